!> Bodies of triangles: what the facets must be, volume and centroid of the points, reading STL files.
module test_polyhedron
  use, intrinsic :: iso_fortran_env, only: real32, int32, int8
  use qsmpm_kinds, only: wp, pi
  use qsmpm_error, only: error_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_polyhedron, only: polyhedron_type, make_polyhedron, polyhedron_volume, polyhedron_contains
  use qsmpm_polyhedron_check, only: polyhedron_problem
  use qsmpm_seeding, only: body_shape_type, seed_list_type, seed_body, seed_even
  use qsmpm_stl_reader, only: read_stl
  use solid_samples, only: block_facets, angle_facets, wedge_facets, sphere_facets, turned
  use sample_models, only: sample_grid
  use test_body_pieces, only: first_moment
  use testing, only: tests_type
  implicit none
  private

  public :: collect_polyhedron

  !> Sums of signed parts of up to a few hundred facets over a thousand cells, for solids of size one.
  real(wp), parameter :: rounding = 1.0e-11_wp
  real(wp), parameter :: middle(3) = [0.47_wp, 0.52_wp, 0.49_wp]

contains

  !> All checks.
  subroutine collect_polyhedron(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    real(wp), allocatable :: block(:, :, :), ball(:, :, :)

    call tests%start('polyhedron')
    allocate (block, source=block_facets([-0.2_wp, -0.25_wp, -0.3_wp], [0.2_wp, 0.25_wp, 0.3_wp]))
    allocate (ball, source=sphere_facets(8))
    call check_solid(tests, 'a tilted block', turned(block, 0.5_wp, 0.7_wp, middle), 0.12_wp)
    call check_solid(tests, 'a block on grid planes', &
      block_facets([0.2_wp, 0.2_wp, 0.2_wp], [0.8_wp, 0.6_wp, 0.7_wp]), 0.12_wp)
    call check_solid(tests, 'a wedge of 45 degrees', 0.6_wp*wedge_facets() + 0.2_wp, 0.108_wp)
    call check_solid(tests, 'an L', turned(0.7_wp*angle_facets(), 0.3_wp, 0.4_wp, [0.3_wp, 0.15_wp, 0.3_wp]), &
      0.375_wp*0.343_wp)
    call check_solid(tests, 'a ball of triangles', 0.42_wp*ball + 0.5_wp, 0.42_wp**3*ball_volume(8))
    call check_single_precision(tests)
    call check_inside(tests)
    call check_problems(tests)
    call check_files(tests)
  end subroutine collect_polyhedron

  !> Volume of the polyhedron of `sphere_facets`. A band of quadrilaterals with parallel edges r1 and r2
  !> times 2 sin(pi/2n) is cut out of cones: sum of frustums of regular 2n-gons.
  real(wp) function ball_volume(n) result(volume)
    !> Bands.
    integer, intent(in) :: n
    real(wp) :: r(2)
    integer :: i

    volume = 0.0_wp
    do i = 1, n
      r = sin(pi*[i - 1, i]/n)
      volume = volume + n*sin(pi/n)*(r(1)**2 + r(1)*r(2) + r(2)**2)/3*(cos(pi*(i - 1)/n) - cos(pi*i/n))
    end do
  end function ball_volume

  !> The divergence theorem gives the volume by hand; the points of grids of five cells a side of
  !> bricks, tetrahedra and wedges hold it, those of bricks have its centroid.
  subroutine check_solid(tests, name, facets, exact)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> What it is.
    character(len=*), intent(in) :: name
    !> Corners (3, 3, n).
    real(wp), intent(in) :: facets(:, :, :)
    !> Volume by hand.
    real(wp), intent(in) :: exact
    character(len=6), parameter :: elements(4) = [character(len=6) :: 'HEX8', 'HEX20', 'WEDGE6', 'TET4']
    type(mesh_type) :: mesh
    type(body_shape_type) :: shape
    type(seed_list_type) :: list
    type(error_type), allocatable :: error
    real(wp) :: volume, centroid(3), held, moment(3)
    integer :: i

    call tests%check(name//' is closed', len(polyhedron_problem(facets)) == 0)
    call polyhedron_volume(facets, volume, centroid)
    call tests%close(name//' has its volume', volume, exact, 1.0e-14_wp)
    allocate (shape%solid)
    call make_polyhedron(facets, shape%solid)
    do i = 1, size(elements)
      list = seed_list_type()
      call sample_grid(trim(elements(i)), 5, merge(0.2_wp, 0.0_wp, i == 4), mesh)
      call seed_body(mesh, shape, 1, 0, seed_even, 0, list, error)
      call first_moment(mesh, list, held, moment)
      call tests%close(name//' is held by '//trim(elements(i)), held, exact, rounding)
      call tests%check(name//': volumes are positive in '//trim(elements(i)), &
        all(list%volume(:list%count) > 0.0_wp))
      if (i <= 2) call tests%close(name//' has its centroid in '//trim(elements(i)), &
        maxval(abs(moment/held - centroid)), 0.0_wp, rounding)
    end do
  end subroutine check_solid

  !> Coordinates in single precision miss grid planes by some 1e-8: no slivers beyond them.
  subroutine check_single_precision(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    real(wp), allocatable :: block(:, :, :)
    type(mesh_type) :: mesh
    type(body_shape_type) :: shape
    type(seed_list_type) :: list
    type(error_type), allocatable :: error

    allocate (block, source=block_facets([0.2_wp, 0.2_wp, 0.2_wp], [0.6_wp, 0.8_wp, 1.0_wp]))
    block = real(real(block, real32), wp)
    allocate (shape%solid)
    call make_polyhedron(block, shape%solid)
    shape%uncertainty = epsilon(1.0_real32)
    call sample_grid('HEX8', 5, 0.0_wp, mesh)
    call seed_body(mesh, shape, 1, 0, seed_even, 0, list, error)
    call tests%check('a block in single precision fills its 24 cells and no more', list%count == 24*8)
    ! Six faces off by up to half a digit of single precision.
    call tests%close('and keeps its volume', sum(list%volume(:list%count)), 0.192_wp, 1.0e-7_wp)
  end subroutine check_single_precision

  !> Containment in the L: its limbs, its notch, and places above and below corners.
  subroutine check_inside(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    type(polyhedron_type) :: solid

    call make_polyhedron(angle_facets(), solid)
    call tests%check('the foot of the L is inside', polyhedron_contains(solid, [0.25_wp, 0.25_wp, 0.25_wp]))
    call tests%check('its other limb is inside', polyhedron_contains(solid, [0.75_wp, 0.75_wp, 0.25_wp]))
    call tests%check('its notch is outside', .not. polyhedron_contains(solid, [0.25_wp, 0.75_wp, 0.25_wp]))
    call tests%check('a place above a corner is outside', &
      .not. polyhedron_contains(solid, [0.5_wp, 0.5_wp, 0.75_wp]))
    call tests%check('a place below a diagonal of the foot is inside', &
      polyhedron_contains(solid, [0.75_wp, 0.25_wp, 0.25_wp]))
  end subroutine check_inside

  !> Each fault of a surface has its message.
  subroutine check_problems(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    real(wp), allocatable :: block(:, :, :), wrong(:, :, :)
    real(wp), parameter :: zero(3) = 0.0_wp, one(3) = 1.0_wp
    real(wp) :: two(3, 3, 24)

    allocate (block, source=block_facets(zero, one))
    call expect('belongs to no other facet', block(:, :, 2:))
    call expect('look inward', block(:, [1, 3, 2], :))
    allocate (wrong, source=block)
    wrong(:, :, 5) = wrong(:, [1, 3, 2], 5)
    call expect('look to opposite sides', wrong)
    wrong(:, 2, 5) = wrong(:, 1, 5)
    call expect('facet 5 coincide', wrong)
    two(:, :, :12) = block
    two(:, :, 13:) = block_facets([1.0_wp, 1.0_wp, 0.0_wp], [2.0_wp, 2.0_wp, 1.0_wp])
    call expect('more than two facets', two)
    call expect('no volume', reshape([zero, one, [0.5_wp, 1.0_wp, 0.0_wp], zero, [0.5_wp, 1.0_wp, 0.0_wp], one], &
      [3, 3, 2]))
    two(:, :, 13:) = -0.5_wp*two(:, [1, 3, 2], :12) - 1.0_wp
    call tests%check('two blocks apart are a solid', len(polyhedron_problem(two)) == 0)

  contains

    !> A message of these words.
    subroutine expect(words, facets)
      !> Part of the message.
      character(len=*), intent(in) :: words
      !> Corners (3, 3, n).
      real(wp), intent(in) :: facets(:, :, :)

      call tests%check("refused, because '"//words//"'", index(polyhedron_problem(facets), words) > 0)
    end subroutine expect
  end subroutine check_problems

  !> A block written in either form comes back; broken files are refused with their line.
  subroutine check_files(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: path = 'test_polyhedron.stl'
    real(wp), allocatable :: block(:, :, :), facets(:, :, :)
    type(error_type), allocatable :: error
    integer :: unit

    allocate (block, source=block_facets([0.0_wp, 0.0_wp, -0.5_wp], [1.0_wp, 0.25_wp, 2.0_wp]))
    call write_ascii(path, block)
    call read_stl(path, facets, error)
    call tests%check('an ASCII file is read', .not. allocated(error))
    if (.not. allocated(error)) call tests%close('and is the block', maxval(abs(facets - block)), 0.0_wp, 0.0_wp)
    call write_binary(path, block)
    call read_stl(path, facets, error)
    call tests%check('a binary file is read', .not. allocated(error))
    if (.not. allocated(error)) call tests%close('and is the block', maxval(abs(facets - block)), 0.0_wp, 0.0_wp)
    call refuse('solid a'//new_line('a')//'facet'//new_line('a')//'vertex 0 0'//new_line('a'), ':3: a vertex has')
    call refuse('solid a'//new_line('a')//'vertex 0 0 x'//new_line('a'), ":2: 'x' is not a number")
    call refuse('solid a'//new_line('a')//'vertex 0 0 1'//new_line('a')//'endfacet', ':3: a facet has three')
    call refuse('solid a'//new_line('a')//'vertex 0 0 1', ':2: the file ends inside')
    call refuse('solid a'//new_line('a')//'endsolid', 'the file has no facets')
    call refuse('ply', ':1: the file is no STL')
    open (newunit=unit, file=path, status='old')
    close (unit, status='delete')

  contains

    !> A file of these bytes has this message.
    subroutine refuse(bytes, words)
      !> The file.
      character(len=*), intent(in) :: bytes
      !> Part of the message.
      character(len=*), intent(in) :: words

      open (newunit=unit, file=path, access='stream', form='unformatted', status='replace')
      write (unit) bytes
      close (unit)
      call read_stl(path, facets, error)
      if (allocated(error)) then
        call tests%check("a broken file: '"//words//"'", index(error%message, words) > 0)
      else
        call tests%check("a broken file: '"//words//"'", .false.)
      end if
    end subroutine refuse
  end subroutine check_files

  !> Write an ASCII file.
  subroutine write_ascii(path, facets)
    !> Path.
    character(len=*), intent(in) :: path
    !> Corners (3, 3, n).
    real(wp), intent(in) :: facets(:, :, :)
    integer :: unit, f, k

    open (newunit=unit, file=path, status='replace')
    write (unit, '(a)') 'solid block'
    do f = 1, size(facets, 3)
      write (unit, '(a)') ' facet normal 0 0 0', '  outer loop'
      do k = 1, 3
        write (unit, '(a, 3es16.8)') '   vertex', facets(:, k, f)
      end do
      write (unit, '(a)') '  endloop', ' endfacet'
    end do
    write (unit, '(a)') 'endsolid block'
    close (unit)
  end subroutine write_ascii

  !> Write a binary file that begins, as some do, with the word of an ASCII one.
  subroutine write_binary(path, facets)
    !> Path.
    character(len=*), intent(in) :: path
    !> Corners (3, 3, n).
    real(wp), intent(in) :: facets(:, :, :)
    character(len=80) :: head
    integer :: unit, f

    head = 'solid of some program'
    open (newunit=unit, file=path, access='stream', form='unformatted', status='replace')
    write (unit) head, int(size(facets, 3), int32)
    do f = 1, size(facets, 3)
      write (unit) [0.0_real32, 0.0_real32, 0.0_real32], real(facets(:, :, f), real32), 0_int8, 0_int8
    end do
    close (unit)
  end subroutine write_binary
end module test_polyhedron
