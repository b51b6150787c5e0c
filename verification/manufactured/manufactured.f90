!> Orders of convergence on manufactured fields in the plane and in space (see exact_field).
!>
!>   build/manufactured [--long]                   the table of methods and grids, orders judged
!>   build/manufactured METHOD[@ELEMENT] POINTS DIMENSION N STEPS   one run, METHOD as in the deck
!>
!> The body never leaves its grid, so nothing but the interior of a method is measured: points that
!> cross cells, start states, functions. Errors are relative L2 over the material points at the end:
!> of the Cauchy stress against the exact one at the point's initial place, and of the displacement.
!> The last column is CPU time; no figure of time is judged. Closes with `N passed, N failed`.
program manufactured
  use, intrinsic :: iso_fortran_env, only: output_unit
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_analysis, only: analysis_type
  use qsmpm_messages, only: message_list_type
  use qsmpm_deck, only: read_deck
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_linear_system, only: end_system
  use qsmpm_initialisation, only: step_type
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_load_step, only: load_step_type
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_smooth_stress, only: stress_norm
  use qsmpm_stress_error, only: stress_error_type, estimate_stress_error
  use exact_field, only: field_type, displacement, cauchy, body_force
  implicit none

  !> What is measured of a run.
  type :: outcome_type
    real(wp) :: estimate = huge(1.0_wp), stress_error = huge(1.0_wp), position_error = huge(1.0_wp), seconds = 0.0_wp
    integer :: iterations = 0, equations = 0
    logical :: finished = .false.
  end type outcome_type

  integer :: passed = 0, failed = 0
  character(len=80) :: words(5)
  integer :: i

  do i = 1, min(5, command_argument_count())
    call get_command_argument(i, words(i))
  end do
  select case (command_argument_count())
  case (5)
    call one_run()
  case (0, 1)
    call table(command_argument_count() == 1)
    write (output_unit, '(i0,a,i0,a)') passed, ' passed, ', failed, ' failed'
    if (failed > 0) stop 1
  case default
    write (output_unit, '(a)') 'use: manufactured [--long] or manufactured METHOD POINTS DIMENSION N STEPS'
    stop 2
  end select

