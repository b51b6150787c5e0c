!> Outline of a rigid body in the plane, counter-clockwise: as places with lengths, in parts of equal length, and as
!> corners for plots.
!>
!> A rounded polygon is bounded by its edges and, at convex corners, by arcs about the vertices of its core; at concave
!> ones its edges meet in a point. A circle begins at its lowest point, a polygon in the middle of its first corner. The
!> first part is centred there, so that an axis of symmetry has half a part on both sides; longer parts would let soil
!> penetrate in the middle. A plane has no outline.
module qsmpm_rigid_outline
  use qsmpm_kinds, only: wp
  use qsmpm_rigid_shape, only: rigid_shape_type, edge_normal, kind_half_space, kind_ball, kind_polygon
  implicit none
  private

  public :: rigid_outline_type, lay_outline, outline_corners

  type :: rigid_outline_type
    integer :: count = 0
    !> Initial coordinates (2, places); length of each and number of its part (places).
    real(wp), allocatable :: place(:, :), length(:)
    integer, allocatable :: part(:)
  end type rigid_outline_type

  !> A straight piece or an arc.
  type :: piece_type
    !> Start of a straight piece or centre of an arc; direction, or radius and angle at the start.
    real(wp) :: start(2), aim(2), length
    logical :: straight
  end type piece_type

  real(wp), parameter :: pi = acos(-1.0_wp)
  !> Number of chords of a full circle in plots.
  integer, parameter :: drawn_chords = 64

