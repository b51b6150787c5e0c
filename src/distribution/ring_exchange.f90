!> Exchange of data of cells and nodes around the own part that a process cannot determine from its points: the owner of
!> a cell has all of its points, the owner of a node all adjacent cells, and sends the values to the others. So the ring
!> of copied points is only as wide as the support of the functions (qsmpm_division). A single process exchanges
!> nothing.
module qsmpm_ring_exchange
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: any_of
  use qsmpm_cell_numbers, only: whole_cells
  use qsmpm_grid_window, only: operator(==)
  use qsmpm_model, only: model_type
  use qsmpm_own_marks, only: node_owners
  use qsmpm_own_part, only: is_divided
  use qsmpm_owner_copies, only: list_copies, copy_values
  use qsmpm_point_location, only: activation_type, add_active
  use qsmpm_space, only: node_label
  implicit none
  private

  public :: list_neighbours, near_cells, learn_active_cells, learn_touched_cells, learn_cell_values

  !> Rows of cells beyond the ring that are requested: a face of the ghost penalty extends one beyond the functions, and
  !> values at the boundary depend on the cells around it.
  integer, parameter, public :: rows_beyond = 2

contains

  !> Lists the cells and nodes of other processes near the own part, if division or window have changed on any process.
  subroutine list_neighbours(model)
    type(model_type), intent(inout) :: model
    integer :: cell(model%mesh%cell_count), label(model%space%node_count), a
    logical :: is_new

    if (.not. is_divided(model%part)) return
    associate (part => model%part, window => model%state%window)
      is_new = .not. allocated(part%cell_copies%taken) .or. .not. part%copied_window == window
      if (.not. any_of(part%team, is_new)) return
      label = [(node_label(model%space, model%mesh, a), a=1, size(label))]
      cell = whole_cells(model, [(a, a=1, size(cell))])
      ! Ranks that own the cells which are own or near own ones; -1 for the others.
      call list_copies(part%team, cell, merge(part%owners%of_cells(cell), -1, part%owners%near(part%team%rank, &
        part%ring + rows_beyond, cell)), part%cell_copies)
      call list_copies(part%team, label, node_owners(model), part%node_copies)
      part%copied_window = window
    end associate
  end subroutine list_neighbours

  !> Marks cells that are own or within a number of rows around these; on a single process all are own.
  pure function near_cells(model, rows) result(near)
    type(model_type), intent(in) :: model
    integer, intent(in) :: rows
    logical :: near(model%mesh%cell_count)
    integer :: c

    near = .true.
    associate (part => model%part)
      if (is_divided(part)) near = part%owners%near(part%team%rank, rows, whole_cells(model, [(c, c=1, size(near))]))
    end associate
  end function near_cells

  !> Adds the active cells near the own part without a point here, with the filled fraction from their owners.
  subroutine learn_active_cells(model, activation)
    type(model_type), intent(in) :: model
    type(activation_type), intent(inout) :: activation
    !> Whether a cell is active, and its filled fraction.
    real(wp) :: values(2, model%mesh%cell_count)
    integer, allocatable :: others(:)
    integer :: c

    values = 0.0_wp
    values(1, activation%active_cell) = 1.0_wp
    values(2, activation%active_cell) = activation%fill
    call copy_values(model%part%team, model%part%cell_copies, values)
    others = pack([(c, c=1, size(values, 2))], values(1, :) > 0.0_wp .and. activation%active_number == 0)
    call add_active(others, values(2, others), activation)
  end subroutine learn_active_cells

  !> Marks the cells that the domains of points on other processes intersect.
  subroutine learn_touched_cells(model, activation)
    type(model_type), intent(in) :: model
    type(activation_type), intent(inout) :: activation
    real(wp) :: values(1, model%mesh%cell_count)

    values(1, :) = merge(1.0_wp, 0.0_wp, activation%touched)
    call copy_values(model%part%team, model%part%cell_copies, values)
    activation%touched = activation%touched .or. values(1, :) > 0.0_wp
  end subroutine learn_touched_cells

  !> Completes values of active cells: those of cells without a point here are sent by their owners.
  subroutine learn_cell_values(model, activation, of_cell)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    !> (known_count)
    real(wp), intent(inout) :: of_cell(:)
    real(wp) :: values(1, model%mesh%cell_count)

    values = 0.0_wp
    values(1, activation%active_cell) = of_cell
    call copy_values(model%part%team, model%part%cell_copies, values)
    of_cell(activation%active_count + 1:) = values(1, activation%active_cell(activation%active_count + 1:))
  end subroutine learn_cell_values
end module qsmpm_ring_exchange
