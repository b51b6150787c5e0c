!> Springs of held surfaces: what they resist, that their stiffness is the derivative of their force, and
!> what is left of a surface that follows the deformation.
module test_supports
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_initialisation, only: step_type, initialise_step, evaluate_step
  use qsmpm_convection, only: convect
  use qsmpm_law, only: tangent_none
  use qsmpm_space, only: node_position
  use qsmpm_supports, only: supports_type, support_block
  use deck_samples, only: joined
  use term_samples, only: term_named, force_named
  use testing, only: tests_type
  implicit none
  private

  public :: collect_supports

  !> The slanted side of the body and its unit normal.
  real(wp), parameter :: normal(2) = [0.6_wp, -0.8_wp], tangent(2) = [0.8_wp, 0.6_wp]

  character(len=*), parameter :: springs = 'force of the supports'

contains

  !> All checks.
  subroutine collect_supports(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('supports')
    call check_springs(tests, 'SPLINE2G', 'NORMAL')
    call check_springs(tests, 'STANDARD', 'ALL')
    call check_gap(tests)
    call check_areas(tests, 'SPLINE2')
    call check_areas(tests, 'GIMP')
    call check_areas(tests, 'STANDARD')
  end subroutine collect_supports

  !> A triangle whose lower side, from (0, 0) to (2, 1.5), cuts the grid.
  subroutine make_step(basis, kind, model, step)
    character(len=*), intent(in) :: basis, kind
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    ! No strains: points are moved without the results of an evaluation.
    call parse_deck('test.inp', joined('*FIELD, STRAIN=NO|*MODEL, TYPE=PLANE STRAIN|'// &
      '*GRID, ELEMENT=QUAD4| X, -1, 3, 8| Y, -1, 3, 8|*METHOD, BASIS='//basis//'|*MATERIAL, NAME=soil|'// &
      '*ELASTIC| 100, 0.3|*BODY, NAME=wedge, MATERIAL=soil, SHAPE=POLYGON| 0, 0| 2, 1.5| 0, 2|'// &
      '*POINTS, BODY=wedge, PER ELEMENT=9|*SURFACE, NAME=rock, TYPE=SEGMENT| 0, 0, 2, 1.5|*PHASE, NAME=load|'// &
      '*SUPPORT, SURFACE=rock, TYPE='//kind//'|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the deck of the test is not good'
    call start_phase(model)
    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'the step of the test cannot be made'
  end subroutine make_step

  !> The supports among the terms.
  function supports_of(step) result(supports)
    type(step_type), intent(in), target :: step
    type(supports_type), pointer :: supports

    supports => null()
    select type (term => term_named(step, springs))
    type is (supports_type)
      supports => term
    end select
  end function supports_of

  !> Force and stiffness of the springs.
  subroutine check_springs(tests, basis, kind)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: basis, kind
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(supports_type), pointer :: supports
    real(wp), allocatable :: u(:, :), force(:, :), linear(:, :), block(:, :, :, :)
    real(wp) :: total(2)
    integer :: a, b, k, n

    allocate (model, step)
    call make_step(basis, kind, model, step)
    supports => supports_of(step)
    allocate (u(2, model%space%node_count), force(2, model%space%node_count), &
      linear(2, model%space%node_count))
    ! The springs resist a push along the normal by their whole stiffness, whatever the functions: they sum to one.
    u = spread(normal, 2, model%space%node_count)
    force = force_named(step, springs, u)
    total = sum(force, dim=2)
    call tests%close(kind//': a push along the normal is resisted', dot_product(total, normal), &
      sum(supports%stiffness), 1.0e-10_wp*sum(supports%stiffness))
    u = spread(tangent, 2, model%space%node_count)
    force = force_named(step, springs, u)
    total = sum(force, dim=2)
    call tests%close(kind//': sliding is free or as stiff', dot_product(total, tangent), &
      merge(sum(supports%stiffness), 0.0_wp, kind == 'ALL'), 1.0e-10_wp*sum(supports%stiffness))
    do a = 1, size(u, 2)
      u(:, a) = [sin(1.7_wp*a), cos(2.3_wp*a)]
    end do
    linear = 0.0_wp
    force = force_named(step, springs, u) - force_named(step, springs, 0.0_wp*u)
    do k = 1, supports%connectivity%count
      allocate (block, source=support_block(supports, k))
      n = size(block, 2)
      associate (nodes => supports%connectivity%nodes(supports%connectivity%first(k): &
        supports%connectivity%first(k + 1) - 1))
        do b = 1, n
          do a = 1, n
            linear(:, nodes(a)) = linear(:, nodes(a)) + matmul(block(:, a, :, b), u(:, nodes(b)))
          end do
        end do
      end associate
      deallocate (block)
    end do
    ! The force is linear: stiffness times displacement to rounding.
    call tests%close(basis//': stiffness is the derivative of the force', maxval(abs(linear - force)), 0.0_wp, &
      1.0e-12_wp*maxval(abs(force)))
  end subroutine check_springs

  !> A surface that is off its plane is pulled back although nothing moves in the step.
  subroutine check_gap(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(supports_type), pointer :: supports
    type(error_type), allocatable :: error
    real(wp), allocatable :: force(:, :), still(:, :)

    allocate (model, step)
    call make_step('SPLINE2', 'NORMAL', model, step)
    supports => supports_of(step)
    model%state%surface%position = model%state%surface%position &
      + 0.01_wp*spread(normal, 2, model%state%surface%count)
    call initialise_step(model, step, error)
    allocate (still(2, model%space%node_count), source=0.0_wp)
    allocate (force, source=force_named(step, springs, still))
    call tests%close('the gap of earlier steps is resisted', dot_product(sum(force, dim=2), normal), &
      0.01_wp*sum(supports%stiffness), 1.0e-10_wp*sum(supports%stiffness))
  end subroutine check_gap

  !> A homogeneous step turns and stretches areas by the cofactor of its gradient.
  subroutine check_areas(tests, basis)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: basis
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :)
    real(wp) :: expected(2), total(2)
    integer :: a

    allocate (model, step)
    call make_step(basis, 'ALL', model, step)
    allocate (u(2, model%space%node_count))
    do a = 1, model%space%node_count
      u(:, a) = node_position(model%space, model%mesh, a)
      u(:, a) = [0.1_wp*u(1, a) + 0.2_wp*u(2, a), -0.05_wp*u(2, a)]
    end do
    ! The points take what the last evaluation has found.
    call evaluate_step(model, step, u, tangent_none)
    call convect(model, step, u, error)
    total = sum(model%state%surface%area_vector, dim=2)
    ! F = [1.1 0.2; 0 0.95], cofactor [0.95 0; -0.2 1.1], area 2.5 along the normal.
    expected = 2.5_wp*[0.95_wp*normal(1), -0.2_wp*normal(1) + 1.1_wp*normal(2)]
    call tests%check(basis//': the step is taken', .not. allocated(error))
    call tests%close(basis//': areas follow Nanson''s formula', norm2(total - expected), 0.0_wp, 1.0e-10_wp)
  end subroutine check_areas
end module test_supports
