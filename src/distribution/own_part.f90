!> The part of a model that belongs to a process; for a single process the whole. A process of a team has the material
!> points and surface points of its own cells, and copies of those in a ring around them, which complete the sums at its
!> own nodes; of a grid it stores the window with these. Reductions over the team count each point, cell and node once,
!> on its owner.
!>
!> The division of a model is in `qsmpm_division`, the marks of ownership are in `qsmpm_own_marks`.
module qsmpm_own_part
  use qsmpm_kinds, only: long
  use qsmpm_cell_owners, only: cell_owners_type
  use qsmpm_grid_window, only: window_type
  use qsmpm_owner_copies, only: owner_copies_type
  use qsmpm_points, only: points_type, surface_points_type
  use qsmpm_team, only: team_type
  implicit none
  private

  public :: own_part_type, is_divided, own_of, own_cells, reset_copies

  type :: own_part_type
    !> Processes that share the model: this process alone unless the model is divided.
    type(team_type) :: team
    !> Owners of the cells.
    class(cell_owners_type), allocatable :: owners
    !> Number of rows of cells around the own ones whose points are copied.
    integer :: ring = 0
    !> Lists for the values of cells and nodes of other processes, in the window for which they were made
    !> (qsmpm_ring_exchange).
    type(owner_copies_type) :: cell_copies, node_copies
    type(window_type) :: copied_window
    !> For a model that was divided as it was built: the window of an undivided model, and the points of all.
    type(window_type) :: built_window
    integer(long) :: built_points = 0
    !> Marks of own nodes of the space, cells, material points, surface points, tracers, watched places, points of
    !> removed bodies and feet; unallocated on a single process.
    logical, allocatable :: nodes(:), cells(:), points(:), surface(:), tracers(:), watched(:), unloading(:), &
      unloading_surface(:), feet(:)
    !> Cells of the whole grid of places known to all, at the last exchange (places).
    integer, allocatable :: tracer_cell(:), watched_cell(:), foot_cell(:)
    !> Bodies that the phase removes (bodies), and the points of all inactive bodies, with cells numbered as in the
    !> whole grid.
    logical, allocatable :: taken_out(:)
    type(points_type) :: waiting
    type(surface_points_type) :: waiting_surface
    !> A point with the same stored quantities as all, and the numbers of the points of histories (0 for none).
    type(points_type) :: like
    integer(long), allocatable :: history_number(:)
  end type own_part_type

contains

  !> Checks whether other processes have a part of the model.
  pure logical function is_divided(part)
    type(own_part_type), intent(in) :: part

    is_divided = part%team%ranks > 1
  end function is_divided

  !> Returns which items are own, by their marks; on a single process all are.
  pure function own_of(marks, count) result(own)
    !> Marks of nodes, points, tracers or other places.
    logical, allocatable, intent(in) :: marks(:)
    !> Number of items.
    integer, intent(in) :: count
    logical :: own(count)

    own = .true.
    if (allocated(marks)) own = marks
  end function own_of

  !> Marks own cells among given ones.
  pure function own_cells(part, cell) result(own)
    type(own_part_type), intent(in) :: part
    !> Their numbers.
    integer, intent(in) :: cell(:)
    logical :: own(size(cell))

    own = .true.
    if (allocated(part%cells)) own = part%cells(cell)
  end function own_cells

  !> Discards the lists of copied values after a change of the owners.
  pure subroutine reset_copies(part)
    type(own_part_type), intent(inout) :: part
    type(owner_copies_type) :: none

    part%cell_copies = none
    part%node_copies = none
  end subroutine reset_copies
end module qsmpm_own_part
