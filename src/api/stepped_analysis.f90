!> One analysis that a program holds and steps: made, advanced, written, saved, restored. There is no state outside the
!> object, so that any number of them may live and take turns in one process; each gives the bytes of a run of its own.
!>
!> What listens is an argument of the calls that step. Changes of loads are left to `qsmpm_simulation`.
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
  use qsmpm_observer, only: observer_type, step_record_type
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

  !> Shares of a stage closer than this are the same.
  real(wp), parameter :: closeness = 1.0e-9_wp

  !> An analysis in the hands of a program.
  type :: stepped_analysis_type
    !> The scene as it was written, with the stages added since.
    type(analysis_type) :: scene
    !> What is modelled of it: mesh, material points, loads. To be looked at; changed by the procedures below.
    !> Allocated while it is ready; as a class, it and the recorder are copied and freed by one call (qsmpm_model).
    class(model_type), allocatable :: model
    !> Threads it may use; the results do not depend on them.
    integer :: threads = 1
    !> How the last accepted step went.
    type(step_record_type) :: last
    !> There is a model.
    logical :: ready = .false.
    !> What was found about reductions of the scene.
    type(reduction_check_type), allocatable :: checks(:)
    !> Where results are written, while they are.
    class(recorder_type), allocatable :: recorder
    !> Time and work so far.
    type(step_loop_type) :: loop
    type(expansion_type), private :: expansion
    type(phase_type), allocatable, private :: adopted(:)
    !> Laws of the program (materials of the deck).
    type(law_slot_type), allocatable, private :: own(:)
    type(clock_type), private :: clock
    !> What the reader of the deck had to say.
    character(len=:), allocatable :: messages
    !> Why the last step was not reached.
    type(error_type), allocatable :: outcome
  contains
    procedure :: create
    procedure :: destroy
    procedure, private :: advance_alone, advance_observed
    !> One accepted load step.
    generic :: advance => advance_alone, advance_observed
    procedure, private :: advance_to_alone, advance_to_observed
    !> Step to a share of the present or coming stage.
    generic :: advance_to => advance_to_alone, advance_to_observed
    procedure, private :: run_alone, run_observed
    !> Step to the end of the last stage.
    generic :: run => run_alone, run_observed
    procedure :: finished, add_term => add_own_term, record, finish_record, save => save_state, load => load_state, &
      checkpoint, restore_checkpoint => restore_kept, take_over, add_cards
  end type stepped_analysis_type

