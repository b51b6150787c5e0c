!> Materials as defined in a deck: laws and their parameters, strength profiles, locking treatment, stresses at rest.
!>
!> The module also provides the properties of a material needed before its law is created: for soil laws they are given
!> by the law description (qsmpm_law_parameters), for elasticity with Mohr-Coulomb strength they are determined here.
!> For user laws and laws of an embedding program nothing is known.
module qsmpm_material_description
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: named_type
  use qsmpm_law_parameters, only: law_parameters_type, law_description_type
  use qsmpm_permeability_law, only: permeability_law_type
  use qsmpm_material_parameters, only: softening_parameters_type
  use qsmpm_source_line, only: source_line_type
  use qsmpm_strength_factor, only: strength_constant_type
  use qsmpm_strength_profile, only: strength_profile_type
  use qsmpm_undrained_parameters, only: undrained_type, undrained_ratio
  use qsmpm_user_material, only: user_material_type
  use qsmpm_value_field, only: field_permeability, field_weight, value_at
  implicit none
  private

  public :: at_rest_type, material_type, weight_at, permeability_at, traits_of, may_yield

  !> Locking treatment of a material; auto is resolved by the model builder.
  integer, parameter, public :: locking_none = 0, locking_auto = 1, locking_uniform_pressure = 2

  !> Initial horizontal stress of a material (qsmpm_stress_at_rest).
  type :: at_rest_type
    type(source_line_type) :: where
    !> K0 of normally consolidated soil, negative: that of the phase; whether it is 1 - sin phi (Jaky).
    real(wp) :: k0 = -1.0_wp
    logical :: jaky = .false.
    !> OCR: maximum past vertical stress over the current one; POP: their difference.
    real(wp) :: overconsolidation = 1.0_wp, pre_overburden = 0.0_wp
    !> Poisson's ratio for unloading; negative: that of the material.
    real(wp) :: poisson = -1.0_wp
  end type at_rest_type

  !> Parameters of a material; the law is selected by the parameters present.
  type, extends(named_type) :: material_type
    type(source_line_type) :: where
    real(wp) :: young = 0.0_wp
    real(wp) :: poisson = 0.0_wp
    !> Unit weight at load factor 1 (multiplied by the gravity vector).
    real(wp) :: unit_weight = 0.0_wp
    !> Unit weight below the water level; negative: not given.
    real(wp) :: saturated_weight = -1.0_wp
    !> Permeability along the axes, as volume per area, time and gradient of the hydraulic head; negative: not given.
    real(wp) :: permeability(3) = -1.0_wp
    type(permeability_law_type) :: permeability_law
    !> Volume of water released per volume of soil when the water surface passes; 0: not given.
    real(wp) :: drainable_porosity = 0.0_wp
    type(at_rest_type) :: at_rest
    logical :: mohr_coulomb = .false.
    real(wp) :: cohesion = 0.0_wp
    !> Degrees.
    real(wp) :: friction_angle = 0.0_wp
    real(wp) :: dilatancy_angle = 0.0_wp
    !> Tension cut-off on the largest principal stress; huge for none.
    real(wp) :: tensile_strength = huge(1.0_wp)
    !> Softening of the strength, if any.
    type(softening_parameters_type) :: softening
    !> Whether the law is given by the embedding program; its properties are unknown.
    logical :: own_law = .false.
    !> Strength profile, which replaces the cohesion.
    type(strength_profile_type) :: strength_profile
    type(source_line_type) :: profile_where, fields_where
    !> Undrained behaviour.
    type(undrained_type) :: undrained
    type(source_line_type) :: undrained_where
    !> A law of qsmpm_law_factory, which replaces elasticity and strength.
    class(law_parameters_type), allocatable :: soil_law
    !> One of locking_*, and its factor; negative for the default of the mesh.
    integer :: locking_treatment = locking_auto
    real(wp) :: pressure_factor = -1.0_wp
    !> Model in a shared library.
    type(user_material_type) :: user
    !> Constants divided by the factor of safety, for a law without strength parameters of its own; unallocated for
    !> none.
    type(strength_constant_type), allocatable :: strength_constants(:)
    type(source_line_type) :: strength_where
  end type material_type

contains

  !> Returns the unit weight at a location without water.
  pure real(wp) function weight_at(material, place) result(weight)
    type(material_type), intent(in) :: material
    !> Initial position (2 or 3).
    real(wp), intent(in) :: place(:)

    weight = value_at(material%strength_profile%fields, field_weight, place, material%unit_weight)
  end function weight_at

  !> Returns the permeability along the axes at a location; a field gives the value along x, and the ratios are
  !> constant.
  pure function permeability_at(material, place) result(permeability)
    type(material_type), intent(in) :: material
    !> Initial position (2 or 3).
    real(wp), intent(in) :: place(:)
    real(wp) :: permeability(3)

    permeability = material%permeability
    associate (along_x => value_at(material%strength_profile%fields, field_permeability, place, permeability(1)))
      if (permeability(1) > 0.0_wp) permeability = permeability*(along_x/permeability(1))
    end associate
  end function permeability_at

  !> Returns the description of the material.
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

  !> Returns whether the law may be other than elastic.
  elemental logical function may_yield(material)
    type(material_type), intent(in) :: material

    may_yield = material%mohr_coulomb .or. allocated(material%soil_law) .or. material%own_law .or. material%user%given
  end function may_yield
end module qsmpm_material_description
