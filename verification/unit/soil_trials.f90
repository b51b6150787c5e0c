!> What the tests of soils share: parameters of hardening ones, laboratory tests on one point, batches of points under
!> pressure, and what is refused.
module soil_trials
  use point_trials, only: step_point
  use law_trials, only: random_batch
  use qsmpm_error, only: error_type
  use qsmpm_cam_clay, only: cam_clay_parameters_type
  use qsmpm_hardening_soil, only: hardening_soil_parameters_type
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type, batch_type
  use qsmpm_law_factory, only: new_law, kinematics_jaumann, kinematics_logarithmic, rate_midpoint
  use qsmpm_law_parameters, only: law_parameters_type
  use qsmpm_point_driver, only: point_type, start_point
  use testing, only: tests_type
  implicit none
  private

  public :: clay_parameters, sand_parameters, make_clay, make_sand, pressed_batch, press, compress, triaxial, oedometer, &
    expect_refusal

contains

  !> Parameters are refused with a sentence.
  subroutine expect_refusal(tests, name, parameters, sentence)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name, sentence
    class(law_parameters_type), intent(in) :: parameters
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error
    logical :: right

    call new_law(parameters, 2, kinematics_jaumann, rate_midpoint, law, error)
    right = allocated(error)
    if (right) right = index(error%message, sentence) > 0
    call tests%check('refused: '//name, right)
  end subroutine expect_refusal

  !> M = 1, lambda = 0.2, kappa = 0.04, v0 = 2.2, nu = 0.3.
  pure function clay_parameters() result(p)
    type(cam_clay_parameters_type) :: p

    p%slope = 1.0_wp
    p%lambda = 0.2_wp
    p%kappa = 0.04_wp
    p%volume = 2.2_wp
    p%poisson = 0.3_wp
  end function clay_parameters

  !> A dense sand: E50 = Eoed = 30 MPa, Eur = 90 MPa, m = 0.5, phi = 35, psi = 5, K0nc = 1 - sin phi.
  pure function sand_parameters() result(p)
    type(hardening_soil_parameters_type) :: p

    p%e50 = 30000.0_wp
    p%eoed = 30000.0_wp
    p%eur = 90000.0_wp
    p%power = 0.5_wp
    p%friction_angle = 35.0_wp
    p%dilatancy_angle = 5.0_wp
  end function sand_parameters

  !> A clay's law that must exist.
  subroutine make_clay(p, dimension, logarithmic, law)
    type(cam_clay_parameters_type), intent(in) :: p
    integer, intent(in) :: dimension
    logical, intent(in) :: logarithmic
    class(law_type), allocatable, intent(out) :: law
    type(error_type), allocatable :: error

    call new_law(p, dimension, merge(kinematics_logarithmic, kinematics_jaumann, logarithmic), rate_midpoint, law, error)
  end subroutine make_clay

  !> A sand's law that must exist.
  subroutine make_sand(p, dimension, logarithmic, law)
    type(hardening_soil_parameters_type), intent(in) :: p
    integer, intent(in) :: dimension
    logical, intent(in) :: logarithmic
    class(law_type), allocatable, intent(out) :: law
    type(error_type), allocatable :: error

    call new_law(p, dimension, merge(kinematics_logarithmic, kinematics_jaumann, logarithmic), rate_midpoint, law, error)
  end subroutine make_sand

  !> Pseudo-random points: gradients within `spread` of I, stresses within `scatter` of a pressure.
  subroutine pressed_batch(law, n, spread, scatter, pressure, batch)
    class(law_type), intent(in) :: law
    integer, intent(in) :: n
    real(wp), intent(in) :: spread
    real(wp), intent(in) :: scatter
    real(wp), intent(in) :: pressure
    type(batch_type), intent(out) :: batch

    call random_batch(law, n, spread, scatter, batch)
    call press(law, pressure, batch)
  end subroutine pressed_batch

  !> Add a pressure to the stresses of a batch.
  subroutine press(law, pressure, batch)
    class(law_type), intent(in) :: law
    real(wp), intent(in) :: pressure
    type(batch_type), intent(inout) :: batch
    integer :: i

    batch%stress_start(1:3, :) = batch%stress_start(1:3, :) - pressure
    do i = 1, batch%count
      call law%start(batch%stress_start(:, i), batch%state_start(:, i))
    end do
  end subroutine press

  !> Stretch a point of a plane law along 2 by a factor in n steps, with factors of the other directions.
  subroutine compress(law, point, axial, radial, n)
    class(law_type), intent(in) :: law
    type(point_type), intent(inout) :: point
    real(wp), intent(in) :: axial
    real(wp), intent(in) :: radial
    integer, intent(in) :: n
    type(error_type), allocatable :: error
    real(wp) :: values(5)
    integer :: i

    values = [radial**(1.0_wp/n), 0.0_wp, 0.0_wp, axial**(1.0_wp/n), radial**(1.0_wp/n)]
    do i = 1, n
      call step_point(law, point, [.true., .true., .true., .true., .true.], values, error)
      if (allocated(error)) return
    end do
  end subroutine compress

  !> Confined compression along 2.
  subroutine oedometer(law, point, axial, n)
    class(law_type), intent(in) :: law
    type(point_type), intent(inout) :: point
    real(wp), intent(in) :: axial
    integer, intent(in) :: n

    call compress(law, point, axial, 1.0_wp, n)
  end subroutine oedometer

  !> Raise the axial stress of a point from where it is at a constant cell pressure, in n equal steps of stress.
  subroutine triaxial(law, point, cell, axial, n, error)
    class(law_type), intent(in) :: law
    type(point_type), intent(inout) :: point
    !> Radial and axial stress at the end.
    real(wp), intent(in) :: cell
    real(wp), intent(in) :: axial
    integer, intent(in) :: n
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: values(5), start
    integer :: i

    start = point%stress(2)
    do i = 1, n
      values = [cell, 0.0_wp, 0.0_wp, start + (axial - start)*i/n, cell]
      call step_point(law, point, [.false., .true., .true., .false., .false.], values, error)
      if (allocated(error)) return
    end do
  end subroutine triaxial
end module soil_trials
