!> Body-fitted triangular mesh from the initial geometry: the sequence of its steps, and the regions of the cells.
module qsmpm_fitted_mesh
  use qsmpm_kinds, only: wp, long, pi
  use qsmpm_edge_division, only: ask_of_features, divide_edges, find_wedges
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_lattice, only: lattice_place, make_lattice, plane_place
  use qsmpm_leaf_sizes, only: ask_in_box, balance_leaves, leaf_places, make_leaf_sizes
  use qsmpm_line_recovery, only: recover_line
  use qsmpm_outline_graph, only: make_outline_graph, outline_type, outline_graph_type
  use qsmpm_polygon, only: polygon_contains
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_spatial_lists, only: list_by_box
  use qsmpm_triangle_refinement, only: refined_scene_type, is_dictated, refine_triangles
  use qsmpm_triangulation, only: insert_node, restore_delaunay, signed_area, start_triangulation, triangulation_type, &
    cells_around, edge_squares, next_of, place_in_cell
  implicit none
  private

  public :: fitted_mesh_type, fit_triangles

  !> Distance relative to the width of a leaf below which its point is too near to an edge.
  real(wp), parameter :: near = 0.55_wp

  type :: fitted_mesh_type
    !> Coordinates (2, nodes).
    real(wp), allocatable :: position(:, :)
    !> Nodes counter-clockwise; adjacent cells, and edges of the graph, opposite each corner, 0 for none (3, cells).
    integer, allocatable :: corner(:, :), neighbour(:, :), line(:, :)
    !> Region of the outline that contains each cell, 0 outside of all (cells).
    integer, allocatable :: region(:)
    !> Smallest angle of each cell, radians.
    real(wp), allocatable :: angle(:)
    !> Whether the smallest angle is that of an acute corner of the outlines, or of a cell across one (cells).
    logical, allocatable :: is_dictated(:)
    type(outline_graph_type) :: graph
  end type fitted_mesh_type

  !> Number of smoothing passes over all nodes, and angle above which a cell is not improved.
  integer, parameter :: passes = 4
  real(wp), parameter :: good = 40.0_wp*pi/180.0_wp

