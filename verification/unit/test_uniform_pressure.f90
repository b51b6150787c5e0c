!> Uniform cell pressure: stiffness against differences of the force, symmetry, the limits where it
!> must change nothing, the condition it enforces, and the volume it keeps.
!>
!> A group is made of pseudo-random gradients, volumes and start stresses; no mesh is behind it.
module test_uniform_pressure
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type
  use qsmpm_points, only: points_type
  use qsmpm_integration, only: integration_type, allocate_integration
  use qsmpm_assembly, only: evaluation_type, prepare_evaluation, evaluate
  use qsmpm_pressure_balance, only: pressure_type, allocate_pressure, search, packed_determinant
  use qsmpm_uniform_pressure, only: find_pressure
  use qsmpm_law, only: law_slot_type, law_type, batch_type, status_ok, tangent_consistent, tangent_elastic, &
    tangent_none
  use qsmpm_law_factory, only: new_law, kinematics_jaumann, kinematics_logarithmic, rate_midpoint
  use qsmpm_material_parameters, only: material_parameters_type
  use law_trials, only: elastic, make_law, random_batch
  use testing, only: tests_type
  implicit none
  private

  public :: collect_uniform_pressure

  character(len=*), parameter :: model_names(3) = [character(len=12) :: 'plane strain', 'axisymmetry', '3D']
  character(len=*), parameter :: soil_names(4) = [character(len=10) :: 'elastic', 'phi = 0', 'phi = psi', 'phi > psi']

