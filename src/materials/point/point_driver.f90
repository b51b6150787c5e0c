!> One material point under mixed control: a laboratory test on a law.
!>
!> In each step the incremental deformation gradient f is computed for which every control has its
!> value. Newton's method uses the law's consistent tangent; controls that are linear in f are satisfied from the first
!> full correction on. A law without a consistent tangent requires more corrections; the limit allows for them.
!>
!> There are as many controls as the incremental deformation gradient f has packed
!> components. Each prescribes the value of
!>   a sum of components of the whole gradient F = f F0, the volume ratio det F, or a sum of components of the Cauchy
!>   stress.
!> The module computes the misfit of a control and its derivative with respect to f, with the law's tangent A = dQ/df:
!>   d(sigma) = (A:df f^T + Q df^T)/det f - sigma tr(df f^-1).
module qsmpm_point_driver
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_not_converged, error_user_material
  use qsmpm_law, only: law_type, batch_type, step_info_type, status_ok, status_unrecoverable, tangent_consistent
  use qsmpm_tensor, only: determinant, unpack_gradient, pack_gradient, gradient_size, stress_size, identity, inverse, &
    unpack_symmetric, gradient_row, gradient_column
  implicit none
  private

  public :: point_type, start_point, prepare_point, control_point, control_type, control_value, control_misfit, &
    control_jacobian

  !> Largest number of Newton corrections, and of halvings of a correction.
  integer, parameter :: max_iterations = 60, max_halvings = 12
  !> Round-off in f, multiplied by the stiffness.
  real(wp), parameter :: round_off = 8.0_wp*epsilon(1.0_wp)
  !> Tolerance of controls of the deformation.
  real(wp), parameter :: deformation_error = 64.0_wp*epsilon(1.0_wp)
  !> Share of E added to the Jacobian's diagonal: perfect plasticity at an edge leaves lateral strains
  !> undetermined, and this selects those closest to the last ones. It slows Newton's method by 1e-8 a correction.
  real(wp), parameter :: ridge = 1.0e-8_wp

  !> State of the point.
  type :: point_type
    !> V/V0.
    real(wp) :: volume_ratio = 1.0_wp
    !> Deformation gradient with respect to the start (3,3).
    real(wp) :: deformation(3, 3) = identity
    !> Cauchy stress (4 or 6).
    real(wp), allocatable :: stress(:)
    !> The law's state (state_count).
    real(wp), allocatable :: state(:)
    !> Whether the point yielded in the last step.
    logical :: plastic = .false.
  end type point_type

  !> Controlled quantities.
  integer, parameter, public :: control_gradient = 1, control_volume = 2, control_stress = 3

  !> One control.
  type :: control_type
    integer :: kind = control_gradient
    !> Weights of the components in the order of packed gradients; a stress is that of the same row and column.
    real(wp) :: weight(9) = 0.0_wp
    !> Value required at the end of the step.
    real(wp) :: value = 0.0_wp
  end type control_type

