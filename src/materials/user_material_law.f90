!> Makes the law of a material whose model is in a shared library, or of what stands in for it where the library may not
!> be loaded.
module qsmpm_user_material_law
  use qsmpm_user_adapter, only: adapter_type, ask_stiffness
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type
  use qsmpm_plugin, only: find_library
  use qsmpm_soil_model, only: soil_model_type
  use qsmpm_placeholder_model, only: placeholder_model_type, make_placeholder_model
  use qsmpm_soil_model_law, only: soil_model_law_type, make_soil_model_law
  use qsmpm_text, only: integer_text
  use qsmpm_udsm, only: udsm_type, make_udsm
  use qsmpm_umat, only: umat_type, make_umat
  use qsmpm_user_material, only: user_material_type, interface_udsm, interface_umat
  implicit none
  private

  public :: new_user_law

contains

  !> Load the model and make a law of it.
  subroutine new_user_law(user, name, young, poisson, stress, dimension, law, error)
    !> What the user says.
    type(user_material_type), intent(in) :: user
    !> Name of the material.
    character(len=*), intent(in) :: name
    !> Young's modulus and Poisson's ratio that scale stabilisation, 0 for none.
    real(wp), intent(in) :: young
    real(wp), intent(in) :: poisson
    !> Cauchy stress that the material starts with, or one like it (6).
    real(wp), intent(in) :: stress(6)
    !> 2 or 3.
    integer, intent(in) :: dimension
    class(law_type), allocatable, intent(out) :: law
    !> error_user_material: why there is none.
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

  !> The law of a model.
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

  !> Load the library.
  subroutine load_model(user, name, dimension, adapter, error)
    !> What the user says.
    type(user_material_type), intent(in) :: user
    !> Name of the material.
    character(len=*), intent(in) :: name
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> The model.
    class(adapter_type), allocatable, intent(out) :: adapter
    !> error_user_material: why there is none.
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

  !> What the deck says fits the model.
  subroutine check_fit(user, states, dimension, error)
    !> What the user says.
    type(user_material_type), intent(in) :: user
    !> State variables of the model.
    integer, intent(in) :: states
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> error_deck: why not.
    type(error_type), allocatable, intent(out) :: error

    if (dimension == 3 .and. user%interface == interface_umat .and. user%components < 6) then
      call fail(error, error_deck, 'COMPONENTS=4 is for the plane, this model is one of space')
    else if (allocated(user%start)) then
      if (size(user%start) > states) call fail(error, error_deck, '*USER STATE has '// &
        integer_text(size(user%start))//' numbers, the model has '//integer_text(states)//' state variables')
    end if
  end subroutine check_fit
end module qsmpm_user_material_law
