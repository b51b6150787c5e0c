!> Where an analysis stands, in a restart file (qsmpm_restart).
module qsmpm_restart_progress
  use qsmpm_kinds, only: wp
  use qsmpm_hdf5_image, only: image_type, put_group, put_array, put_attribute
  use qsmpm_hdf5_reader, only: reader_type, get_array, get_attribute, note_reason
  use qsmpm_model, only: progress_type, phase_end_type
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: put_progress, get_progress

contains

  !> Put where the analysis stands.
  subroutine put_progress(image, group, progress)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    !> Where the analysis stands.
    type(progress_type), intent(in) :: progress
    integer :: i

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
    call put_attribute(image, group, 'force_at_start', progress%force_at_start)
    call put_attribute(image, group, 'strength_factor', progress%strength_factor)
    call put_attribute(image, group, 'stable_factor', progress%bracket%stable)
    call put_attribute(image, group, 'lost_factor', progress%bracket%lost)
    do i = 1, size(progress%bracket%lost_above)
      call put_attribute(image, group, 'lost_factor_above_'//integer_text(i), progress%bracket%lost_above(i))
    end do
    call put_attribute(image, group, 'factor_increment', progress%bracket%increment)
    if (allocated(progress%factors)) call put_array(image, group//'/factors', progress%factors)
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
      call put_attribute(image, group, 'most_compliance', limit%most)
      call put_attribute(image, group, 'knee', limit%knee)
    end associate
  end subroutine put_progress

  !> Put how phases have ended.
  subroutine put_ends(image, group, progress)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    type(progress_type), intent(in) :: progress

    call put_attribute(image, group, 'ends', merge(1, 0, allocated(progress%ends)))
    if (.not. allocated(progress%ends)) return
    call put_array(image, group//'/end_reason', progress%ends%reason)
    call put_array(image, group//'/end_fraction', progress%ends%fraction)
    call put_array(image, group//'/end_displacement', progress%ends%displacement)
  end subroutine put_ends

  !> Get where the analysis stood.
  subroutine get_progress(reader, group, progress)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    !> Where the analysis stood.
    type(progress_type), intent(inout) :: progress
    integer :: whole, stopped, i

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
    call get_attribute(reader, group, 'force_at_start', progress%force_at_start)
    call get_attribute(reader, group, 'strength_factor', progress%strength_factor)
    call get_attribute(reader, group, 'stable_factor', progress%bracket%stable)
    call get_attribute(reader, group, 'lost_factor', progress%bracket%lost)
    do i = 1, size(progress%bracket%lost_above)
      call get_attribute(reader, group, 'lost_factor_above_'//integer_text(i), progress%bracket%lost_above(i))
    end do
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
      call get_attribute(reader, group, 'most_compliance', limit%most)
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
end module qsmpm_restart_progress
