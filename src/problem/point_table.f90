!> Tables of targets for a point test: a CSV file whose first line names the prescribed quantities, `e22 [%],s11
!> [kPa]`, and whose other lines are consecutive targets. A column named `time` gives the time of each target; columns
!> `step` and `phase` are ignored.
module qsmpm_point_table
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, error_deck, fail
  use qsmpm_text, only: replaced, string_type, upper, stripped, squeezed, split, without_return, read_real, newline, &
    integer_text, number_good
  use qsmpm_point_test, only: driven_words, driven_stress, driven_axial_stress, driven_deviator, driven_cell_pressure, &
    driven_shear_stress, driven_normal_stress, driven_pressure
  implicit none
  private

  public :: parse_targets, unit_factor

  !> Supported units of stress, with their factors to Pa.
  character(len=8), parameter :: stress_units(10) = [character(len=8) :: 'Pa', 'kPa', 'MPa', 'GPa', 'N/m^2', &
    'kN/m^2', 'MN/m^2', 'N/mm^2', 'N/cm^2', 'bar']
  real(wp), parameter :: pascals(10) = [1.0_wp, 1.0e3_wp, 1.0e6_wp, 1.0e9_wp, 1.0_wp, 1.0e3_wp, 1.0e6_wp, 1.0e6_wp, &
    1.0e4_wp, 1.0e5_wp]

