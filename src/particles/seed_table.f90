!> Table of the number and the volume of the seed points of every body in every cell. A process that keeps only some of
!> the seeds obtains the data of the others from it.
!>
!> The module also numbers seeds that the processes of a team find together. Each process finds those near it, in the
!> order of their keys; a seed belongs to one process, and the seeds of one key to the same one. The numbers are those
!> of a single process that finds all seeds.
module qsmpm_seed_table
  use qsmpm_kinds, only: wp, long
  use qsmpm_seed_list, only: seed_list_type
  use qsmpm_team, only: team_type, hand_over
  use qsmpm_sorting, only: order_columns, rises
  implicit none
  private

  public :: seed_table_type, start_table, add_to_table, join_counts, held_by, holds_any, number_seeds, number_jointly

  type :: seed_table_type
    !> Number of points, and their volume (cells, bodies).
    integer, allocatable :: points(:, :)
    real(wp), allocatable :: volume(:, :)
  end type seed_table_type

contains

  !> Allocates a table without points.
  pure subroutine start_table(table, cells, bodies)
    type(seed_table_type), intent(out) :: table
    integer, intent(in) :: cells, bodies

    allocate (table%points(cells, bodies), source=0)
    allocate (table%volume(cells, bodies), source=0.0_wp)
  end subroutine start_table

  !> Adds seeds.
  pure subroutine add_to_table(list, first, table)
    type(seed_list_type), intent(in) :: list
    !> First of them in the list.
    integer, intent(in) :: first
    type(seed_table_type), intent(inout) :: table
    integer :: p

    do p = first, list%count
      associate (c => list%cell(p), b => list%body(p))
        table%points(c, b) = table%points(c, b) + 1
        table%volume(c, b) = table%volume(c, b) + list%volume(p)
      end associate
    end do
  end subroutine add_to_table

  !> Exchanges the table: every process of a team has added a body in some of the cells; all receive the whole table.
  subroutine join_counts(team, body, first, table)
    type(team_type), intent(in) :: team
    integer, intent(in) :: body
    !> First cell of each process, one after the other (ranks + 1).
    integer, intent(in) :: first(:)
    type(seed_table_type), intent(inout) :: table
    integer(long), allocatable :: points(:)
    real(wp), allocatable :: volume(:)
    integer, allocatable :: begins(:)
    integer :: n, r

    n = first(team%rank + 2) - first(team%rank + 1)
    associate (own_points => table%points(first(team%rank + 1):first(team%rank + 1) + n - 1, body), &
      own_volume => table%volume(first(team%rank + 1):first(team%rank + 1) + n - 1, body), &
      to_each => [(1 + n*r, r=0, team%ranks)])
      call hand_over(team, [(int(own_points, long), r=1, team%ranks)], to_each, points, begins)
      call hand_over(team, [(own_volume, r=1, team%ranks)], to_each, volume, begins)
    end associate
    table%points(:, body) = int(points)
    table%volume(:, body) = volume
  end subroutine join_counts

  !> Volume of the given bodies in every cell.
  pure function held_by(table, chosen) result(held)
    type(seed_table_type), intent(in) :: table
    !> (bodies)
    logical, intent(in) :: chosen(:)
    real(wp) :: held(size(table%volume, 1))
    integer :: b

    held = 0.0_wp
    do b = 1, size(chosen)
      if (chosen(b)) held = held + table%volume(:, b)
    end do
  end function held_by

  !> Which cells contain points of the given bodies.
  pure function holds_any(table, chosen) result(holds)
    type(seed_table_type), intent(in) :: table
    !> (bodies)
    logical, intent(in) :: chosen(:)
    logical :: holds(size(table%points, 1))
    integer :: b

    holds = .false.
    do b = 1, size(chosen)
      if (chosen(b)) holds = holds .or. table%points(:, b) > 0
    end do
  end function holds_any

  !> Numbers of seeds of complete cells by their positions among all seeds: body by body, cell by cell.
  pure function number_seeds(table, list) result(numbers)
    type(seed_table_type), intent(in) :: table
    type(seed_list_type), intent(in) :: list
    integer(long) :: numbers(list%count)
    integer(long) :: before
    integer :: b, c, p, k

    p = 1
    before = 0
    do b = 1, size(table%points, 2)
      do c = 1, size(table%points, 1)
        k = 0
        do while (p <= list%count)
          if (list%body(p) /= b .or. list%cell(p) /= c) exit
          k = k + 1
          numbers(p) = before + k
          p = p + 1
        end do
        before = before + table%points(c, b)
      end do
    end do
  end function number_seeds

  !> Numbers seeds; a collective call of all processes.
  subroutine number_jointly(team, key, own, number, all_keys)
    type(team_type), intent(in) :: team
    !> Keys, ascending; which of the seeds are owned by this process (seeds).
    integer, intent(in) :: key(:, :)
    logical, intent(in) :: own(:)
    !> 0 for a seed that its owner has not found (seeds).
    integer(long), intent(out) :: number(:)
    !> Keys of the seeds of all processes, ascending, without duplicates.
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

  !> Lists the keys of the owned seeds, each followed by the number of its seeds.
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
end module qsmpm_seed_table
