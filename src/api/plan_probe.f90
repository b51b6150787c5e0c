!> What a run will cost: it is tried for about a second as it is, which tells the time of an iteration, and for another
!> one on every second line of its grid, which tells how many iterations it takes where soil yields. Nothing is written.
!>
!> The range is as wide as the week's scenes ask for (`tools/qsmpm-verify week` prints it beside their seconds).
module qsmpm_plan_probe
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_mesh_description, only: axis_type, set_type, mesh_grid, select_plane, select_box
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_error, only: error_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_observer, only: silent_observer_type
  use qsmpm_phases, only: step_loop_type, begin_step_loop, advance_step_loop, leave_lost_phase, end_step_loop, &
    is_finished
  use qsmpm_run_profile, only: run_profile_type
  use qsmpm_stopwatch, only: clock_type, start_clock, cpu_seconds, start_stopwatch, part_control
  implicit none
  private

  public :: trial_type, try_run, try_coarse, expected_range, coarse_lines, planned_steps

  !> Processor seconds of one trial.
  real(wp), parameter :: budget = 1.0_wp
  !> Factors that a search for a factor of safety tries.
  integer, parameter :: usual_tries = 12
  !> What a run takes over the estimate, at the least and at the most: of a run that came to its end, of one that did on
  !> coarse cells, of one that did on neither.
  real(wp), parameter :: least_over(3) = [0.7_wp, 0.5_wp, 0.4_wp], most_over(3) = [1.5_wp, 4.0_wp, 8.0_wp]
  !> Processor seconds of the program's start and of its results, at the most.
  real(wp), parameter :: beside = 0.1_wp

  !> How far a trial came.
  type :: trial_type
    !> Share of the planned steps; iterations of all attempts; processor seconds.
    real(wp) :: share = 0.0_wp, iterations = 0.0_wp, seconds = 0.0_wp
    !> Of these the seconds before the first iteration: initial stresses, which come once.
    real(wp) :: before = 0.0_wp
    !> It came to the end of the run, whether that was its last phase or the loss of one.
    logical :: ended = .false.
    !> Why the first phase that it lost was lost; unallocated for none.
    character(len=:), allocatable :: lost
  end type trial_type

  !> Stops a trial when its time is over.
  type, extends(silent_observer_type) :: trial_observer_type
    type(clock_type) :: clock
    !> Seconds when it was asked for the first time; negative before.
    real(wp) :: before = -1.0_wp
  contains
    procedure :: stop_requested => time_is_over
  end type trial_observer_type

