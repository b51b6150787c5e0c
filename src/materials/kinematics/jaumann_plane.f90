!> The Jaumann rate (qsmpm_principal_law) in plane strain and axisymmetry.
!>
!> Symmetric tensors are stored as in qsmpm_plane_frame, in the frame at the end of the step, in which
!> dG = (R mid) dF (mid R^T). The trial, a stress of Hookean models and the elastic strain of the others, changes by a
!> matrix times mean, half difference and shear of the symmetric part of dG, its spin (dG_21 - dG_12)/2, and dG_33.
!> All quantities are scalars: the half rotation R by t = tan(angle) has cos = 1/(1 + t^2)^(1/2), and rotates a tensor
!> by cos2 = (1 - t^2) cos^2, sin2 = 2 t cos^2; the spin of R is half of cos^2 times that of dG.
module qsmpm_jaumann_plane
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: pair_quotient
  use qsmpm_jaumann_increment, only: rate_paper, rate_paper_cauchy, smallest_pivot, is_cauchy
  use qsmpm_law, only: batch_type, status_ok, status_cut, status_failed, tangent_none, tangent_elastic
  use qsmpm_plane_frame, only: to_principal, from_principal, frame_map, plane_piola
  use qsmpm_principal_model, only: principal_model_type, stress_update_type, blend_elastic, keep_update, elastic_share
  implicit none
  private

  public :: update_plane

  !> A step of a point up to its trial. It has no default values, which would cost time at every point.
  type :: stress_step_type
    !> Whether the stress is rotated before and after the strain increment.
    logical :: turns
    !> Whether the rate is that of J sigma, with the terms -sigma tr d(eps).
    logical :: volume
    !> Half rotation: cosine, tangent, and the rotation of a tensor.
    real(wp) :: cosine, t, cos2, sin2
    !> Derivative of the spin of the half rotation with respect to the spin of dG.
    real(wp) :: spin
    !> ((F + I)/2)^-1: 11, 21, 12, 22, 33.
    real(wp) :: mid(5)
    real(wp) :: keep, pivot
    !> Lame's moduli of the trial.
    real(wp) :: lame, shear
    !> Stress or elastic strain at the start after the first half rotation, and trial: mean, half difference, shear, 33.
    real(wp) :: start(4), trial(4)
  end type stress_step_type

