!> What the four kernels do alike with a model in principal values: keep what it makes of a point, and weigh the
!> elastic tangent against the consistent one.
module qsmpm_principal_point
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: status_ok, status_failed, tangent_elastic
  use qsmpm_principal_model, only: principal_model_type, stress_update_type
  implicit none
  private

  public :: keep_update, elastic_share

contains

  !> State variables and status of a model's update go to the point, with what the model has to say.
  pure subroutine keep_update(model, result, start, state, status, message)
    class(principal_model_type), intent(in) :: model
    type(stress_update_type), intent(in) :: result
    !> The model's state variables at the start and at the end of the step.
    real(wp), intent(in) :: start(model%state_count)
    real(wp), intent(inout) :: state(model%state_count)
    !> status_ok so far.
    integer, intent(inout) :: status
    character(len=:), allocatable, intent(inout) :: message
    integer :: i

    do i = 1, model%state_count
      state(i) = result%state(i)
      if (.not. ieee_is_finite(start(i))) status = status_failed
    end do
    if (result%status == status_ok) return
    status = result%status
    message = model%message
  end subroutine keep_update

  !> Share of the elastic tangent in the one that is asked for.
  pure real(wp) function elastic_share(tangent, blend)
    !> One of tangent_consistent, tangent_elastic.
    integer, intent(in) :: tangent
    !> Share of the elastic tangent in the consistent one.
    real(wp), intent(in) :: blend

    elastic_share = blend
    if (tangent == tangent_elastic) elastic_share = 1.0_wp
  end function elastic_share
end module qsmpm_principal_point
