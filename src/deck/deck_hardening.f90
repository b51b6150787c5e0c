!> Cards of hardening soils: *CAM CLAY and *HARDENING SOIL.
module qsmpm_deck_hardening
  use qsmpm_kinds, only: wp
  use qsmpm_cards, only: card_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_error, only: error_type
  use qsmpm_keyword_table, only: table_type, in_material, once
  use qsmpm_law, only: law_type
  use qsmpm_law_factory, only: new_law, kinematics_logarithmic, rate_midpoint
  implicit none
  private

  public :: add_hardening_keywords

contains

  !> *CAM CLAY and *HARDENING SOIL.
  subroutine add_hardening_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('CAM CLAY', in_material, once, 'Modified Cam-Clay instead of *ELASTIC and *MOHR COULOMB. '// &
      'Compression lines are straight in ln v - ln p with lambda/v0 and kappa/v0. A point without stress has '// &
      'the stiffness of the smallest pressure: give *INITIAL, TYPE=K0.', cam_clay_fields, &
      '*CAM CLAY, OCR=1.5| 1.0, 0.2, 0.04, 2.2, 0.3', check_cam_clay)
    call table%add('HARDENING SOIL', in_material, once, 'Hardening soil instead of *ELASTIC and *MOHR COULOMB: '// &
      'a hyperbola in shear, a cap in compression, stiffness that follows the smallest stress. Angles in degrees.', &
      hardening_soil_fields, '*HARDENING SOIL, OCR=2| 3e4, 3e4, 9e4, 0.5, 0.2, 100, 1, 35, 5', check_hardening_soil)
  end subroutine add_hardening_keywords

  !> *CAM CLAY.
  subroutine cam_clay_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    !> Outside of its range.
    real(wp), parameter :: not_set = -1.0_wp

    associate (clay => deck%analysis%materials(deck%material)%cam_clay)
      call fields%given(clay%given)
      call fields%number('OCR', clay%ocr, 'size of the first yield surface over that through the initial stress', &
        range='[1, inf)')
      call fields%number('PRECONSOLIDATION', clay%preconsolidation, 'least size of the first yield surface, a mean '// &
        'pressure', range='[0, inf)')
      call fields%number('SHEAR MODULUS', clay%shear, 'constant shear modulus instead of nu', range='(0, inf)')
      call fields%number('SMALLEST PRESSURE', clay%smallest_pressure, 'mean pressure below which the bulk modulus '// &
        'is constant; the default is meant for kPa', range='(0, inf)')
      call fields%data('clay')
      call fields%number('M', clay%slope, 'slope of the critical state line, q = M p', range='(0, inf)')
      call fields%number('lambda', clay%lambda, 'slope of the compression line in v - ln p', range='(0, inf)')
      call fields%number('kappa', clay%kappa, 'slope of the swelling line, below lambda', range='(0, inf)')
      call fields%number('v0', clay%volume, 'specific volume 1 + e at the start', range='(1, inf)')
      if (fields%writing .and. clay%shear > 0.0_wp) clay%poisson = not_set
      call fields%number('nu', clay%poisson, "Poisson's ratio", required=.false., range='(-1, 0.5)')
    end associate
  end subroutine cam_clay_fields

  !> *HARDENING SOIL.
  subroutine hardening_soil_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (soil => deck%analysis%materials(deck%material)%hardening_soil)
      call fields%given(soil%given)
      call fields%number('OCR', soil%ocr, 'largest vertical stress of the past over the initial one', range='[1, inf)')
      call fields%number('POP', soil%pop, 'what the largest vertical stress of the past lay above that', &
        range='[0, inf)')
      call fields%number('SMALLEST PRESSURE', soil%smallest_pressure, 'smallest stress for stiffness; a hundredth '// &
        'of the reference pressure when not given', range='(0, inf)')
      call fields%data('soil')
      call fields%number('E50', soil%e50, 'secant modulus of a drained triaxial test at half its strength and the '// &
        'reference pressure', range='(0, inf)')
      call fields%number('Eoed', soil%eoed, 'tangent modulus of one-dimensional compression at that vertical stress', &
        range='(0, inf)')
      call fields%number('Eur', soil%eur, 'modulus of unloading and reloading', range='(0, inf)')
      call fields%number('m', soil%power, 'power of the stress', range='[0, 1]')
      call fields%number('nu', soil%poisson, "Poisson's ratio of unloading", range='[0, 0.5)')
      call fields%number('p_ref', soil%reference, 'reference pressure', range='(0, inf)')
      call fields%number('c', soil%cohesion, 'cohesion', range='[0, inf)')
      call fields%number('phi', soil%friction_angle, 'friction angle', range='(0, 90)')
      call fields%number('psi', soil%dilatancy_angle, 'dilatancy angle, not above phi', range='[0, 90)')
      call fields%number('Rf', soil%ratio, 'strength over the asymptote of the hyperbola, 0.9', required=.false., &
        range='(0, 1)')
      call fields%number('K0nc', soil%k0, 'stress ratio of one-dimensional compression, 1 - sin phi', &
        required=.false., range='(0, 1)')
    end associate
  end subroutine hardening_soil_fields

  !> The clay makes a law, with one of its two elastic constants.
  subroutine check_cam_clay(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error

    if (.not. card%is_right()) return
    if (card%has('SHEAR MODULUS') .eqv. size(card%rows(1)%items) > 4) call state%error_at(card, card%rows(1), &
      'either nu or SHEAR MODULUS is wanted, not both and not neither')
    call new_law(state%analysis%materials(state%material)%cam_clay, 2, kinematics_logarithmic, rate_midpoint, law, &
      error)
    if (allocated(error)) call state%error_at(card, card%rows(1), error%message)
  end subroutine check_cam_clay

  !> The soil makes a law.
  subroutine check_hardening_soil(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error

    if (.not. card%is_right()) return
    call new_law(state%analysis%materials(state%material)%hardening_soil, 2, kinematics_logarithmic, rate_midpoint, &
      law, &
      error)
    if (allocated(error)) call state%error_at(card, card%rows(1), error%message)
  end subroutine check_hardening_soil
end module qsmpm_deck_hardening
