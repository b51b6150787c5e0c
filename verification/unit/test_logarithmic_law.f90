!> Logarithmic law: exact paths, tangents by differences, symmetry, start and fields, refusal.
module test_logarithmic_law
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_is_finite
  use point_trials, only: step_point
  use law_trials, only: elastic, strong, make_law, make_batch, random_batch, plane_batch, compare_plane, &
    difference_error
  use qsmpm_kinds, only: wp, pi
  use qsmpm_error, only: error_type
  use qsmpm_law, only: law_type, batch_type, status_ok, status_cut, status_failed, tangent_consistent, &
    tangent_elastic
  use qsmpm_law_factory, only: kinematics_logarithmic, rate_midpoint
  use qsmpm_material_parameters, only: material_parameters_type
  use qsmpm_point_driver, only: point_type, start_point
  use qsmpm_isotropic_function, only: compose
  use qsmpm_spectral, only: jacobi_spectral
  use qsmpm_tensor, only: determinant, unpack_gradient, unpack_symmetric
  use testing, only: tests_type
  implicit none
  private

  public :: collect_logarithmic_law

contains

  subroutine collect_logarithmic_law(tests)
    type(tests_type), intent(inout) :: tests
    integer :: d

    call tests%start('logarithmic_law')
    call check_oedometer(tests)
    call check_simple_shear(tests)
    call check_rigid_turn(tests)
    do d = 2, 3
      call check_tangent(tests, 'elastic', elastic(200.0_wp, 0.33_wp), d, .true.)
      call check_tangent(tests, 'nu = 0.4999', elastic(200.0_wp, 0.4999_wp), d, .true.)
      call check_tangent(tests, 'psi = phi', strong(25.0_wp, -1.0_wp), d, .true.)
      call check_tangent(tests, 'psi = 0', strong(0.0_wp, -1.0_wp), d, .false.)
      call check_tangent(tests, 'cut-off', strong(5.0_wp, 0.5_wp), d, .false.)
    end do
    call check_blend(tests)
    call check_equal_values(tests)
    call check_near_plane_values(tests)
    call check_large_strains(tests)
    call check_extreme_ratio(tests)
    call check_plane(tests)
    call check_start_and_fields(tests)
    call check_refusal(tests)
  end subroutine collect_logarithmic_law

  !> Confined compression: sigma = M ln(lambda)/lambda, exact for any number of steps; at nu = 0
  !> and lambda = 0.1 that is -23.0259 E. Tolerance: roundings of 40 steps.
  subroutine check_oedometer(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: lambda, next
    integer :: i, j

    call make_law(elastic(1.0_wp, 0.0_wp), 3, kinematics_logarithmic, rate_midpoint, law)
    call start_point(law, [(0.0_wp, i=1, 6)], point)
    lambda = 1.0_wp
    do i = 1, 40
      next = 1.0_wp - 0.9_wp*real(i, wp)/40.0_wp
      call step_point(law, point, [(.true., j=1, 9)], &
        [next/lambda, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], error)
      lambda = next
    end do
    call tests%close('confined compression to a tenth gives E ln(10)/0.1', point%stress(1), &
      -10.0_wp*log(10.0_wp), 1.0e-12_wp)
    call tests%close('the volume ratio follows', point%volume_ratio, 0.1_wp, 1.0e-15_wp)
  end subroutine check_oedometer

  !> Simple shear of the Hencky material: s12/G and s11/G to the six digits of the table, and the
  !> closed form 2 asinh(g/2)/sqrt(g^2+4), g/2 times it.
  subroutine check_simple_shear(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: wanted(3, 4) = reshape([1.0_wp, 0.860818_wp, 0.430409_wp, &
      2.0_wp, 1.246450_wp, 1.246450_wp, pi, 1.324747_wp, 2.080908_wp, &
      4.0_wp, 1.291227_wp, 2.582454_wp], [3, 4])
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: g
    integer :: i, k

    call make_law(elastic(2.5_wp, 0.25_wp), 2, kinematics_logarithmic, rate_midpoint, law)
    do k = 1, size(wanted, 2)
      g = wanted(1, k)
      call start_point(law, [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], point)
      do i = 1, 7
        call step_point(law, point, [.true., .true., .true., .true., .true.], &
          [1.0_wp, 0.0_wp, g/7.0_wp, 1.0_wp, 1.0_wp], error)
      end do
      call tests%close('shear stress in simple shear', point%stress(4), wanted(2, k), 5.1e-7_wp)
      call tests%close('normal stress in simple shear', point%stress(1), wanted(3, k), 5.1e-7_wp)
      call tests%close('shear stress in closed form', point%stress(4), &
        4.0_wp*log(0.5_wp*g + sqrt(1.0_wp + 0.25_wp*g*g))/sqrt(g*g + 4.0_wp), 1.0e-13_wp)
    end do
  end subroutine check_simple_shear

  !> A full turn in steps of 10 degrees.
  subroutine check_rigid_turn(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: c, s
    integer :: i

    call make_law(elastic(2.5_wp, 0.25_wp), 2, kinematics_logarithmic, rate_midpoint, law)
    call start_point(law, [1.0_wp, -1.0_wp, 0.0_wp, 0.0_wp], point)
    c = cos(pi/18.0_wp)
    s = sin(pi/18.0_wp)
    do i = 1, 36
      call step_point(law, point, [.true., .true., .true., .true., .true.], &
        [c, s, -s, c, 1.0_wp], error)
    end do
    call tests%close('a rigid turn keeps the deviator', &
      0.5_wp*(point%stress(1) - point%stress(2)), 1.0_wp, 1.0e-10_wp)
    call tests%close('a rigid turn makes no mean stress', sum(point%stress(1:3)), 0.0_wp, &
      1.0e-10_wp)
    call tests%close('a rigid turn keeps the volume', point%volume_ratio, 1.0_wp, 1.0e-12_wp)
  end subroutine check_rigid_turn

  !> Consistent and elastic tangent against differences, and symmetry. Tolerance 1e-7 of E: the
  !> differences themselves err by 1e-10 (round-off over the step).
  subroutine check_tangent(tests, name, p, d, symmetric)
    type(tests_type), intent(inout) :: tests
    !> Name for the messages.
    character(len=*), intent(in) :: name
    type(material_parameters_type), intent(in) :: p
    !> Dimension.
    integer, intent(in) :: d
    !> Whether the consistent tangent is symmetric.
    logical, intent(in) :: symmetric
    class(law_type), allocatable :: law, free
    type(batch_type) :: batch, copy
    type(material_parameters_type) :: q
    real(wp), allocatable :: tangent(:, :, :)
    real(wp) :: error, scale
    integer :: compared

    scale = 1.0_wp/(1.0_wp - 2.0_wp*p%poisson)
    call make_law(p, d, kinematics_logarithmic, rate_midpoint, law)
    call random_batch(law, 400, 0.04_wp, 1.0_wp, batch)
    call law%update(batch, tangent_consistent)
    allocate (tangent, source=batch%tangent)
    call tests%check(name//': all points are updated', all(batch%status == status_ok))
    if (p%mohr_coulomb) call tests%check(name//': most points yield', &
      sum(batch%plastic) > 200 .and. sum(batch%plastic) < 400)
    call tests%check(name//': the law says whether it is symmetric', law%symmetric .eqv. symmetric)
    call tests%check(name//': and is', (asymmetry(tangent) < 1.0e-12_wp*scale*p%young) &
      .eqv. symmetric)
    call difference_error(law, batch, tangent, error, compared)
    call tests%close(name//': consistent tangent agrees with differences', error, 0.0_wp, &
      1.0e-7_wp)
    call tests%check(name//': nearly all columns were compared', &
      compared > 98*batch%count*size(tangent, 2)/100)
    call law%update(batch, tangent_elastic)
    q = elastic(p%young, p%poisson)
    call make_law(q, d, kinematics_logarithmic, rate_midpoint, free)
    call random_batch(free, 400, 0.04_wp, 1.0_wp, copy)
    call free%update(copy, tangent_consistent)
    call tests%close(name//': elastic tangent is that of the material without strength', &
      maxval(abs(batch%tangent - copy%tangent)), 0.0_wp, 1.0e-12_wp*scale*p%young)
  end subroutine check_tangent

  pure real(wp) function asymmetry(a)
    real(wp), intent(in) :: a(:, :, :)
    integer :: i

    asymmetry = 0.0_wp
    do i = 1, size(a, 3)
      asymmetry = max(asymmetry, maxval(abs(a(:, :, i) - transpose(a(:, :, i)))))
    end do
  end function asymmetry

  !> The blended tangent is the mix of the two.
  subroutine check_blend(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp), allocatable :: consistent(:, :, :), elastic_one(:, :, :)

    call make_law(strong(0.0_wp, -1.0_wp), 3, kinematics_logarithmic, rate_midpoint, law)
    call random_batch(law, 50, 0.04_wp, 1.0_wp, batch)
    call law%update(batch, tangent_consistent)
    allocate (consistent, source=batch%tangent)
    call law%update(batch, tangent_elastic)
    allocate (elastic_one, source=batch%tangent)
    law%elastic_blend = 0.125_wp
    call law%update(batch, tangent_consistent)
    call tests%close('the blended tangent is the mix of consistent and elastic', &
      maxval(abs(batch%tangent - 0.875_wp*consistent - 0.125_wp*elastic_one)), 0.0_wp, 1.0e-11_wp)
  end subroutine check_blend

  !> Equal and nearly equal stretches, where the quotients of the derivative become limits.
  subroutine check_equal_values(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp), allocatable :: tangent(:, :, :)
    real(wp) :: error
    integer :: i, compared

    call make_law(elastic(200.0_wp, 0.33_wp), 3, kinematics_logarithmic, rate_midpoint, law)
    call make_batch(law, 40, batch)
    do i = 1, batch%count
      batch%gradient(1, i) = 1.02_wp
      batch%gradient(5, i) = 1.02_wp + 10.0_wp**(-real(i, wp)/2.5_wp)
      batch%gradient(9, i) = merge(1.02_wp, 0.97_wp, modulo(i, 2) == 0)
      batch%gradient(7, i) = merge(0.0_wp, 1.0e-12_wp, modulo(i, 3) == 0)
    end do
    call law%update(batch, tangent_consistent)
    allocate (tangent, source=batch%tangent)
    call difference_error(law, batch, tangent, error, compared)
    call tests%close('tangent at equal stretches agrees with differences', error, 0.0_wp, 1.0e-7_wp)
    call tests%check('every column was compared', compared == 9*batch%count)
  end subroutine check_equal_values

  !> Equal and nearly equal stretches in the plane, on both sides of the change from series to logarithm, with
  !> points that yield: stress and tangent are those of the solid law, and the tangent agrees with differences.
  !> Tolerance: roundings of the two forms, relative to E.
  subroutine check_near_plane_values(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: plane, solid
    type(batch_type) :: flat, full
    integer, parameter :: at(5) = [1, 2, 4, 5, 9]
    real(wp), allocatable :: tangent(:, :, :)
    real(wp) :: error
    integer :: i, k, compared

    do k = 1, 2
      call make_law(merge(elastic(200.0_wp, 0.33_wp), strong(5.0_wp, 0.5_wp), k == 1), 2, &
        kinematics_logarithmic, rate_midpoint, plane)
      call make_law(merge(elastic(200.0_wp, 0.33_wp), strong(5.0_wp, 0.5_wp), k == 1), 3, &
        kinematics_logarithmic, rate_midpoint, solid)
      call make_batch(plane, 80, flat)
      do i = 1, flat%count
        ! Gaps from 1e-16 to 1: the series ends at stretches that differ by 6 %.
        flat%gradient(:, i) = [0.98_wp, 0.0_wp, 0.0_wp, 0.98_wp, 1.01_wp]
        flat%gradient(4, i) = 0.98_wp + 10.0_wp**(-0.2_wp*i)
        if (modulo(i, 2) == 0) flat%gradient(2:3, i) = 0.3_wp*10.0_wp**(-0.2_wp*i)
        if (modulo(i, 3) == 0) flat%gradient(3, i) = 0.0_wp
      end do
      call plane_batch(solid, flat, full)
      call plane%update(flat, tangent_consistent)
      call solid%update(full, tangent_consistent)
      call tests%close('nearly equal values: the plane stress is that of the solid', &
        maxval(abs(flat%stress - full%stress(1:4, :)))/200.0_wp, 0.0_wp, 1.0e-14_wp)
      call tests%close('nearly equal values: the plane tangent is that of the solid', &
        maxval(abs(flat%tangent - full%tangent(at, at, :)))/200.0_wp, 0.0_wp, 1.0e-11_wp)
      call tests%check('nearly equal values: a point yields or none can', &
        (sum(flat%plastic) > 0) .eqv. k == 2)
      if (allocated(tangent)) deallocate (tangent)
      allocate (tangent, source=flat%tangent)
      call difference_error(plane, flat, tangent, error, compared)
      call tests%close('nearly equal values: tangent agrees with differences', error, 0.0_wp, 1.0e-7_wp)
      call tests%check('nearly equal values: nearly all columns were compared', compared > 5*flat%count - 20)
    end do
  end subroutine check_near_plane_values

  !> Stretches from 0.05 to 7: stress against ln b by Jacobi's method, symmetry, tangent against differences.
  !> Tolerance of the stress: roundings of b, 1e-16, over its least principal value, 1e-4 of the largest;
  !> the tangent's symmetry and differences relative to its largest entry.
  subroutine check_large_strains(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp), allocatable :: tangent(:, :, :)
    real(wp) :: f(3, 3), values(3), vectors(3, 3), wanted(3, 3), worst, error
    integer :: d, i, j, compared

    do d = 2, 3
      call make_law(elastic(200.0_wp, 0.33_wp), d, kinematics_logarithmic, rate_midpoint, law)
      call make_batch(law, 200, batch)
      worst = 0.0_wp
      do i = 1, batch%count
        do j = 1, size(batch%gradient, 1)
          batch%gradient(j, i) = 0.7_wp*batch%gradient(j, i)*10.0_wp**sin(1.7_wp*i*j) + 0.02_wp*sin(2.9_wp*i*j)
        end do
      end do
      call law%update(batch, tangent_consistent)
      call tests%check('large strains: all points are updated', all(batch%status == status_ok))
      do i = 1, batch%count
        f = unpack_gradient(batch%gradient(:, i))
        call jacobi_spectral(matmul(f, transpose(f)), values, vectors)
        values = log(values)*0.5_wp
        values = (values + 0.33_wp/0.34_wp*sum(values))*200.0_wp/1.33_wp
        wanted = compose(values, vectors)/(batch%volume_ratio(i)*determinant(f))
        worst = max(worst, maxval(abs(unpack_symmetric(batch%stress(:, i)) - wanted))/maxval(abs(wanted)))
      end do
      call tests%close('large strains: the stress is that of ln b', worst, 0.0_wp, 1.0e-12_wp)
      allocate (tangent, source=batch%tangent)
      worst = 0.0_wp
      do i = 1, batch%count
        worst = max(worst, asymmetry(tangent(:, :, i:i))/maxval(abs(tangent(:, :, i))))
      end do
      call tests%close('large strains: the tangent is symmetric', worst, 0.0_wp, 1.0e-12_wp)
      call difference_error(law, batch, tangent, error, compared)
      call tests%close('large strains: tangent agrees with differences', error, 0.0_wp, 1.0e-7_wp)
      call tests%check('large strains: most columns were compared', compared > batch%count*size(tangent, 2)/2)
      deallocate (tangent)
    end do
  end subroutine check_large_strains

  !> Stretches of 1e5 and 1e-5 side by side keep their digits where b is nearly diagonal:
  !> tau = 2 G ln(1e5) for lambda = 0. Tolerance: roundings of the logarithms.
  subroutine check_extreme_ratio(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    integer :: d

    do d = 2, 3
      call make_law(elastic(1.0_wp, 0.0_wp), d, kinematics_logarithmic, rate_midpoint, law)
      call make_batch(law, 1, batch)
      batch%volume_ratio = 1.0_wp
      if (d == 2) batch%gradient(:, 1) = [1.0e5_wp, 0.0_wp, 1.0e-12_wp, 1.0e-5_wp, 1.0_wp]
      if (d == 3) batch%gradient(:, 1) = &
        [1.0e5_wp, 0.0_wp, 0.0_wp, 1.0e-12_wp, 1.0e-5_wp, 0.0_wp, 1.0e-12_wp, 0.0_wp, 1.0_wp]
      call law%update(batch, tangent_consistent)
      call tests%check('extreme ratio: the point is updated', batch%status(1) == status_ok)
      call tests%close('extreme ratio: the large stretch', batch%stress(1, 1), log(1.0e5_wp), 1.0e-13_wp)
      call tests%close('extreme ratio: the small stretch', batch%stress(2, 1), -log(1.0e5_wp), 1.0e-13_wp)
    end do
  end subroutine check_extreme_ratio

  !> The plane law is the solid one. Tolerance: roundings of the two decompositions.
  subroutine check_plane(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: difference
    integer :: plastic

    call compare_plane(elastic(200.0_wp, 0.33_wp), kinematics_logarithmic, rate_midpoint, &
      difference, plastic)
    call tests%close('elastic: two dimensions equal three', difference, 0.0_wp, 1.0e-13_wp)
    call compare_plane(strong(0.0_wp, 0.5_wp), kinematics_logarithmic, rate_midpoint, &
      difference, plastic)
    call tests%close('plastic: two dimensions equal three', difference, 0.0_wp, 1.0e-13_wp)
    call tests%check('plastic: points yield', plastic > 100)
  end subroutine check_plane

  !> A started point holds its stress, and fields go there and back.
  subroutine check_start_and_fields(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: wanted(6) = [-30.0_wp, 10.0_wp, -5.0_wp, 7.0_wp, -12.0_wp, 4.0_wp]
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp) :: stress(6), state(6), fields(6)

    call make_law(elastic(200.0_wp, 0.33_wp), 3, kinematics_logarithmic, rate_midpoint, law)
    call make_batch(law, 1, batch)
    batch%volume_ratio = 1.0_wp
    batch%stress_start(:, 1) = wanted
    call law%start(wanted, batch%state_start(:, 1))
    call law%update(batch, tangent_consistent)
    call tests%close('a started point holds its stress', maxval(abs(batch%stress(:, 1) - wanted)), &
      0.0_wp, 1.0e-12_wp)
    call tests%close('and its state', maxval(abs(batch%state - batch%state_start)), 0.0_wp, &
      1.0e-15_wp)
    call law%to_fields(wanted, batch%state(:, 1), fields)
    call law%from_fields(fields, 2.0_wp, stress, state)
    call tests%check('six fields are averaged', law%fit_count() == 6)
    call tests%close('fields give the state back', maxval(abs(state - batch%state(:, 1))), 0.0_wp, &
      1.0e-14_wp)
    call tests%close('fields give the Cauchy stress, over the volume ratio', &
      maxval(abs(stress - 0.5_wp*wanted)), 0.0_wp, 1.0e-12_wp)
  end subroutine check_start_and_fields

  !> Points that cannot be updated say so and stay finite.
  subroutine check_refusal(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp) :: nan

    nan = ieee_value(nan, ieee_quiet_nan)
    call make_law(strong(0.0_wp, -1.0_wp), 2, kinematics_logarithmic, rate_midpoint, law)
    call make_batch(law, 5, batch)
    batch%gradient(:, 5) = [1.0e-20_wp, 0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp]
    batch%gradient(1, 1) = -0.1_wp
    batch%gradient(3, 2) = nan
    batch%state_start(1, 3) = -1.0_wp
    call law%update(batch, tangent_consistent)
    call tests%check('a point turned inside out asks for a cut', batch%status(1) == status_cut)
    call tests%check('a gradient that is no number asks for a cut', batch%status(2) == status_cut)
    call tests%check('a state that is not positive definite fails', &
      batch%status(3) == status_failed)
    call tests%check('a collapse to a plane asks for a cut', batch%status(5) == status_cut)
    call tests%check('the sound point is updated', batch%status(4) == status_ok)
    call tests%check('no result is a NaN', all(ieee_is_finite(batch%stress)) &
      .and. all(ieee_is_finite(batch%state)) .and. all(ieee_is_finite(batch%piola)) &
      .and. all(ieee_is_finite(batch%tangent)))
  end subroutine check_refusal
end module test_logarithmic_law
