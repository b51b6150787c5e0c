!> Answer of a softening strength to a trial stress: the strength is that of the END of the step.
!>
!> With s(t, kappa) the return of the trial stress t to the strength of kappa, the plastic shear strain of the step
!> is gamma = (2 e':e')^1/2, e' the deviator of D^-1 (t - s) = (t - s)'/2G, and kappa solves
!>   kappa - kappa_0 - b gamma(t, kappa) = 0,   b how often strain counts (band_ratio),
!> by Newton's method, kept in a bracket. With g = d gamma/d(t - s) and h = 1 + b g . ds/dkappa
!>   ds/dt (total) = S + ds/dkappa (b g . (I - S))/h,   S = ds/dt at constant kappa.
!> h is the slope of the equation: where it is not positive the strength falls faster than the elastic unloading
!> follows (snap-back of the point) and no answer is near; a longer band in the law or a smaller cell has one.
module qsmpm_softening_return
  use qsmpm_kinds, only: wp
  use qsmpm_changing_strength, only: return_changing
  use qsmpm_isotropic_function, only: pair_quotients
  use qsmpm_law, only: batch_type, status_failed
  use qsmpm_mohr_coulomb, only: mohr_coulomb_type, inside
  use qsmpm_principal_model, only: principal_model_type, response_type
  use qsmpm_softening, only: strength_change_type, softened_strength, band_ratio
  use qsmpm_tensor, only: identity
  implicit none
  private

  public :: respond_softening, largest_band_ratio

  !> Least slope h of the equation that is taken for a solvable one.
  real(wp), parameter :: least_slope = 1.0e-3_wp
  !> Corrections of kappa, and the size of the last one relative to kappa.
  integer, parameter :: max_corrections = 100
  real(wp), parameter :: tolerance = 1.0e-14_wp
  !> How far beyond the strength the trial stress of `largest_band_ratio` lies.
  real(wp), parameter :: beyond = 1.0e-6_wp
  character(len=*), parameter :: snap_back = 'the strength falls faster than the stress can be unloaded '// &
    '(*SOFTENING: smaller cells or a larger plastic shear strain)'

  !> Everything at a trial value of kappa.
  type :: state_type
    real(wp) :: stress(3) = 0.0_wp
    real(wp) :: by_trial(3, 3) = 0.0_wp
    real(wp) :: by_kappa(3) = 0.0_wp
    !> b g, and b gamma.
    real(wp) :: gradient(3) = 0.0_wp
    real(wp) :: strain = 0.0_wp
    !> h.
    real(wp) :: slope = 1.0_wp
  end type state_type

