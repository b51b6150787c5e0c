!> Unsupported parts of the material, for the message of a run that finds no equilibrium.
!>
!> Two material points belong to one part when a chain of functions connects them, each of which is shared by
!> neighbouring points of the chain. A part is supported when no rigid motion of it satisfies the fixities of its nodes
!> and the surfaces that are supported: the matrix sum r r' over its fixed components, r the rigid motions there, has
!> full rank.
module qsmpm_unsupported_parts
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: any_of
  use qsmpm_mesh_description, only: mesh_grid
  use qsmpm_integration, only: integration_type
  use qsmpm_space, only: node_label, node_position
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: is_divided, own_of
  use qsmpm_owner_copies, only: copy_values
  use qsmpm_points, only: place_of
  use qsmpm_sorting, only: order_columns, place_in_order
  use qsmpm_initialisation, only: step_type
  use qsmpm_grid_window, only: operator(==)
  use qsmpm_soil_points, only: soil_type, soil_of
  use qsmpm_team, only: smallest, total, hand_over
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: describe_unsupported_parts

  !> Pivot, relative to the number of fixities, below which a rigid motion is free.
  real(wp), parameter :: least_pivot = 1.0e-9_wp
  !> Number of rigid motions in space (3 in the plane); in axisymmetry one.
  integer, parameter :: most_motions = 6

  !> Part of the material, identified by the lowest label of its nodes.
  type :: piece_type
    integer :: name = 0
    !> Number of material points on all processes, and the lowest number of a point.
    integer :: points = 0, first = 0
    logical :: held = .false.
    !> Bounding box of the points.
    real(wp) :: low(3) = 0.0_wp, high(3) = 0.0_wp
  end type piece_type

