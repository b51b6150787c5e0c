!> Tests of bodies whose outline is carried: in a deformed body that the grid cuts the integration points and the loaded
!> surfaces satisfy the divergence theorem for every function of the mesh; dividing an outline keeps it.
module test_outlines
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_carried_basis, only: basis_at
  use qsmpm_carried_outline, only: divide_polygon, divide_facets, part_sizes
  use qsmpm_cut_cell_check, only: end_cut_cell_check, level_of, level_none, level_note, level_warning, warn_of_cut_cells
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_point_location, only: relocate
  use qsmpm_initialisation, only: step_type, initialise_step
  use qsmpm_integration, only: integration_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_points, only: carried_type
  use qsmpm_polygon, only: polygon_area
  use qsmpm_polyhedron, only: polyhedron_volume, prism_caps, prism_walls
  use qsmpm_polyhedron_check, only: polyhedron_problem
  use qsmpm_soil_points, only: soil_of, integration_of
  use qsmpm_space, only: shape_values_type
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_outlines, only: trim_outline
  use deck_samples, only: joined
  use scripted_solver, only: test_observer_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_outlines

  !> Deformation of the body: compressed, sheared and turned; in axisymmetry without a part that opens the axis.
  real(wp), parameter :: gradient(3, 3) = reshape([0.80_wp, 0.25_wp, 0.05_wp, -0.30_wp, 0.75_wp, 0.10_wp, &
    0.08_wp, -0.05_wp, 0.85_wp], [3, 3])
  !> Sums of some thousand terms of order one.
  real(wp), parameter :: rounding = 1.0e-12_wp

