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
  pure subroutine keep_update(model, result, first, batch, p)
    class(principal_model_type), intent(in) :: model
    type(stress_update_type), intent(in) :: result
    !> Where the model's state variables begin in the state of a point.
    integer, intent(in) :: first
    type(batch_type), intent(inout) :: batch
    !> Number of the point, whose status is ok.
    integer, intent(in) :: p
    integer :: i

    do i = 1, model%state_count
      batch%state(first + i - 1, p) = result%state(i)
      if (.not. ieee_is_finite(batch%state_start(first + i - 1, p))) batch%status(p) = status_failed
    end do
    if (result%status == status_ok) return
    batch%status(p) = result%status
    batch%message = model%message
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
