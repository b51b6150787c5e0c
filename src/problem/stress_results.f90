!> Reads the points of another run from its results: locations, stresses and named state variables. The index
!> `results.h5` lists the steps; each has a file of its own in the folder `results/`.
!>
!> Also reads stresses from a CSV file: its first line names the columns, every other line is one location.
!>
!> x, y, z coordinates, z in 3D only; s11, s22, s33, s12, s13, s23 stresses, tension positive; unnamed components are
!> 0.
!>
!> Other columns are ignored.
module qsmpm_stress_results
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, error_deck, fail
  use qsmpm_hdf5_reader, only: reader_type, open_reader, get_array, get_attribute, list_group, close_reader
  use qsmpm_text, only: string_type, integer_text
  use qsmpm_csv_columns, only: read_columns
  implicit none
  private

  public :: is_results, read_stress_results, read_state_results, read_stress_file

  !> Folder of the step files next to the index.
  character(len=*), parameter :: parts = 'results/'

  character(len=3), parameter :: axes(3) = ['x  ', 'y  ', 'z  '], &
    components(6) = ['s11', 's22', 's33', 's12', 's13', 's23']

contains

  !> Returns whether a file is a result index, by its name.
  pure logical function is_results(path)
    character(len=*), intent(in) :: path

    is_results = .false.
    if (len(path) > 3) is_results = path(len(path) - 2:) == '.h5'
  end function is_results

  !> Reads the points of a step.
  subroutine read_stress_results(path, dimension, step, places, stresses, part, error)
    !> Path of the index.
    character(len=*), intent(in) :: path
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Number of the step; 0 for the last one.
    integer, intent(in) :: step
    !> (dimension, n), (6, n)
    real(wp), allocatable, intent(out) :: places(:, :), stresses(:, :)
    !> File of the step.
    character(len=:), allocatable, intent(out) :: part
    !> Set when the results cannot be read.
    type(error_type), allocatable, intent(out) :: error
    real(wp), allocatable :: positions(:, :)
    type(reader_type) :: reader

    call find_part(path, step, part, error)
    if (.not. allocated(error)) call check_dimension(path, dimension, error)
    if (allocated(error)) return
    call open_reader(reader, part)
    call get_array(reader, '/step/points/position', positions)
    call get_array(reader, '/step/points/stress', stresses)
    call close_as_deck(reader, error)
    if (allocated(error)) return
    if (allocated(positions) .and. allocated(stresses)) then
      if (size(positions, 2) > 0 .and. size(positions, 2) == size(stresses, 2) .and. size(stresses, 1) == 6) then
        allocate (places, source=positions(:dimension, :))
        return
      end if
    end if
    call fail(error, error_deck, "'"//part//"' has no stresses of material points")
  end subroutine read_stress_results

  !> Reads a state variable of the points of a step.
  subroutine read_state_results(part, name, values, material, error)
    !> File of the step.
    character(len=*), intent(in) :: part
    character(len=*), intent(in) :: name
    !> (n); unallocated if the run had no such variable.
    real(wp), allocatable, intent(out) :: values(:)
    !> Number of the material of each point (n).
    integer, allocatable, intent(out) :: material(:)
    type(error_type), allocatable, intent(out) :: error
    type(reader_type) :: reader

    call open_reader(reader, part)
    call get_array(reader, '/step/points/'//name, values)
    call get_array(reader, '/step/points/material', material)
    call close_as_deck(reader, error)
  end subroutine read_state_results

  !> Closes a file; an error is reported as an error of the deck.
  subroutine close_as_deck(reader, error)
    type(reader_type), intent(inout) :: reader
    type(error_type), allocatable, intent(out) :: error

    call close_reader(reader, error)
    if (allocated(error)) error%code = error_deck
  end subroutine close_as_deck

  !> Checks that the results are from a model of the same dimension.
  subroutine check_dimension(path, dimension, error)
    !> Path of the index.
    character(len=*), intent(in) :: path
    integer, intent(in) :: dimension
    type(error_type), allocatable, intent(out) :: error
    type(reader_type) :: reader
    integer :: found

    found = dimension
    call open_reader(reader, folder_of(path)//'mesh.h5')
    call get_attribute(reader, '/mesh', 'dimension', found)
    call close_as_deck(reader, error)
    if (allocated(error) .or. found == dimension) return
    call fail(error, error_deck, "the results '"//path//"' have "//integer_text(found)//' dimensions, this model '// &
      'has '//integer_text(dimension)//': take those of a run with the same *MODEL, TYPE')
  end subroutine check_dimension

  !> Finds the file of a step.
  subroutine find_part(path, step, part, error)
    !> Path of the index.
    character(len=*), intent(in) :: path
    !> Number of the step, 0 for the last one.
    integer, intent(in) :: step
    character(len=:), allocatable, intent(out) :: part
    type(error_type), allocatable, intent(out) :: error
    type(reader_type) :: reader
    type(string_type), allocatable :: names(:)
    character(len=:), allocatable :: found
    integer :: i, number, status

    call open_reader(reader, path)
    call list_group(reader, '/steps', names)
    call close_as_deck(reader, error)
    if (allocated(error)) return
    found = ''
    do i = 1, size(names)
      read (names(i)%text, *, iostat=status) number
      if (status == 0 .and. (step == 0 .or. number == step)) found = names(i)%text
    end do
    part = folder_of(path)//found//'.h5'
    if (len(found) > 0) return
    if (size(names) == 0) then
      call fail(error, error_deck, "'"//path//"' lists no steps: take the results.h5 of a run")
    else
      call fail(error, error_deck, "the results '"//path//"' have no step "//integer_text(step)//'; the last one '// &
        'is '//names(size(names))%text)
    end if
  end subroutine find_part

  !> Returns the folder of the step files of an index.
  pure function folder_of(path) result(folder)
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: folder

    folder = path(:index(path, '/', back=.true.))//parts
  end function folder_of

  !> Reads a file of stresses.
  subroutine read_stress_file(path, dimension, places, stresses, error)
    character(len=*), intent(in) :: path
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> (dimension, n), (6, n)
    real(wp), allocatable, intent(out) :: places(:, :), stresses(:, :)
    !> Set on an error, with path and line.
    type(error_type), allocatable, intent(out) :: error
    real(wp), allocatable :: table(:, :)
    integer, allocatable :: lines(:)

    call read_columns(path, [axes(:dimension), components], dimension, 'x, y'//trim(merge(', z', '   ', &
      dimension == 3))//' and some of s11, s22, s33, s12, s13, s23', table, lines, error)
    if (allocated(error)) return
    places = table(:dimension, :)
    stresses = table(dimension + 1:, :)
  end subroutine read_stress_file
end module qsmpm_stress_results
