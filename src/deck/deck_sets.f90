!> Cards that name parts of the mesh: *NSET, *ELSET, *SURFACE.
module qsmpm_deck_sets
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: set_type, surface_type, select_list, select_box, select_plane, &
    select_segment, select_mesh, select_outline
  use qsmpm_text, only: squeezed
  use qsmpm_cards, only: card_type, row_type, number_at, whole_at
  use qsmpm_deck_state, only: deck_state_type, source_line
  use qsmpm_deck_words, only: bar_list, position_of, axis_words, surface_words
  use qsmpm_analysis_lists, only: append
  use qsmpm_keyword_table, only: table_type, in_model, many, kind_word, kind_name, kind_flag, &
    kind_integer, kind_real
  implicit none
  private

  public :: add_set_keywords, box_columns, read_box

  !> A longer run of labels is a typing error.
  integer, parameter :: longest_run = 10000000

contains

  !> Entries of *NSET, *ELSET, *SURFACE.
  subroutine add_set_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table

    call table%add('NSET', in_model, many, 'A set of nodes: by labels, or those on a plane, or '// &
      'those in a box.', handle_nset)
    call table%parameter('NSET', kind_name, 'name of the set', required=.true.)
    call table%parameter('PLANE', kind_word, 'nodes on the plane at right angles to this axis', &
      allowed=bar_list(axis_words), excludes='BOX|GENERATE')
    call add_list_parameters(table)
    call table%data('plane', 1, 1, when='PLANE')
    call table%column('coordinate', kind_real, 'where the plane cuts the axis')
    call add_list_columns(table)
    call table%example('*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=corner, BOX| 0, 0.1, 0, 0.1')

    call table%add('ELSET', in_model, many, 'A set of elements: by labels, or those whose '// &
      'centre is in a box.', handle_elset)
    call table%parameter('ELSET', kind_name, 'name of the set', required=.true.)
    call add_list_parameters(table)
    call add_list_columns(table)
    call table%example('*ELSET, ELSET=soil, GENERATE| 1, 99, 2')

    call table%add('SURFACE', in_model, many, 'A piece of the surface of the bodies, for '// &
      'tractions.', handle_surface)
    call table%parameter('NAME', kind_name, 'name of the surface', required=.true.)
    call table%parameter('TYPE', kind_word, 'BOX: element faces in a box. SEGMENT: straight '// &
      'lines in a plane model, the body to their left. MESH: the surface of this name in the '// &
      'mesh file. OUTLINE: the bounds of a body (BOX, POLYGON, POLYHEDRON), also inside elements', &
      default=trim(surface_words(1)), allowed=bar_list(surface_words))
    call table%parameter('BODY', kind_name, 'the body', needs='TYPE=OUTLINE')
    call table%parameter('BOX', kind_flag, 'what of the outline is in a box', needs='TYPE=OUTLINE')
    call table%data('box', 1, 1, when='TYPE=BOX')
    call box_columns(table)
    call table%data('segments', 1, huge(1), when='TYPE=SEGMENT')
    call table%column('x1', kind_real, 'start')
    call table%column('y1', kind_real, 'start')
    call table%column('x2', kind_real, 'end')
    call table%column('y2', kind_real, 'end')
    call table%data('box', 1, 1, when='BOX')
    call box_columns(table)
    call table%example('*SURFACE, NAME=top, TYPE=SEGMENT| 2, 1, 0, 1|'// &
      '*SURFACE, NAME=face, TYPE=OUTLINE, BODY=slope, BOX| 3, 4, 0, 1')
  end subroutine add_set_keywords

  !> Parameters of sets given by labels or a box.
  subroutine add_list_parameters(table)
    type(table_type), intent(inout) :: table

    call table%parameter('BOX', kind_flag, 'those in a box', excludes='GENERATE')
    call table%parameter('GENERATE', kind_flag, 'labels by first, last and step')
  end subroutine add_list_parameters

  !> Data lines of sets given by labels or a box.
  subroutine add_list_columns(table)
    type(table_type), intent(inout) :: table

    call table%data('box', 1, 1, when='BOX')
    call box_columns(table)
    call table%data('runs of labels', 1, huge(1), when='GENERATE')
    call table%column('first', kind_integer, 'first label', range='[1, inf)')
    call table%column('last', kind_integer, 'last label', range='[1, inf)')
    call table%column('step', kind_integer, 'step between labels, 1 when not given', &
      required=.false., range='[1, inf)')
    call table%data('labels', 1, huge(1))
    call table%column('label', kind_integer, 'label', range='[1, inf)', repeated=.true.)
  end subroutine add_list_columns

  !> Columns of a box.
  subroutine box_columns(table)
    !> The table of keywords; its last data lines get the columns.
    type(table_type), intent(inout) :: table

    call table%column('xmin', kind_real, 'least x')
    call table%column('xmax', kind_real, 'largest x')
    call table%column('ymin', kind_real, 'least y')
    call table%column('ymax', kind_real, 'largest y')
    call table%column('zmin', kind_real, 'least z', third=.true.)
    call table%column('zmax', kind_real, 'largest z', third=.true.)
  end subroutine box_columns

  !> *NSET.
  subroutine handle_nset(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(set_type) :: set

    call read_set(card, 'NSET', state%analysis%node_sets, set, state)
    if (card%has('PLANE')) then
      set%selection = select_plane
      set%axis = position_of(card%word('PLANE'), axis_words)
      if (set%axis > state%dimension .and. state%dimension > 0) call state%fault(card, &
        'PLANE=Z has no meaning in a plane model')
      if (size(card%rows) > 0 .and. set%axis > 0) set%box(set%axis, 1) = number_at(card%rows(1), 1)
    end if
    call append(state%analysis%node_sets, set)
  end subroutine handle_nset

  !> *ELSET.
  subroutine handle_elset(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(set_type) :: set

    call read_set(card, 'ELSET', state%analysis%element_sets, set, state)
    call append(state%analysis%element_sets, set)
  end subroutine handle_elset

  !> A set by labels or box, with a name that is new.
  subroutine read_set(card, parameter, others, set, state)
    type(card_type), intent(in) :: card
    !> Parameter that holds the name.
    character(len=*), intent(in) :: parameter
    !> Sets so far.
    type(set_type), intent(in) :: others(:)
    !> The set.
    type(set_type), intent(out) :: set
    type(deck_state_type), intent(inout) :: state
    integer :: i

    set%name = squeezed(card%value(parameter))
    set%where = source_line(card%place)
    do i = 1, size(others)
      if (others(i)%name == set%name .and. len(set%name) > 0) call state%fault(card, &
        "there is already a set '"//set%name//"'")
    end do
    if (card%has('PLANE')) then
      return
    else if (card%has('BOX')) then
      set%selection = select_box
      call read_box(card, .false., set%box, state)
    else
      call read_labels(card, set%labels, state)
    end if
  end subroutine read_set

  !> Labels in the order written; runs written out.
  subroutine read_labels(card, labels, state)
    type(card_type), intent(in) :: card
    !> The labels.
    integer, allocatable, intent(out) :: labels(:)
    type(deck_state_type), intent(inout) :: state
    integer :: i, k, step

    allocate (labels(0))
    do i = 1, size(card%rows)
      associate (row => card%rows(i))
        if (.not. row%good) cycle
        if (.not. card%has('GENERATE')) then
          labels = [labels, (whole_at(row, k), k=1, size(row%items))]
        else if (whole_at(row, 2) < whole_at(row, 1)) then
          call state%fault_at(card, row, 'the last label is below the first')
        else if (whole_at(row, 2) - whole_at(row, 1) > longest_run) then
          call state%fault_at(card, row, 'the run of labels is too long')
        else
          ! Counted from 0: a label beyond the last one may be no integer.
          step = max(1, whole_at(row, 3))
          labels = [labels, (whole_at(row, 1) + k*step, &
            k=0, (whole_at(row, 2) - whole_at(row, 1))/step)]
        end if
      end associate
    end do
  end subroutine read_labels

  !> The box of a data line.
  subroutine read_box(card, solid, box, state)
    !> The card.
    type(card_type), intent(in) :: card
    !> The box needs a volume; else it may be a plane, a line or a point.
    logical, intent(in) :: solid
    !> Lower and upper corner (3,2); the third component is 0 in the plane.
    real(wp), intent(out) :: box(3, 2)
    !> Gains the errors.
    type(deck_state_type), intent(inout) :: state
    integer :: i

    box = 0.0_wp
    if (size(card%rows) == 0) return
    if (.not. card%rows(1)%good) return
    do i = 1, min(3, size(card%rows(1)%items)/2)
      box(i, :) = [number_at(card%rows(1), 2*i - 1), number_at(card%rows(1), 2*i)]
      if (box(i, 1) > box(i, 2)) then
        call state%fault_at(card, card%rows(1), 'the least '//trim(axis_words(i))// &
          ' is above the largest')
      else if (solid .and. .not. box(i, 2) > box(i, 1)) then
        call state%fault_at(card, card%rows(1), 'the box has no extent along '//trim(axis_words(i)))
      end if
    end do
  end subroutine read_box

  !> *SURFACE.
  subroutine handle_surface(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(surface_type) :: surface
    integer :: i

    surface%name = squeezed(card%value('NAME'))
    surface%where = source_line(card%place)
    do i = 1, size(state%analysis%surfaces)
      if (state%analysis%surfaces(i)%name == surface%name .and. len(surface%name) > 0) &
        call state%fault(card, "there is already a surface '"//surface%name//"'")
    end do
    select case (card%word('TYPE'))
    case ('BOX')
      surface%selection = select_box
      call read_box(card, .false., surface%box, state)
    case ('SEGMENT')
      surface%selection = select_segment
      if (state%dimension == 3) call state%fault(card, 'TYPE=SEGMENT is for plane models')
      call read_segments(card, surface, state)
    case ('MESH')
      surface%selection = select_mesh
    case ('OUTLINE')
      surface%selection = select_outline
      surface%body = squeezed(card%value('BODY'))
      surface%boxed = card%has('BOX')
      if (.not. card%has('BODY')) call state%fault(card, 'TYPE=OUTLINE wants the parameter BODY')
      if (surface%boxed) call read_box(card, .false., surface%box, state)
    end select
    call append(state%analysis%surfaces, surface)
  end subroutine handle_surface

  !> Segments, each of some length.
  subroutine read_segments(card, surface, state)
    type(card_type), intent(in) :: card
    type(surface_type), intent(inout) :: surface
    type(deck_state_type), intent(inout) :: state
    integer :: i, k

    allocate (surface%segments(4, size(card%rows)))
    do i = 1, size(card%rows)
      surface%segments(:, i) = [(number_at(card%rows(i), k), k=1, 4)]
      if (.not. card%rows(i)%good) cycle
      if (.not. norm2(surface%segments(3:, i) - surface%segments(:2, i)) > 0.0_wp) &
        call state%fault_at(card, card%rows(i), 'the segment has no length')
    end do
  end subroutine read_segments
end module qsmpm_deck_sets
