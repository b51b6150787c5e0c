!> Places at the boundary of the ground that a rigid body covers: no water passes there, and no free water reaches them.
!> A body that separates from the ground uncovers it.
module qsmpm_covered_faces
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: face_corners
  use qsmpm_model, only: model_type
  use qsmpm_rigid_bodies, only: placed_bodies
  use qsmpm_rigid_pose, only: placed_shape_type
  use qsmpm_rigid_shape, only: distance_type
  implicit none
  private

  public :: is_covered, is_under_body

  !> Distance from a body, relative to the length of a face, up to which the body covers the face.
  real(wp), parameter, public :: covering = 0.05_wp

contains

  !> Checks whether a rigid body covers the middle of a face of a cell.
  pure logical function is_covered(model, c, f)
    type(model_type), intent(in) :: model
    !> Number of the cell, and of its face.
    integer, intent(in) :: c, f

    is_covered = .false.
    if (size(model%analysis%rigid_bodies) == 0) return
    associate (node => model%mesh%cell_nodes(model%mesh%cell_first(c) - 1 + face_corners(model%mesh%cell_kind(c), f)))
      is_covered = is_under_body(model, model%mesh%coordinates(:, node))
    end associate
  end function is_covered

  !> Checks whether a rigid body covers the middle of some corners.
  pure logical function is_under_body(model, corners) result(covered)
    type(model_type), intent(in) :: model
    !> (dimension, corners)
    real(wp), intent(in) :: corners(:, :)
    type(placed_shape_type), allocatable :: bodies(:)
    type(distance_type) :: distance
    real(wp) :: middle(3)
    integer :: b

    covered = .false.
    middle = 0.0_wp
    middle(:size(corners, 1)) = sum(corners, dim=2)/size(corners, 2)
    allocate (bodies, source=placed_bodies(model))
    do b = 1, size(bodies)
      distance = bodies(b)%distance_at(middle)
      covered = covered .or. distance%value <= covering*norm2(corners(:, 2) - corners(:, 1))
    end do
  end function is_under_body
end module qsmpm_covered_faces
