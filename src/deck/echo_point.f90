!> Cards of a laboratory test on one point as the echo writes them, every default spelt out.
module qsmpm_echo_point
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: real_text, integer_text
  use qsmpm_deck_words, only: test_words, strain_words, height_words
  use qsmpm_echo_lines, only: echo_type, quoted, numbers
  use qsmpm_point_test, only: point_test_type, point_stage_type, lead_words, test_shear, test_undrained
  implicit none
  private

  public :: echo_point

contains

  !> The test, its stress at the start and its stages.
  subroutine echo_point(echo, test)
    !> The echo.
    type(echo_type), intent(inout) :: echo
    !> The test.
    type(point_test_type), intent(in) :: test
    character(len=:), allocatable :: text
    integer :: i

    text = '*POINT TEST, TYPE='//trim(test_words(test%kind))//', MATERIAL='//quoted(test%material)//', DIMENSION='// &
      integer_text(test%dimension)//', STRAIN='//trim(strain_words(test%strain))
    if (test%kind == test_shear) text = text//', HEIGHT='//trim(height_words(merge(1, 0, test%fixed_height)))
    if (test%kind == test_undrained) text = text//', CELL PRESSURE='//real_text(test%cell_pressure)
    call echo%line(text//', START TIME='//real_text(test%start_time)//', TOLERANCE='//real_text(test%tolerance))
    call echo%line('*INITIAL STRESS')
    call echo%line(' '//numbers(test%stress))
    do i = 1, size(test%stages)
      call echo_stage(echo, test%stages(i))
    end do
  end subroutine echo_point

  !> A stage.
  subroutine echo_stage(echo, stage)
    !> The echo.
    type(echo_type), intent(inout) :: echo
    !> The stage.
    type(point_stage_type), intent(in) :: stage
    character(len=:), allocatable :: text
    integer :: i

    text = '*POINT STAGE, STEPS='//integer_text(stage%steps)
    if (.not. allocated(stage%times)) text = text//', TIME='//real_text(stage%duration)
    if (len(stage%table) > 0) then
      call echo%line(text//', INPUT='//quoted(stage%table))
      return
    end if
    call echo%line(text)
    do i = 1, size(stage%leads)
      call echo%line(' '//trim(lead_words(stage%leads(i)))//', '//real_text(stage%targets(i, 1)))
    end do
  end subroutine echo_stage
end module qsmpm_echo_point
