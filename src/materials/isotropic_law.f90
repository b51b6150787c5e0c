!> The law of an isotropic soil model (qsmpm_isotropic_model) in either kinematics and dimension.
!>
!> The stress of a point is its Cauchy stress, the state its history. Both are averaged over cells as they
!> are; a history that the average took out of its range is brought back. The points are worked out by
!> qsmpm_isotropic_logarithmic and qsmpm_isotropic_jaumann. The elastic tangent is made symmetric: it is
!> asked for where an approximation will do.
module qsmpm_isotropic_law
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_jaumann, only: update_jaumann
  use qsmpm_isotropic_logarithmic, only: update_logarithmic
  use qsmpm_isotropic_model, only: isotropic_model_type, answer_type
  use qsmpm_law, only: law_type, batch_type, tangent_elastic
  use qsmpm_point_result, only: finish_points
  use qsmpm_spectral, only: spectral
  use qsmpm_tensor, only: stress_size, unpack_symmetric
  implicit none
  private

  public :: isotropic_law_type, make_isotropic_law

  !> The law.
  type, extends(law_type) :: isotropic_law_type
    class(isotropic_model_type), allocatable :: model
    !> Logarithmic strain, else the Jaumann rate.
    logical :: logarithmic = .true.
  contains
    procedure :: start
    procedure :: update
    procedure :: fit_count
    procedure :: to_fields
    procedure :: from_fields
    procedure :: shear_compliance
  end type isotropic_law_type

contains

  !> Law of a model.
  subroutine make_isotropic_law(model, dimension, logarithmic, law)
    !> The model.
    class(isotropic_model_type), intent(in) :: model
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Logarithmic strain, else the Jaumann rate.
    logical, intent(in) :: logarithmic
    !> The law.
    type(isotropic_law_type), intent(out) :: law

    allocate (law%model, source=model)
    law%dimension = dimension
    law%logarithmic = logarithmic
    law%state_count = model%history_count
    allocate (law%state_names, source=model%history_names)
    law%symmetric = .false.
    law%stiffness_scale = model%young
    law%shear_scale = model%shear
  end subroutine make_isotropic_law

  !> History of a stress.
  subroutine start(self, stress, state)
    class(isotropic_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6).
    real(wp), intent(in) :: stress(:)
    !> History (state_count).
    real(wp), intent(out) :: state(:)
    real(wp) :: values(3), vectors(3, 3)

    call spectral(unpack_symmetric(stress), values, vectors)
    call self%model%start_history(values, state)
  end subroutine start

  !> Update a batch.
  subroutine update(self, batch, tangent)
    class(isotropic_law_type), intent(in) :: self
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> One of tangent_none, tangent_consistent, tangent_elastic.
    integer, intent(in) :: tangent
    integer :: p

    if (self%logarithmic) then
      call update_logarithmic(self%model, self%dimension, self%elastic_blend, batch, tangent)
    else
      call update_jaumann(self%model, self%dimension, self%elastic_blend, batch, tangent)
    end if
    call finish_points(batch, tangent)
    if (tangent /= tangent_elastic) return
    do p = 1, batch%count
      batch%tangent(:, :, p) = 0.5_wp*(batch%tangent(:, :, p) + transpose(batch%tangent(:, :, p)))
    end do
  end subroutine update

  !> Stress components and history.
  pure integer function fit_count(self)
    class(isotropic_law_type), intent(in) :: self

    fit_count = stress_size(self%dimension) + self%state_count
  end function fit_count

  !> Fields that may be averaged: Cauchy stress and history.
  pure subroutine to_fields(self, stress, state, fields)
    class(isotropic_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6).
    real(wp), intent(in) :: stress(:)
    !> History (state_count).
    real(wp), intent(in) :: state(:)
    !> Stress, history (fit_count).
    real(wp), intent(out) :: fields(:)
    integer :: n

    n = stress_size(self%dimension)
    fields(1:n) = stress(1:n)
    fields(n + 1:n + self%state_count) = state(1:self%state_count)
  end subroutine to_fields

  !> Stress and history of averaged fields.
  pure subroutine from_fields(self, fields, volume_ratio, stress, state)
    class(isotropic_law_type), intent(in) :: self
    !> Stress, history (fit_count).
    real(wp), intent(in) :: fields(:)
    !> V/V0, of which the law is independent.
    real(wp), intent(in) :: volume_ratio
    !> Cauchy stress (4 or 6).
    real(wp), intent(out) :: stress(:)
    !> History (state_count).
    real(wp), intent(out) :: state(:)
    integer :: n

    associate (unused => volume_ratio)
    end associate
    n = stress_size(self%dimension)
    stress(1:n) = fields(1:n)
    state(1:self%state_count) = fields(n + 1:n + self%state_count)
    call self%model%clamp_history(state(1:self%state_count))
  end subroutine from_fields

  !> That of the elastic answer at the stress of the start.
  pure function shear_compliance(self, stress, volume_ratio, volume_change) result(compliance)
    class(isotropic_law_type), intent(in) :: self
    !> As of qsmpm_law.
    real(wp), intent(in) :: stress(:), volume_ratio, volume_change
    real(wp) :: compliance(2)
    type(answer_type) :: answer
    real(wp) :: values(3), vectors(3, 3), modulus

    associate (unused_ratio => volume_ratio, unused_change => volume_change)
    end associate
    call spectral(unpack_symmetric(stress), values, vectors)
    modulus = self%model%step_modulus(values)
    call self%model%elastic_answer(modulus, self%model%elastic_strain(modulus, values), answer)
    compliance = 1.0_wp/(answer%derivative(1, 1) - answer%derivative(1, 2))
  end function shear_compliance
end module qsmpm_isotropic_law
