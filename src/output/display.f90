!> Display of the progress of a run: on a terminal one line that is refreshed, otherwise plain lines: every step of a
!> short run, a limited number of lines for a long one.
!>
!> Also collects the warnings of a run, one per line, for repetition at its end.
module qsmpm_display
  use qsmpm_kinds, only: wp
  use qsmpm_stopwatch, only: clock_type, start_clock, wall_seconds
  use qsmpm_model, only: model_type
  use qsmpm_number_text, only: duration_text, integer_text, newline
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_observer, only: step_record_type
  use qsmpm_posix, only: terminal_width, write_descriptor
  use qsmpm_term_share, only: share_named, damping_share, stabilisation_share
  implicit none
  private

  public :: display_type, start_display, show_step, show_text, show_result, end_display, step_text, keep_warnings, &
    repeated_warnings

  !> Kinds of display: none, plain lines, a refreshed line, warnings and results only.
  integer, parameter, public :: display_none = 0, display_plain = 1, display_terminal = 2, display_quiet = 3

  !> Completed fraction and seconds after which a plain line is due; for long runs the interval in seconds grows with
  !> the elapsed time, so that a run of a day has a few hundred lines.
  real(wp), parameter :: share_between_lines = 0.01_wp, seconds_between_lines = 1.0_wp
  real(wp), parameter :: growth_of_seconds = 0.01_wp
  !> Interval between updates of a terminal line in seconds.
  real(wp), parameter :: seconds_between_refreshments = 0.1_wp

  integer, parameter :: standard_output = 1, error_output = 2
  !> Escape sequence that clears the line.
  character(len=*), parameter :: clear_line = achar(13)//achar(27)//'[K'

  !> State of the display.
  type :: display_type
    integer :: kind = display_none
    type(clock_type) :: clock
    !> Completed fraction of the run at the start and at the last line, with the times [s].
    real(wp) :: start_share = 0.0_wp
    real(wp) :: last_share = -1.0_wp
    real(wp) :: last_time = 0.0_wp
    !> Whether a refreshed line is on the terminal.
    logical :: line_stands = .false.
  end type display_type

