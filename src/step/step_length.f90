!> Step control: length of the next step as a load fraction of the phase, and end of a phase; the table of all rules is
!> in the header of qsmpm_step_control. No step extends beyond the phase, steps of the first length end on its
!> multiples, and no step reaches a load that was rejected for its compliance.
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

  !> Largest length, relative to the step, to which a step rejected by a law is cut back.
  real(wp), parameter :: largest_cut = 0.9_wp
  !> Bounds of the ratio of two successive steps, and target of the error relative to its bound.
  real(wp), parameter :: least_growth = 0.2_wp, most_growth = 2.0_wp, margin = 0.7_wp
  !> Accuracy of a load beyond the capacity of the soil where the deck does not request a limit load, relative to the
  !> load supported and to the first step; the error due to the grid is larger.
  real(wp), parameter :: nearest_load = 0.02_wp, nearest_limit = 0.12_wp
  !> First step of a phase with transient pore water flow relative to the largest length of its steps, and target of the
  !> error of the pressures.
  real(wp), parameter :: short_start = 0.01_wp, water_allowed = 0.1_wp
  !> Relative difference below which lengths and load fractions are equal.
  real(wp), parameter :: same_length = 1.0e-9_wp, same_fraction = 1.0e-12_wp

contains

  !> Returns the length of the first step of a phase.
  pure real(wp) function first_length(controls)
    type(controls_type), intent(in) :: controls

    first_length = 1.0_wp/controls%steps
    if (is_graded(controls)) first_length = controls%first_share
  end function first_length

  !> Returns whether the steps of a phase grow from a given first one.
  pure logical function is_graded(controls)
    type(controls_type), intent(in) :: controls

    is_graded = controls%first_share > 0.0_wp .and. controls%steps > 1 .and. &
      controls%first_share*controls%steps < 1.0_wp
  end function is_graded

  !> Returns whether the steps begin short and grow as the error of the pore pressures allows.
  pure logical function is_by_water(controls)
    type(controls_type), intent(in) :: controls

    is_by_water = controls%by_water .and. controls%steps > 1 .and. .not. controls%first_share > 0.0_wp
  end function is_by_water

  !> Returns the growth ratio r of the steps, s_1 (1 + r + ... + r^(N-1)) = 1; 1 where all are equal.
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

  !> Returns the length of the step that begins at a load fraction if none was cut back: s_1 + (r - 1) s.
  pure real(wp) function planned_length(controls, fraction) result(length)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: fraction

    length = first_length(controls) + (growth_of(controls) - 1.0_wp)*fraction
    if (is_by_water(controls)) length = short_start*length
  end function planned_length

  !> Returns the smallest length of a step.
  pure real(wp) function smallest_length(controls)
    type(controls_type), intent(in) :: controls

    smallest_length = controls%smallest_step*first_length(controls)
  end function smallest_length

  !> Returns whether a step is smaller than the phase allows.
  pure logical function is_too_short(controls, length)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: length

    is_too_short = length < smallest_length(controls)*(1.0_wp - same_length)
  end function is_too_short

  !> Computes length and end of the next step. Where no load remains below one that was rejected for its compliance, the
  !> limit load is found and there is no next step.
  pure subroutine plan_step(controls, furthest, progress, length, last)
    type(controls_type), intent(in) :: controls
    !> Upper bound of the load fraction at the end of the step.
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

  !> Returns whether a limit load is requested and is below a load that was rejected.
  pure logical function bisects(controls, progress)
    type(controls_type), intent(in) :: controls
    type(progress_type), intent(in) :: progress

    bisects = controls%limit_compliance > 0.0_wp .and. progress%limit%refused > 0.0_wp
  end function bisects

  !> Returns the end of the next step: on a multiple of the first length where one is near, and never beyond the phase.
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

  !> Returns the end of the next step below a load that was rejected for its compliance: halfway to it where it would be
  !> reached.
  pure real(wp) function below_rejected(limit, fraction, last)
    type(limit_load_type), intent(in) :: limit
    !> Load fraction so far, and planned end of the step.
    real(wp), intent(in) :: fraction, last

    below_rejected = last
    if (limit%refused > 0.0_wp) below_rejected = min(last, 0.5_wp*(fraction + limit%refused))
  end function below_rejected

  !> Returns the length after an accepted step.
  pure real(wp) function length_after_step(controls, length, outcome, fraction) result(next)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: length
    type(outcome_type), intent(in) :: outcome
    !> Load fraction at the end of the step.
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

  !> Returns the length after a rejected step.
  pure real(wp) function length_after_rejection(controls, length, outcome) result(next)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: length
    type(outcome_type), intent(in) :: outcome

    next = 0.5_wp*length
    if (outcome%share > 0.0_wp) next = min(largest_cut, outcome%share)*length
    if (outcome%too_long) next = max(smallest_length(controls), &
      length*length_ratio(outcome%step_error, controls%step_error))
  end function length_after_rejection

  !> Updates the progress after an accepted step.
  pure subroutine go_on(controls, compliance, start, length, outcome, progress)
    type(controls_type), intent(in) :: controls
    type(compliance_type), intent(in) :: compliance
    !> Load fraction at its start, and its planned length.
    real(wp), intent(in) :: start, length
    type(outcome_type), intent(in) :: outcome
    !> Progress at the end of the step.
    type(progress_type), intent(inout) :: progress

    progress%step = progress%step + 1
    progress%phase_steps = progress%phase_steps + 1
    progress%next_step = length_after_step(controls, merge(progress%fraction - start, length, &
      is_by_water(controls)), outcome, progress%fraction)
    call note_accepted(compliance, controls%limit_compliance, start, progress%fraction, progress%limit)
  end subroutine go_on

  !> Updates the progress after a rejected step.
  pure subroutine cut_back(controls, compliance, last, outcome, progress)
    type(controls_type), intent(in) :: controls
    type(compliance_type), intent(in) :: compliance
    !> Load fraction that was to be reached.
    real(wp), intent(in) :: last
    type(outcome_type), intent(in) :: outcome
    !> Progress at the start of the step.
    type(progress_type), intent(inout) :: progress

    if (outcome%at_limit) call note_refused(compliance, progress%fraction, last, progress%limit)
    progress%next_step = length_after_rejection(controls, last - progress%fraction, outcome)
  end subroutine cut_back

  !> Returns the factor on the length of a step. The error is a share of the step's own displacements and decreases with
  !> its length; the growth is bounded, and a margin avoids steps that would be rejected.
  pure real(wp) function length_ratio(step_error, allowed) result(ratio)
    real(wp), intent(in) :: step_error, allowed

    ratio = most_growth
    if (step_error > 0.0_wp) ratio = min(most_growth, max(least_growth, margin*allowed/step_error))
  end function length_ratio

  !> Returns the length of a step that exceeded the value at which its phase stops, to be repeated up to a share of it;
  !> 0 where it cannot be shorter and is kept.
  pure real(wp) function length_to_stop(controls, length, share) result(next)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: length, share

    next = max(share*length, smallest_length(controls))
    if (.not. next < length*(1.0_wp - same_length)) next = 0.0_wp
  end function length_to_stop

  !> Returns whether a phase ends without its full load after a step was rejected and the next one cut back; the
  !> bisection of a limit load ends in plan_step.
  pure logical function is_given_up(controls, progress, outcome)
    type(controls_type), intent(in) :: controls
    type(progress_type), intent(in) :: progress
    type(outcome_type), intent(in) :: outcome

    is_given_up = outcome%unrecoverable .or. &
      (.not. bisects(controls, progress) .and. is_too_short(controls, progress%next_step)) .or. &
      is_load_known(controls, progress)
  end function is_given_up

  !> Returns whether the load that the soil supports is known accurately enough where no limit load was requested. Until
  !> then a rejected load is tried again from closer states.
  pure logical function is_load_known(controls, progress)
    type(controls_type), intent(in) :: controls
    type(progress_type), intent(in) :: progress

    associate (refused => progress%limit%refused, carried => progress%fraction)
      is_load_known = .not. controls%limit_compliance > 0.0_wp .and. refused > 0.0_wp .and. &
        refused - carried < max(nearest_limit*first_length(controls), nearest_load*carried)
    end associate
  end function is_load_known

  !> Returns whether the present phase is complete: its full load is reached, its limit load found, a history has
  !> reached its value, or equilibrium was lost.
  pure logical function phase_is_complete(progress)
    type(progress_type), intent(in) :: progress

    phase_is_complete = .not. progress%fraction < 1.0_wp - same_fraction .or. is_found(progress%limit) .or. &
      progress%stopped .or. is_lost(progress)
  end function phase_is_complete
end module qsmpm_step_length
