!> A plane scene of level layers between rollers, under loads that do not depend on x, as a single
!> column of cells.
!>
!> Proof: `qsmpm_uniform_axis` along x, and rectangles that are not shifted: then the columns of the
!> grid are all alike and each carries its own width of the load. Triangles lean to one side, so their
!> columns are not alike at the ends and the scene is left as it is.
module qsmpm_column
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_history_description, only: quantity_displacement, quantity_position, quantity_reaction
  use qsmpm_reduction, only: reduction_type, reduce_column, refuse, place_text, begin_reduction, &
    require_local_histories
  use qsmpm_set_members, only: members_type, find_members, covers_axis, keep_supports, &
    scene_tolerance
  use qsmpm_loaded_surfaces, only: drop_unused
  use qsmpm_rigid_reduction, only: flatten_rigid_bodies, reduce_rigid_history
  use qsmpm_uniform_axis, only: require_uniform
  use qsmpm_water_symmetry, only: require_level_water
  implicit none
  private

  public :: require_column, make_column

  !> Names of the sets of the two sides; no deck can write them without quotes.
  character(len=*), parameter :: side_names(2) = ['=first side', '=last side ']

contains

  !> Prove that a scene is a row of equal columns.
  pure subroutine require_column(analysis, reason)
    type(analysis_type), intent(in) :: analysis
    !> Why not; unallocated when proved.
    character(len=:), allocatable, intent(out) :: reason

    if (analysis%model == three_dimensional) then
      call refuse(reason, 'the scene depends on z')
      return
    end if
    call require_uniform(analysis, 1, reason)
    if (.not. allocated(reason)) call require_level_water(analysis, reason)
    if (allocated(reason)) return
    if (size(analysis%mesh%axes(1)%lines) <= 2) then
      call refuse(reason, 'the grid is one cell wide already')
    else if (index(analysis%mesh%element, 'QUAD') /= 1) then
      call refuse(reason, 'the triangles of *GRID'//place_text(analysis%mesh%where)// &
        ' make columns that are not alike (QUAD4 and QUAD8 do)')
    else if (analysis%mesh%perturbation > 0.0_wp) then
      call refuse(reason, 'the nodes of *GRID'//place_text(analysis%mesh%where)//' are shifted')
    else
      call require_histories(analysis, reason)
    end if
  end subroutine require_column

  !> Histories are inside the grid; reactions are those of a level set, or push a side along x.
  pure subroutine require_histories(analysis, reason)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable, intent(inout) :: reason
    type(members_type) :: members
    integer :: i, s
    logical :: whole

    call require_local_histories(analysis, reason)
    if (allocated(reason)) return
    call find_members(analysis, members)
    do i = 1, size(analysis%histories)
      associate (history => analysis%histories(i), lines => analysis%mesh%axes(1)%lines)
        if (history%quantity == quantity_reaction) then
          s = place_named(analysis%node_sets, history%set)
          whole = covers_axis(members, s, 1)
          if (.not. whole .and. (history%component /= 1 .or. side_of(members, s) == 0)) call refuse(reason, &
            "*HISTORY '"//history%name//"'"//place_text(history%where)//" reads a reaction of '"//history%set// &
            "', which depends on x")
        else if (history%at(1) < lines(1) - scene_tolerance(analysis) .or. &
          history%at(1) > lines(size(lines)) + scene_tolerance(analysis)) then
          call refuse(reason, "*HISTORY '"//history%name//"'"//place_text(history%where)//' is outside the grid')
        end if
      end associate
    end do
  end subroutine require_histories

  !> Side a set lies on: 1 the first line, 2 the last line, 0 neither.
  pure integer function side_of(members, set) result(side)
    type(members_type), intent(in) :: members
    !> Number of the set.
    integer, intent(in) :: set

    side = 0
    associate (holds => members%axis(1)%holds(:, set))
      if (count(holds) /= 1) return
      if (holds(1)) side = 1
      if (holds(size(holds))) side = 2
    end associate
  end function side_of

  !> One column of a scene of equal columns, and the way back.
  pure subroutine make_column(analysis, step)
    !> The scene, proved to be a row of equal columns; the column.
    type(analysis_type), intent(inout) :: analysis
    !> The way back.
    type(reduction_type), intent(out) :: step
    type(members_type) :: members
    integer :: s

    call begin_reduction(analysis, reduce_column, 1, step)
    call find_members(analysis, members)
    associate (lines => analysis%mesh%axes(1)%lines)
      step%factor = (lines(size(lines)) - lines(1))/(lines(2) - lines(1))
    end associate
    call column_histories(analysis, members, step)
    call flatten_rigid_bodies(analysis, [1], step%factor)
    ! What is freed of a side has been proved to be held again.
    call keep_supports(analysis, [(covers_axis(members, s, 1), s=1, size(analysis%node_sets))], 1, &
      analysis%mesh%axes(1)%lines(:2), side_names)
    call move_sides(analysis, members)
    call drop_unused(analysis)
    analysis%bodies%copies = step%factor*analysis%bodies%copies
    analysis%mesh%axes(1)%lines = analysis%mesh%axes(1)%lines(:2)
  end subroutine make_column

  !> Histories of the column: nothing moves along x.
  pure subroutine column_histories(analysis, members, step)
    type(analysis_type), intent(inout) :: analysis
    type(members_type), intent(in) :: members
    !> Gets the way back.
    type(reduction_type), intent(inout) :: step
    integer :: i

    do i = 1, size(analysis%histories)
      associate (history => analysis%histories(i))
        select case (history%quantity)
        case (quantity_displacement)
          if (history%component == 1) step%history_factor(i) = 0.0_wp
        case (quantity_position)
          if (history%component == 1) step%history_factor(i) = 0.0_wp
          if (history%component == 1) step%history_offset(i) = history%at(1)
        case (quantity_reaction)
          if (covers_axis(members, place_named(analysis%node_sets, history%set), 1)) &
            step%history_factor(i) = merge(0.0_wp, step%factor, history%component == 1)
        end select
        call reduce_rigid_history(history, [1], step%factor, step%history_factor(i))
        if (history%quantity /= quantity_reaction) history%at(1) = in_first(analysis%mesh%axes(1)%lines, history%at(1))
      end associate
    end do
  end subroutine column_histories

  !> The place in the first cell that is like a place in any cell.
  pure real(wp) function in_first(lines, x)
    !> Lines along x; the place.
    real(wp), intent(in) :: lines(:), x
    integer :: i

    i = max(1, min(size(lines) - 1, count(lines <= x)))
    in_first = lines(1) + (lines(2) - lines(1))*(x - lines(i))/(lines(i + 1) - lines(i))
    in_first = max(lines(1), min(lines(2), in_first))
  end function in_first

  !> Sets on a side that a history reads go with the side.
  pure subroutine move_sides(analysis, members)
    type(analysis_type), intent(inout) :: analysis
    type(members_type), intent(in) :: members
    integer :: s

    do s = 1, size(members%axis(1)%holds, 2)
      if (side_of(members, s) == 0) cycle
      analysis%node_sets(s)%box(1, :) = analysis%mesh%axes(1)%lines(side_of(members, s))
    end do
  end subroutine move_sides
end module qsmpm_column
