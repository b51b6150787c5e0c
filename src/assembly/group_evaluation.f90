!> Evaluation of one group of integration points: deformation gradients, the law of each material, internal force and
!> stiffness block.
!>
!> Consecutive points of one material are passed to their law together; where the material requires it they share one
!> pressure (qsmpm_uniform_pressure). The products over nodes are those of qsmpm_group_stiffness, in space with more
!> nodes than an element has those of qsmpm_wide_products. A group writes only to its own section of the results.
module qsmpm_group_evaluation
  use qsmpm_kinds, only: wp, long
  use qsmpm_law, only: law_slot_type, law_type, batch_type, tangent_none, tangent_elastic, status_ok
  use qsmpm_points, only: carries_water, points_type
  use qsmpm_integration, only: integration_type, place_of
  use qsmpm_pressure_balance, only: pressure_type, allocate_pressure, packed_determinant
  use qsmpm_small_strain, only: take_stretch, take_true_stress
  use qsmpm_uniform_pressure, only: find_pressure
  use qsmpm_group_stiffness, only: products_type, allocate_products, find_gradients, add_force, add_stiffness, &
    add_pressure_stiffness
  use qsmpm_wide_products, only: wide_type, is_wide, allocate_wide, find_wide_gradients, add_wide_force, &
    add_wide_stiffness
  implicit none
  private

  public :: results_type, work_type, allocate_work, evaluate_group

  !> Results of the laws at every integration point; empty arrays where not requested.
  type :: results_type
    !> Final stress (4 or 6, n), state (states, n), determinant of F (n), plastic flag (n).
    real(wp), allocatable :: stress(:, :), state(:, :), volume_change(:)
    !> F as passed to the law, packed; no columns where not requested (5 or 9, n or 0).
    real(wp), allocatable :: gradient(:, :)
    integer, allocatable :: plastic(:)
  end type results_type

  !> Work space of one thread; it fits the largest group.
  type :: work_type
    !> Points passed to the law.
    type(batch_type) :: batch
    !> Work space of groups with one pressure, empty without such groups.
    type(pressure_type) :: pressure
    type(products_type) :: products
    type(wide_type) :: wide
    !> Displacement of the group's nodes (dimension*n).
    real(wp), allocatable :: u(:)
  end type work_type

