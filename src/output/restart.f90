!> The whole state of a model in a file, bit for bit, and back into a model built from the same
!> deck, with the ends of phases that later ones start from.
!>
!> A fingerprint of the fully resolved deck stands in the file; a restart with another deck is an
!> error, as is one whose arrays have other sizes, whose numbers are out of their ranges
!> (`qsmpm_state_check`) or whose bytes do not give its checksum.
!>
!> The file of a model that is divided is in parts (qsmpm_restart_parts).
module qsmpm_restart
  use qsmpm_kinds, only: wp, long
  use qsmpm_active_bodies, only: has_stages
  use qsmpm_agreement, only: agree
  use qsmpm_error, only: error_type
  use qsmpm_hdf5_image, only: image_type, create_image, put_group, put_array, put_attribute, &
    save_image
  use qsmpm_hdf5_reader, only: reader_type, open_reader, get_array, get_attribute, find_group, note_reason, close_reader
  use qsmpm_model, only: model_type, state_type, kept_phase_type
  use qsmpm_number_text, only: integer_text
  use qsmpm_own_part, only: is_divided
  use qsmpm_phase_tree, only: is_wanted
  use qsmpm_point_selection, only: select_points
  use qsmpm_points, only: points_type, surface_points_type, allocate_surface_points, allocate_watched
  use qsmpm_grid_window, only: window_type
  use qsmpm_model_window, only: restore
  use qsmpm_restart_fields, only: put_carried, get_carried, put_kept, get_kept
  use qsmpm_restart_parts, only: node_values_type, put_shared_state, put_own_state, save_restart_parts, &
    remove_restart_parts, check_parts, share_reason, start_joined, finish_joined, lay_joined, put_node_values
  use qsmpm_restart_progress, only: put_progress, get_progress
  use qsmpm_state_check, only: check_state, window_reason
  use qsmpm_team, only: team_type
  implicit none
  private

  public :: write_restart, read_restart, text_fingerprint

  !> Layout of the file, in one piece or in parts; another one is refused.
  integer, parameter :: layout = 18, layout_in_parts = 19

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
    type(image_type) :: image, part
    integer :: i

    call create_image(image)
    call put_attribute(image, '/', 'layout', merge(layout_in_parts, layout, is_divided(model%part)))
    call put_attribute(image, '/', 'fingerprint_1', fingerprint(1))
    call put_attribute(image, '/', 'fingerprint_2', fingerprint(2))
    if (is_divided(model%part)) then
      call put_shared_state(image, model)
    else
      call put_state(image, '', model%state)
    end if
    if (allocated(model%kept_phases) .and. model%part%team%rank == 0) then
      do i = 1, size(model%kept_phases)
        associate (number => model%kept_phases(i)%phase)
          if (.not. is_in_file(model, model%state%progress%phase, number)) cycle
          call put_group(image, end_of(number))
          call put_state(image, end_of(number), model%kept_phases(i)%state)
        end associate
      end do
    end if
    if (is_divided(model%part)) then
      call create_image(part, 'qsmpm.part')
      call put_own_state(part, model)
      call save_restart_parts(model%part%team, part, path, image, error)
    else
      call save_image(image, path, error, sealed=.true.)
      if (.not. allocated(error)) call remove_restart_parts(path)
    end if
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

  !> Read the state back. The model is unchanged after an error.
  subroutine read_restart(path, model, fingerprint, error, team)
    !> Name of the file.
    character(len=*), intent(in) :: path
    !> A model built from the same deck.
    type(model_type), intent(inout) :: model
    !> Fingerprint of the resolved deck (2).
    integer, intent(in) :: fingerprint(:)
    !> Set when the file is damaged or belongs to another deck.
    type(error_type), allocatable, intent(out) :: error
    !> Who reads it together, and gets the same error; this process alone unless given.
    type(team_type), intent(in), optional :: team
    type(team_type) :: readers
    type(reader_type) :: reader
    type(state_type) :: state
    type(kept_phase_type), allocatable :: kept_phases(:)
    type(node_values_type) :: nodes
    logical :: in_parts

    if (present(team)) readers = team
    call open_reader(reader, path)
    call check_origin(reader, fingerprint, in_parts)
    call share_reason(readers, reader)
    if (in_parts .and. .not. allocated(reader%reason)) call check_parts(readers, reader)
    call share_reason(readers, reader)
    state = model%state
    if (in_parts) call start_joined(reader, model, state, nodes)
    call get_state(reader, '', model, in_parts, state)
    call get_kept_phases(reader, model, state%progress%phase, kept_phases)
    call close_reader(reader, error)
    call agree(readers, error)
    if (allocated(error)) return
    if (in_parts) call lay_joined(model, state)
    call restore(state, model)
    if (in_parts) call put_node_values(model, nodes)
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
      if (.not. allocated(reader%reason)) call get_state(reader, end_of(numbers(i)), &
        model, .false., kept_phases(i)%state)
    end do
  end subroutine get_kept_phases

  !> Get a state of a group.
  subroutine get_state(reader, group, model, in_parts, state)
    type(reader_type), intent(inout) :: reader
    !> Empty for the root.
    character(len=*), intent(in) :: group
    !> A model built from the same deck.
    type(model_type), intent(in) :: model
    !> The rows of points are those of parts; nodal values are got elsewhere.
    logical, intent(in) :: in_parts
    !> One of the model.
    type(state_type), intent(inout) :: state
    integer, allocatable :: watched(:)

    if (.not. in_parts) call get_mesh(reader, group, model, state)
    call get_progress(reader, group//'/progress', state%progress)
    call get_points(reader, group, model, state)
    call get_carried(reader, group//'/tracers', state%tracers)
    ! As many as the phase in the file watches.
    call get_array(reader, group//'/watched/cell', watched)
    if (allocated(watched)) call allocate_watched(state%watched, model%mesh%dimension, size(watched))
    call get_carried(reader, group//'/watched', state%watched)
    call get_attribute(reader, group//'/mesh', 'plate', state%plate)
    call get_kept(reader, group//'/terms', state%kept, nodal=.not. in_parts)
    if (.not. allocated(reader%reason)) call note_reason(reader, check_state(state, model))
    if (in_parts) call finish_joined(state)
  end subroutine get_state

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
  end subroutine get_mesh

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

  !> Note when the file is not one of this program or of this deck.
  subroutine check_origin(reader, fingerprint, in_parts)
    !> The file.
    type(reader_type), intent(inout) :: reader
    !> Fingerprint of the resolved deck (2).
    integer, intent(in) :: fingerprint(:)
    !> It is the index of parts.
    logical, intent(out) :: in_parts
    integer :: found_layout, found(2)

    in_parts = .false.
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
    in_parts = found_layout == layout_in_parts
    if (found_layout /= layout .and. .not. in_parts) then
      reader%reason = 'it was written by another version of the program'
    else if (any(found /= fingerprint)) then
      reader%reason = 'it was written by a run of another deck'
    end if
  end subroutine check_origin

end module qsmpm_restart
