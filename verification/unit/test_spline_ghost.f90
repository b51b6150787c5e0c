!> Ghost penalty of GIMP and splines: which faces, which fields pass, and the energy of fields whose
!> jumps are known.
!>
!> Control values of a polynomial or of a truncated power are products over the inner knots of each
!> function (its polar form, de Boor 1978), so fields with one given jump are written down directly.
module test_spline_ghost
  use active_samples, only: activate
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_cell_share, only: cell_volumes
  use qsmpm_points, only: points_type
  use qsmpm_point_location, only: activation_type
  use qsmpm_space, only: space_type
  use qsmpm_domains, only: domains_type, touch_cells
  use qsmpm_penalty_matrices, only: penalty_matrices_type, add_penalty_force
  use qsmpm_boundary_stabilisation, only: build_penalty
  use qsmpm_method_description, only: stabilise_none, stabilise_ghost, stabilise_background
  use sample_models, only: uneven_grid, sample_space, tiled_box, lines_x
  use testing, only: tests_type
  implicit none
  private

  public :: collect_spline_ghost

  !> Sums of a thousand products; jumps of third derivatives reach 1e3 and their squares 1e6.
  real(wp), parameter :: rounding = 1.0e-9_wp
  !> g and E of the checks.
  real(wp), parameter :: factor = 0.02_wp, young = 50.0_wp
  !> A plate whose ends are kinks: lines x = 1.0 and 2.4, and y = 1.7.
  real(wp), parameter :: plate(3, 2) = reshape([1.0_wp, 1.7_wp, 0.0_wp, 2.4_wp, 1.7_wp, 2.9_wp], [3, 2])

  interface
    !> LAPACK: eigenvalues of a symmetric matrix.
    subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
      import :: wp
      character(len=1), intent(in) :: jobz, uplo
      integer, intent(in) :: n, lda, lwork
      real(wp), intent(inout) :: a(lda, *)
      real(wp), intent(out) :: w(*), work(*)
      integer, intent(out) :: info
    end subroutine dsyev
  end interface

