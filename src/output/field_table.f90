!> The fields of the material points as a table: what pictures, results and named values call them.
module qsmpm_field_table
  use qsmpm_field_list, only: field_type, field_list_type, kind_internal, kind_names, row_components, shown_nowhere
  use qsmpm_fields, only: list_results
  use qsmpm_model, only: model_type
  use qsmpm_number_text, only: integer_text, newline
  use qsmpm_points, only: allocate_points
  use qsmpm_stress_error, only: stress_error_type
  implicit none
  private

  public :: fields_markdown

  !> Where a field is shown, by the shown_* values from 1.
  character(len=*), parameter :: shown_names(3) = [character(len=25) :: 'values', 'pictures, results', &
    'pictures, results, values']

contains

  !> All fields that are shown, a row each, in Markdown.
  subroutine fields_markdown(text)
    character(len=:), allocatable, intent(out) :: text
    type(model_type), target :: none
    type(field_list_type) :: list
    type(stress_error_type) :: no_error
    integer :: i

    call allocate_points(none%state%points, 3, 0, 6, 0)
    allocate (no_error%at_point(0), no_error%scale(0))
    call list_results(none, no_error, list)
    text = '| field | components | unit | kind | where | what |'//newline//'|---|---|---|---|---|---|'//newline
    do i = 1, list%count
      if (list%fields(i)%shown /= shown_nowhere) text = text//row_of(list%fields(i))//newline
    end do
  end subroutine fields_markdown

  !> Row of a field.
  pure function row_of(field) result(row)
    type(field_type), intent(in) :: field
    character(len=:), allocatable :: row, components, places

    components = integer_text(row_components(field%kind))
    if (field%kind == kind_internal) components = 'of the law'
    places = shown_names(field%shown)
    row = '| `'//trim(field%name)//'` | '//components//' | '//trim(field%unit)//' | '//trim(kind_names(field%kind))// &
      ' | '//trim(places)//' | '//trim(field%meaning)//' |'
  end function row_of
end module qsmpm_field_table
