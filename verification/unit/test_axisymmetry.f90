!> Axisymmetry at the axis: a uniform pressure p in a body does the work of its traction on the surface,
!>   sum over points of V (grad N + N/r e_r) p  =  integral of r N n p over the surface,
!> and the weight of the points that of the volume, the sum of V N = the integral of r N, for every basis in
!> bodies that end on grid lines and that cut them. Right hand sides by Gauss points exact for the products.
module test_axisymmetry
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_law, only: tangent_none
  use qsmpm_line_rule, only: line_gauss
  use qsmpm_mesh_search, only: locate
  use qsmpm_space, only: shape_values_type, functions_at, node_position
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_initialisation, only: step_type, initialise_step, evaluate_step
  use qsmpm_deformation, only: point_displacement, step_gradient
  use qsmpm_linear_system, only: end_system
  use deck_samples, only: joined
  use term_samples, only: load_at
  use testing, only: tests_type
  implicit none
  private

  public :: collect_axisymmetry

  !> Sums of some hundred products near one.
  real(wp), parameter :: rounding = 1.0e-12_wp
  !> Grid lines: uneven, from the axis.
  real(wp), parameter :: lines_r(6) = [0.0_wp, 0.125_wp, 0.3_wp, 0.5_wp, 0.75_wp, 1.0_wp], &
    lines_z(6) = [0.0_wp, 0.25_wp, 0.4_wp, 0.75_wp, 1.0_wp, 1.25_wp]
  character(len=*), parameter :: lines = '|X, LINES, 0, 0.125, 0.3, 0.5, 0.75, 1|Y, LINES, 0, 0.25, 0.4, 0.75, 1, 1.25'

