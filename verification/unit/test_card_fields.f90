!> A card made here, one line a parameter: what that line alone brings to help, reading, the check of ranges and words,
!> and the echo.
module test_card_fields
  use qsmpm_kinds, only: wp
  use qsmpm_card_check, only: check_card
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_card_visitors, only: card_reader_type, writer_type, reader, writer, lines_type
  use qsmpm_cards, only: card_type, make_cards, line_list_type, cut_lines
  use qsmpm_deck_help, only: explanation
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_keyword_table, only: table_type, in_model, once
  use qsmpm_messages, only: message_text
  use qsmpm_text, only: same_bits
  use testing, only: tests_type
  implicit none
  private

  public :: collect_card_fields

  character(len=1), parameter :: nl = new_line('a')

  !> What the card fills.
  type :: sample_type
    integer :: count = 3
    real(wp) :: weight = 0.1_wp
    !> Not set.
    real(wp) :: width = -1.0_wp
    integer :: shape = 1
    logical :: deep = .false.
    character(len=:), allocatable :: set
    real(wp) :: modulus = 0.0_wp
    real(wp) :: strength = huge(1.0_wp)
  end type sample_type

contains

  !> The suite.
  subroutine collect_card_fields(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('card_fields')
    call described(tests)
    call read_and_written(tests)
    call refused(tests)
    call by_name(tests)
  end subroutine collect_card_fields

  !> The card: all that is said of it.
  subroutine sample_fields(fields, sample)
    class(card_fields_type), intent(inout) :: fields
    type(sample_type), intent(inout) :: sample

    call fields%whole('COUNT', sample%count, 'how many', range='[1, 9]')
    call fields%number('WEIGHT', sample%weight, 'how heavy', range='[0, inf)')
    call fields%choice('SHAPE', sample%shape, 'FLAT|ROUND|ODD', 'of what shape', first=0)
    call fields%number('WIDTH', sample%width, 'how wide; twice the height when not given', range='(0, inf)', &
      needs='SHAPE=ROUND|ODD')
    call fields%answer('DEEP', sample%deep, 'whether below')
    call fields%name('NSET', sample%set, 'where', required=.true.)
    call fields%data('stiffness')
    call fields%number('E', sample%modulus, 'modulus', range='(0, inf)')
    call fields%number('strength', sample%strength, 'largest stress', range='[0, inf)', required=.false., none='NONE', &
      also='sigma_t')
  end subroutine sample_fields

  !> The table of keywords with the card in it.
  subroutine make_sample_table(table)
    type(table_type), intent(out) :: table

    call table%add('SAMPLE', in_model, once, 'A card.', described_fields, '*SAMPLE, NSET=top| 7')
  end subroutine make_sample_table

  !> The table is reported the card; the test reads it itself.
  subroutine described_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    type(sample_type) :: sample

    if (.not. fields%reading) deck%dimension = 2
    call sample_fields(fields, sample)
  end subroutine described_fields

  !> Check and read a card.
  subroutine read_sample(text, sample, messages)
    character(len=*), intent(in) :: text
    type(sample_type), intent(out) :: sample
    !> Empty when nothing was wrong.
    character(len=:), allocatable, intent(out) :: messages
    type(table_type) :: table
    type(line_list_type) :: lines
    type(card_type), allocatable, target :: cards(:)
    type(deck_state_type) :: state
    type(card_reader_type) :: fields

    call make_sample_table(table)
    call cut_lines('a.inp', text, lines, state%messages)
    call make_cards(lines, cards, state%messages)
    state%card => cards(1)
    call check_card(table%keywords(1), state)
    fields = reader(cards(1), 3)
    call sample_fields(fields, sample)
    messages = message_text(state%messages)
  end subroutine read_sample

  !> The card as the echo writes it.
  function written(from) result(text)
    type(sample_type), intent(in) :: from
    character(len=:), allocatable :: text
    type(sample_type) :: sample
    type(writer_type) :: fields
    type(lines_type) :: echo

    sample = from
    fields = writer('SAMPLE', 2)
    call sample_fields(fields, sample)
    call fields%finish(echo)
    text = echo%text(:echo%length)
  end function written

  !> Help and reference.
  subroutine described(tests)
    type(tests_type), intent(inout) :: tests
    type(table_type) :: table
    character(len=:), allocatable :: text

    call make_sample_table(table)
    text = explanation(table%keywords(1), '- ', '`')
    call has('a whole number', '- `COUNT=whole number`: how many; in `[1, 9]`; default `3`'//nl)
    call has('a number', '- `WEIGHT=number`: how heavy; in `[0, inf)`; default `0.1`'//nl)
    call has('a choice and the word of its default', '- `SHAPE=FLAT|ROUND|ODD`: of what shape; default `ROUND`'//nl)
    call has('a number that is not set has no default', '- `WIDTH=number`: how wide; twice the height when not given; '// &
      'in `(0, inf)`; only with `SHAPE=ROUND|ODD`'//nl)
    call has('yes or no', '- `DEEP=NO|YES`: whether below; default `NO`'//nl)
    call has('a name', '- `NSET=name`: where; required'//nl)
    call has('a column', '- `E` (number): modulus; in `(0, inf)`'//nl)
    call has('a column that may be left out', '- `strength` (number|NONE): largest stress; in `[0, inf)`; may be left out')

  contains

    !> The help has a line.
    subroutine has(name, line)
      character(len=*), intent(in) :: name, line

      call tests%check('help: '//name, index(text, line) > 0)
    end subroutine has
  end subroutine described

  !> Values come from the card, those that are not given stay; the echo reads back.
  subroutine read_and_written(tests)
    type(tests_type), intent(inout) :: tests
    type(sample_type) :: sample, again
    character(len=:), allocatable :: messages

    call read_sample('*SAMPLE, NSET=top'//nl//' 7', sample, messages)
    call tests%check('a small card is right; found: '//messages, len(messages) == 0)
    call tests%check('what it does not say has its default', sample%count == 3 .and. sample%shape == 1 &
      .and. .not. sample%deep .and. all(same_bits([sample%weight, sample%width], [0.1_wp, -1.0_wp])))
    call tests%check('what it says is read', sample%set == 'top' .and. same_bits(sample%modulus, 7.0_wp) .and. &
      same_bits(sample%strength, huge(1.0_wp)))
    call tests%check('the echo tells every default and leaves out what is not set; found: '//written(sample), &
      written(sample) == '*SAMPLE, COUNT=3, WEIGHT=0.1, SHAPE=ROUND, DEEP=NO, NSET=top'//nl//' 7, NONE'//nl)
    call read_sample('*SAMPLE, NSET="a, b", COUNT=9, weight=1d-3, shape=odd, Width=0.3, deep=yes'//nl//' 8, 2.5', sample, &
      messages)
    call tests%check('a large card is right; found: '//messages, len(messages) == 0)
    call tests%check('all of it is read', sample%count == 9 .and. sample%shape == 2 .and. sample%deep .and. &
      sample%set == 'a, b' .and. all(same_bits([sample%weight, sample%width, sample%modulus, sample%strength], &
      [1.0e-3_wp, 0.3_wp, 8.0_wp, 2.5_wp])))
    call read_sample(written(sample), again, messages)
    call tests%check('its echo reads back', len(messages) == 0 .and. written(again) == written(sample) .and. &
      index(written(sample), 'WIDTH=0.3') > 0)
    sample%shape = 0
    call tests%check('what has no meaning beside the rest is not written', index(written(sample), 'WIDTH') == 0 .and. &
      index(written(sample), 'SHAPE=FLAT') > 0)
    sample%set = repeat('n', 90)
    call read_sample(written(sample), again, messages)
    call tests%check('a long card goes on over lines', index(written(sample), ','//nl) > 0 .and. len(messages) == 0 .and. &
      again%set == sample%set)
  end subroutine read_and_written

  !> What is out of range, of other words, without meaning or missing is refused and leaves the default.
  subroutine refused(tests)
    type(tests_type), intent(inout) :: tests
    type(sample_type) :: sample
    character(len=:), allocatable :: messages

    call read_sample('*SAMPLE, NSET=top, COUNT=10, SHAPE=FLAT, WIDTH=1, DEEP=MAYBE'//nl//' -1', sample, messages)
    call tests%check('range of a parameter; found: '//messages, &
      index(messages, 'a.inp:1: *SAMPLE: COUNT = 10 is outside [1, 9]') > 0 .and. sample%count == 3)
    call tests%check('words', index(messages, "DEEP 'MAYBE' is not one of NO, YES") > 0 .and. .not. sample%deep)
    call tests%check('meaning', index(messages, 'parameter WIDTH has no meaning without SHAPE=ROUND|ODD') > 0)
    call tests%check('range of a column', index(messages, 'a.inp:2: *SAMPLE: E = -1 is outside (0, inf)') > 0 .and. &
      same_bits(sample%modulus, 0.0_wp))
    call read_sample('*SAMPLE', sample, messages)
    call tests%check('what is required', index(messages, 'parameter NSET is missing') > 0 .and. &
      index(messages, '1 data line(s) required') > 0)
  end subroutine refused

  !> A data line by name, in any order and on several lines, by names of other programs; what is wrong with one.
  subroutine by_name(tests)
    type(tests_type), intent(inout) :: tests
    type(sample_type) :: sample
    character(len=:), allocatable :: messages

    call read_sample('*SAMPLE, NSET=top'//nl//' strength = 5'//nl//" E^'_r.m=7", sample, messages)
    call tests%check('two lines by name are right; found: '//messages, len(messages) == 0)
    call tests%check('and are read', all(same_bits([sample%modulus, sample%strength], [7.0_wp, 5.0_wp])))
    call read_sample('*SAMPLE, NSET=top'//nl//' 7, sigma t=none', sample, messages)
    call tests%check('a number before a name, another name; found: '//messages, len(messages) == 0 .and. &
      all(same_bits([sample%modulus, sample%strength], [7.0_wp, huge(1.0_wp)])))
    call read_sample('*SAMPLE, NSET=top'//nl//' e=7', sample, messages)
    call tests%check('what is not named stays', len(messages) == 0 .and. same_bits(sample%strength, huge(1.0_wp)))
    call read_sample('*SAMPLE, NSET=top'//nl//' E=7'//nl//' strenght=5', sample, messages)
    call tests%check('an unknown name; found: '//messages, messages == "a.inp:3: *SAMPLE: unknown name 'strenght' "// &
      '(did you mean strength?); there are E, strength'//nl)
    call wrong('a parameter', ' E=7'//nl//' count=5', 'a.inp:3: *SAMPLE: count is a parameter and belongs in the '// &
      'keyword line: *SAMPLE, COUNT=')
    call wrong('given twice', ' 7, strength=5'//nl//' e=8', 'a.inp:3: *SAMPLE: E is given twice')
    call wrong('missing', ' strength=5', 'a.inp:2: *SAMPLE: E is missing')
    call wrong('empty', ' E=7, strength=', 'a.inp:2: *SAMPLE: strength is empty')
    call wrong('out of range', ' strength=5'//nl//' E=-7', 'a.inp:3: *SAMPLE: E = -7 is outside (0, inf)')
    call wrong('without a name', ' E=7, 5', "a.inp:2: *SAMPLE: '5' has no name, unlike the others of the line: strength=5?")
    call wrong('on a line of its own', ' E=7'//nl//' 5', "a.inp:3: *SAMPLE: '5' has no name")
    call wrong('too many', ' 7, 5, 3, E=1', "a.inp:2: *SAMPLE: '3' is more than the columns: E, strength")

  contains

    !> A card has an error, and the column stays.
    subroutine wrong(name, rows, message)
      character(len=*), intent(in) :: name, rows, message

      call read_sample('*SAMPLE, NSET=top'//nl//rows, sample, messages)
      call tests%check('by name: '//name//'; found: '//messages, index(messages, message) > 0 .and. &
        same_bits(sample%modulus, 0.0_wp))
    end subroutine wrong
  end subroutine by_name
end module test_card_fields
