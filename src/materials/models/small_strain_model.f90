!> A model in principal values whose elastic shear modulus is larger at small strain (Benz 2007, HSsmall). With G_ur the
!> modulus of the model at the stress at the start and g the shear strain since the last reversal,
!>
!>   secant G = G_0/(1 + 0.385 g/g_07),  tangent G = G_0/(1 + 0.385 g/g_07)^2, not below G_ur.
!>
!> The strain history H is a tensor that rotates with the material; g = 3^1/2 |H e|/|e| along the deviatoric strain
!> increment e. In the axes of e, H_ii of opposite sign to e_ii is erased (H + 1 := T (H + 1) T, T_ii = (1 + H_ii)^-1/2,
!> Benz 2007). After a reversal the curve is Masing's, 2 f(g/2) from there, until g/2 has reached the largest previous
!> strain, and the first-loading curve from then on (a rule of this program: loops close and first loading continues);
!> a step that retains a share of g counts as a reversal by the remaining share.
!> A step uses the secant of its strain, so that the stress of a path in one direction does not depend on the steps.
!> Poisson's ratio is constant. The plastic strains are those of the model.
module qsmpm_small_strain_model
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: compose, isotropic_change, pair_quotients
  use qsmpm_law, only: status_ok, unnamed_states
  use qsmpm_principal_model, only: principal_model_type, stress_update_type
  use qsmpm_soil_model, only: soil_model_type, soil_increment_type, soil_response_type
  use qsmpm_spectral, only: spectral
  use qsmpm_tensor, only: identity, pack_symmetric, unpack_symmetric, transformed
  implicit none
  private

  public :: make_small_strain_model

  !> Constant of the stiffness reduction curve.
  real(wp), parameter :: decay = 0.385_wp
  !> Indices in the state: the history, the largest strain before the last reversal, g; their number.
  integer, parameter :: at_largest = 7, at_strain = 8, own = 8
  !> Increment regarded as zero; relative steps of finite differences.
  real(wp), parameter :: none = 1.0e-14_wp, small = 1.0e-4_wp, small_modulus = 1.0e-6_wp

  !> The constitutive model.
  type, extends(soil_model_type) :: small_strain_model_type
    class(principal_model_type), allocatable :: soil
    !> G_0/G_ur and g_07.
    real(wp) :: ratio = 1.0_wp, threshold = 1.0_wp
  contains
    procedure :: start
    procedure :: update
    procedure :: shear_modulus
  end type small_strain_model_type

