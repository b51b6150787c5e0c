!> Modified Cam-Clay: closed forms of triaxial and one-dimensional tests in both kinematics, the tangent, the
!> plane against space, and what happens without stress.
module test_cam_clay
  use law_trials, only: difference_error, plane_batch
  use qsmpm_error, only: error_type
  use qsmpm_half_step_law, only: half_step_law_type, make_half_step_law
  use qsmpm_hardening_parameters, only: cam_clay_parameters_type
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type, batch_type, status_ok, status_cut, tangent_none, tangent_consistent
  use qsmpm_law_factory, only: new_law, kinematics_jaumann, kinematics_logarithmic, rate_paper, rate_midpoint
  use qsmpm_point_driver, only: point_type, start_point
  use qsmpm_tensor, only: determinant, unpack_gradient
  use soil_trials, only: clay_parameters, make_clay, pressed_batch, press, compress, triaxial, oedometer
  use testing, only: tests_type
  implicit none
  private

  public :: collect_cam_clay

  !> Isotropic start of 100 kPa.
  real(wp), parameter :: isotropic(4) = [-100.0_wp, -100.0_wp, -100.0_wp, 0.0_wp]

contains

  subroutine collect_cam_clay(tests)
    type(tests_type), intent(inout) :: tests
    integer :: d, k

    call tests%start('cam_clay')
    do k = 0, 1
      call check_undrained(tests, k == 1)
      call check_drained(tests, k == 1)
      call check_one_dimensional(tests, k == 1)
      call check_swelling(tests, k == 1)
      call check_dry_side(tests, k == 1)
      call check_order(tests, k == 1)
      do d = 2, 3
        call check_tangent(tests, d, k == 1)
        call check_no_stress(tests, d, k == 1)
      end do
      call check_plane(tests, k == 1)
    end do
    call check_turn(tests)
    call check_start(tests)
    call check_refusal(tests)
  end subroutine collect_cam_clay

  !> Undrained compression ends at p = q/M = p0 2^-(1 - kappa/lambda) = 57.434918. Strain 0.36: the path has
  !> reached the critical state to 1e-7. Tolerance: 640 backward Euler steps, measured 5e-6 at most.
  subroutine check_undrained(tests, logarithmic)
    type(tests_type), intent(inout) :: tests
    logical, intent(in) :: logarithmic
    class(law_type), allocatable :: law
    type(point_type) :: point

    call make_clay(clay_parameters(), 2, logarithmic, law)
    call start_point(law, isotropic, point)
    call compress(law, point, 0.7_wp, 0.7_wp**(-0.5_wp), 640)
    call tests%close('undrained strength p', -sum(point%stress(1:3))/3.0_wp, 57.434918_wp, 1.0e-5_wp)
    call tests%close('undrained strength q', point%stress(1) - point%stress(2), 57.434918_wp, 1.0e-5_wp)
    call tests%close('pc is twice p at the critical state', point%state(1), 2.0_wp*57.434918_wp, 2.0e-5_wp)
  end subroutine check_undrained

  !> Drained triaxial compression to eta = 0.6 and 0.9: closed forms of the volume and the shear strain.
  !> The volume strain is exact but for the path of eta within a step; the shear strain is of first order:
  !> four times the steps leave a quarter of the error, and the extrapolated value is right to 1e-5.
  subroutine check_drained(tests, logarithmic)
    type(tests_type), intent(inout) :: tests
    logical, intent(in) :: logarithmic
    real(wp) :: coarse(2), fine(2)
    integer :: i
    real(wp), parameter :: ratio(2) = [0.6_wp, 0.9_wp]
    real(wp), parameter :: volume(2) = [0.0426483_wp, 0.0755760_wp], shear(2) = [0.043608_wp, 0.174206_wp]

    do i = 1, 2
      call drained(ratio(i), 160, logarithmic, coarse)
      call drained(ratio(i), 640, logarithmic, fine)
      call tests%close('drained volume strain', fine(1), volume(i), 5.0e-7_wp)
      call tests%close('drained shear strain, extrapolated', fine(2) + (fine(2) - coarse(2))/3.0_wp, shear(i), &
        1.0e-5_wp)
      call tests%close('its error is of first order', (coarse(2) - shear(i))/(fine(2) - shear(i)), 4.0_wp, 0.1_wp)
    end do
  end subroutine check_drained

  !> Volume and shear strain of a drained test to a stress ratio.
  subroutine drained(ratio, n, logarithmic, strain)
    real(wp), intent(in) :: ratio
    integer, intent(in) :: n
    logical, intent(in) :: logarithmic
    real(wp), intent(out) :: strain(2)
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error

    call make_clay(clay_parameters(), 2, logarithmic, law)
    call start_point(law, isotropic, point)
    strain = 0.0_wp
    call triaxial(law, point, -100.0_wp, -100.0_wp - ratio*300.0_wp/(3.0_wp - ratio), n, error)
    if (allocated(error)) return
    strain(1) = -log(point%volume_ratio)
    strain(2) = 2.0_wp/3.0_wp*(log(point%deformation(1, 1)) - log(point%deformation(2, 2)))
  end subroutine drained

  !> Confined compression tends to K0nc = 0.722156. Tolerance: 400 steps, first order, measured 6.7e-5.
  subroutine check_one_dimensional(tests, logarithmic)
    type(tests_type), intent(inout) :: tests
    logical, intent(in) :: logarithmic
    class(law_type), allocatable :: law
    type(point_type) :: point

    call make_clay(clay_parameters(), 2, logarithmic, law)
    call start_point(law, isotropic, point)
    call oedometer(law, point, 0.7_wp, 400)
    call tests%close('K0nc', point%stress(1)/point%stress(2), 0.722156_wp, 1.0e-4_wp)
  end subroutine check_one_dimensional

  !> Isotropic loading and swelling along straight lines in ln v - ln p: lambda/v0 up, kappa/v0 down, exact in
  !> one step. Tolerance: the midpoint strain of the Jaumann rate, e^3/12 of the strain times K/p = 55.
  subroutine check_swelling(tests, logarithmic)
    type(tests_type), intent(inout) :: tests
    logical, intent(in) :: logarithmic
    class(law_type), allocatable :: law
    type(point_type) :: point
    real(wp) :: goal

    goal = merge(1.0e-10_wp, 1.0e-4_wp, logarithmic)
    call make_clay(clay_parameters(), 2, logarithmic, law)
    call start_point(law, isotropic, point)
    call compress(law, point, exp(-0.02_wp), exp(-0.02_wp), 1)
    call tests%close('isotropic compression', -point%stress(1)/100.0_wp, exp(0.06_wp*2.2_wp/0.2_wp), goal)
    call tests%check('it yields', point%plastic)
    call compress(law, point, exp(0.004_wp), exp(0.004_wp), 1)
    call tests%close('swelling', -point%stress(2)/100.0_wp, &
      exp(0.06_wp*2.2_wp/0.2_wp - 0.012_wp*2.2_wp/0.04_wp), goal)
    call tests%check('it does not yield', .not. point%plastic)
  end subroutine check_swelling

  !> A clay of OCR 8 softens to the same critical state line: p = q/M at the end, below the peak of q, with p
  !> = p0 (OCR/2)^(1 - kappa/lambda). Tolerance as in the undrained test, times the larger p.
  subroutine check_dry_side(tests, logarithmic)
    type(tests_type), intent(inout) :: tests
    logical, intent(in) :: logarithmic
    type(cam_clay_parameters_type) :: p
    class(law_type), allocatable :: law
    type(point_type) :: point
    real(wp) :: expected

    p = clay_parameters()
    p%ocr = 8.0_wp
    expected = 100.0_wp*4.0_wp**0.8_wp
    call make_clay(p, 2, logarithmic, law)
    call start_point(law, isotropic, point)
    call compress(law, point, 0.5_wp, 0.5_wp**(-0.5_wp), 800)
    call tests%close('critical state from the dry side, p', -sum(point%stress(1:3))/3.0_wp, expected, 1.0e-2_wp)
    call tests%close('critical state from the dry side, q', point%stress(1) - point%stress(2), expected, 1.0e-2_wp)
    call tests%check('pc has fallen', point%state(1) < 800.0_wp)
  end subroutine check_dry_side

  !> The difference of one step and two halves falls with the square of the step. Tolerance: the third power.
  subroutine check_order(tests, logarithmic)
    type(tests_type), intent(inout) :: tests
    logical, intent(in) :: logarithmic
    real(wp) :: difference(2)
    integer :: i
    class(law_type), allocatable :: law
    type(batch_type) :: whole, half
    type(half_step_law_type) :: halved

    call make_clay(clay_parameters(), 3, logarithmic, law)
    call make_half_step_law(law, halved)
    do i = 1, 2
      call pressed_batch(law, 60, 4.0e-4_wp/2**i, 40.0_wp, 100.0_wp, whole)
      half = whole
      call law%update(whole, tangent_none)
      call halved%update(half, tangent_none)
      difference(i) = norm2(whole%stress - half%stress)
    end do
    call tests%close('order of the halved step', log(difference(1)/difference(2))/log(2.0_wp), 2.0_wp, 0.15_wp)
  end subroutine check_order

  !> Tangent against central differences, elastic and plastic, small and large steps; it is not symmetric.
  !> Tolerance: rounding of the differences, 1e-16/1e-6 times the 100 that the stress is over its change.
  subroutine check_tangent(tests, dimension, logarithmic)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    logical, intent(in) :: logarithmic
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp), allocatable :: tangent(:, :, :)
    real(wp), parameter :: spread(4) = [1.0e-4_wp, 1.0e-3_wp, 1.0e-2_wp, 0.1_wp]
    real(wp) :: error
    integer :: i, compared

    call make_clay(clay_parameters(), dimension, logarithmic, law)
    do i = 1, size(spread)
      call pressed_batch(law, 200, spread(i), 40.0_wp, 100.0_wp, batch)
      call law%update(batch, tangent_consistent)
      allocate (tangent, source=batch%tangent)
      call tests%check('every point has an answer', all(batch%status == status_ok))
      if (i == 1) call tests%check('some yield, some do not', sum(batch%plastic) > 50 .and. sum(batch%plastic) < 150)
      call difference_error(law, batch, tangent, error, compared)
      call tests%close('tangent', error, 0.0_wp, 5.0e-8_wp)
      call tests%check('nearly all columns were compared', compared > 95*size(batch%piola)/100)
      deallocate (tangent)
    end do
  end subroutine check_tangent

  !> Steps of any size from no stress at all and from tension: an answer or a refusal, never anything else,
  !> and answers on or inside the yield surface.
  subroutine check_no_stress(tests, dimension, logarithmic)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    logical, intent(in) :: logarithmic
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp), parameter :: spread(5) = [1.0e-5_wp, 1.0e-3_wp, 1.0e-2_wp, 0.1_wp, 0.4_wp]
    real(wp) :: p, q2, s(6), worst
    integer :: i, k, bad

    call make_clay(clay_parameters(), dimension, logarithmic, law)
    worst = 0.0_wp
    bad = 0
    do i = 1, size(spread)
      call pressed_batch(law, 200, spread(i), 0.5_wp, 0.0_wp, batch)
      call law%update(batch, tangent_consistent)
      do k = 1, batch%count
        if (batch%status(k) /= status_ok) then
          if (determinant(unpack_gradient(batch%gradient(:, k))) > 0.0_wp) bad = bad + 1
          if (batch%status(k) /= status_cut) worst = huge(1.0_wp)
          cycle
        end if
        s = 0.0_wp
        s(:size(batch%stress, 1)) = batch%stress(:, k)
        p = -sum(s(1:3))/3.0_wp
        q2 = 1.5_wp*sum((s(1:3) + p)**2) + 3.0_wp*sum(s(4:6)**2)
        worst = max(worst, (q2 + p*(p - batch%state(1, k)))/batch%state(1, k)**2)
      end do
    end do
    call tests%close('from no stress every answer is admissible', worst, 0.0_wp, 1.0e-9_wp)
    call tests%check('no gradient with a volume is refused', bad == 0)
  end subroutine check_no_stress

  !> A plane law and the solid law on the same path. Tolerance: roundings.
  subroutine check_plane(tests, logarithmic)
    type(tests_type), intent(inout) :: tests
    logical, intent(in) :: logarithmic
    class(law_type), allocatable :: plane, solid
    type(batch_type) :: flat, full
    integer, parameter :: at(5) = [1, 2, 4, 5, 9]

    call make_clay(clay_parameters(), 2, logarithmic, plane)
    call make_clay(clay_parameters(), 3, logarithmic, solid)
    call pressed_batch(plane, 200, 1.0e-2_wp, 40.0_wp, 100.0_wp, flat)
    call plane_batch(solid, flat, full)
    call plane%update(flat, tangent_consistent)
    call solid%update(full, tangent_consistent)
    call tests%close('plane stress is that of space', maxval(abs(flat%stress - full%stress(1:4, :))), 0.0_wp, 1.0e-8_wp)
    call tests%close('plane tangent is that of space', maxval(abs(flat%tangent - full%tangent(at, at, :))) &
      /maxval(abs(flat%tangent)), 0.0_wp, 1.0e-9_wp)
    call tests%close('plane history is that of space', maxval(abs(flat%state - full%state)), 0.0_wp, 1.0e-8_wp)
  end subroutine check_plane

  !> A rigid turn by 0.5 turns the stress and changes nothing else, in both kinematics. Tolerance: rounding of
  !> the logarithm times K/p.
  subroutine check_turn(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp) :: c, s
    integer :: k

    c = cos(0.5_wp)
    s = sin(0.5_wp)
    do k = 0, 1
      call make_clay(clay_parameters(), 2, k == 1, law)
      call pressed_batch(law, 1, 0.0_wp, 0.0_wp, 100.0_wp, batch)
      batch%stress_start(:, 1) = [-60.0_wp, -120.0_wp, -80.0_wp, 0.0_wp]
      call press(law, 0.0_wp, batch)
      batch%gradient(:, 1) = [c, s, -s, c, 1.0_wp]
      call law%update(batch, tangent_none)
      call tests%close('a turned stress', maxval(abs(batch%stress(:, 1) - [-60.0_wp*c*c - 120.0_wp*s*s, &
        -60.0_wp*s*s - 120.0_wp*c*c, -80.0_wp, 60.0_wp*s*c])), 0.0_wp, 1.0e-10_wp)
      call tests%close('history of a turn', batch%state(1, 1) - batch%state_start(1, 1), 0.0_wp, 1.0e-10_wp)
    end do
  end subroutine check_turn

  !> The first yield surface passes through the initial stress, is OCR times that, and not below what is given.
  subroutine check_start(tests)
    type(tests_type), intent(inout) :: tests
    type(cam_clay_parameters_type) :: p
    class(law_type), allocatable :: law
    real(wp) :: state(1)
    real(wp), parameter :: stress(4) = [-80.0_wp, -140.0_wp, -80.0_wp, 0.0_wp]

    p = clay_parameters()
    call make_clay(p, 2, .true., law)
    call law%start(stress, state)
    call tests%close('pc of a normally consolidated stress', state(1), 136.0_wp, 1.0e-12_wp)
    p%ocr = 2.0_wp
    call make_clay(p, 2, .true., law)
    call law%start(stress, state)
    call tests%close('pc of an overconsolidated stress', state(1), 272.0_wp, 1.0e-12_wp)
    p%preconsolidation = 300.0_wp
    call make_clay(p, 2, .true., law)
    call law%start(stress, state)
    call tests%close('pc given', state(1), 300.0_wp, 1.0e-12_wp)
    call tests%check('the history has a name', law%state_names(1)%text == 'preconsolidation_pressure')
  end subroutine check_start

  !> Faulty parameters and the rate of the paper are refused, and the message names what.
  subroutine check_refusal(tests)
    type(tests_type), intent(inout) :: tests
    type(cam_clay_parameters_type) :: p
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error

    p = clay_parameters()
    call new_law(p, 2, kinematics_jaumann, rate_paper, law, error)
    call tests%check('RATE=PAPER is refused', allocated(error))
    p%kappa = 0.3_wp
    call new_law(p, 2, kinematics_logarithmic, rate_midpoint, law, error)
    call tests%check('kappa above lambda is refused', allocated(error))
    if (allocated(error)) call tests%check('by name', index(error%message, 'kappa') > 0)
  end subroutine check_refusal
end module test_cam_clay