contains

  !> Reports which parts are unsupported: empty when all are supported. Called by all processes of a team.
  subroutine describe_unsupported_parts(model, step, text)
    !> The model in its present state.
    type(model_type), intent(in) :: model
    !> Scratch data of the failed step.
    type(step_type), intent(in), target :: step
    !> Text without final punctuation.
    character(len=:), allocatable, intent(out) :: text
    integer :: root(model%space%node_count), of_node(model%space%node_count), of_point(model%state%points%count), n
    type(piece_type), allocatable :: pieces(:)
    type(soil_type), pointer :: soil

    text = ''
    if (.not. is_divided(model%part) .and. (.not. step%window == model%state%window .or. &
      step%at_points%group_count == 0)) return
    do n = 1, size(root)
      root(n) = n
    end do
    call join_groups(step%at_points, root)
    soil => soil_of(step%terms)
    if (allocated(soil%integration)) call join_groups(soil%integration, root)
    call name_pieces(model, root, of_node)
    call find_pieces(step%at_points, of_node, of_point)
    call list_pieces(model, of_point, pieces)
    call measure_pieces(model, of_point, pieces)
    call find_held(model, step, of_node, pieces)
    pieces = pack(pieces, .not. pieces%held)
    if (size(pieces) > 0) text = piece_text(pieces(1), model%mesh%dimension)
    if (size(pieces) > 1) text = text//', one of '//integer_text(size(pieces))//' such pieces'
  end subroutine describe_unsupported_parts

  !> Connects the nodes of each group of points.
  pure subroutine join_groups(integration, root)
    type(integration_type), intent(in) :: integration
    !> A preceding node of the same part, or the node itself (nodes).
    integer, intent(inout) :: root(:)
    integer :: g, k, a, b

    do g = 1, integration%group_count
      associate (nodes => integration%nodes(integration%node_first(g):integration%node_first(g + 1) - 1))
        if (size(nodes) == 0) cycle
        a = first_of(root, nodes(1))
        do k = 2, size(nodes)
          b = first_of(root, nodes(k))
          root(max(a, b)) = min(a, b)
          a = min(a, b)
        end do
      end associate
    end do
    do k = 1, size(root)
      root(k) = first_of(root, k)
    end do
  end subroutine join_groups

  !> Returns the first node of the part of a node.
  pure integer function first_of(root, node) result(first)
    !> A preceding node of the same part, or the node itself (nodes).
    integer, intent(in) :: root(:)
    integer, intent(in) :: node

    first = node
    do while (root(first) /= first)
      first = root(first)
    end do
  end function first_of

  !> Finds the labels of the parts: the lowest label of a node of each, on all processes. The owner of a node knows
  !> every group to which it belongs, so that exchanging the labels of the owners joins parts that extend over several
  !> processes.
  subroutine name_pieces(model, root, name)
    type(model_type), intent(in) :: model
    !> First node on this process of the part of each node (nodes).
    integer, intent(in) :: root(:)
    integer, intent(out) :: name(:)
    real(wp) :: of_owner(1, size(root))
    integer :: n, lowest(size(root))
    logical :: lower(size(root))

    do n = 1, size(root)
      name(n) = n
      if (model%analysis%mesh%kind == mesh_grid) name(n) = node_label(model%space, model%mesh, n)
    end do
    do
      lowest = huge(lowest)
      do n = 1, size(root)
        lowest(root(n)) = min(lowest(root(n)), name(n))
      end do
      name = lowest(root)
      if (.not. is_divided(model%part)) return
      of_owner(1, :) = real(name, wp)
      call copy_values(model%part%team, model%part%node_copies, of_owner)
      lower = of_owner(1, :) > 0.0_wp .and. nint(of_owner(1, :)) < name
      if (.not. any_of(model%part%team, any(lower))) return
      where (lower) name = nint(of_owner(1, :))
    end do
  end subroutine name_pieces

  !> Lists the parts that have material points, by their labels.
  subroutine list_pieces(model, of_point, pieces)
    type(model_type), intent(in) :: model
    !> Label of the part of each point (points).
    integer, intent(in) :: of_point(:)
    type(piece_type), allocatable, intent(out) :: pieces(:)
    integer, allocatable :: names(:), first(:)
    integer(long), allocatable :: all_names(:)
    integer :: r

    allocate (names, source=different(pack(of_point, own_of(model%part%points, size(of_point)) .and. of_point > 0)))
    associate (team => model%part%team)
      ! The same data are sent to every process.
      call hand_over(team, [(int(names, long), r=1, team%ranks)], [(1 + size(names)*r, r=0, team%ranks)], all_names, &
        first)
    end associate
    associate (of_all => different(int(all_names)))
      allocate (pieces(size(of_all)))
      pieces%name = of_all
    end associate
  end subroutine list_pieces

  !> Returns the distinct values of some numbers in ascending order.
  pure function different(numbers) result(sorted)
    integer, intent(in) :: numbers(:)
    integer, allocatable :: sorted(:)
    integer :: order(size(numbers))

    call order_columns(reshape(numbers, [1, size(numbers)]), order)
    sorted = numbers(order)
    sorted = [pack(sorted(:size(order) - 1), sorted(:size(order) - 1) /= sorted(2:)), sorted(max(1, size(order)):)]
  end function different

  !> Computes the number of points, the first point and the bounding box of each part, over all processes.
  subroutine measure_pieces(model, of_point, pieces)
    type(model_type), intent(in) :: model
    integer, intent(in) :: of_point(:)
    type(piece_type), intent(inout) :: pieces(:)
    real(wp) :: least(7, size(pieces)), place(3)
    integer(long) :: held(size(pieces)), before(size(pieces)), number(size(of_point))
    integer :: names(size(pieces)), p, k
    logical :: own(size(of_point))

    names = pieces%name
    own = own_of(model%part%points, size(of_point))
    number = [(int(p, long), p=1, size(number))]
    if (is_divided(model%part)) number = model%state%points%number
    held = 0
    least = huge(least)
    associate (points => model%state%points, team => model%part%team)
      do p = 1, size(of_point)
        k = place_in_order(names, of_point(p))
        if (k == 0 .or. .not. own(p)) cycle
        held(k) = held(k) + 1
        place = place_of(points, p)
        least(:, k) = min(least(:, k), [place, -place, real(number(p), wp)])
      end do
      pieces%points = int(total(team, held))
      least = reshape(smallest(team, reshape(least, [size(least)])), shape(least))
      before = [(count(own .and. number < nint(least(7, k), long), kind=long), k=1, size(pieces))]
      pieces%first = int(total(team, before)) + 1
    end associate
    do k = 1, size(pieces)
      pieces(k)%low = least(:3, k)
      pieces(k)%high = -least(4:6, k)
    end do
  end subroutine measure_pieces

  !> Finds the supported parts.
  subroutine find_held(model, step, of_node, pieces)
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    !> Label of the part of each node (nodes).
    integer, intent(in) :: of_node(:)
    type(piece_type), intent(inout) :: pieces(:)
    real(wp), allocatable :: matrix(:, :, :)
    real(wp) :: motion(most_motions), centre(model%mesh%dimension), size_of_mesh
    integer(long) :: holds(size(pieces))
    logical :: anchored(size(of_node)), own(size(of_node))
    integer :: names(size(pieces)), n, j, k, m, motions

    motions = merge(3, most_motions, model%mesh%dimension == 2)
    if (step%at_points%axisymmetric) motions = 1
    call measure_mesh(model, centre, size_of_mesh)
    allocate (matrix(motions, motions, size(pieces)), source=0.0_wp)
    ! A term that supports the body against the ground supports its part; the direction is not checked.
    anchored = .false.
    do j = 1, size(step%terms)
      associate (term => step%terms(j)%term)
        if (term%anchors .and. term%connectivity%count > 0) &
          anchored(pack(term%connectivity%nodes, term%connectivity%nodes <= size(anchored))) = .true.
      end associate
    end do
    holds = 0
    own = own_of(model%part%nodes, size(of_node))
    names = pieces%name
    do n = 1, size(of_node)
      k = place_in_order(names, of_node(n))
      if (k == 0) cycle
      if (anchored(n)) holds(k) = 1
      if (.not. own(n)) cycle
      do j = 1, model%mesh%dimension
        if (.not. model%loading%constrained(j, n)) cycle
        call rigid_motions((node_position(model%space, model%mesh, n) - centre)/size_of_mesh, j, motions, motion)
        do m = 1, motions
          matrix(:, m, k) = matrix(:, m, k) + motion(m)*motion(:motions)
        end do
      end do
    end do
    holds = total(model%part%team, holds)
    matrix = reshape(total(model%part%team, reshape(matrix, [size(matrix)])), shape(matrix))
    do k = 1, size(pieces)
      pieces(k)%held = holds(k) > 0 .or. has_full_rank(matrix(:, :, k))
    end do
  end subroutine find_held

  !> Computes centre and size of the mesh of all processes.
  subroutine measure_mesh(model, centre, size_of_mesh)
    type(model_type), intent(in) :: model
    real(wp), intent(out) :: centre(:), size_of_mesh
    real(wp) :: ends(2*size(centre))

    associate (coordinates => model%mesh%coordinates, d => size(centre))
      ends = smallest(model%part%team, [minval(coordinates, dim=2), -maxval(coordinates, dim=2)])
      centre = 0.5_wp*(ends(:d) - ends(d + 1:))
      size_of_mesh = maxval(-ends(d + 1:) - ends(:d))
    end associate
  end subroutine measure_mesh

  !> Computes a component of the rigid motions at a place.
  pure subroutine rigid_motions(x, j, motions, motion)
    !> The place (dimension).
    real(wp), intent(in) :: x(:)
    !> The component.
    integer, intent(in) :: j
    !> Number of motions: 1 along the axis of symmetry, 3 in the plane, 6 in space.
    integer, intent(in) :: motions
    !> Their components (motions and more).
    real(wp), intent(out) :: motion(:)

    motion = 0.0_wp
    if (motions == 1) then
      if (j == 2) motion(1) = 1.0_wp
    else if (motions == 3) then
      motion(j) = 1.0_wp
      motion(3) = merge(-x(2), x(1), j == 1)
    else
      motion(j) = 1.0_wp
      motion(4 + mod(j, 3)) = -x(1 + mod(j + 1, 3))
      motion(4 + mod(j + 1, 3)) = x(1 + mod(j, 3))
    end if
  end subroutine rigid_motions

  !> Returns whether a symmetric positive semidefinite matrix has full rank.
  pure logical function has_full_rank(given) result(full)
    !> The matrix (n, n).
    real(wp), intent(in) :: given(:, :)
    real(wp) :: matrix(size(given, 1), size(given, 1)), least
    integer :: i, j

    matrix = given
    least = 0.0_wp
    do i = 1, size(matrix, 1)
      least = least + least_pivot*matrix(i, i)
    end do
    full = .true.
    do i = 1, size(matrix, 1)
      full = full .and. matrix(i, i) > least
      if (.not. full) return
      do j = i + 1, size(matrix, 1)
        matrix(:, j) = matrix(:, j) - matrix(:, i)*(matrix(i, j)/matrix(i, i))
      end do
    end do
  end function has_full_rank

  !> Finds the label of the part of each material point.
  pure subroutine find_pieces(at_points, name, piece)
    !> Material points in groups.
    type(integration_type), intent(in) :: at_points
    !> Label of the part of each node (nodes).
    integer, intent(in) :: name(:)
    !> (points)
    integer, intent(out) :: piece(:)
    integer :: g, q

    piece = 0
    do g = 1, at_points%group_count
      do q = at_points%first(g), at_points%first(g + 1) - 1
        piece(at_points%source(q)) = name(at_points%nodes(at_points%node_first(g)))
      end do
    end do
  end subroutine find_pieces

  !> Returns the description of one part.
  function piece_text(piece, d) result(text)
    type(piece_type), intent(in) :: piece
    !> Number of coordinates of a place.
    integer, intent(in) :: d
    character(len=:), allocatable :: text
    character(len=120) :: box

    if (piece%points == 1) then
      write (box, '(a,3(1x,es11.4))') ' at', piece%low(:d)
      text = 'material point '//integer_text(piece%first)//trim(box)//' is not supported by any constraint'
      return
    end if
    text = 'a piece of '//integer_text(piece%points)//' material points, '//integer_text(piece%first)// &
      ' among them, between'
    write (box, '(3(1x,es11.4))') piece%low(:d)
    text = text//trim(box)//' and'
    write (box, '(3(1x,es11.4))') piece%high(:d)
    text = text//trim(box)//' is not supported by any constraint'
  end function piece_text
end module qsmpm_unsupported_parts
