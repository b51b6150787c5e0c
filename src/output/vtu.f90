!> VTK unstructured grids (.vtu): an XML header followed by the arrays as raw bytes, each preceded by its length as a
!> 64-bit integer.
!>
!> Arrays are written when the picture is complete. The four sections are those of the file format; positions and cells
!> are required. Each process of a team writes a piece of the picture; nodes at the interface of pieces are in each of
!> them.
module qsmpm_vtu
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc, c_ptr
  use, intrinsic :: iso_fortran_env, only: int8
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type
  use qsmpm_file, only: move_to, put_bytes
  use qsmpm_number_text, only: integer_text, newline
  use qsmpm_shared_file, only: shared_file_type, begin_shared, claim, put_at, commit_shared, of_ranks
  use qsmpm_team, only: team_type
  implicit none
  private

  public :: vtu_type, start_vtu, add_array, write_vtu

  !> Sections of the file, in their order.
  integer, parameter, public :: section_point_data = 1, section_cell_data = 2, section_points = 3, section_cells = 4
  character(len=*), parameter :: section_name(4) = [character(len=9) :: 'PointData', 'CellData', 'Points', 'Cells']
  !> Maximum number of arrays of a picture.
  integer, parameter :: most_arrays = 256

  !> An array: its section, the attributes of its tag, its bytes.
  type :: array_type
    integer :: section = 0
    character(len=:), allocatable :: words
    integer(int8), allocatable :: bytes(:)
  end type array_type

  !> A picture under construction.
  type :: vtu_type
    integer :: point_count = 0
    integer :: cell_count = 0
    integer :: array_count = 0
    type(array_type) :: arrays(most_arrays)
  end type vtu_type

  !> Adds an array to a section (section_*): reals (components, n), the others (n).
  interface add_array
    module procedure :: add_reals, add_integers, add_longs, add_bytes
  end interface add_array

