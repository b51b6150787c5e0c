!> Interface of a term of the equations of a step: a load on the nodes, or a resistance.
!>
!>   sum f_external - sum f_internal - sum f_numerical = 0
!>
!> The soil is one term, every load, support or penalty another. The step stores them as an array and loops over it for
!> residual, matrix, linear force of prescribed displacements, shares and messages (qsmpm_term_sums), always in the same
!> order. A new term is an extension of `term_type` and a line in qsmpm_standard_terms, or is passed to `add_term` by
!> the program that owns the analysis. A solve calls its procedures in this order:
!>
!>   prepare, couple      node lists and scratch data of the step, from the state
!>   begin                time of the step, damping and reduction of numerical terms
!>   set_load             loads at a fraction of the phase: that of the start, then that of the end
!>   evaluate, judge, add_force, add_blocks, ...   for each trial displacement
!>   keep_nodal           in equilibrium, before points move and nodes are renumbered
!>   commit or discard    exactly once, when the solve is accepted or not
!>
!> A term contains parameters and scratch data. Data that it stores from step to step (multipliers, a history) are
!> allocated in `model%state%kept` under a name of its own (`start`) and changed in `keep_nodal` and `commit` only:
!> checkpoint, restart file and a cut-back then restore them without further code.
!>
!> A term that requires fields in addition to the displacement names them (`need_field`): they are then unknowns of the
!> step (qsmpm_nodal_fields), `prescribe` sets their known values, and the term receives the table of all unknowns
!> instead of the displacement. It finds its nodes there by `joint_node`. A term that the program creates names them in
!> `choose_fields`, when the model is known.
module qsmpm_term
  use qsmpm_kinds, only: wp
  use qsmpm_configuration, only: configuration_type
  use qsmpm_equations, only: equations_type
  use qsmpm_error, only: error_not_converged
  use qsmpm_kept_arrays, only: kept_arrays_type
  use qsmpm_law, only: step_info_type
  use qsmpm_model, only: model_type
  use qsmpm_node_graph, only: connectivity_type, append_patches
  use qsmpm_owner_copies, only: owner_copies_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_team, only: team_type
  use qsmpm_term_share, only: solve_share_type, share_of_load
  use qsmpm_unknowns, only: unknowns_type, add_field
  implicit none
  private

  public :: term_type, term_slot_type, increment_type, failure_type, force_sizes_type

  !> Role of the force of a term in the balance: a load; a resistance, part of the reactions and of the internal work;
  !> or a numerical term that is not part of the physics.
  integer, parameter, public :: role_external = 1, role_internal = 2, role_numerical = 3

  !> Parameters of a step in addition to its loads.
  type :: increment_type
    type(step_info_type) :: step_info
    !> Coefficient of the proximal damping per volume and displacement; 0 in a static step.
    real(wp) :: damping = 0.0_wp
    !> Factor on the boundary stabilisation.
    real(wp) :: stabilisation = 1.0_wp
  end type increment_type

  !> Reason why a trial displacement cannot be evaluated.
  type :: failure_type
    logical :: failed = .false.
    !> A smaller step does not help: a law has failed.
    logical :: unrecoverable = .false.
    !> One of the error codes.
    integer :: cause = error_not_converged
    !> Load fraction that may be tried next; 0 if not set.
    real(wp) :: share = 0.0_wp
    !> Text; unallocated where that of the caller is used.
    character(len=:), allocatable :: reason
  end type failure_type

  !> Internal forces by magnitude, without cancellation: reference values of the shares.
  type :: force_sizes_type
    !> Sum of the magnitudes of the contributions (components, nodes).
    real(wp), allocatable :: force(:, :)
    !> Sum of the magnitudes of the work of the contributions on the displacement.
    real(wp) :: work = 0.0_wp
    !> Largest sum at a node of all processes of a team, the owned nodes, and the exchange of values at other nodes.
    real(wp) :: most = 0.0_wp
    logical, allocatable :: own(:)
    type(team_type) :: team
    type(owner_copies_type) :: copies
  contains
    procedure :: keep_own
  end type force_sizes_type

  type, abstract :: term_type
    !> For messages: 'the NAME has a value ...'.
    character(len=:), allocatable :: name
    integer :: role = role_internal
    !> Column of curves.csv with its share; unallocated for none.
    character(len=:), allocatable :: share_name
    !> A step is accepted by the residual without this term.
    logical :: transient = .false.
    !> The term supports the body against the ground, so that rigid motions of a part are not free.
    logical :: anchors = .false.
    !> The term is a force of rigid bodies, which may be the only change of load in a phase.
    logical :: of_bodies = .false.
    !> Its blocks are symmetric; set by `prepare`.
    logical :: symmetric = .true.
    !> Number of points whose stress an evaluation updates, for the profile of the run.
    integer :: point_count = 0
    !> Lists of coupled nodes, one for each block.
    type(connectivity_type) :: connectivity
    !> Number of the first of these lists among those of all terms; set by the step.
    integer :: first_stencil = 0
    !> Fields that it requires in addition to the displacement, and those of the step; set by the step.
    type(unknowns_type) :: needs, unknowns
    !> Rows and columns of the table of unknowns that it receives; set by the step.
    integer :: rows = 0, columns = 0
  contains
    procedure :: need_field
    procedure :: choose_fields => choose_no_fields
    procedure :: start => start_nothing
    procedure :: prescribe => prescribe_nothing
    procedure(prepare_interface), deferred :: prepare
    procedure :: couple => couple_patches
    procedure :: begin => begin_nothing
    procedure :: set_load => set_no_load
    procedure :: evaluate => evaluate_nothing
    procedure :: judge => judge_nothing
    procedure(force_interface), deferred :: add_force
    procedure :: add_sizes => add_no_sizes
    procedure :: add_blocks => add_no_blocks
    procedure :: add_linear_force => add_change_of_force
    procedure :: measure => measure_by_load
    procedure :: keep_nodal => keep_no_nodal
    procedure :: commit => commit_nothing
    procedure :: discard => discard_nothing
  end type term_type

  !> Element of the array of terms.
  type :: term_slot_type
    class(term_type), allocatable :: term
  end type term_slot_type

  abstract interface
    !> Finds the coupled nodes and the scratch data of a step from the state.
    subroutine prepare_interface(self, model, configuration)
      import :: term_type, model_type, configuration_type
      class(term_type), intent(inout) :: self
      type(model_type), intent(in) :: model
      type(configuration_type), intent(in) :: configuration
    end subroutine prepare_interface

    !> Adds the force at a displacement of the step that has been evaluated.
    subroutine force_interface(self, displacement, force)
      import :: term_type, wp
      class(term_type), intent(in) :: self
      !> (components, nodes)
      real(wp), intent(in) :: displacement(:, :)
      !> A load where the role is external, otherwise a resistance (components, nodes). At unknowns that belong to no
      !> node it is the contribution of this process, whose sum over a team is the whole.
      real(wp), intent(inout) :: force(:, :)
    end subroutine force_interface
  end interface

