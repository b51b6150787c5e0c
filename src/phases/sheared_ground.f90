!> Warnings about soil that has sheared far. Soil that has failed under the loads before a safety phase, and has reached
!> equilibrium in a deformed shape, is stable in that shape, with a factor above 1; the factor says nothing about the
!> initial geometry. The search may also take place on the background grid, after distortion of the body-fitted mesh.
!> Further warnings concern soil dilated beyond what is possible, and flow rules without a unique load at failure.
module qsmpm_sheared_ground
  use qsmpm_kinds, only: pi, wp
  use qsmpm_active_bodies, only: bodies_active, body_materials
  use qsmpm_background_in_use, only: is_at_start
  use qsmpm_kept_arrays, only: is_kept, kept_values
  use qsmpm_limit_load, only: fallen
  use qsmpm_mesh_measure, only: cell_width
  use qsmpm_method_description, only: basis_fem, basis_standard
  use qsmpm_model, only: model_type
  use qsmpm_nodal_fields, only: rate_of
  use qsmpm_own_part, only: own_of
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_phase_loads, only: waits
  use qsmpm_points, only: carries_strains
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_space, only: functions_at, shape_values_type, value_at
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_material_description, only: material_type, traits_of
  use qsmpm_strength_factor, only: flow_davis_a, flow_material, lower_strength, strength_factor_type
  use qsmpm_team, only: largest, smallest, total
  use qsmpm_undrained_parameters, only: is_undrained
  use qsmpm_vertical, only: vertical_of
  implicit none
  private

  public :: blurred_note, factor_note, fallen_note, flow_notes, loaded_spot_note, moved_note, sheared_note, spot_note, &
    swollen_note, worn_note

  !> Plastic shear strain of failed soil: stable soil has at most a tenth of it, even where it yields. Share of the
  !> volume that exceeds a corner or toe.
  real(wp), parameter :: flows = 0.1_wp, much = 2.0e-3_wp
  !> Plastic shear strain of failed soil whose law hardens: it shears by a tenth and more before the critical state.
  real(wp), parameter :: hardened = 0.3_wp
  !> Volume ratio that no soil reaches by dilation: loose sand grows by a tenth at most.
  real(wp), parameter :: swollen = 1.5_wp
  !> Plastic shear strain of failing soil, and ratio of tan(phi) after Davis below which it is reported.
  real(wp), parameter :: fails = 1.0e-2_wp, less = 0.95_wp
  !> Largest relative error times the number of cells of a load at failure or a factor, by functions that extend over
  !> three cells and smooth a slip surface.
  real(wp), parameter, public :: most_blur = 0.9_wp
  real(wp), parameter :: radian = pi/180.0_wp

