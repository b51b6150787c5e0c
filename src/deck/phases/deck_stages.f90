!> Staged construction: *ACTIVATE, *DEACTIVATE, *CHANGE MATERIAL, and the checks of the complete deck: bodies exist, are
!> activated only if inactive and deactivated only if active, at least one remains, and nothing acts on an inactive
!> body. Props: the keywords *PROP, *INSTALL and *REMOVE.
module qsmpm_deck_stages
  use qsmpm_body_description, only: body_change_type, fill_level
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type, check_name, list_props
  use qsmpm_keyword_table, only: table_type, in_phase, once, in_model, many, bar_list, fill_words
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: bodies_active, bodies_named, body_number, has_stages, leaves_cells
  use qsmpm_load_description, only: carrier_points
  use qsmpm_mesh_description, only: select_outline
  use qsmpm_method_description, only: basis_fem
  use qsmpm_phase_description, only: phase_type
  use qsmpm_source_line, only: source_line_type
  use qsmpm_phase_tree, only: parent_of
  use qsmpm_vertical, only: upwards
  use qsmpm_structures, only: prop_change_type, prop_type
  use qsmpm_phase_loads, only: prop_stage_type, prop_stage
  implicit none
  private

  public :: add_stage_keywords, check_stages, add_prop_keyword, add_prop_stage_keywords, check_props

