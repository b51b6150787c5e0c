!> Datasets whose rows stand in other HDF5 files, behind one another (virtual datasets of HDF5 1.10): who reads one sees
!> a single table, and needs the files beside this one. Where a file is missing the library fills in what no run writes:
!> NaN, or the most negative whole number.
module qsmpm_hdf5_joined
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use, intrinsic :: iso_c_binding, only: c_loc
  use hdf5, only: hid_t, hsize_t, h5pcopy_f, h5pclose_f, h5pset_fill_value_f, h5pset_virtual_f, h5screate_simple_f, &
    h5sclose_f, h5sselect_hyperslab_f, h5s_select_set_f, h5tequal_f, h5t_ieee_f64le, h5t_std_i32le, h5t_native_double, &
    h5t_native_integer, h5kind_to_type, h5_integer_kind
  use qsmpm_kinds, only: wp, long
  use qsmpm_hdf5_image, only: image_type, dataset_type, create_dataset, close_dataset, note_failure
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: put_joined

contains

  !> Put a dataset of the rows of others.
  subroutine put_joined(image, like, files, rows)
    type(image_type), intent(inout) :: image
    !> Name, type and components of each of them.
    type(dataset_type), intent(in) :: like
    !> Where they stand, relative to this file, and how many rows each has.
    type(string_type), intent(in) :: files(:)
    integer(long), intent(in) :: rows(:)
    integer(hsize_t) :: whole(size(like%dimensions))
    integer(hid_t) :: usual, dataset
    integer :: status(2)

    usual = image%dataset_list
    status = 0
    whole = like%dimensions
    whole(size(whole)) = sum(rows)
    if (whole(size(whole)) > 0) then
      call h5pcopy_f(usual, image%dataset_list, status(1))
      call set_fill(image, like)
      call map_rows(image, like, files, rows, whole)
    end if
    call create_dataset(image, like%path, like%kind, whole, dataset)
    if (dataset >= 0) call close_dataset(image, like%path, dataset)
    if (image%dataset_list /= usual) call h5pclose_f(image%dataset_list, status(2))
    image%dataset_list = usual
    call note_failure(image%reason, any(status < 0), like%path)
  end subroutine put_joined

  !> What stands for rows of a file that is missing.
  subroutine set_fill(image, like)
    type(image_type), intent(inout) :: image
    type(dataset_type), intent(in) :: like
    real(wp), target :: no_real
    integer, target :: no_integer
    integer(long), target :: no_long
    logical :: holds(2)
    integer :: status(3)

    no_real = ieee_value(no_real, ieee_quiet_nan)
    no_integer = -huge(no_integer)
    no_long = -huge(no_long)
    call h5tequal_f(like%kind, h5t_ieee_f64le, holds(1), status(1))
    call h5tequal_f(like%kind, h5t_std_i32le, holds(2), status(2))
    if (holds(1)) then
      call h5pset_fill_value_f(image%dataset_list, h5t_native_double, c_loc(no_real), status(3))
    else if (holds(2)) then
      call h5pset_fill_value_f(image%dataset_list, h5t_native_integer, c_loc(no_integer), status(3))
    else
      call h5pset_fill_value_f(image%dataset_list, h5kind_to_type(long, h5_integer_kind), c_loc(no_long), status(3))
    end if
    call note_failure(image%reason, any(status < 0), like%path)
  end subroutine set_fill

  !> Say where the rows stand.
  subroutine map_rows(image, like, files, rows, whole)
    type(image_type), intent(inout) :: image
    type(dataset_type), intent(in) :: like
    type(string_type), intent(in) :: files(:)
    integer(long), intent(in) :: rows(:)
    !> Sizes of the whole.
    integer(hsize_t), intent(in) :: whole(:)
    integer(hsize_t) :: first(size(whole)), extent(size(whole))
    integer(hid_t) :: place, source
    integer :: status(6), i

    first = 0
    extent = whole
    status = 0
    do i = 1, size(files)
      if (rows(i) == 0) cycle
      extent(size(extent)) = rows(i)
      call h5screate_simple_f(size(whole), whole, place, status(1))
      call h5screate_simple_f(size(extent), extent, source, status(2))
      call h5sselect_hyperslab_f(place, h5s_select_set_f, first, extent, status(3))
      call h5pset_virtual_f(image%dataset_list, place, files(i)%text, like%path, source, status(4))
      call h5sclose_f(place, status(5))
      call h5sclose_f(source, status(6))
      call note_failure(image%reason, any(status < 0), like%path)
      first(size(first)) = first(size(first)) + rows(i)
    end do
  end subroutine map_rows
end module qsmpm_hdf5_joined
