!> Assembly of internal forces (eqs. 20, 25) and of the stiffness K^E + K^G (eqs. 15-17) of all groups of integration
!> points for a displacement of the step.
!>
!> With the law's Q (first Piola-Kirchhoff stress relative to the configuration at the start of the step) and A = dQ/dF,
!>   f_ia = sum V Q_ij N_a,j      K_iakb = sum V N_a,j A_ijkl N_b,l
!> in the configuration at the start of the step; in axisymmetry the hoop component F_33 = 1 + u_r/r adds N_a/r. Threads
!> process chunks of groups in turn. A thread evaluates the groups of its chunk, each into a separate block, and adds
!> them after the preceding chunks have been added: in the order of the groups, so that the result does not depend on
!> the number of threads. The blocks are added from the cache of the thread while others evaluate, and each thread
!> stores the blocks of one chunk only. Points of a material with a pressure factor share one pressure in their group
!> (qsmpm_uniform_pressure).
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

  !> Numbers in the blocks of a chunk, so that they stay in the cache until they are added, and number of chunks of an
  !> evaluation, so that threads can process them in turn.
  integer, parameter :: cached = 2**15, chunks = 24
  !> Number of points above which an evaluation, some 0.2 microseconds per point, is distributed over threads.
  integer, parameter :: fewest_points = 2000

  !> Results of an evaluation; kept between iterations so that nothing is allocated in the loop.
  type :: evaluation_type
    !> Internal force, and the sum of the magnitudes of the contributions of the groups (dimension, node_count).
    real(wp), allocatable :: force(:, :), force_size(:, :)
    !> Sum over the groups of the magnitude of the work of the internal force on the displacement.
    real(wp) :: work_size = 0.0_wp
    !> Cells whose groups contribute to it; all if unallocated (cells).
    logical, allocatable :: counted(:)
    !> Force of the tangent due to the prescribed displacements (dimension, node_count).
    real(wp), allocatable :: linear_force(:, :)
    !> Final stress, state, volume change and yielding of the integration points, where requested.
    type(results_type) :: results
    !> Every point could be updated.
    logical :: ok = .true.
    !> First integration point that could not be updated.
    integer :: bad_point = 0
    !> Result of its law: one of the status_* values, the share of the step to be tried next (0 if not specified), and a
    !> message.
    integer :: bad_status = status_ok
    real(wp) :: bad_share = 0.0_wp
    character(len=:), allocatable :: bad_message
    !> Pressure of each integration point relative to the common one of its group, due to weight and water, at the start
    !> and the end of the step [stress]; 0 if unallocated (n, 2).
    real(wp), allocatable :: pressure_offset(:, :)
    !> Points remain in their groups from step to step, so that their pressure differences persist.
    logical :: lasting = .false.
    !> Pore water drains in the step: groups that have not yielded do not share a pressure.
    logical :: draining = .false.
    !> Nodal values of the nonlocal strain at the end of the step; unallocated without this field (nodes).
    real(wp), allocatable :: field(:)
    !> Time of the step, for the laws.
    type(step_info_type) :: step_info
    !> Number of groups of a chunk.
    integer :: chunk = 0
    !> Blocks of the groups of the chunks being processed (dimension*most nodes squared, groups), each packed as (nodes,
    !> dimension, dimension, nodes); of all groups where they are stored.
    real(wp), allocatable :: block(:, :)
    logical :: keeps_blocks = .false.
    !> Forces of these groups (dimension*most nodes, groups), and their first points that could not be updated.
    real(wp), allocatable :: group_force(:, :)
    integer, allocatable :: group_bad(:)
    !> Work space of every thread.
    type(work_type), allocatable :: work(:)
  end type evaluation_type

