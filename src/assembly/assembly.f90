!> Assembly: internal forces (eqs. 20, 25) and the stiffness K^E + K^G (eqs. 15-17) of all groups of
!> integration points for a displacement of the step.
!>
!> With the law's Q (first Piola-Kirchhoff stress on the start of the step) and A = dQ/dF,
!>   f_ia = sum V Q_ij N_a,j      K_iakb = sum V N_a,j A_ijkl N_b,l
!> on the start configuration; in axisymmetry the hoop component F_33 = 1 + u_r/r adds N_a/r.
!> Threads take chunks of groups in turns. A thread evaluates the groups of its chunk, each into a block of its own,
!> and adds them when the chunks before have been added: in group order, so that the result does not depend on the
!> number of threads. It adds from its own cache, while others evaluate; and there is no more than one chunk of blocks
!> a thread. Points of a material with a pressure factor share one pressure in their group (qsmpm_uniform_pressure).
module qsmpm_assembly
  !$ use omp_lib, only: omp_get_max_threads, omp_get_thread_num
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_slot_type, step_info_type, tangent_none, status_ok
  use qsmpm_points, only: points_type
  use qsmpm_integration, only: integration_type, group_of
  use qsmpm_equations, only: equations_type
  use qsmpm_matrix_blocks, only: add_products
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_group_evaluation, only: results_type, work_type, allocate_work, evaluate_group
  implicit none
  private

  public :: evaluation_type, evaluate, prepare_evaluation

  !> Numbers in the blocks of a chunk, so that they stay in the cache until they are added, and chunks of an evaluation,
  !> so that threads have something to take in turns.
  integer, parameter :: cached = 2**15, chunks = 24
  !> Points from which an evaluation, some 0.2 microseconds each, is worth waking the threads.
  integer, parameter :: fewest_points = 2000

  !> What an evaluation yields; kept between iterations so that nothing is allocated in the loop.
  type :: evaluation_type
    !> Internal force, and the same with the contributions of the groups by their size (dimension, node_count).
    real(wp), allocatable :: force(:, :), force_size(:, :)
    !> Work of the internal force on the displacement, that of every group by its size.
    real(wp) :: work_size = 0.0_wp
    !> Cells whose groups count in it; all where it is unallocated (cells).
    logical, allocatable :: counted(:)
    !> Force that the tangent gives the prescribed displacements (dimension, node_count).
    real(wp), allocatable :: linear_force(:, :)
    !> End stress, state, volume change and yielding of the integration points, where they are kept.
    type(results_type) :: results
    !> True when every point could be updated.
    logical :: ok = .true.
    !> Otherwise the first integration point that could not.
    integer :: bad_point = 0
    !> What its law said: one of the status_* values, the share of the step to be tried next (0 for no
    !> opinion), and a sentence.
    integer :: bad_status = status_ok
    real(wp) :: bad_share = 0.0_wp
    character(len=:), allocatable :: bad_message
    !> Pressure of each integration point less the common one of its group, by weight and water at the start and the
    !> end of the step [stress]; 0 where unallocated (n, 2).
    real(wp), allocatable :: pressure_offset(:, :)
    !> Points stay in their groups from step to step: what their pressures differ by lasts.
    logical :: lasting = .false.
    !> Nodal values of the nonlocal strain at the end of the step; unallocated without (nodes).
    real(wp), allocatable :: field(:)
    !> When the step takes place, for the laws.
    type(step_info_type) :: step_info
    !> Groups of a chunk.
    integer :: chunk = 0
    !> Blocks of the groups of the chunks that the threads are at (dimension*most nodes squared, groups), each packed as
    !> (nodes, dimension, dimension, nodes); of all groups where they are kept.
    real(wp), allocatable :: block(:, :)
    logical :: keeps_blocks = .false.
    !> Forces of these groups (dimension*most nodes, groups), and first points that could not be updated.
    real(wp), allocatable :: group_force(:, :)
    integer, allocatable :: group_bad(:)
    !> Work space of every thread.
    type(work_type), allocatable :: work(:)
  end type evaluation_type

