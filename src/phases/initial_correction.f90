!> Correction of K0 stresses to equilibrium on the given grid.
!>
!> The stress of a point represents its domain. Where points are integrated, quadratic functions require, in the row of
!> cells at the boundary of the soil, also the variation of the stress inside the domain, and cells with uniform
!> pressure have no variation inside the cell: K0 stresses of level ground are then slightly out of balance. The
!> imbalance is removed with an elastic material in place of each material,
!>
!>   r = f_load - sum V sigma grad N,   u = K^-1 r,   sigma := sigma + D grad u         until max|u| is nearly zero
!>
!> with stiffnesses proportional to the modulus that scales the stabilisation. The modulus of the law itself is not
!> suitable: soil whose stiffness decreases with its stress has nearly none at the surface, where r is. Positions do not
!> change and no displacement remains. Imbalance that is not due to the grid is not corrected: inclined ground, loads
!> that the stresses do not balance (qsmpm_initial_balance).
!>
!> Cells with uniform pressure are assigned the mean of their effective pressures here. If this were left to the first
!> step, the different stiffness of soil at low stress would change the weights of the points, and in undrained soil the
!> pressure would be equalised by the water. The remaining imbalance of the laws themselves, because soil at yield
!> everywhere does not support the stress between its points, is corrected in the same way.
module qsmpm_initial_correction
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: agree
  use qsmpm_analysis, only: three_dimensional
  use qsmpm_deformation, only: point_displacement
  use qsmpm_division, only: migrate_points
  use qsmpm_equations, only: gather, scatter
  use qsmpm_error, only: error_type
  use qsmpm_initial_stress, only: start_states
  use qsmpm_initialisation, only: step_type, initialise_step, evaluate_step
  use qsmpm_law, only: law_slot_type, law_type, tangent_elastic, tangent_none
  use qsmpm_law_factory, only: new_law, kinematics_jaumann, rate_midpoint
  use qsmpm_joint_system, only: factorise_jointly, solve_jointly
  use qsmpm_material_parameters, only: material_parameters_type
  use qsmpm_model, only: model_type
  use qsmpm_soil_points, only: soil_type, soil_of, find_point_results
  use qsmpm_team, only: largest
  use qsmpm_term_sums, only: add_all_blocks, set_loads, discard_terms
  implicit none
  private

  public :: correction_type, correct_stresses, elastic_moves, largest_move, find_largest_move

  !> Largest displacement, relative to that under the weight, that is attributed to the grid, and the one that may
  !> remain.
  real(wp), parameter :: largest_of_grid = 1.0e-2_wp
  real(wp), parameter :: enough = 1.0e-9_wp
  !> Largest number of passes with elastic soil, and with the forces of the laws: in clay at yield one pass may reduce
  !> the imbalance by as little as 14 %.
  integer, parameter :: most_passes = 12, most_by_law = 40
  !> Residual of an iterative solution.
  real(wp), parameter :: digits = 1.0e-6_wp
  !> Poisson's ratio of the elastic materials, and their stiffness relative to the materials they represent, so that
  !> terms of second order in the strains vanish.
  real(wp), parameter :: ratio = 0.3_wp, stiffer = 100.0_wp
  !> Factor of the uniform cell pressure of these materials: nearly zero, so that pressures are uniform to rounding.
  real(wp), parameter :: even = 1.0e-9_wp

  !> Result of the correction.
  type :: correction_type
    !> Displacement of elastic soil relative to that under its weight, before and after.
    real(wp) :: before = 0.0_wp, after = 0.0_wp
    !> Largest change of a stress component relative to the largest stress; 0 where nothing was corrected.
    real(wp) :: change = 0.0_wp
    !> Only the mean pressure was assigned to cells with uniform pressure; the balance is that of the forces of the laws
    !> instead of the stresses.
    logical :: evened_only = .false., by_law = .false.
  end type correction_type

