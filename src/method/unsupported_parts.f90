!> Pieces of the material that nothing holds: for the message of a run that finds no equilibrium.
!>
!> Two material points belong to one piece when a chain of functions joins them, each seen by both of its
!> neighbours. A piece is held when no rigid motion of it satisfies the fixities of its nodes and the surfaces that
!> are supported: the matrix sum r r' over its fixed components, r the rigid motions there, has full rank.
module qsmpm_unsupported_parts
  use qsmpm_kinds, only: wp
  use qsmpm_integration, only: integration_type
  use qsmpm_space, only: node_position
  use qsmpm_model, only: model_type
  use qsmpm_initialisation, only: step_type
  use qsmpm_grid_window, only: operator(==)
  use qsmpm_soil_points, only: soil_type, soil_of
  use qsmpm_term_sums, only: mark_anchored
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: describe_unsupported_parts

  !> Pivot, relative to the number of fixities, below which a rigid motion is free.
  real(wp), parameter :: least_pivot = 1.0e-9_wp
  !> Rigid motions in the plane and in space; in axisymmetry one.
  integer, parameter :: most_motions = 6

contains

  !> Say which pieces hang on nothing: empty when all are held.
  subroutine describe_unsupported_parts(model, step, text)
    !> The model, its state as it stands.
    type(model_type), intent(in) :: model
    !> Scratch of the step that failed.
    type(step_type), intent(in), target :: step
    !> A sentence without its end.
    character(len=:), allocatable, intent(out) :: text
    integer :: root(model%space%node_count), piece(model%state%points%count), n, number, pieces
    logical :: held(model%space%node_count)
    type(soil_type), pointer :: soil
    character(len=:), allocatable :: one

    text = ''
    if (.not. step%window == model%state%window .or. step%at_points%group_count == 0) return
    do n = 1, size(root)
      root(n) = n
    end do
    call join_groups(step%at_points, root)
    soil => soil_of(step%terms)
    if (allocated(soil%integration)) call join_groups(soil%integration, root)
    call find_held(model, step, root, held)
    call find_pieces(step%at_points, root, piece)
    pieces = 0
    do n = 1, size(root)
      if (held(n)) cycle
      number = count(piece == n)
      if (number == 0) cycle
      pieces = pieces + 1
      call piece_text(model, piece == n, one)
      if (pieces == 1) text = one
    end do
    if (pieces > 1) text = text//', one of '//integer_text(pieces)//' such pieces'
  end subroutine describe_unsupported_parts

  !> Join the nodes that the groups of points see, group by group.
  pure subroutine join_groups(integration, root)
    type(integration_type), intent(in) :: integration
    !> A node of the same piece that comes before, or the node itself (nodes).
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

  !> First node of the piece of a node.
  pure integer function first_of(root, node) result(first)
    !> A node of the same piece that comes before, or the node itself (nodes).
    integer, intent(in) :: root(:)
    integer, intent(in) :: node

    first = node
    do while (root(first) /= first)
      first = root(first)
    end do
  end function first_of

  !> Which pieces, by their first nodes, are held.
  subroutine find_held(model, step, root, held)
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    !> First node of the piece of each node (nodes).
    integer, intent(in) :: root(:)
    !> Held, at the first nodes (nodes).
    logical, intent(out) :: held(:)
    real(wp), allocatable :: matrix(:, :, :)
    real(wp) :: motion(most_motions), centre(model%mesh%dimension), size_of_mesh
    logical :: anchored(size(root))
    integer :: n, j, m, motions

    motions = merge(3, most_motions, model%mesh%dimension == 2)
    if (step%at_points%axisymmetric) motions = 1
    centre = 0.5_wp*(minval(model%mesh%coordinates, dim=2) + maxval(model%mesh%coordinates, dim=2))
    size_of_mesh = maxval(maxval(model%mesh%coordinates, dim=2) - minval(model%mesh%coordinates, dim=2))
    allocate (matrix(motions, motions, size(root)), source=0.0_wp)
    do n = 1, size(root)
      do j = 1, model%mesh%dimension
        if (.not. model%loading%constrained(j, n)) cycle
        call rigid_motions((node_position(model%space, model%mesh, n) - centre)/size_of_mesh, j, motions, motion)
        do m = 1, motions
          matrix(:, m, root(n)) = matrix(:, m, root(n)) + motion(m)*motion(:motions)
        end do
      end do
    end do
    do n = 1, size(root)
      held(n) = root(n) == n .and. has_full_rank(matrix(:, :, n))
    end do
    ! What is held against the ground holds its piece, in which way is not asked.
    anchored = .false.
    call mark_anchored(step%terms, anchored)
    do n = 1, size(root)
      if (anchored(n)) held(root(n)) = .true.
    end do
  end subroutine find_held

  !> A component of the rigid motions at a place.
  pure subroutine rigid_motions(x, j, motions, motion)
    !> The place (dimension).
    real(wp), intent(in) :: x(:)
    !> The component.
    integer, intent(in) :: j
    !> How many motions there are: 1 along the axis of symmetry, 3 in the plane, 6 in space.
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

  !> Whether a symmetric matrix of no negative eigenvalue has full rank.
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

  !> First node of the piece of each material point.
  pure subroutine find_pieces(at_points, root, piece)
    !> Material points in groups.
    type(integration_type), intent(in) :: at_points
    !> First node of the piece of each node (nodes).
    integer, intent(in) :: root(:)
    !> (points)
    integer, intent(out) :: piece(:)
    integer :: g, q

    piece = 0
    do g = 1, at_points%group_count
      do q = at_points%first(g), at_points%first(g + 1) - 1
        piece(at_points%source(q)) = root(at_points%nodes(at_points%node_first(g)))
      end do
    end do
  end subroutine find_pieces

  !> One piece in words.
  subroutine piece_text(model, member, text)
    type(model_type), intent(in) :: model
    !> The points of the piece (points).
    logical, intent(in) :: member(:)
    !> The words.
    character(len=:), allocatable, intent(out) :: text
    real(wp) :: low(3), high(3)
    character(len=120) :: box
    integer :: p, d

    d = model%mesh%dimension
    low = huge(1.0_wp)
    high = -huge(1.0_wp)
    do p = 1, size(member)
      if (.not. member(p)) cycle
      low(:d) = min(low(:d), model%state%points%position(:, p))
      high(:d) = max(high(:d), model%state%points%position(:, p))
    end do
    p = first_true(member)
    if (count(member) == 1) then
      write (box, '(a,3(1x,es11.4))') ' at', low(:d)
      text = 'material point '//integer_text(p)//trim(box)//' hangs on nothing'
      return
    end if
    text = 'a piece of '//integer_text(count(member))//' material points, '//integer_text(p)//' among them, between'
    write (box, '(3(1x,es11.4))') low(:d)
    text = text//trim(box)//' and'
    write (box, '(3(1x,es11.4))') high(:d)
    text = text//trim(box)//' hangs on nothing that holds it'
  end subroutine piece_text

  !> First of the places that are true.
  pure integer function first_true(member) result(place)
    !> Some are true.
    logical, intent(in) :: member(:)

    do place = 1, size(member)
      if (member(place)) return
    end do
  end function first_true
end module qsmpm_unsupported_parts
