!> Integration points of bodies whose outline moves with the material. They are generated in every step for the deformed
!> body as it is cut by the grid.
!>
!> The material points move and keep their volumes, so that after some time those of a cut cell no longer represent the
!> moments of the material in it. The outline defines this material. With the integration points that are generated from
!> the outline (qsmpm_outline_quadrature, in 3D qsmpm_seeding)
!>
!>   sum over points of V grad N_a  =  sum over surface points of N_a a
!>
!> holds again for every function. Each integration point takes the state of the nearest material point of its body, one
!> in its own cell if there is one. If the cell has none on this process, the state is requested from the other
!> processes of the team (qsmpm_source_sharing). docs/methods/bodies.md.
module qsmpm_body_quadrature
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_sorting, only: list_by_key
  use qsmpm_points, only: points_type, nearest_point
  use qsmpm_point_location, only: activation_type
  use qsmpm_seed_list, only: seed_list_type
  use qsmpm_domain_pieces, only: pieces_type
  use qsmpm_mesh_measure, only: place_in_cell
  implicit none
  private

  public :: body_quadrature_type, received_states_type, sort_seeds, choose_sources, nearest_in, source_material, &
    put_bodies, is_filled

  !> Rounding tolerance on the fraction of a cell that a body fills.
  real(wp), parameter :: rounding = 1.0e-9_wp

  !> Material points of other processes that provide states to integration points: materials, volumes, ratios of volume
  !> to initial volume (n), stresses (4 or 6, n) and state variables of the laws (states, n).
  type :: received_states_type
    integer, allocatable :: material(:)
    real(wp), allocatable :: volume(:), volume_ratio(:), stress(:, :), state(:, :)
  end type received_states_type

  !> Integration points sorted by cell; empty if no outline is transported.
  type :: body_quadrature_type
    !> Bodies whose outline moves with the material and bounds their points (bodies).
    logical, allocatable :: carried(:)
    !> Integration points of cell c: first(c) : first(c+1)-1 (cell_count+1).
    integer, allocatable :: first(:)
    !> Local coordinates (dimension, n), volumes, bodies, and material points that provide the state (n): a negative
    !> number refers to `received`, 0 is used in a cell too far from those of this process to matter.
    real(wp), allocatable :: local(:, :), volume(:)
    integer, allocatable :: body(:), source(:)
    type(received_states_type) :: received
    !> Half lengths of the boxes that the points represent, and ends of these boxes in the cell (dimension, n).
    real(wp), allocatable :: half(:, :), low(:, :), high(:, :)
    !> Fraction of each cell that these bodies fill (cell_count).
    real(wp), allocatable :: fill(:)
    !> Vertices of the outlines for which the points were generated (dimension, m).
    real(wp), allocatable :: vertices(:, :)
  end type body_quadrature_type