contains

  !> A run from the command line.
  subroutine one_run()
    type(outcome_type) :: outcome
    integer :: points, dimension, n, steps

    read (words(2), *) points
    read (words(3), *) dimension
    read (words(4), *) n
    read (words(5), *) steps
    call run(trim(words(1)), points, dimension, n, steps, outcome)
    call tell(trim(words(1)), points, dimension, n, outcome)
  end subroutine one_run

  !> All methods: what is asked of each order, between the grids named.
  subroutine table(long)
    !> The fine grids too.
    logical, intent(in) :: long

    write (output_unit, '(a)') 'method                        points dim   n     estimated  stress error  displacement'// &
      '  iterations  equations   CPU s'
    call sweep('BASIS=GIMP', 4, 2, 20, pick(long, [16, 32], [16, 32, 64]), 0.0_wp)
    call sweep('BASIS=SPLINE2G', 4, 2, 20, pick(long, [16, 32], [16, 32, 64]), 0.0_wp)
    call sweep('BASIS=SPLINE2, INTEGRATION=CELL', 9, 2, 20, pick(long, [16, 32], [16, 32, 64]), 2.0_wp)
    call sweep('BASIS=SPLINE2G, INTEGRATION=CELL', 9, 2, 20, pick(long, [16, 32], [16, 32, 64]), 2.0_wp)
    call sweep('BASIS=SPLINE3, INTEGRATION=CELL', 16, 2, 20, pick(long, [16, 32], [16, 32, 64]), 2.5_wp)
    call sweep('BASIS=SPLINE2, INTEGRATION=CELL', 27, 3, 5, pick(long, [8, 12], [8, 12, 16]), 2.0_wp)
    call sweep('BASIS=SPLINE3, INTEGRATION=CELL', 64, 3, 5, pick(long, [6, 8], [8, 12, 16]), 2.5_wp)
  end subroutine table

  !> The quick or the long list.
  pure function pick(long, quick_list, long_list) result(list)
    !> Which.
    logical, intent(in) :: long
    !> The lists.
    integer, intent(in) :: quick_list(:), long_list(:)
    integer, allocatable :: list(:)

    if (long) allocate (list, source=long_list)
    if (.not. long) allocate (list, source=quick_list)
  end function pick

  !> One method on several grids; the order from the first to the last grid is judged.
  subroutine sweep(method, points, dimension, steps, grids, least_order)
    !> *METHOD parameters.
    character(len=*), intent(in) :: method
    !> Points a cell, dimension, steps, cells a side.
    integer, intent(in) :: points, dimension, steps, grids(:)
    !> Order asked for; 0 asks for none.
    real(wp), intent(in) :: least_order
    type(outcome_type) :: outcome, first
    real(wp) :: order
    integer :: k

    do k = 1, size(grids)
      call run(method, points, dimension, grids(k), steps, outcome)
      call tell(method, points, dimension, grids(k), outcome)
      if (k == 1) first = outcome
    end do
    order = log(first%stress_error/outcome%stress_error)/log(real(grids(size(grids)), wp)/grids(1))
    if (least_order > 0.0_wp .and. outcome%finished .and. first%finished .and. order >= least_order) then
      passed = passed + 1
      write (output_unit, '(a,f6.2,a,f4.1)') '  held    order', order, ', asked', least_order
    else if (least_order > 0.0_wp) then
      failed = failed + 1
      write (output_unit, '(a,f6.2,a,f4.1)') '  FAILED  order', order, ', asked', least_order
    else
      write (output_unit, '(a,f6.2)') '          order', order
    end if
  end subroutine sweep

  !> A line of the table.
  subroutine tell(method, points, dimension, n, outcome)
    !> *METHOD parameters.
    character(len=*), intent(in) :: method
    !> Points a cell, dimension, cells a side.
    integer, intent(in) :: points, dimension, n
    !> What was measured.
    type(outcome_type), intent(in) :: outcome
    character(len=33) :: name

    name = method(7:)
    if (outcome%finished) then
      write (output_unit, '(a,i4,i4,i5,3es14.3,i10,i12,f10.2)') name, points, dimension, n, outcome%estimate, &
        outcome%stress_error, outcome%position_error, outcome%iterations, outcome%equations, outcome%seconds
    else
      write (output_unit, '(a,i4,i4,i5,a)') name, points, dimension, n, '  did not finish'
    end if
    flush (output_unit)
  end subroutine tell

  !> One run.
  subroutine run(method, points, dimension, n, steps, outcome)
    !> *METHOD parameters.
    character(len=*), intent(in) :: method
    !> Points a cell, dimension, cells a side, steps.
    integer, intent(in) :: points, dimension, n, steps
    !> What was measured.
    type(outcome_type), intent(out) :: outcome
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(load_step_type) :: solver
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    type(field_type) :: field
    real(wp) :: start, finish
    integer :: k

    allocate (model, step)
    field%dimension = dimension
    field%amplitude = [0.08_wp, 0.08_wp, 0.0_wp]
    if (dimension == 3) field%amplitude = [0.06_wp, -0.045_wp, 0.03_wp]
    call make_model(method, points, dimension, n, model)
    call cpu_time(start)
    call start_phase(model)
    do k = 1, steps
      call push(field, real(k, wp)/steps, model)
      call solver%solve(model, step, model%analysis%phases(1)%controls, &
        attempt_type(real(k, wp)/steps, 1.0e-8_wp, largest_move=0.5_wp), solution, error)
      if (allocated(error)) return
      if (.not. solution%converged) return
      outcome%iterations = outcome%iterations + solution%iterations
    end do
    call cpu_time(finish)
    outcome%seconds = finish - start
    outcome%equations = step%equations%count
    outcome%finished = .true.
    call measure(field, model, outcome)
    call end_system(step%system)
  end subroutine run

  !> The body force of a share of the field on the material points.
  subroutine push(field, share, model)
    !> The field.
    type(field_type), intent(in) :: field
    !> Share of the amplitude.
    real(wp), intent(in) :: share
    !> The model.
    type(model_type), intent(inout) :: model
    real(wp) :: x(3), b(3)
    integer :: p

    associate (points => model%state%points)
      if (.not. allocated(model%loading%point_force)) &
        allocate (model%loading%point_force(field%dimension, points%count))
      x = 0.0_wp
      do p = 1, points%count
        x(:field%dimension) = points%initial_position(:, p)
        b = body_force(field, x, share)
        model%loading%point_force(:, p) = b(:field%dimension)*points%initial_volume(p)
      end do
    end associate
  end subroutine push

  !> Errors against the exact field.
  subroutine measure(field, model, outcome)
    !> The field.
    type(field_type), intent(in) :: field
    !> The model at the end.
    type(model_type), intent(in) :: model
    !> What was measured.
    type(outcome_type), intent(inout) :: outcome
    type(stress_error_type) :: estimate
    real(wp) :: x(3), s(3, 3), exact(6), u(3), sums(5)
    integer :: p, n

    sums = 0.0_wp
    x = 0.0_wp
    associate (points => model%state%points)
      n = size(points%stress, 1)
      do p = 1, points%count
        x(:field%dimension) = points%initial_position(:, p)
        s = cauchy(field, x, 1.0_wp)
        exact = [s(1, 1), s(2, 2), s(3, 3), s(1, 2), s(1, 3), s(2, 3)]
        u = displacement(field, x, 1.0_wp)
        sums(1) = sums(1) + points%initial_volume(p)*sum((points%stress(:, p) - exact(:n))**2)
        sums(2) = sums(2) + points%initial_volume(p)*sum(exact(:n)**2)
        sums(3) = sums(3) + points%initial_volume(p)*sum((points%position(:, p) &
          - points%initial_position(:, p) - u(:field%dimension))**2)
        sums(4) = sums(4) + points%initial_volume(p)*sum(u**2)
        sums(5) = sums(5) + points%initial_volume(p)*stress_norm(exact(:n))**2
      end do
    end associate
    outcome%stress_error = sqrt(sums(1)/sums(2))
    call estimate_stress_error(model, estimate)
    outcome%estimate = sqrt(sum(model%state%points%initial_volume*(estimate%at_point*estimate%scale)**2)/sums(5))
    outcome%position_error = sqrt(sums(3)/sums(4))
  end subroutine measure

  !> A unit square or cube of n cells a side, held on its boundary.
  subroutine make_model(method, points, dimension, n, model)
    !> *METHOD parameters.
    character(len=*), intent(in) :: method
    !> Points a cell, dimension, cells a side.
    integer, intent(in) :: points, dimension, n
    !> The model.
    type(model_type), intent(out) :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=*), parameter :: deck = 'manufactured.inp', letter = 'XYZ'
    character(len=3) :: fixed
    character(len=8) :: element
    integer :: unit, a, k

    allocate (analysis)
    open (newunit=unit, file=deck, action='write', status='replace')
    k = index(method//'@', '@')
    element = 'QUAD4'
    if (dimension == 3) element = 'HEX8'
    if (k < len(method)) element = method(k + 1:)
    if (dimension == 2) write (unit, '(a)') '*MODEL, TYPE=PLANE STRAIN'
    if (dimension == 3) write (unit, '(a)') '*MODEL, TYPE=3D'
    write (unit, '(a)') '*GRID, ELEMENT='//trim(element)
    write (unit, '(a,", 0, 1, ",i0)') (letter(a:a), n, a=1, dimension)
    do a = 1, dimension
      write (unit, '(a)') '*NSET, NSET=low_'//letter(a:a)//', PLANE='//letter(a:a), '0', &
        '*NSET, NSET=high_'//letter(a:a)//', PLANE='//letter(a:a), '1'
    end do
    write (unit, '(a)') '*MATERIAL, NAME=elastic', '*ELASTIC', '1E4, 0.3', '*UNIT WEIGHT', '1', &
      '*BODY, NAME=block, MATERIAL=elastic, SHAPE=ALL'
    write (unit, '(a,i0)') '*POINTS, BODY=block, PER ELEMENT=', points
    write (unit, '(3a)') '*METHOD, ', method(:k - 1), ', KINEMATICS=LOGARITHMIC'
    write (unit, '(a)') '*PHASE, NAME=push', '*FIX'
    do a = 1, dimension
      fixed = letter(a:a)
      if (dimension == 3) fixed = 'ALL'
      write (unit, '(a)') 'low_'//letter(a:a)//', '//fixed, 'high_'//letter(a:a)//', '//fixed
    end do
    write (unit, '(a)') '*GRAVITY', merge('0, 0   ', '0, 0, 0', dimension == 2)
    write (unit, '(a)') '*CONTROLS, STEPS=1, NEWTON=FULL, MAX ITERATIONS=30', '*END PHASE'
    close (unit)
    call read_deck(deck, analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) then
      write (output_unit, '(a)') error%message
      stop 2
    end if
  end subroutine make_model
end program manufactured
