!> Condition numbers of the equations of a first step when cells are cut ever smaller.
!>
!>   conditioning            the table of all bases with the default ghost penalty
!>   conditioning FACTOR     the same with another factor, or NONE for no stabilisation; nothing is
!>                           judged
!>   conditioning FADE SHARE
!>                           the same with this share of the default, as re-equilibrations with STABILISATION FADE have it; nothing
!>                           is judged
!>   conditioning MODES [FACTOR]
!>                           zero eigenvalues of K of the block cut at its corner by 0.1 and held nowhere, beyond those of
!>                           a rigid body, 3 in the plane and 6 in space; nothing is judged
!>
!> A block of 4 x 4 cells (2 x 2 x 2 in space) on rollers stands in an empty grid. Three kinds of cut:
!>   top      the block reaches by a share of a cell into the next row,
!>   corner   the same to the other sides, too
!>            (at 1e-5 and below the piece at the corner holds no point),
!>   moved    the block of whole cells has moved up until its last points lie a quarter of that beyond
!>            the line; by a whole cell it would have left its base.
!> K is the stiffness of the unstressed linear elastic block (nu 0.3) with the penalty, at the free
!> components. Its condition number is that of the largest to the smallest singular value (LAPACK
!> dsyev), of K scaled symmetrically to a unit diagonal (Jacobi), D^-1/2 K D^-1/2, and of K itself. A
!> basis passes when the scaled number stays below 1e4 for all cuts; that the measure sees cuts is shown
!> once without penalty. Closes with `N passed, N failed`.
program conditioning
  use, intrinsic :: iso_fortran_env, only: error_unit
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type, message_text
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_point_location, only: relocate
  use qsmpm_linear_system, only: end_system
  use qsmpm_initialisation, only: step_type, initialise_step, evaluate_step
  use qsmpm_term, only: increment_type
  use qsmpm_term_sums, only: add_all_blocks, begin_terms
  use qsmpm_law, only: tangent_elastic
  implicit none

  interface
    !> LAPACK: eigenvalues of a symmetric matrix.
    subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
      import :: wp
      character(len=1), intent(in) :: jobz, uplo
      integer, intent(in) :: n, lda, lwork
      real(wp), intent(inout) :: a(lda, *)
      real(wp), intent(out) :: w(*), work(*)
      integer, intent(out) :: info
    end subroutine dsyev
  end interface

  !> What is tried: element, basis, integration.
  character(len=8), parameter :: bases(3, 19) = reshape([character(len=8) :: &
    'QUAD4', 'STANDARD', 'POINTS', 'QUAD4', 'STANDARD', 'CELL', 'TRI3', 'STANDARD', 'POINTS', &
    'TRI3', 'STANDARD', 'CELL', 'TRI6', 'STANDARD', 'POINTS', 'TRI6', 'STANDARD', 'CELL', &
    'QUAD4', 'GIMP', 'POINTS', 'QUAD4', 'GIMP', 'CELL', 'QUAD4', 'SPLINE2', 'POINTS', &
    'QUAD4', 'SPLINE2', 'CELL', 'QUAD4', 'SPLINE2G', 'POINTS', 'QUAD4', 'SPLINE2G', 'CELL', &
    'QUAD4', 'SPLINE3', 'POINTS', 'QUAD4', 'SPLINE3', 'CELL', 'HEX8', 'STANDARD', 'POINTS', &
    'HEX8', 'STANDARD', 'CELL', 'HEX8', 'GIMP', 'POINTS', 'HEX8', 'SPLINE2', 'CELL', &
    'HEX8', 'SPLINE2G', 'POINTS'], [3, 19])
  character(len=6), parameter :: kinds(3) = ['top   ', 'corner', 'moved ']
  real(wp), parameter :: cuts(7) = [1.0_wp, 1.0e-1_wp, 1.0e-2_wp, 1.0e-3_wp, 1.0e-4_wp, 1.0e-5_wp, 1.0e-6_wp]
  real(wp), parameter :: target_number = 1.0e4_wp
  !> Share of the largest eigenvalue below which one is zero: round-off leaves 1e-16, the weakest mode 1e-6.
  real(wp), parameter :: zero_share = 1.0e-10_wp

  character(len=32) :: factor, share
  real(wp) :: scaled(size(cuts)), plain(size(cuts)), worst, worst_plain, fade
  integer :: b, k, c, passed, failed

  factor = ''
  fade = 1.0_wp
  if (command_argument_count() > 0) call get_command_argument(1, factor)
  if (factor == 'FADE') then
    call get_command_argument(2, share)
    read (share, *) fade
    factor = ''
  end if
  if (factor == 'MODES') then
    factor = ''
    if (command_argument_count() > 1) call get_command_argument(2, factor)
    do b = 1, size(bases, 2)
      write (*, '(a,2(1x,a),a,i0)') (trim(bases(k, b)), k=1, 3), ': spurious modes ', spurious_modes(bases(:, b))
    end do
    stop
  end if
  passed = 0
  failed = 0
  write (*, '(a)') 'Condition numbers by cut, scaled to a unit diagonal, then as they are'
  write (*, '(a,t37,7es9.0)') 'element basis    integration cut', cuts
  do b = 1, size(bases, 2)
    worst = 0.0_wp
    worst_plain = 0.0_wp
    do k = 1, size(kinds)
      do c = 1, size(cuts)
        call condition_numbers(bases(:, b), kinds(k), cuts(c), scaled(c), plain(c))
      end do
      worst = max(worst, maxval(scaled))
      worst_plain = max(worst_plain, maxval(plain))
      write (*, '(3a9,a7,t37,7es9.1,a,7es9.1)') bases(:, b), kinds(k), scaled, '  |', plain
    end do
    if (len_trim(factor) > 0) cycle
    if (fade < 1.0_wp) then
      write (*, '(a,3(1x,a),2(a,es8.1))') 'at most', (trim(bases(k, b)), k=1, 3), ': scaled', worst, ', as they are', &
        worst_plain
      cycle
    end if
    if (worst <= target_number) then
      passed = passed + 1
      write (*, '(a,3(1x,a),a,es8.1)') 'ok    ', (trim(bases(k, b)), k=1, 3), ': at most', worst
    else
      failed = failed + 1
      write (*, '(a,3(1x,a),a,es8.1)') 'FAILED', (trim(bases(k, b)), k=1, 3), ': up to', worst
    end if
  end do
  if (len_trim(factor) == 0 .and. .not. fade < 1.0_wp) then
    factor = 'NONE'
    ! A unit diagonal hides the smallest cuts of splines and TRI3, not those of QUAD4.
    call condition_numbers(bases(:, 1), 'top', cuts(7), scaled(1), plain(1))
    if (scaled(1) > 1.0e10_wp) then
      passed = passed + 1
      write (*, '(a,es8.1)') 'ok     without the penalty the smallest cut of QUAD4 shows:', scaled(1)
    else
      failed = failed + 1
      write (*, '(a,es8.1)') 'FAILED without the penalty the smallest cut of QUAD4 does not show:', scaled(1)
    end if
    write (*, '(i0,a,i0,a)') passed, ' passed, ', failed, ' failed'
  end if
  if (failed > 0) stop 1

