!> Writes `curves.csv`: one row per accepted step; the first line has `name [unit]`.
!>
!> Rows are written one by one and are complete whenever the program ends. They are identical in every run of a deck; a
!> run that continues another truncates the file to the rows of the state from which it starts.
!>
!> Also writes the table of phases at the end of the log and in `summary.json`: how each phase has ended, the load
!> factor reached, steps, iterations, the largest residual, the largest displacement and the histories at its end.
!>
!> Steps, iterations, residuals and histories are those of `curves.csv`; the ends of phases are part of the state. The
!> summary of a run that was interrupted and continued is therefore identical. The limit load of the last phase that
!> has one is written to `limit_load.json`.
module qsmpm_summary
  use qsmpm_kinds, only: wp, long
  use qsmpm_analysis, only: analysis_type, axisymmetric, three_dimensional
  use qsmpm_phase_description, only: ended_by_load, ended_by_loss, not_ended, phase_safety
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_file, only: read_text, write_text, file_type, append_file, put_text, flush_file, file_exists
  use qsmpm_limit_load, only: limit_loads, relative_compliance
  use qsmpm_model, only: model_type, phase_end_type
  use qsmpm_number_text, only: integer_text, real_text, newline
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_phase_ends, only: end_of_phase, factor_of_phase, has_start_move, start_move
  use qsmpm_text, only: string_type, json_string, read_real, split, newline
  use qsmpm_unfinished_phases, only: is_loss
  use qsmpm_history_quantities, only: unit_of_history
  use qsmpm_observer, only: step_record_type
  implicit none
  private

  public :: write_summary, summary_table, limit_json, summary_file, begin_curves, continue_curves, append_row

  character(len=*), parameter :: file_name = '/curves.csv'

  character(len=*), parameter :: summary_file = 'summary.json'
  !> How a phase has ended, by the ended_* values from 0.
  character(len=10), parameter :: reasons(0:4) = [character(len=10) :: 'not ended', 'whole load', 'limit load', &
    'stop', 'lost']

  !> Data of a phase from the rows of the curves.
  type :: phase_row_type
    integer :: steps = 0, iterations = 0
    real(wp) :: load_factor = 0.0_wp
    !> Largest residual of its steps.
    real(wp) :: out_of_balance = 0.0_wp
    !> Histories in its last row.
    real(wp), allocatable :: histories(:)
  end type phase_row_type

