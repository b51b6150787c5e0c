!> What leads one material point through a step: as many controls as the incremental deformation gradient f has packed
!> components, each a wanted value of
!>   a component of f, a sum of components of the whole gradient F = f F0, the volume ratio det F,
!>   or a sum of components of the Cauchy stress.
!> Here are the misfit of a control and its derivative with respect to f, for which the law's tangent A = dQ/df gives
!>   d(sigma) = (A:df f^T + Q df^T)/det f - sigma tr(df f^-1).
module qsmpm_point_control
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: batch_type
  use qsmpm_tensor, only: determinant, inverse, unpack_gradient, unpack_symmetric, gradient_row, gradient_column
  implicit none
  private

  public :: control_type, control_value, control_misfit, control_jacobian

  !> What is controlled.
  integer, parameter, public :: control_increment = 1, control_gradient = 2, control_volume = 3, control_stress = 4

  !> One control.
  type :: control_type
    integer :: kind = control_gradient
    !> Weights of the components in the order of packed gradients; a stress is that of the same row and column.
    real(wp) :: weight(9) = 0.0_wp
    !> Wanted at the end of the step.
    real(wp) :: value = 0.0_wp
  end type control_type

contains

  !> Present value of what is controlled.
  pure real(wp) function control_value(control, gradient, whole, stress) result(value)
    type(control_type), intent(in) :: control
    !> Incremental deformation gradient, packed (5 or 9).
    real(wp), intent(in) :: gradient(:)
    !> Deformation gradient at the end (3,3); Cauchy stress at the end (4 or 6).
    real(wp), intent(in) :: whole(3, 3), stress(:)
    real(wp) :: tensor(3, 3)
    integer :: i, d

    d = merge(3, 2, size(gradient) == 9)
    value = 0.0_wp
    select case (control%kind)
    case (control_increment)
      value = dot_product(control%weight(:size(gradient)), gradient)
    case (control_volume)
      value = determinant(whole)
    case default
      tensor = whole
      if (control%kind == control_stress) tensor = unpack_symmetric(stress)
      do i = 1, size(gradient)
        value = value + control%weight(i)*tensor(gradient_row(i, d), gradient_column(i, d))
      end do
    end select
  end function control_value

  !> Values less those wanted.
  pure subroutine control_misfit(controls, batch, start, misfit)
    !> The controls (5 or 9).
    type(control_type), intent(in) :: controls(:)
    !> The point, updated.
    type(batch_type), intent(in) :: batch
    !> Deformation gradient at the start of the step (3,3).
    real(wp), intent(in) :: start(3, 3)
    !> Misfits, each in the unit of its control.
    real(wp), intent(out) :: misfit(:)
    real(wp) :: f(3, 3), whole(3, 3)
    integer :: i

    f = unpack_gradient(batch%gradient(:, 1))
    whole = matmul(f, start)
    do i = 1, size(controls)
      misfit(i) = control_value(controls(i), batch%gradient(:, 1), whole, batch%stress(:, 1)) - controls(i)%value
    end do
  end subroutine control_misfit

  !> Derivatives of the values: (control, component of f).
  pure subroutine control_jacobian(controls, batch, start, jacobian)
    !> The controls (5 or 9).
    type(control_type), intent(in) :: controls(:)
    !> The point, updated with its consistent tangent.
    type(batch_type), intent(in) :: batch
    !> Deformation gradient at the start of the step (3,3).
    real(wp), intent(in) :: start(3, 3)
    !> The derivatives.
    real(wp), intent(out) :: jacobian(:, :)
    real(wp) :: f(3, 3), f_inverse(3, 3), weights(3, 3), change(3, 3), det, ratio
    integer :: i, j, k, l, d

    d = merge(3, 2, size(controls) == 9)
    f = unpack_gradient(batch%gradient(:, 1))
    det = determinant(f)
    f_inverse = inverse(f, det)
    ratio = det*determinant(start)
    do j = 1, size(controls)
      k = gradient_row(j, d)
      l = gradient_column(j, d)
      change = stress_change(batch, f, det, f_inverse, j, k, l)
      do i = 1, size(controls)
        weights = unpack_gradient(controls(i)%weight(:size(controls)))
        select case (controls(i)%kind)
        case (control_increment)
          jacobian(i, j) = controls(i)%weight(j)
        case (control_gradient)
          jacobian(i, j) = dot_product(weights(k, :), start(l, :))
        case (control_volume)
          jacobian(i, j) = ratio*f_inverse(l, k)
        case default
          jacobian(i, j) = sum(weights*change)
        end select
      end do
    end do
  end subroutine control_jacobian

  !> Derivative of the Cauchy stress with respect to component j of f, at row k and column l.
  pure function stress_change(batch, f, det, f_inverse, j, k, l) result(change)
    !> The point, updated with its consistent tangent.
    type(batch_type), intent(in) :: batch
    !> f, its determinant and its inverse.
    real(wp), intent(in) :: f(3, 3), det, f_inverse(3, 3)
    !> The component.
    integer, intent(in) :: j, k, l
    real(wp) :: change(3, 3), q(3, 3), dq(3, 3)

    q = unpack_gradient(batch%piola(:, 1))
    dq = unpack_gradient(batch%tangent(:, j, 1))
    change = matmul(dq, transpose(f))
    change(:, k) = change(:, k) + q(:, l)
    change = change/det - f_inverse(l, k)*unpack_symmetric(batch%stress(:, 1))
  end function stress_change
end module qsmpm_point_control
