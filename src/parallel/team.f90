!> The team: the processes (ranks) that share one run. Here stands what a rank may ask of it; the answers are those of a
!> process alone (`alone/team_alone.f90`) or of MPI (`mpi/team_mpi.f90`), and a program is linked with one of the two.
!>
!> Sums and extremes are over all ranks, the same on each of them, and every rank must take part. The parts are
!> gathered and added in the order of the ranks, so that a sum repeats to the last bit as long as the number of ranks is
!> the same. A value that is not a number stays one.
!>
!> Rows of numbers go to the first process, come from one process to all, or from each to each; alone nothing is sent:
!> what a process gives is what it gets. Rows of several processes stand behind one another in the order of their ranks;
!> `first` has as many places as there are ranks and one more. Reals travel as the whole numbers of the same bits.
module qsmpm_team
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type
  implicit none
  private

  public :: team_type, start_team, end_team, team_world, solo_communicator, total, largest, smallest, collect, &
    spread_from, hand_over

  !> One process of a team.
  type :: team_type
    !> Number of this process, from 0, and how many there are.
    integer :: rank = 0, ranks = 1
    !> The communicator as MPI counts it for Fortran; 0 alone.
    integer :: handle = 0
  end type team_type

  interface
    !> Join the processes that were started together, before anything else of this module; to do so again does nothing.
    module subroutine start_team(error)
      !> There is no message passing to be had.
      type(error_type), allocatable, intent(out) :: error
    end subroutine start_team

    !> Leave them; called once, before the process ends.
    module subroutine end_team()
    end subroutine end_team

    !> All processes that were started together; one that was not started by `start_team` is alone.
    module type(team_type) function team_world() result(team)
    end function team_world

    !> The communicator of this process alone, for libraries that want one; 0 where there is no message passing.
    module integer function solo_communicator() result(handle)
    end function solo_communicator
  end interface

  !> Sum over the ranks.
  interface total
    module real(wp) function total_real(team, x) result(whole)
      type(team_type), intent(in) :: team
      !> Part of this rank.
      real(wp), intent(in) :: x
    end function total_real

    module function total_reals(team, x) result(wholes)
      type(team_type), intent(in) :: team
      !> Parts of this rank, as many as those of the others.
      real(wp), intent(in) :: x(:)
      real(wp) :: wholes(size(x))
    end function total_reals

    module integer(long) function total_long(team, x) result(whole)
      type(team_type), intent(in) :: team
      !> Part of this rank.
      integer(long), intent(in) :: x
    end function total_long

    module function total_longs(team, x) result(wholes)
      type(team_type), intent(in) :: team
      !> Parts of this rank, as many as those of the others.
      integer(long), intent(in) :: x(:)
      integer(long) :: wholes(size(x))
    end function total_longs
  end interface total

  interface smallest
    !> Smallest value of the ranks.
    module real(wp) function smallest_real(team, x) result(extreme)
      type(team_type), intent(in) :: team
      !> Value of this rank.
      real(wp), intent(in) :: x
    end function smallest_real

    !> The smallest one of each of several values; all are numbers.
    module function smallest_reals(team, x) result(extremes)
      type(team_type), intent(in) :: team
      !> Values of this rank, as many as those of the others.
      real(wp), intent(in) :: x(:)
      real(wp) :: extremes(size(x))
    end function smallest_reals
  end interface smallest

  interface
    !> Largest value of the ranks.
    module real(wp) function largest(team, x) result(extreme)
      type(team_type), intent(in) :: team
      !> Value of this rank.
      real(wp), intent(in) :: x
    end function largest
  end interface

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
    integer(long), allocatable :: bits(:)

    bits = transfer(values, [0_long])
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
end module qsmpm_team
