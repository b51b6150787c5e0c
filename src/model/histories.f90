!> Histories: the quantities requested for the columns of curves.csv and their locations: a massless tracer for each
!> displacement or position, the nearest material point for each stress, strain and state variable.
module qsmpm_histories
  use qsmpm_kinds, only: wp, long
  use qsmpm_named, only: place_named
  use qsmpm_phase_tree, only: time_in_phase, parent_of
  use qsmpm_own_part, only: is_divided, own_of
  use qsmpm_team, only: largest, total, smallest, spread_from
  use qsmpm_analysis, only: plane_strain
  use qsmpm_history_description, only: history_type, quantity_displacement, quantity_position, quantity_stress, &
    quantity_reaction, quantity_state, quantity_strain, quantity_volume, quantity_runout, quantity_pore_pressure, &
    quantity_contact_force, quantity_contact_moment, quantity_body_move, quantity_body_rotation, &
    quantity_contact_pressure, quantity_contact_slip, quantity_prop_force, quantity_time, quantity_excess_pressure, &
    quantity_discharge
  use qsmpm_history_quantities, only: history_quantities, is_taken_at, at_point, at_tracer
  use qsmpm_model, only: model_type
  use qsmpm_mesh_sets, only: items_of
  use qsmpm_consolidation, only: excess_pressure
  use qsmpm_contact_results, only: contact_pressure_at, contact_slip_on
  use qsmpm_pore_water, only: discharge_in, has_inflow, has_pore_pressure
  use qsmpm_props, only: prop_force
  use qsmpm_rigid_bodies, only: force_on_body, pose_of
  use qsmpm_rigid_pose, only: rigid_pose_type
  use qsmpm_smooth_stress, only: patches_type, smooth_stress_type, make_patches, fit_smooth_stress, smooth_stress_at
  use qsmpm_isotropic_function, only: logarithmic_strain
  use qsmpm_source_line, only: source_line_type
  use qsmpm_agreement, only: lowest_rank
  use qsmpm_active_bodies, only: bodies_active
  use qsmpm_body_stages, only: body_to_follow
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic, where_text
  use qsmpm_own_marks, only: nearest_numbers, place_of_number
  use qsmpm_phase_loads, only: has_consolidation, prop_stage, prop_stage_type
  use qsmpm_points, only: allocate_carried
  use qsmpm_mesh_measure, only: cell_width, place_in_cell
  use qsmpm_mesh_search, only: inverse_map
  use qsmpm_structures, only: prop_type
  use qsmpm_element, only: face_count, inside_distance, local_centre, max_faces
  use qsmpm_mesh, only: mesh_type
  use qsmpm_seed_table, only: seed_table_type
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_text, only: upper
  implicit none
  private

  public :: take_histories, make_histories

  !> Fraction of its length within which a body touches the side of the mesh.
  real(wp), parameter :: on_side = 1.0e-3_wp
  !> A location outside the soil by rounding is moved to its surface, up to these fractions of a cell.
  real(wp), parameter :: on_face = 1.0e-6_wp, near = 0.05_wp

