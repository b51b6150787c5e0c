!> Growing list of the pieces of a body in the sub-cells of a cell, and merging of small pieces.
!>
!> The module also determines the material points of a piece, and the boxes that they represent.
!>
!> One point preserves the first moment of a piece; four (in 3D four or eight) also preserve its second moments.
module qsmpm_piece_list
  use qsmpm_kinds, only: wp, pi
  use qsmpm_element, only: local_centre, inside_distance, max_faces
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_search, only: inverse_map
  use qsmpm_seed_pattern, only: pattern_type
  use qsmpm_tensor, only: cross
  implicit none
  private

  public :: piece_type, piece_list_type, add_piece, merge_small_pieces, points_of_piece, find_inside, half_of_box

  !> A piece.
  type :: piece_type
    !> Area in 2D, volume in 3D.
    real(wp) :: measure
    !> Centroid and extents along the axes; the third is 0 in 2D.
    real(wp) :: centroid(3), extent(3)
    !> Mean of (x - c)(x - c)' over the piece, c its centroid.
    real(wp) :: second(3, 3)
    !> Position of the sub-cell, from 1 to n.
    integer :: place(3)
  end type piece_type

  !> Pieces; the first `count` are used.
  type :: piece_list_type
    integer :: count = 0
    type(piece_type), allocatable :: items(:)
  end type piece_list_type

  !> Tolerances: deviation of a piece from the box of its extents, and of a root from zero.
  real(wp), parameter :: nothing = 1.0e-9_wp, rounding = 1.0e-12_wp
  !> Points of a piece outside its cell: largest number of rotations, then of contractions, and factor of a contraction.
  integer, parameter :: most_turns = 200, most_drawn = 20
  real(wp), parameter :: drawn_together = 0.8_wp