contains

  !> Allocates data stored from step to step in the state, unless they exist. Nothing, unless extended.
  subroutine start_nothing(self, model)
    class(term_type), intent(in) :: self
    type(model_type), intent(inout) :: model
  end subroutine start_nothing

  !> Requests the fields that the model requires; called before all else. None, unless extended.
  subroutine choose_no_fields(self, model)
    class(term_type), intent(inout) :: self
    type(model_type), intent(in) :: model
  end subroutine choose_no_fields

  !> Requests a field on the space of the displacement, or on separate nodes that belong to no mesh; terms that name the
  !> same field share it. Its nodal values are stored under its name.
  subroutine need_field(self, name, components, tolerance_ratio, node_count)
    class(term_type), intent(inout) :: self
    character(len=*), intent(in) :: name
    integer, intent(in) :: components
    !> Allowed relative residual, over that of the forces; 1 unless given.
    real(wp), intent(in), optional :: tolerance_ratio
    !> Number of separate nodes; those of the displacement when absent.
    integer, intent(in), optional :: node_count
    integer :: nodes

    nodes = 0
    if (present(node_count)) nodes = node_count
    call add_field(self%needs, name, components, nodes, tolerance_ratio)
  end subroutine need_field

  !> Marks constrained components of fields other than the displacement, and sets their values at a load fraction of the
  !> phase. Nothing, unless extended.
  subroutine prescribe_nothing(self, model, fraction, constrained, values)
    class(term_type), intent(in) :: self
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: fraction
    !> Table of all unknowns.
    logical, intent(inout) :: constrained(:, :)
    real(wp), intent(inout) :: values(:, :)
  end subroutine prescribe_nothing

  !> Appends the node lists to those of the preceding terms.
  subroutine couple_patches(self, configuration, connectivity)
    class(term_type), intent(in) :: self
    type(configuration_type), intent(in) :: configuration
    type(connectivity_type), intent(inout) :: connectivity

    call append_patches(connectivity, self%connectivity)
  end subroutine couple_patches

  !> Receives the parameters of the step. Nothing, unless extended.
  subroutine begin_nothing(self, increment)
    class(term_type), intent(inout) :: self
    type(increment_type), intent(in) :: increment
  end subroutine begin_nothing

  !> Applies loads. Nothing, unless extended.
  subroutine set_no_load(self, model, configuration, fraction)
    class(term_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    !> Load fraction of the phase, 0 to 1.
    real(wp), intent(in) :: fraction
  end subroutine set_no_load

  !> Performs the computations needed once for a trial displacement, before its force and blocks are requested. A term
  !> that forms its blocks here also adds them. Nothing, unless extended.
  subroutine evaluate_nothing(self, model, configuration, displacement, tangent, equations, matrix, failure, prescribed)
    class(term_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :)
    !> tangent_none, tangent_consistent or tangent_elastic: whether blocks will be requested.
    integer, intent(in) :: tangent
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    !> Set where the displacement cannot be evaluated.
    type(failure_type), intent(inout) :: failure
    !> Displacements whose linear force will be requested (components, nodes).
    real(wp), intent(in), optional :: prescribed(:, :)
  end subroutine evaluate_nothing

  !> Assesses a trial displacement that all processes have evaluated, by criteria that require all processes of the
  !> team, each of which takes part. Nothing, unless extended.
  subroutine judge_nothing(self, model, displacement, failure)
    class(term_type), intent(in) :: self
    type(model_type), intent(in) :: model
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :)
    !> Set on all processes at once where the displacement is not acceptable.
    type(failure_type), intent(inout) :: failure
  end subroutine judge_nothing

  !> Adds the magnitudes of the force. Nothing, unless extended: shares refer to the soil.
  subroutine add_no_sizes(self, sizes)
    class(term_type), intent(in) :: self
    type(force_sizes_type), intent(inout) :: sizes
  end subroutine add_no_sizes

  !> Adds the derivatives of the resistance, or of a load with negative sign, to the matrix: block k at the node list
  !> first_stencil + k - 1. Nothing, unless extended.
  subroutine add_no_blocks(self, displacement, equations, matrix)
    class(term_type), intent(in) :: self
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
  end subroutine add_no_blocks

  !> Adds the resistance due to displacements from the start of the step: the change of the force. It is exact for a
  !> linear term and sufficient for others, because it only starts the iteration.
  subroutine add_change_of_force(self, displacement, force)
    class(term_type), intent(in) :: self
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    real(wp), dimension(size(force, 1), size(force, 2)) :: change, still, at_start

    still = 0.0_wp
    at_start = 0.0_wp
    call self%add_force(still, at_start)
    if (self%role == role_external) then
      change = 0.0_wp
      call self%add_force(displacement, change)
      force = force - (change - at_start)
    else
      call self%add_force(displacement, force)
      force = force - at_start
    end if
  end subroutine add_change_of_force

  !> Sets a force to zero at the nodes owned by other processes.
  pure subroutine keep_own(self, force)
    class(force_sizes_type), intent(in) :: self
    !> (components, nodes)
    real(wp), intent(inout) :: force(:, :)

    if (.not. allocated(self%own)) return
    where (spread(.not. self%own(:size(force, 2)), 1, size(force, 1))) force = 0.0_wp
  end subroutine keep_own

  !> Measures the share in a solve: the force relative to that of the load, unless extended.
  subroutine measure_by_load(self, displacement, load_norm, connectivity, sizes, share)
    class(term_type), intent(in) :: self
    !> Displacement of the solve (components, nodes).
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(in) :: load_norm
    !> Node lists of all terms.
    type(connectivity_type), intent(in) :: connectivity
    !> Internal forces by magnitude at the displacement.
    type(force_sizes_type), intent(in) :: sizes
    type(solve_share_type), intent(out) :: share
    real(wp) :: force(size(displacement, 1), size(displacement, 2))

    force = 0.0_wp
    call self%add_force(displacement, force)
    call sizes%keep_own(force)
    share = share_of_load(self%share_name, force, load_norm)
  end subroutine measure_by_load

  !> Updates data stored by node. The solve is in equilibrium, and nodes are numbered as in `prepare`; the data are
  !> renumbered with the nodes, and restored where the solve is not accepted after all (a point that leaves the mesh).
  !> Nothing, unless extended.
  subroutine keep_no_nodal(self, displacement, kept)
    class(term_type), intent(in) :: self
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(kept_arrays_type), intent(inout) :: kept
  end subroutine keep_no_nodal

  !> Updates stored data after an accepted solve: the points have moved, nodes and cells of the model may be renumbered,
  !> the displacement has the numbering of `prepare`. Nothing, unless extended.
  subroutine commit_nothing(self, displacement, model)
    class(term_type), intent(inout) :: self
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model
  end subroutine commit_nothing

  !> Called when the solve is not accepted. Nothing, unless extended: `prepare` recreates scratch data.
  subroutine discard_nothing(self)
    class(term_type), intent(inout) :: self
  end subroutine discard_nothing
end module qsmpm_term
