!> Messages by MPI. A process whose team is itself alone sends none.
submodule (qsmpm_exchange) exchange_mpi
  use mpi_f08, only: mpi_comm, mpi_integer, mpi_integer8, mpi_allgather, mpi_gatherv, mpi_bcast, mpi_alltoall, &
    mpi_alltoallv
  implicit none

contains

  module procedure collect_longs
    if (team%ranks == 1) then
      rows = mine
      first = [1, size(mine) + 1]
      return
    end if
    call find_first(team, size(mine), first)
    allocate (rows(merge(first(team%ranks + 1) - 1, 0, team%rank == 0)))
    call mpi_gatherv(mine, size(mine), mpi_integer8, rows, first(2:) - first(:team%ranks), &
      first(:team%ranks) - 1, mpi_integer8, 0, mpi_comm(team%handle))
  end procedure collect_longs

  module procedure spread_longs
    if (team%ranks > 1) call mpi_bcast(values, size(values), mpi_integer8, rank, mpi_comm(team%handle))
  end procedure spread_longs

  module procedure hand_over_longs
    if (team%ranks == 1) then
      theirs = mine
      first_theirs = first
      return
    end if
    call find_first_theirs(team, first, first_theirs)
    allocate (theirs(first_theirs(team%ranks + 1) - 1))
    call mpi_alltoallv(mine, first(2:) - first(:team%ranks), first(:team%ranks) - 1, mpi_integer8, theirs, &
      first_theirs(2:) - first_theirs(:team%ranks), first_theirs(:team%ranks) - 1, mpi_integer8, mpi_comm(team%handle))
  end procedure hand_over_longs

  !> Where the rows of all processes begin, by the length of that of this one.
  subroutine find_first(team, length, first)
    type(team_type), intent(in) :: team
    integer, intent(in) :: length
    integer, allocatable, intent(out) :: first(:)
    integer :: lengths(team%ranks)

    call mpi_allgather(length, 1, mpi_integer, lengths, 1, mpi_integer, mpi_comm(team%handle))
    first = beginnings(lengths)
  end subroutine find_first

  !> Where the rows that come from the processes begin.
  subroutine find_first_theirs(team, first, first_theirs)
    type(team_type), intent(in) :: team
    !> Where those that go begin.
    integer, intent(in) :: first(:)
    integer, allocatable, intent(out) :: first_theirs(:)
    integer, dimension(team%ranks) :: mine, theirs

    mine = first(2:) - first(:team%ranks)
    call mpi_alltoall(mine, 1, mpi_integer, theirs, 1, mpi_integer, mpi_comm(team%handle))
    first_theirs = beginnings(theirs)
  end subroutine find_first_theirs

  !> Where rows begin that stand behind one another, and where the last one has ended.
  pure function beginnings(lengths) result(first)
    integer, intent(in) :: lengths(:)
    integer :: first(size(lengths) + 1)
    integer :: i

    first(1) = 1
    do i = 1, size(lengths)
      first(i + 1) = first(i) + lengths(i)
    end do
  end function beginnings
end submodule exchange_mpi
