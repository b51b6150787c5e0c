!> Exchange of values between owners and copies: of the items numbered by a process, such as cells or nodes, some are
!> owned by it and some by other processes. Each item has a name that is the same on all processes. The exchange lists
!> are built once; each exchange then sends the values of the owners to the processes that have copies. Every process
!> must take part. A single process sends nothing.
!>
!> The items and their owners are determined elsewhere.
module qsmpm_owner_copies
  use qsmpm_kinds, only: wp, long
  use qsmpm_sorting, only: order_columns, place_in_order
  use qsmpm_team, only: team_type, hand_over
  implicit none
  private

  public :: owner_copies_type, list_copies, copy_values

  type :: owner_copies_type
    !> Owned items whose values are sent to the ranks, 0 for one that is not here; start of the items of each rank
    !> (ranks + 1).
    integer, allocatable :: given(:), first_given(:)
    !> Items whose values are received, in the order of the ranks that own them.
    integer, allocatable :: taken(:)
  end type owner_copies_type

contains

  !> Builds the exchange lists.
  subroutine list_copies(team, names, owner, copies)
    type(team_type), intent(in) :: team
    !> Names of the items; ranks that own them, -1 for an item that is not requested (items).
    integer, intent(in) :: names(:), owner(:)
    type(owner_copies_type), intent(out) :: copies
    integer(long), allocatable :: asked(:)
    integer, allocatable :: mine(:), order(:), sorted(:)
    integer :: first(team%ranks + 1), i, k, r

    allocate (copies%taken(0))
    first(1) = 1
    do r = 1, team%ranks
      if (r /= team%rank + 1) copies%taken = [copies%taken, pack([(i, i=1, size(names))], owner == r - 1)]
      first(r + 1) = size(copies%taken) + 1
    end do
    call hand_over(team, int(names(copies%taken), long), first, asked, copies%first_given)
    mine = pack([(i, i=1, size(names))], owner == team%rank)
    allocate (order(size(mine)), copies%given(size(asked)))
    call order_columns(reshape(names(mine), [1, size(mine)]), order)
    mine = mine(order)
    sorted = names(mine)
    do i = 1, size(asked)
      k = place_in_order(sorted, int(asked(i)))
      copies%given(i) = 0
      if (k > 0) copies%given(i) = mine(k)
    end do
  end subroutine list_copies

  !> Replaces the values of copies by those of the owners; 0 if an owner does not have the item.
  subroutine copy_values(team, copies, values)
    type(team_type), intent(in) :: team
    type(owner_copies_type), intent(in) :: copies
    !> (components, items)
    real(wp), intent(inout) :: values(:, :)
    real(wp), allocatable :: sent(:, :), got(:)
    integer, allocatable :: first(:)
    integer :: i, n

    if (team%ranks == 1) return
    n = size(values, 1)
    allocate (sent(n, size(copies%given)), source=0.0_wp)
    do i = 1, size(sent, 2)
      if (copies%given(i) > 0) sent(:, i) = values(:, copies%given(i))
    end do
    call hand_over(team, reshape(sent, [size(sent)]), n*(copies%first_given - 1) + 1, got, first)
    values(:, copies%taken) = reshape(got, [n, size(copies%taken)])
  end subroutine copy_values
end module qsmpm_owner_copies
