!> The weight above a place against integrals by hand, and the K0 stresses that follow from it: in the plane, in
!> axisymmetry, in space, for bodies drawn, of triangles and of cells, and for reduced models.
module test_overburden
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_initial_balance, only: balance_type, measure_balance
  use qsmpm_initialisation, only: step_type, initialise_step
  use qsmpm_mesh, only: mesh_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_overburden, only: overburden_type, make_overburden, weight_above, ground_top, find_beside
  use qsmpm_phase_start, only: start_phase
  use qsmpm_polyhedron, only: make_polyhedron
  use qsmpm_reduction, only: expansion_type, reduction_check_type
  use deck_samples, only: joined
  use sample_models, only: sample_grid
  use scene_samples, only: changed, reduced
  use solid_samples, only: wedge_facets, block_facets
  use testing, only: tests_type
  implicit none
  private

  public :: collect_overburden

  !> A few products and sums of numbers of size 100.
  real(wp), parameter :: rounding = 1.0e-12_wp
  !> Unit weights of the lower and the upper layer of the decks, and K0 of the lower one.
  real(wp), parameter :: heavy = 20.0_wp, light = 10.0_wp, k0_low = 0.7_wp, k0 = 0.5_wp

contains

  !> All checks.
  subroutine collect_overburden(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('overburden')
    call check_solids(tests)
    call check_gaps(tests)
    call check_beside(tests)
    call check_layers(tests, 'an inclined interface', plane_layers(), 1.0_wp)
    call check_layers(tests, 'triangles', changed(plane_layers(), 'QUAD4', 'TRI6'), 1.0_wp)
    call check_layers(tests, 'splines', changed(plane_layers(), '*PHASE', &
      '*METHOD, BASIS=SPLINE2G, INTEGRATION=CELL|*PHASE'), 1.0_wp)
    call check_layers(tests, 'axisymmetry', changed(plane_layers(), 'PLANE STRAIN', 'AXISYMMETRIC'), 1.0_wp)
    call check_layers(tests, 'a slice in space', solid_layers(), 1.0_wp)
    call check_layers(tests, 'bodies of cells', cell_layers(), 0.0_wp)
    call check_layers(tests, 'a section of a scene', reduced_layers(), 1.0_wp)
    call check_balance(tests)
    call check_loaded_springs(tests)
  end subroutine collect_overburden

  !> A wedge below x + y = 1, 1 high, and a block on top of it along z, from three sides.
  subroutine check_solids(tests)
    type(tests_type), intent(inout) :: tests
    type(body_shape_type) :: shapes(2)
    type(overburden_type) :: overburden
    type(mesh_type) :: mesh
    real(wp), parameter :: x(3) = [0.3_wp, 0.2_wp, 0.4_wp], exact(3) = [0.5_wp*heavy, 0.5_wp*heavy, &
      0.6_wp*heavy + 0.3_wp*light]
    character(len=1), parameter :: letter(3) = ['x', 'y', 'z']
    integer :: axis

    call sample_grid('HEX8', 3, 0.0_wp, mesh)
    allocate (shapes(1)%solid, shapes(2)%solid)
    call make_polyhedron(wedge_facets(), shapes(1)%solid)
    call make_polyhedron(block_facets([0.0_wp, 0.0_wp, 1.0_wp], [1.0_wp, 1.0_wp, 1.3_wp]), shapes(2)%solid)
    do axis = 1, 3
      call make_overburden(mesh, shapes, [heavy, light], axis, overburden)
      call tests%close('a line along '//letter(axis)//' through solids of triangles', &
        weight_above(overburden, 1, x, 0.0_wp), exact(axis), rounding*heavy)
    end do
    call tests%close('the highest place', ground_top(overburden), 1.3_wp, rounding)
  end subroutine check_solids

  !> Two blocks with a gap between them: below the level it weighs like the block under it, above nothing.
  subroutine check_gaps(tests)
    type(tests_type), intent(inout) :: tests
    type(body_shape_type) :: shapes(2)
    type(overburden_type) :: overburden
    type(mesh_type) :: mesh

    call sample_grid('QUAD4', 3, 0.0_wp, mesh)
    shapes(1)%outline = reshape([0.0_wp, 2.0_wp, 1.0_wp, 2.0_wp, 1.0_wp, 3.0_wp, 0.0_wp, 3.0_wp], [2, 4])
    shapes(2)%outline = reshape([0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 1.0_wp], [2, 4])
    call make_overburden(mesh, shapes, [light, heavy], 2, overburden)
    associate (x => [0.4_wp, 0.5_wp])
      call tests%close('a gap above the level has no weight', weight_above(overburden, 2, x, 1.0_wp), &
        0.5_wp*heavy + light, rounding*heavy)
      call tests%close('a gap below the level', weight_above(overburden, 2, x, 3.0_wp), 1.5_wp*heavy + light, &
        rounding*heavy)
      call tests%close('a level in the gap', weight_above(overburden, 2, x, 1.5_wp), 1.0_wp*heavy + light, &
        rounding*heavy)
      call tests%close('a level above all', weight_above(overburden, 2, x, 5.0_wp), 1.5_wp*heavy + 3.0_wp*light, &
        rounding*heavy)
    end associate
    call tests%close('beside all bodies', weight_above(overburden, 1, [0.5_wp, 2.5_wp], 0.0_wp), 0.5_wp*light, &
      rounding*heavy)
  end subroutine check_gaps

  !> Ground between 0 and 1 and between 2.5 and 4, 2 high; two structures between them, the left one 3 high.
  subroutine check_beside(tests)
    type(tests_type), intent(inout) :: tests
    type(body_shape_type) :: shapes(4)
    type(overburden_type) :: overburden
    type(mesh_type) :: mesh
    real(wp), parameter :: ends(2, 4) = reshape([0.0_wp, 1.0_wp, 2.5_wp, 4.0_wp, 1.0_wp, 2.0_wp, 2.0_wp, 2.5_wp], [2, 4])
    integer :: b

    call sample_grid('QUAD4', 4, 0.0_wp, mesh)
    do b = 1, 4
      associate (a => ends(1, b), e => ends(2, b), top => merge(3.0_wp, 2.0_wp, b == 3))
        shapes(b)%outline = reshape([a, 0.0_wp, e, 0.0_wp, e, top, a, top], [2, 4])
      end associate
    end do
    call make_overburden(mesh, shapes, [heavy, light, heavy, heavy], 2, overburden)
    call check_place(tests, 'without structures a place is itself', 3, [1.2_wp, 1.0_wp], 3, 1.2_wp)
    overburden%structure = [.false., .false., .true., .true.]
    call check_place(tests, 'the ground is itself', 2, [3.0_wp, 1.0_wp], 2, 3.0_wp)
    call check_place(tests, 'left of both', 3, [1.7_wp, 1.0_wp], 1, 1.0_wp)
    call check_place(tests, 'right of both', 3, [1.8_wp, 0.5_wp], 2, 2.5_wp)
    call check_place(tests, 'right of the right one', 4, [2.2_wp, 1.5_wp], 2, 2.5_wp)
    call check_place(tests, 'above the ground', 3, [1.1_wp, 2.5_wp], 0, 1.0_wp)
    overburden%structure = [.true., .false., .true., .true.]
    call check_place(tests, 'a structure at the side', 1, [0.2_wp, 1.0_wp], 2, 2.5_wp)
    overburden%structure = .true.
    call check_place(tests, 'structures alone', 3, [1.2_wp, 1.0_wp], 3, 1.2_wp)

  contains

    !> The body beside a place of a body, and where along x.
    subroutine check_place(tests, name, body, position, beside, x)
      type(tests_type), intent(inout) :: tests
      character(len=*), intent(in) :: name
      integer, intent(in) :: body, beside
      real(wp), intent(in) :: position(2), x
      real(wp) :: place(2)
      integer :: found

      call find_beside(overburden, body, position, found, place)
      call tests%check('beside structures: '//name, found == beside)
      call tests%close('beside structures: '//name//', where', place(1), x, 1.0e-5_wp)
      call tests%close('beside structures: '//name//', how high', place(2), position(2), rounding)
    end subroutine check_place
  end subroutine check_beside

  !> Two layers, 4 high and 2 wide; the interface rises from 1 to 2, so a grid line of no element follows it.
  function plane_layers() result(deck)
    character(len=:), allocatable :: deck

    deck = joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4| X, 0, 2, 4| Y, 0, 5, 7|'// &
      '*MATERIAL, NAME=heavy|*ELASTIC| 1e6, 0.3|*UNIT WEIGHT| 20|*K0| 0.7|'// &
      '*MATERIAL, NAME=light|*ELASTIC| 1e6, 0.3|*UNIT WEIGHT| 10|'// &
      '*BODY, NAME=low, MATERIAL=heavy, SHAPE=POLYGON| 0, 0| 2, 0| 2, 2| 0, 1|'// &
      '*BODY, NAME=up, MATERIAL=light, SHAPE=POLYGON| 0, 1| 2, 2| 2, 4| 0, 4|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*PHASE, NAME=start|*INITIAL, TYPE=K0| 4, 0.5|*FIX| base, ALL|'// &
      '*GRAVITY| 0, -1|*END PHASE|')
  end function plane_layers

  !> The same between z = 0 and 1.
  function solid_layers() result(deck)
    character(len=:), allocatable :: deck

    deck = changed(changed(plane_layers(), 'PLANE STRAIN', '3D'), 'QUAD4', 'HEX8')
    deck = changed(deck, '*MATERIAL, NAME=heavy', ' Z, 0, 1, 2|*MATERIAL, NAME=heavy')
    deck = changed(deck, '*NSET, NSET=base', '*NSET, NSET=front, PLANE=Z| 0|*NSET, NSET=back, PLANE=Z| 1|'// &
      '*NSET, NSET=base')
    deck = changed(deck, 'base, ALL', 'base, ALL| front, Z| back, Z')
    deck = changed(deck, '0, -1', '0, -1, 0')
  end function solid_layers

  !> Level layers of cells.
  function cell_layers() result(deck)
    character(len=:), allocatable :: deck

    deck = joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=TRI3, DIAGONAL=RANDOM| X, 0, 2, 4| Y, 0, 4, 8|'// &
      '*METHOD, BASIS=STANDARD|'// &
      '*ELSET, ELSET=deep, BOX| 0, 2, 0, 1|*ELSET, ELSET=high, BOX| 0, 2, 1, 4|'// &
      '*MATERIAL, NAME=heavy|*ELASTIC| 1e6, 0.3|*UNIT WEIGHT| 20|*K0| 0.7|'// &
      '*MATERIAL, NAME=light|*ELASTIC| 1e6, 0.3|*UNIT WEIGHT| 10|'// &
      '*BODY, NAME=low, MATERIAL=heavy, SHAPE=REGION, REGION=deep|'// &
      '*BODY, NAME=up, MATERIAL=light, SHAPE=REGION, REGION=high|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=left, PLANE=X| 0|*NSET, NSET=right, PLANE=X| 2|'// &
      '*PHASE, NAME=start|*INITIAL, TYPE=K0| 4, 0.5|*FIX| base, ALL| left, X| right, X|*GRAVITY| 0, -1|*END PHASE|')
  end function cell_layers

  !> The slice in space, to be reduced.
  function reduced_layers() result(deck)
    character(len=:), allocatable :: deck

    deck = changed(solid_layers(), 'TYPE=3D', 'TYPE=AUTO')
  end function reduced_layers

  !> K0 stresses of all points against the weight above them by hand.
  subroutine check_layers(tests, name, deck, rise)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name, deck
    !> Rise of the interface over the width.
    real(wp), intent(in) :: rise
    class(model_type), allocatable :: model
    class(analysis_type), allocatable :: analysis
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)
    type(error_type), allocatable :: error
    real(wp) :: interface_level, vertical, ratio, off
    integer :: p

    allocate (model, analysis)
    call reduced(deck, analysis, expansion, checks)
    call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the layers of the unit tests cannot be built'
    call start_phase(model)
    off = 0.0_wp
    associate (points => model%state%points)
      do p = 1, points%count
        interface_level = 1.0_wp + 0.5_wp*rise*points%position(1, p)
        vertical = -light*(4.0_wp - max(points%position(2, p), interface_level)) &
          - heavy*max(0.0_wp, interface_level - points%position(2, p))
        ratio = merge(k0_low, k0, analysis%materials(points%material(p))%name == 'heavy')
        off = max(off, abs(points%stress(2, p) - vertical), abs(points%stress(1, p) - ratio*vertical), &
          abs(points%stress(3, p) - ratio*vertical), maxval(abs(points%stress(4:, p))))
      end do
      call tests%check(name//': both layers have points', all([any(points%material == 1), any(points%material == 2)]))
    end associate
    call tests%close(name//': K0 stresses', off, 0.0_wp, rounding*heavy*4.0_wp)
  end subroutine check_layers

  !> Level cells are in equilibrium to rounding; a step of 1 in a level, and the weight of one layer less, are found.
  subroutine check_balance(tests)
    type(tests_type), intent(inout) :: tests
    type(balance_type) :: balance

    balance = balance_of(cell_layers())
    call tests%close('level layers are in equilibrium', balance%residual, 0.0_wp, 1.0e-12_wp)
    call tests%close('level layers do not move', balance%move, 0.0_wp, 1.0e-12_wp)
    balance = balance_of(plane_layers())
    call tests%check('an interface of 1:2 moves the ground by more than a hundredth of its settlement', &
      balance%move > 1.0e-2_wp)
    ! A level 1 too high puts 10 on all stresses, and the ground heaves by 10 H/M; under its own weight it settles by
    ! the integral of the stress over M, 85/M. The cells' error in the latter is 1 %.
    balance = balance_of(changed(cell_layers(), ' 4, 0.5', ' 5, 0.5'))
    call tests%close('a level too high by 1', balance%move, 10.0_wp*4.0_wp/85.0_wp, 2.0e-2_wp)
  end subroutine check_balance

  !> Springs under the ground that an earlier phase has loaded by its weight hold it up; those loaded twice as much lift
  !> it by their surplus, and their own settlement is a part of that under the weight.
  subroutine check_loaded_springs(tests)
    type(tests_type), intent(inout) :: tests
    type(balance_type) :: balance
    character(len=:), allocatable :: deck

    deck = changed(changed(cell_layers(), ' base, ALL|', ''), '*PHASE', &
      '*SURFACE, NAME=rock, TYPE=SEGMENT| 0, 0, 2, 0|*PHASE')
    deck = changed(deck, '*GRAVITY', '*SUPPORT, SURFACE=rock, TYPE=NORMAL|*GRAVITY')
    balance = balance_of(deck, pressed=50.0_wp)
    call tests%close('springs that carry the weight balance it', balance%residual, 0.0_wp, 1.0e-10_wp)
    balance = balance_of(deck, pressed=100.0_wp)
    call tests%check('springs pressed by twice the weight do not', balance%residual > 0.1_wp)
    call tests%check('and lift the ground', balance%move > 1.0e-4_wp)
  end subroutine check_loaded_springs

  !> Balance of the K0 stresses of a deck.
  function balance_of(deck, pressed) result(balance)
    character(len=*), intent(in) :: deck
    !> Pressure that the springs of all supports carry already; 0 for none.
    real(wp), intent(in), optional :: pressed
    type(balance_type) :: balance
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step

    allocate (analysis, model, step)
    call parse_deck('test.inp', deck, analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the layers of the unit tests cannot be built'
    call start_phase(model)
    if (present(pressed)) model%state%surface%position = model%state%surface%position &
      + pressed/spring_stiffness(model)*model%state%surface%normal
    call initialise_step(model, step, error)
    if (.not. allocated(error)) call measure_balance(model, step, balance)
  end function balance_of

  !> Stiffness of the springs of a support per area, E = 1e6 of the decks.
  pure real(wp) function spring_stiffness(model)
    type(model_type), intent(in) :: model

    spring_stiffness = 1.0e3_wp*1.0e6_wp/model%cell_size
  end function spring_stiffness
end module test_overburden
