!> The lines of a plan: a name and a value each, under headings, written as text for people or as
!> JSON for programs.
module qsmpm_plan_items
  use qsmpm_text, only: json_string, newline
  implicit none
  private

  public :: plan_items_type, add_heading, add_item, plan_text, plan_json

  !> Kinds of entries.
  integer, parameter :: heading = 0, words = 1, figure = 2
  !> Columns of the names in text.
  integer, parameter :: name_width = 26

  !> An entry.
  type :: item_type
    integer :: kind = heading
    character(len=:), allocatable :: name, value
  end type item_type

  !> Entries in order.
  type :: plan_items_type
    type(item_type), allocatable :: rows(:)
  end type plan_items_type

contains

  !> Begin a group of entries.
  pure subroutine add_heading(items, name)
    type(plan_items_type), intent(inout) :: items
    !> Name of the group.
    character(len=*), intent(in) :: name

    call add(items, heading, name, '')
  end subroutine add_heading

  !> Add an entry.
  pure subroutine add_item(items, name, value, is_figure)
    type(plan_items_type), intent(inout) :: items
    !> Its name and value.
    character(len=*), intent(in) :: name, value
    !> The value is a number; otherwise words.
    logical, intent(in), optional :: is_figure
    integer :: kind

    kind = words
    if (present(is_figure)) kind = merge(figure, words, is_figure)
    call add(items, kind, name, value)
  end subroutine add_item

  !> Put an entry at the end.
  pure subroutine add(items, kind, name, value)
    type(plan_items_type), intent(inout) :: items
    !> Kind, name and value.
    integer, intent(in) :: kind
    character(len=*), intent(in) :: name, value
    type(item_type) :: row

    if (.not. allocated(items%rows)) allocate (items%rows(0))
    row%kind = kind
    row%name = name
    row%value = value
    items%rows = [items%rows, row]
  end subroutine add

  !> The plan for people.
  pure function plan_text(items) result(text)
    type(plan_items_type), intent(in) :: items
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(items%rows)
      associate (name => items%rows(i)%name)
        if (items%rows(i)%kind == heading) then
          text = text//name//newline
        else
          text = text//'  '//name//repeat(' ', max(1, name_width - len(name)))//items%rows(i)%value//newline
        end if
      end associate
    end do
  end function plan_text

  !> The plan for programs: an object of objects.
  pure function plan_json(items) result(text)
    type(plan_items_type), intent(in) :: items
    character(len=:), allocatable :: text
    logical :: first
    integer :: i

    text = '{'
    first = .true.
    do i = 1, size(items%rows)
      if (items%rows(i)%kind == heading) then
        if (i > 1) text = text//newline//'  },'
        text = text//newline//'  '//json_string(items%rows(i)%name)//': {'
        first = .true.
        cycle
      end if
      if (.not. first) text = text//','
      first = .false.
      text = text//newline//'    '//json_string(items%rows(i)%name)//': '
      if (items%rows(i)%kind == figure) text = text//items%rows(i)%value
      if (items%rows(i)%kind == words) text = text//json_string(items%rows(i)%value)
    end do
    text = text//newline//'  }'//newline//'}'//newline
  end function plan_json
end module qsmpm_plan_items
