!> Interface to mesh files and to meshes defined in the deck.
!>
!> A mesh in the deck has one element kind; its nodes and elements are given by label. Repeated labels and unknown nodes
!> are errors; nodes without an element are removed (`qsmpm_mesh_from_labels`).
module qsmpm_mesh_readers
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_from_labels, only: mesh_from_labels
  use qsmpm_gmsh_content, only: gmsh_file_type
  use qsmpm_gmsh_reader, only: read_gmsh
  use qsmpm_abaqus_cards, only: abaqus_file_type
  use qsmpm_abaqus_reader, only: read_abaqus
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: node_count, element_name
  use qsmpm_raw_mesh, only: raw_mesh_type, start_raw, add_node, add_cell
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: read_mesh, inline_mesh

contains

  !> Reads a mesh file.
  subroutine read_mesh(path, format, mesh, error)
    character(len=*), intent(in) :: path
    !> GMSH or ABAQUS.
    character(len=*), intent(in) :: format
    type(mesh_type), intent(out) :: mesh
    !> Error message with path and line.
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

  !> Builds a mesh of one element kind from labels and coordinates.
  subroutine inline_mesh(kind, node_labels, nodes, element_labels, connectivity, mesh, error)
    !> Element kind.
    integer, intent(in) :: kind
    integer, intent(in) :: node_labels(:)
    !> Their coordinates (3, nodes); z is ignored in 2D.
    real(wp), intent(in) :: nodes(:, :)
    integer, intent(in) :: element_labels(:)
    !> Node labels (nodes per element, elements).
    integer, intent(in) :: connectivity(:, :)
    !> The mesh without neighbour tables.
    type(mesh_type), intent(out) :: mesh
    !> Repeated or unknown labels, no elements, a wrong number of nodes.
    type(error_type), allocatable, intent(out) :: error
    type(raw_mesh_type) :: raw
    integer :: i

    if (size(connectivity, 1) /= node_count(kind) .and. size(element_labels) > 0) then
      call fail(error, error_deck, 'an element '//element_name(kind)//' has '// &
        integer_text(node_count(kind))//' nodes, not '//integer_text(size(connectivity, 1)))
      return
    end if
    call start_raw(raw, size(node_labels), size(element_labels))
    do i = 1, size(node_labels)
      call add_node(raw, node_labels(i), nodes(:, i), 0)
    end do
    do i = 1, size(element_labels)
      call add_cell(raw, element_labels(i), kind, connectivity(:, i), 0)
    end do
    call mesh_from_labels(raw, mesh, error)
  end subroutine inline_mesh
end module qsmpm_mesh_readers
