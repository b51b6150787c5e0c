!> Parses the command line. Nothing is guessed: an unknown word is an error whose message names the nearest known word.
module qsmpm_arguments
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_file, only: base_name
  use qsmpm_text, only: string_type, add_word, did_you_mean, newline
  implicit none
  private

  public :: command_type, parse_arguments, usage_text

  !> Commands.
  integer, parameter, public :: command_run = 1, command_check = 2, command_help = 3, &
    command_version = 4, command_markdown = 5, command_plan = 6, command_point = 7, command_json = 8

  !> A parsed command line.
  type :: command_type
    integer :: command = command_help
    !> Path of the deck, or keyword of `help` (empty: list of all keywords).
    character(len=:), allocatable :: subject
    !> All decks of the command `point`.
    type(string_type), allocatable :: decks(:)
    !> Directory of the results and restart file; empty when not given.
    character(len=:), allocatable :: directory, restart
    integer :: threads = 1
    !> Number of processes assumed by `plan`.
    integer :: ranks = 1
    logical :: quiet = .false.
    !> Whether `plan` writes JSON.
    logical :: json = .false.
    logical :: profile = .false.
    !> Whether `check` and `plan` load the libraries of user materials.
    logical :: plugins = .false.
    !> Whether tangents are compared with finite differences.
    logical :: tangent = .false.
  end type command_type

  integer, parameter :: word_length = 10
  character(len=word_length), parameter :: commands(5) = [character(len=word_length) :: &
    'run', 'point', 'check', 'plan', 'help']
  character(len=word_length), parameter :: run_options(5) = [character(len=word_length) :: &
    '--out', '--threads', '--restart', '--quiet', '--profile']
  character(len=word_length), parameter :: point_options(3) = [character(len=word_length) :: &
    '--out', '--tangent', '--quiet']

