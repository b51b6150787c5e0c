!> Parameters by place: samples, the value between them, and which samples are around a place.
module test_value_field
  use qsmpm_kinds, only: wp
  use qsmpm_value_field, only: value_field_type, between_nearest, distance_beyond, field_as, field_cohesion, &
    field_friction, field_young, has_values, same_places, set_samples, value_at, value_between, values_of
  use deck_samples, only: joined
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type, message_text
  use qsmpm_error, only: error_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use scratch_folder, only: make_folder, remove_folder
  use testing, only: tests_type
  implicit none
  private

  public :: collect_value_field

  real(wp), parameter :: rounding = 1.0e-11_wp

contains

  subroutine collect_value_field(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('value_field')
    call check_linear(tests)
    call check_nearest(tests)
    call check_list(tests)
    call check_places(tests)
    call check_decks(tests)
  end subroutine collect_value_field

  !> Scattered places (dimension, n).
  pure function scattered(dimension, n) result(places)
    integer, intent(in) :: dimension, n
    real(wp) :: places(dimension, n)
    real(wp), parameter :: steps(3) = [0.7_wp, 1.3_wp, 1.9_wp], sides(3) = [3.1_wp, 4.7_wp, 5.3_wp]
    integer :: i

    do i = 1, n
      places(:, i) = modulo(steps(:dimension)*i, sides(:dimension))
    end do
  end function scattered

  !> Linear fields exactly, samples as they are, nothing beyond those around.
  subroutine check_linear(tests)
    type(tests_type), intent(inout) :: tests
    type(value_field_type) :: field
    real(wp) :: places(3, 40), values(40)

    places = scattered(3, 40)
    places(2, :) = -places(2, :)
    values = 3.0_wp + 0.2_wp*places(1, :) - 1.1_wp*places(2, :) + 0.4_wp*places(3, :)
    call set_samples(field, places, values)
    call tests%close('linear field in space', value_between(field, [1.4_wp, -2.3_wp, 2.0_wp]), &
      3.0_wp + 0.28_wp + 2.53_wp + 0.8_wp, 1.0e-8_wp)
    call tests%check('not beyond the samples', value_between(field, [0.0_wp, -40.0_wp, 0.0_wp]) <= maxval(values) .and. &
      value_between(field, [0.0_wp, 40.0_wp, 0.0_wp]) >= minval(values))
    values(7) = 50.0_wp
    field = value_field_type()
    call set_samples(field, places, values)
    call tests%close('a sample', value_between(field, places(:, 7)), 50.0_wp, rounding)
    field = value_field_type()
    values = 3.0_wp - 1.1_wp*places(2, :)
    places(1, :) = 0.0_wp
    call set_samples(field, places(:2, :), values)
    call tests%close('samples on one line', value_between(field, [0.4_wp, -2.3_wp]), 5.53_wp, 0.2_wp)
    call tests%check('which are kept along it', field%along == 2 .and. &
      all(field%places(2, 2:) >= field%places(2, :39)))
    field = value_field_type()
    call set_samples(field, places(:2, :1), [4.0_wp])
    call tests%close('one sample', value_between(field, [9.0_wp, 9.0_wp]), 4.0_wp, rounding)
  end subroutine check_linear

  !> The samples around a place are the nearest ones of all, whatever the axis they are kept along; a fit that is
  !> handed only them is the same.
  subroutine check_nearest(tests)
    type(tests_type), intent(inout) :: tests
    type(value_field_type) :: field, few
    real(wp) :: places(2, 200), values(200), x(2), distance(200), error(2)
    integer :: order(8), i, k, axis

    error = 0.0_wp
    do axis = 1, 2
      places = scattered(2, 200)
      places(axis, :) = 3.0_wp*places(axis, :)
      values = [(modulo(0.37_wp*i, 1.0_wp), i=1, 200)]
      field = value_field_type()
      call set_samples(field, places, values)
      call tests%check('along the longer axis', field%along == axis)
      do k = 1, 60
        x = [modulo(0.31_wp*k, 4.0_wp) - 0.4_wp, modulo(0.77_wp*k, 16.0_wp) - 1.0_wp]
        distance = (places(1, :) - x(1))**2 + (places(2, :) - x(2))**2
        do i = 1, 8
          order(i) = minloc(distance, dim=1)
          distance(order(i)) = huge(1.0_wp)
        end do
        few = value_field_type()
        call set_samples(few, places(:, order), values(order))
        field%between = 1
        error(1) = max(error(1), abs(value_between(field, x) - value_between(few, x)))
        field%between = between_nearest
        error(2) = max(error(2), abs(value_between(field, x) - values(order(1))))
      end do
    end do
    call tests%close('a fit to the eight nearest samples', error(1), 0.0_wp, 1.0e-9_wp)
    call tests%close('the nearest sample', error(2), 0.0_wp, 0.0_wp)
  end subroutine check_nearest

  !> Fields by the parameter they are of.
  subroutine check_list(tests)
    type(tests_type), intent(inout) :: tests
    type(value_field_type), allocatable :: fields(:), none(:)
    type(value_field_type) :: other

    call tests%check('no field', .not. has_values(none, field_cohesion) .and. size(values_of(none, field_young)) == 0)
    call tests%close('the same everywhere', value_at(none, field_young, [0.0_wp, 0.0_wp], 7.0_wp), 7.0_wp, 0.0_wp)
    allocate (fields(2))
    fields%parameter = [field_cohesion, field_friction]
    call set_samples(fields(1), reshape([0.0_wp, 0.0_wp], [2, 1]), [3.0_wp])
    call set_samples(fields(2), reshape([0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp], [2, 2]), [20.0_wp, 30.0_wp])
    call tests%check('which there are', has_values(fields, field_friction) .and. .not. has_values(fields, field_young))
    call tests%close('one of them', value_at(fields, field_friction, [1.0_wp, 0.0_wp, 5.0_wp], 7.0_wp), 30.0_wp, 0.0_wp)
    call tests%close('none of them', value_at(fields, field_young, [1.0_wp, 0.0_wp], 7.0_wp), 7.0_wp, 0.0_wp)
    call tests%close('its samples', sum(values_of(fields, field_friction)), 50.0_wp, 0.0_wp)
    other = field_as(fields, field_friction, 12)
    call tests%check('under another number', other%parameter == 12 .and. size(other%values) == 2)
  end subroutine check_list

  !> Places that two samples have, and places beyond all samples.
  subroutine check_places(tests)
    type(tests_type), intent(inout) :: tests
    type(value_field_type) :: field
    real(wp) :: places(2, 6)

    places = reshape([0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 2.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 2.0_wp, 1.0_wp], &
      [2, 6])
    call set_samples(field, places, [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp, 6.0_wp])
    call tests%check('each at its own place', all(same_places(field) == 0))
    call tests%close('inside', distance_beyond(field, [1.5_wp, 0.5_wp, 9.0_wp]), 0.0_wp, 0.0_wp)
    call tests%close('beyond a corner, in distances of samples', distance_beyond(field, [5.0_wp, -4.0_wp, 0.0_wp]), &
      5.0_wp/(sqrt(5.0_wp)/sqrt(6.0_wp)), rounding)
    field = value_field_type()
    places(:, 6) = places(:, 1)
    call set_samples(field, places, [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp, 6.0_wp])
    call tests%check('two at one place', all(abs(field%values(same_places(field)) - [1.0_wp, 6.0_wp]) <= 0.0_wp))
    field = value_field_type()
    call set_samples(field, places(:, :1), [1.0_wp])
    call tests%close('one sample is everywhere', distance_beyond(field, [50.0_wp, 0.0_wp, 0.0_wp]), 0.0_wp, 0.0_wp)
    field = value_field_type()
    places(1, :) = 0.0_wp
    places(2, :) = [0.0_wp, 1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 6.0_wp]
    call set_samples(field, places, [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp, 6.0_wp])
    call tests%close('beside samples on a line', distance_beyond(field, [2.0_wp, 3.0_wp, 0.0_wp]), 2.0_wp, rounding)
  end subroutine check_places
  !> Files and cards of decks: what is read, and what is refused by its line.
  subroutine check_decks(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: nl = new_line('a'), soil = '*MATERIAL, NAME=soil|*ELASTIC|5000, 0.3|'// &
      '*MOHR COULOMB|12, 20, 0|*UNIT WEIGHT|18|', clay = '*MATERIAL, NAME=clay|*CAM CLAY|1, 0.2, 0.04, 2.2, 0.3|', &
      card = '*FIELD OF VALUES|'
    character(len=:), allocatable :: folder

    call make_folder(folder)
    call write_file('good.csv', 'id,Y, x,C,phi,gamma,k'//achar(13)//nl//nl//'1,0,0,5,20,18,2'//nl//nl//'2,4,0,7,30,20,3'//nl)
    call write_file('holes.csv', 'x,y,c'//nl//'0,0,5'//nl//nl//'1,0'//nl)
    call write_file('range.csv', 'x,y,c,phi'//nl//'0,0,5,20'//nl//nl//'1,0,-1,95'//nl)
    call write_file('bare.csv', 'x,y,c'//nl)
    call write_file('no_x.csv', 'y,c'//nl//'0,5'//nl)
    call expect('samples of one file for two parameters, in any order of columns', soil//card//'C, good.csv|'// &
      'PHI, good.csv, NEAREST|', '')
    call tests%check('the second of two materials too', index(text_of(soil//clay//card//'GAMMA, good.csv|'), &
      "a positive one on *UNIT WEIGHT too") > 0)
    call expect('a line that ends too soon', soil//card//'C, holes.csv|', 'holes.csv:4: column c has no number')
    call expect('a number out of its range', soil//card//'C, range.csv|', 'range.csv:4: c = -1 is outside [0, inf)')
    call expect('of the parameter that is asked for', soil//card//'PHI, range.csv|', 'range.csv:4: phi = 95 is outside')
    call expect('names alone', soil//card//'C, bare.csv|', 'bare.csv: no row of numbers follows')
    call expect('no coordinate', soil//card//'C, no_x.csv|', 'no_x.csv:1: the first line names the columns: x, y, c')
    call expect('friction by place of soil without', '*MATERIAL, NAME=soil|*ELASTIC|5000, 0.3|*MOHR COULOMB|12, 0, 0|'// &
      card//'PHI, good.csv|', "material 'soil': phi by place requires a positive one on *MOHR COULOMB too")
    call expect('no file', soil//card//'C, none.csv|', 'cannot read the file')
    call expect('twice', soil//card//'C, good.csv|C, good.csv|', 'c stands there twice')
    call expect('a law of its own', clay//card//'C, good.csv|', "material 'clay': c of *MOHR COULOMB by place is for "// &
      '*ELASTIC')
    call expect('the second row', soil//card//'C, good.csv|K, good.csv|', 'k by place requires a positive one on *PERMEABILITY')
    call expect('what any law has by place', clay//'*UNIT WEIGHT|18|'//card//'GAMMA, good.csv|', '')
    call check_values(soil//card//'C, good.csv|PHI, good.csv, NEAREST|')
    call check_ranges()
    call remove_folder(folder)

  contains

    !> Write a file of the folder.
    subroutine write_file(name, text)
      character(len=*), intent(in) :: name, text
      integer :: unit

      open (newunit=unit, file=folder//'/'//name, access='stream', form='unformatted', status='replace', action='write')
      write (unit) text
      close (unit)
    end subroutine write_file

    !> What is said of a deck, nothing where it is right.
    subroutine expect(what, materials, message)
      character(len=*), intent(in) :: what, materials, message
      character(len=:), allocatable :: text

      text = text_of(materials)
      call tests%check(what//'; found: '//text, index(text, message) > 0 .and. &
        (len(message) > 0 .or. index(text, 'FIELD OF VALUES') == 0))
    end subroutine expect

    !> Messages of a deck of some materials, of which the last is that of the ground.
    function text_of(materials) result(text)
      character(len=*), intent(in) :: materials
      character(len=:), allocatable :: text
      class(analysis_type), allocatable :: analysis
      type(message_list_type) :: messages
      type(error_type), allocatable :: error

      call read_deck(materials, analysis, messages, error)
      text = message_text(messages)
    end function text_of

    !> Two bodies of the first and of the last material.
    subroutine read_deck(materials, analysis, messages, error)
      character(len=*), intent(in) :: materials
      class(analysis_type), allocatable, intent(out) :: analysis
      type(message_list_type), intent(out) :: messages
      type(error_type), allocatable, intent(out) :: error
      integer :: from

      from = index(materials, 'NAME=', back=.true.) + len('NAME=')
      allocate (analysis)
      call parse_deck(folder//'/deck.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 4, 4|Y, 0, 4, 4|'// &
        '*NSET, NSET=base, PLANE=Y|0|'//materials//'*BODY, NAME=low, SHAPE=BOX, MATERIAL='//materials(17:20)// &
        '|0, 4, 0, 2|*BODY, NAME=high, SHAPE=BOX, MATERIAL='//materials(from:from + 3)//'|0, 4, 2, 4|'// &
        '*PHASE, NAME=weight|*FIX|base, ALL|*GRAVITY|0, -1|*END PHASE|'), analysis, messages, error)
    end subroutine read_deck

    !> Samples of good.csv, at (0, 0) and (0, 4), as the parsed material has them.
    subroutine check_values(materials)
      character(len=*), intent(in) :: materials
      class(analysis_type), allocatable :: analysis
      type(message_list_type) :: messages
      type(error_type), allocatable :: error

      call read_deck(materials, analysis, messages, error)
      call tests%check('values of a file; found: '//message_text(messages), .not. allocated(error))
      if (allocated(error)) return
      associate (profile => analysis%materials(1)%strength_profile)
        call tests%close('the first sample', of(profile%fields, field_cohesion, 0.0_wp), 5.0_wp, rounding)
        call tests%close('the last sample', of(profile%fields, field_cohesion, 4.0_wp), 7.0_wp, rounding)
        call tests%close('between them', of(profile%fields, field_cohesion, 1.0_wp), 5.5_wp, 1.0e-6_wp)
        call tests%close('the nearer one', of(profile%fields, field_friction, 1.0_wp), 20.0_wp, rounding)
        call tests%close('the other one', of(profile%fields, field_friction, 3.0_wp), 30.0_wp, rounding)
      end associate
    end subroutine check_values

    !> A parameter at (0, y), -1 where none is read.
    pure real(wp) function of(fields, parameter, y)
      type(value_field_type), intent(in), allocatable :: fields(:)
      integer, intent(in) :: parameter
      real(wp), intent(in) :: y

      of = value_at(fields, parameter, [0.0_wp, y], -1.0_wp)
    end function of

    !> What the log says of strengths: of each material over its own points.
    subroutine check_ranges()
      class(analysis_type), allocatable :: analysis
      class(model_type), allocatable :: model
      type(message_list_type) :: messages
      type(error_type), allocatable :: error
      character(len=*), parameter :: deep = '*STRENGTH PROFILE|4, 10, 3|', sand = '*MATERIAL, NAME=sand|*ELASTIC|'// &
        '5000, 0.3|*MOHR COULOMB|1, 0, 0|'

      call read_deck('*MATERIAL, NAME=firm|*ELASTIC|5000, 0.3|*MOHR COULOMB|1, 0, 0|'//deep//sand//deep, analysis, &
        messages, error)
      allocate (model)
      if (.not. allocated(error)) call build_model(analysis, model, error)
      call tests%check('profiles of two materials; found: '//message_text(messages), .not. allocated(error))
      if (allocated(error)) return
      ! 10 + 3 (4 - y) at the points of the lower and of the upper half.
      call tests%check("the lower one's; found: "//model%notes, index(model%notes, &
        "material 'firm': strength from 16.") > 0 .or. index(model%notes, "material 'firm': strength from 17") > 0)
      call tests%check("the upper one's", index(model%notes, "material 'sand': strength from 10.") > 0)
    end subroutine check_ranges
  end subroutine check_decks
end module test_value_field
