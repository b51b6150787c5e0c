!> Some rows of the datasets of an HDF5 file that is read (qsmpm_hdf5_reader): block by block, so that no more is in
!> memory than what is wanted and one block. Blocks without a wanted row are not read.
module qsmpm_hdf5_rows
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc, c_ptr
  use, intrinsic :: iso_fortran_env, only: int8
  use hdf5, only: hid_t, hsize_t, h5dclose_f, h5dread_f, h5dget_space_f, h5sclose_f, h5screate_simple_f, &
    h5sselect_hyperslab_f, h5s_select_set_f, h5t_native_double, h5t_native_integer, h5kind_to_type, h5_integer_kind
  use qsmpm_kinds, only: wp, long
  use qsmpm_hdf5_reader, only: reader_type, open_dataset, compare_shape
  implicit none
  private

  public :: count_rows, count_components, get_rows

  !> Get rows by their numbers, which rise, of a dataset that has so many in all.
  interface get_rows
    module procedure :: get_real_rows, get_integer_rows, get_long_rows
  end interface get_rows

  !> Rows that are in memory beside those that are wanted.
  integer, parameter, public :: block_rows = 16384

contains

  !> Rows of a dataset of one number a row; 0 where there is none.
  integer function count_rows(reader, path) result(rows)
    type(reader_type), intent(inout) :: reader
    !> Name of the dataset.
    character(len=*), intent(in) :: path

    rows = first_extent(reader, path, 1)
  end function count_rows

  !> Components of a table of reals; 0 where there is none.
  integer function count_components(reader, path) result(components)
    type(reader_type), intent(inout) :: reader
    !> Name of the dataset.
    character(len=*), intent(in) :: path

    components = first_extent(reader, path, 2)
  end function count_components

  !> First extent of a dataset; 0 where there is none.
  integer function first_extent(reader, path, rank) result(extent)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    !> Extents that it must have.
    integer, intent(in) :: rank
    integer(hid_t) :: dataset
    integer(hsize_t) :: dims(rank)
    integer :: status

    call open_dataset(reader, path, dataset, dims)
    extent = int(dims(1))
    if (dataset >= 0) call h5dclose_f(dataset, status)
  end function first_extent

  !> Rows of a table of reals.
  subroutine get_real_rows(reader, path, rows, all_rows, values)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    integer, intent(in) :: rows(:), all_rows
    !> (components, rows)
    real(wp), contiguous, target, intent(inout) :: values(:, :)

    if (size(rows) > 0) call read_rows(reader, path, h5t_native_double, rows, [size(values, 1), all_rows], 8, &
      c_loc(values))
  end subroutine get_real_rows

  !> Rows of integers.
  subroutine get_integer_rows(reader, path, rows, all_rows, values)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    integer, intent(in) :: rows(:), all_rows
    !> (rows)
    integer, contiguous, target, intent(inout) :: values(:)

    if (size(rows) > 0) call read_rows(reader, path, h5t_native_integer, rows, [all_rows], 4, c_loc(values))
  end subroutine get_integer_rows

  !> Rows of long integers.
  subroutine get_long_rows(reader, path, rows, all_rows, values)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    integer, intent(in) :: rows(:), all_rows
    !> (rows)
    integer(long), contiguous, target, intent(inout) :: values(:)

    if (size(rows) > 0) call read_rows(reader, path, h5kind_to_type(long, h5_integer_kind), rows, [all_rows], 8, &
      c_loc(values))
  end subroutine get_long_rows

  !> Read rows block by block, as bytes.
  subroutine read_rows(reader, path, kind, rows, sizes, width, address)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    integer(hid_t), intent(in) :: kind
    !> Rows that are wanted; components and rows of the dataset, and bytes of a value.
    integer, intent(in) :: rows(:), sizes(:), width
    !> Where they go, behind one another.
    type(c_ptr), intent(in) :: address
    integer(int8), pointer :: values(:, :)
    integer(int8), allocatable, target :: buffer(:, :)
    integer(hid_t) :: dataset
    integer :: i, j, rank, row_bytes

    call open_rows(reader, path, sizes, dataset)
    if (dataset < 0) return
    rank = size(sizes)
    row_bytes = width*product(sizes(:rank - 1))
    if (row_bytes > 0) call c_f_pointer(address, values, [row_bytes, size(rows)])
    i = 1
    do while (i <= size(rows) .and. row_bytes > 0)
      j = last_of_block(rows, i)
      allocate (buffer(row_bytes, rows(j) - rows(i) + 1))
      call read_block(reader, path, dataset, kind, rows(i), [sizes(:rank - 1), size(buffer, 2)], c_loc(buffer))
      if (.not. allocated(reader%reason)) values(:, i:j) = buffer(:, rows(i:j) - rows(i) + 1)
      deallocate (buffer)
      i = j + 1
    end do
    call h5dclose_f(dataset, i)
  end subroutine read_rows

  !> Open a dataset that must have some sizes; negative where it cannot be read.
  subroutine open_rows(reader, path, sizes, dataset)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    integer, intent(in) :: sizes(:)
    integer(hid_t), intent(out) :: dataset
    integer(hsize_t) :: dims(size(sizes))
    integer :: status

    call open_dataset(reader, path, dataset, dims)
    call compare_shape(reader, path, dims, int(sizes, hsize_t))
    if (dataset < 0 .or. .not. allocated(reader%reason)) return
    call h5dclose_f(dataset, status)
    dataset = -1
  end subroutine open_rows

  !> Place of the last row that is in one block with that at a place.
  pure integer function last_of_block(rows, place) result(last)
    integer, intent(in) :: rows(:), place

    last = place
    do while (last < size(rows))
      if (rows(last + 1) - rows(place) >= block_rows) return
      last = last + 1
    end do
  end function last_of_block

  !> Read rows that stand behind one another.
  subroutine read_block(reader, path, dataset, kind, first, sizes, address)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    integer(hid_t), intent(in) :: dataset, kind
    !> First row, and components and rows of the block.
    integer, intent(in) :: first, sizes(:)
    type(c_ptr), intent(in) :: address
    type(c_ptr) :: place
    integer(hid_t) :: whole, block
    integer(hsize_t) :: start(size(sizes)), extent(size(sizes))
    integer :: status(6)

    start = 0
    start(size(start)) = first - 1
    extent = sizes
    call h5dget_space_f(dataset, whole, status(1))
    call h5sselect_hyperslab_f(whole, h5s_select_set_f, start, extent, status(2))
    call h5screate_simple_f(size(extent), extent, block, status(3))
    place = address
    call h5dread_f(dataset, kind, place, status(4), mem_space_id=block, file_space_id=whole)
    call h5sclose_f(block, status(5))
    call h5sclose_f(whole, status(6))
    if (any(status < 0) .and. .not. allocated(reader%reason)) reader%reason = path//' is damaged'
  end subroutine read_block
end module qsmpm_hdf5_rows
