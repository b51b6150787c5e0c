!> A model divided between the processes of a team, and made whole again.
!>
!> A model is divided as it is built, or built whole by every process, which then keeps the material points and
!> surface points of its own cells (qsmpm_cell_owners) and those in a ring of cells around them, and looks at that
!> part of a grid only. After an accepted step the copies are thrown away, points that have left the cells go to the
!> process whose own they are in, and every process gets copies anew, so that copies never differ from what they are
!> copies of. Points of bodies that the phase takes out go the same way. Tracers, watched places and feet of bodies are
!> few: all processes have all of them, and the one in whose cells they are moves them. Bodies that wait are put aside.
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
  use qsmpm_kept_arrays, only: clear_nodal
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

  !> Numbers of a census: four of each of three sets.
  integer, parameter :: census_size = 12

  !> Rows of cells that a ring is wider where places that are in no material go with the nearest of it, where bodies
  !> touch surfaces, and where cells of a mesh share pressures or gradients.
  integer, parameter :: nearest_rows = 2, contact_rows = 2, element_rows = 3

  !> Rows over which a patch on a body goes on, with a short one that joins it, and the one of the soil around it.
  integer, parameter :: body_rows = 4

  !> Rows of cells that a ring is wider where cells may share a pressure: a pair, and one more at either end.
  integer, parameter :: patch_rows = 2

  character(len=*), parameter :: lost = 'material points, or what they carry, were lost between the processes'

  public :: share_cells, divide_model, enter_team, refuse_short, settle_part, settle_near, divide_anew, division_text, &
    join_model, look_at_all, migrate_points, unevenness, ring_of, rows_of

