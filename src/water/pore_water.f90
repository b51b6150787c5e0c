!> Pore water at rest or in steady flow (qsmpm_seepage): its pressure at the material points and the force that it
!> exerts on them.
!>
!>   u = gamma_w |g| max(0, level - y)
!>   f = V_0 gamma_w |g| e_up s - V gamma_w |g| grad(level) s  +  V_0 (gamma_sat - gamma) g s         per material point
!>
!> with s the share of the point's box below the level. The laws use effective stresses only; their divergence is
!> balanced by weight and -grad u. The integral of u over the body and the water pressure on its outline, where u is
!> continuous, together give the force above, so that no cut cell and no face is integrated. The vertical term uses the
!> initial volume, as the weight does: soil from which water is squeezed loses weight and buoyancy of that water
!> together, so that V_0 (gamma_sat - gamma_w) remains at any strain.
!>
!> Levels are those of the previous phase at the start of a phase and its own at the end; pressure and force are
!> interpolated linearly between them. docs/methods/water.md.
module qsmpm_pore_water
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_active_bodies, only: bodies_active
  use qsmpm_consolidation, only: excess_field, excess_pressure, filled_pores
  use qsmpm_element, only: corner_count
  use qsmpm_free_surface, only: filling_pressure
  use qsmpm_kept_arrays, only: keep_values, kept_values
  use qsmpm_load_description, only: head_type, water_level_type
  use qsmpm_phase_description, only: phase_type
  use qsmpm_method_description, only: basis_fem
  use qsmpm_model, only: model_type
  use qsmpm_phase_loads, only: consolidation_of, free_surface_of, has_consolidation
  use qsmpm_phase_tree, only: lineage, parent_of
  use qsmpm_points, only: carries_water
  use qsmpm_undrained_law, only: excess_pressure_name
  use qsmpm_vertical, only: upwards, vertical_of
  use qsmpm_water_table, only: water_table_type, head_at, level_at, rise_of, submerged_share
  implicit none
  private

  public :: has_water, has_pore_pressure, dry_tables, take_levels, levels_in_force, water_forces, &
    steady_pressure, update_pore_pressure, discharge_in, has_inflow, begin_free_surface, half_size