contains

  !> Starts a picture.
  subroutine start_vtu(vtu, point_count, cell_count)
    !> The picture.
    type(vtu_type), intent(out) :: vtu
    !> Number of VTK points; number of VTK cells.
    integer, intent(in) :: point_count, cell_count

    vtu%point_count = point_count
    vtu%cell_count = cell_count
  end subroutine start_vtu

  !> Adds a real array.
  subroutine add_reals(vtu, section, name, values)
    type(vtu_type), intent(inout) :: vtu
    integer, intent(in) :: section
    character(len=*), intent(in) :: name
    real(wp), contiguous, target, intent(in) :: values(:, :)

    call add(vtu, section, name, 'Float64', size(values, 1), 8*size(values, kind=long), c_loc(values))
  end subroutine add_reals

  !> Adds an integer array.
  subroutine add_integers(vtu, section, name, values)
    type(vtu_type), intent(inout) :: vtu
    integer, intent(in) :: section
    character(len=*), intent(in) :: name
    integer, contiguous, target, intent(in) :: values(:)

    call add(vtu, section, name, 'Int32', 1, 4*size(values, kind=long), c_loc(values))
  end subroutine add_integers

  !> Adds a long integer array.
  subroutine add_longs(vtu, section, name, values)
    type(vtu_type), intent(inout) :: vtu
    integer, intent(in) :: section
    character(len=*), intent(in) :: name
    integer(long), contiguous, target, intent(in) :: values(:)

    call add(vtu, section, name, 'Int64', 1, 8*size(values, kind=long), c_loc(values))
  end subroutine add_longs

  !> Adds a byte array.
  subroutine add_bytes(vtu, section, name, values)
    type(vtu_type), intent(inout) :: vtu
    integer, intent(in) :: section
    character(len=*), intent(in) :: name
    integer(int8), contiguous, target, intent(in) :: values(:)

    call add(vtu, section, name, 'UInt8', 1, 1*size(values, kind=long), c_loc(values))
  end subroutine add_bytes

  !> Adds the bytes of an array.
  subroutine add(vtu, section, name, kind, components, count, address)
    type(vtu_type), intent(inout) :: vtu
    integer, intent(in) :: section, components
    !> Name of the array; VTK's name of its type.
    character(len=*), intent(in) :: name, kind
    !> Number of bytes; their address, if there are any.
    integer(long), intent(in) :: count
    type(c_ptr), intent(in) :: address
    integer(int8), pointer, contiguous :: bytes(:)

    vtu%array_count = vtu%array_count + 1
    associate (array => vtu%arrays(vtu%array_count))
      array%section = section
      array%words = 'type="'//kind//'" Name="'//name//'" NumberOfComponents="'//integer_text(components)//'"'// &
        names_of(components)
      allocate (array%bytes(count))
      if (count == 0) return
      call c_f_pointer(address, bytes, [count])
      array%bytes(:) = bytes
    end associate
  end subroutine add

  !> Writes the picture: the XML of all pieces, then their bytes. In a team, a process without cells has no piece.
  subroutine write_vtu(vtu, path, team, error)
    !> The picture, or the piece of this process.
    type(vtu_type), intent(in) :: vtu
    !> Name of the file.
    character(len=*), intent(in) :: path
    !> Processes that have a piece.
    type(team_type), intent(in) :: team
    !> Set consistently on all processes when the file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error
    type(shared_file_type) :: shared
    character(len=:), allocatable :: head, piece, middle, tail
    integer(long) :: length, lengths(team%ranks), places(5)
    integer :: section, i, arrays

    arrays = vtu%array_count
    if (vtu%cell_count == 0 .and. team%ranks > 1) arrays = 0
    length = 0
    do i = 1, arrays
      length = length + 8 + size(vtu%arrays(i)%bytes, kind=long)
    end do
    lengths = of_ranks(team, length)
    head = of_first('<?xml version="1.0"?>'//newline//'<VTKFile type="UnstructuredGrid" version="1.0" byte_order="'// &
      byte_order()//'" header_type="UInt64">'//newline//'  <UnstructuredGrid>'//newline)
    piece = piece_text(vtu, arrays, sum(lengths(:team%rank)))
    middle = of_first('  </UnstructuredGrid>'//newline//'  <AppendedData encoding="raw">'//newline//'   _')
    tail = of_first(newline//'  </AppendedData>'//newline//'</VTKFile>'//newline)
    call begin_shared(shared, team, path, sealed=.false.)
    call claim(shared, [len(head, kind=long), len(piece, kind=long), len(middle, kind=long), length, &
      len(tail, kind=long)], places)
    call put_at(shared, places(1), transfer(head, [0_int8]))
    call put_at(shared, places(2), transfer(piece, [0_int8]))
    call put_at(shared, places(3), transfer(middle, [0_int8]))
    call move_to(shared%file, places(4))
    do section = 1, size(section_name)
      do i = 1, arrays
        if (vtu%arrays(i)%section == section) call put_array(shared, vtu%arrays(i)%bytes)
      end do
    end do
    call put_at(shared, places(5), transfer(tail, [0_int8]))
    call commit_shared(shared, error)

  contains

    !> Returns the text on the first process, otherwise an empty text.
    pure function of_first(text) result(own)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: own

      own = text(:merge(len(text), 0, team%rank == 0))
    end function of_first
  end subroutine write_vtu

  !> Returns the XML of a piece; empty if it has no arrays.
  pure function piece_text(vtu, arrays, before) result(text)
    type(vtu_type), intent(in) :: vtu
    integer, intent(in) :: arrays
    !> Bytes of the previous pieces.
    integer(long), intent(in) :: before
    character(len=:), allocatable :: text
    integer(long) :: offset
    integer :: section, i

    text = ''
    if (arrays == 0) return
    text = '    <Piece NumberOfPoints="'//integer_text(vtu%point_count)// &
      '" NumberOfCells="'//integer_text(vtu%cell_count)//'">'//newline
    offset = before
    do section = 1, size(section_name)
      text = text//'      <'//trim(section_name(section))//'>'//newline
      do i = 1, arrays
        if (vtu%arrays(i)%section /= section) cycle
        text = text//'        <DataArray '//vtu%arrays(i)%words//' format="appended" offset="'//integer_text(offset)// &
          '"/>'//newline
        offset = offset + 8 + size(vtu%arrays(i)%bytes, kind=long)
      end do
      text = text//'      </'//trim(section_name(section))//'>'//newline
    end do
    text = text//'    </Piece>'//newline
  end function piece_text

  !> Returns the component names of a tensor, since VTK's default order of the last two differs.
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

  !> Writes the length and the bytes of an array.
  subroutine put_array(shared, bytes)
    type(shared_file_type), intent(inout) :: shared
    integer(int8), contiguous, target, intent(in) :: bytes(:)
    integer(long), target :: length

    length = size(bytes, kind=long)
    call put_bytes(shared%file, c_loc(length), 8_long)
    if (length > 0) call put_bytes(shared%file, c_loc(bytes), length)
  end subroutine put_array

  !> Returns the byte order of this machine.
  pure function byte_order() result(name)
    character(len=:), allocatable :: name
    integer(int8) :: bytes(4)

    bytes = transfer(1, bytes)
    name = trim(merge('LittleEndian', 'BigEndian   ', bytes(1) == 1_int8))
  end function byte_order
end module qsmpm_vtu
