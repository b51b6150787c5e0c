!> The card of contacts, *CONTACT, and what it must find: bodies, surfaces, an outline.
module qsmpm_deck_contact
  use qsmpm_kinds, only: wp
  use qsmpm_structures, only: rigid_plane, contact_on_soil, contact_on_body, patch_point
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_objects, only: list_contacts
  use qsmpm_deck_state, only: deck_state_type, check_name
  use qsmpm_deck_words, only: bar_list, contact_words, patch_words
  use qsmpm_keyword_table, only: table_type, in_model, many
  implicit none
  private

  public :: add_contact_keywords, check_contacts

contains

  !> *CONTACT.
  subroutine add_contact_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('CONTACT', in_model, many, 'A surface of the soil that may touch a rigid body, press against it '// &
      'and slide along it; with ON=BODY any soil that flows around the body.', contact_fields, &
      '*CONTACT, BODY=pipe, SURFACE=seabed, FRICTION ANGLE=20', check_contact, list=list_contacts, opens='contact')
  end subroutine add_contact_keywords

  !> *CONTACT.
  subroutine contact_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (contact => deck%analysis%contacts(deck%item))
      call fields%line(contact%where)
      call fields%name('BODY', contact%body, 'the rigid body', required=.true.)
      call fields%choice('ON', contact%place, bar_list(contact_words), 'where contact is asked for. SOIL: at the '// &
        'points of SURFACE. BODY: on the outline of the body, for soil that flows around it')
      call fields%name('SURFACE', contact%surface, 'the surface of the soil; not with ON=BODY')
      call fields%number('FRICTION ANGLE', contact%friction_angle, 'degrees', range='[0, 90)')
      call fields%number('ADHESION', contact%adhesion, 'shear strength beside that of friction; where the '// &
        'soil parts from the body it is lost, unless TENSION=YES, as along a pile that is pulled', range='[0, inf)')
      call fields%number('INTERFACE', contact%interface, 'in place of FRICTION ANGLE and ADHESION: share R of the '// &
        'strength of the soil there, tan(delta) = R tan(phi), a = R c', range='(0, 1]')
      call fields%number('PENALTY', contact%penalty, 'penalty of the gap times the size of a cell over the modulus '// &
        'of the soil; 100 on soil and 10 on bodies when not given, that of the slip is 1', range='(0, inf)')
      call fields%choice('PATCH', contact%patch, bar_list(patch_words), 'what contact is asked for on in the mean. '// &
        'CELL: what a cell holds of the surface. POINT: every point, with waves in the pressure; to compare with')
      call fields%answer('TENSION', contact%tension, 'YES: what has touched once, or touches at the start, does '// &
        'not part')
    end associate
  end subroutine contact_fields

  !> A surface has one contact, and so has the outline of a body.
  subroutine check_contact(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i, n

    associate (contacts => state%analysis%contacts)
      n = size(contacts)
      if (state%card%has('SURFACE') .and. contacts(n)%place &
        == contact_on_body) call state%report_error('with ON=BODY contact is asked for on the body: there is no '// &
        'SURFACE')
      if (contacts(n)%place == contact_on_soil .and. &
        .not. state%card%has('SURFACE')) call state%report_error('SURFACE is missing: the surface of the soil that '// &
        'may touch the body; or ON=BODY')
      if (state%card%has('INTERFACE') .and. (state%card%has('FRICTION ANGLE') .or. &
        state%card%has('ADHESION'))) call state%report_error('INTERFACE says what FRICTION ANGLE and ADHESION '// &
        'would: one or the other')
      if (contacts(n)%patch == patch_point) call state%warn(contacts(n)%where, 'CONTACT', 'PATCH=POINT is there to '// &
        'be compared with: the pressure swings from point to point')
      if (contacts(n)%place == contact_on_body .and. state%dimension == 3) call state%report_error('ON=BODY is for '// &
        'plane and axisymmetric models; in 3D name a SURFACE')
      do i = 1, n - 1
        if (contacts(i)%place /= contacts(n)%place) cycle
        if (contacts(n)%place == contact_on_soil .and. contacts(i)%surface &
          == contacts(n)%surface) call state%report_error("surface '"//contacts(n)%surface//"' has a contact already")
        if (contacts(n)%place == contact_on_body .and. contacts(i)%body &
          == contacts(n)%body) call state%report_error("body '"//contacts(n)%body//"' has a contact with ON=BODY "// &
          "already")
      end do
    end associate
  end subroutine check_contact

  !> Bodies and surfaces of contacts exist.
  subroutine check_contacts(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    do i = 1, size(state%analysis%contacts)
      associate (contact => state%analysis%contacts(i))
        call check_name(state, contact%body, state%analysis%rigid_bodies, contact%where, 'CONTACT', 'rigid body')
        if (contact%place == contact_on_body) then
          call check_outline(state, i)
        else
          call check_name(state, contact%surface, state%analysis%surfaces, contact%where, 'CONTACT', 'surface')
          if (state%analysis%confinement > 0.0_wp) call state%error_from(contact%where, 'CONTACT', 'under a '// &
            '*CONFINING PRESSURE contact is asked for on the body: ON=BODY in place of SURFACE')
        end if
      end associate
    end do
    call warn_of_untouched(state)
    call warn_of_water(state)
  end subroutine check_contacts

  !> A body on which contact is asked for has an outline.
  subroutine check_outline(state, contact)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: contact
    integer :: b

    associate (bodies => state%analysis%rigid_bodies, where => state%analysis%contacts(contact)%where)
      do b = 1, size(bodies)
        if (bodies(b)%name == state%analysis%contacts(contact)%body .and. bodies(b)%shape == rigid_plane) &
          call state%error_from(where, 'CONTACT', 'ON=BODY is for bodies with an outline, which a PLANE has not; '// &
          'name the SURFACE of the soil')
      end do
    end associate
  end subroutine check_outline

  !> A rigid body that no surface may touch does nothing.
  subroutine warn_of_untouched(state)
    type(deck_state_type), intent(inout) :: state
    integer :: b, i
    logical :: touched

    do b = 1, size(state%analysis%rigid_bodies)
      associate (body => state%analysis%rigid_bodies(b))
        touched = any([(state%analysis%contacts(i)%body == body%name, i=1, size(state%analysis%contacts))])
        if (.not. touched) call state%warn(body%where, 'RIGID BODY', "'"//body%name//"' touches nothing: it has no "// &
          '*CONTACT')
      end associate
    end do
  end subroutine warn_of_untouched

  !> Contact carries effective stresses.
  subroutine warn_of_water(state)
    type(deck_state_type), intent(inout) :: state
    integer :: p

    if (size(state%analysis%contacts) == 0) return
    do p = 1, size(state%analysis%phases)
      if (size(state%analysis%phases(p)%water_levels) == 0) cycle
      call state%warn(state%analysis%contacts(1)%where, 'CONTACT', 'contact carries effective stresses: the '// &
        'pressure of the water below *WATER LEVEL is in no CONTACT FORCE; add it for the whole force on the body')
      return
    end do
  end subroutine warn_of_water
end module qsmpm_deck_contact
