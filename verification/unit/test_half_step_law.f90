!> A law in two halves a step: what it leaves, and how its difference from one whole step falls.
module test_half_step_law
  use law_trials, only: elastic, strong, make_law, random_batch
  use qsmpm_kinds, only: wp, pi
  use qsmpm_law, only: law_type, batch_type, status_ok, tangent_none
  use qsmpm_law_factory, only: kinematics_logarithmic, kinematics_jaumann, rate_midpoint, rate_paper
  use qsmpm_material_parameters, only: material_parameters_type
  use qsmpm_half_step_law, only: half_step_law_type, make_half_step_law
  use testing, only: tests_type
  implicit none
  private

  public :: collect_half_step_law

contains

  subroutine collect_half_step_law(tests)
    type(tests_type), intent(inout) :: tests
    integer :: d

    call tests%start('halved_law')
    do d = 2, 3
      call check_hyperelastic(tests, d)
      call check_order(tests, 'paper rate', elastic(200.0_wp, 0.33_wp), d, kinematics_jaumann, rate_paper, 2)
      call check_order(tests, 'midpoint rate', elastic(200.0_wp, 0.33_wp), d, kinematics_jaumann, rate_midpoint, 3)
      call check_order(tests, 'return mapping', strong(0.0_wp, -1.0_wp), d, kinematics_logarithmic, rate_midpoint, 2)
    end do
    call check_refusal(tests)
  end subroutine collect_half_step_law

  !> Stress and Q of a hyperelastic law do not know the path. Tolerance: roundings.
  subroutine check_hyperelastic(tests, dimension)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    class(law_type), allocatable :: law
    type(batch_type) :: whole, half
    type(half_step_law_type) :: halved

    call make_law(elastic(200.0_wp, 0.33_wp), dimension, kinematics_logarithmic, rate_midpoint, law)
    call make_half_step_law(law, halved)
    call random_batch(law, 40, 0.3_wp, 20.0_wp, whole)
    half = whole
    call law%update(whole, tangent_none)
    call halved%update(half, tangent_none)
    call tests%check('every point can be walked', all(half%status == status_ok))
    call tests%close('stress of a hyperelastic law', maxval(abs(whole%stress - half%stress)), 0.0_wp, 1.0e-10_wp)
    call tests%close('Q of a hyperelastic law', maxval(abs(whole%piola - half%piola)), 0.0_wp, 1.0e-10_wp)
  end subroutine check_hyperelastic

  !> The difference of one step and two halves falls with the power of the step that a law of its order
  !> promises: 2 for laws of first order, 3 of second. Tolerance: the next power at these steps; points that
  !> change from one plane of the strength to another are in the norm, which the return mapping's 2 survives.
  subroutine check_order(tests, name, parameters, dimension, kinematics, rate, order)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(material_parameters_type), intent(in) :: parameters
    integer, intent(in) :: dimension
    integer, intent(in) :: kinematics
    integer, intent(in) :: rate
    integer, intent(in) :: order
    class(law_type), allocatable :: law
    type(half_step_law_type) :: halved
    real(wp) :: gap(2)
    integer :: k

    call make_law(parameters, dimension, kinematics, rate, law)
    call make_half_step_law(law, halved)
    do k = 1, 2
      gap(k) = largest_gap(law, halved, 4.0e-3_wp/2**k)
    end do
    call tests%close(name//': power of the difference', log(gap(1)/gap(2))/log(2.0_wp), real(order, wp), 0.3_wp)
  end subroutine check_order

  !> Norm of the differences in stress of many points for one size of step, from a state on the strength of
  !> the soil, whose ratio of stresses is (1 + sin 25)/(1 - sin 25).
  real(wp) function largest_gap(law, halved, spread)
    class(law_type), intent(in) :: law
    type(half_step_law_type), intent(in) :: halved
    real(wp), intent(in) :: spread
    real(wp), parameter :: ratio = (1.0_wp + sin(25.0_wp*pi/180.0_wp))/(1.0_wp - sin(25.0_wp*pi/180.0_wp))
    type(batch_type) :: whole, half

    call random_batch(law, 200, spread, 0.0_wp, whole)
    whole%stress_start(1:3, :) = -2.0_wp
    whole%stress_start(3, :) = -4.0_wp
    whole%stress_start(2, :) = -(2.0_wp*ratio + 2.0_wp*sqrt(ratio))
    call start_again(law, whole)
    half = whole
    call law%update(whole, tangent_none)
    call halved%update(half, tangent_none)
    largest_gap = norm2(whole%stress - half%stress)
  end function largest_gap

  !> State of the start stresses, at volume ratio 1.
  subroutine start_again(law, batch)
    class(law_type), intent(in) :: law
    type(batch_type), intent(inout) :: batch
    integer :: p

    batch%volume_ratio = 1.0_wp
    do p = 1, batch%count
      call law%start(batch%stress_start(:, p), batch%state_start(:, p))
    end do
  end subroutine start_again

  !> A point turned inside out is refused by either.
  subroutine check_refusal(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(half_step_law_type) :: halved
    type(batch_type) :: batch

    call make_law(elastic(1.0_wp, 0.2_wp), 2, kinematics_logarithmic, rate_midpoint, law)
    call make_half_step_law(law, halved)
    call random_batch(law, 3, 0.1_wp, 0.0_wp, batch)
    batch%gradient(1, 2) = -1.0_wp
    call halved%update(batch, tangent_none)
    call tests%check('a point inside out has a status', batch%status(2) /= status_ok)
  end subroutine check_refusal
end module test_half_step_law
