!> Makes the laws of hardening soils from their parameters and the chosen kinematics.
module qsmpm_hardening_factory
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_cam_clay, only: cam_clay_type, make_cam_clay
  use qsmpm_hardening_parameters, only: cam_clay_parameters_type, hardening_soil_parameters_type, &
    check_cam_clay, check_hardening_soil
  use qsmpm_hardening_soil, only: hardening_soil_type, make_hardening_soil
  use qsmpm_isotropic_law, only: isotropic_law_type, make_isotropic_law
  use qsmpm_law, only: law_type
  implicit none
  private

  public :: new_hardening_law

contains

  !> Law of Modified Cam-Clay or of the hardening soil, whichever is given.
  subroutine new_hardening_law(clay, soil, dimension, logarithmic, paper_rate, law, error)
    !> What the user said of a clay.
    type(cam_clay_parameters_type), intent(in) :: clay
    !> What the user said of a soil.
    type(hardening_soil_parameters_type), intent(in) :: soil
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Logarithmic strain, else the Jaumann rate.
    logical, intent(in) :: logarithmic
    !> Whether the rate is to be integrated by the rule of the paper.
    logical, intent(in) :: paper_rate
    !> The law.
    class(law_type), allocatable, intent(out) :: law
    !> Set when a parameter is out of its range or the rule is not that of hardening soils.
    type(error_type), allocatable, intent(out) :: error
    type(cam_clay_type) :: clay_model
    type(hardening_soil_type) :: soil_model
    type(isotropic_law_type), allocatable :: isotropic

    if (.not. logarithmic .and. paper_rate) then
      call fail(error, error_deck, 'hardening soils have no RATE=PAPER: the rule is not objective and of first '// &
        'order; take RATE=MIDPOINT or KINEMATICS=LOGARITHMIC')
      return
    end if
    allocate (isotropic)
    if (clay%given) then
      call check_cam_clay(clay, error)
      if (allocated(error)) return
      call make_cam_clay(clay, clay_model)
      call make_isotropic_law(clay_model, dimension, logarithmic, isotropic)
    else
      call check_hardening_soil(soil, error)
      if (allocated(error)) return
      call make_hardening_soil(soil, soil_model, error)
      if (allocated(error)) return
      call make_isotropic_law(soil_model, dimension, logarithmic, isotropic)
    end if
    call move_alloc(isotropic, law)
  end subroutine new_hardening_law
end module qsmpm_hardening_factory
