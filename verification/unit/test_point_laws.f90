!> Point tests of the laws that harden and soften, led by decks: strength over the law's own state, the verdict on the
!> tangent, and the columns of the results.
module test_point_laws
  use deck_samples, only: joined
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp, pi
  use qsmpm_material_law, only: make_material_law
  use qsmpm_point, only: bench_type, run_stages
  use qsmpm_point_statistics, only: tangent_text
  use testing, only: tests_type
  implicit none
  private

  public :: collect_point_laws

  character(len=*), parameter :: sand = '*HARDENING SOIL| 3e4, 3e4, 9e4, 0.5, 0.2, 100, 1, 35, 5|'
  character(len=*), parameter :: brittle = '*ELASTIC| 5e4, 0.33|*MOHR COULOMB| 10, 30, 5|'

contains

  !> All tests.
  subroutine collect_point_laws(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('point_laws')
    call check_softening(tests, 'LINEAR', '0.01')
    call check_softening(tests, 'LINEAR', '0.2')
    call check_softening(tests, 'EXPONENTIAL', '0.03')
    call check_tips(tests)
    call check_columns(tests)
  end subroutine collect_point_laws

  !> Run a test with comparison of its tangents.
  subroutine run(text, bench)
    !> The deck, bars for ends of lines.
    character(len=*), intent(in) :: text
    type(bench_type), intent(out) :: bench
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('test.inp', joined(text), analysis, messages, error)
    if (.not. allocated(error)) call make_material_law(analysis%materials(1), analysis%method, &
      analysis%point_test%stress, &
      analysis%point_test%dimension, bench%law, error)
    bench%tangent = .true.
    bench%log = ''
    if (.not. allocated(error)) call run_stages(analysis, bench, error)
    if (allocated(error)) error stop 'a point test of the unit tests has no answer'
  end subroutine run

  !> A drained triaxial test ends on the strength of its plastic shear strain, with the width of the band.
  subroutine check_softening(tests, shape, strain)
    type(tests_type), intent(inout) :: tests
    !> TYPE of *SOFTENING, and the axial strain at the end.
    character(len=*), intent(in) :: shape, strain
    type(bench_type) :: bench
    real(wp) :: kappa, degree, cohesion, ratio
    character(len=:), allocatable :: name

    name = shape//' to '//strain
    call run('*METHOD, KINEMATICS=JAUMANN|*MATERIAL, NAME=m|'//brittle//'*SOFTENING, TYPE='//shape// &
      ', LENGTH=0.1| 1, 20, 0, 0.05|*POINT TEST, TYPE=TRIAXIAL DRAINED, CELL PRESSURE=100|*POINT STAGE, STEPS=40|'// &
      ' AXIAL STRAIN, '//strain//'|', bench)
    kappa = bench%point%state(bench%law%state_count)
    degree = min(1.0_wp, kappa/0.05_wp)
    if (shape == 'EXPONENTIAL') degree = 1.0_wp - exp(-3.0_wp*kappa/0.05_wp)
    cohesion = 10.0_wp - 9.0_wp*degree
    ratio = tan((45.0_wp + 0.5_wp*(30.0_wp - 10.0_wp*degree))*pi/180.0_wp)
    call tests%check(name//': the soil has softened', kappa > 0.005_wp)
    ! Equilibrium to 1e-10 of the stress, the strength of kappa to 1e-14: Mohr's circle.
    call tests%close(name//': the strength is that of its strain', -bench%point%stress(2), &
      100.0_wp*ratio**2 + 2.0_wp*cohesion*ratio, 1.0e-6_wp)
    call tests%check(name//': the tangent is told to be consistent', &
      index(tangent_text(bench%statistics), ': it is consistent') > 0)
  end subroutine check_softening

  !> Where a cone has its tip Q has no derivative, and nothing is said of the tangent: the shear surface of a sand that
  !> has only known isotropic stress, and the apex.
  subroutine check_tips(tests)
    type(tests_type), intent(inout) :: tests
    type(bench_type) :: bench

    call run('*MATERIAL, NAME=m|'//sand//'*POINT TEST, TYPE=ISOTROPIC, CELL PRESSURE=50|*POINT STAGE, STEPS=10|'// &
      ' PRESSURE, 200|', bench)
    call tests%check('isotropic compression of sand yields', bench%point%plastic)
    call tests%check('on the tip of its shear surface no tangent is judged', all(bench%statistics%compared == 0))
    call run('*MATERIAL, NAME=m|'//brittle//'*SOFTENING, REGULARISATION=NONE| 1, 20, 0, 0.05|'// &
      '*POINT TEST, TYPE=ISOTROPIC, CELL PRESSURE=50|*POINT STAGE, STEPS=10| VOLUMETRIC STRAIN, -0.05|', bench)
    call tests%check('isotropic extension yields at the apex', bench%point%plastic)
    ! Steps that barely leave the apex as it was have a derivative there.
    call tests%check('nor is one told to be wrong at the apex', index(tangent_text(bench%statistics), &
      'not consistent') == 0 &
      .and. bench%statistics%compared(2) < 10)
  end subroutine check_tips

  !> State variables with a name have a column, elastic strain and other things a law keeps have none.
  subroutine check_columns(tests)
    type(tests_type), intent(inout) :: tests
    type(bench_type) :: bench
    integer :: first, second, i, columns(2)

    call run('*MATERIAL, NAME=m|'//brittle//'*SOFTENING, REGULARISATION=NONE| 1, 20, 0, 0.05|*POINT TEST, '// &
      'TYPE=OEDOMETER|*POINT STAGE, STEPS=1| AXIAL STRAIN, 0.01|', bench)
    first = index(bench%curves%text, new_line('a'))
    second = first + index(bench%curves%text(first + 1:), new_line('a'))
    call tests%check('the last column is the named state', &
      index(bench%curves%text(:first), ',plastic_shear_strain'//new_line('a')) > 0)
    call tests%check('it is the only one of the state', index(bench%curves%text(:first), 'state_') == 0)
    columns = 0
    do i = 1, second
      if (bench%curves%text(i:i) == ',') columns(merge(1, 2, i <= first)) = columns(merge(1, 2, i <= first)) + 1
    end do
    call tests%check('rows have as many columns as the header', columns(1) == columns(2))
    call run('*MATERIAL, NAME=m|'//brittle//'*POINT TEST, TYPE=OEDOMETER, START TIME=5|*POINT STAGE, STEPS=2, TIME=3|'// &
      ' AXIAL STRAIN, 0.001|*POINT STAGE, STEPS=1| AXIAL STRAIN, 0.002|', bench)
    call tests%check('steps have their times', abs(time_of(1) - 5.0_wp) <= 0.0_wp .and. &
      abs(time_of(2) - 6.5_wp) <= 1.0e-12_wp .and. abs(time_of(4) - 9.0_wp) <= 1.0e-12_wp)

  contains

    !> The seventh column of a row.
    real(wp) function time_of(row) result(time)
      !> 1 for the start.
      integer, intent(in) :: row
      integer :: begin, k

      begin = 1
      do k = 1, row
        begin = begin + index(bench%curves%text(begin:), new_line('a'))
      end do
      do k = 1, 6
        begin = begin + index(bench%curves%text(begin:), ',')
      end do
      read (bench%curves%text(begin:begin + index(bench%curves%text(begin:), ',') - 2), *) time
    end function time_of
  end subroutine check_columns
end module test_point_laws
