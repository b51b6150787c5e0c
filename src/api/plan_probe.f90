!> Estimates the cost of a run. The model is run for about a second, which gives the time of an iteration, and then for
!> another second on a grid with every second grid line, which gives the number of iterations when the soil yields. No
!> files are written.
!>
!> The width of the range is calibrated on the scenes of the week (`tools/qsmpm-verify week` prints it next to their
!> seconds).
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

  !> Processor time of one trial run, in seconds.
  real(wp), parameter :: budget = 1.0_wp
  !> Typical number of factors in a search for the factor of safety.
  integer, parameter :: usual_tries = 12
  !> Least and greatest ratio of run time to estimate: for a trial that completed the run, for one that completed it on
  !> the coarse grid only, and for one that completed neither.
  real(wp), parameter :: least_over(3) = [0.7_wp, 0.5_wp, 0.4_wp], most_over(3) = [1.5_wp, 4.0_wp, 8.0_wp]
  !> Upper bound of the processor time for start-up and results, in seconds.
  real(wp), parameter :: beside = 0.1_wp

  !> Result of a trial run.
  type :: trial_type
    !> Completed fraction of the planned steps; iterations of all attempts; processor seconds.
    real(wp) :: share = 0.0_wp, iterations = 0.0_wp, seconds = 0.0_wp
    !> Seconds before the first iteration, included in `seconds`: initial stresses, computed once.
    real(wp) :: before = 0.0_wp
    !> Whether the trial reached the end of the run, by its last phase or by a failed phase.
    logical :: ended = .false.
    !> Message of the first phase that failed; unallocated for none.
    character(len=:), allocatable :: lost
  end type trial_type

  !> Stops a trial run at the end of its time.
  type, extends(silent_observer_type) :: trial_observer_type
    type(clock_type) :: clock
    !> Processor time at the first call; negative before.
    real(wp) :: before = -1.0_wp
  contains
    procedure :: stop_requested => time_is_over
  end type trial_observer_type

contains

  !> Returns whether the time of the trial is over.
  logical function time_is_over(self)
    class(trial_observer_type), intent(inout) :: self

    if (self%before < 0.0_wp) self%before = cpu_seconds(self%clock)
    time_is_over = cpu_seconds(self%clock) - self%before > budget
  end function time_is_over

  !> Returns the planned number of steps up to the end of a phase.
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

  !> Runs a copy of a model to its end or until the time is over.
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
      ! An incomplete first step counts as half a step.
      if (.not. trial%ended) trial%share = max(0.5_wp, planned_steps(copy%analysis, progress%phase - 1) + &
        progress%fraction*phases(progress%phase)%controls%steps)/planned_steps(copy%analysis, size(phases))
    end associate
    call end_step_loop(loop, profile)
    trial%iterations = real(profile%iterations, wp)
  end subroutine try_run

  !> Runs the trial on a grid with every second grid line; a trial without iterations if there is no such grid.
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

  !> Returns every second line of an axis, its end lines and the lines used by node sets.
  pure function coarse_lines(axis, number, sets) result(lines)
    type(axis_type), intent(in) :: axis
    !> 1, 2 or 3.
    integer, intent(in) :: number
    !> All node sets.
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

  !> Returns the expected range of processor seconds of the run.
  pure function expected_range(fine, coarse) result(range)
    !> Trial runs of the model and of the coarse model.
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
