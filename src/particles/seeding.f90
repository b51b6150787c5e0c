!> Seeding bodies with material points, element by element (paper, section 3.1).
!>
!> A cell wholly inside a body gets the pattern of its element. A cell that the body's boundary cuts
!> gets the points of the pattern that lie inside, their volumes scaled so that together they hold
!> exactly the body's part of the cell; a sliver that catches none gets one point at its centroid.
!> The part is exact for straight-sided plane cells and for prisms and bricks that stand along z;
!> for other 3D cells it is counted on a fine subdivision.
module qsmpm_seeding
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: corner_count, full_rule, seed_rule, shape_functions
  use qsmpm_mesh, only: mesh_type
  use qsmpm_cell_measure, only: measure_at
  use qsmpm_polygon, only: polygon_area, polygon_centroid, polygon_contains, clip_by_convex
  use qsmpm_mesh_search, only: inverse_map
  use qsmpm_mesh_measure, only: interpolate
  use qsmpm_error, only: error_type, fail, error_deck
  implicit none
  private

  public :: body_shape_type, seed_list_type, seed_body, add_seed

  !> What bounds a body.
  type :: body_shape_type
    !> Vertices of the outline in the x-y plane, counter-clockwise (2,n); unallocated: no outline.
    real(wp), allocatable :: outline(:, :)
    !> Limits along z.
    real(wp) :: low = -huge(1.0_wp), high = huge(1.0_wp)
    !> Cells the body may occupy (cell_count); unallocated: all.
    logical, allocatable :: region(:)
  end type body_shape_type

  !> Growing list of seeds.
  type :: seed_list_type
    integer :: count = 0
    integer, allocatable :: cell(:), body(:)
    real(wp), allocatable :: local(:, :), volume(:)
  end type seed_list_type

  !> Parts of a cell below and above which it counts as empty and whole.
  real(wp), parameter :: nothing = 1.0e-9_wp, everything = 1.0_wp - 1.0e-9_wp

