!> Tests of the driver of one point and of the check of its tangent, with laws that are made to misbehave: one gives
!> its elastic tangent where it yields, one asks for short steps, one breaks.
module test_point_driver
  use law_trials, only: strong, make_law
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type, error_not_converged, error_user_material
  use qsmpm_law, only: law_type, batch_type, status_cut, status_unrecoverable, tangent_none, tangent_elastic
  use qsmpm_law_factory, only: kinematics_logarithmic, rate_midpoint
  use qsmpm_point, only: bench_type, run_stages
  use qsmpm_point_table, only: parse_targets, unit_factor
  use qsmpm_point_statistics, only: tangent_text
  use qsmpm_point_test, only: driven_strain, driven_stress
  use qsmpm_tensor, only: gradient_size
  use testing, only: tests_type
  implicit none
  private

  public :: collect_point_driver

  !> A law with another inside, and how it misbehaves.
  type, extends(law_type) :: crude_law_type
    class(law_type), allocatable :: inner
    !> The tangent is the elastic one.
    logical :: elastic = .false.
    !> Largest component of f - 1 it takes, and the share it asks for.
    real(wp) :: longest = huge(1.0_wp)
    real(wp) :: share = 0.0_wp
    !> Largest component of f - 1 at which it works at all.
    real(wp) :: breaks_at = huge(1.0_wp)
  contains
    procedure :: start_at => crude_start
    procedure :: update => crude_update
    procedure :: fit_count => crude_count
    procedure :: to_fields => crude_to_fields
    procedure :: from_fields => crude_from_fields
  end type crude_law_type

  character(len=1), parameter :: newline = new_line('a')
  !> The slope's soil from 1 kPa all round to an axial strain of 0.1, long after it has yielded.
  character(len=*), parameter :: deck = '*MATERIAL, NAME=soil'//newline//'*ELASTIC'//newline//'200, 0.33'//newline// &
    '*POINT TEST, TYPE=TRIAXIAL DRAINED, CELL PRESSURE=1'//newline//'*POINT STAGE, STEPS=10'//newline// &
    'AXIAL STRAIN, 0.1'//newline

