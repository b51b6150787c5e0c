!> Summary of phases and rigid bodies printed by `qsmpm check`: the fixities of each phase, and the resultants of the
!> loads at its end, for the active bodies in their initial geometry: weight, water in the pores, tractions and
!> pressures on surfaces.
module qsmpm_phase_summary
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: active_materials, has_stages
  use qsmpm_material_description, only: weight_at
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_structures, only: rigid_plane, rigid_circle, rigid_box, rigid_cone
  use qsmpm_model, only: model_type
  use qsmpm_phase_start, only: resume_phase
  use qsmpm_point_selection, only: keep_chosen, append_points
  use qsmpm_pore_water, only: water_forces
  use qsmpm_vertical, only: vertical_of
  use qsmpm_surface_pressure, only: pressure_at
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: summarise_phases, summarise_rigid_bodies, phase_resultants, resultants_type

  !> Resultant loads, per radian in axisymmetry [force] (3).
  type :: resultants_type
    real(wp) :: weight(3) = 0.0_wp, water(3) = 0.0_wp, surfaces(3) = 0.0_wp
  end type resultants_type

contains

  !> Returns the lines about the phases.
  subroutine summarise_phases(model, text)
    type(model_type), intent(in) :: model
    !> Text to which the lines are added.
    character(len=:), allocatable, intent(inout) :: text
    type(resultants_type) :: load
    integer :: fixed, p

    do p = 1, size(model%analysis%phases)
      associate (phase => model%analysis%phases(p))
        call phase_resultants(model, p, load, fixed)
        text = text//"phase '"//phase%name//"': "//integer_text(fixed)//' fixed components'
        if (phase%kind == phase_safety) text = text//', the loads of its parent'
        text = text//'; weight'//vector_text(model, load%weight)
        if (any(abs(load%water) > 0.0_wp)) text = text//', water'//vector_text(model, load%water)
        if (any(abs(load%surfaces) > 0.0_wp)) text = text//', surfaces'//vector_text(model, load%surfaces)
        text = text//', resultant load'//vector_text(model, load%weight + load%water + load%surfaces)//new_line('a')
      end associate
    end do
  end subroutine summarise_phases

  !> Computes the resultant loads at the end of a phase, and the number of fixed components.
  subroutine phase_resultants(model, number, load, fixed)
    type(model_type), intent(in) :: model
    !> Number of the phase.
    integer, intent(in) :: number
    type(resultants_type), intent(out) :: load
    integer, intent(out) :: fixed
    class(model_type), allocatable :: phased
    real(wp), allocatable :: by_water(:, :)
    integer :: d

    d = model%mesh%dimension
    allocate (phased, source=model)
    phased%state%progress%phase = number
    call resume_phase(phased)
    call take_bodies(phased, number)
    fixed = count(phased%loading%constrained)
    load%weight(:d) = phased%loading%gravity_final(:d)*sum(phased%state%points%weight)
    call water_forces(phased, 1.0_wp, by_water)
    if (allocated(by_water)) load%water(:d) = sum(by_water, dim=2)
    call add_surfaces(phased, load%surfaces)
  end subroutine phase_resultants

  !> Selects the points of the bodies active in a phase, with the weight of their material at that time.
  subroutine take_bodies(model, number)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: number
    integer :: material(size(model%analysis%bodies)), p, i

    if (.not. has_stages(model%analysis)) return
    material = active_materials(model%analysis, number)
    associate (points => model%state%points, surface => model%state%surface)
      call append_points(model%state%inactive%points, points)
      call append_points(model%state%inactive%surface, surface)
      call keep_chosen(points, pack([(i, i=1, points%count)], material(points%body) > 0))
      call keep_chosen(surface, pack([(i, i=1, surface%count)], material(surface%body) > 0))
      do p = 1, points%count
        points%material(p) = material(points%body(p))
        points%weight(p) = weight_at(model%analysis%materials(points%material(p)), points%initial_position(:, p)) &
          *points%volume(p)
      end do
    end associate
  end subroutine take_bodies

  !> Adds the resultant of tractions and pressures on the surfaces.
  subroutine add_surfaces(model, resultant)
    type(model_type), intent(in) :: model
    real(wp), intent(inout) :: resultant(3)
    integer :: k, d, axis

    d = model%mesh%dimension
    axis = vertical_of(model%analysis)
    associate (surface => model%state%surface, load => model%loading)
      do k = 1, surface%count
        associate (s => surface%surface(k))
          resultant = resultant + load%traction_final(:, s)*surface%area(k)
          resultant(:d) = resultant(:d) - pressure_at(load%pressure_final(s), surface%position(axis, k)) &
            *surface%area_vector(:, k)
        end associate
      end do
    end associate
  end subroutine add_surfaces

  !> Returns the lines about the rigid bodies.
  subroutine summarise_rigid_bodies(model, text)
    type(model_type), intent(in) :: model
    !> Text to which the lines are added.
    character(len=:), allocatable, intent(inout) :: text
    integer :: b, i
    character(len=:), allocatable :: word

    do b = 1, size(model%rigid_shapes)
      associate (body => model%analysis%rigid_bodies(b))
        ! Name of the shape.
        word = 'polygon'
        if (body%shape == rigid_plane) word = 'plane'
        if (body%shape == rigid_circle) word = 'circle'
        if (body%shape == rigid_box) word = 'box'
        if (body%shape == rigid_cone) word = 'cone'
        text = text//'rigid body '//body%name//': '//word//', reference point'// &
          vector_text(model, model%rigid_shapes(b)%reference)//', touched by'
        if (.not. any(model%contact_pairs%body == b)) text = text//' no surface'
        do i = 1, size(model%contact_pairs)
          if (model%contact_pairs(i)%body /= b) cycle
          if (model%contact_pairs(i)%surface > 0) then
            text = text//' '//model%analysis%surfaces(model%contact_pairs(i)%surface)%name
          else
            text = text//' the soil around it'
          end if
        end do
        text = text//new_line('a')
      end associate
    end do
  end subroutine summarise_rigid_bodies

  !> Returns the components, each preceded by a blank.
  pure function vector_text(model, vector) result(text)
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: vector(3)
    character(len=:), allocatable :: text
    character(len=40) :: line

    write (line, '(3(1x,es12.5))') vector(:model%mesh%dimension)
    text = trim(line)
  end function vector_text
end module qsmpm_phase_summary
