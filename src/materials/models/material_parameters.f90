!> Parameters of a material as plain data, and the check of their ranges.
!>
!> The material has linear isotropic elasticity and, optionally, Mohr-Coulomb strength and a tension cut-off.
!> Angles are in degrees, all other values in the deck's consistent units. The data of the stress
!> update are computed from these parameters in qsmpm_elastic_model, qsmpm_mohr_coulomb_model and
!> qsmpm_softening_model.
!>
!> The parameters of softening, with their check, define how the strength decreases from that of *MOHR COULOMB to a
!> residual strength with increasing plastic shear strain.
module qsmpm_material_parameters
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_deck
  implicit none
  private

  public :: material_parameters_type, check_parameters, softening_parameters_type, softening_error

  !> Softening curves, numbered as the choices of the keyword.
  integer, parameter, public :: softening_linear = 1, softening_exponential = 2
  !> Regularisation of the width of shear bands, numbered as the choices of the keyword.
  integer, parameter, public :: regularise_none = 1, regularise_cell = 2, regularise_nonlocal = 3

  !> Softening of a material.
  type :: softening_parameters_type
    !> Whether the strength softens.
    logical :: given = .false.
    !> One of softening_*.
    integer :: shape = softening_linear
    !> One of regularise_*.
    integer :: regularisation = regularise_cell
    !> Residual cohesion, from 0 to the peak value.
    real(wp) :: cohesion = 0.0_wp
    !> Residual friction angle in degrees, from 0 to the peak value.
    real(wp) :: friction_angle = 0.0_wp
    !> Residual dilatancy angle in degrees, from 0 to the peak value and to the residual friction angle.
    real(wp) :: dilatancy_angle = 0.0_wp
    !> Plastic shear strain at which the residual strength is reached; for exponential softening 95 % of the reduction.
    real(wp) :: strain = 0.0_wp
    !> Width of the shear band in which that strain was measured.
    real(wp) :: length = 0.0_wp
    !> Weight m of the nonlocal strain in the strain that softens; the local strain has the (negative) weight 1 - m.
    real(wp) :: over = 2.0_wp
  end type softening_parameters_type

  !> Parameters of one material.
  type :: material_parameters_type
    !> Young's modulus, > 0.
    real(wp) :: young = 0.0_wp
    !> Poisson's ratio, above -1 and below 0.5.
    real(wp) :: poisson = 0.0_wp
    !> Whether the stress is limited by the strength below.
    logical :: mohr_coulomb = .false.
    !> Cohesion, >= 0.
    real(wp) :: cohesion = 0.0_wp
    !> Friction angle in degrees, from 0 to less than 90; 0 is Tresca.
    real(wp) :: friction_angle = 0.0_wp
    !> Dilatancy angle in degrees, from 0 to the friction angle.
    real(wp) :: dilatancy_angle = 0.0_wp
    !> Largest admissible principal stress, >= 0; huge: no cut-off.
    real(wp) :: tensile_strength = huge(1.0_wp)
    !> Softening of the strength with the plastic shear strain.
    type(softening_parameters_type) :: softening
  end type material_parameters_type

contains

  !> Checks the elastic and strength parameters.
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

  !> Checks that the strength parameters are in their ranges.
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

  !> Sets the error where the parameters of softening are wrong.
  pure subroutine check_softening(sentence, error)
    !> Error message, empty for none.
    character(len=*), intent(in) :: sentence
    !> Set when there is a message.
    type(error_type), allocatable, intent(inout) :: error

    if (len(sentence) > 0) call fail(error, error_deck, sentence)
  end subroutine check_softening

  !> Error message for the parameters of softening, '' for none.
  pure function softening_error(softening, cohesion, friction_angle, dilatancy_angle) result(sentence)
    type(softening_parameters_type), intent(in) :: softening
    !> Cohesion, friction angle and dilatancy angle at the peak; degrees.
    real(wp), intent(in) :: cohesion, friction_angle, dilatancy_angle
    character(len=:), allocatable :: sentence

    sentence = ''
    associate (s => softening)
      if (.not. (s%cohesion >= 0.0_wp .and. s%cohesion <= cohesion)) then
        sentence = 'the residual cohesion must lie from 0 to the cohesion'
      else if (.not. (s%friction_angle >= 0.0_wp .and. s%friction_angle <= friction_angle)) then
        sentence = 'the residual friction angle must lie from 0 to the friction angle'
      else if (.not. (s%dilatancy_angle >= 0.0_wp .and. s%dilatancy_angle <= dilatancy_angle)) then
        sentence = 'the residual dilatancy angle must lie from 0 to the dilatancy angle'
      else if (s%dilatancy_angle > s%friction_angle) then
        sentence = 'the residual dilatancy angle is above the residual friction angle'
      else if (.not. (s%cohesion > 0.0_wp .or. s%friction_angle > 0.0_wp)) then
        sentence = 'residual cohesion and friction angle are both zero: no strength would be left'
      else if (.not. s%strain > 0.0_wp) then
        sentence = 'the plastic shear strain of the residual strength must be positive'
      else if (s%regularisation == regularise_cell .and. .not. s%length > 0.0_wp) then
        sentence = 'softening by cells needs the LENGTH in which its strain was measured'
      else if (s%regularisation == regularise_nonlocal .and. .not. s%length > 0.0_wp) then
        sentence = 'softening by a nonlocal strain needs the LENGTH in which its strain was measured'
      else if (s%regularisation == regularise_nonlocal .and. .not. s%over > 1.0_wp) then
        sentence = 'OVER must be above 1: strain localises in one cell at 1'
      end if
    end associate
  end function softening_error
end module qsmpm_material_parameters
