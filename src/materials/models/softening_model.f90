!> Linear elasticity bounded by a softening Mohr-Coulomb strength, in principal values. The strength is that at the END
!> of the step.
!>
!> With s(t, kappa) the return of the trial stress t to the strength of kappa, the plastic shear strain of the step
!> is gamma = (2 e':e')^1/2, e' the deviator of D^-1 (t - s) = (t - s)'/2G, and kappa solves
!>   kappa - kappa_0 - b gamma(t, kappa) = 0,   b the factor on the strain (band_ratio),
!> by Newton's method within a bracket. With g = d gamma/d(t - s) and h = 1 + b g . ds/dkappa
!>   ds/dt (total) = S + ds/dkappa (b g . (I - S))/h,   S = ds/dt at constant kappa.
!> h is the slope of the equation. Where it is not positive the strength decreases faster than the stress can unload
!> elastically (snap-back of the point) and there is no solution nearby; a longer band in the law or smaller cells help.
!>
!> The strength of a nonlocal law is that of khat = m kbar + (1 - m) kappa, kbar given with the state. With R = ds/dkhat
!>   h = 1 + (1 - m) g . R > 1,   ds/dkbar = m R/h,   dkappa/dkbar = -m g . R/h,   dkappa/dt = g . (I - S)/h:
!> a point at constant kbar hardens, and no point snaps back.
module qsmpm_softening_model
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: status_ok, status_failed
  use qsmpm_material_parameters, only: material_parameters_type
  use qsmpm_mohr_coulomb_return, only: mohr_coulomb_type, inside
  use qsmpm_mohr_coulomb_model, only: mohr_coulomb_model_type, set_mohr_coulomb
  use qsmpm_principal_model, only: stress_update_type, field_response_type
  use qsmpm_softening, only: softening_type, strength_change_type, make_softening, softened_strength, band_ratio, &
    degree_of, strain_of_degree, nonlocal_length, softening_state, nonlocal_state
  use qsmpm_softening_return, only: return_softening
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: softening_model_type, set_softening, largest_band_ratio

  !> Smallest slope h for which the equation is regarded as solvable.
  real(wp), parameter :: least_slope = 1.0e-3_wp
  !> Largest number of corrections of kappa, and tolerance of the residual relative to kappa.
  integer, parameter :: max_corrections = 100
  real(wp), parameter :: tolerance = 1.0e-14_wp
  !> Largest cell in which the field is used, relative to l.
  real(wp), parameter :: coarsest_cell = 0.75_wp
  !> Excess of the trial stress of `largest_band_ratio` over the strength, relative to it.
  real(wp), parameter :: beyond = 1.0e-6_wp
  character(len=*), parameter :: snap_back = 'the strength falls faster than the stress can be unloaded '// &
    '(*SOFTENING: smaller cells or a larger plastic shear strain)'

  !> The constitutive model; its state variables are kappa and, if nonlocal, kbar.
  type, extends(mohr_coulomb_model_type) :: softening_model_type
    type(softening_type) :: softening
  contains
    procedure :: update
    procedure :: state_to_field
    procedure :: field_to_state
    procedure :: respond
  end type softening_model_type

  !> Weighting of the strain of a point: b, and the strain that softens as offset + share kappa.
  type :: counting_type
    real(wp) :: ratio = 1.0_wp
    real(wp) :: offset = 0.0_wp
    real(wp) :: share = 1.0_wp
  end type counting_type

  !> Results at a trial value of kappa.
  type :: softening_state_type
    real(wp) :: stress(3) = 0.0_wp
    real(wp) :: by_trial(3, 3) = 0.0_wp
    real(wp) :: by_kappa(3) = 0.0_wp
    !> R.
    real(wp) :: by_strain(3) = 0.0_wp
    !> b g, and b gamma.
    real(wp) :: gradient(3) = 0.0_wp
    real(wp) :: strain = 0.0_wp
    !> h.
    real(wp) :: slope = 1.0_wp
  end type softening_state_type

