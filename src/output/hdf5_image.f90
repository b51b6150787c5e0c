!> HDF5 files whose datasets are stored contiguously in one file, written by one process or by a team. The library
!> creates the metadata in memory; the values are written after it by `qsmpm_shared_file`. The address of each dataset
!> is entered in its data layout message (HDF5 File Format Specification 3.0, IV.A.2.i) and the end of the file in the
!> superblock (II.A).
!>
!> The library never writes to the disk itself, so that a full disk is handled by `qsmpm_file`, which leaves no
!> incomplete file, and not by the caches of the library: parallel HDF5 1.10 does not return from such an error on
!> several processes. Objects have no time stamps: the same state gives identical bytes. A failure is stored and
!> reported by `save_image`. Files are read by `qsmpm_hdf5_reader`; no other module uses the library.
module qsmpm_hdf5_image
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc, c_null_ptr, c_ptr
  use, intrinsic :: iso_fortran_env, only: int8
  use hdf5, only: hid_t, hsize_t, size_t, h5pcreate_f, h5pclose_f, h5pset_fapl_core_f, h5pset_obj_track_times_f, &
    h5fcreate_f, h5fclose_f, h5fflush_f, h5fget_file_image_f, h5gcreate_f, h5gclose_f, h5screate_f, &
    h5screate_simple_f, h5sclose_f, h5s_scalar_f, h5dcreate_f, h5dclose_f, h5acreate_by_name_f, h5awrite_f, &
    h5aclose_f, h5lcreate_external_f, h5oget_info_by_name_f, h5o_info_t, h5p_file_access_f, h5p_dataset_create_f, &
    h5f_acc_trunc_f, h5f_scope_global_f, h5t_native_double, h5t_native_integer, h5kind_to_type, h5_integer_kind
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: agree
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_hdf5_reader, only: open_library
  use qsmpm_shared_file, only: shared_file_type, begin_shared, claim, put_at, commit_shared
  use qsmpm_team, only: team_type, largest, smallest, total
  implicit none
  private

  public :: image_type, create_image, put_group, put_array, put_attribute, put_link, save_image

  !> Increment of the memory of an image [bytes].
  integer(size_t), parameter :: growth = 65536_size_t
  !> Initial capacity for datasets.
  integer, parameter :: most_at_first = 64

  !> A dataset: its HDF5 type, bytes per row, sizes with the fastest index first, and the values of this process.
  type :: dataset_type
    character(len=:), allocatable :: path
    integer(hid_t) :: kind = -1
    integer(hsize_t), allocatable :: dimensions(:)
    integer(int8), allocatable :: bytes(:)
  end type dataset_type

  !> A file under construction.
  type :: image_type
    !> Processes that write it: groups, attributes and datasets are the same on all.
    type(team_type) :: team
    integer(hid_t) :: file = -1
    !> Datasets so far (count), and spare entries.
    integer :: count = 0
    type(dataset_type), allocatable :: datasets(:)
    !> Name of the first object that could not be created.
    character(len=:), allocatable :: reason
  end type image_type

  !> Adds an array. If `rows` is true each process passes rows of its own, which are stored in the order of the ranks;
  !> otherwise the array of the first process is stored.
  interface put_array
    module procedure :: put_reals_1, put_reals_2, put_integers_1, put_longs
  end interface put_array

  interface put_attribute
    module procedure :: put_real_attribute, put_integer_attribute
  end interface put_attribute

