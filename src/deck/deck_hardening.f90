!> Cards of hardening soils: *CAM CLAY and *HARDENING SOIL, and their echo.
module qsmpm_deck_hardening
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: material_type
  use qsmpm_cards, only: card_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_card_visitors, only: describer_type, reader_type, writer_type, reader
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_echo_lines, only: echo_type
  use qsmpm_error, only: error_type
  use qsmpm_hardening_parameters, only: cam_clay_parameters_type, hardening_soil_parameters_type
  use qsmpm_keyword_table, only: table_type, in_material, once
  use qsmpm_law, only: law_type
  use qsmpm_law_factory, only: new_law, kinematics_logarithmic, rate_midpoint
  implicit none
  private

  public :: add_hardening_keywords, echo_hardening

contains

  !> Entries of *CAM CLAY and *HARDENING SOIL.
  subroutine add_hardening_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table
    type(describer_type) :: fields, soil_fields
    type(cam_clay_parameters_type) :: clay
    type(hardening_soil_parameters_type) :: soil

    call table%add('CAM CLAY', in_material, once, 'Modified Cam-Clay instead of *ELASTIC and *MOHR COULOMB. '// &
      'Compression lines are straight in ln v - ln p with lambda/v0 and kappa/v0. A point without stress has '// &
      'the stiffness of the smallest pressure: give *INITIAL, TYPE=K0.', handle_cam_clay)
    call table%data('clay', 1, 1)
    call cam_clay_fields(fields, clay)
    call table%take(fields%items)
    call table%example('*CAM CLAY, OCR=1.5| 1.0, 0.2, 0.04, 2.2, 0.3')

    call table%add('HARDENING SOIL', in_material, once, 'Hardening soil instead of *ELASTIC and *MOHR COULOMB: '// &
      'a hyperbola in shear, a cap in compression, stiffness that follows the smallest stress. Angles in degrees.', &
      handle_hardening_soil)
    call table%data('soil', 1, 1)
    call hardening_soil_fields(soil_fields, soil)
    call table%take(soil_fields%items)
    call table%example('*HARDENING SOIL, OCR=2| 3e4, 3e4, 9e4, 0.5, 0.2, 100, 1, 35, 5')
  end subroutine add_hardening_keywords

  !> Parameters and data line of *CAM CLAY.
  subroutine cam_clay_fields(fields, clay)
    class(card_fields_type), intent(inout) :: fields
    type(cam_clay_parameters_type), intent(inout) :: clay

    call fields%number('OCR', clay%ocr, 'size of the first yield surface over that through the initial stress', &
      range='[1, inf)')
    call fields%number('PRECONSOLIDATION', clay%preconsolidation, 'least size of the first yield surface, a mean '// &
      'pressure', range='[0, inf)')
    call fields%number('SHEAR MODULUS', clay%shear, 'constant shear modulus instead of nu', range='(0, inf)')
    call fields%number('SMALLEST PRESSURE', clay%smallest_pressure, 'mean pressure below which the bulk modulus is '// &
      'constant; the default is meant for kPa', range='(0, inf)')
    call fields%column('M', clay%slope, 'slope of the critical state line, q = M p', range='(0, inf)')
    call fields%column('lambda', clay%lambda, 'slope of the compression line in v - ln p', range='(0, inf)')
    call fields%column('kappa', clay%kappa, 'slope of the swelling line, below lambda', range='(0, inf)')
    call fields%column('v0', clay%volume, 'specific volume 1 + e at the start', range='(1, inf)')
    call fields%column('nu', clay%poisson, "Poisson's ratio", required=.false., range='(-1, 0.5)')
  end subroutine cam_clay_fields

  !> Parameters and data line of *HARDENING SOIL.
  subroutine hardening_soil_fields(fields, soil)
    class(card_fields_type), intent(inout) :: fields
    type(hardening_soil_parameters_type), intent(inout) :: soil

    call fields%number('OCR', soil%ocr, 'largest vertical stress of the past over the initial one', range='[1, inf)')
    call fields%number('POP', soil%pop, 'what the largest vertical stress of the past lay above that', &
      range='[0, inf)')
    call fields%number('SMALLEST PRESSURE', soil%smallest_pressure, 'smallest stress for stiffness; a hundredth of '// &
      'the reference pressure when not given', range='(0, inf)')
    call fields%column('E50', soil%e50, 'secant modulus of a drained triaxial test at half its strength and the '// &
      'reference pressure', range='(0, inf)')
    call fields%column('Eoed', soil%eoed, 'tangent modulus of one-dimensional compression at that vertical stress', &
      range='(0, inf)')
    call fields%column('Eur', soil%eur, 'modulus of unloading and reloading', range='(0, inf)')
    call fields%column('m', soil%power, 'power of the stress', range='[0, 1]')
    call fields%column('nu', soil%poisson, "Poisson's ratio of unloading", range='[0, 0.5)')
    call fields%column('p_ref', soil%reference, 'reference pressure', range='(0, inf)')
    call fields%column('c', soil%cohesion, 'cohesion', range='[0, inf)')
    call fields%column('phi', soil%friction_angle, 'friction angle', range='(0, 90)')
    call fields%column('psi', soil%dilatancy_angle, 'dilatancy angle, not above phi', range='[0, 90)')
    call fields%column('Rf', soil%ratio, 'strength over the asymptote of the hyperbola, 0.9', required=.false., &
      range='(0, 1)')
    call fields%column('K0nc', soil%k0, 'stress ratio of one-dimensional compression, 1 - sin phi', &
      required=.false., range='(0, 1)')
  end subroutine hardening_soil_fields

  !> *CAM CLAY.
  subroutine handle_cam_clay(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    fields = reader(card)
    associate (clay => state%analysis%materials(size(state%analysis%materials))%cam_clay)
      clay%given = .true.
      if (size(card%rows) == 0) return
      if (.not. card%rows(1)%good) return
      call cam_clay_fields(fields, clay)
      if (card%has('SHEAR MODULUS') .eqv. size(card%rows(1)%items) > 4) call state%fault_at(card, card%rows(1), &
        'either nu or SHEAR MODULUS is wanted, not both and not neither')
      call check_model(card, state, clay, hardening_soil_parameters_type())
    end associate
  end subroutine handle_cam_clay

  !> *HARDENING SOIL.
  subroutine handle_hardening_soil(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    fields = reader(card)
    associate (soil => state%analysis%materials(size(state%analysis%materials))%hardening_soil)
      soil%given = .true.
      if (size(card%rows) == 0) return
      if (.not. card%rows(1)%good) return
      call hardening_soil_fields(fields, soil)
      call check_model(card, state, cam_clay_parameters_type(), soil)
    end associate
  end subroutine handle_hardening_soil

  !> Whether the parameters make a model, here, where the line is known.
  subroutine check_model(card, state, clay, soil)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    !> One of the two is given.
    type(cam_clay_parameters_type), intent(in) :: clay
    type(hardening_soil_parameters_type), intent(in) :: soil
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error

    if (clay%given) then
      call new_law(clay, 2, kinematics_logarithmic, rate_midpoint, law, error)
    else
      call new_law(soil, 2, kinematics_logarithmic, rate_midpoint, law, error)
    end if
    if (allocated(error)) call state%fault_at(card, card%rows(1), error%message)
  end subroutine check_model

  !> The cards of a material that has one.
  subroutine echo_hardening(echo, material)
    !> The text.
    type(echo_type), intent(inout) :: echo
    !> The material.
    type(material_type), intent(in) :: material
    type(writer_type) :: fields
    type(cam_clay_parameters_type) :: clay
    type(hardening_soil_parameters_type) :: soil
    !> Outside of its range.
    real(wp), parameter :: not_set = -1.0_wp

    clay = material%cam_clay
    soil = material%hardening_soil
    if (clay%given) then
      if (clay%shear > 0.0_wp) clay%poisson = not_set
      call fields%begin('CAM CLAY')
      call cam_clay_fields(fields, clay)
      call fields%finish(echo)
    end if
    if (soil%given) then
      call fields%begin('HARDENING SOIL')
      call hardening_soil_fields(fields, soil)
      call fields%finish(echo)
    end if
  end subroutine echo_hardening
end module qsmpm_deck_hardening