contains

  !> Mesh, seed and make ready to step.
  subroutine create(self, problem, error, team)
    !> The analysis; a former one is given up.
    class(stepped_analysis_type), intent(inout) :: self
    type(problem_type), intent(in) :: problem
    !> Set when the deck or a material of the program is not good.
    type(error_type), allocatable, intent(out) :: error
    !> Who may share the model as it is built; this process alone where it is not given.
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
    ! Results of a scene that is larger than its model are made of the whole model.
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

  !> Give everything back. The results that are written are closed; use finish_record to hear of faults in that.
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

  !> A loop at rest.
  subroutine clear(loop)
    type(step_loop_type), intent(out) :: loop
  end subroutine clear

  !> Set when there is no model.
  subroutine need_model(self, error)
    class(stepped_analysis_type), intent(in) :: self
    !> Set when there is none.
    type(error_type), allocatable, intent(out) :: error

    if (.not. self%ready) call fail(error, error_other, 'there is no model: create it first')
  end subroutine need_model

  !> Whether the last stage has ended.
  pure logical function finished(self)
    class(stepped_analysis_type), intent(in) :: self

    finished = .false.
    if (self%ready) finished = is_finished(self%model, self%loop)
  end function finished

  !> One accepted load step.
  subroutine advance_alone(self, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Why there is none; the state is then that of the last accepted step.
    type(error_type), allocatable, intent(out) :: error

    call step_on(self, 1.0_wp, error)
  end subroutine advance_alone

  !> One accepted load step, with a observer.
  subroutine advance_observed(self, observer, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Listener of the program.
    class(observer_type), intent(inout) :: observer
    !> Why there is none; the state is then that of the last accepted step.
    type(error_type), allocatable, intent(out) :: error

    call step_on(self, 1.0_wp, error, observer)
  end subroutine advance_observed

  !> Step to a share of the present stage, or of the coming one between stages.
  subroutine advance_to_alone(self, share, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Share of the stage, above the present one, to 1.
    real(wp), intent(in) :: share
    !> Why it is not reached; the state is then that of the last accepted step.
    type(error_type), allocatable, intent(out) :: error

    call step_to(self, share, error)
  end subroutine advance_to_alone

  !> Step to a share of a stage, with a observer.
  subroutine advance_to_observed(self, share, observer, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Share of the stage, above the present one, to 1.
    real(wp), intent(in) :: share
    !> Listener of the program.
    class(observer_type), intent(inout) :: observer
    !> Why it is not reached; the state is then that of the last accepted step.
    type(error_type), allocatable, intent(out) :: error

    call step_to(self, share, error, observer)
  end subroutine advance_to_observed

  !> Step to the end of the last stage.
  subroutine run_alone(self, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Why it is not reached; the state is then that of the last accepted step.
    type(error_type), allocatable, intent(out) :: error

    call run_on(self, error)
  end subroutine run_alone

  !> Step to the end of the last stage, with a observer.
  subroutine run_observed(self, observer, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Listener of the program.
    class(observer_type), intent(inout) :: observer
    !> Why it is not reached; the state is then that of the last accepted step.
    type(error_type), allocatable, intent(out) :: error

    call run_on(self, error, observer)
  end subroutine run_observed

  !> Step to the end of the last stage; without the stages that cannot be carried on and those that start from them.
  subroutine run_on(self, error, observer)
    class(stepped_analysis_type), intent(inout) :: self
    !> Why it is not reached, or which stages were not.
    type(error_type), allocatable, intent(out) :: error
    !> Listener of the program.
    class(observer_type), intent(inout), optional :: observer

    call need_model(self, error)
    do while (.not. (allocated(error) .or. self%finished()))
      call step_on(self, 1.0_wp, error, observer, leaves_lost=.true.)
    end do
  end subroutine run_on

  !> Steps to a share of a stage.
  subroutine step_to(self, share, error, observer)
    class(stepped_analysis_type), intent(inout) :: self
    !> Share of the stage.
    real(wp), intent(in) :: share
    !> Why it is not reached.
    type(error_type), allocatable, intent(out) :: error
    !> Listener of the program.
    class(observer_type), intent(inout), optional :: observer
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
      call step_on(self, share, error, observer)
      if (allocated(error) .or. self%model%state%progress%fraction >= share - closeness) exit
    end do
  end subroutine step_to

  !> One accepted step that goes no further than a share of its stage.
  subroutine step_on(self, limit, error, observer, leaves_lost)
    class(stepped_analysis_type), intent(inout), target :: self
    !> Share of the stage.
    real(wp), intent(in) :: limit
    !> Why there is none.
    type(error_type), allocatable, intent(out) :: error
    !> Listener of the program.
    class(observer_type), intent(inout), optional, target :: observer
    !> Go on without a stage that is lost.
    logical, intent(in), optional :: leaves_lost
    type(observer_list_type) :: observers
    type(settings_type) :: settings

    call need_model(self, error)
    if (.not. allocated(error) .and. self%finished()) &
      call fail(error, error_other, 'the analysis is finished: no stage is to come')
    if (allocated(error)) return
    if (allocated(self%recorder)) observers%recorder => self%recorder
    if (present(observer)) observers%own => observer
    call enter_library(self%threads, settings)
    self%loop%limit = limit
    call advance_step_loop(self%model, self%loop, observers, error)
    if (present(leaves_lost) .and. allocated(error)) call leave_lost_phase(self%model, self%loop, observers, error)
    call leave_library(settings)
    self%last = observers%last
    if (allocated(self%outcome)) deallocate (self%outcome)
    if (allocated(error)) allocate (self%outcome, source=error)
  end subroutine step_on

  !> Add a term of the program's own to the equations, before the first step and before anything is written.
  subroutine add_own_term(self, term, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> What it is; a copy is taken.
    class(term_type), intent(in) :: term
    !> Set when it is too late.
    type(error_type), allocatable, intent(out) :: error

    call need_model(self, error)
    if (allocated(error)) return
    if (self%model%state%progress%step > 0 .or. allocated(self%recorder)) then
      call fail(error, error_other, 'a term is added before the first step, and before results are written')
      return
    end if
    call add_term(self%model, self%loop%step%terms, term)
  end subroutine add_own_term

  !> From now on, write what a run of the command line writes.
  subroutine record(self, directory, error, display, continued)
    class(stepped_analysis_type), intent(inout) :: self
    !> Where to; it is made when it is not there. What an earlier run left is replaced.
    character(len=*), intent(in) :: directory
    !> Set when something cannot be written.
    type(error_type), allocatable, intent(out) :: error
    !> One of the display_* values of qsmpm_display; nothing is shown unless given.
    integer, intent(in), optional :: display
    !> The state was loaded, and the directory holds what was written up to it.
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
      ! A model in a library that ends the process does so before these files are closed.
      if (self%loop%team%rank == 0) call guard_exit()
    end if
    call switch_timer(self%loop%step%profile%watch, part_control)
  end subroutine record

  !> Close what is written; the log says how the last step ended.
  subroutine finish_record(self, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Set when something could not be written.
    type(error_type), allocatable, intent(out) :: error

    if (.not. allocated(self%recorder)) return
    call close(self%recorder, self%model, error, self%outcome)
    deallocate (self%recorder)
  end subroutine finish_record

  !> Write the whole state to a file.
  subroutine save_state(self, path, error)
    class(stepped_analysis_type), intent(in) :: self
    !> Name of the file.
    character(len=*), intent(in) :: path
    !> Set when it is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: echo

    call need_model(self, error)
    if (allocated(error)) return
    call echo_text(self%scene, echo)
    call write_restart(path, self%model, text_fingerprint(echo), error)
  end subroutine save_state

  !> Read a state back that was saved with the same stages.
  subroutine load_state(self, path, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Name of the file.
    character(len=*), intent(in) :: path
    !> Set when it is damaged or belongs to another deck; the state is then unchanged.
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

  !> Copy state, loads and stages.
  subroutine checkpoint(self, snapshot, error)
    class(stepped_analysis_type), intent(in) :: self
    type(snapshot_type), intent(out) :: snapshot
    !> Set when there is no model.
    type(error_type), allocatable, intent(out) :: error

    call need_model(self, error)
    if (.not. allocated(error)) call take_snapshot(self%model, self%scene%phases, self%loop, snapshot)
  end subroutine checkpoint

  !> Put a copy of this analysis back.
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

  !> Take over stages that were changed in `scene`; those that have begun must not be. Restored with an error.
  subroutine take_over(self, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Set when the model is not good for them.
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

  !> Add materials and phases to the scene, as cards of its deck. The model under way knows them from now on.
  subroutine add_cards(self, cards, error)
    class(stepped_analysis_type), intent(inout) :: self
    !> Lines of a deck: *MATERIAL and *PHASE with what belongs to them.
    character(len=*), intent(in) :: cards
    !> Set when they are not good, or the model cannot take them; it is then as it was.
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

  !> What is written has columns for the materials and phases that there were.
  subroutine need_no_column(self, extended, error)
    class(stepped_analysis_type), intent(in) :: self
    type(analysis_type), intent(in) :: extended
    !> Set when curves.csv would need the column of the factor, or a reduced scene another material.
    type(error_type), allocatable, intent(out) :: error

    if (.not. allocated(self%recorder)) return
    if (any(extended%phases%kind == phase_safety) .and. .not. any(self%scene%phases%kind == phase_safety)) then
      call fail(error, error_other, 'the first safety phase is added before results are written: curves.csv has a '// &
        'column for its factor')
    else if (size(extended%materials) > size(self%scene%materials) .and. is_reduced(self%recorder%options%whole)) then
      call fail(error, error_other, 'materials are added to a reduced scene before results are written')
    end if
  end subroutine need_no_column

  !> The results that are written follow the stages.
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
