!> Consolidation under an unknown phreatic surface: degree of saturation as a function of the pore pressure, pressure on
!> the skeleton, and boundary conditions of the water.
!>
!>   S = 1 for p >= 0,  1 + p/(gamma_w c) for -gamma_w c < p < 0,  0 below          c: height of the cells at a node
!>   or a curve of the soil (qsmpm_retention)
!>   pi = S p                                                       acts on the skeleton (Bishop 1959, chi = S)
!>
!> Below its level, a part of the boundary has the pressure of the free water, which also loads the faces there and the
!> adjacent exposed faces up to the level. Above it, and on all other exposed faces, water drains where p would be
!> positive. docs/methods/consolidation.md
module qsmpm_free_surface
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_covered_faces, only: is_covered
  use qsmpm_element, only: corner_count, face_area_vector, face_corners, face_count, face_rule, &
    linear_kind, shape_functions
  use qsmpm_free_water, only: beside_text, find_shores, shallow, shore_text, spread_water
  use qsmpm_load_description, only: head_type
  use qsmpm_load_path, only: between
  use qsmpm_mesh, only: mesh_type
  use qsmpm_model, only: model_type
  use qsmpm_phase_description, only: phase_type
  use qsmpm_phase_loads, only: consolidation_of, free_surface_of
  use qsmpm_phase_tree, only: lineage
  use qsmpm_retention, only: curve_type, take_up
  use qsmpm_vertical, only: upwards, vertical_of
  implicit none
  private

  public :: water_bounds_type, filling_pressure, kept_water, find_bounds, is_in_air, is_on, looks_up, &
    rows_in_force, former_levels, idle_rows, bounds_note, nodes_within

  !> Share of the pores that dry soil still drains per suction that empties the pores, beyond that suction.
  real(wp), parameter, public :: dry = 1.0e-3_wp
  !> Vertical share of the normal of a face above which it counts as facing upwards.
  real(wp), parameter :: upwards_from = 0.05_wp

  !> Boundary conditions of the water.
  type :: water_bounds_type
    !> Nodes that drain where the pressure exceeds that of the free water, and nodes of fixed pressure, at which water
    !> also enters (nodes).
    logical, allocatable :: open(:), held(:)
    !> Pressure of the free water, 0 at exposed faces; rain per unit of time (nodes).
    real(wp), allocatable :: pressure(:), rain(:)
    !> Row of *WATER LEVEL of a node, 0 for none (nodes).
    integer, allocatable :: row(:)
    !> Whether the free water of a row acts on adjacent faces, and the node where it ends next to ground below its
    !> level, 0 for none (rows).
    logical, allocatable :: beside(:)
    integer, allocatable :: shore(:)
    !> Force of the free water (dimension, nodes).
    real(wp), allocatable :: load(:, :)
  end type water_bounds_type

