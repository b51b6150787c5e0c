!> Steps of small strain, whose places stay (GEOMETRY=FIXED of safety phases): forces are those of the true stress on
!> the body as it stood, however far the step moves it, so that equilibrium is one of the undeformed body.
!>
!> The law is called at the stretch U = I + (H + H^T)/2 of the displacement gradient H, and its answer Q, A at U becomes
!>   T = sym(Q U),   dT = sym(A:dU U + Q dU),   dU = (dH + dH^T)/2
!> in its place: the stress per unit of the volume at the start, which laws bound that bound the Kirchhoff stress; of
!> others the Cauchy stress T/det U. Where laws are symmetric dT is made so; it is at U = I.
module qsmpm_small_strain
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: batch_type, law_slot_type
  use qsmpm_pressure_balance, only: packed_determinant, pressure_type
  use qsmpm_tensor, only: gradient_index, gradient_row, gradient_column, identity, pack_gradient, unpack_gradient
  implicit none
  private

  public :: take_stretch, take_true_stress

contains

  !> F of the points becomes U.
  pure subroutine take_stretch(batch)
    type(batch_type), intent(inout) :: batch
    integer :: p

    do p = 1, batch%count
      call make_symmetric(batch%gradient(:, p))
    end do
  end subroutine take_stretch

  !> Q and A of the points become T and dT/dH, the stress that is kept the one which is in equilibrium.
  pure subroutine take_true_stress(slot, symmetric, with_tangent, batch, pressure)
    !> Law of the points.
    type(law_slot_type), intent(in) :: slot
    !> The tangent is to be symmetric, and is wanted.
    logical, intent(in) :: symmetric, with_tangent
    type(batch_type), intent(inout) :: batch
    !> What the law was called at, where the points share a pressure: r and l become what belongs to dT.
    type(pressure_type), intent(inout), optional :: pressure
    real(wp) :: stretch(3, 3), piola(3, 3), volume
    integer :: p

    do p = 1, batch%count
      stretch = unpack_gradient(batch%gradient(:, p))
      if (present(pressure)) stretch = unpack_gradient(pressure%gradient(:, p))
      volume = packed_determinant(batch%gradient(:, p))
      piola = unpack_gradient(batch%piola(:, p))
      call pack_gradient(product_of(piola, stretch), batch%piola(:, p))
      if (slot%law%bounds_kirchhoff) then
        batch%stress(:, p) = volume*batch%stress(:, p)
        call pack_gradient(unpack_gradient(batch%piola(:, p)) - slot%confinement*(volume - 1.0_wp)*identity, &
          batch%piola(:, p))
      else
        batch%piola(:, p) = batch%piola(:, p)/volume
      end if
      if (.not. with_tangent) cycle
      call turn_tangent(stretch, piola, batch%tangent(:, :, p))
      if (.not. slot%law%bounds_kirchhoff) call leave_volume(volume, batch%piola(:, p), batch%tangent(:, :, p))
      if (symmetric) batch%tangent(:, :, p) = 0.5_wp*(batch%tangent(:, :, p) + transpose(batch%tangent(:, :, p)))
      if (present(pressure)) call turn_pressure(stretch, merge(1.0_wp, volume, slot%law%bounds_kirchhoff), symmetric, &
        pressure%right(:, p), pressure%left(:, p))
    end do
  end subroutine take_true_stress

  !> A becomes dT/dH.
  pure subroutine turn_tangent(stretch, piola, tangent)
    real(wp), intent(in) :: stretch(3, 3), piola(3, 3)
    real(wp), intent(inout) :: tangent(:, :)
    real(wp) :: turned(size(tangent, 1), size(tangent, 1)), along(size(tangent, 1)), change(size(tangent, 1))
    integer :: j, mirror

    do j = 1, size(tangent, 1)
      mirror = mirrored(j, size(tangent, 1))
      along = 0.0_wp
      along(j) = 0.5_wp
      along(mirror) = along(mirror) + 0.5_wp
      change = 0.5_wp*(tangent(:, j) + tangent(:, mirror))
      call pack_gradient(product_of(unpack_gradient(change), stretch) &
        + product_of(piola, unpack_gradient(along)), turned(:, j))
    end do
    tangent = turned
  end subroutine turn_tangent

  !> T and dT of a law that bounds the Cauchy stress.
  pure subroutine leave_volume(volume, stress, tangent)
    real(wp), intent(in) :: volume, stress(:)
    real(wp), intent(inout) :: tangent(:, :)
    integer :: i, j

    tangent = tangent/volume
    do i = 1, 3
      j = gradient_index(i, i, merge(2, 3, size(stress) == 5))
      tangent(:, j) = tangent(:, j) - stress
    end do
  end subroutine leave_volume

  !> r and l of points under one pressure.
  pure subroutine turn_pressure(stretch, volume, symmetric, right, left)
    real(wp), intent(in) :: stretch(3, 3), volume
    logical, intent(in) :: symmetric
    real(wp), intent(inout) :: right(:), left(:)

    call pack_gradient(product_of(unpack_gradient(right), stretch)/volume, right)
    call make_symmetric(left)
    if (symmetric) left = right
  end subroutine turn_pressure

  !> sym(a b), b symmetric.
  pure function product_of(a, b) result(c)
    real(wp), intent(in) :: a(3, 3), b(3, 3)
    real(wp) :: c(3, 3)

    c = matmul(a, b)
    c = 0.5_wp*(c + transpose(c))
  end function product_of

  !> The symmetric part of a packed tensor.
  pure subroutine make_symmetric(a)
    real(wp), intent(inout) :: a(:)
    integer :: j, mirror

    do j = 1, size(a)
      mirror = mirrored(j, size(a))
      if (mirror > j) a([j, mirror]) = 0.5_wp*(a(j) + a(mirror))
    end do
  end subroutine make_symmetric

  !> Packed place of the transposed component.
  pure integer function mirrored(j, components)
    integer, intent(in) :: j, components
    integer :: d

    d = merge(2, 3, components == 5)
    mirrored = gradient_index(gradient_column(j, d), gradient_row(j, d), d)
  end function mirrored
end module qsmpm_small_strain
