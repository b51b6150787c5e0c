!> The model: everything that exists between two steps, and nothing that can be derived from it.
!>
!> `state_type` is what a step changes and what a rejected step, a constant-load test or a restart puts back
!> as a whole; the rest is fixed after the model is built.
!>
!> Where no time goes, a copy of a model is `class(model_type), allocatable`: gfortran copies and frees that by one
!> call, and writes a page of code for another one into every procedure.
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

  !> How a phase has ended.
  type :: phase_end_type
    !> One of the ended_* values of qsmpm_analysis.
    integer :: reason = not_ended
    !> Load fraction reached.
    real(wp) :: fraction = 0.0_wp
    !> Largest displacement of a material point, as displacements count [length].
    real(wp) :: displacement = 0.0_wp
  end type phase_end_type

  !> Where the analysis stands.
  type :: progress_type
    !> Current phase, 1 for the first; accepted steps in all phases.
    integer :: phase = 1
    integer :: step = 0
    !> Accepted steps in this phase.
    integer :: phase_steps = 0
    !> Load fraction done, 0 to 1, and load factor of the phase.
    real(wp) :: fraction = 0.0_wp
    real(wp) :: load_factor = 0.0_wp
    !> Next step as a load fraction, 0 = not chosen yet.
    real(wp) :: next_step = 0.0_wp
    !> Remembered coefficient of the proximal term, 0 = not chosen yet.
    real(wp) :: damping = 0.0_wp
    !> Solvers of equations that have failed and are not tried again (failures of linear_system).
    integer :: failed_solvers = 0
    !> The last equilibrium was found without a line search, which had failed.
    logical :: undamped_newton = .false.
    !> Work of external loads and of stresses so far.
    real(wp) :: external_work = 0.0_wp
    real(wp) :: internal_work = 0.0_wp
    !> Constant-load tests of this phase already done.
    integer :: constant_load_tests_done = 0
    !> Share of the released forces that a phase ended early has left at its end.
    real(wp) :: release_left = 0.0_wp
    !> Elastic settlement of the ground under the loads of a first phase that begins with K0 stresses, gamma H^2/(2M) of
    !> level ground [length]; 0 for none.
    real(wp) :: own_settlement = 0.0_wp
    !> Norm of what the phase moves when it begins: forces on rigid bodies, and reactions at components that it moves.
    real(wp) :: force_at_start = 0.0_wp
    !> Compliance of the phase and its limit load.
    type(limit_load_type) :: limit
    !> F by which the strengths are divided at present, and the search for the factor of safety of this phase.
    real(wp) :: strength_factor = 1.0_wp
    type(bracket_type) :: bracket
    !> Number, stable and lost factor (0 for none) of each safety phase that has found them (3, found).
    real(wp), allocatable :: factors(:, :)
    !> A history of the phase has reached its value.
    logical :: stopped = .false.
    !> How each phase has ended (phases).
    type(phase_end_type), allocatable :: ends(:)
  end type progress_type

  !> What a step changes beside the material points.
  type :: rest_of_state_type
    type(surface_points_type) :: surface
    type(carried_type) :: tracers
    type(watched_points_type) :: watched
    !> Bodies that are not there.
    type(inactive_points_type) :: inactive
    !> Node coordinates: change only for FEM and moving meshes (dimension, node_count).
    real(wp), allocatable :: coordinates(:, :)
    !> Part of the grid that the mesh is; nodes and cells below are numbered in it. Unused for other meshes.
    type(window_type) :: window
    !> Coordinate of the plate row of a moving mesh.
    real(wp) :: plate = 0.0_wp
    !> Reactions at constrained components after the last step (dimension, nodes of the space).
    real(wp), allocatable :: reactions(:, :)
    !> Reactions of components that this phase has set free; they fall to zero over it (dimension, nodes of the space).
    real(wp), allocatable :: released(:, :)
    !> What terms of the equations keep from step to step.
    type(kept_arrays_type) :: kept
    type(progress_type) :: progress
  end type rest_of_state_type

  !> What a step changes.
  type, extends(rest_of_state_type) :: state_type
    type(points_type) :: points
  end type state_type

  !> A set that rides on the mesh, and what one of its places is.
  type :: carried_set_type
    class(carried_type), pointer :: places => null()
    character(len=37) :: noun
  end type carried_set_type

  !> State at the end of a phase, kept for later ones that start from there.
  type :: kept_phase_type
    !> Number of the phase.
    integer :: phase = 0
    type(state_type) :: state
    !> The part of the model that the state is of.
    type(own_part_type) :: part
  end type kept_phase_type

  !> Loads and constraints of a phase, resolved on the mesh. Every load runs linearly from `start`
  !> to `final` over the phase.
  type :: loading_type
    !> Constrained components (dimension, node_count).
    logical, allocatable :: constrained(:, :)
    !> Displacement prescribed over the whole phase (dimension, node_count).
    real(wp), allocatable :: prescribed(:, :)
    real(wp) :: gravity_start(3) = 0.0_wp, gravity_final(3) = 0.0_wp
    !> Traction vector of each surface (3, surfaces), and who carries it.
    real(wp), allocatable :: traction_start(:, :), traction_final(:, :)
    integer, allocatable :: carrier(:)
    !> Held components of the mesh nodes, and cells with a face on the outside of the mesh that is not held
    !> along its normal (dimension, node_count), (cell_count).
    logical, allocatable :: held(:, :), open_edge(:)
    !> Pressure and kind of support of each surface (surfaces).
    type(surface_pressure_type), allocatable :: pressure_start(:), pressure_final(:)
    integer, allocatable :: support(:)
    !> Share of the distance from the middle by which supports have moved there at the start and at the end of the
    !> phase, and whether as a whole they are free along the vertical (surfaces).
    real(wp), allocatable :: closure_start(:), closure_final(:)
    logical, allocatable :: floats(:)
    !> Water level of each body (bodies); unallocated before the first phase.
    type(water_table_type), allocatable :: water_start(:), water_final(:)
    !> Forces an embedding program puts on the material points, as they stand (dimension, points);
    !> unallocated without. Set them before each step.
    real(wp), allocatable :: point_force(:, :)
  end type loading_type

  !> A surface, or any soil, that may touch a rigid body, and the strength of the interface.
  type :: contact_pair_type
    !> Number of the rigid body and of the surface; 0 where contact is asked for at the body's own outline.
    integer :: body = 0, surface = 0
    !> Tangent of the angle of friction, and strength without pressure.
    real(wp) :: friction = 0.0_wp, adhesion = 0.0_wp
    !> They do not part.
    logical :: tension = .false.
    !> Share of the strength of the soil that stands for both, and penalty of the gap times the size of a cell over
    !> Young's modulus; negative where not given.
    real(wp) :: interface = -1.0_wp, penalty = -1.0_wp
    !> A condition at every point.
    logical :: pointwise = .false.
  end type contact_pair_type

  !> A model that can be advanced.
  type :: model_type
    type(analysis_type) :: analysis
    !> What this process answers for: all of it, unless a team shares the model.
    type(own_part_type) :: part
    !> Topology and sets; the coordinates in use are those of the state.
    type(mesh_type) :: mesh
    !> What carries the displacement: "nodes" below are nodes of this space.
    type(space_type) :: space
    type(law_slot_type), allocatable :: laws(:)
    !> What the laws are made with; that of the state, unless the state was just put back (qsmpm_lowered_laws).
    type(strength_factor_type) :: strength
    !> Bounds of the bodies as drawn (bodies); those of element sets number the cells of the first window.
    type(body_shape_type), allocatable :: shapes(:)
    !> Outlines that are carried with the material; their vertices are tracers behind those of the histories.
    type(carried_outline_type), allocatable :: outlines(:)
    !> Rigid bodies as drawn (rigid bodies), and what may touch (contacts).
    type(placed_shape_type), allocatable :: rigid_shapes(:)
    type(contact_pair_type), allocatable :: contact_pairs(:)
    !> Outline of the body of each pair without a surface, else none (contact pairs).
    type(rigid_outline_type), allocatable :: body_outlines(:)
    type(state_type) :: state
    type(loading_type) :: loading
    !> Ends of phases that later ones start from (qsmpm_phase_ends); unallocated for none.
    type(kept_phase_type), allocatable :: kept_phases(:)
    !> How often the mesh has been laid around the material anew.
    integer :: windows_built = 0
    !> Typical cell size: the smallest of the active cells at the start.
    real(wp) :: cell_size = 0.0_wp
    !> Surface of each traction carried by material points: those points and their areas.
    integer, allocatable :: carrying_point(:), carrying_surface(:)
    real(wp), allocatable :: carrying_area(:)
    !> Middle of the cavity that each surface bounds which is contracted (qsmpm_cavities) (2, surfaces).
    real(wp), allocatable :: cavity_middle(:, :)
    !> Tracer of each history (0 for none) and nearest material point (0 for none).
    integer, allocatable :: history_tracer(:), history_point(:)
    !> Tracers of the ends of each prop, 0 for one that is fixed (ends, props).
    integer, allocatable :: prop_tracer(:, :)
    !> State variable of each history (0 for none), and the number its point has among those of all bodies.
    integer, allocatable :: history_state(:), history_number(:)
    !> Body that each tracer rides with (0: with what is there), and its foot (0 for none) (tracers).
    integer, allocatable :: tracer_body(:), tracer_foot(:)
    !> Places of the nodes before anything has moved, of a mesh that goes with the ground and bodies that come or go
    !> (dimension, node_count).
    real(wp), allocatable :: drawn_coordinates(:, :)
    !> What stands on the feet of bodies that come.
    type(lift_feet_type) :: feet
    !> Sentences the builder wants in the log (points picked, sets found, ...).
    character(len=:), allocatable :: notes
  end type model_type

contains

  !> All that rides on the mesh.
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
