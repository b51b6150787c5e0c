!> Balance of a group of points with one pressure: the additional volume changes omega for which
!>   pi + c omega - g - h s = pbar at all points,   sum V omega = 0
!> (the purpose is described in qsmpm_uniform_pressure). Newton's method for all points together needs two or three
!> calls of the law; a bracketing search replaces it where corners of the yield surface prevent its convergence.
module qsmpm_pressure_balance
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_slot_type, batch_type, status_ok, tangent_consistent
  use qsmpm_tensor, only: gradient_row
  implicit none
  private

  public :: pressure_type, allocate_pressure, even_out_volumes, balance, search, packed_determinant

  !> Largest number of passes of Newton's method before the search; of the search, largest number of pressures, and of
  !> passes for each.
  integer, parameter :: most_passes = 10, most_pressures = 40, most_tries = 60
  !> Largest change of omega in a pass of the search.
  real(wp), parameter :: largest_change = 0.1_wp
  !> Allowed spread of pi + c omega relative to shear modulus and stress, and rounding of a stress whose volume change
  !> is known to some eps.
  real(wp), parameter :: spread = 1.0e-13_wp, rounding = 5.0e-14_wp
  !> A pass has overshot when the slope along it has changed sign and exceeds this share of the first.
  real(wp), parameter :: overshoot = 0.5_wp

  !> Work space of one group, and data needed for the stiffness. Arrays may be longer than the group.
  type :: pressure_type
    !> Volumetric direction m (3).
    real(wp) :: direction(3) = 1.0_wp/3.0_wp
    !> c, and its derivative with respect to F of the points, over V, packed (5 or 9, n); unused where c is constant.
    real(wp) :: resistance = 0.0_wp
    real(wp), allocatable :: resistance_by(:, :)
    logical :: constant = .true.
    !> F of the points from the displacements, packed (5 or 9, n).
    real(wp), allocatable :: gradient(:, :)
    !> Additional volume change omega, and its last correction (n).
    real(wp), allocatable :: omega(:), correction(:)
    !> Bounds of omega (n).
    real(wp), allocatable :: low(:), high(:)
    !> pi + c omega - g - h s and k (n).
    real(wp), allocatable :: pressure(:), stiffness(:)
    !> g + h s: pressure of the points relative to the common one, due to weight and water and due to the differences at
    !> the start of the step; s, the pressure relative to its mean at the start; and h, the share of s that remains
    !> [stress] (n).
    real(wp), allocatable :: offset(:), kept(:)
    real(wp) :: left_share = 1.0_wp
    !> s is included: the points remain in their group from step to step.
    logical :: lasting = .false.
    !> Pore water drains in the step: the effective pressure of soil that has not yielded varies within a group.
    logical :: draining = .false.
    !> r and l, packed (5 or 9, n).
    real(wp), allocatable :: right(:, :), left(:, :)
    !> CR and CL of the group's nodes (dimension*nodes).
    real(wp), allocatable :: right_vector(:), left_vector(:)
    !> Number of calls of the law in the last balance.
    integer :: passes = 0
  end type pressure_type