contains

  !> Starts the table.
  subroutine begin_curves(file, directory, analysis, shares, error)
    !> File of the table.
    type(file_type), intent(out) :: file
    !> Folder of the table.
    character(len=*), intent(in) :: directory
    type(analysis_type), intent(in) :: analysis
    !> Column names of the shares of terms, each preceded by a comma.
    character(len=*), intent(in) :: shares
    !> Set when it cannot be written.
    type(error_type), allocatable, intent(out) :: error

    call append_file(file, directory//file_name, 0_long, error)
    if (allocated(error)) return
    call put_text(file, curves_header(analysis, shares)//newline)
    call flush_file(file, error)
  end subroutine begin_curves

  !> Continues the table after the row of a step; a new table is started if there is none.
  subroutine continue_curves(file, directory, analysis, shares, step, error)
    !> File of the table.
    type(file_type), intent(out) :: file
    !> Folder of the table.
    character(len=*), intent(in) :: directory
    type(analysis_type), intent(in) :: analysis
    !> Column names of the shares of terms, each preceded by a comma.
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

  !> Returns the number of bytes of the first lines of a text, 0 if it has fewer.
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

  !> Appends the row of an accepted step.
  subroutine append_row(file, model, record, error)
    !> File of the table.
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

  !> Returns the header line, without its end.
  pure function curves_header(analysis, shares) result(header)
    type(analysis_type), intent(in) :: analysis
    !> Column names of the shares of terms, each preceded by a comma.
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

  !> Returns the heading of a column.
  pure function column(name, unit) result(text)
    !> Its name; commas and quotes are replaced by blanks, so that commas only separate columns.
    character(len=*), intent(in) :: name
    !> Its unit, empty for a dimensionless number.
    character(len=*), intent(in) :: unit
    character(len=:), allocatable :: text
    integer :: i

    text = trim(name)
    if (len(unit) > 0) text = text//' ['//unit//']'
    do i = 1, len(text)
      if (scan(text(i:i), ',"'//newline) > 0) text(i:i) = ' '
    end do
  end function column

  !> Returns whether the analysis has contact between soil and rigid bodies.
  pure logical function has_contacts(analysis)
    type(analysis_type), intent(in) :: analysis

    has_contacts = .false.
    if (allocated(analysis%contacts)) has_contacts = size(analysis%contacts) > 0
  end function has_contacts

  !> Returns the unit of length.
  pure function length_unit(analysis) result(unit)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: unit

    unit = ''
    if (has_units(analysis)) unit = analysis%length_unit
  end function length_unit

  !> Returns the unit of work.
  pure function work_unit(analysis) result(unit)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: unit, text

    unit = ''
    if (.not. has_units(analysis)) return
    ! Reference of a force in the model: none, the thickness, a radian.
    if (analysis%model == three_dimensional) then
      text = ''
    else if (analysis%model == axisymmetric) then
      text = '/rad'
    else
      text = '/'//analysis%length_unit
    end if
    unit = analysis%force_unit//' '//analysis%length_unit//text
  end function work_unit

  !> Returns whether the deck defines its units.
  pure logical function has_units(analysis)
    type(analysis_type), intent(in) :: analysis

    has_units = allocated(analysis%length_unit) .and. allocated(analysis%force_unit)
    if (has_units) has_units = len(analysis%length_unit) > 0 .and. len(analysis%force_unit) > 0
  end function has_units

  !> Writes summary.json.
  subroutine write_summary(directory, analysis, model, error, outcome)
    !> Folder of the run with its curves.
    character(len=*), intent(in) :: directory
    type(analysis_type), intent(in) :: analysis
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error
    !> Error that ended the run early.
    type(error_type), intent(in), optional :: outcome
    type(phase_row_type) :: rows(size(analysis%phases))
    character(len=:), allocatable :: text
    integer :: p

    call read_rows(directory, analysis, rows, error)
    if (allocated(error)) return
    text = '{'//newline//'  "phases": ['
    do p = 1, size(rows)
      if (p > 1) text = text//','
      text = text//newline//phase_json(analysis, p, rows(p), shown_end(model, p, outcome), &
        factor_of_phase(model%state%progress, p), start_json(model, p))
    end do
    text = text//newline//'  ]'//newline//'}'//newline
    call write_text(directory//'/'//summary_file, text, error)
  end subroutine write_summary

  !> Returns the end of a phase. A phase whose failure ends the run has no end: its step can be repeated.
  pure type(phase_end_type) function shown_end(model, phase, outcome) result(ended)
    type(model_type), intent(in) :: model
    integer, intent(in) :: phase
    !> Error that ended the run early.
    type(error_type), intent(in), optional :: outcome

    ended = end_of_phase(model%state%progress, phase)
    if (.not. present(outcome) .or. ended%reason /= not_ended .or. phase /= model%state%progress%phase) return
    if (is_loss(outcome)) ended%reason = ended_by_loss
  end function shown_end

  !> Returns a phase as a JSON object.
  pure function phase_json(analysis, phase, row, ended, factor, start) result(text)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: phase
    type(phase_row_type), intent(in) :: row
    type(phase_end_type), intent(in) :: ended
    !> Factor of safety: stable and failed value; zeros for none.
    real(wp), intent(in) :: factor(2)
    !> Further members, each preceded by a comma.
    character(len=*), intent(in) :: start
    character(len=:), allocatable :: text
    integer :: i

    text = '    {"name": '//json_string(name_of(analysis, phase))//', '//parent_json(analysis, phase)// &
      factor_json(factor)//'"ended_by": '// &
      json_string(trim(reason_of(ended, row%steps, factor)))//', "load_factor": '//real_text(row%load_factor)//','// &
      newline// &
      '     "steps": '//integer_text(row%steps)//', "iterations": '//integer_text(row%iterations)// &
      ', "out_of_balance": '//real_text(row%out_of_balance)//', "largest_displacement": '// &
      real_text(ended%displacement)//start//','//newline//'     "histories": {'
    if (allocated(row%histories)) then
      do i = 1, size(row%histories)
        if (i > 1) text = text//', '
        text = text//json_string(analysis%histories(i)%name)//': '//real_text(row%histories(i))
      end do
    end if
    text = text//'}}'
  end function phase_json

  !> Returns the largest displacement of a first phase with K0 stresses relative to gamma H^2/M; empty for others.
  pure function start_json(model, phase) result(text)
    type(model_type), intent(in) :: model
    integer, intent(in) :: phase
    character(len=:), allocatable :: text

    text = ''
    if (phase == 1 .and. has_start_move(model%state%progress)) text = ', "start_move": '// &
      real_text(start_move(model%state%progress))
  end function start_json

  !> Returns how a phase has ended, as text.
  pure function reason_of(ended, steps, factor) result(words)
    type(phase_end_type), intent(in) :: ended
    !> Number of its steps.
    integer, intent(in) :: steps
    !> Factor of safety (stable, failed); zeros for none.
    real(wp), intent(in) :: factor(2)
    character(len=10) :: words

    words = reasons(ended%reason)
    if (ended%reason == not_ended .and. steps == 0) words = 'not run'
    if (factor(1) > 0.0_wp .and. ended%reason == ended_by_load) words = 'factor'
  end function reason_of

  !> Returns the name of a phase, or its number if it has no name.
  pure function name_of(analysis, phase) result(name)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: phase
    character(len=:), allocatable :: name

    name = integer_text(phase)
    if (allocated(analysis%phases(phase)%name)) name = analysis%phases(phase)%name
  end function name_of

  !> Returns the parent of a phase, if the deck names it.
  pure function parent_json(analysis, phase) result(text)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: phase
    character(len=:), allocatable :: text

    text = ''
    if (.not. allocated(analysis%phases(phase)%parent)) return
    if (len(analysis%phases(phase)%parent) > 0) text = '"parent": '//json_string(analysis%phases(phase)%parent)//', '
  end function parent_json

  !> Returns the factor of safety, if any: stable and failed value, the latter null if failure was not found.
  pure function factor_json(factor) result(text)
    real(wp), intent(in) :: factor(2)
    character(len=:), allocatable :: text

    text = ''
    if (.not. factor(1) > 0.0_wp) return
    text = '"factor": ['//real_text(factor(1))//', null], '
    if (factor(2) > 0.0_wp) text = '"factor": ['//real_text(factor(1))//', '//real_text(factor(2))//'], '
  end function factor_json

  !> Returns the limit load of the phase that has ended.
  pure function limit_json(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    real(wp) :: loads(4)

    associate (progress => model%state%progress)
      loads = limit_loads(progress%limit, progress%fraction, model%analysis%phases(progress%phase)%load_factor)
      text = '{'//newline//'  "phase": '//integer_text(progress%phase)//','//newline// &
        '  "carried": '//real_text(loads(1))//','//newline//'  "refused": '//real_text(loads(2))//','//newline// &
        '  "knee": '//real_text(loads(3))//','//newline//'  "plateau": '//real_text(loads(4))//newline//'}'//newline
    end associate
  end function limit_json

  !> Returns the table for the log, one line per phase.
  subroutine summary_table(directory, analysis, model, text, error, outcome)
    !> Folder of the run with its curves.
    character(len=*), intent(in) :: directory
    type(analysis_type), intent(in) :: analysis
    type(model_type), intent(in) :: model
    character(len=:), allocatable, intent(out) :: text
    type(error_type), allocatable, intent(out) :: error
    !> Error that ended the run early.
    type(error_type), intent(in), optional :: outcome
    type(phase_row_type) :: rows(size(analysis%phases))
    type(phase_end_type) :: ended
    real(wp) :: factor(2)
    integer :: p

    text = line_of('phase', 'ended by', 'load factor', 'steps', 'iterations', 'residual', 'displacement')
    if (allocated(model%state%progress%factors)) text = text//'  factor of safety'
    call read_rows(directory, analysis, rows, error)
    if (allocated(error)) return
    do p = 1, size(rows)
      ended = shown_end(model, p, outcome)
      factor = factor_of_phase(model%state%progress, p)
      text = text//newline//line_of(name_of(analysis, p), reason_of(ended, rows(p)%steps, factor), &
        rounded_text(rows(p)%load_factor, 4), integer_text(rows(p)%steps), integer_text(rows(p)%iterations), &
        rounded_text(rows(p)%out_of_balance, 2), rounded_text(ended%displacement, 4)) &
        //factor_text(factor)
    end do
  end subroutine summary_table

  !> Returns a factor of safety for the table: an interval if failure was observed, otherwise a lower bound.
  pure function factor_text(factor) result(text)
    !> Stable and failed value.
    real(wp), intent(in) :: factor(2)
    character(len=:), allocatable :: text

    text = ''
    if (.not. factor(1) > 0.0_wp) return
    text = '  at least '//rounded_text(factor(1), 5)
    if (factor(2) > 0.0_wp) text = '  '//rounded_text(factor(1), 5)//' to '//rounded_text(factor(2), 5)
  end function factor_text

  !> Returns a line of the table.
  pure function line_of(name, ended, load, steps, iterations, residual, displacement) result(line)
    character(len=*), intent(in) :: name, ended, load, steps, iterations, residual, displacement
    character(len=:), allocatable :: line
    character(len=max(16, len(name))) :: first

    first = name
    line = first//'  '//padded(ended, 10)//padded(load, 13)//padded(steps, 7)//padded(iterations, 12)// &
      padded(residual, 11)//padded(displacement, 14)
  end function line_of

  !> Returns a word aligned at the right of a field.
  pure function padded(word, places) result(text)
    character(len=*), intent(in) :: word
    integer, intent(in) :: places
    character(len=:), allocatable :: text

    text = repeat(' ', max(1, places - len_trim(word)))//trim(word)
  end function padded

  !> Reads the phases from the rows of the curves.
  subroutine read_rows(directory, analysis, rows, error)
    character(len=*), intent(in) :: directory
    type(analysis_type), intent(in) :: analysis
    type(phase_row_type), intent(out) :: rows(:)
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: text
    integer :: start, last

    call read_text(directory//'/curves.csv', text, error)
    if (allocated(error)) return
    start = index(text, newline) + 1
    do while (start <= len(text))
      last = index(text(start:), newline) + start - 2
      if (last < start) exit
      call add_row(text(start:last), size(analysis%histories), rows)
      start = last + 2
    end do
  end subroutine read_rows

  !> Adds a row of the curves to its phase: phase, step, load factor, iterations and residual are the first columns;
  !> the histories precede the last two columns, which are the works.
  subroutine add_row(line, histories, rows)
    character(len=*), intent(in) :: line
    !> Number of histories.
    integer, intent(in) :: histories
    type(phase_row_type), intent(inout) :: rows(:)
    type(string_type), allocatable :: cells(:)
    real(wp), allocatable :: values(:)
    integer :: i, outcome

    call split(line, ',', cells)
    allocate (values(size(cells)))
    do i = 1, size(cells)
      call read_real(cells(i)%text, values(i), outcome)
    end do
    associate (row => rows(nint(values(1))))
      row%steps = row%steps + 1
      row%load_factor = values(3)
      row%iterations = row%iterations + nint(values(4))
      row%out_of_balance = max(row%out_of_balance, values(5))
      row%histories = values(size(values) - 1 - histories:size(values) - 2)
    end associate
  end subroutine add_row
end module qsmpm_summary