contains

  !> Appends a piece.
  pure subroutine add_piece(list, piece)
    type(piece_list_type), intent(inout) :: list
    type(piece_type), intent(in) :: piece

    if (.not. allocated(list%items)) allocate (list%items(64))
    if (list%count == size(list%items)) list%items = [list%items, list%items]
    list%count = list%count + 1
    list%items(list%count) = piece
  end subroutine add_piece

  !> Merges every piece below a measure into the largest piece near it; volume, first and second moment are preserved.
  pure subroutine merge_small_pieces(pieces, smallest)
    !> The pieces; the last one is kept even if it is small.
    type(piece_list_type), intent(inout) :: pieces
    !> Smallest measure of a separate piece.
    real(wp), intent(in) :: smallest
    integer :: i, k, n, target
    logical :: near, best_near

    do while (pieces%count > 1)
      n = pieces%count
      i = minloc(pieces%items(:n)%measure, dim=1)
      if (pieces%items(i)%measure >= smallest) return
      target = 0
      best_near = .false.
      do k = 1, n
        if (k == i) cycle
        near = all(abs(pieces%items(k)%place - pieces%items(i)%place) <= 1)
        if (target > 0) then
          if (best_near .and. .not. near) cycle
          if ((best_near .eqv. near) .and. pieces%items(k)%measure <= pieces%items(target)%measure) cycle
        end if
        target = k
        best_near = near
      end do
      call merge_into(pieces%items(i), pieces%items(target))
      pieces%items(i:n - 1) = pieces%items(i + 1:n)
      pieces%count = n - 1
    end do
  end subroutine merge_small_pieces

  !> Merges a piece into another.
  pure subroutine merge_into(piece, target)
    type(piece_type), intent(in) :: piece
    type(piece_type), intent(inout) :: target
    real(wp) :: total, part, apart(3)
    integer :: k

    total = piece%measure + target%measure
    if (total > 0.0_wp) then
      part = piece%measure/total
      apart = piece%centroid - target%centroid
      do k = 1, 3
        target%second(:, k) = part*piece%second(:, k) + (1.0_wp - part)*target%second(:, k) &
          + part*(1.0_wp - part)*apart*apart(k)
      end do
      target%centroid = target%centroid + part*apart
    end if
    target%measure = total
  end subroutine merge_into

  !> Returns the points of a piece. A single point is at the centroid, with a box of the proportions and the measure of
  !> the piece. Several points preserve its first and second moments: c + L s with L L' the mean of (x - c)(x - c)', s
  !> the corners of a square, a tetrahedron or a cube, with mean s s' = 1. In a convex plane piece they are inside,
  !> because it contains the ellipse |L^-1 (x - c)| = sqrt 2 (Kannan, Lovasz and Simonovits 1995); otherwise they are
  !> rotated until they are in the cell.
  pure subroutine points_of_piece(mesh, cell, piece, pattern, d, x, half)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    type(piece_type), intent(in) :: piece
    type(pattern_type), intent(in) :: pattern
    !> 2 for a plane piece, 3.
    integer, intent(in) :: d
    !> Positions and half lengths of boxes (d, n).
    real(wp), allocatable, intent(out) :: x(:, :), half(:, :)
    integer, parameter :: tetrahedron(3, 4) = reshape([1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1], [3, 4])
    integer, parameter :: cube(3, 8) = reshape([-1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1, &
      -1, -1, 1, 1, -1, 1, -1, 1, 1, 1, 1, 1], [3, 8])
    real(wp) :: root(d, d), place(3), local(mesh%dimension)
    logical :: inside, all_inside
    integer :: i, n, trial, corner(3)

    n = pattern%spread
    ! A piece that fills the box of its extents.
    if (pattern%boxes_whole .and. abs(piece%measure/product(piece%extent(:d)) - 1.0_wp) <= nothing) n = 1
    allocate (x(d, n), half(d, n))
    root = root_of(piece%second(:d, :d))
    do trial = 0, most_turns + most_drawn
      if (trial > most_turns) root = drawn_together*root
      all_inside = .true.
      do i = 1, n
        corner = cube(:, i)
        if (d == 3 .and. n == 4) corner = tetrahedron(:, i)
        x(:, i) = piece%centroid(:d)
        if (n > 1) x(:, i) = x(:, i) + matmul(root, turned(real(corner(:d), wp), trial))
        place = piece%centroid
        place(:d) = x(:, i)
        call find_inside(mesh, cell, place(:mesh%dimension), local, inside)
        all_inside = all_inside .and. inside
      end do
      if (all_inside .or. n == 1) exit
    end do
    half = tiny(1.0_wp)
    if (n > 1 .and. .not. pattern%has_boxes) return
    do i = 1, n
      half(:, i) = inside_cell(mesh, cell, x(:, i), half_of_box(piece%extent(:d), piece%measure/n))
    end do
  end subroutine points_of_piece

  !> Half lengths of a box of given proportions and measure.
  pure function half_of_box(extent, measure) result(half)
    !> Lengths of a box (dimension).
    real(wp), intent(in) :: extent(:)
    !> Area in 2D, volume in 3D.
    real(wp), intent(in) :: measure
    real(wp) :: half(size(extent))

    half = 0.5_wp*extent*(measure/product(extent))**(1.0_wp/size(extent))
  end function half_of_box

  !> Half lengths shortened so that the box stays in the cell, as the piece does.
  pure function inside_cell(mesh, cell, centroid, half) result(shorter)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Centre of the box, in the cell (dimension).
    real(wp), intent(in) :: centroid(:)
    !> Half lengths (dimension).
    real(wp), intent(in) :: half(:)
    real(wp) :: shorter(size(half)), low, high
    integer :: a

    associate (nodes => mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell + 1) - 1))
      do a = 1, size(half)
        low = minval(mesh%coordinates(a, nodes))
        high = maxval(mesh%coordinates(a, nodes))
        shorter(a) = max(min(half(a), centroid(a) - low, high - centroid(a)), tiny(1.0_wp))
      end do
    end associate
  end function inside_cell

  !> Determines whether a point is in a cell, and its local coordinates.
  pure subroutine find_inside(mesh, cell, x, local, inside)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Coordinates of the point (dimension).
    real(wp), intent(in) :: x(:)
    !> Local coordinates (dimension).
    real(wp), intent(out) :: local(:)
    logical, intent(out) :: inside
    real(wp) :: distance(max_faces)

    distance = 0.0_wp
    call inverse_map(mesh, cell, x, local, inside)
    if (.not. inside) local = local_centre(mesh%cell_kind(cell))
    call inside_distance(mesh%cell_kind(cell), local, distance)
    inside = inside .and. all(distance >= 0.0_wp)
  end subroutine find_inside

  !> Lower triangular root of a matrix that is symmetric and, except for round-off, positive semi-definite.
  pure function root_of(matrix) result(root)
    !> (n,n)
    real(wp), intent(in) :: matrix(:, :)
    real(wp) :: root(size(matrix, 1), size(matrix, 1))
    integer :: i, j

    root = 0.0_wp
    do j = 1, size(matrix, 1)
      root(j, j) = sqrt(max(matrix(j, j) - dot_product(root(j, :j - 1), root(j, :j - 1)), 0.0_wp))
      if (root(j, j) <= rounding*sqrt(max(matrix(j, j), 0.0_wp))) cycle
      do i = j + 1, size(matrix, 1)
        root(i, j) = (matrix(i, j) - dot_product(root(i, :j - 1), root(j, :j - 1)))/root(j, j)
      end do
    end do
  end function root_of

  !> Vector rotated by the k-th of a sequence of evenly distributed rotations (0: identity). In 3D: unit quaternions of
  !> uniform density (Shoemake 1992) at the points k (a, a^2, a^3) modulo 1, 1/a the root of x^4 = x + 1; in 2D by k a
  !> turns.
  pure function turned(vector, k)
    !> The vector (2 or 3).
    real(wp), intent(in) :: vector(:)
    !> Number of the rotation.
    integer, intent(in) :: k
    real(wp) :: turned(size(vector))
    real(wp), parameter :: step(3) = [0.8191725133961645_wp, 0.6710436067037893_wp, 0.5497004779019703_wp]
    real(wp) :: u(3), axis(3), scalar

    turned = vector
    if (k == 0) return
    u = modulo(k*step, 1.0_wp)
    if (size(vector) == 2) then
      turned = cos(2*pi*u(1))*vector + sin(2*pi*u(1))*[-vector(2), vector(1)]
    else
      axis = [sqrt(1.0_wp - u(1))*cos(2*pi*u(2)), sqrt(u(1))*sin(2*pi*u(3)), sqrt(u(1))*cos(2*pi*u(3))]
      scalar = sqrt(1.0_wp - u(1))*sin(2*pi*u(2))
      turned = vector + 2.0_wp*cross(axis, cross(axis, vector) + scalar*vector)
    end if
  end function turned
end module qsmpm_piece_list
