!> Stands in for the model of a shared library that is not loaded: linear elasticity with the state variables and the
!> stiffness that the deck tells. It serves to mesh, seed and plan a deck; nothing is to be computed with it.
module qsmpm_placeholder_model
  use qsmpm_user_adapter, only: number_states
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: status_ok
  use qsmpm_soil_model, only: soil_model_type, soil_increment_type, soil_response_type
  use qsmpm_user_material, only: user_material_type
  implicit none
  private

  public :: placeholder_model_type, make_placeholder_model

  !> Poisson's ratio where the deck has none, and Young's modulus.
  real(wp), parameter :: usual_poisson = 0.25_wp, any_young = 1.0_wp

  type, extends(soil_model_type) :: placeholder_model_type
    !> d stress / d strain (6,6).
    real(wp), private :: stiffness(6, 6) = 0.0_wp
  contains
    procedure :: start
    procedure :: update
  end type placeholder_model_type

contains

  !> A model in place of that of a library.
  pure subroutine make_placeholder_model(user, young, poisson, model)
    !> What the deck says of the library's.
    type(user_material_type), intent(in) :: user
    !> Of the deck's *ELASTIC, 0 without.
    real(wp), intent(in) :: young, poisson
    type(placeholder_model_type), intent(out) :: model
    real(wp) :: modulus, ratio
    integer :: i

    modulus = user%stiffness
    if (.not. modulus > 0.0_wp) modulus = young
    if (.not. modulus > 0.0_wp) modulus = any_young
    ratio = merge(poisson, usual_poisson, young > 0.0_wp)
    model%state_count = max(0, user%states)
    model%stiffness_scale = modulus
    model%shear_scale = 0.5_wp*modulus/(1.0_wp + ratio)
    model%symmetric = user%symmetric
    if (user%shows_state) call number_states(model%state_count, model%state_names)
    model%stiffness(1:3, 1:3) = 2.0_wp*model%shear_scale*ratio/(1.0_wp - 2.0_wp*ratio)
    do i = 1, 3
      model%stiffness(i, i) = model%stiffness(i, i) + 2.0_wp*model%shear_scale
      model%stiffness(i + 3, i + 3) = model%shear_scale
    end do
  end subroutine make_placeholder_model

  !> No state.
  subroutine start(self, stress, state)
    class(placeholder_model_type), intent(in) :: self
    real(wp), intent(in) :: stress(6)
    real(wp), intent(out) :: state(:)

    state = 0.0_wp
  end subroutine start

  !> Linear elasticity.
  subroutine update(self, increment, stress, state, response)
    class(placeholder_model_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    real(wp), intent(inout) :: stress(6)
    real(wp), intent(inout) :: state(:)
    type(soil_response_type), intent(inout) :: response

    stress = stress + matmul(self%stiffness, increment%strain)
    response%tangent = self%stiffness
    response%status = status_ok
  end subroutine update
end module qsmpm_placeholder_model
