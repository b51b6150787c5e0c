!> Refinement of surfaces that stretch: the points of a surface that may be in contact with a rigid body are split where
!> they represent a large part of a cell, and merged where they represent a small part, so that the patch of a cell
!> retains several points.
!>
!> A point of length L (of the present area vector) is replaced by two at x -+ L t/4, t along the surface, where L is
!> more than a third of a cell and more than initially; two neighbours are merged where one is shorter than a twelfth of
!> a cell and than initially. Sums of area vectors, of pressure, shear and slip times area, and of reactions do not
!> change. This applies in the plane and in axisymmetry; surfaces with loads or supports retain their points, as do
!> surfaces in space.
module qsmpm_surface_refinement
  use qsmpm_kinds, only: wp, int_long => long
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_mesh_measure, only: cell_size
  use qsmpm_mesh_search, only: locate
  use qsmpm_model, only: model_type
  use qsmpm_point_selection, only: select_points, keep_chosen
  use qsmpm_points, only: surface_points_type
  use qsmpm_own_part, only: own_of
  implicit none
  private

  public :: refine_surfaces, needs_refining

  !> Lengths in cell sizes above which a point is split, and below which it is merged with another.
  real(wp), parameter :: longest = 1.0_wp/3.0_wp, shortest = 1.0_wp/12.0_wp
  !> Stretch below which points are neither split nor merged: the initial points are retained.
  real(wp), parameter :: stretched = 1.2_wp
  !> Largest distance of neighbours relative to the mean of their lengths, and smallest cosine of the angle between
  !> them.
  real(wp), parameter :: apart = 1.5_wp, level = 0.9_wp

