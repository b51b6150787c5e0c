!> The model: all data that exist between two steps and cannot be derived from others.
!>
!> `state_type` contains what a step changes and what is restored as a whole after a rejected step, a constant-load
!> test or a restart; the other data are constant after the model is built.
!>
!> Where time is not critical, a copy of a model is declared `class(model_type), allocatable`: gfortran copies and
!> deallocates it by one call, while it generates inline code of a page per procedure for other declarations.
module qsmpm_model
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_phase_description, only: not_ended
  use qsmpm_mesh, only: mesh_type
  use qsmpm_own_part, only: own_part_type
  use qsmpm_grid_window, only: window_type
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_carried_outline, only: carried_outline_type
  use qsmpm_space, only: space_type
  use qsmpm_limit_load, only: limit_load_type
  use qsmpm_kept_arrays, only: kept_arrays_type
  use qsmpm_law, only: law_slot_type
  use qsmpm_inactive_points, only: inactive_points_type, lift_feet_type
  use qsmpm_rigid_outline, only: rigid_outline_type
  use qsmpm_rigid_pose, only: placed_shape_type
  use qsmpm_safety_bracket, only: bracket_type
  use qsmpm_strength_factor, only: strength_factor_type
  use qsmpm_surface_pressure, only: surface_pressure_type
  use qsmpm_water_table, only: water_table_type
  use qsmpm_points, only: points_type, surface_points_type, carried_type, watched_points_type
  implicit none
  private

  public :: model_type, state_type, rest_of_state_type, kept_phase_type, loading_type, progress_type, phase_end_type, &
    contact_pair_type, carried_set_type, carried_sets

  !> End of a phase.
  type :: phase_end_type
    !> One of the ended_* values of qsmpm_analysis.
    integer :: reason = not_ended
    !> Load fraction reached.
    real(wp) :: fraction = 0.0_wp
    !> Largest displacement of a material point since the reset of displacements [length].
    real(wp) :: displacement = 0.0_wp
  end type phase_end_type

  !> Progress of the analysis.
  type :: progress_type
    !> Current phase, 1 for the first; accepted steps in all phases.
    integer :: phase = 1
    integer :: step = 0
    !> Accepted steps in this phase.
    integer :: phase_steps = 0
    !> Completed load fraction, 0 to 1; load factor of the phase.
    real(wp) :: fraction = 0.0_wp
    real(wp) :: load_factor = 0.0_wp
    !> Next step as a load fraction, 0 = not determined yet.
    real(wp) :: next_step = 0.0_wp
    !> Stored coefficient of the proximal term, 0 = not determined yet.
    real(wp) :: damping = 0.0_wp
    !> Linear solvers that have failed and are not tried again (failures of linear_system).
    integer :: failed_solvers = 0
    !> Whether the last equilibrium was found without the line search, which had failed.
    logical :: undamped_newton = .false.
    !> Work of external loads and of stresses so far.
    real(wp) :: external_work = 0.0_wp
    real(wp) :: internal_work = 0.0_wp
    !> Number of constant-load tests already made in this phase.
    integer :: constant_load_tests_done = 0
    !> Fraction of the released forces that remains at the end of a phase that ended early.
    real(wp) :: release_left = 0.0_wp
    !> Elastic settlement of the soil under the loads of a first phase with K0 stresses, gamma H^2/(2M) for level
    !> ground [length]; 0 for none.
    real(wp) :: own_settlement = 0.0_wp
    !> Norm of the forces acting at the start of the phase: forces on rigid bodies and reactions at prescribed
    !> components.
    real(wp) :: force_at_start = 0.0_wp
    !> Compliance and limit load of the phase.
    type(limit_load_type) :: limit
    !> Strength reduction factor F in force; search for the factor of safety of this phase.
    real(wp) :: strength_factor = 1.0_wp
    type(bracket_type) :: bracket
    !> Phase number, stable and failed factor (0 for none) of each completed safety phase (3, found).
    real(wp), allocatable :: factors(:, :)
    !> Whether a history of the phase has reached its stop value.
    logical :: stopped = .false.
    !> End of each phase (phases).
    type(phase_end_type), allocatable :: ends(:)
  end type progress_type

  !> Data changed by a step, other than the material points.
  type :: rest_of_state_type
    type(surface_points_type) :: surface
    type(carried_type) :: tracers
    type(watched_points_type) :: watched
    !> Inactive bodies.
    type(inactive_points_type) :: inactive
    !> Node coordinates; change only for FEM and moving meshes (dimension, node_count).
    real(wp), allocatable :: coordinates(:, :)
    !> Part of the grid covered by the mesh; nodes and cells below are numbered in it. Unused for other meshes.
    type(window_type) :: window
    !> Coordinate of the plate row of a moving mesh.
    real(wp) :: plate = 0.0_wp
    !> Reactions at constrained components after the last step (dimension, nodes of the space).
    real(wp), allocatable :: reactions(:, :)
    !> Reactions of components released in this phase; they decrease to zero over it (dimension, nodes of the space).
    real(wp), allocatable :: released(:, :)
    !> Arrays of terms of the equations stored from step to step.
    type(kept_arrays_type) :: kept
    type(progress_type) :: progress
  end type rest_of_state_type

  !> All data changed by a step.
  type, extends(rest_of_state_type) :: state_type
    type(points_type) :: points
  end type state_type

  !> A set of points located in the mesh, and the noun for one of its points.
  type :: carried_set_type
    class(carried_type), pointer :: places => null()
    character(len=37) :: noun
  end type carried_set_type

  !> State at the end of a phase, stored for phases that start from it.
  type :: kept_phase_type
    !> Number of the phase.
    integer :: phase = 0
    type(state_type) :: state
    !> Part of the model to which the state belongs.
    type(own_part_type) :: part
  end type kept_phase_type

  !> Loads and constraints of a phase, evaluated on the mesh. Every load varies linearly from `start` to `final` over
  !> the phase.
  type :: loading_type
    !> Constrained components (dimension, node_count).
    logical, allocatable :: constrained(:, :)
    !> Displacement prescribed over the whole phase (dimension, node_count).
    real(wp), allocatable :: prescribed(:, :)
    real(wp) :: gravity_start(3) = 0.0_wp, gravity_final(3) = 0.0_wp
    !> Traction vector of each surface (3, surfaces); its carrier, the surface or material points.
    real(wp), allocatable :: traction_start(:, :), traction_final(:, :)
    integer, allocatable :: carrier(:)
    !> Fixed components of the mesh nodes (dimension, node_count); cells with a face on the boundary of the mesh that
    !> is not fixed along its normal (cell_count).
    logical, allocatable :: held(:, :), open_edge(:)
    !> Pressure and kind of support of each surface (surfaces).
    type(surface_pressure_type), allocatable :: pressure_start(:), pressure_final(:)
    integer, allocatable :: support(:)
    !> Fraction of the distance to the centre by which supports have moved at the start and at the end of the phase;
    !> whether the support as a whole is free to move vertically (surfaces).
    real(wp), allocatable :: closure_start(:), closure_final(:)
    logical, allocatable :: floats(:)
    !> Water level of each body (bodies); unallocated before the first phase.
    type(water_table_type), allocatable :: water_start(:), water_final(:)
    !> Forces applied by an embedding program to the material points, not scaled by the load factor (dimension,
    !> points); unallocated without. They are set before each step.
    real(wp), allocatable :: point_force(:, :)
  end type loading_type

  !> A contact pair: a surface, or any soil, and a rigid body, with the strength of the interface.
  type :: contact_pair_type
    !> Number of the rigid body and of the surface; 0 where contact is defined at the outline of the body.
    integer :: body = 0, surface = 0
    !> Tangent of the friction angle; strength at zero pressure.
    real(wp) :: friction = 0.0_wp, adhesion = 0.0_wp
    !> Whether the surfaces cannot separate.
    logical :: tension = .false.
    !> Fraction of the soil strength that replaces both; penalty of the gap times cell size over Young's modulus;
    !> negative where not given.
    real(wp) :: interface = -1.0_wp, penalty = -1.0_wp
    !> Whether the contact condition is imposed at every point.
    logical :: pointwise = .false.
  end type contact_pair_type

  !> A model that can be stepped.
  type :: model_type
    type(analysis_type) :: analysis
    !> Part of the model owned by this process: all of it, unless a team shares the model.
    type(own_part_type) :: part
    !> Topology and sets; the current coordinates are those of the state.
    type(mesh_type) :: mesh
    !> Space of the displacement; "nodes" below are nodes of this space.
    type(space_type) :: space
    type(law_slot_type), allocatable :: laws(:)
    !> Strength factor of the laws; equal to that of the state, unless the state was just restored
    !> (qsmpm_lowered_laws).
    type(strength_factor_type) :: strength
    !> Initial boundaries of the bodies (bodies); those of element sets number the cells of the first window.
    type(body_shape_type), allocatable :: shapes(:)
    !> Outlines that move with the material; their vertices are tracers after those of the histories.
    type(carried_outline_type), allocatable :: outlines(:)
    !> Initial shapes of the rigid bodies (rigid bodies); contact pairs (contacts).
    type(placed_shape_type), allocatable :: rigid_shapes(:)
    type(contact_pair_type), allocatable :: contact_pairs(:)
    !> Outline of the body of each pair without a surface, otherwise none (contact pairs).
    type(rigid_outline_type), allocatable :: body_outlines(:)
    type(state_type) :: state
    type(loading_type) :: loading
    !> Ends of phases from which later phases start (qsmpm_phase_ends); unallocated for none.
    type(kept_phase_type), allocatable :: kept_phases(:)
    !> Number of times that the mesh has been regenerated around the material.
    integer :: windows_built = 0
    !> Characteristic cell size: the smallest of the initially active cells.
    real(wp) :: cell_size = 0.0_wp
    !> Tractions carried by material points: the points, their surfaces and areas.
    integer, allocatable :: carrying_point(:), carrying_surface(:)
    real(wp), allocatable :: carrying_area(:)
    !> Centre of the cavity bounded by each contracting surface (qsmpm_cavities) (2, surfaces).
    real(wp), allocatable :: cavity_middle(:, :)
    !> Tracer (0 for none) and nearest material point (0 for none) of each history.
    integer, allocatable :: history_tracer(:), history_point(:)
    !> Tracers of the ends of each prop, 0 for a fixed end (ends, props).
    integer, allocatable :: prop_tracer(:, :)
    !> State variable of each history (0 for none); number of its point among those of all bodies.
    integer, allocatable :: history_state(:), history_number(:)
    !> Body that each tracer follows (0: any active body); foot of the tracer (0 for none) (tracers).
    integer, allocatable :: tracer_body(:), tracer_foot(:)
    !> Initial node coordinates of a mesh that moves with the material (dimension, node_count).
    real(wp), allocatable :: drawn_coordinates(:, :)
    !> Feet of activated bodies and the points above them.
    type(lift_feet_type) :: feet
    !> Messages of the builder for the log (selected points, sets found, ...).
    character(len=:), allocatable :: notes
  end type model_type

contains

  !> Returns all sets of points located in the mesh.
  function carried_sets(state) result(sets)
    type(state_type), intent(in), target :: state
    type(carried_set_type) :: sets(9)

    sets(1)%places => state%points
    sets(2)%places => state%surface
    sets(3)%places => state%tracers
    sets(4)%places => state%watched
    sets(5)%places => state%inactive%points
    sets(6)%places => state%inactive%unloading
    sets(7)%places => state%inactive%surface
    sets(8)%places => state%inactive%unloading_surface
    sets(9)%places => state%inactive%feet
    sets%noun = [character(len=37) :: 'material point', 'surface point', 'tracer', 'watched place', &
      'material point that is not there', 'material point that is taken out', 'surface point that is not there', &
      'surface point that is taken out', 'place under a body that comes']
  end function carried_sets
end module qsmpm_model
