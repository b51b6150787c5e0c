!> Seconds of the wall clock and of the processor.
!>
!> A clock is started once and asked often; two clocks know nothing of each other. The processor
!> seconds are those of the whole process, all threads together.
module qsmpm_clock
  use, intrinsic :: iso_fortran_env, only: real64
  use qsmpm_kinds, only: wp, long
  implicit none
  private

  public :: clock_type, start_clock, wall_seconds, cpu_seconds

  !> Both readings at the start.
  type :: clock_type
    real(wp) :: wall_start = 0.0_wp
    real(wp) :: cpu_start = 0.0_wp
  end type clock_type

contains

  !> Start counting.
  subroutine start_clock(clock)
    type(clock_type), intent(out) :: clock

    clock%wall_start = wall_reading()
    clock%cpu_start = cpu_reading()
  end subroutine start_clock

  !> Seconds gone since the start.
  real(wp) function wall_seconds(clock)
    type(clock_type), intent(in) :: clock

    wall_seconds = wall_reading() - clock%wall_start
  end function wall_seconds

  !> Processor seconds spent by all threads since the start.
  real(wp) function cpu_seconds(clock)
    type(clock_type), intent(in) :: clock

    cpu_seconds = cpu_reading() - clock%cpu_start
  end function cpu_seconds

  !> Wall clock [s]; 64-bit counts, so that it does not wrap round.
  real(wp) function wall_reading()
    integer(long) :: count, rate

    call system_clock(count, rate)
    wall_reading = real(count, wp)/real(rate, wp)
  end function wall_reading

  !> Processor time of the process [s].
  real(wp) function cpu_reading()
    real(real64) :: seconds

    call cpu_time(seconds)
    cpu_reading = real(seconds, wp)
  end function cpu_reading
end module qsmpm_clock
