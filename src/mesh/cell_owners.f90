!> Interface to the distribution of the mesh cells over the processes of a team: owner of each cell, and cells in the
!> rows around those of a process. Implemented for grid boxes (qsmpm_cell_boxes) and other parts (qsmpm_cell_parts).
!>
!> Cells are numbered as in the whole mesh. Every process stores the complete distribution.
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
    !> Ranks that own the given cells; -1 for cell 0, which means no cell.
    pure function ranks_of_cells(self, cell) result(rank)
      import :: cell_owners_type
      class(cell_owners_type), intent(in) :: self
      integer, intent(in) :: cell(:)
      integer :: rank(size(cell))
    end function ranks_of_cells

    !> Which of the given cells are owned by a rank or are in a given number of rows around its cells.
    pure function cells_near(self, rank, rows, cell) result(near)
      import :: cell_owners_type
      class(cell_owners_type), intent(in) :: self
      integer, intent(in) :: rank, rows, cell(:)
      logical :: near(size(cell))
    end function cells_near

    !> Cells to which nodes belong: each node to one of the cells around it, independent of the part of the mesh in use.
    pure function cells_of_nodes(self, mesh, places) result(cell)
      import :: cell_owners_type, mesh_type, wp
      class(cell_owners_type), intent(in) :: self
      type(mesh_type), intent(in) :: mesh
      !> Coordinates of the nodes of the space (dimension, nodes).
      real(wp), intent(in) :: places(:, :)
      integer :: cell(size(places, 2))
    end function cells_of_nodes
  end interface
end module qsmpm_cell_owners
