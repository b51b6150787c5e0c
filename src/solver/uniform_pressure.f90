!> Uniform cell pressure: the points of a group share one pressure, which cures volumetric locking.
!>
!> Two fields, displacement and a pressure that is constant in the group, with the pressure and what
!> belongs to it condensed inside the group. A point of start volume V gets an extra volume change
!> omega; its law is called at Fbar = S F, S = exp(omega M), M = diag(m), sum m = 1. With the law's
!> answer Qbar, Abar the chain rule gives
!>   Q = S Qbar,  A = S Abar S,  pi = Q : M F  (the mean stress, per start volume),
!>   r = dQ/domega = M Q + A (M F),  l = dpi/dF = M Q + A^T (M F),  kappa = dpi/domega = (M F) : r.
!> The group is in balance when
!>   pi + c omega = pbar for all points,   sum V omega = 0,   c = factor * shear modulus.
!> The condition makes sum V Q : dF stationary in omega, so that Q is the force's stress as it stands,
!> and with k = kappa + c > 0
!>   dQ = (A - r l^T/k) dF + r/k dpbar,   dpbar = sum (V/k) l : dF / sum (V/k).
!> c -> infinity is no cure at all; a group of one point has omega = 0. A and the whole are symmetric
!> together. The volume of a point changes by det Fbar = det F exp(omega).
!>
!> This module finds omega and condenses stress and tangent of the points; the rank-one part of the
!> stiffness is `add_pressure_stiffness` of qsmpm_group_stiffness. docs/theory.md, section 6a.
module qsmpm_uniform_pressure
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type, batch_type, status_ok, status_failed, tangent_none, &
    tangent_consistent, tangent_elastic
  use qsmpm_tensor, only: gradient_row
  implicit none
  private

  public :: pressure_type, allocate_pressure, find_pressure, packed_determinant

  !> Passes after which a group is given up.
  integer, parameter :: most_passes = 40
  !> Spread of pi + c omega that is left, relative to shear modulus and stress, and the rounding of a
  !> stress whose volume change is known to some eps.
  real(wp), parameter :: spread = 1.0e-13_wp, rounding = 5.0e-14_wp
  !> A pass has overshot when the slope along it has turned round to more than this share of the first.
  real(wp), parameter :: overshoot = 0.5_wp

  !> Work space of one group, and what the stiffness needs of it. Arrays may be longer than the group.
  type :: pressure_type
    !> Volumetric direction m (3).
    real(wp) :: direction(3) = 1.0_wp/3.0_wp
    !> c.
    real(wp) :: resistance = 0.0_wp
    !> F of the points as the displacements give it, packed (5 or 9, n).
    real(wp), allocatable :: gradient(:, :)
    !> Extra volume change omega, and its last correction (n).
    real(wp), allocatable :: omega(:), correction(:)
    !> pi + c omega and k (n).
    real(wp), allocatable :: pressure(:), stiffness(:)
    !> r and l, packed (5 or 9, n).
    real(wp), allocatable :: right(:, :), left(:, :)
    !> CR and CL of the group's nodes (dimension*nodes).
    real(wp), allocatable :: right_vector(:), left_vector(:)
    !> Calls of the law that the last group took.
    integer :: passes = 0
  end type pressure_type

