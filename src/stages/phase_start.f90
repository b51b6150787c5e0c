!> Start of a phase: applied loads and constraints, initial stresses, displacements and strains reset to zero.
!>
!> Loads and fixities remain until a later phase changes them; a load that is specified again varies from its former
!> value to the new one, a node with a prescribed displacement remains at its place. The reaction of a released fixity
!> or support is reduced to zero over the phase. The loads of a phase with initial stresses are fully applied from its
!> start, because these stresses balance them.
module qsmpm_phase_start
  use qsmpm_kinds, only: wp
  use qsmpm_load_description, only: support_none
  use qsmpm_named, only: place_named
  use qsmpm_phase_description, only: phase_type, initial_keep, phase_safety
  use qsmpm_active_bodies, only: has_stages
  use qsmpm_agreement, only: joint_norm
  use qsmpm_body_loads, only: start_body_loads
  use qsmpm_consolidation, only: closed_note
  use qsmpm_cavities, only: closure_of
  use qsmpm_body_stages, only: change_bodies
  use qsmpm_error, only: error_type
  use qsmpm_free_surface, only: bounds_note
  use qsmpm_initial_contact, only: press_on_bodies
  use qsmpm_initial_stress, only: set_initial_stresses, limit_note
  use qsmpm_limit_load, only: limit_load_type
  use qsmpm_lowered_laws, only: fit_laws
  use qsmpm_load_path, only: between
  use qsmpm_phase_ends, only: fraction_reached
  use qsmpm_pore_water, only: begin_free_surface, dry_tables, take_levels, update_pore_pressure
  use qsmpm_vertical, only: upwards
  use qsmpm_softening, only: softening_state
  use qsmpm_surface_pressure, only: surface_pressure_type, reached_pressure
  use qsmpm_model, only: model_type, loading_type
  use qsmpm_own_part, only: is_divided, own_of
  use qsmpm_points, only: set_normals, reset_strains
  use qsmpm_pushed_material, only: watch_sets
  use qsmpm_element, only: face_count, face_corners
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_sets, only: items_of
  use qsmpm_rigid_bodies, only: force_on_body
  use qsmpm_phase_tree, only: lineage
  use qsmpm_safety_bracket, only: bracket_type
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_strength_profile, only: follows_stress
  use qsmpm_team, only: largest, smallest
  implicit none
  private

  public :: starts_whole, start_phase, resume_phase, measure_start

