!> A soil model of the program's own: isotropic elasticity in the strain increment.
module own_law
  use qsmpm, only: wp, soil_model_type, soil_increment_type, soil_response_type
  implicit none
  private

  public :: elastic_type

  !> Young's modulus and Poisson's ratio.
  type, extends(soil_model_type) :: elastic_type
    real(wp) :: young = 1.0_wp, poisson = 0.0_wp
  contains
    procedure :: start
    procedure :: update
  end type elastic_type

contains

  !> No state.
  subroutine start(self, stress, state)
    class(elastic_type), intent(in) :: self
    real(wp), intent(in) :: stress(6)
    real(wp), intent(out) :: state(:)

    associate (unused => self, unused_stress => stress)
    end associate
    state = 0.0_wp
  end subroutine start

  !> Hooke's law.
  subroutine update(self, increment, stress, state, response)
    class(elastic_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    real(wp), intent(inout) :: stress(6)
    real(wp), intent(inout) :: state(:)
    type(soil_response_type), intent(inout) :: response
    real(wp) :: lame, shear
    integer :: i

    associate (unused => state)
    end associate
    shear = self%young/(2.0_wp*(1.0_wp + self%poisson))
    lame = 2.0_wp*shear*self%poisson/(1.0_wp - 2.0_wp*self%poisson)
    response%tangent = 0.0_wp
    response%tangent(:3, :3) = lame
    do i = 1, 3
      response%tangent(i, i) = lame + 2.0_wp*shear
      response%tangent(i + 3, i + 3) = shear
    end do
    stress = stress + matmul(response%tangent, increment%strain)
  end subroutine update
end module own_law
