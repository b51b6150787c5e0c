!> Copies of the data that move in a step, restored when a point is found to have left the mesh.
!>
!> Stress, state variables, volume, deformation gradient, strains and pore pressures of the material points are updated
!> last (`qsmpm_convection`, `qsmpm_pore_water`) and are not copied, nor are the data from which the model is built. A
!> static step therefore holds one copy of the large arrays: the state that `qsmpm_stepping` saves by assignment and
!> `restore` of `qsmpm_model_window` restores.
!>
!> Also checks the state at the start of a step: a restart file, an embedding program or the start of a law may have
!> introduced values that are not finite. Values computed by a step are checked where they are computed.
module qsmpm_saved_places
  use qsmpm_kinds, only: wp, long
  use qsmpm_model, only: model_type, rest_of_state_type, progress_type, carried_set_type, carried_sets
  use qsmpm_points, only: carried_type
  use qsmpm_model_window, only: return_to_window, place_mesh
  use qsmpm_agreement, only: agree
  use qsmpm_error, only: error_type, fail, error_other
  use qsmpm_finite, only: all_usable, is_usable, unusable
  use qsmpm_field_list, only: field_list_type
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: saved_places_type, save_places, restore_places, check_state

  !> Positions and progress.
  type :: saved_places_type
    !> Position and local coordinates of the material points (dimension, count), owner cells (count).
    real(wp), allocatable :: position(:, :), local(:, :)
    integer, allocatable :: cell(:)
    !> Other data of the state: inactive bodies, some of which are located in the mesh, and nodal values of fields.
    type(rest_of_state_type) :: rest
  end type saved_places_type

contains

  !> Copies the current positions.
  subroutine save_places(model, saved)
    type(model_type), intent(in) :: model
    type(saved_places_type), intent(out) :: saved

    saved%position = model%state%points%position
    saved%local = model%state%points%local
    saved%cell = model%state%points%cell
    saved%rest = model%state%rest_of_state_type
  end subroutine save_places

  !> Restores a copy.
  subroutine restore_places(saved, model)
    type(saved_places_type), intent(in) :: saved
    type(model_type), intent(inout) :: model

    call return_to_window(model, saved%rest%window)
    model%state%points%position = saved%position
    model%state%points%local = saved%local
    model%state%points%cell = saved%cell
    model%state%rest_of_state_type = saved%rest
    call place_mesh(model)
  end subroutine restore_places

  !> Rejects a state with an unusable value, consistently on all processes; the first one is named.
  subroutine check_state(model, error)
    type(model_type), intent(in), target :: model
    !> error_other
    type(error_type), allocatable, intent(out) :: error
    type(carried_set_type) :: sets(9)
    integer :: i

    sets = carried_sets(model%state)
    do i = 1, size(sets)
      call check_carried(sets(i)%places, trim(sets(i)%noun), error)
    end do
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

  !> Checks all fields of a set of points.
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

  !> Checks the progress and the plate of a moving mesh.
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

  !> Checks values of points (components, points); does nothing if there is an error already.
  subroutine check(values, name, noun, error, numbers)
    real(wp), intent(in) :: values(:, :)
    !> Names of the quantity and of an item.
    character(len=*), intent(in) :: name, noun
    type(error_type), allocatable, intent(inout) :: error
    !> Global numbers of the points, if any.
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
end module qsmpm_saved_places
