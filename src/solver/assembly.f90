!> Assembly: internal forces (eqs. 20, 25) and the stiffness K^E + K^G (eqs. 16-18) of all groups of
!> integration points for a displacement of the step.
!>
!> With the law's Q (first Piola-Kirchhoff stress on the start of the step) and A = dQ/dF,
!>   f_ia = sum V Q_ij N_a,j      K_iakb = sum V N_a,j A_ijkl N_b,l
!> on the start configuration; in axisymmetry the hoop component F_33 = 1 + u_r/r adds N_a/r.
!> Groups are evaluated in parallel into their own blocks and added in group order, so the result
!> does not depend on the number of threads.
module qsmpm_assembly
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_slot_type, batch_type, tangent_none, status_ok
  use qsmpm_integration, only: integration_type
  implicit none
  private

  public :: evaluation_type, evaluate, prepare_evaluation

  !> What an evaluation yields; kept between iterations so that nothing is allocated in the loop.
  type :: evaluation_type
    !> Internal force (dimension, node_count).
    real(wp), allocatable :: force(:, :)
    !> Blocks of the groups (dimension*most nodes squared, group_count), each packed as
    !> (dimension, nodes, dimension, nodes); only when a tangent was asked for.
    real(wp), allocatable :: block(:, :)
    !> End stress (4 or 6, n), state, determinant of F, plastic flag of every integration point.
    real(wp), allocatable :: stress(:, :), state(:, :), volume_change(:)
    integer, allocatable :: plastic(:)
    !> True when every point could be updated.
    logical :: ok = .true.
    !> Otherwise the first integration point that could not.
    integer :: bad_point = 0
    !> Forces of the groups (dimension*most nodes, group_count): scratch.
    real(wp), allocatable :: group_force(:, :)
    integer, allocatable :: group_bad(:)
  end type evaluation_type

