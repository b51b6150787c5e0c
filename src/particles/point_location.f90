!> Point location (paper, sections 3.1 and 3.3): which cell owns which point, which cells are active, and which of the
!> active cells are full or at the boundary of the material.
!>
!> A cell is active if it owns a point or a part of a body, never because a shape function extends into it. An active
!> cell belongs to the *boundary* if a cell that shares a corner with it is inactive or its fill is below 0.6; it is
!> *full* if no such neighbour is inactive and its fill is above 0.4. The outside of the mesh does not count as
!> inactive, because the fixities apply there; at a boundary that is not fixed the fill must be above 0.8. Constants:
!> docs/methods/cell_integration.md and ghost.md.
module qsmpm_point_location
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_search, only: locate, inverse_map
  use qsmpm_points, only: carried_type, points_type
  use qsmpm_sorting, only: list_by_key
  use qsmpm_error, only: error_type, fail, error_left_mesh
  use qsmpm_rounded_text, only: rounded_text
  implicit none
  private

  public :: activation_type, sort_points, add_active, classify_cells, relocate

  !> Fill below which an active cell needs stabilisation, and above which it may be integrated as a full cell.
  real(wp), parameter, public :: boundary_fill = 0.6_wp
  real(wp), parameter :: full_fill = 0.4_wp
  !> Fill above which a cell controls the functions of its own nodes, independent of its neighbours.
  real(wp), parameter, public :: whole_fill = 0.95_wp
  !> As `full_fill`, for a cell with a free face on the outside of the mesh: there the body may end inside the cell
  !> without an inactive neighbour.
  real(wp), parameter :: edge_fill = 0.8_wp
  !> A point outside the mesh by more than this fraction of the cell size has left the mesh; otherwise it keeps its
  !> position and belongs to the cell at the wall, whose functions are extrapolated to it.
  real(wp), parameter :: wall_tolerance = 0.2_wp
  !> Smallest number of points that are located by several threads.
  integer, parameter :: fewest_places = 10000

  !> Result of the point location.
  type :: activation_type
    !> Number of active cells with points of this process, and number including those with points of other processes.
    integer :: active_count = 0, known_count = 0
    !> Active cells in ascending order, then those of other processes (known_count); the inverse, 0 for an inactive
    !> cell.
    integer, allocatable :: active_cell(:), active_number(:)
    !> Points of active cell k: point(first(k) : first(k+1)-1), sorted by material, then number; none for other
    !> processes.
    integer, allocatable :: first(:), point(:)
    !> Volume of the points in a cell as a fraction of the cell volume (known_count).
    real(wp), allocatable :: fill(:)
    logical, allocatable :: boundary(:), full(:)
    !> Cells whose functions take part in the equations: the active cells, and those that the domain of a point extends
    !> into (cell_count).
    logical, allocatable :: touched(:)
  end type activation_type

