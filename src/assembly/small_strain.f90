!> Steps of small strain with fixed positions (GEOMETRY=FIXED of safety phases): forces are those of the true stress on
!> the body at the start, for any displacement of the step, so that equilibrium is that of the undeformed body.
!>
!> The law is called at a stretch U of the strain e = (H + H^T)/2 of the displacement gradient H,
!>   U = (I - e/2)^-1 (I + e/2),   dU = B de B,  B = (I + U)/2,   d ln det U = n : de,  n = (U + U^-1 + 2 I)/4,
!> which is exp(e) up to e^3/12: an isochoric e gives an isochoric U, so that pore water a hundred times as stiff as the
!> soil has no effect in shear. The result Q, A at U is replaced, with J the change of volume, by
!>   T = sym(Q U),   dT = sym(A:dU U + Q dU):
!> the stress per unit of the initial volume for laws that bound the Kirchhoff stress; for others the Cauchy stress T/J.
!> Away from U = I the tangent of a symmetric law is not symmetric, and is used as it is: symmetrised, its error would
!> be the strain times the stiffness of the water, which exceeds the stiffness of yielding soil.
module qsmpm_small_strain
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: batch_type, law_slot_type
  use qsmpm_pressure_balance, only: packed_determinant, pressure_type
  use qsmpm_tensor, only: determinant, gradient_row, gradient_column, identity, inverse, pack_gradient, unpack_gradient
  implicit none
  private

  public :: take_stretch, take_true_stress, turn_coupling

