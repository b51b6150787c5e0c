!> Location of an item in the input.
module qsmpm_source_line
  implicit none
  private

  public :: source_line_type

  !> Location of an item in the input, for errors found after parsing.
  type :: source_line_type
    character(len=:), allocatable :: file
    integer :: line = 0
  end type source_line_type
end module qsmpm_source_line
