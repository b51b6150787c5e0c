!> Structured background meshes for every element kind: bricks between given lines, cut into
!> triangles, wedges or tetrahedra where asked for.
!>
!> Triangles come two a quadrilateral with right, left, alternating or random diagonals; wedges are
!> such triangles extruded along z. A quadrilateral whose diagonal lies on a kept segment (an edge
!> of a body) gets that diagonal, and nodes on kept segments and on the boundary stay where they
!> are when inner nodes are shifted at random. The random numbers are our own, so
!> a mesh is the same on every machine. Mid nodes are shared by an edge table (`qsmpm_mid_nodes`).
!>
!> A mesh may be a part of the grid (`qsmpm_grid_window`): places, diagonals, labels and order are those
!> of the whole.
!>
!> The random numbers of a grid: a linear congruential generator (Park and Miller 1988) that can start
!> anywhere in its sequence, so that a part of a grid is shifted and cut as it is in the whole.
!>
!>   r(n+1) = a r(n) mod m,   hence   r(n) = (a**n mod m) r(0) mod m
module qsmpm_grid
  use qsmpm_kinds, only: wp, long
  use qsmpm_element, only: tri3, quad4, hex8, wedge6, linear_kind, element_order, local_dimension
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: cell_size
  use qsmpm_mid_nodes, only: add_mid_nodes
  use qsmpm_grid_window, only: window_type, cells_of, label_mesh
  implicit none
  private

  public :: grid_type, grid_axis_type, make_grid, whole_window, pieces_of, uniform, random_after

  !> How diagonals run.
  integer, parameter, public :: diagonal_right = 1, diagonal_left = 2, diagonal_random = 3, diagonal_alternate = 4

  !> Lines along one axis.
  type :: grid_axis_type
    real(wp), allocatable :: lines(:)
  end type grid_axis_type

  !> What to generate.
  type :: grid_type
    !> Element kind.
    integer :: kind = 0
    type(grid_axis_type) :: axes(3)
    integer :: diagonal = diagonal_right
    !> Shift of inner nodes as a share of the smallest spacing around, 0 to 0.3.
    real(wp) :: perturbation = 0.0_wp
    integer :: seed = 1
    !> x1, y1, x2, y2 of edges to respect, (4,n).
    real(wp), allocatable :: kept(:, :)
  end type grid_type

  !> The six tetrahedra of a brick around its diagonal 1-7 (corners in hex order).
  integer, parameter :: tetrahedra(4, 6) = reshape([1, 2, 3, 7, 1, 3, 4, 7, 1, 4, 8, 7, 1, 8, 5, 7, &
    1, 5, 6, 7, 1, 6, 2, 7], [4, 6])

  integer(long), parameter :: modulus = 2147483647_long, factor = 48271_long

