!> Modified Cam-Clay in principal values (Roscoe and Burland 1968).
!>
!> With p = -tr(sigma)/3, q = sqrt(3/2 s:s), compression positive:
!>   yield      f = q^2/M^2 + p (p - pc) <= 0,  associated flow,
!>   hardening  pc = pc0 exp(ep/(l - k)),  ep the plastic volume strain, l = lambda/v0, k = kappa/v0,
!>   elasticity p = pmin exp(e/k), e the elastic volume strain; below pmin the straight line that goes on
!>              there, p = pmin (1 + e/k), so that a point without stress has stiffness;  s = 2 G dev(strain),
!> G constant as given, or 3(1 - 2nu)/(2(1 + nu)) K(p) with p at the start of the step. All strains are
!> logarithmic, so that compression lines are straight in ln v - ln p (Butterfield 1979).
!>
!> The return is backward Euler with two unknowns, x = plastic volume strain of the step and
!> y = 6 G/M^2 times the multiplier; q = q_trial/(1 + y). Newton's method; should it not arrive, x is
!> bracketed on the yield surface, where a root always is, and Newton's method starts from there.
module qsmpm_cam_clay
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_hardening_parameters, only: cam_clay_parameters_type
  use qsmpm_law, only: status_ok, status_cut
  use qsmpm_principal_model, only: principal_model_type, stress_update_type, elastic_map
  implicit none
  private

  public :: cam_clay_type, make_cam_clay

  !> Newton steps; relative change at which the next one would change nothing.
  integer, parameter :: most_steps = 12
  real(wp), parameter :: small_change = 1.0e-8_wp
  !> Halvings and doublings of the bracket.
  integer, parameter :: most_halvings = 60
  !> Round-off of the yield function relative to pc^2.
  real(wp), parameter :: round_off = 1.0e-12_wp
  !> Largest exponent of a trial pressure.
  real(wp), parameter :: largest_exponent = 200.0_wp

  !> The model; one state variable, pc.
  type, extends(principal_model_type) :: cam_clay_type
    !> M^2, lambda/v0 - kappa/v0, kappa/v0.
    real(wp) :: m2 = 1.0_wp, plastic = 1.0_wp, swelling = 1.0_wp
    !> G/K where positive, else G is constant.
    real(wp) :: shear_ratio = 0.0_wp
    real(wp) :: ocr = 1.0_wp, preconsolidation = 0.0_wp, smallest = 1.0_wp
  contains
    procedure :: initial_state
    procedure :: field_to_state
    procedure :: shear_modulus
    procedure :: elastic_strain
    procedure :: elastic_update
    procedure :: update
  end type cam_clay_type

  !> A return: its data and its two unknowns.
  type :: cam_clay_return_type
    !> Trial elastic volume strain, trial q^2, G, pc at the start.
    real(wp) :: e = 0.0_wp, w = 0.0_wp, shear = 0.0_wp, start = 0.0_wp
    !> Plastic volume strain, scaled multiplier.
    real(wp) :: x = 0.0_wp, y = 0.0_wp
    !> p, dp/de, pc.
    real(wp) :: p = 0.0_wp, bulk = 0.0_wp, pc = 0.0_wp
    !> Derivatives of the two residuals by x and y.
    real(wp) :: jacobian(2, 2) = 0.0_wp
  end type cam_clay_return_type

