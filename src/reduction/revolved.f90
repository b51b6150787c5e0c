!> A 3D scene of polyhedra turned about a vertical axis as an axisymmetric model.
!>
!> What is proved: every body is a figure of revolution about one axis on lines of the grid
!> (`qsmpm_revolved_profile`); a side of the grid through the axis is held along its normal in every
!> phase, so that the grid holds a whole, half or quarter of the figure; everything else that is held,
!> moved or loaded depends on height only and is alike along x and z; the other sides are out of
!> reach: the plane grid ends at the nearest of them, and a point that gets there ends the run. The
!> equations are not those of the bricks, only what they approximate is the same.
module qsmpm_revolved
  use qsmpm_kinds, only: wp, pi
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_body_description, only: body_type, body_polyhedron, body_polygon
  use qsmpm_history_description, only: quantity_stress, quantity_strain, quantity_reaction
  use qsmpm_load_description, only: fixity_type, carrier_points
  use qsmpm_mesh_description, only: select_outline, select_plane, select_list, mesh_grid
  use qsmpm_method_description, only: basis_fem
  use qsmpm_history_quantities, only: is_taken_at, at_rigid_body
  use qsmpm_error, only: error_type
  use qsmpm_stl_reader, only: read_stl
  use qsmpm_reduction, only: refuse, refuse_mesh, place_text, require_local_histories
  use qsmpm_set_members, only: members_type, find_members, covers_axis, representatives, node_state, scene_tolerance
  use qsmpm_revolved_profile, only: find_axis, find_profile
  use qsmpm_rigid_symmetry, only: require_rigid_round
  use qsmpm_water_symmetry, only: require_level_water
  implicit none
  private

  public :: revolved_solid_type, require_revolved, is_level

  !> Coordinates of an STL file are rounded to this share of their size.
  real(wp), parameter :: single_share = 1.0e-5_wp

  !> What a proof has found.
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

  !> Prove that a scene is a figure of revolution.
  subroutine require_revolved(analysis, solid, reason)
    type(analysis_type), intent(in) :: analysis
    type(revolved_solid_type), intent(out) :: solid
    !> Why not; unallocated when proved.
    character(len=:), allocatable, intent(out) :: reason
    type(members_type) :: members

    if (analysis%model /= three_dimensional) then
      call refuse(reason, 'the scene is plane')
    else if (analysis%mesh%kind /= mesh_grid) then
      call refuse_mesh(analysis, reason)
    else if (any(analysis%bodies%kind /= body_polyhedron)) then
      call refuse(reason, 'not all bodies are polyhedra')
    else if (index(analysis%mesh%element, 'HEX') /= 1 .or. analysis%mesh%perturbation > 0.0_wp) then
      call refuse(reason, '*GRID'//place_text(analysis%mesh%where)//' is not of regular bricks')
    else if (analysis%method%basis == basis_fem) then
      call refuse(reason, 'a carried mesh must follow the bricks')
    end if
    if (allocated(reason)) return
    call read_sections(analysis, solid, reason)
    if (allocated(reason)) return
    call find_members(analysis, members)
    call require_axis(analysis, members, solid, reason)
    call require_sets(analysis, members, solid, reason)
    call require_loads(analysis, solid, reason)
    call require_contacts(analysis, solid, reason)
    call require_rigid_round(analysis, solid%centre, solid%cut, reason)
    call require_level_water(analysis, reason)
    call require_histories(analysis, members, solid, reason)
  end subroutine require_revolved

  !> Half sections of all bodies about one axis.
  subroutine read_sections(analysis, solid, reason)
    type(analysis_type), intent(in) :: analysis
    !> Gets the axis and the bodies.
    type(revolved_solid_type), intent(inout) :: solid
    character(len=:), allocatable, intent(inout) :: reason
    type(error_type), allocatable :: error
    real(wp), allocatable :: facets(:, :, :), profile(:, :)
    character(len=:), allocatable :: problem
    integer :: b

    solid%bodies = analysis%bodies
    allocate (solid%widest(size(analysis%bodies)))
    do b = 1, size(analysis%bodies)
      associate (body => solid%bodies(b))
        call read_stl(body%file, facets, error)
        if (allocated(error)) then
          call refuse(reason, error%message)
          return
        end if
        if (b == 1) solid%centre = on_lines(analysis, find_axis(facets), maxval(abs(facets)))
        solid%widest(b) = sqrt(maxval((facets(1, :, :) - solid%centre(1))**2 &
          + (facets(3, :, :) - solid%centre(2))**2))
        call find_profile(facets, solid%centre, profile, problem)
        if (len(problem) > 0) then
          call refuse(reason, "*BODY '"//body%name//"'"//place_text(body%where)//&
            ' is no figure of revolution: '//problem)
          return
        end if
        body%kind = body_polygon
        call move_alloc(profile, body%polygon)
        deallocate (body%file)
      end associate
    end do
  end subroutine read_sections

  !> The grid lines nearest to an axis, if they are as near as the file can tell.
  pure function on_lines(analysis, centre, size_of_file) result(place)
    type(analysis_type), intent(in) :: analysis
    !> x and z of the axis, and the largest coordinate of its file.
    real(wp), intent(in) :: centre(2), size_of_file
    real(wp) :: place(2)
    integer :: i, k

    place = centre
    do i = 1, 2
      associate (lines => analysis%mesh%axes(2*i - 1)%lines)
        k = minloc(abs(lines - centre(i)), dim=1)
        if (abs(lines(k) - centre(i)) <= single_share*size_of_file) place(i) = lines(k)
      end associate
    end do
  end function on_lines

  !> The axis lies on grid lines; sides through it are held along their normal; the grid is wide enough.
  pure subroutine require_axis(analysis, members, solid, reason)
    type(analysis_type), intent(in) :: analysis
    type(members_type), intent(in) :: members
    !> Gets the sector and the radius of the grid.
    type(revolved_solid_type), intent(inout) :: solid
    character(len=:), allocatable, intent(inout) :: reason
    real(wp) :: tolerance
    integer :: i, b

    tolerance = scene_tolerance(analysis)
    solid%radius = huge(1.0_wp)
    do i = 1, 2
      associate (lines => analysis%mesh%axes(2*i - 1)%lines, c => solid%centre(i))
        if (minval(abs(lines - c)) > tolerance) call refuse(reason, 'the axis lies on no line of *GRID'// &
          place_text(analysis%mesh%where))
        solid%cut(i) = abs(lines(1) - c) <= tolerance
        if (abs(lines(size(lines)) - c) <= tolerance) call refuse(reason, &
          'the axis lies on the far side of *GRID'//place_text(analysis%mesh%where))
        solid%radius = min(solid%radius, lines(size(lines)) - c)
        if (.not. solid%cut(i)) solid%radius = min(solid%radius, c - lines(1))
        if (solid%cut(i)) call require_cut(analysis, members, 2*i - 1, reason)
      end associate
    end do
    do b = 1, size(solid%bodies)
      if (solid%widest(b) >= (1.0_wp - single_share)*solid%radius) call refuse(reason, "*BODY '"// &
        solid%bodies(b)%name//"'"//place_text(solid%bodies(b)%where)//' reaches the sides of the grid')
    end do
    solid%sector = [-pi, pi]
    if (solid%cut(1)) solid%sector = [-0.5_wp*pi, 0.5_wp*pi]
    if (solid%cut(2)) solid%sector(1) = 0.0_wp
  end subroutine require_axis

  !> The side of the grid through the axis is held along its normal in every phase.
  pure subroutine require_cut(analysis, members, axis, reason)
    type(analysis_type), intent(in) :: analysis
    type(members_type), intent(in) :: members
    !> 1 or 3.
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    integer, allocatable :: across(:), up(:)
    integer :: node(3), p, i, k
    logical :: fixed(3)
    real(wp) :: value(3)

    call representatives(members, 4 - axis, .false., across)
    call representatives(members, 2, .false., up)
    node(axis) = 1
    do p = 1, size(analysis%phases)
      do i = 1, size(across)
        do k = 1, size(up)
          node(4 - axis) = across(i)
          node(2) = up(k)
          call node_state(analysis, members, node, p, fixed, value)
          if (.not. fixed(axis)) call refuse(reason, "a side through the axis is not held in phase '"// &
            analysis%phases(p)%name//"'"//place_text(analysis%phases(p)%where))
        end do
      end do
    end do
  end subroutine require_cut

  !> Sets that hold or move the figure depend on height only; those on sides hold along their normal.
  pure subroutine require_sets(analysis, members, solid, reason)
    type(analysis_type), intent(in) :: analysis
    type(members_type), intent(in) :: members
    type(revolved_solid_type), intent(in) :: solid
    character(len=:), allocatable, intent(inout) :: reason
    logical :: along
    integer :: p, i

    do p = 1, size(analysis%phases)
      do i = 1, size(analysis%phases(p)%fixities)
        associate (fixity => analysis%phases(p)%fixities(i))
          if (.not. fixity_is_round(analysis, members, solid, fixity)) call refuse(reason, &
            "*FIX of '"//fixity%set//"'"//place_text(fixity%where)//' is not the same all around the axis')
        end associate
      end do
      do i = 1, size(analysis%phases(p)%prescriptions)
        associate (prescription => analysis%phases(p)%prescriptions(i))
          if (prescription%component /= 2 .or. .not. is_level(members, place_named(analysis%node_sets, &
            prescription%set))) call refuse(reason, "*PRESCRIBE of '"//prescription%set//"'"// &
            place_text(prescription%where)//' is not the same all around the axis')
        end associate
      end do
    end do
    if (.not. analysis%moving_mesh%active) return
    along = analysis%moving_mesh%axis == 2
    if (along .and. .not. analysis%moving_mesh%by_body) along = is_level(members, place_named(analysis%node_sets, &
      analysis%moving_mesh%set))
    if (.not. along) &
      call refuse(reason, '*MOVING MESH'//place_text(analysis%moving_mesh%where)//' does not go along the axis')
  end subroutine require_sets

  !> Whether a set depends on height only.
  pure logical function is_level(members, set)
    type(members_type), intent(in) :: members
    !> Number of the set.
    integer, intent(in) :: set

    is_level = covers_axis(members, set, 1) .and. covers_axis(members, set, 3)
  end function is_level

  !> Whether a fixity is alike in all directions: of a level set, of a side through the axis along its
  !> normal, or of a side out of reach.
  pure logical function fixity_is_round(analysis, members, solid, fixity) result(round)
    type(analysis_type), intent(in) :: analysis
    type(members_type), intent(in) :: members
    type(revolved_solid_type), intent(in) :: solid
    type(fixity_type), intent(in) :: fixity
    integer :: s, i

    s = place_named(analysis%node_sets, fixity%set)
    associate (set => analysis%node_sets(s))
      round = set%selection /= select_list .and. is_level(members, s) .and. (fixity%fixed(1) .eqv. fixity%fixed(3))
      if (round .or. set%selection /= select_plane .or. set%axis == 2) return
      i = (set%axis + 1)/2
      if (abs(set%box(set%axis, 1) - solid%centre(i)) <= scene_tolerance(analysis)) then
        round = solid%cut(i) .and. fixity%fixed(set%axis) .and. count(fixity%fixed) == 1
      else
        round = is_outer_side(members, s, set%axis)
      end if
    end associate
  end function fixity_is_round

  !> Whether a set is a side of the grid.
  pure logical function is_outer_side(members, set, axis) result(yes)
    type(members_type), intent(in) :: members
    !> Number of the set, and the axis it lies across.
    integer, intent(in) :: set, axis

    associate (holds => members%axis(axis)%holds(:, set))
      yes = count(holds) == 1 .and. (holds(1) .or. holds(size(holds)))
    end associate
  end function is_outer_side

  !> Loads go along the axis and act on outlines all around it; supports on level parts of outlines.
  pure subroutine require_loads(analysis, solid, reason)
    type(analysis_type), intent(in) :: analysis
    type(revolved_solid_type), intent(in) :: solid
    character(len=:), allocatable, intent(inout) :: reason
    integer :: p, i

    do p = 1, size(analysis%phases)
      associate (phase => analysis%phases(p))
        if (phase%gravity%given .and. any(abs(phase%gravity%vector([1, 3])) > 0.0_wp)) call refuse(reason, &
          "*GRAVITY of phase '"//phase%name//"'"//place_text(phase%where)//' does not go along the axis')
        do i = 1, size(phase%tractions)
          associate (load => phase%tractions(i))
            if (any(abs(load%vector([1, 3])) > 0.0_wp) .or. load%carrier == carrier_points .or. &
              .not. surface_is_round(analysis, solid, load%surface, .false.)) call refuse(reason, &
              "the load on '"//load%surface//"'"//place_text(load%where)//' is not the same all around the axis')
          end associate
        end do
        do i = 1, size(phase%supports)
          if (.not. surface_is_round(analysis, solid, phase%supports(i)%surface, .true.)) call refuse(reason, &
            "*SUPPORT of '"//phase%supports(i)%surface//"'"//place_text(phase%supports(i)%where)// &
            ' is not the same all around the axis')
        end do
      end associate
    end do
  end subroutine require_loads

  !> Surfaces that touch rigid bodies are the same all around the axis.
  pure subroutine require_contacts(analysis, solid, reason)
    type(analysis_type), intent(in) :: analysis
    type(revolved_solid_type), intent(in) :: solid
    character(len=:), allocatable, intent(inout) :: reason
    integer :: i

    if (.not. allocated(analysis%contacts)) return
    do i = 1, size(analysis%contacts)
      if (.not. surface_is_round(analysis, solid, analysis%contacts(i)%surface, .false.)) call refuse(reason, &
        "*CONTACT of '"//analysis%contacts(i)%body//"'"//place_text(analysis%contacts(i)%where)// &
        ' is not the same all around the axis')
    end do
  end subroutine require_contacts

  !> Whether a surface is an outline, or the part of it in a box wider than the figure; a level one where
  !> it is wanted.
  pure logical function surface_is_round(analysis, solid, name, level) result(round)
    type(analysis_type), intent(in) :: analysis
    type(revolved_solid_type), intent(in) :: solid
    !> Name of the surface.
    character(len=*), intent(in) :: name
    !> The box must be flat along the axis.
    logical, intent(in) :: level
    real(wp) :: widest
    integer :: i

    associate (surface => analysis%surfaces(place_named(analysis%surfaces, name)))
      round = surface%selection == select_outline .and. (surface%boxed .or. .not. level)
      if (.not. round .or. .not. surface%boxed) return
      widest = maxval(solid%widest)
      round = round .and. all([(surface%box(2*i - 1, 2) >= solid%centre(i) + widest .and. surface%box(2*i - 1, 1) &
        <= solid%centre(i) - merge(0.0_wp, widest, solid%cut(i)), i=1, 2)])
      if (level) round = round .and. surface%box(2, 2) - surface%box(2, 1) <= scene_tolerance(analysis)
    end associate
  end function surface_is_round

  !> Histories are within reach; stresses are read where the axes are those of radius and ring.
  pure subroutine require_histories(analysis, members, solid, reason)
    type(analysis_type), intent(in) :: analysis
    type(members_type), intent(in) :: members
    type(revolved_solid_type), intent(in) :: solid
    character(len=:), allocatable, intent(inout) :: reason
    real(wp) :: from(2)
    logical :: good
    integer :: i

    call require_local_histories(analysis, reason)
    if (allocated(reason)) return
    do i = 1, size(analysis%histories)
      associate (history => analysis%histories(i))
        if (is_taken_at(history%quantity, at_rigid_body)) cycle
        from = history%at([1, 3]) - solid%centre
        select case (history%quantity)
        case (quantity_reaction)
          good = is_level(members, place_named(analysis%node_sets, history%set)) .and. &
            (history%component == 2 .or. .not. any(solid%cut))
        case (quantity_stress, quantity_strain)
          good = history%component == 2 .or. any(abs(from) <= scene_tolerance(analysis))
        case default
          good = .true.
        end select
        if (history%quantity /= quantity_reaction) good = good .and. norm2(from) <= solid%radius &
          .and. .not. any(solid%cut .and. from < -scene_tolerance(analysis))
        if (.not. good) call refuse(reason, "*HISTORY '"//history%name//"'"//place_text(history%where)// &
          ' cannot be told from radius and height')
      end associate
    end do
  end subroutine require_histories
end module qsmpm_revolved
