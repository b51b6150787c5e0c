!> Factor of safety as a bracket: the largest factor F at which a body is stable and the smallest one at which no
!> equilibrium is found ("lost").
!>
!>   first     F = 1
!>   stable    F + dF next; dF grows by half where equilibrium was easily found, fourfold where F had been lost before,
!>             up to at most 0.1 or F/10; it is at least F/10 from F = 3 on where none was lost
!>   lost      dF/2 from the last stable F; below F = 1, where none is stable yet, dF less, twice as much each time
!>   between   never beyond the midpoint of the bracket
!>   end       bracket as narrow as the tolerance, stable at F = 10, or lost down to F = 0.1; after 100 stable factors
!>             without any of these the bracket so far (qsmpm_safety_search)
!>
!> If a lost factor is exceeded by a stable one, the next lost factor above becomes the upper end of the bracket.
!> Failure to find an equilibrium does not show that there is none: the upper end is confirmed where the body fails
!> there, with a displacement that grows far beyond that of the last stable trial under a damping force that
!> remains (qsmpm_safety_search).
!>
!> For soil that hardens, or may harden, an equilibrium may be found from a close factor but not from a distant one.
!> Where the search must make sure, the lost factor of a narrow bracket is tried again from the stable one, and the
!> search continues if it is stable.
module qsmpm_safety_bracket
  use qsmpm_kinds, only: wp
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_text, only: real_text
  implicit none
  private

  public :: bracket_type, next_factor, note_stable, note_lost, take_again, is_closed, bracket_text

  !> First dF, its growth factors, and the bounds of the search.
  real(wp), parameter :: first_increment = 0.1_wp, growth = 1.5_wp, growth_when_passed = 4.0_wp, &
    growth_below = 2.0_wp
  !> Factor above which dF is at least the following share of it.
  real(wp), parameter :: far_factor = 3.0_wp, least_share = 0.1_wp
  real(wp), parameter, public :: largest_factor = 10.0_wp, smallest_factor = 0.1_wp
  !> Round-off of a factor.
  real(wp), parameter :: rounding = 1.0e-9_wp
  !> Number of lost factors stored in addition to the smallest one.
  integer, parameter :: remembered = 6

  !> State of the search.
  type :: bracket_type
    !> Largest stable and smallest lost factor, 0 if none so far.
    real(wp) :: stable = 0.0_wp, lost = 0.0_wp
    !> dF
    real(wp) :: increment = first_increment
    !> The lost factor was tried starting from the stable one.
    logical :: from_stable = .false.
    !> The body failed at the lost factor with a mechanism.
    logical :: mechanism = .false.
    !> Displacement of the last stable trial per increase of F; 0 for the first one.
    real(wp) :: compliance = 0.0_wp
    !> Lost factors above the smallest one, ascending, 0 for none.
    real(wp) :: lost_above(remembered) = 0.0_wp
  end type bracket_type

contains

  !> Returns the next factor to be tried. It exceeds the last stable one by at least the width that ends the search:
  !> where lost factors turn out stable one after the other, the search advances in such steps and ends.
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

  !> Records a factor with equilibrium.
  pure subroutine note_stable(factor, displacement, easy, bracket)
    !> F, and the displacement of the trial.
    real(wp), intent(in) :: factor, displacement
    !> The equilibrium was found in few iterations.
    logical, intent(in) :: easy
    type(bracket_type), intent(inout) :: bracket

    if (bracket%lost > 0.0_wp .and. .not. bracket%lost > factor) then
      bracket%increment = min(growth_when_passed*bracket%increment, max(first_increment, least_share*factor))
    else if (easy .and. bracket%stable > 0.0_wp) then
      bracket%increment = growth*bracket%increment
    end if
    if (factor >= far_factor .and. .not. bracket%lost > 0.0_wp) bracket%increment = max(bracket%increment, &
      least_share*factor)
    bracket%compliance = 0.0_wp
    if (bracket%stable > 0.0_wp .and. factor > bracket%stable) &
      bracket%compliance = displacement/(factor - bracket%stable)
    bracket%stable = factor
    bracket%from_stable = .false.
    bracket%mechanism = .false.
    do while (bracket%lost > 0.0_wp .and. .not. bracket%lost > factor)
      bracket%lost = bracket%lost_above(1)
      bracket%lost_above = eoshift(bracket%lost_above, 1)
    end do
  end subroutine note_stable

  !> Records a factor without equilibrium.
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

  !> Rejects the last stable factor as too large: the next one is planned at a share of the distance from the previous
  !> one.
  pure subroutine take_again(before, share, tolerance, bracket, again)
    !> The stable factor before the last one, 0 for none: F = 1 is not repeated.
    real(wp), intent(in) :: before
    real(wp), intent(in) :: share
    !> Factors closer than this are not distinguished.
    real(wp), intent(in) :: tolerance
    type(bracket_type), intent(inout) :: bracket
    logical, intent(out) :: again

    again = before > 0.0_wp .and. bracket%stable - before > tolerance*(1.0_wp + rounding)
    if (.not. again) return
    bracket%increment = max(share*(bracket%stable - before), tolerance)
    bracket%stable = before
    bracket%from_stable = .false.
  end subroutine take_again

  !> Returns whether the search has ended.
  pure logical function is_closed(bracket, tolerance, makes_sure)
    type(bracket_type), intent(in) :: bracket
    real(wp), intent(in) :: tolerance
    !> A lost factor counts only if it was tried from the stable one.
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

  !> Returns the result as text.
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
