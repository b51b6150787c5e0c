!> Soil from which pore water flows in time: the matrix against differences, what flows and presses where nothing is
!> solved, where water leaves, time that stands still, and what is refused. Solutions are cases (consolidation.toml).
module test_consolidation
  use qsmpm_analysis, only: analysis_type
  use qsmpm_consolidation, only: drained_nodes, excess_field, excess_pressure, permeable_points
  use qsmpm_deck, only: parse_deck, message_list_type, message_text
  use qsmpm_element, only: corner_count
  use qsmpm_error, only: error_type
  use qsmpm_confined_modulus, only: confined_modulus
  use qsmpm_flow_balance, only: flow_balance_type
  use qsmpm_face_leak, only: face_layers_type, find_layers, terms_of_layer
  use qsmpm_initialisation, only: step_type, begin_analysis, initialise_step, evaluate_step
  use qsmpm_kept_arrays, only: keep_values, kept_values
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: step_info_type, tangent_none
  use qsmpm_linear_system, only: end_system
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_permeability_law, only: permeability_law_type, permeability_ratio, permeability_slope, &
    permeability_kozeny, permeability_logarithm
  use qsmpm_phase_start, only: start_phase
  use qsmpm_term, only: force_sizes_type, increment_type, term_type
  use qsmpm_term_sums, only: begin_terms, set_loads
  use qsmpm_unknowns, only: find_field, joint_node
  use deck_samples, only: joined
  use term_samples, only: force_named, matrix_and_difference, term_named, waves
  use testing, only: tests_type
  implicit none
  private

  public :: collect_consolidation

  !> Clay of 2 x 1 m beside dry rock of 1 m, air above, the clay's base open.
  character(len=*), parameter :: grid = '*GRID| X, 1, 4, 6| Y, 0, 1.5, 3|*NSET, NSET=base, PLANE=Y| 0|'// &
    '*NSET, NSET=top, PLANE=Y| 1|*NSET, NSET=middle, BOX| 1.5, 2.5, 0.2, 0.8|'// &
    '*NSET, NSET=left, PLANE=X| 1|*NSET, NSET=right, PLANE=X| 4|', &
    clay = '*MATERIAL, NAME=clay|*ELASTIC| 100, 0.2|*PERMEABILITY| 0.3, 0.2|', &
    rock = '*MATERIAL, NAME=rock|*ELASTIC| 1000, 0.2|*PERMEABILITY| 0|', &
    bodies = '*BODY, NAME=soil, MATERIAL=clay, SHAPE=BOX| 1, 3, 0, 1|*BODY, NAME=rock, MATERIAL=rock, SHAPE=BOX| 3, 4, 0, 1|', &
    load = '*PHASE, NAME=load, TIME=3|*FIX| base, ALL| left, X| right, X|*GRAVITY| 0, -1|', &
    cube = '*MODEL, TYPE=3D|*GRID, ELEMENT=HEX20| X, 0, 1, 1| Y, 0, 1, 1| Z, 0, 1, 1|*NSET, NSET=base, PLANE=Z| 0|'// &
      '*NSET, NSET=side, PLANE=Y| 1|*MATERIAL, NAME=clay|*ELASTIC| 100, 0.2|*PERMEABILITY| 0.3|*BODY, NAME=soil, '// &
      'MATERIAL=clay, SHAPE=ALL|*SURFACE, '// &
      'NAME=top| 0, 1, 0, 1, 1, 1|*PHASE, NAME=load, TIME=3|*FIX| base, ALL| side, Y|*PRESSURE, SURFACE=top| 1|', &
    flow = '*CONSOLIDATION, UNIT WEIGHT=10, STORAGE=2E-3| base, OPEN|', &
    tight = '*CONSOLIDATION, UNIT WEIGHT=10, STORAGE=2E-3| top, CLOSED|', &
    !> Time of a phase in which no front leaves its cell: 0.1 h^2/c is 0.0055.
    brief = '4E-4'

