!> Keywords of a material whose model is in a shared library, *USER MATERIAL and *USER STATE, and *STRENGTH CONSTANTS:
!> the constants of a law that a factor of safety divides.
module qsmpm_deck_user_material
  use qsmpm_cards, only: card_type, number_at
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type, beside_deck
  use qsmpm_card_visitors, only: numbers
  use qsmpm_keyword_table, only: table_type, in_material, once, bar_list, axis_words, interface_words, &
    model_tangent_words
  use qsmpm_file, only: absolute_path
  use qsmpm_text, only: integer_text, real_text
  use qsmpm_user_material, only: user_material_type, interface_udsm, interface_umat, model_tangent_auto
  use qsmpm_material_description, only: material_type
  use qsmpm_error, only: error_type
  use qsmpm_strength_factor, only: strength_factor_type, strength_constant_type, lowering_words, divide_tangent, &
    follow_friction
  use qsmpm_law_parameters, only: law_parameters_type
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: add_user_material_keywords, check_strength_constants

  !> Largest number of constants of a UDSM.
  integer, parameter :: most_of_udsm = 50

contains

  !> Adds the keywords *USER MATERIAL, *USER STATE, *STRENGTH CONSTANTS.
  subroutine add_user_material_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('USER MATERIAL', in_material, once, 'A model of your own in a shared library: an Abaqus UMAT or '// &
      'a PLAXIS UDSM; docs/user_models.md says how it is built and called.', user_material_fields, &
        '*USER MATERIAL, '// &
      'INTERFACE=UMAT, LIBRARY=libsand.so, STATE=14, TANGENT=NUMERICAL| 33, 0, 1.5e6, 0.28| 0.55, 0.95, 1.05', &
      finish_user_material)
    call table%add('USER STATE', in_material, once, 'State variables of the points of a *USER MATERIAL at the '// &
      'start, zero where the list is shorter. A UDSM is handed them in its task 1 and may replace them.', &
        user_state_fields, '*USER STATE| 0, 0, 0, 0, 0, 0, 0.65', read_profile)
    call table%add('STRENGTH CONSTANTS', in_material, once, 'Constants of *USER MATERIAL or *CAM CLAY that are its '// &
      'strength, a line each: what a phase of TYPE=SAFETY divides by its factor F. Constants that are not named '// &
      'stay.', constants_fields, '*USER MATERIAL, INTERFACE=UMAT, LIBRARY=libsand.so| 200, 0.33, 1, 25, 0'// &
      '|*STRENGTH CONSTANTS| 3, DIVIDE| 4, TAN| 5, DILATANCY')
  end subroutine add_user_material_keywords

  !> Describes the fields of *USER MATERIAL.
  subroutine user_material_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (user => deck%analysis%materials(deck%material)%user)
      call fields%given(user%given)
      call fields%choice('INTERFACE', user%interface, bar_list(interface_words), 'how the model is called', &
        required=.true.)
      call fields%file('LIBRARY', user%library, "shared library, sought from the deck's directory, then from the "// &
        'working directory', required=.true.)
      call fields%name('SYMBOL', user%symbol, 'name of the procedure, UMAT or USER_MOD when not given; NAME as it '// &
        'is, NAME_ and NAME in small letters and NAME in capitals are tried; module::name is one of a Fortran module')
      call fields%whole('MODEL', user%model, 'number of the model in the library', range='[1, inf)', &
        needs='INTERFACE=UDSM')
      call fields%whole('STATE', user%states, 'state variables of a point; a UMAT has none when not given, a UDSM '// &
        'says it itself and must agree', range='[0, 10000]')
      call choice_fields(fields, user)
      call fields%data('constants of the model, in any number of lines', 0, huge(1))
      call fields%numbers('constant', user%constants, 'constants in the order in which the model requires them')
    end associate
  end subroutine user_material_fields

  !> Describes the choices of *USER MATERIAL.
  subroutine choice_fields(fields, user)
    class(card_fields_type), intent(inout) :: fields
    type(user_material_type), intent(inout) :: user

    call fields%choice('TANGENT', user%tangent, bar_list(model_tangent_words), 'tangent used: AUTO uses what the '// &
      'model is expected to return (UMAT: CONSISTENT; UDSM: with iTang = 0 NUMERICAL), ELASTIC calls it at zero '// &
      'strain (UMAT) or with task 6 (UDSM), NUMERICAL differentiates the stress with 12 more '// &
      'calls', first=model_tangent_auto)
    call fields%answer('SYMMETRIC', user%symmetric, 'YES uses the symmetric part of the tangent: cheaper '// &
      'equations, more iterations')
    call fields%answer('THREAD SAFE', user%thread_safe, 'YES: several threads call the model concurrently; it must '// &
      'not use common blocks or saved variables')
    call fields%answer('SILENT', user%silent, 'YES: suppresses what the model prints to standard output')
    call fields%answer('STATE OUTPUT', user%shows_state, 'YES writes the state variables to the results, as SDV1, '// &
      'SDV2, ... with the names that a UDSM gives them')
    call fields%whole('COMPONENTS', user%components, 'stress components passed to the model: 6, or 4 in plane '// &
      'models', range='[4, 6]', needs='INTERFACE=UMAT')
    call fields%number('STIFFNESS', user%stiffness, "Young's modulus that scales the stabilisation; when not given "// &
      "that of *ELASTIC, otherwise of the model's tangent at zero stress", range='(0, inf)')
    call fields%number('UNDRAINED', user%undrained, 'bulk modulus of the pore water over the porosity; the model '// &
      'is then undrained', range='(0, inf)', needs='INTERFACE=UDSM')
  end subroutine choice_fields

  !> Finds the library, and sets missing options from the interface.
  subroutine finish_user_material(state)
    type(deck_state_type), intent(inout) :: state

    associate (user => state%analysis%materials(state%material)%user)
      call find_library(state%card, user%library)
      if (len(user%symbol) == 0) user%symbol = trim(merge('user_mod', 'umat    ', user%interface == interface_udsm))
      if (user%interface == interface_umat) user%states = max(0, user%states)
      if (user%components == 5) call state%report_error('COMPONENTS is 6 or 4')
      if (user%interface == interface_udsm .and. size(user%constants) &
        > most_of_udsm) call state%report_error('a UDSM has no more than '//integer_text(most_of_udsm)// &
        ' constants, here are '//integer_text(size(user%constants)))
    end associate
  end subroutine finish_user_material

  !> Finds the library in the folder of the deck or, if it is not there, in the working directory.
  subroutine find_library(card, path)
    type(card_type), intent(in) :: card
    !> Absolute path; that in the folder of the deck if there is none.
    character(len=:), allocatable, intent(inout) :: path
    logical :: beside, here

    path = beside_deck(card, 'LIBRARY')
    inquire (file=path, exist=beside)
    inquire (file=card%value('LIBRARY'), exist=here)
    if (here .and. .not. beside) path = absolute_path(card%value('LIBRARY'))
  end subroutine find_library

  !> Describes *USER STATE: values, or a coordinate and values per line.
  subroutine user_state_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    integer :: i

    associate (user => deck%analysis%materials(deck%material)%user)
      call fields%there(allocated(user%start) .or. user%along > 0)
      call fields%choice('ALONG', user%along, bar_list(axis_words), 'axis along which they differ: each line is '// &
        'then a coordinate and the state variables there, linear between the lines and constant beyond; '// &
        'the coordinates rise', open=.true.)
      if (fields%writing .and. user%along > 0) then
        do i = 1, size(user%levels)
          call fields%raw(' '//numbers([user%levels(i), user%profile(:, i)]))
        end do
        return
      end if
      call fields%data('values, in any number of lines', 1, huge(1))
      call fields%numbers('value', user%start, 'state variables in the order of the model')
    end associate
  end subroutine user_state_fields

  !> Reads state variables that vary along an axis, one level per line.
  subroutine read_profile(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i, k, n

    associate (user => state%analysis%materials(state%material)%user)
      if (user%along == 0) return
      if (user%along > state%dimension) call state%report_error('ALONG=Z has no meaning in a plane model')
      if (.not. state%card%is_right()) return
      n = size(state%card%rows(1)%items)
      if (n < 2 .or. any([(size(state%card%rows(i)%items) /= n, i=1, size(state%card%rows))])) then
        call state%report_error('each line requires a coordinate and the same number of state variables')
        user%along = 0
        return
      end if
      allocate (user%levels(size(state%card%rows)), user%profile(n - 1, size(state%card%rows)))
      do i = 1, size(state%card%rows)
        user%levels(i) = number_at(state%card%rows(i), 1)
        user%profile(:, i) = [(number_at(state%card%rows(i), k), k=2, n)]
      end do
      if (any(user%levels(2:) <= user%levels(:size(user%levels) - 1))) call state%report_error('the coordinates '// &
        'must rise from line to line')
      user%start = user%profile(:, 1)
    end associate
  end subroutine read_profile

  !> Describes the fields of *STRENGTH CONSTANTS.
  subroutine constants_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    type(strength_constant_type), allocatable :: list(:)
    integer :: i, n

    associate (material => deck%analysis%materials(deck%material))
      allocate (list(0))
      if (allocated(material%strength_constants)) list = material%strength_constants
      n = size(list)
      call fields%line(material%strength_where)
      call fields%list('a constant and how it is reduced', n)
      if (.not. fields%writing) list = [(strength_constant_type(), i=1, n)]
      do i = 1, n
        call fields%row(i)
        call fields%whole('constant', list(i)%number, 'its number from 1, in the order of the data lines of the law', &
          range='[1, inf)')
        call fields%choice('rule', list(i)%rule, bar_list(lowering_words), 'DIVIDE: c/F; TAN: an angle in degrees, '// &
          'atan(tan(phi)/F); DILATANCY: an angle in degrees that is kept until the smallest reduced angle of TAN '// &
          'equals it')
      end do
      if (fields%reading) call move_alloc(list, material%strength_constants)
    end associate
  end subroutine constants_fields

  !> Checks that the constants exist, once each, and belong to a law whose strength parameters are unknown.
  subroutine check_strength_constants(state)
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: sentence
    integer :: m

    do m = 1, size(state%analysis%materials)
      associate (material => state%analysis%materials(m))
        if (.not. allocated(material%strength_constants)) cycle
        ! Rows that could not be read.
        if (any(material%strength_constants%number < 1)) cycle
        call find_fault(material, sentence)
        if (len(sentence) > 0) call state%error_from(material%strength_where, 'STRENGTH CONSTANTS', "material '"// &
          material%name//"': "//sentence)
      end associate
    end do
  end subroutine check_strength_constants

  !> Returns the fault of the list, empty if there is none.
  subroutine find_fault(material, sentence)
    type(material_type), intent(in) :: material
    character(len=:), allocatable, intent(out) :: sentence
    class(law_parameters_type), allocatable :: law
    type(error_type), allocatable :: error

    sentence = ''
    associate (list => material%strength_constants)
      if (allocated(material%soil_law)) then
        allocate (law, source=material%soil_law)
        call law%lower_named(list, strength_factor_type(), error)
        if (allocated(error)) sentence = error%message
      else if (.not. material%user%given) then
        sentence = 'the strength parameters of *MOHR COULOMB are known: this keyword is for *USER MATERIAL and '// &
          '*CAM CLAY'
      else
        sentence = fault_of_user(list, material%user%constants)
      end if
    end associate
  end subroutine find_fault

  !> Returns the fault of the list of a user model.
  pure function fault_of_user(list, constants) result(sentence)
    type(strength_constant_type), intent(in) :: list(:)
    real(wp), intent(in) :: constants(:)
    character(len=:), allocatable :: sentence
    integer :: i

    sentence = ''
    do i = 1, size(list)
      associate (number => list(i)%number, angle => list(i)%rule == divide_tangent .or. list(i)%rule == follow_friction)
        if (number > size(constants)) then
          sentence = 'there is no constant '//integer_text(number)//', *USER MATERIAL has '// &
            integer_text(size(constants))
        else if (any(list(:i - 1)%number == number)) then
          sentence = 'constant '//integer_text(number)//' stands there twice'
        else if (angle .and. .not. abs(constants(number)) < 90.0_wp) then
          sentence = 'constant '//integer_text(number)//' is '//real_text(constants(number))//', no angle in degrees'
        end if
      end associate
      if (len(sentence) > 0) return
    end do
    if (any(list%rule == follow_friction) .and. .not. any(list%rule == divide_tangent)) sentence = &
      'an angle of DILATANCY requires a friction angle by TAN'
  end function fault_of_user
end module qsmpm_deck_user_material