contains

  !> Returns the warning where a search begins on such soil, or that this is not known; empty for stable soil.
  function sheared_note(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text

    text = ''
    if (.not. carries_strains(model%state%points)) then
      text = "warning: phase '"//model%analysis%phases(model%state%progress%phase)%name//"': whether the ground "// &
        'failed before the search is not known: its points carry no strains (*FIELD, STRAIN=YES)'
      return
    end if
    text = sheared_text(model)
    if (len(text) > 0) text = "warning: phase '"//model%analysis%phases(model%state%progress%phase)%name// &
      "': before the search "//text//': the ground failed under the loads of earlier phases and found equilibrium '// &
      'in a deformed shape'//way_text(model)//'. The factor is that of the deformed shape; in its initial geometry '// &
      'the ground may be unstable: `qsmpm-verify bounds DECK --phase PARENT --factor` shows it'//new_line('a')
  end function sheared_note

  !> Returns the warning where soil has failed and is in equilibrium in a deformed shape; otherwise empty, and where the
  !> phase requests its limit load.
  function fallen_note(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text, load, where
    real(wp) :: times

    text = ''
    associate (progress => model%state%progress, phase => model%analysis%phases(model%state%progress%phase))
      times = 0.0_wp
      if (progress%limit%first > 0.0_wp) times = progress%limit%most/progress%limit%first
      if (phase%kind == phase_safety .or. phase%controls%limit_compliance > 0.0_wp .or. .not. (times > fallen .or. &
        abs(progress%limit%passed) > 0.0_wp)) return
      ! Soil that drains or creeps moves without a load.
      if (waits(phase)) return
      if (.not. carries_strains(model%state%points)) return
      text = sheared_text(model)
      if (len(text) == 0) return
      load = rounded_text(phase%load_factor*abs(progress%limit%passed), 3)
      where = ', about load factor '//load//' on this grid by the compliance of the steps'
      if (.not. progress%limit%passed > 0.0_wp) where = ', above load factor '//load//', beyond which the '// &
        'background grid that has replaced the body-fitted mesh restrains the soil'
      text = "warning: phase '"//phase%name//"': "//text//', and the same load moved '// &
        'the ground up to '//rounded_text(times, 2)//' times as far as in the first step: the ground has '// &
        'failed, and is in equilibrium in a deformed shape'//way_text(model)//'. Its limit load is less than '// &
        'the load of the phase'//where//': `qsmpm-verify bounds DECK --phase NAME` gives bounds, '// &
        '*CONTROLS, LIMIT COMPLIANCE ends the phase there'//new_line('a')
    end associate
  end function fallen_note

  !> Returns the warning where a mechanism, given by the displacements of the points from their initial positions, is
  !> local.
  function spot_note(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text

    associate (points => model%state%points)
      text = spot_text(model, norm2(points%position - points%initial_position, dim=1), 'factor')
    end associate
  end function spot_note

  !> Returns the warning where the displacements of the last supported step below a limit load are local.
  function loaded_spot_note(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    real(wp) :: way(model%state%points%count)
    real(wp), allocatable :: rates(:, :)
    type(shape_values_type) :: place
    integer :: i

    text = ''
    if (.not. is_kept(model%state%kept, rate_of//'displacement')) return
    allocate (rates, source=kept_values(model%state%kept, rate_of//'displacement'))
    way = 0.0_wp
    associate (points => model%state%points)
      do i = 1, points%count
        if (points%cell(i) == 0) cycle
        call functions_at(model%space, model%mesh, points%cell(i), points%local(:, i), place)
        way(i) = norm2(value_at(place, rates))
      end do
    end associate
    text = spot_text(model, way, 'limit load')
  end function loaded_spot_note

  !> Returns the warning where few points in a corner of the soil move by over a tenth of the largest displacement.
  function spot_text(model, way, noun) result(text)
    type(model_type), intent(in) :: model
    !> Displacements of the points, and name of the result.
    real(wp), intent(in) :: way(:)
    character(len=*), intent(in) :: noun
    character(len=:), allocatable :: text
    integer, parameter :: few = 30
    real(wp) :: place(3), most, moves, whole
    logical, dimension(size(way)) :: own, far
    integer :: i

    text = ''
    associate (points => model%state%points, team => model%part%team, dimension => model%mesh%dimension)
      own = own_of(model%part%points, points%count)
      most = largest(team, maxval([0.0_wp, way]))
      far = own .and. way > 0.1_wp*most
      moves = total(team, sum(points%volume, mask=far))
      whole = total(team, sum(points%volume, mask=own))
      if (total(team, real(count(far), wp)) > few .or. moves > much*whole .or. .not. moves > 0.0_wp) return
      place = 0.0_wp
      place(:dimension) = [(total(team, sum(points%volume*points%position(i, :), mask=far)), i=1, dimension)]/moves
      text = "warning: phase '"//model%analysis%phases(model%state%progress%phase)%name//"': the mechanism "// &
        "involves "// &
        rounded_text(100.0_wp*moves/whole, 1)//' % of the ground, around ('//rounded_text(place(1))//', '// &
        rounded_text(place(2))//'): the '//noun//' is that of a local failure, at the edge of a load or at a face '// &
        'with hardly any cohesion; with more cohesion there, or a gradual edge of the load, it is that of the '// &
        'ground'//new_line('a')
    end associate
  end function spot_text

  !> Returns the note on a mechanism, given by the displacements of the points, that is only a few cells high where the
  !> functions extend over several cells and smooth its slip surface; empty otherwise.
  function blurred_note(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    !> Relative error of a factor times the number of cells, for a slope and a vertical cut; thresholds of a note and
    !> of a warning.
    real(wp), parameter :: excess(2) = [0.3_wp, most_blur], told = 0.05_wp, much_too_high = 0.1_wp
    real(wp) :: way(model%state%points%count), height(model%state%points%count), cells, sums(2), most
    logical :: far(model%state%points%count)
    integer :: p

    text = ''
    if (any(model%analysis%method%basis == [basis_fem, basis_standard])) return
    associate (points => model%state%points, team => model%part%team)
      way = norm2(points%position - points%initial_position, dim=1)
      far = own_of(model%part%points, points%count)
      most = largest(team, maxval([0.0_wp, pack(way, far)]))
      far = far .and. way > 0.1_wp*most
      height = points%position(vertical_of(model%analysis), :)
      sums = 0.0_wp
      do p = 1, points%count
        if (far(p)) sums = sums + points%volume(p)*[cell_width(model%mesh, points%cell(p)), 1.0_wp]
      end do
      sums = [total(team, sums(1)), total(team, sums(2))]
      if (.not. sums(1) > 0.0_wp) return
      most = largest(team, maxval(height, mask=far))
      cells = (most - smallest(team, minval(height, mask=far)))*sums(2)/sums(1)
    end associate
    cells = max(1.0_wp, anint(cells))
    if (excess(2) < told*cells) return
    if (excess(2) >= much_too_high*cells) text = 'warning: '
    text = text//"phase '"//model%analysis%phases(model%state%progress%phase)%name//"': the mechanism is "// &
      rounded_text(cells)//' cells high, and functions that extend over three cells smooth its slip surface: the '// &
      'factor is about '//rounded_text(100.0_wp*excess(1)/cells, 1)//' to '// &
      rounded_text(100.0_wp*excess(2)/cells, 1)//' % too high (docs/methods/safety.md); use smaller cells, or in '// &
      'plane models a body-fitted mesh (*GRID without ELEMENT)'//new_line('a')
  end function blurred_note

  !> Returns a text on the volume and amount of sheared soil; empty for stable soil.
  function sheared_text(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    logical :: own(model%state%points%count)
    real(wp) :: sheared, whole, most
    real(wp), dimension(model%state%points%count) :: strain, stands
    logical :: hardens(size(model%analysis%materials))
    integer :: m

    text = ''
    hardens = [(hardens_first(model%analysis%materials(m)), m=1, size(hardens))]
    associate (points => model%state%points, team => model%part%team)
      stands = merge(hardened, flows, hardens(points%material))
      own = own_of(model%part%points, points%count)
      ! Soil in confined compression between its neighbours shears by 2 over the root of 3 times its compression,
      ! without failing.
      strain = points%plastic_strain + 2.0_wp/sqrt(3.0_wp)*log(min(1.0_wp, points%volume/points%initial_volume))
      sheared = total(team, sum(points%volume, mask=own .and. strain > stands))
      whole = total(team, sum(points%volume, mask=own))
      most = largest(team, maxval([0.0_wp, pack(strain, own)]))
    end associate
    if (sheared > much*whole) text = 'soil has sheared by up to '//rounded_text(most, 2)//', '// &
      rounded_text(100.0_wp*sheared/whole, 2)//' % of it by more than '//rounded_text(flows, 2)
    if (len(text) > 0 .and. any(hardens)) text = text//' ('//rounded_text(hardened, 2)//' where its law hardens)'
  end function sheared_text

  !> Returns whether a soil hardens before failure.
  logical function hardens_first(soil)
    type(material_type), intent(in) :: soil
    type(law_description_type) :: traits

    hardens_first = allocated(soil%soil_law)
    if (.not. hardens_first) return
    traits = soil%soil_law%describe()
    hardens_first = .not. traits%failure_ties_volume
  end function hardens_first

  !> Returns a text on the largest displacement of the soil.
  function way_text(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text

    associate (points => model%state%points)
      text = ', up to '//rounded_text(largest(model%part%team, maxval([0.0_wp, pack(norm2(points%position - &
        points%initial_position, dim=1), own_of(model%part%points, points%count))])), 2)//' away'
    end associate
  end function way_text

  !> Returns the warning where a search begins on the background grid that replaced the mesh; otherwise empty.
  pure function worn_note(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text

    text = ''
    if (.not. allocated(model%analysis%backgrounds) .or. is_at_start(model)) return
    text = "warning: phase '"//model%analysis%phases(model%state%progress%phase)%name//"' determines its factor "// &
      'with splines on the background grid, since the body-fitted mesh had become too distorted: 8 to 26 % too '// &
      'high on ten cells a height, 1 to 5 % on forty (docs/methods/fitted.md); either the ground has failed, or '// &
      'a finer *GRID keeps the mesh'
  end function worn_note

  !> Returns the warning of yielding soil whose volume has increased by half and more; empty where there is none.
  function swollen_note(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    real(wp) :: ratio(model%state%points%count), most
    logical :: cracks(size(model%analysis%materials))

    text = ''
    ! Soil that shears at constant volume can only dilate by cracks: at its tensile strength or at the apex of its yield
    ! surface.
    cracks = model%analysis%materials%mohr_coulomb .and. .not. model%analysis%materials%dilatancy_angle > 0.0_wp
    associate (points => model%state%points)
      ratio = merge(points%volume/points%initial_volume, 1.0_wp, points%plastic > 0)
      most = largest(model%part%team, maxval([1.0_wp, pack(ratio, .not. cracks(points%material))]))
      if (most > swollen) text = begin()//'shearing soil has dilated to '//rounded_text(most, 3)//' times its '// &
        'volume: dilatancy is unlimited in this law, and the heave beside a load acts as a surcharge; '// &
        'take a smaller dilatancy angle, 0 for large displacements'//new_line('a')
      most = largest(model%part%team, maxval([1.0_wp, pack(ratio, cracks(points%material))]))
      if (most > swollen) text = text//begin()//'cracks have opened soil to '//rounded_text(most, 3)//' times its '// &
        'volume: its tensile strength is too small for it to stay in one piece there'//new_line('a')
    end associate
  contains
    !> Returns the first part of the warning.
    function begin() result(words)
      character(len=:), allocatable :: words

      words = "warning: phase '"//model%analysis%phases(model%state%progress%phase)%name//"': "
    end function begin
  end function swollen_note

  !> Returns a line for each material that fails with psi far below phi: the strengths between which its loads are
  !> (Davis 1968).
  function flow_notes(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    character(len=:), allocatable :: way
    type(law_description_type) :: law
    logical, dimension(model%state%points%count) :: of_soil
    real(wp) :: cohesion, friction, failed, whole
    integer :: m

    text = ''
    if (.not. carries_strains(model%state%points)) return
    if (model%analysis%phases(model%state%progress%phase)%kind == phase_safety) return
    do m = 1, size(model%analysis%materials)
      associate (soil => model%analysis%materials(m), points => model%state%points, team => model%part%team)
        if (.not. flows_otherwise(soil, model%state%progress%phase, law, cohesion, friction)) cycle
        of_soil = own_of(model%part%points, points%count) .and. points%material == m
        failed = total(team, sum(points%volume, mask=of_soil .and. points%plastic_strain > fails))
        whole = total(team, sum(points%volume, mask=of_soil))
        if (.not. failed > much*whole) cycle
        if (law%friction_angle > 0.0_wp) then
          way = 'runs with psi = phi and with phi = psi = '//rounded_text(friction, 3)//', c = '// &
            rounded_text(cohesion, 3)//' (Davis) show'
        else
          way = 'one with FLOW=ASSOCIATED shows'
        end if
        text = text//"material '"//soil%name//"' fails and "//flow_text(law)//': its limit load is not unique; '// &
          way//' the range'//new_line('a')
      end associate
    end do
  end function flow_notes

  !> Returns whether a soil flows with psi far below phi, and its strength after Davis (1968); the strength of rock is a
  !> curve.
  logical function flows_otherwise(soil, phase, law, cohesion, friction)
    type(material_type), intent(in) :: soil
    !> Number of the phase.
    integer, intent(in) :: phase
    type(law_description_type), intent(out) :: law
    real(wp), intent(out) :: cohesion, friction
    real(wp) :: dilatancy

    law = traits_of(soil)
    cohesion = law%cohesion
    friction = law%friction_angle
    dilatancy = law%dilatancy_angle
    flows_otherwise = .not. (law%associated_flow .or. is_undrained(soil%undrained, phase))
    if (.not. (flows_otherwise .and. friction > 0.0_wp)) return
    call lower_strength(strength_factor_type(flow=flow_davis_a), cohesion, friction, dilatancy)
    flows_otherwise = friction < less*law%friction_angle
  end function flows_otherwise

  !> Returns a text on the flow of such a soil.
  pure function flow_text(law) result(text)
    type(law_description_type), intent(in) :: law
    character(len=:), allocatable :: text

    text = ' far below its friction'
    if (law%friction_angle > 0.0_wp) text = ' below phi = '//rounded_text(law%friction_angle, 3)
    text = 'flows at psi = '//rounded_text(law%dilatancy_angle, 3)//text
  end function flow_text

  !> Returns the note that the ground has moved so far that the factor of safety is that of another shape: a slope that
  !> settles by 1 % of the height of the ground has a factor about 2 % higher. Empty otherwise.
  function moved_note(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    !> Displacement from which it is given, relative to the height of the ground.
    real(wp), parameter :: far = 0.01_wp
    real(wp) :: way, height

    text = ''
    associate (points => model%state%points, team => model%part%team)
      associate (own => own_of(model%part%points, points%count), up => points%position(vertical_of(model%analysis), :))
        way = largest(team, maxval([0.0_wp, pack(norm2(points%position - points%initial_position, dim=1), own)]))
        height = largest(team, maxval(up, mask=own)) - smallest(team, minval(up, mask=own))
      end associate
    end associate
    if (way > far*height) text = 'the factor is that of the deformed ground, which has moved by up to '// &
      rounded_text(way, 3)//', '//rounded_text(100.0_wp*way/height, 2)//' % of its height: in the geometry of '// &
      'the deck it may be lower by some per cent; stiffer soil shows it'
  end function moved_note

  !> Returns a note on the soil because of whose flow rule the factor of safety is not unique, with the lowest value
  !> after Davis (1968); empty where there is none. His factor is b times that of associated flow, which is not below
  !> the one found.
  function factor_note(model, flow) result(text)
    type(model_type), intent(in) :: model
    !> Flow rule of the search.
    integer, intent(in) :: flow
    character(len=:), allocatable :: text
    type(law_description_type) :: law
    real(wp) :: cohesion, friction, b
    logical :: otherwise
    integer :: m, number

    text = ''
    b = 1.0_wp
    number = model%state%progress%phase
    if (flow /= flow_material) return
    do m = 1, size(model%analysis%materials)
      associate (soil => model%analysis%materials(m))
        if (.not. any(bodies_active(model%analysis, number) .and. body_materials(model%analysis, number) == m)) cycle
        otherwise = flows_otherwise(soil, number, law, cohesion, friction)
        if (law%friction_angle > 0.0_wp) b = min(b, tan(radian*friction)/tan(radian*law%friction_angle))
        if (otherwise .and. len(text) == 0) text = "'"//soil%name//"' "//flow_text(law)// &
          ': the factor is then not unique'
      end associate
    end do
    if (len(text) > 0 .and. b < 1.0_wp) text = text//'; after Davis it may be as low as '// &
      rounded_text(b*model%state%progress%bracket%stable, 4)//', which FLOW=DAVIS A of *SAFETY computes'
  end function factor_note
end module qsmpm_sheared_ground
