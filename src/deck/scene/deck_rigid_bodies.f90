!> The card of rigid bodies, *RIGID BODY: what shapes are drawn by. Contacts: qsmpm_deck_contact; motions and loads:
!> qsmpm_deck_body_motion.
module qsmpm_deck_rigid_bodies
  use qsmpm_analysis, only: plane_strain
  use qsmpm_structures, only: rigid_body_type, rigid_plane, rigid_circle, rigid_box, rigid_polygon, rigid_cylinder
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_bodies, only: polygon_fields, finish_polygon
  use qsmpm_deck_objects, only: list_rigid_bodies
  use qsmpm_deck_sets, only: box_fields, check_box
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_deck_words, only: bar_list, rigid_words
  use qsmpm_keyword_table, only: table_type, in_model, many
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: upper
  implicit none
  private

  public :: add_rigid_body_keywords, turn_fields


contains

  !> *RIGID BODY.
  subroutine add_rigid_body_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('RIGID BODY', in_model, many, 'A body that does not deform: a plate, pipe, cone, wall. *CONTACT '// &
      'says which surface of the soil may touch it, *MOVE how it moves.', rigid_body_fields, &
      '*RIGID BODY, NAME=pipe, SHAPE=CIRCLE| 0, 1.25, 0.25', finish_rigid_body, list=list_rigid_bodies, &
      opens='rigid body')
  end subroutine add_rigid_body_keywords

  !> *RIGID BODY.
  subroutine rigid_body_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (body => deck%analysis%rigid_bodies(deck%item))
      call fields%line(body%where)
      call fields%name('NAME', body%name, 'name of the body', required=.true.)
      if (fields%reading) body%shape = 0
      call fields%choice('SHAPE', body%shape, bar_list(rigid_words), 'PLANE: all behind a plane. CIRCLE: in '// &
        'axisymmetry and 3D a sphere. CONE: tip downwards, with a shaft above. POLYGON: in axisymmetry with an '// &
        'edge on the axis, in 3D all along z. CYLINDER: upright, in axisymmetry and 3D', required=.true.)
      call fields%number('ROUND', body%round, 'radius of the corners of BOX, CONE, POLYGON and CYLINDER; a quarter '// &
        'of a cell when not given', range='(0, inf)')
      call fields%answer('IN PLACE', body%in_place, 'YES: what is drawn of the soil inside of it is taken out '// &
        'before the first step; in plane strain and axisymmetry')
      call place_fields(fields, body, 'plane', 'a point of the plane')
      call fields%number('nx', body%direction(1), 'direction in which it looks at the soil')
      call fields%number('ny', body%direction(2), 'direction')
      call fields%number('nz', body%direction(3), 'direction', third=.true.)
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

  !> The data line of a shape, which begins with a place.
  subroutine place_fields(fields, body, shape, what)
    class(card_fields_type), intent(inout) :: fields
    type(rigid_body_type), intent(inout) :: body
    !> Word of SHAPE in small letters, and what is at the place.
    character(len=*), intent(in) :: shape, what

    call fields%data(shape, when='SHAPE='//upper(shape))
    call fields%number('x', body%place(1), 'coordinate of '//what)
    call fields%number('y', body%place(2), 'coordinate')
    call fields%number('z', body%place(3), 'coordinate', third=.true.)
  end subroutine place_fields

  !> A cone.
  subroutine cone_fields(fields, body)
    class(card_fields_type), intent(inout) :: fields
    type(rigid_body_type), intent(inout) :: body

    call place_fields(fields, body, 'cone', 'the tip')
    call fields%number('radius', body%radius, 'radius of the shaft', range='(0, inf)')
    call fields%number('angle', body%apex_angle, 'angle of the tip in degrees', range='(0, 180)')
    call fields%number('shaft', body%shaft, 'length of the shaft', range='(0, inf)')
  end subroutine cone_fields

  !> A cylinder.
  subroutine cylinder_fields(fields, body)
    class(card_fields_type), intent(inout) :: fields
    type(rigid_body_type), intent(inout) :: body

    call place_fields(fields, body, 'cylinder', 'the middle of its base')
    call fields%number('radius', body%radius, 'radius', range='(0, inf)')
    call fields%number('height', body%shaft, 'from its base upwards', range='(0, inf)')
  end subroutine cylinder_fields

  !> A rotation in space.
  subroutine turn_fields(fields, rotation, about)
    class(card_fields_type), intent(inout) :: fields
    real(wp), intent(inout) :: rotation(3)
    character(len=*), intent(in) :: about

    call fields%number('rx', rotation(1), 'rotation about '//about//', axis times angle in degrees: 0, 0, 30 turns '// &
      'x to y', required=.false., third=.true.)
    call fields%number('ry', rotation(2), 'rotation', required=.false., third=.true.)
    call fields%number('rz', rotation(3), 'rotation', required=.false., third=.true.)
  end subroutine turn_fields

  !> What a shape needs is there.
  subroutine finish_rigid_body(state)
    type(deck_state_type), intent(inout) :: state

    associate (body => state%analysis%rigid_bodies(state%item))
      if (state%dimension == 3 .and. body%in_place) call state%report_error('IN PLACE is for plane strain and '// &
        'axisymmetry: in 3D draw the bodies of soil without it')
      if (state%analysis%model == plane_strain .and. body%shape &
        == rigid_cylinder) call state%report_error('CYLINDER is for axisymmetry and 3D; in plane strain draw a BOX '// &
        'or a CIRCLE')
      if (state%card%has('ROUND') .and. any(body%shape == [rigid_plane, &
        rigid_circle])) call state%report_error('ROUND is for the corners of BOX, CONE, POLYGON and CYLINDER')
      select case (body%shape)
      case (rigid_plane)
        if (state%card%is_right() .and. .not. norm2(body%direction) > 0.0_wp) call state%report_error('the plane '// &
          'looks in no direction: nx, ny are 0')
      case (rigid_box)
        call check_box(.true., body%box, state)
      case (rigid_polygon)
        call finish_polygon(body%polygon, state)
      end select
    end associate
  end subroutine finish_rigid_body
end module qsmpm_deck_rigid_bodies
