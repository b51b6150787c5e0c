!> Consolidation: the phases in which pore water flows in time, the nodes at which it drains, pressures interpolated to
!> the material points, and the checks of a deck. The equations are in qsmpm_pore_flow.
!>
!> Water drains at exposed faces, where the mesh ends upwards, and at node sets that *CONSOLIDATION opens; the sides and
!> the base of the mesh and interfaces to impermeable soil are closed. docs/methods/consolidation.md
module qsmpm_consolidation
  use qsmpm_kinds, only: wp, pi
  use qsmpm_active_bodies, only: bodies_active, active_materials
  use qsmpm_agreement, only: any_of
  use qsmpm_analysis, only: analysis_type
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_element, only: corner_count, element_order, face_corners, face_count, linear_kind, &
    shape_functions
  use qsmpm_face_leak, only: constrained_modulus, front_within
  use qsmpm_free_surface, only: filling_pressure, is_in_air, nodes_within, rows_in_force
  use qsmpm_free_surface_check, only: check_free_surface
  use qsmpm_kept_arrays, only: is_kept, kept_values
  use qsmpm_load_description, only: consolidation_type, head_type
  use qsmpm_mesh_measure, only: cell_width
  use qsmpm_method_description, only: basis_fem
  use qsmpm_model, only: model_type
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_permeability_law, only: permeability_constant, permeability_words
  use qsmpm_phase_loads, only: consolidation_of, free_surface_of, has_consolidation
  use qsmpm_retention, only: curve_of, take_up
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_structures, only: contact_on_body
  use qsmpm_vertical, only: upwards, vertical_of
  implicit none
  private

  public :: permeable_points, excess_pressure, filled_pores, still_water_forces, drained_nodes, closed_note, &
    check_consolidation

  !> Name of the nodal field of the excess pore pressure.
  character(len=*), parameter, public :: excess_field = 'excess_pore_pressure'
  !> Quantities that are interpolated from the nodal pressure to the points.
  integer, parameter :: itself = 0, filling = 1, acting = 2
  !> Represents an adjacent permeability at nodes of faces with fixed pressure; at wells it is larger.
  real(wp), parameter :: at_face = 0.5_wp*huge(1.0_wp)

