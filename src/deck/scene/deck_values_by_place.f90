!> Spatially variable parameters of a material: *STRENGTH PROFILE, strength, and optionally stiffness, by depth, table
!> or stress; *FIELD OF VALUES, from samples of CSV or HDF5 files.
module qsmpm_deck_values_by_place
  use qsmpm_material_description, only: material_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_keyword_table, only: table_type, in_material, once, bar_list, axis_words
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: initial_keep
  use qsmpm_strength_profile, only: strength_profile_type, profile_table, varies_stiffness, reference_strength, &
    follows_stress
  use qsmpm_undrained_parameters, only: undrained_c
  use qsmpm_card_items, only: in_range
  use qsmpm_csv_columns, only: read_columns
  use qsmpm_error, only: error_type
  use qsmpm_finite, only: is_usable
  use qsmpm_hdf5_reader, only: reader_type, open_reader, get_array, close_reader
  use qsmpm_file, only: absolute_path, directory_of, extension_of, joined
  use qsmpm_text, only: integer_text
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_value_field, only: value_field_type, field_cohesion, field_friction, field_young, field_weight, &
    field_permeability, field_words, field_ranges, field_cards, law_fields, same_places, set_samples
  implicit none
  private

  public :: add_profile_keyword, check_profiles, check_value_fields

  character(len=5), parameter :: axes(3) = ['x    ', 'y    ', 'z    ']

