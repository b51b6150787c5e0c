!> Constants of a law that are its strength, as the user names them: which of them a factor F divides, and how.
!>
!>   DIVIDE      c := c/F
!>   TAN         phi := atan(tan(phi)/F), degrees
!>   DILATANCY   psi := min(psi, the smallest lowered angle of TAN), degrees
!>
!> For laws that do not say it themselves: models of the user's, and those without a cohesion and an angle.
module qsmpm_strength_constants
  use qsmpm_kinds, only: wp
  use qsmpm_strength_factor, only: strength_factor_type, is_lowered, lower_strength
  implicit none
  private

  public :: strength_constant_type, lower_constants

  !> How a constant is lowered, and the words for it.
  integer, parameter, public :: divide_constant = 1, divide_tangent = 2, follow_friction = 3
  character(len=9), parameter, public :: lowering_words(3) = [character(len=9) :: 'DIVIDE', 'TAN', 'DILATANCY']

  !> Number of a constant, from 1, and one of the values above.
  type :: strength_constant_type
    integer :: number = 0
    integer :: rule = divide_constant
  end type strength_constant_type

contains

  !> Lower the constants that are named.
  pure subroutine lower_constants(named, by, constants)
    type(strength_constant_type), intent(in) :: named(:)
    type(strength_factor_type), intent(in) :: by
    !> In the order of the model.
    real(wp), intent(inout) :: constants(:)
    real(wp) :: least, nothing, none
    integer :: i

    if (.not. is_lowered(by)) return
    least = huge(least)
    do i = 1, size(named)
      associate (value => constants(named(i)%number))
        select case (named(i)%rule)
        case (divide_constant)
          value = value/by%factor
        case (divide_tangent)
          nothing = 0.0_wp
          none = 0.0_wp
          call lower_strength(strength_factor_type(by%factor), nothing, value, none)
          least = min(least, value)
        end select
      end associate
    end do
    do i = 1, size(named)
      if (named(i)%rule == follow_friction) constants(named(i)%number) = min(constants(named(i)%number), least)
    end do
  end subroutine lower_constants
end module qsmpm_strength_constants
