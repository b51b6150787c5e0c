!> Cards of a material whose model is in a shared library: *USER MATERIAL and *USER STATE, and their echo.
module qsmpm_deck_user_material
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: material_type
  use qsmpm_analysis_lists, only: append
  use qsmpm_cards, only: card_type, number_at
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_deck_words, only: bar_list, position_of, axis_words, interface_words, model_tangent_words, &
    answer_words
  use qsmpm_echo_lines, only: echo_type, quoted, numbers
  use qsmpm_keyword_table, only: table_type, in_material, once, kind_name, kind_file, kind_real, kind_integer, kind_word
  use qsmpm_path, only: directory_of, joined, absolute_path
  use qsmpm_text, only: integer_text, real_text
  use qsmpm_user_material, only: user_material_type, interface_udsm, interface_umat
  implicit none
  private

  public :: add_user_material_keywords, echo_user_material

  !> Constants of a UDSM, and numbers on a line of the echo.
  integer, parameter :: most_of_udsm = 50, on_a_line = 6

contains

  !> Entries of *USER MATERIAL and *USER STATE.
  subroutine add_user_material_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table
    type(user_material_type) :: user

    call table%add('USER MATERIAL', in_material, once, 'A model of your own in a shared library: an Abaqus UMAT '// &
      'or a '// &
      'PLAXIS UDSM; docs/doors.md says how it is built and called.', handle_user_material)
    call table%parameter('INTERFACE', kind_word, 'how the model is called', required=.true., &
      allowed=bar_list(interface_words))
    call table%parameter('LIBRARY', kind_file, "shared library, sought from the deck's directory, then from the "// &
      'working directory', required=.true.)
    call table%parameter('SYMBOL', kind_name, 'name of the procedure, UMAT or USER_MOD when not given; NAME as it '// &
      'is, NAME_ and NAME in small letters and NAME in capitals are tried; module::name is one of a Fortran module')
    call table%parameter('MODEL', kind_integer, 'number of the model in the library', &
      default=integer_text(user%model), &
      range='[1, inf)', needs='INTERFACE=UDSM')
    call table%parameter('STATE', kind_integer, 'state variables of a point; a UMAT has none when not given, a '// &
      'UDSM '// &
      'says it itself and must agree', range='[0, 10000]')
    call add_choices(table, user)
    call table%data('constants of the model, in any number of lines', 0, huge(1))
    call table%column('constant', kind_real, 'constants in the order in which the model wants them', repeated=.true.)
    call table%example('*USER MATERIAL, INTERFACE=UMAT, LIBRARY=libsand.so, STATE=14, TANGENT=NUMERICAL| 33, 0, '// &
      '1.5e6, 0.28| 0.55, 0.95, 1.05')

    call table%add('USER STATE', in_material, once, 'State variables of the points of a *USER MATERIAL at the '// &
      'start, '// &
      'zero where the list is shorter. A UDSM is handed them in its task 1 and may replace them.', handle_user_state)
    call table%parameter('ALONG', kind_word, 'axis along which they differ: each line is then a coordinate and '// &
      'the state variables there, linear between the lines and constant beyond; the coordinates rise', &
      allowed=bar_list(axis_words))
    call table%data('values, in any number of lines', 1, huge(1))
    call table%column('value', kind_real, 'state variables in the order of the model', repeated=.true.)
    call table%example('*USER STATE| 0, 0, 0, 0, 0, 0, 0.65')
  end subroutine add_user_material_keywords

  !> Choices of *USER MATERIAL.
  subroutine add_choices(table, user)
    type(table_type), intent(inout) :: table
    !> Defaults.
    type(user_material_type), intent(in) :: user

    call table%parameter('TANGENT', kind_word, 'tangent used: AUTO takes what the model is supposed to return '// &
      '(UMAT: '// &
      'CONSISTENT; UDSM: with iTang = 0 NUMERICAL), ELASTIC asks at no strain (UMAT) or task 6 (UDSM), NUMERICAL '// &
      'differentiates '// &
      'the stress, 12 calls more', default=trim(model_tangent_words(user%tangent)), &
      allowed=bar_list(model_tangent_words))
    call table%parameter('SYMMETRIC', kind_word, 'YES uses the symmetric part of the tangent: cheaper '// &
      'equations, more '// &
      'iterations', default='NO', allowed=bar_list(answer_words))
    call table%parameter('THREAD SAFE', kind_word, 'YES lets several threads call the model at once; it must be '// &
      'free '// &
      'of common blocks and saved variables', default='NO', allowed=bar_list(answer_words))
    call table%parameter('SILENT', kind_word, 'YES hides what the model prints to the standard output', default='NO', &
      allowed=bar_list(answer_words))
    call table%parameter('STATE OUTPUT', kind_word, 'YES writes the state variables to the results, as SDV1, SDV2, '// &
      '... with the names that a UDSM gives them', default='YES', allowed=bar_list(answer_words))
    call table%parameter('COMPONENTS', kind_integer, 'stress components that the model is told of: 6, or 4 in the '// &
      'plane', default=integer_text(user%components), range='[4, 6]', needs='INTERFACE=UMAT')
    call table%parameter('STIFFNESS', kind_real, "Young's modulus that scales stabilisation; when not given "// &
      "that of "// &
      "*ELASTIC or, without it, that of the model's tangent at no stress", range='(0, inf)')
    call table%parameter('UNDRAINED', kind_real, 'bulk modulus of the pore water over the porosity; the model '// &
      'is then '// &
      'undrained', range='(0, inf)', needs='INTERFACE=UDSM')
  end subroutine add_choices

  !> *USER MATERIAL.
  subroutine handle_user_material(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    associate (user => state%analysis%materials(size(state%analysis%materials))%user)
      user%given = .true.
      user%interface = max(interface_umat, position_of(card%word('INTERFACE'), interface_words))
      call find_library(card, user%library)
      user%symbol = card%value('SYMBOL')
      if (len(user%symbol) == 0) user%symbol = trim(merge('user_mod', 'umat    ', user%interface == interface_udsm))
      if (card%has('MODEL')) user%model = card%whole('MODEL')
      if (card%has('STATE')) user%states = card%whole('STATE')
      if (user%interface == interface_umat) user%states = max(0, user%states)
      user%tangent = position_of(card%word('TANGENT'), model_tangent_words) - 1
      user%symmetric = card%word('SYMMETRIC') == 'YES'
      user%thread_safe = card%word('THREAD SAFE') == 'YES'
      user%silent = card%word('SILENT') == 'YES'
      user%shows_state = card%word('STATE OUTPUT') == 'YES'
      if (card%has('COMPONENTS')) user%components = card%whole('COMPONENTS')
      if (card%has('STIFFNESS')) user%stiffness = card%number('STIFFNESS')
      if (card%has('UNDRAINED')) user%undrained = card%number('UNDRAINED')
      call take_numbers(card, user%constants)
      if (user%components == 5) call state%fault(card, 'COMPONENTS is 6 or 4')
      if (user%interface == interface_udsm .and. size(user%constants) > most_of_udsm) call state%fault(card, &
        'a UDSM has no more than '//integer_text(most_of_udsm)//' constants, here are '// &
        integer_text(size(user%constants)))
    end associate
  end subroutine handle_user_material

  !> The library beside the deck or, when it is not there, in the working directory.
  subroutine find_library(card, path)
    type(card_type), intent(in) :: card
    !> From the root; that beside the deck when there is none.
    character(len=:), allocatable, intent(out) :: path
    logical :: beside, here

    path = absolute_path(joined(directory_of(card%place%file), card%value('LIBRARY')))
    inquire (file=path, exist=beside)
    inquire (file=card%value('LIBRARY'), exist=here)
    if (here .and. .not. beside) path = absolute_path(card%value('LIBRARY'))
  end subroutine find_library

  !> *USER STATE.
  subroutine handle_user_state(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    associate (user => state%analysis%materials(size(state%analysis%materials))%user)
      if (card%has('ALONG')) then
        user%along = position_of(card%word('ALONG'), axis_words)
        call take_profile(card, state, user)
      else
        call take_numbers(card, user%start)
      end if
    end associate
  end subroutine handle_user_state

  !> State variables that differ along an axis: a level a line.
  subroutine take_profile(card, state, user)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    !> The material.
    type(user_material_type), intent(inout) :: user
    integer :: i, k, n

    if (user%along > state%dimension) call state%fault(card, 'ALONG=Z has no meaning in a plane model')
    if (size(card%rows) == 0) return
    if (.not. all([(card%rows(i)%good, i=1, size(card%rows))])) return
    n = size(card%rows(1)%items)
    if (n < 2 .or. any([(size(card%rows(i)%items) /= n, i=1, size(card%rows))])) then
      call state%fault(card, 'each line wants a coordinate and the same number of state variables')
      user%along = 0
      return
    end if
    allocate (user%levels(size(card%rows)), user%profile(n - 1, size(card%rows)))
    do i = 1, size(card%rows)
      user%levels(i) = number_at(card%rows(i), 1)
      user%profile(:, i) = [(number_at(card%rows(i), k), k=2, n)]
    end do
    if (any(user%levels(2:) <= user%levels(:size(user%levels) - 1))) &
      call state%fault(card, 'the coordinates must rise from line to line')
    user%start = user%profile(:, 1)
  end subroutine take_profile

  !> All numbers of a card.
  subroutine take_numbers(card, numbers)
    type(card_type), intent(in) :: card
    !> The numbers; faulty lines count as none.
    real(wp), allocatable, intent(out) :: numbers(:)
    integer :: i, k, n

    n = 0
    do i = 1, size(card%rows)
      if (card%rows(i)%good) n = n + size(card%rows(i)%items)
    end do
    allocate (numbers(n))
    n = 0
    do i = 1, size(card%rows)
      if (.not. card%rows(i)%good) cycle
      do k = 1, size(card%rows(i)%items)
        numbers(n + k) = number_at(card%rows(i), k)
      end do
      n = n + size(card%rows(i)%items)
    end do
  end subroutine take_numbers

  !> The cards of a material.
  subroutine echo_user_material(echo, material)
    !> The echo.
    type(echo_type), intent(inout) :: echo
    !> The material, with a model of the user's.
    type(material_type), intent(in) :: material
    character(len=:), allocatable :: text
    integer :: i

    associate (user => material%user)
      text = '*USER MATERIAL, INTERFACE='//trim(interface_words(user%interface))//', LIBRARY='//quoted(user%library)// &
        ', SYMBOL='//quoted(user%symbol)
      if (user%interface == interface_udsm) text = text//', MODEL='//integer_text(user%model)
      if (user%states >= 0) text = text//', STATE='//integer_text(user%states)
      text = text//', TANGENT='//trim(model_tangent_words(user%tangent))//', SYMMETRIC='//answer(user%symmetric)// &
        ', THREAD SAFE='//answer(user%thread_safe)//', SILENT='//answer(user%silent)// &
        ', STATE OUTPUT='//answer(user%shows_state)
      if (user%interface == interface_umat) text = text//', COMPONENTS='//integer_text(user%components)
      if (user%stiffness > 0.0_wp) text = text//', STIFFNESS='//real_text(user%stiffness)
      if (user%undrained > 0.0_wp) text = text//', UNDRAINED='//real_text(user%undrained)
      call echo%line(text)
      call echo_numbers(echo, user%constants)
      if (user%along > 0) then
        call echo%line('*USER STATE, ALONG='//trim(axis_words(user%along)))
        do i = 1, size(user%levels)
          call echo%line(' '//numbers([user%levels(i), user%profile(:, i)]))
        end do
      end if
      if (.not. allocated(user%start) .or. user%along > 0) return
      call echo%line('*USER STATE')
      call echo_numbers(echo, user%start)
    end associate
  end subroutine echo_user_material

  !> YES or NO.
  pure function answer(yes) result(word)
    !> Which.
    logical, intent(in) :: yes
    character(len=:), allocatable :: word

    word = trim(answer_words(merge(1, 0, yes)))
  end function answer

  !> Numbers, a few on a line.
  subroutine echo_numbers(echo, values)
    !> The echo.
    type(echo_type), intent(inout) :: echo
    !> The numbers.
    real(wp), intent(in) :: values(:)
    integer :: i

    do i = 1, size(values), on_a_line
      call echo%line(' '//numbers(values(i:min(size(values), i + on_a_line - 1))))
    end do
  end subroutine echo_numbers
end module qsmpm_deck_user_material
