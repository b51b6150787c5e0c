!> Generates the background of *GRID, FIT=YES: triangles whose edges conform to the initial outlines of bodies and
!> rigid bodies, including those of later phases, and to node sets along a line or plane in the soil. Nodes are placed
!> where a set or a surface ends on an outline.
!>
!> The mesh is refined at points of singular stress, where failure begins: re-entrant corners of the soil, such as the
!> toe of a slope, the bottom of an excavation or the edge of a fill, and ends of loaded surfaces. The refinement
!> halves the error of a factor of safety at the same cost (docs/methods/fitted.md). Next to nodes with prescribed
!> displacement, cells are two to four times as wide as the displacement: soil at an edge inverts smaller cells, and
!> the run could then not continue with splines. There is no refinement next to an edge in frictional soil whose
!> strength hardly supports the weight of a cell, since the surface there has no strength. Cells are nowhere smaller
!> than the settlement of soil of that stiffness under its own weight, or four times that under the applied load.
module qsmpm_fitted_background
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_description, only: body_box, body_polygon
  use qsmpm_mesh_description, only: select_box, select_plane
  use qsmpm_method_description, only: basis_fem
  use qsmpm_structures, only: rigid_box, rigid_circle, rigid_polygon
  use qsmpm_element, only: element_from_name, element_order, tri3
  use qsmpm_error, only: error_type
  use qsmpm_fitted_mesh, only: fit_triangles, fitted_mesh_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mid_nodes, only: add_mid_nodes
  use qsmpm_outline_graph, only: outline_type
  use qsmpm_phase_description, only: initial_k0
  use qsmpm_polygon, only: polygon_contains
  use qsmpm_vertical, only: vertical_of
  use qsmpm_active_bodies, only: bodies_active
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_material_description, only: material_type, may_yield, traits_of
  implicit none
  private

  public :: fit_background, fit_scene

  !> Maximum number of times that narrow parts halve the cells of the grid.
  integer, parameter :: halvings = 3
  !> Number of chords of a circle.
  integer, parameter :: chords = 64
  !> Fraction of an edge within which a box touches it.
  real(wp), parameter :: touching = 1.0e-9_wp
  !> Fraction of a grid cell below which the part of an edge inside a box is treated as a point.
  real(wp), parameter :: a_place = 0.2_wp

  !> Number of directions checked around a corner; minimum number of them in soil for a re-entrant corner, which
  !> exceeds a half by 20 degrees; angle of the first, which is parallel to no edge.
  integer, parameter :: directions = 72, inwards = 40
  real(wp), parameter :: turn = 0.0123_wp
  !> Sine of the angle up to which an outline is straight.
  real(wp), parameter :: straight = 0.17_wp
  !> Distance of the checked points, relative to the smallest spacing of the grid.
  real(wp), parameter :: near = 1.0e-3_wp
  !> Maximum ratio of cell width to prescribed displacement next to displacement-controlled nodes; the minimum is half.
  real(wp), parameter :: ways_of_cell = 4.0_wp
  !> Ratio of cohesion to the weight of a cell from which the surface next to a displacement-controlled edge is stable.
  real(wp), parameter :: weights_of_cell = 2.0_wp

