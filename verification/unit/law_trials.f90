!> What the tests of the constitutive laws share: a material, a batch of trial points, and the
!> comparison of a tangent with central differences.
module law_trials
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type
  use qsmpm_law, only: law_type, batch_type, status_ok, tangent_none, tangent_consistent
  use qsmpm_law_factory, only: new_law
  use qsmpm_material_parameters, only: material_parameters_type
  use qsmpm_tensor, only: gradient_size, stress_size, gradient_row, gradient_column
  implicit none
  private

  public :: elastic, strong, make_law, make_batch, random_batch, plane_batch, compare_plane, &
    difference_error

contains

  !> Elastic parameters.
  pure function elastic(young, poisson) result(p)
    real(wp), intent(in) :: young
    real(wp), intent(in) :: poisson
    type(material_parameters_type) :: p

    p%young = young
    p%poisson = poisson
  end function elastic

  !> The slope's soil: E = 200, nu = 0.33, c = 1, phi = 25, with a dilatancy angle and, when not
  !> negative, a tension cut-off.
  pure function strong(dilatancy, cut_off) result(p)
    real(wp), intent(in) :: dilatancy
    real(wp), intent(in) :: cut_off
    type(material_parameters_type) :: p

    p = elastic(200.0_wp, 0.33_wp)
    p%mohr_coulomb = .true.
    p%cohesion = 1.0_wp
    p%friction_angle = 25.0_wp
    p%dilatancy_angle = dilatancy
    if (cut_off >= 0.0_wp) p%tensile_strength = cut_off
  end function strong

  !> A law that must exist.
  subroutine make_law(p, dimension, kinematics, rate, law)
    type(material_parameters_type), intent(in) :: p
    integer, intent(in) :: dimension
    integer, intent(in) :: kinematics
    integer, intent(in) :: rate
    class(law_type), allocatable, intent(out) :: law
    type(error_type), allocatable :: error

    call new_law(p, dimension, kinematics, rate, law, error)
  end subroutine make_law

  !> A batch of n points with F = I, J = 1.1 and no stress.
  subroutine make_batch(law, n, batch)
    class(law_type), intent(in) :: law
    integer, intent(in) :: n
    type(batch_type), intent(out) :: batch
    integer :: i, g, s

    g = gradient_size(law%dimension)
    s = stress_size(law%dimension)
    batch%count = n
    allocate (batch%gradient(g, n), batch%volume_ratio(n), batch%stress_start(s, n), &
              batch%state_start(law%state_count, n), batch%stress(s, n), &
              batch%state(law%state_count, n), batch%piola(g, n), batch%tangent(g, g, n), &
              batch%status(n), batch%plastic(n))
    batch%volume_ratio = 1.1_wp
    batch%stress_start = 0.0_wp
    do i = 1, g
      batch%gradient(i, :) = merge(1.0_wp, 0.0_wp, &
        gradient_row(i, law%dimension) == gradient_column(i, law%dimension))
    end do
    do i = 1, n
      call law%start(batch%stress_start(:, i), batch%state_start(:, i))
    end do
  end subroutine make_batch

  !> A batch of pseudo-random points: gradients within `spread` of I, stresses within `stress`.
  subroutine random_batch(law, n, spread, stress, batch)
    class(law_type), intent(in) :: law
    integer, intent(in) :: n
    real(wp), intent(in) :: spread
    real(wp), intent(in) :: stress
    type(batch_type), intent(out) :: batch
    integer(long) :: seed
    integer :: i, j

    call make_batch(law, n, batch)
    seed = 4711
    do i = 1, n
      do j = 1, size(batch%gradient, 1)
        batch%gradient(j, i) = batch%gradient(j, i) + spread*random(seed)
      end do
      do j = 1, size(batch%stress_start, 1)
        batch%stress_start(j, i) = stress*random(seed)
      end do
      call law%start(batch%stress_start(:, i), batch%state_start(:, i))
    end do
  end subroutine random_batch

  !> Pseudo-random number from -1 to 1 (Park and Miller).
  real(wp) function random(seed)
    integer(long), intent(inout) :: seed

    seed = modulo(48271_long*seed, 2147483647_long)
    random = 2.0_wp*real(seed, wp)/2147483647.0_wp - 1.0_wp
  end function random

  !> The three-dimensional batch that repeats a plane one.
  subroutine plane_batch(solid, plane, batch)
    class(law_type), intent(in) :: solid
    type(batch_type), intent(in) :: plane
    type(batch_type), intent(out) :: batch
    integer :: i

    call make_batch(solid, plane%count, batch)
    batch%volume_ratio = plane%volume_ratio
    batch%gradient([1, 2, 4, 5, 9], :) = plane%gradient
    batch%stress_start(1:4, :) = plane%stress_start
    do i = 1, plane%count
      call solid%start(batch%stress_start(:, i), batch%state_start(:, i))
    end do
  end subroutine plane_batch

  !> Largest difference of the results of a plane law and of the solid law on the same path.
  subroutine compare_plane(p, kinematics, rate, difference, plastic)
    type(material_parameters_type), intent(in) :: p
    integer, intent(in) :: kinematics
    integer, intent(in) :: rate
    !> Relative to Young's modulus.
    real(wp), intent(out) :: difference
    !> Number of points that yield.
    integer, intent(out) :: plastic
    class(law_type), allocatable :: plane, solid
    type(batch_type) :: flat, full
    integer, parameter :: at(5) = [1, 2, 4, 5, 9]

    call make_law(p, 2, kinematics, rate, plane)
    call make_law(p, 3, kinematics, rate, solid)
    call random_batch(plane, 300, 0.03_wp, 1.0_wp, flat)
    call plane_batch(solid, flat, full)
    call plane%update(flat, tangent_consistent)
    call solid%update(full, tangent_consistent)
    plastic = sum(flat%plastic)
    difference = max(maxval(abs(flat%stress - full%stress(1:4, :))), &
      maxval(abs(flat%piola - full%piola(at, :))), &
      maxval(abs(flat%tangent - full%tangent(at, at, :))), &
      maxval(abs(real(flat%plastic - full%plastic, wp))))/p%young
  end subroutine compare_plane

  !> Largest error of a batch's tangent against central differences of piola, relative to
  !> the largest entry. A difference that crosses from one yield region to another is left out:
  !> there forward and backward differ by the step, elsewhere by its square.
  subroutine difference_error(law, batch, tangent, error, compared, step)
    class(law_type), intent(in) :: law
    !> Points; their results are those of the last update.
    type(batch_type), intent(inout) :: batch
    !> Tangent to be judged (g,g,n).
    real(wp), intent(in) :: tangent(:, :, :)
    real(wp), intent(out) :: error
    !> Number of columns compared.
    integer, intent(out) :: compared
    !> Of the differences, 1e-6 when not given: well below the strain over which the stiffness changes, since a bend
    !> within it is taken for the border of a region.
    real(wp), intent(in), optional :: step
    real(wp), parameter :: usual = 1.0e-6_wp, knot_reduced = 1.0e-3_wp
    real(wp), allocatable :: start(:, :), here(:, :), up(:, :), down(:, :)
    real(wp) :: scale, h
    integer :: i, j

    h = usual
    if (present(step)) h = step
    scale = maxval(abs(tangent))
    allocate (start, source=batch%gradient)
    call law%update(batch, tangent_none)
    allocate (here, source=batch%piola)
    allocate (up, source=here)
    allocate (down, source=here)
    error = 0.0_wp
    compared = 0
    do j = 1, size(start, 1)
      batch%gradient(j, :) = start(j, :) + h
      call law%update(batch, tangent_none)
      up = batch%piola
      batch%gradient(j, :) = start(j, :) - h
      call law%update(batch, tangent_none)
      down = batch%piola
      batch%gradient(j, :) = start(j, :)
      do i = 1, batch%count
        if (batch%status(i) /= status_ok) cycle
        if (maxval(abs(up(:, i) + down(:, i) - 2.0_wp*here(:, i))) &
          > knot_reduced*h*scale) cycle
        compared = compared + 1
        error = max(error, &
          maxval(abs((up(:, i) - down(:, i))/(2.0_wp*h) - tangent(:, j, i)))/scale)
      end do
    end do
  end subroutine difference_error
end module law_trials
