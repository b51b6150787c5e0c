!> Props and contracted cavities: forces by hand in phases that install, jack, reach a limit and remove, the matrix with
!> both at work against differences, how a cavity closes, and what decks may not ask of them.
module test_props
  use qsmpm_analysis, only: analysis_type
  use qsmpm_cavities, only: closure_of
  use qsmpm_deck, only: parse_deck, message_list_type, message_text
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_error, only: error_type
  use qsmpm_initialisation, only: step_type, initialise_step, begin_analysis
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: step_info_type
  use qsmpm_linear_system, only: end_system
  use qsmpm_load_step, only: load_step_type
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_props, only: prop_force
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_term, only: increment_type
  use qsmpm_term_sums, only: begin_terms, set_loads
  use qsmpm_unknowns, only: all_nodes
  use deck_samples, only: joined
  use term_samples, only: matrix_and_difference, force_named
  use testing, only: tests_type
  implicit none
  private

  public :: collect_props

  real(wp), parameter :: tight = 1.0e-9_wp
  !> A bar that is held at x = 0, between rollers above and below, with a strut at its end and a tie inside of it.
  character(len=*), parameter :: bar = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 5, 10|Y, 0, 2, 4|'// &
    '*NSET, NSET=left, PLANE=X|0|*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=top, PLANE=Y|2|*MATERIAL, NAME=soil|'// &
    '*ELASTIC|1000, 0.25|*BODY, NAME=bar, MATERIAL=soil, SHAPE=BOX|0, 4, 0, 2|'// &
    '*METHOD, BASIS=STANDARD, STABILISATION=NONE|*SURFACE, NAME=end, TYPE=OUTLINE, BODY=bar, BOX|4, 4, 0, 2|'// &
    '*PROP, NAME=strut, STIFFNESS=100, COMPRESSION LIMIT=4, FIXED=YES|4, 1, 6, 1|'// &
    '*PROP, NAME=tie, STIFFNESS=200|0, 1, 3, 1|', &
    fix = '*FIX|left, X|base, Y|top, Y|*CONTROLS, STEPS=2, TOLERANCE=1e-9|'
  !> Half of a ring, its inner side a surface.
  character(len=*), parameter :: ring = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, -3, 3, 12|Y, 0, 6, 12|'// &
    '*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.25|*BODY, NAME=around, MATERIAL=soil, '// &
    'SHAPE=BOX|-3, 3, 0, 6|*METHOD, BASIS=SPLINE2|*SURFACE, NAME=bore, TYPE=SEGMENT|'// &
    '-1, 2, -1, 4|-1, 4, 1, 4|1, 4, 1, 2|1, 2, -1, 2|*SURFACE, NAME=arc, TYPE=SEGMENT|-1, 2, -1, 4|-1, 4, 1, 4|'// &
    '*SURFACE, NAME=level, TYPE=SEGMENT|-1, 2, 1, 2|'