contains

  !> Corrects the stresses of the points where they move elastic soil by more than `from` and by no more than is
  !> attributed to the grid, and equalises them in cells with uniform pressure. The states of the laws are updated.
  subroutine correct_stresses(model, step, from, correction, error)
    type(model_type), intent(inout) :: model
    !> Scratch data of the step.
    type(step_type), intent(inout) :: step
    !> Share of the settlement under the own weight.
    real(wp), intent(in) :: from
    type(correction_type), intent(out) :: correction
    !> Failures of the initialisation.
    type(error_type), allocatable, intent(out) :: error
    type(law_slot_type), allocatable :: own(:)
    real(wp), allocatable :: move(:, :), given(:, :)

    ! Points in the order in which `renew_copies` leaves them.
    call migrate_points(model, error)
    if (allocated(error)) return
    allocate (given, source=model%state%points%stress)
    call take_elastic_laws(model, own)
    call find_move(model, step, move, correction%before, error)
    correction%after = correction%before
    if (.not. allocated(error) .and. correction%before <= largest_of_grid) then
      if (any(own%pressure_factor > 0.0_wp)) call even_pressures(model, step, own, move, correction%after, error)
      correction%evened_only = .not. correction%after > from
      if (.not. (correction%evened_only .or. allocated(error))) &
        call repeat_correction(model, step, move, correction%after)
      if (.not. allocated(error)) call follow_laws(model, step, own, correction, error)
      associate (stress => model%state%points%stress)
        correction%change = largest(model%part%team, maxval(abs(stress - given))) &
          /max(largest(model%part%team, maxval(abs(given))), tiny(1.0_wp))
      end associate
    end if
    call move_alloc(own, model%laws)
    if (correction%change > 0.0_wp) call start_states(model)
  end subroutine correct_stresses

  !> Assigns the mean pressure to cells with uniform pressure, and computes the remaining displacement.
  subroutine even_pressures(model, step, own, move, share, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: own(:)
    !> Displacement of the elastic soil (components, nodes), and its share.
    real(wp), allocatable, intent(inout) :: move(:, :)
    real(wp), intent(inout) :: share
    !> A point that cannot be updated; failures of the initialisation.
    type(error_type), allocatable, intent(out) :: error

    move = 0.0_wp
    model%laws%pressure_factor = merge(even, 0.0_wp, own%pressure_factor > 0.0_wp)
    call initialise_step(model, step, error)
    if (allocated(error)) return
    ! The pressure variation inside a cell due to weight is not equalised.
    call set_loads(step%terms, model, step%configuration_type, model%state%progress%fraction)
    call take_elastic_stress(model, step, move, error)
    if (.not. allocated(error)) call find_move(model, step, move, share, error)
  end subroutine even_pressures

  !> Corrects the stresses by the imbalance of the laws of the materials, where these do not support them at all
  !> integration points.
  subroutine follow_laws(model, step, own, correction, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    !> Laws of the materials; those of the model are elastic.
    type(law_slot_type), allocatable, intent(inout) :: own(:)
    !> Result of the correction with elastic soil, updated here.
    type(correction_type), intent(inout) :: correction
    !> Failures of the initialisation.
    type(error_type), allocatable, intent(out) :: error
    real(wp), allocatable :: move(:, :)
    real(wp) :: share

    call find_move(model, step, move, share, error, own)
    if (allocated(error)) return
    correction%by_law = share > max(enough, 2.0_wp*correction%after) .and. share < largest_of_grid
    if (correction%by_law) call repeat_correction(model, step, move, share, own)
    correction%evened_only = correction%evened_only .and. .not. correction%by_law
    correction%by_law = correction%by_law .or. any(own%pressure_factor > 0.0_wp)
  end subroutine follow_laws

  !> Repeats the correction as long as the balance improves.
  subroutine repeat_correction(model, step, move, share, own)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    !> Displacement of the elastic soil (components, nodes), and its share.
    real(wp), allocatable, intent(inout) :: move(:, :)
    real(wp), intent(inout) :: share
    !> Laws whose forces are balanced, instead of those of the model.
    type(law_slot_type), allocatable, intent(inout), optional :: own(:)
    type(error_type), allocatable :: error
    real(wp), allocatable :: best(:, :)
    real(wp) :: present_share
    integer :: pass

    allocate (best, source=model%state%points%stress)
    do pass = 1, merge(most_by_law, most_passes, present(own))
      call take_elastic_stress(model, step, move, error)
      if (.not. allocated(error)) call find_move(model, step, move, present_share, error, own)
      if (allocated(error)) exit
      if (.not. present_share < share) exit
      share = present_share
      best = model%state%points%stress
      if (share <= enough) exit
    end do
    model%state%points%stress = best
  end subroutine repeat_correction

  !> Replaces the laws of the materials by elastic ones.
  subroutine take_elastic_laws(model, own)
    type(model_type), intent(inout) :: model
    !> Laws of the materials.
    type(law_slot_type), allocatable, intent(out) :: own(:)
    type(error_type), allocatable :: error
    integer :: m

    call move_alloc(model%laws, own)
    allocate (model%laws(size(own)))
    model%laws%confinement = own%confinement
    do m = 1, size(own)
      call new_law(material_parameters_type(young=stiffer*own(m)%law%stiffness_scale, poisson=ratio), &
        merge(3, 2, model%analysis%model == three_dimensional), kinematics_jaumann, rate_midpoint, model%laws(m)%law, &
        error)
      ! A user-defined model without a known modulus.
      if (allocated(error)) allocate (model%laws(m)%law, source=own(m)%law)
    end do
  end subroutine take_elastic_laws

  !> Computes the displacement that the stresses would cause; zero where the equations cannot be solved.
  subroutine find_move(model, step, move, share, error, own)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    !> (components, nodes)
    real(wp), allocatable, intent(out) :: move(:, :)
    !> Largest displacement relative to that under the loads; huge where a law has no result.
    real(wp), intent(out) :: share
    !> Failures of the initialisation.
    type(error_type), allocatable, intent(out) :: error
    !> Laws whose forces are balanced, instead of those of the model.
    type(law_slot_type), allocatable, intent(inout), optional :: own(:)
    type(error_type), allocatable :: unsolved
    real(wp), allocatable, dimension(:) :: weight, residual, by_weight, by_residual
    real(wp), allocatable :: internal(:, :)

    share = huge(share)
    if (present(own)) then
      call find_forces(model, step, own, internal, error)
      if (allocated(error) .or. step%failure%failed) return
    end if
    share = 0.0_wp
    call initialise_step(model, step, error)
    if (allocated(error)) return
    allocate (move, mold=step%forces%internal)
    move = 0.0_wp
    allocate (weight(step%equations%count), residual(step%equations%count), by_weight(step%equations%count), &
      by_residual(step%equations%count), source=0.0_wp)
    call set_loads(step%terms, model, step%configuration_type, model%state%progress%fraction)
    call evaluate_step(model, step, move, tangent_elastic)
    if (step%failure%failed) return
    if (.not. present(own)) allocate (internal, source=step%forces%internal)
    call gather(step%equations, step%forces%external, weight)
    call gather(step%equations, step%forces%external - internal, residual)
    call elastic_moves(step, weight, residual, by_weight, by_residual, unsolved)
    call discard_terms(step%terms)
    if (allocated(unsolved)) return
    call scatter(step%equations, by_residual, move)
    share = largest_move(step, by_residual)/max(largest_move(step, by_weight), tiny(1.0_wp))
  end subroutine find_move

  !> Returns the largest displacement component of the material points of all processes: nodes outside the soil with
  !> nearly no support are excluded.
  real(wp) function largest_move(step, move)
    type(step_type), intent(in) :: step
    !> (equations)
    real(wp), intent(in) :: move(:)
    real(wp) :: of_own
    integer :: point

    call find_largest_move(step, move, of_own, point)
    largest_move = largest(step%team, of_own)
  end function largest_move

  !> Finds the largest displacement component of this process, and its point; 0 for none.
  subroutine find_largest_move(step, move, most, point)
    type(step_type), intent(in) :: step
    !> (equations)
    real(wp), intent(in) :: move(:)
    real(wp), intent(out) :: most
    integer, intent(out) :: point
    real(wp) :: nodal(size(step%forces%internal, 1), size(step%forces%internal, 2)), u
    integer :: g, q

    nodal = 0.0_wp
    call scatter(step%equations, move, nodal)
    most = 0.0_wp
    point = 0
    associate (at_points => step%at_points)
      do g = 1, at_points%group_count
        do q = at_points%first(g), at_points%first(g + 1) - 1
          u = maxval(abs(point_displacement(at_points, nodal, g, q)))
          if (.not. u > most) cycle
          most = u
          point = at_points%source(q)
        end do
      end do
    end associate
  end subroutine find_largest_move

  !> Computes the internal forces of the laws of the materials, whose states are consistent with the stresses of the
  !> points.
  subroutine find_forces(model, step, own, internal, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    !> Laws of the materials; those of the model are elastic.
    type(law_slot_type), allocatable, intent(inout) :: own(:)
    !> (components, nodes)
    real(wp), allocatable, intent(out) :: internal(:, :)
    !> Failures of the initialisation.
    type(error_type), allocatable, intent(out) :: error

    call exchange_laws(model, own)
    call start_states(model)
    call initialise_step(model, step, error)
    if (.not. allocated(error)) then
      allocate (internal, mold=step%forces%internal)
      internal = 0.0_wp
      call set_loads(step%terms, model, step%configuration_type, model%state%progress%fraction)
      call evaluate_step(model, step, internal, tangent_none)
      internal = step%forces%internal
      call discard_terms(step%terms)
    end if
    call exchange_laws(model, own)
  end subroutine find_forces

  !> Exchanges the laws of the model with others.
  subroutine exchange_laws(model, others)
    type(model_type), intent(inout) :: model
    type(law_slot_type), intent(inout) :: others(:)
    class(law_type), allocatable :: law
    real(wp) :: factor
    integer :: m

    do m = 1, size(others)
      call move_alloc(model%laws(m)%law, law)
      call move_alloc(others(m)%law, model%laws(m)%law)
      call move_alloc(law, others(m)%law)
      factor = model%laws(m)%pressure_factor
      model%laws(m)%pressure_factor = others(m)%pressure_factor
      others(m)%pressure_factor = factor
    end do
  end subroutine exchange_laws

  !> Solves for the displacements due to two forces, with the blocks of the last evaluation at zero displacement.
  subroutine elastic_moves(step, weight, residual, by_weight, by_residual, error)
    type(step_type), intent(inout) :: step
    !> Forces and displacements (equations).
    real(wp), intent(in) :: weight(:), residual(:)
    real(wp), intent(out) :: by_weight(:), by_residual(:)
    !> The equations cannot be solved.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: nothing(size(step%forces%internal, 1), size(step%forces%internal, 2))

    nothing = 0.0_wp
    call add_all_blocks(step%terms, nothing, step%equations, step%matrix)
    call factorise_jointly(step%joint, step%team, step%system, step%equations, step%matrix, error)
    if (.not. allocated(error)) call solve_jointly(step%joint, step%team, step%system, step%equations, step%matrix, &
      weight, digits, by_weight, error)
    if (.not. allocated(error)) call solve_jointly(step%joint, step%team, step%system, step%equations, step%matrix, &
      residual, digits, by_residual, error)
  end subroutine elastic_moves

  !> Updates the stresses of the points after a displacement of the elastic soil. Positions do not change.
  subroutine take_elastic_stress(model, step, move, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    !> (components, nodes)
    real(wp), intent(in) :: move(:, :)
    !> A point that cannot be updated.
    type(error_type), allocatable, intent(out) :: error
    type(soil_type), pointer :: soil
    integer, allocatable :: source(:)

    soil => soil_of(step%terms)
    ! The work space for an evaluation at the points is allocated below, and replaces that of the equations.
    if (soil%updates_points) call evaluate_step(model, step, move, tangent_none)
    call find_point_results(soil, model, step%configuration_type, &
      move(:model%mesh%dimension, :model%space%node_count), source, error)
    call agree(step%team, error)
    if (allocated(error)) return
    model%state%points%stress(:, source) = soil%evaluation%results%stress
    call migrate_points(model, error)
  end subroutine take_elastic_stress
end module qsmpm_initial_correction
