!> Uniform cell pressure: the points of a group share one pressure, which avoids volumetric locking.
!>
!> The formulation has two fields, the displacement and a pressure that is constant in the group, with the pressure and
!> its conjugate condensed inside the group. A point of initial volume V receives an additional volume change omega; its
!> law is called at Fbar = S F, S = exp(omega M), M = diag(m), sum m = 1. With the result Qbar, Abar of the law the
!> chain rule gives
!>   Q = S Qbar,  A = S Abar S,  pi = Q : M F  (the mean stress, per initial volume),
!>   r = dQ/domega = M Q + A (M F),  l = dpi/dF = M Q + A^T (M F),  kappa = dpi/domega = (M F) : r.
!> The group is in balance when
!>   pi + c omega - g - h s = pbar for all points,   sum V omega = 0,   c = h * factor * shear modulus G.
!> g is the pressure variation inside the group due to weight and water (qsmpm_point_forces), s = pi - g relative to its
!> mean at the start of the step where cells move with the material, otherwise 0. Elastic soil has h = 1: the pressure
!> differences in the group are the sum of factor G omega over all steps. In soil that may yield they decay with shear,
!> h = t/(t + 2 G e), with e = sqrt(sum V E':E'/sum V) of the deviator of Green's strain of the step and t that of the
!> stress at its start. This is one implicit Euler step of d(s)/de = -factor G d(omega)/de - s 2G/t: in steady flow the
!> differences are a share of the strength for any length of the step. In a group without shear stress they are retained
!> for a step. The condition makes sum V Q : dF stationary in omega, so that Q is the stress of the internal force, and
!> with k = kappa + c > 0
!>   dQ = (A - r l^T/k) dF + r/k dpbar,   dpbar = sum (V/k) l : dF / sum (V/k).
!> c -> infinity recovers the untreated formulation; a group of one point has omega = 0. A and the condensed tangent are
!> symmetric together. The volume of a point changes by det Fbar = det F exp(omega).
!>
!> qsmpm_pressure_balance finds omega; this module condenses stress and tangent of the points; the rank-one part of the
!> stiffness is `add_pressure_stiffness` of qsmpm_group_stiffness. docs/methods/uniform_pressure.md.
module qsmpm_uniform_pressure
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_slot_type, batch_type, status_ok, status_failed, tangent_none, tangent_elastic
  use qsmpm_pressure_balance, only: pressure_type, even_out_volumes, balance, search
  use qsmpm_tensor, only: gradient_row, identity, pack_gradient, unpack_gradient, unpack_symmetric
  implicit none
  private

  public :: find_pressure

  !> Lower bound of h. The remaining c of freely yielding soil must be negligible compared with the strength where
  !> points remain in their groups, and sufficient to couple them where they move from group to group.
  real(wp), parameter :: least_lasting = 1.0e-5_wp, least_passing = 1.0e-3_wp

