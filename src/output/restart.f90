!> Writes the complete state of a model to a file, with identical bits, and reads it into a model built from the same
!> deck, including the ends of phases from which later ones start.
!>
!> The file contains a fingerprint of the fully resolved deck. A restart with another deck is an error, as is a file
!> with arrays of other sizes, with values outside their ranges (`qsmpm_state_check`) or with a wrong checksum.
!>
!> If the model is divided each process writes its own rows (qsmpm_restart_rows). Several processes divide the model
!> according to the file that they read (qsmpm_restart_division).
module qsmpm_restart
  use qsmpm_kinds, only: long
  use qsmpm_active_bodies, only: has_stages
  use qsmpm_agreement, only: agree
  use qsmpm_cell_numbers, only: whole_of
  use qsmpm_division, only: node_values_type, put_node_values
  use qsmpm_error, only: error_type
  use qsmpm_hdf5_image, only: image_type, create_image, put_group, put_attribute, save_image
  use qsmpm_hdf5_reader, only: reader_type, open_reader, get_attribute, find_group, note_reason, close_reader, &
    count_rows
  use qsmpm_model, only: model_type, state_type, kept_phase_type, progress_type
  use qsmpm_number_text, only: integer_text
  use qsmpm_own_part, only: is_divided
  use qsmpm_phase_tree, only: is_wanted
  use qsmpm_points, only: points_type, allocate_watched
  use qsmpm_model_window, only: restore
  use qsmpm_restart_division, only: read_divided
  use qsmpm_restart_rows, only: node_labels, put_state, put_own, share_reason, get_node_values, lay_joined, &
    get_carried, get_kept, get_mesh, size_set, get_progress
  use qsmpm_shared_file, only: check_shared_seal
  use qsmpm_state_check, only: check_state
  use qsmpm_team, only: team_type
  implicit none
  private

  public :: write_restart, read_restart, writes_kept_phases, text_fingerprint

  !> Version of the file layout; other versions are rejected.
  integer, parameter :: layout = 22

