!> Integration with splines and with domains, at the points and in cells: volumes, and the force of a
!> uniform stress, which is that of its traction on the surface of the body,
!>   sum over points of V grad N_a  =  integral of N_a n over the surface.
!> With domains that tile the body it holds to rounding: averages of gradients are differences of
!> averages at the ends of the domains, and at inner ends they cancel.
module test_integration
  use active_samples, only: activate
  use qsmpm_kinds, only: wp
  use qsmpm_sorting, only: sort
  use qsmpm_line_rule, only: line_gauss
  use qsmpm_mesh, only: mesh_type
  use qsmpm_cell_share, only: cell_volumes
  use qsmpm_points, only: points_type
  use qsmpm_point_location, only: activation_type
  use qsmpm_space, only: space_type, shape_values_type, functions_at, node_position
  use qsmpm_domains, only: domains_type
  use qsmpm_integration, only: integration_type, place_of, group_of
  use qsmpm_point_integration, only: integrate_at_points
  use qsmpm_cell_average, only: integrate_in_cells
  use qsmpm_assembly, only: evaluation_type, prepare_evaluation, evaluate
  use qsmpm_law, only: law_slot_type, tangent_none, status_cut
  use qsmpm_law_factory, only: kinematics_jaumann, kinematics_logarithmic
  use qsmpm_soil_model_law, only: soil_model_law_type, make_soil_model_law
  use soil_samples, only: refusing_type
  use sample_models, only: uneven_grid, sample_space, tiled_box, owner_of, sample_laws, lines_x, lines_y, lines_z
  use testing, only: tests_type
  implicit none
  private

  public :: collect_integration

  !> Sums of some thousand products near one.
  real(wp), parameter :: rounding = 1.0e-12_wp
  !> The stress everywhere, 11, 22, 33, 12, 13, 23, below the strength.
  real(wp), parameter :: stress(6) = [-1.0_wp, -1.5_wp, -1.2_wp, 0.1_wp, 0.0_wp, -0.05_wp]

  !> A body and what it is integrated with.
  type :: sample_type
    type(mesh_type) :: mesh
    type(space_type) :: space
    type(points_type) :: points
    type(domains_type) :: domains
    type(activation_type) :: activation
    type(law_slot_type), allocatable :: laws(:)
    type(integration_type) :: at_points, in_cells
    real(wp), allocatable :: volumes(:)
  end type sample_type

