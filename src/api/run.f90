!> Runs a deck from the file to the results: read, create, record and run, by the procedures that an embedding program
!> calls. Only the recorder writes files, and nothing is written before deck, model and restart file are checked.
!>
!> The caller receives an exit code and the messages for the error output.
module qsmpm_run
  use omp_lib, only: omp_set_num_threads
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: agree
  use qsmpm_analysis, only: analysis_type
  use qsmpm_blas_threads, only: reserve_buffers, set_blas_threads
  use qsmpm_deck, only: read_deck
  use qsmpm_display, only: display_plain
  use qsmpm_error, only: error_type, error_other
  use qsmpm_file, only: write_text
  use qsmpm_law, only: law_type
  use qsmpm_messages, only: message_list_type, message_text
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model, model_summary
  use qsmpm_number_text, only: newline, without_last_newline
  use qsmpm_plan, only: make_plan, plan_ranks, plan_items_type, plan_text, plan_json
  use qsmpm_plugin, only: model_stopped
  use qsmpm_point, only: point_law, point_summary, refuse_point
  use qsmpm_phases, only: error_stopped
  use qsmpm_problem, only: problem_type
  use qsmpm_profile_report, only: profile_json, profile_table, shares_line
  use qsmpm_recorder, only: recorder_type, profile_file, signal_number
  use qsmpm_run_profile, only: run_profile_type
  use qsmpm_simulation, only: simulation_type
  use qsmpm_stopwatch, only: switch_timer, part_control
  use qsmpm_reduction, only: expansion_type, reduction_check_type
  use qsmpm_scene, only: reduce_scene
  use qsmpm_sharing_limits, only: refuse_sharing
  use qsmpm_team, only: team_type, team_world, largest
  use qsmpm_whole_scene, only: whole_scene_type, begin_whole
  implicit none
  private

  public :: run_request_type, run_deck, check_deck, plan_deck

  !> Request for a run.
  type :: run_request_type
    !> Path of the deck file.
    character(len=:), allocatable :: deck
    !> Directory of the results; empty: output/<job>.
    character(len=:), allocatable :: directory
    !> Restart file from which the run continues; empty for a run from the start.
    character(len=:), allocatable :: restart
    integer :: threads = 1
    !> Whether to print the distribution of the run time and write it to profile.json.
    logical :: profile = .false.
    !> One of the display_* values of qsmpm_display.
    integer :: display = display_plain
  end type run_request_type

  !> Added to the number of a signal to form the exit code.
  integer, parameter :: signal_base = 128

