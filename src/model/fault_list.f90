!> Faults of a deck that are only found when the model is built.
module qsmpm_fault_list
  use qsmpm_analysis, only: source_line_type
  use qsmpm_error, only: error_deck, error_user_material
  implicit none
  private

  public :: fault_list_type, add_fault

  !> Faults, one a line.
  type :: fault_list_type
    integer :: count = 0
    !> Exit code: error_deck, or error_user_material when there is no other fault.
    integer :: code = error_user_material
    character(len=:), allocatable :: text
  end type fault_list_type

contains

  !> Add `file:line: *KEYWORD: message`.
  pure subroutine add_fault(faults, where, keyword, message, code)
    !> Faults found so far.
    type(fault_list_type), intent(inout) :: faults
    !> Where the faulty item was written.
    type(source_line_type), intent(in) :: where
    character(len=*), intent(in) :: keyword, message
    !> Code of the error, error_deck when there is none.
    integer, intent(in), optional :: code
    character(len=12) :: line
    character(len=:), allocatable :: text

    write (line, '(i0)') where%line
    text = trim(keyword)//': '//message
    if (allocated(where%file)) text = where%file//':'//trim(line)//': '//text
    faults%count = faults%count + 1
    if (.not. present(code)) then
      faults%code = error_deck
    else if (code /= error_user_material) then
      faults%code = error_deck
    end if
    if (faults%count == 1) then
      faults%text = text
    else
      faults%text = faults%text//new_line('a')//text
    end if
  end subroutine add_fault
end module qsmpm_fault_list
