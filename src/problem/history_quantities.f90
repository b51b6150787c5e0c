!> Table of the quantities of *HISTORY: one row per quantity with its location, components and unit. The row number is
!> the quantity in the analysis; quantities used by name elsewhere are constants of qsmpm_history_description.
module qsmpm_history_quantities
  use qsmpm_analysis, only: analysis_type, axisymmetric, plane_strain
  use qsmpm_history_description, only: history_type
  implicit none
  private

  public :: history_quantity_type, is_taken_at, is_carried, has_components, component_number, unit_of_history

  !> Locations of quantities: massless tracer; nearest material point; sum over a node set or a supported surface;
  !> points of a body or of all bodies; rigid body; nearest surface point of a contact; prop; the run as a whole.
  integer, parameter, public :: at_tracer = 1, at_point = 2, at_support = 3, at_body = 4, &
    at_rigid_body = 5, at_contact = 6, at_prop = 7, at_run = 8
  !> Kinds of components of a quantity.
  integer, parameter, public :: component_none = 0, component_vector = 1, component_tensor = 2

  type :: history_quantity_type
    character(len=16) :: word
    integer :: place
    integer :: components
    !> L length, F force, M moment, V volume, S stress, A angle, Q volume per time; blank for a dimensionless number.
    character(len=1) :: unit
    !> Whether every process of a team has the complete value, which the first one then reports; otherwise each process
    !> reports its contribution.
    logical :: known_to_all = .false.
    !> Whether reductions of a scene (reduction/) and its division among processes support the quantity; scenes with
    !> unsupported quantities are neither reduced nor divided.
    logical :: carried = .false.
  end type history_quantity_type

  type(history_quantity_type), parameter, public :: history_quantities(19) = [ &
    history_quantity_type('DISPLACEMENT', at_tracer, component_vector, 'L', .true., .true.), &
    history_quantity_type('POSITION', at_tracer, component_vector, 'L', .true., .true.), &
    history_quantity_type('STRESS', at_point, component_tensor, 'S', .false., .true.), &
    history_quantity_type('REACTION', at_support, component_vector, 'F', .false., .true.), &
    history_quantity_type('STATE', at_point, component_none, ' ', .false., .true.), &
    history_quantity_type('STRAIN', at_point, component_tensor, ' ', .false., .true.), &
    history_quantity_type('VOLUME', at_body, component_none, 'V', .false., .true.), &
    history_quantity_type('RUNOUT', at_body, component_vector, 'L', .false., .true.), &
    history_quantity_type('PORE PRESSURE', at_point, component_none, 'S', .false., .true.), &
    history_quantity_type('CONTACT FORCE', at_rigid_body, component_vector, 'F', .true., .true.), &
    history_quantity_type('CONTACT MOMENT', at_rigid_body, component_none, 'M', .true., .true.), &
    history_quantity_type('BODY MOVE', at_rigid_body, component_vector, 'L', .true., .true.), &
    history_quantity_type('CONTACT PRESSURE', at_contact, component_none, 'S', .false., .true.), &
    history_quantity_type('BODY ROTATION', at_rigid_body, component_none, 'A', .true., .true.), &
    history_quantity_type('CONTACT SLIP', at_rigid_body, component_none, 'L', .false., .true.), &
    history_quantity_type('PROP FORCE', at_prop, component_none, 'F', .true., .true.), &
    history_quantity_type('TIME', at_run, component_none, ' ', .true., .true.), &
    history_quantity_type('EXCESS PRESSURE', at_run, component_none, 'S', .true., .true.), &
    history_quantity_type('DISCHARGE', at_run, component_none, 'Q', .true., .true.)]

contains

  !> Returns whether a quantity has a location of this kind.
  elemental logical function is_taken_at(quantity, place)
    !> Row of the table, 0 for none; one of the at_* values.
    integer, intent(in) :: quantity, place

    is_taken_at = .false.
    if (quantity >= 1 .and. quantity <= size(history_quantities)) &
      is_taken_at = history_quantities(quantity)%place == place
  end function is_taken_at

  !> Returns whether reductions and division support a quantity; false for no row.
  elemental logical function is_carried(quantity)
    integer, intent(in) :: quantity

    is_carried = quantity >= 1 .and. quantity <= size(history_quantities)
    if (is_carried) is_carried = history_quantities(quantity)%carried
  end function is_carried

  !> Returns whether a quantity has components of this kind.
  elemental logical function has_components(quantity, components)
    !> Row of the table, 0 for none; one of the component_* values.
    integer, intent(in) :: quantity, components

    has_components = .false.
    if (quantity >= 1 .and. quantity <= size(history_quantities)) &
      has_components = history_quantities(quantity)%components == components
  end function has_components

  !> Returns the largest component number in a model of 2 or 3 dimensions.
  elemental integer function component_number(quantity, dimension) result(number)
    integer, intent(in) :: quantity, dimension

    number = 0
    if (has_components(quantity, component_vector)) number = dimension
    if (has_components(quantity, component_tensor)) number = merge(6, 4, dimension == 3)
  end function component_number

  !> Returns the unit of a history: its assigned unit, otherwise that of its quantity.
  pure function unit_of_history(analysis, history) result(unit)
    type(analysis_type), intent(in) :: analysis
    type(history_type), intent(in) :: history
    character(len=:), allocatable :: unit

    unit = ''
    if (allocated(history%unit)) unit = history%unit
    if (len(unit) == 0) unit = default_unit(analysis, history%quantity)
  end function unit_of_history

  !> Returns the unit of a quantity from the units of the analysis; forces and volumes in plane models are per unit
  !> thickness or per radian. '-' if it has none or the analysis defines no units.
  pure function default_unit(analysis, quantity) result(unit)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: quantity
    character(len=:), allocatable :: unit

    unit = '-'
    if (quantity >= 1) then
      if (history_quantities(quantity)%unit == 'A') unit = 'degree'
    end if
    if (.not. (allocated(analysis%length_unit) .and. allocated(analysis%force_unit))) return
    if (analysis%force_unit == '-' .or. quantity < 1) return
    select case (history_quantities(quantity)%unit)
    case ('L')
      unit = analysis%length_unit
    case ('S')
      unit = analysis%force_unit//'/'//analysis%length_unit//'2'
    case ('F')
      unit = analysis%force_unit
      if (analysis%model == axisymmetric) unit = unit//'/rad'
      if (analysis%model == plane_strain) unit = unit//'/'//analysis%length_unit
    case ('M')
      unit = analysis%force_unit//' '//analysis%length_unit
      if (analysis%model == axisymmetric) unit = unit//'/rad'
      if (analysis%model == plane_strain) unit = unit//'/'//analysis%length_unit
    case ('V', 'Q')
      unit = analysis%length_unit//'3'
      if (analysis%model == axisymmetric) unit = unit//'/rad'
      if (analysis%model == plane_strain) unit = analysis%length_unit//'2'
      if (history_quantities(quantity)%unit == 'Q') unit = unit//'/time'
    end select
  end function default_unit
end module qsmpm_history_quantities
