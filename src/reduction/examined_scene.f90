!> A scene that is examined for a reduction: with what the proofs ask of it again and again, and the first reason that
!> one of them has found against it.
module qsmpm_examined_scene
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_history_quantities, only: is_taken_at, at_body, at_support
  use qsmpm_mesh_description, only: mesh_fitted, mesh_grid
  use qsmpm_set_members, only: members_type, find_members, scene_tolerance
  use qsmpm_source_line, only: source_line_type
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: examined_type, examine, refuse, refuse_mesh, require_local_histories, place_text, card

  !> Names of the axes.
  character(len=1), parameter, public :: letters(3) = ['x', 'y', 'z']

  type, extends(analysis_type) :: examined_type
    !> Axis that is to be left out, halved or cut to one cell; 0 where it is to be turned.
    integer :: axis = 0
    !> Of a grid: which lines are in which node sets, the length that is none, and where the plane half way between its
    !> sides across the axis lies.
    type(members_type) :: members
    real(wp) :: nothing = 0.0_wp, plane = 0.0_wp
    !> Why it is not possible; unallocated as long as nothing speaks against it.
    character(len=:), allocatable :: reason
  end type examined_type

contains

  !> Begin to examine a scene.
  pure subroutine examine(scene, axis)
    type(examined_type), intent(inout) :: scene
    integer, intent(in) :: axis

    scene%axis = axis
    if (allocated(scene%reason)) deallocate (scene%reason)
    if (scene%mesh%kind /= mesh_grid) return
    scene%nothing = scene_tolerance(scene)
    call find_members(scene, scene%members)
    if (axis == 0) return
    associate (lines => scene%mesh%axes(axis)%lines)
      if (allocated(scene%mesh%axes(axis)%lines)) scene%plane = 0.5_wp*(lines(1) + lines(size(lines)))
    end associate
  end subroutine examine

  !> Note why a reduction is not possible; the first reason stays.
  pure subroutine refuse(scene, text)
    type(examined_type), intent(inout) :: scene
    character(len=*), intent(in) :: text

    if (.not. allocated(scene%reason)) scene%reason = text
  end subroutine refuse

  !> A mesh that is no grid of equal cells along its axes is not reduced.
  pure subroutine refuse_mesh(scene)
    type(examined_type), intent(inout) :: scene

    if (scene%mesh%kind == mesh_fitted) then
      call refuse(scene, 'its cells are triangles that fit the bodies (*GRID'//place_text(scene%mesh%where)//')')
    else
      call refuse(scene, 'the mesh is no *GRID'//place_text(scene%mesh%where))
    end if
  end subroutine refuse_mesh

  !> Histories of bodies and supported surfaces are sums or extremes over all of the scene.
  pure subroutine require_local_histories(scene)
    type(examined_type), intent(inout) :: scene
    integer :: i

    do i = 1, size(scene%histories)
      associate (history => scene%histories(i))
        if (is_taken_at(history%quantity, at_body)) &
          call refuse(scene, card('*HISTORY', history%name, history%where)//' reads whole bodies')
        if (is_taken_at(history%quantity, at_support) .and. len(history%surface) > 0) &
          call refuse(scene, card('*HISTORY', history%name, history%where)//' reads a whole surface')
      end associate
    end do
  end subroutine require_local_histories

  !> A card by its keyword, the name of what it makes or acts on, and its place.
  pure function card(keyword, name, where) result(text)
    character(len=*), intent(in) :: keyword, name
    type(source_line_type), intent(in) :: where
    character(len=:), allocatable :: text

    text = keyword//" '"//name//"'"//place_text(where)
  end function card

  !> The place of a card in the deck in brackets, empty when it is not known.
  pure function place_text(where) result(text)
    !> Where it was written.
    type(source_line_type), intent(in) :: where
    character(len=:), allocatable :: text

    text = ''
    if (allocated(where%file) .and. where%line > 0) text = ' ('//where%file//':'//integer_text(where%line)//')'
  end function place_text
end module qsmpm_examined_scene
