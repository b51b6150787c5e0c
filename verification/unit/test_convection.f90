!> Tests of the convective phase: a step of one gradient everywhere moves, stretches and stresses whatever rides on the
!> mesh as that gradient says, for every kind of mesh and integration; what leaves the mesh or tangles it is an error.
module test_convection
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_convection, only: convect
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_element_shape, only: shape_functions
  use qsmpm_element, only: node_count
  use qsmpm_error, only: error_type, error_left_mesh, error_tangled
  use qsmpm_held_sides, only: side_check_type, warn_of_crossing, warn_of_reached_sides
  use qsmpm_initialisation, only: step_type, initialise_step, evaluate_step
  use qsmpm_law, only: tangent_none
  use qsmpm_linear_system, only: end_system
  use qsmpm_mesh, only: mesh_type
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_points, only: carried_type
  use qsmpm_space, only: node_position
  use deck_samples, only: joined
  use scripted_solver, only: test_observer_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_convection

  !> Stretches of the step along the axes; Young's modulus and Poisson's ratio of the block.
  real(wp), parameter :: stretch(3) = [1.02_wp, 0.97_wp, 1.01_wp], young = 1000.0_wp, poisson = 0.3_wp
  !> Rounding of positions and of relative volumes and stresses.
  real(wp), parameter :: rounding = 1.0e-11_wp

