!> Which cell a piece of a body's surface belongs to.
!>
!> A piece inside a cell belongs to it. A piece on a face between two cells belongs to the one on the
!> material's side, when that one holds material. Coordinates of a deck or a file may miss the face by
!> their last digits, so that the piece lies in the empty cell: then it goes to the cell behind the
!> face, from which it is seen a hair outside.
module qsmpm_surface_owner
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: inside_distance, face_count, max_faces
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_search, only: inverse_map
  implicit none
  private

  public :: owner_of_piece

  !> Distance from a face below which a piece lies on it, as a share of the size of the face: exactly,
  !> so that both cells hold it, and all but the last digits of single precision.
  real(wp), parameter, public :: exactly_on = 1.0e-10_wp, nearly_on = 1.0e-6_wp

contains

  !> Cell that gets a piece found in a cell; 0 when none does or another one finds it too.
  pure integer function owner_of_piece(mesh, occupied, follow, cell, middle, facing, &
    deviation) result(owner)
    type(mesh_type), intent(in) :: mesh
    !> Cells that hold material (cell_count).
    logical, intent(in) :: occupied(:)
    !> A piece in an empty cell goes to the nearest neighbour that holds material; else it is dropped.
    logical, intent(in) :: follow
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Middle of the piece (dimension).
    real(wp), intent(in) :: middle(:)
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
    f = minloc(deviation, dim=1, mask=beyond .and. deviation <= nearly_on)
    if (f > 0) then
      if (facing(f) < 0.0_wp .or. owner == 0) owner = mesh%face_neighbour(f, cell)
    end if
    if (owner == 0 .and. follow) owner = nearest_neighbour(mesh, occupied, cell, middle)
  end function owner_of_piece

  !> The cell that holds material around an empty one whose inside is nearest to a place; 0 when there
  !> is none.
  pure integer function nearest_neighbour(mesh, occupied, cell, x) result(nearest)
    type(mesh_type), intent(in) :: mesh
    !> Cells that hold material (cell_count).
    logical, intent(in) :: occupied(:)
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Place (dimension).
    real(wp), intent(in) :: x(:)
    real(wp) :: local(size(x)), depth(max_faces), least
    logical :: ok
    integer :: i, n, other

    nearest = 0
    least = huge(1.0_wp)
    do i = mesh%vertex_first(cell), mesh%vertex_first(cell + 1) - 1
      other = mesh%vertex_neighbour(i)
      if (.not. occupied(other)) cycle
      call inverse_map(mesh, other, x, local, ok)
      if (.not. ok) cycle
      n = face_count(mesh%cell_kind(other))
      call inside_distance(mesh%cell_kind(other), local, depth(:n))
      if (-minval(depth(:n)) >= least) cycle
      least = -minval(depth(:n))
      nearest = other
    end do
  end function nearest_neighbour
end module qsmpm_surface_owner
