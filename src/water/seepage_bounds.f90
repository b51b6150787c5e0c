!> Boundary conditions of seepage: nodes with prescribed head, seepage faces, and rain.
!>
!> Levels are assigned to parts of the boundary (*WATER LEVEL, TYPE=SEEPAGE). Nodes of a part below the level have it as
!> their head; so have those of adjacent exposed faces up to the level, as on a wall, and those of a set within the
!> ground, a well or a drain. Nodes above the level and all other exposed faces are seepage faces. The sides and the
!> base of the grid, rigid bodies and faces held by a *SUPPORT are impermeable.
module qsmpm_seepage_bounds
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: body_materials
  use qsmpm_analysis, only: analysis_type, axisymmetric
  use qsmpm_covered_faces, only: is_under_body
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_fitted_mesh, only: fitted_mesh_type
  use qsmpm_free_surface, only: former_levels, is_of_part => is_on, looks_up
  use qsmpm_free_water, only: find_shores, spread_water
  use qsmpm_load_description, only: head_type, support_none, water_level_type
  use qsmpm_mesh_description, only: select_box, select_outline, select_plane, select_segment, surface_type
  use qsmpm_model, only: model_type
  use qsmpm_outline_graph, only: outline_type
  use qsmpm_phase_tree, only: lineage
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_seepage, only: node_face, node_free, node_head, seepage_type
  use qsmpm_tensor, only: cross
  use qsmpm_vertical, only: upwards, vertical_of
  implicit none
  private

  public :: seepage_scene_type, place_bounds

  !> Tolerance of distances relative to the size of the grid.
  real(wp), parameter :: hair = 1.0e-6_wp
  !> Largest distance of a node from a drain, relative to the longest edge of a cell; any place has a node within it.
  real(wp), parameter :: beside = 0.58_wp

  !> Triangles or tetrahedra of a phase.
  type :: seepage_scene_type
    type(fitted_mesh_type) :: mesh
    type(outline_type), allocatable :: outlines(:)
    !> Tetrahedra only: cell of the model's mesh, and its face opposite each corner, 0 for none (corners, cells).
    integer, allocatable :: cell(:), face(:, :)
    !> Whether water flows through a cell (cells).
    logical, allocatable :: flows(:)
    !> Row of *WATER LEVEL of a node, 0 for none (nodes).
    integer, allocatable :: row(:)
    !> Whether the water of a row acts on adjacent faces (rows).
    logical, allocatable :: beside(:)
    !> Node at which the water of a row ends next to exposed ground below its level, 0 for none (rows).
    integer, allocatable :: shore(:)
    real(wp) :: size = 1.0_wp
  end type seepage_scene_type

