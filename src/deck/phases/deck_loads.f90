!> Keywords of the initial state of a phase, *INITIAL, *RESET DISPLACEMENTS, *UPDATE STRENGTH, and of its loads:
!> *GRAVITY, *TRACTION, *PRESSURE, *WATER LEVEL (qsmpm_deck_water), *SUPPORT, which fixes a surface, and *CONTRACTION,
!> which prescribes the contraction of that of a cavity.
module qsmpm_deck_loads
  use qsmpm_kinds, only: wp
  use qsmpm_load_description, only: traction_type, support_all, support_none
  use qsmpm_card_fields, only: card_fields_type, column_type
  use qsmpm_deck_state, only: deck_state_type, beside_deck, list_tractions, list_supports
  use qsmpm_deck_water, only: add_water_keyword
  use qsmpm_keyword_table, only: table_type, in_phase, once, many, bar_list, carrier_words, support_words, &
    initial_words
  use qsmpm_phase_description, only: initial_stress_type, initial_keep, initial_isotropic, initial_given
  use qsmpm_error, only: error_type
  use qsmpm_stress_results, only: read_stress_file, is_results, read_stress_results
  implicit none
  private

  public :: add_load_keywords, add_initial_keywords

  character(len=*), parameter :: height = 'height: the coordinate along which gravity acts, y without gravity'

