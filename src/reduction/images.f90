!> Expansion of the material points of the model to those of the scene: replicated through the thickness, repeated from
!> column to column, mirrored, or rotated about an axis.
!>
!> The steps of the expansion are undone from the last to the first. The transformation of a field of a point depends on
!> its kind (qsmpm_field_list): fields of the output, not those from which a run is continued.
module qsmpm_images
  use qsmpm_kinds, only: wp
  use qsmpm_mesh_description, only: axis_type
  use qsmpm_field_list, only: field_type, field_list_type, kind_amount, kind_position, kind_vector, kind_tensor, &
    kind_internal
  use qsmpm_grid_window, only: window_type, place_of, number_at
  use qsmpm_points, only: points_type, allocate_points, carry_as
  use qsmpm_reduction, only: reduction_type, expansion_type, reduce_prismatic, reduce_revolved, reduce_column, &
    reduce_mirror
  implicit none
  private

  public :: image_list_type, make_images, mirror_field, turn_field, fold_place, window_of_scene

  !> Points of the scene.
  type :: image_list_type
    !> Vectors with three components, tensors with six; cell numbers refer to the whole grid.
    type(points_type) :: points
    !> Point of the model of which each is an image.
    integer, allocatable :: origin(:)
    !> Signs of the components of its vectors relative to those of the origin (3, count).
    real(wp), allocatable :: sign(:, :)
  end type image_list_type