contains

  !> Reads a deck and builds its model, the smallest equivalent one unless the deck specifies it. A deck with a test of
  !> one point has no model.
  subroutine load_deck(path, plugins, scene, expansion, checks, model, warnings, error)
    !> Path of the deck file.
    character(len=*), intent(in) :: path
    !> Whether to load the libraries of user materials.
    logical, intent(in) :: plugins
    !> The scene as defined in the deck, with all defaults; the expansion from the model to the scene.
    class(analysis_type), allocatable, intent(out) :: scene
    type(expansion_type), intent(out) :: expansion
    !> Results of the checks of possible reductions.
    type(reduction_check_type), allocatable, intent(out) :: checks(:)
    class(model_type), allocatable, intent(out) :: model
    !> Messages of the reader, one per line; empty if there are none.
    character(len=:), allocatable, intent(out) :: warnings
    !> Set when the deck or the model has errors.
    type(error_type), allocatable, intent(out) :: error
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages

    allocate (analysis, scene, model)
    call read_deck(path, scene, messages, error)
    warnings = message_text(messages)
    if (allocated(error)) return
    if (.not. plugins) call leave_libraries(scene, warnings)
    if (scene%point_test%given) return
    call reduce_scene(scene, analysis, expansion, checks)
    call build_model(analysis, model, error)
    if (allocated(error)) return
    scene%method = model%analysis%method
    scene%materials = model%analysis%materials
  end subroutine load_deck

  !> Disables the loading of user libraries: a deck from another user would run its code on this machine.
  subroutine leave_libraries(scene, warnings)
    type(analysis_type), intent(inout) :: scene
    !> A message is appended for each library.
    character(len=:), allocatable, intent(inout) :: warnings
    integer :: m

    do m = 1, size(scene%materials)
      associate (material => scene%materials(m))
        if (.not. material%user%given) cycle
        material%user%loads = .false.
        warnings = warnings//"material '"//material%name//"': the library '"//material%user%library// &
          "' is not loaded, linear elasticity stands in for it (--plugins loads it)"//newline
      end associate
    end do
  end subroutine leave_libraries

  !> Reads a deck, generates mesh and material points and returns a summary.
  subroutine check_deck(path, plugins, summary, report, exit_code)
    !> Path of the deck file.
    character(len=*), intent(in) :: path
    !> Whether to load the libraries of user materials.
    logical, intent(in) :: plugins
    !> Summary; empty when the deck has errors.
    character(len=:), allocatable, intent(out) :: summary
    !> Warnings and errors, one per line.
    character(len=:), allocatable, intent(out) :: report
    !> 0, or the code of the error.
    integer, intent(out) :: exit_code
    class(model_type), allocatable :: model
    class(analysis_type), allocatable :: scene
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)
    type(error_type), allocatable :: error
    class(law_type), allocatable :: law

    exit_code = 0
    summary = ''
    call load_deck(path, plugins, scene, expansion, checks, model, report, error)
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

  !> Returns the plan of a deck: what is modelled and what the run will cost.
  subroutine plan_deck(path, plugins, json, ranks, text, report, exit_code)
    !> Path of the deck file.
    character(len=*), intent(in) :: path
    !> Whether to load the libraries of user materials; whether to write JSON.
    logical, intent(in) :: plugins, json
    !> Number of processes of the planned run.
    integer, intent(in) :: ranks
    !> The plan; empty when the deck has errors.
    character(len=:), allocatable, intent(out) :: text
    !> Warnings and errors, one per line.
    character(len=:), allocatable, intent(out) :: report
    !> 0, or the code of the error.
    integer, intent(out) :: exit_code
    class(model_type), allocatable :: model
    class(analysis_type), allocatable :: scene
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)
    class(whole_scene_type), allocatable :: whole
    type(plan_items_type) :: items
    type(error_type), allocatable :: error

    exit_code = 0
    text = ''
    ! gfortran does not recognise that bounds of unallocated arrays are not used.
    allocate (checks(0), whole)
    call omp_set_num_threads(1)
    call set_blas_threads(1)
    call load_deck(path, plugins, scene, expansion, checks, model, report, error)
    if (.not. allocated(error)) call reserve_buffers(1, error)
    if (.not. allocated(error)) call refuse_point(scene, error)
    if (.not. allocated(error)) call begin_whole(whole, scene, expansion, model, error)
    if (allocated(error)) then
      call report_error(report, error, exit_code)
      return
    end if
    call make_plan(scene, whole, checks, model, items)
    if (ranks > 1) call plan_ranks(model, ranks, items)
    if (json) then
      text = plan_json(items)
    else
      text = plan_text(items)
    end if
  end subroutine plan_deck

  !> Runs a deck.
  subroutine run_deck(request, report, exit_code)
    type(run_request_type), intent(in) :: request
    !> Warnings of the deck and errors, one per line.
    character(len=:), allocatable, intent(out) :: report
    !> 0 when the run finished; otherwise the code of the error, or 128 plus the number of the signal.
    integer, intent(out) :: exit_code
    class(problem_type), allocatable :: problem
    class(simulation_type), allocatable :: simulation
    type(error_type), allocatable :: error
    character(len=:), allocatable :: directory
    type(team_type) :: team

    exit_code = 0
    allocate (problem, simulation)
    team = team_world()
    call problem%read(request%deck, error)
    report = problem%messages
    simulation%threads = request%threads
    if (.not. allocated(error)) call simulation%create(problem, error, team)
    if (.not. allocated(error)) call refuse_sharing(simulation%model, team%ranks, error)
    simulation%loop%team = team
    call agree(team, error)
    if (.not. allocated(error) .and. len(request%restart) > 0) call simulation%load(request%restart, error)
    if (.not. allocated(error)) then
      directory = request%directory
      if (len(directory) == 0) directory = 'output/'//simulation%model%analysis%job
      call simulation%record(directory, error, request%display, len(request%restart) > 0)
      if (allocated(simulation%recorder)) report = ''
    end if
    call agree(team, error)
    if (allocated(simulation%recorder)) then
      call run_recorded(request, simulation, error, report, exit_code)
    else if (allocated(error)) then
      call report_error(report, error, exit_code)
    end if
    exit_code = nint(largest(team, real(exit_code, wp)))
    if (team%rank > 0) report = ''
    call simulation%destroy()
  end subroutine run_deck

  !> Runs an analysis, writes its results and reports the distribution of the run time.
  subroutine run_recorded(request, simulation, error, report, exit_code)
    type(run_request_type), intent(in) :: request
    type(simulation_type), intent(inout) :: simulation
    !> An error that has occurred already.
    type(error_type), allocatable, intent(inout) :: error
    !> Warnings and errors, one per line.
    character(len=:), allocatable, intent(inout) :: report
    !> Unchanged when the run finished.
    integer, intent(inout) :: exit_code
    type(error_type), allocatable :: outcome

    if (allocated(error)) then
      call move_alloc(error, simulation%outcome)
    else
      call simulation%run(error)
    end if
    call switch_timer(simulation%loop%step%profile%watch, part_control)
    call report_times(request, simulation%loop%step%profile, simulation%recorder, error)
    if (allocated(error) .and. .not. allocated(simulation%outcome)) call move_alloc(error, simulation%outcome)
    if (allocated(simulation%outcome)) allocate (outcome, source=simulation%outcome)
    call simulation%finish_record(error)
    if (allocated(error)) call report_error(report, error, exit_code)
    if (allocated(outcome)) call report_error(report, outcome, exit_code)
  end subroutine run_recorded

  !> Reports the distribution of the run time: a line of the log and, on request, a table and a file.
  subroutine report_times(request, profile, recorder, error)
    type(run_request_type), intent(in) :: request
    type(run_profile_type), intent(in) :: profile
    type(recorder_type), intent(inout) :: recorder
    !> Set when the file cannot be written.
    type(error_type), allocatable, intent(out) :: error

    recorder%times = shares_line(profile, request%threads)
    if (.not. request%profile) return
    call recorder%tell_result(profile_table(profile, request%threads))
    if (recorder%options%team%rank == 0) &
      call write_text(recorder%directory//'/'//profile_file, profile_json(profile, request%threads), error)
  end subroutine report_times

  !> Appends an error to the report and sets the exit code.
  subroutine report_error(report, error, exit_code)
    !> Warnings and errors, one per line.
    character(len=:), allocatable, intent(inout) :: report
    type(error_type), intent(in) :: error
    integer, intent(out) :: exit_code

    report = report//without_last_newline(error%message)//newline
    exit_code = error%code
    if (exit_code == error_stopped .or. model_stopped()) exit_code = signal_base + signal_number()
    if (exit_code == signal_base) exit_code = error_other
  end subroutine report_error
end module qsmpm_run