contains

  !> Returns whether a divided model must be assembled before its current phase begins: bodies are activated,
  !> deactivated or changed, or contact points on bodies receive initial stresses.
  pure logical function starts_whole(model) result(whole)
    type(model_type), intent(in) :: model

    whole = .false.
    if (.not. is_divided(model%part)) return
    associate (phase => model%analysis%phases(model%state%progress%phase))
      if (has_stages(model%analysis)) whole = size(phase%activations) + size(phase%deactivations) &
        + size(phase%materials) > 0 .or. any(model%part%taken_out)
      if (phase%initial%kind /= initial_keep) whole = whole .or. any(model%contact_pairs%surface == 0)
    end associate
  end function starts_whole

  !> Begins the current phase of the model.
  subroutine start_phase(model, notes, error)
    type(model_type), intent(inout) :: model
    !> Messages for the log.
    character(len=:), allocatable, intent(out), optional :: notes
    !> A body that is activated cannot be placed.
    type(error_type), allocatable, intent(out), optional :: error
    type(error_type), allocatable :: failure
    character(len=:), allocatable :: text

    call start_body_loads(model)
    call change_bodies(model, text, failure)
    if (present(notes)) call move_alloc(text, notes)
    if (present(error) .and. allocated(failure)) then
      call move_alloc(failure, error)
      return
    end if
    associate (progress => model%state%progress)
      progress%release_left = max(1.0_wp - progress%fraction, progress%release_left)
      progress%stopped = .false.
      progress%fraction = 0.0_wp
      if (model%analysis%phases(progress%phase)%kind /= phase_safety) progress%load_factor = 0.0_wp
      progress%strength_factor = 1.0_wp
      progress%bracket = bracket_type()
      progress%next_step = 0.0_wp
      progress%constant_load_tests_done = 0
      progress%limit = limit_load_type()
      progress%phase_steps = 0
    end associate
    call resume_phase(model)
    call fit_laws(model)
    call release(model)
    call watch_sets(model)
    associate (phase => model%analysis%phases(model%state%progress%phase))
      if (phase%reset_displacements) then
        model%state%points%initial_position = model%state%points%position
        model%state%tracers%initial_position = model%state%tracers%position
        call reset_strains(model%state%points)
      end if
      if (phase%initial%kind /= initial_keep) then
        call set_initial_stresses(model, phase%initial)
        if (present(notes)) notes = notes//limit_note(model, phase%initial)
        call press_on_bodies(model, phase%initial)
      end if
      if (phase%reset_strains) call reset_softening(model)
      if (phase%updates_strength) call update_strengths(model)
      if (present(notes) .and. (phase%updates_strength .or. phase%initial%kind /= initial_keep .or. &
        size(phase%materials) > 0)) notes = notes//strength_note(model)
    end associate
    call begin_free_surface(model)
    if (present(notes)) notes = notes//closed_note(model)//bounds_note(model)
    call update_pore_pressure(model)
  end subroutine start_phase

  !> Computes the forces at the start of the phase on what it moves, which may decrease to zero: they are lower bounds
  !> of the reference values of residuals.
  subroutine measure_start(model)
    type(model_type), intent(inout) :: model
    logical :: moved(size(model%loading%prescribed, 1), size(model%loading%prescribed, 2))
    integer :: b

    moved = abs(model%loading%prescribed) > 0.0_wp &
      .and. spread(own_of(model%part%nodes, model%space%node_count), 1, size(moved, 1))
    model%state%progress%force_at_start = joint_norm(model%part%team, norm2(pack(model%state%reactions, moved))) &
      + sum([(norm2(force_on_body(model, b)), b=1, size(model%analysis%rigid_bodies))])
  end subroutine measure_start

  !> Resets materials with *SOFTENING to their initial strength.
  pure subroutine reset_softening(model)
    type(model_type), intent(inout) :: model
    integer :: m, i, p

    do m = 1, size(model%laws)
      if (.not. model%analysis%materials(m)%softening%given .or. .not. allocated(model%laws(m)%law%state_names)) cycle
      do i = 1, size(model%laws(m)%law%state_names)
        if (model%laws(m)%law%state_names(i)%text /= softening_state) cycle
        do p = 1, model%state%points%count
          if (model%state%points%material(p) == m) model%state%points%state(i, p) = 0.0_wp
        end do
      end do
    end do
  end subroutine reset_softening

  !> Converts the reactions of fixities and supports that this phase releases to a load that decreases to zero; supports
  !> that it changes begin at the present position and normal of their surface, without a force.
  subroutine release(model)
    type(model_type), intent(inout) :: model
    logical :: changed(model%state%surface%count)
    integer :: i

    changed = .false.
    associate (phase => model%analysis%phases(model%state%progress%phase), surface => model%state%surface, &
        state => model%state)
      do i = 1, size(phase%supports)
        changed = changed .or. surface%surface == place_named(model%analysis%surfaces, phase%supports(i)%surface)
      end do
      state%released = state%progress%release_left*state%released &
        + merge(0.0_wp, state%reactions, model%loading%constrained)
      surface%released = state%progress%release_left*surface%released &
        + merge(surface%reaction, 0.0_wp, spread(changed, 1, size(surface%reaction, 1)))
      state%progress%release_left = 0.0_wp
    end associate
    call set_normals(model%state%surface, changed)
  end subroutine release

  !> Sets the loads and constraints of the current phase by applying its ancestors in order. Forces on material points
  !> belong to the embedding program and do not change.
  subroutine resume_phase(model)
    type(model_type), intent(inout) :: model
    type(loading_type) :: loading
    integer, allocatable :: line(:)
    integer :: i

    allocate (loading%constrained(model%mesh%dimension, model%space%node_count), source=.false.)
    allocate (loading%prescribed(model%mesh%dimension, model%space%node_count), source=0.0_wp)
    allocate (loading%held(model%mesh%dimension, model%mesh%node_count), source=.false.)
    allocate (loading%traction_start(3, size(model%analysis%surfaces)), &
      loading%traction_final(3, size(model%analysis%surfaces)), source=0.0_wp)
    allocate (loading%pressure_start(size(model%analysis%surfaces)), &
      loading%pressure_final(size(model%analysis%surfaces)))
    call dry_tables(model%analysis, loading%water_final)
    allocate (loading%carrier(size(model%analysis%surfaces)), source=0)
    allocate (loading%support(size(model%analysis%surfaces)), source=support_none)
    allocate (loading%closure_start(size(model%analysis%surfaces)), &
      loading%closure_final(size(model%analysis%surfaces)), source=0.0_wp)
    allocate (loading%floats(size(model%analysis%surfaces)), source=.false.)
    allocate (line, source=lineage(model%analysis%phases, model%state%progress%phase))
    do i = 1, size(line)
      call apply_phase(model, model%analysis%phases(line(i)), loading)
      if (i < size(line)) call end_early(fraction_reached(model%state%progress, line(i)), loading)
    end do
    allocate (loading%open_edge(model%mesh%cell_count))
    call find_open_edges(model%mesh, loading%held, loading%open_edge)
    if (allocated(model%loading%point_force)) call move_alloc(model%loading%point_force, loading%point_force)
    model%loading = loading
  end subroutine resume_phase

  !> Sets the loads of a phase that has ended at a load fraction; water levels are not changed (qsmpm_deck_water).
  pure subroutine end_early(fraction, loading)
    real(wp), intent(in) :: fraction
    type(loading_type), intent(inout) :: loading

    if (.not. fraction < 1.0_wp) return
    loading%gravity_final = between(loading%gravity_start, loading%gravity_final, fraction)
    loading%traction_final = between(loading%traction_start, loading%traction_final, fraction)
    loading%pressure_final = reached_pressure(loading%pressure_start, loading%pressure_final, fraction)
    loading%closure_final = between(loading%closure_start, loading%closure_final, fraction)
  end subroutine end_early

  !> Finds cells with a face on the boundary of the mesh of which a corner is not constrained along the normal. The
  !> rollers of a slice or of a column constrain every node, but not the top.
  pure subroutine find_open_edges(mesh, held, open_edge)
    type(mesh_type), intent(in) :: mesh
    !> Constrained components (dimension, node_count).
    logical, intent(in) :: held(:, :)
    !> (cell_count)
    logical, intent(out) :: open_edge(:)
    integer :: c, f, kind

    open_edge = .false.
    do c = 1, mesh%cell_count
      kind = mesh%cell_kind(c)
      do f = 1, face_count(kind)
        if (mesh%face_neighbour(f, c) /= 0) cycle
        associate (nodes => mesh%cell_nodes(mesh%cell_first(c) - 1 + face_corners(kind, f)))
          open_edge(c) = open_edge(c) .or. .not. all(held(normal_axis(mesh%coordinates(:, nodes)), nodes))
        end associate
      end do
    end do
  end subroutine find_open_edges

  !> Returns the axis nearest to the normal of a face: the one along which it is shortest.
  pure integer function normal_axis(corners)
    !> Corners of the face (dimension, n).
    real(wp), intent(in) :: corners(:, :)

    normal_axis = minloc(maxval(corners, dim=2) - minval(corners, dim=2), dim=1)
  end function normal_axis

  !> Applies the changes of one phase.
  subroutine apply_phase(model, phase, loading)
    type(model_type), intent(in) :: model
    type(phase_type), intent(in) :: phase
    !> Loads and constraints.
    type(loading_type), intent(inout) :: loading
    integer :: i, s

    call apply_constraints(model, phase, loading)
    loading%gravity_start = loading%gravity_final
    if (phase%gravity%given) loading%gravity_final = phase%load_factor*phase%gravity%vector
    loading%traction_start = loading%traction_final
    loading%pressure_start = loading%pressure_final
    loading%closure_start = loading%closure_final
    loading%water_start = loading%water_final
    call take_levels(model%analysis, phase, loading%water_final)
    ! The field of qsmpm_pore_flow contains the total pressure, which is applied instantaneously.
    if (any(phase%water_levels%coupled)) loading%water_start = loading%water_final
    do i = 1, size(phase%tractions)
      s = place_named(model%analysis%surfaces, phase%tractions(i)%surface)
      if (s == 0) cycle
      if (phase%tractions(i)%follows) then
        associate (load => phase%tractions(i), factor => phase%load_factor)
          loading%pressure_final(s) = surface_pressure_type(factor*load%pressure, upwards(model%analysis)*factor* &
            load%gradient, load%height, load%of_water)
        end associate
      else
        loading%traction_final(:, s) = phase%load_factor*phase%tractions(i)%vector
        loading%carrier(s) = phase%tractions(i)%carrier
      end if
    end do
    do i = 1, size(phase%supports)
      associate (support => phase%supports(i))
        s = place_named(model%analysis%surfaces, support%surface)
        if (s == 0) cycle
        loading%support(s) = support%kind
        loading%floats(s) = support%contracts .and. .not. support%held
        loading%closure_start(s) = 0.0_wp
        loading%closure_final(s) = closure_of(phase%load_factor*support%volume_loss)
      end associate
    end do
    if (phase%initial%kind == initial_keep) return
    loading%gravity_start = loading%gravity_final
    loading%traction_start = loading%traction_final
    loading%pressure_start = loading%pressure_final
    loading%water_start = loading%water_final
  end subroutine apply_phase

  !> Applies the components that one phase fixes, releases and prescribes.
  subroutine apply_constraints(model, phase, loading)
    type(model_type), intent(in) :: model
    type(phase_type), intent(in) :: phase
    type(loading_type), intent(inout) :: loading
    integer :: i, c

    loading%prescribed = 0.0_wp
    do i = 1, size(phase%fixities)
      associate (fixity => phase%fixities(i), functions => items_of(model%space%sets, phase%fixities(i)%set), &
          nodes => items_of(model%mesh%node_sets, phase%fixities(i)%set))
        do c = 1, model%mesh%dimension
          loading%constrained(c, functions) = fixity%fixed(c) .or. &
            (any(fixity%fixed) .and. loading%constrained(c, functions))
          loading%held(c, nodes) = fixity%fixed(c) .or. (any(fixity%fixed) .and. loading%held(c, nodes))
        end do
      end associate
    end do
    do i = 1, size(phase%prescriptions)
      associate (set => phase%prescriptions(i)%set, c => phase%prescriptions(i)%component)
        loading%constrained(c, items_of(model%space%sets, set)) = .true.
        loading%held(c, items_of(model%mesh%node_sets, set)) = .true.
        loading%prescribed(c, items_of(model%space%sets, set)) = phase%load_factor*phase%prescriptions(i)%value
      end associate
    end do
  end subroutine apply_constraints

  !> Updates strengths that depend on the effective stress of their points (SHANSEP, Ladd and Foott 1974) from the
  !> present stresses.
  pure subroutine update_strengths(model)
    type(model_type), intent(inout) :: model
    integer :: p

    associate (points => model%state%points)
      do p = 1, points%count
        associate (law => model%laws(points%material(p))%law)
          call law%strengthen(points%stress(:, p), points%state(:law%state_count, p))
        end associate
      end do
    end associate
  end subroutine update_strengths

  !> Returns a line for each material with such a strength: the range over its points.
  function strength_note(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    real(wp) :: range(2)
    logical :: of_soil(model%state%points%count)
    integer :: m, i

    text = ''
    associate (points => model%state%points, team => model%part%team)
      do m = 1, size(model%laws)
        if (.not. follows_stress(model%analysis%materials(m)%strength_profile)) cycle
        of_soil = own_of(model%part%points, points%count) .and. points%material == m
        associate (names => model%laws(m)%law%state_names)
          do i = 1, size(names)
            if (names(i)%text /= 'undrained_strength') cycle
            associate (strength => points%state(i, :points%count))
              range = [smallest(team, minval(strength, of_soil)), largest(team, maxval(strength, of_soil))]
            end associate
            if (range(1) <= range(2)) text = text//"material '"//model%analysis%materials(m)%name// &
              "': strength by the stress from "//rounded_text(range(1))//' to '//rounded_text(range(2))//new_line('a')
          end do
        end associate
      end do
    end associate
  end function strength_note
end module qsmpm_phase_start
