!> Return mapping in principal stresses: admissible, idempotent, equal to a brute-force search over
!> all sets of active planes, tangent by differences; closed-form corners.
module test_mohr_coulomb
  use qsmpm_kinds, only: wp, pi, long
  use qsmpm_error, only: error_type
  use qsmpm_material_parameters, only: material_parameters_type, check_parameters
  use qsmpm_mohr_coulomb_return, only: mohr_coulomb_type, make_mohr_coulomb, inside, return_outside
  use qsmpm_tensor, only: determinant, inverse, identity
  use testing, only: tests_type
  implicit none
  private

  public :: collect_mohr_coulomb

  integer, parameter :: plane_count = 9
  !> The strength written out as all nine planes.
  type :: planes_type
    integer :: count = 0
    real(wp) :: normal(3, plane_count), corrector(3, plane_count), limit(plane_count)
    real(wp) :: apex = huge(1.0_wp)
  end type planes_type

contains

  subroutine collect_mohr_coulomb(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('mohr_coulomb')
    call check_parameter_ranges(tests)
    call check_corners(tests)
    call check_material(tests, 'associated', 25.0_wp, 25.0_wp, 1.0_wp, 0.33_wp, -1.0_wp)
    call check_material(tests, 'psi = 0', 25.0_wp, 0.0_wp, 1.0_wp, 0.33_wp, -1.0_wp)
    call check_material(tests, 'psi = 10', 35.0_wp, 10.0_wp, 1.0_wp, 0.2_wp, -1.0_wp)
    call check_material(tests, 'c = 0', 30.0_wp, 5.0_wp, 0.0_wp, 0.3_wp, -1.0_wp)
    call check_material(tests, 'Tresca', 0.0_wp, 0.0_wp, 1.0_wp, 0.3_wp, -1.0_wp)
    call check_material(tests, 'Tresca, nu = 0.4999', 0.0_wp, 0.0_wp, 1.0_wp, 0.4999_wp, -1.0_wp)
    call check_material(tests, 'Tresca, cut-off', 0.0_wp, 0.0_wp, 1.0_wp, 0.495_wp, 0.3_wp)
    call check_material(tests, 'cut-off', 25.0_wp, 0.0_wp, 1.0_wp, 0.33_wp, 0.5_wp)
    call check_material(tests, 'no tension', 30.0_wp, 30.0_wp, 1.0_wp, 0.0_wp, 0.0_wp)
    call check_material(tests, 'psi = 5, cut-off', 40.0_wp, 5.0_wp, 2.0_wp, 0.25_wp, 1.0_wp)
  end subroutine collect_mohr_coulomb

  !> Parameters out of range are refused.
  subroutine check_parameter_ranges(tests)
    type(tests_type), intent(inout) :: tests
    type(material_parameters_type) :: p
    type(error_type), allocatable :: error

    p = material(25.0_wp, 30.0_wp, 1.0_wp, 0.3_wp, -1.0_wp)
    call check_parameters(p, error)
    call tests%check('a dilatancy angle above the friction angle is refused', allocated(error))
    p = material(0.0_wp, 0.0_wp, 0.0_wp, 0.3_wp, -1.0_wp)
    call check_parameters(p, error)
    call tests%check('a material without strength is refused', allocated(error))
    p = material(25.0_wp, 0.0_wp, 1.0_wp, 0.5_wp, -1.0_wp)
    call check_parameters(p, error)
    call tests%check('Poisson''s ratio of 0.5 is refused', allocated(error))
    p = material(25.0_wp, 0.0_wp, 1.0_wp, 0.4999_wp, -1.0_wp)
    call check_parameters(p, error)
    call tests%check('a sound material is accepted', .not. allocated(error))
  end subroutine check_parameter_ranges

  !> Apex c cot phi (2.14451 to the digits given, for c = 1 and phi = 25), corners of the cut-off
  !> and the triaxial strength 249.531 at 100 (printed to three digits).
  subroutine check_corners(tests)
    type(tests_type), intent(inout) :: tests
    type(mohr_coulomb_type) :: model
    real(wp) :: stress(3), tangent(3, 3)
    logical :: yields

    call make(material(25.0_wp, 0.0_wp, 1.0_wp, 0.33_wp, -1.0_wp), model)
    call return_principal(model, [50.0_wp, 60.0_wp, 55.0_wp], stress, tangent, yields)
    call tests%check('hydrostatic tension yields', yields)
    call tests%close('hydrostatic tension returns to the apex', &
      maxval(abs(stress - 2.14451_wp)), 0.0_wp, 5.0e-6_wp)
    call tests%close('the apex is c cot phi', stress(1), 1.0_wp/tan(25.0_wp*pi/180.0_wp), &
      1.0e-14_wp)
    call tests%close('the tangent at the apex is zero', maxval(abs(tangent)), 0.0_wp, 0.0_wp)
    call return_principal(model, [-100.0_wp, -100.0_wp, -249.5_wp], stress, tangent, yields)
    call tests%check('the triaxial strength is not reached at 249.5', .not. yields)
    call return_principal(model, [-100.0_wp, -249.535_wp, -100.0_wp], stress, tangent, yields)
    call tests%check('the triaxial strength is passed at 249.535', yields)
    call make(material(25.0_wp, 0.0_wp, 1.0_wp, 0.33_wp, 0.5_wp), model)
    call return_principal(model, [50.0_wp, 60.0_wp, 55.0_wp], stress, tangent, yields)
    call tests%close('with a cut-off hydrostatic tension returns to its corner', &
      maxval(abs(stress - 0.5_wp)), 0.0_wp, 1.0e-15_wp)
    call return_principal(model, [1.0_wp, -0.1_wp, -0.2_wp], stress, tangent, yields)
    call tests%close('the cut-off alone is associated: nu/(1 - nu) of the relief', &
      stress(2), -0.1_wp - 0.5_wp*0.33_wp/0.67_wp, 1.0e-14_wp)
  end subroutine check_corners

  !> All properties of a material over pseudo-random trial stresses.
  subroutine check_material(tests, name, phi, psi, cohesion, nu, cut_off)
    type(tests_type), intent(inout) :: tests
    !> Name for the messages.
    character(len=*), intent(in) :: name
    !> Angles in degrees.
    real(wp), intent(in) :: phi
    real(wp), intent(in) :: psi
    real(wp), intent(in) :: cohesion
    real(wp), intent(in) :: nu
    !> Negative: none.
    real(wp), intent(in) :: cut_off
    integer, parameter :: trials = 10000, searched = 1000
    type(material_parameters_type) :: p
    type(mohr_coulomb_type) :: model
    type(planes_type) :: planes
    real(wp) :: trial(3), stress(3), tangent(3, 3), again(3), slope(3, 3), scale
    real(wp) :: excess, change, gap, slope_error
    integer(long) :: seed
    integer :: i, found, plastic
    logical :: yields

    p = material(phi, psi, cohesion, nu, cut_off)
    call make(p, model)
    planes = all_planes(p)
    seed = 12345
    excess = 0.0_wp
    change = 0.0_wp
    gap = 0.0_wp
    slope_error = 0.0_wp
    found = 0
    plastic = 0
    do i = 1, trials
      call random_trial(seed, i, trial)
      call return_principal(model, trial, stress, tangent, yields)
      scale = maxval(abs(trial)) + 1.0_wp
      excess = max(excess, largest_excess(planes, stress)/scale)
      call return_principal(model, stress, again, slope, yields)
      change = max(change, maxval(abs(again - stress))/scale)
      if (i > searched) cycle
      plastic = plastic + 1
      call compare_search(planes, trial, stress, scale, gap, found)
      slope_error = max(slope_error, tangent_error(model, trial, tangent, scale))
    end do
    call tests%close(name//': the stress is admissible', max(excess, 0.0_wp), 0.0_wp, 1.0e-10_wp)
    call tests%close(name//': an admissible stress stays', change, 0.0_wp, 1.0e-10_wp)
    ! 1e-9: the search's own elimination at nu = 0.4999 has a condition number of 1e4.
    call tests%close(name//': the stress is that of the full search', gap, 0.0_wp, 1.0e-9_wp)
    call tests%check(name//': every trial was decided by the search', found == plastic)
    ! The return is piecewise linear: differences within a region err by round-off over the step.
    call tests%close(name//': the tangent agrees with differences', slope_error, 0.0_wp, 1.0e-7_wp)
  end subroutine check_material

  !> Compare with the search; count the trials that it decided.
  subroutine compare_search(planes, trial, stress, scale, gap, found)
    type(planes_type), intent(in) :: planes
    real(wp), intent(in) :: trial(3)
    !> Answer of the return mapping.
    real(wp), intent(in) :: stress(3)
    real(wp), intent(in) :: scale
    !> Largest distance so far.
    real(wp), intent(inout) :: gap
    integer, intent(inout) :: found
    real(wp) :: nearest

    nearest = search(planes, trial, stress, scale)
    if (nearest < 0.5_wp*huge(1.0_wp)) then
      gap = max(gap, nearest/scale)
      found = found + 1
    else if (planes%apex < 0.5_wp*huge(1.0_wp)) then
      ! No set of planes has non-negative multipliers: only beyond the apex without dilatancy.
      gap = max(gap, maxval(abs(stress - planes%apex))/scale)
      if (sum(trial)/3.0_wp >= planes%apex - 1.0e-9_wp*scale) found = found + 1
    end if
  end subroutine compare_search

  !> Farthest distance from a stress to the answers of all sets of up to three planes that have
  !> non-negative multipliers and an admissible stress; huge when there is none.
  real(wp) function search(planes, trial, stress, scale)
    type(planes_type), intent(in) :: planes
    real(wp), intent(in) :: trial(3)
    real(wp), intent(in) :: stress(3)
    real(wp), intent(in) :: scale
    integer :: i, j, k

    search = -1.0_wp
    if (largest_excess(planes, trial) <= 1.0e-12_wp*scale) search = maxval(abs(trial - stress))
    do i = 1, planes%count
      call try_planes(planes, [i], trial, stress, scale, search)
      do j = i + 1, planes%count
        call try_planes(planes, [i, j], trial, stress, scale, search)
        do k = j + 1, planes%count
          call try_planes(planes, [i, j, k], trial, stress, scale, search)
        end do
      end do
    end do
    if (search < 0.0_wp) search = huge(1.0_wp)
  end function search

  !> Add the answer of one set to the search, if it is one.
  subroutine try_planes(planes, set, trial, stress, scale, distance)
    type(planes_type), intent(in) :: planes
    integer, intent(in) :: set(:)
    real(wp), intent(in) :: trial(3)
    real(wp), intent(in) :: stress(3)
    real(wp), intent(in) :: scale
    real(wp), intent(inout) :: distance
    real(wp) :: system(3, 3), right(3), multipliers(3), answer(3), det
    integer :: i, j, n

    n = size(set)
    system = identity
    right = 0.0_wp
    do i = 1, n
      do j = 1, n
        system(i, j) = dot_product(planes%normal(:, set(i)), planes%corrector(:, set(j)))
      end do
      right(i) = dot_product(planes%normal(:, set(i)), trial) - planes%limit(set(i))
    end do
    det = determinant(system)
    if (abs(det) <= 1.0e-9_wp*maxval(abs(system))) return
    system = inverse(system, det)
    multipliers = matmul(system, right)
    if (any(multipliers(1:n) < -1.0e-11_wp*scale)) return
    answer = trial
    do i = 1, n
      answer = answer - multipliers(i)*planes%corrector(:, set(i))
    end do
    if (largest_excess(planes, answer) > 1.0e-11_wp*scale) return
    distance = max(distance, maxval(abs(answer - stress)))
  end subroutine try_planes

  !> Largest yield function of a stress.
  pure real(wp) function largest_excess(planes, stress)
    type(planes_type), intent(in) :: planes
    real(wp), intent(in) :: stress(3)
    integer :: i

    largest_excess = -huge(1.0_wp)
    do i = 1, planes%count
      largest_excess = max(largest_excess, &
        dot_product(planes%normal(:, i), stress) - planes%limit(i))
    end do
  end function largest_excess

  !> Error of the tangent against central differences; zero where the differences cross into
  !> another region, which shows in unequal forward and backward differences.
  real(wp) function tangent_error(model, trial, tangent, scale)
    type(mohr_coulomb_type), intent(in) :: model
    real(wp), intent(in) :: trial(3)
    real(wp), intent(in) :: tangent(3, 3)
    real(wp), intent(in) :: scale
    real(wp) :: here(3), up(3), down(3), slope(3, 3), h, moved(3)
    integer :: i
    logical :: yields

    tangent_error = 0.0_wp
    h = 1.0e-6_wp*scale
    call return_principal(model, trial, here, slope, yields)
    do i = 1, 3
      moved = trial
      moved(i) = trial(i) + h
      call return_principal(model, moved, up, slope, yields)
      moved(i) = trial(i) - h
      call return_principal(model, moved, down, slope, yields)
      if (maxval(abs(up + down - 2.0_wp*here)) > 1.0e-9_wp*h + 1.0e-13_wp*scale) cycle
      tangent_error = max(tangent_error, maxval(abs((up - down)/(2.0_wp*h) - tangent(:, i))))
    end do
  end function tangent_error

  !> A trial stress: sizes from 0.1 to 1000, means of either sign, equal values now and then.
  subroutine random_trial(seed, number, trial)
    integer(long), intent(inout) :: seed
    !> Number of the trial.
    integer, intent(in) :: number
    real(wp), intent(out) :: trial(3)
    real(wp) :: x(5)
    integer :: i

    do i = 1, 5
      seed = modulo(48271_long*seed, 2147483647_long)
      x(i) = real(seed, wp)/2147483647.0_wp
    end do
    trial = 10.0_wp**(4.0_wp*x(4) - 1.0_wp)*(2.0_wp*x(1:3) - 1.0_wp + 1.5_wp*(2.0_wp*x(5) - 1.0_wp))
    if (modulo(number, 7) == 0) trial(2) = trial(1)
    if (modulo(number, 11) == 0) trial(3) = trial(2)
  end subroutine random_trial

  !> The nine planes, or six without a cut-off.
  function all_planes(p) result(planes)
    type(material_parameters_type), intent(in) :: p
    type(planes_type) :: planes
    real(wp) :: k, m, lame, shear, flow(3)
    integer :: i, j

    k = tan(0.25_wp*pi + 0.5_wp*p%friction_angle*pi/180.0_wp)**2
    m = tan(0.25_wp*pi + 0.5_wp*p%dilatancy_angle*pi/180.0_wp)**2
    call moduli(p, lame, shear)
    do i = 1, 3
      do j = 1, 3
        if (i == j .and. p%tensile_strength > 1.0e30_wp) cycle
        planes%count = planes%count + 1
        associate (n => planes%count)
          planes%normal(:, n) = 0.0_wp
          flow = 0.0_wp
          planes%normal(j, n) = -1.0_wp
          flow(j) = -1.0_wp
          planes%normal(i, n) = merge(1.0_wp, k, i == j)
          flow(i) = merge(1.0_wp, m, i == j)
          planes%corrector(:, n) = (lame*sum(flow) + 2.0_wp*shear*flow)/(2.0_wp*shear)
          planes%limit(n) = merge(p%tensile_strength, 2.0_wp*p%cohesion*sqrt(k), i == j)
        end associate
      end do
    end do
    if (p%tensile_strength > 1.0e30_wp .and. p%friction_angle > 0.0_wp) &
      planes%apex = p%cohesion/tan(p%friction_angle*pi/180.0_wp)
  end function all_planes

  pure function material(phi, psi, cohesion, nu, cut_off) result(p)
    real(wp), intent(in) :: phi
    real(wp), intent(in) :: psi
    real(wp), intent(in) :: cohesion
    real(wp), intent(in) :: nu
    real(wp), intent(in) :: cut_off
    type(material_parameters_type) :: p

    p%young = 200.0_wp
    p%poisson = nu
    p%mohr_coulomb = .true.
    p%friction_angle = phi
    p%dilatancy_angle = psi
    p%cohesion = cohesion
    if (cut_off >= 0.0_wp) p%tensile_strength = cut_off
  end function material

  subroutine make(p, model)
    type(material_parameters_type), intent(in) :: p
    type(mohr_coulomb_type), intent(out) :: model
    real(wp) :: lame, shear

    call moduli(p, lame, shear)
    call make_mohr_coulomb(p, lame, shear, model)
  end subroutine make

  pure subroutine moduli(p, lame, shear)
    type(material_parameters_type), intent(in) :: p
    real(wp), intent(out) :: lame
    real(wp), intent(out) :: shear

    shear = 0.5_wp*p%young/(1.0_wp + p%poisson)
    lame = 2.0_wp*shear*p%poisson/(1.0_wp - 2.0_wp*p%poisson)
  end subroutine moduli

  !> Return a trial stress to the strength.
  pure subroutine return_principal(model, trial, stress, tangent, yields)
    !> Strength.
    type(mohr_coulomb_type), intent(in) :: model
    !> Principal trial stresses, in any order (3).
    real(wp), intent(in) :: trial(3)
    !> Principal stresses, in the same order (3).
    real(wp), intent(out) :: stress(3)
    !> d stress / d trial stress; times the elastic moduli it is d stress / d strain (3,3).
    real(wp), intent(out) :: tangent(3, 3)
    !> Whether the trial stress lay outside.
    logical, intent(out) :: yields

    yields = .not. inside(model, trial)
    stress = trial
    tangent = identity
    if (yields) call return_outside(model, trial, stress, tangent)
  end subroutine return_principal
end module test_mohr_coulomb
