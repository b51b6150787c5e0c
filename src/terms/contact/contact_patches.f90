!> Patches on which contact is imposed in the mean: the surface points of one cell, or the contact points of one part of
!> a body's outline; a patch shorter than a given share of the cell is joined to its nearest neighbour of the same
!> contact. Touching points of a cell form a separate patch: a mean that includes points which have left the body would
!> be open.
!>
!> A condition at every point would overconstrain the functions on a surface: pressures would oscillate from point to
!> point, the more the stiffer the contact is. One condition per cell avoids this (docs/methods/contact.md).
module qsmpm_contact_patches
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_body_points, only: body_points_type, are_near
  use qsmpm_mesh_measure, only: cell_size
  use qsmpm_model, only: model_type
  use qsmpm_method_description, only: basis_list
  use qsmpm_own_part, only: is_divided
  implicit none
  private

  public :: contact_patches_type, find_patches, extent_of

  !> Extent in cell sizes below which a patch is joined to another.
  real(wp), parameter :: shortest = 0.6_wp
  !> Largest distance of a neighbour, in cells.
  real(wp), parameter :: beside = 1.5_wp

  !> Lists of surface points, or of contact points on bodies, stored consecutively.
  type :: contact_patches_type
    integer :: count = 0
    !> Contact of each patch (patches), first position in the list (patches + 1), and the list of points.
    integer, allocatable :: pair(:), first(:), point(:)
    !> This process stores only a part of a patch on a body that acts on its nodes.
    logical :: torn = .false.
  end type contact_patches_type

