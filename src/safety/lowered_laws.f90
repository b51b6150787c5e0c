!> Laws with a reduced strength (qsmpm_strength_factor): they are created from the materials of the analysis whenever
!> the factor in force differs from that of the present laws. States of the points do not change.
module qsmpm_lowered_laws
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: materials_active
  use qsmpm_analysis, only: three_dimensional
  use qsmpm_background_in_use, only: take_treatment
  use qsmpm_material_description, only: material_type, traits_of, may_yield
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_error, only: error_type, error_deck, fail
  use qsmpm_law, only: law_type
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_material_law, only: make_material_law
  use qsmpm_model, only: model_type
  use qsmpm_safety_bracket, only: largest_factor
  use qsmpm_strength_factor, only: strength_factor_type, lower_strength, lower_tension, flow_material, operator(==), &
    lower_constants
  use qsmpm_undrained_parameters, only: is_undrained
  implicit none
  private

  public :: fit_laws, lower_material, check_lowering, has_named_strength

contains

  !> Replaces the laws by those of the strength in force, with the treatment against locking of its phase.
  subroutine fit_laws(model)
    type(model_type), intent(inout) :: model
    type(strength_factor_type) :: wanted
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error
    integer :: m

    call take_treatment(model)
    wanted = strength_in_force(model)
    if (model%strength == wanted) return
    do m = 1, size(model%laws)
      if (.not. is_lowerable(model%analysis%materials(m))) cycle
      ! check_lowering has verified that all of these can be created.
      call make_lowered_law(model, m, wanted, law, error)
      if (allocated(error)) cycle
      call law%blend(model%laws(m)%law%elastic_blend)
      call move_alloc(law, model%laws(m)%law)
    end do
    model%strength = wanted
  end subroutine fit_laws

  !> Returns the factor of the state, 1 except in a safety phase, and the flow rule of its phase.
  pure type(strength_factor_type) function strength_in_force(model) result(strength)
    type(model_type), intent(in) :: model

    associate (phases => model%analysis%phases, number => model%state%progress%phase)
      if (number < 1 .or. number > size(phases)) return
      strength = strength_factor_type(model%state%progress%strength_factor, phases(number)%safety%flow)
    end associate
  end function strength_in_force

  !> Creates the law of a material with a reduced strength.
  subroutine make_lowered_law(model, number, by, law, error)
    type(model_type), intent(in) :: model
    !> Number of the material.
    integer, intent(in) :: number
    type(strength_factor_type), intent(in) :: by
    class(law_type), allocatable, intent(out) :: law
    type(error_type), allocatable, intent(out) :: error
    type(material_type) :: material
    real(wp), parameter :: unstressed(6) = 0.0_wp

    material = model%analysis%materials(number)
    call lower_material(by, material, error)
    if (allocated(error)) return
    call make_material_law(material, model%analysis%method, unstressed, &
      merge(3, 2, model%analysis%model == three_dimensional), law, error)
  end subroutine make_lowered_law

  !> Reduces the strength of a material.
  subroutine lower_material(by, material, error)
    type(strength_factor_type), intent(in) :: by
    type(material_type), intent(inout) :: material
    !> error_deck: its law does not define a strength.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: friction, dilatancy

    if (allocated(material%strength_constants)) then
      call lower_named_constants(by, material, error)
    else if (material%own_law) then
      call fail(error, error_deck, 'the strength parameters of a law given by a program are not known')
    else if (material%user%given) then
      call fail(error, error_deck, 'the strength parameters of a *USER MATERIAL are not known: name them by '// &
        '*STRENGTH CONSTANTS')
    else if (allocated(material%soil_law)) then
      call material%soil_law%lower(by, error)
    else
      friction = material%friction_angle
      dilatancy = material%dilatancy_angle
      associate (profile => material%strength_profile)
        profile%lowered = by
        profile%dilatancy_angle = dilatancy
        call lower_strength(by, profile%factor, friction, dilatancy)
      end associate
      call lower_strength(by, material%cohesion, material%friction_angle, material%dilatancy_angle)
      call lower_tension(by, material%tensile_strength)
      associate (s => material%softening)
        call lower_strength(by, s%cohesion, s%friction_angle, s%dilatancy_angle)
      end associate
    end if
  end subroutine lower_material

  !> Reduces the constants specified by the user.
  subroutine lower_named_constants(by, material, error)
    type(strength_factor_type), intent(in) :: by
    type(material_type), intent(inout) :: material
    !> error_deck: the law does not have these constants, or its angle of dilatancy is not known.
    type(error_type), allocatable, intent(out) :: error

    if (allocated(material%soil_law)) then
      call material%soil_law%lower_named(material%strength_constants, by, error)
    else if (by%flow /= flow_material) then
      call fail(error, error_deck, 'the flow rule of a *USER MATERIAL is not known: use FLOW=MATERIAL')
    else
      call lower_constants(material%strength_constants, by, material%user%constants)
    end if
  end subroutine lower_named_constants

  !> Returns whether a material has a strength that can be reduced.
  pure logical function is_lowerable(material)
    type(material_type), intent(in) :: material
    type(law_description_type) :: traits

    traits = traits_of(material)
    is_lowerable = traits%has_strength .or. allocated(material%strength_constants)
  end function is_lowerable

  !> Returns whether a body of the present phase has a law whose strength is defined by user-specified constants: it may
  !> harden.
  pure logical function has_named_strength(model) result(named)
    type(model_type), intent(in) :: model
    logical :: active(size(model%analysis%materials))
    integer :: m

    active = materials_active(model%analysis, model%state%progress%phase)
    named = any([(active(m) .and. allocated(model%analysis%materials(m)%strength_constants), m=1, size(active))])
  end function has_named_strength

  !> Checks that the materials of the bodies active in safety phases have a strength that can be reduced. A law that is
  !> valid at the largest reduction of the search is valid for all smaller reductions.
  subroutine check_lowering(model, diagnostics)
    type(model_type), intent(in) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: p, m
    logical :: concerned(size(model%analysis%materials))

    do p = 1, size(model%analysis%phases)
      associate (phase => model%analysis%phases(p))
        if (phase%kind /= phase_safety) cycle
        concerned = materials_active(model%analysis, p) .and. may_yield(model%analysis%materials)
        do m = 1, size(concerned)
          if (concerned(m)) call check_material(model, m, p, diagnostics)
        end do
        if (.not. any(concerned)) call add_diagnostic(diagnostics, phase%where, '*PHASE', "phase '"//phase%name// &
          "' reduces the strength, but no material has one")
      end associate
    end do
  end subroutine check_lowering

  !> Checks the law of a material at the largest reduction of the search.
  subroutine check_material(model, number, p, diagnostics)
    type(model_type), intent(in) :: model
    !> Number of the material and of the phase.
    integer, intent(in) :: number, p
    type(diagnostics_type), intent(inout) :: diagnostics
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error

    associate (material => model%analysis%materials(number), phase => model%analysis%phases(p))
      if (is_undrained(material%undrained, p) .and. phase%safety%flow /= flow_material .and. &
        material%friction_angle > 0.0_wp) then
        call fail(error, error_deck, 'undrained soil with the associated flow of Davis gains strength without '// &
          'limit: use FLOW=MATERIAL')
      else
        call make_lowered_law(model, number, strength_factor_type(largest_factor, phase%safety%flow), law, error)
      end if
      if (allocated(error)) call add_diagnostic(diagnostics, material%where, '*MATERIAL', "material '"// &
        material%name//"' cannot be reduced in strength in the safety phase '"//phase%name//"': "//error%message)
    end associate
  end subroutine check_material
end module qsmpm_lowered_laws
