!> Return mapping of Mohr-Coulomb plasticity with tension cut-off in principal stresses.
!>
!> Tension positive. The strength is bounded by the six planes k s_i - s_j <= sc, i /= j, with
!> k = (1 + sin phi)/(1 - sin phi) and sc = 2 c sqrt(k), and the three planes s_i <= T. The flow of a shear
!> plane is along m e_i - e_j, m = (1 + sin psi)/(1 - sin psi), that of a cut-off plane along its normal.
!> For an ordered trial stress s1 >= s2 >= s3 only ten sets of active planes can contain the solution:
!> two planes, four edges and four corners; the apex is an additional case. The solution of a set is affine
!> in the trial stress. `make_mohr_coulomb` therefore computes all of them once, and a return searches
!> the table for the set with non-negative multipliers and an admissible stress.
!>
!> The stress is returned to the apex of the cone at c cot phi when no other set is admissible, also for
!> psi = 0, where the flow is isochoric and no flow rule leads there (the limit psi -> 0). Elastic
!> moduli are constant. Strains, kinematics and tensors are left to the calling modules.
module qsmpm_mohr_coulomb_return
  use qsmpm_kinds, only: wp, pi
  use qsmpm_material_parameters, only: material_parameters_type
  use qsmpm_tensor, only: determinant, inverse, identity
  implicit none
  private

  public :: mohr_coulomb_type, active_planes_type, make_mohr_coulomb, set_strength, make_set, plane, inside, &
    falling_order, return_outside, stress_ratio

  !> Planes by number: shear 1-3, 2-3, 1-2, then cut-off of 1, 2, 3.
  integer, parameter, public :: set_count = 10
  !> Planes of each set, single planes first; unused entries are 0.
  integer, parameter, public :: set_planes(3, set_count) = reshape( &
    [1, 0, 0, 4, 0, 0, 1, 2, 0, 1, 3, 0, 1, 4, 0, 4, 5, 0, 1, 3, 4, 1, 4, 5, 1, 2, 4, 4, 5, 6], [3, set_count])

  !> Round-off admitted in yield functions and multipliers, relative to the trial stress.
  real(wp), parameter, public :: round_off = 1.0e-12_wp
  !> A set whose violation is below this is accepted when none passes: the trial is where two
  !> regions meet, and nu near 0.5 has amplified round-off.
  real(wp), parameter, public :: near_tolerance = 1.0e-9_wp

  !> Solution of one set: stress = slope trial + shift, multipliers = weights trial + offsets.
  type :: active_planes_type
    integer :: planes = 0
    real(wp) :: slope(3, 3) = 0.0_wp
    real(wp) :: shift(3) = 0.0_wp
    !> Rows are planes; multiplied by 2 G, so that they have the unit of stress.
    real(wp) :: weights(3, 3) = 0.0_wp
    real(wp) :: offsets(3) = 0.0_wp
  end type active_planes_type

  !> Strength parameters and the table of solutions.
  type :: mohr_coulomb_type
    !> Ratios k and m, uniaxial strength sc, cut-off T, apex c cot phi.
    real(wp) :: k = 1.0_wp
    real(wp) :: m = 1.0_wp
    real(wp) :: sc = 0.0_wp
    real(wp) :: cut_off = huge(1.0_wp)
    real(wp) :: apex = huge(1.0_wp)
    logical :: has_apex = .false.
    logical :: has_cut_off = .false.
    type(active_planes_type) :: sets(set_count)
  end type mohr_coulomb_type

