!> Linear elasticity bounded by perfect plasticity after Drucker and Prager (1952), in principal values.
!>
!> With I = tr(sigma), s the deviator, J = s:s/2, tension positive:
!>   yield f = J^1/2 + a I - k <= 0,   flow g = J^1/2 + b I,
!>   return to the cone with l = f(trial)/(G + 9 K a b):  s = (1 - G l/J_trial^1/2) s_trial,  I = I_trial - 9 K b l,
!>   or to the apex I = k/a, s = 0 where the first factor would be negative.
!> a, b and k match Mohr-Coulomb with c, phi and psi in triaxial compression, in triaxial extension or in plane strain.
!> In plane strain plastic flow has no strain along 3, s_33 = -2 b J^1/2. With D = (1 - 3 b^2)^1/2 the radius R and the
!> centre m of Mohr's circle at failure satisfy R (1 - 3 a b)/D = k - 3 a m, set equal to R = c cos(phi) - m sin(phi).
module qsmpm_drucker_prager
  use qsmpm_kinds, only: wp, pi
  use qsmpm_elastic_model, only: elastic_model_type, set_moduli
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_law, only: status_ok
  use qsmpm_law_parameters, only: law_parameters_type, law_description_type, field_visitor_type
  use qsmpm_material_parameters, only: material_parameters_type, check_parameters
  use qsmpm_principal_model, only: principal_model_type, stress_update_type
  use qsmpm_strength_factor, only: strength_factor_type, lower_strength
  use qsmpm_tensor, only: identity
  implicit none
  private

  public :: drucker_prager_parameters_type

  !> Stress states in which the cone matches Mohr-Coulomb, in the order of the values of the keyword parameter.
  integer, parameter, public :: cone_compression = 1, cone_extension = 2, cone_plane_strain = 3
  !> Round-off of the yield function relative to the stresses.
  real(wp), parameter :: round_off = 1.0e-12_wp

  !> Parameters of the model; angles in degrees.
  type, extends(law_parameters_type) :: drucker_prager_parameters_type
    real(wp) :: young = 0.0_wp, poisson = 0.0_wp
    real(wp) :: cohesion = 0.0_wp, friction_angle = 0.0_wp, dilatancy_angle = 0.0_wp
    integer :: cone = cone_compression
  contains
    procedure :: describe
    procedure :: fields
    procedure :: make_model
    procedure :: lower
  end type drucker_prager_parameters_type

  !> The constitutive model; it has no state variables.
  type, extends(elastic_model_type) :: drucker_prager_type
    !> a, b, k, and 3 K.
    real(wp) :: a = 0.0_wp, b = 0.0_wp, k = 0.0_wp, bulk3 = 0.0_wp
  contains
    procedure :: update
  end type drucker_prager_type

