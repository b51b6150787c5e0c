!> From the material points of the model to those of the scene: replicated through the thickness,
!> repeated from column to column, mirrored, turned about an axis.
!>
!> The steps of the expansion are undone from the last to the first. Positions, initial positions,
!> stresses and volumes are all there is: what a picture shows, not what a run continues from.
module qsmpm_images
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: axis_type
  use qsmpm_grid_window, only: window_type
  use qsmpm_points, only: points_type
  use qsmpm_reduction, only: reduction_type, expansion_type, reduce_prismatic, reduce_revolved, reduce_column, &
    reduce_mirror
  implicit none
  private

  public :: image_list_type, make_images, fold_place, window_of_scene

  !> Points of the scene; vectors with three components, stresses with six.
  type :: image_list_type
    integer :: count = 0
    !> Places now and at the start (3, count).
    real(wp), allocatable :: position(:, :), initial_position(:, :)
    !> 11, 22, 33, 12, 13, 23 (6, count).
    real(wp), allocatable :: stress(:, :)
    real(wp), allocatable :: volume(:), initial_volume(:), weight(:)
    integer, allocatable :: body(:), material(:), plastic(:)
    !> Number of the cell in the whole grid.
    integer, allocatable :: cell(:)
    !> Point of the model that each is an image of.
    integer, allocatable :: origin(:)
    !> Signs of the components of its vectors against those of the origin (3, count).
    real(wp), allocatable :: sign(:, :)
  end type image_list_type

