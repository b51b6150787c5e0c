!> The whole state of a model in a file, bit for bit, and back into a model built from the same
!> deck, with the ends of phases that later ones start from.
!>
!> A fingerprint of the fully resolved deck stands in the file; a restart with another deck is an
!> error, as is one whose arrays have other sizes, whose numbers are out of their ranges
!> (`qsmpm_state_check`) or whose bytes do not give its checksum.
module qsmpm_restart
  use qsmpm_kinds, only: wp, long
  use qsmpm_active_bodies, only: has_stages
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_hdf5_image, only: image_type, create_image, put_group, put_array, put_attribute, &
    save_image
  use qsmpm_hdf5_reader, only: reader_type, open_reader, get_array, get_attribute, find_group, close_reader
  use qsmpm_kept_arrays, only: kept_arrays_type
  use qsmpm_model, only: model_type, state_type, kept_phase_type, progress_type, phase_end_type
  use qsmpm_number_text, only: integer_text
  use qsmpm_phase_tree, only: is_wanted
  use qsmpm_field_list, only: field_type, field_list_type
  use qsmpm_point_selection, only: select_points
  use qsmpm_points, only: carried_type, points_type, surface_points_type, allocate_surface_points, allocate_watched
  use qsmpm_grid_window, only: window_type
  use qsmpm_model_window, only: restore
  use qsmpm_state_check, only: check_state, window_reason
  implicit none
  private

  public :: write_restart, read_restart, text_fingerprint

  !> Layout of the file; another one is refused.
  integer, parameter :: layout = 18