contains

  !> Sorts points into cells, and computes the fill of these cells.
  pure subroutine sort_points(mesh, cell_volume, points, activation, occupied)
    type(mesh_type), intent(in) :: mesh
    !> Volume of every cell (cell_count).
    real(wp), intent(in) :: cell_volume(:)
    type(points_type), intent(in) :: points
    type(activation_type), intent(out) :: activation
    !> Cells that are active without a point because they contain a part of a body (cell_count); none when absent.
    logical, intent(in), optional :: occupied(:)
    integer :: k, c, p

    call sort_by_cell(mesh%cell_count, points, activation, occupied)
    activation%known_count = activation%active_count
    allocate (activation%fill(activation%active_count))
    do k = 1, activation%active_count
      c = activation%active_cell(k)
      activation%fill(k) = 0.0_wp
      do p = activation%first(k), activation%first(k + 1) - 1
        activation%fill(k) = activation%fill(k) + points%volume(activation%point(p))
      end do
      activation%fill(k) = activation%fill(k)/cell_volume(c)
    end do
  end subroutine sort_points

  !> Adds active cells whose points are on other processes.
  pure subroutine add_active(cells, fill, activation)
    !> Their numbers, and their fill (cells).
    integer, intent(in) :: cells(:)
    real(wp), intent(in) :: fill(:)
    type(activation_type), intent(inout) :: activation
    integer :: k

    activation%active_number(cells) = [(activation%known_count + k, k=1, size(cells))]
    activation%active_cell = [activation%active_cell, cells]
    activation%first = [activation%first, spread(size(activation%point) + 1, 1, size(cells))]
    activation%fill = [activation%fill, fill]
    activation%known_count = size(activation%active_cell)
  end subroutine add_active

  !> Determines which active cells are full and which are at the boundary of the material.
  pure subroutine classify_cells(mesh, activation, open_edge)
    type(mesh_type), intent(in) :: mesh
    type(activation_type), intent(inout) :: activation
    !> Cells with a free face on the outside of the mesh (cell_count); none when absent.
    logical, intent(in), optional :: open_edge(:)
    real(wp) :: least
    integer :: k, c

    allocate (activation%touched, source=activation%active_number > 0)
    allocate (activation%boundary(activation%known_count), activation%full(activation%known_count))
    do k = 1, activation%known_count
      c = activation%active_cell(k)
      associate (around => mesh%vertex_neighbour(mesh%vertex_first(c):mesh%vertex_first(c + 1) - 1))
        activation%full(k) = all(activation%active_number(around) > 0)
        activation%boundary(k) = .not. activation%full(k) .or. activation%fill(k) < boundary_fill
        least = full_fill
        if (present(open_edge)) least = merge(edge_fill, full_fill, open_edge(c))
        activation%full(k) = activation%full(k) .and. activation%fill(k) > least
      end associate
    end do
  end subroutine classify_cells

  !> Sorts the points by cell, then material.
  pure subroutine sort_by_cell(cell_count, points, activation, occupied)
    !> Number of cells.
    integer, intent(in) :: cell_count
    type(points_type), intent(in) :: points
    type(activation_type), intent(inout) :: activation
    !> Cells that are active without a point (cell_count).
    logical, intent(in), optional :: occupied(:)
    logical :: active(cell_count)
    integer, allocatable :: first(:), by_material(:), by_cell(:)
    integer :: c, n

    n = points%count
    call list_by_key(points%material(:n), maxval([0, points%material(:n)]), first, by_material)
    call list_by_key(points%cell(by_material), cell_count, first, by_cell)
    activation%point = by_material(by_cell)
    active = first(2:) > first(:cell_count)
    if (present(occupied)) active = active .or. occupied
    activation%active_cell = pack([(c, c=1, cell_count)], active)
    activation%active_count = size(activation%active_cell)
    activation%first = [first(activation%active_cell), n + 1]
    allocate (activation%active_number(cell_count), source=0)
    activation%active_number(activation%active_cell) = [(c, c=1, activation%active_count)]
  end subroutine sort_by_cell

  !> Determines the owner cells again after a displacement or a change of the mesh.
  subroutine relocate(mesh, cell_size, carried, name, error, chosen)
    type(mesh_type), intent(in) :: mesh
    !> Typical cell size [length].
    real(wp), intent(in) :: cell_size
    !> Set that moves with the material.
    class(carried_type), intent(inout) :: carried
    !> Name of the set for the error message.
    character(len=*), intent(in) :: name
    !> error_left_mesh, with the number of the point.
    type(error_type), allocatable, intent(out) :: error
    !> Members of the set that are located; all when absent.
    logical, intent(in), optional :: chosen(:)
    real(wp) :: low(3), high(3)
    character(len=*), parameter :: axes = 'xyz'
    character(len=300) :: text
    logical :: sought(carried%count)
    integer :: p, lost, side

    low(:mesh%dimension) = minval(mesh%coordinates, dim=2)
    high(:mesh%dimension) = maxval(mesh%coordinates, dim=2)
    lost = huge(lost)
    sought = .true.
    if (present(chosen)) sought = chosen
    !$omp parallel do default(none) shared(mesh, cell_size, carried, low, high, sought) reduction(min: lost) &
    !$omp& if (carried%count >= fewest_places)
    do p = 1, carried%count
      if (.not. sought(p)) cycle
      if (.not. is_found(mesh, cell_size, low(:mesh%dimension), high(:mesh%dimension), carried, p)) lost = min(lost, p)
    end do
    !$omp end parallel do
    if (lost > carried%count) return
    write (text, '(a,1x,i0,a,3(1x,es13.6))') name, carried%number(lost), ' left the mesh at', carried%position(:, lost)
    associate (x => carried%position(:, lost), d => mesh%dimension)
      side = maxloc(max(low(:d) - x, x - high(:d)), dim=1)
      if (x(side) < low(side) .or. x(side) > high(side)) text = trim(text)//', beyond its end '//axes(side:side)// &
        ' = '//rounded_text(merge(low(side), high(side), x(side) < low(side)))//': a mesh that goes on there lets '// &
        'it move'
    end associate
    call fail(error, error_left_mesh, trim(text))
  end subroutine relocate

  !> Determines the owner cell of one point and its local coordinates; false if it has left the mesh.
  logical function is_found(mesh, cell_size, low, high, carried, p) result(found)
    type(mesh_type), intent(in) :: mesh
    !> Typical cell size [length].
    real(wp), intent(in) :: cell_size
    !> Corners of the mesh (dimension).
    real(wp), intent(in) :: low(:)
    real(wp), intent(in) :: high(:)
    !> Set that moves with the material.
    class(carried_type), intent(inout) :: carried
    !> Number of the point in the set.
    integer, intent(in) :: p
    real(wp) :: clamped(3), beyond
    integer :: d

    d = size(low)
    clamped(:d) = min(max(carried%position(:, p), low), high)
    beyond = maxval(abs(clamped(:d) - carried%position(:, p)))
    found = beyond <= wall_tolerance*cell_size
    if (found) call locate(mesh, clamped(:d), carried%cell(p), carried%local(:, p), found)
    if (found .and. beyond > 0.0_wp) &
      call inverse_map(mesh, carried%cell(p), carried%position(:, p), carried%local(:, p), found)
  end function is_found
end module qsmpm_point_location
