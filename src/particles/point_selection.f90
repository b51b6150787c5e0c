!> Some of the points of a set as a set of their own, and two sets as one: points whose body comes or goes change from
!> one set to another with all that they carry.
module qsmpm_point_selection
  use qsmpm_field_list, only: field_list_type
  use qsmpm_points, only: carried_type, points_type, surface_points_type, allocate_points, allocate_surface_points, &
    carry_as
  implicit none
  private

  public :: select_points, select_surface_points, keep_chosen, append_points, append_surface_points

contains

  !> Material points by their numbers; one may be taken more than once.
  subroutine select_points(from, chosen, to)
    type(points_type), intent(in) :: from
    integer, intent(in) :: chosen(:)
    type(points_type), intent(out) :: to

    call allocate_like(from, size(chosen), to)
    call copy_columns(from, chosen, 0, to)
  end subroutine select_points

  !> The same of surface points.
  subroutine select_surface_points(from, chosen, to)
    type(surface_points_type), intent(in) :: from
    integer, intent(in) :: chosen(:)
    type(surface_points_type), intent(out) :: to

    call allocate_surface_points(to, size(from%position, 1), size(chosen))
    call copy_columns(from, chosen, 0, to)
  end subroutine select_surface_points

  !> Keep some points of a set, in the order that is given.
  subroutine keep_chosen(carried, chosen)
    !> Material points or surface points.
    class(carried_type), intent(inout) :: carried
    integer, intent(in) :: chosen(:)
    type(points_type) :: points
    type(surface_points_type) :: surface

    select type (carried)
    type is (points_type)
      call select_points(carried, chosen, points)
      carried = points
    type is (surface_points_type)
      call select_surface_points(carried, chosen, surface)
      carried = surface
    end select
  end subroutine keep_chosen

  !> Put points behind others.
  subroutine append_points(more, points)
    type(points_type), intent(in) :: more
    type(points_type), intent(inout) :: points
    type(points_type) :: joint
    integer :: i

    if (more%count == 0) return
    call allocate_like(more, points%count + more%count, joint)
    if (points%count > 0) call copy_columns(points, [(i, i=1, points%count)], 0, joint)
    call copy_columns(more, [(i, i=1, more%count)], points%count, joint)
    points = joint
  end subroutine append_points

  !> The same of surface points.
  subroutine append_surface_points(more, points)
    type(surface_points_type), intent(in) :: more
    type(surface_points_type), intent(inout) :: points
    type(surface_points_type) :: joint
    integer :: i

    if (more%count == 0) return
    call allocate_surface_points(joint, size(more%position, 1), points%count + more%count)
    if (points%count > 0) call copy_columns(points, [(i, i=1, points%count)], 0, joint)
    call copy_columns(more, [(i, i=1, more%count)], points%count, joint)
    points = joint
  end subroutine append_surface_points

  !> Room for points that carry what others do.
  subroutine allocate_like(like, count, points)
    type(points_type), intent(in) :: like
    integer, intent(in) :: count
    type(points_type), intent(out) :: points

    call allocate_points(points, size(like%position, 1), count, size(like%stress, 1), size(like%state, 1))
    call carry_as(points, like)
    if (size(like%deformation_gradient, 2) == 0) return
    deallocate (points%deformation_gradient)
    allocate (points%deformation_gradient(size(like%deformation_gradient, 1), count))
  end subroutine allocate_like

  !> Copy the fields of some points to those behind a place.
  subroutine copy_columns(from, chosen, before, to)
    class(carried_type), intent(in), target :: from
    integer, intent(in) :: chosen(:), before
    class(carried_type), intent(inout), target :: to
    type(field_list_type) :: old, new
    integer :: i, k

    call from%list_fields(old)
    call to%list_fields(new)
    do i = 1, old%count
      if (old%fields(i)%point_count() == 0) cycle
      do k = 1, size(chosen)
        if (associated(old%fields(i)%reals)) &
          new%fields(i)%reals(:, before + k) = old%fields(i)%reals(:, chosen(k))
        if (associated(old%fields(i)%labels)) new%fields(i)%labels(before + k) = old%fields(i)%labels(chosen(k))
        if (associated(old%fields(i)%numbers)) new%fields(i)%numbers(before + k) = old%fields(i)%numbers(chosen(k))
      end do
    end do
  end subroutine copy_columns
end module qsmpm_point_selection
