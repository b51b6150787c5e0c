!> What other rooms ask of a material of the deck before there is a law: of a soil law its description says it
!> (qsmpm_law_parameters), of elasticity and Mohr-Coulomb strength it is worked out here. Of a law of the user's or of
!> the embedding program nothing is known.
module qsmpm_material_traits
  use qsmpm_kinds, only: wp
  use qsmpm_material_description, only: material_type
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_undrained_parameters, only: undrained_ratio
  implicit none
  private

  public :: traits_of, may_yield

contains

  !> What is said of the material's kind.
  pure type(law_description_type) function traits_of(material) result(traits)
    type(material_type), intent(in) :: material

    if (allocated(material%soil_law)) then
      traits = material%soil_law%describe()
    else
      traits%linear_elasticity = .true.
      traits%poisson = material%poisson
      traits%has_strength = material%mohr_coulomb
      traits%may_soften = material%softening%given
      traits%associated_flow = .not. (material%mohr_coulomb .and. material%dilatancy_angle < material%friction_angle)
      traits%failure_ties_volume = material%mohr_coulomb
      traits%failure_keeps_volume = material%mohr_coulomb .and. .not. material%friction_angle > 0.0_wp
      traits%dilatancy_angle = material%dilatancy_angle
      if (material%mohr_coulomb) traits%friction_angle = material%friction_angle
      if (material%mohr_coulomb) traits%cohesion = material%cohesion
    end if
    if (material%undrained%given) traits%poisson = undrained_ratio(material%undrained, traits%poisson)
  end function traits_of

  !> Whether the law may be another than elastic.
  elemental logical function may_yield(material)
    type(material_type), intent(in) :: material

    may_yield = material%mohr_coulomb .or. allocated(material%soil_law) .or. material%own_law .or. material%user%given
  end function may_yield
end module qsmpm_material_traits
