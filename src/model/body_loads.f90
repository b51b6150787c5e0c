!> Loads on rigid bodies: the components in which a body is free, and the force on it there.
!>
!> A component that a phase loads is free from then on; its load runs evenly over the phase from what it was, or from
!> what the soil pushes where the body was held before, to the value of the card. It stays until another phase loads it
!> otherwise or moves the body. In axisymmetry forces are per radian, as those of contact are.
module qsmpm_body_loads
  use qsmpm_kinds, only: wp
  use qsmpm_kept_arrays, only: lay_array, kept_values, keep_values
  use qsmpm_model, only: model_type
  use qsmpm_rigid_bodies, only: force_on_body
  implicit none
  private

  public :: lay_body_loads, start_body_loads, free_components, load_on_body

  character(len=*), parameter :: kept_name = 'body_loads'
  !> Rows of the array that is kept: whether free, load at the start of the phase, at its end.
  integer, parameter :: rows = 9, start_row = 4, final_row = 7

contains

  !> Lay what is kept into the state: all are held.
  subroutine lay_body_loads(model)
    type(model_type), intent(inout) :: model
    real(wp) :: none(rows, size(model%analysis%rigid_bodies))

    none = 0.0_wp
    if (size(none, 2) > 0) call lay_array(model%state%kept, kept_name, none)
  end subroutine lay_body_loads

  !> What is kept of a body.
  pure function kept_of(model, body) result(values)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    real(wp) :: values(rows), all_values(rows, size(model%analysis%rigid_bodies))

    all_values = kept_values(model%state%kept, kept_name)
    values = all_values(:, body)
  end function kept_of

  !> Loads of the model's current phase, from those of the phase before as far as it went.
  subroutine start_body_loads(model)
    !> Its load fraction is still that of the phase before.
    type(model_type), intent(inout) :: model
    real(wp) :: values(rows, size(model%analysis%rigid_bodies))
    integer :: b

    if (size(values, 2) == 0) return
    values = kept_values(model%state%kept, kept_name)
    do b = 1, size(values, 2)
      values(start_row:start_row + 2, b) = load_on_body(model, b, model%state%progress%fraction)
      values(final_row:, b) = values(start_row:start_row + 2, b)
    end do
    do b = 1, size(values, 2)
      call take_cards(model, b, values(:, b))
    end do
    call keep_values(model%state%kept, kept_name, values)
  end subroutine start_body_loads

  !> What *MOVE and *LOAD of the phase make of a body: the first takes it in hand, the second frees an axis.
  pure subroutine take_cards(model, body, values)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    !> Kept of it.
    real(wp), intent(inout) :: values(rows)
    real(wp) :: push(6)
    integer :: i

    push = force_on_body(model, body)
    associate (phase => model%analysis%phases(model%state%progress%phase))
      if (.not. allocated(phase%moves)) return
      do i = 1, size(phase%moves)
        if (phase%moves(i)%body == model%analysis%rigid_bodies(body)%name .and. .not. phase%moves(i)%is_load) &
          values(:3) = 0.0_wp
      end do
      do i = 1, size(phase%moves)
        associate (move => phase%moves(i), c => phase%moves(i)%component)
          if (move%body /= model%analysis%rigid_bodies(body)%name .or. .not. move%is_load) cycle
          values(c) = 1.0_wp
          if (.not. was_free(model, body, c)) values(start_row + c - 1) = -push(c)
          values(final_row + c - 1) = phase%load_factor*move%load
        end associate
      end do
    end associate
  end subroutine take_cards

  !> Whether a component was free so far.
  pure logical function was_free(model, body, component)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body, component
    real(wp) :: values(rows)

    values = kept_of(model, body)
    was_free = values(component) > 0.0_wp
  end function was_free

  !> Components in which a body is free.
  pure function free_components(model, body) result(free)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    logical :: free(3)
    real(wp) :: values(rows)

    values = kept_of(model, body)
    free = values(:3) > 0.0_wp
  end function free_components

  !> Load on a body at a fraction of the phase; 0 in components in which it is held.
  pure function load_on_body(model, body, fraction) result(load)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    real(wp), intent(in) :: fraction
    real(wp) :: load(3), values(rows)

    values = kept_of(model, body)
    load = merge(values(start_row:start_row + 2) + fraction*(values(final_row:) - values(start_row:start_row + 2)), &
      0.0_wp, values(:3) > 0.0_wp)
  end function load_on_body
end module qsmpm_body_loads
