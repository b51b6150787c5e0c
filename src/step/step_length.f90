!> Step control: length of the next step as a load fraction of the phase, and where a phase ends; the table of all rules
!> heads qsmpm_step_control. No step goes beyond the phase, steps of the first length end on its multiples, and none
!> reaches a load that was rejected for its compliance.
module qsmpm_step_length
  use qsmpm_phase_description, only: controls_type
  use qsmpm_kinds, only: wp
  use qsmpm_limit_load, only: compliance_type, limit_load_type, is_found, interpolate_knee, note_accepted, note_refused
  use qsmpm_model, only: progress_type
  use qsmpm_phase_ends, only: is_lost
  use qsmpm_step_control, only: outcome_type
  implicit none
  private

  public :: first_length, is_too_short, plan_step, end_of_step, below_rejected, length_after_step
  public :: length_after_rejection, go_on, cut_back, is_given_up, is_load_known, phase_is_complete, length_to_stop

  !> A step that a law rejects is cut back to this share of it at the most.
  real(wp), parameter :: largest_cut = 0.9_wp
  !> Bounds for the ratio of two steps in a row, and the part of the allowed error that is aimed at.
  real(wp), parameter :: least_growth = 0.2_wp, most_growth = 2.0_wp, margin = 0.7_wp
  !> Share of the load carried, and of the first step, to which a load beyond what the ground carries is found where
  !> none asks for more: the grid itself is not as near.
  real(wp), parameter :: nearest_load = 0.02_wp, nearest_limit = 0.12_wp
  !> First step of a phase in which pore water flows, over those that its steps grow to, and the error of pressures that
  !> is aimed at as they do.
  real(wp), parameter :: short_start = 0.01_wp, water_allowed = 0.1_wp
  !> Lengths as near as this share of the first one are the same, and so are these load fractions.
  real(wp), parameter :: same_length = 1.0e-9_wp, same_fraction = 1.0e-12_wp

