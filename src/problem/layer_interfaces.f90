!> Interfaces between bodies of different stiffness in the initial geometry.
!>
!> The strain is discontinuous across an interface, which smooth functions cannot represent: splines require the
!> interface to be on grid lines, where qsmpm_model_mesh reduces their continuity to C0 (docs/methods/bodies.md,
!> "Layers"). The module also identifies bodies weaker than those in contact with them and measures their thickness.
module qsmpm_layer_interfaces
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: body_materials
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_body_description, only: body_type, body_box, body_polygon
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_material_description, only: may_yield, traits_of
  implicit none
  private

  public :: interface_type, find_interfaces, thin_seam, is_weak, measure_body, corners, moduli

  !> Number of cells required across a weak body; ratio to the strength of the adjacent body below which it is weak.
  real(wp), parameter, public :: fewest_cells = 3.0_wp
  real(wp), parameter :: weak = 0.8_wp

  !> Minimum ratio of Young's moduli of an interface.
  real(wp), parameter :: least_ratio = 1.1_wp
  !> Points closer than this fraction of the grid are identical.
  real(wp), parameter :: near_share = 1.0e-6_wp

  !> Straight part of the boundary between two bodies.
  type :: interface_type
    integer :: bodies(2) = 0
    !> Ratio of the Young's modulus of the stiffer body to that of the other, maximum over the phases.
    real(wp) :: ratio = 1.0_wp
    !> Axis normal to the interface and grid line on which it is; 0 for none.
    integer :: axis = 0, line = 0
    !> Axis normal to the interface, also off the grid lines, and its coordinate there; 0 for none.
    integer :: normal = 0
    real(wp) :: place = 0.0_wp
  end type interface_type

