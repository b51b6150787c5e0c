!> Activation, deactivation and change of material of bodies at the start of a phase (*ACTIVATE, *DEACTIVATE, *CHANGE
!> MATERIAL): their points are exchanged between the active and the inactive points (qsmpm_inactive_points).
!> docs/methods/stages.md.
!>
!> A deactivated body keeps its stress and weight and is unloaded over the phase (qsmpm_unloading). An activated body
!> has no stress and no strain, and its weight increases over the phase; the first time it is stretched down to the
!> ground as it has settled, later it is placed where it has moved to. With another material the stress is retained and
!> the law starts from it.
!>
!> The module also sets up the feet of the initially inactive bodies (qsmpm_inactive_points), one for every vertical
!> line with points, surface points or tracers of such a body, and finds the bodies to which tracers belong. Both are
!> found from the geometry defined in the deck when the model is created.
module qsmpm_body_stages
  use qsmpm_kinds, only: wp, long
  use qsmpm_material_description, only: weight_at
  use qsmpm_named, only: place_named
  use qsmpm_active_bodies, only: bodies_named, body_number, has_stages, bodies_active
  use qsmpm_body_description, only: body_change_type
  use qsmpm_mesh_description, only: select_outline
  use qsmpm_method_description, only: basis_fem
  use qsmpm_body_placing, only: place_body, move_their_nodes
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_inactive_points, only: allocate_inactive
  use qsmpm_law, only: law_type
  use qsmpm_load_path, only: between
  use qsmpm_model, only: model_type, progress_type
  use qsmpm_model_surfaces, only: choose_carrying_points
  use qsmpm_point_selection, only: select_points, append_points, move_points
  use qsmpm_own_part, only: is_divided
  use qsmpm_points, only: points_type, surface_points_type, place_of, allocate_carried, nearest_point
  use qsmpm_undrained_law, only: excess_pressure_name
  use qsmpm_mesh_search, only: locate, inverse_map
  use qsmpm_own_marks, only: nearest_numbers, place_of_number
  use qsmpm_overburden, only: overburden_type, make_overburden
  use qsmpm_vertical, only: vertical_of
  use qsmpm_polyhedron, only: find_crossings
  use qsmpm_sorting, only: order_columns
  use qsmpm_team, only: total
  implicit none
  private

  public :: part_bodies, change_bodies, link_points, body_to_follow

  !> Excess pore pressure relative to the stress below which soil is at rest.
  real(wp), parameter :: rounding = 1.0e-6_wp

  !> Distance in cells below which lines are identical, and below which boundaries of bodies touch.
  real(wp), parameter :: same_line = 1.0e-4_wp, touching = 1.0e-3_wp
  !> Relative distance by which the outermost lines of a body are moved towards its centre, and a z coordinate between
  !> the end faces of a plane body that is on no edge of their triangles.
  real(wp), parameter :: inwards = 1.0e-6_wp, between_caps = 0.0123_wp