contains

  !> Two numbers that another text is next to certain not to have: polynomials in its bytes modulo
  !> the prime 2**31 - 1.
  pure function text_fingerprint(text) result(fingerprint)
    character(len=*), intent(in) :: text
    integer :: fingerprint(2)
    integer(long), parameter :: prime = 2147483647_long, base(2) = [263_long, 1048583_long]
    integer(long) :: sums(2)
    integer :: i

    sums = 1
    do i = 1, len(text)
      sums = mod(sums*base + iachar(text(i:i)) + 1, prime)
    end do
    fingerprint = int(sums)
  end function text_fingerprint

  !> Write the state; the former file stays until the new one is whole and on the disk.
  subroutine write_restart(path, model, fingerprint, error)
    !> Name of the file.
    character(len=*), intent(in) :: path
    type(model_type), intent(in) :: model
    !> Fingerprint of the resolved deck (2).
    integer, intent(in) :: fingerprint(:)
    !> Set when the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    type(image_type) :: image
    integer :: i

    call create_image(image)
    call put_attribute(image, '/', 'layout', layout)
    call put_attribute(image, '/', 'fingerprint_1', fingerprint(1))
    call put_attribute(image, '/', 'fingerprint_2', fingerprint(2))
    call put_state(image, '', model%state)
    if (allocated(model%kept_phases)) then
      do i = 1, size(model%kept_phases)
        associate (number => model%kept_phases(i)%phase)
          if (.not. is_in_file(model, model%state%progress%phase, number)) cycle
          call put_group(image, end_of(number))
          call put_state(image, end_of(number), model%kept_phases(i)%state)
        end associate
      end do
    end if
    call save_image(image, path, error, sealed=.true.)
  end subroutine write_restart

  !> Whether the end of a phase is in the file of a state: a phase behind the present one starts from it. The present
  !> one is kept when it ends, also in a run that goes on from its end.
  pure logical function is_in_file(model, present, number)
    type(model_type), intent(in) :: model
    !> Phase of the state, and number of the other.
    integer, intent(in) :: present, number

    is_in_file = number < present .and. is_wanted(model%analysis%phases, number, present)
  end function is_in_file

  !> Group of the end of a phase.
  pure function end_of(number) result(group)
    integer, intent(in) :: number
    character(len=:), allocatable :: group

    group = '/phase_'//integer_text(number)
  end function end_of

  !> Put a state in a group.
  subroutine put_state(image, group, state)
    type(image_type), intent(inout) :: image
    !> Empty for the root.
    character(len=*), intent(in) :: group
    type(state_type), intent(in) :: state
    integer, allocatable :: window(:)

    call put_progress(image, group//'/progress', state%progress)
    call put_carried(image, group//'/points', state%points)
    call put_carried(image, group//'/surface', state%surface)
    call put_carried(image, group//'/tracers', state%tracers)
    call put_carried(image, group//'/watched', state%watched)
    associate (inactive => state%inactive)
      call put_carried(image, group//'/inactive_points', inactive%points)
      call put_carried(image, group//'/unloading_points', inactive%unloading)
      call put_carried(image, group//'/inactive_surface', inactive%surface)
      call put_carried(image, group//'/unloading_surface', inactive%unloading_surface)
      call put_carried(image, group//'/feet', inactive%feet)
    end associate
    call put_group(image, group//'/mesh')
    allocate (window, source=[state%window%first, state%window%last])
    call put_array(image, group//'/mesh/window', window)
    call put_array(image, group//'/mesh/coordinates', state%coordinates)
    call put_array(image, group//'/mesh/reactions', state%reactions)
    call put_array(image, group//'/mesh/released', state%released)
    call put_attribute(image, group//'/mesh', 'plate', state%plate)
    call put_kept(image, group//'/terms', state%kept)
  end subroutine put_state

  !> Put what the terms keep.
  subroutine put_kept(image, group, kept)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    type(kept_arrays_type), intent(in) :: kept
    integer :: i

    call put_group(image, group)
    call put_attribute(image, group, 'count', kept_count(kept))
    do i = 1, kept_count(kept)
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
  subroutine get_kept(reader, group, kept)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    type(kept_arrays_type), intent(inout) :: kept
    integer :: i, found

    found = 0
    call get_attribute(reader, group, 'count', found)
    if (found /= kept_count(kept)) call note_reason(reader, 'it was written with other terms of the equations')
    do i = 1, kept_count(kept)
      call get_array(reader, group//'/'//kept%list(i)%name, kept%list(i)%values)
    end do
  end subroutine get_kept

  !> Put where the analysis stands.
  subroutine put_progress(image, group, progress)
    !> The file.
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    !> Where the analysis stands.
    type(progress_type), intent(in) :: progress

    call put_group(image, group)
    call put_attribute(image, group, 'phase', progress%phase)
    call put_attribute(image, group, 'step', progress%step)
    call put_attribute(image, group, 'phase_steps', progress%phase_steps)
    call put_attribute(image, group, 'fraction', progress%fraction)
    call put_attribute(image, group, 'load_factor', progress%load_factor)
    call put_attribute(image, group, 'next_step', progress%next_step)
    call put_attribute(image, group, 'damping', progress%damping)
    call put_attribute(image, group, 'failed_solvers', progress%failed_solvers)
    call put_attribute(image, group, 'undamped_newton', merge(1, 0, progress%undamped_newton))
    call put_attribute(image, group, 'external_work', progress%external_work)
    call put_attribute(image, group, 'internal_work', progress%internal_work)
    call put_attribute(image, group, 'constant_load_tests_done', progress%constant_load_tests_done)
    call put_attribute(image, group, 'release_left', progress%release_left)
    call put_attribute(image, group, 'own_settlement', progress%own_settlement)
    call put_attribute(image, group, 'strength_factor', progress%strength_factor)
    call put_attribute(image, group, 'stable_factor', progress%bracket%stable)
    call put_attribute(image, group, 'lost_factor', progress%bracket%lost)
    call put_attribute(image, group, 'factor_increment', progress%bracket%increment)
    call put_array(image, group//'/factors', progress%factors)
    call put_attribute(image, group, 'stopped', merge(1, 0, progress%stopped))
    call put_ends(image, group, progress)
    associate (limit => progress%limit)
      call put_attribute(image, group, 'first_compliance', limit%first)
      call put_attribute(image, group, 'last_compliance', limit%last)
      call put_attribute(image, group, 'last_middle', limit%middle)
      call put_attribute(image, group, 'refused', limit%refused)
      call put_attribute(image, group, 'refused_compliance', limit%refused_compliance)
      call put_attribute(image, group, 'refused_middle', limit%refused_middle)
      call put_attribute(image, group, 'plateau', limit%plateau)
      call put_attribute(image, group, 'knee', limit%knee)
    end associate
  end subroutine put_progress

  !> Put how phases have ended.
  subroutine put_ends(image, group, progress)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    type(progress_type), intent(in) :: progress
    integer, allocatable :: reason(:)
    real(wp), allocatable :: fraction(:), displacement(:)

    call put_attribute(image, group, 'ends', merge(1, 0, allocated(progress%ends)))
    if (.not. allocated(progress%ends)) return
    reason = progress%ends%reason
    fraction = progress%ends%fraction
    displacement = progress%ends%displacement
    call put_array(image, group//'/end_reason', reason)
    call put_array(image, group//'/end_fraction', fraction)
    call put_array(image, group//'/end_displacement', displacement)
  end subroutine put_ends

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

  !> Read the state back. The model is unchanged after an error.
  subroutine read_restart(path, model, fingerprint, error)
    !> Name of the file.
    character(len=*), intent(in) :: path
    !> A model built from the same deck.
    type(model_type), intent(inout) :: model
    !> Fingerprint of the resolved deck (2).
    integer, intent(in) :: fingerprint(:)
    !> Set when the file is damaged or belongs to another deck.
    type(error_type), allocatable, intent(out) :: error
    type(reader_type) :: reader
    type(state_type) :: state
    type(kept_phase_type), allocatable :: kept_phases(:)

    call open_reader(reader, path)
    call check_origin(reader, fingerprint)
    state = model%state
    call get_state(reader, '', model, state)
    call get_kept_phases(reader, model, state%progress%phase, kept_phases)
    call close_reader(reader, error)
    if (allocated(error)) return
    call restore(state, model)
    call move_alloc(kept_phases, model%kept_phases)
  end subroutine read_restart

  !> Get the ends of phases that the present one or a later one starts from.
  subroutine get_kept_phases(reader, model, present, kept_phases)
    type(reader_type), intent(inout) :: reader
    type(model_type), intent(in) :: model
    !> Phase of the state in the file.
    integer, intent(in) :: present
    type(kept_phase_type), allocatable, intent(out) :: kept_phases(:)
    integer :: numbers(size(model%analysis%phases)), i, n
    logical :: there

    n = 0
    do i = 1, size(numbers)
      if (allocated(reader%reason) .or. .not. is_in_file(model, present, i)) cycle
      call find_group(reader, end_of(i), there)
      if (.not. there) cycle
      n = n + 1
      numbers(n) = i
    end do
    allocate (kept_phases(n))
    do i = 1, n
      kept_phases(i)%phase = numbers(i)
      kept_phases(i)%state = model%state
      if (.not. allocated(reader%reason)) call get_state(reader, end_of(numbers(i)), model, kept_phases(i)%state)
    end do
  end subroutine get_kept_phases

  !> Get a state of a group.
  subroutine get_state(reader, group, model, state)
    type(reader_type), intent(inout) :: reader
    !> Empty for the root.
    character(len=*), intent(in) :: group
    !> A model built from the same deck.
    type(model_type), intent(in) :: model
    !> One of the model.
    type(state_type), intent(inout) :: state
    integer, allocatable :: window(:), watched(:)

    allocate (window(6), source=0)
    call get_array(reader, group//'/mesh/window', window)
    call note_reason(reader, window_reason(window, model))
    if (any(window /= [state%window%first, state%window%last])) then
      ! Another part of the grid: as many nodes as it has.
      state%window = window_type(window(:3), window(4:))
      deallocate (state%coordinates, state%reactions, state%released)
    end if
    call get_progress(reader, group//'/progress', state%progress)
    call get_points(reader, group, model, state)
    call get_carried(reader, group//'/tracers', state%tracers)
    ! As many as the phase in the file watches.
    call get_array(reader, group//'/watched/cell', watched)
    if (allocated(watched)) call allocate_watched(state%watched, model%mesh%dimension, size(watched))
    call get_carried(reader, group//'/watched', state%watched)
    call get_array(reader, group//'/mesh/coordinates', state%coordinates)
    call get_array(reader, group//'/mesh/reactions', state%reactions)
    call get_array(reader, group//'/mesh/released', state%released)
    call get_attribute(reader, group//'/mesh', 'plate', state%plate)
    call get_kept(reader, group//'/terms', state%kept)
    if (.not. allocated(reader%reason)) call note_reason(reader, check_state(state, model))
  end subroutine get_state

  !> Material and surface points, those that are there and the others: as many of each as the phase in the file has, and
  !> not more than the bodies.
  subroutine get_points(reader, group, model, state)
    type(reader_type), intent(inout) :: reader
    !> Of the state, empty for the root.
    character(len=*), intent(in) :: group
    type(model_type), intent(in) :: model
    type(state_type), intent(inout) :: state

    call size_all_points(reader, group, model, state)
    call get_carried(reader, group//'/points', state%points)
    call get_carried(reader, group//'/inactive_points', state%inactive%points)
    call get_carried(reader, group//'/unloading_points', state%inactive%unloading)
    call get_carried(reader, group//'/surface', state%surface)
    call get_carried(reader, group//'/inactive_surface', state%inactive%surface)
    call get_carried(reader, group//'/unloading_surface', state%inactive%unloading_surface)
    call get_carried(reader, group//'/feet', state%inactive%feet)
  end subroutine get_points

  !> Room for as many material and surface points as the file has.
  subroutine size_all_points(reader, group, model, state)
    type(reader_type), intent(inout) :: reader
    !> Of the state, empty for the root.
    character(len=*), intent(in) :: group
    type(model_type), intent(in) :: model
    type(state_type), intent(inout) :: state
    type(points_type) :: like
    integer :: left

    like = state%points
    left = state%points%count + state%inactive%points%count + state%inactive%unloading%count
    if (has_stages(model%analysis)) then
      call size_points(group//'/points', state%points)
      call size_points(group//'/inactive_points', state%inactive%points)
      call size_points(group//'/unloading_points', state%inactive%unloading)
      if (left < 0) call note_reason(reader, 'it has more material points than the bodies')
    end if
    call size_surface(group//'/surface', state%surface)
    call size_surface(group//'/inactive_surface', state%inactive%surface)
    call size_surface(group//'/unloading_surface', state%inactive%unloading_surface)

  contains

    !> Room for material points.
    subroutine size_points(name, points)
      character(len=*), intent(in) :: name
      type(points_type), intent(inout) :: points
      type(points_type) :: sized
      integer, allocatable :: cells(:)

      call get_array(reader, name//'/cell', cells)
      if (.not. allocated(cells)) return
      left = left - size(cells)
      if (size(cells) == points%count) return
      call select_points(like, spread(1, 1, size(cells)), sized)
      points = sized
    end subroutine size_points

    !> Room for surface points.
    subroutine size_surface(name, points)
      character(len=*), intent(in) :: name
      type(surface_points_type), intent(inout) :: points
      integer, allocatable :: cells(:)

      call get_array(reader, name//'/cell', cells)
      if (.not. allocated(cells)) return
      if (size(cells) /= points%count) call allocate_surface_points(points, size(like%position, 1), size(cells))
    end subroutine size_surface
  end subroutine size_all_points

  !> Note what is wrong, where something is and nothing was before.
  subroutine note_reason(reader, reason)
    !> The file.
    type(reader_type), intent(inout) :: reader
    !> Empty when nothing is.
    character(len=*), intent(in) :: reason

    if (len(reason) > 0 .and. .not. allocated(reader%reason)) reader%reason = reason
  end subroutine note_reason

  !> Note when the file is not one of this program or of this deck.
  subroutine check_origin(reader, fingerprint)
    !> The file.
    type(reader_type), intent(inout) :: reader
    !> Fingerprint of the resolved deck (2).
    integer, intent(in) :: fingerprint(:)
    integer :: found_layout, found(2)

    found_layout = 0
    found = 0
    call get_attribute(reader, '/', 'layout', found_layout)
    if (allocated(reader%reason)) then
      if (reader%file >= 0) reader%reason = 'it is not a restart file'
      return
    end if
    call get_attribute(reader, '/', 'fingerprint_1', found(1))
    call get_attribute(reader, '/', 'fingerprint_2', found(2))
    if (allocated(reader%reason)) return
    if (found_layout /= layout) then
      reader%reason = 'it was written by another version of the program'
    else if (any(found /= fingerprint)) then
      reader%reason = 'it was written by a run of another deck'
    end if
  end subroutine check_origin

  !> Get where the analysis stood.
  subroutine get_progress(reader, group, progress)
    !> The file.
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    !> Where the analysis stood.
    type(progress_type), intent(inout) :: progress
    integer :: whole, stopped

    whole = 0
    stopped = 0
    call get_attribute(reader, group, 'phase', progress%phase)
    call get_attribute(reader, group, 'step', progress%step)
    call get_attribute(reader, group, 'phase_steps', progress%phase_steps)
    call get_attribute(reader, group, 'fraction', progress%fraction)
    call get_attribute(reader, group, 'load_factor', progress%load_factor)
    call get_attribute(reader, group, 'next_step', progress%next_step)
    call get_attribute(reader, group, 'damping', progress%damping)
    call get_attribute(reader, group, 'failed_solvers', progress%failed_solvers)
    call get_attribute(reader, group, 'undamped_newton', whole)
    progress%undamped_newton = whole == 1
    call get_attribute(reader, group, 'external_work', progress%external_work)
    call get_attribute(reader, group, 'internal_work', progress%internal_work)
    call get_attribute(reader, group, 'constant_load_tests_done', progress%constant_load_tests_done)
    call get_attribute(reader, group, 'release_left', progress%release_left)
    call get_attribute(reader, group, 'own_settlement', progress%own_settlement)
    call get_attribute(reader, group, 'strength_factor', progress%strength_factor)
    call get_attribute(reader, group, 'stable_factor', progress%bracket%stable)
    call get_attribute(reader, group, 'lost_factor', progress%bracket%lost)
    call get_attribute(reader, group, 'factor_increment', progress%bracket%increment)
    if (allocated(progress%factors)) deallocate (progress%factors)
    call get_array(reader, group//'/factors', progress%factors)
    call get_attribute(reader, group, 'stopped', stopped)
    progress%stopped = stopped == 1
    call get_ends(reader, group, progress)
    associate (limit => progress%limit)
      call get_attribute(reader, group, 'first_compliance', limit%first)
      call get_attribute(reader, group, 'last_compliance', limit%last)
      call get_attribute(reader, group, 'last_middle', limit%middle)
      call get_attribute(reader, group, 'refused', limit%refused)
      call get_attribute(reader, group, 'refused_compliance', limit%refused_compliance)
      call get_attribute(reader, group, 'refused_middle', limit%refused_middle)
      call get_attribute(reader, group, 'plateau', limit%plateau)
      call get_attribute(reader, group, 'knee', limit%knee)
    end associate
  end subroutine get_progress

  !> Get how phases have ended.
  subroutine get_ends(reader, group, progress)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    type(progress_type), intent(inout) :: progress
    integer, allocatable :: reason(:)
    real(wp), allocatable :: fraction(:), displacement(:)
    logical :: whole
    integer :: there, i

    there = 0
    if (allocated(progress%ends)) deallocate (progress%ends)
    call get_attribute(reader, group, 'ends', there)
    if (there == 0 .or. allocated(reader%reason)) return
    call get_array(reader, group//'/end_reason', reason)
    call get_array(reader, group//'/end_fraction', fraction)
    call get_array(reader, group//'/end_displacement', displacement)
    if (allocated(reader%reason)) return
    whole = allocated(reason) .and. allocated(fraction) .and. allocated(displacement)
    if (whole) whole = size(fraction) == size(reason) .and. size(displacement) == size(reason)
    if (.not. whole) call note_reason(reader, 'the ends of its phases have lost a part')
    if (.not. whole) return
    progress%ends = [(phase_end_type(reason(i), fraction(i), displacement(i)), i=1, size(reason))]
  end subroutine get_ends

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
end module qsmpm_restart
