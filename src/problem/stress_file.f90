!> Stresses at places, from a CSV file: its first line names the columns, the others are one place each.
!>
!>   x, y, z                            coordinates; z in space only
!>   s11, s22, s33, s12, s13, s23       stress, tension positive; components that are not named are 0
!>
!> Other columns are not read.
module qsmpm_stress_file
  use qsmpm_kinds, only: wp
  use qsmpm_csv_columns, only: read_columns
  use qsmpm_error, only: error_type
  implicit none
  private

  public :: read_stress_file

  character(len=3), parameter :: axes(3) = ['x  ', 'y  ', 'z  '], &
    components(6) = ['s11', 's22', 's33', 's12', 's13', 's23']

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
    real(wp), allocatable :: table(:, :)
    integer, allocatable :: lines(:)

    call read_columns(path, [axes(:dimension), components], dimension, 'x, y'//trim(merge(', z', '   ', &
      dimension == 3))//' and some of s11, s22, s33, s12, s13, s23', table, lines, error)
    if (allocated(error)) return
    places = table(:dimension, :)
    stresses = table(dimension + 1:, :)
  end subroutine read_stress_file
end module qsmpm_stress_file
