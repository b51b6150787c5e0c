!> The vertical direction of a scene, from the gravity of its phases.
module qsmpm_vertical
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  implicit none
  private

  public :: vertical_of, upwards

contains

  !> Returns the axis along which gravity is largest in any phase; y without gravity.
  pure integer function vertical_of(analysis) result(axis)
    type(analysis_type), intent(in) :: analysis
    real(wp) :: gravity(3)
    integer :: p

    gravity = 0.0_wp
    do p = 1, size(analysis%phases)
      gravity = max(gravity, abs(analysis%phases(p)%load_factor*analysis%phases(p)%gravity%vector))
    end do
    axis = 2
    if (any(gravity > 0.0_wp)) axis = maxloc(gravity, dim=1)
  end function vertical_of

  !> Returns the upward direction, opposite to the gravity of the first phase with gravity: 1 if its coordinate
  !> increases upwards, as without gravity, otherwise -1.
  pure real(wp) function upwards(analysis) result(up)
    type(analysis_type), intent(in) :: analysis
    integer :: p, axis

    up = 1.0_wp
    axis = vertical_of(analysis)
    do p = size(analysis%phases), 1, -1
      associate (pull => analysis%phases(p)%load_factor*analysis%phases(p)%gravity%vector(axis))
        if (abs(pull) > 0.0_wp) up = -sign(1.0_wp, pull)
      end associate
    end do
  end function upwards
end module qsmpm_vertical
