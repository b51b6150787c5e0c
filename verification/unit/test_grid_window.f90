!> A part of a grid is the grid with the rest left out, and a model on it follows its material.
module test_grid_window
  use qsmpm_kinds, only: wp, long
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_element, only: element_from_name, local_dimension
  use qsmpm_error, only: error_type
  use qsmpm_grid, only: grid_type, make_grid, whole_window, pieces_of, diagonal_random, uniform, random_after
  use qsmpm_grid_window, only: window_type, operator(==), cells_over, hull, widen, holds, renumber
  use qsmpm_mesh, only: mesh_type
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_model_window, only: follow_material, restore
  use qsmpm_space, only: shape_values_type, functions_at, node_label, node_position
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_grid_window

contains

  !> All checks.
  subroutine collect_grid_window(tests)
    type(tests_type), intent(inout) :: tests
    character(len=7), parameter :: names(10) = [character(len=7) :: 'QUAD4', 'QUAD8', 'TRI3', 'TRI6', 'HEX8', &
      'HEX20', 'WEDGE6', 'WEDGE15', 'TET4', 'TET10']
    integer :: i

    call tests%start('grid_window')
    call check_ranges(tests)
    call check_random(tests)
    do i = 1, size(names)
      call check_part(tests, trim(names(i)))
    end do
    call check_first_window(tests)
    call check_functions(tests, 'SPLINE2')
    call check_functions(tests, 'SPLINE3')
    call check_following(tests, 'ELEMENT=QUAD8', 'BASIS=STANDARD')
    call check_following(tests, 'ELEMENT=TRI6, DIAGONAL=RANDOM, PERTURB=0.2', 'BASIS=STANDARD')
    call check_following(tests, 'ELEMENT=QUAD4', 'BASIS=SPLINE3')
    call check_sets(tests)
    call check_planes(tests)
  end subroutine collect_grid_window

  !> Ranges of cells.
  subroutine check_ranges(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: lines(5) = [0.0_wp, 1.0_wp, 3.0_wp, 4.0_wp, 8.0_wp]
    type(window_type) :: whole, part, wide

    call tests%check('an interval inside a cell touches one', all(touched(1.5_wp, 2.5_wp) == [2, 2]))
    call tests%check('one between lines touches the cells at its ends too', all(touched(1.0_wp, 3.0_wp) == [1, 3]))
    call tests%check('one beyond both ends touches all', all(touched(-9.0_wp, 9.0_wp) == [1, 4]))
    call tests%check('one below the grid has the first cell', all(touched(-9.0_wp, -8.0_wp) == [1, 1]))
    call tests%check('one above the grid has the last cell', all(touched(9.0_wp, 10.0_wp) == [4, 4]))
    whole = window_type([1, 1, 1], [9, 8, 1])
    part = window_type([2, 4, 1], [3, 5, 1])
    wide = widen(part, [2, 2, 2], whole)
    call tests%check('a window is widened as far as the grid goes', wide == window_type([1, 2, 1], [5, 7, 1]))
    call tests%check('the wider one holds the other', holds(wide, part) .and. .not. holds(part, wide))
    call tests%check('a hull holds both', hull(part, window_type([6, 1, 1], [7, 2, 1])) &
      == window_type([2, 1, 1], [7, 5, 1]))
    ! Cell (3, 5) of the grid: number 4 of the part, and (5-2)*5 + 3 of the wider one; its second triangle.
    call tests%check('a cell has its number in either', renumber(part, wide, 2, 8) == 36)

  contains

    !> First and last cell over an interval.
    function touched(low, high) result(cells)
      real(wp), intent(in) :: low, high
      integer :: cells(2)

      call cells_over(lines, low, high, cells(1), cells(2))
    end function touched
  end subroutine check_ranges

  !> The generator starts anywhere in its sequence.
  subroutine check_random(tests)
    type(tests_type), intent(inout) :: tests
    integer(long) :: random
    real(wp) :: u
    logical :: same
    integer :: i

    random = random_after(7, 0_long)
    same = .true.
    do i = 1, 1000
      call uniform(random, u)
      same = same .and. random == random_after(7, int(i, long))
    end do
    call tests%check('the n-th random number is found without the others', same)
    ! The known value after 10 000 numbers from 1 with the multiplier 48271 (ISO C++, minstd_rand in
    ! [rand.predef]).
    call tests%check('the generator is the one it should be', random_after(1, 10000_long) == 399268537_long)
  end subroutine check_random

  !> A part of a disturbed grid against the whole.
  subroutine check_part(tests, name)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(grid_type) :: grid
    type(mesh_type) :: whole, part
    type(window_type) :: window
    logical :: places, order, cells
    integer :: i, k, c, last

    grid%kind = element_from_name(name)
    grid%diagonal = diagonal_random
    grid%perturbation = 0.25_wp
    grid%seed = 11
    do i = 1, local_dimension(grid%kind)
      grid%axes(i)%lines = [(real(k, wp)**1.1_wp, k=0, 5 - i/3)]
    end do
    window = window_type([2, 3, 1], [4, 4, 1])
    if (local_dimension(grid%kind) == 3) window%first(3) = 2
    if (local_dimension(grid%kind) == 3) window%last(3) = 3
    call make_grid(grid, whole)
    call make_grid(grid, part, window)
    places = .true.
    order = .true.
    last = 0
    do i = 1, part%node_count
      k = findloc(whole%node_label, part%node_label(i), dim=1)
      order = order .and. k > last
      last = k
      if (k > 0) places = places .and. all(abs(part%coordinates(:, i) - whole%coordinates(:, k)) <= 0.0_wp)
    end do
    cells = part%cell_count == 6*pieces_of(grid)*merge(2, 1, local_dimension(grid%kind) == 3)
    do c = 1, part%cell_count
      k = whole%cell_label(renumber(window, whole_window(grid), pieces_of(grid), c))
      cells = cells .and. k == part%cell_label(c)
      cells = cells .and. all(whole%node_label(nodes(whole, k)) == part%node_label(nodes(part, c)))
    end do
    call tests%check(name//': nodes of a part come in the order of the whole', order)
    call tests%check(name//': and lie where they lie there, to the bit', places)
    call tests%check(name//': cells of a part have the nodes they have in the whole', cells)
    call tests%check(name//': bounds and size are those of the whole', &
      all(abs(part%bounds - whole%bounds) <= 0.0_wp) .and. abs(part%first_size - whole%first_size) <= 0.0_wp)

  contains

    !> Nodes of a cell.
    pure function nodes(mesh, cell) result(list)
      type(mesh_type), intent(in) :: mesh
      integer, intent(in) :: cell
      integer :: list(mesh%cell_first(cell + 1) - mesh%cell_first(cell))

      list = mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell + 1) - 1)
    end function nodes
  end subroutine check_part

  !> A block of 4 by 4 cells at the foot of a wide grid. A lip beyond it is held: its kinks cross the block.
  function deck(grid, method) result(text)
    !> Words behind *GRID and *METHOD.
    character(len=*), intent(in) :: grid, method
    character(len=:), allocatable :: text

    text = joined('*MODEL, TYPE=PLANE STRAIN|*GRID, '//grid//'| X, 0, 10, 40| Y, 0, 5, 20|*METHOD, '//method// &
      '|*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=lip, BOX| 9, 9.5, 0.5, 0.75|*MATERIAL, NAME=soil'// &
      '|*ELASTIC| 100, 0.3|*UNIT WEIGHT| 10|*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX| 4, 5, 0, 1'// &
      '|*HISTORY, NAME=top, QUANTITY=DISPLACEMENT, COMPONENT=Y| 4.5, 0.9|*PHASE, NAME=load|*FIX| base, ALL'// &
      '| lip, Y|*GRAVITY| 0, -1|*END PHASE|')
  end function deck

  !> Build the model of a deck.
  subroutine build(text, model)
    character(len=*), intent(in) :: text
    type(model_type), intent(out) :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('test.inp', text, analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the deck of the window test is broken'
  end subroutine build

  !> Cells around the body, and none where the deck says so.
  subroutine check_first_window(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model

    allocate (model)
    call build(deck('ELEMENT=QUAD4', 'BASIS=STANDARD'), model)
    ! The block touches cells 16 to 21; two cells must be there, two more save work.
    call tests%check('a window leaves four cells beside the block', &
      model%state%window == window_type([12, 1, 1], [25, 9, 1]))
    call build(deck('ELEMENT=QUAD4', 'BASIS=SPLINE3'), model)
    call tests%check('with cubic splines six', model%state%window == window_type([10, 1, 1], [27, 11, 1]))
    call build(deck('ELEMENT=QUAD4, WINDOW=NO', 'BASIS=SPLINE3'), model)
    call tests%check('and none when it is not wanted', model%state%window == window_type([1, 1, 1], [40, 20, 1]))
  end subroutine check_first_window

  !> Functions and control points of a part against those of the whole.
  subroutine check_functions(tests, basis)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: basis
    class(model_type), allocatable :: part, whole
    type(shape_values_type) :: here, there
    real(wp), parameter :: local(2) = [0.3_wp, -0.7_wp]
    logical :: values, labels, places
    integer :: p, c, a, n

    allocate (part, whole)
    call build(deck('ELEMENT=QUAD4', 'BASIS='//basis), part)
    call build(deck('ELEMENT=QUAD4, WINDOW=NO', 'BASIS='//basis), whole)
    values = part%state%points%count == whole%state%points%count
    labels = .true.
    places = .true.
    do p = 1, part%state%points%count
      c = part%state%points%cell(p)
      call functions_at(part%space, part%mesh, c, local, here)
      call functions_at(whole%space, whole%mesh, whole%state%points%cell(p), local, there)
      n = here%count
      values = values .and. n == there%count .and. all(abs(here%shape(:n) - there%shape(:n)) <= 0.0_wp) &
        .and. all(abs(here%gradient(:, :n) - there%gradient(:, :n)) <= 0.0_wp)
      do a = 1, n
        labels = labels .and. node_label(part%space, part%mesh, here%node(a)) == there%node(a)
        places = places .and. all(abs(node_position(part%space, part%mesh, here%node(a)) &
          - node_position(whole%space, whole%mesh, there%node(a))) <= 0.0_wp)
      end do
    end do
    call tests%check(basis//': functions of a part are those of the whole, also at kinks of a set beyond', values)
    call tests%check(basis//': control points keep their names', labels)
    call tests%check(basis//': and their places', places)
  end subroutine check_functions

  !> Points that move away take the window along; a former state brings its own back.
  subroutine check_following(tests, grid, method)
    type(tests_type), intent(inout) :: tests
    !> Words behind *GRID and *METHOD.
    character(len=*), intent(in) :: grid, method
    class(model_type), allocatable :: model
    class(state_type), allocatable :: before
    integer, allocatable :: cells(:), nodes(:)
    real(wp), allocatable :: places(:, :)
    integer :: i, n

    allocate (model, before)
    call build(deck(grid, method), model)
    ! A reaction that tells its node: the label itself.
    do i = 1, model%space%node_count
      model%state%reactions(:, i) = node_label(model%space, model%mesh, i)
      model%state%released(:, i) = -node_label(model%space, model%mesh, i)
    end do
    before = model%state
    call follow_material(model)
    call tests%check(grid//': nothing moves while nothing does', model%windows_built == 0)
    allocate (cells, source=model%mesh%cell_label(model%state%points%cell))
    n = model%space%node_count
    model%state%points%position(1, :) = model%state%points%position(1, :) + 2.0_wp
    call follow_material(model)
    call tests%check(grid//': the window moves on', model%state%window%last(1) > before%window%last(1) &
      .and. model%state%window%first(1) > 1)
    call tests%check(grid//': no further than the material and what it still is booked in', &
      model%state%window%last(1) < 40 .and. model%state%window%last(2) < 20)
    call tests%check(grid//': points keep their cells', &
      all(model%mesh%cell_label(model%state%points%cell) == cells))
    call tests%check(grid//': arrays are as long as the new mesh', &
      size(model%state%reactions, 2) == model%space%node_count .and. &
      size(model%loading%constrained, 2) == model%space%node_count .and. &
      size(model%state%coordinates, 2) == model%mesh%node_count)
    allocate (nodes(model%space%node_count))
    nodes = [(node_label(model%space, model%mesh, i), i=1, size(nodes))]
    call tests%check(grid//': reactions stay with their nodes', &
      all(nint(model%state%reactions(1, :)) == nodes .or. nint(model%state%reactions(1, :)) == 0) .and. &
      count(nint(model%state%reactions(1, :)) == nodes) > n/2)
    call tests%check(grid//': released forces stay with theirs', &
      all(nint(model%state%released) == -nint(model%state%reactions)))
    call restore(before, model)
    call tests%check(grid//': a former state has its window again', model%state%window == before%window &
      .and. model%space%node_count == n)
    allocate (places, source=model%mesh%coordinates)
    call build(deck(grid, method), model)
    call tests%check(grid//': and its mesh, to the bit', all(abs(places - model%mesh%coordinates) <= 0.0_wp))
  end subroutine check_following

  !> Sets outside of the window are good sets, sets outside of the grid are none.
  subroutine check_sets(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model

    allocate (model)
    call build(deck('ELEMENT=QUAD4', 'BASIS=STANDARD'), model)
    call tests%check('a set beyond the window is empty', size(model%mesh%node_sets(2)%items) == 0)
    call refused('BOX| 9.01, 9.2, 0.5, 0.75', "set 'lip' finds no node", 'a box between the lines')
    call refused('PLANE=X| 9.1', "set 'lip' finds no node", 'a plane between the lines')
    call refused('PLANE=X| 11', "set 'lip' finds no node", 'a plane beyond the grid')

  contains

    !> A deck with another lip is not built.
    subroutine refused(set, message, name)
      character(len=*), intent(in) :: set, message, name
      class(analysis_type), allocatable :: analysis
      type(message_list_type) :: messages
      type(error_type), allocatable :: error
      character(len=:), allocatable :: text
      integer :: at

      allocate (analysis)
      text = deck('ELEMENT=QUAD4', 'BASIS=STANDARD')
      at = index(text, 'BOX'//new_line('a')//' 9')
      text = text(:at - 1)//joined(set)//text(at + len('BOX| 9, 9.5, 0.5, 0.75'):)
      call parse_deck('test.inp', text, analysis, messages, error)
      if (.not. allocated(error)) call build_model(analysis, model, error)
      call tests%check(name//' is refused', allocated(error))
      if (allocated(error)) call tests%check(name//' is told', index(error%message, message) > 0)
    end subroutine refused
  end subroutine check_sets

  !> Planes of a mesh of the deck that hold a side of it, and one node.
  subroutine check_planes(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (model, analysis)
    call parse_deck('test.inp', joined('*MODEL, TYPE=PLANE STRAIN|*NODE|1, 0, 0|2, 1, 0|3, 1, 1|4, 0, 1|5, 0.5, 0.5|'// &
      '*ELEMENT, TYPE=TRI3|1, 1, 2, 5|2, 2, 3, 5|3, 3, 4, 5|4, 4, 1, 5|*NSET, NSET=side, PLANE=X|0|'// &
      '*NSET, NSET=inner, PLANE=X|0.5|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*UNIT WEIGHT|1|'// &
      '*BODY, NAME=soil, MATERIAL=soil, SHAPE=ALL|*PHASE, NAME=one|*FIX|side, ALL|*GRAVITY|0, -1|*END PHASE|'), &
      analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    call tests%check('a mesh of four triangles is built', .not. allocated(error))
    if (allocated(error)) return
    call tests%check('a plane through a node alone is told: '//model%notes, index(model%notes, &
      "warning: test.inp:15: *NSET: set 'inner' finds 1 of 5 nodes and no side of a cell") > 0)
    call tests%check('one through a side is not', index(model%notes, "set 'side'") == 0)
    analysis%node_sets(2)%box(1, 1) = 0.3_wp
    deallocate (model)
    allocate (model)
    call build_model(analysis, model, error)
    call tests%check('one beside it is refused, with the nearest', allocated(error))
    if (allocated(error)) call tests%check(error%message, index(error%message, 'the nearest lie at x = 0.5') > 0)
  end subroutine check_planes
end module test_grid_window
