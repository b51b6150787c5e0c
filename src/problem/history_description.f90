!> What of an analysis is recorded: histories and files of results.
module qsmpm_history_description
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: named_type
  use qsmpm_source_line, only: source_line_type
  implicit none
  private

  public :: history_type, output_request_type

  !> What a history records: rows of `history_quantities` (qsmpm_history_quantities).
  integer, parameter, public :: quantity_displacement = 1, quantity_position = 2, quantity_stress = 3, &
    quantity_reaction = 4, quantity_state = 5, quantity_strain = 6, quantity_volume = 7, quantity_runout = 8, &
    quantity_pore_pressure = 9, quantity_contact_force = 10, quantity_contact_moment = 11, quantity_body_move = 12, &
    quantity_contact_pressure = 13, quantity_body_rotation = 14, quantity_contact_slip = 15, &
    quantity_prop_force = 16, quantity_time = 17, quantity_excess_pressure = 18, &
    quantity_discharge = 19

  !> A column of curves.csv.
  type, extends(named_type) :: history_type
    character(len=:), allocatable :: unit
    type(source_line_type) :: where
    integer :: quantity = quantity_displacement
    !> 1..3 for vectors; 1..6 (11,22,33,12,13,23) for stress.
    integer :: component = 1
    !> Start position of the massless tracer, or where the nearest material point is sought.
    real(wp) :: at(3) = 0.0_wp
    !> quantity_reaction: the node set, or the supported surface; quantity_discharge: that of a row of *WATER LEVEL.
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

  !> Which results are written, and how often (in accepted steps; 0 means at phase ends only).
  type :: output_request_type
    integer :: field_every = 0
    integer :: restart_every = 0
    !> VTK pictures and HDF5 results can be switched off for studies.
    logical :: vtk = .true., hdf5 = .true.
    !> The material points carry strains.
    logical :: strains = .true.
  end type output_request_type
end module qsmpm_history_description
