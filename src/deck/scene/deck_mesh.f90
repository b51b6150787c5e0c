!> Keywords of the mesh: *GRID, lines along the axes from segments with graded spacing or from a list; *REFINE of
!> body-fitted triangles; *MESH (a file), *NODE and *ELEMENT (in the deck).
module qsmpm_deck_mesh
  use qsmpm_kinds, only: wp, long
  use qsmpm_mesh_description, only: mesh_source_type, mesh_fitted, mesh_grid, diagonal_random, mesh_file, mesh_inline
  use qsmpm_element, only: element_from_name, local_dimension, node_count
  use qsmpm_text, only: integer_text, real_text, read_integer, read_real, number_good, integer_list, upper
  use qsmpm_cards, only: row_type, number_at, word_at, whole_at
  use qsmpm_card_fields, only: card_fields_type, column_type
  use qsmpm_card_items, only: in_range
  use qsmpm_deck_state, only: deck_state_type, source_line, list_mesh
  use qsmpm_keyword_table, only: table_type, in_model, once, many, bar_list, position_of, diagonal_words, &
    element_words, axis_words, format_words
  use qsmpm_card_visitors, only: numbers
  use qsmpm_file, only: extension_of
  use qsmpm_messages, only: severity_error
  implicit none
  private

  public :: add_grid_keyword, check_inline_mesh

  !> A larger grid is a typing error.
  integer, parameter :: most_lines = 1000000, most_cells = 50000000
  character(len=*), parameter :: ratio_range = '[1e-6, 1e6]'
  !> Relative tolerance for segments that meet, the round-off of decimal numbers.
  real(wp), parameter :: meeting = 1.0e-12_wp

