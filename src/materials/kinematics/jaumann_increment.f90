!> Stress increment of the Jaumann rate law over a step in three dimensions.
!>
!> The law is d(sigma) = D d(eps) - sigma tr d(eps) + W sigma - sigma W (Beuth et al. 2008, eqs. 8
!> and 11; their omega of eq. 10 is -W). Two rules integrate it:
!> - paper: eqs. 9, 10 and 26 with the stress at the start in all terms, first order;
!> - midpoint: strain and spin on the mid configuration, half the finite rotation R before and half
!>   after the strain increment, -sigma tr d(eps) with the mean of both stresses:
!>     (1 + tr/2) sigma_trial = (1 - tr/2) R sigma0 R^T + D d(eps),
!>     sigma = R return(sigma_trial) R^T,
!>   second order, objective, and exact under confined compression in any number of steps.
!> With the Cauchy rate, the usual one of a UMAT, both rules are without the terms -sigma tr d(eps).
!> Both rules have one form, whose terms `rotated_increment_type` stores. The return mapping and the derivative are in
!> qsmpm_jaumann_solid; plane problems have a separate formulation, qsmpm_jaumann_plane.
!>
!> Kinematics of the midpoint rule (Hughes and Winget 1980).
!>
!> G = (F - I) ((F + I)/2)^-1 is the displacement gradient on the mid configuration: its symmetric
!> part is the strain increment, and the Cayley transform of its skew part W is a finite rotation
!> that is exact for a rigid rotation. Here the rotation is halved: half before and half after the
!> strain increment makes the rule second-order accurate. With t = axial(W)/2 the half rotation is by the
!> angle atan |t| about t.
module qsmpm_jaumann_increment
  use qsmpm_kinds, only: wp
  use qsmpm_tensor, only: cofactor, identity
  implicit none
  private

  public :: rotated_increment_type, make_increment, is_cauchy, half_rotation, rotation_jacobian, axial

  !> Integration of the rate of J sigma, numbered as in the deck's description, and of that of sigma.
  integer, parameter, public :: rate_paper = 1, rate_midpoint = 2, rate_paper_cauchy = 3, rate_midpoint_cauchy = 4

  !> Smallest 1 + tr/2 of the midpoint rule; at 0 the volume is compressed to zero.
  real(wp), parameter, public :: smallest_pivot = 1.0e-3_wp

  !> sigma_trial = (keep start + D d(eps) - ...)/pivot, and the data of its derivative.
  type :: rotated_increment_type
    !> Whether the stress is rotated by `rotation` before and after the strain increment.
    logical :: turns = .false.
    !> ((F + I)/2)^-1, not used where the stress is not rotated: dG = mid dF mid (3,3).
    real(wp) :: mid(3, 3) = 0.0_wp
    !> Half rotation, not used where the stress is not rotated (3,3).
    real(wp) :: rotation(3, 3) = 0.0_wp
    !> Derivative of the spin of the half rotation with respect to the axial vector of dG (3,3).
    real(wp) :: spin(3, 3) = 0.0_wp
    !> Start stress after the first half rotation (3,3).
    real(wp) :: start(3, 3) = 0.0_wp
    !> The stress that is multiplied by -tr d(eps) (3,3).
    real(wp) :: volume_stress(3, 3) = 0.0_wp
    !> Trial stress (3,3).
    real(wp) :: trial(3, 3) = 0.0_wp
    real(wp) :: keep = 1.0_wp
    real(wp) :: pivot = 1.0_wp
  end type rotated_increment_type

