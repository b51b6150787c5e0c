!> Surface points on the true boundary of bodies: lengths, areas, normals and owners.
module test_outline_seeding
  use qsmpm_kinds, only: wp, pi
  use qsmpm_error, only: error_type
  use qsmpm_element, only: shape_functions
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: interpolate
  use qsmpm_mesh_sets, only: faces_in_box
  use qsmpm_polygon, only: polygon_area
  use qsmpm_polyhedron, only: make_polyhedron, polyhedron_volume, facet_normal
  use qsmpm_seeding, only: body_shape_type, seed_list_type, seed_body, seed_even
  use qsmpm_outline_seeding, only: seed_outline
  use qsmpm_surface_seeding, only: seed_segment, seed_faces
  use solid_samples, only: block_facets, angle_facets, wedge_facets, sphere_facets, turned
  use sample_models, only: sample_grid
  use testing, only: tests_type
  implicit none
  private

  public :: collect_outline_seeding

  !> Rounding of sums over a few hundred pieces.
  real(wp), parameter :: rounding = 1.0e-12_wp
  !> A comb whose edges run along grid lines of a fifth, and a slanted outline that is not convex.
  real(wp), parameter :: comb(2, 8) = reshape([0.2_wp, 0.2_wp, 0.8_wp, 0.2_wp, 0.8_wp, 0.8_wp, 0.6_wp, &
    0.8_wp, 0.6_wp, 0.4_wp, 0.4_wp, 0.4_wp, 0.4_wp, 1.0_wp, 0.2_wp, 1.0_wp], [2, 8])
  real(wp), parameter :: slanted(2, 5) = reshape([0.13_wp, 0.21_wp, 0.87_wp, 0.33_wp, 0.61_wp, 0.44_wp, &
    0.79_wp, 0.83_wp, 0.24_wp, 0.91_wp], [2, 5])

