!> Finite elasto-plasticity with logarithmic strain: Hencky elasticity, strength in tau.
!>
!> State is the elastic left Cauchy-Green tensor b_e, and the plastic shear strain where the strength
!> softens. With the incremental deformation gradient F
!>   b = F b_e F^T,   eps = ln(b)/2,   tau_trial = D eps,   tau = return(tau_trial),
!>   b_e,new = exp(2 D^-1 tau),   Q = tau F^-T / J_n,   sigma = tau / (J_n det F),
!> J_n the volume ratio at the start. The strength bounds the Kirchhoff stress tau, so that the
!> return is that of small strain and an average of ln b_e over points stays admissible.
!>
!> Tangent. With l = dF F^-1 = d + w and eps in the frame of the principal directions of b
!>   dtau_aa = sum_b C_ab d_bb,  C = (d tau/d tau_trial) D,
!>   dtau_ab = 2 s_ab d_ab + (tau_b - tau_a) w_ab,
!>   s_ab = G (tau_a - tau_b)/(tautr_a - tautr_b) artanh(x)/x,  x = (b_a - b_b)/(b_a + b_b),
!> and dQ = (dtau - tau l^T) F^-T / J_n; it is K_E + K_G of the paper's eq. 15 in Kirchhoff stress
!> (Beuth et al. 2008). The elastic tangent is that of the same material without strength. The points are
!> worked out by qsmpm_logarithmic_plane and qsmpm_logarithmic_solid.
module qsmpm_logarithmic_law
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: compose, tensor_logarithm, tensor_exponential
  use qsmpm_law, only: law_type, batch_type
  use qsmpm_logarithmic_plane, only: update_plane
  use qsmpm_logarithmic_solid, only: update_solid
  use qsmpm_point_result, only: finish_points
  use qsmpm_principal_model, only: principal_model_type, elastic_strain
  use qsmpm_softening, only: degree_of, strain_of_degree, softening_state
  use qsmpm_spectral, only: spectral
  use qsmpm_tensor, only: unpack_symmetric, pack_symmetric, stress_size
  implicit none
  private

  public :: logarithmic_law_type, make_logarithmic_law

  !> The law.
  type, extends(law_type) :: logarithmic_law_type
    type(principal_model_type) :: model
  contains
    procedure :: start
    procedure :: update
    procedure :: fit_count
    procedure :: to_fields
    procedure :: from_fields
    procedure :: shear_compliance
  end type logarithmic_law_type

contains

  !> Law of a material.
  pure subroutine make_logarithmic_law(model, dimension, law)
    !> Moduli and strength.
    type(principal_model_type), intent(in) :: model
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> The law.
    type(logarithmic_law_type), intent(out) :: law
    integer :: i

    law%model = model
    law%dimension = dimension
    law%state_count = stress_size(dimension) + merge(1, 0, model%softening%active)
    law%asks_where = model%softening%by_cell
    if (model%softening%active) then
      allocate (law%state_names(law%state_count))
      do i = 1, law%state_count
        law%state_names(i)%text = ''
      end do
      law%state_names(law%state_count)%text = softening_state
    end if
    law%symmetric = model%associated_flow .and. .not. model%softening%active
    law%stiffness_scale = model%young
    law%shear_scale = model%shear
  end subroutine make_logarithmic_law

  !> b_e that holds a given Cauchy stress at volume ratio 1.
  pure subroutine start(self, stress, state)
    class(logarithmic_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6).
    real(wp), intent(in) :: stress(:)
    !> b_e, and the plastic shear strain (4 to 7).
    real(wp), intent(out) :: state(:)
    real(wp) :: values(3), vectors(3, 3)

    call spectral(unpack_symmetric(stress), values, vectors)
    values = exp(2.0_wp*elastic_strain(self%model, values))
    state = 0.0_wp
    call pack_symmetric(compose(values, vectors), state(:size(stress)))
  end subroutine start

  !> Update a batch.
  subroutine update(self, batch, tangent)
    class(logarithmic_law_type), intent(in) :: self
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> One of tangent_none, tangent_consistent, tangent_elastic.
    integer, intent(in) :: tangent

    if (self%dimension == 2) then
      call update_plane(self%model, self%elastic_blend, batch, tangent)
    else
      call update_solid(self%model, self%elastic_blend, batch, tangent)
    end if
    call finish_points(batch, tangent)
  end subroutine update

  !> Stress order components of ln b_e, and the degree of softening.
  pure integer function fit_count(self)
    class(logarithmic_law_type), intent(in) :: self

    fit_count = self%state_count
  end function fit_count

  !> Fields that may be averaged: ln b_e, from which the stress follows, and the degree of softening, to which
  !> cohesion is linear, so that the mean of stresses on their strengths lies on the mean strength.
  pure subroutine to_fields(self, stress, state, fields)
    class(logarithmic_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6).
    real(wp), intent(in) :: stress(:)
    !> b_e, and the plastic shear strain (4 to 7).
    real(wp), intent(in) :: state(:)
    !> ln b_e, and the degree of softening (4 to 7).
    real(wp), intent(out) :: fields(:)

    call tensor_logarithm(state(1:size(stress)), fields(1:size(stress)))
    if (self%model%softening%active) &
      fields(size(stress) + 1) = degree_of(self%model%softening, state(size(stress) + 1))
  end subroutine to_fields

  !> b_e and Cauchy stress of averaged fields.
  pure subroutine from_fields(self, fields, volume_ratio, stress, state)
    class(logarithmic_law_type), intent(in) :: self
    !> ln b_e, and the degree of softening (4 to 7).
    real(wp), intent(in) :: fields(:)
    !> V/V0.
    real(wp), intent(in) :: volume_ratio
    !> Cauchy stress (4 or 6).
    real(wp), intent(out) :: stress(:)
    !> b_e, and the plastic shear strain (4 to 7).
    real(wp), intent(out) :: state(:)

    call tensor_exponential(fields(1:size(stress)), state(1:size(stress)))
    if (self%model%softening%active) &
      state(size(stress) + 1) = strain_of_degree(self%model%softening, fields(size(stress) + 1))
    stress = self%model%shear*fields(1:size(stress))
    stress(1:3) = stress(1:3) + 0.5_wp*self%model%lame*sum(fields(1:3))
    stress = stress/volume_ratio
  end subroutine from_fields

  !> The elastic strain belongs to the Kirchhoff stress.
  pure function shear_compliance(self, stress, volume_ratio, volume_change) result(compliance)
    class(logarithmic_law_type), intent(in) :: self
    !> As of qsmpm_law.
    real(wp), intent(in) :: stress(:), volume_ratio, volume_change
    real(wp) :: compliance(2)

    associate (unused => stress)
    end associate
    compliance = [volume_ratio, volume_ratio*volume_change]/(2.0_wp*self%model%shear)
  end function shear_compliance
end module qsmpm_logarithmic_law