contains

  !> All checks.
  subroutine collect_consolidation(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('consolidation')
    call check_tangent(tests, 'PLANE STRAIN')
    call check_tangent(tests, 'AXISYMMETRIC')
    call check_tangent(tests, 'PLANE STRAIN', brief)
    call check_tangent(tests, 'PLANE STRAIN', law=', LAW=KOZENY, VOID RATIO=1.8')
    call check_tangent(tests, 'AXISYMMETRIC', law=', LAW=LOGARITHM, VOID RATIO=1.8, CK=0.7')
    call check_times(tests)
    call check_forces(tests)
    call check_layer(tests)
    call check_leak(tests, 'PLANE STRAIN', 2.0_wp)
    call check_leak(tests, 'AXISYMMETRIC', 4.0_wp)
    call check_drainage(tests)
    call check_space(tests, 'TET10')
    call check_space(tests, 'WEDGE15')
    call check_note(tests)
    call check_background(tests)
    call check_void_ratio(tests)
    call check_refusals(tests)
  end subroutine collect_consolidation

  !> The matrix times a direction of displacements and pressures is the change of the residual along it.
  subroutine check_tangent(tests, kind, time, law)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind
    character(len=*), intent(in), optional :: time, law
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: product(:), change(:)

    allocate (model, step)
    call make_step(kind, flow, model, step, time=time, law=law)
    call matrix_and_difference(model, step, waves(step, 0.3_wp), waves(step, 1.1_wp), 1.0e-5_wp, product, change)
    call tests%close('the matrix is the derivative of the residual, '//kind, maxval(abs(product - change)), 0.0_wp, &
      1.0e-6_wp*maxval(abs(product)))
    call tests%check('which has pressures in it', count(step%field_of == 2) > 3)
    call end_system(step%system)
  end subroutine check_tangent

  !> What nodes take up as t^2 flows in at the rate of the end of a step, 2 t, whatever it was before; a first step has
  !> the mean rate, and so has one that is much longer than that before.
  subroutine check_times(tests)
    type(tests_type), intent(inout) :: tests
    type(flow_balance_type) :: water
    real(wp), parameter :: t(3) = [0.2_wp, 0.5_wp, 1.1_wp]
    real(wp) :: taken(2)

    taken = t(2:)**2 - t(:2)**2
    water%leaks = [.false., .true.]
    water%layers%capacity = [0.0_wp, 0.0_wp]
    call water%set_time(t(3) - t(2), t(2) - t(1), [taken(1), taken(1)])
    call tests%close('the rate at the end of a step', (taken(2) - water%carried(1))/water%flow_time, 2.0_wp*t(3), 1.0e-14_wp)
    call tests%close('layers at faces know their time', water%carried(2), 0.0_wp, 0.0_wp)
    water%total = .true.
    water%kept = [0.0_wp, 0.0_wp]
    water%bounds%rain = [3.0_wp, 0.0_wp]
    call tests%close('rain falls as water flows, at the rate of the end', sum(water%standing_flow()), &
      -water%carried(1) - 3.0_wp*water%flow_time, 1.0e-14_wp)
    water%total = .false.
    call tests%close('on a free surface alone', sum(water%standing_flow()), -water%carried(1), 1.0e-14_wp)
    call water%set_time(t(3) - t(2), 0.0_wp, [taken(1), taken(1)])
    call tests%close('the mean one in a first step', (taken(2) - water%carried(1))/water%flow_time, t(2) + t(3), 1.0e-14_wp)
    call water%set_time(0.75_wp, 0.3_wp, [taken(1), taken(1)])
    call tests%close('and in one 2.5 times as long as that before', water%carried(1), 0.0_wp, 0.0_wp)
  end subroutine check_times

  !> An even pressure presses on the outline alone; one that falls evenly flows evenly; a stretch draws water.
  subroutine check_forces(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: table(:, :), force(:, :)
    type(force_sizes_type) :: sizes
    class(term_type), pointer :: term
    integer :: a, n, field
    real(wp) :: out

    allocate (model, step)
    call make_step('PLANE STRAIN', tight, model, step)
    n = model%space%node_count
    field = find_field(step%unknowns, excess_field)
    allocate (table, source=0.0_wp*waves(step, 0.0_wp))
    ! p = 5: the side at x = 1, of 1 m, is pushed to the left by 5, the rock at x = 3 to the right.
    do a = 1, n
      table(1, joint_node(step%unknowns, a, field)) = 5.0_wp
    end do
    allocate (force, source=force_named(step, 'flow of the pore water', table))
    call tests%close('an even pressure pushes the side', sum(force(1, :n), mask=at(1, 1.0_wp)), 5.0_wp, 1.0e-12_wp)
    call tests%close('and the rock', sum(force(1, :n), mask=at(1, 3.0_wp)), -5.0_wp, 1.0e-12_wp)
    call tests%close('nothing else along x', sum(abs(force(1, :n)), mask=.not. (at(1, 1.0_wp) .or. at(1, 3.0_wp))), &
      0.0_wp, 1.0e-11_wp)
    out = sum(force(1, [(joint_node(step%unknowns, a, field), a=1, n)]))
    call tests%close('it is stored: S p V', out, 2.0e-3_wp*5.0_wp*2.0_wp, 1.0e-12_wp)
    ! p = 7 x: k/gamma_w dp/dx dt H = 0.3/10*7*0.75*1 comes in at x = 3, beside what is stored.
    do a = 1, n
      table(1, joint_node(step%unknowns, a, field)) = 7.0_wp*model%mesh%coordinates(1, a)
    end do
    force = force_named(step, 'flow of the pore water', table)
    out = sum([(model%mesh%coordinates(1, a)*force(1, joint_node(step%unknowns, a, field)), a=1, n)])
    ! sum x_a flow_a = S int 7 x^2 + k/gamma_w dt int 7.
    call tests%close('one that falls flows by k_x', out, 2.0e-3_wp*7.0_wp*26.0_wp/3.0_wp &
      + 0.03_wp*0.75_wp*7.0_wp*2.0_wp, 1.0e-10_wp)
    table = 0.0_wp
    do a = 1, n
      table(2, a) = 0.01_wp*model%mesh%coordinates(2, a)
    end do
    force = force_named(step, 'flow of the pore water', table)
    call tests%close('a stretch by 1 % draws its volume', sum(force(1, [(joint_node(step%unknowns, a, field), &
      a=1, n)])), 0.02_wp, 1.0e-12_wp)
    call evaluate_step(model, step, table, tangent_none)
    allocate (sizes%force, source=0.0_wp*table)
    term => term_named(step, 'flow of the pore water')
    call term%add_sizes(sizes)
    call tests%close('which is the size of the flows', sum(sizes%force(1, [(joint_node(step%unknowns, a, field), &
      a=1, n)])), 0.02_wp, 1.0e-12_wp)
    call end_system(step%system)
  contains
    !> Nodes with a coordinate.
    function at(axis, value)
      integer, intent(in) :: axis
      real(wp), intent(in) :: value
      logical :: at(model%space%node_count)

      at = abs(model%mesh%coordinates(axis, :model%space%node_count) - value) < 1.0e-9_wp
    end function at
  end subroutine check_forces

  !> What is left of a pressure that comes at once is its error function; a step is as two halves; p and what leaves make
  !> up the pressure without flow.
  subroutine check_layer(tests)
    type(tests_type), intent(inout) :: tests
    type(face_layers_type) :: layers, whole
    real(wp) :: time, mean, flow, slope, other, half(terms_of_layer)
    integer :: i, j
    integer, parameter :: parts = 2000

    allocate (layers%capacity, source=[0.0_wp, 2.0_wp])
    allocate (layers%pace, source=[0.0_wp, 3.0_wp])
    allocate (layers%beyond(terms_of_layer, 2), source=0.0_wp)
    do i = -3, 3
      time = 10.0_wp**i/3.0_wp
      call layers%set_time(time)
      call tests%close('what is left is erfc (12 c t/h^2)^1/2', 1.0_wp - layers%left(2), erf(sqrt(3.0_wp*time)), &
        0.05_wp*erf(sqrt(3.0_wp*time)))
      mean = 0.0_wp
      do j = 1, parts
        mean = mean + erfc(sqrt(3.0_wp*time*(j - 0.5_wp)/parts))/parts
      end do
      call tests%close('of what comes evenly its mean', 1.0_wp - layers%follows(2), 1.0_wp - mean, 0.05_wp*(1.0_wp - mean))
    end do
    call layers%set_time(1.0e-9_wp)
    call tests%close('in no time all of it', layers%follows(2), 1.0_wp, 1.0e-4_wp)
    call layers%set_time(0.1_wp)
    call layers%outflow(2, 5.0_wp, 4.0_wp, flow, slope)
    ! dJ = dp + w/C, and p at the end is left of 5 and follows of dJ.
    call tests%close('p and what leaves are what there would be', layers%left(2)*5.0_wp &
      + layers%follows(2)*(-1.0_wp + flow/2.0_wp), 4.0_wp, 1.0e-12_wp)
    call layers%outflow(2, 5.0_wp, 4.5_wp, other, slope)
    call tests%close('its derivative', slope, (other - flow)/0.5_wp, 1.0e-10_wp)
    layers%beyond(:, 2) = layers%beyond_after(2, 5.0_wp, 4.0_wp)
    call layers%set_time(0.0_wp)
    call tests%close('the terms sum to p', layers%past(2), 0.0_wp, 1.0e-12_wp)
    call layers%outflow(2, 4.0_wp, 7.0_wp, flow, slope)
    call tests%close('in no time nothing leaves', flow, 0.0_wp, 1.0e-12_wp)
    ! A whole step and two halves of it in which J stays.
    whole = layers
    call whole%set_time(0.2_wp)
    call layers%set_time(0.1_wp)
    other = layers%left(2)*4.0_wp + layers%past(2)
    half = layers%beyond_after(2, 4.0_wp, other)
    layers%beyond(:, 2) = half
    call layers%set_time(0.1_wp)
    call tests%close('two halves are a whole', layers%left(2)*other + layers%past(2), whole%left(2)*4.0_wp &
      + whole%past(2), 1.0e-12_wp)
  end subroutine check_layer

  !> Nodes of drained faces are free; what leaves there is in the flow, and what flows to them within is not.
  subroutine check_leak(tests, kind, top)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind
    !> Area of the top, of the base, and volume.
    real(wp), intent(in) :: top
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    logical, allocatable :: drained(:), constrained(:, :)
    real(wp), allocatable :: table(:, :), values(:, :), pressure(:)
    type(face_layers_type) :: layers
    class(term_type), pointer :: term
    real(wp), parameter :: modulus = 1000.0_wp/9.0_wp
    real(wp) :: leaves, slope, stored
    integer :: a, field

    allocate (model, step)
    call make_step(kind, flow, model, step, time=brief)
    field = find_field(step%unknowns, excess_field)
    allocate (drained, source=drained_nodes(model, model%analysis%phases(1)%consolidation))
    allocate (pressure(size(drained)), source=0.0_wp)
    call tests%close('M of the elastic law', confined_modulus(model, 1, 1.0_wp), modulus, 1.0e-4_wp*modulus)
    call tests%close('as it swells too', confined_modulus(model, 1, -1.0_wp), modulus, 1.0e-4_wp*modulus)
    call find_layers(model, pressure, drained, 10.0_wp, .false., layers)
    call tests%close('by each face, '//kind, sum(layers%capacity), 2.0_wp*top*0.5_wp/(sqrt(12.0_wp)*modulus), &
      2.0e-2_wp*sum(layers%capacity))
    call tests%check('by no other', all(layers%capacity <= 0.0_wp .or. drained))
    ! The greater permeability, 0.3/10, in rows of 0.5.
    call tests%close('12 c/h^2', maxval(layers%pace), 12.0_wp*0.03_wp*modulus/0.25_wp, 1.0e-3_wp*maxval(layers%pace))
    allocate (table, source=0.0_wp*waves(step, 0.0_wp))
    do a = 1, model%space%node_count
      table(1, joint_node(step%unknowns, a, field)) = 5.0_wp
    end do
    call layers%set_time(1.0e-4_wp)
    stored = 5.0_wp*2.0e-3_wp*top
    do a = 1, size(drained)
      if (.not. layers%capacity(a) > 0.0_wp) cycle
      call layers%outflow(a, 0.0_wp, 5.0_wp, leaves, slope)
      stored = stored + leaves
    end do
    call tests%close('in a first step of 0.0001', out(), stored, 1.0e-10_wp)
    term => term_named(step, 'flow of the pore water')
    allocate (constrained(size(table, 1), size(table, 2)), source=.false.)
    allocate (values, source=0.0_wp*table)
    call term%prescribe(model, 0.5_wp, constrained, values)
    call tests%check('no p is held there', .not. any([(constrained(1, joint_node(step%unknowns, a, field)), a=1, &
      size(drained))] .and. layers%capacity > 0.0_wp))
    call term%keep_nodal(table, model%state%kept)
    call tests%check('nothing is remembered where p is 0', all(abs(kept_values(model%state%kept, &
      'excess pressure of layers at faces')) <= 0.0_wp .or. spread(layers%capacity > 0.0_wp, 1, terms_of_layer)))
    call find_layers(model, pressure, drained, 10.0_wp, .true., layers)
    call tests%check('in a short phase', any(layers%capacity > 0.0_wp))
    call end_system(step%system)
    call make_step(kind, flow, model, step)
    call find_layers(model, pressure, drained, 10.0_wp, .true., layers)
    call tests%check('in a long one none where only short ones count', all(layers%capacity <= 0.0_wp))
    call end_system(step%system)
    call make_step(kind, '*CONSOLIDATION, UNIT WEIGHT=10, FACES=HELD|', model, step)
    term => term_named(step, 'flow of the pore water')
    constrained = .false.
    call term%prescribe(model, 0.5_wp, constrained, values)
    drained = drained_nodes(model, model%analysis%phases(1)%consolidation)
    call tests%check('nodes that are to be held are', any(drained) .and. all([(constrained(1, joint_node(step%unknowns, &
      a, field)), a=1, size(drained))] .eqv. drained))
    call end_system(step%system)
  contains
    !> What flows out of all nodes.
    real(wp) function out()
      real(wp), allocatable :: force(:, :)

      allocate (force, source=force_named(step, 'flow of the pore water', table))
      out = sum(force(1, [(joint_node(step%unknowns, a, field), a=1, model%space%node_count)]))
    end function out
  end subroutine check_leak

  !> Water leaves to the air and at open sets, not into rock and not at the sides.
  subroutine check_drainage(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: nodal(:, :), pressure(:)
    logical, allocatable :: open(:), held(:)
    integer :: p, a, field

    allocate (model, step)
    call make_step('PLANE STRAIN', flow, model, step)
    open = drained_nodes(model, model%analysis%phases(1)%consolidation)
    associate (x => model%mesh%coordinates(1, :), y => model%mesh%coordinates(2, :))
      call tests%check('the top of the clay is open', any(open .and. y > 0.999_wp .and. y < 1.001_wp .and. x > 1.3_wp &
        .and. x < 2.7_wp))
      call tests%check('its base, for it is said', any(open .and. y < 0.001_wp))
      call tests%check('not its inside, its side and the rock beside it', .not. any(open .and. y > 0.2_wp .and. &
        y < 0.8_wp))
    end associate
    ! A pressure that varies evenly is that at the points of the clay; the rock has none.
    allocate (nodal, source=kept_values(model%state%kept, excess_field))
    nodal(1, :) = model%mesh%coordinates(2, :size(nodal, 2))
    call keep_values(model%state%kept, excess_field, nodal)
    pressure = excess_pressure(model)
    call tests%close('points have the pressure of their place', maxval([(abs(pressure(p) &
      - merge(model%state%points%position(2, p), 0.0_wp, model%state%points%position(1, p) < 3.0_wp)), &
      p=1, size(pressure))]), 0.0_wp, 1.0e-12_wp)
    call end_system(step%system)
    call make_step('PLANE STRAIN', '*CONSOLIDATION, UNIT WEIGHT=10|', model, step, top='1')
    open = drained_nodes(model, model%analysis%phases(1)%consolidation)
    associate (x => model%mesh%coordinates(1, :), y => model%mesh%coordinates(2, :))
      call tests%check('where the grid ends with the ground its upper side is open', any(open .and. x > 1.3_wp .and. &
        x < 2.7_wp) .and. all(y > 0.999_wp .or. .not. open))
    end associate
    call end_system(step%system)
    call make_step('PLANE STRAIN', flow//' middle, OPEN|', model, step)
    open = drained_nodes(model, model%analysis%phases(1)%consolidation)
    field = find_field(step%unknowns, excess_field)
    allocate (held, source=[(step%equations%constrained(1, joint_node(step%unknowns, a, field)), a=1, size(open))])
    associate (x => model%mesh%coordinates(1, :), y => model%mesh%coordinates(2, :))
      call tests%check('at a set within the pressure is held', any(held) .and. all(held .or. .not. (open .and. &
        y > 0.2_wp .and. y < 0.8_wp)))
      call tests%check('not at faces', any(.not. held .and. y < 0.001_wp) .and. any(.not. held .and. x < 2.9_wp .and. &
        abs(y - 1.0_wp) < 0.001_wp))
    end associate
    call end_system(step%system)
    call make_step('PLANE STRAIN', '*CONSOLIDATION, UNIT WEIGHT=10| base, OPEN| base, CLOSED|', model, step)
    open = drained_nodes(model, model%analysis%phases(1)%consolidation)
    model%analysis%materials(1)%permeability = [0.3_wp, 0.0_wp, 0.0_wp]
    call tests%check('soil that lets water through along x alone has water', count(permeable_points(model)) > 0 .and. &
      count(permeable_points(model)) < model%state%points%count)
    call tests%check('the last word on a set counts', .not. any(open .and. model%mesh%coordinates(2, :) < 0.001_wp))
    call end_system(step%system)
  end subroutine check_drainage

  !> In space: water leaves at the top alone, flows along each axis by the permeability there, and the matrix is the
  !> derivative.
  subroutine check_space(tests, element)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: element
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: table(:, :), force(:, :), product(:), change(:)
    logical, allocatable :: open(:)
    type(face_layers_type) :: layers
    integer :: a, k, n, field
    !> k/gamma_w of the axes, time of the step, volume.
    real(wp), parameter :: along(3) = [0.03_wp, 0.02_wp, 0.07_wp], time = 0.75_wp, volume = 3.0_wp

    allocate (model, step)
    call begin_step(deck('3', 'HELD'), model, step)
    n = model%space%node_count
    open = drained_nodes(model, model%analysis%phases(1)%consolidation)
    associate (x => model%mesh%coordinates, corner => is_corner(model))
      call tests%check('the top of '//element//' alone is open', all((open .eqv. x(3, :) > 0.999_wp) .or. .not. corner))
      field = find_field(step%unknowns, excess_field)
      do k = 1, 3
        if (.not. allocated(table)) allocate (table, source=0.0_wp*waves(step, 0.0_wp))
        do a = 1, n
          table(1, joint_node(step%unknowns, a, field)) = 7.0_wp*x(k, a)
        end do
        force = force_named(step, 'flow of the pore water', table)
        call tests%close('a pressure flows by the permeability of its axis', sum([(x(k, a)*force(1, &
          joint_node(step%unknowns, a, field)), a=1, n)]), along(k)*time*7.0_wp*volume, 1.0e-10_wp)
      end do
    end associate
    call matrix_and_difference(model, step, waves(step, 0.3_wp), waves(step, 1.1_wp), 1.0e-5_wp, product, change)
    call tests%close('the matrix is the derivative of the residual, '//element, maxval(abs(product - change)), 0.0_wp, &
      1.0e-6_wp*maxval(abs(product)))
    call end_system(step%system)
    call begin_step(deck('1E-3', 'LAYER'), model, step)
    call find_layers(model, [(0.0_wp, a=1, n)], open, 10.0_wp, .false., layers)
    call tests%close('water leaves by its top, of 3 m2: A h/(12^1/2 M)', sum(layers%capacity), 3.0_wp*0.5_wp*9.0_wp &
      /(sqrt(12.0_wp)*1000.0_wp), 2.0e-2_wp*sum(layers%capacity))
    call end_system(step%system)
  contains
    !> A block of which a phase takes some time.
    function deck(time, faces)
      character(len=*), intent(in) :: time, faces
      character(len=:), allocatable :: deck

      deck = '*MODEL, TYPE=3D|*METHOD, BASIS=FEM|*GRID, ELEMENT='//element//'| X, 0, 2, 2| Y, 0, 1.5, 2| Z, 0, 1, 2|'// &
        '*NSET, NSET=base, PLANE=Z| 0|*MATERIAL, NAME=clay|*ELASTIC| 100, 0.2|*PERMEABILITY| 0.3, 0.2, 0.7|'// &
        '*BODY, NAME=soil, MATERIAL=clay, SHAPE=ALL|*PHASE, NAME=load, TIME='//time//'|*FIX| base, ALL|'// &
        '*GRAVITY| 0, 0, -1|*CONSOLIDATION, UNIT WEIGHT=10, FACES='//faces//'|*END PHASE|'
    end function deck

    !> Nodes that are corners of cells.
    function is_corner(model) result(corner)
      type(model_type), intent(in) :: model
      logical :: corner(model%mesh%node_count)
      integer :: c

      corner = .false.
      do c = 1, model%mesh%cell_count
        associate (first => model%mesh%cell_first(c))
          corner(model%mesh%cell_nodes(first:first + corner_count(model%mesh%cell_kind(c)) - 1)) = .true.
        end associate
      end do
    end function is_corner
  end subroutine check_space

  !> Permeability follows the void ratio: e = 1.1 of 1.8 where the volume is three quarters.
  subroutine check_void_ratio(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: table(:, :), force(:, :)
    real(wp) :: flow_out(2)
    integer :: a, i, field

    call tests%close('a constant one stays', permeability_ratio(permeability_law_type(), 0.75_wp), 1.0_wp, 0.0_wp)
    call tests%close('Kozeny', permeability_ratio(permeability_law_type(permeability_kozeny, 1.8_wp), 0.75_wp), &
      (1.1_wp/1.8_wp)**3*2.8_wp/2.1_wp, 1.0e-14_wp)
    call tests%close('logarithm', permeability_ratio(permeability_law_type(permeability_logarithm, 1.8_wp, 0.7_wp), 0.75_wp), &
      0.1_wp, 1.0e-14_wp)
    call tests%close('the slope of Kozeny''s', permeability_slope(permeability_law_type(permeability_kozeny, 1.8_wp), &
      0.75_wp), (1.1_wp/1.8_wp)**3*2.8_wp**2/2.1_wp*(3.0_wp/1.1_wp - 1.0_wp/2.1_wp), 1.0e-14_wp)
    call tests%close('soil without voids is tight', permeability_ratio(permeability_law_type(permeability_kozeny, 1.8_wp), &
      0.3_wp), 0.0_wp, 0.0_wp)
    allocate (model, step)
    do i = 1, 2
      call make_step('PLANE STRAIN', tight, model, step, law=', LAW=LOGARITHM, VOID RATIO=1.8, CK=0.7')
      if (i == 2) model%state%points%initial_volume = model%state%points%volume/0.75_wp
      call prepare(model, step)
      field = find_field(step%unknowns, excess_field)
      if (.not. allocated(table)) allocate (table, source=0.0_wp*waves(step, 0.0_wp))
      do a = 1, model%space%node_count
        table(1, joint_node(step%unknowns, a, field)) = 7.0_wp*model%mesh%coordinates(1, a)
      end do
      force = force_named(step, 'flow of the pore water', table)
      flow_out(i) = sum([(model%mesh%coordinates(1, a)*force(1, joint_node(step%unknowns, a, field)), &
        a=1, model%space%node_count)])
      call end_system(step%system)
    end do
    ! Beside what is stored, S int 7 x^2.
    flow_out = flow_out - 2.0e-3_wp*7.0_wp*26.0_wp/3.0_wp
    call tests%close('a tenth flows', flow_out(2), 0.1_wp*flow_out(1), 1.0e-10_wp)
  end subroutine check_void_ratio

  !> A step from what the model is.
  subroutine prepare(model, step)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    type(error_type), allocatable :: error

    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'a step of the consolidation suite cannot be made'
    call begin_terms(step%terms, increment_type(step_info_type(duration=0.25_wp, phase_time=3.0_wp)))
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
  end subroutine prepare

  !> Soils that drain to nodes at which the pressure falls at once are named: c = k M/gamma_w is 2.2, h 0.6.
  subroutine check_note(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    character(len=*), parameter :: inner = flow//' middle, OPEN|'

    allocate (model, step)
    call make_step('PLANE STRAIN', flow, model, step, time='0.01')
    call tests%check('faces are no such nodes', index(model%notes, 'drains to more permeable soil,') == 0)
    call end_system(step%system)
    call make_step('PLANE STRAIN', inner, model, step, time='0.1')
    ! c t/h^2 = 0.59, of which 1/16 is 0.11.
    call tests%check('a node set within is', index(model%notes, "phase 'load': 'clay' drains to "// &
      'more permeable soil, to a node set within the ground or to a face of fixed pressure, in cells of 0.61 there') > 0)
    call tests%check('by how much', index(model%notes, 'may be 11 % too large; use grid lines at a distance of '// &
      '0.42 there') > 0 .and. &
      index(model%notes, "warning: phase 'load'") == 0)
    call end_system(step%system)
    call make_step('PLANE STRAIN', inner, model, step, time='0.001')
    call tests%check('a warning in a short phase', index(model%notes, "warning: phase 'load': 'clay' drains") > 0)
    call end_system(step%system)
    call make_step('PLANE STRAIN', inner, model, step)
    call tests%check('nothing in a long one', index(model%notes, 'drains to more permeable soil,') == 0)
    call end_system(step%system)
    call make_step('PLANE STRAIN', '*CONSOLIDATION, UNIT WEIGHT=10, FACES=HELD|', model, step, time='0.1')
    call tests%check('held faces are', index(model%notes, "phase 'load': 'clay' drains") > 0)
    call end_system(step%system)
    call tests%check('nothing is said of a permeability that stays', index(model%notes, 'has no effect') == 0)
    call make_step('PLANE STRAIN', flow, model, step, law=', LAW=KOZENY, VOID RATIO=1.8')
    call tests%check('nor of one that follows', index(model%notes, 'has no effect') == 0)
    call end_system(step%system)
    call make_step('PLANE STRAIN', '', model, step, law=', LAW=KOZENY, VOID RATIO=1.8')
    call tests%check('a law without consolidation has no effect', index(model%notes, "material 'clay': LAW=KOZENY of "// &
      '*PERMEABILITY has no effect without *CONSOLIDATION') > 0 .and. index(model%notes, 'LAW=CONSTANT') == 0)
    call end_system(step%system)
    call check_closed('', .true.)
    call check_closed('*GRAVITY| 0, 0, -1|', .false.)

  contains

    !> Upwards without gravity is y, along which nothing ends in a cube of ground up to z.
    subroutine check_closed(gravity, expected)
      character(len=*), intent(in) :: gravity
      logical, intent(in) :: expected
      character(len=:), allocatable :: notes

      call begin_step('*METHOD, BASIS=FEM|'//cube//gravity//flow(:index(flow, '|'))//'*END PHASE|', model, step)
      call start_phase(model, notes)
      call tests%check('ground that no water leaves: '//gravity, expected .eqv. index(notes, "phase 'load': no "// &
        'boundary is drained. Drained are exposed faces, those at the top of the mesh along y') > 0)
      call end_system(step%system)
    end subroutine check_closed
  end subroutine check_note

  !> No grid of splines stands behind the triangles: pressures of nodes would be lost with them.
  subroutine check_background(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step

    allocate (model, step)
    call make_step('PLANE STRAIN', flow, model, step)
    call tests%check('soil that consolidates stays on its triangles', .not. allocated(model%analysis%backgrounds))
    call end_system(step%system)
    call make_step('PLANE STRAIN', '', model, step)
    call tests%check('other soil may leave them', allocated(model%analysis%backgrounds))
    call end_system(step%system)
  end subroutine check_background

  !> What cannot consolidate.
  subroutine check_refusals(tests)
    type(tests_type), intent(inout) :: tests

    call refused(tests, grid//clay//bodies//rock//'*PHASE, NAME=load|*FIX| base, ALL|*GRAVITY| 0, -1|'//flow// &
      '*END PHASE|', "phase 'load' has *CONSOLIDATION and requires TIME=")
    call refused(tests, grid//clay//rock//bodies//load//flow//'*END PHASE|*PHASE, NAME=next|*CONTROLS, STEPS=2|'// &
      '*END PHASE|', "phase 'next' has *CONSOLIDATION and requires TIME=")
    call refused(tests, grid//clay//rock//bodies//load//'*CONSOLIDATION, UNIT WEIGHT=10| basis, OPEN|*END PHASE|', &
      'basis')
    call refused(tests, grid//'*MATERIAL, NAME=clay|*ELASTIC| 100, 0.2|'//rock//bodies//load//flow//'*END PHASE|', &
      "material 'clay' has no *PERMEABILITY")
    call refused(tests, grid//clay//'*MATERIAL, NAME=dry|*ELASTIC| 100, 0.2|'//rock//bodies//'*BODY, NAME=lift, '// &
      'MATERIAL=dry, SHAPE=BOX, ACTIVE=NO| 1, 3, 1, 1.5|'//load//flow//'*END PHASE|*PHASE, NAME=next, TIME=1|*ACTIVATE|'// &
      ' lift|*END PHASE|', "material 'dry' has no *PERMEABILITY")
    call refused(tests, grid//clay//'*MATERIAL, NAME=dry|*ELASTIC| 100, 0.2|'//rock//bodies//'*BODY, NAME=lift, '// &
      'MATERIAL=dry, SHAPE=BOX, ACTIVE=NO| 1, 3, 1, 1.5|'//load//flow//'*END PHASE|*PHASE, NAME=next, TIME=1|*ACTIVATE|'// &
      ' lift|*END PHASE|', "body 'lift' consolidates in phase 'load'", absent=.true.)
    call refused(tests, grid//'*MATERIAL, NAME=clay|*ELASTIC| 100, 0.2|*PERMEABILITY, LAW=KOZENY| 1|'//rock//bodies//load// &
      flow//'*END PHASE|', 'LAW requires the parameter VOID RATIO')
    call refused(tests, grid//'*MATERIAL, NAME=clay|*ELASTIC| 100, 0.2|*PERMEABILITY, LAW=LOGARITHM, VOID RATIO=1| 1|'// &
      rock//bodies//load//flow//'*END PHASE|', 'requires the parameter CK')
    call refused(tests, grid//clay//'*UNDRAINED, TYPE=A|'//rock//bodies//load//flow//'*END PHASE|', &
      'which itself models undrained response in short times')
    call refused(tests, '*GRID, ELEMENT=QUAD4'//grid(6:)//clay//rock//bodies//load//flow//'*END PHASE|', &
      'requires quadratic elements that move with the material: *GRID without ELEMENT, no *METHOD')
    call refused(tests, cube//flow(:index(flow, '|'))//'*END PHASE|', 'ELEMENT=HEX20 with *METHOD, BASIS=FEM')
    call refused(tests, grid//clay//'*MOHR COULOMB| 1, 20, 0|'//rock//bodies//load// &
      '*END PHASE|*PHASE, NAME=f, TYPE=SAFETY, TIME=1|'//flow//'*END PHASE|', 'no time passes')
  end subroutine check_refusals

  !> A deck is refused with these words.
  subroutine refused(tests, deck, words, absent)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: deck, words
    !> Not with these.
    logical, intent(in), optional :: absent
    class(analysis_type), allocatable :: analysis
    class(model_type), allocatable :: model
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: said

    allocate (analysis, model)
    said = deck
    if (index(deck, '*MODEL') == 0) said = '*MODEL, TYPE=PLANE STRAIN|'//deck
    call parse_deck('soil.inp', joined(said), analysis, messages, error)
    said = message_text(messages)
    if (.not. allocated(error)) then
      call build_model(analysis, model, error)
      if (allocated(error)) said = error%message
    end if
    call tests%check(words, (index(said, words) > 0) .neqv. present(absent))
  end subroutine refused

  !> The step of the plane scene.
  subroutine make_step(kind, card, model, step, top, law, time)
    character(len=*), intent(in) :: kind, card
    !> Height of the grid where it is not 1.5.
    character(len=*), intent(in), optional :: top
    !> Parameters of *PERMEABILITY of the clay.
    character(len=*), intent(in), optional :: law
    !> In place of 3.
    character(len=*), intent(in), optional :: time
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    character(len=:), allocatable :: lines, phase, soil
    integer :: at

    lines = grid
    at = index(grid, '1.5')
    if (present(top)) lines = grid(:at - 1)//top//grid(at + 3:)
    phase = load
    if (present(time)) phase = load(:index(load, '=3'))//time//load(index(load, '=3') + 2:)
    soil = clay
    at = index(clay, '*PERMEABILITY') + len('*PERMEABILITY')
    if (present(law)) soil = clay(:at - 1)//law//clay(at:)
    call begin_step('*MODEL, TYPE='//kind//'|'//lines//soil//rock//bodies//phase//card//'*END PHASE|', model, step)
  end subroutine make_step

  !> A step of a quarter of the phase of 3, prepared.
  subroutine begin_step(deck, model, step)
    character(len=*), intent(in) :: deck
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('soil.inp', joined(deck), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'a deck of the consolidation suite is broken'
    call begin_analysis(model, step%terms)
    call start_phase(model)
    call prepare(model, step)
  end subroutine begin_step
end module test_consolidation