contains

  !> All checks.
  subroutine collect_outline_seeding(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    character(len=5), parameter :: plane(3) = [character(len=5) :: 'QUAD4', 'QUAD8', 'TRI6']
    real(wp), allocatable :: block(:, :, :), ball(:, :, :)
    real(wp) :: circle(2, 64)
    integer :: i, k

    call tests%start('outline_seeding')
    circle = reshape([(0.48_wp + 0.37_wp*cos(pi*k/32), 0.51_wp + 0.37_wp*sin(pi*k/32), k=1, 64)], [2, 64])
    do i = 1, size(plane)
      call check_outline(tests, 'a comb', comb, trim(plane(i)), 0.0_wp)
      call check_outline(tests, 'a comb a hair outside of grid lines', &
        0.5_wp + (comb - 0.5_wp)*(1.0_wp + 3.0e-8_wp), trim(plane(i)), 0.0_wp)
      call check_outline(tests, 'a comb a hair inside of grid lines', &
        0.5_wp + (comb - 0.5_wp)*(1.0_wp - 3.0e-8_wp), trim(plane(i)), 0.0_wp)
      call check_outline(tests, 'a slanted outline', slanted, trim(plane(i)), 0.2_wp)
      call check_outline(tests, 'a 64-gon', circle, trim(plane(i)), 0.0_wp)
    end do
    allocate (block, source=block_facets([0.2_wp, 0.2_wp, 0.2_wp], [0.8_wp, 0.6_wp, 1.0_wp]))
    allocate (ball, source=sphere_facets(8))
    call check_solid(tests, 'a block on grid planes', block)
    call check_solid(tests, 'a block on grid planes in single precision', real(real(block), wp))
    call check_solid(tests, 'a tilted block', turned(0.7_wp*(block - 0.5_wp), 0.5_wp, 0.4_wp, &
      [0.5_wp, 0.5_wp, 0.46_wp]))
    call check_solid(tests, 'a wedge of 45 degrees on grid planes', 0.6_wp*wedge_facets() + 0.2_wp)
    call check_solid(tests, 'an L', turned(0.7_wp*angle_facets(), 0.3_wp, 0.4_wp, [0.3_wp, 0.15_wp, 0.3_wp]))
    call check_solid(tests, 'a ball', 0.42_wp*ball + 0.5_wp)
    call check_prism(tests)
    call check_boxes(tests)
    call check_boxes_in_space(tests)
    call check_segment_sides(tests)
    call check_cylinder(tests)
    call check_face_vectors(tests)
  end subroutine collect_outline_seeding

  !> Cells that hold seeds.
  function cells_of(mesh, list) result(occupied)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Seeds of a body.
    type(seed_list_type), intent(in) :: list
    logical :: occupied(mesh%cell_count)

    occupied = .false.
    occupied(list%cell(:list%count)) = .true.
  end function cells_of

  !> Sums over surface points: of areas, of area vectors, and of place times area vector.
  subroutine sums_of(mesh, list, area, vector, flux)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The surface points.
    type(seed_list_type), intent(in) :: list
    !> Sum of areas.
    real(wp), intent(out) :: area
    !> Sum of area vectors (dimension).
    real(wp), intent(out) :: vector(:)
    !> Dimension times the volume inside of a closed surface.
    real(wp), intent(out) :: flux
    real(wp) :: functions(20)
    integer :: i, n

    area = 0.0_wp
    vector = 0.0_wp
    flux = 0.0_wp
    do i = 1, list%count
      n = mesh%cell_first(list%cell(i) + 1) - mesh%cell_first(list%cell(i))
      call shape_functions(mesh%cell_kind(list%cell(i)), list%local(:, i), functions(:n))
      area = area + list%volume(i)
      vector = vector + list%vector(:, i)
      flux = flux + dot_product(list%vector(:, i), &
        interpolate(mesh, list%cell(i), functions(:n), mesh%coordinates))
    end do
  end subroutine sums_of

  !> Bounds of a body on a mesh, and the checks that hold for any closed one.
  subroutine check_closed(tests, name, mesh, shape, area, volume)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> What it is.
    character(len=*), intent(in) :: name
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The body.
    type(body_shape_type), intent(in) :: shape
    !> Its surface and volume.
    real(wp), intent(in) :: area, volume
    type(seed_list_type) :: body, list
    type(error_type), allocatable :: error
    real(wp) :: box(3, 2), found, vector(mesh%dimension), flux, left_out
    logical :: occupied(mesh%cell_count)

    call seed_body(mesh, shape, 1, 0, seed_even, 0, body, error)
    occupied = cells_of(mesh, body)
    box = reshape([-1.0_wp, -1.0_wp, -1.0_wp, 2.0_wp, 2.0_wp, 2.0_wp], [3, 2])
    call seed_outline(mesh, occupied, shape, box, 0.0_wp, 4, 1, list, left_out)
    call sums_of(mesh, list, found, vector, flux)
    call tests%close(name//': all of the surface', found, area, 1.0e-10_wp)
    call tests%close(name//': it is closed', norm2(vector), 0.0_wp, rounding)
    call tests%close(name//': it looks outward and is where it should be', flux, mesh%dimension*volume, &
      1.0e-10_wp)
    call tests%check(name//': all of its cells hold material', all(occupied(list%cell(:list%count))))
  end subroutine check_closed

  !> The edges of an outline.
  subroutine check_outline(tests, name, outline, element, perturbation)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> What it is, and the element.
    character(len=*), intent(in) :: name, element
    !> Vertices (2,n).
    real(wp), intent(in) :: outline(:, :)
    !> Shift of inner nodes.
    real(wp), intent(in) :: perturbation
    type(mesh_type) :: mesh
    type(body_shape_type) :: shape
    real(wp) :: length
    integer :: i, n

    allocate (shape%outline, source=outline)
    length = 0.0_wp
    do i = 1, size(outline, 2)
      length = length + norm2(outline(:, mod(i, size(outline, 2)) + 1) - outline(:, i))
    end do
    do n = 5, 8, 3
      call sample_grid(element, n, perturbation, mesh)
      ! The edge at the wall of the grid is the wall; outside of it there is nothing to find.
      if (any(outline > 1.0_wp)) call stretch_wall(mesh)
      call check_closed(tests, name//' in '//element, mesh, shape, length, polygon_area(outline))
    end do
  end subroutine check_outline

  !> Move the upper wall of a grid up by a part of a cell.
  subroutine stretch_wall(mesh)
    !> The mesh.
    type(mesh_type), intent(inout) :: mesh

    where (mesh%coordinates(2, :) > 1.0_wp - 1.0e-9_wp) mesh%coordinates(2, :) = 1.0_wp + 1.0e-6_wp
  end subroutine stretch_wall

  !> The facets of a polyhedron.
  subroutine check_solid(tests, name, facets)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> What it is.
    character(len=*), intent(in) :: name
    !> Corners (3, 3, n).
    real(wp), intent(in) :: facets(:, :, :)
    character(len=6), parameter :: elements(3) = [character(len=6) :: 'HEX8', 'WEDGE6', 'TET4']
    type(mesh_type) :: mesh
    type(body_shape_type) :: shape
    real(wp) :: area, volume, centroid(3)
    integer :: f, i

    allocate (shape%solid)
    call make_polyhedron(facets, shape%solid)
    call polyhedron_volume(facets, volume, centroid)
    area = 0.0_wp
    do f = 1, size(facets, 3)
      area = area + 0.5_wp*norm2(facet_normal(facets(:, :, f)))
    end do
    do i = 1, size(elements)
      call sample_grid(trim(elements(i)), 5, 0.0_wp, mesh)
      call check_closed(tests, name//' in '//trim(elements(i)), mesh, shape, area, volume)
    end do
  end subroutine check_solid

  !> A box of a deck in 3D: walls and caps.
  subroutine check_prism(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(body_shape_type) :: shape

    allocate (shape%outline, source=reshape([0.1_wp, 0.2_wp, 0.7_wp, 0.2_wp, 0.7_wp, 0.55_wp, 0.1_wp, &
      0.55_wp], [2, 4]))
    shape%low = 0.3_wp
    shape%high = 0.9_wp
    call sample_grid('HEX8', 4, 0.0_wp, mesh)
    call check_closed(tests, 'a box in HEX8', mesh, shape, &
      2*(0.6_wp*0.35_wp + 0.6_wp*0.6_wp + 0.35_wp*0.6_wp), 0.6_wp*0.35_wp*0.6_wp)
  end subroutine check_prism

  !> Boxes that hold parts of an outline: of one edge, of a corner, flat around an edge.
  subroutine check_boxes(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests

    call check(reshape([0.3_wp, 0.1_wp, 0.5_wp, 0.3_wp], [2, 2]), 0.2_wp, [0.0_wp, -0.2_wp])
    call check(reshape([0.7_wp, 0.1_wp, 0.9_wp, 0.4_wp], [2, 2]), 0.3_wp, [0.2_wp, -0.1_wp])
    call check(reshape([0.2_wp, 1.0_wp, 0.4_wp, 1.0_wp], [2, 2]), 0.2_wp, [0.0_wp, 0.2_wp])
    call check(reshape([0.41_wp, 0.41_wp, 0.59_wp, 0.9_wp], [2, 2]), 0.0_wp, [0.0_wp, 0.0_wp])

  contains

    !> Length and area vector of what is in a box.
    subroutine check(box, length, vector)
      !> Lower and upper corner (2,2).
      real(wp), intent(in) :: box(2, 2)
      !> By hand.
      real(wp), intent(in) :: length, vector(2)
      type(mesh_type) :: mesh
      type(body_shape_type) :: shape
      type(seed_list_type) :: body, list
      type(error_type), allocatable :: error
      real(wp) :: limits(3, 2), area, found(2), flux, left_out

      allocate (shape%outline, source=comb)
      call sample_grid('QUAD4', 7, 0.0_wp, mesh)
      call seed_body(mesh, shape, 1, 0, seed_even, 0, body, error)
      limits = 0.0_wp
      ! As wide as the tolerance of sets of a mesh of size one.
      limits(:2, 1) = box(:, 1) - 1.0e-8_wp
      limits(:2, 2) = box(:, 2) + 1.0e-8_wp
      call seed_outline(mesh, cells_of(mesh, body), shape, limits, 1.0e-8_wp, 4, 1, list, left_out)
      call sums_of(mesh, list, area, found, flux)
      call tests%close('length of outline in a box', area, length, 1.0e-7_wp)
      call tests%close('its area vector', norm2(found - vector), 0.0_wp, 1.0e-7_wp)
    end subroutine check
  end subroutine check_boxes

  !> Boxes around a face of a block: what they hold of the walls beside it is left out where it is a sliver, and told
  !> where it is more than the slack of the box.
  subroutine check_boxes_in_space(tests)
    type(tests_type), intent(inout) :: tests

    call check('the slack of a box takes no strips of the walls', 1.0_wp, 1.0e-8_wp, 0.24_wp, 0.0_wp)
    call check('slivers of the walls are left out and told', 1.0_wp - 1.0e-7_wp, 0.0_wp, 0.24_wp, 2.0e-7_wp)
    call check('what is more belongs to the surface', 1.0_wp - 1.0e-3_wp, 0.0_wp, 0.242_wp, 0.0_wp)

  contains

    !> Area in a box from a height to the top of the block.
    subroutine check(label, low, slack, area, left_out)
      character(len=*), intent(in) :: label
      !> Lower end of the box, and how much wider than drawn it is.
      real(wp), intent(in) :: low, slack
      !> By hand: 0.6 times 0.4 and the perimeter of 2 times the height; and what is told.
      real(wp), intent(in) :: area, left_out
      type(mesh_type) :: mesh
      type(body_shape_type) :: shape
      type(seed_list_type) :: body, list
      type(error_type), allocatable :: error
      real(wp) :: limits(3, 2), found, vector(3), flux, dropped

      allocate (shape%solid)
      call make_polyhedron(block_facets([0.2_wp, 0.2_wp, 0.2_wp], [0.8_wp, 0.6_wp, 1.0_wp]), shape%solid)
      call sample_grid('HEX8', 5, 0.0_wp, mesh)
      call seed_body(mesh, shape, 1, 0, seed_even, 0, body, error)
      limits(:, 1) = [0.2_wp, 0.2_wp, low] - slack
      limits(:, 2) = [0.8_wp, 0.6_wp, 1.0_wp] + slack
      call seed_outline(mesh, cells_of(mesh, body), shape, limits, slack, 4, 1, list, dropped)
      call sums_of(mesh, list, found, vector, flux)
      call tests%close(label, found, area, 1.0e-11_wp)
      call tests%close(label//': area vector', norm2(vector - [0.0_wp, 0.0_wp, 0.24_wp]), 0.0_wp, 1.0e-11_wp)
      call tests%close(label//': what is told', dropped, left_out, 1.0e-12_wp)
    end subroutine check
  end subroutine check_boxes_in_space

  !> A segment along a grid line belongs to the cell that holds material, once, whichever way it runs.
  subroutine check_segment_sides(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(seed_list_type) :: list
    logical :: occupied(4)

    call sample_grid('QUAD4', 2, 0.0_wp, mesh)
    occupied = [.true., .true., .false., .false.]
    call seed_segment(mesh, occupied, .false., [1.0_wp, 0.5_wp, 0.0_wp, 0.5_wp], 4, 1, list)
    call tests%check('a segment with the body to its left is in the body', list%count == 6 .and. &
      all(list%cell(:6) <= 2))
    call tests%close('and looks to its right', sum(list%vector(2, :6)), 1.0_wp, 1.0e-15_wp)
    call seed_segment(mesh, occupied, .false., [0.0_wp, 0.5_wp, 1.0_wp, 0.5_wp], 4, 1, list)
    call tests%check('the other way round it is in the body as well', list%count == 12 .and. &
      all(list%cell(:12) <= 2))
    call seed_segment(mesh, spread(.true., 1, 4), .false., [0.0_wp, 0.5_wp, 1.0_wp, 0.5_wp], 4, 1, list)
    call tests%check('inside of a body it belongs to the left, once', list%count == 18 .and. &
      all(list%cell(13:18) > 2))
    call seed_segment(mesh, occupied, .false., [0.0_wp, 0.7_wp, 1.0_wp, 0.7_wp], 4, 1, list)
    call tests%check('off the body it belongs to nothing', list%count == 18)
  end subroutine check_segment_sides

  !> Axisymmetry: the outline of a cone per radian, base r^2/2 and mantle r s/2.
  subroutine check_cylinder(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(body_shape_type) :: shape
    type(seed_list_type) :: body, list
    type(error_type), allocatable :: error
    real(wp) :: box(3, 2), area, vector(2), flux, left_out

    allocate (shape%outline, source=reshape([0.0_wp, 0.1_wp, 0.9_wp, 0.1_wp, 0.0_wp, 0.8_wp], [2, 3]))
    call sample_grid('TRI6', 6, 0.1_wp, mesh)
    mesh%axisymmetric = .true.
    call seed_body(mesh, shape, 1, 0, seed_even, 0, body, error)
    box = reshape([-1.0_wp, -1.0_wp, -1.0_wp, 2.0_wp, 2.0_wp, 2.0_wp], [3, 2])
    call seed_outline(mesh, cells_of(mesh, body), shape, box, 0.0_wp, 4, 1, list, left_out)
    call sums_of(mesh, list, area, vector, flux)
    call tests%close('base and mantle of a cone per radian', area, &
      0.5_wp*0.9_wp*(0.9_wp + norm2([0.9_wp, 0.7_wp])), 1.0e-10_wp)
    call tests%close('forces along the axis cancel', vector(2), 0.0_wp, rounding)
  end subroutine check_cylinder

  !> Faces of the mesh: area vectors of all outer faces look outward.
  subroutine check_face_vectors(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    character(len=7), parameter :: elements(5) = [character(len=7) :: 'TRI6', 'QUAD8', 'HEX20', 'WEDGE15', &
      'TET10']
    type(mesh_type) :: mesh
    type(seed_list_type) :: list
    integer, allocatable :: faces(:, :)
    real(wp) :: area, flux, box(3, 2)
    real(wp), allocatable :: vector(:)
    integer :: i

    box = reshape([-1.0_wp, -1.0_wp, -1.0_wp, 2.0_wp, 2.0_wp, 2.0_wp], [3, 2])
    do i = 1, size(elements)
      call sample_grid(trim(elements(i)), 2, 0.1_wp, mesh)
      list = seed_list_type()
      if (allocated(vector)) deallocate (vector)
      allocate (vector(mesh%dimension))
      call faces_in_box(mesh, box, faces)
      call seed_faces(mesh, spread(.true., 1, mesh%cell_count), faces, 1, list)
      call sums_of(mesh, list, area, vector, flux)
      call tests%close('walls of '//trim(elements(i)), area, 2.0_wp*mesh%dimension, rounding)
      call tests%close('walls of '//trim(elements(i))//' look outward', flux, 1.0_wp*mesh%dimension, rounding)
    end do
  end subroutine check_face_vectors
end module test_outline_seeding
