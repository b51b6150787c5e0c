!> The program: words of the command line in, exit code out. Only here is anything printed or the
!> process ended.
program qsmpm_main
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use, intrinsic :: iso_c_binding, only: c_int
  use qsmpm_arguments, only: command_type, parse_arguments, usage_text, command_run, &
    command_check, command_point, command_plan, command_help, command_version, command_markdown, command_json
  use qsmpm_deck_help, only: deck_markdown, help_text, keyword_list_text, deck_json
  use qsmpm_display, only: display_plain, display_quiet, display_terminal
  use qsmpm_error, only: error_type, error_other
  use qsmpm_fields, only: fields_markdown
  use qsmpm_plugin, only: guard_watch, model_abandoned, leave_process
  use qsmpm_posix, only: exit_process, is_terminal, watch_signals
  use qsmpm_text, only: string_type, upper
  use qsmpm_file, only: base_name
  use qsmpm_point, only: point_request_type, run_point
  use qsmpm_program_name, only: program_name
  use qsmpm_run, only: run_request_type, run_deck, check_deck, plan_deck
  use qsmpm_team, only: start_team, end_team
  implicit none

  interface
    !> Start the program again with threads that sleep while they wait (process_waits.c).
    subroutine wait_asleep() bind(c, name='qsmpm_wait_asleep')
    end subroutine wait_asleep

    !> Meet the limits of the shell: kilobytes of a stack that is too small, 0 for enough (process_waits.c).
    integer(c_int) function meet_limits() bind(c, name='qsmpm_meet_limits')
      import :: c_int
    end function meet_limits
  end interface

  type(string_type), allocatable :: words(:)
  type(command_type) :: command
  type(error_type), allocatable :: error
  character(len=:), allocatable :: text
  integer :: code

  code = meet_limits()
  if (code > 0) then
    write (error_unit, '(a,i0,a)') 'qsmpm: the stack of the process may have ', code, &
      ' kB (ulimit -s), which is too little: ulimit -s 8192 is usual'
    call exit_process(error_other)
  end if
  call read_words(words)
  call parse_arguments(words, command, error)
  if (.not. allocated(error)) then
    if (command%command == command_run .and. command%threads > 1) call wait_asleep()
    call start_team(error)
  end if
  code = 0
  if (allocated(error)) then
    write (error_unit, '(a)') 'qsmpm: '//error%message, usage_text()
    code = error%code
  else
    select case (command%command)
    case (command_run)
      call run(command, code)
    case (command_check)
      call check(command, code)
    case (command_point)
      call point(command, code)
    case (command_plan)
      call plan(command, code)
    case (command_help)
      call help(command%subject, code)
    case (command_markdown)
      call deck_markdown(text)
      write (output_unit, '(a)', advance='no') text
    case (command_json)
      call deck_json(text)
      write (output_unit, '(a)', advance='no') text
    case (command_version)
      write (output_unit, '(a)') program_name()
    end select
  end if
  flush (error_unit)
  call end_team()
  if (model_abandoned()) call leave_process(code)
  flush (output_unit)
  call exit_process(code)

contains

  !> The words of the command line.
  subroutine read_words(words)
    !> One element a word.
    type(string_type), allocatable, intent(out) :: words(:)
    integer :: i, length

    allocate (words(command_argument_count()))
    do i = 1, size(words)
      call get_command_argument(i, length=length)
      allocate (character(len=length) :: words(i)%text)
      if (length > 0) call get_command_argument(i, words(i)%text)
    end do
  end subroutine read_words

  !> Run a deck.
  subroutine run(command, code)
    !> What is asked for.
    type(command_type), intent(in) :: command
    !> Exit code.
    integer, intent(out) :: code
    type(run_request_type) :: request
    character(len=:), allocatable :: report

    request%deck = command%subject
    request%directory = command%directory
    request%restart = command%restart
    request%threads = command%threads
    request%profile = command%profile
    request%display = display_plain
    if (is_terminal(1)) request%display = display_terminal
    if (command%quiet) request%display = display_quiet
    call watch_signals()
    call guard_watch()
    call run_deck(request, report, code)
    write (error_unit, '(a)', advance='no') report
  end subroutine run

  !> Check a deck.
  subroutine check(command, code)
    !> What is asked for.
    type(command_type), intent(in) :: command
    !> Exit code.
    integer, intent(out) :: code
    character(len=:), allocatable :: summary, report

    call check_deck(command%subject, command%plugins, summary, report, code)
    write (error_unit, '(a)', advance='no') report
    write (output_unit, '(a)', advance='no') summary
  end subroutine check

  !> Run tests of one point, one after the other whatever comes of each.
  subroutine point(command, code)
    !> What is asked for.
    type(command_type), intent(in) :: command
    !> The largest exit code.
    integer, intent(out) :: code
    type(point_request_type) :: request
    character(len=:), allocatable :: text, report
    integer :: i, own

    code = 0
    request%tangent = command%tangent
    request%banner = program_name()
    do i = 1, size(command%decks)
      request%deck = command%decks(i)%text
      request%directory = command%directory
      if (size(command%decks) > 1 .and. len(command%directory) > 0) &
        request%directory = command%directory//'/'//base_name(request%deck)
      call run_point(request, text, report, own)
      write (error_unit, '(a)', advance='no') report
      if (.not. command%quiet) write (output_unit, '(a)', advance='no') text
      code = max(code, own)
    end do
  end subroutine point

  !> Plan a deck.
  subroutine plan(command, code)
    !> What is asked for.
    type(command_type), intent(in) :: command
    !> Exit code.
    integer, intent(out) :: code
    character(len=:), allocatable :: text, report

    call plan_deck(command%subject, command%plugins, command%json, command%ranks, text, report, code)
    write (error_unit, '(a)', advance='no') report
    write (output_unit, '(a)', advance='no') text
  end subroutine plan

  !> Explain a keyword, list them, or list the fields of the material points.
  subroutine help(keyword, code)
    !> The keyword, empty for the list.
    character(len=*), intent(in) :: keyword
    !> Exit code.
    integer, intent(out) :: code
    character(len=:), allocatable :: text
    logical :: found

    code = 0
    if (len(keyword) == 0) then
      call keyword_list_text(text)
      write (output_unit, '(a)') usage_text(), text
      return
    end if
    if (upper(keyword) == 'FIELDS') then
      call fields_markdown(text)
      write (output_unit, '(a)', advance='no') text
      return
    end if
    call help_text(keyword, text, found)
    if (found) then
      write (output_unit, '(a)') text
    else
      write (error_unit, '(a)') 'qsmpm: '//text
      code = 1
    end if
  end subroutine help
end program qsmpm_main
