!> *HISTORY: a column of the curves.
module qsmpm_deck_histories
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type, history_type, plane_strain, axisymmetric, &
    quantity_displacement, quantity_position, quantity_stress, quantity_reaction, quantity_state
  use qsmpm_text, only: squeezed, real_text
  use qsmpm_cards, only: card_type, number_at
  use qsmpm_deck_state, only: deck_state_type, source_line
  use qsmpm_deck_words, only: bar_list, position_of, quantity_words, axis_words, tensor_words
  use qsmpm_analysis_lists, only: append
  use qsmpm_keyword_table, only: table_type, in_model, many, kind_word, kind_name, kind_real
  implicit none
  private

  public :: add_history_keyword, give_units

contains

  !> Entry of *HISTORY.
  subroutine add_history_keyword(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table
    type(history_type) :: history

    call table%add('HISTORY', in_model, many, 'A column of curves.csv. DISPLACEMENT and '// &
      'POSITION follow a massless tracer that starts at the place given; STRESS is '// &
      'that of the nearest material point, as is STATE; REACTION is the sum over a node set.', handle_history)
    call table%parameter('NAME', kind_name, 'name of the column', required=.true.)
    call table%parameter('QUANTITY', kind_word, 'what is recorded', required=.true., &
      allowed=bar_list(quantity_words))
    call table%parameter('COMPONENT', kind_word, 'X, Y, Z for vectors, XX to YZ for '// &
      'STRESS; wanted unless QUANTITY=STATE', allowed=bar_list(axis_words)//'|'//bar_list(tensor_words))
    call table%parameter('UNIT', kind_name, 'unit in the header; made of *UNITS when not given')
    call table%parameter('SCALE', kind_real, 'factor of the values', &
      default=real_text(history%scale))
    call table%parameter('NSET', kind_name, 'node set', needs='QUANTITY=REACTION')
    call table%parameter('STATE', kind_name, 'state variable: its name in the results (plastic_strain, '// &
      'SDV3_void_ratio) or, of a *USER MATERIAL, its number', needs='QUANTITY=STATE')
    call table%data('place', 1, 1, when='QUANTITY=DISPLACEMENT|POSITION|STRESS|STATE')
    call table%column('x', kind_real, 'coordinate')
    call table%column('y', kind_real, 'coordinate')
    call table%column('z', kind_real, 'coordinate', third=.true.)
    call table%example('*HISTORY, NAME=crest, QUANTITY=DISPLACEMENT, COMPONENT=Y| 1.0, 1.0|'// &
      '*HISTORY, NAME=force, QUANTITY=REACTION, COMPONENT=Y, NSET=plate')
  end subroutine add_history_keyword

  !> *HISTORY.
  subroutine handle_history(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(history_type) :: history
    integer :: i

    history%name = squeezed(card%value('NAME'))
    history%where = source_line(card%place)
    do i = 1, size(state%analysis%histories)
      if (state%analysis%histories(i)%name == history%name .and. len(history%name) > 0) &
        call state%fault(card, "there is already a history '"//history%name//"'")
    end do
    history%quantity = position_of(card%word('QUANTITY'), quantity_words)
    if (history%quantity == quantity_state) then
      history%state = squeezed(card%value('STATE'))
      if (.not. card%has('STATE')) call state%fault(card, 'QUANTITY=STATE wants the parameter STATE')
      if (card%has('COMPONENT')) call state%fault(card, 'COMPONENT has no meaning with QUANTITY=STATE')
    else if (history%quantity > 0) then
      if (.not. card%has('COMPONENT')) call state%fault(card, 'the parameter COMPONENT is missing')
      call read_component(card, history, state)
    end if
    history%unit = squeezed(card%value('UNIT'))
    history%scale = card%number('SCALE')
    if (.not. abs(history%scale) > 0.0_wp) call state%warn(history%where, 'HISTORY', &
      "SCALE=0: the column '"//history%name//"' will be zero throughout")
    if (size(card%rows) > 0) history%at = [(number_at(card%rows(1), i), i=1, 3)]
    if (history%quantity == quantity_reaction) then
      history%set = squeezed(card%value('NSET'))
      if (.not. card%has('NSET')) call state%fault(card, 'QUANTITY=REACTION wants the '// &
        'parameter NSET')
    end if
    call append(state%analysis%histories, history)
  end subroutine handle_history

  !> The component, which is one of a vector or of a tensor.
  subroutine read_component(card, history, state)
    type(card_type), intent(in) :: card
    type(history_type), intent(inout) :: history
    type(deck_state_type), intent(inout) :: state
    logical :: tensor

    tensor = history%quantity == quantity_stress
    if (tensor) then
      history%component = position_of(card%word('COMPONENT'), tensor_words)
    else
      history%component = position_of(card%word('COMPONENT'), axis_words)
    end if
    if (len(card%word('COMPONENT')) == 0) return
    if (history%component == 0) then
      call state%fault(card, 'COMPONENT='//card%word('COMPONENT')//' is none of '// &
        card%word('QUANTITY')//': '//trim(merge('XX, YY, ZZ, XY, XZ, YZ', &
        'X, Y, Z               ', tensor)))
    else if (state%dimension == 2 .and. history%component > merge(4, 2, tensor)) then
      call state%fault(card, 'COMPONENT='//card%word('COMPONENT')//' has no meaning in a plane '// &
        'model')
    end if
  end subroutine read_component

  !> Units of the histories that have none of their own, when *UNITS and *MODEL are known.
  pure subroutine give_units(analysis)
    !> The analysis.
    type(analysis_type), intent(inout) :: analysis
    integer :: i

    do i = 1, size(analysis%histories)
      associate (history => analysis%histories(i))
        if (len(history%unit) == 0) history%unit = unit_of(analysis, history%quantity)
      end associate
    end do
  end subroutine give_units

  !> Unit of a quantity; '-' when it has none or the deck declares none.
  pure function unit_of(analysis, quantity) result(unit)
    !> The analysis.
    type(analysis_type), intent(in) :: analysis
    !> One of the quantity_* values.
    integer, intent(in) :: quantity
    character(len=:), allocatable :: unit

    unit = '-'
    if (analysis%force_unit == '-') return
    select case (quantity)
    case (quantity_displacement, quantity_position)
      unit = analysis%length_unit
    case (quantity_stress)
      unit = analysis%force_unit//'/'//analysis%length_unit//'2'
    case (quantity_reaction)
      unit = analysis%force_unit
      if (analysis%model == axisymmetric) unit = unit//'/rad'
      if (analysis%model == plane_strain) unit = unit//'/'//analysis%length_unit
    end select
  end function unit_of
end module qsmpm_deck_histories
