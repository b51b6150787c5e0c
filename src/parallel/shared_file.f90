!> A file written jointly by the processes of a team; the calls are the same for a single process. The sections of the
!> file are allocated together; in a section the bytes of the processes are stored in the order of their ranks, and
!> each process writes its own. A failure on one process becomes the error of all when the file is committed; no
!> process waits for another before that.
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
    !> File of this process.
    type(file_type) :: file
    !> Bytes of the file without its last line.
    integer(long) :: length = 0
    !> Whether it ends with a checksum line that reveals damage (`qsmpm_checksum`).
    logical :: sealed = .false.
    !> Contribution of the bytes of this process to the checksum.
    integer(int32) :: share = 0
  end type shared_file_type

contains

  !> Creates a file, which is renamed to its final name when it is committed.
  subroutine begin_shared(shared, team, path, sealed)
    type(shared_file_type), intent(out) :: shared
    type(team_type), intent(in) :: team
    character(len=*), intent(in) :: path
    !> Whether it ends with a checksum line; all data must then be written with `put_at`.
    logical, intent(in) :: sealed
    logical :: failed

    shared%team = team
    shared%sealed = sealed
    if (team%rank == 0) call create_file(shared%file, path)
    ! The file exists when the first process has replied.
    failed = any_of(team, allocated(shared%file%reason))
    if (team%rank > 0) call join_file(shared%file, path)
  end subroutine begin_shared

  !> Returns a number of each process, on all processes (ranks).
  function of_ranks(team, number) result(numbers)
    type(team_type), intent(in) :: team
    !> Number of this process.
    integer(long), intent(in) :: number
    integer(long) :: numbers(team%ranks)

    numbers = 0
    numbers(team%rank + 1) = number
    numbers = total(team, numbers)
  end function of_ranks

  !> Allocates the sections of the file, once.
  subroutine claim(shared, counts, places)
    type(shared_file_type), intent(inout) :: shared
    !> Bytes of this process in each section (sections); position of its bytes in the file.
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

  !> Writes bytes to their allocated position.
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

  !> Synchronises the file with the disk and renames it; on failure the previous file remains.
  subroutine commit_shared(shared, error)
    type(shared_file_type), intent(inout) :: shared
    !> Set consistently on all processes when the file is not completely written under its name.
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

  !> Returns the checksum of a file from the contributions of the processes: the parity of each bit.
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

  !> Verifies the checksum of a file, each process for a piece of it.
  subroutine check_shared_seal(team, path, reason)
    type(team_type), intent(in) :: team
    character(len=*), intent(in) :: path
    !> Error found by this process; unallocated if there is none.
    character(len=:), allocatable, intent(out) :: reason
    character(len=:), allocatable :: line
    integer(int32) :: share

    call sum_piece(path, team%rank + 1, team%ranks, share, line, reason)
    share = joined_sum(team, share)
    if (.not. allocated(reason)) call seal_reason(share, line, reason)
  end subroutine check_shared_seal
end module qsmpm_shared_file
