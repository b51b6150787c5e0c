!> Files in parts: each process of a team writes the rows that are its own to a file in `parts`, and the first one an
!> index under the name that the file of one process has, in which every dataset is the rows of all parts behind one
!> another (qsmpm_hdf5_joined). An index is written when all parts are on the disk.
module qsmpm_part_files
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: agree
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_exchange, only: collect
  use qsmpm_file, only: file_exists
  use qsmpm_hdf5_image, only: image_type, dataset_type, save_image
  use qsmpm_hdf5_joined, only: put_joined
  use qsmpm_number_text, only: integer_text
  use qsmpm_posix, only: remove_file
  use qsmpm_team, only: team_type, total
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: part_name, save_parts, join_rows, remove_parts, rows_before

  !> Folder of the parts, in that of the run.
  character(len=*), parameter, public :: parts_folder = 'parts'

contains

  !> Name of the part of a process, in the folder of the run.
  pure function part_name(name, rank, ending) result(path)
    !> What it is a part of, without its ending.
    character(len=*), intent(in) :: name
    integer, intent(in) :: rank
    character(len=*), intent(in) :: ending
    character(len=:), allocatable :: path

    path = parts_folder//'/'//name//'_'//integer_text(rank + 1)//ending
  end function part_name

  !> Write the parts of an HDF5 file and name their rows in its index, which the first process is to write.
  subroutine save_parts(team, part, directory, name, above, index, error)
    type(team_type), intent(in) :: team
    !> Of this process.
    type(image_type), intent(inout) :: part
    !> Of the run.
    character(len=*), intent(in) :: directory
    !> Of the parts, and the way from the folder of the index to that of the run.
    character(len=*), intent(in) :: name, above
    type(image_type), intent(inout) :: index
    !> The same on all processes: a part is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    type(string_type) :: files(team%ranks)
    type(dataset_type) :: datasets(part%count)
    integer :: r

    datasets = part%datasets(:part%count)
    call save_image(part, directory//'/'//part_name(name, team%rank, '.h5'), error)
    call agree(team, error)
    if (allocated(error)) return
    do r = 1, team%ranks
      files(r)%text = above//part_name(name, r - 1, '.h5')
    end do
    call join_rows(team, datasets, files, index, .true., error)
    if (team%rank == 0) call remove_parts(directory, name, team%ranks, '.h5')
  end subroutine save_parts

  !> Put the datasets of all parts in an index, that of the first process.
  subroutine join_rows(team, datasets, files, index, drops, error)
    type(team_type), intent(in) :: team
    !> Those of the part of this process; all parts have the same, with different rows.
    type(dataset_type), intent(in) :: datasets(:)
    !> The parts, as the index sees them (ranks).
    type(string_type), intent(in) :: files(:)
    type(image_type), intent(inout) :: index
    !> A dataset of which no part has a row is left out, where others of its group have.
    logical, intent(in) :: drops
    !> The same on all processes.
    type(error_type), allocatable, intent(out) :: error
    integer(long) :: mine(size(datasets))
    integer(long), allocatable :: rows(:)
    integer, allocatable :: first(:)
    integer :: i

    do i = 1, size(datasets)
      mine(i) = datasets(i)%dimensions(size(datasets(i)%dimensions))
    end do
    call collect(team, mine, rows, first)
    if (team%rank == 0) then
      if (any(first(2:) - first(:team%ranks) /= size(datasets))) &
        call fail(error, error_other, 'the processes have written different datasets')
    end if
    call agree(team, error)
    if (allocated(error) .or. team%rank > 0) return
    do i = 1, size(datasets)
      associate (of_parts => rows(i::size(datasets)))
        if (drops .and. all(of_parts == 0) .and. has_rows(datasets, rows, i)) cycle
        call put_joined(index, datasets(i), files, of_parts)
      end associate
    end do
  end subroutine join_rows

  !> Whether some part has rows of a dataset of the same group.
  pure logical function has_rows(datasets, rows, number)
    type(dataset_type), intent(in) :: datasets(:)
    !> Of all parts behind one another.
    integer(long), intent(in) :: rows(:)
    integer, intent(in) :: number
    integer :: i, slash

    slash = index(datasets(number)%path, '/', back=.true.)
    has_rows = .false.
    do i = 1, size(datasets)
      if (index(datasets(i)%path, '/', back=.true.) /= slash) cycle
      if (datasets(i)%path(:slash) == datasets(number)%path(:slash)) has_rows = has_rows .or. &
        any(rows(i::size(datasets)) > 0)
    end do
  end function has_rows

  !> Remove the parts that a former file of the same name has had more.
  subroutine remove_parts(directory, name, ranks, ending)
    !> Of the run.
    character(len=*), intent(in) :: directory
    character(len=*), intent(in) :: name
    !> Parts that stay.
    integer, intent(in) :: ranks
    character(len=*), intent(in) :: ending
    integer :: r, ignored

    r = ranks
    do while (file_exists(directory//'/'//part_name(name, r, ending)))
      ignored = remove_file(directory//'/'//part_name(name, r, ending))
      r = r + 1
    end do
  end subroutine remove_parts

  !> Rows of the processes before this one.
  integer function rows_before(team, rows) result(before)
    type(team_type), intent(in) :: team
    !> Of this one.
    integer, intent(in) :: rows
    real(wp) :: counts(team%ranks)

    counts = 0.0_wp
    counts(team%rank + 1) = real(rows, wp)
    counts = total(team, counts)
    before = nint(sum(counts(:team%rank)))
  end function rows_before
end module qsmpm_part_files
