!> Phases that start from the end of an earlier one: who is whose parent, the loads and the state that a child starts
!> with, the children of a phase that has ended at its limit load, and a restart file with ends of phases in it.
module test_phase_tree
  use qsmpm_analysis, only: analysis_type
  use qsmpm_phase_description, only: phase_type, ended_by_load, ended_by_loss
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type, error_left_mesh, error_not_converged
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_kept_phases, only: find_kept_phase
  use qsmpm_phase_tree, only: phase_start_time, parent_of, lineage, is_wanted
  use qsmpm_phases, only: step_loop_type, begin_step_loop, advance_step_loop, end_step_loop, is_finished, &
    leave_lost_phase
  use qsmpm_restart, only: read_restart, write_restart
  use qsmpm_run_profile, only: run_profile_type
  use qsmpm_snapshot, only: snapshot_type, take_snapshot, restore_checkpoint, copy_phases
  use deck_samples, only: joined
  use scratch_folder, only: make_folder, remove_folder
  use scripted_solver, only: scripted_outcome_type, script_type, test_observer_type
  use state_samples, only: state_differences
  use testing, only: tests_type
  implicit none
  private

  public :: collect_phase_tree

  !> A run with all that belongs to it.
  type :: run_type
    class(model_type), allocatable :: model
    type(step_loop_type) :: loop
    type(test_observer_type) :: observer
    type(error_type), allocatable :: error
  end type run_type

  real(wp), parameter :: rounding = 1.0e-14_wp
  integer, parameter :: mark(2) = [3, 4]
  !> Of phase b: a step is cut back once.
  character(len=*), parameter :: coarse = ', SMALLEST STEP=0.5'

