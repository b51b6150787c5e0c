!> Reader of STL files: triangles in 3D, ASCII or binary.
!>
!> Only the corners are stored; the normals in the file are ignored, and the outer side is the one from which the
!> corners are counter-clockwise. Names and attributes are ignored. Whether the triangles form a closed solid is checked
!> by `qsmpm_polyhedron_check`.
module qsmpm_stl_reader
  use, intrinsic :: iso_fortran_env, only: real32, int32
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_text, only: string_type, upper, integer_text
  use qsmpm_text_file, only: text_file_type, open_text, next_words, file_error, word_real
  implicit none
  private

  public :: read_stl

  !> Bytes of a binary file before its triangles, and of one triangle.
  integer(long), parameter :: head_bytes = 84, facet_bytes = 50

contains

  !> Reads a file.
  subroutine read_stl(path, facets, error)
    !> Path of the file.
    character(len=*), intent(in) :: path
    !> Corners of the triangles (3, 3, n).
    real(wp), allocatable, intent(out) :: facets(:, :, :)
    !> Error with the path, and the line of an ASCII file.
    type(error_type), allocatable, intent(out) :: error
    type(text_file_type) :: file
    integer(long) :: announced

    call open_text(path, file)
    announced = -1
    if (allocated(file%bytes)) then
      if (len(file%bytes, kind=long) >= head_bytes) announced = integer_at(file%bytes, head_bytes - 3)
      if (len(file%bytes, kind=long) /= head_bytes + facet_bytes*announced) announced = -1
    end if
    if (announced >= 0) then
      call read_binary(file, int(announced), facets)
    else
      call read_ascii(file, facets)
    end if
    if (allocated(file%error)) then
      call move_alloc(file%error, error)
    else if (size(facets, 3) == 0) then
      call fail(error, error_deck, path//': the file has no facets')
    end if
  end subroutine read_stl

  !> Little-endian integer of four bytes.
  pure integer(int32) function integer_at(bytes, place) result(value)
    !> The file.
    character(len=*), intent(in) :: bytes
    !> Position of the first byte.
    integer(long), intent(in) :: place
    integer :: i

    value = 0_int32
    do i = 3, 0, -1
      value = ior(ishft(value, 8), int(ichar(bytes(place + i:place + i)), int32))
    end do
  end function integer_at

  !> Reads the triangles of a binary file: normal, three corners and two bytes each.
  pure subroutine read_binary(file, count, facets)
    type(text_file_type), intent(inout) :: file
    !> Number of triangles.
    integer, intent(in) :: count
    !> Corners (3, 3, n).
    real(wp), allocatable, intent(out) :: facets(:, :, :)
    integer(long) :: place
    integer :: f, i, k

    allocate (facets(3, 3, count))
    do f = 1, count
      place = head_bytes + facet_bytes*(f - 1) + 13
      do k = 1, 3
        do i = 1, 3
          facets(i, k, f) = real(transfer(integer_at(file%bytes, place), 1.0_real32), wp)
          place = place + 4
        end do
      end do
      if (all(abs(facets(:, :, f)) <= huge(1.0_real32))) cycle
      call fail(file%error, error_deck, file%path//': a coordinate of facet '//integer_text(f)// &
        ' is not a finite number')
      return
    end do
  end subroutine read_binary

  !> Reads the triangles of an ASCII file.
  subroutine read_ascii(file, facets)
    type(text_file_type), intent(inout) :: file
    !> Corners (3, 3, n).
    real(wp), allocatable, intent(out) :: facets(:, :, :)
    real(wp), allocatable :: corners(:, :)
    type(string_type), allocatable :: words(:)
    logical :: more
    integer :: n, lines

    allocate (corners(3, 300))
    n = 0
    lines = 0
    do
      call next_words(file, words, more)
      if (.not. more) exit
      lines = lines + 1
      if (lines == 1 .and. upper(words(1)%text) /= 'SOLID') call file_error(file, &
        "the file is no STL: it neither begins with 'solid' nor has the length of a binary file")
      if (upper(words(1)%text) == 'VERTEX') call add_corner(file, words, corners, n)
      if (upper(words(1)%text) == 'ENDFACET' .and. mod(n, 3) /= 0) call file_error(file, &
        'a facet has three corners, each on a line of its own that begins with vertex')
    end do
    allocate (facets, source=reshape(corners(:, :n - mod(n, 3)), [3, 3, n/3]))
    if (mod(n, 3) /= 0) call file_error(file, 'the file ends inside of a facet')
  end subroutine read_ascii

  !> Reads a corner from the words of a line.
  subroutine add_corner(file, words, corners, n)
    type(text_file_type), intent(inout) :: file
    !> The word vertex and three coordinates.
    type(string_type), intent(in) :: words(:)
    !> Corners so far (3, allocated length) and their number.
    real(wp), allocatable, intent(inout) :: corners(:, :)
    integer, intent(inout) :: n
    integer :: i

    if (size(words) /= 4) then
      call file_error(file, 'a vertex has three coordinates')
      return
    end if
    if (n == size(corners, 2)) corners = reshape(corners, [3, 2*n], pad=[0.0_wp])
    n = n + 1
    do i = 1, 3
      call word_real(file, words(i + 1)%text, corners(i, n))
    end do
  end subroutine add_corner
end module qsmpm_stl_reader
