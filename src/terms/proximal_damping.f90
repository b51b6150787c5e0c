!> Proximal damping: a force alpha W u opposed to the displacement of a sub-step, W the lumped volumes. It limits the
!> motion of a body under a load that it cannot support yet, and is not part of the equilibrium by which a step is
!> accepted. docs/methods/proximal.md
module qsmpm_proximal_damping
  use qsmpm_kinds, only: wp
  use qsmpm_configuration, only: configuration_type
  use qsmpm_equations, only: equations_type
  use qsmpm_matrix_blocks, only: add_diagonal
  use qsmpm_model, only: model_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_term, only: term_type, increment_type
  implicit none
  private

  public :: damping_type

  type, extends(term_type) :: damping_type
    !> alpha, and W (nodes).
    real(wp) :: coefficient = 0.0_wp
    real(wp), allocatable :: volume(:)
  contains
    procedure :: prepare
    procedure :: begin
    procedure :: add_force
    procedure :: add_blocks
  end type damping_type

contains

  !> Sets the volumes; the term adds no coupling of nodes.
  subroutine prepare(self, model, configuration)
    class(damping_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration

    self%coefficient = 0.0_wp
    self%volume = configuration%lumped
  end subroutine prepare

  !> Sets the coefficient.
  subroutine begin(self, increment)
    class(damping_type), intent(inout) :: self
    type(increment_type), intent(in) :: increment

    self%coefficient = increment%damping
  end subroutine begin

  !> Adds alpha W u.
  subroutine add_force(self, displacement, force)
    class(damping_type), intent(in) :: self
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)

    if (self%coefficient > 0.0_wp) &
      force = force + self%coefficient*spread(self%volume, 1, size(force, 1))*displacement
  end subroutine add_force

  !> Adds alpha W.
  subroutine add_blocks(self, displacement, equations, matrix)
    class(damping_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: a, c

    if (.not. self%coefficient > 0.0_wp) return
    do a = 1, size(self%volume)
      do c = 1, size(displacement, 1)
        call add_diagonal(equations, c, a, self%coefficient*self%volume(a), matrix)
      end do
    end do
  end subroutine add_blocks
end module qsmpm_proximal_damping
