!> A deck from the file to the results: read, build, record, run. Only the recorder writes, and
!> nothing is written before deck, model and restart file are known to be good.
!>
!> The caller gets an exit code and the sentences that belong on the error output.
module qsmpm_run
  use omp_lib, only: omp_set_num_threads
  use qsmpm_analysis, only: analysis_type
  use qsmpm_blas_threads, only: set_blas_threads
  use qsmpm_clock, only: start_clock
  use qsmpm_deck, only: read_deck, echo_text
  use qsmpm_display, only: display_plain
  use qsmpm_error, only: error_type, error_other, error_deck, fail
  use qsmpm_file, only: write_text
  use qsmpm_law, only: law_type
  use qsmpm_messages, only: message_list_type, message_text
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model, model_summary
  use qsmpm_number_text, only: without_last_newline
  use qsmpm_plan, only: make_plan
  use qsmpm_plan_items, only: plan_items_type, plan_text, plan_json
  use qsmpm_point, only: point_law, point_summary
  use qsmpm_phases, only: run_phases, error_stopped
  use qsmpm_profile_report, only: profile_json, profile_table, shares_line
  use qsmpm_recorder, only: recorder_type, recorder_options_type, create, close, profile_file, signal_number
  use qsmpm_restart, only: read_restart, text_fingerprint
  use qsmpm_run_profile, only: run_profile_type
  use qsmpm_stopwatch, only: start_stopwatch, turn_to, part_input, part_output
  use qsmpm_reduction, only: expansion_type, verdict_type
  use qsmpm_scene, only: reduce_scene
  use qsmpm_version, only: version, compiler, build_type
  use qsmpm_whole_scene, only: whole_scene_type, begin_whole
  implicit none
  private

  public :: run_request_type, run_deck, check_deck, plan_deck, program_name

  !> What is to be run, and how.
  type :: run_request_type
    !> Path of the deck.
    character(len=:), allocatable :: deck
    !> Directory of the results; empty asks for output/<job>.
    character(len=:), allocatable :: directory
    !> Restart file that the run continues, empty for a run from the start.
    character(len=:), allocatable :: restart
    integer :: threads = 1
    !> Show where the time went, and write it to profile.json.
    logical :: profile = .false.
    !> One of the display_* values of qsmpm_display.
    integer :: display = display_plain
  end type run_request_type

  character(len=1), parameter :: newline = new_line('a')
  !> What a signal's number is added to in an exit code.
  integer, parameter :: signal_base = 128

