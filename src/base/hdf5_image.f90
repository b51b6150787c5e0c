!> HDF5 files that are put together in memory and written as one piece of bytes.
!>
!> The library never writes to the disk itself, so that a full disk is met by `qsmpm_file`, which
!> leaves no half file, and not by the library's caches. Objects carry no times: the same state
!> gives the same bytes. A failure is kept and reported by `save_image`. Reading is `qsmpm_hdf5_reader`;
!> no other module uses the library.
module qsmpm_hdf5_image
  use, intrinsic :: iso_c_binding, only: c_loc, c_null_ptr, c_ptr
  use, intrinsic :: iso_fortran_env, only: int8, int32
  use hdf5, only: hid_t, hsize_t, size_t, h5open_f, h5eset_auto_f, h5iis_valid_f, h5pcreate_f, &
    h5pclose_f, h5pset_fapl_core_f, h5pset_obj_track_times_f, h5fcreate_f, h5fclose_f, &
    h5fflush_f, h5fget_file_image_f, h5gcreate_f, h5gclose_f, h5screate_f, h5screate_simple_f, &
    h5sclose_f, h5s_scalar_f, h5dcreate_f, h5dclose_f, h5dwrite_f, h5acreate_by_name_f, &
    h5awrite_f, h5aclose_f, h5lcreate_external_f, h5p_file_access_f, h5p_dataset_create_f, &
    h5f_acc_trunc_f, h5f_scope_global_f, h5t_ieee_f64le, h5t_std_i32le, h5t_native_double, &
    h5t_native_integer, h5t_std_i64le, h5kind_to_type, h5_integer_kind
  use qsmpm_checksum, only: crc32
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_file, only: file_type, create_file, put_bytes, put_text, commit_file
  use qsmpm_seal, only: seal_line
  implicit none
  private

  public :: image_type, dataset_type, create_image, put_group, put_array, put_attribute, put_link, save_image, &
    discard_image, open_library, create_dataset, close_dataset, note_failure

  !> Steps in which the memory of an image grows [bytes].
  integer(size_t), parameter :: growth = 1048576_size_t
  !> Datasets for which there is room at first.
  integer, parameter :: most_at_first = 64

  !> A dataset that was put: its HDF5 type and its sizes, the fastest first.
  type :: dataset_type
    character(len=:), allocatable :: path
    integer(hid_t) :: kind = -1
    integer(hsize_t), allocatable :: dimensions(:)
  end type dataset_type

  !> A file that is being put together in memory.
  type :: image_type
    integer(hid_t) :: file = -1
    !> Property list of datasets: no times.
    integer(hid_t) :: dataset_list = -1
    !> What was put so far (count), and room for more.
    integer :: count = 0
    type(dataset_type), allocatable :: datasets(:)
    !> First object that could not be made.
    character(len=:), allocatable :: reason
  end type image_type

  !> Put an array; an allocatable one that is not allocated is left out.
  interface put_array
    module procedure :: put_reals_1, put_reals_2, put_integers_1, put_integers_2, put_longs
  end interface put_array

  interface put_attribute
    module procedure :: put_real_attribute, put_integer_attribute
  end interface put_attribute

