!> What the user says of a material, as plain data, and the check that it makes sense.
!>
!> Linear isotropic elasticity with, on request, Mohr-Coulomb strength and a tension cut-off.
!> Angles are in degrees, everything else in the deck's consistent units. The tables that the
!> stress update works with are built from this in qsmpm_elastic_model, qsmpm_mohr_coulomb_model and
!> qsmpm_softening_model.
module qsmpm_material_parameters
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_softening_parameters, only: softening_parameters_type, softening_error
  implicit none
  private

  public :: material_parameters_type, check_parameters

  !> Parameters of one material.
  type :: material_parameters_type
    !> Young's modulus, > 0.
    real(wp) :: young = 0.0_wp
    !> Poisson's ratio, above -1 and below 0.5.
    real(wp) :: poisson = 0.0_wp
    !> Whether the strength below bounds the stress.
    logical :: mohr_coulomb = .false.
    !> Cohesion, >= 0.
    real(wp) :: cohesion = 0.0_wp
    !> Friction angle in degrees, 0 up to below 90; 0 is Tresca.
    real(wp) :: friction_angle = 0.0_wp
    !> Dilatancy angle in degrees, 0 up to the friction angle.
    real(wp) :: dilatancy_angle = 0.0_wp
    !> Largest principal stress, >= 0; huge means no cut-off.
    real(wp) :: tensile_strength = huge(1.0_wp)
    !> How the strength falls with the plastic shear strain, if it does.
    type(softening_parameters_type) :: softening
  end type material_parameters_type

contains

  !> Refuse parameters that describe no material.
  pure subroutine check_parameters(parameters, error)
    type(material_parameters_type), intent(in) :: parameters
    !> Set when a parameter is out of its range; the message names it.
    type(error_type), allocatable, intent(out) :: error

    if (.not. (parameters%young > 0.0_wp)) then
      call fail(error, error_deck, 'Young''s modulus must be positive')
    else if (.not. (parameters%poisson > -1.0_wp .and. parameters%poisson < 0.5_wp)) then
      call fail(error, error_deck, 'Poisson''s ratio must lie above -1 and below 0.5')
    else if (parameters%mohr_coulomb) then
      call check_strength(parameters, error)
    end if
  end subroutine check_parameters

  !> Refuse strength parameters out of their range.
  pure subroutine check_strength(parameters, error)
    type(material_parameters_type), intent(in) :: parameters
    !> Set when a parameter is out of its range; the message names it.
    type(error_type), allocatable, intent(out) :: error

    associate (p => parameters)
      if (.not. p%cohesion >= 0.0_wp) then
        call fail(error, error_deck, 'cohesion must not be negative')
      else if (.not. (p%friction_angle >= 0.0_wp .and. p%friction_angle < 90.0_wp)) then
        call fail(error, error_deck, 'friction angle must lie from 0 to below 90 degrees')
      else if (.not. (p%dilatancy_angle >= 0.0_wp .and. p%dilatancy_angle <= p%friction_angle)) then
        call fail(error, error_deck, 'dilatancy angle must lie from 0 to the friction angle')
      else if (.not. p%tensile_strength >= 0.0_wp) then
        call fail(error, error_deck, 'tensile strength must not be negative')
      else if (.not. (p%cohesion > 0.0_wp .or. p%friction_angle > 0.0_wp)) then
        call fail(error, error_deck, 'cohesion and friction angle must not both be zero')
      else if (p%softening%given) then
        call check_softening(softening_error(p%softening, p%cohesion, p%friction_angle, p%dilatancy_angle), error)
      end if
    end associate
  end subroutine check_strength

  !> Fail where the parameters of softening are wrong.
  pure subroutine check_softening(sentence, error)
    !> What is wrong, empty for nothing.
    character(len=*), intent(in) :: sentence
    !> Set when there is one.
    type(error_type), allocatable, intent(inout) :: error

    if (len(sentence) > 0) call fail(error, error_deck, sentence)
  end subroutine check_softening
end module qsmpm_material_parameters
