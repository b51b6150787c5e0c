!> *HISTORY: a column of the curves.
module qsmpm_deck_histories
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_history_description, only: history_type, quantity_reaction, quantity_state, quantity_prop_force, &
    quantity_discharge
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_objects, only: list_histories
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_deck_words, only: bar_list, axis_words, tensor_words
  use qsmpm_history_quantities, only: history_quantities, has_components, component_number, component_none, &
    component_tensor, unit_of_history, is_taken_at, at_rigid_body
  use qsmpm_keyword_table, only: table_type, in_model, many
  implicit none
  private

  public :: add_history_keyword, give_units

contains

  !> *HISTORY.
  subroutine add_history_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('HISTORY', in_model, many, 'A column of curves.csv. DISPLACEMENT and '// &
      'POSITION follow a massless tracer that starts at the place given; STRESS, STRAIN, PORE PRESSURE and STATE '// &
      'are those of the nearest material point; REACTION is the sum over a node set or a supported surface '// &
      '(as contact forces, of effective stresses: the pressure of water at rest comes on top); VOLUME is that of a '// &
      'body; RUNOUT how far the front of a body has moved along an axis; CONTACT FORCE and CONTACT '// &
      'MOMENT (about z) what the soil does to a rigid body, BODY MOVE and BODY ROTATION how far this has moved '// &
      'and turned about z (degrees); CONTACT SLIP how far soil has slid along it since they touched; CONTACT '// &
      'PRESSURE is that on the soil around a place as drawn, a mean over the length of a patch; PROP FORCE '// &
      'that of a prop, tension positive; TIME that of the phases; EXCESS PRESSURE the largest there is of '// &
      '*CONSOLIDATION, by its size; DISCHARGE what flows in (negative: out) by a row of *WATER LEVEL, '// &
      'TYPE=SEEPAGE in a unit of time. *STOP ends a phase by one.', &
      history_fields, '*HISTORY, NAME=crest, QUANTITY=DISPLACEMENT, COMPONENT=Y| 1.0, 1.0|'// &
      '*HISTORY, NAME=force, QUANTITY=REACTION, COMPONENT=Y, NSET=plate|'// &
      '*HISTORY, NAME=toe, QUANTITY=RUNOUT, COMPONENT=X, BODY=slope', check_history, list=list_histories, &
      opens='history')
  end subroutine add_history_keyword

  !> *HISTORY.
  subroutine history_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    character(len=len(history_quantities%word)) :: words(size(history_quantities))
    integer :: i

    words = [(history_quantities(i)%word, i=1, size(words))]
    associate (history => deck%analysis%histories(deck%item))
      call fields%line(history%where)
      call fields%name('NAME', history%name, 'name of the column', required=.true.)
      if (fields%reading) history%quantity = 0
      call fields%choice('QUANTITY', history%quantity, bar_list(words), 'what is recorded', required=.true.)
      call component_field(fields, history)
      call fields%name('UNIT', history%unit, 'unit in the header; made of *UNITS when not given')
      call fields%number('SCALE', history%scale, 'factor of the values')
      call fields%name('NSET', history%set, 'node set', needs='QUANTITY=REACTION|DISCHARGE')
      call fields%name('SURFACE', history%surface, 'surface, in place of NSET: held by *SUPPORT or '// &
        '*CONTRACTION, or with a level', needs='QUANTITY=REACTION|DISCHARGE')
      call fields%name('BODY', history%body, 'body; all when not given, but of CONTACT FORCE, CONTACT MOMENT, '// &
        'CONTACT SLIP, BODY MOVE and BODY ROTATION, whose rigid body must be named', &
        needs='QUANTITY=VOLUME|RUNOUT|CONTACT FORCE|CONTACT MOMENT|CONTACT SLIP|BODY MOVE|BODY ROTATION')
      call fields%name('PROP', history%prop, 'the prop', needs='QUANTITY=PROP FORCE')
      call fields%answer('MEAN', history%mean, 'YES: the mean over what is in contact, not the largest', &
        needs='QUANTITY=CONTACT SLIP')
      call fields%answer('SMALLEST', history%smallest, 'the front is where the coordinate is smallest, and moves '// &
        'against the axis', needs='QUANTITY=RUNOUT')
      call fields%name('STATE', history%state, 'state variable: its name in the results (plastic_strain, '// &
        'SDV3_void_ratio) or, of a *USER MATERIAL, its number', needs='QUANTITY=STATE')
      call fields%data('place', when='QUANTITY=DISPLACEMENT|POSITION|STRESS|STATE|STRAIN|'// &
        'PORE PRESSURE|CONTACT PRESSURE')
      call fields%number('x', history%at(1), 'coordinate')
      call fields%number('y', history%at(2), 'coordinate')
      call fields%number('z', history%at(3), 'coordinate', third=.true.)
    end associate
  end subroutine history_fields

  !> The component: of a vector, or, behind those in the list of words, of a tensor.
  subroutine component_field(fields, history)
    class(card_fields_type), intent(inout) :: fields
    type(history_type), intent(inout) :: history
    integer :: word, before

    before = merge(size(axis_words), 0, has_components(history%quantity, component_tensor))
    word = before + history%component
    if (fields%reading .or. has_components(history%quantity, component_none)) word = 0
    call fields%choice('COMPONENT', word, bar_list(axis_words)//'|'//bar_list(tensor_words), 'X, Y, Z for vectors, '// &
      'XX to YZ for STRESS and STRAIN; wanted of quantities that have components', open=.true.)
    if (.not. fields%reading) return
    history%component = max(0, word - before)
    if (before == 0 .and. word > size(axis_words)) history%component = 0
  end subroutine component_field

  !> The component is one of the quantity, and what the quantity needs is there.
  subroutine check_history(state)
    type(deck_state_type), intent(inout) :: state

    associate (history => state%analysis%histories(state%item))
      if (history%quantity == quantity_state .and. &
        .not. state%card%has('STATE')) call state%report_error('QUANTITY=STATE wants the parameter STATE')
      if (has_components(history%quantity, component_none)) then
        if (state%card%has('COMPONENT')) call state%report_error('COMPONENT has no meaning with QUANTITY='// &
          state%card%word('QUANTITY'))
      else if (history%quantity > 0) then
        if (.not. state%card%has('COMPONENT')) call state%report_error('the parameter COMPONENT is missing')
        call check_component(history, state)
      end if
      if (.not. abs(history%scale) > 0.0_wp) call state%warn(history%where, 'HISTORY', &
        "SCALE=0: the column '"//history%name//"' will be zero throughout")
      if (is_taken_at(history%quantity, at_rigid_body) .and. &
        .not. state%card%has('BODY')) call state%report_error('QUANTITY='//state%card%word('QUANTITY')// &
        ' wants the parameter BODY, a rigid body')
      if (history%quantity == quantity_prop_force .and. &
        .not. state%card%has('PROP')) call state%report_error('QUANTITY=PROP FORCE wants the parameter PROP')
      if (any(history%quantity == [quantity_reaction, quantity_discharge]) .and. &
        (state%card%has('NSET') .eqv. state%card%has('SURFACE'))) call state%report_error('QUANTITY='// &
        state%card%word('QUANTITY')//' wants one of the parameters NSET and SURFACE')
    end associate
  end subroutine check_history

  !> The component is one of a vector or of a tensor, and in the plane of a plane model.
  subroutine check_component(history, state)
    type(history_type), intent(in) :: history
    type(deck_state_type), intent(inout) :: state
    if (len(state%card%word('COMPONENT')) == 0) return
    if (history%component == 0) then
      call state%report_error('COMPONENT='//state%card%word('COMPONENT')//' is none of '// &
        state%card%word('QUANTITY')//': '//trim(merge('XX, YY, ZZ, XY, XZ, YZ', 'X, Y, Z               ', &
        has_components(history%quantity, component_tensor))))
    else if (history%component > component_number(history%quantity, state%dimension)) then
      call state%report_error('COMPONENT='//state%card%word('COMPONENT')//' has no meaning in a plane model')
    end if
  end subroutine check_component

  !> Units of the histories that have none of their own, when *UNITS and *MODEL are known.
  pure subroutine give_units(analysis)
    type(analysis_type), intent(inout) :: analysis
    integer :: i

    do i = 1, size(analysis%histories)
      analysis%histories(i)%unit = unit_of_history(analysis, analysis%histories(i))
    end do
  end subroutine give_units
end module qsmpm_deck_histories
