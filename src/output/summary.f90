!> The phases of a run in a table at the end of the log, and for programs in `summary.json`: how each has ended, the
!> load factor it reached, steps, iterations, the worst residual, the largest displacement and the histories at its end.
!>
!> Steps, iterations, residuals and histories are those of `curves.csv`; how phases have ended is part of the state.
!> So the summary of a run that was interrupted and continued has the same bytes. The limit load of the last phase that
!> has one stands in `limit_load.json`.
module qsmpm_summary
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_phase_description, only: ended_by_load, ended_by_loss, not_ended
  use qsmpm_error, only: error_type
  use qsmpm_file, only: read_text, write_text
  use qsmpm_limit_load, only: limit_loads
  use qsmpm_model, only: model_type, phase_end_type
  use qsmpm_number_text, only: integer_text, real_text
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_phase_ends, only: end_of_phase, factor_of_phase, has_start_move, start_move
  use qsmpm_text, only: string_type, json_string, read_real, split, newline
  use qsmpm_unfinished_phases, only: is_loss
  implicit none
  private

  public :: write_summary, summary_table, limit_json, summary_file

  character(len=*), parameter :: summary_file = 'summary.json'
  !> How a phase has ended, by the ended_* values from 0.
  character(len=10), parameter :: reasons(0:4) = [character(len=10) :: 'not ended', 'whole load', 'limit load', &
    'stop', 'lost']

  !> A phase by the rows of the curves.
  type :: phase_row_type
    integer :: steps = 0, iterations = 0
    real(wp) :: load_factor = 0.0_wp
    !> Largest out of balance of its steps.
    real(wp) :: out_of_balance = 0.0_wp
    !> Histories in its last row.
    real(wp), allocatable :: histories(:)
  end type phase_row_type

contains

  !> Write summary.json.
  subroutine write_summary(directory, analysis, model, error, outcome)
    !> Of the run, with its curves.
    character(len=*), intent(in) :: directory
    type(analysis_type), intent(in) :: analysis
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error
    !> What ended the run before its end.
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

  !> How a phase has ended. One whose loss ends the run has no end of its own: the step can be tried again.
  pure type(phase_end_type) function shown_end(model, phase, outcome) result(ended)
    type(model_type), intent(in) :: model
    integer, intent(in) :: phase
    !> What ended the run before its end.
    type(error_type), intent(in), optional :: outcome

    ended = end_of_phase(model%state%progress, phase)
    if (.not. present(outcome) .or. ended%reason /= not_ended .or. phase /= model%state%progress%phase) return
    if (is_loss(outcome)) ended%reason = ended_by_loss
  end function shown_end

  !> A phase as an object.
  pure function phase_json(analysis, phase, row, ended, factor, start) result(text)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: phase
    type(phase_row_type), intent(in) :: row
    type(phase_end_type), intent(in) :: ended
    !> Factor of safety: stable and lost; zeros for none.
    real(wp), intent(in) :: factor(2)
    !> Further members, each behind a comma.
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

  !> Largest displacement of a first phase with K0 stresses over gamma H^2/M; nothing for others.
  pure function start_json(model, phase) result(text)
    type(model_type), intent(in) :: model
    integer, intent(in) :: phase
    character(len=:), allocatable :: text

    text = ''
    if (phase == 1 .and. has_start_move(model%state%progress)) text = ', "start_move": '// &
      real_text(start_move(model%state%progress))
  end function start_json

  !> How a phase has ended, in words.
  pure function reason_of(ended, steps, factor) result(words)
    type(phase_end_type), intent(in) :: ended
    !> Its steps.
    integer, intent(in) :: steps
    !> Factor of safety; zeros for none.
    real(wp), intent(in) :: factor(2)
    character(len=10) :: words

    words = reasons(ended%reason)
    if (ended%reason == not_ended .and. steps == 0) words = 'not run'
    if (factor(1) > 0.0_wp .and. ended%reason == ended_by_load) words = 'factor'
  end function reason_of

  !> Name of a phase; its number where a program has given it none.
  pure function name_of(analysis, phase) result(name)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: phase
    character(len=:), allocatable :: name

    name = integer_text(phase)
    if (allocated(analysis%phases(phase)%name)) name = analysis%phases(phase)%name
  end function name_of

  !> The phase that a phase starts from, where the deck names it.
  pure function parent_json(analysis, phase) result(text)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: phase
    character(len=:), allocatable :: text

    text = ''
    if (.not. allocated(analysis%phases(phase)%parent)) return
    if (len(analysis%phases(phase)%parent) > 0) text = '"parent": '//json_string(analysis%phases(phase)%parent)//', '
  end function parent_json

  !> The factor, where there is one: stable and lost, the latter null where it is at least the former.
  pure function factor_json(factor) result(text)
    real(wp), intent(in) :: factor(2)
    character(len=:), allocatable :: text

    text = ''
    if (.not. factor(1) > 0.0_wp) return
    text = '"factor": ['//real_text(factor(1))//', null], '
    if (factor(2) > 0.0_wp) text = '"factor": ['//real_text(factor(1))//', '//real_text(factor(2))//'], '
  end function factor_json

  !> The limit load of the phase that has ended.
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

  !> The table for the log, a line a phase.
  subroutine summary_table(directory, analysis, model, text, error, outcome)
    !> Of the run, with its curves.
    character(len=*), intent(in) :: directory
    type(analysis_type), intent(in) :: analysis
    type(model_type), intent(in) :: model
    character(len=:), allocatable, intent(out) :: text
    type(error_type), allocatable, intent(out) :: error
    !> What ended the run before its end.
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

  !> A factor of safety in the table: a bracket where the soil was seen to give way, else the least that it is.
  pure function factor_text(factor) result(text)
    !> Stable and lost.
    real(wp), intent(in) :: factor(2)
    character(len=:), allocatable :: text

    text = ''
    if (.not. factor(1) > 0.0_wp) return
    text = '  at least '//rounded_text(factor(1), 5)
    if (factor(2) > 0.0_wp) text = '  '//rounded_text(factor(1), 5)//' to '//rounded_text(factor(2), 5)
  end function factor_text

  !> A line of the table.
  pure function line_of(name, ended, load, steps, iterations, residual, displacement) result(line)
    character(len=*), intent(in) :: name, ended, load, steps, iterations, residual, displacement
    character(len=:), allocatable :: line
    character(len=max(16, len(name))) :: first

    first = name
    line = first//'  '//padded(ended, 10)//padded(load, 13)//padded(steps, 7)//padded(iterations, 12)// &
      padded(residual, 11)//padded(displacement, 14)
  end function line_of

  !> A word at the right of so many places.
  pure function padded(word, places) result(text)
    character(len=*), intent(in) :: word
    integer, intent(in) :: places
    character(len=:), allocatable :: text

    text = repeat(' ', max(1, places - len_trim(word)))//trim(word)
  end function padded

  !> The phases by the rows of the curves.
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

  !> Take a row of the curves to its phase: phase, step, load factor, iterations and residual come first, histories
  !> before the two works that come last.
  subroutine add_row(line, histories, rows)
    character(len=*), intent(in) :: line
    !> Their number.
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
