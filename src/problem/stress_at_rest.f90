!> Horizontal stress at rest from the vertical stress (both effective, compression positive).
!>
!>   sigma_h = K0nc sigma_p - (sigma_p - sigma_v) nu/(1 - nu),     sigma_p = OCR sigma_v  or  sigma_v + POP
!>
!> This is the maximum past vertical stress times K0 of normally consolidated soil, minus the reduction by elastic
!> unloading to the current one: K0 = K0nc OCR - (OCR - 1) nu/(1 - nu). K0nc is a value or, after Jaky, 1 - sin phi.
module qsmpm_stress_at_rest
  use qsmpm_kinds, only: wp, pi
  use qsmpm_material_description, only: material_type, traits_of
  use qsmpm_law_parameters, only: law_description_type
  implicit none
  private

  public :: has_ratio, horizontal_at_rest, passive_ratio, unloading_poisson

contains

  !> Returns whether a material has its own K0.
  pure logical function has_ratio(material)
    type(material_type), intent(in) :: material

    has_ratio = material%at_rest%jaky .or. material%at_rest%k0 > 0.0_wp
  end function has_ratio

  !> Returns the horizontal stress for a vertical stress.
  pure real(wp) function horizontal_at_rest(material, default, vertical) result(horizontal)
    type(material_type), intent(in) :: material
    !> K0 of materials without their own.
    real(wp), intent(in) :: default
    !> Compression positive, as the result.
    real(wp), intent(in) :: vertical
    real(wp) :: past, poisson, ratio
    type(law_description_type) :: traits

    associate (rest => material%at_rest)
      past = rest%overconsolidation*vertical + rest%pre_overburden
      ! K0 of normally consolidated soil.
      ratio = default
      if (material%at_rest%k0 > 0.0_wp) ratio = material%at_rest%k0
      if (material%at_rest%jaky) then
        traits = traits_of(material)
        ratio = 1.0_wp - sin(traits%friction_angle*pi/180.0_wp)
      end if
      horizontal = ratio*past
      if (.not. (rest%overconsolidation > 1.0_wp .or. rest%pre_overburden > 0.0_wp)) return
      poisson = unloading_poisson(material)
      horizontal = horizontal - (past - vertical)*poisson/(1.0_wp - poisson)
    end associate
  end function horizontal_at_rest

  !> Returns Poisson's ratio for elastic unloading: that of *K0, otherwise of the drained material; 0 if unknown.
  pure real(wp) function unloading_poisson(material) result(poisson)
    type(material_type), intent(in) :: material
    type(law_description_type) :: traits

    poisson = material%poisson
    if (allocated(material%soil_law)) then
      traits = material%soil_law%describe()
      poisson = traits%poisson
    end if
    if (material%at_rest%poisson >= 0.0_wp) poisson = material%at_rest%poisson
  end function unloading_poisson

  !> Returns the passive ratio (1 + sin phi)/(1 - sin phi) of a purely frictional material; huge for others.
  pure real(wp) function passive_ratio(material) result(ratio)
    type(material_type), intent(in) :: material
    type(law_description_type) :: traits
    real(wp) :: sine

    ratio = huge(1.0_wp)
    traits = traits_of(material)
    if (.not. (traits%friction_angle > 0.0_wp .and. abs(traits%cohesion) <= 0.0_wp)) return
    sine = sin(traits%friction_angle*pi/180.0_wp)
    ratio = (1.0_wp + sine)/(1.0_wp - sine)
  end function passive_ratio
end module qsmpm_stress_at_rest
