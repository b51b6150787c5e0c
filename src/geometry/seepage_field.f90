!> Head field of a seepage flow, linear on triangles or tetrahedra, and location of a place in them.
!>
!>   h(x) = sum N_a(x) h_a,   u = gamma_w max(0, up (h - y))
!>
!> Heads are heights as coordinates along the vertical y. The cells fill the box of the grid: beyond the ground they
!> have the head of the free water there. Heads are computed by qsmpm_seepage.
module qsmpm_seepage_field
  use qsmpm_kinds, only: wp
  use qsmpm_spatial_lists, only: box_number, list_by_box
  use qsmpm_tensor, only: cofactor
  implicit none
  private

  public :: seepage_field_type, index_cells, head_of_flow, gradient_of_flow, cell_of_place, fall_in, find_slopes

  type :: seepage_field_type
    !> Coordinates (dimension, nodes).
    real(wp), allocatable :: position(:, :)
    !> Nodes of the cells (corners, cells).
    integer, allocatable :: corner(:, :)
    !> Head (nodes).
    real(wp), allocatable :: head(:)
    !> Discharge per unit area and time (dimension, cells).
    real(wp), allocatable :: velocity(:, :)
    !> Boxes of a uniform grid over the cells, and the cells that intersect each: `found` from `first` on.
    integer :: boxes(3) = 1
    real(wp), allocatable :: low(:), width(:)
    integer, allocatable :: first(:), found(:)
  end type seepage_field_type

contains

  !> Lists the cells of each box.
  pure subroutine index_cells(field)
    type(seepage_field_type), intent(inout) :: field
    integer :: from(3, size(field%corner, 2)), to(3, size(field%corner, 2)), c, d

    d = size(field%position, 1)
    field%low = minval(field%position, dim=2)
    field%boxes(:d) = max(1, nint((0.5_wp*size(field%corner, 2))**(1.0_wp/d)))
    field%width = (maxval(field%position, dim=2) - field%low)/field%boxes(:d)
    do c = 1, size(field%corner, 2)
      from(:, c) = box_at(field, minval(field%position(:, field%corner(:, c)), dim=2))
      to(:, c) = box_at(field, maxval(field%position(:, field%corner(:, c)), dim=2))
    end do
    call list_by_box(from, to, field%boxes, field%first, field%found)
  end subroutine index_cells

  !> Numbers of the box of a place along the axes.
  pure function box_at(field, place) result(box)
    type(seepage_field_type), intent(in) :: field
    real(wp), intent(in) :: place(:)
    integer :: box(3)

    box = 1
    associate (d => size(place))
      box(:d) = max(1, min(field%boxes(:d), 1 + int((place - field%low)/field%width)))
    end associate
  end function box_at

  !> Finds the cell of a place, or if it is in none the one it is least outside of, and its shape functions there.
  pure subroutine cell_of_place(field, place, cell, share)
    type(seepage_field_type), intent(in) :: field
    !> (dimension)
    real(wp), intent(in) :: place(:)
    integer, intent(out) :: cell
    !> Shape functions, none negative (corners).
    real(wp), intent(out) :: share(:)
    real(wp) :: here(size(share)), corner(size(place), size(share)), inside
    integer :: i, k

    k = box_number(box_at(field, place), field%boxes)
    inside = -huge(1.0_wp)
    cell = field%found(field%first(k))
    share = 0.0_wp
    do i = field%first(k), field%first(k + 1) - 1
      corner = field%position(:, field%corner(:, field%found(i)))
      call shares_in(corner, place, here)
      if (.not. minval(here) > inside) cycle
      inside = minval(here)
      cell = field%found(i)
      share = here
      if (inside >= 0.0_wp) exit
    end do
    share = max(0.0_wp, share)
    share = share/sum(share)
  end subroutine cell_of_place

  !> Computes the shape functions of a cell at a place.
  pure subroutine shares_in(corner, place, share)
    !> (dimension, corners), (dimension)
    real(wp), intent(in) :: corner(:, :), place(:)
    !> (corners)
    real(wp), intent(out) :: share(:)
    real(wp) :: a(3), b(3), p(3), normal(3, 3)
    integer :: d, k

    d = size(place)
    a(:d) = corner(:, 2) - corner(:, 1)
    b(:d) = corner(:, 3) - corner(:, 1)
    p(:d) = place - corner(:, 1)
    if (d == 2) then
      share(2) = p(1)*b(2) - p(2)*b(1)
      share(3) = a(1)*p(2) - a(2)*p(1)
      share(2:) = share(2:)/(a(1)*b(2) - a(2)*b(1))
      share(1) = 1.0_wp - share(2) - share(3)
    else
      normal = cofactor(reshape([a, b, corner(:, 4) - corner(:, 1)], [3, 3]))
      do k = 1, 3
        share(k + 1) = dot_product(normal(:, k), p)/dot_product(normal(:, 1), a)
      end do
      share(1) = 1.0_wp - sum(share(2:))
    end if
  end subroutine shares_in

  !> Computes the gradients of the shape functions of a cell times its determinant.
  pure subroutine find_slopes(corner, slope)
    !> (dimension, corners)
    real(wp), intent(in) :: corner(:, :)
    real(wp), intent(out) :: slope(:, :)
    integer :: a
    integer, parameter :: from(3) = [2, 3, 1], to(3) = [3, 1, 2]

    if (size(corner, 1) == 3) then
      slope(:, 2:) = cofactor(corner(:, 2:) - spread(corner(:, 1), 2, 3))
      slope(:, 1) = -sum(slope(:, 2:), dim=2)
      return
    end if
    do a = 1, 3
      slope(1, a) = corner(2, from(a)) - corner(2, to(a))
      slope(2, a) = corner(1, to(a)) - corner(1, from(a))
    end do
  end subroutine find_slopes

  !> Computes the gradient of corner values times the determinant of the cell, and the determinant.
  pure subroutine fall_in(corner, value, fall, determinant)
    !> (dimension, corners), (corners)
    real(wp), intent(in) :: corner(:, :), value(:)
    !> (dimension)
    real(wp), intent(out) :: fall(:), determinant
    real(wp) :: slope(size(corner, 1), size(corner, 2))
    integer :: k

    call find_slopes(corner, slope)
    fall = 0.0_wp
    do k = 2, size(value)
      fall = fall + slope(:, k)*(value(k) - value(1))
    end do
    determinant = dot_product(slope(:, 2), corner(:, 2) - corner(:, 1))
  end subroutine fall_in

  !> Head at a place.
  pure real(wp) function head_of_flow(field, place) result(head)
    type(seepage_field_type), intent(in) :: field
    !> (dimension or more)
    real(wp), intent(in) :: place(:)
    real(wp) :: share(size(field%corner, 1))
    integer :: cell

    call cell_of_place(field, place(:size(share) - 1), cell, share)
    head = sum(share*field%head(field%corner(:, cell)))
  end function head_of_flow

  !> Gradient of the head at a place (dimension).
  pure function gradient_of_flow(field, place) result(gradient)
    type(seepage_field_type), intent(in) :: field
    !> (dimension)
    real(wp), intent(in) :: place(:)
    real(wp) :: gradient(size(place)), share(size(field%corner, 1)), determinant
    integer :: cell

    call cell_of_place(field, place, cell, share)
    associate (node => field%corner(:, cell))
      call fall_in(field%position(:, node), field%head(node), gradient, determinant)
    end associate
    gradient = gradient/determinant
  end function gradient_of_flow
end module qsmpm_seepage_field
