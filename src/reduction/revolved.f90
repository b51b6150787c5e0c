!> Reduction of a 3D scene of polyhedra that are figures of revolution about a vertical axis to an axisymmetric model.
!>
!> The checks: every body is a figure of revolution about one axis on grid lines (`qsmpm_revolved_profile`). A side of
!> the grid through the axis is fixed along its normal in every phase, so that the grid contains a whole, half or
!> quarter of the figure. All other constraints and loads depend on height only and are equal along x and z. The other
!> sides are out of reach: the plane grid ends at the nearest of them, and a point that reaches it ends the run. The
!> discrete equations differ from those of the bricks; both approximate the same problem.
module qsmpm_revolved
  use qsmpm_kinds, only: wp, pi
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: three_dimensional, axisymmetric
  use qsmpm_body_description, only: body_type, body_polyhedron, body_polygon
  use qsmpm_history_description, only: quantity_stress, quantity_strain, quantity_reaction, quantity_position
  use qsmpm_load_description, only: fixity_type, carrier_points
  use qsmpm_mesh_description, only: select_outline, select_plane, select_list, mesh_grid
  use qsmpm_method_description, only: basis_fem
  use qsmpm_history_quantities, only: is_taken_at, at_rigid_body
  use qsmpm_error, only: error_type
  use qsmpm_stl_reader, only: read_stl
  use qsmpm_reduction, only: reduction_type, reduce_revolved, begin_reduction
  use qsmpm_revolved_profile, only: find_axis, find_profile
  use qsmpm_rigid_symmetry, only: require_rigid_round, flatten_rigid_bodies, reduce_rigid_history
  use qsmpm_loaded_surfaces, only: drop_unused, require_level_water
  use qsmpm_examined_scene, only: examined_type, card, place_text, refuse, refuse_mesh, require_local_histories, &
    members_type, covers_axis, representatives, node_state, keep_supports
  implicit none
  private

  public :: revolved_solid_type, require_revolved, make_revolved

  !> Relative round-off of the coordinates of an STL file.
  real(wp), parameter :: single_share = 1.0e-5_wp

  !> Name of the set of the axis, which a deck cannot define without quotes.
  character(len=*), parameter :: axis_name = '=axis'

  !> Data found by the check.
  type :: revolved_solid_type
    !> x and z of the axis, largest radius of the grid, and the first and last angle of the sector.
    real(wp) :: centre(2) = 0.0_wp
    real(wp) :: radius = 0.0_wp
    !> Largest radius of each body's corners (bodies).
    real(wp), allocatable :: widest(:)
    real(wp) :: sector(2) = 0.0_wp
    !> The grid begins at the axis along x, and along z.
    logical :: cut(2) = .false.
    !> Half section of each body as a polygon.
    type(body_type), allocatable :: bodies(:)
  end type revolved_solid_type

