!> Keywords of named parts of the mesh, *NSET, *ELSET, *SURFACE, and of bodies and their points: *BODY, *POINTS.
module qsmpm_deck_bodies
  use qsmpm_kinds, only: wp
  use qsmpm_mesh_description, only: set_type, select_list, select_box, select_plane, select_segment, select_mesh, &
    select_outline, mesh_fitted, mesh_grid, mesh_inline
  use qsmpm_cards, only: whole_at
  use qsmpm_card_fields, only: card_fields_type, column_type
  use qsmpm_deck_state, only: deck_state_type, check_name, list_node_sets, list_element_sets, &
    list_surfaces, list_bodies, list_points
  use qsmpm_keyword_table, only: table_type, in_model, many, bar_list, axis_words, surface_words, shape_words
  use qsmpm_named, only: place_named
  use qsmpm_body_description, only: body_box, body_polygon, body_region, body_polyhedron
  use qsmpm_element, only: element_from_name, allowed_counts
  use qsmpm_polygon, only: polygon_area
  use qsmpm_text, only: integer_list, integer_text
  implicit none
  private

  public :: add_set_keywords, box_fields, check_box, give_points, polygon_fields, finish_polygon

  !> A longer range of labels is a typing error.
  integer, parameter :: longest_run = 10000000
  !> Selections of the words of TYPE of *SURFACE.
  integer, parameter :: selections(4) = [select_box, select_segment, select_mesh, select_outline]

  !> Areas below this share of the enclosing box are round-off.
  real(wp), parameter :: flat = 1.0e-12_wp

