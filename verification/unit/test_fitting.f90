!> Triangles that fit outlines: questions to the lattice answered without rounding, a triangulation that does not depend
!> on the order of its nodes, and a thousand drawn scenes whose cells fill the box, fit what is drawn and have no small
!> angle that the drawing does not dictate.
module test_fitting
  use qsmpm_error, only: error_type
  use qsmpm_fitted_mesh, only: fit_triangles, fitted_mesh_type
  use qsmpm_grid, only: random_after, uniform
  use qsmpm_kinds, only: wp, long, pi
  use qsmpm_lattice, only: in_circle, orientation
  use qsmpm_outline_graph, only: outline_type
  use qsmpm_polygon, only: polygon_area
  use qsmpm_triangulation, only: insert_node, next_of, previous_of, start_triangulation, triangulation_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_fitting

  !> The box of the scenes, and cells along its sides.
  real(wp), parameter :: width = 20.0_wp, height = 12.0_wp
  integer, parameter :: scenes = 1000
  !> Cells of all scenes, and sum of the squares of their sides.
  integer, parameter :: cells_of_scenes = 1418853
  real(wp), parameter :: sides_of_scenes = 1.7762862874967e6_wp
  !> What docs/methods/fitted.md states.
  real(wp), parameter :: least_angle = 15.0_wp*pi/180.0_wp

