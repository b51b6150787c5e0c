!> Transfer of material points and surface points with all their fields between the processes of a team. The sender
!> determines the destinations of a point, several processes or none. The received points are sorted by number, so that
!> sums over them do not depend on the sender. Most points remain on their process: these are copied once, and only the
!> others are packed.
module qsmpm_point_delivery
  use qsmpm_kinds, only: wp, long
  use qsmpm_field_list, only: field_list_type, field_type
  use qsmpm_point_selection, only: allocate_like, keep_chosen, copy_column
  use qsmpm_points, only: carried_type
  use qsmpm_sorting, only: order_columns
  use qsmpm_team, only: team_type, total, hand_over
  implicit none
  private

  public :: deliver_points, sort_by_number, fingerprint

contains

  !> Sends material points or surface points and receives those that others send.
  subroutine deliver_points(team, points, goes, like, got)
    type(team_type), intent(in) :: team
    class(carried_type), intent(in), target :: points
    !> Whether a point goes to a rank (ranks, points).
    logical, intent(in) :: goes(:, :)
    !> A set with the same fields on all processes, because a process may have no points.
    class(carried_type), intent(in), target :: like
    !> Resulting points, sorted by number.
    class(carried_type), intent(inout), target :: got
    class(carried_type), allocatable, target :: come
    integer(long), allocatable :: numbers(:)
    integer, allocatable :: stay(:), order(:)
    integer :: n

    call exchange(stay, numbers, n)
    allocate (come, mold=like)
    call allocate_like(like, n, come)
    call unpack_points(numbers, like, come)
    deallocate (numbers)
    order = number_order([points%number(stay), come%number])
    ! A process without points stores the same fields as the others from now on.
    call allocate_like(like, size(order), got)
    call gather_points(stay, come, order)

  contains

    !> Sends the fields of points and receives those that others send.
    subroutine exchange(stay, theirs, count)
      !> Points that remain on this process.
      integer, allocatable, intent(out) :: stay(:)
      !> Values of the points of others, in the order of `pack_points`, and number of these points.
      integer(long), allocatable, intent(out) :: theirs(:)
      integer, intent(out) :: count
      integer :: first(team%ranks + 1), each, r, p
      integer, allocatable :: their_first(:)
      logical :: leaves(size(goes, 1), size(goes, 2))

      stay = pack([(p, p=1, points%count)], goes(team%rank + 1, :))
      leaves = goes
      leaves(team%rank + 1, :) = .false.
      each = numbers_of_point(like)
      first(1) = 1
      do r = 1, team%ranks
        first(r + 1) = first(r) + sum(merge(1, 0, leaves(r, :)))
      end do
      call hand_over(team, pack_points(leaves, each), (first - 1)*each + 1, theirs, their_first)
      count = size(theirs)/each
    end subroutine exchange

    !> Packs the values of points, rank by rank, point by point; of reals their bits.
    function pack_points(goes, each) result(numbers)
      !> (ranks, points)
      logical, intent(in) :: goes(:, :)
      !> Values of a point.
      integer, intent(in) :: each
      integer(long), allocatable :: numbers(:)
      type(field_list_type) :: list, carried
      integer :: i, p, r, n, m

      allocate (numbers(each*count(goes)))
      call points%list_fields(list)
      call like%list_fields(carried)
      n = 0
      do r = 1, size(goes, 1)
        do p = 1, size(goes, 2)
          if (.not. goes(r, p)) cycle
          do i = 1, list%count
            if (carried%fields(i)%point_count() == 0) cycle
            associate (field => list%fields(i))
              m = field%component_count()
              if (associated(field%reals)) numbers(n + 1:n + m) = transfer(field%reals(:, p), [0_long])
              if (associated(field%labels)) numbers(n + 1) = field%labels(p)
              if (associated(field%numbers)) numbers(n + 1) = field%numbers(p)
              n = n + m
            end associate
          end do
        end do
      end do
    end function pack_points

    !> Combines the points that remain and the received ones in one order.
    subroutine gather_points(stay, come, order)
      !> Points that remain.
      integer, intent(in) :: stay(:)
      class(carried_type), intent(in), target :: come
      !> Positions in both sets together, those that remain first.
      integer, intent(in) :: order(:)
      type(field_list_type) :: here, others, carried, whole
      integer :: i, k

      call points%list_fields(here)
      call come%list_fields(others)
      call like%list_fields(carried)
      call got%list_fields(whole)
      do i = 1, whole%count
        if (carried%fields(i)%point_count() == 0) cycle
        do k = 1, size(order)
          if (order(k) <= size(stay)) then
            call copy_column(here%fields(i), stay(order(k)), k, whole%fields(i))
          else
            call copy_column(others%fields(i), order(k) - size(stay), k, whole%fields(i))
          end if
        end do
      end do
    end subroutine gather_points
  end subroutine deliver_points

  !> Number of values of a point.
  integer function numbers_of_point(like) result(number)
    class(carried_type), intent(in), target :: like
    type(field_list_type) :: list
    integer :: i

    number = 0
    call like%list_fields(list)
    do i = 1, list%count
      if (list%fields(i)%point_count() > 0) number = number + list%fields(i)%component_count()
    end do
  end function numbers_of_point

  !> Unpacks values into points.
  subroutine unpack_points(numbers, like, points)
    integer(long), intent(in) :: numbers(:)
    class(carried_type), intent(in), target :: like
    class(carried_type), intent(inout), target :: points
    type(field_list_type) :: list, carried
    integer :: i, p, n, m

    call points%list_fields(list)
    call like%list_fields(carried)
    n = 0
    do p = 1, points%count
      do i = 1, list%count
        if (carried%fields(i)%point_count() == 0) cycle
        associate (field => list%fields(i))
          m = field%component_count()
          if (associated(field%reals)) field%reals(:, p) = transfer(numbers(n + 1:n + m), [0.0_wp])
          if (associated(field%labels)) field%labels(p) = int(numbers(n + 1))
          if (associated(field%numbers)) field%numbers(p) = numbers(n + 1)
          n = n + m
        end associate
      end do
    end do
  end subroutine unpack_points

  !> Fingerprint of the real values of points, in two sums of their bits: it does not depend on the processes or the
  !> order of the points, and changes if a bit changes. Sums of the numbers themselves would differ by round-off.
  function fingerprint(team, points, chosen) result(sums)
    type(team_type), intent(in) :: team
    class(carried_type), intent(in), target :: points
    !> Points that are included (points).
    logical, intent(in) :: chosen(:)
    integer(long) :: sums(2)
    !> Leaves a margin for the sum over many processes.
    integer(long), parameter :: modulus = 2_long**40
    type(field_list_type) :: list
    integer(long) :: bits
    integer :: i, c, p

    sums = 0
    call points%list_fields(list)
    do i = 1, list%count
      associate (field => list%fields(i))
        if (.not. associated(field%reals) .or. field%point_count() == 0) cycle
        do p = 1, points%count
          if (.not. chosen(p)) cycle
          do c = 1, size(field%reals, 1)
            bits = transfer(field%reals(c, p), bits)
            sums = sums + [ibits(bits, 0, 32), ibits(bits, 32, 32)]
          end do
          sums = mod(sums, modulus)
        end do
      end associate
    end do
    sums = mod([total(team, sums(1)), total(team, sums(2))], modulus)
  end function fingerprint

  !> Sorts points by their numbers.
  subroutine sort_by_number(points)
    class(carried_type), intent(inout) :: points

    call keep_chosen(points, number_order(points%number))
  end subroutine sort_by_number

  !> Permutation that sorts the numbers.
  pure function number_order(numbers) result(order)
    integer(long), intent(in) :: numbers(:)
    integer :: order(size(numbers))
    integer(long), parameter :: base = 2_long**30
    integer :: halves(2, size(numbers))

    halves(1, :) = int(numbers/base)
    halves(2, :) = int(mod(numbers, base))
    call order_columns(halves, order)
  end function number_order
end module qsmpm_point_delivery
