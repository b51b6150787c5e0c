!> Variation of a load between its values at the start and the end of a phase: linear.
module qsmpm_load_path
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: between

contains

  !> Interpolates linearly between two values.
  elemental real(wp) function between(start, final, fraction)
    real(wp), intent(in) :: start, final
    !> Load fraction of the phase, 0 to 1.
    real(wp), intent(in) :: fraction

    between = start + fraction*(final - start)
  end function between
end module qsmpm_load_path
