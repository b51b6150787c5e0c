!> Small meshes, bodies, spaces and laws that several suites use.
module sample_models
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_element, only: element_from_name, local_dimension
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_sets, only: nodes_in_box, add_set
  use qsmpm_grid, only: grid_type, make_grid, diagonal_random
  use qsmpm_mesh_topology, only: build_topology
  use qsmpm_space, only: space_type
  use qsmpm_space_builder, only: spline_space
  use qsmpm_points, only: points_type, allocate_points
  use qsmpm_domains, only: domains_type
  use qsmpm_law, only: law_slot_type, law_type
  use qsmpm_law_factory, only: new_law, rate_midpoint
  use qsmpm_material_parameters, only: material_parameters_type
  implicit none
  private

  public :: sample_grid, uneven_grid, sample_space, tiled_box, owner_of, sample_laws

  !> Grid lines of uneven_grid.
  real(wp), parameter, public :: lines_x(7) = [-0.2_wp, 0.3_wp, 1.0_wp, 1.4_wp, 2.4_wp, 3.0_wp, 3.9_wp], &
    lines_y(6) = [0.0_wp, 0.5_wp, 0.8_wp, 1.7_wp, 2.2_wp, 3.0_wp], &
    lines_z(5) = [0.0_wp, 0.6_wp, 1.4_wp, 1.9_wp, 2.9_wp]

contains

  !> A grid of n elements a direction on the unit square or cube.
  subroutine sample_grid(name, n, perturbation, mesh)
    !> Element name.
    character(len=*), intent(in) :: name
    integer, intent(in) :: n
    !> Shift of inner nodes.
    real(wp), intent(in) :: perturbation
    type(mesh_type), intent(out) :: mesh
    type(grid_type) :: grid
    type(error_type), allocatable :: error
    integer :: i, k

    grid%kind = element_from_name(name)
    grid%diagonal = diagonal_random
    grid%perturbation = perturbation
    do i = 1, local_dimension(grid%kind)
      grid%axes(i)%lines = [(real(k, wp)/n, k=0, n)]
    end do
    call make_grid(grid, mesh)
    call build_topology(mesh, error)
    if (allocated(error)) error stop 'sample mesh is broken'
  end subroutine sample_grid

  !> A grid of unequal cells.
  subroutine uneven_grid(dimension, mesh)
    !> 2 or 3.
    integer, intent(in) :: dimension
    type(mesh_type), intent(out) :: mesh
    type(grid_type) :: grid
    type(error_type), allocatable :: error

    grid%kind = element_from_name(merge('QUAD4', 'HEX8 ', dimension == 2))
    grid%axes(1)%lines = lines_x
    grid%axes(2)%lines = lines_y
    if (dimension == 3) grid%axes(3)%lines = lines_z
    call make_grid(grid, mesh)
    call build_topology(mesh, error)
    if (allocated(error)) error stop 'uneven mesh is broken'
  end subroutine uneven_grid

  !> Splines on that grid; with a box, its nodes are a constrained set and its sides kinks.
  subroutine sample_space(mesh, degree, averaged, space, box)
    !> The grid; gets the set.
    type(mesh_type), intent(inout) :: mesh
    integer, intent(in) :: degree
    logical, intent(in) :: averaged
    type(space_type), intent(out) :: space
    !> Lower and upper corner (3,2).
    real(wp), intent(in), optional :: box(3, 2)
    integer, allocatable :: items(:)
    logical, allocatable :: constrained(:)

    if (present(box)) then
      call nodes_in_box(mesh, box, items)
      call add_set(mesh%node_sets, 'held', items)
    end if
    allocate (constrained(size(mesh%node_sets)), source=.true.)
    call spline_space(mesh, cell_counts(mesh), degree, averaged, constrained, space)
  end subroutine sample_space

  !> Number of cells of uneven_grid along each axis.
  pure function cell_counts(mesh) result(counts)
    type(mesh_type), intent(in) :: mesh
    integer :: counts(3)

    counts = [size(lines_x), size(lines_y), size(lines_z)] - 1
    if (mesh%dimension == 2) counts(3) = 1
  end function cell_counts

  !> A box in uneven_grid as equal material points whose domains tile it.
  subroutine tiled_box(mesh, low, high, parts, points, domains)
    type(mesh_type), intent(in) :: mesh
    !> Corners of the box (dimension).
    real(wp), intent(in) :: low(:), high(:)
    !> Points along each axis; those beyond the dimension are not used.
    integer, intent(in) :: parts(:)
    !> Unstressed, with room for four or six states.
    type(points_type), intent(out) :: points
    type(domains_type), intent(out) :: domains
    real(wp) :: extent(size(low))
    integer :: p, a, rest, at(size(low)), d

    d = size(low)
    extent = (high - low)/parts(:d)
    call allocate_points(points, d, product(parts(:d)), merge(4, 6, d == 2), merge(4, 6, d == 2))
    allocate (domains%low(d, points%count), domains%high(d, points%count))
    do p = 1, points%count
      rest = p - 1
      do a = 1, d
        at(a) = mod(rest, parts(a))
        rest = rest/parts(a)
      end do
      points%half_size(:, p) = 0.5_wp*extent
      points%position(:, p) = low + (2*at + 1)*points%half_size(:, p)
      call owner_of(mesh, points%position(:, p), points%cell(p), points%local(:, p))
      domains%low(:, p) = low + at*extent
      domains%high(:, p) = low + (at + 1)*extent
    end do
    points%volume = product(extent)
    points%initial_volume = points%volume
    points%material = 1
  end subroutine tiled_box

  !> Cell of uneven_grid that holds a place, and the local coordinates there.
  pure subroutine owner_of(mesh, x, cell, local)
    type(mesh_type), intent(in) :: mesh
    !> Place (dimension).
    real(wp), intent(in) :: x(:)
    integer, intent(out) :: cell
    !> (dimension)
    real(wp), intent(out) :: local(:)
    integer :: at(3), counts(3)

    counts = cell_counts(mesh)
    at = 1
    call place_on(lines_x, x(1), at(1), local(1))
    call place_on(lines_y, x(2), at(2), local(2))
    if (size(x) == 3) call place_on(lines_z, x(3), at(3), local(3))
    cell = ((at(3) - 1)*counts(2) + at(2) - 1)*counts(1) + at(1)
  end subroutine owner_of

  !> Cell along an axis, and the local coordinate in it.
  pure subroutine place_on(lines, x, at, local)
    real(wp), intent(in) :: lines(:), x
    integer, intent(out) :: at
    real(wp), intent(out) :: local

    at = 1 + count(lines(2:size(lines) - 1) <= x)
    local = 2.0_wp*(x - lines(at))/(lines(at + 1) - lines(at)) - 1.0_wp
  end subroutine place_on

  !> One Mohr-Coulomb soil.
  subroutine sample_laws(dimension, kinematics, laws)
    integer, intent(in) :: dimension, kinematics
    type(law_slot_type), allocatable, intent(out) :: laws(:)
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error

    allocate (laws(1))
    call new_law(material_parameters_type(young=100.0_wp, poisson=0.3_wp, mohr_coulomb=.true., cohesion=0.5_wp, &
      friction_angle=30.0_wp, dilatancy_angle=5.0_wp), dimension, kinematics, rate_midpoint, law, error)
    allocate (laws(1)%law, source=law)
  end subroutine sample_laws
end module sample_models