contains

  !> Finds all interfaces between boxes and polygons. The moduli of soil laws and user models are unknown, as are the
  !> outlines of other bodies.
  pure subroutine find_interfaces(analysis, found, contacts)
    type(analysis_type), intent(in) :: analysis
    type(interface_type), allocatable, intent(out) :: found(:)
    !> Whether interfaces of bodies of equal stiffness, or of unknown modulus, are included.
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

  !> Returns Young's modulus of each body initially and in each phase (bodies, phases + 1); 0 where unknown.
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

  !> Adds the common parts of the edges of two bodies.
  pure subroutine meet(analysis, between, found)
    type(analysis_type), intent(in) :: analysis
    !> The bodies and their stiffness ratio.
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

  !> Returns whether two edges coincide along a part.
  pure logical function lie_on(p, q, r, s, near)
    !> End points of both edges.
    real(wp), intent(in) :: p(2), q(2), r(2), s(2)
    !> Points closer than this are identical.
    real(wp), intent(in) :: near
    real(wp) :: along(2), normal(2)

    lie_on = norm2(q - p) > near
    if (.not. lie_on) return
    along = (q - p)/norm2(q - p)
    normal = [-along(2), along(1)]
    lie_on = max(abs(dot_product(r - p, normal)), abs(dot_product(s - p, normal))) <= near .and. &
      overlap([0.0_wp, norm2(q - p)], [dot_product(r - p, along), dot_product(s - p, along)]) > near
  end function lie_on

  !> Adds an interface normal to an axis, once for each grid line.
  pure subroutine add(between, axis, lines, x, near, found)
    !> The bodies and their stiffness ratio.
    type(interface_type), intent(in) :: between
    !> Axis (0 for none), its lines and the coordinate.
    integer, intent(in) :: axis
    real(wp), intent(in) :: lines(:), x, near
    type(interface_type), allocatable, intent(inout) :: found(:)
    type(interface_type) :: piece

    piece = between
    piece%normal = axis
    piece%place = x
    if (axis > 0) piece%line = minloc(abs(lines - x), dim=1)
    if (piece%line > 0) then
      if (abs(lines(piece%line) - x) <= near) then
        piece%axis = axis
      else
        piece%line = 0
      end if
    end if
    if (any(found%bodies(1) == piece%bodies(1) .and. found%bodies(2) == piece%bodies(2) .and. &
      found%normal == piece%normal .and. abs(found%place - piece%place) <= near)) return
    found = [found, piece]
  end subroutine add

  !> Returns the corners of a box or polygon in the x-y plane.
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

  !> Returns the length of the overlap of two ranges, negative if they are separate.
  pure real(wp) function overlap(one, other)
    real(wp), intent(in) :: one(:), other(:)

    overlap = min(maxval(one), maxval(other)) - max(minval(one), minval(other))
  end function overlap

  !> Returns a body that is weaker than those in contact with it and too thin for the grid, 0 for none.
  pure integer function thin_seam(analysis) result(seam)
    type(analysis_type), intent(in) :: analysis
    type(interface_type), allocatable :: found(:)
    real(wp) :: thick, long, cell, normal(3)
    integer :: i, k

    call find_interfaces(analysis, found, contacts=.true.)
    do i = 1, size(found)
      do k = 1, 2
        seam = found(i)%bodies(k)
        if (.not. is_weak(analysis, found, seam, found(i)%bodies(3 - k))) cycle
        call measure_body(analysis, analysis%bodies(seam), thick, long, cell, normal)
        if (thick < (1.0_wp - near_share)*fewest_cells*cell) return
      end do
    end do
    seam = 0
  end function thin_seam

  !> Returns whether a body is weaker than another one, or is between bodies that are all stronger or cannot yield:
  !> soil next to a single wall is not weak for that reason.
  pure logical function is_weak(analysis, found, b, other) result(weak_there)
    type(analysis_type), intent(in) :: analysis
    !> The interfaces.
    type(interface_type), intent(in) :: found(:)
    integer, intent(in) :: b, other
    integer :: i, beside
    logical :: touched(size(analysis%bodies))

    weak_there = is_weaker(analysis, b, other)
    if (weak_there .or. .not. may_fail(analysis, b)) return
    touched = .false.
    do i = 1, size(found)
      if (all(found(i)%bodies /= b)) cycle
      beside = sum(found(i)%bodies) - b
      if (may_fail(analysis, beside) .and. .not. is_weaker(analysis, b, beside)) return
      touched(beside) = .true.
    end do
    weak_there = count(touched) > 1
  end function is_weak

  !> Returns whether the initial material of a body, or that in a phase, can yield.
  pure logical function may_fail(analysis, b)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: b
    integer :: number(size(analysis%bodies)), p

    may_fail = .false.
    do p = 0, size(analysis%phases)
      number = body_materials(analysis, p)
      if (number(b) > 0) may_fail = may_fail .or. may_yield(analysis%materials(number(b)))
    end do
  end function may_fail

  !> Returns whether a body is weaker than another one initially or in a phase.
  pure logical function is_weaker(analysis, b, other)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: b, other
    type(law_description_type) :: mine, its
    integer :: number(size(analysis%bodies)), p

    is_weaker = .false.
    do p = 0, size(analysis%phases)
      number = body_materials(analysis, p)
      if (min(number(b), number(other)) == 0) cycle
      mine = traits_of(analysis%materials(number(b)))
      its = traits_of(analysis%materials(number(other)))
      if (.not. (mine%has_strength .and. its%has_strength)) cycle
      is_weaker = is_weaker .or. (mine%cohesion <= its%cohesion .and. mine%friction_angle <= its%friction_angle .and. &
        (mine%cohesion < weak*its%cohesion .or. mine%friction_angle < weak*its%friction_angle))
    end do
  end function is_weaker

  !> Returns thickness and length of a body, which are the sides of a rectangle of equal area and perimeter, and the
  !> cell size across it.
  pure subroutine measure_body(analysis, body, thick, long, cell, normal)
    type(analysis_type), intent(in) :: analysis
    type(body_type), intent(in) :: body
    real(wp), intent(out) :: thick, long, cell
    !> Unit vector in the thickness direction.
    real(wp), intent(out) :: normal(3)
    real(wp), allocatable :: edges(:, :), lengths(:)
    real(wp) :: area, around, longest(2), bounds(3, 2)
    integer :: i, n, axis

    associate (axes => analysis%mesh%axes)
      bounds = body%box
      normal = 0.0_wp
      if (body%kind == body_box) then
        n = merge(3, 2, analysis%model == three_dimensional)
        axis = minloc(bounds(:n, 2) - bounds(:n, 1), dim=1)
        thick = bounds(axis, 2) - bounds(axis, 1)
        long = maxval(bounds(:n, 2) - bounds(:n, 1))
        cell = size_between(axes(axis)%lines, bounds(axis, :))
        normal(axis) = 1.0_wp
        return
      end if
      edges = cshift(body%polygon, 1, dim=2) - body%polygon
      lengths = [(norm2(edges(:, i)), i=1, size(edges, 2))]
      around = sum(lengths)
      longest = edges(:, maxloc(lengths, dim=1))
      associate (x => body%polygon(1, :), y => body%polygon(2, :))
        area = 0.5_wp*sum(x*cshift(y, 1) - cshift(x, 1)*y)
      end associate
      thick = around/4.0_wp - sqrt(max(0.0_wp, (around/4.0_wp)**2 - abs(area)))
      long = around/2.0_wp - thick
      longest = longest/norm2(longest)
      normal(:2) = [-longest(2), longest(1)]
      bounds(:2, 1) = minval(body%polygon, dim=2)
      bounds(:2, 2) = maxval(body%polygon, dim=2)
      cell = abs(longest(2))*size_between(axes(1)%lines, bounds(1, :)) + abs(longest(1))*size_between(axes(2)%lines, &
        bounds(2, :))
    end associate
  end subroutine measure_body

  !> Returns the mean size of the cells in a range of an axis.
  pure real(wp) function size_between(lines, range)
    real(wp), intent(in) :: lines(:), range(2)
    integer :: low, high, n
    real(wp) :: near

    n = size(lines)
    near = 1.0e-6_wp*(lines(n) - lines(1))
    low = max(1, min(n - 1, count(lines <= range(1) + near)))
    high = max(low + 1, min(n, 1 + count(lines < range(2) - near)))
    size_between = (lines(high) - lines(low))/real(high - low, wp)
  end function size_between
end module qsmpm_layer_interfaces
