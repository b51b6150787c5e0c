!> Team of the processes started by mpirun. A program started without it is a team of one process.
submodule (qsmpm_team) team_mpi
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use mpi_f08, only: mpi_comm, mpi_comm_world, mpi_comm_self, mpi_thread_funneled, mpi_double_precision, &
    mpi_integer8, mpi_success, mpi_init_thread, mpi_finalize, mpi_initialized, mpi_finalized, mpi_comm_rank, &
    mpi_comm_size, mpi_allgather, mpi_allreduce, mpi_sum, mpi_min, mpi_integer, mpi_gatherv, mpi_bcast, mpi_alltoall, &
    mpi_alltoallv
  use qsmpm_error, only: fail, error_other
  implicit none

contains

  module procedure start_team
    integer :: provided, code

    if (is_running()) return
    call mpi_init_thread(mpi_thread_funneled, provided, code)
    if (code /= mpi_success .or. provided < mpi_thread_funneled) &
      call fail(error, error_other, 'MPI did not start')
  end procedure start_team

  module procedure end_team
    if (is_running()) call mpi_finalize()
  end procedure end_team

  module procedure team_world
    if (.not. is_running()) return
    call mpi_comm_rank(mpi_comm_world, team%rank)
    call mpi_comm_size(mpi_comm_world, team%ranks)
    team%handle = mpi_comm_world%mpi_val
  end procedure team_world

  module procedure solo_communicator
    handle = mpi_comm_self%mpi_val
  end procedure solo_communicator

  module procedure total_real
    real(wp) :: wholes(1)

    wholes = total_reals(team, [x])
    whole = wholes(1)
  end procedure total_real

  module procedure total_reals
    real(wp) :: parts(size(x), team%ranks)
    integer :: rank

    call gather(team, x, parts)
    wholes = parts(:, 1)
    do rank = 2, team%ranks
      wholes = wholes + parts(:, rank)
    end do
  end procedure total_reals

  module procedure total_long
    integer(long) :: parts(team%ranks)

    parts = x
    if (team%ranks > 1) call mpi_allgather(x, 1, mpi_integer8, parts, 1, mpi_integer8, mpi_comm(team%handle))
    whole = sum(parts)
  end procedure total_long

  ! Integer sums and extremes do not depend on the order.
  module procedure total_longs
    integer(long) :: own(size(x))

    own = x
    wholes = x
    if (team%ranks > 1) call mpi_allreduce(own, wholes, size(x), mpi_integer8, mpi_sum, mpi_comm(team%handle))
  end procedure total_longs

  module procedure largest
    real(wp) :: parts(1, team%ranks)

    call gather(team, [x], parts)
    extreme = maxval(parts)
    if (any(ieee_is_nan(parts))) extreme = sum(parts)
  end procedure largest

  module procedure smallest_real
    real(wp) :: parts(1, team%ranks)

    call gather(team, [x], parts)
    extreme = minval(parts)
    if (any(ieee_is_nan(parts))) extreme = sum(parts)
  end procedure smallest_real

  module procedure smallest_reals
    real(wp) :: own(size(x))

    own = x
    extremes = x
    if (team%ranks > 1) call mpi_allreduce(own, extremes, size(x), mpi_double_precision, mpi_min, mpi_comm(team%handle))
  end procedure smallest_reals

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

  !> Gathers the parts of all ranks, one per column.
  subroutine gather(team, x, parts)
    type(team_type), intent(in) :: team
    !> Values of this rank.
    real(wp), intent(in) :: x(:)
    real(wp), contiguous, intent(out) :: parts(:, :)
    real(wp) :: own(size(x))

    own = x
    if (team%ranks == 1) then
      parts(:, 1) = own
    else
      call mpi_allgather(own, size(own), mpi_double_precision, parts, size(own), mpi_double_precision, &
        mpi_comm(team%handle))
    end if
  end subroutine gather

  !> Returns whether MPI has been initialised and not finalised.
  logical function is_running()
    logical :: started, ended

    call mpi_initialized(started)
    call mpi_finalized(ended)
    is_running = started .and. .not. ended
  end function is_running

  !> Finds the start of the rows of all processes from the length of the row of this one.
  subroutine find_first(team, length, first)
    type(team_type), intent(in) :: team
    integer, intent(in) :: length
    integer, allocatable, intent(out) :: first(:)
    integer :: lengths(team%ranks)

    call mpi_allgather(length, 1, mpi_integer, lengths, 1, mpi_integer, mpi_comm(team%handle))
    first = beginnings(lengths)
  end subroutine find_first

  !> Finds the start of the rows received from the processes.
  subroutine find_first_theirs(team, first, first_theirs)
    type(team_type), intent(in) :: team
    !> Start of the rows sent.
    integer, intent(in) :: first(:)
    integer, allocatable, intent(out) :: first_theirs(:)
    integer, dimension(team%ranks) :: mine, theirs

    mine = first(2:) - first(:team%ranks)
    call mpi_alltoall(mine, 1, mpi_integer, theirs, 1, mpi_integer, mpi_comm(team%handle))
    first_theirs = beginnings(theirs)
  end subroutine find_first_theirs

  !> Returns the start of consecutive rows, and the end of the last one plus one.
  pure function beginnings(lengths) result(first)
    integer, intent(in) :: lengths(:)
    integer :: first(size(lengths) + 1)
    integer :: i

    first(1) = 1
    do i = 1, size(lengths)
      first(i + 1) = first(i) + lengths(i)
    end do
  end function beginnings
end submodule team_mpi