contains

  !> Adds small-strain stiffness to a model.
  subroutine make_small_strain_model(soil, ratio, threshold, model)
    class(principal_model_type), intent(in) :: soil
    real(wp), intent(in) :: ratio, threshold
    class(soil_model_type), allocatable, intent(out) :: model
    type(small_strain_model_type), allocatable :: made

    allocate (made)
    allocate (made%soil, source=soil)
    made%ratio = ratio
    made%threshold = threshold
    made%state_count = own + soil%state_count
    made%state_names = [unnamed_states(own), soil%state_names]
    made%state_names(at_strain)%text = 'strain_since_reversal'
    made%stiffness_scale = soil%young
    made%shear_scale = soil%shear
    call move_alloc(made, model)
  end subroutine make_small_strain_model

  !> Initialises the state without strain history.
  subroutine start(self, stress, state)
    class(small_strain_model_type), intent(in) :: self
    real(wp), intent(in) :: stress(6)
    real(wp), intent(out) :: state(:)
    real(wp) :: values(3), vectors(3, 3)

    state(:own) = 0.0_wp
    call spectral(unpack_symmetric(stress), values, vectors)
    call self%soil%initial_state(values, state(own + 1:))
  end subroutine start

  !> Tangent shear modulus of the curve at the strain since the last reversal.
  pure real(wp) function shear_modulus(self, stress, state) result(shear)
    class(small_strain_model_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), state(:)
    real(wp) :: values(3), vectors(3, 3)

    call spectral(unpack_symmetric(stress), values, vectors)
    shear = tangent_at(self, state(at_strain), state(at_largest))*self%soil%shear_modulus(values)
  end function shear_modulus

  !> Shear stress of first loading divided by G_ur.
  pure real(wp) function first_curve(self, strain) result(stress)
    class(small_strain_model_type), intent(in) :: self
    real(wp), intent(in) :: strain
    real(wp) :: least

    least = min(strain, self%threshold/decay*(sqrt(self%ratio) - 1.0_wp))
    stress = self%ratio*least/(1.0_wp + decay*least/self%threshold) + strain - least
  end function first_curve

  !> Shear stress since the last reversal divided by G_ur.
  pure real(wp) function stress_since(self, strain, largest) result(stress)
    class(small_strain_model_type), intent(in) :: self
    real(wp), intent(in) :: strain, largest

    if (strain < 2.0_wp*largest) then
      stress = 2.0_wp*first_curve(self, 0.5_wp*strain)
    else
      stress = first_curve(self, strain - largest) + first_curve(self, largest)
    end if
  end function stress_since

  !> Strain of first loading at which the tangent is the same.
  pure real(wp) function first_strain(strain, largest) result(first)
    real(wp), intent(in) :: strain, largest

    first = max(0.5_wp*strain, strain - largest)
  end function first_strain

  !> Tangent modulus divided by G_ur.
  pure real(wp) function tangent_at(self, strain, largest) result(tangent)
    class(small_strain_model_type), intent(in) :: self
    real(wp), intent(in) :: strain, largest

    tangent = max(1.0_wp, self%ratio/(1.0_wp + decay*first_strain(strain, largest)/self%threshold)**2)
  end function tangent_at

  !> Computes G of a step divided by G_ur, and the history at its end.
  pure subroutine follow(self, increment, before, after, modulus)
    class(small_strain_model_type), intent(in) :: self
    !> Strain increment with shear gamma (6), history at the start (own).
    real(wp), intent(in) :: increment(6), before(own)
    real(wp), intent(out) :: after(own), modulus
    real(wp) :: e(3, 3), history(3, 3), values(3), vectors(3, 3), scale(3), first, last, kept
    integer :: i

    after = before
    e = unpack_symmetric([increment(1:3) - sum(increment(1:3))/3.0_wp, 0.5_wp*increment(4:6)])
    modulus = tangent_at(self, before(at_strain), before(at_largest))
    if (.not. norm2(e) > none) return
    call spectral(e, values, vectors)
    history = transformed(transpose(vectors), unpack_symmetric(before(1:6)))
    do i = 1, 3
      scale(i) = 1.0_wp
      if (values(i)*history(i, i) < 0.0_wp) scale(i) = 1.0_wp/sqrt(1.0_wp + history(i, i))
    end do
    history = spread(scale, 2, 3)*(history + identity)*spread(scale, 1, 3) - identity
    history = transformed(vectors, history)
    first = strain_along(history, e)
    kept = 1.0_wp
    if (first < before(at_strain)) kept = first/before(at_strain)
    after(at_largest) = kept*before(at_largest) + (1.0_wp - kept)*max(before(at_largest), &
      first_strain(before(at_strain), before(at_largest)))
    last = strain_along(history + e, e)
    if (abs(last - first) > small*(last + first)) then
      modulus = (stress_since(self, last, after(at_largest)) - stress_since(self, first, after(at_largest))) &
        /(last - first)
    else
      modulus = tangent_at(self, 0.5_wp*(last + first), after(at_largest))
    end if
    call pack_symmetric(history + e, after(1:6))
    after(at_strain) = last
  end subroutine follow

  !> Shear strain g of a history along a strain increment.
  pure real(wp) function strain_along(history, e) result(strain)
    real(wp), intent(in) :: history(3, 3), e(3, 3)

    ! norm2 would spend most of its time on avoiding an overflow that cannot occur with strains.
    strain = sqrt(3.0_wp*sum(matmul(history, e)**2)/sum(e**2))
  end function strain_along

  !> Updates stress, state and tangent by one step.
  subroutine update(self, increment, stress, state, response)
    class(small_strain_model_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    real(wp), intent(inout) :: stress(6), state(:)
    type(soil_response_type), intent(inout) :: response
    type(stress_update_type) :: result
    real(wp) :: history(own), after(own), shear, modulus, values(3), vectors(3, 3), ends(6), by(6), slope(6, 6)

    call pack_symmetric(transformed(increment%rotation, unpack_symmetric(state(1:6))), history(1:6))
    history(7:) = state(7:own)
    call follow(self, increment%strain, history, after, modulus)
    call spectral(unpack_symmetric(stress), values, vectors)
    shear = self%soil%shear_modulus(values)
    call answer(self, increment, stress, state(own + 1:), modulus*shear, increment%wants_tangent, ends, result, slope)
    response%status = result%status
    if (allocated(self%soil%message)) response%message = self%soil%message
    if (result%status /= status_ok) return
    response%plastic = result%yields
    if (increment%wants_tangent) response%tangent = slope
    if (increment%wants_tangent .and. .not. increment%elastic_tangent) then
      call differentiate(self, increment, history, by)
      if (any(abs(by) > 0.0_wp)) response%tangent = slope + spread(modulus_slope(), 2, 6)*spread(by, 1, 6)
    end if
    stress = ends
    state(:own) = after
    state(own + 1:self%state_count) = result%state(:self%soil%state_count)

  contains

    !> d stress / d (G/G_ur) by finite differences: the return is smooth in it.
    function modulus_slope() result(by_modulus)
      real(wp) :: by_modulus(6), up(6), down(6), other(6, 6)
      type(stress_update_type) :: trial

      by_modulus = 0.0_wp
      call answer(self, increment, stress, state(own + 1:), (1.0_wp + small_modulus)*modulus*shear, .false., up, &
        trial, other)
      if (trial%status /= status_ok) return
      call answer(self, increment, stress, state(own + 1:), (1.0_wp - small_modulus)*modulus*shear, .false., down, &
        trial, other)
      if (trial%status == status_ok) by_modulus = (up - down)/(2.0_wp*small_modulus*modulus)
    end function modulus_slope
  end subroutine update

  !> Computes d (G/G_ur) / d strain by finite differences.
  subroutine differentiate(self, increment, history, by)
    class(small_strain_model_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    real(wp), intent(in) :: history(own)
    real(wp), intent(out) :: by(6)
    real(wp) :: strain(6), step, after(own), up, down
    integer :: i

    by = 0.0_wp
    step = small*norm2(increment%strain)
    if (.not. step > none) return
    do i = 1, 6
      strain = increment%strain
      strain(i) = increment%strain(i) + step
      call follow(self, strain, history, after, up)
      strain(i) = increment%strain(i) - step
      call follow(self, strain, history, after, down)
      by(i) = (up - down)/(2.0_wp*step)
    end do
  end subroutine differentiate

  !> Updates the inner model for a given G.
  subroutine answer(self, increment, stress, state, shear, with_tangent, ends, result, slope)
    class(small_strain_model_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    !> Stress and state of the inner model at the start.
    real(wp), intent(in) :: stress(6), state(:)
    real(wp), intent(in) :: shear
    logical, intent(in) :: with_tangent
    !> Stress at the end, result of the inner model, d stress / d strain at that G.
    real(wp), intent(out) :: ends(6)
    type(stress_update_type), intent(out) :: result
    real(wp), intent(out) :: slope(6, 6)
    real(wp) :: values(3), vectors(3, 3), strain(3, 3)
    type(stress_update_type) :: shown
    integer :: i

    call spectral(unpack_symmetric(stress), values, vectors)
    strain = compose(self%soil%elastic_strain(shear, values), vectors) &
      + unpack_symmetric([increment%strain(1:3), 0.5_wp*increment%strain(4:6)])
    call spectral(strain, values, vectors)
    result%yields = .false.
    call self%soil%update(shear, values, state(:self%soil%state_count), increment%cell_size, with_tangent, result)
    slope = 0.0_wp
    ends = stress
    if (result%status /= status_ok) return
    call pack_symmetric(compose(result%stress, vectors), ends)
    if (.not. with_tangent) return
    do i = 1, 6
      slope(i, i) = merge(1.0_wp, 0.5_wp, i <= 3)
    end do
    shown = result
    if (increment%elastic_tangent) call self%soil%elastic_update(shear, values, shown)
    call isotropic_change(vectors, shown%derivative, pair_quotients(values, shown%stress, shown%derivative), 6, slope)
  end subroutine answer
end module qsmpm_small_strain_model