contains

  !> Starts the display of a run.
  subroutine start_display(display, kind, model)
    type(display_type), intent(out) :: display
    !> One of the display_* values.
    integer, intent(in) :: kind
    type(model_type), intent(in) :: model

    display%kind = kind
    call start_clock(display%clock)
    display%start_share = share_done(model)
  end subroutine start_display

  !> Displays an accepted step if a line is due.
  subroutine show_step(display, model, record)
    type(display_type), intent(inout) :: display
    type(model_type), intent(in) :: model
    type(step_record_type), intent(in) :: record
    real(wp) :: seconds, share
    character(len=:), allocatable :: line, part, text
    integer :: width

    if (display%kind == display_none .or. display%kind == display_quiet) return
    seconds = wall_seconds(display%clock)
    share = share_done(model)
    if (.not. is_due(display, seconds, share)) return
    display%last_time = seconds
    display%last_share = share
    ! Remaining time, from the progress since the start.
    if (share - display%start_share <= 0.0_wp) then
      text = 'remaining time unknown'
    else
      text = duration_text(seconds*(1.0_wp - share)/(share - display%start_share))//' remaining'
    end if
    line = step_text(model, record)//', '//text
    if (display%kind == display_terminal) then
      ! Truncated to the width of the terminal: a longer line could not be refreshed.
      part = line
      width = terminal_width(standard_output) - 1
      if (width > 0 .and. width < len(line)) part = line(:width)
      call write_descriptor(standard_output, clear_line//part)
      display%line_stands = .true.
    else
      call write_descriptor(standard_output, line//newline)
    end if
  end subroutine show_step

  !> Displays messages on separate lines; in quiet mode only warnings, on the error output.
  subroutine show_text(display, text)
    type(display_type), intent(inout) :: display
    !> Messages, one per line.
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: warnings

    if (display%kind == display_quiet) then
      call keep_warnings(text, warnings)
      if (len(warnings) > 0) call write_descriptor(error_output, warnings)
    else
      call show_result(display, text)
    end if
  end subroutine show_text

  !> Displays a result on a separate line.
  subroutine show_result(display, text)
    type(display_type), intent(inout) :: display
    !> The result.
    character(len=*), intent(in) :: text

    if (display%kind == display_none) return
    if (display%line_stands) call write_descriptor(standard_output, clear_line)
    display%line_stands = .false.
    call write_descriptor(standard_output, text//newline)
  end subroutine show_result

  !> Ends the display after the last line.
  subroutine end_display(display)
    type(display_type), intent(inout) :: display

    if (display%line_stands) call write_descriptor(standard_output, newline)
    display%line_stands = .false.
  end subroutine end_display

  !> Returns whether a step is to be displayed.
  pure logical function is_due(display, seconds, share)
    type(display_type), intent(in) :: display
    !> Elapsed time [s]; completed fraction of the run.
    real(wp), intent(in) :: seconds, share
    real(wp) :: pause

    if (display%last_share < 0.0_wp .or. share >= 1.0_wp) then
      is_due = .true.
    else if (display%kind == display_terminal) then
      is_due = seconds - display%last_time >= seconds_between_refreshments
    else
      pause = max(seconds_between_lines, growth_of_seconds*seconds)
      is_due = share - display%last_share >= share_between_lines*(1.0_wp - epsilon(1.0_wp)*64) &
        .or. seconds - display%last_time >= pause
    end if
  end function is_due

  !> Returns the completed fraction of all phases.
  pure real(wp) function share_done(model)
    type(model_type), intent(in) :: model
    integer :: phases

    phases = 1
    if (allocated(model%analysis%phases)) phases = max(1, size(model%analysis%phases))
    share_done = (real(model%state%progress%phase - 1, wp) + model%state%progress%fraction) /real(phases, wp)
  end function share_done

  !> Returns the line of a step.
  pure function step_text(model, record) result(text)
    type(model_type), intent(in) :: model
    type(step_record_type), intent(in) :: record
    character(len=:), allocatable :: text
    real(wp) :: damping

    associate (progress => model%state%progress)
      text = phase_text(model)//', load factor '//rounded_text(progress%load_factor, 5)// &
        ', step '//integer_text(progress%step)//', '//integer_text(record%iterations)// &
        ' iterations, out of balance '//rounded_text(record%out_of_balance, 2)// &
        ', stabilisation '//rounded_text(share_named(record%shares, stabilisation_share), 2)
      damping = share_named(record%shares, damping_share)
      if (abs(damping) > 0.0_wp) text = text//', damping '//rounded_text(damping, 2)
    end associate
  end function step_text

  !> Returns the text of the current phase.
  pure function phase_text(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    integer :: phase

    phase = model%state%progress%phase
    text = 'phase '//integer_text(phase)
    if (.not. allocated(model%analysis%phases)) return
    if (phase < 1 .or. phase > size(model%analysis%phases)) return
    text = text//'/'//integer_text(size(model%analysis%phases))
    if (.not. allocated(model%analysis%phases(phase)%name)) return
    text = text//' '//model%analysis%phases(phase)%name
  end function phase_text

  !> Appends the warnings in a text that are not in the list yet.
  pure subroutine keep_warnings(text, warnings)
    character(len=*), intent(in) :: text
    !> Warnings, one per line.
    character(len=:), allocatable, intent(inout) :: warnings
    integer :: start, last

    if (.not. allocated(warnings)) warnings = ''
    start = 1
    do while (start <= len(text))
      last = index(text(start:)//newline, newline) + start - 2
      associate (line => text(start:last))
        if (index(line, 'warning: ') > 0 .and. index(newline//warnings, newline//line//newline) == 0) &
          warnings = warnings//line//newline
      end associate
      start = last + 2
    end do
  end subroutine keep_warnings

  !> Returns the number of warnings and their texts; empty for none.
  pure function repeated_warnings(warnings) result(text)
    character(len=:), allocatable, intent(in) :: warnings
    character(len=:), allocatable :: text
    integer :: i, n

    text = ''
    if (.not. allocated(warnings)) return
    n = count([(warnings(i:i) == newline, i=1, len(warnings))])
    if (n > 0) text = 'warnings of this run: '//integer_text(n)//newline//warnings
  end function repeated_warnings
end module qsmpm_display
