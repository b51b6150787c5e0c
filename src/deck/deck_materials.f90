!> Cards of materials: *MATERIAL and the properties that belong to the last one.
module qsmpm_deck_materials
  use qsmpm_kinds, only: wp, pi
  use qsmpm_analysis, only: material_type
  use qsmpm_text, only: squeezed
  use qsmpm_cards, only: card_type, number_at, word_at
  use qsmpm_deck_hardening, only: add_hardening_keywords
  use qsmpm_deck_words, only: bar_list, position_of, cure_words
  use qsmpm_deck_state, only: deck_state_type, source_line
  use qsmpm_deck_softening, only: add_softening_keyword
  use qsmpm_analysis_lists, only: append
  use qsmpm_deck_user_material, only: add_user_material_keywords
  use qsmpm_keyword_table, only: table_type, in_model, in_material, once, many, kind_name, &
    kind_real, kind_word
  implicit none
  private

  public :: add_material_keywords

  !> Radians.
  real(wp), parameter :: degree = pi/180.0_wp

contains

  !> Entries of *MATERIAL, *ELASTIC, *MOHR COULOMB, *SOFTENING, *UNIT WEIGHT, *K0, *VOLUMETRIC LOCKING.
  subroutine add_material_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table

    call table%add('MATERIAL', in_model, many, 'Begins a material; its properties follow.', &
      handle_material)
    call table%parameter('NAME', kind_name, 'name of the material', required=.true.)
    call table%example('*MATERIAL, NAME=clay|*ELASTIC| 200, 0.33|*MOHR COULOMB| 1, 25, 0|*UNIT '// &
      'WEIGHT| 20')

    call table%add('ELASTIC', in_material, once, 'Isotropic elasticity.', handle_elastic)
    call table%data('elastic constants', 1, 1)
    call table%column('E', kind_real, "Young's modulus", range='(0, inf)')
    call table%column('nu', kind_real, "Poisson's ratio", range='(-1, 0.5)')
    call table%example('*ELASTIC| 200, 0.33')

    call table%add('MOHR COULOMB', in_material, once, 'Strength after Mohr and Coulomb; phi = '// &
      '0 is Tresca. Angles in degrees.', handle_mohr_coulomb)
    call table%data('strength', 1, 1)
    call table%column('c', kind_real, 'cohesion', range='[0, inf)')
    call table%column('phi', kind_real, 'friction angle', range='[0, 90)')
    call table%column('psi', kind_real, 'dilatancy angle, not above phi', range='[0, 90)')
    call table%column('tensile strength', kind_real, 'largest principal stress; NONE (the '// &
      'default) leaves the tip of the yield surface', required=.false., allowed='NONE', &
      range='[0, inf)')
    call table%example('*MOHR COULOMB| 1, 25, 0, 0')

    call add_softening_keyword(table)
    call add_hardening_keywords(table)

    call table%add('UNIT WEIGHT', in_material, once, 'Weight per volume; *GRAVITY multiplies '// &
      'it. A material without the card is weightless.', handle_unit_weight)
    call table%data('weight', 1, 1)
    call table%column('gamma', kind_real, 'weight per volume', range='[0, inf)')
    call table%example('*UNIT WEIGHT| 20')

    call table%add('K0', in_material, once, 'Horizontal over vertical stress of the material at the start, in the '// &
      'place of that of *INITIAL, TYPE=K0.', handle_k0)
    call table%data('ratio', 1, 1)
    call table%column('k0', kind_real, 'horizontal over vertical stress', range='(0, inf)')
    call table%example('*K0| 0.5')

    call add_cure(table)
    call add_user_material_keywords(table)
  end subroutine add_material_keywords

  !> Entry of *VOLUMETRIC LOCKING.
  subroutine add_cure(table)
    type(table_type), intent(inout) :: table
    type(material_type) :: material

    call table%add('VOLUMETRIC LOCKING', in_material, once, 'Treatment of volumetric locking: the points '// &
      'of a cell share one pressure. For flow at constant volume and nearly incompressible '// &
      'elasticity; it costs accuracy where the pressure varies smoothly.', handle_cure)
    call table%parameter('TYPE', kind_word, 'AUTO: uniform pressure when nu is above 0.45, for '// &
      'Mohr-Coulomb with phi = 0, and for any Mohr-Coulomb on linear elements and GIMP, else none', &
      default=trim(cure_words(material%cure)), allowed=bar_list(cure_words))
    call table%parameter('FACTOR', kind_real, 'resistance to volume changes inside a cell over '// &
      'the shear modulus; 0.5 on linear elements and 0.1 on others when not given', &
      range='(0, inf)', needs='TYPE=AUTO|UNIFORM PRESSURE')
    call table%example('*VOLUMETRIC LOCKING, TYPE=UNIFORM PRESSURE, FACTOR=0.5')
  end subroutine add_cure

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

    associate (material => state%analysis%materials(size(state%analysis%materials)))
      ! A faulty card counts as given: the material is not said to be without elasticity as well.
      material%young = 1.0_wp
      if (.not. sound(card)) return
      material%young = number_at(card%rows(1), 1)
      material%poisson = number_at(card%rows(1), 2)
    end associate
  end subroutine handle_elastic

  !> *MOHR COULOMB.
  subroutine handle_mohr_coulomb(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    associate (material => state%analysis%materials(size(state%analysis%materials)))
      material%mohr_coulomb = .true.
      if (.not. sound(card)) return
      material%cohesion = number_at(card%rows(1), 1)
      material%friction_angle = number_at(card%rows(1), 2)
      material%dilatancy_angle = number_at(card%rows(1), 3)
      if (size(card%rows(1)%items) == 4) then
        if (word_at(card%rows(1), 4) /= 'NONE') &
          material%tensile_strength = number_at(card%rows(1), 4)
      end if
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

    if (sound(card)) state%analysis%materials(size(state%analysis%materials))%unit_weight = &
      number_at(card%rows(1), 1)
  end subroutine handle_unit_weight

  !> *K0.
  subroutine handle_k0(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    if (sound(card)) state%analysis%materials(size(state%analysis%materials))%k0 = number_at(card%rows(1), 1)
  end subroutine handle_k0

  !> *VOLUMETRIC LOCKING.
  subroutine handle_cure(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    associate (material => state%analysis%materials(size(state%analysis%materials)))
      material%cure = position_of(card%word('TYPE'), cure_words) - 1
      if (card%has('FACTOR')) material%cure_factor = card%number('FACTOR')
    end associate
  end subroutine handle_cure

  !> Whether a card has a first data line to read.
  pure logical function sound(card)
    type(card_type), intent(in) :: card

    sound = .false.
    if (size(card%rows) > 0) sound = card%rows(1)%good
  end function sound
end module qsmpm_deck_materials
