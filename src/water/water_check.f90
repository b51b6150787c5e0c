!> Consistency checks of the water levels of a deck, carried out before the analysis.
!>
!> The force of the water (qsmpm_pore_water) represents its whole pressure as long as this is continuous: below a level
!> that slopes above the ground, or between two bodies with different levels, it has a jump that nothing balances. A
!> water pressure applied on the surface of a body below its level would be counted twice.
module qsmpm_water_check
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_history_description, only: quantity_contact_force, quantity_contact_pressure, quantity_reaction
  use qsmpm_load_description, only: traction_type, water_level_type
  use qsmpm_agreement, only: lowest_rank, spread_text
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic, where_text
  use qsmpm_model, only: model_type
  use qsmpm_overburden, only: overburden_type, make_overburden, ground_over, body_holds, facet_places
  use qsmpm_phase_loads, only: free_surface_of, load_in_force
  use qsmpm_phase_tree, only: lineage
  use qsmpm_pore_water, only: has_water, levels_in_force
  use qsmpm_vertical, only: upwards, vertical_of
  use qsmpm_team, only: smallest, largest_of_all => largest
  use qsmpm_rounded_text, only: short => rounded_text, rounded_text
  use qsmpm_water_table, only: water_table_type, level_at, slope_at, head_at
  use qsmpm_active_bodies, only: bodies_active, body_number
  implicit none
  private

  public :: check_water_levels

  !> Tolerance for equal heights relative to the mesh, and small distance relative to the mesh at which places next to a
  !> face are evaluated.
  real(wp), parameter :: same_height = 1.0e-3_wp, hair = 1.0e-6_wp
  character(len=*), parameter :: flooded_hollow = 'a hollow below the water level'