contains

  !> Adds the keywords *STRENGTH PROFILE, *FIELD OF VALUES.
  subroutine add_profile_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('STRENGTH PROFILE', in_material, once, 'Cohesion of *MOHR COULOMB (s_u where phi = 0) that '// &
      'varies with the initial position of a point, or with its initial stress; c of *MOHR COULOMB is then the '// &
      'minimum value. Optionally the stiffness varies too: docs/methods/undrained.md.', profile_fields, &
      '*ELASTIC| 3000, 0.3|*MOHR COULOMB| 5, 0, 0|*STRENGTH PROFILE, STIFFNESS RATIO=300| 0, 10, 1.5', finish_profile)
    call table%add('FIELD OF VALUES', in_material, once, 'Spatially variable parameters of the material, from '// &
      'samples in a file at the initial position of a point: C and PHI of *MOHR COULOMB, E of *ELASTIC, GAMMA of '// &
      '*UNIT WEIGHT, K of *PERMEABILITY. The number of that keyword is then used only for decisions about the '// &
      'whole material; c there is the minimum, psi is at most PHI, and gamma_sat - GAMMA and k_y/K are kept: '// &
      'docs/howto/values_by_place.md.', value_fields, &
      '*MOHR COULOMB| 5, 30, 0|*FIELD OF VALUES| C, clay.csv| PHI, clay.csv, NEAREST', read_files)
  end subroutine add_profile_keyword

  !> Describes the fields of *STRENGTH PROFILE.
  subroutine profile_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (profile => deck%analysis%materials(deck%material)%strength_profile)
      call fields%given(profile%given)
      call fields%line(deck%analysis%materials(deck%material)%profile_where)
      call fields%choice('TYPE', profile%kind, 'LINEAR|TABLE|SHANSEP', 'LINEAR: strength + gain (level - Y); '// &
        'TABLE: linear between levels, constant beyond; SHANSEP: S sigma_v '// &
        '(sigma_p/sigma_v)^m of the vertical effective stress at the start, or at *UPDATE STRENGTH, and its past '// &
        'maximum, initially by OCR or POP of *K0')
      call fields%choice('ALONG', profile%along, bar_list(axis_words), 'axis of Y, the vertical')
      call fields%number('STIFFNESS RATIO', profile%stiffness_ratio, "Young's modulus over strength; E of *ELASTIC "// &
        'then has no effect', range='(0, inf)', needs='TYPE=LINEAR|TABLE')
      call fields%data('linear profile', when='TYPE=LINEAR')
      call fields%number('level', profile%level, 'coordinate')
      call fields%number('strength', profile%strength, 'cohesion at that level')
      call fields%number('gain', profile%gain, 'increase of cohesion per depth below it')
      call fields%data('strength by stress', when='TYPE=SHANSEP')
      call fields%number('S', profile%ratio, 's_u/sigma_v of normally consolidated clay', range='(0, inf)')
      call fields%number('m', profile%exponent, 'exponent of the overconsolidation ratio', range='[0, 1]', &
        required=.false.)
      call table_rows(fields, profile)
    end associate
  end subroutine profile_fields

  !> Describes the levels of a table.
  subroutine table_rows(fields, profile)
    class(card_fields_type), intent(inout) :: fields
    type(strength_profile_type), intent(inout) :: profile
    real(wp) :: young
    integer :: i, n

    n = 0
    if (allocated(profile%levels)) n = size(profile%levels)
    call fields%data('levels in order', 2, huge(1), when='TYPE=TABLE', rows=n)
    if (.not. fields%writing) then
      profile%levels = [(0.0_wp, i=1, n)]
      profile%strengths = profile%levels
      profile%moduli = profile%levels
    end if
    do i = 1, n
      call fields%row(i)
      young = -1.0_wp
      if (fields%writing .and. allocated(profile%moduli)) young = profile%moduli(i)
      call fields%number('level', profile%levels(i), 'coordinate')
      call fields%number('strength', profile%strengths(i), 'cohesion there')
      call fields%number('E', young, "Young's modulus there, in all rows or none", range='(0, inf)', required=.false.)
      if (fields%reading) profile%moduli(i) = young
    end do
  end subroutine table_rows

  !> Converts the rows into a profile.
  subroutine finish_profile(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (profile => state%analysis%materials(state%material)%strength_profile)
      if (any([(.not. state%card%rows(i)%good, i=1, size(state%card%rows))])) return
      if (profile%along > state%dimension .and. state%dimension > 0) call state%report_error('ALONG=Z has no '// &
        'meaning in a plane model')
      if (profile%kind == profile_table) call finish_table(state, profile)
      if (profile%kind /= profile_table .and. allocated(profile%levels)) deallocate (profile%levels, &
        profile%strengths, profile%moduli)
      if (profile%stiffness_ratio > 0.0_wp .and. &
        allocated(profile%moduli)) call state%report_error("give STIFFNESS RATIO or a column of Young's moduli, "// &
        "not both")
    end associate
  end subroutine finish_profile

  !> Checks that levels increase, and that either all rows have a stiffness or none.
  subroutine finish_table(state, profile)
    type(deck_state_type), intent(inout) :: state
    type(strength_profile_type), intent(inout) :: profile
    integer :: n

    n = size(profile%levels)
    if (n < 2) return
    if (profile%levels(1) > profile%levels(n)) then
      profile%levels = profile%levels(n:1:-1)
      profile%strengths = profile%strengths(n:1:-1)
      profile%moduli = profile%moduli(n:1:-1)
    end if
    if (any(profile%levels(2:) <= profile%levels(:n - 1))) call state%report_error('the levels must increase or '// &
      'decrease from line to line')
    profile%level = profile%levels(n)
    if (any(profile%moduli > 0.0_wp) .and. .not. all(profile%moduli > 0.0_wp)) call state%report_error("Young's "// &
      "modulus is required in all lines or none")
    if (.not. all(profile%moduli > 0.0_wp)) deallocate (profile%moduli)
  end subroutine finish_table

  !> Checks the profiles of complete materials.
  subroutine check_profiles(state)
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: sentence
    integer :: i

    call check_updates(state)
    do i = 1, size(state%analysis%materials)
      associate (material => state%analysis%materials(i))
        if (.not. material%strength_profile%given) cycle
        sentence = wrong_material(material)
        if (len(sentence) == 0 .and. follows_stress(material%strength_profile)) sentence = wrong_start(state, material)
        if (len(sentence) > 0) call state%error_from(material%profile_where, 'STRENGTH PROFILE', &
          "material '"//material%name//"': "//sentence)
      end associate
    end do
  end subroutine check_profiles

  !> Checks that a phase with *UPDATE STRENGTH has a material whose strength depends on the effective stress.
  subroutine check_updates(state)
    type(deck_state_type), intent(inout) :: state
    integer :: p, m

    do m = 1, size(state%analysis%materials)
      associate (material => state%analysis%materials(m))
        if (follows_stress(material%strength_profile) .and. &
          .not. (material%undrained%given .and. material%undrained%kind == undrained_c)) return
      end associate
    end do
    do p = 1, size(state%analysis%phases)
      if (state%analysis%phases(p)%updates_strength) call state%error_from(state%analysis%phases(p)%strength_where, &
        'UPDATE STRENGTH', 'no material has a *STRENGTH PROFILE, TYPE=SHANSEP and effective stresses that it could '// &
        'follow (not *UNDRAINED, TYPE=C)')
    end do
  end subroutine check_updates

  !> Returns the fault of a material with a profile, empty if there is none.
  function wrong_material(material) result(sentence)
    type(material_type), intent(in) :: material
    character(len=:), allocatable :: sentence

    sentence = ''
    if (material%user%given .or. allocated(material%soil_law)) then
      sentence = 'a profile supports *ELASTIC with or without *MOHR COULOMB; for a user model use *USER STATE, ALONG='
    else if (material%softening%given) then
      sentence = 'a profile does not support *SOFTENING'
    else if (material%tensile_strength > 0.0_wp .and. material%tensile_strength < huge(1.0_wp)) then
      sentence = 'with a profile the tensile strength of *MOHR COULOMB must be 0 or NONE'
    else if (.not. (material%mohr_coulomb .or. varies_stiffness(material%strength_profile))) then
      sentence = 'the material has neither *MOHR COULOMB, whose cohesion it defines, nor STIFFNESS RATIO or a '// &
        'column of moduli'
    else if (.not. reference_strength(material%strength_profile) > 0.0_wp) then
      sentence = 'all of its strengths are zero'
    else if (follows_stress(material%strength_profile) .and. (.not. material%mohr_coulomb .or. &
      material%friction_angle > 0.0_wp)) then
      sentence = 'TYPE=SHANSEP is a strength s_u: it requires *MOHR COULOMB with phi = 0'
    end if
  end function wrong_material

  !> Returns the fault of the initial state of soil whose strength follows its stress, empty if there is none.
  function wrong_start(state, material) result(sentence)
    type(deck_state_type), intent(in) :: state
    type(material_type), intent(in) :: material
    character(len=:), allocatable :: sentence
    integer :: b, p, i

    sentence = ''
    associate (analysis => state%analysis)
      do b = 1, size(analysis%bodies)
        if (analysis%bodies(b)%material /= material%name) cycle
        do p = 1, size(analysis%phases)
          if (p == 1 .and. analysis%phases(p)%initial%kind == initial_keep) sentence = 'begins'
          do i = 1, size(analysis%phases(p)%activations)
            if (analysis%phases(p)%activations(i)%body == analysis%bodies(b)%name) sentence = 'is put in'
          end do
        end do
        if (len(sentence) == 0) cycle
        sentence = "body '"//analysis%bodies(b)%name//"' "//sentence//' without stress, and TYPE=SHANSEP takes the '// &
          'strength from that: *INITIAL in the first phase, or another material until *CHANGE MATERIAL gives it '// &
          'this one under load'
        return
      end do
    end associate
  end function wrong_start

  !> Describes the fields of *FIELD OF VALUES.
  subroutine value_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    type(value_field_type), allocatable :: list(:)
    integer :: i, n

    associate (material => deck%analysis%materials(deck%material))
      allocate (list(0))
      if (allocated(material%strength_profile%fields)) list = material%strength_profile%fields
      n = size(list)
      call fields%line(material%fields_where)
      call fields%list('a parameter and its samples', n)
      if (.not. fields%writing) list = [(value_field_type(), i=1, n)]
      do i = 1, n
        call fields%row(i)
        call fields%choice('parameter', list(i)%parameter, 'C|PHI|E|GAMMA|K', 'as of its own keyword')
        call fields%file('file', list(i)%file, 'CSV, whose first line names the columns x, y, in space z, and the '// &
          'parameter, or HDF5 (.h5, .hdf5) with data sets of these names; relative to the deck')
        call fields%choice('between', list(i)%between, 'LINEAR|NEAREST', 'LINEAR (when not given): interpolation '// &
          'between the surrounding samples, without extrapolation; NEAREST: value of the nearest '// &
          'sample', required=.false.)
      end do
      if (fields%reading) call move_alloc(list, material%strength_profile%fields)
    end associate
  end subroutine value_fields

  !> Reads the samples of all rows.
  subroutine read_files(state)
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: sentence
    integer :: i

    associate (list => state%analysis%materials(state%material)%strength_profile%fields)
      do i = 1, size(list)
        if (.not. state%card%rows(i)%good) cycle
        list(i)%file = absolute_path(joined(directory_of(state%card%place%file), list(i)%file))
        if (any(list(:i - 1)%parameter == list(i)%parameter)) then
          sentence = trim(field_words(list(i)%parameter))//' stands there twice'
        else
          call read_samples(list(i), merge(3, 2, state%dimension == 3), sentence)
        end if
        if (len(sentence) > 0) call state%error_at(state%card%rows(i), sentence)
      end do
    end associate
  end subroutine read_files

  !> Reads the samples of a file, and checks each against the range of the parameter.
  subroutine read_samples(field, dimension, sentence)
    type(value_field_type), intent(inout) :: field
    integer, intent(in) :: dimension
    !> The fault, empty if there is none.
    character(len=:), allocatable, intent(out) :: sentence
    type(error_type), allocatable :: error
    !> (dimension + 1, samples), the parameter last; line of each sample, or its number.
    real(wp), allocatable :: table(:, :)
    integer, allocatable :: lines(:)
    character(len=:), allocatable :: row
    integer :: pair(2), i

    sentence = ''
    row = ':'
    if (any(extension_of(field%file) == [character(len=5) :: '.h5', '.hdf5'])) then
      row = ', sample '
      call read_hdf5(field, dimension, table, sentence)
      allocate (lines(size(table, 2)), source=[(i, i=1, size(table, 2))])
      if (len(sentence) == 0 .and. size(lines) == 0) sentence = 'there is no sample'
      if (len(sentence) > 0) sentence = field%file//': '//sentence
    else
      call read_columns(field%file, [axes(:dimension), field_words(field%parameter)], dimension + 1, 'x, y'// &
        trim(merge(', z', '   ', dimension == 3))//', '//trim(field_words(field%parameter)), table, lines, error)
      if (allocated(error)) sentence = error%message
    end if
    if (len(sentence) > 0) return
    do i = 1, size(lines)
      sentence = sentence_of(table(:, i), field%parameter)
      if (len(sentence) == 0) cycle
      sentence = field%file//row//integer_text(lines(i))//': '//sentence
      exit
    end do
    if (len(sentence) > 0) return
    call set_samples(field, table(:dimension, :), table(dimension + 1, :))
    pair = same_places(field)
    if (pair(1) > 0) sentence = field%file//': two samples are at ('//rounded_text(field%places(1, pair(1)))//', '// &
      rounded_text(field%places(2, pair(1)))//'): their order is ambiguous'
  end subroutine read_samples

  !> Returns the fault of a sample, empty if there is none.
  pure function sentence_of(sample, parameter) result(sentence)
    !> Place and value.
    real(wp), intent(in) :: sample(:)
    integer, intent(in) :: parameter
    character(len=:), allocatable :: sentence

    sentence = ''
    if (.not. all(is_usable(sample))) then
      sentence = 'a number is not finite'
    else if (.not. in_range(sample(size(sample)), trim(field_ranges(parameter)))) then
      sentence = trim(field_words(parameter))//' = '//rounded_text(sample(size(sample)))//' is outside '// &
        trim(field_ranges(parameter))
    end if
  end function sentence_of

  !> Reads the data sets of an HDF5 file, one row of numbers each.
  subroutine read_hdf5(field, dimension, table, sentence)
    type(value_field_type), intent(in) :: field
    integer, intent(in) :: dimension
    real(wp), allocatable, intent(out) :: table(:, :)
    character(len=:), allocatable, intent(out) :: sentence
    type(reader_type) :: reader
    type(error_type), allocatable :: error
    real(wp), allocatable :: values(:)
    character(len=:), allocatable :: name
    integer :: k

    sentence = ''
    allocate (table(dimension + 1, 0))
    call open_reader(reader, field%file)
    do k = 1, dimension + 1
      name = trim(field_words(field%parameter))
      if (k <= dimension) name = trim(axes(k))
      if (allocated(values)) deallocate (values)
      call get_array(reader, name, values)
      if (allocated(reader%reason)) exit
      if (.not. allocated(values)) then
        sentence = "there is no data set '"//name//"'"
        exit
      end if
      if (k == 1) then
        deallocate (table)
        allocate (table(dimension + 1, size(values)))
      end if
      if (size(values) /= size(table, 2)) then
        sentence = "data set '"//name//"' has another size than 'x'"
        exit
      end if
      table(k, :) = values
    end do
    if (allocated(reader%reason)) sentence = reader%reason
    call close_reader(reader, error)
  end subroutine read_hdf5

  !> Checks the fields of complete materials.
  subroutine check_value_fields(state)
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: sentence
    integer :: m, i

    do m = 1, size(state%analysis%materials)
      associate (material => state%analysis%materials(m))
        if (.not. allocated(material%strength_profile%fields)) cycle
        do i = 1, size(material%strength_profile%fields)
          associate (parameter => material%strength_profile%fields(i)%parameter)
            ! A row with an error has already been reported.
            if (parameter == 0) cycle
            sentence = wrong_law(state, material, parameter)
            if (len(sentence) == 0) sentence = wrong_card(material, parameter)
            if (len(sentence) > 0) call state%error_from(material%fields_where, 'FIELD OF VALUES', &
              "material '"//material%name//"': "//sentence)
          end associate
        end do
      end associate
    end do
  end subroutine check_value_fields

  !> Returns the reason why a parameter of the law cannot vary in space, empty if it can.
  function wrong_law(state, material, parameter) result(sentence)
    type(deck_state_type), intent(in) :: state
    type(material_type), intent(in) :: material
    integer, intent(in) :: parameter
    character(len=:), allocatable :: sentence, name

    sentence = ''
    if (all(parameter /= law_fields)) return
    name = trim(field_words(parameter))//' of *'//trim(field_cards(parameter))
    if (state%analysis%point_test%given) then
      sentence = 'a point test has no place that '//name//' could be of: give numbers'
    else if (material%user%given .or. material%own_law .or. allocated(material%soil_law)) then
      sentence = name//' by place is for *ELASTIC with or without *MOHR COULOMB; other laws have GAMMA and K by '// &
        'place, a user model *USER STATE, ALONG=, and bodies with materials of their own do the rest'
    else if (material%softening%given) then
      sentence = 'a softening strength must be uniform: remove *SOFTENING, or '//name//' by place'
    else if (material%tensile_strength > 0.0_wp .and. material%tensile_strength < huge(1.0_wp)) then
      sentence = 'the tensile strength of *MOHR COULOMB is 0 or NONE where '//name//' differs by place'
    end if
  end function wrong_law

  !> Returns the keyword of the material that a parameter contradicts, empty if none.
  pure function wrong_card(material, parameter) result(sentence)
    type(material_type), intent(in) :: material
    integer, intent(in) :: parameter
    character(len=:), allocatable :: sentence
    logical :: there

    sentence = ''
    associate (profile => material%strength_profile)
      select case (parameter)
      case (field_cohesion)
        there = material%mohr_coulomb
        if (profile%given) sentence = 'C by place and *STRENGTH PROFILE are two strengths: give one'
      case (field_friction)
        there = material%mohr_coulomb .and. material%friction_angle > 0.0_wp
        if (follows_stress(profile)) sentence = 'TYPE=SHANSEP of *STRENGTH PROFILE is a strength without friction'
        if (material%at_rest%jaky) sentence = 'TYPE=JAKY of *K0 requires a uniform friction angle: give K0 as a number'
      case (field_young)
        there = material%young > 0.0_wp
        if (follows_stress(profile) .or. profile%stiffness_ratio > 0.0_wp .or. allocated(profile%moduli)) sentence = &
          'E by place excludes TYPE=SHANSEP, STIFFNESS RATIO and a column of moduli of *STRENGTH PROFILE'
      case (field_weight)
        there = material%unit_weight > 0.0_wp
      case (field_permeability)
        there = material%permeability(1) > 0.0_wp
      end select
      if (.not. there) sentence = trim(field_words(parameter))//' by place requires a positive one on *'// &
        trim(field_cards(parameter))//' too, for decisions about the whole material'
    end associate
  end function wrong_card
end module qsmpm_deck_values_by_place
