!> Tests of the external force: resultants and moments of weight, tractions, pressures and forces of an embedding
!> program by hand, at the start, in the midst and at the end of phases. Functions that hold linear fields give both
!> exactly: the sum of nodal forces is the resultant, the sum of x f the moments of first order.
module test_loads
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_initialisation, only: step_type, initialise_step
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_space, only: node_position
  use deck_samples, only: joined
  use term_samples, only: load_at
  use testing, only: tests_type
  implicit none
  private

  public :: collect_loads

  real(wp), parameter :: rounding = 1.0e-11_wp

contains

  !> All tests of the suite.
  subroutine collect_loads(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('loads')
    call check_weight(tests, 'STANDARD')
    call check_weight(tests, 'SPLINE2')
    call check_tractions(tests)
    call check_carried(tests)
    call check_phases(tests)
    call check_surfaces(tests)
    call check_ring(tests)
    call check_refusals(tests)
  end subroutine collect_loads

  !> A block of 1 by 0.8 in a grid of squares of 0.5, its weight 20 a volume.
  function deck(kind, basis, more) result(text)
    !> Kind of model, basis, and cards from the surfaces on.
    character(len=*), intent(in) :: kind, basis, more
    character(len=:), allocatable :: text

    text = '*MODEL, TYPE='//kind//'|*GRID, ELEMENT=QUAD4|X, 0, 2, 4|Y, 0, 1.5, 3|*NSET, NSET=base, PLANE=Y|0|'// &
      '*NSET, NSET=side, PLANE=X|0|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*UNIT WEIGHT|20|'// &
      '*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 0.8|*METHOD, BASIS='//basis//'|'//more
  end function deck

  !> The model of a deck, its phase begun.
  subroutine build(text, model, step, message)
    character(len=*), intent(in) :: text
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    !> Why there is none, empty when there is one.
    character(len=:), allocatable, intent(out) :: message
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    message = ''
    call parse_deck('block.inp', joined(text), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (.not. allocated(error)) then
      call start_phase(model)
      call initialise_step(model, step, error)
    end if
    if (allocated(error)) message = error%message
  end subroutine build

  !> Sum of the nodal forces, and of x times them: resultant, and first moments [i, j] = sum x_i f_j.
  subroutine measure(model, step, fraction, total, moments)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    real(wp), intent(in) :: fraction
    real(wp), intent(out) :: total(2), moments(2, 2)
    real(wp) :: force(2, model%space%node_count), x(2)
    integer :: a

    call load_at(model, step, fraction, force)
    total = sum(force, dim=2)
    moments = 0.0_wp
    do a = 1, size(force, 2)
      x = node_position(model%space, model%mesh, a)
      moments = moments + spread(x, 2, 2)*spread(force(:, a), 1, 2)
    end do
  end subroutine measure

  !> Weight, and the forces of an embedding program.
  subroutine check_weight(tests, basis)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: basis
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    character(len=:), allocatable :: message
    real(wp) :: total(2), moments(2, 2), centre(2)

    allocate (model, step)
    call build(deck('PLANE STRAIN', basis, '*PHASE, NAME=one, LOAD FACTOR=3|*FIX|base, ALL|*GRAVITY|0.5, -1|*END PHASE|'), &
      model, step, message)
    call tests%check(basis//': the deck of the weight is good', len(message) == 0)
    call measure(model, step, 0.25_wp, total, moments)
    ! Volume 0.8, weight 16, load factor 3, a quarter of the phase.
    call tests%close(basis//': the weight of a quarter of the phase', norm2(total - 12.0_wp*[0.5_wp, -1.0_wp]), 0.0_wp, &
      rounding*12.0_wp)
    centre = matmul(model%state%points%position, model%state%points%weight)/16.0_wp
    call tests%close(basis//': the weight acts where the points are', &
      maxval(abs(moments - spread(centre, 2, 2)*spread(total, 1, 2))), 0.0_wp, rounding*12.0_wp)
    call measure(model, step, 0.0_wp, total, moments)
    call tests%close(basis//': a phase begins without its weight', norm2(total), 0.0_wp, 0.0_wp)
    allocate (model%loading%point_force(2, model%state%points%count), source=0.0_wp)
    model%loading%point_force(:, 2) = [7.0_wp, -3.0_wp]
    call measure(model, step, 0.0_wp, total, moments)
    call tests%close(basis//': a force on a point is a load as it stands', norm2(total - [7.0_wp, -3.0_wp]), 0.0_wp, &
      rounding*7.0_wp)
    call tests%close(basis//': and acts at its point', &
      maxval(abs(moments - spread(model%state%points%position(:, 2), 2, 2)*spread(total, 1, 2))), 0.0_wp, rounding*7.0_wp)
  end subroutine check_weight

  !> A dead traction and a pressure on the same top, from 0.2 to 0.7 at y = 0.8.
  subroutine check_tractions(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: top = '*SURFACE, NAME=top, TYPE=SEGMENT|0.7, 0.8, 0.2, 0.8|'
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    character(len=:), allocatable :: message
    real(wp) :: total(2), moments(2, 2)

    allocate (model, step)
    call build(deck('PLANE STRAIN', 'STANDARD', top//'*PHASE, NAME=one, LOAD FACTOR=2|*FIX|base, ALL|'// &
      '*TRACTION, SURFACE=top|3, -4|*END PHASE|'), model, step, message)
    call measure(model, step, 0.5_wp, total, moments)
    call tests%close('a traction times its length', norm2(total - 0.5_wp*[3.0_wp, -4.0_wp]), 0.0_wp, rounding*10.0_wp)
    call tests%close('a traction acts in the midst of its surface', &
      maxval(abs(moments - spread([0.45_wp, 0.8_wp], 2, 2)*spread(total, 1, 2))), 0.0_wp, rounding*10.0_wp)
    ! Half of the areas turned away: a dead traction does not follow.
    model%state%surface%area_vector = 0.0_wp
    call measure(model, step, 0.5_wp, total, moments)
    call tests%close('a dead traction keeps its area', norm2(total - 0.5_wp*[3.0_wp, -4.0_wp]), 0.0_wp, rounding*10.0_wp)
    call build(deck('PLANE STRAIN', 'STANDARD', top//'*PHASE, NAME=one, LOAD FACTOR=2|*FIX|base, ALL|'// &
      '*PRESSURE, SURFACE=top|6|*END PHASE|'), model, step, message)
    call tests%check('the deck of the pressure is good', len(message) == 0)
    call tests%close('a surface has its areas', norm2(sum(model%state%surface%area_vector, dim=2) - [0.0_wp, 0.5_wp]), &
      0.0_wp, rounding)
  end subroutine check_tractions

  !> The paper's way: the outermost points carry the traction, all of it.
  subroutine check_carried(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    character(len=:), allocatable :: message
    real(wp) :: total(2), moments(2, 2), wanted(2, 2)
    integer :: i

    allocate (model, step)
    call build(deck('PLANE STRAIN', 'STANDARD', '*SURFACE, NAME=top, TYPE=SEGMENT|0.7, 0.8, 0.2, 0.8|'// &
      '*PHASE, NAME=one, LOAD FACTOR=2|*FIX|base, ALL|*TRACTION, SURFACE=top, CARRIER=POINTS|3, -4|*END PHASE|'), &
      model, step, message)
    call tests%check('the deck of carried tractions is good', len(message) == 0)
    call measure(model, step, 0.5_wp, total, moments)
    call tests%close('a carried traction times its length', norm2(total - 0.5_wp*[3.0_wp, -4.0_wp]), 0.0_wp, rounding*10.0_wp)
    wanted = 0.0_wp
    do i = 1, size(model%carrying_point)
      wanted = wanted + model%carrying_area(i)*spread(model%state%points%position(:, model%carrying_point(i)), 2, 2) &
        *spread([3.0_wp, -4.0_wp], 1, 2)
    end do
    call tests%close('a carried traction acts at its points', maxval(abs(moments - wanted)), 0.0_wp, rounding*10.0_wp)
    call tests%check('they are the uppermost points', all(model%state%points%position(2, model%carrying_point) > &
      maxval(model%state%points%position(2, :)) - 1.0e-9_wp))
  end subroutine check_carried

  !> A load given again goes on from its former value; others stay.
  subroutine check_phases(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    character(len=:), allocatable :: message
    real(wp) :: total(2), moments(2, 2)

    allocate (model, step)
    call build(deck('PLANE STRAIN', 'STANDARD', '*SURFACE, NAME=top, TYPE=SEGMENT|1, 0.8, 0, 0.8|'// &
      '*PHASE, NAME=one, LOAD FACTOR=2|*FIX|base, ALL|side, X|*GRAVITY|0, -1|*TRACTION, SURFACE=top|3, -4|*END PHASE|'// &
      '*PHASE, NAME=two, LOAD FACTOR=0.5|*FIX|side, FREE|*PRESCRIBE|base, X, 0.4|*TRACTION, SURFACE=top|0, -2|*END PHASE|'), &
      model, step, message)
    call tests%check('the deck of two phases is good', len(message) == 0)
    call tests%check('rollers hold their component in the first phase', &
      count(model%loading%constrained(1, :)) > count(model%loading%constrained(2, :)) .and. &
      all(abs(model%loading%prescribed) <= 0.0_wp))
    model%state%progress%phase = 2
    call start_phase(model)
    call measure(model, step, 0.0_wp, total, moments)
    call tests%close('a second phase begins with the loads of the first', norm2(total - [6.0_wp, -8.0_wp - 32.0_wp]), 0.0_wp, &
      rounding*40.0_wp)
    call measure(model, step, 0.5_wp, total, moments)
    call tests%close('half way a load is the mean of its values', norm2(total - [3.0_wp, -4.5_wp - 32.0_wp]), 0.0_wp, &
      rounding*40.0_wp)
    call measure(model, step, 1.0_wp, total, moments)
    call tests%close('at the end a load has its new value, the weight that of before', &
      norm2(total - [0.0_wp, -1.0_wp - 32.0_wp]), 0.0_wp, rounding*40.0_wp)
    call check_start_in_balance(tests)
    call tests%check('a freed set holds nothing, nor does the corner it shares, but for what is prescribed', &
      count(model%loading%constrained(1, :)) == count(model%loading%constrained(2, :)) + 1)
    call tests%close('a prescribed displacement has the load factor', maxval(model%loading%prescribed(1, :)), 0.2_wp, &
      rounding)
    call tests%close('the other component is held where it is', maxval(abs(model%loading%prescribed(2, :))), 0.0_wp, 0.0_wp)
  end subroutine check_phases

  !> A phase with initial stresses begins with all of its loads: the stresses are those under them.
  subroutine check_start_in_balance(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    character(len=:), allocatable :: message
    real(wp) :: total(2), moments(2, 2)

    allocate (model, step)
    call build(deck('PLANE STRAIN', 'STANDARD', '*SURFACE, NAME=top, TYPE=SEGMENT|1, 0.8, 0, 0.8|'// &
      '*PHASE, NAME=one, LOAD FACTOR=2|*INITIAL, TYPE=K0|0.8, 0.5|*FIX|base, ALL|side, X|*GRAVITY|0, -1|'// &
      '*TRACTION, SURFACE=top|0, -4|*END PHASE|'), model, step, message)
    call tests%check('the deck of initial stresses is good', len(message) == 0)
    if (len(message) > 0) return
    call measure(model, step, 0.0_wp, total, moments)
    call tests%close('a phase with initial stresses begins with all of its loads', total(2), -8.0_wp - 32.0_wp, 1.0e-9_wp)
  end subroutine check_start_in_balance

  !> Every way to choose a surface takes the length it should.
  subroutine check_surfaces(tests)
    type(tests_type), intent(inout) :: tests

    call check_one('TYPE=SEGMENT|1, 0.8, 0, 0.8', 1.0_wp, [0.0_wp, 1.0_wp])
    call check_one('TYPE=OUTLINE, BODY=block, BOX|-0.1, 1.1, 0.8, 0.8', 1.0_wp, [0.0_wp, 1.0_wp])
    call check_one('TYPE=OUTLINE, BODY=block', 3.6_wp, [0.0_wp, 0.0_wp])
    call check_one('TYPE=BOX|0, 1, 0, 0', 1.0_wp, [0.0_wp, -1.0_wp])

  contains

    !> One of them: length, and the sum of normals times areas.
    subroutine check_one(words, length, normals)
      character(len=*), intent(in) :: words
      real(wp), intent(in) :: length, normals(2)
      class(model_type), allocatable :: model
      class(step_type), allocatable :: step
      character(len=:), allocatable :: message

      allocate (model, step)
      call build(deck('PLANE STRAIN', 'STANDARD', '*SURFACE, NAME=s, '//words//'|*PHASE, NAME=one|*FIX|base, ALL|'// &
        '*GRAVITY|0, -1|*END PHASE|'), model, step, message)
      call tests%check(words//' is a surface', len(message) == 0)
      if (len(message) > 0) return
      call tests%close(words//' has its length', sum(model%state%surface%area), length, 1.0e-5_wp)
      call tests%close(words//' has its normals', norm2(sum(model%state%surface%area_vector, dim=2) - normals), 0.0_wp, &
        1.0e-5_wp)
      call tests%check(words//': normals are of length one', &
        all(abs(norm2(model%state%surface%normal, dim=1) - 1.0_wp) < 1.0e-12_wp))
    end subroutine check_one
  end subroutine check_surfaces

  !> Axisymmetry counts per radian: a ring from r = 0.2 to 0.7 under a vertical traction of 4.
  subroutine check_ring(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    character(len=:), allocatable :: message
    real(wp) :: total(2), moments(2, 2)

    allocate (model, step)
    call build(deck('AXISYMMETRIC', 'STANDARD', '*SURFACE, NAME=top, TYPE=SEGMENT|0.7, 0.8, 0.2, 0.8|'// &
      '*PHASE, NAME=one|*FIX|base, ALL|*TRACTION, SURFACE=top|0, -4|*END PHASE|'), model, step, message)
    call tests%check('the deck of the ring is good', len(message) == 0)
    call measure(model, step, 1.0_wp, total, moments)
    call tests%close('a ring carries its area per radian', total(2), -4.0_wp*0.5_wp*(0.49_wp - 0.04_wp), 1.0e-10_wp)
  end subroutine check_ring

  !> A surface that touches nothing, or that cannot slide, is refused with its name.
  subroutine check_refusals(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    character(len=:), allocatable :: message

    allocate (model, step)
    call build(deck('PLANE STRAIN', 'STANDARD', '*SURFACE, NAME=air, TYPE=SEGMENT|2, 1.4, 1.6, 1.4|*PHASE, NAME=one|'// &
      '*FIX|base, ALL|*END PHASE|'), model, step, message)
    call tests%check('a surface in the air is refused', index(message, "surface 'air' touches no element") > 0)
    call build(deck('PLANE STRAIN', 'STANDARD', '*SURFACE, NAME=bent, TYPE=SEGMENT|1, 0.8, 0, 0.8|1, 0, 1, 0.8|'// &
      '*PHASE, NAME=one|*SUPPORT, SURFACE=bent, TYPE=NORMAL|*END PHASE|'), model, step, message)
    call tests%check('a bent surface cannot slide', index(message, "surface 'bent' is not plane") > 0)
  end subroutine check_refusals
end module test_loads
