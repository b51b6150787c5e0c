!> Softening strength: closed forms of one point, tangents by differences, energy of a band, refusal of snap-back.
module test_softening
  use point_trials, only: step_point
  use law_trials, only: strong, elastic, make_law, make_batch, random_batch, compare_plane, difference_error
  use qsmpm_kinds, only: wp, pi
  use qsmpm_error, only: error_type
  use qsmpm_law, only: law_type, batch_type, status_ok, status_failed, tangent_consistent, tangent_elastic, tangent_none
  use qsmpm_law_factory, only: kinematics_jaumann, kinematics_logarithmic, rate_midpoint, new_law
  use qsmpm_material_parameters, only: material_parameters_type, check_parameters, softening_parameters_type, &
    softening_linear, softening_exponential, regularise_none, regularise_cell
  use qsmpm_point_driver, only: point_type, start_point
  use qsmpm_softening, only: degree_of, strain_of_degree
  use qsmpm_softening_model, only: softening_model_type, set_softening, largest_band_ratio
  use testing, only: tests_type
  implicit none
  private

  public :: collect_softening

  real(wp), parameter :: diagonal(5) = [1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp]

contains

  subroutine collect_softening(tests)
    type(tests_type), intent(inout) :: tests
    integer :: d, kinematics

    call tests%start('softening')
    call check_ranges(tests)
    call check_degree(tests)
    do kinematics = kinematics_jaumann, kinematics_logarithmic
      call check_shear(tests, kinematics, softening_linear)
      call check_shear(tests, kinematics, softening_exponential)
      call check_energy(tests, kinematics)
      call check_triaxial(tests, kinematics)
      call check_snap_back(tests, kinematics)
      call check_plane(tests, kinematics)
      call check_order(tests, kinematics)
      call check_fields(tests, kinematics)
      call check_peak(tests, kinematics)
      do d = 2, 3
        call check_tangent(tests, 'Tresca', soft(strong_tresca(), 0.2_wp, 0.0_wp, 0.0_wp), d, kinematics)
        call check_tangent(tests, 'psi = 0', soft(strong(0.0_wp, -1.0_wp), 0.2_wp, 15.0_wp, 0.0_wp), d, kinematics)
        call check_tangent(tests, 'psi falls', soft(strong(10.0_wp, -1.0_wp), 0.1_wp, 20.0_wp, 0.0_wp), d, kinematics)
        call check_tangent(tests, 'cut-off', soft(strong(5.0_wp, 0.5_wp), 0.3_wp, 20.0_wp, 0.0_wp), d, kinematics)
        call check_tangent(tests, 'exponential', exponential(soft(strong(10.0_wp, -1.0_wp), 0.1_wp, 18.0_wp, 0.0_wp)), &
          d, kinematics)
      end do
    end do
  end subroutine collect_softening

  !> Tresca with c = 1 on the slope's elasticity.
  pure function strong_tresca() result(p)
    type(material_parameters_type) :: p

    p = strong(0.0_wp, -1.0_wp)
    p%friction_angle = 0.0_wp
  end function strong_tresca

  !> A material that softens to c, phi, psi over a plastic shear strain of 0.4 in a band of width 1.
  pure function soft(p, c, phi, psi) result(q)
    type(material_parameters_type), intent(in) :: p
    real(wp), intent(in) :: c, phi, psi
    type(material_parameters_type) :: q

    q = p
    q%softening = softening_parameters_type(given=.true., shape=softening_linear, regularisation=regularise_cell, &
      cohesion=c, friction_angle=phi, dilatancy_angle=psi, strain=0.4_wp, length=1.0_wp)
  end function soft

  !> The same, falling exponentially.
  pure function exponential(p) result(q)
    type(material_parameters_type), intent(in) :: p
    type(material_parameters_type) :: q

    q = p
    q%softening%shape = softening_exponential
  end function exponential

  !> Place of kappa among the state variables.
  pure integer function place_of_kappa(d, kinematics)
    integer, intent(in) :: d
    integer, intent(in) :: kinematics

    place_of_kappa = 1
    if (kinematics == kinematics_logarithmic) place_of_kappa = merge(5, 7, d == 2)
  end function place_of_kappa

  !> Residual values above the peak, no strength left, no strain, no length.
  subroutine check_ranges(tests)
    type(tests_type), intent(inout) :: tests

    call tests%check('a sound softening is accepted', accepted(soft(strong(10.0_wp, -1.0_wp), 0.1_wp, 20.0_wp, 5.0_wp)))
    call tests%check('a residual cohesion above the peak is refused', &
      .not. accepted(soft(strong(0.0_wp, -1.0_wp), 1.1_wp, 20.0_wp, 0.0_wp)))
    call tests%check('a residual friction angle above the peak is refused', &
      .not. accepted(soft(strong(0.0_wp, -1.0_wp), 0.5_wp, 26.0_wp, 0.0_wp)))
    call tests%check('a residual dilatancy angle above the peak is refused', &
      .not. accepted(soft(strong(5.0_wp, -1.0_wp), 0.5_wp, 20.0_wp, 6.0_wp)))
    call tests%check('a residual dilatancy above the residual friction is refused', &
      .not. accepted(soft(strong(25.0_wp, -1.0_wp), 0.5_wp, 10.0_wp, 12.0_wp)))
    call tests%check('no residual strength is refused', &
      .not. accepted(soft(strong(0.0_wp, -1.0_wp), 0.0_wp, 0.0_wp, 0.0_wp)))
    call tests%check('a strain of zero is refused', .not. accepted(with(0.0_wp, 1.0_wp, regularise_cell)))
    call tests%check('a missing length is refused', .not. accepted(with(0.4_wp, 0.0_wp, regularise_cell)))
    call tests%check('without regularisation no length is needed', accepted(with(0.4_wp, 0.0_wp, regularise_none)))
  end subroutine check_ranges

  !> Softening with another strain, length and regularisation.
  pure function with(strain, length, regularisation) result(p)
    real(wp), intent(in) :: strain, length
    integer, intent(in) :: regularisation
    type(material_parameters_type) :: p

    p = soft(strong(0.0_wp, -1.0_wp), 0.5_wp, 20.0_wp, 0.0_wp)
    p%softening%strain = strain
    p%softening%length = length
    p%softening%regularisation = regularisation
  end function with

  !> Whether parameters pass.
  logical function accepted(p)
    type(material_parameters_type), intent(in) :: p
    type(error_type), allocatable :: error

    call check_parameters(p, error)
    accepted = .not. allocated(error)
  end function accepted

  !> Degree and strain are each other's inverse; 1 - exp(-3) of the way at kappa_r. Tolerance: roundings, for the
  !> exponential law magnified by 1/(1 - d).
  subroutine check_degree(tests)
    type(tests_type), intent(inout) :: tests
    type(softening_model_type) :: model
    real(wp) :: kappa
    integer :: i

    call set_softening(soft(strong(0.0_wp, -1.0_wp), 0.5_wp, 20.0_wp, 0.0_wp), model)
    call tests%close('linear: half way', degree_of(model%softening, 0.2_wp), 0.5_wp, 1.0e-15_wp)
    call tests%close('linear: residual', degree_of(model%softening, 5.0_wp), 1.0_wp, 0.0_wp)
    call tests%close('linear: the least strain of the residual state', strain_of_degree(model%softening, 1.2_wp), &
      0.4_wp, 0.0_wp)
    call tests%close('linear: no strain below the peak', strain_of_degree(model%softening, -0.1_wp), 0.0_wp, 0.0_wp)
    call set_softening(exponential(soft(strong(0.0_wp, -1.0_wp), 0.5_wp, 20.0_wp, 0.0_wp)), model)
    call tests%close('exponential: 95 % at kappa_r', degree_of(model%softening, 0.4_wp), &
      1.0_wp - exp(-3.0_wp), 1.0e-15_wp)
    do i = 1, 5
      kappa = 0.1_wp*i
      call tests%close('exponential: back and forth', strain_of_degree(model%softening, &
        degree_of(model%softening, kappa)), kappa, 1.0e-14_wp)
    end do
  end subroutine check_degree

  !> Simple shear of a Tresca material with G = 1000, c from 1 to 0.25: the shear strength is c(kappa) to rounding at
  !> every step, and tau follows c(gamma - tau/G) but for rotations, of order gamma^2 = 3.6e-5.
  subroutine check_shear(tests, kinematics, shape)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kinematics, shape
    type(material_parameters_type) :: p
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: radius, miss, off, kappa
    integer :: i, at

    p = elastic(2500.0_wp, 0.25_wp)
    p%mohr_coulomb = .true.
    p%cohesion = 1.0_wp
    p = soft(p, 0.25_wp, 0.0_wp, 0.0_wp)
    p%softening%shape = shape
    p%softening%strain = 4.0e-3_wp
    at = place_of_kappa(2, kinematics)
    call make_law(p, 2, kinematics, rate_midpoint, law)
    call start_point(law, [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], point)
    miss = 0.0_wp
    off = 0.0_wp
    do i = 1, 60
      call step_point(law, point, [.true., .true., .true., .true., .true.], &
        diagonal + [0.0_wp, 0.0_wp, 1.0e-4_wp, 0.0_wp, 0.0_wp], error)
      kappa = point%state(at)
      radius = sqrt(0.25_wp*(point%stress(1) - point%stress(2))**2 + point%stress(4)**2)
      if (i > 10) miss = max(miss, abs(radius - cohesion(kappa)))
      if (i > 10) off = max(off, abs(kappa - (1.0e-4_wp*i - radius/1000.0_wp))/4.0e-3_wp)
    end do
    call tests%close('simple shear: tau = c(kappa)', miss, 0.0_wp, 1.0e-12_wp)
    call tests%close('simple shear: kappa is the shear strain less tau/G', off, 0.0_wp, 4.0e-5_wp)
    call tests%check('the residual state is reached', kappa > 4.0e-3_wp)
  contains
    !> c of the plastic shear strain.
    real(wp) function cohesion(strain)
      real(wp), intent(in) :: strain

      cohesion = 0.25_wp + 0.75_wp*exp(-3.0_wp*strain/4.0e-3_wp)
      if (shape == softening_linear) cohesion = 0.25_wp + 0.75_wp*max(0.0_wp, 1.0_wp - strain/4.0e-3_wp)
    end function cohesion
  end subroutine check_shear

  !> Work per area of a band in one row of cells of size h, beyond the residual strength: L (c_p - c_r) kappa_r/2 for
  !> every h. Trapezoids over steps of which the two with a kink err by up to (step)^2 times the slope; rotations of
  !> order gamma = 6e-3. Tolerance 2e-3 of the energy.
  subroutine check_energy(tests, kinematics)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kinematics
    real(wp), parameter :: sizes(3) = [0.25_wp, 1.0_wp, 3.0_wp], exact = 0.75_wp*4.0e-3_wp/2.0_wp
    integer :: i

    do i = 1, 3
      call tests%close('work of a band is the same for every cell size', band_work(sizes(i), kinematics)/exact, &
        1.0_wp, 2.0e-3_wp)
    end do
  end subroutine check_energy

  !> Work on the plastic shear strain of a cell, beyond the residual strength, times its size.
  real(wp) function band_work(h, kinematics) result(work)
    real(wp), intent(in) :: h
    integer, intent(in) :: kinematics
    type(material_parameters_type) :: p
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp) :: tau, before, slip, last
    integer, parameter :: steps = 2000
    integer :: i

    p = strong_tresca()
    p%young = 2500.0_wp
    p%poisson = 0.25_wp
    p = soft(p, 0.25_wp, 0.0_wp, 0.0_wp)
    p%softening%strain = 4.0e-3_wp
    call make_law(p, 2, kinematics, rate_midpoint, law)
    call make_batch(law, 1, batch)
    batch%volume_ratio = 1.0_wp
    allocate (batch%cell_size(1), source=h)
    batch%gradient(3, 1) = (1.0e-3_wp + 4.5e-3_wp/h)/steps
    work = 0.0_wp
    before = 0.0_wp
    last = 0.0_wp
    do i = 1, steps
      call law%update(batch, tangent_none)
      tau = batch%stress(4, 1)
      slip = batch%gradient(3, 1)*i - tau/1000.0_wp
      if (i > 1) work = work + h*(0.5_wp*(tau + before) - 0.25_wp)*(slip - last)
      before = tau
      last = slip
      batch%stress_start = batch%stress
      batch%state_start = batch%state
    end do
  end function band_work

  !> Drained triaxial compression at 100: k 100 + 2 c k^1/2 with the values of the peak before the first plastic
  !> strain, and the residual ones in the end, to the figures' rounding.
  subroutine check_triaxial(tests, kinematics)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kinematics
    class(law_type), allocatable :: law
    type(material_parameters_type) :: p
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: k, largest, cell
    integer :: i

    p = soft(strong(10.0_wp, -1.0_wp), 0.5_wp, 20.0_wp, 0.0_wp)
    p%young = 5.0e4_wp
    p%softening%strain = 0.05_wp
    call make_law(p, 3, kinematics, rate_midpoint, law)
    call start_point(law, [-100.0_wp, -100.0_wp, -100.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], point)
    largest = 0.0_wp
    cell = 1.0_wp
    do i = 1, 400
      call step_point(law, point, [.true., .true., .true., .true., .false., .true., .true., &
        .true., .false.], [1.0_wp - 1.25e-4_wp, 0.0_wp, 0.0_wp, 0.0_wp, -100.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
        -100.0_wp], error)
      if (allocated(error)) exit
      ! The strength bounds the Kirchhoff stress of the logarithmic law.
      cell = 1.0_wp
      if (kinematics == kinematics_logarithmic) cell = point%volume_ratio
      largest = max(largest, -point%stress(1))
    end do
    call tests%check('triaxial compression runs to its end', .not. allocated(error))
    ! The step with the peak has up to 1.25e-4*2 plastic strain: 0.5 % of the way.
    call tests%close('peak of triaxial compression', largest, 249.531_wp, 0.4_wp)
    k = (1.0_wp + sin(pi/9.0_wp))/(1.0_wp - sin(pi/9.0_wp))
    call tests%close('residual strength of triaxial compression', -point%stress(1)*cell, &
      k*100.0_wp*cell + 2.0_wp*0.5_wp*sqrt(k), 1.0e-8_wp*100.0_wp)
  end subroutine check_triaxial

  !> Tresca softens stably while h/L is below G kappa_r/(c_p - c_r): the bound to its own margin of 1e-3, and a point on
  !> either side of it.
  subroutine check_snap_back(tests, kinematics)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kinematics
    type(softening_model_type) :: model
    type(material_parameters_type) :: p
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp) :: bound

    p = soft(strong_tresca(), 0.2_wp, 0.0_wp, 0.0_wp)
    call set_softening(p, model)
    bound = largest_band_ratio(model)
    call tests%close('largest cell of a softening Tresca material', &
      bound*0.8_wp/(0.4_wp*model%shear), 1.0_wp, 1.1e-3_wp)
    call make_law(p, 2, kinematics, rate_midpoint, law)
    call tests%check('the law asks for the size of the cell', law%asks_where)
    call make_batch(law, 2, batch)
    allocate (batch%cell_size(2))
    batch%cell_size = bound*[0.99_wp, 1.01_wp]
    batch%gradient(3, :) = 0.02_wp
    call law%update(batch, tangent_consistent)
    call tests%check('a cell below the bound is answered', batch%status(1) == status_ok)
    call tests%check('a cell above the bound snaps back', batch%status(2) == status_failed)
    call tests%check('and says so', allocated(batch%message))
    p = exponential(p)
    call set_softening(p, model)
    call tests%close('the exponential law falls three times as fast', largest_band_ratio(model)*3.0_wp/bound, 1.0_wp, &
      1.0e-5_wp)
  end subroutine check_snap_back

  !> The plane law is the solid one. Tolerance: roundings of the two decompositions.
  subroutine check_plane(tests, kinematics)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kinematics
    real(wp) :: difference
    integer :: plastic

    call compare_plane(soft(strong(10.0_wp, -1.0_wp), 0.2_wp, 18.0_wp, 0.0_wp), kinematics, rate_midpoint, difference, &
      plastic)
    call tests%close('softening: two dimensions equal three', difference, 0.0_wp, 1.0e-12_wp)
    call tests%check('softening: points yield', plastic > 100)
  end subroutine check_plane

  !> Half the steps, twice the error: the strength is that of the end of a step, so that the path is of first order.
  !> A path of shear and compression; against 1024 steps.
  subroutine check_order(tests, kinematics)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kinematics
    real(wp) :: exact(4), coarse(4), fine(4)

    exact = walked(1024, kinematics)
    coarse = walked(16, kinematics)
    fine = walked(32, kinematics)
    call tests%check('halved steps: the error falls', norm2(fine - exact) < 0.62_wp*norm2(coarse - exact))
    call tests%close('halved steps: small in the end', norm2(fine - exact)/norm2(exact), 0.0_wp, 0.02_wp)
  end subroutine check_order

  !> Stress after a curved path in equal steps.
  function walked(steps, kinematics) result(stress)
    integer, intent(in) :: steps
    integer, intent(in) :: kinematics
    real(wp) :: stress(4)
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: t
    integer :: i

    call make_law(soft(strong(10.0_wp, -1.0_wp), 0.2_wp, 18.0_wp, 0.0_wp), 2, kinematics, rate_midpoint, law)
    call start_point(law, [-5.0_wp, -5.0_wp, -5.0_wp, 0.0_wp], point)
    do i = 1, steps
      t = (i - 0.5_wp)/steps
      call step_point(law, point, [.true., .true., .true., .true., .true.], diagonal + 0.2_wp/steps &
        *[0.2_wp*t, 0.0_wp, cos(2.0_wp*t), -0.3_wp*t, 0.0_wp], error)
    end do
    stress = point%stress
  end function walked

  !> What a cell averages comes back, and a degree beyond the residual state is taken for it.
  subroutine check_fields(tests, kinematics)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kinematics
    class(law_type), allocatable :: law
    real(wp), allocatable :: fields(:), state(:)
    real(wp) :: stress(4)
    integer :: at, i

    at = place_of_kappa(2, kinematics)
    call make_law(soft(strong(0.0_wp, -1.0_wp), 0.2_wp, 18.0_wp, 0.0_wp), 2, kinematics, rate_midpoint, law)
    allocate (fields(law%fit_count()), state(law%state_count))
    call law%start([-1.0_wp, -2.0_wp, -1.5_wp, 0.3_wp], state)
    call tests%close('a new point has not softened', state(at), 0.0_wp, 0.0_wp)
    call tests%check('its name in results', law%state_names(at)%text == 'plastic_shear_strain')
    call tests%check('no other has one', all([(len(law%state_names(i)%text) == 0 .or. i == at, i=1, law%state_count)]))
    state(at) = 0.1_wp
    call law%to_fields([-1.0_wp, -2.0_wp, -1.5_wp, 0.3_wp], state, fields)
    call tests%check('five fields are averaged', law%fit_count() == 5)
    call tests%close('the last one is the degree', fields(5), 0.25_wp, 1.0e-15_wp)
    call law%from_fields(fields, 1.0_wp, stress, state)
    call tests%close('the stress comes back', &
      maxval(abs(stress - [-1.0_wp, -2.0_wp, -1.5_wp, 0.3_wp])), 0.0_wp, 1.0e-12_wp)
    call tests%close('the strain comes back', state(at), 0.1_wp, 1.0e-15_wp)
    fields(5) = 1.3_wp
    call law%from_fields(fields, 1.0_wp, stress, state)
    call tests%close('a degree above one is residual', state(at), 0.4_wp, 0.0_wp)
  end subroutine check_fields

  !> With residual values equal to those of the peak the answer is that without softening, to rounding.
  subroutine check_peak(tests, kinematics)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kinematics
    class(law_type), allocatable :: plain, same
    type(batch_type) :: a, b

    call make_law(strong(10.0_wp, 0.5_wp), 3, kinematics, rate_midpoint, plain)
    call make_law(soft(strong(10.0_wp, 0.5_wp), 1.0_wp, 25.0_wp, 10.0_wp), 3, kinematics, rate_midpoint, same)
    call random_batch(plain, 400, 0.04_wp, 1.0_wp, a)
    call random_batch(same, 400, 0.04_wp, 1.0_wp, b)
    call plain%update(a, tangent_consistent)
    call same%update(b, tangent_consistent)
    call tests%close('no fall: the stress is that of perfect plasticity', maxval(abs(a%stress - b%stress)), 0.0_wp, &
      1.0e-12_wp*200.0_wp)
    call tests%close('no fall: so is the tangent', maxval(abs(a%tangent - b%tangent)), 0.0_wp, 1.0e-11_wp*200.0_wp)
  end subroutine check_peak

  !> Consistent tangent of points at any degree of softening in cells twice as large as the band, and the elastic one,
  !> against differences. Tolerance 1e-6 of the largest entry: the differences err by 1e-10 (round-off over the step)
  !> and by the curvature of the strength over kappa, larger than that of the perfectly plastic law.
  subroutine check_tangent(tests, name, p, d, kinematics)
    type(tests_type), intent(inout) :: tests
    !> Name for the messages.
    character(len=*), intent(in) :: name
    type(material_parameters_type), intent(in) :: p
    integer, intent(in) :: d
    integer, intent(in) :: kinematics
    class(law_type), allocatable :: law, free
    type(batch_type) :: batch, copy
    real(wp), allocatable :: tangent(:, :, :)
    character(len=:), allocatable :: label
    real(wp) :: error
    integer :: compared, i, at

    label = name//merge(', Jaumann: ', ', log:     ', kinematics == kinematics_jaumann)
    at = place_of_kappa(d, kinematics)
    call make_law(p, d, kinematics, rate_midpoint, law)
    call random_batch(law, 400, 0.04_wp, 1.0_wp, batch)
    allocate (batch%cell_size(400), source=2.0_wp)
    do i = 1, 400
      batch%state_start(at, i) = 0.5_wp*modulo(i*0.6180339887_wp, 1.0_wp)
    end do
    call law%update(batch, tangent_consistent)
    allocate (tangent, source=batch%tangent)
    call tests%check(label//'all points are updated', all(batch%status == status_ok))
    call tests%check(label//'most points yield', sum(batch%plastic) > 200 .and. sum(batch%plastic) <= 400)
    call tests%check(label//'plastic strain does not fall', all(batch%state(at, :) >= batch%state_start(at, :)))
    call difference_error(law, batch, tangent, error, compared)
    call tests%close(label//'consistent tangent agrees with differences', error, 0.0_wp, 1.0e-6_wp)
    call tests%check(label//'nearly all columns were compared', compared > 95*batch%count*size(tangent, 2)/100)
    call law%update(batch, tangent_elastic)
    call make_law(elastic(p%young, p%poisson), d, kinematics, rate_midpoint, free)
    call random_batch(free, 400, 0.04_wp, 1.0_wp, copy)
    call free%update(copy, tangent_consistent)
    call tests%close(label//'elastic tangent is that of the material without strength', &
      maxval(abs(batch%tangent - copy%tangent)), 0.0_wp, 1.0e-12_wp*p%young/(1.0_wp - 2.0_wp*p%poisson))
  end subroutine check_tangent
end module test_softening
