!> Error due to the length of a step: the difference between the step and the same deformation applied in two halves
!> (qsmpm_half_step_law), in stress and in position.
!>
!>   path       e_s = 2 |sigma_2 - sigma_1| / |sigma_1|, norms over the volume
!>   position   e_u = 2 max |K^-1 (f_1 - f_2)| / max |u|, u the displacement of the step
!> f_2 are the internal forces of the two halves, K is the matrix of the last factorisation of the step: the position
!> error is the displacement due to the stresses of the refined path. The laws are at least of first order, so that two
!> halves have half of the error of one step and the difference is the other half: hence the factor 2. Hyperelastic
!> steps have no such error, because the stress does not depend on the path.
module qsmpm_step_error
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: any_of
  use qsmpm_error, only: error_type
  use qsmpm_finite, only: all_usable, is_usable
  use qsmpm_law, only: law_slot_type, tangent_none, tangent_consistent
  use qsmpm_half_step_law, only: half_step_law_type, make_half_step_law
  use qsmpm_joint_system, only: bring_matrix, preconditions_only, solve_by_factors, solve_jointly
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: own_cells
  use qsmpm_integration, only: integration_type
  use qsmpm_initialisation, only: step_type, evaluate_step
  use qsmpm_assembly, only: evaluation_type, evaluate, prepare_evaluation
  use qsmpm_equations, only: gather
  use qsmpm_soil_points, only: soil_type, soil_of, integration_of
  use qsmpm_term_sums, only: add_all_blocks
  use qsmpm_team, only: team_type, largest, total
  implicit none
  private

  public :: step_error_type, measure_step_error

  !> Residual of the displacement where it is solved iteratively; sufficient for an estimate.
  real(wp), parameter :: digits_of_move = 1.0e-4_wp

  !> Errors of a step as shares.
  type :: step_error_type
    !> Error of the stresses.
    real(wp) :: path = 0.0_wp
    !> Error of the displacements of the step.
    real(wp) :: position = 0.0_wp
  end type step_error_type