contains

  !> All tests.
  subroutine collect_point_driver(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('point_driver')
    call test_tangents(tests)
    call test_short_steps(tests)
    call test_broken_law(tests)
    call test_tables(tests)
  end subroutine collect_point_driver

  !> Run the deck with a misbehaving law.
  subroutine run_crude(law, bench, error)
    type(crude_law_type), intent(in) :: law
    type(bench_type), intent(out) :: bench
    type(error_type), allocatable, intent(out) :: error
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages

    allocate (analysis)
    call parse_deck('test.inp', deck, analysis, messages, error)
    if (allocated(error)) return
    allocate (bench%law, source=law)
    bench%tangent = .true.
    bench%log = ''
    call run_stages(analysis, bench, error)
  end subroutine run_crude

  !> A law around the Mohr-Coulomb one.
  subroutine make_crude(law)
    type(crude_law_type), intent(out) :: law

    call make_law(strong(0.0_wp, -1.0_wp), 3, kinematics_logarithmic, rate_midpoint, law%inner)
    law%dimension = 3
    law%state_count = law%inner%state_count
    law%stiffness_scale = law%inner%stiffness_scale
  end subroutine make_crude

  !> A right tangent is found right, an elastic one is found out.
  subroutine test_tangents(tests)
    type(tests_type), intent(inout) :: tests
    type(crude_law_type) :: law
    type(bench_type) :: bench
    type(error_type), allocatable :: error
    ! Strength of sigma_3 = 1, c = 1, phi = 25 by Mohr 1900, of Kirchhoff's stress: J differs from 1 by 1 %.
    real(wp), parameter :: strength = 2.46391_wp + 2.0_wp*1.56968_wp

    call make_crude(law)
    call run_crude(law, bench, error)
    call tests%check('a triaxial test runs', .not. allocated(error))
    call tests%check('every step has its tangent compared', sum(bench%statistics%compared) == 10)
    ! Differences over 1e-2 of the increment: 1e-5 at most.
    call tests%close('a consistent tangent is found right', maxval(bench%statistics%worst), 0.0_wp, 2.0e-5_wp)
    call tests%check('and is told to be', index(tangent_text(bench%statistics), 'it is consistent') > 0)
    call tests%close('the soil reaches its strength', -bench%point%stress(2), strength, 2.0e-2_wp*strength)
    law%elastic = .true.
    call run_crude(law, bench, error)
    call tests%check('a test with the elastic tangent runs', .not. allocated(error))
    call tests%check('its error is large where the soil yields', bench%statistics%worst(2) > 0.1_wp)
    call tests%check('and told to be that of the elastic tangent', &
      index(tangent_text(bench%statistics), 'it is the elastic one where the law yields') > 0)
    ! The equilibrium is the same, whatever the tangent: twice the tolerance of 1e-10.
    call tests%close('the strength is the same', -bench%point%stress(1), 1.0_wp, 1.0e-8_wp)
  end subroutine test_tangents

  !> A law that takes short steps gets them.
  subroutine test_short_steps(tests)
    type(tests_type), intent(inout) :: tests
    type(crude_law_type) :: law
    type(bench_type) :: bench, whole
    type(error_type), allocatable :: error

    call make_crude(law)
    call run_crude(law, whole, error)
    law%longest = 4.0e-3_wp
    law%share = 0.25_wp
    call run_crude(law, bench, error)
    call tests%check('a law that asks for short steps gets them', .not. allocated(error))
    call tests%check('the axial strain is that of the deck', abs(bench%point%deformation(2, 2) - 0.9_wp) < 1.0e-14_wp)
    ! The law is exact for steps along one direction; what differs is where in a step yielding begins.
    call tests%close('and the stress that of whole steps', bench%point%stress(2), whole%point%stress(2), 1.0e-3_wp)
    law%longest = 1.0e-9_wp
    call run_crude(law, bench, error)
    call tests%check('a law that takes no step ends the test', allocated(error))
    if (allocated(error)) call tests%check('as not converged, with its own words', &
      error%code == error_not_converged .and. index(error%message, 'too long for me') > 0)
  end subroutine test_short_steps

  !> A law that has failed ends the test at once.
  subroutine test_broken_law(tests)
    type(tests_type), intent(inout) :: tests
    type(crude_law_type) :: law
    type(bench_type) :: bench
    type(error_type), allocatable :: error

    call make_crude(law)
    law%breaks_at = 1.0e-3_wp
    call run_crude(law, bench, error)
    call tests%check('a broken law ends the test', allocated(error))
    if (.not. allocated(error)) return
    call tests%check('with the exit code of user materials', error%code == error_user_material)
    call tests%check('and its message', index(error%message, 'a parameter is missing') > 0)
    call tests%check('in the first step, which is not cut', bench%statistics%steps == 0 .and. &
      index(error%message, 'stage 1, step 1 ') == 1)
  end subroutine test_broken_law

  !> Tables of targets.
  subroutine test_tables(tests)
    type(tests_type), intent(inout) :: tests
    integer, allocatable :: driven_components(:)
    real(wp), allocatable :: targets(:, :), times(:)
    type(error_type), allocatable :: error

    call parse_targets('a.csv', 'time [s], s11 [MPa],E22 [%]'//achar(13)//newline//'0, -0.1, 2'//achar(13)//newline// &
      newline//'1, -0.2, 3', 'kN/m^2', driven_components, targets, times, error)
    call tests%check('a table is read', .not. allocated(error))
    if (allocated(error)) return
    call tests%check('its columns are found by name', all(driven_components == [driven_stress + 1, driven_strain + 2]))
    ! Products of two doubles: a few units of the last place.
    call tests%close('stresses come in the units of the deck', targets(1, 2), -200.0_wp, 1.0e-12_wp)
    call tests%close('strains in percent become numbers', targets(2, 1), 0.02_wp, 1.0e-16_wp)
    call tests%check('times are read', all(abs(times - [0.0_wp, 1.0_wp]) <= 0.0_wp))
    call tests%check('a unit of another kind is refused', .not. abs(unit_factor('kPa', .false., 'kPa')) > 0.0_wp)
    call parse_targets('a.csv', 'time,E22'//newline//'0,1'//newline//'2,2'//newline//'2,3', 'kPa', &
      driven_components, targets, times, error)
    call tests%check('a time that does not rise is refused', allocated(error))
    if (allocated(error)) call tests%check('with its line', index(error%message, 'a.csv:4: the time') == 1)
    call parse_targets('a.csv', 'time,E22'//newline//'-1,1', 'kPa', driven_components, targets, times, error)
    call tests%check('one before the stage too', allocated(error))
    call parse_targets('a.csv', 'E22'//newline//'1', 'kPa', driven_components, targets, times, error)
    call tests%check('a table may have no times', .not. allocated(error) .and. .not. allocated(times))
  end subroutine test_tables

  subroutine crude_start(self, stress, place, state)
    class(crude_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), place(3)
    real(wp), intent(out) :: state(:)

    call self%inner%start_at(stress, place, state)
  end subroutine crude_start

  subroutine crude_update(self, batch, tangent)
    class(crude_law_type), intent(in) :: self
    type(batch_type), intent(inout) :: batch
    integer, intent(in) :: tangent
    real(wp) :: change(gradient_size(3)), largest
    integer :: p

    call self%inner%update(batch, merge(tangent_elastic, tangent, self%elastic .and. tangent /= tangent_none))
    largest = 0.0_wp
    do p = 1, batch%count
      change = batch%gradient(:, p)
      change([1, 5, 9]) = change([1, 5, 9]) - 1.0_wp
      largest = max(largest, maxval(abs(change)))
    end do
    if (largest > self%longest) then
      batch%status = status_cut
      batch%share = self%share
      batch%message = 'this step is too long for me'
    end if
    if (largest > self%breaks_at) then
      batch%status = status_unrecoverable
      batch%message = 'a parameter is missing'
    end if
  end subroutine crude_update

  pure integer function crude_count(self)
    class(crude_law_type), intent(in) :: self

    crude_count = self%inner%fit_count()
  end function crude_count

  pure subroutine crude_to_fields(self, stress, state, fields)
    class(crude_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:)
    real(wp), intent(in) :: state(:)
    real(wp), intent(out) :: fields(:)

    call self%inner%to_fields(stress, state, fields)
  end subroutine crude_to_fields

  pure subroutine crude_from_fields(self, fields, volume_ratio, stress, state)
    class(crude_law_type), intent(in) :: self
    real(wp), intent(in) :: fields(:)
    real(wp), intent(in) :: volume_ratio
    real(wp), intent(out) :: stress(:)
    real(wp), intent(out) :: state(:)

    call self%inner%from_fields(fields, volume_ratio, stress, state)
  end subroutine crude_from_fields
end module test_point_driver
