!> What stands in the ground beside the bodies of soil, as a deck says it: rigid bodies, where they touch the
!> soil, their motions and loads, and props.
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
  !> Where contact is asked for: on a surface of the soil, or on the outline of the rigid body.
  integer, parameter, public :: contact_on_soil = 1, contact_on_body = 2
  !> What contact is asked for on in the mean: what a cell holds of a surface, or every point by itself.
  integer, parameter, public :: patch_cell = 1, patch_point = 2

  !> A body that does not deform and that surfaces of the soil may touch.
  type, extends(named_type) :: rigid_body_type
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

  !> Motion of a rigid body in the phase, or the load in one component in which it is free, per unit of load factor; the
  !> rotation is about its reference point, axis times angle in degrees.
  type :: rigid_move_type
    character(len=:), allocatable :: body
    type(source_line_type) :: where
    real(wp) :: vector(3) = 0.0_wp, rotation(3) = 0.0_wp
    logical :: is_load = .false.
    !> Axis of the force, or 4 for a moment about z, and its value.
    integer :: component = 1
    real(wp) :: load = 0.0_wp
    !> Place of the body in which the force acts, as drawn, and which of its coordinates are given; else the reference
    !> point.
    real(wp) :: place(2) = 0.0_wp
    logical :: placed(2) = .false.
  end type rigid_move_type

  !> A spring between two places of the ground, or from one to a place that is fixed.
  type, extends(named_type) :: prop_type
    type(source_line_type) :: where
    !> As drawn (3, ends); the second one does not move.
    real(wp) :: places(3, 2) = 0.0_wp
    logical :: fixed = .false.
    !> Force over change of length, and largest force of compression and of tension.
    real(wp) :: stiffness = 0.0_wp, limits(2) = huge(1.0_wp)
  end type prop_type

  !> A prop that a phase installs or removes, and the force it is jacked to, tension positive, per unit of load factor.
  type :: prop_change_type
    character(len=:), allocatable :: prop
    type(source_line_type) :: where
    logical :: jacked = .false.
    real(wp) :: force = 0.0_wp
  end type prop_change_type
end module qsmpm_structures
