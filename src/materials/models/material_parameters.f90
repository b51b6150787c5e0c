!> What the user says of a material, as plain data, and the check that it makes sense.
!>
!> Linear isotropic elasticity with, on request, Mohr-Coulomb strength and a tension cut-off.
!> Angles are in degrees, everything else in the deck's consistent units. The tables that the
!> stress update works with are built from this in qsmpm_elastic_model, qsmpm_mohr_coulomb_model and
!> qsmpm_softening_model.
!>
!> What the user says of softening, as plain data, and the check that it makes sense: strength falls from that of
!> *MOHR COULOMB to a residual one while the plastic shear strain grows.
module qsmpm_material_parameters
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_deck
  implicit none
  private

  public :: material_parameters_type, check_parameters, softening_parameters_type, softening_error

  !> How the strength falls; numbered as the deck's words.
  integer, parameter, public :: softening_linear = 1, softening_exponential = 2
  !> How the width of a band of strain is brought in; numbered as the deck's words.
  integer, parameter, public :: regularise_none = 1, regularise_cell = 2, regularise_nonlocal = 3

  !> Softening of a material.
  type :: softening_parameters_type
    !> Whether the strength falls at all.
    logical :: given = .false.
    !> One of softening_*.
    integer :: shape = softening_linear
    !> One of regularise_*.
    integer :: regularisation = regularise_cell
    !> Residual cohesion, 0 up to the peak's.
    real(wp) :: cohesion = 0.0_wp
    !> Residual friction angle in degrees, 0 up to the peak's.
    real(wp) :: friction_angle = 0.0_wp
    !> Residual dilatancy angle in degrees, 0 up to the peak's and to the residual friction angle.
    real(wp) :: dilatancy_angle = 0.0_wp
    !> Plastic shear strain at which the residual strength is reached, of an exponential law 95 % of the way.
    real(wp) :: strain = 0.0_wp
    !> Width of the band in which that strain was measured.
    real(wp) :: length = 0.0_wp
    !> Share m of the nonlocal strain in the one that softens; 1 - m, below zero, is that of the point's own.
    real(wp) :: over = 2.0_wp
  end type softening_parameters_type

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

  !> What is wrong with softening, '' for nothing.
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
