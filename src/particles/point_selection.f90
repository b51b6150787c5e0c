!> Selection of some points of a set as a separate set, and union of two sets: points whose body is activated or removed
!> are moved from one set to another with all their fields.
module qsmpm_point_selection
  use qsmpm_field_list, only: field_list_type, field_type
  use qsmpm_points, only: carried_type, points_type, surface_points_type, allocate_points, allocate_surface_points, &
    carry_as
  implicit none
  private

  public :: select_points, keep_chosen, append_points, move_points, allocate_like, copy_column

contains

  !> Selects points of a set by their numbers; a point may be selected more than once.
  subroutine select_points(from, chosen, to)
    !> Material points or surface points, both of the same type.
    class(carried_type), intent(in) :: from
    integer, intent(in) :: chosen(:)
    class(carried_type), intent(inout) :: to

    call allocate_like(from, size(chosen), to)
    call copy_columns(from, chosen, 0, to)
  end subroutine select_points

  !> Keeps some points of a set, in the given order.
  subroutine keep_chosen(carried, chosen)
    class(carried_type), intent(inout) :: carried
    integer, intent(in) :: chosen(:)
    class(carried_type), allocatable :: all

    allocate (all, source=carried)
    call select_points(all, chosen, carried)
  end subroutine keep_chosen

  !> Appends points to others.
  subroutine append_points(more, points)
    class(carried_type), intent(in) :: more
    class(carried_type), intent(inout) :: points
    class(carried_type), allocatable :: before
    integer :: i

    if (more%count == 0) return
    allocate (before, source=points)
    call allocate_like(more, before%count + more%count, points)
    if (before%count > 0) call copy_columns(before, [(i, i=1, before%count)], 0, points)
    call copy_columns(more, [(i, i=1, more%count)], before%count, points)
  end subroutine append_points

  !> Moves some points of a set to the end of another.
  subroutine move_points(chosen, from, to)
    logical, intent(in) :: chosen(:)
    class(carried_type), intent(inout) :: from, to
    class(carried_type), allocatable :: going
    integer :: i

    if (.not. any(chosen)) return
    allocate (going, mold=from)
    call select_points(from, pack([(i, i=1, size(chosen))], chosen), going)
    call keep_chosen(from, pack([(i, i=1, size(chosen))], .not. chosen))
    call append_points(going, to)
  end subroutine move_points

  !> Allocates points with the same fields as others.
  subroutine allocate_like(like, count, points)
    class(carried_type), intent(in) :: like
    integer, intent(in) :: count
    class(carried_type), intent(inout) :: points

    select type (points)
    type is (points_type)
      select type (like)
      type is (points_type)
        call allocate_points(points, size(like%position, 1), count, size(like%stress, 1), size(like%state, 1))
        call carry_as(points, like)
        if (size(like%deformation_gradient, 2) == 0) return
        deallocate (points%deformation_gradient)
        allocate (points%deformation_gradient(size(like%deformation_gradient, 1), count))
      end select
    type is (surface_points_type)
      call allocate_surface_points(points, size(like%position, 1), count)
    end select
  end subroutine allocate_like

  !> Copies the fields of some points to the positions after `before`.
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
        call copy_column(old%fields(i), chosen(k), before + k, new%fields(i))
      end do
    end do
  end subroutine copy_columns

  !> Copies the values of one point of a field.
  pure subroutine copy_column(from, column, place, to)
    type(field_type), intent(in) :: from
    !> Number of the point, and its new position.
    integer, intent(in) :: column, place
    type(field_type), intent(inout) :: to

    if (associated(from%reals)) to%reals(:, place) = from%reals(:, column)
    if (associated(from%labels)) to%labels(place) = from%labels(column)
    if (associated(from%numbers)) to%numbers(place) = from%numbers(column)
  end subroutine copy_column
end module qsmpm_point_selection