contains

  !> Describes the keyword and the properties of the model.
  pure type(law_description_type) function describe(self) result(law)
    class(drucker_prager_parameters_type), intent(in) :: self

    law%keyword = 'DRUCKER PRAGER'
    law%sentence = 'Elasticity and the cone of Drucker and Prager instead of *ELASTIC and *MOHR COULOMB, with the '// &
      'strength of Mohr-Coulomb in one state of stress. Angles in degrees.'
    law%example = '*DRUCKER PRAGER, CONE=PLANE STRAIN| 200, 0.33, 1, 25, 0'
    law%linear_elasticity = .true.
    law%poisson = self%poisson
    law%has_strength = .true.
    law%associated_flow = .not. self%dilatancy_angle < self%friction_angle
    law%failure_ties_volume = .true.
    law%dilatancy_angle = self%dilatancy_angle
    law%friction_angle = self%friction_angle
    law%cohesion = self%cohesion
    law%failure_keeps_volume = .not. self%friction_angle > 0.0_wp
  end function describe

  !> Visits the fields of the keyword.
  subroutine fields(self, visitor)
    class(drucker_prager_parameters_type), intent(inout) :: self
    class(field_visitor_type), intent(inout) :: visitor

    call visitor%law_choice('CONE', self%cone, 'COMPRESSION|EXTENSION|PLANE STRAIN', 'where the strength is that '// &
      'of Mohr-Coulomb: triaxial compression, triaxial extension, failure in plane strain')
    call visitor%law_data('elasticity and strength')
    call visitor%law_number('E', self%young, "Young's modulus", '(0, inf)')
    call visitor%law_number('nu', self%poisson, "Poisson's ratio", '(-1, 0.5)')
    call visitor%law_number('c', self%cohesion, 'cohesion', '[0, inf)')
    call visitor%law_number('phi', self%friction_angle, 'friction angle', '[0, 90)')
    call visitor%law_number('psi', self%dilatancy_angle, 'dilatancy angle, not above phi', '[0, 90)')
  end subroutine fields

  !> Makes the model; the parameters are checked as those of Mohr-Coulomb.
  subroutine make_model(self, model, error)
    class(drucker_prager_parameters_type), intent(in) :: self
    class(principal_model_type), allocatable, intent(out) :: model
    type(error_type), allocatable, intent(out) :: error
    type(material_parameters_type) :: matched
    type(drucker_prager_type) :: made

    matched = material_parameters_type(self%young, self%poisson, .true., self%cohesion, self%friction_angle, &
      self%dilatancy_angle)
    call check_parameters(matched, error)
    if (allocated(error)) return
    call set_moduli(matched, made)
    made%elastic = .false.
    made%symmetric = .not. self%dilatancy_angle < self%friction_angle
    made%bulk3 = 3.0_wp*made%trial_lame + 2.0_wp*made%shear
    call match_cone(self, made)
    allocate (model, source=made)
  end subroutine make_model

  !> Reduces the strength of the Mohr-Coulomb soil to which the cone is matched.
  subroutine lower(self, by, error)
    class(drucker_prager_parameters_type), intent(inout) :: self
    type(strength_factor_type), intent(in) :: by
    !> Never set.
    type(error_type), allocatable, intent(out) :: error

    call lower_strength(by, self%cohesion, self%friction_angle, self%dilatancy_angle)
  end subroutine lower

  !> Computes a, b and k.
  pure subroutine match_cone(parameters, model)
    class(drucker_prager_parameters_type), intent(in) :: parameters
    type(drucker_prager_type), intent(inout) :: model
    real(wp) :: friction, dilatancy, cohesion, t, d

    friction = sin(parameters%friction_angle*pi/180.0_wp)
    dilatancy = sin(parameters%dilatancy_angle*pi/180.0_wp)
    cohesion = parameters%cohesion*cos(parameters%friction_angle*pi/180.0_wp)
    if (parameters%cone == cone_plane_strain) then
      t = tan(parameters%dilatancy_angle*pi/180.0_wp)
      model%b = t/sqrt(9.0_wp + 12.0_wp*t**2)
      d = sqrt(1.0_wp - 3.0_wp*model%b**2)
      model%a = friction/(3.0_wp*(d + friction*model%b))
      model%k = cohesion*(1.0_wp - 3.0_wp*model%a*model%b)/d
    else
      t = 1.0_wp
      if (parameters%cone == cone_compression) t = -1.0_wp
      model%b = 2.0_wp*dilatancy/(sqrt(3.0_wp)*(3.0_wp + t*dilatancy))
      model%a = 2.0_wp*friction/(sqrt(3.0_wp)*(3.0_wp + t*friction))
      model%k = 6.0_wp*cohesion/(sqrt(3.0_wp)*(3.0_wp + t*friction))
    end if
  end subroutine match_cone

  !> Returns the trial stress to the cone or to its apex.
  pure subroutine update(self, modulus, trial, state, cell_size, with_derivative, result)
    class(drucker_prager_type), intent(in) :: self
    !> G; principal trial stresses (3); no state variables; the cell size is not used.
    real(wp), intent(in) :: modulus, trial(3), state(self%state_count)
    real(wp), intent(in) :: cell_size
    !> Whether the derivative is required.
    logical, intent(in) :: with_derivative
    type(stress_update_type), intent(inout) :: result
    real(wp) :: mean, deviator(3), root, excess, l, keep

    result%status = status_ok
    mean = (trial(1) + trial(2) + trial(3))/3.0_wp
    deviator = trial - mean
    root = sqrt(0.5_wp*(deviator(1)**2 + deviator(2)**2 + deviator(3)**2))
    excess = root + 3.0_wp*self%a*mean - self%k
    result%yields = excess > round_off*(root + abs(mean) + self%k)
    if (.not. result%yields) return
    l = excess/(modulus + 3.0_wp*self%bulk3*self%a*self%b)
    if (root > modulus*l) then
      keep = 1.0_wp - modulus*l/root
      result%stress = keep*deviator + mean - self%bulk3*self%b*l
      if (with_derivative) call differentiate(self, modulus, deviator, root, l, keep, result%derivative)
    else
      result%stress = self%k/(3.0_wp*self%a)
      result%derivative = 0.0_wp
    end if
  end subroutine update

  !> Computes d stress / d trial stress on the cone: with q = s_trial/J^1/2, dl = (q/2 + a)/(G + 9 K a b).
  pure subroutine differentiate(self, modulus, deviator, root, l, keep, derivative)
    class(drucker_prager_type), intent(in) :: self
    real(wp), intent(in) :: modulus
    !> s_trial, J_trial^1/2, l, and the factor applied to s_trial.
    real(wp), intent(in) :: deviator(3), root, l, keep
    real(wp), intent(out) :: derivative(3, 3)
    real(wp) :: q(3), by_l
    integer :: j

    q = deviator/root
    do j = 1, 3
      by_l = (0.5_wp*q(j) + self%a)/(modulus + 3.0_wp*self%bulk3*self%a*self%b)
      derivative(:, j) = keep*(identity(:, j) - 1.0_wp/3.0_wp) + 1.0_wp/3.0_wp - self%bulk3*self%b*by_l &
        + modulus*q*(0.5_wp*l*q(j)/root - by_l)
    end do
  end subroutine differentiate
end module qsmpm_drucker_prager