contains

  !> Divide a whole model.
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

  !> There are fewer cells with material than a team must have.
  subroutine refuse_short(ranks, error)
    integer, intent(in) :: ranks
    type(error_type), allocatable, intent(out) :: error

    call fail(error, error_deck, 'the material occupies too few cells of the mesh to be divided among '// &
      integer_text(ranks)//' processes')
  end subroutine refuse_short

  !> A whole model is that of a team, which has not shared it yet.
  subroutine enter_team(model, team)
    type(model_type), intent(inout) :: model
    type(team_type), intent(in) :: team

    if (is_divided(model%part)) return
    model%part%team = team
    model%part%ring = ring_of(model%analysis)
    model%part%history_number = numbers_of(model)
    ! Points that carry tractions are known by their numbers while the model is divided.
    if (allocated(model%carrying_point)) model%carrying_point = int(model%state%points%number(model%carrying_point))
  end subroutine enter_team

  !> Keep the part of a model that is this process's, the owners of the cells being known.
  subroutine settle_part(model)
    !> Its points are those of the whole model, or some that hold all that are near.
    type(model_type), intent(inout) :: model

    call number_all(model, model%state%window, whole_of(model))
    call settle_near(model)
  end subroutine settle_part

  !> The same with the cells numbered as in the whole mesh.
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

  !> Divide a model that is divided in another way, by its points as they lie now: they go to their new processes.
  subroutine divide_anew(model, error)
    type(model_type), intent(inout) :: model
    !> error_other: points were lost or doubled.
    type(error_type), allocatable, intent(out) :: error
    class(cell_owners_type), allocatable :: owners
    integer, allocatable :: labels(:)
    real(wp), allocatable :: forces(:, :)
    integer(long) :: before(census_size)
    logical :: short

    before = census(model)
    call share_model(model, model%part%team%ranks, rows_of(model%analysis), owners, short)
    ! As few cells as that are shared as they were.
    if (short) return
    call collect_forces(model, labels, forces)
    call move_alloc(owners, model%part%owners)
    call reset_copies(model%part)
    call send_all(model, .false.)
    call look_at(model, .true.)
    model%state%reactions = 0.0_wp
    model%state%released = 0.0_wp
    call put_forces(model, labels, forces)
    if (any(census(model) /= before)) call fail(error, error_other, lost)
  end subroutine divide_anew

  !> Find the owners of the cells. A mesh that is shared in parts is looked at whole.
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

  !> Keep what is own or in the ring of this process, and put aside what waits; cells are numbered as in the whole mesh.
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

  !> Rows of cells around own ones whose points an own function sees: half the cells that it reaches over, and one more
  !> where points have domains. All else that depends on cells around is told by their owners (qsmpm_ring_exchange), but
  !> for this: a surface point that has left the cells with material goes with the nearest point, one cell further than
  !> surface points are copied, and material that is taken out with the nodes of cells that functions of others see.
  !> Patches of contact join their neighbours, and these theirs; one on a body that acts on own nodes, which functions
  !> let it do from their degree of cells and one away, is to be had whole, with the soil around it. Cells of elements
  !> but QUAD4 and HEX8 may share a pressure or the gradients at their nodes.
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

  !> Rows of cells around its own that a process is asked for.
  pure integer function rows_of(analysis) result(rows)
    type(analysis_type), intent(in) :: analysis

    rows = ring_of(analysis) + rows_beyond
  end function rows_of

  !> Points go to the processes whose own they are now, and copies to those whose rings they are in.
  subroutine migrate_points(model, error)
    type(model_type), intent(inout) :: model
    !> error_other, on all processes alike: points were lost or doubled, or places have left the material that is near.
    type(error_type), allocatable, intent(out) :: error
    integer(long) :: before(census_size)

    if (.not. is_divided(model%part)) return
    before = census(model)
    call send_all(model, .false.)
    associate (state => model%state, inactive => model%state%inactive)
      ! A process without material cannot tell how surface points of others move.
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

  !> Send own points and what this process knows of other places; cells are numbered as in the whole mesh afterwards.
  subroutine send_all(model, everywhere)
    type(model_type), intent(inout) :: model
    !> Every process gets all.
    logical, intent(in) :: everywhere

    call number_all(model, model%state%window, whole_of(model))
    associate (part => model%part, state => model%state, inactive => model%state%inactive)
      ! Surface points are copied from a row less: the nearest material point to one is looked for
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

  !> Whether something that this process is to move lies outside of the part of the grid that it looks at.
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

  !> The whole model on every process again.
  subroutine join_model(model, error)
    type(model_type), intent(inout) :: model
    type(error_type), allocatable, intent(out) :: error
    type(own_part_type) :: alone
    integer, allocatable :: labels(:)
    real(wp), allocatable :: forces(:, :)
    integer(long) :: before(census_size)

    if (.not. is_divided(model%part)) return
    before = census(model)
    call collect_forces(model, labels, forces)
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
    call put_forces(model, labels, forces)
  end subroutine join_model

  !> Look at the part of a grid in which the points and places of all processes are; no forces are there yet, nor what
  !> is kept at nodes. Cells are numbered as in the whole grid before, as in the window afterwards.
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

  !> Points that carry tractions are known by their places in the whole model again, whose points are sorted by number.
  pure subroutine carry_by_place(model)
    type(model_type), intent(inout) :: model
    integer :: i

    if (.not. allocated(model%carrying_point)) return
    do i = 1, size(model%carrying_point)
      model%carrying_point(i) = place_in_order(int(model%state%points%number), model%carrying_point(i))
    end do
  end subroutine carry_by_place

  !> How the points are shared, for the log.
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

    !> With two digits behind the point.
    function two_digits(x) result(text)
      real(wp), intent(in) :: x
      character(len=:), allocatable :: text

      text = real_text(real(nint(100.0_wp*x), wp)/100.0_wp)
    end function two_digits
  end function division_text

  !> Own points of the process that has most of them, over the mean; 1 for a model that is whole.
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

  !> Own material points, those that are taken out, and surface points of all processes: how many, the sums of their
  !> numbers, and what they carry.
  function census(model) result(sums)
    type(model_type), intent(in) :: model
    integer(long) :: sums(census_size)

    associate (part => model%part, state => model%state)
      sums = [counts(state%points, part%points), counts(state%inactive%unloading, part%unloading), &
        counts(state%surface, part%surface)]
    end associate

  contains

    !> Those of one set.
    function counts(carried, marks)
      class(carried_type), intent(in) :: carried
      !> Which of them are own; unallocated where all are.
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

  !> Cells that material and surface points are in, those that are taken out too, by their places in the whole grid.
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

  !> Add the cells near the own box that bodies may hold which are integrated inside of their outlines: those between
  !> their vertices. They may hold a part of a body and no point.
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

  !> A window with the margin that is usual.
  pure type(window_type) function with_margin(model, used) result(window)
    type(model_type), intent(in) :: model
    type(window_type), intent(in) :: used

    window = widen(used, usual_margin(model%analysis, used%last - used%first + 1), whole_of(model))
  end function with_margin

  !> Look at the part of a grid in which the points are, and mark what is own. Cells are numbered as in the whole grid
  !> before, as in the window afterwards.
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

  !> Lay the window around the points where it is another one; a process without points keeps its own. The reactions of
  !> the step that has moved them act where they were, and stay in it.
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

  !> Add the cells around the nodes at which there are forces to a window.
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

  !> Reactions and released forces at the own nodes of all processes, where there are any.
  subroutine collect_forces(model, labels, forces)
    type(model_type), intent(in) :: model
    !> Labels of the nodes, and their forces (2 dimension, nodes).
    integer, allocatable, intent(out) :: labels(:)
    real(wp), allocatable, intent(out) :: forces(:, :)
    integer(long), allocatable :: got_labels(:)
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
      ! The same to every process.
      call hand_over(part%team, [((int(node_label(model%space, model%mesh, chosen(i)), long), i=1, n), &
        r=1, part%team%ranks)], [(1 + n*r, r=0, part%team%ranks)], got_labels, first)
      call hand_over(part%team, [(table, r=1, part%team%ranks)], [(1 + 2*d*n*r, r=0, part%team%ranks)], got, first)
    end associate
    labels = int(got_labels)
    forces = reshape(got, [2*d, size(labels)])
  end subroutine collect_forces

  !> Put them at the nodes of the window.
  pure subroutine put_forces(model, labels, forces)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: labels(:)
    !> (2 dimension, labels)
    real(wp), intent(in) :: forces(:, :)
    integer :: order(size(labels)), sorted(size(labels)), a, d, k

    d = size(model%state%reactions, 1)
    call order_columns(reshape(labels, [1, size(labels)]), order)
    sorted = labels(order)
    do a = 1, model%space%node_count
      k = place_in_order(sorted, node_label(model%space, model%mesh, a))
      if (k == 0) cycle
      model%state%reactions(:, a) = forces(:d, order(k))
      model%state%released(:, a) = forces(d + 1:, order(k))
    end do
  end subroutine put_forces
end module qsmpm_division
