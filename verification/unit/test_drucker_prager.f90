!> Drucker-Prager: the return to cone and apex against its closed form, its derivative against differences, the strength
!> of Mohr-Coulomb where the cone is matched to it, and the law in both kinematics, plane and space.
module test_drucker_prager
  use law_trials, only: difference_error
  use qsmpm_drucker_prager, only: drucker_prager_parameters_type, cone_compression, cone_extension, cone_plane_strain
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp, pi
  use qsmpm_law, only: law_type, batch_type, status_ok, tangent_consistent
  use qsmpm_law_factory, only: new_law, kinematics_jaumann, kinematics_logarithmic, rate_midpoint
  use qsmpm_principal_model, only: principal_model_type, stress_update_type
  use soil_trials, only: pressed_batch
  use testing, only: tests_type
  implicit none
  private

  public :: collect_drucker_prager

  real(wp), parameter :: cohesion = 1.0_wp, friction = 25.0_wp, dilatancy = 5.0_wp

contains

  subroutine collect_drucker_prager(tests)
    type(tests_type), intent(inout) :: tests
    integer :: cone, d, k

    call tests%start('drucker_prager')
    do cone = cone_compression, cone_plane_strain
      call check_cone(tests, cone)
      call check_derivative(tests, cone)
    end do
    call check_apex(tests)
    call check_strength(tests)
    do d = 2, 3
      do k = 0, 1
        call check_law(tests, d, k == 1)
      end do
    end do
    call check_refusal(tests)
  end subroutine collect_drucker_prager

  !> E = 200, nu = 0.3, c = 1, phi = 25, psi as given.
  pure function soil(cone, psi) result(p)
    integer, intent(in) :: cone
    real(wp), intent(in) :: psi
    type(drucker_prager_parameters_type) :: p

    p%young = 200.0_wp
    p%poisson = 0.3_wp
    p%cohesion = cohesion
    p%friction_angle = friction
    p%dilatancy_angle = psi
    p%cone = cone
  end function soil

  !> Stress of a trial, and whether it yields.
  subroutine return_of(p, trial, result, strain)
    type(drucker_prager_parameters_type), intent(in) :: p
    real(wp), intent(in) :: trial(3)
    type(stress_update_type), intent(inout) :: result
    !> Plastic strain, or none.
    real(wp), intent(out), optional :: strain(3)
    class(principal_model_type), allocatable :: model
    type(error_type), allocatable :: error
    real(wp) :: none(0)

    call p%make_model(model, error)
    call model%update(model%shear, trial, none, 0.0_wp, .true., result)
    if (.not. result%yields) result%stress = trial
    if (present(strain)) strain = model%elastic_strain(model%shear, trial - result%stress)
  end subroutine return_of

  !> From a trial in triaxial compression the stress lies on the cone, found from a stress that is known to lie there,
  !> and the plastic strain is normal to the potential: volume over |shear| is 2 x 3 b of the cone of psi.
  subroutine check_cone(tests, cone)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: cone
    type(stress_update_type) :: result
    real(wp) :: strain(3), deviator(3), trial(3), scale, b, a, k

    call cone_of(cone, friction, dilatancy, a, b, k)
    trial = [-1.0_wp, -3.0_wp, -9.0_wp]
    call return_of(soil(cone, dilatancy), trial, result, strain)
    call tests%check('the trial yields', result%yields)
    deviator = result%stress - sum(result%stress)/3.0_wp
    scale = sqrt(0.5_wp*sum(deviator**2))
    call tests%close('the stress is on the cone', scale + a*sum(result%stress), k, 1.0e-13_wp)
    call tests%close('volume change of the flow', sum(strain), &
      6.0_wp*b*sqrt(0.5_wp*sum((strain - sum(strain)/3.0_wp)**2)), 1.0e-15_wp)
    call tests%check('the flow is along the deviator', &
      maxval(abs((strain - sum(strain)/3.0_wp)*sum(deviator**2) - deviator*sum(deviator*strain))) < 1.0e-13_wp)
    call tests%check('and loads', sum(deviator*strain) > 0.0_wp)
    call return_of(soil(cone, dilatancy), 0.999_wp*result%stress, result)
    call tests%check('a stress inside does not yield', .not. result%yields)
  end subroutine check_cone

  !> a, b and k of a cone: in triaxial tests in closed form, in plane strain by two circles of Mohr at failure, with the
  !> stress along 3 that does not flow.
  pure subroutine cone_of(cone, phi, psi, a, b, k)
    integer, intent(in) :: cone
    real(wp), intent(in) :: phi, psi
    real(wp), intent(out) :: a, b, k
    real(wp) :: s, q(2), level(2), centre
    integer :: i

    if (cone == cone_plane_strain) then
      b = tan(psi*pi/180.0_wp)/sqrt(9.0_wp + 12.0_wp*tan(psi*pi/180.0_wp)**2)
      ! Two circles at failure, with centres -10 and -20: J^1/2 = k - a I.
      do i = 1, 2
        centre = -10.0_wp*i
        q(i) = (cohesion*cos(phi*pi/180.0_wp) - centre*sin(phi*pi/180.0_wp))/sqrt(1.0_wp - 3.0_wp*b**2)
        level(i) = 3.0_wp*centre - 3.0_wp*b*q(i)
      end do
      a = (q(1) - q(2))/(level(2) - level(1))
      k = q(1) + a*level(1)
    else
      s = merge(-1.0_wp, 1.0_wp, cone == cone_compression)
      a = 2.0_wp*sin(phi*pi/180.0_wp)/(sqrt(3.0_wp)*(3.0_wp + s*sin(phi*pi/180.0_wp)))
      b = 2.0_wp*sin(psi*pi/180.0_wp)/(sqrt(3.0_wp)*(3.0_wp + s*sin(psi*pi/180.0_wp)))
      k = 6.0_wp*cohesion*cos(phi*pi/180.0_wp)/(sqrt(3.0_wp)*(3.0_wp + s*sin(phi*pi/180.0_wp)))
    end if
  end subroutine cone_of

  !> d stress / d trial against central differences, on the cone and at the apex; symmetric where flow is associated.
  subroutine check_derivative(tests, cone)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: cone
    real(wp), parameter :: trials(3, 3) = reshape([-1.0_wp, -3.0_wp, -9.0_wp, 4.0_wp, 1.0_wp, 0.5_wp, &
      9.0_wp, 8.0_wp, 8.5_wp], [3, 3]), h = 1.0e-5_wp
    type(stress_update_type) :: result, up, down
    real(wp) :: step(3)
    integer :: i, j

    do i = 1, 3
      call return_of(soil(cone, dilatancy), trials(:, i), result)
      do j = 1, 3
        step = 0.0_wp
        step(j) = h
        call return_of(soil(cone, dilatancy), trials(:, i) + step, up)
        call return_of(soil(cone, dilatancy), trials(:, i) - step, down)
        call tests%check('derivative', result%yields .and. &
          maxval(abs((up%stress - down%stress)/(2.0_wp*h) - result%derivative(:, j))) < 1.0e-9_wp)
      end do
    end do
    call return_of(soil(cone, friction), trials(:, 1), result)
    call tests%close('associated flow has a symmetric tangent', asymmetry(result%derivative), 0.0_wp, 1.0e-14_wp)
    call return_of(soil(cone, 0.0_wp), trials(:, 1), result)
    call tests%check('other flow has not', asymmetry(result%derivative) > 0.01_wp)
  end subroutine check_derivative

  !> Asymmetry of the derivative by the strain, over 2 G: the trial is D times the strain, D = 2 G (I + nu/(1 - 2 nu)).
  pure real(wp) function asymmetry(derivative)
    real(wp), intent(in) :: derivative(3, 3)
    real(wp) :: by_strain(3, 3)

    by_strain = derivative + spread(sum(derivative, 2), 2, 3)*0.3_wp/(1.0_wp - 0.6_wp)
    asymmetry = maxval(abs(by_strain - transpose(by_strain)))
  end function asymmetry

  !> Beyond the apex the stress is c cot(phi) on all sides, whatever the trial and the dilatancy.
  subroutine check_apex(tests)
    type(tests_type), intent(inout) :: tests
    type(stress_update_type) :: result
    real(wp) :: apex

    apex = cohesion/tan(friction*pi/180.0_wp)
    call return_of(soil(cone_compression, dilatancy), [9.0_wp, 8.0_wp, 8.5_wp], result)
    call tests%check('the stress is at the apex', maxval(abs(result%stress - apex)) < 1.0e-14_wp)
    call tests%check('and stays there', maxval(abs(result%derivative)) <= 0.0_wp)
    call return_of(soil(cone_extension, 0.0_wp), [3.0_wp, 3.0_wp, 3.0_wp], result)
    call tests%check('without dilatancy, too', maxval(abs(result%stress - apex)) < 1.0e-14_wp)
  end subroutine check_apex

  !> Mohr-Coulomb failure with a cell pressure of 100 in triaxial compression and extension lies on the cone of each: a
  !> little less does not yield, a little more does.
  subroutine check_strength(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: share(2) = [1.0_wp - 1.0e-9_wp, 1.0_wp + 1.0e-9_wp], cell = 100.0_wp
    type(stress_update_type) :: result
    real(wp) :: ratio, high, low
    integer :: i

    ratio = (1.0_wp + sin(friction*pi/180.0_wp))/(1.0_wp - sin(friction*pi/180.0_wp))
    high = cell*ratio + 2.0_wp*cohesion*sqrt(ratio)
    low = (cell - 2.0_wp*cohesion*sqrt(ratio))/ratio
    do i = 1, 2
      call return_of(soil(cone_compression, 0.0_wp), -[cell, cell + share(i)*(high - cell), cell], result)
      call tests%check('triaxial compression', result%yields .eqv. i == 2)
      call return_of(soil(cone_extension, 0.0_wp), -[cell, cell + share(i)*(low - cell), cell], result)
      call tests%check('triaxial extension', result%yields .eqv. i == 2)
    end do
  end subroutine check_strength

  !> The law's tangent against differences.
  subroutine check_law(tests, dimension, logarithmic)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    logical, intent(in) :: logarithmic
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error
    type(batch_type) :: batch
    real(wp), allocatable :: tangent(:, :, :)
    real(wp) :: difference
    integer :: compared

    call new_law(soil(cone_compression, dilatancy), dimension, merge(kinematics_logarithmic, kinematics_jaumann, &
      logarithmic), rate_midpoint, law, error)
    call tests%check('there is a law', .not. allocated(error))
    call pressed_batch(law, 200, 0.02_wp, 1.0_wp, 5.0_wp, batch)
    call law%update(batch, tangent_consistent)
    call tests%check('every point has an answer', all(batch%status == status_ok))
    call tests%check('some yield, some do not', sum(batch%plastic) > 20 .and. sum(batch%plastic) < 180)
    allocate (tangent, source=batch%tangent)
    call difference_error(law, batch, tangent, difference, compared)
    call tests%close('tangent', difference, 0.0_wp, 5.0e-8_wp)
    call tests%check('nearly all columns were compared', compared > 95*size(batch%piola)/100)
  end subroutine check_law

  !> Parameters that do not go together are refused by name.
  subroutine check_refusal(tests)
    type(tests_type), intent(inout) :: tests
    class(principal_model_type), allocatable :: model
    type(error_type), allocatable :: error
    type(drucker_prager_parameters_type) :: p

    p = soil(cone_compression, 30.0_wp)
    call p%make_model(model, error)
    call tests%check('dilatancy above friction is refused', allocated(error))
    if (allocated(error)) call tests%check('by name', index(error%message, 'dilatancy') > 0)
  end subroutine check_refusal
end module test_drucker_prager
