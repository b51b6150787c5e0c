!> The analysis a deck describes, as plain data: what the parser fills, what an embedding program
!> may fill by hand, and what the model is built from. No procedure, no file name resolved twice,
!> every default stated here once.
!>
!> Names of sets, surfaces and materials are kept as text; the model builder resolves them against
!> the mesh and reports the unknown ones. Lengths, forces and stresses are in the deck's consistent
!> units. Vectors have three components; the third is unused in the plane.
module qsmpm_analysis
  use qsmpm_kinds, only: wp
  use qsmpm_softening_parameters, only: softening_parameters_type
  use qsmpm_law_parameters, only: law_parameters_type
  use qsmpm_strength_factor, only: flow_material
  use qsmpm_strength_profile, only: strength_profile_type
  use qsmpm_undrained_parameters, only: undrained_type
  use qsmpm_strength_constants, only: strength_constant_type
  use qsmpm_user_material, only: user_material_type
  use qsmpm_point_test, only: point_test_type
  use qsmpm_source_line, only: source_line_type
  use qsmpm_structures, only: rigid_move_type, prop_type, prop_change_type
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: analysis_type, axis_type, mesh_source_type, set_type, surface_type, body_type, &
    material_type, method_type, solver_choice_type, fixity_type, prescription_type, &
    traction_type, support_type, prop_type, prop_change_type, gravity_type, controls_type, &
    constant_load_test_type, history_type, phase_type, &
    safety_type, moving_mesh_type, initial_stress_type, drain_state_type, output_request_type, source_line_type, &
    body_change_type, stop_type, water_level_type, at_rest_type, rigid_body_type, contact_type, rigid_move_type

  !> Kinds of model.
  integer, parameter, public :: plane_strain = 1, axisymmetric = 2, three_dimensional = 3
  !> Whether a reduced model may be half of a symmetric scene: where nothing speaks against it, whenever
  !> the scene is symmetric, never.
  integer, parameter, public :: mirror_auto = 0, mirror_yes = 1, mirror_no = 2
  !> Where the mesh comes from.
  integer, parameter, public :: mesh_none = 0, mesh_grid = 1, mesh_file = 2, mesh_inline = 3, mesh_fitted = 4
  !> How the diagonals of grid triangles run: random is the prototype's unstructured mesh.
  integer, parameter, public :: diagonal_right = 1, diagonal_left = 2, diagonal_random = 3, &
    diagonal_alternate = 4
  !> How a node set, element set or surface is chosen.
  integer, parameter, public :: select_list = 1, select_box = 2, select_plane = 3, select_segment = 4, &
    select_mesh = 5, select_outline = 6
  !> How a body is bounded.
  integer, parameter, public :: body_all = 1, body_box = 2, body_polygon = 3, body_region = 4, &
    body_polyhedron = 5
  !> What the points see: rows of `basis_list` (qsmpm_basis_traits); auto is decided by the deck's grid and
  !> materials (qsmpm_recommended_method).
  integer, parameter, public :: basis_auto = 0, basis_standard = 1, basis_fem = 2, basis_gimp = 3, &
    basis_spline2 = 4, basis_spline3 = 5, basis_spline2g = 6
  !> How cells are integrated.
  integer, parameter, public :: integrate_points = 1, integrate_cells = 2
  !> Kinematics of the law, and how the rate is integrated.
  integer, parameter, public :: kinematics_jaumann = 1, kinematics_logarithmic = 2
  integer, parameter, public :: rate_paper = 1, rate_midpoint = 2
  !> Stress whose Jaumann rate is proportional to the strain rate.
  integer, parameter, public :: stress_rate_kirchhoff = 1, stress_rate_cauchy = 2
  !> Support of a surface: none, no motion along its normal, no motion.
  integer, parameter, public :: support_none = 0, support_normal = 1, support_all = 2
  !> Stabilisation of boundary cells.
  integer, parameter, public :: stabilise_none = 0, stabilise_background = 1, stabilise_ghost = 2
  !> Cure of volumetric locking of a material; auto is resolved by the model builder.
  integer, parameter, public :: locking_none = 0, locking_auto = 1, locking_uniform_pressure = 2
  !> Strengths of the stabilisation when nothing else is said: background, ghost of elements, ghost
  !> of GIMP and quadratic splines (least error of the elastic column, docs/methods/ghost.md), and of cubic
  !> ones, whose jumps of third derivatives weigh (3!)^2 times as much: with 0.002 already the share
  !> of a coarse block does not come below its bound.
  real(wp), parameter, public :: background_factor = 1.0e-2_wp, ghost_factor = 1.0e-3_wp, &
    grid_ghost_factor = 2.0e-2_wp, cubic_ghost_factor = 5.0e-4_wp
  !> Linear solvers: AUTO, and rows of `solver_list` that others know by name.
  integer, parameter, public :: solver_auto = 0, solver_band = 1, solver_cholmod = 2, &
    solver_umfpack = 3, solver_mumps = 4, solver_krylov = 5, solver_petsc = 7
  !> Precision of the factors.
  integer, parameter, public :: precision_auto = 0, precision_double = 1, precision_single = 2
  !> Whether a factor serves later matrices of the same pattern as a preconditioner.
  integer, parameter, public :: keep_auto = 0, keep_no = 1, keep_yes = 2
  !> Newton variants: the paper's frozen [K^E + K^G]^0, or the consistent tangent.
  integer, parameter, public :: newton_modified = 1, newton_full = 2
  !> What a phase does: loads change, or the strength is lowered until it is lost.
  integer, parameter, public :: phase_loading = 1, phase_safety = 2
  !> Places, volumes and deformation in the search for a factor of safety: they stay, or follow.
  integer, parameter, public :: geometry_fixed = 1, geometry_moving = 2
  !> How a phase starts its stresses.
  integer, parameter, public :: initial_keep = 0, initial_k0 = 1, initial_isotropic = 2, initial_given = 3
  !> Who carries a traction: tracked surface points, or the outermost material points (paper, 3.1).
  integer, parameter, public :: carrier_surface = 1, carrier_points = 2
  !> What a history records: rows of `history_quantities` (qsmpm_history_quantities).
  integer, parameter, public :: quantity_displacement = 1, quantity_position = 2, quantity_stress = 3, &
    quantity_reaction = 4, quantity_state = 5, quantity_strain = 6, quantity_volume = 7, quantity_runout = 8, &
    quantity_pore_pressure = 9, quantity_contact_force = 10, quantity_contact_moment = 11, quantity_body_move = 12, &
    quantity_contact_pressure = 13, quantity_body_rotation = 14, quantity_contact_slip = 15, &
    quantity_prop_force = 16
  !> Whether a phase stops where a history rises to a value or falls to it.
  integer, parameter, public :: stop_above = 1, stop_below = 2
  !> What has ended a phase: nothing yet, its whole load, its limit load, a stop, the loss of its equilibrium.
  integer, parameter, public :: not_ended = 0, ended_by_load = 1, ended_by_limit = 2, ended_by_stop = 3, &
    ended_by_loss = 4
  !> Shapes of rigid bodies.
  integer, parameter, public :: rigid_plane = 1, rigid_circle = 2, rigid_box = 3, rigid_cone = 4, rigid_polygon = 5, &
    rigid_cylinder = 6
  !> Where contact is asked for: on a surface of the soil, or on the outline of the rigid body.
  integer, parameter, public :: contact_on_soil = 1, contact_on_body = 2
  !> What contact is asked for on in the mean: what a cell holds of a surface, or every point by itself.
  integer, parameter, public :: patch_cell = 1, patch_point = 2
  !> How a body that is put in place meets the ground below: stretched down to it, or as it is drawn.
  integer, parameter, public :: fill_level = 1, fill_shape = 2

  !> Grid lines along one axis.
  type :: axis_type
    !> Increasing coordinates, size >= 2.
    real(wp), allocatable :: lines(:)
  end type axis_type

  !> The background mesh.
  type :: mesh_source_type
    integer :: kind = mesh_none
    type(source_line_type) :: where
    !> Element name as in the deck: WEDGE6, WEDGE15, TRI3, TRI6, QUAD4, QUAD8, HEX8, HEX20, TET4, TET10.
    character(len=:), allocatable :: element
    !> Grid: x, y and (in 3D) z lines.
    type(axis_type) :: axes(3)
    integer :: diagonal = diagonal_right
    !> Grid: random shift of inner nodes as a share of the smallest neighbouring spacing, 0 to 0.3.
    real(wp) :: perturbation = 0.0_wp
    !> Grid: seed of the shifts and of random diagonals.
    integer :: seed = 1
    !> Grid: look only at the part around the material; triangles that fit give way to the grid when they are worn.
    logical :: windowed = .true., refits = .true.
    !> Fitted: boxes as least and largest x and y, and the width of triangles there (5,n).
    real(wp), allocatable :: refined(:, :)
    !> File: path relative to the working directory, format GMSH or ABAQUS.
    character(len=:), allocatable :: file, format
    !> Inline: coordinates (3,n) and labels of nodes, element labels, connectivity by label (nodes per element, n).
    real(wp), allocatable :: nodes(:, :)
    integer, allocatable :: node_labels(:), element_labels(:), connectivity(:, :)
  end type mesh_source_type

  !> A named set of nodes or elements chosen in the deck.
  type :: set_type
    character(len=:), allocatable :: name
    type(source_line_type) :: where
    integer :: selection = select_list
    !> select_list: labels.
    integer, allocatable :: labels(:)
    !> select_box: lower and upper corner (3,2). select_plane: box(axis,1) holds the coordinate.
    real(wp) :: box(3, 2) = 0.0_wp
    !> select_plane: 1, 2 or 3.
    integer :: axis = 0
  end type set_type

  !> A named piece of body surface on which tractions act.
  type :: surface_type
    character(len=:), allocatable :: name
    type(source_line_type) :: where
    !> select_box: mesh faces inside the box; select_segment: straight segments in the x-y plane,
    !> through all of z in 3D; select_mesh: a surface named by the mesh file; select_outline: the
    !> bounds of a body, or what of them is in the box.
    integer :: selection = select_box
    real(wp) :: box(3, 2) = 0.0_wp
    !> x1, y1, x2, y2 of each segment, (4,n).
    real(wp), allocatable :: segments(:, :)
    !> Name of the body whose outline it is.
    character(len=:), allocatable :: body
    !> The box bounds the outline.
    logical :: boxed = .false.
  end type surface_type

  !> A body of material, and how densely it is seeded.
  type :: body_type
    character(len=:), allocatable :: name, material
    type(source_line_type) :: where
    integer :: kind = body_all
    real(wp) :: box(3, 2) = 0.0_wp
    !> Vertices in the x-y plane, counter-clockwise, (2,n); through all of z in 3D.
    real(wp), allocatable :: polygon(:, :)
    !> Element set of the mesh.
    character(len=:), allocatable :: region
    !> STL file of a polyhedron: path relative to the working directory.
    character(len=:), allocatable :: file
    !> Points per element; 0 asks for the element's default.
    integer :: points_per_element = 0
    !> It is there from the start; else a phase puts it in place.
    logical :: active = .true.
    !> How often the scene as drawn holds what a reduced model does of the body.
    real(wp) :: copies = 1.0_wp
  end type body_type

  !> Horizontal stress of a material at the start (qsmpm_stress_at_rest).
  type :: at_rest_type
    type(source_line_type) :: where
    !> K0 of first loading; negative: that of the phase. It is 1 - sin phi.
    real(wp) :: k0 = -1.0_wp
    logical :: jaky = .false.
    !> Largest vertical stress in the past over the present one, and less the present one.
    real(wp) :: overconsolidation = 1.0_wp, pre_overburden = 0.0_wp
    !> Poisson's ratio of unloading; negative: that of the material.
    real(wp) :: poisson = -1.0_wp
  end type at_rest_type

  !> Parameters of one material; the law is chosen by what is present.
  type :: material_type
    character(len=:), allocatable :: name
    type(source_line_type) :: where
    real(wp) :: young = 0.0_wp
    real(wp) :: poisson = 0.0_wp
    !> Weight per volume at load factor 1 (multiplied by the gravity vector).
    real(wp) :: unit_weight = 0.0_wp
    !> The same below the water level; negative: no other.
    real(wp) :: saturated_weight = -1.0_wp
    type(at_rest_type) :: at_rest
    logical :: mohr_coulomb = .false.
    real(wp) :: cohesion = 0.0_wp
    !> Degrees.
    real(wp) :: friction_angle = 0.0_wp
    real(wp) :: dilatancy_angle = 0.0_wp
    !> Largest principal stress allowed; huge means no cut-off.
    real(wp) :: tensile_strength = huge(1.0_wp)
    !> How the strength falls, if it does.
    type(softening_parameters_type) :: softening
    !> The law is given by the program that embeds the library; nothing is known of it.
    logical :: own_law = .false.
    !> Strength by place, in the place of the cohesion.
    type(strength_profile_type) :: strength_profile
    type(source_line_type) :: profile_where
    !> Pore water that cannot leave.
    type(undrained_type) :: undrained
    type(source_line_type) :: undrained_where
    !> A law of qsmpm_standard_laws, instead of elasticity and strength.
    class(law_parameters_type), allocatable :: soil_law
    !> One of cure_*, and its factor; negative asks for the default of the mesh.
    integer :: locking_treatment = locking_auto
    real(wp) :: pressure_factor = -1.0_wp
    !> Model in a shared library.
    type(user_material_type) :: user
    !> Constants that a factor of safety divides, of a law that does not know its strength; unallocated for none.
    type(strength_constant_type), allocatable :: strength_constants(:)
    type(source_line_type) :: strength_where
  end type material_type

  !> How the continuum is discretised.
  type :: method_type
    integer :: basis = basis_standard
    integer :: integration = integrate_points
    integer :: kinematics = kinematics_logarithmic
    integer :: rate = rate_midpoint
    integer :: stress_rate = stress_rate_kirchhoff
    !> BACKGROUND is the default of the elements, GHOST of GIMP and splines.
    integer :: stabilisation = stabilise_background
    !> Background eps or ghost gamma; negative asks for usual_factor.
    real(wp) :: stabilisation_factor = -1.0_wp
  end type method_type

  type :: solver_choice_type
    integer :: kind = solver_auto
    integer :: precision = precision_auto, keep_factor = keep_auto
    !> AUTO may take multigrid (no word of the card).
    logical :: multigrid = .true.
  end type solver_choice_type

  !> Fixed components of a node set: zero displacement, or freed again.
  type :: fixity_type
    character(len=:), allocatable :: set
    type(source_line_type) :: where
    logical :: fixed(3) = .false.
  end type fixity_type

  !> Prescribed displacement of a node set in the phase, per unit of load factor.
  type :: prescription_type
    character(len=:), allocatable :: set
    type(source_line_type) :: where
    integer :: component = 0
    real(wp) :: value = 0.0_wp
  end type prescription_type

  !> Load on a surface per unit of load factor: a dead traction, force per undeformed area, or a
  !> pressure that follows area and normal.
  type :: traction_type
    character(len=:), allocatable :: surface
    type(source_line_type) :: where
    logical :: follows = .false.
    real(wp) :: vector(3) = 0.0_wp
    real(wp) :: pressure = 0.0_wp
    !> Pressure: what it grows by per length downwards, and the height at which it is `pressure`.
    real(wp) :: gradient = 0.0_wp, height = 0.0_wp
    !> It is that of water: none above the height.
    logical :: of_water = .false.
    integer :: carrier = carrier_surface
  end type traction_type

  !> A body that does not deform and that surfaces of the soil may touch.
  type :: rigid_body_type
    character(len=:), allocatable :: name
    type(source_line_type) :: where
    !> One of rigid_*.
    integer :: shape = rigid_circle
    !> A point of a plane, centre of a circle, tip of a cone, middle of the base of a cylinder; direction in which a
    !> plane looks at the soil.
    real(wp) :: place(3) = 0.0_wp, direction(3) = 0.0_wp
    !> Of a circle, a cylinder and the shaft of a cone; angle of its tip in degrees; length of the shaft or cylinder.
    real(wp) :: radius = 0.0_wp, apex_angle = 60.0_wp, shaft = 0.0_wp
    !> Lower and upper corner (3,2).
    real(wp) :: box(3, 2) = 0.0_wp
    !> Vertices (2,n).
    real(wp), allocatable :: polygon(:, :)
    !> Radius of the corners; negative asks for a share of the cells.
    real(wp) :: round = -1.0_wp
    !> A box in space as drawn is turned about its middle: axis times angle in degrees.
    real(wp) :: rotation(3) = 0.0_wp
    !> What is drawn of the soil inside of it is taken out at the start.
    logical :: in_place = .false.
  end type rigid_body_type

  !> A surface of the soil that may touch a rigid body, or any soil.
  type :: contact_type
    !> No surface where contact is asked for on the body.
    character(len=:), allocatable :: body, surface
    !> One of contact_on_*.
    integer :: place = contact_on_soil
    type(source_line_type) :: where
    !> Strength of the interface: angle in degrees, and shear strength without pressure.
    real(wp) :: friction_angle = 0.0_wp, adhesion = 0.0_wp
    !> Share of the strength of the soil that the interface has instead; negative for none.
    real(wp) :: interface = -1.0_wp
    !> Penalty of the gap times the size of a cell over Young's modulus; negative for the usual one.
    real(wp) :: penalty = -1.0_wp
    !> One of patch_*.
    integer :: patch = patch_cell
    !> They do not part.
    logical :: tension = .false.
  end type contact_type

  !> A surface held on the plane it lies in, wholly, or freed again.
  type :: support_type
    character(len=:), allocatable :: surface
    type(source_line_type) :: where
    integer :: kind = support_normal
    !> It is the outline of a cavity that moves inwards until this part of its area is lost, in percent per unit of load
    !> factor; its middle stays, else as a whole it is free along the vertical.
    logical :: contracts = .false., held = .false.
    real(wp) :: volume_loss = 0.0_wp
  end type support_type

  !> Gravity per unit of load factor; multiplies the unit weight.
  type :: gravity_type
    logical :: given = .false.
    real(wp) :: vector(3) = 0.0_wp
  end type gravity_type

  !> Level of the ground water from a phase on, of one body or of all that have none of their own.
  type :: water_level_type
    !> Empty for all.
    character(len=:), allocatable :: body
    type(source_line_type) :: where
    !> There is none any more.
    logical :: none = .false.
    !> Weight of water per volume; *GRAVITY multiplies it. Negative: not given.
    real(wp) :: unit_weight = -1.0_wp
    !> Horizontal coordinate and height of the corners of the line, (2,n).
    real(wp), allocatable :: line(:, :)
  end type water_level_type

  !> Step control and stopping rules of a phase.
  type :: controls_type
    type(source_line_type) :: where
    !> Load steps the phase is first cut into.
    integer :: steps = 10
    integer :: newton = newton_full
    !> Relative out-of-balance (eq. 27).
    real(wp) :: tolerance = 1.0e-4_wp
    integer :: max_iterations = 20
    logical :: line_search = .true.
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

  !> A column of curves.csv.
  type :: history_type
    character(len=:), allocatable :: name, unit
    type(source_line_type) :: where
    integer :: quantity = quantity_displacement
    !> 1..3 for vectors; 1..6 (11,22,33,12,13,23) for stress.
    integer :: component = 1
    !> Start position of the massless tracer, or where the nearest material point is sought.
    real(wp) :: at(3) = 0.0_wp
    !> quantity_reaction: the node set, or the supported surface.
    character(len=:), allocatable :: set, surface
    !> Quantities of a body: its name, empty for all bodies.
    character(len=:), allocatable :: body
    !> quantity_prop_force: name of the prop.
    character(len=:), allocatable :: prop
    !> quantity_runout: the front is where the coordinate is smallest, not largest.
    logical :: smallest = .false.
    !> quantity_contact_slip: mean of what is in contact, not the largest.
    logical :: mean = .false.
    !> quantity_state: name of the state variable as results have it, or its number.
    character(len=:), allocatable :: state
    real(wp) :: scale = 1.0_wp
  end type history_type

  !> Mesh rows that follow a plate: rows between base and plate scale, rows beyond shift.
  type :: moving_mesh_type
    logical :: active = .false.
    type(source_line_type) :: where
    character(len=:), allocatable :: set
    integer :: axis = 2
    !> Coordinate of the row that stays.
    real(wp) :: base = 0.0_wp
    !> Rows follow a rigid body in place of a plate; distance from its reference point within which they keep theirs.
    logical :: by_body = .false.
    character(len=:), allocatable :: body
    real(wp) :: near = 0.0_wp
  end type moving_mesh_type

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

  !> What a phase does to a body: put in place, taken out, or of another material from then on.
  type :: body_change_type
    character(len=:), allocatable :: body
    type(source_line_type) :: where
    character(len=:), allocatable :: material
    integer :: fill = fill_level
  end type body_change_type

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

  !> What becomes of the excess pore pressure of undrained materials in a phase, and after it.
  type :: drain_state_type
    logical :: given = .false.
    type(source_line_type) :: where
    !> The pressure stays as it is, and only new one does not come about.
    logical :: keeps = .false.
    !> The material is drained in later phases too.
    logical :: stays_drained = .false.
    !> Bodies it is about; none: all.
    type(string_type), allocatable :: bodies(:)
  end type drain_state_type

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
  type :: phase_type
    character(len=:), allocatable :: name
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
    logical :: start_given = .false.
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
    type(controls_type) :: controls
    type(constant_load_test_type) :: constant_load_test
    !> Where it ends before its whole load, and by how much a value may be passed, relative to it.
    type(stop_type), allocatable :: stops(:)
    real(wp) :: stop_tolerance = 1.0e-2_wp
    !> Displacements count from its start; softened material has its first strength again.
    logical :: reset_displacements = .false., reset_strains = .false.
    type(drain_state_type) :: drain_state
  end type phase_type

  !> Which results are written, and how often (in accepted steps; 0 means at phase ends only).
  type :: output_request_type
    integer :: field_every = 0
    integer :: restart_every = 0
    !> VTK pictures and HDF5 results can be switched off for studies.
    logical :: vtk = .true., hdf5 = .true.
    !> The material points carry strains.
    logical :: strains = .true.
  end type output_request_type

  !> Made of the lines of *GRID: mesh, method, factors against locking (materials), least size of a cell.
  type, public :: background_type
    integer :: kind = mesh_grid
    character(len=:), allocatable :: element
    type(method_type) :: method
    real(wp), allocatable :: pressure_factor(:), cell_size
  end type background_type

  !> Everything a deck says.
  type :: analysis_type
    !> Path of the deck and its base name without extension; keywords of the cards it has, each once.
    character(len=:), allocatable :: deck, job
    type(string_type), allocatable :: cards(:)
    !> Heading lines joined by newlines.
    character(len=:), allocatable :: heading
    character(len=:), allocatable :: length_unit, force_unit
    integer :: model = 0
    !> The smallest model that answers is looked for, and may be half of a symmetric scene.
    logical :: reduce = .false.
    integer :: mirror = mirror_auto
    type(mesh_source_type) :: mesh
    type(set_type), allocatable :: node_sets(:), element_sets(:)
    type(surface_type), allocatable :: surfaces(:)
    type(body_type), allocatable :: bodies(:)
    type(rigid_body_type), allocatable :: rigid_bodies(:)
    type(contact_type), allocatable :: contacts(:)
    type(prop_type), allocatable :: props(:)
    type(material_type), allocatable :: materials(:)
    type(method_type) :: method
    !> Method that is recommended for a deck that names none, and why.
    character(len=:), allocatable :: method_reason
    !> Of the start, and what follows when that is worn; unallocated where nothing follows.
    type(background_type), allocatable :: backgrounds(:)
    type(solver_choice_type) :: solver
    type(moving_mesh_type) :: moving_mesh
    !> All-round pressure on every free boundary of the soil, compression positive.
    real(wp) :: confinement = 0.0_wp
    type(history_type), allocatable :: histories(:)
    type(output_request_type) :: output
    type(phase_type), allocatable :: phases(:)
    !> A laboratory test on one point in place of a scene.
    type(point_test_type) :: point_test
  end type analysis_type
end module qsmpm_analysis
