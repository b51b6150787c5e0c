!> The tangent of a soil model by central differences of its stress.
!>
!> The strain is changed by a share of the increment. A model that integrates by substeps with error control responds to
!> small changes with jumps: where the second difference is not small compared with the first one, the change is
!> increased until it is, so that the jumps do not enter the tangent.
module qsmpm_difference_tangent
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: status_ok
  use qsmpm_soil_model, only: soil_model_type, soil_increment_type, soil_response_type
  implicit none
  private

  public :: difference_tangent

  !> Change of a strain component: this share of the largest one, at least of the smallest value; the factor of its
  !> increase and the largest number of increases, with which it remains within the increment.
  real(wp), parameter :: difference = 1.0e-4_wp, smallest = 1.0e-5_wp, growth = 30.0_wp
  integer, parameter :: most_growths = 2
  !> Ratio of the second to the first difference up to which it is not regarded as noise.
  real(wp), parameter :: smooth = 0.1_wp

contains

  !> Computes the tangent by central differences of the model's stress; the model is called for the stress only.
  subroutine difference_tangent(model, increment, stress, state, response)
    class(soil_model_type), intent(in) :: model
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress at the start, rotated (6), and state at the start.
    real(wp), intent(in) :: stress(6), state(:)
    !> Response of the model; its tangent is set.
    type(soil_response_type), intent(inout) :: response
    type(soil_response_type) :: said
    real(wp) :: middle(6), ahead(6), back(6), share
    integer :: j, growths

    middle = stress_there(model, increment, stress, state, 1, 0.0_wp, said)
    share = difference
    growths = merge(0, most_growths, any(abs(increment%strain) > 0.0_wp))
    do j = 1, 6
      do
        associate (h => share*max(smallest, maxval(abs(increment%strain))))
          if (said%status == status_ok) ahead = stress_there(model, increment, stress, state, j, h, said)
          if (said%status == status_ok) back = stress_there(model, increment, stress, state, j, -h, said)
          if (said%status /= status_ok) exit
          response%tangent(:, j) = (ahead - back)/(2.0_wp*h)
        end associate
        if (growths == 0 .or. .not. is_noise(ahead, middle, back)) exit
        growths = growths - 1
        share = growth*share
      end do
      if (said%status /= status_ok) exit
    end do
    if (said%status == status_ok) return
    response%status = said%status
    response%share = said%share
    if (allocated(said%message)) response%message = said%message
  end subroutine difference_tangent

  !> Whether differences of finite numbers show jumps.
  pure logical function is_noise(ahead, middle, back)
    real(wp), intent(in) :: ahead(6), middle(6), back(6)

    is_noise = all(ieee_is_finite(ahead + middle + back))
    if (is_noise) is_noise = maxval(abs(ahead - 2.0_wp*middle + back)) > smooth*maxval(abs(ahead - back))
  end function is_noise

  !> Stress at the end of a step in which a component of the strain is changed.
  function stress_there(model, increment, stress, state, component, change, said) result(there)
    class(soil_model_type), intent(in) :: model
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress at the start, rotated (6), and state at the start.
    real(wp), intent(in) :: stress(6), state(:)
    !> Component of the strain, and its change.
    integer, intent(in) :: component
    real(wp), intent(in) :: change
    type(soil_response_type), intent(inout) :: said
    type(soil_increment_type) :: moved
    real(wp) :: there(6), own(size(state))

    moved = increment
    moved%wants_tangent = .false.
    moved%elastic_tangent = .false.
    moved%strain(component) = increment%strain(component) + change
    moved%gradient_end = increment%gradient_end + change*strained(component, increment%gradient_end)
    there = stress
    own = state
    call model%update(moved, there, own, said)
  end function stress_there

  !> Change of a deformation gradient due to a strain at its end.
  pure function strained(component, gradient) result(change)
    !> Component of the strain, shear gamma.
    integer, intent(in) :: component
    !> Deformation gradient (3,3).
    real(wp), intent(in) :: gradient(3, 3)
    real(wp) :: change(3, 3)
    integer, parameter :: row(6) = [1, 2, 3, 1, 1, 2], column(6) = [1, 2, 3, 2, 3, 3]

    change = 0.0_wp
    change(row(component), :) = 0.5_wp*gradient(column(component), :)
    change(column(component), :) = change(column(component), :) + 0.5_wp*gradient(row(component), :)
  end function strained
end module qsmpm_difference_tangent