contains

  !> Make the library ready, once: every further start would take memory for its types again.
  subroutine open_library()
    logical :: ready
    integer :: status

    call h5iis_valid_f(h5t_native_double, ready, status)
    if (ready .and. status >= 0) return
    call h5open_f(status)
    ! Failures are reported by the caller's error, not by the library on the screen.
    call h5eset_auto_f(0, status)
  end subroutine open_library

  !> Begin a file in memory.
  subroutine create_image(image, name)
    !> The file.
    type(image_type), intent(out) :: image
    !> What the library knows it by, where another one is open too.
    character(len=*), intent(in), optional :: name
    character(len=:), allocatable :: known
    integer(hid_t) :: access
    integer :: status(6)

    status = 0
    known = 'qsmpm.image'
    if (present(name)) known = name
    call open_library()
    call h5pcreate_f(h5p_file_access_f, access, status(1))
    call h5pset_fapl_core_f(access, growth, .false., status(2))
    call h5fcreate_f(known, h5f_acc_trunc_f, image%file, status(3), access_prp=access)
    call h5pclose_f(access, status(4))
    call h5pcreate_f(h5p_dataset_create_f, image%dataset_list, status(5))
    call h5pset_obj_track_times_f(image%dataset_list, .false., status(6))
    call note_failure(image%reason, any(status < 0), 'the file')
  end subroutine create_image

  !> Make a group; those above it must be there.
  subroutine put_group(image, path)
    !> The file.
    type(image_type), intent(inout) :: image
    !> Name of the group.
    character(len=*), intent(in) :: path
    integer(hid_t) :: group
    integer :: status

    call h5gcreate_f(image%file, path, group, status)
    call note_failure(image%reason, status < 0, path)
    if (status >= 0) call h5gclose_f(group, status)
  end subroutine put_group

  !> Put a row of reals.
  subroutine put_reals_1(image, path, values)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: path
    !> (n)
    real(wp), allocatable, intent(in), target :: values(:)

    if (.not. allocated(values)) return
    call put_values(image, path, h5t_ieee_f64le, h5t_native_double, shape(values, kind=hsize_t), c_loc(values))
  end subroutine put_reals_1

  !> Put a table of reals, (components, n) here and (n, components) in the order of C.
  subroutine put_reals_2(image, path, values)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: path
    !> (components, n)
    real(wp), allocatable, intent(in), target :: values(:, :)

    if (.not. allocated(values)) return
    call put_values(image, path, h5t_ieee_f64le, h5t_native_double, shape(values, kind=hsize_t), c_loc(values))
  end subroutine put_reals_2

  !> Put a row of integers.
  subroutine put_integers_1(image, path, values)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: path
    !> (n)
    integer, allocatable, intent(in), target :: values(:)

    if (.not. allocated(values)) return
    call put_values(image, path, h5t_std_i32le, h5t_native_integer, shape(values, kind=hsize_t), c_loc(values))
  end subroutine put_integers_1

  !> Put a row of long integers.
  subroutine put_longs(image, path, values)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: path
    !> (n)
    integer(long), allocatable, intent(in), target :: values(:)

    if (.not. allocated(values)) return
    call put_values(image, path, h5t_std_i64le, h5kind_to_type(long, h5_integer_kind), shape(values, kind=hsize_t), &
      c_loc(values))
  end subroutine put_longs

  !> Put a table of integers.
  subroutine put_integers_2(image, path, values)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: path
    !> (components, n)
    integer, allocatable, intent(in), target :: values(:, :)

    if (.not. allocated(values)) return
    call put_values(image, path, h5t_std_i32le, h5t_native_integer, shape(values, kind=hsize_t), c_loc(values))
  end subroutine put_integers_2

  !> Make a dataset and fill it.
  subroutine put_values(image, path, in_file, in_memory, dimensions, address)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: path
    !> HDF5 types.
    integer(hid_t), intent(in) :: in_file, in_memory
    !> Sizes, the fastest first.
    integer(hsize_t), intent(in) :: dimensions(:)
    !> Of the values in the order of memory; looked at where there are any.
    type(c_ptr), intent(in) :: address
    integer(hid_t) :: dataset
    integer :: status

    call create_dataset(image, path, in_file, dimensions, dataset)
    if (dataset < 0) return
    status = 0
    if (product(dimensions) > 0) call h5dwrite_f(dataset, in_memory, address, status)
    call note_failure(image%reason, status < 0, path)
    call close_dataset(image, path, dataset)
  end subroutine put_values

  !> Close a dataset.
  subroutine close_dataset(image, path, dataset)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: path
    integer(hid_t), intent(in) :: dataset
    integer :: status

    call h5dclose_f(dataset, status)
    call note_failure(image%reason, status < 0, path)
  end subroutine close_dataset

  !> Make a dataset; it is negative when that fails.
  subroutine create_dataset(image, path, kind, dimensions, dataset)
    !> The file.
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: path
    !> HDF5 type in the file.
    integer(hid_t), intent(in) :: kind
    !> Sizes, the fastest first.
    integer(hsize_t), intent(in) :: dimensions(:)
    integer(hid_t), intent(out) :: dataset
    integer(hid_t) :: space
    integer :: status(3)

    dataset = -1
    status = 0
    call h5screate_simple_f(size(dimensions), dimensions, space, status(1))
    if (status(1) >= 0) then
      call h5dcreate_f(image%file, path, kind, space, dataset, status(2), &
        dcpl_id=image%dataset_list)
      call h5sclose_f(space, status(3))
    end if
    call note_failure(image%reason, any(status < 0), path)
    if (status(2) < 0) dataset = -1
    call list_dataset(image, path, kind, dimensions)
  end subroutine create_dataset

  !> Remember what was put.
  pure subroutine list_dataset(image, path, kind, dimensions)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: path
    integer(hid_t), intent(in) :: kind
    integer(hsize_t), intent(in) :: dimensions(:)
    type(dataset_type), allocatable :: more(:)

    if (.not. allocated(image%datasets)) allocate (image%datasets(most_at_first))
    if (image%count == size(image%datasets)) then
      allocate (more(2*image%count))
      more(:image%count) = image%datasets
      call move_alloc(more, image%datasets)
    end if
    image%count = image%count + 1
    image%datasets(image%count) = dataset_type(path, kind, dimensions)
  end subroutine list_dataset

  !> Give an object a real.
  subroutine put_real_attribute(image, object, name, value)
    type(image_type), intent(inout) :: image
    !> Group or dataset, and name of the attribute.
    character(len=*), intent(in) :: object, name
    real(wp), intent(in) :: value
    real(wp), target :: buffer(1)

    buffer = value
    call put_attribute_value(image, object, name, h5t_ieee_f64le, h5t_native_double, c_loc(buffer))
  end subroutine put_real_attribute

  !> Give an object an integer.
  subroutine put_integer_attribute(image, object, name, value)
    type(image_type), intent(inout) :: image
    !> Group or dataset, and name of the attribute.
    character(len=*), intent(in) :: object, name
    integer, intent(in) :: value
    integer, target :: buffer(1)

    buffer = value
    call put_attribute_value(image, object, name, h5t_std_i32le, h5t_native_integer, c_loc(buffer))
  end subroutine put_integer_attribute

  !> Make an attribute of one value and fill it.
  subroutine put_attribute_value(image, object, name, in_file, in_memory, address)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: object, name
    !> HDF5 types.
    integer(hid_t), intent(in) :: in_file, in_memory
    type(c_ptr), intent(in) :: address
    integer(hid_t) :: attribute, space
    integer :: status(5)

    status = 0
    call h5screate_f(h5s_scalar_f, space, status(1))
    call h5acreate_by_name_f(image%file, object, name, in_file, space, attribute, status(2))
    call h5sclose_f(space, status(3))
    if (status(2) >= 0) then
      call h5awrite_f(attribute, in_memory, address, status(4))
      call h5aclose_f(attribute, status(5))
    end if
    call note_failure(image%reason, any(status < 0), object//' '//name)
  end subroutine put_attribute_value

  !> Let a name stand for an object of another file.
  subroutine put_link(image, path, file, object)
    !> The file.
    type(image_type), intent(inout) :: image
    !> Name of the link.
    character(len=*), intent(in) :: path
    !> The other file, relative to this one.
    character(len=*), intent(in) :: file
    !> Object in the other file.
    character(len=*), intent(in) :: object
    integer :: status

    call h5lcreate_external_f(file, object, image%file, path, status)
    call note_failure(image%reason, status < 0, path)
  end subroutine put_link

  !> Write the file and free its memory.
  subroutine save_image(image, path, error, sealed, sum)
    !> The file.
    type(image_type), intent(inout) :: image
    !> Its name on the disk.
    character(len=*), intent(in) :: path
    !> Set when it is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    !> It ends with a line by which damage is known (`qsmpm_seal`), as `qsmpm_hdf5_reader` wants it; no unless given.
    logical, intent(in), optional :: sealed
    !> Checksum of its bytes.
    integer(int32), intent(out), optional :: sum
    integer(int8), allocatable, target :: bytes(:)
    type(file_type) :: file

    call copy_image(image, bytes)
    if (present(sum)) sum = crc32(bytes)
    call discard_image(image)
    if (allocated(image%reason)) then
      call fail(error, error_other, "cannot make '"//path//"': the HDF5 library failed at "// &
        image%reason)
      return
    end if
    call create_file(file, path)
    call put_bytes(file, c_loc(bytes), size(bytes, kind=long))
    if (present(sealed)) then
      if (sealed) call put_text(file, seal_line(bytes))
    end if
    call commit_file(file, error)
  end subroutine save_image

  !> Free the memory of a file.
  subroutine discard_image(image)
    type(image_type), intent(inout) :: image
    integer :: status

    if (image%dataset_list >= 0) call h5pclose_f(image%dataset_list, status)
    if (image%file >= 0) call h5fclose_f(image%file, status)
    image%dataset_list = -1
    image%file = -1
  end subroutine discard_image

  !> The bytes of the file.
  subroutine copy_image(image, bytes)
    !> The file.
    type(image_type), intent(inout) :: image
    !> Its bytes; at least one, so that there is an address.
    integer(int8), allocatable, target, intent(out) :: bytes(:)
    integer(size_t) :: length
    type(c_ptr) :: address
    integer :: status

    length = 0
    address = c_null_ptr
    if (.not. allocated(image%reason)) then
      call h5fflush_f(image%file, h5f_scope_global_f, status)
      call note_failure(image%reason, status < 0, 'the file')
      call h5fget_file_image_f(image%file, address, 0_size_t, status, length)
      call note_failure(image%reason, status < 0 .or. length < 1, 'the file')
    end if
    allocate (bytes(max(1_size_t, length)))
    if (allocated(image%reason)) return
    address = c_loc(bytes)
    call h5fget_file_image_f(image%file, address, length, status)
    call note_failure(image%reason, status < 0, 'the file')
  end subroutine copy_image

  !> Keep the first failure.
  pure subroutine note_failure(reason, failed, object)
    !> First failure so far.
    character(len=:), allocatable, intent(inout) :: reason
    !> Whether there is one.
    logical, intent(in) :: failed
    !> What could not be done.
    character(len=*), intent(in) :: object

    if (failed .and. .not. allocated(reason)) reason = object
  end subroutine note_failure
end module qsmpm_hdf5_image
