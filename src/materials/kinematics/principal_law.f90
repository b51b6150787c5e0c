!> The law of a model in principal values (qsmpm_principal_model) in either kinematics and dimension.
!>
!> Logarithmic strain. With the incremental deformation gradient F
!>   b = F b_e F^T,   eps = ln(b)/2,   stress of the model at eps,   Q = tau F^-T / J_n.
!> A Hookean model limits the Kirchhoff stress tau = D eps: the return is that of small strain, b_e is a state variable
!> with b_e,new = exp(2 D^-1 tau), and an average of ln b_e over points remains admissible. J_n is the volume ratio at
!> the start, sigma = tau/(J_n det F). Every other model limits sigma: b_e = exp(2 eps(sigma)) follows from the stress
!> at the start, and tau/J_n = det(F) sigma. Tangent: with l = dF F^-1 = d + w in the frame of the principal directions
!> of b
!>   dtau_aa = sum_b C_ab d_bb,  C = d tau/d eps,   dtau_ab = 2 s_ab d_ab + (tau_b - tau_a) w_ab,
!>   s_ab = (tau_a - tau_b)/(eps_a - eps_b)/2 artanh(x)/x,  x = (b_a - b_b)/(b_a + b_b),
!> and dQ = (dtau - tau l^T) F^-T / J_n; it is K^E + K^G of the paper's eqs. 15-17
!> in Kirchhoff stress (Beuth et al. 2008).
!>
!> Jaumann rate of the paper. The stress is the state. The trial is computed by qsmpm_jaumann_increment: a stress of
!> Hookean models and an elastic strain of the others, which have no term -sigma tr(d eps), because the parameters of
!> soils are measured in Cauchy stress. The model limits the Cauchy stress,
!>   Q = det(F) sigma F^-T,   A dF = det(F) d(sigma) F^-T + tr(l) Q - Q dF^T F^-T,
!> d(sigma) the derivative of the whole update. At F = I the elastic tangent is [K^E + K^G]^0, the form of eq. 12.
!>
!> The elastic tangent is that of the same material without strength. For models that are not Hookean it is
!> symmetrised, as it is used only where an approximation suffices. The points are updated by the four kernels
!> qsmpm_logarithmic_plane, _solid and qsmpm_jaumann_plane, _solid.
!>
!> Derivatives that couple the displacement with the field of a nonlocal law (qsmpm_nonlocal_strain), in logarithmic
!> strain. The trial b = F b_e F^T and the result of the model in principal values have the same directions. With r the
!> derivative of the principal stresses by kbar and g that of kappa by the principal trial stresses,
!>   dQ/dkbar = (sum r_a n_a n_a) F^-T / J_n,
!> and as a change of F changes eps = ln(b)/2 in these directions by sym(dF F^-1),
!>   dkappa/dF = (sum p_a n_a n_a) F^-T,   p = D g,  D the elastic moduli.
module qsmpm_principal_law
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_other, error_deck
  use qsmpm_isotropic_function, only: compose, tensor_logarithm, tensor_exponential
  use qsmpm_jaumann_increment, only: rate_paper, rate_midpoint, rate_paper_cauchy, rate_midpoint_cauchy, is_cauchy
  use qsmpm_jaumann_plane, only: update_jaumann_plane => update_plane
  use qsmpm_jaumann_solid, only: update_jaumann_solid => update_solid
  use qsmpm_law, only: law_type, batch_type, field_coupling_type, tangent_elastic, time_increment, &
    unnamed_states
  use qsmpm_logarithmic_plane, only: update_logarithmic_plane => update_plane
  use qsmpm_logarithmic_solid, only: update_logarithmic_solid => update_solid
  use qsmpm_point_result, only: finish_points
  use qsmpm_principal_model, only: principal_model_type, field_response_type
  use qsmpm_spectral, only: spectral
  use qsmpm_tensor, only: stress_size, unpack_symmetric, pack_symmetric, determinant, inverse, pack_gradient, &
    transformed, unpack_gradient
  implicit none
  private

  public :: new_principal_law

  !> Kinematics, numbered as in the deck's description.
  integer, parameter, public :: kinematics_jaumann = 1, kinematics_logarithmic = 2

  !> The law of a model in principal values.
  type, extends(law_type) :: principal_law_type
    class(principal_model_type), allocatable :: model
    !> One of kinematics_*, and of rate_* of qsmpm_jaumann_increment.
    integer :: kinematics = 0
    integer :: rate = 0
    !> Components of b_e in the state, before the model's state variables.
    integer :: strains = 0
  contains
    procedure :: start_at
    procedure :: update
    procedure :: fit_count
    procedure :: to_fields
    procedure :: from_fields
    procedure :: couple
    procedure :: shear_modulus
    procedure :: shear_compliance
  end type principal_law_type

