!> A copy of an analysis between two steps, in memory, with which a trial load can be undone.
module qsmpm_snapshot
  use qsmpm_phase_description, only: phase_type
  use qsmpm_model, only: model_type, state_type, loading_type, kept_phase_type
  use qsmpm_model_window, only: restore
  use qsmpm_phases, only: step_loop_type
  implicit none
  private

  public :: snapshot_type, take_snapshot, restore_checkpoint, copy_phases

  !> State, loads, stages, and stored ends of phases from which later phases start.
  type :: snapshot_type
    !> Whether a copy is stored.
    logical :: taken = .false.
    !> Number of materials of the copied model.
    integer :: materials = 0
    class(state_type), allocatable, private :: state
    type(loading_type), private :: loading
    type(kept_phase_type), allocatable, private :: kept_phases(:)
    type(phase_type), allocatable, private :: phases(:), model_phases(:)
    logical, private :: begun = .false., end_notified = .false.
  end type snapshot_type

contains

  !> Stores a copy of an analysis.
  subroutine take_snapshot(model, phases, loop, snapshot)
    type(model_type), intent(in) :: model
    !> Stages of the scene.
    type(phase_type), intent(in) :: phases(:)
    type(step_loop_type), intent(in) :: loop
    type(snapshot_type), intent(out) :: snapshot

    allocate (snapshot%state, source=model%state)
    snapshot%loading = model%loading
    call copy_kept(model%kept_phases, snapshot%kept_phases)
    call copy_phases(phases, snapshot%phases)
    call copy_phases(model%analysis%phases, snapshot%model_phases)
    snapshot%begun = loop%begun
    snapshot%end_notified = loop%end_notified
    snapshot%materials = size(model%laws)
    snapshot%taken = .true.
  end subroutine take_snapshot

  !> Restores a copy of the same model.
  subroutine restore_checkpoint(snapshot, model, phases, loop)
    type(snapshot_type), intent(in) :: snapshot
    type(model_type), intent(inout) :: model
    !> Stages of the scene.
    type(phase_type), allocatable, intent(inout) :: phases(:)
    type(step_loop_type), intent(inout) :: loop

    call copy_phases(snapshot%phases, phases)
    call copy_phases(snapshot%model_phases, model%analysis%phases)
    ! A regenerated window evaluates the loads again, so the loads are restored last.
    model%state%progress%phase = min(model%state%progress%phase, size(phases))
    call restore(snapshot%state, model)
    model%loading = snapshot%loading
    call copy_kept(snapshot%kept_phases, model%kept_phases)
    loop%begun = snapshot%begun
    loop%end_notified = snapshot%end_notified
  end subroutine restore_checkpoint

  !> Copies stored phases one by one.
  subroutine copy_kept(from, to)
    type(kept_phase_type), allocatable, intent(in) :: from(:)
    type(kept_phase_type), allocatable, intent(inout) :: to(:)
    integer :: i

    if (allocated(to)) deallocate (to)
    if (.not. allocated(from)) return
    allocate (to(size(from)))
    do i = 1, size(from)
      to(i) = from(i)
    end do
  end subroutine copy_kept

  !> Copies stages one by one.
  subroutine copy_phases(from, to)
    type(phase_type), intent(in) :: from(:)
    type(phase_type), allocatable, intent(inout) :: to(:)
    type(phase_type), allocatable :: copy(:)
    integer :: i

    allocate (copy(size(from)))
    do i = 1, size(from)
      copy(i) = from(i)
    end do
    call move_alloc(copy, to)
  end subroutine copy_phases
end module qsmpm_snapshot
