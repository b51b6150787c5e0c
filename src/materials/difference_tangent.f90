!> The tangent of a soil model by central differences of its stress.
module qsmpm_difference_tangent
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: status_ok
  use qsmpm_soil_model, only: soil_model_type, soil_increment_type, soil_response_type
  implicit none
  private

  public :: difference_tangent

  !> Change of a strain for differences: this share of the largest one, at the least of the smallest one.
  real(wp), parameter :: difference = 1.0e-4_wp, smallest = 1.0e-5_wp

contains

  !> Tangent by central differences of the model's stress; the model is asked for stress only.
  subroutine difference_tangent(model, increment, stress, state, response)
    class(soil_model_type), intent(in) :: model
    !> The step.
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress at the start, turned (6), and state at the start.
    real(wp), intent(in) :: stress(6)
    real(wp), intent(in) :: state(:)
    !> What the model says; its tangent is set.
    type(soil_response_type), intent(inout) :: response
    type(soil_increment_type) :: moved
    type(soil_response_type) :: said
    real(wp) :: ahead(6), back(6), own(size(state)), change(3, 3), h
    integer :: j

    moved = increment
    moved%wants_tangent = .false.
    moved%elastic_tangent = .false.
    h = difference*max(smallest, maxval(abs(increment%strain)))
    do j = 1, 6
      change = strained(j, increment%gradient_end)
      moved%strain(j) = increment%strain(j) + h
      moved%gradient_end = increment%gradient_end + h*change
      ahead = stress
      own = state
      call model%update(moved, ahead, own, said)
      moved%strain(j) = increment%strain(j) - h
      moved%gradient_end = increment%gradient_end - h*change
      back = stress
      own = state
      if (said%status == status_ok) call model%update(moved, back, own, said)
      moved%strain(j) = increment%strain(j)
      if (said%status /= status_ok) exit
      response%tangent(:, j) = (ahead - back)/(2.0_wp*h)
    end do
    if (said%status == status_ok) return
    response%status = said%status
    response%share = said%share
    if (allocated(said%message)) response%message = said%message
  end subroutine difference_tangent

  !> Change of a deformation gradient with a strain at its end.
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
