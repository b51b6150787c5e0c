!> Bodies that end inside cells: volume, first moment and boxes of their points.
module test_body_pieces
  use qsmpm_kinds, only: wp, pi
  use qsmpm_error, only: error_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: interpolate
  use qsmpm_element, only: shape_functions
  use qsmpm_polygon, only: polygon_area, polygon_centroid
  use qsmpm_polygon_pieces, only: polygon_list_type, begin_list, pieces_in_convex
  use qsmpm_piece_list, only: piece_list_type, add_piece, merge_small_pieces, piece_type
  use qsmpm_seeding, only: body_shape_type, seed_list_type, seed_body, seed_even
  use sample_models, only: sample_grid
  use testing, only: tests_type
  implicit none
  private

  public :: collect_body_pieces, first_moment

  !> Rounding of sums over a few hundred pieces of a body of size one.
  real(wp), parameter :: rounding = 1.0e-12_wp
  !> A slanted star-like outline with two re-entrant corners; no vertex or edge on a grid line.
  real(wp), parameter :: slanted(2, 8) = reshape([0.13_wp, 0.21_wp, 0.52_wp, 0.11_wp, 0.87_wp, 0.33_wp, &
    0.61_wp, 0.44_wp, 0.79_wp, 0.83_wp, 0.47_wp, 0.57_wp, 0.24_wp, 0.91_wp, 0.36_wp, 0.46_wp], [2, 8])
  !> A comb: two prongs of width 0.08 in one column of cells, vertices and edges on grid lines.
  real(wp), parameter :: comb(2, 8) = reshape([0.2_wp, 0.2_wp, 0.4_wp, 0.2_wp, 0.4_wp, 0.8_wp, 0.32_wp, &
    0.8_wp, 0.32_wp, 0.3_wp, 0.28_wp, 0.3_wp, 0.28_wp, 0.8_wp, 0.2_wp, 0.8_wp], [2, 8])

