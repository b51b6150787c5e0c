!> The interface of all constitutive laws: a batch of points of one material from the start
!> to the end of a step.
!>
!> The law receives the incremental deformation gradient F and returns Q, the first
!> Piola-Kirchhoff stress with respect to the start of the step, and A = dQ/dF. The internal
!> force of a point of start volume V is V Q : grad0 N and its stiffness V grad0 N : A : grad0 N,
!> which contains K^E and K^G of the paper (eqs. 15-17); the assembly needs no knowledge of the law.
!>
!> Packing. Gradient-like tensors are packed column by column: in 3D (11,21,31,12,22,32,13,23,33),
!> nine components; in 2D (11,21,12,22,33), five components, the last used by axisymmetry only.
!> Stresses: 11,22,33,12,13,23 (3D, six) or 11,22,33,12 (2D, four). Tension positive.
!>
!> All-round pressure. A pressure p0 may act on every free boundary of the soil and follow it.
!> Its force on a body of any shape is that of a uniform stress -p0 inside, so that no sum over the
!> boundary is needed: the equations are written for the stress in excess of -p0,
!>
!>   Q := Q + p0 cof F,   A := A + p0 d(cof F)/dF,   cof F = det F F^-T
!>
!> with Q and A of the law. Stresses of points, laws and results include p0. The integration error of cut cells then
!> concerns only the stress in excess of -p0, not p0 itself.
!>
!> A law may wrap another law (outer_law_type), of which it changes stresses, states or steps; procedures that it does
!> not override are those of the inner law.
module qsmpm_law
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: string_type, word_place
  use qsmpm_tensor, only: cofactor, pack_gradient, unpack_gradient
  implicit none
  private

  public :: law_type, model_traits_type, law_traits_type, law_slot_type, batch_type, step_info_type, &
    field_coupling_type, start_time, time_increment, is_nonlocal, outer_law_type, unnamed_states

  !> Status of a point: updated; not in a step of this length; not at all; and failure of the law itself, after which
  !> the run must end.
  integer, parameter, public :: status_ok = 0, status_cut = 1, status_failed = 2, status_unrecoverable = 3

  !> Requested tangent: none, the consistent one, or the elastic one (K^E + K^G at F).
  integer, parameter, public :: tangent_none = 0, tangent_consistent = 1, tangent_elastic = 2

  !> Load fraction assigned to a step at constant load as its duration: models divide by it.
  real(wp), parameter :: held_duration = 1.0e-6_wp

  !> Time of a step. In a quasi-static analysis only the material models depend on time. A phase lasts
  !> as long as the deck defines, one unit by default, and its load increases linearly from start to end.
  type :: step_info_type
    !> Number of the phase, and of the step in all phases, from 1.
    integer :: phase = 1
    integer :: step = 1
    !> Number of the step in its phase, from 1.
    integer :: step_of_phase = 1
    !> Load fraction at the start of the step, and its increment.
    real(wp) :: start = 0.0_wp
    real(wp) :: duration = 1.0_wp
    !> Time at the start of the phase, and duration of the phase.
    real(wp) :: phase_start = 0.0_wp
    real(wp) :: phase_time = 1.0_wp
    !> Positions are fixed and strains are small (qsmpm_small_strain).
    logical :: in_place = .false.
  end type step_info_type

  !> Points of one material in one step. Inputs are set by the caller, outputs by the law;
  !> arrays may be longer than `count`.
  type :: batch_type
    integer :: count = 0
    !> In: incremental deformation gradient, packed (5 or 9, n).
    real(wp), allocatable :: gradient(:, :)
    !> In: volume ratio V/V0 at the start of the step (n).
    real(wp), allocatable :: volume_ratio(:)
    !> In: Cauchy stress at the start (4 or 6, n).
    real(wp), allocatable :: stress_start(:, :)
    !> In: state of the law at the start (state_count, n).
    real(wp), allocatable :: state_start(:, :)
    !> In: time of the step.
    type(step_info_type) :: step_info
    !> In, for laws with asks_where: number of the material point, 0 for a point that belongs to a cell, and of its
    !> cell (n).
    integer, allocatable :: number(:), cell(:)
    !> In, for laws with asks_where: position, for points of a cell its centre, and size of the cell
    !> (dimension, n), (n).
    real(wp), allocatable :: place(:, :), cell_size(:)
    !> In, for user models: pore pressure at the start of the step, compression positive, the excess in it, and the
    !> degree of saturation (3, n); unallocated without water.
    real(wp), allocatable :: water(:, :)
    !> Out: Cauchy stress at the end (4 or 6, n).
    real(wp), allocatable :: stress(:, :)
    !> Out: state at the end (state_count, n).
    real(wp), allocatable :: state(:, :)
    !> Out: Q, packed (5 or 9, n).
    real(wp), allocatable :: piola(:, :)
    !> Out, when requested: A(i,j) = d piola(i) / d gradient(j), (5 or 9, 5 or 9, n).
    real(wp), allocatable :: tangent(:, :, :)
    !> Out: one of the status_* values (n).
    integer, allocatable :: status(:)
    !> Out: 1 where the point yields in this step, else 0 (n).
    integer, allocatable :: plastic(:)
    !> Out, may be set with a status other than ok: the share of the step that may be tried next, and the
    !> message of the law.
    real(wp) :: share = 0.0_wp
    character(len=:), allocatable :: message
  end type batch_type

  !> Coupling of displacement and field of a nonlocal law at a point: derivatives of Q by kbar (5 or 9, packed), of
  !> kappa by kbar, and of kappa by F (5 or 9).
  type :: field_coupling_type
    real(wp) :: stress_by_field(9) = 0.0_wp
    real(wp) :: strain_by_field = 0.0_wp
    real(wp) :: strain_by_gradient(9) = 0.0_wp
  end type field_coupling_type

  !> Properties of a soil model in tensors, and of a law.
  type :: model_traits_type
    !> Number of state variables of a point, in `state`; for the logarithmic kinematics the first are the
    !> elastic left Cauchy-Green tensor in stress order.
    integer :: state_count = 0
    !> Names of the state variables in results; those without a name are not written (state_count).
    type(string_type), allocatable :: state_names(:)
    !> Advice for the user; unallocated if there is none.
    character(len=:), allocatable :: advice
    !> Whether it reports which points yield.
    logical :: tells_yield = .true.
    !> True when the consistent tangent is symmetric for every state.
    logical :: symmetric = .false.
    !> Young's modulus that scales stabilisation terms.
    real(wp) :: stiffness_scale = 0.0_wp
    !> Shear modulus that scales the resistance to volume changes inside a group of uniform pressure.
    real(wp) :: shear_scale = 0.0_wp
  end type model_traits_type

  !> Properties of a law.
  type, extends(model_traits_type) :: law_traits_type
    !> 2 or 3.
    integer :: dimension = 0
    !> Whether the law requires number, cell, position and cell size of its points.
    logical :: asks_where = .false.
    !> Internal length l of a nonlocal law, 0 for others, and the largest cell in which the field is used. Its last two
    !> state variables are kappa, the source of the field, and kbar, the field at the end of the step, which the caller
    !> sets in `state_start` (qsmpm_nonlocal_strain).
    real(wp) :: field_length = 0.0_wp, coarsest_cell = huge(1.0_wp)
    !> The model is a user model: its failure is error_user_material.
    logical :: of_user = .false.
    !> The strength limits the Kirchhoff stress, or J sigma with J from the start of the step; otherwise it limits the
    !> Cauchy stress.
    logical :: bounds_kirchhoff = .false.
    !> Position used where none is given.
    real(wp) :: usual_place(3) = 0.0_wp
    !> Share of the elastic tangent blended into the consistent one, about 1e-5; 0 gives the
    !> exact one.
    real(wp) :: elastic_blend = 0.0_wp
  end type law_traits_type

  !> A constitutive law with its parameters. It stores no state: two models may share one.
  type, abstract, extends(law_traits_type) :: law_type
  contains
    !> Initial state of an unstressed or prestressed point, at the usual position, and at a given one.
    procedure :: start
    procedure(start_interface), deferred :: start_at
    !> Updates the strength from the effective stress of a point, where it depends on it.
    procedure :: strengthen => keep_strength
    !> Updates a batch by one step.
    procedure(update_interface), deferred :: update
    !> Number of fields that are averaged over the points of a cell.
    procedure(count_interface), deferred :: fit_count
    !> Converts stress and state to fields that may be averaged (tensor logarithms, ...).
    procedure(to_fields_interface), deferred :: to_fields
    !> Converts averaged fields back.
    procedure(from_fields_interface), deferred :: from_fields
    !> Sets the share of the elastic tangent.
    procedure :: blend => set_blend
    !> Effective stress, where the stress of a point contains another part as well (pore water).
    procedure :: effective_stress => whole_stress
    !> Coupling derivatives of an updated point, where the law is nonlocal.
    procedure :: couple => couple_not
    procedure :: state_place
    !> Elastic shear modulus of a step.
    procedure :: shear_modulus => usual_shear
    !> Elastic shear compliance of a step, used in results to separate elastic and plastic strain.
    procedure :: shear_compliance => usual_compliance
  end type law_type

  !> A law of the model; the materials of the model are an array of these.
  type :: law_slot_type
    class(law_type), allocatable :: law
    !> Resistance to volume changes inside a group of uniform pressure, as a share of the law's shear
    !> modulus; 0 where every point has its own pressure.
    real(wp) :: pressure_factor = 0.0_wp
    !> The same in loading phases and in phases of TYPE=SAFETY, where they differ; negative where they do not.
    real(wp) :: factors(2) = -1.0_wp
    !> The material may yield: the resistance then decreases.
    logical :: flows = .false.
    !> All-round pressure p0; Q and A of `update` are in excess of it (`add_confinement`).
    real(wp) :: confinement = 0.0_wp
  contains
    !> Updates a batch by one step, including the all-round pressure.
    procedure :: update => update_confined
    !> Whether the tangent is symmetric for every state, including points with a common pressure.
    procedure :: is_symmetric => is_symmetric_slot
  end type law_slot_type

  abstract interface
    !> Initialises the state of a given Cauchy stress at volume ratio 1.
    subroutine start_interface(self, stress, place, state)
      import :: law_type, wp
      class(law_type), intent(in) :: self
      !> Cauchy stress (4 or 6), and position (3).
      real(wp), intent(in) :: stress(:), place(3)
      !> State (state_count).
      real(wp), intent(out) :: state(:)
    end subroutine start_interface

    !> Updates a batch. A point that cannot be updated gets a status, never a NaN.
    subroutine update_interface(self, batch, tangent)
      import :: law_type, batch_type
      class(law_type), intent(in) :: self
      type(batch_type), intent(inout) :: batch
      !> One of tangent_none, tangent_consistent, tangent_elastic.
      integer, intent(in) :: tangent
    end subroutine update_interface

    pure integer function count_interface(self)
      import :: law_type
      class(law_type), intent(in) :: self
    end function count_interface

    pure subroutine to_fields_interface(self, stress, state, fields)
      import :: law_type, wp
      class(law_type), intent(in) :: self
      real(wp), intent(in) :: stress(:), state(:)
      !> (fit_count)
      real(wp), intent(out) :: fields(:)
    end subroutine to_fields_interface

    pure subroutine from_fields_interface(self, fields, volume_ratio, stress, state)
      import :: law_type, wp
      class(law_type), intent(in) :: self
      real(wp), intent(in) :: fields(:), volume_ratio
      real(wp), intent(out) :: stress(:), state(:)
    end subroutine from_fields_interface
  end interface

  !> A law around an inner law, whose procedures it uses unless it overrides them.
  type, abstract, extends(law_type) :: outer_law_type
    class(law_type), allocatable :: law
  contains
    procedure :: start_at
    procedure :: blend
    procedure :: fit_count
    procedure :: to_fields
    procedure :: from_fields
  end type outer_law_type

