!> How many equations a model has in its present phase, counted without making them: free components
!> of the functions that reach into cells with points.
module qsmpm_equation_count
  use qsmpm_model, only: model_type
  use qsmpm_space, only: cell_nodes_of_space, most_functions
  use qsmpm_phase_start, only: resume_phase
  implicit none
  private

  public :: count_equations

contains

  !> Count them; averaged functions may reach a cell further than is seen here.
  subroutine count_equations(model, count)
    !> The model; gets the loads and constraints of its phase.
    type(model_type), intent(inout) :: model
    !> Number of equations.
    integer, intent(out) :: count
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
    count = 0
    do a = 1, model%space%node_count
      if (active(a)) count = count + model%mesh%dimension - sum(merge(1, 0, model%loading%constrained(:, a)))
    end do
  end subroutine count_equations
end module qsmpm_equation_count
