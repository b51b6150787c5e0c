!> Rigid bodies and contact: distances with their derivatives, tractions with theirs, patches, the whole matrix against
!> differences with sticking and slipping friction, what is kept of an accepted step and not of a lost one, soil inside
!> of a body.
module test_contacts
  use, intrinsic :: ieee_exceptions, only: ieee_get_halting_mode, ieee_invalid
  use qsmpm_analysis, only: analysis_type, plane_strain, axisymmetric, three_dimensional
  use qsmpm_phase_description, only: initial_stress_type, initial_given
  use qsmpm_body_points, only: body_points_type
  use qsmpm_contact_law, only: tractions_type, contact_tractions
  use qsmpm_contact_patches, only: contact_patches_type, find_patches
  use qsmpm_contact_results, only: contact_pressure_at, contact_slip_on, penetration_type, widest_gap
  use qsmpm_contacts, only: contacts_type, bodies_at_end
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_diagnostics, only: diagnostics_type
  use qsmpm_drucker_prager, only: drucker_prager_parameters_type
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_error, only: error_type
  use qsmpm_initial_contact, only: press_on_bodies
  use qsmpm_initialisation, only: step_type, initialise_step, begin_analysis, evaluate_step
  use qsmpm_kept_arrays, only: keep_values
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: tangent_none, step_info_type
  use qsmpm_linear_system, only: end_system
  use qsmpm_load_step, only: load_step_type
  use qsmpm_model, only: model_type, contact_pair_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_penetration, only: penetration_check_type, refuse_penetration, warn_of_penetration
  use qsmpm_phase_start, only: start_phase
  use qsmpm_rigid_bodies, only: make_shape, force_on_body, keep_rigid_body, pose_of, placed_bodies, &
    interface_strength, check_interfaces
  use qsmpm_rigid_outline, only: outline_corners
  use qsmpm_rigid_pose, only: rigid_pose_type, placed_shape_type, carry_along
  use qsmpm_rigid_shape, only: rigid_shape_type, distance_type, face_type, ball, half_space, rounded_polygon, &
    box_polygon, cone_polygon, turned_polygon, rounded_block, kind_turned, completed_by_image, largest_round, &
    rotation_matrix, followed_by
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_strength_profile, only: profile_linear, profile_shansep
  use qsmpm_value_field, only: field_friction, set_samples
  use qsmpm_structures, only: rigid_body_type, rigid_plane, rigid_circle, rigid_box, rigid_cone, rigid_cylinder, rigid_polygon
  use qsmpm_term, only: increment_type
  use qsmpm_term_sums, only: begin_terms, commit_terms, set_loads
  use qsmpm_text, only: real_text
  use qsmpm_unknowns, only: all_nodes
  use deck_samples, only: joined
  use scripted_solver, only: test_observer_type
  use term_samples, only: contacts_of, force_named, matrix_and_difference
  use testing, only: tests_type
  implicit none
  private

  public :: collect_contacts

  real(wp), parameter :: difference = 1.0e-6_wp
  !> A block, the top of which a box may touch that is wider than it and cuts no grid line.
  character(len=*), parameter :: block = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 8|Y, 0, 2, 8|'// &
    '*NSET, NSET=base, PLANE=Y|0|*SURFACE, NAME=top, TYPE=SEGMENT|2, 1.1, 0, 1.1|*MATERIAL, NAME=soil|*ELASTIC|'// &
    '1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|0, 2, 0, 1.1|*METHOD, BASIS=SPLINE2, INTEGRATION=POINTS|'
  character(len=*), parameter :: press = '*PHASE, NAME=press, TIME=1|*FIX|base, ALL|*MOVE, BODY=tool'
  !> Soil from which water flows.
  character(len=*), parameter :: wet = '*MODEL, TYPE=PLANE STRAIN|*GRID|X, 0, 2, 4|Y, 0, 2, 4|*NSET, NSET=base, '// &
    'PLANE=Y|0|*SURFACE, NAME=top, TYPE=SEGMENT|2, 1, 0, 1|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*PERMEABILITY|1E-3|'// &
    '*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|0, 2, 0, 1|'

