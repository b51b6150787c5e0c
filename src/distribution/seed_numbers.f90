!> Numbers of seeds that the processes of a team find together: each process finds those near it, in the order of their
!> keys; a seed belongs to one process, and the seeds of one key to the same one. The numbers are those that one process
!> gives, which finds all of them.
module qsmpm_seed_numbers
  use qsmpm_kinds, only: long
  use qsmpm_exchange, only: hand_over
  use qsmpm_sorting, only: order_columns, rises
  use qsmpm_team, only: team_type
  implicit none
  private

  public :: number_jointly

contains

  !> Number seeds; all processes at once.
  subroutine number_jointly(team, key, own, number, all_keys)
    type(team_type), intent(in) :: team
    !> Rising; which of the seeds are this process's own (seeds).
    integer, intent(in) :: key(:, :)
    logical, intent(in) :: own(:)
    !> 0 for a seed whose owner has not found it (seeds).
    integer(long), intent(out) :: number(:)
    !> Keys of the seeds of all processes, rising, each once.
    integer, allocatable, intent(out) :: all_keys(:, :)
    integer(long), allocatable :: mine(:), got(:), found(:, :)
    integer(long) :: before
    integer, allocatable :: where_from(:), order(:)
    integer :: i, j, k, r

    call list_keys(key, own, mine)
    call hand_over(team, [(mine, r=1, team%ranks)], [(1 + size(mine)*r, r=0, team%ranks)], got, where_from)
    allocate (found, source=reshape(got, [size(key, 1) + 1, size(got)/(size(key, 1) + 1)]))
    allocate (order(size(found, 2)))
    call order_columns(int(found(:size(key, 1), :)), order)
    found = found(:, order)
    all_keys = int(found(:size(key, 1), :))
    number = 0
    before = 0
    i = 1
    do j = 1, size(order)
      do while (i <= size(number))
        if (.not. rises(key(:, i), all_keys(:, j))) exit
        i = i + 1
      end do
      do k = 1, int(found(size(found, 1), j))
        before = before + 1
        if (i > size(number)) cycle
        if (any(key(:, i) /= all_keys(:, j))) cycle
        number(i) = before
        i = i + 1
      end do
    end do
  end subroutine number_jointly

  !> Keys of own seeds, each followed by the number of its seeds.
  pure subroutine list_keys(key, own, list)
    integer, intent(in) :: key(:, :)
    logical, intent(in) :: own(:)
    integer(long), allocatable, intent(out) :: list(:)
    integer(long) :: found(size(key, 1) + 1, size(key, 2))
    integer :: i, n, rows

    rows = size(key, 1)
    n = 0
    do i = 1, size(own)
      if (.not. own(i)) cycle
      if (n > 0) then
        if (all(found(:rows, n) == key(:, i))) then
          found(rows + 1, n) = found(rows + 1, n) + 1
          cycle
        end if
      end if
      n = n + 1
      found(:, n) = [int(key(:, i), long), 1_long]
    end do
    allocate (list, source=reshape(found(:, :n), [(rows + 1)*n]))
  end subroutine list_keys
end module qsmpm_seed_numbers
