!> Contact on the outline of a rigid body: places and lengths of outlines, which of them soil touches, nothing where
!> soil and body move as one, the matrix against differences, what is kept of a step and what parts.
module test_body_contact
  use qsmpm_analysis, only: analysis_type
  use qsmpm_phase_description, only: initial_stress_type, initial_given
  use qsmpm_body_points, only: body_points_type, present_body_points, keep_body_points, touch_body_points
  use qsmpm_contact_patches, only: contact_patches_type, find_patches
  use qsmpm_contact_report, only: contact_check_type, begin_contact_check, end_contact_check
  use qsmpm_contact_results, only: contact_pressure_at, contact_slip_on, widest_gap
  use qsmpm_contact_scratch, only: keep_contact_points
  use qsmpm_contacts, only: contacts_type
  use qsmpm_penetration, only: put_back
  use qsmpm_points, only: place_of
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_error, only: error_type
  use qsmpm_initial_contact, only: press_on_bodies
  use qsmpm_initialisation, only: step_type, initialise_step, begin_analysis, evaluate_step
  use qsmpm_kept_arrays, only: kept_values, keep_values
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: tangent_none, step_info_type
  use qsmpm_linear_system, only: end_system
  use qsmpm_load_step, only: load_step_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_rigid_bodies, only: force_on_body, keep_rigid_body, placed_bodies, pose_of
  use qsmpm_rigid_outline, only: rigid_outline_type, lay_outline
  use qsmpm_rigid_pose, only: rigid_pose_type, placed_shape_type, carry_along
  use qsmpm_rigid_shape, only: rigid_shape_type, distance_type, ball, half_space, rounded_polygon, box_polygon, &
    cone_polygon
  use qsmpm_space, only: node_position
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_term, only: increment_type
  use qsmpm_term_sums, only: begin_terms, commit_terms, set_loads
  use qsmpm_unknowns, only: all_nodes
  use deck_samples, only: joined
  use scripted_solver, only: test_observer_type
  use term_samples, only: force_named, matrix_and_difference
  use testing, only: tests_type
  implicit none
  private

  public :: collect_body_contact

  real(wp), parameter :: difference = 1.0e-6_wp, pi = acos(-1.0_wp)
  !> A block with a notch, and the box that fills it.
  character(len=*), parameter :: block = '|*GRID, ELEMENT=QUAD4|X, 0, 2, 10|Y, 0, 1.6, 8|'// &
    '*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, '// &
    'SHAPE=POLYGON|0, 0|2, 0|2, 1.1|1.45, 1.1|1.45, 0.65|0.55, 0.65|0.55, 1.1|0, 1.1|*METHOD, BASIS=SPLINE2, '// &
    'INTEGRATION=POINTS|*RIGID BODY, NAME=tool, SHAPE=BOX, ROUND=0.05|0.55, 1.45, 0.65, 1.3|'
  character(len=*), parameter :: press = '*PHASE, NAME=press|*FIX|base, ALL|*CONTROLS, MAX ITERATIONS=100|'// &
    '*MOVE, BODY=tool'

