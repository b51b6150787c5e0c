!> Makes the law of a material from its parameters and the chosen kinematics.
module qsmpm_law_factory
  use qsmpm_error, only: error_type, fail, error_other
  use qsmpm_jaumann_increment, only: rate_paper, rate_midpoint, rate_paper_cauchy, rate_midpoint_cauchy
  use qsmpm_jaumann_law, only: jaumann_law_type, make_jaumann_law
  use qsmpm_law, only: law_type
  use qsmpm_logarithmic_law, only: logarithmic_law_type, make_logarithmic_law
  use qsmpm_material_parameters, only: material_parameters_type, check_parameters
  use qsmpm_principal_model, only: principal_model_type, make_principal_model
  implicit none
  private

  public :: new_law, rate_paper, rate_midpoint, rate_paper_cauchy, rate_midpoint_cauchy

  !> Kinematics, numbered as in the deck's description.
  integer, parameter, public :: kinematics_jaumann = 1, kinematics_logarithmic = 2

contains

  !> Law of a material.
  subroutine new_law(parameters, dimension, kinematics, rate, law, error)
    !> What the user said.
    type(material_parameters_type), intent(in) :: parameters
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> One of kinematics_*.
    integer, intent(in) :: kinematics
    !> One of rate_*; read by the Jaumann kinematics only.
    integer, intent(in) :: rate
    !> The law.
    class(law_type), allocatable, intent(out) :: law
    !> Set when a parameter is out of its range.
    type(error_type), allocatable, intent(out) :: error
    type(principal_model_type) :: model
    type(jaumann_law_type), allocatable :: jaumann
    type(logarithmic_law_type), allocatable :: logarithmic

    call check_parameters(parameters, error)
    if (allocated(error)) return
    if (dimension /= 2 .and. dimension /= 3) then
      call fail(error, error_other, 'a law is for two or three dimensions')
      return
    end if
    call make_principal_model(parameters, model)
    select case (kinematics)
    case (kinematics_jaumann)
      if (all(rate /= [rate_paper, rate_midpoint, rate_paper_cauchy, rate_midpoint_cauchy])) then
        call fail(error, error_other, 'unknown integration of the stress rate')
        return
      end if
      allocate (jaumann)
      call make_jaumann_law(model, dimension, rate, jaumann)
      call move_alloc(jaumann, law)
    case (kinematics_logarithmic)
      allocate (logarithmic)
      call make_logarithmic_law(model, dimension, logarithmic)
      call move_alloc(logarithmic, law)
    case default
      call fail(error, error_other, 'unknown kinematics')
    end select
  end subroutine new_law
end module qsmpm_law_factory
