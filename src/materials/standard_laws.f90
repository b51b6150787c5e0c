!> The soil laws that a card of the deck gives, instead of elasticity and Mohr-Coulomb strength. A new law has its
!> parameters and its model in a file of models/ and one line here.
module qsmpm_standard_laws
  use qsmpm_cam_clay, only: cam_clay_parameters_type
  use qsmpm_drucker_prager, only: drucker_prager_parameters_type
  use qsmpm_hardening_soil, only: hardening_soil_parameters_type
  use qsmpm_hoek_brown, only: hoek_brown_parameters_type
  use qsmpm_law_parameters, only: law_parameters_slot_type
  use qsmpm_ngi_adp, only: ngi_adp_parameters_type
  use qsmpm_soft_soil_creep, only: soft_soil_creep_parameters_type
  implicit none
  private

  public :: standard_laws

contains

  !> All of them, with their default parameters.
  subroutine standard_laws(laws)
    type(law_parameters_slot_type), allocatable, intent(inout) :: laws(:)

    if (allocated(laws)) deallocate (laws)
    allocate (laws(6))
    allocate (laws(1)%parameters, source=cam_clay_parameters_type())
    allocate (laws(2)%parameters, source=hardening_soil_parameters_type())
    allocate (laws(3)%parameters, source=drucker_prager_parameters_type())
    allocate (laws(4)%parameters, source=hoek_brown_parameters_type())
    allocate (laws(5)%parameters, source=ngi_adp_parameters_type())
    allocate (laws(6)%parameters, source=soft_soil_creep_parameters_type())
  end subroutine standard_laws
end module qsmpm_standard_laws
