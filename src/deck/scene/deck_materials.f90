!> Cards of materials: *MATERIAL and the properties that belong to the last one.
module qsmpm_deck_materials
  use qsmpm_kinds, only: wp, pi
  use qsmpm_material_description, only: locking_none
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_soil_laws, only: add_soil_law_keywords
  use qsmpm_deck_profile, only: add_profile_keyword
  use qsmpm_deck_objects, only: list_materials
  use qsmpm_deck_k0, only: add_k0_keyword
  use qsmpm_deck_softening, only: add_softening_keyword
  use qsmpm_deck_state, only: deck_state_type, source_line
  use qsmpm_deck_strength_constants, only: add_strength_constants_keyword
  use qsmpm_deck_undrained, only: add_undrained_keyword
  use qsmpm_deck_user_material, only: add_user_material_keywords
  use qsmpm_deck_value_fields, only: add_value_fields_keyword
  use qsmpm_deck_words, only: bar_list
  use qsmpm_keyword_table, only: table_type, in_model, in_material, once, many
  use qsmpm_permeability_law, only: permeability_constant, permeability_logarithm, permeability_words
  implicit none
  private

  public :: add_material_keywords

  !> Radians.
  real(wp), parameter :: degree = pi/180.0_wp

contains

  !> *MATERIAL and its properties.
  subroutine add_material_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('MATERIAL', in_model, many, 'Begins a material; its properties follow.', material_fields, &
      '*MATERIAL, NAME=clay|*ELASTIC| 200, 0.33|*MOHR COULOMB| 1, 25, 0|*UNIT WEIGHT| 20', list=list_materials, &
      opens='material')
    call table%add('ELASTIC', in_material, once, 'Isotropic elasticity.', elastic_fields, '*ELASTIC| 200, 0.33')
    call table%add('MOHR COULOMB', in_material, once, 'Strength after Mohr and Coulomb; phi = 0 is Tresca. Angles '// &
      'in degrees.', strength_fields, '*MOHR COULOMB| 1, 25, 0, 0', check_strength)
    call add_softening_keyword(table)
    call add_soil_law_keywords(table)
    call add_profile_keyword(table)
    call add_value_fields_keyword(table)
    call add_undrained_keyword(table)
    call table%add('UNIT WEIGHT', in_material, once, 'Weight per volume; *GRAVITY multiplies '// &
      'it. A material without the card is weightless.', weight_fields, '*UNIT WEIGHT| 18, 20')
    call table%add('PERMEABILITY', in_material, once, 'How much water soil lets through: its volume a unit of '// &
      'area, time and gradient of the head. For *WATER LEVEL, TYPE=SEEPAGE, and *CONSOLIDATION, whose time it gives.', &
      permeability_fields, '*PERMEABILITY| 1e-5|*PERMEABILITY, LAW=LOGARITHM, VOID RATIO=1.8, CK=0.9| 1e-4|'// &
      '*PERMEABILITY, DRAINABLE POROSITY=0.25, ALPHA=1.5, N=1.6| 1e-6', &
      check_permeability)
    call add_k0_keyword(table)
    call table%add('VOLUMETRIC LOCKING', in_material, once, 'Treatment of volumetric locking: the points '// &
      'of a cell share one pressure. For flow at constant volume, nearly incompressible elasticity, '// &
      'and soil under rigid bodies; it costs accuracy where the pressure varies smoothly.', locking_fields, &
      '*VOLUMETRIC LOCKING, TYPE=UNIFORM PRESSURE, FACTOR=0.5')
    call add_user_material_keywords(table)
    call add_strength_constants_keyword(table)
  end subroutine add_material_keywords

  !> *MATERIAL.
  subroutine material_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (material => deck%analysis%materials(deck%material))
      call fields%line(material%where)
      call fields%name('NAME', material%name, 'name of the material', required=.true.)
    end associate
  end subroutine material_fields

  !> *ELASTIC; a card with an error counts as given: the material is not said to be without elasticity as well.
  subroutine elastic_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (material => deck%analysis%materials(deck%material))
      call fields%there(material%young > 0.0_wp)
      if (fields%reading) material%young = 1.0_wp
      call fields%data('elastic constants')
      call fields%number('E', material%young, "Young's modulus", range='(0, inf)')
      call fields%number('nu', material%poisson, "Poisson's ratio", range='(-1, 0.5)')
    end associate
  end subroutine elastic_fields

  !> *MOHR COULOMB.
  subroutine strength_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (material => deck%analysis%materials(deck%material))
      call fields%given(material%mohr_coulomb)
      call fields%data('strength')
      call fields%number('c', material%cohesion, 'cohesion', range='[0, inf)')
      call fields%number('phi', material%friction_angle, 'friction angle', range='[0, 90)')
      call fields%number('psi', material%dilatancy_angle, 'dilatancy angle, not above phi', range='[0, 90)')
      call fields%number('tensile strength', material%tensile_strength, 'largest principal stress; NONE (the '// &
        'default) leaves the tip of the yield surface', range='[0, inf)', required=.false., none='NONE', also='sigma_t')
    end associate
  end subroutine strength_fields

  !> There is strength, dilatancy is not above friction, and the tensile strength has a meaning.
  subroutine check_strength(state)
    type(deck_state_type), intent(inout) :: state

    if (.not. state%card%is_right()) return
    associate (material => state%analysis%materials(state%material))
      if (material%tensile_strength < huge(1.0_wp) .and. material%tensile_strength*sin(material%friction_angle*degree) &
        > material%cohesion*cos(material%friction_angle*degree)) call state%warn(source_line(state%card%place), &
        'MOHR COULOMB', 'the tensile strength lies beyond the tip of the yield surface, c cot phi: it has no effect')
      if (material%dilatancy_angle > material%friction_angle) call state%error_at(state%card%rows(1), &
        'the dilatancy angle psi is above the friction angle phi')
      if (max(material%cohesion, material%friction_angle) <= 0.0_wp) call state%error_at(state%card%rows(1), &
        'cohesion and friction angle are both zero: the material has no strength')
    end associate
  end subroutine check_strength

  !> *UNIT WEIGHT.
  subroutine weight_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (material => deck%analysis%materials(deck%material))
      call fields%data('weight')
      call fields%number('gamma', material%unit_weight, 'weight per volume', range='[0, inf)')
      call fields%number('gamma_sat', material%saturated_weight, 'the same below the water level; gamma when not '// &
        'given', range='[0, inf)', required=.false.)
    end associate
  end subroutine weight_fields

  !> *PERMEABILITY.
  subroutine permeability_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (k => deck%analysis%materials(deck%material)%permeability, &
        law => deck%analysis%materials(deck%material)%permeability_law)
      call fields%there(k(1) >= 0.0_wp)
      call fields%choice('LAW', law%kind, bar_list(permeability_words), 'how it follows the void ratio e under '// &
        '*CONSOLIDATION. KOZENY: as e^3/(1 + e), LOGARITHM: ten times as small where e has fallen by CK')
      call fields%number('VOID RATIO', law%void_ratio, 'that of the soil as drawn, or where *INITIAL sets its '// &
        'stresses', range='(0, inf)', needs='LAW=KOZENY|LOGARITHM')
      call fields%number('CK', law%index, 'fall of e; about half of VOID RATIO for clays', range='(0, inf)', &
        needs='LAW=LOGARITHM')
      call fields%number('DRAINABLE POROSITY', deck%analysis%materials(deck%material)%drainable_porosity, &
        'water that a unit volume gives off as the surface of the water falls past it; for FLOW=TRANSIENT of '// &
        '*WATER LEVEL', range='(0, 1)')
      call fields%number('ALPHA', law%alpha, '1 over a height of suction: how much water soil holds and lets '// &
        'through there, by van Genuchten and Mualem. DRAINABLE POROSITY is porosity less what never leaves. '// &
        'Linear over a cell when not given', range='(0, inf)')
      call fields%number('N', law%n, 'slope of that curve; 1.1 to 1.5 in clay and silt, 2 to 4 in sand', &
        range='[1.01, 20]', needs='ALPHA')
      call fields%data('permeability')
      call fields%number('k', k(1), 'along x; 0 for what is tight', range='[0, inf)')
      if (fields%reading) k(2:) = k(1)
      call fields%number('k_y', k(2), 'along y; k when not given', range='[0, inf)', required=.false.)
      call fields%number('k_z', k(3), 'along z; k when not given', range='[0, inf)', required=.false., third=.true.)
    end associate
  end subroutine permeability_fields

  !> What a law wants to know.
  subroutine check_permeability(state)
    type(deck_state_type), intent(inout) :: state

    associate (law => state%analysis%materials(state%material)%permeability_law)
      if (law%kind /= permeability_constant .and. &
        .not. state%card%has('VOID RATIO')) call state%report_error('LAW wants the parameter VOID RATIO')
      if (law%kind == permeability_logarithm .and. &
        .not. state%card%has('CK')) call state%report_error('LAW=LOGARITHM wants the parameter CK: half of VOID '// &
        'RATIO for many clays')
      if (state%card%has('ALPHA') .and. .not. state%card%has('N')) call state%report_error('ALPHA wants the '// &
        'parameter N: 1.1 to 1.5 for clay and silt, 2 to 4 for sand')
    end associate
  end subroutine check_permeability

  !> *VOLUMETRIC LOCKING.
  subroutine locking_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (material => deck%analysis%materials(deck%material))
      call fields%choice('TYPE', material%locking_treatment, 'NONE|AUTO|UNIFORM PRESSURE', &
        'AUTO: uniform pressure when nu is '// &
        'above 0.45, for Mohr-Coulomb with phi = 0, and for any Mohr-Coulomb on linear elements and GIMP, else none', &
        first=locking_none)
      call fields%number('FACTOR', material%pressure_factor, 'resistance to volume changes inside a cell over '// &
        'the shear modulus, of the secant of a step in which soil flows; when not given 1, 0.1 for phi = 0 '// &
        'that does not crack, on cells that go with the ground 0.45 and 0.22, and 0.5 for elasticity, on linear '// &
        'elements and, but for phi = 0, with GIMP', &
        range='(0, inf)', needs='TYPE=AUTO|UNIFORM PRESSURE')
    end associate
  end subroutine locking_fields
end module qsmpm_deck_materials
