!> What the user sees of a run: on a terminal one line that is refreshed, elsewhere plain lines,
!> every step of a short run and a bounded number of lines of a long one.
!>
!> Warnings of a run, a line each, to be said again at its end.
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

  !> How a run shows itself: not at all, by lines, by a line that is refreshed, by its warnings and results alone.
  integer, parameter, public :: display_none = 0, display_plain = 1, display_terminal = 2, display_quiet = 3

  !> Share of the run after which a plain line is due, and seconds; for long runs the seconds grow
  !> with the time gone, so that a day's run has a few hundred lines.
  real(wp), parameter :: share_between_lines = 0.01_wp, seconds_between_lines = 1.0_wp
  real(wp), parameter :: growth_of_seconds = 0.01_wp
  !> Seconds between two refreshments of a terminal's line.
  real(wp), parameter :: seconds_between_refreshments = 0.1_wp

  integer, parameter :: standard_output = 1, error_output = 2
  !> Back to the start of the line and clear it.
  character(len=*), parameter :: clear_line = achar(13)//achar(27)//'[K'

  !> What is shown, and when it was.
  type :: display_type
    integer :: kind = display_none
    type(clock_type) :: clock
    !> Share of the run done at the start and at the last line, and when that was [s].
    real(wp) :: start_share = 0.0_wp
    real(wp) :: last_share = -1.0_wp
    real(wp) :: last_time = 0.0_wp
    !> Whether a refreshed line stands on the terminal.
    logical :: line_stands = .false.
  end type display_type

contains

  !> Begin to show a run.
  subroutine start_display(display, kind, model)
    type(display_type), intent(out) :: display
    !> One of the display_* values.
    integer, intent(in) :: kind
    type(model_type), intent(in) :: model

    display%kind = kind
    call start_clock(display%clock)
    display%start_share = share_done(model)
  end subroutine start_display

  !> Show an accepted step, if it is time to.
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
    ! Time left, from the share done since the start.
    if (share - display%start_share <= 0.0_wp) then
      text = 'remaining time unknown'
    else
      text = duration_text(seconds*(1.0_wp - share)/(share - display%start_share))//' remaining'
    end if
    line = step_text(model, record)//', '//text
    if (display%kind == display_terminal) then
      ! As much of a line as the terminal is wide: a longer one could not be refreshed.
      part = line
      width = terminal_width(standard_output) - 1
      if (width > 0 .and. width < len(line)) part = line(:width)
      call write_descriptor(standard_output, clear_line//part)
      display%line_stands = .true.
    else
      call write_descriptor(standard_output, line//newline)
    end if
  end subroutine show_step

  !> Show sentences on lines of their own; to those who want it quiet the warnings among them, as errors.
  subroutine show_text(display, text)
    type(display_type), intent(inout) :: display
    !> A sentence a line.
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: warnings

    if (display%kind == display_quiet) then
      call keep_warnings(text, warnings)
      if (len(warnings) > 0) call write_descriptor(error_output, warnings)
    else
      call show_result(display, text)
    end if
  end subroutine show_text

  !> Show a result on a line of its own.
  subroutine show_result(display, text)
    type(display_type), intent(inout) :: display
    !> The sentence.
    character(len=*), intent(in) :: text

    if (display%kind == display_none) return
    if (display%line_stands) call write_descriptor(standard_output, clear_line)
    display%line_stands = .false.
    call write_descriptor(standard_output, text//newline)
  end subroutine show_result

  !> Leave the last line where it stands.
  subroutine end_display(display)
    type(display_type), intent(inout) :: display

    if (display%line_stands) call write_descriptor(standard_output, newline)
    display%line_stands = .false.
  end subroutine end_display

  !> Whether a step is to be shown.
  pure logical function is_due(display, seconds, share)
    type(display_type), intent(in) :: display
    !> Time gone [s]; share of the run done.
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

  !> Share of all phases done.
  pure real(wp) function share_done(model)
    type(model_type), intent(in) :: model
    integer :: phases

    phases = 1
    if (allocated(model%analysis%phases)) phases = max(1, size(model%analysis%phases))
    share_done = (real(model%state%progress%phase - 1, wp) + model%state%progress%fraction) /real(phases, wp)
  end function share_done

  !> A step in a line.
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

  !> The present phase.
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

  !> Keep the lines of a text that are warnings, each once.
  pure subroutine keep_warnings(text, warnings)
    character(len=*), intent(in) :: text
    !> A line each.
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

  !> How many there are, and what they say; empty for none.
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
