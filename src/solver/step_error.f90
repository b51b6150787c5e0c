!> What the length of a step costs: the difference between the step as taken and its deformation walked
!> in two halves (qsmpm_halved_law), in stress and in position.
!>
!>   path       e_s = 2 |sigma_2 - sigma_1| / |sigma_1|, norms over the volume
!>   position   e_u = 2 max |K^-1 (f_1 - f_2)| / max |u|, u the displacement of the step
!> f_2 are the internal forces of the halved walk, K the matrix the step was last factorised with: what the
!> stresses of a longer path would move the nodes by. The laws are of first order at least, so two halves
!> leave half of the error of one step and their difference is the other half: hence the factor 2.
!> Hyperelastic steps have none, however long: the stress does not know the path.
module qsmpm_step_error
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_law, only: law_slot_type, tangent_none
  use qsmpm_halved_law, only: halved_law_type, make_halved_law
  use qsmpm_linear_system, only: solve_system
  use qsmpm_initialisation, only: step_type
  use qsmpm_assembly, only: evaluation_type, evaluate, prepare_evaluation
  use qsmpm_system_matrix, only: gather
  implicit none
  private

  public :: step_error_type, measure_step_error

  !> Residual of the move where it is iterated: an estimate needs no more.
  real(wp), parameter :: digits_of_move = 1.0e-4_wp

  !> Errors of a step as shares.
  type :: step_error_type
    !> Of the stresses.
    real(wp) :: path = 0.0_wp
    !> Of the displacements of the step.
    real(wp) :: position = 0.0_wp
  end type step_error_type

contains

  !> Errors of a step in equilibrium that has not been taken yet.
  subroutine measure_step_error(step, laws, displacement, errors, error)
    !> Scratch of the step, evaluated and factorised.
    type(step_type), intent(inout) :: step
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> The errors; huge where the halved walk could not be made.
    type(step_error_type), intent(out) :: errors
    !> The equations could not be solved.
    type(error_type), allocatable, intent(out) :: error
    type(law_slot_type) :: halved(size(laws))
    type(evaluation_type) :: walk
    real(wp) :: residual(step%equations%count), move(step%equations%count)

    call halve(laws, halved)
    call prepare_evaluation(step%integration, size(displacement, 1), size(displacement, 2), .false., walk)
    call evaluate(step%integration, halved, displacement, tangent_none, walk)
    if (.not. walk%ok) then
      errors = step_error_type(huge(1.0_wp), huge(1.0_wp))
      return
    end if
    errors%path = 2.0_wp*stress_distance(step, walk)
    if (step%equations%count == 0 .or. .not. any(abs(displacement) > 0.0_wp)) return
    call gather(step%equations, step%evaluation%force - walk%force, residual)
    if (.not. any(abs(residual) > 0.0_wp)) return
    call solve_system(step%system, step%matrix, residual, digits_of_move, move, error)
    if (allocated(error)) return
    errors%position = 2.0_wp*maxval(abs(move))/maxval(abs(displacement))
  end subroutine measure_step_error

  !> The laws, each in two halves a step.
  subroutine halve(laws, halved)
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> The same in halves.
    type(law_slot_type), intent(out) :: halved(:)
    type(halved_law_type) :: law
    integer :: m

    do m = 1, size(laws)
      call make_halved_law(laws(m)%law, law)
      allocate (halved(m)%law, source=law)
      halved(m)%pressure_factor = laws(m)%pressure_factor
    end do
  end subroutine halve

  !> |sigma_2 - sigma_1| / |sigma_1|, root mean squares over the volume.
  pure real(wp) function stress_distance(step, walk)
    !> Scratch of the step, evaluated.
    type(step_type), intent(in) :: step
    !> The walk in halves.
    type(evaluation_type), intent(in) :: walk
    real(wp) :: difference, total
    integer :: q

    difference = 0.0_wp
    total = 0.0_wp
    associate (weight => step%integration%weight, stress => step%evaluation%stress)
      do q = 1, size(weight)
        difference = difference + weight(q)*sum((walk%stress(:, q) - stress(:, q))**2)
        total = total + weight(q)*sum(stress(:, q)**2)
      end do
    end associate
    stress_distance = 0.0_wp
    if (total > 0.0_wp) stress_distance = sqrt(difference/total)
  end function stress_distance
end module qsmpm_step_error
