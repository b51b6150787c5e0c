!> Water in the ground: *WATER LEVEL and its levels, *CONSOLIDATION, pore water flow in time from a phase on, *UNDRAINED
!> of a material, *DRAIN STATE of a phase, and their checks.
module qsmpm_deck_water
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: add_names, place_named
  use qsmpm_load_description, only: head_type, water_level_type, consolidation_type, drainage_type
  use qsmpm_mesh_description, only: mesh_file
  use qsmpm_phase_description, only: phase_type, initial_keep, phase_safety
  use qsmpm_card_fields, only: card_fields_type, column_type
  use qsmpm_deck_state, only: check_name, deck_state_type, list_water_levels
  use qsmpm_keyword_table, only: table_type, in_phase, many, once, in_material
  use qsmpm_phase_tree, only: lineage
  use qsmpm_pore_water, only: has_water
  use qsmpm_vertical, only: upwards, vertical_of
  use qsmpm_text, only: string_type, real_text
  use qsmpm_phase_loads, only: consolidation_of
  use qsmpm_body_description, only: drain_state_type
  use qsmpm_material_description, only: material_type, traits_of
  use qsmpm_drainage, only: set_drainage, is_drained_by, has_excess_pressure
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_undrained_parameters, only: undrained_a, undrained_b, undrained_ratio
  implicit none
  private

  public :: add_water_keyword, check_water, add_consolidation_keyword, check_drainage, add_undrained_keyword, &
    add_drain_keyword, check_undrained

