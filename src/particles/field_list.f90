!> List of the fields of sets that move with the material: name, unit, number and kind of components, outputs that
!> contain the field, and its location in memory. Procedures that treat all fields alike (checkpoint, restart, checks,
!> results, plots, named values, expansion of reduced models) loop over such a list and contain no names of fields.
!>
!> A stored field is accessed by a pointer to its array, a table (components, n) or a row of integers, short or long;
!> the list is valid as long as its owner exists. A derived field, computed from others, has its own values. The fields
!> are defined by `list_fields` and `list_made_fields` of qsmpm_points.
module qsmpm_field_list
  use qsmpm_kinds, only: wp, long
  use qsmpm_text, only: replaced
  implicit none
  private

  public :: field_type, field_list_type, row_components

  !> Kinds of fields: how a field is transformed if a point of a reduced model is mirrored, rotated or replicated. A
  !> number is the same for every image; an amount is divided among the images; a position is that of the image; vectors
  !> and symmetric tensors (11, 22, 33, 12, 13, 23) are transformed with it; a label is an integer; an internal field
  !> has a meaning only in the cell, or for the law, of its own point and is not copied.
  integer, parameter, public :: kind_number = 1, kind_amount = 2, kind_position = 3, kind_vector = 4, kind_tensor = 5, &
    kind_label = 6, kind_internal = 7
  character(len=*), parameter, public :: kind_names(7) = [character(len=16) :: 'number', 'amount', 'position', &
    'vector', 'symmetric tensor', 'label', 'internal']

  !> Outputs of a field in addition to checkpoint and restart: none; named values; results and plots; all of them.
  integer, parameter, public :: shown_nowhere = 0, shown_by_name = 1, shown_in_results = 2, shown_everywhere = 3

  !> Units in terms of length L and force F.
  character(len=*), parameter, public :: unit_none = '', unit_length = 'L', unit_area = 'L2', unit_volume = 'L3', &
    unit_force = 'F', unit_stress = 'F/L2'

  integer, parameter, public :: field_name_length = 40

  !> A field; `reals`, `made`, `labels` or `numbers` contains its values.
  type :: field_type
    character(len=field_name_length) :: name = ''
    character(len=8) :: unit = ''
    integer :: kind = kind_internal
    integer :: shown = shown_nowhere
    !> Description for the table of fields; empty for fields that are not output.
    character(len=160) :: meaning = ''
    !> One number per point, stored as a row.
    logical :: is_row = .false.
    !> Array of a stored field (components, n), (n).
    real(wp), pointer, contiguous :: reals(:, :) => null()
    integer, pointer, contiguous :: labels(:) => null()
    integer(long), pointer, contiguous :: numbers(:) => null()
    !> Values of a derived field (components, n).
    real(wp), allocatable :: made(:, :)
  contains
    procedure :: get_values
    procedure :: component_count
    procedure :: point_count
    procedure :: spoken
  end type field_type

  !> Fields in the order in which they were added.
  type :: field_list_type
    integer :: count = 0
    type(field_type), allocatable :: fields(:)
  contains
    procedure :: add
    procedure :: add_made
    procedure :: find
  end type field_list_type

