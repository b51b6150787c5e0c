!> The interface to mesh files.
module qsmpm_mesh_readers
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_from_labels, only: mesh_from_labels
  use qsmpm_gmsh_content, only: gmsh_file_type
  use qsmpm_gmsh_reader, only: read_gmsh
  use qsmpm_abaqus_cards, only: abaqus_file_type
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
    type(gmsh_file_type) :: gmsh
    type(abaqus_file_type) :: abaqus

    select case (format)
    case ('GMSH')
      call read_gmsh(path, gmsh)
      call mesh_from_labels(gmsh, mesh, error)
    case ('ABAQUS')
      call read_abaqus(path, abaqus)
      call mesh_from_labels(abaqus, mesh, error)
    case default
      call fail(error, error_deck, 'mesh format '//format//' is not known (GMSH, ABAQUS)')
    end select
  end subroutine read_mesh
end module qsmpm_mesh_readers