contains

  !> Allocates the work space for groups of a given size.
  pure subroutine allocate_pressure(components, points, unknowns, hoop, pressure)
    !> Packed components of a gradient, 5 or 9.
    integer, intent(in) :: components
    !> Numbers of points and of displacement components of the largest group.
    integer, intent(in) :: points, unknowns
    !> The third direction is strained: axisymmetry and space.
    logical, intent(in) :: hoop
    !> The work space.
    type(pressure_type), intent(out) :: pressure

    if (.not. hoop) pressure%direction = [0.5_wp, 0.5_wp, 0.0_wp]
    allocate (pressure%gradient(components, points), pressure%right(components, points), &
      pressure%left(components, points), pressure%resistance_by(components, points))
    allocate (pressure%omega(points), pressure%correction(points), pressure%pressure(points), &
      pressure%stiffness(points), pressure%low(points), pressure%high(points))
    allocate (pressure%offset(points), pressure%kept(points), source=0.0_wp)
    allocate (pressure%right_vector(unknowns), pressure%left_vector(unknowns))
  end subroutine allocate_pressure

  !> Sets the first guess: all points have the mean logarithmic volume change.
  pure subroutine even_out_volumes(weight, batch, pressure, ok)
    !> Initial volumes (n).
    real(wp), intent(in) :: weight(:)
    !> Points, whose gradients are set to Fbar.
    type(batch_type), intent(inout) :: batch
    !> Work space with F.
    type(pressure_type), intent(inout) :: pressure
    !> False when a point is turned inside out.
    logical, intent(out) :: ok
    real(wp) :: determinant
    integer :: p

    ok = .true.
    do p = 1, batch%count
      determinant = packed_determinant(pressure%gradient(:, p))
      ok = ok .and. determinant > 0.0_wp .and. determinant <= huge(determinant)
      if (.not. ok) return
      pressure%omega(p) = -log(determinant)
    end do
    associate (omega => pressure%omega(:batch%count))
      omega = omega - sum(weight*omega)/sum(weight)
    end associate
    call strain_points(batch, pressure)
  end subroutine even_out_volumes

  !> Applies Newton's method to omega. With the correction d, sum V d = 0, the slope -sum V (pi + c omega) d decreases
  !> along d (pi increases with omega), so that a step that is too long is detected by its sign and shortened. The slope
  !> contains deviations from the mean, because rounding in sum V d would otherwise conceal it.
  subroutine balance(slot, weight, batch, pressure, found)
    !> The law of the points.
    type(law_slot_type), intent(in) :: slot
    !> Initial volumes (n).
    real(wp), intent(in) :: weight(:)
    !> Points with Fbar of the first guess.
    type(batch_type), intent(inout) :: batch
    !> Work space.
    type(pressure_type), intent(inout) :: pressure
    !> All points have the same pressure.
    logical, intent(out) :: found
    logical :: ok
    real(wp) :: slope, first_slope, length, common
    integer :: n, pass

    n = batch%count
    pressure%correction(:n) = 0.0_wp
    pressure%passes = 0
    found = .false.
    first_slope = 0.0_wp
    length = 0.0_wp
    do pass = 1, most_passes
      call call_law(slot, batch, pressure, ok)
      if (ok) then
        common = sum(weight*pressure%pressure(:n)/pressure%stiffness(:n))/sum(weight/pressure%stiffness(:n))
        slope = sum(weight*(common - pressure%pressure(:n))*pressure%correction(:n))
        if (pass == 1 .or. slope >= -overshoot*first_slope) then
          found = is_even(slot, common, batch, pressure)
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

  !> Finds the balance where Newton's method for all points together fails: pbar is bracketed, and for each trial of
  !> pbar the omega of every point. pi + c omega increases with omega, and sum V omega with pbar, so that bracketing and
  !> bisection find the solution for any corners of the law.
  subroutine search(slot, weight, batch, pressure, found)
    !> The law of the points.
    type(law_slot_type), intent(in) :: slot
    !> Initial volumes (n).
    real(wp), intent(in) :: weight(:)
    !> Points.
    type(batch_type), intent(inout) :: batch
    !> Work space with F.
    type(pressure_type), intent(inout) :: pressure
    !> All points have the same pressure.
    logical, intent(out) :: found
    real(wp) :: low, high, common, next, excess
    integer :: n, trial

    n = batch%count
    low = -huge(low)
    high = huge(high)
    call even_out_volumes(weight, batch, pressure, found)
    if (found) call call_law(slot, batch, pressure, found)
    if (.not. found) return
    common = sum(weight*pressure%pressure(:n)/pressure%stiffness(:n))/sum(weight/pressure%stiffness(:n))
    do trial = 1, most_pressures
      call reach(slot, common, batch, pressure, found)
      if (.not. found) return
      excess = sum(weight*pressure%omega(:n))
      if (abs(excess) <= rounding*sum(weight)) return
      if (excess > 0.0_wp) high = common
      if (excess < 0.0_wp) low = common
      next = common - excess/sum(weight/pressure%stiffness(:n))
      if (is_better_halved(next, low, high, trial)) next = low + 0.5_wp*(high - low)
      pressure%omega(:n) = pressure%omega(:n) + limited((next - common)/pressure%stiffness(:n))
      common = next
    end do
    found = .false.
  end subroutine search

  !> Finds omega of every point for one pressure.
  subroutine reach(slot, common, batch, pressure, reached)
    !> The law of the points.
    type(law_slot_type), intent(in) :: slot
    !> pbar.
    real(wp), intent(in) :: common
    !> Points.
    type(batch_type), intent(inout) :: batch
    !> Work space with a first guess.
    type(pressure_type), intent(inout) :: pressure
    !> All points have the pressure.
    logical, intent(out) :: reached
    real(wp) :: next
    integer :: p, trial

    pressure%low(:batch%count) = -huge(1.0_wp)
    pressure%high(:batch%count) = huge(1.0_wp)
    do trial = 1, most_tries
      call strain_points(batch, pressure)
      call call_law(slot, batch, pressure, reached)
      if (.not. reached) return
      reached = is_even(slot, common, batch, pressure)
      if (reached) return
      do p = 1, batch%count
        associate (y => pressure%pressure(p), omega => pressure%omega(p))
          if (y > common) pressure%high(p) = omega
          if (y <= common) pressure%low(p) = omega
          next = omega + limited((common - y)/pressure%stiffness(p))
          if (is_better_halved(next, pressure%low(p), pressure%high(p), trial)) &
            next = pressure%low(p) + 0.5_wp*(pressure%high(p) - pressure%low(p))
          omega = next
        end associate
      end do
    end do
  end subroutine reach

  !> Evaluates the law at Fbar; `ok` is false when a point has no result or k is not positive.
  subroutine call_law(slot, batch, pressure, ok)
    !> The law of the points.
    type(law_slot_type), intent(in) :: slot
    !> Points with Fbar.
    type(batch_type), intent(inout) :: batch
    !> Work space.
    type(pressure_type), intent(inout) :: pressure
    !> pi + c omega - g - h s and k are available.
    logical, intent(out) :: ok

    pressure%passes = pressure%passes + 1
    call slot%update(batch, tangent_consistent)
    ok = all(batch%status(:batch%count) == status_ok)
    if (.not. ok) return
    call linearise(batch, pressure)
    ok = all(pressure%stiffness(:batch%count) > 0.0_wp)
  end subroutine call_law

  !> Returns whether the midpoint of a bracket is a better trial than Newton's, which is outside or is replaced at
  !> intervals so that the bracket shrinks.
  pure logical function is_better_halved(next, low, high, trial) result(halved)
    !> Trial of Newton's method.
    real(wp), intent(in) :: next
    !> Bracket; huge where there is no bound yet.
    real(wp), intent(in) :: low
    real(wp), intent(in) :: high
    !> Number of the trial.
    integer, intent(in) :: trial

    halved = low > -huge(low) .and. high < huge(high)
    if (halved) halved = next <= low .or. next >= high .or. modulo(trial, 4) == 0
  end function is_better_halved

  !> Returns a change of omega of limited size.
  elemental real(wp) function limited(change)
    !> The required change.
    real(wp), intent(in) :: change

    limited = max(-largest_change, min(largest_change, change))
  end function limited

  !> Moves back along the last correction.
  pure subroutine shorten(new_length, count, length, pressure)
    !> Required length, in corrections.
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

  !> Sets Fbar = exp(omega M) F.
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

  !> Computes pi + c omega - g - h s and k of all points from the result of the law at Fbar: pi = Qbar : h, kappa = (M
  !> Qbar + Abar h) : h with h = M Fbar.
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
      pressure%pressure(p) = dot_product(batch%piola(:, p), h) + pressure%resistance*pressure%omega(p) &
        - pressure%offset(p)
      pressure%stiffness(p) = pressure%resistance + dot_product(m*batch%piola(:, p), h)
      do j = 1, n
        pressure%stiffness(p) = pressure%stiffness(p) + dot_product(h, batch%tangent(:, j, p))*h(j)
      end do
    end do
  end subroutine linearise

  !> Returns whether all points have the common pressure up to rounding.
  pure logical function is_even(slot, common, batch, pressure)
    !> The law of the points.
    type(law_slot_type), intent(in) :: slot
    !> pbar.
    real(wp), intent(in) :: common
    !> The points.
    type(batch_type), intent(in) :: batch
    !> Work space.
    type(pressure_type), intent(in) :: pressure

    associate (y => pressure%pressure(:batch%count), k => pressure%stiffness(:batch%count))
      is_even = all(abs(y - common) <= spread*(slot%law%shear_scale + abs(y)) + rounding*k)
    end associate
  end function is_even

  !> Returns the determinant of a packed deformation gradient.
  pure real(wp) function packed_determinant(f) result(determinant)
    !> (5) or (9)
    real(wp), intent(in) :: f(:)

    if (size(f) == 5) then
      determinant = (f(1)*f(4) - f(2)*f(3))*f(5)
    else
      determinant = f(1)*(f(5)*f(9) - f(6)*f(8)) - f(4)*(f(2)*f(9) - f(3)*f(8)) &
        + f(7)*(f(2)*f(6) - f(3)*f(5))
    end if
  end function packed_determinant
end module qsmpm_pressure_balance
