!> Functions common to the plane and the solid form of the logarithmic law: limits of b, artanh(x)/x and sinh.
!>
!> With x = (b_a - b_b)/(b_a + b_b) of two principal values artanh(x) is the difference of their
!> logarithmic strains, and g = artanh(x)/x the ratio of the shear stiffness to the shear modulus.
module qsmpm_logarithmic_series
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: artanh_terms, short_sinh

  !> Admissible range of the principal values of b; outside of it the step is cut.
  real(wp), parameter, public :: smallest_b = 1.0e-30_wp, largest_b = 1.0e30_wp
  !> x^2 up to which g is computed by its series: the terms of `artanh_terms` have an error of 1e-16.
  real(wp), parameter, public :: series_limit = 0.0036_wp

contains

  !> (g - 1)/y = 1/3 + y/5 + y^2/7 + ..., y = x^2 up to `series_limit`.
  pure real(wp) function artanh_terms(y)
    !> x^2.
    real(wp), intent(in) :: y

    ! Grouped in pairs that can be evaluated independently.
    artanh_terms = (1.0_wp/3.0_wp + 0.2_wp*y) + y*y*((1.0_wp/7.0_wp + (1.0_wp/9.0_wp)*y) &
      + y*y*(1.0_wp/11.0_wp + (1.0_wp/13.0_wp)*y))
  end function artanh_terms

  !> sinh(d), by its series where d is small, as elastic strains are: the error is 1e-18.
  pure real(wp) function short_sinh(d)
    real(wp), intent(in) :: d
    real(wp) :: y

    y = d*d
    if (y <= series_limit) then
      short_sinh = d*(1.0_wp + y*((1.0_wp/6.0_wp) + y*((1.0_wp/120.0_wp) + y*((1.0_wp/5040.0_wp) &
        + y*(1.0_wp/362880.0_wp)))))
    else
      short_sinh = sinh(d)
    end if
  end function short_sinh
end module qsmpm_logarithmic_series