contains

  !> Size the arrays for a set of integration points.
  subroutine prepare_evaluation(integration, dimension, node_count, with_blocks, evaluation)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    integer, intent(in) :: dimension, node_count
    !> Room for stiffness blocks is needed.
    logical, intent(in) :: with_blocks
    !> Results of the evaluation.
    type(evaluation_type), intent(out) :: evaluation
    integer :: most

    most = dimension*size(integration%shape, 1)
    allocate (evaluation%force(dimension, node_count))
    allocate (evaluation%group_force(most, integration%group_count))
    allocate (evaluation%group_bad(integration%group_count))
    if (with_blocks) allocate (evaluation%block(most*most, integration%group_count))
    allocate (evaluation%stress, mold=integration%stress)
    allocate (evaluation%state, mold=integration%state)
    allocate (evaluation%volume_change(integration%point_count))
    allocate (evaluation%plastic(integration%point_count))
  end subroutine prepare_evaluation

  !> Stresses, internal forces and, when asked for, stiffness blocks.
  subroutine evaluate(integration, laws, displacement, tangent, evaluation)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> tangent_none, tangent_consistent or tangent_elastic.
    integer, intent(in) :: tangent
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    type(batch_type) :: batch
    integer :: g, a, n, first

    !$omp parallel default(none) shared(integration, laws, displacement, tangent, evaluation) &
    !$omp& private(batch, g)
    call allocate_batch(integration, tangent, batch)
    !$omp do schedule(static)
    do g = 1, integration%group_count
      call evaluate_group(integration, laws, displacement, tangent, g, batch, evaluation)
    end do
    !$omp end do
    !$omp end parallel
    evaluation%force = 0.0_wp
    do g = 1, integration%group_count
      first = integration%node_first(g)
      n = size(displacement, 1)
      do a = first, integration%node_first(g + 1) - 1
        evaluation%force(:, integration%nodes(a)) = evaluation%force(:, integration%nodes(a)) &
          + evaluation%group_force((a - first)*n + 1:(a - first + 1)*n, g)
      end do
    end do
    evaluation%bad_point = 0
    do g = integration%group_count, 1, -1
      if (evaluation%group_bad(g) > 0) evaluation%bad_point = evaluation%group_bad(g)
    end do
    evaluation%ok = evaluation%bad_point == 0
  end subroutine evaluate

  !> Room for the points of the largest group.
  subroutine allocate_batch(integration, tangent, batch)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    !> Which tangent is wanted.
    integer, intent(in) :: tangent
    !> The points handed to the law.
    type(batch_type), intent(out) :: batch
    integer :: most, components

    most = 0
    if (integration%group_count > 0) most = maxval(integration%first(2:) &
      - integration%first(:integration%group_count))
    components = merge(5, 9, size(integration%gradient, 1) == 2)
    allocate (batch%gradient(components, most), batch%piola(components, most))
    allocate (batch%volume_ratio(most), batch%status(most), batch%plastic(most))
    allocate (batch%stress_start(size(integration%stress, 1), most))
    allocate (batch%stress(size(integration%stress, 1), most))
    allocate (batch%state_start(size(integration%state, 1), most))
    allocate (batch%state(size(integration%state, 1), most))
    if (tangent /= tangent_none) allocate (batch%tangent(components, components, most))
  end subroutine allocate_batch

  !> One group: runs of points of equal material go to their law together.
  subroutine evaluate_group(integration, laws, displacement, tangent, group, batch, evaluation)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    integer, intent(in) :: tangent, group
    !> The points handed to the law.
    type(batch_type), intent(inout) :: batch
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    real(wp) :: u(size(displacement, 1), size(integration%shape, 1))
    integer :: n, from, to, q

    n = integration%node_first(group + 1) - integration%node_first(group)
    u(:, :n) = displacement(:, integration%nodes(integration%node_first(group): &
      integration%node_first(group + 1) - 1))
    evaluation%group_force(:, group) = 0.0_wp
    evaluation%group_bad(group) = 0
    if (tangent /= tangent_none) evaluation%block(:, group) = 0.0_wp
    from = integration%first(group)
    do while (from < integration%first(group + 1))
      to = from
      do while (to + 1 < integration%first(group + 1))
        if (integration%material(to + 1) /= integration%material(from)) exit
        to = to + 1
      end do
      call load_batch(integration, from, to, u(:, :n), batch)
      call laws(integration%material(from))%law%update(batch, tangent)
      do q = from, to
        if (batch%status(q - from + 1) == status_ok) cycle
        if (evaluation%group_bad(group) == 0) evaluation%group_bad(group) = q
      end do
      if (evaluation%group_bad(group) > 0) return
      call store_batch(from, to, batch, evaluation)
      call add_forces(integration, from, to, n, batch, evaluation%group_force(:, group))
      if (tangent /= tangent_none) then
        if (size(u, 1) == 2) then
          call add_stiffness_2d(integration, from, to, n, batch, evaluation%block(:, group))
        else
          call add_stiffness_3d(integration, from, to, n, batch, evaluation%block(:, group))
        end if
      end if
      from = to + 1
    end do
  end subroutine evaluate_group

  !> Incremental deformation gradients and start states of a run of points.
  pure subroutine load_batch(integration, from, to, u, batch)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    integer, intent(in) :: from, to
    !> Displacement of the group's nodes (dimension, n).
    real(wp), intent(in) :: u(:, :)
    !> The points handed to the law.
    type(batch_type), intent(inout) :: batch
    integer :: q, k, a, j, d, n

    d = size(u, 1)
    n = size(u, 2)
    batch%count = to - from + 1
    do q = from, to
      k = q - from + 1
      batch%gradient(:, k) = 0.0_wp
      do a = 1, n
        do j = 1, d
          batch%gradient((j - 1)*d + 1:j*d, k) = batch%gradient((j - 1)*d + 1:j*d, k) &
            + u(:, a)*integration%gradient(j, a, q)
        end do
      end do
      do j = 1, d
        batch%gradient((j - 1)*d + j, k) = batch%gradient((j - 1)*d + j, k) + 1.0_wp
      end do
      if (d == 2) then
        batch%gradient(5, k) = 1.0_wp
        if (integration%axisymmetric) batch%gradient(5, k) = 1.0_wp &
          + dot_product(u(1, :), integration%shape(:n, q))/integration%radius(q)
      end if
      batch%volume_ratio(k) = integration%volume_ratio(q)
      batch%stress_start(:, k) = integration%stress(:, q)
      batch%state_start(:, k) = integration%state(:, q)
    end do
  end subroutine load_batch

  !> Keep the results of a run of points.
  pure subroutine store_batch(from, to, batch, evaluation)
    integer, intent(in) :: from, to
    !> The points handed to the law.
    type(batch_type), intent(in) :: batch
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    integer :: q, k

    do q = from, to
      k = q - from + 1
      evaluation%stress(:, q) = batch%stress(:, k)
      evaluation%state(:, q) = batch%state(:, k)
      evaluation%plastic(q) = batch%plastic(k)
      evaluation%volume_change(q) = packed_determinant(batch%gradient(:, k))
    end do
  end subroutine store_batch

  !> Determinant of a packed deformation gradient.
  pure function packed_determinant(f) result(determinant)
    !> (5) or (9)
    real(wp), intent(in) :: f(:)
    real(wp) :: determinant

    if (size(f) == 5) then
      determinant = (f(1)*f(4) - f(2)*f(3))*f(5)
    else
      determinant = f(1)*(f(5)*f(9) - f(6)*f(8)) - f(4)*(f(2)*f(9) - f(3)*f(8)) &
        + f(7)*(f(2)*f(6) - f(3)*f(5))
    end if
  end function packed_determinant

  !> Internal forces of a run of points (eq. 25 on the start configuration).
  pure subroutine add_forces(integration, from, to, n, batch, force)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    !> Range of points and number of nodes.
    integer, intent(in) :: from, to, n
    !> The points handed to the law.
    type(batch_type), intent(in) :: batch
    !> (dimension*nodes)
    real(wp), intent(inout) :: force(:)
    real(wp) :: v
    integer :: q, k, a, j, d

    d = size(integration%gradient, 1)
    do q = from, to
      k = q - from + 1
      v = integration%weight(q)
      do a = 1, n
        do j = 1, d
          force((a - 1)*d + 1:a*d) = force((a - 1)*d + 1:a*d) &
            + v*batch%piola((j - 1)*d + 1:j*d, k)*integration%gradient(j, a, q)
        end do
        if (integration%axisymmetric) force((a - 1)*d + 1) = force((a - 1)*d + 1) &
          + v*batch%piola(5, k)*integration%shape(a, q)/integration%radius(q)
      end do
    end do
  end subroutine add_forces

  !> Stiffness of a run of plane or axisymmetric points.
  pure subroutine add_stiffness_2d(integration, from, to, n, batch, block)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    integer, intent(in) :: from, to, n
    !> The points handed to the law.
    type(batch_type), intent(in) :: batch
    !> (2, n, 2, n)
    real(wp), intent(inout) :: block(2, n, 2, n)
    real(wp) :: t(5, 2), g(2), hoop, v
    integer :: q, k, a, b

    do q = from, to
      k = q - from + 1
      v = integration%weight(q)
      do b = 1, n
        g = v*integration%gradient(:, b, q)
        t(:, 1) = batch%tangent(:, 1, k)*g(1) + batch%tangent(:, 3, k)*g(2)
        t(:, 2) = batch%tangent(:, 2, k)*g(1) + batch%tangent(:, 4, k)*g(2)
        if (integration%axisymmetric) t(:, 1) = t(:, 1) &
          + batch%tangent(:, 5, k)*v*integration%shape(b, q)/integration%radius(q)
        do a = 1, n
          block(:, a, 1, b) = block(:, a, 1, b) + integration%gradient(1, a, q)*t(1:2, 1) &
            + integration%gradient(2, a, q)*t(3:4, 1)
          block(:, a, 2, b) = block(:, a, 2, b) + integration%gradient(1, a, q)*t(1:2, 2) &
            + integration%gradient(2, a, q)*t(3:4, 2)
          if (integration%axisymmetric) then
            hoop = integration%shape(a, q)/integration%radius(q)
            block(1, a, :, b) = block(1, a, :, b) + hoop*t(5, :)
          end if
        end do
      end do
    end do
  end subroutine add_stiffness_2d

  !> Stiffness of a run of points in 3D.
  pure subroutine add_stiffness_3d(integration, from, to, n, batch, block)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    integer, intent(in) :: from, to, n
    !> The points handed to the law.
    type(batch_type), intent(in) :: batch
    !> (3, n, 3, n)
    real(wp), intent(inout) :: block(3, n, 3, n)
    real(wp) :: t(9), g(3), h(3, n)
    integer :: q, k, a, b, i

    do q = from, to
      k = q - from + 1
      h = integration%gradient(:, :n, q)
      do b = 1, n
        g = integration%weight(q)*h(:, b)
        do i = 1, 3
          t = batch%tangent(:, i, k)*g(1) + batch%tangent(:, 3 + i, k)*g(2) &
            + batch%tangent(:, 6 + i, k)*g(3)
          do a = 1, n
            block(:, a, i, b) = block(:, a, i, b) + h(1, a)*t(1:3) + h(2, a)*t(4:6) + h(3, a)*t(7:9)
          end do
        end do
      end do
    end do
  end subroutine add_stiffness_3d
end module qsmpm_assembly
