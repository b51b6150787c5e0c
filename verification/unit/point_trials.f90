!> One step of a material point, each component of its gradient or its stress given: what the tests of laws share.
module point_trials
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_law, only: law_type, batch_type, step_info_type
  use qsmpm_point_control, only: control_type, control_increment, control_stress
  use qsmpm_point_driver, only: point_type, prepare_point, control_point
  implicit none
  private

  public :: step_point

  !> Tolerance of the stresses.
  real(wp), parameter :: tight = 1.0e-12_wp

contains

  !> One step by components of f. When it fails the point stays as it was.
  subroutine step_point(law, point, prescribed, values, error)
    class(law_type), intent(in) :: law
    type(point_type), intent(inout) :: point
    !> Which components of the incremental gradient are prescribed (5 or 9).
    logical, intent(in) :: prescribed(:)
    !> Their values; elsewhere the Cauchy stress of the row and column (5 or 9).
    real(wp), intent(in) :: values(:)
    !> Set when no gradient gives the stresses.
    type(error_type), allocatable, intent(out) :: error
    type(control_type) :: controls(size(values))
    type(batch_type) :: batch
    integer :: i, iterations

    do i = 1, size(values)
      controls(i)%kind = merge(control_increment, control_stress, prescribed(i))
      controls(i)%weight(i) = 1.0_wp
      controls(i)%value = values(i)
    end do
    call prepare_point(law, batch)
    call control_point(law, point, controls, tight, step_info_type(), batch, iterations, error)
  end subroutine step_point
end module point_trials
