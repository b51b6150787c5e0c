!> Bodies that come and go at the start of a phase (*ACTIVATE, *DEACTIVATE, *CHANGE MATERIAL): their points change
!> between what is there and what is not (qsmpm_inactive_points). docs/methods/stages.md.
!>
!> A body that is taken out keeps its stress and weight and is unloaded over the phase (qsmpm_unloading). One that comes
!> has no stress and no strain, and its weight comes over the phase; the first time it is stretched down to the ground
!> as it has settled (qsmpm_body_feet), later it stands where it has ridden to. With another material the stress stays
!> and the law starts from it.
module qsmpm_body_stages
  use qsmpm_kinds, only: wp
  use qsmpm_material_description, only: weight_at
  use qsmpm_named, only: place_named
  use qsmpm_active_bodies, only: bodies_named, body_number, has_stages
  use qsmpm_body_description, only: body_change_type
  use qsmpm_mesh_description, only: select_outline
  use qsmpm_method_description, only: basis_fem
  use qsmpm_body_feet, only: find_tracer_bodies, plant_feet
  use qsmpm_body_placing, only: place_body
  use qsmpm_carried_basis, only: nearest_point
  use qsmpm_cells_of_bodies, only: move_their_nodes
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_inactive_points, only: allocate_inactive
  use qsmpm_law, only: law_type
  use qsmpm_load_path, only: between
  use qsmpm_model, only: model_type, progress_type
  use qsmpm_model_surfaces, only: choose_carrying_points
  use qsmpm_point_selection, only: select_points, append_points, move_points
  use qsmpm_own_part, only: is_divided
  use qsmpm_points, only: points_type, surface_points_type, place_of
  use qsmpm_undrained_law, only: excess_pressure_name
  implicit none
  private

  public :: part_bodies, change_bodies, link_points

  !> Excess pore pressure of ground at rest over its stress.
  real(wp), parameter :: rounding = 1.0e-6_wp

contains

  !> Set the bodies aside that are not there at the start.
  subroutine part_bodies(model)
    !> As built, with all bodies.
    type(model_type), intent(inout) :: model

    call allocate_inactive(model%state%inactive, model%mesh%dimension)
    model%state%points%start_weight = model%state%points%weight
    if (.not. has_stages(model%analysis)) return
    if (model%analysis%method%basis == basis_fem) model%drawn_coordinates = model%mesh%coordinates
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

  !> Body of every surface point: that of the outline, else that of the nearest point which is there at the start.
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

  !> What the present phase does to bodies; its load fraction still is that which the phase before has reached. Nothing
  !> is done twice when the phase begins again.
  subroutine change_bodies(model, notes, error)
    type(model_type), intent(inout) :: model
    !> Sentences for the log.
    character(len=:), allocatable, intent(out) :: notes
    !> A body overlaps the ground, lies outside of the mesh, or has excess pore pressure that its new material cannot
    !> carry.
    type(error_type), allocatable, intent(out) :: error
    logical, dimension(size(model%analysis%bodies)) :: going, coming
    integer :: i

    notes = ''
    call settle_weights(model)
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
      ! Forces that a program has put on the points were those of others.
      if (allocated(model%loading%point_force)) deallocate (model%loading%point_force)
      call link_points(model)
    end associate
  end subroutine change_bodies

  !> Share of its changes that the phase before has left, where it has ended early.
  pure real(wp) function left_of(progress)
    type(progress_type), intent(in) :: progress

    left_of = max(1.0_wp - progress%fraction, progress%release_left)
  end function left_of

  !> Weights at the start of the phase are those that the phase before has reached.
  pure subroutine settle_weights(model)
    type(model_type), intent(inout) :: model
    real(wp) :: reached

    associate (progress => model%state%progress, points => model%state%points)
      reached = 1.0_wp - left_of(progress)
      points%start_weight = between(points%start_weight, points%weight, reached)
    end associate
  end subroutine settle_weights

  !> Bodies that the phase before has unloaded wait; what a phase ended early has left of their stress and weight is
  !> lowered on.
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

  !> Put a body in place, from what waits.
  subroutine bring(model, change, notes, error)
    type(model_type), intent(inout) :: model
    type(body_change_type), intent(in) :: change
    !> Gets a sentence.
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

  !> Another material for a body. The excess pore pressure of undrained soil stays with it; what else a law remembers
  !> begins anew from the stress, which is said.
  subroutine change_material(model, change, notes, error)
    type(model_type), intent(inout) :: model
    type(body_change_type), intent(in) :: change
    !> Sentences for the log.
    character(len=:), allocatable, intent(inout) :: notes
    !> The other material has no room for an excess pore pressure that is there.
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
            "which the drained material '"//change%material//"' cannot carry: let it out by *DRAIN STATE in a "// &
            'phase before, or give the material *UNDRAINED')
          return
        end if
        points%material(p) = m
        points%plastic(p) = 0
        ! The strain that the law takes the stress for counts from here.
        points%initial_volume(p) = points%volume(p)
        effective = points%stress(:, p)
        effective(:3) = effective(:3) + excess
        call law%start_at(effective, place_of(points, p), points%state(:law%state_count, p))
        if (behind > 0) points%state(behind, p) = excess
      end do
    end associate
    if (forgets) notes = notes//"warning: *CHANGE MATERIAL: the law of '"//change%material//"' begins anew from "// &
      "the stress of body '"//change%body//"': what it remembers of the past (preconsolidation, hardening, "// &
      'softening) is that of the card of the material'//new_line('a')
  end subroutine change_material

  !> Whether a law has remembered what the next one will remember anew.
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

  !> Find the points of histories, and of the pictures of loads, among those that are there.
  subroutine link_points(model)
    type(model_type), intent(inout) :: model
    integer :: i

    if (.not. allocated(model%history_number) .or. is_divided(model%part)) return
    model%history_point = model%history_number
    ! A state that was put back may be of before phases in which bodies come or go: its points are those of the start.
    if (has_stages(model%analysis)) then
      do i = 1, size(model%history_point)
        if (model%history_number(i) > 0) &
          model%history_point(i) = findloc(model%state%points%number, model%history_number(i), dim=1)
      end do
    end if
    call choose_carrying_points(model)
  end subroutine link_points
end module qsmpm_body_stages
