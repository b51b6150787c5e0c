!> What the user says of softening, as plain data, and the check that it makes sense: strength falls from that of
!> *MOHR COULOMB to a residual one while the plastic shear strain grows.
module qsmpm_softening_parameters
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: softening_parameters_type, softening_error

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

contains

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
end module qsmpm_softening_parameters
