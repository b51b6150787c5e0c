!> A phase of an analysis as defined in a deck: initial stresses, loads, step control, stop conditions.
module qsmpm_phase_description
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: named_type
  use qsmpm_body_description, only: body_change_type, drain_state_type
  use qsmpm_load_description, only: fixity_type, prescription_type, traction_type, support_type, gravity_type, &
    water_level_type, consolidation_type
  use qsmpm_source_line, only: source_line_type
  use qsmpm_strength_factor, only: flow_material
  use qsmpm_structures, only: prop_change_type, rigid_move_type
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: controls_type, constant_load_test_type, initial_stress_type, safety_type, stop_type, phase_type

  !> Newton variants: the constant matrix [K^E + K^G]^0 of the paper, or the consistent tangent.
  integer, parameter, public :: newton_modified = 1, newton_full = 2
  !> Kinds of phase: change of loads, or strength reduction to failure.
  integer, parameter, public :: phase_loading = 1, phase_safety = 2
  !> Positions, volumes and deformation in the search for a factor of safety: fixed or updated.
  integer, parameter, public :: geometry_fixed = 1, geometry_moving = 2
  !> Initial stresses of a phase.
  integer, parameter, public :: initial_keep = 0, initial_k0 = 1, initial_isotropic = 2, initial_given = 3
  !> Whether a phase stops when a history exceeds a value or falls below it.
  integer, parameter, public :: stop_above = 1, stop_below = 2
  !> End of a phase: not ended, full load, limit load, stop condition, no equilibrium.
  integer, parameter, public :: not_ended = 0, ended_by_load = 1, ended_by_limit = 2, ended_by_stop = 3, &
    ended_by_loss = 4

  !> Step control and stop conditions of a phase.
  type :: controls_type
    type(source_line_type) :: where
    !> Initial number of load steps; load fraction of the first step if steps grow from it (FIRST TIME over TIME), 0
    !> for equal steps.
    integer :: steps = 10
    real(wp) :: first_share = 0.0_wp
    !> Whether pore water flow controls the step length: without FIRST TIME steps begin short and grow up to those of
    !> `steps`, as the pressures allow.
    logical :: by_water = .false.
    integer :: newton = newton_full
    !> Relative residual (eq. 27).
    real(wp) :: tolerance = 1.0e-4_wp
    integer :: max_iterations = 20
    logical :: line_search = .true.
    !> Whether iterations start from the extrapolation of the previous step.
    logical :: extrapolation = .true.
    !> Smallest step, as a fraction of the first one, below which the phase stops.
    real(wp) :: smallest_step = 1.0e-3_wp
    !> Number of iterations up to which a reduced step grows again, and above which the next one is reduced.
    integer :: few_iterations = 8
    integer :: many_iterations = 16
    !> Allowed error due to the step length, as a fraction of stresses and displacements; 0: the step length is not
    !> adapted.
    real(wp) :: step_error = 0.0_wp
    !> Largest step as a load fraction.
    real(wp) :: largest_step = 1.0_wp
    !> Largest nodal displacement of a step in cell sizes; a step that exceeds it is rejected.
    real(wp) :: largest_move = 0.5_wp
    !> Allowed share of the load that stabilisation supports; a step is re-equilibrated until it is smaller.
    real(wp) :: stabilisation_share = 5.0e-3_wp
    integer :: max_reequilibrations = 30
    !> Factor of the stabilisation from one re-equilibration to the next; 1 for no change.
    real(wp) :: stabilisation_fade = 1.0_wp
    !> Ratio of the compliance of a step to that of the first one at which the phase ends; 0 for no such condition.
    real(wp) :: limit_compliance = 0.0_wp
    !> Whether proximal sub-steps are used where the static step is rejected; share of damping below which the static
    !> step is tried again.
    logical :: damping = .true.
    real(wp) :: damping_share = 1.0e-3_wp
    integer :: max_substeps = 400
    !> Whether only stresses and state variables are updated; set by the search for a factor of safety, not by a
    !> keyword.
    logical :: in_place = .false.
  end type controls_type

  !> Constant-load test: solves again at constant load and reports the change of the first history; the state is
  !> restored.
  type :: constant_load_test_type
    integer :: repeats = 10
    !> Load factors of the phase at which tests are made.
    real(wp), allocatable :: at(:)
  end type constant_load_test_type

  !> Initial stresses of a phase.
  type :: initial_stress_type
    integer :: kind = initial_keep
    type(source_line_type) :: where
    !> K0 stresses: level of the horizontal surface; ratio of horizontal to vertical stress.
    real(wp) :: surface_level = 0.0_wp
    real(wp) :: k0 = 1.0_wp
    !> Height and pressure, compression positive, (2,n); height and stress 11, 22, 33, 12, 13, 23, (7,n).
    real(wp), allocatable :: pressures(:, :), stresses(:, :)
    !> File of stresses: path relative to the working directory; locations (dimension,n) and stresses (6,n).
    character(len=:), allocatable :: file
    real(wp), allocatable :: places(:, :), at_places(:, :)
    !> Results of another run: number of the step, 0 for the last one; result file of that step, unallocated for other
    !> files; whether state variables are also used.
    integer :: step = 0
    character(len=:), allocatable :: part
    logical :: takes_state = .false.
    !> Names and values of the state variables (names,n) and material numbers (n) at the locations.
    type(string_type), allocatable :: state_names(:)
    real(wp), allocatable :: state_at_places(:, :)
    integer, allocatable :: material_at_places(:)
  end type initial_stress_type

  !> Strength reduction of a phase.
  type :: safety_type
    logical :: given = .false.
    type(source_line_type) :: where
    !> Largest difference between the stable and the failed factor.
    real(wp) :: tolerance = 5.0e-3_wp
    !> One of flow_* (qsmpm_strength_factor); one of geometry_*.
    integer :: flow = flow_material
    integer :: geometry = geometry_fixed
    !> Factor of the run-out analysis that follows the search; huge for none.
    real(wp) :: runout = huge(1.0_wp)
  end type safety_type

  !> Value of a history at which a phase ends.
  type :: stop_type
    character(len=:), allocatable :: history
    type(source_line_type) :: where
    !> stop_above or stop_below.
    integer :: side = stop_above
    !> Scaled as in curves.csv.
    real(wp) :: value = 0.0_wp
  end type stop_type

  !> A phase: its changes and its step control.
  type, extends(named_type) :: phase_type
    !> Parent phase, from whose end it starts; empty or unallocated: the previous phase.
    character(len=:), allocatable :: parent
    type(source_line_type) :: where
    !> phase_loading or phase_safety.
    integer :: kind = phase_loading
    type(safety_type) :: safety
    !> Load factor at the end of the phase; loads of the phase are given per unit of it.
    real(wp) :: load_factor = 1.0_wp
    !> Duration, for time-dependent models; start time, if it differs from the end time of the parent.
    real(wp) :: duration = 1.0_wp
    real(wp) :: start_time = 0.0_wp
    !> Duration of the first step; 0: equal steps.
    real(wp) :: first_time = 0.0_wp
    logical :: start_given = .false., duration_given = .false.
    type(initial_stress_type) :: initial
    type(fixity_type), allocatable :: fixities(:)
    type(prescription_type), allocatable :: prescriptions(:)
    type(gravity_type) :: gravity
    type(traction_type), allocatable :: tractions(:)
    type(support_type), allocatable :: supports(:)
    type(rigid_move_type), allocatable :: moves(:)
    type(body_change_type), allocatable :: activations(:), deactivations(:), materials(:)
    type(prop_change_type), allocatable :: installed(:), removed(:)
    type(water_level_type), allocatable :: water_levels(:)
    type(consolidation_type) :: consolidation
    type(controls_type) :: controls
    type(constant_load_test_type) :: constant_load_test
    !> Stop conditions before the full load; relative tolerance by which a value may be exceeded.
    type(stop_type), allocatable :: stops(:)
    real(wp) :: stop_tolerance = 1.0e-2_wp
    !> Whether displacements are reset to zero at its start; whether the initial strength of softened material is
    !> restored.
    logical :: reset_displacements = .false., reset_strains = .false.
    !> Whether a strength that depends on the stress is updated at its start.
    logical :: updates_strength = .false.
    type(source_line_type) :: strength_where
    type(drain_state_type) :: drain_state
  end type phase_type
end module qsmpm_phase_description