contains

  !> Adds the keyword *WATER LEVEL.
  subroutine add_water_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('WATER LEVEL', in_phase, many, 'Water level in the ground and above it; it remains until '// &
      'changed. Below it the pore pressure is hydrostatic, and the laws use effective stresses. A new or changed '// &
      'level is applied linearly over the phase. A body with its own level does not follow others. With '// &
      'TYPE=SEEPAGE the phreatic surface is computed from the levels at the boundary (docs/methods/seepage.md).', &
      water_fields, '*WATER LEVEL, UNIT WEIGHT=9.81| 0, 3| 10, 3|*WATER LEVEL, BODY=core, TYPE=NONE|'// &
      '*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=9.81| upstream, 7| downstream, 2', check_level, &
      list=list_water_levels, opens='water level')
  end subroutine add_water_keyword

  !> Describes the fields of *WATER LEVEL.
  subroutine water_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    integer :: kind

    associate (level => deck%analysis%phases(deck%phase)%water_levels(deck%item))
      call fields%line(level%where)
      kind = merge(3, merge(2, 1, level%none), level%flows)
      call fields%choice('TYPE', kind, 'LINE|NONE|SEEPAGE', 'LINE: polyline of the level; NONE: no water; SEEPAGE: '// &
        'seepage through the bodies in their initial geometry, which fill whole cells in 3D')
      level%none = kind == 2
      level%flows = kind == 3
      call fields%answer('FLOW', level%transient, 'TRANSIENT: transient seepage over the TIME of the phase, from '// &
        'the flow of the phases before; levels change linearly to those given; with *CONSOLIDATION coupled with '// &
        'the deformation', needs='TYPE=SEEPAGE', words='STEADY|TRANSIENT')
      call fields%name('BODY', level%body, 'the body with this level; when not given all bodies without their own '// &
        'level', needs='TYPE=LINE|NONE')
      call fields%number('UNIT WEIGHT', level%unit_weight, 'unit weight of water, in the units of the deck; '// &
        '*GRAVITY multiplies it. Required unless TYPE=NONE', range='(0, inf)', needs='TYPE=LINE|SEEPAGE')
      call fields%table('vertices of the polyline, in order of x; constant beyond them', [ &
        column_type('x', 'horizontal coordinate: x, or y where gravity acts along x'), &
        column_type('y', 'height: the coordinate along which gravity acts')], level%line, when='TYPE=LINE')
      call head_fields(fields, level)
    end associate
  end subroutine water_fields

  !> Describes the levels at the boundary.
  subroutine head_fields(fields, level)
    class(card_fields_type), intent(inout) :: fields
    type(water_level_type), intent(inout) :: level
    integer :: i, n

    n = 0
    if (allocated(level%heads)) n = size(level%heads)
    call fields%data('free water levels at parts of the boundary; seepage faces above them and on all other '// &
      'exposed boundaries; the sides of the grid and surfaces with *SUPPORT are impermeable', 1, huge(1), &
        when='TYPE=SEEPAGE', rows=n)
    if (.not. fields%writing) level%heads = [(head_type(), i=1, n)]
    do i = 1, n
      call fields%row(i)
      call fields%line(level%heads(i)%where)
      call fields%name('set', level%heads(i)%set, 'node set (in the plane by PLANE or BOX; a drain if within the '// &
        'ground) or surface')
      call fields%number('level', level%heads(i)%level, 'height: the coordinate along which gravity acts')
      call fields%number('rain', level%heads(i)%rain, 'infiltration on the boundary above the level, volume per '// &
        'unit of horizontal area and time; the excess runs off', range='[0, inf)', required=.false.)
    end do
  end subroutine head_fields

  !> Checks that a line is a function of the horizontal coordinate, given once for each body.
  subroutine check_level(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (list => state%analysis%phases(state%phase)%water_levels)
      associate (level => list(size(list)))
        if (.not. level%none .and. .not. state%card%has('UNIT WEIGHT')) call state%report_error('the parameter '// &
          'UNIT WEIGHT is missing: the unit weight of water in the units of the deck, 9.81 or 10 for kN and m')
        do i = 2, merge(0, size(level%line, 2), level%flows)
          if (level%line(1, i) > level%line(1, i - 1) .or. .not. state%card%is_right()) cycle
          call state%error_at(state%card%rows(i), 'x does not increase: the level is a line over the horizontal '// &
            'axis, from left to right')
        end do
        do i = 1, size(list) - 1
          if (list(i)%body /= level%body) cycle
          call state%report_error('the water level '//of_body(level)//' is given in this phase already')
        end do
      end associate
    end associate
  end subroutine check_level

  !> Returns the text naming the body of a level.
  pure function of_body(level) result(text)
    type(water_level_type), intent(in) :: level
    character(len=:), allocatable :: text

    text = 'of all bodies'
    if (len(level%body) > 0) text = "of body '"//level%body//"'"
  end function of_body

  !> Checks that the bodies of levels exist, and that gravity gives the water a weight.
  subroutine check_water(state)
    type(deck_state_type), intent(inout) :: state
    logical :: heavy
    integer :: p, i

    call check_stops(state)
    call check_direction(state)
    do p = 1, size(state%analysis%phases)
      associate (phase => state%analysis%phases(p))
        heavy = is_heavy(state%analysis%phases, p)
        do i = 1, size(phase%water_levels)
          associate (level => phase%water_levels(i))
            if (.not. (heavy .or. level%none)) call state%error_from(level%where, 'WATER LEVEL', 'the water has no '// &
              'weight: no *GRAVITY acts up to this phase')
            call check_heads(state, level)
            call check_name(state, level%body, state%analysis%bodies, level%where, 'WATER LEVEL', 'body')
          end associate
        end do
      end associate
    end do
  end subroutine check_water

  !> Checks the node sets or surfaces at which levels are given.
  subroutine check_heads(state, level)
    type(deck_state_type), intent(inout) :: state
    type(water_level_type), intent(in) :: level
    type(string_type), allocatable :: names(:)
    integer :: i, k

    if (.not. level%flows) return
    allocate (names(0))
    call add_names(state%analysis%node_sets, names)
    call add_names(state%analysis%surfaces, names)
    do i = 1, size(level%heads)
      ! Sets of a mesh file are not known yet; one without a face is reported when the model is built.
      if (state%analysis%mesh%kind /= mesh_file) call check_name(state, level%heads(i)%set, names, &
        level%heads(i)%where, 'WATER LEVEL', 'node set or surface')
      if (any([(level%heads(k)%set == level%heads(i)%set, k=1, i - 1)])) call state%error_from(level%heads(i)%where, &
        'WATER LEVEL', "'"//level%heads(i)%set//"' has a level already")
    end do
  end subroutine check_heads

  !> Checks that the vertical is unique: where there is water, gravity acts mainly along the same axis and in the same
  !> sense in all phases.
  subroutine check_direction(state)
    type(deck_state_type), intent(inout) :: state
    character(len=1), parameter :: letter(3) = ['x', 'y', 'z']
    integer :: p, axis
    logical :: wet

    axis = vertical_of(state%analysis)
    wet = has_water(state%analysis)
    do p = 1, size(state%analysis%phases)
      associate (phase => state%analysis%phases(p))
        wet = wet .or. any(phase%tractions%of_water)
        associate (pull => phase%gravity%vector)
          if (.not. (wet .and. any(abs(pull) > 0.0_wp))) cycle
          if (abs(pull(axis)) >= maxval(abs(pull)) .and. -pull(axis)*upwards(state%analysis) > 0.0_wp) cycle
        end associate
        call state%error_from(phase%where, 'GRAVITY', "in phase '"//phase%name//"' gravity does not act along "// &
          trim(merge('-', '+', upwards(state%analysis) > 0.0_wp))//letter(axis)//' as elsewhere in the deck, but '// &
          'water levels require one direction of gravity: use a separate deck')
      end associate
    end do
  end subroutine check_direction

  !> Checks whether there is gravity in a phase or before it.
  pure logical function is_heavy(phases, number)
    type(phase_type), intent(in) :: phases(:)
    integer, intent(in) :: number
    integer, allocatable :: path(:)
    integer :: i

    allocate (path, source=lineage(phases, number))
    is_heavy = any([(any(abs(phases(path(i))%gravity%vector) > 0.0_wp), i=1, size(path))])
  end function is_heavy

  !> Checks that a phase that may end early does not change the water, since an intermediate level is undefined.
  subroutine check_stops(state)
    type(deck_state_type), intent(inout) :: state
    logical :: moves
    integer :: p, i, q, k

    do p = 1, size(state%analysis%phases)
      associate (phase => state%analysis%phases(p))
        if (size(phase%stops) == 0 .or. phase%initial%kind /= initial_keep) cycle
        moves = size(phase%water_levels) > 0
        do i = 1, size(phase%tractions)
          if (.not. phase%tractions(i)%follows) cycle
          do q = 1, p
            do k = 1, size(state%analysis%phases(q)%tractions)
              associate (load => state%analysis%phases(q)%tractions(k))
                moves = moves .or. (load%of_water .and. load%surface == phase%tractions(i)%surface)
              end associate
            end do
          end do
        end do
        if (moves) call state%error_from(phase%where, 'PHASE', "phase '"//phase%name//"' changes a water level and "// &
          'has a *STOP, which cannot stop between two levels: change the level in a separate phase')
      end associate
    end do
  end subroutine check_stops

  !> Adds the keyword *CONSOLIDATION.
  subroutine add_consolidation_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('CONSOLIDATION', in_phase, once, 'Coupled consolidation over the TIME of the phase, and of '// &
      'those after it: in soil with *PERMEABILITY loads generate excess pore pressure, which dissipates. Exposed '// &
      'faces are drained, faces under rigid bodies and the sides of the grid closed, unless the data lines '// &
      'change it. In a phase of TYPE=SAFETY no time passes. With *WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT in '// &
      'the phase the total pore pressure is computed, with a moving phreatic surface.', consolidation_fields, &
      '*CONSOLIDATION, UNIT WEIGHT=9.81| base, OPEN')
  end subroutine add_consolidation_keyword

  !> Describes the fields of *CONSOLIDATION.
  subroutine consolidation_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    integer :: i, n

    associate (card => deck%analysis%phases(deck%phase)%consolidation)
      call fields%line(card%where)
      call fields%given(card%given)
      call fields%number('UNIT WEIGHT', card%unit_weight, 'unit weight of water', &
        range='(0, inf)', required=.true.)
      call fields%number('STORAGE', card%storage, 'storage coefficient: volume change of water and grains per unit '// &
        'of volume and pressure', range='[0, inf)')
      call fields%answer('FACES', card%held, 'LAYER: nodal pressures at drained faces follow the analytical '// &
        'drainage of a half space until the drainage front has crossed their cells. HELD: they are 0 from the '// &
        'start, as in other programs: in short phases too much water drains', &
        words='LAYER|HELD')
      ! Open or closed sets.
      n = 0
      if (allocated(card%sets)) n = size(card%sets)
      call fields%data('drained and closed node sets', 0, huge(1), rows=n)
      if (.not. fields%writing) card%sets = [(drainage_type(), i=1, n)]
      do i = 1, n
        call fields%row(i)
        call fields%line(card%sets(i)%where)
        call fields%name('set', card%sets(i)%name, 'node set')
        call fields%answer('way', card%sets(i)%closed, 'OPEN: the excess pressure is 0 there', words='OPEN|CLOSED')
      end do
    end associate
  end subroutine consolidation_fields

  !> Checks that phases in which water flows in time have a TIME.
  subroutine check_drainage(state)
    type(deck_state_type), intent(inout) :: state
    integer :: p

    do p = 1, size(state%analysis%phases)
      associate (phase => state%analysis%phases(p))
        if (consolidation_of(state%analysis%phases, p) > 0) &
          phase%water_levels%coupled = phase%water_levels%flows .and. phase%water_levels%transient
        phase%controls%by_water = consolidation_of(state%analysis%phases, p) > 0 .and. phase%kind /= phase_safety
        if (consolidation_of(state%analysis%phases, p) > 0 .and. phase%kind /= phase_safety .and. .not. &
          phase%duration_given) &
          call state%error_from(phase%where, 'PHASE', "phase '"//phase%name//"' has *CONSOLIDATION and requires TIME=")
      end associate
    end do
  end subroutine check_drainage

  !> Adds the keyword *UNDRAINED.
  subroutine add_undrained_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('UNDRAINED', in_material, once, 'Undrained pore water: volume changes generate an excess pore '// &
      'pressure (state variable excess_pore_pressure, compression positive); stresses include it, but not the '// &
      'steady pore pressure, and the treatment of volumetric locking is active: docs/methods/undrained.md.', &
      undrained_fields, '*ELASTIC| 3000, 0.3|*MOHR COULOMB| 2, 25, 0|*UNDRAINED, TYPE=A', finish_undrained)
  end subroutine add_undrained_keyword

  !> Adds the keyword *DRAIN STATE.
  subroutine add_drain_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('DRAIN STATE', in_phase, once, 'Drainage of *UNDRAINED materials in this phase: the excess '// &
      'pressure is reduced linearly to zero over it, and transferred to effective stress. Every step is in '// &
      'equilibrium. Without data lines it applies to all bodies.', drain_fields, &
      '*DRAIN STATE, AFTERWARDS=DRAINED')
  end subroutine add_drain_keyword

  !> Describes the fields of *UNDRAINED.
  subroutine undrained_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (undrained => deck%analysis%materials(deck%material)%undrained)
      call fields%given(undrained%given)
      call fields%line(deck%analysis%materials(deck%material)%undrained_where)
      call fields%choice('TYPE', undrained%kind, 'A|B|C', 'A: effective stiffness and strength; B: effective '// &
        'stiffness, strength s_u (*MOHR COULOMB with phi = 0); C: total stress, no pore pressure, strength s_u, '// &
        'the shear modulus of *ELASTIC with NU', required=.true.)
      call fields%number('NU', undrained%poisson, "undrained Poisson's ratio", range='(0, 0.5)')
      call fields%number('SKEMPTON', undrained%skempton, "Skempton's B, in place of NU", range='(0, 1)')
      call fields%answer('DILATANT', undrained%dilatant, 'YES: allows a dilatancy angle with TYPE=A, for which the '// &
        'strength is unlimited', needs='TYPE=A')
    end associate
  end subroutine undrained_fields

  !> Checks that NU and SKEMPTON are not both given.
  subroutine finish_undrained(state)
    type(deck_state_type), intent(inout) :: state

    if (state%card%has('NU') .and. state%card%has('SKEMPTON')) call state%report_error('give NU or SKEMPTON, not both')
  end subroutine finish_undrained

  !> Describes the fields of *DRAIN STATE.
  subroutine drain_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (drain => deck%analysis%phases(deck%phase)%drain_state)
      call fields%given(drain%given)
      call fields%line(drain%where)
      call fields%answer('KEEP PRESSURE', drain%keeps, 'YES: keeps the excess pressure; the soil is drained in the '// &
        'phase, so that no further excess is generated')
      call fields%answer('AFTERWARDS', drain%stays_drained, 'drainage of the soil in later phases', &
        words='UNDRAINED|DRAINED')
      call drain_rows(fields, drain%bodies)
    end associate
  end subroutine drain_fields

  !> Describes the bodies of *DRAIN STATE, one per line.
  subroutine drain_rows(fields, bodies)
    class(card_fields_type), intent(inout) :: fields
    type(string_type), allocatable, intent(inout) :: bodies(:)
    integer :: i, n

    n = 0
    if (allocated(bodies)) n = size(bodies)
    call fields%data('bodies, one a line', 0, huge(1), rows=n)
    if (.not. fields%writing) bodies = [(string_type(), i=1, n)]
    do i = 1, n
      call fields%row(i)
      call fields%name('body', bodies(i)%text, 'body that is drained')
    end do
  end subroutine drain_rows

  !> Checks the undrained soil of complete materials and phases.
  subroutine check_undrained(state)
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: sentence
    integer :: i

    do i = 1, size(state%analysis%materials)
      associate (material => state%analysis%materials(i))
        if (.not. material%undrained%given) cycle
        sentence = wrong_material(material)
        if (len(sentence) > 0) call state%error_from(material%undrained_where, 'UNDRAINED', &
          "material '"//material%name//"': "//sentence)
      end associate
    end do
    do i = 1, size(state%analysis%phases)
      associate (card => state%analysis%phases(i)%drain_state)
        if (card%given) call check_drain_state(state, card)
      end associate
    end do
    call set_drainage(state%analysis)
  end subroutine check_undrained

  !> Returns the fault of *UNDRAINED of a material, empty if there is none.
  function wrong_material(material) result(sentence)
    type(material_type), intent(in) :: material
    character(len=:), allocatable :: sentence
    type(law_description_type) :: traits

    sentence = ''
    traits = traits_of(material)
    associate (undrained => material%undrained)
      if (traits%total_stress) then
        sentence = '*'//traits%keyword//' is a total stress law, undrained by definition'
      else if (undrained%kind /= undrained_a .and. (.not. material%mohr_coulomb .or. material%user%given .or. &
        allocated(material%soil_law))) then
        sentence = 'TYPE='//trim(merge('B', 'C', undrained%kind == undrained_b))//' requires a strength s_u: *MOHR '// &
          'COULOMB with c = s_u and phi = 0; TYPE=A takes the effective strength of any law'
      else if (undrained%kind /= undrained_a .and. material%friction_angle > 0.0_wp) then
        sentence = 'TYPE='//trim(merge('B', 'C', undrained%kind == undrained_b))//' requires *MOHR COULOMB with '// &
          'c = s_u and phi = 0; with friction it is TYPE=A'
      else if (undrained%kind == undrained_a .and. traits%dilatancy_angle > 0.0_wp .and. .not. undrained%dilatant) then
        sentence = 'the dilatancy angle psi is '//real_text(traits%dilatancy_angle)//': the strength of dilating '// &
          'undrained soil is unlimited; use psi = 0, or allow it by DILATANT=YES'
      else if (material%user%given .and. material%user%undrained > 0.0_wp) then
        sentence = 'the model has its own pore water by UNDRAINED of *USER MATERIAL, which would be counted twice'
      else if (traits%linear_elasticity .and. material%young > 0.0_wp .and. &
        .not. undrained_ratio(undrained, material%poisson) > material%poisson) then
        sentence = 'NU='//real_text(undrained%poisson)//" is not above Poisson's ratio of the soil, "// &
          real_text(material%poisson)//': the pore water would have no stiffness'
      end if
    end associate
  end function wrong_material

  !> Checks that there is excess pressure to drain, and that all bodies of one material are named.
  subroutine check_drain_state(state, card)
    type(deck_state_type), intent(inout) :: state
    type(drain_state_type), intent(in) :: card
    integer :: i, m
    logical :: wet

    do i = 1, size(card%bodies)
      if (place_named(state%analysis%bodies, card%bodies(i)%text) > 0) cycle
      call check_name(state, card%bodies(i)%text, state%analysis%bodies, card%where, 'DRAIN STATE', 'body')
      return
    end do
    wet = .false.
    do m = 1, size(state%analysis%materials)
      if (.not. is_drained_by(state%analysis, m, card)) cycle
      wet = wet .or. has_excess_pressure(state%analysis, m)
      if (has_excess_pressure(state%analysis, m) .and. size(card%bodies) > 0) call check_together(state, card, m)
    end do
    if (.not. wet) call state%error_from(card%where, 'DRAIN STATE', 'there is no excess pore pressure to drain: no '// &
      'body named has a material that is *UNDRAINED, TYPE=A or B')
  end subroutine check_drain_state

  !> Checks that all bodies of a material are named if one is.
  subroutine check_together(state, card, material)
    type(deck_state_type), intent(inout) :: state
    type(drain_state_type), intent(in) :: card
    !> Number of the material.
    integer, intent(in) :: material
    integer :: b, i
    logical :: named

    do b = 1, size(state%analysis%bodies)
      associate (body => state%analysis%bodies(b))
        if (body%material /= state%analysis%materials(material)%name) cycle
        named = any([(card%bodies(i)%text == body%name, i=1, size(card%bodies))])
        if (.not. named) call state%error_from(card%where, 'DRAIN STATE', "body '"//body%name// &
          "' has the material '"//body%material//"' of a body that is drained: name it too, or give it a separate "// &
          'material')
      end associate
    end do
  end subroutine check_together
end module qsmpm_deck_water
