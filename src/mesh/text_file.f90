!> A text file as lines of words, with the place for messages.
module qsmpm_text_file
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_text, only: string_type, read_integer, read_real, number_good, integer_text
  implicit none
  private

  public :: text_file_type, open_text, next_line, words_of, file_fault, word_integer, word_real

  !> A file read as a whole, and where the reader stands.
  type :: text_file_type
    character(len=:), allocatable :: path, bytes
    integer :: place = 1, line = 0
  end type text_file_type

contains

  !> Read a file into memory.
  subroutine open_text(path, file, error)
    character(len=*), intent(in) :: path
    !> The file being read.
    type(text_file_type), intent(out) :: file
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    integer :: unit, status, length

    file%path = path
    open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read', iostat=status)
    if (status == 0) then
      inquire (unit=unit, size=length)
      allocate (character(len=max(0, length)) :: file%bytes)
      if (length > 0) read (unit, iostat=status) file%bytes
      close (unit)
    end if
    if (status /= 0) call fail(error, error_deck, "cannot read the mesh file '"//path//"'")
  end subroutine open_text

  !> The next line without its end; `more` is false behind the last.
  subroutine next_line(file, line, more)
    !> The file being read.
    type(text_file_type), intent(inout) :: file
    !> The line.
    character(len=:), allocatable, intent(out) :: line
    logical, intent(out) :: more
    integer :: last

    more = file%place <= len(file%bytes)
    line = ''
    if (.not. more) return
    file%line = file%line + 1
    last = index(file%bytes(file%place:), new_line('a'))
    if (last == 0) then
      line = file%bytes(file%place:)
      file%place = len(file%bytes) + 1
    else
      line = file%bytes(file%place:file%place + last - 2)
      file%place = file%place + last
    end if
    if (len(line) > 0) then
      if (line(len(line):) == achar(13)) line = line(:len(line) - 1)
    end if
  end subroutine next_line

  !> Words between blanks; a name in double quotes is one word.
  pure subroutine words_of(line, words)
    !> The line.
    character(len=*), intent(in) :: line
    !> Words of the line.
    type(string_type), allocatable, intent(out) :: words(:)
    type(string_type) :: found(len(line)/2 + 1)
    integer :: i, first, n
    logical :: quoted

    n = 0
    first = 0
    quoted = .false.
    do i = 1, len(line) + 1
      if (i <= len(line)) then
        if (line(i:i) == '"') quoted = .not. quoted
        if (quoted .or. .not. (line(i:i) == ' ' .or. line(i:i) == achar(9))) then
          if (first == 0) first = i
          cycle
        end if
      end if
      if (first == 0) cycle
      n = n + 1
      found(n)%text = line(first:i - 1)
      first = 0
    end do
    words = found(:n)
  end subroutine words_of

  !> Error at the present line.
  subroutine file_fault(file, message, error)
    !> The file being read.
    type(text_file_type), intent(in) :: file
    character(len=*), intent(in) :: message
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error

    call fail(error, error_deck, file%path//':'//integer_text(file%line)//': '//message)
  end subroutine file_fault

  !> A whole number out of a word.
  subroutine word_integer(file, word, value, error)
    !> The file being read.
    type(text_file_type), intent(in) :: file
    character(len=*), intent(in) :: word
    integer, intent(out) :: value
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(inout) :: error
    integer :: outcome

    call read_integer(word, value, outcome)
    if (outcome /= number_good .and. .not. allocated(error)) &
      call file_fault(file, "'"//word//"' is not a whole number", error)
  end subroutine word_integer

  !> A number out of a word.
  subroutine word_real(file, word, value, error)
    !> The file being read.
    type(text_file_type), intent(in) :: file
    character(len=*), intent(in) :: word
    real(wp), intent(out) :: value
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(inout) :: error
    integer :: outcome

    call read_real(word, value, outcome)
    if (outcome /= number_good .and. .not. allocated(error)) &
      call file_fault(file, "'"//word//"' is not a number", error)
  end subroutine word_real
end module qsmpm_text_file
