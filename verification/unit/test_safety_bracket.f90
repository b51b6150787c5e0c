!> The rules of the search for a factor of safety, on scripted outcomes: a body that is stable below a factor, one that
!> never is, one that always is, and easy steps.
module test_safety_bracket
  use qsmpm_kinds, only: wp
  use qsmpm_safety_bracket, only: bracket_type, bracket_text, is_closed, next_factor, note_lost, note_stable, &
    take_again
  use testing, only: tests_type
  implicit none
  private

  public :: collect_safety_bracket

  real(wp), parameter :: rounding = 1.0e-12_wp

contains

  !> All tests.
  subroutine collect_safety_bracket(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('safety_bracket')
    call check_course(tests)
    call check_easy(tests)
    call check_below(tests)
    call check_ends(tests)
    call check_mistaken(tests)
    call check_brackets(tests)
    call check_again(tests)
    call check_sure(tests)
    call check_settled(tests)
    call check_text(tests)
  end subroutine collect_safety_bracket

  !> Try factors on a body that is stable up to one, and remember them.
  subroutine search(critical, tolerance, easy, bracket, tried, reach)
    real(wp), intent(in) :: critical, tolerance
    !> Every equilibrium is easily found.
    logical, intent(in) :: easy
    type(bracket_type), intent(out) :: bracket
    real(wp), allocatable, intent(out) :: tried(:)
    !> Largest step above F = 1 that finds equilibrium; any where it is not given.
    real(wp), intent(in), optional :: reach
    real(wp) :: factor, near

    near = huge(near)
    if (present(reach)) near = reach
    allocate (tried(0))
    do while (.not. is_closed(bracket, tolerance, near < huge(near)) .and. size(tried) < 100)
      factor = next_factor(bracket, tolerance)
      tried = [tried, factor]
      if (factor <= critical .and. (factor - bracket%stable <= near .or. .not. bracket%stable > 0.0_wp)) then
        call note_stable(factor, 0.0_wp, easy, bracket)
      else
        call note_lost(factor, bracket)
      end if
    end do
  end subroutine search

  !> Whether these factors were tried.
  pure logical function same(tried, wanted)
    real(wp), intent(in) :: tried(:), wanted(:)

    same = size(tried) == size(wanted)
    if (same) same = all(abs(tried - wanted) <= rounding)
  end function same

  !> Where every factor that seemed lost turns out stable the search goes on by its width at the least, and does not stand.
  subroutine check_settled(tests)
    type(tests_type), intent(inout) :: tests
    type(bracket_type) :: bracket
    real(wp), parameter :: width = 0.005_wp
    integer :: i

    call note_stable(1.0_wp, 0.0_wp, .false., bracket)
    do i = 1, 20
      call note_lost(next_factor(bracket, width), bracket)
      call note_stable(bracket%lost, 0.0_wp, .false., bracket)
    end do
    call tests%check('factors that are settled one by one lie apart by the width', &
      next_factor(bracket, width) - bracket%stable >= width*(1.0_wp - rounding))
  end subroutine check_settled

  !> Steps of 0.1, halved where equilibrium is lost.
  subroutine check_course(tests)
    type(tests_type), intent(inout) :: tests
    type(bracket_type) :: bracket
    real(wp), allocatable :: tried(:)

    call search(1.21_wp, 0.02_wp, .false., bracket, tried)
    call tests%check('from 1 by 0.1, and halves of it', same(tried, [1.0_wp, 1.1_wp, 1.2_wp, 1.3_wp, 1.25_wp, 1.225_wp, &
      1.2125_wp]))
    call tests%close('the last stable factor', bracket%stable, 1.2_wp, rounding)
    call tests%close('the first lost one', bracket%lost, 1.2125_wp, rounding)
    bracket = bracket_type()
    call note_lost(1.0_wp, bracket)
    call tests%check('lost from nothing is not lost from a stable one', .not. bracket%from_stable)
    call search(1.26_wp, 0.03_wp, .false., bracket, tried)
    call tests%check('never beyond the middle of the bracket', same(tried, [1.0_wp, 1.1_wp, 1.2_wp, 1.3_wp, 1.25_wp, &
      1.275_wp]))
  end subroutine check_course

  !> Easy steps grow by half, but for the one that only says that F = 1 is stable.
  subroutine check_easy(tests)
    type(tests_type), intent(inout) :: tests
    type(bracket_type) :: bracket
    real(wp), allocatable :: tried(:)

    call search(1.5_wp, 0.1_wp, .true., bracket, tried)
    call tests%check('easy steps grow', same(tried, [1.0_wp, 1.1_wp, 1.25_wp, 1.475_wp, 1.8125_wp, 1.64375_wp, &
      1.559375_wp]))
  end subroutine check_easy

  !> A body that is lost at F = 1.
  subroutine check_below(tests)
    type(tests_type), intent(inout) :: tests
    type(bracket_type) :: bracket
    real(wp), allocatable :: tried(:)

    call tests%close('never below 0.1', next_factor(bracket_type(0.0_wp, 0.15_wp, 0.1_wp), 0.005_wp), 0.1_wp, rounding)
    call search(0.83_wp, 0.03_wp, .false., bracket, tried)
    call tests%check('below 1 by 0.1 and twice as far each time, then up by halves', same(tried, [1.0_wp, 0.9_wp, 0.7_wp, &
      0.8_wp, 0.85_wp, 0.825_wp]))
    call tests%check('the bracket holds the factor', bracket%stable <= 0.83_wp .and. bracket%lost > 0.83_wp)
  end subroutine check_below

  !> Bodies that are never lost, or always.
  subroutine check_ends(tests)
    type(tests_type), intent(inout) :: tests
    type(bracket_type) :: bracket
    real(wp), allocatable :: tried(:)

    call search(huge(1.0_wp), 0.005_wp, .true., bracket, tried)
    call tests%check('the search ends at 10', abs(bracket%stable - 10.0_wp) <= 0.0_wp .and. .not. bracket%lost > 0.0_wp &
      .and. size(tried) < 20)
    call search(0.0_wp, 0.005_wp, .true., bracket, tried)
    call tests%check('and at 0.1', abs(bracket%lost - 0.1_wp) <= rounding .and. .not. bracket%stable > 0.0_wp .and. &
      size(tried) == 5)
  end subroutine check_ends

  !> A body that finds equilibrium from near alone: what was lost from afar is tried again from the stable factor.
  subroutine check_sure(tests)
    type(tests_type), intent(inout) :: tests
    type(bracket_type) :: bracket
    real(wp), allocatable :: tried(:)

    call search(1.171_wp, 0.03_wp, .false., bracket, tried, 0.06_wp)
    call tests%check('the lost factor of a narrow bracket is tried again and holds, the next one is lost', same(tried, &
      [1.0_wp, 1.1_wp, 1.05_wp, 1.075_wp, 1.1_wp, 1.21_wp, 1.155_wp, 1.1825_wp]))
    call tests%check('the bracket is that of the body', bracket%stable <= 1.171_wp .and. bracket%lost > 1.171_wp)
    call search(1.21_wp, 0.02_wp, .false., bracket, tried, 1.0_wp)
    call tests%check('nothing is tried twice where it was lost from the stable one', same(tried, [1.0_wp, 1.1_wp, &
      1.2_wp, 1.3_wp, 1.25_wp, 1.225_wp, 1.2125_wp]))
  end subroutine check_sure

  !> What was lost by mistake, between two that are stable, does not take the end of the bracket with it.
  subroutine check_mistaken(tests)
    type(tests_type), intent(inout) :: tests
    type(bracket_type) :: bracket
    integer :: i

    call note_stable(1.25_wp, 0.0_wp, .false., bracket)
    call note_lost(1.475_wp, bracket)
    call note_lost(1.3625_wp, bracket)
    call note_stable(1.3_wp, 0.0_wp, .false., bracket)
    call tests%close('the smallest lost factor is the end', bracket%lost, 1.3625_wp, rounding)
    bracket%mechanism = .true.
    call note_stable(1.31_wp, 0.0_wp, .false., bracket)
    call tests%check('a mechanism is shown anew after a factor that is stable', .not. bracket%mechanism)
    bracket%mechanism = .true.
    call note_lost(1.36_wp, bracket)
    call tests%check('and after one that is lost', .not. bracket%mechanism)
    call note_stable(1.36_wp, 0.0_wp, .false., bracket)
    call note_stable(1.4_wp, 0.0_wp, .false., bracket)
    call tests%close('that before it where a larger one is stable', bracket%lost, 1.475_wp, rounding)
    call note_stable(1.5_wp, 0.0_wp, .false., bracket)
    call tests%close('none where all are passed', bracket%lost, 0.0_wp, rounding)
    call note_lost(1.6_wp, bracket)
    call note_stable(1.7_wp, 0.0_wp, .false., bracket)
    call tests%close('and none that was passed before', bracket%lost, 0.0_wp, rounding)
    do i = 1, 5
      call note_lost(2.4_wp - 0.1_wp*i, bracket)
    end do
    call note_stable(1.95_wp, 0.0_wp, .false., bracket)
    call tests%close('one of several that were lost is passed', bracket%lost, 2.0_wp, rounding)
    call note_stable(2.15_wp, 0.0_wp, .false., bracket)
    call tests%close('two at once', bracket%lost, 2.2_wp, rounding)
    call note_stable(2.25_wp, 0.0_wp, .false., bracket)
    call tests%close('and so on', bracket%lost, 2.3_wp, rounding)
    bracket = bracket_type()
    call note_stable(1.25_wp, 0.3_wp, .false., bracket)
    call tests%close('the first stable factor has no increase to refer its displacement to', bracket%compliance, 0.0_wp, rounding)
    call note_stable(1.3_wp, 0.1_wp, .false., bracket)
    call tests%close('a displacement of 0.1 by an increase of 0.05', bracket%compliance, 2.0_wp, rounding)
  end subroutine check_mistaken

  !> Every body is bracketed as narrowly as is asked for.
  subroutine check_brackets(tests)
    type(tests_type), intent(inout) :: tests
    type(bracket_type) :: bracket
    real(wp), allocatable :: tried(:)
    real(wp) :: critical
    logical :: held, narrow
    integer :: i, most

    held = .true.
    narrow = .true.
    most = 0
    do i = 0, 400
      critical = 0.15_wp + 0.01_wp*i + 1.0e-4_wp*mod(7*i, 13)
      call search(critical, 0.005_wp, mod(i, 2) == 0, bracket, tried)
      held = held .and. bracket%stable <= critical .and. bracket%lost > critical
      narrow = narrow .and. bracket%lost - bracket%stable <= 0.005_wp*(1.0_wp + rounding)
      if (mod(i, 2) == 0) most = max(most, size(tried))
    end do
    call tests%check('brackets hold the factor', held)
    call tests%check('and are as narrow as the tolerance', narrow)
    call tests%check('in at most 18 tries where steps are easy', most <= 18)
  end subroutine check_brackets

  !> A factor that went past what its phase looks for is taken again, smaller.
  subroutine check_again(tests)
    type(tests_type), intent(inout) :: tests
    type(bracket_type) :: bracket
    real(wp) :: width
    logical :: again

    bracket = bracket_type(1.2_wp, 1.3_wp, 0.15_wp, from_stable=.true.)
    call take_again(1.1_wp, 0.4_wp, 0.005_wp, bracket, again)
    call tests%check('it is', again)
    call tests%check('the lost one was tried from the factor that is given up', .not. bracket%from_stable)
    call tests%close('from the factor before', bracket%stable, 1.1_wp, 0.0_wp)
    call tests%close('up to the share', next_factor(bracket, 0.005_wp), 1.14_wp, rounding)
    call tests%close('a lost one stays', bracket%lost, 1.3_wp, 0.0_wp)
    bracket = bracket_type(1.2_wp, 1.3_wp, 0.15_wp)
    call take_again(1.1_wp, 1.0e-3_wp, 0.005_wp, bracket, again)
    call tests%close('not by less than the tolerance', next_factor(bracket, 0.005_wp), 1.105_wp, rounding)
    bracket = bracket_type(1.205_wp, 1.3_wp, 0.15_wp)
    call take_again(1.2_wp, 0.5_wp, 0.005_wp, bracket, again)
    call tests%check('one as near as the tolerance stays', .not. again .and. abs(bracket%stable - 1.205_wp) <= 0.0_wp)
    bracket = bracket_type(1.25_wp, 1.3_wp, 0.15_wp)
    width = 0.25_wp/(1.0_wp + 1.0e-9_wp)
    call tests%close('a width that is that of the last step within its round-off', width*(1.0_wp + 1.0e-9_wp), 0.25_wp, 0.0_wp)
    call take_again(1.0_wp, 0.5_wp, width, bracket, again)
    call tests%check('is as near too', .not. again)
    bracket = bracket_type(1.0_wp, 0.0_wp, 0.1_wp)
    call take_again(0.0_wp, 0.5_wp, 0.005_wp, bracket, again)
    call tests%check('so does the first', .not. again .and. abs(bracket%stable - 1.0_wp) <= 0.0_wp)
  end subroutine check_again

  !> The answer in words.
  subroutine check_text(tests)
    type(tests_type), intent(inout) :: tests

    call tests%check('a bracket', bracket_text(bracket_type(1.2_wp, 1.25_wp, mechanism=.true.)) == &
      'factor of safety between 1.2 (stable) and 1.25 (no equilibrium)')
    call tests%check('one whose end is not known', bracket_text(bracket_type(1.2_wp, 1.25_wp)) == &
      'factor of safety at least 1.2 (stable); at 1.25 no equilibrium was found')
    call tests%check('in six digits', bracket_text(bracket_type(1.23456789_wp, 1.24000012_wp, mechanism=.true.)) == &
      'factor of safety between 1.23457 (stable) and 1.24 (no equilibrium)')
    call tests%check('both of them', bracket_text(bracket_type(1.2345678_wp, 1.2456789_wp, mechanism=.true.)) == &
      'factor of safety between 1.23457 (stable) and 1.24568 (no equilibrium)')
    call tests%check('and where the end is not known', bracket_text(bracket_type(1.2345678_wp, 1.2456789_wp)) == &
      'factor of safety at least 1.23457 (stable); at 1.24568 no equilibrium was found')
    call tests%check('none lost', bracket_text(bracket_type(10.0_wp, 0.0_wp)) == 'factor of safety above 10')
    call tests%check('in six digits too', bracket_text(bracket_type(1.23456789_wp, 0.0_wp)) == &
      'factor of safety above 1.23457')
    call tests%check('none stable', bracket_text(bracket_type(0.0_wp, 0.1_wp)) == &
      'no equilibrium down to a factor of 0.1')
  end subroutine check_text
end module test_safety_bracket
