!> Check of whether the initial stresses of a phase are within the strength of the materials.
!>
!> *INITIAL, TYPE=K0 sets stresses without evaluating the laws. A stress beyond the strength is returned to it by the
!> first step, which moves the soil before any load acts. This is detected at points without deformation: the law is
!> evaluated for a step with F = 1, and a stress that changes was not admissible. User-defined models are not checked.
module qsmpm_initial_strength
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: batch_type, tangent_none, status_ok
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: own_of
  use qsmpm_point_driver, only: prepare_point
  use qsmpm_tensor, only: identity, pack_gradient
  implicit none
  private

  public :: count_beyond_strength

  !> Relative change of a stress that is attributed to round-off.
  real(wp), parameter :: round_off = 1.0e-6_wp

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
        call prepare_point(law, batch)
        call pack_gradient(identity, batch%gradient(:, 1))
        batch%volume_ratio = 1.0_wp
        ! Creep takes place in zero time.
        batch%step_info%phase_time = 0.0_wp
        do p = 1, points%count
          if (points%material(p) /= m .or. .not. own(p)) cycle
          batch%stress_start(:, 1) = points%stress(:, p)
          batch%state_start(:, 1) = points%state(:law%state_count, p)
          call law%update(batch, tangent_none)
          if (batch%status(1) /= status_ok) cycle
          if (norm2(batch%stress(:, 1) - points%stress(:, p)) > round_off*norm2(points%stress(:, p))) &
            beyond(m) = beyond(m) + 1
        end do
      end associate
    end do
  end function count_beyond_strength
end module qsmpm_initial_strength