contains

  !> Returns the usage text of the program.
  pure function usage_text() result(text)
    character(len=:), allocatable :: text

    text = 'qsmpm run DECK [--out DIR] [--threads N] [--restart FILE] [--quiet] [--profile]'//newline// &
      '    runs a deck; results go to DIR (default output/<job>); --quiet shows what was found,'//newline// &
      '    warnings and errors alone; --profile tells where the time went and writes profile.json'//newline// &
      'qsmpm point DECK [DECK ...] [--out DIR] [--tangent] [--quiet]'//newline// &
      '    runs laboratory tests on one material point (*POINT TEST); --tangent compares the'//newline// &
      '    tangent of the material law with differences in every step; the results of several'//newline// &
      '    decks go to DIR/<job>'//newline// &
      'qsmpm check DECK [--plugins]'//newline// &
      '    reads, meshes and seeds a deck and prints its totals; nothing is written'//newline// &
      'qsmpm plan DECK [--json] [--plugins] [--ranks N]'//newline// &
      '    tells what will be modelled, why not less, and what it will cost; nothing is written;'//newline// &
      '    --ranks tells points, equations and memory of N processes (docs/distributed.md)'//newline// &
      '    check and plan load the libraries of *USER MATERIAL, which runs their code, with'//newline// &
      '    --plugins only'//newline// &
      'qsmpm help [KEYWORD | --json]'//newline// &
      '    explains a keyword of the deck, or lists them; FIELDS lists what is shown of material points,'//newline// &
      '    RENAMED the words of decks and results that had another name'//newline// &
      'qsmpm --version'//newline// &
      'Exit codes: 0 done, 1 wrong call or other failure, 2 deck, 3 not converged,'//newline// &
      '    4 a point left the mesh, 5 singular equations, 6 user material,'//newline// &
      '    130 or 143 stopped by a signal (restart.h5 continues the run)'//newline
  end function usage_text

  !> Parses the command line.
  pure subroutine parse_arguments(words, command, error)
    !> The words after the program's name.
    type(string_type), intent(in) :: words(:)
    type(command_type), intent(out) :: command
    !> Set when the arguments are invalid.
    type(error_type), allocatable, intent(out) :: error

    command%subject = ''
    command%directory = ''
    command%restart = ''
    if (size(words) == 0) then
      call fail(error, error_other, 'no command is given')
      return
    end if
    if (size(words) == 2) then
      if (any(words(2)%text == ['--help', '-h    ']) .and. &
        any(words(1)%text == ['run  ', 'point', 'check', 'plan '])) then
        call parse_help(words(3:), command, error)
        return
      end if
    end if
    select case (words(1)%text)
    case ('run')
      command%command = command_run
      call parse_run(words(2:), 'run', run_options, command, error)
    case ('point')
      command%command = command_point
      call parse_run(words(2:), 'point', point_options, command, error)
      if (.not. allocated(error)) call check_jobs(command%decks, error)
    case ('check')
      command%command = command_check
      call parse_look(words(2:), 'check', command, error)
    case ('plan')
      command%command = command_plan
      call parse_look(words(2:), 'plan', command, error)
    case ('help', '--help', '-h')
      call parse_help(words(2:), command, error)
    case ('--version')
      command%command = command_version
      if (size(words) > 1) call fail(error, error_other, '--version stands alone')
    case default
      call fail(error, error_other, "unknown command '"//words(1)%text//"'"//suggestion(words(1)%text, commands))
    end select
  end subroutine parse_arguments

  !> Parses the arguments of `check` and `plan`: the deck and the options --plugins and, for `plan`, --json and
  !> --ranks.
  pure subroutine parse_look(words, name, command, error)
    type(string_type), intent(in) :: words(:)
    !> Name of the command.
    character(len=*), intent(in) :: name
    type(command_type), intent(inout) :: command
    !> Set when the arguments are invalid.
    type(error_type), allocatable, intent(out) :: error
    type(string_type) :: others(size(words))
    integer :: i, n

    n = 0
    i = 0
    do while (i < size(words))
      i = i + 1
      if (words(i)%text == '--json' .and. name == 'plan') then
        command%json = .true.
      else if (words(i)%text == '--ranks' .and. name == 'plan') then
        call parse_option(words(i:), name, command, error)
        if (allocated(error)) return
        i = i + 1
      else if (words(i)%text == '--plugins') then
        command%plugins = .true.
      else
        n = n + 1
        others(n) = words(i)
      end if
    end do
    if (n == 0) then
      call fail(error, error_other, name//': a deck is required')
    else if (n > 1) then
      call fail(error, error_other, name//": unexpected '"//others(2)%text//"'")
    else if (index(others(1)%text, '-') == 1) then
      call fail(error, error_other, name//": unknown option '"//others(1)%text//"'")
    else
      command%subject = others(1)%text
    end if
  end subroutine parse_look

  !> Parses the arguments of `help`.
  pure subroutine parse_help(words, command, error)
    type(string_type), intent(in) :: words(:)
    type(command_type), intent(inout) :: command
    !> Set when the arguments are invalid.
    type(error_type), allocatable, intent(out) :: error
    integer :: i

    command%command = command_help
    if (size(words) == 0) return
    if (any(words(1)%text == ['--markdown', '--json    ']) .and. size(words) == 1) then
      command%command = merge(command_markdown, command_json, words(1)%text == '--markdown')
      return
    end if
    ! A keyword may contain blanks: help MOHR COULOMB.
    do i = 1, size(words)
      if (index(words(i)%text, '-') == 1) then
        call fail(error, error_other, "help: unknown option '"//words(i)%text//"'")
        return
      end if
      command%subject = trim(adjustl(command%subject//' '//words(i)%text))
    end do
  end subroutine parse_help

  !> Parses the arguments of `run` and `point`: the deck and options in any order.
  pure subroutine parse_run(words, name, options, command, error)
    type(string_type), intent(in) :: words(:)
    !> Name of the command; options it accepts.
    character(len=*), intent(in) :: name, options(:)
    type(command_type), intent(inout) :: command
    !> Set when the arguments are invalid.
    type(error_type), allocatable, intent(out) :: error
    integer :: i

    allocate (command%decks(0))
    i = 1
    do while (i <= size(words))
      if (index(words(i)%text, '-') == 1 .and. .not. any(options == words(i)%text)) then
        call fail(error, error_other, name//": unknown option '"//words(i)%text//"'"// &
          suggestion(words(i)%text, options))
      else if (words(i)%text == '--quiet') then
        command%quiet = .true.
      else if (words(i)%text == '--tangent') then
        command%tangent = .true.
      else if (words(i)%text == '--profile') then
        command%profile = .true.
      else if (index(words(i)%text, '-') == 1) then
        call parse_option(words(i:min(i + 1, size(words))), name, command, error)
        i = i + 1
      else if (len(command%subject) > 0 .and. name == 'run') then
        call fail(error, error_other, name//": unexpected '"//words(i)%text//"': the deck is '"//command%subject//"'")
      else
        command%subject = words(i)%text
        call add_word(command%decks, words(i)%text)
      end if
      if (allocated(error)) return
      i = i + 1
    end do
    if (len(command%subject) == 0) call fail(error, error_other, name//': a deck is required')
  end subroutine parse_run

  !> Checks that the results of several decks have different names.
  pure subroutine check_jobs(decks, error)
    type(string_type), intent(in) :: decks(:)
    !> Set when two decks have the same job name.
    type(error_type), allocatable, intent(out) :: error
    integer :: i, k

    do i = 2, size(decks)
      if (any([(base_name(decks(i)%text) == base_name(decks(k)%text), k=1, i - 1)]) .and. .not. allocated(error)) &
        call fail(error, error_other, "point: two decks are called '"//base_name(decks(i)%text)//"'")
    end do
  end subroutine check_jobs

  !> Parses an option of `run` or `point` and its value.
  pure subroutine parse_option(words, name, command, error)
    !> The option and the following word, if there is one.
    type(string_type), intent(in) :: words(:)
    !> Name of the command.
    character(len=*), intent(in) :: name
    type(command_type), intent(inout) :: command
    !> Set when the arguments are invalid.
    type(error_type), allocatable, intent(out) :: error

    if (size(words) < 2) then
      call fail(error, error_other, name//': '//words(1)%text//' requires a value')
      return
    end if
    associate (value => words(2)%text)
      select case (words(1)%text)
      case ('--out')
        command%directory = value
      case ('--restart')
        command%restart = value
      case ('--threads')
        call parse_count(words(:2), name, command%threads, error)
      case ('--ranks')
        call parse_count(words(:2), name, command%ranks, error)
      end select
      if (len(value) == 0) call fail(error, error_other, name//': '//words(1)%text//' is empty')
    end associate
  end subroutine parse_option

  !> Parses an option whose value is a number.
  pure subroutine parse_count(words, name, count, error)
    type(string_type), intent(in) :: words(2)
    !> Name of the command.
    character(len=*), intent(in) :: name
    integer, intent(inout) :: count
    !> Set when the value is not an integer of at least 1.
    type(error_type), allocatable, intent(out) :: error
    integer :: status

    status = 1
    associate (value => words(2)%text)
      if (len(value) > 0 .and. verify(value, '0123456789') == 0) read (value, *, iostat=status) count
      if (status /= 0 .or. count < 1) call fail(error, error_other, name//': '//words(1)%text// &
        " requires a number from 1, not '"//value//"'")
    end associate
  end subroutine parse_count

  !> Returns the nearest known word as a question, empty when none is near.
  pure function suggestion(word, known) result(text)
    !> The unknown word; the known words.
    character(len=*), intent(in) :: word, known(:)
    character(len=:), allocatable :: text
    type(string_type) :: words(size(known))
    integer :: i

    do i = 1, size(known)
      words(i)%text = trim(known(i))
    end do
    text = did_you_mean(word, words)
  end function suggestion
end module qsmpm_arguments
