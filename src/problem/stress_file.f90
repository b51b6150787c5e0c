!> Stresses at places, from a CSV file: its first line names the columns, the others are one place each.
!>
!>   x, y, z                            coordinates; z in space only
!>   s11, s22, s33, s12, s13, s23       stress, tension positive; components that are not named are 0
!>
!> Other columns are not read.
module qsmpm_stress_file
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_text, only: string_type, split, stripped, read_real, number_good
  use qsmpm_text_file, only: text_file_type, open_text, next_line, file_error
  implicit none
  private

  public :: read_stress_file

  character(len=3), parameter :: names(9) = ['x  ', 'y  ', 'z  ', 's11', 's22', 's33', 's12', 's13', 's23']

contains

  !> Read a file.
  subroutine read_stress_file(path, dimension, places, stresses, error)
    character(len=*), intent(in) :: path
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> (dimension, n), (6, n)
    real(wp), allocatable, intent(out) :: places(:, :), stresses(:, :)
    !> What is wrong, with path and line.
    type(error_type), allocatable, intent(out) :: error
    type(text_file_type) :: file
    type(string_type), allocatable :: cells(:)
    character(len=:), allocatable :: line
    integer :: column(size(names)), n
    logical :: more

    call open_text(path, file, error)
    if (allocated(error)) return
    call next_line(file, line, more)
    call split(line, ',', cells)
    call find_columns(file, cells, dimension, column, error)
    if (allocated(error)) return
    allocate (places(dimension, 0), stresses(6, 0))
    n = 0
    do
      call next_line(file, line, more)
      if (.not. more) exit
      if (len(stripped(line)) == 0) cycle
      n = n + 1
      if (n > size(places, 2)) call make_room(places, stresses)
      call split(line, ',', cells)
      call read_row(file, cells, column, places(:, n), stresses(:, n), error)
      if (allocated(error)) return
    end do
    places = places(:, :n)
    stresses = stresses(:, :n)
    if (n == 0) call fail(error, error_deck, path//': the file has no place')
  end subroutine read_stress_file

  !> Twice the room.
  pure subroutine make_room(places, stresses)
    real(wp), allocatable, intent(inout) :: places(:, :), stresses(:, :)
    real(wp), allocatable :: more_places(:, :), more_stresses(:, :)
    integer :: n

    n = size(places, 2)
    allocate (more_places(size(places, 1), 2*n + 64), more_stresses(6, 2*n + 64), source=0.0_wp)
    more_places(:, :n) = places
    more_stresses(:, :n) = stresses
    call move_alloc(more_places, places)
    call move_alloc(more_stresses, stresses)
  end subroutine make_room

  !> Column of each name, 0 for none.
  subroutine find_columns(file, cells, dimension, column, error)
    type(text_file_type), intent(in) :: file
    !> Of the first line.
    type(string_type), intent(in) :: cells(:)
    integer, intent(in) :: dimension
    integer, intent(out) :: column(:)
    !> A coordinate, or all stresses, are missing.
    type(error_type), allocatable, intent(out) :: error
    integer :: i, k

    column = 0
    do i = 1, size(cells)
      do k = 1, size(names)
        if (stripped(cells(i)%text) == trim(names(k))) column(k) = i
      end do
    end do
    if (any(column(:dimension) == 0) .or. all(column(4:) == 0)) call file_error(file, 'the first line names the '// &
      'columns: x, y'//trim(merge(', z', '   ', dimension == 3))//' and some of s11, s22, s33, s12, s13, s23', error)
  end subroutine find_columns

  !> One place.
  subroutine read_row(file, cells, column, place, stress, error)
    type(text_file_type), intent(in) :: file
    type(string_type), intent(in) :: cells(:)
    integer, intent(in) :: column(:)
    real(wp), intent(out) :: place(:), stress(:)
    !> A number that is none.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: value, values(size(names))
    integer :: k, outcome

    values = 0.0_wp
    place = 0.0_wp
    stress = 0.0_wp
    do k = 1, size(column)
      if (column(k) == 0 .or. (k <= 3 .and. k > size(place))) cycle
      outcome = number_good + 1
      if (column(k) <= size(cells)) call read_real(stripped(cells(column(k))%text), value, outcome)
      if (outcome /= number_good) then
        call file_error(file, 'column '//trim(names(k))//' has no number', error)
        return
      end if
      values(k) = value
    end do
    place = values(:size(place))
    stress = values(4:)
  end subroutine read_row
end module qsmpm_stress_file
