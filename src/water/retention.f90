!> Water retention and relative permeability of soil under suction, linear over a height c or by curves of the soil.
!> The suction is s = -p; u = alpha s (van Genuchten 1980, equations 3 and 9, m = 1 - 1/n, after Mualem 1976):
!>
!>   S = 1 + p/c                           k_r = k_min + (1 - k_min) S,  in time, horizontally, S^3
!>   S = (1 + u^n)^(-m)                    k_r = S^(1/2) (1 - u^(n-1) S)^2,  no less than 1e-6
!>
!> S is the saturation of the drainable pores. For n < 2 the slope of k_r is unbounded at u = 0; below u = 0.01 k_r is
!> linear (Vogel and others 2001). Curves are limited in steepness to the height c, 1/alpha >= c.
module qsmpm_retention
  use qsmpm_kinds, only: wp
  use qsmpm_permeability_law, only: permeability_law_type
  use qsmpm_rounded_text, only: rounded_text
  implicit none
  private

  public :: curve_type, curve_of, take_up, let_through_in_time, relative, sharp_note

  !> Relative permeability of dry soil: linear law, and curve.
  real(wp), parameter :: least = 1.0e-3_wp, least_of_curve = 1.0e-6_wp
  !> Value of u up to which the permeability is linear; largest u whose powers do not overflow.
  real(wp), parameter :: straight = 1.0e-2_wp, far = 1.0e12_wp

  type :: curve_type
    !> Inverse of a pressure or of a height, in the unit of the pressures, 0 for the linear law; exponent n.
    real(wp) :: alpha = 0.0_wp, n = 2.0_wp
  end type curve_type

