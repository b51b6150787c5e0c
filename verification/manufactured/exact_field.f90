!> Manufactured fields: a displacement chosen, its Cauchy stress and the body force that makes it an
!> equilibrium of Hencky's elastic law.
!>
!>   plane   u_i = a_i sin(2 pi X_i)                                unit square, rollers on all sides
!>   space   u_i = a_i sin(2 pi X_1) sin(2 pi X_2) sin(2 pi X_3)   unit cube, all faces held
!>
!>   F = I + du/dX,  tau = lambda tr(e) I + 2 mu e,  e = 1/2 ln(F F'),  P = tau F'^-1,  b = -Div P
!>
!> The divergence is taken by central differences of fourth order of the exact P: their error is below
!> 1e-8 of b and far below that of any run here.
module exact_field
  use qsmpm_kinds, only: wp, pi
  use qsmpm_spectral, only: spectral
  use qsmpm_tensor, only: cofactor, determinant
  use qsmpm_isotropic_function, only: compose
  implicit none
  private

  public :: field_type, displacement, cauchy, body_force

  !> A field of displacement and the elastic body it lives in.
  type :: field_type
    !> 2 or 3.
    integer :: dimension = 2
    !> Amplitudes at the end.
    real(wp) :: amplitude(3) = 0.0_wp
    real(wp) :: young = 1.0e4_wp, poisson = 0.3_wp
  end type field_type

contains

  !> Displacement of a point at a share of the amplitude.
  pure function displacement(field, x, share) result(u)
    !> The field.
    type(field_type), intent(in) :: field
    !> Initial position (3) and share of the amplitude.
    real(wp), intent(in) :: x(3), share
    real(wp) :: u(3)

    if (field%dimension == 2) then
      u = [sin(2.0_wp*pi*x(1:2)), 0.0_wp]
    else
      u = product(sin(2.0_wp*pi*x))
    end if
    u = share*field%amplitude*u
  end function displacement

  !> Deformation gradient.
  pure function gradient(field, x, share) result(f)
    !> The field.
    type(field_type), intent(in) :: field
    !> Initial position (3) and share of the amplitude.
    real(wp), intent(in) :: x(3), share
    real(wp) :: f(3, 3), slope(3)
    integer :: i, j

    f = 0.0_wp
    do j = 1, 3
      if (field%dimension == 2 .and. j < 3) f(j, j) = &
        share*field%amplitude(j)*2.0_wp*pi*cos(2.0_wp*pi*x(j))
      if (field%dimension == 2) cycle
      slope = sin(2.0_wp*pi*x)
      slope(j) = 2.0_wp*pi*cos(2.0_wp*pi*x(j))
      f(:, j) = share*field%amplitude*product(slope)
    end do
    do i = 1, 3
      f(i, i) = f(i, i) + 1.0_wp
    end do
  end function gradient

  !> Cauchy stress (3,3).
  pure function cauchy(field, x, share) result(stress)
    !> The field.
    type(field_type), intent(in) :: field
    !> Initial position (3) and share of the amplitude.
    real(wp), intent(in) :: x(3), share
    real(wp) :: stress(3, 3), f(3, 3)

    f = gradient(field, x, share)
    stress = kirchhoff(field, f)/determinant(f)
  end function cauchy

  !> Kirchhoff stress of Hencky's law.
  pure function kirchhoff(field, f) result(tau)
    !> The field.
    type(field_type), intent(in) :: field
    !> Deformation gradient.
    real(wp), intent(in) :: f(3, 3)
    real(wp) :: tau(3, 3), values(3), vectors(3, 3), strain(3), lame, shear

    call spectral(matmul(f, transpose(f)), values, vectors)
    strain = 0.5_wp*log(values)
    shear = 0.5_wp*field%young/(1.0_wp + field%poisson)
    lame = 2.0_wp*shear*field%poisson/(1.0_wp - 2.0_wp*field%poisson)
    tau = compose(lame*sum(strain) + 2.0_wp*shear*strain, vectors)
  end function kirchhoff

  !> Body force per initial volume.
  pure function body_force(field, x, share) result(b)
    !> The field.
    type(field_type), intent(in) :: field
    !> Initial position (3) and share of the amplitude.
    real(wp), intent(in) :: x(3), share
    real(wp) :: b(3), y(3, 4), p(3, 3)
    real(wp), parameter :: step = 2.0e-3_wp
    !> Central differences of fourth order at -2, -1, 1, 2 steps.
    real(wp), parameter :: place(4) = [-2.0_wp, -1.0_wp, 1.0_wp, 2.0_wp], &
      weight(4) = [1.0_wp, -8.0_wp, 8.0_wp, -1.0_wp]/12.0_wp
    integer :: j, k

    b = 0.0_wp
    do j = 1, field%dimension
      do k = 1, 4
        y(:, k) = x
        y(j, k) = x(j) + place(k)*step
        p = piola(field, y(:, k), share)
        b = b - weight(k)*p(:, j)/step
      end do
    end do
  end function body_force

  !> First Piola-Kirchhoff stress, tau F'^-1.
  pure function piola(field, x, share) result(p)
    !> The field.
    type(field_type), intent(in) :: field
    !> Initial position (3) and share of the amplitude.
    real(wp), intent(in) :: x(3), share
    real(wp) :: p(3, 3), f(3, 3)

    f = gradient(field, x, share)
    p = matmul(kirchhoff(field, f), cofactor(f))/determinant(f)
  end function piola
end module exact_field
