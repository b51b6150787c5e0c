!> VTK unstructured grids (.vtu): an XML head and the arrays behind it as raw bytes, each with its
!> length in a 64-bit integer before it.
!>
!> Arrays are handed over to the picture (`move_alloc`), which writes them when it is complete. The
!> four sections are those of the file format; positions and cells must be given. A picture in pieces (.pvtu) is a list
!> of such files, which need not have the nodes at their borders once.
module qsmpm_vtu
  use, intrinsic :: iso_c_binding, only: c_loc, c_ptr
  use, intrinsic :: iso_fortran_env, only: int8
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type
  use qsmpm_file, only: file_type, create_file, put_text, put_bytes, commit_file, write_text
  use qsmpm_number_text, only: integer_text
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: vtu_type, start_vtu, add_reals, add_integers, add_longs, add_bytes, write_vtu, pieces_head, write_pieces

  !> Sections of the file, in its order.
  integer, parameter, public :: section_point_data = 1, section_cell_data = 2, &
    section_points = 3, section_cells = 4
  character(len=*), parameter :: section_name(4) = [character(len=9) :: &
    'PointData', 'CellData', 'Points', 'Cells']
  !> Most arrays of a picture.
  integer, parameter :: most_arrays = 256
  character(len=1), parameter :: newline = new_line('a')

  !> One array; exactly one of the four forms is allocated.
  type :: array_type
    character(len=:), allocatable :: name
    integer :: section = 0
    !> (components, n)
    real(wp), allocatable :: reals(:, :)
    integer, allocatable :: integers(:)
    integer(long), allocatable :: longs(:)
    integer(int8), allocatable :: bytes(:)
  end type array_type

  !> A picture that is being put together.
  type :: vtu_type
    integer :: point_count = 0
    integer :: cell_count = 0
    integer :: array_count = 0
    type(array_type) :: arrays(most_arrays)
  end type vtu_type

