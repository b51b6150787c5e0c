!> A plane scene of level layers between rollers, under loads that do not depend on x, as a single
!> column of cells.
!>
!> Proof: `qsmpm_uniform_axis` along x, and rectangles that are not shifted: then the columns of the
!> grid are all alike and each carries its own width of the load. Triangles lean to one side, so their
!> columns are not alike at the ends and the scene is left as it is.
module qsmpm_column
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: three_dimensional
  use qsmpm_history_description, only: quantity_displacement, quantity_position, quantity_reaction
  use qsmpm_reduction, only: reduction_type, reduce_column, begin_reduction
  use qsmpm_loaded_surfaces, only: drop_unused, require_level_water
  use qsmpm_rigid_symmetry, only: flatten_rigid_bodies, reduce_rigid_history
  use qsmpm_uniform_axis, only: require_uniform
  use qsmpm_examined_scene, only: examined_type, card, place_text, refuse, require_local_histories, members_type, &
    covers_axis, keep_supports
  implicit none
  private

  public :: require_column, make_column

  !> Names of the sets of the two sides; no deck can write them without quotes.
  character(len=*), parameter :: side_names(2) = ['=first side', '=last side ']

contains

  !> Prove that a scene is a row of equal columns.
  pure subroutine require_column(scene)
    type(examined_type), intent(inout) :: scene

    if (scene%model == three_dimensional) then
      call refuse(scene, 'the scene depends on z')
      return
    end if
    call require_uniform(scene)
    if (.not. allocated(scene%reason)) call require_level_water(scene)
    if (allocated(scene%reason)) return
    if (size(scene%mesh%axes(1)%lines) <= 2) then
      call refuse(scene, 'the grid is one cell wide already')
    else if (index(scene%mesh%element, 'QUAD') /= 1) then
      call refuse(scene, 'the triangles of *GRID'//place_text(scene%mesh%where)// &
        ' make columns that are not alike (QUAD4 and QUAD8 do)')
    else if (scene%mesh%perturbation > 0.0_wp) then
      call refuse(scene, 'the nodes of *GRID'//place_text(scene%mesh%where)//' are shifted')
    else
      call require_histories(scene)
    end if
  end subroutine require_column

  !> Histories are inside the grid; reactions are those of a level set, or push a side along x.
  pure subroutine require_histories(scene)
    type(examined_type), intent(inout) :: scene
    integer :: i, s
    logical :: whole

    call require_local_histories(scene)
    if (allocated(scene%reason)) return
    do i = 1, size(scene%histories)
      associate (history => scene%histories(i), lines => scene%mesh%axes(1)%lines)
        if (history%quantity == quantity_reaction) then
          s = place_named(scene%node_sets, history%set)
          whole = covers_axis(scene%members, s, 1)
          if (.not. whole .and. (history%component /= 1 .or. side_of(scene%members, s) == 0)) &
            call refuse(scene, card('*HISTORY', history%name, history%where)//" reads a reaction of '"//history%set// &
            "', which depends on x")
        else if (history%at(1) < lines(1) - scene%nothing .or. history%at(1) > lines(size(lines)) + scene%nothing) then
          call refuse(scene, card('*HISTORY', history%name, history%where)//' is outside the grid')
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
  pure subroutine make_column(scene, step)
    !> The scene, proved to be a row of equal columns; the column.
    type(examined_type), intent(inout) :: scene
    !> The way back.
    type(reduction_type), intent(out) :: step
    integer :: s

    call begin_reduction(scene, reduce_column, 1, step)
    associate (lines => scene%mesh%axes(1)%lines)
      step%factor = (lines(size(lines)) - lines(1))/(lines(2) - lines(1))
    end associate
    call column_histories(scene, step)
    call flatten_rigid_bodies(scene, [1], step%factor)
    ! What is freed of a side has been proved to be held again.
    call keep_supports(scene, [(covers_axis(scene%members, s, 1), s=1, size(scene%node_sets))], 1, &
      scene%mesh%axes(1)%lines(:2), side_names)
    ! Sets on a side that a history reads go with the side.
    do s = 1, size(scene%members%axis(1)%holds, 2)
      if (side_of(scene%members, s) == 0) cycle
      scene%node_sets(s)%box(1, :) = scene%mesh%axes(1)%lines(side_of(scene%members, s))
    end do
    call drop_unused(scene)
    scene%bodies%copies = step%factor*scene%bodies%copies
    scene%mesh%axes(1)%lines = scene%mesh%axes(1)%lines(:2)
  end subroutine make_column

  !> Histories of the column: nothing moves along x.
  pure subroutine column_histories(scene, step)
    type(examined_type), intent(inout) :: scene
    !> Gets the way back.
    type(reduction_type), intent(inout) :: step
    integer :: i

    do i = 1, size(scene%histories)
      associate (history => scene%histories(i))
        select case (history%quantity)
        case (quantity_displacement)
          if (history%component == 1) step%history_factor(i) = 0.0_wp
        case (quantity_position)
          if (history%component == 1) step%history_factor(i) = 0.0_wp
          if (history%component == 1) step%history_offset(i) = history%at(1)
        case (quantity_reaction)
          if (covers_axis(scene%members, place_named(scene%node_sets, history%set), 1)) &
            step%history_factor(i) = merge(0.0_wp, step%factor, history%component == 1)
        end select
        call reduce_rigid_history(history, [1], step%factor, step%history_factor(i))
        if (history%quantity /= quantity_reaction) history%at(1) = in_first(scene%mesh%axes(1)%lines, history%at(1))
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
end module qsmpm_column
