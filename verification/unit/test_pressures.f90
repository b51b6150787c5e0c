!> Pressures that follow their surface: the force on the areas at the end of a step, its tangent, and the part of
!> the tangent that symmetric equations take.
module test_pressures
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_law, only: tangent_consistent
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_initialisation, only: step_type, initialise_step, evaluate_step
  use qsmpm_equations, only: gather
  use qsmpm_term_sums, only: add_all_blocks
  use qsmpm_sparse_matrix, only: multiply
  use qsmpm_space, only: node_position
  use qsmpm_pressures, only: pressures_type
  use qsmpm_term, only: term_type
  use deck_samples, only: joined
  use term_samples, only: term_named, force_named
  use testing, only: tests_type
  implicit none
  private

  public :: collect_pressures

  !> Pressure in force, and steps of the central differences: the force is quadratic in the displacement, so that
  !> these have no error but rounding.
  real(wp), parameter :: pressure = 1.0_wp, difference = 1.0e-3_wp

  character(len=*), parameter :: name = 'load of the pressures'

contains

  !> All checks.
  subroutine collect_pressures(tests)
    type(tests_type), intent(inout) :: tests
    character(len=8), parameter :: bases(*) = [character(len=8) :: 'STANDARD', 'GIMP', 'SPLINE2', 'SPLINE2G', &
      'SPLINE3', 'FEM']
    character(len=8), parameter :: elements(*) = [character(len=8) :: 'TRI6', 'WEDGE15', 'TET10']
    integer :: i

    call tests%start('pressures')
    do i = 1, size(bases)
      call check_tangent(tests, 'PLANE STRAIN', 'QUAD4', bases(i), 30)
      call check_tangent(tests, 'AXISYMMETRIC', 'QUAD4', bases(i), 30)
      call check_tangent(tests, '3D', 'HEX8', bases(i), 30)
    end do
    do i = 1, size(elements)
      call check_tangent(tests, trim(merge('PLANE STRAIN', '3D          ', i == 1)), elements(i), 'STANDARD', 30)
    end do
    call check_tangent(tests, '3D', 'HEX8', 'SPLINE2G', 0)
    call check_tangent(tests, 'AXISYMMETRIC', 'TRI6', 'STANDARD', 0)
    call check_homogeneous(tests, 'PLANE STRAIN', 'QUAD4')
    call check_homogeneous(tests, '3D', 'HEX8')
    call check_symmetry(tests)
  end subroutine collect_pressures

  !> A pressure that is not small beside the modulus takes the whole load stiffness.
  subroutine check_symmetry(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step

    allocate (model, step)
    call make_step('PLANE STRAIN', 'QUAD4', 'STANDARD', 0, '1.9', model, step)
    call tests%check('a pressure of 1.9 % of the modulus leaves the equations symmetric', step%equations%symmetric)
    call make_step('PLANE STRAIN', 'QUAD4', 'STANDARD', 0, '-2.1', model, step)
    call tests%check('a suction of 2.1 % of the modulus does not', .not. step%equations%symmetric)
  end subroutine check_symmetry

  !> A block under pressure on two sides that meet, elastic as long as nothing strains; its friction without
  !> dilatancy makes the equations unsymmetric.
  subroutine make_step(kind, element, basis, friction, load, model, step)
    character(len=*), intent(in) :: kind, element, basis, load
    integer, intent(in) :: friction
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: text
    character(len=:), allocatable :: strength
    character(len=2) :: angle

    allocate (analysis)
    write (angle, '(i2)') friction
    strength = ''
    if (friction > 0) strength = '|*MOHR COULOMB| 1E6, '//angle//', 0'
    text = '*MODEL, TYPE='//kind//'|*GRID, ELEMENT='//trim(element)//'| X, 1, 4, 3| Y, 0, 3, 3|'
    if (kind == '3D') text = text//' Z, 0, 2, 2|'
    text = text//'*METHOD, BASIS='//trim(basis)//'|*MATERIAL, NAME=soil|*ELASTIC| 100, 0.3'//strength// &
      '|*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX| 1, 3, 0, 2'
    if (kind == '3D') text = text//', 0, 1'
    text = text//'|*NSET, NSET=base, PLANE=Y|0|'
    if (kind == '3D') then
      text = text//'*SURFACE, NAME=top| 1, 3, 2, 2, 0, 1|*SURFACE, NAME=side| 3, 3, 0, 2, 0, 1|'
    else
      text = text//'*SURFACE, NAME=top| 1, 3, 2, 2|*SURFACE, NAME=side| 3, 3, 0, 2|'
    end if
    text = text//'*PHASE, NAME=load|*FIX|base, Y|*PRESSURE, SURFACE=top|'//load// &
      '|*PRESSURE, SURFACE=side|1|*END PHASE|'
    call parse_deck('test.inp', joined(text), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the deck of the test is not good'
    call start_phase(model)
    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'the step of the test cannot be made'
    call set_pressures(step, pressure)
  end subroutine make_step

  !> Put one pressure on all surfaces in force.
  subroutine set_pressures(step, value)
    type(step_type), intent(inout), target :: step
    real(wp), intent(in) :: value
    class(term_type), pointer :: term

    term => term_named(step, name)
    select type (term)
    type is (pressures_type)
      term%pressure = value
    end select
  end subroutine set_pressures

  !> The matrix with pressures less the one without is the derivative of their force, or its symmetric part.
  subroutine check_tangent(tests, kind, element, basis, friction)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind, element, basis
    integer, intent(in) :: friction
    character(len=:), allocatable :: label
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    class(term_type), pointer :: term
    real(wp), allocatable :: u(:, :), v(:, :), w(:, :), force(:, :), change(:, :), found(:)
    real(wp), allocatable :: found_by_differences(:)
    integer :: a, c

    allocate (model, step)
    label = kind//' '//trim(element)//' '//trim(basis)//': '
    call make_step(kind, element, basis, friction, '1', model, step)
    allocate (u(model%mesh%dimension, model%space%node_count))
    allocate (v, w, force, change, mold=u)
    allocate (found_by_differences(step%equations%count))
    do a = 1, size(u, 2)
      do c = 1, size(u, 1)
        u(c, a) = 0.02_wp*sin(1.7_wp*a + 0.8_wp*c)
        v(c, a) = cos(1.1_wp*a + 2.1_wp*c)
        w(c, a) = sin(3.1_wp*a + 1.2_wp*c)
      end do
    end do
    where (.not. spread(step%equations%active, 1, size(u, 1)) .or. model%loading%constrained)
      v = 0.0_wp
      w = 0.0_wp
    end where
    force = derivative(step, u, v)
    change = 0.0_wp
    term => term_named(step, name)
    call term%add_linear_force(v, change)
    call tests%close(label//'load stiffness of a prescribed displacement', &
      maxval(abs(change + derivative(step, 0.0_wp*u, v))), 0.0_wp, 1.0e-9_wp*maxval(abs(change)))
    call matrix_part(model, step, u, v, found)
    call tests%check(label//'equations keep their symmetry', step%equations%symmetric .eqv. friction == 0)
    if (friction > 0) then
      call gather(step%equations, force, found_by_differences)
      call tests%close(label//'tangent is the derivative of the force', maxval(abs(found + found_by_differences)), &
        0.0_wp, 1.0e-9_wp*maxval(abs(found)))
    else
      ! w K_s v = (w K v + v K w)/2
      call gather(step%equations, w, found_by_differences)
      call tests%close(label//'symmetric part of the tangent', dot_product(found_by_differences, found), &
        -0.5_wp*sum(w*force + v*derivative(step, u, w)), 1.0e-9_wp*maxval(abs(found))*size(found))
    end if
  end subroutine check_tangent

  !> Derivative of the force of the pressures along a direction.
  function derivative(step, displacement, direction) result(change)
    type(step_type), intent(in) :: step
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :), direction(:, :)
    real(wp) :: change(size(displacement, 1), size(displacement, 2))

    change = (force_named(step, name, displacement + difference*direction) &
      - force_named(step, name, displacement - difference*direction))/(2.0_wp*difference)
  end function derivative

  !> What the pressures add to the product of the matrix and a direction (equations).
  subroutine matrix_part(model, step, displacement, direction, part)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :), direction(:, :)
    real(wp), allocatable, intent(out) :: part(:)
    real(wp), allocatable :: x(:), without(:)

    allocate (part(step%equations%count), x(step%equations%count), without(step%equations%count))
    call gather(step%equations, direction, x)
    call evaluate_step(model, step, displacement, tangent_consistent)
    call add_all_blocks(step%terms, displacement, step%equations, step%matrix)
    call multiply(step%matrix, x, part)
    call set_pressures(step, 0.0_wp)
    call evaluate_step(model, step, displacement, tangent_consistent)
    call add_all_blocks(step%terms, displacement, step%equations, step%matrix)
    call multiply(step%matrix, x, without)
    call set_pressures(step, pressure)
    part = part - without
  end subroutine matrix_part

  !> The pressures press on the areas that a homogeneous step makes: the cofactor of its gradient.
  subroutine check_homogeneous(tests, kind, element)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind, element
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: u(:, :), force(:, :)
    real(wp) :: total(2)
    integer :: a

    allocate (model, step)
    call make_step(kind, element, 'SPLINE2', 0, '1', model, step)
    allocate (u(model%mesh%dimension, model%space%node_count))
    do a = 1, size(u, 2)
      u(:, a) = node_position(model%space, model%mesh, a)
      u(:2, a) = [0.1_wp*u(1, a) + 0.2_wp*u(2, a), -0.05_wp*u(2, a)]
      if (size(u, 1) == 3) u(3, a) = 0.3_wp*u(3, a)
    end do
    allocate (force, source=force_named(step, name, u))
    total = sum(force(:2, :), dim=2)
    ! F = [1.1 0.2; 0 0.95], F_33 = 1 or 1.3; areas 2 along x and y, cofactor F_33 [0.95 0; -0.2 1.1].
    call tests%close(kind//': force on the areas of a homogeneous step', norm2(total + pressure*2.0_wp* &
      merge(1.3_wp, 1.0_wp, kind == '3D')*[0.95_wp, 0.9_wp]), 0.0_wp, 1.0e-9_wp*pressure)
  end subroutine check_homogeneous
end module test_pressures
