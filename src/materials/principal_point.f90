!> What the four kernels do alike with a model in principal values: ask the model, and weigh the
!> elastic tangent against the consistent one.
module qsmpm_principal_point
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: batch_type, status_ok, status_failed, tangent_elastic
  use qsmpm_principal_model, only: principal_model_type, stress_update_type
  implicit none
  private

  public :: ask_model, elastic_share

contains

  !> Ask a model for the stress of a trial of a point whose status is ok; status, message, state variables and the mark of yielding go to the point.
  pure subroutine ask_model(model, modulus, trial, first, with_derivative, batch, p, result)
    class(principal_model_type), intent(in) :: model
    !> Shear modulus of the step.
    real(wp), intent(in) :: modulus
    !> Principal trial strains or stresses (3).
    real(wp), intent(in) :: trial(3)
    !> Where the model's state variables begin in the state of a point.
    integer, intent(in) :: first
    !> Whether the derivative is wanted.
    logical, intent(in) :: with_derivative
    type(batch_type), intent(inout) :: batch
    !> Number of the point.
    integer, intent(in) :: p
    type(stress_update_type), intent(inout) :: result
    real(wp) :: cell_size
    integer :: i

    do i = 1, model%state_count
      if (.not. ieee_is_finite(batch%state_start(first + i - 1, p))) batch%status(p) = status_failed
    end do
    if (batch%status(p) /= status_ok) return
    cell_size = 0.0_wp
    if (allocated(batch%cell_size)) cell_size = batch%cell_size(p)
    call model%update(modulus, trial, batch%state_start(first:, p), cell_size, with_derivative, result)
    do i = 1, model%state_count
      batch%state(first + i - 1, p) = result%state(i)
    end do
    batch%plastic(p) = merge(1, 0, result%yields)
    if (result%status == status_ok) return
    batch%status(p) = result%status
    batch%message = model%message
  end subroutine ask_model

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
