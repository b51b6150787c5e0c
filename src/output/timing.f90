!> `timing.json`: seconds of a run and of those it continues in the same folder.
!>
!> Only this file and `job.log` tell seconds: all other results of a deck are the same bytes in every run.
module qsmpm_timing
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_file, only: file_exists, read_text, write_text
  use qsmpm_number_text, only: newline, real_text
  implicit none
  private

  public :: timing_type, timing_file, write_timing, read_timing

  !> Seconds of a run [s].
  type :: timing_type
    real(wp) :: cpu = 0.0_wp, wall = 0.0_wp
  end type timing_type

  character(len=*), parameter :: timing_file = 'timing.json'
  character(len=*), parameter :: cpu_key = '"cpu_seconds": ', wall_key = '"wall_seconds": '

contains

  !> Write the seconds.
  subroutine write_timing(directory, timing, error)
    !> Folder of the results.
    character(len=*), intent(in) :: directory
    type(timing_type), intent(in) :: timing
    type(error_type), allocatable, intent(out) :: error

    call write_text(directory//'/'//timing_file, '{'//newline//'  '//cpu_key//real_text(timing%cpu)//','// &
      newline//'  '//wall_key//real_text(timing%wall)//newline//'}'//newline, error, durable=.false.)
  end subroutine write_timing

  !> Seconds written before; zeros where there is no such file or it is not whole: they change no result.
  subroutine read_timing(directory, timing)
    !> Folder of the results.
    character(len=*), intent(in) :: directory
    type(timing_type), intent(out) :: timing
    type(error_type), allocatable :: error
    character(len=:), allocatable :: text

    if (.not. file_exists(directory//'/'//timing_file)) return
    call read_text(directory//'/'//timing_file, text, error)
    if (allocated(error)) return
    timing%cpu = number_behind(text, cpu_key)
    timing%wall = number_behind(text, wall_key)
  end subroutine read_timing

  !> The number behind a key, 0 when there is none.
  pure real(wp) function number_behind(text, key)
    character(len=*), intent(in) :: text, key
    integer :: at, status

    number_behind = 0.0_wp
    at = index(text, key)
    if (at == 0) return
    read (text(at + len(key):), *, iostat=status) number_behind
    if (status /= 0) number_behind = 0.0_wp
  end function number_behind
end module qsmpm_timing
