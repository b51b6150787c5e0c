!> The part of a model that a process answers for. Alone that is all of it. A process of a team has the material points
!> and surface points of its own cells, and copies of those in a ring around them, which make the sums at its own nodes
!> whole; of a grid it has the window with these. What is reduced over the team counts each point, cell and node once:
!> on the process whose own it is.
!>
!> How a model is divided is left to `qsmpm_division`, what is own to `qsmpm_own_marks`.
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
    !> Who shares the model: this process alone unless the model is divided.
    type(team_type) :: team
    !> Which cells are each rank's own.
    class(cell_owners_type), allocatable :: owners
    !> Rows of cells around the own ones whose points are copied.
    integer :: ring = 0
    !> Values of cells and nodes that are others', in the window that they were listed for (qsmpm_ring_exchange).
    type(owner_copies_type) :: cell_copies, node_copies
    type(window_type) :: copied_window
    !> Of a model that was divided as it was built: the window that one process would look at, and the points of all.
    type(window_type) :: built_window
    integer(long) :: built_points = 0
    !> Which nodes of the space, cells, material points, surface points, tracers, watched places, points of bodies that
    !> are taken out and feet are own; unallocated alone.
    logical, allocatable :: nodes(:), cells(:), points(:), surface(:), tracers(:), watched(:), unloading(:), &
      unloading_surface(:), feet(:)
    !> Cells of the whole grid that places known to all were in when that was told last (places).
    integer, allocatable :: tracer_cell(:), watched_cell(:), foot_cell(:)
    !> Bodies that the phase takes out (bodies), and the points of those that wait: all, their cells numbered as in the
    !> whole grid.
    logical, allocatable :: taken_out(:)
    type(points_type) :: waiting
    type(surface_points_type) :: waiting_surface
    !> A point that carries what all of them do, and the numbers of the points of histories (0 for none).
    type(points_type) :: like
    integer(long), allocatable :: history_number(:)
  end type own_part_type

contains

  !> Whether there are other processes that have a part.
  pure logical function is_divided(part)
    type(own_part_type), intent(in) :: part

    is_divided = part%team%ranks > 1
  end function is_divided

  !> Which of some things are own, by their marks; alone all are.
  pure function own_of(marks, count) result(own)
    !> Nodes, points, tracers or other places of a part.
    logical, allocatable, intent(in) :: marks(:)
    !> How many there are.
    integer, intent(in) :: count
    logical :: own(count)

    own = .true.
    if (allocated(marks)) own = marks
  end function own_of

  !> Which of some cells are own.
  pure function own_cells(part, cell) result(own)
    type(own_part_type), intent(in) :: part
    !> Their numbers.
    integer, intent(in) :: cell(:)
    logical :: own(size(cell))

    own = .true.
    if (allocated(part%cells)) own = part%cells(cell)
  end function own_cells

  !> Whose values are copied is to be listed anew: the owners are others.
  pure subroutine reset_copies(part)
    type(own_part_type), intent(inout) :: part
    type(owner_copies_type) :: none

    part%cell_copies = none
    part%node_copies = none
  end subroutine reset_copies
end module qsmpm_own_part
