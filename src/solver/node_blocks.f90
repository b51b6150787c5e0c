!> The nodes of the equations, for solvers that require a block of rows per node: its components in order, including
!> constrained ones, and the locations of the nodes if they have any.
!>
!> The equations of a node are consecutive, and nodes are numbered in the order of their equations. If rows are
!> distributed over ranks the nodes are the owned ones, and equations of other ranks are interspersed in the matrix.
module qsmpm_node_blocks
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: node_blocks_type, find_node_blocks

  !> The nodes of the equations.
  type :: node_blocks_type
    !> Components per node; 0 if unknown.
    integer :: components = 0
    !> Number of nodes.
    integer :: count = 0
    !> Row of each equation among the blocks (owned equations), from 1.
    integer, allocatable :: row(:)
    !> Location of each node (components, count); unallocated if nodes have none.
    real(wp), allocatable :: places(:, :)
    !> Communicator of the ranks that share the matrix, as in team_type; equations whose rows belong to this rank
    !> (owned equations); global block rows of the others, from 0 (equations). Unallocated if this process has the
    !> whole matrix.
    integer :: communicator = 0
    integer, allocatable :: own(:), outside(:)
  end type node_blocks_type

contains

  !> Finds the blocks of numbered equations.
  pure subroutine find_node_blocks(number, equation_count, places, blocks)
    !> Equation of each component of each node, 0 for none (components, nodes).
    integer, intent(in) :: number(:, :)
    integer, intent(in) :: equation_count
    !> Locations of the nodes (components, nodes); unallocated for none.
    real(wp), allocatable, intent(in) :: places(:, :)
    type(node_blocks_type), intent(out) :: blocks
    integer, allocatable :: node_of(:), order(:)
    integer :: a, c, i

    allocate (node_of(equation_count), order(equation_count), blocks%row(equation_count))
    blocks%components = size(number, 1)
    do a = 1, size(number, 2)
      do c = 1, size(number, 1)
        if (number(c, a) == 0) cycle
        node_of(number(c, a)) = a
        blocks%row(number(c, a)) = c
      end do
    end do
    do i = 1, equation_count
      if (i == 1) then
        blocks%count = 1
      else if (node_of(i) /= node_of(i - 1)) then
        blocks%count = blocks%count + 1
      end if
      order(blocks%count) = node_of(i)
      blocks%row(i) = (blocks%count - 1)*blocks%components + blocks%row(i)
    end do
    if (.not. allocated(places)) return
    if (size(places, 1) == size(number, 1)) blocks%places = places(:, order(:blocks%count))
  end subroutine find_node_blocks
end module qsmpm_node_blocks
