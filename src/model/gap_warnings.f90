!> Gaps between bodies, or within one, that a grid cannot part: functions of the cells on either side reach across, so
!> that the grid carries forces from side to side as if they touched. Triangles that fit the scene part them.
module qsmpm_gap_warnings
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_basis_traits, only: grid_degree
  use qsmpm_layer_interfaces, only: corners
  use qsmpm_mesh_description, only: mesh_grid
  use qsmpm_method_description, only: basis_fem
  use qsmpm_body_description, only: body_box, body_polygon
  use qsmpm_polygon, only: polygon_area
  use qsmpm_rounded_text, only: rounded_text
  implicit none
  private

  public :: gap_notes

  !> An edge of a body of soil, with the soil on its left.
  type :: edge_type
    integer :: body = 0
    real(wp) :: from(2) = 0.0_wp, to(2) = 0.0_wp
  end type edge_type

  !> Places along an edge, of which these are opposite to another edge where there is a gap; and the share of a cell
  !> that is none: bodies drawn by hand miss one another by a hair.
  integer, parameter :: places = 9, most = 3
  real(wp), parameter :: hair = 0.05_wp

contains

  !> Sentences for the log.
  pure function gap_notes(analysis) result(notes)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: notes
    type(edge_type), allocatable :: edges(:)
    logical, allocatable :: is_said(:, :)
    real(wp) :: width, reach
    integer :: i, k, other, opposite(places)

    notes = ''
    if (analysis%mesh%kind /= mesh_grid .or. analysis%method%basis == basis_fem) return
    if (analysis%model == three_dimensional .or. .not. allocated(analysis%bodies)) return
    call list_edges(analysis, edges)
    allocate (is_said(size(analysis%bodies), size(analysis%bodies)), source=.false.)
    do i = 1, size(edges)
      reach = cells_across(analysis, edges(i))*max(1, grid_degree(analysis%method%basis))
      do k = 1, places
        call look_across(edges, i, real(k, wp)/(places + 1), reach, opposite(k), width)
      end do
      do k = 1, places
        other = opposite(k)
        if (other == 0 .or. count(opposite == other) < most) cycle
        if (is_said(edges(i)%body, other) .or. is_said(other, edges(i)%body)) cycle
        is_said(edges(i)%body, other) = .true.
        call look_across(edges, i, real(k, wp)/(places + 1), reach, other, width)
        notes = notes//sentence(analysis, edges(i)%body, other, width)
      end do
    end do
  end function gap_notes

  !> What is said of a gap.
  pure function sentence(analysis, one, other, width) result(text)
    type(analysis_type), intent(in) :: analysis
    !> The bodies, and the width of the gap.
    integer, intent(in) :: one, other
    real(wp), intent(in) :: width
    character(len=:), allocatable :: text

    associate (bodies => analysis%bodies)
      text = "bodies '"//bodies(one)%name//"' and '"//bodies(other)%name//"' are "//rounded_text(width)//' apart'
      if (one == other) text = "body '"//bodies(one)%name//"' has a gap of "//rounded_text(width)
    end associate
    text = 'warning: '//text//', too little for this grid: it carries forces across as if there were none; '// &
      'draw none, take smaller cells, or a *GRID that names no ELEMENT, whose triangles fit it'//new_line('a')
  end function sentence

  !> Edges of all boxes and polygons, those of bodies that come later too.
  pure subroutine list_edges(analysis, edges)
    type(analysis_type), intent(in) :: analysis
    type(edge_type), allocatable, intent(out) :: edges(:)
    real(wp), allocatable :: at(:, :)
    integer :: b, i, n

    allocate (edges(0))
    do b = 1, size(analysis%bodies)
      if (all(analysis%bodies(b)%kind /= [body_box, body_polygon])) cycle
      at = corners(analysis%bodies(b))
      n = size(at, 2)
      if (polygon_area(at) < 0.0_wp) at = at(:, n:1:-1)
      do i = 1, n
        edges = [edges, edge_type(b, at(:, i), at(:, modulo(i, n) + 1))]
      end do
    end do
  end subroutine list_edges

  !> Size of the cells along the normal of an edge, those of the grid's lines next to its middle.
  pure real(wp) function cells_across(analysis, edge) result(cell)
    type(analysis_type), intent(in) :: analysis
    type(edge_type), intent(in) :: edge
    real(wp) :: width(2), along(2), middle(2)
    integer :: d, k

    along = abs(edge%to - edge%from)/max(norm2(edge%to - edge%from), tiny(1.0_wp))
    middle = 0.5_wp*(edge%from + edge%to)
    do d = 1, 2
      associate (lines => analysis%mesh%axes(d)%lines)
        k = min(max(count(lines <= middle(d)), 1), size(lines) - 1)
        width(d) = lines(k + 1) - lines(k)
      end associate
    end do
    cell = dot_product(along([2, 1]), width)
  end function cells_across

  !> The body that a ray meets which leaves an edge outwards, 0 where none is within reach or they touch.
  pure subroutine look_across(edges, number, share, reach, body, width)
    type(edge_type), intent(in) :: edges(:)
    !> Edge, and place on it as a share of its length.
    integer, intent(in) :: number
    real(wp), intent(in) :: share, reach
    integer, intent(out) :: body
    !> The way to it.
    real(wp), intent(out) :: width
    real(wp) :: from(2), out(2), along(2), facing, t, s
    integer :: i

    body = 0
    width = reach
    associate (edge => edges(number))
      along = edge%to - edge%from
      if (.not. norm2(along) > 0.0_wp) return
      out = [along(2), -along(1)]/norm2(along)
      from = edge%from + share*along
    end associate
    do i = 1, size(edges)
      along = edges(i)%to - edges(i)%from
      facing = along(1)*out(2) - along(2)*out(1)
      if (i == number .or. .not. abs(facing) > 0.5_wp*norm2(along)) cycle
      ! from + t out = its start + s along
      associate (way => edges(i)%from - from)
        t = (along(1)*way(2) - along(2)*way(1))/facing
        s = (out(1)*way(2) - out(2)*way(1))/facing
      end associate
      if (s < 0.0_wp .or. s > 1.0_wp .or. t < -hair*reach .or. .not. t < width) cycle
      width = t
      body = merge(edges(i)%body, 0, facing > 0.0_wp .and. t > hair*reach)
    end do
  end subroutine look_across
end module qsmpm_gap_warnings
