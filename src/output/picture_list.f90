!> List of the pictures of a run and the ParaView collections (.pvd) that contain their names and times.
!>
!> A run that continues another reads the list from `points.pvd` and omits the pictures of steps that will be repeated.
!>
!> Writes the pictures and results of a state together with their lists. Every process of a team takes part: if the
!> model is divided each writes its part, otherwise the first one writes everything.
!>
!> Also writes the files of safety phases: `safety.json` with the factors found so far, and pictures of the failure
!> mechanism.
module qsmpm_picture_list
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_file, only: file_type, create_file, put_text, commit_file, read_text, write_text
  use qsmpm_number_text, only: numbered, real_text, integer_text, newline
  use qsmpm_text, only: newline, string_type
  use qsmpm_agreement, only: agree
  use qsmpm_fields, only: phase_time
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: is_divided
  use qsmpm_results, only: write_results_index, write_state, mechanism_part, write_points_picture, write_mesh_picture
  use qsmpm_stress_error, only: stress_error_type
  use qsmpm_team, only: team_type
  use qsmpm_phase_description, only: geometry_fixed
  use qsmpm_strength_factor, only: flow_words
  implicit none
  private

  public :: picture_list_type, read_collection, write_fields, write_safety

  !> Pictures in the order of their steps.
  type :: picture_list_type
    integer, allocatable :: steps(:)
    !> Times (qsmpm_fields: phase_time) as text, since the collections are rewritten after each picture.
    type(string_type), allocatable :: times(:)
  end type picture_list_type

  !> Text before the time and before the step in a line of a collection.
  character(len=*), parameter :: time_mark = 'timestep="', step_mark = 'file="points_'

  character(len=*), parameter, public :: safety_file = 'safety.json'