contains

  !> Computes strength and table of solutions from checked parameters.
  pure subroutine make_mohr_coulomb(parameters, lame, shear, model)
    type(material_parameters_type), intent(in) :: parameters
    !> Lame's first modulus; shear modulus.
    real(wp), intent(in) :: lame, shear
    !> Strength and table.
    type(mohr_coulomb_type), intent(out) :: model
    integer :: i

    call set_strength(parameters, model)
    do i = 1, set_count
      if (any(set_planes(:, i) > 3) .and. .not. model%has_cut_off) cycle
      call make_set(model, set_planes(:, i), lame, shear, model%sets(i))
    end do
  end subroutine make_mohr_coulomb

  !> Sets the strength from checked parameters; the table is not changed.
  pure subroutine set_strength(parameters, model)
    type(material_parameters_type), intent(in) :: parameters
    !> Strength.
    type(mohr_coulomb_type), intent(inout) :: model

    model%k = stress_ratio(parameters%friction_angle)
    model%m = stress_ratio(parameters%dilatancy_angle)
    model%sc = 2.0_wp*parameters%cohesion*sqrt(model%k)
    model%has_apex = parameters%friction_angle > 0.0_wp
    model%apex = huge(1.0_wp)
    if (model%has_apex) model%apex = parameters%cohesion/tan(parameters%friction_angle*pi/180.0_wp)
    ! A cut-off beyond the apex has no effect; one at the apex is the apex.
    model%has_cut_off = parameters%tensile_strength < sqrt(huge(1.0_wp)) &
      .and. parameters%tensile_strength < model%apex*(1.0_wp - round_off)
    if (model%has_cut_off) model%has_apex = .false.
    if (model%has_cut_off) model%cut_off = parameters%tensile_strength
  end subroutine set_strength

  !> Ratio of principal stresses (1 + sin angle)/(1 - sin angle).
  pure real(wp) function stress_ratio(angle)
    !> Degrees.
    real(wp), intent(in) :: angle

    stress_ratio = (1.0_wp + sin(angle*pi/180.0_wp))/(1.0_wp - sin(angle*pi/180.0_wp))
  end function stress_ratio

  !> Returns normal, flow direction and limit of a plane.
  pure subroutine plane(model, number, normal, flow, limit)
    !> Strength.
    type(mohr_coulomb_type), intent(in) :: model
    !> Number of the plane, 1 to 6.
    integer, intent(in) :: number
    !> Normal in stress space (3); direction of plastic strain (3); largest value of normal . stress.
    real(wp), intent(out) :: normal(3), flow(3), limit
    integer, parameter :: high(3) = [1, 2, 1], low(3) = [3, 3, 2]

    normal = 0.0_wp
    flow = 0.0_wp
    if (number <= 3) then
      normal(high(number)) = model%k
      normal(low(number)) = -1.0_wp
      flow(high(number)) = model%m
      flow(low(number)) = -1.0_wp
      limit = model%sc
    else
      normal(number - 3) = 1.0_wp
      flow(number - 3) = 1.0_wp
      limit = model%cut_off
    end if
  end subroutine plane

  !> Computes the solution of a set of planes: with normals N, flows M and limits c the multipliers
  !> are (N^T D M)^-1 (N^T s - c), and the stress is s - D M times the multipliers.
  pure subroutine make_set(model, planes, lame, shear, set)
    !> Strength.
    type(mohr_coulomb_type), intent(in) :: model
    !> Numbers of the planes, 0 where there is none (3).
    integer, intent(in) :: planes(3)
    !> Lame's first modulus; shear modulus.
    real(wp), intent(in) :: lame, shear
    !> The solution.
    type(active_planes_type), intent(out) :: set
    real(wp) :: normals(3, 3), corrector(3, 3), limits(3), flow(3), system(3, 3), solver(3, 3)
    integer :: i, n

    normals = 0.0_wp
    corrector = 0.0_wp
    limits = 0.0_wp
    system = identity
    n = count(planes > 0)
    do i = 1, n
      call plane(model, planes(i), normals(:, i), flow, limits(i))
      corrector(:, i) = 2.0_wp*shear*flow + lame*sum(flow)
    end do
    system(1:n, 1:n) = matmul(transpose(normals(:, 1:n)), corrector(:, 1:n))/(2.0_wp*shear)
    solver = inverse(system, determinant(system))
    set%planes = n
    set%weights(1:n, :) = matmul(solver(1:n, 1:n), transpose(normals(:, 1:n)))
    set%offsets(1:n) = -matmul(solver(1:n, 1:n), limits(1:n))
    if (n == 3) then
      ! At a corner the stress is the intersection of the planes for any trial.
      set%shift = matmul(transpose(inverse(normals, determinant(normals))), limits)
    else
      corrector = corrector/(2.0_wp*shear)
      set%slope = identity - matmul(corrector, set%weights)
      set%shift = -matmul(corrector, set%offsets)
    end if
  end subroutine make_set

  !> Violation of the strength by a stress (a stress; negative inside).
  pure real(wp) function excess(model, stress)
    !> Strength.
    type(mohr_coulomb_type), intent(in) :: model
    !> Principal stresses in any order (3).
    real(wp), intent(in) :: stress(3)
    real(wp) :: largest

    largest = max(stress(1), stress(2), stress(3))
    excess = model%k*largest - min(stress(1), stress(2), stress(3)) - model%sc
    if (model%has_cut_off) excess = max(excess, largest - model%cut_off)
  end function excess

  !> Magnitude of the stresses, for round-off.
  pure real(wp) function size_of(model, stress)
    !> Strength.
    type(mohr_coulomb_type), intent(in) :: model
    !> Principal stresses in any order (3).
    real(wp), intent(in) :: stress(3)

    size_of = max(abs(stress(1)), abs(stress(2)), abs(stress(3))) + model%sc
  end function size_of

  !> Whether a stress is inside the strength or, within round-off, on its surface.
  pure logical function inside(model, stress)
    !> Strength.
    type(mohr_coulomb_type), intent(in) :: model
    !> Principal stresses in any order (3).
    real(wp), intent(in) :: stress(3)

    inside = .not. excess(model, stress) > round_off*size_of(model, stress)
  end function inside

  !> Returns a trial stress that is outside the strength.
  pure subroutine return_outside(model, trial, stress, tangent)
    !> Strength.
    type(mohr_coulomb_type), intent(in) :: model
    !> Principal trial stresses, in any order (3).
    real(wp), intent(in) :: trial(3)
    !> Principal stresses, in the same order (3).
    real(wp), intent(out) :: stress(3)
    !> d stress / d trial stress; times the elastic moduli it is d stress / d strain (3,3).
    real(wp), intent(out) :: tangent(3, 3)
    real(wp) :: sorted(3), answer(3), slope(3, 3)
    integer :: order(3), i

    order = falling_order(trial)
    sorted = trial(order)
    call find_set(model, sorted, size_of(model, trial), answer, slope)
    do i = 1, 3
      stress(order(i)) = answer(i)
      tangent(order, order(i)) = slope(:, i)
    end do
  end subroutine return_outside

  !> Positions of the largest, middle and smallest value.
  pure function falling_order(values) result(order)
    !> Values (3).
    real(wp), intent(in) :: values(3)
    integer :: order(3)

    order = [1, 2, 3]
    if (values(1) < values(2)) order(1:2) = [2, 1]
    if (values(order(2)) < values(3)) order(2:3) = [3, order(2)]
    if (values(order(1)) < values(order(2))) order(1:2) = order(2:1:-1)
  end function falling_order

  !> Finds the set of active planes of an ordered trial stress that is outside the strength.
  pure subroutine find_set(model, trial, scale, stress, slope)
    !> Strength.
    type(mohr_coulomb_type), intent(in) :: model
    !> Principal trial stresses in descending order (3).
    real(wp), intent(in) :: trial(3)
    !> Magnitude of the stresses, for round-off.
    real(wp), intent(in) :: scale
    !> Principal stresses (3); d stress / d trial stress (3,3).
    real(wp), intent(out) :: stress(3), slope(3, 3)
    real(wp) :: candidate(3), miss, least
    integer :: i, best

    least = huge(1.0_wp)
    best = 0
    do i = 1, set_count
      if (model%sets(i)%planes == 0) cycle
      call try_set(model, model%sets(i), trial, candidate, miss)
      if (miss >= least) cycle
      least = miss
      best = i
      stress = candidate
      if (miss <= round_off*scale) exit
    end do
    if (best == 0 .or. (model%has_apex .and. least > near_tolerance*scale)) then
      stress = model%apex
      slope = 0.0_wp
    else
      slope = model%sets(best)%slope
    end if
  end subroutine find_set

  !> Computes the stress of a set and its violation (inadmissible stress or negative multiplier).
  pure subroutine try_set(model, set, trial, stress, miss)
    !> Strength.
    type(mohr_coulomb_type), intent(in) :: model
    !> Set of planes.
    type(active_planes_type), intent(in) :: set
    !> Principal trial stresses in descending order (3).
    real(wp), intent(in) :: trial(3)
    !> Stress of the set (3).
    real(wp), intent(out) :: stress(3)
    !> Largest violation, as a stress; <= 0 for the correct set.
    real(wp), intent(out) :: miss
    integer :: i

    stress = matmul(set%slope, trial) + set%shift
    miss = excess(model, stress)
    do i = 1, set%planes
      miss = max(miss, -dot_product(set%weights(i, :), trial) - set%offsets(i))
    end do
  end subroutine try_set
end module qsmpm_mohr_coulomb_return
