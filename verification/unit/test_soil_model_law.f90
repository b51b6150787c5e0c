!> The law of a soil model: its tangent by differences, simple shear, a rigid turn, what the points carry, plane
!> and space, and refusals.
module test_soil_model_law
  use point_trials, only: step_point
  use law_trials, only: make_batch, random_batch, plane_batch, difference_error
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp, pi
  use qsmpm_law, only: batch_type, status_ok, status_cut, status_failed, status_unrecoverable, tangent_none, &
    tangent_consistent, tangent_elastic
  use qsmpm_point_driver, only: point_type, start_point
  use qsmpm_soil_model, only: soil_model_type
  use qsmpm_soil_model_law, only: soil_model_law_type, make_soil_model_law
  use qsmpm_tensor, only: unpack_symmetric, unpack_gradient
  use soil_samples, only: hooke_type, refusing_type, make_hooke
  use testing, only: tests_type
  implicit none
  private

  public :: collect_soil_model_law

  !> Every component is prescribed.
  logical, parameter :: all_given(9) = .true.

contains

  subroutine collect_soil_model_law(tests)
    type(tests_type), intent(inout) :: tests
    integer :: dimension

    call tests%start('soil_model_law')
    do dimension = 2, 3
      call check_tangent(tests, 'Hooke', dimension, 0.0_wp, 0.0_wp)
      call check_tangent(tests, 'stiffness with the stress', dimension, 0.0_wp, 30.0_wp)
      call check_elastic_tangent(tests, dimension)
    end do
    ! A fibre along (2, 1, 2) does not stay in the plane.
    call check_tangent(tests, 'fibre that turns', 3, 500.0_wp, 30.0_wp)
    call check_shear(tests)
    call check_turn(tests)
    call check_carried(tests)
    call check_plane(tests)
    call check_refusals(tests)
  end subroutine collect_soil_model_law

  !> A against central differences at points that are strained and turned by up to 0.1, with stresses of up to half
  !> of Young's modulus so that the terms of the rotation weigh. Truncation and round-off of the differences are
  !> below 1e-8 of the largest component.
  subroutine check_tangent(tests, name, dimension, fibre, growth)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    integer, intent(in) :: dimension
    real(wp), intent(in) :: fibre
    real(wp), intent(in) :: growth
    type(hooke_type) :: model
    type(soil_model_law_type) :: law
    type(batch_type) :: batch
    real(wp) :: error
    integer :: compared

    call make_hooke(fibre, growth, model)
    call make_soil_model_law(model, dimension, law)
    call random_batch(law, 50, 0.1_wp, 100.0_wp, batch)
    call law%update(batch, tangent_consistent)
    call difference_error(law, batch, batch%tangent, error, compared)
    call tests%check(name//': all points are compared', compared > 40*merge(5, 9, dimension == 2))
    call tests%close(name//': tangent is the derivative', error, 0.0_wp, 1.0e-7_wp)
  end subroutine check_tangent

  !> At F = I the elastic tangent is symmetric and, without the volume term, the derivative.
  subroutine check_elastic_tangent(tests, dimension)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    type(hooke_type) :: model
    type(soil_model_law_type) :: law
    type(batch_type) :: batch
    real(wp) :: a(9, 9), s(9), d, largest
    integer :: p, i, j, n

    call make_hooke(0.0_wp, 0.0_wp, model)
    call make_soil_model_law(model, dimension, law)
    call random_batch(law, 10, 0.0_wp, 100.0_wp, batch)
    n = size(batch%tangent, 1)
    call law%update(batch, tangent_elastic)
    largest = 0.0_wp
    d = 0.0_wp
    do p = 1, batch%count
      a(:n, :n) = batch%tangent(:, :, p)
      largest = max(largest, maxval(abs(a(:n, :n) - transpose(a(:n, :n)))))
    end do
    call tests%close('the elastic tangent is symmetric', largest, 0.0_wp, 1.0e-12_wp)
    if (dimension == 2) return
    a = batch%tangent(:, :, 1)
    s = reshape(unpack_symmetric(batch%stress_start(:, 1)), [9])
    call law%update(batch, tangent_consistent)
    ! The consistent one has sigma_ij delta_kl more.
    do i = 1, 9
      do j = 1, 9, 4
        d = max(d, abs(batch%tangent(i, j, 1) - a(i, j) - s(i)))
      end do
    end do
    call tests%close('the elastic tangent lacks the volume term', d, 0.0_wp, 1.0e-11_wp)
  end subroutine check_elastic_tangent

  !> Simple shear: s12 = G sin g, s11 = G (1 - cos g), of second order: 3.0e-5 at g = 2 in 100 steps.
  subroutine check_shear(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: coarse(6), fine(6), exact

    coarse = sheared(2.0_wp, 100)
    fine = sheared(2.0_wp, 200)
    exact = sin(2.0_wp)
    call tests%close('shear stress of simple shear', fine(4), exact, 1.0e-5_wp)
    call tests%close('normal stress of simple shear', fine(1), 1.0_wp - cos(2.0_wp), 1.0e-5_wp)
    call tests%close('second order', (coarse(4) - exact)/(fine(4) - exact), 4.0_wp, 0.02_wp)
  end subroutine check_shear

  !> Stress over G after simple shear.
  function sheared(shear, steps) result(stress)
    real(wp), intent(in) :: shear
    integer, intent(in) :: steps
    real(wp) :: stress(6)
    type(hooke_type) :: model
    type(soil_model_law_type) :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    integer :: i

    call make_hooke(0.0_wp, 0.0_wp, model)
    call make_soil_model_law(model, 3, law)
    call start_point(law, [(0.0_wp, i=1, 6)], point)
    do i = 1, steps
      call step_point(law, point, all_given, [1.0_wp, 0.0_wp, 0.0_wp, shear/steps, 1.0_wp, 0.0_wp, 0.0_wp, &
        0.0_wp, 1.0_wp], error)
    end do
    stress = point%stress/model%shear_scale
  end function sheared

  !> 90 degrees about (1, 2, 2)/3 in 9 steps: stress and fibre end where the rotation brings them, up to
  !> round-off of the steps.
  subroutine check_turn(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: axis(3) = [1.0_wp, 2.0_wp, 2.0_wp]/3.0_wp
    real(wp), parameter :: first(6) = [-100.0_wp, -40.0_wp, -70.0_wp, 20.0_wp, -10.0_wp, 5.0_wp]
    type(hooke_type) :: model
    type(soil_model_law_type) :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: r(3, 3), s(3, 3), m(3, 3)
    integer :: i

    call make_hooke(500.0_wp, 1.0_wp, model)
    call make_soil_model_law(model, 3, law)
    call start_point(law, first, point)
    m = unpack_symmetric(point%state(16:21))
    r = rotation(axis, pi/18.0_wp)
    do i = 1, 9
      call step_point(law, point, all_given, [r], error)
    end do
    r = rotation(axis, 0.5_wp*pi)
    s = matmul(r, matmul(unpack_symmetric(first), transpose(r)))
    call tests%close('a rigid turn turns the stress', maxval(abs(unpack_symmetric(point%stress) - s)), 0.0_wp, &
      1.0e-12_wp*100.0_wp)
    s = matmul(r, matmul(m, transpose(r)))
    call tests%close('and the tensor of the state', maxval(abs(unpack_symmetric(point%state(16:21)) - s)), 0.0_wp, &
      1.0e-13_wp)
    call tests%close('and strains nothing', maxval(abs(point%state(10:15))), 0.0_wp, 1.0e-14_wp)
  end subroutine check_turn

  !> Rotation about an axis.
  pure function rotation(axis, angle) result(r)
    real(wp), intent(in) :: axis(3)
    real(wp), intent(in) :: angle
    real(wp) :: r(3, 3)
    real(wp) :: w(3, 3)
    integer :: i

    w(:, 1) = [0.0_wp, axis(3), -axis(2)]
    w(:, 2) = [-axis(3), 0.0_wp, axis(1)]
    w(:, 3) = [axis(2), -axis(1), 0.0_wp]
    r = sin(angle)*w + (1.0_wp - cos(angle))*matmul(w, w)
    do i = 1, 3
      r(i, i) = r(i, i) + 1.0_wp
    end do
  end function rotation

  !> The points carry the deformation gradient and a strain that is near the logarithmic one.
  subroutine check_carried(tests)
    type(tests_type), intent(inout) :: tests
    type(hooke_type) :: model
    type(soil_model_law_type) :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: step(9)
    integer :: i

    call make_hooke(0.0_wp, 0.0_wp, model)
    call make_soil_model_law(model, 3, law)
    call tests%check('gradient, strain and own state are carried', law%state_count == 21)
    call start_point(law, [(0.0_wp, i=1, 6)], point)
    step = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.01_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp]
    do i = 1, 20
      call step_point(law, point, all_given, step, error)
    end do
    call tests%close('the gradient is the product of the steps', point%state(5), 1.01_wp**20, 1.0e-13_wp)
    call tests%close('the others stay', maxval(abs(point%state([2, 3, 4, 6, 7, 8]))), 0.0_wp, 1.0e-15_wp)
    ! 20 times 0.01/1.005 and the logarithm differ by 20/12 1e-6.
    call tests%close('the strain is the logarithmic one but for 1e-6', point%state(11), 20.0_wp*log(1.01_wp), &
      2.0e-6_wp)
  end subroutine check_carried

  !> The plane is space with nothing across.
  subroutine check_plane(tests)
    type(tests_type), intent(inout) :: tests
    integer, parameter :: at(5) = [1, 2, 4, 5, 9]
    type(hooke_type) :: model
    type(soil_model_law_type) :: flat, solid
    type(batch_type) :: plane, space

    call make_hooke(0.0_wp, 10.0_wp, model)
    call make_soil_model_law(model, 2, flat)
    call make_soil_model_law(model, 3, solid)
    call random_batch(flat, 20, 0.1_wp, 10.0_wp, plane)
    call plane_batch(solid, plane, space)
    call flat%update(plane, tangent_consistent)
    call solid%update(space, tangent_consistent)
    call tests%close('plane stress components', maxval(abs(plane%stress - space%stress(1:4, :))), 0.0_wp, 1.0e-13_wp)
    call tests%close('plane first Piola stress', maxval(abs(plane%piola - space%piola(at, :))), 0.0_wp, 1.0e-13_wp)
    call tests%close('plane tangent', maxval(abs(plane%tangent - space%tangent(at, at, :))), 0.0_wp, 1.0e-11_wp)
  end subroutine check_plane

  !> Share, sentence and place are passed on; NaN is a failure with a sentence.
  subroutine check_refusals(tests)
    type(tests_type), intent(inout) :: tests
    type(refusing_type) :: model
    type(batch_type) :: batch

    model%share = 0.25_wp
    call refuse(model, batch)
    call tests%check('a cut is passed on', batch%status(1) == status_cut)
    call tests%close('its share is', batch%share, 0.25_wp, 0.0_wp)
    model%nan = .true.
    call refuse(model, batch)
    call tests%check('NaN is a failure', batch%status(1) == status_failed)
    call tests%check('that names the material', index(batch%message, "'sand'") > 0)
    call tests%check('the point', index(batch%message, 'material point 7') > 0)
    call tests%check('and the step', index(batch%message, 'phase 2, step 11') > 0)
    call tests%check('nothing that is not a number is left', abs(batch%stress(2, 1)) < 1.0_wp)
    model%nan = .false.
    model%status = status_unrecoverable
    call refuse(model, batch)
    call tests%check('a broken model is passed on', batch%status(1) == status_unrecoverable)
    call tests%check('with what it says', index(batch%message, 'it is out of order') > 0)
  end subroutine check_refusals

  !> Ask a refusing model.
  subroutine refuse(model, batch)
    class(soil_model_type), intent(in) :: model
    type(batch_type), intent(out) :: batch
    type(soil_model_law_type) :: law

    call make_soil_model_law(model, 2, law)
    law%name = 'sand'
    call make_batch(law, 1, batch)
    allocate (batch%number(1), source=7)
    allocate (batch%cell(1), source=3)
    allocate (batch%place(2, 1), source=0.0_wp)
    allocate (batch%cell_size(1), source=1.0_wp)
    batch%step_info%phase = 2
    batch%step_info%step = 11
    call law%update(batch, tangent_none)
    call law%update(batch, tangent_consistent)
  end subroutine refuse
end module test_soil_model_law
