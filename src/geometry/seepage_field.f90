!> Head of water that flows through the ground of a plane section, linear on triangles, and where a place lies in them.
!>
!>   h(x) = sum N_a(x) h_a,   u = gamma_w max(0, up (h - y))
!>
!> Heads are heights as coordinates along the vertical y. The triangles fill the box of the grid: beyond the ground they
!> hold the head of the free water there. How heads are found is left to qsmpm_seepage.
module qsmpm_seepage_field
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: seepage_field_type, index_triangles, head_of_flow, gradient_of_flow, cell_of_place

  type :: seepage_field_type
    !> (2, nodes)
    real(wp), allocatable :: position(:, :)
    !> (3, cells)
    integer, allocatable :: corner(:, :)
    !> (nodes)
    real(wp), allocatable :: head(:)
    !> Volume of water that passes through a unit area in unit time (2, cells).
    real(wp), allocatable :: velocity(:, :)
    !> Boxes of an even grid over the triangles, and the triangles that reach into each: `found` from `first` on.
    integer :: boxes(2) = 0
    real(wp) :: low(2) = 0.0_wp, width(2) = 1.0_wp
    integer, allocatable :: first(:), found(:)
  end type seepage_field_type

contains

  !> List the triangles of each box.
  pure subroutine index_triangles(field)
    type(seepage_field_type), intent(inout) :: field
    integer :: c, i, j, turn, from(2), to(2), box
    integer, allocatable :: filled(:)

    field%low = minval(field%position, dim=2)
    field%boxes = max(1, nint(sqrt(0.5_wp*size(field%corner, 2))))
    field%width = (maxval(field%position, dim=2) - field%low)/field%boxes
    allocate (filled(product(field%boxes)))
    do turn = 1, 2
      filled = 0
      do c = 1, size(field%corner, 2)
        from = box_at(field, minval(field%position(:, field%corner(:, c)), dim=2))
        to = box_at(field, maxval(field%position(:, field%corner(:, c)), dim=2))
        do j = from(2), to(2)
          do i = from(1), to(1)
            box = i + (j - 1)*field%boxes(1)
            if (turn == 2) field%found(field%first(box) + filled(box)) = c
            filled(box) = filled(box) + 1
          end do
        end do
      end do
      if (turn == 2) exit
      field%first = [1, (1 + sum(filled(:i)), i=1, size(filled))]
      allocate (field%found(sum(filled)))
    end do
  end subroutine index_triangles

  !> Numbers of the box of a place along both axes.
  pure function box_at(field, place) result(box)
    type(seepage_field_type), intent(in) :: field
    real(wp), intent(in) :: place(2)
    integer :: box(2)

    box = max(1, min(field%boxes, 1 + int((place - field%low)/field%width)))
  end function box_at

  !> The triangle of a place, that which it lies outside of least where it lies in none, and its shares in it.
  pure subroutine cell_of_place(field, place, cell, share)
    type(seepage_field_type), intent(in) :: field
    real(wp), intent(in) :: place(2)
    integer, intent(out) :: cell
    !> Shape functions (3), none negative.
    real(wp), intent(out) :: share(3)
    real(wp) :: here(3), inside
    integer :: box(2), i, k

    box = box_at(field, place)
    k = box(1) + (box(2) - 1)*field%boxes(1)
    inside = -huge(1.0_wp)
    cell = field%found(field%first(k))
    share = 0.0_wp
    do i = field%first(k), field%first(k + 1) - 1
      here = shares_in(field%position(:, field%corner(:, field%found(i))), place)
      if (.not. minval(here) > inside) cycle
      inside = minval(here)
      cell = field%found(i)
      share = here
      if (inside >= 0.0_wp) exit
    end do
    share = max(0.0_wp, share)
    share = share/sum(share)
  end subroutine cell_of_place

  !> Shape functions of a triangle at a place.
  pure function shares_in(corner, place) result(share)
    real(wp), intent(in) :: corner(2, 3), place(2)
    real(wp) :: share(3)

    share(2) = cross(place - corner(:, 1), corner(:, 3) - corner(:, 1))
    share(3) = cross(corner(:, 2) - corner(:, 1), place - corner(:, 1))
    share(2:) = share(2:)/cross(corner(:, 2) - corner(:, 1), corner(:, 3) - corner(:, 1))
    share(1) = 1.0_wp - share(2) - share(3)
  end function shares_in

  pure real(wp) function cross(a, b)
    real(wp), intent(in) :: a(2), b(2)

    cross = a(1)*b(2) - a(2)*b(1)
  end function cross

  !> Head at a place.
  pure real(wp) function head_of_flow(field, place) result(head)
    type(seepage_field_type), intent(in) :: field
    real(wp), intent(in) :: place(2)
    real(wp) :: share(3)
    integer :: cell

    call cell_of_place(field, place, cell, share)
    head = sum(share*field%head(field%corner(:, cell)))
  end function head_of_flow

  !> Gradient of the head at a place.
  pure function gradient_of_flow(field, place) result(gradient)
    type(seepage_field_type), intent(in) :: field
    real(wp), intent(in) :: place(2)
    real(wp) :: gradient(2)
    real(wp) :: share(3), a(2), b(2)
    integer :: cell

    call cell_of_place(field, place, cell, share)
    associate (node => field%corner(:, cell))
      a = field%position(:, node(2)) - field%position(:, node(1))
      b = field%position(:, node(3)) - field%position(:, node(1))
      associate (da => field%head(node(2)) - field%head(node(1)), db => field%head(node(3)) - field%head(node(1)))
        gradient = [da*b(2) - db*a(2), db*a(1) - da*b(1)]/cross(a, b)
      end associate
    end associate
  end function gradient_of_flow
end module qsmpm_seepage_field
