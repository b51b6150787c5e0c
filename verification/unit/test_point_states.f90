!> States of material points of several laws in one model: what results call them, and initial stresses that a law
!> cannot carry.
module test_point_states
  use deck_samples, only: joined
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_fields, only: state_name, state_values
  use qsmpm_initial_strength, only: count_beyond_strength
  use qsmpm_initial_stress, only: limit_note
  use qsmpm_kinds, only: wp
  use qsmpm_messages, only: message_text
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_text, only: same_bits
  use testing, only: tests_type
  implicit none
  private

  public :: collect_point_states

  integer, parameter :: rock = 1, clay = 2, sand = 3, till = 4

contains

  !> All tests.
  subroutine collect_point_states(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model

    allocate (model)
    call tests%start('point_states')
    call build(0.5_wp, model)
    call check_names(tests, model)
    call check_strength(tests)
    call check_creep(tests)
  end subroutine collect_point_states

  !> Four layers of four laws under their weight.
  subroutine build(k0, model)
    !> Horizontal over vertical stress.
    real(wp), intent(in) :: k0
    type(model_type), intent(out) :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('layers.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 1, 1|Y, 0, 4, 4|'// &
      '*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=rock|*ELASTIC|1e5, 0.3|*UNIT WEIGHT|20|'// &
      '*MATERIAL, NAME=clay|*CAM CLAY, OCR=2|1, 0.2, 0.04, 2.2, 0.3|*UNIT WEIGHT|20|'// &
      '*MATERIAL, NAME=sand|*HARDENING SOIL|3e4, 3e4, 9e4, 0.5, 0.2, 100, 1, 35, 5|*UNIT WEIGHT|20|'// &
      '*MATERIAL, NAME=till|*ELASTIC|5e4, 0.3|*MOHR COULOMB|0, 30, 0|*SOFTENING, REGULARISATION=NONE|0, 25, 0, 0.5|'// &
      '*UNIT WEIGHT|20|*BODY, NAME=a, MATERIAL=rock, SHAPE=BOX|0, 1, 0, 1|*BODY, NAME=b, MATERIAL=clay, SHAPE=BOX|'// &
      '0, 1, 1, 2|*BODY, NAME=c, MATERIAL=sand, SHAPE=BOX|0, 1, 2, 3|*BODY, NAME=d, MATERIAL=till, SHAPE=BOX|'// &
      '0, 1, 3, 4|*METHOD, BASIS=GIMP|*POINTS, PER ELEMENT=4|*PHASE, NAME=weight|*INITIAL, TYPE=K0|4, 0.5'// &
      '|*FIX|base, ALL|*GRAVITY|0, -1|*CONTROLS, STEPS=1|*END PHASE|'), analysis, messages, error)
    ! Also ratios that a deck is not allowed.
    if (.not. allocated(error)) analysis%phases(1)%initial%k0 = k0
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the layers of the unit tests cannot be built'
    call start_phase(model)
  end subroutine build

  !> Every name once, the values where a law has it, in the place it has there; 0 elsewhere.
  subroutine check_names(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    real(wp), allocatable :: values(:, :)
    integer :: p, last
    logical :: right

    call tests%check('two laws that share a name give one field', state_name(model, 3) == '')
    call tests%check('in the order of the laws', state_name(model, 1) == 'preconsolidation_pressure' &
      .and. state_name(model, 2) == 'plastic_shear_strain')
    call state_values(model, 'preconsolidation_pressure', values)
    right = .true.
    do p = 1, model%state%points%count
      select case (model%state%points%material(p))
      case (clay)
        right = right .and. same_bits(values(1, p), model%state%points%state(1, p))
      case (sand)
        right = right .and. same_bits(values(1, p), model%state%points%state(2, p))
      case default
        right = right .and. .not. abs(values(1, p)) > 0.0_wp
      end select
    end do
    call tests%check('the pressure is that of clay and sand, no other has one', right .and. maxval(values) > 40.0_wp)
    last = model%laws(till)%law%state_count
    model%state%points%state(last, :) = 0.25_wp
    call state_values(model, 'plastic_shear_strain', values)
    call tests%check('the strain of the till is its last state', &
      all(pack(abs(values(1, :) - 0.25_wp), model%state%points%material == till) <= 0.0_wp))
    call tests%check('rock has none', all(pack(abs(values(1, :)), model%state%points%material == rock) <= 0.0_wp))
  end subroutine check_names

  !> Till carries horizontal stresses from a third of the vertical one to three times it, sand up to 3.69 times; clay and
  !> rock more. K0 is limited to that; stresses given otherwise are counted.
  subroutine check_strength(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    character(len=:), allocatable :: note
    integer :: layer

    allocate (model)
    call build(0.5_wp, model)
    layer = count(model%state%points%material == till)
    call tests%check('a layer has four points', layer == 4)
    call tests%check('an initial stress within the strength is none to warn of', all(count_beyond_strength(model) == 0))
    call build(0.34_wp, model)
    call tests%check('nor is one that is nearly the active one', all(count_beyond_strength(model) == 0))
    call build(0.3_wp, model)
    call tests%close('below the active one the till has the active ratio', ratio_of(till), 1.0_wp/3.0_wp, 1.0e-5_wp)
    call tests%close('and the rock K0', ratio_of(rock), 0.3_wp, 1.0e-12_wp)
    call tests%check('so that nothing exceeds the strength', all(count_beyond_strength(model) == 0))
    note = limit_note(model, model%analysis%phases(1)%initial)
    call tests%check('which is a warning: '//note, index(note, 'K0 is beyond the strength at 4 of 16 material points '// &
      "(material 'till')") > 0 .and. index(note, '0.3333 to 0.3333 times') > 0)
    call build(4.5_wp, model)
    call tests%close('above the passive one the till has the passive ratio', ratio_of(till), 3.0_wp, 3.0e-5_wp)
    call tests%check('and the sand that of c = 1, phi = 35', abs(ratio_of(sand) - 3.82_wp) < 0.01_wp)
    model%state%points%stress(1, :) = 0.3_wp*model%state%points%stress(2, :)
    model%state%points%stress(3, :) = model%state%points%stress(1, :)
    call tests%check('a stress that is not of K0 is counted where the law reduces it', count_at(till) == layer .and. &
      count_at(sand) == 0)

  contains

    !> Returns the mean ratio of horizontal to vertical stress of a material.
    real(wp) function ratio_of(material)
      integer, intent(in) :: material

      associate (points => model%state%points)
        ratio_of = sum(points%stress(1, :)/points%stress(2, :), points%material == material)/layer
      end associate
    end function ratio_of

    !> Returns the number of points of a material whose stress is beyond the strength.
    integer function count_at(material)
      integer, intent(in) :: material
      integer :: beyond(size(model%laws))

      beyond = count_beyond_strength(model)
      count_at = beyond(material)
    end function count_at
  end subroutine check_strength

  !> Soil that creeps: a phase without TIME is warned of, and what creeps in a while lies within the strength.
  subroutine check_creep(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: analysis
    class(model_type), allocatable :: model
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: said
    integer :: timed
    real(wp), parameter :: lasts(3) = [1.0e-6_wp, 1000.0_wp, 1.0_wp]
    character(len=11), parameter :: time(3) = [character(len=11) :: '', ', TIME=1000', '']

    do timed = 1, 3
      allocate (analysis, model)
      call parse_deck('creep.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 1, 1|Y, 0, 4, 4|'// &
        '*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=peat|*SOFT SOIL CREEP|0.1, 0.02, 0.004, 1, 25, 0|*UNIT WEIGHT|12|'// &
        '*BODY, NAME=a, MATERIAL=peat, SHAPE=ALL|*METHOD, BASIS=GIMP|*PHASE, NAME=weight'//trim(time(timed))// &
        trim(merge('|*INITIAL, TYPE=K0|4, 0.6', '                         ', timed < 3))// &
        '|*FIX|base, ALL|*GRAVITY|0, -1|*CONTROLS, STEPS=1|*END PHASE|'), analysis, messages, error)
      said = message_text(messages)
      call tests%check('a phase without TIME is told, but one that begins with stresses: '//said, &
        (index(said, "material 'peat' has *SOFT SOIL CREEP, but the phase has no TIME: one unit of time is "// &
        "assumed") > 0) .eqv. timed == 3)
      call tests%close('which takes no time', analysis%phases(1)%duration, lasts(timed), &
        1.0e-12_wp)
      if (timed == 3) exit
      if (.not. allocated(error)) call build_model(analysis, model, error)
      if (allocated(error)) error stop 'the peat of the unit tests cannot be built'
      call start_phase(model)
      call tests%check('what creeps is within its strength', all(count_beyond_strength(model) == 0))
      deallocate (analysis, model)
    end do
  end subroutine check_creep
end module test_point_states
