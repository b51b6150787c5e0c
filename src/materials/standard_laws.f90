!> The soil laws that a card of the deck gives, instead of elasticity and Mohr-Coulomb strength. A new law has its
!> parameters and its model in a file of models/ and one line here.
module qsmpm_standard_laws
  use qsmpm_cam_clay, only: cam_clay_parameters_type
  use qsmpm_drucker_prager, only: drucker_prager_parameters_type
  use qsmpm_hardening_soil, only: hardening_soil_parameters_type
  use qsmpm_hoek_brown, only: hoek_brown_parameters_type
  use qsmpm_law_parameters, only: law_parameters_type, law_parameters_slot_type
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
    allocate (laws(0))
    call add(laws, cam_clay_parameters_type())
    call add(laws, hardening_soil_parameters_type())
    call add(laws, drucker_prager_parameters_type())
    call add(laws, hoek_brown_parameters_type())
    call add(laws, ngi_adp_parameters_type())
    call add(laws, soft_soil_creep_parameters_type())
  end subroutine standard_laws

  !> One more law.
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
end module qsmpm_standard_laws
