!> Field of nonlocal softening, an unknown of the step in addition to the displacement. Its equation is that of the
!> over-nonlocal implicit gradient method (Peerlings et al. 1996; Vermeer and Brinkgreve 1994)
!>
!>   sum V [ M_a (kbar - kappa) + l^2 grad M_a . grad kbar ] + dE/dkbar_a = 0,   E = d/2 sum V |M_b| (kbar_b - kbar)^2
!>
!> over the integration points of nonlocal laws, M the functions of the displacement, kappa the plastic shear strain of
!> a point at the end of the step and l the length of its law. kappa and kbar are evaluated at the same points, so that
!> a constant is reproduced exactly. E stabilises nodes in the support of which there are few points; on linear
!> functions it adds d h^2/6 to l^2. Laws are evaluated with the field of the trial (qsmpm_group_evaluation), and the
!> stresses in equilibrium are those with the field at its end. Cells too wide for l have no field
!> (qsmpm_softening_model).
!>
!> The field is a part of the soil term (qsmpm_soil_points), whose evaluation provides kappa. The blocks of both fields
!> are
!>   K_ukbar = sum V dQ/dkbar grad N M,   K_kbaru = - sum V M dkappa/dF grad N,   K_kbarkbar with 1 - dkappa/dkbar.
!> Volumes and functions are those at the start of the step. docs/methods/softening.md
module qsmpm_nonlocal_strain
  use qsmpm_kinds, only: wp
  use qsmpm_assembly, only: evaluation_type
  use qsmpm_equations, only: equations_type
  use qsmpm_integration, only: integration_type, place_of
  use qsmpm_kept_arrays, only: kept_values
  use qsmpm_law, only: field_coupling_type, law_slot_type
  use qsmpm_matrix_blocks, only: add_block
  use qsmpm_model, only: model_type
  use qsmpm_node_graph, only: connectivity_type, lay_lists
  use qsmpm_nonlocal_field, only: nonlocal_field
  use qsmpm_points, only: points_type
  use qsmpm_small_strain, only: turn_coupling
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_unknowns, only: find_field, joint_node, unknowns_type
  implicit none
  private

  !> Factor d of the stabilisation E.
  real(wp), parameter :: hold = 0.01_wp

  public :: nonlocal_strain_type, prepare_nonlocal, trial_field, evaluate_nonlocal, add_nonlocal_blocks

  type :: nonlocal_strain_type
    !> Number of the field among the unknowns, and its values at the start of the step (nodes).
    integer :: number = 0
    real(wp), allocatable :: start(:)
    !> Groups of integration points that have the field, and their node lists: nodes of the displacement, then of the
    !> field.
    integer, allocatable :: group(:)
    type(connectivity_type) :: connectivity
    !> Residual at the nodes, and sum of its contributions by their size (nodes).
    real(wp), allocatable :: residual(:), sizes(:)
  end type nonlocal_strain_type

