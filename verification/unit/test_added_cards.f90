!> Cards that a program adds behind a deck: the same bytes as of the deck that has them, faults named by their own
!> lines, and what a state that was put back does not know is forgotten.
module test_added_cards
  use qsmpm, only: wp, error_type, problem_type, simulation_type, snapshot_type, get_values, error_deck, error_other
  use qsmpm_posix, only: remove_file
  use testing, only: tests_type
  implicit none
  private

  public :: collect_added_cards

  character(len=1), parameter :: nl = new_line('a')
  character(len=*), parameter :: hard = '*MATERIAL, NAME=hard'//nl//'*ELASTIC'//nl//'4e4, 0.3'//nl// &
    '*MOHR COULOMB'//nl//'6, 20, 0'//nl//'*UNIT WEIGHT'//nl//'21'//nl
  character(len=*), parameter :: weight = '*PHASE, NAME=weight'//nl//'*FIX'//nl//'base, ALL'//nl//'left, X'//nl// &
    'right, X'//nl//'*GRAVITY'//nl//'0, -1'//nl//'*CONTROLS, STEPS=2'//nl//'*END PHASE'//nl
  character(len=*), parameter :: flood = '*PHASE, NAME=flood'//nl//'*WATER LEVEL, UNIT WEIGHT=10'//nl//'0, 0.5'//nl// &
    '*CONTROLS, STEPS=1'//nl//'*END PHASE'//nl
  character(len=*), parameter :: dig = '*PHASE, NAME=dig'//nl//'*DEACTIVATE'//nl//'pit'//nl// &
    '*CONTROLS, STEPS=2'//nl//'*END PHASE'//nl
  character(len=*), parameter :: grout = '*PHASE, NAME=grout'//nl//'*CHANGE MATERIAL'//nl//'bank, hard'//nl// &
    '*CONTROLS, STEPS=1'//nl//'*END PHASE'//nl
  character(len=*), parameter :: factor = '*PHASE, NAME=factor, TYPE=SAFETY'//nl//'*SAFETY, TOLERANCE=0.1'//nl// &
    '*CONTROLS, STEPS=1'//nl//'*END PHASE'//nl
  character(len=*), parameter :: back = '*PHASE, NAME=back, PARENT=grout'//nl//'*GRAVITY'//nl//'0.02, -1'//nl// &
    '*CONTROLS, STEPS=1'//nl//'*END PHASE'//nl

