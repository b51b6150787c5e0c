!> One step of a material point, each component of its gradient or its stress given: what the tests of laws share.
module point_trials
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_law, only: law_type, batch_type, step_info_type
  use qsmpm_point_driver, only: point_type, prepare_point, control_point, control_type, control_stress
  use qsmpm_tensor, only: determinant, gradient_column, gradient_index, gradient_row, inverse
  implicit none
  private

  public :: step_point

  !> Tolerance of the stresses.
  real(wp), parameter :: tight = 1.0e-12_wp

contains

  !> One step by components of f. When it fails the point stays as it was.
  subroutine step_point(law, point, prescribed, values, error, time)
    class(law_type), intent(in) :: law
    type(point_type), intent(inout) :: point
    !> Which components of the incremental gradient are prescribed (5 or 9).
    logical, intent(in) :: prescribed(:)
    !> Their values; elsewhere the Cauchy stress of the row and column (5 or 9).
    real(wp), intent(in) :: values(:)
    !> Set when no gradient gives the stresses.
    type(error_type), allocatable, intent(out) :: error
    !> Time that the step takes.
    real(wp), intent(in), optional :: time
    type(control_type) :: controls(size(values))
    type(step_info_type) :: step_info
    type(batch_type) :: batch
    real(wp) :: back(3, 3)
    integer :: i, k, d, iterations

    d = law%dimension
    back = inverse(point%deformation, determinant(point%deformation))
    do i = 1, size(values)
      controls(i)%value = values(i)
      if (.not. prescribed(i)) then
        controls(i)%kind = control_stress
        controls(i)%weight(i) = 1.0_wp
        cycle
      end if
      ! f = F F0^-1, F the whole gradient.
      do k = 1, 3
        associate (place => gradient_index(gradient_row(i, d), k, d))
          if (place > 0) controls(i)%weight(place) = back(k, gradient_column(i, d))
        end associate
      end do
    end do
    if (present(time)) step_info%phase_time = time
    call prepare_point(law, batch)
    call control_point(law, point, controls, tight, step_info, batch, iterations, error)
  end subroutine step_point
end module point_trials
