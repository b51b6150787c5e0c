!> Where bodies of different stiffness meet, as a deck draws them.
!>
!> Across an interface the strain jumps. Functions that are smooth there cannot follow: splines need it to lie on lines
!> of the grid, where qsmpm_model_space makes them only continuous (docs/methods/bodies.md, "Layers").
module qsmpm_layer_interfaces
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: body_materials
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_body_description, only: body_type, body_box, body_polygon
  implicit none
  private

  public :: interface_type, find_interfaces

  !> Young's modulus over that of the neighbour from which an interface counts.
  real(wp), parameter :: least_ratio = 1.1_wp
  !> Places closer than this share of the grid are one.
  real(wp), parameter :: near_share = 1.0e-6_wp

  !> A straight piece on which two bodies meet.
  type :: interface_type
    integer :: bodies(2) = 0
    !> Young's modulus of the stiffer one over that of the other, the largest of all phases.
    real(wp) :: ratio = 1.0_wp
    !> Axis it is normal to, and the line of the grid that it lies on; 0 where it lies on none.
    integer :: axis = 0, line = 0
  end type interface_type

contains

  !> All interfaces of boxes and polygons. Of soil laws and models of the user no modulus is known, nor are outlines of
  !> other bodies.
  pure subroutine find_interfaces(analysis, found, contacts)
    type(analysis_type), intent(in) :: analysis
    type(interface_type), allocatable, intent(out) :: found(:)
    !> Whether bodies that are as stiff as each other, or of no known modulus, count too.
    logical, intent(in), optional :: contacts
    real(wp) :: least
    type(interface_type) :: between
    real(wp), allocatable :: young(:, :)
    integer :: a, b

    allocate (found(0))
    if (.not. (allocated(analysis%materials) .and. allocated(analysis%bodies) .and. allocated(analysis%phases))) return
    ! The grid of a deck with errors may have no lines.
    do a = 1, merge(3, 2, analysis%model == three_dimensional)
      if (.not. allocated(analysis%mesh%axes(a)%lines)) return
    end do
    least = least_ratio
    if (present(contacts)) least = merge(0.0_wp, least_ratio, contacts)
    call moduli(analysis, young)
    do a = 1, size(analysis%bodies)
      do b = a + 1, size(analysis%bodies)
        between%bodies = [a, b]
        between%ratio = max(0.0_wp, maxval(max(young(a, :), young(b, :))/max(min(young(a, :), young(b, :)), &
          tiny(1.0_wp)), mask=min(young(a, :), young(b, :)) > 0.0_wp))
        if (between%ratio >= least) call meet(analysis, between, found)
      end do
    end do
  end subroutine find_interfaces

  !> Young's modulus of each body as drawn and in each phase (bodies, phases + 1); 0 where it is not known.
  pure subroutine moduli(analysis, young)
    type(analysis_type), intent(in) :: analysis
    real(wp), allocatable, intent(out) :: young(:, :)
    integer :: number(size(analysis%bodies)), b, p

    allocate (young(size(analysis%bodies), size(analysis%phases) + 1), source=0.0_wp)
    do p = 0, size(analysis%phases)
      number = body_materials(analysis, p)
      do b = 1, size(number)
        if (number(b) > 0) young(b, p + 1) = analysis%materials(number(b))%young
      end do
    end do
  end subroutine moduli

  !> Add the pieces on which the edges of two bodies lie on each other.
  pure subroutine meet(analysis, between, found)
    type(analysis_type), intent(in) :: analysis
    !> The bodies and their ratio.
    type(interface_type), intent(in) :: between
    type(interface_type), allocatable, intent(inout) :: found(:)
    real(wp), allocatable :: one(:, :), other(:, :)
    real(wp) :: z(2, 2), near
    integer :: i, j, axis

    associate (first => analysis%bodies(between%bodies(1)), second => analysis%bodies(between%bodies(2)), &
      axes => analysis%mesh%axes)
      if (any([first%kind, second%kind] /= body_box .and. [first%kind, second%kind] /= body_polygon)) return
      allocate (one, source=corners(first))
      allocate (other, source=corners(second))
      near = near_share*(axes(1)%lines(size(axes(1)%lines)) - axes(1)%lines(1))
      if (analysis%model == three_dimensional) then
        z = 0.25_wp*reshape([-huge(near), -huge(near), huge(near), huge(near)], [2, 2])
        if (first%kind == body_box) z(1, :) = first%box(3, :)
        if (second%kind == body_box) z(2, :) = second%box(3, :)
        if (overlap(one(1, :), other(1, :)) > near .and. overlap(one(2, :), other(2, :)) > near) then
          if (abs(z(1, 2) - z(2, 1)) <= near) call add(between, 3, axes(3)%lines, z(1, 2), near, found)
          if (abs(z(1, 1) - z(2, 2)) <= near) call add(between, 3, axes(3)%lines, z(1, 1), near, found)
        end if
        if (.not. overlap(z(1, :), z(2, :)) > near) return
      end if
      do i = 1, size(one, 2)
        associate (p => one(:, i), q => one(:, modulo(i, size(one, 2)) + 1))
          do j = 1, size(other, 2)
            if (.not. lie_on(p, q, other(:, j), other(:, modulo(j, size(other, 2)) + 1), near)) cycle
            axis = minloc(abs(q - p), dim=1)
            if (abs(q(axis) - p(axis)) > near) then
              call add(between, 0, axes(1)%lines, 0.0_wp, near, found)
            else
              call add(between, axis, axes(axis)%lines, p(axis), near, found)
            end if
          end do
        end associate
      end do
    end associate
  end subroutine meet

  !> Whether two edges lie on each other along a piece.
  pure logical function lie_on(p, q, r, s, near)
    !> Ends of the one and of the other.
    real(wp), intent(in) :: p(2), q(2), r(2), s(2)
    !> Places that are closer are one.
    real(wp), intent(in) :: near
    real(wp) :: along(2), normal(2)

    lie_on = norm2(q - p) > near
    if (.not. lie_on) return
    along = (q - p)/norm2(q - p)
    normal = [-along(2), along(1)]
    lie_on = max(abs(dot_product(r - p, normal)), abs(dot_product(s - p, normal))) <= near .and. &
      overlap([0.0_wp, norm2(q - p)], [dot_product(r - p, along), dot_product(s - p, along)]) > near
  end function lie_on

  !> Add a piece normal to an axis, once for each line of the grid.
  pure subroutine add(between, axis, lines, x, near, found)
    !> The bodies and their ratio.
    type(interface_type), intent(in) :: between
    !> Axis, 0 for none, its lines and the place on it.
    integer, intent(in) :: axis
    real(wp), intent(in) :: lines(:), x, near
    type(interface_type), allocatable, intent(inout) :: found(:)
    type(interface_type) :: piece

    piece = between
    if (axis > 0) piece%line = minloc(abs(lines - x), dim=1)
    if (piece%line > 0) then
      if (abs(lines(piece%line) - x) <= near) then
        piece%axis = axis
      else
        piece%line = 0
      end if
    end if
    if (any(found%bodies(1) == piece%bodies(1) .and. found%bodies(2) == piece%bodies(2) .and. &
      found%axis == piece%axis .and. found%line == piece%line)) return
    found = [found, piece]
  end subroutine add

  !> Corners of a box or polygon in the x-y plane.
  pure function corners(body) result(at)
    type(body_type), intent(in) :: body
    real(wp), allocatable :: at(:, :)

    if (body%kind == body_polygon) then
      at = body%polygon
    else
      at = reshape([body%box(1, 1), body%box(2, 1), body%box(1, 2), body%box(2, 1), body%box(1, 2), body%box(2, 2), &
        body%box(1, 1), body%box(2, 2)], [2, 4])
    end if
  end function corners

  !> Length that two ranges have in common, negative where they lie apart.
  pure real(wp) function overlap(one, other)
    real(wp), intent(in) :: one(:), other(:)

    overlap = min(maxval(one), maxval(other)) - max(minval(one), minval(other))
  end function overlap
end module qsmpm_layer_interfaces
