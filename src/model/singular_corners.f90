!> Places where stress is singular and failure begins, as a deck draws them: corners at which soil turns inwards, as
!> the toe of a slope, the foot of a pit or the edge of a fill, and ends of what loads a face. Triangles that fit the
!> scene are smallest there: half of what a factor of safety is too high by goes, at the same cost
!> (docs/methods/fitted.md). Where nodes are pushed they are two to four times as wide as the way that these go: soil
!> that follows an edge turns smaller cells inside out, and the run cannot go on with splines then. Beside an edge in
!> soil of friction that hardly carries the weight of a cell there is a surface without strength: there are none. And
!> nowhere are they smaller than what ground of that stiffness settles under its own weight, or four times as much under
!> what presses on it.
module qsmpm_singular_corners
  use qsmpm_active_bodies, only: bodies_active
  use qsmpm_analysis, only: analysis_type
  use qsmpm_kinds, only: wp
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_material_traits, only: may_yield, traits_of
  use qsmpm_material_description, only: material_type
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
  !> Ways of nodes that are pushed in the width of a cell beside them, at the most; half as many at the least.
  real(wp), parameter :: ways_of_cell = 4.0_wp
  !> Cohesion over the weight of a cell, from which the surface beside an edge that is pushed in stands.
  real(wp), parameter :: weights_of_cell = 2.0_wp

contains

  !> Places in ground that can yield, and how wide cells may be there, 0 for as small as they come (3, n).
  pure function singular_corners(analysis, outlines, spacing) result(places)
    type(analysis_type), intent(in) :: analysis
    !> Those of bodies, whose region is their number, and places where sets and surfaces end.
    type(outline_type), intent(in) :: outlines(:)
    !> Smallest spacing of the grid.
    real(wp), intent(in) :: spacing
    real(wp), allocatable :: places(:, :)
    logical :: active(size(analysis%bodies)), found
    real(wp) :: width
    integer :: o, i, p

    allocate (places(3, 0))
    width = ways_of_cell*way_of_nodes(analysis)
    if (.not. any(may_yield(analysis%materials)) .or. width >= spacing) return
    if (width > 0.0_wp .and. .not. all(stands(analysis%materials, spacing))) return
    width = max(width, maxval(own_settlement(analysis%materials, depth_of(outlines), largest_load(analysis))))
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
          if (found) places = reshape([places, corner, width], [3, size(places, 2) + 1])
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

  !> Whether the surface of a material has a strength of its own.
  elemental logical function stands(material, spacing)
    type(material_type), intent(in) :: material
    real(wp), intent(in) :: spacing
    type(law_description_type) :: traits

    traits = traits_of(material)
    stands = .not. traits%friction_angle > 0.0_wp .or. traits%cohesion >= weights_of_cell*material%unit_weight*spacing
  end function stands

  !> What a layer of a soil that can yield settles under its own weight, g D^2/(2 E), or four times q D/E under a load;
  !> 0 where its law has no E.
  elemental real(wp) function own_settlement(material, depth, load) result(settlement)
    type(material_type), intent(in) :: material
    real(wp), intent(in) :: depth, load

    settlement = 0.0_wp
    if (may_yield(material) .and. material%young > 0.0_wp) &
      settlement = max(0.5_wp*material%unit_weight*depth, ways_of_cell*load)*depth/material%young
  end function own_settlement

  !> The smaller extent of what the bodies fill: ground is wider than deep, whatever way is down.
  pure real(wp) function depth_of(outlines) result(depth)
    type(outline_type), intent(in) :: outlines(:)
    real(wp) :: low(2), high(2)
    integer :: o

    low = huge(low)
    high = -huge(high)
    do o = 1, size(outlines)
      if (outlines(o)%region == 0) cycle
      low = min(low, minval(outlines(o)%corner, dim=2))
      high = max(high, maxval(outlines(o)%corner, dim=2))
    end do
    depth = max(0.0_wp, minval(high - low))
  end function depth_of

  !> The largest load on a face.
  pure real(wp) function largest_load(analysis) result(load)
    type(analysis_type), intent(in) :: analysis
    integer :: p, i

    load = 0.0_wp
    do p = 1, size(analysis%phases)
      associate (phase => analysis%phases(p))
        do i = 1, size(phase%tractions)
          load = max(load, abs(phase%load_factor)*max(norm2(phase%tractions(i)%vector), &
            abs(phase%tractions(i)%pressure)))
        end do
      end associate
    end do
  end function largest_load

  !> How far phases push nodes in all.
  pure real(wp) function way_of_nodes(analysis) result(way)
    type(analysis_type), intent(in) :: analysis
    integer :: p

    way = 0.0_wp
    do p = 1, size(analysis%phases)
      way = way + maxval([0.0_wp, abs(analysis%phases(p)%load_factor*analysis%phases(p)%prescriptions%value)])
    end do
  end function way_of_nodes

  !> Whether a phase loads the surface of a name, or pushes the set.
  pure logical function is_loaded(analysis, name) result(loaded)
    type(analysis_type), intent(in) :: analysis
    character(len=*), intent(in) :: name
    integer :: p, i

    loaded = .false.
    do p = 1, size(analysis%phases)
      associate (phase => analysis%phases(p))
        loaded = loaded .or. any([(phase%tractions(i)%surface == name .and. .not. phase%tractions(i)%of_water, &
          i=1, size(phase%tractions))]) .or. any([(phase%prescriptions(i)%set == name .and. &
          abs(phase%prescriptions(i)%value) > 0.0_wp, i=1, size(phase%prescriptions))])
      end associate
    end do
  end function is_loaded
end module qsmpm_singular_corners
