!> Stabilisation of boundary cells, acting on the displacement of the step in residual and tangent.
!>
!> The boundary of a body cuts cells; the smaller the part of a cell in the body, the worse the condition of the
!> equations. Two methods bound the condition number for any cut (docs/methods/ghost.md):
!>   background   a soft material in each boundary cell,
!>   ghost        a penalty on the jumps of derivatives over the faces of boundary cells
!>                (`qsmpm_element_ghost`, `qsmpm_spline_ghost`).
!> Both resist the displacement of the step without being a load: their share is reported, and a step is re-equilibrated
!> until the share is below its bound.
!>
!> The background is eps E int_K (grad N_a - g_a) . (grad N_b - g_b) dV over each boundary cell K.
!>
!> g_a is the mean of grad N_a over the root of K: K itself where it is well filled, otherwise the nearest well filled
!> cell at its corners, otherwise the fullest one. A linear field is therefore not resisted, and a nearly empty cell
!> follows the linear field of a cell that is supported by its material.
module qsmpm_boundary_stabilisation
  use qsmpm_kinds, only: wp
  use qsmpm_method_description, only: basis_fem, stabilise_none, stabilise_background, stabilise_ghost
  use qsmpm_body_quadrature, only: source_material
  use qsmpm_configuration, only: configuration_type
  use qsmpm_element_ghost, only: build_element_ghost
  use qsmpm_equations, only: equations_type
  use qsmpm_matrix_blocks, only: add_scalar_block
  use qsmpm_point_location, only: activation_type, boundary_fill, whole_fill
  use qsmpm_mesh, only: mesh_type
  use qsmpm_model, only: model_type
  use qsmpm_node_graph, only: connectivity_type, append_patches
  use qsmpm_own_part, only: is_divided
  use qsmpm_penalty_matrices, only: penalty_matrices_type, add_penalty_force, pair_cells
  use qsmpm_ring_exchange, only: learn_cell_values
  use qsmpm_space, only: space_type, cell_nodes_of_space, most_functions, shape_values_type, functions_at
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_spline_ghost, only: build_spline_ghost
  use qsmpm_term, only: term_type, increment_type, force_sizes_type
  use qsmpm_term_share, only: solve_share_type, share_of_cells
  use qsmpm_element, only: full_rule, gauss_rule
  use qsmpm_mesh_measure, only: cell_centre
  implicit none
  private

  public :: stabilisation_type, build_penalty, build_background

  type, extends(term_type) :: stabilisation_type
    type(penalty_matrices_type) :: penalty
  contains
    procedure :: prepare
    procedure :: couple
    procedure :: begin
    procedure :: add_force
    procedure :: add_blocks
    procedure :: measure
  end type stabilisation_type