contains

  !> All tests of the suite.
  subroutine collect_outlines(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('outlines')
    call check_polygon(tests)
    call check_facets(tests)
    call check_divergence(tests, 'PLANE STRAIN', 'TRI3', 3, 'BASIS=STANDARD', rounding)
    call check_divergence(tests, 'PLANE STRAIN', 'TRI6', 3, 'BASIS=STANDARD', rounding)
    call check_divergence(tests, 'PLANE STRAIN', 'QUAD4', 4, 'BASIS=STANDARD', rounding)
    call check_divergence(tests, 'PLANE STRAIN', 'QUAD8', 4, 'BASIS=STANDARD', rounding)
    call check_divergence(tests, 'PLANE STRAIN', 'QUAD4', 4, 'BASIS=GIMP', rounding)
    call check_divergence(tests, 'PLANE STRAIN', 'QUAD4', 9, 'BASIS=SPLINE2G', rounding)
    call check_divergence(tests, 'PLANE STRAIN', 'QUAD4', 9, 'BASIS=SPLINE3', rounding)
    call check_divergence(tests, 'AXISYMMETRIC', 'TRI6', 3, 'BASIS=STANDARD', rounding)
    call check_divergence(tests, 'AXISYMMETRIC', 'QUAD4', 9, 'BASIS=SPLINE2', rounding)
    call check_divergence(tests, '3D', 'HEX8', 8, 'BASIS=STANDARD', rounding)
    call check_divergence(tests, '3D', 'WEDGE6', 8, 'BASIS=STANDARD', rounding)
    call check_divergence(tests, '3D', 'TET10', 4, 'BASIS=STANDARD', rounding)
    call check_divergence(tests, '3D', 'HEX8', 8, 'BASIS=GIMP', rounding)
    call check_points(tests)
    call check_end_corner(tests)
    call check_soil(tests)
    call check_part(tests)
    call check_uncut(tests)
    call check_trim(tests)
    call check_lost(tests)
  end subroutine collect_outlines

  !> A divided polygon: edges short enough, nothing moved, a vertex where it enters a box.
  subroutine check_polygon(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: polygon(2, 3) = reshape([0.0_wp, 0.0_wp, 2.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 3])
    real(wp), allocatable :: vertices(:, :)
    integer :: i, n

    call divide_polygon(polygon, 0.3_wp, reshape([0.7_wp, -1.0_wp, 3.0_wp, 0.1_wp], [2, 2, 1]), 1.0e-3_wp, vertices)
    n = size(vertices, 2)
    call tests%close('a divided polygon keeps its area', polygon_area(vertices), 1.0_wp, rounding)
    call tests%check('no edge is longer than asked for', maxval(part_sizes(vertices, reshape([(i, modulo(i, n) + 1, &
      i=1, n)], [2, n]))) <= 0.3_wp + rounding)
    call tests%check('it has a vertex where it enters a box', &
      any(norm2(vertices - spread([0.7_wp, 0.0_wp], 2, n), dim=1) < rounding))
  end subroutine check_polygon

  !> Divided facets: closed, of the same volume and area, short edges.
  subroutine check_facets(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: outline(2, 4) = reshape([0.0_wp, 0.0_wp, 1.1_wp, 0.0_wp, 1.3_wp, 0.9_wp, 0.0_wp, 1.0_wp], &
      [2, 4])
    real(wp), allocatable :: walls(:, :, :), caps(:, :, :), facets(:, :, :), vertices(:, :)
    integer, allocatable :: corner(:, :)
    real(wp) :: volume, centroid(3), edge
    integer :: f, k

    call prism_walls(outline, 0.0_wp, 0.7_wp, walls)
    call prism_caps(outline, 0.0_wp, 0.7_wp, caps)
    facets = reshape([walls, caps], [3, 3, size(walls, 3) + size(caps, 3)])
    call divide_facets(facets, 0.25_wp, vertices, corner)
    edge = 0.0_wp
    facets = reshape(vertices(:, reshape(corner, [size(corner)])), [3, 3, size(corner, 2)])
    do f = 1, size(facets, 3)
      do k = 1, 3
        edge = max(edge, norm2(facets(:, k, f) - facets(:, mod(k, 3) + 1, f)))
      end do
    end do
    call polyhedron_volume(facets, volume, centroid)
    call tests%check('divided facets close the solid', len(polyhedron_problem(facets)) == 0)
    call tests%close('they keep its volume', volume, 0.7_wp*polygon_area(outline), rounding)
    call tests%check('no edge is longer than asked for', edge <= 0.25_wp)
  end subroutine check_facets

  !> A block that the grid cuts, all of its outline under pressure, deformed; the step from there is prepared.
  subroutine deformed(kind, element, points, method, box, more, model, step, strength)
    !> Words of *MODEL, *GRID and *METHOD, points of an element, box of the surface (empty for all), further cards.
    character(len=*), intent(in) :: kind, element, method, box, more
    integer, intent(in) :: points
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    !> Cards of the material's strength.
    character(len=*), intent(in), optional :: strength
    character(len=:), allocatable :: text
    character(len=4) :: count

    write (count, '(i0)') points
    text = '*MODEL, TYPE='//kind//'|*GRID, ELEMENT='//element//'|X, 0, 3, 6|Y, -1, 2, 6|'
    if (kind == '3D') text = text//'Z, -1, 2, 6|'
    text = text//'*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|'
    if (present(strength)) text = text//strength
    text = text//'*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|'
    if (kind == '3D') then
      text = text//'0.63, 1.57, -0.12, 0.87, 0.07, 0.91|'
    else
      text = text//'0.63, 1.57, -0.12, 0.87|'
    end if
    text = text//'*POINTS, PER ELEMENT='//trim(count)//'|*SURFACE, NAME=all, TYPE=OUTLINE, BODY=block'//box// &
      '|*METHOD, '//method//'|*NSET, NSET=base, PLANE=Y|-1|'
    call build(text//'*PHASE, NAME=p|*FIX|base, Y|*PRESSURE, SURFACE=all|1|'//more//'*END PHASE|', model)
    call deform(model, model%state%points)
    call deform(model, model%state%tracers)
    model%state%points%volume = determinant(model%mesh%dimension)*model%state%points%volume
    call start_phase(model)
    call prepare(model, step)
  end subroutine deformed

  !> The model of a deck.
  subroutine build(text, model)
    character(len=*), intent(in) :: text
    type(model_type), intent(out) :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('block.inp', joined(text), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the deck of the test is not good'
  end subroutine build

  !> Prepare the next step.
  subroutine prepare(model, step)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    type(error_type), allocatable :: error

    model%state%progress%step = model%state%progress%step + 1
    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'the step of the test cannot be made'
  end subroutine prepare

  !> Of the deformation in the plane or in space.
  pure real(wp) function determinant(dimension)
    integer, intent(in) :: dimension

    associate (f => gradient)
      determinant = f(1, 1)*f(2, 2) - f(1, 2)*f(2, 1)
      if (dimension == 3) determinant = dot_product(f(:, 1), [f(2, 2)*f(3, 3) - f(3, 2)*f(2, 3), &
        f(3, 2)*f(1, 3) - f(1, 2)*f(3, 3), f(1, 2)*f(2, 3) - f(2, 2)*f(1, 3)])
    end associate
  end function determinant

  !> Move places by the deformation about the middle of the block, and find their cells.
  subroutine deform(model, carried)
    type(model_type), intent(in) :: model
    class(carried_type), intent(inout) :: carried
    real(wp), parameter :: middle(3) = [1.1_wp, 0.4_wp, 0.5_wp]
    integer :: i, d

    d = model%mesh%dimension
    do i = 1, carried%count
      carried%position(:, i) = middle(:d) + matmul(gradient(:d, :d), carried%position(:, i) - middle(:d))
    end do
    call find_cells(model, carried)
  end subroutine deform

  !> Cells of places that have moved.
  subroutine find_cells(model, carried)
    type(model_type), intent(in) :: model
    class(carried_type), intent(inout) :: carried
    type(error_type), allocatable :: error

    call relocate(model%mesh, 1.0_wp, carried, 'place', error)
    if (allocated(error)) error stop 'the block of the test leaves its mesh'
  end subroutine find_cells

  !> Sum of V grad N over the integration points less that of N a over the points under pressure, at the worst node.
  subroutine find_imbalance(model, step, worst)
    type(model_type), intent(in) :: model
    type(step_type), intent(in), target :: step
    real(wp), intent(out) :: worst
    type(integration_type), pointer :: integration
    type(shape_values_type) :: place
    real(wp) :: sums(model%mesh%dimension, model%space%node_count)
    integer :: i, a

    sums = 0.0_wp
    integration => integration_of(soil_of(step%terms), step%configuration_type)
    call add_gradients(integration, model%mesh%dimension, sums)
    associate (surface => model%state%surface)
      do i = 1, surface%count
        call basis_at(model%mesh, model%space, step%activation, model%state%points, surface, i, place)
        do a = 1, place%count
          sums(:, place%node(a)) = sums(:, place%node(a)) - place%shape(a)*surface%area_vector(:, i)
        end do
      end do
    end associate
    worst = maxval(abs(sums))
  end subroutine find_imbalance

  !> Add the integrals of the gradients, in axisymmetry with N/r for the first component.
  subroutine add_gradients(integration, dimension, sums)
    type(integration_type), intent(in) :: integration
    integer, intent(in) :: dimension
    real(wp), intent(inout) :: sums(:, :)
    integer :: g, q, n, b, j, d

    d = integration%directions
    do g = 1, integration%group_count
      n = integration%node_first(g + 1) - integration%node_first(g)
      associate (nodes => integration%nodes(integration%node_first(g):integration%node_first(g + 1) - 1))
        do q = integration%first(g), integration%first(g + 1) - 1
          b = d*(integration%value_first(g) + (q - integration%first(g))*n)
          do j = 1, d
            associate (row => merge(j, 1, j <= dimension))
              sums(row, nodes) = sums(row, nodes) + integration%weight(q)*integration%gradient(b + (j - 1)*n + 1:b + j*n)
            end associate
          end do
        end do
      end associate
    end do
  end subroutine add_gradients

  !> The divergence theorem holds in the deformed block, and the area that dead loads act on is that of the start.
  subroutine check_divergence(tests, kind, element, points, method, tolerance)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind, element, method
    integer, intent(in) :: points
    real(wp), intent(in) :: tolerance
    character(len=:), allocatable :: label
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    real(wp) :: worst, area

    allocate (model, step)
    label = kind//' '//element//' '//method//': '
    call deformed(kind, element, points, method//', INTEGRATION=CELL', '', '', model, step)
    call find_imbalance(model, step, worst)
    call tests%check(label//'a deformed block satisfies the divergence theorem at every node', worst <= tolerance)
    area = 2.0_wp*(0.94_wp + 0.99_wp)
    if (kind == 'AXISYMMETRIC') area = 1.1_wp*area
    if (kind == '3D') area = 2.0_wp*(0.94_wp*0.99_wp + 0.94_wp*0.84_wp + 0.99_wp*0.84_wp)
    call tests%close(label//'its loaded area is that of the start', sum(model%state%surface%area), area, &
      1.0e-9_wp)
  end subroutine check_divergence

  !> Points of a deformed block are off the divergence theorem by what they are told to be; before, by nothing.
  subroutine check_points(tests)
    type(tests_type), intent(inout) :: tests
    type(test_observer_type) :: observer
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step

    allocate (model, step)
    call deformed('PLANE STRAIN', 'QUAD4', 4, 'BASIS=GIMP', '', '', model, step)
    call tests%check('without stress nothing is out of balance', step%cut%share <= 0.0_wp)
    model%state%points%stress(:3, :) = -7.0_wp
    call prepare(model, step)
    call tests%check('points of a deformed block are off the divergence theorem', step%cut%share > 0.02_wp .and. &
      step%cut%share < 0.5_wp)
    call warn_of_cut_cells(model, step%configuration_type, step%cut, observer)
    call tests%check('an elastic body has a remedy: '//observer%text, index(observer%text, 'warning: the integration') == 1 &
      .and. index(observer%text, 'use INTEGRATION=CELL') > 0)
    call tests%check('most at a node beside the outline', norm2(step%cut%place - [1.1_wp, 0.4_wp]) < 1.2_wp .and. &
      norm2(step%cut%place - [1.1_wp, 0.4_wp]) > 0.2_wp)
    model%state%points%position = model%state%points%initial_position
    model%state%tracers%position = model%state%tracers%initial_position
    model%state%points%volume = model%state%points%initial_volume
    call find_cells(model, model%state%points)
    call find_cells(model, model%state%tracers)
    call prepare(model, step)
    call tests%check('and not in the block as it was', step%cut%share <= rounding)
  end subroutine check_points

  !> A corner that lies on an end of the grid is one corner of what is left of an outline.
  subroutine check_end_corner(tests)
    type(tests_type), intent(inout) :: tests
    type(body_shape_type) :: shape
    real(wp), parameter :: bounds(2, 2) = reshape([0.0_wp, 0.0_wp, 4.0_wp, 1.5_wp], [2, 2])

    shape%outline = reshape([0.0_wp, -1.0_wp, 2.0_wp, -1.0_wp, 2.0_wp, 0.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 1.0_wp], [2, 5])
    call trim_outline(bounds, shape)
    call tests%check('an outline trimmed at a corner has four', size(shape%outline, 2) == 4)
    call tests%close('and the area above', polygon_area(shape%outline), 1.5_wp, rounding)
  end subroutine check_end_corner

  !> A surface on one side of the block: resultant and moment of a pressure on it are those of the deformed side.
  subroutine check_part(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    real(wp) :: side(2), middle(2), moment(2)
    integer :: k

    allocate (model, step)
    call deformed('PLANE STRAIN', 'TRI6', 6, 'BASIS=STANDARD, INTEGRATION=CELL', ', BOX|0.6, 1.6, 0.87, 0.87', '', &
      model, step)
    side = matmul(gradient(:2, :2), [-0.94_wp, 0.0_wp])
    middle = [1.1_wp, 0.4_wp] + matmul(gradient(:2, :2), [0.0_wp, 0.47_wp])
    moment = 0.0_wp
    associate (points => model%state%surface)
      do k = 1, points%count
        moment = moment + norm2(points%area_vector(:, k))*points%position(:, k)
      end do
      call tests%check('a pressure on one side has its resultant', &
        norm2(sum(points%area_vector, dim=2) - [side(2), -side(1)]) <= rounding)
      call tests%check('and its moment', norm2(moment - norm2(side)*middle) <= rounding)
    end associate
  end subroutine check_part

  !> Where cells are integrated the outline of a body that can yield is carried, but its points are what is integrated,
  !> off by what they are told to be; of two bodies the one that cannot yield alone is integrated inside of its outline.
  subroutine check_soil(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: soil = '*MOHR COULOMB|1e6, 20, 0|'
    type(test_observer_type) :: observer
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step

    allocate (model, step)
    call deformed('PLANE STRAIN', 'TRI6', 6, 'BASIS=STANDARD, INTEGRATION=CELL', '', '', model, step, soil)
    call tests%check('the outline of a body that can yield is carried', size(model%outlines) == 1)
    call tests%check('and nothing is integrated inside of it', .not. allocated(step%bodies))
    model%state%points%stress(:3, :) = -7.0_wp
    call prepare(model, step)
    call tests%check('it tells how far the integration is off', step%cut%share > 0.02_wp .and. step%cut%share < 1.0_wp)
    step%cut%share = 0.019_wp
    call warn_of_cut_cells(model, step%configuration_type, step%cut, observer)
    call warn_of_cut_cells(model, step%configuration_type, step%cut, observer)
    call tests%check('little is told once, and what makes it less: '//observer%text, index(observer%text, &
      'the integration error of cells cut by a body is 1.9 % along') == 1 .and. index(observer%text, 'cells of half the size', &
      back=.true.) == index(observer%text, 'cells of half the size') .and. index(observer%text, 'warning') == 0)
    step%cut%share = 0.03_wp
    call warn_of_cut_cells(model, step%configuration_type, step%cut, observer)
    call end_cut_cell_check('load', step%cut, observer)
    call tests%check('much is a warning: '//observer%text, index(observer%text, '|warning: the integration') > 0 .and. &
      index(observer%text, "|warning: phase 'load': the integration error of cells cut by a body is 3") > 0)
    call tests%check('little of an elastic body is one too', level_of(0.005_wp, .true.) == level_warning .and. &
      level_of(0.005_wp, .false.) == level_note .and. level_of(0.0039_wp, .true.) == level_none)
    call deformed('PLANE STRAIN', 'TRI6', 6, 'BASIS=STANDARD, INTEGRATION=POINTS', '', '', model, step)
    call tests%check('with points that of any body only tells', .not. allocated(step%bodies) .and. &
      size(model%outlines) == 1)
    call build('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 3, 6|Y, 0, 2, 4|*METHOD, INTEGRATION=CELL|'// &
      '*MATERIAL, NAME=rock|*ELASTIC|1000, 0.3|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|'//soil// &
      '*BODY, NAME=a, MATERIAL=rock, SHAPE=BOX|0, 1.2, 0, 1|*BODY, NAME=b, MATERIAL=soil, SHAPE=BOX|2.2, 3, 0, 1|'// &
      '*NSET, NSET=base, PLANE=Y|0|*PHASE, NAME=p|*FIX|base, Y|*END PHASE|', model)
    call tests%check('the rock beside the soil alone is integrated inside of its outline', &
      all(model%outlines%integrates .eqv. [.true., .false.]))
    call check_neighbours(tests)
  end subroutine check_soil

  !> Beside soil that the grid cuts soil that ends on grid lines has its outline too, when they touch; what
  !> INTEGRATION=CELL is said to follow is the outline of an elastic body where it is worst.
  subroutine check_neighbours(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: head = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 3, 6|Y, 0, 2, 4|'// &
      '*MATERIAL, NAME=rock|*ELASTIC|1000, 0.3|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*MOHR COULOMB|1, 20, 0|', &
      tail = '*NSET, NSET=base, PLANE=Y|0|*PHASE, NAME=p|*FIX|base, Y|*END PHASE|'
    type(test_observer_type) :: observer
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step

    allocate (model, step)
    call build(head//'*METHOD, INTEGRATION=CELL|*BODY, NAME=a, MATERIAL=soil, SHAPE=BOX|0, 1.5, 0, 1|'// &
      '*BODY, NAME=b, MATERIAL=soil, SHAPE=BOX|1.5, 2.7, 0, 1|*BODY, NAME=c, MATERIAL=rock, SHAPE=BOX|0, 1, 1, 2|'// &
      '*BODY, NAME=d, MATERIAL=soil, SHAPE=BOX|2, 3, 1.5, 2|'//tail, model)
    call tests%check('of four bodies the one that is cut and the soil that touches it are carried', &
      size(model%outlines) == 2)
    if (size(model%outlines) == 2) call tests%check('these two', all(model%outlines%body == [2, 1]))
    call build(head//'*METHOD, BASIS=GIMP, INTEGRATION=POINTS|*BODY, NAME=a, MATERIAL=soil, SHAPE=BOX|0, 1.1, 0, 1|'// &
      '*BODY, NAME=b, MATERIAL=rock, SHAPE=BOX|1.9, 3, 0, 1|'//tail, model)
    call start_phase(model)
    call prepare(model, step)
    step%cut%share = 0.01_wp
    step%cut%place = [1.0_wp, 0.5_wp]
    call warn_of_cut_cells(model, step%configuration_type, step%cut, observer)
    call tests%check('beside the soil cells follow no outline: '//observer%text, &
      index(observer%text, 'half the size') > 0)
    step%cut%place = [2.0_wp, 0.5_wp]
    call warn_of_cut_cells(model, step%configuration_type, step%cut, observer)
    call tests%check('beside the rock they do: '//observer%text, index(observer%text, 'use INTEGRATION=CELL') > 0)
  end subroutine check_neighbours

  !> Nothing is carried for a body that ends on grid lines; the points of a support stay where they are.
  subroutine check_uncut(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: head = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 3, 6|Y, 0, 2, 4|'// &
      '*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*BODY, NAME=b, MATERIAL=soil, SHAPE=BOX|', &
      tail = '*NSET, NSET=base, PLANE=Y|0|*SURFACE, NAME=s, TYPE=OUTLINE, BODY=b|*PHASE, NAME=p|*FIX|base, Y|'
    class(model_type), allocatable :: model

    allocate (model)
    call build(head//'0, 2, 0, 1|*METHOD, INTEGRATION=CELL|'//tail//'*END PHASE|', model)
    call tests%check('the outline of a body that ends on grid lines is not carried', size(model%outlines) == 0)
    call build(head//'0, 2, 0, 1.1|*METHOD, INTEGRATION=CELL|'//tail//'*END PHASE|', model)
    call tests%check('the one of a body that cuts cells is', size(model%outlines) == 1)
    call tests%check('with its surface', size(model%outlines(1)%part) == size(model%outlines(1)%size))
    call build(head//'0, 2, 0, 1.1|*METHOD, INTEGRATION=CELL|'//tail//'*SUPPORT, SURFACE=s, TYPE=ALL|*END PHASE|', model)
    call tests%check('but not with one that is held', size(model%outlines(1)%part) == 0)
  end subroutine check_uncut

  !> A body that reaches beyond the grid is carried as the part on it; what is an end of the grid is no surface. One in
  !> parts is not carried.
  subroutine check_trim(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: head = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 3, 6|Y, 0, 2, 4|'// &
      '*METHOD, INTEGRATION=CELL|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*BODY, NAME=b, MATERIAL=soil, SHAPE=', &
      tail = '|*NSET, NSET=base, PLANE=Y|0|*SURFACE, NAME=s, TYPE=OUTLINE, BODY=b|*PHASE, NAME=p|*FIX|base, Y|*END PHASE|'
    class(model_type), allocatable :: model

    allocate (model)
    ! Divided to half a cell the edge as drawn would have 4e12 parts.
    call build(head//'BOX|0, 1e12, 0, 1.1'//tail, model)
    call tests%check('a body that ends far outside of the grid is carried', size(model%outlines) == 1)
    if (size(model%outlines) /= 1) return
    call tests%close('as the part on it', sum(model%outlines(1)%size), 8.2_wp, rounding)
    call tests%close('its surface has no end there', sum(model%outlines(1)%size(model%outlines(1)%part)), 7.1_wp, rounding)
    call build(head//'BOX|-1, 2, -1, 1.1'//tail, model)
    call tests%close('nor at the lower ends', sum(model%outlines(1)%size(model%outlines(1)%part)), 3.1_wp, rounding)
    call build(head//'POLYGON|0.2, 3|0.2, 0.2|2.8, 0.2|2.8, 3|2.2, 3|2.2, 2.2|1.8, 2.2|1.8, 3'//tail, model)
    call tests%check('a fork is whole on the grid', size(model%outlines) == 1)
    call build(head//'POLYGON|0.2, 3|0.2, 0.2|0.8, 0.2|0.8, 2.2|2.2, 2.2|2.2, 0.2|2.8, 0.2|2.8, 3'//tail, model)
    call tests%check('a bridge above it is not', size(model%outlines) == 0)
  end subroutine check_trim

  !> An outline that does not bound its points any more is left alone.
  subroutine check_lost(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    integer :: c

    allocate (model, step)
    call deformed('PLANE STRAIN', 'TRI6', 3, 'BASIS=STANDARD, INTEGRATION=CELL', '', '', model, step)
    model%state%points%volume = model%state%points%volume/1.09_wp
    call prepare(model, step)
    call tests%check('a deformed block has a part in a cell without a point', any(step%bodies%fill > 0.0_wp .and. &
      [(.not. any(model%state%points%cell == c), c=1, model%mesh%cell_count)]))
    call tests%check('an outline serves while its volume is 9 % off that of the points', step%bodies%carried(1))
    model%state%points%volume = model%state%points%volume*1.09_wp/1.11_wp
    call prepare(model, step)
    call tests%check('and no longer when it is 11 % off', .not. step%bodies%carried(1))
    call tests%check('the cells have their points then', size(step%bodies%volume) == 0)
  end subroutine check_lost
end module test_outlines
