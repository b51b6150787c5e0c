!> Whether the state that a step begins from can be computed with: a restart file, an embedding program or a
!> law's start may have brought in what is not a number. What a step computes itself is looked at where it is born.
module qsmpm_usable_state
  use qsmpm_agreement, only: agree
  use qsmpm_error, only: error_type, fail, error_other
  use qsmpm_finite, only: all_usable, is_usable, unusable
  use qsmpm_kinds, only: wp, long
  use qsmpm_model, only: model_type, progress_type
  use qsmpm_field_list, only: field_list_type
  use qsmpm_points, only: carried_type
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: check_state

contains

  !> Refuse a state with a number that cannot be computed with, on all processes alike; the first one is named.
  subroutine check_state(model, error)
    type(model_type), intent(in) :: model
    !> error_other
    type(error_type), allocatable, intent(out) :: error
    integer :: i

    call check_carried(model%state%points, 'material point', error)
    call check_carried(model%state%surface, 'surface point', error)
    call check_carried(model%state%tracers, 'tracer', error)
    call check_carried(model%state%watched, 'watched place', error)
    call check_carried(model%state%inactive%points, 'material point that is not there', error)
    call check_carried(model%state%inactive%unloading, 'material point that is taken out', error)
    call check_carried(model%state%inactive%surface, 'surface point that is not there', error)
    call check_carried(model%state%inactive%unloading_surface, 'surface point that is taken out', error)
    call check_carried(model%state%inactive%feet, 'place under a body that comes', error)
    call check(model%state%coordinates, 'position', 'node', error)
    call check(model%state%reactions, 'reaction', 'node', error)
    call check(model%state%released, 'released force', 'node', error)
    if (allocated(model%state%kept%list)) then
      do i = 1, size(model%state%kept%list)
        associate (kept => model%state%kept%list(i))
          call check(kept%values, 'value', kept%name//', column', error)
        end associate
      end do
    end if
    call check_progress(model%state%plate, model%state%progress, error)
    call agree(model%part%team, error)
  end subroutine check_state

  !> All fields of what rides on the mesh.
  subroutine check_carried(carried, noun, error)
    class(carried_type), intent(in), target :: carried
    character(len=*), intent(in) :: noun
    type(error_type), allocatable, intent(inout) :: error
    type(field_list_type) :: list
    integer :: i

    if (allocated(error)) return
    call carried%list_fields(list)
    do i = 1, list%count
      associate (field => list%fields(i))
        if (associated(field%reals)) call check(field%reals, field%spoken(), noun, error, carried%number)
      end associate
    end do
  end subroutine check_carried

  !> Where the analysis stands, and the plate of a moving mesh.
  subroutine check_progress(plate, progress, error)
    real(wp), intent(in) :: plate
    type(progress_type), intent(in) :: progress
    type(error_type), allocatable, intent(inout) :: error

    if (allocated(error)) return
    if (.not. is_usable(plate)) call fail(error, error_other, 'the plate of the moving mesh has a position'//unusable)
    if (.not. (is_usable(progress%fraction) .and. is_usable(progress%next_step) .and. is_usable(progress%damping))) &
      call fail(error, error_other, 'the step has a load fraction, a length or a damping'//unusable)
    if (.not. (is_usable(progress%external_work) .and. is_usable(progress%internal_work))) &
      call fail(error, error_other, 'the steps so far have a work'//unusable)
  end subroutine check_progress

  !> Numbers of points (numbers, points); nothing is done where there is an error already.
  subroutine check(values, name, noun, error, numbers)
    real(wp), intent(in) :: values(:, :)
    !> What they are and of what.
    character(len=*), intent(in) :: name, noun
    type(error_type), allocatable, intent(inout) :: error
    !> Numbers of the points, where they have some of their own.
    integer(long), intent(in), optional :: numbers(:)
    integer(long) :: number
    integer :: i

    if (allocated(error)) return
    if (all_usable(size(values), values)) return
    i = findloc(all(is_usable(values), dim=1), .false., dim=1)
    number = i
    if (present(numbers)) number = numbers(i)
    call fail(error, error_other, noun//' '//integer_text(number)//' has a '//name//unusable)
  end subroutine check
end module qsmpm_usable_state
