!> Reading of HDF5 files. The library trusts the content; files with a checksum (`qsmpm_checksum`) are verified before.
!> A failure is stored and reported by `close_reader`.
!>
!> Selected rows of a dataset are read block by block, so that only the selected rows and one block are in memory;
!> blocks without a selected row are not read.
module qsmpm_hdf5_reader
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc, c_ptr
  use, intrinsic :: iso_fortran_env, only: int8
  use hdf5, only: hid_t, hsize_t, size_t, h5open_f, h5eset_auto_f, h5iis_valid_f, h5fopen_f, h5fclose_f, h5dopen_f, &
    h5dclose_f, h5dread_f, h5dget_space_f, h5sclose_f, h5sget_simple_extent_ndims_f, h5sget_simple_extent_dims_f, &
    h5aopen_by_name_f, h5aread_f, h5aclose_f, h5lexists_f, h5gget_info_by_name_f, h5lget_name_by_idx_f, &
    h5_index_name_f, h5_iter_inc_f, h5f_acc_rdonly_f, h5t_native_double, h5t_native_integer, h5kind_to_type, &
    h5_integer_kind, h5screate_simple_f, h5sselect_hyperslab_f, h5s_select_set_f
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: open_library, reader_type, open_reader, get_array, get_attribute, find_group, list_group, note_reason, &
    close_reader, count_rows, first_extent, get_rows

  !> A file that is read.
  type :: reader_type
    integer(hid_t) :: file = -1
    character(len=:), allocatable :: path
    !> First item that could not be read, with the reason.
    character(len=:), allocatable :: reason
  end type reader_type

  !> Reads an array. An allocated array must have the shape of that in the file; an array that is not in the file is
  !> left unallocated.
  interface get_array
    module procedure :: get_reals_1, get_reals_2, get_integers_1, get_longs
  end interface get_array

  interface get_attribute
    module procedure :: get_real_attribute, get_integer_attribute
  end interface get_attribute

  !> Reads rows with given ascending indices of a dataset with a given total number of rows.
  interface get_rows
    module procedure :: get_real_rows, get_integer_rows, get_long_rows
  end interface get_rows

  !> Rows in memory in addition to the selected ones.
  integer, parameter, public :: block_rows = 16384