contains

  !> Room for groups of some size.
  pure subroutine allocate_pressure(components, points, unknowns, hoop, pressure)
    !> Packed components of a gradient, 5 or 9.
    integer, intent(in) :: components
    !> Points and displacement components of the largest group.
    integer, intent(in) :: points
    integer, intent(in) :: unknowns
    !> The third direction strains: axisymmetry and 3D.
    logical, intent(in) :: hoop
    !> The work space.
    type(pressure_type), intent(out) :: pressure

    if (.not. hoop) pressure%direction = [0.5_wp, 0.5_wp, 0.0_wp]
    allocate (pressure%gradient(components, points), pressure%right(components, points), &
      pressure%left(components, points))
    allocate (pressure%omega(points), pressure%correction(points), pressure%pressure(points), &
      pressure%stiffness(points))
    allocate (pressure%right_vector(unknowns), pressure%left_vector(unknowns))
  end subroutine allocate_pressure

  !> Stress, state and, when asked for, condensed tangent A - r l^T/k of points under one pressure.
  !> Where there is none in the passes allowed, all points get a status.
  subroutine find_pressure(law, resistance, weight, tangent, batch, pressure)
    !> The law of the points.
    class(law_type), intent(in) :: law
    !> c.
    real(wp), intent(in) :: resistance
    !> Start volumes V (n).
    real(wp), intent(in) :: weight(:)
    !> tangent_none, tangent_consistent or tangent_elastic.
    integer, intent(in) :: tangent
    !> In: F. Out: Fbar, results of the law, Q and condensed tangent.
    type(batch_type), intent(inout) :: batch
    !> Work space.
    type(pressure_type), intent(inout) :: pressure
    logical :: found

    pressure%resistance = resistance
    call even_out_volumes(weight, batch, pressure, found)
    if (found) call balance(law, weight, batch, pressure, found)
    if (.not. found) then
      batch%status(:batch%count) = status_failed
      return
    end if
    if (tangent == tangent_elastic) call law%update(batch, tangent)
    if (any(batch%status(:batch%count) /= status_ok)) return
    call condense(batch, pressure, tangent /= tangent_none)
  end subroutine find_pressure

  !> First guess: all points have the mean logarithmic volume change.
  pure subroutine even_out_volumes(weight, batch, pressure, ok)
    !> Start volumes (n).
    real(wp), intent(in) :: weight(:)
    !> Points with F.
    type(batch_type), intent(inout) :: batch
    !> Work space.
    type(pressure_type), intent(inout) :: pressure
    !> False when a point is turned inside out.
    logical, intent(out) :: ok
    real(wp) :: determinant
    integer :: p

    ok = .true.
    do p = 1, batch%count
      pressure%gradient(:, p) = batch%gradient(:, p)
      determinant = packed_determinant(batch%gradient(:, p))
      ok = ok .and. determinant > 0.0_wp .and. determinant <= huge(determinant)
      if (.not. ok) return
      pressure%omega(p) = -log(determinant)
    end do
    associate (omega => pressure%omega(:batch%count))
      omega = omega - sum(weight*omega)/sum(weight)
    end associate
    call strain_points(batch, pressure)
  end subroutine even_out_volumes

  !> Newton's method for omega. With the correction d, sum V d = 0, the slope -sum V (pi + c omega) d
  !> falls along d (pi rises with omega), so that a step too long is seen by its sign and shortened.
  !> Deviations from the mean enter the slope, else rounding in sum V d would hide it.
  subroutine balance(law, weight, batch, pressure, found)
    !> The law of the points.
    class(law_type), intent(in) :: law
    !> Start volumes (n).
    real(wp), intent(in) :: weight(:)
    !> Points with Fbar of the first guess.
    type(batch_type), intent(inout) :: batch
    !> Work space.
    type(pressure_type), intent(inout) :: pressure
    !> All points have the same pressure.
    logical, intent(out) :: found
    real(wp) :: slope, first_slope, length, common
    integer :: n, pass

    n = batch%count
    pressure%correction(:n) = 0.0_wp
    found = .false.
    first_slope = 0.0_wp
    length = 0.0_wp
    do pass = 1, most_passes
      pressure%passes = pass
      call law%update(batch, tangent_consistent)
      if (all(batch%status(:n) == status_ok)) then
        call linearise(batch, pressure)
        if (any(pressure%stiffness(:n) <= 0.0_wp)) return
        common = sum(weight*pressure%pressure(:n)/pressure%stiffness(:n))/sum(weight/pressure%stiffness(:n))
        slope = sum(weight*(common - pressure%pressure(:n))*pressure%correction(:n))
        if (pass == 1 .or. slope >= -overshoot*first_slope) then
          found = is_even(law, common, batch, pressure)
          if (found) return
          pressure%correction(:n) = (common - pressure%pressure(:n))/pressure%stiffness(:n)
          first_slope = sum(weight*(common - pressure%pressure(:n))*pressure%correction(:n))
          length = 1.0_wp
          pressure%omega(:n) = pressure%omega(:n) + pressure%correction(:n)
        else
          call shorten(length*max(first_slope/(first_slope - slope), 0.1_wp), n, length, pressure)
        end if
      else
        if (pass == 1) return
        call shorten(0.5_wp*length, n, length, pressure)
      end if
      call strain_points(batch, pressure)
    end do
  end subroutine balance

  !> Go back along the last correction.
  pure subroutine shorten(new_length, count, length, pressure)
    !> Length wanted, in corrections.
    real(wp), intent(in) :: new_length
    !> Points of the group.
    integer, intent(in) :: count
    !> Length before and after.
    real(wp), intent(inout) :: length
    !> Work space.
    type(pressure_type), intent(inout) :: pressure

    pressure%omega(:count) = pressure%omega(:count) &
      + (new_length - length)*pressure%correction(:count)
    length = new_length
  end subroutine shorten

  !> Fbar = exp(omega M) F.
  pure subroutine strain_points(batch, pressure)
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> Work space.
    type(pressure_type), intent(in) :: pressure
    real(wp) :: scale(3)
    integer :: p, i, d

    d = merge(2, 3, size(pressure%gradient, 1) == 5)
    do p = 1, batch%count
      scale = exp(pressure%omega(p)*pressure%direction)
      do i = 1, size(pressure%gradient, 1)
        batch%gradient(i, p) = scale(gradient_row(i, d))*pressure%gradient(i, p)
      end do
    end do
  end subroutine strain_points

  !> pi + c omega and k of all points, from the law's answer at Fbar:
  !> pi = Qbar : h, kappa = (M Qbar + Abar h) : h with h = M Fbar.
  pure subroutine linearise(batch, pressure)
    !> The points.
    type(batch_type), intent(in) :: batch
    !> Work space.
    type(pressure_type), intent(inout) :: pressure
    real(wp) :: m(size(pressure%gradient, 1)), h(size(pressure%gradient, 1))
    integer :: p, j, n

    n = size(m)
    m = pressure%direction(gradient_row(:n, merge(2, 3, n == 5)))
    do p = 1, batch%count
      h = m*batch%gradient(:, p)
      pressure%pressure(p) = dot_product(batch%piola(:, p), h) + pressure%resistance*pressure%omega(p)
      pressure%stiffness(p) = pressure%resistance + dot_product(m*batch%piola(:, p), h)
      do j = 1, n
        pressure%stiffness(p) = pressure%stiffness(p) + dot_product(h, batch%tangent(:, j, p))*h(j)
      end do
    end do
  end subroutine linearise

  !> Whether all points have the common pressure up to rounding.
  pure logical function is_even(law, common, batch, pressure)
    !> The law of the points.
    class(law_type), intent(in) :: law
    !> pbar.
    real(wp), intent(in) :: common
    !> The points.
    type(batch_type), intent(in) :: batch
    !> Work space.
    type(pressure_type), intent(in) :: pressure

    associate (y => pressure%pressure(:batch%count), k => pressure%stiffness(:batch%count))
      is_even = all(abs(y - common) <= spread*(law%shear_scale + abs(y)) + rounding*k)
    end associate
  end function is_even

  !> Q and, when asked for, r, l, k and A - r l^T/k of all points.
  pure subroutine condense(batch, pressure, with_tangent)
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> Work space.
    type(pressure_type), intent(inout) :: pressure
    !> A tangent is wanted.
    logical, intent(in) :: with_tangent
    real(wp) :: m(size(pressure%gradient, 1)), h(size(pressure%gradient, 1)), s(size(pressure%gradient, 1))
    integer :: row(size(pressure%gradient, 1)), p, j, n

    n = size(m)
    row = gradient_row(:n, merge(2, 3, n == 5))
    m = pressure%direction(row)
    do p = 1, batch%count
      s = exp(pressure%omega(p)*m)
      h = m*pressure%gradient(:, p)
      batch%piola(:, p) = s*batch%piola(:, p)
      if (.not. with_tangent) cycle
      associate (a => batch%tangent(:, :, p), r => pressure%right(:, p), l => pressure%left(:, p))
        r = m*batch%piola(:, p)
        l = r
        do j = 1, n
          a(:, j) = s*a(:, j)*s(j)
          r = r + a(:, j)*h(j)
          l(j) = l(j) + dot_product(a(:, j), h)
        end do
        pressure%stiffness(p) = pressure%resistance + dot_product(h, r)
        do j = 1, n
          a(:, j) = a(:, j) - r*(l(j)/pressure%stiffness(p))
        end do
      end associate
    end do
  end subroutine condense

  !> Determinant of a packed deformation gradient.
  pure function packed_determinant(f) result(determinant)
    !> (5) or (9)
    real(wp), intent(in) :: f(:)
    real(wp) :: determinant

    if (size(f) == 5) then
      determinant = (f(1)*f(4) - f(2)*f(3))*f(5)
    else
      determinant = f(1)*(f(5)*f(9) - f(6)*f(8)) - f(4)*(f(2)*f(9) - f(3)*f(8)) &
        + f(7)*(f(2)*f(6) - f(3)*f(5))
    end if
  end function packed_determinant
end module qsmpm_uniform_pressure
