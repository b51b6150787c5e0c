!> The system matrix of an iteration, and the moves between nodal fields and equations.
module qsmpm_system_matrix
  use qsmpm_kinds, only: wp
  use qsmpm_equations, only: equations_type, add_block
  use qsmpm_initialisation, only: step_type
  use qsmpm_penalty_terms, only: add_stabilising_force
  use qsmpm_supports, only: add_support_force, support_block
  implicit none
  private

  public :: build_matrix, linear_force, gather, scatter

contains

  !> K^E + K^G of the last evaluation, the stabilisation, the supports and the proximal drag.
  subroutine build_matrix(step, drag, dimension)
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Coefficient of the proximal drag per volume and displacement.
    real(wp), intent(in) :: drag
    !> 2 or 3.
    integer, intent(in) :: dimension
    real(wp), allocatable :: block(:, :, :, :)
    integer :: g, k, n, a, c, row, place

    step%matrix%values = 0.0_wp
    do g = 1, step%integration%group_count
      n = step%integration%node_first(g + 1) - step%integration%node_first(g)
      call add_packed(step, g, dimension, n, step%evaluation%block(:, g))
    end do
    do k = 1, step%stabilisation%patches%count
      n = step%stabilisation%patches%first(k + 1) - step%stabilisation%patches%first(k)
      allocate (block(dimension, n, dimension, n), source=0.0_wp)
      do c = 1, dimension
        block(c, :, c, :) = step%stabilisation%matrix(:n, :n, k)
      end do
      call add_block(step%equations, step%integration%group_count + k, block, step%matrix)
      deallocate (block)
    end do
    do k = 1, step%supports%patches%count
      call add_block(step%equations, step%integration%group_count + step%stabilisation%patches%count + k, &
        support_block(step%supports, k), step%matrix)
    end do
    if (.not. drag > 0.0_wp) return
    do a = 1, size(step%lumped)
      do c = 1, dimension
        row = step%equations%number(c, a)
        if (row == 0) cycle
        place = step%matrix%row_first(row)
        do while (step%matrix%column(place) < row)
          place = place + 1
        end do
        step%matrix%values(place) = step%matrix%values(place) + drag*step%lumped(a)
      end do
    end do
  end subroutine build_matrix

  !> Add a group's block, unpacked by shape.
  subroutine add_packed(step, group, dimension, n, block)
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    integer, intent(in) :: group, dimension, n
    !> (dimension, nodes, dimension, nodes)
    real(wp), intent(in) :: block(dimension, n, dimension, n)

    call add_block(step%equations, group, block, step%matrix)
  end subroutine add_packed

  !> Force that the last tangent and the stabilisation give a displacement, at the free components.
  subroutine linear_force(step, displacement, force)
    !> Scratch of the step.
    type(step_type), intent(in) :: step
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    !> (equations)
    real(wp), intent(out) :: force(:)
    real(wp) :: nodal(size(displacement, 1), size(displacement, 2))
    integer :: g, n, d

    d = size(displacement, 1)
    nodal = 0.0_wp
    call add_stabilising_force(step%stabilisation, displacement, nodal)
    call add_support_force(step%supports, displacement, .false., nodal)
    do g = 1, step%integration%group_count
      n = step%integration%node_first(g + 1) - step%integration%node_first(g)
      associate (nodes => step%integration%nodes(step%integration%node_first(g): &
        step%integration%node_first(g + 1) - 1))
        nodal(:, nodes) = nodal(:, nodes) + reshape(matmul(reshape(step%evaluation%block(:(d*n)**2, g), &
          [d*n, d*n]), reshape(displacement(:, nodes), [d*n])), [d, n])
      end associate
    end do
    call gather(step%equations, nodal, force)
  end subroutine linear_force

  !> The free components of a nodal field.
  pure subroutine gather(equations, field, vector)
    !> The equations.
    type(equations_type), intent(in) :: equations
    !> (dimension, node_count)
    real(wp), intent(in) :: field(:, :)
    !> (equations)
    real(wp), intent(out) :: vector(:)
    integer :: a, c

    do a = 1, size(field, 2)
      do c = 1, size(field, 1)
        if (equations%number(c, a) > 0) vector(equations%number(c, a)) = field(c, a)
      end do
    end do
  end subroutine gather

  !> Put the unknowns into a nodal field; the other components stay.
  pure subroutine scatter(equations, vector, field)
    !> The equations.
    type(equations_type), intent(in) :: equations
    real(wp), intent(in) :: vector(:)
    real(wp), intent(inout) :: field(:, :)
    integer :: a, c

    do a = 1, size(field, 2)
      do c = 1, size(field, 1)
        if (equations%number(c, a) > 0) field(c, a) = vector(equations%number(c, a))
      end do
    end do
  end subroutine scatter
end module qsmpm_system_matrix