contains

  !> Begin a picture.
  subroutine start_vtu(vtu, point_count, cell_count)
    !> The picture.
    type(vtu_type), intent(out) :: vtu
    !> Number of VTK points.
    integer, intent(in) :: point_count
    !> Number of VTK cells.
    integer, intent(in) :: cell_count

    vtu%point_count = point_count
    vtu%cell_count = cell_count
  end subroutine start_vtu

  !> Hand over an array of reals.
  subroutine add_reals(vtu, section, name, values)
    !> The picture.
    type(vtu_type), intent(inout) :: vtu
    !> One of the section_* values.
    integer, intent(in) :: section
    !> Name of the field.
    character(len=*), intent(in) :: name
    !> (components, n); gone afterwards.
    real(wp), allocatable, intent(inout) :: values(:, :)

    call add_array(vtu, section, name)
    call move_alloc(values, vtu%arrays(vtu%array_count)%reals)
  end subroutine add_reals

  !> Hand over an array of integers.
  subroutine add_integers(vtu, section, name, values)
    !> The picture.
    type(vtu_type), intent(inout) :: vtu
    !> One of the section_* values.
    integer, intent(in) :: section
    !> Name of the field.
    character(len=*), intent(in) :: name
    !> (n); gone afterwards.
    integer, allocatable, intent(inout) :: values(:)

    call add_array(vtu, section, name)
    call move_alloc(values, vtu%arrays(vtu%array_count)%integers)
  end subroutine add_integers

  !> Hand over an array of long integers.
  subroutine add_longs(vtu, section, name, values)
    !> The picture.
    type(vtu_type), intent(inout) :: vtu
    !> One of the section_* values.
    integer, intent(in) :: section
    !> Name of the field.
    character(len=*), intent(in) :: name
    !> (n); gone afterwards.
    integer(long), allocatable, intent(inout) :: values(:)

    call add_array(vtu, section, name)
    call move_alloc(values, vtu%arrays(vtu%array_count)%longs)
  end subroutine add_longs

  !> Hand over an array of bytes.
  subroutine add_bytes(vtu, section, name, values)
    !> The picture.
    type(vtu_type), intent(inout) :: vtu
    !> One of the section_* values.
    integer, intent(in) :: section
    !> Name of the field.
    character(len=*), intent(in) :: name
    !> (n); gone afterwards.
    integer(int8), allocatable, intent(inout) :: values(:)

    call add_array(vtu, section, name)
    call move_alloc(values, vtu%arrays(vtu%array_count)%bytes)
  end subroutine add_bytes

  !> Room for one more array.
  subroutine add_array(vtu, section, name)
    !> The picture.
    type(vtu_type), intent(inout) :: vtu
    !> One of the section_* values.
    integer, intent(in) :: section
    !> Name of the field.
    character(len=*), intent(in) :: name

    vtu%array_count = vtu%array_count + 1
    vtu%arrays(vtu%array_count)%section = section
    vtu%arrays(vtu%array_count)%name = name
  end subroutine add_array

  !> Write the picture.
  subroutine write_vtu(vtu, path, error)
    !> The picture.
    type(vtu_type), intent(in) :: vtu
    !> Name of the file.
    character(len=*), intent(in) :: path
    !> Set when the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    type(file_type) :: file
    integer :: section, i

    call create_file(file, path)
    call put_text(file, head(vtu))
    do section = 1, size(section_name)
      do i = 1, vtu%array_count
        if (vtu%arrays(i)%section == section) call put_array(file, vtu%arrays(i))
      end do
    end do
    call put_text(file, newline//'  </AppendedData>'//newline//'</VTKFile>'//newline)
    call commit_file(file, error)
  end subroutine write_vtu

  !> The XML before the raw bytes.
  function head(vtu) result(text)
    !> The picture.
    type(vtu_type), intent(in) :: vtu
    character(len=:), allocatable :: text
    integer(long) :: offset
    integer :: section, i

    text = '<?xml version="1.0"?>'//newline// &
      '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="'//byte_order()// &
      '" header_type="UInt64">'//newline//'  <UnstructuredGrid>'//newline// &
      '    <Piece NumberOfPoints="'//integer_text(vtu%point_count)// &
      '" NumberOfCells="'//integer_text(vtu%cell_count)//'">'//newline
    offset = 0
    do section = 1, size(section_name)
      text = text//'      <'//trim(section_name(section))//'>'//newline
      do i = 1, vtu%array_count
        if (vtu%arrays(i)%section /= section) cycle
        text = text//array_tag(vtu%arrays(i), offset)//newline
        offset = offset + 8 + byte_count(vtu%arrays(i))
      end do
      text = text//'      </'//trim(section_name(section))//'>'//newline
    end do
    text = text//'    </Piece>'//newline//'  </UnstructuredGrid>'//newline// &
      '  <AppendedData encoding="raw">'//newline//'   _'
  end function head

  !> What a picture in pieces says of their arrays: those of one of the pieces.
  function pieces_head(vtu) result(text)
    type(vtu_type), intent(in) :: vtu
    character(len=:), allocatable :: text
    integer :: section, i

    text = '<?xml version="1.0"?>'//newline//'<VTKFile type="PUnstructuredGrid" version="1.0" byte_order="'// &
      byte_order()//'" header_type="UInt64">'//newline//'  <PUnstructuredGrid GhostLevel="0">'//newline
    do section = section_point_data, section_points
      text = text//'    <P'//trim(section_name(section))//'>'//newline
      do i = 1, vtu%array_count
        if (vtu%arrays(i)%section /= section) cycle
        text = text//'      <PDataArray '//array_words(vtu%arrays(i))//'/>'//newline
      end do
      text = text//'    </P'//trim(section_name(section))//'>'//newline
    end do
  end function pieces_head

  !> Write the list of the pieces of a picture.
  subroutine write_pieces(path, head, pieces, error)
    character(len=*), intent(in) :: path
    !> What they have (`pieces_head`).
    character(len=*), intent(in) :: head
    !> Their files, relative to this one.
    type(string_type), intent(in) :: pieces(:)
    !> Set when the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: text
    integer :: i

    text = head
    do i = 1, size(pieces)
      text = text//'    <Piece Source="'//pieces(i)%text//'"/>'//newline
    end do
    call write_text(path, text//'  </PUnstructuredGrid>'//newline//'</VTKFile>'//newline, error)
  end subroutine write_pieces

  !> The tag that describes an array.
  pure function array_tag(array, offset) result(tag)
    type(array_type), intent(in) :: array
    !> Its place behind the underscore, in bytes.
    integer(long), intent(in) :: offset
    character(len=:), allocatable :: tag

    tag = '        <DataArray '//array_words(array)//' format="appended" offset="'//integer_text(offset)//'"/>'
  end function array_tag

  !> Type, name and components of an array.
  pure function array_words(array) result(words)
    type(array_type), intent(in) :: array
    character(len=:), allocatable :: words
    character(len=:), allocatable :: kind
    integer :: components

    components = 1
    if (allocated(array%reals)) then
      kind = 'Float64'
      components = size(array%reals, 1)
    else if (allocated(array%integers)) then
      kind = 'Int32'
    else if (allocated(array%longs)) then
      kind = 'Int64'
    else
      kind = 'UInt8'
    end if
    words = 'type="'//kind//'" Name="'//array%name//'" NumberOfComponents="'//integer_text(components)//'"'// &
      names_of(components)
  end function array_words

  !> Names of the components of a tensor: VTK's own order of the last two is another one.
  pure function names_of(components) result(text)
    integer, intent(in) :: components
    character(len=:), allocatable :: text
    character(len=2), parameter :: names(0:5) = ['XX', 'YY', 'ZZ', 'XY', 'XZ', 'YZ']
    integer :: i

    text = ''
    if (components /= size(names)) return
    do i = 0, size(names) - 1
      text = text//' ComponentName'//integer_text(i)//'="'//names(i)//'"'
    end do
  end function names_of

  !> Bytes of an array without its length.
  pure integer(long) function byte_count(array)
    type(array_type), intent(in) :: array

    if (allocated(array%reals)) then
      byte_count = 8_long*size(array%reals, kind=long)
    else if (allocated(array%integers)) then
      byte_count = 4_long*size(array%integers, kind=long)
    else if (allocated(array%longs)) then
      byte_count = 8_long*size(array%longs, kind=long)
    else
      byte_count = size(array%bytes, kind=long)
    end if
  end function byte_count

  !> Write the length and the bytes of an array.
  subroutine put_array(file, array)
    type(file_type), intent(inout) :: file
    type(array_type), intent(in), target :: array
    integer(long), target :: length

    length = byte_count(array)
    call put_bytes(file, c_loc(length), 8_long)
    if (length == 0) return
    if (allocated(array%reals)) then
      call put_bytes(file, c_loc(array%reals), length)
    else if (allocated(array%integers)) then
      call put_bytes(file, c_loc(array%integers), length)
    else if (allocated(array%longs)) then
      call put_bytes(file, c_loc(array%longs), length)
    else
      call put_bytes(file, c_loc(array%bytes), length)
    end if
  end subroutine put_array

  !> How this machine orders the bytes of a number.
  pure function byte_order() result(name)
    character(len=:), allocatable :: name
    integer(int8) :: bytes(4)

    bytes = transfer(1, bytes)
    if (bytes(1) == 1_int8) then
      name = 'LittleEndian'
    else
      name = 'BigEndian'
    end if
  end function byte_order
end module qsmpm_vtu