contains

  !> Answer a point of a batch.
  pure subroutine respond_softening(model, batch, p, trial, with_derivative, kappa_start, response, kappa)
    !> Moduli and strength.
    type(principal_model_type), intent(in) :: model
    !> The points; the status of the point is set, and the message where it is not ok.
    type(batch_type), intent(inout) :: batch
    !> Number of the point.
    integer, intent(in) :: p
    !> Principal trial stresses (3).
    real(wp), intent(in) :: trial(3)
    !> Whether the derivative is wanted.
    logical, intent(in) :: with_derivative
    !> Plastic shear strain at the start of the step.
    real(wp), intent(in) :: kappa_start
    !> The answer.
    type(response_type), intent(inout) :: response
    !> Plastic shear strain at the end.
    real(wp), intent(out) :: kappa
    type(mohr_coulomb_type) :: strength
    type(strength_change_type) :: change
    type(state_type) :: state
    real(wp) :: ratio
    logical :: ok

    kappa = kappa_start
    call softened_strength(model%softening, kappa, strength, change)
    response%yields = .not. inside(strength, trial)
    response%stress = trial
    response%derivative = identity
    response%quotient = 1.0_wp
    if (.not. response%yields) return
    ratio = 1.0_wp
    if (allocated(batch%cell_size)) ratio = band_ratio(model%softening, batch%cell_size(p))
    call find_kappa(model, ratio, trial, kappa_start, strength, kappa, state, ok)
    response%stress = state%stress
    if (.not. ok) then
      batch%status(p) = status_failed
      batch%message = snap_back
    else if (with_derivative) then
      response%derivative = total_derivative(state)
      response%quotient = pair_quotients(trial, response%stress, response%derivative)
    end if
  end subroutine respond_softening

  !> Solve for the plastic shear strain at the end of the step.
  pure subroutine find_kappa(model, ratio, trial, kappa_start, strength, kappa, state, ok)
    !> Moduli and strength.
    type(principal_model_type), intent(in) :: model
    !> How often strain counts.
    real(wp), intent(in) :: ratio
    !> Principal trial stresses, outside the strength of the start (3).
    real(wp), intent(in) :: trial(3)
    !> Plastic shear strain at the start of the step.
    real(wp), intent(in) :: kappa_start
    !> Work space.
    type(mohr_coulomb_type), intent(inout) :: strength
    !> Plastic shear strain at the end.
    real(wp), intent(out) :: kappa
    !> Stress and derivatives there.
    type(state_type), intent(out) :: state
    !> False where there is none near.
    logical, intent(out) :: ok
    real(wp) :: low, high, next, miss, noise
    integer :: i

    low = kappa_start
    high = huge(1.0_wp)
    kappa = kappa_start
    noise = 4.0_wp*epsilon(1.0_wp)*ratio*(maxval(abs(trial)) + strength%sc)/(2.0_wp*model%shear)
    do i = 1, max_corrections
      call evaluate(model, ratio, trial, kappa, strength, state)
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
      ! Neighbouring numbers: a kink between them.
      if (abs(next - kappa) <= epsilon(1.0_wp)*kappa) return
      kappa = next
    end do
    ok = .false.
  end subroutine find_kappa

  !> Stress, strain and derivatives at a trial value of kappa.
  pure subroutine evaluate(model, ratio, trial, kappa, strength, state)
    !> Moduli and strength.
    type(principal_model_type), intent(in) :: model
    !> How often strain counts.
    real(wp), intent(in) :: ratio
    !> Principal trial stresses (3).
    real(wp), intent(in) :: trial(3)
    !> Plastic shear strain.
    real(wp), intent(in) :: kappa
    !> Its strength.
    type(mohr_coulomb_type), intent(inout) :: strength
    !> The answer.
    type(state_type), intent(inout) :: state
    type(strength_change_type) :: change
    real(wp) :: relief(3), size

    call softened_strength(model%softening, kappa, strength, change)
    call return_changing(strength, change, model%lame, model%shear, trial, state%stress, state%by_trial, state%by_kappa)
    relief = trial - state%stress
    relief = relief - sum(relief)/3.0_wp
    size = sqrt(2.0_wp*sum(relief**2))
    state%strain = ratio*size/(2.0_wp*model%shear)
    state%gradient = 0.0_wp
    if (size > 0.0_wp) state%gradient = ratio*relief/(size*model%shear)
    state%slope = 1.0_wp + dot_product(state%gradient, state%by_kappa)
  end subroutine evaluate

  !> d stress / d trial stress with the change of kappa.
  pure function total_derivative(state) result(derivative)
    !> The answer.
    type(state_type), intent(in) :: state
    real(wp) :: derivative(3, 3)
    integer :: j

    do j = 1, 3
      derivative(:, j) = state%by_trial(:, j) + state%by_kappa/state%slope &
        *(state%gradient(j) - dot_product(state%gradient, state%by_trial(:, j)))
    end do
  end function total_derivative

  !> How often strain may count at most, h/L, before a point without confinement snaps back; huge where it does not.
  pure real(wp) function largest_band_ratio(model)
    !> Moduli and strength.
    type(principal_model_type), intent(in) :: model
    type(mohr_coulomb_type) :: strength
    type(strength_change_type) :: change
    type(state_type) :: state
    integer, parameter :: places = 50
    integer :: i

    largest_band_ratio = huge(1.0_wp)
    do i = 0, places - 1
      call softened_strength(model%softening, i*model%softening%strain/places, strength, change)
      call evaluate(model, 1.0_wp, strength%sc*[0.0_wp, -0.5_wp, -1.0_wp - beyond], i*model%softening%strain/places, &
        strength, state)
      if (state%slope < 1.0_wp) largest_band_ratio = min(largest_band_ratio, &
        (1.0_wp - least_slope)/(1.0_wp - state%slope))
    end do
  end function largest_band_ratio
end module qsmpm_softening_return
