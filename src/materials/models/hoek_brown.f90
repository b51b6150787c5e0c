!> Linear elasticity bounded by the perfect plasticity of rock masses after Hoek, Carranza-Torres and Corkum (2002).
!>
!> Tension positive, s1 >= s2 >= s3, with m_b, s, a of GSI, m_i and D:
!>   f = s1 - s3 - g(s1) <= 0,  g(t) = s_ci (s - m_b t/s_ci)^a,  t up to T = s s_ci/m_b,
!>   m_b = m_i exp((GSI - 100)/(28 - 14 D)),  s = exp((GSI - 100)/(9 - 3 D)),
!>   a = 1/2 + (exp(-GSI/15) - exp(-20/3))/6.
!> At every t the surface has a Mohr-Coulomb tangent k s1 - s3 = s_c with k = 1 - g' and s_c = g - g' t. A trial stress
!> is returned to the tangent that touches the surface at the final stress, s1 = t(tangent), found by a bracketed
!> Newton's method. The flow is along m e_1 - e_3 with m of the dilatancy angle, or with m = k (associated). As the
!> touching point does not move when the tangent rotates, the derivative is that of Mohr-Coulomb plus a term in m'.
!> A factor F divides the envelope tau(sigma_n) (Hammah, Yacoub, Corkum and Curran 2005): c and tan(phi) of the tangent
!> at a normal stress are divided by F; the circle that it touches there has a different s1.
module qsmpm_hoek_brown
  use qsmpm_kinds, only: wp
  use qsmpm_elastic_model, only: elastic_model_type, set_moduli
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_law, only: status_ok, status_cut
  use qsmpm_law_parameters, only: law_parameters_type, law_description_type, field_visitor_type
  use qsmpm_material_parameters, only: material_parameters_type, check_parameters
  use qsmpm_mohr_coulomb_return, only: mohr_coulomb_type, make_set, return_outside, set_planes, stress_ratio
  use qsmpm_principal_model, only: principal_model_type, stress_update_type
  use qsmpm_strength_factor, only: strength_factor_type, flow_material
  implicit none
  private

  public :: hoek_brown_parameters_type

  integer, parameter, public :: flow_constant = 1, flow_associated = 2
  !> Relative to the stresses: round-off of the yield function, and tolerance of the touching point.
  real(wp), parameter :: round_off = 1.0e-12_wp, near = 1.0e-13_wp
  !> Least distance from T relative to T: the slope of tangents at T is unbounded. Relative step for finite differences.
  real(wp), parameter :: least = 1.0e-9_wp, small = 1.0e-6_wp
  !> Accuracy of the tangent that suffices for a circle that is inside by this share of the stresses.
  real(wp), parameter :: far = 1.0e-2_wp
  integer, parameter :: most_iterations = 100
  !> Sets of active planes: one, two with the same s1, two with the same s3.
  integer, parameter :: shear_sets(3) = [1, 3, 4]

  !> Parameters of the model; the dilatancy angle in degrees; the factor that divides the envelope.
  type, extends(law_parameters_type) :: hoek_brown_parameters_type
    real(wp) :: young = 0.0_wp, poisson = 0.0_wp
    real(wp) :: intact = 0.0_wp, index = 0.0_wp, m_intact = 0.0_wp, disturbance = 0.0_wp, dilatancy_angle = 0.0_wp
    integer :: flow = flow_constant
    type(strength_factor_type) :: by
  contains
    procedure :: describe
    procedure :: fields
    procedure :: make_model
    procedure :: lower
  end type hoek_brown_parameters_type

  !> The constitutive model; it has no state variables.
  type, extends(elastic_model_type) :: hoek_brown_type
    !> s_ci, m_b, s, a, T.
    real(wp) :: intact = 0.0_wp, m_b = 0.0_wp, s = 0.0_wp, a = 0.0_wp, tension = 0.0_wp
    !> Flow ratio m of the dilatancy angle.
    real(wp) :: flow_ratio = 1.0_wp
    logical :: associated_flow = .false.
    type(strength_factor_type) :: by
  contains
    procedure :: update
  end type hoek_brown_type

  !> A tangent: k, m and s_c, and the distance T - s1 of the circle that it touches.
  type :: tangent_type
    real(wp) :: k, m, sc, distance
  end type tangent_type

