!> Profile of a run as text and as a file: the line of shares at the end of the log, the table printed by `--profile`,
!> and `profile.json` for programs.
!>
!> Shares refer to processor time, or to wall-clock time if several threads are used: on some systems waiting threads
!> are busy and would be attributed to parts that run on one thread.
!>
!> `timing.json` has the seconds of a run and of the runs that it continues in the same folder.
!>
!> Only these files and `job.log` contain times: all other results of a deck are identical in every run.
module qsmpm_profile_report
  use qsmpm_kinds, only: wp, long
  use qsmpm_number_text, only: integer_text, newline, real_text
  use qsmpm_posix, only: peak_memory
  use qsmpm_run_profile, only: run_profile_type
  use qsmpm_stopwatch, only: part_count, part_names
  use qsmpm_error, only: error_type
  use qsmpm_file, only: file_exists, read_text, write_text
  implicit none
  private

  public :: shares_line, profile_table, profile_json, timing_type, timing_file, write_timing, read_timing

  !> Minimum share of a part to be mentioned in the log.
  real(wp), parameter :: least_share = 0.005_wp

  !> Run time [s].
  type :: timing_type
    real(wp) :: cpu = 0.0_wp, wall = 0.0_wp
  end type timing_type

  character(len=*), parameter :: timing_file = 'timing.json'
  character(len=*), parameter :: cpu_key = '"cpu_seconds": ', wall_key = '"wall_seconds": '

