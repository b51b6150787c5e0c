!> Feet of the bodies that are not there at the start (qsmpm_inactive_points), one for every vertical line on which
!> points, surface points and tracers of such a body lie, and the bodies that tracers belong to. All is found from the
!> drawings, when the model is built.
module qsmpm_body_feet
  use qsmpm_kinds, only: wp, long
  use qsmpm_active_bodies, only: bodies_active, has_stages
  use qsmpm_mesh_search, only: locate, inverse_map
  use qsmpm_model, only: model_type
  use qsmpm_own_marks, only: nearest_numbers, place_of_number
  use qsmpm_overburden, only: overburden_type, make_overburden
  use qsmpm_points, only: allocate_carried
  use qsmpm_vertical, only: vertical_of
  use qsmpm_polyhedron, only: find_crossings
  use qsmpm_sorting, only: order_columns
  use qsmpm_team, only: total
  implicit none
  private

  public :: find_tracer_bodies, body_to_follow, plant_feet

  !> Lines nearer than this share of a cell are one; bodies whose bounds are so near touch.
  real(wp), parameter :: same_line = 1.0e-4_wp, touching = 1.0e-3_wp
  !> Share of the way to the middle of a body by which its outermost lines are moved inwards, and a place along z
  !> between the caps of a plane body that no edge of their triangles has.
  real(wp), parameter :: inwards = 1.0e-6_wp, between_caps = 0.0123_wp

