!> The interface to mesh files.
module qsmpm_mesh_readers
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_mesh, only: mesh_type
  use qsmpm_raw_mesh, only: raw_mesh_type
  use qsmpm_mesh_from_labels, only: mesh_from_labels
  use qsmpm_gmsh_reader, only: read_gmsh
  use qsmpm_abaqus_reader, only: read_abaqus
  implicit none
  private

  public :: read_mesh

contains

  !> Read a mesh file.
  subroutine read_mesh(path, format, mesh, error)
    character(len=*), intent(in) :: path
    !> GMSH or ABAQUS.
    character(len=*), intent(in) :: format
    type(mesh_type), intent(out) :: mesh
    !> `path:line: what is wrong`.
    type(error_type), allocatable, intent(out) :: error
    type(raw_mesh_type) :: raw

    select case (format)
    case ('GMSH')
      call read_gmsh(path, raw, error)
    case ('ABAQUS')
      call read_abaqus(path, raw, error)
    case default
      call fail(error, error_deck, 'mesh format '//format//' is not known (GMSH, ABAQUS)')
    end select
    if (.not. allocated(error)) call mesh_from_labels(raw, mesh, error)
  end subroutine read_mesh
end module qsmpm_mesh_readers
