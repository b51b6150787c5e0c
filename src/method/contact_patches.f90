!> Patches of surface points on which contact is asked for in the mean: the points of one cell; a patch shorter than a
!> share of the cell joins its nearest neighbour of the same contact.
!>
!> A condition at every point would be more than the functions of a surface can follow: pressures swing from point to
!> point the stiffer the contact is. One condition a cell leaves them room (docs/methods/contact.md).
module qsmpm_contact_patches
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_model, only: model_type
  implicit none
  private

  public :: contact_patches_type, find_patches

  !> Extent over the size of a cell below which a patch joins another.
  real(wp), parameter :: shortest = 0.6_wp

  !> Lists of surface points, one behind the other.
  type :: contact_patches_type
    integer :: count = 0
    !> Contact of each patch (patches), its first place in the list (patches + 1), and the list.
    integer, allocatable :: pair(:), first(:), point(:)
  end type contact_patches_type

contains

  !> The patches of all contacts of which a point is near.
  subroutine find_patches(model, near, patches)
    type(model_type), intent(in) :: model
    !> Whether a surface point may touch the body of a contact (surface points, contacts).
    logical, intent(in) :: near(:, :)
    type(contact_patches_type), intent(out) :: patches
    integer, allocatable :: label(:), points(:)
    integer :: k, c, i

    allocate (patches%pair(0), patches%first(1), patches%point(0))
    patches%first = 1
    do k = 1, size(near, 2)
      points = pack([(i, i=1, size(near, 1))], model%state%surface%surface == model%contact_pairs(k)%surface)
      if (size(points) == 0) cycle
      label = model%state%surface%cell(points)
      call join_short(model, points, label)
      do c = minval(label), maxval(label)
        if (.not. any(label == c .and. near(points, k))) cycle
        patches%pair = [patches%pair, k]
        patches%point = [patches%point, pack(points, label == c)]
        patches%first = [patches%first, size(patches%point) + 1]
      end do
    end do
    patches%count = size(patches%pair)
  end subroutine find_patches

  !> Give the points of short patches the label of the nearest other patch, the shortest first.
  subroutine join_short(model, points, label)
    type(model_type), intent(in) :: model
    !> Surface points of the contact (points).
    integer, intent(in) :: points(:)
    !> The same number for all points of a patch (points).
    integer, intent(inout) :: label(:)
    real(wp) :: extents(size(points)), least, middle(model%mesh%dimension), distance, nearest
    integer :: i, short, other

    do i = 1, size(points)
      extents(i) = extent_of(model, points(i))
    end do
    do
      short = 0
      least = patch_limit(model)
      do i = 1, size(points)
        if (sum(extents, mask=label == label(i)) >= least) cycle
        least = sum(extents, mask=label == label(i))
        short = label(i)
      end do
      if (short == 0 .or. all(label == short)) return
      middle = middle_of(model, pack(points, label == short))
      nearest = huge(1.0_wp)
      do i = 1, size(points)
        if (label(i) == short) cycle
        distance = norm2(model%state%surface%position(:, points(i)) - middle)
        if (distance >= nearest) cycle
        nearest = distance
        other = label(i)
      end do
      where (label == short) label = other
    end do
  end subroutine join_short

  !> Length in the plane, area in space, that a surface point stands for.
  pure real(wp) function extent_of(model, point) result(extent)
    type(model_type), intent(in) :: model
    integer, intent(in) :: point

    extent = norm2(model%state%surface%area_vector(:, point))
    if (model%analysis%model == axisymmetric) extent = extent/model%state%surface%position(1, point)
  end function extent_of

  !> Extent below which a patch is short.
  pure real(wp) function patch_limit(model) result(limit)
    type(model_type), intent(in) :: model

    limit = shortest*model%cell_size
    if (model%mesh%dimension == 3) limit = limit**2
  end function patch_limit

  !> Mean place of surface points.
  pure function middle_of(model, points) result(middle)
    type(model_type), intent(in) :: model
    integer, intent(in) :: points(:)
    real(wp) :: middle(model%mesh%dimension)

    middle = sum(model%state%surface%position(:, points), dim=2)/size(points)
  end function middle_of
end module qsmpm_contact_patches
