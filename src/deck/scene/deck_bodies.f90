!> Cards of bodies and their points: *BODY, *POINTS.
module qsmpm_deck_bodies
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_body_description, only: body_box, body_polygon, body_region, body_polyhedron
  use qsmpm_mesh_description, only: mesh_fitted, mesh_grid, mesh_inline
  use qsmpm_element, only: element_from_name, allowed_counts
  use qsmpm_polygon, only: polygon_area
  use qsmpm_text, only: integer_list, integer_text
  use qsmpm_path, only: directory_of, joined
  use qsmpm_card_fields, only: card_fields_type, column_type
  use qsmpm_deck_objects, only: list_bodies, list_points
  use qsmpm_deck_sets, only: box_fields, check_box
  use qsmpm_deck_state, only: deck_state_type, check_name, beside_deck
  use qsmpm_deck_words, only: bar_list, shape_words
  use qsmpm_keyword_table, only: table_type, in_model, many
  implicit none
  private

  public :: add_body_keywords, give_points, polygon_fields, finish_polygon

  !> Areas below this share of the enclosing box are rounding.
  real(wp), parameter :: flat = 1.0e-12_wp

contains

  !> *BODY, *POINTS.
  subroutine add_body_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('BODY', in_model, many, 'A body of one material. It may end inside elements.', body_fields, &
      '*BODY, NAME=slope, MATERIAL=clay, SHAPE=POLYGON| 0, 0| 4, 0| 3, 1| 0, 1| '// &
      '*BODY, NAME=dam, MATERIAL=clay, SHAPE=POLYHEDRON, INPUT=dam.stl', finish_body, list=list_bodies, opens='body')
    call table%add('POINTS', in_model, many, 'How densely bodies are filled with material points.', point_fields, &
      '*POINTS, PER ELEMENT=18', check_points, list=list_points, opens='request')
  end subroutine add_body_keywords

  !> *BODY.
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
      call fields%answer('ACTIVE', body%active, 'NO: it is not there until a phase puts it in place by *ACTIVATE')
      call fields%data('box', when='SHAPE=BOX')
      call box_fields(fields, body%box)
      call polygon_fields(fields, body%polygon)
    end associate
  end subroutine body_fields

  !> Vertices of a polygon.
  subroutine polygon_fields(fields, polygon)
    class(card_fields_type), intent(inout) :: fields
    !> (2,n)
    real(wp), allocatable, intent(inout) :: polygon(:, :)

    call fields%table('vertices in order, either way round', [column_type('x', 'coordinate'), &
      column_type('y', 'coordinate')], polygon, when='SHAPE=POLYGON')
  end subroutine polygon_fields

  !> What a shape needs is there.
  subroutine finish_body(state)
    type(deck_state_type), intent(inout) :: state

    select case (state%analysis%bodies(state%item)%kind)
    case (body_box)
      call check_box(.true., state%analysis%bodies(state%item)%box, state)
    case (body_polygon)
      call finish_polygon(state%analysis%bodies(state%item)%polygon, state)
    case (body_region)
      if (.not. state%card%has('REGION')) call state%report_error('SHAPE=REGION wants the parameter REGION')
    case (body_polyhedron)
      call find_file(state)
    end select
  end subroutine finish_body

  !> The file of a polyhedron; it is read when the model is built.
  subroutine find_file(state)
    type(deck_state_type), intent(inout) :: state
    logical :: there

    if (state%dimension == 2) call state%report_error('SHAPE=POLYHEDRON is for 3D models')
    if (.not. state%card%has('INPUT')) then
      call state%report_error('SHAPE=POLYHEDRON wants the parameter INPUT')
    else if (len(state%card%value('INPUT')) > 0) then
      associate (body => state%analysis%bodies(state%item))
        body%file = beside_deck(state%card, 'INPUT')
        inquire (file=body%file, exist=there)
      end associate
      if (.not. there) call state%report_error("there is no file '"//joined(directory_of(state%card%place%file), &
        state%card%value('INPUT'))//"'")
    end if
  end subroutine find_file

  !> A polygon bounds an area; it is turned counter-clockwise.
  subroutine finish_polygon(polygon, state)
    !> One of the deck's (2,n).
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

  !> *POINTS.
  subroutine point_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (request => deck%points(deck%item))
      call fields%line(request%where)
      call fields%name('BODY', request%body, 'the body; without it all bodies that have no *POINTS of their own')
      call fields%whole('PER ELEMENT', request%per_element, 'points of a full element; each element '// &
        'allows certain numbers, which the message of a wrong one lists', required=.true., range='[1, inf)', &
        none='DEFAULT')
    end associate
  end subroutine point_fields

  !> No body is asked for twice.
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

  !> Give every body its number of points, when all bodies are known.
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

  !> The element of a mesh whose element the deck tells allows the number.
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

  !> What is wrong with an outline, empty when nothing is.
  pure function outline_problem(vertices) result(problem)
    !> Vertices in order, either way round (2,n).
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

  !> Both ends of an edge.
  pure function edge(vertices, i) result(ends)
    !> Vertices (2,n).
    real(wp), intent(in) :: vertices(:, :)
    !> Number of the edge: that of its first vertex.
    integer, intent(in) :: i
    real(wp) :: ends(2, 2)

    ends(:, 1) = vertices(:, i)
    ends(:, 2) = vertices(:, mod(i, size(vertices, 2)) + 1)
  end function edge

  !> Whether two segments have a point in common.
  pure logical function touch(a, b)
    !> Ends of one (2,2); ends of the other (2,2).
    real(wp), intent(in) :: a(2, 2), b(2, 2)

    touch = sides_differ(a, b) .and. sides_differ(b, a) .and. &
      all(max(a(:, 1), a(:, 2)) >= min(b(:, 1), b(:, 2))) .and. all(max(b(:, 1), b(:, 2)) >= min(a(:, 1), a(:, 2)))
  end function touch

  !> Whether the ends of a segment are not strictly on one side of another's line.
  pure logical function sides_differ(line, ends)
    !> Two points of the line; ends of the segment.
    real(wp), intent(in) :: line(2, 2), ends(2, 2)
    real(wp) :: side(2), along(2)

    along = line(:, 2) - line(:, 1)
    side = along(1)*(ends(2, :) - line(2, 1)) - along(2)*(ends(1, :) - line(1, 1))
    sides_differ = .not. (all(side > 0.0_wp) .or. all(side < 0.0_wp))
  end function sides_differ
end module qsmpm_deck_bodies