contains

  !> All bodies as vertical lines see them; their weight does not matter.
  pure subroutine see_bodies(model, seen)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(out) :: seen
    real(wp) :: nothing(size(model%shapes))

    nothing = 0.0_wp
    call make_overburden(model%mesh, model%shapes, nothing, vertical_of(model%analysis), seen)
  end subroutine see_bodies

  !> Heights at which the vertical line through a place, moved by `inwards`, crosses the bounds of a body.
  pure subroutine heights_of(seen, body, place, heights, side)
    type(overburden_type), intent(in) :: seen
    integer, intent(in) :: body
    !> (dimension)
    real(wp), intent(in) :: place(:)
    real(wp), allocatable, intent(out) :: heights(:)
    !> Towards which side it is moved, -1 or 1; towards the middle of the body when not given.
    integer, intent(in), optional :: side
    logical, allocatable :: looks_up(:)
    real(wp) :: x(3), line(2)

    x = between_caps
    x(:size(place)) = place
    line = x([mod(seen%axis, 3) + 1, mod(seen%axis + 1, 3) + 1])
    associate (solid => seen%solid(body))
      if (present(side)) then
        line = line + side*inwards*(solid%high(:2) - solid%low(:2))
      else
        line = line + inwards*(0.5_wp*(solid%low(:2) + solid%high(:2)) - line)
      end if
      call find_crossings(solid, line, heights, looks_up)
    end associate
  end subroutine heights_of

  !> Whether a body, crossed at some heights, holds another height or ends there.
  pure logical function reaches(heights, height, slack)
    real(wp), intent(in) :: heights(:), height, slack

    reaches = any(abs(heights - height) <= slack) .or. mod(count(heights < height), 2) == 1
  end function reaches

  !> Body of every tracer: that of its outline, else the one to follow from its place, else that of the nearest point.
  subroutine find_tracer_bodies(model)
    type(model_type), intent(inout) :: model
    type(overburden_type) :: seen
    integer :: i, k

    allocate (model%tracer_body(model%state%tracers%count), model%tracer_foot(model%state%tracers%count), source=0)
    do k = 1, size(model%outlines)
      associate (outline => model%outlines(k))
        model%tracer_body(outline%before + 1:outline%before + outline%count) = outline%body
      end associate
    end do
    call see_bodies(model, seen)
    do i = 1, model%state%tracers%count
      if (model%tracer_body(i) == 0) model%tracer_body(i) = longest_there(model, seen, &
        model%state%tracers%position(:, i))
      if (model%tracer_body(i) == 0) model%tracer_body(i) = nearest_body(model, model%state%tracers%position(:, i))
    end do
  end subroutine find_tracer_bodies

  !> Body that a history at a place follows where bodies come and go; 0 for any: none holds the place, or none comes or
  !> goes.
  pure integer function body_to_follow(model, place) result(body)
    type(model_type), intent(in) :: model
    !> (dimension)
    real(wp), intent(in) :: place(:)
    type(overburden_type) :: seen

    body = 0
    if (.not. has_stages(model%analysis)) return
    call see_bodies(model, seen)
    body = longest_there(model, seen, place)
  end function body_to_follow

  !> Of the bodies that hold a place, or end there, the one that is there in most phases, the start among them; 0 where
  !> none holds it.
  pure integer function longest_there(model, seen, place) result(body)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: seen
    !> (dimension)
    real(wp), intent(in) :: place(:)
    integer :: phases(size(model%shapes)), most, p, b

    phases = 0
    do p = 0, size(model%analysis%phases)
      phases = phases + merge(1, 0, bodies_active(model%analysis, p))
    end do
    body = 0
    most = -1
    do b = 1, size(phases)
      if (phases(b) <= most) cycle
      if (.not. holds(seen, b, place, touching*model%cell_size)) cycle
      body = b
      most = phases(b)
    end do
  end function longest_there

  !> Whether a body holds a place or ends there: on an upright face its inner side tells, whichever that is.
  pure logical function holds(seen, body, place, slack)
    type(overburden_type), intent(in) :: seen
    integer, intent(in) :: body
    !> (dimension)
    real(wp), intent(in) :: place(:)
    real(wp), intent(in) :: slack
    real(wp), allocatable :: heights(:)
    integer :: side

    call heights_of(seen, body, place, heights)
    holds = reaches(heights, place(seen%axis), slack)
    do side = -1, 1, 2
      if (holds) return
      call heights_of(seen, body, place, heights, side)
      holds = reaches(heights, place(seen%axis), slack)
    end do
  end function holds

  !> Body of the material point that is nearest to a place.
  integer function nearest_body(model, place) result(body)
    type(model_type), intent(in) :: model
    !> (dimension)
    real(wp), intent(in) :: place(:)
    integer(long) :: number(1)
    integer :: p

    number = nearest_numbers(model, reshape(place, [size(place), 1]))
    p = place_of_number(model, number(1))
    body = 0
    if (p > 0) body = model%state%points%body(p)
    body = int(total(model%part%team, int(body, long)))
  end function nearest_body

  !> Feet under points, surface points and tracers of the bodies that are not there at the start.
  subroutine plant_feet(model)
    type(model_type), intent(inout) :: model
    integer, allocatable :: line(:, :), foot(:)
    real(wp), allocatable :: places(:, :)
    integer :: n, s, t

    associate (points => model%state%points, surface => model%state%surface, tracers => model%state%tracers)
      n = points%count
      s = surface%count
      t = tracers%count
      allocate (places(model%mesh%dimension, n + s + t), line(3, n + s + t))
      places(:, :n) = points%position
      places(:, n + 1:n + s) = surface%position
      places(:, n + s + 1:) = tracers%position
      line(1, :) = [points%body, surface%body, model%tracer_body]
      call number_lines(model, places, line)
      call set_feet(model, places, line, foot)
      points%foot = foot(:n)
      surface%foot = foot(n + 1:n + s)
      model%tracer_foot = foot(n + s + 1:)
    end associate
  end subroutine plant_feet

  !> Whole numbers for the horizontal coordinates: places on one line have the same.
  pure subroutine number_lines(model, places, line)
    type(model_type), intent(in) :: model
    !> (dimension, n)
    real(wp), intent(in) :: places(:, :)
    !> Body of each; gets the two coordinates (3, n).
    integer, intent(inout) :: line(:, :)
    integer :: a, k

    line(2:, :) = 0
    k = 1
    do a = 1, size(places, 1)
      if (a == vertical_of(model%analysis)) cycle
      k = k + 1
      line(k, :) = nint((places(a, :) - model%mesh%bounds(a, 1))/(same_line*model%cell_size))
    end do
  end subroutine number_lines

  !> A foot for every line of a body that comes.
  subroutine set_feet(model, places, line, foot)
    type(model_type), intent(inout) :: model
    !> (dimension, n)
    real(wp), intent(in) :: places(:, :)
    !> Body and line of each place (3, n).
    integer, intent(in) :: line(:, :)
    !> Foot of each place (n).
    integer, allocatable, intent(out) :: foot(:)
    type(overburden_type) :: seen
    real(wp), allocatable :: heights(:), bottom(:), top(:), at(:, :)
    integer, allocatable :: order(:), body(:)
    integer :: i, k, n

    call see_bodies(model, seen)
    allocate (order(size(line, 2)), bottom(size(line, 2)), top(size(line, 2)), body(size(line, 2)))
    allocate (foot(size(line, 2)), source=0)
    allocate (at, mold=places)
    call order_columns(line, order)
    n = 0
    do i = 1, size(order)
      k = order(i)
      if (model%analysis%bodies(line(1, k))%active) cycle
      if (n > 0) then
        if (all(line(:, k) == line(:, order(i - 1))) .and. foot(order(i - 1)) > 0) then
          foot(k) = n
          cycle
        end if
      end if
      call heights_of(seen, line(1, k), places(:, k), heights)
      if (size(heights) < 2) cycle
      n = n + 1
      foot(k) = n
      body(n) = line(1, k)
      bottom(n) = minval(heights)
      top(n) = maxval(heights)
      at(:, n) = places(:, k)
      at(seen%axis, n) = bottom(n)
    end do
    model%feet%axis = seen%axis
    model%feet%body = body(:n)
    model%feet%bottom = bottom(:n)
    model%feet%top = top(:n)
    call put_on_ground(model, seen, at(:, :n))
  end subroutine set_feet

  !> Put the feet in their cells, those of the ground below them, and find the bodies that they stand on.
  subroutine put_on_ground(model, seen, places)
    type(model_type), intent(inout) :: model
    type(overburden_type), intent(in) :: seen
    !> (dimension, feet)
    real(wp), intent(in) :: places(:, :)
    real(wp) :: below(size(places, 1))
    real(wp), allocatable :: heights(:)
    logical :: found
    integer :: i, b

    deallocate (model%state%inactive%feet%position, model%state%inactive%feet%initial_position, &
      model%state%inactive%feet%local, model%state%inactive%feet%cell, model%state%inactive%feet%number)
    call allocate_carried(model%state%inactive%feet, size(places, 1), size(places, 2))
    allocate (model%feet%on(size(model%shapes), size(places, 2)), source=.false.)
    associate (feet => model%state%inactive%feet)
      feet%position = places
      feet%initial_position = places
      do i = 1, feet%count
        below = places(:, i)
        below(seen%axis) = below(seen%axis) - touching*model%cell_size
        feet%cell(i) = model%state%points%cell(1)
        call locate(model%mesh, below, feet%cell(i), feet%local(:, i), found)
        if (.not. found) call locate(model%mesh, places(:, i), feet%cell(i), feet%local(:, i), found)
        if (found) call inverse_map(model%mesh, feet%cell(i), places(:, i), feet%local(:, i), found)
        do b = 1, size(model%shapes)
          if (b == model%feet%body(i)) cycle
          call heights_of(seen, b, places(:, i), heights)
          model%feet%on(b, i) = mod(count(heights < below(seen%axis)), 2) == 1
        end do
      end do
    end associate
  end subroutine put_on_ground
end module qsmpm_body_feet
