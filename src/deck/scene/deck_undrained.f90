!> Cards of undrained soil: *UNDRAINED of a material, *DRAIN STATE of a phase, and what must fit them.
module qsmpm_deck_undrained
  use qsmpm_kinds, only: wp
  use qsmpm_body_description, only: drain_state_type
  use qsmpm_material_description, only: material_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type, check_name
  use qsmpm_drainage, only: set_drainage, is_drained_by, has_excess_pressure
  use qsmpm_keyword_table, only: table_type, in_material, in_phase, once
  use qsmpm_named, only: place_named
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_material_traits, only: traits_of
  use qsmpm_text, only: string_type, real_text
  use qsmpm_undrained_parameters, only: undrained_a, undrained_b, undrained_ratio
  implicit none
  private

  public :: add_undrained_keyword, add_drain_keyword, check_undrained

contains

  !> *UNDRAINED.
  subroutine add_undrained_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('UNDRAINED', in_material, once, 'Pore water that cannot leave: volume changes raise or lower an '// &
      'excess pore pressure (state variable excess_pore_pressure, compression positive), stresses are total beyond '// &
      'the steady pore pressure, and the treatment of volumetric locking is on: docs/methods/undrained.md.', &
      undrained_fields, '*ELASTIC| 3000, 0.3|*MOHR COULOMB| 2, 25, 0|*UNDRAINED, TYPE=A', finish_undrained)
  end subroutine add_undrained_keyword

  !> *DRAIN STATE.
  subroutine add_drain_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('DRAIN STATE', in_phase, once, 'The pore water of *UNDRAINED materials may leave in this phase: '// &
      'the excess pressure falls evenly to zero over it, and the soil takes over what the water carried. Every '// &
      'step is in equilibrium. Without bodies it is about all of them.', drain_fields, &
      '*DRAIN STATE, AFTERWARDS=DRAINED')
  end subroutine add_drain_keyword

  !> Fields of *UNDRAINED.
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
      call fields%number('SKEMPTON', undrained%skempton, "Skempton's B in the place of NU", range='(0, 1)')
      call fields%answer('DILATANT', undrained%dilatant, 'YES allows a dilatancy angle with TYPE=A, which gives '// &
        'strength without end', needs='TYPE=A')
    end associate
  end subroutine undrained_fields

  !> NU or SKEMPTON.
  subroutine finish_undrained(state)
    type(deck_state_type), intent(inout) :: state

    if (state%card%has('NU') .and. state%card%has('SKEMPTON')) call state%report_error('give NU or SKEMPTON, not both')
  end subroutine finish_undrained

  !> Fields of *DRAIN STATE.
  subroutine drain_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (drain => deck%analysis%phases(deck%phase)%drain_state)
      call fields%given(drain%given)
      call fields%line(drain%where)
      call fields%answer('KEEP PRESSURE', drain%keeps, 'YES leaves the excess pressure as it is; the soil is '// &
        'drained in the phase, so that no other one comes about')
      call fields%answer('AFTERWARDS', drain%stays_drained, 'what the soil is in the phases after this one', &
        words='UNDRAINED|DRAINED')
      call drain_rows(fields, drain%bodies)
    end associate
  end subroutine drain_fields

  !> Bodies of *DRAIN STATE, one a line.
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

  !> What belongs to undrained soil of complete materials and phases.
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

  !> What is wrong with the card of a material, empty for nothing.
  function wrong_material(material) result(sentence)
    type(material_type), intent(in) :: material
    character(len=:), allocatable :: sentence
    type(law_description_type) :: traits

    sentence = ''
    traits = traits_of(material)
    associate (undrained => material%undrained)
      if (traits%total_stress) then
        sentence = '*'//traits%keyword//' is a law of total stress, undrained by itself'
      else if (undrained%kind /= undrained_a .and. (.not. material%mohr_coulomb .or. material%user%given .or. &
        allocated(material%soil_law))) then
        sentence = 'TYPE='//trim(merge('B', 'C', undrained%kind == undrained_b))//' wants a strength s_u: *MOHR '// &
          'COULOMB with c = s_u and phi = 0; TYPE=A takes the effective strength of any law'
      else if (undrained%kind /= undrained_a .and. material%friction_angle > 0.0_wp) then
        sentence = 'TYPE='//trim(merge('B', 'C', undrained%kind == undrained_b))//' wants *MOHR COULOMB with c = '// &
          's_u and phi = 0; with friction it is TYPE=A'
      else if (undrained%kind == undrained_a .and. traits%dilatancy_angle > 0.0_wp .and. .not. undrained%dilatant) then
        sentence = 'the dilatancy angle psi is '//real_text(traits%dilatancy_angle)//': undrained soil that '// &
          'dilates gains strength without end; take psi = 0, or ask for it by DILATANT=YES'
      else if (material%user%given .and. material%user%undrained > 0.0_wp) then
        sentence = 'the model has pore water of its own by UNDRAINED of *USER MATERIAL: it would count twice'
      else if (traits%linear_elasticity .and. material%young > 0.0_wp .and. &
        .not. undrained_ratio(undrained, material%poisson) > material%poisson) then
        sentence = 'NU='//real_text(undrained%poisson)//" is not above Poisson's ratio of the soil, "// &
          real_text(material%poisson)//': the pore water would have no stiffness'
      end if
    end associate
  end function wrong_material

  !> There is excess pressure to drain, and the bodies of one material go together.
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

  !> All bodies of a material are named where one is.
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
          "' has the material '"//body%material//"' of a body that is drained: name it too, or give it a material "// &
          'of its own')
      end associate
    end do
  end subroutine check_together
end module qsmpm_deck_undrained
