!> Histories on a state that is set by hand: forces of a supported surface and of a node set, the front of a body along and
!> against an axis, volumes, and the factor on the values.
module test_histories
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type, axisymmetric, plane_strain
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_histories, only: take_histories
  use qsmpm_history_description, only: history_type, quantity_body_rotation, quantity_discharge, quantity_volume
  use qsmpm_history_quantities, only: unit_of_history
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_histories

  real(wp), parameter :: rounding = 1.0e-12_wp

contains

  !> All tests.
  subroutine collect_histories(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model

    allocate (model)
    call tests%start('histories')
    call make_model(model)
    call check_forces(tests, model)
    call check_fronts(tests, model)
    call check_volumes(tests, model)
    call check_reach(tests, model)
    call check_smooth(tests)
    call check_followed(tests)
    call check_rounded(tests)
    call check_units(tests)
  end subroutine collect_histories

  !> A place on the face of a slope in rounded coordinates is moved onto it; one that is off by more is refused.
  subroutine check_rounded(tests)
    type(tests_type), intent(inout) :: tests
    type(model_type) :: model
    character(len=:), allocatable :: said

    call build_slope('13.333, 6.667', model, said)
    call tests%check('a place on the face with three digits is found; told: '//said, len(said) == 0)
    associate (x => model%state%tracers%position(:, 1))
      call tests%close('where the face is, y = x/2', x(2), x(1)/2.0_wp, 1.0e-12_wp)
      call tests%close('near the place', norm2(x - [13.333_wp, 6.667_wp]), 0.0_wp, 2.0e-3_wp)
    end associate
    call build_slope('13.333, 6.666', model, said)
    associate (x => model%state%tracers%position(:, 1))
      call tests%close('one inside stays where it is', norm2(x - [13.333_wp, 6.666_wp]), 0.0_wp, 0.0_wp)
    end associate
    call build_slope('13.3, 6.9', model, said)
    call tests%check('one in the air is refused', index(said, "'face' lies in no element that holds material") > 0)
  end subroutine check_rounded

  !> Units in the header of the curves: turns are in degrees, what flows is a volume of a slice, or of a radian, a time.
  subroutine check_units(tests)
    type(tests_type), intent(inout) :: tests
    type(analysis_type) :: analysis

    analysis%length_unit = 'm'
    analysis%force_unit = 'kN'
    analysis%model = plane_strain
    call tests%check('turns', unit_of_history(analysis, history_type(quantity=quantity_body_rotation)) == 'degree')
    call tests%check('discharge', unit_of_history(analysis, history_type(quantity=quantity_discharge)) == 'm2/time')
    call tests%check('volume', unit_of_history(analysis, history_type(quantity=quantity_volume)) == 'm2')
    analysis%model = axisymmetric
    call tests%check('discharge of a radian', unit_of_history(analysis, history_type(quantity=quantity_discharge)) == &
      'm3/rad/time')
  end subroutine check_units

  !> A slope of 1 in 2 on fitted triangles with a history at a place; what the builder tells.
  subroutine build_slope(place, model, said)
    character(len=*), intent(in) :: place
    type(model_type), intent(out) :: model
    character(len=:), allocatable, intent(out) :: said
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    said = ''
    call parse_deck('slope.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID| X, 0, 30, 30| Y, 0, 10, 10|'// &
      '*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*UNIT WEIGHT|18|*BODY, NAME=ground, '// &
      'MATERIAL=soil, SHAPE=POLYGON|0, 0|30, 0|30, 10|20, 10|10, 5|0, 5|*HISTORY, NAME=face, QUANTITY=POSITION, '// &
      'COMPONENT=Y|'//place//'|*PHASE, NAME=load|*FIX|base, ALL|*GRAVITY|0, -1|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) said = error%message
  end subroutine build_slope

  !> Two blocks side by side, each held by a surface; two cells wide, one point in the middle of each quarter of a cell.
  subroutine make_model(model)
    type(model_type), intent(out) :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('blocks.inp', joined('*MODEL, TYPE=PLANE STRAIN|*METHOD, BASIS=STANDARD|*GRID, ELEMENT=QUAD4|'// &
      'X, 0, 4, 4|Y, 0, 2, 2|*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*UNIT WEIGHT|18|'// &
      '*BODY, NAME=west, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 1|*BODY, NAME=east, MATERIAL=soil, SHAPE=BOX|2, 3, 0, 1|'// &
      '*SURFACE, NAME=one, TYPE=SEGMENT|1, 0, 1, 1|*SURFACE, NAME=two, TYPE=SEGMENT|3, 0, 3, 1|'// &
      '*HISTORY, NAME=a, QUANTITY=REACTION, COMPONENT=X, SURFACE=one|'// &
      '*HISTORY, NAME=b, QUANTITY=REACTION, COMPONENT=Y, SURFACE=two, SCALE=-2|'// &
      '*HISTORY, NAME=c, QUANTITY=REACTION, COMPONENT=Y, NSET=base|'// &
      '*HISTORY, NAME=d, QUANTITY=RUNOUT, COMPONENT=X|'// &
      '*HISTORY, NAME=e, QUANTITY=RUNOUT, COMPONENT=X, SMALLEST=YES|'// &
      '*HISTORY, NAME=f, QUANTITY=RUNOUT, COMPONENT=X, BODY=west|'// &
      '*HISTORY, NAME=g, QUANTITY=RUNOUT, COMPONENT=X, BODY=east, SMALLEST=YES|'// &
      '*HISTORY, NAME=h, QUANTITY=VOLUME, BODY=east|*HISTORY, NAME=i, QUANTITY=VOLUME|'// &
      '*PHASE, NAME=load|*FIX|base, ALL|*SUPPORT, SURFACE=one|*SUPPORT, SURFACE=two|*GRAVITY|0, -1|*END PHASE|'), &
      analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the deck of the suite of histories is broken'
  end subroutine make_model

  !> A front at the side of the mesh is warned of: that of all bodies where x is smallest, and of no other.
  subroutine check_reach(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(in) :: model

    call tests%check('the body that reaches the side', index(model%notes, "history 'e' (RUNOUT): the body reaches "// &
      'the side of the mesh at 0,') > 0)
    call tests%check('those that do not', index(model%notes, "history 'd' (RUNOUT)") == 0 .and. &
      index(model%notes, "history 'f' (RUNOUT)") == 0 .and. index(model%notes, "history 'g' (RUNOUT)") == 0)
  end subroutine check_reach

  !> A history on a face follows the body that stays, whatever the order of the cards; one in a body that goes is warned of.
  subroutine check_followed(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: pit = '*BODY, NAME=pit, MATERIAL=soil, SHAPE=BOX|0, 2, 1, 2|', &
      ground = '*BODY, NAME=ground, MATERIAL=soil, SHAPE=POLYGON|0, 0|4, 0|4, 2|2, 2|2, 1|0, 1|'
    class(model_type), allocatable :: model
    integer :: turn

    do turn = 1, 2
      allocate (model)
      if (turn == 1) call build_dug(pit//ground, model)
      if (turn == 2) call build_dug(ground//pit, model)
      associate (bodies => model%analysis%bodies, points => model%state%points)
        call tests%check('a tracer on the face', bodies(model%tracer_body(model%history_tracer(1)))%name == 'ground')
        call tests%check('a tracer inside', bodies(model%tracer_body(model%history_tracer(3)))%name == 'pit')
        call tests%check('a point at the face', bodies(points%body(model%history_point(2)))%name == 'ground')
      end associate
      call tests%check('bodies are told', index(model%notes, "history 'wall' follows body 'ground'") > 0 .and. &
        index(model%notes, "history 'push' follows body 'ground'") > 0)
      call tests%check('a body that goes is warned of', index(model%notes, "warning: dug.inp:10: *HISTORY: 'heave' "// &
        "follows body 'pit', which phase 'dig' deactivates") > 0 .and. index(model%notes, "'wall' follows body 'ground', "// &
        'which') == 0)
      deallocate (model)
    end do
    ! The face is in the middle of the box around the ground, which is on its left.
    allocate (model)
    call build_dug('*BODY, NAME=pit, MATERIAL=soil, SHAPE=BOX|2, 4, 1, 2|*BODY, NAME=ground, MATERIAL=soil, '// &
      'SHAPE=POLYGON|0, 0|4, 0|4, 1|2, 1|2, 2|0, 2|', model)
    call tests%check('a tracer on the face of ground on its left', &
      model%analysis%bodies(model%tracer_body(model%history_tracer(1)))%name == 'ground')
  end subroutine check_followed

  !> A model of ground that loses some of its bodies: histories on their face and in the pit.
  subroutine build_dug(bodies, model)
    character(len=*), intent(in) :: bodies
    type(model_type), intent(out) :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('dug.inp', joined('*MODEL, TYPE=PLANE STRAIN|*METHOD, BASIS=STANDARD|*GRID, ELEMENT=QUAD4|'// &
      'X, 0, 4, 4|Y, 0, 2, 2|*HISTORY, NAME=wall, QUANTITY=DISPLACEMENT, COMPONENT=X|2, 2|*HISTORY, NAME=push, '// &
      'QUANTITY=STRESS, COMPONENT=XX|2, 1.5|*HISTORY, NAME=heave, QUANTITY=DISPLACEMENT, COMPONENT=Y|1, 1.5|'// &
      '*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*UNIT WEIGHT|18|'//bodies// &
      '*PHASE, NAME=start|*FIX|base, ALL|*GRAVITY|0, -1|*END PHASE|*PHASE, NAME=dig|*DEACTIVATE|pit|*END PHASE|'), &
      analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the deck of a pit is broken'
  end subroutine build_dug

  !> Stress at a point of a cell of one pressure: the pressure is the linear one of which each cell has the mean, the rest
  !> of the tensor that of the point.
  subroutine check_smooth(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    real(wp) :: depth
    integer :: p

    allocate (model, analysis)
    call parse_deck('cells.inp', joined('*MODEL, TYPE=PLANE STRAIN|*METHOD, BASIS=STANDARD|*GRID, ELEMENT=QUAD4|'// &
      'X, 0, 1, 1|Y, 0, 8, 8|*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|'// &
      '*VOLUMETRIC LOCKING, TYPE=UNIFORM PRESSURE|*UNIT WEIGHT|18|*BODY, NAME=all, MATERIAL=soil, SHAPE=BOX|'// &
      '0, 1, 0, 8|*HISTORY, NAME=y, QUANTITY=STRESS, COMPONENT=YY|0.25, 4.75|*HISTORY, NAME=x, QUANTITY=STRESS, '// &
      'COMPONENT=XX|0.25, 4.75|*HISTORY, NAME=xy, QUANTITY=STRESS, COMPONENT=XY|0.25, 4.75|'// &
      '*PHASE, NAME=load|*FIX|base, ALL|*GRAVITY|0, -1|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the second deck of the suite of histories is broken'
    associate (points => model%state%points)
      do p = 1, points%count
        depth = 8.0_wp - (points%cell(p) - 0.5_wp)
        points%stress(:, p) = -depth*[0.6_wp, 1.0_wp, 0.7_wp, 0.0_wp] + [0.2_wp, -0.2_wp, 0.0_wp, 0.3_wp]
      end do
    end associate
    call tests%check('it is told', index(model%notes, "cells of material 'soil' have one pressure each") > 0)
    call tests%close('the mean of the plane is that of the depth of the point, along y', value_of(model, 1), &
      -3.5_wp - 0.2_wp + 0.8_wp*0.25_wp, 1.0e-9_wp)
    call tests%close('and along x', value_of(model, 2), -0.6_wp*3.5_wp + 0.2_wp + 0.8_wp*0.25_wp, 1.0e-9_wp)
    call tests%close('the shear is that of the point', value_of(model, 3), 0.3_wp, rounding)
  end subroutine check_smooth

  !> One history.
  real(wp) function value_of(model, number)
    type(model_type), intent(in) :: model
    integer, intent(in) :: number
    real(wp), allocatable :: values(:)

    call take_histories(model, values)
    value_of = values(number)
  end function value_of

  !> Sums over the points of a surface and over the nodes of a set.
  subroutine check_forces(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    integer :: s

    associate (surface => model%state%surface)
      call tests%check('both surfaces have points', count(surface%surface == 1) > 1 .and. count(surface%surface == 2) > 1)
      do s = 1, surface%count
        surface%reaction(:, s) = merge([3.0_wp, 5.0_wp], [7.0_wp, 11.0_wp], surface%surface(s) == 1)
      end do
      call tests%close('the force of a surface is the sum over its points', value_of(model, 1), &
        3.0_wp*count(surface%surface == 1), rounding)
      call tests%close('that of another its own, with the factor', value_of(model, 2), &
        -22.0_wp*count(surface%surface == 2), rounding)
    end associate
    model%state%reactions = 0.0_wp
    model%state%reactions(2, :) = 1.0_wp
    call tests%close('the force of a node set is the sum over its nodes', value_of(model, 3), 5.0_wp, rounding)
  end subroutine check_forces

  !> Fronts along and against the axis.
  subroutine check_fronts(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    integer :: first, last

    associate (points => model%state%points)
      points%initial_position = points%position
      first = minloc(points%position(1, :points%count), dim=1)
      last = maxloc(points%position(1, :points%count), dim=1)
      call tests%close('a front that rests', value_of(model, 4), 0.0_wp, rounding)
      points%position(1, last) = points%position(1, last) + 0.5_wp
      points%position(1, first) = points%position(1, first) - 0.25_wp
    end associate
    call tests%close('the front moves with the outermost point', value_of(model, 4), 0.5_wp, rounding)
    call tests%close('the other front against the axis', value_of(model, 5), 0.25_wp, rounding)
    call tests%close('that of a body is its own', value_of(model, 6), 0.0_wp, rounding)
    call tests%close('against the axis too', value_of(model, 7), 0.0_wp, rounding)
  end subroutine check_fronts

  !> Volumes now.
  subroutine check_volumes(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model

    call tests%close('the volume of a body', value_of(model, 8), 1.0_wp, rounding)
    where (model%state%points%body == 1) model%state%points%volume = 2.0_wp*model%state%points%volume
    call tests%close('of all bodies', value_of(model, 9), 3.0_wp, rounding)
    call tests%close('and still of the one', value_of(model, 8), 1.0_wp, rounding)
  end subroutine check_volumes
end module test_histories
