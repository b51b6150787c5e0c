!> Bodies whose outline moves with the material: those cut by the grid, and plane bodies of quadratic elements that the
!> grid may cut later: with points only, the bore of a thick tube that grows by 0.29 of its radius is 14 % too small.
!> Where cells are integrated the outline is used for the integration in bodies whose materials cannot yield: a yielding
!> body folds and separates, which an outline does not follow, and the states that integration points take from the
!> nearest material point cost a softening slope more accuracy than the outline gains. Elsewhere the outline only
!> measures the integration error (qsmpm_cut_cell_check); bodies that touch such a body also have an outline there.
!>
!> The vertices of an outline are tracers. At the start of every step an outline used for integration defines which part
!> of each cell its body fills, and the loads on it are generated again (qsmpm_outline_surfaces), so that a uniform
!> stress remains in equilibrium with its traction for any motion or deformation of the body. A body that extends beyond
!> the grid is replaced by its part on the grid (`trim_outline`). docs/methods/bodies.md.
module qsmpm_outlines
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type
  use qsmpm_material_description, only: may_yield
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_mesh_description, only: mesh_grid, select_outline
  use qsmpm_method_description, only: basis_fem, integrate_cells, grid_degree
  use qsmpm_model, only: model_type
  use qsmpm_model_bodies, only: places_for
  use qsmpm_model_surfaces, only: outline_box
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_body_quadrature, only: body_quadrature_type, sort_seeds
  use qsmpm_carried_outline, only: carried_outline_type, divide_polygon, divide_facets, part_sizes, shape_of_outline
  use qsmpm_element, only: element_order
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_search, only: locate
  use qsmpm_mesh_sets, only: set_tolerance
  use qsmpm_outline_quadrature, only: seed_outline_cells
  use qsmpm_outline_seeding, only: bounds_of
  use qsmpm_points, only: carried_type
  use qsmpm_polyhedron, only: polyhedron_type
  use qsmpm_seeding, only: seed_body
  use qsmpm_seed_list, only: seed_list_type
  use qsmpm_seed_table, only: seed_table_type
  use qsmpm_cell_share, only: cell_volumes
  use qsmpm_agreement, only: any_of
  use qsmpm_own_part, only: own_cells, own_of
  use qsmpm_team, only: largest, smallest, total
  use qsmpm_polygon_pieces, only: polygon_list_type, begin_list, pieces_in_convex
  implicit none
  private

  public :: carry_outlines, find_bodies, flows, measures, trim_outline, is_trimmed

  !> Share of a cell that must be outside a body, and inside it, for the cell to be cut.
  real(wp), parameter :: cut = 1.0e-6_wp
  !> Largest length of an edge relative to the size of a cell, in the plane and in space, where edges are more numerous.
  real(wp), parameter :: longest(2:3) = [0.5_wp, 1.0_wp]
  !> Relative difference between the volume of an outline and that of the points above which it does not enclose them
  !> any more.
  real(wp), parameter :: lost = 0.1_wp
  !> Relative difference up to which the area of parts of an outline is equal to that of the points of a surface.
  real(wp), parameter :: same_area = 1.0e-6_wp
  !> Share of the size of a cell within which bodies touch.
  real(wp), parameter :: touching = 0.02_wp
  !> Smallest distance of two divisions, in tolerances of sets.
  real(wp), parameter :: apart = 4.0_wp

  !> Extent beyond the grid, relative to the size of a body, up to which the body ends with the grid.
  real(wp), parameter :: same_place = 1.0e-8_wp

