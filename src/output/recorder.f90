!> The observer that writes: curves, pictures, results, restart, log, progress.
!>
!> A run writes into one directory, and no other run at the same time: `run.lock` is locked until it ends,
!> however it ends. What a run of the same directory left is replaced; a run that
!> continues another (restart) keeps what belongs to the steps before and makes the rest again.
!> Every file but `curves.csv` and `job.log`, which grow line by line, appears whole or not at all.
!> The last line of the log is `qsmpm: finished` only when the run did.
!>
!> Each process of a team has a recorder. The first one writes; the others write their rows of pictures, results and
!> restart files where the model is divided (qsmpm_shared_file), and nothing else.
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
  use qsmpm_picture_list, only: picture_list_type, read_collection, write_fields, write_way_of_failure, safety_file, &
    write_safety
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

  !> How a run is recorded.
  type :: recorder_options_type
    !> One of the display_* values of qsmpm_display.
    integer :: display = display_plain
    !> The model's state was read from a restart file.
    logical :: continued = .false.
    !> A phase has begun: the initial stresses are set.
    logical :: begun = .false.
    !> Fingerprint of the resolved deck for restart.h5.
    integer :: fingerprint(2) = 0
    !> Clock of the whole run.
    type(clock_type) :: clock
    !> Columns for the shares of the terms (qsmpm_term_sums); those of the standard terms where it is not set.
    character(len=:), allocatable :: shares
    !> First line of the log: the program and its version.
    character(len=:), allocatable :: banner
    !> The scene that the model answers, where it is a reduced one: results are those of the scene.
    type(whole_scene_type) :: whole
    !> Who shares the run.
    type(team_type) :: team
  end type recorder_options_type

  !> Everything that is open or remembered between two steps.
  type, extends(observer_type) :: recorder_type
    character(len=:), allocatable :: directory
    type(recorder_options_type) :: options
    !> Keeps other runs out of the directory.
    type(folder_lock_type) :: lock
    type(display_type) :: display
    type(file_type) :: curves, log
    type(picture_list_type) :: pictures
    !> Seconds of the runs this one continues.
    type(timing_type) :: earlier
    !> Step of the last picture and of the last restart file of this run, -1 for none.
    integer :: picture_step = -1
    integer :: restart_step = -1
    !> Error of the stresses of a step, and which step that is, -1 for none.
    type(stress_error_type) :: estimate
    integer :: estimate_step = -1
    !> Warnings so far, a line each; repeated at the end of the log.
    character(len=:), allocatable :: warnings
    !> First failure of the log; returned at the next accepted step.
    type(error_type), allocatable :: log_error
    !> Where the time went: the last but one line of the log.
    character(len=:), allocatable :: times
  contains
    procedure :: phase_begun, needs_model, accepted, phase_done, mechanism, note, tell_result, stop_requested
  end type recorder_type

  !> Name of the profile that a run writes on request.
  character(len=*), parameter, public :: profile_file = 'profile.json'
  !> Name of the limit load of a phase that has asked for one.
  character(len=*), parameter :: limit_file = 'limit_load.json'
  character(len=*), parameter :: finished_line = 'qsmpm: finished'
  !> Files of a run beside the numbered ones.
  character(len=*), parameter :: own_files(12) = [character(len=16) :: 'curves.csv', limit_file, safety_file, &
    'points.pvd', 'mesh.pvd', 'results.h5', 'results/mesh.h5', 'restart.h5', 'job.log', timing_file, &
    profile_file, summary_file]

