!> Tests of text scanning: words, lists, strict numbers, shortest reals, nearest word.
module test_text
  use, intrinsic :: ieee_arithmetic, only: ieee_next_after
  use qsmpm_kinds, only: wp
  use qsmpm_plain_text, only: plain_text
  use qsmpm_text, only: string_type, upper, stripped, squeezed, split, edit_distance, &
    nearest_word, read_integer, read_real, integer_text, real_text, same_bits, number_good, &
    number_not, number_not_finite, number_not_whole
  use testing, only: tests_type
  implicit none
  private

  public :: collect_text

contains

  !> The suite.
  subroutine collect_text(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('text')
    call words(tests)
    call plain(tests)
    call lists(tests)
    call whole_numbers(tests)
    call reals(tests)
    call written_reals(tests)
    call near_words(tests)
  end subroutine collect_text

  !> Case and blanks.
  subroutine words(tests)
    type(tests_type), intent(inout) :: tests
    character(len=1), parameter :: tab = achar(9)

    call tests%check('capitals are made of a to z only', upper('aZ9_-'//char(195)) == 'AZ9_-'// &
      char(195))
    call tests%check('blanks and tabs at the ends go', stripped(' '//tab//'a b'//tab//' ') == 'a b')
    call tests%check('a blank text is stripped to nothing', len(stripped('   ')) == 0)
    call tests%check('blanks inside are squeezed to one', squeezed('  plane '//tab// &
      '  strain ') == 'plane strain')
    call tests%check('an empty text is squeezed to nothing', len(squeezed('')) == 0)
  end subroutine words

  !> Text as other programs save it.
  subroutine plain(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: umlaut = char(195)//char(182), mark = char(239)//char(187)//char(191)

    call tests%check('UTF-8 stays', plain_text('bl'//umlaut//'ck'//char(226)//char(136)//char(146)) == 'bl'//umlaut//'ck'// &
      char(226)//char(136)//char(146))
    call tests%check('Latin-1 becomes UTF-8', plain_text('bl'//char(246)//'ck') == 'bl'//umlaut//'ck')
    call tests%check('a letter that is cut off is none of UTF-8', plain_text('a'//char(195)) == 'a'//char(195)//char(131))
    call tests%check('a byte order mark goes', plain_text(mark//'a') == 'a')
    call tests%check('carriage returns alone end lines', plain_text('a'//achar(13)//'b') == 'a'//new_line('a')//'b')
    call tests%check('those before a newline are left', len(plain_text('a'//achar(13)//new_line('a'))) == 3)
    call tests%check('a blank that does not break is one', plain_text('1,'//char(194)//char(160)//'2') == '1, 2')
    call tests%check('the end of a file under DOS goes', plain_text('a'//achar(26)) == 'a')
    call tests%check('nothing is plain', len(plain_text('')) == 0)
  end subroutine plain

  !> Lists with commas and quotes.
  subroutine lists(tests)
    type(tests_type), intent(inout) :: tests
    type(string_type), allocatable :: pieces(:)

    call split(' a , "b, c",, d', ',', pieces)
    call tests%check('four pieces are cut', size(pieces) == 4)
    call tests%check('pieces are stripped', pieces(1)%text == 'a' .and. pieces(4)%text == 'd')
    call tests%check('a comma in quotes does not cut', pieces(2)%text == '"b, c"')
    call tests%check('nothing between commas is an empty piece', len(pieces(3)%text) == 0)
    call split('', ',', pieces)
    call tests%check('an empty text is one piece', size(pieces) == 1)
    call split(repeat('1,', 1000000)//'1', ',', pieces)
    call tests%check('a line of two million bytes is cut', size(pieces) == 1000001)
  end subroutine lists

  !> Whole numbers are read as whole words.
  subroutine whole_numbers(tests)
    type(tests_type), intent(inout) :: tests
    integer :: value, outcome

    call read_integer('-12', value, outcome)
    call tests%check('a whole number is read', outcome == number_good .and. value == -12)
    call read_integer('1.0', value, outcome)
    call tests%check('a real is no whole number', outcome == number_not_whole .and. value == 0)
    call read_integer('99999999999', value, outcome)
    call tests%check('a number beyond the integers is refused', outcome == number_not_whole)
    call read_integer('12x', value, outcome)
    call tests%check('a number with a letter is none', outcome == number_not)
    call read_integer('', value, outcome)
    call tests%check('nothing is no number', outcome == number_not)
    call tests%check('whole numbers are written without blanks', integer_text(-7) == '-7')
  end subroutine whole_numbers

  !> Reals are read as whole words.
  subroutine reals(tests)
    type(tests_type), intent(inout) :: tests
    character(len=6), parameter :: good(8) = [character(len=6) :: &
      '1', '1.0', '1e3', '1d3', '.5', '5.', '-1E-3', '+2.5']
    real(wp), parameter :: values(8) = [1.0_wp, 1.0_wp, 1.0e3_wp, 1.0e3_wp, 0.5_wp, 5.0_wp, &
      -1.0e-3_wp, 2.5_wp]
    character(len=6), parameter :: bad(12) = [character(len=6) :: &
      '1 2', '1,2', 'e3', '1e', '.', '-', '1.2.3', '2*3', '1/', 'abc', '0x1', '1e3.5']
    real(wp) :: value
    integer :: outcome, i

    do i = 1, size(good)
      call read_real(trim(good(i)), value, outcome)
      call tests%check('read as a real: '//trim(good(i)), outcome == number_good .and. &
        same_bits(value, values(i)))
    end do
    do i = 1, size(bad)
      call read_real(trim(bad(i)), value, outcome)
      call tests%check('refused as a real: '//trim(bad(i)), outcome == number_not)
    end do
    call read_real('NaN', value, outcome)
    call tests%check('NaN is not finite', outcome == number_not_finite)
    call read_real('-Inf', value, outcome)
    call tests%check('Inf is not finite', outcome == number_not_finite)
    call read_real('1e999', value, outcome)
    call tests%check('a number beyond the doubles is not finite', outcome == number_not_finite)
    call read_real('1.8e308', value, outcome)
    call tests%check('nor is one just beyond', outcome == number_not_finite)
    call read_real('-0.00018d+0312', value, outcome)
    call tests%check('however it is written', outcome == number_not_finite)
    call read_real('1e99999999999999', value, outcome)
    call tests%check('nor one whose exponent is no integer', outcome == number_not_finite)
    call read_real('0e99999999999999', value, outcome)
    call tests%check('zero is zero with any exponent', outcome == number_good)
    call read_real('1e-400', value, outcome)
    call tests%check('a number below the doubles is zero', outcome == number_good .and. &
      same_bits(value, 0.0_wp))
  end subroutine reals

  !> Reals are written short and read back to the same bits.
  subroutine written_reals(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: value, back
    integer :: i, outcome
    logical :: same

    call tests%check('0.15 is written 0.15', real_text(0.15_wp) == '0.15')
    call tests%check('100 is written 100', real_text(100.0_wp) == '100')
    call tests%check('-1e-3 is written -0.001', real_text(-1.0e-3_wp) == '-0.001')
    call tests%check('1e-5 is written 1e-5', real_text(1.0e-5_wp) == '1e-5')
    call tests%check('2.5e12 is written 2.5e12', real_text(2.5e12_wp) == '2.5e12')
    call tests%check('zero is written 0', real_text(0.0_wp) == '0')
    same = .true.
    value = 1.0_wp/3.0_wp
    do i = 1, 600
      value = -value*3.217_wp
      if (i == 250) value = 1.0e-300_wp
      call read_real(real_text(value), back, outcome)
      same = same .and. outcome == number_good .and. same_bits(value, back)
    end do
    call tests%check('600 reals from 1e-300 to 1e176 read back to the same bits', same)
    value = ieee_next_after(1.0_wp, 2.0_wp)
    call read_real(real_text(value), back, outcome)
    call tests%check('the number after 1 is told from 1', same_bits(value, back))
    call read_real(real_text(9.9e307_wp), back, outcome)
    call tests%check('9.9e307 reads back', same_bits(9.9e307_wp, back))
    call read_real(real_text(tiny(1.0_wp)), back, outcome)
    call tests%check('the least normal number reads back', same_bits(tiny(1.0_wp), back))
  end subroutine written_reals

  !> Distances of words.
  subroutine near_words(tests)
    type(tests_type), intent(inout) :: tests
    type(string_type) :: known(3)

    known(1)%text = 'TOLERANCE'
    known(2)%text = 'STEPS'
    known(3)%text = 'Clay'
    call tests%check('equal words have no distance', edit_distance('abc', 'abc') == 0)
    call tests%check('a swap is one change', edit_distance('RIHGT', 'RIGHT') == 1)
    call tests%check('kitten is three changes from sitting', edit_distance('kitten', &
      'sitting') == 3)
    call tests%check('an empty word is as far as the other is long', edit_distance('', 'abc') == 3)
    call tests%check('a typing error finds its word', nearest_word('TOLERENCE', &
      known) == 'TOLERANCE')
    call tests%check('case does not count', nearest_word('clay', known) == 'Clay')
    call tests%check('a different word finds none', len(nearest_word('GRAVITY', known)) == 0)
  end subroutine near_words
end module test_text
