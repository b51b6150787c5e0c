!> Cards that bring a mesh along: *MESH (a file), *NODE and *ELEMENT (in the deck); *REFINE of triangles that fit the
!> scene.
module qsmpm_deck_mesh
  use qsmpm_kinds, only: wp
  use qsmpm_mesh_description, only: mesh_source_type, mesh_file, mesh_inline
  use qsmpm_echo_lines, only: numbers
  use qsmpm_element, only: element_from_name, node_count
  use qsmpm_text, only: integer_list, integer_text, upper
  use qsmpm_path, only: directory_of, joined, extension_of
  use qsmpm_messages, only: severity_error
  use qsmpm_cards, only: number_at, whole_at
  use qsmpm_card_fields, only: card_fields_type, column_type
  use qsmpm_deck_grid, only: check_element_dimension
  use qsmpm_deck_objects, only: list_mesh
  use qsmpm_deck_state, only: deck_state_type, source_line, beside_deck
  use qsmpm_deck_words, only: bar_list, format_words, element_words
  use qsmpm_keyword_table, only: table_type, in_model, once, many
  implicit none
  private

  public :: add_mesh_keywords, check_inline_mesh

contains

  !> *REFINE, *MESH, *NODE, *ELEMENT.
  subroutine add_mesh_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('REFINE', in_model, once, 'Boxes in which triangles that fit the scene are smaller than the '// &
      'cells between the lines of *GRID, with cells in between around them: where ground fails, or a corner loads '// &
      'it. A corner is a box of no size. An eighth of a cell of the grid is the least; corners at which soil turns '// &
      'inwards and ends of loads have it anyway. `qsmpm-verify study` finds the boxes.', refine_fields, &
      '*REFINE| 0, 2, -1, 0, 0.1| 2, 2, 0, 0, 0.05', check_boxes)
    call table%add('MESH', in_model, once, 'A mesh file with its named sets.', file_fields, '*MESH, INPUT=slope.msh', &
      finish_file, list=list_mesh, opens='mesh')
    call table%add('NODE', in_model, many, 'Nodes of a mesh in the deck.', node_fields, &
      '*NODE| 1, 0, 0| 2, 1, 0| 3, 0, 1', read_nodes, list=list_mesh, opens='mesh')
    call table%add('ELEMENT', in_model, many, 'Elements of a mesh in the deck, all of one '// &
      'type. The nodes come in the order of VTK: corners, then mid nodes.', element_fields, &
      '*ELEMENT, TYPE=TRI3| 1, 1, 2, 3', read_elements, list=list_mesh, opens='mesh')
  end subroutine add_mesh_keywords

  !> *MESH.
  subroutine file_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (mesh => deck%analysis%mesh)
      call fields%there(mesh%kind == mesh_file)
      if (fields%reading) mesh%kind = mesh_file
      call fields%line(mesh%where)
      call fields%file('INPUT', mesh%file, 'the file, relative to the deck', required=.true.)
      call fields%word('FORMAT', mesh%format, bar_list(format_words), 'form of the file; .msh is GMSH and .inp is '// &
        'ABAQUS when not given', open=.true.)
    end associate
  end subroutine file_fields

  !> The file is there, and its form is known.
  subroutine finish_file(state)
    type(deck_state_type), intent(inout) :: state
    logical :: there

    associate (mesh => state%analysis%mesh)
      mesh%file = beside_deck(state%card, 'INPUT')
      if (len(state%card%value('INPUT')) == 0) return
      inquire (file=mesh%file, exist=there)
      if (.not. there) call state%report_error("there is no file '"//joined(directory_of(state%card%place%file), &
        state%card%value('INPUT'))//"'")
      if (len(mesh%format) > 0) return
      select case (upper(extension_of(mesh%file)))
      case ('.MSH')
        mesh%format = 'GMSH'
      case ('.INP')
        mesh%format = 'ABAQUS'
      case default
        call state%report_error("the form of '"//state%card%value('INPUT')//"' does not follow from its name; give "// &
          "FORMAT=GMSH or FORMAT=ABAQUS")
      end select
    end associate
  end subroutine finish_file

  !> A mesh in the deck that has no nodes or elements yet.
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

  !> *NODE.
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
        call fields%number('x', x(1), 'coordinate')
        call fields%number('y', x(2), 'coordinate')
        call fields%number('z', x(3), 'coordinate', third=.true.)
      end if
    end associate
  end subroutine node_fields

  !> The nodes of a card, which may be very many.
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

  !> *ELEMENT.
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

  !> The elements of a card.
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

  !> Remember where the elements were written.
  pure subroutine keep_places(state)
    type(deck_state_type), intent(inout) :: state

    state%element_places = [state%element_places, state%card%rows%place]
  end subroutine keep_places

  !> Labels of the last data lines of a list are not there before.
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

  !> A mesh in the deck has nodes and elements, and every node of an element is there.
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

  !> *REFINE.
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

  !> A box ends where it begins, or beyond.
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