contains

  !> Whether the tangent is symmetric; a resistance that decreases with plastic flow makes it unsymmetric.
  pure logical function is_symmetric_slot(self) result(symmetric)
    class(law_slot_type), intent(in) :: self

    symmetric = self%law%symmetric .and. .not. (self%flows .and. self%pressure_factor > 0.0_wp)
  end function is_symmetric_slot

  !> Updates a batch by one step of the law, with Q and A in excess of the all-round pressure.
  subroutine update_confined(self, batch, tangent)
    class(law_slot_type), intent(in) :: self
    type(batch_type), intent(inout) :: batch
    integer, intent(in) :: tangent
    integer :: p

    call self%law%update(batch, tangent)
    if (.not. abs(self%confinement) > 0.0_wp) return
    do p = 1, batch%count
      if (batch%status(p) /= status_ok) cycle
      if (tangent == tangent_none) then
        call add_confinement(self%confinement, batch%gradient(:, p), batch%piola(:, p))
      else
        call add_confinement(self%confinement, batch%gradient(:, p), batch%piola(:, p), batch%tangent(:, :, p))
      end if
    end do
  end subroutine update_confined

  !> Whether any law is nonlocal.
  pure logical function is_nonlocal(laws)
    type(law_slot_type), intent(in) :: laws(:)
    integer :: m

    is_nonlocal = any([(laws(m)%law%field_length > 0.0_wp, m=1, size(laws))])
  end function is_nonlocal

  !> Time at the start of a step.
  pure real(wp) function start_time(step_info) result(time)
    type(step_info_type), intent(in) :: step_info

    time = step_info%phase_start + step_info%start*step_info%phase_time
  end function start_time

  !> Duration of a step; not 0 at constant load, for models that divide by it.
  pure real(wp) function time_increment(step_info) result(increment)
    type(step_info_type), intent(in) :: step_info

    increment = max(held_duration, step_info%duration)*step_info%phase_time
  end function time_increment

  !> Initialises the state of a point at the usual position.
  subroutine start(self, stress, state)
    class(law_type), intent(in) :: self
    !> Cauchy stress (4 or 6).
    real(wp), intent(in) :: stress(:)
    !> State (state_count).
    real(wp), intent(out) :: state(:)

    call self%start_at(stress, self%usual_place, state)
  end subroutine start

  !> Leaves the strength unchanged: it does not depend on the stress.
  pure subroutine keep_strength(self, stress, state)
    class(law_type), intent(in) :: self
    !> Cauchy stress (4 or 6), and state (state_count).
    real(wp), intent(in) :: stress(:)
    real(wp), intent(inout) :: state(:)
  end subroutine keep_strength

  !> Names of state variables that are not written.
  pure function unnamed_states(count) result(names)
    integer, intent(in) :: count
    type(string_type) :: names(count)
    integer :: i

    do i = 1, count
      names(i)%text = ''
    end do
  end function unnamed_states

  !> Index of a state variable, 0 where the law has none of that name.
  pure integer function state_place(self, name) result(place)
    class(law_type), intent(in) :: self
    character(len=*), intent(in) :: name

    place = 0
    if (allocated(self%state_names)) place = word_place(self%state_names, name)
  end function state_place

  !> Sets the share of the elastic tangent.
  subroutine set_blend(self, share)
    class(law_type), intent(inout) :: self
    real(wp), intent(in) :: share

    self%elastic_blend = share
  end subroutine set_blend

  !> Effective stress equal to the total stress.
  pure function whole_stress(self, stress, state) result(effective)
    class(law_type), intent(in) :: self
    !> Cauchy stress (4 or 6), and state (state_count).
    real(wp), intent(in) :: stress(:), state(:)
    real(wp) :: effective(size(stress))

    effective = stress
  end function whole_stress

  !> Returns no coupling: the law is not nonlocal.
  pure subroutine couple_not(self, gradient, volume_ratio, cell_size, state_start, state, coupling)
    class(law_type), intent(in) :: self
    !> F, packed, V/V0 at the start, and size of the cell.
    real(wp), intent(in) :: gradient(:), volume_ratio, cell_size
    !> At the start and at the end of the step (state_count).
    real(wp), intent(in) :: state_start(:), state(:)
    type(field_coupling_type), intent(out) :: coupling

    associate (unused => self, unused_gradient => gradient, unused_ratio => volume_ratio, unused_size => cell_size, &
        unused_start => state_start, unused_state => state)
    end associate
    coupling = field_coupling_type()
  end subroutine couple_not

  !> G of a step that starts from a stress and a state: by default the one that scales the stabilisation.
  pure real(wp) function usual_shear(self, stress, state) result(shear)
    class(law_type), intent(in) :: self
    !> Effective stress (4 or 6), and state (state_count).
    real(wp), intent(in) :: stress(:), state(:)

    shear = self%shear_scale
  end function usual_shear

  !> Compliance c at the start and at the end of a step, with which c s' is the deviator of the elastic strain of the
  !> Cauchy stress s: 1/2G for linear elasticity in Cauchy stress.
  pure function usual_compliance(self, stress, state, volume_ratio, volume_change) result(compliance)
    class(law_type), intent(in) :: self
    !> Cauchy stress, state and V/V0 at the start, and the volume at the end over that at the start (4 or 6).
    real(wp), intent(in) :: stress(:), state(:), volume_ratio, volume_change
    real(wp) :: compliance(2)

    compliance = 0.5_wp/self%shear_modulus(stress, state)
  end function usual_compliance

  !> Adds the pressure to Q and, if present, its derivative to A.
  pure subroutine add_confinement(pressure, gradient, piola, tangent)
    !> p0, compression positive.
    real(wp), intent(in) :: pressure
    !> F and Q, packed (5 or 9).
    real(wp), intent(in) :: gradient(:)
    real(wp), intent(inout) :: piola(:)
    !> (5 or 9, 5 or 9)
    real(wp), intent(inout), optional :: tangent(:, :)
    real(wp), dimension(size(gradient)) :: here, moved, along
    integer :: j

    call pack_gradient(cofactor(unpack_gradient(gradient)), here)
    piola = piola + pressure*here
    if (.not. present(tangent)) return
    do j = 1, size(gradient)
      ! cof F is quadratic, but linear in a single component: the difference is the exact derivative.
      along = gradient
      along(j) = along(j) + 1.0_wp
      call pack_gradient(cofactor(unpack_gradient(along)), moved)
      tangent(:, j) = tangent(:, j) + pressure*(moved - here)
    end do
  end subroutine add_confinement

  !> Sets the share of the elastic tangent of the inner law.
  subroutine blend(self, share)
    class(outer_law_type), intent(inout) :: self
    real(wp), intent(in) :: share

    self%elastic_blend = share
    call self%law%blend(share)
  end subroutine blend

  !> Initialises the state of a point.
  subroutine start_at(self, stress, place, state)
    class(outer_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), place(3)
    real(wp), intent(out) :: state(:)

    call self%law%start_at(stress, place, state)
  end subroutine start_at

  !> Number of fields that are averaged.
  pure integer function fit_count(self)
    class(outer_law_type), intent(in) :: self

    fit_count = self%law%fit_count()
  end function fit_count

  !> Converts stress and state to fields.
  pure subroutine to_fields(self, stress, state, fields)
    class(outer_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), state(:)
    real(wp), intent(out) :: fields(:)

    call self%law%to_fields(stress, state, fields)
  end subroutine to_fields

  !> Converts fields to stress and state.
  pure subroutine from_fields(self, fields, volume_ratio, stress, state)
    class(outer_law_type), intent(in) :: self
    real(wp), intent(in) :: fields(:), volume_ratio
    real(wp), intent(out) :: stress(:), state(:)

    call self%law%from_fields(fields, volume_ratio, stress, state)
  end subroutine from_fields
end module qsmpm_law
