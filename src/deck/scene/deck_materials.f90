!> Keywords of materials: *MATERIAL and the properties of the last one, among them *SOFTENING and *K0, and the checks of
!> complete materials. The cards of the soil laws of qsmpm_law_factory are described by the laws themselves; nothing
!> here depends on a particular law.
module qsmpm_deck_materials
  use qsmpm_kinds, only: wp, pi
  use qsmpm_material_description, only: locking_none, material_type, traits_of
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_values_by_place, only: add_profile_keyword
  use qsmpm_deck_state, only: deck_state_type, source_line, list_materials
  use qsmpm_deck_user_material, only: add_user_material_keywords
  use qsmpm_deck_water, only: add_undrained_keyword
  use qsmpm_keyword_table, only: table_type, in_model, in_material, once, many, bar_list
  use qsmpm_permeability_law, only: permeability_constant, permeability_logarithm, permeability_words
  use qsmpm_phase_description, only: newton_modified, initial_k0
  use qsmpm_phase_loads, only: has_consolidation
  use qsmpm_material_parameters, only: regularise_nonlocal, softening_error
  use qsmpm_undrained_parameters, only: undrained_c
  use qsmpm_carried_cards, only: note_card
  use qsmpm_error, only: error_type
  use qsmpm_law_parameters, only: law_parameters_type, law_parameters_slot_type, law_description_type
  use qsmpm_principal_model, only: principal_model_type
  use qsmpm_soil_model, only: soil_model_type
  use qsmpm_law_factory, only: standard_laws
  use qsmpm_stress_at_rest, only: has_ratio, horizontal_at_rest, passive_ratio, unloading_poisson
  use qsmpm_rounded_text, only: rounded_text
  implicit none
  private

  public :: add_material_keywords, check_softening, check_k0

  !> One degree in radians.
  real(wp), parameter :: degree = pi/180.0_wp

  !> Round-off in the comparison of K0 with the passive ratio.
  real(wp), parameter :: rounding = 1.0e-9_wp

