!> Surfaces that carry loads or supports in a scene or may touch rigid bodies: whether they depend on an axis, and
!> which of them are used at all.
module qsmpm_loaded_surfaces
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_description, only: body_polygon
  use qsmpm_load_description, only: carrier_points
  use qsmpm_mesh_description, only: surface_type, select_box, select_segment, select_outline
  use qsmpm_structures, only: contact_on_soil
  use qsmpm_reduction, only: letters, refuse, place_text
  use qsmpm_set_members, only: drop_unused_sets, scene_tolerance
  implicit none
  private

  public :: surface_is_used, drop_unused, require_loads_uniform, require_surface

contains

  !> Whether a phase loads or supports a surface, or a rigid body may touch it.
  pure logical function surface_is_used(analysis, name) result(used)
    type(analysis_type), intent(in) :: analysis
    !> Name of the surface.
    character(len=*), intent(in) :: name
    integer :: p, i

    used = .false.
    if (allocated(analysis%contacts)) then
      do i = 1, size(analysis%contacts)
        if (analysis%contacts(i)%place == contact_on_soil) used = used .or. analysis%contacts(i)%surface == name
      end do
    end if
    do p = 1, size(analysis%phases)
      used = used .or. any([(analysis%phases(p)%tractions(i)%surface == name, i=1, size(analysis%phases(p)%tractions))])
      used = used .or. any([(analysis%phases(p)%supports(i)%surface == name, i=1, size(analysis%phases(p)%supports))])
    end do
  end function surface_is_used

  !> Leave out the sets and surfaces that nothing refers to.
  pure subroutine drop_unused(analysis)
    type(analysis_type), intent(inout) :: analysis
    integer :: s

    call drop_unused_sets(analysis)
    analysis%surfaces = analysis%surfaces(pack([(s, s=1, size(analysis%surfaces))], &
      [(surface_is_used(analysis, analysis%surfaces(s)%name), s=1, size(analysis%surfaces))]))
  end subroutine drop_unused

  !> Prove that gravity, tractions, pressures and supports do not depend on an axis and have no part
  !> along it.
  pure subroutine require_loads_uniform(analysis, axis, reason)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: axis
    !> Why not; unallocated when proved.
    character(len=:), allocatable, intent(inout) :: reason
    integer :: p, i

    do p = 1, size(analysis%phases)
      associate (phase => analysis%phases(p))
        if (phase%gravity%given .and. abs(phase%gravity%vector(axis)) > 0.0_wp) call refuse(reason, &
          "*GRAVITY of phase '"//phase%name//"'"//place_text(phase%where)//' has a part along '//letters(axis))
        do i = 1, size(phase%tractions)
          associate (traction => phase%tractions(i))
            if (.not. traction%follows .and. abs(traction%vector(axis)) > 0.0_wp) call refuse(reason, &
              "*TRACTION on '"//traction%surface//"'"//place_text(traction%where)//' has a part along '// &
              letters(axis))
            if (traction%carrier == carrier_points) call refuse(reason, "*TRACTION on '"// &
              traction%surface//"'"//place_text(traction%where)//' is carried by the outermost points')
            call require_surface(analysis, traction%surface, axis, reason)
          end associate
        end do
        do i = 1, size(phase%supports)
          call require_surface(analysis, phase%supports(i)%surface, axis, reason)
        end do
      end associate
    end do
  end subroutine require_loads_uniform

  !> Prove that a surface goes through the whole grid along an axis and has no face across it.
  pure subroutine require_surface(analysis, name, axis, reason)
    type(analysis_type), intent(in) :: analysis
    !> Name of the surface.
    character(len=*), intent(in) :: name
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    real(wp) :: first, last, tolerance
    logical :: whole

    tolerance = scene_tolerance(analysis)
    associate (surface => analysis%surfaces(place_named(analysis%surfaces, name)), &
        lines => analysis%mesh%axes(axis)%lines)
      first = lines(1) + tolerance
      last = lines(size(lines)) - tolerance
      select case (surface%selection)
      case (select_box)
        whole = surface%box(axis, 1) <= first .and. surface%box(axis, 2) >= last &
          .and. is_flat_across(surface, axis, tolerance)
      case (select_outline)
        if (surface%boxed) then
          whole = surface%box(axis, 1) <= first .and. surface%box(axis, 2) >= last &
            .and. is_flat_across(surface, axis, tolerance)
        else
          whole = axis == 3 .and. is_prism(analysis, surface)
        end if
      case (select_segment)
        whole = axis == 1 .and. size(surface%segments, 2) == 1
        if (whole) whole = abs(surface%segments(2, 1) - surface%segments(4, 1)) <= tolerance .and. &
          minval(surface%segments([1, 3], 1)) <= first .and. maxval(surface%segments([1, 3], 1)) >= last
      case default
        whole = .false.
      end select
      if (.not. whole) call refuse(reason, "*SURFACE '"//name//"'"//place_text(surface%where)// &
        ' depends on '//letters(axis)//' or has faces across it')
    end associate
  end subroutine require_surface

  !> Whether the box of a surface is flat along another axis: then no face across the given one is in
  !> it. Along x only a box that is flat along y counts: a scene that does not depend on x has no others.
  pure logical function is_flat_across(surface, axis, tolerance) result(flat)
    type(surface_type), intent(in) :: surface
    integer, intent(in) :: axis
    !> Length that is none.
    real(wp), intent(in) :: tolerance

    flat = surface%box(2, 2) - surface%box(2, 1) <= tolerance
    if (axis == 3) flat = flat .or. surface%box(1, 2) - surface%box(1, 1) <= tolerance
  end function is_flat_across

  !> Whether the body of an outline is a polygon: the prism over it has walls only.
  pure logical function is_prism(analysis, surface) result(yes)
    type(analysis_type), intent(in) :: analysis
    type(surface_type), intent(in) :: surface
    integer :: b

    b = place_named(analysis%bodies, surface%body)
    yes = b > 0
    if (yes) yes = analysis%bodies(b)%kind == body_polygon
  end function is_prism
end module qsmpm_loaded_surfaces
