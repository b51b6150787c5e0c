!> A second field beside the displacement, whole: a scalar p that diffuses through the body and a term of its own,
!>
!>   sum V grad N_a . grad N_b p_b        (points of the body, volumes V)
!>
!> on the space of the displacement.
module diffusion_term
  use qsmpm_kinds, only: wp
  use qsmpm_configuration, only: configuration_type
  use qsmpm_equations, only: equations_type, add_block
  use qsmpm_integration, only: place_of
  use qsmpm_model, only: model_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_term, only: term_type
  use qsmpm_unknowns, only: unknowns_type, joint_node
  implicit none
  private

  public :: diffusion_type

  type, extends(term_type) :: diffusion_type
    type(unknowns_type) :: unknowns
    integer :: field = 2
    !> (most nodes, most nodes, groups)
    real(wp), allocatable :: conductance(:, :, :)
  contains
    procedure :: prepare
    procedure :: add_force
    procedure :: add_blocks
  end type diffusion_type

contains

  !> The nodes of the groups of material points, as nodes of the scalar, and their conductances.
  subroutine prepare(self, model, configuration)
    class(diffusion_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    integer :: g, q, j, n, b

    associate (p => configuration%at_points)
      self%connectivity%count = p%group_count
      self%connectivity%first = p%node_first
      self%connectivity%nodes = joint_node(self%unknowns, p%nodes, self%field)
      n = maxval(p%node_first(2:) - p%node_first(:p%group_count))
      if (allocated(self%conductance)) deallocate (self%conductance)
      allocate (self%conductance(n, n, p%group_count), source=0.0_wp)
      do g = 1, p%group_count
        n = p%node_first(g + 1) - p%node_first(g)
        do q = p%first(g), p%first(g + 1) - 1
          do j = 1, model%mesh%dimension
            b = p%directions*place_of(p, g, q) + (j - 1)*n
            associate (slope => p%gradient(b + 1:b + n))
              self%conductance(:n, :n, g) = self%conductance(:n, :n, g) &
                + p%weight(q)*spread(slope, 2, n)*spread(slope, 1, n)
            end associate
          end do
        end do
      end do
    end associate
  end subroutine prepare

  !> Flow out of the nodes.
  subroutine add_force(self, displacement, force)
    class(diffusion_type), intent(in) :: self
    !> The table of all unknowns.
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    integer :: g, n

    do g = 1, self%connectivity%count
      associate (nodes => self%connectivity%nodes(self%connectivity%first(g):self%connectivity%first(g + 1) - 1))
        n = size(nodes)
        force(1, nodes) = force(1, nodes) + matmul(self%conductance(:n, :n, g), displacement(1, nodes))
      end associate
    end do
  end subroutine add_force

  !> The conductances.
  subroutine add_blocks(self, displacement, equations, matrix)
    class(diffusion_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: g, n

    associate (unused => displacement)
    end associate
    do g = 1, self%connectivity%count
      n = self%connectivity%first(g + 1) - self%connectivity%first(g)
      call add_block(equations, self%first_stencil + g - 1, reshape(self%conductance(:n, :n, g), [1, n, 1, n]), matrix)
    end do
  end subroutine add_blocks
end module diffusion_term
