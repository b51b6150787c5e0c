!> Products of groups with many nodes in space: displacement gradients, internal forces and stiffness of the points of a
!> group (equations in qsmpm_group_stiffness). The matrices are small for a dense matrix library, which copies and pads
!> both factors. Here nodes are processed four at a time, a pair of four and four stays in registers over all points,
!> and only half of a symmetric stiffness is formed.
!>
!> This file is compiled for processors with AVX2 and FMA (CMakeLists.txt): call has_avx2 before use.
module qsmpm_wide_kernels
  use, intrinsic :: iso_c_binding, only: c_int
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: width, has_avx2, find_tensors, add_forces, form_stiffness

  !> Nodes of a block.
  integer, parameter :: width = 4
  !> Components i and k of the pairs that are formed together: those with i = k, and the others in two groups of three
  !> that are transposes of each other (pair, group).
  integer, parameter :: first_of(3, 3) = reshape([1, 2, 3, 1, 1, 2, 2, 3, 3], [3, 3])
  integer, parameter :: second_of(3, 3) = reshape([1, 2, 3, 2, 3, 3, 1, 1, 2], [3, 3])

  interface
    !> Returns whether the processor has AVX2 and FMA, 0 or 1 (processor.c).
    pure integer(c_int) function has_avx2() bind(c, name='qsmpm_has_avx2')
      import :: c_int
    end function has_avx2
  end interface

