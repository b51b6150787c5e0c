!> *STRENGTH CONSTANTS of a material: which constants of its law a factor of safety divides.
module qsmpm_deck_strength_constants
  use qsmpm_material_description, only: material_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_deck_words, only: bar_list
  use qsmpm_error, only: error_type
  use qsmpm_keyword_table, only: table_type, in_material, once
  use qsmpm_strength_constants, only: strength_constant_type, lowering_words, divide_tangent, follow_friction
  use qsmpm_strength_factor, only: strength_factor_type
  use qsmpm_law_parameters, only: law_parameters_type
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: integer_text, real_text
  implicit none
  private

  public :: add_strength_constants_keyword, check_strength_constants

contains

  !> *STRENGTH CONSTANTS.
  subroutine add_strength_constants_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('STRENGTH CONSTANTS', in_material, once, 'Constants of *USER MATERIAL or *CAM CLAY that are its '// &
      'strength, a line each: what a phase of TYPE=SAFETY divides by its factor F. Constants that are not named '// &
      'stay.', constants_fields, '*USER MATERIAL, INTERFACE=UMAT, LIBRARY=libsand.so| 200, 0.33, 1, 25, 0'// &
      '|*STRENGTH CONSTANTS| 3, DIVIDE| 4, TAN| 5, DILATANCY')
  end subroutine add_strength_constants_keyword

  !> Fields of *STRENGTH CONSTANTS.
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
      call fields%list('a constant and how it is lowered', n)
      if (.not. fields%writing) list = [(strength_constant_type(), i=1, n)]
      do i = 1, n
        call fields%row(i)
        call fields%whole('constant', list(i)%number, 'its number from 1, in the order of the data lines of the law', &
          range='[1, inf)')
        call fields%choice('rule', list(i)%rule, bar_list(lowering_words), 'DIVIDE: c/F; TAN: an angle in degrees, '// &
          'atan(tan(phi)/F); DILATANCY: an angle in degrees that stays until the smallest lowered one of TAN comes '// &
          'down to it')
      end do
      if (fields%reading) call move_alloc(list, material%strength_constants)
    end associate
  end subroutine constants_fields

  !> Constants that there are, once each, of a law that does not know its strength.
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

  !> What is wrong with the list, empty for nothing.
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
        sentence = 'what is divided of the strength of *MOHR COULOMB is known: the card is for *USER MATERIAL and '// &
          '*CAM CLAY'
      else
        sentence = fault_of_user(list, material%user%constants)
      end if
    end associate
  end subroutine find_fault

  !> What is wrong with the list of a model of the user's.
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
      'an angle of DILATANCY wants one of friction beside it, by TAN'
  end function fault_of_user
end module qsmpm_deck_strength_constants
