!> The factor of safety as a bracket: the largest factor F that a body has been found stable at and the smallest one at
!> which it was lost.
!>
!>   first     F = 1
!>   stable    F + dF next; dF grows by half where equilibrium was easily found, fourfold where F had been lost before
!>             but to 0.1 or F/10 at the most, and is F/10 at the least from F = 3 on where none was lost
!>   lost      dF/2 from the last stable F; below F = 1, where none is stable yet, dF less, twice as much each time
!>   between   never beyond the middle of the bracket
!>   end       bracket as narrow as the tolerance, stable at F = 10, or lost down to F = 0.1; after 100 stable factors
!>             without any of these what is known (qsmpm_safety_search)
!>
!> A factor that was lost and is passed all the same leaves the next one above it that was lost as the end of the
!> bracket.
!> That no equilibrium is found does not say that there is none: the lost end counts as known where the body gives way
!> there, moving on and on against a drag (qsmpm_safety_search).
!>
!> Soil that hardens, or of which that is not known, may find no equilibrium at a factor from afar that it finds from
!> near. Where the search is to make sure, the lost factor of a narrow bracket is tried again from the stable one, and
!> the search goes on where it holds.
module qsmpm_safety_bracket
  use qsmpm_kinds, only: wp
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_text, only: real_text
  implicit none
  private

  public :: bracket_type, next_factor, note_stable, note_lost, take_again, is_closed, bracket_text

  !> First dF, its growth, and the ends of the search.
  real(wp), parameter :: first_increment = 0.1_wp, growth = 1.5_wp, growth_when_passed = 4.0_wp, &
    growth_below = 2.0_wp
  !> Factor from which dF is at least this share of it.
  real(wp), parameter :: far_factor = 3.0_wp, least_share = 0.1_wp
  real(wp), parameter, public :: largest_factor = 10.0_wp, smallest_factor = 0.1_wp
  !> Round-off of a factor.
  real(wp), parameter :: rounding = 1.0e-9_wp
  !> Lost factors that are kept beside the smallest one.
  integer, parameter :: remembered = 6

  !> Where the search stands.
  type :: bracket_type
    !> Largest stable and smallest lost factor, 0 for none so far.
    real(wp) :: stable = 0.0_wp, lost = 0.0_wp
    !> dF
    real(wp) :: increment = first_increment
    !> The lost factor was tried from the stable one.
    logical :: from_stable = .false.
    !> The body was seen to give way at the lost factor.
    logical :: mechanism = .false.
    !> Lost factors above the smallest one, upwards, 0 for none.
    real(wp) :: lost_above(remembered) = 0.0_wp
  end type bracket_type

