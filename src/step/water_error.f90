!> What the length of a step costs where pore water flows in time: how far its excess pressures are from a straight line
!> with those of the step before,
!>
!>   e = max |dp - r dp'| / p_max,      r the length of the step over that of the one before, dp' the change in it,
!>
!> p_max the largest pressure of the phase so far: 0 while a load is put on and no water leaves. Backward differences of
!> second order (qsmpm_flow_balance) are off by less than that.
module qsmpm_water_error
  use qsmpm_kinds, only: wp
  use qsmpm_consolidation, only: excess_field
  use qsmpm_initialisation, only: step_type
  use qsmpm_kept_arrays, only: is_kept, kept_values
  use qsmpm_model, only: model_type
  use qsmpm_nodal_fields, only: rate_of
  use qsmpm_pore_flow, only: course_name
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_unknowns, only: find_field, values_of
  implicit none
  private

  public :: water_error

contains

  !> The error; 0 in the first step of a phase.
  function water_error(model, step, attempt, displacement) result(error)
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    type(attempt_type), intent(in) :: attempt
    !> Changes of all unknowns (components, columns).
    real(wp), intent(in) :: displacement(:, :)
    real(wp) :: error
    real(wp), allocatable :: course(:, :), change(:), before(:)

    error = 0.0_wp
    if (model%state%progress%phase_steps == 0 .or. .not. is_kept(model%state%kept, rate_of//excess_field)) return
    course = kept_values(model%state%kept, course_name)
    before = pack(kept_values(model%state%kept, rate_of//excess_field), .true.)
    change = pack(values_of(step%unknowns, find_field(step%unknowns, excess_field), displacement), .true.)
    before = before*(attempt%fraction - model%state%progress%fraction)
    error = maxval(abs(change - before))/max(course(2, 1), tiny(1.0_wp))
  end function water_error
end module qsmpm_water_error
