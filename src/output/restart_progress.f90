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

  !> A number in the file: one of the three is where it lies.
  type :: number_type
    character(len=24) :: name
    integer, pointer :: whole => null()
    real(wp), pointer :: real => null()
    logical, pointer :: yes => null()
  end type number_type

contains

  !> Put where the analysis stands.
  subroutine put_progress(image, group, progress)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    !> Where the analysis stands.
    type(progress_type), intent(in), target :: progress
    type(number_type), allocatable :: list(:)
    logical, target :: has_ends
    integer :: i

    call put_group(image, group)
    has_ends = allocated(progress%ends)
    call list_numbers(progress, has_ends, list)
    do i = 1, size(list)
      associate (number => list(i))
        if (associated(number%whole)) call put_attribute(image, group, trim(number%name), number%whole)
        if (associated(number%real)) call put_attribute(image, group, trim(number%name), number%real)
        if (associated(number%yes)) call put_attribute(image, group, trim(number%name), merge(1, 0, number%yes))
      end associate
    end do
    if (allocated(progress%factors)) call put_array(image, group//'/factors', progress%factors)
    if (.not. has_ends) return
    call put_array(image, group//'/end_reason', progress%ends%reason)
    call put_array(image, group//'/end_fraction', progress%ends%fraction)
    call put_array(image, group//'/end_displacement', progress%ends%displacement)
  end subroutine put_progress

  !> Get where the analysis stood.
  subroutine get_progress(reader, group, progress)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    !> Where the analysis stood.
    type(progress_type), intent(inout), target :: progress
    type(number_type), allocatable :: list(:)
    logical, target :: has_ends
    integer :: i, found

    call list_numbers(progress, has_ends, list)
    do i = 1, size(list)
      associate (number => list(i))
        found = 0
        if (associated(number%whole)) call get_attribute(reader, group, trim(number%name), number%whole)
        if (associated(number%real)) call get_attribute(reader, group, trim(number%name), number%real)
        if (associated(number%yes)) call get_attribute(reader, group, trim(number%name), found)
        if (associated(number%yes)) number%yes = found == 1
      end associate
    end do
    if (allocated(progress%factors)) deallocate (progress%factors)
    call get_array(reader, group//'/factors', progress%factors)
    if (allocated(progress%ends)) deallocate (progress%ends)
    if (has_ends) call get_ends(reader, group, progress)
  end subroutine get_progress

  !> All numbers of the progress in the order of the file.
  subroutine list_numbers(progress, has_ends, list)
    type(progress_type), intent(in), target :: progress
    !> Whether phases have ended.
    logical, intent(in), target :: has_ends
    type(number_type), allocatable, intent(out) :: list(:)
    integer :: i

    associate (p => progress, bracket => progress%bracket, limit => progress%limit)
      list = [ &
        number_type('phase', whole=p%phase), number_type('step', whole=p%step), &
        number_type('phase_steps', whole=p%phase_steps), number_type('fraction', real=p%fraction), &
        number_type('load_factor', real=p%load_factor), number_type('next_step', real=p%next_step), &
        number_type('damping', real=p%damping), number_type('failed_solvers', whole=p%failed_solvers), &
        number_type('undamped_newton', yes=p%undamped_newton), number_type('external_work', real=p%external_work), &
        number_type('internal_work', real=p%internal_work), &
        number_type('constant_load_tests_done', whole=p%constant_load_tests_done), &
        number_type('release_left', real=p%release_left), number_type('own_settlement', real=p%own_settlement), &
        number_type('force_at_start', real=p%force_at_start), number_type('strength_factor', real=p%strength_factor), &
        number_type('stable_factor', real=bracket%stable), number_type('lost_factor', real=bracket%lost), &
        (number_type('lost_factor_above_'//integer_text(i), real=bracket%lost_above(i)), &
        i=1, size(bracket%lost_above)), &
        number_type('factor_increment', real=bracket%increment), number_type('stopped', yes=p%stopped), &
        number_type('ends', yes=has_ends), number_type('first_compliance', real=limit%first), &
        number_type('last_compliance', real=limit%last), number_type('last_middle', real=limit%middle), &
        number_type('refused', real=limit%refused), number_type('refused_compliance', real=limit%refused_compliance), &
        number_type('refused_middle', real=limit%refused_middle), number_type('plateau', real=limit%plateau), &
        number_type('most_compliance', real=limit%most), number_type('knee', real=limit%knee)]
    end associate
  end subroutine list_numbers

  !> Get how phases have ended.
  subroutine get_ends(reader, group, progress)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    type(progress_type), intent(inout) :: progress
    integer, allocatable :: reason(:)
    real(wp), allocatable :: fraction(:), displacement(:)
    logical :: whole
    integer :: i

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