contains

  !> Checks whether any phase has a water level.
  pure logical function has_water(analysis)
    type(analysis_type), intent(in) :: analysis
    integer :: p

    has_water = any([(size(analysis%phases(p)%water_levels) > 0, p=1, size(analysis%phases))])
  end function has_water

  !> Checks whether pore pressures can occur: a water level, consolidation, or a law with excess pressure.
  pure logical function has_pore_pressure(model)
    type(model_type), intent(in) :: model
    integer :: m

    has_pore_pressure = has_water(model%analysis) .or. has_consolidation(model%analysis%phases) .or. &
      any([(model%laws(m)%law%state_place(excess_pressure_name) > 0, m=1, size(model%laws))])
  end function has_pore_pressure

  !> Returns the inflow at a part of the boundary in a phase from the flow in force; 0 without one.
  pure real(wp) function discharge_in(analysis, number, name) result(discharge)
    type(analysis_type), intent(in) :: analysis
    !> Number of the phase.
    integer, intent(in) :: number
    !> The node set or surface of a row of *WATER LEVEL, TYPE=SEEPAGE.
    character(len=*), intent(in) :: name
    integer, allocatable :: line(:)
    integer :: i, k

    discharge = 0.0_wp
    allocate (line, source=lineage(analysis%phases, number))
    do i = 1, size(line)
      associate (levels => analysis%phases(line(i))%water_levels)
        do k = 1, size(levels)
          if (len(levels(k)%body) == 0) discharge = 0.0_wp
          if (levels(k)%flows) discharge = discharge + sum(levels(k)%heads%inflow, mask=is_named(levels(k)%heads, name))
        end do
      end associate
    end do
  end function discharge_in

  !> Checks whether a part of the boundary has this name.
  elemental logical function is_named(head, name)
    type(head_type), intent(in) :: head
    character(len=*), intent(in) :: name

    is_named = head%set == name
  end function is_named

  !> Checks whether any flow has a level at a part of the boundary.
  pure logical function has_inflow(analysis, name)
    type(analysis_type), intent(in) :: analysis
    character(len=*), intent(in) :: name
    integer :: p, k

    has_inflow = .false.
    do p = 1, size(analysis%phases)
      do k = 1, size(analysis%phases(p)%water_levels)
        associate (level => analysis%phases(p)%water_levels(k))
          if (level%flows) has_inflow = has_inflow .or. any(is_named(level%heads, name))
        end associate
      end do
    end do
  end function has_inflow

  !> Initialises the tables without water in any body.
  pure subroutine dry_tables(analysis, tables)
    type(analysis_type), intent(in) :: analysis
    !> (bodies)
    type(water_table_type), allocatable, intent(out) :: tables(:)

    allocate (tables(size(analysis%bodies)))
    tables%axis = vertical_of(analysis)
    tables%across = merge(2, 1, tables%axis == 1)
    tables%up = upwards(analysis)
  end subroutine dry_tables

  !> Finds the levels at the end of a phase.
  pure subroutine levels_in_force(analysis, number, tables)
    type(analysis_type), intent(in) :: analysis
    !> Number of the phase; 0 for none.
    integer, intent(in) :: number
    !> (bodies)
    type(water_table_type), allocatable, intent(out) :: tables(:)
    integer, allocatable :: path(:)
    integer :: k

    call dry_tables(analysis, tables)
    allocate (path, source=lineage(analysis%phases, number))
    do k = 1, size(path)
      call take_levels(analysis, analysis%phases(path(k)), tables)
    end do
  end subroutine levels_in_force

  !> Applies the levels of a phase: the general level to bodies without one of their own, then those of single bodies.
  pure subroutine take_levels(analysis, phase, tables)
    type(analysis_type), intent(in) :: analysis
    type(phase_type), intent(in) :: phase
    !> (bodies)
    type(water_table_type), intent(inout) :: tables(:)
    integer :: i, b, turn

    do turn = 1, 2
      do i = 1, size(phase%water_levels)
        associate (level => phase%water_levels(i))
          if ((len(level%body) == 0) .neqv. turn == 1) cycle
          do b = 1, size(tables)
            if (turn == 2 .and. analysis%bodies(b)%name == level%body) tables(b)%own = .true.
            if (turn == 1 .and. .not. tables(b)%own) call give_level(level, tables(b))
            if (turn == 2 .and. analysis%bodies(b)%name == level%body) call give_level(level, tables(b))
          end do
        end associate
      end do
    end do
  end subroutine take_levels

  !> Converts a level into a table.
  pure subroutine give_level(level, table)
    type(water_level_type), intent(in) :: level
    type(water_table_type), intent(inout) :: table

    if (allocated(table%field)) deallocate (table%field)
    table%present = .not. (level%none .or. level%coupled)
    if (.not. table%present) return
    table%unit_weight = level%unit_weight
    if (allocated(level%field)) table%field = level%field
    table%x = level%line(1, :)
    table%height = level%line(2, :)
  end subroutine give_level

  !> Computes the force of the water on the material points at a load fraction, with their additional saturated weight.
  pure subroutine water_forces(model, fraction, force)
    type(model_type), intent(in) :: model
    !> Load fraction, 0 to 1.
    real(wp), intent(in) :: fraction
    !> (dimension, points); unallocated without water.
    real(wp), allocatable, intent(out) :: force(:, :)
    integer :: p, b, d

    associate (load => model%loading, points => model%state%points)
      if (.not. allocated(load%water_start)) return
      if (.not. (any(load%water_start%present) .or. any(load%water_final%present))) return
      d = model%mesh%dimension
      allocate (force(d, points%count))
      do p = 1, points%count
        b = points%body(p)
        force(:, p) = (1.0_wp - fraction)*force_at(model, p, load%water_start(b), load%gravity_start(:d)) &
          + fraction*force_at(model, p, load%water_final(b), load%gravity_final(:d))
      end do
    end associate
  end subroutine water_forces

  !> Force of the water on a point under one level and gravity.
  pure function force_at(model, p, table, gravity) result(force)
    type(model_type), intent(in) :: model
    !> Number of the point.
    integer, intent(in) :: p
    type(water_table_type), intent(in) :: table
    !> (dimension)
    real(wp), intent(in) :: gravity(:)
    real(wp) :: force(size(gravity))
    real(wp) :: share, weight

    force = 0.0_wp
    associate (points => model%state%points, material => model%analysis%materials(model%state%points%material(p)))
      share = submerged_share(table, points%position(:, p), half_size(model, p, table%axis))
      if (.not. share > 0.0_wp) return
      weight = table%unit_weight*abs(gravity(table%axis))
      if (material%saturated_weight >= 0.0_wp) &
        force = share*points%initial_volume(p)*(material%saturated_weight - material%unit_weight)*gravity
      force(table%axis) = force(table%axis) + share*points%initial_volume(p)*table%up*weight
      force = force - share*points%volume(p)*table%up*weight*rise_of(table, points%position(:, p), &
        half_size(model, p, table%across))
    end associate
  end function force_at

  !> Half the size of the box of a point along an axis; in body-fitted cells it is limited to the cell.
  pure real(wp) function half_size(model, p, axis) result(half)
    type(model_type), intent(in) :: model
    !> Number of the point, and of the axis.
    integer, intent(in) :: p, axis

    half = model%state%points%half_size(axis, p)
    if (model%analysis%method%basis /= basis_fem) return
    associate (mesh => model%mesh, c => model%state%points%cell(p), y => model%state%points%position(axis, p))
      associate (corners => mesh%coordinates(axis, mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1)))
        half = max(0.0_wp, min(half, y - minval(corners), maxval(corners) - y))
      end associate
    end associate
  end function half_size

  !> Current hydrostatic or steady-flow pressure at a point.
  pure real(wp) function steady_pressure(model, p) result(pressure)
    type(model_type), intent(in) :: model
    !> Number of the point.
    integer, intent(in) :: p

    pressure = 0.0_wp
    associate (load => model%loading, points => model%state%points)
      if (.not. allocated(load%water_start)) return
      associate (start => load%water_start(points%body(p)), final => load%water_final(points%body(p)))
        pressure = (1.0_wp - model%state%progress%fraction) &
          *start%unit_weight*abs(load%gravity_start(start%axis))*head_at(start, points%position(:, p)) &
          + model%state%progress%fraction &
          *final%unit_weight*abs(load%gravity_final(final%axis))*head_at(final, points%position(:, p))
      end associate
    end associate
  end function steady_pressure

  !> Initialises consolidation under a free surface: the former water pressure plus the excess pressure. Suction follows
  !> from the height above the surface, or above the base of the mesh, with the linear law down to twice the suction
  !> that empties the pores. Activated bodies are dry; with a curve their suction is 2/alpha.
  pure subroutine begin_free_surface(model)
    type(model_type), intent(inout) :: model
    real(wp) :: nodal(model%space%node_count), pressure(model%mesh%node_count), suction(model%mesh%node_count), level, &
      weight
    logical :: stays(size(model%analysis%bodies)), given(model%mesh%node_count)
    type(water_table_type), allocatable :: tables(:)
    integer :: i, p, axis, before

    associate (phases => model%analysis%phases, number => model%state%progress%phase, mesh => model%mesh)
      if (free_surface_of(phases, number) == 0) return
      axis = vertical_of(model%analysis)
      before = parent_of(phases, number)
      weight = phases(consolidation_of(phases, number))%consolidation%unit_weight
      suction = filling_pressure(model)
      pressure = -2.0_wp*suction
      given = .false.
      call levels_in_force(model%analysis, before, tables)
      stays = bodies_active(model%analysis, before)
      nodal = reshape(kept_values(model%state%kept, excess_field), shape(nodal))
      do p = 1, model%state%points%count
        associate (c => model%state%points%cell(p), table => tables(model%state%points%body(p)), &
            alpha => model%analysis%materials(model%state%points%material(p))%permeability_law%alpha)
          do i = mesh%cell_first(c), mesh%cell_first(c) + corner_count(mesh%cell_kind(c)) - 1
            associate (a => mesh%cell_nodes(i))
              if (given(a)) cycle
              if (.not. stays(model%state%points%body(p))) then
                if (alpha > 0.0_wp) pressure(a) = min(pressure(a), -2.0_wp*weight/alpha)
                cycle
              end if
              given(a) = .true.
              pressure(a) = nodal(a)
              if (free_surface_of(phases, before) > 0) cycle
              level = table%up*minval(table%up*mesh%coordinates(axis, :))
              if (table%present) level = level_at(table, mesh%coordinates(:, a))
              pressure(a) = nodal(a) + table%up*weight*(level - mesh%coordinates(axis, a))
              if (.not. alpha > 0.0_wp) pressure(a) = max(pressure(a), -2.0_wp*suction(a))
            end associate
          end do
        end associate
      end do
      call keep_values(model%state%kept, excess_field, reshape(pressure, [1, size(pressure)]))
    end associate
  end subroutine begin_free_surface

  !> Updates the pore pressures at the current positions and load of the material points, where they are stored.
  pure subroutine update_pore_pressure(model)
    type(model_type), intent(inout) :: model
    integer :: place(size(model%laws)), p, m
    real(wp) :: excess(model%state%points%count)

    if (.not. carries_water(model%state%points)) return
    excess = excess_pressure(model)
    place = [(model%laws(m)%law%state_place(excess_pressure_name), m=1, size(model%laws))]
    associate (points => model%state%points)
      do p = 1, points%count
        m = place(points%material(p))
        points%steady_pore_pressure(p) = steady_pressure(model, p) + excess(p)
        points%pore_pressure(p) = points%steady_pore_pressure(p)
        if (m > 0) points%pore_pressure(p) = points%pore_pressure(p) + points%state(m, p)
        points%pore_state(:, p) = [points%pore_pressure(p) - steady_pressure(model, p), filled_share_at(model, p)]
      end do
      if (free_surface_of(model%analysis%phases, model%state%progress%phase) == 0) return
      points%pore_state(1, :) = 0.0_wp
      points%pore_state(2, :) = filled_pores(model)
    end associate
  end subroutine update_pore_pressure

  !> Current share of a point's pores below the levels; 1 without a level.
  pure real(wp) function filled_share_at(model, p) result(share)
    type(model_type), intent(in) :: model
    !> Number of the point.
    integer, intent(in) :: p

    share = 1.0_wp
    associate (load => model%loading, points => model%state%points, f => model%state%progress%fraction)
      if (.not. allocated(load%water_start)) return
      associate (start => load%water_start(points%body(p)), final => load%water_final(points%body(p)))
        if (start%present .or. final%present) share = (1.0_wp - f)*share_below(start) + f*share_below(final)
      end associate
    end associate

  contains

    !> Share below one level; without a level the pores count as saturated.
    pure real(wp) function share_below(table)
      type(water_table_type), intent(in) :: table

      share_below = 1.0_wp
      if (table%present) share_below = submerged_share(table, model%state%points%position(:, p), &
        half_size(model, p, table%axis))
    end function share_below
  end function filled_share_at
end module qsmpm_pore_water