contains

  !> Selects the bodies, and creates the vertices of their outlines as tracers.
  subroutine carry_outlines(model, table)
    !> The model with its points, surfaces and tracers.
    type(model_type), intent(inout) :: model
    !> Parts of the cells in the bodies.
    type(seed_table_type), intent(in) :: table
    real(wp) :: volumes(model%mesh%cell_count)
    integer :: b, before
    logical :: added, carried

    allocate (model%outlines(0))
    if (model%analysis%method%basis == basis_fem) return
    call cell_volumes(model%mesh, volumes)
    do b = 1, size(model%shapes)
      carried = any(table%volume(:, b) > cut*volumes .and. table%volume(:, b) < (1.0_wp - cut)*volumes)
      if (.not. carried .and. model%mesh%dimension == 2 .and. any(element_order(model%mesh%cell_kind) > 1)) &
        carried = integrates_inside(model, b)
      if (carried) call carry_outline(model, b, longest(model%mesh%dimension)*model%cell_size)
    end do
    ! If only one of two touching bodies had an outline, the interface between them would be treated as a free boundary.
    added = .true.
    do while (added)
      added = .false.
      do b = 1, size(model%shapes)
        if (.not. touches_outline(model, b, touching*model%cell_size)) cycle
        before = size(model%outlines)
        call carry_outline(model, b, longest(model%mesh%dimension)*model%cell_size)
        added = added .or. size(model%outlines) > before
      end do
    end do
  end subroutine carry_outlines

  !> Creates the outline of a body, unless it has none or a vertex is outside the mesh.
  subroutine carry_outline(model, body, length)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: body
    !> Largest length of an edge.
    real(wp), intent(in) :: length
    type(carried_outline_type) :: outline
    real(wp), allocatable :: vertices(:, :)
    logical :: placed

    call divide_bounds(model, body, length, vertices, outline)
    if (size(vertices) == 0) return
    call add_tracers(model, vertices, placed)
    if (.not. placed) return
    outline%before = model%state%tracers%count - outline%count
    outline%integrates = integrates_inside(model, body)
    call find_surfaces(model, vertices, outline)
    model%outlines = [model%outlines, outline]
  end subroutine carry_outline

  !> Returns whether a body is integrated inside its outline if it has one.
  logical function integrates_inside(model, body) result(inside)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body

    inside = .not. any_of(model%part%team, flows(model, body))
    if (model%analysis%method%integration /= integrate_cells) inside = .false.
  end function integrates_inside

  !> Returns whether the points of a body without an outline touch a body whose outline only measures the integration
  !> error.
  logical function touches_outline(model, body, margin) result(touches)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    real(wp), intent(in) :: margin
    real(wp), dimension(model%mesh%dimension, 2) :: own, other
    integer :: k

    touches = .false.
    if (any(model%outlines%body == body)) return
    if (integrates_inside(model, body)) return
    own = box_of(body)
    do k = 1, size(model%outlines)
      if (model%outlines(k)%integrates) cycle
      other = box_of(model%outlines(k)%body)
      touches = touches .or. all(own(:, 1) <= other(:, 2) + margin .and. own(:, 2) >= other(:, 1) - margin)
    end do
  contains
    !> Returns the lower and upper corner of the boxes of the points of a body.
    function box_of(number) result(box)
      integer, intent(in) :: number
      real(wp) :: box(model%mesh%dimension, 2)
      integer :: d

      associate (points => model%state%points)
        do d = 1, size(box, 1)
          box(d, 1) = smallest(model%part%team, minval(points%position(d, :) - points%half_size(d, :), &
            mask=points%body == number))
          box(d, 2) = largest(model%part%team, maxval(points%position(d, :) + points%half_size(d, :), &
            mask=points%body == number))
        end do
      end associate
    end function box_of
  end function touches_outline

  !> Returns whether a material of a body can yield.
  pure logical function flows(model, body)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    integer :: m

    flows = .false.
    do m = 1, size(model%analysis%materials)
      if (.not. may_yield(model%analysis%materials(m))) cycle
      flows = flows .or. any(model%state%points%body == body .and. model%state%points%material == m)
    end do
  end function flows

  !> Computes vertices and parts of the boundary of a body; no vertices where it has no separate boundary in all
  !> directions.
  subroutine divide_bounds(model, body, length, vertices, outline)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    !> Largest length of an edge.
    real(wp), intent(in) :: length
    !> (dimension, n)
    real(wp), allocatable, intent(out) :: vertices(:, :)
    type(carried_outline_type), intent(out) :: outline
    type(polyhedron_type) :: solid
    type(body_shape_type) :: drawn
    real(wp), allocatable :: boxes(:, :, :)
    real(wp) :: box(3, 2)
    integer :: s, i

    allocate (vertices(model%mesh%dimension, 0))
    drawn = model%shapes(body)
    if (model%analysis%mesh%kind == mesh_grid) call trim_outline(model%mesh%bounds, drawn)
    if (allocated(drawn%region)) return
    if (model%mesh%dimension == 2) then
      if (.not. allocated(drawn%outline)) return
      if (leaves(model%mesh, drawn%outline, length)) return
      allocate (boxes(2, 2, 0))
      do s = 1, size(model%analysis%surfaces)
        if (.not. is_of_body(model, s, body)) cycle
        box = outline_box(model, model%analysis%surfaces(s))
        boxes = reshape([boxes, box(:2, :)], [2, 2, size(boxes, 3) + 1])
      end do
      call divide_polygon(drawn%outline, length, boxes, apart*set_tolerance(model%mesh), vertices)
      outline%corner = reshape([(i, modulo(i, size(vertices, 2)) + 1, i=1, size(vertices, 2))], shape(vertices))
    else
      if (.not. allocated(drawn%solid) .and. drawn%high >= huge(1.0_wp)) return
      call bounds_of(model%mesh, drawn, solid)
      if (leaves(model%mesh, reshape(solid%facets, [3, size(solid%facets)/3]), length)) return
      call divide_facets(solid%facets, length, vertices, outline%corner)
    end if
    outline%body = body
    outline%count = size(vertices, 2)
    outline%size = measures(model, vertices, outline%corner)
  end subroutine divide_bounds

  !> Returns whether a corner is so far outside the mesh that no tracer can be there; checked before edges are divided,
  !> because the number of parts of such an edge is unbounded.
  pure logical function leaves(mesh, corners, margin)
    type(mesh_type), intent(in) :: mesh
    !> (dimension, n)
    real(wp), intent(in) :: corners(:, :)
    real(wp), intent(in) :: margin
    integer :: i

    leaves = any([(minval(corners(i, :)) < minval(mesh%coordinates(i, :)) - margin .or. maxval(corners(i, :)) &
      > maxval(mesh%coordinates(i, :)) + margin, i=1, size(corners, 1))])
  end function leaves

  !> Returns whether a surface has only loads and is on the outline of a body: supports hold the places where they
  !> began, and contact stores its tractions at the points.
  pure logical function is_of_body(model, surface, body)
    type(model_type), intent(in) :: model
    integer, intent(in) :: surface, body
    integer :: p, i

    associate (chosen => model%analysis%surfaces(surface))
      is_of_body = chosen%selection == select_outline
      if (is_of_body) is_of_body = chosen%body == model%analysis%bodies(body)%name
      is_of_body = is_of_body .and. all([(model%analysis%contacts(i)%surface /= chosen%name, i=1, &
        size(model%analysis%contacts))])
      is_of_body = is_of_body .and. all([(all([(model%analysis%phases(p)%supports(i)%surface /= chosen%name, i=1, &
        size(model%analysis%phases(p)%supports))]), p=1, size(model%analysis%phases))])
    end associate
  end function is_of_body

  !> Adds tracers, unless one is outside the mesh.
  subroutine add_tracers(model, places, placed)
    type(model_type), intent(inout) :: model
    !> (dimension, n)
    real(wp), intent(in) :: places(:, :)
    logical, intent(out) :: placed
    type(carried_type) :: more
    integer :: i

    associate (tracers => model%state%tracers)
      more%count = size(places, 2)
      allocate (more%cell(more%count), source=model%state%points%cell(1))
      allocate (more%local, mold=places)
      placed = .true.
      do i = 1, more%count
        if (placed) call locate(model%mesh, places(:, i), more%cell(i), more%local(:, i), placed)
      end do
      if (.not. placed) return
      tracers%number = [tracers%number, (int(tracers%count + i, long), i=1, more%count)]
      tracers%cell = [tracers%cell, more%cell]
      tracers%local = reshape([tracers%local, more%local], [size(places, 1), tracers%count + more%count])
      tracers%position = reshape([tracers%position, places], [size(places, 1), tracers%count + more%count])
      tracers%initial_position = reshape([tracers%initial_position, places], &
        [size(places, 1), tracers%count + more%count])
      tracers%count = tracers%count + more%count
    end associate
  end subroutine add_tracers

  !> Finds the parts of an outline that form surfaces of the deck. A surface that ends inside facets retains its points.
  subroutine find_surfaces(model, vertices, outline)
    type(model_type), intent(in) :: model
    !> (dimension, n)
    real(wp), intent(in) :: vertices(:, :)
    type(carried_outline_type), intent(inout) :: outline
    logical :: inside(size(outline%corner, 2))
    real(wp) :: box(3, 2), middle(size(vertices, 1)), area
    integer :: s, i, d

    d = size(vertices, 1)
    allocate (outline%part(0), outline%surface(0))
    do s = 1, size(model%analysis%surfaces)
      if (.not. is_of_body(model, s, outline%body)) cycle
      box = outline_box(model, model%analysis%surfaces(s))
      do i = 1, size(inside)
        middle = sum(vertices(:, outline%corner(:, i)), dim=2)/size(outline%corner, 1)
        inside(i) = all(middle >= box(:d, 1) .and. middle <= box(:d, 2)) .and. .not. &
          is_trimmed(model%mesh%bounds, model%shapes(outline%body), middle)
      end do
      area = sum(model%state%surface%area, mask=model%state%surface%surface == s)
      if (abs(sum(outline%size, mask=inside) - area) > same_area*area) cycle
      outline%part = [outline%part, pack([(i, i=1, size(inside))], inside)]
      outline%surface = [outline%surface, spread(s, 1, count(inside))]
    end do
  end subroutine find_surfaces

  !> Returns the lengths or areas of the parts of an outline, per radian in axisymmetry.
  pure function measures(model, vertices, corner)
    type(model_type), intent(in) :: model
    !> (dimension, n)
    real(wp), intent(in) :: vertices(:, :)
    !> (2 or 3, parts)
    integer, intent(in) :: corner(:, :)
    real(wp) :: measures(size(corner, 2))
    integer :: i

    measures = part_sizes(vertices, corner)
    if (model%analysis%model /= axisymmetric) return
    do i = 1, size(measures)
      measures(i) = measures(i)*0.5_wp*sum(vertices(1, corner(:, i)))
    end do
  end function measures

  !> Computes the part of each cell in the bodies with moving outlines, in their present position.
  subroutine find_bodies(model, volumes, integrates, bodies)
    type(model_type), intent(in) :: model
    !> Volume of every cell (cell_count).
    real(wp), intent(in) :: volumes(:)
    !> Select bodies that are integrated inside their outlines, or the others.
    logical, intent(in) :: integrates
    type(body_quadrature_type), intent(out) :: bodies
    type(body_shape_type) :: shape
    type(seed_list_type) :: list
    type(error_type), allocatable :: error
    logical :: carried(size(model%shapes)), fails
    integer :: k, before

    carried = .false.
    do k = 1, size(model%outlines)
      associate (outline => model%outlines(k))
        if (outline%integrates .neqv. integrates) cycle
        if (.not. any_of(model%part%team, any(model%state%points%body == outline%body))) cycle
        call shape_of_outline(outline, model%state%tracers%position(:, outline%before + 1:outline%before &
          + outline%count), shape)
        before = list%count
        if (model%mesh%dimension == 2) then
          call seed_outline_cells(model%mesh, shape%outline, outline%body, &
            grid_degree(model%analysis%method%basis), list)
        else
          call seed_body(model%mesh, shape, outline%body, &
            model%analysis%bodies(outline%body)%points_per_element, places_for(model), &
            grid_degree(model%analysis%method%basis), list, error)
        end if
        fails = any_of(model%part%team, allocated(error))
        carried(outline%body) = bounds_points(model, outline%body, list%volume(before + 1:list%count), &
          list%cell(before + 1:list%count))
        if (fails) carried(outline%body) = .false.
      end associate
    end do
    call sort_seeds(list, volumes, carried, bodies)
  end subroutine find_bodies

  !> Returns whether the volume inside an outline is still equal to that of the points of its body.
  logical function bounds_points(model, body, held, cell)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    !> Volumes of the parts of cells, and their cells (parts).
    real(wp), intent(in) :: held(:)
    integer, intent(in) :: cell(:)
    real(wp) :: volume, inside

    associate (team => model%part%team, points => model%state%points)
      volume = total(team, sum(points%volume, mask=points%body == body .and. own_of(model%part%points, points%count)))
      inside = total(team, sum(held, mask=own_cells(model%part, cell)))
    end associate
    bounds_points = inside > 0.0_wp .and. abs(inside - volume) <= lost*volume
  end function bounds_points

  !> Reduces an outline in the x-y plane to its part on the grid; one that would separate into several parts is not
  !> changed.
  pure subroutine trim_outline(bounds, shape)
    !> Bounds of the grid (dimension, 2).
    real(wp), intent(in) :: bounds(:, :)
    type(body_shape_type), intent(inout) :: shape
    type(polygon_list_type) :: whole, parts
    real(wp) :: corners(2, 4)
    integer :: i

    if (.not. allocated(shape%outline)) return
    if (.not. (any(reaches_beyond(bounds, shape%outline, 1)) .or. any(reaches_beyond(bounds, shape%outline, 2)))) return
    corners(1, :) = bounds(1, [1, 2, 2, 1])
    corners(2, :) = bounds(2, [1, 1, 2, 2])
    call begin_list(shape%outline, whole)
    call pieces_in_convex(whole, corners, parts)
    if (parts%count /= 1) return
    ! A corner on an end of the grid occurs twice.
    associate (polygon => parts%vertices(:, :parts%first(2) - 1))
      associate (gaps => norm2(polygon - cshift(polygon, -1, dim=2), dim=1))
        shape%outline = polygon(:, pack([(i, i=1, size(gaps))], gaps > same_place*maxval(bounds(:, 2) - bounds(:, 1))))
      end associate
    end associate
  end subroutine trim_outline

  !> Returns whether a part of a trimmed outline is on an end of the grid and not on the boundary of the body.
  pure logical function is_trimmed(bounds, shape, place)
    real(wp), intent(in) :: bounds(:, :)
    !> The initial shape.
    type(body_shape_type), intent(in) :: shape
    !> Centre of the part (dimension).
    real(wp), intent(in) :: place(:)
    logical :: beyond(2)
    integer :: a

    is_trimmed = .false.
    if (.not. allocated(shape%outline)) return
    do a = 1, 2
      beyond = reaches_beyond(bounds, shape%outline, a)
      is_trimmed = is_trimmed .or. any(beyond .and. abs(place(a) - bounds(a, :)) <= same_place*(bounds(a, 2) - &
        bounds(a, 1)))
    end do
  end function is_trimmed

  !> Returns whether an outline extends beyond the lower and the upper end of the grid along an axis.
  pure function reaches_beyond(bounds, outline, axis) result(beyond)
    real(wp), intent(in) :: bounds(:, :), outline(:, :)
    integer, intent(in) :: axis
    logical :: beyond(2)
    real(wp) :: slack

    slack = same_place*(bounds(axis, 2) - bounds(axis, 1))
    beyond = [minval(outline(axis, :)) < bounds(axis, 1) - slack, maxval(outline(axis, :)) > bounds(axis, 2) + slack]
  end function reaches_beyond
end module qsmpm_outlines
