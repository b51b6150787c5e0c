!> One material point under mixed control: a laboratory test on a law.
!>
!> In each step every packed component of the incremental deformation gradient is either prescribed
!> or free; for a free one the Cauchy stress component of the same row and column is prescribed at
!> the end of the step. Newton's method with the law's consistent tangent finds the free ones from
!>   d(sigma)_ij = (dQ F^T + Q dF^T)_ij / J - sigma_ij tr(dF F^-1).
module qsmpm_point_driver
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_not_converged
  use qsmpm_law, only: law_type, batch_type, status_ok, tangent_none, tangent_consistent
  use qsmpm_tensor, only: determinant, inverse, unpack_gradient, pack_gradient, unpack_symmetric, &
    gradient_size, stress_size, gradient_row, gradient_column, identity
  implicit none
  private

  public :: point_type, start_point, step_point

  !> Newton corrections and halvings of one.
  integer, parameter :: max_iterations = 60, max_halvings = 12
  !> Stress error allowed, relative to the largest stress in the step; and round-off in F, which
  !> counts with the stiffness.
  real(wp), parameter :: tolerance = 1.0e-12_wp, round_off = 8.0_wp*epsilon(1.0_wp)
  !> Share of E put on the Jacobian's diagonal: perfect plasticity at an edge leaves lateral strains
  !> undetermined, and this picks those nearest the last ones. It slows Newton by 1e-8 a correction.
  real(wp), parameter :: ridge = 1.0e-8_wp

  !> State of the point.
  type :: point_type
    !> V/V0.
    real(wp) :: volume_ratio = 1.0_wp
    !> Deformation gradient since the start (3,3).
    real(wp) :: deformation(3, 3) = identity
    !> Cauchy stress (4 or 6).
    real(wp), allocatable :: stress(:)
    !> The law's state (state_count).
    real(wp), allocatable :: state(:)
    !> Whether the point yielded in the last step.
    logical :: plastic = .false.
  end type point_type

