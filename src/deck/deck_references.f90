!> Checks between keywords, when the whole deck is known: required keywords, existence of names, completeness of
!> materials, and the tree of phases.
module qsmpm_deck_references
  use qsmpm_analysis, only: analysis_type
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: add_names, place_named
  use qsmpm_body_description, only: body_region, body_all, body_box, body_polygon
  use qsmpm_material_description, only: material_type, traits_of
  use qsmpm_mesh_description, only: mesh_none, mesh_file, mesh_fitted, select_outline, set_type, mesh_grid, &
    select_plane
  use qsmpm_method_description, only: kinematics_jaumann, rate_paper
  use qsmpm_phase_description, only: initial_k0, initial_keep, initial_isotropic, initial_given, phase_safety
  use qsmpm_source_line, only: source_line_type
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_phase_loads, only: acts, consolidation_of, is_loaded
  use qsmpm_phase_tree, only: has_parent, parent_of
  use qsmpm_polygon, only: polygon_area, polygon_contains
  use qsmpm_text, only: did_you_mean, string_type
  use qsmpm_messages, only: severity_error
  use qsmpm_deck_state, only: deck_state_type, check_name
  use qsmpm_deck_stages, only: check_props, check_stages
  use qsmpm_deck_controls, only: check_histories, check_stops, check_limit_compliance, check_safety
  use qsmpm_deck_materials, only: check_k0, check_softening
  use qsmpm_deck_magnitudes, only: check_magnitudes, check_strengths
  use qsmpm_deck_rigid_bodies, only: check_moves, check_contacts
  use qsmpm_deck_values_by_place, only: check_profiles, check_value_fields
  use qsmpm_keyword_table, only: axis_words
  use qsmpm_deck_water, only: check_drainage, check_water, check_undrained
  use qsmpm_deck_phases, only: check_first_times
  use qsmpm_deck_user_material, only: check_strength_constants
  use qsmpm_deck_mesh, only: check_inline_mesh
  use qsmpm_deck_point, only: check_point_deck
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_vertical, only: vertical_of
  implicit none
  private

  public :: check_references

  !> Gap that counts as closed, relative to the adjacent cell.
  real(wp), parameter :: closed = 1.0e-3_wp
  !> Cosine of the angle to its normal within which a side faces an end of the grid.
  real(wp), parameter :: across = 0.7_wp