contains

  !> Adds the keywords *GRAVITY, *TRACTION, *PRESSURE, *WATER LEVEL, *SUPPORT, *CONTRACTION.
  subroutine add_load_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('GRAVITY', in_phase, once, 'Gravity per unit of load factor; it multiplies the unit weight of '// &
      'the materials.', gravity_fields, '*GRAVITY| 0, -1')
    call table%add('TRACTION', in_phase, many, 'Dead load on a surface, force per undeformed '// &
      'area per unit of load factor.', traction_fields, '*TRACTION, SURFACE=top| 0, -10', check_load, &
      list=list_tractions, opens='traction')
    call table%add('PRESSURE', in_phase, many, 'Pressure on a surface per unit of load factor; it follows the '// &
      'current area and normal of the surface and may increase with depth.', pressure_fields, &
      '*PRESSURE, SURFACE=wall| 50|*PRESSURE, SURFACE=face, LEVEL=3, UNIT WEIGHT=9.81', check_pressure, &
      list=list_tractions, opens='pressure')
    call add_water_keyword(table)
    call table%add('SUPPORT', in_phase, many, 'Surface fixed at zero displacement wherever it cuts the grid; it '// &
      'remains until changed.', support_fields, '*SUPPORT, SURFACE=rock, TYPE=NORMAL', check_support, &
      list=list_supports, opens='support')
    call table%add('CONTRACTION', in_phase, many, 'Uniform contraction of the outline of a cavity over the phase, '// &
      'as for the volume loss of a tunnel (a circle contracts along its normals); the outline is then kept until '// &
      '*SUPPORT or another contraction changes it. Plane strain only.', contraction_fields, &
      '*CONTRACTION, SURFACE=tunnel| 1.5', check_support, list=list_supports, opens='contraction')
  end subroutine add_load_keywords

  !> Describes the fields of *GRAVITY.
  subroutine gravity_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (gravity => deck%analysis%phases(deck%phase)%gravity)
      call fields%given(gravity%given)
      call fields%data('vector')
      call fields%vector('g', gravity%vector, 'component')
    end associate
  end subroutine gravity_fields

  !> Describes the fields of *TRACTION.
  subroutine traction_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (traction => deck%analysis%phases(deck%phase)%tractions(deck%item))
      call fields%there(.not. traction%follows)
      call surface_field(fields, traction)
      call fields%choice('CARRIER', traction%carrier, bar_list(carrier_words), 'tracked surface points, or the '// &
        'outermost material points (only for comparison with the paper)')
      call fields%data('vector')
      call fields%vector('t', traction%vector, 'component')
    end associate
  end subroutine traction_fields

  !> Describes the fields of *PRESSURE.
  subroutine pressure_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (traction => deck%analysis%phases(deck%phase)%tractions(deck%item))
      call fields%given(traction%follows)
      call surface_field(fields, traction)
      call water_fields(fields, traction)
      call fields%data('nothing: the level defines it', 0, 0, when='LEVEL')
      call fields%data('pressure')
      call fields%number('p', traction%pressure, 'force per current area, positive against the body')
      call fields%number('gradient', traction%gradient, 'increase per length downwards, 0 when not given', &
        required=.false.)
      call fields%number('y', traction%height, 'height at which it equals p, 0 when not given: the coordinate '// &
        'along which gravity acts, y without gravity', required=.false.)
      if (fields%reading .and. traction%of_water) traction%pressure = 0.0_wp
    end associate
  end subroutine pressure_fields

  !> Describes level and unit weight of a water pressure.
  subroutine water_fields(fields, traction)
    class(card_fields_type), intent(inout) :: fields
    type(traction_type), intent(inout) :: traction
    real(wp) :: weight

    call fields%number('LEVEL', traction%height, 'level of free water at the surface, in place of the data line: '// &
      'the pressure is UNIT WEIGHT times the depth below it', given=traction%of_water)
    weight = 0.0_wp
    if (traction%of_water) weight = traction%gradient
    call fields%number('UNIT WEIGHT', weight, 'weight of the water per volume', range='(0, inf)', needs='LEVEL')
    if (fields%reading .and. traction%of_water) traction%gradient = weight
  end subroutine water_fields

  !> Checks that a water pressure has a unit weight.
  subroutine check_pressure(state)
    type(deck_state_type), intent(inout) :: state

    call check_load(state)
    if (state%card%has('LEVEL') .and. .not. state%card%has('UNIT WEIGHT')) call state%report_error('LEVEL requires '// &
      'the parameter UNIT WEIGHT, the weight of the water per volume')
  end subroutine check_pressure

  !> Describes the surface of a load.
  subroutine surface_field(fields, traction)
    class(card_fields_type), intent(inout) :: fields
    type(traction_type), intent(inout) :: traction

    call fields%line(traction%where)
    call fields%name('SURFACE', traction%surface, 'the surface', required=.true.)
  end subroutine surface_field

  !> Checks that a phase has one load per surface.
  subroutine check_load(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (list => state%analysis%phases(state%phase)%tractions)
      do i = 1, size(list) - 1
        if (list(i)%surface == list(size(list))%surface) call state%report_error("surface '"//list(i)%surface// &
          "' has a traction in this phase already")
      end do
    end associate
  end subroutine check_load

  !> Describes the fields of *SUPPORT.
  subroutine support_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (support => deck%analysis%phases(deck%phase)%supports(deck%item))
      call fields%there(.not. support%contracts)
      call fields%line(support%where)
      call fields%name('SURFACE', support%surface, 'the surface; a plane one for TYPE=NORMAL', required=.true.)
      call fields%choice('TYPE', support%kind, bar_list(support_words), 'NORMAL: fixed along its normal (smooth), '// &
        'ALL: fixed in all directions (rough), FREE: released', first=support_none)
    end associate
  end subroutine support_fields

  !> Describes the fields of *CONTRACTION.
  subroutine contraction_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (support => deck%analysis%phases(deck%phase)%supports(deck%item))
      call fields%given(support%contracts)
      if (fields%reading) support%kind = support_all
      call fields%line(support%where)
      call fields%name('SURFACE', support%surface, 'the outline of the cavity: closed, or half or a quarter of a '// &
        'circle that ends at planes of symmetry', required=.true.)
      call fields%answer('HELD', support%held, 'NO: the outline as a whole is free to move vertically, as a '// &
        'weightless lining; YES: its centre is fixed, and the settlement trough is flatter')
      call fields%data('volume loss')
      call fields%number('percent', support%volume_loss, 'volume loss: reduction of the area of the cavity at the '// &
        'end of the phase, per unit of load factor; negative: the cavity expands', range='(-100, 50]')
    end associate
  end subroutine contraction_fields

  !> Checks that a phase has one support per surface.
  subroutine check_support(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (list => state%analysis%phases(state%phase)%supports)
      do i = 1, size(list) - 1
        if (list(i)%surface == list(size(list))%surface) call state%report_error("surface '"//list(i)%surface// &
          "' has a support or contraction in this phase already")
      end do
    end associate
  end subroutine check_support

  !> Adds the keywords of the initial state.
  subroutine add_initial_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('INITIAL', in_phase, once, 'Effective stresses at the start of the first phase, whose loads act '// &
      'from its start: they must be in equilibrium with the stresses, otherwise the phase ends with an '// &
      'error.', initial_fields, &
      '*INITIAL, TYPE=K0| 10, 0.5|*INITIAL, TYPE=ISOTROPIC| 0, 100', check_initial)
    call table%add('RESET DISPLACEMENTS', in_phase, once, 'Displacements and strains in the results are counted '// &
      'from the start of this phase.', reset_fields, '*RESET DISPLACEMENTS')
    call table%add('UPDATE STRENGTH', in_phase, once, 'Strengths of *STRENGTH PROFILE, TYPE=SHANSEP are updated to '// &
      'the vertical effective stresses at the start of the phase: the gain by earlier consolidation. Without it '// &
      'they do not change.', update_fields, '*UPDATE STRENGTH')
  end subroutine add_initial_keywords

  !> Describes the fields of *INITIAL.
  subroutine initial_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (initial => deck%analysis%phases(deck%phase)%initial)
      call fields%line(initial%where)
      call fields%choice('TYPE', initial%kind, bar_list(initial_words), 'KEEP those there are. K0: vertical '// &
        'stress from the weight of the bodies and the water above, horizontal stress in proportion; only '// &
        'horizontal ground is then in equilibrium, with structures in it (a wall without *MOHR COULOMB) that start '// &
        'with the stress of the adjacent ground; other ground must start from a phase with *GRAVITY. ISOTROPIC: a '// &
        'pressure by height. GIVEN: all components by height or from a file', first=initial_keep)
      call fields%file('INPUT', initial%file, 'file of stresses, relative to the deck, in place of data lines; a '// &
        'point takes the stress of the nearest place. CSV: first line `x,y,s11,s22,s33,s12`, then a row per place. '// &
        '`results.h5` of another run: its material points, within a distance of a cell', needs='TYPE=GIVEN')
      call fields%whole('STEP', initial%step, 'number of the step of a results.h5', range='[0, inf)', needs='INPUT', &
        none='LAST')
      call fields%answer('STATE', initial%takes_state, 'YES also reads the named state variables, where the point '// &
        'of results.h5 has a material of the same number', needs='INPUT')
      call fields%data('surface', when='TYPE=K0')
      call fields%number('level', initial%surface_level, 'vertical coordinate of the surface; a gap below it has '// &
        'the weight of the ground below the gap')
      call fields%number('k0', initial%k0, 'horizontal over vertical stress, of materials without *K0', &
        range='(0, inf)')
      call fields%table('pressures by height, upwards; even between and beyond', [column_type('y', height), &
        column_type('p', 'pressure, compression positive')], initial%pressures, when='TYPE=ISOTROPIC')
      call fields%data('nothing: the file contains them', 0, 0, when='INPUT')
      call fields%table('stresses by height, upwards; even between and beyond', [column_type('y', height), &
        column_type('s11', 'stress, tension positive'), column_type('s22', 'stress'), column_type('s33', 'stress'), &
        column_type('s12', 'shear stress'), column_type('s13', 'shear stress', .true.), &
        column_type('s23', 'shear stress', .true.)], initial%stresses, when='TYPE=GIVEN')
    end associate
  end subroutine initial_fields

  !> Checks that stresses are prescribed in the first phase only and that heights increase, and reads the file.
  subroutine check_initial(state)
    type(deck_state_type), intent(inout) :: state

    associate (initial => state%analysis%phases(state%phase)%initial)
      if (state%phase > 1 .and. initial%kind /= initial_keep) call state%report_error('TYPE='// &
        trim(initial_words(initial%kind))//' is for the first phase: later phases start from the present stresses')
      if (initial%kind == initial_isotropic) call check_heights(initial%pressures, state)
      if (initial%kind == initial_given .and. .not. state%card%has('INPUT')) call check_heights(initial%stresses, state)
      if (initial%kind == initial_given .and. state%card%has('INPUT')) call read_file(initial, state)
    end associate
  end subroutine check_initial

  !> Checks that the heights of a table increase.
  subroutine check_heights(table, state)
    !> Heights in the first row.
    real(wp), intent(in) :: table(:, :)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    if (.not. state%card%is_right()) return
    do i = 2, size(table, 2)
      if (.not. table(1, i) > table(1, i - 1)) call state%error_at(state%card%rows(i), 'y does not increase')
    end do
  end subroutine check_heights

  !> Reads stresses from a file.
  subroutine read_file(initial, state)
    type(initial_stress_type), intent(inout) :: initial
    type(deck_state_type), intent(inout) :: state
    type(error_type), allocatable :: error

    initial%file = beside_deck(state%card, 'INPUT')
    if (is_results(initial%file)) then
      call read_stress_results(initial%file, state%dimension, initial%step, initial%places, initial%at_places, &
        initial%part, error)
    else
      call read_stress_file(initial%file, state%dimension, initial%places, initial%at_places, error)
      if (state%card%has('STEP') .or. state%card%has('STATE')) call state%report_error('STEP and STATE are for the '// &
        "results of a run: INPUT=results.h5, not '"//initial%file//"'")
    end if
    if (allocated(error)) call state%report_error(error%message)
  end subroutine read_file

  !> Describes the fields of *RESET DISPLACEMENTS.
  subroutine reset_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (phase => deck%analysis%phases(deck%phase))
      call fields%given(phase%reset_displacements)
      call fields%answer('STRAINS', phase%reset_strains, 'YES also resets the plastic shear strain of materials '// &
        'with *SOFTENING, which start again with their initial strength. Stresses and all other state variables '// &
        'are kept')
    end associate
  end subroutine reset_fields

  !> Describes the fields of *UPDATE STRENGTH.
  subroutine update_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call fields%given(deck%analysis%phases(deck%phase)%updates_strength)
    call fields%line(deck%analysis%phases(deck%phase)%strength_where)
  end subroutine update_fields
end module qsmpm_deck_loads
