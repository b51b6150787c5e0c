!> An analysis controlled by a program: created, stepped, written, saved and restored. All data are components of the
!> object, so that several analyses can exist and be stepped alternately in one process; each gives results identical
!> to those of a separate run.
!>
!> Observers are arguments of the calls that step. Changes of loads are implemented in `qsmpm_simulation`.
module qsmpm_stepped_analysis
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_phase_description, only: phase_type, phase_safety
  use qsmpm_observer_list, only: observer_list_type
  use qsmpm_blas_threads, only: reserve_buffers
  use qsmpm_deck, only: echo_text
  use qsmpm_display, only: display_none
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_file, only: write_text
  use qsmpm_initialisation, only: add_term
  use qsmpm_law, only: law_slot_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_number_text, only: without_last_newline
  use qsmpm_observer, only: observer_type, silent_observer_type, step_record_type
  use qsmpm_phases, only: step_loop_type, begin_step_loop, advance_step_loop, end_step_loop, is_finished, &
    leave_lost_phase
  use qsmpm_plugin, only: guard_exit
  use qsmpm_point, only: refuse_point
  use qsmpm_problem, only: problem_type, own_laws, mark_own
  use qsmpm_program_name, only: settings_type, enter_library, leave_library, check_threads, program_name
  use qsmpm_recorder, only: recorder_type, recorder_options_type, create_recorder => create, close
  use qsmpm_reduction, only: expansion_type, reduction_check_type
  use qsmpm_restart, only: read_restart, write_restart, text_fingerprint
  use qsmpm_run_profile, only: run_profile_type
  use qsmpm_scene, only: reduce_scene
  use qsmpm_snapshot, only: snapshot_type, take_snapshot, restore_checkpoint, copy_phases
  use qsmpm_stages, only: take_over_stages, added_lines_type, name_added_lines, read_added_cards, drop_materials, &
    extend_model
  use qsmpm_step_length, only: phase_is_complete
  use qsmpm_stopwatch, only: clock_type, switch_timer, part_output, part_control
  use qsmpm_team, only: team_type
  use qsmpm_term, only: term_type
  use qsmpm_term_sums, only: share_names
  use qsmpm_whole_scene, only: begin_whole, is_reduced
  implicit none
  private

  public :: stepped_analysis_type, need_model

  !> Load fractions of a stage that differ by less are equal.
  real(wp), parameter :: closeness = 1.0e-9_wp

  !> An analysis controlled by a program.
  type :: stepped_analysis_type
    !> The scene as defined, with the stages added since.
    type(analysis_type) :: scene
    !> The model: mesh, material points, loads; for reading only, changed by the procedures below. It is allocated
    !> while the analysis is ready; as a class, it and the recorder are copied and deallocated by one call
    !> (qsmpm_model).
    class(model_type), allocatable :: model
    !> Number of threads; the results do not depend on it.
    integer :: threads = 1
    !> Record of the last accepted step.
    type(step_record_type) :: last
    !> Whether there is a model.
    logical :: ready = .false.
    !> Results of the checks of possible reductions of the scene.
    type(reduction_check_type), allocatable :: checks(:)
    !> Recorder of the results, while they are written.
    class(recorder_type), allocatable :: recorder
    !> Time and work so far.
    type(step_loop_type) :: loop
    type(expansion_type), private :: expansion
    type(phase_type), allocatable, private :: adopted(:)
    !> User-defined laws (materials of the deck).
    type(law_slot_type), allocatable, private :: own(:)
    type(clock_type), private :: clock
    !> Messages of the deck reader.
    character(len=:), allocatable :: messages
    !> Error that ended the last step.
    type(error_type), allocatable :: outcome
  contains
    procedure :: create
    procedure :: destroy
    procedure, private :: advance_alone, advance_observed
    !> Computes one accepted load step.
    generic :: advance => advance_alone, advance_observed
    procedure, private :: advance_to_alone, advance_to_observed
    !> Steps to a load fraction of the current or next stage.
    generic :: advance_to => advance_to_alone, advance_to_observed
    procedure, private :: run_alone, run_observed
    !> Steps to the end of the last stage.
    generic :: run => run_alone, run_observed
    procedure :: finished, add_term => add_own_term, record, finish_record, save => save_state, load => load_state, &
      checkpoint, restore_checkpoint => restore_kept, take_over, add_cards
  end type stepped_analysis_type