contains

  !> The program's name, version and make.
  pure function program_name() result(text)
    character(len=:), allocatable :: text

    text = 'qsmpm '//version//' ('//compiler//', '//build_type//')'
  end function program_name

  !> Read a deck and build its model: the smallest one where the deck leaves it open. A test of one point has none.
  subroutine load_deck(path, scene, expansion, verdicts, model, warnings, error)
    !> Path of the deck.
    character(len=*), intent(in) :: path
    !> The scene as the deck says it, with all defaults, and the way back to it from the model.
    type(analysis_type), intent(out) :: scene
    type(expansion_type), intent(out) :: expansion
    !> What was found about its reductions.
    type(verdict_type), allocatable, intent(out) :: verdicts(:)
    !> The model.
    type(model_type), intent(out) :: model
    !> What the reader has to say, one sentence a line; empty when nothing.
    character(len=:), allocatable, intent(out) :: warnings
    !> Set when the deck or the model is not good.
    type(error_type), allocatable, intent(out) :: error
    type(analysis_type) :: analysis
    type(message_list_type) :: messages

    call read_deck(path, scene, messages, error)
    warnings = message_text(messages)
    if (allocated(error)) return
    if (scene%point_test%given) return
    call reduce_scene(scene, analysis, expansion, verdicts)
    call build_model(analysis, model, error)
    if (allocated(error)) return
    scene%method = model%analysis%method
    scene%materials = model%analysis%materials
  end subroutine load_deck

  !> A test of one point is no scene.
  subroutine refuse_point(path, scene, error)
    !> Path of the deck.
    character(len=*), intent(in) :: path
    !> What it says.
    type(analysis_type), intent(in) :: scene
    !> Set when it is a test of one point.
    type(error_type), allocatable, intent(out) :: error

    if (scene%point_test%given) call fail(error, error_deck, path// &
      ': the deck is a test of one point: `qsmpm point` runs it')
  end subroutine refuse_point

  !> Read, mesh and seed a deck and tell its totals.
  subroutine check_deck(path, summary, report, exit_code)
    !> Path of the deck.
    character(len=*), intent(in) :: path
    !> Totals, empty when the deck is not good.
    character(len=:), allocatable, intent(out) :: summary
    !> Warnings and errors, one a line.
    character(len=:), allocatable, intent(out) :: report
    !> 0, or the code of the error.
    integer, intent(out) :: exit_code
    type(model_type) :: model
    type(analysis_type) :: scene
    type(expansion_type) :: expansion
    type(verdict_type), allocatable :: verdicts(:)
    type(error_type), allocatable :: error
    class(law_type), allocatable :: law

    exit_code = 0
    summary = ''
    call load_deck(path, scene, expansion, verdicts, model, report, error)
    if (scene%point_test%given .and. .not. allocated(error)) then
      call point_law(scene, law, error)
      if (.not. allocated(error)) summary = point_summary(scene)
    end if
    if (allocated(error)) then
      call report_error(report, error, exit_code)
    else if (.not. scene%point_test%given) then
      call model_summary(model, summary)
    end if
  end subroutine check_deck

  !> Tell what of a deck will be modelled, and what it will cost.
  subroutine plan_deck(path, json, text, report, exit_code)
    !> Path of the deck.
    character(len=*), intent(in) :: path
    !> Write JSON.
    logical, intent(in) :: json
    !> The plan, empty when the deck is not good.
    character(len=:), allocatable, intent(out) :: text
    !> Warnings and errors, one a line.
    character(len=:), allocatable, intent(out) :: report
    !> 0, or the code of the error.
    integer, intent(out) :: exit_code
    type(model_type) :: model
    type(analysis_type) :: scene
    type(expansion_type) :: expansion
    type(verdict_type), allocatable :: verdicts(:)
    type(whole_scene_type) :: whole
    type(plan_items_type) :: items
    type(error_type), allocatable :: error

    exit_code = 0
    text = ''
    call omp_set_num_threads(1)
    call set_blas_threads(1)
    call load_deck(path, scene, expansion, verdicts, model, report, error)
    if (.not. allocated(error)) call refuse_point(path, scene, error)
    if (.not. allocated(error)) call begin_whole(whole, scene, expansion, model, error)
    if (allocated(error)) then
      call report_error(report, error, exit_code)
      return
    end if
    call make_plan(scene, whole, verdicts, model, items)
    if (json) then
      text = plan_json(items)
    else
      text = plan_text(items)
    end if
  end subroutine plan_deck

  !> Run a deck.
  subroutine run_deck(request, report, exit_code)
    !> What is to be run.
    type(run_request_type), intent(in) :: request
    !> Warnings of the deck and errors, one a line.
    character(len=:), allocatable, intent(out) :: report
    !> 0 when the run finished; else the code of the error, or 128 plus the number of the signal.
    integer, intent(out) :: exit_code
    type(model_type) :: model
    type(analysis_type) :: scene
    type(expansion_type) :: expansion
    type(verdict_type), allocatable :: verdicts(:)
    type(recorder_options_type) :: options
    type(error_type), allocatable :: error
    type(run_profile_type) :: profile
    character(len=:), allocatable :: echo

    exit_code = 0
    call start_clock(options%clock)
    call start_stopwatch(profile%watch, part_input)
    call omp_set_num_threads(max(1, request%threads))
    call set_blas_threads(1)
    call load_deck(request%deck, scene, expansion, verdicts, model, report, error)
    if (.not. allocated(error)) call refuse_point(request%deck, scene, error)
    if (.not. allocated(error)) call begin_whole(options%whole, scene, expansion, model, error)
    if (.not. allocated(error)) then
      call echo_text(scene, echo)
      options%display = request%display
      options%banner = program_name()
      options%fingerprint = text_fingerprint(echo)
      options%continued = len(request%restart) > 0
      if (options%continued) then
        call read_restart(request%restart, model, options%fingerprint, error)
      end if
    end if
    if (allocated(error)) then
      call report_error(report, error, exit_code)
    else
      call record_run(request, options, model, echo, profile, report, exit_code)
    end if
  end subroutine run_deck

  !> Run a model with a recorder.
  subroutine record_run(request, options, model, echo, profile, report, exit_code)
    !> What is to be run.
    type(run_request_type), intent(in) :: request
    !> How it is recorded.
    type(recorder_options_type), intent(in) :: options
    !> The model.
    type(model_type), intent(inout) :: model
    !> The resolved deck.
    character(len=*), intent(in) :: echo
    !> Time and work of the run, its stopwatch started.
    type(run_profile_type), intent(inout) :: profile
    !> Warnings and errors, one a line.
    character(len=:), allocatable, intent(inout) :: report
    !> Unchanged when the run finished.
    integer, intent(inout) :: exit_code
    type(recorder_type) :: recorder
    type(error_type), allocatable :: error, outcome
    character(len=:), allocatable :: directory

    directory = request%directory
    if (len(directory) == 0) directory = 'output/'//model%analysis%job
    call turn_to(profile%watch, part_output)
    call create(recorder, model, directory, options, error)
    if (allocated(error)) then
      call report_error(report, error, exit_code)
      return
    end if
    if (len(report) > 0) call recorder%note(without_last_newline(report))
    report = ''
    call write_text(directory//'/'//model%analysis%job//'.echo.inp', echo, outcome)
    if (.not. allocated(outcome)) call run_phases(model, recorder, profile, outcome)
    call tell_times(request, directory, profile, recorder, error)
    if (allocated(error) .and. .not. allocated(outcome)) call move_alloc(error, outcome)
    call close(recorder, model, error, outcome)
    if (allocated(error)) call report_error(report, error, exit_code)
    if (allocated(outcome)) call report_error(report, outcome, exit_code)
  end subroutine record_run

  !> Where the time went: a line of the log and, on request, a table and a file.
  subroutine tell_times(request, directory, profile, recorder, error)
    !> What is to be run.
    type(run_request_type), intent(in) :: request
    !> Where the results go.
    character(len=*), intent(in) :: directory
    !> Time and work of the run.
    type(run_profile_type), intent(in) :: profile
    !> The recorder.
    type(recorder_type), intent(inout) :: recorder
    !> Set when the file cannot be written.
    type(error_type), allocatable, intent(out) :: error

    recorder%times = shares_line(profile, request%threads)
    if (.not. request%profile) return
    call recorder%note(profile_table(profile, request%threads))
    call write_text(directory//'/'//profile_file, profile_json(profile, request%threads), error)
  end subroutine tell_times

  !> Add an error to the report and take its exit code.
  subroutine report_error(report, error, exit_code)
    !> Warnings and errors, one a line.
    character(len=:), allocatable, intent(inout) :: report
    !> The error.
    type(error_type), intent(in) :: error
    !> Its code.
    integer, intent(out) :: exit_code

    report = report//without_last_newline(error%message)//newline
    exit_code = error%code
    if (exit_code == error_stopped) exit_code = signal_base + signal_number()
    if (exit_code == signal_base) exit_code = error_other
  end subroutine report_error
end module qsmpm_run