contains

  !> All tests of the suite.
  subroutine collect_contacts(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('contacts')
    call check_distances(tests)
    call check_polygons(tests)
    call check_faces(tests)
    call check_outlines(tests)
    call check_rotations(tests)
    call check_blocks(tests)
    call check_shapes(tests)
    call check_pose(tests)
    call check_tractions(tests)
    call check_patches(tests)
    call check_kinds(tests)
    call check_left(tests)
    call check_far_away(tests)
    call check_two_bodies(tests)
    call check_wide_cell(tests)
    call check_sliver(tests)
    call check_numbers(tests)
    call check_far_end(tests)
    call check_tangent(tests, 'FRICTION ANGLE=40', 0.0_wp)
    call check_tangent(tests, 'FRICTION ANGLE=10', 0.03_wp)
    call check_tangent(tests, 'FRICTION ANGLE=10, ADHESION=5', 0.03_wp)
    ! 100 E/h 0.03 tan(0.3 degrees) is half of E/h 0.03: it slips.
    call check_tangent(tests, 'FRICTION ANGLE=0.3', 0.03_wp)
    call check_tangent(tests, 'FRICTION ANGLE=0.2, ADHESION=5', 0.03_wp)
    call check_tangent(tests, 'TENSION=YES', 0.0_wp)
    call check_tangent(tests, 'FRICTION ANGLE=10, PENALTY=0.01', 0.03_wp, wet)
    call check_tangent(tests, 'FRICTION ANGLE=10, PENALTY=0.01, ADHESION=5', 0.03_wp, wet)
    call check_step(tests)
    call check_parting(tests)
    call check_bonds(tests)
    call check_along(tests)
    call check_slip(tests)
    call check_pressure(tests)
    call check_round_pressure(tests)
    call check_space(tests)
    call check_space_tangent(tests, 'FRICTION ANGLE=10')
    call check_space_tangent(tests, 'FRICTION ANGLE=0.3')
    call check_space_tangent(tests, 'FRICTION ANGLE=60, ADHESION=3')
    call check_interface(tests)
    call check_strength(tests)
    call check_penetration(tests)
    call check_rest(tests)
    call check_wall(tests)
    call check_other_surfaces(tests)
    call check_turned_body(tests)
  end subroutine collect_contacts

  !> What is drawn of a shape is its surface, the body at the left hand.
  subroutine check_outlines(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: corner(2, 6) = reshape([0.0_wp, 0.0_wp, 2.0_wp, 0.0_wp, 2.0_wp, 2.0_wp, 1.0_wp, 2.0_wp, &
      1.0_wp, 1.0_wp, 0.0_wp, 1.0_wp], [2, 6])

    call check_outline('a circle', ball([1.0_wp, 0.5_wp, 0.0_wp], 0.7_wp), acos(-1.0_wp)*0.49_wp)
    call check_outline('a round box', rounded_polygon(box_polygon([0.0_wp, 0.0_wp], [2.0_wp, 1.0_wp]), 0.2_wp), &
      2.0_wp - (4.0_wp - acos(-1.0_wp))*0.04_wp)
    call check_outline('a round corner piece', rounded_polygon(corner, 0.1_wp), 3.0_wp &
      - 5.0_wp*(1.0_wp - acos(-1.0_wp)/4.0_wp)*0.01_wp)
    call check_outline('a plane', half_space([1.0_wp, 1.0_wp, 0.0_wp], [0.6_wp, 0.8_wp, 0.0_wp]), 0.0_wp)

  contains

    subroutine check_outline(name, shape, area)
      character(len=*), intent(in) :: name
      type(rigid_shape_type), intent(in) :: shape
      real(wp), intent(in) :: area
      real(wp), allocatable :: x(:, :), after(:, :)
      type(distance_type) :: distance
      real(wp) :: most
      integer :: i

      allocate (x, source=outline_corners(shape, 3.0_wp))
      allocate (after, source=cshift(x, 1, dim=2))
      most = 0.0_wp
      do i = 1, size(x, 2)
        distance = shape%distance_of([x(:, i), 0.0_wp])
        most = max(most, abs(distance%value))
      end do
      call tests%check('outline of '//name//' is its surface', most < 1.0e-12_wp)
      call tests%close('outline of '//name//' holds its area', 0.5_wp*sum(x(1, :)*after(2, :) - x(2, :)*after(1, :)), area, &
        5.0e-3_wp)
      distance = shape%distance_of([0.5_wp*(x(:, 1) + x(:, 2)) + 0.01_wp*[x(2, 1) - x(2, 2), x(1, 2) - x(1, 1)], 0.0_wp])
      call tests%check('the body is at the left hand of the outline of '//name, distance%value < 0.0_wp)
    end subroutine check_outline
  end subroutine check_outlines

  !> Normal and curvature are the derivatives of the distance.
  subroutine check_distances(tests)
    type(tests_type), intent(inout) :: tests
    type(placed_shape_type) :: placed
    real(wp), parameter :: square(2, 4) = reshape([0.0_wp, 0.0_wp, 2.0_wp, 0.0_wp, 2.0_wp, 1.0_wp, 0.0_wp, 1.0_wp], &
      [2, 4])

    placed%pose = rigid_pose_type([0.3_wp, -0.2_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.4_wp])
    placed%reference = [1.0_wp, 0.5_wp, 0.0_wp]
    placed%shape = ball([1.0_wp, 0.5_wp, 0.0_wp], 0.7_wp)
    call check_derivatives('of a circle', [2.2_wp, 1.9_wp, 0.0_wp], 0.0_wp)
    call check_derivatives('inside of a circle', [1.2_wp, 0.5_wp, 0.0_wp], 0.0_wp)
    placed%shape = half_space([1.0_wp, 0.0_wp, 0.0_wp], [1.0_wp, 2.0_wp, 0.0_wp])
    call check_derivatives('of a plane', [2.2_wp, 1.9_wp, 0.0_wp], 0.0_wp)
    placed%shape = rounded_polygon(square, 0.1_wp)
    call check_derivatives('of a box beside an edge', [1.5_wp, -0.9_wp, 0.0_wp], 0.0_wp)
    call check_derivatives('of a box beside a corner', [3.2_wp, 1.9_wp, 0.0_wp], 0.0_wp)
    call check_derivatives('of a box under its skin', [1.3_wp, -0.1_wp, 0.0_wp], 0.0_wp)
    placed%pose%rotation(3) = 0.0_wp
    call check_derivatives('of a box at rest', [4.3_wp, 0.3_wp, 0.0_wp], 2.0_wp)
    placed%shape = turned_polygon([1.0_wp, 9.0_wp, -0.5_wp], box_polygon([-0.6_wp, 0.0_wp], [0.6_wp, 1.0_wp]), 0.1_wp)
    ! Moved by (0.3, -0.2): the line is at x = 1.3, z = -0.5.
    call check_derivatives('of a cylinder beside its shell', [2.1_wp, 0.3_wp, 0.1_wp], 0.4_wp)
    call check_derivatives('of a cylinder below its edge', [1.9_wp, -0.5_wp, -1.0_wp], 0.0_wp)
    call check_derivatives('of a cylinder under its base', [1.4_wp, -0.5_wp, -0.3_wp], 0.3_wp)
    placed%shape = turned_polygon([1.0_wp, 0.0_wp, -0.5_wp], cone_polygon([0.0_wp, 0.0_wp], 1.0_wp, 0.5_wp, 1.0_wp), 0.1_wp)
    call check_derivatives('of a cone on its line, below the tip', [1.3_wp, -0.6_wp, -0.5_wp], 0.0_wp)
    call check_derivatives('of a cone beside its flank', [1.9_wp, 0.2_wp, 0.2_wp], 0.0_wp)
  contains
    !> Differences of the distance and of the normal.
    subroutine check_derivatives(which, x, value)
      character(len=*), intent(in) :: which
      real(wp), intent(in) :: x(3), value
      type(distance_type) :: here, ahead, back
      real(wp) :: move(3)
      integer :: d, j

      here = placed%distance_at(x)
      d = merge(3, 2, placed%shape%kind == kind_turned)
      do j = 1, d
        move = 0.0_wp
        move(j) = difference
        ahead = placed%distance_at(x + move)
        back = placed%distance_at(x - move)
        call tests%close('normal '//which, here%normal(j), (ahead%value - back%value)/(2.0_wp*difference), 1.0e-8_wp)
        call tests%close('curvature '//which, norm2(here%curvature(:d, j) &
          - (ahead%normal(:d) - back%normal(:d))/(2.0_wp*difference)), 0.0_wp, 1.0e-8_wp)
      end do
      if (value > 0.0_wp) call tests%close('distance '//which, here%value, value, 1.0e-12_wp)
    end subroutine check_derivatives
  end subroutine check_distances

  !> Polygons of the shapes.
  subroutine check_polygons(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), allocatable :: whole(:, :)

    call tests%close('the largest round of a box is half its shorter side', &
      largest_round(box_polygon([0.0_wp, 0.0_wp], [3.0_wp, 1.0_wp])), 0.5_wp, 1.0e-14_wp)
    associate (cone => cone_polygon([0.0_wp, 1.0_wp], 0.5_wp, atan(0.5_wp), 2.0_wp))
      call tests%close('a cone of slope 2 has its shoulder at its diameter above the tip', cone(2, 2), 2.0_wp, &
        1.0e-14_wp)
      call tests%close('and its shaft above', cone(2, 3), 4.0_wp, 1.0e-14_wp)
    end associate
    allocate (whole, source=completed_by_image(reshape([0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 2.0_wp], [2, 3]), &
      1.0e-9_wp))
    call tests%check('a polygon with an edge on the axis gets its image', size(whole, 2) == 4 .and. &
      any(abs(whole(1, :) + 1.0_wp) < 1.0e-14_wp))
    call tests%check('one across the axis stays', size(completed_by_image(box_polygon([-1.0_wp, 0.0_wp], [1.0_wp, &
      1.0_wp]), 1.0e-9_wp), 2) == 4)
    call tests%check('one beside the axis stays', size(completed_by_image(reshape([1.0_wp, 0.0_wp, 2.0_wp, 1.0_wp, &
      1.0_wp, 2.0_wp], [2, 3]), 1.0e-9_wp), 2) == 3)
  end subroutine check_polygons

  !> Pieces of a surface along the faces of a box, drawn and turned: distance, normal and the share that counts.
  subroutine check_faces(tests)
    type(tests_type), intent(inout) :: tests
    type(placed_shape_type) :: placed
    type(face_type) :: face
    real(wp), parameter :: up(2) = [0.0_wp, 1.0_wp], left(2) = [-1.0_wp, 0.0_wp], length = 0.08_wp
    integer :: turn

    placed%shape = rounded_polygon(box_polygon([0.0_wp, 0.0_wp], [2.0_wp, 1.0_wp]), 0.2_wp)
    placed%reference = [1.0_wp, 0.5_wp, 0.0_wp]
    do turn = 0, 1
      placed%pose = rigid_pose_type(turn*[0.3_wp, -0.7_wp, 0.0_wp], turn*[0.0_wp, 0.0_wp, 0.4_wp])
      face = face_at([1.0_wp, -0.05_wp], up)
      call tests%check('a piece below the base lies along it', face%found)
      call tests%close('with all of it', face%share, 1.0_wp, 1.0e-14_wp)
      call tests%close('its distance', face%distance%value, 0.05_wp, 1.0e-14_wp)
      call tests%close('the normal of the base, turned with the body', norm2(face%distance%normal(:2) &
        - [sin(0.4_wp*turn), -cos(0.4_wp*turn)]), 0.0_wp, 1.0e-14_wp)
      ! The base is flat to 1.8; a quarter of the corner's radius counts too, and 0.75 of the piece is looked at.
      face = face_at([1.85_wp, -0.05_wp], up)
      call tests%close('a piece across the end of the base counts half', face%share, 0.5_wp, 1.0e-12_wp)
      face = face_at([1.87_wp, -0.05_wp], up)
      call tests%close('and by what of it is along the base', face%share, 1.0_wp/6.0_wp, 1.0e-12_wp)
      face = face_at([1.95_wp, -0.05_wp], up)
      call tests%check('beside the round corner it is found and carries nothing', face%found .and. face%share <= 0.0_wp)
      face = face_at([2.1_wp, -0.05_wp], up)
      call tests%check('beyond the corner there is no face', .not. face%found)
      face = face_at([1.0_wp, -0.15_wp], up)
      call tests%check('nor farther away than what touches', .not. face%found)
      face = face_at([1.0_wp, 0.15_wp], up)
      call tests%close('inside of the body the distance is negative', face%distance%value, -0.15_wp, 1.0e-14_wp)
      face = face_at([1.0_wp, 0.25_wp], up)
      call tests%check('deep inside there is none', .not. face%found)
      face = face_at([1.9_wp, 0.5_wp], left)
      call tests%close('what has folded in at the side lies along the side', face%distance%value, -0.1_wp, 1.0e-14_wp)
      face = face_at([1.0_wp, -0.05_wp], left)
      call tests%check('a piece that stands upright below the base lies along no face', .not. face%found)
    end do
    placed%shape = ball([1.0_wp, 0.5_wp, 0.0_wp], 0.7_wp)
    face = face_at([1.0_wp, -0.05_wp], up)
    call tests%check('a circle has no faces', .not. face%found)
  contains
    !> Face at a place and for a normal of the piece as the body is drawn.
    type(face_type) function face_at(x, outward) result(face)
      real(wp), intent(in) :: x(2), outward(2)
      type(rigid_pose_type) :: drawn
      real(wp) :: place(3), ahead(3)

      place = carry_along(placed%reference, drawn, placed%pose, [x, 0.0_wp])
      ahead = carry_along(placed%reference, drawn, placed%pose, [x + outward, 0.0_wp])
      face = placed%face_at(place, ahead - place, length, 0.1_wp, 0.2_wp)
    end function face_at
  end subroutine check_faces

  !> Blocks in space, turned: outside of a face, an edge, a corner, and inside.
  subroutine check_blocks(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: low(3) = [-1.0_wp, 0.0_wp, 2.0_wp], high(3) = [1.0_wp, 1.0_wp, 6.0_wp], round = 0.2_wp
    real(wp), parameter :: turn(3) = [0.3_wp, -0.5_wp, 0.9_wp], middle(3) = 0.5_wp*(low + high)
    type(placed_shape_type) :: placed

    placed%reference = middle
    placed%shape = rounded_block(low, high, turn, round)
    ! Beyond the skin of the box that has no round edges by the legs of right triangles.
    call check_place('of a face', [1.5_wp, 0.1_wp, -0.3_wp], 0.5_wp)
    call check_place('of an edge', [1.1_wp, 0.6_wp, 0.4_wp], sqrt(0.3_wp**2 + 0.3_wp**2) - round)
    call check_place('of a corner', [-1.2_wp, 0.7_wp, -2.3_wp], sqrt(0.4_wp**2 + 0.4_wp**2 + 0.5_wp**2) - round)
    call check_place('inside', [0.1_wp, -0.4_wp, 0.2_wp], -0.1_wp)
    placed%pose = rigid_pose_type([0.2_wp, 0.1_wp, -0.4_wp], [0.7_wp, 0.2_wp, -0.1_wp])
    call check_place('of an edge, moved', [1.1_wp, 0.6_wp, 0.4_wp], sqrt(0.3_wp**2 + 0.3_wp**2) - round)
  contains
    !> Distance at a place along the axes of the block from its middle, with its differences.
    subroutine check_place(which, along, value)
      character(len=*), intent(in) :: which
      real(wp), intent(in) :: along(3), value
      type(distance_type) :: here, ahead, back
      real(wp) :: x(3), move(3)
      integer :: j

      x = carry_along(middle, rigid_pose_type(), placed%pose, middle + matmul(rotation_matrix(turn), along))
      here = placed%distance_at(x)
      call tests%close('distance of a block '//which, here%value, value, 1.0e-14_wp)
      do j = 1, 3
        move = 0.0_wp
        move(j) = difference
        ahead = placed%distance_at(x + move)
        back = placed%distance_at(x - move)
        call tests%close('normal of a block '//which, here%normal(j), (ahead%value - back%value)/(2.0_wp*difference), &
          1.0e-9_wp)
        call tests%close('curvature of a block '//which, norm2(here%curvature(:, j) - (ahead%normal - back%normal) &
          /(2.0_wp*difference)), 0.0_wp, 1.0e-8_wp)
      end do
    end subroutine check_place
  end subroutine check_blocks

  !> Rotations one behind the other are their matrices multiplied; about one axis their angles add.
  subroutine check_rotations(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: first(3) = [0.4_wp, -1.1_wp, 0.3_wp], then(3) = [1.2_wp, 0.5_wp, 2.0_wp], up(3) = &
      [0.0_wp, 0.0_wp, 4.0_wp]
    real(wp) :: r(3, 3)

    r = rotation_matrix([0.0_wp, 0.0_wp, 0.5_wp*acos(-1.0_wp)])
    call tests%close('a right angle about z turns x to y', norm2(r(:, 1) - [0.0_wp, 1.0_wp, 0.0_wp]), 0.0_wp, 1.0e-15_wp)
    r = rotation_matrix(followed_by(first, then)) - matmul(rotation_matrix(then), rotation_matrix(first))
    call tests%close('the second behind the first', maxval(abs(r)), 0.0_wp, 1.0e-14_wp)
    call tests%close('more than once around', norm2(followed_by(up, up) - 2.0_wp*up), 0.0_wp, 1.0e-15_wp)
    r = rotation_matrix(followed_by(first, -first)) - rotation_matrix([0.0_wp, 0.0_wp, 0.0_wp])
    call tests%close('back again', maxval(abs(r)), 0.0_wp, 1.0e-15_wp)
  end subroutine check_rotations

  !> What a card says of a body in the plane, around an axis and in space: its reference point, how far places are from
  !> it, how round its corners are and may be.
  subroutine check_shapes(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: cell = 0.2_wp, usual = 0.05_wp
    integer, parameter :: all_kinds(3) = [plane_strain, axisymmetric, three_dimensional]
    type(rigid_body_type) :: body
    type(placed_shape_type) :: placed
    type(diagnostics_type) :: diagnostics
    integer :: k

    body%name = 'tool'
    do k = 1, 3
      body%place = [0.0_wp, 3.0_wp, merge(4.0_wp, 0.0_wp, k == 3)]
      body%shape = rigid_plane
      body%direction = [0.0_wp, -2.0_wp, 0.0_wp]
      call expect('a plane', body%place, [7.0_wp, 1.0_wp, 0.0_wp], 2.0_wp)
      body%shape = rigid_circle
      body%radius = 0.5_wp
      call expect('a circle', body%place, body%place + [0.0_wp, -1.5_wp, 0.0_wp], 1.0_wp)
      body%shape = rigid_cone
      body%apex_angle = 2.0_wp*atan(0.5_wp)*180.0_wp/acos(-1.0_wp)
      body%shaft = 2.0_wp
      ! Of slope 2: the shoulder stands 1 above the tip, and the top 2 above it.
      call expect('beside the shaft of a cone', body%place, body%place + [1.25_wp, 2.0_wp, 0.0_wp], 0.75_wp)
      call expect('beside its flank', body%place, body%place + [0.25_wp, 0.5_wp, 0.0_wp] + [2.0_wp, -1.0_wp, 0.0_wp]/sqrt(5.0_wp), &
        1.0_wp)
      call expect('above it', body%place, body%place + [0.0_wp, 3.5_wp, 0.0_wp], 0.5_wp)
      call expect('at the other side', body%place, body%place + [-1.25_wp, 2.0_wp, 0.0_wp], 0.75_wp)
    end do
    k = 3
    call expect('in space the shaft is round', body%place, body%place + [0.6_wp, 2.0_wp, 0.8_wp], 0.5_wp)
    body%place(:2) = [1.0_wp, 3.0_wp]
    call expect('where it is drawn', body%place, body%place + [0.6_wp, 2.0_wp, 0.8_wp], 0.5_wp)
    body%shape = rigid_cylinder
    body%shaft = 0.75_wp
    call expect('beside a cylinder', body%place, body%place + [0.6_wp, 0.3_wp, -0.8_wp], 0.5_wp)
    call expect('below its base', body%place, body%place + [0.1_wp, -0.3_wp, 0.1_wp], 0.3_wp)
    call expect('above it', body%place, body%place + [0.1_wp, 1.0_wp, 0.1_wp], 0.25_wp)
    k = 2
    body%place = [0.0_wp, 3.0_wp, 0.0_wp]
    call expect('beside a cylinder on the axis', body%place, [1.0_wp, 3.3_wp, 0.0_wp], 0.5_wp)
    call expect('above it', body%place, [0.1_wp, 4.0_wp, 0.0_wp], 0.25_wp)
    body%shape = rigid_polygon
    body%polygon = reshape([0.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 4.0_wp, 0.0_wp, 4.0_wp], [2, 4])
    call expect('a polygon with an edge on the axis has its image', [0.0_wp, 2.5_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp], 1.0_wp)
    ! A millionth of a cell is 2e-7.
    body%polygon(1, [1, 4]) = 1.0e-7_wp
    call expect('or nearly on it', [0.0_wp, 2.5_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp], 1.0_wp)
    body%polygon(1, [1, 4]) = 1.0e-6_wp
    call expect('one beside the axis has not', [0.5_wp*(1.0_wp + 1.0e-6_wp), 2.5_wp, 0.0_wp], [0.5_wp, 0.0_wp, 0.0_wp], 1.0_wp)
    body%polygon(1, [1, 4]) = 0.0_wp
    k = 1
    call expect('in the plane it has not', [0.5_wp, 2.5_wp, 0.0_wp], [-0.5_wp, 2.0_wp, 0.0_wp], 0.5_wp)
    k = 3
    call expect('in space it runs along z', [0.5_wp, 2.5_wp, 0.0_wp], [-0.5_wp, 2.0_wp, 9.0_wp], 0.5_wp)
    body%shape = rigid_box
    body%box = reshape([1.0_wp, 2.0_wp, 3.0_wp, 2.0_wp, 4.0_wp, 6.0_wp], [3, 2])
    call expect('a box in space', [1.5_wp, 3.0_wp, 4.5_wp], [1.5_wp, 3.2_wp, 7.0_wp], 1.0_wp)
    body%rotation = [90.0_wp, 0.0_wp, 0.0_wp]
    call expect('turned from y to z', [1.5_wp, 3.0_wp, 4.5_wp], [1.5_wp, 3.2_wp, 6.0_wp], 0.5_wp)
    call check_round('in space', 0.5_wp)
    k = 1
    call expect('a box in the plane', [1.5_wp, 3.0_wp, 0.0_wp], [1.6_wp, 4.5_wp, 0.0_wp], 0.5_wp)
    call check_round('in the plane', 0.5_wp)
  contains
    !> Reference point and distance of a place, with the corners of the usual roundness.
    subroutine expect(what, reference, x, distance)
      character(len=*), intent(in) :: what
      real(wp), intent(in) :: reference(3), x(3), distance
      type(distance_type) :: found

      call make_shape(body, all_kinds(k), cell, placed%shape, placed%reference, diagnostics)
      found = placed%distance_at(x)
      call tests%close('distance of '//what, found%value, distance, 1.0e-13_wp)
      call tests%close('its reference point', norm2(placed%reference - reference), 0.0_wp, 1.0e-13_wp)
      call tests%check('nothing is said', diagnostics%count == 0)
    end subroutine expect

    !> Corners of a box.
    subroutine check_round(where, largest)
      character(len=*), intent(in) :: where
      !> Half of the shortest edge.
      real(wp), intent(in) :: largest
      integer :: i

      call tests%close('a quarter of a cell '//where, radius_of(-1.0_wp, cell), usual, 1.0e-15_wp)
      call tests%close('at most half of what the edges allow '//where, radius_of(-1.0_wp, 10.0_wp), 0.5_wp*largest, 1.0e-15_wp)
      call tests%close('as it is asked for '//where, radius_of(0.3_wp, cell), 0.3_wp, 1.0e-15_wp)
      call tests%close('to the end '//where, radius_of(0.98_wp*largest, cell), 0.98_wp*largest, 1.0e-15_wp)
      i = diagnostics%count
      call tests%check('nothing is said '//where, i == 0)
      call tests%check('beyond it is refused '//where, radius_of(0.9975_wp*largest, cell) <= huge(1.0_wp) .and. &
        diagnostics%count == 1)
      diagnostics%count = 0
    end subroutine check_round

    !> Roundness of what is made of it.
    real(wp) function radius_of(asked, size_of_cell)
      real(wp), intent(in) :: asked, size_of_cell

      body%round = asked
      call make_shape(body, all_kinds(k), size_of_cell, placed%shape, placed%reference, diagnostics)
      radius_of = placed%shape%radius
      body%round = -1.0_wp
    end function radius_of
  end subroutine check_shapes

  !> A place that rides on a body keeps its distance.
  subroutine check_pose(tests)
    type(tests_type), intent(inout) :: tests
    type(placed_shape_type) :: from, to
    type(distance_type) :: before, behind
    real(wp), parameter :: x(3) = [0.4_wp, 2.0_wp, 0.0_wp]

    from%shape = rounded_polygon(box_polygon([-1.0_wp, 0.0_wp], [1.0_wp, 1.0_wp]), 0.1_wp)
    from%reference = [0.0_wp, 0.5_wp, 0.0_wp]
    from%pose = rigid_pose_type([0.1_wp, 0.2_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.3_wp])
    to = from
    to%pose = rigid_pose_type([-0.5_wp, 0.7_wp, 0.0_wp], [0.0_wp, 0.0_wp, 1.1_wp])
    before = from%distance_at(x)
    behind = to%distance_at(carry_along(from%reference, from%pose, to%pose, x))
    call tests%close('what rides on a body keeps its distance', behind%value, before%value, 1.0e-14_wp)
  end subroutine check_pose

  !> Tractions by their formulas, and their derivatives.
  subroutine check_tractions(tests)
    type(tests_type), intent(inout) :: tests
    type(contact_pair_type) :: pair
    type(tractions_type) :: now, more
    real(wp), parameter :: shear(3) = [3.0_wp, 1.0_wp, 0.0_wp], slip(3) = [0.02_wp, -0.01_wp, 0.0_wp]

    pair = contact_pair_type(1, 1, 0.5_wp, 2.0_wp, .false.)
    now = contact_tractions(pair, [100.0_wp, 10.0_wp], 20.0_wp, shear, 0.3_wp, slip, 0.0_wp, 0.0_wp)
    call tests%check('a gap beyond lambda/eps opens the contact', .not. now%closed .and. .not. now%pressure > 0.0_wp &
      .and. norm2(now%shear) <= 0.0_wp)
    now = contact_tractions(pair, [100.0_wp, 10.0_wp], 20.0_wp, shear, 0.1_wp, slip, 0.0_wp, 0.0_wp)
    call tests%close('p = lambda - eps g', now%pressure, 10.0_wp, 1.0e-12_wp)
    call tests%close('a shear below the limit sticks', norm2(now%shear - [2.8_wp, 1.1_wp, 0.0_wp]), 0.0_wp, &
      1.0e-12_wp)
    now = contact_tractions(pair, [1.0e4_wp, 1.0e3_wp], 20.0_wp, shear, 1.0e-3_wp, slip, 0.0_wp, 0.0_wp)
    call tests%close('one above it slips at mu p + a', norm2(now%shear), 7.0_wp, 1.0e-12_wp)
    more = contact_tractions(pair, [1.0e4_wp, 1.0e3_wp], 20.0_wp, shear, 1.0e-3_wp + difference, slip, 0.0_wp, 0.0_wp)
    call tests%close('dp/dg', now%by_gap, (more%pressure - now%pressure)/difference, 1.0e-4_wp)
    call tests%close('dt/dp', norm2(now%by_gap*now%by_pressure - (more%shear - now%shear)/difference), 0.0_wp, &
      1.0e-3_wp)
    more = contact_tractions(pair, [1.0e4_wp, 1.0e3_wp], 20.0_wp, shear, 1.0e-3_wp, slip + [difference, 0.0_wp, 0.0_wp], &
      0.0_wp, 0.0_wp)
    call tests%close('dt/ds', norm2(now%by_slip(:, 1) - (more%shear - now%shear)/difference), 0.0_wp, 1.0e-1_wp)
    call check_slopes('slipping in space', contact_pair_type(1, 1, 0.5_wp, 2.0_wp, .false.), [1.0e4_wp, 1.0e3_wp], 1.0e-3_wp)
    call check_slopes('sticking', contact_pair_type(1, 1, 0.5_wp, 2.0_wp, .false.), [100.0_wp, 10.0_wp], 0.1_wp)
    call check_slopes('pulled, with its adhesion', contact_pair_type(1, 1, 0.5_wp, 2.0_wp, .true.), [1.0e4_wp, 1.0e3_wp], 4.0e-3_wp)
    call check_slopes('open', contact_pair_type(1, 1, 0.5_wp, 2.0_wp, .false.), [1.0e4_wp, 1.0e3_wp], 4.0e-3_wp)
    now = contact_tractions(pair, [1.0e4_wp, 1.0e3_wp], 20.0_wp, shear, 1.999e-3_wp, slip, 0.0_wp, 0.0_wp)
    call tests%close('half of the adhesion at a pressure of half a hundredth of it', norm2(now%shear), 1.0_wp + 0.005_wp, &
      1.0e-9_wp)
    call check_slopes('about to part', contact_pair_type(1, 1, 0.5_wp, 2.0_wp, .false.), [1.0e4_wp, 1.0e3_wp], 1.999e-3_wp)
    call check_slopes('above water', contact_pair_type(1, 1, 0.5_wp, 2.0_wp, .false.), [1.0e4_wp, 1.0e3_wp], 1.0e-3_wp, 6.0_wp)
    call check_slopes('on water', contact_pair_type(1, 1, 0.5_wp, 2.0_wp, .false.), [1.0e4_wp, 1.0e3_wp], 1.0e-3_wp, 14.0_wp)
    call check_slopes('in suction', contact_pair_type(1, 1, 0.5_wp, 2.0_wp, .false.), [1.0e4_wp, 1.0e3_wp], 1.0e-3_wp, -6.0_wp)
    call check_slopes('in suction, about to part', contact_pair_type(1, 1, 0.5_wp, 2.0_wp, .false.), [1.0e4_wp, 1.0e3_wp], &
      1.998e-3_wp, -6.0_wp)
    now = contact_tractions(pair, [1.0e4_wp, 1.0e3_wp], 20.0_wp, shear, 1.0e-3_wp, slip, 0.0_wp, 6.0_wp)
    call tests%close('friction on the pressure less that of the water', norm2(now%shear), 4.0_wp, 1.0e-12_wp)
    now = contact_tractions(pair, [1.0e4_wp, 1.0e3_wp], 20.0_wp, shear, 1.0e-3_wp, slip, 0.0_wp, 14.0_wp)
    call tests%close('none where the water carries all', norm2(now%shear), 2.0_wp, 1.0e-12_wp)
    now = contact_tractions(pair, [1.0e4_wp, 1.0e3_wp], 20.0_wp, shear, 1.0e-3_wp, slip, 0.0_wp, -6.0_wp)
    call tests%close('and more by suction', norm2(now%shear), 10.0_wp, 1.0e-12_wp)
    pair%tension = .true.
    now = contact_tractions(pair, [100.0_wp, 10.0_wp], 20.0_wp, shear, 0.3_wp, slip, 0.0_wp, 0.0_wp)
    call tests%close('a contact with tension pulls', now%pressure, -10.0_wp, 1.0e-12_wp)
    call tests%close('and has its adhesion then', norm2(now%shear), 2.0_wp, 1.0e-12_wp)
    pair = contact_pair_type(1, 1, 0.0_wp, 0.0_wp, .false.)
    now = contact_tractions(pair, [100.0_wp, 10.0_wp], 20.0_wp, 0.0_wp*shear, 0.1_wp, 0.0_wp*slip, 0.0_wp, 0.0_wp)
    call tests%check('a smooth contact has no stiffness along it', all(abs(now%by_slip) <= 0.0_wp))
    now = contact_tractions(pair, [100.0_wp, 10.0_wp], 0.0_wp, 0.0_wp*shear, 5.0e-4_wp, 0.0_wp*slip, 1.0e-3_wp, 0.0_wp)
    call tests%check('a gap of rounding is closed', now%closed)
    now = contact_tractions(pair, [100.0_wp, 10.0_wp], 0.0_wp, 0.0_wp*shear, 1.1e-3_wp, 0.0_wp*slip, 1.0e-3_wp, 0.0_wp)
    call tests%check('a little more is not', .not. now%closed)
  contains
    !> All derivatives by central differences, at a multiplier of 20 and a slip in space.
    subroutine check_slopes(what, law, penalty, gap, water)
      character(len=*), intent(in) :: what
      type(contact_pair_type), intent(in) :: law
      real(wp), intent(in) :: penalty(2), gap
      real(wp), intent(in), optional :: water
      real(wp), parameter :: before(3) = [3.0_wp, 1.0_wp, -2.0_wp], slid(3) = [0.02_wp, -0.01_wp, 0.03_wp]
      type(tractions_type) :: here, ahead, back
      real(wp) :: by(3), most, move(3), w
      integer :: j

      w = 0.0_wp
      if (present(water)) w = water
      here = contact_tractions(law, penalty, 20.0_wp, before, gap, slid, 0.0_wp, w)
      ahead = contact_tractions(law, penalty, 20.0_wp, before, gap + difference, slid, 0.0_wp, w)
      back = contact_tractions(law, penalty, 20.0_wp, before, gap - difference, slid, 0.0_wp, w)
      call tests%close('dp/dg '//what, here%by_gap, (ahead%pressure - back%pressure)/(2.0_wp*difference), 1.0e-3_wp)
      by = (ahead%shear - back%shear)/(2.0_wp*difference)
      call tests%close('dt/dp '//what, norm2(here%by_gap*here%by_pressure - by), 0.0_wp, 1.0e-3_wp)
      ahead = contact_tractions(law, penalty, 20.0_wp, before, gap, slid, 0.0_wp, w + difference)
      back = contact_tractions(law, penalty, 20.0_wp, before, gap, slid, 0.0_wp, w - difference)
      if (present(water)) call tests%close('dt/dw '//what, norm2(here%by_water - (ahead%shear - back%shear) &
        /(2.0_wp*difference)), 0.0_wp, 1.0e-6_wp)
      most = 0.0_wp
      do j = 1, 3
        move = 0.0_wp
        move(j) = difference
        ahead = contact_tractions(law, penalty, 20.0_wp, before, gap, slid + move, 0.0_wp, w)
        back = contact_tractions(law, penalty, 20.0_wp, before, gap, slid - move, 0.0_wp, w)
        most = max(most, norm2(here%by_slip(:, j) - (ahead%shear - back%shear)/(2.0_wp*difference)))
      end do
      call tests%close('dt/ds '//what, most, 0.0_wp, 1.0e-4_wp)
    end subroutine check_slopes
  end subroutine check_tractions

  !> A model with a tool above the block, and its first step.
  subroutine make_step(tool, contact, move, model, step, ground)
    !> Rest of the card, and its data line; rest of *CONTACT; data line of *MOVE.
    character(len=*), intent(in) :: tool, contact, move
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    !> Cards of the model; the block when not given.
    character(len=*), intent(in), optional :: ground
    character(len=:), allocatable :: cards
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    cards = block
    if (present(ground)) cards = ground
    call parse_deck('block.inp', joined(cards//'*RIGID BODY, NAME=tool, '//tool//'|*CONTACT, BODY=tool, '// &
      'SURFACE=top, '//contact//'|'//press//move//'|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'a deck of the contacts suite is broken'
    call begin_analysis(model, step%terms)
    call start_phase(model)
    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'a step of the contacts suite cannot be made'
    call begin_terms(step%terms, increment_type(step_info_type(duration=0.5_wp, phase_time=1.0_wp)))
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
  end subroutine make_step

  !> One patch a cell, no patch short, none far away.
  subroutine check_patches(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(contact_patches_type) :: patches
    type(body_points_type) :: nobody
    integer, allocatable :: points(:)
    integer :: c, i

    allocate (model, step)
    call make_step('SHAPE=CIRCLE|1, 2.1, 1', 'FRICTION ANGLE=0', '|0, -0.02', model, step)
    call find_patches(model, all_points(model, .true.), all_points(model, .false.), nobody, patches)
    call tests%check('a patch a cell', patches%count == 8)
    call tests%check('no places on the body itself', model%body_outlines(1)%count == 0 .and. &
      .not. any([(model%state%kept%list(i)%name == 'body_points', i=1, size(model%state%kept%list))]))
    ! The first cell loses all but a sliver of its surface.
    do i = 1, model%state%surface%count
      if (model%state%surface%cell(i) == model%state%surface%cell(1)) &
        model%state%surface%area_vector(:, i) = 0.5_wp*model%state%surface%area_vector(:, i)
    end do
    points = pack([(i, i=1, model%state%surface%count)], model%state%surface%cell == model%state%surface%cell(1))
    call find_patches(model, all_points(model, .true.), all_points(model, .false.), nobody, patches)
    call tests%check('a short one joins its neighbour', patches%count == 7)
    do c = 1, patches%count
      associate (list => patches%point(patches%first(c):patches%first(c + 1) - 1))
        if (any(list == points(1))) call tests%check('as a whole', size(list) == 2*size(points) .and. &
          all([(any(list == points(i)), i=1, size(points))]))
      end associate
    end do
    call check_nearest_patch(tests, model)
    call check_two_short(tests, model)
    call find_patches(model, reshape([(i == 1, i=1, model%state%surface%count)], [model%state%surface%count, 1]), &
      all_points(model, .false.), nobody, patches)
    call tests%check('what is far away is left out', patches%count == 1)
    call end_system(step%system)
  end subroutine check_patches

  !> What of a cell touches the body and what has left it are two conditions, and each joins its own kind.
  subroutine check_kinds(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(contact_patches_type) :: patches
    type(body_points_type) :: nobody
    logical, allocatable :: touched(:, :)
    integer :: i, p

    allocate (model, step)
    call make_step('SHAPE=CIRCLE|1, 2.1, 1', 'FRICTION ANGLE=0', '|0, -0.02', model, step)
    associate (x => model%state%surface%position(1, :))
      allocate (touched(size(x), 1))
      ! Five cells and a half.
      touched(:, 1) = x < 1.375_wp
      call find_patches(model, all_points(model, .true.), touched, nobody, patches)
      call tests%check('no patch is of both kinds', .not. any([(is_mixed(i), i=1, patches%count)]))
      call tests%check('the lesser part of a cell joins its own kind, the greater stays', patches%count == 8)
      ! Less than half a cell that touches, and nothing else.
      touched(:, 1) = x > 0.5_wp .and. x < 0.625_wp
      call find_patches(model, all_points(model, .true.), touched, nobody, patches)
      call tests%check('what has none of its kind beside it stays alone', patches%count == 9)
      ! As much, and cells that touch three cells away.
      touched(:, 1) = (x > 0.5_wp .and. x < 0.625_wp) .or. x > 1.5_wp
      call find_patches(model, all_points(model, .true.), touched, nobody, patches)
      call tests%check('or has it too far away', patches%count == 9)
      ! The first point, and all of the cell beside its own.
      touched(:, 1) = abs(x - x(1)) <= 0.0_wp .or. (x > 0.25_wp .and. x < 0.5_wp)
      call find_patches(model, all_points(model, .true.), touched, nobody, patches)
      call tests%check('the first point joins too', patches%count == 8)
      ! The first point, which is no short patch by its area as the others are not, and one that is.
      model%state%surface%area_vector = 3.0_wp*model%state%surface%area_vector
      i = minloc(abs(x - x(1) - 0.25_wp), dim=1)
      model%state%surface%area_vector(:, i) = model%state%surface%area_vector(:, i)/3.0_wp
      touched(:, 1) = [(any(p == [1, i]), p=1, size(x))]
      call find_patches(model, all_points(model, .true.), touched, nobody, patches)
      call tests%check('and is joined', patches%count == 9 .and. any([(patches%first(p + 1) - patches%first(p), &
        p=1, patches%count)] == 2))
    end associate
    call end_system(step%system)
  contains
    pure logical function is_mixed(c)
      integer, intent(in) :: c

      associate (list => touched(patches%point(patches%first(c):patches%first(c + 1) - 1), 1))
        is_mixed = any(list) .and. .not. all(list)
      end associate
    end function is_mixed
  end subroutine check_kinds

  !> A point that was pressed has left the body from a tenth of a cell on, one that was not from a thousandth on.
  subroutine check_left(tests)
    type(tests_type), intent(inout) :: tests

    call tests%check('what was pressed stays with the body, what was not does not', .not. mixes('1.1125'))
    call tests%check('both touch it', mixes('1.1'))
    call tests%check('both have left it', mixes('1.13'))
  contains
    !> Whether points that were pressed, in five cells and a half, share a patch with others under a plane so high.
    logical function mixes(height)
      character(len=*), intent(in) :: height
      class(model_type), allocatable :: model
      class(step_type), allocatable :: step
      type(contacts_type) :: term
      type(error_type), allocatable :: error
      integer :: c

      allocate (model, step)
      call make_step('SHAPE=PLANE|0, '//height//', 0, -1', 'FRICTION ANGLE=0', '|0, -0.02', model, step)
      where (model%state%surface%position(1, :) < 1.375_wp) model%state%surface%contact_pressure = 5.0_wp
      call end_system(step%system)
      call initialise_step(model, step, error)
      term = contacts_of(step)
      mixes = .false.
      associate (patches => term%scratch%patches)
        do c = 1, patches%count
          associate (pressed => model%state%surface%contact_pressure(patches%point(patches%first(c): &
              patches%first(c + 1) - 1)) > 0.0_wp)
            mixes = mixes .or. (any(pressed) .and. .not. all(pressed))
          end associate
        end do
      end associate
      call end_system(step%system)
    end function mixes
  end subroutine check_left

  !> Far from the origin of the model a pressure is what it is at the origin: gaps are not rounded with the places.
  subroutine check_far_away(tests)
    type(tests_type), intent(inout) :: tests
    !> Two to the power of 20: multiples of an eighth are exact there, and places are rounded to 2.3e-10.
    character(len=*), parameter :: far = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 8|Y, 1048576, 1048578, '// &
      '8|*NSET, NSET=base, PLANE=Y|1048576|*SURFACE, NAME=top, TYPE=SEGMENT|2, 1048577.125, 0, 1048577.125|'// &
      '*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|0, 2, 1048576, 1048577.125|'// &
      '*METHOD, BASIS=GIMP, INTEGRATION=POINTS|'
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: u(:, :)
    real(wp), parameter :: up = 0.001_wp/3.0_wp

    allocate (model, step)
    call make_step('SHAPE=PLANE|0, 1048577.125, 0, -1', 'FRICTION ANGLE=0', '|0, -0.02', model, step, far)
    allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
    u(2, :) = up
    call evaluate_step(model, step, u, tangent_none)
    ! p = 100 E/h times the gap of -0.01 - up on 2 m: 3e-13 of a gap are 1e-7 of a pressure.
    call tests%close('pressure far from the origin', -sum(force_named(step, 'force of the contacts', u)), &
      8.0e5_wp*(0.01_wp + up), 1.0e-6_wp)
    call end_system(step%system)
  end subroutine check_far_away

  !> Two bodies on surfaces of their own: how far a body goes is asked of its own places alone, and each has its force.
  subroutine check_two_bodies(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: head = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 8|Y, 0, 2, 8|'// &
      '*NSET, NSET=base, PLANE=Y|0|*SURFACE, NAME=top, TYPE=SEGMENT|1, 1.1, 0, 1.1|*SURFACE, NAME=right, TYPE=SEGMENT|'// &
      '2, 1.1, 1.5, 1.1|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|'// &
      '0, 2, 0, 1.1|*METHOD, BASIS=SPLINE2, INTEGRATION=POINTS|'
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(placed_shape_type), allocatable :: bodies(:)
    type(contacts_type) :: term
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :)
    integer :: c

    allocate (model, step)
    ! Half of 78 degrees are in force: arms of 0.71 at most go 0.47, those of the other surface more than two cells.
    call make_step('SHAPE=CIRCLE|0.5, 1.6, 0.5', 'FRICTION ANGLE=0|*RIGID BODY, NAME=other, SHAPE=PLANE|0, 1.1, 0, -1|'// &
      '*CONTACT, BODY=other, SURFACE=right', ', ROTATION=78|0, 0', model, step, head)
    allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
    call evaluate_step(model, step, u, tangent_none)
    call tests%check('a body goes no farther than its own places', .not. step%failure%failed)
    term = contacts_of(step)
    associate (patches => term%scratch%patches)
      call tests%check('both have patches', any(patches%pair(:patches%count) == 1) .and. any(patches%pair == 2))
      call tests%check('points of their own surfaces', all([(all(model%state%surface%surface(patches%point( &
        patches%first(c):patches%first(c + 1) - 1)) == patches%pair(c)), c=1, patches%count)]))
    end associate
    call end_system(step%system)
    call initialise_step(model, step, error)
    allocate (bodies, source=bodies_at_end(step%terms))
    call tests%check('before loads are set the bodies are where they were', size(bodies) == 2 .and. &
      abs(bodies(1)%pose%rotation(3)) <= 0.0_wp)
    call end_system(step%system)
  end subroutine check_two_bodies

  !> The same for all surface points and the one contact.
  pure function all_points(model, value) result(values)
    class(model_type), intent(in) :: model
    logical, intent(in) :: value
    logical :: values(model%state%surface%count, 1)

    values = value
  end function all_points

  !> What is short is so beside its own cell: a piece of 0.2 in a cell of 0.75 by 0.25.
  subroutine check_wide_cell(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: graded = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, LINES, 0, 0.25, 0.5, '// &
      '0.75, 1, 1.75|Y, 0, 2, 8|*NSET, NSET=base, PLANE=Y|0|*SURFACE, NAME=top, TYPE=SEGMENT|1.2, 1.1, 0, 1.1|'// &
      '*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|0, 1.2, 0, 1.1|'// &
      '*METHOD, BASIS=GIMP, INTEGRATION=POINTS|'
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(contact_patches_type) :: patches
    type(body_points_type) :: nobody

    allocate (model, step)
    call make_step('SHAPE=CIRCLE|1, 2.1, 1', 'FRICTION ANGLE=0', '|0, -0.02', model, step, graded)
    call find_patches(model, all_points(model, .true.), all_points(model, .false.), nobody, patches)
    call tests%check('a piece that is short in its wide cell joins its neighbour', patches%count == 4)
    call end_system(step%system)
  end subroutine check_wide_cell

  !> A sliver of the axis in the box of a surface has no area, and leaves the patches as they are.
  subroutine check_sliver(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: cylinder = '*MODEL, TYPE=AXISYMMETRIC|*GRID, ELEMENT=QUAD4|X, 0, 2, 8|Y, 0, 2, 8|'// &
      '*NSET, NSET=base, PLANE=Y|0|*SURFACE, NAME=top, TYPE=OUTLINE, BODY=ground, BOX|0, 1.9, 1.095, 1.2|'// &
      '*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|0, 2, 0, 1.1|'// &
      '*METHOD, BASIS=GIMP, INTEGRATION=POINTS|'
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(contact_patches_type) :: patches
    type(body_points_type) :: nobody

    allocate (model, step)
    call make_step('SHAPE=PLANE|0, 1.2, 0, -1', 'FRICTION ANGLE=0', '|0, -0.02', model, step, cylinder)
    call tests%check('a surface has no points without area', all(model%state%surface%area > 0.0_wp))
    call find_patches(model, all_points(model, .true.), all_points(model, .false.), nobody, patches)
    call tests%check('a patch a cell of a top with a sliver of the axis', patches%count == 8)
    where (spread(model%state%surface%cell == model%state%surface%cell(1), 1, 2)) &
      model%state%surface%area_vector = 0.5_wp*model%state%surface%area_vector
    call find_patches(model, all_points(model, .true.), all_points(model, .false.), nobody, patches)
    call tests%check('half a cell is short at any radius', patches%count == 7)
    call end_system(step%system)
  end subroutine check_sliver

  !> A gap that is no number fails the step and says where; a build that stops at such a number needs no such check.
  subroutine check_numbers(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :)
    logical :: halts

    call ieee_get_halting_mode(ieee_invalid, halts)
    if (halts) return
    allocate (model, step)
    call make_step('SHAPE=PLANE|0, 1.1, 0, -1', 'FRICTION ANGLE=0', '|0, -0.02', model, step)
    allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
    model%state%surface%area_vector = 0.0_wp
    call initialise_step(model, step, error)
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    call evaluate_step(model, step, u, tangent_none)
    call tests%check('a gap that is no number fails', step%failure%failed .and. .not. allocated(error))
    call tests%check('and its place is named', index(step%failure%reason, "'tool' at (0.") > 0)
    call end_system(step%system)
  end subroutine check_numbers

  !> The matrix times a direction is the change of the residual along it.
  subroutine check_tangent(tests, contact, aside, ground)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: contact
    !> Displacement along the surface beside that into the tool.
    real(wp), intent(in) :: aside
    !> Cards of the model; the block when not given.
    character(len=*), intent(in), optional :: ground
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: u(:, :), v(:, :), product(:), change(:)
    integer :: a

    allocate (model, step)
    if (present(ground)) then
      call make_step('SHAPE=BOX|-1, 3, 1, 2', contact, '|0.01, -0.03|*CONSOLIDATION, UNIT WEIGHT=10', model, step, ground)
    else
      call make_step('SHAPE=CIRCLE|1, 3.105, 2', contact, ', ROTATION=1|0.01, -0.03', model, step)
    end if
    allocate (u(2, all_nodes(step%unknowns)), v(2, all_nodes(step%unknowns)))
    do a = 1, size(u, 2)
      u(:, a) = 1.0e-3_wp*[sin(1.7_wp*a), cos(2.3_wp*a)] + [aside, 0.0_wp]
      v(:, a) = [cos(0.7_wp*a), sin(1.1_wp*a)]
    end do
    call matrix_and_difference(model, step, u, v, difference, product, change)
    call tests%close('the matrix is the derivative of the residual, '//contact, maxval(abs(product - change)), 0.0_wp, &
      1.0e-6_wp*maxval(abs(change)))
    call tests%check('the contact is at work', norm2(force_named(step, 'force of the contacts', u)) > 0.1_wp)
    call end_system(step%system)
  end subroutine check_tangent

  !> A body that turns about one end moves too far where its other end does, though no other place moves as far.
  subroutine check_far_end(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: u(:, :)
    real(wp), parameter :: two_cells = 0.5_wp
    real(wp) :: far, next, angle
    integer :: i

    do i = 1, 2
      allocate (model, step)
      if (i == 2) then
        ! Half of the motion is in force: by chords of two cells between the last place and the one before it.
        angle = 2.0_wp*2.0_wp*asin(0.5_wp*two_cells/(0.5_wp*(far + next)))*180.0_wp/acos(-1.0_wp)
      else
        angle = 1.0_wp
      end if
      call make_step('SHAPE=PLANE|2, 1.1, 0, -1', 'FRICTION ANGLE=0', ', ROTATION='//real_text(angle)//'|0, 0', model, &
        step)
      far = 2.0_wp - minval(model%state%surface%position(1, :))
      next = 2.0_wp - minval(model%state%surface%position(1, :), &
        mask=model%state%surface%position(1, :) > 2.0_wp - far + 1.0e-9_wp)
      allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
      call evaluate_step(model, step, u, tangent_none)
      call tests%check('the last place of a body moves too far', step%failure%failed .eqv. i == 2)
      call end_system(step%system)
      deallocate (model, step, u)
    end do
  end subroutine check_far_end

  !> Short patches far apart join their own neighbours.
  subroutine check_two_short(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    type(contact_patches_type) :: patches
    type(body_points_type) :: nobody
    real(wp), allocatable :: before(:, :)
    integer :: round, c
    logical :: near

    allocate (before, source=model%state%surface%area_vector)
    near = .true.
    do round = 0, 1
      associate (surface => model%state%surface)
        surface%area_vector = before
        where (spread(surface%cell == surface%cell(merge(1, surface%count, round == 0)), 1, 2)) &
          surface%area_vector = 0.25_wp*before
        call find_patches(model, all_points(model, .true.), all_points(model, .false.), nobody, patches)
        do c = 1, patches%count
          associate (x => surface%position(1, patches%point(patches%first(c):patches%first(c + 1) - 1)))
            near = near .and. maxval(x) - minval(x) < 0.6_wp
          end associate
        end do
      end associate
    end do
    call tests%check('what is joined lies side by side, at either end', near)
    model%state%surface%area_vector = before
  end subroutine check_two_short

  !> A short patch between two joins the nearer one, whichever comes first.
  subroutine check_nearest_patch(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    type(contact_patches_type) :: patches
    type(body_points_type) :: nobody
    real(wp), parameter :: towards = -0.06_wp
    integer :: cell, side, c, i

    do side = -1, 1, 2
      cell = model%state%surface%cell(size(model%state%surface%cell)/2)
      do i = 1, model%state%surface%count
        if (model%state%surface%cell(i) /= cell) cycle
        if (side < 0) model%state%surface%area_vector(:, i) = 0.4_wp*model%state%surface%area_vector(:, i)
        model%state%surface%position(1, i) = model%state%surface%position(1, i) + merge(1.0_wp, 2.0_wp, side < 0) &
          *side*abs(towards)
      end do
      call find_patches(model, all_points(model, .true.), all_points(model, .false.), nobody, patches)
      do c = 1, patches%count
        associate (list => patches%point(patches%first(c):patches%first(c + 1) - 1))
          if (any(model%state%surface%cell(list) == cell)) call tests%check('a short patch joins the nearer one', &
            any((model%state%surface%position(1, list) - sum(model%state%surface%position(1, :), &
            mask=model%state%surface%cell == cell)/count(model%state%surface%cell == cell))*side > 0.1_wp))
        end associate
      end do
    end do
  end subroutine check_nearest_patch

  !> What is kept of a step that is taken, and of one that is not.
  subroutine check_step(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(load_step_type) :: solver
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    type(rigid_pose_type) :: pose
    real(wp) :: force(6), work, moved
    real(wp), allocatable :: u(:, :)

    allocate (model, step)
    call make_step('SHAPE=PLANE|0, 1.1, 0, -1', 'FRICTION ANGLE=30', ', ROTATION=0.5|0, -0.02', model, step)
    allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
    call evaluate_step(model, step, u, tangent_none)
    moved = norm2(force_named(step, 'force of the contacts', u))
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    call tests%check('what is asked for is not there before the step is evaluated', moved > 1.0_wp .and. &
      norm2(force_named(step, 'force of the contacts', u)) <= 0.0_wp)
    associate (controls => model%analysis%phases(1)%controls)
      call solver%solve(model, step, controls, attempt_type(1.0_wp, 1.0e-9_wp, largest_move=1.0e-6_wp), solution, error)
      pose = pose_of(model, 1)
      force = force_on_body(model, 1)
      call tests%check('of a step that is not taken nothing is kept', .not. solution%converged .and. &
        norm2(pose%displacement) <= 0.0_wp .and. norm2(force) <= 0.0_wp .and. &
        all(abs(model%state%surface%contact_pressure) <= 0.0_wp))
      call solver%solve(model, step, controls, attempt_type(1.0_wp, 1.0e-9_wp, largest_move=1.0_wp), solution, error)
    end associate
    call tests%check('the step is taken', solution%converged .and. .not. allocated(error))
    pose = pose_of(model, 1)
    force = force_on_body(model, 1)
    call tests%close('the body is where it was moved to', norm2(pose%displacement - [0.0_wp, -0.02_wp, 0.0_wp]), &
      0.0_wp, 1.0e-15_wp)
    call tests%close('and has turned', pose%rotation(3), 0.5_wp*acos(-1.0_wp)/180.0_wp, 1.0e-15_wp)
    ! But for a thousandth that goes into the stabilisation.
    call tests%close('the work of the body is the work of the stresses', model%state%progress%external_work, &
      model%state%progress%internal_work, 2.0e-3_wp*model%state%progress%internal_work)
    work = model%state%progress%external_work
    call tests%check('surface points keep their pressure', maxval(model%state%surface%contact_pressure) > 1.0_wp)
    call tests%close('the base carries what the body does', force(2), &
      sum(model%state%reactions(2, :)), 1.0e-6_wp*force(2))
    call tests%close('and along it', force(1), sum(model%state%reactions(1, :)), 1.0e-6_wp*force(2))
    call tests%close('the moment is that of the tractions', force(6), moment_of_tractions(model), 1.0e-8_wp*force(2))
    call solver%solve(model, step, model%analysis%phases(1)%controls, attempt_type(1.0_wp, 1.0e-9_wp, &
      largest_move=1.0_wp), solution, error)
    call tests%close('held, it does next to no more work', model%state%progress%external_work, work, 1.0e-2_wp*work)
    call end_system(step%system)
  end subroutine check_step

  !> Points that no body is near any more keep nothing of what they carried.
  subroutine check_parting(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(load_step_type) :: solver
    type(solution_type) :: solution
    type(error_type), allocatable :: error

    allocate (model, step)
    call make_step('SHAPE=PLANE|0, 5, 0, -1', 'FRICTION ANGLE=30', '|0, -0.02', model, step)
    model%state%surface%contact_pressure = 1.0_wp
    model%state%surface%contact_shear = 1.0_wp
    model%state%surface%contact_slip = 1.0_wp
    call solver%solve(model, step, model%analysis%phases(1)%controls, attempt_type(1.0_wp, 1.0e-9_wp, &
      largest_move=1.0_wp), solution, error)
    call tests%check('the step without a body near is taken', solution%converged .and. .not. allocated(error))
    associate (surface => model%state%surface)
      call tests%check('the points of its surface carry and slip no more', all(abs(surface%contact_pressure) <= 0.0_wp) &
        .and. all(abs(surface%contact_shear) <= 0.0_wp) .and. all(abs(surface%contact_slip) <= 0.0_wp))
    end associate
    call end_system(step%system)
  end subroutine check_parting

  !> Moment of the tractions that the surface points keep about the reference point, a point of the plane: pressure
  !> against the soil along the direction of the plane, shear as it was before it turned with the body.
  real(wp) function moment_of_tractions(model) result(moment)
    type(model_type), intent(in) :: model
    type(rigid_pose_type) :: pose
    real(wp) :: arm(2), on_body(2), back(2, 2)
    integer :: i

    pose = pose_of(model, 1)
    back = reshape([cos(pose%rotation(3)), -sin(pose%rotation(3)), sin(pose%rotation(3)), cos(pose%rotation(3))], [2, 2])
    moment = 0.0_wp
    associate (surface => model%state%surface)
      do i = 1, surface%count
        arm = surface%position(:, i) - [0.0_wp, 1.1_wp] - pose%displacement(:2)
        on_body = -surface%area(i)*(surface%contact_pressure(i)*[sin(pose%rotation(3)), -cos(pose%rotation(3))] &
          + matmul(back, surface%contact_shear(:, i)))
        moment = moment + arm(1)*on_body(2) - arm(2)*on_body(1)
      end do
    end associate
  end function moment_of_tractions

  !> With tension what has not touched is not pulled.
  subroutine check_bonds(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: force

    force = force_of_lifting('SHAPE=PLANE|0, 1.1, 0, -1')
    call tests%close('a plane that touches pulls: 100 E/h 0.01 on 2 m', force, 8000.0_wp, 1.0e-6_wp)
    force = force_of_lifting('SHAPE=BOX, ROUND=0.001|0.5, 1, 1.1, 2')
    call tests%close('a box on two of eight cells pulls these alone', force, 2000.0_wp, 1.0e-6_wp)
    force = force_of_lifting('SHAPE=PLANE|0, 1.11, 0, -1')
    call tests%close('one above the ground pulls nothing', force, 0.0_wp, 1.0e-12_wp)
    ! A thousandth of a cell is 2.5e-4.
    force = force_of_lifting('SHAPE=PLANE|0, 1.1002, 0, -1')
    call tests%close('within a thousandth of a cell it touches', force, 8000.0_wp*1.02_wp, 1.0e-6_wp)
    force = force_of_lifting('SHAPE=PLANE|0, 1.1003, 0, -1')
    call tests%close('beyond it does not', force, 0.0_wp, 1.0e-12_wp)
    force = force_of_lifting('SHAPE=PLANE|0, 1.11, 0, -1', -2.0_wp)
    call tests%close('what was drawn before is drawn on, from there', force, 16004.0_wp, 1.0e-6_wp)
  contains
    !> Vertical force on the block of a body with tension that goes up by 0.01.
    real(wp) function force_of_lifting(tool, pressure)
      character(len=*), intent(in) :: tool
      !> Before the step; none when absent.
      real(wp), intent(in), optional :: pressure
      type(error_type), allocatable :: error
      class(model_type), allocatable :: model
      class(step_type), allocatable :: step
      real(wp), allocatable :: u(:, :), push(:, :)

      allocate (model, step)
      call make_step(tool, 'TENSION=YES', '|0, 0.02', model, step)
      if (present(pressure)) then
        call end_system(step%system)
        model%state%surface%contact_pressure = pressure
        call initialise_step(model, step, error)
        call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
      end if
      allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
      call evaluate_step(model, step, u, tangent_none)
      allocate (push, source=force_named(step, 'force of the contacts', u))
      force_of_lifting = sum(push(2, :))
      call end_system(step%system)
    end function force_of_lifting
  end subroutine check_bonds

  !> Where nothing has moved yet soil in contact goes along with the body: it is pulled and sheared by the penalty,
  !> sheared only where the contact has a strength; at rest it has what it had, within its strength.
  subroutine check_along(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp) :: force(2)

    allocate (model, step)
    force = force_along('FRICTION ANGLE=30', '|0, 0.02', 0.0_wp, .true.)
    call tests%close('pulled: 5 on 2 m less 100 E/h 0.01', force(2), 7990.0_wp, 1.0e-6_wp)
    force = force_along('FRICTION ANGLE=30', '|0.02, 0', 0.0_wp, .true.)
    call tests%close('sheared beyond its friction: E/h 0.01 on 2 m', force(1), 80.0_wp, 1.0e-8_wp)
    force = force_along('FRICTION ANGLE=0', '|0.02, 0', 0.0_wp, .true.)
    call tests%close('a smooth one is not', force(1), 0.0_wp, 1.0e-12_wp)
    force = force_along('FRICTION ANGLE=30', '|0, 0.02', 7.0_wp, .false.)
    call tests%close('at rest it presses as before', force(2), -10.0_wp, 1.0e-12_wp)
    call tests%close('and is sheared within its friction', abs(force(1)), 10.0_wp*tan(acos(-1.0_wp)/6.0_wp), 1.0e-10_wp)
    force = force_along('FRICTION ANGLE=30', '|0, 0.02', 7.0_wp, .true., again=.true.)
    call tests%close('at rest again, within its friction again', abs(force(1)), 10.0_wp*tan(acos(-1.0_wp)/6.0_wp), &
      1.0e-10_wp)

  contains

    !> Force on the block, pressed by 5 and sheared before.
    function force_along(contact, move, shear, evaluated, again) result(force)
      character(len=*), intent(in) :: contact, move
      real(wp), intent(in) :: shear
      logical, intent(in) :: evaluated
      !> Whether loads are set once more after that; not when absent.
      logical, intent(in), optional :: again
      real(wp) :: force(2)
      type(error_type), allocatable :: error
      real(wp), allocatable :: u(:, :)

      call make_step('SHAPE=PLANE|0, 1.1, 0, -1', contact, move, model, step)
      call end_system(step%system)
      model%state%surface%contact_pressure = 5.0_wp
      model%state%surface%contact_shear(1, :) = shear
      call initialise_step(model, step, error)
      call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
      allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
      if (evaluated) call evaluate_step(model, step, u, tangent_none)
      if (present(again)) call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
      force = sum(force_named(step, 'force of the contacts', u), dim=2)
      call end_system(step%system)
    end function force_along
  end subroutine check_along

  !> Slip adds up while soil and body touch, turns with the body, and is none where they part.
  subroutine check_slip(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(load_step_type) :: solver
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    real(wp) :: largest, mean

    allocate (model, step)
    ! A smooth plane goes 0.02 into the block and 0.1 along it, which does not move with it.
    call make_step('SHAPE=PLANE|0, 1.1, 0, -1', 'FRICTION ANGLE=0', '|0.1, -0.02', model, step)
    call solver%solve(model, step, model%analysis%phases(1)%controls, attempt_type(0.5_wp, 1.0e-9_wp, &
      largest_move=1.0_wp), solution, error)
    call tests%check('the first half is taken', solution%converged)
    mean = contact_slip_on(model, 1, .true.)
    call tests%close('the mean slip is half of the motion', mean, 0.05_wp, 1.0e-4_wp)
    call solver%solve(model, step, model%analysis%phases(1)%controls, attempt_type(1.0_wp, 1.0e-9_wp, &
      largest_move=1.0_wp), solution, error)
    mean = contact_slip_on(model, 1, .true.)
    largest = contact_slip_on(model, 1, .false.)
    call tests%close('then the whole', mean, 0.1_wp, 2.0e-4_wp)
    call tests%check('the largest is more, as the sides of the block bulge', largest > 0.101_wp .and. largest < 0.12_wp)
    mean = contact_slip_on(model, 1, .true.)
    model%state%surface%contact_slip(1, 1:2) = 9.0_wp
    model%state%surface%contact_pressure(1:2) = 0.0_wp
    call tests%check('what does not press does not count', contact_slip_on(model, 1, .false.) < 0.12_wp .and. &
      abs(contact_slip_on(model, 1, .true.) - mean) < 0.01_wp)
    model%state%surface%contact_slip(1, 1:2) = -0.1_wp
    call tests%check('soil goes against the body', all(model%state%surface%contact_slip(1, :) < -0.08_wp))
    call end_system(step%system)
  end subroutine check_slip

  !> Pressures of patches that rise along the surface: between their middles they rise along a line, but for the points
  !> that are cut by the ends of a patch's length. At single points each has its own.
  subroutine check_pressure(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp) :: pressure

    allocate (model, step)
    call make_step('SHAPE=PLANE|0, 1.1, 0, -1', 'FRICTION ANGLE=0', '|0, -0.02', model, step)
    call raise_pressures(model)
    pressure = contact_pressure_at(model, [0.875_wp, 1.1_wp])
    call tests%close('pressure in the middle of a patch', pressure, 87.5_wp, 1.0e-10_wp)
    pressure = contact_pressure_at(model, [0.75_wp, 1.1_wp])
    call tests%close('between two patches', pressure, 75.0_wp, 1.0e-10_wp)
    pressure = contact_pressure_at(model, [0.8_wp, 1.1_wp])
    call tests%close('a fifth of a patch on', pressure, 80.0_wp, 2.0_wp)
    where (model%state%surface%position(1, :) > 0.75_wp) model%state%surface%surface = 2
    pressure = contact_pressure_at(model, [0.75_wp, 1.1_wp])
    call tests%close('at the end of a surface', pressure, 62.5_wp, 1.0e-10_wp)
    model%state%surface%surface = 1
    model%contact_pairs%pointwise = .true.
    pressure = contact_pressure_at(model, [0.8_wp, 1.1_wp])
    call tests%close('of the nearest point', pressure, 87.5_wp, 1.0e-10_wp)
    call end_system(step%system)
  end subroutine check_pressure

  !> Patches have pressures that rise by 100 a metre along x.
  subroutine raise_pressures(model)
    type(model_type), intent(inout) :: model
    integer :: i

    associate (surface => model%state%surface)
      do i = 1, surface%count
        surface%contact_pressure(i) = 100.0_wp*(0.25_wp*floor(surface%position(1, i)/0.25_wp) + 0.125_wp)
      end do
    end associate
  end subroutine raise_pressures

  !> In axisymmetry points weigh by their lengths as drawn, not by their areas: between two patches it is their mean.
  subroutine check_round_pressure(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: cylinder = '*MODEL, TYPE=AXISYMMETRIC|*GRID, ELEMENT=QUAD4|X, 0, 2, 8|Y, 0, 2, 8|'// &
      '*NSET, NSET=base, PLANE=Y|0|*SURFACE, NAME=top, TYPE=SEGMENT|2, 1.1, 0, 1.1|'// &
      '*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|0, 2, 0, 1.1|'// &
      '*METHOD, BASIS=GIMP, INTEGRATION=POINTS|'
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp) :: pressure

    allocate (model, step)
    call make_step('SHAPE=PLANE|0, 1.1, 0, -1', 'FRICTION ANGLE=0', '|0, -0.02', model, step, cylinder)
    call raise_pressures(model)
    pressure = contact_pressure_at(model, [0.5_wp, 1.1_wp])
    call tests%close('between two patches around an axis', pressure, 50.0_wp, 0.2_wp)
    call end_system(step%system)
  end subroutine check_round_pressure

  !> In space contact points have their place along z, and a plane that comes down presses on the whole top.
  subroutine check_space(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: cube = '*MODEL, TYPE=3D|*GRID, ELEMENT=HEX8|X, 0, 1, 2|Y, 0, 1.5, 3|Z, 0, 1, 2|'// &
      '*NSET, NSET=base, PLANE=Y|0|*SURFACE, NAME=top, TYPE=OUTLINE, BODY=ground, BOX|0, 1, 0.99, 1.01, 0, 1|'// &
      '*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 1, 0, 1|'// &
      '*METHOD, BASIS=STANDARD, INTEGRATION=CELL|'
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(contacts_type) :: term
    type(distance_type) :: distance
    type(error_type), allocatable :: error

    allocate (model, step)
    call make_step('SHAPE=PLANE|0, 1, 0, 0, -1, 0', 'FRICTION ANGLE=0', '|0, -0.02, 0', model, step, cube)
    term = contacts_of(step)
    call tests%check('contact in space', term%scratch%dimension == 3 .and. size(term%scratch%place, 2) > 0)
    call tests%check('its points lie along z too', maxval(term%scratch%place(3, :)) > 0.5_wp &
      .and. minval(term%scratch%place(3, :)) < 0.5_wp)
    call check_space_forces(tests, model, step)
    call check_space_patches(tests, model)
    call initialise_step(model, step, error)
    call keep_values(model%state%kept, 'body_loads', reshape([0.0_wp, 0.0_wp, 1.0_wp, spread(0.0_wp, 1, 17)], [20, 1]))
    call initialise_step(model, step, error)
    term = contacts_of(step)
    call tests%check('a body that is loaded along z alone is an unknown', .not. allocated(error) .and. &
      term%scratch%column(1) > 0)
    call end_system(step%system)
    call make_step('SHAPE=CYLINDER, ROUND=0.01|0.6, 1, 0.4, 0.2, 0.4', 'FRICTION ANGLE=0', '|0, -0.02, 0', model, step, cube)
    distance = model%rigid_shapes(1)%distance_at([1.0_wp, 1.2_wp, 0.4_wp])
    call tests%close('a cylinder stands where it is drawn', distance%value, 0.2_wp, 1.0e-14_wp)
    call end_system(step%system)
    call make_step('SHAPE=POLYGON, ROUND=0.01|0.2, 1|0.8, 1|0.8, 1.4|0.2, 1.4', 'FRICTION ANGLE=0', '|0, -0.02, 0', model, &
      step, cube)
    distance = model%rigid_shapes(1)%distance_at([1.0_wp, 1.2_wp, 7.0_wp])
    call tests%close('a polygon runs on along z', distance%value, 0.2_wp, 1.0e-14_wp)
    term = contacts_of(step)
    call tests%close('what lies along its base is counted', sum(term%scratch%area, mask=term%scratch%straight), &
      0.585_wp, 0.07_wp)
    call end_system(step%system)
  end subroutine check_space

  !> The plane goes down by 0.01 on a top of 1 by 1 and a strip of 0.01 along its sides, in the middle half as deep:
  !> 100 E/h 0.01 (1 + 0.04/2 + ...), and the moment about a corner of it.
  subroutine check_space_forces(tests, model, step)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    real(wp), allocatable :: u(:, :)
    real(wp), parameter :: push = 2.0e5_wp*(0.01_wp*1.04_wp - 0.04_wp*0.005_wp)

    allocate (u(3, all_nodes(step%unknowns)), source=0.0_wp)
    call evaluate_step(model, step, u, tangent_none)
    call commit_terms(step%terms, u, model)
    call tests%close('force and moment on a body in space', norm2(force_on_body(model, 1) - push*[0.0_wp, 1.0_wp, 0.0_wp, &
      -0.5_wp, 0.0_wp, 0.5_wp]), 0.0_wp, 1.0e-9_wp*push)
    call end_system(step%system)
  end subroutine check_space_forces

  !> Patches in space are short below 0.6 of a cell along either axis; pressures at a place mix patches beside it alone.
  subroutine check_space_patches(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    type(contact_patches_type) :: patches
    type(body_points_type) :: nobody
    real(wp), allocatable :: before(:, :)
    integer :: count_of(2), i

    allocate (before, source=model%state%surface%area_vector)
    do i = 1, 2
      where (spread(model%state%surface%cell == model%state%surface%cell(1), 1, 3)) &
        model%state%surface%area_vector = (0.36_wp + 0.01_wp*(2*i - 3))/1.04_wp*before
      call find_patches(model, all_points(model, .true.), all_points(model, .false.), nobody, patches)
      count_of(i) = patches%count
    end do
    call tests%check('0.35 of the face of a cell is short, 0.37 is not', all(count_of == [3, 4]))
    model%state%surface%area_vector = before
    associate (surface => model%state%surface)
      surface%contact_pressure = merge(10.0_wp, 20.0_wp, surface%position(3, :) < 0.5_wp)
      call tests%close('at the end along z its own pressure', contact_pressure_at(model, [0.25_wp, 1.0_wp, 0.0_wp]), 10.0_wp, &
        1.0e-12_wp)
      call tests%close('between two patches their mean', contact_pressure_at(model, [0.25_wp, 1.0_wp, 0.5_wp]), 15.0_wp, &
        1.0e-4_wp)
      surface%contact_pressure = merge(10.0_wp, 20.0_wp, surface%position(1, :) < 0.5_wp)
      call tests%close('along x as along z', contact_pressure_at(model, [0.0_wp, 1.0_wp, 0.25_wp]) + &
        contact_pressure_at(model, [0.5_wp, 1.0_wp, 0.25_wp]), 25.0_wp, 1.0e-4_wp)
      surface%contact_pressure = 0.0_wp
    end associate
  end subroutine check_space_patches

  !> The matrix of a ball in space that is loaded along all axes and slips on soil it sticks to elsewhere.
  subroutine check_space_tangent(tests, contact)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: contact
    character(len=*), parameter :: cube = '*MODEL, TYPE=3D|*GRID, ELEMENT=HEX8|X, 0, 1, 2|Y, 0, 1.5, 3|Z, 0, 1, 2|'// &
      '*NSET, NSET=base, PLANE=Y|0|*SURFACE, NAME=top, TYPE=OUTLINE, BODY=ground, BOX|0, 1, 0.99, 1.01, 0, 1|'// &
      '*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 1, 0, 1|'// &
      '*METHOD, BASIS=STANDARD, INTEGRATION=CELL|'
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :), v(:, :), product(:), change(:)
    real(wp) :: kept(20)
    integer :: a

    allocate (model, step)
    call make_step('SHAPE=CIRCLE|0.45, 1.95, 0.55, 1', contact, '|0.01, -0.03, 0.02, 0.5, 1, -0.7', model, step, cube)
    call end_system(step%system)
    kept = 0.0_wp
    kept([1, 2, 3]) = 1.0_wp
    call keep_values(model%state%kept, 'body_loads', reshape(kept, [20, 1]))
    call initialise_step(model, step, error)
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    allocate (u(3, all_nodes(step%unknowns)), v(3, all_nodes(step%unknowns)))
    do a = 1, size(u, 2)
      u(:, a) = 1.0e-3_wp*[sin(1.7_wp*a), cos(2.3_wp*a), sin(0.9_wp*a)] + [0.02_wp, 0.0_wp, 0.01_wp]
      v(:, a) = [cos(0.7_wp*a), sin(1.1_wp*a), cos(1.9_wp*a)]
    end do
    u(:, size(u, 2)) = [-0.01_wp, -0.02_wp, 0.005_wp]
    call matrix_and_difference(model, step, u, v, difference, product, change)
    call tests%close('in space the matrix is the derivative of the residual, '//contact, maxval(abs(product - change)), 0.0_wp, &
      1.0e-6_wp*maxval(abs(change)))
    call tests%check('the body moves by unknowns', any(step%field_of == 2) .and. &
      maxval(abs(product), mask=step%field_of == 2) > 1.0_wp)
    call end_system(step%system)
  end subroutine check_space_tangent

  !> Strength of an interface by a share of that of the soil; penalties and patches that are asked for.
  subroutine check_interface(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: ground = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 8|Y, 0, 2, 8|'// &
      '*NSET, NSET=base, PLANE=Y|0|*SURFACE, NAME=top, TYPE=SEGMENT|2, 1.1, 0, 1.1|*MATERIAL, NAME=sand|*ELASTIC|'// &
      '1000, 0.3|*MOHR COULOMB|4, 30, 0|*MATERIAL, NAME=clay|*ELASTIC|1000, 0.3|*MOHR COULOMB|5, 0, 0|'// &
      '*STRENGTH PROFILE, TYPE=LINEAR|1.1, 10, 2|*BODY, NAME=left, MATERIAL=sand, SHAPE=BOX|0, 1, 0, 1.1|'// &
      '*BODY, NAME=right, MATERIAL=clay, SHAPE=BOX|1, 2, 0, 1.1|*RIGID BODY, NAME=tool, SHAPE=PLANE|0, 1.1, 0, -1|'
    class(model_type), allocatable :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    real(wp) :: strength(2)

    allocate (model, analysis)
    call parse_deck('ground.inp', joined(ground//'*CONTACT, BODY=tool, SURFACE=top, INTERFACE=0.5, PENALTY=20, '// &
      'PATCH=POINT|'//press//'|0, -0.02|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    call tests%check('a deck with INTERFACE is read', .not. allocated(error))
    if (allocated(error)) return
    strength = interface_strength(model, 0.5_wp, [0.2_wp, 1.1_wp])
    call tests%close('share of tan phi', strength(1), 0.5_wp*tan(acos(-1.0_wp)/6.0_wp), 1.0e-15_wp)
    call tests%close('share of c', strength(2), 2.0_wp, 1.0e-15_wp)
    allocate (model%analysis%materials(1)%strength_profile%fields(1))
    associate (fields => model%analysis%materials(1)%strength_profile%fields)
      fields(1)%parameter = field_friction
      call set_samples(fields(1), reshape([0.2_wp, 1.1_wp], [2, 1]), [20.0_wp])
    end associate
    strength = interface_strength(model, 0.5_wp, [0.2_wp, 1.1_wp])
    call tests%close('share of tan phi by place', strength(1), 0.5_wp*tan(acos(-1.0_wp)/9.0_wp), 1.0e-15_wp)
    call tests%close('and of the c of all', strength(2), 2.0_wp, 1.0e-15_wp)
    deallocate (model%analysis%materials(1)%strength_profile%fields)
    strength = interface_strength(model, 0.5_wp, [1.8_wp, 0.6_wp])
    call tests%close('no friction on clay', strength(1), 0.0_wp, 1.0e-15_wp)
    ! Points lie up to an eighth of a cell from the place: half of a gain of 2 on 0.04.
    call tests%close('share of s_u where the place was', strength(2), 0.5_wp*(10.0_wp + 2.0_wp*0.5_wp), 0.07_wp)
    call check_patch_strengths(tests, model)
    call check_refused(tests, index_of('*MOHR COULOMB|5, 0, 0|*STRENGTH PROFILE, TYPE=LINEAR|1.1, 10, 2|'), '', &
      "material 'clay' does not have")
    call check_refused(tests, index_of('*MOHR COULOMB|4, 30, 0|'), '', "material 'sand' does not have")
    call check_kinds_of_strength(tests, model)
    call check_refused(tests, index_of('*MOHR COULOMB|5, 0, 0|*STRENGTH PROFILE, TYPE=LINEAR|1.1, 10, 2|'), &
      '*MOHR COULOMB|5, 20, 0|*UNDRAINED, TYPE=A|', "s_u of undrained material 'clay'")
  contains
    !> Where the cards that are replaced stand, and how long they are.
    pure function index_of(cards) result(place)
      character(len=*), intent(in) :: cards
      integer :: place(2)

      place = [index(ground, cards), len(cards)]
    end function index_of

    !> The same ground with other cards for its clay is refused, and why.
    subroutine check_refused(tests, place, cards, reason)
      type(tests_type), intent(inout) :: tests
      integer, intent(in) :: place(2)
      character(len=*), intent(in) :: cards, reason
      class(model_type), allocatable :: other
      class(analysis_type), allocatable :: given

      allocate (other, given)
      call parse_deck('ground.inp', joined(ground(:place(1) - 1)//cards//ground(sum(place):)//'*CONTACT, BODY=tool, '// &
        'SURFACE=top, INTERFACE=0.5|'//press//'|0, -0.02|*END PHASE|'), given, messages, error)
      if (.not. allocated(error)) call build_model(given, other, error)
      call tests%check('an interface without a strength is refused: '//reason, allocated(error))
      if (allocated(error)) call tests%check('and says: '//reason//' ('//error%message//')', &
        index(error%message, reason) > 0)
    end subroutine check_refused
  end subroutine check_interface

  !> What has c and phi beside a law of its own does not follow them, and there is no share of them.
  subroutine check_kinds_of_strength(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model

    call tests%check('c and phi alone', refused() == 0)
    model%analysis%materials(1)%own_law = .true.
    call tests%check('a law of an embedding program', refused() == 1)
    model%analysis%materials(1)%own_law = .false.
    model%analysis%materials(2)%user%given = .true.
    call tests%check('one of a user', refused() == 1)
    model%analysis%materials(2)%user%given = .false.
    allocate (drucker_prager_parameters_type :: model%analysis%materials(1)%soil_law)
    call tests%check('a soil model', refused() == 1)
    deallocate (model%analysis%materials(1)%soil_law)
    model%analysis%materials(2)%strength_profile%kind = profile_shansep
    call tests%check('a strength that follows the stress', refused() == 1)
    model%analysis%materials(2)%strength_profile%kind = profile_linear
    model%analysis%materials(2)%undrained%given = .true.
    call tests%check('undrained clay has its s_u', refused() == 0)
    model%analysis%materials(1)%undrained%given = .true.
    call tests%check('undrained sand has none', refused() == 1)
    model%analysis%materials%undrained%given = .false.
    model%analysis%contacts(1)%interface = -1.0_wp
    model%analysis%materials%mohr_coulomb = .false.
    call tests%check('without a share all is right', refused() == 0)
    model%analysis%materials%mohr_coulomb = .true.
    model%analysis%contacts(1)%interface = 0.5_wp
  contains
    !> Number of things that are wrong.
    integer function refused()
      type(diagnostics_type) :: diagnostics

      call check_interfaces(model, diagnostics)
      refused = diagnostics%count
    end function refused
  end subroutine check_kinds_of_strength

  !> Its patches are points with the strength of the soil there, lowered by a factor of safety.
  subroutine check_patch_strengths(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    class(step_type), allocatable :: step
    type(error_type), allocatable :: error
    type(contacts_type) :: term
    real(wp), allocatable :: u(:, :), force(:, :)

    allocate (step)
    call begin_analysis(model, step%terms)
    call start_phase(model)
    model%state%progress%strength_factor = 2.0_wp
    call initialise_step(model, step, error)
    call begin_terms(step%terms, increment_type(step_info_type(duration=0.5_wp, phase_time=1.0_wp)))
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
    u(1, :) = 0.1_wp
    call evaluate_step(model, step, u, tangent_none)
    allocate (force, source=force_named(step, 'force of the contacts', u))
    ! p = 20 E/h 0.01 = 800; the sand has 0.25 tan 30 p + 1 on 1 m, the clay 2.5 (its profile falls to 10 at the top).
    call tests%close('pressure by the penalty that is asked for', -sum(force(2, :)), 1600.0_wp, 1.0e-9_wp)
    call tests%close('shear by the shares, lowered', -sum(force(1, :)), 0.25_wp*tan(acos(-1.0_wp)/6.0_wp)*800.0_wp &
      + 1.0_wp + 2.5_wp, 0.1_wp)
    term = contacts_of(step)
    call tests%check('a condition at every point', term%scratch%patches%count == model%state%surface%count)
    call end_system(step%system)
  end subroutine check_patch_strengths

  !> A factor of safety lowers the strength of the interface.
  subroutine check_strength(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(contacts_type) :: term
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :)
    real(wp) :: whole, lowered

    allocate (model, step)
    call make_step('SHAPE=PLANE|0, 1.1, 0, -1', 'ADHESION=8', '|0.1, -0.02', model, step)
    allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
    call tests%close('before the step is evaluated nothing slips', &
      norm2(force_named(step, 'force of the contacts', u)), 0.0_wp, 0.0_wp)
    call evaluate_step(model, step, u, tangent_none)
    whole = sum(force_named(step, 'force of the contacts', u), mask=spread([.true., .false.], 2, size(u, 2)))
    call tests%close('a surface of 2 m slips at its adhesion', whole, 16.0_wp, 1.0e-10_wp)
    term = contacts_of(step)
    call tests%check('adhesion on a body that does not turn leaves the matrix symmetric', term%symmetric)
    call tests%check('where nothing has moved yet soil in contact goes along with the body', term%scratch%goes_along)
    call set_loads(step%terms, model, step%configuration_type, 0.0_wp)
    call evaluate_step(model, step, u, tangent_none)
    term = contacts_of(step)
    call tests%check('it does not with one that stays', .not. term%scratch%goes_along)
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    u(1, 1) = 1.0e-9_wp
    call evaluate_step(model, step, u, tangent_none)
    term = contacts_of(step)
    call tests%check('nor where anything has moved yet', .not. term%scratch%goes_along)
    u(1, 1) = 0.0_wp
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    call evaluate_step(model, step, u, tangent_none)
    model%state%progress%strength_factor = 2.0_wp
    call end_system(step%system)
    call initialise_step(model, step, error)
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    call evaluate_step(model, step, u, tangent_none)
    lowered = sum(force_named(step, 'force of the contacts', u), mask=spread([.true., .false.], 2, size(u, 2)))
    call tests%close('a factor of 2 halves it', lowered, 8.0_wp, 1.0e-10_wp)
    call end_system(step%system)
  end subroutine check_strength

  !> Soil under initial stresses presses on the body that it touches, and not where it does not touch it.
  subroutine check_rest(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(initial_stress_type) :: initial
    real(wp), parameter :: normal(2) = [0.0_wp, -1.0_wp]
    integer :: p

    allocate (model)
    call make_rest('0, 1.1, 0, -1')
    call tests%close('pressure of the stress', maxval(abs(model%state%surface%contact_pressure - 30.0_wp)), 0.0_wp, &
      1.0e-12_wp)
    call tests%close('shear of the stress: that of the body on the soil', &
      maxval(abs(model%state%surface%contact_shear(1, :) - 7.0_wp)), 0.0_wp, 1.0e-12_wp)
    call tests%close('the shear is along the body', maxval(abs(matmul(normal, model%state%surface%contact_shear))), &
      0.0_wp, 1.0e-12_wp)
    call make_rest('0, 1.2, 0, -1')
    call tests%check('no touch, no pressure', all(abs(model%state%surface%contact_pressure) <= 0.0_wp))
    ! A hundredth of a cell.
    call make_rest('0, 1.1025, 0, -1')
    call tests%check('near is no touch', all(abs(model%state%surface%contact_pressure) <= 0.0_wp))
    call make_rest('0, 1.1, 0, -1', 0.0_wp)
    call tests%check('no pressure, no shear', all(abs(model%state%surface%contact_shear) <= 0.0_wp))
  contains
    !> A plane at or above the block, which has one stress.
    subroutine make_rest(plane, upright)
      character(len=*), intent(in) :: plane
      !> Stress along y, -30 when not given.
      real(wp), intent(in), optional :: upright
      class(step_type), allocatable :: step

      allocate (step)
      call make_step('SHAPE=PLANE|'//plane, 'FRICTION ANGLE=30', '|0, -0.02', model, step)
      call end_system(step%system)
      do p = 1, model%state%points%count
        model%state%points%stress(:, p) = [-10.0_wp, -30.0_wp, -12.0_wp, 7.0_wp]
        if (present(upright)) model%state%points%stress(2, p) = upright
      end do
      initial%kind = initial_given
      call press_on_bodies(model, initial)
    end subroutine make_rest
  end subroutine check_rest

  !> A wall beside ground at rest carries K0 times the weight above each point, however far the next material point is.
  subroutine check_wall(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: ground = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 8|Y, 0, 2, 8|'// &
      '*NSET, NSET=base, PLANE=Y|0|*SURFACE, NAME=top, TYPE=SEGMENT|2, 0, 2, 1|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|'// &
      '*UNIT WEIGHT|20|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|0, 2, 0, 1|*METHOD, BASIS=GIMP, INTEGRATION=POINTS|'
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step

    allocate (model, step)
    call make_step('SHAPE=PLANE|2, 0, -1, 0', 'FRICTION ANGLE=30', '|0, 0|*INITIAL, TYPE=K0|1, 0.5|*GRAVITY|0, -1', model, step, &
      ground)
    associate (surface => model%state%surface)
      call tests%close('pressure at rest by depth', maxval(abs(surface%contact_pressure - 0.5_wp*20.0_wp*(1.0_wp &
        - surface%position(2, :)))), 0.0_wp, 1.0e-11_wp)
      call tests%close('no shear', maxval(abs(surface%contact_shear)), 0.0_wp, 1.0e-12_wp)
    end associate
    call end_system(step%system)
  end subroutine check_wall

  !> Of two surfaces at one place and two bodies each contact has its own: initial pressures, slip, pressure at a place.
  subroutine check_other_surfaces(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(initial_stress_type) :: initial
    type(penetration_check_type) :: check
    type(test_observer_type) :: observer
    integer, allocatable :: top(:), side(:)
    integer :: i

    allocate (model, step)
    call make_step('SHAPE=PLANE|0, 1.1, 0, -1', 'FRICTION ANGLE=30|*RIGID BODY, NAME=other, SHAPE=PLANE|0, 1.1, 0, -1|'// &
      '*CONTACT, BODY=other, SURFACE=side', '|0, -0.02', model, step, block//'*SURFACE, NAME=side, TYPE=SEGMENT|2, 1.1, '// &
      '0, 1.1|*SURFACE, NAME=free, TYPE=SEGMENT|2, 1.1, 0, 1.1|')
    call end_system(step%system)
    model%state%points%stress = spread([-10.0_wp, -30.0_wp, -12.0_wp, 7.0_wp], 2, model%state%points%count)
    initial%kind = initial_given
    call press_on_bodies(model, initial)
    associate (surface => model%state%surface)
      top = pack([(i, i=1, surface%count)], surface%surface == 1)
      side = pack([(i, i=1, surface%count)], surface%surface == 2)
      call tests%check('what is in no contact has no pressure', maxval(surface%surface) == 3 .and. &
        all(surface%contact_pressure > 29.0_wp .eqv. surface%surface < 3))
      surface%contact_slip(1, top) = 0.25_wp
      surface%contact_slip(1, side) = 0.5_wp
      call tests%close('slip on a body is that of its own surfaces', contact_slip_on(model, 1, .true.), 0.25_wp, 1.0e-12_wp)
      call tests%close('and that on the other', contact_slip_on(model, 2, .true.), 0.5_wp, 1.0e-12_wp)
      ! As if another process had a point.
      model%part%surface = [(i /= top(1), i=1, surface%count)]
      surface%contact_slip(1, top(1)) = 9.0_wp
      call tests%close('a process counts the slip of its own points', contact_slip_on(model, 1, .true.) &
        + contact_slip_on(model, 1, .false.), 0.5_wp, 1.0e-12_wp)
      surface%contact_pressure = merge(4.0_wp, 7.0_wp, model%part%surface)
      call tests%close('and the pressures of its own points', contact_pressure_at(model, &
        surface%initial_position(:, top(1)) - [0.01_wp, 0.0_wp]), 4.0_wp, 1.0e-12_wp)
      deallocate (model%part%surface)
      surface%contact_pressure = [(1.0_wp*i, i=1, surface%count)]
      model%contact_pairs%pointwise = .true.
      call tests%close('the first point has its pressure', contact_pressure_at(model, surface%initial_position(:, top(1))), &
        surface%contact_pressure(top(1)), 1.0e-12_wp)
      ! What is in contact lies lower.
      surface%initial_position(2, top) = surface%initial_position(2, top) - 0.1_wp
      surface%initial_position(2, side) = surface%initial_position(2, side) - 0.2_wp
      call tests%close('the nearest that is in contact counts', contact_pressure_at(model, &
        surface%initial_position(:, top(1)) + [0.0_wp, 0.1_wp]), surface%contact_pressure(top(1)), 1.0e-12_wp)
      ! Turned round, the points of the third surface alone look away from the bodies.
      where (spread(surface%surface == 3, 1, 2)) surface%area_vector = -surface%area_vector
      call warn_of_penetration(model, penetration_type(), check, observer)
      call tests%check('a surface in no contact folds as it likes', .not. allocated(observer%text))
      model%contact_pairs%surface = 9
      call tests%close('where nothing is in contact there is none', contact_pressure_at(model, [2.0_wp, 1.1_wp]), 0.0_wp, &
        0.0_wp)
      model%contact_pairs = model%contact_pairs(:0)
      call tests%close('nor in a model without a contact', contact_pressure_at(model, [2.0_wp, 1.1_wp]), 0.0_wp, 0.0_wp)
    end associate
  end subroutine check_other_surfaces

  !> A body that has gone far and turned before the step: its motion is that of the step.
  subroutine check_turned_body(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(error_type), allocatable :: error
    type(contacts_type) :: term
    real(wp), allocatable :: u(:, :)

    allocate (model, step)
    call make_step('SHAPE=CIRCLE|1, 2.1, 0.5', 'FRICTION ANGLE=0', ', ROTATION=20|0, 0', model, step)
    call keep_rigid_body(model, 1, rigid_pose_type([8.0_wp, 3.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.1_wp]), spread(0.0_wp, 1, 6))
    call initialise_step(model, step, error)
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
    call evaluate_step(model, step, u, tangent_none)
    call tests%check('it turns about where it is', .not. step%failure%failed)
    term = contacts_of(step)
    call tests%check('and has moved, by a force of bodies that hold soil', term%scratch%goes_along .and. term%of_bodies &
      .and. term%anchors)
    model%analysis%phases(1)%moves(1)%rotation = 0.0_wp
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    call evaluate_step(model, step, u, tangent_none)
    term = contacts_of(step)
    call tests%check('one that stays as it has turned has not', .not. term%scratch%goes_along)
    call end_system(step%system)
  end subroutine check_turned_body

  !> Soil deep inside of a body is refused; a body that moves too far in one step is.
  subroutine check_penetration(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(error_type), allocatable :: error
    type(placed_shape_type), allocatable :: bodies(:)
    type(penetration_type) :: found
    real(wp), allocatable :: u(:, :)

    allocate (model, step)
    call make_step('SHAPE=PLANE|0, 1.1, 0, -1', 'FRICTION ANGLE=0', '|0, -0.1', model, step)
    call tests%check('half of the move is in force', norm2(bodies_displacement() - [0.0_wp, -0.05_wp]) < 1.0e-14_wp)
    bodies = placed_bodies(model)
    call refuse_penetration(model, bodies, found, error)
    call tests%check('soil outside is right', .not. allocated(error))
    call widest_gap(model, bodies, found%pressed, found%place, found%gap)
    call tests%check('where contact is on the soil no gap is measured', found%pressed == 0 .and. found%gap <= 0.0_wp)
    bodies(1)%pose%displacement(2) = -0.10_wp
    call refuse_penetration(model, bodies, found, error)
    call tests%check('soil a little inside is not refused', .not. allocated(error))
    bodies(1)%pose%displacement(2) = -0.20_wp
    call refuse_penetration(model, bodies, found, error)
    call tests%check('soil half a cell inside is', allocated(error))
    if (allocated(error)) call tests%check('by a sentence that names the body ('//error%message//')', &
      index(error%message, "inside rigid body 'tool'") > 0)
    call end_system(step%system)
    call make_step('SHAPE=PLANE|0, 1.1, 0, -1', 'FRICTION ANGLE=0', '|0, -1.1', model, step)
    allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
    call evaluate_step(model, step, u, tangent_none)
    call tests%check('a body that moves by more than two cells loses the step', step%failure%failed)
    if (step%failure%failed) call tests%check('by a sentence ('//step%failure%reason//')', &
      index(step%failure%reason, "rigid body 'tool' moves by more than") > 0)
    call end_system(step%system)
    ! Ten cells above the block, where no surface point is near.
    call make_step('SHAPE=CIRCLE|1, 4.1, 0.5', 'FRICTION ANGLE=0', '|0, -6', model, step)
    call evaluate_step(model, step, u, tangent_none)
    call tests%check('one far away does, too: it might pass through the soil unseen', step%failure%failed)
    call end_system(step%system)
  contains
    !> Displacement of the body at the end of the step.
    function bodies_displacement() result(displacement)
      real(wp) :: displacement(2)

      bodies = bodies_at_end(step%terms)
      displacement = bodies(1)%pose%displacement(:2)
    end function bodies_displacement
  end subroutine check_penetration
end module test_contacts
