!> Props: the cards *PROP, *INSTALL and *REMOVE.
module qsmpm_deck_props
  use qsmpm_kinds, only: wp
  use qsmpm_structures, only: prop_change_type, prop_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_objects, only: list_props, check_new_name
  use qsmpm_deck_state, only: deck_state_type, check_name
  use qsmpm_keyword_table, only: table_type, in_model, in_phase, once, many
  use qsmpm_phase_loads, only: prop_stage_type, prop_stage
  implicit none
  private

  public :: add_prop_keyword, add_prop_stage_keywords, check_props

contains

  !> *PROP.
  subroutine add_prop_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('PROP', in_model, many, 'A spring between two places of the ground or of what stands in it, '// &
      'that go with it: a strut, or with FIXED=YES one that leans on a place that does not move. *INSTALL puts '// &
      'it in place; its force is QUANTITY=PROP FORCE of *HISTORY. Forces and stiffness are those of a slice of '// &
      'unit thickness in plane strain, of a radian in axisymmetry.', prop_fields, &
      '*PROP, NAME=strut, STIFFNESS=2e4, TENSION LIMIT=0| 2, 5.5, 8, 5.5', check_prop, list=list_props, opens='prop')
  end subroutine add_prop_keyword

  !> *INSTALL, *REMOVE.
  subroutine add_prop_stage_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('INSTALL', in_phase, once, 'Props that this phase puts in place, without force and at the '// &
      'length that they have then. One with a force is jacked: the phase brings it there, and its stiffness counts '// &
      'from the next phase on.', install_fields, '*INSTALL| strut, -100', check_changes)
    call table%add('REMOVE', in_phase, once, 'Props that this phase takes out; their force falls to zero over it.', &
      remove_fields, '*REMOVE| strut', check_changes)
  end subroutine add_prop_stage_keywords

  !> *PROP.
  subroutine prop_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (prop => deck%analysis%props(deck%item))
      call fields%line(prop%where)
      call fields%name('NAME', prop%name, 'name of the prop', required=.true.)
      call fields%number('STIFFNESS', prop%stiffness, 'force over change of length', range='(0, inf)', required=.true.)
      call fields%number('COMPRESSION LIMIT', prop%limits(1), 'largest force of compression, at which it yields; '// &
        'none when not given', range='[0, inf)')
      call fields%number('TENSION LIMIT', prop%limits(2), 'the same of tension', range='[0, inf)')
      call fields%answer('FIXED', prop%fixed, 'YES: the second end does not move')
      call fields%data('ends')
      call fields%number('x1', prop%places(1, 1), 'first end')
      call fields%number('y1', prop%places(2, 1), 'coordinate')
      call fields%number('z1', prop%places(3, 1), 'coordinate', third=.true.)
      call fields%number('x2', prop%places(1, 2), 'second end')
      call fields%number('y2', prop%places(2, 2), 'coordinate')
      call fields%number('z2', prop%places(3, 2), 'coordinate', third=.true.)
    end associate
  end subroutine prop_fields

  !> It has a name of its own and a length.
  subroutine check_prop(state)
    type(deck_state_type), intent(inout) :: state

    call check_new_name(state, list_props, 'prop')
    associate (prop => state%analysis%props(size(state%analysis%props)))
      if (.not. norm2(prop%places(:, 2) - prop%places(:, 1)) > 0.0_wp) call state%report_error('both ends are the '// &
        'same place')
    end associate
  end subroutine check_prop

  !> *INSTALL.
  subroutine install_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call change_rows(fields, deck%analysis%phases(deck%phase)%installed, .true.)
  end subroutine install_fields

  !> *REMOVE.
  subroutine remove_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call change_rows(fields, deck%analysis%phases(deck%phase)%removed, .false.)
  end subroutine remove_fields

  !> Rows of a card.
  subroutine change_rows(fields, list, with_force)
    class(card_fields_type), intent(inout) :: fields
    type(prop_change_type), allocatable, intent(inout) :: list(:)
    !> A force may stand beside each prop.
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
        'per unit of load factor; without it the prop follows its length from the start of the phase', &
        required=.false., given=list(i)%jacked)
    end do
  end subroutine change_rows

  !> Each prop is named once.
  subroutine check_changes(state)
    type(deck_state_type), intent(inout) :: state

    call state%check_once('prop')
  end subroutine check_changes

  !> Props that phases name exist; they are there when they are taken out, and bear the force that they are jacked to.
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

  !> What a phase does to a prop can be done.
  subroutine check_stage(state, prop, number, stage)
    type(deck_state_type), intent(inout) :: state
    type(prop_type), intent(in) :: prop
    !> Of the phase.
    integer, intent(in) :: number
    type(prop_stage_type), intent(in) :: stage
    integer :: k

    associate (phase => state%analysis%phases(number))
      do k = 1, size(phase%installed)
        if (phase%installed(k)%prop /= prop%name) cycle
        if (.not. stage%there) call state%error_from(phase%installed(k)%where, 'INSTALL', "prop '"//prop%name// &
          "' is taken out by the same phase")
        if (stage%before .and. .not. stage%driven) call state%error_from(phase%installed(k)%where, 'INSTALL', &
          "prop '"//prop%name//"' is there already; with a force it is jacked anew")
        if (stage%force < -prop%limits(1) .or. stage%force > prop%limits(2)) call state%error_from( &
          phase%installed(k)%where, 'INSTALL', "the force is beyond what prop '"//prop%name//"' bears")
      end do
      do k = 1, size(phase%removed)
        if (phase%removed(k)%prop == prop%name .and. .not. stage%before) call state%error_from( &
          phase%removed(k)%where, 'REMOVE', "prop '"//prop%name//"' is not there")
      end do
    end associate
  end subroutine check_stage
end module qsmpm_deck_props