contains

  !> All tests of the suite.
  subroutine collect_convection(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('convection')
    call check_stretch(tests, 'QUAD4', 'BASIS=STANDARD')
    call check_stretch(tests, 'QUAD4', 'BASIS=STANDARD, INTEGRATION=CELL')
    call check_stretch(tests, 'TRI6', 'BASIS=STANDARD, INTEGRATION=CELL')
    call check_stretch(tests, 'QUAD4', 'BASIS=GIMP')
    call check_stretch(tests, 'QUAD4', 'BASIS=SPLINE2')
    call check_stretch(tests, 'QUAD4', 'BASIS=SPLINE2G, INTEGRATION=CELL')
    call check_stretch(tests, 'QUAD8', 'BASIS=FEM')
    call check_stretch(tests, 'HEX8', 'BASIS=STANDARD')
    call check_stretch(tests, 'HEX8', 'BASIS=FEM')
    call check_second_step(tests)
    call check_pressure_groups(tests)
    call check_moving_rows(tests, 'STANDARD')
    call check_moving_rows(tests, 'SPLINE2')
    call check_sides(tests)
    call check_warning(tests)
    call check_reached(tests)
    call check_losses(tests)
    call check_tangled(tests)
  end subroutine collect_convection

  !> An elastic block with a loaded side and a tracer in a grid; its first phase has begun and its step is prepared.
  subroutine build(element, method, more, model, step)
    !> Element, words of *METHOD, and further cards between bars.
    character(len=*), intent(in) :: element, method, more
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: text
    logical :: solid

    allocate (analysis)
    solid = element == 'HEX8'
    text = '*MODEL, TYPE='//trim(merge('3D          ', 'PLANE STRAIN', solid))//'|*GRID, ELEMENT='//element// &
      '|X, 0, 2, 4|Y, 0, 2, 4|'
    if (solid) text = text//'Z, 0, 2, 4|'
    text = text//'*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=plate, BOX|0, 1, 1, 1'//trim(merge(', 0, 1', '      ', solid))
    text = text//'|*SURFACE, NAME=side, TYPE=OUTLINE, BODY=block, BOX|0.99, 1.01, 0, 1'// &
      trim(merge(', 0, 1', '      ', solid))//more
    text = text//'|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*UNIT WEIGHT|1|*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|'// &
      '0, 1, 0, 1'//trim(merge(', 0, 1', '      ', solid))//'|*METHOD, '//method
    text = text//'|*HISTORY, NAME=u, QUANTITY=DISPLACEMENT, COMPONENT=Y|0.7, 0.6'//trim(merge(', 0.3', '     ', solid))
    text = text//'|*PHASE, NAME=one|*FIX|base, ALL|*END PHASE|'
    call parse_deck('block.inp', joined(text), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'a deck of the convection suite is broken'
    call start_phase(model)
    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'a step of the convection suite cannot be made'
  end subroutine build

  !> Displacement of every node of the space under the stretches.
  function stretching(model) result(u)
    type(model_type), intent(in) :: model
    !> (dimension, nodes)
    real(wp), allocatable :: u(:, :)
    integer :: a, d

    d = model%mesh%dimension
    allocate (u(d, model%space%node_count))
    do a = 1, size(u, 2)
      u(:, a) = (stretch(:d) - 1.0_wp)*node_position(model%space, model%mesh, a)
    end do
  end function stretching

  !> Positions, volumes, stresses, gradients and cells after a stretch along the axes. The stress is Hencky's: the
  !> Kirchhoff stress is linear in the logarithms of the stretches.
  subroutine check_stretch(tests, element, method)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: element, method
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    class(state_type), allocatable :: before
    type(error_type), allocatable :: error
    character(len=:), allocatable :: name
    integer :: d, p, off

    allocate (model, step, before)
    name = element//' '//method//': '
    call build(element, method, '', model, step)
    d = model%mesh%dimension
    before = model%state
    call evaluate_step(model, step, stretching(model), tangent_none)
    call convect(model, step, stretching(model), error)
    call tests%check(name//'the step is taken', .not. allocated(error))
    call tests%check(name//'there are points, surface points and tracers', model%state%points%count > 3 .and. &
      model%state%surface%count > 1 .and. model%state%tracers%count > 0)
    call check_moved('material points', before%points, model%state%points)
    call check_moved('surface points', before%surface, model%state%surface)
    call check_moved('tracers', before%tracers, model%state%tracers)
    call tests%close(name//'volumes grow by the determinant', maxval(abs(model%state%points%volume &
      /before%points%volume - product(stretch(:d)))), 0.0_wp, rounding)
    call check_stress()
    call tests%check(name//'no elastic point yields', all(model%state%points%plastic == 0))
    call check_areas()
    call check_nodes()
    ! The packed gradient has the stretches at 1, 4, 5 in the plane and at 1, 5, 9 in space.
    off = 0
    do p = 1, size(model%state%points%deformation_gradient, 2)
      if (abs(model%state%points%deformation_gradient(1, p) - stretch(1)) > rounding .or. &
        abs(model%state%points%deformation_gradient(merge(4, 5, d == 2), p) - stretch(2)) > rounding) off = off + 1
    end do
    call tests%check(name//'the total gradients are the stretches', off == 0)
    call end_system(step%system)

  contains

    !> A carried set has moved with the field, and its local coordinates are those of its position.
    subroutine check_moved(what, old, new)
      character(len=*), intent(in) :: what
      class(carried_type), intent(in) :: old, new

      call tests%close(name//what//' move with the field', maxval(abs(new%position - spread(stretch(:d), 2, new%count) &
        *old%position)), 0.0_wp, rounding)
      call tests%close(name//what//' are found where they are', largest_distance(model%mesh, new), 0.0_wp, 1.0e-9_wp)
    end subroutine check_moved

    !> Stresses of the points.
    subroutine check_stress()
      real(wp) :: strain(3), expected(3), shear, lame
      real(wp) :: largest
      integer :: k

      strain = 0.0_wp
      strain(:d) = log(stretch(:d))
      shear = young/(2.0_wp*(1.0_wp + poisson))
      lame = young*poisson/((1.0_wp + poisson)*(1.0_wp - 2.0_wp*poisson))
      expected = (lame*sum(strain) + 2.0_wp*shear*strain)/product(stretch(:d))
      largest = maxval(abs(model%state%points%stress(4:, :)))
      do k = 1, 3
        largest = max(largest, maxval(abs(model%state%points%stress(k, :) - expected(k))))
      end do
      call tests%close(name//'stresses are those of the stretches', largest, 0.0_wp, 1.0e-8_wp*maxval(abs(expected)))
    end subroutine check_stress

    !> Areas of the loaded side, whose normal is x: the other stretches enlarge them.
    subroutine check_areas()
      call tests%close(name//'areas grow by the cofactor', maxval(abs(model%state%surface%area_vector(1, :) &
        - before%surface%area_vector(1, :)*product(stretch(2:d)))), 0.0_wp, rounding)
    end subroutine check_areas

    !> A carried mesh goes with the field, a fixed one stays.
    subroutine check_nodes()
      real(wp) :: wanted(d, size(before%coordinates, 2))

      wanted = before%coordinates
      if (index(method, 'FEM') > 0) wanted = spread(stretch(:d), 2, size(wanted, 2))*wanted
      call tests%close(name//'the nodes are where they belong', maxval(abs(model%state%coordinates - wanted)), 0.0_wp, &
        rounding)
      call tests%close(name//'and those of the mesh with them', maxval(abs(model%mesh%coordinates - wanted)), 0.0_wp, &
        rounding)
    end subroutine check_nodes
  end subroutine check_stretch

  !> Largest distance between positions and what their cells and local coordinates say.
  function largest_distance(mesh, carried) result(distance)
    type(mesh_type), intent(in) :: mesh
    class(carried_type), intent(in) :: carried
    real(wp) :: distance
    integer :: p

    distance = 0.0_wp
    do p = 1, carried%count
      distance = max(distance, norm2(mapped(mesh, carried%cell(p), carried%local(:, p)) - carried%position(:, p)))
      if (any(abs(carried%local(:, p)) > 1.0_wp + 1.0e-9_wp)) distance = huge(distance)
    end do
  end function largest_distance

  !> Position of local coordinates in a cell.
  function mapped(mesh, cell, local) result(x)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: cell
    real(wp), intent(in) :: local(:)
    real(wp) :: x(size(local)), shape(node_count(mesh%cell_kind(cell)))

    call shape_functions(mesh%cell_kind(cell), local, shape)
    x = matmul(mesh%coordinates(:, mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell + 1) - 1)), shape)
  end function mapped

  !> A second step goes on from the first: volumes and total gradients are products.
  subroutine check_second_step(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: volume(:)
    integer :: i

    allocate (model, step)
    call build('QUAD4', 'BASIS=SPLINE2G', '', model, step)
    allocate (volume, source=model%state%points%volume)
    do i = 1, 2
      if (i == 2) call initialise_step(model, step, error)
      call evaluate_step(model, step, stretching(model), tangent_none)
      call convect(model, step, stretching(model), error)
    end do
    call tests%close('two steps: volumes have grown twice', maxval(abs(model%state%points%volume/volume &
      - product(stretch(:2))**2)), 0.0_wp, rounding)
    call tests%close('two steps: gradients are multiplied', maxval(abs(model%state%points%deformation_gradient(1, :) &
      - stretch(1)**2)), 0.0_wp, rounding)
    call end_system(step%system)
  end subroutine check_second_step

  !> Points that share the pressure of their cell or of a patch of cells follow a uniform field exactly, too.
  subroutine check_pressure_groups(tests)
    type(tests_type), intent(inout) :: tests

    call check_group('QUAD4', 'BASIS=STANDARD', 'PRESSURE')
    call check_group('QUAD4', 'BASIS=STANDARD, INTEGRATION=CELL', 'UNIFORM PRESSURE')

  contains

    !> One kind of them.
    subroutine check_group(element, method, kind)
      character(len=*), intent(in) :: element, method, kind
      class(model_type), allocatable :: model
      class(step_type), allocatable :: step
      type(error_type), allocatable :: error
      real(wp), allocatable :: volume(:)

      allocate (model, step)
      call build(element, method, '', model, step)
      ! The treatment is that of the law slot: all points of a group share the volume change.
      model%laws%pressure_factor = 0.1_wp
      call initialise_step(model, step, error)
      allocate (volume, source=model%state%points%volume)
      call evaluate_step(model, step, stretching(model), tangent_none)
      call convect(model, step, stretching(model), error)
      call tests%check(method//' with shared pressures: the step is taken', .not. allocated(error))
      call tests%close(method//' with shared pressures ('//kind//'): volumes grow by the determinant', &
        maxval(abs(model%state%points%volume/volume - product(stretch(:2)))), 0.0_wp, rounding)
      call end_system(step%system)
    end subroutine check_group
  end subroutine check_pressure_groups

  !> Rows between base and plate are scaled, those beyond shifted; points keep to their material.
  subroutine check_moving_rows(tests, basis)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: basis
    real(wp), parameter :: move = -0.1_wp
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :), y(:), wanted(:), x(:, :)
    integer :: a

    allocate (model, step)
    call build('QUAD4', 'BASIS='//basis, '|*MOVING MESH, NSET=plate, AXIS=Y, BASE=0', model, step)
    allocate (u(2, model%space%node_count), source=0.0_wp)
    do a = 1, size(model%space%sets)
      if (model%mesh%node_sets(a)%name == 'plate') u(2, model%space%sets(a)%items) = move
    end do
    allocate (y, source=model%state%coordinates(2, :))
    allocate (x, source=model%state%coordinates)
    call evaluate_step(model, step, 0.0_wp*u, tangent_none)
    call convect(model, step, u, error)
    call tests%check(basis//' moving mesh: the step is taken', .not. allocated(error))
    call tests%close(basis//' moving mesh: the plate goes by the mean of its nodes', model%state%plate, 1.0_wp + move, &
      rounding)
    allocate (wanted, source=merge(y*(1.0_wp + move), y + move, y < 1.0_wp))
    call tests%close(basis//' moving mesh: rows follow', maxval(abs(model%state%coordinates(2, :) - wanted)), 0.0_wp, rounding)
    call tests%close(basis//' moving mesh: columns stay', maxval(abs(model%state%coordinates(1, :) - x(1, :))), 0.0_wp, &
      rounding)
    call tests%close(basis//' moving mesh: points are found in the new rows', &
      largest_distance(model%mesh, model%state%points), 0.0_wp, 1.0e-9_wp)
    ! The control points of splines follow the rows.
    do a = 1, model%space%node_count
      x(:, 1) = node_position(model%space, model%mesh, a)
      if (x(2, 1) > 2.0_wp + move + rounding) exit
    end do
    call tests%check(basis//' moving mesh: the functions end with the rows', a > model%space%node_count)
    call end_system(step%system)
  end subroutine check_moving_rows

  !> A way of more than a tenth of a cell across a held side is warned of, and again when it is twice as far.
  subroutine check_warning(tests)
    type(tests_type), intent(inout) :: tests
    type(side_check_type) :: check
    type(test_observer_type) :: observer

    call warn_of_crossing(0.5_wp, 0.049_wp, check, observer)
    call tests%check('a short way is not warned of', .not. allocated(observer%text))
    call warn_of_crossing(0.5_wp, 0.06_wp, check, observer)
    call warn_of_crossing(0.5_wp, 0.11_wp, check, observer)
    call tests%check('a longer one is', allocated(observer%text))
    if (.not. allocated(observer%text)) return
    call tests%check('once', index(observer%text, 'warning: a step carries material points by 0.12 cells across') == 1 &
      .and. index(observer%text, '|') == len(observer%text))
    call warn_of_crossing(0.5_wp, 0.13_wp, check, observer)
    call tests%check('and one of twice as many', index(observer%text, '|warning: a step carries material points by 0.26 ') > 0)
  end subroutine check_warning

  !> Soil that has yielded and gone far along a held side of the mesh is told once; along a free one it is not.
  subroutine check_reached(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(side_check_type) :: check
    type(test_observer_type) :: observer
    integer :: p

    allocate (model, step)
    call build('QUAD4', 'BASIS=GIMP', '', model, step)
    associate (points => model%state%points)
      ! Of cells of 0.5 it is the one beside the base, and, at the left, the free side.
      p = minloc(points%position(1, :) + points%position(2, :), dim=1)
      points%plastic_strain = 0.09_wp
      points%initial_position(1, p) = points%position(1, p) - 0.62_wp
      points%initial_position(2, p) = points%position(2, p) - 0.7_wp
      call warn_of_reached_sides(model, check, observer)
      points%plastic_strain = 0.11_wp
      points%initial_position(1, p) = points%position(1, p) - 0.48_wp
      call warn_of_reached_sides(model, check, observer)
      call tests%check('soil that has not yielded, or gone by less than a cell, is none that slides', &
        .not. allocated(observer%text))
      points%initial_position(1, p) = points%position(1, p) - 0.62_wp
      call warn_of_reached_sides(model, check, observer)
      call warn_of_reached_sides(model, check, observer)
    end associate
    if (.not. allocated(observer%text)) observer%text = ''
    call tests%check('a slide on a held side is told, once: '//observer%text, index(observer%text, &
      "warning: phase 'one': the slide has reached the side y = 0 of the mesh: soil within a cell of it has yielded "// &
      'and moved along it by 0.62, most at (') == 1 .and. index(observer%text, '|') == len(observer%text) .and. &
      index(observer%text, 'unless the ground is firm there') > 0)
    call check_smooth(tests, model)
    call end_system(step%system)
  end subroutine check_reached

  !> Along a smooth side a column that is compressed is no slide; soil that flows there while nodes are pushed is told in
  !> any case of more than a tenth of the longest way, unless the nodes lie on the side.
  subroutine check_smooth(tests, model)
    type(tests_type), intent(inout) :: tests
    !> Held at its base, its soil has sheared.
    type(model_type), intent(inout) :: model
    character(len=*), parameter :: start = "phase 'one': soil yields along the side x = 0 of the mesh: "
    integer :: a, p

    associate (points => model%state%points, constrained => model%loading%constrained)
      constrained(2, :) = .false.
      do a = 1, model%space%node_count
        constrained(1, a) = constrained(1, a) .or. only_left(a)
      end do
      points%initial_position = points%position
      p = minloc(points%position(1, :) - 1.0e-3_wp*points%position(2, :), dim=1)
      points%initial_position(2, p) = points%position(2, p) + 0.62_wp
      call tests%check('a column between rollers does not slide', len(told()) == 0)
      points%initial_position(1, p) = points%position(1, p) + 0.05_wp
      call tests%check('nor does one that goes across by a tenth of its way', len(told()) == 0)
      points%initial_position(1, p) = points%position(1, p) + 0.07_wp
      call tests%check('soil that turns along the side does', index(told(), 'the slide has reached the side x = 0') > 0)
      points%plastic = 1
      points%plastic_strain = 0.0_wp
      model%state%progress%limit%knee = 1.0_wp
      points%initial_position(:, maxloc(points%position(1, :), dim=1)) = 0.0_wp
      call tests%check('a limit load with soil that flows there is told: '//told(), index(told(), start) == 1)
      points%initial_position(2, p) = points%position(2, p) + 0.08_wp
      call tests%check('not one that hardly moves', len(told()) == 0)
      points%initial_position(2, p) = points%position(2, p) + 0.62_wp
      points%plastic = 0
      call tests%check('nor one that is elastic', len(told()) == 0)
      points%plastic = 1
      do a = 1, model%space%node_count
        if (only_left(a)) model%loading%prescribed(2, a) = 1.0_wp
      end do
      call tests%check('nor one whose nodes there are pushed', len(told()) == 0)
    end associate

  contains

    !> Whether a node lies on the left side.
    logical function only_left(a)
      integer, intent(in) :: a
      real(wp) :: at(2)

      at = node_position(model%space, model%mesh, a)
      only_left = abs(at(1) - model%mesh%bounds(1, 1)) <= 1.0e-9_wp
    end function only_left

    !> What is told.
    function told() result(text)
      character(len=:), allocatable :: text
      type(side_check_type) :: check
      type(test_observer_type) :: observer

      call warn_of_reached_sides(model, check, observer)
      text = ''
      if (allocated(observer%text)) text = observer%text
    end function told
  end subroutine check_smooth

  !> Whatever leaves the mesh is an error that names it.
  subroutine check_losses(tests)
    type(tests_type), intent(inout) :: tests

    call check_one('material point', 1)
    call check_one('surface point', 2)
    call check_one('tracer', 3)

  contains

    !> One kind of what rides, outside.
    subroutine check_one(what, kind)
      character(len=*), intent(in) :: what
      integer, intent(in) :: kind
      class(model_type), allocatable :: model
      class(step_type), allocatable :: step
      type(error_type), allocatable :: error
      real(wp), allocatable :: still(:, :)

      allocate (model, step)
      call build('QUAD4', 'BASIS=STANDARD', '', model, step)
      allocate (still(2, model%space%node_count), source=0.0_wp)
      select case (kind)
      case (1)
        model%state%points%position(1, 3) = -5.0_wp
      case (2)
        model%state%surface%position(1, 1) = -5.0_wp
      case (3)
        model%state%tracers%position(1, 1) = -5.0_wp
      end select
      call evaluate_step(model, step, still, tangent_none)
      call convect(model, step, still, error)
      call tests%check('a '//what//' outside the mesh is an error', allocated(error))
      if (allocated(error)) call tests%check('that names the '//what, error%code == error_left_mesh .and. &
        index(error%message, what//' ') == 1)
      call end_system(step%system)
    end subroutine check_one
  end subroutine check_losses

  !> What has crossed a side that is held along its normal is as far inside; where nothing holds a side, or it moves, it
  !> stays outside, within a share of a cell.
  subroutine check_sides(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: way = 0.03_wp
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :)
    integer :: a, moves

    allocate (model, step)
    do moves = 0, 1
      call build('QUAD4', 'BASIS=GIMP', '', model, step)
      allocate (u(2, model%space%node_count), source=0.0_wp)
      if (moves == 1) then
        ! The base is pushed up: it is held, but not still, and cells above it follow.
        do a = 1, size(u, 2)
          if (model%mesh%coordinates(2, a) < rounding) u(2, a) = 0.01_wp
        end do
      end if
      call evaluate_step(model, step, 0.0_wp*u, tangent_none)
      model%state%points%position(:, 3) = [0.3_wp, -way] - [0.0_wp, 0.01_wp*moves]
      model%state%points%position(:, 4) = [-way, 0.3_wp]
      model%state%tracers%position(:, 1) = [0.6_wp, -0.5_wp*way] - [0.0_wp, 0.01_wp*moves]
      model%state%surface%position(:, 1) = [0.9_wp, -0.25_wp*way] - [0.0_wp, 0.01_wp*moves]
      call convect(model, step, u, error)
      call tests%check('sides: the step is taken', .not. allocated(error))
      call tests%close('a side without fixity lets points stay outside', model%state%points%position(1, 4), -way, &
        rounding)
      if (moves == 1) then
        call tests%check('a side that moves lets points stay outside', model%state%points%position(2, 3) < 0.0_wp)
        call tests%close('and none is said to have crossed', step%crossing, 0.0_wp, 0.0_wp)
      else
        call tests%close('a held side sends points back', model%state%points%position(2, 3), way, rounding)
        call tests%close('and tracers', model%state%tracers%position(2, 1), 0.5_wp*way, rounding)
        call tests%close('and surface points', model%state%surface%position(2, 1), 0.25_wp*way, rounding)
        call tests%close('along the side they stay', model%state%points%position(1, 3), 0.3_wp, rounding)
        call tests%close('the way across is known', step%crossing, way, rounding)
        call tests%close('what is put back is found where it is', largest_distance(model%mesh, model%state%tracers), &
          0.0_wp, 1.0e-9_wp)
      end if
      call end_system(step%system)
      deallocate (u)
    end do
  end subroutine check_sides

  !> A carried mesh that turns inside out is an error that names the element; the state keeps its nodes.
  subroutine check_tangled(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :), nodes(:, :)
    integer :: a

    allocate (model, step)
    call build('QUAD4', 'BASIS=FEM', '', model, step)
    allocate (u(2, model%space%node_count), source=0.0_wp)
    allocate (nodes, source=model%state%coordinates)
    do a = 1, size(u, 2)
      if (abs(nodes(1, a) - 0.5_wp) < rounding .and. abs(nodes(2, a) - 0.5_wp) < rounding) u(:, a) = 0.45_wp
    end do
    call evaluate_step(model, step, 0.0_wp*u, tangent_none)
    call convect(model, step, u, error)
    call tests%check('a tangled mesh is an error', allocated(error))
    if (allocated(error)) call tests%check('that names the element', error%code == error_tangled .and. &
      index(error%message, 'the mesh is tangled: element ') == 1)
    call tests%close('the state keeps its nodes', maxval(abs(model%state%coordinates - nodes)), 0.0_wp, 0.0_wp)
    call end_system(step%system)
  end subroutine check_tangled
end module test_convection
