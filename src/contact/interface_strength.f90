!> Strength of an interface as a share of that of the soil which touches it (*CONTACT, INTERFACE=R), as PLAXIS has it:
!>
!>   tan(delta) = R tan(phi),   a = R c,   a = R s_u of soil whose strength is that by place
!>
!> of the material of the nearest material point; a profile is asked where that point was at the start, as its law does.
!> Strength that falls with strain does not fall here.
module qsmpm_interface_strength
  use qsmpm_kinds, only: wp
  use qsmpm_material_description, only: material_type
  use qsmpm_carried_basis, only: nearest_point
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_model, only: model_type
  use qsmpm_strength_profile, only: follows_stress, strength_at
  use qsmpm_value_field, only: field_friction, value_at
  implicit none
  private

  public :: interface_strength, check_interfaces

  real(wp), parameter :: degree = acos(-1.0_wp)/180.0_wp

contains

  !> Tangent of the angle of friction, and adhesion, of an interface at a place.
  pure function interface_strength(model, share, x) result(strength)
    type(model_type), intent(in) :: model
    !> R.
    real(wp), intent(in) :: share
    !> Present place (dimension).
    real(wp), intent(in) :: x(:)
    real(wp) :: strength(2), place(3)
    integer :: p

    p = nearest_point(model%state%points, x)
    place = 0.0_wp
    place(:size(x)) = model%state%points%initial_position(:, p)
    associate (material => model%analysis%materials(model%state%points%material(p)))
      strength(1) = share*tan(degree*value_at(material%strength_profile%fields, field_friction, place, &
        material%friction_angle))
      strength(2) = share*max(material%cohesion, strength_at(material%strength_profile, place))
    end associate
  end function interface_strength

  !> An interface by a share wants soil whose strength is known: c and phi of *MOHR COULOMB.
  subroutine check_interfaces(model, diagnostics)
    type(model_type), intent(in) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: i, m

    do i = 1, size(model%analysis%contacts)
      if (.not. model%analysis%contacts(i)%interface > 0.0_wp) cycle
      do m = 1, size(model%analysis%materials)
        associate (material => model%analysis%materials(m), where => model%analysis%contacts(i)%where)
          if (.not. has_strength(material)) call add_diagnostic(diagnostics, where, '*CONTACT', 'INTERFACE takes a '// &
            "share of c and phi of *MOHR COULOMB, which material '"//material%name//"' does not have: give "// &
            'FRICTION ANGLE and ADHESION')
          ! Contact carries the total stress of undrained soil.
          if (material%undrained%given .and. material%friction_angle > 0.0_wp) call add_diagnostic(diagnostics, where, &
            '*CONTACT', "INTERFACE requires s_u of undrained material '"//material%name//"', which is a result "// &
            "with a "// &
            'friction angle: give ADHESION, or c = s_u and phi = 0')
        end associate
      end do
    end do
  end subroutine check_interfaces

  !> Whether a material is one of Mohr and Coulomb.
  pure logical function has_strength(material)
    type(material_type), intent(in) :: material

    has_strength = material%mohr_coulomb .and. .not. (material%user%given .or. material%own_law .or. &
      allocated(material%soil_law) .or. follows_stress(material%strength_profile))
  end function has_strength
end module qsmpm_interface_strength
