!> Warning about a pressure beside whose edge frictional ground fails before it fails as a whole.
!>
!> Under a uniform pressure a strip of width b at the edge, beside unloaded ground, carries
!>
!>   p(b) = c N_c + gamma b N_gamma/2,     N_q = tan^2(45 + phi/2) exp(pi tan phi), N_c = (N_q - 1)/tan phi,
!>                                         N_gamma = 2 (N_q + 1) tan phi
!>
!> (Prandtl, Reissner; Vesic 1973), c N_c for b = 0. Cells of width h restrain mechanisms narrower than themselves: a
!> pressure above p(h) is carried by the cells, and a limit load decreases with h. A rigid load does not fail so.
module qsmpm_edge_failure
  use qsmpm_kinds, only: wp, pi
  use qsmpm_agreement, only: lowest_rank, spread_text
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_material_description, only: traits_of
  use qsmpm_mesh_measure, only: cell_width
  use qsmpm_model, only: model_type
  use qsmpm_points, only: nearest_point
  use qsmpm_rounded_text, only: rounded_place, rounded_text
  use qsmpm_strength_factor, only: lower_strength, strength_factor_type
  use qsmpm_stress_error, only: applied_traction
  use qsmpm_undrained_parameters, only: is_undrained
  implicit none
  private

  public :: edge_note, edge_strength

  !> Share of a cell around a place in which a point belongs to it.
  real(wp), parameter :: near = 0.75_wp

contains

  !> Returns the warning of the first surface whose edge fails in the phase; empty where none does.
  function edge_note(model) result(text)
    !> The model at the end of a phase.
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    integer, allocatable :: points(:)
    real(wp) :: along(2)
    integer :: s, i, rank

    text = ''
    if (model%mesh%dimension == 2) then
      associate (surface => model%state%surface)
        do s = 1, size(model%analysis%surfaces)
          points = pack([(i, i=1, surface%count)], surface%surface(:surface%count) == s &
            .and. norm2(surface%area_vector(:, :surface%count), dim=1) > 0.0_wp)
          if (size(points) == 0) cycle
          along = sum(surface%area_vector(:, points), dim=2)
          if (.not. norm2(along) > 0.0_wp) cycle
          along = [-along(2), along(1)]/norm2(along)
          associate (place => matmul(along, surface%position(:, points)))
            if (len(text) == 0) text = end_note(model, points(maxloc(place, dim=1)), along)
            if (len(text) == 0) text = end_note(model, points(minloc(place, dim=1)), -along)
          end associate
        end do
      end associate
    end if
    rank = lowest_rank(model%part%team, len(text) > 0)
    if (rank < model%part%team%ranks) call spread_text(model%part%team, rank, text)
  end function edge_note

  !> Returns the warning of one end of a surface; empty if the ground carries its pressure, or no soil is beside it.
  function end_note(model, point, along) result(text)
    type(model_type), intent(in) :: model
    !> Number of the surface point at the end.
    integer, intent(in) :: point
    !> Unit vector along the surface, outwards.
    real(wp), intent(in) :: along(2)
    character(len=:), allocatable :: text
    real(wp) :: normal(2), traction(2), pressure, width, cohesion, friction, carried(2)
    type(law_description_type) :: traits
    integer :: cell, p

    text = ''
    associate (surface => model%state%surface, points => model%state%points)
      cell = surface%cell(point)
      if (cell == 0) return
      width = cell_width(model%mesh, cell)
      normal = surface%area_vector(:, point)/norm2(surface%area_vector(:, point))
      call applied_traction(model, point, traction)
      pressure = -dot_product(traction, normal)
      associate (beside => surface%position(:, point) + width*along)
        p = soil_at(model, beside - 0.5_wp*width*normal, width)
        if (p == 0 .or. is_loaded(model, beside, width)) return
        if (soil_at(model, beside + 2.0_wp*width*normal, width) > 0) return
      end associate
      associate (material => model%analysis%materials(points%material(p)))
        traits = traits_of(material)
        if (is_undrained(material%undrained, model%state%progress%phase)) return
        if (.not. (traits%friction_angle > 0.0_wp .and. traits%cohesion >= 0.0_wp)) return
        cohesion = traits%cohesion
        friction = traits%friction_angle
        call lower_strength(strength_factor_type(model%state%progress%strength_factor), cohesion, friction, &
          traits%dilatancy_angle)
        carried = edge_strength(cohesion, friction, norm2(model%loading%gravity_final)*material%unit_weight, &
          [0.0_wp, width])
        if (.not. pressure > carried(2)) return
        text = "warning: phase '"//model%analysis%phases(model%state%progress%phase)%name//"': pressure "// &
          rounded_text(pressure, 3)//" of surface '"//model%analysis%surfaces(surface%surface(point))%name// &
          "' ends at "//rounded_place(surface%position(:, point))//" beside soil '"//material%name//"', which "// &
          'carries '//rounded_text(carried(1), 3)//' at an edge (c Nc) and '//rounded_text(carried(2), 3)// &
          ' over a cell of '//rounded_text(width, 2)//': the cells restrain a local failure, and a limit load or '// &
          'factor is too high and decreases with them. `qsmpm-verify bounds DECK --phase NAME` gives bounds; a '// &
          'stiff body or prescribed displacements represent a footing'//new_line('a')
      end associate
    end associate
  end function end_note

  !> Returns the pressure that strips of given widths carry at an edge.
  pure function edge_strength(cohesion, friction, weight, widths) result(carried)
    !> Cohesion, friction angle in degrees, and weight per volume.
    real(wp), intent(in) :: cohesion, friction, weight
    real(wp), intent(in) :: widths(:)
    real(wp) :: carried(size(widths)), tangent, of_surcharge

    tangent = tan(friction*pi/180.0_wp)
    of_surcharge = tan(pi/4.0_wp + friction*pi/360.0_wp)**2*exp(pi*tangent)
    carried = cohesion*(of_surcharge - 1.0_wp)/tangent + weight*widths*(of_surcharge + 1.0_wp)*tangent
  end function edge_strength

  !> Returns the material point near a place; 0 where there is none.
  pure integer function soil_at(model, place, width) result(point)
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: place(2), width

    point = nearest_point(model%state%points, place)
    if (norm2(model%state%points%position(:, point) - place) > near*width) point = 0
  end function soil_at

  !> Returns whether a loaded surface continues at a place.
  pure logical function is_loaded(model, place, width)
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: place(2), width
    real(wp) :: traction(2)
    integer :: i

    is_loaded = .false.
    associate (surface => model%state%surface)
      do i = 1, surface%count
        if (norm2(surface%position(:, i) - place) > near*width) cycle
        call applied_traction(model, i, traction)
        is_loaded = is_loaded .or. norm2(traction) > 0.0_wp
      end do
    end associate
  end function is_loaded
end module qsmpm_edge_failure