contains

  !> Allocates the work space for the largest group; existing arrays are retained.
  subroutine allocate_work(integration, laws, dimension, tangent, work)
    type(integration_type), intent(in) :: integration
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Kind of tangent.
    integer, intent(in) :: tangent
    !> The work space.
    type(work_type), intent(inout) :: work
    integer :: most, nodes, components
    logical :: treated

    most = maxval([0, integration%first(2:) - integration%first(:integration%group_count)])
    nodes = maxval([0, integration%node_first(2:) - integration%node_first(:integration%group_count)])
    components = merge(5, 9, dimension == 2)
    treated = any(laws%pressure_factor > 0.0_wp)
    call allocate_products(dimension, integration%directions, most, nodes, tangent /= tangent_none, work%products)
    call allocate_wide(dimension, most, nodes, tangent /= tangent_none, work%wide)
    if ((tangent /= tangent_none .or. treated) .and. .not. allocated(work%batch%tangent)) &
      allocate (work%batch%tangent(components, components, most))
    if (allocated(work%u)) return
    allocate (work%u(dimension*nodes))
    associate (batch => work%batch)
      allocate (batch%gradient(components, most), batch%piola(components, most), batch%volume_ratio(most), &
        batch%stress_start(size(integration%stress, 1), most), batch%stress(size(integration%stress, 1), most), &
        batch%state_start(size(integration%state, 1), most), batch%state(size(integration%state, 1), most))
      allocate (batch%status(most), batch%plastic(most))
      allocate (batch%number(most), batch%cell(most), batch%place(dimension, most), batch%cell_size(most))
    end associate
    if (treated) call allocate_pressure(components, most, dimension*nodes, &
      components == 9 .or. integration%axisymmetric, work%pressure)
  end subroutine allocate_work

  !> Evaluates one group: consecutive points of the same material are passed to their law together.
  subroutine evaluate_group(integration, points, laws, displacement, tangent, group, work, results, force, block, bad, &
      offset, field)
    type(integration_type), intent(in) :: integration
    !> The material points, with the initial states of those that are integration points.
    type(points_type), intent(in) :: points
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Kind of tangent, and number of the group.
    integer, intent(in) :: tangent, group
    !> Work space.
    type(work_type), intent(inout) :: work
    !> Results of the laws.
    type(results_type), intent(inout) :: results
    !> Internal force (dimension*n or more).
    real(wp), intent(inout) :: force(:)
    !> Stiffness, packed as (n, dimension, dimension, n), if a tangent is requested.
    real(wp), intent(inout) :: block(:)
    !> First point that could not be updated, 0 for none.
    integer, intent(out) :: bad
    !> Pressure of the points relative to the common one of their group due to weight and water, at the start and the
    !> end of the step [stress] (points, 2); nodal values of the nonlocal strain at its end (nodes), without which the
    !> values at the points do not change.
    real(wp), intent(in), optional :: offset(:, :), field(:)
    integer :: n, d, a, from, to, last

    d = size(displacement, 1)
    n = integration%node_first(group + 1) - integration%node_first(group)
    do a = 1, n
      work%u((a - 1)*d + 1:a*d) = displacement(:, integration%nodes(integration%node_first(group) + a - 1))
    end do
    force(:d*n) = 0.0_wp
    from = integration%first(group)
    last = integration%first(group + 1) - 1
    if (tangent /= tangent_none .and. from > last) block(:(d*n)**2) = 0.0_wp
    bad = 0
    do while (from <= last .and. bad == 0)
      to = end_of_run(integration%material(from:last)) + from - 1
      call evaluate_run(integration, points, laws(integration%material(from)), d, tangent, group, from, to, work, &
        results, force, block, bad, offset, field)
      from = to + 1
    end do
  end subroutine evaluate_group

  !> Evaluates consecutive points of one material.
  subroutine evaluate_run(integration, points, slot, d, tangent, group, from, to, work, results, force, block, bad, &
      offset, field)
    type(integration_type), intent(in) :: integration
    type(points_type), intent(in) :: points
    !> Law of the points.
    type(law_slot_type), intent(in) :: slot
    !> Dimension, kind of tangent, group, and range of points.
    integer, intent(in) :: d, tangent, group, from, to
    !> Work space with the displacement of the nodes.
    type(work_type), intent(inout) :: work
    type(results_type), intent(inout) :: results
    !> Internal force and stiffness.
    real(wp), intent(inout) :: force(:), block(:)
    !> First point that could not be updated, 0 for none.
    integer, intent(out) :: bad
    real(wp), intent(in), optional :: offset(:, :), field(:)
    integer :: n, m, b, count
    logical :: treated, wide, symmetric

    n = integration%node_first(group + 1) - integration%node_first(group)
    m = integration%directions
    count = to - from + 1
    b = m*(integration%value_first(group) + (from - integration%first(group))*n) + 1
    treated = slot%pressure_factor > 0.0_wp .and. count > 1
    ! Where water drains the integration points are material points.
    if (treated .and. work%pressure%draining .and. slot%flows) &
      treated = any(points%plastic(integration%source(from:to)) > 0)
    wide = is_wide(d, n) .and. .not. treated
    symmetric = (slot%is_symmetric() .and. .not. work%batch%step_info%in_place) .or. tangent == tangent_elastic
    work%batch%count = count
    associate (batch => work%batch, tensor => work%products%tensor, weight => integration%weight(from:to))
      if (wide) then
        call find_wide_gradients(n, count, work%u, integration%gradient(b), work%wide, tensor)
      else
        call find_gradients(d, m, n, count, work%u, integration%gradient(b), tensor)
      end if
      call load_gradients(integration, d, from, tensor, batch)
      if (batch%step_info%in_place) call take_stretch(batch)
      call load_states(integration, points, from, batch)
      if (present(field) .and. slot%law%field_length > 0.0_wp) &
        call load_field(integration, group, from, slot%law%state_count, field, batch)
      ! State variables of other materials that this one does not have remain unchanged.
      batch%state(slot%law%state_count + 1:, :batch%count) = batch%state_start(slot%law%state_count + 1:, :batch%count)
      if (slot%law%asks_where) call load_places(integration, points, slot%law, d, group, from, tensor, batch)
      if (treated) then
        call load_pressures(from, weight, batch, work%pressure, offset)
        call find_pressure(slot, weight, tangent, batch, work%pressure)
      else
        call slot%update(batch, tangent)
      end if
      bad = first_bad(batch)
      if (bad > 0) bad = from - 1 + bad
      if (bad > 0) return
      if (batch%step_info%in_place .and. treated) then
        call take_true_stress(slot, tangent /= tangent_none, batch, work%pressure)
      else if (batch%step_info%in_place) then
        call take_true_stress(slot, tangent /= tangent_none, batch)
      end if
      if (size(results%plastic) > 0) call store_batch(from, batch, results)
      call add_run(d, m, n, count, wide, symmetric, from == integration%first(group), tangent /= tangent_none, weight, &
        integration%gradient(b), work, force, block)
      if (treated .and. tangent /= tangent_none) call add_pressure_stiffness(d, m, n, count, weight, &
        integration%gradient(b), tensor, work%pressure, block)
    end associate
  end subroutine evaluate_run

  !> Adds force and stiffness of consecutive points after the evaluation of their law.
  subroutine add_run(d, m, n, count, wide, symmetric, first, with_tangent, weight, gradient, work, force, block)
    !> Dimension, directions of a gradient, numbers of nodes and points.
    integer, intent(in) :: d, m, n, count
    !> Use the products for many nodes; all tangents are symmetric; the block is still empty; stiffness is requested.
    logical, intent(in) :: wide, symmetric, first, with_tangent
    !> V (points), and the gradients.
    real(wp), intent(in) :: weight(:), gradient(*)
    !> Work space with the stresses and tangents of the points.
    type(work_type), intent(inout) :: work
    !> Internal force and stiffness.
    real(wp), intent(inout) :: force(:), block(:)

    if (wide) then
      call add_wide_force(n, count, weight, work%batch%piola, gradient, work%products%tensor, force)
      if (with_tangent) call add_wide_stiffness(n, count, symmetric, first, weight, gradient, work%batch%tangent, &
        work%wide, block)
    else
      call add_force(d, m, n, count, weight, work%batch%piola, gradient, work%products%tensor, force)
      if (with_tangent) call add_stiffness(d, m, n, count, symmetric, first, weight, gradient, work%batch%tangent, &
        work%products, block)
    end if
  end subroutine add_run

  !> Returns the last of the leading points of one material.
  pure integer function end_of_run(material) result(last)
    !> Materials of points.
    integer, intent(in) :: material(:)

    last = 1
    do while (last < size(material))
      if (material(last + 1) /= material(1)) exit
      last = last + 1
    end do
  end function end_of_run

  !> First point of a batch that could not be updated, 0 for none.
  pure integer function first_bad(batch)
    !> The points.
    type(batch_type), intent(in) :: batch

    do first_bad = 1, batch%count
      if (batch%status(first_bad) /= status_ok) return
    end do
    first_bad = 0
  end function first_bad

  !> Sets the incremental deformation gradients of consecutive points.
  pure subroutine load_gradients(integration, d, from, tensor, batch)
    type(integration_type), intent(in) :: integration
    !> 2 or 3, and the first point.
    integer, intent(in) :: d, from
    !> Displacement gradients (dimension, directions, points or more).
    real(wp), intent(in) :: tensor(d*integration%directions, *)
    !> Points passed to the law.
    type(batch_type), intent(inout) :: batch
    integer :: k, j

    do k = 1, batch%count
      batch%gradient(:d*d, k) = tensor(:d*d, k)
      if (allocated(integration%given)) batch%gradient(:d*d, k) = reshape(integration%given(:, :, from + k - 1), [d*d])
      do j = 1, d
        batch%gradient((j - 1)*d + j, k) = batch%gradient((j - 1)*d + j, k) + 1.0_wp
      end do
      if (d == 3) cycle
      batch%gradient(5, k) = 1.0_wp
      if (integration%axisymmetric) batch%gradient(5, k) = 1.0_wp + tensor(5, k)
    end do
  end subroutine load_gradients

  !> Sets the initial states of consecutive points: those of material points, or those stored at Gauss points.
  pure subroutine load_states(integration, points, from, batch)
    type(integration_type), intent(in) :: integration
    type(points_type), intent(in) :: points
    !> Number of the first point.
    integer, intent(in) :: from
    !> Points passed to the law.
    type(batch_type), intent(inout) :: batch
    integer :: k, p

    do k = 1, batch%count
      p = integration%source(from + k - 1)
      if (p > 0) then
        batch%volume_ratio(k) = points%volume(p)/points%initial_volume(p)
        batch%stress_start(:, k) = points%stress(:, p)
        batch%state_start(:, k) = points%state(:, p)
      else
        batch%volume_ratio(k) = integration%volume_ratio(-p)
        batch%stress_start(:, k) = integration%stress(:, -p)
        batch%state_start(:, k) = integration%state(:, -p)
      end if
    end do
  end subroutine load_states

  !> Sets the pressure differences of consecutive points: g at the end of the step, and s at its start.
  pure subroutine load_pressures(from, weight, batch, pressure, offset)
    !> Number of the first point, and initial volumes (points).
    integer, intent(in) :: from
    real(wp), intent(in) :: weight(:)
    type(batch_type), intent(in) :: batch
    type(pressure_type), intent(inout) :: pressure
    !> g of all points, 0 where it is not given.
    real(wp), intent(in), optional :: offset(:, :)

    associate (n => batch%count, g => pressure%offset(:batch%count), s => pressure%kept(:batch%count))
      g = 0.0_wp
      s = 0.0_wp
      if (present(offset)) g = offset(from:from + n - 1, 2)
      if (.not. pressure%lasting) return
      s = matmul(pressure%direction, batch%stress_start(:3, :n))
      if (present(offset)) s = s - offset(from:from + n - 1, 1)
      s = s - sum(weight*s)/sum(weight)
    end associate
  end subroutine load_pressures

  !> Sets the nonlocal strain at consecutive points.
  pure subroutine load_field(integration, group, from, place, field, batch)
    type(integration_type), intent(in) :: integration
    !> Group, first point, and index of the state variable.
    integer, intent(in) :: group, from, place
    !> Nodal values (nodes).
    real(wp), intent(in) :: field(:)
    type(batch_type), intent(inout) :: batch
    integer :: k, a, b

    do k = 1, batch%count
      batch%state_start(place, k) = 0.0_wp
      b = place_of(integration, group, from + k - 1)
      do a = 1, integration%node_first(group + 1) - integration%node_first(group)
        batch%state_start(place, k) = batch%state_start(place, k) + integration%shape(b + a) &
          *field(integration%nodes(integration%node_first(group) + a - 1))
      end do
    end do
  end subroutine load_field

  !> Sets the positions of consecutive points, and the width of their cell.
  pure subroutine load_places(integration, points, law, d, group, from, tensor, batch)
    type(integration_type), intent(in) :: integration
    type(points_type), intent(in) :: points
    class(law_type), intent(in) :: law
    !> 2 or 3, group, and first point.
    integer, intent(in) :: d, group, from
    !> Displacement gradients (dimension, directions, points or more).
    real(wp), intent(in) :: tensor(d, integration%directions, *)
    !> Points passed to the law.
    type(batch_type), intent(inout) :: batch
    integer :: k, p

    do k = 1, batch%count
      p = integration%source(from + k - 1)
      batch%number(k) = 0
      batch%cell(k) = integration%cell(group)
      batch%cell_size(k) = integration%cell_size(group)
      if (.not. (law%of_user .or. law%field_length > 0.0_wp)) batch%cell_size(k) = width_across( &
        integration%cell_metric(:, :, group), tensor(:, :d, k), batch%cell_size(k))
      batch%place(:, k) = integration%cell_centre(:, group)
      if (p <= 0) cycle
      batch%number(k) = int(min(points%number(p), int(huge(batch%number), long)))
      batch%place(:, k) = points%position(:, p)
    end do
    if (law%of_user .and. carries_water(points)) call load_water(integration, points, from, batch)
  end subroutine load_places

  !> Sets the pore water data of consecutive points; for Gauss points the mean of their cell.
  pure subroutine load_water(integration, points, from, batch)
    type(integration_type), intent(in) :: integration
    type(points_type), intent(in) :: points
    !> Number of the first point.
    integer, intent(in) :: from
    !> Points passed to the law.
    type(batch_type), intent(inout) :: batch
    integer :: k, p

    if (.not. allocated(batch%water)) allocate (batch%water(3, size(batch%number)))
    do k = 1, batch%count
      p = integration%source(from + k - 1)
      if (p > 0) then
        batch%water(:, k) = [points%pore_pressure(p), points%pore_state(:, p)]
      else
        batch%water(:, k) = integration%water(:, -p)
      end if
    end do
  end subroutine load_water

  !> Returns the width of a cell across the shear band that a displacement gradient L forms in it: tr(L G L^T)/tr(L L^T)
  !> is the mean of n . G n over the normals n in L, and equal to n . G n where L = m n, a slip along m.
  pure real(wp) function width_across(metric, gradient, usual) result(width)
    !> G (dimension, dimension), and L.
    real(wp), intent(in) :: metric(:, :), gradient(:, :)
    !> Width where L is zero.
    real(wp), intent(in) :: usual
    real(wp) :: whole

    whole = sum(gradient**2)
    width = usual
    if (whole > 0.0_wp) width = sqrt(sum(matmul(gradient, metric)*gradient)/whole)
  end function width_across

  !> Stores the results of consecutive points.
  pure subroutine store_batch(from, batch, results)
    !> Number of the first point.
    integer, intent(in) :: from
    !> Points passed to the law.
    type(batch_type), intent(in) :: batch
    !> Results of the laws.
    type(results_type), intent(inout) :: results
    integer :: q, k

    do k = 1, batch%count
      q = from + k - 1
      results%stress(:, q) = batch%stress(:, k)
      results%state(:, q) = batch%state(:, k)
      results%plastic(q) = batch%plastic(k)
      results%volume_change(q) = packed_determinant(batch%gradient(:, k))
      if (size(results%gradient, 2) > 0) results%gradient(:, q) = batch%gradient(:, k)
    end do
  end subroutine store_batch
end module qsmpm_group_evaluation
