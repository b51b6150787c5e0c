!> Places where stress is singular and failure begins, as a deck draws them: corners at which soil turns inwards, as
!> the toe of a slope, the foot of a pit or the edge of a fill, and ends of what loads a face. Triangles that fit the
!> scene are smallest there: half of what a factor of safety is too high by goes, at the same cost
!> (docs/methods/fitted.md). Where nodes are pushed there are none: soil that follows an edge turns small cells inside
!> out, and the run cannot go on with splines then.
module qsmpm_singular_corners
  use qsmpm_active_bodies, only: bodies_active
  use qsmpm_analysis, only: analysis_type
  use qsmpm_kinds, only: wp
  use qsmpm_material_traits, only: may_yield
  use qsmpm_outline_graph, only: outline_type
  use qsmpm_polygon, only: polygon_contains
  implicit none
  private

  public :: singular_corners

  !> Directions that are looked into around a corner, how many lie in soil at the least where it turns inwards, by 20
  !> degrees, and the angle of the first: along no edge.
  integer, parameter :: directions = 72, inwards = 40
  real(wp), parameter :: turn = 0.0123_wp
  !> Sine of the angle up to which an outline goes straight on.
  real(wp), parameter :: straight = 0.17_wp
  !> How far they look, as a share of the smallest spacing of the grid.
  real(wp), parameter :: near = 1.0e-3_wp

contains

  !> Places in ground that can yield (2, n).
  pure function singular_corners(analysis, outlines, spacing) result(places)
    type(analysis_type), intent(in) :: analysis
    !> Those of bodies, whose region is their number, and places where sets and surfaces end.
    type(outline_type), intent(in) :: outlines(:)
    !> Smallest spacing of the grid.
    real(wp), intent(in) :: spacing
    real(wp), allocatable :: places(:, :)
    logical :: active(size(analysis%bodies)), found
    integer :: o, i, p

    allocate (places(2, 0))
    if (.not. any(may_yield(analysis%materials)) .or. pushes_nodes(analysis)) return
    do o = 1, size(outlines)
      do i = 1, size(outlines(o)%corner, 2)
        associate (corner => outlines(o)%corner(:, i))
          found = size(outlines(o)%corner, 2) == 1
          if (found) found = is_loaded(analysis, outlines(o)%name)
          do p = 1, size(analysis%phases)
            if (found .or. outlines(o)%region == 0) exit
            if (.not. bends(outlines(o)%corner, i)) exit
            active = bodies_active(analysis, p)
            found = turns_inwards(outlines, active, corner, near*spacing)
          end do
          if (found) places = reshape([places, corner], [2, size(places, 2) + 1])
        end associate
      end do
    end do
  end function singular_corners

  !> Whether an outline bends at a corner by more than a chord of a circle: what turns inwards has such a corner of some
  !> body, and an outline of thousands of corners has few.
  pure logical function bends(corners, i)
    real(wp), intent(in) :: corners(:, :)
    integer, intent(in) :: i
    real(wp) :: before(2), behind(2)
    integer :: n

    n = size(corners, 2)
    before = corners(:, i) - corners(:, modulo(i - 2, n) + 1)
    behind = corners(:, modulo(i, n) + 1) - corners(:, i)
    bends = abs(before(1)*behind(2) - before(2)*behind(1)) > straight*norm2(before)*norm2(behind) &
      .or. dot_product(before, behind) < 0.0_wp
  end function bends

  !> Whether more than a half of what is around a corner is soil, and not all.
  pure logical function turns_inwards(outlines, active, corner, radius)
    type(outline_type), intent(in) :: outlines(:)
    !> Bodies that are there.
    logical, intent(in) :: active(:)
    real(wp), intent(in) :: corner(2), radius
    real(wp) :: angle
    integer :: k, o, full
    logical :: soil

    full = 0
    do k = 1, directions
      angle = turn + 8.0_wp*atan(1.0_wp)*k/directions
      soil = .false.
      do o = 1, size(outlines)
        if (outlines(o)%region == 0) cycle
        ! A body covers those that are drawn before it.
        if (polygon_contains(outlines(o)%corner, corner + radius*[cos(angle), sin(angle)])) &
          soil = active(outlines(o)%region)
      end do
      if (soil) full = full + 1
    end do
    turns_inwards = full >= inwards .and. full < directions
  end function turns_inwards

  !> Whether a phase prescribes a displacement.
  pure logical function pushes_nodes(analysis)
    type(analysis_type), intent(in) :: analysis
    integer :: p

    pushes_nodes = .false.
    do p = 1, size(analysis%phases)
      pushes_nodes = pushes_nodes .or. any(abs(analysis%phases(p)%prescriptions%value) > 0.0_wp)
    end do
  end function pushes_nodes

  !> Whether a phase loads the surface of a name.
  pure logical function is_loaded(analysis, name) result(loaded)
    type(analysis_type), intent(in) :: analysis
    character(len=*), intent(in) :: name
    integer :: p, i

    loaded = .false.
    do p = 1, size(analysis%phases)
      associate (phase => analysis%phases(p))
        loaded = loaded .or. any([(phase%tractions(i)%surface == name .and. .not. phase%tractions(i)%of_water, &
          i=1, size(phase%tractions))])
      end associate
    end do
  end function is_loaded
end module qsmpm_singular_corners