contains

  !> Length of the first step of a phase.
  pure real(wp) function first_length(controls)
    type(controls_type), intent(in) :: controls

    first_length = 1.0_wp/controls%steps
    if (is_graded(controls)) first_length = controls%first_share
  end function first_length

  !> Whether the steps of a phase grow from a first one.
  pure logical function is_graded(controls)
    type(controls_type), intent(in) :: controls

    is_graded = controls%first_share > 0.0_wp .and. controls%steps > 1 .and. &
      controls%first_share*controls%steps < 1.0_wp
  end function is_graded

  !> Whether they begin short and grow as the pressures of the pore water allow.
  pure logical function is_by_water(controls)
    type(controls_type), intent(in) :: controls

    is_by_water = controls%by_water .and. controls%steps > 1 .and. .not. controls%first_share > 0.0_wp
  end function is_by_water

  !> r, by which steps grow, s_1 (1 + r + ... + r^(N-1)) = 1: 1 where all are even.
  pure real(wp) function growth_of(controls) result(growth)
    type(controls_type), intent(in) :: controls
    integer, parameter :: halvings = 60
    real(wp) :: least, most
    integer :: i

    growth = 1.0_wp
    if (.not. is_graded(controls)) return
    least = 1.0_wp
    ! The last step is no longer than the phase.
    most = controls%first_share**(-1.0_wp/(controls%steps - 1))
    do i = 1, halvings
      growth = 0.5_wp*(least + most)
      if (controls%first_share*(growth**controls%steps - 1.0_wp) > growth - 1.0_wp) then
        most = growth
      else
        least = growth
      end if
    end do
  end function growth_of

  !> Length of the step that begins at a load fraction where none was cut back: s_1 + (r - 1) s.
  pure real(wp) function planned_length(controls, fraction) result(length)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: fraction

    length = first_length(controls) + (growth_of(controls) - 1.0_wp)*fraction
    if (is_by_water(controls)) length = short_start*length
  end function planned_length

  !> The smallest step.
  pure real(wp) function smallest_length(controls)
    type(controls_type), intent(in) :: controls

    smallest_length = controls%smallest_step*first_length(controls)
  end function smallest_length

  !> Whether a step is smaller than the phase allows.
  pure logical function is_too_short(controls, length)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: length

    is_too_short = length < smallest_length(controls)*(1.0_wp - same_length)
  end function is_too_short

  !> Length and end of the next step. Where no load is left below one that was rejected for its compliance the limit
  !> load is found, and there is no next step.
  pure subroutine plan_step(controls, furthest, progress, length, last)
    type(controls_type), intent(in) :: controls
    !> Load fraction that no step goes beyond.
    real(wp), intent(in) :: furthest
    type(progress_type), intent(inout) :: progress
    real(wp), intent(out) :: length, last

    if (.not. progress%next_step > 0.0_wp) progress%next_step = planned_length(controls, progress%fraction)
    length = progress%next_step
    last = end_of_step(controls, progress%fraction, length)
    if (bisects(controls, progress)) then
      last = below_rejected(progress%limit, progress%fraction, last)
      if (is_too_short(controls, last - progress%fraction)) &
        call interpolate_knee(controls%limit_compliance, progress%limit)
    end if
    last = min(furthest, last)
  end subroutine plan_step

  !> Whether a limit load is asked for and lies below a load that was rejected.
  pure logical function bisects(controls, progress)
    type(controls_type), intent(in) :: controls
    type(progress_type), intent(in) :: progress

    bisects = controls%limit_compliance > 0.0_wp .and. progress%limit%refused > 0.0_wp
  end function bisects

  !> End of the next step: on a multiple of the first length where one is near, and never beyond the phase.
  pure real(wp) function end_of_step(controls, fraction, length) result(last)
    type(controls_type), intent(in) :: controls
    !> Load fraction so far, and length of the step.
    real(wp), intent(in) :: fraction, length
    real(wp) :: first, whole

    first = first_length(controls)
    last = min(1.0_wp, fraction + length)
    whole = (aint(fraction/first + same_length) + 1.0_wp)*first
    if (is_by_water(controls)) last = min(1.0_wp, fraction + (whole - fraction)/ceiling((whole - fraction)/length &
      - same_length))
    if (last > whole - same_length*first .and. length <= first*(1.0_wp + same_length)) last = min(1.0_wp, whole)
    if (last > 1.0_wp - same_length*max(first, length)) last = 1.0_wp
  end function end_of_step

  !> The same below a load that was rejected for its compliance: halfway to it where it would be reached.
  pure real(wp) function below_rejected(limit, fraction, last)
    type(limit_load_type), intent(in) :: limit
    !> Load fraction so far, and the end that is wanted.
    real(wp), intent(in) :: fraction, last

    below_rejected = last
    if (limit%refused > 0.0_wp) below_rejected = min(last, 0.5_wp*(fraction + limit%refused))
  end function below_rejected

  !> Length after an accepted step.
  pure real(wp) function length_after_step(controls, length, outcome, fraction) result(next)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: length
    type(outcome_type), intent(in) :: outcome
    !> At its end.
    real(wp), intent(in) :: fraction
    real(wp) :: growth

    growth = growth_of(controls)
    next = growth*length
    if (outcome%static_iterations <= controls%few_iterations .and. .not. outcome%was_cut) next = &
      min(planned_length(controls, fraction), max(2.0_wp, growth)*length)
    if (is_by_water(controls)) next = min(first_length(controls), length*length_ratio(sqrt(outcome%water_error), &
      sqrt(water_allowed)))
    if (controls%step_error > 0.0_wp .and. outcome%static) next = min(controls%largest_step, &
      length*length_ratio(outcome%step_error, controls%step_error))
    if (outcome%static_iterations > controls%many_iterations) next = min(0.5_wp*length, next)
    next = max(next, smallest_length(controls))
  end function length_after_step

  !> Length after a step that was rejected.
  pure real(wp) function length_after_rejection(controls, length, outcome) result(next)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: length
    type(outcome_type), intent(in) :: outcome

    next = 0.5_wp*length
    if (outcome%share > 0.0_wp) next = min(largest_cut, outcome%share)*length
    if (outcome%too_long) next = max(smallest_length(controls), &
      length*length_ratio(outcome%step_error, controls%step_error))
  end function length_after_rejection

  !> After an accepted step.
  pure subroutine go_on(controls, compliance, start, length, outcome, progress)
    type(controls_type), intent(in) :: controls
    type(compliance_type), intent(in) :: compliance
    !> Load fraction at its start, and its length as it was planned.
    real(wp), intent(in) :: start, length
    type(outcome_type), intent(in) :: outcome
    !> At the end of the step.
    type(progress_type), intent(inout) :: progress

    progress%step = progress%step + 1
    progress%phase_steps = progress%phase_steps + 1
    progress%next_step = length_after_step(controls, merge(progress%fraction - start, length, &
      is_by_water(controls)), outcome, progress%fraction)
    call note_accepted(compliance, controls%limit_compliance, start, progress%fraction, progress%limit)
  end subroutine go_on

  !> After a rejected step.
  pure subroutine cut_back(controls, compliance, last, outcome, progress)
    type(controls_type), intent(in) :: controls
    type(compliance_type), intent(in) :: compliance
    !> Load fraction that was to be reached.
    real(wp), intent(in) :: last
    type(outcome_type), intent(in) :: outcome
    !> At the start of the step.
    type(progress_type), intent(inout) :: progress

    if (outcome%at_limit) call note_refused(compliance, progress%fraction, last, progress%limit)
    progress%next_step = length_after_rejection(controls, last - progress%fraction, outcome)
  end subroutine cut_back

  !> By what a step is to be longer or shorter. The error is a share of the step's own displacements and falls with its
  !> length; a step is not to grow too fast, and a little margin saves steps that would be rejected.
  pure real(wp) function length_ratio(step_error, allowed) result(ratio)
    real(wp), intent(in) :: step_error, allowed

    ratio = most_growth
    if (step_error > 0.0_wp) ratio = min(most_growth, max(least_growth, margin*allowed/step_error))
  end function length_ratio

  !> Length of a step that went past the value at which its phase stops, to be taken again up to a share of it; 0 where
  !> it may not be any shorter, and stays.
  pure real(wp) function length_to_stop(controls, length, share) result(next)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: length, share

    next = max(share*length, smallest_length(controls))
    if (.not. next < length*(1.0_wp - same_length)) next = 0.0_wp
  end function length_to_stop

  !> Whether a phase ends without its load after a step was rejected and the next one cut back: the bisection of a limit
  !> load ends elsewhere (plan_step).
  pure logical function is_given_up(controls, progress, outcome)
    type(controls_type), intent(in) :: controls
    type(progress_type), intent(in) :: progress
    type(outcome_type), intent(in) :: outcome

    is_given_up = outcome%unrecoverable .or. &
      (.not. bisects(controls, progress) .and. is_too_short(controls, progress%next_step)) .or. &
      is_load_known(controls, progress)
  end function is_given_up

  !> Whether the load that the ground carries is known near enough where none was asked for. A load that was refused is
  !> tried again from nearer states until then.
  pure logical function is_load_known(controls, progress)
    type(controls_type), intent(in) :: controls
    type(progress_type), intent(in) :: progress

    associate (refused => progress%limit%refused, carried => progress%fraction)
      is_load_known = .not. controls%limit_compliance > 0.0_wp .and. refused > 0.0_wp .and. &
        refused - carried < max(nearest_limit*first_length(controls), nearest_load*carried)
    end associate
  end function is_load_known

  !> Whether the present phase is at its end: its whole load is carried, its limit load found, a history has reached
  !> its value, or equilibrium was lost.
  pure logical function phase_is_complete(progress)
    type(progress_type), intent(in) :: progress

    phase_is_complete = .not. progress%fraction < 1.0_wp - same_fraction .or. is_found(progress%limit) .or. &
      progress%stopped .or. is_lost(progress)
  end function phase_is_complete
end module qsmpm_step_length
