!> The equations of a team of processes. Each process has the rows of its own nodes whole (qsmpm_own_part). With PETSc
!> all of them solve together (qsmpm_shared_rows). For any other solver, and where PETSc fails, they send their rows to
!> the first one, which numbers, factorises and solves as a process alone would, and all get the solution: exact, but as
!> slow and as large as on one process. Alone nothing is sent.
!>
!> A list of nodes that couple is sent by the process whose own its first node is, an entry of one triangle by the
!> process whose own the row of it is in the joint numbering: it has every part of it. Unknowns that belong to no node
!> are those of the first process; what couples one to a node is sent by the process whose own the node is, what couples
!> them to each other is the sum of what all have. PETSc gets no such rows, which would run through all processes: the
!> first one solves.
module qsmpm_joint_system
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: agree, any_of
  use qsmpm_method_description, only: solver_choice_type, solver_petsc
  use qsmpm_equations, only: equations_type, number_equations, one_triangle
  use qsmpm_error, only: error_type, fail, error_other
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_linear_system, only: linear_system_type, kind_for, start_system, factorise_system, solve_system, &
    sweeps_of_multigrid, give_multigrid_up
  use qsmpm_node_graph, only: connectivity_type
  use qsmpm_petsc_solver, only: make_petsc_solver, with_petsc
  use qsmpm_shared_rows, only: shared_rows_type, start_shared_rows, factorise_shared_rows, solve_shared_rows, &
    end_shared_rows
  use qsmpm_sorting, only: order_columns, place_in_order
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_team, only: team_type, collect, spread_from
  implicit none
  private

  public :: joint_system_type, start_joint_system, begin_joint_system, leave_joint_system, end_joint_system, &
    factorise_jointly, solve_jointly, preconditions_only, bring_matrix, solve_by_factors

  character(len=*), parameter :: no_rows = 'rigid bodies that are loaded have equations that run through all '// &
    'processes: the first one solves them, PETSc GAMG too'
  character(len=*), parameter :: torn = 'the parts of the equations do not fit together'

  type :: joint_system_type
    !> All processes solve together; it is told that they cannot.
    logical :: together = .false., told = .false.
    type(shared_rows_type) :: rows
    !> A program with PETSc has started it, which all processes do at once.
    logical :: started = .false.
    !> What the deck asks for, and names, owners and places of the nodes of this process, for when it fails.
    type(solver_choice_type) :: choice
    integer, allocatable :: labels(:), owner(:)
    real(wp), allocatable :: own_places(:, :)
    !> Equations of all and their matrix; on the first process.
    type(equations_type) :: equations
    type(sparse_matrix_type) :: matrix
    !> How many there are, and which of them each equation of this process is (equations).
    integer :: count = 0
    !> Where its nodes are (dimension, nodes).
    real(wp), allocatable :: places(:, :)
    integer, allocatable :: number(:)
    !> Values of its matrix, and equations, that this process sends.
    integer, allocatable :: sent(:), own(:)
    !> Equations of unknowns that belong to no node (equations).
    logical, allocatable :: common(:)
    !> Where they go; on the first process.
    integer(long), allocatable :: place(:), own_number(:)
  end type joint_system_type