contains

  !> Returns two numbers that differ for different texts with near certainty: polynomials in the bytes modulo the prime
  !> 2**31 - 1.
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

  !> Writes the state; the previous file remains until the new one is complete and on the disk.
  subroutine write_restart(path, model, fingerprint, error)
    !> Name of the file.
    character(len=*), intent(in) :: path
    type(model_type), intent(in) :: model
    !> Fingerprint of the resolved deck (2).
    integer, intent(in) :: fingerprint(:)
    !> Set when the file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error
    type(image_type) :: image
    integer :: i

    call create_image(image, model%part%team)
    call put_attribute(image, '/', 'layout', layout)
    call put_attribute(image, '/', 'fingerprint_1', fingerprint(1))
    call put_attribute(image, '/', 'fingerprint_2', fingerprint(2))
    if (is_divided(model%part)) then
      call put_own(image, model)
    else
      call put_state(image, '', model%state, .false.)
    end if
    if (allocated(model%kept_phases)) then
      do i = 1, size(model%kept_phases)
        associate (number => model%kept_phases(i)%phase)
          if (.not. is_in_file(model, model%state%progress%phase, number)) cycle
          call put_group(image, end_of(number))
          call put_state(image, end_of(number), model%kept_phases(i)%state, .false.)
        end associate
      end do
    end if
    call save_image(image, path, .true., error)
  end subroutine write_restart

  !> Returns whether the file of a model contains ends of phases, which are written for the whole model.
  pure logical function writes_kept_phases(model) result(writes)
    type(model_type), intent(in) :: model
    integer :: i

    writes = .false.
    if (.not. allocated(model%kept_phases)) return
    writes = any([(is_in_file(model, model%state%progress%phase, model%kept_phases(i)%phase), &
      i=1, size(model%kept_phases))])
  end function writes_kept_phases

  !> Returns whether the end of a phase is in the file of a state: a later phase starts from it. The current phase is
  !> stored when it ends, also in a run that continues from its end.
  pure logical function is_in_file(model, present, number)
    type(model_type), intent(in) :: model
    !> Phase of the state; number of the other phase.
    integer, intent(in) :: present, number

    is_in_file = number < present .and. is_wanted(model%analysis%phases, number, present)
  end function is_in_file

  !> Returns the group of the end of a phase.
  pure function end_of(number) result(group)
    integer, intent(in) :: number
    character(len=:), allocatable :: group

    group = '/phase_'//integer_text(number)
  end function end_of

  !> Reads a state. With a single process, the model is unchanged after an error.
  subroutine read_restart(path, model, fingerprint, error, team)
    !> Name of the file.
    character(len=*), intent(in) :: path
    !> A model built from the same deck.
    type(model_type), intent(inout) :: model
    !> Fingerprint of the resolved deck (2).
    integer, intent(in) :: fingerprint(:)
    !> Set when the file is damaged or belongs to another deck.
    type(error_type), allocatable, intent(out) :: error
    !> Processes that read the file together and receive the same error; by default this process alone.
    type(team_type), intent(in), optional :: team
    type(team_type) :: readers
    type(reader_type) :: reader
    type(state_type) :: state
    type(kept_phase_type), allocatable :: kept_phases(:)
    type(node_values_type) :: nodes
    character(len=:), allocatable :: reason
    logical :: in_rows

    if (present(team)) readers = team
    call check_shared_seal(readers, path, reason)
    reader%path = path
    if (allocated(reason)) call note_reason(reader, reason)
    call share_reason(readers, reader)
    if (.not. allocated(reader%reason)) call open_reader(reader, path)
    call check_origin(reader, fingerprint)
    call find_group(reader, node_labels, in_rows)
    call share_reason(readers, reader)
    if (readers%ranks > 1) then
      call get_divided(reader, in_rows, readers, model, error)
      return
    end if
    state = model%state
    if (in_rows) then
      state%window = whole_of(model)
      call get_node_values(reader, state%kept, nodes)
    end if
    call get_state(reader, '', model, in_rows, state)
    call get_kept_phases(reader, model, state%progress%phase, kept_phases)
    call close_reader(reader, error)
    if (allocated(error)) return
    if (in_rows) call lay_joined(model, state)
    call restore(state, model)
    if (in_rows) call put_node_values(model, nodes)
    call move_alloc(kept_phases, model%kept_phases)
  end subroutine read_restart

  !> Divides the model according to the state in an open file, and reads the ends of phases in it.
  subroutine get_divided(reader, in_rows, team, model, error)
    type(reader_type), intent(inout) :: reader
    logical, intent(in) :: in_rows
    type(team_type), intent(in) :: team
    type(model_type), intent(inout) :: model
    !> Set consistently on all processes.
    type(error_type), allocatable, intent(out) :: error
    type(kept_phase_type), allocatable :: kept_phases(:)
    type(progress_type) :: progress
    type(error_type), allocatable :: failure
    integer :: i, most

    most = points_of_bodies(model)
    progress = model%state%progress
    if (.not. allocated(reader%reason)) call get_progress(reader, '/progress', progress)
    associate (numbers => kept_numbers(reader, model, progress%phase))
      allocate (kept_phases(size(numbers)))
      call share_reason(team, reader)
      do i = 1, size(numbers)
        if (allocated(reader%reason) .or. allocated(error)) exit
        call read_divided(reader, end_of(numbers(i)), .false., team, most, model, error)
        kept_phases(i) = kept_phase_type(numbers(i), model%state, model%part)
      end do
    end associate
    if (.not. (allocated(reader%reason) .or. allocated(error))) &
      call read_divided(reader, '', in_rows, team, most, model, error)
    call close_reader(reader, failure)
    if (allocated(failure)) call move_alloc(failure, error)
    call agree(team, error)
    call move_alloc(kept_phases, model%kept_phases)
  end subroutine get_divided

  !> Returns the number of material points of all bodies.
  pure integer function points_of_bodies(model) result(points)
    type(model_type), intent(in) :: model

    associate (state => model%state)
      points = state%points%count + state%inactive%points%count + state%inactive%unloading%count
    end associate
    if (model%part%built_points > 0) points = int(model%part%built_points)
  end function points_of_bodies

  !> Reads the ends of phases from which the current or a later phase starts.
  subroutine get_kept_phases(reader, model, present, kept_phases)
    type(reader_type), intent(inout) :: reader
    type(model_type), intent(in) :: model
    !> Phase of the state in the file.
    integer, intent(in) :: present
    type(kept_phase_type), allocatable, intent(out) :: kept_phases(:)
    integer :: i

    associate (numbers => kept_numbers(reader, model, present))
      allocate (kept_phases(size(numbers)))
      do i = 1, size(numbers)
        kept_phases(i)%phase = numbers(i)
        kept_phases(i)%state = model%state
        if (.not. allocated(reader%reason)) call get_state(reader, end_of(numbers(i)), &
          model, .false., kept_phases(i)%state)
      end do
    end associate
  end subroutine get_kept_phases

  !> Returns the phases whose ends are in a file and required.
  function kept_numbers(reader, model, present) result(numbers)
    type(reader_type), intent(inout) :: reader
    type(model_type), intent(in) :: model
    !> Phase of the state in the file.
    integer, intent(in) :: present
    integer, allocatable :: numbers(:)
    integer :: i
    logical :: there

    allocate (numbers(0))
    do i = 1, size(model%analysis%phases)
      if (allocated(reader%reason) .or. .not. is_in_file(model, present, i)) cycle
      call find_group(reader, end_of(i), there)
      if (there) numbers = [numbers, i]
    end do
  end function kept_numbers

  !> Reads a state from a group.
  subroutine get_state(reader, group, model, in_rows, state)
    type(reader_type), intent(inout) :: reader
    !> Empty for the root.
    character(len=*), intent(in) :: group
    !> A model built from the same deck.
    type(model_type), intent(in) :: model
    !> Whether points and nodes are rows of several processes; nodal values are then read elsewhere.
    logical, intent(in) :: in_rows
    !> A state of the model, overwritten.
    type(state_type), intent(inout) :: state

    if (.not. in_rows) call get_mesh(reader, group, model, state)
    call get_progress(reader, group//'/progress', state%progress)
    call get_points(reader, group, model, state)
    call get_carried(reader, group//'/tracers', state%tracers)
    ! As many as are watched in the phase of the file.
    call allocate_watched(state%watched, model%mesh%dimension, count_rows(reader, group//'/watched/cell'))
    call get_carried(reader, group//'/watched', state%watched)
    call get_attribute(reader, group//'/mesh', 'plate', state%plate)
    call get_kept(reader, group//'/terms', state%kept, nodal=.not. in_rows)
    if (.not. allocated(reader%reason)) call note_reason(reader, check_state(state, model))
  end subroutine get_state

  !> Reads active and inactive material and surface points: the numbers are those in the file, at most those of the
  !> bodies.
  subroutine get_points(reader, group, model, state)
    type(reader_type), intent(inout) :: reader
    !> Group of the state, empty for the root.
    character(len=*), intent(in) :: group
    type(model_type), intent(in) :: model
    type(state_type), intent(inout) :: state
    type(points_type) :: like
    integer :: left

    like = state%points
    associate (inactive => state%inactive)
      left = state%points%count + inactive%points%count + inactive%unloading%count
      if (has_stages(model%analysis)) then
        call size_set(reader, group//'/points', like, state%points)
        call size_set(reader, group//'/inactive_points', like, inactive%points)
        call size_set(reader, group//'/unloading_points', like, inactive%unloading)
        if (state%points%count + inactive%points%count + inactive%unloading%count > left) &
          call note_reason(reader, 'it has more material points than the bodies')
      end if
      call size_set(reader, group//'/surface', like, state%surface)
      call size_set(reader, group//'/inactive_surface', like, inactive%surface)
      call size_set(reader, group//'/unloading_surface', like, inactive%unloading_surface)
    end associate
    call get_carried(reader, group//'/points', state%points)
    call get_carried(reader, group//'/inactive_points', state%inactive%points)
    call get_carried(reader, group//'/unloading_points', state%inactive%unloading)
    call get_carried(reader, group//'/surface', state%surface)
    call get_carried(reader, group//'/inactive_surface', state%inactive%surface)
    call get_carried(reader, group//'/unloading_surface', state%inactive%unloading_surface)
    call get_carried(reader, group//'/feet', state%inactive%feet)
  end subroutine get_points

  !> Records an error if the file is not from this program or this deck.
  subroutine check_origin(reader, fingerprint)
    type(reader_type), intent(inout) :: reader
    !> Fingerprint of the resolved deck (2).
    integer, intent(in) :: fingerprint(:)
    integer :: found_layout, found(2)

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
end module qsmpm_restart
