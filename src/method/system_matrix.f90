!> The system matrix of an iteration, and the moves between nodal fields and equations.
module qsmpm_system_matrix
  use qsmpm_kinds, only: wp
  use qsmpm_equations, only: equations_type, add_block
  use qsmpm_initialisation, only: step_type
  use qsmpm_penalty_terms, only: add_stabilising_force
  use qsmpm_supports, only: add_support_force, support_block
  use qsmpm_pressures, only: pressure_block, add_pressure_change
  implicit none
  private

  public :: complete_matrix, linear_force, gather, scatter

contains

  !> Add the stabilisation, the supports, the pressures and the proximal drag to K^E + K^G of the last evaluation.
  subroutine complete_matrix(step, drag, displacement)
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Coefficient of the proximal drag per volume and displacement.
    real(wp), intent(in) :: drag
    !> Displacement of the step that was evaluated (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    real(wp), allocatable :: block(:, :, :, :)
    integer :: before, dimension, k, n, a, c, row, place

    dimension = size(displacement, 1)
    before = step%equations%patches%count - step%pressures%patches%count - step%supports%patches%count &
      - step%stabilisation%patches%count
    do k = 1, step%stabilisation%patches%count
      n = step%stabilisation%patches%first(k + 1) - step%stabilisation%patches%first(k)
      allocate (block(dimension, n, dimension, n), source=0.0_wp)
      do c = 1, dimension
        block(c, :, c, :) = step%stabilisation%matrix(:n, :n, k)
      end do
      call add_block(step%equations, before + k, block, step%matrix)
      deallocate (block)
    end do
    before = before + step%stabilisation%patches%count
    do k = 1, step%supports%patches%count
      call add_block(step%equations, before + k, support_block(step%supports, k), step%matrix)
    end do
    before = before + step%supports%patches%count
    do k = 1, step%pressures%patches%count
      call add_block(step%equations, before + k, &
        pressure_block(step%pressures, k, displacement, step%equations%symmetric), step%matrix)
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
  end subroutine complete_matrix

  !> Force that tangent, stabilisation, supports and pressures give the prescribed displacements, at the free
  !> components; the first evaluation of the step has found the tangent's part.
  subroutine linear_force(step, displacement, force)
    !> Scratch of the step.
    type(step_type), intent(in) :: step
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    !> (equations)
    real(wp), intent(out) :: force(:)
    real(wp) :: nodal(size(displacement, 1), size(displacement, 2))

    nodal = step%evaluation%linear_force
    call add_stabilising_force(step%stabilisation, displacement, nodal)
    call add_support_force(step%supports, displacement, .false., nodal)
    call add_pressure_change(step%pressures, displacement, nodal)
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