contains

  !> Allocates the arrays for a set of integration points; arrays of the correct size are retained.
  subroutine prepare_evaluation(integration, dimension, node_count, keep_results, keep_blocks, evaluation, &
      keep_gradients)
    type(integration_type), intent(in) :: integration
    !> 2 or 3.
    integer, intent(in) :: dimension, node_count
    !> The results of the laws at the points are requested.
    logical, intent(in) :: keep_results
    !> The blocks of all groups are requested.
    logical, intent(in) :: keep_blocks
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    !> The deformation gradients are also requested; false when absent.
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

  !> Allocates the results of some points.
  pure subroutine size_results(integration, count, results)
    type(integration_type), intent(in) :: integration
    !> Number of points whose results are stored.
    integer, intent(in) :: count
    !> Results of the laws.
    type(results_type), intent(inout) :: results

    if (allocated(results%plastic)) then
      if (size(results%plastic) == count .and. size(results%state, 1) == size(integration%state, 1)) return
      deallocate (results%stress, results%state, results%volume_change, results%plastic)
    end if
    allocate (results%stress(size(integration%stress, 1), count), results%state(size(integration%state, 1), count), &
      results%volume_change(count))
    allocate (results%plastic(count))
  end subroutine size_results

  !> Computes stresses, internal forces and, if requested, the stiffness, which is added to a matrix if there is one.
  !> Where a point cannot be updated the following points are evaluated nevertheless: the share of the step to be tried
  !> next is the smallest requested at any point, independent of the distribution of points over threads and processes.
  subroutine evaluate(integration, points, laws, displacement, tangent, evaluation, equations, first_stencil, matrix, &
    prescribed)
    type(integration_type), intent(in) :: integration
    !> The material points, with the initial states of those that are integration points.
    type(points_type), intent(in) :: points
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> tangent_none, tangent_consistent or tangent_elastic.
    integer, intent(in) :: tangent
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    !> The equations, the number of the node list of the first group, and the matrix to which the stiffness is added.
    type(equations_type), intent(in), optional :: equations
    integer, intent(in), optional :: first_stencil
    type(sparse_matrix_type), intent(inout), optional :: matrix
    !> Displacements whose linear force is requested, most of them zero (dimension, node_count).
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

  !> Evaluates the groups of a chunk separately.
  subroutine evaluate_chunk(integration, points, laws, displacement, tangent, start, last, before, me, evaluation)
    type(integration_type), intent(in) :: integration
    type(points_type), intent(in) :: points
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Kind of tangent, first and last group, number of blocks stored before theirs, and thread.
    integer, intent(in) :: tangent, start, last, before, me
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    integer :: g, k

    evaluation%work(me)%batch%share = 0.0_wp
    evaluation%work(me)%pressure%lasting = evaluation%lasting
    evaluation%work(me)%pressure%draining = evaluation%draining
    do g = start, last
      k = before + g - start + 1
      call evaluate_group(integration, points, laws, displacement, tangent, g, evaluation%work(me), &
        evaluation%results, evaluation%group_force(:, k), evaluation%block(:, k), evaluation%group_bad(k), &
        evaluation%pressure_offset, evaluation%field)
    end do
  end subroutine evaluate_chunk

  !> Retrieves the message of the law for the first point that could not be updated. The law is evaluated again, because
  !> another thread may have evaluated it since.
  subroutine ask_why(integration, points, laws, displacement, tangent, evaluation)
    type(integration_type), intent(in) :: integration
    type(points_type), intent(in) :: points
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Kind of tangent that was requested.
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

  !> Returns the smaller one of two specified shares, 0 if none is specified.
  pure real(wp) function smaller_share(share, other)
    real(wp), intent(in) :: share, other

    smaller_share = max(share, other)
    if (min(share, other) > 0.0_wp) smaller_share = min(share, other)
  end function smaller_share

  !> Sets the sums to zero.
  subroutine begin(evaluation, prescribed)
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    !> Displacements whose linear force is requested.
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
      ! The mesh may have been generated again.
      if (size(evaluation%linear_force, 2) /= size(evaluation%force, 2)) deallocate (evaluation%linear_force)
    end if
    if (.not. allocated(evaluation%linear_force)) allocate (evaluation%linear_force, mold=evaluation%force)
    evaluation%linear_force = 0.0_wp
  end subroutine begin

  !> Adds forces and blocks of a chunk of groups, in their order.
  subroutine add_chunk(integration, start, last, before, displacement, tangent, evaluation, equations, first_stencil, &
    matrix, prescribed)
    type(integration_type), intent(in) :: integration
    !> First and last group, and number of blocks stored before theirs.
    integer, intent(in) :: start, last, before
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Kind of tangent that was requested.
    integer, intent(in) :: tangent
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    !> The equations, the number of the node list of the first group, and the matrix.
    type(equations_type), intent(in), optional :: equations
    integer, intent(in), optional :: first_stencil
    type(sparse_matrix_type), intent(inout), optional :: matrix
    !> Displacements whose linear force is requested.
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

  !> Returns whether the work of a group is counted.
  pure logical function is_counted(evaluation, cell)
    type(evaluation_type), intent(in) :: evaluation
    integer, intent(in) :: cell

    is_counted = .true.
    if (allocated(evaluation%counted)) is_counted = evaluation%counted(cell)
  end function is_counted

  !> Adds the block of a group with explicit shape.
  subroutine add_packed(equations, stencil, dimension, n, block, matrix)
    type(equations_type), intent(in) :: equations
    !> Number of the node list, 2 or 3, and number of nodes.
    integer, intent(in) :: stencil, dimension, n
    real(wp), intent(in) :: block(n, dimension, dimension, n)
    type(sparse_matrix_type), intent(inout) :: matrix

    call add_products(equations, stencil, block, matrix)
  end subroutine add_packed

  !> Adds the product of the block of a group with the displacements of its nodes, unless these are zero.
  pure subroutine add_product(nodes, dimension, n, block, displacement, force)
    !> Nodes of the group (n), 2 or 3.
    integer, intent(in) :: nodes(:), dimension, n
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

  !> Returns the number of threads of a parallel region.
  integer function thread_count()
    thread_count = 1
    !$ thread_count = omp_get_max_threads()
  end function thread_count
end module qsmpm_assembly
