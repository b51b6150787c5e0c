!> Domain decomposition: division of a model among the processes of a team, and reassembly of the complete model.
!>
!> A model is divided as it is built, or built whole by every process, which then keeps the material points and surface
!> points of its own cells (qsmpm_cell_owners) and those in a ring of cells around them, and uses only that part of a
!> grid. After an accepted step the copies are discarded, points that have left the cells are sent to their new owners,
!> and every process receives new copies, so that copies never differ from their originals. Points of bodies that the
!> phase removes are treated alike. Tracers, watched places and feet of bodies are few: all processes store all of them,
!> and the one that owns their cell moves them. Inactive bodies are stored separately.
module qsmpm_division
  use qsmpm_kinds, only: wp, long
  use qsmpm_active_bodies, only: bodies_active
  use qsmpm_agreement, only: agree
  use qsmpm_analysis, only: analysis_type
  use qsmpm_mesh_description, only: mesh_grid
  use qsmpm_method_description, only: integrate_cells, basis_list
  use qsmpm_structures, only: contact_on_body
  use qsmpm_cell_numbers, only: whole_of, number_all, add_places
  use qsmpm_cell_boxes, only: box_owners_type
  use qsmpm_cell_owners, only: cell_owners_type
  use qsmpm_cell_sharing, only: has_boxes, share_model
  use qsmpm_error, only: error_type, fail, error_deck, error_other
  use qsmpm_model_window, only: least_margin, usual_margin, fit_window, lay_window
  use qsmpm_grid, only: grid_type
  use qsmpm_grid_window, only: window_type, operator(==), cell_place, cells_over, holds, hull, widen
  use qsmpm_kept_arrays, only: kept_arrays_type, clear_nodal
  use qsmpm_model, only: model_type
  use qsmpm_model_mesh, only: grid_of
  use qsmpm_outline_surfaces, only: is_laid_anew
  use qsmpm_own_marks, only: link_histories, mark_own, near_ones, send_points, share_places
  use qsmpm_own_part, only: own_part_type, is_divided, own_of, reset_copies
  use qsmpm_point_delivery, only: fingerprint
  use qsmpm_point_selection, only: keep_chosen, select_points
  use qsmpm_points, only: carried_type
  use qsmpm_ring_exchange, only: rows_beyond
  use qsmpm_sorting, only: order_columns, place_in_order
  use qsmpm_surface_refinement, only: refine_surfaces
  use qsmpm_space, only: node_label, node_position
  use qsmpm_team, only: team_type, largest, total, hand_over
  use qsmpm_text, only: integer_text, real_text
  implicit none
  private

  !> Nodal values by node labels: reactions and released forces (dimension, labels), arrays of the terms.
  type :: node_values_type
    integer, allocatable :: labels(:)
    real(wp), allocatable :: reactions(:, :), released(:, :)
    type(kept_arrays_type) :: kept
  end type node_values_type

  !> Numbers of a census: four for each of three sets.
  integer, parameter :: census_size = 12

  !> Additional rows of a ring where places outside of material move with the nearest material point, where bodies are
  !> in contact with surfaces, and where cells of a mesh share pressures or gradients.
  integer, parameter :: nearest_rows = 2, contact_rows = 2, element_rows = 3

  !> Rows over which a patch on a body extends, including a short one merged with it, and that of the surrounding soil.
  integer, parameter :: body_rows = 4

  !> Additional rows of a ring where cells may share a pressure: a pair, and one more at either end.
  integer, parameter :: patch_rows = 2

  character(len=*), parameter :: lost = 'material points, or what they carry, were lost between the processes'

  public :: node_values_type, put_node_values, kept_count, share_cells, divide_model, enter_team, refuse_short, &
    settle_part, settle_near, divide_anew, division_text, join_model, look_at_all, migrate_points, unevenness, &
    ring_of, rows_of

