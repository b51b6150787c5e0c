!> Softening by a nonlocal strain: the coupling of a law by differences, the matrix of displacement and field by
!> differences, a constant that passes exactly, the length of a law, and a run that goes on from a snapshot.
module test_nonlocal_strain
  use qsmpm, only: wp, error_type, problem_type, simulation_type, snapshot_type, kept_values, keep_values
  use qsmpm_equations, only: gather, scatter
  use qsmpm_error, only: error_deck
  use qsmpm_initialisation, only: step_type, initialise_step, evaluate_step
  use qsmpm_law, only: law_type, batch_type, field_coupling_type, step_info_type, status_ok, tangent_none, &
    tangent_consistent
  use qsmpm_law_factory, only: kinematics_jaumann, kinematics_logarithmic, new_law, rate_midpoint
  use qsmpm_material_parameters, only: material_parameters_type, softening_parameters_type, softening_exponential, &
    softening_linear, regularise_nonlocal
  use qsmpm_nonlocal_field, only: nonlocal_field, gather_field
  use qsmpm_phase_start, only: start_phase
  use qsmpm_sharing_limits, only: refuse_sharing
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_term, only: increment_type
  use qsmpm_term_sums, only: add_all_blocks, begin_terms, set_loads
  use qsmpm_text, only: same_bits
  use qsmpm_unknowns, only: all_nodes, joint_node
  use deck_samples, only: joined
  use law_trials, only: strong, make_law, random_batch, difference_error
  use scratch_folder, only: make_folder, remove_folder
  use testing, only: tests_type
  implicit none
  private

  public :: collect_nonlocal_strain

  !> The backgrounds of the tests: element, lines along z, model, method.
  character(len=*), parameter :: plane_fem = 'PLANE STRAIN|*GRID, ELEMENT=TRI6|X, 0, 0.5, 2|Y, 0, 0.5, 2|*METHOD, '// &
    'BASIS=FEM|', plane_cells = 'PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, -0.1, 0.9, 8|Y, 0, 0.5, 4|*METHOD, '// &
    'BASIS=STANDARD, INTEGRATION=CELL|', plane_splines = 'PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, -0.1, 0.9, 8|'// &
    'Y, 0, 0.5, 4|*METHOD, BASIS=SPLINE2G, INTEGRATION=CELL|', rings = 'AXISYMMETRIC|*GRID, ELEMENT=QUAD4|'// &
    'X, 0, 0.5, 4|Y, 0, 0.5, 4|*METHOD, BASIS=GIMP, INTEGRATION=POINTS|', &
    solid = '3D|*GRID, ELEMENT=HEX8|X, 0, 0.5, 2|Y, 0, 0.5, 2|Z, 0, 0.5, 2|*METHOD, BASIS=STANDARD|'

