!> The recorder: observer that writes curves, pictures, results, restart files, log and progress.
!>
!> A run writes into one directory, to which no other run has access at the same time: `run.lock` is locked until the
!> run ends in any way. Files of an earlier run in the directory are replaced; a run that continues another (restart)
!> retains the results of the steps before and repeats the rest. Every file except `curves.csv` and `job.log`, which
!> grow line by line, is written completely or not at all. The last line of the log is `qsmpm: finished` only if the
!> run finished.
!>
!> Each process of a team has a recorder. The first one writes; the others write only their rows of pictures, results
!> and restart files if the model is divided (qsmpm_shared_file).
module qsmpm_recorder
  use qsmpm_kinds, only: long
  use qsmpm_agreement, only: agree, any_of
  use qsmpm_stopwatch, only: clock_type, cpu_seconds, wall_seconds
  use qsmpm_display, only: display_type, display_none, display_plain, start_display, show_step, show_text, &
    show_result, end_display, step_text, keep_warnings, repeated_warnings
  use qsmpm_error, only: error_type, error_other
  use qsmpm_file, only: file_type, append_file, close_file, file_exists, flush_file, put_text, read_text, write_text
  use qsmpm_folder_lock, only: folder_lock_type, lock_folder, unlock_folder, make_place
  use qsmpm_mesh_description, only: mesh_grid
  use qsmpm_limit_load, only: is_found
  use qsmpm_model, only: model_type
  use qsmpm_model_mesh, only: grid_text, sizes_text
  use qsmpm_number_text, only: integer_text, newline, without_last_newline
  use qsmpm_own_part, only: is_divided
  use qsmpm_observer, only: observer_type, step_record_type
  use qsmpm_picture_list, only: picture_list_type, read_collection, write_fields, safety_file, write_safety
  use qsmpm_posix, only: signal_received
  use qsmpm_restart, only: write_restart, writes_kept_phases
  use qsmpm_step_length, only: phase_is_complete
  use qsmpm_results, only: results_folder, write_mesh_results
  use qsmpm_team, only: team_type
  use qsmpm_profile_report, only: timing_type, timing_file, read_timing, write_timing
  use qsmpm_safety_factors, only: has_factor
  use qsmpm_standard_terms, only: standard_shares
  use qsmpm_summary, only: limit_json, summary_file, summary_table, write_summary, begin_curves, continue_curves, &
    append_row
  use qsmpm_stress_error, only: stress_error_type, estimate_stress_error
  use qsmpm_error_report, only: error_line, error_warning
  use qsmpm_whole_scene, only: whole_scene_type, is_reduced, follow_step, show_state, whole_record, savings_text, &
    estimate_of_scene, scene_of
  implicit none
  private

  public :: recorder_type, recorder_options_type, create, close, signal_number

  !> Options of a recorder.
  type :: recorder_options_type
    !> One of the display_* values of qsmpm_display.
    integer :: display = display_plain
    !> Whether the state of the model was read from a restart file.
    logical :: continued = .false.
    !> Whether a phase has begun: the initial stresses are set.
    logical :: begun = .false.
    !> Fingerprint of the resolved deck for restart.h5.
    integer :: fingerprint(2) = 0
    !> Clock of the complete run.
    type(clock_type) :: clock
    !> Columns for the shares of the terms (qsmpm_term_sums); by default those of the standard terms.
    character(len=:), allocatable :: shares
    !> First line of the log: program name and version.
    character(len=:), allocatable :: banner
    !> The scene represented by a reduced model: results are those of the scene.
    type(whole_scene_type) :: whole
    !> Processes that share the run.
    type(team_type) :: team
  end type recorder_options_type

  !> Open files and data stored between two steps.
  type, extends(observer_type) :: recorder_type
    character(len=:), allocatable :: directory
    type(recorder_options_type) :: options
    !> Locks the directory against other runs.
    type(folder_lock_type) :: lock
    type(display_type) :: display
    type(file_type) :: curves, log
    type(picture_list_type) :: pictures
    !> Run times of the runs that this one continues.
    type(timing_type) :: earlier
    !> Step of the last picture and of the last restart file of this run, -1 for none.
    integer :: picture_step = -1
    integer :: restart_step = -1
    !> Stress error of a step, and number of that step, -1 for none.
    type(stress_error_type) :: estimate
    integer :: estimate_step = -1
    !> Warnings so far, one per line; repeated at the end of the log.
    character(len=:), allocatable :: warnings
    !> First failure to write the log; returned at the next accepted step.
    type(error_type), allocatable :: log_error
    !> Distribution of the run time: the line before the last one of the log.
    character(len=:), allocatable :: times
  contains
    procedure :: phase_begun, needs_model, accepted, phase_done, mechanism, note, tell_result, stop_requested
  end type recorder_type

  !> File name of the profile written on request.
  character(len=*), parameter, public :: profile_file = 'profile.json'
  !> File name of the limit load of a phase for which it is requested.
  character(len=*), parameter :: limit_file = 'limit_load.json'
  character(len=*), parameter :: finished_line = 'qsmpm: finished'
  !> Files of a run other than the numbered ones.
  character(len=*), parameter :: own_files(12) = [character(len=16) :: 'curves.csv', limit_file, safety_file, &
    'points.pvd', 'mesh.pvd', 'results.h5', 'results/mesh.h5', 'restart.h5', 'job.log', timing_file, &
    profile_file, summary_file]

