!> What stands in the ground beside the bodies of soil, as a deck says it: motions and loads of rigid bodies, props.
module qsmpm_structures
  use qsmpm_kinds, only: wp
  use qsmpm_source_line, only: source_line_type
  implicit none
  private

  public :: rigid_move_type, prop_type, prop_change_type

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
  type :: prop_type
    character(len=:), allocatable :: name
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
