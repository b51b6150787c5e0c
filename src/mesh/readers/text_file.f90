!> Text file as lines of words, with its first error.
!>
!> The file is stored in memory, so that lines have any length and a reader can check whether the rest of the file can
!> contain a given number of entries. The readers interpret the words. The first error is stored, and nothing is read
!> after it, so that a reader need not check for errors after every word.
module qsmpm_text_file
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_file, only: read_text
  use qsmpm_text, only: string_type, read_integer, read_real, number_good, integer_text, stripped, without_return
  implicit none
  private

  public :: text_file_type, open_text, next_line, next_words, unquoted, bytes_left, file_error, word_integer, &
    word_label, word_real

  !> A file in memory, and the position of the reader.
  type :: text_file_type
    character(len=:), allocatable :: path, bytes
    !> First byte not read yet.
    integer(long) :: place = 1
    !> Number of the last line read, from 1.
    integer :: line = 0
    !> First error, `path:line: message`.
    type(error_type), allocatable :: error
  end type text_file_type

contains

  !> Reads a file into memory.
  subroutine open_text(path, file)
    !> Path of any length.
    character(len=*), intent(in) :: path
    !> File, positioned before its first line.
    class(text_file_type), intent(inout) :: file
    !> UTF-8 byte order mark that some editors write.
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

  !> Returns the next line without its line end.
  subroutine next_line(file, line, more)
    !> File, advanced by one line.
    class(text_file_type), intent(inout) :: file
    !> The line, empty after the last one.
    character(len=:), allocatable, intent(out) :: line
    !> False after the last line.
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

  !> Returns the words of the next line that is not blank.
  subroutine next_words(file, words, more)
    !> File, advanced by the lines read.
    class(text_file_type), intent(inout) :: file
    !> The words, none after the last line; older ones are deleted.
    type(string_type), allocatable, intent(inout) :: words(:)
    !> False after the last line.
    logical, intent(out) :: more
    character(len=:), allocatable :: line

    do
      call next_line(file, line, more)
      call words_of(line, words)
      if (size(words) > 0 .or. .not. more) return
    end do
  end subroutine next_words

  !> Splits a line into words at blanks; a name in double quotes is one word.
  pure subroutine words_of(line, words)
    !> Any text.
    character(len=*), intent(in) :: line
    !> The words in order, quotes kept; older ones are deleted.
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

  !> Name without the enclosing double quotes.
  pure function unquoted(word) result(name)
    !> The name, with or without quotes.
    character(len=*), intent(in) :: word
    character(len=:), allocatable :: name

    name = word
    if (len(word) < 2) return
    if (word(1:1) == '"' .and. word(len(word):) == '"') name = stripped(word(2:len(word) - 1))
  end function unquoted

  !> Number of bytes not read yet.
  pure integer(long) function bytes_left(file) result(bytes)
    class(text_file_type), intent(in) :: file

    bytes = max(0_long, len(file%bytes, kind=long) - file%place + 1)
  end function bytes_left

  !> Sets an error at the last line read.
  pure subroutine file_error(file, message)
    class(text_file_type), intent(inout) :: file
    character(len=*), intent(in) :: message

    if (.not. allocated(file%error)) call fail(file%error, error_deck, &
      file%path//':'//integer_text(file%line)//': '//message)
  end subroutine file_error

  !> Reads an integer from a word.
  pure subroutine word_integer(file, word, value)
    class(text_file_type), intent(inout) :: file
    character(len=*), intent(in) :: word
    !> The number.
    integer, intent(out) :: value
    integer :: outcome

    call read_integer(word, value, outcome)
    if (outcome /= number_good) call file_error(file, "'"//word//"' is not a whole number")
  end subroutine word_integer

  !> Reads a label, a positive integer, from a word.
  pure subroutine word_label(file, word, value)
    class(text_file_type), intent(inout) :: file
    character(len=*), intent(in) :: word
    !> The label.
    integer, intent(out) :: value

    call word_integer(file, word, value)
    if (value < 1) call file_error(file, "'"//word//"' is not a positive label")
  end subroutine word_label

  !> Reads a real number from a word.
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
