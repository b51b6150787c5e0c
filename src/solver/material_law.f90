!> The law of a material of the deck: the one place that knows which card makes which law.
module qsmpm_material_law
  use qsmpm_analysis, only: material_type, method_type
  use qsmpm_error, only: error_type
  use qsmpm_law, only: law_type
  use qsmpm_law_factory, only: new_law
  use qsmpm_material_parameters, only: material_parameters_type
  implicit none
  private

  public :: make_material_law

contains

  !> Make the law of a material.
  subroutine make_material_law(material, method, dimension, law, error)
    !> What the deck says of it.
    type(material_type), intent(in) :: material
    !> Kinematics and rate.
    type(method_type), intent(in) :: method
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> The law, with its exact consistent tangent.
    class(law_type), allocatable, intent(out) :: law
    !> Set when a parameter is out of its range.
    type(error_type), allocatable, intent(out) :: error
    type(material_parameters_type) :: parameters

    parameters = material_parameters_type(young=material%young, poisson=material%poisson, &
      mohr_coulomb=material%mohr_coulomb, cohesion=material%cohesion, friction_angle=material%friction_angle, &
      dilatancy_angle=material%dilatancy_angle, tensile_strength=material%tensile_strength)
    call new_law(parameters, dimension, method%kinematics, method%rate, law, error)
  end subroutine make_material_law
end module qsmpm_material_law
