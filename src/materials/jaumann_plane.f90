!> The Jaumann rate (qsmpm_principal_law) in plane strain and axisymmetry.
!>
!> Symmetric tensors are those of qsmpm_plane_frame, turned into the frame at the end of the step, in which
!> dG = (R mid) dF (mid R^T). The trial, a stress of Hookean models and the elastic strain of the others, changes by a
!> matrix times mean, half difference and shear of the symmetric part of dG, its spin (dG_21 - dG_12)/2, and dG_33.
!> Everything is scalars: the half rotation R by t = tan(angle) has cos = 1/(1 + t^2)^(1/2), and turns a tensor by
!> cos2 = (1 - t^2) cos^2, sin2 = 2 t cos^2; the spin of R is half of cos^2 times that of dG.
module qsmpm_jaumann_plane
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: pair_quotient
  use qsmpm_jaumann_increment, only: rate_paper, rate_paper_cauchy, smallest_pivot, is_cauchy
  use qsmpm_law, only: batch_type, status_ok, status_cut, status_failed, tangent_none, tangent_elastic
  use qsmpm_plane_frame, only: to_principal, from_principal, frame_map, plane_piola
  use qsmpm_principal_model, only: principal_model_type, stress_update_type, blend_elastic
  use qsmpm_principal_point, only: keep_update, size_of_cell, elastic_share
  implicit none
  private

  public :: update_plane

  !> A step of a point up to its trial.
  type :: stress_step_type
    !> Whether the stress turns before and after the strain increment.
    logical :: turns = .false.
    !> Half rotation: cosine, tangent, and the turn of a tensor.
    real(wp) :: cosine = 1.0_wp, t = 0.0_wp, cos2 = 1.0_wp, sin2 = 0.0_wp
    !> Spin of the half rotation by the spin of dG.
    real(wp) :: spin = 1.0_wp
    !> ((F + I)/2)^-1: 11, 21, 12, 22, 33.
    real(wp) :: mid(5) = [1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp]
    real(wp) :: keep = 1.0_wp, pivot = 1.0_wp
    !> Whether the rate is that of J sigma, with the terms -sigma tr d(eps).
    logical :: volume = .true.
    !> Lame's moduli of the trial.
    real(wp) :: lame = 0.0_wp, shear = 0.0_wp
    !> Stress or elastic strain at the start after the first half rotation, and trial: mean, half difference, shear, 33.
    real(wp) :: start(4) = 0.0_wp, trial(4) = 0.0_wp
  end type stress_step_type

