!> Cards that bring a mesh along: *MESH (a file), *NODE and *ELEMENT (in the deck).
module qsmpm_deck_mesh
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: mesh_none, mesh_file, mesh_inline
  use qsmpm_element, only: element_from_name, node_count
  use qsmpm_text, only: integer_text, upper
  use qsmpm_path, only: directory_of, joined, extension_of, absolute_path
  use qsmpm_messages, only: place_type, severity_error
  use qsmpm_cards, only: card_type, number_at, whole_at
  use qsmpm_deck_state, only: deck_state_type, source_line
  use qsmpm_deck_words, only: bar_list, format_words, element_words
  use qsmpm_deck_grid, only: check_element_dimension
  use qsmpm_keyword_table, only: table_type, in_model, once, many, kind_word, kind_file, &
    kind_integer, kind_real
  implicit none
  private

  public :: add_mesh_keywords, check_inline_mesh

contains

  !> Entries of *MESH, *NODE, *ELEMENT.
  subroutine add_mesh_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table

    call table%add('MESH', in_model, once, 'A mesh file with its named sets.', handle_mesh)
    call table%parameter('INPUT', kind_file, 'the file, relative to the deck', required=.true.)
    call table%parameter('FORMAT', kind_word, 'form of the file; .msh is GMSH and .inp is '// &
      'ABAQUS when not given', allowed=bar_list(format_words))
    call table%example('*MESH, INPUT=slope.msh')

    call table%add('NODE', in_model, many, 'Nodes of a mesh in the deck.', handle_node)
    call table%data('nodes', 1, huge(1))
    call table%column('label', kind_integer, 'label of the node', range='[1, inf)')
    call table%column('x', kind_real, 'coordinate')
    call table%column('y', kind_real, 'coordinate')
    call table%column('z', kind_real, 'coordinate', third=.true.)
    call table%example('*NODE| 1, 0, 0| 2, 1, 0| 3, 0, 1')

    call table%add('ELEMENT', in_model, many, 'Elements of a mesh in the deck, all of one '// &
      'type. The nodes come in the order of VTK: corners, then mid nodes.', handle_element)
    call table%parameter('TYPE', kind_word, 'element', required=.true., &
      allowed=bar_list(element_words))
    call table%data('elements', 1, huge(1))
    call table%column('label', kind_integer, 'label of the element', range='[1, inf)')
    call table%column('node', kind_integer, 'label of a node', range='[1, inf)', repeated=.true.)
    call table%example('*ELEMENT, TYPE=TRI3| 1, 1, 2, 3')
  end subroutine add_mesh_keywords

  !> *MESH.
  subroutine handle_mesh(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    logical :: there

    if (.not. begin_mesh(card, mesh_file, state)) return
    associate (mesh => state%analysis%mesh)
      mesh%file = absolute_path(joined(directory_of(card%place%file), card%value('INPUT')))
      mesh%format = card%word('FORMAT')
      if (len(card%value('INPUT')) == 0) return
      inquire (file=mesh%file, exist=there)
      if (.not. there) call state%fault(card, "there is no file '"// &
        joined(directory_of(card%place%file), card%value('INPUT'))//"'")
      if (len(mesh%format) > 0) return
      select case (upper(extension_of(mesh%file)))
      case ('.MSH')
        mesh%format = 'GMSH'
      case ('.INP')
        mesh%format = 'ABAQUS'
      case default
        call state%fault(card, "the form of '"//card%value('INPUT')// &
          "' does not follow from its name; give FORMAT=GMSH or FORMAT=ABAQUS")
      end select
    end associate
  end subroutine handle_mesh

  !> Whether the mesh may come from a card: there is none yet, or one of the same kind.
  logical function begin_mesh(card, kind, state)
    type(card_type), intent(in) :: card
    !> mesh_file or mesh_inline.
    integer, intent(in) :: kind
    type(deck_state_type), intent(inout) :: state

    associate (mesh => state%analysis%mesh)
      begin_mesh = mesh%kind == mesh_none .or. (mesh%kind == mesh_inline .and. kind == mesh_inline)
      if (.not. begin_mesh) then
        call state%fault(card, 'the deck has a mesh already')
      else if (mesh%kind == mesh_none) then
        mesh%kind = kind
        mesh%where = source_line(card%place)
      end if
      if (begin_mesh .and. kind == mesh_inline .and. .not. allocated(mesh%node_labels)) then
        allocate (mesh%node_labels(0), mesh%nodes(3, 0), mesh%element_labels(0), &
          mesh%connectivity(0, 0))
        mesh%element = ''
      end if
    end associate
  end function begin_mesh

  !> *NODE.
  subroutine handle_node(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    integer :: i, k

    if (.not. begin_mesh(card, mesh_inline, state)) return
    associate (mesh => state%analysis%mesh, rows => card%rows)
      mesh%node_labels = [mesh%node_labels, (whole_at(rows(i), 1), i=1, size(rows))]
      mesh%nodes = reshape([mesh%nodes, ((number_at(rows(i), k), k=2, 4), i=1, size(rows))], &
        [3, size(mesh%nodes, 2) + size(rows)])
      call check_unique(card, mesh%node_labels, 'node', state)
    end associate
  end subroutine handle_node

  !> *ELEMENT.
  subroutine handle_element(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    integer :: i, k, n, before

    if (.not. begin_mesh(card, mesh_inline, state)) return
    associate (mesh => state%analysis%mesh, rows => card%rows)
      if (len(mesh%element) == 0) then
        mesh%element = card%word('TYPE')
        mesh%where = source_line(card%place)
        call check_element_dimension(card, state)
      else if (mesh%element /= card%word('TYPE')) then
        call state%fault(card, 'elements of a mesh in the deck are all of one type, here '// &
          mesh%element)
        return
      end if
      if (element_from_name(mesh%element) == 0) return
      n = node_count(element_from_name(mesh%element))
      do i = 1, size(rows)
        if (rows(i)%good .and. size(rows(i)%items) /= n + 1) call state%fault_at(card, rows(i), &
          integer_text(size(rows(i)%items) - 1)//' nodes where '//mesh%element//' has '// &
          integer_text(n))
      end do
      before = size(mesh%element_labels)
      mesh%element_labels = [mesh%element_labels, (whole_at(rows(i), 1), i=1, size(rows))]
      mesh%connectivity = reshape([mesh%connectivity, &
        ((whole_at(rows(i), k), k=2, n + 1), i=1, size(rows))], [n, before + size(rows)])
      call check_unique(card, mesh%element_labels, 'element', state)
    end associate
    call keep_places(card, state)
  end subroutine handle_element

  !> Remember where the elements were written.
  pure subroutine keep_places(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(place_type), allocatable :: longer(:)
    integer :: i, before

    before = size(state%element_places)
    allocate (longer(before + size(card%rows)))
    do i = 1, before
      longer(i) = state%element_places(i)
    end do
    do i = 1, size(card%rows)
      longer(before + i) = card%rows(i)%place
    end do
    call move_alloc(longer, state%element_places)
  end subroutine keep_places

  !> Labels of the last data lines of a list are not there before.
  subroutine check_unique(card, labels, what, state)
    !> The card.
    type(card_type), intent(in) :: card
    !> All labels; those of the card at the end.
    integer, intent(in) :: labels(:)
    !> Noun for the message.
    character(len=*), intent(in) :: what
    type(deck_state_type), intent(inout) :: state
    integer :: i, k

    do i = 1, size(card%rows)
      k = size(labels) - size(card%rows) + i
      if (.not. card%rows(i)%good) cycle
      if (any(labels(:k - 1) == labels(k))) call state%fault_at(card, card%rows(i), &
        'there is already a '//what//' '//integer_text(labels(k)))
    end do
  end subroutine check_unique

  !> A mesh in the deck has nodes and elements, and every node of an element is there.
  subroutine check_inline_mesh(state)
    !> The deck.
    type(deck_state_type), intent(inout) :: state
    integer :: e, k

    associate (mesh => state%analysis%mesh)
      if (mesh%kind /= mesh_inline) return
      if (size(mesh%node_labels) == 0) call state%fault_from(mesh%where, 'NODE', 'there are no '// &
        'nodes')
      if (size(mesh%element_labels) == 0) call state%fault_from(mesh%where, 'ELEMENT', &
        'there are no elements')
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
end module qsmpm_deck_mesh
