!> Errors of a deck that are detected only when the model is built.
module qsmpm_diagnostics
  use qsmpm_source_line, only: source_line_type
  use qsmpm_error, only: error_deck, error_user_material
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: diagnostics_type, add_diagnostic, where_text

  !> Errors, one per line.
  type :: diagnostics_type
    integer :: count = 0
    !> Exit code: error_deck, or error_user_material if there is no other error.
    integer :: code = error_user_material
    character(len=:), allocatable :: text
  end type diagnostics_type

contains

  !> Adds `file:line: *KEYWORD: message`.
  pure subroutine add_diagnostic(diagnostics, where, keyword, message, code)
    type(diagnostics_type), intent(inout) :: diagnostics
    !> Location of the faulty item.
    type(source_line_type), intent(in) :: where
    character(len=*), intent(in) :: keyword, message
    !> Code of the error; error_deck by default.
    integer, intent(in), optional :: code
    character(len=:), allocatable :: text

    text = where_text(where)//trim(keyword)//': '//message
    diagnostics%count = diagnostics%count + 1
    if (.not. present(code)) then
      diagnostics%code = error_deck
    else if (code /= error_user_material) then
      diagnostics%code = error_deck
    end if
    if (diagnostics%count == 1) then
      diagnostics%text = text
    else
      diagnostics%text = diagnostics%text//new_line('a')//text
    end if
  end subroutine add_diagnostic

  !> Returns `file:line: `; empty for an item that is not from a deck.
  pure function where_text(where) result(text)
    type(source_line_type), intent(in) :: where
    character(len=:), allocatable :: text

    text = ''
    if (allocated(where%file)) text = where%file//':'//integer_text(where%line)//': '
  end function where_text
end module qsmpm_diagnostics