contains

  !> A point with a given stress.
  subroutine start_point(law, stress, point)
    !> The law.
    class(law_type), intent(in) :: law
    !> Cauchy stress (4 or 6).
    real(wp), intent(in) :: stress(:)
    !> The point.
    type(point_type), intent(out) :: point

    point%stress = stress
    allocate (point%state(law%state_count))
    call law%start(stress, point%state)
  end subroutine start_point

  !> One step. When it fails the point stays as it was.
  subroutine step_point(law, point, prescribed, values, error)
    !> The law.
    class(law_type), intent(in) :: law
    !> The point.
    type(point_type), intent(inout) :: point
    !> Which components of the incremental gradient are prescribed (5 or 9).
    logical, intent(in) :: prescribed(:)
    !> Their values; elsewhere the Cauchy stress of the row and column (5 or 9).
    real(wp), intent(in) :: values(:)
    !> Set when no gradient gives the stresses.
    type(error_type), allocatable, intent(out) :: error
    type(batch_type) :: batch
    integer, allocatable :: free(:)
    integer :: i

    free = pack([(i, i=1, size(values))], .not. prescribed)
    call make_batch(law, point, batch)
    where (prescribed) batch%gradient(:, 1) = values
    call solve_step(law, batch, free, values, error)
    if (allocated(error)) return
    point%stress = batch%stress(:, 1)
    point%state = batch%state(:, 1)
    point%plastic = batch%plastic(1) /= 0
    point%deformation = matmul(unpack_gradient(batch%gradient(:, 1)), point%deformation)
    point%volume_ratio = determinant(point%deformation)
  end subroutine step_point

  !> A batch that holds the point, with F = I.
  subroutine make_batch(law, point, batch)
    !> The law.
    class(law_type), intent(in) :: law
    !> The point.
    type(point_type), intent(in) :: point
    !> The batch.
    type(batch_type), intent(out) :: batch
    integer :: n, m

    n = gradient_size(law%dimension)
    m = stress_size(law%dimension)
    batch%count = 1
    allocate (batch%gradient(n, 1), batch%volume_ratio(1), batch%stress_start(m, 1), &
              batch%state_start(law%state_count, 1), batch%stress(m, 1), &
              batch%state(law%state_count, 1), batch%piola(n, 1), batch%tangent(n, n, 1), &
              batch%status(1), batch%plastic(1))
    call pack_gradient(identity, batch%gradient(:, 1))
    batch%volume_ratio = point%volume_ratio
    batch%stress_start(:, 1) = point%stress
    batch%state_start(:, 1) = point%state
  end subroutine make_batch

  !> Newton's method on the free components, each correction halved until the error falls.
  subroutine solve_step(law, batch, free, values, error)
    !> The law.
    class(law_type), intent(in) :: law
    !> The point, its prescribed components set.
    type(batch_type), intent(inout) :: batch
    !> Numbers of the free components.
    integer, intent(in) :: free(:)
    !> Stresses wanted, by component.
    real(wp), intent(in) :: values(:)
    !> Set when Newton's method does not arrive.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: misfit(size(free)), jacobian(size(free), size(free)), before(size(free)), goal
    integer :: iteration, halving

    call law%update(batch, tangent_consistent)
    if (batch%status(1) == status_ok) then
      do iteration = 1, max_iterations
        misfit = stress_misfit(law, batch, free, values)
        if (norm2(misfit) <= allowed_misfit(batch)) return
        jacobian = stress_jacobian(law, batch, free)
        goal = norm2(misfit)
        call solve_dense(jacobian, misfit)
        before = batch%gradient(free, 1)
        do halving = 0, max_halvings
          batch%gradient(free, 1) = before - misfit*0.5_wp**halving
          call law%update(batch, tangent_none)
          if (batch%status(1) /= status_ok) cycle
          if (norm2(stress_misfit(law, batch, free, values)) < goal) exit
        end do
        call law%update(batch, tangent_consistent)
        if (batch%status(1) /= status_ok) exit
      end do
    end if
    call fail(error, error_not_converged, 'no deformation of the point gives the stresses wanted')
  end subroutine solve_step

  !> Stress error at which Newton's method has arrived.
  pure real(wp) function allowed_misfit(batch)
    !> The point, updated with its consistent tangent.
    type(batch_type), intent(in) :: batch

    allowed_misfit = max(tolerance*maxval(abs(batch%stress(:, 1))), &
                         tolerance*maxval(abs(batch%stress_start(:, 1))), &
                         round_off*maxval(abs(batch%tangent(:, :, 1))))
  end function allowed_misfit

  !> Stress of the free components less the stress wanted.
  pure function stress_misfit(law, batch, free, values) result(misfit)
    !> The law.
    class(law_type), intent(in) :: law
    !> The point.
    type(batch_type), intent(in) :: batch
    !> Numbers of the free components.
    integer, intent(in) :: free(:)
    !> Stresses wanted, by component.
    real(wp), intent(in) :: values(:)
    real(wp) :: misfit(size(free))
    real(wp) :: stress(3, 3)
    integer :: i

    stress = unpack_symmetric(batch%stress(:, 1))
    do i = 1, size(free)
      misfit(i) = stress(gradient_row(free(i), law%dimension), &
                         gradient_column(free(i), law%dimension)) - values(free(i))
    end do
  end function stress_misfit

  !> Derivative of the stresses of the free components.
  pure function stress_jacobian(law, batch, free) result(jacobian)
    !> The law.
    class(law_type), intent(in) :: law
    !> The point, updated with its consistent tangent.
    type(batch_type), intent(in) :: batch
    !> Numbers of the free components.
    integer, intent(in) :: free(:)
    real(wp) :: jacobian(size(free), size(free))
    real(wp) :: f(3, 3), f_inverse(3, 3), q(3, 3), dq(3, 3), change(3, 3), det
    integer :: i, j, k, l

    f = unpack_gradient(batch%gradient(:, 1))
    det = determinant(f)
    f_inverse = inverse(f, det)
    q = unpack_gradient(batch%piola(:, 1))
    do j = 1, size(free)
      k = gradient_row(free(j), law%dimension)
      l = gradient_column(free(j), law%dimension)
      dq = unpack_gradient(batch%tangent(:, free(j), 1))
      change = matmul(dq, transpose(f))
      change(:, k) = change(:, k) + q(:, l)
      change = change/det - f_inverse(l, k)*unpack_symmetric(batch%stress(:, 1))
      do i = 1, size(free)
        jacobian(i, j) = change(gradient_row(free(i), law%dimension), &
                                gradient_column(free(i), law%dimension))
      end do
      jacobian(j, j) = jacobian(j, j) + ridge*law%stiffness_scale
    end do
  end function stress_jacobian

  !> Gauss elimination with row exchange; the right-hand side becomes the solution.
  pure subroutine solve_dense(a, b)
    !> Matrix (n,n), destroyed.
    real(wp), intent(inout) :: a(:, :)
    !> Right-hand side, then solution (n).
    real(wp), intent(inout) :: b(:)
    real(wp) :: row(size(b)), x
    integer :: i, j, p

    do i = 1, size(b)
      p = i - 1 + maxloc(abs(a(i:, i)), dim=1)
      row = a(i, :)
      a(i, :) = a(p, :)
      a(p, :) = row
      x = b(i)
      b(i) = b(p)
      b(p) = x
      do j = i + 1, size(b)
        x = a(j, i)/a(i, i)
        a(j, i:) = a(j, i:) - x*a(i, i:)
        b(j) = b(j) - x*b(i)
      end do
    end do
    do i = size(b), 1, -1
      b(i) = (b(i) - dot_product(a(i, i + 1:), b(i + 1:)))/a(i, i)
    end do
  end subroutine solve_dense
end module qsmpm_point_driver
