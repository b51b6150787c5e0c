!> Initial stresses and the strength of the materials.
!>
!> *INITIAL, TYPE=K0 gives stresses without evaluating the laws. A stress that a law changes in a step without
!> deformation (F = 1) is beyond its strength. The horizontal stress of K0 is then limited to the one nearest to it, for
!> the same vertical stress, that the law carries: the active or the passive state. Other initial stresses are counted;
!> the first step returns them to the strength, which moves the soil before any load acts. User-defined models are not
!> evaluated.
module qsmpm_initial_strength
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type, batch_type, tangent_none, status_ok
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: own_of
  use qsmpm_point_driver, only: prepare_point
  use qsmpm_tensor, only: identity, pack_gradient
  implicit none
  private

  public :: count_beyond_strength, limit_horizontal, round_off

  !> Relative change of a stress that is attributed to round-off.
  real(wp), parameter :: round_off = 1.0e-6_wp
  !> Halvings of the interval of horizontal stresses.
  integer, parameter :: halvings = 40

contains

  !> Returns the number of owned material points of each material whose stress changes without deformation.
  function count_beyond_strength(model) result(beyond)
    !> The model at the start of a phase.
    type(model_type), intent(in) :: model
    integer :: beyond(size(model%laws))
    type(batch_type) :: batch
    logical :: own(model%state%points%count)
    integer :: p, m

    beyond = 0
    own = own_of(model%part%points, model%state%points%count)
    do m = 1, size(model%laws)
      if (model%analysis%materials(m)%user%given) cycle
      associate (law => model%laws(m)%law, points => model%state%points)
        call prepare_undeformed(law, batch)
        do p = 1, points%count
          if (points%material(p) /= m .or. .not. own(p)) cycle
          batch%state_start(:, 1) = points%state(:law%state_count, p)
          if (exceeds_strength(law, points%stress(:, p), batch)) beyond(m) = beyond(m) + 1
        end do
      end associate
    end do
  end function count_beyond_strength

  !> Limits the horizontal stress at a place to the strength: bisection between it and the vertical stress. Unchanged
  !> if the vertical stress alone, as an isotropic one, is beyond the strength (tension).
  subroutine limit_horizontal(law, place, axis, stress)
    class(law_type), intent(in) :: law
    !> Position (3).
    real(wp), intent(in) :: place(3)
    !> Number of the vertical axis.
    integer, intent(in) :: axis
    !> Effective stress (4 or 6) without shear.
    real(wp), intent(inout) :: stress(:)
    type(batch_type) :: batch
    real(wp) :: low, high, middle
    integer :: i

    call prepare_undeformed(law, batch)
    if (is_within(1.0_wp)) return
    if (.not. is_within(0.0_wp)) return
    low = 0.0_wp
    high = 1.0_wp
    do i = 1, halvings
      middle = 0.5_wp*(low + high)
      if (is_within(middle)) then
        low = middle
      else
        high = middle
      end if
    end do
    stress = between(low)

  contains

    !> Returns whether the law carries the stress at a share of the difference from the isotropic one.
    logical function is_within(share)
      real(wp), intent(in) :: share

      call law%start_at(between(share), place, batch%state_start(:, 1))
      is_within = .not. exceeds_strength(law, between(share), batch)
    end function is_within

    !> Returns the stress at a share of the difference from the isotropic one.
    pure function between(share)
      real(wp), intent(in) :: share
      real(wp) :: between(size(stress))

      between = 0.0_wp
      between(:3) = stress(axis) + share*(stress(:3) - stress(axis))
    end function between
  end subroutine limit_horizontal

  !> Prepares a batch of one point for a step without deformation.
  subroutine prepare_undeformed(law, batch)
    class(law_type), intent(in) :: law
    type(batch_type), intent(out) :: batch

    call prepare_point(law, batch)
    call pack_gradient(identity, batch%gradient(:, 1))
    batch%volume_ratio = 1.0_wp
    ! No time passes, so that nothing creeps.
    batch%step_info%phase_time = 0.0_wp
  end subroutine prepare_undeformed

  !> Returns whether a law changes a stress in a step without deformation.
  logical function exceeds_strength(law, stress, batch)
    class(law_type), intent(in) :: law
    !> (4 or 6)
    real(wp), intent(in) :: stress(:)
    !> The prepared batch with the state of the point.
    type(batch_type), intent(inout) :: batch

    batch%stress_start(:, 1) = stress
    call law%update(batch, tangent_none)
    exceeds_strength = batch%status(1) == status_ok
    if (exceeds_strength) exceeds_strength = norm2(batch%stress(:, 1) - stress) > round_off*norm2(stress)
  end function exceeds_strength
end module qsmpm_initial_strength
