!> The equations of a team of processes. Each process has the complete rows of its own nodes (qsmpm_own_part). With
!> PETSc all processes solve together (qsmpm_shared_rows). For any other solver, and if PETSc fails, they send their
!> rows to the first process, which numbers, factorises and solves like a single process, and the solution is
!> distributed: this is exact, but requires the time and memory of one process. A single process sends nothing.
!>
!> A list of coupled nodes is sent by the owner of its first node. An entry of one triangle is sent by the owner of its
!> row in the joint numbering, which has all contributions to it. Unknowns that belong to no node are those of the
!> first process; entries that couple one of them to a node are sent by the owner of the node, and entries that couple
!> them to each other are summed over all processes. PETSc does not support such rows, which would extend over all
!> processes; the first process then solves.
module qsmpm_joint_system
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: agree, any_of
  use qsmpm_method_description, only: solver_choice_type, solver_petsc
  use qsmpm_equations, only: equations_type, number_equations, one_triangle, equations_of
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
    !> Whether all processes solve together; whether it has been reported that they cannot.
    logical :: together = .false., told = .false.
    type(shared_rows_type) :: rows
    !> Whether PETSc has been started, which all processes do at the same time.
    logical :: started = .false.
    !> Solver requested in the deck; names, owners and locations of the nodes of this process, needed if PETSc fails.
    type(solver_choice_type) :: choice
    integer, allocatable :: labels(:), owner(:)
    real(wp), allocatable :: own_places(:, :)
    !> Equations of all processes and their matrix; on the first process.
    type(equations_type) :: equations
    type(sparse_matrix_type) :: matrix
    !> Number of joint equations; joint number of each equation of this process (equations).
    integer :: count = 0
    !> Locations of the joint nodes (dimension, nodes).
    real(wp), allocatable :: places(:, :)
    integer, allocatable :: number(:)
    !> Matrix values and equations sent by this process.
    integer, allocatable :: sent(:), own(:)
    !> Equations of unknowns that belong to no node (equations).
    logical, allocatable :: common(:)
    !> Their positions in the joint matrix and equations; on the first process.
    integer(long), allocatable :: place(:), own_number(:)
  end type joint_system_type

