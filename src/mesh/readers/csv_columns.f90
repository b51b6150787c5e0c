!> Columns of numbers of a CSV file whose first line contains their names: the requested columns are read, one row per
!> line that is not blank. Other columns are ignored; names are not case-sensitive.
module qsmpm_csv_columns
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_text, only: string_type, split, squeezed, stripped, upper, read_real, number_good
  use qsmpm_text_file, only: text_file_type, open_text, next_line, file_error
  implicit none
  private

  public :: read_columns

contains

  !> Reads a file.
  subroutine read_columns(path, names, wanted, what, table, lines, error)
    character(len=*), intent(in) :: path
    !> Columns; the first `wanted` are required, and at least one of the others.
    character(len=*), intent(in) :: names(:)
    integer, intent(in) :: wanted
    !> Description of the names for the error message.
    character(len=*), intent(in) :: what
    !> (names, rows), 0 in missing columns, and the line of each row.
    real(wp), allocatable, intent(out) :: table(:, :)
    integer, allocatable, intent(out) :: lines(:)
    !> Error with path and line; a file without rows is an error.
    type(error_type), allocatable, intent(out) :: error
    type(text_file_type) :: file
    type(string_type), allocatable :: cells(:)
    character(len=:), allocatable :: line
    integer :: column(size(names)), n
    logical :: more

    call open_text(path, file)
    call next_line(file, line, more)
    call split(line, ',', cells)
    column = columns_of(cells, names)
    if (any(column(:wanted) == 0) .or. (wanted < size(names) .and. all(column(wanted + 1:) == 0))) &
      call file_error(file, 'the first line names the columns: '//what)
    allocate (table(size(names), 0), lines(0))
    n = 0
    do
      call next_line(file, line, more)
      if (.not. more) exit
      if (len(stripped(line)) == 0) cycle
      n = n + 1
      if (n > size(lines)) then
        table = reshape(table, [size(names), 2*n + 64], pad=[0.0_wp])
        lines = reshape(lines, [2*n + 64], pad=[0])
      end if
      lines(n) = file%line
      call split(line, ',', cells)
      call read_row(file, cells, names, column, table(:, n))
    end do
    table = table(:, :n)
    lines = lines(:n)
    if (allocated(file%error)) then
      call move_alloc(file%error, error)
    else if (n == 0) then
      call fail(error, error_deck, path//': no row of numbers follows the names of the columns')
    end if
  end subroutine read_columns

  !> Position of each name in the first line, 0 if missing.
  pure function columns_of(cells, names) result(column)
    type(string_type), intent(in) :: cells(:)
    character(len=*), intent(in) :: names(:)
    integer :: column(size(names)), i, k

    column = 0
    do i = 1, size(cells)
      do k = 1, size(names)
        if (upper(squeezed(cells(i)%text)) == upper(trim(names(k)))) column(k) = i
      end do
    end do
  end function columns_of

  !> Reads a row.
  subroutine read_row(file, cells, names, column, values)
    type(text_file_type), intent(inout) :: file
    type(string_type), intent(in) :: cells(:)
    character(len=*), intent(in) :: names(:)
    integer, intent(in) :: column(:)
    real(wp), intent(out) :: values(:)
    integer :: k, outcome

    values = 0.0_wp
    do k = 1, size(column)
      if (column(k) == 0) cycle
      outcome = number_good + 1
      if (column(k) <= size(cells)) call read_real(stripped(cells(column(k))%text), values(k), outcome)
      if (outcome /= number_good) call file_error(file, 'column '//trim(names(k))//' has no number')
    end do
  end subroutine read_row
end module qsmpm_csv_columns
