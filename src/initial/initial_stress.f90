!> Initial stresses of a phase (*INITIAL). TYPE=K0: level ground under its own weight.
!>
!> sigma_v = -|g| W(x) + u(x), sigma_h = K0 sigma_v, W the weight above the point (qsmpm_overburden)
!>
!> are effective stresses with u the pressure of the water at rest (qsmpm_pore_water), along the coordinate in which
!> gravity acts. K0 is that of the material or of the phase; sigma_h is limited to the strength
!> (qsmpm_initial_strength). Only level layers are then in equilibrium, which qsmpm_initial_balance checks.
!>
!> Structures are bodies that cannot yield next to soil that can, or that are much stiffer than elastic ground. They
!> have the stress and the weight of the adjacent soil at the start, zero above ground level, and their own weight at
!> the end of the phase. A body as wide as the ground is a layer.
!>
!> Stresses may be read from the results of another run (*INITIAL, TYPE=GIVEN, INPUT=results.h5), with its state
!> variables; its material must be at the same place as that of the model. docs/methods/initial_stresses.md.
module qsmpm_initial_stress
  use qsmpm_kinds, only: wp, long
  use qsmpm_active_bodies, only: bodies_active
  use qsmpm_material_description, only: may_yield
  use qsmpm_named, only: place_named
  use qsmpm_phase_description, only: initial_stress_type, initial_k0, initial_isotropic, initial_given
  use qsmpm_model, only: model_type
  use qsmpm_points, only: place_of
  use qsmpm_pore_water, only: half_size
  use qsmpm_point_bins, only: point_bins_type, make_bins, nearest_in_bins
  use qsmpm_initial_strength, only: limit_horizontal, round_off
  use qsmpm_own_part, only: own_of
  use qsmpm_stress_at_rest, only: horizontal_at_rest
  use qsmpm_water_table, only: head_at, submerged_share
  use qsmpm_overburden, only: overburden_type, make_overburden, weight_above, ground_top, body_holds, find_beside
  use qsmpm_polyhedron, only: polyhedron_type
  use qsmpm_value_field, only: value_field_type, field_as, field_weight, has_values
  use qsmpm_agreement, only: lowest_rank, spread_text
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_error, only: error_type
  use qsmpm_law, only: law_slot_type
  use qsmpm_mesh_measure, only: cell_size
  use qsmpm_stress_results, only: read_state_results
  use qsmpm_team, only: largest, smallest, total
  use qsmpm_rounded_text, only: rounded_place, rounded_text
  use qsmpm_text, only: integer_text, word_place
  implicit none
  private

  public :: set_initial_stresses, start_states, reaches_above, measure_slope, stresses_at_rest, structures_at_rest, &
    check_initial_results, limit_note

  !> Part of the half size of a point's box that is evaluated: inside its edges, which bodies may share.
  real(wp), parameter :: inside_box = 0.9_wp
  !> Ratio of Young's modulus to that of elastic ground above which a body is a structure.
  real(wp), parameter :: stiff = 30.0_wp

