!> A text file as lines of words, with the place for messages.
!>
!> The file is held in memory, so lines have any length and a reader can tell whether a number of
!> entries a file announces can be in it at all. What the words mean is left to the readers. The file keeps the first
!> thing that was wrong, and nothing is read behind it: a reader need not look after every word.
module qsmpm_text_file
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_file, only: read_text
  use qsmpm_text, only: string_type, read_integer, read_real, number_good, integer_text, stripped, without_return
  implicit none
  private

  public :: text_file_type, open_text, next_line, next_words, unquoted, bytes_left, file_error, word_integer, &
    word_label, word_real

  !> A file read as a whole, and where the reader stands.
  type :: text_file_type
    character(len=:), allocatable :: path, bytes
    !> First byte that is not read yet.
    integer(long) :: place = 1
    !> Line read last, from 1.
    integer :: line = 0
    !> `path:line: what is wrong`, the first one.
    type(error_type), allocatable :: error
  end type text_file_type

contains

  !> Read a file into memory.
  subroutine open_text(path, file)
    !> Path of any length.
    character(len=*), intent(in) :: path
    !> The file, before its first line.
    class(text_file_type), intent(inout) :: file
    !> Bytes some editors mark UTF-8 with.
    character(len=3), parameter :: mark = char(239)//char(187)//char(191)
    type(error_type), allocatable :: unread

    file%path = path
    call read_text(path, file%bytes, unread)
    if (allocated(unread)) then
      call fail(file%error, error_deck, "cannot read the file '"//path//"'")
    else if (index(file%bytes, mark) == 1) then
      file%place = 4
    end if
  end subroutine open_text

  !> The next line without its end.
  subroutine next_line(file, line, more)
    !> The file; it moves on by one line.
    class(text_file_type), intent(inout) :: file
    !> The line, empty behind the last.
    character(len=:), allocatable, intent(out) :: line
    !> False behind the last line.
    logical, intent(out) :: more
    integer(long) :: length

    more = .not. allocated(file%error)
    if (more) more = file%place <= len(file%bytes, kind=long)
    line = ''
    if (.not. more) return
    file%line = file%line + 1
    length = index(file%bytes(file%place:), new_line('a'), kind=long) - 1
    if (length < 0) length = len(file%bytes, kind=long) - file%place + 1
    line = without_return(file%bytes(file%place:file%place + length - 1))
    file%place = file%place + length + 1
  end subroutine next_line

  !> Words of the next line that is not blank.
  subroutine next_words(file, words, more)
    !> The file; it moves on.
    class(text_file_type), intent(inout) :: file
    !> The words, none behind the last line; older ones are dropped.
    type(string_type), allocatable, intent(inout) :: words(:)
    !> False behind the last line.
    logical, intent(out) :: more
    character(len=:), allocatable :: line

    do
      call next_line(file, line, more)
      call words_of(line, words)
      if (size(words) > 0 .or. .not. more) return
    end do
  end subroutine next_words

  !> Words between blanks; a name in double quotes is one word.
  pure subroutine words_of(line, words)
    !> Any text.
    character(len=*), intent(in) :: line
    !> The words in order, quotes kept; older ones are dropped.
    type(string_type), allocatable, intent(inout) :: words(:)
    integer, allocatable :: first(:), last(:)
    logical :: quoted, inside, blank
    integer :: i, n

    allocate (first(len(line)/2 + 1), last(len(line)/2 + 1))
    n = 0
    quoted = .false.
    inside = .false.
    do i = 1, len(line)
      if (line(i:i) == '"') quoted = .not. quoted
      blank = .not. quoted .and. (line(i:i) == ' ' .or. line(i:i) == achar(9))
      if (.not. blank .and. .not. inside) then
        n = n + 1
        first(n) = i
      end if
      inside = .not. blank
      if (inside) last(n) = i
    end do
    if (allocated(words)) deallocate (words)
    allocate (words(n))
    do i = 1, n
      words(i)%text = line(first(i):last(i))
    end do
  end subroutine words_of

  !> A name without the double quotes around it.
  pure function unquoted(word) result(name)
    !> The name, with or without quotes.
    character(len=*), intent(in) :: word
    character(len=:), allocatable :: name

    name = word
    if (len(word) < 2) return
    if (word(1:1) == '"' .and. word(len(word):) == '"') name = stripped(word(2:len(word) - 1))
  end function unquoted

  !> Bytes behind the reader.
  pure integer(long) function bytes_left(file) result(bytes)
    class(text_file_type), intent(in) :: file

    bytes = max(0_long, len(file%bytes, kind=long) - file%place + 1)
  end function bytes_left

  !> Error at the line read last.
  pure subroutine file_error(file, message)
    class(text_file_type), intent(inout) :: file
    character(len=*), intent(in) :: message

    if (.not. allocated(file%error)) call fail(file%error, error_deck, &
      file%path//':'//integer_text(file%line)//': '//message)
  end subroutine file_error

  !> A whole number out of a word.
  pure subroutine word_integer(file, word, value)
    class(text_file_type), intent(inout) :: file
    character(len=*), intent(in) :: word
    !> The number.
    integer, intent(out) :: value
    integer :: outcome

    call read_integer(word, value, outcome)
    if (outcome /= number_good) call file_error(file, "'"//word//"' is not a whole number")
  end subroutine word_integer

  !> A label, that is a positive whole number, out of a word.
  pure subroutine word_label(file, word, value)
    class(text_file_type), intent(inout) :: file
    character(len=*), intent(in) :: word
    !> The label.
    integer, intent(out) :: value

    call word_integer(file, word, value)
    if (value < 1) call file_error(file, "'"//word//"' is not a positive label")
  end subroutine word_label

  !> A number out of a word.
  pure subroutine word_real(file, word, value)
    class(text_file_type), intent(inout) :: file
    character(len=*), intent(in) :: word
    !> The number.
    real(wp), intent(out) :: value
    integer :: outcome

    call read_real(word, value, outcome)
    if (outcome /= number_good) call file_error(file, "'"//word//"' is not a number")
  end subroutine word_real
end module qsmpm_text_file
