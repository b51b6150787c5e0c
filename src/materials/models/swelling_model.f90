!> Clay on its swelling line: elasticity with a bulk modulus that increases with the pressure.
!>
!>   p = pmin exp(e/k), e the elastic volume strain, compression positive; below pmin the tangent at that point,
!>   p = pmin (1 + e/k), so that a point without stress has stiffness;   s = 2 G dev(strain)
!> with k the slope of the line in volume strain over ln p. G is given, or is a ratio of K(p) with p at the start of the
!> step. Yield and creep are left to the models that extend it (qsmpm_cam_clay, qsmpm_soft_soil_creep).
module qsmpm_swelling_model
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: status_ok, status_cut
  use qsmpm_principal_model, only: principal_model_type, stress_update_type, elastic_map
  implicit none
  private

  public :: swelling_line_type, swelling_model_type, make_line, pressure_of, strain_of

  !> Largest exponent in the pressure of a trial strain.
  real(wp), parameter, public :: largest_exponent = 200.0_wp

  !> A swelling line.
  type :: swelling_line_type
    !> k, pmin, and 1/k.
    real(wp) :: swelling = 1.0_wp, smallest = 1.0_wp, by_swelling = 1.0_wp
  end type swelling_line_type

  !> A model with this elasticity.
  type, extends(principal_model_type), abstract :: swelling_model_type
    type(swelling_line_type) :: line
    !> G/K if positive, otherwise G is constant.
    real(wp) :: shear_ratio = 0.0_wp
  contains
    procedure :: shear_modulus
    procedure :: elastic_strain
    procedure :: elastic_update
  end type swelling_model_type

contains

  !> Sets slope and smallest pressure of a line, both positive.
  pure subroutine make_line(swelling, smallest, line)
    real(wp), intent(in) :: swelling, smallest
    class(swelling_line_type), intent(inout) :: line

    line%swelling = swelling
    line%smallest = smallest
    line%by_swelling = 1.0_wp/swelling
  end subroutine make_line

  !> Computes p and dp/de of an elastic volume strain.
  pure subroutine pressure_of(line, e, p, bulk)
    class(swelling_line_type), intent(in) :: line
    !> Compression positive.
    real(wp), intent(in) :: e
    real(wp), intent(out) :: p, bulk

    if (e > 0.0_wp) then
      p = line%smallest*exp(e*line%by_swelling)
      bulk = p*line%by_swelling
    else
      p = line%smallest*(1.0_wp + e*line%by_swelling)
      bulk = line%smallest*line%by_swelling
    end if
  end subroutine pressure_of

  !> Elastic volume strain of a pressure.
  pure real(wp) function strain_of(line, p) result(e)
    class(swelling_line_type), intent(in) :: line
    real(wp), intent(in) :: p
    real(wp) :: ratio

    ratio = p/line%smallest
    if (ratio > 1.0_wp) then
      ratio = log(ratio)
    else
      ratio = ratio - 1.0_wp
    end if
    e = line%swelling*ratio
  end function strain_of

  !> Shear modulus G of a step.
  pure real(wp) function shear_modulus(self, stress)
    class(swelling_model_type), intent(in) :: self
    !> Principal stresses (3).
    real(wp), intent(in) :: stress(3)

    shear_modulus = self%shear
    if (.not. self%shear_ratio > 0.0_wp) return
    shear_modulus = self%shear_ratio*max(-sum(stress)/3.0_wp, self%line%smallest)*self%line%by_swelling
  end function shear_modulus

  !> Elastic strain of a stress.
  pure function elastic_strain(self, modulus, stress) result(strain)
    class(swelling_model_type), intent(in) :: self
    !> G of the step; principal stresses (3).
    real(wp), intent(in) :: modulus, stress(3)
    real(wp) :: strain(3), mean

    mean = sum(stress)/3.0_wp
    strain = (stress - mean)/(2.0_wp*modulus) - strain_of(self%line, -mean)/3.0_wp
  end function elastic_strain

  !> Computes the elastic stress and its derivative; the step is cut where the trial pressure would overflow.
  pure subroutine elastic_update(self, modulus, trial, result)
    class(swelling_model_type), intent(in) :: self
    !> G of the step; principal elastic strains (3).
    real(wp), intent(in) :: modulus, trial(3)
    type(stress_update_type), intent(inout) :: result
    real(wp) :: p, bulk, e

    e = -sum(trial)
    result%status = merge(status_ok, status_cut, e < largest_exponent*self%line%swelling)
    if (result%status /= status_ok) return
    call pressure_of(self%line, e, p, bulk)
    result%stress = 2.0_wp*modulus*(trial + e/3.0_wp) - p
    result%derivative = elastic_map(bulk - 2.0_wp*modulus/3.0_wp, modulus)
  end subroutine elastic_update
end module qsmpm_swelling_model
