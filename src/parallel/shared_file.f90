!> A file that the processes of a team write together: one file, the same call alone. They claim its stretches in one
!> go; in a stretch the bytes of all stand behind one another in the order of their ranks, and each writes its own. What
!> cannot be written on one process is the error of all when the file is committed; none waits for another before.
module qsmpm_shared_file
  use, intrinsic :: iso_c_binding, only: c_loc
  use, intrinsic :: iso_fortran_env, only: int8, int32
  use qsmpm_kinds, only: long
  use qsmpm_agreement, only: agree, any_of
  use qsmpm_checksum, only: crc32, followed_by, seal_line, sum_piece, seal_reason
  use qsmpm_error, only: error_type
  use qsmpm_file, only: file_type, create_file, join_file, move_to, put_bytes, put_text, finish_file, commit_file, &
    discard_file
  use qsmpm_team, only: team_type, total
  implicit none
  private

  public :: shared_file_type, begin_shared, claim, put_at, commit_shared, check_shared_seal, of_ranks

  type :: shared_file_type
    type(team_type) :: team
    !> Where this process writes.
    type(file_type) :: file
    !> Bytes of the file, but for its last line.
    integer(long) :: length = 0
    !> It ends with a line by which damage is known (`qsmpm_checksum`).
    logical :: sealed = .false.
    !> What the own bytes have added to its checksum.
    integer(int32) :: share = 0
  end type shared_file_type

contains

  !> Begin a file, which gets its name when it is committed.
  subroutine begin_shared(shared, team, path, sealed)
    type(shared_file_type), intent(out) :: shared
    type(team_type), intent(in) :: team
    character(len=*), intent(in) :: path
    !> It is to end with a line by which damage is known; all of it is put with `put_at`.
    logical, intent(in) :: sealed
    logical :: failed

    shared%team = team
    shared%sealed = sealed
    if (team%rank == 0) call create_file(shared%file, path)
    ! The file is there when the first process has answered.
    failed = any_of(team, allocated(shared%file%reason))
    if (team%rank > 0) call join_file(shared%file, path)
  end subroutine begin_shared

  !> A number of each process, known to all (ranks).
  function of_ranks(team, number) result(numbers)
    type(team_type), intent(in) :: team
    !> Of this one.
    integer(long), intent(in) :: number
    integer(long) :: numbers(team%ranks)

    numbers = 0
    numbers(team%rank + 1) = number
    numbers = total(team, numbers)
  end function of_ranks

  !> Claim the stretches of the file, once.
  subroutine claim(shared, counts, places)
    type(shared_file_type), intent(inout) :: shared
    !> Bytes of this process in each (stretches), and how many stand before them in the file.
    integer(long), intent(in) :: counts(:)
    integer(long), intent(out) :: places(:)
    integer(long) :: parts(shared%team%ranks, size(counts))
    integer :: i

    parts = 0
    parts(shared%team%rank + 1, :) = counts
    parts = reshape(total(shared%team, reshape(parts, [size(parts)])), shape(parts))
    do i = 1, size(counts)
      places(i) = shared%length + sum(parts(:shared%team%rank, i))
      shared%length = shared%length + sum(parts(:, i))
    end do
  end subroutine claim

  !> Put bytes where they have been claimed.
  subroutine put_at(shared, place, bytes)
    type(shared_file_type), intent(inout) :: shared
    integer(long), intent(in) :: place
    integer(int8), contiguous, target, intent(in) :: bytes(:)

    associate (count => size(bytes, kind=long))
      if (count == 0) return
      call move_to(shared%file, place)
      call put_bytes(shared%file, c_loc(bytes), count)
      if (shared%sealed) shared%share = ieor(shared%share, followed_by(crc32(bytes), shared%length - place - count))
    end associate
  end subroutine put_at

  !> Bring the file to the disk and give it its name; on failure the former file stays.
  subroutine commit_shared(shared, error)
    type(shared_file_type), intent(inout) :: shared
    !> The same on all processes: the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    integer(int32) :: sum

    if (shared%sealed) then
      sum = joined_sum(shared%team, shared%share)
      call move_to(shared%file, shared%length)
      if (shared%team%rank == 0) call put_text(shared%file, seal_line(sum))
    end if
    call finish_file(shared%file, error)
    call agree(shared%team, error)
    if (allocated(error)) then
      call discard_file(shared%file)
    else
      if (shared%team%rank == 0) call commit_file(shared%file, error)
      call agree(shared%team, error)
    end if
  end subroutine commit_shared

  !> The checksum of a file from what the processes have added to it: the parity of each bit.
  integer(int32) function joined_sum(team, share) result(joined)
    type(team_type), intent(in) :: team
    integer(int32), intent(in) :: share
    integer(long) :: bits(0:31)
    integer :: i

    bits = total(team, [(merge(1_long, 0_long, btest(share, i)), i=0, 31)])
    joined = 0
    do i = 0, 31
      if (mod(bits(i), 2_long) == 1) joined = ibset(joined, i)
    end do
  end function joined_sum

  !> Compare a file with its last line, each process a piece of it.
  subroutine check_shared_seal(team, path, reason)
    type(team_type), intent(in) :: team
    character(len=*), intent(in) :: path
    !> What this process finds wrong with it; not allocated when nothing is.
    character(len=:), allocatable, intent(out) :: reason
    character(len=:), allocatable :: line
    integer(int32) :: share

    call sum_piece(path, team%rank + 1, team%ranks, share, line, reason)
    share = joined_sum(team, share)
    if (.not. allocated(reason)) call seal_reason(share, line, reason)
  end subroutine check_shared_seal
end module qsmpm_shared_file
