!> Bodies that end inside cells: the theorem of Gauss holds function by function,
!>   sum over points of V grad N_a  =  sum over surface points of N_a a,
!> so that a uniform stress is in equilibrium with its traction whatever cells the body cuts.
module test_cut_cells
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_element, only: element_geometry, full_rule, max_nodes
  use qsmpm_mesh, only: mesh_type
  use qsmpm_cell_share, only: volume_of
  use qsmpm_polygon, only: polygon_area, polygon_centroid, polygon_second
  use qsmpm_polyhedron, only: make_polyhedron
  use qsmpm_seeding, only: body_shape_type, seed_list_type, seed_body, seed_even
  use qsmpm_outline_seeding, only: seed_outline
  use solid_samples, only: block_facets, turned
  use sample_models, only: sample_grid
  use testing, only: tests_type
  implicit none
  private

  public :: collect_cut_cells

  !> Sums over a few hundred points of gradients of the size of one over a cell.
  real(wp), parameter :: rounding = 1.0e-11_wp
  !> A slanted outline with a re-entrant corner; no vertex or edge on a grid line.
  real(wp), parameter :: slanted(2, 5) = reshape([0.13_wp, 0.21_wp, 0.87_wp, 0.33_wp, 0.53_wp, 0.47_wp, &
    0.79_wp, 0.83_wp, 0.24_wp, 0.91_wp], [2, 5])