contains

  !> Runs all checks between keywords.
  subroutine check_references(state)
    type(deck_state_type), intent(inout) :: state

    call check_point_deck(state)
    if (state%analysis%point_test%given) then
      call check_materials(state)
      call check_profiles(state)
      call check_value_fields(state)
      call check_undrained(state)
      call check_strengths(state)
      return
    end if
    call check_presence(state)
    call check_inline_mesh(state)
    call check_bodies(state)
    call check_materials(state)
    call check_softening(state)
    call check_profiles(state)
    call check_value_fields(state)
    call check_strength_constants(state)
    call check_undrained(state)
    call check_node_sets(state)
    call check_surfaces(state)
    call check_contacts(state)
    call check_moves(state)
    call check_prescriptions(state)
    call check_parents(state)
    call check_stages(state)
    call check_safety(state)
    call check_starts(state)
    call check_water(state)
    call check_first_times(state)
    call check_drainage(state)
    call check_k0(state)
    call check_limit_compliance(state)
    call check_props(state)
    call check_histories(state)
    call check_stops(state)
    if (state%messages%error_count() == 0) call check_magnitudes(state)
    if (state%messages%error_count() == 0) call check_held_ends(state)
  end subroutine check_references

  !> Checks the keywords that every deck requires.
  subroutine check_presence(state)
    type(deck_state_type), intent(inout) :: state

    if (state%in_phase) call state%messages%add(severity_error, state%phase_place, 'PHASE', &
      'the phase has no *END PHASE')
    if (.not. state%model_given) call missing('MODEL', 'the kind of model')
    if (state%analysis%mesh%kind == mesh_none) call missing('GRID', 'a mesh (*GRID, *MESH or *NODE and *ELEMENT)')
    if (allocated(state%analysis%mesh%refined) .and. all(state%analysis%mesh%kind /= [mesh_none, mesh_fitted])) &
      call state%error_from(state%analysis%mesh%where, 'REFINE', 'it requires body-fitted triangles: *GRID without '// &
      'ELEMENT (and without rigid bodies and other features that need a grid), or ELEMENT=TRI6, FIT=YES')
    if (size(state%analysis%materials) == 0) call missing('MATERIAL', 'a material')
    if (size(state%analysis%bodies) == 0) call missing('BODY', 'a body')
    if (size(state%analysis%phases) == 0) call missing('PHASE', 'a phase')

  contains

    !> Reports a keyword that is missing at the end of the deck.
    subroutine missing(keyword, what)
      !> The missing keyword; what it would define.
      character(len=*), intent(in) :: keyword, what

      call state%messages%add(severity_error, state%last, keyword, 'the deck lacks '//what)
    end subroutine missing
  end subroutine check_presence

  !> Checks materials and regions of bodies.
  subroutine check_bodies(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    do i = 1, size(state%analysis%bodies)
      associate (body => state%analysis%bodies(i))
        call check_name(state, body%material, state%analysis%materials, body%where, 'BODY', 'material')
        if (body%kind == body_region) call check_set(state, body%region, &
          state%analysis%element_sets, body%where, 'BODY', 'element set')
      end associate
    end do
  end subroutine check_bodies

  !> Checks that a set exists, unless it may still come from a mesh file.
  subroutine check_set(state, name, sets, where, keyword, what)
    type(deck_state_type), intent(inout) :: state
    character(len=*), intent(in) :: name
    type(set_type), intent(in) :: sets(:)
    type(source_line_type), intent(in) :: where
    character(len=*), intent(in) :: keyword, what

    if (state%analysis%mesh%kind /= mesh_file) call check_name(state, name, sets, where, keyword, what)
  end subroutine check_set

  !> Checks the laws of all materials; warns of one without weight under gravity, or of a profile across gravity.
  subroutine check_materials(state)
    type(deck_state_type), intent(inout) :: state
    logical :: gravity
    integer :: i

    gravity = has_gravity(state)
    do i = 1, size(state%analysis%materials)
      associate (material => state%analysis%materials(i))
        call check_law(state, material)
        call check_user_material(state, material)
        if (gravity .and. .not. material%unit_weight > 0.0_wp) call state%warn(material%where, &
          'MATERIAL', "material '"//material%name//"' has no weight, but there is gravity")
        if (gravity .and. material%strength_profile%given .and. material%strength_profile%along /= &
          vertical_of(state%analysis)) call state%warn(material%profile_where, 'STRENGTH PROFILE', "material '"// &
          material%name//"': gravity does not act along the axis of its levels: ALONG="// &
          trim(axis_words(vertical_of(state%analysis))))
      end associate
    end do
  end subroutine check_materials

  !> Checks that a user material has no other law or strength, and that *USER STATE has a *USER MATERIAL.
  subroutine check_user_material(state, material)
    type(deck_state_type), intent(inout) :: state
    type(material_type), intent(in) :: material
    type(law_description_type) :: traits

    traits = traits_of(material)
    if (material%user%given .and. material%mohr_coulomb) call state%error_from(material%where, 'MATERIAL', &
      "material '"//material%name//"' has both *MOHR COULOMB and *USER MATERIAL")
    if (material%user%given .and. allocated(material%soil_law)) call state%error_from(material%where, 'MATERIAL', &
      "material '"//material%name//"' has *USER MATERIAL beside *"//traits%keyword)
    if (allocated(material%user%start) .and. .not. material%user%given) call state%error_from(material%where, &
      'MATERIAL', "material '"//material%name//"' has *USER STATE, but no *USER MATERIAL")
  end subroutine check_user_material

  !> Checks that a material has one law, and a clay an initial stress.
  subroutine check_law(state, material)
    type(deck_state_type), intent(inout) :: state
    type(material_type), intent(in) :: material
    type(law_description_type) :: traits
    logical :: elastic

    if (material%user%given) return
    elastic = material%young > 0.0_wp .or. material%mohr_coulomb
    if (.not. allocated(material%soil_law)) then
      if (.not. material%young > 0.0_wp) call state%error_from(material%where, 'MATERIAL', "material '"// &
        material%name//"' has no *ELASTIC")
      return
    end if
    traits = traits_of(material)
    if (elastic) call state%error_from(material%where, 'MATERIAL', "material '"//material%name// &
      "' has more than one law: *"//traits%keyword//' stands for *ELASTIC and *MOHR COULOMB')
    if (state%analysis%method%kinematics == kinematics_jaumann .and. state%analysis%method%rate == rate_paper .and. &
      .not. traits%linear_elasticity) call state%error_from(material%where, 'MATERIAL', "material '"//material%name// &
      "' hardens, which *METHOD, RATE=PAPER does not support; use MIDPOINT or KINEMATICS=LOGARITHMIC")
    if (traits%vertical > 0 .and. traits%vertical /= vertical_of(state%analysis) .and. has_gravity(state)) &
      call state%error_from(material%where, 'MATERIAL', "material '"//material%name//"': gravity does not act "// &
      'along the axis that *'//traits%keyword//' takes as the vertical: ALONG='// &
      trim(axis_words(vertical_of(state%analysis))))
    if (traits%flows_in_time) call warn_of_time(state, material, traits%keyword)
    if (size(state%analysis%phases) == 0 .or. .not. traits%smallest_pressure > 0.0_wp) return
    if (state%analysis%phases(1)%initial%kind == initial_keep) call state%warn(material%where, 'MATERIAL', &
      "clay '"//material%name//"' starts without stress, at its smallest pressure: use *INITIAL, TYPE=K0")
  end subroutine check_law

  !> Warns of phases without a TIME in which a time-dependent material flows; a phase with prescribed initial stresses
  !> gets a negligible one.
  subroutine warn_of_time(state, material, keyword)
    type(deck_state_type), intent(inout) :: state
    type(material_type), intent(in) :: material
    character(len=*), intent(in) :: keyword
    !> Fraction of the unit of time that is too short for creep.
    real(wp), parameter :: at_once = 1.0e-6_wp
    integer :: p

    do p = 1, size(state%analysis%phases)
      associate (phase => state%analysis%phases(p))
        if (phase%duration_given .or. phase%kind == phase_safety) cycle
        if (phase%initial%kind /= initial_keep) then
          phase%duration = at_once
          cycle
        end if
        call state%warn(phase%where, 'PHASE', "material '"//material%name//"' has *"//keyword// &
          ', but the phase has no TIME: one unit of time is assumed')
      end associate
    end do
  end subroutine warn_of_time

  !> Checks whether any phase has gravity.
  pure logical function has_gravity(state)
    type(deck_state_type), intent(in) :: state
    integer :: p

    associate (phases => state%analysis%phases)
      has_gravity = any([(any(abs(phases(p)%gravity%vector) > 0.0_wp), p=1, size(phases))])
    end associate
  end function has_gravity

  !> Checks the node sets of fixities, prescriptions, histories and the moving mesh.
  subroutine check_node_sets(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i, p

    associate (sets => state%analysis%node_sets)
      if (state%analysis%moving_mesh%active .and. .not. state%analysis%moving_mesh%by_body) call check_set(state, &
        state%analysis%moving_mesh%set, sets, state%analysis%moving_mesh%where, 'MOVING MESH', 'node set')
      do i = 1, size(state%analysis%histories)
        associate (history => state%analysis%histories(i))
          if (len(history%set) > 0) call check_set(state, history%set, sets, history%where, 'HISTORY', 'node set')
        end associate
      end do
      do p = 1, size(state%analysis%phases)
        associate (phase => state%analysis%phases(p))
          do i = 1, size(phase%fixities)
            call check_set(state, phase%fixities(i)%set, sets, phase%fixities(i)%where, 'FIX', 'node set')
          end do
          do i = 1, size(phase%prescriptions)
            call check_set(state, phase%prescriptions(i)%set, sets, phase%prescriptions(i)%where, &
              'PRESCRIBE', 'node set')
          end do
        end associate
      end do
    end associate
  end subroutine check_node_sets

  !> Checks the surfaces of tractions and supports, which are always defined in the deck.
  subroutine check_surfaces(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i, p

    do i = 1, size(state%analysis%surfaces)
      if (state%analysis%surfaces(i)%selection == select_outline) call check_outline(state, i)
    end do
    do p = 1, size(state%analysis%phases)
      do i = 1, size(state%analysis%phases(p)%tractions)
        associate (traction => state%analysis%phases(p)%tractions(i))
          call check_name(state, traction%surface, state%analysis%surfaces, traction%where, &
            trim(merge('PRESSURE', 'TRACTION', traction%follows)), 'surface')
        end associate
      end do
      do i = 1, size(state%analysis%phases(p)%supports)
        associate (support => state%analysis%phases(p)%supports(i))
          call check_name(state, support%surface, state%analysis%surfaces, support%where, &
            trim(merge('CONTRACTION', 'SUPPORT    ', support%contracts)), 'surface')
        end associate
      end do
    end do
  end subroutine check_surfaces

  !> Checks that the body of an outline exists and has an outline.
  subroutine check_outline(state, number)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: number
    integer :: b

    associate (surface => state%analysis%surfaces(number), bodies => state%analysis%bodies)
      call check_name(state, surface%body, bodies, surface%where, 'SURFACE', 'body')
      b = place_named(bodies, surface%body)
      if (b == 0 .or. len(surface%body) == 0) return
      if (any(bodies(b)%kind == [body_all, body_region])) call state%error_from( &
        surface%where, 'SURFACE', "body '"//surface%body//"' has no outline; TYPE=OUTLINE requires SHAPE=BOX, "// &
        'POLYGON or POLYHEDRON')
    end associate
  end subroutine check_outline

  !> Checks that no phase both fixes and prescribes the same component of a set.
  subroutine check_prescriptions(state)
    type(deck_state_type), intent(inout) :: state
    integer :: p, i, k

    do p = 1, size(state%analysis%phases)
      associate (phase => state%analysis%phases(p))
        do i = 1, size(phase%prescriptions)
          do k = 1, size(phase%fixities)
            if (phase%fixities(k)%set /= phase%prescriptions(i)%set) cycle
            if (phase%prescriptions(i)%component < 1) cycle
            if (phase%fixities(k)%fixed(phase%prescriptions(i)%component)) call state%error_from( &
              phase%prescriptions(i)%where, 'PRESCRIBE', "this component of set '"// &
              phase%prescriptions(i)%set//"' is fixed by *FIX in the same phase")
          end do
        end do
      end associate
    end do
  end subroutine check_prescriptions

  !> Checks that parents are earlier phases.
  subroutine check_parents(state)
    type(deck_state_type), intent(inout) :: state
    integer :: p

    associate (phases => state%analysis%phases)
      do p = 1, size(phases)
        if (has_parent(phases(p)) .and. parent_of(phases, p) == 0) call report_parent(state, p)
      end do
    end associate
  end subroutine check_parents

  !> Reports a parent that is not an earlier phase.
  subroutine report_parent(state, number)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: number
    type(string_type), allocatable :: before(:)

    associate (phases => state%analysis%phases, phase => state%analysis%phases(number))
      allocate (before(0))
      call add_names(phases(:number - 1), before)
      if (place_named(phases(number:), phase%parent) > 0) then
        call state%error_from(phase%where, 'PHASE', "PARENT='"//phase%parent//"' of phase '"//phase%name// &
          "' is not an earlier phase: a phase starts from the end of one that has been run")
      else if (size(before) == 0) then
        call state%error_from(phase%where, 'PHASE', "phase '"//phase%name//"' is the first one: it has no PARENT")
      else
        call state%error_from(phase%where, 'PHASE', "there is no phase '"//phase%parent//"' before '"//phase%name// &
          "'"//did_you_mean(phase%parent, before))
      end if
    end associate
  end subroutine report_parent

  !> Checks whether a built-in material is time-dependent.
  pure logical function flows_in_time(material)
    type(material_type), intent(in) :: material
    type(law_description_type) :: traits

    flows_in_time = allocated(material%soil_law)
    if (.not. flows_in_time) return
    traits = traits_of(material)
    flows_in_time = traits%flows_in_time
  end function flows_in_time

  !> Checks whether a phase itself changes loads, supports, bodies or water.
  pure logical function changes_something(analysis, number)
    type(analysis_type), intent(in) :: analysis
    !> Number of the phase.
    integer, intent(in) :: number

    associate (phase => analysis%phases(number))
      changes_something = acts(phase) .or. consolidation_of(analysis%phases, number) > 0 .or. &
        size(phase%fixities) + size(phase%supports) + size(phase%tractions) + size(phase%installed) &
        + size(phase%activations) + size(phase%deactivations) + size(phase%materials) &
        + size(phase%constant_load_test%at) + size(phase%water_levels) > 0 .or. phase%kind == phase_safety .or. &
        phase%gravity%given .or. phase%drain_state%given .or. phase%updates_strength
    end associate
  end function changes_something

  !> Warns of probable oversights, such as no fixities or K0 stresses without weight, and checks *CONFINING PRESSURE.
  subroutine check_starts(state)
    type(deck_state_type), intent(inout) :: state
    logical :: held, creeps
    integer :: p

    held = .false.
    creeps = any([(flows_in_time(state%analysis%materials(p)), p=1, size(state%analysis%materials))])
    do p = 1, size(state%analysis%phases)
      associate (phase => state%analysis%phases(p))
        held = held .or. size(phase%fixities) + size(phase%prescriptions) + size(phase%supports) > 0
        if (p == 1 .and. state%analysis%confinement > 0.0_wp .and. &
          all(phase%initial%kind /= [initial_isotropic, initial_given])) call state%error_from(phase%where, 'PHASE', &
          'the soil must be in equilibrium with the *CONFINING PRESSURE from the start: the first phase requires '// &
          '*INITIAL, TYPE=ISOTROPIC with this pressure, or TYPE=GIVEN')
        if (phase%initial%kind == initial_k0 .and. .not. phase%gravity%given) call state%warn( &
          phase%where, 'PHASE', 'K0 stresses follow from the weight, but the phase has no *GRAVITY')
        if (state%messages%error_count() > 0) cycle
        if (rises(phase%gravity%vector)) call state%warn(phase%where, 'GRAVITY', &
          'gravity points upwards: it is the direction of the force, '//trim(merge('0, 0, -1', '0, -1   ', &
          abs(phase%gravity%vector(3)) > 0.0_wp))//' for weight')
        if (any(phase%initial%kind == [initial_isotropic, initial_given])) cycle
        ! The removal of a load is a change too.
        if (.not. (is_loaded(state%analysis%phases, p) .or. p > 1 .and. changes_something(state%analysis, p))) then
          call state%warn(phase%where, 'PHASE', "phase '"//phase%name//"' has no load: nothing changes in it")
        else if (.not. (changes_something(state%analysis, p) .or. (creeps .and. phase%duration_given))) then
          call state%warn(phase%where, 'PHASE', "phase '"//phase%name//"' changes nothing: it has no load of its own")
        end if
      end associate
    end do
    if (.not. held .and. size(state%analysis%phases) > 0 .and. size(state%analysis%contacts) == 0) &
      call state%warn(state%analysis%phases(1)%where, 'PHASE', 'no phase has *FIX, '// &
      '*PRESCRIBE or *SUPPORT: the model is not supported')
  end subroutine check_starts

  !> Checks whether gravity acts upwards along y or z.
  pure logical function rises(gravity)
    real(wp), intent(in) :: gravity(3)
    integer :: axis

    axis = maxloc(abs(gravity), dim=1)
    rises = axis > 1 .and. gravity(axis) > 0.0_wp
  end function rises

  !> Warns where a fixed plane at an end of the grid faces a side of a body within a cell: partly filled cells support
  !> the body there, whereas on body-fitted triangles the side is free.
  subroutine check_held_ends(state)
    type(deck_state_type), intent(inout) :: state
    logical :: said(size(state%analysis%node_sets))
    real(wp) :: gap, cell, side
    integer :: p, i, s, b

    said = .false.
    associate (analysis => state%analysis)
      if (all(analysis%mesh%kind /= [mesh_grid, mesh_fitted]) .or. .not. all(analysis%bodies%kind == body_box .or. &
        analysis%bodies%kind == body_polygon)) return
      do p = 1, size(analysis%phases)
        do i = 1, size(analysis%phases(p)%fixities)
          associate (fixity => analysis%phases(p)%fixities(i))
            s = place_named(analysis%node_sets, fixity%set)
            if (s == 0) cycle
            associate (set => analysis%node_sets(s))
              if (said(s) .or. set%selection /= select_plane) cycle
              ! A pile on the axis of the model, with soil around it.
              if (set%axis /= vertical_of(analysis) .and. size(analysis%rigid_bodies) > 0) cycle
              if (.not. (fixity%fixed(set%axis) .and. allocated(analysis%mesh%axes(set%axis)%lines))) cycle
              associate (lines => analysis%mesh%axes(set%axis)%lines)
                cell = merge(lines(2) - lines(1), lines(size(lines)) - lines(size(lines) - 1), set%box(set%axis, 1) < &
                  0.5_wp*(lines(1) + lines(size(lines))))
                side = lines(merge(1, size(lines), set%box(set%axis, 1) < 0.5_wp*(lines(1) + lines(size(lines)))))
                if (abs(set%box(set%axis, 1) - side) > closed*cell) cycle
                do b = 1, size(analysis%bodies)
                  gap = gap_of(state, b, set%axis, side, merge(-1.0_wp, 1.0_wp, side < lines(2)), cell)
                  if (gap <= closed*cell .or. said(s)) cycle
                  said(s) = .true.
                  call state%warn(fixity%where, 'FIX', "node set '"//set%name//"' fixes the side "// &
                    trim(axis_words(set%axis))//' = '//rounded_text(side)//" of the grid, and body '"// &
                    analysis%bodies(b)%name//"' ends up to "//rounded_text(gap, 3)//' from it: '//trim(merge( &
                    'it is unsupported there                        ', &
                    'it rests on cells that it fills only partly    ', analysis%mesh%kind == mesh_fitted))// &
                    '; let both end at the same coordinate')
                end do
              end associate
            end associate
          end associate
        end do
      end do
    end associate
  end subroutine check_held_ends

  !> Distance of the sides of a body from an end of the grid that they face within a cell, with no body in between.
  pure real(wp) function gap_of(state, number, axis, side, out, cell) result(gap)
    type(deck_state_type), intent(in) :: state
    !> Number of the body.
    integer, intent(in) :: number, axis
    !> Coordinate of the end, its outward sense, and the size of the adjacent cell.
    real(wp), intent(in) :: side, out, cell
    real(wp), allocatable :: corner(:, :)
    real(wp) :: off(2), middle(3)
    integer :: k, n, next

    gap = 0.0_wp
    associate (body => state%analysis%bodies(number))
      if (body%kind == body_box) then
        corner = reshape([body%box(:, 1), body%box(:, 2)], [3, 2])
        corner(axis, :) = body%box(axis, merge(2, 1, out > 0.0_wp))
      else
        if (axis == 3) return
        corner = body%polygon
        if (polygon_area(corner) < 0.0_wp) corner = corner(:, size(corner, 2):1:-1)
      end if
    end associate
    n = size(corner, 2)
    do k = 1, n
      next = modulo(k, n) + 1
      associate (along => corner(:, next) - corner(:, k))
        ! The outward side is to the right of an edge.
        if (size(along) == 2) then
          if (out*merge(along(2), -along(1), axis == 1) < across*norm2(along)) cycle
        end if
      end associate
      off = out*(side - corner(axis, [k, next]))
      if (minval(off) >= cell .or. maxval(off) <= gap) cycle
      middle = 0.0_wp
      middle(:size(corner, 1)) = 0.5_wp*(corner(:, k) + corner(:, next))
      middle(axis) = middle(axis) + 0.25_wp*out*sum(off)
      if (.not. is_filled()) gap = maxval(off)
    end do

  contains

    !> Checks whether a body contains the midpoint.
    pure logical function is_filled()
      integer :: b

      is_filled = .false.
      do b = 1, size(state%analysis%bodies)
        associate (body => state%analysis%bodies(b))
          if (body%kind == body_polygon) is_filled = is_filled .or. polygon_contains(body%polygon, middle(:2))
          if (body%kind == body_box) is_filled = is_filled .or. all((middle >= body%box(:, 1) .and. &
            middle <= body%box(:, 2)) .or. body%box(:, 1) >= body%box(:, 2))
        end associate
      end do
    end function is_filled
  end function gap_of
end module qsmpm_deck_references
