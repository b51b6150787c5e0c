!> Checks whether a state read from a file is valid for a model: counts and indices are in range, reals are finite. An
!> invalid state would index beyond an array, or contains values that no step has written.
module qsmpm_state_check
  use qsmpm_kinds, only: wp
  use qsmpm_mesh_description, only: mesh_grid
  use qsmpm_phase_description, only: not_ended, ended_by_loss
  use qsmpm_finite, only: is_usable
  use qsmpm_grid, only: pieces_of, whole_window
  use qsmpm_grid_window, only: window_type, cells_of
  use qsmpm_inactive_points, only: inactive_points_type
  use qsmpm_limit_load, only: limit_load_type
  use qsmpm_model, only: model_type, progress_type, state_type
  use qsmpm_model_mesh, only: grid_of
  use qsmpm_field_list, only: field_list_type
  use qsmpm_points, only: carried_type, points_type, watched_points_type
  implicit none
  private

  public :: check_state, places_reason, window_reason

  character(len=*), parameter :: misfit = ' in it cannot be those of this analysis'

contains

  !> Returns what is invalid in a state; empty if it is valid.
  function check_state(state, model, window) result(reason)
    type(state_type), intent(in) :: state
    !> A model built from the same deck.
    type(model_type), intent(in) :: model
    !> Window in which the cells are numbered; by default that of the state.
    type(window_type), intent(in), optional :: window
    character(len=:), allocatable :: reason
    integer :: cells, i

    cells = cell_count(state%window, model)
    if (present(window)) cells = cell_count(window, model)
    reason = ''
    if (.not. progress_good(state%progress, size(model%analysis%phases))) reason = 'the progress'
    if (.not. carried_good(state%points, 1, cells)) reason = 'the material points'
    if (.not. points_good(state%points, model)) reason = 'the material points'
    if (.not. inactive_good(state%inactive, cells, model)) reason = 'the bodies that are not there'
    if (.not. carried_good(state%surface, 0, cells)) reason = 'the surface points'
    if (.not. carried_good(state%tracers, 0, cells)) reason = 'the tracers'
    if (.not. watched_good(state%watched, cells, model)) reason = 'the watched places'
    if (.not. (all(is_usable(state%coordinates)) .and. all(is_usable(state%reactions)))) reason = 'the mesh'
    if (.not. all(is_usable(state%released))) reason = 'the mesh'
    if (.not. all(is_usable([state%plate]))) reason = 'the mesh'
    if (allocated(state%kept%list)) then
      do i = 1, size(state%kept%list)
        if (.not. all(is_usable(state%kept%list(i)%values))) reason = state%kept%list(i)%name
      end do
    end if
    if (len(reason) > 0) reason = reason//misfit
  end function check_state

  !> Returns what is invalid in the cells of points; empty if they are valid.
  pure function places_reason(cell, lowest, window, model, what) result(reason)
    !> Cell numbers in a window; lowest number allowed.
    integer, intent(in) :: cell(:), lowest
    type(window_type), intent(in) :: window
    type(model_type), intent(in) :: model
    !> Name of the set, for the message.
    character(len=*), intent(in) :: what
    character(len=:), allocatable :: reason

    reason = ''
    if (any(cell < lowest .or. cell > cell_count(window, model))) reason = what//misfit
  end function places_reason

  !> Returns what is invalid in a part of the grid; empty if it is valid.
  pure function window_reason(window, model) result(reason)
    !> First and last cells along each axis (6).
    integer, intent(in) :: window(:)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: reason
    type(window_type) :: whole
    logical :: good

    reason = ''
    good = all(window(:3) >= 1 .and. window(:3) <= window(4:))
    if (model%analysis%mesh%kind == mesh_grid .and. good) then
      whole = whole_window(grid_of(model%analysis))
      good = all(window(4:) <= whole%last)
    end if
    if (.not. good) reason = 'the part of the grid in it is none'
  end function window_reason

  !> Returns the number of mesh cells in a part of the grid.
  pure integer function cell_count(window, model)
    type(window_type), intent(in) :: window
    type(model_type), intent(in) :: model

    cell_count = model%mesh%cell_count
    if (model%analysis%mesh%kind == mesh_grid) &
      cell_count = product(cells_of(window))*pieces_of(grid_of(model%analysis))
  end function cell_count

  !> Returns whether the progress is possible for the phases.
  pure logical function progress_good(progress, phases)
    type(progress_type), intent(in) :: progress
    integer, intent(in) :: phases

    progress_good = progress%phase >= 1 .and. progress%phase <= phases .and. &
      min(progress%step, progress%phase_steps, progress%constant_load_tests_done) >= 0 .and. &
      progress%fraction >= 0.0_wp .and. progress%fraction <= 1.0_wp .and. progress%next_step >= 0.0_wp .and. &
      progress%release_left >= 0.0_wp .and. progress%release_left <= 1.0_wp .and. &
      progress%failed_solvers >= 0 .and. progress%failed_solvers <= 7 .and. &
      min(progress%own_settlement, progress%force_at_start) >= 0.0_wp .and. &
      max(progress%own_settlement, progress%force_at_start) <= huge(1.0_wp) .and. &
      progress%damping >= 0.0_wp .and. all(is_usable([progress%load_factor, progress%next_step, progress%damping, &
      progress%external_work, progress%internal_work])) .and. limit_good(progress%limit) .and. &
      search_good(progress, phases) .and. ends_good(progress, phases)
  end function progress_good

  !> Returns whether strength factors are possible for safety phases.
  pure logical function search_good(progress, phases)
    type(progress_type), intent(in) :: progress
    integer, intent(in) :: phases

    associate (b => progress%bracket)
      search_good = all(is_usable([progress%strength_factor, b%stable, b%lost, b%lost_above, b%increment])) .and. &
        progress%strength_factor > 0.0_wp .and. minval([b%stable, b%lost, b%lost_above]) >= 0.0_wp .and. &
        b%increment > 0.0_wp
    end associate
    if (.not. allocated(progress%factors)) return
    search_good = search_good .and. size(progress%factors, 1) == 4
    if (search_good .and. size(progress%factors) > 0) search_good = all(is_usable(progress%factors)) .and. &
      minval(progress%factors) >= 0.0_wp .and. maxval(progress%factors(1, :)) <= real(phases, wp)
  end function search_good

  !> Returns whether the ends of phases are possible.
  pure logical function ends_good(progress, phases)
    type(progress_type), intent(in) :: progress
    integer, intent(in) :: phases

    ends_good = .true.
    if (.not. allocated(progress%ends)) return
    ends_good = size(progress%ends) <= phases .and. all(progress%ends%reason >= not_ended) .and. &
      all(progress%ends%reason <= ended_by_loss) .and. all(is_usable(progress%ends%displacement)) .and. &
      all(progress%ends%fraction >= 0.0_wp .and. progress%ends%fraction <= 1.0_wp)
  end function ends_good

  !> Returns whether compliances and load fractions are possible for a phase.
  pure logical function limit_good(limit)
    type(limit_load_type), intent(in) :: limit

    limit_good = all(is_usable([limit%first, limit%last, limit%most, limit%refused_compliance, limit%square])) .and. &
      all(abs([limit%middle, limit%refused, limit%refused_middle, limit%plateau, limit%knee, abs(limit%passed)] - &
      0.5_wp) <= 0.5_wp)
  end function limit_good

  !> Returns whether all fields are finite and the points are in cells of the mesh.
  logical function carried_good(carried, first_cell, last_cell)
    class(carried_type), intent(in), target :: carried
    integer, intent(in) :: first_cell, last_cell
    type(field_list_type) :: list
    integer :: i

    carried_good = carried%count == size(carried%cell) .and. all(carried%cell >= first_cell) .and. &
      all(carried%cell <= last_cell)
    call carried%list_fields(list)
    do i = 1, list%count
      if (associated(list%fields(i)%reals)) carried_good = carried_good .and. all(is_usable(list%fields(i)%reals))
    end do
  end function carried_good

  !> Returns whether watched points refer to existing sets and components.
  logical function watched_good(watched, last_cell, model)
    type(watched_points_type), intent(in) :: watched
    integer, intent(in) :: last_cell
    type(model_type), intent(in) :: model

    watched_good = carried_good(watched, 0, last_cell) .and. all(watched%set >= 1) .and. &
      all(watched%component >= 1) .and. all(watched%component <= model%mesh%dimension)
    if (allocated(model%mesh%node_sets)) &
      watched_good = watched_good .and. all(watched%set <= size(model%mesh%node_sets))
  end function watched_good

  !> Returns whether the data of inactive bodies are possible.
  logical function inactive_good(inactive, last_cell, model)
    type(inactive_points_type), intent(in) :: inactive
    integer, intent(in) :: last_cell
    type(model_type), intent(in) :: model
    logical :: good(5)

    good(1) = carried_good(inactive%points, 1, last_cell)
    good(2) = carried_good(inactive%unloading, 1, last_cell)
    good(3) = carried_good(inactive%surface, 0, last_cell)
    good(4) = carried_good(inactive%unloading_surface, 0, last_cell)
    good(5) = carried_good(inactive%feet, 0, last_cell)
    inactive_good = all(good) .and. points_good(inactive%points, model) .and. points_good(inactive%unloading, model)
  end function inactive_good

  !> Returns whether material points refer to existing bodies and materials and have valid volumes and stretches.
  pure logical function points_good(points, model)
    type(points_type), intent(in) :: points
    type(model_type), intent(in) :: model

    points_good = min(minval([1, points%body]), minval([1, points%material])) >= 1 .and. all(points%volume > 0.0_wp) &
      .and. all(points%left_cauchy_green(1:3, :) > 0.0_wp)
    if (allocated(model%analysis%bodies)) &
      points_good = points_good .and. all(points%body <= size(model%analysis%bodies))
    if (allocated(model%analysis%materials)) &
      points_good = points_good .and. all(points%material <= size(model%analysis%materials))
  end function points_good
end module qsmpm_state_check
