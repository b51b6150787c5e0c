!> Moves lines of a grid onto the interfaces of bodies that are normal to an axis. A cell that two materials share has
!> one strain, and splines are smooth across an interface inside it, whereas on a grid line their continuity is reduced
!> (docs/methods/bodies.md, "Layers"). A line is moved by at most two thirds of the cell that contains the
!> interface, so that only a layer as thin makes a cell flatter, and not if it is on another interface or within a cell
!> of the boundary of a set of nodes, elements or faces, which would gain or lose some.
module qsmpm_interface_lines
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_layer_interfaces, only: find_interfaces, interface_type
  use qsmpm_mesh_description, only: select_box, select_plane, set_type
  use qsmpm_rounded_text, only: rounded_text
  implicit none
  private

  public :: follow_interfaces

  !> Largest displacement of a line relative to the cell on that side, and distance below which lines are identical.
  real(wp), parameter :: most = 2.0_wp/3.0_wp, same = 1.0e-6_wp

contains

  !> Moves the lines, and describes it; the text is empty if no line is moved.
  pure subroutine follow_interfaces(analysis, text)
    !> The analysis after the deck has been read completely.
    type(analysis_type), intent(inout) :: analysis
    character(len=:), allocatable, intent(out) :: text
    type(interface_type), allocatable :: found(:)
    integer :: i, line

    text = ''
    call find_interfaces(analysis, found, contacts=.true.)
    do i = 1, size(found)
      if (found(i)%normal == 0 .or. found(i)%axis > 0) cycle
      associate (axis => found(i)%normal, x => found(i)%place)
        ! Another pair of bodies may have moved a line onto it.
        if (any(abs(analysis%mesh%axes(axis)%lines - x) < same*abs(analysis%mesh%axes(axis)%lines(2) - &
          analysis%mesh%axes(axis)%lines(1)))) cycle
        line = free_line(analysis, found, axis, x)
        if (line == 0) cycle
        analysis%mesh%axes(axis)%lines(line) = x
        text = text//merge(', ', '  ', len(text) > 0)//achar(iachar('x') + axis - 1)//' = '//rounded_text(x)
      end associate
    end do
    if (len(text) > 0) text = '; grid lines moved onto interfaces of bodies:'//text(2:)
  end subroutine follow_interfaces

  !> Returns the nearer of the lines on both sides of an interface that can be moved onto it; 0 if none can.
  pure integer function free_line(analysis, found, axis, x) result(line)
    type(analysis_type), intent(in) :: analysis
    type(interface_type), intent(in) :: found(:)
    !> Normal to the interface and its coordinate.
    integer, intent(in) :: axis
    real(wp), intent(in) :: x
    real(wp) :: cell
    integer :: below, i, nearer

    line = 0
    associate (lines => analysis%mesh%axes(axis)%lines)
      below = count(lines < x)
      if (below == 0 .or. below == size(lines)) return
      cell = lines(below + 1) - lines(below)
      nearer = below + merge(0, 1, x - lines(below) < 0.5_wp*cell)
      do i = nearer, 2*below + 1 - nearer, 2*(below - nearer) + 1
        if (i == 1 .or. i == size(lines) .or. is_interface(i) .or. is_used(i)) cycle
        if (abs(x - lines(i)) > most*cell .and. .not. is_interface(2*below + 1 - i)) cycle
        line = i
        return
      end do
    end associate

  contains

    !> Returns whether a line is on an interface.
    pure logical function is_interface(i)
      integer, intent(in) :: i

      is_interface = any(found%normal == axis .and. abs(found%place - analysis%mesh%axes(axis)%lines(i)) < same*cell)
    end function is_interface

    !> Returns whether the boundary of a set of nodes, elements or faces is within a cell of a line, except at the ends
    !> of the grid.
    pure logical function is_used(i)
      integer, intent(in) :: i
      integer :: s

      is_used = .false.
      if (allocated(analysis%node_sets)) then
        do s = 1, size(analysis%node_sets)
          is_used = is_used .or. is_of_set(analysis%node_sets(s), i)
        end do
      end if
      if (allocated(analysis%element_sets)) then
        do s = 1, size(analysis%element_sets)
          is_used = is_used .or. is_of_set(analysis%element_sets(s), i)
        end do
      end if
      if (.not. allocated(analysis%surfaces)) return
      do s = 1, size(analysis%surfaces)
        if (analysis%surfaces(s)%selection == select_box) is_used = is_used .or. is_beside( &
          analysis%surfaces(s)%box(axis, 1), i) .or. is_beside(analysis%surfaces(s)%box(axis, 2), i)
      end do
    end function is_used

    !> Returns whether the boundary of a set is within a cell of a line.
    pure logical function is_of_set(set, i)
      type(set_type), intent(in) :: set
      integer, intent(in) :: i

      is_of_set = .false.
      if (set%selection == select_plane .and. set%axis == axis) is_of_set = is_beside(set%box(axis, 1), i)
      if (set%selection == select_box) is_of_set = is_beside(set%box(axis, 1), i) .or. is_beside(set%box(axis, 2), i)
    end function is_of_set

    !> Returns whether a boundary inside the grid is within a cell of a line.
    pure logical function is_beside(boundary, i)
      real(wp), intent(in) :: boundary
      integer, intent(in) :: i

      associate (lines => analysis%mesh%axes(axis)%lines)
        is_beside = boundary > lines(1) .and. boundary < lines(size(lines)) .and. abs(boundary - lines(i)) < cell
      end associate
    end function is_beside
  end function free_line
end module qsmpm_interface_lines
