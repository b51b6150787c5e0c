!> Meshes written in the deck itself.
module qsmpm_inline_mesh
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_raw_mesh, only: raw_mesh_type, finish_mesh
  implicit none
  private

  public :: inline_mesh

contains

  !> A mesh of one element kind from labels and coordinates.
  subroutine inline_mesh(kind, node_labels, nodes, element_labels, connectivity, mesh, error)
    !> Element kind.
    integer, intent(in) :: kind
    integer, intent(in) :: node_labels(:)
    !> (3, nodes)
    real(wp), intent(in) :: nodes(:, :)
    integer, intent(in) :: element_labels(:)
    !> Node labels (nodes per element, elements).
    integer, intent(in) :: connectivity(:, :)
    !> The mesh.
    type(mesh_type), intent(out) :: mesh
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    type(raw_mesh_type) :: raw

    raw%node_count = size(node_labels)
    raw%cell_count = size(element_labels)
    raw%node_label = node_labels
    raw%nodes = nodes
    raw%cell_label = element_labels
    allocate (raw%cell_kind(raw%cell_count), source=kind)
    allocate (raw%connectivity(20, raw%cell_count), source=0)
    raw%connectivity(:size(connectivity, 1), :) = connectivity
    allocate (raw%node_sets(0), raw%cell_sets(0), raw%face_sets(0))
    call finish_mesh(raw, mesh, error)
  end subroutine inline_mesh
end module qsmpm_inline_mesh