contains

  !> Checks that a scene is a figure of revolution.
  subroutine require_revolved(scene, solid)
    type(examined_type), intent(inout) :: scene
    type(revolved_solid_type), intent(out) :: solid

    if (scene%model /= three_dimensional) then
      call refuse(scene, 'the scene is plane')
    else if (scene%mesh%kind /= mesh_grid) then
      call refuse_mesh(scene)
    else if (any(scene%bodies%kind /= body_polyhedron)) then
      call refuse(scene, 'not all bodies are polyhedra')
    else if (index(scene%mesh%element, 'HEX') /= 1 .or. scene%mesh%perturbation > 0.0_wp) then
      call refuse(scene, '*GRID'//place_text(scene%mesh%where)//' is not of regular bricks')
    else if (scene%method%basis == basis_fem) then
      call refuse(scene, 'a carried mesh must follow the bricks')
    end if
    if (allocated(scene%reason)) return
    call read_sections(scene, solid)
    if (allocated(scene%reason)) return
    call require_axis(scene, solid)
    call require_sets(scene, solid)
    call require_loads(scene, solid)
    call require_contacts(scene, solid)
    call require_rigid_round(scene, solid%centre, solid%cut)
    call require_level_water(scene)
    call require_histories(scene, solid)
  end subroutine require_revolved

  !> Determines the half sections of all bodies about one axis.
  subroutine read_sections(scene, solid)
    type(examined_type), intent(inout) :: scene
    !> Receives the axis and the bodies.
    type(revolved_solid_type), intent(inout) :: solid
    type(error_type), allocatable :: error
    real(wp), allocatable :: facets(:, :, :), profile(:, :)
    character(len=:), allocatable :: problem
    integer :: b

    solid%bodies = scene%bodies
    allocate (solid%widest(size(scene%bodies)))
    do b = 1, size(scene%bodies)
      associate (body => solid%bodies(b))
        call read_stl(body%file, facets, error)
        if (allocated(error)) then
          call refuse(scene, error%message)
          return
        end if
        if (b == 1) solid%centre = on_lines(scene, find_axis(facets), maxval(abs(facets)))
        solid%widest(b) = sqrt(maxval((facets(1, :, :) - solid%centre(1))**2 &
          + (facets(3, :, :) - solid%centre(2))**2))
        call find_profile(facets, solid%centre, profile, problem)
        if (len(problem) > 0) then
          call refuse(scene, card('*BODY', body%name, body%where)//' is no figure of revolution: '//problem)
          return
        end if
        body%kind = body_polygon
        call move_alloc(profile, body%polygon)
        deallocate (body%file)
      end associate
    end do
  end subroutine read_sections

  !> Returns the grid lines nearest to an axis, if they agree with it within the accuracy of the file.
  pure function on_lines(scene, centre, size_of_file) result(place)
    type(examined_type), intent(in) :: scene
    !> x and z of the axis, and the largest coordinate of its file.
    real(wp), intent(in) :: centre(2), size_of_file
    real(wp) :: place(2)
    integer :: i, k

    place = centre
    do i = 1, 2
      associate (lines => scene%mesh%axes(2*i - 1)%lines)
        k = minloc(abs(lines - centre(i)), dim=1)
        if (abs(lines(k) - centre(i)) <= single_share*size_of_file) place(i) = lines(k)
      end associate
    end do
  end function on_lines

  !> Checks that the axis is on grid lines, that sides through it are fixed along their normal, and that the grid is
  !> wide enough.
  pure subroutine require_axis(scene, solid)
    type(examined_type), intent(inout) :: scene
    !> Receives the sector and the radius of the grid.
    type(revolved_solid_type), intent(inout) :: solid
    real(wp) :: tolerance
    integer :: i, b

    tolerance = scene%nothing
    solid%radius = huge(1.0_wp)
    do i = 1, 2
      associate (lines => scene%mesh%axes(2*i - 1)%lines, c => solid%centre(i))
        if (minval(abs(lines - c)) > tolerance) &
          call refuse(scene, 'the axis lies on no line of *GRID'//place_text(scene%mesh%where))
        solid%cut(i) = abs(lines(1) - c) <= tolerance
        if (abs(lines(size(lines)) - c) <= tolerance) &
          call refuse(scene, 'the axis lies on the far side of *GRID'//place_text(scene%mesh%where))
        solid%radius = min(solid%radius, lines(size(lines)) - c)
        if (.not. solid%cut(i)) solid%radius = min(solid%radius, c - lines(1))
        if (solid%cut(i)) call require_cut(scene, 2*i - 1)
      end associate
    end do
    do b = 1, size(solid%bodies)
      if (solid%widest(b) >= (1.0_wp - single_share)*solid%radius) call refuse(scene, card('*BODY', &
        solid%bodies(b)%name, solid%bodies(b)%where)//' reaches the sides of the grid')
    end do
    solid%sector = [-pi, pi]
    if (solid%cut(1)) solid%sector = [-0.5_wp*pi, 0.5_wp*pi]
    if (solid%cut(2)) solid%sector(1) = 0.0_wp
  end subroutine require_axis

  !> Checks that the side of the grid through the axis is fixed along its normal in every phase.
  pure subroutine require_cut(scene, axis)
    type(examined_type), intent(inout) :: scene
    !> 1 or 3.
    integer, intent(in) :: axis
    integer, allocatable :: across(:), up(:)
    integer :: node(3), p, i, k
    logical :: fixed(3)
    real(wp) :: value(3)

    call representatives(scene%members, 4 - axis, .false., across)
    call representatives(scene%members, 2, .false., up)
    node(axis) = 1
    do p = 1, size(scene%phases)
      do i = 1, size(across)
        do k = 1, size(up)
          node(4 - axis) = across(i)
          node(2) = up(k)
          call node_state(scene, scene%members, node, p, fixed, value)
          if (.not. fixed(axis)) call refuse(scene, card('a side through the axis is not held in phase', &
            scene%phases(p)%name, scene%phases(p)%where))
        end do
      end do
    end do
  end subroutine require_cut

  !> Checks that sets that constrain the figure depend on height only, and that those on sides fix their normal.
  pure subroutine require_sets(scene, solid)
    type(examined_type), intent(inout) :: scene
    type(revolved_solid_type), intent(in) :: solid
    logical :: along
    integer :: p, i

    do p = 1, size(scene%phases)
      do i = 1, size(scene%phases(p)%fixities)
        associate (fixity => scene%phases(p)%fixities(i))
          if (.not. fixity_is_round(scene, solid, fixity)) &
            call refuse(scene, card('*FIX of', fixity%set, fixity%where)//' is not the same all around the axis')
        end associate
      end do
      do i = 1, size(scene%phases(p)%prescriptions)
        associate (prescription => scene%phases(p)%prescriptions(i))
          if (prescription%component /= 2 .or. .not. is_level(scene%members, place_named(scene%node_sets, &
            prescription%set))) call refuse(scene, card('*PRESCRIBE of', prescription%set, prescription%where)// &
            ' is not the same all around the axis')
        end associate
      end do
    end do
    if (.not. scene%moving_mesh%active) return
    along = scene%moving_mesh%axis == 2
    if (along .and. .not. scene%moving_mesh%by_body) &
      along = is_level(scene%members, place_named(scene%node_sets, scene%moving_mesh%set))
    if (.not. along) &
      call refuse(scene, '*MOVING MESH'//place_text(scene%moving_mesh%where)//' does not go along the axis')
  end subroutine require_sets

  !> Checks whether a set depends on height only.
  pure logical function is_level(members, set)
    type(members_type), intent(in) :: members
    !> Number of the set.
    integer, intent(in) :: set

    is_level = covers_axis(members, set, 1) .and. covers_axis(members, set, 3)
  end function is_level

  !> Checks whether a fixity is axisymmetric: of a horizontal set, of a side through the axis along its normal, or of a
  !> side out of reach.
  pure logical function fixity_is_round(scene, solid, fixity) result(round)
    type(examined_type), intent(in) :: scene
    type(revolved_solid_type), intent(in) :: solid
    type(fixity_type), intent(in) :: fixity
    integer :: s, i

    s = place_named(scene%node_sets, fixity%set)
    associate (set => scene%node_sets(s))
      round = set%selection /= select_list .and. is_level(scene%members, s) .and. &
        (fixity%fixed(1) .eqv. fixity%fixed(3))
      if (round .or. set%selection /= select_plane .or. set%axis == 2) return
      i = (set%axis + 1)/2
      if (abs(set%box(set%axis, 1) - solid%centre(i)) <= scene%nothing) then
        round = solid%cut(i) .and. fixity%fixed(set%axis) .and. count(fixity%fixed) == 1
      else
        round = is_outer_side(scene%members, s, set%axis)
      end if
    end associate
  end function fixity_is_round

  !> Checks whether a set is a side of the grid.
  pure logical function is_outer_side(members, set, axis) result(yes)
    type(members_type), intent(in) :: members
    !> Number of the set, and the axis normal to it.
    integer, intent(in) :: set, axis

    associate (holds => members%axis(axis)%holds(:, set))
      yes = count(holds) == 1 .and. (holds(1) .or. holds(size(holds)))
    end associate
  end function is_outer_side

  !> Checks that loads act along the axis on whole outlines, and supports on horizontal parts of outlines.
  pure subroutine require_loads(scene, solid)
    type(examined_type), intent(inout) :: scene
    type(revolved_solid_type), intent(in) :: solid
    integer :: p, i

    do p = 1, size(scene%phases)
      associate (phase => scene%phases(p))
        if (phase%gravity%given .and. any(abs(phase%gravity%vector([1, 3])) > 0.0_wp)) &
          call refuse(scene, card('*GRAVITY of phase', phase%name, phase%where)//' does not go along the axis')
        do i = 1, size(phase%tractions)
          associate (load => phase%tractions(i))
            if (any(abs(load%vector([1, 3])) > 0.0_wp) .or. load%carrier == carrier_points .or. &
              .not. surface_is_round(scene, solid, load%surface, .false.)) call refuse(scene, card('the load on', &
              load%surface, load%where)//' is not the same all around the axis')
          end associate
        end do
        do i = 1, size(phase%supports)
          if (.not. surface_is_round(scene, solid, phase%supports(i)%surface, .true.)) &
            call refuse(scene, card('*SUPPORT of', phase%supports(i)%surface, phase%supports(i)%where)// &
            ' is not the same all around the axis')
        end do
      end associate
    end do
  end subroutine require_loads

  !> Checks that surfaces in contact with rigid bodies are axisymmetric.
  pure subroutine require_contacts(scene, solid)
    type(examined_type), intent(inout) :: scene
    type(revolved_solid_type), intent(in) :: solid
    integer :: i

    if (.not. allocated(scene%contacts)) return
    do i = 1, size(scene%contacts)
      if (.not. surface_is_round(scene, solid, scene%contacts(i)%surface, .false.)) &
        call refuse(scene, card('*CONTACT of', scene%contacts(i)%body, scene%contacts(i)%where)// &
        ' is not the same all around the axis')
    end do
  end subroutine require_contacts

  !> Checks whether a surface is an outline, or the part of it in a box wider than the figure; if required a horizontal
  !> one.
  pure logical function surface_is_round(scene, solid, name, level) result(round)
    type(examined_type), intent(in) :: scene
    type(revolved_solid_type), intent(in) :: solid
    !> Name of the surface.
    character(len=*), intent(in) :: name
    !> The box must be flat along the axis.
    logical, intent(in) :: level
    real(wp) :: widest
    integer :: i

    associate (surface => scene%surfaces(place_named(scene%surfaces, name)))
      round = surface%selection == select_outline .and. (surface%boxed .or. .not. level)
      if (.not. round .or. .not. surface%boxed) return
      widest = maxval(solid%widest)
      round = round .and. all([(surface%box(2*i - 1, 2) >= solid%centre(i) + widest .and. surface%box(2*i - 1, 1) &
        <= solid%centre(i) - merge(0.0_wp, widest, solid%cut(i)), i=1, 2)])
      if (level) round = round .and. surface%box(2, 2) - surface%box(2, 1) <= scene%nothing
    end associate
  end function surface_is_round

  !> Checks that histories are within reach, and that stresses are those at places where x or z is the radial direction.
  pure subroutine require_histories(scene, solid)
    type(examined_type), intent(inout) :: scene
    type(revolved_solid_type), intent(in) :: solid
    real(wp) :: from(2)
    logical :: good
    integer :: i

    call require_local_histories(scene)
    if (allocated(scene%reason)) return
    do i = 1, size(scene%histories)
      associate (history => scene%histories(i))
        if (is_taken_at(history%quantity, at_rigid_body)) cycle
        from = history%at([1, 3]) - solid%centre
        select case (history%quantity)
        case (quantity_reaction)
          good = is_level(scene%members, place_named(scene%node_sets, history%set)) .and. (history%component == 2 .or. &
            .not. any(solid%cut))
        case (quantity_stress, quantity_strain)
          good = history%component == 2 .or. any(abs(from) <= scene%nothing)
        case default
          good = .true.
        end select
        if (history%quantity /= quantity_reaction) &
          good = good .and. norm2(from) <= solid%radius .and. .not. any(solid%cut .and. from < -scene%nothing)
        if (.not. good) &
          call refuse(scene, card('*HISTORY', history%name, history%where)//' cannot be told from radius and height')
      end associate
    end do
  end subroutine require_histories

  !> Makes the axisymmetric model of a figure of revolution and its expansion.
  pure subroutine make_revolved(scene, solid, step)
    !> The scene; on return the model.
    type(examined_type), intent(inout) :: scene
    !> Data found by the check.
    type(revolved_solid_type), intent(in) :: solid
    !> Expansion step.
    type(reduction_type), intent(out) :: step
    integer :: s, b, p

    call begin_reduction(scene, reduce_revolved, 0, step)
    step%factor = solid%sector(2) - solid%sector(1)
    step%centre = solid%centre
    step%sector = solid%sector
    call round_histories(scene, solid, step)
    call flatten_rigid_bodies(scene, [1, 3], step%factor)
    do s = 1, size(scene%node_sets)
      scene%node_sets(s)%box(1, :) = [-solid%radius, 2.0_wp*solid%radius]
      scene%node_sets(s)%box(3, :) = 0.0_wp
    end do
    call keep_supports(scene, [(is_level(scene%members, s), s=1, size(scene%node_sets))], 1, [0.0_wp], [axis_name])
    do p = 1, size(scene%phases)
      scene%phases(p)%fixities%fixed(3) = .false.
    end do
    call drop_unused(scene)
    do s = 1, size(scene%surfaces)
      scene%surfaces(s)%box(1, :) = [0.0_wp, solid%radius]
      scene%surfaces(s)%box(3, :) = 0.0_wp
    end do
    scene%bodies = solid%bodies
    do b = 1, size(scene%bodies)
      associate (n => scene%bodies(b)%points_per_element)
        if (n > 0) n = nint(real(n, wp)**(1.0_wp/3.0_wp))**2
      end associate
    end do
    call radial_lines(scene, solid)
    scene%mesh%element = trim(merge('QUAD4', 'QUAD8', scene%mesh%element == 'HEX8'))
    scene%model = axisymmetric
  end subroutine make_revolved

  !> Determines the lines along the radius: those along x beyond the axis, up to the nearest side.
  pure subroutine radial_lines(scene, solid)
    !> The scene; on return with its grid in radius and height.
    type(examined_type), intent(inout) :: scene
    type(revolved_solid_type), intent(in) :: solid
    real(wp) :: lines(size(scene%mesh%axes(1)%lines)), tolerance
    integer :: i, n

    tolerance = scene%nothing
    n = 0
    do i = 1, size(lines)
      associate (radius => scene%mesh%axes(1)%lines(i) - solid%centre(1))
        if (radius < -tolerance .or. radius > solid%radius + tolerance) cycle
        n = n + 1
        lines(n) = merge(0.0_wp, radius, n == 1)
      end associate
    end do
    deallocate (scene%mesh%axes(1)%lines, scene%mesh%axes(3)%lines)
    allocate (scene%mesh%axes(1)%lines(n), source=lines(:n))
  end subroutine radial_lines

  !> Converts histories to radius and height.
  pure subroutine round_histories(scene, solid, step)
    type(examined_type), intent(inout) :: scene
    type(revolved_solid_type), intent(in) :: solid
    !> Receives the expansion.
    type(reduction_type), intent(inout) :: step
    real(wp) :: from(2), along(2), radius
    integer :: i

    do i = 1, size(scene%histories)
      associate (history => scene%histories(i))
        if (history%quantity == quantity_reaction) then
          step%history_factor(i) = merge(step%factor, 0.0_wp, history%component == 2)
          if (history%component /= 2) history%component = 1
          cycle
        end if
        if (is_taken_at(history%quantity, at_rigid_body)) then
          call reduce_rigid_history(history, [1, 3], step%factor, step%history_factor(i))
          cycle
        end if
        from = history%at([1, 3]) - solid%centre
        radius = norm2(from)
        along = 0.0_wp
        if (radius > 0.0_wp) along = from/radius
        history%at = [radius, history%at(2), 0.0_wp]
        if (any(history%quantity == [quantity_stress, quantity_strain])) then
          call round_stress(history%component, abs(from(2)) <= scene%nothing, along, step%history_factor(i))
        else if (history%component /= 2) then
          step%history_factor(i) = along((history%component + 1)/2)
          if (history%quantity == quantity_position) step%history_offset(i) = solid%centre((history%component + 1)/2)
          history%component = 1
        end if
      end associate
    end do
  end subroutine round_histories

  !> Converts a stress component on the x or z axis to those of radius, height and hoop direction.
  pure subroutine round_stress(component, on_x, along, factor)
    !> 1 to 6 in, 1 to 4 out.
    integer, intent(inout) :: component
    !> The place is on the x axis, otherwise on the z axis.
    logical, intent(in) :: on_x
    !> Radial direction: x and z.
    real(wp), intent(in) :: along(2)
    !> Sign of the component, 0 if it vanishes.
    real(wp), intent(out) :: factor
    integer, parameter :: by_x(6) = [1, 2, 3, 4, 0, 0], by_z(6) = [3, 2, 1, 0, 0, 4]
    integer :: found

    found = merge(by_x(component), by_z(component), on_x)
    factor = 1.0_wp
    if (found == 4) factor = merge(along(1), along(2), on_x)
    if (found == 0) factor = 0.0_wp
    component = max(1, found)
  end subroutine round_stress
end module qsmpm_revolved