contains

  !> Separates the bodies that are not active at the start.
  subroutine part_bodies(model)
    !> The model as created, with all bodies.
    type(model_type), intent(inout) :: model

    call allocate_inactive(model%state%inactive, model%mesh%dimension)
    model%state%points%start_weight = model%state%points%weight
    if (model%analysis%method%basis == basis_fem .and. .not. allocated(model%drawn_coordinates)) &
      allocate (model%drawn_coordinates, source=model%mesh%coordinates)
    if (.not. has_stages(model%analysis)) return
    model%history_number = model%history_point
    if (is_divided(model%part)) model%history_number = int(model%part%history_number)
    call find_surface_bodies(model)
    call find_tracer_bodies(model)
    call plant_feet(model)
    associate (waits => .not. model%analysis%bodies%active)
      call move_points(waits(model%state%points%body), model%state%points, model%state%inactive%points)
      call move_points(waits(model%state%surface%body), model%state%surface, model%state%inactive%surface)
    end associate
    call link_points(model)
  end subroutine part_bodies

  !> Finds the body of every surface point: that of the outline, otherwise that of the nearest initially active point.
  subroutine find_surface_bodies(model)
    type(model_type), intent(inout) :: model
    type(points_type) :: there
    integer :: i

    associate (points => model%state%points, bodies => model%analysis%bodies)
      call select_points(points, pack([(i, i=1, points%count)], [(bodies(points%body(i))%active, i=1, points%count)]), &
        there)
    end associate
    associate (surface => model%state%surface)
      do i = 1, surface%count
        associate (drawn => model%analysis%surfaces(surface%surface(i)))
          if (drawn%selection == select_outline) then
            surface%body(i) = body_number(model%analysis, drawn%body)
          else
            surface%body(i) = there%body(nearest_point(there, surface%position(:, i)))
          end if
        end associate
      end do
    end associate
  end subroutine find_surface_bodies

  !> Applies the changes of bodies in the present phase; the load fraction is still that reached by the previous phase.
  !> Nothing is done twice when the phase is started again.
  subroutine change_bodies(model, notes, error)
    type(model_type), intent(inout) :: model
    !> Messages for the log.
    character(len=:), allocatable, intent(out) :: notes
    !> A body overlaps the ground, is outside the mesh, or has excess pore pressure that its new material cannot store.
    type(error_type), allocatable, intent(out) :: error
    logical, dimension(size(model%analysis%bodies)) :: going, coming
    integer :: i

    notes = ''
    ! Weights at the start of the phase are those reached by the previous phase.
    associate (points => model%state%points)
      points%start_weight = between(points%start_weight, points%weight, 1.0_wp - left_of(model%state%progress))
    end associate
    if (.not. has_stages(model%analysis)) return
    associate (phase => model%analysis%phases(model%state%progress%phase), inactive => model%state%inactive)
      going = bodies_named(model%analysis, phase%deactivations)
      coming = bodies_named(model%analysis, phase%activations)
      call end_unloading(model, .not. going)
      call move_points(going(model%state%points%body), model%state%points, inactive%unloading)
      call move_points(going(model%state%surface%body), model%state%surface, inactive%unloading_surface)
      if (model%analysis%method%basis == basis_fem .and. any(coming)) call move_their_nodes(model, error)
      if (allocated(error)) return
      do i = 1, size(phase%activations)
        call bring(model, phase%activations(i), notes, error)
        if (allocated(error)) return
      end do
      do i = 1, size(phase%materials)
        call change_material(model, phase%materials(i), notes, error)
        if (allocated(error)) return
      end do
      if (.not. (any(going) .or. any(coming))) return
      ! Forces of an embedding program on the points are discarded, because the points have changed.
      if (allocated(model%loading%point_force)) deallocate (model%loading%point_force)
      call link_points(model)
    end associate
  end subroutine change_bodies

  !> Returns the share of its changes that the previous phase has not applied, where it has ended early.
  pure real(wp) function left_of(progress)
    type(progress_type), intent(in) :: progress

    left_of = max(1.0_wp - progress%fraction, progress%release_left)
  end function left_of

  !> Moves bodies that the previous phase has unloaded to the inactive points; the stress and weight that remain after a
  !> phase ended early continue to be reduced.
  subroutine end_unloading(model, chosen)
    type(model_type), intent(inout) :: model
    !> (bodies)
    logical, intent(in) :: chosen(:)
    real(wp) :: left

    left = left_of(model%state%progress)
    associate (inactive => model%state%inactive)
      if (left > 0.0_wp) then
        inactive%unloading%stress = left*inactive%unloading%stress
        inactive%unloading%start_weight = left*inactive%unloading%start_weight
        inactive%unloading_surface%area = left*inactive%unloading_surface%area
        inactive%unloading_surface%area_vector = left*inactive%unloading_surface%area_vector
        inactive%unloading_surface%reaction = left*inactive%unloading_surface%reaction
      else
        call move_points(chosen(inactive%unloading%body), inactive%unloading, inactive%points)
        call move_points(chosen(inactive%unloading_surface%body), inactive%unloading_surface, inactive%surface)
      end if
    end associate
  end subroutine end_unloading

  !> Places a body, taken from the inactive points.
  subroutine bring(model, change, notes, error)
    type(model_type), intent(inout) :: model
    type(body_change_type), intent(in) :: change
    !> Messages for the log, to which one is added.
    character(len=:), allocatable, intent(inout) :: notes
    type(error_type), allocatable, intent(out) :: error
    type(points_type) :: body
    type(surface_points_type) :: surface
    logical :: chosen(size(model%analysis%bodies))

    chosen = .false.
    chosen(body_number(model%analysis, change%body)) = .true.
    call select_points(model%state%points, [integer ::], body)
    call select_points(model%state%surface, [integer ::], surface)
    call move_points(chosen(model%state%inactive%points%body), model%state%inactive%points, body)
    call move_points(chosen(model%state%inactive%surface%body), model%state%inactive%surface, surface)
    if (body%count == 0) return
    call place_body(model, change, body, surface, notes, error)
    if (allocated(error)) return
    call append_points(body, model%state%points)
    call append_points(surface, model%state%surface)
  end subroutine bring

  !> Changes the material of a body. The excess pore pressure of undrained soil is retained; other state variables of a
  !> law are initialised from the stress, which is reported.
  subroutine change_material(model, change, notes, error)
    type(model_type), intent(inout) :: model
    type(body_change_type), intent(in) :: change
    !> Messages for the log.
    character(len=:), allocatable, intent(inout) :: notes
    !> The new material cannot store an existing excess pore pressure.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: excess, effective(size(model%state%points%stress, 1)), weight(2)
    integer :: b, m, p, before, behind
    logical :: forgets

    b = body_number(model%analysis, change%body)
    m = place_named(model%analysis%materials, change%material)
    forgets = .false.
    associate (points => model%state%points, materials => model%analysis%materials, law => model%laws(m)%law)
      behind = law%state_place(excess_pressure_name)
      do p = 1, points%count
        if (points%body(p) /= b .or. points%material(p) == m) cycle
        weight = [weight_at(materials(points%material(p)), points%initial_position(:, p)), &
          weight_at(materials(m), points%initial_position(:, p))]
        if (weight(1) > 0.0_wp) then
          points%weight(p) = points%weight(p)*weight(2)/weight(1)
        else
          points%weight(p) = weight(2)*points%volume(p)
        end if
        before = model%laws(points%material(p))%law%state_place(excess_pressure_name)
        forgets = forgets .or. is_forgotten(model%laws(points%material(p))%law, law)
        excess = 0.0_wp
        if (before > 0) excess = points%state(before, p)
        if (behind == 0 .and. abs(excess) > rounding*maxval(abs(points%stress(:, p)))) then
          call fail(error, error_other, "*CHANGE MATERIAL: body '"//change%body//"' has excess pore pressure, "// &
            "which the drained material '"//change%material//"' cannot carry: dissipate it by *DRAIN STATE in "// &
            'an earlier phase, or give the material *UNDRAINED')
          return
        end if
        points%material(p) = m
        points%plastic(p) = 0
        ! The strain to which the law relates the stress is measured from here.
        points%initial_volume(p) = points%volume(p)
        effective = points%stress(:, p)
        effective(:3) = effective(:3) + excess
        call law%start_at(effective, place_of(points, p), points%state(:law%state_count, p))
        if (behind > 0) points%state(behind, p) = excess
      end do
    end associate
    if (forgets) notes = notes//"warning: *CHANGE MATERIAL: the law of '"//change%material//"' starts again from "// &
      "the stress of body '"//change%body//"': its state variables (preconsolidation, hardening, softening) are "// &
      'those that the material defines'//new_line('a')
  end subroutine change_material

  !> Returns whether state variables of a law are lost that the next law initialises.
  pure logical function is_forgotten(before, behind)
    class(law_type), intent(in) :: before, behind
    integer :: i

    is_forgotten = .false.
    if (.not. allocated(before%state_names)) return
    do i = 1, before%state_count
      if (before%state_names(i)%text == excess_pressure_name .or. len(before%state_names(i)%text) == 0) cycle
      is_forgotten = is_forgotten .or. behind%state_place(before%state_names(i)%text) > 0
    end do
  end function is_forgotten

  !> Finds the points of histories, and of the sketches of loads, among the active points.
  subroutine link_points(model)
    type(model_type), intent(inout) :: model
    integer :: i

    if (.not. allocated(model%history_number) .or. is_divided(model%part)) return
    model%history_point = model%history_number
    ! A restored state may precede phases with changes of bodies: its points are then those at the start.
    if (has_stages(model%analysis)) then
      do i = 1, size(model%history_point)
        if (model%history_number(i) > 0) &
          model%history_point(i) = findloc(model%state%points%number, model%history_number(i), dim=1)
      end do
    end if
    call choose_carrying_points(model)
  end subroutine link_points

  !> Sets up all bodies for intersection with vertical lines; their weight is not used.
  pure subroutine see_bodies(model, seen)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(out) :: seen
    real(wp) :: nothing(size(model%shapes))

    nothing = 0.0_wp
    call make_overburden(model%mesh, model%shapes, nothing, vertical_of(model%analysis), seen)
  end subroutine see_bodies

  !> Finds the heights at which the vertical line through a place, moved by `inwards`, intersects the boundary of a
  !> body.
  pure subroutine heights_of(seen, body, place, heights, side)
    type(overburden_type), intent(in) :: seen
    integer, intent(in) :: body
    !> (dimension)
    real(wp), intent(in) :: place(:)
    real(wp), allocatable, intent(out) :: heights(:)
    !> Direction of this shift, -1 or 1; towards the centre of the body when absent.
    integer, intent(in), optional :: side
    logical, allocatable :: looks_up(:)
    real(wp) :: x(3), line(2)

    x = between_caps
    x(:size(place)) = place
    line = x([mod(seen%axis, 3) + 1, mod(seen%axis + 1, 3) + 1])
    associate (solid => seen%solid(body))
      if (present(side)) then
        line = line + side*inwards*(solid%high(:2) - solid%low(:2))
      else
        line = line + inwards*(0.5_wp*(solid%low(:2) + solid%high(:2)) - line)
      end if
      call find_crossings(solid, line, heights, looks_up)
    end associate
  end subroutine heights_of

  !> Returns whether a body, intersected at some heights, contains another height or ends there.
  pure logical function reaches(heights, height, slack)
    real(wp), intent(in) :: heights(:), height, slack

    reaches = any(abs(heights - height) <= slack) .or. mod(count(heights < height), 2) == 1
  end function reaches

  !> Finds the body of every tracer: that of its outline, otherwise the one that a history at its place follows,
  !> otherwise that of the nearest point.
  subroutine find_tracer_bodies(model)
    type(model_type), intent(inout) :: model
    type(overburden_type) :: seen
    integer :: i, k

    allocate (model%tracer_body(model%state%tracers%count), model%tracer_foot(model%state%tracers%count), source=0)
    do k = 1, size(model%outlines)
      associate (outline => model%outlines(k))
        model%tracer_body(outline%before + 1:outline%before + outline%count) = outline%body
      end associate
    end do
    call see_bodies(model, seen)
    do i = 1, model%state%tracers%count
      if (model%tracer_body(i) == 0) model%tracer_body(i) = longest_there(model, seen, &
        model%state%tracers%position(:, i))
      if (model%tracer_body(i) == 0) model%tracer_body(i) = nearest_body(model, model%state%tracers%position(:, i))
    end do
  end subroutine find_tracer_bodies

  !> Returns the body that a history at a place follows where bodies are activated or deactivated; 0 for any: none
  !> contains the place, or there are no such changes.
  pure integer function body_to_follow(model, place) result(body)
    type(model_type), intent(in) :: model
    !> (dimension)
    real(wp), intent(in) :: place(:)
    type(overburden_type) :: seen

    body = 0
    if (.not. has_stages(model%analysis)) return
    call see_bodies(model, seen)
    body = longest_there(model, seen, place)
  end function body_to_follow

  !> Returns, of the bodies that contain a place or end there, the one that is active in most phases, including the
  !> start; 0 where none contains it.
  pure integer function longest_there(model, seen, place) result(body)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: seen
    !> (dimension)
    real(wp), intent(in) :: place(:)
    integer :: phases(size(model%shapes)), most, p, b

    phases = 0
    do p = 0, size(model%analysis%phases)
      phases = phases + merge(1, 0, bodies_active(model%analysis, p))
    end do
    body = 0
    most = -1
    do b = 1, size(phases)
      if (phases(b) <= most) cycle
      if (.not. holds(seen, b, place, touching*model%cell_size)) cycle
      body = b
      most = phases(b)
    end do
  end function longest_there

  !> Returns whether a body contains a place or ends there: on a vertical face its inner side is checked, in either
  !> direction.
  pure logical function holds(seen, body, place, slack)
    type(overburden_type), intent(in) :: seen
    integer, intent(in) :: body
    !> (dimension)
    real(wp), intent(in) :: place(:)
    real(wp), intent(in) :: slack
    real(wp), allocatable :: heights(:)
    integer :: side

    call heights_of(seen, body, place, heights)
    holds = reaches(heights, place(seen%axis), slack)
    do side = -1, 1, 2
      if (holds) return
      call heights_of(seen, body, place, heights, side)
      holds = reaches(heights, place(seen%axis), slack)
    end do
  end function holds

  !> Returns the body of the material point nearest to a place.
  integer function nearest_body(model, place) result(body)
    type(model_type), intent(in) :: model
    !> (dimension)
    real(wp), intent(in) :: place(:)
    integer(long) :: number(1)
    integer :: p

    number = nearest_numbers(model, reshape(place, [size(place), 1]))
    p = place_of_number(model, number(1))
    body = 0
    if (p > 0) body = model%state%points%body(p)
    body = int(total(model%part%team, int(body, long)))
  end function nearest_body

  !> Sets up the feet under points, surface points and tracers of the bodies that are not active at the start.
  subroutine plant_feet(model)
    type(model_type), intent(inout) :: model
    integer, allocatable :: line(:, :), foot(:)
    real(wp), allocatable :: places(:, :)
    integer :: n, s, t

    associate (points => model%state%points, surface => model%state%surface, tracers => model%state%tracers)
      n = points%count
      s = surface%count
      t = tracers%count
      allocate (places(model%mesh%dimension, n + s + t), line(3, n + s + t))
      places(:, :n) = points%position
      places(:, n + 1:n + s) = surface%position
      places(:, n + s + 1:) = tracers%position
      line(1, :) = [points%body, surface%body, model%tracer_body]
      call number_lines(model, places, line)
      call set_feet(model, places, line, foot)
      points%foot = foot(:n)
      surface%foot = foot(n + 1:n + s)
      model%tracer_foot = foot(n + s + 1:)
    end associate
  end subroutine plant_feet

  !> Assigns integers to the horizontal coordinates: places on one line have the same.
  pure subroutine number_lines(model, places, line)
    type(model_type), intent(in) :: model
    !> (dimension, n)
    real(wp), intent(in) :: places(:, :)
    !> Body of each place on entry; the two coordinates are added (3, n).
    integer, intent(inout) :: line(:, :)
    integer :: a, k

    line(2:, :) = 0
    k = 1
    do a = 1, size(places, 1)
      if (a == vertical_of(model%analysis)) cycle
      k = k + 1
      line(k, :) = nint((places(a, :) - model%mesh%bounds(a, 1))/(same_line*model%cell_size))
    end do
  end subroutine number_lines

  !> Sets a foot for every line of an initially inactive body.
  subroutine set_feet(model, places, line, foot)
    type(model_type), intent(inout) :: model
    !> (dimension, n)
    real(wp), intent(in) :: places(:, :)
    !> Body and line of each place (3, n).
    integer, intent(in) :: line(:, :)
    !> Foot of each place (n).
    integer, allocatable, intent(out) :: foot(:)
    type(overburden_type) :: seen
    real(wp), allocatable :: heights(:), bottom(:), top(:), at(:, :)
    integer, allocatable :: order(:), body(:)
    integer :: i, k, n

    call see_bodies(model, seen)
    allocate (order(size(line, 2)), bottom(size(line, 2)), top(size(line, 2)), body(size(line, 2)))
    allocate (foot(size(line, 2)), source=0)
    allocate (at, mold=places)
    call order_columns(line, order)
    n = 0
    do i = 1, size(order)
      k = order(i)
      if (model%analysis%bodies(line(1, k))%active) cycle
      if (n > 0) then
        if (all(line(:, k) == line(:, order(i - 1))) .and. foot(order(i - 1)) > 0) then
          foot(k) = n
          cycle
        end if
      end if
      call heights_of(seen, line(1, k), places(:, k), heights)
      if (size(heights) < 2) cycle
      n = n + 1
      foot(k) = n
      body(n) = line(1, k)
      bottom(n) = minval(heights)
      top(n) = maxval(heights)
      at(:, n) = places(:, k)
      at(seen%axis, n) = bottom(n)
    end do
    model%feet%axis = seen%axis
    model%feet%body = body(:n)
    model%feet%bottom = bottom(:n)
    model%feet%top = top(:n)
    call put_on_ground(model, seen, at(:, :n))
  end subroutine set_feet

  !> Finds the cells of the feet, which are those of the ground below them, and the bodies on which they rest.
  subroutine put_on_ground(model, seen, places)
    type(model_type), intent(inout) :: model
    type(overburden_type), intent(in) :: seen
    !> (dimension, feet)
    real(wp), intent(in) :: places(:, :)
    real(wp) :: below(size(places, 1))
    real(wp), allocatable :: heights(:)
    logical :: found
    integer :: i, b

    deallocate (model%state%inactive%feet%position, model%state%inactive%feet%initial_position, &
      model%state%inactive%feet%local, model%state%inactive%feet%cell, model%state%inactive%feet%number)
    call allocate_carried(model%state%inactive%feet, size(places, 1), size(places, 2))
    allocate (model%feet%on(size(model%shapes), size(places, 2)), source=.false.)
    associate (feet => model%state%inactive%feet)
      feet%position = places
      feet%initial_position = places
      do i = 1, feet%count
        below = places(:, i)
        below(seen%axis) = below(seen%axis) - touching*model%cell_size
        feet%cell(i) = model%state%points%cell(1)
        call locate(model%mesh, below, feet%cell(i), feet%local(:, i), found)
        if (.not. found) call locate(model%mesh, places(:, i), feet%cell(i), feet%local(:, i), found)
        if (found) call inverse_map(model%mesh, feet%cell(i), places(:, i), feet%local(:, i), found)
        do b = 1, size(model%shapes)
          if (b == model%feet%body(i)) cycle
          call heights_of(seen, b, places(:, i), heights)
          model%feet%on(b, i) = mod(count(heights < below(seen%axis)), 2) == 1
        end do
      end do
    end associate
  end subroutine put_on_ground
end module qsmpm_body_stages
