!> Domains of material points and their pieces: stretch, bounds, walls, shares.
module test_domains
  use active_samples, only: activate
  use qsmpm_kinds, only: wp
  use qsmpm_tensor, only: pack_gradient
  use qsmpm_mesh, only: mesh_type
  use qsmpm_cell_share, only: cell_volumes
  use qsmpm_points, only: points_type
  use qsmpm_point_location, only: activation_type
  use qsmpm_grid_window, only: place_of
  use qsmpm_space, only: space_type
  use qsmpm_domains, only: domains_type, place_domains, touch_cells
  use qsmpm_domain_pieces, only: pieces_type, cut_domains, whole_points
  use sample_models, only: uneven_grid, sample_space, tiled_box, owner_of, lines_x, lines_y, lines_z
  use testing, only: tests_type
  implicit none
  private

  public :: collect_domains

  !> Sums of a few hundred products near one.
  real(wp), parameter :: rounding = 1.0e-12_wp

contains

  !> All checks.
  subroutine collect_domains(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('domains')
    call check_stretch(tests, 2)
    call check_stretch(tests, 3)
    call check_bounds(tests)
    call check_edge(tests)
    call check_walls(tests)
    call check_corner(tests)
    call check_touched(tests)
    call check_pieces(tests, 2)
    call check_pieces(tests, 3)
    call check_whole(tests)
  end subroutine collect_domains

  !> One point in uneven_grid and its domain.
  subroutine one_domain(dimension, x, half, gradient, low, high, box, others)
    integer, intent(in) :: dimension
    !> Place and half lengths at the start.
    real(wp), intent(in) :: x(:), half(:)
    !> Total deformation gradient.
    real(wp), intent(in) :: gradient(3, 3)
    !> Ends of the domain.
    real(wp), intent(out) :: low(:), high(:)
    !> A constrained set whose sides are kinks (3,2).
    real(wp), intent(in), optional :: box(3, 2)
    !> Places of further points (dimension, n), of half lengths 0.01.
    real(wp), intent(in), optional :: others(:, :)
    type(mesh_type) :: mesh
    type(space_type) :: space
    type(points_type) :: points
    type(domains_type) :: domains
    type(activation_type) :: activation
    real(wp), allocatable :: volumes(:), packed(:, :)
    integer :: p, n

    call uneven_grid(dimension, mesh)
    call sample_space(mesh, 2, .true., space, box)
    n = 1
    if (present(others)) n = 1 + size(others, 2)
    call tiled_box(mesh, x - half, x + half, [n, 1, 1], points, domains)
    allocate (packed(4*dimension - 3, n), volumes(mesh%cell_count))
    do p = 1, n
      points%position(:, p) = x
      points%half_size(:, p) = half
      if (p > 1) points%position(:, p) = others(:, p - 1)
      if (p > 1) points%half_size(:, p) = 0.01_wp
      call owner_of(mesh, points%position(:, p), points%cell(p), points%local(:, p))
      call pack_gradient(gradient, packed(:, p))
    end do
    call move_alloc(packed, points%deformation_gradient)
    call cell_volumes(mesh, volumes)
    call activate(mesh, volumes, points, activation)
    call place_domains(space, activation, points, domains)
    low = domains%low(:, 1)
    high = domains%high(:, 1)
  end subroutine one_domain

  !> No deformation.
  pure function identity() result(f)
    real(wp) :: f(3, 3)

    f = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
  end function identity

  !> F = R U with a known U: half lengths grow by the diagonal of U, however the point has turned.
  subroutine check_stretch(tests, dimension)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    real(wp), parameter :: half(3) = [0.05_wp, 0.04_wp, 0.03_wp], x(3) = [1.9_wp, 1.2_wp, 1.0_wp]
    real(wp), dimension(dimension) :: low, high
    real(wp) :: u(3, 3), r(3, 3), turn(3, 3), diagonal(3), c, s

    u = reshape([1.3_wp, 0.2_wp, 0.0_wp, 0.2_wp, 0.8_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.1_wp], [3, 3])
    if (dimension == 3) u(3, :) = [0.1_wp, -0.15_wp, 1.1_wp]
    u(:, 3) = u(3, :)
    c = cos(1.1_wp)
    s = sin(1.1_wp)
    r = reshape([c, s, 0.0_wp, -s, c, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
    turn = identity()
    if (dimension == 3) turn = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, c, s, 0.0_wp, -s, c], [3, 3])
    call one_domain(dimension, x(:dimension), half(:dimension), matmul(matmul(turn, r), u), low, high)
    diagonal = [u(1, 1), u(2, 2), u(3, 3)]
    call tests%close('half lengths grow by the diagonal of the right stretch', maxval(abs(high - low &
      - 2.0_wp*half(:dimension)*diagonal(:dimension))), 0.0_wp, rounding)
    call tests%close('the point stays in the middle', maxval(abs(0.5_wp*(low + high) - x(:dimension))), 0.0_wp, &
      rounding)
  end subroutine check_stretch

  !> A domain ends where it would reach beyond the neighbours of its cell, on both sides alike.
  subroutine check_bounds(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: x(2) = [1.1_wp, 1.2_wp]
    real(wp) :: low(2), high(2)

    ! The cell is 1.0 to 1.4 by 0.8 to 1.7, the neighbours end at 0.3 and 2.4, and at 0.5 and 2.2.
    call one_domain(2, x, [5.0_wp, 5.0_wp], identity(), low, high)
    call tests%close('a domain reaches one cell beyond its own', maxval(abs(low - [0.3_wp, 0.5_wp])), 0.0_wp, rounding)
    call tests%close('and as far on the other side', maxval(abs(high - [1.9_wp, 1.9_wp])), 0.0_wp, rounding)
    call one_domain(2, x, [0.0_wp, 0.1_wp], identity(), low, high)
    call tests%check('a domain never vanishes', high(1) > low(1))
  end subroutine check_bounds

  !> Towards the edge of the mesh a domain ends there on one side only.
  subroutine check_edge(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: low(2), high(2)

    call one_domain(2, [0.0_wp, 2.9_wp], [0.3_wp, 0.3_wp], identity(), low, high)
    call tests%close('a domain ends at the lower edge of the mesh', low(1), -0.2_wp, rounding)
    call tests%close('its other end stays', high(1), 0.3_wp, rounding)
    call tests%close('a domain ends at the upper edge of the mesh', high(2), 3.0_wp, rounding)
    call tests%close('and its lower end stays', low(2), 2.6_wp, rounding)
    call one_domain(2, [3.95_wp, 1.2_wp], [0.02_wp, 0.1_wp], identity(), low, high)
    call tests%check('the domain of a point just outside has a length', high(1) - low(1) > 1.0e-3_wp)
  end subroutine check_edge

  !> A kink with an empty cell behind is a wall; with material behind, or without a kink, none is there.
  subroutine check_walls(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: plate(3, 2) = reshape([1.0_wp, 1.7_wp, 0.0_wp, 1.4_wp, 1.7_wp, 0.0_wp], [3, 2])
    real(wp), parameter :: x(2) = [1.2_wp, 1.5_wp], half(2) = [0.1_wp, 0.3_wp]
    real(wp) :: low(2), high(2), above(2, 1)

    call one_domain(2, x, half, identity(), low, high, plate)
    call tests%close('a domain ends at a wall', high(2), 1.7_wp, rounding)
    call tests%close('and is as long on the other side', low(2), 1.3_wp, rounding)
    call tests%close('its width stays', high(1) - low(1), 0.2_wp, rounding)
    above(:, 1) = [1.2_wp, 2.0_wp]
    call one_domain(2, x, half, identity(), low, high, plate, above)
    call tests%close('with material behind the wall the domain reaches through', high(2), 1.8_wp, rounding)
    call one_domain(2, x, half, identity(), low, high)
    call tests%close('without a kink there is no wall', high(2), 1.8_wp, rounding)
  end subroutine check_walls

  !> Where only the cell across the corner is empty, the domain gives way along the axis on which it
  !> reaches least far.
  subroutine check_corner(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: plate(3, 2) = reshape([1.4_wp, 1.7_wp, 0.0_wp, 2.4_wp, 2.2_wp, 0.0_wp], [3, 2])
    real(wp), parameter :: x(2) = [1.3_wp, 1.6_wp], half(2) = [0.15_wp, 0.3_wp]
    real(wp) :: low(2), high(2), others(2, 2)

    others(:, 1) = [1.2_wp, 1.9_wp]
    others(:, 2) = [1.8_wp, 1.2_wp]
    call one_domain(2, x, half, identity(), low, high, plate, others)
    call tests%close('at an open corner the domain ends at the nearer side', high(1), 1.4_wp, rounding)
    call tests%close('its other axis stays', high(2), 1.9_wp, rounding)
    call one_domain(2, x, half, identity(), low, high, plate, reshape([others, 1.8_wp, 1.9_wp], [2, 3]))
    call tests%close('with the corner filled it stays whole', high(1), 1.45_wp, rounding)
  end subroutine check_corner

  !> Cells that a domain reaches into are marked; those marked before stay so.
  subroutine check_touched(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(space_type) :: space
    type(domains_type) :: domains
    logical, allocatable :: touched(:)

    call uneven_grid(2, mesh)
    call sample_space(mesh, 2, .true., space)
    allocate (touched(mesh%cell_count), source=.false.)
    touched(30) = .true.
    domains%low = reshape([0.4_wp, 0.5_wp, 0.3_wp, 2.2_wp], [2, 2])
    domains%high = reshape([1.2_wp, 0.9_wp, 1.0_wp, 2.5_wp], [2, 2])
    call touch_cells(space, domains, touched)
    ! x from 0.3 to 1.4 are columns 2 and 3, y from 0.5 to 1.7 rows 2 and 3; row 5 has its second cell.
    call tests%check('touched are the cells domains reach into', count(touched) == 6 .and. &
      all(touched([8, 9, 14, 15, 26])))
    call tests%check('what was touched stays so', touched(30))
  end subroutine check_touched

  !> A box tiled across the lines of the grid: every cell gets its part of the box.
  subroutine check_pieces(tests, dimension)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    real(wp), parameter :: low(3) = [0.1_wp, 0.2_wp, 0.3_wp], high(3) = [2.7_wp, 2.0_wp, 1.8_wp]
    type(mesh_type) :: mesh
    type(space_type) :: space
    type(points_type) :: points
    type(domains_type) :: domains
    type(pieces_type) :: pieces
    real(wp), allocatable :: shares(:)
    real(wp) :: worst, held
    logical :: inside, sorted
    integer :: g, n, at(3)

    call uneven_grid(dimension, mesh)
    call sample_space(mesh, 2, .true., space)
    call tiled_box(mesh, low(:dimension), high(:dimension), [7, 5, 4], points, domains)
    call cut_domains(space, mesh, domains, pieces)
    allocate (shares(points%count), source=0.0_wp)
    worst = 0.0_wp
    inside = .true.
    sorted = all(pieces%cell(2:) > pieces%cell(:size(pieces%cell) - 1))
    do g = 1, size(pieces%cell)
      at = place_of(pieces%cell(g), space%axis%cell_count)
      held = 0.0_wp
      do n = pieces%first(g), pieces%first(g + 1) - 1
        shares(pieces%point(n)) = shares(pieces%point(n)) + pieces%share(n)
        held = held + pieces%share(n)*points%volume(pieces%point(n))
        inside = inside .and. all(pieces%low(:, n) >= corner(at) - rounding) .and. &
          all(pieces%high(:, n) <= corner(at + 1) + rounding) .and. &
          all(pieces%high(:, n) > pieces%low(:, n))
        if (n > pieces%first(g)) sorted = sorted .and. pieces%point(n) > pieces%point(n - 1)
      end do
      worst = max(worst, abs(held - product(min(corner(at + 1), high(:dimension)) &
        - max(corner(at), low(:dimension)))))
    end do
    call tests%close('shares of a domain sum to one', maxval(abs(shares - 1.0_wp)), 0.0_wp, rounding)
    call tests%close('every cell holds its part of the box', worst, 0.0_wp, rounding)
    call tests%check('pieces lie in their cells', inside)
    call tests%check('cells rise, and points in a cell', sorted)
    call tests%check('pieces end where the lists do', pieces%first(size(pieces%cell) + 1) == &
      size(pieces%share) + 1)
  contains
    !> Lower corner of the cell at a place.
    pure function corner(place) result(x)
      integer, intent(in) :: place(3)
      real(wp) :: x(dimension)

      x(:2) = [lines_x(place(1)), lines_y(place(2))]
      if (dimension == 3) x(3) = lines_z(place(3))
    end function corner
  end subroutine check_pieces

  !> Without domains every point is one piece in the cell that owns it.
  subroutine check_whole(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(points_type) :: points
    type(domains_type) :: domains
    type(activation_type) :: activation
    type(pieces_type) :: pieces
    real(wp), allocatable :: volumes(:)
    logical :: owned
    integer :: g, n

    call uneven_grid(2, mesh)
    call tiled_box(mesh, [0.1_wp, 0.2_wp], [2.7_wp, 2.0_wp], [7, 5], points, domains)
    allocate (volumes(mesh%cell_count))
    call cell_volumes(mesh, volumes)
    call activate(mesh, volumes, points, activation)
    call whole_points(activation, pieces)
    owned = .true.
    do g = 1, size(pieces%cell)
      do n = pieces%first(g), pieces%first(g + 1) - 1
        owned = owned .and. points%cell(pieces%point(n)) == pieces%cell(g)
      end do
    end do
    call tests%check('whole points lie in the cells that own them', owned)
    call tests%check('each point is one piece', size(pieces%point) == points%count .and. &
      sum(pieces%point) == points%count*(points%count + 1)/2 .and. &
      maxval(abs(pieces%share - 1.0_wp)) < rounding)
  end subroutine check_whole
end module test_domains