contains

  !> Numbers the equations of all processes and creates a solver for them.
  subroutine start_joint_system(joint, team, system, choice, equations, matrix, labels, owner, places, error)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    type(linear_system_type), intent(inout) :: system
    !> Solver requested in the deck.
    type(solver_choice_type), intent(in) :: choice
    !> Numbered equations of this process and the pattern of its matrix.
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(in) :: matrix
    !> Names of the nodes, negative for unknowns that belong to none; ranks that own them (nodes); their locations
    !> (dimension, nodes).
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
    joint%common = equations_of(equations, labels < 0)
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

  !> Starts the library on all processes at the same time, as it requires; later the first one may call it alone.
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

  !> Starts a solve as in a run continued from here: nothing of an older matrix is used.
  subroutine begin_joint_system(joint)
    type(joint_system_type), intent(inout) :: joint

    if (joint%together) joint%rows%solver%afresh = .true.
  end subroutine begin_joint_system

  !> Ends a solve: the multigrid of all processes is freed and the next solve creates a new one.
  subroutine leave_joint_system(joint)
    type(joint_system_type), intent(inout) :: joint

    if (joint%together) call joint%rows%solver%forget()
  end subroutine leave_joint_system

  !> Frees all data.
  subroutine end_joint_system(joint)
    type(joint_system_type), intent(inout) :: joint

    call end_shared_rows(joint%rows)
    joint%together = .false.
  end subroutine end_joint_system

  !> Numbers the equations of all processes on the first one and creates a solver for them there.
  subroutine put_together(joint, team, system, equations, matrix, error)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    type(linear_system_type), intent(inout) :: system
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: joint_labels(:)
    logical :: own(size(joint%owner))

    own = joint%owner == team%rank
    joint%equations%solver_kind = kind_for(system, joint%choice)
    call spread_from(team, 0, joint%equations%solver_kind)
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

  !> Transfers the equations after a failure of the joint solution to the first process, which solves from then on.
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

  !> Collects nodes and node lists of all processes on the first one and numbers the equations there.
  subroutine collect_graph(joint, team, equations, labels, own, places, joint_labels, error)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    type(equations_type), intent(in) :: equations
    integer, intent(in) :: labels(:)
    logical, intent(in) :: own(:)
    real(wp), intent(in) :: places(:, :)
    !> Labels of all nodes, ascending; on the first process.
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

  !> Returns the node lists whose first node is owned, by labels, each preceded by its length.
  pure function own_lists(connectivity, labels, own) result(lists)
    type(connectivity_type), intent(in) :: connectivity
    !> Names of the nodes; which ones are owned (nodes).
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

  !> Numbers the equations of all processes.
  subroutine number_all(joint, joint_labels, bits, places, lists, error)
    type(joint_system_type), intent(inout) :: joint
    !> Labels, constrained components and locations of all nodes.
    integer, intent(in) :: joint_labels(:), bits(:)
    real(wp), intent(in) :: places(:, :)
    !> Node lists by labels, each preceded by its length.
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

  !> Finds the joint numbers of the equations of this process.
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

  !> Finds the entries and equations sent by this process and their positions.
  subroutine find_sent(joint, team, equations, matrix, own, error)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(in) :: matrix
    !> Whether each node is owned (nodes).
    logical, intent(in) :: own(:)
    type(error_type), allocatable, intent(out) :: error
    logical :: own_equation(equations%count)
    integer(long), allocatable :: entries(:), all_entries(:)
    integer, allocatable :: first(:)
    logical :: common(joint%count)
    integer :: i

    own_equation = equations_of(equations, own)
    joint%own = pack([(i, i=1, equations%count)], own_equation)
    call collect(team, int(joint%number(joint%own), long), joint%own_number, first)
    call list_entries(matrix, joint%number, own_equation, joint%common, one_triangle(joint%equations), joint%sent, &
      entries)
    call collect(team, entries, all_entries, first)
    common = .false.
    common(pack(joint%number, joint%common)) = .true.
    if (team%rank == 0) call place_entries(joint%matrix, common, all_entries, joint%place, error)
  end subroutine find_sent

  !> Lists the entries whose rows are owned in the joint numbering, those that couple owned nodes with unknowns of no
  !> node, and all entries between the latter, for one triangle or both.
  pure subroutine list_entries(matrix, number, own, common, triangle, sent, entries)
    !> Matrix of this process.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Joint number of each equation of this process; which are owned; which belong to no node (equations).
    integer, intent(in) :: number(:)
    logical, intent(in) :: own(:), common(:)
    !> Whether the joint matrix stores one triangle.
    logical, intent(in) :: triangle
    !> Positions of the values in the matrix; their rows and columns alternately, in the joint numbering.
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

  !> Finds the positions of entries in a matrix.
  pure subroutine place_entries(matrix, common, entries, place, error)
    type(sparse_matrix_type), intent(in) :: matrix
    !> Rows between which every process contributes to an entry (equations).
    logical, intent(in) :: common(:)
    !> Rows and columns alternately.
    integer(long), intent(in) :: entries(:)
    integer(long), allocatable, intent(out) :: place(:)
    !> Set when the entries are not exactly those of the matrix.
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

  !> Takes new values of the matrix.
  recursive subroutine factorise_jointly(joint, team, system, equations, matrix, error)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    type(linear_system_type), intent(inout) :: system
    !> Equations of this process.
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

  !> Sends new values of the matrix to the first process if it solves; its factors are retained.
  subroutine bring_matrix(joint, team, matrix)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    !> Matrix of this process.
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

  !> Returns whether the last factorisation is only a preconditioner, whichever process solves.
  logical function preconditions_only(joint, team, system) result(only)
    type(joint_system_type), intent(in) :: joint
    type(team_type), intent(in) :: team
    type(linear_system_type), intent(in) :: system

    only = joint%together
    if (team%rank == 0 .and. .not. joint%together) only = system%solver%approximate
    only = any_of(team, only)
  end function preconditions_only

  !> Solves for the matrix taken last.
  subroutine solve_jointly(joint, team, system, equations, matrix, rhs, tolerance, x, error)
    type(joint_system_type), intent(inout) :: joint
    type(team_type), intent(in) :: team
    type(linear_system_type), intent(inout) :: system
    !> Equations of this process.
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(in) :: matrix
    !> Right-hand side, valid at owned equations (equations).
    real(wp), intent(in) :: rhs(:)
    !> Residual allowed relative to the right-hand side for iterative solutions.
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

  !> Solves with the factors taken last, which are not only a preconditioner.
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

  !> Collects the right-hand sides of all processes on the first one.
  subroutine collect_rhs(joint, team, rhs, all_rhs)
    type(joint_system_type), intent(in) :: joint
    type(team_type), intent(in) :: team
    !> Right-hand side of this process (equations); of all processes.
    real(wp), intent(in) :: rhs(:)
    real(wp), intent(out) :: all_rhs(:)
    real(wp), allocatable :: values(:)
    integer, allocatable :: first(:)

    call collect(team, rhs(joint%own), values, first)
    all_rhs = 0.0_wp
    if (team%rank == 0) all_rhs(joint%own_number) = values
  end subroutine collect_rhs

  !> Distributes the solution to all processes, unless there is none.
  subroutine spread_solution(joint, team, all_x, x, error)
    type(joint_system_type), intent(in) :: joint
    type(team_type), intent(in) :: team
    !> Solution of all equations, on the first process; of this process (equations).
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
