!> Pore pressure at the places of a contact, where it is an unknown of consolidating soil. Friction acts on the
!> effective normal stress, the pressure of the contact less
!>
!>   w = sum A_s M_a(x_s) S_a p_a/A
!>
!> with the functions M of the pressure, and the degree of saturation S under a free surface (1 otherwise).
!> docs/methods/contact.md
module qsmpm_contact_water
  use qsmpm_kinds, only: wp
  use qsmpm_consolidation, only: excess_field, permeable_points
  use qsmpm_element, only: corner_count, linear_kind, shape_functions
  use qsmpm_free_surface, only: filling_pressure
  use qsmpm_kept_arrays, only: kept_values
  use qsmpm_model, only: model_type
  use qsmpm_phase_loads, only: consolidation_of, free_surface_of
  use qsmpm_retention, only: curve_of, curve_type, take_up
  use qsmpm_unknowns, only: find_field, joint_node, unknowns_type
  implicit none
  private

  public :: contact_water_type, see_contact_water, water_at

  type :: contact_water_type
    !> There is a free surface.
    logical :: total = .false.
    !> Columns of the corner pressures in the table of unknowns, 0 for none, functions M, pressures at the start of the
    !> step and suctions at which pores are empty (corners, places).
    integer, allocatable :: column(:, :)
    real(wp), allocatable :: shape(:, :), kept(:, :), suction(:, :)
    !> (places)
    type(curve_type), allocatable :: curve(:)
  end type contact_water_type

contains

  !> Evaluates the functions of the pressure at surface points next to permeable soil.
  subroutine see_contact_water(model, unknowns, point, water)
    type(model_type), intent(in) :: model
    type(unknowns_type), intent(in) :: unknowns
    !> Surface point of each place, 0 on the outline of a body, where there is no field (places).
    integer, intent(in) :: point(:)
    type(contact_water_type), intent(out) :: water
    real(wp) :: kept(model%mesh%node_count), suction(model%mesh%node_count)
    integer :: material(model%mesh%cell_count), from, field, k, n

    from = consolidation_of(model%analysis%phases, model%state%progress%phase)
    allocate (water%column(8, size(point)), source=0)
    allocate (water%shape(8, size(point)), source=0.0_wp)
    allocate (water%curve(size(point)))
    water%kept = water%shape
    water%suction = water%shape + 1.0_wp
    if (from == 0) return
    water%total = free_surface_of(model%analysis%phases, model%state%progress%phase) > 0
    field = find_field(unknowns, excess_field)
    kept = reshape(kept_values(model%state%kept, excess_field), shape(kept))
    suction = filling_pressure(model)
    material = 0
    associate (points => model%state%points, surface => model%state%surface, mesh => model%mesh)
      material(pack(points%cell, permeable_points(model))) = pack(points%material, permeable_points(model))
      do k = 1, size(point)
        if (point(k) == 0) cycle
        associate (c => surface%cell(point(k)))
          if (material(c) == 0) cycle
          n = corner_count(mesh%cell_kind(c))
          associate (node => mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c) + n - 1))
            call shape_functions(linear_kind(mesh%cell_kind(c)), surface%local(:, point(k)), water%shape(:n, k))
            water%column(:n, k) = joint_node(unknowns, node, field)
            water%kept(:n, k) = kept(node)
            water%suction(:n, k) = suction(node)
          end associate
          water%curve(k) = curve_of(model%analysis%materials(material(c))%permeability_law, &
            model%analysis%phases(from)%consolidation%unit_weight)
        end associate
      end do
    end associate
  end subroutine see_contact_water

  !> Returns the pore pressure at a place, which acts on the skeleton, and its derivatives.
  pure subroutine water_at(water, k, pressure, by_column, table)
    type(contact_water_type), intent(in) :: water
    !> Number of the place.
    integer, intent(in) :: k
    real(wp), intent(out) :: pressure
    !> (corners)
    real(wp), intent(out) :: by_column(8)
    !> Table of all unknowns; at the start of the step when not given.
    real(wp), intent(in), optional :: table(:, :)
    real(wp) :: nodal, share, slope
    integer :: a

    pressure = 0.0_wp
    by_column = 0.0_wp
    do a = 1, size(by_column)
      if (water%column(a, k) == 0) cycle
      nodal = water%kept(a, k)
      if (present(table)) nodal = nodal + table(1, water%column(a, k))
      share = 1.0_wp
      slope = 0.0_wp
      if (water%total) call take_up(water%curve(k), nodal, water%suction(a, k), share, slope)
      pressure = pressure + water%shape(a, k)*share*nodal
      by_column(a) = water%shape(a, k)*(share + slope*nodal)
    end do
  end subroutine water_at
end module qsmpm_contact_water