contains

  !> Adds the keywords *NSET, *ELSET, *SURFACE, *BODY, *POINTS.
  subroutine add_set_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('NSET', in_model, many, 'A set of nodes: by labels, on a plane, or in a '// &
      'box.', node_set_fields, '*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=corner, BOX| 0, 0.1, 0, 0.1', &
      finish_node_set, list=list_node_sets, opens='set')
    call table%add('ELSET', in_model, many, 'A set of elements: by labels, or with their centre in a box.', &
      element_set_fields, '*ELSET, ELSET=soil, GENERATE| 1, 99, 2', finish_element_set, list=list_element_sets, &
      opens='set')
    call table%add('SURFACE', in_model, many, 'A part of the boundary of bodies, for loads, supports and '// &
      'contact.', surface_fields, &
      '*SURFACE, NAME=top, TYPE=SEGMENT| 2, 1, 0, 1|*SURFACE, NAME=face, TYPE=OUTLINE, BODY=slope, BOX| 3, 4, 0, 1', &
      check_surface, list=list_surfaces, opens='surface')
    call table%add('BODY', in_model, many, 'A body of one material. Its boundary may cut elements.', body_fields, &
      '*BODY, NAME=slope, MATERIAL=clay, SHAPE=POLYGON| 0, 0| 4, 0| 3, 1| 0, 1| '// &
      '*BODY, NAME=dam, MATERIAL=clay, SHAPE=POLYHEDRON, INPUT=dam.stl', finish_body, list=list_bodies, opens='body')
    call table%add('POINTS', in_model, many, 'Number of material points in bodies.', point_fields, &
      '*POINTS, PER ELEMENT=18', check_points, list=list_points, opens='request')
  end subroutine add_set_keywords

  !> Describes the fields of *NSET.
  subroutine node_set_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    real(wp) :: coordinate

    associate (set => deck%analysis%node_sets(deck%item))
      call fields%line(set%where)
      call fields%name('NSET', set%name, 'name of the set', required=.true.)
      call fields%choice('PLANE', set%axis, bar_list(axis_words), 'nodes on the plane normal to this axis', &
        open=.true., excludes='BOX|GENERATE')
      coordinate = 0.0_wp
      if (set%axis > 0) coordinate = set%box(set%axis, 1)
      call list_parameters(fields, set)
      call fields%data('plane', when='PLANE')
      call fields%number('coordinate', coordinate, 'coordinate of the plane on the axis')
      call list_columns(fields, set)
      if (.not. fields%reading .or. set%axis == 0) return
      set%selection = select_plane
      set%box(set%axis, 1) = coordinate
    end associate
  end subroutine node_set_fields

  !> Describes the fields of *ELSET.
  subroutine element_set_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (set => deck%analysis%element_sets(deck%item))
      call fields%line(set%where)
      call fields%name('ELSET', set%name, 'name of the set', required=.true.)
      call list_parameters(fields, set)
      call list_columns(fields, set)
    end associate
  end subroutine element_set_fields

  !> Describes the parameters of sets given by labels or a box.
  subroutine list_parameters(fields, set)
    class(card_fields_type), intent(inout) :: fields
    type(set_type), intent(inout) :: set
    logical :: boxed, generated

    boxed = set%selection == select_box
    generated = .false.
    call fields%flag('BOX', boxed, 'those in a box', excludes='GENERATE')
    call fields%flag('GENERATE', generated, 'labels by first, last and step')
    if (fields%reading .and. boxed) set%selection = select_box
  end subroutine list_parameters

  !> Describes the data lines of sets given by labels or a box; ranges of labels are expanded.
  subroutine list_columns(fields, set)
    class(card_fields_type), intent(inout) :: fields
    type(set_type), intent(inout) :: set
    integer :: run(3)

    run = 0
    call fields%data('box', when='BOX')
    call box_fields(fields, set%box)
    call fields%data('runs of labels', 1, huge(1), when='GENERATE')
    call fields%whole('first', run(1), 'first label', range='[1, inf)')
    call fields%whole('last', run(2), 'last label', range='[1, inf)')
    call fields%whole('step', run(3), 'step between labels, 1 when not given', required=.false., range='[1, inf)')
    call fields%data('labels', 1, huge(1))
    call fields%labels('label', set%labels, 'label', range='[1, inf)')
  end subroutine list_columns

  !> Describes the columns of a box.
  subroutine box_fields(fields, box)
    class(card_fields_type), intent(inout) :: fields
    !> Lower and upper corner (3,2).
    real(wp), intent(inout) :: box(3, 2)

    call fields%number('xmin', box(1, 1), 'least x')
    call fields%number('xmax', box(1, 2), 'largest x')
    call fields%number('ymin', box(2, 1), 'least y')
    call fields%number('ymax', box(2, 2), 'largest y')
    call fields%number('zmin', box(3, 1), 'least z', third=.true.)
    call fields%number('zmax', box(3, 2), 'largest z', third=.true.)
  end subroutine box_fields

  !> Finishes *NSET.
  subroutine finish_node_set(state)
    type(deck_state_type), intent(inout) :: state
    type(set_type) :: set

    set = state%analysis%node_sets(state%item)
    if (set%axis > state%dimension .and. state%dimension > 0) call state%report_error('PLANE=Z has no meaning in a '// &
      'plane model')
    call finish_set(set, state)
    state%analysis%node_sets(state%item) = set
  end subroutine finish_node_set

  !> Finishes *ELSET.
  subroutine finish_element_set(state)
    type(deck_state_type), intent(inout) :: state
    type(set_type) :: set

    set = state%analysis%element_sets(state%item)
    call finish_set(set, state)
    state%analysis%element_sets(state%item) = set
  end subroutine finish_element_set

  !> Expands ranges of labels and checks the box.
  subroutine finish_set(set, state)
    type(set_type), intent(inout) :: set
    type(deck_state_type), intent(inout) :: state

    if (set%selection == select_box) call check_box(.false., set%box, state)
    if (state%card%has('GENERATE') .and. set%selection == select_list) call read_runs(set%labels, state)
  end subroutine finish_set

  !> Expands ranges of labels.
  subroutine read_runs(labels, state)
    integer, allocatable, intent(inout) :: labels(:)
    type(deck_state_type), intent(inout) :: state
    integer :: i, k, step

    labels = [integer ::]
    do i = 1, size(state%card%rows)
      associate (row => state%card%rows(i))
        if (.not. row%good) cycle
        if (whole_at(row, 2) < whole_at(row, 1)) then
          call state%error_at(row, 'the last label is below the first')
        else if (whole_at(row, 2) - whole_at(row, 1) > longest_run) then
          call state%error_at(row, 'the run of labels is too long')
        else
          ! Counted from 0, as the label after the last one may overflow.
          step = max(1, whole_at(row, 3))
          labels = [labels, (whole_at(row, 1) + k*step, k=0, (whole_at(row, 2) - whole_at(row, 1))/step)]
        end if
      end associate
    end do
  end subroutine read_runs

  !> Checks that the upper corner of a box is above the lower one.
  subroutine check_box(solid, box, state)
    !> The box must have a volume; otherwise it may be a plane, a line or a point.
    logical, intent(in) :: solid
    !> Lower and upper corner (3,2); the third component is 0 in plane models.
    real(wp), intent(in) :: box(3, 2)
    type(deck_state_type), intent(inout) :: state
    character(len=1), parameter :: axes(3) = ['X', 'Y', 'Z']
    integer :: i

    if (.not. state%card%is_right()) return
    do i = 1, min(3, size(state%card%rows(1)%items)/2)
      if (box(i, 1) > box(i, 2)) then
        call state%error_at(state%card%rows(1), 'the least '//axes(i)//' is above the largest')
      else if (solid .and. .not. box(i, 2) > box(i, 1)) then
        call state%error_at(state%card%rows(1), 'the box has no extent along '//axes(i))
      end if
    end do
  end subroutine check_box

  !> Describes the fields of *SURFACE.
  subroutine surface_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    integer :: type

    associate (surface => deck%analysis%surfaces(deck%item))
      call fields%line(surface%where)
      call fields%name('NAME', surface%name, 'name of the surface', required=.true.)
      type = findloc(selections, surface%selection, dim=1)
      call fields%choice('TYPE', type, bar_list(surface_words), 'BOX: element faces in a box. SEGMENT: straight '// &
        'lines in a plane model, with the body on their left. MESH: the surface of this name in the mesh file. '// &
        'OUTLINE: the boundary of a body (BOX, POLYGON, POLYHEDRON), also inside elements')
      surface%selection = selections(type)
      call fields%name('BODY', surface%body, 'the body', needs='TYPE=OUTLINE')
      call fields%flag('BOX', surface%boxed, 'the part of the outline in a box', needs='TYPE=OUTLINE')
      call fields%data('box', when='TYPE=BOX')
      call box_fields(fields, surface%box)
      call fields%table('segments', [column_type('x1', 'start'), column_type('y1', 'start'), column_type('x2', 'end'), &
        column_type('y2', 'end')], surface%segments, when='TYPE=SEGMENT')
      call fields%data('box', when='BOX')
      call box_fields(fields, surface%box)
    end associate
  end subroutine surface_fields

  !> Checks that segments have a length, boxes are ordered, and an outline has a body.
  subroutine check_surface(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (surface => state%analysis%surfaces(state%item))
      select case (surface%selection)
      case (select_segment)
        if (state%dimension == 3) call state%report_error('TYPE=SEGMENT is for plane models')
        do i = 1, size(state%card%rows)
          if (.not. state%card%rows(i)%good) cycle
          if (.not. norm2(surface%segments(3:, i) - surface%segments(:2, i)) &
            > 0.0_wp) call state%error_at(state%card%rows(i), 'the segment has no length')
        end do
      case (select_outline)
        if (.not. state%card%has('BODY')) call state%report_error('TYPE=OUTLINE requires the parameter BODY')
        if (surface%boxed) call check_box(.false., surface%box, state)
      case (select_box)
        call check_box(.false., surface%box, state)
      end select
    end associate
  end subroutine check_surface

  !> Describes the fields of *BODY.
  subroutine body_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (body => deck%analysis%bodies(deck%item))
      call fields%line(body%where)
      call fields%name('NAME', body%name, 'name of the body', required=.true.)
      call fields%name('MATERIAL', body%material, 'name of its material', required=.true.)
      if (fields%reading) body%kind = 0
      call fields%choice('SHAPE', body%kind, bar_list(shape_words), 'ALL: the whole mesh. BOX. POLYGON: in the x-y '// &
        'plane, through all of z. REGION: an element set. POLYHEDRON: a closed surface of '// &
        'triangles in 3D, corners counter-clockwise seen from outside', required=.true.)
      call fields%name('REGION', body%region, 'element set', needs='SHAPE=REGION')
      call fields%file('INPUT', body%file, 'STL file, ASCII or binary, relative to the deck', &
        needs='SHAPE=POLYHEDRON')
      call fields%answer('ACTIVE', body%active, 'NO: it is inactive until a phase activates it by *ACTIVATE')
      call fields%data('box', when='SHAPE=BOX')
      call box_fields(fields, body%box)
      call polygon_fields(fields, body%polygon)
    end associate
  end subroutine body_fields

  !> Describes the vertices of a polygon.
  subroutine polygon_fields(fields, polygon)
    class(card_fields_type), intent(inout) :: fields
    !> (2,n)
    real(wp), allocatable, intent(inout) :: polygon(:, :)

    call fields%table('vertices in order, either way round', [column_type('x', 'coordinate'), &
      column_type('y', 'coordinate')], polygon, when='SHAPE=POLYGON')
  end subroutine polygon_fields

  !> Checks that the data of a shape are complete; the file of a polyhedron is read when the model is built.
  subroutine finish_body(state)
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: file

    select case (state%analysis%bodies(state%item)%kind)
    case (body_box)
      call check_box(.true., state%analysis%bodies(state%item)%box, state)
    case (body_polygon)
      call finish_polygon(state%analysis%bodies(state%item)%polygon, state)
    case (body_region)
      if (.not. state%card%has('REGION')) call state%report_error('SHAPE=REGION requires the parameter REGION')
    case (body_polyhedron)
      if (state%dimension == 2) call state%report_error('SHAPE=POLYHEDRON is for 3D models')
      if (.not. state%card%has('INPUT')) call state%report_error('SHAPE=POLYHEDRON requires the parameter INPUT')
      call state%find_file('INPUT', file)
      state%analysis%bodies(state%item)%file = file
    end select
  end subroutine finish_body

  !> Checks that a polygon encloses an area, and orients it counter-clockwise.
  subroutine finish_polygon(polygon, state)
    !> Vertices (2,n).
    real(wp), intent(inout) :: polygon(:, :)
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: problem

    if (.not. state%card%is_right()) return
    problem = outline_problem(polygon)
    if (len(problem) > 0) then
      call state%report_error(problem)
    else if (polygon_area(polygon) < 0.0_wp) then
      polygon = polygon(:, size(polygon, 2):1:-1)
    end if
  end subroutine finish_polygon

  !> Describes the fields of *POINTS.
  subroutine point_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (request => deck%points(deck%item))
      call fields%line(request%where)
      call fields%name('BODY', request%body, 'the body; when not given all bodies without their own *POINTS')
      call fields%whole('PER ELEMENT', request%per_element, 'points in a full element; an error lists the numbers '// &
        'that the element type allows', required=.true., range='[1, inf)', &
        none='DEFAULT')
    end associate
  end subroutine point_fields

  !> Checks that no body has two *POINTS.
  subroutine check_points(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (request => state%points(state%item))
      do i = 1, state%item - 1
        if (state%points(i)%body /= request%body) cycle
        if (len(request%body) > 0) then
          call state%report_error("the points of body '"//request%body//"' are given twice")
        else
          call state%report_error('the points of all bodies are given twice')
        end if
      end do
    end associate
  end subroutine check_points

  !> Assigns the number of points to every body, when all bodies are known.
  subroutine give_points(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i, b

    do i = 1, size(state%points)
      if (len(state%points(i)%body) == 0) state%analysis%bodies%points_per_element = state%points(i)%per_element
    end do
    do i = 1, size(state%points)
      call check_count(state, i)
      if (len(state%points(i)%body) == 0) cycle
      call check_name(state, state%points(i)%body, state%analysis%bodies, state%points(i)%where, 'POINTS', 'body')
      b = place_named(state%analysis%bodies, state%points(i)%body)
      if (b > 0) state%analysis%bodies(b)%points_per_element = state%points(i)%per_element
    end do
  end subroutine give_points

  !> Checks the number of points of a mesh whose element is given in the deck.
  subroutine check_count(state, i)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: i
    integer, allocatable :: counts(:)
    integer :: kind

    if (all(state%analysis%mesh%kind /= [mesh_grid, mesh_fitted, mesh_inline])) return
    if (.not. allocated(state%analysis%mesh%element)) return
    kind = element_from_name(state%analysis%mesh%element)
    if (kind == 0 .or. state%points(i)%per_element == 0) return
    allocate (counts, source=allowed_counts(kind))
    if (any(counts == state%points(i)%per_element)) return
    call state%error_from(state%points(i)%where, 'POINTS', 'PER ELEMENT = '// &
      integer_text(state%points(i)%per_element)//' is not a number of points '// &
      state%analysis%mesh%element//' allows: '//integer_list(counts))
  end subroutine check_count

  !> Returns the fault of an outline, empty if there is none.
  pure function outline_problem(vertices) result(problem)
    !> Vertices in order, of either orientation (2,n).
    real(wp), intent(in) :: vertices(:, :)
    character(len=:), allocatable :: problem
    real(wp) :: extent(2)
    integer :: i, k, n

    n = size(vertices, 2)
    problem = ''
    if (n < 3) then
      problem = 'a polygon has at least 3 vertices, this one has '//integer_text(n)
      return
    end if
    do i = 1, n
      k = mod(i, n) + 1
      if (norm2(vertices(:, k) - vertices(:, i)) > 0.0_wp) cycle
      problem = 'vertices '//integer_text(i)//' and '//integer_text(k)//' of the polygon '// &
        'coincide (the polygon closes by itself)'
      return
    end do
    extent = maxval(vertices, dim=2) - minval(vertices, dim=2)
    if (abs(polygon_area(vertices)) <= flat*max(product(extent), tiny(1.0_wp))) problem = 'the polygon has no area'
    do i = 1, n
      do k = i + 2, n
        if (i == 1 .and. k == n) cycle
        if (.not. touch(edge(vertices, i), edge(vertices, k))) cycle
        problem = 'edges '//integer_text(i)//' and '//integer_text(k)//' of the polygon cross or touch'
        return
      end do
    end do
  end function outline_problem

  !> Returns both ends of an edge.
  pure function edge(vertices, i) result(ends)
    !> Vertices (2,n).
    real(wp), intent(in) :: vertices(:, :)
    !> Number of the edge: that of its first vertex.
    integer, intent(in) :: i
    real(wp) :: ends(2, 2)

    ends(:, 1) = vertices(:, i)
    ends(:, 2) = vertices(:, mod(i, size(vertices, 2)) + 1)
  end function edge

  !> Checks whether two segments have a point in common.
  pure logical function touch(a, b)
    !> Ends of one (2,2); ends of the other (2,2).
    real(wp), intent(in) :: a(2, 2), b(2, 2)

    touch = sides_differ(a, b) .and. sides_differ(b, a) .and. &
      all(max(a(:, 1), a(:, 2)) >= min(b(:, 1), b(:, 2))) .and. all(max(b(:, 1), b(:, 2)) >= min(a(:, 1), a(:, 2)))
  end function touch

  !> Checks whether the ends of a segment are not strictly on one side of the line of another.
  pure logical function sides_differ(line, ends)
    !> Two points of the line; ends of the segment.
    real(wp), intent(in) :: line(2, 2), ends(2, 2)
    real(wp) :: side(2), along(2)

    along = line(:, 2) - line(:, 1)
    side = along(1)*(ends(2, :) - line(2, 1)) - along(2)*(ends(1, :) - line(1, 1))
    sides_differ = .not. (all(side > 0.0_wp) .or. all(side < 0.0_wp))
  end function sides_differ
end module qsmpm_deck_bodies
