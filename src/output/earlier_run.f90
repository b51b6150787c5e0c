!> What an earlier run has left in a directory: numbered pictures and results, and the files of the recorder.
module qsmpm_earlier_run
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_file, only: file_exists
  use qsmpm_posix, only: remove_file, remove_numbered, system_message
  use qsmpm_results, only: mechanism_part, results_folder
  use qsmpm_safety_files, only: mechanism_mesh, mechanism_points
  implicit none
  private

  public :: remove_earlier_run

contains

  !> Remove what an earlier run left, so that nothing of it is taken for a result of this one.
  subroutine remove_earlier_run(directory, names, error)
    character(len=*), intent(in) :: directory
    !> Files without a number.
    character(len=*), intent(in) :: names(:)
    !> Set when a file cannot be removed.
    type(error_type), allocatable, intent(out) :: error
    integer :: i, status

    status = remove_numbered(directory, 'points_', '.vtu')
    if (status == 0) status = remove_numbered(directory, 'mesh_', '.vtu')
    if (status == 0) status = remove_numbered(directory, mechanism_points, '.vtu')
    if (status == 0) status = remove_numbered(directory, mechanism_mesh, '.vtu')
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
