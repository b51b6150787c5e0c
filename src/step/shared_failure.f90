!> A trial displacement that one process of a team cannot evaluate is one that none can: what the lowest rank says of it
!> is the reason of all, and the step to be tried next is the shortest that any asks for.
module qsmpm_shared_failure
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: lowest_rank, spread_text
  use qsmpm_exchange, only: spread_from
  use qsmpm_team, only: team_type, smallest
  use qsmpm_term, only: failure_type
  implicit none
  private

  public :: agree_on_failure

contains

  !> The failure of the lowest rank that has one is that of all.
  subroutine agree_on_failure(team, failure)
    type(team_type), intent(in) :: team
    type(failure_type), intent(inout) :: failure
    character(len=:), allocatable :: reason
    integer(long) :: figures(2)
    real(wp) :: share
    integer :: rank

    if (team%ranks == 1) return
    rank = lowest_rank(team, failure%failed)
    if (rank == team%ranks) return
    share = huge(share)
    if (failure%failed .and. failure%share > 0.0_wp) share = failure%share
    share = smallest(team, share)
    figures = [merge(1, 0, failure%unrecoverable), failure%cause]
    reason = ''
    if (allocated(failure%reason)) reason = failure%reason
    call spread_from(team, rank, figures)
    call spread_text(team, rank, reason)
    failure = failure_type(failed=.true., unrecoverable=figures(1) == 1, cause=int(figures(2)))
    if (share < huge(share)) failure%share = share
    if (len(reason) > 0) failure%reason = reason
  end subroutine agree_on_failure
end module qsmpm_shared_failure
