!> What rigid bodies do in a phase: the cards *MOVE and *LOAD.
module qsmpm_deck_body_motion
  use qsmpm_analysis, only: axisymmetric, plane_strain
  use qsmpm_phase_description, only: phase_type
  use qsmpm_structures, only: rigid_move_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_objects, only: list_moves
  use qsmpm_deck_rigid_bodies, only: turn_fields
  use qsmpm_deck_state, only: deck_state_type, check_name
  use qsmpm_deck_words, only: bar_list, load_words
  use qsmpm_keyword_table, only: table_type, in_phase, many
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: add_move_keywords, check_moves

  !> Component of a load that is a moment about z.
  integer, parameter :: turning = 4

contains

  !> *MOVE, *LOAD.
  subroutine add_move_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('MOVE', in_phase, many, 'Motion of a rigid body in the phase, per unit of load factor; without '// &
      'the card it stays where it is.', move_fields, '*MOVE, BODY=pipe| 0, -0.5', check_move, list=list_moves, &
      opens='motion')
    call table%add('LOAD', in_phase, many, 'Force on a rigid body along one axis, or moment about z, per unit of '// &
      'load factor: there it is free from this phase on and finds its place, until *MOVE takes it in hand again. A '// &
      'body that was held starts from what the soil pushes.', load_fields, '*LOAD, BODY=plate, COMPONENT=Y| -50|'// &
      '*LOAD, BODY=plate, COMPONENT=MZ| 0', check_body_load, list=list_moves, opens='force on a rigid body')
  end subroutine add_move_keywords

  !> *MOVE.
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
        'counter-clockwise; in 3D rx, ry, rz say it', given=plane)
      call fields%data('displacement')
      call fields%number('ux', move%vector(1), 'component')
      call fields%number('uy', move%vector(2), 'component')
      call fields%number('uz', move%vector(3), 'component', third=.true.)
      call turn_fields(fields, move%rotation, 'its reference point')
    end associate
  end subroutine move_fields

  !> A body has one motion in a phase.
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

  !> *LOAD.
  subroutine load_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (move => deck%analysis%phases(deck%phase)%moves(deck%item))
      call fields%given(move%is_load)
      call fields%line(move%where)
      call fields%name('BODY', move%body, 'the rigid body', required=.true.)
      call fields%choice('COMPONENT', move%component, bar_list(load_words), 'axis of a force; MZ: moment about the '// &
        'reference point of the body (plane strain), also 0, so that it may turn', required=.true.)
      call fields%data('force')
      call fields%number('force', move%load, 'on the body, or moment; in axisymmetry per radian')
      call fields%number('x', move%place(1), 'place of the body, as drawn, in which the force acts and '// &
        'with which it turns; its reference point (centre, tip) when not given', required=.false., given=move%placed(1))
      call fields%number('y', move%place(2), 'coordinate', required=.false., given=move%placed(2))
    end associate
  end subroutine load_fields

  !> A component is loaded once, and not moved as well.
  subroutine check_body_load(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i, n

    associate (moves => state%analysis%phases(state%phase)%moves)
      n = size(moves)
      if (moves(n)%component == 3 .and. state%dimension == 2) call state%report_error('COMPONENT=Z is for 3D')
      if (moves(n)%component == turning .and. state%analysis%model &
        /= plane_strain) call state%report_error('COMPONENT=MZ is for plane strain: elsewhere bodies turn by '// &
        '*MOVE alone')
      call check_load_place(state, moves(n))
      if (state%analysis%model == axisymmetric .and. moves(n)%component &
        == 1) call state%report_error('in axisymmetry a body is free along the axis alone: COMPONENT=Y')
      do i = 1, n - 1
        if (moves(i)%is_load .and. moves(i)%body == moves(n)%body .and. moves(i)%component &
          == moves(n)%component) call state%report_error("body '"//moves(n)%body//"' has a load in this component "// &
          "in this phase already")
      end do
    end associate
  end subroutine check_body_load

  !> A place in which a force acts is whole, and that of a force.
  subroutine check_load_place(state, load)
    type(deck_state_type), intent(inout) :: state
    type(rigid_move_type), intent(in) :: load

    if (.not. any(load%placed)) return
    if (.not. all(load%placed)) call state%report_error('the place in which the force acts wants x and y')
    if (load%component == turning) call state%report_error('a moment acts in no place: it is the force that does')
  end subroutine check_load_place

  !> Bodies that are moved, loaded and followed exist.
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

  !> Whether a moment acts on a body in a phase, and be it 0, and frees it to turn.
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

  !> A body is moved or loaded in a component, not both in one phase.
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
end module qsmpm_deck_body_motion
