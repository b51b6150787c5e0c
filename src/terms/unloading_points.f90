!> The bodies that a phase takes out: their stress and weight are lowered evenly over it.
!>
!>   f_external  +=  (1 - l) (sum w g N_a + surface loads - sum V sigma grad N_a)       l the load fraction of the phase
!>
!> At l = 0 the balance of the phase before is met, at l = 1 nothing is left. The sums are over the points taken out,
!> which ride with the mesh (qsmpm_unloading); g is gravity as the phase began. They have no stiffness: nodes that they
!> alone hold are in no equation. docs/methods/stages.md.
module qsmpm_unloading_points
  use qsmpm_kinds, only: wp
  use qsmpm_configuration, only: configuration_type
  use qsmpm_model, only: model_type
  use qsmpm_term, only: term_type, role_external
  implicit none
  private

  public :: new_unloading_points

  type, extends(term_type) :: unloading_points_type
    !> Nodal forces in force (dimension, nodes); unallocated without.
    real(wp), allocatable :: force(:, :)
  contains
    procedure :: prepare
    procedure :: set_load
    procedure :: add_force
  end type unloading_points_type

contains

  !> The term.
  subroutine new_unloading_points(term)
    class(term_type), allocatable, intent(out) :: term

    allocate (unloading_points_type :: term)
    term%name = 'force of the bodies taken out'
    term%role = role_external
  end subroutine new_unloading_points

  !> Nothing is in force yet.
  subroutine prepare(self, model, configuration)
    class(unloading_points_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration

    if (allocated(self%force)) deallocate (self%force)
    if (allocated(configuration%unloading)) &
      allocate (self%force(model%mesh%dimension, model%space%node_count), source=0.0_wp)
  end subroutine prepare

  !> What is left at a fraction of the phase.
  subroutine set_load(self, model, configuration, fraction)
    class(unloading_points_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: fraction
    integer :: i

    if (.not. allocated(self%force)) return
    do i = 1, size(self%force, 1)
      self%force(i, :) = (1.0_wp - fraction)*(configuration%unloading(i, :) &
        + model%loading%gravity_start(i)*configuration%unloading_weight)
    end do
  end subroutine set_load

  !> They do not follow the displacement.
  subroutine add_force(self, displacement, force)
    class(unloading_points_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)

    if (allocated(self%force)) force = force + self%force
  end subroutine add_force
end module qsmpm_unloading_points