contains

  !> All tests.
  subroutine collect_added_cards(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('added_cards')
    call check_same_bytes(tests)
    call check_drained(tests)
    call check_errors(tests)
    call check_forgotten(tests)
    call check_fresh_stage(tests)
    call check_saved(tests)
    call check_variants(tests)
  end subroutine collect_added_cards

  !> A bank and a pit beside it, of one soil; what stands before the phases, and those.
  subroutine begin(run, materials, phases, soil)
    type(simulation_type), intent(inout) :: run
    character(len=*), intent(in) :: materials, phases
    !> Another soil.
    character(len=*), intent(in), optional :: soil
    class(problem_type), allocatable :: problem
    type(error_type), allocatable :: error
    character(len=:), allocatable :: cards

    allocate (problem)
    cards = '*ELASTIC'//nl//'2e4, 0.3'//nl//'*MOHR COULOMB'//nl//'6, 25, 0'//nl//'*UNIT WEIGHT'//nl//'18'//nl
    if (present(soil)) cards = soil
    call problem%parse('*MODEL, TYPE=PLANE STRAIN'//nl//'*GRID, ELEMENT=QUAD4'//nl//'X, 0, 4, 8'//nl// &
      'Y, 0, 2, 4'//nl//'*NSET, NSET=base, PLANE=Y'//nl//'0'//nl//'*NSET, NSET=left, PLANE=X'//nl//'0'//nl// &
      '*NSET, NSET=right, PLANE=X'//nl//'4'//nl//'*MATERIAL, NAME=soil'//nl//cards//materials// &
      '*BODY, NAME=pit, MATERIAL=soil, SHAPE=BOX'//nl//'2, 4, 0.5, 1.5'//nl// &
      '*BODY, NAME=bank, MATERIAL=soil, SHAPE=POLYGON'//nl//'0, 0'//nl//'4, 0'//nl//'4, 0.5'//nl//'2, 0.5'//nl// &
      '2, 1.5'//nl//'0, 1.5'//nl// &
      '*METHOD, BASIS=STANDARD, INTEGRATION=CELL'//nl//'*HISTORY, NAME=toe, QUANTITY=STRESS, COMPONENT=YY'//nl// &
      '3.8, 0.3'//nl//'*HISTORY, NAME=crest, QUANTITY=DISPLACEMENT, COMPONENT=Y'//nl//'0.3, 1.5'//nl//phases, &
      'bank', error)
    if (.not. allocated(error)) call run%create(problem, error)
    if (.not. allocated(error)) return
    print '(a)', problem%messages//error%message
    error stop 'the deck of the suite of added cards is broken'
  end subroutine begin

  !> Add cards and run to the end.
  subroutine go_on(tests, run, cards)
    type(tests_type), intent(inout) :: tests
    type(simulation_type), intent(inout) :: run
    character(len=*), intent(in) :: cards
    type(error_type), allocatable :: error

    call run%add_cards(cards, error)
    call tests%check('cards are taken', .not. allocated(error))
    if (allocated(error)) print '(a)', error%message
    if (.not. allocated(error)) call run%run(error)
    call tests%check('the run goes on', .not. allocated(error))
    if (allocated(error)) print '(a)', error%message
  end subroutine go_on

  !> Whether two analyses stand in the same state, bit for bit.
  logical function same(a, b)
    type(simulation_type), intent(in) :: a, b
    real(wp), allocatable :: one(:), two(:)
    type(error_type), allocatable :: error, other

    associate (p => a%model%state%points, q => b%model%state%points)
      same = p%count == q%count .and. size(p%pore_pressure) == size(q%pore_pressure)
      if (.not. same) return
      same = all(transfer(p%stress, [1]) == transfer(q%stress, [1])) .and. &
        all(transfer(p%position, [1]) == transfer(q%position, [1])) .and. &
        all(transfer(p%state, [1]) == transfer(q%state, [1])) .and. &
        all(transfer(p%pore_pressure, [1]) == transfer(q%pore_pressure, [1])) .and. &
        all(transfer(p%weight, [1]) == transfer(q%weight, [1]))
    end associate
    allocate (one(2), two(2))
    call get_values(a, 'histories', one, error)
    call get_values(b, 'histories', two, other)
    same = same .and. all(transfer(one, [1]) == transfer(two, [1])) .and. .not. (allocated(error) .or. allocated(other))
    deallocate (one, two)
    allocate (one(5*size(a%scene%phases)), two(5*size(b%scene%phases)))
    call get_values(a, 'phase_results', one, error)
    call get_values(b, 'phase_results', two, other)
    same = same .and. size(one) == size(two) .and. .not. (allocated(error) .or. allocated(other))
    if (same) same = all(transfer(one, [1]) == transfer(two, [1]))
  end function same

  !> Water, an excavation, another material, a factor of safety and what starts before it, in one deck or one by one.
  subroutine check_same_bytes(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: whole, added
    type(error_type), allocatable :: error
    real(wp) :: results(30), strength(1)
    integer :: i

    allocate (whole, added)
    call begin(whole, hard, weight//flood//dig//grout//factor//back)
    call whole%run(error)
    call tests%check('the whole deck runs', .not. allocated(error))
    if (allocated(error)) print '(a)', error%message
    call begin(added, '', weight)
    call added%run(error)
    call go_on(tests, added, flood)
    call go_on(tests, added, dig)
    call go_on(tests, added, hard//grout)
    call added%add_cards(factor, error)
    do i = 1, 2
      if (.not. allocated(error)) call added%advance(error)
    end do
    if (.not. allocated(error)) call get_values(added, 'strength_factor', strength, error)
    call tests%check('cards come while the strength is lowered', .not. allocated(error) .and. strength(1) > 1.0_wp)
    call go_on(tests, added, back)
    call tests%check('cards one by one give the bytes of the deck', same(whole, added))
    call get_values(added, 'phase_results', results, error)
    call tests%check('phases have ended with their whole loads', .not. allocated(error) .and. &
      all(nint(results([1, 6, 11, 16, 21, 26])) == 1) .and. all(results([2, 7, 12, 17, 27]) >= 1.0_wp))
    call tests%check('one phase has a factor of safety', results(24) > 1.0_wp .and. results(25) > results(24) .and. &
      results(25) - results(24) < 0.1001_wp .and. all(results([4, 5, 9, 10, 14, 15, 19, 20, 29, 30]) < 0.5_wp))
    call get_values(added, 'strength_factor', strength, error)
    call tests%close('the strength is whole again', strength(1), 1.0_wp, 0.0_wp)
  end subroutine check_same_bytes

  !> Undrained soil drains in a phase that is added, stays drained after it, and a stage behind that knows it.
  subroutine check_drained(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: clay = '*ELASTIC'//nl//'2e3, 0.3'//nl//'*UNDRAINED, TYPE=A'//nl// &
      '*UNIT WEIGHT'//nl// &
      '18'//nl, drain = '*PHASE, NAME=drain'//nl//'*DRAIN STATE, AFTERWARDS=DRAINED'//nl//'*CONTROLS, STEPS=2'//nl// &
      '*END PHASE'//nl
    class(simulation_type), allocatable :: whole, added
    type(error_type), allocatable :: error
    integer :: excess

    allocate (whole, added)
    call begin(whole, '', weight//drain, clay)
    call whole%run(error)
    call begin(added, '', weight, clay)
    call added%run(error)
    excess = added%model%laws(1)%law%state_count
    call tests%check('weight makes an excess pressure', maxval(added%model%state%points%state(excess, :)) > 1.0_wp)
    call go_on(tests, added, drain)
    call tests%check('drained by cards or by the deck: the same bytes', same(whole, added))
    call added%add_stage('heavier', 1, error)
    call added%set_gravity([0.0_wp, -2.0_wp, 0.0_wp], error)
    if (.not. allocated(error)) call added%run(error)
    call tests%check('a stage behind stays drained', .not. allocated(error) .and. &
      maxval(abs(added%model%state%points%state(excess, :))) < 1.0e-9_wp)
  end subroutine check_drained

  !> What is wrong is told with the line of what was added, and changes nothing.
  subroutine check_errors(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error

    allocate (run)
    call begin(run, '', weight)
    call run%add_cards(hard//dig//'*PHASE, NAME=again'//nl//'*DEACTIVATE'//nl//'put'//nl//'*END PHASE'//nl, error)
    call refused('an unknown body', 'added cards:15: *DEACTIVATE: there is no body '// &
      "'put' (did you mean pit?)", error_deck)
    call run%add_cards('*MATERIAL, NAME=hard'//nl//'*ELASTIC'//nl//'-1, 0.3'//nl, error)
    call refused('a stiffness below 0', 'added cards:3: *ELASTIC:', error_deck)
    call run%add_cards('*HISTORY, NAME=top, QUANTITY=VOLUME'//nl, error)
    call refused('another card', 'only *MATERIAL and *PHASE', error_other)
    call run%add_cards(flood//'*PHASE, NAME=deep'//nl//'*WATER LEVEL, UNIT WEIGHT=10'//nl//'0, -9'//nl//'*END PHASE'// &
      nl, error)
    call refused('a level below the ground', 'added cards:7: *WATER LEVEL:', error_deck)
    call run%add_cards('*MATERIAL, NAME=clay'//nl//'*ELASTIC'//nl//'2e3, 0.3'//nl//'*UNDRAINED, TYPE=A'//nl, error)
    call refused('more state variables', 'state variables than the material points carry', error_other)
    call run%run(error)
    call go_on(tests, run, flood)
    call run%add_cards(replaced(back, 'grout', 'weight'), error)
    call refused('a parent that is not kept', "the end of phase 'weight', that phase 'back'", error_other)

  contains

    !> The last call has failed, and the scene is what it was.
    subroutine refused(what, sentence, code)
      character(len=*), intent(in) :: what, sentence
      integer, intent(in) :: code
      logical :: good

      good = allocated(error)
      if (good) good = error%code == code .and. index(error%message, sentence) > 0
      if (allocated(error) .and. .not. good) print '(a)', error%message
      call tests%check(what//' is refused', good)
      call tests%check(what//' leaves the scene', size(run%scene%materials) == 1 .and. size(run%model%laws) == 1 .and. &
        size(run%scene%phases) == size(run%model%analysis%phases) .and. size(run%scene%phases) <= 2)
    end subroutine refused
  end subroutine check_errors

  !> A text with one word in the place of another.
  pure function replaced(text, old, new) result(changed)
    character(len=*), intent(in) :: text, old, new
    character(len=:), allocatable :: changed
    integer :: i

    i = index(text, old)
    changed = text(:i - 1)//new//text(i + len(old):)
  end function replaced

  !> A state that is put back forgets the cards, which can then be added again with other numbers.
  subroutine check_forgotten(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run, straight
    class(snapshot_type), allocatable :: snapshot
    type(error_type), allocatable :: error
    real(wp), parameter :: resistances(2) = [0.0_wp, 0.3_wp]

    allocate (run, straight, snapshot)
    call begin(run, '', weight)
    call run%run(error)
    call run%checkpoint(snapshot, error)
    call go_on(tests, run, replaced(hard, '4e4', '9e4')//dig//grout)
    ! As of soil on splines, whose cells have one pressure in a search alone.
    run%model%laws(1)%factors = resistances
    call run%restore_checkpoint(snapshot, error)
    call tests%check('the soil that stays keeps its treatment of locking', &
      all(abs(run%model%laws(1)%factors - resistances) <= 0.0_wp))
    run%model%laws(1)%factors = -1.0_wp
    call tests%check('materials and phases are forgotten', &
      size(run%scene%materials) == 1 .and. size(run%model%laws) == 1 &
      .and. size(run%model%analysis%materials) == 1 .and. size(run%scene%phases) == 1)
    call go_on(tests, run, hard//dig//grout)
    call begin(straight, hard, weight//dig//grout)
    call straight%run(error)
    call tests%check('the second trial is that of the deck', same(run, straight))
  end subroutine check_forgotten

  !> Stages that are added by calls follow those of cards.
  subroutine check_fresh_stage(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error

    allocate (run)
    call begin(run, '', weight)
    call go_on(tests, run, dig)
    call run%add_stage('pushed', 1, error)
    call run%set_gravity([0.01_wp, -1.0_wp, 0.0_wp], error)
    if (.not. allocated(error)) call run%run(error)
    call tests%check('a stage follows cards', .not. allocated(error) .and. run%model%state%progress%phase == 3)
  end subroutine check_fresh_stage

  !> A state that is saved within a phase of cards goes on in an analysis that has the same cards, and in no other.
  subroutine check_saved(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run, other, none
    type(error_type), allocatable :: error
    character(len=*), parameter :: path = 'test_added_cards.h5'

    allocate (run, other, none)
    call begin(run, '', weight)
    call run%run(error)
    call run%add_cards(hard//dig//grout, error)
    if (.not. allocated(error)) call run%advance(error)
    if (.not. allocated(error)) call run%save(path, error)
    if (.not. allocated(error)) call run%run(error)
    call tests%check('a state is saved in a phase of cards', .not. allocated(error))
    call begin(other, '', weight)
    call other%add_cards(hard//dig//grout, error)
    if (.not. allocated(error)) call other%load(path, error)
    if (.not. allocated(error)) call other%run(error)
    call tests%check('what is loaded ends in the same bytes', .not. allocated(error) .and. same(run, other))
    call begin(none, '', weight)
    call none%load(path, error)
    call tests%check('without the cards it is refused', allocated(error))
    call tests%check('the file is taken away', remove_file(path) == 0)
  end subroutine check_saved

  !> Cards that come after a safety phase start from its parent.
  subroutine check_variants(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run, whole
    type(error_type), allocatable :: error

    allocate (run, whole)
    call begin(whole, hard, weight//grout//factor//back)
    call whole%run(error)
    call begin(run, hard, weight//grout//factor)
    call run%run(error)
    call go_on(tests, run, back)
    call tests%check('a phase behind a safety phase of the deck starts from its parent', same(whole, run))
  end subroutine check_variants
end module test_added_cards
