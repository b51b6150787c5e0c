!> Convex solids as lists of tetrahedra: cuts by planes, volume, first and second moments.
!>
!> A plane cuts a tetrahedron into at most a tetrahedron and a solid with the corners of a wedge, which is divided into
!> three tetrahedra; so any number of cuts is exact to round-off.
module qsmpm_tet_list
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: tet_list_type, cell_tets, cut_tets, add_moments

  !> Tetrahedra of positive volume; corners(:, :, i), i = 1 ... count.
  type :: tet_list_type
    integer :: count = 0
    !> Corners (3, 4, size of allocation).
    real(wp), allocatable :: corners(:, :, :)
  end type tet_list_type

  !> Tetrahedra of a wedge, and of a brick about its diagonal from corner 1 to corner 7.
  integer, parameter :: of_wedge(4, 3) = reshape([1, 2, 3, 4, 2, 3, 4, 5, 3, 4, 5, 6], [4, 3])
  integer, parameter :: of_brick(4, 6) = reshape([1, 2, 3, 7, 1, 3, 4, 7, 1, 4, 8, 7, 1, 8, 5, 7, &
    1, 5, 6, 7, 1, 6, 2, 7], [4, 6])

contains

  !> Returns the tetrahedra of a cell given by its corners; plane faces are assumed.
  pure subroutine cell_tets(corners, list)
    !> Corners of a tetrahedron, wedge or brick in the order of the elements (3, 4, 6 or 8).
    real(wp), intent(in) :: corners(:, :)
    type(tet_list_type), intent(inout) :: list
    integer :: i

    list%count = 0
    select case (size(corners, 2))
    case (4)
      call add_tet(list, corners)
    case (6)
      do i = 1, 3
        call add_tet(list, corners(:, of_wedge(:, i)))
      end do
    case default
      do i = 1, 6
        call add_tet(list, corners(:, of_brick(:, i)))
      end do
    end select
  end subroutine cell_tets

  !> Appends a tetrahedron.
  pure subroutine add_tet(list, corners)
    type(tet_list_type), intent(inout) :: list
    !> Corners in any order (3,4).
    real(wp), intent(in) :: corners(:, :)

    if (.not. allocated(list%corners)) allocate (list%corners(3, 4, 32))
    if (list%count == size(list%corners, 3)) &
      list%corners = reshape(list%corners, [3, 4, 2*list%count], pad=[0.0_wp])
    list%count = list%count + 1
    list%corners(:, :, list%count) = corners
  end subroutine add_tet

  !> Keeps the part on the side of a plane where normal . (x - origin) <= 0.
  pure subroutine cut_tets(list, origin, normal, kept)
    type(tet_list_type), intent(in) :: list
    !> Point of the plane (3); normal of any length (3).
    real(wp), intent(in) :: origin(3), normal(3)
    !> The retained part.
    type(tet_list_type), intent(inout) :: kept
    real(wp) :: height(4), x(3, 4)
    integer :: i, k, n, order(4)

    kept%count = 0
    do i = 1, list%count
      n = 0
      do k = 1, 4
        height(k) = dot_product(normal, list%corners(:, k, i) - origin)
        if (height(k) > 0.0_wp) cycle
        n = n + 1
        order(n) = k
      end do
      if (n == 4) call add_tet(kept, list%corners(:, :, i))
      if (n == 4 .or. n == 0) cycle
      do k = 1, 4
        if (height(k) <= 0.0_wp) cycle
        n = n + 1
        order(n) = k
      end do
      x = list%corners(:, order, i)
      call cut_one(x, height(order), count(height <= 0.0_wp), kept)
    end do
  end subroutine cut_tets

  !> Appends the retained part of a tetrahedron whose first corners are inside.
  pure subroutine cut_one(x, height, inside, kept)
    !> Corners, those inside first (3,4); heights above the plane (4).
    real(wp), intent(in) :: x(3, 4), height(4)
    !> Number of corners inside, 1 to 3.
    integer, intent(in) :: inside
    !> Receives the part.
    type(tet_list_type), intent(inout) :: kept
    real(wp) :: wedge(3, 6)
    integer :: i

    select case (inside)
    case (1)
      call add_tet(kept, reshape([x(:, 1), on_plane(1, 2), on_plane(1, 3), on_plane(1, 4)], [3, 4]))
      return
    case (2)
      wedge = reshape([x(:, 1), on_plane(1, 3), on_plane(1, 4), &
        x(:, 2), on_plane(2, 3), on_plane(2, 4)], [3, 6])
    case default
      wedge = reshape([x(:, :3), on_plane(1, 4), on_plane(2, 4), on_plane(3, 4)], [3, 6])
    end select
    do i = 1, 3
      call add_tet(kept, wedge(:, of_wedge(:, i)))
    end do

  contains

    !> Intersection of an edge with the plane.
    pure function on_plane(inner, outer) result(place)
      !> Numbers of the corners.
      integer, intent(in) :: inner, outer
      real(wp) :: place(3)

      place = x(:, inner) + height(inner)/(height(inner) - height(outer))*(x(:, outer) - x(:, inner))
    end function on_plane
  end subroutine cut_one

  !> Adds volume and first moment, times a sign; optionally the second moments about a place too. A tetrahedron of
  !> volume V with corners v has the integral V/20 (sum v v' + (sum v)(sum v)').
  pure subroutine add_moments(list, sign, volume, moment, about, second)
    type(tet_list_type), intent(in) :: list
    !> Factor.
    real(wp), intent(in) :: sign
    !> Volume, and integral of the position (3), to which the terms are added.
    real(wp), intent(inout) :: volume, moment(3)
    !> Reference point of the second moments (3).
    real(wp), intent(in), optional :: about(3)
    !> Integral of (x - about)(x - about)' (3,3), to which the terms are added.
    real(wp), intent(inout), optional :: second(3, 3)
    real(wp) :: a(3), b(3), c(3), v(3, 4), part
    integer :: i, k

    do i = 1, list%count
      associate (x => list%corners(:, :, i))
        a = x(:, 2) - x(:, 1)
        b = x(:, 3) - x(:, 1)
        c = x(:, 4) - x(:, 1)
        part = sign*abs(a(1)*(b(2)*c(3) - b(3)*c(2)) + a(2)*(b(3)*c(1) - b(1)*c(3)) &
          + a(3)*(b(1)*c(2) - b(2)*c(1)))/6.0_wp
        volume = volume + part
        moment = moment + 0.25_wp*part*sum(x, dim=2)
        if (.not. present(second)) cycle
        v = x - spread(about, 2, 4)
        do k = 1, 3
          second(:, k) = second(:, k) + part/20.0_wp*(matmul(v, v(k, :)) + sum(v, dim=2)*sum(v(k, :)))
        end do
      end associate
    end do
  end subroutine add_moments
end module qsmpm_tet_list
