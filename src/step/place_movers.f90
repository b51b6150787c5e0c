!> Which process of a team moves a place that all of them know of: a tracer, material before a prescribed set, a foot
!> of a body. It is the one whose cell the place is in; where the functions of that cell take no part the place goes
!> with the nearest material point (qsmpm_carried_basis), and the process moves it whose own that point is.
module qsmpm_place_movers
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: is_divided
  use qsmpm_point_location, only: activation_type
  use qsmpm_points, only: carried_type
  use qsmpm_team, only: smallest, total
  implicit none
  private

  public :: choose_movers

contains

  !> Mark as own what this process moves in the step that begins; alone all is own.
  subroutine choose_movers(model, activation)
    type(model_type), intent(inout) :: model
    type(activation_type), intent(in) :: activation

    if (.not. is_divided(model%part)) return
    call choose(model, activation, model%state%tracers, model%part%tracers)
    call choose(model, activation, model%state%watched, model%part%watched)
    call choose(model, activation, model%state%inactive%feet, model%part%feet)
  end subroutine choose_movers

  !> The same of one set of places.
  subroutine choose(model, activation, carried, own)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    class(carried_type), intent(in) :: carried
    !> In whose boxes they are (places).
    logical, intent(inout) :: own(:)
    real(wp) :: empty(carried%count), distance, least, number
    integer :: i

    if (carried%count == 0) return
    empty = 0.0_wp
    do i = 1, carried%count
      if (.not. own(i) .or. carried%cell(i) == 0) cycle
      if (.not. activation%touched(carried%cell(i))) empty(i) = 1.0_wp
    end do
    empty = total(model%part%team, empty)
    do i = 1, carried%count
      if (.not. empty(i) > 0.0_wp) cycle
      call find_nearest(model, carried, i, distance, number)
      least = smallest(model%part%team, distance)
      if (least >= huge(least)) cycle
      if (distance > least) number = huge(number)
      own(i) = number <= smallest(model%part%team, number) .and. number < huge(number)
    end do
  end subroutine choose

  !> Square of the distance of the nearest own point, and its number; huge where there is none or the place is outside
  !> of the part of the grid that this process looks at.
  subroutine find_nearest(model, carried, i, least, number)
    type(model_type), intent(in) :: model
    class(carried_type), intent(in) :: carried
    integer, intent(in) :: i
    real(wp), intent(out) :: least, number
    real(wp) :: distance
    integer :: p

    least = huge(least)
    number = huge(number)
    if (carried%cell(i) == 0) return
    associate (points => model%state%points)
      do p = 1, points%count
        if (.not. model%part%points(p)) cycle
        distance = sum((points%position(:, p) - carried%position(:, i))**2)
        if (distance >= least) cycle
        least = distance
        number = real(points%number(p), wp)
      end do
    end associate
  end subroutine find_nearest
end module qsmpm_place_movers
