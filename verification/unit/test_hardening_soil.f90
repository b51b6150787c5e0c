!> The hardening soil model: what its moduli promise, strength, dilatancy, one-dimensional compression, the
!> tangent on every surface, and the plane against space.
module test_hardening_soil
  use point_trials, only: step_point
  use law_trials, only: difference_error, plane_batch
  use qsmpm_error, only: error_type
  use qsmpm_half_step_law, only: half_step_law_type, make_half_step_law
  use qsmpm_hardening_soil, only: hardening_soil_parameters_type
  use qsmpm_kinds, only: wp, pi
  use qsmpm_law, only: law_type, batch_type, status_ok, tangent_none, tangent_consistent
  use qsmpm_law_factory, only: new_law, kinematics_logarithmic, rate_midpoint
  use qsmpm_point_driver, only: point_type, start_point
  use soil_trials, only: sand_parameters, make_sand, pressed_batch, triaxial, oedometer
  use testing, only: tests_type
  implicit none
  private

  public :: collect_hardening_soil

  real(wp), parameter :: isotropic(4) = [-100.0_wp, -100.0_wp, -100.0_wp, 0.0_wp]

contains

  subroutine collect_hardening_soil(tests)
    type(tests_type), intent(inout) :: tests
    integer :: d, k, m
    real(wp), parameter :: power(3) = [0.5_wp, 0.7_wp, 1.0_wp]

    call tests%start('hardening_soil')
    do k = 0, 1
      do m = 1, 3
        call check_hyperbola(tests, power(m), k == 1)
        call check_one_dimensional(tests, power(m), k == 1)
      end do
      call check_strength(tests, k == 1)
      call check_order(tests, k == 1)
      do d = 2, 3
        call check_tangent(tests, d, k == 1)
        call check_no_stress(tests, d, k == 1)
      end do
      call check_plane(tests, k == 1)
    end do
    call check_start(tests)
    call check_refusal(tests)
  end subroutine collect_hardening_soil

  !> Largest q at a cell pressure.
  pure real(wp) function strength(p, cell)
    type(hardening_soil_parameters_type), intent(in) :: p
    real(wp), intent(in) :: cell
    real(wp) :: s

    s = sin(p%friction_angle*pi/180.0_wp)
    strength = (cell + p%cohesion/tan(p%friction_angle*pi/180.0_wp))*2.0_wp*s/(1.0_wp - s)
  end function strength

  !> Drained triaxial test with the cap out of reach, at the reference pressure and four times it: the secant
  !> at half the strength is E50 S^m, every stress lies on the hyperbola, unloading has Eur S^m. Exact, as the
  !> smallest stress does not change, but for the volume strain between Hencky strain and hyperbola: none here.
  !> Tolerance: the driver's 1e-12 of the stress.
  subroutine check_hyperbola(tests, power, logarithmic)
    type(tests_type), intent(inout) :: tests
    real(wp), intent(in) :: power
    logical, intent(in) :: logarithmic
    type(hardening_soil_parameters_type) :: p
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: qf, cell, level, before(2), initial, goal
    integer :: i

    goal = merge(1.0e-7_wp, 1.0e-4_wp, logarithmic)
    p = sand_parameters()
    p%power = power
    p%dilatancy_angle = 0.0_wp
    p%cohesion = 7.0_wp
    call make_sand(p, 2, logarithmic, law)
    do i = 1, 2
      cell = 100.0_wp*4.0_wp**(i - 1)
      level = ((cell + p%cohesion/tan(35.0_wp*pi/180.0_wp))/(100.0_wp + p%cohesion/tan(35.0_wp*pi/180.0_wp)))**power
      qf = strength(p, cell)
      call start_point(law, isotropic*cell/100.0_wp, point)
      point%state(2) = 1.0e5_wp
      call triaxial(law, point, -cell, -cell - 0.5_wp*qf, 20, error)
      call tests%close('E50', -0.5_wp*qf/log(point%deformation(2, 2))/(level*p%e50), 1.0_wp, goal)
      call triaxial(law, point, -cell, -cell - 0.9_wp*qf, 20, error)
      initial = 2.0_wp*p%e50*level/(2.0_wp - p%ratio)
      call tests%close('hyperbola at 0.9 qf', -log(point%deformation(2, 2))*initial, &
        0.9_wp*qf/(1.0_wp - 0.9_wp*p%ratio), goal*qf*10.0_wp)
      before = [log(point%deformation(2, 2)), point%stress(2)]
      call triaxial(law, point, -cell, -cell - 0.5_wp*qf, 3, error)
      call tests%close('Eur', (point%stress(2) - before(2))/(log(point%deformation(2, 2)) - before(1))/(level*p%eur), &
        1.0_wp, goal)
      call tests%check('unloading is elastic', .not. point%plastic)
    end do
  end subroutine check_hyperbola

  !> One-dimensional compression of a soil that has only known it: K0nc at every stress, the tangent modulus
  !> Eoed at the reference pressure (by a difference of stresses around it) and Eoed (s/pref)^m elsewhere.
  !> Tolerance: first order in 400 steps, measured 1e-5 and 1e-3.
  subroutine check_one_dimensional(tests, power, logarithmic)
    type(tests_type), intent(inout) :: tests
    real(wp), intent(in) :: power
    logical, intent(in) :: logarithmic
    type(hardening_soil_parameters_type) :: p
    class(law_type), allocatable :: law
    type(point_type) :: point
    real(wp) :: k0, before, strain
    integer :: i

    p = sand_parameters()
    p%power = power
    k0 = 1.0_wp - sin(35.0_wp*pi/180.0_wp)
    call make_sand(p, 2, logarithmic, law)
    do i = 1, 2
      associate (stress => 100.0_wp*2.0_wp**(i - 1))
        call start_point(law, -0.96_wp*stress*[k0, 1.0_wp, k0, 0.0_wp], point)
        before = point%stress(2)
        ! A strain that brings the stress as far beyond as it began below.
        strain = 0.08_wp*stress/(p%eoed*(stress/100.0_wp)**power)
        call oedometer(law, point, exp(-strain), 400)
        call tests%close('K0nc', point%stress(1)/point%stress(2), k0, 2.0e-5_wp)
        call tests%close('stress after a strain with Eoed', point%stress(2)/before, 1.04_wp/0.96_wp, 5.0e-4_wp)
      end associate
    end do
  end subroutine check_one_dimensional

  !> Triaxial compression and extension fail at the strength of Mohr and Coulomb and dilate there by
  !> 2 sin psi/(1 - sin psi) of the axial strain. Tolerance: 1e-9 of the strength; the curvature of the path in
  !> 100 steps that start below failure for the dilatancy.
  subroutine check_strength(tests, logarithmic)
    type(tests_type), intent(inout) :: tests
    logical, intent(in) :: logarithmic
    type(hardening_soil_parameters_type) :: p
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: before(2), psi
    integer :: i, k

    p = sand_parameters()
    psi = sin(p%dilatancy_angle*pi/180.0_wp)
    do k = 1, 2
      call make_sand(p, 2, logarithmic, law)
      call start_point(law, isotropic, point)
      before = 0.0_wp
      do i = 1, 300
        if (i == 251) before = [log(point%deformation(2, 2)), log(point%volume_ratio)]
        call step_point(law, point, [.false., .true., .true., .true., .false.], [-100.0_wp, 0.0_wp, 0.0_wp, &
          merge(0.999_wp, 1.001_wp, k == 1), -100.0_wp], error)
        if (allocated(error)) exit
      end do
      call tests%check('the test goes on to its end', .not. allocated(error))
      if (k == 1) then
        call tests%close('strength in compression', -point%stress(2) - 100.0_wp, strength(p, 100.0_wp), 1.0e-6_wp)
        call tests%close('dilatancy at failure', (log(point%volume_ratio) - before(2)) &
          /(before(1) - log(point%deformation(2, 2))), 2.0_wp*psi/(1.0_wp - psi), 1.0e-6_wp)
      else
        call tests%close('strength in extension', 100.0_wp + point%stress(2), &
          strength(p, -point%stress(2)), 1.0e-6_wp)
        call tests%close('dilatancy in extension', (log(point%volume_ratio) - before(2)) &
          /(log(point%deformation(2, 2)) - before(1)), 2.0_wp*psi/(1.0_wp + psi), 1.0e-6_wp)
      end if
    end do
  end subroutine check_strength

  !> The difference of one step and two halves falls with the square of the step. Tolerance: the third power,
  !> and points that change surfaces.
  subroutine check_order(tests, logarithmic)
    type(tests_type), intent(inout) :: tests
    logical, intent(in) :: logarithmic
    real(wp) :: difference(2)
    integer :: i
    class(law_type), allocatable :: law
    type(batch_type) :: whole, half
    type(half_step_law_type) :: halved

    call make_sand(sand_parameters(), 3, logarithmic, law)
    call make_half_step_law(law, halved)
    do i = 1, 2
      call pressed_batch(law, 60, 2.0e-5_wp/2**i, 20.0_wp, 100.0_wp, whole)
      half = whole
      call law%update(whole, tangent_none)
      call halved%update(half, tangent_none)
      difference(i) = norm2(whole%stress - half%stress)
    end do
    call tests%close('order of the halved step', log(difference(1)/difference(2))/log(2.0_wp), 2.0_wp, 0.25_wp)
  end subroutine check_order

  !> Tangent against central differences on cap, shear surface, edges and failure, small and large steps.
  !> Tolerance: the hyperbola bends strongly at the smallest steps, where central differences miss 4e-6.
  subroutine check_tangent(tests, dimension, logarithmic)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    logical, intent(in) :: logarithmic
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp), allocatable :: tangent(:, :, :)
    real(wp), parameter :: spread(4) = [1.0e-4_wp, 1.0e-3_wp, 1.0e-2_wp, 0.1_wp]
    real(wp), parameter :: allowed(4) = [1.0e-5_wp, 1.0e-5_wp, 1.0e-6_wp, 1.0e-7_wp]
    real(wp) :: error
    integer :: i, compared

    call make_sand(sand_parameters(), dimension, logarithmic, law)
    do i = 1, size(spread)
      call pressed_batch(law, 200, spread(i), 40.0_wp, 100.0_wp, batch)
      call law%update(batch, tangent_consistent)
      allocate (tangent, source=batch%tangent)
      call tests%check('every point has an answer', all(batch%status == status_ok))
      if (i == 1) call tests%check('some yield, some do not', sum(batch%plastic) > 50 .and. sum(batch%plastic) < 195)
      call difference_error(law, batch, tangent, error, compared)
      call tests%close('tangent', error, 0.0_wp, allowed(i))
      call tests%check('nearly all columns were compared', compared > 90*size(batch%piola)/100)
      deallocate (tangent)
    end do
  end subroutine check_tangent

  !> Steps of any size from no stress and from tension: an answer inside the strength. Tolerance: roundings of
  !> stresses of 1e4.
  subroutine check_no_stress(tests, dimension, logarithmic)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    logical, intent(in) :: logarithmic
    type(hardening_soil_parameters_type) :: p
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp), parameter :: spread(5) = [1.0e-5_wp, 1.0e-3_wp, 1.0e-2_wp, 0.1_wp, 0.4_wp]
    integer :: i, bad

    p = sand_parameters()
    call make_sand(p, dimension, logarithmic, law)
    bad = 0
    do i = 1, size(spread)
      call pressed_batch(law, 200, spread(i), 1.0_wp, 0.0_wp, batch)
      call law%update(batch, tangent_consistent)
      bad = bad + count(batch%status /= status_ok)
      call tests%check('tension has gone', all(sum(batch%stress(1:3, :), dim=1) < 1.0e-6_wp))
    end do
    call tests%check('nearly every step has an answer', bad <= 5)
  end subroutine check_no_stress

  !> A plane law and the solid law on the same path. Tolerance: roundings.
  subroutine check_plane(tests, logarithmic)
    type(tests_type), intent(inout) :: tests
    logical, intent(in) :: logarithmic
    class(law_type), allocatable :: plane, solid
    type(batch_type) :: flat, full
    integer, parameter :: at(5) = [1, 2, 4, 5, 9]

    call make_sand(sand_parameters(), 2, logarithmic, plane)
    call make_sand(sand_parameters(), 3, logarithmic, solid)
    call pressed_batch(plane, 200, 1.0e-2_wp, 40.0_wp, 100.0_wp, flat)
    call plane_batch(solid, flat, full)
    call plane%update(flat, tangent_consistent)
    call solid%update(full, tangent_consistent)
    call tests%close('plane stress is that of space', maxval(abs(flat%stress - full%stress(1:4, :))), 0.0_wp, 1.0e-6_wp)
    call tests%close('plane tangent is that of space', maxval(abs(flat%tangent - full%tangent(at, at, :))) &
      /maxval(abs(flat%tangent)), 0.0_wp, 1.0e-7_wp)
  end subroutine check_plane

  !> Both surfaces pass through a stress that was never larger; OCR and POP widen them.
  subroutine check_start(tests)
    type(tests_type), intent(inout) :: tests
    type(hardening_soil_parameters_type) :: p
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp) :: state(2), past(2)
    integer :: k

    p = sand_parameters()
    call make_sand(p, 2, .true., law)
    call law%start(isotropic, state)
    call tests%close('no shear strain of an isotropic stress', state(1), 0.0_wp, 0.0_wp)
    call tests%close('the cap passes through it', state(2), 100.0_wp, 1.0e-10_wp)
    call law%start([-85.2847_wp, -200.0_wp, -85.2847_wp, 0.0_wp], past)
    do k = 1, 2
      p = sand_parameters()
      if (k == 1) p%ocr = 4.0_wp
      if (k == 2) p%pop = 150.0_wp
      call make_sand(p, 2, .true., law)
      call law%start([-25.0_wp, -50.0_wp, -25.0_wp, 0.0_wp], state)
      call tests%close('shear strain of the past', state(1)/past(1), 1.0_wp, 1.0e-5_wp)
      call tests%close('preconsolidation of the past', state(2)/past(2), 1.0_wp, 1.0e-5_wp)
    end do
    call pressed_batch(law, 10, 1.0e-6_wp, 1.0_wp, 50.0_wp, batch)
    call law%update(batch, tangent_none)
    call tests%close('inside them nothing yields', real(sum(batch%plastic), wp), 0.0_wp, 0.0_wp)
  end subroutine check_start

  !> Moduli that no cap can give are refused, and the message says which.
  subroutine check_refusal(tests)
    type(tests_type), intent(inout) :: tests
    type(hardening_soil_parameters_type) :: p
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error

    p = sand_parameters()
    p%eoed = 85000.0_wp
    call new_law(p, 2, kinematics_logarithmic, rate_midpoint, law, error)
    call tests%check('an Eoed that shear alone undercuts is refused', allocated(error))
    if (allocated(error)) call tests%check('by name', index(error%message, 'Eoed') > 0)
    p = sand_parameters()
    p%eur = 50000.0_wp
    call new_law(p, 2, kinematics_logarithmic, rate_midpoint, law, error)
    call tests%check('an Eur below the initial slope is refused', allocated(error))
  end subroutine check_refusal
end module test_hardening_soil
