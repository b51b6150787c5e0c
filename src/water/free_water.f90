!> Free water adjacent to the part of the boundary to which a level is assigned: it acts on the exposed edges connected
!> to that part, as on a wall, up to its level, but on none that is entirely below the part, since a pond on a hill does
!> not drain downhill; and the nodes where it ends next to ground that is also below its level. docs/methods/seepage.md
module qsmpm_free_water
  use qsmpm_kinds, only: wp
  use qsmpm_rounded_text, only: rounded_place
  implicit none
  private

  public :: spread_water, find_shores, beside_text, shore_text

  !> Depth of water from which it is reported, relative to the range of heights, as settled ground is always slightly
  !> submerged; relative tolerance for equal heights.
  real(wp), parameter, public :: shallow = 1.0e-2_wp
  real(wp), parameter :: level_within = 1.0e-6_wp

contains

  !> Finds the nodes that the water of a row reaches along edges.
  pure subroutine spread_water(ends, height, reach, closed, wet)
    !> Nodes of the exposed edges (2, edges).
    integer, intent(in) :: ends(:, :)
    !> Upward heights (nodes), and highest level of each row (rows).
    real(wp), intent(in) :: height(:), reach(:)
    !> Nodes that are not changed (nodes).
    logical, intent(in) :: closed(:)
    !> Row whose water reaches a node, 0 for none (nodes).
    integer, intent(inout) :: wet(:)
    real(wp) :: lowest(size(reach)), same
    logical :: spreads
    integer :: e, row, dry

    lowest = [(minval(height, mask=wet == row), row=1, size(reach))]
    same = level_within*(maxval(height) - minval(height))
    spreads = .true.
    do while (spreads)
      spreads = .false.
      do e = 1, size(ends, 2)
        row = maxval(wet(ends(:, e)))
        if (row == 0 .or. all(wet(ends(:, e)) > 0)) cycle
        dry = ends(minloc(wet(ends(:, e)), 1), e)
        if (closed(dry) .or. .not. reach(row) > height(dry) + same .or. height(dry) < lowest(row) - same) cycle
        wet(dry) = row
        spreads = .true.
      end do
    end do
  end subroutine spread_water

  !> Returns the nodes at which the water of a row ends next to ground below its level, 0 for none (rows).
  pure function find_shores(ends, height, level, row, held) result(shore)
    !> Nodes of the exposed edges of permeable soil (2, edges).
    integer, intent(in) :: ends(:, :)
    !> Upward heights (nodes), and levels (rows).
    real(wp), intent(in) :: height(:), level(:)
    !> Row of a node, 0 for none, and whether it has the pressure of free water (nodes).
    integer, intent(in) :: row(:)
    logical, intent(in) :: held(:)
    integer :: shore(size(level))
    integer :: e, at

    shore = 0
    do e = 1, size(ends, 2)
      if (count(held(ends(:, e))) /= 1) cycle
      at = ends(findloc(held(ends(:, e)), .true., dim=1), e)
      if (row(at) == 0) cycle
      if (all(level(row(at)) - height(ends(:, e)) > shallow*(maxval(height) - minval(height)))) shore(row(at)) = at
    end do
  end function find_shores

  !> Returns the note on adjacent faces on which the water of a row acts.
  pure function beside_text(phase, set) result(text)
    character(len=*), intent(in) :: phase, set
    character(len=:), allocatable :: text

    text = "phase '"//phase//"': the free water of '"//set//"' also acts on adjacent exposed faces up to its "// &
      'level'//new_line('a')
  end function beside_text

  !> Returns the warning of water that ends next to exposed ground.
  pure function shore_text(phase, set, place) result(text)
    character(len=*), intent(in) :: phase, set
    !> (dimension)
    real(wp), intent(in) :: place(:)
    character(len=:), allocatable :: text

    text = "warning: phase '"//phase//"': the free water of '"//set//"' ends at "//rounded_place(place)// &
      ', next to exposed ground below the same level that carries no water: give this ground the level too, or '// &
      'restrict the level to a part (BOX) away from it'//new_line('a')
  end function shore_text
end module qsmpm_free_water