contains

  !> Sorts the seed points of bodies by cell.
  pure subroutine sort_seeds(list, volumes, carried, quadrature)
    type(seed_list_type), intent(in) :: list
    !> Volume of every cell (cell_count).
    real(wp), intent(in) :: volumes(:)
    !> Bodies whose seed points are used (bodies).
    logical, intent(in) :: carried(:)
    type(body_quadrature_type), intent(out) :: quadrature
    integer :: i, c, n, rows
    integer, allocatable :: seed(:)

    allocate (quadrature%carried, source=carried)
    call list_by_key([(merge(list%cell(i), 0, carried(list%body(i))), i=1, list%count)], size(volumes), &
      quadrature%first, seed)
    n = size(seed)
    allocate (quadrature%volume(n), quadrature%body(n))
    allocate (quadrature%source(n), source=0)
    allocate (quadrature%received%material(0), quadrature%received%volume(0), quadrature%received%volume_ratio(0), &
      quadrature%received%stress(0, 0), quadrature%received%state(0, 0))
    rows = 0
    if (n > 0) rows = size(list%local, 1)
    allocate (quadrature%local(rows, n))
    allocate (quadrature%half, quadrature%low, quadrature%high, mold=quadrature%local)
    allocate (quadrature%fill(size(volumes)), source=0.0_wp)
    do i = 1, n
      c = list%cell(seed(i))
      quadrature%local(:, i) = list%local(:, seed(i))
      quadrature%half(:, i) = list%vector(:, seed(i))
      quadrature%volume(i) = list%volume(seed(i))
      quadrature%body(i) = list%body(seed(i))
      quadrature%fill(c) = quadrature%fill(c) + list%volume(seed(i))/volumes(c)
    end do
  end subroutine sort_seeds

  !> Determines the boxes of the integration points, and the material points that provide their states.
  pure subroutine choose_sources(mesh, activation, points, in_own_cell, quadrature)
    type(mesh_type), intent(in) :: mesh
    type(activation_type), intent(in) :: activation
    type(points_type), intent(in) :: points
    !> Only points in the same cell are known.
    logical, intent(in) :: in_own_cell
    type(body_quadrature_type), intent(inout) :: quadrature
    real(wp), dimension(mesh%dimension) :: x, low, high
    integer :: c, i, k

    do c = 1, mesh%cell_count
      do i = quadrature%first(c), quadrature%first(c + 1) - 1
        x = place_in_cell(mesh, c, quadrature%local(:, i))
        associate (corners => mesh%coordinates(:, mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1)))
          low = minval(corners, dim=2)
          high = maxval(corners, dim=2)
        end associate
        quadrature%low(:, i) = max(x - quadrature%half(:, i), low)
        quadrature%high(:, i) = min(x + quadrature%half(:, i), high)
        associate (source => quadrature%source(i), body => quadrature%body(i))
          source = 0
          call nearest_in(activation, points, c, body, x, source)
          if (source > 0 .or. in_own_cell) cycle
          do k = mesh%vertex_first(c), mesh%vertex_first(c + 1) - 1
            call nearest_in(activation, points, mesh%vertex_neighbour(k), body, x, source)
          end do
          if (source == 0) source = nearest_point(points, x, body)
        end associate
      end do
    end do
  end subroutine choose_sources

  !> Replaces `nearest` by the material point of a body in a cell that is nearest to a position, if it is nearer.
  pure subroutine nearest_in(activation, points, cell, body, x, nearest)
    type(activation_type), intent(in) :: activation
    type(points_type), intent(in) :: points
    integer, intent(in) :: cell, body
    !> Position (dimension).
    real(wp), intent(in) :: x(:)
    !> 0 for none.
    integer, intent(inout) :: nearest
    integer :: g, k, p

    g = activation%active_number(cell)
    if (g == 0) return
    do k = activation%first(g), activation%first(g + 1) - 1
      p = activation%point(k)
      if (points%body(p) /= body) cycle
      if (nearest > 0) then
        if (sum((points%position(:, p) - x)**2) >= sum((points%position(:, nearest) - x)**2)) cycle
      end if
      nearest = p
    end do
  end subroutine nearest_in

  !> Material of the material point that provides the state of an integration point.
  elemental integer function source_material(quadrature, points, i) result(material)
    type(body_quadrature_type), intent(in) :: quadrature
    type(points_type), intent(in) :: points
    integer, intent(in) :: i

    if (quadrature%source(i) > 0) then
      material = points%material(quadrature%source(i))
    else
      material = quadrature%received%material(-quadrature%source(i))
    end if
  end function source_material

  !> Volume of the material point that provides the state of an integration point.
  pure real(wp) function source_volume(quadrature, points, i) result(volume)
    type(body_quadrature_type), intent(in) :: quadrature
    type(points_type), intent(in) :: points
    integer, intent(in) :: i

    if (quadrature%source(i) > 0) then
      volume = points%volume(quadrature%source(i))
    else
      volume = quadrature%received%volume(-quadrature%source(i))
    end if
  end function source_volume

  !> Replaces the material points of bodies with an outline by the integration points of these bodies. A point in a cell
  !> that contains no part of its body is not changed.
  pure subroutine put_bodies(quadrature, points, pieces)
    type(body_quadrature_type), intent(in) :: quadrature
    type(points_type), intent(in) :: points
    !> In: pieces of domains or points. Out: with the integration points of the bodies, after the other pieces of a
    !> cell.
    type(pieces_type), intent(inout) :: pieces
    type(pieces_type) :: joint
    integer :: cell(size(pieces%point) + size(quadrature%source))
    integer, allocatable :: first(:), item(:)
    integer :: before, g, n, c, i

    ! Pieces that are kept, then integration points, with their cells.
    before = size(pieces%point)
    cell = 0
    do g = 1, size(pieces%cell)
      do i = pieces%first(g), pieces%first(g + 1) - 1
        associate (p => pieces%point(i))
          if (.not. (quadrature%carried(points%body(p)) .and. quadrature%first(points%cell(p) + 1) > &
            quadrature%first(points%cell(p)))) cell(i) = pieces%cell(g)
        end associate
      end do
    end do
    do c = 1, size(quadrature%fill)
      do i = quadrature%first(c), quadrature%first(c + 1) - 1
        if (quadrature%source(i) /= 0) cell(before + i) = c
      end do
    end do
    call list_by_key(cell, size(quadrature%fill), first, item)
    joint%cell = pack([(c, c=1, size(quadrature%fill))], first(2:) > first(:size(quadrature%fill)))
    n = size(item)
    joint%first = [first(joint%cell), n + 1]
    allocate (joint%point(n), joint%share(n), joint%local(size(points%position, 1), n))
    allocate (joint%of_body(n), joint%at_place(n), source=.false.)
    allocate (joint%low(size(pieces%low, 1), merge(n, 0, size(pieces%low, 1) > 0)), source=0.0_wp)
    allocate (joint%high, source=joint%low)
    do n = 1, size(item)
      i = item(n) - before
      if (i > 0) then
        joint%point(n) = quadrature%source(i)
        joint%share(n) = quadrature%volume(i)/source_volume(quadrature, points, i)
        joint%local(:, n) = quadrature%local(:, i)
        joint%of_body(n) = .true.
        joint%at_place(n) = all(quadrature%half(:, i) <= tiny(1.0_wp))
        if (size(joint%low) > 0) joint%low(:, n) = quadrature%low(:, i)
        if (size(joint%low) > 0) joint%high(:, n) = quadrature%high(:, i)
      else
        joint%point(n) = pieces%point(item(n))
        joint%share(n) = pieces%share(item(n))
        if (size(joint%low) > 0) joint%low(:, n) = pieces%low(:, item(n))
        if (size(joint%low) > 0) joint%high(:, n) = pieces%high(:, item(n))
      end if
    end do
    pieces = joint
  end subroutine put_bodies

  !> Whether a single body fills a cell.
  pure logical function is_filled(quadrature, cell)
    type(body_quadrature_type), intent(in) :: quadrature
    integer, intent(in) :: cell

    associate (body => quadrature%body(quadrature%first(cell):quadrature%first(cell + 1) - 1))
      is_filled = size(body) > 0 .and. quadrature%fill(cell) >= 1.0_wp - rounding
      if (is_filled) is_filled = all(body == body(1))
    end associate
  end function is_filled
end module qsmpm_body_quadrature
