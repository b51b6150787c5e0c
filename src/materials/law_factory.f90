!> Creates the law of given parameters: its model in the chosen kinematics.
!>
!> It also lists the soil laws that have a keyword and replace elasticity and Mohr-Coulomb strength. A new law has its
!> parameters and its model in a file of models/ and one line here.
module qsmpm_law_factory
  use qsmpm_elastic_model, only: elastic_model_type, set_moduli
  use qsmpm_error, only: error_type
  use qsmpm_jaumann_increment, only: rate_paper, rate_midpoint, rate_paper_cauchy, rate_midpoint_cauchy
  use qsmpm_law, only: law_type
  use qsmpm_law_parameters, only: law_parameters_type, law_parameters_slot_type
  use qsmpm_material_parameters, only: material_parameters_type, check_parameters
  use qsmpm_mohr_coulomb_model, only: mohr_coulomb_model_type, set_mohr_coulomb
  use qsmpm_principal_law, only: new_principal_law, kinematics_jaumann, kinematics_logarithmic
  use qsmpm_principal_model, only: principal_model_type
  use qsmpm_soil_model, only: soil_model_type
  use qsmpm_soil_model_law, only: soil_model_law_type, make_soil_model_law
  use qsmpm_softening_model, only: softening_model_type, set_softening
  use qsmpm_cam_clay, only: cam_clay_parameters_type
  use qsmpm_drucker_prager, only: drucker_prager_parameters_type
  use qsmpm_hardening_soil, only: hardening_soil_parameters_type
  use qsmpm_hoek_brown, only: hoek_brown_parameters_type
  use qsmpm_ngi_adp, only: ngi_adp_parameters_type
  use qsmpm_soft_soil_creep, only: soft_soil_creep_parameters_type
  implicit none
  private

  public :: new_law, rate_paper, rate_midpoint, rate_paper_cauchy, rate_midpoint_cauchy, kinematics_jaumann, &
    kinematics_logarithmic, standard_laws

  !> Makes the law of parameters in 2 or 3 dimensions, with one of kinematics_* and of rate_*; the rate is used by the
  !> Jaumann kinematics only. The error is set when a parameter is out of its range or the law does not exist.
  interface new_law
    module procedure :: new_elastic_law, new_soil_law
  end interface new_law

contains

  !> Makes linear elasticity, with Mohr-Coulomb strength and softening where they are given.
  subroutine new_elastic_law(parameters, dimension, kinematics, rate, law, error)
    type(material_parameters_type), intent(in) :: parameters
    integer, intent(in) :: dimension, kinematics, rate
    class(law_type), allocatable, intent(out) :: law
    type(error_type), allocatable, intent(out) :: error
    type(elastic_model_type) :: elastic
    type(mohr_coulomb_model_type) :: strong
    type(softening_model_type) :: softening

    call check_parameters(parameters, error)
    if (allocated(error)) return
    if (.not. parameters%mohr_coulomb) then
      call set_moduli(parameters, elastic)
      call new_principal_law(elastic, dimension, kinematics, rate, law, error)
    else if (.not. parameters%softening%given) then
      call set_mohr_coulomb(parameters, strong)
      call new_principal_law(strong, dimension, kinematics, rate, law, error)
    else
      call set_softening(parameters, softening)
      call new_principal_law(softening, dimension, kinematics, rate, law, error)
    end if
  end subroutine new_elastic_law

  !> Makes any law of `standard_laws`.
  subroutine new_soil_law(parameters, dimension, kinematics, rate, law, error)
    class(law_parameters_type), intent(in) :: parameters
    integer, intent(in) :: dimension, kinematics, rate
    class(law_type), allocatable, intent(out) :: law
    type(error_type), allocatable, intent(out) :: error
    class(principal_model_type), allocatable :: model
    class(soil_model_type), allocatable :: soil
    type(soil_model_law_type), allocatable :: made

    call parameters%make_soil_model(soil, error)
    if (allocated(soil)) then
      allocate (made)
      call make_soil_model_law(soil, dimension, made)
      made%of_user = .false.
      call move_alloc(made, law)
    else if (.not. allocated(error)) then
      call parameters%make_model(model, error)
      if (.not. allocated(error)) call new_principal_law(model, dimension, kinematics, rate, law, error)
    end if
  end subroutine new_soil_law

  !> Lists all soil laws, with their default parameters.
  subroutine standard_laws(laws)
    type(law_parameters_slot_type), allocatable, intent(inout) :: laws(:)

    if (allocated(laws)) deallocate (laws)
    allocate (laws(0))
    call add(laws, cam_clay_parameters_type())
    call add(laws, hardening_soil_parameters_type())
    call add(laws, drucker_prager_parameters_type())
    call add(laws, hoek_brown_parameters_type())
    call add(laws, ngi_adp_parameters_type())
    call add(laws, soft_soil_creep_parameters_type())
  end subroutine standard_laws

  !> Adds a law to the list.
  subroutine add(laws, parameters)
    type(law_parameters_slot_type), allocatable, intent(inout) :: laws(:)
    class(law_parameters_type), intent(in) :: parameters
    type(law_parameters_slot_type), allocatable :: more(:)
    integer :: i

    allocate (more(size(laws) + 1))
    do i = 1, size(laws)
      call move_alloc(laws(i)%parameters, more(i)%parameters)
    end do
    allocate (more(size(more))%parameters, source=parameters)
    call move_alloc(more, laws)
  end subroutine add
end module qsmpm_law_factory
