!> Lines of gmsh files: so many words or whole numbers, counts that can be, ends of sections.
module qsmpm_gmsh_lines
  use qsmpm_kinds, only: long
  use qsmpm_text, only: string_type, integer_text
  use qsmpm_text_file, only: text_file_type, next_words, bytes_left, file_error, word_integer
  implicit none
  private

  public :: read_end, words_of_line, numbers_of_line, check_count

contains

  !> The line that closes a section.
  subroutine read_end(file, line)
    class(text_file_type), intent(inout) :: file
    !> The line that must come.
    character(len=*), intent(in) :: line
    type(string_type), allocatable :: words(:)
    logical :: more, good

    call next_words(file, words, more)
    good = size(words) == 1
    if (good) good = words(1)%text == line
    if (.not. good) call file_error(file, 'here should be '//line)
  end subroutine read_end

  !> Words of the next line, at least so many.
  subroutine words_of_line(file, least, what, words)
    class(text_file_type), intent(inout) :: file
    !> Least number of words.
    integer, intent(in) :: least
    !> What the line is to hold, for the message.
    character(len=*), intent(in) :: what
    !> The words; older ones are dropped.
    type(string_type), allocatable, intent(inout) :: words(:)
    logical :: more

    call next_words(file, words, more)
    if (.not. more) then
      call file_error(file, what//' is incomplete: the file ends')
    else if (size(words) < least) then
      call file_error(file, what//' is incomplete: it takes '//integer_text(least)//' words')
    end if
  end subroutine words_of_line

  !> Words of the next line as whole numbers, at least so many; zeros where that is wrong.
  subroutine numbers_of_line(file, least, what, numbers)
    class(text_file_type), intent(inout) :: file
    !> Least number of numbers.
    integer, intent(in) :: least
    !> What the line is to hold, for the message.
    character(len=*), intent(in) :: what
    integer, allocatable, intent(out) :: numbers(:)
    type(string_type), allocatable :: words(:)
    integer :: i

    call words_of_line(file, least, what, words)
    allocate (numbers(max(least, size(words))), source=0)
    do i = 1, size(words)
      call word_integer(file, words(i)%text, numbers(i))
    end do
    if (allocated(file%error)) numbers = 0
  end subroutine numbers_of_line

  !> A number of entries must be one that the rest of the file can hold; 0 where it is not.
  subroutine check_count(file, count, what)
    class(text_file_type), intent(inout) :: file
    !> The number the file announces.
    integer, intent(inout) :: count
    !> What is counted.
    character(len=*), intent(in) :: what

    ! An entry takes a digit and a line end at least.
    if (count < 0 .or. int(count, long) > bytes_left(file)/2 + 1) call file_error(file, &
      integer_text(count)//' '//what//' cannot be: the file is too short')
    if (allocated(file%error)) count = 0
  end subroutine check_count
end module qsmpm_gmsh_lines
