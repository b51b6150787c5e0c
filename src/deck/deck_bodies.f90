!> Cards of bodies and their points: *BODY, *POINTS.
module qsmpm_deck_bodies
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: body_type, mesh_grid, mesh_inline, body_box, body_polygon, body_region, &
    body_polyhedron
  use qsmpm_element, only: element_from_name, allowed_counts
  use qsmpm_polygon, only: polygon_area
  use qsmpm_outline_check, only: outline_problem
  use qsmpm_text, only: string_type, add_word, squeezed, integer_text
  use qsmpm_path, only: directory_of, joined, absolute_path
  use qsmpm_messages, only: severity_error
  use qsmpm_cards, only: card_type, number_at
  use qsmpm_deck_state, only: deck_state_type, points_request_type, source_line, did_you_mean
  use qsmpm_deck_words, only: bar_list, position_of, shape_words
  use qsmpm_deck_sets, only: box_columns, read_box
  use qsmpm_analysis_lists, only: append
  use qsmpm_keyword_table, only: table_type, in_model, many, kind_word, kind_name, kind_integer, &
    kind_real, kind_file
  implicit none
  private

  public :: add_body_keywords, give_points

contains

  !> Entries of *BODY, *POINTS.
  subroutine add_body_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table

    call table%add('BODY', in_model, many, 'A body of one material. It may end inside elements.', &
      handle_body)
    call table%parameter('NAME', kind_name, 'name of the body', required=.true.)
    call table%parameter('MATERIAL', kind_name, 'name of its material', required=.true.)
    call table%parameter('SHAPE', kind_word, 'ALL: the whole mesh. BOX. POLYGON: in the x-y '// &
      'plane, through all of z. REGION: an element set. POLYHEDRON: a closed surface of '// &
      'triangles in 3D, corners counter-clockwise seen from outside', required=.true., &
      allowed=bar_list(shape_words))
    call table%parameter('REGION', kind_name, 'element set', needs='SHAPE=REGION')
    call table%parameter('INPUT', kind_file, 'STL file, ASCII or binary, relative to the deck', &
      needs='SHAPE=POLYHEDRON')
    call table%data('box', 1, 1, when='SHAPE=BOX')
    call box_columns(table)
    call table%data('vertices in order, either way round', 1, huge(1), when='SHAPE=POLYGON')
    call table%column('x', kind_real, 'coordinate')
    call table%column('y', kind_real, 'coordinate')
    call table%example('*BODY, NAME=slope, MATERIAL=clay, SHAPE=POLYGON| 0, 0| 4, 0| 3, 1| 0, 1| '// &
      '*BODY, NAME=dam, MATERIAL=clay, SHAPE=POLYHEDRON, INPUT=dam.stl')

    call table%add('POINTS', in_model, many, 'How densely bodies are filled with material '// &
      'points.', handle_points)
    call table%parameter('BODY', kind_name, 'the body; without it all bodies that have no '// &
      '*POINTS of their own')
    call table%parameter('PER ELEMENT', kind_integer, 'points of a full element; each element '// &
      'allows certain numbers, which the message of a wrong one lists', required=.true., &
      default='DEFAULT', allowed='DEFAULT', range='[1, inf)')
    call table%example('*POINTS, PER ELEMENT=18')
  end subroutine add_body_keywords

  !> *BODY.
  subroutine handle_body(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(body_type) :: body
    integer :: i

    body%name = squeezed(card%value('NAME'))
    body%material = squeezed(card%value('MATERIAL'))
    body%where = source_line(card%place)
    do i = 1, size(state%analysis%bodies)
      if (state%analysis%bodies(i)%name == body%name .and. len(body%name) > 0) &
        call state%fault(card, "there is already a body '"//body%name//"'")
    end do
    body%kind = position_of(card%word('SHAPE'), shape_words)
    select case (body%kind)
    case (body_box)
      call read_box(card, .true., body%box, state)
    case (body_polygon)
      call read_polygon(card, body, state)
    case (body_region)
      body%region = squeezed(card%value('REGION'))
      if (.not. card%has('REGION')) call state%fault(card, 'SHAPE=REGION wants the parameter '// &
        'REGION')
    case (body_polyhedron)
      call find_file(card, body, state)
    end select
    call append(state%analysis%bodies, body)
  end subroutine handle_body

  !> The file of a polyhedron; it is read when the model is built.
  subroutine find_file(card, body, state)
    type(card_type), intent(in) :: card
    type(body_type), intent(inout) :: body
    type(deck_state_type), intent(inout) :: state
    logical :: there

    body%file = ''
    if (state%dimension == 2) call state%fault(card, 'SHAPE=POLYHEDRON is for 3D models')
    if (.not. card%has('INPUT')) then
      call state%fault(card, 'SHAPE=POLYHEDRON wants the parameter INPUT')
    else if (len(card%value('INPUT')) > 0) then
      body%file = absolute_path(joined(directory_of(card%place%file), card%value('INPUT')))
      inquire (file=body%file, exist=there)
      if (.not. there) call state%fault(card, "there is no file '"// &
        joined(directory_of(card%place%file), card%value('INPUT'))//"'")
    end if
  end subroutine find_file

  !> Vertices of a polygon, turned counter-clockwise.
  subroutine read_polygon(card, body, state)
    type(card_type), intent(in) :: card
    type(body_type), intent(inout) :: body
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: problem
    integer :: i, k, n

    n = size(card%rows)
    allocate (body%polygon(2, n))
    do i = 1, n
      body%polygon(:, i) = [(number_at(card%rows(i), k), k=1, 2)]
    end do
    if (n == 0 .or. any(.not. card%rows%good)) return
    problem = outline_problem(body%polygon)
    if (len(problem) > 0) then
      call state%fault(card, problem)
    else if (polygon_area(body%polygon) < 0.0_wp) then
      body%polygon = body%polygon(:, n:1:-1)
    end if
  end subroutine read_polygon

  !> *POINTS.
  subroutine handle_points(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(points_request_type), allocatable :: longer(:)
    integer :: i, n

    n = size(state%points)
    allocate (longer(n + 1))
    do i = 1, n
      longer(i) = state%points(i)
    end do
    associate (request => longer(n + 1))
      request%place = card%place
      request%body = squeezed(card%value('BODY'))
      request%per_element = card%whole('PER ELEMENT')
      do i = 1, n
        if (longer(i)%body /= request%body) cycle
        if (len(request%body) > 0) then
          call state%fault(card, "the points of body '"//request%body//"' are given twice")
        else
          call state%fault(card, 'the points of all bodies are given twice')
        end if
      end do
    end associate
    call move_alloc(longer, state%points)
  end subroutine handle_points

  !> Give every body its number of points, when all bodies are known.
  subroutine give_points(state)
    !> The deck.
    type(deck_state_type), intent(inout) :: state
    type(string_type), allocatable :: names(:)
    integer :: i, b
    logical :: found

    allocate (names(0))
    do b = 1, size(state%analysis%bodies)
      call add_word(names, state%analysis%bodies(b)%name)
      do i = 1, size(state%points)
        if (len(state%points(i)%body) == 0) state%analysis%bodies(b)%points_per_element = &
          state%points(i)%per_element
      end do
    end do
    do i = 1, size(state%points)
      call check_count(state, i)
      if (len(state%points(i)%body) == 0) cycle
      found = .false.
      do b = 1, size(names)
        if (names(b)%text /= state%points(i)%body) cycle
        found = .true.
        state%analysis%bodies(b)%points_per_element = state%points(i)%per_element
      end do
      if (.not. found) call state%messages%add(severity_error, state%points(i)%place, 'POINTS', &
        "there is no body '"//state%points(i)%body//"'"//did_you_mean(state%points(i)%body, names))
    end do
  end subroutine give_points

  !> The element of a mesh whose element the deck tells allows the number.
  subroutine check_count(state, i)
    type(deck_state_type), intent(inout) :: state
    !> Number of the request.
    integer, intent(in) :: i
    integer, allocatable :: counts(:)
    character(len=:), allocatable :: list
    integer :: k, kind

    if (all(state%analysis%mesh%kind /= [mesh_grid, mesh_inline])) return
    if (.not. allocated(state%analysis%mesh%element)) return
    kind = element_from_name(state%analysis%mesh%element)
    if (kind == 0 .or. state%points(i)%per_element == 0) return
    allocate (counts, source=allowed_counts(kind))
    if (any(counts == state%points(i)%per_element)) return
    list = integer_text(counts(1))
    do k = 2, size(counts)
      list = list//', '//integer_text(counts(k))
    end do
    call state%messages%add(severity_error, state%points(i)%place, 'POINTS', 'PER ELEMENT = '// &
      integer_text(state%points(i)%per_element)//' is not a number of points '// &
      state%analysis%mesh%element//' allows: '//list)
  end subroutine check_count
end module qsmpm_deck_bodies
