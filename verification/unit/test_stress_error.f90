!> Tests of the estimate of the stress error: fields it must not see, fields it must see, and how large.
module test_stress_error
  use omp_lib, only: omp_set_num_threads, omp_get_max_threads
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_error_report, only: error_line, error_warning
  use qsmpm_analysis, only: analysis_type
  use qsmpm_load_description, only: support_normal
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_stress_error, only: stress_error_type, estimate_stress_error
  use qsmpm_text, only: same_bits, integer_text
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_stress_error

  !> Rounding of fits to stresses of the order of one in some hundred points.
  real(wp), parameter :: rounding = 1.0e-12_wp
  !> Cells of triangles that the body cuts hold points in a row; across a row that is narrower than 0.03 of a cell (the
  !> root of least_spread) there is no slope: 0.03 times a cell of 0.2 times a slope of 0.6 to 1.5 of the scale.
  real(wp), parameter :: faded = 4.0e-3_wp

contains

  !> All tests of the suite.
  subroutine collect_stress_error(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model

    allocate (model)
    call tests%start('stress_error')
    call check_linear_fields(tests, 'QUAD4', 'STANDARD', rounding)
    call check_linear_fields(tests, 'QUAD8', 'STANDARD', rounding)
    call check_linear_fields(tests, 'TRI3', 'STANDARD', faded)
    call check_linear_fields(tests, 'TRI6', 'STANDARD', rounding)
    call check_linear_fields(tests, 'QUAD4', 'SPLINE2G', rounding)
    call check_linear_fields(tests, 'HEX8', 'STANDARD', rounding)
    call check_linear_fields(tests, 'WEDGE15', 'STANDARD', faded)
    call check_curved_fields(tests, 'QUAD4', 'SPLINE2G', 2)
    call check_curved_fields(tests, 'QUAD8', 'STANDARD', 2)
    call check_curved_fields(tests, 'QUAD4', 'SPLINE3', 3)
    call check_curved_fields(tests, 'HEX8', 'SPLINE3', 3)
    call check_checkerboard(tests)
    call check_far_field(tests, -1.0_wp)
    call check_far_field(tests, -0.02_wp)
    call check_surface(tests)
    call check_jump(tests, 'QUAD4', 'STANDARD')
    call check_jump(tests, 'TRI6', 'STANDARD')
    call check_jump(tests, 'HEX8', 'STANDARD')
    call check_words(tests)
    call check_reaction(tests)
    call check_left_out(tests)
    call check_few_points(tests)
    call check_threads(tests)
    call build('QUAD4', 'STANDARD', '0, 0.93, 0, 0.81', model)
    model%state%points%stress = 0.0_wp
    call check_no_stress(tests, model)
  end subroutine collect_stress_error

  !> A block of two materials in a grid that it does not fit, under a traction on its top.
  subroutine build(element, basis, box, model, points)
    !> Element, basis, and bounds of the lower body.
    character(len=*), intent(in) :: element, basis, box
    !> The model with all of its load on it.
    type(model_type), intent(out) :: model
    !> Points a cell, those of the element when not given.
    integer, intent(in), optional :: points
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: text
    logical :: solid

    allocate (analysis)
    solid = any(element == [character(len=8) :: 'HEX8', 'WEDGE15'])
    text = '*MODEL, TYPE='//merge('3D          ', 'PLANE STRAIN', solid)//'|*GRID, ELEMENT='//element// &
      '|X, 0, 1, 5|Y, 0, 1.5, 8|'
    if (solid) text = text//'Z, 0, 1, 3|'
    text = text//'*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=lower|*ELASTIC|1000, 0.3|*MATERIAL, NAME=upper|'// &
      '*ELASTIC|500, 0.3|*BODY, NAME=a, MATERIAL=lower, SHAPE=BOX|'//box//merge(', 0, 0.9', '        ', solid)// &
      '|*BODY, NAME=b, MATERIAL=upper, SHAPE=BOX|0, 0.93, 0.81, 1.3'//merge(', 0, 0.9', '        ', solid)
    if (.not. solid) text = text//'|*SURFACE, NAME=top, TYPE=SEGMENT|0.93, 1.3, 0, 1.3|*SURFACE, NAME=side, '// &
      'TYPE=SEGMENT|0, 1.3, 0, 1|*SURFACE, NAME=strip, TYPE=SEGMENT|0.4, 1.3, 0, 1.3'
    if (present(points)) text = text//'|*POINTS, PER ELEMENT='//integer_text(points)
    text = text//'|*METHOD, BASIS='//basis//'|*PHASE, NAME=one|*FIX|base, ALL|'
    if (.not. solid) text = text//'*TRACTION, SURFACE=top|0, -1|'
    text = text//'*CONTROLS, STEPS=1|*END PHASE|'
    call parse_deck('two.inp', joined(text), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) return
    call start_phase(model)
    model%state%progress%fraction = 1.0_wp
  end subroutine build

  !> Stresses linear in space, those of the two materials unlike each other.
  subroutine make_linear(model)
    !> The model.
    type(model_type), intent(inout) :: model
    real(wp) :: sign
    integer :: p, k, d

    d = model%mesh%dimension
    do p = 1, model%state%points%count
      sign = merge(1.0_wp, -2.0_wp, model%state%points%material(p) == 1)
      do k = 1, size(model%state%points%stress, 1)
        model%state%points%stress(k, p) = sign*(0.1_wp*k - 0.3_wp*model%state%points%position(1, p) &
          + 0.2_wp*k*model%state%points%position(2, p) + 0.05_wp*model%state%points%position(d, p))
      end do
    end do
  end subroutine make_linear

  !> A stress that is linear in each material has no scatter.
  subroutine check_linear_fields(tests, element, basis, tolerance)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> Element and basis.
    character(len=*), intent(in) :: element, basis
    !> What is allowed.
    real(wp), intent(in) :: tolerance
    class(model_type), allocatable :: model
    type(stress_error_type) :: estimate

    allocate (model)
    call build(element, basis, '0, 0.93, 0, 0.5', model)
    call tests%check(element//' '//basis//' is built, of two materials', maxval(model%state%points%material) == 2)
    if (model%state%points%count == 0) return
    call make_linear(model)
    call estimate_stress_error(model, estimate)
    call tests%close('linear stresses in '//element//' '//basis//' have no scatter', estimate%largest, 0.0_wp, &
      tolerance)
    call tests%check('linear stresses in '//element//' '//basis//' have a scale', all(estimate%scale > 0.05_wp))
    model%state%points%stress(1, 7) = model%state%points%stress(1, 7) + 0.5_wp*estimate%scale(7)
    call estimate_stress_error(model, estimate)
    call tests%check('one point of '//element//' '//basis//' that is off by half of the scale is found', &
      estimate%worst_point == 7 .and. estimate%largest > 0.3_wp .and. estimate%mean > 0.0_wp)
  end subroutine check_linear_fields

  !> Stresses that change from cell to cell are off by what they change, cells of one colour up and those of the
  !> other down: patches of four cells see neither a slope nor a mean of it.
  subroutine check_checkerboard(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: amplitude = 0.2_wp
    class(model_type), allocatable :: model
    type(stress_error_type) :: estimate
    integer :: p, column, row, inner

    allocate (model)
    call build('QUAD4', 'STANDARD', '0, 1, 0, 0.75', model)
    associate (points => model%state%points)
      points%material = 1
      points%stress = 0.0_wp
      inner = 0
      do p = 1, points%count
        column = int(points%position(1, p)*5.0_wp)
        row = int(points%position(2, p)*8.0_wp/1.5_wp)
        points%stress(2, p) = -1.0_wp + amplitude*merge(1, -1, mod(column + row, 2) == 0)
        if (inner == 0 .and. column == 2 .and. row == 2) inner = p
      end do
      call estimate_stress_error(model, estimate)
      call tests%close('a checkerboard is off by its amplitude', estimate%at_point(inner)*estimate%scale(inner), &
        amplitude, rounding)
      call tests%close('a checkerboard is off in the mean by its amplitude and less at the edges', estimate%mean, &
        amplitude, 0.3_wp*amplitude)
    end associate
  end subroutine check_checkerboard

  !> A stress that is a polynomial of the degree of the displacement has no scatter where patches have two points a
  !> term: the recovered stress is an order better than that of the displacement.
  subroutine check_curved_fields(tests, element, basis, degree)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> Element and basis.
    character(len=*), intent(in) :: element, basis
    !> Degree of the displacement.
    integer, intent(in) :: degree
    class(model_type), allocatable :: model
    type(stress_error_type) :: estimate
    integer :: p, inner

    allocate (model)
    call build(element, basis, '0, 0.93, 0, 0.81', model, points=merge(64, 16, element == 'HEX8'))
    associate (points => model%state%points)
      points%material = 1
      do p = 1, points%count
        points%stress(:, p) = 1.0_wp + points%position(1, p)*points%position(2, p)**(degree - 1)
      end do
      call estimate_stress_error(model, estimate)
      inner = minloc(sum((points%position - 0.5_wp)**2, dim=1), dim=1)
      call tests%close('a stress of the degree of '//element//' '//basis//' has no scatter inside', &
        estimate%at_point(inner), 0.0_wp, 1.0e-11_wp)
      do p = 1, points%count
        points%stress(:, p) = 1.0_wp + points%position(2, p)**(degree + 1)
      end do
      call estimate_stress_error(model, estimate)
      call tests%check('a stress one degree above '//element//' '//basis//' has', estimate%at_point(inner) > 1.0e-7_wp)
    end associate
  end subroutine check_curved_fields

  !> An error of known size in a uniform stress is stated at its size, and material around it whose stress is uniform
  !> changes nothing however much there is: ten times the volume leaves every figure as it is.
  subroutine check_far_field(tests, far)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> Stress away from the error; that around the error is -1.
    real(wp), intent(in) :: far
    real(wp), parameter :: amplitude = 0.2_wp
    class(model_type), allocatable :: model
    type(stress_error_type) :: small, large
    integer :: p, column, row, inner

    allocate (model)
    call build('QUAD4', 'STANDARD', '0, 1, 0, 0.5', model)
    inner = 0
    associate (points => model%state%points)
      points%stress = 0.0_wp
      ! The upper body has the error, the lower one is a material of its own without.
      do p = 1, points%count
        column = int(points%position(1, p)*5.0_wp)
        row = int(points%position(2, p)*8.0_wp/1.5_wp)
        points%stress(2, p) = far
        if (points%material(p) /= 2) cycle
        points%stress(2, p) = -1.0_wp + amplitude*merge(1, -1, mod(column + row, 2) == 0)
        if (column == 2 .and. row == 5) inner = p
      end do
      call estimate_stress_error(model, small)
      where (points%material == 1) points%volume = 10.0_wp*points%volume
      call estimate_stress_error(model, large)
      call tests%close('a planted error is stated at its size', small%at_point(inner), amplitude/sqrt(1.04_wp), &
        1.0e-2_wp)
      call tests%close('its mean is its size too', small%mean, amplitude/sqrt(1.04_wp), 0.3_wp*amplitude)
      call tests%close('ten times the uniform stress around it leaves the mean', large%mean, small%mean, 1.0e-6_wp)
      call tests%close('ten times the uniform stress around it leaves the largest', large%largest, small%largest, &
        rounding)
      call tests%close('ten times the uniform stress around it leaves every point', &
        maxval(abs(large%at_point - small%at_point)), 0.0_wp, rounding)
      call tests%close('ten times the uniform stress around it leaves the surface', large%surface_mean, &
        small%surface_mean, rounding)
    end associate
  end subroutine check_far_field

  !> The report names the worst places and what the figures are relative to.
  subroutine check_words(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(stress_error_type) :: estimate
    character(len=:), allocatable :: line, warning

    allocate (model)
    call build('QUAD4', 'STANDARD', '0, 0.93, 0, 0.81', model)
    model%state%points%stress = 0.0_wp
    model%state%points%stress(2, :) = -0.8_wp
    call estimate_stress_error(model, estimate)
    line = error_line(model, estimate)
    call tests%check('the line names the surface: '//line, &
      index(line, "; on loaded surface 'top' mean 20 %, largest 20 %") > 0)
    call error_warning(model, estimate, warning)
    call tests%check('a fifth of the traction is not warned of', len(warning) == 0)
    model%state%points%stress(2, 7) = -5.0_wp
    model%state%points%stress(2, model%state%points%count - 5:) = -0.5_wp
    call estimate_stress_error(model, estimate)
    line = error_line(model, estimate)
    call error_warning(model, estimate, warning)
    call tests%check('the line names the point and the stress around it: '//line, &
      index(line, 'at material point 7 at (') > 0 .and. index(line, ', relative to a stress of ') > 0)
    call tests%check('so does the warning: '//warning, index(warning, 'at material point 7 at (') > 0)
    model%state%points%stress(2, :) = -0.7_wp
    call estimate_stress_error(model, estimate)
    call error_warning(model, estimate, warning)
    call tests%check('three tenths of the traction are: '//warning, &
      index(warning, "warning: stresses differ from the traction on surface 'top' mean 30 %") == 1)
  end subroutine check_words

  !> A support holds the loaded top: its reaction, however its springs share it, and the load are what the stress must
  !> carry in all; points of the surface are not looked at one by one.
  subroutine check_reaction(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(stress_error_type) :: estimate

    allocate (model)
    call build('QUAD4', 'STANDARD', '0, 0.93, 0, 0.81', model)
    model%state%points%stress = 0.0_wp
    model%state%points%stress(2, :) = -1.2_wp
    model%loading%support(1) = support_normal
    model%state%surface%reaction(2, 2) = -0.5_wp*0.93_wp
    call estimate_stress_error(model, estimate)
    call tests%close('a stress of 1.2 for a load of 1 and a reaction of 0.5', estimate%reaction, 0.3_wp/1.5_wp, rounding)
    call tests%check('the points of the surface are not compared', estimate%worst_surface == 0)
    call tests%check('the line says so', index(error_line(model, estimate), &
      "; differ from the reaction on supported surface 'top' by 20 %") > 0)
    model%state%surface%reaction(2, 2) = -0.2_wp*0.93_wp
    call estimate_stress_error(model, estimate)
    call tests%close('a stress that carries both', estimate%reaction, 0.0_wp, rounding)
  end subroutine check_reaction

  !> Where two materials meet the traction is one: half of what it jumps by is stated beside their interface and nothing
  !> two cells from it; what acts along the interface may jump.
  subroutine check_jump(tests, element, basis)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: element, basis
    real(wp), parameter :: jump = 0.4_wp
    class(model_type), allocatable :: model
    type(stress_error_type) :: estimate
    real(wp) :: beside

    allocate (model)
    call build(element, basis, '0, 0.93, 0, 0.81', model)
    associate (points => model%state%points)
      points%stress = 0.0_wp
      points%stress(1, :) = merge(-1.0_wp, -0.3_wp, points%material == 1)
      points%stress(2, :) = -1.0_wp
      call estimate_stress_error(model, estimate)
      call tests%close(element//': stress along an interface may jump', estimate%largest, 0.0_wp, 2.0e-2_wp)
      points%stress(2, :) = merge(-1.0_wp, -1.0_wp - jump, points%material == 1)
      call estimate_stress_error(model, estimate)
      beside = maxval(estimate%at_point*estimate%scale, mask=abs(points%position(2, :) - 0.81_wp) < 0.05_wp)
      call tests%close(element//': half of the jump of a traction is stated', beside, 0.5_wp*jump, 2.0e-2_wp*jump)
      call tests%close(element//': and nothing two cells away', maxval(estimate%at_point, &
        mask=abs(points%position(2, :) - 0.81_wp) > 0.375_wp), 0.0_wp, rounding)
    end associate
  end subroutine check_jump

  !> A uniform stress that does not carry the load has no scatter and is found at the loaded surface.
  subroutine check_surface(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(stress_error_type) :: estimate

    allocate (model)
    call build('QUAD4', 'STANDARD', '0, 0.93, 0, 0.81', model)
    model%state%points%stress = 0.0_wp
    model%state%points%stress(2, :) = -0.8_wp
    call estimate_stress_error(model, estimate)
    call tests%close('a uniform stress has no scatter', estimate%largest, 0.0_wp, rounding)
    call tests%close('a stress of 0.8 under a traction of 1 is a fifth of the traction off', estimate%surface_mean, &
      0.2_wp, rounding)
    call tests%close('and everywhere alike', estimate%surface_largest, 0.2_wp, rounding)
    model%state%points%stress(2, :) = -4.0_wp
    call estimate_stress_error(model, estimate)
    call tests%close('a stress of 4 under it is three quarters of itself off', estimate%surface_mean, 0.75_wp, rounding)
    model%state%points%stress(2, :) = -1.0_wp
    call estimate_stress_error(model, estimate)
    call tests%close('the stress that carries the load meets it', estimate%surface_largest, 0.0_wp, rounding)
  end subroutine check_surface

  !> Where nodes are held, a rigid body presses or another loaded surface lies, the traction of a surface is not all that
  !> acts: the mismatch grows to the left, so that it is largest at the first place that is compared.
  subroutine check_left_out(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(stress_error_type) :: estimate
    real(wp), allocatable :: drawn(:)
    integer :: n

    allocate (model)
    call build('QUAD4', 'STANDARD', '0, 0.93, 0, 0.81', model)
    associate (points => model%state%points, surface => model%state%surface, loading => model%loading)
      points%stress = 0.0_wp
      points%stress(2, :) = -1.0_wp + 0.3_wp*(0.93_wp - points%position(1, :))
      points%stress(1, :) = -1.0_wp
      loading%pressure_final(2)%value = 1.0_wp
      call estimate_stress_error(model, estimate)
      call tests%check('a load on a side leaves the top as it is', compared_from(0.0_wp, 0.2_wp))
      loading%pressure_final(2)%value = 0.0_wp
      points%stress(4, :) = 0.6_wp
      call estimate_stress_error(model, estimate)
      call tests%check('a shear stress is off the traction', estimate%surface_largest > 0.3_wp)
      do n = 1, model%mesh%node_count
        loading%constrained(1, n) = model%mesh%coordinates(2, n) > 1.0_wp
      end do
      call estimate_stress_error(model, estimate)
      call tests%check('unless the nodes are held along it', compared_from(0.0_wp, 0.2_wp) .and. &
        estimate%surface_largest < 0.3_wp)
      loading%pressure_final(3)%value = 1.0_wp
      call estimate_stress_error(model, estimate)
      call tests%check('another load on a part of it leaves that out', compared_from(0.4_wp, 0.6_wp))
      loading%pressure_final(3)%value = 0.0_wp
      where (surface%surface == 1 .and. surface%position(1, :) < 0.4_wp) surface%contact_pressure = 1.0_wp
      call estimate_stress_error(model, estimate)
      call tests%check('so does a rigid body', compared_from(0.4_wp, 0.6_wp))
      surface%contact_pressure = 0.0_wp
      where (surface%surface == 3) surface%contact_pressure = 1.0_wp
      call estimate_stress_error(model, estimate)
      call tests%check('and one that touches the other surface', compared_from(0.4_wp, 0.6_wp))
      surface%contact_pressure = 0.0_wp
      allocate (drawn, source=points%position(2, :))
      where (points%position(1, :) < 0.4_wp .and. drawn > maxval(drawn) - 1.0e-3_wp) points%position(2, :) = 2.6_wp - drawn
      call estimate_stress_error(model, estimate)
call tests%check('and soil that lies on it', compared_from(0.4_wp, 0.6_wp))
      points%position(2, :) = drawn
      do n = 1, model%mesh%node_count
        loading%constrained(2, n) = all(model%mesh%coordinates(:, n) < [0.45_wp, 2.0_wp])
      end do
      call estimate_stress_error(model, estimate)
      call tests%check('and nodes that are held across it', compared_from(0.5_wp, 0.6_wp))
    end associate

  contains

    !> Whether the mismatch is that of the top and largest between these coordinates.
    logical function compared_from(low, high)
      real(wp), intent(in) :: low, high

      compared_from = estimate%worst_surface == 1 .and. estimate%surface_place(1) > low .and. &
        estimate%surface_place(1) < high
    end function compared_from
  end subroutine check_left_out

  !> One point a cell, in one row of cells: patches of one or two points.
  subroutine check_few_points(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(stress_error_type) :: estimate

    allocate (model)
    call build('QUAD4', 'STANDARD', '0, 0.02, 0, 0.02', model)
    model%state%points%stress = 0.0_wp
    model%state%points%stress(1, :) = 1.0_wp
    call estimate_stress_error(model, estimate)
    call tests%close('patches of few points keep a uniform stress', estimate%largest, 0.0_wp, rounding)
    call tests%check('patches of few points give numbers', all(estimate%at_point <= 1.0_wp))
  end subroutine check_few_points

  !> The same bits for one and for three threads.
  subroutine check_threads(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(stress_error_type) :: one, three
    integer :: threads, p

    allocate (model)
    call build('TRI6', 'STANDARD', '0, 0.93, 0, 0.81', model)
    do p = 1, model%state%points%count
      model%state%points%stress(:, p) = [sin(3.0_wp*p), cos(7.0_wp*p), sin(5.0_wp*p), cos(2.0_wp*p)]
    end do
    threads = omp_get_max_threads()
    call omp_set_num_threads(1)
    call estimate_stress_error(model, one)
    call omp_set_num_threads(3)
    call estimate_stress_error(model, three)
    call omp_set_num_threads(threads)
    call tests%check('the estimate has the same bits for any number of threads', &
      all(same_bits(one%at_point, three%at_point)) .and. all(same_bits([one%mean, one%largest, one%surface_mean], &
      [three%mean, three%largest, three%surface_mean])))
    call tests%check('stresses at random scatter by more than half', one%mean > 0.5_wp)
  end subroutine check_threads

  !> A model without stress has no error and no worst point.
  subroutine check_no_stress(tests, model)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> The model.
    type(model_type), intent(in) :: model
    type(stress_error_type) :: estimate

    call estimate_stress_error(model, estimate)
    call tests%check('without stress there is no error', estimate%worst_point == 0 .and. &
      size(estimate%at_point) == model%state%points%count .and. .not. any(abs(estimate%at_point) > 0.0_wp))
  end subroutine check_no_stress
end module test_stress_error
