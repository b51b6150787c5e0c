!> Stabilisation of boundary cells, acting on the displacement of the step in residual and tangent.
!>
!> A body ends somewhere inside a cell; the smaller the piece, the worse the equations. Two cures,
!> both bounding the condition number for any cut (docs/methods/ghost.md):
!>   background   a soft material in each boundary cell (`qsmpm_background`),
!>   ghost        a penalty on the jumps of derivatives over the faces of boundary cells
!>                (`qsmpm_element_ghost`, `qsmpm_spline_ghost`).
!> Either resists the step and is no load: its share is reported and a step is re-equilibrated until the
!> share is below its bound.
module qsmpm_boundary_stabilisation
  use qsmpm_kinds, only: wp
  use qsmpm_method_description, only: basis_fem, stabilise_none, stabilise_background, stabilise_ghost
  use qsmpm_background, only: build_background
  use qsmpm_body_quadrature, only: source_material
  use qsmpm_configuration, only: configuration_type
  use qsmpm_element_ghost, only: build_element_ghost
  use qsmpm_equations, only: equations_type
  use qsmpm_matrix_blocks, only: add_scalar_block
  use qsmpm_point_location, only: activation_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_model, only: model_type
  use qsmpm_node_graph, only: connectivity_type, append_patches
  use qsmpm_own_part, only: is_divided
  use qsmpm_penalty_matrices, only: penalty_matrices_type, add_penalty_force
  use qsmpm_ring_exchange, only: learn_cell_values
  use qsmpm_space, only: space_type, cell_nodes_of_space, most_functions
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_spline_ghost, only: build_spline_ghost
  use qsmpm_term, only: term_type, increment_type, force_sizes_type, role_numerical
  use qsmpm_term_share, only: solve_share_type, share_of_cells, stabilisation_share
  implicit none
  private

  public :: new_boundary_stabilisation, build_penalty

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

  !> The term.
  subroutine new_boundary_stabilisation(term)
    class(term_type), allocatable, intent(out) :: term

    allocate (stabilisation_type :: term)
    term%name = 'force of the stabilisation'
    term%role = role_numerical
    term%share_name = stabilisation_share
  end subroutine new_boundary_stabilisation

  !> The chosen penalty on the boundary cells of this step; FEM has none.
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

  !> Cells that see own nodes: what acts on none of them is left to others.
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

  !> A penalty by its kind.
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
    !> Cells that it is wanted at (cell_count).
    logical, intent(in) :: near(:)
    type(penalty_matrices_type), intent(out) :: penalty

    select case (kind)
    case (stabilise_background)
      call build_background(mesh, space, activation, factor, stiffness, near, penalty)
    case (stabilise_ghost)
      if (space%tensor) then
        call build_spline_ghost(mesh, space, activation, factor, stiffness, near, penalty)
      else
        call build_element_ghost(mesh, activation, factor, stiffness, volumes, near, penalty)
      end if
    end select
  end subroutine build_penalty

  !> Smallest Young's modulus in each active cell: of its points, else, where an outline has been carried into a cell
  !> before a point of its body, of those that the parts of it take their states from. In a cell that a thin stiff body
  !> shares with soil the larger one would resist what the soil does beside it.
  subroutine stiffness_of_cells(model, configuration, stiffness)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    !> (known_count); those of cells without a point or a part of a body here are left alone.
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

  !> Smallest Young's modulus of some materials, 0 of none.
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

  !> The nodes of the penalty.
  subroutine couple(self, configuration, connectivity)
    class(stabilisation_type), intent(in) :: self
    type(configuration_type), intent(in) :: configuration
    type(connectivity_type), intent(inout) :: connectivity

    call append_patches(connectivity, self%penalty%connectivity)
  end subroutine couple

  !> Fade in a re-equilibration.
  subroutine begin(self, increment)
    class(stabilisation_type), intent(inout) :: self
    type(increment_type), intent(in) :: increment

    if (self%penalty%connectivity%count > 0) self%penalty%matrix = increment%stabilisation*self%penalty%matrix
  end subroutine begin

  !> G u.
  subroutine add_force(self, displacement, force)
    class(stabilisation_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)

    call add_penalty_force(self%penalty, displacement, force)
  end subroutine add_force

  !> G, the same for every component.
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

  !> Its share of the forces of the cells: what the material does not carry.
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
end module qsmpm_boundary_stabilisation