contains

  !> Marks the points whose material is permeable (points).
  pure function permeable_points(model) result(permeable)
    type(model_type), intent(in) :: model
    logical :: permeable(model%state%points%count)

    permeable = model%analysis%materials(model%state%points%material)%permeability(1) > 0.0_wp
  end function permeable_points

  !> Returns the excess pore pressure at the points; 0 where there is no such field (points).
  pure function excess_pressure(model) result(pressure)
    type(model_type), intent(in) :: model
    real(wp) :: pressure(model%state%points%count)
    real(wp) :: nodal(model%space%node_count)

    pressure = 0.0_wp
    if (.not. is_kept(model%state%kept, excess_field)) return
    nodal = reshape(kept_values(model%state%kept, excess_field), [model%space%node_count])
    pressure = at_points(model, nodal, merge(acting, itself, free_surface_of(model%analysis%phases, &
      model%state%progress%phase) > 0))
  end function excess_pressure

  !> Returns the degree of saturation of the pores under a free surface, 1 in impermeable material (points).
  pure function filled_pores(model) result(share)
    type(model_type), intent(in) :: model
    real(wp) :: share(model%state%points%count)
    real(wp) :: nodal(model%space%node_count)

    nodal = reshape(kept_values(model%state%kept, excess_field), [model%space%node_count])
    share = at_points(model, nodal, filling)
    where (.not. permeable_points(model)) share = 1.0_wp
  end function filled_pores

  !> Interpolates corner values of the cells to the points; 0 in impermeable material (points).
  pure function at_points(model, nodal, kind) result(values)
    type(model_type), intent(in) :: model
    !> Pressure (mesh nodes or more).
    real(wp), intent(in) :: nodal(:)
    !> The pressure itself, the degree of saturation under a free surface, or the pressure acting on the skeleton.
    integer, intent(in) :: kind
    real(wp) :: values(model%state%points%count)
    real(wp) :: shape(8), share(8), slope(8), suction(model%mesh%node_count)
    integer :: p, n, from

    from = consolidation_of(model%analysis%phases, model%state%progress%phase)
    if (kind /= itself) suction = filling_pressure(model)
    associate (mesh => model%mesh, points => model%state%points)
      do p = 1, points%count
        n = corner_count(mesh%cell_kind(points%cell(p)))
        associate (node => mesh%cell_nodes(mesh%cell_first(points%cell(p)):mesh%cell_first(points%cell(p)) + n - 1))
          call shape_functions(linear_kind(mesh%cell_kind(points%cell(p))), points%local(:, p), shape(:n))
          share = 1.0_wp
          if (kind /= itself) call take_up(curve_of(model%analysis%materials(points%material(p))%permeability_law, &
            model%analysis%phases(from)%consolidation%unit_weight), nodal(node), suction(node), share(:n), slope(:n))
          if (kind /= filling) share(:n) = share(:n)*nodal(node)
          values(p) = dot_product(shape(:n), share(:n))
        end associate
      end do
    end associate
    where (.not. permeable_points(model)) values = 0.0_wp
  end function at_points

  !> Returns the force of the pore water under a free surface on the points as if it were at rest, from the pressure at
  !> the start of the step: buoyancy of saturated ground, and weight of the water (dimension, points).
  pure function still_water_forces(model, gravity, buoyant) result(force)
    type(model_type), intent(in) :: model
    !> Current gravity (dimension).
    real(wp), intent(in) :: gravity(:)
    !> With buoyancy; otherwise the weight of the water alone.
    logical, intent(in) :: buoyant
    real(wp) :: force(size(gravity), model%state%points%count)
    real(wp) :: nodal(model%space%node_count), filled(model%state%points%count)
    integer :: from, p, axis

    force = 0.0_wp
    from = consolidation_of(model%analysis%phases, model%state%progress%phase)
    if (free_surface_of(model%analysis%phases, model%state%progress%phase) == 0) return
    nodal = reshape(kept_values(model%state%kept, excess_field), [model%space%node_count])
    filled = at_points(model, nodal, filling)
    axis = vertical_of(model%analysis)
    associate (points => model%state%points)
      do p = 1, points%count
        associate (soil => model%analysis%materials(points%material(p)))
          if (buoyant) force(axis, p) = filled(p)*points%volume(p)*upwards(model%analysis) &
            *model%analysis%phases(from)%consolidation%unit_weight
          if (soil%saturated_weight >= 0.0_wp) force(:, p) = force(:, p) + filled(p)*points%initial_volume(p) &
            *(soil%saturated_weight - soil%unit_weight)*gravity
        end associate
      end do
    end associate
  end function still_water_forces

  !> Marks the nodes at which water drains (mesh nodes).
  pure function drained_nodes(model, card) result(drained)
    type(model_type), intent(in) :: model
    type(consolidation_type), intent(in) :: card
    logical :: drained(model%mesh%node_count)
    logical, dimension(model%mesh%cell_count) :: wet, filled
    integer :: c, f, s, i

    drained = .false.
    filled = .false.
    wet = .false.
    filled(model%state%points%cell) = .true.
    wet(pack(model%state%points%cell, permeable_points(model))) = .true.
    associate (mesh => model%mesh)
      do c = 1, mesh%cell_count
        if (.not. wet(c)) cycle
        do f = 1, face_count(mesh%cell_kind(c))
          if (.not. is_in_air(model, filled, c, f)) cycle
          drained(mesh%cell_nodes(mesh%cell_first(c) - 1 + face_corners(mesh%cell_kind(c), f))) = .true.
        end do
      end do
      do i = 1, size(card%sets)
        do s = 1, size(mesh%node_sets)
          if (mesh%node_sets(s)%name == card%sets(i)%name) &
            drained(mesh%node_sets(s)%items) = .not. card%sets(i)%closed
        end do
      end do
    end associate
  end function drained_nodes

  !> Checks that *CONSOLIDATION is used with quadratic cells that move with the material and soil of known permeability.
  subroutine check_consolidation(model, diagnostics)
    !> Receives notes on phases in which the drainage front does not cross a cell.
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    logical :: checked(size(model%analysis%materials))
    character(len=:), allocatable :: way
    integer :: p

    call note_idle_laws(model)
    checked = .false.
    do p = 1, size(model%analysis%phases)
      associate (phase => model%analysis%phases(p))
        if (phase%consolidation%given .and. (model%analysis%method%basis /= basis_fem .or. &
          any(element_order(model%mesh%cell_kind) < 2))) then
          way = '*GRID without ELEMENT, no *METHOD'
          if (model%mesh%dimension == 3) way = '*GRID, ELEMENT=HEX20 with *METHOD, BASIS=FEM'
          call add_diagnostic(diagnostics, phase%consolidation%where, '*CONSOLIDATION', 'requires quadratic '// &
            'elements that move with the material: '//way//', and no body that is activated in its drawn shape or '// &
            'again: these use a fixed background grid')
        else if (phase%consolidation%given .and. any(model%analysis%contacts%place == contact_on_body)) then
          call add_diagnostic(diagnostics, phase%consolidation%where, '*CONSOLIDATION', 'does not support ON=BODY '// &
            'of *CONTACT: give the SURFACE of the soil beside the body')
        else if (phase%consolidation%given .and. phase%kind == phase_safety) then
          call add_diagnostic(diagnostics, phase%consolidation%where, '*CONSOLIDATION', "phase '"//phase%name// &
            "' is of TYPE=SAFETY, in which no time passes")
        else if (consolidation_of(model%analysis%phases, p) > 0) then
          call check_soil(model%analysis, p, checked, diagnostics)
          call check_free_surface(model, p, diagnostics)
          if (phase%kind /= phase_safety) model%notes = model%notes//front_notes(model, p)
        end if
      end associate
    end do
  end subroutine check_consolidation

  !> Returns the warning of a phase without drained boundary, else an empty text.
  function closed_note(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    character(len=*), parameter :: axes = 'xyz'
    integer :: up

    text = ''
    up = vertical_of(model%analysis)
    associate (number => model%state%progress%phase, phase => model%analysis%phases(model%state%progress%phase))
      if (.not. phase%consolidation%given .or. free_surface_of(model%analysis%phases, number) > 0) return
      if (any_of(model%part%team, any(drained_nodes(model, phase%consolidation)))) return
      text = "warning: *CONSOLIDATION of phase '"//phase%name//"': no boundary is drained. Drained are exposed "// &
        'faces, those at the top of the mesh along '//axes(up:up)//' (the axis of *GRAVITY), and the node sets of '// &
        'its data lines'//new_line('a')
    end associate
  end function closed_note

  !> Notes permeability laws of void ratio or suction that have no effect.
  subroutine note_idle_laws(model)
    type(model_type), intent(inout) :: model
    integer :: m, p

    do m = 1, size(model%analysis%materials)
      associate (soil => model%analysis%materials(m))
        if (soil%permeability_law%alpha > 0.0_wp .and. .not. any([(any(model%analysis%phases(p)%water_levels%flows), &
          p=1, size(model%analysis%phases))])) model%notes = model%notes//"material '"//soil%name//"': ALPHA of "// &
          '*PERMEABILITY has no effect without *WATER LEVEL, TYPE=SEEPAGE'//new_line('a')
        if (soil%permeability_law%kind == permeability_constant .or. has_consolidation(model%analysis%phases)) cycle
        model%notes = model%notes//"material '"//soil%name//"': LAW="// &
          trim(permeability_words(soil%permeability_law%kind))//' of *PERMEABILITY has no effect without '// &
          '*CONSOLIDATION: steady seepage takes that of the initial state'//new_line('a')
      end associate
    end do
  end subroutine note_idle_laws

  !> Returns the notes on soils that drain, in a phase, to nodes whose pressure falls instantaneously: next to soil of
  !> much larger permeability, given sufficient time, at open sets within the ground, and at faces of fixed pressure.
  !> Their cells there drain as a whole until the drainage front has crossed them.
  function front_notes(model, number) result(text)
    type(model_type), intent(in) :: model
    integer, intent(in) :: number
    character(len=:), allocatable :: text
    !> Relative errors of the outflow from which a note and a warning are given, and the largest that is reported.
    real(wp), parameter :: told = 0.05_wp, too_much = 0.5_wp, most = 9.0_wp, long = 1.0e6_wp
    !> Time relative to that of a cell (h^2/c) from which nothing is reported.
    real(wp), parameter :: crossed = 1.0_wp/(16.0_wp*told)
    logical :: active(size(model%analysis%bodies))
    real(wp), dimension(size(model%analysis%materials)) :: width, fast
    real(wp) :: beside(model%mesh%node_count, size(model%analysis%materials)), k, time, excess
    integer :: m, p, up

    text = ''
    up = vertical_of(model%analysis)
    active = bodies_active(model%analysis, number)
    beside = permeability_beside(model, number, active)
    width = 0.0_wp
    fast = 0.0_wp
    associate (points => model%state%points, mesh => model%mesh)
      do p = 1, points%count
        associate (c => points%cell(p), m => points%material(p))
          associate (corner => mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c) - 1 + &
              corner_count(mesh%cell_kind(c))))
            if (.not. (active(points%body(p)) .and. any(beside(corner, m) > 0.0_wp))) cycle
            width(m) = max(width(m), cell_width(mesh, c)*merge(sqrt(2.0_wp), 1.0_wp, size(corner) == 3))
            fast(m) = max(fast(m), maxval(beside(corner, m)))
          end associate
        end associate
      end do
    end associate
    do m = 1, size(width)
      associate (soil => model%analysis%materials(m), phase => model%analysis%phases(number))
        if (.not. (width(m) > 0.0_wp .and. soil%young > 0.0_wp .and. soil%permeability(up) > 0.0_wp)) cycle
        k = soil%permeability(up)/model%analysis%phases(consolidation_of(model%analysis%phases, number)) &
          %consolidation%unit_weight
        if (free_surface_of(model%analysis%phases, number) > 0 .and. fast(m) < huge(k) .and. &
          front_within(soil, k, width(m), phase%duration)) cycle
        if (fast(m) < at_face) then
          if (front_within(soil, k*fast(m)/soil%permeability(up), width(m), phase%duration)) cycle
        end if
        time = width(m)**2/(k*constrained_modulus(soil))
        time = min(phase%duration, long*time)/time
        excess = early_excess(time)
        if (.not. excess > told) cycle
        if (excess > too_much) text = text//'warning: '
        text = text//"phase '"//phase%name//"': '"//soil%name//"' drains to more permeable soil, to a node set "// &
          'within the ground or to a face of fixed pressure, in cells of '//rounded_text(width(m), 2)//' there, '// &
          'which the drainage front does not cross in the TIME: the outflow, and settlements due to it, may be '// &
          rounded_text(100.0_wp*min(excess, most), 2)//' % too large; use grid lines at a distance of '// &
          rounded_text(width(m)*sqrt(time/crossed), 2)//' there, or a longer phase'//new_line('a')
      end associate
    end do
  end function front_notes

  !> Returns, for nodes at which the pressure of a soil falls instantaneously, the permeability that causes it,
  !> unlimited at fixed pressure; 0 for others (mesh nodes, materials).
  pure function permeability_beside(model, number, active) result(beside)
    type(model_type), intent(in) :: model
    integer, intent(in) :: number
    !> Active bodies.
    logical, intent(in) :: active(:)
    real(wp) :: beside(model%mesh%node_count, size(model%analysis%materials))
    !> Ratio to the permeability of a soil above which the adjacent soil holds no pressure.
    real(wp), parameter :: much = 30.0_wp
    real(wp) :: fastest(model%mesh%node_count)
    logical, dimension(model%mesh%node_count) :: drained, inside, well
    logical :: filled(0:model%mesh%cell_count), held
    type(head_type), allocatable :: rows(:)
    integer :: c, f, m, p, up

    up = vertical_of(model%analysis)
    associate (card => model%analysis%phases(consolidation_of(model%analysis%phases, number))%consolidation)
      drained = drained_nodes(model, card)
      held = card%held .or. free_surface_of(model%analysis%phases, number) > 0
    end associate
    well = .false.
    allocate (rows(0))
    if (free_surface_of(model%analysis%phases, number) > 0) rows = rows_in_force(model%analysis%phases, number, 1.0_wp)
    do m = 1, size(rows)
      well(nodes_within(model, rows(m)%set)) = .true.
    end do
    inside = .true.
    filled = .false.
    fastest = 0.0_wp
    associate (points => model%state%points, mesh => model%mesh)
      do p = 1, points%count
        if (.not. active(points%body(p))) cycle
        c = points%cell(p)
        filled(c) = .true.
        associate (node => mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1))
          fastest(node) = max(fastest(node), model%analysis%materials(points%material(p))%permeability(up))
        end associate
      end do
      do c = 1, mesh%cell_count
        do f = 1, face_count(mesh%cell_kind(c))
          if (filled(c) .and. .not. filled(mesh%face_neighbour(f, c))) &
            inside(mesh%cell_nodes(mesh%cell_first(c) - 1 + face_corners(mesh%cell_kind(c), f))) = .false.
        end do
      end do
    end associate
    do m = 1, size(model%analysis%materials)
      beside(:, m) = merge(fastest, 0.0_wp, fastest > much*model%analysis%materials(m)%permeability(up))
      where (drained .and. (inside .or. held)) beside(:, m) = at_face
      where (well .and. inside) beside(:, m) = huge(1.0_wp)
    end do
  end function permeability_beside

  !> Relative error of the outflow from a half space with the face node held at p = 0, under a load that grows linearly
  !> in time; argument c t/h^2.
  pure real(wp) function early_excess(time) result(excess)
    real(wp), intent(in) :: time
    !> Up to this time the outflow is the share of the cell, h/12^1/2, over 4/3 (c t/pi)^1/2, and one half more.
    real(wp), parameter :: early = 0.02_wp

    excess = merge(sqrt(3.0_wp*pi/time)/8.0_wp + 0.5_wp, 1.0_wp/(16.0_wp*time), time < early)
  end function early_excess

  !> Checks that every body has a permeability and that its material is not *UNDRAINED too.
  subroutine check_soil(analysis, number, checked, diagnostics)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number
    !> Materials already checked.
    logical, intent(inout) :: checked(:)
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: material(size(analysis%bodies)), b

    material = active_materials(analysis, number)
    do b = 1, size(material)
      if (material(b) == 0) cycle
      if (checked(material(b))) cycle
      checked(material(b)) = .true.
      associate (soil => analysis%materials(material(b)), name => analysis%phases(number)%name)
        if (soil%permeability(1) < 0.0_wp) call add_diagnostic(diagnostics, soil%where, '*MATERIAL', &
          "body '"//analysis%bodies(b)%name//"' consolidates in phase '"//name//"', but material '"//soil%name// &
          "' has no *PERMEABILITY (0: impermeable)")
        if (soil%undrained%given) call add_diagnostic(diagnostics, soil%undrained_where, '*UNDRAINED', &
          "body '"//analysis%bodies(b)%name//"' consolidates in phase '"//name//"', which itself models undrained "// &
          'response in short times: remove the keyword')
      end associate
    end do
  end subroutine check_soil
end module qsmpm_consolidation
