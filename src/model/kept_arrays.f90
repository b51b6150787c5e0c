!> Arrays that stay from step to step, by name: what terms of the equations keep (multipliers, a history). They are
!> part of the state, so that checkpoint and restart file bring them back without knowing whose they are.
module qsmpm_kept_arrays
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: kept_array_type, kept_arrays_type, lay_array, kept_values, keep_values

  type :: kept_array_type
    !> Unique, without a slash: a name in the restart file.
    character(len=:), allocatable :: name
    real(wp), allocatable :: values(:, :)
  end type kept_array_type

  type :: kept_arrays_type
    type(kept_array_type), allocatable :: list(:)
  end type kept_arrays_type

contains

  !> Add an array with its first values; one that is there already stays.
  subroutine lay_array(kept, name, values)
    type(kept_arrays_type), intent(inout) :: kept
    character(len=*), intent(in) :: name
    real(wp), intent(in) :: values(:, :)
    type(kept_array_type), allocatable :: more(:)
    integer :: i

    if (place_of(kept, name) > 0) return
    if (.not. allocated(kept%list)) allocate (kept%list(0))
    allocate (more(size(kept%list) + 1))
    do i = 1, size(kept%list)
      more(i) = kept%list(i)
    end do
    more(size(more))%name = name
    more(size(more))%values = values
    call move_alloc(more, kept%list)
  end subroutine lay_array

  !> The values of an array that is there.
  pure function kept_values(kept, name) result(values)
    type(kept_arrays_type), intent(in) :: kept
    character(len=*), intent(in) :: name
    real(wp), allocatable :: values(:, :)

    values = kept%list(place_of(kept, name))%values
  end function kept_values

  !> Give an array that is there new values.
  pure subroutine keep_values(kept, name, values)
    type(kept_arrays_type), intent(inout) :: kept
    character(len=*), intent(in) :: name
    real(wp), intent(in) :: values(:, :)

    kept%list(place_of(kept, name))%values = values
  end subroutine keep_values

  !> Place in the list, 0 where there is none.
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
