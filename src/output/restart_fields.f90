!> What rides on the mesh and what the terms keep, in a restart file (qsmpm_restart).
module qsmpm_restart_fields
  use qsmpm_kinds, only: wp, long
  use qsmpm_hdf5_image, only: image_type, put_group, put_array, put_attribute
  use qsmpm_hdf5_reader, only: reader_type, get_array, get_attribute, note_reason
  use qsmpm_hdf5_rows, only: count_components, count_rows, get_rows
  use qsmpm_kept_arrays, only: clear_nodal, kept_arrays_type
  use qsmpm_grid_window, only: window_type
  use qsmpm_model, only: model_type, state_type
  use qsmpm_state_check, only: window_reason
  use qsmpm_field_list, only: field_list_type
  use qsmpm_point_selection, only: allocate_like
  use qsmpm_points, only: carried_type, points_type, surface_points_type, allocate_surface_points
  use qsmpm_team, only: total
  implicit none
  private

  public :: put_carried, size_set, get_carried, get_some, put_kept, get_kept, get_mesh, kept_count

contains

  !> Put what the terms keep.
  subroutine put_kept(image, group, kept, rows)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    type(kept_arrays_type), intent(in) :: kept
    !> Each process gives nodes of its own.
    logical, intent(in) :: rows
    integer :: i

    call put_group(image, group)
    call put_attribute(image, group, 'count', kept_count(kept))
    do i = 1, kept_count(kept)
      call put_array(image, group//'/'//kept%list(i)%name, kept%list(i)%values, rows .and. kept%list(i)%nodal)
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
  subroutine put_carried(image, group, carried, rows)
    type(image_type), intent(inout) :: image
    !> Name of its group.
    character(len=*), intent(in) :: group
    !> The set.
    class(carried_type), intent(in), target :: carried
    !> Each process gives some of it; else it is known to all.
    logical, intent(in) :: rows
    type(field_list_type) :: list
    real(wp), allocatable :: reals(:, :)
    integer :: i

    call put_group(image, group)
    if (rows) then
      call put_attribute(image, group, 'count', int(total(image%team, int(carried%count, long))))
    else
      call put_attribute(image, group, 'count', carried%count)
    end if
    call carried%list_fields(list)
    do i = 1, list%count
      associate (field => list%fields(i), path => group//'/'//trim(list%fields(i)%name))
        if (associated(field%labels)) then
          call put_array(image, path, field%labels, rows)
        else if (associated(field%numbers)) then
          call put_array(image, path, field%numbers, rows)
        else
          call field%get_values(field%component_count(), reals)
          call put_array(image, path, reals, rows)
        end if
      end associate
    end do
  end subroutine put_carried

  !> Room for as many points as the file has in a set, or for some of them; where none are left they have carried what
  !> others do, or there have been none.
  subroutine size_set(reader, group, like, carried, some)
    type(reader_type), intent(inout) :: reader
    !> The group of the set in the file.
    character(len=*), intent(in) :: group
    type(points_type), intent(in) :: like
    !> Material points or surface points.
    class(carried_type), intent(inout) :: carried
    integer, intent(in), optional :: some
    integer :: count, states

    count = count_rows(reader, group//'/cell')
    if (present(some)) count = some
    select type (carried)
    type is (points_type)
      states = count_components(reader, group//'/state')
      if (count == carried%count .and. states == size(carried%state, 1)) return
      call allocate_like(like, count, carried)
    type is (surface_points_type)
      call allocate_surface_points(carried, size(like%position, 1), count)
    end select
  end subroutine size_set

  !> Get all fields of a carried set; their sizes are those of the model.
  subroutine get_carried(reader, group, carried)
    type(reader_type), intent(inout) :: reader
    !> Name of its group.
    character(len=*), intent(in) :: group
    !> The set.
    class(carried_type), intent(inout), target :: carried
    integer :: i

    call get_some(reader, group, [(i, i=1, size(carried%cell))], size(carried%cell), carried)
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
        ! What is not carried.
        if (field%point_count() == 0) cycle
        if (associated(field%labels)) then
          call get_rows(reader, path, rows, all_rows, field%labels)
        else if (associated(field%numbers)) then
          call get_rows(reader, path, rows, all_rows, field%numbers)
        else if (associated(field%reals)) then
          call get_rows(reader, path, rows, all_rows, field%reals)
        end if
      end associate
    end do
  end subroutine get_some
end module qsmpm_restart_fields
