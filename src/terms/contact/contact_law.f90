!> Pressure and shear of a patch in contact by an augmented Lagrangian method, a penalty with a multiplier stored from
!> step to step, and Coulomb's limit with adhesion.
!>
!>   p = max(0, lambda - eps g)                       g   mean gap, lambda pressure of the previous step
!>   t* = t_0 - eps_t s,   |t| <= mu (p - w) + a(p)   s   mean slip in the step, t_0 shear of the previous step,
!>                                                    w   pore pressure there, part of p: p - w is no less than 0
!>
!> With the pressure of one step as the multiplier of the next the penetration decreases from step to step for any
!> penalty. A contact with tension does not bound p. Any other contact loses its adhesion where it opens, continuously,
!> a(p) = a min(1, p/0.01 a): otherwise patches with nearly no pressure would have no equilibrium. Suction, w < 0, is
!> such an adhesion of -mu w.
!> docs/methods/contact.md; the augmented Lagrangian form of friction is that of Simo and Laursen (1992).
module qsmpm_contact_law
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: contact_pair_type
  use qsmpm_tensor, only: identity
  implicit none
  private

  public :: tractions_type, contact_tractions

  !> Ratio of pressure to adhesion above which the full adhesion acts.
  real(wp), parameter :: sticks = 0.01_wp

  type :: tractions_type
    logical :: closed = .false., slips = .false.
    real(wp) :: pressure = 0.0_wp
    !> Shear of the body on the soil.
    real(wp) :: shear(3) = 0.0_wp
    !> dp/dg; dt/ds; dt/dp; dt/dw.
    real(wp) :: by_gap = 0.0_wp, by_slip(3, 3) = 0.0_wp, by_pressure(3) = 0.0_wp, by_water(3) = 0.0_wp
  end type tractions_type

contains

  !> Returns the tractions of a patch and their derivatives.
  pure type(tractions_type) function contact_tractions(pair, penalty, multiplier, shear_before, gap, slip, touching, &
    water) result(now)
    type(contact_pair_type), intent(in) :: pair
    !> eps, eps_t [stress/length].
    real(wp), intent(in) :: penalty(2)
    !> lambda, t_0, g, s.
    real(wp), intent(in) :: multiplier, shear_before(3), gap, slip(3)
    !> Gap that is zero except for rounding: soil that initially touches the body is resisted by it from the first
    !> iteration on.
    real(wp), intent(in) :: touching
    !> Pore pressure at the contact where it is a part of the pressure of the contact.
    real(wp), intent(in) :: water
    real(wp) :: slope, friction, adhesion, by_water, trial(3), limit, size_of_trial, direction(3)
    integer :: j

    now%pressure = multiplier - penalty(1)*gap
    now%closed = pair%tension .or. now%pressure > -penalty(1)*touching
    if (.not. pair%tension) now%pressure = max(0.0_wp, now%pressure)
    if (.not. now%closed) return
    now%by_gap = -penalty(1)
    adhesion = pair%adhesion + pair%friction*max(0.0_wp, -water)
    friction = merge(pair%friction, 0.0_wp, now%pressure > max(0.0_wp, water))
    limit = adhesion
    slope = friction
    by_water = -merge(pair%friction, friction, water < 0.0_wp)
    if (.not. pair%tension .and. now%pressure < sticks*adhesion) then
      limit = now%pressure/sticks
      slope = slope + 1.0_wp/sticks
      if (water < 0.0_wp) by_water = 0.0_wp
    end if
    limit = limit + friction*(now%pressure - max(0.0_wp, water))
    trial = shear_before - penalty(2)*slip
    if (.not. limit > 0.0_wp) then
      ! A touching patch without tractions also resists slip in the first iteration.
      if (pair%friction + pair%adhesion > 0.0_wp .and. .not. any(abs(trial) > 0.0_wp)) &
        now%by_slip = -penalty(2)*identity
      return
    end if
    size_of_trial = norm2(trial)
    now%slips = size_of_trial > limit
    if (.not. now%slips) then
      now%shear = trial
      now%by_slip = -penalty(2)*identity
      return
    end if
    direction = trial/size_of_trial
    now%shear = limit*direction
    do j = 1, 3
      now%by_slip(:, j) = -penalty(2)*limit/size_of_trial*(identity(:, j) - direction*direction(j))
    end do
    now%by_water = by_water*direction
    if (now%pressure > 0.0_wp) now%by_pressure = slope*direction
  end function contact_tractions
end module qsmpm_contact_law
