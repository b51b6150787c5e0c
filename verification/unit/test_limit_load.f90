!> Compliance of steps, and the knee between the last two steps.
module test_limit_load
  use qsmpm_kinds, only: wp
  use qsmpm_limit_load, only: compliance_type, limit_load_type, add_compliance, compliance_of, &
    convert_compliances, note_accepted, note_left, note_refused, is_found, interpolate_knee, limit_loads, limit_text, &
    limit_report, relative_compliance, jump_note
  use testing, only: tests_type
  implicit none
  private

  public :: collect_limit_load

  real(wp), parameter :: rounding = 1.0e-14_wp

contains

  !> All tests.
  subroutine collect_limit_load(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('limit_load')
    call check_compliance(tests)
    call check_knee(tests)
    call check_plateau(tests)
    call check_words(tests)
  end subroutine collect_limit_load

  !> df . U over df . df, summed over the solves of a step.
  subroutine check_compliance(tests)
    type(tests_type), intent(inout) :: tests
    type(compliance_type) :: step

    call tests%close('without a load there is no compliance', compliance_of(step), 0.0_wp, 0.0_wp)
    call add_compliance(compliance_type(6.0_wp, 2.0_wp), step)
    call tests%close('it is the work over the square of the increment', compliance_of(step), 3.0_wp, rounding)
    call add_compliance(compliance_type(4.0_wp, 50.0_wp), step)
    call tests%close('a re-equilibration adds displacement, not load', compliance_of(step), 5.0_wp, rounding)
  end subroutine check_compliance

  !> What is remembered of steps, and interpolation.
  subroutine check_knee(tests)
    type(tests_type), intent(inout) :: tests
    type(limit_load_type) :: limit

    call tests%close('a phase begins without a compliance', relative_compliance(limit), 0.0_wp, 0.0_wp)
    call note_accepted(compliance_type(3.0_wp, 1.0_wp), 10.0_wp, 0.0_wp, 0.1_wp, limit)
    call note_accepted(compliance_type(12.0_wp, 1.0_wp), 10.0_wp, 0.2_wp, 0.4_wp, limit)
    call tests%close('the first step stays the reference', relative_compliance(limit), 4.0_wp, rounding)
    call note_refused(compliance_type(75.0_wp, 1.0_wp), 0.4_wp, 0.8_wp, limit)
    call tests%check('a load that was rejected is no limit load yet', .not. is_found(limit) .and. &
      all(abs(limit_loads(limit, 0.4_wp, 2.0_wp)) <= 0.0_wp))
    call interpolate_knee(10.0_wp, limit)
    ! Compliance 4 at 0.3 and 25 at 0.6: ten, their geometric mean, is in the middle.
    call tests%close('the knee is where the logarithm of the compliance says', limit%knee, 0.45_wp, rounding)
    call tests%check('and the limit load is found', is_found(limit))
    call tests%check('a jump over more than half of what is allowed is told: '//jump_note('push', limit, 10.0_wp), &
      index(jump_note('push', limit, 10.0_wp), 'accepted step is 4 times as compliant as the first one, the '// &
      'rejected one more than 10 times: such a jump') > 0)
    call tests%check('one from beyond half of it is none', len(jump_note('push', limit, 7.9_wp)) == 0 .and. &
      len(jump_note('push', limit, 8.1_wp)) > 0)
    call tests%close('without soft steps the plateau begins on the way to the refused one', limit%plateau, &
      0.3_wp + 0.3_wp*log(1.25_wp)/log(6.25_wp), rounding)
    limit%plateau = 0.2_wp
    call interpolate_knee(10.0_wp, limit)
    call tests%close('behind a soft step it stays', limit%plateau, 0.2_wp, 0.0_wp)
  end subroutine check_knee

  !> The plateau begins with the first of the soft steps in a row at the end.
  subroutine check_plateau(tests)
    type(tests_type), intent(inout) :: tests
    type(limit_load_type) :: limit
    real(wp), parameter :: compliance(7) = [1.0_wp, 6.0_wp, 4.9_wp, 5.1_wp, 7.0_wp, 9.0_wp, 8.0_wp]
    integer :: i

    do i = 1, size(compliance)
      call note_accepted(compliance_type(compliance(i), 1.0_wp), 10.0_wp, 0.1_wp*(i - 1), 0.1_wp*i, limit)
    end do
    ! Compliance 4.9 at 0.25 and 5.1 at 0.35.
    call tests%close('half of what is allowed is soft, a stiff step begins anew', limit%plateau, 0.25_wp + &
      0.1_wp*log(5.0_wp/4.9_wp)/log(5.1_wp/4.9_wp), rounding)
    call tests%close('the most compliant step is remembered', limit%most, 9.0_wp, rounding)
    call tests%close('none has been ten times as soft as the first', limit%passed, 0.0_wp, 0.0_wp)
    call note_accepted(compliance_type(8.0_wp, 1.0_wp), 0.0_wp, 0.7_wp, 0.8_wp, limit)
    call tests%close('there is none where no limit load is looked for', limit%plateau, 0.0_wp, 0.0_wp)
    call note_accepted(compliance_type(12.5_wp, 1.0_wp), 0.0_wp, 0.8_wp, 0.9_wp, limit)
    ! Compliance 8 at 0.75 and 12.5 at 0.85: ten, their geometric mean, is in the middle.
    call tests%close('failure is where the logarithm of the compliance says', limit%passed, 0.8_wp, rounding)
    call note_accepted(compliance_type(2.0_wp, 1.0_wp), 0.0_wp, 0.82_wp, 0.86_wp, limit)
    call note_accepted(compliance_type(50.0_wp, 1.0_wp), 0.0_wp, 0.86_wp, 0.90_wp, limit)
    ! Compliance 2 at 0.84 and 50 at 0.88: ten is at their geometric mean.
    call tests%close('twenty times is the better estimate', limit%passed, 0.84_wp + 0.04_wp*log(10.0_wp)/ &
      log(25.0_wp), rounding)
    call note_accepted(compliance_type(2.0_wp, 1.0_wp), 0.0_wp, 1.0_wp, 1.02_wp, limit)
    call note_accepted(compliance_type(60.0_wp, 1.0_wp), 0.0_wp, 1.02_wp, 1.04_wp, limit)
    call tests%close('and stays where it was first passed', limit%passed, 0.84_wp + 0.04_wp*log(10.0_wp)/ &
      log(25.0_wp), rounding)
    limit%most = 8.0_wp
    limit%last = 8.0_wp
    limit%passed = 0.0_wp
    call note_left(0.5_wp, limit)
    call tests%close('a soft mesh that finds no equilibrium has failed with the soil', limit%passed, 0.5_wp, 0.0_wp)
    call note_accepted(compliance_type(60.0_wp, 1.0_wp), 0.0_wp, 1.0_wp, 1.02_wp, limit)
    call note_left(0.7_wp, limit)
    call tests%close('and what another mesh carries is no plateau', limit%passed, 0.5_wp, 0.0_wp)
    limit%passed = 0.0_wp
    limit%last = 1.9_wp
    call note_left(0.5_wp, limit)
    call tests%close('of one that is stiff the load is kept as a lower one', limit%passed, -0.5_wp, 0.0_wp)
    call note_accepted(compliance_type(9.0_wp, 1.0_wp), 0.0_wp, 1.02_wp, 1.04_wp, limit)
    call note_accepted(compliance_type(11.0_wp, 1.0_wp), 0.0_wp, 1.04_wp, 1.06_wp, limit)
    call tests%check('until the compliance shows failure', limit%passed > 1.0_wp)
    ! Soil that rebounds first.
    limit = limit_load_type()
    call note_accepted(compliance_type(-1.0_wp, 1.0_wp), 0.0_wp, 0.0_wp, 0.1_wp, limit)
    call note_accepted(compliance_type(1.0_wp, 1.0_wp), 0.0_wp, 0.1_wp, 0.2_wp, limit)
    call tests%close('a negative compliance is no reference', limit%passed, 0.0_wp, 0.0_wp)
    call note_accepted(compliance_type(-1.0_wp, 1.0_wp), 0.0_wp, 0.2_wp, 0.3_wp, limit)
    call note_accepted(compliance_type(12.0_wp, 1.0_wp), 0.0_wp, 0.3_wp, 0.4_wp, limit)
    call tests%close('nor a step to interpolate from', limit%passed, 0.0_wp, 0.0_wp)
    call note_accepted(compliance_type(12.0_wp, 1.0_wp), 0.0_wp, 0.4_wp, 0.5_wp, limit)
    call tests%close('failure is then before the next one', limit%passed, 0.35_wp, rounding)
    call check_other_nodes(tests)
  end subroutine check_plateau

  !> The same load on fewer nodes: the square of its increment is larger, its work is not.
  subroutine check_other_nodes(tests)
    type(tests_type), intent(inout) :: tests
    type(limit_load_type) :: limit

    call note_accepted(compliance_type(4.0_wp, 1.0_wp), 0.0_wp, 0.0_wp, 0.1_wp, limit)
    call note_accepted(compliance_type(8.0_wp, 1.0_wp), 0.0_wp, 0.1_wp, 0.2_wp, limit)
    call convert_compliances(compliance_type(12.0_wp, 0.5_wp), 0.05_wp, limit)
    call tests%close('on the same nodes compliances stay', limit%first, 4.0_wp, 0.0_wp)
    limit%square = -limit%square
    call convert_compliances(compliance_type(12.0_wp, 0.5_wp), 0.05_wp, limit)
    ! Half a step has a quarter of the square, 0.25, and here twice that.
    call tests%check('on others all are converted', all(abs([limit%first, limit%last, limit%most] - [2.0_wp, 4.0_wp, &
      4.0_wp]) <= rounding))
    call convert_compliances(compliance_type(12.0_wp, 5.0_wp), 0.05_wp, limit)
    call tests%close('once', limit%first, 2.0_wp, rounding)
  end subroutine check_other_nodes

  !> What is told.
  subroutine check_words(tests)
    type(tests_type), intent(inout) :: tests
    type(limit_load_type) :: limit
    real(wp) :: loads(4)

    limit%refused = 0.5_wp
    limit%knee = 1.0_wp/3.0_wp
    limit%plateau = 0.2_wp
    loads = limit_loads(limit, 0.25_wp, 80.0_wp)
    call tests%check('the loads are those carried and refused, the knee and the start of the plateau', &
      all(abs(loads - [20.0_wp, 40.0_wp, 80.0_wp/3.0_wp, 16.0_wp]) <= 1.0e-12_wp))
    call tests%check('in words: '//limit_report(loads), index(limit_report(loads), 'limit load 26.6667 of this grid '// &
      '(the knee), known to 90.0 %: its plateau begins at 16, the largest load carried is 20, no equilibrium at '// &
      '40, and the compliance grows without bound towards 40; `qsmpm-verify study') == 1)
    ! Inverses of 5 at 0.55 and of 10 at 0.6125: 0 at 0.675.
    call tests%check('a slowly growing compliance leaves the limit load as far above the knee as its plateau is below', &
      index(limit_report([0.625_wp, 0.625049_wp, 0.6125_wp, 0.55_wp]), 'known to 20.4 %: its plateau begins at 0.55, '// &
      'the largest load carried is 0.625, no equilibrium at 0.625049, and the compliance grows without bound towards 0.675;') > 0)
    call tests%check('in short', limit_text(loads) == 'limit load 26.6667')
    limit%plateau = 0.5_wp
    loads = limit_loads(limit, 0.25_wp, 80.0_wp)
    call tests%close('the knee is on the plateau', loads(4), 80.0_wp/3.0_wp, 1.0e-12_wp)
  end subroutine check_words
end module test_limit_load
