!> Surfaces of contacts that stretch: points split and join, and what they carry in all stays.
module test_surface_refinement
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_surface_refinement, only: refine_surfaces
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_surface_refinement

  !> A block two wide under a plane, cells of 0.25, the surface from the left to the middle; a second one that is loaded.
  character(len=*), parameter :: head = '*GRID, ELEMENT=QUAD4|X, 0, 4, 16|Y, 0, 2, 8|*NSET, NSET=base, PLANE=Y|0|'// &
    '*SURFACE, NAME=top, TYPE=SEGMENT|1, 1.1, 0, 1.1|*SURFACE, NAME=rest, TYPE=SEGMENT|2, 1.1, 1, 1.1|'// &
    '*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|0, 2, 0, 1.1|'// &
    '*METHOD, BASIS=GIMP, INTEGRATION=CELL|*RIGID BODY, NAME=plate, SHAPE=PLANE|0, 1.1, 0, -1|'// &
    '*CONTACT, BODY=plate, SURFACE=top, ADHESION=1|*PHASE, NAME=press|*FIX|base, ALL|*PRESSURE, SURFACE=rest|1|'
  real(wp), parameter :: rounding = 1.0e-13_wp

contains

  !> All tests of the suite.
  subroutine collect_surface_refinement(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('surface_refinement')
    call check_stretched(tests, 'PLANE STRAIN')
    call check_stretched(tests, 'AXISYMMETRIC')
    call check_others(tests)
  end subroutine collect_surface_refinement

  !> The model as drawn.
  subroutine build(tests, kind, more, model)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind, more
    type(model_type), intent(out) :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('test.inp', joined('*MODEL, TYPE='//kind//'|'//head//more//'*MOVE, BODY=plate|0, -0.1|*END PHASE|'), &
      analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    call tests%check('the model is built', .not. allocated(error))
  end subroutine build

  !> Stretch the surface of the contact along x, with pressures that differ from point to point.
  subroutine stretch(model, ratio)
    type(model_type), intent(inout) :: model
    real(wp), intent(in) :: ratio
    real(wp) :: round
    integer :: i

    associate (surface => model%state%surface)
      do i = 1, surface%count
        surface%contact_pressure(i) = 10.0_wp + i
        surface%contact_shear(:, i) = [0.1_wp*i, 0.0_wp]
        surface%contact_slip(:, i) = [0.01_wp*i, 0.0_wp]
        if (surface%surface(i) /= 1) cycle
        surface%position(1, i) = ratio*surface%position(1, i)
        ! In axisymmetry areas are those of rings.
        round = 1.0_wp
        if (model%analysis%model == 2) round = ratio
        surface%area_vector(:, i) = ratio*round*surface%area_vector(:, i)
      end do
    end associate
  end subroutine stretch

  !> Sums over the surface of the contact: area as drawn, area vector, area, times pressure, times shear, reaction.
  function sums_of(model) result(sums)
    type(model_type), intent(in) :: model
    real(wp) :: sums(8), area
    integer :: i

    sums = 0.0_wp
    associate (surface => model%state%surface)
      do i = 1, surface%count
        if (surface%surface(i) /= 1) cycle
        area = norm2(surface%area_vector(:, i))
        sums = sums + [surface%area(i), surface%area_vector(:, i), area, area*surface%contact_pressure(i), &
          area*surface%contact_shear(1, i), area*surface%contact_slip(1, i), surface%reaction(2, i)]
      end do
    end associate
  end function sums_of

  !> Three times as long and back again.
  subroutine check_stretched(tests, kind)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind
    class(model_type), allocatable :: model
    real(wp) :: before(8), longest, shortest
    integer :: drawn, fine

    allocate (model)
    call build(tests, kind, '', model)
    drawn = count(model%state%surface%surface == 1)
    call refine_surfaces(model)
    call tests%check('a surface as drawn stays', count(model%state%surface%surface == 1) == drawn)
    model%state%surface%reaction(2, :) = 1.0_wp
    call stretch(model, 3.0_wp)
    before = sums_of(model)
    call refine_surfaces(model)
    call refine_surfaces(model)
    fine = count(model%state%surface%surface == 1)
    call tests%check(kind//': three times as long it has more points', fine >= 3*drawn/2)
    call tests%check(kind//': sums stay when points are split', all(abs(sums_of(model) - before) <= rounding*abs(before)))
    call measure(model, longest, shortest)
    call tests%check(kind//': no point stands for more than a third of a cell', longest <= 0.25_wp/3.0_wp + rounding)
    call tests%check(kind//': points lie in their cells', all(abs(model%state%surface%local) <= 1.0_wp + 1.0e-9_wp) .and. &
      all(cells_of(model) == model%state%surface%cell))
    call tests%check(kind//': places as drawn are those of the points', all(abs(model%state%surface%position(1, :fine) &
      - 3.0_wp*model%state%surface%initial_position(1, :fine)) < 0.02_wp))
    call stretch(model, 0.1_wp/3.0_wp)
    before = sums_of(model)
    call refine_surfaces(model)
    call refine_surfaces(model)
    call tests%check(kind//': a tenth as long it has fewer', count(model%state%surface%surface == 1) < fine/2)
    call tests%check(kind//': sums stay when points are joined', all(abs(sums_of(model) - before) <= rounding*abs(before)))
  end subroutine check_stretched

  !> Longest and shortest length on the surface of the contact.
  subroutine measure(model, longest, shortest)
    type(model_type), intent(in) :: model
    real(wp), intent(out) :: longest, shortest
    real(wp) :: length
    integer :: i

    longest = 0.0_wp
    shortest = huge(1.0_wp)
    associate (surface => model%state%surface)
      do i = 1, surface%count
        if (surface%surface(i) /= 1) cycle
        length = norm2(surface%area_vector(:, i))
        if (model%analysis%model == 2) length = length/surface%position(1, i)
        longest = max(longest, length)
        shortest = min(shortest, length)
      end do
    end associate
  end subroutine measure

  !> Numbers of the cells that the places of the surface points lie in: rows of sixteen.
  function cells_of(model) result(cells)
    type(model_type), intent(in) :: model
    integer :: cells(model%state%surface%count), i
    real(wp) :: low(2), high(2)

    do i = 1, size(cells)
      associate (mesh => model%mesh, c => model%state%surface%cell(i))
        low = minval(mesh%coordinates(:, mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1)), dim=2)
        high = maxval(mesh%coordinates(:, mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1)), dim=2)
        cells(i) = merge(c, 0, all(model%state%surface%position(:, i) >= low - 1.0e-9_wp) .and. &
          all(model%state%surface%position(:, i) <= high + 1.0e-9_wp))
      end associate
    end do
  end function cells_of

  !> What is loaded, and what bends, is left as it is.
  subroutine check_others(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    integer :: others, i, n

    allocate (model)
    call build(tests, 'PLANE STRAIN', '*TRACTION, SURFACE=top|0, -1|', model)
    n = model%state%surface%count
    call stretch(model, 3.0_wp)
    call refine_surfaces(model)
    call tests%check('a surface that is loaded too keeps its points', model%state%surface%count == n)
    call build(tests, 'PLANE STRAIN', '', model)
    others = count(model%state%surface%surface == 2)
    call stretch(model, 3.0_wp)
    call refine_surfaces(model)
    call tests%check('that of another surface', count(model%state%surface%surface == 2) == others)
    call build(tests, 'PLANE STRAIN', '', model)
    call stretch(model, 0.1_wp)
    do i = 1, model%state%surface%count
      if (mod(i, 2) == 0) model%state%surface%area_vector(:, i) = model%state%surface%area_vector([2, 1], i)
    end do
    call refine_surfaces(model)
    call tests%check('neighbours that look in different directions are not joined to each other', &
      all(abs(minval(abs(model%state%surface%area_vector), dim=1)) <= 0.0_wp))
  end subroutine check_others
end module test_surface_refinement