contains

  !> Sets the stresses of the phase at all material points, and the corresponding states of their laws.
  subroutine set_initial_stresses(model, initial)
    type(model_type), intent(inout) :: model
    type(initial_stress_type), intent(in) :: initial
    integer :: p

    select case (initial%kind)
    case (initial_k0)
      associate (points => model%state%points)
        call stresses_at_rest(model, initial, [(p, p=1, points%count)], points%position, points%stress)
      end associate
      call weigh_structures(model, initial)
    case (initial_isotropic, initial_given)
      call set_given_stresses(model, initial)
    end select
    model%state%points%initial_volume = model%state%points%volume
    call start_states(model)
    if (allocated(initial%state_names)) call take_states(model, initial)
  end subroutine set_initial_stresses

  !> Sets the states of the laws for the stresses of the points.
  subroutine start_states(model)
    type(model_type), intent(inout) :: model
    integer :: p

    associate (points => model%state%points)
      do p = 1, points%count
        associate (law => model%laws(points%material(p))%law)
          call law%start_at(points%stress(:, p), place_of(points, p), points%state(:law%state_count, p))
        end associate
      end do
    end associate
  end subroutine start_states

  !> Sets stresses from a table or from the nearest place of a list.
  subroutine set_given_stresses(model, initial)
    type(model_type), intent(inout) :: model
    type(initial_stress_type), intent(in) :: initial
    type(point_bins_type) :: bins
    real(wp) :: found(6)
    integer :: p, axis
    logical :: from_file

    axis = vertical_axis(model)
    from_file = .false.
    if (allocated(initial%places)) from_file = initial%kind == initial_given
    if (from_file) call make_bins(initial%places, bins)
    associate (points => model%state%points)
      do p = 1, points%count
        found = 0.0_wp
        if (from_file) then
          found = initial%at_places(:, nearest_in_bins(bins, initial%places, points%position(:, p)))
        else if (initial%kind == initial_given) then
          found = table_row(initial%stresses, points%position(axis, p))
        else
          found(1:1) = -table_row(initial%pressures, points%position(axis, p))
          found(2:3) = found(1)
        end if
        points%stress(:, p) = found(:size(points%stress, 1))
      end do
    end associate
  end subroutine set_given_stresses

  !> Returns the row of a table at a height: linear between the given heights, constant beyond the ends.
  pure function table_row(table, height) result(row)
    !> Height and values (1 + values, n), with ascending heights.
    real(wp), intent(in) :: table(:, :)
    real(wp), intent(in) :: height
    real(wp) :: row(size(table, 1) - 1)
    real(wp) :: share
    integer :: i

    i = max(1, min(size(table, 2) - 1, count(table(1, :) <= height)))
    row = table(2:, i)
    if (i == size(table, 2)) return
    share = max(0.0_wp, min(1.0_wp, (height - table(1, i))/(table(1, i + 1) - table(1, i))))
    row = row + share*(table(2:, i + 1) - table(2:, i))
  end function table_row

  !> Computes K0 stresses of material points, each at a given place, limited to the strength.
  subroutine stresses_at_rest(model, initial, points, places, stress)
    type(model_type), intent(in) :: model
    !> Level and K0 of the phase.
    type(initial_stress_type), intent(in) :: initial
    !> Numbers of the points (n), places in their bodies (dimension, n).
    integer, intent(in) :: points(:)
    real(wp), intent(in) :: places(:, :)
    !> (4 or 6, n)
    real(wp), intent(out) :: stress(:, :)
    type(overburden_type) :: overburden
    real(wp) :: at_rest(2), place(3)
    integer :: i, axis, material

    axis = vertical_axis(model)
    call bodies_from_the_side(model, axis, overburden)
    place = 0.0_wp
    do i = 1, size(points)
      call find_at_rest(model, overburden, initial, points(i), places(:, i), at_rest, material)
      stress(:, i) = 0.0_wp
      stress(1:3, i) = at_rest(2)
      stress(axis, i) = at_rest(1)
      if (material == 0) cycle
      if (model%analysis%materials(material)%user%given .or. .not. may_yield(model%analysis%materials(material))) cycle
      place(:size(places, 1)) = places(:, i)
      call limit_horizontal(model%laws(material)%law, place, axis, stress(:, i))
    end do
  end subroutine stresses_at_rest

  !> Finds the effective vertical and horizontal stress at a place in the body of a point, not limited to the strength.
  pure subroutine find_at_rest(model, overburden, initial, p, position, stress, material)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: overburden
    type(initial_stress_type), intent(in) :: initial
    !> Number of the point.
    integer, intent(in) :: p
    !> The place (dimension).
    real(wp), intent(in) :: position(:)
    real(wp), intent(out) :: stress(2)
    !> Number of the material that is at rest there: in a structure that of the adjacent ground; 0 outside the ground.
    integer, intent(out) :: material
    real(wp) :: place(size(position))
    integer :: body

    stress = 0.0_wp
    material = 0
    call find_beside(overburden, model%state%points%body(p), position, body, place)
    if (body == 0) return
    material = model%state%points%material(p)
    if (overburden%structure(model%state%points%body(p))) &
      material = place_named(model%analysis%materials, model%analysis%bodies(body)%material)
    associate (gravity => abs(model%loading%gravity_final(overburden%axis)), water => model%loading%water_final(body))
      stress(1) = gravity*(water%unit_weight*head_at(water, place) &
        - weight_above(overburden, body, place, initial%surface_level))
    end associate
    stress(2) = -horizontal_at_rest(model%analysis%materials(material), initial%k0, -stress(1))
  end subroutine find_at_rest

  !> Returns the warning of the points where the strength limits the horizontal stress of K0, or nothing.
  function limit_note(model, initial) result(text)
    !> The model with its initial stresses.
    type(model_type), intent(in) :: model
    type(initial_stress_type), intent(in) :: initial
    character(len=:), allocatable :: text, names
    type(overburden_type) :: overburden
    real(wp) :: at_rest(2), range(2)
    logical :: limited(model%state%points%count), own(model%state%points%count)
    integer(long) :: points_of(2)
    integer :: at(model%state%points%count), p, m, axis, horizontal

    text = ''
    if (initial%kind /= initial_k0) return
    axis = vertical_axis(model)
    horizontal = merge(2, 1, axis == 1)
    call bodies_from_the_side(model, axis, overburden)
    own = own_of(model%part%points, model%state%points%count)
    limited = .false.
    at = 0
    range = [huge(1.0_wp), 0.0_wp]
    names = ''
    associate (points => model%state%points, team => model%part%team)
      do p = 1, points%count
        if (.not. own(p)) cycle
        call find_at_rest(model, overburden, initial, p, points%position(:, p), at_rest, at(p))
        limited(p) = abs(points%stress(horizontal, p) - at_rest(2)) > round_off*abs(at_rest(2))
        if (limited(p) .and. at_rest(1) < 0.0_wp) range = [min(range(1), points%stress(horizontal, p)/at_rest(1)), &
          max(range(2), points%stress(horizontal, p)/at_rest(1))]
      end do
      do m = 1, size(model%laws)
        if (total(team, count(limited .and. at == m, kind=long)) > 0) &
          names = names//", '"//model%analysis%materials(m)%name//"'"
      end do
      range = [smallest(team, range(1)), largest(team, range(2))]
      points_of = [total(team, count(limited, kind=long)), total(team, count(own, kind=long))]
      if (len(names) > 0) text = 'warning: K0 is beyond the strength at '//integer_text(points_of(1))//' of '// &
        integer_text(points_of(2))//' material points (material '//names(3:)//'): their horizontal stress is set '// &
        'to the nearest one within the strength, '//rounded_text(range(1))//' to '//rounded_text(range(2))// &
        ' times the vertical stress'//new_line('a')
    end associate
  end function limit_note

  !> Sets the weight of the points of structures at the start of the phase to that of the adjacent soil.
  subroutine weigh_structures(model, initial)
    type(model_type), intent(inout) :: model
    type(initial_stress_type), intent(in) :: initial
    type(overburden_type) :: overburden
    real(wp) :: ends(model%mesh%dimension, 2), above(2), half
    integer :: p, k

    call bodies_from_the_side(model, vertical_axis(model), overburden)
    if (.not. any(overburden%structure)) return
    associate (points => model%state%points, axis => overburden%axis)
      do p = 1, points%count
        associate (body => points%body(p), position => points%position(:, p))
          if (.not. overburden%structure(body)) cycle
          half = inside_box*half_size(model, p, axis)
          ends = spread(position, 2, 2)
          ends(axis, :) = ends(axis, :) + [-half, half]*overburden%up
          above = [(weight_beside(overburden, body, ends(:, k), initial%surface_level), k=1, 2)]
          ! Boxes of points may extend below the ground.
          if (.not. above(1) > 0.0_wp) then
            ends(axis, 1) = position(axis)
            above(1) = weight_beside(overburden, body, position, initial%surface_level)
          end if
          points%start_weight(p) = points%volume(p)*((above(1) - above(2))/abs(ends(axis, 2) - ends(axis, 1)) &
            - (overburden%saturated_weight(body) - overburden%unit_weight(body)) &
            *submerged_share(model%loading%water_final(body), position, half))
        end associate
      end do
    end associate
  end subroutine weigh_structures

  !> Returns the weight above a place in the ground or in the free water next to structures, 0 below the ground.
  pure real(wp) function weight_beside(overburden, body, position, level) result(weight)
    type(overburden_type), intent(in) :: overburden
    !> Body that contains the place, and the place (dimension).
    integer, intent(in) :: body
    real(wp), intent(in) :: position(:)
    !> Coordinate of the ground level.
    real(wp), intent(in) :: level
    real(wp) :: place(size(position))
    integer :: beside

    weight = 0.0_wp
    call find_beside(overburden, body, position, beside, place)
    if (beside > 0) then
      weight = weight_above(overburden, beside, place, level)
    else if (overburden%up*position(overburden%axis) > overburden%up*ground_top(overburden)) then
      weight = overburden%water(body)%unit_weight*head_at(overburden%water(body), position)
    end if
  end function weight_beside

  !> Measures the deviation of K0 stresses from horizontal equilibrium, and finds the critical point: without shear
  !> stress the horizontal stress must not vary horizontally,
  !>
  !>   |d sigma_h/dx| / gamma,   largest over the points, gamma the largest unit weight
  !>
  !> by differences over the box of a point, in its body. Where an interface, the ground or the water table is inclined
  !> at 1 in n between unit weights that differ by g this is K0 g/(n gamma), on any mesh.
  subroutine measure_slope(model, initial, slope, worst)
    type(model_type), intent(in) :: model
    type(initial_stress_type), intent(in) :: initial
    real(wp), intent(out) :: slope
    !> Number of the point; 0 where nothing is inclined.
    integer, intent(out) :: worst
    type(overburden_type) :: overburden
    real(wp) :: heaviest, found
    integer :: p, d

    slope = 0.0_wp
    worst = 0
    call bodies_from_the_side(model, vertical_axis(model), overburden)
    heaviest = abs(model%loading%gravity_final(overburden%axis))*maxval([overburden%unit_weight, &
      overburden%saturated_weight])
    if (.not. heaviest > 0.0_wp) return
    do p = 1, model%state%points%count
      do d = 1, model%mesh%dimension
        if (d == overburden%axis) cycle
        found = abs(change_along(model, overburden, initial, p, d))/heaviest
        if (.not. found > slope) cycle
        slope = found
        worst = p
      end do
    end do
  end subroutine measure_slope

  !> Returns the change of the horizontal stress along a horizontal axis, between two places of the box of a point
  !> inside its body.
  pure real(wp) function change_along(model, overburden, initial, p, axis) result(change)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: overburden
    type(initial_stress_type), intent(in) :: initial
    !> Number of the point.
    integer, intent(in) :: p
    integer, intent(in) :: axis
    real(wp) :: place(model%mesh%dimension, 2), stress(2, 2)
    integer :: k, material

    associate (points => model%state%points)
      do k = 1, 2
        place(:, k) = points%position(:, p)
        place(axis, k) = place(axis, k) + merge(-1.0_wp, 1.0_wp, k == 1)*inside_box*points%half_size(axis, p)
        if (.not. body_holds(overburden, points%body(p), place(:, k))) place(:, k) = points%position(:, p)
        call find_at_rest(model, overburden, initial, p, place(:, k), stress(:, k), material)
      end do
      change = (stress(2, 2) - stress(2, 1))/max(place(axis, 2) - place(axis, 1), tiny(1.0_wp))
    end associate
  end function change_along

  !> Returns the coordinate along which gravity acts; y without gravity.
  pure integer function vertical_axis(model) result(axis)
    type(model_type), intent(in) :: model

    axis = 2
    associate (gravity => model%loading%gravity_final(:model%mesh%dimension))
      if (any(abs(gravity) > 0.0_wp)) axis = maxloc(abs(gravity), dim=1)
    end associate
  end function vertical_axis

  !> Sets up the bodies with their unit weights.
  subroutine bodies_from_the_side(model, axis, overburden)
    type(model_type), intent(in) :: model
    !> Number of the vertical axis.
    integer, intent(in) :: axis
    type(overburden_type), intent(out) :: overburden
    real(wp), dimension(size(model%shapes)) :: unit_weight, saturated, young
    type(value_field_type), allocatable :: weights(:)
    logical, dimension(size(model%shapes)) :: active, yields, ground
    integer :: b

    active = bodies_active(model%analysis, model%state%progress%phase)
    allocate (weights(0))
    do b = 1, size(model%shapes)
      associate (material => model%analysis%materials(place_named(model%analysis%materials, &
          model%analysis%bodies(b)%material)))
        yields(b) = may_yield(material)
        young(b) = material%young
        unit_weight(b) = material%unit_weight
        saturated(b) = material%unit_weight
        if (material%saturated_weight >= 0.0_wp) saturated(b) = material%saturated_weight
        if (has_values(material%strength_profile%fields, field_weight)) weights = [weights, &
          field_as(material%strength_profile%fields, field_weight, b)]
      end associate
    end do
    call make_overburden(model%mesh, model%shapes, unit_weight, axis, overburden, saturated, &
      model%loading%water_final, active, merge(-1.0_wp, 1.0_wp, model%loading%gravity_final(axis) > 0.0_wp))
    if (size(weights) > 0) call move_alloc(weights, overburden%weights)
    ground = active .and. yields
    if (.not. any(ground)) ground = active .and. young < stiff*minval(young, active)
    overburden%structure = active .and. .not. (ground .or. is_as_wide(overburden%solid, ground))
  end subroutine bodies_from_the_side

  !> Returns whether bodies are as wide along the horizontal as the ground.
  pure function is_as_wide(solid, ground) result(wide)
    type(polyhedron_type), intent(in) :: solid(:)
    !> (bodies)
    logical, intent(in) :: ground(:)
    logical :: wide(size(solid))
    integer :: i

    wide = .true.
    do i = 1, 2
      wide = wide .and. solid%low(i) <= minval(solid%low(i), ground)
      wide = wide .and. solid%high(i) >= maxval(solid%high(i), ground)
    end do
  end function is_as_wide

  !> Returns the names of the structures in ground at rest, empty if there are none.
  function structures_at_rest(model) result(names)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: names
    type(overburden_type) :: overburden
    integer :: b

    call bodies_from_the_side(model, vertical_axis(model), overburden)
    names = ''
    do b = 1, size(overburden%structure)
      if (overburden%structure(b)) names = names//", '"//model%analysis%bodies(b)%name//"'"
    end do
    names = names(min(3, len(names) + 1):)
  end function structures_at_rest

  !> Returns the height of bodies above the ground level of a K0 start, 0 or less if there are none.
  real(wp) function reaches_above(model, initial) result(height)
    type(model_type), intent(in) :: model
    type(initial_stress_type), intent(in) :: initial
    type(overburden_type) :: overburden

    call bodies_from_the_side(model, vertical_axis(model), overburden)
    height = overburden%up*(ground_top(overburden) - initial%surface_level)
  end function reaches_above

  !> Rejects results of material at another place, and reads the state variables known to the laws of the model.
  subroutine check_initial_results(model, diagnostics)
    !> The model with its laws and points.
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics

    if (size(model%analysis%phases) == 0) return
    associate (initial => model%analysis%phases(1)%initial)
      if (.not. allocated(initial%part)) return
      call check_distances(model, initial, diagnostics)
      if (initial%takes_state) call read_states(model%laws, initial, diagnostics)
    end associate
  end subroutine check_initial_results

  !> Checks that every initially active material point has a point of the other run within a cell.
  subroutine check_distances(model, initial, diagnostics)
    type(model_type), intent(in) :: model
    type(initial_stress_type), intent(in) :: initial
    type(diagnostics_type), intent(inout) :: diagnostics
    type(point_bins_type) :: bins
    real(wp) :: distance, farthest, farthest_of_all
    character(len=:), allocatable :: place
    integer :: p, worst, rank

    call make_bins(initial%places, bins)
    farthest = 1.0_wp
    worst = 0
    associate (points => model%state%points)
      do p = 1, points%count
        if (.not. model%analysis%bodies(points%body(p))%active) cycle
        distance = norm2(initial%places(:, nearest_in_bins(bins, initial%places, points%position(:, p))) &
          - points%position(:, p))/cell_size(model%mesh, points%cell(p))
        if (.not. distance > farthest) cycle
        farthest = distance
        worst = p
      end do
      place = ''
      if (worst > 0) place = rounded_place(points%position(:, worst))
    end associate
    farthest_of_all = largest(model%part%team, farthest)
    rank = lowest_rank(model%part%team, worst > 0 .and. farthest >= farthest_of_all)
    if (rank == model%part%team%ranks) return
    call spread_text(model%part%team, rank, place)
    call add_diagnostic(diagnostics, initial%where, '*INITIAL', "'"//initial%file//"' has no material point within "// &
      'a cell of '//place//': that run had no material there; deactivate the body by ACTIVE=NO and activate it '// &
      'later, or give stresses by height')
  end subroutine check_distances

  !> Reads the state variables that exist in both runs.
  subroutine read_states(laws, initial, diagnostics)
    type(law_slot_type), intent(in) :: laws(:)
    type(initial_stress_type), intent(inout) :: initial
    type(diagnostics_type), intent(inout) :: diagnostics
    type(error_type), allocatable :: error
    real(wp), allocatable :: values(:)
    integer :: m, i, n

    allocate (initial%state_names(0), initial%state_at_places(0, size(initial%places, 2)))
    do m = 1, size(laws)
      if (.not. allocated(laws(m)%law%state_names)) cycle
      do i = 1, size(laws(m)%law%state_names)
        associate (name => laws(m)%law%state_names(i)%text)
          if (len(name) == 0 .or. word_place(initial%state_names, name) > 0) cycle
          call read_state_results(initial%part, name, values, initial%material_at_places, error)
          if (allocated(error)) then
            call add_diagnostic(diagnostics, initial%where, '*INITIAL', error%message)
            return
          end if
          if (.not. allocated(values)) cycle
          n = size(initial%state_names)
          initial%state_names = [initial%state_names, laws(m)%law%state_names(i)]
          initial%state_at_places = transpose(reshape([transpose(initial%state_at_places), values], &
            [size(values), n + 1]))
        end associate
      end do
    end do
    if (size(initial%state_names) == 0) call add_diagnostic(diagnostics, initial%where, '*INITIAL', &
      "'"//initial%file//"' has no state variable of the materials of this model: leave out STATE=YES")
  end subroutine read_states

  !> Sets the state variables from the nearest place, where the material has the same number.
  subroutine take_states(model, initial)
    type(model_type), intent(inout) :: model
    !> Initial stresses with their state variables.
    type(initial_stress_type), intent(in) :: initial
    type(point_bins_type) :: bins
    integer :: p, i, k, from

    call make_bins(initial%places, bins)
    associate (points => model%state%points)
      do p = 1, points%count
        from = nearest_in_bins(bins, initial%places, points%position(:, p))
        if (initial%material_at_places(from) /= points%material(p)) cycle
        associate (law => model%laws(points%material(p))%law)
          if (.not. allocated(law%state_names)) cycle
          do i = 1, size(law%state_names)
            k = word_place(initial%state_names, law%state_names(i)%text)
            if (k > 0) points%state(i, p) = initial%state_at_places(k, from)
          end do
        end associate
      end do
    end associate
  end subroutine take_states
end module qsmpm_initial_stress