contains

  !> All checks.
  subroutine collect_axisymmetry(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: grid(2) = [1.0_wp, 1.25_wp], part(2) = [0.5_wp, 1.0_wp], cut(2) = [0.47_wp, 0.93_wp]

    call tests%start('axisymmetry')
    call check(tests, 'QUAD4', 'FEM', [4, 9, 16], grid)
    call check(tests, 'QUAD8', 'FEM', [4, 9, 16], grid)
    call check(tests, 'TRI3', 'FEM', [1, 3, 4, 12], grid)
    call check(tests, 'TRI6', 'FEM', [4, 6, 7, 9, 12, 16], grid)
    call check(tests, 'QUAD4', 'STANDARD', [4, 9], part)
    call check(tests, 'QUAD4', 'STANDARD, INTEGRATION=CELL', [4, 9], part)
    call check(tests, 'TRI6', 'STANDARD, INTEGRATION=CELL', [12, 16], part)
    call check(tests, 'QUAD4', 'SPLINE2', [4, 9], part)
    call check(tests, 'QUAD4', 'SPLINE3', [9, 16], part)
    call check(tests, 'QUAD4', 'GIMP', [4, 9], part)
    call check(tests, 'QUAD4', 'GIMP', [4, 9], cut)
    call check(tests, 'QUAD4', 'GIMP, INTEGRATION=CELL', [4], cut)
    call check(tests, 'QUAD4', 'SPLINE2G', [9], cut)
    call check(tests, 'QUAD4', 'SPLINE2G, INTEGRATION=CELL', [4, 9], cut)
    call check(tests, 'QUAD4', 'SPLINE2, INTEGRATION=CELL', [9], cut)
    call check(tests, 'QUAD4', 'SPLINE3, INTEGRATION=CELL', [9, 16], cut)
  end subroutine collect_axisymmetry

  !> One method with several numbers of points in a cylinder.
  subroutine check(tests, element, method, counts, corner)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> Element of the grid; parameters of *METHOD.
    character(len=*), intent(in) :: element, method
    !> Points of an element.
    integer, intent(in) :: counts(:)
    !> Radius and height of the cylinder.
    real(wp), intent(in) :: corner(2)
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    character(len=80) :: name
    logical :: ready
    integer :: i

    allocate (model, step)
    do i = 1, size(counts)
      write (name, '(4a,i0,a,f4.2)') element, ' ', method, ', ', counts(i), ' points, to ', corner(1)
      call make_model(element, method, counts(i), corner, model, step, ready)
      call tests%check(trim(name)//': the scene is good', ready)
      if (.not. ready) cycle
      call check_pressure(tests, trim(name), corner, model, step)
      call check_motion(tests, trim(name), model, step)
      ! Splines whose points have domains for cut cells only see the functions at their places as in the plane.
      if (model%space%averaged .or. .not. model%space%domains) call check_weight(tests, trim(name), counts(i), corner, &
        model, step)
    end do
  end subroutine check

  !> A cylinder under a pressure of one on smooth supports.
  subroutine make_model(element, method, count, corner, model, step, ready)
    !> As for `check`.
    character(len=*), intent(in) :: element, method
    integer, intent(in) :: count
    real(wp), intent(in) :: corner(2)
    !> The model, its state that of the pressure, and a step that is ready to be solved.
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    logical, intent(out) :: ready
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=600) :: text
    integer :: p

    allocate (analysis)
    write (text, '(5a,2(f4.2,a),a,i0,3a)') '*MODEL, TYPE=AXISYMMETRIC|*GRID, ELEMENT=', element, lines, &
      '|*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=axis, PLANE=X|0|*MATERIAL, NAME=m|*ELASTIC|1000, 0.3|*UNIT WEIGHT|1|'// &
      '*BODY, NAME=b, MATERIAL=m, SHAPE=BOX|', '0, ', corner(1), ', 0, ', corner(2), '|', '*POINTS, PER ELEMENT=', count, &
      '|*METHOD, KINEMATICS=JAUMANN, BASIS=', method, &
      '|*PHASE, NAME=one|*FIX|base, Y|axis, X|*GRAVITY|0, 1|*CONTROLS, STEPS=1|*END PHASE|'
    call parse_deck('axis.inp', joined(trim(text)), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (.not. allocated(error)) then
      call start_phase(model)
      do p = 1, model%state%points%count
        model%state%points%stress(:3, p) = -1.0_wp
        associate (law => model%laws(1)%law)
          call law%start(model%state%points%stress(:, p), model%state%points%state(:law%state_count, p))
        end associate
      end do
      call initialise_step(model, step, error)
    end if
    ready = .not. allocated(error)
    if (ready) call end_system(step%system)
  end subroutine make_model

  !> Internal force of the pressure.
  subroutine check_pressure(tests, name, corner, model, step)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    real(wp), intent(in) :: corner(2)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    real(wp), dimension(2, model%space%node_count) :: still, exact
    integer :: side

    exact = 0.0_wp
    call add_side(model, 1, corner(1), corner(2), -1.0_wp, exact)
    call add_side(model, 2, corner(2), corner(1), -1.0_wp, exact)
    call add_side(model, 2, 0.0_wp, corner(1), 1.0_wp, exact)
    still = 0.0_wp
    call evaluate_step(model, step, still, tangent_none)
    do side = 1, 2
      call tests%close(name//': force of a pressure along '//merge('r', 'z', side == 1), &
        maxval(abs(step%forces%internal(side, :) - exact(side, :))), 0.0_wp, rounding)
    end do
  end subroutine check_pressure

  !> Add the integral of r N over a side of the cylinder to the forces across it.
  subroutine add_side(model, across, place_of_side, extent, factor, force)
    type(model_type), intent(in) :: model
    !> Axis across the side, its coordinate, and the length of the side.
    integer, intent(in) :: across
    real(wp), intent(in) :: place_of_side, extent
    !> Traction.
    real(wp), intent(in) :: factor
    real(wp), intent(inout) :: force(:, :)
    real(wp), allocatable :: x(:), w(:)
    real(wp) :: at(2)
    integer :: k

    call places_along(3 - across, extent, x, w)
    do k = 1, size(x)
      at(across) = place_of_side
      at(3 - across) = x(k)
      call add_functions(model, at, factor*w(k)*at(1), across, force)
    end do
  end subroutine add_side

  !> Add the functions at a place to the forces along an axis.
  subroutine add_functions(model, at, factor, axis, force)
    type(model_type), intent(in) :: model
    !> The place, and what the functions are multiplied by.
    real(wp), intent(in) :: at(2), factor
    integer, intent(in) :: axis
    real(wp), intent(inout) :: force(:, :)
    type(shape_values_type) :: functions
    real(wp) :: local(2)
    integer :: cell, a
    logical :: found

    cell = 1
    local = 0.0_wp
    call locate(model%mesh, at, cell, local, found)
    call functions_at(model%space, model%mesh, cell, local, functions)
    do a = 1, functions%count
      force(axis, functions%node(a)) = force(axis, functions%node(a)) + factor*functions%shape(a)
    end do
  end subroutine add_functions

  !> Gauss points between the grid lines from zero to an end.
  subroutine places_along(axis, extent, x, w)
    integer, intent(in) :: axis
    real(wp), intent(in) :: extent
    real(wp), allocatable, intent(out) :: x(:), w(:)
    real(wp), allocatable :: gauss(:), weights(:)
    real(wp) :: ends(size(lines_r)), from, to
    integer :: c

    call line_gauss(4, gauss, weights)
    ends = merge(lines_r, lines_z, axis == 1)
    allocate (x(0), w(0))
    do c = 1, size(ends) - 1
      from = ends(c)
      to = min(extent, ends(c + 1))
      if (to <= from) exit
      x = [x, 0.5_wp*(from + to) + 0.5_wp*(to - from)*gauss]
      w = [w, 0.5_wp*(to - from)*weights]
    end do
  end subroutine places_along

  !> A linear displacement moves the middle of every point as it says, and strains it so.
  subroutine check_motion(tests, name, model, step)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    real(wp) :: displacement(2, model%space%node_count), u(3), f(3, 3), worst(2)
    integer :: a, g, q, p

    do a = 1, model%space%node_count
      displacement(:, a) = [0.3_wp, -0.2_wp]*node_position(model%space, model%mesh, a)
    end do
    worst = 0.0_wp
    do g = 1, step%at_points%group_count
      do q = step%at_points%first(g), step%at_points%first(g + 1) - 1
        p = step%at_points%source(q)
        u = point_displacement(step%at_points, displacement, g, q)
        f = step_gradient(step%at_points, displacement, g, q)
        worst(1) = max(worst(1), maxval(abs(u(:2) - [0.3_wp, -0.2_wp]*model%state%points%position(:, p))))
        worst(2) = max(worst(2), abs(f(1, 1) - 1.3_wp), abs(f(2, 2) - 0.8_wp), abs(f(3, 3) - 1.3_wp), abs(f(1, 2)), &
          abs(f(2, 1)))
      end do
    end do
    call tests%close(name//': a linear field moves the points', worst(1), 0.0_wp, rounding)
    call tests%close(name//': a linear field strains the points', worst(2), 0.0_wp, rounding)
  end subroutine check_motion

  !> The weight of the points.
  subroutine check_weight(tests, name, count, corner, model, step)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    !> Points of an element.
    integer, intent(in) :: count
    real(wp), intent(in) :: corner(2)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    real(wp), dimension(2, model%space%node_count) :: weight, exact
    real(wp), allocatable :: r(:), z(:), w(:), h(:)
    integer :: i, j

    ! Triangles have no product rule here, and few points are no rule for r N.
    if (index(name, 'QUAD') == 0 .or. (index(name, 'QUAD4') == 0 .and. count < 9)) return
    call places_along(1, corner(1), r, w)
    call places_along(2, corner(2), z, h)
    exact = 0.0_wp
    do j = 1, size(z)
      do i = 1, size(r)
        call add_functions(model, [r(i), z(j)], r(i)*w(i)*h(j), 2, exact)
      end do
    end do
    call load_at(model, step, 1.0_wp, weight)
    call tests%close(name//': weight', maxval(abs(weight - exact)), 0.0_wp, rounding)
  end subroutine check_weight
end module test_axisymmetry
