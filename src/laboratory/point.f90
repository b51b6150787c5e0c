!> `qsmpm point`: laboratory test on one material point, from the deck to curves.csv, the echo and job.log, whose last
!> line is `qsmpm: finished` only if the test finished. A step without equilibrium is cut back; if no cut-back converges
!> the test ends, and the rows so far are kept.
module qsmpm_point
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: analysis_type
  use qsmpm_stopwatch, only: clock_type, start_clock, cpu_seconds, wall_seconds
  use qsmpm_card_visitors, only: lines_type
  use qsmpm_deck, only: read_deck, echo_text
  use qsmpm_keyword_table, only: test_words, kinematics_words
  use qsmpm_error, only: error_type, error_deck, error_other, error_not_converged, fail, prefix
  use qsmpm_file, only: write_text, file_exists
  use qsmpm_folder_lock, only: folder_lock_type, lock_folder, unlock_folder
  use qsmpm_law, only: law_type, batch_type, step_info_type
  use qsmpm_material_law, only: make_material_law
  use qsmpm_messages, only: message_list_type, message_text
  use qsmpm_number_text, only: integer_text, newline, seconds_text, without_last_newline
  use qsmpm_point_curves, only: point_row_type, point_header, point_row
  use qsmpm_point_driver, only: point_type, start_point, prepare_point, control_point, control_type
  use qsmpm_point_stages, only: ramp_type, begin_ramps, aim_ramps, set_controls
  use qsmpm_point_test, only: point_stage_type, point_test_type
  use qsmpm_point_statistics, only: point_statistics_type, take_tangent, tangent_text, state_text
  use qsmpm_posix, only: remove_file, system_message
  use qsmpm_tensor, only: stress_size
  use qsmpm_profile_report, only: timing_type, timing_file, write_timing
  implicit none
  private

  public :: point_request_type, run_point, point_summary, point_law, refuse_point, bench_type, run_stages

  !> Input of a run.
  type :: point_request_type
    !> Path of the deck.
    character(len=:), allocatable :: deck
    !> Directory of the results; empty for output/<job>.
    character(len=:), allocatable :: directory
    !> Compare the tangent of the law with finite differences in every step.
    logical :: tangent = .false.
    !> Head of the log.
    character(len=:), allocatable :: banner
  end type point_request_type

  !> Data of a running test.
  type :: bench_type
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(batch_type) :: batch
    type(ramp_type), allocatable :: ramps(:)
    type(point_statistics_type) :: statistics
    !> Table and log so far.
    type(lines_type) :: curves
    character(len=:), allocatable :: log
    logical :: tangent = .false.
  end type bench_type

  !> Smallest part of a step that is tried, and bounds of the share that a law may request.
  real(wp), parameter :: smallest_part = 1.0_wp/1024.0_wp, least_share = 0.1_wp, most_share = 0.9_wp
  character(len=*), parameter :: finished_line = 'qsmpm: finished'

