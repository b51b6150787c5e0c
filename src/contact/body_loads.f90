!> Loads on rigid bodies: the components in which a body is free, and forces and moment on it there.
!>
!> A component that a phase loads is free from then on; its load varies linearly over the phase from its former value,
!> or from the force of the soil where the body was fixed before, to the value of the keyword. It remains until another
!> phase changes the load or moves the body. A force acts at a place that moves with the body: with its arm r from the
!> reference point in the initial position and the angle a of rotation of the body its moment is
!>
!>   (R r) x F = A cos(a) - B sin(a),   A = r_x F_y - r_y F_x,   B = r_y F_y + r_x F_x
!>
!> In axisymmetry forces are per radian, as those of contact are.
module qsmpm_body_loads
  use qsmpm_kinds, only: wp
  use qsmpm_structures, only: rigid_move_type
  use qsmpm_kept_arrays, only: lay_array, kept_values, keep_values
  use qsmpm_model, only: model_type
  use qsmpm_rigid_bodies, only: force_on_body
  implicit none
  private

  public :: lay_body_loads, start_body_loads, free_components, load_on_body, moment_of, moment_by_angle

  character(len=*), parameter :: kept_name = 'body_loads'
  !> Components: three axes, and rotation about z.
  integer, parameter, public :: body_components = 4, turning = 4
  !> Rows of a load: forces and moment, A and B of the forces along x, those of the forces along y.
  integer, parameter, public :: load_rows = 8
  !> Rows of the stored array: whether free, load at the start of the phase, load at its end.
  integer, parameter :: rows = body_components + 2*load_rows, start_row = body_components, &
    final_row = start_row + load_rows

contains

  !> Allocates the stored data in the state: all bodies are fixed.
  subroutine lay_body_loads(model)
    type(model_type), intent(inout) :: model
    real(wp) :: none(rows, size(model%analysis%rigid_bodies))

    none = 0.0_wp
    if (size(none, 2) > 0) call lay_array(model%state%kept, kept_name, none)
  end subroutine lay_body_loads

  !> Returns the stored data of a body.
  pure function kept_of(model, body) result(values)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    real(wp) :: values(rows), all_values(rows, size(model%analysis%rigid_bodies))

    all_values = kept_values(model%state%kept, kept_name)
    values = all_values(:, body)
  end function kept_of

  !> Sets the loads of the current phase of the model, starting from those that the previous phase has reached.
  subroutine start_body_loads(model)
    !> Its load fraction is still that of the previous phase.
    type(model_type), intent(inout) :: model
    real(wp) :: values(rows, size(model%analysis%rigid_bodies))
    integer :: b

    if (size(values, 2) == 0) return
    values = kept_values(model%state%kept, kept_name)
    do b = 1, size(values, 2)
      values(start_row + 1:final_row, b) = load_on_body(model, b, model%state%progress%fraction)
      values(final_row + 1:, b) = values(start_row + 1:final_row, b)
    end do
    do b = 1, size(values, 2)
      call take_cards(model, b, values(:, b))
    end do
    call keep_values(model%state%kept, kept_name, values)
  end subroutine start_body_loads

  !> Applies *MOVE and *LOAD of the phase to a body: the first prescribes its motion, the second frees a component.
  pure subroutine take_cards(model, body, values)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    !> Stored data of the body.
    real(wp), intent(inout) :: values(rows)
    real(wp) :: push(6)
    integer :: i

    push = force_on_body(model, body)
    associate (phase => model%analysis%phases(model%state%progress%phase), &
        name => model%analysis%rigid_bodies(body)%name)
      if (.not. allocated(phase%moves)) return
      do i = 1, size(phase%moves)
        if (phase%moves(i)%body == name .and. .not. phase%moves(i)%is_load) values = 0.0_wp
      end do
      do i = 1, size(phase%moves)
        associate (move => phase%moves(i), c => phase%moves(i)%component)
          if (move%body /= name .or. .not. move%is_load) cycle
          ! The forces have no arms where the moment was constrained before.
          if (.not. values(c) > 0.0_wp) values(start_row + c) = -push(merge(6, c, c == turning))
          values(c) = 1.0_wp
          call take_load(move, model%rigid_shapes(body)%reference(:2), phase%load_factor, values(final_row + 1:))
        end associate
      end do
    end associate
  end subroutine take_cards

  !> Sets the load at the end of the phase from one keyword.
  pure subroutine take_load(move, reference, factor, load)
    type(rigid_move_type), intent(in) :: move
    !> Reference point of the body in the initial position; load factor of the phase.
    real(wp), intent(in) :: reference(2), factor
    real(wp), intent(inout) :: load(load_rows)
    real(wp) :: arm(2)

    arm = merge(move%place - reference, 0.0_wp, all(move%placed))
    load(move%component) = factor*move%load
    if (move%component == 1) load(5:6) = load(1)*[-arm(2), arm(1)]
    if (move%component == 2) load(7:8) = load(2)*arm
  end subroutine take_load

  !> Returns the components in which a body is free.
  pure function free_components(model, body) result(free)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    logical :: free(body_components)
    real(wp) :: values(rows)

    values = kept_of(model, body)
    free = values(:body_components) > 0.0_wp
  end function free_components

  !> Returns the load on a body at a fraction of the phase; 0 in constrained components.
  pure function load_on_body(model, body, fraction) result(load)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    real(wp), intent(in) :: fraction
    real(wp) :: load(load_rows), values(rows)

    values = kept_of(model, body)
    associate (start => values(start_row + 1:final_row), final => values(final_row + 1:))
      load = start + fraction*(final - start)
    end associate
    where (.not. values(:body_components) > 0.0_wp) load(:body_components) = 0.0_wp
  end function load_on_body

  !> Returns the moment of a load about z after a rotation of the body by an angle.
  pure real(wp) function moment_of(load, angle)
    real(wp), intent(in) :: load(load_rows), angle

    moment_of = load(turning) + (load(5) + load(7))*cos(angle) - (load(6) + load(8))*sin(angle)
  end function moment_of

  !> Returns the derivative of the moment with respect to the angle.
  pure real(wp) function moment_by_angle(load, angle)
    real(wp), intent(in) :: load(load_rows), angle

    moment_by_angle = -(load(5) + load(7))*sin(angle) - (load(6) + load(8))*cos(angle)
  end function moment_by_angle
end module qsmpm_body_loads