contains

  !> Add the points of one body.
  subroutine seed_body(mesh, axisymmetric, shape, body, points_per_element, gauss, list, error)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Volumes and areas per radian.
    logical, intent(in) :: axisymmetric
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    !> Number of the body.
    integer, intent(in) :: body
    !> 0 asks for the element's default.
    integer, intent(in) :: points_per_element
    !> Seed the Gauss rule of a full cell instead (FEM).
    logical, intent(in) :: gauss
    !> The seeds.
    type(seed_list_type), intent(inout) :: list
    !> A number of points the element does not know.
    type(error_type), allocatable, intent(out) :: error
    real(wp), allocatable :: places(:, :), weights(:)
    real(wp) :: share, centre(3)
    integer :: c, kind

    kind = 0
    do c = 1, mesh%cell_count
      if (allocated(shape%region)) then
        if (.not. shape%region(c)) cycle
      end if
      call occupied_share(mesh, shape, c, share, centre)
      if (share <= nothing) cycle
      if (mesh%cell_kind(c) /= kind) then
        kind = mesh%cell_kind(c)
        if (gauss .and. points_per_element == 0) then
          call full_rule(kind, places, weights)
        else
          call seed_rule(kind, points_per_element, places, weights, error)
          if (allocated(error)) return
        end if
      end if
      if (share >= everything) then
        call seed_cell(mesh, axisymmetric, c, body, places, weights, list)
      else if (gauss) then
        call fail(error, error_deck, 'BASIS=FEM needs a body that ends on mesh lines, '// &
          'but its boundary cuts through an element')
        return
      else
        call seed_cut_cell(mesh, axisymmetric, shape, c, body, share, centre, places, weights, list)
      end if
    end do
  end subroutine seed_body

  !> The whole pattern.
  subroutine seed_cell(mesh, axisymmetric, cell, body, places, weights, list)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Volumes and areas per radian.
    logical, intent(in) :: axisymmetric
    integer, intent(in) :: cell, body
    !> Local coordinates and weights of the pattern.
    real(wp), intent(in) :: places(:, :), weights(:)
    !> The seeds.
    type(seed_list_type), intent(inout) :: list
    integer :: k

    do k = 1, size(weights)
      call add_seed(list, cell, body, places(:, k), &
        weights(k)*measure_at(mesh, axisymmetric, cell, places(:, k)))
    end do
  end subroutine seed_cell

  !> The points of the pattern inside the body, with the body's share of the cell's volume.
  subroutine seed_cut_cell(mesh, axisymmetric, shape, cell, body, share, centre, places, weights, list)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Volumes and areas per radian.
    logical, intent(in) :: axisymmetric
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    integer, intent(in) :: cell, body
    !> Share of the cell, and centroid of the occupied part.
    real(wp), intent(in) :: share, centre(3)
    !> Local coordinates of the pattern (dimension, n).
    real(wp), intent(in) :: places(:, :), weights(:)
    !> The seeds.
    type(seed_list_type), intent(inout) :: list
    real(wp) :: volume(size(weights)), local(size(places, 1))
    logical :: inside(size(weights)), ok
    integer :: k

    do k = 1, size(weights)
      volume(k) = weights(k)*measure_at(mesh, axisymmetric, cell, places(:, k))
      inside(k) = contains_place(mesh, shape, cell, places(:, k))
    end do
    if (any(inside)) then
      do k = 1, size(weights)
        if (inside(k)) call add_seed(list, cell, body, places(:, k), &
          volume(k)*share*sum(volume)/sum(volume, mask=inside))
      end do
    else
      call inverse_map(mesh, cell, centre(:mesh%dimension), local, ok)
      if (ok) call add_seed(list, cell, body, local, share*sum(volume))
    end if
  end subroutine seed_cut_cell

  !> True when a place of a cell lies inside the body.
  pure function contains_place(mesh, shape, cell, local) result(inside)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Local coordinates (dimension).
    real(wp), intent(in) :: local(:)
    logical :: inside
    real(wp) :: x(3), functions(20)
    integer :: n

    n = mesh%cell_first(cell + 1) - mesh%cell_first(cell)
    call shape_functions(mesh%cell_kind(cell), local, functions(:n))
    x = 0.0_wp
    x(:mesh%dimension) = interpolate(mesh, cell, functions(:n), mesh%coordinates)
    inside = .true.
    if (allocated(shape%outline)) inside = polygon_contains(shape%outline, x(:2))
    if (mesh%dimension == 3) inside = inside .and. x(3) >= shape%low .and. x(3) <= shape%high
  end function contains_place

  !> Share of a cell that a body occupies, and the centroid of that part.
  subroutine occupied_share(mesh, shape, cell, share, centre)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    !> Number of the cell.
    integer, intent(in) :: cell
    real(wp), intent(out) :: share, centre(3)
    real(wp), allocatable :: base(:, :)
    real(wp) :: low, high
    logical :: upright

    share = 1.0_wp
    centre = 0.0_wp
    if (.not. allocated(shape%outline) .and. shape%high >= huge(1.0_wp) &
      .and. shape%low <= -huge(1.0_wp)) return
    call upright_prism(mesh, cell, base, low, high, upright)
    if (upright) then
      call share_of_prism(shape, base, low, high, share, centre)
    else
      call share_by_counting(mesh, shape, cell, share, centre)
    end if
  end subroutine occupied_share

  !> Corners of a plane cell, or the base and height of a prism or brick standing along z.
  subroutine upright_prism(mesh, cell, base, low, high, upright)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Base corners (2,n).
    real(wp), allocatable, intent(out) :: base(:, :)
    real(wp), intent(out) :: low, high
    logical, intent(out) :: upright
    real(wp), allocatable :: x(:, :)
    real(wp) :: tolerance
    integer :: n, half

    n = corner_count(mesh%cell_kind(cell))
    allocate (x(mesh%dimension, n))
    x = mesh%coordinates(:, mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell) + n - 1))
    low = 0.0_wp
    high = 0.0_wp
    upright = mesh%dimension == 2
    if (upright) then
      allocate (base, source=x)
      return
    end if
    if (n == 4) return
    half = n/2
    allocate (base, source=x(:2, :half))
    low = minval(x(3, :))
    high = maxval(x(3, :))
    tolerance = 1.0e-9_wp*(maxval(abs(x)) + high - low)
    upright = maxval(abs(x(:2, half + 1:) - base)) <= tolerance &
      .and. maxval(abs(x(3, :half) - x(3, 1))) <= tolerance &
      .and. maxval(abs(x(3, half + 1:) - x(3, half + 1))) <= tolerance
    if (polygon_area(base) < 0.0_wp) base = base(:, half:1:-1)
  end subroutine upright_prism

  !> Exact share of a plane cell or an upright prism.
  subroutine share_of_prism(shape, base, low, high, share, centre)
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    real(wp), intent(in) :: base(:, :), low, high
    real(wp), intent(out) :: share, centre(3)
    real(wp), allocatable :: clipped(:, :)

    share = 1.0_wp
    centre(:2) = polygon_centroid(base)
    centre(3) = 0.5_wp*(max(low, shape%low) + min(high, shape%high))
    if (allocated(shape%outline)) then
      call clip_by_convex(shape%outline, base, clipped)
      share = 0.0_wp
      if (size(clipped, 2) > 2) then
        share = polygon_area(clipped)/polygon_area(base)
        centre(:2) = polygon_centroid(clipped)
      end if
    end if
    if (high > low) share = share*max(0.0_wp, min(high, shape%high) - max(low, shape%low))/(high - low)
  end subroutine share_of_prism

  !> Share of any other cell, counted at the points of a rule repeated in the cell.
  subroutine share_by_counting(mesh, shape, cell, share, centre)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    !> Number of the cell.
    integer, intent(in) :: cell
    real(wp), intent(out) :: share, centre(3)
    integer, parameter :: slices = 12
    real(wp) :: local(3), volume, total, x(3), functions(20)
    integer :: i, j, k, n

    share = 0.0_wp
    total = 0.0_wp
    centre = 0.0_wp
    n = mesh%cell_first(cell + 1) - mesh%cell_first(cell)
    do k = 1, slices
      do j = 1, slices
        do i = 1, slices
          local = ([i, j, k] - 0.5_wp)/slices
          if (corner_count(mesh%cell_kind(cell)) == 4 .and. sum(local) > 1.0_wp) cycle
          if (corner_count(mesh%cell_kind(cell)) == 6 .and. sum(local(:2)) > 1.0_wp) cycle
          if (corner_count(mesh%cell_kind(cell)) == 8) local = 2.0_wp*local - 1.0_wp
          if (corner_count(mesh%cell_kind(cell)) == 6) local(3) = 2.0_wp*local(3) - 1.0_wp
          volume = measure_at(mesh, .false., cell, local)
          total = total + volume
          if (.not. contains_place(mesh, shape, cell, local)) cycle
          share = share + volume
          call shape_functions(mesh%cell_kind(cell), local, functions(:n))
          x = interpolate(mesh, cell, functions(:n), mesh%coordinates)
          centre = centre + volume*x
        end do
      end do
    end do
    if (share > 0.0_wp) centre = centre/share
    share = share/total
  end subroutine share_by_counting

  !> Append one seed.
  pure subroutine add_seed(list, cell, body, local, volume)
    !> The seeds.
    type(seed_list_type), intent(inout) :: list
    integer, intent(in) :: cell, body
    real(wp), intent(in) :: local(:), volume
    type(seed_list_type) :: longer
    integer :: room

    room = 0
    if (allocated(list%cell)) room = size(list%cell)
    if (list%count == room) then
      longer%count = list%count
      room = max(256, 2*room)
      allocate (longer%cell(room), longer%body(room), longer%local(size(local), room), longer%volume(room))
      if (list%count > 0) then
        longer%cell(:list%count) = list%cell
        longer%body(:list%count) = list%body
        longer%local(:, :list%count) = list%local
        longer%volume(:list%count) = list%volume
      end if
      call move_alloc(longer%cell, list%cell)
      call move_alloc(longer%body, list%body)
      call move_alloc(longer%local, list%local)
      call move_alloc(longer%volume, list%volume)
    end if
    list%count = list%count + 1
    list%cell(list%count) = cell
    list%body(list%count) = body
    list%local(:, list%count) = local
    list%volume(list%count) = volume
  end subroutine add_seed
end module qsmpm_seeding