contains

  !> Runs the test of a deck.
  subroutine run_point(request, text, report, exit_code)
    type(point_request_type), intent(in) :: request
    !> The log, empty if nothing was run.
    character(len=:), allocatable, intent(out) :: text
    !> Warnings and errors, one per line.
    character(len=:), allocatable, intent(out) :: report
    !> 0 if the test finished; otherwise the code of the error.
    integer, intent(out) :: exit_code
    type(analysis_type) :: analysis
    type(message_list_type) :: messages
    type(bench_type) :: bench
    type(clock_type) :: clock
    type(folder_lock_type) :: lock
    type(error_type), allocatable :: error
    character(len=:), allocatable :: directory

    call start_clock(clock)
    text = ''
    exit_code = 0
    call read_deck(request%deck, analysis, messages, error)
    report = message_text(messages)
    if (.not. allocated(error) .and. .not. analysis%point_test%given) call fail(error, error_deck, request%deck// &
      ': the deck has no *POINT TEST: `qsmpm run` is for scenes')
    if (.not. allocated(error)) call point_law(analysis, bench%law, error)
    if (.not. allocated(error)) then
      bench%tangent = request%tangent
      bench%log = request%banner//newline//point_summary(analysis)
      if (allocated(bench%law%advice)) bench%log = bench%log//"material '"//analysis%point_test%material//"': "// &
        bench%law%advice//newline
      directory = request%directory
      if (len(directory) == 0) directory = 'output/'//analysis%job
      call lock_folder(lock, directory, error)
    end if
    if (.not. allocated(error)) then
      call remove_earlier_test(directory, error)
      if (.not. allocated(error)) call run_locked(analysis, directory, clock, bench, error)
      call unlock_folder(lock)
    end if
    if (allocated(bench%log)) text = bench%log
    if (.not. allocated(error)) return
    report = report//without_last_newline(error%message)//newline
    exit_code = error%code
  end subroutine run_point

  !> Rejects a test of one point where a boundary value problem is required.
  subroutine refuse_point(scene, error)
    !> Contents of the deck.
    type(analysis_type), intent(in) :: scene
    !> Set if it is a test of one point.
    type(error_type), allocatable, intent(out) :: error

    if (scene%point_test%given) call fail(error, error_deck, scene%deck// &
      ': the deck is a test of one point: `qsmpm point` runs it')
  end subroutine refuse_point

  !> Returns the law of the tested material.
  subroutine point_law(analysis, law, error)
    type(analysis_type), intent(in) :: analysis
    class(law_type), allocatable, intent(out) :: law
    !> Set if a parameter is out of its range.
    type(error_type), allocatable, intent(out) :: error
    integer :: m

    do m = 1, size(analysis%materials)
      if (analysis%materials(m)%name /= analysis%point_test%material) cycle
      call make_material_law(analysis%materials(m), analysis%method, analysis%point_test%stress, &
        analysis%point_test%dimension, law, error)
      if (allocated(error)) call prefix(error, analysis%deck//": material '"//analysis%materials(m)%name//"'")
      return
    end do
  end subroutine point_law

  !> Returns a short summary of the test.
  pure function point_summary(analysis) result(text)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: text
    integer :: i, steps

    associate (test => analysis%point_test)
      steps = 0
      do i = 1, size(test%stages)
        steps = steps + test%stages(i)%steps*size(test%stages(i)%targets, 2)
      end do
      text = 'point test '//analysis%job//': '//trim(test_words(test%kind))//", material '"//test%material//"', "// &
        trim(kinematics_words(analysis%method%kinematics))//', '//integer_text(test%dimension)//'D, '// &
        integer_text(size(test%stages))//trim(merge(' stage ', ' stages', size(test%stages) == 1))//', '// &
        integer_text(steps)//trim(merge(' step ', ' steps', steps == 1))//newline
    end associate
  end function point_summary

  !> Runs the test and writes into a directory locked against other runs.
  subroutine run_locked(analysis, directory, clock, bench, error)
    type(analysis_type), intent(in) :: analysis
    !> Directory of the results.
    character(len=*), intent(in) :: directory
    !> Started with the program.
    type(clock_type), intent(in) :: clock
    !> The test; its log is extended.
    type(bench_type), intent(inout) :: bench
    !> Set if the test did not finish or could not be written.
    type(error_type), allocatable, intent(out) :: error
    type(error_type), allocatable :: trouble
    character(len=:), allocatable :: echo

    call echo_text(analysis, echo)
    call write_text(directory//'/'//analysis%job//'.echo.inp', echo, error, durable=.false.)
    if (allocated(error)) return
    call run_stages(analysis, bench, error)
    if (bench%tangent) bench%log = bench%log//tangent_text(bench%statistics)//newline
    bench%log = bench%log//integer_text(bench%statistics%steps)//' steps, '// &
      integer_text(bench%statistics%iterations)//' iterations, '//seconds_text(cpu_seconds(clock))//' s'//newline
    if (allocated(error)) then
      bench%log = bench%log//error%message//newline
    else
      bench%log = bench%log//finished_line//newline
    end if
    call write_text(directory//'/curves.csv', bench%curves%text(:bench%curves%length), trouble, durable=.false.)
    if (.not. allocated(trouble)) call write_timing(directory, &
      timing_type(cpu=cpu_seconds(clock), wall=wall_seconds(clock)), trouble)
    if (.not. allocated(trouble)) call write_text(directory//'/job.log', bench%log, trouble, durable=.false.)
    if (allocated(trouble) .and. .not. allocated(error)) call move_alloc(trouble, error)
  end subroutine run_locked

  !> Removes the results of an earlier test, so that an interrupted test does not look finished.
  subroutine remove_earlier_test(directory, error)
    character(len=*), intent(in) :: directory
    !> Set if a file cannot be removed.
    type(error_type), allocatable, intent(out) :: error
    character(len=*), parameter :: results(3) = [character(len=11) :: 'job.log', 'curves.csv', timing_file]
    integer :: i

    do i = 1, size(results)
      if (.not. file_exists(directory//'/'//trim(results(i)))) cycle
      if (remove_file(directory//'/'//trim(results(i))) /= 0) call fail(error, error_other, "cannot remove '"// &
        directory//'/'//trim(results(i))//"': "//system_message())
    end do
  end subroutine remove_earlier_test

  !> Runs all stages.
  subroutine run_stages(analysis, bench, error)
    type(analysis_type), intent(in) :: analysis
    type(bench_type), intent(inout) :: bench
    !> Set if there is no equilibrium.
    type(error_type), allocatable, intent(out) :: error
    type(point_row_type) :: row
    integer :: i, k

    associate (test => analysis%point_test)
      call start_point(bench%law, test%stress(:stress_size(test%dimension)), bench%point)
      call prepare_point(bench%law, bench%batch)
      bench%batch%cell_size = measured_width(analysis)
      call begin_ramps(test, bench%ramps)
      call bench%curves%line(point_header(test, analysis%force_unit//'/'//analysis%length_unit//'^2', bench%law, &
        bench%tangent))
      row%time = test%start_time
      call bench%curves%line(point_row(test, bench%law, bench%point, row, bench%tangent))
      do i = 1, size(test%stages)
        row%stage = i
        row%increments = 0
        do k = 1, size(test%stages(i)%targets, 2)
          call aim_ramps(test, test%stages(i)%driven_components, test%stages(i)%targets(:, k), bench%point, bench%ramps)
          call run_targets(analysis, k, bench, row, error)
          if (allocated(error)) return
        end do
        bench%log = bench%log//'stage '//integer_text(i)//': '//state_text(test, bench%point)//newline
      end do
    end associate
  end subroutine run_stages

  !> Width of a sample: that of the band in which softening was measured, so that a test reproduces the measurement.
  pure real(wp) function measured_width(analysis)
    type(analysis_type), intent(in) :: analysis
    integer :: m

    measured_width = 1.0_wp
    m = place_named(analysis%materials, analysis%point_test%material)
    if (m == 0) return
    if (analysis%materials(m)%softening%length > 0.0_wp) measured_width = analysis%materials(m)%softening%length
  end function measured_width

  !> Runs the steps to one row of targets.
  subroutine run_targets(analysis, number, bench, row, error)
    type(analysis_type), intent(in) :: analysis
    !> Number of the targets in their stage.
    integer, intent(in) :: number
    type(bench_type), intent(inout) :: bench
    !> Row of the previous step.
    type(point_row_type), intent(inout) :: row
    !> Set if there is no equilibrium.
    type(error_type), allocatable, intent(out) :: error
    integer :: k
    real(wp) :: rows

    associate (test => analysis%point_test, stage => analysis%point_test%stages(row%stage))
      rows = real(size(stage%targets, 2), wp)
      do k = 1, stage%steps
        row%step = row%step + 1
        call run_step(test, number, k, bench, row, error)
        if (allocated(error)) then
          call prefix(error, 'stage '//integer_text(row%stage)//', step '//integer_text(row%step)//' (the last '// &
            'equilibrium: '//state_text(test, bench%point)//')')
          return
        end if
        row%load_factor = (real(number - 1, wp) + real(k, wp)/real(stage%steps, wp))/rows
        if (bench%tangent) call take_tangent(bench%statistics, bench%law, bench%batch, row%step, row%tangent_error)
        bench%statistics%steps = row%step
        call bench%curves%line(point_row(test, bench%law, bench%point, row, bench%tangent))
      end do
    end associate
  end subroutine run_targets

  !> Runs one step, in parts where it has no equilibrium.
  subroutine run_step(test, number, step, bench, row, error)
    type(point_test_type), intent(in) :: test
    !> Number of the targets in their stage, and of the step to them.
    integer, intent(in) :: number, step
    type(bench_type), intent(inout) :: bench
    !> Its corrections and parts are increased.
    type(point_row_type), intent(inout) :: row
    !> Set if there is no equilibrium.
    type(error_type), allocatable, intent(out) :: error
    type(control_type) :: controls(size(bench%ramps))
    type(step_info_type) :: step_info
    real(wp) :: done, part, steps, rows
    integer :: iterations

    steps = real(test%stages(row%stage)%steps, wp)
    rows = real(size(test%stages(row%stage)%targets, 2), wp)
    row%iterations = 0
    row%parts = 0
    done = 0.0_wp
    part = 1.0_wp
    do while (done < 1.0_wp)
      call set_controls(bench%ramps, (real(step - 1, wp) + min(1.0_wp, done + part))/steps, controls)
      step_info = step_info_type(row%stage, row%step, row%increments + 1, &
        (real(number - 1, wp) + (real(step - 1, wp) + done)/steps)/rows, part/(steps*rows), &
        test%start_time + sum(test%stages(:row%stage - 1)%duration), test%stages(row%stage)%duration)
      if (allocated(test%stages(row%stage)%times)) &
        call take_times(test%stages(row%stage), number, step, done, part, step_info)
      call control_point(bench%law, bench%point, controls, test%tolerance, step_info, bench%batch, iterations, error)
      row%iterations = row%iterations + iterations
      bench%statistics%iterations = bench%statistics%iterations + iterations
      if (.not. allocated(error)) then
        row%parts = row%parts + 1
        row%increments = row%increments + 1
        done = done + part
        part = min(2.0_wp*part, 1.0_wp - done)
        row%time = step_info%phase_start + (step_info%start + step_info%duration)*step_info%phase_time
      else
        if (error%code /= error_not_converged .or. part <= smallest_part) return
        part = part*smaller(bench%batch%share)
      end if
    end do
  end subroutine run_step

  !> Sets start and duration of a part of a step to a row of a table with times, relative to the stage.
  pure subroutine take_times(stage, number, step, done, part, step_info)
    type(point_stage_type), intent(in) :: stage
    !> Number of the row, and of the step to it.
    integer, intent(in) :: number, step
    !> Completed share of the step, and share of the part.
    real(wp), intent(in) :: done, part
    !> Times of the part.
    type(step_info_type), intent(inout) :: step_info
    real(wp) :: before, length

    before = 0.0_wp
    if (number > 1) before = stage%times(number - 1)
    length = (stage%times(number) - before)/(real(stage%steps, wp)*stage%duration)
    step_info%start = before/stage%duration + (real(step - 1, wp) + done)*length
    step_info%duration = part*length
  end subroutine take_times

  !> Share of a part that is tried next.
  pure real(wp) function smaller(share)
    !> Share requested by the law; 0 if none.
    real(wp), intent(in) :: share

    smaller = 0.5_wp
    if (share > 0.0_wp) smaller = min(max(share, least_share), most_share)
  end function smaller
end module qsmpm_point
