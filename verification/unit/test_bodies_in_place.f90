!> Rigid bodies that are in place from the start: what is left of the soil, exactly, and of its surfaces.
module test_bodies_in_place
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_rigid_shape, only: distance_type
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_text, only: real_text
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_bodies_in_place

  !> A block of 4 by 3; a surface through its middle, and one around it.
  character(len=*), parameter :: head = '*GRID, ELEMENT=QUAD4|X, 0, 4, 16|Y, 0, 4, 16|*NSET, NSET=base, PLANE=Y|0|'// &
    '*SURFACE, NAME=level, TYPE=SEGMENT|4, 1.6, 0, 1.6|'// &
    '*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*UNIT WEIGHT|20|'
  character(len=*), parameter :: box = '*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|0, 4, 0, 3|'// &
    '*SURFACE, NAME=around, TYPE=OUTLINE, BODY=ground|'
  character(len=*), parameter :: tail = '*PHASE, NAME=press|*FIX|base, ALL|*MOVE, BODY=tool|0, -0.1|*END PHASE|'
  character(len=*), parameter :: contact = '*CONTACT, BODY=tool, SURFACE=around|'
  real(wp), parameter :: rounding = 1.0e-12_wp, pi = acos(-1.0_wp)

contains

  !> All tests of the suite.
  subroutine collect_bodies_in_place(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    ! Areas of circles of radius one by 84 and by 64 chords.
    real(wp), parameter :: chorded = 42.0_wp*sin(pi/42.0_wp), corners = 32.0_wp*sin(pi/32.0_wp)

    allocate (model)
    call tests%start('bodies_in_place')
    call build(tests, 'PLANE STRAIN', box, 'SHAPE=CIRCLE, IN PLACE=YES|2, 1.6, 0.7', model)
    call check_rest(tests, 'a circle in the middle', model, 12.0_wp - chorded*0.49_wp)
    call check_surfaces(tests, model, 14.0_wp + 84.0_wp*1.4_wp*sin(pi/84.0_wp), 4.0_wp - 1.4_wp)
    call tests%check('what is taken out is told: '//model%notes, index(model%notes, &
      "body 'ground': soil of volume 1.538 and weight 30.76 ") > 0)
    call build(tests, 'PLANE STRAIN', box, 'SHAPE=BOX, IN PLACE=YES, ROUND=0.1|1, 2, 2.5, 3.5', model)
    call check_rest(tests, 'a box at the top', model, 12.0_wp - 0.5_wp + 2.0_wp*(0.01_wp - corners*0.01_wp/4.0_wp))
    call build(tests, 'PLANE STRAIN', box, 'SHAPE=BOX, IN PLACE=YES, ROUND=0.1|0, 2, 1, 2', model)
    call check_rest(tests, 'a box at the side', model, 12.0_wp - 2.0_wp + 4.0_wp*(0.01_wp - corners*0.01_wp/4.0_wp))
    call build(tests, 'PLANE STRAIN', box, 'SHAPE=BOX, IN PLACE=YES|1, 2, 1, 2', model)
    call tests%close('corners of its own radius keep it', model%analysis%rigid_bodies(1)%round, 0.0625_wp, 1.0e-15_wp)
    call build(tests, 'PLANE STRAIN', box, 'SHAPE=PLANE, IN PLACE=YES|4, 0, -1, -1', model)
    call check_rest(tests, 'a slope', model, 12.0_wp - 4.5_wp)
    call build(tests, 'PLANE STRAIN', box, 'SHAPE=PLANE, IN PLACE=YES|0, 0, 1, -1', model)
    call check_rest(tests, 'a slope from a corner of the mesh', model, 12.0_wp - 4.5_wp)
    call build(tests, 'PLANE STRAIN', '*BODY, NAME=ground, MATERIAL=soil, SHAPE=ALL|'// &
      '*SURFACE, NAME=around, TYPE=SEGMENT|4, 3, 0, 3|', &
      'SHAPE=CIRCLE, IN PLACE=YES|2, 1.6, 0.7', model)
    call check_rest(tests, 'a circle in all of the grid', model, 16.0_wp - chorded*0.49_wp)
    call tests%check('nothing is said of a surface beside it', index(model%notes, "surface 'around'") == 0)
    call build(tests, 'AXISYMMETRIC', box, 'SHAPE=CYLINDER, IN PLACE=YES, ROUND=0.001|0, 2, 1, 2', model)
    call check_rest(tests, 'a cylinder on the axis, per radian', model, 24.0_wp - 0.5_wp, 1.0e-5_wp)
    ! A twelfth of a cell below the top of the body, and a two-hundredth.
    call build(tests, 'PLANE STRAIN', box, 'SHAPE=BOX, IN PLACE=YES, ROUND=0.001|1, 2, 1, 1.62', model)
    call tests%close('a surface just inside ends at the body', sum(model%state%surface%area, &
      mask=model%state%surface%surface == 1), 3.0_wp, 0.1_wp)
    call build(tests, 'PLANE STRAIN', box, 'SHAPE=BOX, IN PLACE=YES, ROUND=0.001|1, 2, 1, 1.60125', model)
    call tests%close('one on it does not', sum(model%state%surface%area, mask=model%state%surface%surface == 1), 4.0_wp, &
      1.0e-12_wp)
    call build(tests, 'PLANE STRAIN', box, 'SHAPE=BOX, IN PLACE=YES, ROUND=1E-5|1, 2, 1, 2', model)
    call check_rest(tests, 'a box with sharp corners', model, 11.0_wp, 1.0e-9_wp)
    call check_others(tests)
    call check_refusals(tests)
    call check_advice(tests)
  end subroutine collect_bodies_in_place

  !> A model with a rigid body.
  subroutine build(tests, kind, soil, rigid, model)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind, soil, rigid
    type(model_type), intent(out) :: model
    character(len=:), allocatable :: text

    call try(kind, soil, rigid, model, text)
    call tests%check('a model is built: '//text, len(text) == 0)
    if (len(text) > 0) error stop 'a sample cannot be built'
  end subroutine build

  !> A model, or why there is none.
  subroutine try(kind, soil, rigid, model, text)
    character(len=*), intent(in) :: kind, soil, rigid
    type(model_type), intent(out) :: model
    character(len=:), allocatable, intent(out) :: text
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    text = ''
    call parse_deck('test.inp', joined('*MODEL, TYPE='//kind//'|'//head//soil//'*METHOD, BASIS=GIMP, '// &
      'INTEGRATION=CELL|*RIGID BODY, NAME=tool, '//rigid//'|'//contact//tail), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) text = error%message
  end subroutine try

  !> The material points hold the volume and weight that is left, and none is inside of the body.
  subroutine check_rest(tests, what, model, volume, tolerance, weight)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: what
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: volume
    !> Unit weight, 20 unless given.
    real(wp), intent(in), optional :: tolerance, weight
    type(distance_type) :: distance
    real(wp) :: allowed, deepest, unit_weight
    integer :: p

    allowed = rounding
    unit_weight = 20.0_wp
    if (present(weight)) unit_weight = weight
    if (present(tolerance)) allowed = tolerance
    call tests%close('volume without '//what, sum(model%state%points%volume), volume, allowed)
    call tests%close('weight without '//what, sum(model%state%points%weight), unit_weight*volume, 20.0_wp*allowed)
    deepest = 0.0_wp
    do p = 1, model%state%points%count
      distance = model%rigid_shapes(1)%distance_at([model%state%points%position(:, p), 0.0_wp])
      deepest = max(deepest, -distance%value)
    end do
    call tests%check('no soil is inside of '//what, deepest < 2.0e-3_wp*model%cell_size)
  end subroutine check_rest

  !> The outline runs along the body, without the slit that leads to it; a level surface ends at it.
  subroutine check_surfaces(tests, model, around, level)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: around, level

    associate (surface => model%state%surface)
      call tests%close('length of the outline', sum(surface%area, mask=surface%surface == 2), around, 1.0e-10_wp)
      call tests%close('sum of its area vectors', norm2(sum(surface%area_vector, dim=2, &
        mask=spread(surface%surface == 2, 1, 2))), 0.0_wp, 1.0e-10_wp)
      call tests%close('a surface through the body', sum(surface%area, mask=surface%surface == 1), level, 0.05_wp)
      call tests%check('carrying points are those of the surfaces left', size(model%carrying_point) == surface%count)
    end associate
    call tests%check('what of it is left out is told', index(model%notes, "surface 'level': 0.") > 0)
  end subroutine check_surfaces

  !> A plate of nodes that goes more than two cells is told of rigid bodies, once.
  subroutine check_advice(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: told = "the plate 'plate' of *MOVING MESH goes"

    call tests%check('a plate that goes 2.4 cells', index(notes_of('0.3', '2'), told) > 0)
    call tests%check('one that goes 1.9 cells', index(notes_of('0.475', '1'), told) == 0)

  contains

    !> Notes of a block pressed by a plate.
    function notes_of(move, factor) result(notes)
      character(len=*), intent(in) :: move, factor
      character(len=:), allocatable :: notes
      class(analysis_type), allocatable :: analysis
      class(model_type), allocatable :: model
      type(message_list_type) :: messages
      type(error_type), allocatable :: error

      allocate (analysis, model)
      call parse_deck('test.inp', joined('*MODEL, TYPE=PLANE STRAIN|'//head//box//'*METHOD, BASIS=GIMP, '// &
        'INTEGRATION=CELL|*NSET, NSET=plate, BOX|1, 2, 3, 3|*MOVING MESH, NSET=plate, AXIS=Y|*PHASE, NAME=press, '// &
        'LOAD FACTOR='//factor//'|*FIX|base, ALL|*PRESCRIBE|plate, Y, -'//move//'|*END PHASE|'), analysis, messages, error)
      if (.not. allocated(error)) call build_model(analysis, model, error)
      notes = ''
      if (.not. allocated(error)) notes = model%notes
    end function notes_of
  end subroutine check_advice

  !> A body that is not in place leaves surfaces alone; one that is small beside the cells keeps straight edges.
  subroutine check_others(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (model)
    call build(tests, 'PLANE STRAIN', box, 'SHAPE=CIRCLE, IN PLACE=YES|1, 2.5, 0.2|*SURFACE, NAME=lid, TYPE=SEGMENT|'// &
      '4, 2.999, 0, 2.999|*RIGID BODY, NAME=other, SHAPE=BOX, ROUND=0.01|1, 2, 2.97, 3.5|*CONTACT, BODY=other, SURFACE=lid', model)
    call tests%close('a surface inside of a body that is not in place stays', sum(model%state%surface%area, &
      mask=model%state%surface%surface == 3), 4.0_wp, 1.0e-12_wp)
    allocate (analysis)
    call parse_deck('test.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 1, 3, 8|Y, 2, 4, 8|*NSET, '// &
      'NSET=base, PLANE=Y|2|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, SHAPE=ALL|'// &
      '*RIGID BODY, NAME=tool, SHAPE=BOX, IN PLACE=YES, ROUND=1E-5|1.5, 2.5, 2.5, 3.5|*CONTACT, BODY=tool, ON=BODY|'// &
      '*METHOD, BASIS=GIMP, INTEGRATION=CELL|'//tail), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    call tests%check('a body in all of a grid that begins elsewhere', .not. allocated(error))
    if (.not. allocated(error)) call check_rest(tests, 'a box there', model, 3.0_wp, 1.0e-9_wp, 0.0_wp)
    call build(tests, 'PLANE STRAIN', box, 'SHAPE=BOX|1, 1.1, 3.1, 3.2', model)
    call tests%close('a small body has its own roundness', model%rigid_shapes(1)%shape%radius, 0.025_wp, 1.0e-12_wp)
  end subroutine check_others

  !> What cannot be.
  subroutine check_refusals(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    character(len=:), allocatable :: text

    allocate (model)
    call try('PLANE STRAIN', box, 'SHAPE=CIRCLE|2, 1.6, 0.7', model, text)
    call tests%check('the word is suggested: '//text, index(text, 'or remove it by IN PLACE=YES') > 0)
    call try('PLANE STRAIN', box, 'SHAPE=CIRCLE, IN PLACE=YES|1, 1.6, 0.3|*RIGID BODY, NAME=other, SHAPE=CIRCLE|'// &
      '3, 1.6, 0.3|*CONTACT, BODY=other, SURFACE=level', model, text)
    call tests%check('beside one that is in place, too: '//text, index(text, 'or remove it by IN PLACE=YES') > 0)
    call try('PLANE STRAIN', box, 'SHAPE=BOX, IN PLACE=YES|-1, 5, -1, 4', model, text)
    call tests%check('nothing left: '//text, index(text, "nothing remains of 'ground' where rigid") > 0)
    call try('PLANE STRAIN', box, 'SHAPE=BOX, IN PLACE=YES|-1, 5, 1.5, 1.7', model, text)
    call tests%check('a surface inside: '//text, index(text, "all of 'level' is inside rigid bodies") > 0)
    call try('PLANE STRAIN', box, 'SHAPE=BOX, ROUND=0.496|1, 2, 3.1, 4.1', model, text)
    call tests%check('corners that are too round: '//text, index(text, "the corners of 'tool' cannot be as round as "// &
      'ROUND=0.496') > 0 .and. index(text, 'its edges allow 0.495') > 0)
    call try('PLANE STRAIN', box, 'SHAPE=BOX, ROUND=0.494|1, 2, 3.1, 4.1', model, text)
    call tests%check('and a little less: '//text, len(text) == 0)
    call try('PLANE STRAIN', box, 'SHAPE=BOX, IN PLACE=YES, ROUND=0.6|1, 2, 1, 2|*RIGID BODY, NAME=other, SHAPE=BOX, '// &
      'IN PLACE=YES, ROUND=0.7|2, 3, 1, 2|*CONTACT, BODY=other, SURFACE=level', model, text)
    call tests%check('in place the first of them is told, once: '//text, index(text, 'cannot be as round as ROUND=0.6') > 0 &
      .and. index(text, 'cannot be as round', back=.true.) == index(text, 'cannot be as round'))
    call try('PLANE STRAIN', '*ELSET, ELSET=part, BOX|0, 4, 0, 2|*BODY, NAME=ground, MATERIAL=soil, SHAPE=REGION, '// &
      'REGION=part|*SURFACE, NAME=around, TYPE=SEGMENT|4, 2, 0, 2|', 'SHAPE=CIRCLE, IN PLACE=YES|2, 1, 0.3', model, text)
    call tests%check('an element set: '//text, index(text, "and of ALL of a *GRID: 'ground' is none of them") > 0)
    call check_single_points(tests)
  end subroutine check_refusals

  !> Soil of one point inside of a body is refused, be it the first or the last one, and its volume is told.
  subroutine check_single_points(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model, other
    character(len=:), allocatable :: text
    integer :: i, p

    allocate (model, other)
    call build(tests, 'PLANE STRAIN', box, 'SHAPE=CIRCLE|1, 3.5, 0.4', model)
    do i = 1, 2
      p = merge(1, model%state%points%count, i == 1)
      call try('PLANE STRAIN', box, 'SHAPE=CIRCLE|'//real_text(model%state%points%position(1, p))//', '// &
        real_text(model%state%points%position(2, p))//', 0.01', other, text)
      call tests%check('one point is inside: '//text, index(text, 'soil of volume '// &
        rounded_text(model%state%points%volume(p))//" is inside 'tool': define the soil") > 0)
    end do
    call try('PLANE STRAIN', box, 'SHAPE=CIRCLE|'//real_text(model%state%points%position(1, 1))//', '// &
      real_text(model%state%points%position(2, 1))//', 0.002', other, text)
    call tests%check('a hundredth of a cell is allowed: '//text, len(text) == 0)
  end subroutine check_single_points
end module test_bodies_in_place