contains

  !> Adds a picture; a picture of the same step is replaced.
  pure subroutine add_picture(list, step, time)
    type(picture_list_type), intent(inout) :: list
    !> Accepted steps so far.
    integer, intent(in) :: step
    !> Time of the picture.
    real(wp), intent(in) :: time
    logical, allocatable :: keep(:)
    type(string_type), allocatable :: times(:)
    integer :: i, kept

    if (.not. allocated(list%steps)) allocate (list%steps(0), list%times(0))
    keep = list%steps < step
    list%steps = [pack(list%steps, keep), step]
    kept = count(keep)
    allocate (times(kept + 1))
    do i = 1, kept
      call move_alloc(list%times(i)%text, times(i)%text)
    end do
    times(kept + 1)%text = real_text(time)
    call move_alloc(times, list%times)
  end subroutine add_picture

  !> Writes the collection of one kind of picture.
  subroutine write_collection(list, directory, kind, error)
    type(picture_list_type), intent(in) :: list
    !> Folder of the pictures; `points` or `mesh`.
    character(len=*), intent(in) :: directory, kind
    !> Set when the file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error
    type(file_type) :: file
    integer :: i

    call create_file(file, directory//'/'//kind//'.pvd')
    call put_text(file, '<?xml version="1.0"?>'//newline// &
      '<VTKFile type="Collection" version="0.1">'//newline//'  <Collection>'//newline)
    do i = 1, size(list%steps)
      call put_text(file, '    <DataSet '//time_mark//list%times(i)%text// &
        '" group="" part="0" file="'//kind//'_'//numbered(list%steps(i))//'.vtu"/>'//newline)
    end do
    call put_text(file, '  </Collection>'//newline//'</VTKFile>'//newline)
    call commit_file(file, error)
  end subroutine write_collection

  !> Reads the list up to a step.
  subroutine read_collection(list, directory, last_step, error)
    type(picture_list_type), intent(out) :: list
    !> Folder of the pictures.
    character(len=*), intent(in) :: directory
    !> Pictures of later steps are omitted.
    integer, intent(in) :: last_step
    !> Set when the collection cannot be read.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: text
    integer :: first, last

    allocate (list%steps(0), list%times(0))
    call read_text(directory//'/points.pvd', text, error)
    if (allocated(error)) return
    first = 1
    do while (first <= len(text))
      last = first + index(text(first:), newline) - 1
      if (last < first) last = len(text)
      call read_line(list, text(first:last), last_step)
      first = last + 1
    end do
  end subroutine read_collection

  !> Adds the picture named in a line of the collection, if any.
  pure subroutine read_line(list, line, last_step)
    type(picture_list_type), intent(inout) :: list
    character(len=*), intent(in) :: line
    !> Pictures of later steps are omitted.
    integer, intent(in) :: last_step
    integer :: step, status(2)
    real(wp) :: time
    character(len=:), allocatable :: word

    if (index(line, time_mark) == 0 .or. index(line, step_mark) == 0) return
    word = line(index(line, time_mark) + len(time_mark):)
    read (word(:scan(word, '"') - 1), *, iostat=status(1)) time
    word = line(index(line, step_mark) + len(step_mark):)
    read (word(:scan(word, '.') - 1), *, iostat=status(2)) step
    if (any(status /= 0)) return
    if (step <= last_step) call add_picture(list, step, time)
  end subroutine read_line

  !> Writes the pictures and results of a state, or of a failure mechanism, and their lists.
  subroutine write_fields(directory, pictures, team, model, estimate, of_mechanism, error)
    character(len=*), intent(in) :: directory
    !> Pictures so far; that of a state is added.
    type(picture_list_type), intent(inout) :: pictures
    !> Processes that share the run.
    type(team_type), intent(in) :: team
    type(model_type), intent(in) :: model
    !> Estimated error of the stresses.
    type(stress_error_type), intent(in) :: estimate
    !> Whether it is a failure mechanism: its files are numbered by the phase, and no collection contains them.
    logical, intent(in) :: of_mechanism
    !> Set consistently on all processes when a file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: before, number
    logical :: leads, writes

    leads = team%rank == 0
    writes = leads .or. is_divided(model%part)
    associate (progress => model%state%progress, output => model%analysis%output)
      before = ''
      if (of_mechanism) before = mechanism_part
      number = numbered(merge(progress%phase, progress%step, of_mechanism))
      if (.not. of_mechanism) call add_picture(pictures, progress%step, phase_time(model))
      if (output%vtk .and. writes) then
        call write_points_picture(directory, before//'points_'//number, model, estimate, error)
        if (.not. allocated(error)) call write_mesh_picture(directory, before//'mesh_'//number, model, error)
      end if
      if (output%vtk .and. leads .and. .not. of_mechanism) then
        if (.not. allocated(error)) call write_collection(pictures, directory, 'points', error)
        if (.not. allocated(error)) call write_collection(pictures, directory, 'mesh', error)
      end if
      call agree(team, error)
      if (allocated(error) .or. .not. output%hdf5) return
      if (writes) call write_state(directory, before//number, model, estimate, error)
      if (leads .and. .not. allocated(error) .and. allocated(pictures%steps)) &
        call write_results_index(directory, pictures%steps, error, size(model%analysis%phases))
      call agree(team, error)
    end associate
  end subroutine write_fields

  !> Writes the factors of safety found so far.
  subroutine write_safety(directory, model, error)
    character(len=*), intent(in) :: directory
    type(model_type), intent(in) :: model
    !> Set when the file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: text
    integer :: i

    text = '{'//newline//'  "phases": ['
    associate (factors => model%state%progress%factors)
      do i = 1, size(factors, 2)
        if (i > 1) text = text//','
        text = text//newline//'    '//factor_json(model, factors(:, i))
      end do
    end associate
    call write_text(directory//'/'//safety_file, text//newline//'  ]'//newline//'}'//newline, error)
  end subroutine write_safety

  !> Returns the factor of safety of a phase. A factor without equilibrium but without an observed mechanism is
  !> `refused`, not `lost`.
  pure function factor_json(model, row) result(text)
    type(model_type), intent(in) :: model
    !> Row of the factors (qsmpm_safety_factors).
    real(wp), intent(in) :: row(:)
    character(len=:), allocatable :: text

    associate (phase => model%analysis%phases(nint(row(1))), number => nint(row(1)), stable => row(2), lost => row(3))
      text = '{"phase": "'//phase%name//'", "number": '//integer_text(number)//', "flow": "'// &
        trim(flow_words(phase%safety%flow))//'", "geometry": "'// &
        trim(merge('FIXED ', 'MOVING', phase%safety%geometry == geometry_fixed))//'", "stable": '//real_text(stable)// &
        ', "lost": '
      if (row(4) > 0.0_wp) then
        text = text//real_text(lost)//', "mechanism": true}'
      else
        text = text//'null, "mechanism": false'
        if (lost > 0.0_wp) text = text//', "refused": '//real_text(lost)
        text = text//'}'
      end if
    end associate
  end function factor_json
end module qsmpm_picture_list
