!> The command `qsmpm plan`: what part of a scene is modelled, why it is not reduced further, and what the run will
!> cost; no files are written. The figures of the equations are those of the first step, which is solved on a copy of
!> the model: matrix, solver, factors and time are measured, and the cost of the run is estimated from them.
!>
!> A plan is a list of names and values under headings, printed as text or as JSON.
!>
!> For `qsmpm plan --ranks` the plan has the division among several processes: points and equations of each, copies in
!> the surrounding rings, and memory. Boxes, rings and owners are those of a run (qsmpm_division) for the initial point
!> locations; memory is an estimate from measured values for points and for PETSc's matrices.
module qsmpm_plan
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_mesh_description, only: mesh_fitted, mesh_grid
  use qsmpm_method_description, only: basis_fem, stabilise_none, basis_list
  use qsmpm_phase_description, only: newton_modified
  use qsmpm_contacts, only: contact_counts
  use qsmpm_keyword_table, only: model_words, integration_words, stabilisation_words
  use qsmpm_error, only: error_type
  use qsmpm_initialisation, only: step_type, begin_analysis
  use qsmpm_linear_system, only: end_system
  use qsmpm_load_step, only: load_step_type
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_nodal_fields, only: count_equations, count_node_equations
  use qsmpm_model, only: model_type
  use qsmpm_number_text, only: integer_text
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_phase_start, only: start_phase
  use qsmpm_plan_probe, only: trial_type, try_run, try_coarse, expected_range
  use qsmpm_reduction, only: reduction_check_type, reduction_name
  use qsmpm_scene, only: check_text
  use qsmpm_soil_points, only: soil_type, soil_of
  use qsmpm_stopwatch, only: clock_type, start_clock, cpu_seconds, start_stopwatch, part_control
  use qsmpm_whole_scene, only: whole_scene_type, is_reduced
  use qsmpm_cell_numbers, only: whole_cells
  use qsmpm_division, only: ring_of, share_cells
  use qsmpm_model_builder, only: is_divided_as_built
  use qsmpm_own_marks, only: node_owners
  use qsmpm_sharing_limits, only: refuse_sharing
  use qsmpm_text, only: json_string, newline
  implicit none
  private

  public :: make_plan, plan_ranks, plan_items_type, add_heading, add_item, plan_text, plan_json

  !> Bytes of a real number and of a column index; a megabyte.
  real(wp), parameter :: number_bytes = 8.0_wp, index_bytes = 4.0_wp, megabyte = 1.0e6_wp
  !> Number of equations above which the first step is not solved for a plan.
  integer, parameter :: most_for_plan = 300000

  !> Bytes of the program with its libraries, of a point with its cell and the state before the step, and of a matrix
  !> entry (number and column index); fitted to runs with PETSc of 22 000 to 2.7 million points (docs/distributed.md).
  real(wp), parameter :: bytes_of_program = 60.0e6_wp, bytes_of_point = 1500.0_wp, bytes_of_entry = 12.0_wp
  !> Memory of the matrix, its copy in PETSc, the coarser matrices and the vectors of the method, relative to the
  !> matrix.
  real(wp), parameter :: matrices = 3.0_wp

  !> Kinds of entries of a plan.
  integer, parameter :: heading = 0, words = 1, figure = 2
  !> Width of the names in columns.
  integer, parameter :: name_width = 26

  !> An entry of a plan.
  type :: item_type
    integer :: kind = heading
    character(len=:), allocatable :: name, value
  end type item_type

  !> Entries in the order of the plan.
  type :: plan_items_type
    type(item_type), allocatable :: rows(:)
  end type plan_items_type

