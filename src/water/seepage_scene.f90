!> Water that flows through the bodies of a phase as they are drawn: the triangles that fit them, what their bounds are
!> to the water, and what is found told.
!>
!> Levels are given on parts of the bounds (*WATER LEVEL, TYPE=SEEPAGE). Nodes there below the level have it as their
!> head, and so those of a set within the ground, a well or a drain; those above it and all that lie in air elsewhere
!> are a face at which water may leave; the sides and the base of the grid and rigid bodies are tight. Ground that no
!> level reaches is dry.
module qsmpm_seepage_scene
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: bodies_active, body_materials
  use qsmpm_analysis, only: analysis_type, axisymmetric, three_dimensional
  use qsmpm_body_description, only: body_box, body_polygon
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_error, only: error_type
  use qsmpm_fitted_background, only: fit_scene
  use qsmpm_fitted_mesh, only: fitted_mesh_type
  use qsmpm_load_description, only: head_type, water_level_type
  use qsmpm_mesh_description, only: mesh_fitted, mesh_grid, select_box, select_outline, select_plane, select_segment, &
    surface_type
  use qsmpm_model, only: model_type
  use qsmpm_outline_graph, only: outline_type
  use qsmpm_phase_tree, only: lineage
  use qsmpm_polygon, only: polygon_contains
  use qsmpm_vertical, only: upwards, vertical_of
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_seepage, only: node_face, node_free, node_head, seepage_type, solve_seepage
  use qsmpm_seepage_field, only: index_triangles, seepage_field_type
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: find_seepage

  !> Distance that is none, over the size of the grid.
  real(wp), parameter :: hair = 1.0e-6_wp
  !> Height over which soil in suction lets water through, over the smallest cell of the grid: the discharge errs by
  !> half of what it does with one, and a quarter is not always found.
  real(wp), parameter :: suction_of_cell = 0.5_wp
  !> Distance of a node of a drain from it, over the longest edge of a cell: one of the nodes of any place is as near.
  real(wp), parameter :: beside = 0.58_wp
  !> Permeability of what is tight over the least of all others: the pressure goes evenly from one side to the other.
  real(wp), parameter :: tight = 1.0e-6_wp

  !> The triangles of a phase.
  type :: scene_type
    type(fitted_mesh_type) :: mesh
    type(outline_type), allocatable :: outlines(:)
    !> Whether water flows through a cell (cells).
    logical, allocatable :: flows(:)
    !> Row of the card that a node is of, 0 for none (nodes).
    integer, allocatable :: row(:)
    real(wp) :: size = 1.0_wp
  end type scene_type

