!> Messages between the processes of a team: rows of numbers that go to the first process, come from one process to all,
!> or from each to each. Every process must take part. Alone nothing is sent: what a process gives is what it gets.
!>
!> Rows of several processes stand behind one another in the order of their ranks; `first` has as many places as there
!> are ranks and one more. What is sent is left to others; reals travel as the whole numbers of the same bits.
module qsmpm_exchange
  use qsmpm_kinds, only: wp, long
  use qsmpm_team, only: team_type
  implicit none
  private

  public :: collect, spread_from, hand_over

  !> Rows of all processes, at the first one; the others get none.
  interface collect
    module subroutine collect_longs(team, mine, rows, first)
      type(team_type), intent(in) :: team
      integer(long), intent(in) :: mine(:)
      integer(long), allocatable, intent(out) :: rows(:)
      !> (ranks + 1)
      integer, allocatable, intent(out) :: first(:)
    end subroutine collect_longs
    procedure :: collect_reals
  end interface collect

  !> Numbers of one process to all.
  interface spread_from
    module subroutine spread_longs(team, rank, values)
      type(team_type), intent(in) :: team
      !> Whose they are, from 0.
      integer, intent(in) :: rank
      !> As many on each.
      integer(long), contiguous, intent(inout) :: values(:)
    end subroutine spread_longs
    procedure :: spread_reals
  end interface spread_from

  !> A row from each process to each.
  interface hand_over
    module subroutine hand_over_longs(team, mine, first, theirs, first_theirs)
      type(team_type), intent(in) :: team
      !> What goes to each, and where it begins (ranks + 1).
      integer(long), intent(in) :: mine(:)
      integer, intent(in) :: first(:)
      !> What comes from each.
      integer(long), allocatable, intent(out) :: theirs(:)
      integer, allocatable, intent(out) :: first_theirs(:)
    end subroutine hand_over_longs
    procedure :: hand_over_reals
  end interface hand_over

contains

  subroutine collect_reals(team, mine, rows, first)
    type(team_type), intent(in) :: team
    real(wp), intent(in) :: mine(:)
    real(wp), allocatable, intent(out) :: rows(:)
    integer, allocatable, intent(out) :: first(:)
    integer(long), allocatable :: bits(:)

    call collect_longs(team, transfer(mine, [0_long]), bits, first)
    rows = transfer(bits, [0.0_wp])
  end subroutine collect_reals

  subroutine spread_reals(team, rank, values)
    type(team_type), intent(in) :: team
    integer, intent(in) :: rank
    real(wp), intent(inout) :: values(:)
    integer(long) :: bits(size(values))

    bits = transfer(values, bits)
    call spread_longs(team, rank, bits)
    values = transfer(bits, values)
  end subroutine spread_reals

  subroutine hand_over_reals(team, mine, first, theirs, first_theirs)
    type(team_type), intent(in) :: team
    real(wp), intent(in) :: mine(:)
    integer, intent(in) :: first(:)
    real(wp), allocatable, intent(out) :: theirs(:)
    integer, allocatable, intent(out) :: first_theirs(:)
    integer(long), allocatable :: bits(:)

    call hand_over_longs(team, transfer(mine, [0_long]), first, bits, first_theirs)
    theirs = transfer(bits, [0.0_wp])
  end subroutine hand_over_reals
end module qsmpm_exchange
