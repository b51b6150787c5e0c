!> Loads and constraints of a phase as defined in a deck: fixities, prescribed displacements, tractions, supports,
!> gravity, water levels.
module qsmpm_load_description
  use qsmpm_kinds, only: wp
  use qsmpm_seepage_field, only: seepage_field_type
  use qsmpm_source_line, only: source_line_type
  implicit none
  private

  public :: fixity_type, prescription_type, traction_type, support_type, gravity_type, water_level_type, head_type, &
    consolidation_type, drainage_type

  !> Support of a surface: none, no displacement along its normal, no displacement.
  integer, parameter, public :: support_none = 0, support_normal = 1, support_all = 2
  !> Carrier of a traction: tracked surface points, or the outermost material points (paper, 3.1).
  integer, parameter, public :: carrier_surface = 1, carrier_points = 2

  !> Fixed or released components of a node set.
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

  !> Load on a surface per unit load factor: a dead traction, force per undeformed area, or a pressure that follows
  !> area and normal.
  type :: traction_type
    character(len=:), allocatable :: surface
    type(source_line_type) :: where
    logical :: follows = .false.
    real(wp) :: vector(3) = 0.0_wp
    real(wp) :: pressure = 0.0_wp
    !> Pressure gradient per length downwards, and the height at which the pressure is `pressure`.
    real(wp) :: gradient = 0.0_wp, height = 0.0_wp
    !> Whether it is a water pressure, which is zero above the height.
    logical :: of_water = .false.
    integer :: carrier = carrier_surface
  end type traction_type

  !> Support of a surface on the plane in which it is, full support, or release.
  type :: support_type
    character(len=:), allocatable :: surface
    type(source_line_type) :: where
    integer :: kind = support_normal
    !> Whether the surface is the outline of a cavity that contracts by this percentage of its area per unit load
    !> factor; whether its centre is fixed, otherwise it is free to move vertically as a whole.
    logical :: contracts = .false., held = .false.
    real(wp) :: volume_loss = 0.0_wp
  end type support_type

  !> Gravity per unit load factor; multiplies the unit weight.
  type :: gravity_type
    logical :: given = .false.
    real(wp) :: vector(3) = 0.0_wp
  end type gravity_type

  !> Water level at a part of the boundary of a seepage domain.
  type :: head_type
    !> Node set or surface.
    character(len=:), allocatable :: set
    !> Elevation, as a coordinate; rainfall above it as volume per horizontal area and time.
    real(wp) :: level = 0.0_wp, rain = 0.0_wp
    !> Inflow per unit time, for unit thickness or per radian; computed with the field of the level.
    real(wp) :: inflow = 0.0_wp
    type(source_line_type) :: where
  end type head_type

  !> Ground water level from a phase on, of one body or of all bodies without a level of their own.
  type :: water_level_type
    !> Name of the body, empty for all.
    character(len=:), allocatable :: body
    type(source_line_type) :: where
    !> Whether the level is removed.
    logical :: none = .false.
    !> Unit weight of water, multiplied by *GRAVITY. Negative: not given.
    real(wp) :: unit_weight = -1.0_wp
    !> Horizontal coordinate and height of the vertices of the level (2,n).
    real(wp), allocatable :: line(:, :)
    !> Whether the pressure results from seepage between the levels at the boundary; the field is computed for the
    !> initial geometry of the bodies of the phase when the model is built (qsmpm_seepage_scene).
    logical :: flows = .false.
    !> Whether seepage is transient, starting from the previous flow.
    logical :: transient = .false.
    !> Whether the soil consolidates, so that the pressure is an unknown (qsmpm_pore_flow); there is then no separate
    !> field.
    logical :: coupled = .false.
    type(head_type), allocatable :: heads(:)
    type(seepage_field_type), allocatable :: field
  end type water_level_type

  !> A node set that is open (drained) or closed for excess pore pressure.
  type :: drainage_type
    character(len=:), allocatable :: name
    logical :: closed = .false.
    type(source_line_type) :: where
  end type drainage_type

  !> Consolidation from a phase on.
  type :: consolidation_type
    logical :: given = .false.
    type(source_line_type) :: where
    !> Unit weight of water; negative: not given. Compressibility of water and grains.
    real(wp) :: unit_weight = -1.0_wp, storage = 0.0_wp
    !> Whether the pressure at drained boundary nodes is zero from the first step on, as in other programs.
    logical :: held = .false.
    type(drainage_type), allocatable :: sets(:)
  end type consolidation_type
end module qsmpm_load_description