contains

  !> Computes stress, state and, if requested, the condensed tangent A - r l^T/k of points with one pressure. Where none
  !> is found in the allowed number of passes, all points receive a status.
  subroutine find_pressure(slot, weight, tangent, batch, pressure)
    !> The law of the points.
    type(law_slot_type), intent(in) :: slot
    !> Initial volumes V (n).
    real(wp), intent(in) :: weight(:)
    !> tangent_none, tangent_consistent or tangent_elastic.
    integer, intent(in) :: tangent
    !> F on entry; Fbar, results of the law, Q and condensed tangent on return.
    type(batch_type), intent(inout) :: batch
    !> Work space with g stored in place of g + h s, and s.
    type(pressure_type), intent(inout) :: pressure
    logical :: sound, found

    call find_resistance(slot, weight, batch, pressure)
    associate (n => batch%count)
      pressure%offset(:n) = pressure%offset(:n) + pressure%left_share*pressure%kept(:n)
    end associate
    pressure%gradient(:, :batch%count) = batch%gradient(:, :batch%count)
    call even_out_volumes(weight, batch, pressure, sound)
    found = .false.
    if (sound) call balance(slot, weight, batch, pressure, found)
    if (sound .and. .not. found) call search(slot, weight, batch, pressure, found)
    if (.not. found) then
      batch%status(:batch%count) = status_failed
      return
    end if
    if (tangent == tangent_elastic) then
      pressure%constant = .true.
      call slot%update(batch, tangent)
    end if
    if (any(batch%status(:batch%count) /= status_ok)) return
    call condense(batch, pressure, tangent /= tangent_none)
  end subroutine find_pressure

  !> Computes h, c and dc/dF from F and the stresses at the start of the step.
  pure subroutine find_resistance(slot, weight, batch, pressure)
    type(law_slot_type), intent(in) :: slot
    !> Initial volumes V (n).
    real(wp), intent(in) :: weight(:)
    type(batch_type), intent(in) :: batch
    type(pressure_type), intent(inout) :: pressure
    real(wp) :: f(3, 3), strain(3, 3), stress(3, 3), e, tau, stiff, least
    integer :: p

    pressure%resistance = slot%pressure_factor*slot%law%shear_scale
    pressure%constant = .true.
    pressure%left_share = 1.0_wp
    if (.not. slot%flows) return
    stiff = 2.0_wp*slot%law%shear_scale
    least = merge(least_lasting, least_passing, pressure%lasting)
    e = 0.0_wp
    tau = 0.0_wp
    do p = 1, batch%count
      f = unpack_gradient(batch%gradient(:, p))
      strain = deviator_of(0.5_wp*(matmul(transpose(f), f) - identity))
      stress = deviator_of(unpack_symmetric(batch%stress_start(:, p)))
      e = e + weight(p)*sum(strain**2)
      tau = tau + weight(p)*sum(stress**2)
      call pack_gradient(matmul(f, strain), pressure%resistance_by(:, p))
    end do
    e = sqrt(e/sum(weight))
    tau = sqrt(tau/sum(weight))
    if (.not. (e > 0.0_wp .and. tau > 0.0_wp)) return
    pressure%constant = .false.
    associate (by => pressure%resistance_by(:, :batch%count))
      by = -by*pressure%resistance*(1.0_wp - least)*tau*stiff/((tau + stiff*e)**2*e*sum(weight))
    end associate
    pressure%left_share = (tau + least*stiff*e)/(tau + stiff*e)
    pressure%resistance = pressure%resistance*pressure%left_share
  end subroutine find_resistance

  !> Returns the deviator of a tensor.
  pure function deviator_of(a) result(deviator)
    real(wp), intent(in) :: a(3, 3)
    real(wp) :: deviator(3, 3)

    deviator = a - (a(1, 1) + a(2, 2) + a(3, 3))/3.0_wp*identity
  end function deviator_of

  !> Computes Q and, if requested, r, l, k and A - r l^T/k of all points.
  pure subroutine condense(batch, pressure, with_tangent)
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> Work space.
    type(pressure_type), intent(inout) :: pressure
    !> A tangent is requested.
    logical, intent(in) :: with_tangent
    real(wp) :: m(size(pressure%gradient, 1)), h(size(pressure%gradient, 1)), s(size(pressure%gradient, 1))
    integer :: row(size(pressure%gradient, 1)), p, j, n

    n = size(m)
    row = gradient_row(:n, merge(2, 3, n == 5))
    m = pressure%direction(row)
    do p = 1, batch%count
      s = exp(pressure%omega(p)*m)
      h = m*pressure%gradient(:, p)
      batch%piola(:, p) = s*batch%piola(:, p)
      if (.not. with_tangent) cycle
      associate (a => batch%tangent(:, :, p), r => pressure%right(:, p), l => pressure%left(:, p))
        r = m*batch%piola(:, p)
        l = r
        do j = 1, n
          a(:, j) = s*a(:, j)*s(j)
          r = r + a(:, j)*h(j)
          l(j) = l(j) + dot_product(a(:, j), h)
        end do
        pressure%stiffness(p) = pressure%resistance + dot_product(h, r)
        do j = 1, n
          a(:, j) = a(:, j) - r*(l(j)/pressure%stiffness(p))
        end do
      end associate
    end do
  end subroutine condense

end module qsmpm_uniform_pressure