contains

  !> All checks.
  subroutine collect_integration(tests)
    type(tests_type), intent(inout) :: tests
    type(sample_type) :: sample
    character(len=24) :: name
    integer :: dimension, degree

    call tests%start('integration')
    do dimension = 2, 3
      do degree = 1, 3
        write (name, '(a,i0,a,i0,a)') 'degree ', degree, ' in ', dimension, 'D'
        ! From the lower corner of the grid: whole cells, and on the other sides cut ones. The column
        ! from 1.4 to 2.4 and the row from 1.7 to 2.2 own no point, or only few.
        call make_sample(dimension, degree, [-0.2_wp, 0.0_wp, 0.0_wp], [1.5_wp, 2.0_wp, 1.6_wp], [8, 9, 7], sample)
        call check_body(tests, trim(name)//' from a corner', sample, .true.)
        ! In the middle, with empty cells on all sides but one, where the last layer is filled too little.
        call make_sample(dimension, degree, [0.5_wp, 0.6_wp, 0.7_wp], [2.6_wp, 2.1_wp, 2.2_wp], [9, 9, 7], sample)
        call check_body(tests, trim(name)//' amid', sample, .false.)
      end do
    end do
    call check_radius(tests)
    call check_plain_points(tests)
    call check_seen_nodes(tests)
    call check_shares(tests)
  end subroutine collect_integration

  !> A box of points with domains under a uniform stress.
  subroutine make_sample(dimension, degree, low, high, parts, sample)
    integer, intent(in) :: dimension, degree
    !> Corners, and points along the axes.
    real(wp), intent(in) :: low(3), high(3)
    integer, intent(in) :: parts(3)
    type(sample_type), intent(out) :: sample
    integer :: p, inaccurate, kinematics

    kinematics = merge(kinematics_jaumann, kinematics_logarithmic, degree == 2)
    call sample_laws(dimension, kinematics, sample%laws)
    associate (s => sample, d => dimension)
      call uneven_grid(d, s%mesh)
      call sample_space(s%mesh, degree, .true., s%space)
      call tiled_box(s%mesh, low(:d), high(:d), parts, s%points, s%domains)
      deallocate (s%points%state)
      allocate (s%points%state(s%laws(1)%law%state_count, s%points%count))
      do p = 1, s%points%count
        s%points%stress(:, p) = stress(:size(s%points%stress, 1))
        call s%laws(1)%law%start(s%points%stress(:, p), s%points%state(:, p))
      end do
      allocate (s%volumes(s%mesh%cell_count))
      call cell_volumes(s%mesh, s%volumes)
      call activate(s%mesh, s%volumes, s%points, s%activation)
      call integrate_at_points(s%mesh, s%space, s%activation, s%points, s%domains, s%at_points)
      call integrate_in_cells(s%mesh, s%space, s%activation, s%points, s%laws, s%domains, s%in_cells, inaccurate)
    end associate
  end subroutine make_sample

  !> Volume and force of the body, at its points and in its cells.
  subroutine check_body(tests, name, sample, expect_whole)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(sample_type), intent(in) :: sample
    !> Some cells are integrated whole.
    logical, intent(in) :: expect_whole
    real(wp), dimension(sample%mesh%dimension, sample%space%node_count) :: surface, points, cells
    real(wp) :: volume

    volume = sum(sample%points%volume)
    call surface_force(sample, surface)
    call force_of(sample, sample%at_points, points)
    call force_of(sample, sample%in_cells, cells)
    call tests%check(name//': the body has a surface', maxval(abs(surface)) > 0.1_wp)
    call tests%close(name//': points hold the volume', sum(sample%at_points%weight), volume, rounding)
    call tests%close(name//': cells hold the volume', sum(sample%in_cells%weight), volume, rounding)
    call tests%close(name//': the force of a uniform stress at points', maxval(abs(points - surface)), 0.0_wp, rounding)
    ! The fit gives the stress back to 1e-13 of itself.
    call tests%close(name//': the force of a uniform stress in cells', maxval(abs(cells - surface)), 0.0_wp, &
      1.0e-11_wp)
    if (expect_whole) call tests%check(name//': whole and cut cells are there', &
      any(sample%in_cells%source < 0) .and. any(sample%in_cells%source > 0))
  end subroutine check_body

  !> Internal force of the start state.
  subroutine force_of(sample, integration, force)
    type(sample_type), intent(in) :: sample
    type(integration_type), intent(in) :: integration
    !> (dimension, nodes)
    real(wp), intent(out) :: force(:, :)
    type(evaluation_type) :: evaluation
    real(wp) :: still(size(force, 1), size(force, 2))

    still = 0.0_wp
    call prepare_evaluation(integration, size(force, 1), size(force, 2), .false., .false., evaluation)
    call evaluate(integration, sample%points, sample%laws, still, tangent_none, evaluation)
    force = evaluation%force
  end subroutine force_of

  !> Every point asks for a shorter step, the last ones for the shortest.
  subroutine check_shares(tests)
    type(tests_type), intent(inout) :: tests
    type(sample_type) :: sample
    type(refusing_type) :: hasty
    type(soil_model_law_type) :: law
    type(evaluation_type) :: evaluation
    real(wp), allocatable :: still(:, :)

    call make_sample(2, 1, [-0.2_wp, 0.0_wp, 0.0_wp], [1.5_wp, 2.0_wp, 1.6_wp], [8, 9, 7], sample)
    hasty%status = status_cut
    hasty%share = 0.5_wp
    hasty%hurry = 0.1_wp
    call make_soil_model_law(hasty, 2, law)
    deallocate (sample%laws(1)%law)
    allocate (sample%laws(1)%law, source=law)
    allocate (still(2, sample%space%node_count), source=0.0_wp)
    allocate (sample%at_points%cell_size(sample%at_points%group_count), source=1.0_wp)
    allocate (sample%at_points%cell_centre(2, sample%at_points%group_count), source=0.0_wp)
    call prepare_evaluation(sample%at_points, 2, sample%space%node_count, .false., .false., evaluation)
    call evaluate(sample%at_points, sample%points, sample%laws, still, tangent_none, evaluation)
    call tests%check('a point refuses', .not. evaluation%ok .and. evaluation%bad_status == status_cut)
    call tests%close('the shortest step that any point asks for', evaluation%bad_share, &
      0.5_wp/(1.0_wp + 0.1_wp*(sample%points%count - 1)), 0.0_wp)
  end subroutine check_shares

  !> Integral of sigma n N over the six (four) sides of the box, cell by cell, with Gauss points that
  !> are exact for products of cubics.
  subroutine surface_force(sample, force)
    type(sample_type), intent(in) :: sample
    !> (dimension, nodes)
    real(wp), intent(out) :: force(:, :)
    real(wp) :: low(size(force, 1)), high(size(force, 1)), tensor(3, 3)
    integer :: normal

    low = minval(sample%domains%low, dim=2)
    high = maxval(sample%domains%high, dim=2)
    tensor = reshape([stress(1), stress(4), stress(5), stress(4), stress(2), stress(6), stress(5), stress(6), &
      stress(3)], [3, 3])
    force = 0.0_wp
    do normal = 1, size(low)
      call add_side(sample, low, high, normal, high(normal), tensor(:size(low), normal), force)
      call add_side(sample, low, high, normal, low(normal), -tensor(:size(low), normal), force)
    end do
  end subroutine surface_force

  !> One side.
  subroutine add_side(sample, low, high, normal, place_of_side, traction, force)
    type(sample_type), intent(in) :: sample
    real(wp), intent(in) :: low(:), high(:)
    !> Axis across the side, and its coordinate.
    integer, intent(in) :: normal
    real(wp), intent(in) :: place_of_side
    real(wp), intent(in) :: traction(:)
    real(wp), intent(inout) :: force(:, :)
    real(wp), allocatable :: x(:, :), w(:, :)
    integer, allocatable :: number(:)
    real(wp) :: place(3), weight, local(3)
    type(shape_values_type) :: functions
    integer :: i, j, k, a, cell, d

    d = size(low)
    allocate (x(40, 3), w(40, 3), number(3))
    x = 0.0_wp
    w = 1.0_wp
    number = 1
    do a = 1, d
      x(1, a) = place_of_side
      if (a /= normal) call places_along(a, low(a), high(a), x(:, a), w(:, a), number(a))
    end do
    do k = 1, number(3)
      do j = 1, number(2)
        do i = 1, number(1)
          place = [x(i, 1), x(j, 2), x(k, 3)]
          weight = w(i, 1)*w(j, 2)*w(k, 3)
          call owner_of(sample%mesh, place(:d), cell, local(:d))
          call functions_at(sample%space, sample%mesh, cell, local(:d), functions)
          do a = 1, functions%count
            force(:, functions%node(a)) = force(:, functions%node(a)) + weight*functions%shape(a)*traction
          end do
        end do
      end do
    end do
  end subroutine add_side

  !> Gauss points of the parts of an interval between lines.
  subroutine places_along(axis, low, high, x, w, number)
    integer, intent(in) :: axis
    real(wp), intent(in) :: low, high
    real(wp), intent(inout) :: x(:), w(:)
    integer, intent(out) :: number
    real(wp), allocatable :: lines(:), gauss(:), weights(:)
    real(wp) :: from, to
    integer :: c

    select case (axis)
    case (1)
      allocate (lines, source=lines_x)
    case (2)
      allocate (lines, source=lines_y)
    case default
      allocate (lines, source=lines_z)
    end select
    call line_gauss(4, gauss, weights)
    number = 0
    do c = 1, size(lines) - 1
      from = max(low, lines(c))
      to = min(high, lines(c + 1))
      if (to <= from) cycle
      x(number + 1:number + 4) = 0.5_wp*(from + to) + 0.5_wp*(to - from)*gauss
      w(number + 1:number + 4) = 0.5_wp*(to - from)*weights
      number = number + 4
    end do
  end subroutine places_along

  !> In axisymmetry the radius of an integration point is that of its place; for a domain its middle.
  subroutine check_radius(tests)
    type(tests_type), intent(inout) :: tests
    type(sample_type) :: s
    type(integration_type) :: axisymmetric
    type(space_type) :: plain
    real(wp) :: worst
    integer :: q, degree

    do degree = 1, 3
      call make_sample(2, degree, [0.4_wp, 0.1_wp, 0.0_wp], [2.0_wp, 1.5_wp, 0.0_wp], [6, 5, 1], s)
      s%mesh%axisymmetric = .true.
      call integrate_at_points(s%mesh, s%space, s%activation, s%points, s%domains, axisymmetric)
      worst = 0.0_wp
      do q = 1, axisymmetric%point_count
        worst = max(worst, abs(radius(axisymmetric, q) - s%points%position(1, axisymmetric%source(q))))
      end do
      call tests%close('the radius of a domain is that of its middle', worst, 0.0_wp, rounding)
      call sample_space(s%mesh, degree, .false., plain)
      call integrate_at_points(s%mesh, plain, s%activation, s%points, s%domains, axisymmetric)
      worst = 0.0_wp
      do q = 1, axisymmetric%point_count
        worst = max(worst, abs(radius(axisymmetric, q) - s%points%position(1, axisymmetric%source(q))))
      end do
      call tests%close('the radius of a point is its own', worst, 0.0_wp, rounding)
    end do
  end subroutine check_radius

  !> Distance from the axis by the hoop direction: the sum of N/r is 1/r.
  pure real(wp) function radius(integration, point)
    type(integration_type), intent(in) :: integration
    integer, intent(in) :: point
    integer :: g, n, place

    g = group_of(integration, point)
    n = integration%node_first(g + 1) - integration%node_first(g)
    place = 3*place_of(integration, g, point)
    radius = 1.0_wp/sum(integration%gradient(place + 2*n + 1:place + 3*n))
  end function radius

  !> Without averages the points see the functions at their places: values, gradients and state.
  subroutine check_plain_points(tests)
    type(tests_type), intent(inout) :: tests
    type(sample_type) :: s
    type(space_type) :: plain
    type(integration_type) :: integration
    real(wp) :: worst(2), x(2)
    integer :: g, q, a, n, p

    call make_sample(2, 3, [0.4_wp, 0.1_wp, 0.0_wp], [2.0_wp, 1.5_wp, 0.0_wp], [6, 5, 1], s)
    call sample_space(s%mesh, 3, .false., plain)
    call integrate_at_points(s%mesh, plain, s%activation, s%points, s%domains, integration)
    worst = 0.0_wp
    do g = 1, integration%group_count
      n = integration%node_first(g + 1) - integration%node_first(g)
      do q = integration%first(g), integration%first(g + 1) - 1
        p = integration%source(q)
        x = 0.0_wp
        do a = 1, n
          x = x + integration%shape(place_of(integration, g, q) + a)*node_position(plain, s%mesh, &
            integration%nodes(integration%node_first(g) + a - 1))
        end do
        worst(1) = max(worst(1), maxval(abs(x - s%points%position(:, p))))
        worst(2) = max(worst(2), abs(integration%weight(q) - s%points%volume(p)))
      end do
    end do
    call tests%close('functions at a point give its place', worst(1), 0.0_wp, rounding)
    call tests%close('the volume is that of the point', worst(2), 0.0_wp, rounding)
    call tests%check('each point is taken once', sum(integration%source) == s%points%count*(s%points%count + 1)/2)
  end subroutine check_plain_points

  !> Domains of one cell that reach out of it on different sides leave corners of their common block that
  !> none of them sees: such nodes have no place in the group, for their equations would be empty. In space blocks that
  !> differ along x and y are one group, so that those that differ along the last axis have fewer functions apart.
  subroutine check_seen_nodes(tests)
    type(tests_type), intent(inout) :: tests
    type(sample_type) :: s
    type(integration_type) :: jagged
    integer :: dimension, degree, side, p, blocks

    do dimension = 2, 3
      do degree = 1, 3
        do side = 2, dimension
          call make_sample(dimension, degree, [0.5_wp, 0.6_wp, 0.7_wp], [2.6_wp, 2.1_wp, 2.2_wp], [9, 9, 7], s)
          do p = 1, s%points%count
            s%domains%low(:, p) = s%points%position(:, p) - 1.0e-3_wp
            s%domains%high(:, p) = s%points%position(:, p) + 1.0e-3_wp
            if (mod(p, 2) == 0) s%domains%low(1, p) = s%domains%low(1, p) - 0.3_wp
            if (mod(p, 2) == 1) s%domains%high(side, p) = s%domains%high(side, p) + 0.3_wp
          end do
          call integrate_at_points(s%mesh, s%space, s%activation, s%points, s%domains, jagged, .true.)
          call look_at_rows(tests, jagged)
          blocks = size(jagged%shape)
          call integrate_at_points(s%mesh, s%space, s%activation, s%points, s%domains, jagged)
          call look_at_rows(tests, jagged)
          if (side == dimension) call tests%check('grouped by blocks the points carry fewer functions', &
              size(jagged%shape) < blocks)
          call tests%check('and each point is there once', all(sorted(jagged%source) == [(p, p=1, s%points%count)]))
        end do
      end do
    end do
  end subroutine check_seen_nodes

  !> Every node of a group is seen, and the functions sum to one.
  subroutine look_at_rows(tests, jagged)
    type(tests_type), intent(inout) :: tests
    type(integration_type), intent(in) :: jagged
    integer :: g, n, q, a, place, unseen, fewest, most
    real(wp) :: worst, largest

    unseen = 0
    worst = 0.0_wp
    fewest = huge(1)
    most = 0
    do g = 1, jagged%group_count
      n = jagged%node_first(g + 1) - jagged%node_first(g)
      fewest = min(fewest, n)
      most = max(most, n)
      do a = 1, n
        largest = 0.0_wp
        do q = jagged%first(g), jagged%first(g + 1) - 1
          largest = max(largest, jagged%shape(place_of(jagged, g, q) + a))
        end do
        if (largest <= 0.0_wp) unseen = unseen + 1
      end do
      do q = jagged%first(g), jagged%first(g + 1) - 1
        place = place_of(jagged, g, q)
        worst = max(worst, abs(sum(jagged%shape(place + 1:place + n)) - 1.0_wp))
      end do
    end do
    call tests%check('every node of a group is seen by one of its points', unseen == 0 .and. fewest < most)
    call tests%close('the functions left still sum to one', worst, 0.0_wp, rounding)
    call tests%check('the node list ends with the last group', &
      size(jagged%nodes) == jagged%node_first(jagged%group_count + 1) - 1)
  end subroutine look_at_rows

  !> Numbers in rising order.
  pure function sorted(numbers) result(list)
    integer, intent(in) :: numbers(:)
    integer :: list(size(numbers))

    list = numbers
    call sort(list)
  end function sorted
end module test_integration
