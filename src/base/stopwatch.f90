!> Distribution of the run time: wall-clock and processor seconds of each part.
!>
!> A stopwatch always counts for one part; switching to another part ends the interval of the last one. Every second
!> since the start therefore belongs to exactly one part and the parts add up to the total. Each switch reads two
!> system clocks, which takes a third of a microsecond: switch around complete phases of a step, not inside loops over
!> points or cells. Processor seconds are those of the process, the sum over all threads.
!>
!> A clock is started once and read repeatedly; clocks are independent of each other.
module qsmpm_stopwatch
  use, intrinsic :: iso_fortran_env, only: real64
  use qsmpm_kinds, only: wp, long
  implicit none
  private

  public :: clock_type, start_clock, wall_seconds, cpu_seconds, stopwatch_type, start_stopwatch, switch_timer

  !> Parts of a run.
  integer, parameter, public :: part_input = 1, part_initialisation = 2, part_analysis = 3, part_evaluation = 4, &
    part_assembly = 5, part_factorisation = 6, part_solves = 7, part_step_error = 8, &
    part_convection = 9, part_output = 10, part_control = 11, part_count = 11

  integer, parameter :: name_length = 14
  !> Names of the parts, for tables and files.
  character(len=name_length), parameter, public :: part_names(part_count) = [character(len=name_length) :: &
    'input', 'initialisation', 'analysis', 'evaluation', 'assembly', 'factorisation', 'solves', 'step error', &
    'convection', 'output', 'control']

  !> Readings of both clocks at the start.
  type :: clock_type
    real(wp) :: wall_start = 0.0_wp
    real(wp) :: cpu_start = 0.0_wp
  end type clock_type

  !> Accumulated times and counts.
  type :: stopwatch_type
    !> Wall-clock and processor seconds of each part.
    real(wp) :: wall(part_count) = 0.0_wp
    real(wp) :: cpu(part_count) = 0.0_wp
    !> Number of switches to each part.
    integer(long) :: calls(part_count) = 0
    !> Current part, 0 before the start.
    integer, private :: part = 0
    type(clock_type), private :: clock
    !> Readings at the last switch.
    real(wp), private :: wall_last = 0.0_wp, cpu_last = 0.0_wp
  end type stopwatch_type

contains

  !> Resets all times and starts to count for a part. A stopwatch that was not started does nothing.
  subroutine start_stopwatch(watch, part)
    type(stopwatch_type), intent(out) :: watch
    !> One of the part_* values.
    integer, intent(in) :: part

    call start_clock(watch%clock)
    watch%part = part
    watch%calls(part) = 1
  end subroutine start_stopwatch

  !> Ends the interval of the current part and counts for another one from now on.
  subroutine switch_timer(watch, part)
    type(stopwatch_type), intent(inout) :: watch
    !> One of the part_* values; the current one to update its time.
    integer, intent(in) :: part
    real(wp) :: wall, cpu

    if (watch%part == 0) return
    wall = wall_seconds(watch%clock)
    cpu = cpu_seconds(watch%clock)
    watch%wall(watch%part) = watch%wall(watch%part) + (wall - watch%wall_last)
    watch%cpu(watch%part) = watch%cpu(watch%part) + (cpu - watch%cpu_last)
    watch%wall_last = wall
    watch%cpu_last = cpu
    if (part /= watch%part) watch%calls(part) = watch%calls(part) + 1
    watch%part = part
  end subroutine switch_timer

  !> Starts a clock.
  subroutine start_clock(clock)
    type(clock_type), intent(out) :: clock

    clock%wall_start = wall_reading()
    clock%cpu_start = cpu_reading()
  end subroutine start_clock

  !> Returns the wall-clock seconds since the start.
  real(wp) function wall_seconds(clock)
    type(clock_type), intent(in) :: clock

    wall_seconds = wall_reading() - clock%wall_start
  end function wall_seconds

  !> Returns the processor seconds of all threads since the start.
  real(wp) function cpu_seconds(clock)
    type(clock_type), intent(in) :: clock

    cpu_seconds = cpu_reading() - clock%cpu_start
  end function cpu_seconds

  !> Returns the wall clock [s]; 64-bit counts do not wrap around.
  real(wp) function wall_reading()
    integer(long) :: count, rate

    call system_clock(count, rate)
    wall_reading = real(count, wp)/real(rate, wp)
  end function wall_reading

  !> Returns the processor time of the process [s].
  real(wp) function cpu_reading()
    real(real64) :: seconds

    call cpu_time(seconds)
    cpu_reading = real(seconds, wp)
  end function cpu_reading
end module qsmpm_stopwatch