contains

  !> Condition numbers of one block.
  subroutine condition_numbers(basis, kind, cut, scaled, plain)
    !> Element, basis, integration.
    character(len=*), intent(in) :: basis(3), kind
    !> Share of a cell.
    real(wp), intent(in) :: cut
    real(wp), intent(out) :: scaled, plain
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: matrix(:, :), roots(:)
    integer :: i

    allocate (model, step)
    call build_block(basis, kind, cut, model)
    call start_phase(model)
    if (kind == 'moved') call move_up(0.25_wp*cut, model)
    call stiffness(model, step, matrix)
    plain = condition(matrix)
    allocate (roots(size(matrix, 1)))
    do i = 1, size(roots)
      roots(i) = sqrt(matrix(i, i))
    end do
    do i = 1, size(roots)
      matrix(:, i) = matrix(:, i)/(roots*roots(i))
    end do
    scaled = condition(matrix)
    call end_system(step%system)
  end subroutine condition_numbers

  !> K of the elastic block at rest.
  subroutine stiffness(model, step, matrix)
    type(model_type), intent(inout) :: model
    !> The step it is taken from.
    type(step_type), intent(out) :: step
    real(wp), allocatable, intent(out) :: matrix(:, :)
    type(error_type), allocatable :: error
    real(wp), allocatable :: still(:, :)

    call initialise_step(model, step, error)
    call give_up(error)
    call begin_terms(step%terms, increment_type(stabilisation=fade))
    allocate (still(model%mesh%dimension, model%space%node_count), source=0.0_wp)
    call evaluate_step(model, step, still, tangent_elastic)
    call add_all_blocks(step%terms, still, step%equations, step%matrix)
    call make_dense(step, matrix)
  end subroutine stiffness

  !> Zero eigenvalues of a free block beyond those of a rigid body.
  integer function spurious_modes(basis)
    !> Element, basis, integration.
    character(len=*), intent(in) :: basis(3)
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: matrix(:, :), values(:)

    allocate (model, step)
    call build_block(basis, 'corner', 0.1_wp, model, free=.true.)
    call start_phase(model)
    call stiffness(model, step, matrix)
    allocate (values(size(matrix, 1)))
    call eigenvalues(matrix, values)
    spurious_modes = count(abs(values) < zero_share*maxval(abs(values))) - merge(6, 3, basis(1) == 'HEX8')
    call end_system(step%system)
  end function spurious_modes

  !> The model of a block.
  subroutine build_block(basis, kind, cut, model, free)
    character(len=*), intent(in) :: basis(3), kind
    real(wp), intent(in) :: cut
    type(model_type), intent(out) :: model
    !> Held nowhere.
    logical, intent(in), optional :: free
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: text
    character(len=80) :: box
    real(wp) :: high(3), size_of_block

    allocate (analysis)
    size_of_block = merge(2.0_wp, 4.0_wp, basis(1) == 'HEX8')
    high = size_of_block
    if (kind == 'corner') high = high + cut
    if (kind == 'top') high(merge(3, 2, basis(1) == 'HEX8')) = size_of_block + cut
    write (box, '(3(a,es22.15))') '0,', high(1), ',0,', high(2)
    if (basis(1) == 'HEX8') write (box, '(3(a,es22.15))') '0,', high(1), ',0,', high(2), ',0,', high(3)
    text = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT='//trim(basis(1))//'|X, 0, 6, 6|Y, 0, 6, 6|'// &
      '*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=side, PLANE=X|0|'
    if (basis(1) == 'HEX8') text = '*MODEL, TYPE=3D|*GRID, ELEMENT=HEX8|X, 0, 4, 4|Y, 0, 4, 4|Z, 0, 4, 4|'// &
      '*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=side, PLANE=X|0|*NSET, NSET=back, PLANE=Z|0|'
    text = text//'*MATERIAL, NAME=soil|*ELASTIC|1, 0.3|*UNIT WEIGHT|1|'// &
      '*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|'//trim(box)//'|*METHOD, BASIS='//trim(basis(2))// &
      ', INTEGRATION='//trim(basis(3))
    select case (factor)
    case ('')
      text = text//', STABILISATION=GHOST'
    case ('NONE')
      text = text//', STABILISATION=NONE'
    case default
      text = text//', STABILISATION=GHOST, FACTOR='//trim(factor)
    end select
    text = text//'|*PHASE, NAME=one|'
    if (.not. present(free)) then
      text = text//'*FIX|base, Y|side, X|'
      if (basis(1) == 'HEX8') text = text//'back, Z|'
    end if
    text = text//'*GRAVITY|0, -1'//merge(', 0', '   ', basis(1) == 'HEX8')//'|*END PHASE|'
    call parse_deck('block.inp', with_line_ends(text), analysis, messages, error)
    if (allocated(error)) write (error_unit, '(a)') message_text(messages)
    call give_up(error)
    call build_model(analysis, model, error)
    call give_up(error)
  end subroutine build_block

  !> Bars as line ends.
  pure function with_line_ends(bars) result(text)
    character(len=*), intent(in) :: bars
    character(len=len(bars)) :: text
    integer :: i

    text = bars
    do i = 1, len(text)
      if (text(i:i) == '|') text(i:i) = new_line('a')
    end do
  end function with_line_ends

  !> Move all points up until the last ones lie a little beyond the line.
  subroutine move_up(beyond, model)
    !> How far, as a share of a cell of length one.
    real(wp), intent(in) :: beyond
    type(model_type), intent(inout) :: model
    type(error_type), allocatable :: error
    real(wp) :: top
    integer :: d

    d = model%mesh%dimension
    top = merge(2.0_wp, 4.0_wp, d == 3)
    associate (points => model%state%points)
      points%position(d, :) = points%position(d, :) + (top - maxval(points%position(d, :))) + beyond
    end associate
    call relocate(model%mesh, model%cell_size, model%state%points, 'point', error)
    call give_up(error)
  end subroutine move_up

  !> The matrix with its zeros.
  subroutine make_dense(step, matrix)
    type(step_type), intent(in) :: step
    real(wp), allocatable, intent(out) :: matrix(:, :)
    integer :: i, k

    associate (sparse => step%matrix)
      allocate (matrix(sparse%n, sparse%n), source=0.0_wp)
      do i = 1, sparse%n
        do k = sparse%row_first(i), sparse%row_first(i + 1) - 1
          matrix(i, sparse%column(k)) = sparse%values(k)
          if (sparse%symmetric) matrix(sparse%column(k), i) = sparse%values(k)
        end do
      end do
    end associate
  end subroutine make_dense

  !> Largest to smallest size of the eigenvalues, which for a symmetric matrix are its singular values.
  real(wp) function condition(matrix)
    !> Symmetric to rounding.
    real(wp), intent(in) :: matrix(:, :)
    real(wp), allocatable :: values(:)

    allocate (values(size(matrix, 1)))
    call eigenvalues(matrix, values)
    condition = maxval(abs(values))/max(minval(abs(values)), tiny(1.0_wp))
  end function condition

  !> Eigenvalues of a symmetric matrix, growing.
  subroutine eigenvalues(matrix, values)
    !> Symmetric to rounding.
    real(wp), intent(in) :: matrix(:, :)
    real(wp), intent(out) :: values(:)
    real(wp), allocatable :: work_matrix(:, :), work(:)
    integer :: n, info

    n = size(matrix, 1)
    allocate (work_matrix, source=0.5_wp*(matrix + transpose(matrix)))
    allocate (work(8*n))
    call dsyev('N', 'U', n, work_matrix, n, values, work, size(work), info)
    if (info /= 0) error stop 3
  end subroutine eigenvalues

  !> End with the reason when something went wrong.
  subroutine give_up(error)
    type(error_type), allocatable, intent(in) :: error

    if (.not. allocated(error)) return
    write (error_unit, '(a)') error%message
    error stop 2
  end subroutine give_up
end program conditioning
