!> The team: the processes (ranks) that share a run. This module declares the operations of a rank; they are
!> implemented for a single process (`alone/team_alone.f90`) or with MPI (`mpi/team_mpi.f90`), and a program is linked
!> with one of the two.
!>
!> Sums and extremes are taken over all ranks and returned on each of them; every rank must take part. The parts are
!> gathered and added in the order of the ranks, so that a sum is reproducible to the last bit for a given number of
!> ranks. A NaN is preserved.
!>
!> Rows of numbers are gathered on the first process, broadcast from one process, or exchanged between all processes; a
!> single process receives what it sends. Rows of several processes are concatenated in the order of their ranks;
!> `first` has one more entry than there are ranks. Reals are sent as integers of the same bits.
module qsmpm_team
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type
  implicit none
  private

  public :: team_type, start_team, end_team, team_world, solo_communicator, total, largest, smallest, collect, &
    spread_from, hand_over

  !> A process of a team.
  type :: team_type
    !> Rank of this process, from 0; number of ranks.
    integer :: rank = 0, ranks = 1
    !> MPI communicator as a Fortran handle; 0 for a single process.
    integer :: handle = 0
  end type team_type

  interface
    !> Joins the processes that were started together, before any other call of this module; repeated calls do nothing.
    module subroutine start_team(error)
      !> Set when message passing is not available.
      type(error_type), allocatable, intent(out) :: error
    end subroutine start_team

    !> Leaves the team; called once, before the process ends.
    module subroutine end_team()
    end subroutine end_team

    !> Returns the team of all processes started together; without `start_team` a single process.
    module type(team_type) function team_world() result(team)
    end function team_world

    !> Returns the communicator of this process alone, for libraries that require one; 0 without message passing.
    module integer function solo_communicator() result(handle)
    end function solo_communicator
  end interface

  !> Returns the sum over the ranks.
  interface total
    module real(wp) function total_real(team, x) result(whole)
      type(team_type), intent(in) :: team
      !> Part of the model of this process.
      real(wp), intent(in) :: x
    end function total_real

    module function total_reals(team, x) result(wholes)
      type(team_type), intent(in) :: team
      !> Values of this rank; the same number on all ranks.
      real(wp), intent(in) :: x(:)
      real(wp) :: wholes(size(x))
    end function total_reals

    module integer(long) function total_long(team, x) result(whole)
      type(team_type), intent(in) :: team
      !> Part of the model of this process.
      integer(long), intent(in) :: x
    end function total_long

    module function total_longs(team, x) result(wholes)
      type(team_type), intent(in) :: team
      !> Values of this rank; the same number on all ranks.
      integer(long), intent(in) :: x(:)
      integer(long) :: wholes(size(x))
    end function total_longs
  end interface total

  interface smallest
    !> Returns the smallest value of the ranks.
    module real(wp) function smallest_real(team, x) result(extreme)
      type(team_type), intent(in) :: team
      !> Value of this rank.
      real(wp), intent(in) :: x
    end function smallest_real

    !> Returns the smallest value of each of several quantities; no NaN is allowed.
    module function smallest_reals(team, x) result(extremes)
      type(team_type), intent(in) :: team
      !> Values of this rank; the same number on all ranks.
      real(wp), intent(in) :: x(:)
      real(wp) :: extremes(size(x))
    end function smallest_reals
  end interface smallest

  interface
    !> Returns the largest value of the ranks.
    module real(wp) function largest(team, x) result(extreme)
      type(team_type), intent(in) :: team
      !> Value of this rank.
      real(wp), intent(in) :: x
    end function largest
  end interface

  !> Gathers the rows of all processes on the first one; the others receive none.
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

  !> Broadcasts numbers of one process to all.
  interface spread_from
    module subroutine spread_longs(team, rank, values)
      type(team_type), intent(in) :: team
      !> Rank of the sender, from 0.
      integer, intent(in) :: rank
      !> The same number on all ranks.
      integer(long), contiguous, intent(inout) :: values(:)
    end subroutine spread_longs
    procedure :: spread_reals, spread_number
  end interface spread_from

  !> Exchanges rows between all processes (all-to-all).
  interface hand_over
    module subroutine hand_over_longs(team, mine, first, theirs, first_theirs)
      type(team_type), intent(in) :: team
      !> Rows sent to the ranks; start of each row (ranks + 1).
      integer(long), intent(in) :: mine(:)
      integer, intent(in) :: first(:)
      !> Rows received from the ranks.
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
    integer(long), allocatable :: bits(:)

    bits = transfer(values, [0_long])
    call spread_longs(team, rank, bits)
    values = transfer(bits, values)
  end subroutine spread_reals

  subroutine spread_number(team, rank, number)
    type(team_type), intent(in) :: team
    integer, intent(in) :: rank
    integer, intent(inout) :: number
    integer(long) :: values(1)

    values = number
    call spread_longs(team, rank, values)
    number = int(values(1))
  end subroutine spread_number

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
end module qsmpm_team