contains

  !> Adds the keywords *GRID, *REFINE, *MESH, *NODE, *ELEMENT.
  subroutine add_grid_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('GRID', in_model, once, 'A structured background mesh.', grid_fields, &
      '*GRID, ELEMENT=WEDGE15| X, 0, 2, 8| X, 2, 6, 6, 3| Y, 0, 1, 8| Z, LINES, 0, 0.25', finish_grid, list=list_mesh, &
      opens='mesh')
    call table%add('REFINE', in_model, once, 'Boxes in which body-fitted triangles are smaller than the cells of '// &
      '*GRID, with a gradual transition around them: for failure zones and corners. A box of zero size refines at '// &
      'a point. The smallest size is an eighth of a grid cell; re-entrant corners of the soil and edges of loads '// &
      'are refined by default. `qsmpm-verify study` determines the boxes.', refine_fields, &
      '*REFINE| 0, 2, -1, 0, 0.1| 2, 2, 0, 0, 0.05', check_boxes)
    call table%add('MESH', in_model, once, 'A mesh file with its named sets.', file_fields, '*MESH, INPUT=slope.msh', &
      finish_file, list=list_mesh, opens='mesh')
    call table%add('NODE', in_model, many, 'Nodes of a mesh in the deck.', node_fields, &
      '*NODE| 1, 0, 0| 2, 1, 0| 3, 0, 1', read_nodes, list=list_mesh, opens='mesh')
    call table%add('ELEMENT', in_model, many, 'Elements of a mesh in the deck, all of one '// &
      'type. The nodes come in the order of VTK: corners, then mid nodes.', element_fields, &
      '*ELEMENT, TYPE=TRI3| 1, 1, 2, 3', read_elements, list=list_mesh, opens='mesh')
  end subroutine add_grid_keyword

  !> Describes the fields of *GRID.
  subroutine grid_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    logical :: fits

    associate (mesh => deck%analysis%mesh)
      fits = mesh%kind == mesh_fitted
      call fields%there(fits .or. mesh%kind == mesh_grid)
      call fields%line(mesh%where)
      call fields%word('ELEMENT', mesh%element, bar_list(element_words), 'element; bricks are divided into '// &
        'triangles, wedges or tetrahedra; when not given, HEX8 in 3D and in the plane TRI6 with FIT=YES, or QUAD4 '// &
        'where a grid is better: rigid bodies, bodies activated in their drawn shape, smooth elastic problems; its '// &
        'lines move onto interfaces of bodies normal to an axis (the log reports which)')
      call fields%choice('DIAGONAL', mesh%diagonal, bar_list(diagonal_words), 'direction of the diagonals of '// &
        'triangles', &
        needs='ELEMENT=TRI3|TRI6|WEDGE6|WEDGE15')
      call fields%number('PERTURB', mesh%perturbation, 'random shift of interior nodes, relative to the smallest '// &
        'adjacent spacing', range='[0, 0.3]')
      if (fields%writing .and. .not. is_random(mesh)) mesh%seed = 0
      call fields%whole('SEED', mesh%seed, 'seed of the random numbers', range='[1, inf)')
      call fields%answer('WINDOW', mesh%windowed, 'use only the part of the grid around the material, which '// &
        'follows it: the cost does not depend on the empty grid, and the results are the same; output of the mesh '// &
        'shows this part')
      call fields%answer('FIT', fits, 'body-fitted triangles, with edges on the outlines of bodies and rigid '// &
        'bodies and the size of the grid cells (docs/methods/fitted.md)', needs='ELEMENT=TRI3|TRI6')
      if (fields%reading) mesh%kind = merge(mesh_fitted, mesh_grid, fits)
      call fields%answer('REFIT', mesh%refits, 'body-fitted triangles move with the material unless *METHOD is '// &
        'given; YES: when elements become too distorted the run continues with splines on the grid; NO: it ends '// &
        'there', &
        needs='FIT=YES')
      call fields%data('`axis, first, last, number of intervals [, last spacing / first spacing]` '// &
        'or `axis, LINES, v1, v2, ...`; a further line of an axis continues from its last '// &
        'value', 0, huge(1), free=.true.)
      if (fields%writing .and. .not. fields%left_out) call write_axes(fields, mesh, deck%dimension)
    end associate
  end subroutine grid_fields

  !> Checks whether a grid has a random property.
  pure logical function is_random(mesh)
    type(mesh_source_type), intent(in) :: mesh

    is_random = mesh%perturbation > 0.0_wp .or. mesh%diagonal == diagonal_random
  end function is_random

  !> Describes the lines along the axes.
  subroutine write_axes(fields, mesh, dimension)
    class(card_fields_type), intent(inout) :: fields
    type(mesh_source_type), intent(in) :: mesh
    !> 2 or 3.
    integer, intent(in) :: dimension
    character(len=:), allocatable :: text
    integer :: axis, i

    do axis = 1, dimension
      associate (lines => mesh%axes(axis)%lines)
        do i = 1, size(lines)
          text = ' '//real_text(lines(i))
          if (i == 1) text = ' '//trim(axis_words(axis))//', LINES,'//text
          if (i < size(lines)) text = text//','
          call fields%raw(text)
        end do
      end associate
    end do
  end subroutine write_axes

  !> Reads the lines along the axes, and checks them.
  subroutine finish_grid(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i, before

    if (state%card%has('SEED') .and. .not. is_random(state%analysis%mesh)) call state%report_error('parameter SEED '// &
      'has no meaning without PERTURB > 0 or DIAGONAL=RANDOM')
    call check_element_dimension(state)
    before = state%messages%error_count()
    do i = 1, size(state%card%rows)
      if (state%card%rows(i)%good) call read_axis_row(state%card%rows(i), state)
    end do
    if (state%messages%error_count() == before) call check_axes(state)
  end subroutine finish_grid

  !> Checks that the element belongs to models of this dimension.
  subroutine check_element_dimension(state)
    type(deck_state_type), intent(inout) :: state
    integer :: kind

    kind = element_from_name(state%analysis%mesh%element)
    if (kind == 0 .or. state%dimension == 0) return
    if (local_dimension(kind) == state%dimension) return
    if (state%dimension == 2) then
      call state%report_error(state%analysis%mesh%element//' is an element of 3D models, *MODEL is plane')
    else
      call state%report_error(state%analysis%mesh%element//' is an element of plane models, *MODEL is 3D')
    end if
  end subroutine check_element_dimension

  !> Reads one data line.
  subroutine read_axis_row(row, state)
    type(row_type), intent(in) :: row
    type(deck_state_type), intent(inout) :: state
    real(wp), allocatable :: values(:)
    integer :: axis

    axis = position_of(word_at(row, 1), axis_words)
    if (axis == 0) then
      call state%error_at(row, "'"//row%items(1)%text//"' is not an axis: X, Y or Z")
    else if (axis > state%dimension .and. state%dimension > 0) then
      call state%error_at(row, 'a plane model has no Z axis')
    else
      if (word_at(row, 2) == 'LINES') then
        call read_lines_row(row, values, state)
      else
        call read_segment_row(row, values, state)
      end if
      if (allocated(values)) call extend_axis(row, axis, values, state)
    end if
  end subroutine read_axis_row

  !> Reads a data line: axis, LINES, v1, v2, ...
  subroutine read_lines_row(row, values, state)
    type(row_type), intent(in) :: row
    !> The values, unallocated if there is an error.
    real(wp), allocatable, intent(out) :: values(:)
    type(deck_state_type), intent(inout) :: state
    integer :: i, n

    n = size(row%items) - 2
    if (n < 1) call state%error_at(row, 'LINES requires at least one value')
    if (n < 1) return
    if (.not. all_numbers(row, 3, state)) return
    values = [(number_at(row, i), i=3, n + 2)]
  end subroutine read_lines_row

  !> Reads a data line: axis, first, last, number of intervals [, ratio].
  subroutine read_segment_row(row, values, state)
    type(row_type), intent(in) :: row
    !> The values, unallocated if there is an error.
    real(wp), allocatable, intent(out) :: values(:)
    type(deck_state_type), intent(inout) :: state
    real(wp) :: ratio
    integer :: n, outcome

    if (size(row%items) < 4 .or. size(row%items) > 5) then
      call state%error_at(row, integer_text(size(row%items))//' item(s) where axis, first, last, number of '// &
        'intervals [, ratio] are required')
      return
    end if
    if (.not. all_numbers(row, 2, state)) return
    call read_integer(row%items(4)%text, n, outcome)
    ratio = 1.0_wp
    if (size(row%items) == 5) ratio = number_at(row, 5)
    if (outcome /= number_good .or. n < 1 .or. n > most_lines) then
      call state%error_at(row, "number of intervals '"//row%items(4)%text//"' is not a whole number in [1, "// &
        integer_text(most_lines)//']')
    else if (.not. number_at(row, 3) > number_at(row, 2)) then
      call state%error_at(row, 'the last coordinate is not above the first')
    else if (.not. in_range(ratio, ratio_range)) then
      call state%error_at(row, 'ratio = '//row%items(5)%text//' is outside '//ratio_range)
    else if (n == 1 .and. size(row%items) == 5) then
      call state%error_at(row, 'a ratio has no meaning for one interval')
    else
      call graded(number_at(row, 2), number_at(row, 3), n, ratio, values)
    end if
  end subroutine read_segment_row

  !> Checks whether all items from a given one on are numbers, and reports those that are not.
  logical function all_numbers(row, first, state)
    type(row_type), intent(in) :: row
    !> First item that must be a number.
    integer, intent(in) :: first
    type(deck_state_type), intent(inout) :: state
    real(wp) :: number
    integer :: i, outcome

    all_numbers = .true.
    do i = first, size(row%items)
      call read_real(row%items(i)%text, number, outcome)
      if (outcome == number_good) cycle
      all_numbers = .false.
      call state%error_at(row, "'"//row%items(i)%text//"' is not a finite number")
    end do
  end function all_numbers

  !> Returns coordinates whose spacings grow by a constant factor; the ends are exact.
  pure subroutine graded(first, last, n, ratio, values)
    real(wp), intent(in) :: first, last
    integer, intent(in) :: n
    !> Last spacing over first spacing.
    real(wp), intent(in) :: ratio
    !> The coordinates (n+1).
    real(wp), allocatable, intent(out) :: values(:)
    real(wp) :: spacing, total, reached(n)
    integer :: i

    allocate (values(n + 1))
    values(1) = first
    total = 0.0_wp
    do i = 1, n
      spacing = 1.0_wp
      if (n > 1) spacing = ratio**(real(i - 1, wp)/real(n - 1, wp))
      total = total + spacing
      reached(i) = total
    end do
    do i = 2, n
      values(i) = first + (last - first)*(reached(i - 1)/reached(n))
    end do
    values(n + 1) = last
  end subroutine graded

  !> Extends the lines along an axis.
  subroutine extend_axis(row, axis, values, state)
    type(row_type), intent(in) :: row
    !> 1, 2 or 3.
    integer, intent(in) :: axis
    !> New coordinates; the first may repeat the last existing one.
    real(wp), intent(in) :: values(:)
    type(deck_state_type), intent(inout) :: state
    real(wp), allocatable :: lines(:)
    real(wp) :: last
    integer :: from

    allocate (lines(0))
    from = 1
    if (allocated(state%analysis%mesh%axes(axis)%lines)) then
      lines = state%analysis%mesh%axes(axis)%lines
      last = lines(size(lines))
      if (abs(values(1) - last) <= meeting*max(abs(last), abs(values(1)))) then
        from = 2
      else if (word_at(row, 2) /= 'LINES') then
        call state%error_at(row, 'the segment begins at '//row%items(2)%text//', but the one before ends at '// &
          real_text(last))
        return
      end if
    end if
    lines = [lines, values(from:)]
    if (any(.not. lines(2:) > lines(:size(lines) - 1))) then
      call state%error_at(row, 'the coordinates do not increase')
      return
    end if
    state%analysis%mesh%axes(axis)%lines = lines
  end subroutine extend_axis

  !> Checks that every axis has an interval, and that the grid is not too large.
  subroutine check_axes(state)
    type(deck_state_type), intent(inout) :: state
    integer(long) :: cells
    integer :: axis

    cells = 1
    do axis = 1, max(2, state%dimension)
      if (.not. allocated(state%analysis%mesh%axes(axis)%lines)) allocate (state%analysis%mesh%axes(axis)%lines(0))
      associate (lines => state%analysis%mesh%axes(axis)%lines)
        if (size(lines) < 2) call state%report_error('the '//trim(axis_words(axis))//' axis has no interval')
        cells = min(cells*max(1, size(lines) - 1), int(most_cells, long) + 1)
      end associate
    end do
    if (cells > most_cells) call state%report_error('the grid has more than '//integer_text(most_cells)//' cells')
  end subroutine check_axes

  !> Describes the fields of *MESH.
  subroutine file_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (mesh => deck%analysis%mesh)
      call fields%there(mesh%kind == mesh_file)
      if (fields%reading) mesh%kind = mesh_file
      call fields%line(mesh%where)
      call fields%file('INPUT', mesh%file, 'the file, relative to the deck', required=.true.)
      call fields%word('FORMAT', mesh%format, bar_list(format_words), 'format of the file; when not given .msh: '// &
        'GMSH, .inp: ABAQUS', open=.true.)
    end associate
  end subroutine file_fields

  !> Checks that the file exists and that its format is known.
  subroutine finish_file(state)
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: path

    call state%find_file('INPUT', path)
    associate (mesh => state%analysis%mesh)
      mesh%file = path
      if (len(mesh%format) > 0 .or. len(state%card%value('INPUT')) == 0) return
      select case (upper(extension_of(mesh%file)))
      case ('.MSH')
        mesh%format = 'GMSH'
      case ('.INP')
        mesh%format = 'ABAQUS'
      case default
        call state%report_error("the format of '"//state%card%value('INPUT')//"' does not follow from its name; "// &
          "give FORMAT=GMSH or FORMAT=ABAQUS")
      end select
    end associate
  end subroutine finish_file

  !> Begins a mesh in the deck, without nodes or elements.
  subroutine begin_inline(fields, mesh)
    class(card_fields_type), intent(inout) :: fields
    type(mesh_source_type), intent(inout) :: mesh

    call fields%there(mesh%kind == mesh_inline)
    if (.not. fields%reading .or. mesh%kind == mesh_inline) return
    mesh%kind = mesh_inline
    call fields%line(mesh%where)
    allocate (mesh%node_labels(0), mesh%nodes(3, 0), mesh%element_labels(0), mesh%connectivity(0, 0))
    mesh%element = ''
  end subroutine begin_inline

  !> Describes the fields of *NODE.
  subroutine node_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    real(wp) :: x(3)
    integer :: i, label

    x = 0.0_wp
    label = 0
    associate (mesh => deck%analysis%mesh)
      call begin_inline(fields, mesh)
      if (fields%writing .and. mesh%kind == mesh_inline) then
        do i = 1, size(mesh%node_labels)
          call fields%raw(' '//integer_text(mesh%node_labels(i))//', '//numbers(mesh%nodes(:deck%dimension, i)))
        end do
      else
        call fields%data('nodes', 1, huge(1))
        call fields%whole('label', label, 'label of the node', range='[1, inf)')
        call fields%vector('', x, 'coordinate')
      end if
    end associate
  end subroutine node_fields

  !> Reads the nodes of a card, which may be numerous.
  subroutine read_nodes(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i, k

    associate (mesh => state%analysis%mesh, rows => state%card%rows)
      mesh%node_labels = [mesh%node_labels, (whole_at(rows(i), 1), i=1, size(rows))]
      mesh%nodes = reshape([mesh%nodes, ((number_at(rows(i), k), k=2, 4), i=1, size(rows))], &
        [3, size(mesh%nodes, 2) + size(rows)])
      call check_unique(mesh%node_labels, 'node', state)
    end associate
  end subroutine read_nodes

  !> Describes the fields of *ELEMENT.
  subroutine element_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    integer, allocatable :: labels(:)
    character(len=:), allocatable :: type
    integer :: i, label

    label = 0
    associate (mesh => deck%analysis%mesh)
      call begin_inline(fields, mesh)
      if (fields%writing) type = mesh%element
      call fields%word('TYPE', type, bar_list(element_words), 'element', required=.true.)
      if (fields%writing .and. mesh%kind == mesh_inline) then
        do i = 1, size(mesh%element_labels)
          call fields%raw(' '//integer_list([mesh%element_labels(i), mesh%connectivity(:, i)]))
        end do
      else
        call fields%data('elements', 1, huge(1))
        call fields%whole('label', label, 'label of the element', range='[1, inf)')
        call fields%labels('node', labels, 'label of a node', range='[1, inf)')
      end if
    end associate
  end subroutine element_fields

  !> Reads the elements of a card.
  subroutine read_elements(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i, k, n, before

    associate (mesh => state%analysis%mesh, rows => state%card%rows)
      if (len(mesh%element) == 0) then
        mesh%element = state%card%word('TYPE')
        mesh%where = source_line(state%card%place)
        call check_element_dimension(state)
      else if (mesh%element /= state%card%word('TYPE')) then
        call state%report_error('elements of a mesh in the deck are all of one type, here '//mesh%element)
        return
      end if
      if (element_from_name(mesh%element) == 0) return
      n = node_count(element_from_name(mesh%element))
      do i = 1, size(rows)
        if (rows(i)%good .and. size(rows(i)%items) /= n + 1) call state%error_at(rows(i), &
          integer_text(size(rows(i)%items) - 1)//' nodes where '//mesh%element//' has '//integer_text(n))
      end do
      before = size(mesh%element_labels)
      mesh%element_labels = [mesh%element_labels, (whole_at(rows(i), 1), i=1, size(rows))]
      mesh%connectivity = reshape([mesh%connectivity, &
        ((whole_at(rows(i), k), k=2, n + 1), i=1, size(rows))], [n, before + size(rows)])
      call check_unique(mesh%element_labels, 'element', state)
    end associate
    call keep_places(state)
  end subroutine read_elements

  !> Stores the positions of the elements in the deck.
  pure subroutine keep_places(state)
    type(deck_state_type), intent(inout) :: state

    state%element_places = [state%element_places, state%card%rows%place]
  end subroutine keep_places

  !> Checks that the labels of the last data lines of a list are new.
  subroutine check_unique(labels, what, state)
    !> All labels; those of the card at the end.
    integer, intent(in) :: labels(:)
    character(len=*), intent(in) :: what
    type(deck_state_type), intent(inout) :: state
    integer :: i, k

    do i = 1, size(state%card%rows)
      k = size(labels) - size(state%card%rows) + i
      if (.not. state%card%rows(i)%good) cycle
      if (any(labels(:k - 1) == labels(k))) call state%error_at(state%card%rows(i), 'there is already a '//what//' '// &
        integer_text(labels(k)))
    end do
  end subroutine check_unique

  !> Checks that a mesh in the deck has nodes and elements, and that every node of an element exists.
  subroutine check_inline_mesh(state)
    type(deck_state_type), intent(inout) :: state
    integer :: e, k

    associate (mesh => state%analysis%mesh)
      if (mesh%kind /= mesh_inline) return
      if (size(mesh%node_labels) == 0) call state%error_from(mesh%where, 'NODE', 'there are no nodes')
      if (size(mesh%element_labels) == 0) call state%error_from(mesh%where, 'ELEMENT', 'there are no elements')
      if (state%messages%error_count() > 0) return
      do e = 1, size(mesh%element_labels)
        do k = 1, size(mesh%connectivity, 1)
          associate (node => mesh%connectivity(k, e), place => state%element_places(e))
            if (.not. any(mesh%node_labels == node)) call state%messages%add(severity_error, &
              place, 'ELEMENT', 'there is no node '//integer_text(node))
            if (any(mesh%connectivity(:k - 1, e) == node)) call state%messages%add(severity_error, &
              place, 'ELEMENT', 'node '//integer_text(node)//' is named twice')
          end associate
        end do
      end do
    end associate
  end subroutine check_inline_mesh

  !> Describes the fields of *REFINE.
  subroutine refine_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (mesh => deck%analysis%mesh)
      call fields%there(allocated(mesh%refined))
      call fields%table('boxes', [column_type('xmin', 'least x'), column_type('xmax', 'largest x'), &
        column_type('ymin', 'least y'), column_type('ymax', 'largest y'), &
        column_type('width', 'width of the triangles', range='(0, inf)')], mesh%refined)
    end associate
  end subroutine refine_fields

  !> Checks that the upper corner of a box is not below the lower one.
  subroutine check_boxes(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (refined => state%analysis%mesh%refined)
      do i = 1, size(refined, 2)
        if (refined(2, i) < refined(1, i) .or. refined(4, i) < refined(3, i)) call state%error_at(state%card%rows(i), &
          'the box ends before it begins')
      end do
    end associate
  end subroutine check_boxes
end module qsmpm_deck_mesh
