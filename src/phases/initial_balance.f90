!> Check of whether the stresses of *INITIAL are in equilibrium with the loads of the phase.
!>
!>   r = f_load - f_held - sum V sigma grad N,   u = K^-1 r,   u_w = K^-1 f_load        (free components, elastic K)
!>
!> where f_held is the resistance of all other internal terms before any displacement, such as springs of a support that
!> an earlier phase has loaded.
!>
!> K0 stresses contain no shear stress: they are in equilibrium in level layers only. Under a slope, or below an
!> inclined interface, the first step would move the soil by the unbalanced force, and its stresses would be neither K0
!> stresses nor those of loaded soil. Such a model is rejected by two criteria: the horizontal gradient of the
!> horizontal stress relative to the weight (`measure_slope`), which does not depend on the mesh, and, for other sources
!> of imbalance, the displacement max|u| of the material points relative to max|u_w|, gamma H^2/2M on level ground. The
!> norm of r is printed but not assessed: it is as large where the rule of a cell does not integrate a linear stress
!> exactly, which causes only a small displacement. The actual displacement in the phase is printed in the log at its
!> end (qsmpm_phase_report).
!>
!> Where soil receives one water pressure with a free surface, suction above it and the water that partly fills its
!> pores act from the first step on. The resulting out-of-balance force at the start of the phase, at all free nodes,
!>
!>   r = sum V (sigma' + S chi p) grad N - f_load,
!>
!> is then applied and reduced to zero over the phase, like the reaction of a released fixity: a smaller step would not
!> reduce it.
module qsmpm_initial_balance
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: any_of, joint_norm, lowest_rank
  use qsmpm_equations, only: gather
  use qsmpm_error, only: error_type, error_not_converged, fail
  use qsmpm_phase_description, only: phase_type, initial_k0
  use qsmpm_initial_stress, only: reaches_above, measure_slope, structures_at_rest
  use qsmpm_initial_correction, only: correction_type, correct_stresses, elastic_moves, find_largest_move, largest_move
  use qsmpm_initial_strength, only: count_beyond_strength
  use qsmpm_initialisation, only: step_type, initialise_step, evaluate_step
  use qsmpm_law, only: tangent_elastic, tangent_none
  use qsmpm_model, only: model_type
  use qsmpm_observer, only: observer_type
  use qsmpm_soil_points, only: soil_type, soil_of, integration_of
  use qsmpm_stress_force, only: internal_force
  use qsmpm_team, only: team_type, largest, spread_from
  use qsmpm_term_sums, only: set_loads, discard_terms
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_phase_loads, only: free_surface_of
  use qsmpm_phase_tree, only: parent_of
  implicit none
  private

  public :: check_initial_balance, measure_balance, balance_type, hold_water_start

  !> Displacement relative to that under the own weight above which a warning is printed, and above which the model is
  !> rejected.
  real(wp), parameter :: warned_from = 1.0e-3_wp, refused = 1.0e-2_wp
  !> Horizontal change of the horizontal stress, relative to the weight, above which the model is rejected.
  real(wp), parameter :: steepest = 1.0e-3_wp
  !> Relative height up to which the level is that of the bodies.
  real(wp), parameter :: same_level = 1.0e-9_wp
  !> Ratio of loads to the forces of the stresses below which loads are rounding.
  real(wp), parameter :: no_load = 1.0e-9_wp
  !> Displacement up to which K0 stresses are not corrected.
  real(wp), parameter :: exact = 1.0e-6_wp

  !> Displacements below this share of a cell are rounding.
  real(wp), parameter :: rounding = 1.0e-14_wp
  character(len=*), parameter :: advice = 'Start from a phase with *GRAVITY alone, without *INITIAL, TYPE=K0, and '// &
    'begin the next one with *RESET DISPLACEMENTS'

  !> Deviation of stresses from equilibrium.
  type :: balance_type
    !> |r|/|f_load|.
    real(wp) :: residual = 0.0_wp
    !> max|u|/max|u_w|, and place of the largest u (dimension).
    real(wp) :: move = 0.0_wp
    real(wp), allocatable :: position(:)
    !> max|u_w|, 0 without a load [length].
    real(wp) :: settlement = 0.0_wp
  end type balance_type

contains

  !> Rejects initial stresses that are not in equilibrium and reports their balance.
  subroutine check_initial_balance(model, step, phase, observer, error)
    type(model_type), intent(inout) :: model
    !> Scratch data of the step, reused by the first step.
    type(step_type), intent(inout) :: step
    type(phase_type), intent(in) :: phase
    class(observer_type), intent(inout) :: observer
    !> error_not_converged if they are not in equilibrium; failures of the initialisation.
    type(error_type), allocatable, intent(out) :: error
    type(balance_type) :: balance
    type(correction_type) :: correction
    character(len=240) :: text
    character(len=:), allocatable :: names

    if (phase%initial%kind == initial_k0) then
      names = structures_at_rest(model)
      if (len(names) > 0) call observer%note('K0 stresses: bodies without a strength, taken as structures in the '// &
        'ground: '//names//'. They start with the stress and the weight of the adjacent ground; their own weight '// &
        "is applied over phase '"//phase%name//"'")
      call warn_of_material_above(model, phase, observer)
      call check_slope(model, phase, error)
    end if
    if (allocated(error)) return
    call initialise_step(model, step, error)
    if (allocated(error)) return
    call measure_balance(model, step, balance)
    call discard_terms(step%terms)
    if (phase%initial%kind == initial_k0) then
      if (is_left_alone(phase) .and. len(names) == 0) model%state%progress%own_settlement = balance%settlement
      call correct_balance(model, step, balance, observer, correction, error)
      if (allocated(error)) return
    end if
    if (.not. balance%move > refused) then
      call observer%note(kind_of(balance%move)//stresses_of(phase)//': '//balance_text(balance))
      return
    end if
    write (text, '(a,3(1x,es11.4))') ', most at', balance%position
    call fail(error, error_not_converged, "phase '"//phase%name//"': the "//stresses_of(phase)// &
      ' are not in equilibrium, '//balance_text(balance)//trim(text)//': '// &
      cause_of(correction, is_beyond_strength(model), size(model%analysis%rigid_bodies) > 0))
  end subroutine check_initial_balance

  !> Returns whether only gravity acts in a phase, so that displacements indicate errors of its initial stresses.
  pure logical function is_left_alone(phase)
    type(phase_type), intent(in) :: phase

    is_left_alone = size(phase%prescriptions) == 0 .and. size(phase%tractions) == 0 .and. size(phase%moves) == 0
  end function is_left_alone

  !> Corrects K0 stresses where they are not in equilibrium on the grid; the balance returned is the remaining one.
  subroutine correct_balance(model, step, balance, observer, correction, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    type(balance_type), intent(inout) :: balance
    class(observer_type), intent(inout) :: observer
    type(correction_type), intent(out) :: correction
    type(error_type), allocatable, intent(out) :: error

    call correct_stresses(model, step, merge(0.0_wp, exact, balance%move > exact), correction, error)
    if (allocated(error) .or. .not. correction%change > 0.0_wp) return
    call note_correction(balance, correction, observer)
    call initialise_step(model, step, error)
    if (allocated(error)) return
    call measure_balance(model, step, balance, correction%by_law)
    call discard_terms(step%terms)
  end subroutine correct_balance

  !> Reports the correction.
  subroutine note_correction(before, correction, observer)
    type(balance_type), intent(in) :: before
    type(correction_type), intent(in) :: correction
    class(observer_type), intent(inout) :: observer
    character(len=:), allocatable :: done
    character(len=12) :: change

    write (change, '(es7.1)') correction%change
    done = 'corrected for the cells of the grid, by '
    if (correction%evened_only) done = 'averaged in cells with a uniform pressure, by '
    call observer%note(kind_of(correction%before)//'K0 stresses: '//balance_text(before)//'; '//done//trim(change)// &
      ' of the largest stress at the most')
  end subroutine note_correction

  !> Returns the text that reports the balance.
  function balance_text(balance) result(text)
    type(balance_type), intent(in) :: balance
    character(len=:), allocatable :: text
    character(len=240) :: buffer

    write (buffer, '(a,es7.1,a,es7.1,a,es7.1)') 'out of balance by ', balance%residual, &
      ' of the loads, which moves the ground by ', balance%move, ' of its settlement under its own weight, ', &
      balance%settlement
    text = trim(buffer)
  end function balance_text

  !> Returns the prefix of the text by the size of a displacement.
  pure function kind_of(move) result(words)
    real(wp), intent(in) :: move
    character(len=:), allocatable :: words

    words = ''
    if (move > warned_from) words = 'warning: '
  end function kind_of

  !> Returns the cause of a large imbalance and the remedy. Where elastic soil would hardly move, the cause is soil with
  !> a low stiffness at low stress.
  pure function cause_of(correction, beyond_strength, beside_bodies) result(words)
    type(correction_type), intent(in) :: correction
    logical, intent(in) :: beyond_strength
    !> The model contains rigid bodies.
    logical, intent(in) :: beside_bodies
    character(len=:), allocatable :: words

    if (beyond_strength) then
      words = 'they exceed the strength of the soil (see the warning): in clay K0 cannot differ from 1 by more '// &
        'than 2 c over the vertical stress, in frictional soil it lies between the active and the passive ratio'
    else if (correction%before > 0.0_wp .and. correction%before <= refused) then
      words = 'the stiffness of a soil decreases with its stress to almost zero at the surface, and the cells '// &
        'there are too large for that. Use smaller cells, *METHOD, BASIS=GIMP, INTEGRATION=CELL, or let the '// &
        'grid end at the ground surface'
    else
      words = 'the ground or a layer is not horizontal, a side is not fixed, *INITIAL gives another level, a '// &
        'load of the phase is not included in them, or too few points integrate the cells (*METHOD, INTEGRATION=CELL). '
      if (beside_bodies) words = words//'Corners of rigid bodies are round (ROUND) and support nothing: extend '// &
        'a body beyond the ground beside it. '
      words = words//advice
    end if
  end function cause_of

  !> Returns whether on any process the laws reduce stresses of points before any displacement.
  logical function is_beyond_strength(model)
    type(model_type), intent(in) :: model

    is_beyond_strength = any_of(model%part%team, any(count_beyond_strength(model) > 0))
  end function is_beyond_strength

  !> Warns of material above the ground level.
  subroutine warn_of_material_above(model, phase, observer)
    type(model_type), intent(in) :: model
    type(phase_type), intent(in) :: phase
    class(observer_type), intent(inout) :: observer
    real(wp) :: above

    above = reaches_above(model, phase%initial)
    if (above > same_level*maxval(model%mesh%bounds(:, 2) - model%mesh%bounds(:, 1))) call observer%note( &
      'warning: material extends up to '//rounded_text(above)//' above the level of *INITIAL, TYPE=K0; its '// &
      'weight is included in the K0 stresses')
  end subroutine warn_of_material_above

  !> Returns the name of the stresses of a phase.
  pure function stresses_of(phase) result(words)
    type(phase_type), intent(in) :: phase
    character(len=:), allocatable :: words

    words = 'given stresses'
    if (phase%initial%kind == initial_k0) words = 'K0 stresses'
  end function stresses_of

  !> Rejects inclined ground, layers or water tables.
  subroutine check_slope(model, phase, error)
    type(model_type), intent(in) :: model
    type(phase_type), intent(in) :: phase
    type(error_type), allocatable, intent(out) :: error
    character(len=200) :: text
    real(wp) :: slope, place(model%mesh%dimension)
    integer :: worst

    call measure_slope(model, phase%initial, slope, worst)
    place = 0.0_wp
    if (worst > 0) place = model%state%points%position(:, worst)
    call take_largest(model%part%team, slope, place)
    if (.not. slope > steepest) return
    write (text, '(a,es8.1,a,3(1x,es11.4))') 'their horizontal part varies by ', slope, ' of the weight along the '// &
      'horizontal, most at', place
    call fail(error, error_not_converged, "phase '"//phase%name//"': the K0 stresses are not in equilibrium, "// &
      trim(text)//': the ground, a layer or the water level is not horizontal there, or a wall that has a '// &
      'strength, and so is treated as ground, is heavier than it. '//advice)
  end subroutine check_slope

  !> Computes the out-of-balance of the stresses of the material points with the loads at the start of the phase. Where
  !> the equations cannot be solved the displacement is not computed; the first step then reports the cause.
  subroutine measure_balance(model, step, balance, by_law)
    type(model_type), intent(in) :: model
    !> Scratch data of the step, initialised.
    type(step_type), intent(inout) :: step
    type(balance_type), intent(out) :: balance
    !> Use the forces of the laws, as in the first step; not when absent.
    logical, intent(in), optional :: by_law
    type(error_type), allocatable :: error
    real(wp), dimension(size(step%forces%internal, 1), size(step%forces%internal, 2)) :: move
    real(wp), dimension(model%mesh%dimension, model%space%node_count) :: load, resistance
    real(wp), dimension(step%equations%count) :: weight, residual, by_weight, by_residual
    real(wp) :: size_of_loads, size_of_points, largest_of_own
    integer :: worst

    move = 0.0_wp
    balance%position = model%mesh%bounds(:, 1)
    call set_loads(step%terms, model, step%configuration_type, model%state%progress%fraction)
    call evaluate_step(model, step, move, tangent_elastic)
    if (step%failure%failed) return
    load = step%forces%external(:size(load, 1), :size(load, 2))
    weight = 0.0_wp
    residual = 0.0_wp
    call gather(step%equations, load, weight)
    call force_before_law(model, step, resistance)
    if (present(by_law)) then
      if (by_law) resistance = step%forces%internal(:size(load, 1), :size(load, 2))
    end if
    call gather(step%equations, load - resistance, residual)
    size_of_loads = norm_of(step, weight)
    size_of_points = size_of_stresses(model, step)
    if (.not. size_of_loads > no_load*size_of_points) then
      ! Without a load only the stresses themselves serve as reference.
      balance%residual = norm_of(step, residual)/max(size_of_points, tiny(1.0_wp))
      balance%move = balance%residual
      return
    end if
    balance%residual = norm_of(step, residual)/size_of_loads
    call elastic_moves(step, weight, residual, by_weight, by_residual, error)
    if (allocated(error)) return
    balance%settlement = largest_move(step, by_weight)
    call find_largest_move(step, by_residual, largest_of_own, worst)
    if (worst > 0) balance%position = model%state%points%position(:, worst)
    call take_largest(step%team, largest_of_own, balance%position)
    ! Loads that are rounding cause no settlement and serve as no reference.
    if (max(largest_of_own, balance%settlement) > rounding*model%cell_size) &
      balance%move = largest_of_own/max(balance%settlement, tiny(1.0_wp))
  end subroutine measure_balance

  !> Returns the norm of forces at the equations of all processes.
  real(wp) function norm_of(step, force)
    type(step_type), intent(in) :: step
    !> (equations)
    real(wp), intent(in) :: force(:)

    norm_of = joint_norm(step%team, norm2(pack(force, step%field_of > 0)))
  end function norm_of

  !> Finds the largest value of all processes, and its place.
  subroutine take_largest(team, value, place)
    type(team_type), intent(in) :: team
    !> Value of this process; on return that of all.
    real(wp), intent(inout) :: value
    real(wp), contiguous, intent(inout) :: place(:)
    real(wp) :: extreme
    integer :: rank

    extreme = largest(team, value)
    rank = lowest_rank(team, value >= extreme)
    value = extreme
    if (rank < team%ranks) call spread_from(team, rank, place)
  end subroutine take_largest

  !> Returns the size of the nodal forces of the total stresses, including the all-round pressure.
  real(wp) function size_of_stresses(model, step) result(force_size)
    type(model_type), intent(in) :: model
    !> Scratch data of the step, initialised.
    type(step_type), intent(in), target :: step
    real(wp) :: force(model%mesh%dimension, model%space%node_count)
    type(soil_type), pointer :: soil

    soil => soil_of(step%terms)
    call internal_force(integration_of(soil, step%configuration_type), model%state%points, 0.0_wp, force)
    force_size = joint_norm(step%team, norm2(pack(force, spread(step%own(:size(force, 2)), 1, size(force, 1)))))
  end function size_of_stresses

  !> Computes the internal force at the start of the step. The force of the soil is that of the given stresses: an
  !> evaluation of the laws would reduce those beyond the strength, which are assessed separately.
  subroutine force_before_law(model, step, force)
    type(model_type), intent(in) :: model
    !> Scratch data of the step, evaluated at zero displacement.
    type(step_type), intent(in), target :: step
    !> (dimension, node_count)
    real(wp), intent(out) :: force(:, :)
    type(soil_type), pointer :: soil
    real(wp), dimension(size(force, 1), size(force, 2)) :: by_law, rest

    soil => soil_of(step%terms)
    by_law = 0.0_wp
    rest = 0.0_wp
    call soil%add_force(rest, by_law)
    call internal_force(integration_of(soil, step%configuration_type), model%state%points, &
      model%analysis%confinement, force)
    force = force + (step%forces%internal(:size(force, 1), :size(force, 2)) - by_law)
  end subroutine force_before_law

  !> Applies the out-of-balance force where the free surface begins to move.
  subroutine hold_water_start(model, step, error)
    type(model_type), intent(inout) :: model
    !> Scratch data.
    type(step_type), intent(inout) :: step
    !> Failures of the initialisation.
    type(error_type), allocatable, intent(out) :: error

    if (.not. begins(model)) return
    call initialise_step(model, step, error)
    if (allocated(error)) return
    call set_loads(step%terms, model, step%configuration_type, 0.0_wp)
    call evaluate_step(model, step, 0.0_wp*step%forces%internal, tangent_none)
    associate (released => model%state%released)
      associate (internal => step%forces%internal(:size(released, 1), :size(released, 2)), &
          external => step%forces%external(:size(released, 1), :size(released, 2)))
        where (.not. model%loading%constrained .and. spread(step%equations%active(:size(released, 2)), 1, &
          size(released, 1))) released = released + internal - external
      end associate
    end associate
    call discard_terms(step%terms)
  end subroutine hold_water_start

  !> Returns whether the phase is the first one in its branch with a free surface in consolidating soil.
  pure logical function begins(model)
    type(model_type), intent(in) :: model
    integer :: parent

    associate (phases => model%analysis%phases, number => model%state%progress%phase)
      begins = free_surface_of(phases, number) > 0
      if (.not. begins) return
      parent = parent_of(phases, number)
      if (parent > 0) begins = free_surface_of(phases, parent) == 0
    end associate
  end function begins
end module qsmpm_initial_balance