contains

  !> Whether the trial's time is over.
  logical function time_is_over(self)
    class(trial_observer_type), intent(inout) :: self

    if (self%before < 0.0_wp) self%before = cpu_seconds(self%clock)
    time_is_over = cpu_seconds(self%clock) - self%before > budget
  end function time_is_over

  !> Steps that a run is planned to take, to the end of a phase.
  pure real(wp) function planned_steps(analysis, last)
    type(analysis_type), intent(in) :: analysis
    !> Number of the phase.
    integer, intent(in) :: last
    integer :: p

    planned_steps = 0.0_wp
    do p = 1, last
      associate (phase => analysis%phases(p))
        if (phase%kind == phase_safety) planned_steps = planned_steps + usual_tries
        if (phase%kind /= phase_safety .or. phase%safety%runout < huge(1.0_wp)) &
          planned_steps = planned_steps + phase%controls%steps
      end associate
    end do
  end function planned_steps

  !> Run a copy of a model until its end or until the time is over.
  subroutine try_run(model, trial)
    type(model_type), intent(in) :: model
    type(trial_type), intent(out) :: trial
    class(model_type), allocatable :: copy
    class(step_loop_type), allocatable :: loop
    type(run_profile_type) :: profile
    type(trial_observer_type) :: observer
    type(error_type), allocatable :: error
    logical :: over

    over = .false.
    allocate (copy, source=model)
    allocate (loop)
    call start_stopwatch(profile%watch, part_control)
    call begin_step_loop(copy, profile, loop)
    call start_clock(observer%clock)
    do while (.not. is_finished(copy, loop))
      call advance_step_loop(copy, loop, observer, error)
      over = observer%stop_requested()
      if (allocated(error) .and. .not. (over .or. allocated(trial%lost))) trial%lost = error%message
      if (allocated(error) .and. .not. over) call leave_lost_phase(copy, loop, observer, error)
      if (allocated(error) .or. over) exit
    end do
    trial%seconds = cpu_seconds(observer%clock)
    trial%before = max(0.0_wp, observer%before)
    trial%ended = is_finished(copy, loop) .or. (allocated(error) .and. .not. over)
    trial%share = 1.0_wp
    associate (progress => copy%state%progress, phases => copy%analysis%phases)
      ! Half a step for one that has not been done.
      if (.not. trial%ended) trial%share = max(0.5_wp, planned_steps(copy%analysis, progress%phase - 1) + &
        progress%fraction*phases(progress%phase)%controls%steps)/planned_steps(copy%analysis, size(phases))
    end associate
    call end_step_loop(loop, profile)
    trial%iterations = real(profile%iterations, wp)
  end subroutine try_run

  !> The same on every second line of the grid; a trial of no iterations where there is no such grid.
  subroutine try_coarse(model, trial)
    type(model_type), intent(in) :: model
    type(trial_type), intent(out) :: trial
    class(analysis_type), allocatable :: analysis
    class(model_type), allocatable :: coarse
    type(error_type), allocatable :: error
    integer :: a

    if (model%analysis%mesh%kind /= mesh_grid) return
    allocate (analysis, source=model%analysis)
    do a = 1, size(analysis%mesh%axes)
      if (allocated(analysis%mesh%axes(a)%lines)) &
        analysis%mesh%axes(a)%lines = coarse_lines(analysis%mesh%axes(a), a, analysis%node_sets)
    end do
    allocate (coarse)
    call build_model(analysis, coarse, error)
    if (.not. allocated(error)) call try_run(coarse, trial)
  end subroutine try_coarse

  !> Every second line of an axis, its ends, and those that a set of nodes stands on.
  pure function coarse_lines(axis, number, sets) result(lines)
    type(axis_type), intent(in) :: axis
    !> 1, 2 or 3.
    integer, intent(in) :: number
    !> All sets of nodes.
    type(set_type), intent(in) :: sets(:)
    real(wp), allocatable :: lines(:)
    logical :: kept(size(axis%lines))
    integer :: s

    kept = .false.
    kept(1::2) = .true.
    kept(size(kept)) = .true.
    do s = 1, size(sets)
      if (sets(s)%selection == select_plane .and. sets(s)%axis /= number) cycle
      if (sets(s)%selection == select_plane .or. sets(s)%selection == select_box) &
        kept(minloc(abs(axis%lines - sets(s)%box(number, 1)))) = .true.
      if (sets(s)%selection == select_box) kept(minloc(abs(axis%lines - sets(s)%box(number, 2)))) = .true.
    end do
    lines = pack(axis%lines, kept)
  end function coarse_lines

  !> Least and largest processor seconds to expect of the run.
  pure function expected_range(fine, coarse) result(range)
    !> Trials of the model and of the coarse one.
    type(trial_type), intent(in) :: fine, coarse
    real(wp) :: range(2), estimate
    integer :: known

    estimate = fine%before + (fine%seconds - fine%before)/fine%share
    known = merge(1, 3, fine%ended)
    if (.not. fine%ended .and. coarse%iterations > 0.0_wp) then
      known = merge(2, 3, coarse%ended)
      estimate = fine%before + (fine%seconds - fine%before)/max(fine%iterations, 1.0_wp)*coarse%iterations/coarse%share
    end if
    range = estimate*[least_over(known), most_over(known)] + [0.0_wp, beside]
    if (.not. fine%ended) range = max(range, fine%seconds)
  end function expected_range
end module qsmpm_plan_probe
