!> An all-round pressure p0 that acts on every free boundary of the soil and follows it.
!>
!> Its force on a body of any shape is that of a uniform stress -p0 inside, so that it need not be summed over the
!> boundary: the equations are those of the stress above -p0,
!>
!>   Q := Q + p0 cof F,   A := A + p0 d(cof F)/dF,   cof F = det F F^-T
!>
!> with Q and A of the law (qsmpm_law). Stresses of points, laws and results are whole. What the rules of cut cells do
!> not integrate exactly is then the stress above -p0 alone, and not p0 itself.
module qsmpm_confinement
  use qsmpm_kinds, only: wp
  use qsmpm_tensor, only: cofactor, pack_gradient, unpack_gradient
  implicit none
  private

  public :: add_confinement

contains

  !> Add the force of the pressure to Q and, when it is there, its derivative to A.
  pure subroutine add_confinement(pressure, gradient, piola, tangent)
    !> p0, compression positive.
    real(wp), intent(in) :: pressure
    !> F and Q, packed (5 or 9).
    real(wp), intent(in) :: gradient(:)
    real(wp), intent(inout) :: piola(:)
    !> (5 or 9, 5 or 9)
    real(wp), intent(inout), optional :: tangent(:, :)
    real(wp), dimension(size(gradient)) :: here, moved, along
    integer :: j

    call pack_gradient(cofactor(unpack_gradient(gradient)), here)
    piola = piola + pressure*here
    if (.not. present(tangent)) return
    do j = 1, size(gradient)
      ! cof F is of second degree, and has none in a single component: the difference is the derivative.
      along = gradient
      along(j) = along(j) + 1.0_wp
      call pack_gradient(cofactor(unpack_gradient(along)), moved)
      tangent(:, j) = tangent(:, j) + pressure*(moved - here)
    end do
  end subroutine add_confinement
end module qsmpm_confinement
