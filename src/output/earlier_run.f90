!> What an earlier run has left in a directory: numbered pictures and results, and the files of the recorder.
module qsmpm_earlier_run
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_file, only: file_exists
  use qsmpm_posix, only: remove_file, remove_numbered, system_message
  use qsmpm_folder_lock, only: make_folder
  use qsmpm_results, only: mechanism_part, results_folder
  use qsmpm_safety_files, only: mechanism_mesh, mechanism_points
  implicit none
  private

  public :: make_place

  !> Heads of the names of pictures.
  character(len=*), parameter :: pictures(4) = [character(len=len(mechanism_points)) :: 'points_', 'mesh_', &
    mechanism_points, mechanism_mesh]

contains

  !> Remove what an earlier run left where this one does not continue it, and make the folders of this one.
  subroutine make_place(directory, names, continued, in_results, error)
    character(len=*), intent(in) :: directory
    !> Files without a number.
    character(len=*), intent(in) :: names(:)
    logical, intent(in) :: continued
    !> It writes HDF5 results.
    logical, intent(in) :: in_results
    !> Set when a file cannot be removed or a folder not made.
    type(error_type), allocatable, intent(out) :: error

    if (.not. continued) call remove_earlier_run(directory, names, error)
    if (.not. allocated(error) .and. in_results) call make_folder(directory//'/'//results_folder, error)
  end subroutine make_place

  !> Remove what an earlier run left, so that nothing of it is taken for a result of this one.
  subroutine remove_earlier_run(directory, names, error)
    character(len=*), intent(in) :: directory
    !> Files without a number.
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
end module qsmpm_earlier_run