contains

  !> Generates the mesh of a box.
  pure subroutine fit_triangles(x, y, outlines, levels, mesh, error, boxes)
    !> Grid lines, increasing, at least two each: they define the box and the size of the triangles.
    real(wp), intent(in) :: x(:), y(:)
    type(outline_type), intent(in) :: outlines(:)
    !> Number of halvings by which features may refine the size given by the grid.
    integer, intent(in) :: levels
    type(fitted_mesh_type), intent(out) :: mesh
    !> Outlines that cannot be meshed, by name and place.
    type(error_type), allocatable, intent(out) :: error
    !> Boxes as smallest and largest x and y, and the required size in each (5, n).
    real(wp), intent(in), optional :: boxes(:, :)
    type(refined_scene_type) :: scene
    real(wp) :: box(2, 2)
    integer :: i

    box = reshape([x(1), y(1), x(size(x)), y(size(y))], [2, 2])
    call make_leaf_sizes(scene%sizes, x, y, levels)
    call make_outline_graph(box, outlines, scene%sizes, scene%graph, error)
    if (allocated(error)) return
    call ask_of_features(scene%graph, scene%sizes)
    if (present(boxes)) then
      do i = 1, size(boxes, 2)
        call ask_in_box(scene%sizes, boxes([1, 3], i), boxes([2, 4], i), boxes(5, i))
      end do
    end if
    call balance_leaves(scene%sizes)
    scene%lattice = make_lattice(box)
    call find_wedges(scene%graph, scene%wedges)
    call lay_edges(scene, error)
    if (allocated(error)) return
    call lay_interior(scene)
    call refine_triangles(scene)
    call smooth_triangles(scene%t, scene%lies_on)
    call take_mesh(scene, mesh)
    call find_regions(scene, outlines, mesh)
    call look_for_lost(outlines, mesh, error)
  end subroutine fit_triangles

  !> Inserts nodes and lines of the graph.
  pure subroutine lay_edges(scene, error)
    type(refined_scene_type), intent(inout) :: scene
    !> Edges that cross on the lattice.
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: first(:), node(:)
    real(wp), allocatable :: share(:)
    integer :: e, i, n, last
    logical :: crossed

    call divide_edges(scene%graph, scene%wedges, scene%sizes, first, share)
    n = size(scene%graph%vertex, 2) + size(share)
    call start_triangulation(scene%t, scene%lattice%extent, 2*n + scene%sizes%count)
    allocate (scene%node_at(size(scene%graph%vertex, 2)), node(size(share)))
    allocate (scene%lies_on(size(scene%t%node, 2)), source=0)
    do i = 1, size(scene%node_at)
      call insert_node(scene%t, lattice_place(scene%lattice, scene%graph%vertex(:, i)), scene%node_at(i))
      scene%lies_on(scene%node_at(i)) = -i
    end do
    do e = 1, size(scene%graph%ends, 2)
      associate (a => scene%graph%vertex(:, scene%graph%ends(1, e)), b => scene%graph%vertex(:, scene%graph%ends(2, e)))
        do i = first(e), first(e + 1) - 1
          call insert_node(scene%t, lattice_place(scene%lattice, a + share(i)*(b - a)), node(i))
          scene%lies_on(node(i)) = e
        end do
      end associate
    end do
    do e = 1, size(scene%graph%ends, 2)
      last = scene%node_at(scene%graph%ends(1, e))
      do i = first(e), first(e + 1)
        n = scene%node_at(scene%graph%ends(2, e))
        if (i < first(e + 1)) n = node(i)
        call recover_line(scene%t, last, n, e, crossed)
        if (crossed) then
          associate (at => scene%graph%vertex(:, scene%graph%ends(1, e)))
            call fail(error, error_deck, 'an edge of an outline at ('//rounded_text(at(1))//', '// &
              rounded_text(at(2))//') crosses another one: cells cannot fit both')
          end associate
          return
        end if
        last = n
      end do
    end do
    call restore_delaunay(scene%t)
  end subroutine lay_edges

  !> Inserts a node in each leaf that no edge passes closely; rows are offset by half a leaf.
  pure subroutine lay_interior(scene)
    type(refined_scene_type), intent(inout) :: scene
    real(wp), allocatable :: place(:, :)
    integer, allocatable :: first(:), edge(:)
    integer :: i, node, root

    call leaf_places(scene%sizes, place)
    call edges_by_root(scene, first, edge)
    do i = 1, size(place, 2)
      root = nint(place(4, i))
      if (is_near(scene%graph, edge(first(root):first(root + 1) - 1), place(1:2, i), near*place(3, i))) cycle
      call insert_node(scene%t, lattice_place(scene%lattice, place(1:2, i)), node)
    end do
    if (scene%t%node_count > size(scene%lies_on)) scene%lies_on = [scene%lies_on, spread(0, 1, scene%t%node_count)]
  end subroutine lay_interior

  !> Edges that pass a root of the sizes at less than its width, in compressed rows.
  pure subroutine edges_by_root(scene, first, edge)
    type(refined_scene_type), intent(in) :: scene
    integer, allocatable, intent(out) :: first(:), edge(:)
    integer, dimension(3, size(scene%graph%ends, 2)) :: low, high
    integer :: e

    low = 1
    high = 1
    associate (sizes => scene%sizes, graph => scene%graph)
      do e = 1, size(graph%ends, 2)
        associate (a => graph%vertex(:, graph%ends(1, e)), b => graph%vertex(:, graph%ends(2, e)))
          low(:2, e) = max(1, floor((min(a, b) - sizes%low)/sizes%side))
          high(:2, e) = min(sizes%roots, floor((max(a, b) - sizes%low)/sizes%side) + 2)
        end associate
      end do
      call list_by_box(low, high, [sizes%roots, 1], first, edge)
    end associate
  end subroutine edges_by_root

  !> Checks whether one of several edges passes a place.
  pure logical function is_near(graph, edges, x, distance)
    type(outline_graph_type), intent(in) :: graph
    integer, intent(in) :: edges(:)
    real(wp), intent(in) :: x(:), distance
    real(wp) :: along(2), share
    integer :: i

    do i = 1, size(edges)
      associate (a => graph%vertex(:, graph%ends(1, edges(i))), b => graph%vertex(:, graph%ends(2, edges(i))))
        is_near = .false.
        if (any(x < min(a, b) - distance) .or. any(x > max(a, b) + distance)) cycle
        along = b - a
        share = min(max(dot_product(x - a, along)/dot_product(along, along), 0.0_wp), 1.0_wp)
        is_near = norm2(x - a - share*along) <= distance
        if (is_near) return
      end associate
    end do
    is_near = .false.
  end function is_near

  !> Sets the coordinates: vertices as defined in the deck, nodes between them on their edges.
  pure subroutine take_mesh(scene, mesh)
    type(refined_scene_type), intent(in) :: scene
    type(fitted_mesh_type), intent(inout) :: mesh
    real(wp) :: along(2), share
    integer :: cell, node, on

    associate (t => scene%t, graph => scene%graph)
      allocate (mesh%position(2, t%node_count), mesh%region(t%cell_count), mesh%angle(t%cell_count))
      allocate (mesh%is_dictated(t%cell_count))
      mesh%corner = t%corner(:, :t%cell_count)
      mesh%neighbour = t%neighbour(:, :t%cell_count)
      mesh%line = t%line(:, :t%cell_count)
      mesh%graph = graph
      do node = 1, t%node_count
        on = scene%lies_on(node)
        mesh%position(:, node) = plane_place(scene%lattice, t%node(:, node))
        if (on < 0) mesh%position(:, node) = graph%vertex(:, -on)
        if (on <= 0) cycle
        associate (a => graph%vertex(:, graph%ends(1, on)))
          along = graph%vertex(:, graph%ends(2, on)) - a
          share = dot_product(mesh%position(:, node) - a, along)/dot_product(along, along)
          mesh%position(:, node) = a + share*along
        end associate
      end do
      do cell = 1, t%cell_count
        mesh%angle(cell) = smallest_angle(t, cell)
        mesh%is_dictated(cell) = is_dictated(scene, cell)
      end do
    end associate
  end subroutine take_mesh

  !> Assigns regions to the areas enclosed by lines, by the outlines around their largest and roundest cell.
  pure subroutine find_regions(scene, outlines, mesh)
    type(refined_scene_type), intent(in) :: scene
    type(outline_type), intent(in) :: outlines(:)
    type(fitted_mesh_type), intent(inout) :: mesh
    integer :: filled(size(mesh%region)), count, done, seed, k, o, best
    real(wp) :: worth, most, middle(2)

    mesh%region = -1
    do seed = 1, size(mesh%region)
      if (mesh%region(seed) >= 0) cycle
      count = 1
      done = 0
      filled(1) = seed
      mesh%region(seed) = 0
      most = -1.0_wp
      best = seed
      do while (done < count)
        done = done + 1
        worth = real(signed_area(scene%t, filled(done)), wp)*mesh%angle(filled(done))
        if (worth > most) best = filled(done)
        most = max(most, worth)
        do k = 1, 3
          associate (other => mesh%neighbour(k, filled(done)))
            if (other == 0 .or. mesh%line(k, filled(done)) /= 0) cycle
            if (mesh%region(other) >= 0) cycle
            count = count + 1
            filled(count) = other
            mesh%region(other) = 0
          end associate
        end do
      end do
      middle = sum(mesh%position(:, mesh%corner(:, best)), dim=2)/3.0_wp
      do o = size(outlines), 1, -1
        if (.not. outlines(o)%is_closed) cycle
        if (.not. polygon_contains(outlines(o)%corner, middle)) cycle
        mesh%region(filled(:count)) = outlines(o)%region
        exit
      end do
    end do
  end subroutine find_regions

  !> Reports an outline that is too thin: its region has no cell although no later outline covers it.
  pure subroutine look_for_lost(outlines, mesh, error)
    type(outline_type), intent(in) :: outlines(:)
    type(fitted_mesh_type), intent(in) :: mesh
    type(error_type), allocatable, intent(out) :: error
    integer :: o, later
    logical :: is_covered

    do o = 1, size(outlines)
      if (.not. outlines(o)%is_closed .or. outlines(o)%region == 0) cycle
      if (any(mesh%region == outlines(o)%region)) cycle
      is_covered = .false.
      do later = o + 1, size(outlines)
        if (outlines(later)%is_closed) is_covered = is_covered .or. &
          polygon_contains(outlines(later)%corner, sum(outlines(o)%corner, dim=2)/size(outlines(o)%corner, 2))
      end do
      if (is_covered .or. is_outside(outlines(o)%corner, mesh%position)) cycle
      call fail(error, error_deck, "'"//outlines(o)%name//"' at ("//rounded_text(outlines(o)%corner(1, 1))//', '// &
        rounded_text(outlines(o)%corner(2, 1))//') is thinner than a twentieth of a cell: a finer *GRID there')
      return
    end do
  end subroutine look_for_lost

  !> Checks whether an outline is beyond the mesh.
  pure logical function is_outside(corner, position)
    real(wp), intent(in) :: corner(:, :), position(:, :)

    is_outside = any(minval(corner, dim=2) >= maxval(position, dim=2)) .or. &
      any(maxval(corner, dim=2) <= minval(position, dim=2))
  end function is_outside

  !> Moves free nodes to the centre of their neighbours if this increases the smallest angle at them.
  pure subroutine smooth_triangles(t, lies_on)
    type(triangulation_type), intent(inout) :: t
    !> Nonzero for a node that is not moved.
    integer, intent(in) :: lies_on(:)
    integer :: pass, node

    do pass = 1, passes
      do node = 5, t%node_count
        if (lies_on(node) == 0) call smooth_node(t, node)
      end do
      call restore_delaunay(t)
    end do
  end subroutine smooth_triangles

  !> Moves a node entirely, or half way, to the centre of its neighbours, or not.
  pure subroutine smooth_node(t, node)
    type(triangulation_type), intent(inout) :: t
    integer, intent(in) :: node
    integer, allocatable :: cells(:)
    integer(long) :: old(2), middle(2)
    real(wp) :: before
    integer :: i, part

    call cells_around(t, node, cells)
    before = least_of(t, cells)
    if (before > good) return
    old = t%node(:, node)
    middle = 0_long
    do i = 1, size(cells)
      middle = middle + t%node(:, t%corner(next_of(place_in_cell(t, cells(i), node)), cells(i)))
    end do
    do part = 1, 2
      t%node(:, node) = old + nint(real(middle - size(cells)*old, wp)/(part*size(cells)), long)
      if (least_of(t, cells) > before) return
    end do
    t%node(:, node) = old
  end subroutine smooth_node

  !> Smallest angle of cells, negative if one is inverted.
  pure real(wp) function least_of(t, cells)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cells(:)
    integer :: i

    least_of = pi
    do i = 1, size(cells)
      if (signed_area(t, cells(i)) <= 0_long) then
        least_of = -1.0_wp
        return
      end if
      least_of = min(least_of, smallest_angle(t, cells(i)))
    end do
  end function least_of

  !> Smallest angle of a cell in radians: that opposite its shortest edge.
  pure real(wp) function smallest_angle(t, cell)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cell
    real(wp) :: square(3)

    square = edge_squares(t, cell)
    smallest_angle = atan2(real(abs(signed_area(t, cell)), wp), 0.5_wp*(sum(square) - 2.0_wp*minval(square)))
  end function smallest_angle
end module qsmpm_fitted_mesh
