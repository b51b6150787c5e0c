!> Reading and writing of text: words, numbers, comma-separated lists, search of the nearest known word.
!>
!> Numbers are read strictly (the whole word or nothing), and reals are written with the least number of digits that
!> are read back with identical bits. The module does not depend on the deck format.
module qsmpm_text
  use qsmpm_kinds, only: wp, long
  implicit none
  private

  public :: string_type, upper, stripped, squeezed, without_return, split, json_string, edit_distance, nearest_word, &
    replaced, word_place, did_you_mean, integer_list, read_integer, read_real, integer_text, real_text, same_bits, &
    add_word

  !> The end of a line.
  character(len=1), parameter, public :: newline = new_line('a')
  !> Result of reading a word as a number.
  integer, parameter, public :: number_good = 0, number_not = 1, number_not_finite = 2, number_not_whole = 3

  !> A text of any length, for arrays of texts.
  type :: string_type
    character(len=:), allocatable :: text
  end type string_type

  !> Numbers of this power of ten or more are rejected: 9.99e307 is the largest one accepted.
  integer, parameter :: largest_exponent = 308
  !> Numbers up to this power of ten are zero in double precision.
  integer, parameter :: smallest_exponent = -330

  character(len=*), parameter :: digits = '0123456789'
  character(len=*), parameter :: blanks = ' '//achar(9)

  !> Returns an integer with its sign, without blanks.
  interface integer_text
    procedure :: short_text, long_text
  end interface integer_text