contains

  !> Runs all checks for every phase.
  subroutine check_water_levels(model, diagnostics)
    !> Receives warnings.
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    type(overburden_type) :: ground
    type(water_table_type), allocatable :: tables(:)
    real(wp) :: none(size(model%shapes))
    character(len=:), allocatable :: notes
    integer :: p, i

    if (.not. has_water(model%analysis)) return
    none = 0.0_wp
    notes = ''
    call make_overburden(model%mesh, model%shapes, none, vertical_of(model%analysis), ground, &
      up=upwards(model%analysis))
    do p = 1, size(model%analysis%phases)
      associate (phase => model%analysis%phases(p))
        call levels_in_force(model%analysis, p, tables)
        do i = 1, size(phase%water_levels)
          associate (level => phase%water_levels(i))
            if (level%none .or. level%flows) cycle
            call check_reach(model, level, tables, diagnostics)
            call check_slope(model, ground, level, tables, diagnostics)
          end associate
        end do
        do i = 1, size(phase%water_levels)
          associate (level => phase%water_levels(i))
            if (.not. (level%none .or. level%flows)) call check_falls(model, level, tables, diagnostics)
          end associate
        end do
        if (size(phase%water_levels) > 0) call check_neighbours(model, ground, p, tables, diagnostics)
        call check_pressures(model, ground, p, tables, diagnostics)
      end associate
      call warn_of_flooded_pits(model, ground, p, tables, [same_height, hair]*mesh_height(model, ground%axis), notes)
      if (index(notes, flooded_hollow) == 0) call warn_of_flooded_hollow(model, ground, p, tables, &
        [same_height, hair]*mesh_height(model, ground%axis), notes)
    end do
    model%notes = model%notes//notes//effective_note(model%analysis)
  end subroutine check_water_levels

  !> Returns the note that histories of reactions and contact forces exclude the water, with the name of the first;
  !> empty where there is none.
  pure function effective_note(analysis) result(text)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: text, but
    integer :: i

    text = ''
    but = ''
    if (any([(free_surface_of(analysis%phases, i) > 0, i=1, size(analysis%phases))])) &
      but = ', except under a free surface of *CONSOLIDATION, where they include it'
    do i = 1, size(analysis%histories)
      if (.not. any(analysis%histories(i)%quantity == [quantity_reaction, quantity_contact_force, &
        quantity_contact_pressure])) cycle
      text = "history '"//analysis%histories(i)%name//"', as all reactions and contact forces, is of effective "// &
        'stresses: the hydrostatic water pressure must be added, gamma_w h^2/2 on a wall '// &
        '(docs/methods/water.md)'//but//new_line('a')
      return
    end do
  end function effective_note

  !> Height of the mesh along the vertical.
  pure real(wp) function mesh_height(model, axis) result(height)
    type(model_type), intent(in) :: model
    integer, intent(in) :: axis

    height = model%mesh%bounds(axis, 2) - model%mesh%bounds(axis, 1)
  end function mesh_height

  !> Checks whether a level of the deck applies to a body.
  pure logical function is_of(model, level, body, table) result(yes)
    type(model_type), intent(in) :: model
    type(water_level_type), intent(in) :: level
    integer, intent(in) :: body
    type(water_table_type), intent(in) :: table

    yes = model%analysis%bodies(body)%name == level%body
    if (len(level%body) == 0) yes = .not. table%own
  end function is_of

  !> Checks that a line crosses the mesh and is not below all ground to which it applies.
  subroutine check_reach(model, level, tables, diagnostics)
    type(model_type), intent(in) :: model
    type(water_level_type), intent(in) :: level
    type(water_table_type), intent(in) :: tables(:)
    type(diagnostics_type), intent(inout) :: diagnostics
    real(wp) :: lowest
    integer :: p, b, axis

    associate (bounds => model%mesh%bounds(tables(1)%across, :), points => model%state%points)
      if (size(level%line, 2) > 1 .and. (maxval(level%line(1, :)) <= bounds(1) .or. minval(level%line(1, :)) &
        >= bounds(2))) then
        call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', 'the line from '// &
          short(minval(level%line(1, :)))//' to '//short(maxval(level%line(1, :)))// &
          ' does not cross the mesh, which goes from '//short(bounds(1))//' to '//short(bounds(2)))
        return
      end if
      axis = tables(1)%axis
      lowest = huge(1.0_wp)
      do p = 1, points%count
        b = points%body(p)
        if (.not. is_of(model, level, b, tables(b))) cycle
        lowest = min(lowest, tables(b)%up*(points%position(axis, p) - level_at(tables(b), points%position(:, p))) &
          - points%half_size(axis, p))
      end do
      lowest = smallest(model%part%team, lowest)
      if (lowest > same_height*mesh_height(model, axis)) call add_diagnostic(diagnostics, level%where, &
        '*WATER LEVEL', 'the level is below all ground it applies to, by '//short(lowest)// &
        '; TYPE=NONE removes the water')
    end associate
  end subroutine check_reach

  !> Checks that no steep fall of a line is within the box of a point, over which its slope is averaged.
  subroutine check_falls(model, level, tables, diagnostics)
    type(model_type), intent(in) :: model
    type(water_level_type), intent(in) :: level
    type(water_table_type), intent(in) :: tables(:)
    type(diagnostics_type), intent(inout) :: diagnostics
    real(wp) :: fall
    character(len=:), allocatable :: place
    integer :: i, p, b, rank

    do i = 1, size(level%line, 2) - 1
      associate (from => level%line(:, i), to => level%line(:, i + 1), points => model%state%points)
        fall = abs(to(2) - from(2))
        if (fall <= max(same_height*mesh_height(model, tables(1)%axis), to(1) - from(1))) cycle
        place = ''
        do p = 1, points%count
          b = points%body(p)
          if (.not. is_of(model, level, b, tables(b))) cycle
          associate (x => points%position(tables(b)%across, p), half => points%half_size(tables(b)%across, p))
            if (x + half <= from(1) .or. x - half >= to(1) .or. to(1) - from(1) >= 2.0_wp*half) cycle
            place = short(2.0_wp*half)//" wide, as at ("//short(points%position(1, p))//', '// &
              short(points%position(2, p))//") in body '"//model%analysis%bodies(b)%name//"'"
          end associate
          exit
        end do
        rank = lowest_rank(model%part%team, len(place) > 0)
        if (rank == model%part%team%ranks) cycle
        call spread_text(model%part%team, rank, place)
        call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', &
          'the line falls by '//short(fall)//' from '//across_name(tables)//' = '//short(from(1))//' to '// &
          short(to(1))//', within the domain of a material point, '//place//', which averages it: let it fall over '// &
          'the width of the wall, or of several points; below a thinner wall compute the flow around it, by '// &
          'TYPE=SEEPAGE')
      end associate
    end do
  end subroutine check_falls

  !> Checks that a sloping line is within the ground or at its surface, since free water is horizontal.
  subroutine check_slope(model, ground, level, tables, diagnostics)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: ground
    type(water_level_type), intent(in) :: level
    type(water_table_type), intent(in) :: tables(:)
    type(diagnostics_type), intent(inout) :: diagnostics
    character(len=:), allocatable :: place
    real(wp) :: above, highest
    integer :: p, b, worst, rank

    allocate (character(len=0) :: place)
    worst = 0
    above = same_height*mesh_height(model, ground%axis)
    associate (points => model%state%points)
      do p = 1, points%count
        b = points%body(p)
        if (.not. is_of(model, level, b, tables(b))) cycle
        associate (x => points%position(:, p))
          if (.not. abs(slope_at(tables(b), x)) > 0.0_wp) cycle
          if (ground%up*(level_at(tables(b), x) - ground_over(ground, x)) <= above) cycle
          above = ground%up*(level_at(tables(b), x) - ground_over(ground, x))
          worst = p
        end associate
      end do
      if (worst > 0) place = short(above)//' over it at '//across_name(tables)//' = '// &
        short(points%position(tables(1)%across, worst))
      highest = largest_of_all(model%part%team, above)
      rank = lowest_rank(model%part%team, worst > 0 .and. above >= highest)
      if (rank == model%part%team%ranks) return
      call spread_text(model%part%team, rank, place)
      call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', 'the line slopes above the ground, by '//place// &
        ': free water is horizontal; where the level leaves the ground let it follow the surface or continue '// &
        'horizontally')
    end associate
  end subroutine check_slope

  !> Checks that bodies in contact have the same pressure there, unless a *PRESSURE acts between them.
  subroutine check_neighbours(model, ground, number, tables, diagnostics)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: ground
    !> Number of the phase.
    integer, intent(in) :: number
    type(water_table_type), intent(in) :: tables(:)
    type(diagnostics_type), intent(inout) :: diagnostics
    real(wp) :: jump
    integer :: a, b

    do a = 1, size(tables)
      if (all(same_tables(tables(a), tables))) cycle
      do b = a + 1, size(tables)
        if (same_tables(tables(a), tables(b))) cycle
        jump = largest_jump(model, ground, tables, a, b)
        if (.not. jump > 0.0_wp) cycle
        if (is_pressed(model, ground, number, a, b)) cycle
        call add_diagnostic(diagnostics, model%analysis%phases(number)%water_levels(1)%where, '*WATER LEVEL', &
          'the pressure of the water jumps by '//short(jump)//" from body '"//model%analysis%bodies(a)%name// &
          "' to body '"//model%analysis%bodies(b)%name//"', which are in contact: nothing balances the jump; give "// &
          'both one level, let it fall over the width of one of them, or apply a *PRESSURE on the surface between them')
      end do
    end do
  end subroutine check_neighbours

  !> Largest jump of the pressure between two bodies where they are in contact; 0 without one.
  real(wp) function largest_jump(model, ground, tables, a, b) result(largest)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: ground
    type(water_table_type), intent(in) :: tables(:)
    !> Numbers of the bodies.
    integer, intent(in) :: a, b
    real(wp), allocatable :: places(:, :)
    real(wp) :: jump
    integer :: k

    largest = 0.0_wp
    call facet_places(ground, a, hair*mesh_height(model, ground%axis), places)
    do k = 1, size(places, 2)
      jump = abs(tables(a)%unit_weight*head_at(tables(a), places(:, k)) &
        - tables(b)%unit_weight*head_at(tables(b), places(:, k)))
      if (jump <= same_height*mesh_height(model, ground%axis)*max(tables(a)%unit_weight, &
        tables(b)%unit_weight)) cycle
      if (jump > largest .and. body_holds(ground, b, places(:model%mesh%dimension, k))) largest = jump
    end do
  end function largest_jump

  !> Name of the coordinate along which levels vary.
  pure character(len=1) function across_name(tables) result(letter)
    type(water_table_type), intent(in) :: tables(:)

    letter = merge('y', 'x', tables(1)%across == 2)
  end function across_name

  !> Checks whether two levels are equal.
  elemental logical function same_tables(a, b) result(same)
    type(water_table_type), intent(in) :: a, b

    same = (a%present .eqv. b%present)
    if (.not. (same .and. a%present)) return
    same = size(a%x) == size(b%x) .and. abs(a%unit_weight - b%unit_weight) <= 0.0_wp
    if (same) same = all(abs(a%x - b%x) <= 0.0_wp) .and. all(abs(a%height - b%height) <= 0.0_wp)
  end function same_tables

  !> Checks whether a *PRESSURE acts between two bodies in a phase: on one of them where it is in contact with the
  !> other.
  pure logical function is_pressed(model, ground, number, a, b) result(pressed)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: ground
    !> Number of the phase, and of the bodies.
    integer, intent(in) :: number, a, b
    integer, allocatable :: path(:)
    integer :: i, p, k

    pressed = .false.
    allocate (path, source=lineage(model%analysis%phases, number))
    associate (surface => model%state%surface)
      do k = 1, surface%count
        do p = 1, size(path)
          do i = 1, size(model%analysis%phases(path(p))%tractions)
            associate (load => model%analysis%phases(path(p))%tractions(i))
              if (.not. load%follows .or. model%analysis%surfaces(surface%surface(k))%name /= load%surface) cycle
              pressed = pressed .or. (holds(a, 1) .and. holds(b, -1)) .or. (holds(b, 1) .and. holds(a, -1))
            end associate
          end do
        end do
      end do
    end associate
  contains
    !> Checks whether a body contains the place behind the surface point, or the one in front of it.
    pure logical function holds(body, side)
      integer, intent(in) :: body
      !> 1 behind, -1 in front.
      integer, intent(in) :: side

      holds = body_holds(ground, body, place_beside(model, ground, k, side))
    end function holds
  end function is_pressed

  !> Returns a place slightly behind a surface point, in the body, or in front of it.
  pure function place_beside(model, ground, k, side) result(place)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: ground
    !> Number of the surface point; 1 behind it, -1 in front of it.
    integer, intent(in) :: k, side
    real(wp) :: place(model%mesh%dimension)

    associate (surface => model%state%surface)
      place = surface%position(:, k) - side*hair*mesh_height(model, ground%axis)*surface%area_vector(:, k) &
        /max(norm2(surface%area_vector(:, k)), tiny(1.0_wp))
    end associate
  end function place_beside

  !> Checks that no surface below the level of its body is loaded by a water pressure.
  subroutine check_pressures(model, ground, number, tables, diagnostics)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: ground
    !> Number of the phase.
    integer, intent(in) :: number
    type(water_table_type), intent(in) :: tables(:)
    type(diagnostics_type), intent(inout) :: diagnostics
    type(traction_type) :: load
    integer :: s, k, b
    logical :: wet

    associate (surface => model%state%surface, phase => model%analysis%phases(number))
      if (size(phase%water_levels) + size(phase%tractions) == 0) return
      do s = 1, size(model%analysis%surfaces)
        load = load_in_force(model%analysis%phases, lineage(model%analysis%phases, number), &
          model%analysis%surfaces(s)%name, follows=.true.)
        if (.not. (load%of_water .and. load%gradient > 0.0_wp)) cycle
        wet = .false.
        do k = 1, surface%count
          if (surface%surface(k) /= s) cycle
          do b = 1, size(tables)
            if (.not. head_at(tables(b), surface%position(:, k)) > same_height*mesh_height(model, ground%axis)) cycle
            wet = wet .or. body_holds(ground, b, place_beside(model, ground, k, 1))
          end do
        end do
        if (wet) call add_diagnostic(diagnostics, load%where, '*PRESSURE', "surface '"//load%surface// &
          "' lies below the water level of its body in phase '"//phase%name//"', whose force already includes the "// &
          'water pressure on the surface: it would be counted twice; for slurry give only the pressure in excess '// &
          'of water, in a data line `p, gradient, y`')
      end do
    end associate
  end subroutine check_pressures

  !> Warns of bodies that a phase removes below the level. The force of the water on the ground (qsmpm_pore_water)
  !> includes its pressure on every face below the level, also on floor and walls of an excavation. That is correct for
  !> an underwater excavation; a dry one requires a lowered level.
  subroutine warn_of_flooded_pits(model, ground, number, tables, tolerance, notes)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: ground
    !> Number of the phase.
    integer, intent(in) :: number
    !> Levels at its end (bodies).
    type(water_table_type), intent(in) :: tables(:)
    !> Smallest relevant depth of water, and distance from a face to the place behind it [length].
    real(wp), intent(in) :: tolerance(2)
    !> Text for the log.
    character(len=:), allocatable, intent(inout) :: notes
    real(wp) :: depth
    integer :: i

    if (.not. allocated(model%analysis%phases(number)%deactivations)) return
    associate (phase => model%analysis%phases(number))
      do i = 1, size(phase%deactivations)
        associate (change => phase%deactivations(i))
          depth = depth_of_water(model, ground, number, body_number(model%analysis, change%body), tables, tolerance(2))
          if (.not. depth > tolerance(1)) cycle
          notes = notes//'warning: '//where_text(change%where)//"*DEACTIVATE: where body '"//change%body// &
            "' is excavated, water stands "//rounded_text(depth)//" deep from phase '"//phase%name// &
            "' on, because the water level stays above the floor; for a dry excavation let *WATER LEVEL of this "// &
            'phase run along or below the floor'//new_line('a')
        end associate
      end do
    end associate
  end subroutine warn_of_flooded_pits

  !> Warns of a cavity below the level, such as a culvert or a tunnel: its floor has a body below it, ground or a roof
  !> above it and nothing in between. The force of the water also acts on its faces from within. Scenes with rigid
  !> bodies, which may fill it, are skipped.
  subroutine warn_of_flooded_hollow(model, ground, number, tables, tolerance, notes)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: ground
    !> Number of the phase.
    integer, intent(in) :: number
    !> Levels at its end (bodies).
    type(water_table_type), intent(in) :: tables(:)
    !> Smallest relevant depth of water, and distance from a face to the place in front of it [length].
    real(wp), intent(in) :: tolerance(2)
    !> Text for the log.
    character(len=:), allocatable, intent(inout) :: notes
    real(wp), allocatable :: places(:, :)
    real(wp) :: below(3)
    logical :: active(size(tables))
    integer :: b, k, i

    if (size(model%analysis%rigid_bodies) > 0) return
    active = bodies_active(model%analysis, number)
    do b = 1, size(tables)
      if (.not. active(b) .or. .not. tables(b)%present) cycle
      call facet_places(ground, b, tolerance(2), places)
      do k = 1, size(places, 2)
        associate (x => places(:model%mesh%dimension, k), axis => ground%axis)
          below = places(:, k)
          below(axis) = below(axis) - 3.0_wp*ground%up*tolerance(2)
          if (.not. head_at(tables(b), x) > tolerance(1)) cycle
          if (.not. ground%up*(ground_over(ground, x) - x(axis)) > tolerance(1)) cycle
          if (.not. body_holds(ground, b, below(:size(x)))) cycle
          if (any([(body_holds(ground, i, x), i=1, size(tables))])) cycle
          notes = notes//'warning: '//flooded_hollow//' at ('//rounded_text(x(1))//', '//rounded_text(x(2))// &
            '), with '//rounded_text(head_at(tables(b), x))// &
            " of water on its floor in body '"//model%analysis%bodies(b)%name//"' in phase '"// &
            model%analysis%phases(number)%name//"', is treated as full of water, which acts on its faces: a dry "// &
            'one requires *WATER LEVEL, BODY=, TYPE=NONE of the lining and *PRESSURE, LEVEL= on its outside; a gap '// &
            'between layers is closed by giving both the same corners'//new_line('a')
          return
        end associate
      end do
    end do
  end subroutine warn_of_flooded_hollow

  !> Largest depth below the level of the faces of active bodies that the removal of a body exposes.
  real(wp) function depth_of_water(model, ground, number, body, tables, hair) result(depth)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: ground
    !> Number of the phase and of the body.
    integer, intent(in) :: number, body
    type(water_table_type), intent(in) :: tables(:)
    real(wp), intent(in) :: hair
    real(wp), allocatable :: places(:, :)
    logical :: active(size(tables))
    integer :: b, k

    depth = 0.0_wp
    active = bodies_active(model%analysis, number)
    call facet_places(ground, body, hair, places)
    do k = 1, size(places, 2)
      do b = 1, size(tables)
        if (.not. active(b) .or. .not. tables(b)%present) cycle
        if (.not. head_at(tables(b), places(:, k)) > depth) cycle
        if (body_holds(ground, b, places(:model%mesh%dimension, k))) depth = head_at(tables(b), places(:, k))
      end do
    end do
  end function depth_of_water
end module qsmpm_water_check