contains

  !> Make the directory and begin its files.
  subroutine create(recorder, model, directory, options, error)
    type(recorder_type), intent(out) :: recorder
    !> The model, its state as read when the run continues another.
    type(model_type), intent(in) :: model
    !> Where everything is written.
    character(len=*), intent(in) :: directory
    !> How.
    type(recorder_options_type), intent(in) :: options
    !> Set when the directory or a file cannot be made.
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

  !> Whether this process writes what there is one of.
  pure logical function leads(recorder)
    class(recorder_type), intent(in) :: recorder

    leads = recorder%options%team%rank == 0
  end function leads

  !> Whether this process writes something of the model: a part of it, or all.
  pure logical function writes(recorder, model)
    class(recorder_type), intent(in) :: recorder
    type(model_type), intent(in) :: model

    writes = leads(recorder) .or. is_divided(model%part)
  end function writes

  !> Remove what was there and begin the files.
  subroutine begin_files(recorder, model, error)
    type(recorder_type), intent(inout) :: recorder
    !> The model, its state as read when the run continues another.
    type(model_type), intent(in) :: model
    !> Set when a file cannot be made.
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
    ! A run from the start has a picture of it, when the initial stresses are set.
    if (.not. allocated(error) .and. recorder%options%begun) call recorder%phase_begun(model, error)
    if (allocated(error)) call write_log(recorder, 'qsmpm: stopped: '//error%message)
  end subroutine begin_files

  !> Open the log: anew, or behind what the continued run wrote.
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

  !> The head of the log: program, deck, what the model builder has to say.
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

  !> Begin or continue the curves and the list of pictures.
  subroutine open_tables(recorder, model, error)
    type(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    !> Set when a file cannot be written.
    type(error_type), allocatable, intent(out) :: error
    logical :: there

    if (leads(recorder)) call open_curves(recorder, model, error)
    call agree(recorder%options%team, error)
    if (allocated(error)) return
    ! The mesh as it was built: a run that is continued has it, and may look at another part of the grid now.
    there = file_exists(recorder%directory//'/'//results_folder//'/mesh.h5')
    there = any_of(recorder%options%team, there .and. leads(recorder) .and. recorder%options%continued)
    if (model%analysis%output%hdf5 .and. .not. there .and. writes(recorder, model)) &
      call write_mesh_results(recorder%directory, model, error)
    call agree(recorder%options%team, error)
  end subroutine open_tables

  !> Begin or continue the curves, and read which pictures there are.
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

  !> Tell by what the model is smaller than the scene.
  subroutine log_savings(recorder, model)
    type(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text

    if (recorder%options%continued) return
    call savings_text(recorder%options%whole, model, text)
    call recorder%note(text)
  end subroutine log_savings

  !> A phase has begun: the picture that a record begins with, where there is none yet.
  subroutine phase_begun(self, model, error)
    class(recorder_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error

    if (self%picture_step >= 0 .or. self%options%continued) return
    self%picture_step = model%state%progress%step
    call write_pictures(self, model, error)
  end subroutine phase_begun

  !> Whether the scene is larger than the model, whose images are made from the whole, or a restart file is due that has
  !> ends of phases.
  logical function needs_model(self, model)
    class(recorder_type), intent(inout) :: self
    type(model_type), intent(in) :: model

    needs_model = is_reduced(self%options%whole)
    if (.not. needs_model .and. writes_kept_phases(model)) needs_model = phase_is_complete(model%state%progress) .or. &
      is_multiple(model%state%progress%step, model%analysis%output%restart_every)
  end function needs_model

  !> A step was accepted: its row, and what is due.
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
      call write_pictures(self, model, error)
      if (allocated(error)) return
      self%picture_step = step
    end if
    if (is_multiple(step, model%analysis%output%restart_every)) then
      call save_restart(self, model, error)
      if (allocated(error)) return
    end if
    if (allocated(self%log_error)) allocate (error, source=self%log_error)
  end subroutine accepted

  !> The row of a step, of the scene where the model is a reduced one.
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

  !> A phase has ended: everything is written that this step has not written already.
  subroutine phase_done(self, model, error)
    class(recorder_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error

    call write_log(self, 'end of phase '//integer_text(model%state%progress%phase)//" '"// &
      model%analysis%phases(model%state%progress%phase)%name//"'")
    call report_stress_error(self, model)
    if (self%picture_step /= model%state%progress%step) call write_pictures(self, model, error)
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

  !> Pictures of the way a body fails, numbered by the phase.
  subroutine mechanism(self, model, error)
    class(recorder_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    !> Set when a file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error

    if (.not. (model%analysis%output%vtk .or. model%analysis%output%hdf5)) return
    self%estimate_step = -1
    call measure(self, model)
    self%estimate_step = -1
    if (is_reduced(self%options%whole)) then
      call show_state(self%options%whole, model)
      call write_way_of_failure(self%directory, self%pictures, self%options%team, self%options%whole%model, &
        estimate_of_scene(self%options%whole, self%estimate), error)
    else
      call write_way_of_failure(self%directory, self%pictures, self%options%team, model, self%estimate, error)
    end if
  end subroutine mechanism

  !> Say how far the stresses can be trusted, and warn where they cannot.
  subroutine report_stress_error(recorder, model)
    class(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text

    call measure(recorder, model)
    call recorder%note(error_line(model, recorder%estimate))
    call error_warning(model, recorder%estimate, text)
    if (len(text) > 0) call recorder%note(text)
  end subroutine report_stress_error

  !> Estimate the error of the stresses unless that is done for this step.
  subroutine measure(recorder, model)
    class(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model

    if (recorder%estimate_step == model%state%progress%step) return
    call estimate_stress_error(model, recorder%estimate)
    recorder%estimate_step = model%state%progress%step
  end subroutine measure

  !> A sentence for the log and for the user.
  subroutine note(self, text)
    class(recorder_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    call write_log(self, without_last_newline(text))
    call show_text(self%display, without_last_newline(text))
    call keep_warnings(text, self%warnings)
  end subroutine note

  !> What a phase was run for.
  subroutine tell_result(self, text)
    class(recorder_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    call write_log(self, text)
    call show_result(self%display, text)
  end subroutine tell_result

  !> Whether a signal has asked the run to stop.
  logical function stop_requested(self)
    class(recorder_type), intent(inout) :: self

    stop_requested = signal_received() /= 0
  end function stop_requested

  !> Number of the signal that has asked the run to stop, 0 for none.
  integer function signal_number()

    signal_number = int(signal_received())
  end function signal_number

  !> End the recording. After a failure or a signal the last accepted state is kept in restart.h5,
  !> after a failure in a picture too; the log says how the run ended.
  subroutine close(recorder, model, error, outcome)
    type(recorder_type), intent(inout) :: recorder
    !> The model, at its last accepted state.
    type(model_type), intent(in) :: model
    !> Set when something could not be written.
    type(error_type), allocatable, intent(out) :: error
    !> What ended the run; not allocated when it finished.
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

  !> The table of phases, and the file too where the run did not finish; a run that could not write has none.
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

  !> Last line of a run that nothing but its files may have stopped.
  pure function last_line(error) result(line)
    !> What could not be written.
    type(error_type), allocatable, intent(in) :: error
    character(len=:), allocatable :: line

    line = finished_line
    if (allocated(error)) line = 'qsmpm: stopped: '//error%message
  end function last_line

  !> Write restart.h5, and unless a signal stopped the run a picture, of the last accepted state.
  subroutine keep_last_state(recorder, model, outcome, by_signal, error)
    type(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    !> What ended the run.
    type(error_type), intent(in) :: outcome
    !> A signal has asked for it.
    logical, intent(in) :: by_signal
    !> Set when something could not be written.
    type(error_type), allocatable, intent(out) :: error

    if (recorder%restart_step /= model%state%progress%step) call save_restart(recorder, model, error)
    ! A disk that took a file no longer takes no picture either; a signal leaves what a run
    ! without the interruption would have left.
    if (allocated(error) .or. outcome%code == error_other) return
    if (by_signal) return
    if (recorder%picture_step /= model%state%progress%step) call write_pictures(recorder, model, error)
  end subroutine keep_last_state

  !> Write the pictures and results of the present step, those of the scene where the model is a
  !> reduced one.
  subroutine write_pictures(recorder, model, error)
    class(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    !> Set when a file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error

    call measure(recorder, model)
    if (is_reduced(recorder%options%whole)) then
      call follow_step(recorder%options%whole, model)
      call show_state(recorder%options%whole, model)
      call write_fields(recorder%directory, recorder%pictures, recorder%options%team, recorder%options%whole%model, &
        estimate_of_scene(recorder%options%whole, recorder%estimate), error)
    else
      call write_fields(recorder%directory, recorder%pictures, recorder%options%team, model, recorder%estimate, error)
    end if
  end subroutine write_pictures

  !> Write restart.h5.
  subroutine save_restart(recorder, model, error)
    class(recorder_type), intent(inout) :: recorder
    type(model_type), intent(in) :: model
    !> Set when the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error

    if (writes(recorder, model)) &
      call write_restart(recorder%directory//'/restart.h5', model, recorder%options%fingerprint, error)
    call agree(recorder%options%team, error)
    if (allocated(error)) return
    recorder%restart_step = model%state%progress%step
    if (leads(recorder)) call write_seconds(recorder, error)
  end subroutine save_restart

  !> Add a line to the log; a failure is kept.
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

  !> Write timing.json: the seconds of this run and those it continues.
  subroutine write_seconds(recorder, error)
    class(recorder_type), intent(in) :: recorder
    !> Set when the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error

    call write_timing(recorder%directory, timing_type(cpu=recorder%earlier%cpu + cpu_seconds(recorder%options%clock), &
      wall=recorder%earlier%wall + wall_seconds(recorder%options%clock)), error)
  end subroutine write_seconds

  !> Whether a step is one of every so many; never when that is 0.
  elemental logical function is_multiple(step, every)
    integer, intent(in) :: step
    !> Every so many steps, 0 for never.
    integer, intent(in) :: every

    is_multiple = .false.
    if (every > 0) is_multiple = mod(step, every) == 0
  end function is_multiple
end module qsmpm_recorder