contains

  !> Returns the curve of a soil.
  elemental type(curve_type) function curve_of(law, unit_weight) result(curve)
    type(permeability_law_type), intent(in) :: law
    !> Unit weight of the water; 1 where pressures are heads.
    real(wp), intent(in) :: unit_weight

    curve = curve_type(law%alpha/unit_weight, law%n)
  end function curve_of

  !> Returns S at a pressure, and its derivative.
  elemental subroutine take_up(curve, pressure, reach, share, by_pressure)
    type(curve_type), intent(in) :: curve
    !> Both in the same unit; reach is c.
    real(wp), intent(in) :: pressure, reach
    real(wp), intent(out) :: share, by_pressure
    real(wp) :: alpha, u

    if (.not. curve%alpha > 0.0_wp) then
      share = max(0.0_wp, min(1.0_wp, 1.0_wp + pressure/reach))
      by_pressure = merge(1.0_wp/reach, 0.0_wp, pressure < 0.0_wp .and. pressure > -reach)
      return
    end if
    alpha = min(curve%alpha, 1.0_wp/reach)
    u = min(far, max(0.0_wp, -alpha*pressure))
    share = (1.0_wp + u**curve%n)**(1.0_wp/curve%n - 1.0_wp)
    by_pressure = (curve%n - 1.0_wp)*alpha*u**(curve%n - 1.0_wp)/(1.0_wp + u**curve%n)*share
  end subroutine take_up

  !> Returns k_r at a pressure by a curve, and its derivative.
  elemental subroutine permit(curve, pressure, reach, factor, by_pressure)
    type(curve_type), intent(in) :: curve
    !> Both in the same unit; reach is c.
    real(wp), intent(in) :: pressure, reach
    real(wp), intent(out) :: factor, by_pressure
    real(wp) :: alpha, u, at, share, slope, kept

    alpha = min(curve%alpha, 1.0_wp/reach)
    u = min(far, max(0.0_wp, -alpha*pressure))
    at = max(u, straight)
    call take_up(curve_type(1.0_wp, curve%n), -at, 1.0_wp, share, slope)
    kept = 1.0_wp - at**(curve%n - 1.0_wp)*share
    factor = sqrt(share)*kept**2
    by_pressure = alpha*kept/sqrt(share)*(0.5_wp*slope*kept + 2.0_wp*share*at**(curve%n - 2.0_wp) &
      *((curve%n - 1.0_wp)*share - at*slope))
    if (u < straight) then
      by_pressure = alpha*(1.0_wp - factor)/straight
      factor = 1.0_wp - u*by_pressure/alpha
    end if
    if (factor > least_of_curve .and. pressure < 0.0_wp) return
    factor = max(factor, least_of_curve)
    by_pressure = 0.0_wp
  end subroutine permit

  !> Returns k_r of a cell and its derivatives in a transient step. With a curve it is the mean of the corners, so that
  !> dry ground admits the water that wets it. With the linear law pressures are limited to -c, so that a dry corner
  !> obstructs no more than one that begins to fill. Vertically k_r is then linear in the saturation, as otherwise water
  !> would stay in the cell, horizontally its cube: the total flow in suction equals that of steady flow over half a
  !> cell.
  pure subroutine let_through_in_time(curve, pressure, reach, factor, by_pressure)
    type(curve_type), intent(in) :: curve
    !> Pressures of the corners and heights over which their pores fill, in the same unit.
    real(wp), intent(in) :: pressure(:), reach(:)
    !> Horizontally and vertically (2), (corners, 2).
    real(wp), intent(out) :: factor(2), by_pressure(:, :)
    real(wp) :: filling(size(pressure))

    if (curve%alpha > 0.0_wp) then
      call permit(curve, pressure, reach, filling, by_pressure(:, 1))
      factor = sum(filling)/size(filling)
      by_pressure = spread(by_pressure(:, 1)/size(filling), 2, 2)
      return
    end if
    filling = max(pressure, -reach)
    call relative(filling, sum(reach)/size(reach), [3, 1], factor, by_pressure)
    where (spread(pressure < -reach, 2, 2)) by_pressure = 0.0_wp
  end subroutine let_through_in_time

  !> Returns k_r of a cell by the linear law, averaged over its edge midpoints, and its derivatives.
  pure subroutine relative(pressure, width, power, factor, by_head)
    !> Pressure heads of the corners.
    real(wp), intent(in) :: pressure(:)
    real(wp), intent(in) :: width
    !> Exponents of the saturation, horizontally and vertically.
    integer, intent(in) :: power(2)
    !> (2), (corners, 2)
    real(wp), intent(out) :: factor(2), by_head(:, :)
    real(wp) :: filled, edges
    integer :: a, b, e, n

    factor = least
    by_head = 0.0_wp
    n = size(pressure)
    edges = 0.5_wp*n*(n - 1)
    do e = 1, n*(n - 1)/2
      ! The fifth and sixth edge of a tetrahedron join corners that are not consecutive.
      a = modulo(e - 1, n) + 1
      b = modulo(a + (e - 1)/n, n) + 1
      filled = max(0.0_wp, min(1.0_wp, 1.0_wp + 0.5_wp*(pressure(a) + pressure(b))/width))
      factor = factor + (1.0_wp - least)*filled**power/edges
      if (filled <= 0.0_wp .or. filled >= 1.0_wp) cycle
      by_head([a, b], :) = by_head([a, b], :) + spread((1.0_wp - least)*power*filled**(power - 1) &
        /(2.0_wp*edges*width), 1, 2)
    end do
  end subroutine relative

  !> Returns the warning of curves steeper than the cells resolve; empty where there is none.
  pure function sharp_note(phase, alpha, reach) result(text)
    character(len=*), intent(in) :: phase
    !> Values of alpha of the cells, and the smallest height over which each is resolved.
    real(wp), intent(in) :: alpha(:), reach(:)
    character(len=:), allocatable :: text
    integer :: worst

    text = ''
    if (.not. any(alpha*reach > 1.0_wp)) return
    worst = maxloc(alpha*reach, dim=1)
    text = "warning: phase '"//phase//"': soil of ALPHA="//rounded_text(alpha(worst))//' (*PERMEABILITY) retains '// &
      'water over less than a cell in part of the ground, and is modelled with ALPHA='// &
      rounded_text(1.0_wp/reach(worst), 2)//' there: closer grid lines resolve its own curve'//new_line('a')
  end function sharp_note
end module qsmpm_retention