contains

  !> Update a batch; points with a status other than ok are left half done.
  pure subroutine update_plane(model, rate, blend, batch, tangent)
    class(principal_model_type), intent(in) :: model
    !> One of rate_* of qsmpm_jaumann_increment.
    integer, intent(in) :: rate
    !> Share of the elastic tangent in the consistent one.
    real(wp), intent(in) :: blend
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> Which tangent is wanted.
    integer, intent(in) :: tangent
    type(stress_step_type) :: step
    type(stress_update_type) :: result
    real(wp) :: start(4), stress(4), map(4, 4), lame, shear, modulus, cell_size, value(3), c, s, turn(4)
    logical :: principal
    integer :: p

    map = 0.0_wp
    lame = model%trial_lame
    shear = model%trial_shear
    modulus = model%shear
    cell_size = 0.0_wp
    do p = 1, batch%count
      associate (stress => batch%stress_start(:, p))
        start = [0.5_wp*(stress(1) + stress(2)), 0.5_wp*(stress(1) - stress(2)), stress(4), stress(3)]
      end associate
      if (.not. model%hookean) call start_strain(model, start, modulus)
      call make_step(lame, shear, rate, batch%gradient(:, p), start, step, batch%status(p))
      if (batch%status(p) /= status_ok) cycle
      principal = .not. model%hookean
      batch%plastic(p) = 0
      if (.not. model%elastic) then
        value = principal_values(step%trial)
        if (model%asks_cell_size) cell_size = size_of_cell(model, batch, p)
        call model%update(modulus, value, batch%state_start(1:, p), cell_size, tangent /= tangent_none, result)
        batch%plastic(p) = merge(1, 0, result%yields)
        if (model%state_count > 0 .or. result%status /= status_ok) call keep_update(model, result, 1, batch, p)
        if (batch%status(p) /= status_ok) cycle
        principal = principal .or. result%yields
      end if
      if (principal) then
        call to_principal(step%trial, value, c, s)
        turn = turned(step, [0.0_wp, c, s, 0.0_wp])
        stress = from_principal(result%stress, turn(2), turn(3))
      else
        stress = turned(step, step%trial)
      end if
      batch%stress(:, p) = stress_order(stress)
      call plane_piola(batch%stress(:, p), batch%gradient(:, p), batch%piola(:, p))
      if (tangent == tangent_none) cycle
      if (principal) then
        ! The plane turns one pair of directions only.
        result%quotient = pair_quotient(value, result%stress, result%derivative, 1, 2)
        call blend_elastic(model, modulus, value, elastic_share(tangent, blend), result)
        stress = from_principal(result%stress, turn(2), turn(3))
        map = frame_map(result%derivative, result%quotient(1), turn(2), turn(3))
      end if
      ! [K_E + K_G]^0 is that of the rate of J sigma.
      if (tangent == tangent_elastic .and. model%hookean) step%volume = .true.
      call point_tangent(step, principal, map, stress, batch%gradient(:, p), batch%tangent(:, :, p))
    end do
  end subroutine update_plane

  !> Elastic strain of a Cauchy stress.
  pure subroutine start_strain(model, tensor, modulus)
    class(principal_model_type), intent(in) :: model
    !> In: Cauchy stress. Out: strain, or the stress where it is not finite. Mean, half difference, shear, 33.
    real(wp), intent(inout) :: tensor(4)
    !> Shear modulus of the step; stays as it is where the stress is not finite.
    real(wp), intent(inout) :: modulus
    real(wp) :: value(3), c, s

    if (.not. all(ieee_is_finite(tensor))) return
    call to_principal(tensor, value, c, s)
    modulus = model%shear_modulus(value)
    tensor = from_principal(model%elastic_strain(modulus, value), c, s)
  end subroutine start_strain

  !> Trial of a step.
  pure subroutine make_step(lame, shear, rate, f, start, step, status)
    !> Lame's moduli of the trial.
    real(wp), intent(in) :: lame, shear
    !> One of rate_* of qsmpm_jaumann_increment.
    integer, intent(in) :: rate
    !> Incremental deformation gradient, packed.
    real(wp), intent(in) :: f(5)
    !> Stress or elastic strain at the start.
    real(wp), intent(in) :: start(4)
    type(stress_step_type), intent(out) :: step
    !> status_ok, or why there is none.
    integer, intent(out) :: status
    real(wp) :: g(5), det

    status = status_failed
    if (.not. all(ieee_is_finite(start))) return
    status = status_cut
    ! A gradient that is not finite has no finite determinant.
    det = f(1)*f(4) - f(3)*f(2)
    if (.not. ieee_is_finite(det*f(5))) return
    if (.not. (det > 0.0_wp .and. f(5) > 0.0_wp)) return
    step%lame = lame
    step%shear = shear
    g = [f(1) - 1.0_wp, f(2), f(3), f(4) - 1.0_wp, f(5) - 1.0_wp]
    step%volume = .not. is_cauchy(rate)
    if (rate == rate_paper .or. rate == rate_paper_cauchy) then
      call paper_step(g, start, step)
      status = status_ok
    else
      call midpoint_step(f, g, start, step, status)
    end if
  end subroutine make_step

  !> Eq. 26 with eqs. 9 and 10.
  pure subroutine paper_step(g, start, step)
    !> Displacement gradient on the start configuration, packed.
    real(wp), intent(in) :: g(5)
    !> Stress or elastic strain at the start.
    real(wp), intent(in) :: start(4)
    type(stress_step_type), intent(inout) :: step
    real(wp) :: spin

    spin = g(2) - g(3)
    step%start = start
    step%trial = start + elastic_change(step, g)
    if (step%volume) step%trial = step%trial - (g(1) + g(4) + g(5))*start
    step%trial(2) = step%trial(2) - spin*start(3)
    step%trial(3) = step%trial(3) + spin*start(2)
  end subroutine paper_step

  !> The midpoint rule.
  pure subroutine midpoint_step(f, u, start, step, status)
    !> Incremental deformation gradient, packed.
    real(wp), intent(in) :: f(5)
    !> F - I, packed.
    real(wp), intent(in) :: u(5)
    !> Stress or elastic strain at the start.
    real(wp), intent(in) :: start(4)
    type(stress_step_type), intent(inout) :: step
    !> status_cut when the mid configuration is turned inside out or compressed to nothing.
    integer, intent(inout) :: status
    real(wp) :: g(5), half(4), det, trace, c

    half = 0.5_wp*[f(1) + 1.0_wp, f(2), f(3), f(4) + 1.0_wp]
    det = half(1)*half(4) - half(2)*half(3)
    if (.not. det > 0.0_wp) return
    step%mid = [half(4)/det, -half(2)/det, -half(3)/det, half(1)/det, 2.0_wp/(f(5) + 1.0_wp)]
    associate (m => step%mid)
      g = [u(1)*m(1) + u(3)*m(2), u(2)*m(1) + u(4)*m(2), u(1)*m(3) + u(3)*m(4), u(2)*m(3) + u(4)*m(4), &
        u(5)*m(5)]
    end associate
    trace = g(1) + g(4) + g(5)
    if (step%volume) then
      step%pivot = 1.0_wp + 0.5_wp*trace
      step%keep = 1.0_wp - 0.5_wp*trace
    end if
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

  !> What the symmetric part of a gradient adds to the trial: the stress of linear elasticity, or the strain.
  pure function elastic_change(step, g) result(stress)
    type(stress_step_type), intent(in) :: step
    !> Displacement gradient, packed.
    real(wp), intent(in) :: g(5)
    real(wp) :: stress(4)
    real(wp) :: mean

    mean = step%lame*(g(1) + g(4) + g(5))
    stress = [mean + step%shear*(g(1) + g(4)), step%shear*(g(1) - g(4)), step%shear*(g(2) + g(3)), &
      mean + 2.0_wp*step%shear*g(5)]
  end function elastic_change

  !> A tensor after a half rotation.
  pure function turned(step, a) result(b)
    type(stress_step_type), intent(in) :: step
    !> The tensor.
    real(wp), intent(in) :: a(4)
    real(wp) :: b(4)

    b = [a(1), step%cos2*a(2) - step%sin2*a(3), step%sin2*a(2) + step%cos2*a(3), a(4)]
  end function turned

  !> Principal values: the larger and the smaller one of the plane, 33. Here, as a call to another module would cost as
  !> much as the rest of a point that does not yield.
  pure function principal_values(tensor) result(value)
    !> Mean, half difference, shear, 33.
    real(wp), intent(in) :: tensor(4)
    real(wp) :: value(3)
    real(wp) :: radius

    radius = sqrt(tensor(2)**2 + tensor(3)**2)
    value = [tensor(1) + radius, tensor(1) - radius, tensor(4)]
  end function principal_values

  !> 11, 22, 33, 12.
  pure function stress_order(tensor) result(stress)
    !> Mean, half difference, shear, 33.
    real(wp), intent(in) :: tensor(4)
    real(wp) :: stress(4)

    stress = [tensor(1) + tensor(2), tensor(1) - tensor(2), tensor(4), tensor(3)]
  end function stress_order

  !> Change of the stress with mean, half difference, shear and spin of dG, and dG_33.
  pure subroutine stress_change(step, principal, map, stress, change)
    type(stress_step_type), intent(in) :: step
    !> Whether the stress is another than the trial, by `map`.
    logical, intent(in) :: principal
    !> Change of the stress with the trial.
    real(wp), intent(in) :: map(4, 4)
    !> Stress at the end.
    real(wp), intent(in) :: stress(4)
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

  !> A = dQ/dF of a point.
  pure subroutine point_tangent(step, principal, map, stress, f, a)
    type(stress_step_type), intent(in) :: step
    !> Whether the stress is another than the trial, by `map`.
    logical, intent(in) :: principal
    !> Change of the stress with the trial.
    real(wp), intent(in) :: map(4, 4)
    !> Stress at the end.
    real(wp), intent(in) :: stress(4)
    !> Incremental deformation gradient, packed.
    real(wp), intent(in) :: f(5)
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

  !> R mid and mid R^T.
  pure subroutine mid_factors(step, left, right)
    type(stress_step_type), intent(in) :: step
    !> R mid.
    real(wp), intent(out) :: left(2, 2)
    !> mid R^T.
    real(wp), intent(out) :: right(2, 2)
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

  !> What the change of det(F) F^-T adds: tr(l) Q - Q dF^T F^-T.
  pure subroutine add_geometry(stress, f, a)
    !> Cauchy stress that enters the tangent.
    real(wp), intent(in) :: stress(4)
    !> Incremental deformation gradient, packed.
    real(wp), intent(in) :: f(5)
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