contains

  !> All tests.
  subroutine collect_phase_tree(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('phase_tree')
    call check_tree(tests)
    call check_times(tests)
    call check_child(tests)
    call check_limit_load(tests)
    call check_last_limit(tests)
    call check_lost(tests)
    call check_lost_alone(tests)
    call check_lost_twice(tests)
    call check_lost_resumed(tests)
    call check_resumed(tests)
    call check_snapshot(tests)
  end subroutine collect_phase_tree

  !> Phases a, b from a, c from a, d from c, e from b.
  subroutine five_phases(phases)
    type(phase_type), intent(out) :: phases(5)
    character(len=*), parameter :: names(5) = ['a', 'b', 'c', 'd', 'e'], parents(5) = [' ', ' ', 'a', ' ', 'b']
    integer :: p

    do p = 1, 5
      phases(p)%name = names(p)
      if (len_trim(parents(p)) > 0) phases(p)%parent = parents(p)
      phases(p)%duration = 10.0_wp**p
    end do
    phases(4)%parent = ''
  end subroutine five_phases

  !> Parents, lines of ancestors, and whose end is wanted.
  subroutine check_tree(tests)
    type(tests_type), intent(inout) :: tests
    type(phase_type) :: phases(5)
    integer :: p

    call five_phases(phases)
    call tests%check('parents by name, else the phase before', all([(parent_of(phases, p), p=1, 5)] == [0, 1, 1, 3, 2]))
    call tests%check('the line of a variant', same(lineage(phases, 4), [1, 3, 4]))
    call tests%check('the line of another', same(lineage(phases, 5), [1, 2, 5]))
    call tests%check('the first phase is its own line', same(lineage(phases, 1), [1]))
    call tests%check('ends wanted behind the next phase', &
      all([(is_wanted(phases, p, p + 1), p=1, 5)] .eqv. [.true., .true., .false., .false., .false.]))
    call tests%check('the end of the first is not wanted behind its last child', .not. is_wanted(phases, 1, 3))
    phases(5)%parent = 'none'
    call tests%check('a parent that is not there is none', parent_of(phases, 5) == 0)
    phases(3)%parent = 'e'
    call tests%check('nor is one that comes later', parent_of(phases, 3) == 0)
  end subroutine check_tree

  !> Whether two rows are the same.
  pure logical function same(a, b)
    integer, intent(in) :: a(:), b(:)

    same = size(a) == size(b)
    if (same) same = all(a == b)
  end function same

  !> Times run along the line.
  subroutine check_times(tests)
    type(tests_type), intent(inout) :: tests
    type(phase_type) :: phases(5)

    call five_phases(phases)
    call tests%close('time at the start of a variant', phase_start_time(phases, 4), 1010.0_wp, 0.0_wp)
    call tests%close('and of another', phase_start_time(phases, 5), 110.0_wp, 0.0_wp)
    phases(3)%start_given = .true.
    phases(3)%start_time = 7.0_wp
    call tests%close('a time that is given holds for what follows', phase_start_time(phases, 4), 1007.0_wp, 0.0_wp)
  end subroutine check_times

  !> A block in four phases: a, b from it, c from a too, d from b or from c.
  subroutine make_run(answers, controls, last_parent, run)
    type(scripted_outcome_type), intent(in) :: answers(:)
    !> More parameters of *CONTROLS of phase b; name of the parent of d.
    character(len=*), intent(in) :: controls, last_parent
    class(run_type), allocatable, intent(out) :: run
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    type(script_type) :: script
    type(run_profile_type) :: profile

    allocate (run, analysis)
    allocate (run%model)
    call parse_deck('block.inp', joined('*MODEL, TYPE=PLANE STRAIN|*METHOD, BASIS=STANDARD|*GRID, ELEMENT=QUAD4|'// &
      'X, 0, 2, 4|Y, 0, 1, 2|*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=side, PLANE=X|1|*MATERIAL, NAME=soil|*ELASTIC|'// &
      '1000, 0.3|*UNIT WEIGHT|18|*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 0.8|'// &
      '*PHASE, NAME=a, LOAD FACTOR=8|*FIX|base, ALL|*GRAVITY|0, -1|*CONTROLS, STEPS=2, DAMPING=NO|*END PHASE|'// &
      '*PHASE, NAME=b, LOAD FACTOR=3|*FIX|side, X|*GRAVITY|0, -1|*CONTROLS, STEPS=4, DAMPING=NO'//controls// &
      '|*END PHASE|*PHASE, NAME=c, PARENT=a, LOAD FACTOR=5|*GRAVITY|0, -1|*CONTROLS, STEPS=2, DAMPING=NO|*END PHASE|'// &
      '*PHASE, NAME=d, PARENT='//last_parent//', LOAD FACTOR=2|*GRAVITY|0, -1|*CONTROLS, STEPS=1|*END PHASE|'), &
      analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, run%model, error)
    if (allocated(error)) error stop 'the deck of the phase tree suite is broken'
    allocate (script%answers, source=answers)
    allocate (run%loop%solver, source=script)
    call begin_step_loop(run%model, profile, run%loop)
  end subroutine make_run

  !> Take some steps, or all there are.
  subroutine walk(run, steps)
    type(run_type), intent(inout) :: run
    integer, intent(in) :: steps
    type(run_profile_type) :: profile
    integer :: k

    do k = 1, steps
      if (is_finished(run%model, run%loop) .or. allocated(run%error)) exit
      call advance_step_loop(run%model, run%loop, run%observer, run%error)
      if (allocated(run%error)) call leave_lost_phase(run%model, run%loop, run%observer, run%error)
    end do
    if (steps == huge(1)) call end_step_loop(run%loop, profile)
  end subroutine walk

  !> A child starts with the state and the loads of its parent; steps are counted on.
  subroutine check_child(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run([scripted_outcome_type()], '', 'b', run)
    call walk(run, 7)
    associate (progress => run%model%state%progress, loading => run%model%loading)
      call tests%check('the phase after a variant starts', progress%phase == 3 .and. progress%phase_steps == 1)
      call tests%check('steps are those of the run', progress%step == 7)
      call tests%close('with the stresses of its parent', run%model%state%points%stress(1, 1), 3.0_wp, rounding)
      call tests%close('the loads of its parent in force', loading%gravity_start(2), -8.0_wp, rounding)
      call tests%close('and its own', loading%gravity_final(2), -5.0_wp, rounding)
      call tests%check('without the fixities of another variant', count(loading%constrained) == &
        2*count(loading%constrained(2, :)))
      call tests%check('it is told where it starts', index(run%observer%text, "phase 'c' starts from the end of phase "// &
        "'a'|") > 0)
      call walk(run, huge(1))
      call tests%check('the last one starts from the second', progress%phase == 4 .and. progress%step == 9)
      call tests%close('with its stresses', run%model%state%points%stress(1, 1), 7.0_wp, rounding)
      call tests%close('and its loads', run%model%loading%gravity_start(2), -3.0_wp, rounding)
      call tests%check('and its fixities', count(run%model%loading%constrained) > &
        2*count(run%model%loading%constrained(2, :)))
    end associate
    call tests%check('the run has ended well', is_finished(run%model, run%loop) .and. .not. allocated(run%error) .and. &
      run%observer%phases == 4)
  end subroutine check_child

  !> Phase b ends at its limit load.
  subroutine check_limit_load(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    type(scripted_outcome_type), parameter :: first = scripted_outcome_type(compliance=1.0_wp, iterations=9), &
      compliant = scripted_outcome_type(compliance=50.0_wp, iterations=9)
    character(len=*), parameter :: control = ', LIMIT COMPLIANCE=10, SMALLEST STEP=0.5'

    call make_run([first, first, first, compliant, compliant, first], control, 'c', run)
    call walk(run, huge(1))
    call tests%check('a limit load stops nobody who does not start from it', .not. allocated(run%error) .and. &
      run%observer%phases == 4)
    call make_run([first, first, first, compliant, compliant, first], control, 'b', run)
    call walk(run, huge(1))
    call tests%check('others run to their end', run%observer%phases == 3 .and. run%model%state%progress%phase == 3)
    call tests%check('its child is left out and the run not a good one', allocated(run%error))
    if (.not. allocated(run%error)) return
    call tests%check('that is no equilibrium', run%error%code == error_not_converged)
    call tests%check('and named: '//run%error%message, run%error%message == "phase 'b' has ended at its limit load"// &
      ", and these phases behind it were not run: 'd'")
  end subroutine check_limit_load

  !> A child that is left out between others is told of, and the run ends with the error.
  subroutine check_last_limit(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    type(scripted_outcome_type), parameter :: first = scripted_outcome_type(compliance=1.0_wp, iterations=9), &
      compliant = scripted_outcome_type(compliance=50.0_wp, iterations=9)

    call make_run([first, first, first, compliant, compliant, first], ', LIMIT COMPLIANCE=10, SMALLEST STEP=0.5', 'a', &
      run)
    run%model%analysis%phases(3)%parent = ''
    call walk(run, huge(1))
    call tests%check('the child is told of: '//run%observer%text, index(run%observer%text, "phase 'c' is skipped: phase "// &
      "'b' has not ended with its whole load|") > 0)
    call tests%check('the phase behind it runs', run%model%state%progress%phase == 4 .and. run%observer%phases == 3)
    call tests%check('and the run ends with the error', allocated(run%error))
  end subroutine check_last_limit

  !> Phase b loses equilibrium: c, which does not start from it, is run, d, which does, is not.
  subroutine check_lost(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run(lost_in_b(1), coarse, 'b', run)
    call walk(run, huge(1))
    call tests%check('a phase that does not start from one that is lost is run', &
      run%model%state%progress%phase == 3 .and. run%observer%phases == 3 .and. run%observer%steps == 5)
    call tests%close('from the end of its parent', run%model%state%points%stress(1, 1), 4.0_wp, rounding)
    call tests%check('one that does is not, and the run not a good one', allocated(run%error))
    if (.not. allocated(run%error)) return
    call tests%check('that is no equilibrium', run%error%code == error_not_converged)
    call tests%check('it names them: '//run%error%message, run%error%message == "phase 'b' has lost equilibrium at "// &
      "load factor 0.75, and these phases behind it were not run: 'd'")
    call tests%check('the reason is a warning', index(run%observer%text, "warning: phase 'b': no equilibrium beyond "// &
      "load factor  7.500000E-01: the script says no") > 0)
    call tests%check('how phases have ended is known', all(run%model%state%progress%ends%reason == &
      [ended_by_load, ended_by_loss, ended_by_load]))
    call tests%check('the lost end is not kept', find_kept_phase(run%model, 2) == 0)
  end subroutine check_lost

  !> Where nothing else is left the run ends as it is, and the step can be tried again.
  subroutine check_lost_alone(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run([scripted_outcome_type(converged=.false.)], '', 'b', run)
    call walk(run, huge(1))
    call tests%check('the first phase carries all others', allocated(run%error) .and. run%observer%phases == 0)
    if (.not. allocated(run%error)) return
    call tests%check('which are named: '//run%error%message, index(run%error%message, "phase 'a': no equilibrium") == 1 &
      .and. index(run%error%message, ", and these phases behind it were not run: 'b', 'c', 'd'") > 0)
    deallocate (run%error)
    select type (solver => run%loop%solver)
    type is (script_type)
      solver%answers = [scripted_outcome_type()]
    end select
    call walk(run, huge(1))
    call tests%check('it can be tried again', .not. allocated(run%error) .and. run%observer%phases == 4)
  end subroutine check_lost_alone

  !> Two are lost, the second one last.
  subroutine check_lost_twice(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run([lost_in_b(3), scripted_outcome_type(converged=.false., cause=error_left_mesh)], coarse, 'c', run)
    call walk(run, huge(1))
    call tests%check('the run ends with both', allocated(run%error) .and. run%observer%phases == 3)
    if (.not. allocated(run%error)) return
    call tests%check('in their order: '//run%error%message, run%error%message == "phase 'b' has lost equilibrium at load "// &
      "factor 2.25; phase 'c' has lost equilibrium at load factor 2.5, and these phases behind it were not run: 'd'")
    call tests%check('both are known', all(run%model%state%progress%ends(2:)%reason == ended_by_loss))
  end subroutine check_lost_twice

  !> Files at all steps of a run in which b is lost: at its first step, or behind some.
  subroutine check_lost_resumed(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run, resumed
    type(error_type), allocatable :: error
    character(len=:), allocatable :: directory
    logical :: same_states, same_words
    integer :: done, carried

    call make_folder(directory)
    same_states = .true.
    same_words = .true.
    do carried = 0, 2
      do done = 2, 5 + carried
        call make_run(lost_in_b(carried), coarse, 'b', run)
        call walk(run, done)
        call write_restart(directory//'/restart.h5', run%model, mark, error)
        ! The script begins anew with the run.
        call make_run(answers_behind(run, lost_in_b(carried)), coarse, 'b', resumed)
        if (.not. allocated(error)) call read_restart(directory//'/restart.h5', resumed%model, mark, error)
        call tests%check('a file with a lost phase is written and read', .not. allocated(error))
        call walk(run, huge(1))
        call walk(resumed, huge(1))
        same_states = same_states .and. len(state_differences(run%model%state, resumed%model%state)) == 0 .and. &
          find_kept_phase(resumed%model, 2) == 0
        same_words = same_words .and. allocated(run%error) .and. allocated(resumed%error)
        if (same_words) same_words = run%error%message == resumed%error%message
      end do
    end do
    call tests%check('a resumed run ends in the same state', same_states)
    call tests%check('and with the same words', same_words)
    call remove_folder(directory)
  end subroutine check_lost_resumed

  !> A script: phase a in two steps, some steps of b, then two attempts of b that fail; all others converge.
  function lost_in_b(carried) result(answers)
    integer, intent(in) :: carried
    type(scripted_outcome_type), allocatable :: answers(:)
    integer :: k

    allocate (answers(carried + 5))
    do k = carried + 3, carried + 4
      answers(k)%converged = .false.
    end do
  end function lost_in_b

  !> The part of a script that a run has not come to.
  function answers_behind(run, answers) result(rest)
    type(run_type), intent(in) :: run
    type(scripted_outcome_type), intent(in) :: answers(:)
    type(scripted_outcome_type), allocatable :: rest(:)

    select type (solver => run%loop%solver)
    type is (script_type)
      rest = answers(min(size(solver%asked) + 1, size(answers)):)
    end select
  end function answers_behind

  !> A run that goes on from a file ends in the state of one that was not interrupted.
  subroutine check_resumed(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run, resumed
    type(error_type), allocatable :: error
    character(len=:), allocatable :: directory
    integer :: done

    call make_folder(directory)
    do done = 1, 8
      call make_run([scripted_outcome_type()], '', 'b', run)
      call walk(run, done)
      call write_restart(directory//'/restart.h5', run%model, mark, error)
      call make_run([scripted_outcome_type()], '', 'b', resumed)
      if (.not. allocated(error)) call read_restart(directory//'/restart.h5', resumed%model, mark, error)
      call tests%check('a file with the ends of phases is written and read', .not. allocated(error))
      if (done == 4) call tests%check('it holds the end that is wanted', find_kept_phase(resumed%model, 1) > 0)
      if (done == 7) call tests%check('and no other', find_kept_phase(resumed%model, 1) == 0 .and. &
        find_kept_phase(resumed%model, 2) > 0)
      call walk(run, huge(1))
      call walk(resumed, huge(1))
      call tests%check('a resumed run ends as one that was not interrupted', &
        len(state_differences(run%model%state, resumed%model%state)) == 0 .and. .not. allocated(resumed%error))
    end do
    call remove_folder(directory)
  end subroutine check_resumed

  !> A snapshot brings the ends of phases back.
  subroutine check_snapshot(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    class(snapshot_type), allocatable :: snapshot
    type(phase_type), allocatable :: phases(:)

    allocate (snapshot)
    call make_run([scripted_outcome_type()], '', 'b', run)
    call walk(run, 4)
    call copy_phases(run%model%analysis%phases, phases)
    call take_snapshot(run%model, phases, run%loop, snapshot)
    deallocate (run%model%kept_phases)
    call restore_checkpoint(snapshot, run%model, phases, run%loop)
    call tests%check('a snapshot holds the ends of phases', find_kept_phase(run%model, 1) > 0)
    call walk(run, huge(1))
    call tests%check('so that their children can run', .not. allocated(run%error) .and. &
      run%model%state%progress%phase == 4)
  end subroutine check_snapshot
end module test_phase_tree