contains

  !> Returns the values of all histories in the order of the deck.
  subroutine take_histories(model, values)
    type(model_type), intent(in) :: model
    real(wp), allocatable, intent(out) :: values(:)
    integer :: i

    allocate (values(size(model%analysis%histories)))
    do i = 1, size(values)
      values(i) = model%analysis%histories(i)%scale*total(model%part%team, history_value(model, i))
    end do
  end subroutine take_histories

  !> Returns a history before scaling; in a model shared by a team the contribution of this process, which is summed
  !> over the processes.
  real(wp) function history_value(model, i) result(value)
    type(model_type), intent(in) :: model
    integer, intent(in) :: i
    real(wp), dimension(size(model%state%points%stress, 1)) :: strain, stress
    integer :: place

    value = 0.0_wp
    place = model%history_tracer(i)
    associate (history => model%analysis%histories(i), tracers => model%state%tracers)
      ! The point may belong to an inactive body.
      if (is_taken_at(history%quantity, at_point) .and. model%history_point(i) == 0) return
      if (is_divided(model%part) .and. history_quantities(history%quantity)%known_to_all .and. &
        model%part%team%rank > 0) return
      select case (history%quantity)
      case (quantity_displacement)
        value = tracers%position(history%component, place) - tracers%initial_position(history%component, place)
      case (quantity_position)
        value = tracers%position(history%component, place)
      case (quantity_stress)
        stress = smooth_in_pressure(model, model%history_point(i))
        value = stress(history%component)
      case (quantity_state)
        value = model%state%points%state(model%history_state(i), model%history_point(i))
      case (quantity_strain)
        strain = logarithmic_strain(model%state%points%left_cauchy_green(:, model%history_point(i)))
        value = strain(history%component)
      case (quantity_pore_pressure)
        value = model%state%points%pore_pressure(model%history_point(i))
      case (quantity_reaction)
        value = reaction_of(model, history)
      case (quantity_volume)
        value = sum(model%state%points%volume, mask=is_of_body(model, history) .and. &
          own_of(model%part%points, model%state%points%count))
      case (quantity_runout)
        value = runout_of(model, history)
        if (model%part%team%rank > 0) value = 0.0_wp
      case (quantity_contact_force, quantity_contact_moment, quantity_body_move, quantity_body_rotation)
        value = rigid_body_value(model, history)
      case (quantity_time)
        value = time_in_phase(model%analysis%phases, model%state%progress%phase, model%state%progress%fraction)
      case (quantity_excess_pressure)
        value = max(0.0_wp, maxval(abs(excess_pressure(model))))
      case (quantity_discharge)
        value = discharge_in(model%analysis, model%state%progress%phase, history%set//history%surface)
      case (quantity_prop_force)
        value = prop_force(model, history%prop)
      case (quantity_contact_slip)
        value = contact_slip_on(model, place_named(model%analysis%rigid_bodies, history%body), history%mean)
        if (model%part%team%rank > 0) value = 0.0_wp
      case (quantity_contact_pressure)
        value = contact_pressure_at(model, history%at(:model%mesh%dimension))
        if (model%part%team%rank > 0) value = 0.0_wp
      end select
    end associate
  end function history_value

  !> Returns a quantity of a rigid body.
  pure real(wp) function rigid_body_value(model, history) result(value)
    type(model_type), intent(in) :: model
    type(history_type), intent(in) :: history
    type(rigid_pose_type) :: pose
    real(wp) :: force(6)
    integer :: b

    b = place_named(model%analysis%rigid_bodies, history%body)
    force = force_on_body(model, b)
    pose = pose_of(model, b)
    select case (history%quantity)
    case (quantity_contact_force)
      value = force(history%component)
    case (quantity_contact_moment)
      value = force(6)
    case (quantity_body_rotation)
      value = pose%rotation(3)*180.0_wp/acos(-1.0_wp)
    case default
      value = pose%displacement(history%component)
    end select
  end function rigid_body_value

  !> Returns the stress of a material point. In cells of uniform pressure, the pressure is taken from the smoothed
  !> stress of the material (qsmpm_smooth_stress), since the pressure of the point is accurate only at the centre of
  !> the cell.
  function smooth_in_pressure(model, point) result(stress)
    type(model_type), intent(in) :: model
    integer, intent(in) :: point
    real(wp) :: stress(size(model%state%points%stress, 1)), smooth(size(model%state%points%stress, 1))
    type(patches_type) :: patches
    type(smooth_stress_type) :: field
    integer, parameter :: linear = 1

    associate (points => model%state%points)
      stress = points%stress(:, point)
      if (.not. model%laws(points%material(point))%pressure_factor > 0.0_wp) return
      call make_patches(model%mesh, points, patches)
      call fit_smooth_stress(model%mesh, model%state%coordinates, patches, points, points%material(point), linear, &
        field)
      call smooth_stress_at(field, model%mesh, points%cell(point), points%local(:, point), points%position(:, point), &
        smooth)
    end associate
    if (model%analysis%model == plane_strain) then
      stress(:2) = stress(:2) + 0.5_wp*sum(smooth(:2) - stress(:2))
      stress(3) = smooth(3)
    else
      stress(:3) = stress(:3) + sum(smooth(:3) - stress(:3))/3.0_wp
    end if
  end function smooth_in_pressure

  !> Returns the sum of the reactions of a node set, or of the support forces of a surface.
  pure real(wp) function reaction_of(model, history) result(value)
    type(model_type), intent(in) :: model
    type(history_type), intent(in) :: history
    integer :: s

    if (len(history%surface) == 0) then
      associate (own => own_of(model%part%nodes, model%space%node_count), &
          items => items_of(model%space%sets, history%set))
        value = sum(model%state%reactions(history%component, items), mask=own(items))
      end associate
      return
    end if
    s = place_named(model%analysis%surfaces, history%surface)
    associate (surface => model%state%surface)
      value = sum(surface%reaction(history%component, :), mask=surface%surface == s .and. &
        own_of(model%part%surface, surface%count))
    end associate
  end function reaction_of

  !> Returns the advance of the front of a body, its outermost material point, since the reset of displacements.
  real(wp) function runout_of(model, history) result(value)
    type(model_type), intent(in) :: model
    type(history_type), intent(in) :: history
    logical :: here(model%state%points%count)
    real(wp) :: sense

    here = is_of_body(model, history) .and. own_of(model%part%points, model%state%points%count)
    sense = merge(-1.0_wp, 1.0_wp, history%smallest)
    associate (points => model%state%points, c => history%component)
      value = largest(model%part%team, maxval(sense*points%position(c, :points%count), mask=here)) &
        - largest(model%part%team, maxval(sense*points%initial_position(c, :points%count), mask=here))
    end associate
  end function runout_of

  !> Returns the points of the body of a history, or of all bodies if it names none.
  pure function is_of_body(model, history) result(here)
    type(model_type), intent(in) :: model
    type(history_type), intent(in) :: history
    logical :: here(model%state%points%count)

    here = len(history%body) == 0 .or. model%state%points%body == place_named(model%analysis%bodies, history%body)
  end function is_of_body

  !> Creates the tracers and selects the points of all histories.
  subroutine make_histories(model, table, diagnostics)
    type(model_type), intent(inout) :: model
    !> Numbers of points of the bodies in the cells.
    type(seed_table_type), intent(in) :: table
    type(diagnostics_type), intent(inout) :: diagnostics
    logical :: traced(size(model%analysis%histories)), occupied(model%mesh%cell_count)
    integer :: i, n, material

    associate (histories => model%analysis%histories)
      traced = is_taken_at(histories%quantity, at_tracer)
      allocate (model%history_tracer(size(histories)), model%history_point(size(histories)), &
        model%history_state(size(histories)), source=0)
      if (is_divided(model%part)) allocate (model%part%history_number(size(histories)), source=0_long)
      occupied = any(table%points > 0, dim=2)
      call allocate_carried(model%state%tracers, model%mesh%dimension, count(traced) &
        + count(.not. model%analysis%props%fixed) + size(model%analysis%props))
      n = 0
      material = 0
      do i = 1, size(histories)
        if (histories(i)%quantity == quantity_reaction .and. len(histories(i)%surface) == 0) then
          if (place_named(model%mesh%node_sets, histories(i)%set) == 0) call add_diagnostic(diagnostics, &
            histories(i)%where, '*HISTORY', "there is no node set '"//histories(i)%set//"'")
        end if
        if (is_taken_at(histories(i)%quantity, at_point)) call pick_point(model, histories(i), i, material)
        if (histories(i)%quantity == quantity_strain .and. .not. model%analysis%output%strains) &
          call add_diagnostic(diagnostics, histories(i)%where, '*HISTORY', 'the material points carry no '// &
          'strains; *FIELD, STRAIN=YES stores them')
        if (histories(i)%quantity == quantity_pore_pressure .and. .not. has_pore_pressure(model)) &
          call add_diagnostic(diagnostics, histories(i)%where, '*HISTORY', 'there is no pore water: the deck '// &
          'has neither *WATER LEVEL nor *UNDRAINED')
        if (histories(i)%quantity == quantity_excess_pressure .and. .not. has_consolidation(model%analysis%phases)) &
          call add_diagnostic(diagnostics, histories(i)%where, '*HISTORY', 'there is no excess pressure field: '// &
          'no phase has *CONSOLIDATION')
        if (histories(i)%quantity == quantity_discharge .and. .not. has_inflow(model%analysis, histories(i)%set// &
          histories(i)%surface)) call add_diagnostic(diagnostics, histories(i)%where, '*HISTORY', 'no *WATER '// &
          "LEVEL, TYPE=SEEPAGE has a level at '"//histories(i)%set//histories(i)%surface//"'")
        if (histories(i)%quantity == quantity_state) call find_state(model, i, material, diagnostics)
        if (histories(i)%quantity == quantity_runout) call check_front(model, histories(i))
        if (.not. traced(i)) cycle
        n = n + 1
        model%history_tracer(i) = n
        call place_tracer(model, histories(i)%at, '*HISTORY', histories(i)%name, histories(i)%where, occupied, n, &
          diagnostics)
        call tell_body(model, histories(i), body_to_follow(model, histories(i)%at(:model%mesh%dimension)))
      end do
    end associate
    call place_props(model, occupied, n, diagnostics)
  end subroutine make_histories

  !> Places the tracers of the ends of props after those of the histories.
  subroutine place_props(model, occupied, before, diagnostics)
    type(model_type), intent(inout) :: model
    !> Cells that hold material (cell_count).
    logical, intent(in) :: occupied(:)
    !> Number of tracers of the histories.
    integer, intent(in) :: before
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: b, e, n

    n = before
    allocate (model%prop_tracer(2, size(model%analysis%props)), source=0)
    do b = 1, size(model%analysis%props)
      associate (prop => model%analysis%props(b))
        do e = 1, merge(1, 2, prop%fixed)
          n = n + 1
          model%prop_tracer(e, b) = n
          call place_tracer(model, prop%places(:, e), '*PROP', prop%name, prop%where, occupied, n, diagnostics)
          call check_seat(model, prop, e, diagnostics)
        end do
      end associate
    end do
  end subroutine place_props

  !> Checks that the end of a prop is supported by active soil in every phase that has the prop.
  subroutine check_seat(model, prop, number, diagnostics)
    type(model_type), intent(in) :: model
    type(prop_type), intent(in) :: prop
    !> Number of the end.
    integer, intent(in) :: number
    type(diagnostics_type), intent(inout) :: diagnostics
    !> Maximum distance, in cell widths, between a location at the edge of the soil and the nearest material point.
    real(wp), parameter :: near = 1.0_wp
    type(prop_stage_type) :: stage
    logical :: active(size(model%analysis%bodies))
    real(wp) :: distance
    integer :: p, i

    do p = 1, size(model%analysis%phases)
      stage = prop_stage(model%analysis%phases, p, prop%name)
      if (.not. stage%there) cycle
      active = bodies_active(model%analysis, p)
      distance = huge(1.0_wp)
      associate (points => model%state%points, x => prop%places(:model%mesh%dimension, number))
        do i = 1, points%count
          if (active(points%body(i))) distance = min(distance, norm2(points%position(:, i) - x) &
            /cell_width(model%mesh, points%cell(i)))
        end do
        distance = smallest(model%part%team, distance)
        if (.not. distance > near) cycle
        call add_diagnostic(diagnostics, prop%where, '*PROP', "'"//prop%name//"' has no ground at its end in "// &
          "phase '"// &
          model%analysis%phases(p)%name//"': the nearest ground is "//rounded_text(distance, 2)//' cells from its '// &
          'end at ('//rounded_text(x(1))//', '//rounded_text(x(2))//')')
        return
      end associate
    end do
  end subroutine check_seat

  !> Finds the state variable of a history among those of the law of its point.
  subroutine find_state(model, number, material, diagnostics)
    type(model_type), intent(inout) :: model
    !> Number of the history, and the material of its point.
    integer, intent(in) :: number, material
    type(diagnostics_type), intent(inout) :: diagnostics
    character(len=:), allocatable :: known, name
    integer :: k

    known = ''
    associate (law => model%laws(material)%law, history => model%analysis%histories(number))
      if (allocated(law%state_names)) then
        do k = 1, law%state_count
          name = law%state_names(k)%text
          if (len(name) == 0) cycle
          known = known//', '//name
          if (is_named(name, history%state)) model%history_state(number) = k
        end do
      end if
      if (model%history_state(number) > 0) return
      if (len(known) == 0) known = ', none'
      call add_diagnostic(diagnostics, history%where, '*HISTORY', "'"//history%state// &
        "' is no state variable of material '"// &
        model%analysis%materials(material)%name//"', whose point is nearest; it has: "//known(3:))
    end associate
  end subroutine find_state

  !> Returns whether a word means a name or the number in it: SDV3_void_ratio is also SDV3 and 3.
  pure logical function is_named(name, word)
    !> Name of a state variable; word of the deck.
    character(len=*), intent(in) :: name, word
    character(len=:), allocatable :: wanted, head

    wanted = upper(word)
    head = upper(name(:scan(name//'_', '_') - 1))
    is_named = upper(name) == wanted .or. (index(head, 'SDV') == 1 .and. (head == wanted .or. head == 'SDV'//wanted))
  end function is_named

  !> Places a tracer in an occupied cell that contains its location, with preference for the cell of the nearest point.
  !> A location slightly outside all cells, such as rounded coordinates of an outline, is moved to the nearest cell.
  subroutine place_tracer(model, at, keyword, name, where, occupied, tracer, diagnostics)
    type(model_type), intent(inout) :: model
    !> The location; the keyword that defines it.
    real(wp), intent(in) :: at(3)
    character(len=*), intent(in) :: keyword, name
    type(source_line_type), intent(in) :: where
    !> Cells that hold material (cell_count).
    logical, intent(in) :: occupied(:)
    integer, intent(in) :: tracer
    type(diagnostics_type), intent(inout) :: diagnostics
    real(wp) :: x(model%mesh%dimension), local(model%mesh%dimension), distance(6), best
    logical :: ok
    integer :: c, n, cell

    x = at(:model%mesh%dimension)
    best = -near
    cell = 0
    do c = 1, model%mesh%cell_count
      if (.not. occupied(c)) cycle
      call inverse_map(model%mesh, c, x, local, ok)
      if (.not. ok) cycle
      n = face_count(model%mesh%cell_kind(c))
      call inside_distance(model%mesh%cell_kind(c), local, distance(:n))
      if (minval(distance(:n)) < best) cycle
      if (cell > 0 .and. .not. minval(distance(:n)) > best + 1.0e-9_wp) cycle
      best = max(best, minval(distance(:n)))
      cell = c
    end do
    if (cell == 0) then
      call add_diagnostic(diagnostics, where, keyword, "the place of '"//name// &
        "' lies in no element that holds material")
      return
    end if
    call inverse_map(model%mesh, cell, x, local, ok)
    if (best < -on_face) call move_onto_cell(model%mesh, cell, local, x)
    model%state%tracers%cell(tracer) = cell
    model%state%tracers%local(:, tracer) = local
    model%state%tracers%position(:, tracer) = x
    model%state%tracers%initial_position(:, tracer) = x
  end subroutine place_tracer

  !> Moves a location outside a cell towards its centre, onto its face.
  pure subroutine move_onto_cell(mesh, cell, local, x)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: cell
    !> Local coordinates; position (dimension).
    real(wp), intent(inout) :: local(:), x(:)
    real(wp) :: middle(size(local)), within(max_faces), outside(max_faces)
    integer :: n, kind

    kind = mesh%cell_kind(cell)
    n = face_count(kind)
    middle = local_centre(kind)
    call inside_distance(kind, middle, within(:n))
    call inside_distance(kind, local, outside(:n))
    local = middle + minval(within(:n)/(within(:n) - outside(:n)), mask=outside(:n) < 0.0_wp)*(local - middle)
    x = place_in_cell(mesh, cell, local)
  end subroutine move_onto_cell

  !> Selects the material point nearest to the location of a history and reports it.
  subroutine pick_point(model, history, number, material)
    type(model_type), intent(inout) :: model
    type(history_type), intent(in) :: history
    !> Number of the history.
    integer, intent(in) :: number
    !> Material of the point.
    integer, intent(out) :: material
    character(len=160) :: line
    integer(long) :: point(1), known(1)
    real(wp) :: place(model%mesh%dimension)
    integer :: p, owner, body

    body = body_to_follow(model, history%at(:size(place)))
    point = nearest_numbers(model, reshape(history%at(:size(place)), [size(place), 1]), body)
    if (is_divided(model%part)) model%part%history_number(number) = point(1)
    p = place_of_number(model, point(1))
    model%history_point(number) = p
    place = 0.0_wp
    known = 0
    if (p > 0) then
      place = model%state%points%position(:, p)
      known = model%state%points%material(p)
    end if
    owner = lowest_rank(model%part%team, p > 0)
    call spread_from(model%part%team, owner, place)
    call spread_from(model%part%team, owner, known)
    material = int(known(1))
    write (line, '(3a,i0,a,3(1x,es12.5))') "history '", history%name, "' reads material point ", point(1), ' at', place
    model%notes = model%notes//trim(line)
    if (history%quantity == quantity_stress .and. model%laws(material)%pressure_factor > 0.0_wp) &
      model%notes = model%notes//"; cells of material '"//model%analysis%materials(material)%name// &
      "' have one pressure each; the history reports the smoothed pressure of the surrounding cells"
    model%notes = model%notes//new_line('a')
    call tell_body(model, history, body)
  end subroutine pick_point

  !> Reports which body a history follows when bodies are activated or deactivated, and warns if the body is removed.
  subroutine tell_body(model, history, body)
    type(model_type), intent(inout) :: model
    type(history_type), intent(in) :: history
    !> Number of the body, 0 for no particular body.
    integer, intent(in) :: body
    logical :: before(size(model%analysis%bodies)), now(size(before))
    integer :: p

    if (body == 0) return
    associate (name => model%analysis%bodies(body)%name, phases => model%analysis%phases)
      model%notes = model%notes//"history '"//history%name//"' follows body '"//name//"'"//new_line('a')
      do p = 1, size(phases)
        before = bodies_active(model%analysis, parent_of(phases, p))
        now = bodies_active(model%analysis, p)
        if (.not. before(body) .or. now(body)) cycle
        model%notes = model%notes//'warning: '//where_text(history%where)//"*HISTORY: '"//history%name// &
          "' follows body '"//name//"', which phase '"//phases(p)%name// &
          "' deactivates: from then on it does not represent the ground; choose a place in a body that remains, or "// &
          'on its face'//new_line('a')
        return
      end do
    end associate
  end subroutine tell_body

  !> Warns of a front that cannot move because the body touches the side of the mesh towards which it would run out.
  subroutine check_front(model, history)
    type(model_type), intent(inout) :: model
    type(history_type), intent(in) :: history
    real(wp) :: gap
    integer :: b, c, p

    c = history%component
    gap = huge(gap)
    associate (points => model%state%points, side => model%mesh%bounds(c, merge(1, 2, history%smallest)))
      do p = 1, points%count
        b = points%body(p)
        if (len(history%body) > 0 .and. model%analysis%bodies(b)%name /= history%body) cycle
        gap = min(gap, abs(side - points%position(c, p)) - points%half_size(c, p))
      end do
      gap = smallest(model%part%team, gap)
      if (gap > on_side*(model%mesh%bounds(c, 2) - model%mesh%bounds(c, 1))) return
      model%notes = model%notes//"warning: history '"//history%name//"' (RUNOUT): the body reaches the side of the "// &
        'mesh at '//rounded_text(side)//', where its outermost material point remains; let BODY= name the sliding '// &
        'soil, defined as a body separate from the ground in front of it'//new_line('a')
    end associate
  end subroutine check_front
end module qsmpm_histories
