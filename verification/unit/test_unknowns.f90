!> Two fields in one set of equations: the displacement under its weight, and a scalar that diffuses from the base of
!> the body to its top (diffusion_term). Numbering, assembly, solution, checkpoint and restart file.
module test_unknowns
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_equations, only: equations_type, number_equations, gather, scatter
  use qsmpm_error, only: error_type
  use qsmpm_initialisation, only: step_type, initialise_step, add_term
  use qsmpm_kept_arrays, only: lay_array, kept_values, keep_values
  use qsmpm_law, only: tangent_elastic
  use qsmpm_linear_system, only: linear_system_type, start_system, factorise_system, solve_system, end_system
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_model_window, only: restore
  use qsmpm_node_graph, only: connectivity_type
  use qsmpm_phase_start, only: start_phase
  use qsmpm_restart, only: read_restart, write_restart
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_space, only: node_position
  use qsmpm_term, only: role_external, failure_type
  use qsmpm_term_sums, only: prepare_terms, set_loads, sum_forces, evaluate_terms, add_all_blocks
  use qsmpm_unknowns, only: unknowns_type, add_field, find_field, joint_node, most_components, all_nodes, &
    join_constraints, put_values, values_of
  use deck_samples, only: joined
  use diffusion_term, only: diffusion_type
  use scratch_folder, only: make_folder, remove_folder
  use testing, only: tests_type
  implicit none
  private

  public :: collect_unknowns