contains

  !> Adds a stored field: one number per point (row) or several (table), integers, short or long; null if not allocated.
  subroutine add(self, name, kind, shown, unit, meaning, row, table, labels, numbers)
    class(field_list_type), intent(inout) :: self
    character(len=*), intent(in) :: name
    !> One of the kind_* values, and one of the shown_* values.
    integer, intent(in) :: kind
    integer, intent(in), optional :: shown
    character(len=*), intent(in), optional :: unit, meaning
    !> Exactly one of these.
    real(wp), allocatable, intent(in), target, optional :: row(:), table(:, :)
    integer, allocatable, intent(in), target, optional :: labels(:)
    integer(long), allocatable, intent(in), target, optional :: numbers(:)

    call append(self, name, kind, shown, unit, meaning)
    associate (field => self%fields(self%count))
      field%is_row = .not. present(table)
      if (present(row)) then
        if (allocated(row)) field%reals(1:1, 1:size(row)) => row
      else if (present(table)) then
        if (allocated(table)) field%reals => table
      else if (present(labels)) then
        if (allocated(labels)) field%labels => labels
      else if (allocated(numbers)) then
        field%numbers => numbers
      end if
    end associate
  end subroutine add

  !> Adds a derived field, which stores its values.
  subroutine add_made(self, name, values, kind, shown, unit, meaning)
    class(field_list_type), intent(inout) :: self
    character(len=*), intent(in) :: name
    !> (components, n); deallocated on return.
    real(wp), allocatable, intent(inout) :: values(:, :)
    integer, intent(in) :: kind, shown
    character(len=*), intent(in), optional :: unit, meaning

    call append(self, name, kind, shown, unit, meaning)
    self%fields(self%count)%is_row = row_components(kind) == 1
    call move_alloc(values, self%fields(self%count)%made)
  end subroutine add_made

  !> Appends a field with its properties.
  subroutine append(list, name, kind, shown, unit, meaning)
    type(field_list_type), intent(inout) :: list
    character(len=*), intent(in) :: name
    integer, intent(in) :: kind
    integer, intent(in), optional :: shown
    character(len=*), intent(in), optional :: unit, meaning
    type(field_type), allocatable :: longer(:)
    integer :: i

    if (.not. allocated(list%fields)) allocate (list%fields(32))
    if (list%count == size(list%fields)) then
      allocate (longer(2*list%count))
      do i = 1, list%count
        longer(i) = list%fields(i)
      end do
      call move_alloc(longer, list%fields)
    end if
    list%count = list%count + 1
    associate (field => list%fields(list%count))
      field%name = name
      field%kind = kind
      if (present(shown)) field%shown = shown
      if (present(unit)) field%unit = unit
      if (present(meaning)) field%meaning = meaning
    end associate
  end subroutine append

  !> Number of the field with a given name, 0 if there is none.
  pure integer function find(self, name)
    class(field_list_type), intent(in) :: self
    character(len=*), intent(in) :: name

    do find = self%count, 1, -1
      if (self%fields(find)%name == name) return
    end do
  end function find

  !> Number of components of a kind in results: three for a vector, six for a symmetric tensor, padded with zeros in 2D.
  pure integer function row_components(kind)
    integer, intent(in) :: kind

    select case (kind)
    case (kind_position, kind_vector)
      row_components = 3
    case (kind_tensor)
      row_components = 6
    case default
      row_components = 1
    end select
  end function row_components

  !> Number of stored components; 0 if there are no values.
  pure integer function component_count(self)
    class(field_type), intent(in) :: self

    component_count = 0
    if (allocated(self%made)) component_count = size(self%made, 1)
    if (associated(self%reals)) component_count = size(self%reals, 1)
    if (associated(self%labels) .or. associated(self%numbers)) component_count = 1
  end function component_count

  !> Number of points with values; 0 for a field that is not stored.
  pure integer function point_count(self)
    class(field_type), intent(in) :: self

    point_count = 0
    if (allocated(self%made)) point_count = size(self%made, 2)
    if (associated(self%reals)) point_count = size(self%reals, 2)
    if (associated(self%labels)) point_count = size(self%labels)
    if (associated(self%numbers)) point_count = size(self%numbers)
  end function point_count

  !> Name with blanks instead of underscores, for messages.
  pure function spoken(self) result(text)
    class(field_type), intent(in) :: self
    character(len=:), allocatable :: text

    text = replaced(trim(self%name), '_', ' ')
  end function spoken

  !> Returns a copy of the values as reals, padded with zeros.
  pure subroutine get_values(self, components, values)
    class(field_type), intent(in) :: self
    !> Number of components, at least that of the field.
    integer, intent(in) :: components
    !> (components, n)
    real(wp), allocatable, intent(out) :: values(:, :)
    integer :: n

    n = self%component_count()
    allocate (values(components, self%point_count()))
    values(n + 1:, :) = 0.0_wp
    if (allocated(self%made)) values(:n, :) = self%made
    if (associated(self%reals)) values(:n, :) = self%reals
    if (associated(self%labels)) values(1, :) = real(self%labels, wp)
    if (associated(self%numbers)) values(1, :) = real(self%numbers, wp)
  end subroutine get_values
end module qsmpm_field_list