contains

  !> Size the arrays for a set of integration points; arrays of the right size are kept.
  subroutine prepare_evaluation(integration, dimension, node_count, keep_results, keep_blocks, evaluation, &
      keep_gradients)
    type(integration_type), intent(in) :: integration
    !> 2 or 3.
    integer, intent(in) :: dimension
    integer, intent(in) :: node_count
    !> The laws' results at the points are wanted.
    logical, intent(in) :: keep_results
    !> The blocks of all groups are wanted.
    logical, intent(in) :: keep_blocks
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    !> The deformation gradients are results as well; they are not unless this is given.
    logical, intent(in), optional :: keep_gradients
    integer :: most, groups
    logical :: gradients

    most = dimension*maxval([0, integration%node_first(2:) - integration%node_first(:integration%group_count)])
    evaluation%chunk = max(1, min(cached/max(1, most)**2, integration%group_count/chunks))
    evaluation%keeps_blocks = keep_blocks
    groups = evaluation%chunk*thread_count()
    if (keep_blocks) groups = integration%group_count
    if (allocated(evaluation%work)) deallocate (evaluation%work)
    allocate (evaluation%work(thread_count()))
    if (allocated(evaluation%force)) then
      if (size(evaluation%force, 2) /= node_count) deallocate (evaluation%force, evaluation%force_size)
    end if
    if (.not. allocated(evaluation%force)) allocate (evaluation%force(dimension, node_count), &
      evaluation%force_size(dimension, node_count))
    if (allocated(evaluation%block)) then
      if (size(evaluation%block, 1) /= most**2 .or. size(evaluation%block, 2) /= groups) &
        deallocate (evaluation%block, evaluation%group_force, evaluation%group_bad)
    end if
    if (.not. allocated(evaluation%block)) allocate (evaluation%block(most**2, groups), &
      evaluation%group_force(most, groups), evaluation%group_bad(groups))
    gradients = .false.
    if (present(keep_gradients)) gradients = keep_gradients .and. keep_results
    call size_results(integration, merge(integration%point_count, 0, keep_results), evaluation%results)
    if (allocated(evaluation%results%gradient)) then
      if (size(evaluation%results%gradient, 2) /= merge(integration%point_count, 0, gradients)) &
        deallocate (evaluation%results%gradient)
    end if
    if (.not. allocated(evaluation%results%gradient)) allocate (evaluation%results%gradient( &
      merge(5, 9, dimension == 2), merge(integration%point_count, 0, gradients)))
  end subroutine prepare_evaluation

  !> Room for the results of some points.
  pure subroutine size_results(integration, count, results)
    type(integration_type), intent(in) :: integration
    !> Number of points whose results are kept.
    integer, intent(in) :: count
    !> What the laws say.
    type(results_type), intent(inout) :: results

    if (allocated(results%plastic)) then
      if (size(results%plastic) == count .and. size(results%state, 1) == size(integration%state, 1)) return
      deallocate (results%stress, results%state, results%volume_change, results%plastic)
    end if
    allocate (results%stress(size(integration%stress, 1), count), results%state(size(integration%state, 1), count), &
      results%volume_change(count))
    allocate (results%plastic(count))
  end subroutine size_results

  !> Stresses, internal forces and, when asked for, stiffness: added to a matrix when there is one. Where a point
  !> cannot be updated those behind it are asked too: the share of the step to be tried next is the smallest that any
  !> point asks for, however the points are shared by threads and processes.
  subroutine evaluate(integration, points, laws, displacement, tangent, evaluation, equations, first_stencil, matrix, &
    prescribed)
    type(integration_type), intent(in) :: integration
    !> The material points, with the start state of those that are integrated at.
    type(points_type), intent(in) :: points
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> tangent_none, tangent_consistent or tangent_elastic.
    integer, intent(in) :: tangent
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    !> The equations, the patch that is the first group, and the matrix to add to.
    type(equations_type), intent(in), optional :: equations
    integer, intent(in), optional :: first_stencil
    type(sparse_matrix_type), intent(inout), optional :: matrix
    !> Displacements whose linear force is wanted, most of them zero (dimension, node_count).
    real(wp), intent(in), optional :: prescribed(:, :)
    integer :: start, last, before, me

    call begin(evaluation, prescribed)
    !$omp parallel default(shared) private(start, last, before, me) if (integration%point_count >= fewest_points)
    me = 1
    !$ me = omp_get_thread_num() + 1
    call allocate_work(integration, laws, size(displacement, 1), tangent, evaluation%work(me))
    evaluation%work(me)%batch%step_info = evaluation%step_info
    !$omp do ordered schedule(dynamic)
    do start = 1, integration%group_count, evaluation%chunk
      last = min(integration%group_count, start + evaluation%chunk - 1)
      before = merge(start - 1, (me - 1)*evaluation%chunk, evaluation%keeps_blocks)
      call evaluate_chunk(integration, points, laws, displacement, tangent, start, last, before, me, evaluation)
      !$omp ordered
      call add_chunk(integration, start, last, before, displacement, tangent, evaluation, equations, first_stencil, &
        matrix, prescribed)
      evaluation%bad_share = smaller_share(evaluation%bad_share, evaluation%work(me)%batch%share)
      !$omp end ordered
    end do
    !$omp end do
    !$omp end parallel
    evaluation%ok = evaluation%bad_point == 0
    if (.not. evaluation%ok) call ask_why(integration, points, laws, displacement, tangent, evaluation)
  end subroutine evaluate

  !> The groups of a chunk, each by itself.
  subroutine evaluate_chunk(integration, points, laws, displacement, tangent, start, last, before, me, evaluation)
    type(integration_type), intent(in) :: integration
    type(points_type), intent(in) :: points
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Which tangent is wanted, the groups, how many blocks stand before theirs, and the thread.
    integer, intent(in) :: tangent, start, last, before, me
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    integer :: g, k

    evaluation%work(me)%batch%share = 0.0_wp
    evaluation%work(me)%pressure%lasting = evaluation%lasting
    do g = start, last
      k = before + g - start + 1
      call evaluate_group(integration, points, laws, displacement, tangent, g, evaluation%work(me), &
        evaluation%results, evaluation%group_force(:, k), evaluation%block(:, k), evaluation%group_bad(k), &
        evaluation%pressure_offset, evaluation%field)
    end do
  end subroutine evaluate_chunk

  !> What the law says of the first point that it could not update: it is asked again, because another thread may
  !> have asked it something else since.
  subroutine ask_why(integration, points, laws, displacement, tangent, evaluation)
    type(integration_type), intent(in) :: integration
    type(points_type), intent(in) :: points
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Which tangent was wanted.
    integer, intent(in) :: tangent
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    integer :: bad, group

    group = group_of(integration, evaluation%bad_point)
    associate (batch => evaluation%work(1)%batch)
      batch%share = 0.0_wp
      if (allocated(batch%message)) deallocate (batch%message)
      call evaluate_group(integration, points, laws, displacement, tangent, group, evaluation%work(1), &
        evaluation%results, evaluation%group_force(:, 1), evaluation%block(:, 1), bad, &
        evaluation%pressure_offset, evaluation%field)
      evaluation%bad_status = maxval(batch%status(:batch%count))
      if (allocated(batch%message)) call move_alloc(batch%message, evaluation%bad_message)
    end associate
  end subroutine ask_why

  !> The smaller one of two shares that are opinions, 0 when none is.
  pure real(wp) function smaller_share(share, other)
    real(wp), intent(in) :: share, other

    smaller_share = max(share, other)
    if (min(share, other) > 0.0_wp) smaller_share = min(share, other)
  end function smaller_share

  !> Clear what is summed up.
  subroutine begin(evaluation, prescribed)
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    !> Displacements whose linear force is wanted.
    real(wp), intent(in), optional :: prescribed(:, :)

    evaluation%force = 0.0_wp
    evaluation%force_size = 0.0_wp
    evaluation%work_size = 0.0_wp
    evaluation%bad_point = 0
    evaluation%bad_status = status_ok
    evaluation%bad_share = 0.0_wp
    if (allocated(evaluation%bad_message)) deallocate (evaluation%bad_message)
    if (.not. present(prescribed)) return
    if (allocated(evaluation%linear_force)) then
      ! The mesh may have been rebuilt.
      if (size(evaluation%linear_force, 2) /= size(evaluation%force, 2)) deallocate (evaluation%linear_force)
    end if
    if (.not. allocated(evaluation%linear_force)) allocate (evaluation%linear_force, mold=evaluation%force)
    evaluation%linear_force = 0.0_wp
  end subroutine begin

  !> Add forces and blocks of a chunk of groups, in their order.
  subroutine add_chunk(integration, start, last, before, displacement, tangent, evaluation, equations, first_stencil, &
    matrix, prescribed)
    type(integration_type), intent(in) :: integration
    !> The groups, and how many blocks stand before theirs.
    integer, intent(in) :: start, last, before
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Which tangent was wanted.
    integer, intent(in) :: tangent
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    !> The equations, the patch that is the first group, and the matrix.
    type(equations_type), intent(in), optional :: equations
    integer, intent(in), optional :: first_stencil
    type(sparse_matrix_type), intent(inout), optional :: matrix
    !> Displacements whose linear force is wanted.
    real(wp), intent(in), optional :: prescribed(:, :)
    real(wp) :: work
    integer :: g, k, a, n, d

    d = size(evaluation%force, 1)
    do g = start, last
      k = before + g - start + 1
      if (evaluation%group_bad(k) > 0) evaluation%bad_point = evaluation%group_bad(k)
      if (evaluation%bad_point > 0) return
      associate (nodes => integration%nodes(integration%node_first(g):integration%node_first(g + 1) - 1))
        n = size(nodes)
        work = 0.0_wp
        do a = 1, n
          associate (force => evaluation%group_force((a - 1)*d + 1:a*d, k), node => nodes(a))
            evaluation%force(:, node) = evaluation%force(:, node) + force
            evaluation%force_size(:, node) = evaluation%force_size(:, node) + abs(force)
            work = work + sum(force*displacement(:, node))
          end associate
        end do
        if (is_counted(evaluation, integration%cell(g))) evaluation%work_size = evaluation%work_size + abs(work)
        if (tangent == tangent_none) cycle
        if (present(matrix)) call add_packed(equations, first_stencil + g - 1, d, n, &
          evaluation%block(1, k), matrix)
        if (present(prescribed)) call add_product(nodes, d, n, evaluation%block(1, k), prescribed, &
          evaluation%linear_force)
      end associate
    end do
  end subroutine add_chunk

  !> Whether the work of a group counts.
  pure logical function is_counted(evaluation, cell)
    type(evaluation_type), intent(in) :: evaluation
    integer, intent(in) :: cell

    is_counted = .true.
    if (allocated(evaluation%counted)) is_counted = evaluation%counted(cell)
  end function is_counted

  !> Add a group's block, unpacked by shape.
  subroutine add_packed(equations, stencil, dimension, n, block, matrix)
    type(equations_type), intent(in) :: equations
    !> The patch, 2 or 3, and the number of nodes.
    integer, intent(in) :: stencil
    integer, intent(in) :: dimension
    integer, intent(in) :: n
    real(wp), intent(in) :: block(n, dimension, dimension, n)
    type(sparse_matrix_type), intent(inout) :: matrix

    call add_products(equations, stencil, block, matrix)
  end subroutine add_packed

  !> Product of a group's block with displacements of its nodes; nothing when these are zero.
  pure subroutine add_product(nodes, dimension, n, block, displacement, force)
    !> Nodes of the group (n), 2 or 3.
    integer, intent(in) :: nodes(:)
    integer, intent(in) :: dimension
    integer, intent(in) :: n
    real(wp), intent(in) :: block(n, dimension, dimension, n)
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    !> (dimension, node_count)
    real(wp), intent(inout) :: force(:, :)
    integer :: a, b, k

    do b = 1, n
      do k = 1, dimension
        if (.not. abs(displacement(k, nodes(b))) > 0.0_wp) cycle
        do a = 1, n
          force(:, nodes(a)) = force(:, nodes(a)) + block(a, :, k, b)*displacement(k, nodes(b))
        end do
      end do
    end do
  end subroutine add_product

  !> Threads that a parallel region gets.
  integer function thread_count()
    thread_count = 1
    !$ thread_count = omp_get_max_threads()
  end function thread_count
end module qsmpm_assembly
