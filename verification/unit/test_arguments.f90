!> Tests of the command line: words in, request out, or an error that helps.
module test_arguments
  use testing, only: tests_type
  use qsmpm_arguments, only: command_type, parse_arguments, usage_text, command_run, &
    command_check, command_plan, command_help, command_version, command_markdown, command_json
  use qsmpm_error, only: error_type
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: collect_arguments

contains

  !> All checks.
  subroutine collect_arguments(tests)
    type(tests_type), intent(inout) :: tests
    type(command_type) :: command
    type(error_type), allocatable :: error

    call tests%start('arguments')
    call parse('run a.inp --out d --threads 3 --restart r.h5 --quiet --profile', command, error)
    call tests%check('a run with all options is understood', .not. allocated(error))
    call tests%check('the deck is the word without a dash', command%subject == 'a.inp')
    call tests%check('options keep their values', command%command == command_run .and. &
      command%directory == 'd' .and. command%restart == 'r.h5' .and. command%threads == 3 .and. &
      command%quiet .and. command%profile)
    call parse('run --threads 2 b.inp', command, error)
    call tests%check('options may stand before the deck', command%subject == 'b.inp' .and. &
      command%threads == 2 .and. .not. allocated(error))
    call parse('check a.inp', command, error)
    call tests%check('check takes a deck', command%command == command_check .and. &
      command%subject == 'a.inp')
    call parse('plan a.inp --json', command, error)
    call tests%check('plan takes a deck and an option', command%command == command_plan .and. &
      command%subject == 'a.inp' .and. command%json .and. .not. allocated(error))
    call parse('plan --ranks 8 a.inp', command, error)
    call tests%check('and for how many processes', command%ranks == 8 .and. command%subject == 'a.inp')
    call parse('plan a.inp', command, error)
    call tests%check('for one unless it says so', command%ranks == 1)
    call tests%check('a plan is text unless JSON is asked for', .not. command%json)
    call tests%check('and loads no library', .not. command%plugins)
    call parse('plan --plugins a.inp', command, error)
    call tests%check('unless it is told to', command%plugins .and. command%subject == 'a.inp' .and. .not. allocated(error))
    call parse('check a.inp --plugins', command, error)
    call tests%check('so is check', command%plugins .and. command%subject == 'a.inp' .and. .not. allocated(error))
    call parse('help MOHR COULOMB', command, error)
    call tests%check('a keyword may have a blank', command%command == command_help .and. &
      command%subject == 'MOHR COULOMB')
    call parse('run --help', command, error)
    call tests%check('a command explains itself', command%command == command_help .and. .not. allocated(error))
    call parse('help --markdown', command, error)
    call tests%check('the deck reference can be had', command%command == command_markdown)
    call parse('help --json', command, error)
    call tests%check('so can the table for programs', command%command == command_json)
    call parse('--version', command, error)
    call tests%check('the version can be had', command%command == command_version)
    call test_errors(tests)
  end subroutine collect_arguments

  !> Wrong calls.
  subroutine test_errors(tests)
    type(tests_type), intent(inout) :: tests

    call expect(tests, '', 'no command is given')
    call expect(tests, 'rum a.inp', "unknown command 'rum' (did you mean run?)")
    call expect(tests, 'zzzzzz', "unknown command 'zzzzzz'")
    call expect(tests, 'run', 'run: a deck is required')
    call expect(tests, 'run a b', "run: unexpected 'b': the deck is 'a'")
    call expect(tests, 'run a --thread 2', &
      "run: unknown option '--thread' (did you mean --threads?)")
    call expect(tests, 'run a --threads two', "run: --threads requires a number from 1, not 'two'")
    call expect(tests, 'run a --threads 0', "run: --threads requires a number from 1, not '0'")
    call expect(tests, 'run a --threads 99999999999', &
      "run: --threads requires a number from 1, not '99999999999'")
    call expect(tests, 'run a --out', 'run: --out requires a value')
    call expect(tests, 'point', 'point: a deck is required')
    call expect(tests, 'point a --tangen', "point: unknown option '--tangen' (did you mean --tangent?)")
    call expect(tests, 'point a --threads 2', "point: unknown option '--threads'")
    call expect(tests, 'run a --tangent', "run: unknown option '--tangent'")
    call expect(tests, 'point a --out', 'point: --out requires a value')
    call expect(tests, 'point a/x.inp y b/x.inp', "point: two decks are called 'x'")
    call expect(tests, 'check', 'check: a deck is required')
    call expect(tests, 'check a b', "check: unexpected 'b'")
    call expect(tests, 'check --quiet', "check: unknown option '--quiet'")
    call expect(tests, 'plan --json', 'plan: a deck is required')
    call expect(tests, 'plan a --ranks 0', "plan: --ranks requires a number from 1, not '0'")
    call expect(tests, 'plan a --ranks', 'plan: --ranks requires a value')
    call expect(tests, 'check a --ranks 2', "check: unexpected '--ranks'")
    call expect(tests, 'plan a --xml', "plan: unexpected '--xml'")
    call expect(tests, 'help --mark', "help: unknown option '--mark'")
  end subroutine test_errors

  !> Check that a call is refused with a message.
  subroutine expect(tests, line, message)
    type(tests_type), intent(inout) :: tests
    !> Words with blanks between them.
    character(len=*), intent(in) :: line
    !> The message.
    character(len=*), intent(in) :: message
    type(command_type) :: command
    type(error_type), allocatable :: error

    call parse(line, command, error)
    if (allocated(error)) then
      call tests%check("'"//line//"' says: "//message, error%message == message)
    else
      call tests%check("'"//line//"' is refused", .false.)
    end if
  end subroutine expect

  !> Parse a line.
  subroutine parse(line, command, error)
    !> Words with blanks between them.
    character(len=*), intent(in) :: line
    !> What they ask for.
    type(command_type), intent(out) :: command
    !> Set when they are not understood.
    type(error_type), allocatable, intent(out) :: error
    type(string_type), allocatable :: words(:)
    integer :: first, last, count

    allocate (words(len(line)))
    count = 0
    first = 1
    do while (first <= len(line))
      last = first + index(line(first:)//' ', ' ') - 2
      count = count + 1
      words(count)%text = line(first:last)
      first = last + 2
    end do
    call parse_arguments(words(:count), command, error)
  end subroutine parse
end module test_arguments