contains

  !> Converts letters a-z to capitals; other bytes are unchanged.
  pure function upper(text) result(changed)
    !> Any text.
    character(len=*), intent(in) :: text
    character(len=len(text)) :: changed
    integer :: i

    changed = text
    do i = 1, len(text)
      if (text(i:i) >= 'a' .and. text(i:i) <= 'z') changed(i:i) = achar(iachar(text(i:i)) - 32)
    end do
  end function upper

  !> Removes blanks and tabs at both ends.
  pure function stripped(text) result(inner)
    !> Any text.
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: inner
    integer :: first, last

    first = verify(text, blanks)
    last = verify(text, blanks, back=.true.)
    inner = ''
    if (first > 0) inner = text(first:last)
  end function stripped

  !> Returns a line without a final carriage return.
  pure function without_return(line) result(text)
    character(len=*), intent(in) :: line
    character(len=:), allocatable :: text

    text = line
    if (len(line) > 0) then
      if (line(len(line):) == achar(13)) text = line(:len(line) - 1)
    end if
  end function without_return

  !> Returns the stripped text with every sequence of blanks and tabs as one blank.
  pure function squeezed(text) result(inner)
    !> Any text.
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: inner, buffer
    integer :: i, n
    logical :: gap

    allocate (character(len=len(text)) :: buffer)
    n = 0
    gap = .false.
    do i = 1, len(text)
      if (index(blanks, text(i:i)) > 0) then
        gap = n > 0
        cycle
      end if
      if (gap) then
        n = n + 1
        buffer(n:n) = ' '
        gap = .false.
      end if
      n = n + 1
      buffer(n:n) = text(i:i)
    end do
    inner = buffer(:n)
  end function squeezed

  !> Splits a text at each separator outside double quotes; every piece is stripped.
  pure subroutine split(text, separator, pieces)
    !> Any text; an empty one gives one empty piece.
    character(len=*), intent(in) :: text
    !> Separator.
    character(len=1), intent(in) :: separator
    !> The pieces in order; previous content is discarded.
    type(string_type), allocatable, intent(inout) :: pieces(:)
    integer, allocatable :: cuts(:)
    integer :: i, n
    logical :: quoted

    allocate (cuts(0:len(text) + 1))
    n = 0
    cuts(0) = 0
    quoted = .false.
    do i = 1, len(text)
      if (text(i:i) == '"') quoted = .not. quoted
      if (text(i:i) == separator .and. .not. quoted) then
        n = n + 1
        cuts(n) = i
      end if
    end do
    cuts(n + 1) = len(text) + 1
    if (allocated(pieces)) deallocate (pieces)
    allocate (pieces(n + 1))
    do i = 1, n + 1
      pieces(i)%text = stripped(text(cuts(i - 1) + 1:cuts(i) - 1))
    end do
  end subroutine split

  !> Returns a text as a JSON string.
  pure function json_string(text) result(string)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: string
    integer :: i

    string = '"'
    do i = 1, len(text)
      if (text(i:i) == '"' .or. text(i:i) == '\') string = string//'\'
      if (text(i:i) == new_line('a')) then
        string = string//'\n'
      else if (iachar(text(i:i)) < 32) then
        string = string//' '
      else
        string = string//text(i:i)
      end if
    end do
    string = string//'"'
  end function json_string

  !> Returns the number of letters to be changed, added, removed or swapped with their neighbour to convert one word to
  !> the other.
  pure integer function edit_distance(a, b) result(distance)
    !> One word; the other.
    character(len=*), intent(in) :: a, b
    integer :: table(0:len(a), 0:len(b)), i, j

    table(:, 0) = [(i, i=0, len(a))]
    table(0, :) = [(j, j=0, len(b))]
    do j = 1, len(b)
      do i = 1, len(a)
        table(i, j) = min(table(i - 1, j) + 1, table(i, j - 1) + 1, &
          table(i - 1, j - 1) + merge(0, 1, a(i:i) == b(j:j)))
        if (swapped(a(:i), b(:j))) table(i, j) = min(table(i, j), table(max(0, i - 2), max(0, j - 2)) + 1)
      end do
    end do
    distance = table(len(a), len(b))
  end function edit_distance

  !> Returns whether the last two letters of one word are those of the other, swapped.
  pure logical function swapped(a, b)
    !> One word; the other.
    character(len=*), intent(in) :: a, b
    integer :: i, j

    i = len(a)
    j = len(b)
    swapped = .false.
    if (min(i, j) > 1) swapped = a(i - 1:i - 1) == b(j:j) .and. a(i:i) == b(j - 1:j - 1)
  end function swapped

  !> Returns the known word nearest to an unknown one, ignoring case; empty if none is near.
  pure function nearest_word(word, known) result(found)
    !> The unknown word.
    character(len=*), intent(in) :: word
    !> Candidate words.
    type(string_type), intent(in) :: known(:)
    character(len=:), allocatable :: found
    !> Longer words are not typing errors; the limit keeps the table of distances small.
    integer, parameter :: longest = 80
    integer :: best, distance, i

    found = ''
    if (len(word) > longest) return
    best = max(1, len(word)/3) + 1
    do i = 1, size(known)
      if (abs(len(known(i)%text) - len(word)) >= best) cycle
      distance = edit_distance(upper(word), upper(known(i)%text))
      if (distance < best) then
        best = distance
        found = known(i)%text
      end if
    end do
  end function nearest_word

  !> Returns integers separated by commas.
  pure function integer_list(values) result(text)
    integer, intent(in) :: values(:)
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(values)
      if (i > 1) text = text//', '
      text = text//integer_text(values(i))
    end do
  end function integer_list

  !> Returns a text in which every occurrence of a character is replaced by another text.
  pure function replaced(text, old, new) result(changed)
    character(len=*), intent(in) :: text
    character(len=1), intent(in) :: old
    character(len=*), intent(in) :: new
    character(len=:), allocatable :: changed
    integer :: first, length

    changed = ''
    first = 1
    do
      length = index(text(first:), old) - 1
      if (length < 0) exit
      changed = changed//text(first:first + length - 1)//new
      first = first + length + 1
    end do
    changed = changed//text(first:)
  end function replaced

  !> Returns the position of a word in a list, 0 if it is not found.
  pure integer function word_place(list, word) result(place)
    type(string_type), intent(in) :: list(:)
    character(len=*), intent(in) :: word

    do place = size(list), 1, -1
      if (list(place)%text == word) return
    end do
  end function word_place

  !> Returns the nearest known word as a question, empty if none is near.
  pure function did_you_mean(word, known) result(text)
    !> As for nearest_word.
    character(len=*), intent(in) :: word
    type(string_type), intent(in) :: known(:)
    character(len=:), allocatable :: text

    text = nearest_word(word, known)
    if (len(text) > 0) text = ' (did you mean '//text//'?)'
  end function did_you_mean

  !> Reads an integer that occupies the whole word.
  pure subroutine read_integer(word, value, outcome)
    !> The word, stripped.
    character(len=*), intent(in) :: word
    !> The number, 0 if there is none; one of the number_* values.
    integer, intent(out) :: value, outcome
    real(wp) :: number
    integer :: status

    value = 0
    call read_real(word, number, outcome)
    if (outcome /= number_good) return
    outcome = number_not_whole
    if (verify(word, '+-'//digits) > 0) return
    read (word, *, iostat=status) value
    if (status == 0) then
      outcome = number_good
    else
      value = 0
    end if
  end subroutine read_integer

  !> Reads a finite real that occupies the whole word: 1, 1.0, .5, 1e3, 1d3.
  pure subroutine read_real(word, value, outcome)
    !> The word, stripped.
    character(len=*), intent(in) :: word
    !> The number, 0 if there is none.
    real(wp), intent(out) :: value
    !> One of the number_* values.
    integer, intent(out) :: outcome
    integer :: status

    value = 0.0_wp
    outcome = number_not
    if (any(upper(word) == [character(len=9) :: 'NAN', 'INF', '+INF', '-INF', 'INFINITY', &
      '+INFINITY', '-INFINITY', '+NAN', '-NAN'])) outcome = number_not_finite
    if (.not. is_number(word)) return
    outcome = number_good
    select case (decimal_size(word))
    case (:smallest_exponent)
      return
    case (largest_exponent:)
      outcome = number_not_finite
      return
    end select
    read (word, *, iostat=status) value
    if (status /= 0) outcome = number_not_finite
  end subroutine read_real

  !> Returns the power of ten of the first digit of a number: numbers beyond the range of doubles are detected without
  !> overflow, which would stop a debug build.
  pure integer function decimal_size(word) result(power)
    !> A word that has the form of a number.
    character(len=*), intent(in) :: word
    !> Exponents are limited to this value, which exceeds the number of digits on any line of a deck.
    integer, parameter :: most = 1000000
    integer :: e, point, first, exponent, status

    e = scan(word//'e', 'eEdD')
    first = scan(word(:e - 1), '123456789')
    power = -most
    if (first == 0) return
    point = scan(word(:e - 1)//'.', '.')
    exponent = 0
    if (e < len(word)) then
      read (word(e + 1:), *, iostat=status) exponent
      if (status /= 0) exponent = most
      if (status /= 0 .and. word(e + 1:e + 1) == '-') exponent = -most
    end if
    power = max(-most, min(most, exponent)) + point - first - merge(1, 0, first < point)
  end function decimal_size

  !> Returns whether a word has the form of a number: sign, digits with at most one point, exponent.
  pure logical function is_number(word)
    !> The word, stripped.
    character(len=*), intent(in) :: word
    character(len=:), allocatable :: mantissa, exponent
    integer :: e

    e = scan(word, 'eEdD')
    mantissa = unsigned(word)
    exponent = '0'
    if (e > 0) then
      mantissa = unsigned(word(:e - 1))
      exponent = unsigned(word(e + 1:))
    end if
    is_number = verify(mantissa, digits//'.') == 0 .and. scan(mantissa, digits) > 0 .and. &
      index(mantissa, '.') == index(mantissa, '.', back=.true.) .and. &
      len(exponent) > 0 .and. verify(exponent, digits) == 0
  end function is_number

  !> Returns a word without one leading sign.
  pure function unsigned(word) result(rest)
    character(len=*), intent(in) :: word
    character(len=:), allocatable :: rest

    rest = word
    if (len(word) > 0) then
      if (scan(word(1:1), '+-') == 1) rest = word(2:)
    end if
  end function unsigned

  !> Returns an integer without blanks.
  pure function short_text(value) result(text)
    !> The number.
    integer, intent(in) :: value
    character(len=:), allocatable :: text

    text = long_text(int(value, long))
  end function short_text

  !> Returns a long integer without blanks.
  pure function long_text(value) result(text)
    !> The number.
    integer(long), intent(in) :: value
    character(len=:), allocatable :: text
    character(len=20) :: buffer

    write (buffer, '(i0)') value
    text = trim(buffer)
  end function long_text

  !> Returns a real with the least number of digits that are read back with identical bits: 0.15, 100, 1e-3, 2.5e12.
  pure function real_text(value) result(text)
    !> The number, finite.
    real(wp), intent(in) :: value
    character(len=:), allocatable :: text
    !> Sufficient number of digits after the first one for any double.
    integer, parameter :: enough = 16
    character(len=32) :: buffer, form
    real(wp) :: back
    integer :: decimals, exponent, e

    do decimals = 0, enough
      write (form, '(a,i0,a)') '(es32.', decimals, 'e3)'
      write (buffer, form) value
      read (buffer, *) back
      if (same_bits(back, value)) exit
    end do
    buffer = adjustl(buffer)
    e = index(buffer, 'E')
    read (buffer(e + 1:), *) exponent
    text = laid_out(value < 0.0_wp .or. buffer(1:1) == '-', without_point(buffer(:e - 1)), exponent)
  end function real_text

  !> Returns the digits of a number without sign, point and trailing zeros.
  pure function without_point(mantissa) result(figures)
    !> Sign, digit, point, digits.
    character(len=*), intent(in) :: mantissa
    character(len=:), allocatable :: figures
    integer :: i

    figures = ''
    do i = 1, len(mantissa)
      if (index(digits, mantissa(i:i)) > 0) figures = figures//mantissa(i:i)
    end do
    do while (len(figures) > 1 .and. figures(len(figures):) == '0')
      figures = figures(:len(figures) - 1)
    end do
  end function without_point

  !> Returns d.ddd x 10^exponent in common notation.
  pure function laid_out(negative, figures, exponent) result(text)
    !> Sign.
    logical, intent(in) :: negative
    !> Digits; the first one is before the point.
    character(len=*), intent(in) :: figures
    !> Power of ten of the first digit.
    integer, intent(in) :: exponent
    character(len=:), allocatable :: text
    !> Maximum number of digits before the point and of zeros after it without an exponent.
    integer, parameter :: most_before = 8, most_zeros = 4

    if (exponent > most_before .or. exponent < -most_zeros) then
      text = figures(1:1)
      if (len(figures) > 1) text = text//'.'//figures(2:)
      text = text//'e'//integer_text(exponent)
    else if (exponent < 0) then
      text = '0.'//repeat('0', -exponent - 1)//figures
    else if (len(figures) > exponent + 1) then
      text = figures(:exponent + 1)//'.'//figures(exponent + 2:)
    else
      text = figures//repeat('0', exponent + 1 - len(figures))
    end if
    if (negative) text = '-'//text
  end function laid_out

  !> Returns whether two reals have identical bits.
  elemental logical function same_bits(a, b)
    !> One number; the other.
    real(wp), intent(in) :: a, b

    same_bits = transfer(a, 0_long) == transfer(b, 0_long)
  end function same_bits

  !> Appends a word to a list.
  pure subroutine add_word(list, word)
    !> The list, allocated.
    type(string_type), allocatable, intent(inout) :: list(:)
    character(len=*), intent(in) :: word
    type(string_type) :: item

    item%text = word
    list = [list, item]
  end subroutine add_word
end module qsmpm_text