contains

  !> The flows of all phases, each kept with its level.
  subroutine find_seepage(model, diagnostics)
    !> Its notes tell what flows.
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: p, i

    do p = 1, size(model%analysis%phases)
      call check_change(model%analysis, p, diagnostics)
      do i = 1, size(model%analysis%phases(p)%water_levels)
        if (model%analysis%phases(p)%water_levels(i)%flows) call find_flow(model, p, i, diagnostics)
      end do
    end do
  end subroutine find_seepage

  !> Bodies that come or go change a flow.
  subroutine check_change(analysis, number, diagnostics)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number
    type(diagnostics_type), intent(inout) :: diagnostics
    integer, allocatable :: path(:)
    integer :: k

    associate (phase => analysis%phases(number))
      if (.not. allocated(phase%activations) .or. size(phase%water_levels) > 0) return
      if (size(phase%activations) + size(phase%deactivations) == 0) return
      allocate (path, source=lineage(analysis%phases, number))
      do k = size(path), 1, -1
        associate (levels => analysis%phases(path(k))%water_levels)
          if (size(levels) == 0) cycle
          if (any(levels%flows)) call add_diagnostic(diagnostics, phase%where, '*PHASE', "phase '"//phase%name// &
            "' changes bodies that water flows through: repeat *WATER LEVEL, TYPE=SEEPAGE in it")
          return
        end associate
      end do
    end associate
  end subroutine check_change

  !> The flow of one card.
  subroutine find_flow(model, number, item, diagnostics)
    type(model_type), intent(inout) :: model
    !> Of the phase, and of the card in it.
    integer, intent(in) :: number, item
    type(diagnostics_type), intent(inout) :: diagnostics
    type(scene_type) :: scene
    type(seepage_type) :: flow
    type(error_type), allocatable :: error
    integer :: before

    associate (level => model%analysis%phases(number)%water_levels(item))
      before = diagnostics%count
      call check_scene(model%analysis, number, level, diagnostics)
      if (diagnostics%count > before) return
      call fit_scene(model%analysis, scene%mesh, scene%outlines, error)
      if (.not. allocated(error)) then
        call place_cells(model%analysis, number, scene, flow)
        call place_bounds(model%analysis, level, scene, flow, diagnostics)
        if (diagnostics%count > before) return
        call leave_dry(scene, flow)
        call solve_seepage(flow, error)
      end if
      if (allocated(error)) then
        call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', error%message, error%code)
        return
      end if
      allocate (level%field)
      call make_field(scene, flow, upwards(model%analysis), level%field)
      model%notes = model%notes//flow_notes(model%analysis, number, level, scene, flow)
    end associate
  end subroutine find_flow

  !> Flow is for plane scenes whose bodies are drawn, of soil whose permeability is known.
  subroutine check_scene(analysis, number, level, diagnostics)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number
    type(water_level_type), intent(in) :: level
    type(diagnostics_type), intent(inout) :: diagnostics
    logical :: active(size(analysis%bodies))
    integer :: material(size(analysis%bodies)), b

    if (analysis%model == three_dimensional .or. all(analysis%mesh%kind /= [mesh_grid, mesh_fitted])) then
      call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', 'TYPE=SEEPAGE is for plane strain and '// &
        'axisymmetry on a *GRID, whose lines say how large its triangles are')
      return
    end if
    active = bodies_active(analysis, number)
    material = body_materials(analysis, number)
    do b = 1, size(active)
      if (.not. active(b)) cycle
      if (all(analysis%bodies(b)%kind /= [body_box, body_polygon])) call add_diagnostic(diagnostics, level%where, &
        '*WATER LEVEL', "TYPE=SEEPAGE: body '"//analysis%bodies(b)%name//"' is neither a BOX nor a POLYGON")
      if (analysis%materials(material(b))%permeability(1) < 0.0_wp) call add_diagnostic(diagnostics, &
        analysis%materials(material(b))%where, '*MATERIAL', "water is to flow through body '"// &
        analysis%bodies(b)%name//"', but material '"//analysis%materials(material(b))%name// &
        "' has no *PERMEABILITY (0 for one that is tight)")
    end do
  end subroutine check_scene

  !> Cells that water flows through, and their permeability.
  subroutine place_cells(analysis, number, scene, flow)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number
    type(scene_type), intent(inout) :: scene
    type(seepage_type), intent(inout) :: flow
    logical :: active(size(analysis%bodies))
    integer :: material(size(analysis%bodies)), c

    active = bodies_active(analysis, number)
    material = body_materials(analysis, number)
    associate (mesh => scene%mesh)
      scene%size = maxval(maxval(mesh%position, dim=2) - minval(mesh%position, dim=2))
      allocate (scene%flows(size(mesh%region)))
      do c = 1, size(mesh%region)
        scene%flows(c) = mesh%region(c) > 0
        if (scene%flows(c)) scene%flows(c) = active(mesh%region(c))
      end do
      call keep_cells(analysis, scene, material, flow)
      flow%position = mesh%position
      allocate (flow%kind(size(mesh%position, 2)), source=node_free)
      allocate (flow%head(size(flow%kind)), flow%rain(size(flow%kind)), source=0.0_wp)
    end associate
    allocate (flow%height(size(flow%kind)), source=upwards(analysis)*scene%mesh%position(vertical_of(analysis), :))
    flow%suction = suction_of_cell*minval([(minval(analysis%mesh%axes(c)%lines(2:) &
      - analysis%mesh%axes(c)%lines(:size(analysis%mesh%axes(c)%lines) - 1)), c=1, 2)])
  end subroutine place_cells

  !> The cells of the flow.
  subroutine keep_cells(analysis, scene, material, flow)
    type(analysis_type), intent(in) :: analysis
    type(scene_type), intent(in) :: scene
    !> (bodies)
    integer, intent(in) :: material(:)
    type(seepage_type), intent(inout) :: flow
    integer, allocatable :: kept(:)
    real(wp) :: least
    integer :: c

    least = 1.0_wp
    do c = 1, size(analysis%materials)
      associate (k => analysis%materials(c)%permeability)
        if (all(k > 0.0_wp)) least = min(least, tight*minval(k))
      end associate
    end do
    kept = pack([(c, c=1, size(scene%flows))], scene%flows)
    flow%corner = scene%mesh%corner(:, kept)
    allocate (flow%permeability(2, size(kept)), flow%depth(size(kept)))
    do c = 1, size(kept)
      flow%permeability(:, c) = max(least, analysis%materials(material(scene%mesh%region(kept(c))))%permeability)
      flow%depth(c) = 1.0_wp
      if (analysis%model == axisymmetric) flow%depth(c) = sum(scene%mesh%position(1, flow%corner(:, c)))/3.0_wp
    end do
  end subroutine keep_cells

  !> Kinds and heads of the nodes on the bounds.
  subroutine place_bounds(analysis, level, scene, flow, diagnostics)
    type(analysis_type), intent(in) :: analysis
    type(water_level_type), intent(in) :: level
    type(scene_type), intent(inout) :: scene
    type(seepage_type), intent(inout) :: flow
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: c, k, i, ends(2)
    logical :: found(size(level%heads))
    integer :: axis
    real(wp) :: up

    axis = vertical_of(analysis)
    up = upwards(analysis)
    allocate (scene%row(size(flow%kind)), source=0)
    found = .false.
    do c = 1, size(scene%flows)
      do k = 1, 3
        if (.not. is_bound(scene, c, k)) cycle
        ends = scene%mesh%corner([modulo(k, 3) + 1, modulo(k + 1, 3) + 1], c)
        if (is_in_air(scene, axis, up, c, k)) where (flow%kind(ends) == node_free) flow%kind(ends) = node_face
        do i = 1, size(level%heads)
          if (.not. is_on(analysis, level%heads(i)%set, scene%mesh%region(c), scene%mesh%position(:, ends), &
            hair*scene%size)) cycle
          found(i) = .true.
          call give_head(upwards(analysis)*level%heads(i)%level, i, ends, scene, flow)
          call let_rain(analysis, level%heads(i), ends, flow)
        end do
      end do
    end do
    do i = 1, size(found)
      if (.not. found(i)) call place_drain(analysis, level%heads(i), i, scene, flow, found(i))
      if (.not. found(i)) call add_diagnostic(diagnostics, level%heads(i)%where, '*WATER LEVEL', &
        "neither an edge nor a node of the ground lies in '"//level%heads(i)%set//"'")
    end do
    where (flow%kind == node_head) flow%rain = 0.0_wp
    if (all(found) .and. .not. any(flow%kind == node_head .or. flow%rain > 0.0_wp)) &
      call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', &
      'every level lies below its part of the bounds: no water comes in')
  end subroutine place_bounds

  !> Rain on an edge, half of it for each end; what falls on free water is not counted.
  subroutine let_rain(analysis, head, ends, flow)
    type(analysis_type), intent(in) :: analysis
    type(head_type), intent(in) :: head
    integer, intent(in) :: ends(2)
    type(seepage_type), intent(inout) :: flow
    real(wp) :: breadth

    associate (x => flow%position(3 - vertical_of(analysis), ends))
      breadth = abs(x(2) - x(1))
      if (analysis%model == axisymmetric) breadth = breadth*sum(flow%position(1, ends))/2.0_wp
    end associate
    flow%rain(ends) = flow%rain(ends) + 0.5_wp*head%rain*breadth
  end subroutine let_rain

  !> A box within the ground is a well or a drain, no narrower than a cell: the nodes at it have the level, or let
  !> water go.
  subroutine place_drain(analysis, head, number, scene, flow, found)
    type(analysis_type), intent(in) :: analysis
    type(head_type), intent(in) :: head
    !> Of the row.
    integer, intent(in) :: number
    type(scene_type), intent(inout) :: scene
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

  !> The level of a row at the ends of an edge: below it water stands, above it there is a face.
  subroutine give_head(level, number, ends, scene, flow)
    real(wp), intent(in) :: level
    integer, intent(in) :: number, ends(2)
    type(scene_type), intent(inout) :: scene
    type(seepage_type), intent(inout) :: flow
    integer :: k

    do k = 1, 2
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

  !> Whether the edge of a cell opposite a corner bounds the ground that water flows through.
  pure logical function is_bound(scene, c, k)
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: c, k

    is_bound = scene%flows(c)
    if (.not. is_bound .or. scene%mesh%neighbour(k, c) == 0) return
    is_bound = .not. scene%flows(scene%mesh%neighbour(k, c))
  end function is_bound

  !> Whether there is air beyond: no side and no base of the grid and no rigid body.
  pure logical function is_in_air(scene, axis, up, c, k)
    type(scene_type), intent(in) :: scene
    !> Vertical axis and sense of upwards.
    integer, intent(in) :: axis
    real(wp), intent(in) :: up
    integer, intent(in) :: c, k
    real(wp) :: middle(2)
    integer :: o

    is_in_air = .false.
    associate (mesh => scene%mesh, beyond => scene%mesh%neighbour(k, c))
      if (beyond == 0) then
        is_in_air = all(up*(mesh%position(axis, mesh%corner([modulo(k, 3) + 1, modulo(k + 1, 3) + 1], c))) >= &
          maxval(up*mesh%position(axis, :)) - hair*scene%size)
        return
      end if
      middle = sum(mesh%position(:, mesh%corner(:, beyond)), dim=2)/3.0_wp
    end associate
    is_in_air = .true.
    do o = 1, size(scene%outlines)
      if (scene%outlines(o)%region == 0 .and. scene%outlines(o)%is_closed) &
        is_in_air = is_in_air .and. .not. polygon_contains(scene%outlines(o)%corner, middle)
    end do
  end function is_in_air

  !> Whether an edge of a body lies in a node set or a surface.
  pure logical function is_on(analysis, name, body, ends, near) result(on)
    type(analysis_type), intent(in) :: analysis
    character(len=*), intent(in) :: name
    !> Number of the body.
    integer, intent(in) :: body
    !> (2, 2)
    real(wp), intent(in) :: ends(:, :)
    real(wp), intent(in) :: near
    integer :: i

    on = .false.
    do i = 1, size(analysis%node_sets)
      associate (set => analysis%node_sets(i))
        if (set%name /= name) cycle
        if (set%selection == select_plane .and. set%axis < 3) &
          on = all(abs(ends(set%axis, :) - set%box(set%axis, 1)) <= near)
        if (set%selection == select_box) on = in_box(set%box, ends, near)
      end associate
    end do
    do i = 1, size(analysis%surfaces)
      associate (surface => analysis%surfaces(i))
        if (surface%name == name) on = on .or. is_on_surface(surface, analysis%bodies(body)%name, ends, near)
      end associate
    end do
  end function is_on

  !> Whether an edge of a body lies on a surface.
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

  !> Whether two places lie in a box.
  pure logical function in_box(box, ends, near)
    !> Lower and upper corner (3, 2).
    real(wp), intent(in) :: box(:, :), ends(:, :), near

    in_box = all(ends >= spread(box(:2, 1), 2, 2) - near) .and. all(ends <= spread(box(:2, 2), 2, 2) + near)
  end function in_box

  !> Take out the cells that no node with a head is joined to.
  subroutine leave_dry(scene, flow)
    type(scene_type), intent(inout) :: scene
    type(seepage_type), intent(inout) :: flow
    logical :: wet(size(flow%kind)), kept(size(flow%corner, 2))
    integer :: c, before

    wet = flow%kind == node_head .or. flow%rain > 0.0_wp
    do
      before = count(wet)
      do c = 1, size(flow%corner, 2)
        if (any(wet(flow%corner(:, c)))) wet(flow%corner(:, c)) = .true.
      end do
      do c = size(flow%corner, 2), 1, -1
        if (any(wet(flow%corner(:, c)))) wet(flow%corner(:, c)) = .true.
      end do
      if (count(wet) == before) exit
    end do
    kept = [(wet(flow%corner(1, c)), c=1, size(kept))]
    flow%corner = flow%corner(:, pack([(c, c=1, size(kept))], kept))
    flow%permeability = flow%permeability(:, pack([(c, c=1, size(kept))], kept))
    flow%depth = pack(flow%depth, kept)
    scene%flows = unpack(kept, scene%flows, .false.)
    where (.not. wet) flow%kind = node_free
  end subroutine leave_dry

  !> Heads all over the grid. Beyond the ground they are those of the nearest bounds, along edges: the level of free
  !> water, else what presses nowhere.
  subroutine make_field(scene, flow, up, field)
    type(scene_type), intent(in) :: scene
    type(seepage_type), intent(in) :: flow
    real(wp), intent(in) :: up
    type(seepage_field_type), intent(inout) :: field
    logical, dimension(size(flow%kind)) :: known, grown, free
    integer :: c, k

    allocate (field%position, source=scene%mesh%position)
    allocate (field%corner, source=scene%mesh%corner)
    allocate (field%head, source=flow%head)
    allocate (field%velocity(2, size(scene%flows)), source=0.0_wp)
    known = .false.
    free = flow%kind == node_head
    k = 0
    do c = 1, size(scene%flows)
      if (.not. scene%flows(c)) cycle
      k = k + 1
      field%velocity(:, c) = flow%velocity(:, k)
      known(field%corner(:, c)) = .true.
    end do
    where (known .and. flow%kind == node_face) field%head = min(field%head, flow%height)
    do
      grown = known
      do c = 1, size(field%corner, 2)
        associate (node => field%corner(:, c))
          if (all(known(node)) .or. .not. any(known(node))) cycle
          if (any(free(node))) then
            where (.not. grown(node)) field%head(node) = maxval(field%head(node), mask=free(node))
            free(node) = free(node) .or. .not. grown(node)
          else
            where (.not. grown(node)) field%head(node) = min(minval(field%head(node), mask=known(node)), &
              flow%height(node))
          end if
          grown(node) = .true.
        end associate
      end do
      if (all(grown .eqv. known)) exit
      known = grown
    end do
    field%head = up*field%head
    call index_triangles(field)
  end subroutine make_field

  !> What flows in and out by the rows of the card, and whether water lifts the soil where it leaves.
  function flow_notes(analysis, number, level, scene, flow) result(text)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number
    type(water_level_type), intent(in) :: level
    type(scene_type), intent(in) :: scene
    type(seepage_type), intent(in) :: flow
    character(len=:), allocatable :: text
    integer :: i

    text = "phase '"//analysis%phases(number)%name//"': water flows in by"
    do i = 1, size(level%heads)
      text = text//" '"//level%heads(i)%set//"' "//rounded_text(sum(flow%inflow, mask=scene%row == i), 4)//','
    end do
    text = text//' elsewhere '// &
      rounded_text(sum(flow%inflow, mask=scene%row == 0 .and. flow%kind == node_face), 4)// &
      ' (negative: out; a unit of time and '// &
      trim(merge('radian    ', 'unit width', analysis%model == axisymmetric))// &
      '); '//integer_text(size(flow%corner, 2))//' triangles, '//integer_text(flow%iterations)//' iterations, '// &
      'suction over a height of '//rounded_text(flow%suction, 2)//new_line('a')//lift_note(analysis, number, level, &
      scene, flow)
  end function flow_notes

  !> The warning of water that leaves the ground upwards by a gradient that lifts it; empty where there is none.
  function lift_note(analysis, number, level, scene, flow) result(text)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number
    type(water_level_type), intent(in) :: level
    type(scene_type), intent(in) :: scene
    type(seepage_type), intent(in) :: flow
    character(len=:), allocatable :: text
    integer :: material(size(analysis%bodies)), c, cell
    real(wp) :: gradient, critical, worst, place(2)
    integer :: axis

    text = ''
    material = body_materials(analysis, number)
    axis = vertical_of(analysis)
    worst = 1.0_wp
    cell = 0
    do c = 1, size(scene%flows)
      if (.not. scene%flows(c)) cycle
      cell = cell + 1
      associate (node => flow%corner(:, cell))
        if (.not. any(flow%inflow(node) < 0.0_wp .and. flow%kind(node) /= node_free)) cycle
      end associate
      associate (soil => analysis%materials(material(scene%mesh%region(c))))
        critical = merge(soil%saturated_weight, soil%unit_weight, soil%saturated_weight >= 0.0_wp)/level%unit_weight &
          - 1.0_wp
        gradient = upwards(analysis)*flow%velocity(axis, cell)/flow%permeability(axis, cell)
      end associate
      if (.not. gradient > worst*critical) cycle
      worst = gradient/critical
      place = sum(flow%position(:, flow%corner(:, cell)), dim=2)/3.0_wp
      text = "warning: phase '"//analysis%phases(number)%name//"': water leaves upwards by a gradient of "// &
        rounded_text(gradient, 3)//' at ('//rounded_text(place(1), 4)//', '//rounded_text(place(2), 4)// &
        '), where '//rounded_text(critical, 3)//' lifts the soil: piping begins there'//new_line('a')
    end do
  end function lift_note
end module qsmpm_seepage_scene
