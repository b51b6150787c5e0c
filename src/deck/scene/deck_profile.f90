!> *STRENGTH PROFILE: strength, and stiffness where asked for, by depth, table or stress.
module qsmpm_deck_profile
  use qsmpm_material_description, only: material_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_deck_words, only: bar_list, axis_words
  use qsmpm_keyword_table, only: table_type, in_material, once
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: initial_keep
  use qsmpm_strength_profile, only: strength_profile_type, profile_table, varies_stiffness, &
    reference_strength, follows_stress
  use qsmpm_undrained_parameters, only: undrained_c
  implicit none
  private

  public :: add_profile_keyword, check_profiles

contains

  !> *STRENGTH PROFILE.
  subroutine add_profile_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('STRENGTH PROFILE', in_material, once, 'Cohesion of *MOHR COULOMB (s_u where phi = 0) that '// &
      'differs from place to place, by the place where a point is at its start or by its stress there; c of *MOHR '// &
      'COULOMB is its least value then. On request the stiffness follows: docs/methods/undrained.md.', profile_fields, &
      '*ELASTIC| 3000, 0.3|*MOHR COULOMB| 5, 0, 0|*STRENGTH PROFILE, STIFFNESS RATIO=300| 0, 10, 1.5', finish_profile)
  end subroutine add_profile_keyword

  !> Its fields.
  subroutine profile_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (profile => deck%analysis%materials(deck%material)%strength_profile)
      call fields%given(profile%given)
      call fields%line(deck%analysis%materials(deck%material)%profile_where)
      call fields%choice('TYPE', profile%kind, 'LINEAR|TABLE|SHANSEP', 'LINEAR: strength + gain (level - Y); '// &
        'TABLE: linear between levels, constant beyond; SHANSEP: S sigma_v '// &
        '(sigma_p/sigma_v)^m of the vertical effective stress at the start, or at a *UPDATE STRENGTH, and the '// &
        'largest one so far, at the start by OCR or POP of *K0')
      call fields%choice('ALONG', profile%along, bar_list(axis_words), 'axis of Y, the vertical')
      call fields%number('STIFFNESS RATIO', profile%stiffness_ratio, "Young's modulus over strength; E of *ELASTIC "// &
        'then has no effect', range='(0, inf)', needs='TYPE=LINEAR|TABLE')
      call fields%data('linear profile', when='TYPE=LINEAR')
      call fields%number('level', profile%level, 'coordinate')
      call fields%number('strength', profile%strength, 'cohesion at that level')
      call fields%number('gain', profile%gain, 'gain of cohesion with depth below it')
      call fields%data('strength by stress', when='TYPE=SHANSEP')
      call fields%number('S', profile%ratio, 's_u/sigma_v of normally consolidated clay', range='(0, inf)')
      call fields%number('m', profile%exponent, 'exponent of the overconsolidation ratio', range='[0, 1]', &
        required=.false.)
      call table_rows(fields, profile)
    end associate
  end subroutine profile_fields

  !> Levels of a table.
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

  !> Rows become a profile.
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

  !> Levels rise, and all rows have a stiffness or none.
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
    if (any(profile%levels(2:) <= profile%levels(:n - 1))) call state%report_error('the levels must rise or fall '// &
      'from line to line')
    profile%level = profile%levels(n)
    if (any(profile%moduli > 0.0_wp) .and. .not. all(profile%moduli > 0.0_wp)) call state%report_error("Young's "// &
      "modulus is wanted in all lines or none")
    if (.not. all(profile%moduli > 0.0_wp)) deallocate (profile%moduli)
  end subroutine finish_table

  !> What belongs to the profiles of complete materials.
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

  !> A phase that asks for strengths by the stress has a material of such a strength, of effective stress.
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

  !> What is wrong with the profile of a material, empty for nothing.
  function wrong_material(material) result(sentence)
    type(material_type), intent(in) :: material
    character(len=:), allocatable :: sentence

    sentence = ''
    if (material%user%given .or. allocated(material%soil_law)) then
      sentence = 'a profile is for *ELASTIC with or without *MOHR COULOMB; a user model has *USER STATE, ALONG='
    else if (material%softening%given) then
      sentence = 'strength that softens has no profile'
    else if (material%tensile_strength > 0.0_wp .and. material%tensile_strength < huge(1.0_wp)) then
      sentence = 'the tensile strength of *MOHR COULOMB is 0 or NONE with a profile'
    else if (.not. (material%mohr_coulomb .or. varies_stiffness(material%strength_profile))) then
      sentence = 'there is no *MOHR COULOMB whose cohesion it could be, and no STIFFNESS RATIO or column of moduli'
    else if (.not. reference_strength(material%strength_profile) > 0.0_wp) then
      sentence = 'all of its strengths are zero'
    else if (follows_stress(material%strength_profile) .and. (.not. material%mohr_coulomb .or. &
      material%friction_angle > 0.0_wp)) then
      sentence = 'TYPE=SHANSEP is a strength s_u: it wants *MOHR COULOMB with phi = 0'
    end if
  end function wrong_material

  !> What is wrong with the start of soil whose strength follows its stress, empty for nothing: it needs one.
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
end module qsmpm_deck_profile
