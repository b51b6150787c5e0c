!> How many equations a model has in its present phase, counted without making them: free components
!> of the functions that reach into cells with points.
module qsmpm_equation_count
  use qsmpm_model, only: model_type
  use qsmpm_space, only: cell_nodes_of_space, most_functions
  use qsmpm_phase_start, only: resume_phase
  implicit none
  private

  public :: count_equations, count_node_equations

contains

  !> Count them; averaged functions may reach a cell further than is seen here.
  subroutine count_equations(model, count)
    !> The model; gets the loads and constraints of its phase.
    type(model_type), intent(inout) :: model
    !> Number of equations.
    integer, intent(out) :: count
    integer :: equations(model%space%node_count)

    call count_node_equations(model, equations)
    count = sum(equations)
  end subroutine count_equations

  !> Those of each node.
  subroutine count_node_equations(model, equations)
    !> As above.
    type(model_type), intent(inout) :: model
    !> (nodes of the space)
    integer, intent(out) :: equations(:)
    logical :: held(model%mesh%cell_count), active(model%space%node_count)
    integer :: nodes(most_functions), c, n, a

    call resume_phase(model)
    held = .false.
    held(model%state%points%cell) = .true.
    active = .false.
    do c = 1, model%mesh%cell_count
      if (.not. held(c)) cycle
      call cell_nodes_of_space(model%space, model%mesh, c, nodes, n)
      active(nodes(:n)) = .true.
    end do
    equations = 0
    do a = 1, model%space%node_count
      if (active(a)) equations(a) = model%mesh%dimension - count(model%loading%constrained(:, a))
    end do
  end subroutine count_node_equations
end module qsmpm_equation_count
