!> Rigid bodies of a model: their shapes from the deck, the surfaces that may be in contact with each of them, and the
!> data stored from step to step: pose, and force and moment of the soil on them.
!>
!> The moment is about the present position of the reference point: the centre of a circle or box, the tip of a cone,
!> the given point of a plane, the centroid of a polygon, the centre of a cylinder's base. In axisymmetry forces are per
!> radian, as reactions are.
!>
!> Strength of an interface as a share of that of the adjacent soil (*CONTACT, INTERFACE=R), as in PLAXIS:
!>
!>   tan(delta) = R tan(phi),   a = R c,   a = R s_u of soil whose strength is a function of position
!>
!> for the material of the nearest material point; a profile is evaluated at the initial position of that point, as by
!> its law. Softening of the soil does not reduce the strength of the interface.
module qsmpm_rigid_bodies
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_active_bodies, only: body_materials, body_number
  use qsmpm_analysis, only: axisymmetric, three_dimensional
  use qsmpm_structures, only: rigid_body_type, patch_point, rigid_plane, rigid_circle, rigid_box, rigid_cone, &
    rigid_cylinder
  use qsmpm_body_points, only: make_body_outlines, lay_body_points
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_kept_arrays, only: is_kept, lay_array, kept_values, keep_values
  use qsmpm_model, only: model_type, contact_pair_type
  use qsmpm_own_part, only: own_of
  use qsmpm_polygon, only: polygon_centroid
  use qsmpm_points, only: place_of, nearest_point
  use qsmpm_rigid_pose, only: rigid_pose_type, placed_shape_type
  use qsmpm_rigid_shape, only: rigid_shape_type, distance_type, half_space, ball, rounded_polygon, cone_polygon, &
    box_polygon, turned_polygon, rounded_block, completed_by_image, largest_round
  use qsmpm_team, only: total
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_text, only: real_text
  use qsmpm_material_description, only: material_type
  use qsmpm_strength_profile, only: follows_stress, strength_at
  use qsmpm_value_field, only: field_friction, value_at
  implicit none
  private

  public :: make_rigid_bodies, make_shape, lay_rigid_bodies, placed_bodies, pose_of, keep_rigid_body, force_on_body, &
    motion_in_phase, interface_strength, check_interfaces

  character(len=*), parameter :: kept_name = 'rigid_bodies'
  !> Rows of the stored array: displacement, rotation, force and moment.
  integer, parameter :: rows = 12, rotation_row = 4, force_row = 7
  !> Default radius of corners in cell sizes.
  real(wp), parameter :: usual_round = 0.25_wp
  !> Largest radius of corners relative to the geometric maximum.
  real(wp), parameter :: most_of_edge = 0.99_wp
  !> Depth in cells by which soil may initially be inside a body: that of the chords of a polygon along a circle.
  real(wp), parameter, public :: drawn_within = 1.0e-2_wp
  !> The same where the soil was removed along the body: the centre of a thin piece along an arc is inside it.
  real(wp), parameter :: left_within = 5.0e-2_wp
  !> Distance in cells up to which a surface is initially in contact; share of it next to rounded corners above which a
  !> warning is printed, and a note where the surface adheres.
  real(wp), parameter :: touching = 1.0e-3_wp, much_beside = 0.1_wp, some_beside = 0.03_wp

  real(wp), parameter :: degree = acos(-1.0_wp)/180.0_wp

