!> Tests of the stopwatch of the parts and of what is reported it: seconds are lost to no part, counts
!> are those of the work done, and the files hold them.
module test_run_profile
  use testing, only: tests_type
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_band_solver, only: make_band_solver
  use qsmpm_posix, only: peak_memory
  use qsmpm_profile_report, only: profile_json, profile_table, shares_line
  use qsmpm_run_profile, only: run_profile_type, count_evaluation, count_factorisation, count_iteration
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_stopwatch, only: clock_type, cpu_seconds, start_clock, wall_seconds, stopwatch_type, start_stopwatch, &
    switch_timer, part_control, part_evaluation, part_input, &
    part_output, part_solves
  implicit none
  private

  public :: collect_run_profile

contains

  !> All checks.
  subroutine collect_run_profile(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('run_profile')
    call test_stopwatch(tests)
    call test_silence(tests)
    call test_counts(tests)
    call test_report(tests)
    call test_memory(tests)
  end subroutine collect_run_profile

  !> Work of which the part is known is found there, and the parts add up to the whole.
  subroutine test_stopwatch(tests)
    type(tests_type), intent(inout) :: tests
    type(stopwatch_type) :: watch
    type(clock_type) :: clock
    real(wp) :: wall, cpu

    call start_clock(clock)
    call start_stopwatch(watch, part_input)
    call switch_timer(watch, part_evaluation)
    call work(0.02_wp)
    call switch_timer(watch, part_control)
    call switch_timer(watch, part_evaluation)
    call work(0.02_wp)
    call switch_timer(watch, part_evaluation)
    call switch_timer(watch, part_control)
    wall = wall_seconds(clock)
    cpu = cpu_seconds(clock)
    call tests%check('calls are counted, and staying is no call', watch%calls(part_evaluation) == 2 .and. &
      watch%calls(part_control) == 2 .and. watch%calls(part_input) == 1 .and. watch%calls(part_output) == 0)
    call tests%check('the processor seconds of the work are on its account', watch%cpu(part_evaluation) >= 0.04_wp)
    call tests%check('a part that was never turned to has no time', .not. watch%wall(part_output) > 0.0_wp)
    ! Between the two clocks lie a few readings; a process that is interrupted there loses at most some slices.
    call tests%close('the wall seconds of the parts are the whole', sum(watch%wall), wall, 0.2_wp)
    call tests%close('the processor seconds of the parts are the whole', sum(watch%cpu), cpu, 0.01_wp)
  end subroutine test_stopwatch

  !> Use the processor for some time.
  subroutine work(seconds)
    !> At least so long.
    real(wp), intent(in) :: seconds
    type(clock_type) :: clock

    call start_clock(clock)
    do while (cpu_seconds(clock) < seconds)
    end do
  end subroutine work

  !> Embedding programs need no stopwatch.
  subroutine test_silence(tests)
    type(tests_type), intent(inout) :: tests
    type(stopwatch_type) :: watch

    call switch_timer(watch, part_solves)
    call switch_timer(watch, part_control)
    call tests%check('a stopwatch that was not started takes no time', sum(watch%calls) == 0 .and. &
      .not. any(watch%wall > 0.0_wp))
  end subroutine test_silence

  !> Counts of a factorisation of a matrix whose operations are known.
  subroutine test_counts(tests)
    type(tests_type), intent(inout) :: tests
    type(run_profile_type) :: profile
    class(linear_solver_type), allocatable :: solver
    type(sparse_matrix_type) :: matrix
    type(error_type), allocatable :: error
    integer :: n

    n = 50
    call tridiagonal(n, matrix)
    call make_band_solver(.true., solver)
    call solver%analyse(matrix, error)
    call solver%factorise(matrix, error)
    call count_factorisation(profile, solver, size(matrix%values))
    call count_factorisation(profile, solver, size(matrix%values))
    call count_iteration(profile, 7)
    call count_iteration(profile, 9)
    call count_evaluation(profile, 11)
    call tests%check('factorisations are counted, sizes are the largest', profile%factorisations == 2 .and. &
      profile%matrix_entries == 3*n - 2 .and. profile%factor_entries == 2*n)
    ! A root, a division, a product and a difference an equation: 4; a count, so exact.
    call tests%close('operations of a tridiagonal Cholesky factorisation add up', profile%factor_operations, &
      8.0_wp*n, 0.0_wp)
    call tests%check('point-iterations follow the number of points', profile%iterations == 2 .and. &
      profile%point_iterations == 16)
    call tests%check('stress updates are counted', profile%evaluations == 1 .and. profile%stress_updates == 11)
    call solver%destroy()
  end subroutine test_counts

  !> The matrix -1, 4, -1.
  subroutine tridiagonal(n, matrix)
    !> Rows.
    integer, intent(in) :: n
    !> The matrix.
    type(sparse_matrix_type), intent(out) :: matrix
    integer :: i, j, k

    matrix%n = n
    allocate (matrix%row_first(n + 1), matrix%column(3*n - 2), matrix%values(3*n - 2))
    k = 0
    do i = 1, n
      matrix%row_first(i) = k + 1
      do j = max(1, i - 1), min(n, i + 1)
        k = k + 1
        matrix%column(k) = j
        matrix%values(k) = merge(4.0_wp, -1.0_wp, i == j)
      end do
    end do
    matrix%row_first(n + 1) = k + 1
  end subroutine tridiagonal

  !> The line of the log, the table, the file.
  subroutine test_report(tests)
    type(tests_type), intent(inout) :: tests
    type(run_profile_type) :: profile
    character(len=:), allocatable :: text

    profile%watch%cpu(part_evaluation) = 3.0_wp
    profile%watch%cpu(part_solves) = 1.0_wp
    profile%watch%cpu(part_output) = 0.004_wp
    profile%watch%wall(part_output) = 1.0_wp
    profile%iterations = 12
    profile%factor_operations = 2.5e9_wp
    profile%solver = 'CHOLMOD'
    text = shares_line(profile, 1)
    call tests%check('the log names the parts by size and leaves small ones out', &
      index(text, 'time: evaluation 75 %, solves 25 %; 4.00 s of processor, ') == 1)
    call tests%check('shares of several threads are of the wall clock', &
      index(shares_line(profile, 2), 'time: output 100 %; ') == 1)
    text = profile_table(profile, 1)
    call tests%check('the table has a line a part', index(text, 'evaluation'//repeat(' ', 13)//'3.000') > 0 .and. &
      index(text, '12 iterations') > 0)
    text = profile_json(profile, 1)
    call tests%check('the file holds the counts', index(text, '"iterations": 12,') > 0 .and. &
      index(text, '"factor_operations": 2.5e9,') > 0 .and. index(text, '"solver": "CHOLMOD"') > 0)
    call tests%check('the file holds the parts', index(text, '"evaluation": {"cpu_seconds": 3,') > 0)
  end subroutine test_report

  !> Memory that is used is seen.
  subroutine test_memory(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), allocatable :: room(:)
    real(wp) :: before, after

    before = real(peak_memory(), wp)
    allocate (room(20000000))
    room = 1.0_wp
    ! 160 MB; what other suites have freed before may be used again, but the mark never falls below what is in use.
    after = real(peak_memory(), wp)
    call tests%check('the peak of memory covers an array in use', sum(room) > 0.0_wp .and. &
      after >= max(before, 8.0_wp*size(room)))
  end subroutine test_memory
end module test_run_profile
