!> Displacement gradients of a step recovered at the nodes: the mean over the cells at a node of their gradients there,
!> weighted by volume, and interpolated by the functions of the elements.
!>
!> The gradient of an element is discontinuous at faces. A material point that crosses cells accumulates these jumps,
!> each of the order of the element, once for every cell on its path: the accumulated error is one order lower. The
!> recovered gradient is continuous in a material; at an interface of two materials it is discontinuous, so that each
!> material has its own means, over the cells that contain its points. Points of full cells of quadratic elements follow
!> the recovered gradient except for a share of their own; linear elements gain accuracy in stress and lose it in
!> displacement, and keep their own gradient. docs/methods/cell_integration.md.
module qsmpm_recovered_gradient
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: element_geometry, element_order, local_nodes, max_nodes
  use qsmpm_mesh, only: mesh_type
  use qsmpm_point_location, only: activation_type
  use qsmpm_law, only: law_slot_type
  use qsmpm_integration, only: integration_type, place_of
  implicit none
  private

  public :: recover_gradients

  !> Share of the gradient of its cell that a point retains. Without it a mode whose gradients cancel at the nodes would
  !> not affect the points and would grow from step to step (measured with this constant at 0 and 200 steps on 16 cells:
  !> QUAD8 9.4e-2 against 4.1e-2 at 0.3, linear triangles diverge); with 0.3 it is stable and the accumulated error is
  !> 0.3 of the former.
  real(wp), parameter :: own = 0.3_wp

contains

  !> Sets the displacement gradients of the step at the points: recovered ones in full cells, those of the functions
  !> elsewhere and in materials whose cells share a pressure.
  pure subroutine recover_gradients(mesh, activation, volumes, laws, displacement, at_points)
    type(mesh_type), intent(in) :: mesh
    type(activation_type), intent(in) :: activation
    !> Volume of every cell (cell_count).
    real(wp), intent(in) :: volumes(:)
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Material points in groups, whose `given` gradients are set.
    type(integration_type), intent(inout) :: at_points
    real(wp) :: nodal(mesh%dimension, mesh%dimension, mesh%node_count)
    integer :: m

    if (allocated(at_points%given)) deallocate (at_points%given)
    allocate (at_points%given(mesh%dimension, mesh%dimension, at_points%point_count), source=0.0_wp)
    do m = 1, size(laws)
      if (.not. any(at_points%material == m)) cycle
      call nodal_gradients(mesh, activation, volumes, cells_of(at_points, m), displacement, nodal)
      call give_gradients(mesh, activation, m, .not. laws(m)%pressure_factor > 0.0_wp, displacement, nodal, at_points)
    end do
  end subroutine recover_gradients

  !> Returns the groups that contain points of a material.
  pure function cells_of(at_points, material) result(hold)
    type(integration_type), intent(in) :: at_points
    integer, intent(in) :: material
    logical :: hold(at_points%group_count)
    integer :: g

    do g = 1, at_points%group_count
      hold(g) = any(at_points%material(at_points%first(g):at_points%first(g + 1) - 1) == material)
    end do
  end function cells_of

  !> Sets the gradients of the points of a material.
  pure subroutine give_gradients(mesh, activation, material, follows, displacement, nodal, at_points)
    type(mesh_type), intent(in) :: mesh
    type(activation_type), intent(in) :: activation
    integer, intent(in) :: material
    !> Points of full cells of the material follow the recovered gradient.
    logical, intent(in) :: follows
    !> Displacement of the step (dimension, node_count), and its means (dimension, dimension, node_count).
    real(wp), intent(in) :: displacement(:, :), nodal(:, :, :)
    type(integration_type), intent(inout) :: at_points
    integer :: g, q, a, j, n, first, place
    logical :: recovered

    do g = 1, at_points%group_count
      first = at_points%node_first(g) - 1
      do q = at_points%first(g), at_points%first(g + 1) - 1
        if (at_points%material(q) /= material) cycle
        recovered = follows .and. activation%full(g) .and. element_order(mesh%cell_kind(at_points%cell(g))) > 1
        place = place_of(at_points, g, q)
        n = at_points%node_first(g + 1) - 1 - first
        do a = 1, n
          associate (node => at_points%nodes(first + a), given => at_points%given(:, :, q))
            if (recovered) given = given + (1.0_wp - own)*at_points%shape(place + a)*nodal(:, :, node)
            do j = 1, mesh%dimension
              given(:, j) = given(:, j) + merge(own, 1.0_wp, recovered)*displacement(:, node) &
                *at_points%gradient(at_points%directions*place + (j - 1)*n + a)
            end do
          end associate
        end do
      end do
    end do
  end subroutine give_gradients

  !> Computes the means of the gradients of cells at the nodes, over selected cells.
  pure subroutine nodal_gradients(mesh, activation, volumes, counts, displacement, nodal)
    type(mesh_type), intent(in) :: mesh
    type(activation_type), intent(in) :: activation
    !> Volume of every cell (cell_count).
    real(wp), intent(in) :: volumes(:)
    !> Selected active cells (active_count).
    logical, intent(in) :: counts(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Gradients (dimension, dimension, node_count).
    real(wp), intent(out) :: nodal(:, :, :)
    real(wp) :: weight(mesh%node_count)
    real(wp) :: corner(mesh%dimension, max_nodes), shape(max_nodes), slope(mesh%dimension, max_nodes)
    real(wp) :: determinant, places(mesh%dimension, max_nodes), at_node(mesh%dimension, mesh%dimension)
    integer :: g, c, a, b, j, n, first

    nodal = 0.0_wp
    weight = 0.0_wp
    do g = 1, activation%active_count
      if (.not. counts(g)) cycle
      c = activation%active_cell(g)
      first = mesh%cell_first(c) - 1
      n = mesh%cell_first(c + 1) - first - 1
      corner(:, :n) = mesh%coordinates(:, mesh%cell_nodes(first + 1:first + n))
      places(:, :n) = local_nodes(mesh%cell_kind(c))
      do a = 1, n
        call element_geometry(mesh%cell_kind(c), places(:, a), corner(:, :n), shape(:n), slope(:, :n), determinant)
        at_node = 0.0_wp
        do b = 1, n
          do j = 1, mesh%dimension
            at_node(:, j) = at_node(:, j) + displacement(:, mesh%cell_nodes(first + b))*slope(j, b)
          end do
        end do
        associate (node => mesh%cell_nodes(first + a))
          nodal(:, :, node) = nodal(:, :, node) + volumes(c)*at_node
          weight(node) = weight(node) + volumes(c)
        end associate
      end do
    end do
    do a = 1, mesh%node_count
      if (weight(a) > 0.0_wp) nodal(:, :, a) = nodal(:, :, a)/weight(a)
    end do
  end subroutine nodal_gradients
end module qsmpm_recovered_gradient
