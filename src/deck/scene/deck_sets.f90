!> Cards that name parts of the mesh: *NSET, *ELSET, *SURFACE.
module qsmpm_deck_sets
  use qsmpm_kinds, only: wp
  use qsmpm_mesh_description, only: set_type, select_list, select_box, select_plane, select_segment, select_mesh, &
    select_outline
  use qsmpm_cards, only: whole_at
  use qsmpm_card_fields, only: card_fields_type, column_type
  use qsmpm_deck_objects, only: list_node_sets, list_element_sets, list_surfaces
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_deck_words, only: bar_list, axis_words, surface_words
  use qsmpm_keyword_table, only: table_type, in_model, many
  implicit none
  private

  public :: add_set_keywords, box_fields, check_box

  !> A longer run of labels is a typing error.
  integer, parameter :: longest_run = 10000000
  !> What the words of TYPE of *SURFACE select.
  integer, parameter :: selections(4) = [select_box, select_segment, select_mesh, select_outline]

contains

  !> *NSET, *ELSET, *SURFACE.
  subroutine add_set_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('NSET', in_model, many, 'A set of nodes: by labels, or those on a plane, or '// &
      'those in a box.', node_set_fields, '*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=corner, BOX| 0, 0.1, 0, 0.1', &
      finish_node_set, list=list_node_sets, opens='set')
    call table%add('ELSET', in_model, many, 'A set of elements: by labels, or those whose centre is in a box.', &
      element_set_fields, '*ELSET, ELSET=soil, GENERATE| 1, 99, 2', finish_element_set, list=list_element_sets, &
      opens='set')
    call table%add('SURFACE', in_model, many, 'A piece of the surface of the bodies, for tractions.', surface_fields, &
      '*SURFACE, NAME=top, TYPE=SEGMENT| 2, 1, 0, 1|*SURFACE, NAME=face, TYPE=OUTLINE, BODY=slope, BOX| 3, 4, 0, 1', &
      check_surface, list=list_surfaces, opens='surface')
  end subroutine add_set_keywords

  !> *NSET.
  subroutine node_set_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    real(wp) :: coordinate

    associate (set => deck%analysis%node_sets(deck%item))
      call fields%line(set%where)
      call fields%name('NSET', set%name, 'name of the set', required=.true.)
      call fields%choice('PLANE', set%axis, bar_list(axis_words), 'nodes on the plane at right angles to this axis', &
        open=.true., excludes='BOX|GENERATE')
      coordinate = 0.0_wp
      if (set%axis > 0) coordinate = set%box(set%axis, 1)
      call list_parameters(fields, set)
      call fields%data('plane', when='PLANE')
      call fields%number('coordinate', coordinate, 'where the plane cuts the axis')
      call list_columns(fields, set)
      if (.not. fields%reading .or. set%axis == 0) return
      set%selection = select_plane
      set%box(set%axis, 1) = coordinate
    end associate
  end subroutine node_set_fields

  !> *ELSET.
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

  !> Parameters of sets given by labels or a box.
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

  !> Data lines of sets given by labels or a box; runs of labels are written out.
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

  !> Columns of a box.
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

  !> Rest of *NSET.
  subroutine finish_node_set(state)
    type(deck_state_type), intent(inout) :: state
    type(set_type) :: set

    set = state%analysis%node_sets(state%item)
    if (set%axis > state%dimension .and. state%dimension > 0) call state%report_error('PLANE=Z has no meaning in a '// &
      'plane model')
    call finish_set(set, state)
    state%analysis%node_sets(state%item) = set
  end subroutine finish_node_set

  !> Rest of *ELSET.
  subroutine finish_element_set(state)
    type(deck_state_type), intent(inout) :: state
    type(set_type) :: set

    set = state%analysis%element_sets(state%item)
    call finish_set(set, state)
    state%analysis%element_sets(state%item) = set
  end subroutine finish_element_set

  !> Runs of labels, and a box that is one.
  subroutine finish_set(set, state)
    type(set_type), intent(inout) :: set
    type(deck_state_type), intent(inout) :: state

    if (set%selection == select_box) call check_box(.false., set%box, state)
    if (state%card%has('GENERATE') .and. set%selection == select_list) call read_runs(set%labels, state)
  end subroutine finish_set

  !> Runs of labels, written out.
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
          ! Counted from 0: a label beyond the last one may be no integer.
          step = max(1, whole_at(row, 3))
          labels = [labels, (whole_at(row, 1) + k*step, k=0, (whole_at(row, 2) - whole_at(row, 1))/step)]
        end if
      end associate
    end do
  end subroutine read_runs

  !> A box is the right way round.
  subroutine check_box(solid, box, state)
    !> The box needs a volume; else it may be a plane, a line or a point.
    logical, intent(in) :: solid
    !> Lower and upper corner (3,2); the third component is 0 in the plane.
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

  !> *SURFACE.
  subroutine surface_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    integer :: type

    associate (surface => deck%analysis%surfaces(deck%item))
      call fields%line(surface%where)
      call fields%name('NAME', surface%name, 'name of the surface', required=.true.)
      type = findloc(selections, surface%selection, dim=1)
      call fields%choice('TYPE', type, bar_list(surface_words), 'BOX: element faces in a box. SEGMENT: straight '// &
        'lines in a plane model, the body to their left. MESH: the surface of this name in the '// &
        'mesh file. OUTLINE: the bounds of a body (BOX, POLYGON, POLYHEDRON), also inside elements')
      surface%selection = selections(type)
      call fields%name('BODY', surface%body, 'the body', needs='TYPE=OUTLINE')
      call fields%flag('BOX', surface%boxed, 'what of the outline is in a box', needs='TYPE=OUTLINE')
      call fields%data('box', when='TYPE=BOX')
      call box_fields(fields, surface%box)
      call fields%table('segments', [column_type('x1', 'start'), column_type('y1', 'start'), column_type('x2', 'end'), &
        column_type('y2', 'end')], surface%segments, when='TYPE=SEGMENT')
      call fields%data('box', when='BOX')
      call box_fields(fields, surface%box)
    end associate
  end subroutine surface_fields

  !> Segments have a length, boxes are the right way round, an outline has a body.
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
        if (.not. state%card%has('BODY')) call state%report_error('TYPE=OUTLINE wants the parameter BODY')
        if (surface%boxed) call check_box(.false., surface%box, state)
      case (select_box)
        call check_box(.false., surface%box, state)
      end select
    end associate
  end subroutine check_surface
end module qsmpm_deck_sets