contains

  !> Computes displacement gradients of points, u_ij = sum over nodes of u_ia N_a,j. The last block of nodes ends with
  !> the last node; nodes already included in the block before are zero in `u`.
  pure subroutine find_tensors(n, quads, points, u, gradient, tensor)
    !> Numbers of nodes, of blocks of four nodes, and of points.
    integer, intent(in) :: n, quads, points
    !> Displacements of the nodes, stored by blocks.
    real(wp), intent(in) :: u(width, quads, 3)
    real(wp), intent(in) :: gradient(n, 3, points)
    real(wp), intent(out) :: tensor(3, 3, points)
    real(wp), dimension(width) :: s11, s21, s31, s12, s22, s32, s13, s23, s33
    integer :: a, q, v

    do q = 1, points
      s11 = 0.0_wp
      s21 = 0.0_wp
      s31 = 0.0_wp
      s12 = 0.0_wp
      s22 = 0.0_wp
      s32 = 0.0_wp
      s13 = 0.0_wp
      s23 = 0.0_wp
      s33 = 0.0_wp
      do v = 1, quads
        a = min(width*(v - 1), n - width)
        s11 = s11 + u(:, v, 1)*gradient(a + 1:a + width, 1, q)
        s21 = s21 + u(:, v, 2)*gradient(a + 1:a + width, 1, q)
        s31 = s31 + u(:, v, 3)*gradient(a + 1:a + width, 1, q)
        s12 = s12 + u(:, v, 1)*gradient(a + 1:a + width, 2, q)
        s22 = s22 + u(:, v, 2)*gradient(a + 1:a + width, 2, q)
        s32 = s32 + u(:, v, 3)*gradient(a + 1:a + width, 2, q)
        s13 = s13 + u(:, v, 1)*gradient(a + 1:a + width, 3, q)
        s23 = s23 + u(:, v, 2)*gradient(a + 1:a + width, 3, q)
        s33 = s33 + u(:, v, 3)*gradient(a + 1:a + width, 3, q)
      end do
      tensor(:, 1, q) = [sum(s11), sum(s21), sum(s31)]
      tensor(:, 2, q) = [sum(s12), sum(s22), sum(s32)]
      tensor(:, 3, q) = [sum(s13), sum(s23), sum(s33)]
    end do
  end subroutine find_tensors

  !> Adds internal forces of points, f_ia = sum over points of t_ij N_a,j.
  pure subroutine add_forces(n, points, tensor, gradient, force)
    integer, intent(in) :: n, points
    !> Weighted stresses.
    real(wp), intent(in) :: tensor(3, 3, points)
    real(wp), intent(in) :: gradient(n, 3, points)
    real(wp), intent(inout) :: force(3, n)
    real(wp), dimension(width) :: s1, s2, s3
    real(wp) :: sums(width, 3)
    integer :: a, first, next, q

    next = 1
    do while (next <= n)
      ! The last block begins with nodes of the block before, which are not added again.
      first = min(next, n - width + 1)
      s1 = 0.0_wp
      s2 = 0.0_wp
      s3 = 0.0_wp
      do q = 1, points
        s1 = s1 + gradient(first:first + width - 1, 1, q)*tensor(1, 1, q)
        s2 = s2 + gradient(first:first + width - 1, 1, q)*tensor(2, 1, q)
        s3 = s3 + gradient(first:first + width - 1, 1, q)*tensor(3, 1, q)
        s1 = s1 + gradient(first:first + width - 1, 2, q)*tensor(1, 2, q)
        s2 = s2 + gradient(first:first + width - 1, 2, q)*tensor(2, 2, q)
        s3 = s3 + gradient(first:first + width - 1, 2, q)*tensor(3, 2, q)
        s1 = s1 + gradient(first:first + width - 1, 3, q)*tensor(1, 3, q)
        s2 = s2 + gradient(first:first + width - 1, 3, q)*tensor(2, 3, q)
        s3 = s3 + gradient(first:first + width - 1, 3, q)*tensor(3, 3, q)
      end do
      sums(:, 1) = s1
      sums(:, 2) = s2
      sums(:, 3) = s3
      do a = next, first + width - 1
        force(:, a) = force(:, a) + sums(a - first + 1, :)
      end do
      next = first + width
    end do
  end subroutine add_forces

  !> Computes the stiffness of some points, K_iakb = sum of V N_a,j A_ijkl N_b,l, stored in a block or added to it. For
  !> a symmetric one the pairs i < k are formed, and for i = k the entries at and below the diagonal.
  pure subroutine form_stiffness(n, quads, points, point, symmetric, add, weight, gradient, tangent, packed, scaled, &
    panel, block)
    integer, intent(in) :: n, quads
    !> Number of selected points, and their numbers.
    integer, intent(in) :: points, point(points)
    logical, intent(in) :: symmetric, add
    !> Values of all points of the group.
    real(wp), intent(in) :: weight(*), gradient(n, 3, *), tangent(3, 3, 3, 3, *)
    !> Work arrays: gradients by blocks; V A_ijkl of three pairs (i,k) as (j, pair, l); their sums with N_a,j.
    real(wp), intent(inout) :: packed(width, 3, points, quads), scaled(3, 3, 3, points), panel(width, 3, 3, points)
    real(wp), intent(inout) :: block(n, 3, 3, n)
    real(wp) :: value(width, width, 3)
    logical :: mirrored
    integer :: t, v, w

    call pack_gradients(n, quads, points, point, gradient, packed)
    do t = 1, merge(2, 3, symmetric)
      call scale_tangents(points, point, first_of(:, t), second_of(:, t), weight, tangent, scaled)
      do v = 1, quads
        call form_panel(points, packed(:, :, :, v), scaled, panel)
        do w = 1, merge(v, quads, symmetric .and. t == 1)
          call multiply(3*points, panel, packed(:, :, :, w), value)
          mirrored = symmetric .and. (t > 1 .or. w < v)
          call put_blocks(n, add, mirrored, width*(v - 1), width*(w - 1), first_of(:, t), second_of(:, t), value, block)
        end do
      end do
    end do
  end subroutine form_stiffness

  !> Stores gradients by blocks, padded with zeros.
  pure subroutine pack_gradients(n, quads, points, point, gradient, packed)
    integer, intent(in) :: n, quads, points, point(points)
    real(wp), intent(in) :: gradient(n, 3, *)
    real(wp), intent(out) :: packed(width, 3, points, quads)
    integer :: j, last, q, v

    do v = 1, n/width
      do q = 1, points
        do j = 1, 3
          packed(:, j, q, v) = gradient(width*(v - 1) + 1:width*v, j, point(q))
        end do
      end do
    end do
    if (n == width*quads) return
    last = n - width*(quads - 1)
    packed(:, :, :, quads) = 0.0_wp
    do q = 1, points
      packed(:last, :, q, quads) = gradient(n - last + 1:, :, point(q))
    end do
  end subroutine pack_gradients

  !> Computes V A_ijkl of three pairs (i,k), as (j, pair, l).
  pure subroutine scale_tangents(points, point, i, k, weight, tangent, scaled)
    integer, intent(in) :: points, point(points), i(3), k(3)
    real(wp), intent(in) :: weight(*), tangent(3, 3, 3, 3, *)
    real(wp), intent(out) :: scaled(3, 3, 3, points)
    integer :: l, p, q

    do q = 1, points
      do l = 1, 3
        do p = 1, 3
          scaled(:, p, l, q) = weight(point(q))*tangent(i(p), :, k(p), l, point(q))
        end do
      end do
    end do
  end subroutine scale_tangents

  !> Computes the sums over j for a block of nodes a.
  pure subroutine form_panel(points, packed, scaled, panel)
    integer, intent(in) :: points
    real(wp), intent(in) :: packed(width, 3, points), scaled(3, 3, 3, points)
    real(wp), intent(out) :: panel(width, 3, 3, points)
    integer :: l, p, q

    do q = 1, points
      do l = 1, 3
        do p = 1, 3
          panel(:, p, l, q) = packed(:, 1, q)*scaled(1, p, l, q) + packed(:, 2, q)*scaled(2, p, l, q) + &
            packed(:, 3, q)*scaled(3, p, l, q)
        end do
      end do
    end do
  end subroutine form_panel

  !> Multiplies a panel by a block of nodes b: sums over l and the points. There is one array for each pair and node b,
  !> so that all of them stay in registers.
  pure subroutine multiply(terms, panel, other, value)
    integer, intent(in) :: terms
    real(wp), intent(in) :: panel(width, 3, terms), other(width, terms)
    !> (a, b, pair)
    real(wp), intent(out) :: value(width, width, 3)
    real(wp), dimension(width) :: x1, x2, x3, x4, y1, y2, y3, y4, z1, z2, z3, z4
    integer :: t

    x1 = 0.0_wp
    x2 = 0.0_wp
    x3 = 0.0_wp
    x4 = 0.0_wp
    y1 = 0.0_wp
    y2 = 0.0_wp
    y3 = 0.0_wp
    y4 = 0.0_wp
    z1 = 0.0_wp
    z2 = 0.0_wp
    z3 = 0.0_wp
    z4 = 0.0_wp
    do t = 1, terms
      x1 = x1 + panel(:, 1, t)*other(1, t)
      y1 = y1 + panel(:, 2, t)*other(1, t)
      z1 = z1 + panel(:, 3, t)*other(1, t)
      x2 = x2 + panel(:, 1, t)*other(2, t)
      y2 = y2 + panel(:, 2, t)*other(2, t)
      z2 = z2 + panel(:, 3, t)*other(2, t)
      x3 = x3 + panel(:, 1, t)*other(3, t)
      y3 = y3 + panel(:, 2, t)*other(3, t)
      z3 = z3 + panel(:, 3, t)*other(3, t)
      x4 = x4 + panel(:, 1, t)*other(4, t)
      y4 = y4 + panel(:, 2, t)*other(4, t)
      z4 = z4 + panel(:, 3, t)*other(4, t)
    end do
    value(:, 1, 1) = x1
    value(:, 2, 1) = x2
    value(:, 3, 1) = x3
    value(:, 4, 1) = x4
    value(:, 1, 2) = y1
    value(:, 2, 2) = y2
    value(:, 3, 2) = y3
    value(:, 4, 2) = y4
    value(:, 1, 3) = z1
    value(:, 2, 3) = z2
    value(:, 3, 3) = z3
    value(:, 4, 3) = z4
  end subroutine multiply

  !> Stores three pairs (i,k) of a block of nodes a and one of nodes b, and their transposes.
  pure subroutine put_blocks(n, add, mirrored, a0, b0, i, k, value, block)
    integer, intent(in) :: n
    logical, intent(in) :: add, mirrored
    !> Numbers of nodes before the blocks.
    integer, intent(in) :: a0, b0, i(3), k(3)
    real(wp), intent(in) :: value(width, width, 3)
    real(wp), intent(inout) :: block(n, 3, 3, n)
    integer :: a, b, p, rows, columns

    rows = min(width, n - a0)
    columns = min(width, n - b0)
    do p = 1, 3
      do b = 1, columns
        if (rows == width) then
          call put_four(add, value(:, b, p), block(a0 + 1, i(p), k(p), b0 + b))
        else
          call put(rows, add, value(:, b, p), block(a0 + 1, i(p), k(p), b0 + b))
        end if
      end do
      if (.not. mirrored) cycle
      do a = 1, rows
        if (columns == width) then
          call put_four(add, value(a, :, p), block(b0 + 1, k(p), i(p), a0 + a))
        else
          call put(columns, add, value(a, :, p), block(b0 + 1, k(p), i(p), a0 + a))
        end if
      end do
    end do
  end subroutine put_blocks

  !> Stores or adds four numbers.
  pure subroutine put_four(add, value, to)
    logical, intent(in) :: add
    real(wp), intent(in) :: value(width)
    real(wp), intent(inout) :: to(width)

    if (add) then
      to = to + value
    else
      to = value
    end if
  end subroutine put_four

  !> Stores or adds the first of four numbers.
  pure subroutine put(count, add, value, to)
    integer, intent(in) :: count
    logical, intent(in) :: add
    real(wp), intent(in) :: value(width)
    real(wp), intent(inout) :: to(count)

    if (add) then
      to = to + value(:count)
    else
      to = value(:count)
    end if
  end subroutine put
end module qsmpm_wide_kernels
