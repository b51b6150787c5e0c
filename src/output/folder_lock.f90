!> Exclusive access of one run to a folder: `run.lock` in it is locked until the run ends in any way; a killed run
!> therefore leaves the file but not the lock.
!>
!> Also removes the files of an earlier run from the folder: numbered pictures and results, and the files of the
!> recorder.
module qsmpm_folder_lock
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_number_text, only: integer_text
  use qsmpm_posix, only: lock_file, make_directory, system_message, unlock_file, remove_file, remove_numbered
  use qsmpm_file, only: file_exists
  use qsmpm_results, only: mechanism_part, results_folder
  implicit none
  private

  public :: folder_lock_type, lock_folder, unlock_folder, make_folder, make_place

  !> A folder locked against other runs.
  type :: folder_lock_type
    private
    character(len=:), allocatable :: path
    !> Descriptor of the locked file, negative if there is none.
    integer :: descriptor = -1
  end type folder_lock_type

  integer, parameter :: has_failed = -1

  !> Beginnings of the names of pictures.
  character(len=*), parameter :: pictures(4) = [character(len=len(mechanism_part) + 7) :: 'points_', 'mesh_', &
    mechanism_part//'points_', mechanism_part//'mesh_']

contains

  !> Creates a folder if it does not exist.
  subroutine make_folder(directory, error)
    character(len=*), intent(in) :: directory
    !> Set when it cannot be created.
    type(error_type), allocatable, intent(out) :: error

    if (make_directory(directory) == 0) return
    call fail(error, error_other, "cannot make directory '"//directory//"': "//system_message())
  end subroutine make_folder

  !> Creates a folder if it does not exist and locks it against other runs.
  subroutine lock_folder(lock, directory, error)
    type(folder_lock_type), intent(out) :: lock
    character(len=*), intent(in) :: directory
    !> Set when there is no folder, or when it is locked by another run.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: holder
    integer :: process

    call make_folder(directory, error)
    if (allocated(error)) return
    lock%path = directory//'/run.lock'
    lock%descriptor = lock_file(lock%path, process)
    if (lock%descriptor >= 0) return
    if (lock%descriptor == has_failed) then
      call fail(error, error_other, "cannot lock '"//lock%path//"': "//system_message())
      return
    end if
    holder = ''
    if (process > 0) holder = ' (process '//integer_text(process)//')'
    call fail(error, error_other, 'another run'//holder//" writes into '"//directory// &
      "': wait for its end, or give another directory")
  end subroutine lock_folder

  !> Unlocks the folder; does nothing if it is not locked.
  subroutine unlock_folder(lock)
    type(folder_lock_type), intent(inout) :: lock

    if (lock%descriptor >= 0) call unlock_file(lock%path, lock%descriptor)
    lock%descriptor = -1
  end subroutine unlock_folder

  !> Removes the files of an earlier run unless this run continues it, and creates the folders of this run.
  subroutine make_place(directory, names, continued, in_results, error)
    character(len=*), intent(in) :: directory
    !> File names without a number.
    character(len=*), intent(in) :: names(:)
    logical, intent(in) :: continued
    !> Whether the run writes HDF5 results.
    logical, intent(in) :: in_results
    !> Set when a file cannot be removed or a folder cannot be created.
    type(error_type), allocatable, intent(out) :: error

    if (.not. continued) call remove_earlier_run(directory, names, error)
    if (.not. allocated(error) .and. in_results) call make_folder(directory//'/'//results_folder, error)
  end subroutine make_place

  !> Removes the files of an earlier run, so that none is mistaken for a result of this one.
  subroutine remove_earlier_run(directory, names, error)
    character(len=*), intent(in) :: directory
    !> File names without a number.
    character(len=*), intent(in) :: names(:)
    !> Set when a file cannot be removed.
    type(error_type), allocatable, intent(out) :: error
    integer :: i, status

    status = 0
    do i = 1, size(pictures)
      if (status == 0) status = remove_numbered(directory, trim(pictures(i)), '.vtu')
    end do
    if (status == 0) status = remove_numbered(directory//'/'//results_folder, '', '.h5')
    if (status == 0) status = remove_numbered(directory//'/'//results_folder, mechanism_part, '.h5')
    do i = 1, size(names)
      if (status /= 0) exit
      if (file_exists(directory//'/'//trim(names(i)))) status = remove_file(directory//'/'//trim(names(i)))
    end do
    if (status == 0) return
    call fail(error, error_other, "cannot remove the files of an earlier run from '"//directory//"': "// &
      system_message())
  end subroutine remove_earlier_run
end module qsmpm_folder_lock