contains

  !> All tests of the suite.
  subroutine collect_fitting(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('fitting')
    call check_predicates(tests)
    call check_order(tests)
    call check_slope(tests)
    call check_sizes(tests)
    call check_errors(tests)
    call check_scenes(tests)
  end subroutine collect_fitting

  !> Four places on a circle far from the origin, and one of them a step away.
  subroutine check_predicates(tests)
    type(tests_type), intent(inout) :: tests
    integer(long), parameter :: far = 2_long**26
    integer(long) :: a(2), b(2), c(2), d(2)

    a = [0_long, 0_long]
    b = [far, 0_long]
    c = [far, far]
    d = [0_long, far]
    call tests%check('the corners of a square lie on a circle', in_circle(a, b, c, d) == 0)
    call tests%check('a step inside', in_circle(a, b, c, d + [1_long, 0_long]) == 1)
    call tests%check('a step outside', in_circle(a, b, c, d + [0_long, 1_long]) == -1)
    call tests%check('a line is one', orientation(a, c, [far/2, far/2]) == 0_long)
    call tests%check('a step to its left', orientation(a, c, [far/2 - 1_long, far/2]) > 0_long)
  end subroutine check_predicates

  !> A square lattice, where all circles hold four nodes, in three orders: the same triangles.
  subroutine check_order(tests)
    type(tests_type), intent(inout) :: tests
    integer, parameter :: n = 8
    integer :: pass, i, k, stride(3)
    integer(long) :: sums(3)
    type(triangulation_type) :: t
    logical :: is_delaunay

    stride = [1, 37, 59]
    do pass = 1, 3
      call start_triangulation(t, [int(n, long), int(n, long)]*1000_long, 10)
      do i = 0, (n + 1)**2 - 1
        k = mod(i*stride(pass), (n + 1)**2)
        call insert_node(t, [int(mod(k, n + 1), long), int(k/(n + 1), long)]*1000_long, k)
      end do
      call tests%check('all cells of a lattice', t%cell_count == 2*n*n .and. t%node_count == (n + 1)**2)
      sums(pass) = hash_of(t)
      is_delaunay = .true.
      do i = 1, t%cell_count
        do k = 1, 3
          if (t%neighbour(k, i) == 0) cycle
          is_delaunay = is_delaunay .and. in_circle(t%node(:, t%corner(1, i)), t%node(:, t%corner(2, i)), &
            t%node(:, t%corner(3, i)), apex_beyond(t, i, k)) <= 0
        end do
      end do
      call tests%check('no node in the circle of a cell', is_delaunay)
    end do
    call tests%check('the same cells in any order', all(sums == sums(1)))
  end subroutine check_order

  !> The node opposite an edge in the cell beyond.
  pure function apex_beyond(t, cell, k) result(place)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cell, k
    integer(long) :: place(2)
    integer :: j, other

    other = t%neighbour(k, cell)
    do j = 1, 3
      if (all(t%corner(j, other) /= t%corner([next_of(k), previous_of(k)], cell))) place = t%node(:, t%corner(j, other))
    end do
  end function apex_beyond

  !> A sum over the cells that does not depend on their order.
  pure integer(long) function hash_of(t)
    type(triangulation_type), intent(in) :: t
    integer :: i
    integer(long) :: middle(2)

    hash_of = 0_long
    do i = 1, t%cell_count
      middle = sum(t%node(:, t%corner(:, i)), dim=2)
      hash_of = hash_of + mod(middle(1)*7919_long + middle(2)*104729_long, 1000003_long)**2
    end do
  end function hash_of

  !> A slope: its area, its corners, and the same bytes twice.
  subroutine check_slope(tests)
    type(tests_type), intent(inout) :: tests
    type(outline_type) :: outlines(1)
    type(fitted_mesh_type) :: mesh, again
    type(error_type), allocatable :: error
    integer :: k

    outlines(1) = outline('slope', 1, [0.0_wp, 0.0_wp, 20.0_wp, 0.0_wp, 20.0_wp, 3.3_wp, 13.1_wp, 3.3_wp, 8.2_wp, &
      8.7_wp, 0.0_wp, 8.7_wp])
    call fit_triangles(lines(width, 20), lines(height, 12), outlines, 3, mesh, error)
    call fit_triangles(lines(width, 20), lines(height, 12), outlines, 3, again, error)
    call tests%close('area of the cells of a slope', area_of(mesh, 1), polygon_area(outlines(1)%corner), 1.0e-12_wp)
    do k = 1, 6
      call tests%check('a corner is a node', minval(norm2(mesh%position - &
        spread(outlines(1)%corner(:, k), 2, size(mesh%position, 2)), dim=1)) <= 0.0_wp)
    end do
    call tests%check('the same cells again', size(mesh%corner) == size(again%corner) .and. &
      all(abs(mesh%position - again%position) <= 0.0_wp) .and. all(mesh%corner == again%corner))
    call tests%check('as many cells as two for each of the grid', abs(size(mesh%region) - 2*240) < 100)
  end subroutine check_slope

  !> A graded grid grades the triangles; a corner that is named gets small ones; a narrow seam gets two rows.
  subroutine check_sizes(tests)
    type(tests_type), intent(inout) :: tests
    type(outline_type) :: outlines(1)
    type(fitted_mesh_type) :: mesh
    type(error_type), allocatable :: error
    real(wp), parameter :: x(6) = [0.0_wp, 1.0_wp, 2.0_wp, 4.0_wp, 8.0_wp, 16.0_wp], y(3) = [0.0_wp, 1.0_wp, 2.0_wp]
    real(wp) :: near, far

    outlines(1) = outline('all', 1, [0.0_wp, 0.0_wp, 16.0_wp, 0.0_wp, 16.0_wp, 2.0_wp, 0.0_wp, 2.0_wp])
    call fit_triangles(x, y, outlines, 3, mesh, error)
    near = count(mesh%position(1, :) < 2.0_wp)
    far = count(mesh%position(1, :) > 8.0_wp)
    call tests%check('wide cells where lines are far apart', far < 1.5_wp*near .and. far > 0.0_wp)
    call fit_triangles(lines(width, 20), lines(height, 12), outlines, 3, mesh, error, &
      reshape([5.0_wp, 5.0_wp, 1.0_wp, 1.0_wp, 0.125_wp], [5, 1]))
    call tests%check('small cells at a place that asks for them', &
      minval(norm2(mesh%position - spread([5.0_wp, 1.0_wp], 2, size(mesh%position, 2)), dim=1)) < 0.125_wp .and. &
      count(norm2(mesh%position - spread([5.0_wp, 1.0_wp], 2, size(mesh%position, 2)), dim=1) < 0.5_wp) > 8)
    outlines(1) = outline('seam', 1, [0.0_wp, 4.0_wp, 20.0_wp, 5.0_wp, 20.0_wp, 5.3_wp, 0.0_wp, 4.3_wp])
    call fit_triangles(lines(width, 20), lines(height, 12), outlines, 3, mesh, error)
    call tests%close('area of a seam', area_of(mesh, 1), 6.0_wp, 1.0e-6_wp)
    call tests%check('cells of a seam are as wide as it', minval(mesh%angle) > least_angle)
  end subroutine check_sizes

  !> What is too small to be fitted is named, with its place.
  subroutine check_errors(tests)
    type(tests_type), intent(inout) :: tests
    type(outline_type) :: outlines(1)
    type(fitted_mesh_type) :: mesh
    type(error_type), allocatable :: error

    outlines(1) = outline('pebble', 1, [5.0_wp, 5.0_wp, 5.01_wp, 5.0_wp, 5.01_wp, 5.02_wp])
    call fit_triangles(lines(width, 20), lines(height, 12), outlines, 3, mesh, error)
    call tests%check('a body smaller than what is merged', allocated(error))
    if (allocated(error)) call tests%check('its name and place: '//error%message, &
      index(error%message, "'pebble' at (5, 5)") == 1)
    outlines(1) = outline('seam', 1, [0.0_wp, 4.0_wp, 20.0_wp, 5.0_wp, 20.0_wp, 5.03_wp, 0.0_wp, 4.03_wp])
    call fit_triangles(lines(width, 20), lines(height, 12), outlines, 3, mesh, error)
    call tests%check('a body thinner than what is merged', allocated(error))
    if (allocated(error)) call tests%check('is named: '//error%message, index(error%message, "'seam'") == 1)
  end subroutine check_errors

  !> Drawn at random: layers that touch and pinch out, an acute toe, a circle, turned boxes, a thin wall, a sliver,
  !> corners that nearly coincide.
  subroutine check_scenes(tests)
    type(tests_type), intent(inout) :: tests
    type(outline_type), allocatable :: outlines(:)
    type(fitted_mesh_type) :: mesh
    type(error_type), allocatable :: error
    integer :: seed, refused, cell, cells
    real(wp) :: smallest, gap, sides
    logical :: is_turned
    character(len=40) :: found

    refused = 0
    cells = 0
    sides = 0.0_wp
    smallest = pi
    gap = 0.0_wp
    is_turned = .false.
    do seed = 1, scenes
      call draw(seed, outlines)
      call fit_triangles(lines(width, 20), lines(height, 12), outlines, 3, mesh, error)
      if (allocated(error)) then
        refused = refused + 1
        if (index(error%message, "'sliver'") /= 1) call tests%check('scene that is refused: '//error%message, .false.)
        cycle
      end if
      smallest = min(smallest, minval(mesh%angle, mask=.not. mesh%is_dictated))
      gap = max(gap, abs(sum([(area_of(mesh, cell), cell=0, 9)]) - width*height))
      cells = cells + size(mesh%region)
      do cell = 1, size(mesh%region)
        associate (x => mesh%position(:, mesh%corner(:, cell)))
          is_turned = is_turned .or. .not. polygon_area(x) > 0.0_wp
          sides = sides + sum((x - x(:, [2, 3, 1]))**2)
        end associate
      end do
    end do
    call tests%check('few scenes are refused, each for a sliver', refused < scenes/50)
    call tests%check('no angle of a thousand scenes below 15 degrees but where the drawing dictates it', &
      smallest > least_angle)
    call tests%check('cells fill the box', gap < 1.0e-9_wp*width*height)
    call tests%check('no cell is turned over', .not. is_turned)
    ! Own run: sizes, places and diagonals are those of the method of docs/methods/fitted.md as it is.
    write (found, '(i0, 1x, es22.15)') cells, sides
    call tests%check('the meshes have the cells and the sides that they had; found: '//found, &
      cells == cells_of_scenes .and. abs(sides - sides_of_scenes) <= 1.0e-9_wp*sides_of_scenes)
  end subroutine check_scenes

  !> A scene.
  subroutine draw(seed, outlines)
    integer, intent(in) :: seed
    type(outline_type), allocatable, intent(out) :: outlines(:)
    integer(long) :: random
    real(wp) :: u(40), x(4), low(4), high(4), angle
    integer :: i, k, n

    random = random_after(seed, 7_long)
    do i = 1, size(u)
      call uniform(random, u(i))
    end do
    allocate (outlines(9))
    n = 0
    x = [0.0_wp, 1.0_wp + 8.0_wp*u(1), 11.0_wp + 8.0_wp*u(2), width]
    low = 0.0_wp
    do i = 1, 1 + int(3.0_wp*u(3))
      high = low + merge(spread(0.3_wp + 2.0_wp*u(4), 1, 4), 2.0_wp*u([(4*i + k, k=1, 4)]), u(5) < 0.3_wp)
      if (u(6) < 0.4_wp) high(4) = low(4)
      n = n + 1
      outlines(n) = outline('layer', i, [x(1), low(1), x(2), low(2), x(3), low(3), x(4), low(4), x(4), high(4), x(3), &
        high(3), x(2), high(2), x(1), high(1)])
      low = high
    end do
    if (u(21) < 0.5_wp) then
      angle = (15.0_wp + 30.0_wp*u(22))*pi/180.0_wp
      n = n + 1
      outlines(n) = outline('fill', 5, [0.0_wp, low(1), x(2), low(2), x(3), low(3), x(3) - 3.0_wp, &
        low(3) + 3.0_wp*tan(angle), 0.0_wp, low(3) + 3.0_wp*tan(angle)])
    end if
    if (u(23) < 0.4_wp) then
      n = n + 1
      outlines(n) = outline('pipe', 6, circle(width*u(24), 1.0_wp + 10.0_wp*u(25), 0.3_wp + 2.7_wp*u(26)))
    end if
    if (u(27) < 0.4_wp) then
      n = n + 1
      outlines(n) = outline('box', 7, turned_box(4.0_wp + 12.0_wp*u(28), 3.0_wp + 6.0_wp*u(29), 2.0_wp + 6.0_wp*u(30), &
        0.1_wp + 2.9_wp*u(31), 3.0_wp*u(32)))
    end if
    if (u(33) < 0.3_wp) then
      n = n + 1
      outlines(n) = outline('wall', 8, [3.0_wp + 14.0_wp*u(34), 1.0_wp, 3.1_wp + 14.0_wp*u(34), 1.0_wp, &
        3.1_wp + 14.0_wp*u(34), 8.0_wp, 3.1_wp + 14.0_wp*u(34) - 0.001_wp, 8.001_wp, 3.0_wp + 14.0_wp*u(34), 8.0_wp])
    end if
    if (u(35) < 0.25_wp) then
      n = n + 1
      outlines(n) = outline('sliver', 9, [24.0_wp*u(36) - 2.0_wp, 5.0_wp, 24.0_wp*u(37) - 2.0_wp, 14.0_wp*u(38) - &
        1.0_wp, 24.0_wp*u(39) - 2.0_wp, 14.0_wp*u(40) - 1.0_wp])
    end if
    outlines = outlines(:n)
  end subroutine draw

  pure function outline(name, region, corner) result(one)
    character(len=*), intent(in) :: name
    integer, intent(in) :: region
    !> x and y in turn.
    real(wp), intent(in) :: corner(:)
    type(outline_type) :: one

    one%name = name
    one%region = region
    allocate (one%corner(2, size(corner)/2), source=reshape(corner, [2, size(corner)/2]))
  end function outline

  pure function circle(x, y, radius) result(corner)
    real(wp), intent(in) :: x, y, radius
    real(wp) :: corner(128)
    integer :: i

    do i = 1, 64
      corner(2*i - 1:2*i) = [x, y] + radius*[cos(pi*i/32.0_wp), sin(pi*i/32.0_wp)]
    end do
  end function circle

  pure function turned_box(x, y, length, thickness, angle) result(corner)
    real(wp), intent(in) :: x, y, length, thickness, angle
    real(wp) :: corner(8)
    real(wp), parameter :: sign(2, 4) = reshape([-0.5_wp, -0.5_wp, 0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp, -0.5_wp, 0.5_wp], &
      [2, 4])
    integer :: i

    do i = 1, 4
      corner(2*i - 1) = x + length*sign(1, i)*cos(angle) - thickness*sign(2, i)*sin(angle)
      corner(2*i) = y + length*sign(1, i)*sin(angle) + thickness*sign(2, i)*cos(angle)
    end do
  end function turned_box

  pure function lines(length, count) result(x)
    real(wp), intent(in) :: length
    integer, intent(in) :: count
    real(wp) :: x(count + 1)
    integer :: i

    x = [(length*i/count, i=0, count)]
  end function lines

  !> Area of the cells of a region.
  pure real(wp) function area_of(mesh, region)
    type(fitted_mesh_type), intent(in) :: mesh
    integer, intent(in) :: region
    integer :: cell

    area_of = 0.0_wp
    do cell = 1, size(mesh%region)
      if (mesh%region(cell) == region) area_of = area_of + polygon_area(mesh%position(:, mesh%corner(:, cell)))
    end do
  end function area_of
end module test_fitting
