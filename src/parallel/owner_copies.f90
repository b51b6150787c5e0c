!> Values of others: of things that a process has numbered, cells or nodes, some are its own, some another's. Each has
!> a name that is the same on all processes. Which values go where is listed once; each exchange then brings the values
!> that the owners have to those who ask for them. Every process must take part. Alone nothing is sent.
!>
!> Which things there are, and whose they are, is left to others.
module qsmpm_owner_copies
  use qsmpm_kinds, only: wp, long
  use qsmpm_sorting, only: order_columns, place_in_order
  use qsmpm_team, only: team_type, hand_over
  implicit none
  private

  public :: owner_copies_type, list_copies, copy_values

  type :: owner_copies_type
    !> Own things whose values go to the ranks, 0 for one that is not here, and where those of each begin (ranks + 1).
    integer, allocatable :: given(:), first_given(:)
    !> Things whose values come, by the ranks that own them.
    integer, allocatable :: taken(:)
  end type owner_copies_type

contains

  !> List what goes where.
  subroutine list_copies(team, names, owner, copies)
    type(team_type), intent(in) :: team
    !> Names of the things and the ranks that own them, -1 for one that is not asked for (things).
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

  !> Put what the owners have in the place of what is here; 0 where an owner has not got the thing.
  subroutine copy_values(team, copies, values)
    type(team_type), intent(in) :: team
    type(owner_copies_type), intent(in) :: copies
    !> (components, things)
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