contains

  !> Generates all points of the scene.
  subroutine make_images(expansion, points, cells, images)
    !> Expansion of the model.
    type(expansion_type), intent(in) :: expansion
    !> Points of the model, and the numbers of their cells in the whole grid (points).
    type(points_type), intent(in) :: points
    integer, intent(in) :: cells(:)
    !> Points of the scene.
    type(image_list_type), intent(out) :: images
    type(image_list_type) :: before
    integer :: s

    call first_images(points, cells, images)
    do s = size(expansion%steps), 1, -1
      before = images
      select case (expansion%steps(s)%kind)
      case (reduce_prismatic, reduce_column)
        call undo_repeated(expansion%steps(s), before, images)
      case (reduce_revolved)
        call undo_revolved(expansion%steps(s), before, images)
      case (reduce_mirror)
        call undo_mirror(expansion%steps(s), before, images)
      end select
    end do
  end subroutine make_images

  !> Returns the points of the model with all components.
  subroutine first_images(points, cells, images)
    !> Points of the model, and the numbers of their cells in the whole grid (points).
    type(points_type), intent(in), target :: points
    integer, intent(in) :: cells(:)
    type(image_list_type), intent(out), target :: images
    type(field_list_type) :: from, to
    integer :: i, n

    call allocate_images(points, points%count, images)
    call points%list_fields(from)
    call images%points%list_fields(to)
    do i = 1, from%count
      if (from%fields(i)%kind == kind_internal) cycle
      n = from%fields(i)%component_count()
      if (associated(from%fields(i)%reals)) to%fields(i)%reals(:n, :) = from%fields(i)%reals
      if (associated(from%fields(i)%labels)) to%fields(i)%labels = from%fields(i)%labels
    end do
    images%points%cell = cells
    images%origin = [(i, i=1, points%count)]
    images%sign = 1.0_wp
  end subroutine first_images

  !> Allocates a list of points with the fields of another list.
  subroutine allocate_images(like, count, images)
    type(points_type), intent(in) :: like
    !> Number of points.
    integer, intent(in) :: count
    type(image_list_type), intent(inout) :: images

    call allocate_points(images%points, 3, count, 6, 0)
    call carry_as(images%points, like)
    allocate (images%origin(count), images%sign(3, count))
  end subroutine allocate_images

  !> Replicates points of a list once or several times, each with a share of its extensive quantities.
  subroutine replicate(from, source, share, cells, to)
    type(image_list_type), intent(in), target :: from
    !> Point of which each is an image, and its volume relative to that of the point; a thickness converts an area into
    !> a volume (n).
    integer, intent(in) :: source(:)
    real(wp), intent(in) :: share(:)
    !> Cells of the images (n).
    integer, intent(in) :: cells(:)
    type(image_list_type), intent(out), target :: to
    type(field_list_type) :: old, new
    integer :: i, k

    call allocate_images(from%points, size(source), to)
    call from%points%list_fields(old)
    call to%points%list_fields(new)
    do i = 1, old%count
      associate (field => old%fields(i), image => new%fields(i))
        if (field%kind == kind_internal .or. field%point_count() == 0) cycle
        if (associated(field%labels)) image%labels = field%labels(source)
        if (.not. associated(field%reals)) cycle
        do k = 1, size(source)
          image%reals(:, k) = field%reals(:, source(k))
          if (field%kind == kind_amount) image%reals(:, k) = share(k)*image%reals(:, k)
        end do
      end associate
    end do
    to%points%cell = cells
    to%origin = from%origin(source)
    to%sign = from%sign(:, source)
  end subroutine replicate

  !> Maps images along an axis: x <- shift + ratio*(x - from) of every position.
  subroutine map_coordinate(images, axis, from, shift, ratio)
    type(image_list_type), intent(inout), target :: images
    integer, intent(in) :: axis
    real(wp), intent(in) :: from
    !> (n)
    real(wp), intent(in) :: shift(:), ratio(:)
    type(field_list_type) :: list
    integer :: i

    call images%points%list_fields(list)
    do i = 1, list%count
      if (list%fields(i)%kind /= kind_position) cycle
      associate (x => list%fields(i)%reals)
        x(axis, :) = shift + ratio*(x(axis, :) - from)
      end associate
    end do
  end subroutine map_coordinate

  !> Number of the cell in a brick that is the image of a part of another brick.
  pure integer function image_cell(at, counts, pieces, cell) result(number)
    !> Brick along each axis, bricks along each axis, cells per brick, and the cell of the other brick.
    integer, intent(in) :: at(3), counts(3), pieces, cell

    number = (number_at(at, counts) - 1)*pieces + mod(cell - 1, pieces) + 1
  end function image_cell

  !> Number of bricks along each axis of a grid.
  pure function brick_counts(lines) result(counts)
    !> Grid lines; unallocated along z in the plane.
    type(axis_type), intent(in) :: lines(3)
    integer :: counts(3), a

    counts = 1
    do a = 1, 3
      if (allocated(lines(a)%lines)) counts(a) = size(lines(a)%lines) - 1
    end do
  end function brick_counts

  !> Repeats points along the axis of the step: in layers through the thickness, or from column to column. Nothing moves
  !> along the axis, so that the positions in the column apply to all.
  subroutine undo_repeated(step, few, images)
    type(reduction_type), intent(in) :: step
    !> Points of the plane or of the column.
    type(image_list_type), intent(in) :: few
    !> Points of the scene.
    type(image_list_type), intent(out) :: images
    integer, allocatable :: source(:), cells(:)
    real(wp), allocatable :: share(:), x(:)
    real(wp) :: width
    integer :: i, k, l, n, counts(3), few_counts(3), at(3)

    counts = brick_counts(step%lines)
    few_counts = counts
    few_counts(step%axis) = 1
    n = 0
    do i = 1, few%points%count
      n = n + counts(step%axis)*size(step%layers(few%points%body(i))%place)
    end do
    allocate (source(n), cells(n), share(n), x(n))
    n = 0
    associate (a => step%axis, lines => step%lines(step%axis)%lines)
      ! The volumes of a column are those of its width, those of a plane of the unit thickness.
      width = merge(1.0_wp, lines(2) - lines(1), step%kind == reduce_prismatic)
      do i = 1, few%points%count
        at = place_of((few%points%cell(i) - 1)/step%pieces + 1, few_counts)
        associate (layers => step%layers(few%points%body(i)))
          do k = 1, counts(a)
            at(a) = k
            do l = 1, size(layers%place)
              n = n + 1
              source(n) = i
              share(n) = layers%share(l)*((lines(k + 1) - lines(k))/width)
              x(n) = lines(k) + layers%place(l)*(lines(k + 1) - lines(k))
              cells(n) = image_cell(at, counts, step%pieces, few%points%cell(i))
            end do
          end do
        end associate
      end do
      call replicate(few, source, share, cells, images)
      call map_coordinate(images, a, lines(1), x, merge(0.0_wp, share, step%kind == reduce_prismatic))
    end associate
  end subroutine undo_repeated

  !> Generates points around the axis at about the spacing of those in the half section.
  subroutine undo_revolved(step, flat, images)
    type(reduction_type), intent(in) :: step
    !> Points of the half section, their volumes per radian.
    type(image_list_type), intent(in) :: flat
    !> Points of the scene.
    type(image_list_type), intent(out), target :: images
    type(field_list_type) :: list
    integer, allocatable :: source(:)
    real(wp), allocatable :: angle(:)
    integer :: i, k, n, copies(flat%points%count), counts(3), at(3)
    real(wp) :: sector

    sector = step%sector(2) - step%sector(1)
    counts = brick_counts(step%lines)
    do i = 1, flat%points%count
      associate (r => flat%points%initial_position(1, i))
        copies(i) = max(1, nint(sector*r/sqrt(flat%points%initial_volume(i)/r)))
      end associate
    end do
    allocate (source(sum(copies)), angle(sum(copies)))
    n = 0
    do i = 1, flat%points%count
      do k = 1, copies(i)
        n = n + 1
        source(n) = i
        angle(n) = step%sector(1) + sector*(k - 0.5_wp)/copies(i)
      end do
    end do
    call replicate(flat, source, sector/copies(source), spread(1, 1, n), images)
    call images%points%list_fields(list)
    do i = 1, list%count
      call turn_field(list%fields(i), step%centre, angle)
    end do
    associate (points => images%points)
      do i = 1, n
        at = [(interval(step%lines(k)%lines, points%position(k, i)), k=1, 3)]
        points%cell(i) = number_at(at, counts)
      end do
    end associate
  end subroutine undo_revolved

  !> Rotates the fields of a half section about the axis: radius, height and hoop become x, y and z.
  pure subroutine turn_field(field, centre, angle)
    type(field_type), intent(inout) :: field
    !> x and z of the axis; angle of each point from x to z (n).
    real(wp), intent(in) :: centre(2), angle(:)
    real(wp) :: c, s
    integer :: k

    if (all(field%kind /= [kind_position, kind_vector, kind_tensor])) return
    do k = 1, field%point_count()
      c = cos(angle(k))
      s = sin(angle(k))
      associate (v => field%reals(:, k))
        if (field%kind == kind_tensor) then
          v = turned_tensor(v, c, s)
        else
          v = [c*v(1) - s*v(3), v(2), s*v(1) + c*v(3)]
        end if
        if (field%kind == kind_position) v([1, 3]) = v([1, 3]) + centre
      end associate
    end do
  end subroutine turn_field

  !> Symmetric tensor in x, y and z from that in radius, height and hoop direction.
  pure function turned_tensor(tensor, c, s) result(turned)
    !> Radial, vertical and hoop components and the shear of the first two: 11, 22, 33, 12.
    real(wp), intent(in) :: tensor(6)
    !> Cosine and sine of the angle from x to z.
    real(wp), intent(in) :: c, s
    real(wp) :: turned(6)

    turned = [c*c*tensor(1) + s*s*tensor(3), tensor(2), s*s*tensor(1) + c*c*tensor(3), c*tensor(4), &
      c*s*(tensor(1) - tensor(3)), s*tensor(4)]
  end function turned_tensor

  !> Interval of lines that contains a place.
  pure integer function interval(lines, x)
    !> Increasing lines; the place.
    real(wp), intent(in) :: lines(:), x

    interval = max(1, min(size(lines) - 1, count(lines <= x)))
  end function interval

  !> Appends the mirror image to the half.
  subroutine undo_mirror(step, half, images)
    type(reduction_type), intent(in) :: step
    !> Points of the half.
    type(image_list_type), intent(in) :: half
    !> Points of the scene.
    type(image_list_type), intent(out), target :: images
    type(field_list_type) :: list
    integer :: i, n, counts(3), half_counts(3), at(3), cells(2*half%points%count)

    counts = brick_counts(step%lines)
    half_counts = counts
    n = half%points%count
    associate (a => step%axis)
      half_counts(a) = counts(a)/2
      do i = 1, n
        at = place_of((half%points%cell(i) - 1)/step%pieces + 1, half_counts)
        cells(i) = image_cell(at, counts, step%pieces, half%points%cell(i))
        at(a) = counts(a) + 1 - at(a)
        cells(n + i) = image_cell(at, counts, step%pieces, half%points%cell(i))
      end do
      call replicate(half, [(i, i=1, n), (i, i=1, n)], spread(1.0_wp, 1, 2*n), cells, images)
      images%points%body = [step%body(half%points%body), step%image_body(half%points%body)]
      images%sign(a, n + 1:) = -images%sign(a, n + 1:)
      call images%points%list_fields(list)
      do i = 1, list%count
        call mirror_field(list%fields(i), a, step%plane, n + 1)
      end do
    end associate
  end subroutine undo_mirror

  !> Mirrors the fields of the points from a given one on.
  pure subroutine mirror_field(field, axis, plane, first)
    type(field_type), intent(inout) :: field
    !> Axis normal to the mirror plane, and the coordinate of the plane.
    integer, intent(in) :: axis
    real(wp), intent(in) :: plane
    !> First point that is mirrored.
    integer, intent(in) :: first

    if (field%point_count() == 0) return
    select case (field%kind)
    case (kind_position)
      field%reals(axis, first:) = 2.0_wp*plane - field%reals(axis, first:)
    case (kind_vector)
      field%reals(axis, first:) = -field%reals(axis, first:)
    case (kind_tensor)
      ! The two shear components that contain the axis: 12 and 13, 12 and 23, 13 and 23.
      associate (shear => merge([4, 5], merge([4, 6], [5, 6], axis == 2), axis == 1))
        field%reals(shear, first:) = -field%reals(shear, first:)
      end associate
    end select
  end subroutine mirror_field

  !> Returns the part of the scene's grid that is the image of a part of the model's grid.
  pure type(window_type) function window_of_scene(expansion, window) result(wide)
    !> Expansion of the model.
    type(expansion_type), intent(in) :: expansion
    !> The part of the model's grid.
    type(window_type), intent(in) :: window
    integer :: s, counts(3)

    wide = window
    do s = size(expansion%steps), 1, -1
      associate (step => expansion%steps(s), a => expansion%steps(s)%axis)
        counts = brick_counts(step%lines)
        select case (step%kind)
        case (reduce_prismatic, reduce_column)
          wide%first(a) = 1
          wide%last(a) = counts(a)
        case (reduce_revolved)
          wide%first([1, 3]) = 1
          wide%last([1, 3]) = counts([1, 3])
        case (reduce_mirror)
          wide%last(a) = counts(a) + 1 - wide%first(a)
        end select
      end associate
    end do
  end function window_of_scene

  !> Maps a place of the scene to the place of the model of which it is an image, with the signs of its vectors; sign 0
  !> for components without displacement.
  pure subroutine fold_place(expansion, place, sign)
    !> Expansion of the model.
    type(expansion_type), intent(in) :: expansion
    !> On entry the place in the scene, on return in the model (3).
    real(wp), intent(inout) :: place(3)
    !> Vector of the scene = sign * vector of the model (3).
    real(wp), intent(out) :: sign(3)
    integer :: s, i

    sign = 1.0_wp
    do s = 1, size(expansion%steps)
      associate (step => expansion%steps(s), a => expansion%steps(s)%axis)
        select case (step%kind)
        case (reduce_prismatic)
          place(3) = 0.0_wp
          sign(3) = 0.0_wp
        case (reduce_revolved)
          place = [norm2(place([1, 3]) - step%centre), place(2), 0.0_wp]
          sign([1, 3]) = 0.0_wp
        case (reduce_column)
          associate (lines => step%lines(1)%lines)
            i = max(1, min(size(lines) - 1, count(lines <= place(1))))
            place(1) = lines(1) + (lines(2) - lines(1))*(place(1) - lines(i))/(lines(i + 1) - lines(i))
          end associate
          sign(1) = 0.0_wp
        case (reduce_mirror)
          if (place(a) > step%plane) then
            place(a) = 2.0_wp*step%plane - place(a)
            sign(a) = -sign(a)
          end if
        end select
      end associate
    end do
  end subroutine fold_place
end module qsmpm_images
