!> Parameters of undrained soil as plain data, and the stiffness of its pore water.
!>
!> The pore water resists changes of volume in addition to the soil skeleton (G, nu of the effective stress):
!>   K_w/n = (2G/3) [(1 + nu_u)/(1 - 2 nu_u) - (1 + nu)/(1 - 2 nu)],
!> nu_u the undrained ratio, or from Skempton's B = (K_w/n)/(K_w/n + K'):
!>   nu_u = [3 nu + B (1 - 2 nu)]/[3 - B (1 - 2 nu)]
!> (Potts and Zdravkovic 1999, section 3.4). A: effective strength. B: effective stiffness, s_u as strength. C: total
!> stress, stiffness with the same G and nu_u, strength s_u, no pore pressure.
module qsmpm_undrained_parameters
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: undrained_type, is_undrained, undrained_ratio, water_stiffness

  !> Types, numbered as the choices of the keyword.
  integer, parameter, public :: undrained_a = 1, undrained_b = 2, undrained_c = 3
  !> Behaviour of the pore water in a phase: undrained; dissipation of the excess pressure in proportion to the load
  !> fraction, to zero at the end; constant excess pressure.
  integer, parameter, public :: drainage_none = 0, drainage_dissipates = 1, drainage_keeps = 2

  !> Undrained behaviour of a material.
  type :: undrained_type
    logical :: given = .false.
    integer :: kind = undrained_a
    !> nu_u; Skempton's B is used instead if positive.
    real(wp) :: poisson = 0.495_wp
    real(wp) :: skempton = -1.0_wp
    !> Whether the effective strength may be dilatant.
    logical :: dilatant = .false.
    !> One of drainage_* of each phase; unallocated: undrained in all phases (phases).
    integer, allocatable :: drainage(:)
  end type undrained_type

contains

  !> Returns whether soil is undrained in a phase: *DRAIN STATE may drain it.
  pure logical function is_undrained(undrained, phase)
    type(undrained_type), intent(in) :: undrained
    !> Number of the phase.
    integer, intent(in) :: phase

    is_undrained = undrained%given
    if (is_undrained .and. allocated(undrained%drainage)) is_undrained = undrained%drainage(phase) == drainage_none
  end function is_undrained

  !> Undrained ratio nu_u of a skeleton with nu.
  pure real(wp) function undrained_ratio(undrained, poisson) result(ratio)
    type(undrained_type), intent(in) :: undrained
    real(wp), intent(in) :: poisson
    real(wp) :: share

    ratio = undrained%poisson
    if (.not. undrained%skempton > 0.0_wp) return
    share = undrained%skempton*(1.0_wp - 2.0_wp*poisson)
    ratio = (3.0_wp*poisson + share)/(3.0_wp - share)
  end function undrained_ratio

  !> K_w/n of a skeleton with shear modulus and nu; not positive where nu_u is not above nu.
  pure real(wp) function water_stiffness(undrained, shear, poisson) result(stiffness)
    type(undrained_type), intent(in) :: undrained
    real(wp), intent(in) :: shear, poisson
    real(wp) :: ratio

    ratio = undrained_ratio(undrained, poisson)
    stiffness = 2.0_wp*shear/3.0_wp*((1.0_wp + ratio)/(1.0_wp - 2.0_wp*ratio) &
      - (1.0_wp + poisson)/(1.0_wp - 2.0_wp*poisson))
  end function water_stiffness
end module qsmpm_undrained_parameters