contains

  !> Initialises the library once, since every further call would allocate memory for its types again.
  subroutine open_library()
    logical :: ready
    integer :: status

    call h5iis_valid_f(h5t_native_double, ready, status)
    if (ready .and. status >= 0) return
    call h5open_f(status)
    ! Failures are reported by the caller's error; automatic printing by the library is disabled.
    call h5eset_auto_f(0, status)
  end subroutine open_library

  !> Opens a file.
  subroutine open_reader(reader, path)
    type(reader_type), intent(out) :: reader
    character(len=*), intent(in) :: path
    logical :: there
    integer :: status

    reader%path = path
    inquire (file=path, exist=there)
    if (.not. there) then
      reader%reason = 'there is no such file'
      return
    end if
    call open_library()
    call h5fopen_f(path, h5f_acc_rdonly_f, reader%file, status)
    if (status >= 0) return
    reader%file = -1
    reader%reason = 'it is not an HDF5 file'
  end subroutine open_reader

  !> Closes the file.
  subroutine close_reader(reader, error)
    type(reader_type), intent(inout) :: reader
    !> Set when an item could not be read.
    type(error_type), allocatable, intent(out) :: error
    integer :: status

    if (reader%file >= 0) call h5fclose_f(reader%file, status)
    reader%file = -1
    if (allocated(reader%reason)) call fail(error, error_other, "cannot read '"//reader%path//"': "//reader%reason)
  end subroutine close_reader

  !> Stores the reason of an error, unless one is stored already.
  subroutine note_reason(reader, reason)
    type(reader_type), intent(inout) :: reader
    !> Empty if there is no error.
    character(len=*), intent(in) :: reason

    if (len(reason) > 0 .and. .not. allocated(reader%reason)) reader%reason = reason
  end subroutine note_reason

  !> Returns whether there is a group.
  subroutine find_group(reader, path, there)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    logical, intent(out) :: there
    integer :: status

    there = .false.
    if (allocated(reader%reason)) return
    call h5lexists_f(reader%file, path, there, status)
    there = there .and. status >= 0
  end subroutine find_group

  !> Lists the names in a group in ascending order, including links; none if there is no group.
  subroutine list_group(reader, path, names)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    type(string_type), allocatable, intent(out) :: names(:)
    character(len=80) :: name
    integer(size_t) :: length
    integer :: storage, links, last, status, i
    logical :: there

    call find_group(reader, path, there)
    links = 0
    if (there) call h5gget_info_by_name_f(reader%file, path, storage, links, last, status)
    allocate (names(links))
    do i = 1, links
      name = ''
      call h5lget_name_by_idx_f(reader%file, path, h5_index_name_f, h5_iter_inc_f, int(i - 1, hsize_t), name, status, &
        length)
      names(i)%text = trim(name)
    end do
  end subroutine list_group

  !> Reads a real array.
  subroutine get_reals_1(reader, path, values)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    !> (n)
    real(wp), allocatable, intent(inout), target :: values(:)
    integer(hid_t) :: dataset
    integer(hsize_t) :: dims(1)

    call open_dataset(reader, path, dataset, dims)
    if (allocated(values)) call compare_shape(reader, path, dims, shape(values, kind=hsize_t))
    if (dataset < 0) return
    if (.not. allocated(values)) allocate (values(dims(1)))
    call read_values(reader, path, dataset, h5t_native_double, size(values) > 0, c_loc(values))
  end subroutine get_reals_1

  !> Reads a real table.
  subroutine get_reals_2(reader, path, values)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    !> (components, n)
    real(wp), allocatable, intent(inout), target :: values(:, :)
    integer(hid_t) :: dataset
    integer(hsize_t) :: dims(2)

    call open_dataset(reader, path, dataset, dims)
    if (allocated(values)) call compare_shape(reader, path, dims, shape(values, kind=hsize_t))
    if (dataset < 0) return
    if (.not. allocated(values)) allocate (values(dims(1), dims(2)))
    call read_values(reader, path, dataset, h5t_native_double, size(values) > 0, c_loc(values))
  end subroutine get_reals_2

  !> Reads an integer array.
  subroutine get_integers_1(reader, path, values)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    !> (n)
    integer, allocatable, intent(inout), target :: values(:)
    integer(hid_t) :: dataset
    integer(hsize_t) :: dims(1)

    call open_dataset(reader, path, dataset, dims)
    if (allocated(values)) call compare_shape(reader, path, dims, shape(values, kind=hsize_t))
    if (dataset < 0) return
    if (.not. allocated(values)) allocate (values(dims(1)))
    call read_values(reader, path, dataset, h5t_native_integer, size(values) > 0, c_loc(values))
  end subroutine get_integers_1

  !> Reads a long integer array.
  subroutine get_longs(reader, path, values)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    !> (n)
    integer(long), allocatable, intent(inout), target :: values(:)
    integer(hid_t) :: dataset
    integer(hsize_t) :: dims(1)

    call open_dataset(reader, path, dataset, dims)
    if (allocated(values)) call compare_shape(reader, path, dims, shape(values, kind=hsize_t))
    if (dataset < 0) return
    if (.not. allocated(values)) allocate (values(dims(1)))
    call read_values(reader, path, dataset, h5kind_to_type(long, h5_integer_kind), size(values) > 0, c_loc(values))
  end subroutine get_longs

  !> Opens a dataset of known rank; the identifier is negative if there is none or after a failure.
  subroutine open_dataset(reader, path, dataset, dims)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    integer(hid_t), intent(out) :: dataset
    !> Its sizes, fastest index first; zeros if there is none.
    integer(hsize_t), intent(out) :: dims(:)
    integer(hsize_t) :: largest(size(dims))
    integer(hid_t) :: space
    integer :: status, rank
    logical :: exists

    dataset = -1
    dims = 0
    if (allocated(reader%reason)) return
    call h5lexists_f(reader%file, path, exists, status)
    if (status < 0 .or. .not. exists) return
    call h5dopen_f(reader%file, path, dataset, status)
    if (status < 0) dataset = -1
    rank = 0
    if (dataset >= 0) then
      call h5dget_space_f(dataset, space, status)
      call h5sget_simple_extent_ndims_f(space, rank, status)
      if (rank == size(dims)) call h5sget_simple_extent_dims_f(space, dims, largest, status)
      call h5sclose_f(space, status)
    end if
    if (rank == size(dims)) return
    reader%reason = path//' is not as expected'
    if (dataset >= 0) call h5dclose_f(dataset, status)
    dataset = -1
  end subroutine open_dataset

  !> Stores an error if an array of the file does not have the required shape.
  subroutine compare_shape(reader, path, dims, wanted)
    type(reader_type), intent(inout) :: reader
    !> Path of the dataset.
    character(len=*), intent(in) :: path
    integer(hsize_t), intent(in) :: dims(:)
    !> Required sizes.
    integer(hsize_t), intent(in) :: wanted(:)

    if (allocated(reader%reason) .or. all(dims == wanted)) return
    reader%reason = path//' has another size than in this analysis'
  end subroutine compare_shape

  !> Reads the values of a dataset, if any, and closes it.
  subroutine read_values(reader, path, dataset, in_memory, any_there, address)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    !> The dataset; HDF5 type of the values in memory.
    integer(hid_t), intent(in) :: dataset, in_memory
    logical, intent(in) :: any_there
    type(c_ptr), value :: address
    integer :: status

    status = 0
    if (any_there .and. .not. allocated(reader%reason)) call h5dread_f(dataset, in_memory, address, status)
    if (status < 0) reader%reason = path//' is damaged'
    call h5dclose_f(dataset, status)
  end subroutine read_values

  !> Reads a real attribute of an object.
  subroutine get_real_attribute(reader, object, name, value)
    type(reader_type), intent(inout) :: reader
    !> Path of the group or dataset; name of the attribute.
    character(len=*), intent(in) :: object, name
    !> The value; unchanged after a failure.
    real(wp), intent(inout) :: value
    real(wp), target :: buffer(1)
    logical :: found

    call read_attribute(reader, object, name, h5t_native_double, c_loc(buffer), found)
    if (found) value = buffer(1)
  end subroutine get_real_attribute

  !> Reads an integer attribute of an object.
  subroutine get_integer_attribute(reader, object, name, value)
    type(reader_type), intent(inout) :: reader
    !> Path of the group or dataset; name of the attribute.
    character(len=*), intent(in) :: object, name
    !> The value; unchanged after a failure.
    integer, intent(inout) :: value
    integer, target :: buffer(1)
    logical :: found

    call read_attribute(reader, object, name, h5t_native_integer, c_loc(buffer), found)
    if (found) value = buffer(1)
  end subroutine get_integer_attribute

  !> Reads an attribute of one value.
  subroutine read_attribute(reader, object, name, in_memory, address, found)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: object, name
    !> HDF5 type of the value in memory.
    integer(hid_t), intent(in) :: in_memory
    type(c_ptr), value :: address
    logical, intent(out) :: found
    integer(hid_t) :: attribute
    integer :: status(2)

    found = .false.
    if (allocated(reader%reason)) return
    call h5aopen_by_name_f(reader%file, object, name, attribute, status(1))
    if (status(1) < 0) then
      reader%reason = object//' '//name//' is missing'
      return
    end if
    call h5aread_f(attribute, in_memory, address, status(1))
    call h5aclose_f(attribute, status(2))
    found = status(1) >= 0
    if (.not. found) reader%reason = object//' '//name//' is damaged'
  end subroutine read_attribute

  !> Returns the number of rows of a dataset with one number per row; 0 if there is none.
  integer function count_rows(reader, path) result(rows)
    type(reader_type), intent(inout) :: reader
    !> Path of the dataset.
    character(len=*), intent(in) :: path

    rows = first_extent(reader, path, 1)
  end function count_rows

  !> Returns the first extent of a dataset, e.g. the components of a table; 0 if there is none.
  integer function first_extent(reader, path, rank) result(extent)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    !> Required rank.
    integer, intent(in) :: rank
    integer(hid_t) :: dataset
    integer(hsize_t) :: dims(rank)
    integer :: status

    call open_dataset(reader, path, dataset, dims)
    extent = int(dims(1))
    if (dataset >= 0) call h5dclose_f(dataset, status)
  end function first_extent

  !> Reads rows of a real table.
  subroutine get_real_rows(reader, path, rows, all_rows, values)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    integer, intent(in) :: rows(:), all_rows
    !> (components, rows)
    real(wp), contiguous, target, intent(inout) :: values(:, :)

    if (size(rows) > 0) call read_rows(reader, path, h5t_native_double, rows, [size(values, 1), all_rows], 8, &
      c_loc(values))
  end subroutine get_real_rows

  !> Reads rows of integers.
  subroutine get_integer_rows(reader, path, rows, all_rows, values)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    integer, intent(in) :: rows(:), all_rows
    !> (rows)
    integer, contiguous, target, intent(inout) :: values(:)

    if (size(rows) > 0) call read_rows(reader, path, h5t_native_integer, rows, [all_rows], 4, c_loc(values))
  end subroutine get_integer_rows

  !> Reads rows of long integers.
  subroutine get_long_rows(reader, path, rows, all_rows, values)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    integer, intent(in) :: rows(:), all_rows
    !> (rows)
    integer(long), contiguous, target, intent(inout) :: values(:)

    if (size(rows) > 0) call read_rows(reader, path, h5kind_to_type(long, h5_integer_kind), rows, [all_rows], 8, &
      c_loc(values))
  end subroutine get_long_rows

  !> Reads rows block by block, as bytes.
  subroutine read_rows(reader, path, kind, rows, sizes, width, address)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    integer(hid_t), intent(in) :: kind
    !> Selected rows; components and rows of the dataset; bytes per value.
    integer, intent(in) :: rows(:), sizes(:), width
    !> Address to which the rows are copied in sequence.
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

  !> Opens a dataset with required sizes; negative if it cannot be read.
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

  !> Returns the index of the last selected row in the same block as a given one.
  pure integer function last_of_block(rows, place) result(last)
    integer, intent(in) :: rows(:), place

    last = place
    do while (last < size(rows))
      if (rows(last + 1) - rows(place) >= block_rows) return
      last = last + 1
    end do
  end function last_of_block

  !> Reads consecutive rows.
  subroutine read_block(reader, path, dataset, kind, first, sizes, address)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: path
    integer(hid_t), intent(in) :: dataset, kind
    !> First row; components and rows of the block.
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
end module qsmpm_hdf5_reader