contains

  !> Generates the body-fitted mesh of an analysis.
  subroutine fit_background(analysis, mesh, error)
    type(analysis_type), intent(in) :: analysis
    !> Nodes and cells, no topology.
    type(mesh_type), intent(out) :: mesh
    !> Set when the mesh cannot conform to the outlines.
    type(error_type), allocatable, intent(out) :: error
    type(fitted_mesh_type) :: fitted
    type(outline_type), allocatable :: outlines(:)
    integer :: i, kind

    call fit_scene(analysis, fitted, outlines, error)
    if (allocated(error)) return
    associate (x => analysis%mesh%axes(1)%lines, y => analysis%mesh%axes(2)%lines)
      mesh%bounds = reshape([x(1), y(1), x(size(x)), y(size(y))], [2, 2])
    end associate
    mesh%dimension = 2
    mesh%is_box = .true.
    mesh%node_count = size(fitted%position, 2)
    mesh%coordinates = fitted%position
    mesh%cell_count = size(fitted%corner, 2)
    mesh%cell_nodes = reshape(fitted%corner, [size(fitted%corner)])
    mesh%cell_first = [(3*i + 1, i=0, mesh%cell_count)]
    allocate (mesh%cell_kind(mesh%cell_count), source=tri3)
    kind = element_from_name(analysis%mesh%element)
    if (element_order(kind) == 2) call add_mid_nodes(kind, mesh)
    mesh%node_label = [(i, i=1, mesh%node_count)]
    mesh%cell_label = [(i, i=1, mesh%cell_count)]
  end subroutine fit_background

  !> Returns the triangles, with the body number of each, and the outlines; those of rigid bodies have region 0.
  subroutine fit_scene(analysis, fitted, outlines, error)
    type(analysis_type), intent(in) :: analysis
    type(fitted_mesh_type), intent(out) :: fitted
    type(outline_type), allocatable, intent(out) :: outlines(:)
    !> Set when the mesh cannot conform to the outlines.
    type(error_type), allocatable, intent(out) :: error
    real(wp), allocatable :: boxes(:, :), corners(:, :)
    real(wp) :: spacing

    call outlines_of(analysis, outlines)
    associate (x => analysis%mesh%axes(1)%lines, y => analysis%mesh%axes(2)%lines)
      spacing = min(minval(x(2:) - x(:size(x) - 1)), minval(y(2:) - y(:size(y) - 1)))
      call add_ends(analysis, spacing, outlines)
      allocate (corners, source=singular_corners(analysis, outlines, spacing))
      call add_set_lines(analysis, a_place*spacing, outlines)
      call add_levels(analysis, outlines)
      allocate (boxes(5, size(corners, 2)), source=corners([1, 1, 2, 2, 3], :))
      if (allocated(analysis%mesh%refined)) boxes = reshape([boxes, analysis%mesh%refined], &
        [5, size(boxes, 2) + size(analysis%mesh%refined, 2)])
      call fit_triangles(x, y, outlines, halvings, fitted, error, boxes)
    end associate
  end subroutine fit_scene

  !> Returns the outlines of bodies and rigid bodies in the order of the deck; later ones cover earlier ones.
  pure subroutine outlines_of(analysis, outlines)
    type(analysis_type), intent(in) :: analysis
    type(outline_type), allocatable, intent(out) :: outlines(:)
    integer :: i, n

    allocate (outlines(size(analysis%bodies) + size(analysis%rigid_bodies)))
    n = 0
    do i = 1, size(analysis%bodies)
      associate (body => analysis%bodies(i))
        select case (body%kind)
        case (body_box)
          call add_outline(outlines, n, body%name, i, box_corners(body%box))
        case (body_polygon)
          call add_outline(outlines, n, body%name, i, body%polygon)
        end select
      end associate
    end do
    do i = 1, size(analysis%rigid_bodies)
      associate (body => analysis%rigid_bodies(i))
        select case (body%shape)
        case (rigid_box)
          call add_outline(outlines, n, body%name, 0, box_corners(body%box))
        case (rigid_polygon)
          call add_outline(outlines, n, body%name, 0, body%polygon)
        case (rigid_circle)
          ! Cells that move with the soil have no edges on a circle that touches them at one place.
          if (body%in_place .or. analysis%method%basis /= basis_fem) &
            call add_outline(outlines, n, body%name, 0, circle_corners(body%place, body%radius))
        end select
      end associate
    end do
    outlines = outlines(:n)
  end subroutine outlines_of

  !> Adds hydrostatic water levels across the grid in soil with K0 stresses: the stresses have a kink there, and cells
  !> that contain the level are not in equilibrium.
  pure subroutine add_levels(analysis, outlines)
    type(analysis_type), intent(in) :: analysis
    type(outline_type), allocatable, intent(inout) :: outlines(:)
    type(outline_type) :: line
    integer :: p, i, n

    line%name = '*WATER LEVEL'
    line%is_closed = .false.
    if (.not. allocated(analysis%phases)) return
    do p = 1, size(analysis%phases)
      if (analysis%phases(p)%initial%kind /= initial_k0) cycle
      do i = 1, size(analysis%phases(p)%water_levels)
        associate (level => analysis%phases(p)%water_levels(i), x => analysis%mesh%axes(1)%lines, &
            y => analysis%mesh%axes(2)%lines)
          n = size(level%line, 2)
          if (n == 0 .or. vertical_of(analysis) /= 2) cycle
          if (minval(level%line(2, :)) <= y(1) .or. maxval(level%line(2, :)) >= y(size(y))) cycle
          if (minval(level%line(1, :)) < x(1) .or. maxval(level%line(1, :)) > x(size(x))) cycle
          line%corner = reshape([x(1), level%line(2, 1), level%line, x(size(x)), level%line(2, n)], [2, n + 2])
          if (.not. level%line(1, 1) > x(1)) line%corner = line%corner(:, 2:)
          if (.not. level%line(1, n) < x(size(x))) line%corner = line%corner(:, :size(line%corner, 2) - 1)
          if (size(line%corner, 2) > 1) outlines = [outlines, line]
        end associate
      end do
    end do
  end subroutine add_levels

  !> Adds the points where the boxes of sets and surfaces end on outlines.
  pure subroutine add_ends(analysis, spacing, outlines)
    type(analysis_type), intent(in) :: analysis
    !> Smallest spacing of the grid.
    real(wp), intent(in) :: spacing
    type(outline_type), allocatable, intent(inout) :: outlines(:)
    integer :: i, drawn

    drawn = size(outlines)
    do i = 1, size(analysis%node_sets)
      if (analysis%node_sets(i)%selection == select_box) &
        call cut_outlines(analysis%node_sets(i)%name, analysis%node_sets(i)%box, a_place*spacing, drawn, outlines)
    end do
    do i = 1, size(analysis%surfaces)
      if (analysis%surfaces(i)%boxed .or. analysis%surfaces(i)%selection == select_box) &
        call cut_outlines(analysis%surfaces(i)%name, analysis%surfaces(i)%box, a_place*spacing, drawn, outlines)
    end do
  end subroutine add_ends

  !> Adds node sets along a line or plane that is not part of an outline, such as a wall that extends below an
  !> excavation.
  pure subroutine add_set_lines(analysis, shortest, outlines)
    type(analysis_type), intent(in) :: analysis
    !> Minimum length of a line that is not treated as a point.
    real(wp), intent(in) :: shortest
    type(outline_type), allocatable, intent(inout) :: outlines(:)
    type(outline_type) :: line
    real(wp) :: box(2, 2)
    integer :: i, drawn

    drawn = size(outlines)
    line%is_closed = .false.
    do i = 1, size(analysis%node_sets)
      associate (set => analysis%node_sets(i), x => analysis%mesh%axes(1)%lines, y => analysis%mesh%axes(2)%lines)
        if (all(set%selection /= [select_box, select_plane])) cycle
        line%name = set%name
        box = set%box(:2, :)
        if (set%selection == select_plane) box(3 - set%axis, :) = huge(box)*[-1, 1]
        if (set%selection == select_plane) box(set%axis, 2) = box(set%axis, 1)
        line%corner = reshape([max(box(1, 1), x(1)), max(box(2, 1), y(1)), min(box(1, 2), x(size(x))), &
          min(box(2, 2), y(size(y)))], [2, 2])
        associate (along => line%corner(:, 2) - line%corner(:, 1), inside => [line%corner(1, 1) > x(1) .and. &
            line%corner(1, 2) < x(size(x)), line%corner(2, 1) > y(1) .and. line%corner(2, 2) < y(size(y))])
          if (minval(abs(along)) > touching*maxval(abs(along)) .or. maxval(along) < shortest) cycle
          if (.not. inside(minloc(abs(along), dim=1))) cycle
        end associate
        if (.not. is_drawn(line%corner, set%selection == select_plane, outlines(:drawn))) outlines = [outlines, line]
      end associate
    end do
  end subroutine add_set_lines

  !> Returns whether a line is on outlines over its full length, or a plane wherever there is a body on both sides of
  !> it.
  pure logical function is_drawn(line, in_ground, outlines)
    !> End points (2, 2).
    real(wp), intent(in) :: line(:, :)
    !> Whether the set is a plane.
    logical, intent(in) :: in_ground
    type(outline_type), intent(in) :: outlines(:)
    integer, parameter :: samples = 64
    real(wp) :: place(2, 2), along(2), share(2), aside(2)
    logical :: met, beside(2)
    integer :: o, i, k

    is_drawn = .true.
    aside = 1.0e-4_wp/samples*(line([2, 1], 2) - line([2, 1], 1))
    do k = 1, samples
      place = spread(line(:, 1) + (k - 0.5_wp)/samples*(line(:, 2) - line(:, 1)), 2, 2)
      beside = .not. in_ground
      do o = 1, size(outlines)
        if (outlines(o)%region > 0) beside = beside .or. [polygon_contains(outlines(o)%corner, place(:, 1) + aside), &
          polygon_contains(outlines(o)%corner, place(:, 1) - aside)]
      end do
      met = .not. all(beside)
      do o = 1, size(outlines)
        do i = 1, size(outlines(o)%corner, 2)
          along = outlines(o)%corner(:, modulo(i, size(outlines(o)%corner, 2)) + 1) - outlines(o)%corner(:, i)
          share = shares_inside(outlines(o)%corner(:, i), along, place)
          met = met .or. share(1) <= share(2)
        end do
      end do
      is_drawn = is_drawn .and. met
    end do
  end function is_drawn

  !> Adds the points where a box intersects the edges of the first outlines.
  pure subroutine cut_outlines(name, box, shortest, drawn, outlines)
    character(len=*), intent(in) :: name
    !> Lower and upper corner (3, 2).
    real(wp), intent(in) :: box(:, :)
    !> Minimum length of an edge part that is not treated as a point: a box around a corner selects its node.
    real(wp), intent(in) :: shortest
    integer, intent(in) :: drawn
    type(outline_type), allocatable, intent(inout) :: outlines(:)
    type(outline_type) :: place
    real(wp) :: share(2), a(2), along(2)
    integer :: o, i, k

    place%name = name
    do o = 1, drawn
      do i = 1, size(outlines(o)%corner, 2)
        a = outlines(o)%corner(:, i)
        along = outlines(o)%corner(:, modulo(i, size(outlines(o)%corner, 2)) + 1) - a
        share = shares_inside(a, along, box(:2, :))
        if ((share(2) - share(1))*norm2(along) < shortest) cycle
        do k = 1, 2
          if (share(k) <= 0.0_wp .or. share(k) >= 1.0_wp) cycle
          place%corner = reshape(a + share(k)*along, [2, 1])
          outlines = [outlines, place]
        end do
      end do
    end do
  end subroutine cut_outlines

  !> Returns the fractions of its length at which a straight line enters and leaves a box; the first is the larger one
  !> if the line misses the box.
  pure function shares_inside(from, along, box) result(share)
    real(wp), intent(in) :: from(2), along(2), box(2, 2)
    real(wp) :: share(2), ends(2), slack
    integer :: d

    share = [0.0_wp, 1.0_wp]
    slack = touching*norm2(along)
    do d = 1, 2
      if (abs(along(d)) > slack) then
        ends = (box(d, :) - from(d))/along(d)
        share = [max(share(1), minval(ends)), min(share(2), maxval(ends))]
      else if (from(d) < box(d, 1) - slack .or. from(d) > box(d, 2) + slack) then
        share = [1.0_wp, 0.0_wp]
      end if
    end do
  end function shares_inside

  pure subroutine add_outline(outlines, n, name, region, corner)
    type(outline_type), intent(inout) :: outlines(:)
    integer, intent(inout) :: n
    character(len=*), intent(in) :: name
    integer, intent(in) :: region
    real(wp), intent(in) :: corner(:, :)

    n = n + 1
    outlines(n)%name = name
    outlines(n)%region = region
    outlines(n)%corner = corner
  end subroutine add_outline

  !> Returns the corners of a box, counter-clockwise.
  pure function box_corners(box) result(corner)
    !> Lower and upper corner (3, 2).
    real(wp), intent(in) :: box(:, :)
    real(wp) :: corner(2, 4)

    corner(1, :) = box(1, [1, 2, 2, 1])
    corner(2, :) = box(2, [1, 1, 2, 2])
  end function box_corners

  !> Returns the corners of a polygon inscribed in a circle.
  pure function circle_corners(place, radius) result(corner)
    real(wp), intent(in) :: place(:), radius
    real(wp) :: corner(2, chords)
    integer :: i

    do i = 1, chords
      corner(:, i) = place(:2) + radius*[cos(8.0_wp*atan(1.0_wp)*i/chords), sin(8.0_wp*atan(1.0_wp)*i/chords)]
    end do
  end function circle_corners

  !> Returns the singular points in soil that can yield, with the minimum cell width there, 0 for no limit (3, n).
  pure function singular_corners(analysis, outlines, spacing) result(places)
    type(analysis_type), intent(in) :: analysis
    !> Outlines of bodies, whose region is the body number, and end points of sets and surfaces.
    type(outline_type), intent(in) :: outlines(:)
    !> Smallest spacing of the grid.
    real(wp), intent(in) :: spacing
    real(wp), allocatable :: places(:, :)
    logical :: active(size(analysis%bodies)), found
    real(wp) :: width, load
    integer :: o, i, p

    allocate (places(3, 0))
    width = ways_of_cell*way_of_nodes(analysis)
    if (.not. any(may_yield(analysis%materials)) .or. width >= spacing) return
    if (width > 0.0_wp .and. .not. all(stands(analysis%materials, spacing))) return
    ! Largest load on a surface.
    load = 0.0_wp
    do p = 1, size(analysis%phases)
      associate (phase => analysis%phases(p))
        do i = 1, size(phase%tractions)
          load = max(load, abs(phase%load_factor)*max(norm2(phase%tractions(i)%vector), &
            abs(phase%tractions(i)%pressure)))
        end do
      end associate
    end do
    width = max(width, maxval(own_settlement(analysis%materials, depth_of(outlines), load)))
    do o = 1, size(outlines)
      do i = 1, size(outlines(o)%corner, 2)
        associate (corner => outlines(o)%corner(:, i))
          found = size(outlines(o)%corner, 2) == 1
          if (found) found = is_loaded(analysis, outlines(o)%name)
          do p = 1, size(analysis%phases)
            if (found .or. outlines(o)%region == 0) exit
            if (.not. bends(outlines(o)%corner, i)) exit
            active = bodies_active(analysis, p)
            found = turns_inwards(outlines, active, corner, near*spacing)
          end do
          if (found) places = reshape([places, corner, width], [3, size(places, 2) + 1])
        end associate
      end do
    end do
  end function singular_corners

  !> Returns whether an outline bends at a corner by more than a chord of a circle. A re-entrant corner of the soil is
  !> such a corner of some body, and an outline of thousands of corners has few of them.
  pure logical function bends(corners, i)
    real(wp), intent(in) :: corners(:, :)
    integer, intent(in) :: i
    real(wp) :: before(2), behind(2)
    integer :: n

    n = size(corners, 2)
    before = corners(:, i) - corners(:, modulo(i - 2, n) + 1)
    behind = corners(:, modulo(i, n) + 1) - corners(:, i)
    bends = abs(before(1)*behind(2) - before(2)*behind(1)) > straight*norm2(before)*norm2(behind) &
      .or. dot_product(before, behind) < 0.0_wp
  end function bends

  !> Returns whether more than half of the surroundings of a corner, but not all of it, is soil.
  pure logical function turns_inwards(outlines, active, corner, radius)
    type(outline_type), intent(in) :: outlines(:)
    !> Whether each body is active.
    logical, intent(in) :: active(:)
    real(wp), intent(in) :: corner(2), radius
    real(wp) :: angle
    integer :: k, o, full
    logical :: soil

    full = 0
    do k = 1, directions
      angle = turn + 8.0_wp*atan(1.0_wp)*k/directions
      soil = .false.
      do o = 1, size(outlines)
        if (outlines(o)%region == 0) cycle
        ! A body covers the bodies defined before it.
        if (polygon_contains(outlines(o)%corner, corner + radius*[cos(angle), sin(angle)])) &
          soil = active(outlines(o)%region)
      end do
      if (soil) full = full + 1
    end do
    turns_inwards = full >= inwards .and. full < directions
  end function turns_inwards

  !> Returns whether the surface of a material is stable by cohesion.
  elemental logical function stands(material, spacing)
    type(material_type), intent(in) :: material
    real(wp), intent(in) :: spacing
    type(law_description_type) :: traits

    traits = traits_of(material)
    stands = .not. traits%friction_angle > 0.0_wp .or. traits%cohesion >= weights_of_cell*material%unit_weight*spacing
  end function stands

  !> Returns the settlement of a layer of soil that can yield, g D^2/(2 E) under its own weight or four times q D/E
  !> under a load; 0 if its law has no E.
  elemental real(wp) function own_settlement(material, depth, load) result(settlement)
    type(material_type), intent(in) :: material
    real(wp), intent(in) :: depth, load

    settlement = 0.0_wp
    if (may_yield(material) .and. material%young > 0.0_wp) &
      settlement = max(0.5_wp*material%unit_weight*depth, ways_of_cell*load)*depth/material%young
  end function own_settlement

  !> Returns the smaller extent of the bodies, taken as the depth of the soil whatever the vertical direction.
  pure real(wp) function depth_of(outlines) result(depth)
    type(outline_type), intent(in) :: outlines(:)
    real(wp) :: low(2), high(2)
    integer :: o

    low = huge(low)
    high = -huge(high)
    do o = 1, size(outlines)
      if (outlines(o)%region == 0) cycle
      low = min(low, minval(outlines(o)%corner, dim=2))
      high = max(high, maxval(outlines(o)%corner, dim=2))
    end do
    depth = max(0.0_wp, minval(high - low))
  end function depth_of

  !> Returns the sum of the prescribed displacements of all phases.
  pure real(wp) function way_of_nodes(analysis) result(way)
    type(analysis_type), intent(in) :: analysis
    integer :: p

    way = 0.0_wp
    do p = 1, size(analysis%phases)
      way = way + maxval([0.0_wp, abs(analysis%phases(p)%load_factor*analysis%phases(p)%prescriptions%value)])
    end do
  end function way_of_nodes

  !> Returns whether a phase loads the surface or prescribes displacements of the set of this name.
  pure logical function is_loaded(analysis, name) result(loaded)
    type(analysis_type), intent(in) :: analysis
    character(len=*), intent(in) :: name
    integer :: p, i

    loaded = .false.
    do p = 1, size(analysis%phases)
      associate (phase => analysis%phases(p))
        loaded = loaded .or. any([(phase%tractions(i)%surface == name .and. .not. phase%tractions(i)%of_water, &
          i=1, size(phase%tractions))]) .or. any([(phase%prescriptions(i)%set == name .and. &
          abs(phase%prescriptions(i)%value) > 0.0_wp, i=1, size(phase%prescriptions))])
      end associate
    end do
  end function is_loaded
end module qsmpm_fitted_background
