!> Soil models of the tests: linear hypoelasticity with or without a fibre, a modulus that grows with compression,
!> and one that refuses.
module soil_samples
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use qsmpm_jaumann_solid, only: product_of, full
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: status_cut, status_unrecoverable
  use qsmpm_soil_model, only: soil_model_type, soil_increment_type, soil_response_type
  use qsmpm_tensor, only: pack_symmetric
  implicit none
  private

  public :: hooke_type, refusing_type, hooke_matrix, make_hooke

  !> stress <- stress (1 + growth tr(e)) + (C + fibre m m') e, the fibre's tensor m being the state, turned by the
  !> step.
  type, extends(soil_model_type) :: hooke_type
    real(wp) :: young = 200.0_wp, poisson = 0.33_wp, fibre = 0.0_wp, growth = 0.0_wp
  contains
    procedure :: start => start_hooke
    procedure :: update => update_hooke
  end type hooke_type

  !> Answers with a status and a share, or with NaN.
  type, extends(soil_model_type) :: refusing_type
    integer :: status = status_cut
    real(wp) :: share = 0.0_wp
    !> By how much more the share is divided from one point to the next.
    real(wp) :: hurry = 0.0_wp
    logical :: nan = .false.
  contains
    procedure :: start => start_refusing
    procedure :: update => update_refusing
  end type refusing_type

contains

  !> A hypoelastic model.
  subroutine make_hooke(fibre, growth, model)
    !> Stiffness along the fibre, and growth of the stress with the volume strain.
    real(wp), intent(in) :: fibre
    real(wp), intent(in) :: growth
    type(hooke_type), intent(out) :: model

    model%fibre = fibre
    model%growth = growth
    model%state_count = 6
    model%stiffness_scale = model%young
    model%shear_scale = 0.5_wp*model%young/(1.0_wp + model%poisson)
    model%reads_strain = .true.
    model%reads_gradient = .true.
  end subroutine make_hooke

  !> Hooke's law for shear gamma.
  pure function hooke_matrix(young, poisson) result(c)
    real(wp), intent(in) :: young
    real(wp), intent(in) :: poisson
    real(wp) :: c(6, 6)
    integer :: i

    c = 0.0_wp
    c(1:3, 1:3) = young*poisson/((1.0_wp + poisson)*(1.0_wp - 2.0_wp*poisson))
    do i = 1, 3
      c(i, i) = c(i, i) + young/(1.0_wp + poisson)
      c(3 + i, 3 + i) = 0.5_wp*young/(1.0_wp + poisson)
    end do
  end function hooke_matrix

  !> The fibre along (2, 1, 2)/3.
  subroutine start_hooke(self, stress, state)
    class(hooke_type), intent(in) :: self
    real(wp), intent(in) :: stress(6)
    real(wp), intent(out) :: state(:)

    associate (unused => stress)
    end associate
    state(:self%state_count) = [4.0_wp, 1.0_wp, 4.0_wp, 2.0_wp, 4.0_wp, 2.0_wp]/9.0_wp
  end subroutine start_hooke

  !> One step.
  subroutine update_hooke(self, increment, stress, state, response)
    class(hooke_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    real(wp), intent(inout) :: stress(6)
    real(wp), intent(inout) :: state(:)
    type(soil_response_type), intent(inout) :: response
    real(wp) :: c(6, 6), m(3, 3)
    integer :: i

    m = product_of(product_of(increment%rotation, full(state(1:6))), transpose(increment%rotation))
    call pack_symmetric(m, state(1:6))
    c = hooke_matrix(self%young, self%poisson)
    do i = 1, 6
      c(:, i) = c(:, i) + self%fibre*state(1:6)*state(i)
    end do
    response%tangent = c
    do i = 1, 3
      response%tangent(:, i) = response%tangent(:, i) + self%growth*stress
    end do
    stress = stress*(1.0_wp + self%growth*sum(increment%strain(1:3))) + matmul(c, increment%strain)
  end subroutine update_hooke

  !> No state.
  subroutine start_refusing(self, stress, state)
    class(refusing_type), intent(in) :: self
    real(wp), intent(in) :: stress(6)
    real(wp), intent(out) :: state(:)

    associate (unused => stress, unused2 => self)
    end associate
    state = 0.0_wp
  end subroutine start_refusing

  !> No.
  subroutine update_refusing(self, increment, stress, state, response)
    class(refusing_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    real(wp), intent(inout) :: stress(6)
    real(wp), intent(inout) :: state(:)
    type(soil_response_type), intent(inout) :: response

    state = 0.0_wp
    response%tangent = hooke_matrix(1.0_wp, 0.0_wp)
    if (self%nan) then
      stress(2) = ieee_value(0.0_wp, ieee_quiet_nan)
      return
    end if
    response%status = self%status
    response%share = self%share/(1.0_wp + self%hurry*(increment%point - 1))
    if (self%status == status_unrecoverable) response%message = 'it is out of order'
  end subroutine update_refusing
end module soil_samples
