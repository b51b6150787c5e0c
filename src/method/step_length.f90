!> Step control: how long the next attempt is, as a share of the phase.
!>
!>   after an accepted step   a hard one makes the next one smaller, an easy one lets it grow to the first
!>                            length again, or to what the error of its length allows
!>   after a lost one         half of it, or what a law or the error of its length asks for; below the
!>                            smallest step the phase ends
!> No step goes beyond the phase, and steps of the first length end on its multiples.
module qsmpm_step_length
  use qsmpm_analysis, only: controls_type
  use qsmpm_kinds, only: wp
  use qsmpm_stepping, only: outcome_type
  implicit none
  private

  public :: first_length, end_of_step, length_after_step, length_after_loss, is_too_short

  !> A step that a law has refused is cut to this share of it at the most.
  real(wp), parameter :: largest_cut = 0.9_wp
  !> Bounds for the ratio of two steps in a row, and the part of the allowed error that is aimed at.
  real(wp), parameter :: least_growth = 0.2_wp, most_growth = 2.0_wp, margin = 0.7_wp
  !> Lengths that are as near as this, as a share of the first one, are the same.
  real(wp), parameter :: closeness = 1.0e-9_wp

contains

  !> Length of the first step of a phase.
  pure real(wp) function first_length(controls)
    type(controls_type), intent(in) :: controls

    first_length = 1.0_wp/controls%steps
  end function first_length

  !> End of the next step: on a multiple of the first length where one is near, and never beyond the phase.
  pure real(wp) function end_of_step(controls, fraction, length) result(last)
    type(controls_type), intent(in) :: controls
    !> Share of the phase done, and length of the step.
    real(wp), intent(in) :: fraction, length
    real(wp) :: first, whole

    first = first_length(controls)
    last = min(1.0_wp, fraction + length)
    whole = (aint(fraction/first + closeness) + 1.0_wp)*first
    if (last > whole - closeness*first .and. length <= first*(1.0_wp + closeness)) last = min(1.0_wp, whole)
    if (last > 1.0_wp - closeness*first) last = 1.0_wp
  end function end_of_step

  !> Length after an accepted step.
  pure real(wp) function length_after_step(controls, length, outcome) result(next)
    type(controls_type), intent(in) :: controls
    !> Length of the step.
    real(wp), intent(in) :: length
    type(outcome_type), intent(in) :: outcome

    next = length
    if (outcome%static_iterations <= controls%few_iterations) next = min(first_length(controls), 2.0_wp*length)
    if (controls%step_error > 0.0_wp .and. outcome%static) next = min(controls%largest_step, &
      length*length_ratio(outcome%step_error, controls%step_error))
    if (outcome%static_iterations > controls%many_iterations) next = min(0.5_wp*length, next)
    next = max(next, smallest_length(controls))
  end function length_after_step

  !> Length after a step that was not accepted.
  pure real(wp) function length_after_loss(controls, length, outcome) result(next)
    type(controls_type), intent(in) :: controls
    !> Length of the step.
    real(wp), intent(in) :: length
    type(outcome_type), intent(in) :: outcome

    next = 0.5_wp*length
    if (outcome%share > 0.0_wp) next = min(largest_cut, outcome%share)*length
    if (outcome%too_long) next = max(smallest_length(controls), &
      length*length_ratio(outcome%step_error, controls%step_error))
  end function length_after_loss

  !> Whether a step is smaller than the phase allows.
  pure logical function is_too_short(controls, length)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: length

    is_too_short = length < smallest_length(controls)*(1.0_wp - closeness)
  end function is_too_short

  !> The smallest step.
  pure real(wp) function smallest_length(controls)
    type(controls_type), intent(in) :: controls

    smallest_length = controls%smallest_step*first_length(controls)
  end function smallest_length

  !> By what a step is to be longer or shorter. The error is a share of the step's own displacements and
  !> falls with its length; a step is not to grow too fast, and a little margin saves steps that would be
  !> rejected.
  pure real(wp) function length_ratio(step_error, allowed) result(ratio)
    !> Error of the step and what is allowed, as shares.
    real(wp), intent(in) :: step_error, allowed

    ratio = most_growth
    if (step_error > 0.0_wp) ratio = min(most_growth, max(least_growth, margin*allowed/step_error))
  end function length_ratio
end module qsmpm_step_length
