!> Variation of the permeability of soil with its void ratio e; e_0 is the void ratio of the permeability in the deck.
!>
!>   Kozeny and Carman   k/k_0 = (e/e_0)^3 (1 + e_0)/(1 + e)
!>   logarithm           log k/k_0 = (e - e_0)/C_k,  C_k about e_0/2 of clays (Taylor 1948; Tavenas and others 1983)
!>
!> e = (1 + e_0) J - 1 with J the volume over that at the start.
module qsmpm_permeability_law
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: permeability_law_type, permeability_ratio, permeability_slope

  !> Laws and their words in the deck.
  integer, parameter, public :: permeability_constant = 1, permeability_kozeny = 2, permeability_logarithm = 3
  character(len=9), parameter, public :: permeability_words(3) = [character(len=9) :: 'CONSTANT', 'KOZENY', 'LOGARITHM']

  type :: permeability_law_type
    integer :: kind = permeability_constant
    !> e_0 and C_k; 0 if not given.
    real(wp) :: void_ratio = 0.0_wp, index = 0.0_wp
    !> Parameters of the retention curve (qsmpm_retention): alpha as 1 over a height, 0 for none, and n.
    real(wp) :: alpha = 0.0_wp, n = 0.0_wp
  end type permeability_law_type

contains

  !> Returns the ratio of the permeability to the initial one; zero without voids.
  elemental real(wp) function permeability_ratio(law, stretch) result(ratio)
    type(permeability_law_type), intent(in) :: law
    !> J.
    real(wp), intent(in) :: stretch
    real(wp) :: e

    e = max(0.0_wp, (1.0_wp + law%void_ratio)*stretch - 1.0_wp)
    select case (law%kind)
    case (permeability_kozeny)
      ratio = (e/law%void_ratio)**3*(1.0_wp + law%void_ratio)/(1.0_wp + e)
    case (permeability_logarithm)
      ratio = 10.0_wp**((e - law%void_ratio)/law%index)
    case default
      ratio = 1.0_wp
    end select
  end function permeability_ratio

  !> Returns the derivative of the ratio with respect to the volume ratio.
  elemental real(wp) function permeability_slope(law, stretch) result(slope)
    type(permeability_law_type), intent(in) :: law
    !> J.
    real(wp), intent(in) :: stretch
    real(wp) :: e

    slope = 0.0_wp
    e = (1.0_wp + law%void_ratio)*stretch - 1.0_wp
    if (law%kind == permeability_constant .or. e < 0.0_wp) return
    slope = permeability_ratio(law, stretch)*(1.0_wp + law%void_ratio)
    if (law%kind == permeability_logarithm) then
      slope = slope*log(10.0_wp)/law%index
    else
      slope = slope*(3.0_wp/max(e, tiny(e)) - 1.0_wp/(1.0_wp + e))
    end if
  end function permeability_slope
end module qsmpm_permeability_law
