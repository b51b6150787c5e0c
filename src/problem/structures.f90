!> Structures in the soil as defined in a deck: rigid bodies, their contact with the soil, their motions and loads, and
!> props.
module qsmpm_structures
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: named_type
  use qsmpm_source_line, only: source_line_type
  implicit none
  private

  public :: rigid_body_type, contact_type, rigid_move_type, prop_type, prop_change_type

  !> Shapes of rigid bodies.
  integer, parameter, public :: rigid_plane = 1, rigid_circle = 2, rigid_box = 3, rigid_cone = 4, rigid_polygon = 5, &
    rigid_cylinder = 6
  !> Location of the contact condition: a surface of the soil, or the outline of the rigid body.
  integer, parameter, public :: contact_on_soil = 1, contact_on_body = 2
  !> Contact condition in the mean over the part of a surface in a cell, or at every point.
  integer, parameter, public :: patch_cell = 1, patch_point = 2

  !> A rigid body that may be in contact with surfaces of the soil.
  type, extends(named_type) :: rigid_body_type
    type(source_line_type) :: where
    !> One of rigid_*.
    integer :: shape = rigid_circle
    !> Point of a plane, centre of a circle, tip of a cone, centre of the base of a cylinder; direction of a plane
    !> towards the soil.
    real(wp) :: place(3) = 0.0_wp, direction(3) = 0.0_wp
    !> Radius of a circle, a cylinder or the shaft of a cone; apex angle in degrees; length of the shaft or cylinder.
    real(wp) :: radius = 0.0_wp, apex_angle = 60.0_wp, shaft = 0.0_wp
    !> Lower and upper corner (3,2).
    real(wp) :: box(3, 2) = 0.0_wp
    !> Vertices (2,n).
    real(wp), allocatable :: polygon(:, :)
    !> Radius of rounded corners; negative for a fraction of the cell size.
    real(wp) :: round = -1.0_wp
    !> Initial rotation of a box in 3D about its centre: axis times angle in degrees.
    real(wp) :: rotation(3) = 0.0_wp
    !> Whether soil inside its initial geometry is removed at the start.
    logical :: in_place = .false.
  end type rigid_body_type

  !> Contact between a surface of the soil, or any soil, and a rigid body.
  type :: contact_type
    !> No surface if the contact condition is on the rigid body.
    character(len=:), allocatable :: body, surface
    !> One of contact_on_*.
    integer :: place = contact_on_soil
    type(source_line_type) :: where
    !> Strength of the interface: friction angle in degrees; shear strength at zero pressure.
    real(wp) :: friction_angle = 0.0_wp, adhesion = 0.0_wp
    !> Alternative strength of the interface as a fraction of the soil strength; negative for none.
    real(wp) :: interface = -1.0_wp
    !> Penalty of the gap times cell size over Young's modulus; negative for the default.
    real(wp) :: penalty = -1.0_wp
    !> One of patch_*.
    integer :: patch = patch_cell
    !> Whether the surfaces cannot separate.
    logical :: tension = .false.
  end type contact_type

  !> Motion of a rigid body in the phase, or load in a free component, per unit load factor; the rotation is about its
  !> reference point, axis times angle in degrees.
  type :: rigid_move_type
    character(len=:), allocatable :: body
    type(source_line_type) :: where
    real(wp) :: vector(3) = 0.0_wp, rotation(3) = 0.0_wp
    logical :: is_load = .false.
    !> Axis of the force, or 4 for a moment about z; its value.
    integer :: component = 1
    real(wp) :: load = 0.0_wp
    !> Initial location of the point of application of the force and which of its coordinates are given; the reference
    !> point by default.
    real(wp) :: place(2) = 0.0_wp
    logical :: placed(2) = .false.
  end type rigid_move_type

  !> A spring between two points of the soil, or between one and a fixed point.
  type, extends(named_type) :: prop_type
    type(source_line_type) :: where
    !> Initial end points (3, ends); the second one may be fixed.
    real(wp) :: places(3, 2) = 0.0_wp
    logical :: fixed = .false.
    !> Force per change of length; largest compression and tension force.
    real(wp) :: stiffness = 0.0_wp, limits(2) = huge(1.0_wp)
  end type prop_type

  !> Installation or removal of a prop by a phase; prestress force, tension positive, per unit load factor.
  type :: prop_change_type
    character(len=:), allocatable :: prop
    type(source_line_type) :: where
    logical :: jacked = .false.
    real(wp) :: force = 0.0_wp
  end type prop_change_type
end module qsmpm_structures