contains

  !> Replaces F of the points by U; a strain without a stretch (I - e/2 not positive definite) turns a point inside out.
  pure subroutine take_stretch(batch)
    type(batch_type), intent(inout) :: batch
    real(wp) :: strain(3, 3), rest(3, 3), det
    integer :: p

    do p = 1, batch%count
      strain = unpack_gradient(batch%gradient(:, p)) - identity
      strain = 0.5_wp*(strain + transpose(strain))
      rest = identity - 0.5_wp*strain
      det = determinant(rest)
      if (is_positive(rest, det)) then
        call pack_gradient(2.0_wp*inverse(rest, det) - identity, batch%gradient(:, p))
      else
        call pack_gradient(-identity, batch%gradient(:, p))
      end if
    end do
  end subroutine take_stretch

  !> Replaces Q and A of the points by T and dT/dH; the stored stress is the one in equilibrium.
  pure subroutine take_true_stress(slot, with_tangent, batch, pressure)
    !> Law of the points.
    type(law_slot_type), intent(in) :: slot
    !> The tangent is requested.
    logical, intent(in) :: with_tangent
    type(batch_type), intent(inout) :: batch
    !> Arguments of the law, where the points share a pressure: r and l are converted to those of dT.
    type(pressure_type), intent(inout), optional :: pressure
    real(wp) :: stretch(3, 3), piola(3, 3), stress(3, 3), of_volume(3, 3), volume, scale
    integer :: p

    do p = 1, batch%count
      stretch = unpack_gradient(batch%gradient(:, p))
      if (present(pressure)) stretch = unpack_gradient(pressure%gradient(:, p))
      volume = packed_determinant(batch%gradient(:, p))
      piola = unpack_gradient(batch%piola(:, p))
      if (slot%law%bounds_kirchhoff) then
        scale = 1.0_wp
        batch%stress(:, p) = volume*batch%stress(:, p)
        stress = product_of(piola, stretch) - slot%confinement*(volume - 1.0_wp)*identity
        of_volume = slot%confinement*volume*identity
      else
        scale = volume
        stress = product_of(piola, stretch)/volume
        of_volume = stress
      end if
      call pack_gradient(stress, batch%piola(:, p))
      if (.not. with_tangent) cycle
      call turn_tangent(stretch, piola, scale, batch%tangent(:, :, p))
      if (present(pressure)) then
        call turn_pressure(stretch, scale, of_volume, pressure%right(:, p), pressure%left(:, p))
        if (.not. pressure%constant) call pack_gradient(strained(stretch, &
          unpack_gradient(pressure%resistance_by(:, p))), pressure%resistance_by(:, p))
        call leave_volume(stretch, of_volume, batch%tangent(:, :, p), pressure%left(:, p)/pressure%stiffness(p))
      else
        call leave_volume(stretch, of_volume, batch%tangent(:, :, p))
      end if
    end do
  end subroutine take_true_stress

  !> Converts A to dT/dH, without the effect of the volume on T.
  pure subroutine turn_tangent(stretch, piola, scale, tangent)
    real(wp), intent(in) :: stretch(3, 3), piola(3, 3)
    !> Divisor of T.
    real(wp), intent(in) :: scale
    real(wp), intent(inout) :: tangent(:, :)
    real(wp) :: turned(size(tangent, 1), size(tangent, 1)), along(3, 3), packed(size(tangent, 1))
    integer :: j, d

    d = merge(2, 3, size(tangent, 1) == 5)
    do j = 1, size(tangent, 1)
      along = 0.0_wp
      along(gradient_row(j, d), gradient_column(j, d)) = 1.0_wp
      along = strained(stretch, along)
      call pack_gradient(along, packed)
      call pack_gradient((product_of(unpack_gradient(matmul(tangent, packed)), stretch) &
        + product_of(piola, along))/scale, turned(:, j))
    end do
    tangent = turned
  end subroutine turn_tangent

  !> Subtracts the effect of the volume change, d ln J = (n - l/k) : dH at constant pressure, on T.
  pure subroutine leave_volume(stretch, of_volume, tangent, shared)
    !> U, and -dT/d ln J.
    real(wp), intent(in) :: stretch(3, 3), of_volume(3, 3)
    real(wp), intent(inout) :: tangent(:, :)
    !> l/k of a point that shares a pressure.
    real(wp), intent(in), optional :: shared(:)
    real(wp) :: volume(size(tangent, 1)), change(size(tangent, 1))
    integer :: j

    if (.not. any(abs(of_volume) > 0.0_wp)) return
    call pack_gradient(of_volume, change)
    call pack_gradient(0.25_wp*(stretch + inverse(stretch, determinant(stretch))) + 0.5_wp*identity, volume)
    if (present(shared)) volume = volume - shared
    do j = 1, size(tangent, 1)
      tangent(:, j) = tangent(:, j) - change*volume(j)
    end do
  end subroutine leave_volume

  !> Converts r and l of points with one pressure.
  pure subroutine turn_pressure(stretch, scale, of_volume, right, left)
    real(wp), intent(in) :: stretch(3, 3), scale, of_volume(3, 3)
    real(wp), intent(inout) :: right(:), left(:)

    call pack_gradient(product_of(unpack_gradient(right), stretch)/scale - of_volume, right)
    call pack_gradient(strained(stretch, unpack_gradient(left)), left)
  end subroutine turn_pressure

  !> Converts the derivatives of Q and with respect to F of a scalar of the law at U (qsmpm_nonlocal_strain) to those of
  !> T and with respect to H.
  pure subroutine turn_coupling(bounds_kirchhoff, gradient, of_stress, by_gradient)
    !> As declared by the law.
    logical, intent(in) :: bounds_kirchhoff
    !> U, packed.
    real(wp), intent(in) :: gradient(:)
    real(wp), intent(inout) :: of_stress(:), by_gradient(:)
    real(wp), parameter :: no_volume(3, 3) = 0.0_wp
    real(wp) :: scale

    scale = 1.0_wp
    if (.not. bounds_kirchhoff) scale = packed_determinant(gradient)
    call turn_pressure(unpack_gradient(gradient), scale, no_volume, of_stress, by_gradient)
  end subroutine turn_coupling

  !> Returns B sym(a) B: the change of U due to the strain, and the quantity conjugate to the strain for one conjugate
  !> to U.
  pure function strained(stretch, a) result(c)
    real(wp), intent(in) :: stretch(3, 3), a(3, 3)
    real(wp) :: c(3, 3), b(3, 3)

    b = 0.5_wp*(identity + stretch)
    c = matmul(b, matmul(0.5_wp*(a + transpose(a)), b))
  end function strained

  !> Returns whether a symmetric tensor with this determinant has only positive principal values.
  pure logical function is_positive(a, det)
    real(wp), intent(in) :: a(3, 3), det

    is_positive = a(1, 1) > 0.0_wp .and. a(1, 1)*a(2, 2) > a(1, 2)**2 .and. det > 0.0_wp
  end function is_positive

  !> Returns sym(a b), b symmetric.
  pure function product_of(a, b) result(c)
    real(wp), intent(in) :: a(3, 3), b(3, 3)
    real(wp) :: c(3, 3)

    c = matmul(a, b)
    c = 0.5_wp*(c + transpose(c))
  end function product_of
end module qsmpm_small_strain
