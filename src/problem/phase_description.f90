!> A phase of an analysis as a deck describes it: how it starts, its loads, rules of its steps, what ends it.
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

  !> Newton variants: the paper's frozen [K^E + K^G]^0, or the consistent tangent.
  integer, parameter, public :: newton_modified = 1, newton_full = 2
  !> What a phase does: loads change, or the strength is lowered until it is lost.
  integer, parameter, public :: phase_loading = 1, phase_safety = 2
  !> Places, volumes and deformation in the search for a factor of safety: they stay, or follow.
  integer, parameter, public :: geometry_fixed = 1, geometry_moving = 2
  !> How a phase starts its stresses.
  integer, parameter, public :: initial_keep = 0, initial_k0 = 1, initial_isotropic = 2, initial_given = 3
  !> Whether a phase stops where a history rises to a value or falls to it.
  integer, parameter, public :: stop_above = 1, stop_below = 2
  !> What has ended a phase: nothing yet, its whole load, its limit load, a stop, the loss of its equilibrium.
  integer, parameter, public :: not_ended = 0, ended_by_load = 1, ended_by_limit = 2, ended_by_stop = 3, &
    ended_by_loss = 4

  !> Step control and stopping rules of a phase.
  type :: controls_type
    type(source_line_type) :: where
    !> Load steps the phase is first cut into, and the share of the phase that the first one is where they grow from it
    !> (FIRST TIME over TIME); 0: all are even.
    integer :: steps = 10
    real(wp) :: first_share = 0.0_wp
    !> Pore water flows in time: without FIRST TIME steps begin short and grow up to those of `steps`, as the pressures
    !> allow.
    logical :: by_water = .false.
    integer :: newton = newton_full
    !> Relative out-of-balance (eq. 27).
    real(wp) :: tolerance = 1.0e-4_wp
    integer :: max_iterations = 20
    logical :: line_search = .true.
    !> Iterations begin where the step before leads.
    logical :: extrapolation = .true.
    !> Smallest step as a share of the first one before the phase stops.
    real(wp) :: smallest_step = 1.0e-3_wp
    !> Iterations up to which a cut step grows again, and above which the next one shrinks.
    integer :: few_iterations = 8
    integer :: many_iterations = 16
    !> Error that the length of a step may cause, as a share of stresses and displacements; 0 leaves the
    !> steps as they are cut.
    real(wp) :: step_error = 0.0_wp
    !> Largest step as a load fraction.
    real(wp) :: largest_step = 1.0_wp
    !> Largest nodal displacement of a step in cell sizes; a larger one is rejected.
    real(wp) :: largest_move = 0.5_wp
    !> Share of the load that stabilisation may carry; a step is re-equilibrated until it is below.
    real(wp) :: stabilisation_share = 5.0e-3_wp
    integer :: max_reequilibrations = 30
    !> Factor on the stabilisation from one re-equilibration to the next; 1 keeps it.
    real(wp) :: stabilisation_fade = 1.0_wp
    !> The phase ends where a step is so many times as compliant as its first one; 0 for no such end.
    real(wp) :: limit_compliance = 0.0_wp
    !> Proximal sub-steps where the static step is rejected, and the share of damping below which it is tried again.
    logical :: damping = .true.
    real(wp) :: damping_share = 1.0e-3_wp
    integer :: max_substeps = 400
    !> Stresses and states alone are updated: no card says so, the search for a factor of safety does.
    logical :: in_place = .false.
  end type controls_type

  !> Re-solve at held load and report how far the first history creeps; the state is restored.
  type :: constant_load_test_type
    integer :: repeats = 10
    !> Load factors of the phase at which to test.
    real(wp), allocatable :: at(:)
  end type constant_load_test_type

  !> How the stresses of a phase start.
  type :: initial_stress_type
    integer :: kind = initial_keep
    type(source_line_type) :: where
    !> K0 start: level of the horizontal surface and ratio of horizontal to vertical stress.
    real(wp) :: surface_level = 0.0_wp
    real(wp) :: k0 = 1.0_wp
    !> Height and pressure, compression positive, (2,n); height and stress 11, 22, 33, 12, 13, 23, (7,n).
    real(wp), allocatable :: pressures(:, :), stresses(:, :)
    !> File of stresses: path relative to the working directory, places (dimension,n) and stresses (6,n).
    character(len=:), allocatable :: file
    real(wp), allocatable :: places(:, :), at_places(:, :)
    !> Results of another run: step, 0 for the last one; its own file, unallocated for other files; whether state
    !> variables are taken, too.
    integer :: step = 0
    character(len=:), allocatable :: part
    logical :: takes_state = .false.
    !> Names of these and values at the places (names,n), and number of the material there (n).
    type(string_type), allocatable :: state_names(:)
    real(wp), allocatable :: state_at_places(:, :)
    integer, allocatable :: material_at_places(:)
  end type initial_stress_type

  !> How a phase lowers the strength.
  type :: safety_type
    logical :: given = .false.
    type(source_line_type) :: where
    !> Largest distance of the factors that are stable and lost.
    real(wp) :: tolerance = 5.0e-3_wp
    !> One of flow_* (qsmpm_strength_factor) and of geometry_*.
    integer :: flow = flow_material
    integer :: geometry = geometry_fixed
    !> Factor of the run-out that follows the search; huge for none.
    real(wp) :: runout = huge(1.0_wp)
  end type safety_type

  !> A history value at which a phase ends.
  type :: stop_type
    character(len=:), allocatable :: history
    type(source_line_type) :: where
    !> stop_above or stop_below.
    integer :: side = stop_above
    !> Scaled as in curves.csv.
    real(wp) :: value = 0.0_wp
  end type stop_type

  !> One phase: what changes, and how it is stepped.
  type, extends(named_type) :: phase_type
    !> Phase that it starts from the end of; empty or unallocated: the one before.
    character(len=:), allocatable :: parent
    type(source_line_type) :: where
    !> phase_loading or phase_safety.
    integer :: kind = phase_loading
    type(safety_type) :: safety
    !> Load factor at the end of the phase; loads of the phase are given per unit of it.
    real(wp) :: load_factor = 1.0_wp
    !> How long it lasts, for models that depend on time, and when it starts where it does not start at the end of the
    !> one before.
    real(wp) :: duration = 1.0_wp
    real(wp) :: start_time = 0.0_wp
    !> Of the first step; 0: steps are even.
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
    !> Where it ends before its whole load, and by how much a value may be passed, relative to it.
    type(stop_type), allocatable :: stops(:)
    real(wp) :: stop_tolerance = 1.0e-2_wp
    !> Displacements count from its start; softened material has its first strength again.
    logical :: reset_displacements = .false., reset_strains = .false.
    !> Strength that follows the stress is updated at its start.
    logical :: updates_strength = .false.
    type(source_line_type) :: strength_where
    type(drain_state_type) :: drain_state
  end type phase_type
end module qsmpm_phase_description
