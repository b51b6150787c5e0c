!> Water levels of a state as lines for pictures: between the ends of the mesh, or of the body to which they belong.
module qsmpm_water_lines
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: initial_keep
  use qsmpm_model, only: model_type
  use qsmpm_phase_tree, only: lineage
  use qsmpm_pore_water, only: dry_tables, has_water, take_levels
  use qsmpm_team, only: largest, smallest
  use qsmpm_water_table, only: head_at, level_at, water_table_type
  implicit none
  private

  public :: water_line_type, water_lines

  !> Maximum number of locations across and along the vertical at which a seepage field is evaluated.
  integer, parameter :: most_stations = 200

  type :: water_line_type
    !> Number of the body, 0 for all without a level of their own.
    integer :: body = 0
    !> Vertices in 3D, the third coordinate is 0 (3,n).
    real(wp), allocatable :: corners(:, :)
  end type water_line_type

contains

  !> Returns the water levels at the current load: interpolated between those of the previous phase and those of the
  !> phase; a new or removed level is not interpolated.
  subroutine water_lines(model, lines)
    type(model_type), intent(in) :: model
    !> Unallocated on entry.
    type(water_line_type), allocatable, intent(inout) :: lines(:)
    type(water_table_type), allocatable :: start(:), final(:)
    integer, allocatable :: path(:)
    integer :: i, b
    logical :: all_told

    allocate (lines(0))
    if (model%state%progress%phase < 1) return
    if (.not. allocated(model%analysis%phases(1)%water_levels)) return
    if (.not. has_water(model%analysis)) return
    call dry_tables(model%analysis, final)
    allocate (path, source=lineage(model%analysis%phases, model%state%progress%phase))
    do i = 1, size(path)
      associate (phase => model%analysis%phases(path(i)))
        start = final
        call take_levels(model%analysis, phase, final)
        if (phase%initial%kind /= initial_keep) start = final
      end associate
    end do
    all_told = .false.
    do b = 1, size(final)
      if (all_told .and. .not. (start(b)%own .or. final(b)%own)) cycle
      call add_line(model, b, start(b), final(b), lines)
      all_told = all_told .or. .not. (start(b)%own .or. final(b)%own)
    end do
  end subroutine water_lines

  !> Adds the level of a body, or of all bodies without a level of their own.
  subroutine add_line(model, body, start, final, lines)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    type(water_table_type), intent(in) :: start, final
    type(water_line_type), allocatable, intent(inout) :: lines(:)
    type(water_line_type) :: line
    real(wp), allocatable :: x(:)
    real(wp) :: ends(2), height
    integer :: i

    associate (share => model%state%progress%fraction)
      if (is_flow_in_space(start) .or. is_flow_in_space(final)) return
      if (.not. (final%present .or. (start%present .and. share < 1.0_wp))) return
      line%body = merge(body, 0, start%own .or. final%own)
      ends = ends_of(model, line%body, final%across)
      if (ends(2) < ends(1)) return
      allocate (x(0))
      if (start%present) x = stations(start)
      if (final%present) x = [x, stations(final)]
      call sort_within(ends, x)
      allocate (line%corners(3, size(x)), source=0.0_wp)
      do i = 1, size(x)
        line%corners(final%across, i) = x(i)
        ! Height of the level at a location.
        if (start%present .and. final%present) then
          height = (1.0_wp - share)*surface_at(start, line%corners(:, i)) + share*surface_at(final, line%corners(:, i))
        else if (final%present) then
          height = surface_at(final, line%corners(:, i))
        else
          height = surface_at(start, line%corners(:, i))
        end if
        line%corners(final%axis, i) = height
      end do
    end associate
    lines = [lines, line]
  end subroutine add_line

  !> Returns whether there is seepage in 3D, whose surface is not a line.
  pure logical function is_flow_in_space(table) result(yes)
    type(water_table_type), intent(in) :: table

    yes = allocated(table%field)
    if (yes) yes = size(table%field%position, 1) == 3
  end function is_flow_in_space

  !> Returns the locations at which a level is evaluated: its vertices, or stations across a seepage field.
  pure function stations(table) result(x)
    type(water_table_type), intent(in) :: table
    real(wp), allocatable :: x(:)
    integer :: i

    x = table%x
    if (.not. allocated(table%field)) return
    associate (low => minval(table%field%position(table%across, :)), &
        high => maxval(table%field%position(table%across, :)))
      x = [(low + (high - low)*i/most_stations, i=0, most_stations)]
    end associate
  end function stations

  !> Returns the height of the level; for seepage the highest location of zero pressure, searched from above at as many
  !> stations.
  pure real(wp) function surface_at(table, place) result(height)
    type(water_table_type), intent(in) :: table
    real(wp), intent(in) :: place(3)
    real(wp) :: at(3), ends(2)
    integer :: i

    if (.not. allocated(table%field)) then
      height = level_at(table, place)
      return
    end if
    ends = [minval(table%field%position(table%axis, :)), maxval(table%field%position(table%axis, :))]
    if (table%up < 0.0_wp) ends = ends([2, 1])
    at = place
    do i = most_stations, 0, -1
      at(table%axis) = ends(1) + (ends(2) - ends(1))*i/most_stations
      if (head_at(table, at) > 0.0_wp) exit
    end do
    height = at(table%axis) + table%up*head_at(table, at)
  end function surface_at

  !> Returns the ends of the mesh along an axis, or of the points of a body, over all processes if the model is
  !> divided.
  function ends_of(model, body, axis) result(ends)
    type(model_type), intent(in) :: model
    !> Number of the body, 0 for the mesh.
    integer, intent(in) :: body, axis
    real(wp) :: ends(2)

    if (body == 0) then
      ends = [minval(model%state%coordinates(axis, :)), maxval(model%state%coordinates(axis, :))]
    else
      associate (points => model%state%points)
        ends = [minval(points%position(axis, :), mask=points%body == body), &
          maxval(points%position(axis, :), mask=points%body == body)]
      end associate
    end if
    ends = [smallest(model%part%team, ends(1)), largest(model%part%team, ends(2))]
  end function ends_of

  !> Returns the ends and the numbers between them, ascending and each once.
  pure subroutine sort_within(ends, x)
    real(wp), intent(in) :: ends(2)
    real(wp), allocatable, intent(inout) :: x(:)
    real(wp) :: sorted(size(x) + 2)
    integer :: n

    sorted(1) = ends(1)
    n = 1
    do while (any(x > sorted(n) .and. x < ends(2)))
      sorted(n + 1) = minval(x, mask=x > sorted(n))
      n = n + 1
    end do
    sorted(n + 1) = ends(2)
    deallocate (x)
    allocate (x, source=sorted(:n + 1))
  end subroutine sort_within
end module qsmpm_water_lines
