!> Checks whether a soil model keeps its stress at zero strain. A model that does not may return to its yield surface,
!> which a second call leaves unchanged, or flow with time, which is less in a shorter time. A model that does neither
!> is not a function of strain and time: its change of stress accumulates with the calls.
module qsmpm_rest_check
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: status_ok
  use qsmpm_soil_model, only: soil_model_type, soil_increment_type, soil_response_type
  implicit none
  private

  public :: changes_at_rest, what_changes

  !> Reasons for a change of the stress at zero strain: return to the admissible stresses, flow with time, fault.
  integer, parameter, public :: rest_returns = 0, rest_flows = 1, rest_is_faulty = 2
  !> Share of the stress regarded as a change; largest share of a change that remains for a return or a flow.
  real(wp), parameter :: least_change = 1.0e-5_wp, left = 0.5_wp
  !> Shares of the phase: the shorter time is this share of the time, unless that is the shortest already.
  real(wp), parameter :: shorter = 1.0e-2_wp, shortest = 1.0e-4_wp

contains

  !> Whether the stress changes at zero strain; a stress that is not finite is not regarded as a change.
  pure logical function changes_at_rest(before, after)
    !> Cauchy stress (6).
    real(wp), intent(in) :: before(:), after(:)

    changes_at_rest = all(ieee_is_finite(after))
    if (changes_at_rest) changes_at_rest = &
      change(before, after) > least_change*max(maxval(abs(before)), maxval(abs(after)))
  end function changes_at_rest

  !> Largest change of a component.
  pure real(wp) function change(before, after)
    real(wp), intent(in) :: before(:), after(:)

    change = maxval(abs(after - before))
  end function change

  !> Determines why the stress changes, by two more calls.
  subroutine what_changes(model, increment, before, after, what)
    class(soil_model_type), intent(in) :: model
    !> A step without strain.
    type(soil_increment_type), intent(in) :: increment
    !> Stress and state at its start, one after the other, and at its end.
    real(wp), intent(in) :: before(:), after(:)
    !> One of the rest_* values; a rejected step is not a fault of this kind.
    integer, intent(out) :: what
    type(soil_increment_type) :: other
    type(soil_response_type) :: response
    real(wp) :: stress(6), state(size(before) - 6), first, second

    what = rest_returns
    other = increment
    other%wants_tangent = .false.
    first = change(before(:6), after(:6))
    stress = after(:6)
    state = after(7:)
    call model%update(other, stress, state, response)
    if (response%status /= status_ok .or. change(after(:6), stress) <= left*first) return
    other%step_info%duration = merge(shorter*increment%step_info%duration, 1.0_wp, &
      increment%step_info%duration > shortest)
    stress = before(:6)
    state = before(7:)
    call model%update(other, stress, state, response)
    if (response%status /= status_ok) return
    second = change(before(:6), stress)
    what = merge(rest_flows, rest_is_faulty, min(first, second) <= left*max(first, second))
  end subroutine what_changes
end module qsmpm_rest_check