contains

  !> Makes the law of a model.
  subroutine new_principal_law(model, dimension, kinematics, rate, law, error)
    class(principal_model_type), intent(in) :: model
    !> 2 or 3; one of kinematics_*; one of rate_*, used by the Jaumann kinematics only.
    integer, intent(in) :: dimension, kinematics, rate
    class(law_type), allocatable, intent(out) :: law
    !> Set when the combination is not supported.
    type(error_type), allocatable, intent(out) :: error
    type(principal_law_type), allocatable :: made

    call check_kinematics(model, dimension, kinematics, rate, error)
    if (allocated(error)) return
    allocate (made)
    allocate (made%model, source=model)
    made%dimension = dimension
    made%kinematics = kinematics
    made%rate = rate
    if (.not. model%hookean) made%rate = rate_midpoint_cauchy
    if (kinematics == kinematics_logarithmic .and. model%hookean) made%strains = stress_size(dimension)
    made%state_count = made%strains + model%state_count
    if (model%state_count > 0) made%state_names = [unnamed_states(made%strains), model%state_names]
    made%asks_where = model%asks_cell_size
    made%symmetric = kinematics == kinematics_logarithmic .and. model%hookean .and. model%symmetric
    made%field_length = model%field_length
    made%coarsest_cell = model%coarsest_cell
    made%bounds_kirchhoff = made%strains > 0
    made%stiffness_scale = model%young
    made%shear_scale = model%shear
    call move_alloc(made, law)
  end subroutine new_principal_law

  !> Rejects combinations that no kernel supports.
  subroutine check_kinematics(model, dimension, kinematics, rate, error)
    class(principal_model_type), intent(in) :: model
    integer, intent(in) :: dimension, kinematics, rate
    type(error_type), allocatable, intent(out) :: error

    if (dimension /= 2 .and. dimension /= 3) then
      call fail(error, error_other, 'a law is for two or three dimensions')
    else if (kinematics /= kinematics_jaumann .and. kinematics /= kinematics_logarithmic) then
      call fail(error, error_other, 'unknown kinematics')
    else if (kinematics == kinematics_logarithmic) then
      return
    else if (all(rate /= [rate_paper, rate_midpoint, rate_paper_cauchy, rate_midpoint_cauchy])) then
      call fail(error, error_other, 'unknown integration of the stress rate')
    else if (.not. model%hookean .and. (rate == rate_paper .or. rate == rate_paper_cauchy)) then
      call fail(error, error_deck, 'hardening soils have no RATE=PAPER: the rule is not objective and of first '// &
        'order; take RATE=MIDPOINT or KINEMATICS=LOGARITHMIC')
    else if (model%field_length > 0.0_wp) then
      call fail(error, error_deck, 'REGULARISATION=NONLOCAL of *SOFTENING is for '// &
        'KINEMATICS=LOGARITHMIC: take that, or REGULARISATION=CELL')
    end if
  end subroutine check_kinematics

  !> Initialises the state of a given Cauchy stress at volume ratio 1, independent of the position.
  subroutine start_at(self, stress, place, state)
    class(principal_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6), and position (3).
    real(wp), intent(in) :: stress(:), place(3)
    !> b_e where it is a state variable, and the model's state variables (state_count).
    real(wp), intent(out) :: state(:)
    real(wp) :: values(3), vectors(3, 3)

    call spectral(unpack_symmetric(stress), values, vectors)
    call self%model%initial_state(values, state(self%strains + 1:self%state_count))
    if (self%strains == 0) return
    values = exp(2.0_wp*self%model%elastic_strain(self%model%shear, values))
    call pack_symmetric(compose(values, vectors), state(:self%strains))
  end subroutine start_at

  !> Updates a batch.
  subroutine update(self, batch, tangent)
    class(principal_law_type), intent(in) :: self
    type(batch_type), intent(inout) :: batch
    !> One of tangent_none, tangent_consistent, tangent_elastic.
    integer, intent(in) :: tangent
    class(principal_model_type), allocatable :: timed
    integer :: p

    if (self%model%asks_time) then
      allocate (timed, source=self%model)
      timed%time = time_increment(batch%step_info)
      call update_points(self, timed, batch, tangent)
    else
      call update_points(self, self%model, batch, tangent)
    end if
    call finish_points(batch, tangent)
    if (tangent /= tangent_elastic .or. self%model%hookean) return
    do p = 1, batch%count
      batch%tangent(:, :, p) = 0.5_wp*(batch%tangent(:, :, p) + transpose(batch%tangent(:, :, p)))
    end do
  end subroutine update

  !> Calls the kernel of the kinematics and dimension.
  subroutine update_points(self, model, batch, tangent)
    class(principal_law_type), intent(in) :: self
    !> The model of the law, or a copy with the duration of the step.
    class(principal_model_type), intent(in) :: model
    type(batch_type), intent(inout) :: batch
    integer, intent(in) :: tangent

    if (self%kinematics == kinematics_logarithmic) then
      if (self%dimension == 2) call update_logarithmic_plane(model, self%elastic_blend, batch, tangent)
      if (self%dimension == 3) call update_logarithmic_solid(model, self%elastic_blend, batch, tangent)
    else
      if (self%dimension == 2) call update_jaumann_plane(model, self%rate, self%elastic_blend, batch, tangent)
      if (self%dimension == 3) call update_jaumann_solid(model, self%rate, self%elastic_blend, batch, tangent)
    end if
  end subroutine update_points

  !> Number of components of stress or ln b_e, and of the model's state variables.
  pure integer function fit_count(self)
    class(principal_law_type), intent(in) :: self

    fit_count = stress_size(self%dimension) + self%model%state_count
  end function fit_count

  !> Converts to fields that may be averaged: ln b_e where it is a state variable, from which the stress follows,
  !> otherwise the Cauchy stress; and the state variables converted by the model.
  pure subroutine to_fields(self, stress, state, fields)
    class(principal_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6); state (state_count).
    real(wp), intent(in) :: stress(:), state(:)
    !> (fit_count)
    real(wp), intent(out) :: fields(:)
    integer :: n

    n = stress_size(self%dimension)
    if (self%strains > 0) then
      call tensor_logarithm(state(1:n), fields(1:n))
    else
      fields(1:n) = stress(1:n)
    end if
    fields(n + 1:n + self%model%state_count) = state(self%strains + 1:self%state_count)
    call self%model%state_to_field(fields(n + 1:n + self%model%state_count))
  end subroutine to_fields

  !> Computes stress and state of averaged fields.
  pure subroutine from_fields(self, fields, volume_ratio, stress, state)
    class(principal_law_type), intent(in) :: self
    !> (fit_count)
    real(wp), intent(in) :: fields(:)
    !> V/V0, used where the Kirchhoff stress is limited.
    real(wp), intent(in) :: volume_ratio
    !> Cauchy stress (4 or 6); state (state_count).
    real(wp), intent(out) :: stress(:), state(:)
    integer :: n

    n = stress_size(self%dimension)
    state(self%strains + 1:self%state_count) = fields(n + 1:n + self%model%state_count)
    call self%model%field_to_state(state(self%strains + 1:self%state_count))
    stress(1:n) = fields(1:n)
    if (self%strains == 0) return
    call tensor_exponential(fields(1:n), state(1:n))
    stress = self%model%trial_shear*fields(1:n)
    stress(1:3) = stress(1:3) + 0.5_wp*self%model%trial_lame*sum(fields(1:3))
    stress = stress/volume_ratio
  end subroutine from_fields

  !> Computes the coupling of a point with the field, in logarithmic strain.
  pure subroutine couple(self, gradient, volume_ratio, cell_size, state_start, state, coupling)
    class(principal_law_type), intent(in) :: self
    !> As in qsmpm_law.
    real(wp), intent(in) :: gradient(:), volume_ratio, cell_size, state_start(:), state(:)
    type(field_coupling_type), intent(out) :: coupling

    coupling = field_coupling_type()
    if (self%strains > 0) call couple_logarithmic(self%model, gradient, volume_ratio, cell_size, &
      state_start(:self%strains), state(self%strains + 1:self%state_count), coupling)
  end subroutine couple

  !> Shear modulus G of the model at a stress.
  pure real(wp) function shear_modulus(self, stress, state) result(shear)
    class(principal_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), state(:)
    real(wp) :: values(3), vectors(3, 3)

    shear = self%model%shear
    if (self%model%hookean) return
    call spectral(unpack_symmetric(stress), values, vectors)
    shear = self%model%shear_modulus(values)
  end function shear_modulus

  !> Shear compliance of the stress that the model limits: Kirchhoff stress, J sigma of the rate with J from
  !> the start of the step, or Cauchy stress.
  pure function shear_compliance(self, stress, state, volume_ratio, volume_change) result(compliance)
    class(principal_law_type), intent(in) :: self
    !> As in qsmpm_law.
    real(wp), intent(in) :: stress(:), state(:), volume_ratio, volume_change
    real(wp) :: compliance(2), values(3), vectors(3, 3)

    call spectral(unpack_symmetric(stress), values, vectors)
    compliance = 0.5_wp/self%model%shear_modulus(values)
    if (self%strains > 0) then
      compliance = compliance*[volume_ratio, volume_ratio*volume_change]
    else if (self%kinematics == kinematics_jaumann .and. .not. is_cauchy(self%rate)) then
      compliance(2) = compliance(2)*volume_change
    end if
  end function shear_compliance

  !> Computes the coupling of an updated point.
  pure subroutine couple_logarithmic(model, gradient, volume_ratio, cell_size, strain_start, state, coupling)
    !> Hookean; its trial is a Kirchhoff stress.
    class(principal_model_type), intent(in) :: model
    !> F, packed (5 or 9), J_n, size of the cell.
    real(wp), intent(in) :: gradient(:), volume_ratio, cell_size
    !> b_e at the start (4 or 6), and the model's state variables at the end (state_count).
    real(wp), intent(in) :: strain_start(:), state(:)
    type(field_coupling_type), intent(inout) :: coupling
    type(field_response_type) :: response
    real(wp) :: f(3, 3), values(3), vectors(3, 3), turned(3, 3), elastic(3)
    integer :: n

    n = size(gradient)
    f = unpack_gradient(gradient)
    call spectral(transformed(f, unpack_symmetric(strain_start)), values, vectors)
    values = 0.5_wp*log(values)
    call model%respond(model%trial_lame*sum(values) + 2.0_wp*model%trial_shear*values, state, cell_size, response)
    elastic = model%trial_lame*sum(response%strain_by_trial) + 2.0_wp*model%trial_shear*response%strain_by_trial
    turned = transpose(inverse(f, determinant(f)))
    call pack_gradient(matmul(compose(response%stress_by_field/volume_ratio, vectors), turned), &
      coupling%stress_by_field(:n))
    call pack_gradient(matmul(compose(elastic, vectors), turned), coupling%strain_by_gradient(:n))
    coupling%strain_by_field = response%strain_by_field
  end subroutine couple_logarithmic
end module qsmpm_principal_law
