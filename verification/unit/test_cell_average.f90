!> Cell integration and assembly: the fit reproduces linear fields, and the stiffness of whole meshes
!> is the derivative of the internal force, for points and for cells, in all three kinds of model.
module test_cell_average
  use active_samples, only: activate
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: interpolate
  use qsmpm_element, only: shape_functions, element_order
  use qsmpm_cell_share, only: cell_volumes
  use qsmpm_points, only: points_type, allocate_points
  use qsmpm_seeding, only: body_shape_type, seed_list_type, seed_body, seed_even
  use qsmpm_point_location, only: activation_type
  use qsmpm_space, only: space_type
  use qsmpm_space_builder, only: element_space
  use qsmpm_domains, only: domains_type
  use qsmpm_integration, only: integration_type
  use qsmpm_point_integration, only: integrate_at_points
  use qsmpm_cell_average, only: integrate_in_cells
  use qsmpm_recovered_gradient, only: recover_gradients
  use qsmpm_assembly, only: evaluation_type, prepare_evaluation, evaluate
  use qsmpm_law, only: law_slot_type, law_type, tangent_consistent, tangent_none
  use qsmpm_law_factory, only: new_law, kinematics_jaumann, kinematics_logarithmic, rate_midpoint
  use qsmpm_material_parameters, only: material_parameters_type
  use sample_models, only: sample_grid
  use testing, only: tests_type
  implicit none
  private

  public :: collect_cell_average

