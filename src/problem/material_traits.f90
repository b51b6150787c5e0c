!> What other rooms ask of a material of the deck, answered in one place for every built-in law: a new law is entered
!> here once. Of a law of the user's or of the embedding program nothing is known.
module qsmpm_material_traits
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: material_type
  implicit none
  private

  public :: has_soil_law, has_strength, may_yield, may_soften, flow_is_associated, failure_ties_volume, &
    failure_keeps_volume

contains

  !> Whether the law is one that stands instead of elasticity and Mohr-Coulomb strength.
  pure logical function has_soil_law(material)
    type(material_type), intent(in) :: material

    has_soil_law = material%cam_clay%given .or. material%hardening_soil%given
  end function has_soil_law

  !> Whether the stress of the law is bounded by a strength that ends all stiffness.
  pure logical function has_strength(material)
    type(material_type), intent(in) :: material

    has_strength = material%mohr_coulomb .or. material%hardening_soil%given
  end function has_strength

  !> Whether the law may be another than elastic.
  elemental logical function may_yield(material)
    type(material_type), intent(in) :: material

    may_yield = has_strength(material) .or. has_soil_law(material) .or. material%own_law .or. material%user%given
  end function may_yield

  !> Whether the strength may fall: with softening, and beside the critical state on the dry side.
  pure logical function may_soften(material)
    type(material_type), intent(in) :: material

    may_soften = material%softening%given .or. material%cam_clay%given
  end function may_soften

  !> Whether plastic flow, if any, is normal to the yield surface.
  pure logical function flow_is_associated(material)
    type(material_type), intent(in) :: material

    flow_is_associated = .not. material%hardening_soil%given
    if (material%mohr_coulomb) flow_is_associated = flow_is_associated &
      .and. .not. material%dilatancy_angle < material%friction_angle
  end function flow_is_associated

  !> Whether the volume change of failure is tied to its shear strain for good.
  pure logical function failure_ties_volume(material)
    type(material_type), intent(in) :: material

    failure_ties_volume = material%mohr_coulomb
  end function failure_ties_volume

  !> Whether failure keeps the volume: strength without friction.
  pure logical function failure_keeps_volume(material)
    type(material_type), intent(in) :: material

    failure_keeps_volume = failure_ties_volume(material) .and. .not. material%friction_angle > 0.0_wp
  end function failure_keeps_volume
end module qsmpm_material_traits