contains

  !> Returns `time: evaluation 41 %, ...`: the parts in descending order.
  function shares_line(profile, threads) result(line)
    type(run_profile_type), intent(in) :: profile
    !> Number of threads of the run.
    integer, intent(in) :: threads
    character(len=:), allocatable :: line
    real(wp) :: share(part_count)
    character(len=:), allocatable :: between
    integer :: i, part

    share = shares(profile, threads)
    line = 'time:'
    between = ' '
    do i = 1, part_count
      part = maxloc(share, dim=1)
      if (share(part) < least_share) exit
      line = line//between//trim(part_names(part))//' '//integer_text(nint(100.0_wp*share(part)))//' %'
      between = ', '
      share(part) = -1.0_wp
    end do
    line = line//'; '//fixed(sum(profile%watch%cpu), 2)//' s of processor, '// &
      fixed(real(peak_memory(), wp)/1048576.0_wp, 1)//' MiB at the most'
  end function shares_line

  !> Returns the share of each part, 0 if no time was measured.
  pure function shares(profile, threads) result(share)
    type(run_profile_type), intent(in) :: profile
    !> Number of threads of the run.
    integer, intent(in) :: threads
    real(wp) :: share(part_count)

    share = profile%watch%cpu
    if (threads > 1) share = profile%watch%wall
    share = share/max(sum(share), tiny(1.0_wp))
  end function shares

  !> Returns a table with a line per part: processor and wall-clock seconds, calls, share.
  function profile_table(profile, threads) result(text)
    type(run_profile_type), intent(in) :: profile
    !> Number of threads of the run.
    integer, intent(in) :: threads
    character(len=:), allocatable :: text
    real(wp) :: share(part_count)
    character(len=80) :: line
    integer :: part

    share = shares(profile, threads)
    write (line, '(a14,2x,3a12,a10)') 'part          ', 'CPU s', 'wall s', 'calls', 'share %'
    text = trim(line)
    do part = 1, part_count
      write (line, '(a14,2x,2f12.3,i12,f10.1)') part_names(part), profile%watch%cpu(part), profile%watch%wall(part), &
        profile%watch%calls(part), 100.0_wp*share(part)
      text = text//newline//trim(line)
    end do
    text = text//newline//integer_text(profile%steps)//' steps, '// &
      integer_text(profile%iterations)//' iterations, '// &
      integer_text(profile%evaluations)//' evaluations, '//integer_text(profile%factorisations)//' factorisations'
  end function profile_table

  !> Returns the profile as a JSON object.
  function profile_json(profile, threads) result(text)
    type(run_profile_type), intent(in) :: profile
    !> Number of threads of the run.
    integer, intent(in) :: threads
    character(len=:), allocatable :: text
    integer :: part

    text = '{'//newline//'  "threads": '//integer_text(threads)//','//newline// &
      '  "cpu_seconds": '//real_text(sum(profile%watch%cpu))//','//newline// &
      '  "wall_seconds": '//real_text(sum(profile%watch%wall))//','//newline// &
      '  "peak_memory_bytes": '//integer_text(peak_memory())//','//newline
    if (allocated(profile%solver)) text = text//'  "solver": "'//profile%solver//'",'//newline
    text = text//count_lines(profile)//'  "parts": {'
    do part = 1, part_count
      text = text//newline//'    "'//trim(part_names(part))//'": {"cpu_seconds": '// &
        real_text(profile%watch%cpu(part))//', "wall_seconds": '//real_text(profile%watch%wall(part))// &
        ', "calls": '//integer_text(profile%watch%calls(part))//'}'
      if (part < part_count) text = text//','
    end do
    text = text//newline//'  }'//newline//'}'//newline
  end function profile_json

  !> Returns the counts, one per line.
  pure function count_lines(profile) result(text)
    type(run_profile_type), intent(in) :: profile
    character(len=:), allocatable :: text

    text = count_line('steps', profile%steps)//count_line('iterations', profile%iterations)// &
      count_line('evaluations', profile%evaluations)//count_line('stress_updates', profile%stress_updates)// &
      count_line('point_iterations', profile%point_iterations)// &
      count_line('factorisations', profile%factorisations)//count_line('sweeps', profile%sweeps)// &
      count_line('most_sweeps', profile%most_sweeps)//count_line('points', profile%points)// &
      count_line('active_cells', profile%active_cells)//count_line('equations', profile%equations)// &
      count_line('bandwidth', profile%bandwidth)//count_line('matrix_entries', profile%matrix_entries)// &
      count_line('factor_entries', profile%factor_entries)// &
      '  "factor_operations": '//real_text(profile%factor_operations)//','//newline
  end function count_lines

  !> Returns `  "name": number,`.
  pure function count_line(name, number) result(line)
    !> Name of the count.
    character(len=*), intent(in) :: name
    !> The count.
    integer(long), intent(in) :: number
    character(len=:), allocatable :: line

    line = '  "'//name//'": '//integer_text(number)//','//newline
  end function count_line

  !> Returns a number with a fixed number of decimals.
  pure function fixed(value, decimals) result(text)
    !> The number.
    real(wp), intent(in) :: value
    integer, intent(in) :: decimals
    character(len=:), allocatable :: text
    character(len=24) :: buffer

    write (buffer, '(f24.'//integer_text(decimals)//')') value
    text = trim(adjustl(buffer))
  end function fixed

  !> Writes the run times.
  subroutine write_timing(directory, timing, error)
    !> Folder of the results.
    character(len=*), intent(in) :: directory
    type(timing_type), intent(in) :: timing
    type(error_type), allocatable, intent(out) :: error

    call write_text(directory//'/'//timing_file, '{'//newline//'  '//cpu_key//real_text(timing%cpu)//','// &
      newline//'  '//wall_key//real_text(timing%wall)//newline//'}'//newline, error, durable=.false.)
  end subroutine write_timing

  !> Reads the run times written before; zeros if there is no file or it is incomplete, since they have no effect on
  !> results.
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

  !> Returns the number after a key, 0 if there is none.
  pure real(wp) function number_behind(text, key)
    character(len=*), intent(in) :: text, key
    integer :: at, status

    number_behind = 0.0_wp
    at = index(text, key)
    if (at == 0) return
    read (text(at + len(key):), *, iostat=status) number_behind
    if (status /= 0) number_behind = 0.0_wp
  end function number_behind
end module qsmpm_profile_report