contains

  !> All checks.
  subroutine collect_cut_cells(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    character(len=7), parameter :: plane(4) = [character(len=7) :: 'TRI3', 'TRI6', 'QUAD4', 'QUAD8'], &
      solid(5) = [character(len=7) :: 'TET4', 'TET10', 'WEDGE6', 'WEDGE15', 'HEX8']
    type(body_shape_type) :: outline, prism, block
    integer :: i

    call tests%start('cut_cells')
    allocate (outline%outline, source=slanted)
    allocate (prism%outline, source=slanted(:, [1, 2, 4, 5]))
    prism%low = 0.13_wp
    prism%high = 0.81_wp
    allocate (block%solid)
    call make_polyhedron(turned(block_facets([-0.3_wp, -0.28_wp, -0.25_wp], [0.3_wp, 0.28_wp, 0.25_wp]), 0.5_wp, &
      0.4_wp, [0.5_wp, 0.52_wp, 0.48_wp]), block%solid)
    do i = 1, size(plane)
      call check_theorem(tests, 'an outline', outline, trim(plane(i)))
    end do
    do i = 1, size(solid)
      call check_theorem(tests, 'a prism', prism, trim(solid(i)))
      call check_theorem(tests, 'a tilted block', block, trim(solid(i)))
    end do
    call check_second_moments(tests, outline)
  end subroutine collect_cut_cells

  !> The theorem for every function of an element mesh.
  subroutine check_theorem(tests, name, shape, element)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> What the body is.
    character(len=*), intent(in) :: name
    !> The body.
    type(body_shape_type), intent(in) :: shape
    !> Element name.
    character(len=*), intent(in) :: element
    type(mesh_type) :: mesh
    type(seed_list_type) :: list, surface
    type(error_type), allocatable :: error
    real(wp), allocatable :: defect(:, :), places(:, :), weights(:)
    real(wp) :: box(3, 2), held, left_out
    logical, allocatable :: occupied(:)
    integer :: c, k

    call sample_grid(element, 5, 0.0_wp, mesh)
    call seed_body(mesh, shape, 1, 0, seed_even, 0, list, error)
    call tests%check(name//' is seeded in '//element, .not. allocated(error) .and. list%count > 0)
    allocate (occupied(mesh%cell_count), source=.false.)
    occupied(list%cell(:list%count)) = .true.
    box(:, 1) = -1.0_wp
    box(:, 2) = 2.0_wp
    call seed_outline(mesh, occupied, shape, box, 0.0_wp, 4, 1, surface, left_out)
    allocate (defect(mesh%dimension, mesh%node_count), source=0.0_wp)
    do c = 1, mesh%cell_count
      held = sum(list%volume(:list%count), mask=list%cell(:list%count) == c)
      if (held < (1.0_wp - 1.0e-9_wp)*volume_of(mesh, c)) cycle
      call full_rule(mesh%cell_kind(c), places, weights)
      do k = 1, size(weights)
        call add(mesh, c, places(:, k), weights(k), .true., defect)
      end do
      where (list%cell(:list%count) == c) list%volume(:list%count) = 0.0_wp
    end do
    do k = 1, list%count
      call add(mesh, list%cell(k), list%local(:, k), list%volume(k), .false., defect)
    end do
    do k = 1, surface%count
      call add(mesh, surface%cell(k), surface%local(:, k), 1.0_wp, .false., defect, -surface%vector(:, k))
    end do
    call tests%close('the theorem of Gauss for '//name//' in '//element, maxval(abs(defect)), 0.0_wp, rounding)
  end subroutine check_theorem

  !> Add V grad N_a, or N_a a, of one place.
  subroutine add(mesh, cell, local, volume, times_determinant, sums, vector)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Cell and local coordinates (dimension).
    integer, intent(in) :: cell
    real(wp), intent(in) :: local(:)
    !> Volume, or the weight of a Gauss point.
    real(wp), intent(in) :: volume
    logical, intent(in) :: times_determinant
    !> (dimension, nodes)
    real(wp), intent(inout) :: sums(:, :)
    !> Area vector (dimension).
    real(wp), intent(in), optional :: vector(:)
    real(wp) :: corner(mesh%dimension, max_nodes), functions(max_nodes), gradients(mesh%dimension, max_nodes)
    real(wp) :: determinant
    integer :: a, n

    associate (nodes => mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell + 1) - 1))
      n = size(nodes)
      corner(:, :n) = mesh%coordinates(:, nodes)
      call element_geometry(mesh%cell_kind(cell), local, corner(:, :n), functions(:n), gradients(:, :n), determinant)
      if (.not. times_determinant) determinant = 1.0_wp
      do a = 1, n
        if (present(vector)) then
          sums(:, nodes(a)) = sums(:, nodes(a)) + functions(a)*vector
        else
          sums(:, nodes(a)) = sums(:, nodes(a)) + volume*determinant*gradients(:, a)
        end if
      end do
    end associate
  end subroutine add

  !> Points and boxes of a body for splines have its second moments: x x' + l l/3 over all points.
  subroutine check_second_moments(tests, shape)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> The body.
    type(body_shape_type), intent(in) :: shape
    type(mesh_type) :: mesh
    type(seed_list_type) :: list
    type(error_type), allocatable :: error
    real(wp) :: second(2, 2), exact(2, 2), centroid(2), x(2)
    integer :: k, a

    call sample_grid('QUAD4', 6, 0.0_wp, mesh)
    call seed_body(mesh, shape, 1, 9, seed_even, 2, list, error)
    centroid = polygon_centroid(shape%outline)
    second = 0.0_wp
    do k = 1, list%count
      associate (corner => mesh%coordinates(:, mesh%cell_nodes(mesh%cell_first(list%cell(k)))))
        x = corner + (1.0_wp + list%local(:, k))/12.0_wp - centroid
      end associate
      do a = 1, 2
        second(:, a) = second(:, a) + list%volume(k)*x*x(a)
        second(a, a) = second(a, a) + list%volume(k)*list%vector(a, k)**2/3.0_wp
      end do
    end do
    exact = polygon_area(shape%outline)*polygon_second(shape%outline)
    call tests%close('points of splines keep the second moments of a body', maxval(abs(second - exact)), 0.0_wp, &
      1.0e-14_wp)
    exact = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp]/3.0_wp, [2, 2])
    second = polygon_second(reshape([1.0_wp, 1.0_wp, 3.0_wp, 1.0_wp, 3.0_wp, 3.0_wp, 1.0_wp, 3.0_wp], [2, 4]))
    call tests%close('the second moment of a square', maxval(abs(second - exact)), 0.0_wp, 1.0e-15_wp)
  end subroutine check_second_moments
end module test_cut_cells