contains

  !> Generate nodes and cells (no topology).
  subroutine make_grid(grid, mesh, window)
    type(grid_type), intent(in) :: grid
    type(mesh_type), intent(out) :: mesh
    !> Part of the grid to generate; all of it when absent.
    type(window_type), intent(in), optional :: window
    type(mesh_type) :: corner
    integer :: a

    if (present(window)) then
      call make_part(grid, window, mesh)
    else
      call make_part(grid, whole_window(grid), mesh)
    end if
    call make_part(grid, window_type(), corner)
    mesh%first_size = cell_size(corner, 1)
    mesh%is_box = .true.
    allocate (mesh%bounds(mesh%dimension, 2))
    do a = 1, mesh%dimension
      mesh%bounds(a, :) = [grid%axes(a)%lines(1), grid%axes(a)%lines(size(grid%axes(a)%lines))]
    end do
  end subroutine make_grid

  !> All cells of a grid.
  pure type(window_type) function whole_window(grid) result(window)
    type(grid_type), intent(in) :: grid
    integer :: a

    do a = 1, local_dimension(grid%kind)
      window%last(a) = size(grid%axes(a)%lines) - 1
    end do
  end function whole_window

  !> Cells a brick of the grid is cut into.
  pure integer function pieces_of(grid)
    type(grid_type), intent(in) :: grid
    integer, allocatable :: cells(:, :)

    call cut_brick(linear_kind(grid%kind), [1, 2, 3, 4, 5, 6, 7, 8], .false., cells)
    pieces_of = size(cells, 2)
  end function pieces_of

  !> Generate a part of a grid.
  subroutine make_part(grid, window, mesh)
    type(grid_type), intent(in) :: grid
    !> The part.
    type(window_type), intent(in) :: window
    type(mesh_type), intent(out) :: mesh
    integer, allocatable :: ends(:, :)

    mesh%dimension = local_dimension(grid%kind)
    call place_nodes(grid, window, mesh)
    call connect(grid, linear_kind(grid%kind), window, mesh)
    allocate (ends(2, 0))
    if (element_order(grid%kind) == 2) call add_mid_nodes(grid%kind, mesh, ends)
    call label_mesh(cells_of(whole_window(grid)), window, ends, mesh)
  end subroutine make_part

  !> Corner nodes, x fastest; inner ones shifted, alike in all layers.
  subroutine place_nodes(grid, window, mesh)
    type(grid_type), intent(in) :: grid
    !> The part of it.
    type(window_type), intent(in) :: window
    type(mesh_type), intent(inout) :: mesh
    real(wp) :: shift(2), x(2)
    integer(long) :: random
    integer :: i, j, k, n, nx, ny, layers

    nx = size(grid%axes(1)%lines)
    ny = size(grid%axes(2)%lines)
    layers = 1
    if (mesh%dimension == 3) layers = window%last(3) - window%first(3) + 2
    mesh%node_count = (window%last(1) - window%first(1) + 2)*(window%last(2) - window%first(2) + 2)*layers
    allocate (mesh%coordinates(mesh%dimension, mesh%node_count))
    n = 0
    do j = window%first(2), window%last(2) + 1
      random = random_after(grid%seed, 2*(int(j - 1, long)*nx + window%first(1) - 1))
      do i = window%first(1), window%last(1) + 1
        n = n + 1
        x = [grid%axes(1)%lines(i), grid%axes(2)%lines(j)]
        call uniform(random, shift(1))
        call uniform(random, shift(2))
        if (i > 1 .and. i < nx .and. j > 1 .and. j < ny .and. grid%perturbation > 0.0_wp) then
          if (.not. on_kept(grid, x)) x = x + grid%perturbation*(2.0_wp*shift - 1.0_wp) &
            *min(line_spacing(grid%axes(1)%lines, i), line_spacing(grid%axes(2)%lines, j))
        end if
        do k = 1, layers
          associate (node => n + (k - 1)*(mesh%node_count/layers))
            mesh%coordinates(:2, node) = x
            if (mesh%dimension == 3) mesh%coordinates(3, node) = grid%axes(3)%lines(window%first(3) + k - 1)
          end associate
        end do
      end do
    end do
  end subroutine place_nodes

  !> Smaller distance of an inner line to its neighbours.
  pure real(wp) function line_spacing(lines, i) result(distance)
    real(wp), intent(in) :: lines(:)
    integer, intent(in) :: i

    distance = min(lines(i) - lines(i - 1), lines(i + 1) - lines(i))
  end function line_spacing

  !> True when a place lies on a kept segment.
  pure logical function on_kept(grid, x) result(yes)
    type(grid_type), intent(in) :: grid
    !> Place (dimension).
    real(wp), intent(in) :: x(2)
    real(wp) :: along(2), off(2), length
    integer :: k

    yes = .false.
    if (.not. allocated(grid%kept)) return
    do k = 1, size(grid%kept, 2)
      along = grid%kept(3:4, k) - grid%kept(1:2, k)
      length = norm2(along)
      if (.not. length > 0.0_wp) cycle
      off = x - grid%kept(1:2, k)
      yes = yes .or. (abs(along(1)*off(2) - along(2)*off(1)) <= 1.0e-8_wp*length**2 .and. &
        dot_product(off, along) >= -1.0e-8_wp*length**2 .and. &
        dot_product(off, along) <= (1.0_wp + 1.0e-8_wp)*length**2)
    end do
  end function on_kept

  !> Cells of the corners, brick by brick.
  subroutine connect(grid, base, window, mesh)
    type(grid_type), intent(in) :: grid
    !> Linear kind of the cells.
    integer, intent(in) :: base
    !> The part of the grid.
    type(window_type), intent(in) :: window
    !> Nodes in, cells out.
    type(mesh_type), intent(inout) :: mesh
    logical, allocatable :: falls(:, :)
    integer, allocatable :: cells(:, :)
    integer :: i, j, k, n, nx, ny, corner(8), bricks(3)

    call run_diagonals(grid, window, falls)
    bricks = cells_of(window)
    nx = bricks(1) + 1
    ny = bricks(2) + 1
    call cut_brick(base, [1, 2, 3, 4, 5, 6, 7, 8], .false., cells)
    mesh%cell_count = size(cells, 2)*product(bricks)
    allocate (mesh%cell_kind(mesh%cell_count), source=base)
    mesh%cell_first = [(1 + k*size(cells, 1), k=0, mesh%cell_count)]
    allocate (mesh%cell_nodes(mesh%cell_count*size(cells, 1)))
    n = 0
    do k = 1, bricks(3)
      do j = 1, bricks(2)
        do i = 1, bricks(1)
          corner(1:4) = (k - 1)*nx*ny + (j - 1)*nx + i + [0, 1, nx + 1, nx]
          corner(5:8) = corner(1:4) + nx*ny
          call cut_brick(base, corner, falls(i, j), cells)
          mesh%cell_nodes(n + 1:n + size(cells)) = reshape(cells, [size(cells)])
          n = n + size(cells)
        end do
      end do
    end do
  end subroutine connect

  !> Which diagonals of a part of a grid fall.
  subroutine run_diagonals(grid, window, falls)
    type(grid_type), intent(in) :: grid
    !> The part of the grid.
    type(window_type), intent(in) :: window
    !> Along x and y.
    logical, allocatable, intent(out) :: falls(:, :)
    integer(long) :: random, drawn
    integer :: i, j, nx, ny

    nx = size(grid%axes(1)%lines)
    ny = size(grid%axes(2)%lines)
    allocate (falls(window%last(1) - window%first(1) + 1, window%last(2) - window%first(2) + 1))
    do j = window%first(2), window%last(2)
      ! The shifts of all nodes have been drawn before.
      drawn = 2*int(nx, long)*ny + int(j - 1, long)*(nx - 1) + window%first(1) - 1
      random = random_after(grid%seed, drawn)
      do i = window%first(1), window%last(1)
        falls(i - window%first(1) + 1, j - window%first(2) + 1) = diagonal_falls(grid, i, j, random)
      end do
    end do
  end subroutine run_diagonals

  !> The cells of one quadrilateral or brick.
  pure subroutine cut_brick(base, corner, falls, cells)
    !> Linear kind of the cells.
    integer, intent(in) :: base
    !> Corners, bottom then top (8); a plane cell uses the first four.
    integer, intent(in) :: corner(8)
    !> The diagonal falls from upper left to lower right.
    logical, intent(in) :: falls
    !> (corners of a cell, cells)
    integer, allocatable, intent(out) :: cells(:, :)
    integer :: pieces(3, 2), t

    pieces = merge(reshape([1, 2, 4, 2, 3, 4], [3, 2]), reshape([1, 2, 3, 1, 3, 4], [3, 2]), falls)
    select case (base)
    case (quad4)
      allocate (cells(4, 1))
      cells(:, 1) = corner(1:4)
    case (hex8)
      allocate (cells(8, 1))
      cells(:, 1) = corner
    case (tri3)
      allocate (cells(3, 2))
      cells(:, 1) = corner(pieces(:, 1))
      cells(:, 2) = corner(pieces(:, 2))
    case (wedge6)
      allocate (cells(6, 2))
      do t = 1, 2
        cells(:, t) = [corner(pieces(:, t)), corner(4 + pieces(:, t))]
      end do
    case default
      allocate (cells(4, 6))
      do t = 1, 6
        cells(:, t) = corner(tetrahedra(:, t))
      end do
    end select
  end subroutine cut_brick

  !> True when the diagonal of a quadrilateral falls from upper left to lower right.
  logical function diagonal_falls(grid, i, j, random) result(falls)
    type(grid_type), intent(in) :: grid
    integer, intent(in) :: i, j
    !> State of the generator.
    integer(long), intent(inout) :: random
    real(wp) :: low(2), high(2), u

    low = [grid%axes(1)%lines(i), grid%axes(2)%lines(j)]
    high = [grid%axes(1)%lines(i + 1), grid%axes(2)%lines(j + 1)]
    select case (grid%diagonal)
    case (diagonal_left)
      falls = .true.
    case (diagonal_random)
      call uniform(random, u)
      falls = u < 0.5_wp
    case (diagonal_alternate)
      falls = mod(i + j, 2) == 1
    case default
      falls = .false.
    end select
    if (on_kept(grid, 0.5_wp*(low + high))) then
      if (on_kept(grid, [low(1), high(2)]) .and. on_kept(grid, [high(1), low(2)])) falls = .true.
      if (on_kept(grid, low) .and. on_kept(grid, high)) falls = .false.
    end if
  end function diagonal_falls

  !> Next number between 0 and 1.
  subroutine uniform(random, u)
    !> State of the generator.
    integer(long), intent(inout) :: random
    !> The number.
    real(wp), intent(out) :: u

    random = mod(factor*random, modulus)
    u = real(random, wp)/real(modulus, wp)
  end subroutine uniform

  !> State of the generator after some numbers, by squaring.
  pure integer(long) function random_after(seed, count) result(random)
    !> Start of the sequence.
    integer, intent(in) :: seed
    !> How many numbers have been drawn.
    integer(long), intent(in) :: count
    integer(long) :: power, left

    random = max(1_long, mod(int(seed, long), modulus))
    power = factor
    left = count
    do while (left > 0)
      if (mod(left, 2_long) == 1) random = mod(random*power, modulus)
      power = mod(power*power, modulus)
      left = left/2
    end do
  end function random_after
end module qsmpm_grid