contains

  !> All checks.
  subroutine collect_spline_ghost(tests)
    type(tests_type), intent(inout) :: tests
    character(len=24) :: name
    integer :: dimension, degree

    call tests%start('spline_ghost')
    do dimension = 2, 3
      do degree = 1, 3
        write (name, '(a,i0,a,i0,a)') 'degree ', degree, ' in ', dimension, 'D'
        call check_polynomials(tests, trim(name), dimension, degree)
        call check_jumps(tests, trim(name), dimension, degree)
        call check_reduced_knots(tests, trim(name), dimension, degree)
        if (dimension == 2) call check_definite(tests, trim(name), degree)
        call check_background(tests, trim(name), dimension, degree)
      end do
    end do
    call check_faces(tests)
    call check_touched(tests)
    call check_none(tests)
  end subroutine collect_spline_ghost

  !> Terms for a body with a point in every cell, so thin that all are boundary cells.
  subroutine thin_body(dimension, degree, kind, mesh, space, stabilisation, box)
    integer, intent(in) :: dimension, degree, kind
    type(mesh_type), intent(out) :: mesh
    type(space_type), intent(out) :: space
    type(penalty_matrices_type), intent(out) :: stabilisation
    !> A set whose sides are kinks.
    real(wp), intent(in), optional :: box(3, 2)
    type(points_type) :: points
    type(domains_type) :: domains
    real(wp), parameter :: low(3) = [-0.2_wp, 0.0_wp, 0.0_wp], high(3) = [3.9_wp, 3.0_wp, 2.9_wp]

    call uneven_grid(dimension, mesh)
    call sample_space(mesh, degree, .true., space, box)
    call tiled_box(mesh, low(:dimension), high(:dimension), [16, 16, 10], points, domains)
    points%volume = 0.01_wp*points%volume
    call build(mesh, space, points, domains, kind, stabilisation)
  end subroutine thin_body

  !> Terms for a body; beyond a line along x its modulus is a thousand times that of the rest.
  subroutine build(mesh, space, points, domains, kind, stabilisation, stiff_from)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(points_type), intent(in) :: points
    type(domains_type), intent(in) :: domains
    integer, intent(in) :: kind
    type(penalty_matrices_type), intent(out) :: stabilisation
    !> Where it begins.
    real(wp), intent(in), optional :: stiff_from
    type(activation_type) :: activation
    real(wp) :: volumes(mesh%cell_count)
    real(wp), allocatable :: stiffness(:)
    integer :: g

    call cell_volumes(mesh, volumes)
    call activate(mesh, volumes, points, activation)
    call touch_cells(space, domains, activation%touched)
    allocate (stiffness(activation%active_count), source=young)
    if (present(stiff_from)) then
      do g = 1, activation%active_count
        associate (c => activation%active_cell(g))
          if (minval(mesh%coordinates(1, mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1))) >= &
            stiff_from) stiffness(g) = 1.0e3_wp*young
        end associate
      end do
    end if
    call build_penalty(mesh, space, activation, kind, factor, stiffness, volumes, &
      spread(.true., 1, mesh%cell_count), stabilisation)
  end subroutine build

  !> Control values along an axis of (x - shift)^degree, or with `upper` of its part above `shift`, or
  !> of x alone when `linear`.
  pure function along_axis(space, a, shift, upper) result(values)
    type(space_type), intent(in) :: space
    integer, intent(in) :: a
    real(wp), intent(in) :: shift
    logical, intent(in) :: upper
    real(wp) :: values(space%axis(a)%function_count)
    integer :: i

    do i = 1, size(values)
      associate (inner => space%axis(a)%knots(i + 1:i + space%degree) - shift)
        values(i) = product(inner)
        if (upper) values(i) = product(max(inner, 0.0_wp))
      end associate
    end do
  end function along_axis

  !> Product of control values along the axes, x fastest.
  subroutine multiply(space, dimension, x, y, z, field)
    type(space_type), intent(in) :: space
    integer, intent(in) :: dimension
    real(wp), intent(in) :: x(:), y(:), z(:)
    !> (1, nodes)
    real(wp), intent(out) :: field(:, :)
    integer :: i, j, k, n

    n = 0
    do k = 1, merge(size(z), 1, dimension == 3)
      do j = 1, size(y)
        do i = 1, size(x)
          n = n + 1
          field(1, n) = x(i)*y(j)
          if (dimension == 3) field(1, n) = field(1, n)*z(k)
        end do
      end do
    end do
    if (n /= space%node_count) field = huge(1.0_wp)
  end subroutine multiply

  !> No polynomial of the degree is resisted, not even products of such along the axes.
  subroutine check_polynomials(tests, name, dimension, degree)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    integer, intent(in) :: dimension, degree
    type(mesh_type) :: mesh
    type(space_type) :: space
    type(penalty_matrices_type) :: stabilisation
    real(wp), allocatable :: field(:, :), force(:, :)
    integer :: variant

    do variant = 1, 2
      if (variant == 1) call thin_body(dimension, degree, stabilise_ghost, mesh, space, stabilisation)
      if (variant == 2) call thin_body(dimension, degree, stabilise_ghost, mesh, space, stabilisation, plate)
      allocate (field(1, space%node_count), force(1, space%node_count))
      call multiply(space, dimension, along_axis(space, 1, 1.9_wp, .false.), along_axis(space, 2, 1.2_wp, .false.), &
        third_axis(space, dimension), field)
      force = 0.0_wp
      call add_penalty_force(stabilisation, field, force)
      call tests%close('ghost of '//name//merge(' kinked', '       ', variant == 2)// &
        ' lets polynomials of its degree pass', maxval(abs(force)), 0.0_wp, rounding)
      field = 0.0_wp
      field(1, space%node_count/2) = 1.0_wp
      force = 0.0_wp
      call add_penalty_force(stabilisation, field, force)
      call tests%check('and resists a single control value', force(1, space%node_count/2) > 1.0e-3_wp)
      deallocate (field, force)
    end do
  end subroutine check_polynomials

  !> A polynomial along z, nothing in the plane.
  function third_axis(space, dimension) result(values)
    type(space_type), intent(in) :: space
    integer, intent(in) :: dimension
    real(wp), allocatable :: values(:)

    if (dimension == 3) then
      allocate (values, source=along_axis(space, 3, 1.1_wp, .false.))
    else
      allocate (values(1), source=1.0_wp)
    end if
  end function third_axis

  !> Ones along an axis.
  pure function ones(space, a) result(values)
    type(space_type), intent(in) :: space
    integer, intent(in) :: a
    real(wp) :: values(space%axis(a)%function_count)

    values = 1.0_wp
  end function ones

  !> Energy of a field.
  real(wp) function energy(stabilisation, field)
    type(penalty_matrices_type), intent(in) :: stabilisation
    real(wp), intent(in) :: field(:, :)
    real(wp) :: force(size(field, 1), size(field, 2))

    force = 0.0_wp
    call add_penalty_force(stabilisation, field, force)
    energy = sum(force*field)
  end function energy

  !> The part of (x - t)^p above a simple line t jumps by p! in its derivative of order p there and
  !> nowhere else: its energy is g E h^(2p-1) (p!)^2 times the length (area) of the line.
  subroutine check_jumps(tests, name, dimension, degree)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    integer, intent(in) :: dimension, degree
    integer, parameter :: factorial(3) = [1, 2, 6], line(3) = [4, 3, 2]
    type(mesh_type) :: mesh
    type(space_type) :: space
    type(penalty_matrices_type) :: stabilisation
    real(wp), allocatable :: field(:, :)
    real(wp) :: h, wanted, area(3)
    character(len=1), parameter :: axes(3) = ['x', 'y', 'z']
    integer :: a

    call thin_body(dimension, degree, stabilise_ghost, mesh, space, stabilisation)
    area = [3.0_wp*2.9_wp, 4.1_wp*2.9_wp, 4.1_wp*3.0_wp]
    if (dimension == 2) area = [3.0_wp, 4.1_wp, 0.0_wp]
    allocate (field(1, space%node_count))
    do a = 1, dimension
      associate (lines => space%axis(a)%lines)
        call one_axis(space, dimension, a, along_axis(space, a, lines(line(a)), .true.), field)
        h = 0.5_wp*(lines(line(a) + 1) - lines(line(a) - 1))
        wanted = factor*young*h**(2*degree - 1)*factorial(degree)**2*area(a)
      end associate
      call tests%close('ghost of '//name//' has the energy of a jump across '//axes(a), &
        energy(stabilisation, field)/wanted, 1.0_wp, rounding)
    end do
  end subroutine check_jumps

  !> A field of one coordinate.
  subroutine one_axis(space, dimension, a, values, field)
    type(space_type), intent(in) :: space
    integer, intent(in) :: dimension, a
    real(wp), intent(in) :: values(:)
    real(wp), intent(out) :: field(:, :)
    real(wp) :: none(0)

    if (dimension == 3) then
      if (a == 1) call multiply(space, 3, values, ones(space, 2), ones(space, 3), field)
      if (a == 2) call multiply(space, 3, ones(space, 1), values, ones(space, 3), field)
      if (a == 3) call multiply(space, 3, ones(space, 1), ones(space, 2), values, field)
    else
      if (a == 1) call multiply(space, 2, values, ones(space, 2), none, field)
      if (a == 2) call multiply(space, 2, ones(space, 1), values, none, field)
    end if
  end subroutine one_axis

  !> At a kink the slope may jump, and the penalty counts it: a field of slope zero below and one above
  !> has the energy g E h times the area. Its higher derivatives do not jump.
  subroutine check_reduced_knots(tests, name, dimension, degree)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    integer, intent(in) :: dimension, degree
    type(mesh_type) :: mesh
    type(space_type) :: space
    type(penalty_matrices_type) :: stabilisation
    real(wp), allocatable :: field(:, :)
    real(wp) :: wanted

    call thin_body(dimension, degree, stabilise_ghost, mesh, space, stabilisation, plate)
    allocate (field(1, space%node_count))
    call one_axis(space, dimension, 2, max(space%axis(2)%anchor - 1.7_wp, 0.0_wp), field)
    wanted = factor*young*0.5_wp*(2.2_wp - 0.8_wp)*4.1_wp*merge(2.9_wp, 1.0_wp, dimension == 3)
    call tests%close('ghost of '//name//' has the energy of a jump of slope at a kink', &
      energy(stabilisation, field)/wanted, 1.0_wp, rounding)
  end subroutine check_reduced_knots

  !> The assembled penalty is symmetric and has no negative eigenvalue.
  subroutine check_definite(tests, name, degree)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    integer, intent(in) :: degree
    type(mesh_type) :: mesh
    type(space_type) :: space
    type(penalty_matrices_type) :: stabilisation
    real(wp), allocatable :: matrix(:, :), values(:), work(:)
    integer :: k, n, info

    call thin_body(2, degree, stabilise_ghost, mesh, space, stabilisation, plate)
    n = space%node_count
    allocate (matrix(n, n), source=0.0_wp)
    do k = 1, stabilisation%connectivity%count
      associate (nodes => stabilisation%connectivity%nodes(stabilisation%connectivity%first(k): &
        stabilisation%connectivity%first(k + 1) - 1))
        matrix(nodes, nodes) = matrix(nodes, nodes) + stabilisation%matrix(:size(nodes), :size(nodes), k)
      end associate
    end do
    call tests%close('ghost of '//name//' is symmetric', maxval(abs(matrix - transpose(matrix)))/ &
      maxval(abs(matrix)), 0.0_wp, 1.0e-14_wp)
    allocate (values(n), work(8*n))
    call dsyev('N', 'U', n, matrix, n, values, work, size(work), info)
    call tests%check('ghost of '//name//' has no negative eigenvalue', info == 0 .and. &
      values(1) > -1.0e-13_wp*values(n))
    ! Free of any penalty are just the polynomials of the degree along each axis.
    call tests%check('ghost of '//name//' leaves only polynomials free', &
      count(values < 1.0e-11_wp*values(n)) == (degree + 1)**2)
  end subroutine check_definite

  !> The background term of splines lets a linear field pass and resists another one.
  subroutine check_background(tests, name, dimension, degree)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    integer, intent(in) :: dimension, degree
    type(mesh_type) :: mesh
    type(space_type) :: space
    type(penalty_matrices_type) :: stabilisation
    real(wp), allocatable :: field(:, :)

    call thin_body(dimension, degree, stabilise_background, mesh, space, stabilisation)
    allocate (field(1, space%node_count))
    call one_axis(space, dimension, 1, space%axis(1)%anchor, field)
    call tests%close('background of '//name//' lets a linear field pass', energy(stabilisation, field), 0.0_wp, rounding)
    field = 0.0_wp
    field(1, 1) = 1.0_wp
    call tests%check('background of '//name//' resists a single function', energy(stabilisation, field) > 0.01_wp)
  end subroutine check_background

  !> A filled block of three by four cells in the lower corner of six by five: the third column and the
  !> fourth row are boundary cells. Of the 17 faces between cells of the block only the 7 between the
  !> two columns and three rows of inner cells stay free.
  subroutine check_faces(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(space_type) :: space
    type(points_type) :: points
    type(domains_type) :: domains
    type(penalty_matrices_type) :: stabilisation
    real(wp), allocatable :: field(:, :)

    call uneven_grid(2, mesh)
    call sample_space(mesh, 2, .false., space)
    call tiled_box(mesh, [-0.2_wp, 0.0_wp], [1.4_wp, 2.2_wp], [16, 22], points, domains)
    call build(mesh, space, points, domains, stabilise_ghost, stabilisation)
    call tests%check('only faces of boundary cells are penalised', stabilisation%connectivity%count == 17 - 7)
    allocate (field(1, space%node_count))
    call one_axis(space, 2, 1, along_axis(space, 1, lines_x(2), .true.), field)
    call tests%close('a jump inside the body is free but for the boundary row', energy(stabilisation, field), &
      factor*young*(0.5_wp*1.2_wp)**3*4.0_wp*0.5_wp, rounding)
    call one_axis(space, 2, 1, along_axis(space, 1, lines_x(4), .true.), field)
    call tests%close('a jump at the edge of the body is free', energy(stabilisation, field), 0.0_wp, rounding)
    call build(mesh, space, points, domains, stabilise_ghost, stabilisation, lines_x(2))
    call one_axis(space, 2, 1, along_axis(space, 1, lines_x(2), .true.), field)
    call tests%close('a jump beside a stiff body is penalised by the modulus of the soft one', &
      energy(stabilisation, field), factor*young*(0.5_wp*1.2_wp)**3*4.0_wp*0.5_wp, rounding)
  end subroutine check_faces

  !> A cell that only domains reach into has faces; a cell that nothing reaches has none.
  subroutine check_touched(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(space_type) :: space
    type(points_type) :: points
    type(domains_type) :: domains
    type(penalty_matrices_type) :: stabilisation
    real(wp), allocatable :: field(:, :)

    call uneven_grid(2, mesh)
    call sample_space(mesh, 2, .true., space)
    ! The last points lie at 1.375 and reach to 1.45, over the line at 1.4.
    call tiled_box(mesh, [-0.2_wp, 0.0_wp], [1.45_wp, 2.2_wp], [11, 22], points, domains)
    call build(mesh, space, points, domains, stabilise_ghost, stabilisation)
    allocate (field(1, space%node_count))
    call one_axis(space, 2, 1, along_axis(space, 1, lines_x(4), .true.), field)
    call tests%close('a jump to a cell that domains reach is penalised', energy(stabilisation, field), &
      factor*young*(0.5_wp*1.4_wp)**3*4.0_wp*2.2_wp, rounding)
    call one_axis(space, 2, 1, along_axis(space, 1, lines_x(5), .true.), field)
    call tests%close('one to a cell beyond is not', energy(stabilisation, field), 0.0_wp, rounding)
  end subroutine check_touched

  !> Without stabilisation there are no terms.
  subroutine check_none(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(space_type) :: space
    type(penalty_matrices_type) :: stabilisation

    call thin_body(2, 2, stabilise_none, mesh, space, stabilisation)
    call tests%check('no stabilisation has no terms', stabilisation%connectivity%count == 0 .and. &
      .not. allocated(stabilisation%matrix))
  end subroutine check_none
end module test_spline_ghost
