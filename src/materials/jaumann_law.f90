!> The rate law of the paper: Jaumann rate of the Cauchy stress, strength in Cauchy stress.
!>
!> The stress is the state; where the strength softens, the plastic shear strain goes with it. The step's
!> trial stress comes from qsmpm_jaumann_increment, is returned
!> to the strength in principal stresses, and
!>   Q = det(F) sigma F^-T,
!>   A dF = det(F) d(sigma) F^-T + tr(l) Q - Q dF^T F^-T,  l = dF F^-1,
!> where d(sigma) is the derivative of the whole update. At F = I the elastic tangent is
!> [K_E + K_G]^0 of Beuth et al. 2008, eqs. 12 and 15-17, and symmetric; elsewhere it is the
!> tangent of the same material without strength, and no tangent is symmetric. The points are worked out by
!> qsmpm_jaumann_plane and qsmpm_jaumann_solid.
module qsmpm_jaumann_law
  use qsmpm_kinds, only: wp
  use qsmpm_jaumann_increment, only: is_cauchy
  use qsmpm_jaumann_plane, only: update_plane
  use qsmpm_jaumann_solid, only: update_solid
  use qsmpm_law, only: law_type, batch_type
  use qsmpm_point_result, only: finish_points
  use qsmpm_principal_model, only: principal_model_type
  use qsmpm_softening, only: degree_of, strain_of_degree, softening_state
  use qsmpm_tensor, only: stress_size
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: jaumann_law_type, make_jaumann_law

  !> The law.
  type, extends(law_type) :: jaumann_law_type
    type(principal_model_type) :: model
    !> One of rate_* of qsmpm_jaumann_increment.
    integer :: rate = 0
  contains
    procedure :: start
    procedure :: update
    procedure :: fit_count
    procedure :: to_fields
    procedure :: from_fields
    procedure :: shear_compliance
  end type jaumann_law_type

contains

  !> Law of a material.
  pure subroutine make_jaumann_law(model, dimension, rate, law)
    !> Moduli and strength.
    type(principal_model_type), intent(in) :: model
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> One of rate_* of qsmpm_jaumann_increment.
    integer, intent(in) :: rate
    !> The law.
    type(jaumann_law_type), intent(out) :: law

    law%model = model
    law%dimension = dimension
    law%rate = rate
    law%state_count = merge(1, 0, model%softening%active)
    law%asks_where = model%softening%by_cell
    if (model%softening%active) allocate (law%state_names, source=[string_type(softening_state)])
    law%symmetric = .false.
    law%stiffness_scale = model%young
    law%shear_scale = model%shear
  end subroutine make_jaumann_law

  !> Nothing has yielded.
  pure subroutine start(self, stress, state)
    class(jaumann_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6).
    real(wp), intent(in) :: stress(:)
    !> Plastic shear strain, where the strength softens (0 or 1).
    real(wp), intent(out) :: state(:)

    associate (unused => stress)
    end associate
    state(1:self%state_count) = 0.0_wp
  end subroutine start

  !> Update a batch.
  subroutine update(self, batch, tangent)
    class(jaumann_law_type), intent(in) :: self
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> One of tangent_none, tangent_consistent, tangent_elastic.
    integer, intent(in) :: tangent

    if (self%dimension == 2) then
      call update_plane(self%model, self%rate, self%elastic_blend, batch, tangent)
    else
      call update_solid(self%model, self%rate, self%elastic_blend, batch, tangent)
    end if
    call finish_points(batch, tangent)
  end subroutine update

  !> Stress components, and the degree of softening.
  pure integer function fit_count(self)
    class(jaumann_law_type), intent(in) :: self

    fit_count = stress_size(self%dimension) + self%state_count
  end function fit_count

  !> Fields that may be averaged: the Cauchy stress, and the degree of softening, to which cohesion is linear, so
  !> that the mean of stresses on their strengths lies on the mean strength.
  pure subroutine to_fields(self, stress, state, fields)
    class(jaumann_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6).
    real(wp), intent(in) :: stress(:)
    !> Plastic shear strain, where the strength softens (0 or 1).
    real(wp), intent(in) :: state(:)
    !> Cauchy stress and degree (4 to 7).
    real(wp), intent(out) :: fields(:)

    fields(1:size(stress)) = stress
    if (self%state_count > 0) fields(size(stress) + 1) = degree_of(self%model%softening, state(1))
  end subroutine to_fields

  !> Stress of averaged fields.
  pure subroutine from_fields(self, fields, volume_ratio, stress, state)
    class(jaumann_law_type), intent(in) :: self
    !> Cauchy stress and degree (4 to 7).
    real(wp), intent(in) :: fields(:)
    !> V/V0, of which the law is independent.
    real(wp), intent(in) :: volume_ratio
    !> Cauchy stress (4 or 6).
    real(wp), intent(out) :: stress(:)
    !> Plastic shear strain, where the strength softens (0 or 1).
    real(wp), intent(out) :: state(:)

    associate (unused => volume_ratio)
    end associate
    stress = fields(1:size(stress))
    if (self%state_count > 0) state(1) = strain_of_degree(self%model%softening, fields(size(stress) + 1))
  end subroutine from_fields

  !> The rate is that of J sigma, J from the start of the step, unless it is that of sigma.
  pure function shear_compliance(self, stress, volume_ratio, volume_change) result(compliance)
    class(jaumann_law_type), intent(in) :: self
    !> As of qsmpm_law.
    real(wp), intent(in) :: stress(:), volume_ratio, volume_change
    real(wp) :: compliance(2)

    associate (unused => stress, unused_ratio => volume_ratio)
    end associate
    compliance = [1.0_wp, merge(1.0_wp, volume_change, is_cauchy(self%rate))]/(2.0_wp*self%model%shear)
  end function shear_compliance
end module qsmpm_jaumann_law