contains

  !> All tests of the suite.
  subroutine collect_body_contact(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('body_contact')
    call check_outlines(tests)
    call check_touch(tests)
    call check_axis(tests)
    call check_beyond(tests)
    call check_at_end(tests)
    call check_round_gap(tests)
    call check_rigid_motion(tests)
    call check_tangent(tests, 'FRICTION ANGLE=30', '')
    ! 10 E/h 0.03 tan(0.3 degrees) is less than E/h 0.01: it slips.
    call check_tangent(tests, 'FRICTION ANGLE=0.3', '')
    call check_tangent(tests, 'TENSION=YES, ADHESION=1', '')
    call check_tangent(tests, 'FRICTION ANGLE=30|*CONFINING PRESSURE|40', '|*INITIAL, TYPE=ISOTROPIC|0, 40')
    call check_confined(tests)
    call check_opening(tests)
    call check_put_back(tests)
    call check_step(tests)
    call check_rest(tests)
    call check_two(tests)
    call check_idle(tests)
    call check_parted(tests)
    call check_short(tests)
    call check_places(tests)
    call check_one_point(tests)
    call check_kept(tests)
    call check_circle_gap(tests)
  end subroutine collect_body_contact

  !> One material point beside the flat base: it touches what its box reaches, by half its width more to either side.
  subroutine check_one_point(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(body_points_type) :: points
    logical, allocatable :: expected(:)

    allocate (model, step)
    call make_step('FRICTION ANGLE=0', '|0, -0.01', model, step)
    call part_all(0.65_wp - 0.03_wp)
    allocate (expected, source=abs(points%position(1, :) - 1.0_wp) <= 1.5_wp*0.06_wp .and. points%position(2, :) < 0.651_wp)
    call tests%check('it touches three times its half width', count(expected) > 1 .and. all(points%touched .eqv. expected))
    call tests%check('closed, as if it had never opened', all(abs(points%opening - merge(0.0_wp, 1.0_wp, expected)) <= 0.0_wp))
    call part_all(0.65_wp - 0.031_wp)
    call tests%check('a box that ends before the body touches nothing', .not. any(points%touched))
    ! Inside of the body, nearest to the same base.
    call part_all(0.65_wp + 0.1_wp)
    call tests%check('from within it touches as far as it is large', all(points%touched .eqv. (expected .and. &
      hypot(points%position(1, :) - 1.0_wp, points%position(2, :) - 0.75_wp) <= 3.0_wp*0.06_wp)))
    call end_system(step%system)
  contains
    !> Open all places and bring them what the first point touches, of 0.06 by 0.03, below the middle of the base.
    subroutine part_all(height)
      real(wp), intent(in) :: height

      call present_body_points(model, placed_bodies(model), points)
      points%opening = 1.0_wp
      call keep_body_points(model, points)
      model%state%points%position = -9.0_wp
      model%state%points%position(:, 1) = [1.0_wp, height]
      model%state%points%half_size(:, 1) = [0.06_wp, 0.03_wp]
      call touch_body_points(model, placed_bodies(model))
      call present_body_points(model, placed_bodies(model), points)
    end subroutine part_all
  end subroutine check_one_point

  !> What places keep, pressure and shear in means of patches, is what the body does before anything moves; as much comes
  !> to its force and its moment.
  subroutine check_kept(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(body_points_type) :: points
    type(distance_type) :: distance
    real(wp), allocatable :: u(:, :), push(:, :)
    real(wp) :: expected(6), traction(2), arm(2), kept(6)
    integer :: i

    allocate (model, step)
    call make_step('FRICTION ANGLE=45', '|0, -0.01', model, step)
    call present_body_points(model, placed_bodies(model), points)
    expected = 0.0_wp
    where (points%touched) points%pressure = 5.0_wp
    do i = 1, points%count
      if (.not. points%touched(i)) cycle
      ! On patches of the flat base more, and shear.
      associate (mine => points%patch == points%patch(i))
        if (any(mine .and. (points%position(2, :) > 0.651_wp .or. abs(points%position(1, :) - 1.0_wp) > 0.4_wp))) cycle
      end associate
      points%pressure(i) = 5.0_wp + points%patch(i)
      points%shear(1, i) = 2.0_wp
    end do
    do i = 1, points%count
      if (.not. points%touched(i)) cycle
      associate (mine => points%touched .and. points%patch == points%patch(i))
        distance = model%rigid_shapes(1)%distance_at([points%position(:, i), 0.0_wp])
        traction = [sum(points%shear(1, :)*points%area, mask=mine)/sum(points%area, mask=mine), 0.0_wp]
        traction = points%pressure(i)*distance%normal(:2) + traction &
          - dot_product(traction, distance%normal(:2))*distance%normal(:2)
        arm = points%position(:, i) - model%rigid_shapes(1)%reference(:2)
        expected([1, 2]) = expected([1, 2]) - points%area(i)*traction
        expected(6) = expected(6) - points%area(i)*(arm(1)*traction(2) - arm(2)*traction(1))
      end associate
    end do
    call keep_body_points(model, points)
    call again(model, step)
    allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
    allocate (push, source=force_named(step, 'force of the contacts', u))
    call tests%close('before anything moves the body pushes as it did', norm2(sum(push, dim=2) + expected(:2)), 0.0_wp, &
      1.0e-12_wp*norm2(expected))
    call commit_terms(step%terms, u, model)
    kept = force_on_body(model, 1)
    call tests%close('so much comes to it, with its moment', norm2(kept - expected), 0.0_wp, 1.0e-12_wp*norm2(expected))
    call end_system(step%system)
  end subroutine check_kept

  !> Before a round body the ground that is looked at widens: as much soil as is there leaves no gap, half of it half of the
  !> depth.
  subroutine check_circle_gap(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    type(body_points_type) :: points
    real(wp) :: place(2), width
    integer :: body

    allocate (model, analysis)
    call parse_deck('circle.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 20|Y, 0, 2, 20|*NSET, '// &
      'NSET=base, PLANE=Y|0|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|'// &
      '0, 2, 0, 2|*METHOD, BASIS=GIMP, INTEGRATION=POINTS|*RIGID BODY, NAME=tool, SHAPE=CIRCLE, IN PLACE=YES|'// &
      '1, 1, 0.3|*CONTACT, BODY=tool, ON=BODY|'//press//'|0, -0.01|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'a deck of the body contact suite is broken'
    call present_body_points(model, placed_bodies(model), points)
    points%touched = .true.
    points%pressure = 1.0_wp
    call keep_body_points(model, points)
    call widest_gap(model, placed_bodies(model), body, place, width)
    call tests%close('no gap', width, 0.0_wp, 0.02_wp)
    model%state%points%volume = 0.5_wp*model%state%points%volume
    call widest_gap(model, placed_bodies(model), body, place, width)
    call tests%close('half of the depth of a cell and a half', width, 0.075_wp, 0.01_wp)
    call tests%check('at the body', body == 1 .and. abs(norm2(place - 1.0_wp) - 0.3_wp) < 0.02_wp)
    ! Cells that are wider by a fifth and more are not looked at.
    model%cell_size = model%cell_size/1.19_wp
    call widest_gap(model, placed_bodies(model), body, place, width)
    call tests%check('in cells a little wider', body == 1)
    model%cell_size = model%cell_size*1.19_wp/1.21_wp
    call widest_gap(model, placed_bodies(model), body, place, width)
    call tests%check('in wide cells nothing is said', body == 0)
  end subroutine check_circle_gap

  !> Outlines are where the distance is zero, as long as they are, in equal parts.
  subroutine check_outlines(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: corner(2, 6) = reshape([0.0_wp, 0.0_wp, 2.0_wp, 0.0_wp, 2.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, &
      1.0_wp, 3.0_wp, 0.0_wp, 3.0_wp], [2, 6])
    type(rigid_outline_type) :: outline

    call check_outline('of a circle', ball([1.0_wp, 2.0_wp, 0.0_wp], 0.5_wp), pi)
    ! Rounding takes 2 - pi/2 radii of each right angle.
    call check_outline('of a box', rounded_polygon(box_polygon([0.0_wp, 0.0_wp], [3.0_wp, 1.0_wp]), 0.2_wp), &
      8.0_wp - 0.2_wp*(8.0_wp - 2.0_wp*pi))
    call check_outline('with a concave corner', rounded_polygon(corner, 0.1_wp), &
      10.0_wp - 0.1_wp*(10.0_wp - 2.5_wp*pi))
    ! Flank 2 and shaft 3 at each side, 2 above.
    call check_outline('of a cone', rounded_polygon(cone_polygon([0.0_wp, 0.0_wp], 1.0_wp, pi/6.0_wp, &
      3.0_wp), 1.0e-9_wp), &
      12.0_wp)
    call lay_outline(half_space([0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 1.0_wp, 0.0_wp]), 0.1_wp, 4, outline)
    call tests%check('a plane has no outline', outline%count == 0)
    call lay_outline(ball([0.0_wp, 0.0_wp, 0.0_wp], 1.0_wp), 0.3_wp, 5, outline)
    call tests%check('parts are a multiple of four', maxval(outline%part) == 20 .and. count(outline%part == 7) == 5)
    call tests%check('a circle begins at its lowest point', all(outline%place(1, :50) > 0.0_wp) .and. &
      all(outline%place(1, 51:) < 0.0_wp) .and. outline%place(2, 1) < -0.99_wp)

  contains

    !> Length, distance and parts of one.
    subroutine check_outline(what, shape, length)
      character(len=*), intent(in) :: what
      type(rigid_shape_type), intent(in) :: shape
      real(wp), intent(in) :: length
      type(distance_type) :: distance
      real(wp) :: farthest
      integer :: i

      call lay_outline(shape, 0.2_wp, 6, outline)
      farthest = 0.0_wp
      do i = 1, outline%count
        distance = shape%distance_of([outline%place(:, i), 0.0_wp])
        farthest = max(farthest, abs(distance%value))
      end do
      call tests%close('places on the outline '//what, farthest, 0.0_wp, 1.0e-12_wp)
      call tests%close('length '//what, sum(outline%length), length, 1.0e-6_wp)
      call tests%check('the first place follows the last '//what, norm2(outline%place(:, 1) &
        - outline%place(:, outline%count)) <= 1.01_wp*outline%length(1))
    end subroutine check_outline
  end subroutine check_outlines

  !> A place on the axis of revolution stands for no area: a patch of it would carry no force for ever.
  subroutine check_axis(tests)
    type(tests_type), intent(inout) :: tests
    !> How far beyond the axis rounding may put a place.
    real(wp), parameter :: beyond = 1.0e-12_wp
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(placed_shape_type), allocatable :: bodies(:)
    type(body_points_type) :: points
    integer :: i

    allocate (model, step)
    call make_step('FRICTION ANGLE=0', '|0, -0.01', model, step, revolved='AXISYMMETRIC')
    bodies = placed_bodies(model)
    call present_body_points(model, bodies, points)
    i = findloc(points%touched .and. points%position(2, :) < 0.66_wp, .true., dim=1)
    call tests%check('a place at a radius touches soil over it', points%area(i) > 0.0_wp)
    bodies(1)%pose%displacement(1) = -points%position(1, i) - beyond
    call present_body_points(model, bodies, points)
    call tests%check('moved to the axis it has a cell and no area, and is not in contact', points%cell(i) > 0 .and. &
      .not. points%area(i) > 0.0_wp .and. .not. points%touched(i))
    call tests%close('areas are lengths times radii', maxval(abs(points%area - model%body_outlines(1)%length* &
      max(0.0_wp, points%position(1, :)))), 0.0_wp, 1.0e-15_wp)
    call tests%check('its neighbours are', any(points%touched) .and. all(points%area > 0.0_wp .or. .not. points%touched))
    call end_system(step%system)
  end subroutine check_axis

  !> What the body carries beyond the end of the mesh is in no cell and in no contact; the rest is.
  subroutine check_beyond(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(placed_shape_type), allocatable :: bodies(:)
    type(body_points_type) :: points
    logical, allocatable :: before(:)
    real(wp) :: place(2), width
    integer :: body

    allocate (model, step)
    call make_step('FRICTION ANGLE=0', '|0, -0.01', model, step)
    allocate (bodies, source=placed_bodies(model))
    call present_body_points(model, bodies, points)
    allocate (before, source=points%touched)
    bodies(1)%pose%displacement(1) = 1.0_wp
    call present_body_points(model, bodies, points)
    associate (inside => points%position(1, :) < 2.0_wp)
      call tests%check('places of both kinds', any(before .and. inside) .and. any(before .and. .not. inside))
      call tests%check('beyond the mesh nothing touches', all(points%touched .eqv. (before .and. inside)))
      call tests%check('there is no cell', all(points%cell > 0 .eqv. (before .and. inside)))
      call tests%close('a cell is as large as those of the grid', maxval(abs(points%cell_size - merge(0.2_wp, 0.0_wp, &
        before .and. inside))), 0.0_wp, 1.0e-14_wp)
    end associate
    ! What is beyond the mesh opens no patch beside it, as what nothing touches in the mesh does.
    points%pressure = 0.0_wp
    where (points%patch == points%patch(minloc(hypot(points%position(1, :) - 1.9_wp, points%position(2, :) - 0.65_wp), &
      dim=1))) points%pressure = 1.0_wp
    points%touched = before
    call keep_body_points(model, points)
    allocate (model%part%points(model%state%points%count), source=.false.)
    call widest_gap(model, bodies, body, place, width)
    call tests%check('a patch that ends at the end of the mesh is looked at', body == 1)
    call tests%check('its middle is that of what is in the mesh', place(1) < 2.0_wp .and. abs(place(2) - 0.65_wp) < 0.01_wp)
    call end_system(step%system)
  end subroutine check_beyond

  !> A side of the body that lies on the end of the mesh, as on a plane of symmetry, opens no patch beside it.
  subroutine check_at_end(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(placed_shape_type), allocatable :: bodies(:)
    type(body_points_type) :: points
    real(wp) :: end_of_mesh, place(2), width
    integer :: body, side, i

    allocate (model, step)
    call make_step('FRICTION ANGLE=0', '|0, -0.01', model, step)
    allocate (bodies, source=placed_bodies(model))
    allocate (model%part%points(model%state%points%count), source=.false.)
    do side = 0, 1
      end_of_mesh = 2.0_wp*side
      do i = 1, 3
        call present_body_points(model, bodies, points)
        bodies(1)%pose%displacement(1) = bodies(1)%pose%displacement(1) + end_of_mesh &
          - merge(maxval(points%position(1, :)), minval(points%position(1, :)), side == 1)
      end do
      call present_body_points(model, bodies, points)
      points%touched = abs(points%position(1, :) - end_of_mesh) > 1.0e-9_wp
      points%pressure = 0.0_wp
      where (points%patch == points%patch(minloc(hypot(points%position(1, :) - abs(end_of_mesh - 0.1_wp), &
        points%position(2, :) - 0.65_wp), dim=1))) points%pressure = 1.0_wp
      points%opening = merge(0.0_wp, 1.0_wp, points%touched)
      call tests%check('a side is on the end of the mesh', any(abs(points%position(1, :) - end_of_mesh) <= 0.0_wp))
      call keep_body_points(model, points)
      call widest_gap(model, bodies, body, place, width)
      call tests%check('and opens no patch', body == 1)
    end do
    call end_system(step%system)
  end subroutine check_at_end

  !> Half of the soil before a patch is missing: a gap of half the depth that is looked at, around an axis as in the plane.
  subroutine check_round_gap(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: plane(3), round(3)

    plane = gap_in('PLANE STRAIN')
    round = gap_in('AXISYMMETRIC')
    ! Points fill the depth but for a tenth.
    call tests%close('a gap in the plane', plane(3), 0.5_wp*1.5_wp*0.2_wp, 0.03_wp)
    call tests%close('around an axis it is as wide', norm2(round - plane), 0.0_wp, 0.03_wp)

  contains

    !> Place and width.
    function gap_in(kind) result(found)
      character(len=*), intent(in) :: kind
      real(wp) :: found(3)
      class(model_type), allocatable :: model
      class(step_type), allocatable :: step
      type(body_points_type) :: points
      real(wp) :: place(2), width
      integer :: body, base

      allocate (model, step)
      call make_step('FRICTION ANGLE=0', '|0, -0.01', model, step, revolved=kind)
      call present_body_points(model, placed_bodies(model), points)
      base = minloc(hypot(points%position(1, :) - 1.2_wp, points%position(2, :) - 0.65_wp), dim=1)
      points%pressure = merge(1.0_wp, 0.0_wp, points%patch == points%patch(base))
      call keep_body_points(model, points)
      model%state%points%volume = 0.5_wp*model%state%points%volume
      call widest_gap(model, placed_bodies(model), body, found(:2), found(3))
      call tests%check('before the body', body == 1)
      allocate (model%part%points(model%state%points%count), source=.false.)
      call widest_gap(model, placed_bodies(model), body, place, width)
      call tests%close('without soil of its own all is missing', width, 0.3_wp, 1.0e-12_wp)
      ! A tenth of a sector of 0.3 by 0.3, be it the first point.
      model%part%points(1) = .true.
      model%state%points%position(:, 1) = [1.2_wp, 0.6_wp]
      model%state%points%volume(1) = 0.009_wp*merge(1.2_wp, 1.0_wp, kind == 'AXISYMMETRIC')
      call widest_gap(model, placed_bodies(model), body, place, width)
      call tests%close('all but a tenth', width, 0.27_wp, 0.01_wp)
      call end_system(step%system)
    end function gap_in
  end subroutine check_round_gap

  !> A model with the box in its notch, and its first step.
  subroutine make_step(contact, move, model, step, revolved)
    !> Rest of *CONTACT, with cards behind it; rest of *MOVE and its data line, with cards of the phase behind it.
    character(len=*), intent(in) :: contact, move
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    !> The model, unless plane strain.
    character(len=*), intent(in), optional :: revolved
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: plane

    plane = 'PLANE STRAIN'
    if (present(revolved)) plane = revolved
    allocate (analysis)
    call parse_deck('notch.inp', joined('*MODEL, TYPE='//plane//block//'*CONTACT, BODY=tool, ON=BODY, '// &
      contact//'|'//press//move//'|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'a deck of the body contact suite is broken'
    call begin_analysis(model, step%terms)
    call start_phase(model)
    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'a step of the body contact suite cannot be made'
    call begin_terms(step%terms, increment_type(step_info_type(duration=0.5_wp, phase_time=1.0_wp)))
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
  end subroutine make_step

  !> Soil touches what it lies against, and no other place.
  subroutine check_touch(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(body_points_type) :: points
    type(placed_shape_type), allocatable :: bodies(:)
    real(wp) :: expected

    allocate (model, step)
    call make_step('FRICTION ANGLE=0', '|0, -0.01', model, step)
    call present_body_points(model, placed_bodies(model), points)
    expected = 0.9_wp + 0.9_wp - 0.05_wp*(4.0_wp - pi)
    call tests%close('length that soil touches', sum(points%area, mask=points%touched), expected, 0.1_wp*expected)
    call tests%check('nothing above the ground', all(points%position(2, :) < 1.2_wp .or. .not. points%touched))
    call tests%check('places in contact know their cells', all(points%cell > 0 .or. .not. points%touched) .and. &
      all(abs(points%local) <= 1.0_wp + 1.0e-9_wp))
    ! The boxes of the points end where the tool does, but those to its right are moved away: its right side has opened,
    ! and does not close.
    associate (x => model%state%points%position(1, :))
      where (x > 1.45_wp) x = x + 0.01_wp
    end associate
    points%opening = 1.0_wp
    call keep_body_points(model, points)
    call present_body_points(model, placed_bodies(model), points)
    call tests%check('places that have opened by a cell part', .not. any(points%touched))
    call tests%close('where nothing touches no pressure', contact_pressure_at(model, [1.0_wp, 0.65_wp]), 0.0_wp, 0.0_wp)
    ! Half a box above the soil.
    allocate (bodies, source=placed_bodies(model))
    bodies(1)%pose%displacement(2) = 0.5_wp*model%state%points%half_size(2, 1)
    call touch_body_points(model, bodies)
    call present_body_points(model, bodies, points)
    call tests%check('boxes that do not reach a place do not touch it', .not. any(points%touched .and. &
      points%initial_position(2, :) < 0.651_wp .and. abs(points%initial_position(1, :) - 1.0_wp) < 0.3_wp))
    call touch_body_points(model, bodies, 2.0_wp)
    call present_body_points(model, bodies, points)
    call tests%check('twice the boxes do', all(points%touched .or. points%initial_position(2, :) > 0.651_wp .or. &
      abs(points%initial_position(1, :) - 1.0_wp) > 0.3_wp))
    points%opening = 1.0_wp
    call keep_body_points(model, points)
    call touch_body_points(model, placed_bodies(model))
    call present_body_points(model, placed_bodies(model), points)
    call tests%check('a box that reaches a place touches it', any(points%touched) .and. &
      all(points%opening <= 0.0_wp .or. .not. points%touched))
    call tests%close('all that boxes reach', sum(points%area, mask=points%touched), expected - 0.45_wp, 0.1_wp*expected)
    call tests%check('no other', .not. any(points%touched .and. points%position(1, :) > 1.449_wp))
    points%touched = .true.
    points%opening = 0.02_wp
    call keep_body_points(model, points)
    call present_body_points(model, placed_bodies(model), points)
    call check_gap(tests, model, points)
    call tests%check('with a small opening they stay', all(points%touched) .and. all(points%opening > 0.01_wp))
    call end_system(step%system)
  end subroutine check_touch

  !> Soil that presses from afar: the places above the ground do not touch any.
  subroutine check_gap(tests, model, points)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    !> All in contact.
    type(body_points_type), intent(inout) :: points
    real(wp) :: place(2), width
    integer :: body

    points%pressure = 0.0_wp
    call keep_body_points(model, points)
    call widest_gap(model, placed_bodies(model), body, place, width)
    call tests%check('what does not press is not asked for', body == 0 .and. width <= 0.0_wp)
    where (points%position(2, :) < 1.0_wp) points%pressure = 1.0_wp
    call keep_body_points(model, points)
    call widest_gap(model, placed_bodies(model), body, place, width)
    ! Points fill the sectors of the corners up to half a cell; three quarters are warned of.
    call tests%close('beside the soil next to none', width, 0.0_wp, 0.15_wp)
    call tests%check('at the body', body == 1)
    where (points%position(2, :) > 1.29_wp) points%pressure = 1.0_wp
    call keep_body_points(model, points)
    call widest_gap(model, placed_bodies(model), body, place, width)
    call tests%check('above it all of the sector is missing', abs(width - 0.3_wp) < 0.05_wp .and. place(2) > 1.2_wp)
    call check_open(tests, model, points)
    points%pressure = merge(1.0_wp, 0.0_wp, points%patch == 1)
    call keep_body_points(model, points)
    call widest_gap(model, placed_bodies(model), body, place, width)
    call tests%check('the first patch is looked at too', body == 1 .and. norm2(place - [ &
      sum(points%position(1, :), mask=points%patch == 1), sum(points%position(2, :), mask=points%patch == 1)] &
      /count(points%patch == 1)) < 0.01_wp)
  end subroutine check_gap

  !> A patch beside one that nothing touches is left out, on either side of it.
  subroutine check_open(tests, model, points)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    !> All in contact.
    type(body_points_type), intent(in) :: points
    type(body_points_type) :: some
    real(wp) :: width(-1:1), place(2)
    integer :: body(-1:1), at, side

    at = points%patch(maxloc(points%position(2, :), dim=1))
    do side = -1, 1
      some = points
      some%pressure = merge(1.0_wp, 0.0_wp, points%patch == at)
      where (points%patch == at + side .and. side /= 0) some%opening = 1.0_wp
      call keep_body_points(model, some)
      call widest_gap(model, placed_bodies(model), body(side), place, width(side))
      call keep_body_points(model, points)
    end do
    call tests%check('a patch beside an open one is left out', all(body == [0, 1, 0]) .and. all(abs(width([-1, 1])) <= 0.0_wp))
    some = points
    some%pressure = merge(1.0_wp, 0.0_wp, points%patch == at)
    some%opening(maxloc(points%position(2, :), dim=1)) = 1.0_wp
    call keep_body_points(model, some)
    call widest_gap(model, placed_bodies(model), body(0), place, width(0))
    call keep_body_points(model, points)
    call tests%check('and so is one with an open place of its own', body(0) == 0)
  end subroutine check_open

  !> Soil that moves and turns as the body does feels nothing of it.
  subroutine check_rigid_motion(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(placed_shape_type), allocatable :: bodies(:)
    real(wp), allocatable :: u(:, :)
    real(wp) :: x(3)
    integer :: a

    allocate (model, step)
    call make_step('TENSION=YES, ADHESION=5', ', ROTATION=4|0.03, -0.05', model, step)
    allocate (bodies, source=placed_bodies(model))
    allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
    do a = 1, model%space%node_count
      x = 0.0_wp
      x(:2) = node_position(model%space, model%mesh, a)
      x = carry_along(bodies(1)%reference, rigid_pose_type(), rigid_pose_type([0.015_wp, -0.025_wp, 0.0_wp], &
        [0.0_wp, 0.0_wp, 2.0_wp*pi/180.0_wp]), x) - x
      u(:, a) = x(:2)
    end do
    call evaluate_step(model, step, u, tangent_none)
    call tests%close('no force in a rigid motion', maxval(abs(force_named(step, 'force of the contacts', u))), 0.0_wp, &
      1.0e-7_wp)
    u(1, :) = u(1, :) + 1.0e-3_wp
    call evaluate_step(model, step, u, tangent_none)
    call tests%check('but in any other', maxval(abs(force_named(step, 'force of the contacts', u))) > 1.0_wp)
    call end_system(step%system)
  end subroutine check_rigid_motion

  !> The matrix times a direction is the change of the residual along it.
  subroutine check_tangent(tests, contact, start)
    type(tests_type), intent(inout) :: tests
    !> Rest of *CONTACT, and cards of the phase.
    character(len=*), intent(in) :: contact, start
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: u(:, :), v(:, :), product(:), change(:)
    integer :: a

    allocate (model, step)
    call make_step(contact, ', ROTATION=1|0.01, -0.03'//start, model, step)
    allocate (u(2, all_nodes(step%unknowns)), v(2, all_nodes(step%unknowns)))
    do a = 1, size(u, 2)
      u(:, a) = 1.0e-3_wp*[sin(1.7_wp*a), cos(2.3_wp*a)]
      v(:, a) = [cos(0.7_wp*a), sin(1.1_wp*a)]
    end do
    call matrix_and_difference(model, step, u, v, difference, product, change)
    call tests%close('the matrix is the derivative of the residual, '//contact, maxval(abs(product - change)), 0.0_wp, &
      1.0e-6_wp*maxval(abs(change)))
    call end_system(step%system)
  end subroutine check_tangent

  !> What has opened in earlier steps closes before it presses.
  subroutine check_opening(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    real(wp) :: whole, half, most

    allocate (model)
    half = force_after(0.005_wp)
    whole = force_after(0.0_wp)
    call tests%close('a body that goes down by 0.01 presses on a flat patch by 10 E/h 0.01', most, 500.0_wp, 1.0e-8_wp)
    ! The corners of the base, 0.9 wide, take less.
    call tests%check('and on the base by less than on its width', whole > 0.8_wp*450.0_wp .and. whole < 450.0_wp)
    call tests%close('half as much on what was open by half of it', half, 0.5_wp*whole, 0.05_wp*whole)
    call tests%close('and not at all on what was open by more', force_after(0.011_wp), 0.0_wp, 1.0e-12_wp)
  contains
    !> Vertical force on the block, which stands still, of the smooth box that goes down by 0.01.
    real(wp) function force_after(opening)
      !> Of all places, before.
      real(wp), intent(in) :: opening
      class(step_type), allocatable :: step
      type(body_points_type) :: points
      type(error_type), allocatable :: error
      real(wp), allocatable :: u(:, :), push(:, :)

      allocate (step)
      call make_step('FRICTION ANGLE=0', '|0, -0.02', model, step)
      call present_body_points(model, placed_bodies(model), points)
      points%opening = opening
      call keep_body_points(model, points)
      call initialise_step(model, step, error)
      if (allocated(error)) error stop 'a step of the body contact suite cannot be made'
      call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
      allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
      call evaluate_step(model, step, u, tangent_none)
      allocate (push, source=force_named(step, 'force of the contacts', u))
      force_after = -sum(push(2, :))
      call commit_terms(step%terms, u, model)
      call present_body_points(model, placed_bodies(model), points)
      most = maxval(points%pressure)
      call end_system(step%system)
    end function force_after
  end subroutine check_opening

  !> What is kept of a step that is taken.
  subroutine check_step(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(load_step_type) :: solver
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    type(body_points_type) :: points
    real(wp) :: force(6), pressure

    allocate (model, step)
    call make_step('FRICTION ANGLE=20', '|0, -0.02', model, step)
    ! Places in the air that pressed before.
    call present_body_points(model, placed_bodies(model), points)
    where (points%position(2, :) > 1.2_wp) points%pressure = 5.0_wp
    points%shear = spread(points%pressure, 1, 3)
    call keep_body_points(model, points)
    call initialise_step(model, step, error)
    call solver%solve(model, step, model%analysis%phases(1)%controls, attempt_type(1.0_wp, 1.0e-9_wp, &
      largest_move=1.0_wp), solution, error)
    call tests%check('the step is taken', solution%converged .and. .not. allocated(error))
    force = force_on_body(model, 1)
    call tests%close('the base carries what the body does', force(2), sum(model%state%reactions(2, :)), &
      1.0e-6_wp*force(2))
    call present_body_points(model, placed_bodies(model), points)
    call tests%close('the places have moved with the body', maxval(abs(points%position(2, :) + 0.02_wp &
      - points%initial_position(2, :))), 0.0_wp, 1.0e-14_wp)
    pressure = contact_pressure_at(model, [1.0_wp, 0.65_wp])
    call tests%check('the middle of the base presses', pressure > 1.0_wp)
    pressure = contact_pressure_at(model, [1.0_wp, -5.0_wp])
    call tests%close('from afar it is that of the nearest place', pressure, &
      points%pressure(minloc(norm2(points%initial_position(:2, :) - spread([1.0_wp, -5.0_wp], 2, points%count), dim=1), &
      mask=points%touched, dim=1)), 1.0e-12_wp)
    call tests%check('and so does no place above the ground', .not. any(points%pressure > 0.0_wp .and. &
      points%position(2, :) > 1.2_wp))
    ! The base is flat: what it carries is its share of the pressures along the vertical, the rest is friction.
    call tests%check('a part of the force is friction on the sides', force(2) > sum(points%area*points%pressure, &
      mask=points%initial_position(2, :) < 0.66_wp))
    call tests%check('places in contact have slipped, no others', maxval(norm2(points%slip, dim=1)) > 1.0e-3_wp .and. &
      all(points%pressure > 0.0_wp .or. norm2(points%slip, dim=1) <= 0.0_wp))
    call tests%close('the largest slip', contact_slip_on(model, 1, .false.), maxval(norm2(points%slip, dim=1), &
      mask=points%pressure > 0.0_wp), 1.0e-14_wp)
    call tests%close('the mean slip', contact_slip_on(model, 1, .true.), sum(norm2(points%slip, dim=1)*points%area, &
      mask=points%pressure > 0.0_wp)/sum(points%area, mask=points%pressure > 0.0_wp), 1.0e-14_wp)
    call tests%check('shear is kept, within its friction', maxval(norm2(points%shear, dim=1)) > 1.0_wp .and. &
      all(norm2(points%shear, dim=1) <= (1.0_wp + 1.0e-9_wp)*tan(pi/9.0_wp)*points%pressure))
    call check_near(tests, step, model)
    call end_system(step%system)
  end subroutine check_step

  !> What has opened comes into contact again at the end of a step when soil is near.
  subroutine check_near(tests, step, model)
    type(tests_type), intent(inout) :: tests
    type(step_type), intent(inout) :: step
    type(model_type), intent(inout) :: model
    type(body_points_type) :: points
    integer :: t

    do t = 1, size(step%terms)
      select type (term => step%terms(t)%term)
      class is (contacts_type)
        term%scratch%on_bodies%opening = 1.0_wp
        call keep_contact_points(term%scratch, model)
      end select
    end do
    call present_body_points(model, placed_bodies(model), points)
    call tests%check('soil that is near touches again', any(points%touched) .and. .not. all(points%touched))
  end subroutine check_near

  !> Contact on two bodies: the places of each lie on it.
  subroutine check_two(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(body_points_type) :: points
    type(placed_shape_type), allocatable :: bodies(:)
    type(distance_type) :: distance
    type(rigid_pose_type) :: pose
    real(wp) :: furthest
    integer :: i

    allocate (model, step)
    call make_step('FRICTION ANGLE=0|*RIGID BODY, NAME=other, SHAPE=CIRCLE|1, 1.45, 0.1|*CONTACT, BODY=other, ON=BODY', &
      '|0, -0.01', model, step)
    allocate (bodies, source=placed_bodies(model))
    call present_body_points(model, bodies, points)
    call tests%close('a body that nothing presses on has no slip', contact_slip_on(model, 2, .false.) &
      + contact_slip_on(model, 2, .true.), 0.0_wp, 0.0_wp)
    furthest = 0.0_wp
    do i = 1, points%count
      distance = bodies(points%pair(i))%distance_at([points%position(:, i), 0.0_wp])
      furthest = max(furthest, abs(distance%value))
    end do
    call tests%check('both bodies have places', any(points%pair == 1) .and. any(points%pair == 2))
    call tests%close('each on its own body', furthest, 0.0_wp, 1.0e-12_wp)
    call keep_values(model%state%kept, 'rigid_bodies', kept_values(model%state%kept, 'rigid_bodies') + 3.0_wp)
    call keep_rigid_body(model, 2, rigid_pose_type([1.0_wp, 2.0_wp, 3.0_wp], [4.0_wp, 5.0_wp, 6.0_wp]), &
      [(0.5_wp*i, i=1, 6)])
    pose = pose_of(model, 2)
    call tests%close('where a body is', norm2([pose%displacement, pose%rotation] - [(1.0_wp*i, i=1, 6)]), 0.0_wp, 0.0_wp)
    call tests%close('what is kept of a body', norm2(force_on_body(model, 2) - [(0.5_wp*i, i=1, 6)]), 0.0_wp, 1.0e-15_wp)
    call tests%close('leaves the other one as it is', norm2(force_on_body(model, 1) - 3.0_wp), 0.0_wp, 1.0e-15_wp)
    call end_system(step%system)
  end subroutine check_two

  !> Under an all-round pressure soil with that stress and a body beside it are at rest, however the cells are cut; the
  !> pressure is whole, and the force on the body counts from it.
  subroutine check_confined(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(initial_stress_type) :: initial
    type(body_points_type) :: points
    real(wp), allocatable :: u(:, :)
    real(wp), parameter :: all_round = 40.0_wp
    integer :: p

    allocate (model, step)
    call make_step('FRICTION ANGLE=10|*CONFINING PRESSURE|40', '|0, -0.01|*INITIAL, TYPE=ISOTROPIC|0, 40', &
      model, step)
    do p = 1, model%state%points%count
      model%state%points%stress(:, p) = [-all_round, -all_round, -all_round, 0.0_wp]
      call model%laws(1)%law%start(model%state%points%stress(:, p), model%state%points%state(:, p))
    end do
    initial%kind = initial_given
    call press_on_bodies(model, initial)
    call present_body_points(model, placed_bodies(model), points)
    call tests%close('the pressure on the body is whole', maxval(abs(pack(points%pressure, points%touched) &
      - all_round)), 0.0_wp, 1.0e-12_wp)
    call again(model, step)
    allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
    call tests%close('the body pushes nothing above the pressure', maxval(abs(force_named(step, &
      'force of the contacts', u))), 0.0_wp, 1.0e-12_wp)
    call evaluate_step(model, step, u, tangent_none)
    call tests%close('nor does the soil', maxval(abs(step%forces%internal)), 0.0_wp, 1.0e-12_wp)
    call end_system(step%system)
  end subroutine check_confined

  !> The next step of a model, before anything moves.
  subroutine again(model, step)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    type(error_type), allocatable :: error

    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'a step of the body contact suite cannot be made'
    call begin_terms(step%terms, increment_type(step_info_type(duration=0.5_wp, phase_time=1.0_wp)))
    call set_loads(step%terms, model, step%configuration_type, 0.0_wp)
  end subroutine again

  !> Points inside of the body are put back onto its outline, no other is.
  subroutine check_put_back(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(placed_shape_type), allocatable :: bodies(:)
    type(distance_type) :: distance
    real(wp), allocatable :: before(:, :)
    real(wp) :: farthest
    integer :: p
    logical :: outside

    allocate (model, step)
    call make_step('FRICTION ANGLE=0', '|0, -0.01', model, step)
    allocate (bodies, source=placed_bodies(model))
    bodies(1)%pose%displacement(2) = -0.06_wp
    model%state%points%position(:, 1) = [1.0_wp, 0.7_wp]
    allocate (before, source=model%state%points%position)
    call put_back(model, bodies)
    farthest = 0.0_wp
    outside = .true.
    do p = 1, model%state%points%count
      distance = bodies(1)%distance_at(place_of(model%state%points, p))
      if (all(abs(model%state%points%position(:, p) - before(:, p)) <= 0.0_wp)) then
        outside = outside .and. distance%value >= 0.0_wp
      else
        farthest = max(farthest, abs(distance%value))
      end if
    end do
    call tests%check('what stays is outside', outside)
    call tests%check('some soil was inside', any(abs(model%state%points%position - before) > 0.0_wp))
    call tests%close('it is on the outline', farthest, 0.0_wp, 1.0e-14_wp)
    model%contact_pairs(1)%surface = 1
    model%state%points%position = before
    call put_back(model, bodies)
    call tests%check('where contact is on the soil points stay', all(abs(model%state%points%position - before) <= 0.0_wp))
    call end_system(step%system)
  end subroutine check_put_back

  !> Initial stresses press on the body: p = -n sigma n, t = -(1 - n n') sigma n.
  subroutine check_rest(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(initial_stress_type) :: initial
    type(body_points_type) :: points
    integer :: p, at_base, at_side

    allocate (model, step)
    call make_step('FRICTION ANGLE=0', '|0, -0.01', model, step)
    do p = 1, model%state%points%count
      model%state%points%stress(:, p) = [-3.0_wp, -8.0_wp, -3.0_wp, 2.0_wp]
    end do
    initial%kind = initial_given
    call press_on_bodies(model, initial)
    call present_body_points(model, placed_bodies(model), points)
    at_base = minloc(hypot(points%position(1, :) - 1.0_wp, points%position(2, :) - 0.65_wp), dim=1)
    at_side = minloc(hypot(points%position(1, :) - 1.45_wp, points%position(2, :) - 0.9_wp), dim=1)
    call tests%close('pressure at the base', points%pressure(at_base), 8.0_wp, 1.0e-12_wp)
    call tests%close('pressure at the side', points%pressure(at_side), 3.0_wp, 1.0e-12_wp)
    ! The base looks down, n = (0, -1): -sigma n = (2, -8).
    call tests%close('shear at the base', norm2(points%shear(:, at_base) - [2.0_wp, 0.0_wp, 0.0_wp]), 0.0_wp, &
      1.0e-12_wp)
    call tests%check('nothing presses where nothing touches', .not. all(points%touched) .and. &
      all(points%pressure <= 0.0_wp .or. points%touched))
    model%state%points%stress(2, :) = 8.0_wp
    call press_on_bodies(model, initial)
    call present_body_points(model, placed_bodies(model), points)
    call tests%check('what pulls has no shear', norm2(points%shear(:, at_base)) <= 0.0_wp .and. &
      points%pressure(at_base) <= 0.0_wp .and. points%touched(at_base))
    call end_system(step%system)
  end subroutine check_rest

  !> A body with contact on itself that nothing has touched yet: how far the nearest soil is.
  subroutine check_idle(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(contact_check_type) :: check
    type(test_observer_type) :: observer

    allocate (model, step)
    call make_step('FRICTION ANGLE=0', '|0, -0.01', model, step)
    model%state%progress%fraction = 1.0_wp
    call keep_rigid_body(model, 1, rigid_pose_type([0.0_wp, 1.0_wp, 0.0_wp]), spread(0.0_wp, 1, 6))
    call begin_contact_check(model, check)
    call keep_rigid_body(model, 1, rigid_pose_type([0.0_wp, 0.9_wp, 0.0_wp]), spread(0.0_wp, 1, 6))
    observer%text = ''
    call end_contact_check(model, check, observer)
    ! The base stands at 1.55, the highest points beside it at 1.05.
    call tests%check('the nearest soil is told: '//observer%text, index(observer%text, &
      "moves rigid body 'tool', and nothing is in contact with it: the nearest soil of its *CONTACT is 0.50") > 0)
    model%state%points%position(:, 1) = [1.0_wp, 1.3_wp]
    call keep_rigid_body(model, 1, rigid_pose_type([0.0_wp, 1.0_wp, 0.0_wp]), spread(0.0_wp, 1, 6))
    call begin_contact_check(model, check)
    call keep_rigid_body(model, 1, rigid_pose_type([0.0_wp, 0.9_wp, 0.0_wp]), spread(0.0_wp, 1, 6))
    observer%text = ''
    call end_contact_check(model, check, observer)
    call tests%check('the first point may be it: '//observer%text, index(observer%text, 'its *CONTACT is 0.25 away') > 0)
    call end_system(step%system)
  end subroutine check_idle

  !> What is kept of a step in which the body parts: by how much it is open, nothing of the pressure before, though the
  !> last evaluation was the one in which what it holds goes along.
  subroutine check_parted(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(body_points_type) :: points
    real(wp), allocatable :: u(:, :)
    integer :: at_base

    allocate (model, step)
    call make_step('FRICTION ANGLE=0', '|0, 0.16', model, step)
    call present_body_points(model, placed_bodies(model), points)
    points%pressure = merge(5.0_wp, 0.0_wp, points%touched)
    call keep_body_points(model, points)
    call again(model, step)
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
    call evaluate_step(model, step, u, tangent_none)
    call commit_terms(step%terms, u, model)
    call present_body_points(model, placed_bodies(model), points)
    at_base = minloc(hypot(points%initial_position(1, :) - 1.0_wp, points%initial_position(2, :) - 0.65_wp), dim=1)
    call tests%close('it is open by half of the move', points%opening(at_base), 0.08_wp, 1.0e-12_wp)
    call tests%close('and carries nothing', points%pressure(at_base), 0.0_wp, 0.0_wp)
    call end_system(step%system)
  end subroutine check_parted

  !> Places of one patch of which a few touch join the patch beside; points alone stay so.
  subroutine check_short(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(body_points_type) :: points
    type(contact_patches_type) :: patches
    logical :: none(0, 1)

    allocate (model, step)
    call make_step('FRICTION ANGLE=0', '|0, -0.01', model, step)
    call present_body_points(model, placed_bodies(model), points)
    points%touched = points%patch == 1 .and. points%cell > 0
    call find_patches(model, none, none, points, patches)
    call tests%check('a patch of many places', patches%count == 1 .and. size(patches%point) > 4)
    points%touched = points%touched .or. (points%cell > 0 .and. points%patch == 2 .and. &
      norm2(points%position - spread(points%position(:, count(points%patch == 1) + 1), 2, points%count), dim=1) < 0.03_wp)
    call find_patches(model, none, none, points, patches)
    call tests%check('with a few of the next', patches%count == 1 .and. size(patches%point) > count(points%patch == 1 .and. &
      points%cell > 0))
    model%contact_pairs%pointwise = .true.
    call find_patches(model, none, none, points, patches)
    call tests%check('every place is a patch where that is asked for', patches%count == count(points%touched))
    call end_system(step%system)
  end subroutine check_short

  !> Pressures on a body at a place: the first place has its own, places that nothing touches do not count; the first
  !> material point touches as the others do; nothing pressed has no place.
  subroutine check_places(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(body_points_type) :: points
    real(wp) :: numbers(3)
    integer :: body(1), i, base

    allocate (model, step)
    call make_step('FRICTION ANGLE=0', '|0, -0.01', model, step)
    call present_body_points(model, placed_bodies(model), points)
    numbers = 7.0_wp
    body = 7
    call widest_gap(model, placed_bodies(model), body(1), numbers(:2), numbers(3))
    call tests%check('no gap where nothing presses', body(1) == 0 .and. all(abs(numbers) <= 0.0_wp))
    base = minloc(hypot(points%initial_position(1, :) - 1.0_wp, points%initial_position(2, :) - 0.65_wp), dim=1)
    points%pressure = merge(5.0_wp, 0.0_wp, points%touched)
    points%opening(base - 1) = 1.0_wp
    points%pressure(base - 1) = 0.0_wp
    call keep_body_points(model, points)
    call tests%close('a place that nothing touches does not count', contact_pressure_at(model, [1.0_wp, 0.65_wp]), 5.0_wp, &
      1.0e-12_wp)
    model%contact_pairs%pointwise = .true.
    points%touched = .true.
    points%opening = 0.0_wp
    points%pressure = [(1.0_wp*i, i=1, points%count)]
    call keep_body_points(model, points)
    call tests%close('the first place has its own pressure', contact_pressure_at(model, points%initial_position(:, 1)), &
      1.0_wp, 1.0e-12_wp)
    points%opening = 1.0_wp
    call keep_body_points(model, points)
    model%state%points%position(:, 2:) = model%state%points%position(:, 2:) + 10.0_wp
    model%state%points%position(:, 1) = [1.0_wp, 0.63_wp]
    model%part%points = [(i /= 1, i=1, model%state%points%count)]
    call touch_body_points(model, placed_bodies(model))
    call present_body_points(model, placed_bodies(model), points)
    call tests%check('points of another process are its own matter', .not. any(points%touched))
    deallocate (model%part%points)
    call touch_body_points(model, placed_bodies(model))
    call present_body_points(model, placed_bodies(model), points)
    call tests%check('the first point touches', any(points%touched))
    call end_system(step%system)
  end subroutine check_places
end module test_body_contact
