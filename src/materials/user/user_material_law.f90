!> Makes the law of a material whose model is in a shared library, or of its placeholder where the library may not
!> be loaded.
module qsmpm_user_material_law
  use qsmpm_user_adapter, only: adapter_type, ask_stiffness, number_states
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type, status_ok
  use qsmpm_plugin, only: find_library
  use qsmpm_soil_model, only: soil_model_type, soil_increment_type, soil_response_type
  use qsmpm_soil_model_law, only: soil_model_law_type, make_soil_model_law
  use qsmpm_text, only: integer_text
  use qsmpm_udsm, only: udsm_type, make_udsm
  use qsmpm_umat, only: umat_type, make_umat
  use qsmpm_user_material, only: user_material_type, interface_udsm, interface_umat
  implicit none
  private

  public :: new_user_law

  !> Poisson's ratio and Young's modulus where the deck gives none.
  real(wp), parameter :: usual_poisson = 0.25_wp, any_young = 1.0_wp

  !> Placeholder for the model of a library that is not loaded: linear elasticity with the state variables and the
  !> stiffness of the deck. It is used to mesh, seed and plan a deck; no results may be computed with it.
  type, extends(soil_model_type) :: placeholder_model_type
    !> d stress / d strain (6,6).
    real(wp), private :: stiffness(6, 6) = 0.0_wp
  contains
    procedure :: start
    procedure :: update
  end type placeholder_model_type

contains

  !> Loads the model and makes its law.
  subroutine new_user_law(user, name, young, poisson, stress, dimension, law, error)
    type(user_material_type), intent(in) :: user
    !> Name of the material.
    character(len=*), intent(in) :: name
    !> Young's modulus and Poisson's ratio that scale the stabilisation, 0 for none.
    real(wp), intent(in) :: young, poisson
    !> Initial Cauchy stress of the material, or a representative one (6).
    real(wp), intent(in) :: stress(6)
    !> 2 or 3.
    integer, intent(in) :: dimension
    class(law_type), allocatable, intent(out) :: law
    !> error_user_material: reason for the failure.
    type(error_type), allocatable, intent(out) :: error
    class(adapter_type), allocatable :: adapter
    type(placeholder_model_type) :: placeholder_model

    if (user%loads) then
      call load_model(user, name, dimension, adapter, error)
      if (.not. allocated(error)) call ask_stiffness(adapter, young, poisson, stress, error)
      if (.not. allocated(error)) call adapt(adapter, name, dimension, law)
    else
      call find_library(user%library, error)
      if (.not. allocated(error)) call check_fit(user, huge(1), dimension, error)
      if (allocated(error)) return
      call make_placeholder_model(user, young, poisson, placeholder_model)
      call adapt(placeholder_model, name, dimension, law)
    end if
  end subroutine new_user_law

  !> Makes the law of a model.
  subroutine adapt(model, name, dimension, law)
    class(soil_model_type), intent(in) :: model
    !> Name of the material.
    character(len=*), intent(in) :: name
    !> 2 or 3.
    integer, intent(in) :: dimension
    class(law_type), allocatable, intent(out) :: law
    type(soil_model_law_type), allocatable :: soil

    allocate (soil)
    call make_soil_model_law(model, dimension, soil)
    soil%name = name
    call move_alloc(soil, law)
  end subroutine adapt

  !> Loads the library.
  subroutine load_model(user, name, dimension, adapter, error)
    type(user_material_type), intent(in) :: user
    !> Name of the material.
    character(len=*), intent(in) :: name
    !> 2 or 3.
    integer, intent(in) :: dimension
    class(adapter_type), allocatable, intent(out) :: adapter
    !> error_user_material: reason for the failure.
    type(error_type), allocatable, intent(out) :: error
    type(umat_type), allocatable :: umat
    type(udsm_type), allocatable :: udsm

    if (user%interface == interface_udsm) then
      allocate (udsm)
      call make_udsm(user, name, udsm, error)
      if (.not. allocated(error)) call check_fit(user, udsm%user%states, dimension, error)
      call move_alloc(udsm, adapter)
    else
      allocate (umat)
      call check_fit(user, max(0, user%states), dimension, error)
      if (.not. allocated(error)) call make_umat(user, name, umat, error)
      call move_alloc(umat, adapter)
    end if
  end subroutine load_model

  !> Checks that the description of the deck is consistent with the model.
  subroutine check_fit(user, states, dimension, error)
    type(user_material_type), intent(in) :: user
    !> State variables of the model; 2 or 3.
    integer, intent(in) :: states, dimension
    !> error_deck: reason for the rejection.
    type(error_type), allocatable, intent(out) :: error

    if (dimension == 3 .and. user%interface == interface_umat .and. user%components < 6) then
      call fail(error, error_deck, 'COMPONENTS=4 is for the plane, this model is one of space')
    else if (allocated(user%start)) then
      if (size(user%start) > states) call fail(error, error_deck, '*USER STATE has '// &
        integer_text(size(user%start))//' numbers, the model has '//integer_text(states)//' state variables')
    end if
  end subroutine check_fit

  !> Makes the placeholder for the model of a library.
  pure subroutine make_placeholder_model(user, young, poisson, model)
    !> Description of the library's model in the deck.
    type(user_material_type), intent(in) :: user
    !> Values of the deck's *ELASTIC, 0 if not given.
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

  !> Initialises the state with zeros.
  subroutine start(self, stress, state)
    class(placeholder_model_type), intent(in) :: self
    real(wp), intent(in) :: stress(6)
    real(wp), intent(out) :: state(:)

    state = 0.0_wp
  end subroutine start

  !> Updates a point by linear elasticity.
  subroutine update(self, increment, stress, state, response)
    class(placeholder_model_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    real(wp), intent(inout) :: stress(6), state(:)
    type(soil_response_type), intent(inout) :: response

    stress = stress + matmul(self%stiffness, increment%strain)
    response%tangent = self%stiffness
    response%status = status_ok
  end subroutine update
end module qsmpm_user_material_law
