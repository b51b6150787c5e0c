!> What rides on the mesh and what the terms keep, in a restart file (qsmpm_restart).
module qsmpm_restart_fields
  use qsmpm_kinds, only: wp, long
  use qsmpm_hdf5_image, only: image_type, put_group, put_array, put_attribute
  use qsmpm_hdf5_reader, only: reader_type, get_array, get_attribute, note_reason
  use qsmpm_hdf5_rows, only: get_rows
  use qsmpm_kept_arrays, only: clear_nodal, kept_arrays_type
  use qsmpm_grid_window, only: window_type
  use qsmpm_model, only: model_type, state_type
  use qsmpm_state_check, only: window_reason
  use qsmpm_field_list, only: field_type, field_list_type
  use qsmpm_points, only: carried_type
  implicit none
  private

  public :: put_carried, get_carried, get_some, put_kept, get_kept, get_mesh, kept_count

contains

  !> Put what the terms keep.
  subroutine put_kept(image, group, kept, nodal)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    type(kept_arrays_type), intent(in) :: kept
    !> Put those too that have a column for each node; yes unless given.
    logical, intent(in), optional :: nodal
    logical :: all_put
    integer :: i

    all_put = .true.
    if (present(nodal)) all_put = nodal
    call put_group(image, group)
    call put_attribute(image, group, 'count', kept_count(kept))
    do i = 1, kept_count(kept)
      if (kept%list(i)%nodal .and. .not. all_put) cycle
      call put_array(image, group//'/'//kept%list(i)%name, kept%list(i)%values)
    end do
  end subroutine put_kept

  !> Number of arrays that terms keep.
  pure integer function kept_count(kept)
    type(kept_arrays_type), intent(in) :: kept

    kept_count = 0
    if (allocated(kept%list)) kept_count = size(kept%list)
  end function kept_count

  !> Get what the terms keep: those of the file must be those of the analysis.
  subroutine get_kept(reader, group, kept, nodal)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    type(kept_arrays_type), intent(inout) :: kept
    !> Those too that have a column for each node.
    logical, intent(in) :: nodal
    integer :: i, found

    found = 0
    call get_attribute(reader, group, 'count', found)
    if (found /= kept_count(kept)) call note_reason(reader, 'it was written with other terms of the equations')
    do i = 1, kept_count(kept)
      if (kept%list(i)%nodal .and. .not. nodal) cycle
      call get_array(reader, group//'/'//kept%list(i)%name, kept%list(i)%values)
    end do
  end subroutine get_kept

  !> Get the part of the grid, where its nodes are, and the forces at them.
  subroutine get_mesh(reader, group, model, state)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    type(model_type), intent(in) :: model
    type(state_type), intent(inout) :: state
    integer, allocatable :: window(:)

    allocate (window(6), source=0)
    call get_array(reader, group//'/mesh/window', window)
    call note_reason(reader, window_reason(window, model))
    if (any(window /= [state%window%first, state%window%last])) then
      ! Another part of the grid: as many nodes as it has.
      state%window = window_type(window(:3), window(4:))
      deallocate (state%coordinates, state%reactions, state%released)
    end if
    call get_array(reader, group//'/mesh/coordinates', state%coordinates)
    call get_array(reader, group//'/mesh/reactions', state%reactions)
    call get_array(reader, group//'/mesh/released', state%released)
    if (allocated(state%reactions)) call clear_nodal(state%kept, size(state%reactions, 2))
  end subroutine get_mesh

  !> Put all fields of a carried set.
  subroutine put_carried(image, group, carried)
    !> The file.
    type(image_type), intent(inout) :: image
    !> Name of its group.
    character(len=*), intent(in) :: group
    !> The set.
    class(carried_type), intent(in), target :: carried
    type(field_list_type) :: list
    real(wp), allocatable :: reals(:, :)
    integer, allocatable :: labels(:)
    integer(long), allocatable :: numbers(:)
    integer :: i

    call put_group(image, group)
    call put_attribute(image, group, 'count', carried%count)
    call carried%list_fields(list)
    do i = 1, list%count
      associate (field => list%fields(i))
        if (associated(field%labels)) then
          allocate (labels, source=field%labels)
          call put_array(image, group//'/'//trim(field%name), labels)
          deallocate (labels)
        else if (associated(field%numbers)) then
          allocate (numbers, source=field%numbers)
          call put_array(image, group//'/'//trim(field%name), numbers)
          deallocate (numbers)
        else
          call field%get_values(field%component_count(), reals)
          call put_array(image, group//'/'//trim(field%name), reals)
        end if
      end associate
    end do
  end subroutine put_carried

  !> Get all fields of a carried set; their sizes are those of the model.
  subroutine get_carried(reader, group, carried)
    !> The file.
    type(reader_type), intent(inout) :: reader
    !> Name of its group.
    character(len=*), intent(in) :: group
    !> The set.
    class(carried_type), intent(inout), target :: carried
    type(field_list_type) :: list
    integer :: i

    call get_attribute(reader, group, 'count', carried%count)
    call carried%list_fields(list)
    do i = 1, list%count
      if (.not. allocated(reader%reason)) call get_field(reader, group//'/'//trim(list%fields(i)%name), list%fields(i))
    end do
  end subroutine get_carried

  !> Get some of a carried set with all their fields.
  subroutine get_some(reader, group, rows, all_rows, carried)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    !> Their places in the file, rising, and how many the set has.
    integer, intent(in) :: rows(:), all_rows
    !> As many, carrying what those of the model do.
    class(carried_type), intent(inout), target :: carried
    type(field_list_type) :: list
    integer :: i, found

    found = all_rows
    call get_attribute(reader, group, 'count', found)
    if (found /= all_rows) call note_reason(reader, group//' has another size than it says')
    call carried%list_fields(list)
    do i = 1, list%count
      associate (field => list%fields(i), path => group//'/'//trim(list%fields(i)%name))
        if (allocated(reader%reason) .or. size(rows) == 0) exit
        if (field%point_count() == 0) then
          call get_field(reader, path, field)
        else if (associated(field%labels)) then
          call get_rows(reader, path, rows, all_rows, field%labels)
        else if (associated(field%numbers)) then
          call get_rows(reader, path, rows, all_rows, field%numbers)
        else if (associated(field%reals)) then
          call get_rows(reader, path, rows, all_rows, field%reals)
        end if
      end associate
    end do
  end subroutine get_some

  !> Get the values of a field.
  subroutine get_field(reader, path, field)
    type(reader_type), intent(inout) :: reader
    !> Name of the dataset.
    character(len=*), intent(in) :: path
    type(field_type), intent(inout) :: field
    real(wp), allocatable :: reals(:, :)
    integer, allocatable :: labels(:)
    integer(long), allocatable :: numbers(:)

    if (associated(field%labels)) then
      allocate (labels, source=field%labels)
      call get_array(reader, path, labels)
      if (.not. allocated(reader%reason)) field%labels = labels
    else if (associated(field%numbers)) then
      allocate (numbers, source=field%numbers)
      call get_array(reader, path, numbers)
      if (.not. allocated(reader%reason)) field%numbers = numbers
    else if (associated(field%reals)) then
      allocate (reals, source=field%reals)
      call get_array(reader, path, reals)
      if (.not. allocated(reader%reason)) field%reals = reals
    end if
  end subroutine get_field
end module qsmpm_restart_fields