contains

  !> Describes the keyword and the properties of the model.
  pure type(law_description_type) function describe(self) result(law)
    class(hoek_brown_parameters_type), intent(in) :: self

    law%keyword = 'HOEK BROWN'
    law%sentence = 'Elasticity and the strength of a rock mass after Hoek and Brown (2002) instead of *ELASTIC and '// &
      '*MOHR COULOMB. A factor of safety divides the envelope of shear strength.'
    law%example = '*HOEK BROWN| 5e6, 0.3, 30000, 5, 2, 0'
    law%linear_elasticity = .true.
    law%poisson = self%poisson
    law%has_strength = .true.
    law%associated_flow = self%flow == flow_associated
    law%failure_ties_volume = .true.
    law%dilatancy_angle = self%dilatancy_angle
  end function describe

  !> Visits the fields of the keyword.
  subroutine fields(self, visitor)
    class(hoek_brown_parameters_type), intent(inout) :: self
    class(field_visitor_type), intent(inout) :: visitor

    call visitor%law_choice('FLOW', self%flow, 'CONSTANT|ASSOCIATED', 'with one dilatancy angle (not above the '// &
      'friction angle at the stress), or normal to the surface')
    call visitor%law_data('elasticity and strength')
    call visitor%law_number('E', self%young, "Young's modulus of the rock mass", '(0, inf)')
    call visitor%law_number('nu', self%poisson, "Poisson's ratio", '(-1, 0.5)')
    call visitor%law_number('sigma_ci', self%intact, 'uniaxial strength of the intact rock', '(0, inf)')
    call visitor%law_number('GSI', self%index, 'geological strength index', '[1, 100]')
    call visitor%law_number('m_i', self%m_intact, 'constant of the intact rock', '(0, inf)')
    call visitor%law_number('D', self%disturbance, 'disturbance by blasting and relief', '[0, 1]')
    call visitor%law_number('psi', self%dilatancy_angle, 'dilatancy angle with FLOW=CONSTANT', '[0, 90)', &
      required=.false.)
  end subroutine fields

  !> Makes the model.
  subroutine make_model(self, model, error)
    class(hoek_brown_parameters_type), intent(in) :: self
    class(principal_model_type), allocatable, intent(out) :: model
    type(error_type), allocatable, intent(out) :: error
    type(material_parameters_type) :: elastic
    type(hoek_brown_type) :: made

    elastic = material_parameters_type(self%young, self%poisson)
    call check_parameters(elastic, error)
    if (allocated(error)) return
    call set_moduli(elastic, made)
    made%elastic = .false.
    made%symmetric = self%flow == flow_associated
    made%intact = self%intact
    made%m_b = self%m_intact*exp((self%index - 100.0_wp)/(28.0_wp - 14.0_wp*self%disturbance))
    made%s = exp((self%index - 100.0_wp)/(9.0_wp - 3.0_wp*self%disturbance))
    made%a = 0.5_wp + (exp(-self%index/15.0_wp) - exp(-20.0_wp/3.0_wp))/6.0_wp
    made%tension = made%s*made%intact/made%m_b
    made%flow_ratio = stress_ratio(self%dilatancy_angle)
    made%associated_flow = self%flow == flow_associated
    made%by = self%by
    made%message = 'no return to the strength of Hoek and Brown'
    allocate (model, source=made)
  end subroutine make_model

  !> Reduces the strength: the model divides its envelope by the factor.
  subroutine lower(self, by, error)
    class(hoek_brown_parameters_type), intent(inout) :: self
    type(strength_factor_type), intent(in) :: by
    !> error_deck: a flow rule that would change the envelope.
    type(error_type), allocatable, intent(out) :: error

    if (by%flow /= flow_material) then
      call fail(error, error_deck, '*HOEK BROWN is lowered by FLOW=MATERIAL alone: for associated flow write '// &
        '*HOEK BROWN, FLOW=ASSOCIATED')
      return
    end if
    self%by = strength_factor_type(self%by%factor*by%factor)
  end subroutine lower

  !> Returns the trial stress to the strength envelope.
  pure subroutine update(self, modulus, trial, state, cell_size, with_derivative, result)
    class(hoek_brown_type), intent(in) :: self
    !> G; principal trial stresses (3); no state variables; the cell size is not used.
    real(wp), intent(in) :: modulus, trial(3), state(self%state_count)
    real(wp), intent(in) :: cell_size
    !> Whether the derivative is required.
    logical, intent(in) :: with_derivative
    type(stress_update_type), intent(inout) :: result
    real(wp) :: w, largest, scale, r(3), touch_rate
    integer :: j

    result%status = status_ok
    largest = max(trial(1), trial(2), trial(3))
    scale = maxval(abs(trial)) + self%tension
    result%yields = largest >= self%tension
    w = 1.0e-3_wp*self%tension
    if (.not. result%yields) then
      w = self%tension - largest
      call find_touching(self, largest, largest - min(trial(1), trial(2), trial(3)), scale, w, result%yields)
    end if
    if (.not. result%yields) return
    call return_to_tangent(self, trial, scale, w, result)
    if (.not. (with_derivative .and. w > 0.0_wp)) return
    call turn_tangent(self, trial, w, result, r, touch_rate)
    j = maxloc(trial, 1)
    result%derivative = result%derivative + spread(r, 2, 3)*spread(result%derivative(j, :), 1, 3)/(touch_rate - r(j))
  end subroutine update

  !> Finds the tangent that touches the surface at the s1 of a circle, and whether the circle is outside of it.
  pure subroutine find_touching(self, largest, difference, scale, w, outside)
    class(hoek_brown_type), intent(in) :: self
    !> s1 below T, s1 - s3, and the magnitude of the stresses.
    real(wp), intent(in) :: largest, difference, scale
    !> T - t: initial guess on entry, solution on exit, approximate where the circle is far inside.
    real(wp), intent(inout) :: w
    logical, intent(out) :: outside
    type(tangent_type) :: tangent
    real(wp) :: excess, wanted, off
    integer :: i

    wanted = self%tension - largest
    do i = 1, most_iterations
      tangent = tangent_at(self, w)
      excess = difference + (tangent%k - 1.0_wp)*largest - tangent%sc
      off = abs(tangent%distance/wanted - 1.0_wp)
      ! The error of a tangent next to the touching one is of second order in the distance between them.
      if (off <= near .or. (off <= far .and. excess < -far*scale)) exit
      w = w*wanted/tangent%distance
    end do
    outside = excess > round_off*scale
  end subroutine find_touching

  !> Returns to the tangent that touches at the final stress, s1 = T - distance(w), by Newton's method in log(w).
  pure subroutine return_to_tangent(self, trial, scale, w, result)
    class(hoek_brown_type), intent(in) :: self
    real(wp), intent(in) :: trial(3), scale
    !> T - t: initial guess on entry, solution on exit; 0 at the apex, where all stresses are T.
    real(wp), intent(inout) :: w
    type(stress_update_type), intent(inout) :: result
    type(tangent_type) :: tangent
    type(mohr_coulomb_type) :: strength
    real(wp) :: low, high, found, r(3), touch_rate
    integer :: i, j

    strength%has_apex = .true.
    low = least*self%tension
    high = huge(1.0_wp)
    do i = 1, most_iterations
      tangent = tangent_at(self, w)
      strength%k = tangent%k
      strength%m = tangent%m
      strength%sc = tangent%sc
      strength%apex = tangent%sc/(tangent%k - 1.0_wp)
      do j = 1, size(shear_sets)
        call make_set(strength, set_planes(:, shear_sets(j)), self%trial_lame, self%trial_shear, &
          strength%sets(shear_sets(j)))
      end do
      call return_outside(strength, trial, result%stress, result%derivative)
      found = self%tension - max(result%stress(1), result%stress(2), result%stress(3))
      if (abs(found - tangent%distance) <= near*scale .or. high - low <= near*high) return
      if (found > tangent%distance) then
        low = w
      else
        high = w
        if (w <= least*self%tension) exit
      end if
      call turn_tangent(self, trial, w, result, r, touch_rate)
      found = max(found, 0.0_wp)
      w = next_place(w*(found/tangent%distance)**(1.0_wp/(w*touch_rate/tangent%distance &
        - w*r(maxloc(trial, 1))/max(found, tiny(1.0_wp)))), low, high)
    end do
    result%stress = self%tension
    result%derivative = 0.0_wp
    if (w > least*self%tension) result%status = status_cut
    w = 0.0_wp
  end subroutine return_to_tangent

  !> The iterate of Newton's method, or a point of its bracket where the iterate is outside.
  pure real(wp) function next_place(newton, low, high)
    real(wp), intent(in) :: newton, low, high

    next_place = newton
    if (newton > low .and. newton < high) return
    next_place = max(low, 0.1_wp*high)
    if (newton >= high) next_place = sqrt(low)*sqrt(high)
  end function next_place

  !> Computes the change of the stress with t, which changes the flow ratio m of the tangent: with S the derivative of
  !> the return and v the plastic strain along 1 (or 1 and 2) over m, r = -S D v m'; the tangent rotates about the
  !> stress. Thus d stress = S d trial + r dt with d s1 = touch_rate dt.
  pure subroutine turn_tangent(self, trial, w, result, r, touch_rate)
    class(hoek_brown_type), intent(in) :: self
    real(wp), intent(in) :: trial(3), w
    !> Stress and S.
    type(stress_update_type), intent(in) :: result
    real(wp), intent(out) :: r(3), touch_rate
    type(tangent_type) :: tangent, beside
    real(wp) :: strain(3)

    tangent = tangent_at(self, w)
    beside = tangent_at(self, (1.0_wp + small)*w)
    touch_rate = (beside%distance - tangent%distance)/(small*w)
    strain = max(self%elastic_strain(self%shear, trial - result%stress), 0.0_wp)/tangent%m
    r = (beside%m - tangent%m)/(small*w)* &
      matmul(result%derivative, self%trial_lame*sum(strain) + 2.0_wp*self%shear*strain)
  end subroutine turn_tangent

  !> Tangent at s1 = T - w of the surface, divided by the factor: tan(phi) = (k - 1)/(2 k^1/2), c = s_c/(2 k^1/2),
  !> and k^1/2 = tan(phi) + (1 + tan(phi)^2)^1/2 of the reduced angle.
  pure type(tangent_type) function tangent_at(self, w) result(tangent)
    class(hoek_brown_type), intent(in) :: self
    real(wp), intent(in) :: w
    real(wp) :: g, slope, root, friction, lower_root

    g = self%intact*(self%m_b*w/self%intact)**self%a
    slope = self%a*g/w
    root = sqrt(1.0_wp + slope)
    friction = 0.5_wp*slope/(root*self%by%factor)
    lower_root = friction + sqrt(1.0_wp + friction**2)
    tangent%k = lower_root**2
    tangent%m = tangent%k
    if (.not. self%associated_flow) tangent%m = min(self%flow_ratio, tangent%k)
    tangent%sc = (g + slope*(self%tension - w))/(root*self%by%factor)*lower_root
    ! The circle of t touches its envelope g/(1 + k) below t, at the shear stress g k^1/2/(1 + k).
    tangent%distance = w + g/(2.0_wp + slope)*(1.0_wp - root/(self%by%factor*lower_root))
  end function tangent_at
end module qsmpm_hoek_brown
