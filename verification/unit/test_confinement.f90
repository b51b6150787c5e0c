!> The all-round pressure: Q of a slot against that of its law, its A against differences; the stress is that of the law.
module test_confinement
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_slot_type, batch_type, tangent_consistent, tangent_none
  use qsmpm_law_factory, only: kinematics_logarithmic, rate_midpoint
  use qsmpm_tensor, only: cofactor, pack_gradient, unpack_gradient
  use law_trials, only: elastic, make_law, random_batch
  use testing, only: tests_type
  implicit none
  private

  public :: collect_confinement

  real(wp), parameter :: difference = 1.0e-6_wp, pressure = 70.0_wp

contains

  !> All checks.
  subroutine collect_confinement(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('confinement')
    call check_slot(tests, 'plane', 2)
    call check_slot(tests, '3D', 3)
  end subroutine collect_confinement

  !> A law in a slot with a pressure.
  subroutine check_slot(tests, what, dimension)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: what
    integer, intent(in) :: dimension
    type(law_slot_type) :: slot
    type(batch_type) :: batch, plain, forward, backward
    real(wp), allocatable :: slope(:), push(:)
    integer :: j

    call make_law(elastic(100.0_wp, 0.3_wp), dimension, kinematics_logarithmic, rate_midpoint, slot%law)
    call random_batch(slot%law, 1, 0.05_wp, 1.0_wp, batch)
    plain = batch
    call slot%update(plain, tangent_consistent)
    slot%confinement = pressure
    call slot%update(batch, tangent_consistent)
    call tests%check(what//': the stress is that of the law', all(abs(batch%stress - plain%stress) <= 0.0_wp))
    allocate (push, mold=batch%piola(:, 1))
    call pack_gradient(pressure*cofactor(unpack_gradient(batch%gradient(:, 1))), push)
    call tests%close(what//': Q is above the pressure', maxval(abs(batch%piola(:, 1) - plain%piola(:, 1) - push)), &
      0.0_wp, 1.0e-13_wp)
    do j = 1, size(batch%gradient, 1)
      forward = batch
      backward = batch
      forward%gradient(j, 1) = forward%gradient(j, 1) + difference
      backward%gradient(j, 1) = backward%gradient(j, 1) - difference
      call slot%update(forward, tangent_none)
      call slot%update(backward, tangent_none)
      slope = (forward%piola(:, 1) - backward%piola(:, 1))/(2.0_wp*difference)
      ! Differences of second order of a law with a modulus of 100.
      call tests%close(what//': a column of A', maxval(abs(batch%tangent(:, j, 1) - slope)), 0.0_wp, 1.0e-6_wp)
    end do
  end subroutine check_slot
end module test_confinement
