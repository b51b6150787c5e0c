!> Boundary of a body, independent of the mesh: an outline in the x-y plane, limits along z, a polyhedron, or a list of
!> cells.
module qsmpm_body_shape
  use qsmpm_kinds, only: wp
  use qsmpm_polyhedron, only: polyhedron_type
  implicit none
  private

  public :: body_shape_type, is_unbounded, shape_box

  !> Boundary of a body.
  type :: body_shape_type
    !> Vertices of the outline in the x-y plane, counter-clockwise (2,n); unallocated: no outline.
    real(wp), allocatable :: outline(:, :)
    !> Limits along z.
    real(wp) :: low = -huge(1.0_wp), high = huge(1.0_wp)
    !> Cells that the body may occupy (cell_count); unallocated: all.
    logical, allocatable :: region(:)
    !> The body is the interior of this polyhedron; unallocated: it is none.
    type(polyhedron_type), allocatable :: solid
    !> Uncertainty of the boundary as a length, for a file with few digits.
    real(wp) :: uncertainty = 0.0_wp
    !> Share of a cell that may be outside of a body that contains it: body-fitted cells merge places nearer than a
    !> twentieth of a cell, and the body ends at the resulting edges.
    real(wp) :: slack = 0.0_wp
  end type body_shape_type

contains

  !> Checks whether the body fills every cell that it may occupy.
  pure logical function is_unbounded(shape)
    !> Boundary of the body.
    type(body_shape_type), intent(in) :: shape

    is_unbounded = .not. allocated(shape%outline) .and. .not. allocated(shape%solid) &
      .and. shape%high >= huge(1.0_wp) .and. shape%low <= -huge(1.0_wp)
  end function is_unbounded

  !> Returns the bounding box of a body.
  pure subroutine shape_box(shape, low, high)
    !> Boundary of the body.
    type(body_shape_type), intent(in) :: shape
    !> Lower and upper corner (3).
    real(wp), intent(out) :: low(3), high(3)

    low = -huge(1.0_wp)
    high = huge(1.0_wp)
    if (allocated(shape%outline)) then
      low(:2) = minval(shape%outline, dim=2)
      high(:2) = maxval(shape%outline, dim=2)
    end if
    low(3) = shape%low
    high(3) = shape%high
    if (.not. allocated(shape%solid)) return
    low = max(low, shape%solid%low)
    high = min(high, shape%solid%high)
  end subroutine shape_box
end module qsmpm_body_shape
