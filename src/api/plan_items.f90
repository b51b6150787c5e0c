!> The lines of a plan: a name and a value each, under headings, written as text for people or as
!> JSON for programs.
module qsmpm_plan_items
  use qsmpm_text, only: string_type, json_string
  implicit none
  private

  public :: plan_items_type, add_heading, add_item, plan_text, plan_json

  !> Kinds of entries.
  integer, parameter :: heading = 0, words = 1, figure = 2
  !> Columns of the names in text.
  integer, parameter :: name_width = 26
  character(len=1), parameter :: newline = new_line('a')

  !> Entries in order.
  type :: plan_items_type
    integer :: count = 0
    integer, allocatable :: kind(:)
    type(string_type), allocatable :: name(:), value(:)
  end type plan_items_type

contains

  !> Begin a group of entries.
  pure subroutine add_heading(items, name)
    !> The entries.
    type(plan_items_type), intent(inout) :: items
    !> Name of the group.
    character(len=*), intent(in) :: name

    call add(items, heading, name, '')
  end subroutine add_heading

  !> Add an entry.
  pure subroutine add_item(items, name, value, is_figure)
    !> The entries.
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
    !> The entries.
    type(plan_items_type), intent(inout) :: items
    !> Kind, name and value.
    integer, intent(in) :: kind
    character(len=*), intent(in) :: name, value
    type(string_type), allocatable :: names(:), values(:)
    integer, allocatable :: kinds(:)
    integer :: i, room

    if (.not. allocated(items%kind)) allocate (items%kind(0), items%name(0), items%value(0))
    if (items%count == size(items%kind)) then
      room = 2*items%count + 8
      allocate (kinds(room), names(room), values(room))
      do i = 1, items%count
        kinds(i) = items%kind(i)
        names(i) = items%name(i)
        values(i) = items%value(i)
      end do
      call move_alloc(kinds, items%kind)
      call move_alloc(names, items%name)
      call move_alloc(values, items%value)
    end if
    items%count = items%count + 1
    items%kind(items%count) = kind
    items%name(items%count)%text = name
    items%value(items%count)%text = value
  end subroutine add

  !> The plan for people.
  pure function plan_text(items) result(text)
    !> The entries.
    type(plan_items_type), intent(in) :: items
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, items%count
      associate (name => items%name(i)%text)
        if (items%kind(i) == heading) then
          text = text//name//newline
        else
          text = text//'  '//name//repeat(' ', max(1, name_width - len(name)))//items%value(i)%text//newline
        end if
      end associate
    end do
  end function plan_text

  !> The plan for programs: an object of objects.
  pure function plan_json(items) result(text)
    !> The entries.
    type(plan_items_type), intent(in) :: items
    character(len=:), allocatable :: text
    logical :: first
    integer :: i

    text = '{'
    first = .true.
    do i = 1, items%count
      if (items%kind(i) == heading) then
        if (i > 1) text = text//newline//'  },'
        text = text//newline//'  '//json_string(items%name(i)%text)//': {'
        first = .true.
        cycle
      end if
      if (.not. first) text = text//','
      first = .false.
      text = text//newline//'    '//json_string(items%name(i)%text)//': '
      if (items%kind(i) == figure) text = text//items%value(i)%text
      if (items%kind(i) == words) text = text//json_string(items%value(i)%text)
    end do
    text = text//newline//'  }'//newline//'}'//newline
  end function plan_json
end module qsmpm_plan_items
