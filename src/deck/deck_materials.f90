!> Cards of materials: *MATERIAL and the properties that belong to the last one.
module qsmpm_deck_materials
  use qsmpm_kinds, only: wp, pi
  use qsmpm_analysis, only: material_type, cure_none
  use qsmpm_text, only: squeezed
  use qsmpm_cards, only: card_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_card_visitors, only: describer_type, reader_type, writer_type, reader
  use qsmpm_deck_hardening, only: add_hardening_keywords, echo_hardening
  use qsmpm_deck_state, only: deck_state_type, source_line
  use qsmpm_deck_softening, only: add_softening_keyword, echo_softening
  use qsmpm_analysis_lists, only: append
  use qsmpm_deck_user_material, only: add_user_material_keywords, echo_user_material
  use qsmpm_echo_lines, only: echo_type, quoted
  use qsmpm_keyword_table, only: table_type, in_model, in_material, once, many, kind_name
  implicit none
  private

  public :: add_material_keywords, echo_material

  !> Radians.
  real(wp), parameter :: degree = pi/180.0_wp

contains

  !> Entries of *MATERIAL, *ELASTIC, *MOHR COULOMB, *SOFTENING, *UNIT WEIGHT, *K0, *VOLUMETRIC LOCKING.
  subroutine add_material_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table
    type(describer_type) :: elastic, strength, weight, ratio
    type(material_type) :: material

    call table%add('MATERIAL', in_model, many, 'Begins a material; its properties follow.', &
      handle_material)
    call table%parameter('NAME', kind_name, 'name of the material', required=.true.)
    call table%example('*MATERIAL, NAME=clay|*ELASTIC| 200, 0.33|*MOHR COULOMB| 1, 25, 0|*UNIT '// &
      'WEIGHT| 20')

    call table%add('ELASTIC', in_material, once, 'Isotropic elasticity.', handle_elastic)
    call table%data('elastic constants', 1, 1)
    call elastic_fields(elastic, material)
    call table%take(elastic%items)
    call table%example('*ELASTIC| 200, 0.33')

    call table%add('MOHR COULOMB', in_material, once, 'Strength after Mohr and Coulomb; phi = '// &
      '0 is Tresca. Angles in degrees.', handle_mohr_coulomb)
    call table%data('strength', 1, 1)
    call strength_fields(strength, material)
    call table%take(strength%items)
    call table%example('*MOHR COULOMB| 1, 25, 0, 0')

    call add_softening_keyword(table)
    call add_hardening_keywords(table)

    call table%add('UNIT WEIGHT', in_material, once, 'Weight per volume; *GRAVITY multiplies '// &
      'it. A material without the card is weightless.', handle_unit_weight)
    call table%data('weight', 1, 1)
    call weight_fields(weight, material)
    call table%take(weight%items)
    call table%example('*UNIT WEIGHT| 20')

    call table%add('K0', in_material, once, 'Horizontal over vertical stress of the material at the start, in the '// &
      'place of that of *INITIAL, TYPE=K0.', handle_k0)
    call table%data('ratio', 1, 1)
    call ratio_fields(ratio, material)
    call table%take(ratio%items)
    call table%example('*K0| 0.5')

    call add_locking(table)
    call add_user_material_keywords(table)
  end subroutine add_material_keywords

  !> Data line of *ELASTIC.
  subroutine elastic_fields(fields, material)
    class(card_fields_type), intent(inout) :: fields
    type(material_type), intent(inout) :: material

    call fields%column('E', material%young, "Young's modulus", range='(0, inf)')
    call fields%column('nu', material%poisson, "Poisson's ratio", range='(-1, 0.5)')
  end subroutine elastic_fields

  !> Data line of *MOHR COULOMB.
  subroutine strength_fields(fields, material)
    class(card_fields_type), intent(inout) :: fields
    type(material_type), intent(inout) :: material

    call fields%column('c', material%cohesion, 'cohesion', range='[0, inf)')
    call fields%column('phi', material%friction_angle, 'friction angle', range='[0, 90)')
    call fields%column('psi', material%dilatancy_angle, 'dilatancy angle, not above phi', range='[0, 90)')
    call fields%column('tensile strength', material%tensile_strength, 'largest principal stress; NONE (the '// &
      'default) leaves the tip of the yield surface', range='[0, inf)', required=.false., none='NONE')
  end subroutine strength_fields

  !> Data line of *UNIT WEIGHT.
  subroutine weight_fields(fields, material)
    class(card_fields_type), intent(inout) :: fields
    type(material_type), intent(inout) :: material

    call fields%column('gamma', material%unit_weight, 'weight per volume', range='[0, inf)')
  end subroutine weight_fields

  !> Data line of *K0.
  subroutine ratio_fields(fields, material)
    class(card_fields_type), intent(inout) :: fields
    type(material_type), intent(inout) :: material

    call fields%column('k0', material%k0, 'horizontal over vertical stress', range='(0, inf)')
  end subroutine ratio_fields

  !> Entry of *VOLUMETRIC LOCKING.
  subroutine add_locking(table)
    type(table_type), intent(inout) :: table
    type(describer_type) :: fields
    type(material_type) :: material

    call table%add('VOLUMETRIC LOCKING', in_material, once, 'Treatment of volumetric locking: the points '// &
      'of a cell share one pressure. For flow at constant volume and nearly incompressible '// &
      'elasticity; it costs accuracy where the pressure varies smoothly.', handle_locking)
    call locking_fields(fields, material)
    call table%take(fields%items)
    call table%example('*VOLUMETRIC LOCKING, TYPE=UNIFORM PRESSURE, FACTOR=0.5')
  end subroutine add_locking

  !> Parameters of *VOLUMETRIC LOCKING.
  subroutine locking_fields(fields, material)
    class(card_fields_type), intent(inout) :: fields
    type(material_type), intent(inout) :: material

    call fields%choice('TYPE', material%cure, 'NONE|AUTO|UNIFORM PRESSURE', 'AUTO: uniform pressure when nu is '// &
      'above 0.45, for Mohr-Coulomb with phi = 0, and for any Mohr-Coulomb on linear elements and GIMP, else none', &
      first=cure_none)
    call fields%number('FACTOR', material%cure_factor, 'resistance to volume changes inside a cell over '// &
      'the shear modulus; 0.5 on linear elements and 0.1 on others when not given', &
      range='(0, inf)', needs='TYPE=AUTO|UNIFORM PRESSURE')
  end subroutine locking_fields

  !> *MATERIAL.
  subroutine handle_material(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(material_type) :: material
    integer :: i

    material%name = squeezed(card%value('NAME'))
    material%where = source_line(card%place)
    do i = 1, size(state%analysis%materials)
      if (state%analysis%materials(i)%name == material%name .and. len(material%name) > 0) &
        call state%fault(card, "there is already a material '"//material%name//"'")
    end do
    call append(state%analysis%materials, material)
  end subroutine handle_material

  !> *ELASTIC.
  subroutine handle_elastic(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    fields = reader(card)
    associate (material => state%analysis%materials(size(state%analysis%materials)))
      ! A faulty card counts as given: the material is not said to be without elasticity as well.
      material%young = 1.0_wp
      call elastic_fields(fields, material)
    end associate
  end subroutine handle_elastic

  !> *MOHR COULOMB.
  subroutine handle_mohr_coulomb(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    fields = reader(card)
    associate (material => state%analysis%materials(size(state%analysis%materials)))
      material%mohr_coulomb = .true.
      if (.not. sound(card)) return
      call strength_fields(fields, material)
      if (material%tensile_strength < huge(1.0_wp) .and. material%tensile_strength*sin(material%friction_angle*degree) &
        > material%cohesion*cos(material%friction_angle*degree)) call state%warn(source_line(card%place), &
        'MOHR COULOMB', 'the tensile strength lies beyond the tip of the yield surface, c cot phi: it has no effect')
      if (material%dilatancy_angle > material%friction_angle) call state%fault_at(card, &
        card%rows(1), 'the dilatancy angle psi is above the friction angle phi')
      if (max(material%cohesion, material%friction_angle) <= 0.0_wp) call state%fault_at(card, &
        card%rows(1), 'cohesion and friction angle are both zero: the material has no strength')
    end associate
  end subroutine handle_mohr_coulomb

  !> *UNIT WEIGHT.
  subroutine handle_unit_weight(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    fields = reader(card)
    call weight_fields(fields, state%analysis%materials(size(state%analysis%materials)))
  end subroutine handle_unit_weight

  !> *K0.
  subroutine handle_k0(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    fields = reader(card)
    call ratio_fields(fields, state%analysis%materials(size(state%analysis%materials)))
  end subroutine handle_k0

  !> *VOLUMETRIC LOCKING.
  subroutine handle_locking(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    fields = reader(card)
    call locking_fields(fields, state%analysis%materials(size(state%analysis%materials)))
  end subroutine handle_locking

  !> Whether a card has a first data line to read.
  pure logical function sound(card)
    type(card_type), intent(in) :: card

    sound = .false.
    if (size(card%rows) > 0) sound = card%rows(1)%good
  end function sound

  !> A material and its properties, as the echo writes them.
  subroutine echo_material(echo, from)
    type(echo_type), intent(inout) :: echo
    type(material_type), intent(in) :: from
    type(writer_type) :: fields
    type(material_type) :: material

    material = from
    call echo%line('*MATERIAL, NAME='//quoted(material%name))
    if (material%young > 0.0_wp) then
      call fields%begin('ELASTIC')
      call elastic_fields(fields, material)
      call fields%finish(echo)
    end if
    call echo_hardening(echo, material)
    if (material%user%given) call echo_user_material(echo, material)
    call fields%begin('UNIT WEIGHT')
    call weight_fields(fields, material)
    call fields%finish(echo)
    if (material%k0 > 0.0_wp) then
      call fields%begin('K0')
      call ratio_fields(fields, material)
      call fields%finish(echo)
    end if
    call fields%begin('VOLUMETRIC LOCKING')
    call locking_fields(fields, material)
    call fields%finish(echo)
    if (.not. material%mohr_coulomb) return
    call fields%begin('MOHR COULOMB')
    call strength_fields(fields, material)
    call fields%finish(echo)
    if (material%softening%given) call echo_softening(echo, material)
  end subroutine echo_material
end module qsmpm_deck_materials