contains

  !> Model of checked parameters.
  subroutine make_cam_clay(parameters, model)
    type(cam_clay_parameters_type), intent(in) :: parameters
    type(cam_clay_type), intent(out) :: model
    real(wp) :: pressure

    model%state_count = 1
    allocate (model%state_names(1))
    model%state_names(1)%text = 'preconsolidation_pressure'
    model%message = 'Cam-Clay: the volume strain of the step is too large'
    model%m2 = parameters%slope**2
    model%swelling = parameters%kappa/parameters%volume
    model%plastic = (parameters%lambda - parameters%kappa)/parameters%volume
    model%ocr = parameters%ocr
    model%preconsolidation = parameters%preconsolidation
    model%smallest = parameters%smallest_pressure
    pressure = max(parameters%preconsolidation, 10.0_wp*model%smallest)
    model%shear = parameters%shear
    if (.not. parameters%shear > 0.0_wp) then
      model%shear_ratio = 1.5_wp*(1.0_wp - 2.0_wp*parameters%poisson)/(1.0_wp + parameters%poisson)
      model%shear = model%shear_ratio*pressure/model%swelling
    end if
    ! What carries load beyond the first yield is the compression line.
    associate (bulk => pressure/(model%swelling + model%plastic))
      model%young = 9.0_wp*bulk*model%shear/(3.0_wp*bulk + model%shear)
    end associate
  end subroutine make_cam_clay

  !> pc of a stress: OCR times the size of the yield surface through it, or the preconsolidation pressure.
  pure subroutine initial_state(self, stress, state)
    class(cam_clay_type), intent(in) :: self
    !> Principal stresses (3).
    real(wp), intent(in) :: stress(3)
    !> pc (1).
    real(wp), intent(out) :: state(:)
    real(wp) :: p, q2

    p = max(-sum(stress)/3.0_wp, self%smallest)
    q2 = 1.5_wp*sum((stress - sum(stress)/3.0_wp)**2)
    state(1) = max(self%ocr*(p + q2/(self%m2*p)), self%preconsolidation)
    call self%field_to_state(state)
  end subroutine initial_state

  !> pc is not below twice the smallest pressure.
  pure subroutine field_to_state(self, state)
    class(cam_clay_type), intent(in) :: self
    !> pc (1).
    real(wp), intent(inout) :: state(:)

    state(1) = max(state(1), 2.0_wp*self%smallest)
  end subroutine field_to_state

  !> G of a step.
  pure real(wp) function shear_modulus(self, stress)
    class(cam_clay_type), intent(in) :: self
    !> Principal stresses (3).
    real(wp), intent(in) :: stress(3)

    shear_modulus = self%shear
    if (self%shear_ratio > 0.0_wp) shear_modulus = self%shear_ratio*max(-sum(stress)/3.0_wp, self%smallest) &
      /self%swelling
  end function shear_modulus

  !> Elastic strain of a stress.
  pure function elastic_strain(self, modulus, stress) result(strain)
    class(cam_clay_type), intent(in) :: self
    !> G of the step.
    real(wp), intent(in) :: modulus
    !> Principal stresses (3).
    real(wp), intent(in) :: stress(3)
    real(wp) :: strain(3)
    real(wp) :: mean, ratio

    mean = sum(stress)/3.0_wp
    ratio = -mean/self%smallest
    if (ratio > 1.0_wp) then
      ratio = log(ratio)
    else
      ratio = ratio - 1.0_wp
    end if
    strain = (stress - mean)/(2.0_wp*modulus) - self%swelling*ratio/3.0_wp
  end function elastic_strain

  !> p and dp/de of an elastic volume strain.
  pure subroutine pressure_of(self, e, p, bulk)
    type(cam_clay_type), intent(in) :: self
    !> Elastic volume strain, compression positive.
    real(wp), intent(in) :: e
    !> p, and its derivative.
    real(wp), intent(out) :: p, bulk

    if (e > 0.0_wp) then
      p = self%smallest*exp(e/self%swelling)
      bulk = p/self%swelling
    else
      p = self%smallest*(1.0_wp + e/self%swelling)
      bulk = self%smallest/self%swelling
    end if
  end subroutine pressure_of

  !> Stress and derivative without strength.
  pure subroutine elastic_update(self, modulus, trial, result)
    class(cam_clay_type), intent(in) :: self
    !> G of the step.
    real(wp), intent(in) :: modulus
    !> Principal elastic strains (3).
    real(wp), intent(in) :: trial(3)
    type(stress_update_type), intent(inout) :: result
    real(wp) :: p, bulk, e

    e = -sum(trial)
    result%status = merge(status_ok, status_cut, e < largest_exponent*self%swelling)
    if (result%status /= status_ok) return
    call pressure_of(self, e, p, bulk)
    result%stress = 2.0_wp*modulus*(trial + e/3.0_wp) - p
    result%derivative = elastic_map(bulk - 2.0_wp*modulus/3.0_wp, modulus)
  end subroutine elastic_update

  !> Stress, state and derivative.
  pure subroutine update(self, modulus, trial, state, cell_size, with_derivative, result)
    class(cam_clay_type), intent(in) :: self
    !> G of the step.
    real(wp), intent(in) :: modulus
    !> Principal trial strains (3).
    real(wp), intent(in) :: trial(3)
    !> pc at the start (1).
    real(wp), intent(in) :: state(self%state_count)
    !> Size of the point's cell.
    real(wp), intent(in) :: cell_size
    !> Whether the derivative is wanted.
    logical, intent(in) :: with_derivative
    type(stress_update_type), intent(inout) :: result
    type(cam_clay_return_type) :: r
    real(wp) :: p, deviator(3)
    logical :: found

    associate (unused => cell_size)
    end associate
    r%start = max(state(1), 2.0_wp*self%smallest)
    result%state(1) = r%start
    result%yields = .false.
    r%e = -sum(trial)
    result%status = merge(status_ok, status_cut, r%e < largest_exponent*self%swelling)
    if (result%status /= status_ok) return
    call pressure_of(self, r%e, p, r%bulk)
    ! Not from the stress: beside a large trial pressure the deviator would drown in rounding.
    deviator = 2.0_wp*modulus*(trial + r%e/3.0_wp)
    r%w = 1.5_wp*sum(deviator**2)
    result%yields = r%w/self%m2 + p*(p - r%start) > round_off*r%start**2
    if (.not. result%yields) then
      result%stress = deviator - p
      if (with_derivative) result%derivative = elastic_map(r%bulk - 2.0_wp*modulus/3.0_wp, modulus)
      return
    end if
    r%shear = modulus
    call solve_return(self, r, found)
    result%status = merge(status_ok, status_cut, found)
    if (.not. found) return
    result%stress = deviator/(1.0_wp + r%y) - r%p
    result%state(1) = r%pc
    if (with_derivative) call find_derivative(self, r, deviator, result%derivative)
  end subroutine update

  !> Residuals of the return at x and y, and their derivatives.
  pure subroutine residuals(self, r, residual)
    type(cam_clay_type), intent(in) :: self
    type(cam_clay_return_type), intent(inout) :: r
    !> Of the flow rule (a strain), and of the yield surface over pc0^2.
    real(wp), intent(out) :: residual(2)
    real(wp) :: c, z

    call pressure_of(self, r%e - r%x, r%p, r%bulk)
    r%pc = r%start*exp(r%x/self%plastic)
    c = self%m2/(6.0_wp*r%shear)
    z = 1.0_wp/(1.0_wp + r%y)
    residual(1) = r%x - r%y*c*(2.0_wp*r%p - r%pc)
    residual(2) = (z*z*r%w/self%m2 + r%p*(r%p - r%pc))/r%start**2
    r%jacobian(1, 1) = 1.0_wp + r%y*c*(2.0_wp*r%bulk + r%pc/self%plastic)
    r%jacobian(1, 2) = -c*(2.0_wp*r%p - r%pc)
    r%jacobian(2, 1) = -(r%bulk*(2.0_wp*r%p - r%pc) + r%p*r%pc/self%plastic)/r%start**2
    r%jacobian(2, 2) = -2.0_wp*z**3*r%w/self%m2/r%start**2
  end subroutine residuals

  !> Find x and y.
  pure subroutine solve_return(self, r, found)
    type(cam_clay_type), intent(in) :: self
    type(cam_clay_return_type), intent(inout) :: r
    !> Whether they were found.
    logical, intent(out) :: found

    call newton(self, r, found)
    if (found) return
    call bracket(self, r, found)
    if (found) call newton(self, r, found)
  end subroutine solve_return

  !> Newton's method from the x and y at hand.
  pure subroutine newton(self, r, found)
    type(cam_clay_type), intent(in) :: self
    type(cam_clay_return_type), intent(inout) :: r
    !> Whether it arrived.
    logical, intent(out) :: found
    real(wp) :: residual(2), change(2), det
    integer :: step

    found = .false.
    do step = 1, most_steps
      call residuals(self, r, residual)
      associate (j => r%jacobian)
        det = j(1, 1)*j(2, 2) - j(1, 2)*j(2, 1)
        if (.not. abs(det) > 0.0_wp) return
        change(1) = (j(2, 2)*residual(1) - j(1, 2)*residual(2))/det
        change(2) = (j(1, 1)*residual(2) - j(2, 1)*residual(1))/det
      end associate
      if (.not. all(ieee_is_finite(change))) return
      if (abs(change(1)) > 10.0_wp*self%plastic) return
      r%x = r%x - change(1)
      r%y = r%y - change(2)
      if (r%y < -0.5_wp) return
      found = abs(change(1)) <= small_change*(abs(r%x) + self%swelling) &
        .and. abs(change(2)) <= small_change*(1.0_wp + r%y)
      if (found) exit
    end do
    if (.not. found) return
    call residuals(self, r, residual)
    found = r%y >= -small_change .and. r%p > -small_change*r%pc .and. r%p < r%pc*(1.0_wp + small_change)
  end subroutine newton

  !> x between two values of opposite violation: the flow rule on the yield surface. Trials on the wet side
  !> (2 p > pc) have 0 <= x, those on the dry side x <= 0.
  pure subroutine bracket(self, r, found)
    type(cam_clay_type), intent(in) :: self
    type(cam_clay_return_type), intent(inout) :: r
    !> Whether there is a bracket.
    logical, intent(out) :: found
    real(wp) :: low, high, violation, reach
    integer :: i

    low = 0.0_wp
    high = 0.0_wp
    r%x = 0.0_wp
    r%y = 0.0_wp
    call surface_violation(self, r, violation)
    reach = sign(self%swelling, -violation)
    do i = 1, most_halvings
      r%x = reach
      call surface_violation(self, r, violation)
      if (violation*reach >= 0.0_wp) exit
      reach = 2.0_wp*reach
    end do
    found = i <= most_halvings
    low = min(0.0_wp, reach)
    high = max(0.0_wp, reach)
    do i = 1, most_halvings
      r%x = 0.5_wp*(low + high)
      call surface_violation(self, r, violation)
      if (violation < 0.0_wp) low = r%x
      if (violation >= 0.0_wp) high = r%x
      if (high - low < 1.0e-14_wp*(abs(r%x) + self%swelling)) exit
    end do
    r%x = high
    if (reach < 0.0_wp) r%x = low
    call surface_violation(self, r, violation)
    ! Near a tip the surface says little of q, and so of y; the flow rule says it there.
    if (abs(2.0_wp*r%p - r%pc) > 0.2_wp*r%pc) r%y = max(0.0_wp, &
      r%x*6.0_wp*r%shear/(self%m2*(2.0_wp*r%p - r%pc)))
  end subroutine bracket

  !> Violation of the flow rule at x with q on the yield surface, times q; y of that q.
  pure subroutine surface_violation(self, r, violation)
    type(cam_clay_type), intent(in) :: self
    !> The return: x in, y out.
    type(cam_clay_return_type), intent(inout) :: r
    !> Negative where x is too small.
    real(wp), intent(out) :: violation
    real(wp) :: q, trial, c

    call pressure_of(self, r%e - r%x, r%p, r%bulk)
    r%pc = r%start*exp(min(r%x/self%plastic, largest_exponent))
    trial = sqrt(r%w)
    c = self%m2/(6.0_wp*r%shear)
    q = sqrt(self%m2*max(r%p*(r%pc - r%p), 0.0_wp))
    r%y = 0.0_wp
    if (q > small_change*trial) r%y = max(trial/q - 1.0_wp, 0.0_wp)
    if (r%p >= r%pc) then
      violation = -c*trial*r%p
    else if (r%p <= 0.0_wp) then
      violation = c*trial*r%pc
    else
      violation = r%x*q - max(trial - q, 0.0_wp)*c*(2.0_wp*r%p - r%pc)
    end if
    ! Without shear the tips of the surface are the answers.
    if (r%p >= r%pc) violation = min(violation, -tiny(1.0_wp))
  end subroutine surface_violation

  !> d stress / d trial strain of a converged return: x and y change with the trial by the residuals'
  !> derivatives, the stress is trial/(1 + y) - p.
  pure subroutine find_derivative(self, r, trial, derivative)
    type(cam_clay_type), intent(in) :: self
    type(cam_clay_return_type), intent(in) :: r
    !> Deviator of the trial stress (3).
    real(wp), intent(in) :: trial(3)
    !> d stress / d strain (3,3).
    real(wp), intent(out) :: derivative(3, 3)
    real(wp) :: z, by_e(2), by_w, change(2), det, right(2)
    integer :: b

    z = 1.0_wp/(1.0_wp + r%y)
    by_e = [-r%y*self%m2/(3.0_wp*r%shear)*r%bulk, r%bulk*(2.0_wp*r%p - r%pc)/r%start**2]
    by_w = z*z/self%m2/r%start**2
    derivative = elastic_map(-2.0_wp*z*r%shear/3.0_wp, z*r%shear)
    associate (j => r%jacobian)
      det = j(1, 1)*j(2, 2) - j(1, 2)*j(2, 1)
      do b = 1, 3
        right = by_e
        right(2) = right(2) - by_w*6.0_wp*r%shear*trial(b)
        ! By strain b: e falls by one, w grows by 6 G trial(b).
        change(1) = (j(2, 2)*right(1) - j(1, 2)*right(2))/det
        change(2) = (j(1, 1)*right(2) - j(2, 1)*right(1))/det
        derivative(:, b) = derivative(:, b) + r%bulk*(1.0_wp + change(1)) - z*z*change(2)*trial
      end do
    end associate
  end subroutine find_derivative
end module qsmpm_cam_clay