contains

  !> All tests of the suite.
  subroutine collect_nonlocal_strain(tests)
    type(tests_type), intent(inout) :: tests
    integer :: d, shape

    call tests%start('nonlocal_strain')
    call check_kinematics(tests)
    do d = 2, 3
      do shape = softening_linear, softening_exponential
        call check_coupling(tests, d, shape)
      end do
    end do
    call check_matrix(tests, 'triangles', plane_fem)
    call check_matrix(tests, 'cells', plane_cells)
    call check_matrix(tests, 'splines', plane_splines)
    call check_matrix(tests, 'rings', rings)
    call check_matrix(tests, 'solid', solid)
    call check_constant(tests, 'triangles', plane_fem)
    call check_constant(tests, 'cells', plane_cells)
    call check_constant(tests, 'splines', plane_splines)
    call check_constant(tests, 'rings', rings)
    call check_wide_cells(tests)
    call check_sharing(tests)
    call check_kept(tests)
  end subroutine collect_nonlocal_strain

  !> A soil that softens in c, phi and psi.
  pure function soil(shape) result(p)
    integer, intent(in) :: shape
    type(material_parameters_type) :: p

    p = strong(10.0_wp, -1.0_wp)
    p%softening = softening_parameters_type(given=.true., shape=shape, regularisation=regularise_nonlocal, &
      cohesion=0.2_wp, friction_angle=18.0_wp, dilatancy_angle=0.0_wp, strain=0.4_wp, length=2.0_wp, over=2.0_wp)
  end function soil

  !> The Jaumann rate is refused; l = L/(3 pi/2 + 2) for m = 2.
  subroutine check_kinematics(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error

    call new_law(soil(softening_linear), 2, kinematics_jaumann, rate_midpoint, law, error)
    call tests%check('the Jaumann rate is refused', allocated(error))
    if (allocated(error)) call tests%check('as an error of the deck', error%code == error_deck)
    call make_law(soil(softening_linear), 2, kinematics_logarithmic, rate_midpoint, law)
    call tests%close('the length of the field', law%field_length, 2.0_wp/6.712388980_wp, 1.0e-9_wp)
  end subroutine check_kinematics

  !> Derivatives by the field and of kappa by F, and the tangent at a constant field, against central differences;
  !> points that change their set of planes within the step are left out. Tolerance: the curvature of the strength.
  subroutine check_coupling(tests, d, shape)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: d, shape
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    type(field_coupling_type) :: coupling(300)
    real(wp), allocatable :: tangent(:, :, :), gradient(:, :), up(:, :), down(:, :), here(:, :)
    real(wp), parameter :: step = 1.0e-6_wp
    real(wp) :: error, miss(3)
    integer :: last, i, j, n, compared

    call make_law(soil(shape), d, kinematics_logarithmic, rate_midpoint, law)
    call random_batch(law, 300, 0.04_wp, 1.0_wp, batch)
    last = law%state_count
    n = size(batch%gradient, 1)
    allocate (batch%cell_size(300), source=0.1_wp)
    do i = 1, 300
      batch%state_start(last - 1, i) = 0.3_wp*modulo(i*0.6180339887_wp, 1.0_wp)
      batch%state_start(last, i) = 0.3_wp*modulo(i*0.7548776662_wp, 1.0_wp)
    end do
    call law%update(batch, tangent_consistent)
    allocate (tangent, source=batch%tangent)
    call tests%check('all points are updated', all(batch%status == status_ok))
    call tests%check('most points yield', sum(batch%plastic) > 150)
    call difference_error(law, batch, tangent, error, compared)
    call tests%close('the tangent at a constant field agrees with differences', error, 0.0_wp, 1.0e-6_wp)
    call law%update(batch, tangent_none)
    do i = 1, 300
      if (batch%plastic(i) > 0) call law%couple(batch%gradient(:, i), batch%volume_ratio(i), batch%cell_size(i), &
        batch%state_start(:, i), batch%state(:, i), coupling(i))
    end do
    allocate (gradient, source=batch%gradient)
    here = answers()
    miss = 0.0_wp
    batch%state_start(last, :) = batch%state_start(last, :) + step
    up = answers()
    batch%state_start(last, :) = batch%state_start(last, :) - 2.0_wp*step
    down = answers()
    batch%state_start(last, :) = batch%state_start(last, :) + step
    do i = 1, 300
      if (bends(i)) cycle
      miss(1) = max(miss(1), maxval(abs((up(:n, i) - down(:n, i))/(2.0_wp*step) - coupling(i)%stress_by_field(:n))))
      miss(2) = max(miss(2), abs((up(n + 1, i) - down(n + 1, i))/(2.0_wp*step) - coupling(i)%strain_by_field))
    end do
    do j = 1, n
      batch%gradient(j, :) = gradient(j, :) + step
      up = answers()
      batch%gradient(j, :) = gradient(j, :) - step
      down = answers()
      batch%gradient(j, :) = gradient(j, :)
      do i = 1, 300
        if (.not. bends(i)) miss(3) = max(miss(3), abs((up(n + 1, i) - down(n + 1, i))/(2.0_wp*step) &
          - coupling(i)%strain_by_gradient(j)))
      end do
    end do
    call tests%close('the stress by the field', miss(1), 0.0_wp, 1.0e-5_wp)
    call tests%close('kappa by the field', miss(2), 0.0_wp, 1.0e-6_wp)
    call tests%close('kappa by the gradient', miss(3), 0.0_wp, 1.0e-5_wp)

  contains

    !> Q and kappa of all points.
    function answers() result(values)
      real(wp) :: values(n + 1, 300)

      call law%update(batch, tangent_none)
      values(:n, :) = batch%piola
      values(n + 1, :) = batch%state(last - 1, :)
    end function answers

    !> Whether a point has a kink between the two answers.
    logical function bends(p)
      integer, intent(in) :: p

      bends = maxval(abs(up(:, p) + down(:, p) - 2.0_wp*here(:, p))) > 1.0e-8_wp
    end function bends
  end subroutine check_coupling

  !> A block of the soil on a background, held at its base.
  subroutine begin(background, run, length)
    character(len=*), intent(in) :: background
    class(simulation_type), allocatable, intent(out) :: run
    class(problem_type), allocatable :: problem
    type(error_type), allocatable :: error
    !> LENGTH of the softening; 4 unless given.
    character(len=*), intent(in), optional :: length
    character(len=:), allocatable :: shape, wide

    wide = '4'
    if (present(length)) wide = length
    shape = 'SHAPE=BOX|0, 0.5, 0, 0.5|'
    if (background(1:2) == '3D') shape = 'SHAPE=BOX|0, 0.5, 0, 0.5, 0, 0.5|'
    allocate (problem, run)
    call problem%parse(joined('*MODEL, TYPE='//background//'*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=top, '// &
      'PLANE=Y|0.5|*MATERIAL, NAME=soil|*ELASTIC|200, 0.3|*MOHR COULOMB|1, 20, 5|*SOFTENING, REGULARISATION=NONLOCAL, LENGTH='// &
      wide//'|0.2, 15, 0, 0.1|*VOLUMETRIC LOCKING, TYPE=NONE|*BODY, NAME=block, MATERIAL=soil, '//shape// &
      '*PHASE, NAME=one|*FIX|base, ALL|*PRESCRIBE|top, X, 0.02|*CONTROLS, STEPS=4, TOLERANCE=1e-6|*END PHASE|'), &
      'block', error)
    if (.not. allocated(error)) call run%create(problem, error)
    if (allocated(error)) error stop 'the block of the nonlocal suite cannot be made'
  end subroutine begin

  !> Make a step ready for evaluations.
  subroutine ready(run, step)
    class(simulation_type), intent(inout) :: run
    class(step_type), allocatable, intent(out) :: step
    type(error_type), allocatable :: error

    allocate (step)
    call start_phase(run%model)
    call move_alloc(run%loop%step%terms, step%terms)
    call initialise_step(run%model, step, error)
    if (allocated(error)) error stop 'the step of the nonlocal suite cannot be made'
    call begin_terms(step%terms, increment_type(step_info_type(duration=0.25_wp)))
    call set_loads(step%terms, run%model, step%configuration_type, 0.25_wp)
  end subroutine ready

  !> The matrix is the derivative of the residual, by central differences along a direction, at a trial at which soil
  !> yields; the tangent of the displacement holds a share of 1e-5 of the elastic one.
  subroutine check_matrix(tests, name, background)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name, background
    class(simulation_type), allocatable :: run
    class(step_type), allocatable :: step
    real(wp), parameter :: difference = 1.0e-7_wp, tolerances(2) = [1.0e-3_wp, 1.0e-4_wp]
    real(wp), allocatable :: u(:, :), v(:, :), along(:), by_matrix(:), ahead(:), back(:)
    integer :: i

    call begin(background, run)
    call ready(run, step)
    along = [(sin(3.0_wp*i), i=1, step%equations%count)]
    allocate (u(size(step%equations%number, 1), all_nodes(step%unknowns)), source=0.0_wp)
    allocate (v, mold=u)
    v = 0.0_wp
    call scatter(step%equations, merge(2.0e-3_wp, 1.0e-2_wp, step%field_of == 1)*cos(along), u)
    call scatter(step%equations, along, v)
    call evaluate_step(run%model, step, u, tangent_consistent)
    call tests%check(name//': there are two fields', maxval(step%field_of) == 2)
    call add_all_blocks(step%terms, u, step%equations, step%matrix)
    by_matrix = product_with(step%matrix, along)
    ahead = residual_at(u + difference*v)
    back = residual_at(u - difference*v)
    do i = 1, 2
      call tests%close(name//': the tangent of field '//achar(iachar('0') + i), maxval(abs(by_matrix &
        - (ahead - back)/(2.0_wp*difference)), mask=step%field_of == i), 0.0_wp, &
        tolerances(i)*maxval(abs(by_matrix), mask=step%field_of == i))
    end do

  contains

    !> Resistance less load at a trial.
    function residual_at(table) result(vector)
      real(wp), intent(in) :: table(:, :)
      real(wp) :: vector(step%equations%count)

      call evaluate_step(run%model, step, table, tangent_none)
      call gather(step%equations, step%forces%internal + step%forces%numerical - step%forces%external, vector)
    end function residual_at
  end subroutine check_matrix

  !> Product of an unsymmetric matrix with a vector.
  pure function product_with(matrix, vector) result(y)
    type(sparse_matrix_type), intent(in) :: matrix
    real(wp), intent(in) :: vector(:)
    real(wp) :: y(size(vector))
    integer :: row

    do row = 1, matrix%n
      associate (places => [integer :: matrix%row_first(row), matrix%row_first(row + 1) - 1])
        y(row) = dot_product(matrix%values(places(1):places(2)), vector(matrix%column(places(1):places(2))))
      end associate
    end do
  end function product_with

  !> Where kappa of all points is one number the field is that number: no residual, to roundings; and the nodal values
  !> gathered from the points are it too.
  subroutine check_constant(tests, name, background)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name, background
    real(wp), parameter :: kappa = 0.01_wp
    class(simulation_type), allocatable :: run
    class(step_type), allocatable :: step
    real(wp), allocatable :: u(:, :)
    integer :: last, first

    call begin(background, run)
    last = run%model%laws(1)%law%state_count
    run%model%state%points%state(last - 1:last, :) = kappa
    call gather_field(run%model)
    associate (kept => kept_values(run%model%state%kept, nonlocal_field))
      call tests%close(name//': the field gathered from points', maxval(abs(kept - kappa), mask=abs(kept) > 0.0_wp), &
        0.0_wp, 1.0e-15_wp)
      call keep_values(run%model%state%kept, nonlocal_field, 0.0_wp*kept + kappa)
    end associate
    call ready(run, step)
    allocate (u(size(step%equations%number, 1), all_nodes(step%unknowns)), source=0.0_wp)
    call evaluate_step(run%model, step, u, tangent_none)
    first = joint_node(step%unknowns, 1, 2)
    call tests%close(name//': a constant passes', maxval(abs(step%forces%internal(1, first:))), 0.0_wp, 1.0e-16_wp)
  end subroutine check_constant

  !> Cells of 0.25, wider than 3/4 of l = LENGTH/6.71: the run says so, has no equation of the field, and runs.
  subroutine check_wide_cells(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    class(step_type), allocatable :: step
    type(error_type), allocatable :: error

    call begin(plane_fem, run)
    call tests%check('no word where cells are small enough', index(run%model%notes, 'NONLOCAL') == 0)
    call begin(plane_fem, run, '1')
    call tests%check('wide cells are warned of, with their material', &
      index(run%model%notes, "warning: material 'soil': REGULARISATION=NONLOCAL") > 0)
    call ready(run, step)
    call tests%check('they have no field', maxval(step%field_of) == 1)
    call begin(plane_fem, run, '1')
    call run%run(error)
    call tests%check('and soften by their size', .not. allocated(error) .and. &
      maxval(run%model%state%points%state(run%model%laws(1)%law%state_count - 1, :)) > 1.0e-3_wp)
  end subroutine check_wide_cells

  !> Two processes refuse it by name.
  subroutine check_sharing(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error

    call begin(plane_splines, run)
    call refuse_sharing(run%model, 2, error)
    call tests%check('several processes refuse it', allocated(error))
    if (allocated(error)) call tests%check('by its name', index(error%message, 'REGULARISATION=NONLOCAL') > 0)
  end subroutine check_sharing

  !> A run that goes on from a checkpoint or a restart file is the whole run, bit for bit, and the points have the field
  !> of the last step.
  subroutine check_kept(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: whole, half, other
    class(snapshot_type), allocatable :: snapshot
    type(error_type), allocatable :: error
    character(len=:), allocatable :: directory
    integer :: last

    allocate (snapshot)
    call begin(plane_fem, whole)
    call whole%run(error)
    call tests%check('a block that softens runs', .not. allocated(error))
    call begin(plane_fem, half)
    call half%advance(error)
    call half%advance(error)
    call make_folder(directory)
    call half%save(directory//'/half.h5', error)
    call half%checkpoint(snapshot, error)
    call half%run(error)
    call half%restore_checkpoint(snapshot, error)
    call half%run(error)
    call tests%check('a checkpoint takes the field back', .not. allocated(error) .and. &
      all(same_bits(half%model%state%points%state, whole%model%state%points%state)))
    call begin(plane_fem, other)
    call other%load(directory//'/half.h5', error)
    call other%run(error)
    call remove_folder(directory)
    call tests%check('a restart file too', .not. allocated(error) .and. &
      all(same_bits(other%model%state%points%state, whole%model%state%points%state)))
    last = whole%model%laws(1)%law%state_count
    associate (state => whole%model%state%points%state)
      call tests%check('points know kappa and the field', maxval(state(last - 1, :)) > 1.0e-3_wp .and. &
        minval(state(last, :)) > 0.0_wp)
    end associate
  end subroutine check_kept
end module test_nonlocal_strain