contains

  !> Adds *MATERIAL and its properties.
  subroutine add_material_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('MATERIAL', in_model, many, 'Begins a material; the keywords of its properties '// &
      'follow.', material_fields, &
      '*MATERIAL, NAME=clay|*ELASTIC| 200, 0.33|*MOHR COULOMB| 1, 25, 0|*UNIT WEIGHT| 20', list=list_materials, &
      opens='material')
    call table%add('ELASTIC', in_material, once, 'Isotropic elasticity.', elastic_fields, '*ELASTIC| 200, 0.33')
    call table%add('MOHR COULOMB', in_material, once, 'Mohr-Coulomb strength; phi = 0 is Tresca. Angles in '// &
      'degrees.', strength_fields, '*MOHR COULOMB| 1, 25, 0, 0', check_strength)
    call table%add('SOFTENING', in_material, once, 'The strength of *MOHR COULOMB decreases to a residual value '// &
      'with the plastic shear strain, (2 e:e)^1/2 with the deviator e of the plastic strain: '// &
      'docs/methods/softening.md. Angles in degrees.', softening_fields, &
      '*MOHR COULOMB| 10, 30, 5|*SOFTENING, TYPE=LINEAR, LENGTH=0.1| 1, 20, 0, 0.2')
    call add_soil_law_keywords(table)
    call add_profile_keyword(table)
    call add_undrained_keyword(table)
    call table%add('UNIT WEIGHT', in_material, once, 'Weight per volume; *GRAVITY multiplies it. A material '// &
      'without this keyword is weightless.', weight_fields, '*UNIT WEIGHT| 18, 20')
    call table%add('PERMEABILITY', in_material, once, 'Hydraulic conductivity: volume of water per unit of area, '// &
      'time and hydraulic gradient. For *WATER LEVEL, TYPE=SEEPAGE, and *CONSOLIDATION; it defines the unit of time.', &
      permeability_fields, '*PERMEABILITY| 1e-5|*PERMEABILITY, LAW=LOGARITHM, VOID RATIO=1.8, CK=0.9| 1e-4|'// &
      '*PERMEABILITY, DRAINABLE POROSITY=0.25, ALPHA=1.5, N=1.6| 1e-6', &
      check_permeability)
    call table%add('K0', in_material, once, 'Ratio of horizontal to vertical effective stress of the material at '// &
      'the start, in place of that of *INITIAL, TYPE=K0.', ratio_fields, '*K0| 0.5|*K0, TYPE=JAKY, OCR=2', check_card)
    call table%add('VOLUMETRIC LOCKING', in_material, once, 'Treatment of volumetric locking: the points of a cell '// &
      'share one pressure. For plastic flow at constant volume, nearly incompressible elasticity, and soil under '// &
      'rigid bodies; it is less accurate where the pressure varies smoothly.', locking_fields, &
      '*VOLUMETRIC LOCKING, TYPE=UNIFORM PRESSURE, FACTOR=0.5')
    call add_user_material_keywords(table)
  end subroutine add_material_keywords

  !> Describes the fields of *MATERIAL.
  subroutine material_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (material => deck%analysis%materials(deck%material))
      call fields%line(material%where)
      call fields%name('NAME', material%name, 'name of the material', required=.true.)
    end associate
  end subroutine material_fields

  !> Describes *ELASTIC; a card with an error counts as given, so that missing elasticity is not reported too.
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

  !> Describes the fields of *MOHR COULOMB.
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
        'default): no tension cut-off', range='[0, inf)', required=.false., none='NONE', also='sigma_t')
    end associate
  end subroutine strength_fields

  !> Checks that there is strength, that dilatancy does not exceed friction, and that the tensile strength has a
  !> meaning.
  subroutine check_strength(state)
    type(deck_state_type), intent(inout) :: state

    if (.not. state%card%is_right()) return
    associate (material => state%analysis%materials(state%material))
      if (material%tensile_strength < huge(1.0_wp) .and. material%tensile_strength*sin(material%friction_angle*degree) &
        > material%cohesion*cos(material%friction_angle*degree)) call state%warn(source_line(state%card%place), &
        'MOHR COULOMB', 'the tensile strength exceeds the apex of the yield surface, c cot phi: it has no effect')
      if (material%dilatancy_angle > material%friction_angle) call state%error_at(state%card%rows(1), &
        'the dilatancy angle psi is above the friction angle phi')
      if (max(material%cohesion, material%friction_angle) <= 0.0_wp) call state%error_at(state%card%rows(1), &
        'cohesion and friction angle are both zero: the material has no strength')
    end associate
  end subroutine check_strength

  !> Describes the fields of *UNIT WEIGHT.
  subroutine weight_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (material => deck%analysis%materials(deck%material))
      call fields%data('weight')
      call fields%number('gamma', material%unit_weight, 'weight per volume', range='[0, inf)')
      call fields%number('gamma_sat', material%saturated_weight, 'saturated unit weight, below the water level; '// &
        'gamma when not given', range='[0, inf)', required=.false.)
    end associate
  end subroutine weight_fields

  !> Describes the fields of *PERMEABILITY.
  subroutine permeability_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (k => deck%analysis%materials(deck%material)%permeability, &
        law => deck%analysis%materials(deck%material)%permeability_law)
      call fields%there(k(1) >= 0.0_wp)
      call fields%choice('LAW', law%kind, bar_list(permeability_words), 'dependence on the void ratio e under '// &
        '*CONSOLIDATION. KOZENY: e^3/(1 + e); LOGARITHM: reduced by ten when e decreases by CK')
      call fields%number('VOID RATIO', law%void_ratio, 'initial void ratio, of the initial geometry or where '// &
        '*INITIAL sets stresses', range='(0, inf)', needs='LAW=KOZENY|LOGARITHM')
      call fields%number('CK', law%index, 'decrease of e per log cycle; about half of VOID RATIO for '// &
        'clays', range='(0, inf)', &
        needs='LAW=LOGARITHM')
      call fields%number('DRAINABLE POROSITY', deck%analysis%materials(deck%material)%drainable_porosity, &
        'volume of water that drains from a unit volume as the water table falls; for FLOW=TRANSIENT of *WATER '// &
        'LEVEL', range='(0, 1)')
      call fields%number('ALPHA', law%alpha, 'parameter alpha of the retention curve and relative permeability '// &
        'after van Genuchten and Mualem, 1/length. DRAINABLE POROSITY is the porosity minus the residual water '// &
        'content. Linear over a cell when not given', range='(0, inf)')
      call fields%number('N', law%n, 'parameter n of that curve; 1.1 to 1.5 in clay and silt, 2 to 4 in sand', &
        range='[1.01, 20]', needs='ALPHA')
      call fields%data('permeability')
      call fields%number('k', k(1), 'along x; 0: impermeable', range='[0, inf)')
      if (fields%reading) k(2:) = k(1)
      call fields%number('k_y', k(2), 'along y; k when not given', range='[0, inf)', required=.false.)
      call fields%number('k_z', k(3), 'along z; k when not given', range='[0, inf)', required=.false., third=.true.)
    end associate
  end subroutine permeability_fields

  !> Checks the data that a permeability law requires.
  subroutine check_permeability(state)
    type(deck_state_type), intent(inout) :: state

    associate (law => state%analysis%materials(state%material)%permeability_law)
      if (law%kind /= permeability_constant .and. &
        .not. state%card%has('VOID RATIO')) call state%report_error('LAW requires the parameter VOID RATIO')
      if (law%kind == permeability_logarithm .and. &
        .not. state%card%has('CK')) call state%report_error('LAW=LOGARITHM requires the parameter CK: half of VOID '// &
        'RATIO for many clays')
      if (state%card%has('ALPHA') .and. .not. state%card%has('N')) call state%report_error('ALPHA requires the '// &
        'parameter N: 1.1 to 1.5 for clay and silt, 2 to 4 for sand')
    end associate
  end subroutine check_permeability

  !> Describes the fields of *VOLUMETRIC LOCKING.
  subroutine locking_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (material => deck%analysis%materials(deck%material))
      call fields%choice('TYPE', material%locking_treatment, 'NONE|AUTO|UNIFORM PRESSURE', &
        'AUTO: uniform pressure for nu above 0.45, for Mohr-Coulomb with phi = 0, and for any Mohr-Coulomb on '// &
        'linear elements, GIMP and in searches for a factor of safety on splines; otherwise none', &
        first=locking_none)
      call fields%number('FACTOR', material%pressure_factor, 'resistance to volume changes within a cell, relative '// &
        'to the shear modulus (the secant modulus of a step in yielding soil); when not given 1, 0.1 for phi = 0 '// &
        'without tension cut-off, 0.45 and 0.22 on meshes that move with the material, and 0.5 for elasticity, on '// &
        'linear elements and, except for phi = 0, with GIMP', &
        range='(0, inf)', needs='TYPE=AUTO|UNIFORM PRESSURE')
    end associate
  end subroutine locking_fields

  !> Describes the fields of *SOFTENING.
  subroutine softening_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (softening => deck%analysis%materials(deck%material)%softening)
      call fields%given(softening%given)
      call fields%choice('TYPE', softening%shape, 'LINEAR|EXPONENTIAL', 'decrease: linear, or exponential with 95 '// &
        '% of it at the given strain')
      call fields%choice('REGULARISATION', softening%regularisation, 'NONE|CELL|NONLOCAL', 'CELL: the strain is '// &
        'scaled by the cell size over LENGTH, so that the work of a slip surface does not depend on the cells; '// &
        'NONLOCAL: by a nonlocal field, so that bands have a width of 0.7 LENGTH and the same work in any '// &
        'direction, in cells up to 0.11 LENGTH, in wider ones as CELL; NONE: not scaled, the work decreases with '// &
        'the cell size')
      call fields%number('LENGTH', softening%length, 'width of the shear band in which the strain was measured, '// &
        'required with CELL and NONLOCAL', range='(0, inf)', needs='REGULARISATION=CELL|NONLOCAL')
      call fields%number('OVER', softening%over, 'weight m of the nonlocal field in the softening strain; 1 - m is '// &
        'the weight of the local strain', range='(1, inf)', needs='REGULARISATION=NONLOCAL')
      call fields%data('residual strength')
      call fields%number('c', softening%cohesion, 'residual cohesion', range='[0, inf)')
      call fields%number('phi', softening%friction_angle, 'residual friction angle', range='[0, 90)')
      call fields%number('psi', softening%dilatancy_angle, 'residual dilatancy angle', range='[0, 90)')
      call fields%number('plastic shear strain', softening%strain, 'at which the residual strength is '// &
        'reached', range='(0, inf)')
    end associate
  end subroutine softening_fields

  !> Checks the softening of complete materials.
  subroutine check_softening(state)
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: report_error
    integer :: i

    do i = 1, size(state%analysis%materials)
      associate (material => state%analysis%materials(i))
        ! A data line with an error has already been reported.
        if (.not. (material%softening%given .and. material%softening%strain > 0.0_wp)) cycle
        report_error = softening_error(material%softening, material%cohesion, material%friction_angle, &
          material%dilatancy_angle)
        if (.not. material%mohr_coulomb) report_error = 'the material has no *MOHR COULOMB strength that could soften'
        ! An erroneous card of the peak strength has already been reported.
        if (material%mohr_coulomb .and. max(material%cohesion, material%friction_angle) <= 0.0_wp) cycle
        if (len(report_error) == 0 .and. material%softening%regularisation == regularise_nonlocal) report_error = &
          wrong_beside_field(state, i)
        if (len(report_error) > 0) call state%error_from(material%where, 'SOFTENING', &
          "material '"//material%name//"': "//report_error)
      end associate
    end do
  end subroutine check_softening

  !> Returns the option that a nonlocal strain cannot be combined with, empty if none.
  function wrong_beside_field(state, m) result(sentence)
    type(deck_state_type), intent(in) :: state
    !> Number of the material.
    integer, intent(in) :: m
    character(len=:), allocatable :: sentence

    sentence = ''
    associate (undrained => state%analysis%materials(m)%undrained)
      if (has_consolidation(state%analysis%phases)) then
        sentence = 'REGULARISATION=NONLOCAL does not support *CONSOLIDATION; use REGULARISATION=CELL'
      else if (any(state%analysis%phases%controls%newton == newton_modified)) then
        sentence = 'REGULARISATION=NONLOCAL requires the tangent of stress and field; take NEWTON=FULL in all phases'
      else if (undrained%given .and. undrained%kind /= undrained_c) then
        sentence = 'REGULARISATION=NONLOCAL does not support effective stresses of *UNDRAINED soil; use TYPE=C of '// &
          'that keyword, or REGULARISATION=CELL'
      end if
    end associate
  end function wrong_beside_field

  !> Adds one keyword per law.
  subroutine add_soil_law_keywords(table)
    type(table_type), intent(inout) :: table
    type(law_parameters_slot_type), allocatable :: laws(:)
    type(law_description_type) :: law
    integer :: i

    call standard_laws(laws)
    do i = 1, size(laws)
      law = laws(i)%parameters%describe()
      call table%add(law%keyword, in_material, once, law%sentence, soil_law_fields, law%example, check_soil_law)
    end do
  end subroutine add_soil_law_keywords

  !> Describes the card of a law: that of the material if it has this law, otherwise one with default parameters.
  subroutine soil_law_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    class(law_parameters_type), allocatable :: law
    type(law_description_type) :: other
    logical :: given

    associate (material => deck%analysis%materials(deck%material))
      given = .false.
      if (allocated(material%soil_law)) then
        other = material%soil_law%describe()
        given = other%keyword == fields%keyword
        if (fields%reading) call deck%error_from(material%where, 'MATERIAL', "material '"//material%name// &
          "' has more than one law: *"//other%keyword//' and *'//fields%keyword)
      end if
      if (given) then
        allocate (law, source=material%soil_law)
      else
        call find_law(fields%keyword, law)
      end if
      call fields%there(given)
      call law%fields(fields)
      if (fields%reading) call move_alloc(law, material%soil_law)
    end associate
  end subroutine soil_law_fields

  !> Finds a law by the keyword of its card.
  subroutine find_law(keyword, law)
    character(len=*), intent(in) :: keyword
    class(law_parameters_type), allocatable, intent(out) :: law
    type(law_parameters_slot_type), allocatable :: laws(:)
    type(law_description_type) :: described
    integer :: i

    call standard_laws(laws)
    do i = 1, size(laws)
      described = laws(i)%parameters%describe()
      if (described%keyword == keyword) call move_alloc(laws(i)%parameters, law)
    end do
  end subroutine find_law

  !> Checks whether the parameters define a model, here, where the line is known.
  subroutine check_soil_law(state)
    type(deck_state_type), intent(inout) :: state
    class(principal_model_type), allocatable :: model
    class(soil_model_type), allocatable :: soil
    type(law_description_type) :: described
    type(error_type), allocatable :: error

    if (.not. state%card%is_right()) return
    associate (law => state%analysis%materials(state%material)%soil_law)
      described = law%describe()
      if (described%keeps_tensor) call note_card(state%analysis, state%card%keyword//' with a strain history')
      call law%make_soil_model(soil, error)
      if (.not. (allocated(error) .or. allocated(soil))) call law%make_model(model, error)
    end associate
    if (allocated(error)) call state%error_at(state%card%rows(1), error%message)
  end subroutine check_soil_law

  !> Describes the fields of *K0.
  subroutine ratio_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (rest => deck%analysis%materials(deck%material)%at_rest)
      call fields%there(has_ratio(deck%analysis%materials(deck%material)))
      call fields%line(rest%where)
      call fields%answer('TYPE', rest%jaky, 'K0 of first loading. VALUE: from the data line; JAKY: 1 - sin phi', &
        words='VALUE|JAKY')
      call fields%number('OCR', rest%overconsolidation, 'overconsolidation ratio, largest past over present '// &
        'vertical stress: K0 OCR - (OCR - 1) nu/(1 - nu)', range='[1, inf)')
      call fields%number('POP', rest%pre_overburden, 'pre-overburden pressure, largest past minus present vertical '// &
        'stress, in place of OCR', range='[0, inf)')
      call fields%number('NU', rest%poisson, "Poisson's ratio for unloading, with OCR and POP; that of the "// &
        'material when not given', range='[0, 0.5)')
      call fields%data('ratio', when='TYPE=VALUE')
      call fields%number('k0', rest%k0, 'horizontal over vertical stress', range='(0, inf)')
    end associate
  end subroutine ratio_fields

  !> Checks that the stress history of the ground is given in one way only.
  subroutine check_card(state)
    type(deck_state_type), intent(inout) :: state

    associate (rest => state%analysis%materials(state%material)%at_rest)
      if (rest%overconsolidation > 1.0_wp .and. rest%pre_overburden > 0.0_wp) call state%report_error('give OCR or '// &
        'POP, not both')
    end associate
  end subroutine check_card

  !> Checks K0 of all materials, when they are complete.
  subroutine check_k0(state)
    type(deck_state_type), intent(inout) :: state
    real(wp) :: default
    logical :: starts
    integer :: i

    default = 1.0_wp
    starts = .false.
    if (size(state%analysis%phases) > 0) then
      starts = state%analysis%phases(1)%initial%kind == initial_k0
      if (starts) default = state%analysis%phases(1)%initial%k0
    end if
    do i = 1, size(state%analysis%materials)
      associate (material => state%analysis%materials(i))
        if (has_ratio(material)) then
          call check_source(state, material)
          call check_range(state, material, default)
        else if (starts) then
          call check_range(state, material, default)
        end if
      end associate
    end do
  end subroutine check_k0

  !> Checks that the data from which K0 is computed are known.
  subroutine check_source(state, material)
    type(deck_state_type), intent(inout) :: state
    type(material_type), intent(in) :: material
    type(law_description_type) :: traits

    traits = traits_of(material)
    if (material%at_rest%jaky .and. .not. traits%friction_angle > 0.0_wp) call state%error_from( &
      material%at_rest%where, 'K0', "TYPE=JAKY requires a friction angle, which is not known of material '"// &
      material%name//"': give a value")
    if ((material%at_rest%overconsolidation > 1.0_wp .or. material%at_rest%pre_overburden > 0.0_wp) .and. &
      .not. (unloading_poisson(material) > 0.0_wp .or. material%at_rest%poisson >= 0.0_wp)) call state%error_from( &
      material%at_rest%where, 'K0', "OCR and POP require Poisson's ratio, which is not known of material '"// &
      material%name//"': give NU")
  end subroutine check_source

  !> Checks that the ratio is between 0 and the passive one of soil without cohesion.
  subroutine check_range(state, material, default)
    type(deck_state_type), intent(inout) :: state
    type(material_type), intent(in) :: material
    !> K0 of materials without *K0.
    real(wp), intent(in) :: default
    type(material_type) :: normal
    real(wp) :: ratio

    ! With POP the ratio decreases with depth; the value at great depth is checked.
    normal = material
    normal%at_rest%pre_overburden = 0.0_wp
    ratio = horizontal_at_rest(normal, default, 1.0_wp)
    if (ratio > 0.0_wp .and. ratio*(1.0_wp - rounding) <= passive_ratio(material)) return
    if (ratio > 0.0_wp) then
      call report("K0 = "//rounded_text(ratio)//" of material '"//material%name//"' is above its passive ratio, "// &
        rounded_text(passive_ratio(material)))
    else
      call report("K0 = "//rounded_text(ratio)//" of material '"//material%name//"' is not above 0")
    end if
  contains
    !> Reports an error at the card that has the ratio.
    subroutine report(sentence)
      character(len=*), intent(in) :: sentence

      if (has_ratio(material)) then
        call state%error_from(material%at_rest%where, 'K0', sentence)
      else
        call state%error_from(state%analysis%phases(1)%initial%where, 'INITIAL', sentence)
      end if
    end subroutine report
  end subroutine check_range
end module qsmpm_deck_materials
