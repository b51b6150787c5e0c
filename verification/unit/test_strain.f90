!> Strains of finite deformation against exact values, and strains that points carry through runs to a known stretch.
!>
!> Sources: simple shear, ln of the principal stretches (s/2 + (1 + s^2/4)^1/2)^+-1 (e.g. Ogden 1984); for the rest the
!> stretches themselves.
module test_strain
  use qsmpm, only: error_type, get_values, problem_type, simulation_type, value_shape
  use qsmpm_field_list, only: field_list_type
  use qsmpm_file, only: read_text, file_exists
  use qsmpm_kinds, only: wp
  use qsmpm_phase_start, only: start_phase
  use qsmpm_points, only: carries_strains, list_made_fields
  use qsmpm_isotropic_function, only: deform, logarithmic_strain, plastic_shear_increment, shear_strain, volume_strain
  use qsmpm_tensor, only: identity, pack_gradient, pack_symmetric
  use deck_samples, only: joined
  use scratch_folder, only: make_folder, remove_folder
  use testing, only: tests_type
  implicit none
  private

  public :: collect_strain

  !> Logarithms of stretches near 1 that are products of a few rounded numbers.
  real(wp), parameter :: rounding = 1.0e-14_wp

contains

  !> All tests of the suite.
  subroutine collect_strain(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('strain')
    call check_shear(tests)
    call check_stretches(tests)
    call check_turn(tests)
    call check_plastic(tests)
    call check_biaxial(tests)
    call check_sum(tests)
    call check_locking(tests)
    call check_not_carried(tests)
    call check_start(tests)
  end subroutine collect_strain

  !> Simple shear of any size, in one step and in three.
  subroutine check_shear(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: parts(3) = [0.2_wp, 1.5_wp, 0.7_wp]
    real(wp) :: b(4), once(4), strain(4), s, size
    integer :: i

    s = sum(parts)
    size = asinh(s/2.0_wp)
    b = [1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp]
    once = b
    do i = 1, 3
      call deform([1.0_wp, 0.0_wp, parts(i), 1.0_wp, 1.0_wp], b)
    end do
    call deform([1.0_wp, 0.0_wp, s, 1.0_wp, 1.0_wp], once)
    strain = logarithmic_strain(b)
    call tests%close('simple shear has no volume strain', volume_strain(strain), 0.0_wp, 10.0_wp*rounding)
    call tests%close('its shear strain is 2 asinh(s/2)', shear_strain(strain), 2.0_wp*size, 10.0_wp*rounding)
    ! The direction of the larger stretch: cos 2 theta = s/(4 + s^2)^1/2.
    call tests%close('its components turn with the larger stretch', maxval(abs(strain - [size*s, -size*s, 0.0_wp, &
      4.0_wp*size]/sqrt(4.0_wp + s*s))), 0.0_wp, 10.0_wp*rounding)
    call tests%close('steps make the whole', maxval(abs(strain - logarithmic_strain(once))), 0.0_wp, 10.0_wp*rounding)
  end subroutine check_shear

  !> Change of volume alone, and stretches along the axes.
  subroutine check_stretches(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: b(6), strain(6), f(9)

    b = [1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
    call pack_gradient(0.6_wp*identity, f)
    call deform(f, b)
    strain = logarithmic_strain(b)
    call tests%close('a change of volume has volume strain ln J', volume_strain(strain), 3.0_wp*log(0.6_wp), rounding)
    call tests%close('and no shear strain', shear_strain(strain), 0.0_wp, rounding)
    f([1, 5, 9]) = [1.25_wp, 0.8_wp, 1.0_wp]
    b = [1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
    call deform(f, b)
    strain = logarithmic_strain(b)
    call tests%close('stretches have their logarithms', maxval(abs(strain - [log(1.25_wp), log(0.8_wp), 0.0_wp, &
      0.0_wp, 0.0_wp, 0.0_wp])), 0.0_wp, rounding)
    call tests%close('pure shear by 1.25 has the shear strain 2 ln 1.25', shear_strain(strain), 2.0_wp*log(1.25_wp), &
      rounding)
  end subroutine check_stretches

  !> A rigid rotation has no strain, behind a stretch it changes no invariant.
  subroutine check_turn(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: b(6), strain(6), f(9), turn(3, 3), before(2)
    integer :: i

    turn = matmul(rotation(0.7_wp, 1), matmul(rotation(-1.1_wp, 2), rotation(2.3_wp, 3)))
    b = [1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
    call pack_gradient(turn, f)
    do i = 1, 5
      call deform(f, b)
    end do
    call tests%close('a rigid rotation has no strain', maxval(abs(logarithmic_strain(b))), 0.0_wp, rounding)
    call deform([1.2_wp, 0.1_wp, 0.0_wp, 0.3_wp, 0.7_wp, 0.2_wp, 0.0_wp, 0.4_wp, 1.1_wp], b)
    strain = logarithmic_strain(b)
    before = [volume_strain(strain), shear_strain(strain)]
    call deform(f, b)
    strain = logarithmic_strain(b)
    call tests%close('it changes neither volume nor shear strain', maxval(abs([volume_strain(strain), &
      shear_strain(strain)] - before)), 0.0_wp, 10.0_wp*rounding)
  end subroutine check_turn

  !> Rotation about an axis.
  pure function rotation(angle, axis) result(turn)
    real(wp), intent(in) :: angle
    integer, intent(in) :: axis
    real(wp) :: turn(3, 3)
    integer :: i, j

    i = 1 + mod(axis, 3)
    j = 1 + mod(axis + 1, 3)
    turn = identity
    turn([i, j], i) = [cos(angle), sin(angle)]
    turn([i, j], j) = [-sin(angle), cos(angle)]
  end function rotation

  !> The plastic part of a step: none where the stress follows elastically, all where the stress stays.
  subroutine check_plastic(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: shear_modulus = 500.0_wp, compliance(2) = 0.5_wp/shear_modulus, &
      start(6) = [-3.0_wp, -1.0_wp, -2.0_wp, 0.5_wp, 0.3_wp, -0.2_wp]
    real(wp) :: turn(3, 3), stretch(3, 3), stress(3, 3), f(9), turned(6), elastic(6)

    turn = rotation(0.3_wp, 3)
    stretch = identity
    stretch(1, 1) = 1.1_wp
    stretch(2, 2) = 0.95_wp
    call pack_gradient(matmul(stretch, turn), f)
    stress = reshape([start(1), start(4), start(5), start(4), start(2), start(6), start(5), start(6), start(3)], [3, 3])
    stress = matmul(matmul(turn, stress), transpose(turn))
    call pack_symmetric(stress, turned)
    stress = stress + 2.0_wp*shear_modulus*reshape([log(1.1_wp), 0.0_wp, 0.0_wp, 0.0_wp, log(0.95_wp), 0.0_wp, 0.0_wp, &
      0.0_wp, 0.0_wp], [3, 3]) + 7.0_wp*identity
    call pack_symmetric(stress, elastic)
    call tests%close('an elastic step has no plastic strain', plastic_shear_increment(f, start, elastic, &
      compliance), 0.0_wp, rounding)
    call tests%close('where the stress only turns all strain is plastic', plastic_shear_increment(f, start, turned, &
      compliance), shear_strain([log(1.1_wp), log(0.95_wp), 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]), rounding)
  end subroutine check_plastic

  !> A block that fills its mesh, in two phases, the second of which starts from no displacement.
  function block(material, more) result(text)
    !> Cards below *MATERIAL, and cards before the phases.
    character(len=*), intent(in) :: material, more
    character(len=:), allocatable :: text

    text = joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 1, 2|Y, 0, 1, 2|*MATERIAL, NAME=soil|'// &
      material//'|*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 1|*NSET, NSET=base, PLANE=Y|0|'// &
      '*NSET, NSET=top, PLANE=Y|1|*NSET, NSET=left, PLANE=X|0|*NSET, NSET=right, PLANE=X|1|'//more//'|'// &
      '*PHASE, NAME=stretch|*FIX|base, Y|left, X|*PRESCRIBE|top, Y, -0.3|right, X, 0.1|'// &
      '*CONTROLS, STEPS=6, TOLERANCE=1E-10|*END PHASE|')
  end function block

  !> Run a deck to its end.
  subroutine run_deck(tests, text, run)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: text
    type(simulation_type), intent(inout) :: run
    class(problem_type), allocatable :: problem
    type(error_type), allocatable :: error

    allocate (problem)
    call problem%parse(text, 'block', error)
    if (.not. allocated(error)) call run%create(problem, error)
    if (.not. allocated(error)) call run%run(error)
    call tests%check('a block is run', .not. allocated(error))
  end subroutine run_deck

  !> Largest distance of values from others.
  real(wp) function distance(run, name, expected)
    type(simulation_type), intent(in) :: run
    character(len=*), intent(in) :: name
    !> Values of one point.
    real(wp), intent(in) :: expected(:)
    real(wp), allocatable :: values(:)
    type(error_type), allocatable :: error
    integer :: rows, columns

    distance = huge(1.0_wp)
    call value_shape(run, name, rows, columns, error)
    if (allocated(error) .or. rows /= size(expected)) return
    allocate (values(rows*columns))
    call get_values(run, name, values, error)
    if (.not. allocated(error)) distance = maxval(abs(reshape(values, [rows, columns]) - spread(expected, 2, columns)))
  end function distance

  !> A biaxial run of six steps to the stretches 1.1 and 0.7; a second phase sets strains to zero and stretches on.
  subroutine check_biaxial(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    character(len=*), parameter :: on = '*PHASE, NAME=on|*RESET DISPLACEMENTS|*FIX|right, X|*PRESCRIBE|'// &
      'top, Y, -0.07|*CONTROLS, STEPS=2|*END PHASE|'
    real(wp), parameter :: volume = log(1.1_wp*0.7_wp), first = log(1.1_wp), second = log(0.7_wp)

    allocate (run)
    call run_deck(tests, block('*ELASTIC|1000, 0.3', '*METHOD, BASIS=FEM'), run)
    call tests%close('a biaxial run has the logarithms of its stretches', distance(run, 'point_strain', [first, &
      second, 0.0_wp, 0.0_wp]), 0.0_wp, 1.0e-9_wp)
    call tests%close('its volume strain is ln J', distance(run, 'point_volume_strain', [volume]), 0.0_wp, 1.0e-9_wp)
    call tests%close('its shear strain is the invariant', distance(run, 'point_shear_strain', &
      [shear_strain([first, second, 0.0_wp, 0.0_wp])]), 0.0_wp, 1.0e-9_wp)
    call tests%close('an elastic law has no plastic strain', distance(run, 'point_accumulated_plastic_shear_strain', &
      [0.0_wp]), 0.0_wp, 0.0_wp)
    call run%destroy()
    call run_deck(tests, block('*ELASTIC|1000, 0.3', '*METHOD, BASIS=FEM')//joined(on), run)
    call tests%close('strains are set to zero with displacements', distance(run, 'point_strain', [0.0_wp, &
      log(0.9_wp), 0.0_wp, 0.0_wp]), 0.0_wp, 1.0e-9_wp)
    call run%destroy()
  end subroutine check_biaxial

  !> The accumulated plastic shear strain is that of the softening law where strain counts once. Principal directions
  !> stay, so that the logarithmic law agrees to rounding; the Jaumann law has its strain from the middle of a step,
  !> and its plastic one by the stress at its end: as much as half the volume strain of a step apart, 3 %.
  subroutine check_sum(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: soil = '*ELASTIC|1000, 0.3|*MOHR COULOMB|10, 20, 5|'// &
      '*SOFTENING, TYPE=LINEAR, REGULARISATION=NONE|2, 15, 0, 0.5'
    character(len=11), parameter :: kinematics(2) = [character(len=11) :: 'LOGARITHMIC', 'JAUMANN']
    real(wp), parameter :: tolerance(2) = [1.0e-9_wp, 3.0e-2_wp]
    class(simulation_type), allocatable :: run
    integer :: k

    allocate (run)
    do k = 1, 2
      call run_deck(tests, block(soil, '*METHOD, BASIS=FEM, KINEMATICS='//trim(kinematics(k))), run)
      associate (points => run%model%state%points)
        associate (kappa => points%state(run%model%laws(1)%law%state_count, :))
          call tests%check(trim(kinematics(k))//': the block has yielded', all(kappa > 0.2_wp))
          call tests%close(trim(kinematics(k))//': the sum of the steps is the plastic strain of the law', &
            maxval(abs(points%plastic_strain/kappa - 1.0_wp)), 0.0_wp, tolerance(k))
        end associate
      end associate
      call run%destroy()
    end do
  end subroutine check_sum

  !> Under a pressure that cells share, strains are those that the law has seen: their volume is that of the points.
  subroutine check_locking(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(field_list_type) :: list
    real(wp), allocatable :: volume(:)

    allocate (run)
    call run_deck(tests, joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 4|Y, 0, 1.5, 3|'// &
      '*MATERIAL, NAME=clay|*ELASTIC|1000, 0.49|*MOHR COULOMB|5, 0, 0|*UNIT WEIGHT|18|*METHOD, BASIS=STANDARD|'// &
      '*BODY, NAME=block, MATERIAL=clay, SHAPE=BOX|0, 1.2, 0, 1|*NSET, NSET=base, PLANE=Y|0|'// &
      '*NSET, NSET=left, PLANE=X|0|*PHASE, NAME=weight|*FIX|base, ALL|left, X|*GRAVITY|0, -1|*CONTROLS, STEPS=3|'// &
      '*END PHASE|'), run)
    call tests%check('cells share a pressure', any(run%model%laws%pressure_factor > 0.0_wp))
    call list_made_fields(run%model%state%points, list)
    allocate (volume, source=list%fields(list%find('volume_strain'))%made(1, :))
    associate (points => run%model%state%points)
      call tests%check('volumes change', maxval(abs(volume)) > 1.0e-4_wp)
      call tests%close('the volume strain is that of the points', maxval(abs(volume - log(points%volume &
        /points%initial_volume))), 0.0_wp, 10.0_wp*rounding)
    end associate
    call run%destroy()
  end subroutine check_locking

  !> Where nobody asks strains are not carried, and are no result.
  subroutine check_not_carried(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: cards(3) = [character(len=26) :: '*FIELD, STRAIN=NO', '*FIELD, VTK=NO, HDF5=NO', &
      '*FIELD, VTK=NO']
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    integer :: i, rows, columns

    allocate (run)
    do i = 1, 3
      call run_deck(tests, block('*ELASTIC|1000, 0.3', '*METHOD, BASIS=FEM|'//trim(cards(i))), run)
      call tests%check(trim(cards(i))//': strains are carried if results show them', &
        carries_strains(run%model%state%points) .eqv. i == 3)
      call value_shape(run, 'point_strain', rows, columns, error)
      call tests%check(trim(cards(i))//': strains are values if they are carried', allocated(error) .eqv. i < 3)
      if (i < 3) call tests%check('the error names the card', index(error%message, '*FIELD, STRAIN=YES') > 0)
      call run%destroy()
    end do
  end subroutine check_not_carried

  !> The first picture and the first results show the initial stresses.
  subroutine check_start(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run, start
    class(problem_type), allocatable :: problem
    type(error_type), allocatable :: error
    character(len=:), allocatable :: directory, text, bytes
    type(field_list_type) :: list
    real(wp), allocatable :: stress(:, :)

    allocate (run, start, problem)
    call problem%parse(joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=TRI6|X, 0, 2, 2|Y, 0, 2, 2|'// &
      '*MATERIAL, NAME=sand|*ELASTIC|20000, 0.3|*UNIT WEIGHT|18|*BODY, NAME=ground, MATERIAL=sand, SHAPE=ALL|'// &
      '*METHOD, BASIS=STANDARD, INTEGRATION=POINTS|*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=left, PLANE=X|0|'// &
      '*NSET, NSET=right, PLANE=X|2|'// &
      '*PHASE, NAME=start|*INITIAL, TYPE=K0|2, 0.5|*FIX|base, ALL|left, X|right, X|*GRAVITY|0, -1|'// &
      '*CONTROLS, STEPS=1|*END PHASE|'), 'ground', error)
    if (.not. allocated(error)) call start%create(problem, error)
    if (.not. allocated(error)) call run%create(problem, error)
    call make_folder(directory)
    if (.not. allocated(error)) call run%record(directory//'/ground', error)
    call tests%check('the first picture waits for the initial stresses', .not. allocated(error) .and. &
      .not. file_exists(directory//'/ground/points_000000.vtu'))
    if (.not. allocated(error)) call run%run(error)
    if (.not. allocated(error)) call run%finish_record(error)
    call tests%check('level ground is run', .not. allocated(error))
    if (allocated(error)) return
    call start_phase(start%model)
    call start%model%state%points%list_fields(list)
    call list%fields(list%find('stress'))%get_values(6, stress)
    call tests%check('the initial stress is there', minval(stress(2, :)) < -30.0_wp)
    allocate (character(len=8*size(stress)) :: bytes)
    bytes = transfer(stress, bytes)
    call read_text(directory//'/ground/points_000000.vtu', text, error)
    call tests%check('the first picture shows the initial stresses', index(text, bytes) > 0)
    call read_text(directory//'/ground/results/000000.h5', text, error)
    call tests%check('the first results show the initial stresses', index(text, bytes) > 0)
    call remove_folder(directory)
    call run%destroy()
    call start%destroy()
  end subroutine check_start
end module test_strain