contains

  !> Finds the groups that have the field.
  subroutine prepare_nonlocal(model, integration, unknowns, nonlocal)
    type(model_type), intent(in) :: model
    type(integration_type), intent(in) :: integration
    type(unknowns_type), intent(in) :: unknowns
    type(nonlocal_strain_type), intent(out) :: nonlocal
    integer :: g, i, n, q

    nonlocal%number = find_field(unknowns, nonlocal_field)
    nonlocal%start = reshape(kept_values(model%state%kept, nonlocal_field), [model%space%node_count])
    allocate (nonlocal%residual(model%space%node_count), nonlocal%sizes(model%space%node_count), source=0.0_wp)
    nonlocal%group = pack([(g, g=1, integration%group_count)], &
      [(any([(has_field(model%laws, integration, g, q), q=integration%first(g), integration%first(g + 1) - 1)]), &
      g=1, integration%group_count)])
    associate (graph => nonlocal%connectivity)
      call lay_lists(2*(integration%node_first(nonlocal%group + 1) - integration%node_first(nonlocal%group)), graph)
      do i = 1, graph%count
        g = nonlocal%group(i)
        n = integration%node_first(g + 1) - integration%node_first(g)
        associate (node => integration%nodes(integration%node_first(g):integration%node_first(g + 1) - 1))
          graph%nodes(graph%first(i):graph%first(i) + n - 1) = node
          graph%nodes(graph%first(i) + n:graph%first(i + 1) - 1) = joint_node(unknowns, node, nonlocal%number)
        end associate
      end do
    end associate
  end subroutine prepare_nonlocal

  !> Returns whether a point of a group has the field: its law is nonlocal, and the cell is not too wide.
  pure logical function has_field(laws, integration, group, point)
    type(law_slot_type), intent(in) :: laws(:)
    type(integration_type), intent(in) :: integration
    integer, intent(in) :: group, point

    associate (law => laws(integration%material(point))%law)
      has_field = law%field_length > 0.0_wp
      if (has_field) has_field = integration%cell_size(group) <= law%coarsest_cell
    end associate
  end function has_field

  !> Returns the field at a trial (nodes).
  pure function trial_field(nonlocal, unknowns, table) result(field)
    type(nonlocal_strain_type), intent(in) :: nonlocal
    type(unknowns_type), intent(in) :: unknowns
    !> Table of all unknowns.
    real(wp), intent(in) :: table(:, :)
    real(wp) :: field(size(nonlocal%start))
    integer :: first

    first = joint_node(unknowns, 1, nonlocal%number)
    field = nonlocal%start + table(1, first:first + size(field) - 1)
  end function trial_field

  !> Computes the residual of the field with which the laws have been evaluated.
  subroutine evaluate_nonlocal(laws, integration, dimension, evaluation, nonlocal)
    type(law_slot_type), intent(in) :: laws(:)
    type(integration_type), intent(in) :: integration
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Results of all points, including the field.
    type(evaluation_type), intent(in) :: evaluation
    type(nonlocal_strain_type), intent(inout) :: nonlocal
    real(wp) :: own(2)
    integer :: i, g, q, b, n, last

    nonlocal%residual = 0.0_wp
    nonlocal%sizes = 0.0_wp
    do i = 1, size(nonlocal%group)
      g = nonlocal%group(i)
      n = integration%node_first(g + 1) - integration%node_first(g)
      associate (node => integration%nodes(integration%node_first(g):integration%node_first(g + 1) - 1))
        do q = integration%first(g), integration%first(g + 1) - 1
          if (.not. has_field(laws, integration, g, q)) cycle
          last = laws(integration%material(q))%law%state_count
          own = integration%weight(q)*evaluation%results%state(last - 1:last, q)
          b = place_of(integration, g, q)
          associate (shape => integration%shape(b + 1:b + n))
            nonlocal%residual(node) = nonlocal%residual(node) - own(1)*shape + matmul(field_matrix(integration, &
              laws(integration%material(q))%law%field_length**2, dimension, n, b, integration%weight(q)), &
              evaluation%field(node))
            nonlocal%sizes(node) = nonlocal%sizes(node) + abs(shape)*sum(abs(own))
          end associate
        end do
      end associate
    end do
  end subroutine evaluate_nonlocal

  !> Returns the contribution of a point to the matrix of the field, without the change of kappa (n, n).
  pure function field_matrix(integration, length2, d, n, place, weight) result(matrix)
    type(integration_type), intent(in) :: integration
    !> l^2.
    real(wp), intent(in) :: length2
    !> Dimension, number of nodes, and offset of the values of the point.
    integer, intent(in) :: d, n, place
    real(wp), intent(in) :: weight
    real(wp) :: matrix(n, n)
    real(wp) :: total
    integer :: a, b

    associate (shape => integration%shape(place + 1:place + n), gradient => gradients(integration, d, place, n))
      matrix = length2*matmul(gradient, transpose(gradient))
      total = 1.0_wp + hold*sum(abs(shape))
      do b = 1, n
        do a = 1, n
          matrix(a, b) = matrix(a, b) + total*shape(a)*shape(b) - hold*(abs(shape(a))*shape(b) + shape(a)*abs(shape(b)))
        end do
        matrix(b, b) = matrix(b, b) + hold*abs(shape(b))
      end do
    end associate
    matrix = weight*matrix
  end function field_matrix

  !> Returns the gradients of the functions at a point (nodes, directions).
  pure function gradients(integration, directions, place, n) result(gradient)
    type(integration_type), intent(in) :: integration
    !> Number of directions: the dimension, plus one with the hoop direction; offset of the values of the point, and
    !> number of nodes.
    integer, intent(in) :: directions, place, n
    real(wp) :: gradient(n, directions)

    gradient = reshape(integration%gradient(integration%directions*place + 1:integration%directions*place &
      + directions*n), [n, directions])
  end function gradients

  !> Adds the blocks of displacement and field.
  subroutine add_nonlocal_blocks(model, integration, evaluation, consistent, nonlocal, equations, first_stencil, matrix)
    type(model_type), intent(in) :: model
    type(integration_type), intent(in) :: integration
    !> Results of the trial.
    type(evaluation_type), intent(in) :: evaluation
    !> Include the coupling of the field with the displacement; not in the elastic tangent.
    logical, intent(in) :: consistent
    type(nonlocal_strain_type), intent(in) :: nonlocal
    type(equations_type), intent(in) :: equations
    !> Number of the first node list.
    integer, intent(in) :: first_stencil
    type(sparse_matrix_type), intent(inout) :: matrix
    type(field_coupling_type) :: coupling
    real(wp), allocatable :: block(:, :, :, :)
    integer :: i, g, q, d, n

    d = model%mesh%dimension
    do i = 1, size(nonlocal%group)
      g = nonlocal%group(i)
      n = integration%node_first(g + 1) - integration%node_first(g)
      if (allocated(block)) then
        if (size(block, 2) /= 2*n) deallocate (block)
      end if
      if (.not. allocated(block)) allocate (block(size(equations%number, 1), 2*n, size(equations%number, 1), 2*n))
      block = 0.0_wp
      do q = integration%first(g), integration%first(g + 1) - 1
        if (.not. has_field(model%laws, integration, g, q)) cycle
        coupling = field_coupling_type()
        if (consistent .and. evaluation%results%plastic(q) > 0) call find_coupling(model%state%points, integration, &
          model%laws(integration%material(q)), evaluation, g, q, coupling)
        call add_point(integration, model%laws(integration%material(q))%law%field_length**2, coupling, d, n, g, q, &
          block)
      end do
      call add_block(equations, first_stencil + i - 1, block, matrix)
    end do
  end subroutine add_nonlocal_blocks

  !> Computes the coupling derivatives of the law of a yielding point.
  subroutine find_coupling(points, integration, slot, evaluation, group, point, coupling)
    type(points_type), intent(in) :: points
    type(integration_type), intent(in) :: integration
    type(law_slot_type), intent(in) :: slot
    type(evaluation_type), intent(in) :: evaluation
    integer, intent(in) :: group, point
    type(field_coupling_type), intent(out) :: coupling
    real(wp) :: state(slot%law%state_count), ratio
    integer :: p

    p = integration%source(point)
    if (p > 0) then
      state = points%state(:size(state), p)
      ratio = points%volume(p)/points%initial_volume(p)
    else
      state = integration%state(:size(state), -p)
      ratio = integration%volume_ratio(-p)
    end if
    associate (gradient => evaluation%results%gradient(:, point))
      call slot%law%couple(gradient, ratio, integration%cell_size(group), state, &
        evaluation%results%state(:size(state), point), coupling)
      if (evaluation%step_info%in_place) call turn_coupling(slot%law%bounds_kirchhoff, gradient, &
        coupling%stress_by_field(:size(gradient)), coupling%strain_by_gradient(:size(gradient)))
    end associate
  end subroutine find_coupling

  !> Adds the contribution of a point to a block.
  pure subroutine add_point(integration, length2, coupling, d, n, group, point, block)
    type(integration_type), intent(in) :: integration
    !> l^2.
    real(wp), intent(in) :: length2
    type(field_coupling_type), intent(in) :: coupling
    !> Dimension, number of nodes, group and point.
    integer, intent(in) :: d, n, group, point
    !> (components, 2*nodes, components, 2*nodes)
    real(wp), intent(inout) :: block(:, :, :, :)
    real(wp) :: gradient(n, integration%directions), force(d, n), strain(d, n), matrix(n, n)
    integer :: a, b, place

    place = place_of(integration, group, point)
    gradient = gradients(integration, integration%directions, place, n)
    matrix = field_matrix(integration, length2, d, n, place, integration%weight(point))
    force = matmul(reshape(coupling%stress_by_field(:d*d), [d, d]), transpose(gradient(:, :d)))
    strain = matmul(reshape(coupling%strain_by_gradient(:d*d), [d, d]), transpose(gradient(:, :d)))
    if (integration%axisymmetric) then
      force(1, :) = force(1, :) + coupling%stress_by_field(5)*gradient(:, 3)
      strain(1, :) = strain(1, :) + coupling%strain_by_gradient(5)*gradient(:, 3)
    end if
    associate (shape => integration%shape(place + 1:place + n), weight => integration%weight(point))
      do b = 1, n
        do a = 1, n
          block(:d, a, 1, n + b) = block(:d, a, 1, n + b) + weight*force(:, a)*shape(b)
          block(1, n + a, :d, b) = block(1, n + a, :d, b) - weight*shape(a)*strain(:, b)
          block(1, n + a, 1, n + b) = block(1, n + a, 1, n + b) + matrix(a, b) &
            - weight*coupling%strain_by_field*shape(a)*shape(b)
        end do
      end do
    end associate
  end subroutine add_point
end module qsmpm_nonlocal_strain
