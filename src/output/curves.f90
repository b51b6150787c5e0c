!> `curves.csv`: one row an accepted step, first line `name [unit]`.
!>
!> Rows are brought to the file one by one and are whole whenever the program ends. They are the same
!> bytes in every run of a deck; a run that continues another cuts the file back to the rows of the
!> state it starts from.
module qsmpm_curves
  use qsmpm_kinds, only: long
  use qsmpm_analysis, only: analysis_type, axisymmetric, three_dimensional
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_file, only: file_type, append_file, put_text, flush_file, file_exists, read_text
  use qsmpm_history_quantities, only: unit_of_history
  use qsmpm_limit_load, only: relative_compliance
  use qsmpm_model, only: model_type
  use qsmpm_number_text, only: integer_text, newline, real_text
  use qsmpm_observer, only: step_record_type
  implicit none
  private

  public :: begin_curves, continue_curves, append_row

  character(len=*), parameter :: file_name = '/curves.csv'

contains

  !> Begin the table.
  subroutine begin_curves(file, directory, analysis, shares, error)
    !> The table.
    type(file_type), intent(out) :: file
    !> Where it stands.
    character(len=*), intent(in) :: directory
    type(analysis_type), intent(in) :: analysis
    !> Columns of the shares of terms, a comma in front of each.
    character(len=*), intent(in) :: shares
    !> Set when it cannot be written.
    type(error_type), allocatable, intent(out) :: error

    call append_file(file, directory//file_name, 0_long, error)
    if (allocated(error)) return
    call put_text(file, curves_header(analysis, shares)//newline)
    call flush_file(file, error)
  end subroutine begin_curves

  !> Go on with the table behind the row of a step; without a table one is begun.
  subroutine continue_curves(file, directory, analysis, shares, step, error)
    !> The table.
    type(file_type), intent(out) :: file
    !> Where it stands.
    character(len=*), intent(in) :: directory
    type(analysis_type), intent(in) :: analysis
    !> Columns of the shares of terms, a comma in front of each.
    character(len=*), intent(in) :: shares
    !> Accepted steps so far, each of which has a row.
    integer, intent(in) :: step
    !> Set when the table is of another analysis, too short, or cannot be written.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: text, header
    integer(long) :: length

    if (.not. file_exists(directory//file_name)) then
      call begin_curves(file, directory, analysis, shares, error)
      return
    end if
    call read_text(directory//file_name, text, error)
    if (allocated(error)) return
    header = curves_header(analysis, shares)//newline
    length = length_of_lines(text, step + 1)
    if (length == 0 .or. index(text, header) /= 1) then
      call fail(error, error_other, "cannot continue '"//directory//file_name// &
        "': it is not the table of the run that is restarted (give another directory)")
      return
    end if
    call append_file(file, directory//file_name, length, error)
  end subroutine continue_curves

  !> Bytes of the first lines of a text, 0 when it has fewer.
  pure integer(long) function length_of_lines(text, count)
    character(len=*), intent(in) :: text
    !> Number of lines.
    integer, intent(in) :: count
    integer :: line, gap

    length_of_lines = 0
    do line = 1, count
      gap = index(text(length_of_lines + 1:), newline)
      if (gap == 0) then
        length_of_lines = 0
        return
      end if
      length_of_lines = length_of_lines + gap
    end do
  end function length_of_lines

  !> Add the row of an accepted step.
  subroutine append_row(file, model, record, error)
    !> The table.
    type(file_type), intent(inout) :: file
    type(model_type), intent(in) :: model
    type(step_record_type), intent(in) :: record
    !> Set when the row could not be written.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: row
    integer :: i

    associate (progress => model%state%progress)
      row = integer_text(progress%phase)//','//integer_text(progress%step)//','// &
        real_text(progress%load_factor)//','//integer_text(record%iterations)//','//real_text(record%out_of_balance)
      if (allocated(record%shares)) then
        do i = 1, size(record%shares)
          row = row//','//real_text(record%shares(i)%share)
        end do
      end if
      if (any(model%analysis%phases%kind == phase_safety)) row = row//','//real_text(progress%strength_factor)
      row = row//','//integer_text(record%inaccurate_points)//','//real_text(record%step_error)//','// &
        real_text(relative_compliance(progress%limit))
      if (has_contacts(model%analysis)) row = row//','//real_text(record%penetration%depth)//','// &
        real_text(record%penetration%gap)
      if (allocated(record%histories)) then
        do i = 1, size(record%histories)
          row = row//','//real_text(record%histories(i))
        end do
      end if
      row = row//','//real_text(progress%external_work)//','//real_text(progress%internal_work)
    end associate
    call put_text(file, row//newline)
    call flush_file(file, error)
  end subroutine append_row

  !> The first line, without its end.
  pure function curves_header(analysis, shares) result(header)
    type(analysis_type), intent(in) :: analysis
    !> Columns of the shares of terms, a comma in front of each.
    character(len=*), intent(in) :: shares
    character(len=:), allocatable :: header
    integer :: i

    header = 'phase,step,load_factor,iterations,out_of_balance'//shares
    if (any(analysis%phases%kind == phase_safety)) header = header//',F'
    header = header//',inaccurate_points,step_error,compliance'
    if (has_contacts(analysis)) header = header//','//column('soil_inside_bodies', length_unit(analysis))//','// &
      column('soil_away_from_bodies', length_unit(analysis))
    if (allocated(analysis%histories)) then
      do i = 1, size(analysis%histories)
        header = header//','//column(analysis%histories(i)%name, unit_of_history(analysis, analysis%histories(i)))
      end do
    end if
    header = header//','//column('external_work', work_unit(analysis))//','// &
      column('internal_work', work_unit(analysis))
  end function curves_header

  !> Head of a column.
  pure function column(name, unit) result(text)
    !> Its name; commas and quotes become blanks, so that a row has a number for each comma.
    character(len=*), intent(in) :: name
    !> Its unit, empty for a number without one.
    character(len=*), intent(in) :: unit
    character(len=:), allocatable :: text
    integer :: i

    text = trim(name)
    if (len(unit) > 0) text = text//' ['//unit//']'
    do i = 1, len(text)
      if (scan(text(i:i), ',"'//newline) > 0) text(i:i) = ' '
    end do
  end function column

  !> Whether soil and rigid bodies may touch.
  pure logical function has_contacts(analysis)
    type(analysis_type), intent(in) :: analysis

    has_contacts = .false.
    if (allocated(analysis%contacts)) has_contacts = size(analysis%contacts) > 0
  end function has_contacts

  !> Unit of lengths.
  pure function length_unit(analysis) result(unit)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: unit

    unit = ''
    if (has_units(analysis)) unit = analysis%length_unit
  end function length_unit

  !> Unit of work.
  pure function work_unit(analysis) result(unit)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: unit, text

    unit = ''
    if (.not. has_units(analysis)) return
    ! What a force is divided by in the model: nothing, the thickness, a radian.
    if (analysis%model == three_dimensional) then
      text = ''
    else if (analysis%model == axisymmetric) then
      text = '/rad'
    else
      text = '/'//analysis%length_unit
    end if
    unit = analysis%force_unit//' '//analysis%length_unit//text
  end function work_unit

  !> Whether the deck names its units.
  pure logical function has_units(analysis)
    type(analysis_type), intent(in) :: analysis

    has_units = allocated(analysis%length_unit) .and. allocated(analysis%force_unit)
    if (has_units) has_units = len(analysis%length_unit) > 0 .and. len(analysis%force_unit) > 0
  end function has_units
end module qsmpm_curves
