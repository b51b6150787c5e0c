!> A law that applies the deformation of a step in two halves: the same law, the same start and end, one
!> more point on the path. The difference between its result and that of the law itself measures the error
!> due to the length of the step (qsmpm_step_error): zero in hyperelasticity, otherwise the error of the
!> return mapping or of the stress rate.
!>
!> The displacement is halved: F_1 = 1 + (F - 1)/2, then F_2 = F F_1^-1, and the stress at the end is
!> referred to the start of the whole step, Q = J sigma F^-T with J = det F.
module qsmpm_half_step_law
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type, batch_type, status_ok, tangent_none, outer_law_type
  use qsmpm_tensor, only: determinant, inverse, unpack_gradient, pack_gradient, unpack_symmetric, identity
  implicit none
  private

  public :: half_step_law_type, make_half_step_law

  !> A law with halved steps.
  type, extends(outer_law_type) :: half_step_law_type
  contains
    procedure :: update
  end type half_step_law_type

contains

  !> Makes the law with halved steps of a law.
  subroutine make_half_step_law(law, halved)
    class(law_type), intent(in) :: law
    !> The same law, each step in two halves.
    type(half_step_law_type), intent(out) :: halved

    allocate (halved%law, source=law)
    halved%law_traits_type = law%law_traits_type
  end subroutine make_half_step_law

  !> Updates a batch in two halves. A requested tangent is that of the whole step: the balance of pressures that uses it
  !> (qsmpm_pressure_balance) needs an approximate slope only.
  subroutine update(self, batch, tangent)
    class(half_step_law_type), intent(in) :: self
    type(batch_type), intent(inout) :: batch
    !> tangent_none, tangent_consistent or tangent_elastic.
    integer, intent(in) :: tangent
    type(batch_type) :: half
    real(wp) :: f(3, 3), det
    integer :: p

    if (tangent /= tangent_none) then
      call self%law%update(batch, tangent)
      if (any(batch%status(:batch%count) /= status_ok)) return
    end if
    half = batch
    half%step_info%duration = 0.5_wp*batch%step_info%duration
    do p = 1, batch%count
      if (determinant(unpack_gradient(batch%gradient(:, p))) > 0.0_wp) &
        call pack_gradient(first_half(batch%gradient(:, p)), half%gradient(:, p))
    end do
    call self%law%update(half, tangent_none)
    do p = 1, batch%count
      if (half%status(p) /= status_ok) cycle
      call start_second_half(batch%gradient(:, p), batch%volume_ratio(p), half, p)
    end do
    batch%status(:batch%count) = half%status(:batch%count)
    batch%plastic(:batch%count) = half%plastic(:batch%count)
    if (any(batch%status(:batch%count) /= status_ok)) return
    half%step_info%start = batch%step_info%start + half%step_info%duration
    call self%law%update(half, tangent_none)
    do p = 1, batch%count
      batch%status(p) = half%status(p)
      batch%plastic(p) = max(batch%plastic(p), half%plastic(p))
      if (batch%status(p) /= status_ok) cycle
      batch%stress(:, p) = half%stress(:, p)
      batch%state(:, p) = half%state(:, p)
      ! Q with respect to the start of the whole step.
      f = unpack_gradient(batch%gradient(:, p))
      det = determinant(f)
      call pack_gradient(det*matmul(unpack_symmetric(half%stress(:, p)), transpose(inverse(f, det))), &
        batch%piola(:, p))
    end do
  end subroutine update

  !> F_1 of half the displacement; its determinant is positive if that of F is.
  pure function first_half(gradient) result(half)
    !> F, packed (5 or 9).
    real(wp), intent(in) :: gradient(:)
    real(wp) :: half(3, 3)

    half = 0.5_wp*(identity + unpack_gradient(gradient))
  end function first_half

  !> Sets the start of the second half to the end of the first.
  pure subroutine start_second_half(gradient, volume_ratio, half, p)
    !> F of the whole step, packed (5 or 9); volume ratio at the start of the step.
    real(wp), intent(in) :: gradient(:), volume_ratio
    !> The points after their first half.
    type(batch_type), intent(inout) :: half
    !> Number of the point.
    integer, intent(in) :: p
    real(wp) :: f(3, 3), f_first(3, 3), back(3, 3), det

    f = unpack_gradient(gradient)
    f_first = first_half(gradient)
    det = determinant(f_first)
    back = inverse(f_first, det)
    call pack_gradient(matmul(f, back), half%gradient(:, p))
    half%volume_ratio(p) = volume_ratio*det
    half%stress_start(:, p) = half%stress(:, p)
    half%state_start(:, p) = half%state(:, p)
  end subroutine start_second_half
end module qsmpm_half_step_law
