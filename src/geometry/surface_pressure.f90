!> Pressure on a surface as a function of height.
!>
!>   p = value + gradient (height - y),   0 where that of water is less
!>
!> with y the coordinate along the vertical; a pressure that increases with depth has a negative gradient if y points
!> along gravity.
module qsmpm_surface_pressure
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: surface_pressure_type, pressure_at, reached_pressure, acts

  type :: surface_pressure_type
    !> Pressure at the height, and its increase per length against the coordinate.
    real(wp) :: value = 0.0_wp, gradient = 0.0_wp, height = 0.0_wp
    !> There is no pressure above the height, where its value is 0.
    logical :: of_water = .false.
  end type surface_pressure_type

contains

  !> Pressure at a height.
  elemental real(wp) function pressure_at(pressure, y)
    type(surface_pressure_type), intent(in) :: pressure
    real(wp), intent(in) :: y

    pressure_at = 0.0_wp
    if (pressure%of_water .and. pressure%gradient*(pressure%height - y) < 0.0_wp) return
    pressure_at = pressure%value + pressure%gradient*(pressure%height - y)
  end function pressure_at

  !> Returns the pressure at a load fraction between two, neither of which is a water pressure unless they are equal.
  elemental type(surface_pressure_type) function reached_pressure(start, final, fraction) result(reached)
    type(surface_pressure_type), intent(in) :: start, final
    !> Load fraction, 0 to 1.
    real(wp), intent(in) :: fraction
    real(wp) :: before

    reached = final
    before = start%value + start%gradient*(start%height - final%height)
    reached%value = before + fraction*(final%value - before)
    reached%gradient = start%gradient + fraction*(final%gradient - start%gradient)
  end function reached_pressure

  !> Checks whether there is a pressure anywhere.
  elemental logical function acts(pressure)
    type(surface_pressure_type), intent(in) :: pressure

    ! Also for a value that is NaN.
    acts = .not. abs(pressure%value) + abs(pressure%gradient) <= 0.0_wp
  end function acts
end module qsmpm_surface_pressure