contains

  !> All checks.
  subroutine collect_uniform_pressure(tests)
    type(tests_type), intent(inout) :: tests
    integer :: model, soil

    call tests%start('uniform_pressure')
    do model = 1, 3
      do soil = 1, 4
        call check_tangent(tests, model, soil, kinematics_logarithmic, .false., 'logarithmic')
        call check_tangent(tests, model, soil, kinematics_jaumann, .false., 'Jaumann')
        call check_tangent(tests, model, soil, kinematics_logarithmic, .true., 'logarithmic in place')
        call check_tangent(tests, model, soil, kinematics_jaumann, .true., 'Jaumann in place')
      end do
      call check_condition(tests, model)
      call check_limits(tests, model)
      call check_elastic_tangent(tests, model)
      call check_two_materials(tests, model)
    end do
    call check_one_point(tests)
    call check_search(tests)
    call check_resistance(tests)
    call check_failure(tests)
  end subroutine collect_uniform_pressure

  !> A soil of the list, nearly incompressible, in a slot with a pressure factor.
  subroutine make_slot(soil, dimension, kinematics, factor, slot)
    integer, intent(in) :: soil
    integer, intent(in) :: dimension
    integer, intent(in) :: kinematics
    real(wp), intent(in) :: factor
    type(law_slot_type), intent(out) :: slot
    type(material_parameters_type) :: p
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error

    p = elastic(100.0_wp, 0.495_wp)
    p%mohr_coulomb = soil > 1
    p%cohesion = 1.0_wp
    if (soil > 2) p%friction_angle = 25.0_wp
    if (soil == 3) p%dilatancy_angle = 25.0_wp
    if (soil == 4) p%dilatancy_angle = 5.0_wp
    call new_law(p, dimension, kinematics, rate_midpoint, law, error)
    allocate (slot%law, source=law)
    slot%pressure_factor = factor
    slot%flows = soil > 1
  end subroutine make_slot

  !> Pseudo-random number from -1 to 1 (Park and Miller).
  real(wp) function random(seed)
    integer(long), intent(inout) :: seed

    seed = modulo(48271_long*seed, 2147483647_long)
    random = 2.0_wp*real(seed, wp)/2147483647.0_wp - 1.0_wp
  end function random

  !> One group of some nodes and points, all of material 1.
  subroutine make_group(model, law, nodes, points, integration)
    !> 1 plane strain, 2 axisymmetry, 3 three dimensions.
    integer, intent(in) :: model
    class(law_type), intent(in) :: law
    integer, intent(in) :: nodes
    integer, intent(in) :: points
    type(integration_type), intent(out) :: integration
    integer(long) :: seed
    integer :: q, a, i

    seed = 815
    integration%axisymmetric = model == 2
    integration%group_count = 1
    integration%cell = [1]
    integration%first = [1, points + 1]
    integration%node_first = [1, nodes + 1]
    integration%nodes = [(a, a=1, nodes)]
    call allocate_integration(law%dimension, merge(4, 6, law%dimension == 2), law%state_count, points, .false., integration)
    integration%material = 1
    integration%volume_ratio = 1.1_wp
    do q = 1, points
      associate (gradient => integration%gradient(integration%directions*nodes*(q - 1) + 1:))
        do a = 1, nodes
          do i = 1, law%dimension
            gradient((i - 1)*nodes + a) = random(seed)
          end do
          if (integration%axisymmetric) gradient(2*nodes + a) = (1.0_wp/nodes + 0.1_wp*random(seed))/(2.0_wp + 0.1_wp*q)
        end do
      end associate
      integration%source(q) = -q
      integration%weight(q) = 1.0_wp + 0.5_wp*random(seed)
      do i = 1, size(integration%stress, 1)
        integration%stress(i, q) = 0.5_wp*random(seed)
      end do
      integration%stress(:3, q) = integration%stress(:3, q) - 2.0_wp
      call law%start(integration%stress(:, q), integration%state(:, q))
    end do
  end subroutine make_group

  !> Displacements of some size.
  subroutine make_displacement(size_of, start, u)
    real(wp), intent(in) :: size_of
    integer(long), intent(in) :: start
    real(wp), intent(out) :: u(:, :)
    integer(long) :: seed
    integer :: a, i

    seed = start
    do a = 1, size(u, 2)
      do i = 1, size(u, 1)
        u(i, a) = size_of*random(seed)
      end do
    end do
  end subroutine make_displacement

  !> Differences of the force in many directions, and the symmetry of the block.
  subroutine check_tangent(tests, model, soil, kinematics, in_place, law_name)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: model
    integer, intent(in) :: soil
    integer, intent(in) :: kinematics
    !> At small strain, under an all-round pressure.
    logical, intent(in) :: in_place
    character(len=*), intent(in) :: law_name
    type(points_type) :: none
    type(integration_type) :: integration
    type(evaluation_type) :: evaluation
    type(law_slot_type) :: laws(1)
    character(len=:), allocatable :: name
    real(wp), allocatable :: u(:, :), block(:, :)
    real(wp) :: error
    integer(long) :: seed
    integer :: d, n, compared, plastic

    d = merge(3, 2, model == 3)
    n = merge(8, 4, d == 3)
    name = trim(model_names(model))//', '//trim(soil_names(soil))//', '//law_name
    call make_slot(soil, d, kinematics, 1.0_wp, laws(1))
    if (in_place) laws(1)%confinement = 3.0_wp
    evaluation%step_info%in_place = in_place
    evaluation%lasting = .true.
    call make_group(model, laws(1)%law, n, 7, integration)
    allocate (u(d, n))
    seed = merge(33_long, 21_long, model == 1)
    if (.not. in_place) seed = merge(99_long, 99_long, model == 2)
    call make_displacement(merge(0.04_wp, 0.03_wp, in_place), seed, u)
    call prepare_evaluation(integration, d, n, .true., .true., evaluation)
    call evaluate(integration, none, laws, u, tangent_consistent, evaluation)
    call tests%check(name//': the group finds its pressure', evaluation%ok)
    if (.not. evaluation%ok) return
    plastic = sum(evaluation%results%plastic)
    allocate (block, source=reshape(reshape(evaluation%block(:(d*n)**2, 1), [d, n, d, n], order=[2, 1, 3, 4]), &
      [d*n, d*n]))
    call compare_differences(integration, laws, u, block, evaluation, error, compared)
    ! Differences of fourth order with step 8e-5: the balance of the group is exact to 5e-14 of k, 2e-12 of the force; the noise is 5e-8 then.
    call tests%close(name//': stiffness is the derivative of the force', error, 0.0_wp, 1.0e-7_wp)
    call tests%check(name//': most directions cross no corner of the yield surface', compared > 10)
    if (soil > 1) call tests%check(name//': points yield', plastic >= 3)
    error = maxval(abs(block - transpose(block)))/maxval(abs(block))
    if (laws(1)%is_symmetric() .and. .not. in_place) then
      call tests%close(name//': symmetric with the law', error, 0.0_wp, 1.0e-13_wp)
    else if (soil == 4) then
      call tests%check(name//': unsymmetric with the law', error > 1.0e-4_wp)
    end if
  end subroutine check_tangent

  !> Largest error in twenty directions, those left out in which the force has a corner: there second differences beside
  !> each other differ by the step, elsewhere by its cube.
  subroutine compare_differences(integration, laws, u, block, evaluation, error, compared)
    type(integration_type), intent(in) :: integration
    type(law_slot_type), intent(in) :: laws(:)
    real(wp), intent(in) :: u(:, :)
    real(wp), intent(in) :: block(:, :)
    type(evaluation_type), intent(inout) :: evaluation
    real(wp), intent(out) :: error
    integer, intent(out) :: compared
    type(points_type) :: none
    real(wp), parameter :: step = 8.0e-5_wp, corner = 1.0e-8_wp
    real(wp), dimension(size(u, 1), size(u, 2)) :: direction, linear, slope
    real(wp) :: force(size(u, 1), size(u, 2), -2:2), second(size(u, 1), size(u, 2), -1:1), scale
    integer :: k, i

    error = 0.0_wp
    compared = 0
    do k = 1, 20
      call make_displacement(1.0_wp, 1000_long + k, direction)
      linear = reshape(matmul(block, reshape(direction, [size(direction)])), shape(direction))
      scale = norm2(linear)
      do i = -2, 2
        call evaluate(integration, none, laws, u + i*step*direction, tangent_none, evaluation)
        force(:, :, i) = evaluation%force
      end do
      second = force(:, :, 0:) - 2.0_wp*force(:, :, -1:1) + force(:, :, :0)
      if (max(norm2(second(:, :, 1) - second(:, :, 0)), norm2(second(:, :, -1) - second(:, :, 0))) > corner*scale) cycle
      compared = compared + 1
      slope = (8.0_wp*(force(:, :, 1) - force(:, :, -1)) - force(:, :, 2) + force(:, :, -2))/(12.0_wp*step)
      error = max(error, norm2(slope - linear)/scale)
    end do
  end subroutine compare_differences

  !> The law's results of a group, without stiffness.
  subroutine update(integration, laws, u, evaluation)
    type(integration_type), intent(in) :: integration
    type(law_slot_type), intent(in) :: laws(:)
    real(wp), intent(in) :: u(:, :)
    type(evaluation_type), intent(out) :: evaluation
    type(points_type) :: none

    call prepare_evaluation(integration, size(u, 1), size(u, 2), .true., .true., evaluation)
    evaluation%pressure_offset = offsets(integration%point_count)
    evaluation%lasting = .true.
    call evaluate(integration, none, laws, u, tangent_consistent, evaluation)
  end subroutine update

  !> What the pressures of the points differ by for their weight, at the start and the end of the step.
  pure function offsets(n) result(offset)
    integer, intent(in) :: n
    real(wp) :: offset(n, 2)
    integer :: q

    offset(:, 1) = [(0.4_wp*cos(2.0_wp*q), q=1, n)]
    offset(:, 2) = [(0.5_wp*sin(2.0_wp*q), q=1, n)]
  end function offsets

  !> From the results alone: mean stresses plus c omega differ by what they did at the start and by the change of the
  !> offsets alone, and sum V omega = 0. Without displacement and change stresses stay as they are.
  subroutine check_condition(tests, model)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: model
    type(integration_type) :: integration
    type(points_type) :: none
    type(evaluation_type) :: treated, plain
    type(law_slot_type) :: laws(1)
    real(wp), allocatable :: u(:, :)
    real(wp) :: m(3), pressure(7), omega(7), offset(7, 2), c
    integer :: d, n

    d = merge(3, 2, model == 3)
    n = merge(8, 4, d == 3)
    m = 1.0_wp/3.0_wp
    if (model == 1) m = [0.5_wp, 0.5_wp, 0.0_wp]
    call make_slot(4, d, kinematics_logarithmic, 0.1_wp, laws(1))
    laws(1)%flows = .false.
    call make_group(model, laws(1)%law, n, 7, integration)
    allocate (u(d, n))
    call make_displacement(0.02_wp, 99_long, u)
    call update(integration, laws, u, treated)
    laws(1)%pressure_factor = 0.0_wp
    call update(integration, laws, u, plain)
    omega = log(treated%results%volume_change/plain%results%volume_change)
    c = 0.1_wp*100.0_wp/(2.0_wp*1.495_wp)
    offset = offsets(7)
    pressure = treated%results%volume_change*matmul(m, treated%results%stress(:3, :)) + c*omega - offset(:, 2) &
      - (matmul(m, integration%stress(:3, :)) - offset(:, 1))
    call tests%check(trim(model_names(model))//': the cure changes the volumes', maxval(abs(omega)) > 1.0e-3_wp)
    ! Bulk modulus 3333: a volume change is known to 1e-16, a pressure to some 1e-13 of the modulus.
    call tests%close(trim(model_names(model))//': one pressure in the group', &
      maxval(pressure) - minval(pressure), 0.0_wp, 1.0e-9_wp)
    call tests%close(trim(model_names(model))//': the logarithmic volume of the group is kept', &
      sum(integration%weight*omega), 0.0_wp, 1.0e-14_wp)
    treated%pressure_offset(:, 2) = offset(:, 1)
    integration%volume_ratio = 1.0_wp
    laws(1)%pressure_factor = 0.1_wp
    call evaluate(integration, none, laws, 0.0_wp*u, tangent_none, treated)
    call tests%close(trim(model_names(model))//': a step that does nothing leaves pressures that differ', &
      maxval(abs(treated%results%stress - integration%stress)), 0.0_wp, 1.0e-11_wp)
    treated%lasting = .false.
    call evaluate(integration, none, laws, 0.0_wp*u, tangent_none, treated)
    call tests%check(trim(model_names(model))//': but where points go from cell to cell', &
      maxval(abs(treated%results%stress - integration%stress)) > 0.1_wp)
  end subroutine check_condition

  !> Large factors lead to no cure, in proportion to their inverse.
  subroutine check_limits(tests, model)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: model
    type(integration_type) :: integration
    type(evaluation_type) :: treated, plain
    type(law_slot_type) :: laws(1)
    real(wp), allocatable :: u(:, :)
    real(wp) :: force(3), block(3)
    integer :: d, n, k

    d = merge(3, 2, model == 3)
    n = merge(8, 4, d == 3)
    call make_slot(1, d, kinematics_logarithmic, 0.0_wp, laws(1))
    call make_group(model, laws(1)%law, n, 7, integration)
    allocate (u(d, n))
    call make_displacement(0.02_wp, 99_long, u)
    call update(integration, laws, u, plain)
    do k = 1, 3
      laws(1)%pressure_factor = 1.0e4_wp*100.0_wp**(k - 1)
      call update(integration, laws, u, treated)
      force(k) = norm2(treated%force - plain%force)/norm2(plain%force)
      block(k) = norm2(treated%block - plain%block)/norm2(plain%block)
    end do
    ! Differences of first order in 1/c: a hundredth for a hundred times the factor.
    call tests%close(trim(model_names(model))//': a large factor is no cure, force', force(3)/force(2), 0.01_wp, &
      1.0e-4_wp)
    call tests%close(trim(model_names(model))//': a large factor is no cure, stiffness', block(3)/block(2), &
      0.01_wp, 1.0e-4_wp)
    call tests%check(trim(model_names(model))//': the limit is near', force(3) < 1.0e-5_wp .and. block(3) < 1.0e-5_wp)
  end subroutine check_limits

  !> The elastic tangent of a modified Newton method: symmetric, with the forces of the consistent one;
  !> in elasticity the same as the consistent one.
  subroutine check_elastic_tangent(tests, model)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: model
    type(points_type) :: none
    type(integration_type) :: integration
    type(evaluation_type) :: consistent, frozen
    type(law_slot_type) :: laws(1)
    real(wp), allocatable :: u(:, :), block(:, :)
    integer :: d, n, soil

    d = merge(3, 2, model == 3)
    n = merge(8, 4, d == 3)
    allocate (u(d, n))
    call make_displacement(0.02_wp, 99_long, u)
    do soil = 1, 4, 3
      call make_slot(soil, d, kinematics_logarithmic, 0.1_wp, laws(1))
      call make_group(model, laws(1)%law, n, 7, integration)
      call update(integration, laws, u, consistent)
      call prepare_evaluation(integration, d, n, .true., .true., frozen)
      frozen%pressure_offset = offsets(integration%point_count)
      frozen%lasting = .true.
      call evaluate(integration, none, laws, u, tangent_elastic, frozen)
      call tests%close(trim(model_names(model))//', '//trim(soil_names(soil))//': force with the elastic tangent', &
        norm2(frozen%force - consistent%force)/norm2(consistent%force), 0.0_wp, 1.0e-13_wp)
      if (soil == 1) call tests%close(trim(model_names(model))//': elastic tangent is that of elasticity', &
        norm2(frozen%block - consistent%block)/norm2(consistent%block), 0.0_wp, 1.0e-12_wp)
    end do
    allocate (block, source=reshape(reshape(frozen%block(:(d*n)**2, 1), [d, n, d, n], order=[2, 1, 3, 4]), &
      [d*n, d*n]))
    call tests%close(trim(model_names(model))//': elastic tangent of phi > psi is symmetric', &
      maxval(abs(block - transpose(block)))/maxval(abs(block)), 0.0_wp, 1.0e-13_wp)
  end subroutine check_elastic_tangent

  !> Points 1 to 3 have a material without a cure; they know nothing of the others, nor these of them.
  subroutine check_two_materials(tests, model)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: model
    type(integration_type) :: integration
    type(evaluation_type) :: both, plain
    type(law_slot_type) :: laws(2)
    real(wp), allocatable :: u(:, :), jumps(:)
    integer :: d, n

    d = merge(3, 2, model == 3)
    n = merge(8, 4, d == 3)
    call make_slot(2, d, kinematics_logarithmic, 0.1_wp, laws(1))
    call make_slot(4, d, kinematics_logarithmic, 0.0_wp, laws(2))
    call make_group(model, laws(1)%law, n, 7, integration)
    integration%material = [2, 2, 2, 1, 1, 1, 1]
    allocate (u(d, n))
    call make_displacement(0.02_wp, 99_long, u)
    call update(integration, laws, u, both)
    laws(1)%pressure_factor = 0.0_wp
    call update(integration, laws, u, plain)
    allocate (jumps, source=log(both%results%volume_change/plain%results%volume_change))
    call tests%check(trim(model_names(model))//': points without a cure are left alone', &
      all(abs(both%results%stress(:, :3) - plain%results%stress(:, :3)) <= 0.0_wp) .and. all(abs(jumps(:3)) <= 0.0_wp))
    call tests%close(trim(model_names(model))//': points with a cure keep their volume among them', &
      sum(integration%weight(4:)*jumps(4:)), 0.0_wp, 1.0e-14_wp)
    call tests%check(trim(model_names(model))//': points with a cure share it', all(abs(jumps(4:)) > 1.0e-6_wp))
  end subroutine check_two_materials

  !> A group of one point has no extra volume change and the stress and tangent of the law.
  subroutine check_one_point(tests)
    type(tests_type), intent(inout) :: tests
    type(law_slot_type) :: slot
    type(batch_type) :: batch, plain
    type(pressure_type) :: pressure

    call make_law(elastic(100.0_wp, 0.49_wp), 3, kinematics_logarithmic, rate_midpoint, slot%law)
    call random_batch(slot%law, 1, 0.03_wp, 1.0_wp, batch)
    plain = batch
    call slot%law%update(plain, tangent_consistent)
    call allocate_pressure(9, 1, 3, .true., pressure)
    slot%pressure_factor = 0.1_wp
    call find_pressure(slot, [0.7_wp], tangent_consistent, batch, pressure)
    ! Rounding of a weighted mean of one value, times the bulk modulus of 1667.
    call tests%close('one point: no extra volume change', pressure%omega(1), 0.0_wp, 1.0e-16_wp)
    call tests%close('one point: the stress of the law', maxval(abs(batch%piola - plain%piola)), 0.0_wp, 1.0e-12_wp)
    call tests%check('one point: one call of the law', pressure%passes == 1)
    ! A - r l^T/k + r l^T/k
    call tests%close('one point: the tangent of the law', maxval(abs(batch%tangent(:, :, 1) &
      + spread(pressure%right(:, 1), 2, 9)*spread(pressure%left(:, 1), 1, 9)/pressure%stiffness(1) &
      - plain%tangent(:, :, 1))), 0.0_wp, 1.0e-10_wp)
  end subroutine check_one_point

  !> The search finds what Newton's method finds, and takes over where corners defeat that.
  subroutine check_search(tests)
    type(tests_type), intent(inout) :: tests
    type(law_slot_type) :: slot
    type(batch_type) :: batch
    type(pressure_type) :: pressure
    real(wp), parameter :: weight(9) = [0.5_wp, 1.0_wp, 1.5_wp, 0.7_wp, 0.9_wp, 1.1_wp, 1.3_wp, 1.0_wp, 2.0_wp]
    real(wp) :: omega(9)
    integer :: soil
    logical :: found

    do soil = 1, 4
      call make_slot(soil, 3, kinematics_logarithmic, 0.1_wp, slot)
      call random_batch(slot%law, 9, 0.03_wp, 1.0_wp, batch)
      call allocate_pressure(9, 9, 3, .true., pressure)
      call find_pressure(slot, weight, tangent_none, batch, pressure)
      omega = pressure%omega
      if (soil == 1) call tests%check('elasticity takes few calls of the law', pressure%passes <= 3)
      batch%gradient = pressure%gradient
      call search(slot, weight, batch, pressure, found)
      call tests%check(trim(soil_names(soil))//': the search finds a pressure', found)
      call tests%close(trim(soil_names(soil))//': the search keeps the volume', sum(weight*pressure%omega), 0.0_wp, &
        1.0e-12_wp)
      ! 5e-14 of k, with k at most the bulk modulus of 3333.
      call tests%close(trim(soil_names(soil))//': the search makes one pressure', maxval(pressure%pressure) &
        - minval(pressure%pressure), 0.0_wp, 1.0e-9_wp)
      call tests%close(trim(soil_names(soil))//': both ways lead to one state', maxval(abs(pressure%omega - omega)), &
        0.0_wp, 1.0e-11_wp)
      if (soil == 1) call tests%check('elasticity takes few calls of the law in a search too', pressure%passes <= 6)
    end do
  end subroutine check_search

  !> Of soil that flows the resistance to volume changes falls as the strain of the step grows: c = 0.1 G/(1 + G g/t) in
  !> simple shear g under a shear stress t, so that in flow the pressures it allows do not depend on the step.
  subroutine check_resistance(tests)
    type(tests_type), intent(inout) :: tests
    type(law_slot_type) :: slot
    type(batch_type) :: batch
    type(pressure_type) :: pressure
    real(wp), parameter :: shear(3) = [1.0e-4_wp, 1.0e-3_wp, 1.0e-2_wp], weight(3) = [1.0_wp, 2.0_wp, 0.5_wp], stress = 0.9_wp
    real(wp) :: g
    integer :: i

    call make_slot(2, 2, kinematics_jaumann, 0.1_wp, slot)
    call random_batch(slot%law, 3, 0.01_wp, 1.0_wp, batch)
    call allocate_pressure(5, 3, 2, .false., pressure)
    g = slot%law%shear_scale
    pressure%lasting = .true.
    do i = 1, size(shear)
      batch%gradient(:, :3) = spread([1.0_wp, 0.0_wp, shear(i), 1.0_wp, 1.0_wp], 2, 3)
      batch%stress_start(:, :3) = spread([0.0_wp, 0.0_wp, 0.0_wp, stress], 2, 3)
      call find_pressure(slot, weight, tangent_none, batch, pressure)
      call tests%close('resistance of soil that flows', pressure%resistance*(1.0_wp + g*shear(i)/stress)/(0.1_wp*g), &
        1.0_wp, 1.0e-4_wp)
      call tests%close('share of pressures that differed before', pressure%left_share*(1.0_wp + g*shear(i)/stress), 1.0_wp, &
        1.0e-4_wp)
    end do
    slot%flows = .false.
    call find_pressure(slot, weight, tangent_none, batch, pressure)
    call tests%close('resistance of soil that does not', pressure%resistance, 0.1_wp*g, 1.0e-15_wp*g)
    call tests%check('elastic soil under one pressure has a symmetric tangent, soil that flows has not', &
      slot%is_symmetric() .eqv. slot%law%symmetric)
    slot%flows = .true.
    call tests%check('that of soil that flows is not', .not. slot%is_symmetric())
  end subroutine check_resistance

  !> A point turned inside out fails its group and no number comes out wrong.
  subroutine check_failure(tests)
    type(tests_type), intent(inout) :: tests
    type(law_slot_type) :: slot
    type(batch_type) :: batch
    type(pressure_type) :: pressure

    call make_law(elastic(100.0_wp, 0.49_wp), 2, kinematics_logarithmic, rate_midpoint, slot%law)
    call random_batch(slot%law, 3, 0.03_wp, 1.0_wp, batch)
    call allocate_pressure(5, 3, 2, .false., pressure)
    batch%gradient(1, 2) = -1.0_wp
    call tests%check('the second point is turned inside out', packed_determinant(batch%gradient(:, 2)) < 0.0_wp)
    call find_pressure(slot, [1.0_wp, 1.0_wp, 1.0_wp], tangent_consistent, batch, pressure)
    call tests%check('a point inside out fails the group', all(batch%status /= status_ok))
  end subroutine check_failure
end module test_uniform_pressure