contains

  !> All checks.
  subroutine collect_cell_average(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('cell_average')
    call check_model(tests, 'TRI6', .false., kinematics_logarithmic)
    call check_model(tests, 'QUAD4', .true., kinematics_logarithmic)
    call check_model(tests, 'QUAD8', .false., kinematics_jaumann)
    call check_model(tests, 'WEDGE15', .false., kinematics_logarithmic)
    call check_model(tests, 'WEDGE6', .false., kinematics_jaumann)
    call check_model(tests, 'TET4', .false., kinematics_logarithmic)
  end subroutine collect_cell_average

  !> One kind of model.
  subroutine check_model(tests, name, axisymmetric, kinematics)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    logical, intent(in) :: axisymmetric
    integer, intent(in) :: kinematics
    type(mesh_type) :: mesh
    type(points_type) :: points
    type(law_slot_type), allocatable :: laws(:)
    type(space_type) :: space
    type(domains_type) :: domains
    type(activation_type) :: activation
    type(integration_type) :: at_points, in_cells
    real(wp), allocatable :: volumes(:)
    integer :: inaccurate

    call sample_grid(name, 2, 0.1_wp, mesh)
    mesh%axisymmetric = axisymmetric
    call make_laws(mesh%dimension, kinematics, laws)
    call stressed_points(mesh, laws, points)
    allocate (volumes(mesh%cell_count))
    call cell_volumes(mesh, volumes)
    call activate(mesh, volumes, points, activation)
    call element_space(mesh, space)
    call integrate_at_points(mesh, space, activation, points, domains, at_points)
    call integrate_in_cells(mesh, space, activation, points, laws, domains, in_cells, inaccurate)
    call tests%check('full cells of '//name//' go to their Gauss points', all(in_cells%source < 0))
    call tests%close('cells of '//name//' keep the volume', sum(in_cells%weight), sum(volumes), 1.0e-13_wp)
    call check_fit(tests, mesh, name, points, in_cells)
    call check_recovery(tests, mesh, activation, volumes, laws, name, points, at_points)
    call check_tangent(tests, mesh, points, laws, name//' at points', at_points)
    call check_tangent(tests, mesh, points, laws, name//' in cells', in_cells)
  end subroutine check_model

  !> Recovered gradients of a field the element holds are exact: each cell has the right one at its nodes.
  subroutine check_recovery(tests, mesh, activation, volumes, laws, name, points, at_points)
    type(tests_type), intent(inout) :: tests
    type(mesh_type), intent(in) :: mesh
    type(activation_type), intent(in) :: activation
    real(wp), intent(in) :: volumes(:)
    type(law_slot_type), intent(in) :: laws(:)
    character(len=*), intent(in) :: name
    type(points_type), intent(in) :: points
    type(integration_type), intent(inout) :: at_points
    real(wp) :: displacement(mesh%dimension, mesh%node_count), bent, expected, worst
    integer :: q, p, last

    last = mesh%dimension
    ! Serendipity elements of uneven shape hold no full quadratic.
    bent = merge(0.3_wp, 0.0_wp, element_order(mesh%cell_kind(1)) > 1 .and. name /= 'QUAD8')
    displacement = 0.0_wp
    displacement(1, :) = 0.1_wp*mesh%coordinates(last, :) + bent*mesh%coordinates(last, :)**2
    call recover_gradients(mesh, activation, volumes, laws, displacement, at_points)
    worst = 0.0_wp
    do q = 1, at_points%point_count
      p = at_points%source(q)
      expected = 0.1_wp + 2.0_wp*bent*points%position(last, p)
      worst = max(worst, abs(at_points%given(1, last, q) - expected), abs(at_points%given(last, 1, q)))
    end do
    ! Rounding of gradients of the order of one.
    call tests%close('recovered gradients of '//name//' are exact', worst, 0.0_wp, 1.0e-12_wp)
    deallocate (at_points%given)
  end subroutine check_recovery

  !> A Mohr-Coulomb soil.
  subroutine make_laws(dimension, kinematics, laws)
    integer, intent(in) :: dimension, kinematics
    type(law_slot_type), allocatable, intent(out) :: laws(:)
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error

    allocate (laws(1))
    call new_law(material_parameters_type(young=100.0_wp, poisson=0.3_wp, mohr_coulomb=.true., cohesion=0.5_wp, &
      friction_angle=30.0_wp, dilatancy_angle=5.0_wp), dimension, kinematics, rate_midpoint, law, error)
    allocate (laws(1)%law, source=law)
  end subroutine make_laws

  !> The default points, under the same small stress everywhere.
  subroutine stressed_points(mesh, laws, points)
    type(mesh_type), intent(in) :: mesh
    type(law_slot_type), intent(in) :: laws(:)
    type(points_type), intent(out) :: points
    type(body_shape_type) :: shape
    type(seed_list_type) :: list
    type(error_type), allocatable :: error
    real(wp) :: functions(20)
    integer :: p, n

    call seed_body(mesh, shape, 1, 0, seed_even, 0, list, error)
    call allocate_points(points, mesh%dimension, list%count, merge(4, 6, mesh%dimension == 2), &
      laws(1)%law%state_count)
    points%cell = list%cell(:list%count)
    points%local = list%local(:, :list%count)
    points%volume = list%volume(:list%count)
    points%initial_volume = points%volume
    points%material = 1
    do p = 1, points%count
      n = mesh%cell_first(points%cell(p) + 1) - mesh%cell_first(points%cell(p))
      call shape_functions(mesh%cell_kind(points%cell(p)), points%local(:, p), functions(:n))
      points%position(:, p) = interpolate(mesh, points%cell(p), functions(:n), mesh%coordinates)
      points%stress(1:3, p) = -[1.0_wp, 1.5_wp, 1.2_wp]
      points%stress(4, p) = 0.1_wp
      call laws(1)%law%start(points%stress(:, p), points%state(:, p))
    end do
  end subroutine stressed_points

  !> A constant stress comes out of the fit as it went in.
  subroutine check_fit(tests, mesh, name, points, in_cells)
    type(tests_type), intent(inout) :: tests
    type(mesh_type), intent(in) :: mesh
    character(len=*), intent(in) :: name
    type(points_type), intent(in) :: points
    type(integration_type), intent(in) :: in_cells
    real(wp) :: worst
    integer :: q

    worst = 0.0_wp
    do q = 1, in_cells%point_count
      worst = max(worst, maxval(abs(in_cells%stress(:, -in_cells%source(q)) - points%stress(:, 1))))
    end do
    ! The ridge of 1e-5 acts on slopes only, so a constant field is exact up to rounding.
    call tests%close('the fit in '//name//' keeps a constant stress', worst, 0.0_wp, 1.0e-11_wp)
    call tests%check('all nodes of '//name//' are reached', maxval(in_cells%nodes) == mesh%node_count)
  end subroutine check_fit

  !> Central differences of the internal force in one random direction.
  subroutine check_tangent(tests, mesh, points, laws, name, integration)
    type(tests_type), intent(inout) :: tests
    type(mesh_type), intent(in) :: mesh
    type(points_type), intent(in) :: points
    type(law_slot_type), intent(in) :: laws(:)
    character(len=*), intent(in) :: name
    type(integration_type), intent(in) :: integration
    type(evaluation_type) :: evaluation
    real(wp) :: u(mesh%dimension, mesh%node_count), direction(mesh%dimension, mesh%node_count)
    real(wp) :: linear(mesh%dimension, mesh%node_count), forward(mesh%dimension, mesh%node_count)
    real(wp), parameter :: step = 1.0e-6_wp
    integer :: a, i, d

    d = mesh%dimension
    do a = 1, mesh%node_count
      do i = 1, d
        u(i, a) = 0.02_wp*sin((1.2_wp*i - 0.1_wp)*a)
        direction(i, a) = cos((1.1_wp*i - 0.4_wp)*a)
      end do
    end do
    call prepare_evaluation(integration, d, mesh%node_count, .false., .false., evaluation)
    call evaluate(integration, points, laws, u, tangent_consistent, evaluation, prescribed=direction)
    linear = evaluation%linear_force
    call evaluate(integration, points, laws, u + step*direction, tangent_none, evaluation)
    forward = evaluation%force
    call evaluate(integration, points, laws, u - step*direction, tangent_none, evaluation)
    ! Points that change their yield region between the two states leave some 1e-6 of the norm.
    call tests%close('stiffness of '//name//' is the derivative of the force', &
      norm2((forward - evaluation%force)/(2.0_wp*step) - linear)/norm2(linear), 0.0_wp, 1.0e-5_wp)
  end subroutine check_tangent
end module test_cell_average
