!> Constant-load test: is it really equilibrium? The load is kept, the mesh reset and the step solved again a
!> number of times; the growth of the first history is reported and the state restored.
module qsmpm_constant_load_test
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_phase_description, only: phase_type
  use qsmpm_model, only: model_type, state_type
  use qsmpm_observer, only: observer_type
  use qsmpm_initialisation, only: step_type
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_model_window, only: restore
  use qsmpm_step_control, only: largest_move, static_attempt
  use qsmpm_step_solver, only: step_solver_type
  use qsmpm_histories, only: take_histories
  implicit none
  private

  public :: test_constant_load

contains

  !> Do the tests that are due at the present load factor.
  subroutine test_constant_load(model, step, solver, phase, observer, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(phase_type), intent(in) :: phase
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error
    integer :: due

    if (.not. allocated(phase%constant_load_test%at)) return
    due = count(abs(phase%constant_load_test%at) <= abs(model%state%progress%load_factor)*(1.0_wp + 1.0e-9_wp))
    if (due <= model%state%progress%constant_load_tests_done) return
    model%state%progress%constant_load_tests_done = due
    call hold(model, step, solver, phase, observer, error)
  end subroutine test_constant_load

  !> Solve again at constant load and report.
  subroutine hold(model, step, solver, phase, observer, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(phase_type), intent(in) :: phase
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error
    type(state_type) :: before
    type(solution_type) :: solution
    real(wp), allocatable :: start(:), final(:)
    character(len=180) :: text
    integer :: repeat

    if (size(model%analysis%histories) == 0) return
    before = model%state
    call take_histories(model, start)
    do repeat = 1, phase%constant_load_test%repeats
      call solver%solve(model, step, phase%controls, static_attempt(phase%controls, before%progress%fraction, &
        before%progress%fraction, largest_move(model, phase%controls)), solution, error)
      if (allocated(error)) exit
      if (.not. solution%converged) exit
    end do
    call take_histories(model, final)
    call restore(before, model)
    if (allocated(error)) return
    if (solution%converged) then
      write (text, '(a,es10.3,a,i0,a,f9.3,a)') 'constant load test at load factor ', &
        before%progress%load_factor, ': after ', &
        phase%constant_load_test%repeats, ' re-solves '//model%analysis%histories(1)%name//' has grown by ', &
        100.0_wp*(final(1)/start(1) - 1.0_wp), ' %'
    else
      write (text, '(a,es10.3,a,i0,a)') 'constant load test at load factor ', before%progress%load_factor, &
        ': rejected at re-solve ', repeat, ' ('//solution%reason//')'
    end if
    call observer%note(trim(text))
  end subroutine hold
end module qsmpm_constant_load_test
