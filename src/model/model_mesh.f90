!> The mesh of a model and the sets of the deck on it.
!>
!> Of a grid, only the part named by the state is generated (`qsmpm_model_window`). A set may have no node in it, but
!> must have one in the whole grid, which is checked when the model is built.
!>
!> Also builds the space of displacements selected by *METHOD.
module qsmpm_model_mesh
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_error, only: error_type
  use qsmpm_fitted_background, only: fit_background
  use qsmpm_analysis, only: analysis_type, three_dimensional, axisymmetric
  use qsmpm_body_description, only: body_polygon, body_type
  use qsmpm_mesh_description, only: mesh_grid, mesh_file, mesh_fitted, mesh_inline, select_list, select_box, &
    select_plane, set_type, holds_corner
  use qsmpm_method_description, only: basis_fem, integrate_cells, basis_standard, basis_list
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_source_line, only: source_line_type
  use qsmpm_element, only: element_from_name, local_dimension
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic, where_text
  use qsmpm_model, only: model_type
  use qsmpm_grid, only: grid_type, make_grid, whole_window
  use qsmpm_grid_window, only: operator(==), cells_of, place_of
  use qsmpm_mesh, only: mesh_type
  use qsmpm_text, only: integer_text
  use qsmpm_mesh_readers, only: read_mesh, inline_mesh
  use qsmpm_mesh_topology, only: build_topology
  use qsmpm_mesh_sets, only: faces_in_box, nodes_in_box, nodes_on_plane, add_set, set_tolerance
  use qsmpm_history_description, only: quantity_reaction
  use qsmpm_layer_interfaces, only: interface_type, find_interfaces
  use qsmpm_space_builder, only: element_space, spline_space, reduced_knots_type
  implicit none
  private

  public :: make_mesh, make_sets, grid_of, sizes_text, grid_text, make_space

  !> A block of grid nodes.
  type :: line_box_type
    !> First and last line along each axis; 1 and 1 along z in plane models.
    integer :: low(3) = 1, high(3) = 1
    !> Whether the set has nodes and includes all of the block.
    logical :: whole = .false.
  end type line_box_type