contains

  !> Divides a whole model.
  subroutine divide_model(model, team, error)
    type(model_type), intent(inout) :: model
    type(team_type), intent(in) :: team
    !> error_deck: there are too few cells with material.
    type(error_type), allocatable, intent(out) :: error
    logical :: short

    if (team%ranks == 1 .or. is_divided(model%part)) return
    call refine_surfaces(model)
    call share_cells(model, team%ranks, short)
    if (short) then
      deallocate (model%part%owners)
      call refuse_short(team%ranks, error)
      return
    end if
    call enter_team(model, team)
    call settle_part(model)
  end subroutine divide_model

  !> Reports that there are fewer cells with material than a team requires.
  subroutine refuse_short(ranks, error)
    integer, intent(in) :: ranks
    type(error_type), allocatable, intent(out) :: error

    call fail(error, error_deck, 'the material occupies too few cells of the mesh to be divided among '// &
      integer_text(ranks)//' processes')
  end subroutine refuse_short

  !> Assigns a whole model to a team that has not divided it yet.
  subroutine enter_team(model, team)
    type(model_type), intent(inout) :: model
    type(team_type), intent(in) :: team

    if (is_divided(model%part)) return
    model%part%team = team
    model%part%ring = ring_of(model%analysis)
    model%part%history_number = numbers_of(model)
    ! Points that apply tractions are identified by their numbers while the model is divided.
    if (allocated(model%carrying_point)) model%carrying_point = int(model%state%points%number(model%carrying_point))
  end subroutine enter_team

  !> Keeps the part of a model that belongs to this process, once the owners of the cells are known.
  subroutine settle_part(model)
    !> Its points are those of the whole model, or a subset that includes all nearby ones.
    type(model_type), intent(inout) :: model

    call number_all(model, model%state%window, whole_of(model))
    call settle_near(model)
  end subroutine settle_part

  !> Keeps the part of this process, with the cells numbered as in the whole mesh.
  subroutine settle_near(model)
    type(model_type), intent(inout) :: model
    integer :: b

    associate (part => model%part, unloading => model%state%inactive%unloading)
      call select_points(model%state%points, [1], part%like)
      part%taken_out = total(part%team, [(count(unloading%body == b, kind=long), b=1, size(model%analysis%bodies))]) > 0
    end associate
    call take_near(model)
    call look_at(model, .true.)
  end subroutine settle_near

  !> Divides a divided model differently, by the current positions of its points, which are sent to their new owners.
  subroutine divide_anew(model, error)
    type(model_type), intent(inout) :: model
    !> error_other: points were lost or duplicated.
    type(error_type), allocatable, intent(out) :: error
    class(cell_owners_type), allocatable :: owners
    type(node_values_type) :: nodes
    integer(long) :: before(census_size)
    logical :: short

    before = census(model)
    call share_model(model, model%part%team%ranks, rows_of(model%analysis), owners, short)
    ! With too few cells the distribution is not changed.
    if (short) return
    call collect_forces(model, nodes)
    call move_alloc(owners, model%part%owners)
    call reset_copies(model%part)
    call send_all(model, .false.)
    call look_at(model, .true.)
    model%state%reactions = 0.0_wp
    model%state%released = 0.0_wp
    call put_node_values(model, nodes)
    if (any(census(model) /= before)) call fail(error, error_other, lost)
  end subroutine divide_anew

  !> Determines the owners of the cells. A mesh that is distributed in parts is stored whole.
  subroutine share_cells(model, ranks, short)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: ranks
    !> There are too few cells with material.
    logical, intent(out) :: short
    type(window_type) :: window

    if (.not. has_boxes(model%analysis) .and. .not. model%state%window == whole_of(model)) then
      window = model%state%window
      call lay_window(model, whole_of(model))
      call number_all(model, window, model%state%window)
    end if
    call share_model(model, ranks, rows_of(model%analysis), model%part%owners, short)
  end subroutine share_cells

  !> Keeps points owned by this process or in its ring, and separates inactive ones; cells are numbered as in the
  !> whole mesh.
  subroutine take_near(model)
    type(model_type), intent(inout) :: model

    associate (part => model%part, state => model%state, inactive => model%state%inactive)
      call keep_chosen(state%points, near_ones(part, state%points, part%ring))
      call keep_chosen(inactive%unloading, near_ones(part, inactive%unloading, part%ring))
      call keep_chosen(state%surface, near_ones(part, state%surface, part%ring - 1))
      call keep_chosen(inactive%unloading_surface, near_ones(part, inactive%unloading_surface, part%ring - 1))
      part%waiting = inactive%points
      part%waiting_surface = inactive%surface
      call select_points(part%waiting, spread(1, 1, 0), inactive%points)
      call select_points(part%waiting_surface, spread(1, 1, 0), inactive%surface)
    end associate
  end subroutine take_near

  !> Number of rows of cells around own ones whose points are within the support of own functions: half the cells that a
  !> function extends over, and one more where points have domains. Other data that depend on surrounding cells are sent
  !> by their owners (qsmpm_ring_exchange), except for these: a surface point that has left the cells with material
  !> moves with the nearest point, one cell beyond the ring of copied surface points, and removed material moves with
  !> the nodes of cells within the functions of others. Contact patches merge with their neighbours, and these with
  !> theirs; one on a body that acts on own nodes, possible up to degree cells plus one away, must be whole, with the
  !> surrounding soil. Cells of elements other than QUAD4 and HEX8 may share a pressure or the gradients at their nodes.
  pure integer function ring_of(analysis) result(ring)
    type(analysis_type), intent(in) :: analysis
    integer :: p

    associate (basis => basis_list(analysis%method%basis), cells => analysis%method%integration == integrate_cells)
      ring = (max(1, basis%degree) + 1)/2
      if (basis%averaged .or. (cells .and. basis%degree > 0)) ring = ring + 1
      if (size(analysis%surfaces) + size(analysis%rigid_bodies) > 0 .or. &
        any([(.not. all(bodies_active(analysis, p)), p=1, size(analysis%phases))])) ring = ring + nearest_rows
      if (size(analysis%rigid_bodies) > 0) ring = ring + contact_rows
      if (any(analysis%contacts%place == contact_on_body)) ring = max(ring, max(1, basis%degree) + 1 + body_rows)
      if (.not. has_boxes(analysis)) ring = ring + patch_rows
    end associate
    if (analysis%mesh%kind == mesh_grid) then
      if (any(analysis%mesh%element == ['QUAD4', 'HEX8 '])) return
    end if
    ring = ring + element_rows
  end function ring_of

  !> Number of rows of cells around its own that a process requires.
  pure integer function rows_of(analysis) result(rows)
    type(analysis_type), intent(in) :: analysis

    rows = ring_of(analysis) + rows_beyond
  end function rows_of

  !> Sends points to their new owners, and copies to the processes in whose rings they are.
  subroutine migrate_points(model, error)
    type(model_type), intent(inout) :: model
    !> error_other, on all processes alike: points were lost or duplicated, or places have left the nearby material.
    type(error_type), allocatable, intent(out) :: error
    integer(long) :: before(census_size)

    if (.not. is_divided(model%part)) return
    before = census(model)
    call send_all(model, .false.)
    associate (state => model%state, inactive => model%state%inactive)
      ! A process without material cannot determine how surface points of others move.
      if (state%points%count == 0) call keep_chosen(state%surface, near_ones(model%part, state%surface, 0))
      if (state%points%count + inactive%unloading%count == 0) &
        call keep_chosen(inactive%unloading_surface, near_ones(model%part, inactive%unloading_surface, 0))
    end associate
    call look_at(model, .false.)
    if (any(census(model) /= before)) then
      call fail(error, error_other, lost)
    else if (is_left_behind(model)) then
      call fail(error, error_other, 'a surface or a history place is too far from any material')
    end if
    call agree(model%part%team, error)
  end subroutine migrate_points

  !> Sends own points and the data of other places; on return cells are numbered as in the whole mesh.
  subroutine send_all(model, everywhere)
    type(model_type), intent(inout) :: model
    !> Every process receives all.
    logical, intent(in) :: everywhere

    call number_all(model, model%state%window, whole_of(model))
    associate (part => model%part, state => model%state, inactive => model%state%inactive)
      ! Surface points are copied from one row less, since the nearest material point to each is searched for
      ! (qsmpm_carried_basis).
      call send_points(part, part%points, part%ring, state%points, everywhere)
      call send_points(part, part%surface, part%ring - 1, state%surface, everywhere)
      if (any(part%taken_out)) then
        call send_points(part, part%unloading, part%ring, inactive%unloading, everywhere)
        call send_points(part, part%unloading_surface, part%ring - 1, inactive%unloading_surface, everywhere)
      end if
      call share_places(part, part%tracers, part%tracer_cell, state%tracers)
      call share_places(part, part%watched, part%watched_cell, state%watched)
      call share_places(part, part%feet, part%foot_cell, inactive%feet)
    end associate
  end subroutine send_all

  !> Checks whether a point that this process has to move is outside of its part of the grid.
  pure logical function is_left_behind(model) result(behind)
    type(model_type), intent(in) :: model
    logical :: waits(model%state%tracers%count)

    associate (part => model%part, state => model%state)
      waits = .false.
      if (allocated(model%tracer_body)) then
        associate (active => bodies_active(model%analysis, state%progress%phase) .or. part%taken_out)
          waits = .not. active(model%tracer_body)
        end associate
      end if
      associate (laid => is_laid_anew(model))
        behind = state%points%count == 0 .and. .not. all(laid(state%surface%surface))
      end associate
      behind = behind .or. any(part%tracers .and. state%tracers%cell == 0 .and. .not. waits)
      behind = behind .or. any(part%watched .and. state%watched%cell == 0)
    end associate
  end function is_left_behind

  !> Restores the whole model on every process.
  subroutine join_model(model, error)
    type(model_type), intent(inout) :: model
    type(error_type), allocatable, intent(out) :: error
    type(own_part_type) :: alone
    type(node_values_type) :: nodes
    integer(long) :: before(census_size)

    if (.not. is_divided(model%part)) return
    before = census(model)
    call collect_forces(model, nodes)
    call send_all(model, .true.)
    associate (state => model%state)
      state%inactive%points = model%part%waiting
      state%inactive%surface = model%part%waiting_surface
      call link_histories(model, model%part%history_number, spread(.true., 1, state%points%count))
      call carry_by_place(model)
      model%part = alone
      if (any(census(model) /= before)) call fail(error, error_other, lost)
    end associate
    if (allocated(error)) return
    call look_at_all(model)
    call put_node_values(model, nodes)
  end subroutine join_model

  !> Generates the window with the points and places of all processes, before there are forces or nodal data. On entry
  !> cells are numbered as in the whole grid, on return as in the window.
  subroutine look_at_all(model)
    type(model_type), intent(inout) :: model
    type(window_type) :: used

    if (model%analysis%mesh%kind /= mesh_grid) then
      model%state%reactions = 0.0_wp
      model%state%released = 0.0_wp
      return
    end if
    used = cells_used(model)
    associate (inactive => model%state%inactive)
      call add_places(model, model%state%tracers, used)
      call add_places(model, inactive%points, used)
      call add_places(model, inactive%surface, used)
      call add_places(model, inactive%feet, used)
    end associate
    call fit_window(model, with_margin(model, used))
    call number_all(model, whole_of(model), model%state%window)
    call clear_nodal(model%state%kept, model%space%node_count)
  end subroutine look_at_all

  !> Converts points that apply tractions back to positions in the whole model, whose points are sorted by number.
  pure subroutine carry_by_place(model)
    type(model_type), intent(inout) :: model
    integer :: i

    if (.not. allocated(model%carrying_point)) return
    do i = 1, size(model%carrying_point)
      model%carrying_point(i) = place_in_order(int(model%state%points%number), model%carrying_point(i))
    end do
  end subroutine carry_by_place

  !> Returns a description of the distribution of the points, for the log.
  function division_text(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    real(wp) :: copies

    associate (part => model%part)
      copies = real(total(part%team, count(.not. part%points, kind=long)), wp) &
        /real(total(part%team, count(part%points, kind=long)), wp)
      text = 'shared by '//integer_text(part%team%ranks)//' processes: imbalance '//two_digits(unevenness(model))// &
        ' of their points, '//two_digits(copies)//' copies of a point'
    end associate

  contains

    !> Returns a number with two decimals.
    function two_digits(x) result(text)
      real(wp), intent(in) :: x
      character(len=:), allocatable :: text

      text = real_text(real(nint(100.0_wp*x), wp)/100.0_wp)
    end function two_digits
  end function division_text

  !> Largest number of own points of a process relative to the mean; 1 for an undivided model.
  real(wp) function unevenness(model)
    type(model_type), intent(in) :: model
    real(wp) :: own

    unevenness = 1.0_wp
    if (.not. is_divided(model%part)) return
    associate (part => model%part)
      own = real(count(part%points), wp)
      unevenness = largest(part%team, own)*part%team%ranks/total(part%team, own)
    end associate
  end function unevenness

  !> Own material points, removed ones, and surface points of all processes: their number, and the sums of their numbers
  !> and of the quantities that they store.
  function census(model) result(sums)
    type(model_type), intent(in) :: model
    integer(long) :: sums(census_size)

    associate (part => model%part, state => model%state)
      sums = [counts(state%points, part%points), counts(state%inactive%unloading, part%unloading), &
        counts(state%surface, part%surface)]
    end associate

  contains

    !> Census of one set.
    function counts(carried, marks)
      class(carried_type), intent(in) :: carried
      !> Marks of own ones; unallocated if all are own.
      logical, allocatable, intent(in) :: marks(:)
      integer(long) :: counts(census_size/3)
      logical :: own(carried%count)

      own = own_of(marks, carried%count)
      associate (team => model%part%team)
        counts = [total(team, count(own, kind=long)), total(team, sum(carried%number, mask=own)), &
          fingerprint(team, carried, own)]
      end associate
    end function counts
  end function census

  !> Cells of material and surface points, including removed ones, by their positions in the whole grid.
  pure type(window_type) function cells_used(model) result(used)
    type(model_type), intent(in) :: model

    used%first = huge(used%first)
    used%last = -huge(used%last)
    associate (state => model%state)
      call add_places(model, state%points, used)
      call add_places(model, state%surface, used)
      call add_places(model, state%inactive%unloading, used)
      call add_places(model, state%inactive%unloading_surface, used)
    end associate
    call add_outlines(model, used)
  end function cells_used

  !> Extends a window by the cells near the own box that may contain bodies integrated over their outlines: those
  !> between their vertices. They may contain a part of a body and no point.
  pure subroutine add_outlines(model, used)
    type(model_type), intent(in) :: model
    type(window_type), intent(inout) :: used
    type(window_type) :: held
    integer :: k, i

    if (.not. is_divided(model%part)) return
    select type (owners => model%part%owners)
    type is (box_owners_type)
      do k = 1, size(model%outlines)
        if (.not. model%outlines(k)%integrates) cycle
        held%first = huge(held%first)
        held%last = -huge(held%last)
        do i = model%outlines(k)%before + 1, model%outlines(k)%before + model%outlines(k)%count
          if (model%state%tracers%cell(i) == 0) cycle
          associate (at => cell_place(owners%whole, owners%pieces, model%state%tracers%cell(i)))
            held%first = min(held%first, at)
            held%last = max(held%last, at)
          end associate
        end do
        associate (box => owners%boxes(model%part%team%rank + 1))
          held%first = max(held%first, box%first - model%part%ring)
          held%last = min(held%last, box%last + model%part%ring)
        end associate
        if (all(held%first <= held%last)) used = hull(used, held)
      end do
    end select
  end subroutine add_outlines

  !> Window with the usual margin.
  pure type(window_type) function with_margin(model, used) result(window)
    type(model_type), intent(in) :: model
    type(window_type), intent(in) :: used

    window = widen(used, usual_margin(model%analysis, used%last - used%first + 1), whole_of(model))
  end function with_margin

  !> Generates the window around the points, and marks own ones. On entry cells are numbered as in the whole grid, on
  !> return as in the window.
  subroutine look_at(model, anew)
    type(model_type), intent(inout) :: model
    !> The window is that of another division.
    logical, intent(in) :: anew

    if (has_boxes(model%analysis)) call follow_points(model, anew)
    associate (part => model%part, state => model%state)
      part%tracer_cell = state%tracers%cell
      part%watched_cell = state%watched%cell
      part%foot_cell = state%inactive%feet%cell
      call number_all(model, whole_of(model), model%state%window)
    end associate
    call mark_own(model)
  end subroutine look_at

  !> Generates the window around the points if it has changed; a process without points keeps its own. The reactions of
  !> the step that moved them act at their former positions, and must be within it.
  subroutine follow_points(model, anew)
    type(model_type), intent(inout) :: model
    logical, intent(in) :: anew
    type(window_type) :: used, window
    integer :: a

    used = cells_used(model)
    if (used%first(1) > used%last(1)) return
    a = least_margin(model%analysis)
    if (.not. anew .and. holds(model%state%window, widen(used, [a, a, a], whole_of(model)))) return
    window = with_margin(model, used)
    if (.not. anew) call add_loaded_cells(model, window)
    call lay_window(model, window)
  end subroutine follow_points

  !> Extends a window by the cells around the nodes with forces.
  pure subroutine add_loaded_cells(model, window)
    type(model_type), intent(in) :: model
    type(window_type), intent(inout) :: window
    type(window_type) :: around
    type(grid_type) :: grid
    real(wp) :: place(model%mesh%dimension)
    integer :: a, i

    grid = grid_of(model%analysis)
    do i = 1, model%space%node_count
      if (.not. (any(abs(model%state%reactions(:, i)) > 0.0_wp) .or. &
        any(abs(model%state%released(:, i)) > 0.0_wp))) cycle
      place = node_position(model%space, model%mesh, i)
      do a = 1, size(place)
        call cells_over(grid%axes(a)%lines, place(a), place(a), around%first(a), around%last(a))
      end do
      window = hull(window, around)
    end do
  end subroutine add_loaded_cells

  !> Numbers of the points of histories, 0 for none.
  pure function numbers_of(model) result(numbers)
    type(model_type), intent(in) :: model
    integer(long) :: numbers(size(model%history_point))
    integer :: i

    numbers = 0
    do i = 1, size(numbers)
      if (model%history_point(i) > 0) numbers(i) = model%state%points%number(model%history_point(i))
    end do
  end function numbers_of

  !> Collects reactions and released forces at the own nodes of all processes, if any.
  subroutine collect_forces(model, nodes)
    type(model_type), intent(in) :: model
    !> Without arrays of the terms.
    type(node_values_type), intent(out) :: nodes
    integer(long), allocatable :: labels(:)
    real(wp), allocatable :: table(:, :), got(:)
    integer, allocatable :: chosen(:), first(:)
    integer :: d, i, n, r

    associate (part => model%part, reactions => model%state%reactions, released => model%state%released)
      d = size(reactions, 1)
      chosen = pack([(i, i=1, size(part%nodes))], part%nodes .and. (any(abs(reactions) > 0.0_wp, dim=1) .or. &
        any(abs(released) > 0.0_wp, dim=1)))
      n = size(chosen)
      allocate (table(2*d, n))
      table(:d, :) = reactions(:, chosen)
      table(d + 1:, :) = released(:, chosen)
      ! The same data for every process.
      call hand_over(part%team, [((int(node_label(model%space, model%mesh, chosen(i)), long), i=1, n), &
        r=1, part%team%ranks)], [(1 + n*r, r=0, part%team%ranks)], labels, first)
      call hand_over(part%team, [(table, r=1, part%team%ranks)], [(1 + 2*d*n*r, r=0, part%team%ranks)], got, first)
    end associate
    nodes%labels = int(labels)
    table = reshape(got, [2*d, size(labels)])
    nodes%reactions = table(:d, :)
    nodes%released = table(d + 1:, :)
  end subroutine collect_forces

  !> Sets the values at the nodes of a model that have them; arrays of the terms are zero at the others.
  subroutine put_node_values(model, nodes)
    type(model_type), intent(inout) :: model
    type(node_values_type), intent(in) :: nodes
    integer :: order(size(nodes%labels)), sorted(size(nodes%labels)), a, i, k

    if (kept_count(nodes%kept) > 0) call clear_nodal(model%state%kept, model%space%node_count)
    call order_columns(reshape(nodes%labels, [1, size(order)]), order)
    sorted = nodes%labels(order)
    do a = 1, model%space%node_count
      k = place_in_order(sorted, node_label(model%space, model%mesh, a))
      if (k == 0) cycle
      model%state%reactions(:, a) = nodes%reactions(:, order(k))
      model%state%released(:, a) = nodes%released(:, order(k))
      do i = 1, kept_count(nodes%kept)
        if (nodes%kept%list(i)%nodal) model%state%kept%list(i)%values(:, a) = nodes%kept%list(i)%values(:, order(k))
      end do
    end do
  end subroutine put_node_values

  !> Returns the number of arrays of the terms.
  pure integer function kept_count(kept)
    type(kept_arrays_type), intent(in) :: kept

    kept_count = 0
    if (allocated(kept%list)) kept_count = size(kept%list)
  end function kept_count
end module qsmpm_division
