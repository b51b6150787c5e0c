!> Pieces of the domains of the material points, cell by cell.
!>
!> A domain that extends over several cells is cut along the grid lines; each piece has its share of the volume of the
!> point. So a cell contains the material that is really in it, independent of the cell that owns the point: the cells
!> of CELL integration that are not integrated by a Gauss rule are integrated over these pieces. Without domains a point
!> is one piece, in the cell that owns it. In axisymmetry shares are those of rings.
module qsmpm_domain_pieces
  use qsmpm_kinds, only: wp
  use qsmpm_point_location, only: activation_type
  use qsmpm_grid_window, only: place_of
  use qsmpm_space, only: space_type
  use qsmpm_spatial_lists, only: list_by_box
  use qsmpm_spline_axis, only: interval_cells
  use qsmpm_domains, only: domains_type, cells_of
  use qsmpm_mesh, only: mesh_type
  implicit none
  private

  public :: pieces_type, cut_domains, whole_points

  !> Pieces sorted by cell, and within a cell by point.
  type :: pieces_type
    !> Cells that contain pieces, ascending; the pieces of cell(g) are first(g) : first(g+1)-1.
    integer, allocatable :: cell(:), first(:)
    !> Material point of each piece, negative for a point of another process (qsmpm_body_quadrature), and share of its
    !> volume (n).
    integer, allocatable :: point(:)
    real(wp), allocatable :: share(:)
    !> Lower and upper ends of the pieces (dimension, n); empty if points are not cut.
    real(wp), allocatable :: low(:, :), high(:, :)
    !> Marks of the integration points of bodies with an outline, and of those among them without a box (n); their local
    !> coordinates in the cell (dimension, n). Not allocated if all pieces are those of domains or of points.
    logical, allocatable :: of_body(:), at_place(:)
    real(wp), allocatable :: local(:, :)
  end type pieces_type

contains

  !> Returns every point as one piece in its owner cell.
  pure subroutine whole_points(activation, pieces)
    type(activation_type), intent(in) :: activation
    type(pieces_type), intent(out) :: pieces

    allocate (pieces%cell, source=activation%active_cell(:activation%active_count))
    allocate (pieces%first, source=activation%first(:activation%active_count + 1))
    allocate (pieces%point, source=activation%point)
    allocate (pieces%share(size(pieces%point)), source=1.0_wp)
    allocate (pieces%low(0, 0), pieces%high(0, 0))
  end subroutine whole_points

  !> Cuts the domains along the grid lines.
  pure subroutine cut_domains(space, mesh, domains, pieces)
    !> Space of displacements, whose axes store the grid lines.
    type(space_type), intent(in) :: space
    type(mesh_type), intent(in) :: mesh
    type(domains_type), intent(in) :: domains
    type(pieces_type), intent(out) :: pieces
    integer, dimension(3, size(domains%low, 2)) :: from, to
    integer, allocatable :: first(:)
    integer :: p, c, g, n

    do p = 1, size(from, 2)
      call cells_of(space, domains, p, from(:, p), to(:, p))
    end do
    call list_by_box(from, to, space%axis%cell_count, first, pieces%point)
    pieces%cell = pack([(c, c=1, mesh%cell_count)], first(2:) > first(:mesh%cell_count))
    pieces%first = [first(pieces%cell), size(pieces%point) + 1]
    n = size(pieces%point)
    allocate (pieces%share(n), pieces%low(size(domains%low, 1), n), pieces%high(size(domains%low, 1), n))
    do g = 1, size(pieces%cell)
      associate (at => place_of(pieces%cell(g), space%axis%cell_count))
        do n = pieces%first(g), pieces%first(g + 1) - 1
          p = pieces%point(n)
          call cut(space, domains, p, at, pieces%low(:, n), pieces%high(:, n), pieces%share(n))
          if (mesh%axisymmetric) pieces%share(n) = pieces%share(n)*(pieces%low(1, n) + pieces%high(1, n)) &
            /(domains%low(1, p) + domains%high(1, p))
        end do
      end associate
    end do
  end subroutine cut_domains

  !> Returns the part of a domain in one cell. Ends beyond the outermost cells are kept in the pieces of these cells.
  pure subroutine cut(space, domains, p, at, low, high, share)
    type(space_type), intent(in) :: space
    type(domains_type), intent(in) :: domains
    !> Material point; position of the cell along the axes.
    integer, intent(in) :: p, at(3)
    !> Ends of the piece (dimension).
    real(wp), intent(out) :: low(:), high(:)
    !> Share of the volume of the point.
    real(wp), intent(out) :: share
    integer :: a, from, to

    share = 1.0_wp
    do a = 1, size(low)
      call interval_cells(space%axis(a), domains%low(a, p), domains%high(a, p), from, to)
      low(a) = domains%low(a, p)
      high(a) = domains%high(a, p)
      if (at(a) > from) low(a) = space%axis(a)%lines(at(a))
      if (at(a) < to) high(a) = space%axis(a)%lines(at(a) + 1)
      share = share*(high(a) - low(a))/(domains%high(a, p) - domains%low(a, p))
    end do
  end subroutine cut
end module qsmpm_domain_pieces
