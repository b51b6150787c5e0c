!> Rigid bodies: *RIGID BODY and its shapes; *CONTACT, and the checks of its bodies, surfaces and outlines; *MOVE and
!> *LOAD, motions and loads in a phase.
module qsmpm_deck_rigid_bodies
  use qsmpm_analysis, only: plane_strain, axisymmetric
  use qsmpm_structures, only: rigid_body_type, rigid_plane, rigid_circle, rigid_box, rigid_polygon, rigid_cylinder, &
    contact_on_soil, contact_on_body, patch_point, rigid_move_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_bodies, only: polygon_fields, finish_polygon, box_fields, check_box
  use qsmpm_deck_state, only: deck_state_type, check_name, list_rigid_bodies, list_contacts, list_moves
  use qsmpm_keyword_table, only: table_type, in_model, many, in_phase, bar_list, rigid_words, contact_words, &
    patch_words, load_words
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: upper
  use qsmpm_phase_description, only: phase_type
  implicit none
  private

  public :: add_rigid_body_keywords, check_contacts, add_move_keywords, check_moves

  !> Component of a load that is a moment about z.
  integer, parameter :: turning = 4

contains

  !> Adds the keywords *RIGID BODY, *CONTACT.
  subroutine add_rigid_body_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('RIGID BODY', in_model, many, 'A rigid body: a plate, pipe, cone, wall. *CONTACT defines the '// &
      'surface of the soil in contact with it, *MOVE its motion.', rigid_body_fields, &
      '*RIGID BODY, NAME=pipe, SHAPE=CIRCLE| 0, 1.25, 0.25', finish_rigid_body, list=list_rigid_bodies, &
      opens='rigid body')
    call table%add('CONTACT', in_model, many, 'Contact between a surface of the soil and a rigid body, with '// &
      'friction and separation; with ON=BODY of any soil that flows around the body. Friction acts on effective '// &
      'stresses, in soil with *CONSOLIDATION on the pressure less that of the water.', contact_fields, &
      '*CONTACT, BODY=pipe, SURFACE=seabed, FRICTION ANGLE=20', check_contact, list=list_contacts, opens='contact')
  end subroutine add_rigid_body_keywords

  !> Describes the fields of *RIGID BODY.
  subroutine rigid_body_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (body => deck%analysis%rigid_bodies(deck%item))
      call fields%line(body%where)
      call fields%name('NAME', body%name, 'name of the body', required=.true.)
      if (fields%reading) body%shape = 0
      call fields%choice('SHAPE', body%shape, bar_list(rigid_words), 'PLANE: the half space behind a plane. '// &
        'CIRCLE: in axisymmetry and 3D a sphere. CONE: tip downwards, with a shaft above. POLYGON: in axisymmetry '// &
        'with an edge on the axis, in 3D prismatic along z. CYLINDER: vertical, in axisymmetry and 3D', required=.true.)
      call fields%number('ROUND', body%round, 'radius of the corners of BOX, CONE, POLYGON and CYLINDER; when not '// &
        'given a quarter of a cell', range='(0, inf)')
      call fields%answer('IN PLACE', body%in_place, 'YES: the soil inside it is removed before the first step '// &
        '(plane strain and axisymmetry)')
      call place_fields(fields, body, 'plane', 'a point of the plane')
      call fields%vector('n', body%direction, 'normal direction towards the soil', 'direction')
      call place_fields(fields, body, 'circle', 'the centre')
      call fields%number('radius', body%radius, 'radius', range='(0, inf)')
      call fields%data('box', when='SHAPE=BOX')
      call box_fields(fields, body%box)
      call turn_fields(fields, body%rotation, 'its middle')
      call cone_fields(fields, body)
      call polygon_fields(fields, body%polygon)
      call cylinder_fields(fields, body)
    end associate
  end subroutine rigid_body_fields

  !> Describes the data line of a shape that begins with a place.
  subroutine place_fields(fields, body, shape, what)
    class(card_fields_type), intent(inout) :: fields
    type(rigid_body_type), intent(inout) :: body
    !> Word of SHAPE in lower case, and what the place is.
    character(len=*), intent(in) :: shape, what

    call fields%data(shape, when='SHAPE='//upper(shape))
    call fields%vector('', body%place, 'coordinate of '//what, 'coordinate')
  end subroutine place_fields

  !> Describes a cone.
  subroutine cone_fields(fields, body)
    class(card_fields_type), intent(inout) :: fields
    type(rigid_body_type), intent(inout) :: body

    call place_fields(fields, body, 'cone', 'the tip')
    call fields%number('radius', body%radius, 'radius of the shaft', range='(0, inf)')
    call fields%number('angle', body%apex_angle, 'angle of the tip in degrees', range='(0, 180)')
    call fields%number('shaft', body%shaft, 'length of the shaft', range='(0, inf)')
  end subroutine cone_fields

  !> Describes a cylinder.
  subroutine cylinder_fields(fields, body)
    class(card_fields_type), intent(inout) :: fields
    type(rigid_body_type), intent(inout) :: body

    call place_fields(fields, body, 'cylinder', 'the middle of its base')
    call fields%number('radius', body%radius, 'radius', range='(0, inf)')
    call fields%number('height', body%shaft, 'from its base upwards', range='(0, inf)')
  end subroutine cylinder_fields

  !> Describes a rotation in 3D.
  subroutine turn_fields(fields, rotation, about)
    class(card_fields_type), intent(inout) :: fields
    real(wp), intent(inout) :: rotation(3)
    character(len=*), intent(in) :: about

    call fields%number('rx', rotation(1), 'rotation about '//about//', axis times angle in degrees: 0, 0, 30 turns '// &
      'x to y', required=.false., third=.true.)
    call fields%number('ry', rotation(2), 'rotation', required=.false., third=.true.)
    call fields%number('rz', rotation(3), 'rotation', required=.false., third=.true.)
  end subroutine turn_fields

  !> Checks that the data of a shape are complete.
  subroutine finish_rigid_body(state)
    type(deck_state_type), intent(inout) :: state

    associate (body => state%analysis%rigid_bodies(state%item))
      if (state%dimension == 3 .and. body%in_place) call state%report_error('IN PLACE supports plane strain and '// &
        'axisymmetry: in 3D define the soil bodies without it')
      if (state%analysis%model == plane_strain .and. body%shape &
        == rigid_cylinder) call state%report_error('CYLINDER is for axisymmetry and 3D; in plane strain use a BOX '// &
        'or a CIRCLE')
      if (state%card%has('ROUND') .and. any(body%shape == [rigid_plane, &
        rigid_circle])) call state%report_error('ROUND is for the corners of BOX, CONE, POLYGON and CYLINDER')
      select case (body%shape)
      case (rigid_plane)
        if (state%card%is_right() .and. .not. norm2(body%direction) > 0.0_wp) call state%report_error('the plane '// &
          'has no normal: nx and ny are 0')
      case (rigid_box)
        call check_box(.true., body%box, state)
      case (rigid_polygon)
        call finish_polygon(body%polygon, state)
      end select
    end associate
  end subroutine finish_rigid_body

  !> Describes the fields of *CONTACT.
  subroutine contact_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (contact => deck%analysis%contacts(deck%item))
      call fields%line(contact%where)
      call fields%name('BODY', contact%body, 'the rigid body', required=.true.)
      call fields%choice('ON', contact%place, bar_list(contact_words), 'where contact is enforced. SOIL: at the '// &
        'points of SURFACE. BODY: on the outline of the body, for soil that flows around it')
      call fields%name('SURFACE', contact%surface, 'the surface of the soil; not with ON=BODY')
      call fields%number('FRICTION ANGLE', contact%friction_angle, 'degrees', range='[0, 90)')
      call fields%number('ADHESION', contact%adhesion, 'shear strength in addition to friction; it is lost where '// &
        'the soil separates from the body, unless TENSION=YES, as along a pile in tension', range='[0, inf)')
      call fields%number('INTERFACE', contact%interface, 'strength reduction factor R of the interface, in place '// &
        'of FRICTION ANGLE and ADHESION: tan(delta) = R tan(phi), a = R c of the adjacent soil', range='(0, 1]')
      call fields%number('PENALTY', contact%penalty, 'normal penalty times the cell size over the modulus of the '// &
        'soil; when not given 100 with ON=SOIL and 10 with ON=BODY; the tangential one is 1', range='(0, inf)')
      call fields%choice('PATCH', contact%patch, bar_list(patch_words), 'part of the surface on which contact is '// &
        'enforced in the mean. CELL: the part in a cell. POINT: every point, with oscillating pressures; for '// &
        'comparison only')
      call fields%answer('TENSION', contact%tension, 'YES: no separation after first contact, or of contact at the '// &
        'start')
    end associate
  end subroutine contact_fields

  !> Checks that a surface has one contact, and so has the outline of a body.
  subroutine check_contact(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i, n

    associate (contacts => state%analysis%contacts)
      n = size(contacts)
      if (state%card%has('SURFACE') .and. contacts(n)%place &
        == contact_on_body) call state%report_error('with ON=BODY contact is enforced on the body: there is no '// &
        'SURFACE')
      if (contacts(n)%place == contact_on_soil .and. &
        .not. state%card%has('SURFACE')) call state%report_error('SURFACE is missing: the surface of the soil in '// &
        'contact with the body; or use ON=BODY')
      if (state%card%has('INTERFACE') .and. (state%card%has('FRICTION ANGLE') .or. &
        state%card%has('ADHESION'))) call state%report_error('INTERFACE replaces FRICTION ANGLE and ADHESION: give '// &
        'one or the other')
      if (contacts(n)%patch == patch_point) call state%warn(contacts(n)%where, 'CONTACT', 'PATCH=POINT is for '// &
        'comparison only: the pressure oscillates from point to point')
      if (contacts(n)%place == contact_on_body .and. state%dimension == 3) call state%report_error('ON=BODY '// &
        'supports plane and axisymmetric models; in 3D give a SURFACE')
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

  !> Checks that bodies and surfaces of contacts exist.
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
            '*CONFINING PRESSURE contact is enforced on the body: ON=BODY in place of SURFACE')
        end if
      end associate
    end do
    call warn_of_untouched(state)
    call warn_of_water(state)
  end subroutine check_contacts

  !> Checks that a body with contact has an outline.
  subroutine check_outline(state, contact)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: contact
    integer :: b

    associate (bodies => state%analysis%rigid_bodies, where => state%analysis%contacts(contact)%where)
      do b = 1, size(bodies)
        if (bodies(b)%name == state%analysis%contacts(contact)%body .and. bodies(b)%shape == rigid_plane) &
          call state%error_from(where, 'CONTACT', 'ON=BODY requires a body with an outline, which a PLANE does not '// &
          'have; give the SURFACE of the soil')
      end do
    end associate
  end subroutine check_outline

  !> Warns of a rigid body without contact, which has no effect.
  subroutine warn_of_untouched(state)
    type(deck_state_type), intent(inout) :: state
    integer :: b, i
    logical :: touched

    do b = 1, size(state%analysis%rigid_bodies)
      associate (body => state%analysis%rigid_bodies(b))
        touched = any([(state%analysis%contacts(i)%body == body%name, i=1, size(state%analysis%contacts))])
        if (.not. touched) call state%warn(body%where, 'RIGID BODY', "'"//body%name//"' has no *CONTACT")
      end associate
    end do
  end subroutine warn_of_untouched

  !> Warns that contact transmits effective stresses only where the water is given by a level, and total ones beside
  !> undrained soil.
  subroutine warn_of_water(state)
    type(deck_state_type), intent(inout) :: state
    integer :: p

    if (size(state%analysis%contacts) == 0) return
    if (any(state%analysis%contacts%friction_angle > 0.0_wp) .and. any(state%analysis%materials%undrained%given)) &
      call state%warn(state%analysis%contacts(1)%where, 'CONTACT', 'friction beside *UNDRAINED soil acts on the '// &
      'total pressure, without the excess pore pressure: give ADHESION, or *CONSOLIDATION in place of *UNDRAINED')
    do p = 1, size(state%analysis%phases)
      if (size(state%analysis%phases(p)%water_levels) == 0) cycle
      call state%warn(state%analysis%contacts(1)%where, 'CONTACT', 'contact transmits effective stresses: CONTACT '// &
        'FORCE does not include the water pressure below *WATER LEVEL, except under a free surface of '// &
        '*CONSOLIDATION; add it for the total force on the body, and give *LOAD less the uplift')
      return
    end do
  end subroutine warn_of_water

  !> Adds the keywords *MOVE, *LOAD.
  subroutine add_move_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('MOVE', in_phase, many, 'Prescribed motion of a rigid body in the phase, per unit of load '// &
      'factor; without it the body does not move.', move_fields, '*MOVE, BODY=pipe| 0, '// &
      '-0.5', check_move, list=list_moves, &
      opens='motion')
    call table%add('LOAD', in_phase, many, 'Force on a rigid body along one axis, or moment about z, per unit of '// &
      'load factor: in this direction it is free from this phase on, in equilibrium with the contact forces, until '// &
      '*MOVE prescribes its motion again. A body that was fixed starts from the force of the soil on '// &
      'it.', load_fields, '*LOAD, BODY=plate, COMPONENT=Y| -50|'// &
      '*LOAD, BODY=plate, COMPONENT=MZ| 0', check_body_load, list=list_moves, opens='force on a rigid body')
  end subroutine add_move_keywords

  !> Describes the fields of *MOVE.
  subroutine move_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    logical :: plane

    associate (move => deck%analysis%phases(deck%phase)%moves(deck%item))
      call fields%there(.not. move%is_load)
      call fields%line(move%where)
      call fields%name('BODY', move%body, 'the rigid body', required=.true.)
      plane = deck%dimension /= 3
      call fields%number('ROTATION', move%rotation(3), 'about its reference point (centre, tip), degrees, '// &
        'counter-clockwise; in 3D use rx, ry, rz', given=plane)
      call fields%data('displacement')
      call fields%vector('u', move%vector, 'component')
      call turn_fields(fields, move%rotation, 'its reference point')
    end associate
  end subroutine move_fields

  !> Checks that a body has one motion in a phase.
  subroutine check_move(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (moves => state%analysis%phases(state%phase)%moves)
      do i = 1, size(moves) - 1
        if (moves(i)%is_load .or. moves(i)%body /= moves(size(moves))%body) cycle
        call state%report_error("body '"//moves(i)%body//"' has a motion in this phase already")
      end do
      if (state%dimension == 3 .and. state%card%has('ROTATION')) call state%report_error('ROTATION is for the '// &
        'plane; in 3D give rx, ry, rz behind the displacement: axis times angle in degrees')
    end associate
  end subroutine check_move

  !> Describes the fields of *LOAD.
  subroutine load_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (move => deck%analysis%phases(deck%phase)%moves(deck%item))
      call fields%given(move%is_load)
      call fields%line(move%where)
      call fields%name('BODY', move%body, 'the rigid body', required=.true.)
      call fields%choice('COMPONENT', move%component, bar_list(load_words), 'axis of a force; MZ: moment about the '// &
        'reference point of the body (plane strain); 0 lets it rotate freely', required=.true.)
      call fields%data('force')
      call fields%number('force', move%load, 'on the body, or moment; in axisymmetry per radian')
      call fields%number('x', move%place(1), 'point of application of the force in the initial geometry, which '// &
        'rotates with the body; its reference point (centre, tip) when not '// &
        'given', required=.false., given=move%placed(1))
      call fields%number('y', move%place(2), 'coordinate', required=.false., given=move%placed(2))
    end associate
  end subroutine load_fields

  !> Checks that a component is loaded once, and not moved as well.
  subroutine check_body_load(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i, n

    associate (moves => state%analysis%phases(state%phase)%moves)
      n = size(moves)
      if (moves(n)%component == 3 .and. state%dimension == 2) call state%report_error('COMPONENT=Z is for 3D')
      if (moves(n)%component == turning .and. state%analysis%model &
        /= plane_strain) call state%report_error('COMPONENT=MZ supports plane strain; otherwise bodies rotate by '// &
        '*MOVE only')
      call check_load_place(state, moves(n))
      if (state%analysis%model == axisymmetric .and. moves(n)%component &
        == 1) call state%report_error('in axisymmetry a body is free along the axis only: COMPONENT=Y')
      do i = 1, n - 1
        if (moves(i)%is_load .and. moves(i)%body == moves(n)%body .and. moves(i)%component &
          == moves(n)%component) call state%report_error("body '"//moves(n)%body//"' has a load in this component "// &
          "in this phase already")
      end do
    end associate
  end subroutine check_body_load

  !> Checks that the point of application is complete and belongs to a force.
  subroutine check_load_place(state, load)
    type(deck_state_type), intent(inout) :: state
    type(rigid_move_type), intent(in) :: load

    if (.not. any(load%placed)) return
    if (.not. all(load%placed)) call state%report_error('the point of application of the force requires x and y')
    if (load%component == turning) call state%report_error('a moment has no point of application')
  end subroutine check_load_place

  !> Checks that bodies with motions, loads and histories exist.
  subroutine check_moves(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i, p

    do p = 1, size(state%analysis%phases)
      do i = 1, size(state%analysis%phases(p)%moves)
        associate (move => state%analysis%phases(p)%moves(i))
          call check_name(state, move%body, state%analysis%rigid_bodies, move%where, &
            trim(merge('LOAD', 'MOVE', move%is_load)), 'rigid body')
          if (any(move%placed) .and. .not. may_turn(state%analysis%phases(:p), move%body)) &
            call state%error_from(move%where, 'LOAD', "the place in which the force acts does not matter: body '"// &
            move%body//"' may not turn; *LOAD, COMPONENT=MZ with 0 frees it")
        end associate
      end do
    end do
    associate (moving => state%analysis%moving_mesh)
      if (moving%by_body) call check_name(state, moving%body, state%analysis%rigid_bodies, moving%where, &
        'MOVING MESH', 'rigid body')
    end associate
    call check_moved_and_loaded(state)
  end subroutine check_moves

  !> Checks whether a moment, possibly 0, acts on a body in a phase and frees its rotation.
  pure logical function may_turn(phases, body)
    type(phase_type), intent(in) :: phases(:)
    character(len=*), intent(in) :: body
    integer :: p, i

    may_turn = .false.
    do p = 1, size(phases)
      do i = 1, size(phases(p)%moves)
        associate (other => phases(p)%moves(i))
          may_turn = may_turn .or. (other%is_load .and. other%component == turning .and. other%body == body)
        end associate
      end do
    end do
  end function may_turn

  !> Checks that a component of a body is not both moved and loaded in one phase.
  subroutine check_moved_and_loaded(state)
    type(deck_state_type), intent(inout) :: state
    real(wp) :: motion(4)
    integer :: p, i, j

    do p = 1, size(state%analysis%phases)
      associate (moves => state%analysis%phases(p)%moves)
        do i = 1, size(moves)
          if (.not. moves(i)%is_load) cycle
          do j = 1, size(moves)
            if (moves(j)%is_load .or. moves(j)%body /= moves(i)%body) cycle
            motion = [moves(j)%vector, moves(j)%rotation(3)]
            if (abs(motion(moves(i)%component)) > 0.0_wp) call state%error_from(moves(i)%where, 'LOAD', &
              "body '"//moves(i)%body//"' is moved in this component in the same phase: *MOVE it with 0 there, or "// &
              'in a phase of its own')
          end do
        end do
      end associate
    end do
  end subroutine check_moved_and_loaded
end module qsmpm_deck_rigid_bodies
