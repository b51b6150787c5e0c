!> The lines of a plan as text and as JSON.
module test_plan_items
  use qsmpm_plan, only: plan_items_type, add_heading, add_item, plan_text, plan_json
  use testing, only: tests_type
  implicit none
  private

  public :: collect_plan_items

contains

  !> All checks.
  subroutine collect_plan_items(tests)
    type(tests_type), intent(inout) :: tests
    type(plan_items_type) :: items
    character(len=1), parameter :: line = new_line('a')
    integer :: i

    call tests%start('plan_items')
    call add_heading(items, 'scene')
    call add_item(items, 'kind', 'a "plane" one')
    call add_item(items, 'points', '12', is_figure=.true.)
    call add_heading(items, 'model')
    call add_item(items, 'folder', 'a\b')
    call tests%check('a plan is headings and lines', plan_text(items) == 'scene'//line// &
      '  kind                      a "plane" one'//line//'  points                    12'//line// &
      'model'//line//'  folder                    a\b'//line)
    call tests%check('JSON has objects, numbers and escaped strings', plan_json(items) == '{'//line// &
      '  "scene": {'//line//'    "kind": "a \"plane\" one",'//line//'    "points": 12'//line//'  },'//line// &
      '  "model": {'//line//'    "folder": "a\\b"'//line//'  }'//line//'}'//line)
    do i = 1, 40
      call add_item(items, 'more', 'x')
    end do
    call tests%check('it grows as it must', size(items%rows) == 45)
  end subroutine collect_plan_items
end module test_plan_items