contains

  !> Updates a batch; points with a status other than ok are incomplete. The loop works on the arrays themselves,
  !> because components of the batch would be dereferenced at every point.
  pure subroutine update_plane(model, rate, blend, batch, tangent)
    class(principal_model_type), intent(in) :: model
    !> One of rate_* of qsmpm_jaumann_increment.
    integer, intent(in) :: rate
    !> Share of the elastic tangent in the consistent one.
    real(wp), intent(in) :: blend
    type(batch_type), intent(inout) :: batch
    !> Requested tangent.
    integer, intent(in) :: tangent

    call update_points(model, rate, elastic_share(tangent, blend), tangent, batch%count, size(batch%state, 1), &
      batch%gradient, batch%stress_start, batch%state_start, batch%cell_size, batch%stress, batch%state, batch%piola, &
      batch%tangent, batch%status, batch%plastic, batch%message)
  end subroutine update_plane

  !> Updates the points of a batch.
  pure subroutine update_points(model, rate, share, tangent, n, m, gradient, stress_start, state_start, cell_size, &
    stress, state, piola, a, status, plastic, message)
    class(principal_model_type), intent(in) :: model
    !> Rate, share of the elastic tangent, requested tangent.
    integer, intent(in) :: rate
    real(wp), intent(in) :: share
    integer, intent(in) :: tangent
    !> Number of points, and of state variables of a point.
    integer, intent(in) :: n, m
    !> As in batch_type.
    real(wp), intent(in) :: gradient(5, n), stress_start(4, n), state_start(m, n)
    real(wp), intent(in), optional :: cell_size(n)
    real(wp), intent(inout) :: stress(4, n), state(m, n), piola(5, n)
    real(wp), intent(inout), optional :: a(5, 5, n)
    integer, intent(inout) :: status(n), plastic(n)
    character(len=:), allocatable, intent(inout) :: message
    type(stress_step_type) :: step
    type(stress_update_type) :: result
    real(wp) :: end(4), map(4, 4), lame, shear, modulus, width, value(3), c, s, turn(4)
    logical :: principal, paper, cauchy
    integer :: p

    map = 0.0_wp
    lame = model%trial_lame
    shear = model%trial_shear
    modulus = model%shear
    width = 0.0_wp
    paper = rate == rate_paper .or. rate == rate_paper_cauchy
    cauchy = is_cauchy(rate)
    result%yields = .false.
    do p = 1, n
      call make_step(model, lame, shear, paper, cauchy, gradient(:, p), stress_start(:, p), modulus, step, status(p))
      if (status(p) /= status_ok) cycle
      if (.not. model%elastic) then
        value = principal_values(step%trial(1), step%trial(2), step%trial(3), step%trial(4))
        if (model%asks_cell_size .and. present(cell_size)) width = cell_size(p)
        call model%update(modulus, value, state_start(:, p), width, tangent /= tangent_none, result)
        if (m > 0 .or. result%status /= status_ok) call keep_update(model, result, state_start(:, p), state(:, p), &
          status(p), message)
        if (status(p) /= status_ok) cycle
      end if
      plastic(p) = merge(1, 0, result%yields)
      principal = result%yields .or. .not. model%hookean
      if (principal) then
        call to_principal(step%trial(1), step%trial(2), step%trial(3), step%trial(4), value, c, s)
        turn = turned(step, [0.0_wp, c, s, 0.0_wp])
        end = from_principal(result%stress, turn(2), turn(3))
      else
        end = turned(step, step%trial)
      end if
      stress(:, p) = stress_order(end)
      call plane_piola(stress(:, p), gradient(:, p), piola(:, p))
      if (tangent == tangent_none) cycle
      if (principal) then
        ! Only one pair of directions rotates in the plane.
        result%quotient = pair_quotient(value, result%stress, result%derivative, 1, 2)
        call blend_elastic(model, modulus, value, share, result)
        end = from_principal(result%stress, turn(2), turn(3))
        map = frame_map(result%derivative, result%quotient(1), turn(2), turn(3))
      end if
      ! [K^E + K^G]^0 corresponds to the rate of J sigma.
      if (tangent == tangent_elastic .and. model%hookean) step%volume = .true.
      call point_tangent(step, principal, map, end, gradient(:, p), a(:, :, p))
    end do
  end subroutine update_points

  !> Computes the elastic strain of a Cauchy stress.
  pure subroutine start_strain(model, tensor, modulus)
    class(principal_model_type), intent(in) :: model
    !> In: Cauchy stress. Out: strain, or the stress where it is not finite. Mean, half difference, shear, 33.
    real(wp), intent(inout) :: tensor(4)
    !> Shear modulus of the step; unchanged where the stress is not finite.
    real(wp), intent(inout) :: modulus
    real(wp) :: value(3), c, s

    if (.not. all(ieee_is_finite(tensor))) return
    call to_principal(tensor(1), tensor(2), tensor(3), tensor(4), value, c, s)
    modulus = model%shear_modulus(value)
    tensor = from_principal(model%elastic_strain(modulus, value), c, s)
  end subroutine start_strain

  !> Computes the trial of a step.
  pure subroutine make_step(model, lame, shear, paper, cauchy, f, stress, modulus, step, status)
    class(principal_model_type), intent(in) :: model
    !> Lame's moduli of the trial.
    real(wp), intent(in) :: lame, shear
    !> Whether the rate is integrated as in the paper, and whether it is that of sigma.
    logical, intent(in) :: paper, cauchy
    !> Incremental deformation gradient, packed; Cauchy stress at the start.
    real(wp), intent(in) :: f(5), stress(4)
    !> Shear modulus of the step; unchanged for a Hookean model.
    real(wp), intent(inout) :: modulus
    type(stress_step_type), intent(out) :: step
    !> status_ok, or the reason for which there is no trial.
    integer, intent(out) :: status
    real(wp) :: g(5), start(4), det

    status = status_failed
    if (.not. all(ieee_is_finite(stress))) return
    status = status_cut
    ! The determinant of a gradient that is not finite is not finite.
    det = f(1)*f(4) - f(3)*f(2)
    if (.not. ieee_is_finite(det*f(5))) return
    if (.not. (det > 0.0_wp .and. f(5) > 0.0_wp)) return
    start = [0.5_wp*(stress(1) + stress(2)), 0.5_wp*(stress(1) - stress(2)), stress(4), stress(3)]
    if (.not. model%hookean) call start_strain(model, start, modulus)
    step%lame = lame
    step%shear = shear
    g = [f(1) - 1.0_wp, f(2), f(3), f(4) - 1.0_wp, f(5) - 1.0_wp]
    step%volume = .not. cauchy
    if (paper) then
      call paper_step(g, start, step)
      status = status_ok
    else
      call midpoint_step(f, g, start, step, status)
    end if
  end subroutine make_step

  !> Computes the trial by eq. 26 with eqs. 9 and 10.
  pure subroutine paper_step(g, start, step)
    !> Displacement gradient on the start configuration, packed; stress or elastic strain at the start.
    real(wp), intent(in) :: g(5), start(4)
    type(stress_step_type), intent(inout) :: step
    real(wp) :: spin, trial(4)

    step%turns = .false.
    step%cosine = 1.0_wp
    step%t = 0.0_wp
    step%cos2 = 1.0_wp
    step%sin2 = 0.0_wp
    step%spin = 1.0_wp
    step%mid = [1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp]
    step%keep = 1.0_wp
    step%pivot = 1.0_wp
    spin = g(2) - g(3)
    step%start = start
    trial = start + elastic_change(step, g)
    if (step%volume) trial = trial - (g(1) + g(4) + g(5))*start
    step%trial = [trial(1), trial(2) - spin*start(3), trial(3) + spin*start(2), trial(4)]
  end subroutine paper_step

  !> Computes the trial by the midpoint rule.
  pure subroutine midpoint_step(f, u, start, step, status)
    !> Incremental deformation gradient, packed.
    real(wp), intent(in) :: f(5)
    !> F - I, packed; stress or elastic strain at the start.
    real(wp), intent(in) :: u(5), start(4)
    type(stress_step_type), intent(inout) :: step
    !> status_cut when the mid configuration is inverted or compressed to zero volume.
    integer, intent(inout) :: status
    real(wp) :: g(5), half(4), det, trace, c

    half = 0.5_wp*[f(1) + 1.0_wp, f(2), f(3), f(4) + 1.0_wp]
    det = half(1)*half(4) - half(2)*half(3)
    if (.not. det > 0.0_wp) return
    step%mid = [half(4)/det, -half(2)/det, -half(3)/det, half(1)/det, 2.0_wp/(f(5) + 1.0_wp)]
    associate (m => step%mid)
      g = [u(1)*m(1) + u(3)*m(2), u(2)*m(1) + u(4)*m(2), u(1)*m(3) + u(3)*m(4), u(2)*m(3) + u(4)*m(4), u(5)*m(5)]
    end associate
    trace = 0.0_wp
    if (step%volume) trace = g(1) + g(4) + g(5)
    step%pivot = 1.0_wp + 0.5_wp*trace
    step%keep = 1.0_wp - 0.5_wp*trace
    if (.not. step%pivot > smallest_pivot) return
    status = status_ok
    step%turns = .true.
    step%t = 0.25_wp*(g(2) - g(3))
    c = 1.0_wp/(1.0_wp + step%t**2)
    step%cosine = sqrt(c)
    step%cos2 = c*(1.0_wp - step%t**2)
    step%sin2 = 2.0_wp*c*step%t
    step%spin = 0.5_wp*c
    step%start = turned(step, start)
    step%trial = (step%keep*step%start + elastic_change(step, g))*(1.0_wp/step%pivot)
  end subroutine midpoint_step

  !> Change of the trial with the symmetric part of a gradient: the stress of linear elasticity, or the strain.
  pure function elastic_change(step, g) result(stress)
    type(stress_step_type), intent(in) :: step
    !> Displacement gradient, packed.
    real(wp), intent(in) :: g(5)
    real(wp) :: stress(4), mean

    mean = step%lame*(g(1) + g(4) + g(5))
    stress = [mean + step%shear*(g(1) + g(4)), step%shear*(g(1) - g(4)), step%shear*(g(2) + g(3)), &
      mean + 2.0_wp*step%shear*g(5)]
  end function elastic_change

  !> A tensor after the half rotation.
  pure function turned(step, a) result(b)
    type(stress_step_type), intent(in) :: step
    !> The tensor.
    real(wp), intent(in) :: a(4)
    real(wp) :: b(4)

    b = [a(1), step%cos2*a(2) - step%sin2*a(3), step%sin2*a(2) + step%cos2*a(3), a(4)]
  end function turned

  !> Principal values: the larger and the smaller in-plane value, 33. The function is in this module because a call to
  !> another module would cost as much as the rest of a point that does not yield.
  pure function principal_values(mean, half, shear, normal) result(value)
    !> Mean, half difference, shear, 33.
    real(wp), intent(in) :: mean, half, shear, normal
    real(wp) :: value(3), radius

    radius = sqrt(half**2 + shear**2)
    value = [mean + radius, mean - radius, normal]
  end function principal_values

  !> Components 11, 22, 33, 12.
  pure function stress_order(tensor) result(stress)
    !> Mean, half difference, shear, 33.
    real(wp), intent(in) :: tensor(4)
    real(wp) :: stress(4)

    stress = [tensor(1) + tensor(2), tensor(1) - tensor(2), tensor(4), tensor(3)]
  end function stress_order

  !> Computes the change of the stress with mean, half difference, shear and spin of dG, and dG_33.
  pure subroutine stress_change(step, principal, map, stress, change)
    type(stress_step_type), intent(in) :: step
    !> Whether the stress differs from the trial, by `map`.
    logical, intent(in) :: principal
    !> Change of the stress with the trial; stress at the end.
    real(wp), intent(in) :: map(4, 4), stress(4)
    real(wp), intent(out) :: change(4, 5)
    real(wp) :: start(4), volume(4), scale, lame, shear
    integer :: j

    scale = 1.0_wp/step%pivot
    lame = scale*step%lame
    shear = 2.0_wp*scale*step%shear
    start = turned(step, step%start)
    volume = scale*start
    if (step%turns) volume = 0.5_wp*scale*(start + turned(step, step%trial))
    if (.not. step%volume) volume = 0.0_wp
    change(:, 1) = [2.0_wp*lame + shear, 0.0_wp, 0.0_wp, 2.0_wp*lame] - 2.0_wp*volume
    change(:, 2) = [0.0_wp, shear, 0.0_wp, 0.0_wp]
    change(:, 3) = [0.0_wp, 0.0_wp, shear, 0.0_wp]
    change(:, 4) = 2.0_wp*scale*step%keep*step%spin*[0.0_wp, -start(3), start(2), 0.0_wp]
    change(:, 5) = [lame, 0.0_wp, 0.0_wp, lame + shear] - volume
    if (principal) then
      do j = 1, 5
        start = change(:, j)
        change(:, j) = map(:, 1)*start(1) + map(:, 2)*start(2) + map(:, 3)*start(3) + map(:, 4)*start(4)
      end do
    end if
    if (.not. step%turns) return
    change(2, 4) = change(2, 4) - 2.0_wp*step%spin*stress(3)
    change(3, 4) = change(3, 4) + 2.0_wp*step%spin*stress(2)
  end subroutine stress_change

  !> Computes A = dQ/dF of a point.
  pure subroutine point_tangent(step, principal, map, stress, f, a)
    type(stress_step_type), intent(in) :: step
    !> Whether the stress differs from the trial, by `map`.
    logical, intent(in) :: principal
    !> Change of the stress with the trial; stress at the end; incremental deformation gradient, packed.
    real(wp), intent(in) :: map(4, 4), stress(4), f(5)
    real(wp), intent(out) :: a(5, 5)
    real(wp) :: change(4, 5), left(2, 2), right(2, 2), g(2, 2), ds(4), z(4)
    integer :: k, l

    call stress_change(step, principal, map, stress, change)
    call mid_factors(step, left, right)
    do l = 1, 2
      do k = 1, 2
        g(:, 1) = left(:, k)*right(l, 1)
        g(:, 2) = left(:, k)*right(l, 2)
        z = 0.5_wp*[g(1, 1) + g(2, 2), g(1, 1) - g(2, 2), g(1, 2) + g(2, 1), g(2, 1) - g(1, 2)]
        ds = change(:, 1)*z(1) + change(:, 2)*z(2) + change(:, 3)*z(3) + change(:, 4)*z(4)
        call plane_piola(stress_order(ds), f, a(:, 2*(l - 1) + k))
      end do
    end do
    call plane_piola(stress_order(change(:, 5)*step%mid(5)**2), f, a(:, 5))
    call add_geometry(stress_order(stress), f, a)
  end subroutine point_tangent

  !> Computes R mid and mid R^T.
  pure subroutine mid_factors(step, left, right)
    type(stress_step_type), intent(in) :: step
    !> R mid; mid R^T.
    real(wp), intent(out) :: left(2, 2), right(2, 2)
    real(wp) :: c, s

    c = step%cosine
    s = step%cosine*step%t
    associate (m => step%mid)
      left(:, 1) = [c*m(1) - s*m(2), s*m(1) + c*m(2)]
      left(:, 2) = [c*m(3) - s*m(4), s*m(3) + c*m(4)]
      right(:, 1) = [c*m(1) - s*m(3), c*m(2) - s*m(4)]
      right(:, 2) = [s*m(1) + c*m(3), s*m(2) + c*m(4)]
    end associate
  end subroutine mid_factors

  !> Adds the change of det(F) F^-T: tr(l) Q - Q dF^T F^-T.
  pure subroutine add_geometry(stress, f, a)
    !> Cauchy stress that enters the tangent; incremental deformation gradient, packed.
    real(wp), intent(in) :: stress(4), f(5)
    real(wp), intent(inout) :: a(5, 5)
    real(wp) :: q(5), inverse(5)
    integer :: i, j, k, l

    call plane_piola(stress, f, q)
    inverse(:4) = [f(4), -f(3), -f(2), f(1)]*(1.0_wp/(f(1)*f(4) - f(2)*f(3)))
    inverse(5) = 1.0_wp/f(5)
    do j = 1, 5
      a(:, j) = a(:, j) + inverse(j)*q
    end do
    a(5, 5) = a(5, 5) - inverse(5)*q(5)
    do l = 1, 2
      do k = 1, 2
        do j = 1, 2
          do i = 1, 2
            a(2*(j - 1) + i, 2*(l - 1) + k) = a(2*(j - 1) + i, 2*(l - 1) + k) &
              - q(2*(l - 1) + i)*inverse(2*(j - 1) + k)
          end do
        end do
      end do
    end do
  end subroutine add_geometry
end module qsmpm_jaumann_plane
