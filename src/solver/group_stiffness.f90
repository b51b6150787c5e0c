!> Internal force and stiffness of a run of integration points of one group, in the group's own block.
!>
!>   f_ia = sum V Q_ij N_a,j      K_iakb = sum V N_a,j A_ijkl N_b,l      (eqs. 16-18, 20, 25)
!> with the law's Q and A on the start configuration; in axisymmetry the hoop component adds N_a/r.
!> Points of one pressure (qsmpm_uniform_pressure) add CR CL^T / sum (V/k).
module qsmpm_group_stiffness
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: batch_type
  use qsmpm_integration, only: integration_type
  use qsmpm_pressure_balance, only: pressure_type
  implicit none
  private

  public :: add_forces, add_stiffness_2d, add_stiffness_3d, add_pressure_stiffness

contains

  !> Internal forces of a run of points (eq. 25 on the start configuration).
  pure subroutine add_forces(integration, from, to, n, batch, force)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    !> Range of points and number of nodes.
    integer, intent(in) :: from, to, n
    !> The points handed to the law.
    type(batch_type), intent(in) :: batch
    !> (dimension*nodes)
    real(wp), intent(inout) :: force(:)
    integer :: q

    do q = from, to
      call add_divergence(integration, q, n, integration%weight(q), batch%piola(:, q - from + 1), force)
    end do
  end subroutine add_forces

  !> v T_ij N_a,j of one point for a tensor T packed as a gradient.
  pure subroutine add_divergence(integration, q, n, v, tensor, force)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    !> The point and the number of nodes.
    integer, intent(in) :: q
    integer, intent(in) :: n
    !> Volume.
    real(wp), intent(in) :: v
    !> T (5 or 9).
    real(wp), intent(in) :: tensor(:)
    !> (dimension*nodes)
    real(wp), intent(inout) :: force(:)
    integer :: a, j, d

    d = size(integration%gradient, 1)
    do a = 1, n
      do j = 1, d
        force((a - 1)*d + 1:a*d) = force((a - 1)*d + 1:a*d) &
          + v*tensor((j - 1)*d + 1:j*d)*integration%gradient(j, a, q)
      end do
      if (integration%axisymmetric) force((a - 1)*d + 1) = force((a - 1)*d + 1) &
        + v*tensor(5)*integration%shape(a, q)/integration%radius(q)
    end do
  end subroutine add_divergence

  !> What the common pressure of a run of points adds: CR CL^T / sum (V/k), CR = sum (V/k) r : grad N,
  !> CL = sum (V/k) l : grad N.
  pure subroutine add_pressure_stiffness(integration, from, to, n, pressure, block)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    !> Range of points.
    integer, intent(in) :: from
    integer, intent(in) :: to
    !> Displacement components of the group.
    integer, intent(in) :: n
    !> r, l and k of the points; its vectors are overwritten.
    type(pressure_type), intent(inout) :: pressure
    !> (n, n)
    real(wp), intent(inout) :: block(n, n)
    real(wp) :: total, share
    integer :: q, k, b

    pressure%right_vector(:n) = 0.0_wp
    pressure%left_vector(:n) = 0.0_wp
    total = 0.0_wp
    do q = from, to
      k = q - from + 1
      share = integration%weight(q)/pressure%stiffness(k)
      total = total + share
      call add_divergence(integration, q, n/size(integration%gradient, 1), share, &
        pressure%right(:, k), pressure%right_vector)
      call add_divergence(integration, q, n/size(integration%gradient, 1), share, &
        pressure%left(:, k), pressure%left_vector)
    end do
    do b = 1, n
      block(:, b) = block(:, b) + pressure%right_vector(:n)*(pressure%left_vector(b)/total)
    end do
  end subroutine add_pressure_stiffness

  !> Stiffness of a run of plane or axisymmetric points.
  pure subroutine add_stiffness_2d(integration, from, to, n, batch, block)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    integer, intent(in) :: from, to, n
    !> The points handed to the law.
    type(batch_type), intent(in) :: batch
    !> (2, n, 2, n)
    real(wp), intent(inout) :: block(2, n, 2, n)
    real(wp) :: t(5, 2), g(2), hoop, v
    integer :: q, k, a, b

    do q = from, to
      k = q - from + 1
      v = integration%weight(q)
      do b = 1, n
        g = v*integration%gradient(:, b, q)
        t(:, 1) = batch%tangent(:, 1, k)*g(1) + batch%tangent(:, 3, k)*g(2)
        t(:, 2) = batch%tangent(:, 2, k)*g(1) + batch%tangent(:, 4, k)*g(2)
        if (integration%axisymmetric) t(:, 1) = t(:, 1) &
          + batch%tangent(:, 5, k)*v*integration%shape(b, q)/integration%radius(q)
        do a = 1, n
          block(:, a, 1, b) = block(:, a, 1, b) + integration%gradient(1, a, q)*t(1:2, 1) &
            + integration%gradient(2, a, q)*t(3:4, 1)
          block(:, a, 2, b) = block(:, a, 2, b) + integration%gradient(1, a, q)*t(1:2, 2) &
            + integration%gradient(2, a, q)*t(3:4, 2)
          if (integration%axisymmetric) then
            hoop = integration%shape(a, q)/integration%radius(q)
            block(1, a, :, b) = block(1, a, :, b) + hoop*t(5, :)
          end if
        end do
      end do
    end do
  end subroutine add_stiffness_2d

  !> Stiffness of a run of points in 3D.
  pure subroutine add_stiffness_3d(integration, from, to, n, batch, block)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    integer, intent(in) :: from, to, n
    !> The points handed to the law.
    type(batch_type), intent(in) :: batch
    !> (3, n, 3, n)
    real(wp), intent(inout) :: block(3, n, 3, n)
    real(wp) :: t(9), g(3), h(3, n)
    integer :: q, k, a, b, i

    do q = from, to
      k = q - from + 1
      h = integration%gradient(:, :n, q)
      do b = 1, n
        g = integration%weight(q)*h(:, b)
        do i = 1, 3
          t = batch%tangent(:, i, k)*g(1) + batch%tangent(:, 3 + i, k)*g(2) &
            + batch%tangent(:, 6 + i, k)*g(3)
          do a = 1, n
            block(:, a, i, b) = block(:, a, i, b) + h(1, a)*t(1:3) + h(2, a)*t(4:6) + h(3, a)*t(7:9)
          end do
        end do
      end do
    end do
  end subroutine add_stiffness_3d
end module qsmpm_group_stiffness