contains

  !> Prepares the plan of a scene.
  subroutine make_plan(scene, whole, checks, model, items)
    !> The scene as defined in the deck.
    type(analysis_type), intent(in) :: scene
    !> The unreduced scene, where the model is reduced.
    type(whole_scene_type), intent(inout) :: whole
    !> Results of the checks of possible reductions.
    type(reduction_check_type), intent(in) :: checks(:)
    type(model_type), intent(in) :: model
    type(plan_items_type), intent(out) :: items
    integer :: i
    character(len=:), allocatable :: text

    call add_heading(items, 'scene')
    text = trim(model_words(scene%model))
    if (scene%reduce) text = merge('3D   ', 'plane', scene%model == three_dimensional)
    text = trim(text)
    if (scene%reduce) text = text//', reduced to the smallest equivalent model'
    if (.not. scene%reduce) text = text//', as in the deck'
    call add_item(items, 'kind', text)
    call add_item(items, 'mesh', mesh_text(scene))
    call add_item(items, 'bodies', integer_text(size(scene%bodies)), is_figure=.true.)
    call add_heading(items, 'reductions')
    do i = 1, size(checks)
      call add_item(items, reduction_name(checks(i)%kind, checks(i)%axis), check_text(checks(i)))
    end do
    call add_heading(items, 'model')
    call add_item(items, 'kind', trim(model_words(model%analysis%model)))
    call add_item(items, 'mesh', mesh_text(model%analysis))
    call add_item(items, 'basis', trim(basis_list(model%analysis%method%basis)%word))
    if (model%analysis%method%basis /= basis_fem) call add_item(items, 'integration', &
      trim(integration_words(model%analysis%method%integration)))
    call plan_sizes(whole, model, items)
    call plan_method(model%analysis, items)
    call plan_equations(model, items)
  end subroutine make_plan

  !> Returns the number of cells of a grid along each axis, or the source of the mesh.
  pure function mesh_text(analysis) result(text)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: text
    integer :: a

    text = 'given by its nodes and elements'
    if (analysis%mesh%kind == mesh_fitted) text = 'body-fitted triangles'
    if (analysis%mesh%kind /= mesh_grid) return
    text = ''
    do a = 1, merge(3, 2, analysis%model == three_dimensional)
      if (a > 1) text = text//' x '
      text = text//integer_text(size(analysis%mesh%axes(a)%lines) - 1)
    end do
    text = text//' cells, '//analysis%mesh%element
  end function mesh_text

  !> Adds the sizes of the model and of the scene.
  subroutine plan_sizes(whole, model, items)
    !> The unreduced scene, where the model is reduced.
    type(whole_scene_type), intent(inout) :: whole
    type(model_type), intent(in) :: model
    type(plan_items_type), intent(inout) :: items
    class(model_type), allocatable :: counted
    logical :: held(model%mesh%cell_count)
    integer :: equations

    allocate (counted, source=model)
    call count_equations(counted, equations)
    held = .false.
    held(model%state%points%cell) = .true.
    call add_item(items, 'nodes', integer_text(model%mesh%node_count), is_figure=.true.)
    call add_item(items, 'elements', integer_text(model%mesh%cell_count), is_figure=.true.)
    call add_item(items, 'elements with points', integer_text(count(held)), is_figure=.true.)
    call add_item(items, 'material points', integer_text(model%state%points%count), is_figure=.true.)
    call add_item(items, 'state variables a point', integer_text(size(model%state%points%state, 1)), is_figure=.true.)
    call add_item(items, 'equations', integer_text(equations), is_figure=.true.)
    if (.not. is_reduced(whole)) return
    call count_equations(whole%model, equations)
    call add_item(items, 'nodes of the scene', integer_text(whole%model%mesh%node_count), is_figure=.true.)
    call add_item(items, 'points of the scene', integer_text(whole%model%state%points%count), is_figure=.true.)
    call add_item(items, 'equations of the scene', integer_text(equations), is_figure=.true.)
    call add_item(items, 'answers', 'symmetric ones only: a failure that breaks the symmetry is not found')
  end subroutine plan_sizes

  !> Adds the stabilisation and its bounds.
  subroutine plan_method(analysis, items)
    type(analysis_type), intent(in) :: analysis
    type(plan_items_type), intent(inout) :: items

    associate (method => analysis%method, controls => analysis%phases(1)%controls)
      if (method%stabilisation == stabilise_none .or. method%basis == basis_fem) then
        call add_item(items, 'stabilisation', 'none')
        return
      end if
      call add_item(items, 'stabilisation', trim(stabilisation_words(method%stabilisation))//', factor '// &
        rounded_text(method%stabilisation_factor, 3))
      call add_item(items, 're-equilibrations', &
        'while it carries more than '//rounded_text(controls%stabilisation_share, 3)// &
        ' of the load, at most '//integer_text(controls%max_reequilibrations)//' a step')
    end associate
  end subroutine plan_method

  !> Adds matrix, solver, memory and time of the first step.
  subroutine plan_equations(model, items)
    type(model_type), intent(in) :: model
    type(plan_items_type), intent(inout) :: items
    class(model_type), allocatable :: first
    type(step_type) :: step
    type(load_step_type) :: solver
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    type(clock_type) :: clock
    real(wp) :: seconds
    integer :: equations

    call add_heading(items, 'first step')
    allocate (first, source=model)
    call count_equations(first, equations)
    if (equations > most_for_plan) then
      call add_item(items, 'not made', 'more than '//integer_text(most_for_plan)//' equations')
      return
    end if
    call begin_analysis(first, step%terms)
    call start_phase(first)
    call start_stopwatch(step%profile%watch, part_control)
    call start_clock(clock)
    associate (controls => model%analysis%phases(1)%controls)
      call solver%solve(first, step, controls, attempt_type(1.0_wp/controls%steps, controls%tolerance), solution, error)
    end associate
    seconds = cpu_seconds(clock)
    if (allocated(error)) then
      call add_item(items, 'not made', error%message)
      return
    end if
    call add_item(items, 'matrix', symmetry_text(model, step%equations%symmetric))
    call add_item(items, 'equations', integer_text(step%equations%count), is_figure=.true.)
    call add_item(items, 'entries', integer_text(size(step%matrix%column)), is_figure=.true.)
    if (allocated(step%system%solver)) call plan_solver(step, items)
    call plan_contacts(step, items)
    call plan_cost(model, solution, seconds, items)
    call end_system(step%system)
  end subroutine plan_equations

  !> Returns why the matrix is symmetric or not.
  pure function symmetry_text(model, symmetric) result(text)
    type(model_type), intent(in) :: model
    !> Whether it is symmetric.
    logical, intent(in) :: symmetric
    character(len=:), allocatable :: text
    integer :: m

    text = 'symmetric: every material is elastic or fails associated'
    if (symmetric) then
      if (model%analysis%phases(1)%controls%newton == newton_modified) text = 'symmetric: the elastic one is kept'
      return
    end if
    text = 'unsymmetric'
    if (size(model%contact_pairs) > 0) text = 'unsymmetric: friction of the contacts'
    do m = 1, size(model%laws)
      if (.not. model%laws(m)%is_symmetric()) text = "unsymmetric: material '"//model%analysis%materials(m)%name//"'"
    end do
  end function symmetry_text

  !> Adds the contact patches near rigid bodies, their surface points and the unknowns of free rigid bodies.
  subroutine plan_contacts(step, items)
    type(step_type), intent(in) :: step
    type(plan_items_type), intent(inout) :: items
    integer :: counts(3)

    counts = contact_counts(step%terms)
    if (counts(1) == 0) return
    call add_item(items, 'contact patches', integer_text(counts(2)), is_figure=.true.)
    call add_item(items, 'contact points', integer_text(counts(3)), is_figure=.true.)
    call add_item(items, 'unknowns of bodies', integer_text(count(step%field_of > 1)), is_figure=.true.)
  end subroutine plan_contacts

  !> Adds solver, factors and memory.
  subroutine plan_solver(step, items)
    !> Workspace of the first step, with the factorised matrix.
    type(step_type), intent(in), target :: step
    type(plan_items_type), intent(inout) :: items
    type(soil_type), pointer :: soil
    real(wp) :: bytes

    call add_item(items, 'solver', step%system%solver%name)
    call add_item(items, 'factors', integer_text(step%system%solver%factor_nonzeros), is_figure=.true.)
    soil => soil_of(step%terms)
    bytes = number_bytes*real(step%system%solver%factor_nonzeros, wp) &
      + (number_bytes + index_bytes)*real(size(step%matrix%column), wp) &
      + number_bytes*real(size(soil%evaluation%block), wp)
    call add_item(items, 'memory of the equations', rounded_text(bytes/megabyte, 2)// &
      ' MB: factors, matrix and element blocks')
  end subroutine plan_solver

  !> Adds the cost of the first step and the estimated cost of the run, from trial runs of about a second each with the
  !> model and with a coarser grid.
  subroutine plan_cost(model, solution, seconds, items)
    type(model_type), intent(in) :: model
    !> Result of the first step.
    type(solution_type), intent(in) :: solution
    !> Processor time of the first step, in seconds.
    real(wp), intent(in) :: seconds
    type(plan_items_type), intent(inout) :: items
    type(trial_type) :: fine, coarse
    real(wp) :: range(2)
    character(len=:), allocatable :: text

    if (.not. solution%converged) call add_item(items, 'converged', 'no: '//solution%reason)
    call add_item(items, 'iterations', integer_text(solution%iterations), is_figure=.true.)
    call add_item(items, 'processor seconds', rounded_text(seconds, 2), is_figure=.true.)
    call try_run(model, fine)
    if (allocated(fine%lost)) call add_item(items, 'the run is lost', fine%lost)
    if (.not. fine%ended) call try_coarse(model, coarse)
    range = expected_range(fine, coarse)
    text = 'by the run itself, to its end'
    if (.not. fine%ended) text = 'by '//rounded_text(fine%seconds, 2)//' s of it, '// &
      integer_text(nint(fine%iterations))//' iterations to '//integer_text(nint(100.0_wp*fine%share))//' % of its steps'
    if (coarse%iterations > 0.0_wp) text = text//'; on every second line of its grid '// &
      integer_text(nint(coarse%iterations))//' iterations to '//integer_text(nint(100.0_wp*coarse%share))//' %'
    call add_item(items, 'expected of the run', rounded_text(range(1), 2)//' to '//rounded_text(range(2), 2)// &
      ' s: '//text)
  end subroutine plan_cost

  !> Adds the estimates for a run on several processes.
  subroutine plan_ranks(model, ranks, items)
    type(model_type), intent(in) :: model
    !> Number of processes, at least 2.
    integer, intent(in) :: ranks
    type(plan_items_type), intent(inout) :: items
    type(error_type), allocatable :: error
    integer :: own(ranks), copies(ranks), equations(ranks)
    logical :: short
    real(wp) :: entries
    character(len=:), allocatable :: text

    call add_heading(items, integer_text(ranks)//' processes')
    call refuse_sharing(model, ranks, error)
    if (allocated(error)) then
      call add_item(items, 'not shared', error%message)
      return
    end if
    call count_parts(model, ranks, own, copies, equations, short)
    if (short) then
      call add_item(items, 'not shared', 'the material occupies too few cells of the mesh')
      return
    end if
    call add_item(items, 'points of a process', integer_text(minval(own))//' to '//integer_text(maxval(own)))
    call add_item(items, 'imbalance', rounded_text(maxval(own)*real(ranks, wp)/sum(own), 3), is_figure=.true.)
    call add_item(items, 'copies in its ring', integer_text(minval(copies))//' to '//integer_text(maxval(copies)))
    call add_item(items, 'copies of a point', rounded_text(sum(copies)/real(sum(own), wp), 3), is_figure=.true.)
    call add_item(items, 'equations of a process', integer_text(minval(equations))//' to '// &
      integer_text(maxval(equations)))
    ! Memory of the process with the most data; where every process builds the whole model, its points are included.
    associate (d => model%mesh%dimension, degree => max(1, basis_list(model%analysis%method%basis)%degree))
      entries = real(d*(2*degree + 1)**d, wp)
    end associate
    text = rounded_text((bytes_of_program + maxval(own + copies)*bytes_of_point + &
      maxval(equations)*entries*bytes_of_entry*matrices)/megabyte, 2)//' MB with PETSC'
    if (.not. is_divided_as_built(model%analysis)) text = text//'; '// &
      rounded_text(model%state%points%count*bytes_of_point/megabyte, 2)//' MB of points while the model is built whole'
    call add_item(items, 'memory of a process', text)
  end subroutine plan_ranks

  !> Counts owned points, copies and equations of each process.
  subroutine count_parts(model, ranks, own, copies, equations, short)
    type(model_type), intent(in) :: model
    integer, intent(in) :: ranks
    !> (ranks)
    integer, intent(out) :: own(:), copies(:), equations(:)
    !> Whether there are too few cells with material.
    logical, intent(out) :: short
    class(model_type), allocatable :: shared
    integer, allocatable :: cell(:), owner(:), of_node(:)
    integer :: r, a

    allocate (shared, source=model)
    own = 0
    copies = 0
    equations = 0
    call share_cells(shared, ranks, short)
    if (short) return
    cell = whole_cells(shared, shared%state%points%cell(:shared%state%points%count))
    do r = 1, ranks
      own(r) = count(shared%part%owners%near(r - 1, 0, cell))
      copies(r) = count(shared%part%owners%near(r - 1, ring_of(model%analysis), cell)) - own(r)
    end do
    allocate (owner, source=node_owners(shared))
    allocate (of_node(shared%space%node_count))
    call count_node_equations(shared, of_node)
    do a = 1, size(owner)
      equations(owner(a) + 1) = equations(owner(a) + 1) + of_node(a)
    end do
  end subroutine count_parts

  !> Starts a group of entries.
  pure subroutine add_heading(items, name)
    type(plan_items_type), intent(inout) :: items
    !> Name of the group.
    character(len=*), intent(in) :: name

    call add(items, heading, name, '')
  end subroutine add_heading

  !> Adds an entry.
  pure subroutine add_item(items, name, value, is_figure)
    type(plan_items_type), intent(inout) :: items
    !> Name and value of the entry.
    character(len=*), intent(in) :: name, value
    !> Whether the value is a number; otherwise it is text.
    logical, intent(in), optional :: is_figure
    integer :: kind

    kind = words
    if (present(is_figure)) kind = merge(figure, words, is_figure)
    call add(items, kind, name, value)
  end subroutine add_item

  !> Appends an entry.
  pure subroutine add(items, kind, name, value)
    type(plan_items_type), intent(inout) :: items
    !> Kind, name and value.
    integer, intent(in) :: kind
    character(len=*), intent(in) :: name, value
    type(item_type) :: row

    if (.not. allocated(items%rows)) allocate (items%rows(0))
    row%kind = kind
    row%name = name
    row%value = value
    items%rows = [items%rows, row]
  end subroutine add

  !> Returns the plan as text.
  pure function plan_text(items) result(text)
    type(plan_items_type), intent(in) :: items
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(items%rows)
      associate (name => items%rows(i)%name)
        if (items%rows(i)%kind == heading) then
          text = text//name//newline
        else
          text = text//'  '//name//repeat(' ', max(1, name_width - len(name)))//items%rows(i)%value//newline
        end if
      end associate
    end do
  end function plan_text

  !> Returns the plan as JSON: an object of objects.
  pure function plan_json(items) result(text)
    type(plan_items_type), intent(in) :: items
    character(len=:), allocatable :: text
    logical :: first
    integer :: i

    text = '{'
    first = .true.
    do i = 1, size(items%rows)
      if (items%rows(i)%kind == heading) then
        if (i > 1) text = text//newline//'  },'
        text = text//newline//'  '//json_string(items%rows(i)%name)//': {'
        first = .true.
        cycle
      end if
      if (.not. first) text = text//','
      first = .false.
      text = text//newline//'    '//json_string(items%rows(i)%name)//': '
      if (items%rows(i)%kind == figure) text = text//items%rows(i)%value
      if (items%rows(i)%kind == words) text = text//json_string(items%rows(i)%value)
    end do
    text = text//newline//'  }'//newline//'}'//newline
  end function plan_json
end module qsmpm_plan