contains

  !> Splits and merges the points of all surfaces in contact pairs.
  subroutine refine_surfaces(model)
    type(model_type), intent(inout) :: model

    if (model%mesh%dimension /= 2 .or. model%state%surface%count == 0) return
    if (.not. any(touches_only(model))) return
    call split_long(model, touches_only(model))
    call join_short(model, touches_only(model))
  end subroutine refine_surfaces

  !> Returns whether an owned point has become so long or short that it would be split or merged.
  pure logical function needs_refining(model) result(needs)
    type(model_type), intent(in) :: model
    logical :: chosen(model%state%surface%count)
    real(wp) :: lengths(2)
    integer :: i

    needs = .false.
    if (model%mesh%dimension /= 2 .or. model%state%surface%count == 0) return
    chosen = touches_only(model) .and. own_of(model%part%surface, model%state%surface%count)
    do i = 1, size(chosen)
      if (.not. chosen(i)) cycle
      lengths = lengths_of(model, i)
      needs = is_long(model, i, lengths)
      if (is_short(model, i, lengths)) needs = needs .or. neighbour_of(model, i, .not. chosen, lengths(1)) > 0
      if (needs) return
    end do
  end function needs_refining

  !> Returns whether a point has become too long.
  pure logical function is_long(model, i, lengths)
    type(model_type), intent(in) :: model
    integer, intent(in) :: i
    !> Present and initial length.
    real(wp), intent(in) :: lengths(2)

    is_long = lengths(1) > max(longest*size_at(model, i), stretched*lengths(2))
  end function is_long

  !> Returns whether a point has become too short.
  pure logical function is_short(model, i, lengths)
    type(model_type), intent(in) :: model
    integer, intent(in) :: i
    real(wp), intent(in) :: lengths(2)

    is_short = lengths(1) <= min(shortest*size_at(model, i), lengths(2)/stretched)
  end function is_short

  !> Returns the points of surfaces that may be in contact with rigid bodies and have no other function (surface
  !> points).
  pure function touches_only(model) result(chosen)
    type(model_type), intent(in) :: model
    logical :: chosen(model%state%surface%count), surface(size(model%analysis%surfaces))
    integer :: s, p, i

    do s = 1, size(surface)
      surface(s) = any(model%contact_pairs%surface == s)
      do p = 1, size(model%analysis%phases)
        associate (phase => model%analysis%phases(p), name => model%analysis%surfaces(s)%name)
          do i = 1, size(phase%tractions)
            surface(s) = surface(s) .and. phase%tractions(i)%surface /= name
          end do
          do i = 1, size(phase%supports)
            surface(s) = surface(s) .and. phase%supports(i)%surface /= name
          end do
        end associate
      end do
    end do
    chosen = surface(model%state%surface%surface)
  end function touches_only

  !> Returns the length represented by a point, and its initial value.
  pure function lengths_of(model, i) result(lengths)
    type(model_type), intent(in) :: model
    integer, intent(in) :: i
    real(wp) :: lengths(2)

    associate (surface => model%state%surface)
      lengths = [norm2(surface%area_vector(:, i)), surface%area(i)]
      if (model%analysis%model == axisymmetric) lengths = lengths/[surface%position(1, i), &
        surface%initial_position(1, i)]
    end associate
  end function lengths_of

  !> Returns the size of the cell of a point.
  pure real(wp) function size_at(model, i)
    type(model_type), intent(in) :: model
    integer, intent(in) :: i

    size_at = cell_size(model%mesh, model%state%surface%cell(i))
  end function size_at

  !> Returns the unit tangent of the surface, with the outward normal to its right.
  pure function tangent_of(normal) result(tangent)
    !> Vector of any length (2).
    real(wp), intent(in) :: normal(:)
    real(wp) :: tangent(2)

    tangent = [-normal(2), normal(1)]/norm2(normal)
  end function tangent_of

  !> Splits the points that have become long.
  subroutine split_long(model, chosen)
    type(model_type), intent(inout) :: model
    logical, intent(in) :: chosen(:)
    type(surface_points_type) :: finer
    real(wp) :: place(2, 2, size(chosen)), local(2, 2, size(chosen)), lengths(2), step(2), drawn_step(2), parts(2)
    integer :: cell(2, size(chosen)), i, n, k
    integer(int_long) :: highest
    logical :: long(size(chosen)), found(2)

    do i = 1, size(chosen)
      long(i) = .false.
      if (.not. chosen(i)) cycle
      lengths = lengths_of(model, i)
      long(i) = is_long(model, i, lengths)
      if (.not. long(i)) cycle
      step = 0.25_wp*lengths(1)*tangent_of(model%state%surface%area_vector(:, i))
      do k = 1, 2
        place(:, k, i) = model%state%surface%position(:, i) + (2*k - 3)*step
        cell(k, i) = model%state%surface%cell(i)
        call locate(model%mesh, place(:, k, i), cell(k, i), local(:, k, i), found(k))
      end do
      long(i) = all(found)
    end do
    if (.not. any(long)) return
    call select_points(model%state%surface, [(spread(i, 1, merge(2, 1, long(i))), i=1, size(long))], finer)
    highest = maxval(finer%number)
    n = 0
    do i = 1, size(long)
      n = n + 1
      if (.not. long(i)) cycle
      lengths = lengths_of(model, i)
      drawn_step = 0.25_wp*lengths(2)*tangent_of(model%state%surface%normal(:, i))
      ! In axisymmetry the parts of a ring are in proportion to their radii.
      parts = 0.5_wp
      if (model%analysis%model == axisymmetric) parts(1) = place(1, 1, i)/sum(place(1, :, i))
      parts(2) = 1.0_wp - parts(1)
      do k = 1, 2
        finer%position(:, n + k - 1) = place(:, k, i)
        finer%initial_position(:, n + k - 1) = finer%initial_position(:, n + k - 1) + (2*k - 3)*drawn_step
        finer%cell(n + k - 1) = cell(k, i)
        finer%local(:, n + k - 1) = local(:, k, i)
        call take_share(finer, n + k - 1, parts(k))
      end do
      ! The first half retains the label.
      n = n + 1
      highest = highest + 1
      finer%number(n) = highest
    end do
    model%state%surface = finer
  end subroutine split_long

  !> Reduces the extensive quantities of a point to a share.
  pure subroutine take_share(surface, i, share)
    type(surface_points_type), intent(inout) :: surface
    integer, intent(in) :: i
    real(wp), intent(in) :: share

    surface%area(i) = share*surface%area(i)
    surface%area_vector(:, i) = share*surface%area_vector(:, i)
    surface%reaction(:, i) = share*surface%reaction(:, i)
    surface%released(:, i) = share*surface%released(:, i)
  end subroutine take_share

  !> Merges the points that have become short with their neighbours.
  subroutine join_short(model, chosen)
    type(model_type), intent(inout) :: model
    logical, intent(in) :: chosen(:)
    logical :: gone(size(chosen)), found
    real(wp) :: lengths(2), local(2)
    integer :: i, k, cell

    gone = .false.
    do i = 1, size(chosen)
      if (.not. chosen(i) .or. gone(i)) cycle
      lengths = lengths_of(model, i)
      if (.not. is_short(model, i, lengths)) cycle
      k = neighbour_of(model, i, gone, lengths(1))
      if (k == 0) cycle
      cell = model%state%surface%cell(k)
      call locate(model%mesh, middle_of(model%state%surface, i, k), cell, local, found)
      if (.not. found) cycle
      call unite(model%state%surface, i, k)
      model%state%surface%cell(k) = cell
      model%state%surface%local(:, k) = local
      gone(i) = .true.
    end do
    if (.not. any(gone)) return
    call keep_chosen(model%state%surface, pack([(i, i=1, size(gone))], .not. gone))
  end subroutine join_short

  !> Returns the nearest neighbour of a point on its surface; 0 where no point is close enough, has the same direction,
  !> and is short enough together with the point.
  pure integer function neighbour_of(model, i, gone, length) result(neighbour)
    type(model_type), intent(in) :: model
    integer, intent(in) :: i
    logical, intent(in) :: gone(:)
    real(wp), intent(in) :: length
    real(wp) :: distance, nearest, lengths(2)
    integer :: k

    neighbour = 0
    nearest = huge(1.0_wp)
    associate (surface => model%state%surface)
      do k = 1, surface%count
        if (k == i .or. gone(k) .or. surface%surface(k) /= surface%surface(i) .or. surface%body(k) /= surface%body(i) &
          .or. surface%foot(k) /= surface%foot(i)) cycle
        distance = norm2(surface%position(:, k) - surface%position(:, i))
        if (distance >= nearest) cycle
        lengths = lengths_of(model, k)
        if (distance > 0.5_wp*apart*(length + lengths(1)) .or. length + lengths(1) > longest*size_at(model, i)) cycle
        if (dot_product(surface%area_vector(:, k), surface%area_vector(:, i)) < level &
          *norm2(surface%area_vector(:, k))*norm2(surface%area_vector(:, i))) cycle
        nearest = distance
        neighbour = k
      end do
    end associate
  end function neighbour_of

  !> Returns the centre of two points, weighted by their areas.
  pure function middle_of(surface, i, k) result(middle)
    type(surface_points_type), intent(in) :: surface
    integer, intent(in) :: i, k
    real(wp) :: middle(2), first, second

    first = norm2(surface%area_vector(:, i))
    second = norm2(surface%area_vector(:, k))
    middle = (first*surface%position(:, i) + second*surface%position(:, k))/(first + second)
  end function middle_of

  !> Adds the quantities of a point to those of another.
  pure subroutine unite(surface, i, k)
    type(surface_points_type), intent(inout) :: surface
    integer, intent(in) :: i, k
    real(wp) :: first, second, whole, drawn

    first = norm2(surface%area_vector(:, i))
    second = norm2(surface%area_vector(:, k))
    drawn = surface%area(i) + surface%area(k)
    surface%position(:, k) = middle_of(surface, i, k)
    surface%initial_position(:, k) = (surface%area(i)*surface%initial_position(:, i) &
      + surface%area(k)*surface%initial_position(:, k))/drawn
    surface%area(k) = drawn
    surface%area_vector(:, k) = surface%area_vector(:, k) + surface%area_vector(:, i)
    whole = norm2(surface%area_vector(:, k))
    surface%contact_pressure(k) = (first*surface%contact_pressure(i) + second*surface%contact_pressure(k))/whole
    surface%contact_shear(:, k) = (first*surface%contact_shear(:, i) + second*surface%contact_shear(:, k))/whole
    surface%contact_slip(:, k) = (first*surface%contact_slip(:, i) + second*surface%contact_slip(:, k))/whole
    surface%normal(:, k) = surface%normal(:, k) + surface%normal(:, i)
    surface%normal(:, k) = surface%normal(:, k)/norm2(surface%normal(:, k))
    surface%reaction(:, k) = surface%reaction(:, k) + surface%reaction(:, i)
    surface%released(:, k) = surface%released(:, k) + surface%released(:, i)
  end subroutine unite
end module qsmpm_surface_refinement