contains

  !> Returns whether a quantity is a stress.
  pure logical function is_stress(driven)
    !> One of driven_*.
    integer, intent(in) :: driven

    is_stress = driven > driven_stress .or. any(driven == [driven_axial_stress, driven_deviator, driven_cell_pressure, &
      driven_shear_stress, driven_normal_stress, driven_pressure])
  end function is_stress

  !> Reads the targets of a table.
  pure subroutine parse_targets(path, text, stress_unit, driven_components, targets, times, error)
    !> Path of the file, for messages.
    character(len=*), intent(in) :: path
    !> Content of the file.
    character(len=*), intent(in) :: text
    !> Unit of stress of the deck, FORCE/LENGTH^2.
    character(len=*), intent(in) :: stress_unit
    !> Prescribed quantities, one of driven_* per column.
    integer, allocatable, intent(out) :: driven_components(:)
    !> Targets in the deck's units (column, row).
    real(wp), allocatable, intent(out) :: targets(:, :)
    !> Time of each row from the start of the stage; unallocated without a time column.
    real(wp), allocatable, intent(out) :: times(:)
    !> Set when the table has errors.
    type(error_type), allocatable, intent(out) :: error
    type(string_type), allocatable :: lines(:), cells(:)
    integer, allocatable :: column(:), places(:)
    real(wp), allocatable :: factor(:)
    real(wp) :: time(1)
    integer :: i, row, time_column

    call split(text, newline, lines)
    allocate (places(0))
    do i = 1, size(lines)
      if (len(stripped(without_return(lines(i)%text))) > 0) places = [places, i]
    end do
    if (size(places) < 2) then
      call fail(error, error_deck, path//': a line of headings and a row of targets are required')
      return
    end if
    call parse_head(path, without_return(lines(places(1))%text), stress_unit, driven_components, column, factor, &
      time_column, error)
    if (allocated(error)) return
    allocate (targets(size(driven_components), size(places) - 1))
    if (time_column > 0) allocate (times(size(places) - 1))
    do row = 2, size(places)
      call split(without_return(lines(places(row))%text), ',', cells)
      call parse_row(path//':'//integer_text(places(row)), cells, column, factor, targets(:, row - 1), error)
      if (allocated(error)) return
      if (time_column == 0) cycle
      call parse_row(path//':'//integer_text(places(row)), cells, [time_column], [1.0_wp], time, error)
      if (allocated(error)) return
      times(row - 1) = time(1)
    end do
    if (time_column > 0) call check_times(path, places(2:), times, error)
  end subroutine parse_targets

  !> Checks that times increase from row to row; the first row may be at the start of the stage.
  pure subroutine check_times(path, places, times, error)
    !> Path of the file.
    character(len=*), intent(in) :: path
    !> Line number of each row.
    integer, intent(in) :: places(:)
    real(wp), intent(in) :: times(:)
    !> Set when a time is not greater than the previous one.
    type(error_type), allocatable, intent(out) :: error
    integer :: i
    real(wp) :: before

    ! The first row may be at the start, unless it is the only one.
    before = merge(-tiny(1.0_wp), 0.0_wp, size(times) > 1)
    do i = 1, size(times)
      if (times(i) > before) then
        before = times(i)
        cycle
      end if
      call fail(error, error_deck, path//':'//integer_text(places(i))//': the time is not after the one before; it '// &
        'counts from the start of the stage')
      return
    end do
  end subroutine check_times

  !> Reads the header line.
  pure subroutine parse_head(path, line, stress_unit, driven_components, column, factor, time_column, error)
    !> Path of the file.
    character(len=*), intent(in) :: path
    character(len=*), intent(in) :: line
    !> Unit of stress of the deck.
    character(len=*), intent(in) :: stress_unit
    !> Prescribed components.
    integer, allocatable, intent(out) :: driven_components(:)
    !> Column of each component and its factor to the unit of the deck.
    integer, allocatable, intent(out) :: column(:)
    real(wp), allocatable, intent(out) :: factor(:)
    !> Column of the time, 0 for none.
    integer, intent(out) :: time_column
    !> Set when a heading is unknown.
    type(error_type), allocatable, intent(out) :: error
    type(string_type), allocatable :: cells(:)
    character(len=:), allocatable :: name, unit
    integer :: i, driven
    real(wp) :: f

    call split(line, ',', cells)
    allocate (driven_components(0), column(0), factor(0))
    time_column = 0
    do i = 1, size(cells)
      call cut_heading(cells(i)%text, name, unit)
      if (any(name == ['STEP ', 'PHASE'])) cycle
      if (name == 'TIME') then
        if (time_column > 0) call fail(error, error_deck, path//":1: 'TIME' stands there twice")
        if (allocated(error)) return
        time_column = i
        cycle
      end if
      call find_component(path, stripped(cells(i)%text), name, unit, stress_unit, driven, f, error)
      if (.not. allocated(error) .and. any(driven_components == driven)) &
        call fail(error, error_deck, path//":1: '"//trim(driven_words(driven))//"' stands there twice")
      if (allocated(error)) return
      driven_components = [driven_components, driven]
      column = [column, i]
      factor = [factor, f]
    end do
    if (size(driven_components) == 0) call fail(error, error_deck, path//':1: no column is a prescribed component')
  end subroutine parse_head

  !> Returns the component of a heading and the factor from its unit to that of the deck.
  pure subroutine find_component(path, heading, name, unit, stress_unit, driven, factor, error)
    character(len=*), intent(in) :: path, heading
    !> Parts of the heading.
    character(len=*), intent(in) :: name, unit
    !> Unit of stress of the deck.
    character(len=*), intent(in) :: stress_unit
    integer, intent(out) :: driven
    real(wp), intent(out) :: factor
    !> Set when name or unit are unknown.
    type(error_type), allocatable, intent(out) :: error

    factor = 0.0_wp
    driven = findloc(driven_words == name, .true., dim=1)
    if (driven == 0) then
      call fail(error, error_deck, path//":1: nothing is called '"//heading//"'")
      return
    end if
    factor = unit_factor(unit, is_stress(driven), stress_unit)
    if (.not. abs(factor) > 0.0_wp) call fail(error, error_deck, path//":1: unit '"//unit//"' of '"//name// &
      "' cannot be converted to '"//trim(merge(stress_unit, repeat('-', len(stress_unit)), is_stress(driven)))//"'")
  end subroutine find_component

  !> Returns name and unit of a heading `name [unit]`.
  pure subroutine cut_heading(text, name, unit)
    !> The heading.
    character(len=*), intent(in) :: text
    !> Its name in capitals, with blanks and underscores as one blank.
    character(len=:), allocatable, intent(out) :: name
    !> Its unit, empty if there is none.
    character(len=:), allocatable, intent(out) :: unit
    integer :: open, close

    open = scan(text//'[', '[')
    name = upper(squeezed(replaced(text(:open - 1), '_', ' ')))
    unit = ''
    close = index(text, ']')
    if (close > open) unit = stripped(text(open + 1:close - 1))
  end subroutine cut_heading

  !> Returns the factor from a unit to that of the deck; 0 if there is none.
  pure real(wp) function unit_factor(unit, stress, stress_unit) result(factor)
    !> The unit, empty for that of the deck.
    character(len=*), intent(in) :: unit
    !> Whether it is a unit of stress, otherwise of strain.
    logical, intent(in) :: stress
    !> Unit of stress of the deck.
    character(len=*), intent(in) :: stress_unit
    integer :: from, to

    factor = 0.0_wp
    if (len(unit) == 0) factor = 1.0_wp
    if (stress) then
      if (unit == stress_unit) factor = 1.0_wp
      from = findloc(stress_units == unit, .true., dim=1)
      to = findloc(stress_units == stress_unit, .true., dim=1)
      if (from > 0 .and. to > 0) factor = pascals(from)/pascals(to)
    else
      if (unit == '-' .or. unit == '1') factor = 1.0_wp
      if (unit == '%') factor = 1.0e-2_wp
    end if
  end function unit_factor

  !> Reads a row of targets.
  pure subroutine parse_row(place, cells, column, factor, targets, error)
    !> File and line, for messages.
    character(len=*), intent(in) :: place
    type(string_type), intent(in) :: cells(:)
    !> Columns of the targets and their factors.
    integer, intent(in) :: column(:)
    real(wp), intent(in) :: factor(:)
    real(wp), intent(out) :: targets(:)
    !> Set when a value is not a number.
    type(error_type), allocatable, intent(out) :: error
    integer :: i, outcome

    targets = 0.0_wp
    do i = 1, size(column)
      if (column(i) > size(cells)) then
        call fail(error, error_deck, place//': a number for each heading is required')
        return
      end if
      call read_real(stripped(cells(column(i))%text), targets(i), outcome)
      if (outcome /= number_good) then
        call fail(error, error_deck, place//": '"//stripped(cells(column(i))%text)//"' is not a number")
        return
      end if
    end do
    targets = targets*factor
  end subroutine parse_row
end module qsmpm_point_table