contains

  !> Adds the keywords *ACTIVATE, *DEACTIVATE, *CHANGE MATERIAL.
  subroutine add_stage_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('ACTIVATE', in_phase, once, 'Bodies activated in this phase, without stress; their weight is '// &
      'applied over the phase. A body deactivated earlier is activated where it is.', activate_fields, &
      '*ACTIVATE| lift 2', check_changes)
    call table%add('DEACTIVATE', in_phase, once, 'Bodies deactivated in this phase; their stress and weight are '// &
      'reduced to zero over the phase, so that it starts in equilibrium.', deactivate_fields, '*DEACTIVATE| pit', &
      check_changes)
    call table%add('CHANGE MATERIAL', in_phase, once, 'Bodies that have another material from this phase on: the '// &
      'stress is kept as the initial stress of the new law, the weight changes over the phase.', material_fields, &
      '*CHANGE MATERIAL| column, grouted', check_changes)
  end subroutine add_stage_keywords

  !> Describes the fields of *ACTIVATE.
  subroutine activate_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    integer :: fill

    fill = fill_level
    associate (list => deck%analysis%phases(deck%phase)%activations)
      if (fields%writing .and. size(list) > 0) fill = list(1)%fill
      call fields%choice('FILL', fill, bar_list(fill_words), 'LEVEL: the body extends from its defined top down to '// &
        'the deformed ground surface; SHAPE: it has its defined shape, and an overlap with the ground is an error')
    end associate
    call body_rows(fields, deck%analysis%phases(deck%phase)%activations, .false.)
    deck%analysis%phases(deck%phase)%activations%fill = fill
  end subroutine activate_fields

  !> Describes the fields of *DEACTIVATE.
  subroutine deactivate_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call body_rows(fields, deck%analysis%phases(deck%phase)%deactivations, .false.)
  end subroutine deactivate_fields

  !> Describes the fields of *CHANGE MATERIAL.
  subroutine material_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call body_rows(fields, deck%analysis%phases(deck%phase)%materials, .true.)
  end subroutine material_fields

  !> Describes the rows of bodies.
  subroutine body_rows(fields, list, with_material)
    class(card_fields_type), intent(inout) :: fields
    type(body_change_type), allocatable, intent(inout) :: list(:)
    !> A material is given for each body.
    logical, intent(in) :: with_material
    integer :: i, n

    n = size(list)
    call fields%list(trim(merge('body and material', 'body             ', with_material)), n)
    if (.not. fields%writing) list = [(body_change_type(), i=1, n)]
    do i = 1, n
      call fields%row(i)
      call fields%line(list(i)%where)
      call fields%name('body', list(i)%body, 'the body')
      if (with_material) call fields%name('material', list(i)%material, 'its material from now on')
    end do
  end subroutine body_rows

  !> Checks that each body is named once.
  subroutine check_changes(state)
    type(deck_state_type), intent(inout) :: state

    call state%check_once('body')
  end subroutine check_changes

  !> Checks all phases in order.
  subroutine check_stages(state)
    type(deck_state_type), intent(inout) :: state
    logical :: before(size(state%analysis%bodies)), now(size(state%analysis%bodies))
    integer :: p

    if (.not. has_stages(state%analysis)) return
    call check_method(state)
    if (size(before) > 0 .and. .not. any(state%analysis%bodies%active)) call state%error_from( &
      state%analysis%bodies(1)%where, 'BODY', 'no body is active at the start: all have ACTIVE=NO')
    do p = 1, size(state%analysis%phases)
      before = bodies_active(state%analysis, parent_of(state%analysis%phases, p))
      now = bodies_active(state%analysis, p)
      associate (phase => state%analysis%phases(p))
        call check_names(state, phase%activations, 'ACTIVATE')
        call check_names(state, phase%deactivations, 'DEACTIVATE')
        call check_names(state, phase%materials, 'CHANGE MATERIAL')
        call check_phase(state, p, before, now)
        if (.not. any(now) .and. any(before)) call state%error_from(phase%deactivations(1)%where, 'DEACTIVATE', &
          "phase '"//phase%name//"' deactivates all active bodies")
        call check_surfaces(state, phase, now)
      end associate
    end do
    call check_unused(state)
  end subroutine check_stages

  !> Checks the features that staged construction cannot be combined with.
  subroutine check_method(state)
    type(deck_state_type), intent(inout) :: state
    integer :: p, i

    do p = 1, size(state%analysis%phases)
      associate (phase => state%analysis%phases(p))
        if (state%analysis%method%basis == basis_fem) then
          if (leaves_cells(state%analysis, p)) call state%error_from(phase%activations(1)%where, 'ACTIVATE', &
            'FILL=SHAPE, and a body that was deactivated before, require a background grid: *METHOD, '// &
            'BASIS=FEM does not support them')
        end if
        do i = 1, size(phase%tractions)
          if (phase%tractions(i)%carrier == carrier_points) call state%error_from(phase%tractions(i)%where, &
            'TRACTION', 'CARRIER=POINTS does not support analyses in which bodies are activated or deactivated')
        end do
      end associate
    end do
  end subroutine check_method

  !> Checks that bodies and materials of a list exist.
  subroutine check_names(state, changes, keyword)
    type(deck_state_type), intent(inout) :: state
    type(body_change_type), intent(in) :: changes(:)
    character(len=*), intent(in) :: keyword
    integer :: i

    do i = 1, size(changes)
      call check_name(state, changes(i)%body, state%analysis%bodies, changes(i)%where, keyword, 'body')
      if (allocated(changes(i)%material)) call check_name(state, changes(i)%material, state%analysis%materials, &
        changes(i)%where, keyword, 'material')
    end do
  end subroutine check_names

  !> Checks that the changes of one phase are possible.
  subroutine check_phase(state, p, before, now)
    type(deck_state_type), intent(inout) :: state
    !> Number of the phase.
    integer, intent(in) :: p
    !> Bodies that are active before it and in it (bodies).
    logical, intent(in) :: before(:), now(:)
    logical :: coming(size(before)), going(size(before))
    integer :: i, b

    associate (phase => state%analysis%phases(p), analysis => state%analysis)
      coming = bodies_named(analysis, phase%activations)
      going = bodies_named(analysis, phase%deactivations)
      if (p == 1 .and. size(phase%activations) > 0) call state%error_from(phase%activations(1)%where, 'ACTIVATE', &
        'the first phase starts with the active bodies: remove ACTIVE=NO of *BODY')
      if (p == 1 .and. size(phase%deactivations) > 0) call state%error_from(phase%deactivations(1)%where, &
        'DEACTIVATE', 'nothing can be deactivated before the first phase has loaded it')
      if (p == 1 .and. size(phase%materials) > 0) call state%error_from(phase%materials(1)%where, &
        'CHANGE MATERIAL', 'the first phase starts with the materials of *BODY')
      do i = 1, size(phase%activations)
        if (phase%activations(i)%fill == fill_level .and. upwards(analysis) < 0.0_wp) call state%error_from( &
          phase%activations(i)%where, 'ACTIVATE', 'FILL=LEVEL requires a coordinate that increases upwards, and '// &
          'gravity acts along it here: rotate the model, or use FILL=SHAPE')
        b = body_number(analysis, phase%activations(i)%body)
        if (b > 0) call refuse(before(b) .and. .not. going(b), phase%activations(i), 'ACTIVATE', 'is there already')
        if (b > 0) call refuse(going(b), phase%activations(i), 'ACTIVATE', 'is deactivated in the same phase')
      end do
      do i = 1, size(phase%deactivations)
        b = body_number(analysis, phase%deactivations(i)%body)
        if (b > 0) call refuse(.not. before(b), phase%deactivations(i), 'DEACTIVATE', 'is not there')
      end do
      do i = 1, size(phase%materials)
        b = body_number(analysis, phase%materials(i)%body)
        if (b == 0) cycle
        call refuse(coming(b) .or. going(b), phase%materials(i), 'CHANGE MATERIAL', &
          'is activated or deactivated in the same phase')
        call refuse(.not. (now(b) .or. coming(b) .or. going(b)), phase%materials(i), 'CHANGE MATERIAL', &
          'is not active: give it this material at *BODY, or in a phase after its *ACTIVATE')
      end do
    end associate

  contains

    !> Reports a change that is not possible.
    subroutine refuse(wrong, change, keyword, what)
      logical, intent(in) :: wrong
      type(body_change_type), intent(in) :: change
      character(len=*), intent(in) :: keyword, what

      if (wrong) call state%error_from(change%where, keyword, "body '"//change%body//"' "//what)
    end subroutine refuse
  end subroutine check_phase

  !> Checks that a phase loads and supports outlines of active bodies only.
  subroutine check_surfaces(state, phase, now)
    type(deck_state_type), intent(inout) :: state
    type(phase_type), intent(in) :: phase
    !> (bodies)
    logical, intent(in) :: now(:)
    integer :: i

    do i = 1, size(phase%tractions)
      call check_surface(phase%tractions(i)%surface, phase%tractions(i)%where, &
        trim(merge('PRESSURE', 'TRACTION', phase%tractions(i)%follows)))
    end do
    do i = 1, size(phase%supports)
      call check_surface(phase%supports(i)%surface, phase%supports(i)%where, &
        trim(merge('CONTRACTION', 'SUPPORT    ', phase%supports(i)%contracts)))
    end do

  contains

    !> Checks that the body of one surface is active.
    subroutine check_surface(name, where, keyword)
      character(len=*), intent(in) :: name, keyword
      type(source_line_type), intent(in) :: where
      integer :: s, b

      do s = 1, size(state%analysis%surfaces)
        associate (surface => state%analysis%surfaces(s))
          if (surface%name /= name .or. surface%selection /= select_outline) cycle
          b = body_number(state%analysis, surface%body)
          if (b == 0) cycle
          if (.not. now(b)) call state%error_from(where, keyword, "surface '"//name//"' is one of body '"// &
            surface%body//"', which is not active in phase '"//phase%name//"'")
        end associate
      end do
    end subroutine check_surface
  end subroutine check_surfaces

  !> Warns of a body that no phase activates.
  subroutine check_unused(state)
    type(deck_state_type), intent(inout) :: state
    logical :: used(size(state%analysis%bodies))
    integer :: p, b

    used = state%analysis%bodies%active
    do p = 1, size(state%analysis%phases)
      used = used .or. bodies_named(state%analysis, state%analysis%phases(p)%activations)
    end do
    do b = 1, size(used)
      if (.not. used(b)) call state%warn(state%analysis%bodies(b)%where, 'BODY', "body '"// &
        state%analysis%bodies(b)%name//"' has ACTIVE=NO, and no phase activates it")
    end do
  end subroutine check_unused

  !> Adds the keyword *PROP.
  subroutine add_prop_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('PROP', in_model, many, 'A spring between two places of the ground or of a structure, which '// &
      'move with it: a strut, or with FIXED=YES an anchor to a fixed place. *INSTALL activates it; its force is '// &
      'QUANTITY=PROP FORCE of *HISTORY. Forces and stiffness are per unit thickness in plane strain, per radian in '// &
      'axisymmetry.', prop_fields, &
      '*PROP, NAME=strut, STIFFNESS=2e4, TENSION LIMIT=0| 2, 5.5, 8, 5.5', check_prop, list=list_props, opens='prop')
  end subroutine add_prop_keyword

  !> Adds the keywords *INSTALL, *REMOVE.
  subroutine add_prop_stage_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('INSTALL', in_phase, once, 'Props activated in this phase, without force at their current '// &
      'length. A prop with a force is prestressed: the force is applied over the phase, and its stiffness acts '// &
      'from the next phase on.', install_fields, '*INSTALL| strut, -100', check_prop_changes)
    call table%add('REMOVE', in_phase, once, 'Props deactivated in this phase; their force is reduced to zero over '// &
      'the phase.', &
      remove_fields, '*REMOVE| strut', check_prop_changes)
  end subroutine add_prop_stage_keywords

  !> Describes the fields of *PROP.
  subroutine prop_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (prop => deck%analysis%props(deck%item))
      call fields%line(prop%where)
      call fields%name('NAME', prop%name, 'name of the prop', required=.true.)
      call fields%number('STIFFNESS', prop%stiffness, 'force over change of length', range='(0, inf)', required=.true.)
      call fields%number('COMPRESSION LIMIT', prop%limits(1), 'compressive force at which it yields; unlimited '// &
        'when not given', range='[0, inf)')
      call fields%number('TENSION LIMIT', prop%limits(2), 'tensile force at which it yields; unlimited when not '// &
        'given', range='[0, inf)')
      call fields%answer('FIXED', prop%fixed, 'YES: the second end does not move')
      call fields%data('ends')
      call fields%vector('', prop%places(:, 1), 'first end', 'coordinate', '1')
      call fields%vector('', prop%places(:, 2), 'second end', 'coordinate', '2')
    end associate
  end subroutine prop_fields

  !> Checks that a prop has a unique name and a length.
  subroutine check_prop(state)
    type(deck_state_type), intent(inout) :: state

    associate (prop => state%analysis%props(size(state%analysis%props)))
      if (.not. norm2(prop%places(:, 2) - prop%places(:, 1)) > 0.0_wp) call state%report_error('both ends are the '// &
        'same place')
    end associate
  end subroutine check_prop

  !> Describes the fields of *INSTALL.
  subroutine install_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call change_rows(fields, deck%analysis%phases(deck%phase)%installed, .true.)
  end subroutine install_fields

  !> Describes the fields of *REMOVE.
  subroutine remove_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call change_rows(fields, deck%analysis%phases(deck%phase)%removed, .false.)
  end subroutine remove_fields

  !> Describes the rows of props.
  subroutine change_rows(fields, list, with_force)
    class(card_fields_type), intent(inout) :: fields
    type(prop_change_type), allocatable, intent(inout) :: list(:)
    !> A force may be given for each prop.
    logical, intent(in) :: with_force
    integer :: i, n

    n = size(list)
    call fields%list(trim(merge('prop and force', 'prop          ', with_force)), n)
    if (.not. fields%writing) list = [(prop_change_type(), i=1, n)]
    do i = 1, n
      call fields%row(i)
      call fields%line(list(i)%where)
      call fields%name('prop', list(i)%prop, 'the prop')
      if (with_force) call fields%number('force', list(i)%force, 'force at the end of the phase, tension positive, '// &
        'per unit of load factor; without it the prop acts as a spring from the start of the phase', &
        required=.false., given=list(i)%jacked)
    end do
  end subroutine change_rows

  !> Checks that each prop is named once.
  subroutine check_prop_changes(state)
    type(deck_state_type), intent(inout) :: state

    call state%check_once('prop')
  end subroutine check_prop_changes

  !> Checks that the props of phases exist, are installed when they are removed, and resist the jacking force.
  subroutine check_props(state)
    type(deck_state_type), intent(inout) :: state
    type(prop_stage_type) :: stage
    logical :: used
    integer :: i, k, p

    do p = 1, size(state%analysis%phases)
      associate (phase => state%analysis%phases(p))
        do k = 1, size(phase%installed)
          call check_name(state, phase%installed(k)%prop, state%analysis%props, phase%installed(k)%where, 'INSTALL', &
            'prop')
        end do
        do k = 1, size(phase%removed)
          call check_name(state, phase%removed(k)%prop, state%analysis%props, phase%removed(k)%where, 'REMOVE', 'prop')
        end do
      end associate
    end do
    do i = 1, size(state%analysis%props)
      used = .false.
      do p = 1, size(state%analysis%phases)
        stage = prop_stage(state%analysis%phases, p, state%analysis%props(i)%name)
        used = used .or. stage%there
        call check_stage(state, state%analysis%props(i), p, stage)
      end do
      if (.not. used) call state%warn(state%analysis%props(i)%where, 'PROP', "no phase installs prop '"// &
        state%analysis%props(i)%name//"'")
    end do
  end subroutine check_props

  !> Checks that a change of a prop in a phase is possible.
  subroutine check_stage(state, prop, number, stage)
    type(deck_state_type), intent(inout) :: state
    type(prop_type), intent(in) :: prop
    !> Number of the phase.
    integer, intent(in) :: number
    type(prop_stage_type), intent(in) :: stage
    integer :: k

    associate (phase => state%analysis%phases(number))
      do k = 1, size(phase%installed)
        if (phase%installed(k)%prop /= prop%name) cycle
        if (.not. stage%there) call state%error_from(phase%installed(k)%where, 'INSTALL', "prop '"//prop%name// &
          "' is deactivated in the same phase")
        if (stage%before .and. .not. stage%driven) call state%error_from(phase%installed(k)%where, 'INSTALL', &
          "prop '"//prop%name//"' is already active; give a force to prestress it again")
        if (stage%force < -prop%limits(1) .or. stage%force > prop%limits(2)) call state%error_from( &
          phase%installed(k)%where, 'INSTALL', "the force exceeds the limit of prop '"//prop%name//"'")
      end do
      do k = 1, size(phase%removed)
        if (phase%removed(k)%prop == prop%name .and. .not. stage%before) call state%error_from( &
          phase%removed(k)%where, 'REMOVE', "prop '"//prop%name//"' is not there")
      end do
    end associate
  end subroutine check_stage
end module qsmpm_deck_stages