contains

  !> All points of the scene.
  pure subroutine make_images(expansion, points, cells, dimension, images)
    !> The way back.
    type(expansion_type), intent(in) :: expansion
    !> Points of the model, and the numbers of their cells in the whole grid (points).
    type(points_type), intent(in) :: points
    integer, intent(in) :: cells(:)
    !> Dimension of the model.
    integer, intent(in) :: dimension
    !> Points of the scene.
    type(image_list_type), intent(out) :: images
    type(image_list_type) :: before
    integer :: s

    call first_images(points, cells, dimension, images)
    do s = size(expansion%steps), 1, -1
      before = images
      select case (expansion%steps(s)%kind)
      case (reduce_prismatic)
        call undo_prismatic(expansion%steps(s), before, images)
      case (reduce_revolved)
        call undo_revolved(expansion%steps(s), before, images)
      case (reduce_column)
        call undo_column(expansion%steps(s), before, images)
      case (reduce_mirror)
        call undo_mirror(expansion%steps(s), before, images)
      end select
    end do
  end subroutine make_images

  !> The points of the model with all components.
  pure subroutine first_images(points, cells, dimension, images)
    !> Points of the model, and the numbers of their cells in the whole grid (points).
    type(points_type), intent(in) :: points
    integer, intent(in) :: cells(:)
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> The list.
    type(image_list_type), intent(out) :: images
    integer :: i

    call allocate_images(images, points%count)
    images%position(:dimension, :) = points%position
    images%initial_position(:dimension, :) = points%initial_position
    images%stress(:size(points%stress, 1), :) = points%stress
    images%volume = points%volume
    images%initial_volume = points%initial_volume
    images%weight = points%weight
    images%body = points%body
    images%material = points%material
    images%plastic = points%plastic
    images%cell = cells
    images%origin = [(i, i=1, points%count)]
  end subroutine first_images

  !> Allocate a list of points at the origin.
  pure subroutine allocate_images(images, count)
    !> The list.
    type(image_list_type), intent(out) :: images
    !> Number of points.
    integer, intent(in) :: count

    images%count = count
    allocate (images%position(3, count), images%initial_position(3, count), images%stress(6, count), source=0.0_wp)
    allocate (images%volume(count), images%initial_volume(count), images%weight(count), source=0.0_wp)
    allocate (images%body(count), images%material(count), images%plastic(count), images%cell(count), &
      images%origin(count), source=0)
    allocate (images%sign(3, count), source=1.0_wp)
  end subroutine allocate_images

  !> One point of a list into another, with a share of its volume.
  pure subroutine copy_image(from, i, share, to, k)
    !> The list it comes from, and its number there.
    type(image_list_type), intent(in) :: from
    integer, intent(in) :: i
    !> Volume over that of the point; a thickness makes a volume of an area.
    real(wp), intent(in) :: share
    !> The list it goes to, and its number there.
    type(image_list_type), intent(inout) :: to
    integer, intent(in) :: k

    to%position(:, k) = from%position(:, i)
    to%initial_position(:, k) = from%initial_position(:, i)
    to%stress(:, k) = from%stress(:, i)
    to%volume(k) = share*from%volume(i)
    to%initial_volume(k) = share*from%initial_volume(i)
    to%weight(k) = share*from%weight(i)
    to%body(k) = from%body(i)
    to%material(k) = from%material(i)
    to%plastic(k) = from%plastic(i)
    to%cell(k) = from%cell(i)
    to%origin(k) = from%origin(i)
    to%sign(:, k) = from%sign(:, i)
  end subroutine copy_image

  !> Place of a cell in its grid: piece of the brick, then brick along each axis, all from 0.
  pure function cell_place(cell, pieces, counts) result(place)
    !> Number of the cell, pieces of a brick, bricks along each axis.
    integer, intent(in) :: cell, pieces, counts(3)
    integer :: place(4)
    integer :: rest

    rest = cell - 1
    place(1) = mod(rest, pieces)
    rest = rest/pieces
    place(2) = mod(rest, counts(1))
    rest = rest/counts(1)
    place(3) = mod(rest, counts(2))
    place(4) = rest/counts(2)
  end function cell_place

  !> Number of the cell at a place.
  pure integer function cell_number(place, pieces, counts)
    !> As of `cell_place`.
    integer, intent(in) :: place(4), pieces, counts(3)

    cell_number = 1 + place(1) + pieces*(place(2) + counts(1)*(place(3) + counts(2)*place(4)))
  end function cell_number

  !> Bricks along each axis of a grid.
  pure function brick_counts(lines) result(counts)
    !> Grid lines; unallocated along z in the plane.
    type(axis_type), intent(in) :: lines(3)
    integer :: counts(3)
    integer :: a

    counts = 1
    do a = 1, 3
      if (allocated(lines(a)%lines)) counts(a) = size(lines(a)%lines) - 1
    end do
  end function brick_counts

  !> Layers through the thickness.
  pure subroutine undo_prismatic(step, flat, images)
    !> The step.
    type(reduction_type), intent(in) :: step
    !> Points of the plane.
    type(image_list_type), intent(in) :: flat
    !> Points of the scene.
    type(image_list_type), intent(out) :: images
    integer :: i, k, l, n, counts(3), place(4)
    real(wp) :: z

    counts = brick_counts(step%lines)
    n = 0
    do i = 1, flat%count
      n = n + counts(3)*size(step%layers(flat%body(i))%place)
    end do
    call allocate_images(images, n)
    n = 0
    associate (lines => step%lines(3)%lines)
      do i = 1, flat%count
        associate (layers => step%layers(flat%body(i)))
          place = cell_place(flat%cell(i), step%pieces, [counts(1:2), 1])
          do k = 1, counts(3)
            do l = 1, size(layers%place)
              n = n + 1
              z = lines(k) + layers%place(l)*(lines(k + 1) - lines(k))
              call copy_image(flat, i, layers%share(l)*(lines(k + 1) - lines(k)), images, n)
              images%position(3, n) = z
              images%initial_position(3, n) = z
              place(4) = k - 1
              images%cell(n) = cell_number(place, step%pieces, counts)
            end do
          end do
        end associate
      end do
    end associate
  end subroutine undo_prismatic

  !> Points around the axis, about as far from each other as they stand for in the half section.
  pure subroutine undo_revolved(step, flat, images)
    !> The step.
    type(reduction_type), intent(in) :: step
    !> Points of the half section, their volumes per radian.
    type(image_list_type), intent(in) :: flat
    !> Points of the scene.
    type(image_list_type), intent(out) :: images
    integer :: i, k, n, copies(flat%count), counts(3), place(4)
    real(wp) :: sector, angle

    sector = step%sector(2) - step%sector(1)
    counts = brick_counts(step%lines)
    do i = 1, flat%count
      associate (r => flat%initial_position(1, i))
        copies(i) = max(1, nint(sector*r/sqrt(flat%initial_volume(i)/r)))
      end associate
    end do
    call allocate_images(images, sum(copies))
    n = 0
    do i = 1, flat%count
      do k = 1, copies(i)
        n = n + 1
        angle = step%sector(1) + sector*(k - 0.5_wp)/copies(i)
        call copy_image(flat, i, sector/copies(i), images, n)
        call turn(step%centre, angle, images%position(:, n))
        call turn(step%centre, angle, images%initial_position(:, n))
        images%stress(:, n) = turned_stress(flat%stress(:, i), cos(angle), sin(angle))
        place = [0, interval(step%lines(1)%lines, images%position(1, n)), &
          interval(step%lines(2)%lines, images%position(2, n)), interval(step%lines(3)%lines, images%position(3, n))]
        images%cell(n) = cell_number(place, 1, counts)
      end do
    end do
  end subroutine undo_revolved

  !> Turn a place in the half section about the axis.
  pure subroutine turn(centre, angle, place)
    !> x and z of the axis, and the angle from x to z.
    real(wp), intent(in) :: centre(2), angle
    !> Radius and height in, place out (3).
    real(wp), intent(inout) :: place(3)

    place = [centre(1) + place(1)*cos(angle), place(2), centre(2) + place(1)*sin(angle)]
  end subroutine turn

  !> Stresses along x, y and z by those along radius, height and ring.
  pure function turned_stress(stress, c, s) result(turned)
    !> Radius, height, ring and the shear of the first two: 11, 22, 33, 12.
    real(wp), intent(in) :: stress(6)
    !> Cosine and sine of the angle from x to z.
    real(wp), intent(in) :: c, s
    real(wp) :: turned(6)

    turned = [c*c*stress(1) + s*s*stress(3), stress(2), s*s*stress(1) + c*c*stress(3), c*stress(4), &
      c*s*(stress(1) - stress(3)), s*stress(4)]
  end function turned_stress

  !> Interval of lines that holds a place, from 0.
  pure integer function interval(lines, x)
    !> Rising lines.
    real(wp), intent(in) :: lines(:)
    !> The place.
    real(wp), intent(in) :: x

    interval = max(0, min(size(lines) - 2, count(lines <= x) - 1))
  end function interval

  !> Columns beside each other. Nothing moves along x, so the column's places are those of all.
  pure subroutine undo_column(step, column, images)
    !> The step.
    type(reduction_type), intent(in) :: step
    !> Points of the column.
    type(image_list_type), intent(in) :: column
    !> Points of the scene.
    type(image_list_type), intent(out) :: images
    integer :: i, k, n, counts(3), place(4)
    real(wp) :: ratio

    counts = brick_counts(step%lines)
    call allocate_images(images, column%count*counts(1))
    n = 0
    associate (lines => step%lines(1)%lines)
      do i = 1, column%count
        place = cell_place(column%cell(i), step%pieces, [1, counts(2:3)])
        do k = 1, counts(1)
          n = n + 1
          ratio = (lines(k + 1) - lines(k))/(lines(2) - lines(1))
          call copy_image(column, i, ratio, images, n)
          images%position(1, n) = lines(k) + ratio*(column%position(1, i) - lines(1))
          images%initial_position(1, n) = lines(k) + ratio*(column%initial_position(1, i) - lines(1))
          place(2) = k - 1
          images%cell(n) = cell_number(place, step%pieces, counts)
        end do
      end do
    end associate
  end subroutine undo_column

  !> The half, and behind it its mirror image.
  pure subroutine undo_mirror(step, half, images)
    !> The step.
    type(reduction_type), intent(in) :: step
    !> Points of the half.
    type(image_list_type), intent(in) :: half
    !> Points of the scene.
    type(image_list_type), intent(out) :: images
    integer :: i, k, a, counts(3), half_counts(3), place(4)

    a = step%axis
    counts = brick_counts(step%lines)
    half_counts = counts
    half_counts(a) = counts(a)/2
    call allocate_images(images, 2*half%count)
    do i = 1, half%count
      place = cell_place(half%cell(i), step%pieces, half_counts)
      call copy_image(half, i, 1.0_wp, images, i)
      images%cell(i) = cell_number(place, step%pieces, counts)
      images%body(i) = step%body(half%body(i))
      k = half%count + i
      call copy_image(half, i, 1.0_wp, images, k)
      place(a + 1) = counts(a) - 1 - place(a + 1)
      images%cell(k) = cell_number(place, step%pieces, counts)
      images%body(k) = step%image_body(half%body(i))
      images%position(a, k) = 2.0_wp*step%plane - half%position(a, i)
      images%initial_position(a, k) = 2.0_wp*step%plane - half%initial_position(a, i)
      images%stress(5, k) = -half%stress(5, i)
      images%stress(merge(4, 6, a == 1), k) = -half%stress(merge(4, 6, a == 1), i)
      images%sign(a, k) = -half%sign(a, i)
    end do
  end subroutine undo_mirror

  !> The part of the scene's grid that a part of the model's grid is an image of.
  pure function window_of_scene(expansion, window) result(wide)
    !> The way back.
    type(expansion_type), intent(in) :: expansion
    !> The part of the model's grid.
    type(window_type), intent(in) :: window
    type(window_type) :: wide
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

  !> Place of the model that a place of the scene is an image of, and the signs of its vectors. What
  !> does not move is of sign 0.
  pure subroutine fold_place(expansion, place, sign)
    !> The way back.
    type(expansion_type), intent(in) :: expansion
    !> Place in the scene in, in the model out (3).
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