contains

  !> Creates the shapes of all bodies, and the pairs that may be in contact; the names have been checked with the deck.
  subroutine make_rigid_bodies(model, diagnostics)
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: b, i

    associate (bodies => model%analysis%rigid_bodies, contacts => model%analysis%contacts)
      allocate (model%rigid_shapes(size(bodies)), model%contact_pairs(size(contacts)))
      do b = 1, size(bodies)
        call make_shape(bodies(b), model%analysis%model, model%cell_size, &
          model%rigid_shapes(b)%shape, model%rigid_shapes(b)%reference, diagnostics)
      end do
      do i = 1, size(contacts)
        model%contact_pairs(i) = contact_pair_type(place_named(model%analysis%rigid_bodies, contacts(i)%body), &
          place_named(model%analysis%surfaces, contacts(i)%surface), tan(contacts(i)%friction_angle*degree), &
          contacts(i)%adhesion, contacts(i)%tension, contacts(i)%interface, contacts(i)%penalty, &
          contacts(i)%patch == patch_point)
      end do
    end associate
    call make_body_outlines(model)
    call check_overlap(model, diagnostics)
    call tell_round_corners(model)
    call check_interfaces(model, diagnostics)
  end subroutine make_rigid_bodies

  !> Checks that no soil is initially inside a body.
  subroutine check_overlap(model, diagnostics)
    type(model_type), intent(in) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    type(distance_type) :: distance
    real(wp) :: inside, within
    integer :: b, p

    do b = 1, size(model%rigid_shapes)
      inside = 0.0_wp
      within = merge(left_within, drawn_within, model%analysis%rigid_bodies(b)%in_place)*model%cell_size
      associate (own => own_of(model%part%points, model%state%points%count))
        do p = 1, size(own)
          if (.not. own(p)) cycle
          distance = model%rigid_shapes(b)%distance_at(place_of(model%state%points, p))
          if (distance%value < -within) inside = inside + model%state%points%volume(p)
        end do
      end associate
      inside = total(model%part%team, inside)
      associate (body => model%analysis%rigid_bodies(b))
        if (inside > 0.0_wp) call add_diagnostic(diagnostics, body%where, '*RIGID BODY', 'soil of volume '// &
          rounded_text(inside)//" is inside '"//body%name//"': define the soil bodies without it, or remove it "// &
          'by IN PLACE=YES')
      end associate
    end do
  end subroutine check_overlap

  !> Warns where a large part of a surface defined along a body is next to its rounded corners, which it does not touch.
  subroutine tell_round_corners(model)
    type(model_type), intent(inout) :: model
    type(rigid_body_type) :: body
    type(placed_shape_type) :: sharp
    type(distance_type) :: distance
    type(diagnostics_type) :: said
    character(len=:), allocatable :: begin
    real(wp) :: drawn, beside
    integer :: i, p

    do i = 1, size(model%contact_pairs)
      associate (pair => model%contact_pairs(i), points => model%state%surface)
        body = model%analysis%rigid_bodies(pair%body)
        body%round = touching*model%cell_size
        call make_shape(body, model%analysis%model, model%cell_size, sharp%shape, sharp%reference, said)
        drawn = 0.0_wp
        beside = 0.0_wp
        do p = 1, points%count
          if (points%surface(p) /= pair%surface) cycle
          distance = sharp%distance_at(place_of(points, p))
          if (abs(distance%value) > touching*model%cell_size) cycle
          drawn = drawn + points%area(p)
          distance = model%rigid_shapes(pair%body)%distance_at(place_of(points, p))
          if (distance%value > touching*model%cell_size) beside = beside + points%area(p)
        end do
        begin = ''
        if (beside > much_beside*drawn) begin = 'warning: '
        if (len(begin) == 0 .and. .not. (max(pair%adhesion, pair%interface) > 0.0_wp .and. &
          beside > some_beside*drawn)) cycle
        model%notes = model%notes//begin//rounded_text(100.0_wp*beside/drawn, 2)//" % of the part of surface '"// &
          model%analysis%contacts(i)%surface//"' along rigid body '"//body%name//"' is beside its rounded corners, "// &
          'without contact or adhesion: use a smaller ROUND of *RIGID BODY, or smaller cells (the default is a '// &
          'quarter of a cell)'//new_line('a')
      end associate
    end do
  end subroutine tell_round_corners

  !> Creates shape and reference point of one body.
  subroutine make_shape(body, kind_of_model, cell_size, shape, reference, diagnostics)
    type(rigid_body_type), intent(in) :: body
    !> plane_strain, axisymmetric or three_dimensional.
    integer, intent(in) :: kind_of_model
    real(wp), intent(in) :: cell_size
    type(rigid_shape_type), intent(out) :: shape
    real(wp), intent(out) :: reference(3)
    type(diagnostics_type), intent(inout) :: diagnostics
    real(wp), allocatable :: vertices(:, :)
    real(wp) :: round, axis(2)
    logical :: turned

    if (body%shape == rigid_box .and. kind_of_model == three_dimensional) then
      call make_block(body, cell_size, shape, reference, diagnostics)
      return
    end if
    reference = body%place
    turned = any(body%shape == [rigid_cone, rigid_cylinder]) .and. kind_of_model == three_dimensional
    axis = body%place(:2)
    if (turned) axis(1) = 0.0_wp
    select case (body%shape)
    case (rigid_plane)
      shape = half_space(body%place, body%direction)
      return
    case (rigid_circle)
      shape = ball(body%place, body%radius)
      return
    case (rigid_box)
      vertices = box_polygon(body%box(:2, 1), body%box(:2, 2))
    case (rigid_cone)
      vertices = cone_polygon(axis, body%radius, 0.5_wp*body%apex_angle*degree, body%shaft)
    case (rigid_cylinder)
      vertices = box_polygon(axis - [body%radius, 0.0_wp], axis + [body%radius, body%shaft])
    case default
      vertices = body%polygon
    end select
    if (kind_of_model == axisymmetric) vertices = completed_by_image(vertices, 1.0e-6_wp*cell_size)
    if (.not. any(body%shape == [rigid_cone, rigid_cylinder])) reference(:2) = polygon_centroid(vertices)
    round = round_of(body, cell_size, largest_round(vertices))
    if (round > most_of_edge*largest_round(vertices)) then
      call refuse_round(body, round, largest_round(vertices), diagnostics)
    else if (turned) then
      shape = turned_polygon(body%place, vertices, round)
    else
      shape = rounded_polygon(vertices, round)
    end if
  end subroutine make_shape

  !> Creates a box in space, rotated about its centre.
  subroutine make_block(body, cell_size, shape, reference, diagnostics)
    type(rigid_body_type), intent(in) :: body
    real(wp), intent(in) :: cell_size
    type(rigid_shape_type), intent(out) :: shape
    real(wp), intent(out) :: reference(3)
    type(diagnostics_type), intent(inout) :: diagnostics
    real(wp) :: largest, round

    reference = 0.5_wp*(body%box(:, 1) + body%box(:, 2))
    largest = 0.5_wp*minval(body%box(:, 2) - body%box(:, 1))
    round = round_of(body, cell_size, largest)
    if (round > most_of_edge*largest) call refuse_round(body, round, largest, diagnostics)
    shape = rounded_block(body%box(:, 1), body%box(:, 2), body%rotation*degree, round)
  end subroutine make_block

  !> Returns the radius of the corners of a body.
  pure real(wp) function round_of(body, cell_size, largest) result(round)
    type(rigid_body_type), intent(in) :: body
    real(wp), intent(in) :: cell_size
    !> Radius at which an edge has zero length.
    real(wp), intent(in) :: largest

    round = body%round
    if (round < 0.0_wp) round = min(usual_round*cell_size, 0.5_wp*largest)
  end function round_of

  !> Reports that the radius of corners is too large.
  subroutine refuse_round(body, round, largest, diagnostics)
    type(rigid_body_type), intent(in) :: body
    real(wp), intent(in) :: round, largest
    type(diagnostics_type), intent(inout) :: diagnostics

    call add_diagnostic(diagnostics, body%where, '*RIGID BODY', "the corners of '"//body%name// &
      "' cannot be as round as ROUND="//real_text(round)//': its edges allow '//rounded_text(most_of_edge*largest))
  end subroutine refuse_round

  !> Allocates the stored data of the bodies in the state: none has moved.
  subroutine lay_rigid_bodies(model)
    type(model_type), intent(inout) :: model
    real(wp) :: none(rows, size(model%analysis%rigid_bodies))

    none = 0.0_wp
    if (size(none, 2) > 0) call lay_array(model%state%kept, kept_name, none)
    call lay_body_points(model)
  end subroutine lay_rigid_bodies

  !> Returns the present pose of a body.
  pure type(rigid_pose_type) function pose_of(model, body) result(pose)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    real(wp) :: values(rows, size(model%analysis%rigid_bodies))

    values = kept_values(model%state%kept, kept_name)
    pose = rigid_pose_type(values(:3, body), values(rotation_row:force_row - 1, body))
  end function pose_of

  !> Returns the bodies in their present position; while the model is built that of the deck.
  pure function placed_bodies(model) result(bodies)
    type(model_type), intent(in) :: model
    type(placed_shape_type), allocatable :: bodies(:)
    integer :: b

    allocate (bodies, source=model%rigid_shapes)
    if (.not. is_kept(model%state%kept, kept_name)) return
    do b = 1, size(bodies)
      bodies(b)%pose = pose_of(model, b)
    end do
  end function placed_bodies

  !> Returns force and moment of the soil on a body.
  pure function force_on_body(model, body) result(force)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    real(wp) :: force(6), values(rows, size(model%analysis%rigid_bodies))

    values = kept_values(model%state%kept, kept_name)
    force = values(force_row:, body)
  end function force_on_body

  !> Stores pose, force and moment of a body.
  pure subroutine keep_rigid_body(model, body, pose, force)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: body
    type(rigid_pose_type), intent(in) :: pose
    !> Force and moment of the soil on the body.
    real(wp), intent(in) :: force(6)
    real(wp) :: values(rows, size(model%analysis%rigid_bodies))

    values = kept_values(model%state%kept, kept_name)
    values(:, body) = [pose%displacement, pose%rotation, force]
    call keep_values(model%state%kept, kept_name, values)
  end subroutine keep_rigid_body

  !> Returns the motion of a body in the whole present phase.
  pure type(rigid_pose_type) function motion_in_phase(model, body) result(motion)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    integer :: i

    associate (phase => model%analysis%phases(model%state%progress%phase))
      if (.not. allocated(phase%moves)) return
      do i = 1, size(phase%moves)
        if (phase%moves(i)%is_load) cycle
        if (phase%moves(i)%body == model%analysis%rigid_bodies(body)%name) motion = rigid_pose_type( &
          phase%load_factor*phase%moves(i)%vector, phase%load_factor*phase%moves(i)%rotation*degree)
      end do
    end associate
  end function motion_in_phase

  !> Returns tangent of the angle of friction, and adhesion, of an interface at a place.
  pure function interface_strength(model, share, x) result(strength)
    type(model_type), intent(in) :: model
    !> R.
    real(wp), intent(in) :: share
    !> Present position (dimension).
    real(wp), intent(in) :: x(:)
    real(wp) :: strength(2), place(3)
    integer :: p

    p = nearest_point(model%state%points, x)
    place = 0.0_wp
    place(:size(x)) = model%state%points%initial_position(:, p)
    associate (material => model%analysis%materials(model%state%points%material(p)))
      strength(1) = share*tan(degree*value_at(material%strength_profile%fields, field_friction, place, &
        material%friction_angle))
      strength(2) = share*max(material%cohesion, strength_at(material%strength_profile, place))
    end associate
  end function interface_strength

  !> Checks that the strength of soil next to an interface with INTERFACE is known: c and phi of *MOHR COULOMB.
  subroutine check_interfaces(model, diagnostics)
    type(model_type), intent(in) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: i, m

    do i = 1, size(model%analysis%contacts)
      if (.not. model%analysis%contacts(i)%interface > 0.0_wp) cycle
      do m = 1, size(model%analysis%materials)
        if (.not. may_touch(m, place_named(model%analysis%surfaces, model%analysis%contacts(i)%surface))) cycle
        associate (material => model%analysis%materials(m), where => model%analysis%contacts(i)%where)
          if (.not. has_strength(material)) call add_diagnostic(diagnostics, where, '*CONTACT', 'INTERFACE takes a '// &
            "share of c and phi of *MOHR COULOMB, which material '"//material%name//"' does not have: give "// &
            'FRICTION ANGLE and ADHESION')
          ! Contact is formulated in total stresses of undrained soil.
          if (material%undrained%given .and. material%friction_angle > 0.0_wp) call add_diagnostic(diagnostics, where, &
            '*CONTACT', "INTERFACE requires s_u of undrained material '"//material%name//"', which is a result "// &
            'with a friction angle: give ADHESION, or c = s_u and phi = 0')
        end associate
      end do
    end do

  contains

    !> Returns whether a body has a material in some phase: the one whose outline is a surface, otherwise any.
    pure logical function may_touch(m, surface)
      integer, intent(in) :: m, surface
      integer :: b, p, number(size(model%analysis%bodies))

      b = 0
      if (surface > 0) then
        if (allocated(model%analysis%surfaces(surface)%body)) b = body_number(model%analysis, &
          model%analysis%surfaces(surface)%body)
      end if
      may_touch = .false.
      do p = 0, size(model%analysis%phases)
        number = body_materials(model%analysis, p)
        if (b > 0) number = number(b)
        may_touch = may_touch .or. any(number == m)
      end do
    end function may_touch
  end subroutine check_interfaces

  !> Returns whether a material has the Mohr-Coulomb strength.
  pure logical function has_strength(material)
    type(material_type), intent(in) :: material

    has_strength = material%mohr_coulomb .and. .not. (material%user%given .or. material%own_law .or. &
      allocated(material%soil_law) .or. follows_stress(material%strength_profile))
  end function has_strength
end module qsmpm_rigid_bodies
