!> Cards of hardening soils: *CAM CLAY and *HARDENING SOIL, and their echo.
module qsmpm_deck_hardening
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: material_type
  use qsmpm_cards, only: card_type, row_type, number_at
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_echo_lines, only: echo_type, numbers
  use qsmpm_error, only: error_type
  use qsmpm_hardening_parameters, only: cam_clay_parameters_type, hardening_soil_parameters_type
  use qsmpm_keyword_table, only: table_type, in_material, once, kind_real
  use qsmpm_law, only: law_type
  use qsmpm_law_factory, only: new_law, kinematics_logarithmic, rate_midpoint
  use qsmpm_text, only: real_text
  implicit none
  private

  public :: add_hardening_keywords, echo_hardening

contains

  !> Entries of *CAM CLAY and *HARDENING SOIL.
  subroutine add_hardening_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table

    call table%add('CAM CLAY', in_material, once, 'Modified Cam-Clay instead of *ELASTIC and *MOHR COULOMB. '// &
      'Compression lines are straight in ln v - ln p with lambda/v0 and kappa/v0. A point without stress has '// &
      'the stiffness of the smallest pressure: give *INITIAL, TYPE=K0.', handle_cam_clay)
    call table%parameter('OCR', kind_real, 'size of the first yield surface over that through the initial stress', &
      default='1', range='[1, inf)')
    call table%parameter('PRECONSOLIDATION', kind_real, 'least size of the first yield surface, a mean pressure', &
      default='0', range='[0, inf)')
    call table%parameter('SHEAR MODULUS', kind_real, 'constant shear modulus instead of nu', range='(0, inf)')
    call table%parameter('SMALLEST PRESSURE', kind_real, 'mean pressure below which the bulk modulus is constant; '// &
      'the default is meant for kPa', default='1', range='(0, inf)')
    call table%data('clay', 1, 1)
    call table%column('M', kind_real, 'slope of the critical state line, q = M p', range='(0, inf)')
    call table%column('lambda', kind_real, 'slope of the compression line in v - ln p', range='(0, inf)')
    call table%column('kappa', kind_real, 'slope of the swelling line, below lambda', range='(0, inf)')
    call table%column('v0', kind_real, 'specific volume 1 + e at the start', range='(1, inf)')
    call table%column('nu', kind_real, "Poisson's ratio", required=.false., range='(-1, 0.5)')
    call table%example('*CAM CLAY, OCR=1.5| 1.0, 0.2, 0.04, 2.2, 0.3')

    call table%add('HARDENING SOIL', in_material, once, 'Hardening soil instead of *ELASTIC and *MOHR COULOMB: '// &
      'a hyperbola in shear, a cap in compression, stiffness that follows the smallest stress. Angles in degrees.', &
      handle_hardening_soil)
    call table%parameter('OCR', kind_real, 'largest vertical stress of the past over the initial one', &
      default='1', range='[1, inf)')
    call table%parameter('POP', kind_real, 'what the largest vertical stress of the past lay above that', &
      default='0', range='[0, inf)')
    call table%parameter('SMALLEST PRESSURE', kind_real, 'smallest stress for stiffness; a hundredth of the '// &
      'reference pressure when not given', range='(0, inf)')
    call table%data('soil', 1, 1)
    call table%column('E50', kind_real, 'secant modulus of a drained triaxial test at half its strength and the '// &
      'reference pressure', range='(0, inf)')
    call table%column('Eoed', kind_real, 'tangent modulus of one-dimensional compression at that vertical stress', &
      range='(0, inf)')
    call table%column('Eur', kind_real, 'modulus of unloading and reloading', range='(0, inf)')
    call table%column('m', kind_real, 'power of the stress', range='[0, 1]')
    call table%column('nu', kind_real, "Poisson's ratio of unloading", range='[0, 0.5)')
    call table%column('p_ref', kind_real, 'reference pressure', range='(0, inf)')
    call table%column('c', kind_real, 'cohesion', range='[0, inf)')
    call table%column('phi', kind_real, 'friction angle', range='(0, 90)')
    call table%column('psi', kind_real, 'dilatancy angle, not above phi', range='[0, 90)')
    call table%column('Rf', kind_real, 'strength over the asymptote of the hyperbola, 0.9', required=.false., &
      range='(0, 1)')
    call table%column('K0nc', kind_real, 'stress ratio of one-dimensional compression, 1 - sin phi', &
      required=.false., range='(0, 1)')
    call table%example('*HARDENING SOIL, OCR=2| 3e4, 3e4, 9e4, 0.5, 0.2, 100, 1, 35, 5')
  end subroutine add_hardening_keywords

  !> *CAM CLAY.
  subroutine handle_cam_clay(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    associate (clay => state%analysis%materials(size(state%analysis%materials))%cam_clay)
      clay%given = .true.
      if (size(card%rows) == 0) return
      if (.not. card%rows(1)%good) return
      clay%slope = number_at(card%rows(1), 1)
      clay%lambda = number_at(card%rows(1), 2)
      clay%kappa = number_at(card%rows(1), 3)
      clay%volume = number_at(card%rows(1), 4)
      if (size(card%rows(1)%items) > 4) clay%poisson = number_at(card%rows(1), 5)
      clay%ocr = card%number('OCR')
      clay%preconsolidation = card%number('PRECONSOLIDATION')
      clay%smallest_pressure = card%number('SMALLEST PRESSURE')
      if (card%has('SHEAR MODULUS')) clay%shear = card%number('SHEAR MODULUS')
      if (card%has('SHEAR MODULUS') .eqv. size(card%rows(1)%items) > 4) call state%fault_at(card, card%rows(1), &
        'either nu or SHEAR MODULUS is wanted, not both and not neither')
      call check_model(card, state, clay, hardening_soil_parameters_type())
    end associate
  end subroutine handle_cam_clay

  !> *HARDENING SOIL.
  subroutine handle_hardening_soil(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    associate (soil => state%analysis%materials(size(state%analysis%materials))%hardening_soil)
      soil%given = .true.
      if (size(card%rows) == 0) return
      if (.not. card%rows(1)%good) return
      call read_soil(card%rows(1), soil)
      soil%ocr = card%number('OCR')
      soil%pop = card%number('POP')
      if (card%has('SMALLEST PRESSURE')) soil%smallest_pressure = card%number('SMALLEST PRESSURE')
      call check_model(card, state, cam_clay_parameters_type(), soil)
    end associate
  end subroutine handle_hardening_soil

  !> Data line of *HARDENING SOIL.
  subroutine read_soil(row, soil)
    !> The data line.
    type(row_type), intent(in) :: row
    !> The soil.
    type(hardening_soil_parameters_type), intent(inout) :: soil

    soil%e50 = number_at(row, 1)
    soil%eoed = number_at(row, 2)
    soil%eur = number_at(row, 3)
    soil%power = number_at(row, 4)
    soil%poisson = number_at(row, 5)
    soil%reference = number_at(row, 6)
    soil%cohesion = number_at(row, 7)
    soil%friction_angle = number_at(row, 8)
    soil%dilatancy_angle = number_at(row, 9)
    if (size(row%items) > 9) soil%ratio = number_at(row, 10)
    if (size(row%items) > 10) soil%k0 = number_at(row, 11)
  end subroutine read_soil

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
    character(len=:), allocatable :: text

    associate (clay => material%cam_clay, soil => material%hardening_soil)
      if (clay%given) then
        text = '*CAM CLAY, OCR='//real_text(clay%ocr)//', PRECONSOLIDATION='//real_text(clay%preconsolidation)// &
          ', SMALLEST PRESSURE='//real_text(clay%smallest_pressure)
        if (clay%shear > 0.0_wp) then
          call echo%line(text//', SHEAR MODULUS='//real_text(clay%shear))
          call echo%line(' '//numbers([clay%slope, clay%lambda, clay%kappa, clay%volume]))
        else
          call echo%line(text)
          call echo%line(' '//numbers([clay%slope, clay%lambda, clay%kappa, clay%volume, clay%poisson]))
        end if
      end if
      if (.not. soil%given) return
      text = '*HARDENING SOIL, OCR='//real_text(soil%ocr)//', POP='//real_text(soil%pop)
      if (soil%smallest_pressure > 0.0_wp) text = text//', SMALLEST PRESSURE='//real_text(soil%smallest_pressure)
      call echo%line(text)
      text = ' '//numbers([soil%e50, soil%eoed, soil%eur, soil%power, soil%poisson, soil%reference, soil%cohesion, &
        soil%friction_angle, soil%dilatancy_angle, soil%ratio])
      if (soil%k0 > 0.0_wp) text = text//', '//real_text(soil%k0)
      call echo%line(text)
    end associate
  end subroutine echo_hardening
end module qsmpm_deck_hardening
