!> Loads and constraints of a phase as a deck describes them: fixities, prescribed displacements, tractions, supports,
!> gravity, water levels.
module qsmpm_load_description
  use qsmpm_kinds, only: wp
  use qsmpm_seepage_field, only: seepage_field_type
  use qsmpm_source_line, only: source_line_type
  implicit none
  private

  public :: fixity_type, prescription_type, traction_type, support_type, gravity_type, water_level_type, head_type, &
    consolidation_type, drainage_type

  !> Support of a surface: none, no motion along its normal, no motion.
  integer, parameter, public :: support_none = 0, support_normal = 1, support_all = 2
  !> Who carries a traction: tracked surface points, or the outermost material points (paper, 3.1).
  integer, parameter, public :: carrier_surface = 1, carrier_points = 2

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

  !> Level of the free water at a part of the bounds of ground that water flows through.
  type :: head_type
    !> Node set or surface.
    character(len=:), allocatable :: set
    !> Height as a coordinate, and rain above it: a volume a unit of level area and time.
    real(wp) :: level = 0.0_wp, rain = 0.0_wp
    !> What flows in there a unit of time, of a slice of unit width or a radian; found with the field of the level.
    real(wp) :: inflow = 0.0_wp
    type(source_line_type) :: where
  end type head_type

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
    !> The water flows, and its pressure is found from the levels at the bounds; the field is that of the bodies of its
    !> phase as they are drawn, and is there when the model is built (qsmpm_seepage_scene).
    logical :: flows = .false.
    !> In time, from the flow before.
    logical :: transient = .false.
    !> In ground that consolidates, whose equations have its pressure (qsmpm_pore_flow); there is no field then.
    logical :: coupled = .false.
    type(head_type), allocatable :: heads(:)
    type(seepage_field_type), allocatable :: field
  end type water_level_type

  !> A node set that is open to the excess pore pressure, or closed.
  type :: drainage_type
    character(len=:), allocatable :: name
    logical :: closed = .false.
    type(source_line_type) :: where
  end type drainage_type

  !> Pore water that flows in time, from a phase on.
  type :: consolidation_type
    logical :: given = .false.
    type(source_line_type) :: where
    !> Weight of water per volume; negative: not given. Compressibility of water and grains.
    real(wp) :: unit_weight = -1.0_wp, storage = 0.0_wp
    !> Nodes of faces have no pressure from the first step on, as in other programs.
    logical :: held = .false.
    type(drainage_type), allocatable :: sets(:)
  end type consolidation_type
end module qsmpm_load_description