contains

  !> Generates or reads the mesh and builds its tables.
  subroutine make_mesh(model, diagnostics)
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    type(error_type), allocatable :: error

    associate (source => model%analysis%mesh)
      select case (source%kind)
      case (mesh_grid)
        call make_grid(grid_of(model%analysis), model%mesh, model%state%window)
        model%mesh%is_box = model%analysis%method%basis /= basis_fem
      case (mesh_fitted)
        call fit_background(model%analysis, model%mesh, error)
        model%mesh%is_box = model%analysis%method%basis /= basis_fem
      case (mesh_file)
        call read_mesh(source%file, source%format, model%mesh, error)
      case (mesh_inline)
        call inline_mesh(element_from_name(source%element), source%node_labels, source%nodes, &
          source%element_labels, source%connectivity, model%mesh, error)
      end select
      model%mesh%axisymmetric = model%analysis%model == axisymmetric
      if (.not. allocated(error)) then
        if (model%mesh%dimension /= merge(3, 2, model%analysis%model == three_dimensional)) then
          call add_diagnostic(diagnostics, source%where, keyword_of(source%kind), &
            'the dimension of the mesh differs from that of *MODEL')
          return
        end if
        call build_topology(model%mesh, error)
      end if
      if (allocated(error)) call add_diagnostic(diagnostics, source%where, keyword_of(source%kind), error%message)
    end associate
  end subroutine make_mesh

  !> Returns the keyword that defines a mesh.
  pure function keyword_of(kind) result(keyword)
    !> Element kind.
    integer, intent(in) :: kind
    character(len=:), allocatable :: keyword

    select case (kind)
    case (mesh_grid, mesh_fitted)
      keyword = '*GRID'
    case (mesh_file)
      keyword = '*MESH'
    case default
      keyword = '*ELEMENT'
    end select
  end function keyword_of

  !> Returns the structured grid of an analysis, which respects the edges of polygonal bodies.
  pure type(grid_type) function grid_of(analysis) result(grid)
    type(analysis_type), intent(in) :: analysis
    integer :: i

    associate (source => analysis%mesh)
      grid%kind = element_from_name(source%element)
      do i = 1, local_dimension(grid%kind)
        grid%axes(i)%lines = source%axes(i)%lines
      end do
      grid%diagonal = source%diagonal
      grid%perturbation = source%perturbation
      grid%seed = source%seed
    end associate
    allocate (grid%kept(4, 0))
    do i = 1, size(analysis%bodies)
      if (analysis%bodies(i)%kind == body_polygon) call add_edges(analysis%bodies(i), grid%kept)
    end do
  end function grid_of

  !> Returns the numbers of nodes, elements and material points of a model as built; of a model divided while it was
  !> built, the mesh of an undivided run and the points of all processes.
  pure function sizes_text(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    integer :: nodes, cells, points, along(3)

    nodes = model%mesh%node_count
    cells = model%mesh%cell_count
    points = model%state%points%count
    if (model%part%built_points > 0) then
      along = cells_of(model%part%built_window)
      cells = product(along)
      along(:model%mesh%dimension) = along(:model%mesh%dimension) + 1
      nodes = product(along)
      points = int(model%part%built_points)
    end if
    text = integer_text(nodes)//' nodes, '//integer_text(cells)//' elements, '//integer_text(points)//' material points'
  end function sizes_text

  !> Returns which part of its grid a model covers; for models with a grid.
  pure function grid_text(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    integer :: cells(3)

    cells = cells_of(model%state%window)
    if (model%part%built_points > 0) cells = cells_of(model%part%built_window)
    text = 'grid of '//cells_text(cells_of(whole_window(grid_of(model%analysis))), model%mesh%dimension)// &
      ' cells, '//cells_text(cells, model%mesh%dimension)//' of them looked at'
  end function grid_text

  !> Returns the numbers of cells along the axes, as in `4 x 2`.
  pure function cells_text(cells, dimension) result(text)
    !> Numbers of cells along each axis (3); 2 or 3.
    integer, intent(in) :: cells(3), dimension
    character(len=:), allocatable :: text
    integer :: a

    text = integer_text(cells(1))
    do a = 2, dimension
      text = text//' x '//integer_text(cells(a))
    end do
  end function cells_text

  !> Appends the edges of a polygon.
  pure subroutine add_edges(body, segments)
    !> The body.
    type(body_type), intent(in) :: body
    real(wp), allocatable, intent(inout) :: segments(:, :)
    integer :: k, n

    n = size(body%polygon, 2)
    segments = reshape([segments, (body%polygon(:, k), body%polygon(:, mod(k, n) + 1), k=1, n)], &
      [4, size(segments, 2) + n])
  end subroutine add_edges

  !> Creates the sets of the deck and checks that every set named by a phase exists.
  subroutine make_sets(model, diagnostics)
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: i, p

    if (.not. allocated(model%mesh%node_sets)) allocate (model%mesh%node_sets(0))
    do i = 1, size(model%analysis%node_sets)
      call make_node_set(model, model%analysis%node_sets(i), diagnostics)
    end do
    do i = 1, size(model%analysis%element_sets)
      call make_cell_set(model, model%analysis%element_sets(i), diagnostics)
    end do
    do p = 1, size(model%analysis%phases)
      associate (phase => model%analysis%phases(p))
        do i = 1, size(phase%fixities)
          call require(model, phase%fixities(i)%set, phase%fixities(i)%where, '*FIX', diagnostics)
        end do
        do i = 1, size(phase%prescriptions)
          call require(model, phase%prescriptions(i)%set, phase%prescriptions(i)%where, '*PRESCRIBE', diagnostics)
        end do
        if (.not. phase%consolidation%given) cycle
        do i = 1, size(phase%consolidation%sets)
          call require(model, phase%consolidation%sets(i)%name, phase%consolidation%sets(i)%where, '*CONSOLIDATION', &
            diagnostics)
        end do
      end associate
    end do
    associate (moving => model%analysis%moving_mesh)
      if (moving%active .and. .not. moving%by_body) call require(model, moving%set, moving%where, '*MOVING MESH', &
        diagnostics)
    end associate
  end subroutine make_sets

  !> Checks that a named node set exists.
  subroutine require(model, name, where, keyword, diagnostics)
    type(model_type), intent(in) :: model
    character(len=*), intent(in) :: name
    type(source_line_type), intent(in) :: where
    character(len=*), intent(in) :: keyword
    type(diagnostics_type), intent(inout) :: diagnostics

    if (place_named(model%mesh%node_sets, name) == 0) &
      call add_diagnostic(diagnostics, where, keyword, "there is no node set '"//name//"' in the deck or the mesh")
  end subroutine require

  !> Creates a node set; labels must exist and a selector must find a node, at least in the whole grid.
  subroutine make_node_set(model, set, diagnostics)
    type(model_type), intent(inout) :: model
    type(set_type), intent(in) :: set
    type(diagnostics_type), intent(inout) :: diagnostics
    type(mesh_type) :: whole
    integer, allocatable :: items(:), others(:)
    integer :: found

    call find_nodes(model%mesh, set, items)
    found = size(items)
    if (model%windows_built > 0) found = huge(found)
    if (is_missing(set, found) .and. is_part(model)) then
      if (holds_corner(set, model%analysis%mesh%axes(:model%mesh%dimension), set_tolerance(model%mesh)) .and. &
          .not. model%analysis%mesh%perturbation > 0.0_wp) then
        found = 1
      else
        call make_grid(grid_of(model%analysis), whole)
        call find_nodes(whole, set, others)
        found = size(others)
      end if
    end if
    if (is_missing(set, found) .and. set%selection == select_list) &
      call add_diagnostic(diagnostics, set%where, '*NSET', "set '"//set%name//"' names nodes that are not in the mesh")
    if (found == 0) call add_diagnostic(diagnostics, set%where, '*NSET', "set '"//set%name//"' finds no node"// &
      nearest_text(model, set))
    if (set%selection == select_plane .and. any(model%analysis%mesh%kind == [mesh_file, mesh_inline])) &
      call note_few_nodes(model, set, items)
    call add_set(model%mesh%node_sets, set%name, items)
  end subroutine make_node_set

  !> Returns true if a set has fewer nodes than it should.
  pure logical function is_missing(set, found)
    type(set_type), intent(in) :: set
    !> Number of nodes found.
    integer, intent(in) :: found

    is_missing = found == 0
    if (set%selection == select_list) is_missing = is_missing .or. found < size(set%labels)
  end function is_missing

  !> Returns true if the mesh is only a part of its grid.
  pure logical function is_part(model)
    type(model_type), intent(in) :: model

    is_part = model%analysis%mesh%kind == mesh_grid
    if (is_part) is_part = .not. model%state%window == whole_window(grid_of(model%analysis))
  end function is_part

  !> Returns the location of the nodes nearest to a plane; empty for other sets and for grids, whose lines are in the
  !> deck.
  pure function nearest_text(model, set) result(text)
    type(model_type), intent(in) :: model
    type(set_type), intent(in) :: set
    character(len=:), allocatable :: text

    text = ''
    if (set%selection /= select_plane .or. model%analysis%mesh%kind == mesh_grid) return
    associate (at => model%mesh%coordinates(set%axis, :))
      text = '; the nearest lie at '//achar(iachar('x') + set%axis - 1)//' = '// &
        rounded_text(at(minloc(abs(at - set%box(set%axis, 1)), dim=1)), 9)
    end associate
  end function nearest_text

  !> Warns of a plane without element sides on it: the constraint then acts on isolated nodes only.
  subroutine note_few_nodes(model, set, items)
    type(model_type), intent(inout) :: model
    type(set_type), intent(in) :: set
    !> Nodes of the set.
    integer, intent(in) :: items(:)
    real(wp) :: box(3, 2)
    integer, allocatable :: faces(:, :)

    box(:, 1) = -huge(box)
    box(:, 2) = huge(box)
    box(set%axis, :) = set%box(set%axis, 1)
    call faces_in_box(model%mesh, box, faces)
    if (size(items) == 0 .or. size(faces) > 0) return
    model%notes = model%notes//'warning: '//where_text(set%where)//"*NSET: set '"//set%name//"' finds "// &
      integer_text(size(items))//' of '//integer_text(model%mesh%node_count)//' nodes and no side of a cell: the '// &
      'ground boundary does not follow the plane, and constraints act on single nodes'//new_line('a')
  end subroutine note_few_nodes

  !> Finds the nodes of a mesh selected by a set of the deck.
  subroutine find_nodes(mesh, set, items)
    type(mesh_type), intent(in) :: mesh
    type(set_type), intent(in) :: set
    !> Node numbers, ascending.
    integer, allocatable, intent(out) :: items(:)
    integer :: i

    select case (set%selection)
    case (select_plane)
      call nodes_on_plane(mesh, set%axis, set%box(set%axis, 1), items)
    case (select_box)
      call nodes_in_box(mesh, set%box, items)
    case default
      allocate (items, source=pack([(i, i=1, mesh%node_count)], &
        [(any(set%labels == mesh%node_label(i)), i=1, mesh%node_count)]))
    end select
  end subroutine find_nodes

  !> Creates an element set: labels, or the elements with all nodes in a box.
  subroutine make_cell_set(model, set, diagnostics)
    type(model_type), intent(inout) :: model
    type(set_type), intent(in) :: set
    type(diagnostics_type), intent(inout) :: diagnostics
    type(mesh_type) :: whole
    integer, allocatable :: items(:), others(:)

    call find_cells(model%mesh, set, items)
    if (size(items) == 0 .and. model%windows_built == 0) then
      allocate (others(0))
      if (is_part(model)) then
        call make_grid(grid_of(model%analysis), whole)
        call find_cells(whole, set, others)
      end if
      if (size(others) == 0) &
        call add_diagnostic(diagnostics, set%where, '*ELSET', "set '"//set%name//"' finds no element")
    end if
    call add_set(model%mesh%cell_sets, set%name, items)
  end subroutine make_cell_set

  !> Finds the cells of a mesh selected by a set of the deck.
  subroutine find_cells(mesh, set, items)
    type(mesh_type), intent(in) :: mesh
    type(set_type), intent(in) :: set
    !> Cell numbers, ascending.
    integer, allocatable, intent(out) :: items(:)
    integer, allocatable :: nodes(:)
    logical :: inside(mesh%node_count), chosen(mesh%cell_count)
    integer :: c

    inside = .false.
    if (set%selection == select_box) then
      call nodes_in_box(mesh, set%box, nodes)
      inside(nodes) = .true.
    end if
    do c = 1, mesh%cell_count
      if (set%selection == select_list) then
        chosen(c) = any(set%labels == mesh%cell_label(c))
      else
        chosen(c) = all(inside(mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1)))
      end if
    end do
    allocate (items, source=pack([(c, c=1, mesh%cell_count)], chosen))
  end subroutine find_cells

  !> Builds the space; GIMP and splines require a regular grid of quadrilaterals or bricks.
  subroutine make_space(model, diagnostics)
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    logical :: constrained(size(model%mesh%node_sets))
    type(line_box_type) :: boxes(size(model%mesh%node_sets))
    type(reduced_knots_type) :: reduced_knots(3)
    integer :: s

    if (any(model%analysis%method%basis == [basis_standard, basis_fem])) then
      call element_space(model%mesh, model%space)
      return
    end if
    associate (source => model%analysis%mesh)
      if (source%kind /= mesh_grid) then
        call add_diagnostic(diagnostics, source%where, '*METHOD', &
          'GIMP and splines need a structured grid: give the mesh by *GRID')
        return
      end if
      if (all(source%element /= ['QUAD4', 'HEX8 ']) .or. source%perturbation > 0.0_wp) then
        call add_diagnostic(diagnostics, source%where, '*GRID', &
          'GIMP and splines need ELEMENT=QUAD4 or HEX8 without PERTURB')
        return
      end if
    end associate
    do s = 1, size(boxes)
      call box_of_set(model, model%analysis%node_sets(s), boxes(s))
    end do
    call mark_constrained(model, boxes, constrained, diagnostics)
    call find_reduced_knots(model, boxes, constrained, reduced_knots)
    associate (basis => basis_list(model%analysis%method%basis))
      call spline_space(model%mesh, cells_of(model%state%window), basis%degree, basis%averaged, constrained, &
        model%space, reduced_knots, model%state%window%first - 1)
    end associate
    ! Splines without averaging detect cut cells better by the domains of the points than by the points.
    model%space%domains = model%space%averaged .or. model%analysis%method%integration == integrate_cells
  end subroutine make_space

  !> Finds the lines of the whole grid that bound the nodes of a set.
  pure subroutine box_of_set(model, set, box)
    type(model_type), intent(in) :: model
    type(set_type), intent(in) :: set
    !> The block of the set.
    type(line_box_type), intent(out) :: box
    integer :: lines(3), at(3), a, i
    real(wp) :: near

    near = set_tolerance(model%mesh)
    lines = 1
    do a = 1, model%mesh%dimension
      associate (x => model%analysis%mesh%axes(a)%lines)
        lines(a) = size(x)
        box%low(a) = 1
        box%high(a) = size(x)
        if (set%selection == select_box .or. (set%selection == select_plane .and. set%axis == a)) then
          box%low(a) = 1 + count(x < set%box(a, 1) - near)
          box%high(a) = count(x <= set%box(a, merge(1, 2, set%selection == select_plane)) + near)
        end if
      end associate
    end do
    box%whole = all(box%low <= box%high)
    if (any(set%selection == [select_plane, select_box])) return
    box%low = lines
    box%high = 1
    do i = 1, size(set%labels)
      at = place_of(set%labels(i), lines)
      box%low = min(box%low, at)
      box%high = max(box%high, at)
    end do
    box%whole = size(set%labels) == product(box%high - box%low + 1)
  end subroutine box_of_set

  !> Finds the reduced knots of the whole grid: where a constrained set begins or ends, and where layers of different
  !> stiffness meet.
  pure subroutine find_reduced_knots(model, boxes, constrained, reduced_knots)
    type(model_type), intent(in) :: model
    !> Blocks of the sets, and which sets are constrained (node sets).
    type(line_box_type), intent(in) :: boxes(:)
    logical, intent(in) :: constrained(:)
    !> Reduced knots along each axis.
    type(reduced_knots_type), intent(out) :: reduced_knots(3)
    type(interface_type), allocatable :: interfaces(:)
    integer :: a, s

    call find_interfaces(model%analysis, interfaces)
    do a = 1, model%mesh%dimension
      allocate (reduced_knots(a)%at(size(model%analysis%mesh%axes(a)%lines)))
      reduced_knots(a)%at = .false.
      do s = 1, size(boxes)
        if (constrained(s) .and. boxes(s)%whole) reduced_knots(a)%at([boxes(s)%low(a), boxes(s)%high(a)]) = .true.
      end do
      reduced_knots(a)%at(pack(interfaces%line, interfaces%axis == a)) = .true.
    end do
  end subroutine find_reduced_knots

  !> Marks the node sets that a phase constrains or that are the plate of a moving mesh. Sets that are not a block have
  !> no control points and cannot be constrained.
  subroutine mark_constrained(model, boxes, constrained, diagnostics)
    type(model_type), intent(in) :: model
    !> Blocks of the sets (node sets).
    type(line_box_type), intent(in) :: boxes(:)
    !> (node sets)
    logical, intent(out) :: constrained(:)
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: p, i

    constrained = .false.
    do p = 1, size(model%analysis%phases)
      associate (phase => model%analysis%phases(p))
        do i = 1, size(phase%fixities)
          call constrain(phase%fixities(i)%set, phase%fixities(i)%where, '*FIX')
        end do
        do i = 1, size(phase%prescriptions)
          call constrain(phase%prescriptions(i)%set, phase%prescriptions(i)%where, '*PRESCRIBE')
        end do
      end associate
    end do
    associate (moving => model%analysis%moving_mesh)
      if (moving%active .and. .not. moving%by_body) call constrain(moving%set, moving%where, '*MOVING MESH')
    end associate
    call check_reactions(model, boxes, constrained, diagnostics)

  contains

    !> Marks a set; a set that is not a block is reported once.
    subroutine constrain(name, where, keyword)
      character(len=*), intent(in) :: name
      !> Location and keyword where it is named.
      type(source_line_type), intent(in) :: where
      character(len=*), intent(in) :: keyword
      integer :: s

      s = place_named(model%mesh%node_sets, name)
      if (s == 0) return
      if (.not. constrained(s) .and. .not. boxes(s)%whole) &
        call add_diagnostic(diagnostics, where, keyword, no_box(name))
      constrained(s) = .true.
    end subroutine constrain
  end subroutine mark_constrained

  !> Checks that sets whose reaction is a history are blocks; constrained sets have been checked already.
  subroutine check_reactions(model, boxes, constrained, diagnostics)
    type(model_type), intent(in) :: model
    !> Blocks of the sets, and which sets are constrained (node sets).
    type(line_box_type), intent(in) :: boxes(:)
    logical, intent(in) :: constrained(:)
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: i, s

    do i = 1, size(model%analysis%histories)
      associate (history => model%analysis%histories(i))
        if (history%quantity /= quantity_reaction) cycle
        s = place_named(model%mesh%node_sets, history%set)
        if (s == 0) cycle
        if (constrained(s) .or. boxes(s)%whole) cycle
        call add_diagnostic(diagnostics, history%where, '*HISTORY', no_box(history%set))
      end associate
    end do
  end subroutine check_reactions

  !> Returns the reason why a set cannot be constrained.
  pure function no_box(name) result(message)
    !> Name of the set.
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: message

    message = "with GIMP and splines node set '"//name//"' must hold all grid nodes of a plane or box"
  end function no_box
end module qsmpm_model_mesh