contains

  !> Builds the chosen penalty on the boundary cells of this step; FEM has none.
  subroutine prepare(self, model, configuration)
    class(stabilisation_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp) :: stiffness(configuration%activation%known_count)
    logical :: near(model%mesh%cell_count)
    integer :: kind

    stiffness = 0.0_wp
    call stiffness_of_cells(model, configuration, stiffness)
    if (is_divided(model%part)) call learn_cell_values(model, configuration%activation, stiffness)
    call find_cells_near(model, configuration%activation, near)
    kind = model%analysis%method%stabilisation
    if (model%analysis%method%basis == basis_fem) kind = stabilise_none
    call build_penalty(model%mesh, model%space, configuration%activation, kind, &
      model%analysis%method%stabilisation_factor, stiffness, configuration%volumes, near, self%penalty)
  end subroutine prepare

  !> Marks the cells whose functions include owned nodes; penalties that act on none of these are left to other
  !> processes.
  pure subroutine find_cells_near(model, activation, near)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    !> (cells)
    logical, intent(out) :: near(:)
    integer :: c, n, nodes(most_functions)

    near = .true.
    if (.not. is_divided(model%part)) return
    near = activation%touched
    do c = 1, size(near)
      if (.not. near(c)) cycle
      call cell_nodes_of_space(model%space, model%mesh, c, nodes, n)
      near(c) = any(model%part%nodes(nodes(:n)))
    end do
  end subroutine find_cells_near

  !> Builds a penalty of the given kind.
  subroutine build_penalty(mesh, space, activation, kind, factor, stiffness, volumes, near, penalty)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(activation_type), intent(in) :: activation
    !> stabilise_none, stabilise_background or stabilise_ghost.
    integer, intent(in) :: kind
    !> eps or g.
    real(wp), intent(in) :: factor
    !> Young's modulus in each active cell (known_count), volume of each cell (cell_count).
    real(wp), intent(in) :: stiffness(:), volumes(:)
    !> Cells at which the penalty is required (cell_count).
    logical, intent(in) :: near(:)
    type(penalty_matrices_type), intent(out) :: penalty

    select case (kind)
    case (stabilise_background)
      call build_background(mesh, space, activation, factor, stiffness, near, penalty)
    case (stabilise_ghost)
      if (space%tensor) then
        call build_spline_ghost(mesh, space, activation, factor, stiffness, near, penalty)
      else
        call build_element_ghost(mesh, space, activation, factor, stiffness, volumes, near, penalty)
      end if
    end select
  end subroutine build_penalty

  !> Finds the smallest Young's modulus in each active cell: of its points or, where an outline has moved into a cell
  !> before a point of its body, of the points from which its parts take their states. In a cell shared by a thin stiff
  !> body and soil the larger modulus would resist the deformation of the soil.
  subroutine stiffness_of_cells(model, configuration, stiffness)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    !> (known_count); unchanged for cells without a point or a part of a body.
    real(wp), intent(inout) :: stiffness(:)
    integer :: g, i

    associate (activation => configuration%activation)
      do g = 1, activation%active_count
        stiffness(g) = smallest_modulus(model, model%state%points%material( &
          activation%point(activation%first(g):activation%first(g + 1) - 1)))
        if (stiffness(g) > 0.0_wp .or. .not. allocated(configuration%bodies)) cycle
        associate (bodies => configuration%bodies, c => activation%active_cell(g))
          stiffness(g) = smallest_modulus(model, source_material(bodies, model%state%points, &
            [(i, i=bodies%first(c), bodies%first(c + 1) - 1)]))
        end associate
      end do
    end associate
  end subroutine stiffness_of_cells

  !> Returns the smallest Young's modulus of some materials, 0 if there are none.
  pure real(wp) function smallest_modulus(model, materials) result(modulus)
    type(model_type), intent(in) :: model
    integer, intent(in) :: materials(:)
    integer :: i

    modulus = 0.0_wp
    if (size(materials) == 0) return
    modulus = huge(modulus)
    do i = 1, size(materials)
      modulus = min(modulus, model%laws(materials(i))%law%stiffness_scale)
    end do
  end function smallest_modulus

  !> Appends the node lists of the penalty.
  subroutine couple(self, configuration, connectivity)
    class(stabilisation_type), intent(in) :: self
    type(configuration_type), intent(in) :: configuration
    type(connectivity_type), intent(inout) :: connectivity

    call append_patches(connectivity, self%penalty%connectivity)
  end subroutine couple

  !> Applies the reduction factor of a re-equilibration.
  subroutine begin(self, increment)
    class(stabilisation_type), intent(inout) :: self
    type(increment_type), intent(in) :: increment

    if (self%penalty%connectivity%count > 0) self%penalty%matrix = increment%stabilisation*self%penalty%matrix
  end subroutine begin

  !> Adds G u.
  subroutine add_force(self, displacement, force)
    class(stabilisation_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)

    call add_penalty_force(self%penalty, displacement, force)
  end subroutine add_force

  !> Adds G, which is the same for every component.
  subroutine add_blocks(self, displacement, equations, matrix)
    class(stabilisation_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: k

    do k = 1, self%penalty%connectivity%count
      call add_scalar_block(equations, self%first_stencil + k - 1, self%penalty%matrix(:, :, k), matrix)
    end do
  end subroutine add_blocks

  !> Measures the share of the stabilisation in the forces of the cells, which the material does not support.
  subroutine measure(self, displacement, load_norm, connectivity, sizes, share)
    class(stabilisation_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(in) :: load_norm
    type(connectivity_type), intent(in) :: connectivity
    type(force_sizes_type), intent(in) :: sizes
    type(solve_share_type), intent(out) :: share
    real(wp) :: force(size(displacement, 1), size(displacement, 2))

    force = 0.0_wp
    call self%add_force(displacement, force)
    call sizes%keep_own(force)
    share = share_of_cells(self%share_name, force, displacement, connectivity, sizes%force, sizes%work, &
      sizes%most, sizes%team, sizes%copies)
  end subroutine measure

  !> Builds the soft background in boundary cells.
  subroutine build_background(mesh, space, activation, factor, stiffness, near, stabilisation)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(activation_type), intent(in) :: activation
    !> eps, and Young's modulus in each active cell (known_count).
    real(wp), intent(in) :: factor, stiffness(:)
    !> Cells that are to be stabilised themselves or as roots of boundary cells (cell_count).
    logical, intent(in) :: near(:)
    !> The stabilisation terms.
    type(penalty_matrices_type), intent(inout) :: stabilisation
    integer, allocatable :: cells(:), roots(:)
    logical, allocatable :: wanted(:)
    integer :: k

    cells = pack(activation%active_cell, activation%boundary .and. (space%tensor .or. activation%fill < whole_fill))
    roots = [(root_of(cells(k)), k=1, size(cells))]
    wanted = near(cells) .or. near(roots)
    cells = pack(cells, wanted)
    roots = pack(roots, wanted)
    call pair_cells(mesh, space, cells, roots, stabilisation)
    do k = 1, size(cells)
      associate (from => stabilisation%connectivity%first(k), to => stabilisation%connectivity%first(k + 1) - 1)
        call cell_matrix(cells(k), roots(k), factor*stiffness(activation%active_number(cells(k))), &
          stabilisation%connectivity%nodes(from:to), stabilisation%matrix(:, :, k))
      end associate
    end do

  contains

    !> Returns the cell whose linear field a boundary cell follows.
    pure integer function root_of(cell) result(root)
      !> Number of the boundary cell.
      integer, intent(in) :: cell
      real(wp) :: least, distance, most
      integer :: k, g, fullest

      root = cell
      most = activation%fill(activation%active_number(cell))
      if (most >= boundary_fill) return
      fullest = cell
      least = huge(least)
      do k = mesh%vertex_first(cell), mesh%vertex_first(cell + 1) - 1
        g = activation%active_number(mesh%vertex_neighbour(k))
        if (g == 0) cycle
        if (activation%fill(g) > most) fullest = mesh%vertex_neighbour(k)
        most = max(most, activation%fill(g))
        distance = norm2(cell_centre(mesh, cell) - cell_centre(mesh, mesh%vertex_neighbour(k)))
        if (activation%fill(g) < boundary_fill .or. distance >= least) cycle
        least = distance
        root = mesh%vertex_neighbour(k)
      end do
      if (root == cell) root = fullest
    end function root_of

    !> Adds the matrix of one cell.
    subroutine cell_matrix(cell, root, factor, nodes, matrix)
      !> The boundary cell and its root.
      integer, intent(in) :: cell, root
      !> eps E.
      real(wp), intent(in) :: factor
      !> Nodes of the patch (n).
      integer, intent(in) :: nodes(:)
      !> Leading (n,n) is added to.
      real(wp), intent(inout) :: matrix(:, :)
      real(wp), allocatable :: places(:, :), weights(:)
      real(wp), dimension(mesh%dimension, size(nodes)) :: mean, deviation
      type(shape_values_type) :: place
      real(wp) :: volume
      integer :: q, n

      n = size(nodes)
      mean = 0.0_wp
      volume = 0.0_wp
      call rule_of(root, places, weights)
      do q = 1, size(weights)
        call functions_at(space, mesh, root, places(:, q), place)
        call add_gradients(place, nodes, weights(q)*place%determinant, mean)
        volume = volume + weights(q)*place%determinant
      end do
      call rule_of(cell, places, weights)
      do q = 1, size(weights)
        call functions_at(space, mesh, cell, places(:, q), place)
        deviation = -mean/volume
        call add_gradients(place, nodes, 1.0_wp, deviation)
        matrix(:n, :n) = matrix(:n, :n) + factor*weights(q)*place%determinant*matmul(transpose(deviation), deviation)
      end do
    end subroutine cell_matrix

    !> Returns a quadrature rule that integrates products of gradients.
    subroutine rule_of(cell, places, weights)
      !> Number of the cell.
      integer, intent(in) :: cell
      !> Local coordinates (dimension, m), and weights (m).
      real(wp), allocatable, intent(out) :: places(:, :), weights(:)

      if (space%tensor .and. space%degree > 1) then
        call gauss_rule(mesh%cell_kind(cell), 2*space%degree, places, weights)
      else
        call full_rule(mesh%cell_kind(cell), places, weights)
      end if
    end subroutine rule_of
  end subroutine build_background

  !> Adds the gradients at a place, multiplied by a factor, to those of the nodes of a patch.
  pure subroutine add_gradients(place, nodes, factor, gradients)
    !> The functions at the place.
    type(shape_values_type), intent(in) :: place
    !> Nodes of the patch (n).
    integer, intent(in) :: nodes(:)
    real(wp), intent(in) :: factor
    !> (dimension, n)
    real(wp), intent(inout) :: gradients(:, :)
    integer :: a, b

    do a = 1, place%count
      b = findloc(nodes, place%node(a), dim=1)
      gradients(:, b) = gradients(:, b) + factor*place%gradient(:size(gradients, 1), a)
    end do
  end subroutine add_gradients
end module qsmpm_boundary_stabilisation