contains

  !> Initialises a point with a given stress.
  subroutine start_point(law, stress, point)
    class(law_type), intent(in) :: law
    !> Cauchy stress (4 or 6).
    real(wp), intent(in) :: stress(:)
    type(point_type), intent(out) :: point

    point%stress = stress
    allocate (point%state(law%state_count))
    call law%start(stress, point%state)
  end subroutine start_point

  !> Prepares a batch for one point, or for several.
  subroutine prepare_point(law, batch, points)
    class(law_type), intent(in) :: law
    type(batch_type), intent(out) :: batch
    integer, intent(in), optional :: points
    integer :: n, m

    n = gradient_size(law%dimension)
    m = stress_size(law%dimension)
    batch%count = 1
    if (present(points)) batch%count = points
    associate (k => batch%count)
      allocate (batch%gradient(n, k), batch%volume_ratio(k), batch%stress_start(m, k), &
                batch%state_start(law%state_count, k), batch%stress(m, k), &
                batch%state(law%state_count, k), batch%piola(n, k), batch%tangent(n, n, k), &
                batch%status(k), batch%plastic(k))
      allocate (batch%number(k), batch%cell(k), source=1)
      allocate (batch%place(law%dimension, k), source=0.0_wp)
      allocate (batch%cell_size(k), source=1.0_wp)
    end associate
  end subroutine prepare_point

  !> Solves one step under controls. If it fails, the point is unchanged.
  subroutine control_point(law, point, controls, tolerance, step_info, batch, iterations, error)
    class(law_type), intent(in) :: law
    type(point_type), intent(inout) :: point
    !> The controls (5 or 9).
    type(control_type), intent(in) :: controls(:)
    !> Tolerance of stresses, relative to the largest stress.
    real(wp), intent(in) :: tolerance
    !> Time of the step.
    type(step_info_type), intent(in) :: step_info
    !> Batch of the point; on exit start and end of the step, with the consistent tangent.
    type(batch_type), intent(inout) :: batch
    !> Number of corrections.
    integer, intent(out) :: iterations
    !> Set when no deformation gives the values, or the law has failed.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: f(3, 3)

    batch%step_info = step_info
    batch%share = 0.0_wp
    if (allocated(batch%message)) deallocate (batch%message)
    batch%volume_ratio = point%volume_ratio
    batch%stress_start(:, 1) = point%stress
    batch%state_start(:, 1) = point%state
    call pack_gradient(identity, batch%gradient(:, 1))
    call solve_step(law, batch, controls, point%deformation, tolerance, iterations, error)
    if (allocated(error)) return
    point%stress(:) = batch%stress(:, 1)
    point%state(:) = batch%state(:, 1)
    point%plastic = batch%plastic(1) /= 0
    f = unpack_gradient(batch%gradient(:, 1))
    point%deformation = matmul(f, point%deformation)
    point%volume_ratio = determinant(point%deformation)
  end subroutine control_point

  !> Solves by Newton's method; each correction is halved until the error decreases.
  subroutine solve_step(law, batch, controls, start, tolerance, iterations, error)
    class(law_type), intent(in) :: law
    !> The point with f = I.
    type(batch_type), intent(inout) :: batch
    type(control_type), intent(in) :: controls(:)
    !> Deformation gradient at the start (3,3); tolerance of stresses.
    real(wp), intent(in) :: start(3, 3), tolerance
    !> Number of corrections.
    integer, intent(out) :: iterations
    !> Set when it does not converge.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: misfit(size(controls)), jacobian(size(controls), size(controls)), before(size(controls)), &
      left(size(controls)), goal
    integer :: iteration, halving

    call law%update(batch, tangent_consistent)
    do iteration = 1, max_iterations
      iterations = iteration - 1
      if (batch%status(1) /= status_ok) exit
      call control_misfit(controls, batch, start, misfit)
      if (has_arrived(controls, misfit, batch, tolerance)) return
      call control_jacobian(controls, batch, start, jacobian)
      call scale_rows(law, controls, jacobian, misfit)
      goal = norm2(misfit)
      call solve_dense(jacobian, misfit)
      before = batch%gradient(:, 1)
      do halving = 0, max_halvings
        batch%gradient(:, 1) = before - misfit*0.5_wp**halving
        if (.not. determinant(unpack_gradient(batch%gradient(:, 1))) > 0.0_wp) cycle
        call law%update(batch, tangent_consistent)
        if (batch%status(1) == status_unrecoverable) exit
        if (batch%status(1) /= status_ok) cycle
        call control_misfit(controls, batch, start, left)
        where (controls%kind == control_stress) left = left/law%stiffness_scale
        if (norm2(left) < goal) exit
      end do
    end do
    call report_failure(batch, error)
  end subroutine solve_step

  !> Reports the reason for the failure of a step.
  pure subroutine report_failure(batch, error)
    !> The point.
    type(batch_type), intent(in) :: batch
    !> Set.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: message

    message = ''
    if (allocated(batch%message)) message = trim(batch%message)
    if (batch%status(1) == status_unrecoverable) then
      if (len(message) == 0) message = 'the material law is out of order'
      call fail(error, error_user_material, message)
    else if (len(message) > 0) then
      call fail(error, error_not_converged, 'the material law refuses the step: '//message)
    else if (batch%status(1) /= status_ok) then
      call fail(error, error_not_converged, 'the material law refuses the step')
    else
      call fail(error, error_not_converged, 'no deformation of the point gives the stresses required')
    end if
  end subroutine report_failure

  !> Whether every control has its value.
  pure logical function has_arrived(controls, misfit, batch, tolerance)
    type(control_type), intent(in) :: controls(:)
    !> Their misfits.
    real(wp), intent(in) :: misfit(:)
    !> The point, updated with its consistent tangent.
    type(batch_type), intent(in) :: batch
    !> Tolerance of stresses.
    real(wp), intent(in) :: tolerance
    real(wp) :: allowed
    integer :: i

    allowed = max(tolerance*maxval(abs(batch%stress(:, 1))), tolerance*maxval(abs(batch%stress_start(:, 1))), &
                  round_off*maxval(abs(batch%tangent(:, :, 1))))
    has_arrived = norm2(pack(misfit, controls%kind == control_stress)) <= allowed
    do i = 1, size(controls)
      if (controls(i)%kind == control_stress) cycle
      has_arrived = has_arrived .and. abs(misfit(i)) <= deformation_error*max(1.0_wp, abs(controls(i)%value))
    end do
  end function has_arrived

  !> Divides the rows of stresses by the stiffness, and adds the ridge to them.
  pure subroutine scale_rows(law, controls, jacobian, misfit)
    class(law_type), intent(in) :: law
    type(control_type), intent(in) :: controls(:)
    !> Derivatives and misfits.
    real(wp), intent(inout) :: jacobian(:, :), misfit(:)
    integer :: i

    do i = 1, size(controls)
      if (controls(i)%kind /= control_stress) cycle
      jacobian(i, :) = jacobian(i, :)/law%stiffness_scale + ridge*controls(i)%weight(:size(controls))
      misfit(i) = misfit(i)/law%stiffness_scale
    end do
  end subroutine scale_rows

  !> Solves by Gaussian elimination with row exchange; the right-hand side becomes the solution.
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

  !> Present value of the controlled quantity.
  pure real(wp) function control_value(control, whole, stress) result(value)
    type(control_type), intent(in) :: control
    !> Deformation gradient at the end (3,3); Cauchy stress at the end (4 or 6).
    real(wp), intent(in) :: whole(3, 3), stress(:)
    real(wp) :: tensor(3, 3)
    integer :: i, d

    if (control%kind == control_volume) then
      value = determinant(whole)
      return
    end if
    value = 0.0_wp
    d = merge(3, 2, size(stress) == 6)
    tensor = whole
    if (control%kind == control_stress) tensor = unpack_symmetric(stress)
    do i = 1, gradient_size(d)
      value = value + control%weight(i)*tensor(gradient_row(i, d), gradient_column(i, d))
    end do
  end function control_value

  !> Computes the differences of the values from those required.
  pure subroutine control_misfit(controls, batch, start, misfit)
    !> The controls (5 or 9).
    type(control_type), intent(in) :: controls(:)
    !> The point, updated.
    type(batch_type), intent(in) :: batch
    !> Deformation gradient at the start of the step (3,3).
    real(wp), intent(in) :: start(3, 3)
    !> Misfits, each in the unit of its control.
    real(wp), intent(out) :: misfit(:)
    real(wp) :: whole(3, 3)
    integer :: i

    whole = matmul(unpack_gradient(batch%gradient(:, 1)), start)
    do i = 1, size(controls)
      misfit(i) = control_value(controls(i), whole, batch%stress(:, 1)) - controls(i)%value
    end do
  end subroutine control_misfit

  !> Computes the derivatives of the values: (control, component of f).
  pure subroutine control_jacobian(controls, batch, start, jacobian)
    !> The controls (5 or 9).
    type(control_type), intent(in) :: controls(:)
    !> The point, updated with its consistent tangent.
    type(batch_type), intent(in) :: batch
    !> Deformation gradient at the start of the step (3,3).
    real(wp), intent(in) :: start(3, 3)
    !> The derivatives.
    real(wp), intent(out) :: jacobian(:, :)
    real(wp) :: f(3, 3), f_inverse(3, 3), weights(3, 3), change(3, 3), det, ratio
    integer :: i, j, k, l, d

    d = merge(3, 2, size(controls) == 9)
    f = unpack_gradient(batch%gradient(:, 1))
    det = determinant(f)
    f_inverse = inverse(f, det)
    ratio = det*determinant(start)
    do j = 1, size(controls)
      k = gradient_row(j, d)
      l = gradient_column(j, d)
      change = stress_change(batch, f, det, f_inverse, j, k, l)
      do i = 1, size(controls)
        weights = unpack_gradient(controls(i)%weight(:size(controls)))
        select case (controls(i)%kind)
        case (control_gradient)
          jacobian(i, j) = dot_product(weights(k, :), start(l, :))
        case (control_volume)
          jacobian(i, j) = ratio*f_inverse(l, k)
        case default
          jacobian(i, j) = sum(weights*change)
        end select
      end do
    end do
  end subroutine control_jacobian

  !> Derivative of the Cauchy stress with respect to component j of f, at row k and column l.
  pure function stress_change(batch, f, det, f_inverse, j, k, l) result(change)
    !> The point, updated with its consistent tangent.
    type(batch_type), intent(in) :: batch
    !> f, its determinant and its inverse.
    real(wp), intent(in) :: f(3, 3), det, f_inverse(3, 3)
    !> The component.
    integer, intent(in) :: j, k, l
    real(wp) :: change(3, 3), q(3, 3), dq(3, 3)

    q = unpack_gradient(batch%piola(:, 1))
    dq = unpack_gradient(batch%tangent(:, j, 1))
    change = matmul(dq, transpose(f))
    change(:, k) = change(:, k) + q(:, l)
    change = change/det - f_inverse(l, k)*unpack_symmetric(batch%stress(:, 1))
  end function stress_change
end module qsmpm_point_driver
