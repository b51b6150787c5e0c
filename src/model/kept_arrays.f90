!> Named arrays that are stored from step to step: data of terms of the equations, such as multipliers or a history.
!> They are part of the state, so that checkpoint and restart file contain them without knowledge of their owner.
module qsmpm_kept_arrays
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: kept_array_type, kept_arrays_type, lay_array, is_kept, kept_values, keep_values, renumber_nodal, clear_nodal

  type :: kept_array_type
    !> Unique name without a slash, used in the restart file.
    character(len=:), allocatable :: name
    real(wp), allocatable :: values(:, :)
    !> Whether the columns are the nodes of the space; they are then reordered when the nodes are renumbered.
    logical :: nodal = .false.
  end type kept_array_type

  type :: kept_arrays_type
    type(kept_array_type), allocatable :: list(:)
  end type kept_arrays_type

contains

  !> Adds an array with its initial values; an existing array is unchanged.
  subroutine lay_array(kept, name, values, nodal)
    type(kept_arrays_type), intent(inout) :: kept
    character(len=*), intent(in) :: name
    real(wp), intent(in) :: values(:, :)
    !> Whether there is a column for each node of the space.
    logical, intent(in), optional :: nodal
    type(kept_array_type) :: array

    if (place_of(kept, name) > 0) return
    if (.not. allocated(kept%list)) allocate (kept%list(0))
    array%name = name
    array%values = values
    if (present(nodal)) array%nodal = nodal
    kept%list = [kept%list, array]
  end subroutine lay_array

  !> Returns whether an array exists.
  pure logical function is_kept(kept, name)
    type(kept_arrays_type), intent(in) :: kept
    character(len=*), intent(in) :: name

    is_kept = place_of(kept, name) > 0
  end function is_kept

  !> Returns the values of an existing array.
  pure function kept_values(kept, name) result(values)
    type(kept_arrays_type), intent(in) :: kept
    character(len=*), intent(in) :: name
    real(wp), allocatable :: values(:, :)

    values = kept%list(place_of(kept, name))%values
  end function kept_values

  !> Replaces the values of an existing array.
  pure subroutine keep_values(kept, name, values)
    type(kept_arrays_type), intent(inout) :: kept
    character(len=*), intent(in) :: name
    real(wp), intent(in) :: values(:, :)

    kept%list(place_of(kept, name))%values = values
  end subroutine keep_values

  !> Renumbers the nodal arrays: values are retained at the same nodes and are zero at new nodes.
  pure subroutine renumber_nodal(kept, source)
    type(kept_arrays_type), intent(inout) :: kept
    !> Previous number of each node, 0 for none (nodes).
    integer, intent(in) :: source(:)
    real(wp), allocatable :: values(:, :)
    integer :: i, a

    if (.not. allocated(kept%list)) return
    do i = 1, size(kept%list)
      if (.not. kept%list(i)%nodal) cycle
      allocate (values(size(kept%list(i)%values, 1), size(source)), source=0.0_wp)
      do a = 1, size(source)
        if (source(a) > 0) values(:, a) = kept%list(i)%values(:, source(a))
      end do
      call move_alloc(values, kept%list(i)%values)
    end do
  end subroutine renumber_nodal

  !> Sets the nodal arrays to zero for a number of nodes.
  pure subroutine clear_nodal(kept, nodes)
    type(kept_arrays_type), intent(inout) :: kept
    integer, intent(in) :: nodes

    call renumber_nodal(kept, spread(0, 1, nodes))
  end subroutine clear_nodal

  !> Returns the position in the list, 0 if there is none.
  pure integer function place_of(kept, name) result(place)
    type(kept_arrays_type), intent(in) :: kept
    character(len=*), intent(in) :: name

    if (allocated(kept%list)) then
      do place = 1, size(kept%list)
        if (kept%list(place)%name == name) return
      end do
    end if
    place = 0
  end function place_of
end module qsmpm_kept_arrays