contains

  !> Generates the mesh and the material points and prepares the analysis for stepping.
  subroutine create(self, problem, error, team)
    !> The analysis; a previous one is discarded.
    class(stepped_analysis_type), intent(inout) :: self
    type(problem_type), intent(in) :: problem
    !> Set when the deck or a user-defined material has errors.
    type(error_type), allocatable, intent(out) :: error
    !> Processes that share the model; by default this process alone.
    type(team_type), intent(in), optional :: team
    class(analysis_type), allocatable :: analysis
    type(team_type) :: sharing
    type(settings_type) :: settings
    type(law_slot_type), allocatable :: laws(:)
    type(run_profile_type) :: profile

    call self%destroy()
    if (.not. problem%given) then
      call fail(error, error_other, 'there is no problem: read a deck first')
      return
    end if
    call refuse_point(problem%scene, error)
    if (.not. allocated(error)) call check_threads(self%threads, error)
    if (.not. allocated(error)) call reserve_buffers(self%threads, error)
    if (allocated(error)) return
    call enter_library(self%threads, settings)
    self%clock = problem%clock
    profile%watch = problem%watch
    self%messages = problem%messages
    self%scene = problem%scene
    call mark_own(problem%materials, self%scene)
    allocate (analysis)
    if (.not. allocated(self%model)) allocate (self%model)
    call reduce_scene(self%scene, analysis, self%expansion, self%checks)
    call own_laws(problem%materials, analysis, laws, error)
    ! The results of a scene that is larger than its model are computed from the whole model.
    if (present(team) .and. size(self%expansion%steps) == 0) sharing = team
    if (.not. allocated(error)) call build_model(analysis, self%model, error, laws, sharing)
    if (allocated(laws)) call move_alloc(laws, self%own)
    if (.not. allocated(error)) then
      self%scene%method = self%model%analysis%method
      self%scene%materials = self%model%analysis%materials
      call copy_phases(self%scene%phases, self%adopted)
      call begin_step_loop(self%model, profile, self%loop)
      self%ready = .true.
    end if
    call leave_library(settings)
  end subroutine create

  !> Deallocates all data and closes the result files. Call finish_record before to receive errors of closing.
  subroutine destroy(self)
    class(stepped_analysis_type), intent(inout) :: self
    type(error_type), allocatable :: error
    type(run_profile_type) :: profile

    if (.not. self%ready) return
    call self%finish_record(error)
    call end_step_loop(self%loop, profile)
    deallocate (self%model)
    call clear(self%loop)
    self%ready = .false.
    if (allocated(self%outcome)) deallocate (self%outcome)
  end subroutine destroy

  !> Resets the step loop.
  subroutine clear(loop)
    type(step_loop_type), intent(out) :: loop
  end subroutine clear

  !> Checks that there is a model.
  subroutine need_model(self, error)
    class(stepped_analysis_type), intent(in) :: self
    !> Set when there is none.
    type(error_type), allocatable, intent(out) :: error

    if (.not. self%ready) call fail(error, error_other, 'there is no model: create it first')
  end subroutine need_model

  !> Returns whether the last stage has ended.
  pure logical function finished(self)
    class(stepped_analysis_type), intent(in) :: self

    finished = .false.
    if (self%ready) finished = is_finished(self%model, self%loop)
  end function finished

  !> Computes one accepted load step.
  subroutine advance_alone(self, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Set when no step is accepted; the state is then that of the last accepted step.
    type(error_type), allocatable, intent(out) :: error
    type(silent_observer_type) :: silent

    call self%advance(silent, error)
  end subroutine advance_alone

  !> Computes one accepted load step with an observer.
  subroutine advance_observed(self, observer, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Observer supplied by the program.
    class(observer_type), intent(inout) :: observer
    !> Set when no step is accepted; the state is then that of the last accepted step.
    type(error_type), allocatable, intent(out) :: error

    call step_on(self, 1.0_wp, observer, error)
  end subroutine advance_observed

  !> Steps to a load fraction of the current stage, or of the next stage when between stages.
  subroutine advance_to_alone(self, share, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Load fraction to reach, greater than the current one and at most 1.
    real(wp), intent(in) :: share
    !> Set when it is not reached; the state is then that of the last accepted step.
    type(error_type), allocatable, intent(out) :: error
    type(silent_observer_type) :: silent

    call self%advance_to(share, silent, error)
  end subroutine advance_to_alone

  !> Steps to the end of the last stage.
  subroutine run_alone(self, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Set when it is not reached; the state is then that of the last accepted step.
    type(error_type), allocatable, intent(out) :: error
    type(silent_observer_type) :: silent

    call self%run(silent, error)
  end subroutine run_alone

  !> Steps to the end of the last stage with an observer; skips failed stages and those that start from them.
  subroutine run_observed(self, observer, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Observer supplied by the program.
    class(observer_type), intent(inout) :: observer
    !> Set when the end is not reached, or names the stages that failed; the state is then that of the last accepted
    !> step.
    type(error_type), allocatable, intent(out) :: error

    call need_model(self, error)
    do while (.not. (allocated(error) .or. self%finished()))
      call step_on(self, 1.0_wp, observer, error, leaves_lost=.true.)
    end do
  end subroutine run_observed

  !> Steps to a load fraction of a stage with an observer.
  subroutine advance_to_observed(self, share, observer, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Load fraction to reach, greater than the current one and at most 1.
    real(wp), intent(in) :: share
    !> Observer supplied by the program.
    class(observer_type), intent(inout) :: observer
    !> Set when it is not reached; the state is then that of the last accepted step.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: done

    call need_model(self, error)
    if (allocated(error)) return
    done = self%model%state%progress%fraction
    if (phase_is_complete(self%model%state%progress)) done = 0.0_wp
    if (.not. (share > done + closeness .and. share <= 1.0_wp)) then
      call fail(error, error_other, 'the share of the stage to reach is not above the present one, to 1')
      return
    end if
    do
      call step_on(self, share, observer, error)
      if (allocated(error) .or. self%model%state%progress%fraction >= share - closeness) exit
    end do
  end subroutine advance_to_observed

  !> Computes one accepted step up to at most a load fraction of its stage.
  subroutine step_on(self, limit, observer, error, leaves_lost)
    class(stepped_analysis_type), intent(inout), target :: self
    !> Load fraction of the stage.
    real(wp), intent(in) :: limit
    !> Observer supplied by the program.
    class(observer_type), intent(inout), target :: observer
    !> Set when no step is accepted.
    type(error_type), allocatable, intent(out) :: error
    !> Whether to continue without a failed stage.
    logical, intent(in), optional :: leaves_lost
    type(observer_list_type) :: observers
    type(settings_type) :: settings

    call need_model(self, error)
    if (.not. allocated(error) .and. self%finished()) &
      call fail(error, error_other, 'the analysis is finished: no stage is to come')
    if (allocated(error)) return
    if (allocated(self%recorder)) observers%recorder => self%recorder
    observers%own => observer
    call enter_library(self%threads, settings)
    self%loop%limit = limit
    call advance_step_loop(self%model, self%loop, observers, error)
    if (present(leaves_lost) .and. allocated(error)) call leave_lost_phase(self%model, self%loop, observers, error)
    call leave_library(settings)
    self%last = observers%last
    if (allocated(self%outcome)) deallocate (self%outcome)
    if (allocated(error)) allocate (self%outcome, source=error)
  end subroutine step_on

  !> Adds a user-defined term to the equations, before the first step and before results are written.
  subroutine add_own_term(self, term, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> The term; a copy is stored.
    class(term_type), intent(in) :: term
    !> Set when steps have been made or results are being written.
    type(error_type), allocatable, intent(out) :: error

    call need_model(self, error)
    if (allocated(error)) return
    if (self%model%state%progress%step > 0 .or. allocated(self%recorder)) then
      call fail(error, error_other, 'a term is added before the first step, and before results are written')
      return
    end if
    call add_term(self%model, self%loop%step%terms, term)
  end subroutine add_own_term

  !> Starts to write the results that a run of the command line writes.
  subroutine record(self, directory, error, display, continued)
    class(stepped_analysis_type), intent(inout) :: self
    !> Directory, created if it does not exist; results of an earlier run are replaced.
    character(len=*), intent(in) :: directory
    !> Set when a file cannot be written.
    type(error_type), allocatable, intent(out) :: error
    !> One of the display_* values of qsmpm_display; by default nothing is displayed.
    integer, intent(in), optional :: display
    !> Whether the state was loaded and the directory contains the results up to it.
    logical, intent(in), optional :: continued
    class(recorder_options_type), allocatable :: options
    character(len=:), allocatable :: echo

    call need_model(self, error)
    if (.not. allocated(error) .and. allocated(self%recorder)) &
      call fail(error, error_other, 'results are already written to '//self%recorder%directory)
    if (allocated(error)) return
    allocate (options)
    options%display = display_none
    if (present(display)) options%display = display
    if (present(continued)) options%continued = continued
    options%begun = self%loop%begun .or. self%model%state%progress%step > 0
    options%clock = self%clock
    options%banner = program_name()
    options%team = self%loop%team
    call echo_text(self%scene, echo)
    options%fingerprint = text_fingerprint(echo)
    options%shares = share_names(self%loop%step%terms)
    call begin_whole(options%whole, self%scene, self%expansion, self%model, error)
    if (allocated(error)) return
    call switch_timer(self%loop%step%profile%watch, part_output)
    allocate (self%recorder)
    call create_recorder(self%recorder, self%model, directory, options, error)
    if (allocated(error)) then
      deallocate (self%recorder)
    else
      if (len(self%messages) > 0) call self%recorder%note(without_last_newline(self%messages))
      if (self%loop%team%rank == 0) call write_text(directory//'/'//self%model%analysis%job//'.echo.inp', echo, error)
      ! If a model in a library ends the process, this happens before these files are closed.
      if (self%loop%team%rank == 0) call guard_exit()
    end if
    call switch_timer(self%loop%step%profile%watch, part_control)
  end subroutine record

  !> Closes the result files; the log reports how the last step ended.
  subroutine finish_record(self, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Set when a file could not be written.
    type(error_type), allocatable, intent(out) :: error

    if (.not. allocated(self%recorder)) return
    call close(self%recorder, self%model, error, self%outcome)
    deallocate (self%recorder)
  end subroutine finish_record

  !> Writes the complete state to a file.
  subroutine save_state(self, path, error)
    class(stepped_analysis_type), intent(in) :: self
    !> Name of the file.
    character(len=*), intent(in) :: path
    !> Set when the file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: echo

    call need_model(self, error)
    if (allocated(error)) return
    call echo_text(self%scene, echo)
    call write_restart(path, self%model, text_fingerprint(echo), error)
  end subroutine save_state

  !> Reads a state that was saved with the same stages.
  subroutine load_state(self, path, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Name of the file.
    character(len=*), intent(in) :: path
    !> Set when the file is damaged or belongs to another deck; the state is then unchanged.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: echo

    call need_model(self, error)
    if (allocated(error)) return
    call echo_text(self%scene, echo)
    call read_restart(path, self%model, text_fingerprint(echo), error, self%loop%team)
    if (allocated(error)) return
    self%loop%begun = .false.
    self%loop%end_notified = .false.
  end subroutine load_state

  !> Stores a copy of state, loads and stages.
  subroutine checkpoint(self, snapshot, error)
    class(stepped_analysis_type), intent(in) :: self
    type(snapshot_type), intent(out) :: snapshot
    !> Set when there is no model.
    type(error_type), allocatable, intent(out) :: error

    call need_model(self, error)
    if (.not. allocated(error)) call take_snapshot(self%model, self%scene%phases, self%loop, snapshot)
  end subroutine checkpoint

  !> Restores a copy of this analysis.
  subroutine restore_kept(self, snapshot, error)
    class(stepped_analysis_type), intent(inout) :: self
    type(snapshot_type), intent(in) :: snapshot
    !> Set when there is no copy or no model.
    type(error_type), allocatable, intent(out) :: error

    call need_model(self, error)
    if (.not. allocated(error) .and. .not. snapshot%taken) call fail(error, error_other, 'no state has been kept')
    if (allocated(error)) return
    call restore_checkpoint(snapshot, self%model, self%scene%phases, self%loop)
    call drop_materials(snapshot%materials, self%scene, self%model)
    call copy_phases(self%scene%phases, self%adopted)
    if (allocated(self%outcome)) deallocate (self%outcome)
    call report_recorder(self, error)
  end subroutine restore_kept

  !> Takes over changes of the stages in `scene`; stages that have begun must not change. Restores the scene on error.
  subroutine take_over(self, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Set when the model is not valid for the changed stages.
    type(error_type), allocatable, intent(out) :: error

    call need_model(self, error)
    if (allocated(error)) return
    call take_over_stages(self%scene, self%expansion, self%model, error)
    if (allocated(error)) then
      call copy_phases(self%adopted, self%scene%phases)
      return
    end if
    call copy_phases(self%scene%phases, self%adopted)
    call report_recorder(self, error)
  end subroutine take_over

  !> Adds materials and phases, given as deck keywords, to the scene and to the model in progress.
  subroutine add_cards(self, cards, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Lines of a deck: *MATERIAL and *PHASE blocks.
    character(len=*), intent(in) :: cards
    !> Set when the keywords have errors or the model cannot be extended; the model is then unchanged.
    type(error_type), allocatable, intent(out) :: error
    class(analysis_type), allocatable :: extended
    type(added_lines_type) :: lines
    character(len=:), allocatable :: warnings

    call need_model(self, error)
    allocate (extended)
    if (.not. allocated(error)) call read_added_cards(self%scene, cards, extended, lines, warnings, error)
    if (.not. allocated(error)) call need_no_column(self, extended, error)
    if (allocated(error)) return
    call extend_model(extended, self%expansion, self%own, self%loop%begun .and. self%loop%end_notified, self%model, &
      error)
    if (allocated(error)) then
      error%message = without_last_newline(name_added_lines(error%message//new_line('a'), lines))
      return
    end if
    self%messages = self%messages//warnings
    self%scene = extended
    self%scene%materials = self%model%analysis%materials
    call copy_phases(self%scene%phases, self%adopted)
    call report_recorder(self, error)
  end subroutine add_cards

  !> Checks that the result files have the columns for new materials and phases.
  subroutine need_no_column(self, extended, error)
    class(stepped_analysis_type), intent(in) :: self
    type(analysis_type), intent(in) :: extended
    !> Set when curves.csv lacks the column of the factor, or when a reduced scene has another material.
    type(error_type), allocatable, intent(out) :: error

    if (.not. allocated(self%recorder)) return
    if (any(extended%phases%kind == phase_safety) .and. .not. any(self%scene%phases%kind == phase_safety)) then
      call fail(error, error_other, 'the first safety phase is added before results are written: curves.csv has a '// &
        'column for its factor')
    else if (size(extended%materials) > size(self%scene%materials) .and. is_reduced(self%recorder%options%whole)) then
      call fail(error, error_other, 'materials are added to a reduced scene before results are written')
    end if
  end subroutine need_no_column

  !> Updates the recorder after a change of the stages.
  subroutine report_recorder(self, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Set when the resolved deck cannot be written.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: echo

    if (.not. allocated(self%recorder)) return
    call echo_text(self%scene, echo)
    self%recorder%options%fingerprint = text_fingerprint(echo)
    if (is_reduced(self%recorder%options%whole)) &
      call copy_phases(self%scene%phases, self%recorder%options%whole%model%analysis%phases)
    call write_text(self%recorder%directory//'/'//self%model%analysis%job//'.echo.inp', echo, error)
  end subroutine report_recorder
end module qsmpm_stepped_analysis