contains

  !> Finds the patches of all contacts of which a point is near.
  subroutine find_patches(model, near, touched, on_bodies, patches, beside)
    type(model_type), intent(in) :: model
    !> Whether a surface point may touch the body of a contact, and whether it does (surface points, contacts).
    logical, intent(in) :: near(:, :), touched(:, :)
    !> Contact points on the bodies.
    type(body_points_type), intent(in) :: on_bodies
    type(contact_patches_type), intent(out) :: patches
    !> The point is beside a rounded corner, where it transmits no pressure (surface points, contacts).
    logical, intent(in), optional :: beside(:, :)
    integer, allocatable :: label(:), points(:)
    real(wp), allocatable :: extents(:), lengths(:)
    integer :: k, i

    allocate (patches%pair(0), patches%first(1), patches%point(0))
    patches%first = 1
    do k = 1, size(near, 2)
      if (model%contact_pairs(k)%surface > 0) then
        points = pack([(i, i=1, size(near, 1))], model%state%surface%surface == model%contact_pairs(k)%surface)
        if (present(beside)) points = pack(points, .not. beside(points, k))
        label = model%state%surface%cell(points)
        lengths = [(cell_size(model%mesh, label(i)), i=1, size(points))]
        extents = [(extent_of(model, points(i)), i=1, size(points))]/lengths**(model%mesh%dimension - 1)
        where (touched(points, k)) label = label + model%mesh%cell_count
        if (model%contact_pairs(k)%pointwise) label = [(i, i=1, size(points))]
        if (.not. model%contact_pairs(k)%pointwise) call join_short( &
          model%state%surface%position(:, points), extents, lengths, touched(points, k), label)
        call add_patches(k, points, label, near(points, k), patches)
      else
        points = pack([(i, i=1, on_bodies%count)], on_bodies%pair == k .and. on_bodies%touched)
        label = on_bodies%patch(points)
        extents = model%body_outlines(k)%length(points - findloc(on_bodies%pair, k, dim=1) + 1) &
          /on_bodies%cell_size(points)
        if (model%contact_pairs(k)%pointwise) label = [(i, i=1, size(points))]
        if (.not. model%contact_pairs(k)%pointwise) call join_short( &
          on_bodies%position(:, points), extents, on_bodies%cell_size(points), on_bodies%touched(points), label)
        call add_patches(k, points, label, whole_here(model, on_bodies, points, label), patches)
        patches%torn = patches%torn .or. is_torn(model, on_bodies, points, label)
      end if
    end do
    patches%count = size(patches%pair)
  end subroutine find_patches

  !> Returns whether this process stores the whole patch of a point on a body, with the soil around it (points).
  pure function whole_here(model, on_bodies, points, label) result(whole)
    type(model_type), intent(in) :: model
    type(body_points_type), intent(in) :: on_bodies
    !> Number and patch of each point.
    integer, intent(in) :: points(:), label(:)
    logical :: whole(size(points)), near(size(points)), in_ring(on_bodies%count)
    integer :: i

    whole = .true.
    if (.not. is_divided(model%part)) return
    in_ring = are_near(model, on_bodies, model%part%ring - 1)
    near = on_bodies%cell(points) > 0 .and. in_ring(points) .and. model%state%points%count > 0
    whole = [(all(near .or. label /= label(i)), i=1, size(points))]
  end function whole_here

  !> Returns whether a patch that this process stores only in part acts on its nodes: its functions extend over as many
  !> cells as their degree, those of the nearest material point one cell further.
  pure logical function is_torn(model, on_bodies, points, label)
    type(model_type), intent(in) :: model
    type(body_points_type), intent(in) :: on_bodies
    integer, intent(in) :: points(:), label(:)
    logical :: acts(on_bodies%count)

    is_torn = .false.
    if (.not. is_divided(model%part)) return
    associate (basis => basis_list(model%analysis%method%basis))
      acts = are_near(model, on_bodies, max(1, basis%degree) + 1)
    end associate
    is_torn = any(acts(points) .and. .not. whole_here(model, on_bodies, points, label))
  end function is_torn

  !> Adds the patches of a contact of which a point is near.
  subroutine add_patches(pair, points, label, near, patches)
    integer, intent(in) :: pair
    !> Number, patch label and nearness of each point.
    integer, intent(in) :: points(:), label(:)
    logical, intent(in) :: near(:)
    type(contact_patches_type), intent(inout) :: patches
    logical, allocatable :: wanted(:)
    integer :: c, i

    if (size(points) == 0) return
    allocate (wanted(minval(label):maxval(label)), source=.false.)
    do i = 1, size(label)
      wanted(label(i)) = wanted(label(i)) .or. near(i)
    end do
    do c = lbound(wanted, 1), ubound(wanted, 1)
      if (.not. wanted(c)) cycle
      patches%pair = [patches%pair, pair]
      patches%point = [patches%point, pack(points, label == c)]
      patches%first = [patches%first, size(patches%point) + 1]
    end do
  end subroutine add_patches

  !> Assigns the points of short patches the label of the nearest patch in their neighbourhood that has the same contact
  !> state, the shortest first; a patch without a neighbour is kept.
  pure subroutine join_short(place, extents, lengths, touched, label)
    !> Position of each point, its length or area relative to the face of its cell, cell size (dimension, points),
    !> (points).
    real(wp), intent(in) :: place(:, :), extents(:), lengths(:)
    logical, intent(in) :: touched(:)
    !> Label, equal for all points of a patch (points).
    integer, intent(inout) :: label(:)
    real(wp) :: least, middle(size(place, 1)), distance, nearest
    logical :: alone(size(label)), of_short(size(label))
    integer :: i, short, other

    alone = .false.
    do
      short = 0
      least = shortest**merge(2, 1, size(place, 1) == 3)
      do i = 1, size(label)
        if (alone(i)) cycle
        if (sum(extents, mask=label == label(i)) >= least) cycle
        least = sum(extents, mask=label == label(i))
        short = i
      end do
      if (short == 0) return
      of_short = label == label(short)
      do i = 1, size(middle)
        middle(i) = sum(place(i, :), mask=of_short)/count(of_short)
      end do
      other = 0
      nearest = beside*lengths(short)
      do i = 1, size(label)
        if (of_short(i) .or. (touched(i) .neqv. touched(short))) cycle
        distance = norm2(place(:, i) - middle)
        if (distance >= nearest) cycle
        nearest = distance
        other = i
      end do
      if (other == 0) then
        alone = alone .or. of_short
      else
        where (of_short) label = label(other)
      end if
    end do
  end subroutine join_short

  !> Returns the length (plane) or area (space) represented by a surface point.
  pure real(wp) function extent_of(model, point) result(extent)
    type(model_type), intent(in) :: model
    integer, intent(in) :: point

    extent = norm2(model%state%surface%area_vector(:, point))
    if (model%analysis%model /= axisymmetric) return
    associate (radius => model%state%surface%position(1, point))
      if (radius > 0.0_wp) extent = extent/radius
    end associate
  end function extent_of
end module qsmpm_contact_patches
