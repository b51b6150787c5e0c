!> Evaluation of one group of integration points: deformation gradients, the law of each material,
!> internal force and stiffness block.
!>
!> Runs of points of one material go to their law together; where the material asks for it they share
!> one pressure (qsmpm_uniform_pressure). A group writes to its own places of the results only.
module qsmpm_group_evaluation
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_slot_type, batch_type, tangent_none, status_ok
  use qsmpm_integration, only: integration_type
  use qsmpm_pressure_balance, only: pressure_type, allocate_pressure, packed_determinant
  use qsmpm_uniform_pressure, only: find_pressure
  use qsmpm_group_stiffness, only: add_forces, add_stiffness_2d, add_stiffness_3d, add_pressure_stiffness
  implicit none
  private

  public :: evaluation_type, allocate_batch, evaluate_group

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

  !> Room for the points of the largest group.
  subroutine allocate_batch(integration, laws, tangent, batch, pressure)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Which tangent is wanted.
    integer, intent(in) :: tangent
    !> The points handed to the law.
    type(batch_type), intent(out) :: batch
    !> Work space of groups of one pressure, empty when there are none.
    type(pressure_type), intent(out) :: pressure
    integer :: most, components
    logical :: cured

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
    cured = any(laws%pressure_factor > 0.0_wp)
    if (tangent /= tangent_none .or. cured) allocate (batch%tangent(components, components, most))
    if (cured) call allocate_pressure(components, most, size(integration%gradient, 1)* &
      size(integration%shape, 1), components == 9 .or. integration%axisymmetric, pressure)
  end subroutine allocate_batch

  !> One group: runs of points of equal material go to their law together.
  subroutine evaluate_group(integration, laws, displacement, tangent, group, batch, pressure, evaluation)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    integer, intent(in) :: tangent, group
    !> The points handed to the law.
    type(batch_type), intent(inout) :: batch
    !> Work space of points of one pressure.
    type(pressure_type), intent(inout) :: pressure
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    real(wp) :: u(size(displacement, 1), size(integration%shape, 1))
    integer :: n, from, to, last

    n = integration%node_first(group + 1) - integration%node_first(group)
    u(:, :n) = displacement(:, integration%nodes(integration%node_first(group): &
      integration%node_first(group + 1) - 1))
    evaluation%group_force(:, group) = 0.0_wp
    evaluation%group_bad(group) = 0
    if (tangent /= tangent_none) evaluation%block(:, group) = 0.0_wp
    from = integration%first(group)
    last = integration%first(group + 1) - 1
    do while (from <= last)
      to = end_of_run(integration%material(from:last)) + from - 1
      call load_batch(integration, from, to, u(:, :n), batch)
      call update_run(laws(integration%material(from)), integration%weight(from:to), tangent, batch, pressure)
      evaluation%group_bad(group) = first_bad(batch)
      if (evaluation%group_bad(group) > 0) then
        evaluation%group_bad(group) = from - 1 + evaluation%group_bad(group)
        return
      end if
      call store_batch(from, to, batch, evaluation)
      call add_forces(integration, from, to, n, batch, evaluation%group_force(:, group))
      if (tangent /= tangent_none) call add_stiffness(integration, from, to, n, &
        is_cured(laws(integration%material(from)), batch), batch, pressure, evaluation%block(:, group))
      from = to + 1
    end do
  end subroutine evaluate_group

  !> Last of the leading points of one material.
  pure integer function end_of_run(material) result(last)
    !> Materials of points.
    integer, intent(in) :: material(:)

    last = 1
    do while (last < size(material))
      if (material(last + 1) /= material(1)) exit
      last = last + 1
    end do
  end function end_of_run

  !> Whether the points of a batch share their pressure; one point has its own anyway.
  pure logical function is_cured(slot, batch)
    !> Law of the points.
    type(law_slot_type), intent(in) :: slot
    !> The points.
    type(batch_type), intent(in) :: batch

    is_cured = slot%pressure_factor > 0.0_wp .and. batch%count > 1
  end function is_cured

  !> Stresses and tangents of a run of points.
  subroutine update_run(slot, weight, tangent, batch, pressure)
    !> Law of the points.
    type(law_slot_type), intent(in) :: slot
    !> Volumes of the points.
    real(wp), intent(in) :: weight(:)
    !> Which tangent is wanted.
    integer, intent(in) :: tangent
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> Work space of points of one pressure.
    type(pressure_type), intent(inout) :: pressure

    if (is_cured(slot, batch)) then
      call find_pressure(slot%law, slot%pressure_factor*slot%law%shear_scale, weight, tangent, batch, pressure)
    else
      call slot%law%update(batch, tangent)
    end if
  end subroutine update_run

  !> First point of a batch that could not be updated, 0 for none.
  pure integer function first_bad(batch)
    !> The points.
    type(batch_type), intent(in) :: batch

    do first_bad = 1, batch%count
      if (batch%status(first_bad) /= status_ok) return
    end do
    first_bad = 0
  end function first_bad

  !> Stiffness of a run of points.
  subroutine add_stiffness(integration, from, to, n, cured, batch, pressure, block)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    !> Range of points and number of nodes.
    integer, intent(in) :: from, to, n
    !> The points share their pressure.
    logical, intent(in) :: cured
    !> The points handed to the law.
    type(batch_type), intent(in) :: batch
    !> What the common pressure needs.
    type(pressure_type), intent(inout) :: pressure
    !> The group's block.
    real(wp), intent(inout) :: block(:)

    if (size(integration%gradient, 1) == 2) then
      call add_stiffness_2d(integration, from, to, n, batch, block)
    else
      call add_stiffness_3d(integration, from, to, n, batch, block)
    end if
    if (cured) call add_pressure_stiffness(integration, from, to, size(integration%gradient, 1)*n, &
      pressure, block)
  end subroutine add_stiffness

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
      if (allocated(integration%given)) batch%gradient(:d*d, k) = reshape(integration%given(:, :, q), [d*d])
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

end module qsmpm_group_evaluation