contains

  !> All tests of the suite.
  subroutine collect_props(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('props')
    call check_phases(tests)
    call check_limit(tests)
    call check_matrix(tests)
    call check_cavity(tests)
    call check_decks(tests)
  end subroutine collect_props

  !> A model from cards, at the start of its first phase.
  subroutine make_model(cards, model, step)
    character(len=*), intent(in) :: cards
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('props.inp', joined(cards), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'a deck of the props suite is broken'
    call begin_analysis(model, step%terms)
  end subroutine make_model

  !> Solve a phase in steps to the load fractions given.
  subroutine run_phase(tests, model, step, number, fractions)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout), target :: step
    integer, intent(in) :: number
    real(wp), intent(in) :: fractions(:)
    type(load_step_type) :: solver
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    integer :: i

    if (model%state%progress%fraction >= 1.0_wp .or. number == 1) then
      model%state%progress%phase = number
      call start_phase(model)
    end if
    do i = 1, size(fractions)
      call initialise_step(model, step, error)
      if (.not. allocated(error)) call solver%solve(model, step, model%analysis%phases(number)%controls, &
        attempt_type(fractions(i), tight, largest_move=1.0_wp), solution, error)
      call tests%check('a step of phase '//model%analysis%phases(number)%name//' is taken', solution%converged .and. &
        .not. allocated(error))
      model%state%progress%fraction = fractions(i)
    end do
  end subroutine run_phase

  !> Displacement along x of the ends: of the bar, and of the tie inside of it.
  real(wp) function end_of(model, prop)
    type(model_type), intent(in) :: model
    integer, intent(in) :: prop

    associate (tracer => model%prop_tracer(merge(1, 2, prop == 1), prop), tracers => model%state%tracers)
      end_of = tracers%position(1, tracer) - tracers%initial_position(1, tracer)
    end associate
  end function end_of

  !> Forces are stiffness times change of length; jacked and removed ones run to their value; a state that is put back
  !> has its own.
  subroutine check_phases(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    class(state_type), allocatable :: before
    real(wp) :: moved(2), tie

    allocate (model, step)
    call make_model(bar//'*PHASE, NAME=pull|'//fix//'*INSTALL|strut|tie|*TRACTION, SURFACE=end|10, 0|*END PHASE|'// &
      '*PHASE, NAME=jack, LOAD FACTOR=2|*INSTALL|strut, -1.5|*END PHASE|*PHASE, NAME=more|'// &
      '*TRACTION, SURFACE=end|11, 0|*END PHASE|*PHASE, NAME=out|*REMOVE|strut|*END PHASE|', model, step)
    call run_phase(tests, model, step, 1, [0.5_wp, 1.0_wp])
    call tests%check('the bar is pulled against the strut', end_of(model, 1) > 0.01_wp)
    call tests%close('which is pressed', prop_force(model, 'strut'), -100.0_wp*end_of(model, 1), 1.0e-12_wp)
    call tests%close('while the tie is pulled', prop_force(model, 'tie'), 200.0_wp*end_of(model, 2), 1.0e-12_wp)
    call tests%close('with the wall it holds what pulls', sum(model%state%reactions(1, :)) &
      + prop_force(model, 'strut'), -20.0_wp, 1.0e-6_wp)
    allocate (before, source=model%state)
    tie = prop_force(model, 'tie')
    call run_phase(tests, model, step, 2, [0.25_wp])
    call tests%close('a prop is jacked in proportion', prop_force(model, 'strut'), 0.75_wp*(-100.0_wp) &
      *(before%tracers%position(1, model%prop_tracer(1, 1)) - 4.0_wp) - 0.25_wp*3.0_wp, 1.0e-12_wp)
    call run_phase(tests, model, step, 2, [1.0_wp])
    call tests%close('to its force, per unit of the load factor', prop_force(model, 'strut'), -3.0_wp, 1.0e-12_wp)
    call tests%check('and others go on by their length', prop_force(model, 'tie') < tie)
    model%state = before
    call tests%close('a state that is put back has its forces', prop_force(model, 'tie'), tie, 0.0_wp)
    call run_phase(tests, model, step, 2, [0.5_wp, 1.0_wp])
    moved = [end_of(model, 1), prop_force(model, 'strut')]
    call run_phase(tests, model, step, 3, [1.0_wp])
    call tests%close('a jacked one is stiff in the phases behind', prop_force(model, 'strut'), moved(2) &
      - 100.0_wp*(end_of(model, 1) - moved(1)), 1.0e-12_wp)
    moved(2) = prop_force(model, 'strut')
    call run_phase(tests, model, step, 4, [0.5_wp])
    call tests%close('one that is taken out falls in proportion', prop_force(model, 'strut'), 0.5_wp*moved(2), &
      1.0e-12_wp)
    call run_phase(tests, model, step, 4, [1.0_wp])
    call tests%close('to nothing', prop_force(model, 'strut'), 0.0_wp, 1.0e-12_wp)
    call end_system(step%system)
  end subroutine check_phases

  !> At its limit the force stays; the way back is elastic from there, and the prop is too short then.
  subroutine check_limit(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    real(wp) :: far

    allocate (model, step)
    call make_model(bar//'*PHASE, NAME=pull|'//fix//'*INSTALL|strut|*TRACTION, SURFACE=end|30, 0|*END PHASE|'// &
      '*PHASE, NAME=back|*TRACTION, SURFACE=end|0, 0|*END PHASE|', model, step)
    call run_phase(tests, model, step, 1, [0.5_wp, 1.0_wp])
    far = end_of(model, 1)
    call tests%check('the strut would carry more', 100.0_wp*far > 5.0_wp)
    call tests%close('but yields', prop_force(model, 'strut'), -4.0_wp, 1.0e-12_wp)
    call run_phase(tests, model, step, 2, [0.5_wp, 1.0_wp])
    call tests%close('and goes back along its stiffness', prop_force(model, 'strut'), &
      -4.0_wp + 100.0_wp*(far - end_of(model, 1)), 1.0e-12_wp)
    call tests%check('into tension', prop_force(model, 'strut') > 0.1_wp)
    call end_system(step%system)
  end subroutine check_limit

  !> The matrix times a direction is the change of the residual along it: an inclined strut and tie that carry, a cavity
  !> that is free.
  subroutine check_matrix(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :), v(:, :), product(:), change(:)
    integer :: a

    allocate (model, step)
    call make_model(ring//'*PROP, NAME=strut, STIFFNESS=9e5, FIXED=YES|2.3, 5.1, 4, 7|*PROP, NAME=tie, '// &
      'STIFFNESS=7e5|-2.2, 4.7, 0.3, 5.6|*PHASE, NAME=one|*FIX|base, ALL|*INSTALL|strut|tie|'// &
      '*CONTRACTION, SURFACE=bore|1|*END PHASE|', model, step)
    call start_phase(model)
    call initialise_step(model, step, error)
    call begin_terms(step%terms, increment_type(step_info_type(duration=0.5_wp, phase_time=1.0_wp)))
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    allocate (u(2, all_nodes(step%unknowns)), v(2, all_nodes(step%unknowns)))
    do a = 1, size(u, 2)
      u(:, a) = 0.03_wp*[sin(1.7_wp*a), cos(2.3_wp*a)]
      v(:, a) = [cos(0.7_wp*a), sin(1.1_wp*a)]
    end do
    call matrix_and_difference(model, step, u, v, 1.0e-6_wp, product, change)
    ! The springs of the outline are the stiffest by far; what is left of the difference is little beside the props.
    call tests%close('the matrix is the derivative of the residual', maxval(abs(product - change)), 0.0_wp, &
      1.0e-8_wp*maxval(abs(change)))
    call tests%check('the props are in it', maxval(abs(force_named(step, 'force of the props', u))) &
      > 1.0e-5_wp*maxval(abs(change)))
    call tests%check('and the height of the cavity', any(step%field_of == 2) .and. &
      count(step%field_of == 2) == 1 .and. maxval(abs(product), mask=step%field_of == 2) > 1.0_wp)
    call end_system(step%system)
  end subroutine check_matrix

  !> A square cavity in a block closes to 99 % of its area and keeps its shape; as it is free no force is left on it and
  !> it finds another height. A second contraction counts from there, and holds it there.
  subroutine check_cavity(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    real(wp) :: drawn(2, 2), first(2, 2), second(2, 2)
    integer :: i, j

    allocate (model, step)
    call make_model(ring//'*PHASE, NAME=one|*FIX|base, ALL|*CONTRACTION, SURFACE=bore|1|*END PHASE|'// &
      '*PHASE, NAME=two, LOAD FACTOR=2|*CONTRACTION, SURFACE=bore, HELD=YES|1.5|*END PHASE|', model, step)
    call tests%close('19 % of the area is a tenth of the radius', closure_of(19.0_wp), 0.1_wp, 1.0e-14_wp)
    call tests%close('the middle is found', norm2(model%cavity_middle(:, 1) - [0.0_wp, 3.0_wp]), 0.0_wp, 1.0e-12_wp)
    call tests%check('soil inside of it is told: '//model%notes, index(model%notes, "body 'around' fills surface 'bore' "// &
      "in phase 'one'") > 0 .and. index(model%notes, "in phase 'two'") > 0)
    drawn = extent_of(model)
    call run_phase(tests, model, step, 1, [0.5_wp, 1.0_wp])
    first = extent_of(model)
    call tests%close('width and height are those of an area of 99 %', norm2(first(:, 2)/drawn(:, 2) - sqrt(0.99_wp)), &
      0.0_wp, 1.0e-4_wp)
    call tests%check('the cavity has found another height', abs(first(2, 1) - 3.0_wp) > 1.0e-4_wp)
    call tests%close('on its axis', first(1, 1), 0.0_wp, 1.0e-6_wp)
    call tests%close('without a force', sum(model%state%surface%reaction(2, :)), 0.0_wp, &
      1.0e-7_wp*sum(abs(model%state%surface%reaction(2, :))))
    call run_phase(tests, model, step, 2, [0.25_wp, 1.0_wp])
    second = extent_of(model)
    call tests%close('held it stays at that height, but for its middle as drawn', second(2, 1), 3.0_wp &
      + sqrt(0.97_wp)*(first(2, 1) - 3.0_wp), 2.0e-5_wp)
    call tests%close('what is lost next is lost of what was left', norm2(second(:, 2)/first(:, 2) - sqrt(0.97_wp)), &
      0.0_wp, 4.0e-4_wp)
    call tests%check('against a force', abs(sum(model%state%surface%reaction(2, :))) > 1.0e-3_wp)
    call end_system(step%system)
    deallocate (model, step)
    allocate (model, step)
    i = index(ring, 'SHAPE=BOX|')
    j = index(ring, '*METHOD')
    call make_model(ring(:i - 1)//'SHAPE=BOX|-3, -1, 0, 6|*BODY, NAME=right, MATERIAL=soil, SHAPE=BOX|1, 3, 0, 6|'// &
      '*BODY, NAME=floor, MATERIAL=soil, SHAPE=BOX|-1, 1, 0, 2|*BODY, NAME=roof, MATERIAL=soil, SHAPE=BOX|-1, 1, 4, 6|'// &
      '*BODY, NAME=core, MATERIAL=soil, SHAPE=BOX|-1, 1, 2, 4|'//ring(j:)//'*PHASE, NAME=rest|*FIX|base, ALL|'// &
      '*GRAVITY|0, -1|*END PHASE|*PHASE, NAME=one|*DEACTIVATE|core|*CONTRACTION, SURFACE=bore|1|*END PHASE|', model, step)
    call tests%check('none is left where it goes: '//model%notes, index(model%notes, 'fills') == 0)
    call end_system(step%system)
  end subroutine check_cavity

  !> Middle and extent of the points of the first surface (2, 2).
  function extent_of(model) result(place)
    type(model_type), intent(in) :: model
    real(wp) :: place(2, 2)
    integer :: c

    do c = 1, 2
      associate (x => pack(model%state%surface%position(c, :), model%state%surface%surface == 1))
        place(c, :) = [0.5_wp*(maxval(x) + minval(x)), maxval(x) - minval(x)]
      end associate
    end do
  end function extent_of

  !> What is wrong is told by name.
  subroutine check_decks(tests)
    type(tests_type), intent(inout) :: tests

    call refuses(bar//'*PHASE, NAME=a|'//fix//'*INSTALL|strat|*END PHASE|', "no prop 'strat' (did you mean strut?)")
    call refuses(bar//'*PHASE, NAME=a|'//fix//'*REMOVE|strut|*END PHASE|', "prop 'strut' is not there")
    call refuses(bar//'*PHASE, NAME=a|'//fix//'*INSTALL|strut, -5|*END PHASE|', 'exceeds the limit')
    call refuses(bar//'*PHASE, NAME=a|'//fix//'*INSTALL|strut|strut|*END PHASE|', 'given twice')
    call refuses(bar//'*PHASE, NAME=a|'//fix//'*INSTALL|tie|*END PHASE|*PHASE, NAME=b|*INSTALL|tie|*END PHASE|', &
      'is already active')
    call refuses(bar//'*PROP, NAME=none, STIFFNESS=1|1, 1, 1, 1|', 'the same place')
    call refuses(bar//'*PROP, NAME=air, STIFFNESS=1|1, 1, 4.8, 1|*PHASE, NAME=a|'//fix//'*GRAVITY|0, -1|*END PHASE|', &
      "the place of 'air' lies in no element")
    call refuses(bar//'*BODY, NAME=pit, MATERIAL=soil, SHAPE=BOX|4, 5, 0, 2|'// &
      '*PROP, NAME=strut 2, STIFFNESS=1|1, 1, 4.8, 1|'// &
      '*PHASE, NAME=a|'//fix//'*INSTALL|strut 2|*GRAVITY|0, -1|*END PHASE|*PHASE, NAME=b|*DEACTIVATE|pit|*END PHASE|', &
      "'strut 2' has no ground at its end in phase 'b'")
    call refuses(bar//'*HISTORY, NAME=f, QUANTITY=PROP FORCE|', 'requires the parameter PROP')
    call refuses(ring//'*PHASE, NAME=a|*CONTRACTION, SURFACE=arc|1|*END PHASE|', 'neither closed nor an arc')
    call refuses(ring//'*SURFACE, NAME=upper, TYPE=SEGMENT|-1, 3, -0.97, 3.26|-0.97, 3.26, -0.87, 3.5|'// &
      '*PHASE, NAME=a|*CONTRACTION, SURFACE=upper|1|*END PHASE|', 'HELD=YES')
    call refuses(ring//'*PHASE, NAME=a|*CONTRACTION, SURFACE=level|1|*END PHASE|', 'neither closed nor an arc')
    call refuses(ring//'*PHASE, NAME=a|*CONTRACTION, SURFACE=boor|1|*END PHASE|', '*CONTRACTION: there is no surface')
    call refuses(ring//'*PHASE, NAME=a|*CONTRACTION, SURFACE=bore|1|*SUPPORT, SURFACE=bore|*END PHASE|', &
      'support or contraction in this phase already')

  contains

    !> A deck is refused with a sentence.
    subroutine refuses(cards, sentence)
      character(len=*), intent(in) :: cards, sentence
      class(analysis_type), allocatable :: analysis
      class(model_type), allocatable :: model
      type(message_list_type) :: messages
      type(error_type), allocatable :: error
      character(len=:), allocatable :: text

      allocate (analysis, model)
      call parse_deck('props.inp', joined(cards), analysis, messages, error)
      text = message_text(messages)
      if (.not. allocated(error)) call build_model(analysis, model, error)
      if (allocated(error)) text = text//error%message
      call tests%check('refused: '//sentence//'; found: '//text, allocated(error) .and. index(text, sentence) > 0)
    end subroutine refuses
  end subroutine check_decks
end module test_props
