!> Requested results of an analysis: histories and result files.
module qsmpm_history_description
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: named_type
  use qsmpm_source_line, only: source_line_type
  implicit none
  private

  public :: history_type, output_request_type

  !> Quantities of a history: rows of `history_quantities` (qsmpm_history_quantities).
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
    !> Initial position of the massless tracer, or location for the selection of the nearest material point.
    real(wp) :: at(3) = 0.0_wp
    !> quantity_reaction: node set or supported surface; quantity_discharge: node set or surface of a *WATER LEVEL row.
    character(len=:), allocatable :: set, surface
    !> Quantities of a body: name of the body, empty for all bodies.
    character(len=:), allocatable :: body
    !> quantity_prop_force: name of the prop.
    character(len=:), allocatable :: prop
    !> quantity_runout: whether the front is at the smallest coordinate instead of the largest.
    logical :: smallest = .false.
    !> quantity_contact_slip: whether the mean over the points in contact is taken instead of the largest.
    logical :: mean = .false.
    !> quantity_state: name of the state variable in the results, or its number.
    character(len=:), allocatable :: state
    real(wp) :: scale = 1.0_wp
  end type history_type

  !> Requested result files and their interval (in accepted steps; 0: at phase ends only).
  type :: output_request_type
    integer :: field_every = 0
    integer :: restart_every = 0
    !> VTK and HDF5 results; can be disabled for studies.
    logical :: vtk = .true., hdf5 = .true.
    !> Whether the material points store strains.
    logical :: strains = .true.
  end type output_request_type
end module qsmpm_history_description
