!> Ground that ends above the base that is held: cells which it fills in part hang it up, and the stress there is wrong.
module qsmpm_deck_ground_base
  use qsmpm_kinds, only: wp
  use qsmpm_body_description, only: body_box, body_polygon
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_mesh_description, only: mesh_fitted, mesh_grid, select_plane
  use qsmpm_named, only: place_named
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_vertical, only: upwards, vertical_of
  implicit none
  private

  public :: check_ground_base

  !> A gap that is none, over the cell beside the base.
  real(wp), parameter :: closed = 1.0e-3_wp

contains

  !> Warn where a set that is held lies in the base of the grid, and the lowest ground less than a cell above it.
  subroutine check_ground_base(state)
    type(deck_state_type), intent(inout) :: state
    real(wp) :: base, cell, gap
    integer :: p, i, s, axis

    associate (analysis => state%analysis)
      if (all(analysis%mesh%kind /= [mesh_grid, mesh_fitted]) .or. .not. all(analysis%bodies%kind == body_box .or. &
        analysis%bodies%kind == body_polygon)) return
      axis = vertical_of(analysis)
      if (size(analysis%bodies) == 0 .or. .not. allocated(analysis%mesh%axes(axis)%lines)) return
      associate (lines => analysis%mesh%axes(axis)%lines)
        base = merge(lines(1), lines(size(lines)), upwards(analysis) > 0.0_wp)
        cell = merge(lines(2) - lines(1), lines(size(lines)) - lines(size(lines) - 1), upwards(analysis) > 0.0_wp)
      end associate
      gap = lowest(state, axis) - upwards(analysis)*base
      if (gap <= closed*cell .or. gap >= cell) return
      do p = 1, size(analysis%phases)
        do i = 1, size(analysis%phases(p)%fixities)
          associate (fixity => analysis%phases(p)%fixities(i))
            s = place_named(analysis%node_sets, fixity%set)
            if (s == 0 .or. .not. fixity%fixed(axis)) cycle
            associate (set => analysis%node_sets(s))
              if (set%selection /= select_plane .or. set%axis /= axis) cycle
              if (abs(set%box(axis, 1) - base) > closed*cell) cycle
            end associate
            call state%warn(fixity%where, 'FIX', "node set '"//fixity%set//"' holds the base of the grid, and the "// &
              'ground ends '//rounded_text(gap, 3)//' above it, within a cell of '//rounded_text(cell, 3)// &
              ': what it stands on is cells that it fills in part; let a body or the grid end at the other')
            return
          end associate
        end do
      end do
    end associate
  end subroutine check_ground_base

  !> Lowest place of all bodies, upwards.
  pure real(wp) function lowest(state, axis)
    type(deck_state_type), intent(in) :: state
    integer, intent(in) :: axis
    integer :: b

    lowest = huge(1.0_wp)
    do b = 1, size(state%analysis%bodies)
      associate (body => state%analysis%bodies(b), up => upwards(state%analysis))
        if (body%kind == body_box) lowest = min(lowest, minval(up*body%box(axis, :)))
        if (body%kind == body_polygon .and. axis < 3) lowest = min(lowest, minval(up*body%polygon(axis, :)))
        if (body%kind == body_polygon .and. axis == 3) lowest = -huge(1.0_wp)
      end associate
    end do
  end function lowest
end module qsmpm_deck_ground_base
