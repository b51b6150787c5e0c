!> The material point nearest to a place, where a team shares the points: of several at the same distance the one with
!> the lowest number, as of one process.
module qsmpm_nearest_of_team
  use qsmpm_kinds, only: wp, long
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: own_of
  use qsmpm_point_bins, only: point_bins_type, make_bins, nearest_in_bins
  use qsmpm_team, only: smallest
  implicit none
  private

  public :: nearest_numbers, place_of_number

contains

  !> Numbers of the points nearest to places, of a body or of all.
  function nearest_numbers(model, places, body) result(numbers)
    type(model_type), intent(in) :: model
    !> (dimension, n)
    real(wp), intent(in) :: places(:, :)
    !> Number of the body, of all when absent or 0.
    integer, intent(in), optional :: body
    integer(long) :: numbers(size(places, 2))
    real(wp), dimension(size(places, 2)) :: distance, least, candidate
    type(point_bins_type) :: bins
    integer, allocatable :: own(:)
    logical :: looked_at(model%state%points%count)
    real(wp), allocatable :: there(:, :)
    integer :: i, p

    associate (points => model%state%points)
      looked_at = own_of(model%part%points, points%count)
      if (present(body)) looked_at = looked_at .and. (body == 0 .or. points%body(:points%count) == body)
      own = pack([(p, p=1, points%count)], looked_at)
      distance = huge(1.0_wp)
      candidate = huge(1.0_wp)
      if (size(own) > 0) then
        there = points%position(:, own)
        call make_bins(there, bins)
        do i = 1, size(places, 2)
          p = own(nearest_in_bins(bins, there, places(:, i)))
          distance(i) = sum((points%position(:, p) - places(:, i))**2)
          candidate(i) = real(points%number(p), wp)
        end do
      end if
      least = smallest(model%part%team, distance)
      where (distance > least) candidate = huge(1.0_wp)
      numbers = nint(smallest(model%part%team, candidate), long)
    end associate
  end function nearest_numbers

  !> Place of an own point by its number, 0 where it is another process's.
  pure integer function place_of_number(model, number) result(place)
    type(model_type), intent(in) :: model
    integer(long), intent(in) :: number

    associate (points => model%state%points)
      place = findloc(points%number == number .and. own_of(model%part%points, points%count), .true., dim=1)
    end associate
  end function place_of_number
end module qsmpm_nearest_of_team