contains

  !> Number the equations of all, and make a solver for them.
  subroutine start_joint_system(joint, team, system, choice, equations, matrix, labels, owner, places, error)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    type(linear_system_type), intent(inout) :: system
    !> Output requested in the deck.
    type(solver_choice_type), intent(in) :: choice
    !> Equations of this process, numbered, and the pattern of its matrix.
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(in) :: matrix
    !> Names of the nodes, negative for unknowns that belong to none, the ranks that own them (nodes), and where they
    !> are (dimension, nodes).
    integer, intent(in) :: labels(:), owner(:)
    real(wp), allocatable, intent(in) :: places(:, :)
    type(error_type), allocatable, intent(out) :: error
    type(error_type), allocatable :: failure

    call start_petsc(joint, error)
    call agree(team, error)
    if (allocated(error)) return
    joint%choice = choice
    joint%labels = labels
    joint%owner = owner
    joint%own_places = places
    joint%common = common_equations(equations, labels)
    joint%together = equations%solver_kind == solver_petsc .and. with_petsc()
    if (joint%together .and. any(joint%common)) then
      joint%together = .false.
      if (.not. joint%told) system%note = no_rows
      joint%told = .true.
    end if
    if (joint%together) then
      call start_shared_rows(joint%rows, team, equations, matrix, labels, owner, places, failure)
      if (.not. allocated(failure)) then
        system%symmetric = equations%symmetric
        return
      end if
    end if
    joint%together = .false.
    call put_together(joint, team, system, equations, matrix, error)
  end subroutine start_joint_system

  !> Equations of unknowns that belong to no node.
  pure function common_equations(equations, labels) result(common)
    type(equations_type), intent(in) :: equations
    integer, intent(in) :: labels(:)
    logical :: common(equations%count)
    integer :: a, c

    common = .false.
    do a = 1, size(labels)
      do c = 1, size(equations%number, 1)
        if (equations%number(c, a) > 0) common(equations%number(c, a)) = labels(a) < 0
      end do
    end do
  end function common_equations

  !> Start the library on all processes at once, as it wants: later the first one may call it alone.
  subroutine start_petsc(joint, error)
    type(joint_system_type), intent(inout) :: joint
    type(error_type), allocatable, intent(out) :: error
    class(linear_solver_type), allocatable :: solver
    type(sparse_matrix_type) :: one

    if (joint%started .or. .not. with_petsc()) return
    one%n = 1
    one%row_first = [1, 2]
    one%column = [1]
    one%values = [1.0_wp]
    call make_petsc_solver(.true., solver)
    call solver%analyse(one, error)
    call solver%destroy()
    joint%started = .true.
  end subroutine start_petsc

  !> Begin a solve as a run that is continued here does: nothing is kept of an older matrix.
  subroutine begin_joint_system(joint)
    type(joint_system_type), intent(inout) :: joint

    if (joint%together) joint%rows%solver%afresh = .true.
  end subroutine begin_joint_system

  !> The solve has ended, and the next one begins afresh: multigrid of all processes is given back.
  subroutine leave_joint_system(joint)
    type(joint_system_type), intent(inout) :: joint

    if (joint%together) call joint%rows%solver%forget()
  end subroutine leave_joint_system

  !> Give everything back.
  subroutine end_joint_system(joint)
    type(joint_system_type), intent(inout) :: joint

    call end_shared_rows(joint%rows)
    joint%together = .false.
  end subroutine end_joint_system

  !> Number the equations of all on the first process, and make a solver for them there.
  subroutine put_together(joint, team, system, equations, matrix, error)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    type(linear_system_type), intent(inout) :: system
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: joint_labels(:)
    logical :: own(size(joint%owner))
    integer(long) :: kind(1)

    own = joint%owner == team%rank
    kind = kind_for(system, joint%choice)
    call spread_from(team, 0, kind)
    joint%equations%solver_kind = int(kind(1))
    joint%equations%symmetric = equations%symmetric
    call collect_graph(joint, team, equations, joint%labels, own, joint%own_places, joint_labels, error)
    call agree(team, error)
    if (allocated(error)) return
    call find_numbers(joint, team, equations, joint%labels, joint_labels, error)
    call agree(team, error)
    if (allocated(error)) return
    call find_sent(joint, team, equations, matrix, own, error)
    call agree(team, error)
    if (allocated(error)) return
    if (team%rank == 0) call start_system(system, joint%choice, joint%matrix, joint%equations%bandwidth, &
      equations%symmetric, size(joint%own_places, 1), error, joint%equations%number, joint%places)
    call agree(team, error)
  end subroutine put_together

  !> All processes together have failed: the first one solves, from here on.
  recursive subroutine give_way(joint, team, system, equations, matrix, error)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    type(linear_system_type), intent(inout) :: system
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    call end_joint_system(joint)
    call give_multigrid_up(system, 'PETSc GAMG does not precondition the equations on all processes together: the '// &
      'first one solves them from here on')
    call put_together(joint, team, system, equations, matrix, error)
    if (.not. allocated(error)) call factorise_jointly(joint, team, system, equations, matrix, error)
  end subroutine give_way

  !> Bring nodes and node lists of all to the first process, and number the equations there.
  subroutine collect_graph(joint, team, equations, labels, own, places, joint_labels, error)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    type(equations_type), intent(in) :: equations
    integer, intent(in) :: labels(:)
    logical, intent(in) :: own(:)
    real(wp), intent(in) :: places(:, :)
    !> Labels of all nodes, rising; on the first process.
    integer, allocatable, intent(out) :: joint_labels(:)
    type(error_type), allocatable, intent(out) :: error
    integer(long), allocatable :: nodes(:), all_lists(:), all_nodes(:)
    real(wp), allocatable :: all_places(:)
    integer, allocatable :: first(:), order(:), mine(:), bits(:)
    integer :: a, c, d, k, n

    d = size(places, 1)
    mine = pack([(a, a=1, size(own))], own .and. equations%active(:size(own)))
    allocate (bits(size(mine)), source=0)
    do c = 1, d
      where (equations%constrained(c, mine)) bits = ibset(bits, c)
    end do
    allocate (nodes(2*size(mine)))
    nodes(1::2) = labels(mine)
    nodes(2::2) = bits
    call collect(team, own_lists(equations%connectivity, labels, own), all_lists, first)
    call collect(team, nodes, all_nodes, first)
    call collect(team, reshape(places(:, mine), [d*size(mine)]), all_places, first)
    if (team%rank > 0) return
    n = size(all_nodes)/2
    allocate (order(n))
    call order_columns(reshape(int(all_nodes(1::2)), [1, n]), order)
    joint_labels = int(all_nodes(2*order - 1))
    bits = int(all_nodes(2*order))
    if (any(joint_labels(2:) == joint_labels(:n - 1))) call fail(error, error_other, torn//': a node is twice own')
    if (allocated(error)) return
    call number_all(joint, joint_labels, bits, &
      reshape([(all_places(d*(order(k) - 1) + 1:d*order(k)), k=1, n)], [d, n]), all_lists, error)
  end subroutine collect_graph

  !> Node lists whose first node is own, by labels, their lengths before them.
  pure function own_lists(connectivity, labels, own) result(lists)
    type(connectivity_type), intent(in) :: connectivity
    !> Names of the nodes, and which are own (nodes).
    integer, intent(in) :: labels(:)
    logical, intent(in) :: own(:)
    integer(long), allocatable :: lists(:)
    integer :: n, q

    allocate (lists(connectivity%count + size(connectivity%nodes)))
    n = 0
    do q = 1, connectivity%count
      associate (list => connectivity%nodes(connectivity%first(q):connectivity%first(q + 1) - 1))
        if (.not. own(list(1))) cycle
        lists(n + 1) = size(list)
        lists(n + 2:n + 1 + size(list)) = labels(list)
        n = n + 1 + size(list)
      end associate
    end do
    lists = lists(:n)
  end function own_lists

  !> Number the equations of all.
  subroutine number_all(joint, joint_labels, bits, places, lists, error)
    type(joint_system_type), intent(inout) :: joint
    !> Labels, constrained components and places of all nodes.
    integer, intent(in) :: joint_labels(:), bits(:)
    real(wp), intent(in) :: places(:, :)
    !> Node lists by labels, their lengths before them.
    integer(long), intent(in) :: lists(:)
    type(error_type), allocatable, intent(out) :: error
    type(connectivity_type) :: connectivity
    logical :: constrained(size(places, 1), size(bits)), changed
    integer, allocatable :: nodes(:), first(:)
    integer :: c, k, n, q

    do c = 1, size(places, 1)
      constrained(c, :) = btest(bits, c)
    end do
    allocate (nodes(size(lists)), first(size(lists) + 1))
    k = 1
    n = 0
    q = 0
    first(1) = 1
    do while (k <= size(lists))
      q = q + 1
      do c = k + 1, k + int(lists(k))
        n = n + 1
        nodes(n) = place_in_order(joint_labels, int(lists(c)))
        if (nodes(n) == 0) call fail(error, error_other, torn//': a node is no one''s')
        if (allocated(error)) return
      end do
      first(q + 1) = n + 1
      k = k + 1 + int(lists(k))
    end do
    connectivity%count = q
    connectivity%first = first(:q + 1)
    connectivity%nodes = nodes(:n)
    joint%places = places
    call number_equations(joint%equations, connectivity, constrained, joint%matrix, changed, error, places)
  end subroutine number_all

  !> Find which of all equations those of this process are.
  subroutine find_numbers(joint, team, equations, labels, joint_labels, error)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    type(equations_type), intent(in) :: equations
    integer, intent(in) :: labels(:)
    !> On the first process.
    integer, allocatable, intent(inout) :: joint_labels(:)
    type(error_type), allocatable, intent(out) :: error
    integer(long) :: counts(2)
    integer(long), allocatable :: table(:)
    integer :: a, c, d, k

    d = size(equations%number, 1)
    counts = 0
    if (team%rank == 0) counts = [size(joint_labels), joint%equations%count]
    call spread_from(team, 0, counts)
    joint%count = int(counts(2))
    allocate (table((d + 1)*counts(1)), source=0_long)
    if (team%rank == 0) then
      do k = 1, size(joint_labels)
        table((d + 1)*(k - 1) + 1:(d + 1)*k) = [joint_labels(k), joint%equations%number(:, k)]
      end do
    end if
    call spread_from(team, 0, table)
    joint_labels = int(table(1::d + 1))
    if (allocated(joint%number)) deallocate (joint%number)
    allocate (joint%number(equations%count), source=0)
    do a = 1, size(labels)
      if (.not. equations%active(a)) cycle
      k = place_in_order(joint_labels, labels(a))
      do c = 1, d
        if (equations%number(c, a) == 0) cycle
        if (k > 0) joint%number(equations%number(c, a)) = int(table((d + 1)*(k - 1) + 1 + c))
      end do
    end do
    if (any(joint%number == 0)) call fail(error, error_other, torn//': an equation is in no part')
  end subroutine find_numbers

  !> Which entries and equations this process sends, and where they go.
  subroutine find_sent(joint, team, equations, matrix, own, error)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(in) :: matrix
    !> Which nodes are own (nodes).
    logical, intent(in) :: own(:)
    type(error_type), allocatable, intent(out) :: error
    logical :: own_equation(equations%count)
    integer(long), allocatable :: entries(:), all_entries(:)
    integer, allocatable :: first(:)
    logical :: common(joint%count)
    integer :: a, c, i

    own_equation = .false.
    do a = 1, size(own)
      do c = 1, size(equations%number, 1)
        if (equations%number(c, a) > 0) own_equation(equations%number(c, a)) = own(a)
      end do
    end do
    joint%own = pack([(i, i=1, equations%count)], own_equation)
    call collect(team, int(joint%number(joint%own), long), joint%own_number, first)
    call list_entries(matrix, joint%number, own_equation, joint%common, one_triangle(joint%equations), joint%sent, &
      entries)
    call collect(team, entries, all_entries, first)
    common = .false.
    common(pack(joint%number, joint%common)) = .true.
    if (team%rank == 0) call place_entries(joint%matrix, common, all_entries, joint%place, error)
  end subroutine find_sent

  !> Entries whose rows are own in the joint numbering, or whose nodes are beside what belongs to none; every entry
  !> between the latter. Of one triangle of it, or of both.
  pure subroutine list_entries(matrix, number, own, common, triangle, sent, entries)
    !> Value of this process.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Which of all equations those of this process are, which are own, and which belong to no node (equations).
    integer, intent(in) :: number(:)
    logical, intent(in) :: own(:), common(:)
    !> The joint matrix keeps one triangle.
    logical, intent(in) :: triangle
    !> Where the values stand in the matrix, and their rows and columns in turn, as all count.
    integer, allocatable, intent(out) :: sent(:)
    integer(long), allocatable, intent(out) :: entries(:)
    integer :: column, i, k, n, row

    allocate (sent(size(matrix%column)), entries(2*size(matrix%column)))
    n = 0
    do i = 1, size(number)
      do k = matrix%row_first(i), matrix%row_first(i + 1) - 1
        row = i
        column = matrix%column(k)
        if (matrix%symmetric .and. number(column) < number(row)) then
          row = column
          column = i
        end if
        if (triangle .and. number(column) < number(row)) cycle
        if (.not. (common(row) .and. common(column)) .and. .not. own(merge(column, row, common(row)))) cycle
        n = n + 1
        sent(n) = k
        entries(2*n - 1:2*n) = [number(row), number(column)]
      end do
    end do
    sent = sent(:n)
    entries = entries(:2*n)
  end subroutine list_entries

  !> Where entries stand in a matrix.
  pure subroutine place_entries(matrix, common, entries, place, error)
    type(sparse_matrix_type), intent(in) :: matrix
    !> Rows between which each process has a share of an entry (equations).
    logical, intent(in) :: common(:)
    !> Rows and columns in turn.
    integer(long), intent(in) :: entries(:)
    integer(long), allocatable, intent(out) :: place(:)
    !> The matrix has not one value for each.
    type(error_type), allocatable, intent(out) :: error
    logical :: taken(size(matrix%column))
    integer :: i, j, k

    taken = .false.
    allocate (place(size(entries)/2))
    do k = 1, size(place)
      i = int(entries(2*k - 1))
      j = place_in_order(matrix%column(matrix%row_first(i):matrix%row_first(i + 1) - 1), int(entries(2*k)))
      if (j == 0) call fail(error, error_other, torn//': a value has no place')
      if (allocated(error)) return
      place(k) = matrix%row_first(i) - 1 + j
      if (taken(place(k)) .and. .not. (common(i) .and. common(entries(2*k)))) &
        call fail(error, error_other, torn//': a value comes twice')
      if (allocated(error)) return
      taken(place(k)) = .true.
    end do
    if (.not. all(taken)) call fail(error, error_other, torn//': a value is missing')
  end subroutine place_entries

  !> Take new values of the matrix.
  recursive subroutine factorise_jointly(joint, team, system, equations, matrix, error)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    type(linear_system_type), intent(inout) :: system
    !> Value of this process.
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error
    type(error_type), allocatable :: failure

    if (team%ranks == 1) then
      call factorise_system(system, matrix, error)
      return
    else if (joint%together) then
      call factorise_shared_rows(joint%rows, team, matrix, failure)
      if (allocated(failure)) call give_way(joint, team, system, equations, matrix, error)
      return
    end if
    call bring_matrix(joint, team, matrix)
    if (team%rank == 0) call factorise_system(system, joint%matrix, error)
    call agree(team, error)
  end subroutine factorise_jointly

  !> Bring new values of the matrix to the first process where that one solves; what it has factorised stays.
  subroutine bring_matrix(joint, team, matrix)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    !> Value of this process.
    type(sparse_matrix_type), intent(in) :: matrix
    real(wp), allocatable :: values(:)
    integer, allocatable :: first(:)
    integer :: k

    if (team%ranks == 1 .or. joint%together) return
    call collect(team, matrix%values(joint%sent), values, first)
    if (team%rank > 0) return
    joint%matrix%values = 0.0_wp
    do k = 1, size(values)
      associate (entry => joint%matrix%values(joint%place(k)))
        entry = entry + values(k)
      end associate
    end do
  end subroutine bring_matrix

  !> Whether what was factorised last is no more than a preconditioner, whoever solves.
  logical function preconditions_only(joint, team, system) result(only)
    type(joint_system_type), intent(in) :: joint
    type(team_type), intent(in) :: team
    type(linear_system_type), intent(in) :: system

    only = joint%together
    if (team%rank == 0 .and. .not. joint%together) only = system%solver%approximate
    only = any_of(team, only)
  end function preconditions_only

  !> Solve for the matrix taken last.
  subroutine solve_jointly(joint, team, system, equations, matrix, rhs, tolerance, x, error)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    type(linear_system_type), intent(inout) :: system
    !> Value of this process.
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(in) :: matrix
    !> Right-hand side, valid at owned equations (equations).
    real(wp), intent(in) :: rhs(:)
    !> Residual allowed relative to it where the solution is iterated.
    real(wp), intent(in) :: tolerance
    !> Solution, valid at all equations of this process.
    real(wp), intent(out) :: x(:)
    type(error_type), allocatable, intent(out) :: error
    type(error_type), allocatable :: failure
    real(wp), allocatable :: all_rhs(:), all_x(:)

    if (team%ranks == 1) then
      call solve_system(system, matrix, rhs, tolerance, x, error)
      return
    else if (joint%together) then
      call solve_shared_rows(joint%rows, team, rhs, tolerance, sweeps_of_multigrid(joint%choice, tolerance), x, failure)
      system%sweeps = system%sweeps + joint%rows%solver%sweeps
      if (.not. allocated(failure)) return
      call give_way(joint, team, system, equations, matrix, error)
      if (allocated(error)) return
    end if
    allocate (all_rhs(joint%count), all_x(joint%count))
    call collect_rhs(joint, team, rhs, all_rhs)
    all_x = 0.0_wp
    if (team%rank == 0) call solve_system(system, joint%matrix, all_rhs, tolerance, all_x, error)
    call spread_solution(joint, team, all_x, x, error)
  end subroutine solve_jointly

  !> Solve by the factors taken last, which are more than a preconditioner.
  subroutine solve_by_factors(joint, team, system, rhs, x, error)
    type(joint_system_type), intent(in) :: joint
    type(team_type), intent(in) :: team
    type(linear_system_type), intent(inout) :: system
    !> Right-hand side, valid at owned equations (equations).
    real(wp), intent(in) :: rhs(:)
    !> Solution, valid at all equations of this process.
    real(wp), intent(out) :: x(:)
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: all_rhs(joint%count), all_x(joint%count)

    if (team%ranks == 1) then
      call system%solver%solve(rhs, x, error)
      return
    end if
    call collect_rhs(joint, team, rhs, all_rhs)
    all_x = 0.0_wp
    if (team%rank == 0) call system%solver%solve(all_rhs, all_x, error)
    call spread_solution(joint, team, all_x, x, error)
  end subroutine solve_by_factors

  !> Bring the right-hand sides of all to the first process.
  subroutine collect_rhs(joint, team, rhs, all_rhs)
    type(joint_system_type), intent(in) :: joint
    type(team_type), intent(in) :: team
    !> Of this process (equations), and of all.
    real(wp), intent(in) :: rhs(:)
    real(wp), intent(out) :: all_rhs(:)
    real(wp), allocatable :: values(:)
    integer, allocatable :: first(:)

    call collect(team, rhs(joint%own), values, first)
    all_rhs = 0.0_wp
    if (team%rank == 0) all_rhs(joint%own_number) = values
  end subroutine collect_rhs

  !> Give all processes their parts of the solution, unless there is none.
  subroutine spread_solution(joint, team, all_x, x, error)
    type(joint_system_type), intent(in) :: joint
    type(team_type), intent(in) :: team
    !> Of all equations, on the first process; of this process (equations).
    real(wp), intent(inout) :: all_x(:)
    real(wp), intent(out) :: x(:)
    type(error_type), allocatable, intent(inout) :: error

    x = 0.0_wp
    call agree(team, error)
    if (allocated(error)) return
    call spread_from(team, 0, all_x)
    x = all_x(joint%number)
  end subroutine spread_solution
end module qsmpm_joint_system