contains

  !> The factor to be tried, farther than the last stable one by the width that ends the search at the least: where
  !> factors that seemed lost turn out stable, one by one, the search goes on in such steps and ends.
  pure real(wp) function next_factor(bracket, tolerance) result(factor)
    type(bracket_type), intent(in) :: bracket
    !> Width of the bracket that ends the search.
    real(wp), intent(in) :: tolerance

    associate (b => bracket)
      if (is_closed(b, tolerance, .false.)) then
        factor = b%lost
      else if (b%stable > 0.0_wp) then
        factor = min(b%stable + max(b%increment, tolerance), largest_factor)
        if (b%lost > 0.0_wp) factor = min(factor, 0.5_wp*(b%stable + b%lost))
      else if (b%lost > 0.0_wp) then
        factor = max(b%lost - b%increment, smallest_factor)
      else
        factor = 1.0_wp
      end if
    end associate
  end function next_factor

  !> There is equilibrium at a factor.
  pure subroutine note_stable(factor, easy, bracket)
    real(wp), intent(in) :: factor
    !> It was found in few iterations.
    logical, intent(in) :: easy
    type(bracket_type), intent(inout) :: bracket

    if (bracket%lost > 0.0_wp .and. .not. bracket%lost > factor) then
      bracket%increment = min(growth_when_passed*bracket%increment, max(first_increment, least_share*factor))
    else if (easy .and. bracket%stable > 0.0_wp) then
      bracket%increment = growth*bracket%increment
    end if
    if (factor >= far_factor .and. .not. bracket%lost > 0.0_wp) bracket%increment = max(bracket%increment, &
      least_share*factor)
    bracket%stable = factor
    bracket%from_stable = .false.
    bracket%mechanism = .false.
    do while (bracket%lost > 0.0_wp .and. .not. bracket%lost > factor)
      bracket%lost = bracket%lost_above(1)
      bracket%lost_above = eoshift(bracket%lost_above, 1)
    end do
  end subroutine note_stable

  !> There is none.
  pure subroutine note_lost(factor, bracket)
    real(wp), intent(in) :: factor
    type(bracket_type), intent(inout) :: bracket

    if (bracket%stable > 0.0_wp) then
      bracket%increment = 0.5_wp*(factor - bracket%stable)
    else if (factor < 1.0_wp) then
      bracket%increment = growth_below*bracket%increment
    end if
    if (bracket%lost > factor) bracket%lost_above = [bracket%lost, bracket%lost_above(:remembered - 1)]
    bracket%lost = factor
    bracket%mechanism = .false.
    bracket%from_stable = bracket%stable > 0.0_wp
  end subroutine note_lost

  !> The last stable factor went too far: the next one is to lie at a share of the way from the one before.
  pure subroutine take_again(before, share, tolerance, bracket, again)
    !> The stable factor before the last one, 0 for none: F = 1 is not taken again.
    real(wp), intent(in) :: before
    real(wp), intent(in) :: share
    !> Two factors as near as this are not told apart.
    real(wp), intent(in) :: tolerance
    type(bracket_type), intent(inout) :: bracket
    logical, intent(out) :: again

    again = before > 0.0_wp .and. bracket%stable - before > tolerance*(1.0_wp + rounding)
    if (.not. again) return
    bracket%increment = max(share*(bracket%stable - before), tolerance)
    bracket%stable = before
    bracket%from_stable = .false.
  end subroutine take_again

  !> Whether the search has ended.
  pure logical function is_closed(bracket, tolerance, makes_sure)
    type(bracket_type), intent(in) :: bracket
    real(wp), intent(in) :: tolerance
    !> The lost factor counts only from the stable one.
    logical, intent(in) :: makes_sure

    associate (b => bracket)
      if (b%stable > 0.0_wp .and. b%lost > 0.0_wp) then
        is_closed = b%lost - b%stable <= tolerance*(1.0_wp + rounding) .and. (b%from_stable .or. .not. makes_sure)
      else
        is_closed = .not. b%stable < largest_factor .or. &
          (b%lost > 0.0_wp .and. .not. b%lost > smallest_factor*(1.0_wp + rounding))
      end if
    end associate
  end function is_closed

  !> The answer in words.
  pure function bracket_text(bracket) result(text)
    type(bracket_type), intent(in) :: bracket
    character(len=:), allocatable :: text

    associate (b => bracket)
      if (.not. b%stable > 0.0_wp) then
        text = 'no equilibrium down to a factor of '//real_text(smallest_factor)
      else if (b%lost > 0.0_wp .and. .not. b%mechanism) then
        text = 'factor of safety at least '//rounded_text(b%stable, 6)//' (stable); at '//rounded_text(b%lost, 6)// &
          ' no equilibrium was found'
      else if (b%lost > 0.0_wp) then
        text = 'factor of safety between '//rounded_text(b%stable, 6)//' (stable) and '// &
          rounded_text(b%lost, 6)//' (no equilibrium)'
      else
        text = 'factor of safety above '//rounded_text(b%stable, 6)
      end if
    end associate
  end function bracket_text
end module qsmpm_safety_bracket