contains

  !> Determines the kinds and heads of the nodes on the boundary.
  subroutine place_bounds(model, number, level, scene, flow, diagnostics)
    type(model_type), intent(in) :: model
    !> Number of the phase.
    integer, intent(in) :: number
    type(water_level_type), intent(in) :: level
    type(seepage_scene_type), intent(inout) :: scene
    type(seepage_type), intent(inout) :: flow
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: c, k, i, turn, ends(size(scene%mesh%corner, 1) - 1), wet(size(flow%kind))
    logical :: found(size(level%heads)), open(size(scene%mesh%corner, 1), size(scene%flows)), missing(size(found))
    real(wp) :: up, reach(size(level%heads)), area(size(level%heads))
    integer :: material(size(model%analysis%bodies))

    up = upwards(model%analysis)
    allocate (scene%row(size(flow%kind)), source=0)
    reach = up*level%heads%level
    if (level%transient) reach = max(reach, up*former_levels(model%analysis%phases, number, level%heads))
    found = .false.
    area = 0.0_wp
    open = .false.
    wet = 0
    ! Faces under rigid bodies belong to a row that has no others, as of a drained wall.
    do turn = 1, 2
      missing = .not. found
      do c = 1, size(scene%flows)
        do k = 1, size(open, 1)
          if (.not. is_bound(scene, c, k)) cycle
          ends = ends_of(scene, c, k)
          if (is_under_body(model, flow%position(:, ends)) .neqv. turn == 2) cycle
          open(k, c) = is_in_air(model, scene, c, k) .and. .not. is_held(model, scene, number, c, k)
          if (open(k, c)) where (flow%kind(ends) == node_free) flow%kind(ends) = node_face
          do i = 1, size(level%heads)
            if (.not. missing(i)) cycle
            if (.not. is_on(model, scene, level%heads(i)%set, c, k)) cycle
            found(i) = .true.
            call give_head(up*level%heads(i)%level, i, ends, scene, flow)
            area(i) = area(i) + norm2(area_of(flow%position(:, ends)))
            call let_rain(model%analysis, level%heads(i), ends, flow)
            if (open(k, c)) where (scene%row(ends) == i .and. reach(i) >= flow%height(ends) - hair*scene%size) &
              wet(ends) = i
          end do
        end do
      end do
    end do
    material = body_materials(model%analysis, number)
    call flood(up*level%heads%level, reach, open, spread(model%analysis%materials(material(max(1, scene%mesh%region))) &
      %permeability(1) > 0.0_wp, 1, size(open, 1)), wet, scene, flow)
    do i = 1, size(found)
      if (size(ends) == 3) then
        call check_part(model, level%heads(i), area(i), diagnostics)
        cycle
      end if
      if (.not. found(i)) call place_drain(model%analysis, level%heads(i), i, scene, flow, found(i))
      if (.not. found(i)) call add_diagnostic(diagnostics, level%heads(i)%where, '*WATER LEVEL', &
        "neither an edge nor a node of the ground is in '"//level%heads(i)%set//"'")
    end do
    if (all(found) .and. .not. (level%transient .or. any(flow%kind == node_head .or. flow%rain > 0.0_wp))) &
      call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', &
      'every level is below its part of the boundary: there is no inflow')
  end subroutine place_bounds

  !> Checks that a level in 3D covers whole faces of the ground.
  subroutine check_part(model, head, area, diagnostics)
    type(model_type), intent(in) :: model
    type(head_type), intent(in) :: head
    !> Area of the faces to which the level applies.
    real(wp), intent(in) :: area
    type(diagnostics_type), intent(inout) :: diagnostics
    real(wp), parameter :: whole = 1.0e-3_wp
    real(wp) :: wanted
    integer :: i

    wanted = 0.0_wp
    associate (points => model%state%surface)
      do i = 1, points%count
        if (model%analysis%surfaces(points%surface(i))%name == head%set) wanted = wanted + &
          norm2(points%area_vector(:, i))
      end do
    end associate
    if (.not. area > 0.0_wp) then
      call add_diagnostic(diagnostics, head%where, '*WATER LEVEL', "no face of the ground is in '"//head%set// &
        "' (a well or drain inside the ground requires a plane model)")
    else if (wanted > 0.0_wp .and. abs(area - wanted) > whole*wanted) then
      call add_diagnostic(diagnostics, head%where, '*WATER LEVEL', "surface '"//head%set//"', "// &
        rounded_text(wanted)//' large, covers faces of cells that are '//rounded_text(area)// &
        ' large: let it end at their edges')
    end if
  end subroutine check_part

  !> Area vector of a triangle in 3D; 0 for an edge in the plane.
  pure function area_of(corner) result(area)
    !> (dimension, dimension)
    real(wp), intent(in) :: corner(:, :)
    real(wp) :: area(3)

    area = 0.0_wp
    if (size(corner, 1) == 3) area = 0.5_wp*cross(corner(:, 2) - corner(:, 1), corner(:, 3) - corner(:, 1))
  end function area_of

  !> Applies the free water to adjacent exposed faces.
  subroutine flood(level, reach, open, porous, wet, scene, flow)
    !> Upward level of each row, and its highest in the phase.
    real(wp), intent(in) :: level(:), reach(:)
    !> Exposed faces, and those of permeable soil (corners, cells).
    logical, intent(in) :: open(:, :), porous(:, :)
    !> Row whose free water reaches a node, 0 for none (nodes).
    integer, intent(in) :: wet(:)
    type(seepage_scene_type), intent(inout) :: scene
    type(seepage_type), intent(inout) :: flow
    integer :: reached(size(wet)), a

    reached = wet
    call spread_water(edges_of(scene, open), flow%height, reach, scene%row > 0, reached)
    allocate (scene%beside(size(level)), source=.false.)
    do a = 1, size(wet)
      if (reached(a) == wet(a)) cycle
      call give_head(level(reached(a)), reached(a), [a, a], scene, flow)
      scene%beside(reached(a)) = .true.
    end do
    allocate (scene%shore, source=find_shores(edges_of(scene, open .and. porous), flow%height, level, scene%row, &
      flow%kind == node_head))
  end subroutine flood

  !> Returns the nodes of the edges of the chosen faces (2, edges).
  pure function edges_of(scene, chosen) result(ends)
    type(seepage_scene_type), intent(in) :: scene
    !> (corners, cells)
    logical, intent(in) :: chosen(:, :)
    integer :: ends(2, count(chosen)*merge(1, 3, size(chosen, 1) == 3))
    integer :: face(size(chosen, 1) - 1), c, k, n, i

    n = 0
    do c = 1, size(chosen, 2)
      do k = 1, size(chosen, 1)
        if (.not. chosen(k, c)) cycle
        face = ends_of(scene, c, k)
        do i = 1, merge(1, 3, size(face) == 2)
          n = n + 1
          ends(:, n) = face([i, modulo(i, size(face)) + 1])
        end do
      end do
    end do
  end function edges_of

  !> Returns the nodes of the face of a cell opposite a corner.
  pure function ends_of(scene, c, k) result(ends)
    type(seepage_scene_type), intent(in) :: scene
    integer, intent(in) :: c, k
    integer :: ends(size(scene%mesh%corner, 1) - 1), i

    ends = scene%mesh%corner(modulo([(k + i, i=0, size(ends) - 1)], size(ends) + 1) + 1, c)
  end function ends_of

  !> Checks whether a face is on a surface held by a support, which is impermeable.
  pure logical function is_held(model, scene, number, c, f) result(held)
    type(model_type), intent(in) :: model
    type(seepage_scene_type), intent(in) :: scene
    !> Number of the phase, of the cell, and of the opposite corner.
    integer, intent(in) :: number, c, f
    integer, allocatable :: line(:)
    integer :: i, k

    held = .false.
    allocate (line, source=lineage(model%analysis%phases, number))
    do i = 1, size(line)
      associate (supports => model%analysis%phases(line(i))%supports)
        do k = 1, size(supports)
          if (is_on(model, scene, supports(k)%surface, c, f)) held = supports(k)%kind /= support_none
        end do
      end associate
    end do
  end function is_held

  !> Distributes the rain on a face to its nodes; rain on free water has no effect.
  subroutine let_rain(analysis, head, ends, flow)
    type(analysis_type), intent(in) :: analysis
    type(head_type), intent(in) :: head
    integer, intent(in) :: ends(:)
    type(seepage_type), intent(inout) :: flow
    real(wp) :: breadth, area(3)

    associate (x => flow%position(:, ends), axis => vertical_of(analysis))
      if (size(ends) == 3) then
        area = area_of(x)
        breadth = abs(area(axis))
      else
        breadth = abs(x(3 - axis, 2) - x(3 - axis, 1))
      end if
      if (analysis%model == axisymmetric) breadth = breadth*sum(flow%position(1, ends))/2.0_wp
    end associate
    flow%rain(ends) = flow%rain(ends) + head%rain*breadth/size(ends)
  end subroutine let_rain

  !> Applies the level at a box within the ground, a well or a drain at least as wide as a cell: the nodes at it have
  !> the level as their head or drain.
  subroutine place_drain(analysis, head, number, scene, flow, found)
    type(analysis_type), intent(in) :: analysis
    type(head_type), intent(in) :: head
    !> Number of the row.
    integer, intent(in) :: number
    type(seepage_scene_type), intent(inout) :: scene
    type(seepage_type), intent(inout) :: flow
    logical, intent(out) :: found
    real(wp) :: at(2), near
    integer :: i, c, k

    found = .false.
    do i = 1, size(analysis%node_sets)
      if (analysis%node_sets(i)%name /= head%set .or. analysis%node_sets(i)%selection /= select_box) cycle
      do c = 1, size(scene%flows)
        if (.not. scene%flows(c)) cycle
        associate (corner => scene%mesh%corner(:, c), x => scene%mesh%position, box => analysis%node_sets(i)%box(:2, :))
          near = beside*maxval(norm2(x(:, corner) - x(:, corner([2, 3, 1])), dim=1))
          do k = 1, 3
            at = max(box(:, 1), min(box(:, 2), x(:, corner(k))))
            if (norm2(at - x(:, corner(k))) > near) cycle
            found = .true.
            call give_head(upwards(analysis)*head%level, number, corner([k, k]), scene, flow)
          end do
        end associate
      end do
    end do
  end subroutine place_drain

  !> Applies the level of a row at the nodes of a face: prescribed head below it, seepage face above it.
  subroutine give_head(level, number, ends, scene, flow)
    real(wp), intent(in) :: level
    integer, intent(in) :: number, ends(:)
    type(seepage_scene_type), intent(inout) :: scene
    type(seepage_type), intent(inout) :: flow
    integer :: k

    do k = 1, size(ends)
      associate (kind => flow%kind(ends(k)), head => flow%head(ends(k)))
        if (level - flow%height(ends(k)) >= -hair*scene%size) then
          if (kind == node_head .and. head >= level) cycle
          kind = node_head
          head = level
          scene%row(ends(k)) = number
        else if (kind /= node_head) then
          kind = node_face
          scene%row(ends(k)) = number
        end if
      end associate
    end do
  end subroutine give_head

  !> Checks whether the face of a cell opposite a corner bounds the ground that water flows through.
  pure logical function is_bound(scene, c, k)
    type(seepage_scene_type), intent(in) :: scene
    integer, intent(in) :: c, k

    is_bound = scene%flows(c)
    if (.not. is_bound .or. scene%mesh%neighbour(k, c) == 0) return
    is_bound = .not. scene%flows(scene%mesh%neighbour(k, c))
  end function is_bound

  !> Checks whether a face is exposed: neither side nor base of the grid or mesh nor next to a rigid body.
  pure logical function is_in_air(model, scene, c, k)
    type(model_type), intent(in) :: model
    type(seepage_scene_type), intent(in) :: scene
    integer, intent(in) :: c, k
    integer :: ends(size(scene%mesh%corner, 1) - 1)

    ends = ends_of(scene, c, k)
    associate (height => upwards(model%analysis)*scene%mesh%position(vertical_of(model%analysis), :))
      is_in_air = .not. is_under_body(model, scene%mesh%position(:, ends))
      if (scene%mesh%neighbour(k, c) > 0 .or. .not. is_in_air) return
      if (allocated(scene%face)) then
        is_in_air = looks_up(model, scene%cell(c), scene%face(k, c))
      else
        is_in_air = all(height(ends) >= maxval(height) - hair*scene%size)
      end if
    end associate
  end function is_in_air

  !> Checks whether the face of a cell opposite a corner is in a node set or a surface.
  pure logical function is_on(model, scene, name, c, k) result(on)
    type(model_type), intent(in) :: model
    type(seepage_scene_type), intent(in) :: scene
    character(len=*), intent(in) :: name
    integer, intent(in) :: c, k
    real(wp) :: ends(2, 2), near
    integer :: i

    if (allocated(scene%face)) then
      on = is_of_part(model, name, scene%cell(c), scene%face(k, c))
      return
    end if
    on = .false.
    ends = scene%mesh%position(:, ends_of(scene, c, k))
    near = hair*scene%size
    do i = 1, size(model%analysis%node_sets)
      associate (set => model%analysis%node_sets(i))
        if (set%name /= name) cycle
        if (set%selection == select_plane .and. set%axis < 3) &
          on = all(abs(ends(set%axis, :) - set%box(set%axis, 1)) <= near)
        if (set%selection == select_box) on = in_box(set%box, ends, near)
      end associate
    end do
    do i = 1, size(model%analysis%surfaces)
      associate (surface => model%analysis%surfaces(i))
        if (surface%name == name) &
          on = on .or. is_on_surface(surface, model%analysis%bodies(scene%mesh%region(c))%name, ends, near)
      end associate
    end do
  end function is_on

  !> Checks whether an edge of a body is on a surface.
  pure logical function is_on_surface(surface, body, ends, near) result(on)
    type(surface_type), intent(in) :: surface
    character(len=*), intent(in) :: body
    real(wp), intent(in) :: ends(:, :), near
    real(wp) :: along(2), across(2), share(2)
    integer :: k

    on = .false.
    select case (surface%selection)
    case (select_box)
      on = in_box(surface%box, ends, near)
    case (select_outline)
      on = surface%body == body
      if (surface%boxed) on = on .and. in_box(surface%box, ends, near)
    case (select_segment)
      do k = 1, size(surface%segments, 2)
        along = surface%segments(3:4, k) - surface%segments(1:2, k)
        share = matmul(along, ends - spread(surface%segments(1:2, k), 2, 2))/dot_product(along, along)
        across = matmul([-along(2), along(1)], ends - spread(surface%segments(1:2, k), 2, 2))/norm2(along)
        on = on .or. (all(abs(across) <= near) .and. minval(share) >= -near/norm2(along) .and. &
          maxval(share) <= 1.0_wp + near/norm2(along))
      end do
    end select
  end function is_on_surface

  !> Checks whether two places are within a box.
  pure logical function in_box(box, ends, near)
    !> Lower and upper corner (3, 2).
    real(wp), intent(in) :: box(:, :), ends(:, :), near

    in_box = all(ends >= spread(box(:2, 1), 2, 2) - near) .and. all(ends <= spread(box(:2, 2), 2, 2) + near)
  end function in_box
end module qsmpm_seepage_bounds
