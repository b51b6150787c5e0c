!> Which process of a team owns which cells of the whole mesh, and which cells lie in how many rows around those of a
!> process: boxes of a grid (qsmpm_cell_boxes), parts of other meshes (qsmpm_cell_parts).
!>
!> Cells have their numbers in the whole mesh. Every process knows all of it.
module qsmpm_cell_owners
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  implicit none
  private

  public :: cell_owners_type

  type, abstract :: cell_owners_type
  contains
    procedure(ranks_of_cells), deferred :: of_cells
    procedure(cells_near), deferred :: near
    procedure(cells_of_nodes), deferred :: homes
  end type cell_owners_type

  abstract interface
    !> Ranks that own some cells; -1 for cell 0, which is none.
    pure function ranks_of_cells(self, cell) result(rank)
      import :: cell_owners_type
      class(cell_owners_type), intent(in) :: self
      integer, intent(in) :: cell(:)
      integer :: rank(size(cell))
    end function ranks_of_cells

    !> Which of some cells are a rank's own or lie in so many rows around these.
    pure function cells_near(self, rank, rows, cell) result(near)
      import :: cell_owners_type
      class(cell_owners_type), intent(in) :: self
      integer, intent(in) :: rank, rows, cell(:)
      logical :: near(size(cell))
    end function cells_near

    !> Cells that nodes belong to: each node to one of those around it, whatever part of the mesh is looked at.
    pure function cells_of_nodes(self, mesh, places) result(cell)
      import :: cell_owners_type, mesh_type, wp
      class(cell_owners_type), intent(in) :: self
      type(mesh_type), intent(in) :: mesh
      !> Where the nodes of the space are (dimension, nodes).
      real(wp), intent(in) :: places(:, :)
      integer :: cell(size(places, 2))
    end function cells_of_nodes
  end interface
end module qsmpm_cell_owners
