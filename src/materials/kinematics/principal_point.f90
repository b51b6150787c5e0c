!> What the four kernels do alike with a model in principal values: keep what it makes of a point, and weigh the
!> elastic tangent against the consistent one.
module qsmpm_principal_point
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: batch_type, status_ok, status_failed, tangent_elastic
  use qsmpm_principal_model, only: principal_model_type, stress_update_type
  implicit none
  private

  public :: keep_update, size_of_cell, elastic_share

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

  !> Size of a point's cell for a model that asks for it; 0 where there is none.
  pure real(wp) function size_of_cell(model, batch, p) result(cell_size)
    class(principal_model_type), intent(in) :: model
    type(batch_type), intent(in) :: batch
    !> Number of the point.
    integer, intent(in) :: p

    cell_size = 0.0_wp
    if (model%asks_cell_size .and. allocated(batch%cell_size)) cell_size = batch%cell_size(p)
  end function size_of_cell

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