contains

  !> Returns the suction at which the pores at a node are empty: unit weight of water times the mean height of its cells
  !> (nodes).
  pure function filling_pressure(model) result(suction)
    type(model_type), intent(in) :: model
    real(wp) :: suction(model%mesh%node_count)
    real(wp) :: count(model%mesh%node_count)
    integer :: p, axis

    axis = vertical_of(model%analysis)
    suction = 0.0_wp
    count = 0.0_wp
    associate (mesh => model%mesh, points => model%state%points)
      do p = 1, points%count
        associate (c => points%cell(p))
          associate (node => mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c) - 1 + &
              corner_count(mesh%cell_kind(c))))
            count(node) = count(node) + points%volume(p)
            suction(node) = suction(node) + points%volume(p)*(maxval(mesh%coordinates(axis, node)) &
              - minval(mesh%coordinates(axis, node)))
          end associate
        end associate
      end do
    end associate
    suction = max(suction/max(count, tiny(1.0_wp)), tiny(1.0_wp))*model%analysis%phases(max(1, &
      consolidation_of(model%analysis%phases, model%state%progress%phase)))%consolidation%unit_weight
  end function filling_pressure

  !> Stored water as a share of the drainable pores: S, and for the linear law a small release of dry soil with growing
  !> suction, without which rain would change the pressure there discontinuously.
  elemental real(wp) function kept_water(curve, pressure, suction)
    type(curve_type), intent(in) :: curve
    !> Suction at which the pores are empty, or the smallest over which a curve is resolved.
    real(wp), intent(in) :: pressure, suction
    real(wp) :: slope

    call take_up(curve, pressure, suction, kept_water, slope)
    if (.not. curve%alpha > 0.0_wp) kept_water = kept_water + dry*min(0.0_wp, 1.0_wp + pressure/suction)
  end function kept_water

  !> Returns the levels in force at a fraction of the phase, interpolated linearly from the former ones.
  pure function rows_in_force(phases, number, fraction) result(rows)
    type(phase_type), intent(in) :: phases(:)
    !> Number of the phase.
    integer, intent(in) :: number
    real(wp), intent(in) :: fraction
    type(head_type), allocatable :: rows(:)
    integer :: k, from

    from = free_surface_of(phases, number)
    do k = 1, size(phases(from)%water_levels)
      if (phases(from)%water_levels(k)%coupled) rows = phases(from)%water_levels(k)%heads
    end do
    if (from == number) rows%level = between(former_levels(phases, number, rows), rows%level, fraction)
  end function rows_in_force

  !> Returns the levels of parts of the boundary in the flow before a phase; a new part has its own level.
  pure function former_levels(phases, number, rows) result(level)
    type(phase_type), intent(in) :: phases(:)
    integer, intent(in) :: number
    type(head_type), intent(in) :: rows(:)
    real(wp) :: level(size(rows))
    integer, allocatable :: line(:)
    integer :: i, k, r, h

    level = rows%level
    allocate (line, source=lineage(phases, number))
    do i = size(line) - 1, 1, -1
      do k = 1, size(phases(line(i))%water_levels)
        associate (before => phases(line(i))%water_levels(k))
          if (.not. before%flows) cycle
          do r = 1, size(rows)
            do h = 1, size(before%heads)
              if (before%heads(h)%set == rows(r)%set) level(r) = before%heads(h)%level
            end do
          end do
          return
        end associate
      end do
    end do
  end function former_levels

  !> Determines the boundary conditions at a fraction of the phase.
  pure subroutine find_bounds(model, open, fraction, bounds)
    type(model_type), intent(in) :: model
    !> Nodes of exposed faces (mesh nodes).
    logical, intent(in) :: open(:)
    real(wp), intent(in) :: fraction
    type(water_bounds_type), intent(out) :: bounds
    type(head_type), allocatable :: rows(:)
    !> Rows with faces of the ground, other than wells and drains, so far, and those without.
    logical, allocatable :: found(:), missing(:)
    logical :: filled(model%mesh%cell_count), air, given(6, model%mesh%cell_count)
    integer :: c, f, i, turn, wet(model%mesh%node_count)

    associate (mesh => model%mesh)
      allocate (bounds%open, source=open)
      allocate (bounds%held(mesh%node_count), source=.false.)
      allocate (bounds%row(mesh%node_count), source=0)
      allocate (bounds%pressure(mesh%node_count), bounds%rain(mesh%node_count), source=0.0_wp)
      allocate (bounds%load(mesh%dimension, mesh%node_count), source=0.0_wp)
      filled = .false.
      filled(model%state%points%cell) = .true.
      given = .false.
      wet = 0
      rows = rows_in_force(model%analysis%phases, model%state%progress%phase, fraction)
      found = [(.false., i=1, size(rows))]
      ! Faces under rigid bodies belong to a row that has no others, as of a drained wall.
      do turn = 1, 2
        missing = .not. found
        do c = 1, mesh%cell_count
          if (.not. filled(c)) cycle
          do f = 1, face_count(mesh%cell_kind(c))
            if (mesh%face_neighbour(f, c) > 0) then
              if (filled(mesh%face_neighbour(f, c))) cycle
            end if
            if (is_covered(model, c, f) .neqv. turn == 2) cycle
            air = is_in_air(model, filled, c, f)
            given(f, c) = .not. air
            do i = 1, size(rows)
              if (.not. missing(i)) cycle
              if (.not. is_on(model, rows(i)%set, c, f)) cycle
              found(i) = .true.
              call take_face(model, rows(i), i, c, f, bounds, loads=turn == 1)
              given(f, c) = .true.
              if (air) call wet_ends(model, rows(i), i, c, f, wet)
            end do
          end do
        end do
      end do
      do i = 1, size(rows)
        if (.not. found(i)) call take_ends(model, rows(i), i, nodes_within(model, rows(i)%set), bounds)
      end do
      call flood(model, rows, filled, given, wet, bounds)
    end associate
  end subroutine find_bounds

  !> Returns the corner nodes of filled cells in a node set: a well or a drain where the set has no face.
  pure function nodes_within(model, name) result(nodes)
    type(model_type), intent(in) :: model
    character(len=*), intent(in) :: name
    integer, allocatable :: nodes(:)
    logical :: corner(model%mesh%node_count)
    integer :: p, s

    corner = .false.
    associate (mesh => model%mesh)
      do p = 1, model%state%points%count
        associate (c => model%state%points%cell(p))
          corner(mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c) - 1 + corner_count(mesh%cell_kind(c)))) = .true.
        end associate
      end do
      allocate (nodes(0))
      do s = 1, size(mesh%node_sets)
        if (mesh%node_sets(s)%name == name) nodes = pack(mesh%node_sets(s)%items, corner(mesh%node_sets(s)%items))
      end do
    end associate
  end function nodes_within

  !> Applies the free water to adjacent exposed faces.
  pure subroutine flood(model, rows, filled, given, wet, bounds)
    type(model_type), intent(in) :: model
    type(head_type), intent(in) :: rows(:)
    !> Filled cells (cells), faces that belong to a row or are not exposed (faces, cells).
    logical, intent(in) :: filled(:), given(:, :)
    !> Row whose free water reaches a node, 0 for none (mesh nodes).
    integer, intent(inout) :: wet(:)
    type(water_bounds_type), intent(inout) :: bounds
    integer, allocatable :: faces(:, :), ends(:, :)
    real(wp) :: height(model%mesh%node_count), level(size(rows))
    type(head_type) :: row
    integer :: k, i

    call find_faces(model, filled, given, faces, ends)
    height = upwards(model%analysis)*model%mesh%coordinates(vertical_of(model%analysis), :)
    level = upwards(model%analysis)*rows%level
    call spread_water(ends, height, level, [(.false., k=1, size(wet))], wet)
    allocate (bounds%beside(size(rows)), source=.false.)
    do k = 1, size(ends, 2)
      i = maxval(wet(ends(:, k)))
      if (i == 0) cycle
      if (any(wet(ends(:, k)) == 0 .and. height(ends(:, k)) < level(i))) cycle
      row = rows(i)
      row%rain = 0.0_wp
      call take_face(model, row, i, faces(2, k), faces(1, k), bounds, loads=.true.)
      bounds%beside(i) = .true.
    end do
    allocate (bounds%shore, source=find_shores(ends(:, pack([(k, k=1, size(ends, 2))], &
      lets_through(model, faces(2, :)))), height, level, bounds%row, bounds%held))
  end subroutine flood

  !> Lists the exposed faces without a row and their end nodes; only faces of triangles are treated.
  pure subroutine find_faces(model, filled, given, faces, ends)
    type(model_type), intent(in) :: model
    logical, intent(in) :: filled(:), given(:, :)
    !> Face and cell, and nodes (2, faces).
    integer, allocatable, intent(out) :: faces(:, :), ends(:, :)
    integer :: c, f, n

    allocate (faces(2, 3*count(filled)), ends(2, 3*count(filled)))
    n = 0
    do c = 1, model%mesh%cell_count
      if (.not. filled(c)) cycle
      do f = 1, min(3, face_count(model%mesh%cell_kind(c)))
        if (given(f, c)) cycle
        if (.not. is_in_air(model, filled, c, f)) cycle
        n = n + 1
        faces(:, n) = [f, c]
        associate (corners => face_corners(model%mesh%cell_kind(c), f))
          ends(:, n) = model%mesh%cell_nodes(model%mesh%cell_first(c) - 1 + corners(:2))
        end associate
      end do
    end do
    faces = faces(:, :n)
    ends = ends(:, :n)
  end subroutine find_faces

  !> Checks whether the soil of cells is permeable.
  pure function lets_through(model, cells) result(through)
    type(model_type), intent(in) :: model
    integer, intent(in) :: cells(:)
    logical :: through(size(cells)), porous(model%mesh%cell_count)

    porous = .false.
    porous(pack(model%state%points%cell, model%analysis%materials(model%state%points%material)%permeability(1) > &
      0.0_wp)) = .true.
    through = porous(cells)
  end function lets_through

  !> Marks the corners of a face that are below the level of a row.
  pure subroutine wet_ends(model, row, number, c, f, wet)
    type(model_type), intent(in) :: model
    type(head_type), intent(in) :: row
    !> Number of the row, of the cell, and of its face.
    integer, intent(in) :: number, c, f
    integer, intent(inout) :: wet(:)
    integer :: i

    associate (ends => model%mesh%cell_nodes(model%mesh%cell_first(c) - 1 + &
        face_corners(model%mesh%cell_kind(c), f)))
      do i = 1, size(ends)
        if (free_pressure(model, row, model%mesh%coordinates(vertical_of(model%analysis), ends(i))) > 0.0_wp) &
          wet(ends(i)) = max(wet(ends(i)), number)
      end do
    end associate
  end subroutine wet_ends

  !> Checks whether a face is exposed: next to an empty cell, or facing upwards at the end of the mesh, and not covered
  !> by a rigid body.
  pure logical function is_in_air(model, filled, c, f) result(air)
    type(model_type), intent(in) :: model
    !> Filled cells (cells).
    logical, intent(in) :: filled(:)
    !> Number of the cell, and of its face.
    integer, intent(in) :: c, f

    if (model%mesh%face_neighbour(f, c) == 0) then
      air = looks_up(model, c, f)
    else
      air = .not. filled(model%mesh%face_neighbour(f, c))
    end if
    if (air) air = .not. is_covered(model, c, f)
  end function is_in_air

  !> Checks whether a face at the end of the mesh faces upwards and is free: a vertically fixed face is no ground
  !> surface (before the first phase nothing is fixed).
  pure logical function looks_up(model, c, f)
    type(model_type), intent(in) :: model
    !> Number of the cell, and of its face.
    integer, intent(in) :: c, f
    real(wp) :: out(model%mesh%dimension), along(model%mesh%dimension, 2)
    logical :: held
    integer :: axis, i

    axis = vertical_of(model%analysis)
    associate (mesh => model%mesh, first => model%mesh%cell_first(c) - 1)
      associate (node => mesh%cell_nodes(first + face_corners(mesh%cell_kind(c), f)), &
          all_nodes => mesh%cell_nodes(first + 1:first + corner_count(mesh%cell_kind(c))))
        held = .false.
        if (allocated(model%loading%constrained)) held = all(model%loading%constrained(axis, node))
        out = sum(mesh%coordinates(:, node), dim=2)/size(node) - sum(mesh%coordinates(:, all_nodes), dim=2) &
          /size(all_nodes)
        do i = 1, mesh%dimension - 1
          along(:, i) = mesh%coordinates(:, node(i + 1)) - mesh%coordinates(:, node(1))
          if (i == 2) along(:, 2) = off(along(:, 2), along(:, 1))
          out = off(out, along(:, i))
        end do
      end associate
    end associate
    looks_up = upwards(model%analysis)*out(axis) > upwards_from*norm2(out) .and. .not. held
  contains
    !> Component of a vector orthogonal to another one.
    pure function off(vector, other)
      real(wp), intent(in) :: vector(:), other(:)
      real(wp) :: off(size(vector))

      off = vector - dot_product(vector, other)/dot_product(other, other)*other
    end function off
  end function looks_up

  !> Marks the rows of the current phase that apply to no face.
  pure function idle_rows(model) result(idle)
    type(model_type), intent(in) :: model
    logical, allocatable :: idle(:)
    type(water_bounds_type) :: bounds
    integer :: r

    call find_bounds(model, [(.false., r=1, model%mesh%node_count)], 1.0_wp, bounds)
    allocate (idle, source=[(all(bounds%row /= r), r=1, size(rows_in_force(model%analysis%phases, &
      model%state%progress%phase, 1.0_wp)))])
  end function idle_rows

  !> Returns the notes on the levels of a phase: levels without a face of the ground, water on adjacent faces, and water
  !> that ends next to exposed ground; empty where there is nothing to report.
  pure function bounds_note(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    type(water_bounds_type) :: bounds
    type(head_type), allocatable :: rows(:)
    integer :: r

    text = ''
    associate (phases => model%analysis%phases, number => model%state%progress%phase)
      if (free_surface_of(phases, number) == 0) return
      call find_bounds(model, [(.false., r=1, model%mesh%node_count)], 1.0_wp, bounds)
      allocate (rows, source=rows_in_force(phases, number, 1.0_wp))
      do r = 1, size(rows)
        if (all(bounds%row /= r)) text = text//"warning: phase '"//phases(number)%name// &
          "': no face of the ground is in '"//rows(r)%set//"', and its level has no effect"//new_line('a')
        if (bounds%beside(r) .and. maxval(bounds%pressure, mask=bounds%row == r) > deep(model)) &
          text = text//beside_text(phases(number)%name, rows(r)%set)
        if (bounds%shore(r) > 0) text = text//shore_text(phases(number)%name, rows(r)%set, &
          model%mesh%coordinates(:2, bounds%shore(r)))
      end do
    end associate
  end function bounds_note

  !> Pressure of free water from which it is reported: ground that settles below the level is always slightly loaded.
  pure real(wp) function deep(model)
    type(model_type), intent(in) :: model
    integer :: axis

    axis = vertical_of(model%analysis)
    associate (phases => model%analysis%phases)
      deep = shallow*(model%mesh%bounds(axis, 2) - model%mesh%bounds(axis, 1)) &
        *phases(consolidation_of(phases, model%state%progress%phase))%consolidation%unit_weight
    end associate
  end function deep

  !> Checks whether a face is part of a node set or more than half covered by a surface, whose points move with the
  !> material; a surface that slightly overlaps an adjacent face at a corner does not count.
  pure logical function is_on(model, name, c, f)
    type(model_type), intent(in) :: model
    character(len=*), intent(in) :: name
    !> Number of the cell, and of its face.
    integer, intent(in) :: c, f
    real(wp) :: shape(8), covered, area
    integer :: s, i, k
    real(wp), parameter :: on_face = 1.0e-3_wp

    is_on = .false.
    associate (mesh => model%mesh, points => model%state%surface, kind => model%mesh%cell_kind(c))
      associate (corners => face_corners(kind, f))
        do s = 1, size(mesh%node_sets)
          if (mesh%node_sets(s)%name == name) is_on = all([(any(mesh%node_sets(s)%items == &
            mesh%cell_nodes(mesh%cell_first(c) - 1 + corners(k))), k=1, size(corners))])
        end do
        covered = 0.0_wp
        do i = 1, points%count
          if (points%cell(i) /= c .or. is_on) cycle
          if (model%analysis%surfaces(points%surface(i))%name /= name) cycle
          call shape_functions(linear_kind(kind), points%local(:, i), shape(:corner_count(kind)))
          if (sum(shape(corners)) < 1.0_wp - on_face) cycle
          area = norm2(points%area_vector(:, i))
          if (model%analysis%model == axisymmetric) area = area/points%position(1, i)
          covered = covered + area
        end do
        if (covered > 0.0_wp) is_on = covered > 0.5_wp*area_of_face(mesh, c, f)
      end associate
    end associate
  end function is_on

  !> Area of a face; in axisymmetry its length.
  pure real(wp) function area_of_face(mesh, c, f) result(total)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell, and of its face.
    integer, intent(in) :: c, f
    real(wp), allocatable :: place(:, :), weight(:)
    real(wp) :: area(mesh%dimension)
    integer :: q

    total = 0.0_wp
    call face_rule(mesh%cell_kind(c), f, 2, place, weight)
    do q = 1, size(weight)
      call face_area_vector(mesh%cell_kind(c), f, place(:, q), mesh%coordinates(:, mesh%cell_nodes(mesh%cell_first(c): &
        mesh%cell_first(c + 1) - 1)), area)
      total = total + weight(q)*norm2(area)
    end do
  end function area_of_face

  !> Adds level, load and rain of a row on a face; free water neither loads a face under a body nor falls on it.
  pure subroutine take_face(model, row, number, c, f, bounds, loads)
    type(model_type), intent(in) :: model
    type(head_type), intent(in) :: row
    !> Number of the row, of the cell, and of its face.
    integer, intent(in) :: number, c, f
    type(water_bounds_type), intent(inout) :: bounds
    logical, intent(in) :: loads
    real(wp), allocatable :: place(:, :), weight(:)
    real(wp) :: shape(20), at(model%mesh%dimension), area(model%mesh%dimension), depth
    integer :: axis, q, n
    integer, parameter :: degree = 9

    axis = vertical_of(model%analysis)
    associate (mesh => model%mesh, kind => model%mesh%cell_kind(c), first => model%mesh%cell_first(c))
      n = mesh%cell_first(c + 1) - first
      associate (node => mesh%cell_nodes(first:first + n - 1), &
          ends => mesh%cell_nodes(first - 1 + face_corners(kind, f)))
        call face_rule(kind, f, degree, place, weight)
        do q = 1, merge(size(weight), 0, loads)
          call shape_functions(kind, place(:, q), shape(:n))
          at = matmul(mesh%coordinates(:, node), shape(:n))
          call face_area_vector(kind, f, place(:, q), mesh%coordinates(:, node), area)
          depth = weight(q)
          if (model%analysis%model == axisymmetric) depth = weight(q)*at(1)
          bounds%load(:, node) = bounds%load(:, node) - depth*max(0.0_wp, free_pressure(model, row, at(axis))) &
            *spread(area, 2, n)*spread(shape(:n), 1, size(area))
          call shape_functions(linear_kind(kind), place(:, q), shape(:corner_count(kind)))
          associate (corner => node(:corner_count(kind)))
            bounds%rain(corner) = bounds%rain(corner) + row%rain*depth*abs(area(axis))*shape(:corner_count(kind))
          end associate
        end do
        call take_ends(model, row, number, ends, bounds)
      end associate
    end associate
  end subroutine take_face

  !> Applies a level at the corners of a face.
  pure subroutine take_ends(model, row, number, ends, bounds)
    type(model_type), intent(in) :: model
    type(head_type), intent(in) :: row
    !> Number of the row, and of the corners.
    integer, intent(in) :: number, ends(:)
    type(water_bounds_type), intent(inout) :: bounds
    real(wp) :: pressure
    integer :: i

    do i = 1, size(ends)
      pressure = free_pressure(model, row, model%mesh%coordinates(vertical_of(model%analysis), ends(i)))
      if (bounds%held(ends(i)) .and. pressure < bounds%pressure(ends(i))) cycle
      bounds%row(ends(i)) = number
      bounds%open(ends(i)) = .true.
      bounds%held(ends(i)) = bounds%held(ends(i)) .or. pressure >= 0.0_wp
      bounds%pressure(ends(i)) = max(0.0_wp, pressure)
    end do
  end subroutine take_ends

  !> Pressure of the free water at a height, negative above its level.
  pure real(wp) function free_pressure(model, row, height) result(pressure)
    type(model_type), intent(in) :: model
    type(head_type), intent(in) :: row
    real(wp), intent(in) :: height

    associate (phases => model%analysis%phases)
      pressure = phases(consolidation_of(phases, model%state%progress%phase))%consolidation%unit_weight &
        *upwards(model%analysis)*(row%level - height)
    end associate
  end function free_pressure
end module qsmpm_free_surface
