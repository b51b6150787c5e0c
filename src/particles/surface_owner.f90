!> Which cell a piece of a body's surface belongs to.
!>
!> A piece inside a cell belongs to it. A piece on a face between two cells belongs to the one on the
!> material's side, when that one holds material. Coordinates of a deck or a file may miss the face by
!> their last digits, so that the piece lies in the empty cell: then it goes to the cell behind the
!> face, from which it is seen a hair outside.
module qsmpm_surface_owner
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  implicit none
  private

  public :: owner_of_piece

  !> Distance from a face below which a piece lies on it, as a share of the size of the face: exactly,
  !> so that both cells hold it, and all but the last digits of single precision.
  real(wp), parameter, public :: exactly_on = 1.0e-10_wp, nearly_on = 1.0e-6_wp

contains

  !> Cell that gets a piece found in a cell; 0 when none does or another one finds it too.
  pure integer function owner_of_piece(mesh, occupied, follow, cell, facing, deviation) result(owner)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Cells that hold material (cell_count).
    logical, intent(in) :: occupied(:)
    !> A piece in an empty cell goes to the nearest neighbour that holds material; else it is dropped.
    logical, intent(in) :: follow
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Outward normal of the piece times that of each face of the cell.
    real(wp), intent(in) :: facing(:)
    !> Greatest distance of the piece from each face, as a share of its size; 0 when it is on it.
    real(wp), intent(in) :: deviation(:)
    logical :: beyond(size(facing))
    integer :: f

    do f = 1, size(facing)
      beyond(f) = mesh%face_neighbour(f, cell) > 0
      if (beyond(f)) beyond(f) = occupied(mesh%face_neighbour(f, cell))
    end do
    owner = merge(cell, 0, occupied(cell))
    do f = 1, size(facing)
      if (deviation(f) > 0.0_wp) cycle
      ! The cell beyond finds the piece as well; it is that cell's when the material is there.
      if (facing(f) < 0.0_wp .and. beyond(f)) owner = 0
      return
    end do
    f = minloc(deviation, dim=1, mask=beyond)
    if (f == 0) return
    if (deviation(f) <= nearly_on .and. facing(f) < 0.0_wp) owner = mesh%face_neighbour(f, cell)
    if (owner > 0) return
    if (deviation(f) <= nearly_on .or. follow) owner = mesh%face_neighbour(f, cell)
  end function owner_of_piece
end module qsmpm_surface_owner