contains

  !> Measures the errors of a step in equilibrium that has not been accepted yet.
  subroutine measure_step_error(model, step, displacement, path_only, errors, error)
    type(model_type), intent(in) :: model
    !> Scratch data of the step, evaluated and factorised.
    type(step_type), intent(inout), target :: step
    !> Displacement of the step and changes of further fields (components, nodes).
    real(wp), intent(in) :: displacement(:, :)
    !> Omits the error of the position, which requires a solution, and returns 0 for it.
    logical, intent(in) :: path_only
    !> The errors; huge where the two halves could not be evaluated or the result is not a number.
    type(step_error_type), intent(out) :: errors
    !> The equations could not be solved.
    type(error_type), allocatable, intent(out) :: error
    type(law_slot_type) :: halved(size(model%laws))
    type(evaluation_type) :: whole, walk
    type(soil_type), pointer :: soil
    type(integration_type), pointer :: integration
    real(wp) :: residual(step%equations%count), move(step%equations%count)
    logical :: own(step%equations%count)

    soil => soil_of(step%terms)
    integration => integration_of(soil, step%configuration_type)
    call halve(model%laws, halved)
    whole%step_info = soil%evaluation%step_info
    whole%lasting = soil%evaluation%lasting
    whole%draining = soil%evaluation%draining
    if (allocated(soil%evaluation%pressure_offset)) whole%pressure_offset = soil%evaluation%pressure_offset
    if (allocated(soil%evaluation%field)) whole%field = soil%evaluation%field
    walk = whole
    associate (u => displacement(:model%mesh%dimension, :model%space%node_count))
      call walk_along(integration, model, model%laws, u, whole)
      call walk_along(integration, model, halved, u, walk)
    end associate
    if (any_of(step%team, .not. (whole%ok .and. walk%ok))) then
      errors = step_error_type(huge(1.0_wp), huge(1.0_wp))
      return
    end if
    errors%path = 2.0_wp*stress_distance(step%team, counted_volumes(model, integration), whole%results%stress, &
      walk%results%stress)
    if (path_only) return
    if (total(step%team, int(step%equations%count, long)) == 0) return
    associate (u => displacement(:, :model%space%node_count))
      if (.not. any_of(step%team, any(abs(u) > 0.0_wp))) return
      residual = 0.0_wp
      call gather(step%equations, whole%force - walk%force, residual)
      own = step%field_of > 0
      if (.not. any_of(step%team, any(own .and. abs(residual) > 0.0_wp))) return
      call respond_to(model, step, displacement, residual, move, error)
      if (allocated(error)) return
      errors%position = huge(1.0_wp)
      if (any_of(step%team, .not. all_usable(size(move), move))) return
      errors%position = 2.0_wp*largest(step%team, maxval(abs(move), mask=step%field_of == 1)) &
        /largest(step%team, maxval(abs(u)))
    end associate
  end subroutine measure_step_error

  !> Solves for the displacements due to a residual: with the last factors of the step or, where these are only a
  !> preconditioner, with the present matrix.
  subroutine respond_to(model, step, displacement, residual, move, error)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    !> Displacement of the step and changes of further fields (components, nodes).
    real(wp), intent(in) :: displacement(:, :)
    !> Residual (equations).
    real(wp), intent(in) :: residual(:)
    !> The displacements (equations).
    real(wp), intent(out) :: move(:)
    !> The equations could not be solved.
    type(error_type), allocatable, intent(out) :: error

    if (preconditions_only(step%joint, step%team, step%system)) then
      call evaluate_step(model, step, displacement, tangent_consistent)
      call add_all_blocks(step%terms, displacement, step%equations, step%matrix)
      call bring_matrix(step%joint, step%team, step%matrix)
      call solve_jointly(step%joint, step%team, step%system, step%equations, step%matrix, residual, digits_of_move, &
        move, error)
    else
      call solve_by_factors(step%joint, step%team, step%system, residual, move, error)
    end if
  end subroutine respond_to

  !> Creates the laws that apply each step in two halves.
  subroutine halve(laws, halved)
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Laws that divide each step into halves.
    type(law_slot_type), intent(out) :: halved(:)
    type(half_step_law_type) :: law
    integer :: m

    do m = 1, size(laws)
      call make_half_step_law(laws(m)%law, law)
      allocate (halved(m)%law, source=law)
      halved(m)%pressure_factor = laws(m)%pressure_factor
      halved(m)%flows = laws(m)%flows
      halved(m)%confinement = laws(m)%confinement
    end do
  end subroutine halve

  !> Evaluates stresses and forces at the end of the step with the given laws.
  subroutine walk_along(integration, model, laws, displacement, evaluation)
    type(integration_type), intent(in) :: integration
    type(model_type), intent(in) :: model
    type(law_slot_type), intent(in) :: laws(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> The results.
    type(evaluation_type), intent(inout) :: evaluation

    call prepare_evaluation(integration, size(displacement, 1), size(displacement, 2), .true., .false., evaluation)
    call evaluate(integration, model%state%points, laws, displacement, tangent_none, evaluation)
  end subroutine walk_along

  !> Returns the volumes of the integration points; zero in cells owned by other processes.
  pure function counted_volumes(model, integration) result(volumes)
    type(model_type), intent(in) :: model
    type(integration_type), intent(in) :: integration
    real(wp) :: volumes(size(integration%weight))
    logical :: own(integration%group_count)
    integer :: g

    volumes = integration%weight
    own = own_cells(model%part, integration%cell(:integration%group_count))
    do g = 1, integration%group_count
      if (.not. own(g)) volumes(integration%first(g):integration%first(g + 1) - 1) = 0.0_wp
    end do
  end function counted_volumes

  !> Returns |sigma_2 - sigma_1| / |sigma_1|, root mean squares over the volume of all processes.
  real(wp) function stress_distance(team, weight, whole, walk)
    type(team_type), intent(in) :: team
    !> Volumes of the points (n).
    real(wp), intent(in) :: weight(:)
    !> Stresses of the whole step and of the two halves (4 or 6, n).
    real(wp), intent(in) :: whole(:, :), walk(:, :)
    !> Sums for the difference and for the stress.
    real(wp) :: squares(2)
    integer :: q

    squares = 0.0_wp
    do q = 1, size(weight)
      squares = squares + weight(q)*[sum((walk(:, q) - whole(:, q))**2), sum(whole(:, q)**2)]
    end do
    squares = total(team, squares)
    stress_distance = 0.0_wp
    if (squares(2) > 0.0_wp) stress_distance = sqrt(squares(1)/squares(2))
    if (.not. (is_usable(sqrt(squares(2))) .and. is_usable(stress_distance))) stress_distance = 0.5_wp*huge(1.0_wp)
  end function stress_distance
end module qsmpm_step_error
