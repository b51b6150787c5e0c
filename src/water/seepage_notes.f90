!> Log messages of seepage: inflow and outflow at the parts of the boundary, hydraulic heave, and ground that has moved
!> relative to the mesh of its flow.
module qsmpm_seepage_notes
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: active_materials, body_materials
  use qsmpm_analysis, only: analysis_type
  use qsmpm_drainage, only: has_excess_pressure
  use qsmpm_free_water, only: beside_text, shore_text
  use qsmpm_load_description, only: water_level_type
  use qsmpm_model, only: model_type
  use qsmpm_retention, only: sharp_note
  use qsmpm_rounded_text, only: rounded_place, rounded_text
  use qsmpm_seepage, only: node_face, node_free, seepage_type
  use qsmpm_seepage_bounds, only: seepage_scene_type
  use qsmpm_team, only: largest
  use qsmpm_text, only: integer_text
  use qsmpm_undrained_parameters, only: drainage_none
  use qsmpm_vertical, only: upwards, vertical_of
  implicit none
  private

  public :: discharge, flow_notes, moved_note

  !> Round-off of a discharge relative to the sum of all flows.
  real(wp), parameter :: round_off = 1.0e-9_wp

contains

  !> Returns the notes on inflow and outflow of the rows of *WATER LEVEL and on hydraulic heave where water exits.
  function flow_notes(analysis, number, level, scene, flow) result(text)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number
    type(water_level_type), intent(in) :: level
    type(seepage_scene_type), intent(in) :: scene
    type(seepage_type), intent(in) :: flow
    character(len=:), allocatable :: text
    !> By the kind of model (plane strain, axisymmetry, 3D).
    character(len=*), parameter :: per(3) = [' and unit width', ' and radian    ', '               '], &
      cells(3) = [' triangles ', ' triangles ', ' tetrahedra']
    integer :: i

    text = "phase '"//analysis%phases(number)%name//"': water flows in by"
    do i = 1, size(level%heads)
      text = text//" '"//level%heads(i)%set//"' "//rounded_text(level%heads(i)%inflow, 4)//','
    end do
    text = text//' elsewhere '// &
      rounded_text(discharge(flow, scene%row == 0 .and. flow%kind == node_face), 4)// &
      ' (negative: out; a unit of time'//trim(per(analysis%model))//'); '//integer_text(size(flow%corner, 2))// &
      trim(cells(analysis%model))//', '//in_steps(flow%steps)// &
      integer_text(flow%iterations)//' iterations, '// &
      'suction over a height of '//rounded_text(flow%suction, 2)//new_line('a')
    if (flow%suction > flow%wanted) text = text//"warning: phase '"//analysis%phases(number)%name//"': the seepage "// &
      'analysis does not converge with suction over less than '//rounded_text(flow%suction, 2)//' ('// &
      rounded_text(flow%wanted, 2)//' is intended): too much water flows above the phreatic surface'//new_line('a')
    do i = 1, size(level%heads)
      if (scene%beside(i)) text = text//beside_text(analysis%phases(number)%name, level%heads(i)%set)
      if (scene%shore(i) > 0) text = text//shore_text(analysis%phases(number)%name, level%heads(i)%set, &
        scene%mesh%position(:, scene%shore(i)))
    end do
    if (level%transient) then
      text = text//sharp_note(analysis%phases(number)%name, flow%curve%alpha, [(maxval(flow%reach(flow%corner(:, i))), &
        i=1, size(flow%curve))])
    else
      text = text//sharp_note(analysis%phases(number)%name, flow%curve%alpha, spread(2.0_wp*flow%suction, 1, &
        size(flow%curve)))
    end if
    text = text//lift_note(analysis, number, level, scene, flow)
    if (level%transient) text = text//undrained_note(analysis, number)
  end function flow_notes

  !> Returns the warning of undrained soil with its own excess pressure in a transient flow; empty where there is none.
  function undrained_note(analysis, number) result(text)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number
    character(len=:), allocatable :: text
    integer :: material(size(analysis%bodies)), b

    text = ''
    material = active_materials(analysis, number)
    do b = 1, size(material)
      if (material(b) == 0) cycle
      if (.not. has_excess_pressure(analysis, material(b))) cycle
      associate (undrained => analysis%materials(material(b))%undrained)
        if (allocated(undrained%drainage)) then
          if (undrained%drainage(number) /= drainage_none) cycle
        end if
      end associate
      text = "warning: phase '"//analysis%phases(number)%name//"': water leaves body '"//analysis%bodies(b)%name// &
        "' in time, and its material is *UNDRAINED, which keeps an excess pressure in addition to that of the "// &
        'flow: use one of them (*DRAIN STATE drains it from a phase on)'//new_line('a')
      return
    end do
  end function undrained_note

  !> Returns the number of steps in time as text; empty for steady flow.
  pure function in_steps(steps) result(text)
    integer, intent(in) :: steps
    character(len=:), allocatable :: text

    text = ''
    if (steps > 0) text = 'at the end of the phase, after '//integer_text(steps)//' steps in time, '
  end function in_steps

  !> Inflow at some nodes; 0 where it is round-off of the other flows.
  pure real(wp) function discharge(flow, nodes)
    type(seepage_type), intent(in) :: flow
    logical, intent(in) :: nodes(:)

    discharge = sum(flow%inflow, mask=nodes)
    if (abs(discharge) <= round_off*sum(abs(flow%inflow))) discharge = 0.0_wp
  end function discharge

  !> Returns the warning of an upward exit gradient that lifts the soil; empty where there is none.
  function lift_note(analysis, number, level, scene, flow) result(text)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number
    type(water_level_type), intent(in) :: level
    type(seepage_scene_type), intent(in) :: scene
    type(seepage_type), intent(in) :: flow
    character(len=:), allocatable :: text
    integer :: material(size(analysis%bodies)), c, cell
    real(wp) :: gradient, critical, worst
    integer :: axis

    text = ''
    material = body_materials(analysis, number)
    axis = vertical_of(analysis)
    worst = 1.0_wp
    cell = 0
    do c = 1, size(scene%flows)
      if (.not. scene%flows(c)) cycle
      cell = cell + 1
      associate (node => flow%corner(:, cell))
        if (.not. any(flow%inflow(node) < 0.0_wp .and. flow%kind(node) /= node_free)) cycle
      end associate
      associate (soil => analysis%materials(material(scene%mesh%region(c))))
        ! An impermeable wall cannot be lifted by the exit gradient.
        if (.not. soil%permeability(1) > 0.0_wp) cycle
        critical = merge(soil%saturated_weight, soil%unit_weight, soil%saturated_weight >= 0.0_wp)/level%unit_weight &
          - 1.0_wp
        gradient = upwards(analysis)*flow%velocity(axis, cell)/flow%permeability(axis, cell)
      end associate
      if (.not. gradient > worst*critical) cycle
      worst = gradient/critical
      text = "warning: phase '"//analysis%phases(number)%name//"': water flows out upwards with a hydraulic "// &
        "gradient of "// &
        rounded_text(gradient, 3)//' at '//rounded_place(sum(flow%position(:, flow%corner(:, cell)), dim=2) &
        /size(flow%corner, 1))//', where '//rounded_text(critical, 3)//' is critical: piping starts there'// &
        new_line('a')
    end do
  end function lift_note

  !> Returns the warning of a phase whose flow was computed for the initial geometry and whose ground has moved by more
  !> than a cell since; empty where there is none.
  function moved_note(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    real(wp) :: way

    text = ''
    associate (phase => model%analysis%phases(model%state%progress%phase), points => model%state%points)
      if (.not. any(phase%water_levels%flows .and. .not. phase%water_levels%coupled)) return
      way = largest(model%part%team, maxval([0.0_wp, norm2(points%position - points%initial_position, dim=1)]))
      if (.not. way > model%cell_size) return
      text = "warning: phase '"//phase%name//"': seepage is computed for the initial geometry, and the ground has "// &
        'moved by '//rounded_text(way, 2)//' since, more than a cell: pore pressures there are inaccurate'// &
        new_line('a')
    end associate
  end function moved_note
end module qsmpm_seepage_notes