contains

  !> All checks.
  subroutine collect_body_pieces(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    character(len=5), parameter :: names(4) = [character(len=5) :: 'QUAD4', 'QUAD8', 'HEX8', 'HEX20']
    integer, parameter :: counts(4) = [4, 9, 8, 27]
    integer :: i, k

    call tests%start('body_pieces')
    do i = 1, size(names)
      call check_outline(tests, 'a 64-gon in ', circle(64), trim(names(i)), counts(i), 0.0_wp)
      call check_outline(tests, 'a slanted outline in ', slanted, trim(names(i)), counts(i), 0.0_wp)
      call check_outline(tests, 'a comb along grid lines in ', comb, trim(names(i)), counts(i), 0.0_wp)
      call check_outline(tests, 'a slanted outline in distorted ', slanted, trim(names(i)), counts(i), 0.2_wp)
    end do
    do k = 1, 6
      call check_regular(tests, 'QUAD4', k, 2)
      if (k <= 4) call check_regular(tests, 'HEX8', k, 3)
    end do
    call check_two_prongs(tests)
    call check_merging(tests)
    call check_cone(tests)
    call check_box_shares(tests)
  end subroutine collect_body_pieces

  !> Corners of a circle.
  function circle(n) result(outline)
    !> Number of corners.
    integer, intent(in) :: n
    real(wp) :: outline(2, n)
    integer :: k

    outline = reshape([(0.48_wp + 0.37_wp*cos(2*pi*k/n), 0.51_wp + 0.37_wp*sin(2*pi*k/n), k=1, n)], [2, n])
  end function circle

  !> Volume and volume times place of seeds.
  subroutine first_moment(mesh, list, volume, moment)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The seeds.
    type(seed_list_type), intent(in) :: list
    !> Sum of volumes.
    real(wp), intent(out) :: volume
    !> (dimension)
    real(wp), intent(out) :: moment(:)
    real(wp) :: functions(20)
    integer :: i, n

    volume = 0.0_wp
    moment = 0.0_wp
    do i = 1, list%count
      n = mesh%cell_first(list%cell(i) + 1) - mesh%cell_first(list%cell(i))
      call shape_functions(mesh%cell_kind(list%cell(i)), list%local(:, i), functions(:n))
      volume = volume + list%volume(i)
      moment = moment + list%volume(i)*interpolate(mesh, list%cell(i), functions(:n), mesh%coordinates)
    end do
  end subroutine first_moment

  !> Area and centroid of an outline are exact for five and for seven cells a side.
  subroutine check_outline(tests, name, outline, element, count, perturbation)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> What the outline is, the element, and points of an element.
    character(len=*), intent(in) :: name, element
    real(wp), intent(in) :: outline(:, :)
    integer, intent(in) :: count
    !> Shift of inner nodes.
    real(wp), intent(in) :: perturbation
    type(mesh_type) :: mesh
    type(body_shape_type) :: shape
    type(seed_list_type) :: list
    type(error_type), allocatable :: error
    real(wp) :: volume, height, outside, report_error, shortened
    real(wp), allocatable :: moment(:)
    integer :: n

    allocate (shape%outline, source=outline)
    shape%high = 0.83_wp
    do n = 5, 7, 2
      list = seed_list_type()
      call sample_grid(element, n, perturbation, mesh)
      height = merge(0.83_wp, 1.0_wp, mesh%dimension == 3)
      if (allocated(moment)) deallocate (moment)
      allocate (moment(mesh%dimension))
      call seed_body(mesh, shape, 1, count, seed_even, 0, list, error)
      call tests%check(name//element//' is seeded', .not. allocated(error) .and. list%count > 0)
      call first_moment(mesh, list, volume, moment)
      call tests%close(name//element//' keeps its volume', volume, height*polygon_area(outline), rounding)
      call tests%close(name//element//' keeps its centroid', &
        norm2(moment(:2)/volume - polygon_centroid(outline)), 0.0_wp, rounding)
      if (mesh%dimension == 3) call tests%close(name//element//' keeps its middle height', &
        moment(3)/volume, 0.5_wp*height, rounding)
      call look_at_boxes(mesh, list, outside, report_error, shortened)
      call tests%close(name//element//': no box leaves its cell', outside, 0.0_wp, rounding)
      call tests%close(name//element//': boxes have the volumes of the points unless they end at a side of their cell', &
        report_error, 0.0_wp, rounding)
      ! A box with the area of a right triangle around its centroid reaches beyond its legs, 1/9 of it; with the volume
      ! of the corner of a brick, 1/4 of it. Not all of the body is such pieces. No functions are averaged in QUAD8, HEX20.
      if (element == 'QUAD4' .or. element == 'HEX8') call tests%check(name//element// &
        ': boxes at sides of their cells lack less than a quarter of the body', shortened < 0.25_wp)
      call tests%check(name//element//': no point has less than 1e-3 of a sub-cell but in a sliver', &
        no_dust(mesh, list, count))
    end do
  end subroutine check_outline

  !> How the boxes of the points fit their cells and their volumes.
  subroutine look_at_boxes(mesh, list, outside, report_error, shortened)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The seeds.
    type(seed_list_type), intent(in) :: list
    !> Furthest reach beyond a cell.
    real(wp), intent(out) :: outside
    !> Largest difference of volumes of a box and its point: of those that end at a side of the cell the excess only.
    real(wp), intent(out) :: report_error
    !> Volume that boxes at sides of cells lack, as a share of all.
    real(wp), intent(out) :: shortened
    real(wp) :: gap, x(mesh%dimension), functions(20)
    integer :: i, a, n

    outside = 0.0_wp
    report_error = 0.0_wp
    shortened = 0.0_wp
    do i = 1, list%count
      associate (nodes => mesh%cell_nodes(mesh%cell_first(list%cell(i)):mesh%cell_first(list%cell(i) + 1) - 1))
        n = size(nodes)
        call shape_functions(mesh%cell_kind(list%cell(i)), list%local(:, i), functions(:n))
        x = interpolate(mesh, list%cell(i), functions(:n), mesh%coordinates)
        gap = huge(gap)
        do a = 1, mesh%dimension
          gap = min(gap, x(a) - list%vector(a, i) - minval(mesh%coordinates(a, nodes)), &
            maxval(mesh%coordinates(a, nodes)) - x(a) - list%vector(a, i))
        end do
      end associate
      outside = max(outside, -gap)
      shortened = shortened + max(0.0_wp, list%volume(i) - product(2*list%vector(:, i)))
      if (gap > rounding) then
        report_error = max(report_error, abs(product(2*list%vector(:, i)) - list%volume(i)))
      else
        report_error = max(report_error, product(2*list%vector(:, i)) - list%volume(i))
      end if
    end do
    shortened = shortened/sum(list%volume(:list%count))
  end subroutine look_at_boxes

  !> True when each piece below 1e-3 of a sub-cell is alone in its cell.
  logical function no_dust(mesh, list, count)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The seeds.
    type(seed_list_type), intent(in) :: list
    !> Points of a full cell.
    integer, intent(in) :: count
    integer :: held(mesh%cell_count), i

    held = 0
    do i = 1, list%count
      held(list%cell(i)) = held(list%cell(i)) + 1
    end do
    no_dust = .true.
    do i = 1, list%count
      ! Cells of a distorted mesh are no smaller than a quarter of a regular one; a piece has 8 points at most.
      if (list%volume(i) < 0.25e-3_wp/(8*mesh%cell_count*count)) no_dust = no_dust &
        .and. held(list%cell(i)) <= 8
    end do
  end function no_dust

  !> k points a direction are the centres of equal sub-cells, with boxes that are the sub-cells.
  subroutine check_regular(tests, element, k, dimension)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> Element.
    character(len=*), intent(in) :: element
    !> Points a direction; 2 or 3.
    integer, intent(in) :: k, dimension
    type(mesh_type) :: mesh
    type(body_shape_type) :: shape
    type(seed_list_type) :: list
    type(error_type), allocatable :: error
    real(wp) :: x(dimension), report_error
    character(len=40) :: name
    integer :: i

    write (name, '(a, i0, a)') element//' with ', k**dimension, ' points:'
    call sample_grid(element, 1, 0.0_wp, mesh)
    call seed_body(mesh, shape, 1, k**dimension, seed_even, 0, list, error)
    call tests%check(trim(name)//' as many as asked', list%count == k**dimension)
    report_error = 0.0_wp
    do i = 1, list%count
      ! Places count in sub-cells from their corner: a centre is at a half.
      x = 0.5_wp*k*(list%local(:, i) + 1.0_wp)
      report_error = max(report_error, maxval(abs(x - floor(x) - 0.5_wp)))
    end do
    call tests%close(trim(name)//' centres of sub-cells', report_error, 0.0_wp, 1.0e-14_wp)
    call tests%close(trim(name)//' boxes are sub-cells', &
      maxval(abs(list%vector(:, :list%count) - 0.5_wp/k)), 0.0_wp, 1.0e-14_wp)
  end subroutine check_regular

  !> A line through two prongs leaves two polygons, each of the area of one.
  subroutine check_two_prongs(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    type(polygon_list_type) :: whole, pieces
    real(wp), parameter :: cell(2, 4) = reshape([0.2_wp, 0.4_wp, 0.4_wp, 0.4_wp, 0.4_wp, 0.6_wp, 0.2_wp, &
      0.6_wp], [2, 4])
    integer :: i

    call begin_list(comb, whole)
    call pieces_in_convex(whole, cell, pieces)
    call tests%check('a cell over two prongs holds two pieces', pieces%count == 2)
    do i = 1, pieces%count
      call tests%close('a piece is one prong', &
        polygon_area(pieces%vertices(:, pieces%first(i):pieces%first(i + 1) - 1)), 0.016_wp, 1.0e-15_wp)
    end do
  end subroutine check_two_prongs

  !> A small piece goes to the largest one around it; the last piece stays.
  subroutine check_merging(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    type(piece_list_type) :: pieces
    real(wp), parameter :: none(3) = 0.0_wp, flat(3, 3) = 0.0_wp

    call add_piece(pieces, piece_type(1.0_wp, [1.0_wp, 0.0_wp, 0.0_wp], none, flat, [1, 1, 1]))
    call add_piece(pieces, piece_type(2.0_wp, [2.0_wp, 0.0_wp, 0.0_wp], none, flat, [2, 1, 1]))
    call add_piece(pieces, piece_type(9.0_wp, [9.0_wp, 0.0_wp, 0.0_wp], none, flat, [4, 1, 1]))
    call add_piece(pieces, piece_type(0.5_wp, [-3.0_wp, 0.0_wp, 0.0_wp], none, flat, [1, 2, 1]))
    call merge_small_pieces(pieces, 0.6_wp)
    call tests%check('one piece of four was too small', pieces%count == 3)
    call tests%close('the largest piece around it gained its volume', pieces%items(2)%measure, 2.5_wp, 1.0e-15_wp)
    call tests%close('and its moment', pieces%items(2)%centroid(1), 1.0_wp, 1.0e-15_wp)
    call tests%close('and its second moment: a share of 0.2, 5 apart', pieces%items(2)%second(1, 1), 4.0_wp, 1.0e-14_wp)
    call merge_small_pieces(pieces, 100.0_wp)
    call tests%check('the last piece stays', pieces%count == 1)
    call tests%close('with all of the volume', pieces%items(1)%measure, 12.5_wp, 1.0e-14_wp)
    call tests%close('and all of the second moment', pieces%items(1)%second(1, 1), 59.4_wp - 6.76_wp**2, 1.0e-13_wp)
  end subroutine check_merging

  !> Axisymmetry: a cone of radius 0.9 and height 0.7 holds r^2 h/6 per radian.
  subroutine check_cone(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(body_shape_type) :: shape
    type(seed_list_type) :: list
    type(error_type), allocatable :: error
    real(wp) :: volume, moment(2)

    allocate (shape%outline, source=reshape([0.0_wp, 0.1_wp, 0.9_wp, 0.1_wp, 0.0_wp, 0.8_wp], [2, 3]))
    call sample_grid('QUAD4', 6, 0.15_wp, mesh)
    mesh%axisymmetric = .true.
    call seed_body(mesh, shape, 1, 4, seed_even, 0, list, error)
    call first_moment(mesh, list, volume, moment)
    call tests%close('a cone holds a third of its cylinder per radian', volume, 0.9_wp**2*0.7_wp/6.0_wp, &
      rounding)
    ! The points are at centroids of areas: the variation of the radius over a piece is left, of
    ! second order in the sub-cell, 1/12^2/12 of the height.
    call tests%close('the centroid of a cone is a quarter of the height up', moment(2)/volume, &
      0.1_wp + 0.7_wp/4, 1.0e-3_wp)
  end subroutine check_cone

  !> The box of a cut piece has the proportions of the cut sub-cell.
  subroutine check_box_shares(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(body_shape_type) :: shape
    type(seed_list_type) :: list
    type(error_type), allocatable :: error

    allocate (shape%outline, source=reshape([0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 0.25_wp, 0.0_wp, &
      0.25_wp], [2, 4]))
    call sample_grid('QUAD4', 1, 0.0_wp, mesh)
    call seed_body(mesh, shape, 1, 4, seed_even, 0, list, error)
    call tests%check('a strip of a cell has two of four points', list%count == 2)
    call tests%close('their boxes are half a cell long', maxval(abs(list%vector(1, :2) - 0.25_wp)), 0.0_wp, &
      1.0e-15_wp)
    call tests%close('and as high as the strip', maxval(abs(list%vector(2, :2) - 0.125_wp)), 0.0_wp, &
      1.0e-15_wp)
  end subroutine check_box_shares
end module test_body_pieces
