!> Collective decisions of the processes of a team: whether a condition holds on one of them, an error, a message. If
!> several processes have an error, that of the lowest rank becomes the error of all. A single process is unaffected.
module qsmpm_agreement
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type, fail
  use qsmpm_team, only: team_type, smallest, total, spread_from
  implicit none
  private

  public :: any_of, agree, lowest_rank, spread_text, joint_norm

contains

  !> Returns whether a flag is set on any process.
  logical function any_of(team, flag)
    type(team_type), intent(in) :: team
    logical, intent(in) :: flag

    any_of = flag
    if (team%ranks > 1) any_of = lowest_rank(team, flag) < team%ranks
  end function any_of

  !> Returns the lowest rank on which a flag is set; the number of ranks if it is set on none.
  integer function lowest_rank(team, flag)
    type(team_type), intent(in) :: team
    logical, intent(in) :: flag

    lowest_rank = nint(smallest(team, real(merge(team%rank, team%ranks, flag), wp)))
  end function lowest_rank

  !> Makes the error of the lowest rank that has one the error of all.
  subroutine agree(team, error)
    type(team_type), intent(in) :: team
    type(error_type), allocatable, intent(inout) :: error
    character(len=:), allocatable :: message
    integer :: code, rank

    if (team%ranks == 1) return
    rank = lowest_rank(team, allocated(error))
    if (rank == team%ranks) return
    message = ''
    code = 0
    if (allocated(error)) then
      message = error%message
      code = error%code
    end if
    call spread_text(team, rank, message)
    call spread_from(team, rank, code)
    call fail(error, code, message)
  end subroutine agree

  !> Sends a text of one process to all.
  subroutine spread_text(team, rank, text)
    type(team_type), intent(in) :: team
    !> Rank of the sender, from 0; the text of the others is replaced.
    integer, intent(in) :: rank
    character(len=:), allocatable, intent(inout) :: text
    integer(long) :: length(1)
    integer(long), allocatable :: letters(:)
    integer :: i

    if (team%ranks == 1) return
    length = 0
    if (team%rank == rank) length = len(text)
    call spread_from(team, rank, length)
    allocate (letters(length(1)), source=0_long)
    if (team%rank == rank) letters = [(int(iachar(text(i:i)), long), i=1, len(text))]
    call spread_from(team, rank, letters)
    text = repeat(' ', int(length(1)))
    do i = 1, len(text)
      text(i:i) = achar(letters(i))
    end do
  end subroutine spread_text

  !> Returns the norm of a vector distributed over the processes, from the norms of the parts.
  real(wp) function joint_norm(team, norm)
    type(team_type), intent(in) :: team
    !> Norm of the part of this process.
    real(wp), intent(in) :: norm

    joint_norm = norm
    if (team%ranks > 1) joint_norm = sqrt(total(team, norm**2))
  end function joint_norm
end module qsmpm_agreement