contains

  !> All tests of the suite.
  subroutine collect_unknowns(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('unknowns')
    call check_table(tests)
    call check_two_fields(tests)
  end subroutine collect_unknowns

  !> Where nodes, constraints and values of three fields stand.
  subroutine check_table(tests)
    type(tests_type), intent(inout) :: tests
    type(unknowns_type) :: unknowns
    logical :: constrained(3, 9)
    real(wp) :: table(3, 9)

    call add_field(unknowns, 'displacement', 2, 4)
    call add_field(unknowns, 'pressure', 1, 3)
    call add_field(unknowns, 'rotation', 3, 2)
    call tests%check('the table is as high as the field of most components and as long as all nodes', &
      most_components(unknowns) == 3 .and. all_nodes(unknowns) == 9)
    call tests%check('fields stand behind one another', all(joint_node(unknowns, [1, 2], [1, 2]) == [1, 6]) .and. &
      joint_node(unknowns, 2, 3) == 9)
    call tests%check('a field is found by its name', find_field(unknowns, 'pressure') == 2 .and. &
      find_field(unknowns, 'heat') == 0)
    constrained = .false.
    call join_constraints(unknowns, 2, reshape([.false., .true., .false.], [1, 3]), constrained)
    call tests%check('what a field has not is constrained', all(constrained(2:, 5:7)) .and. &
      all(constrained(1, 5:7) .eqv. [.false., .true., .false.]) .and. count(constrained) == 7)
    table = 0.0_wp
    call put_values(unknowns, 2, reshape([1.0_wp, 2.0_wp, 3.0_wp], [1, 3]), table)
    call tests%close('values come back', sum(abs(values_of(unknowns, 2, table) &
      - reshape([1.0_wp, 2.0_wp, 3.0_wp], [1, 3]))) + abs(sum(table) - 6.0_wp), 0.0_wp, 0.0_wp)
  end subroutine check_table

  !> A block under its weight.
  subroutine build(model)
    type(model_type), intent(out) :: model
    type(analysis_type) :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    call parse_deck('block.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 1, 4|Y, 0, 1, 4|'// &
      '*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*UNIT WEIGHT|18|'// &
      '*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 1|*METHOD, BASIS=STANDARD|*PHASE, NAME=one|*FIX|base, ALL|'// &
      '*GRAVITY|0, -1|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the deck of the unknowns suite is broken'
    call start_phase(model)
  end subroutine build

  !> Displacement and scalar in one matrix: either is what it is alone, and the scalar is linear between its ends.
  subroutine check_two_fields(tests)
    type(tests_type), intent(inout) :: tests
    type(model_type) :: model
    type(step_type) :: alone, both
    type(unknowns_type) :: unknowns
    type(diffusion_type) :: diffusion
    type(error_type), allocatable :: error
    real(wp), allocatable :: sunk(:, :), u(:, :), p(:, :), exact(:, :)

    call build(model)
    call add_field(unknowns, 'displacement', 2, model%space%node_count)
    call initialise_step(model, alone, error)
    call end_system(alone%system)
    allocate (sunk(2, model%space%node_count), source=0.0_wp)
    call solve_fields(model, alone, unknowns, sunk)

    call add_field(unknowns, 'scalar', 1, model%space%node_count)
    diffusion%name = 'flow of the scalar'
    diffusion%unknowns = unknowns
    call add_term(model, both%terms, diffusion)
    call initialise_both(model, both)
    allocate (u(2, all_nodes(unknowns)), source=0.0_wp)
    call prescribe_ends(model, unknowns, u)
    call solve_fields(model, both, unknowns, u)
    call tests%close('the displacement beside a scalar is what it is alone', &
      maxval(abs(values_of(unknowns, 1, u) - sunk)), 0.0_wp, 1.0e-12_wp*maxval(abs(sunk)))
    call tests%check('the body sinks', maxval(abs(sunk)) > 1.0e-3_wp)
    allocate (exact(1, model%space%node_count), source=heights(model))
    allocate (p, source=values_of(unknowns, 2, u))
    call tests%close('the scalar is linear between its ends', maxval(abs(p - exact)), 0.0_wp, 1.0e-12_wp)
    call tests%check('its second component is no unknown', all(abs(u(2, joint_node(unknowns, 1, 2):)) <= 0.0_wp))
    call check_kept(tests, model, p)
  end subroutine check_two_fields

  !> Heights of the nodes.
  function heights(model) result(y)
    type(model_type), intent(in) :: model
    real(wp) :: y(1, model%space%node_count)
    real(wp) :: x(2)
    integer :: a

    do a = 1, size(y, 2)
      x = node_position(model%space, model%mesh, a)
      y(1, a) = x(2)
    end do
  end function heights

  !> The scalar is its height at base and top.
  subroutine prescribe_ends(model, unknowns, table)
    type(model_type), intent(in) :: model
    type(unknowns_type), intent(in) :: unknowns
    real(wp), intent(inout) :: table(:, :)
    real(wp) :: y(1, model%space%node_count)

    y = heights(model)
    call put_values(unknowns, 2, merge(y, 0.0_wp, at_ends(y)), table)
  end subroutine prescribe_ends

  !> Base and top.
  elemental logical function at_ends(y)
    real(wp), intent(in) :: y

    at_ends = y < 1.0e-9_wp .or. y > 1.0_wp - 1.0e-9_wp
  end function at_ends

  !> Configuration of the step; its equations are numbered by the test.
  subroutine initialise_both(model, step)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    type(model_type) :: copy
    type(step_type) :: plain
    type(error_type), allocatable :: error

    copy = model
    call initialise_step(copy, plain, error)
    if (allocated(error)) error stop 'a step of the unknowns suite cannot be made'
    call end_system(plain%system)
    step%configuration_type = plain%configuration_type
  end subroutine initialise_both

  !> One linear solution for the weight and the prescribed values in the table.
  subroutine solve_fields(model, step, unknowns, table)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    type(unknowns_type), intent(in) :: unknowns
    !> In: prescribed values, else zero. Out: the solution.
    real(wp), intent(inout) :: table(:, :)
    type(connectivity_type) :: connectivity
    type(equations_type) :: equations
    type(sparse_matrix_type) :: matrix
    type(linear_system_type) :: system
    type(failure_type) :: failure
    type(error_type), allocatable :: error
    real(wp), dimension(size(table, 1), size(table, 2)) :: force, still
    logical :: constrained(size(table, 1), size(table, 2)), changed
    real(wp), allocatable :: rhs(:), x(:)
    integer :: f

    call prepare_terms(model, step%configuration_type, step%terms, connectivity)
    call join_constraints(unknowns, 1, model%loading%constrained, constrained)
    do f = 2, size(unknowns%fields)
      call join_constraints(unknowns, f, at_ends(heights(model)), constrained)
    end do
    equations%symmetric = .true.
    call number_equations(equations, connectivity, constrained, matrix, changed, error)
    allocate (rhs(equations%count), x(equations%count))
    call start_system(system, model%analysis%solver, matrix, equations%bandwidth, .true., 2, error)
    still = 0.0_wp
    call evaluate_terms(step%terms, model, step%configuration_type, still(:, :model%space%node_count), tangent_elastic, &
      equations, matrix, failure)
    call add_all_blocks(step%terms, still, equations, matrix)
    call set_loads(step%terms, model, step%configuration_type, 1.0_wp)
    force = 0.0_wp
    call sum_forces(step%terms(:6), role_external, still(:, :model%space%node_count), force(:, :model%space%node_count))
    ! What the prescribed values call up.
    do f = 7, size(step%terms)
      still = 0.0_wp
      call step%terms(f)%term%add_force(table, still)
      force = force - still
    end do
    call gather(equations, force, rhs)
    call factorise_system(system, matrix, error)
    if (.not. allocated(error)) call solve_system(system, matrix, rhs, 1.0e-12_wp, x, error)
    if (allocated(error)) error stop 'the equations of two fields cannot be solved'
    call scatter(equations, x, table)
    call end_system(system)
  end subroutine solve_fields

  !> The scalar is kept from step to step: checkpoint and restart file bring it back.
  subroutine check_kept(tests, model, p)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    real(wp), intent(in) :: p(:, :)
    type(model_type) :: other
    type(state_type) :: before
    type(error_type), allocatable :: error
    character(len=:), allocatable :: directory

    call lay_array(model%state%kept, 'scalar', p)
    before = model%state
    call keep_values(model%state%kept, 'scalar', 2.0_wp*p)
    call restore(before, model)
    call tests%close('a restored state has the scalar', maxval(abs(kept_values(model%state%kept, 'scalar') - p)), 0.0_wp, &
      0.0_wp)
    call make_folder(directory)
    call write_restart(directory//'/scalar.h5', model, [1, 2], error)
    call build(other)
    call lay_array(other%state%kept, 'scalar', 0.0_wp*p)
    call read_restart(directory//'/scalar.h5', other, [1, 2], error)
    call tests%check('a file with a scalar is read', .not. allocated(error))
    call tests%close('and has it', maxval(abs(kept_values(other%state%kept, 'scalar') - p)), 0.0_wp, 0.0_wp)
    call build(other)
    call read_restart(directory//'/scalar.h5', other, [1, 2], error)
    call tests%check('an analysis without the scalar refuses it', allocated(error))
    call remove_folder(directory)
  end subroutine check_kept
end module test_unknowns
