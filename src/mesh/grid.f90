!> Structured background meshes for every element kind: bricks between given lines, cut into
!> triangles, wedges or tetrahedra where asked for.
!>
!> Triangles come two a quadrilateral with right, left, alternating or random diagonals; wedges are
!> such triangles extruded along z. A quadrilateral whose diagonal lies on a kept segment (an edge
!> of a body) gets that diagonal, and nodes on kept segments and on the boundary stay where they
!> are when inner nodes are shifted at random. The random numbers are this module's own, so a mesh
!> is the same on every machine. Mid nodes are shared by an edge table (`qsmpm_mid_nodes`).
module qsmpm_grid
  use qsmpm_kinds, only: wp, long
  use qsmpm_element, only: tri3, quad4, hex8, wedge6, linear_kind, element_order, &
    local_dimension
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mid_nodes, only: add_mid_nodes
  implicit none
  private

  public :: grid_type, grid_axis_type, make_grid

  !> How diagonals run.
  integer, parameter, public :: diagonal_right = 1, diagonal_left = 2, diagonal_random = 3, &
    diagonal_alternate = 4

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

contains

  !> Generate nodes and cells (no topology).
  subroutine make_grid(grid, mesh)
    !> What to generate.
    type(grid_type), intent(in) :: grid
    !> The mesh.
    type(mesh_type), intent(out) :: mesh
    integer(long) :: random
    integer :: base, layers

    base = linear_kind(grid%kind)
    mesh%dimension = local_dimension(grid%kind)
    layers = 1
    if (mesh%dimension == 3) layers = size(grid%axes(3)%lines)
    random = int(grid%seed, long)
    call place_nodes(grid, layers, random, mesh)
    call connect(grid, base, layers, random, mesh)
    if (element_order(grid%kind) == 2) call add_mid_nodes(grid%kind, mesh)
    call label(mesh)
  end subroutine make_grid

  !> Number nodes and cells from 1.
  pure subroutine label(mesh)
    !> The mesh.
    type(mesh_type), intent(inout) :: mesh
    integer :: i

    mesh%node_label = [(i, i=1, mesh%node_count)]
    mesh%cell_label = [(i, i=1, mesh%cell_count)]
    allocate (mesh%node_sets(0), mesh%cell_sets(0), mesh%face_sets(0))
  end subroutine label

  !> Corner nodes, x fastest; inner ones shifted, alike in all layers.
  subroutine place_nodes(grid, layers, random, mesh)
    !> What to generate.
    type(grid_type), intent(in) :: grid
    integer, intent(in) :: layers
    !> State of the generator.
    integer(long), intent(inout) :: random
    !> The mesh.
    type(mesh_type), intent(inout) :: mesh
    real(wp) :: shift(2), x(2)
    integer :: i, j, k, n, nx, ny

    nx = size(grid%axes(1)%lines)
    ny = size(grid%axes(2)%lines)
    mesh%node_count = nx*ny*layers
    allocate (mesh%coordinates(mesh%dimension, mesh%node_count))
    do j = 1, ny
      do i = 1, nx
        x = [grid%axes(1)%lines(i), grid%axes(2)%lines(j)]
        shift = [uniform(random), uniform(random)]
        if (i > 1 .and. i < nx .and. j > 1 .and. j < ny) then
          if (.not. on_kept(grid, x)) x = x + grid%perturbation*(2.0_wp*shift - 1.0_wp) &
            *min(line_spacing(grid%axes(1)%lines, i), line_spacing(grid%axes(2)%lines, j))
        end if
        do k = 1, layers
          n = ((k - 1)*ny + j - 1)*nx + i
          mesh%coordinates(:2, n) = x
          if (mesh%dimension == 3) mesh%coordinates(3, n) = grid%axes(3)%lines(k)
        end do
      end do
    end do
  end subroutine place_nodes

  !> Smaller distance of an inner line to its neighbours.
  pure function line_spacing(lines, i) result(distance)
    real(wp), intent(in) :: lines(:)
    integer, intent(in) :: i
    real(wp) :: distance

    distance = min(lines(i) - lines(i - 1), lines(i + 1) - lines(i))
  end function line_spacing

  !> True when a place lies on a kept segment.
  pure function on_kept(grid, x) result(yes)
    !> What to generate.
    type(grid_type), intent(in) :: grid
    !> Place (dimension).
    real(wp), intent(in) :: x(2)
    logical :: yes
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

  !> Next number between 0 and 1 of a linear congruential generator (Park and Miller 1988).
  function uniform(random) result(u)
    !> State of the generator.
    integer(long), intent(inout) :: random
    real(wp) :: u
    integer(long), parameter :: modulus = 2147483647_long, factor = 48271_long

    random = mod(factor*max(random, 1_long), modulus)
    u = real(random, wp)/real(modulus, wp)
  end function uniform

  !> Cells of the corners, brick by brick.
  subroutine connect(grid, base, layers, random, mesh)
    !> What to generate.
    type(grid_type), intent(in) :: grid
    !> Linear kind of the cells, and number of node layers.
    integer, intent(in) :: base, layers
    !> State of the generator.
    integer(long), intent(inout) :: random
    !> Nodes in, cells out.
    type(mesh_type), intent(inout) :: mesh
    logical :: falls(size(grid%axes(1)%lines) - 1, size(grid%axes(2)%lines) - 1)
    integer, allocatable :: cells(:, :)
    integer :: i, j, k, n, nx, ny, corner(8)

    nx = size(grid%axes(1)%lines)
    ny = size(grid%axes(2)%lines)
    do j = 1, ny - 1
      do i = 1, nx - 1
        falls(i, j) = diagonal_falls(grid, i, j, random)
      end do
    end do
    call cut_brick(base, [1, 2, 3, 4, 5, 6, 7, 8], .false., cells)
    mesh%cell_count = size(cells, 2)*(nx - 1)*(ny - 1)*max(1, layers - 1)
    allocate (mesh%cell_kind(mesh%cell_count), source=base)
    mesh%cell_first = [(1 + k*size(cells, 1), k=0, mesh%cell_count)]
    allocate (mesh%cell_nodes(mesh%cell_count*size(cells, 1)))
    n = 0
    do k = 1, max(1, layers - 1)
      do j = 1, ny - 1
        do i = 1, nx - 1
          corner(1:4) = (k - 1)*nx*ny + (j - 1)*nx + i + [0, 1, nx + 1, nx]
          corner(5:8) = corner(1:4) + nx*ny
          call cut_brick(base, corner, falls(i, j), cells)
          mesh%cell_nodes(n + 1:n + size(cells)) = reshape(cells, [size(cells)])
          n = n + size(cells)
        end do
      end do
    end do
  end subroutine connect

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
  function diagonal_falls(grid, i, j, random) result(falls)
    !> What to generate.
    type(grid_type), intent(in) :: grid
    integer, intent(in) :: i, j
    !> State of the generator.
    integer(long), intent(inout) :: random
    logical :: falls
    real(wp) :: low(2), high(2)

    low = [grid%axes(1)%lines(i), grid%axes(2)%lines(j)]
    high = [grid%axes(1)%lines(i + 1), grid%axes(2)%lines(j + 1)]
    select case (grid%diagonal)
    case (diagonal_left)
      falls = .true.
    case (diagonal_random)
      falls = uniform(random) < 0.5_wp
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
end module qsmpm_grid
