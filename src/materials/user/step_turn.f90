!> Strain increment and rotation of a step, as passed to a soil model, and their derivative.
!>
!> G = (F - I) ((F + I)/2)^-1 is the displacement gradient on the mid configuration (Hughes and Winget 1980). Its
!> skew part rotates by R = R_h R_h, R_h the half rotation of qsmpm_jaumann_increment; R rotates the tensors at the
!> start to the frame at the end of the step. The strain increment is rotated to that frame, too, by R_h. All input of
!> a model is thus in one frame, a step is of second order, and an isotropic model responds as if
!> half of the rotation came before and half after the strain increment.
!>
!> The stress at the end is M(R s0 R^T, e) with e = R_h sym(G) R_h^T. When all tensors are rotated by a small w in
!> addition to R, the stress of an objective model is rotated with them; therefore
!>   d s = W s - s W + C : (R_h sym(dG) R_h^T + W' e - e W'),   W = dR R^T,  W' = dR_h R_h^T - W,
!> without the derivative of M with respect to the start. This is exact for models that rotate with their tensors,
!> isotropic or with tensors in their state which they rotate by R; for a model with directions fixed in space
!> it omits W (C : e) - (C : e) W - C : (W e - e W), which is of the order of the strain increment.
module qsmpm_step_turn
  use qsmpm_kinds, only: wp
  use qsmpm_jaumann_increment, only: half_rotation, rotation_jacobian, axial
  use qsmpm_jaumann_solid, only: spin_columns, by_gradient, product_of, full, contract, piola_tangent
  use qsmpm_tensor, only: cofactor, identity
  implicit none
  private

  public :: step_turn_type, make_step_turn, turned_stress, turned_strain, step_tangent

  !> Strain increment and rotation of a step of a point.
  type :: step_turn_type
    !> Half the axial vector of the skew part of G (3).
    real(wp) :: t(3) = 0.0_wp
    !> R_h and R (3,3).
    real(wp) :: half(3, 3) = identity
    real(wp) :: rotation(3, 3) = identity
    !> ((F + I)/2)^-1: dG = mid dF mid (3,3).
    real(wp) :: mid(3, 3) = identity
    !> Strain increment in the frame at the end, shear gamma (6).
    real(wp) :: strain(6) = 0.0_wp
  end type step_turn_type

contains

  !> Computes strain increment and rotation of a step.
  pure subroutine make_step_turn(f, turn, ok)
    !> Incremental deformation gradient (3,3).
    real(wp), intent(in) :: f(3, 3)
    type(step_turn_type), intent(out) :: turn
    !> False when the mid configuration is inverted.
    logical, intent(out) :: ok
    real(wp) :: a(3, 3), g(3, 3), det

    a = 0.5_wp*(f + identity)
    g = cofactor(a)
    det = dot_product(a(:, 1), g(:, 1))
    ok = det > 0.0_wp
    if (.not. ok) return
    turn%mid = transpose(g)*(1.0_wp/det)
    g = product_of(f - identity, turn%mid)
    turn%t = 0.5_wp*axial(g)
    turn%half = half_rotation(turn%t)
    turn%rotation = product_of(turn%half, turn%half)
    g = g + transpose(g)
    a = product_of(product_of(turn%half, g), transpose(turn%half))
    turn%strain = [0.5_wp*a(1, 1), 0.5_wp*a(2, 2), 0.5_wp*a(3, 3), a(1, 2), a(1, 3), a(2, 3)]
  end subroutine make_step_turn

  !> Stress at the start in the frame at the end.
  pure function turned_stress(turn, stress) result(turned)
    type(step_turn_type), intent(in) :: turn
    !> 11, 22, 33, 12, 13, 23.
    real(wp), intent(in) :: stress(6)
    real(wp) :: turned(6), a(3, 3)

    a = product_of(product_of(turn%rotation, full(stress)), transpose(turn%rotation))
    turned = [a(1, 1), a(2, 2), a(3, 3), a(1, 2), a(1, 3), a(2, 3)]
  end function turned_stress

  !> Strain at the start in the frame at the end.
  pure function turned_strain(turn, strain) result(turned)
    type(step_turn_type), intent(in) :: turn
    !> 11, 22, 33, 12, 13, 23, shear gamma.
    real(wp), intent(in) :: strain(6)
    real(wp) :: turned(6)

    turned = turned_stress(turn, [strain(1:3), 0.5_wp*strain(4:6)])
    turned(4:6) = 2.0_wp*turned(4:6)
  end function turned_strain

  !> Computes A = dQ/dF of a point.
  pure subroutine step_tangent(turn, stress, modulus, symmetric, inverse, det, a)
    type(step_turn_type), intent(in) :: turn
    !> Cauchy stress at the end (6); C = d stress / d strain (6,6).
    real(wp), intent(in) :: stress(6), modulus(6, 6)
    !> Whether to use the symmetric part of C, and its stress as J times the Cauchy stress: A is then symmetric at
    !> F = I, [K^E + K^G]^0 of the paper's eqs. 15-17.
    logical, intent(in) :: symmetric
    !> F^-1 and det(F).
    real(wp), intent(in) :: inverse(3, 3), det
    !> A (3,3,3,3).
    real(wp), intent(out) :: a(3, 3, 3, 3)
    real(wp) :: change(6, 3, 3), c(6, 6)
    integer :: i

    c = modulus
    if (symmetric) then
      c = 0.5_wp*(modulus + transpose(modulus))
      do i = 1, 3
        c(:, i) = c(:, i) - stress
      end do
    end if
    call by_gradient(c, change_by_spin(turn, full(stress), c), change)
    call contract(product_of(turn%half, turn%mid), product_of(turn%mid, transpose(turn%half)), change)
    call piola_tangent(full(stress), inverse, det, change, a)
  end subroutine step_tangent

  !> Change of the stress with half the axial vector of the rotated dG. With L of rotation_jacobian, dR_h R_h^T has the
  !> axial vector L R_h^T/2 times that of the rotated dG, W has that plus R_h times it, W' has minus R_h times it.
  pure function change_by_spin(turn, stress, c) result(columns)
    type(step_turn_type), intent(in) :: turn
    !> Cauchy stress at the end (3,3); d stress / d strain (6,6).
    real(wp), intent(in) :: stress(3, 3), c(6, 6)
    real(wp) :: columns(6, 3), after(3, 3), strain(6, 3), e(3, 3)
    integer :: i, j

    after = 0.5_wp*rotation_jacobian(turn%t)
    e = full([turn%strain(1:3), 0.5_wp*turn%strain(4:6)])
    strain = spin_columns(e, -after)
    strain(4:6, :) = 2.0_wp*strain(4:6, :)
    columns = spin_columns(stress, product_of(after, identity + transpose(turn%half)))
    do j = 1, 3
      do i = 1, 6
        columns(:, j) = columns(:, j) + c(:, i)*strain(i, j)
      end do
    end do
    columns = 0.5_wp*columns
  end function change_by_spin
end module qsmpm_step_turn