contains

  !> Computes the trial stress of a step.
  pure subroutine make_increment(rate, lame, shear, f, stress, increment, ok)
    !> One of rate_*.
    integer, intent(in) :: rate
    !> Lame's first modulus; shear modulus; incremental deformation gradient (3,3).
    real(wp), intent(in) :: lame, shear, f(3, 3)
    !> Cauchy stress at the start (3,3).
    real(wp), intent(in) :: stress(3, 3)
    type(rotated_increment_type), intent(out) :: increment
    !> False when the step is too large for the rule.
    logical, intent(out) :: ok
    logical :: cauchy

    cauchy = is_cauchy(rate)
    if (rate == rate_paper .or. rate == rate_paper_cauchy) then
      ok = .true.
      call paper_increment(lame, shear, cauchy, f - identity, stress, increment)
    else
      call midpoint_increment(lame, shear, cauchy, f, stress, increment, ok)
    end if
  end subroutine make_increment

  !> Whether the rate is that of the Cauchy stress sigma.
  pure logical function is_cauchy(rate)
    !> One of rate_*.
    integer, intent(in) :: rate

    is_cauchy = rate == rate_paper_cauchy .or. rate == rate_midpoint_cauchy
  end function is_cauchy

  !> Computes the increment by eq. 26 with eqs. 9 and 10.
  pure subroutine paper_increment(lame, shear, cauchy, g, stress, increment)
    !> Lame's first modulus; shear modulus.
    real(wp), intent(in) :: lame, shear
    !> Whether the rate is that of sigma.
    logical, intent(in) :: cauchy
    !> Displacement gradient on the start configuration (3,3); Cauchy stress at the start (3,3).
    real(wp), intent(in) :: g(3, 3), stress(3, 3)
    type(rotated_increment_type), intent(out) :: increment
    real(wp) :: spin(3, 3), turn(3, 3)

    increment%spin = identity
    increment%start = stress
    if (.not. cauchy) increment%volume_stress = stress
    spin = 0.5_wp*(g - transpose(g))
    turn = matmul(spin, stress)
    increment%trial = stress + turn + transpose(turn) + hooke(lame, shear, g) - trace(g)*increment%volume_stress
  end subroutine paper_increment

  !> Computes the increment by the midpoint rule.
  pure subroutine midpoint_increment(lame, shear, cauchy, f, stress, increment, ok)
    !> Lame's first modulus; shear modulus.
    real(wp), intent(in) :: lame, shear
    !> Whether the rate is that of sigma.
    logical, intent(in) :: cauchy
    !> Incremental deformation gradient (3,3); Cauchy stress at the start (3,3).
    real(wp), intent(in) :: f(3, 3), stress(3, 3)
    type(rotated_increment_type), intent(out) :: increment
    !> False when the mid configuration is inverted or compressed to zero volume.
    logical, intent(out) :: ok
    real(wp) :: half(3, 3), g(3, 3), t(3), det

    half = 0.5_wp*(f + identity)
    g = cofactor(half)
    det = dot_product(half(:, 1), g(:, 1))
    ok = det > 0.0_wp
    if (.not. ok) return
    increment%mid = transpose(g)*(1.0_wp/det)
    half = f - identity
    g = matmul(half, increment%mid)
    if (.not. cauchy) then
      increment%pivot = 1.0_wp + 0.5_wp*trace(g)
      increment%keep = 1.0_wp - 0.5_wp*trace(g)
    end if
    ok = increment%pivot > smallest_pivot
    if (.not. ok) return
    t = 0.5_wp*axial(g)
    increment%turns = .true.
    increment%rotation = half_rotation(t)
    increment%spin = 0.5_wp*rotation_jacobian(t)
    half = transpose(increment%rotation)
    half = matmul(stress, half)
    increment%start = matmul(increment%rotation, half)
    increment%trial = (increment%keep*increment%start + hooke(lame, shear, g))*(1.0_wp/increment%pivot)
    if (.not. cauchy) increment%volume_stress = 0.5_wp*(increment%start + increment%trial)
  end subroutine midpoint_increment

  !> Elastic stress of the symmetric part of a gradient.
  pure function hooke(lame, shear, g) result(stress)
    !> Lame's first modulus; shear modulus; displacement gradient (3,3).
    real(wp), intent(in) :: lame, shear, g(3, 3)
    real(wp) :: stress(3, 3), mean
    integer :: i

    stress = shear*(g + transpose(g))
    mean = lame*trace(g)
    do i = 1, 3
      stress(i, i) = stress(i, i) + mean
    end do
  end function hooke

  !> Trace.
  pure real(wp) function trace(a)
    !> Tensor (3,3).
    real(wp), intent(in) :: a(3, 3)

    trace = a(1, 1) + a(2, 2) + a(3, 3)
  end function trace

  !> Half of the rotation of a spin increment.
  pure function half_rotation(t) result(rotation)
    !> Half the axial vector of W (3).
    real(wp), intent(in) :: t(3)
    real(wp) :: rotation(3, 3), c, g
    integer :: i

    c = 1.0_wp/sqrt(1.0_wp + dot_product(t, t))
    g = c*c/(1.0_wp + c)
    do i = 1, 3
      rotation(:, i) = g*t(i)*t
      rotation(i, i) = rotation(i, i) + c
    end do
    rotation = rotation + c*skew(t)
  end function half_rotation

  !> L of d(rotation) rotation^T = skew(L dt): for the rotation about n with tan(angle) = |t|,
  !> L = c^2 n n^T + (sin/|t|)(I - n n^T) + ((1 - cos)/|t|) skew(n).
  pure function rotation_jacobian(t) result(jacobian)
    !> Half the axial vector of W (3).
    real(wp), intent(in) :: t(3)
    real(wp) :: jacobian(3, 3), c, g
    integer :: i

    ! sin/|t| = c, (1 - cos)/|t|^2 = g, and (c^2 - c)/|t|^2 = -c g.
    c = 1.0_wp/sqrt(1.0_wp + dot_product(t, t))
    g = c*c/(1.0_wp + c)
    do i = 1, 3
      jacobian(:, i) = -c*g*t(i)*t
      jacobian(i, i) = jacobian(i, i) + c
    end do
    jacobian = jacobian + g*skew(t)
  end function rotation_jacobian

  !> Axial vector of the skew part of a tensor: skew(axial(a)) = (a - a^T)/2.
  pure function axial(a) result(vector)
    !> Tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    real(wp) :: vector(3)

    vector = 0.5_wp*[a(3, 2) - a(2, 3), a(1, 3) - a(3, 1), a(2, 1) - a(1, 2)]
  end function axial

  !> Skew tensor of an axial vector.
  pure function skew(vector) result(a)
    !> Axial vector (3).
    real(wp), intent(in) :: vector(3)
    real(wp) :: a(3, 3)

    a(:, 1) = [0.0_wp, vector(3), -vector(2)]
    a(:, 2) = [-vector(3), 0.0_wp, vector(1)]
    a(:, 3) = [vector(2), -vector(1), 0.0_wp]
  end function skew
end module qsmpm_jaumann_increment