contains

  !> Sets moduli, strength and softening from checked parameters.
  subroutine set_softening(parameters, model)
    type(material_parameters_type), intent(in) :: parameters
    class(softening_model_type), intent(inout) :: model

    call set_mohr_coulomb(parameters, model)
    call make_softening(parameters, model%softening)
    model%symmetric = .false.
    model%asks_cell_size = model%softening%by_cell
    model%message = snap_back
    model%state_count = 1
    model%state_names = [string_type(softening_state)]
    if (.not. model%softening%nonlocal) return
    model%state_count = 2
    model%state_names = [string_type(softening_state), string_type(nonlocal_state)]
    model%field_length = nonlocal_length(model%softening)
    model%coarsest_cell = coarsest_cell*model%field_length
  end subroutine set_softening

  !> Converts kappa to the degree of softening, which may be averaged: cohesion is linear in it, so that the mean of
  !> stresses on their strengths is on the mean strength. kappa itself is averaged if nonlocal: kbar is linear in it.
  pure subroutine state_to_field(self, state)
    class(softening_model_type), intent(in) :: self
    !> In: kappa. Out: degree (1).
    real(wp), intent(inout) :: state(:)

    if (self%softening%nonlocal) return
    state(1) = degree_of(self%softening, state(1))
  end subroutine state_to_field

  !> Converts an averaged degree back to kappa.
  pure subroutine field_to_state(self, state)
    class(softening_model_type), intent(in) :: self
    !> In: degree. Out: kappa (1).
    real(wp), intent(inout) :: state(:)

    if (self%softening%nonlocal) then
      state(1) = max(0.0_wp, state(1))
    else
      state(1) = strain_of_degree(self%softening, state(1))
    end if
  end subroutine field_to_state

  !> Returns the trial stress to the strength at the end of the step.
  pure subroutine update(self, modulus, trial, state, cell_size, with_derivative, result)
    class(softening_model_type), intent(in) :: self
    !> G; principal trial stresses (3); kappa at the start; kbar at the end.
    real(wp), intent(in) :: modulus, trial(3), state(self%state_count)
    !> Size of the point's cell; 0 where there is no cell, and the strain is not scaled.
    real(wp), intent(in) :: cell_size
    !> Whether the derivative is required.
    logical, intent(in) :: with_derivative
    type(stress_update_type), intent(inout) :: result
    type(mohr_coulomb_type) :: strength
    type(strength_change_type) :: change
    type(softening_state_type) :: end_state
    type(counting_type) :: counting
    logical :: ok

    result%status = status_ok
    result%state(:self%state_count) = state
    counting = counting_of(self, state, cell_size)
    call softened_strength(self%softening, softening_strain(counting, state(1)), strength, change)
    result%yields = .not. inside(strength, trial)
    if (.not. result%yields) return
    call find_kappa(self, counting, trial, state(1), strength, result%state(1), end_state, ok)
    result%stress = end_state%stress
    if (.not. ok) then
      result%status = status_failed
    else if (with_derivative) then
      result%derivative = total_derivative(end_state)
    end if
  end subroutine update

  !> Weighting of the strain: by the nonlocal field where the cell is small enough for it, otherwise by the cell size.
  pure type(counting_type) function counting_of(model, state, cell_size) result(counting)
    class(softening_model_type), intent(in) :: model
    !> kappa, kbar; 0 where there is no cell.
    real(wp), intent(in) :: state(:), cell_size

    if (.not. cell_size > 0.0_wp) return
    if (.not. model%softening%nonlocal .or. cell_size > model%coarsest_cell) then
      counting%ratio = band_ratio(model%softening, cell_size)
    else
      counting%offset = model%softening%over*state(2)
      counting%share = 1.0_wp - model%softening%over
    end if
  end function counting_of

  !> Strain that determines the strength.
  pure real(wp) function softening_strain(counting, kappa) result(strain)
    type(counting_type), intent(in) :: counting
    real(wp), intent(in) :: kappa

    strain = counting%offset + counting%share*kappa
  end function softening_strain

  !> Solves for the plastic shear strain at the end of the step.
  pure subroutine find_kappa(model, counting, trial, kappa_start, strength, kappa, state, ok)
    class(softening_model_type), intent(in) :: model
    type(counting_type), intent(in) :: counting
    !> Principal trial stresses, outside the strength of the start (3); plastic shear strain at the start of the step.
    real(wp), intent(in) :: trial(3), kappa_start
    !> Workspace.
    type(mohr_coulomb_type), intent(inout) :: strength
    !> Plastic shear strain at the end.
    real(wp), intent(out) :: kappa
    !> Stress and derivatives there.
    type(softening_state_type), intent(out) :: state
    !> False where there is no solution nearby.
    logical, intent(out) :: ok
    real(wp) :: low, high, next, miss, noise
    integer :: i

    low = kappa_start
    high = huge(1.0_wp)
    kappa = kappa_start
    noise = 4.0_wp*epsilon(1.0_wp)*counting%ratio*(maxval(abs(trial)) + strength%sc)/(2.0_wp*model%shear)
    do i = 1, max_corrections
      call evaluate(model, counting, trial, kappa, strength, state)
      ok = state%slope > least_slope
      if (i == 1 .and. .not. ok) return
      miss = kappa - kappa_start - state%strain
      if (abs(miss) <= tolerance*kappa + noise) return
      if (miss > 0.0_wp) high = kappa
      if (miss < 0.0_wp) low = kappa
      next = high
      if (ok) next = kappa - miss/state%slope
      if (.not. (next > low .and. next < high)) then
        next = 0.5_wp*(low + high)
        if (high >= huge(1.0_wp)) next = 2.0_wp*kappa - kappa_start + state%strain
      end if
      ! Adjacent floating-point numbers: there is a kink between them.
      if (abs(next - kappa) <= epsilon(1.0_wp)*kappa) return
      kappa = next
    end do
    ok = .false.
  end subroutine find_kappa

  !> Evaluates stress, strain and derivatives at a trial value of kappa.
  pure subroutine evaluate(model, counting, trial, kappa, strength, state)
    class(softening_model_type), intent(in) :: model
    type(counting_type), intent(in) :: counting
    !> Principal trial stresses (3); plastic shear strain.
    real(wp), intent(in) :: trial(3), kappa
    type(mohr_coulomb_type), intent(inout) :: strength
    !> Stress and derivatives.
    type(softening_state_type), intent(inout) :: state
    type(strength_change_type) :: change
    real(wp) :: corrector(3), size

    call softened_strength(model%softening, softening_strain(counting, kappa), strength, change)
    call return_softening(strength, change, model%trial_lame, model%shear, trial, state%stress, state%by_trial, &
      state%by_strain)
    state%by_kappa = counting%share*state%by_strain
    corrector = trial - state%stress
    corrector = corrector - sum(corrector)/3.0_wp
    size = sqrt(2.0_wp*sum(corrector**2))
    state%strain = counting%ratio*size/(2.0_wp*model%shear)
    state%gradient = 0.0_wp
    if (size > 0.0_wp) state%gradient = counting%ratio*corrector/(size*model%shear)
    state%slope = 1.0_wp + dot_product(state%gradient, state%by_kappa)
  end subroutine evaluate

  !> d stress / d trial stress including the change of kappa.
  pure function total_derivative(state) result(derivative)
    !> Stress and derivatives.
    type(softening_state_type), intent(in) :: state
    real(wp) :: derivative(3, 3)
    integer :: j

    do j = 1, 3
      derivative(:, j) = state%by_trial(:, j) + state%by_kappa/state%slope &
        *(state%gradient(j) - dot_product(state%gradient, state%by_trial(:, j)))
    end do
  end function total_derivative

  !> Computes the derivatives of stress and kappa of an updated point by the nonlocal strain, and of kappa by the trial.
  pure subroutine respond(self, trial, state, cell_size, response)
    class(softening_model_type), intent(in) :: self
    !> Principal trial stresses (3); kappa and kbar at the end of the step.
    real(wp), intent(in) :: trial(3), state(self%state_count)
    real(wp), intent(in) :: cell_size
    type(field_response_type), intent(out) :: response
    type(mohr_coulomb_type) :: strength
    type(softening_state_type) :: at

    if (.not. self%softening%nonlocal .or. cell_size > self%coarsest_cell) return
    call evaluate(self, counting_of(self, state, cell_size), trial, state(1), strength, at)
    response%stress_by_field = self%softening%over*at%by_strain/at%slope
    response%strain_by_field = -self%softening%over*dot_product(at%gradient, at%by_strain)/at%slope
    response%strain_by_trial = (at%gradient - matmul(at%gradient, at%by_trial))/at%slope
  end subroutine respond

  !> Largest factor h/L on the strain before a point without confinement snaps back; huge where none does.
  pure real(wp) function largest_band_ratio(model)
    class(softening_model_type), intent(in) :: model
    type(mohr_coulomb_type) :: strength
    type(strength_change_type) :: change
    type(softening_state_type) :: state
    integer, parameter :: samples = 50
    integer :: i

    largest_band_ratio = huge(1.0_wp)
    do i = 0, samples - 1
      call softened_strength(model%softening, i*model%softening%strain/samples, strength, change)
      call evaluate(model, counting_type(), strength%sc*[0.0_wp, -0.5_wp, -1.0_wp - beyond], &
        i*model%softening%strain/samples, strength, state)
      if (state%slope < 1.0_wp) largest_band_ratio = min(largest_band_ratio, &
        (1.0_wp - least_slope)/(1.0_wp - state%slope))
    end do
  end function largest_band_ratio
end module qsmpm_softening_model