contains

  !> Generates the places along the outline.
  pure subroutine lay_outline(shape, part_length, places_of_part, outline)
    type(rigid_shape_type), intent(in) :: shape
    !> Approximate length of a part: their number is a multiple of four.
    real(wp), intent(in) :: part_length
    integer, intent(in) :: places_of_part
    type(rigid_outline_type), intent(out) :: outline
    type(piece_type), allocatable :: pieces(:)
    real(wp) :: total
    integer :: i, parts

    call find_pieces(shape, pieces)
    total = sum(pieces%length)
    parts = 0
    if (total > 0.0_wp) parts = max(4, 4*nint(0.25_wp*total/part_length))
    outline%count = parts*places_of_part
    allocate (outline%place(2, outline%count), outline%length(outline%count), outline%part(outline%count))
    do i = 1, outline%count
      outline%length(i) = total/outline%count
      outline%part(i) = modulo((i - 1 + places_of_part/2)/places_of_part, parts) + 1
      outline%place(:, i) = place_along(pieces, (i - 0.5_wp)*outline%length(i))
    end do
  end subroutine lay_outline

  !> Returns the corners of the outline, arcs as chords; for a plane two points at distance `reach` on both sides of its
  !> point, with the body to the left.
  pure function outline_corners(shape, reach, chords_of_circle) result(corners)
    type(rigid_shape_type), intent(in) :: shape
    real(wp), intent(in) :: reach
    !> Number of chords of a full circle; by default that of plots.
    integer, intent(in), optional :: chords_of_circle
    !> (2,n)
    real(wp), allocatable :: corners(:, :)
    type(piece_type), allocatable :: pieces(:)
    real(wp) :: part
    integer :: k, i, chords, of_circle

    of_circle = drawn_chords
    if (present(chords_of_circle)) of_circle = chords_of_circle
    allocate (corners(2, 0))
    if (shape%kind == kind_half_space) then
      call add_corner(shape%place(:2) + reach*[shape%normal(2), -shape%normal(1)])
      call add_corner(shape%place(:2) - reach*[shape%normal(2), -shape%normal(1)])
      return
    end if
    call find_pieces(shape, pieces)
    part = 0.0_wp
    do k = 1, size(pieces)
      chords = 1
      if (.not. pieces(k)%straight) chords = max(1, nint(of_circle*pieces(k)%length/(2.0_wp*pi*pieces(k)%aim(1))))
      do i = 0, chords - 1
        call add_corner(place_along(pieces, part + i*pieces(k)%length/chords))
      end do
      part = part + pieces(k)%length
    end do

  contains

    pure subroutine add_corner(x)
      real(wp), intent(in) :: x(2)

      corners = reshape([corners, x], [2, size(corners, 2) + 1])
    end subroutine add_corner
  end function outline_corners

  !> Returns the pieces of an outline; none for a plane.
  pure subroutine find_pieces(shape, pieces)
    type(rigid_shape_type), intent(in) :: shape
    type(piece_type), allocatable, intent(out) :: pieces(:)

    allocate (pieces(0))
    select case (shape%kind)
    case (kind_ball)
      call add_arc(pieces, shape%place(:2), shape%radius, -0.5_wp*pi, 2.0_wp*pi)
    case (kind_polygon)
      call add_polygon(shape%core, shape%radius, pieces)
    end select
  end subroutine find_pieces

  !> Appends edges and arcs of a rounded polygon.
  pure subroutine add_polygon(core, round, pieces)
    !> (2, vertices)
    real(wp), intent(in) :: core(:, :), round
    type(piece_type), allocatable, intent(inout) :: pieces(:)
    real(wp), dimension(2, size(core, 2)) :: normal, from, to
    real(wp) :: turn(size(core, 2)), at_start(size(core, 2)), before(2)
    integer :: i, n, next

    n = size(core, 2)
    do i = 1, n
      normal(:, i) = edge_normal(core(:, i), core(:, modulo(i, n) + 1))
    end do
    do i = 1, n
      before = normal(:, modulo(i - 2, n) + 1)
      at_start(i) = atan2(before(2), before(1))
      turn(i) = atan2(before(1)*normal(2, i) - before(2)*normal(1, i), dot_product(before, normal(:, i)))
      from(:, i) = core(:, i) + round*normal(:, i)
      to(:, i) = core(:, i) + round*before
      if (turn(i) >= 0.0_wp) cycle
      from(:, i) = core(:, i) + round*(before + normal(:, i))/(1.0_wp + dot_product(before, normal(:, i)))
      to(:, i) = from(:, i)
    end do
    call add_arc(pieces, core(:, 1), round, at_start(1) + 0.5_wp*turn(1), 0.5_wp*turn(1))
    do i = 1, n
      next = modulo(i, n) + 1
      call add_line(pieces, from(:, i), to(:, next))
      if (next /= 1) call add_arc(pieces, core(:, next), round, at_start(next), turn(next))
    end do
    call add_arc(pieces, core(:, 1), round, at_start(1), 0.5_wp*turn(1))
  end subroutine add_polygon

  !> Appends a straight piece.
  pure subroutine add_line(pieces, from, to)
    type(piece_type), allocatable, intent(inout) :: pieces(:)
    real(wp), intent(in) :: from(2), to(2)

    if (.not. norm2(to - from) > 0.0_wp) return
    pieces = [pieces, piece_type(from, (to - from)/norm2(to - from), norm2(to - from), .true.)]
  end subroutine add_line

  !> Appends a counter-clockwise arc; none if it turns the other way.
  pure subroutine add_arc(pieces, centre, radius, angle, turn)
    type(piece_type), allocatable, intent(inout) :: pieces(:)
    real(wp), intent(in) :: centre(2), radius, angle, turn

    if (turn > 0.0_wp) pieces = [pieces, piece_type(centre, [radius, angle], radius*turn, .false.)]
  end subroutine add_arc

  !> Returns the place at a length along the pieces.
  pure function place_along(pieces, length) result(place)
    type(piece_type), intent(in) :: pieces(:)
    real(wp), intent(in) :: length
    real(wp) :: place(2), left
    integer :: k

    left = length
    do k = 1, size(pieces) - 1
      if (left <= pieces(k)%length) exit
      left = left - pieces(k)%length
    end do
    if (pieces(k)%straight) then
      place = pieces(k)%start + left*pieces(k)%aim
    else
      associate (radius => pieces(k)%aim(1), angle => pieces(k)%aim(2))
        place = pieces(k)%start + radius*[cos(angle + left/radius), sin(angle + left/radius)]
      end associate
    end if
  end function place_along
end module qsmpm_rigid_outline