contains

  !> Creates the directory and starts the files.
  subroutine create(recorder, model, directory, options, error)
    type(recorder_type), intent(out) :: recorder
    !> The model, with the state read from a restart file if the run continues another.
    type(model_type), intent(in) :: model
    !> Output directory.
    character(len=*), intent(in) :: directory
    !> Options of the recorder.
    type(recorder_options_type), intent(in) :: options
    !> Set when the directory or a file cannot be created.
    type(error_type), allocatable, intent(out) :: error

    recorder%directory = directory
    recorder%options = options
    if (.not. allocated(options%shares)) recorder%options%shares = standard_shares()
    if (leads(recorder)) then
      call lock_folder(recorder%lock, directory, error)
    else
      recorder%options%display = display_none
    end if
    call agree(options%team, error)
    if (.not. allocated(error)) call begin_files(recorder, model, error)
    if (allocated(error)) call unlock_folder(recorder%lock)
  end subroutine create

  !> Returns whether this process writes the files that exist once.
  pure logical function leads(recorder)
    class(recorder_type), intent(in) :: recorder

    leads = recorder%options%team%rank == 0
  end function leads

  !> Returns whether this process writes data of the model: a part of it, or all.
  pure logical function writes(recorder, model)
    class(recorder_type), intent(in) :: recorder
    type(model_type), intent(in) :: model

    writes = leads(recorder) .or. is_divided(model%part)
  end function writes

  !> Removes earlier files and starts the files of this run.
  subroutine begin_files(recorder, model, error)
    type(recorder_type), intent(inout) :: recorder
    !> The model, with the state read from a restart file if the run continues another.
    type(model_type), intent(in) :: model
    !> Set when a file cannot be created.
    type(error_type), allocatable, intent(out) :: error

    if (leads(recorder)) call make_place(recorder%directory, own_files, recorder%options%continued, &
      model%analysis%output%hdf5, error)
    if (recorder%options%continued) call read_timing(recorder%directory, recorder%earlier)
    call agree(recorder%options%team, error)
    if (allocated(error)) return
    call start_display(recorder%display, recorder%options%display, model)
    if (leads(recorder)) call open_log(recorder, error)
    call agree(recorder%options%team, error)
    if (allocated(error)) return
    call begin_log(recorder, model)
    if (is_reduced(recorder%options%whole)) then
      call log_savings(recorder, model)
      call follow_step(recorder%options%whole, model)
      call open_tables(recorder, recorder%options%whole%model, error)
    else
      call open_tables(recorder, model, error)
    end if
    ! A run from the start writes a picture of it when the initial stresses are set.
    if (.not. allocated(error) .and. recorder%options%begun) call recorder%phase_begun(model, error)
    if (allocated(error)) call write_log(recorder, 'qsmpm: stopped: '//error%message)
  end subroutine begin_files

  !> Opens a new log, or the log of the continued run for appending.
  subroutine open_log(recorder, error)
    type(recorder_type), intent(inout) :: recorder
    !> Set when it cannot be written.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: path, text

    path = recorder%directory//'/job.log'
    text = ''
    if (recorder%options%continued) then
      if (file_exists(path)) call read_text(path, text, error)
      if (allocated(error)) return
    end if
    call append_file(recorder%log, path, len(text, kind=long), error)
  end subroutine open_log

  !> Writes the head of the log: program, deck, messages of the model builder.
  subroutine begin_log(recorder, model)
    type(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model

    if (allocated(recorder%options%banner)) call write_log(recorder, recorder%options%banner)
    if (allocated(model%analysis%deck)) call write_log(recorder, 'deck '//model%analysis%deck)
    call write_log(recorder, sizes_text(model))
    if (model%analysis%mesh%kind == mesh_grid) call write_log(recorder, grid_text(model))
    if (recorder%options%continued) then
      call recorder%note('continued from step '//integer_text(model%state%progress%step))
    else if (allocated(model%notes)) then
      if (len(model%notes) > 0) call recorder%note(model%notes)
    end if
  end subroutine begin_log

  !> Starts or continues the curves and the list of pictures.
  subroutine open_tables(recorder, model, error)
    type(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    !> Set when a file cannot be written.
    type(error_type), allocatable, intent(out) :: error
    logical :: there

    if (leads(recorder)) call open_curves(recorder, model, error)
    call agree(recorder%options%team, error)
    if (allocated(error)) return
    ! The mesh as built: a continued run has this file already, and its mesh may now cover another part of the grid.
    there = file_exists(recorder%directory//'/'//results_folder//'/mesh.h5')
    there = any_of(recorder%options%team, there .and. leads(recorder) .and. recorder%options%continued)
    if (model%analysis%output%hdf5 .and. .not. there .and. writes(recorder, model)) &
      call write_mesh_results(recorder%directory, model, error)
    call agree(recorder%options%team, error)
  end subroutine open_tables

  !> Starts or continues the curves and reads the list of existing pictures.
  subroutine open_curves(recorder, model, error)
    type(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    !> Set when a file cannot be written.
    type(error_type), allocatable, intent(out) :: error

    if (recorder%options%continued) then
      call continue_curves(recorder%curves, recorder%directory, model%analysis, recorder%options%shares, &
        model%state%progress%step, error)
      if (allocated(error)) return
      if (file_exists(recorder%directory//'/points.pvd')) then
        call read_collection(recorder%pictures, recorder%directory, model%state%progress%step, error)
      end if
    else
      call begin_curves(recorder%curves, recorder%directory, model%analysis, recorder%options%shares, error)
    end if
  end subroutine open_curves

  !> Reports by how much the model is smaller than the scene.
  subroutine log_savings(recorder, model)
    type(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text

    if (recorder%options%continued) return
    call savings_text(recorder%options%whole, model, text)
    call recorder%note(text)
  end subroutine log_savings

  !> Writes the first picture of a record at the start of a phase, unless there is one.
  subroutine phase_begun(self, model, error)
    class(recorder_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error

    if (self%picture_step >= 0 .or. self%options%continued) return
    self%picture_step = model%state%progress%step
    call write_pictures(self, model, .false., error)
  end subroutine phase_begun

  !> Returns whether the whole model is required: results of a scene larger than the model are derived from it, or a
  !> restart file with ends of phases is due.
  logical function needs_model(self, model)
    class(recorder_type), intent(inout) :: self
    type(model_type), intent(in) :: model

    needs_model = is_reduced(self%options%whole)
    if (.not. needs_model .and. writes_kept_phases(model)) needs_model = phase_is_complete(model%state%progress) .or. &
      is_multiple(model%state%progress%step, model%analysis%output%restart_every)
  end function needs_model

  !> Writes the row of an accepted step and all files that are due.
  subroutine accepted(self, model, record, error)
    class(recorder_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(step_record_type), intent(in) :: record
    type(error_type), allocatable, intent(out) :: error
    integer :: step

    step = model%state%progress%step
    if (leads(self)) call write_row(self, model, record, error)
    call agree(self%options%team, error)
    if (allocated(error)) return
    call write_log(self, step_text(model, record)//', '//integer_text(record%equations)// &
      ' equations, '//integer_text(record%reequilibrations)//' re-equilibrations, '//integer_text(record%substeps)// &
      ' sub-steps, '//integer_text(record%rejected)//' rejected')
    call show_step(self%display, model, record)
    if (is_multiple(step, model%analysis%output%field_every)) then
      call write_pictures(self, model, .false., error)
      if (allocated(error)) return
      self%picture_step = step
    end if
    if (is_multiple(step, model%analysis%output%restart_every)) then
      call save_restart(self, model, error)
      if (allocated(error)) return
    end if
    if (allocated(self%log_error)) allocate (error, source=self%log_error)
  end subroutine accepted

  !> Writes the row of a step; for a reduced model that of the scene.
  subroutine write_row(recorder, model, record, error)
    class(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    type(step_record_type), intent(in) :: record
    !> Set when the row could not be written.
    type(error_type), allocatable, intent(out) :: error
    type(step_record_type) :: shown

    if (is_reduced(recorder%options%whole)) then
      call follow_step(recorder%options%whole, model)
      call whole_record(recorder%options%whole, record, shown)
      call append_row(recorder%curves, recorder%options%whole%model, shown, error)
    else
      call append_row(recorder%curves, model, record, error)
    end if
  end subroutine write_row

  !> Writes all files at the end of a phase that have not been written for this step.
  subroutine phase_done(self, model, error)
    class(recorder_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error

    call write_log(self, 'end of phase '//integer_text(model%state%progress%phase)//" '"// &
      model%analysis%phases(model%state%progress%phase)%name//"'")
    call report_stress_error(self, model)
    if (self%picture_step /= model%state%progress%step) call write_pictures(self, model, .false., error)
    if (allocated(error)) return
    call save_restart(self, model, error)
    if (.not. leads(self)) return
    if (.not. allocated(error) .and. is_found(model%state%progress%limit)) &
      call write_text(self%directory//'/'//limit_file, limit_json(model), error)
    if (.not. allocated(error) .and. has_factor(model%state%progress)) call write_safety(self%directory, model, error)
    if (.not. allocated(error)) call write_summary(self%directory, scene_of(self%options%whole, model), model, error)
    if (allocated(error)) return
    if (allocated(self%log_error)) allocate (error, source=self%log_error)
  end subroutine phase_done

  !> Writes pictures of the failure mechanism, numbered by the phase.
  subroutine mechanism(self, model, error)
    class(recorder_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    !> Set when a file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error

    if (.not. (model%analysis%output%vtk .or. model%analysis%output%hdf5)) return
    self%estimate_step = -1
    call write_pictures(self, model, .true., error)
    self%estimate_step = -1
  end subroutine mechanism

  !> Reports the accuracy of the stresses and warns if it is insufficient.
  subroutine report_stress_error(recorder, model)
    class(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text

    call measure(recorder, model)
    call recorder%note(error_line(model, recorder%estimate))
    call error_warning(model, recorder%estimate, text)
    if (len(text) > 0) call recorder%note(text)
  end subroutine report_stress_error

  !> Estimates the stress error unless this has been done for the step.
  subroutine measure(recorder, model)
    class(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model

    if (recorder%estimate_step == model%state%progress%step) return
    call estimate_stress_error(model, recorder%estimate)
    recorder%estimate_step = model%state%progress%step
  end subroutine measure

  !> Writes a message to the log and to the display.
  subroutine note(self, text)
    class(recorder_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    call write_log(self, without_last_newline(text))
    call show_text(self%display, without_last_newline(text))
    call keep_warnings(text, self%warnings)
  end subroutine note

  !> Writes the result of a phase.
  subroutine tell_result(self, text)
    class(recorder_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    call write_log(self, text)
    call show_result(self%display, text)
  end subroutine tell_result

  !> Returns whether a signal has requested a stop.
  logical function stop_requested(self)
    class(recorder_type), intent(inout) :: self

    stop_requested = signal_received() /= 0
  end function stop_requested

  !> Returns the number of the signal that requested a stop, 0 for none.
  integer function signal_number()

    signal_number = int(signal_received())
  end function signal_number

  !> Ends the recording. After a failure or a signal the last accepted state is written to restart.h5, after a failure
  !> also a picture; the log reports how the run ended.
  subroutine close(recorder, model, error, outcome)
    type(recorder_type), intent(inout) :: recorder
    !> The model at its last accepted state.
    type(model_type), intent(in) :: model
    !> Set when a file could not be written.
    type(error_type), allocatable, intent(out) :: error
    !> Error that ended the run; unallocated if it finished.
    type(error_type), allocatable, intent(in) :: outcome
    type(error_type), allocatable :: log_error
    character(len=:), allocatable :: said
    logical :: by_signal

    by_signal = any_of(recorder%options%team, signal_received() /= 0)
    if (leads(recorder)) call log_summary(recorder, model, outcome)
    if (allocated(recorder%times)) call write_log(recorder, recorder%times)
    said = repeated_warnings(recorder%warnings)
    if (len(said) > 0) call write_log(recorder, without_last_newline(said))
    if (.not. allocated(outcome)) then
      call recorder%phase_begun(model, error)
    else
      call keep_last_state(recorder, model, outcome, by_signal, error)
      if (.not. by_signal) call report_stress_error(recorder, model)
      call write_log(recorder, 'qsmpm: stopped: '//outcome%message)
      if (allocated(error)) call write_log(recorder, 'qsmpm: '//error%message)
    end if
    if (.not. allocated(error) .and. leads(recorder)) call write_seconds(recorder, error)
    call close_file(recorder%curves, log_error)
    if (allocated(log_error) .and. .not. allocated(error)) call move_alloc(log_error, error)
    if (allocated(recorder%log_error) .and. .not. allocated(error)) allocate (error, source=recorder%log_error)
    if (.not. allocated(outcome)) call write_log(recorder, last_line(error))
    call close_file(recorder%log, log_error)
    if (allocated(log_error) .and. .not. allocated(error)) call move_alloc(log_error, error)
    call unlock_folder(recorder%lock)
    if (.not. allocated(outcome)) call show_text(recorder%display, last_line(error))
    call end_display(recorder%display)
  end subroutine close

  !> Writes the table of phases to the log, and the summary file if the run did not finish; not after a write error.
  subroutine log_summary(recorder, model, outcome)
    type(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(in) :: outcome
    type(error_type), allocatable :: error
    character(len=:), allocatable :: text

    call summary_table(recorder%directory, scene_of(recorder%options%whole, model), model, text, error, outcome)
    if (.not. allocated(error)) call write_log(recorder, text)
    if (.not. allocated(outcome)) return
    call write_summary(recorder%directory, scene_of(recorder%options%whole, model), model, error, outcome)
  end subroutine log_summary

  !> Returns the last line of the log of a run that was stopped by nothing except its files.
  pure function last_line(error) result(line)
    !> Error of writing a file.
    type(error_type), allocatable, intent(in) :: error
    character(len=:), allocatable :: line

    line = finished_line
    if (allocated(error)) line = 'qsmpm: stopped: '//error%message
  end function last_line

  !> Writes restart.h5 and, unless a signal stopped the run, a picture of the last accepted state.
  subroutine keep_last_state(recorder, model, outcome, by_signal, error)
    type(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    !> Error that ended the run.
    type(error_type), intent(in) :: outcome
    !> Whether the stop was requested by a signal.
    logical, intent(in) :: by_signal
    !> Set when a file could not be written.
    type(error_type), allocatable, intent(out) :: error

    if (recorder%restart_step /= model%state%progress%step) call save_restart(recorder, model, error)
    ! A disk on which writing a file has failed accepts no picture either; after a signal the files are those of a run
    ! without the interruption.
    if (allocated(error) .or. outcome%code == error_other) return
    if (by_signal) return
    if (recorder%picture_step /= model%state%progress%step) call write_pictures(recorder, model, .false., error)
  end subroutine keep_last_state

  !> Writes the pictures and results of the current step, or of a failure mechanism; for a reduced model those of the
  !> scene.
  subroutine write_pictures(recorder, model, of_mechanism, error)
    class(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    logical, intent(in) :: of_mechanism
    !> Set when a file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error

    call measure(recorder, model)
    if (is_reduced(recorder%options%whole)) then
      if (.not. of_mechanism) call follow_step(recorder%options%whole, model)
      call show_state(recorder%options%whole, model)
      call write_fields(recorder%directory, recorder%pictures, recorder%options%team, recorder%options%whole%model, &
        estimate_of_scene(recorder%options%whole, recorder%estimate), of_mechanism, error)
    else
      call write_fields(recorder%directory, recorder%pictures, recorder%options%team, model, recorder%estimate, &
        of_mechanism, error)
    end if
  end subroutine write_pictures

  !> Writes restart.h5.
  subroutine save_restart(recorder, model, error)
    class(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    !> Set when the file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error

    if (writes(recorder, model)) &
      call write_restart(recorder%directory//'/restart.h5', model, recorder%options%fingerprint, error)
    call agree(recorder%options%team, error)
    if (allocated(error)) return
    recorder%restart_step = model%state%progress%step
    if (leads(recorder)) call write_seconds(recorder, error)
  end subroutine save_restart

  !> Appends a line to the log; a failure is stored.
  subroutine write_log(recorder, text)
    class(recorder_type), intent(inout) :: recorder
    !> The line.
    character(len=*), intent(in) :: text
    type(error_type), allocatable :: error

    if (allocated(recorder%log_error) .or. .not. leads(recorder)) return
    call put_text(recorder%log, text//newline)
    call flush_file(recorder%log, error)
    if (allocated(error)) call move_alloc(error, recorder%log_error)
  end subroutine write_log

  !> Writes timing.json: the run times of this run and of those it continues.
  subroutine write_seconds(recorder, error)
    class(recorder_type), intent(in) :: recorder
    !> Set when the file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error

    call write_timing(recorder%directory, timing_type(cpu=recorder%earlier%cpu + cpu_seconds(recorder%options%clock), &
      wall=recorder%earlier%wall + wall_seconds(recorder%options%clock)), error)
  end subroutine write_seconds

  !> Returns whether a step is a multiple of an interval; false if the interval is 0.
  elemental logical function is_multiple(step, every)
    integer, intent(in) :: step
    !> Interval in steps, 0 for never.
    integer, intent(in) :: every

    is_multiple = .false.
    if (every > 0) is_multiple = mod(step, every) == 0
  end function is_multiple
end module qsmpm_recorder