contains

  !> Starts a file.
  subroutine create_image(image, team)
    type(image_type), intent(out) :: image
    !> Processes that write it; by default this process alone.
    type(team_type), intent(in), optional :: team
    integer(hid_t) :: access
    integer :: status(4)

    status = 0
    if (present(team)) image%team = team
    allocate (image%datasets(most_at_first))
    call open_library()
    call h5pcreate_f(h5p_file_access_f, access, status(1))
    call h5pset_fapl_core_f(access, growth, .false., status(2))
    call h5fcreate_f('qsmpm.image', h5f_acc_trunc_f, image%file, status(3), access_prp=access)
    call h5pclose_f(access, status(4))
    call note_failure(image%reason, any(status < 0), 'the file')
  end subroutine create_image

  !> Creates a group; its parents must exist.
  subroutine put_group(image, path)
    type(image_type), intent(inout) :: image
    !> Path of the group.
    character(len=*), intent(in) :: path
    integer(hid_t) :: group
    integer :: status

    call h5gcreate_f(image%file, path, group, status)
    call note_failure(image%reason, status < 0, path)
    if (status >= 0) call h5gclose_f(group, status)
  end subroutine put_group

  !> Adds a real array.
  subroutine put_reals_1(image, path, values, rows)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: path
    !> (n)
    real(wp), contiguous, target, intent(in) :: values(:)
    logical, intent(in), optional :: rows

    call put_values(image, path, h5t_native_double, 8, shape(values, kind=hsize_t), c_loc(values), rows)
  end subroutine put_reals_1

  !> Adds a real table, (components, n) in Fortran and (n, components) in C order.
  subroutine put_reals_2(image, path, values, rows)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: path
    !> (components, n)
    real(wp), contiguous, target, intent(in) :: values(:, :)
    logical, intent(in), optional :: rows

    call put_values(image, path, h5t_native_double, 8, shape(values, kind=hsize_t), c_loc(values), rows)
  end subroutine put_reals_2

  !> Adds an integer array.
  subroutine put_integers_1(image, path, values, rows)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: path
    !> (n)
    integer, contiguous, target, intent(in) :: values(:)
    logical, intent(in), optional :: rows

    call put_values(image, path, h5t_native_integer, 4, shape(values, kind=hsize_t), c_loc(values), rows)
  end subroutine put_integers_1

  !> Adds a long integer array.
  subroutine put_longs(image, path, values, rows)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: path
    !> (n)
    integer(long), contiguous, target, intent(in) :: values(:)
    logical, intent(in), optional :: rows

    call put_values(image, path, h5kind_to_type(long, h5_integer_kind), 8, shape(values, kind=hsize_t), c_loc(values), &
      rows)
  end subroutine put_longs

  !> Stores the values of a dataset until the file is written.
  subroutine put_values(image, path, kind, width, dimensions, address, rows)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: path
    !> HDF5 type; bytes per value.
    integer(hid_t), intent(in) :: kind
    integer, intent(in) :: width
    !> Sizes, fastest index first.
    integer(hsize_t), intent(in) :: dimensions(:)
    !> Address of the values, if there are any.
    type(c_ptr), intent(in) :: address
    logical, intent(in), optional :: rows
    type(dataset_type), allocatable :: more(:)
    integer(int8), pointer, contiguous :: bytes(:)
    logical :: gives

    gives = image%team%rank == 0
    if (present(rows)) gives = gives .or. rows
    if (image%count == size(image%datasets)) then
      allocate (more(2*image%count))
      more(:image%count) = image%datasets
      call move_alloc(more, image%datasets)
    end if
    image%count = image%count + 1
    associate (dataset => image%datasets(image%count), last => size(dimensions))
      dataset%path = path
      dataset%kind = kind
      dataset%dimensions = dimensions
      if (.not. gives) dataset%dimensions(last) = 0
      allocate (dataset%bytes(width*product(dataset%dimensions)))
      if (size(dataset%bytes, kind=long) == 0) return
      call c_f_pointer(address, bytes, [size(dataset%bytes, kind=long)])
      dataset%bytes(:) = bytes
    end associate
  end subroutine put_values

  !> Adds a real attribute to an object.
  subroutine put_real_attribute(image, object, name, value)
    type(image_type), intent(inout) :: image
    !> Path of the group; name of the attribute.
    character(len=*), intent(in) :: object, name
    real(wp), intent(in) :: value
    real(wp), target :: buffer(1)

    buffer = value
    call put_attribute_value(image, object, name, h5t_native_double, c_loc(buffer))
  end subroutine put_real_attribute

  !> Adds an integer attribute to an object.
  subroutine put_integer_attribute(image, object, name, value)
    type(image_type), intent(inout) :: image
    !> Path of the group; name of the attribute.
    character(len=*), intent(in) :: object, name
    integer, intent(in) :: value
    integer, target :: buffer(1)

    buffer = value
    call put_attribute_value(image, object, name, h5t_native_integer, c_loc(buffer))
  end subroutine put_integer_attribute

  !> Creates an attribute of one value.
  subroutine put_attribute_value(image, object, name, kind, address)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: object, name
    !> HDF5 type.
    integer(hid_t), intent(in) :: kind
    type(c_ptr), intent(in) :: address
    integer(hid_t) :: attribute, space
    integer :: status(5)

    status = 0
    call h5screate_f(h5s_scalar_f, space, status(1))
    call h5acreate_by_name_f(image%file, object, name, kind, space, attribute, status(2))
    call h5sclose_f(space, status(3))
    if (status(2) >= 0) then
      call h5awrite_f(attribute, kind, address, status(4))
      call h5aclose_f(attribute, status(5))
    end if
    call note_failure(image%reason, any(status < 0), object//' '//name)
  end subroutine put_attribute_value

  !> Adds an external link to an object of another file.
  subroutine put_link(image, path, file, object)
    type(image_type), intent(inout) :: image
    !> Name of the link; the other file, relative to this one; object in the other file.
    character(len=*), intent(in) :: path, file, object
    integer :: status

    call h5lcreate_external_f(file, object, image%file, path, status)
    call note_failure(image%reason, status < 0, path)
  end subroutine put_link

  !> Writes the file and frees its memory.
  subroutine save_image(image, path, sealed, error)
    type(image_type), intent(inout) :: image
    !> Name of the file.
    character(len=*), intent(in) :: path
    !> Whether it ends with a checksum line that reveals damage (`qsmpm_checksum`).
    logical, intent(in) :: sealed
    !> Set consistently on all processes when the file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error
    integer(int8), allocatable :: head(:)
    type(shared_file_type) :: file
    integer(long) :: places(0:image%count)
    integer :: i

    call describe(image, head)
    if (allocated(image%reason)) call fail(error, error_other, "cannot make '"//path// &
      "': the HDF5 library failed at "//image%reason)
    call agree(image%team, error)
    if (allocated(error)) return
    call begin_shared(file, image%team, path, sealed)
    head = head(:merge(size(head), 0, image%team%rank == 0))
    call claim(file, [size(head, kind=long), (size(image%datasets(i)%bytes, kind=long), i=1, image%count)], places)
    call put_at(file, places(0), head)
    do i = 1, image%count
      call put_at(file, places(i), image%datasets(i)%bytes)
      deallocate (image%datasets(i)%bytes)
    end do
    call commit_shared(file, error)
  end subroutine save_image

  !> Creates the metadata of the file and closes it in the library.
  subroutine describe(image, head)
    type(image_type), intent(inout) :: image
    !> Metadata, stored before the values.
    integer(int8), allocatable, intent(out) :: head(:)
    integer(hid_t) :: list
    integer(long) :: headers(image%count), lengths(image%count)
    integer :: status(3), i

    status = 0
    if (largest(image%team, real(image%count, wp)) > smallest(image%team, real(image%count, wp))) then
      call note_failure(image%reason, .true., 'datasets that not all processes have')
    else
      lengths = total(image%team, [(size(image%datasets(i)%bytes, kind=long), i=1, image%count)])
      call h5pcreate_f(h5p_dataset_create_f, list, status(1))
      call h5pset_obj_track_times_f(list, .false., status(2))
      call make_datasets(image, list, headers)
      call h5pclose_f(list, status(3))
      call note_failure(image%reason, any(status < 0), 'the file')
      call copy_image(image, head)
      if (.not. allocated(image%reason)) call enter_places(image, headers, lengths, head)
    end if
    if (image%file >= 0) call h5fclose_f(image%file, status(1))
    image%file = -1
  end subroutine describe

  !> Creates the datasets without values and returns the addresses of their headers.
  subroutine make_datasets(image, list, headers)
    type(image_type), intent(inout) :: image
    !> Creation property list.
    integer(hid_t), intent(in) :: list
    !> (datasets)
    integer(long), intent(out) :: headers(:)
    type(h5o_info_t) :: info
    integer(hid_t) :: dataset, space
    integer(hsize_t), allocatable :: whole(:)
    integer(long) :: rows(image%count)
    integer :: status(5), i

    rows = total(image%team, &
      [(image%datasets(i)%dimensions(size(image%datasets(i)%dimensions)), i=1, image%count)])
    do i = 1, image%count
      associate (path => image%datasets(i)%path, dimensions => image%datasets(i)%dimensions)
        status = 0
        whole = dimensions
        whole(size(whole)) = rows(i)
        call h5screate_simple_f(size(whole), whole, space, status(1))
        call h5dcreate_f(image%file, path, image%datasets(i)%kind, space, dataset, status(2), dcpl_id=list)
        call h5sclose_f(space, status(3))
        if (status(2) >= 0) call h5dclose_f(dataset, status(4))
        if (status(2) >= 0) call h5oget_info_by_name_f(image%file, path, info, status(5))
        call note_failure(image%reason, any(status < 0), path)
        headers(i) = int(info%addr, long)
      end associate
    end do
  end subroutine make_datasets

  !> Copies the file image created by the library.
  subroutine copy_image(image, bytes)
    type(image_type), intent(inout) :: image
    !> Bytes of the image; at least one, so that there is an address.
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

  !> Enters the addresses of the dataset values, which follow the metadata in sequence, and the end of the file.
  subroutine enter_places(image, headers, lengths, head)
    type(image_type), intent(inout) :: image
    !> Addresses of the dataset headers; bytes of the values (datasets).
    integer(long), intent(in) :: headers(:), lengths(:)
    integer(int8), intent(inout) :: head(:)
    !> Position of the end-of-file address in the superblock.
    integer, parameter :: end_of_file = 40
    !> Bytes before address and length in a data layout message: version 3, contiguous. An undefined address has all
    !> bits set.
    integer(int8), parameter :: layout(2) = [3_int8, 1_int8], nowhere(8) = -1_int8
    integer(long) :: place, at
    integer :: i

    place = size(head)
    do i = 1, size(headers)
      if (lengths(i) == 0) cycle
      at = headers(i) + 1
      do while (at + 17 < size(head))
        if (all(head(at:at + 17) == [layout, nowhere, little_endian(lengths(i))])) exit
        at = at + 1
      end do
      call note_failure(image%reason, at + 17 >= size(head), image%datasets(i)%path)
      if (allocated(image%reason)) return
      head(at + 2:at + 9) = little_endian(place)
      place = place + lengths(i)
    end do
    head(end_of_file + 1:end_of_file + 8) = little_endian(place)
  end subroutine enter_places

  !> Returns the bytes of a number in little-endian order.
  pure function little_endian(number) result(bytes)
    integer(long), intent(in) :: number
    integer(int8) :: bytes(8)
    integer :: i, byte

    do i = 1, 8
      byte = int(ibits(number, 8*(i - 1), 8))
      bytes(i) = int(merge(byte - 256, byte, byte > 127), int8)
    end do
  end function little_endian

  !> Stores the first failure.
  pure subroutine note_failure(reason, failed, object)
    !> First failure so far.
    character(len=:), allocatable, intent(inout) :: reason
    !> Whether there is a failure.
    logical, intent(in) :: failed
    !> Name of the object concerned.
    character(len=*), intent(in) :: object

    if (failed .and. .not. allocated(reason)) reason = object
  end subroutine note_failure
end module qsmpm_hdf5_image
