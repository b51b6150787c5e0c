!> Unconfined seepage: flow of water through ground with an unknown phreatic surface, steady or in one step in time; the
!> steps are controlled by qsmpm_transient_seepage.
!>
!>   div( k_r(p) K grad h ) = n dS/dt,   p = h - y                                                   Darcy
!>   S = 1 for p >= 0,  1 + p/c for -c < p < 0,  0 below; n: drainable porosity                      0 = steady
!>   k_r = 1 for p >= 0,  1 + (1 - k_min) p/w for -w < p < 0,  k_min below                           suction
!>   in time over c, horizontally k_min + (1 - k_min) (1 + p/c)^3, with the same integral over p
!>   or S, k_r by a curve of the soil (qsmpm_retention), no steeper than over 2 w, in time c
!>   h = H                          below a level of free water
!>   p <= 0,  q >= 0,  q p = 0      on exposed faces: water drains where the surface meets the face    seepage face
!>   q = 0                          on all others;  -rain in place of 0 on faces with rain
!>
!> Discretisation: linear triangles or tetrahedra, k_r at the edge midpoints, storage lumped at the nodes, which fill
!> one after the other as the surface passes the height c of their cells. The seepage face is an active set of nodes in
!> Newton's method with the unsymmetric tangent. As Newton's method usually fails from a saturated start, the width of
!> suction w is halved from the height of the ground to the required value, each solution starting from the last. In dry
!> and partly saturated ground k_min conducts; the errors of k_min and w decrease with the cell size.
!> docs/methods/seepage.md
module qsmpm_seepage
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, error_not_converged, fail
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_node_graph, only: connectivity_type, node_graph
  use qsmpm_node_ordering, only: order_bandwidth, order_metis
  use qsmpm_retention, only: curve_type, let_through_in_time, relative, take_up
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_seepage_field, only: fall_in, find_slopes
  use qsmpm_solver_list, only: solver_number, solver_row, solver_row_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_version, only: with_suitesparse
  implicit none
  private

  public :: seepage_type, seepage_newton_type, solve_seepage, start_seepage, find_heads, end_seepage, height_of, &
    water_in

  !> Residual in heads relative to the height of the ground: at the last width, and at the intermediate ones.
  real(wp), parameter :: last_tolerance = 1.0e-10_wp, way_tolerance = 1.0e-4_wp
  integer, parameter :: most_iterations = 150
  !> Smallest step length of a correction; largest growth of the residual in a damped one.
  real(wp), parameter :: shortest = 1.0_wp/8.0_wp, most_rise = 1.2_wp
  !> Largest number of iterations of a step in time, number of those with full corrections, which may cycle, and
  !> distance by which a correction passes a kink, relative to the height over which soil fills.
  integer, parameter :: most_in_time = 30, quick_in_time = 8
  real(wp), parameter :: past = 1.0e-3_wp
  !> Damping on the diagonal relative to the scale: the first, and the smallest that is not set to zero.
  real(wp), parameter :: first_damping = 1.0e-2_wp, least_damping = 1.0e-4_wp
  !> Tangent of nodes without storage, relative to their conductance.
  real(wp), parameter :: yielding = 1.0e-10_wp
  !> Kinds of nodes.
  integer, parameter, public :: node_free = 0, node_head = 1, node_face = 2

  !> Data and solution of a flow.
  type :: seepage_type
    !> Coordinates (dimension, nodes); weight of a cell's area: 1, or the mean radius (cells).
    real(wp), allocatable :: position(:, :), depth(:)
    !> Nodes of the cells (corners, cells); of triangles counter-clockwise.
    integer, allocatable :: corner(:, :)
    !> Permeability along the axes (dimension, cells).
    real(wp), allocatable :: permeability(:, :)
    !> Retention curve of the soil (cells).
    type(curve_type), allocatable :: curve(:)
    !> Required width of suction, on return the one for which a solution was found; the one originally required.
    real(wp) :: suction = 0.0_wp, wanted = 0.0_wp
    !> One of `node_*`; height y against gravity; head, prescribed or on return computed (nodes).
    integer, allocatable :: kind(:)
    real(wp), allocatable :: height(:), head(:)
    !> Rain, inflow (nodes), and velocity (dimension, cells).
    real(wp), allocatable :: rain(:), inflow(:), velocity(:, :)
    integer :: iterations = 0
    !> Transient step: its length, 0 for steady flow; water volume that a corner of a cell stores when it fills (cells),
    !> the height over which it fills, and the water volume at the start of the step (nodes).
    real(wp) :: interval = 0.0_wp
    real(wp), allocatable :: pores(:), reach(:), water(:)
    !> Number of steps so far.
    integer :: steps = 0
  end type seepage_type

  !> Data of Newton's method.
  type :: seepage_newton_type
    type(sparse_matrix_type) :: matrix
    !> Equation number of each node, 0 for none.
    integer, allocatable :: row(:)
    !> Sum of inflows at the current heads, and saturated conductance of a node, the unit of the residuals (nodes).
    real(wp), allocatable :: inflow(:), scale(:), residual(:)
    !> Saturated flow between the corners of a cell for unit heads, horizontally and vertically (corners, corners, 2,
    !> cells).
    real(wp), allocatable :: conductance(:, :, :, :)
    class(linear_solver_type), allocatable :: solver
  end type seepage_newton_type

contains

  !> Solves for the heads of steady flow.
  subroutine solve_seepage(flow, error)
    type(seepage_type), intent(inout) :: flow
    !> error_not_converged.
    type(error_type), allocatable, intent(out) :: error
    type(seepage_newton_type) :: newton
    real(wp) :: height, width
    real(wp), allocatable :: before(:)

    call start_seepage(flow, newton, error)
    if (allocated(error)) return
    where (flow%kind /= node_head) flow%head = maxval(merge(flow%head, flow%height, flow%kind == node_head), &
      mask=flow%kind /= node_free)
    height = height_of(flow, newton)
    flow%wanted = flow%suction
    width = max(height, flow%suction)
    do
      before = flow%head
      call find_heads(flow, newton, width, height, merge(last_tolerance, way_tolerance, width <= flow%suction), error)
      if (allocated(error)) then
        ! Where no solution is found the width of suction is increased.
        if (2.0_wp*width >= height) exit
        width = 2.0_wp*width
        flow%suction = width
        flow%head = before
        deallocate (error)
      else if (width <= flow%suction) then
        exit
      else
        width = max(0.5_wp*width, flow%suction)
      end if
    end do
    call end_seepage(flow, newton, width)
  end subroutine solve_seepage

  !> Height of the ground that water flows through.
  pure real(wp) function height_of(flow, newton) result(height)
    type(seepage_type), intent(in) :: flow
    type(seepage_newton_type), intent(in) :: newton

    height = maxval(flow%height, mask=newton%row > 0) - minval(flow%height, mask=newton%row > 0)
  end function height_of

  !> Stores inflows and velocities and releases the solver.
  subroutine end_seepage(flow, newton, width)
    type(seepage_type), intent(inout) :: flow
    type(seepage_newton_type), intent(inout) :: newton
    !> Width of suction.
    real(wp), intent(in) :: width

    call newton%solver%destroy()
    flow%inflow = newton%inflow
    call take_velocity(flow, width)
  end subroutine end_seepage

  !> Numbers the equations of the nodes and prepares the solver.
  subroutine start_seepage(flow, newton, error)
    type(seepage_type), intent(in) :: flow
    type(seepage_newton_type), intent(inout) :: newton
    type(error_type), allocatable, intent(out) :: error
    type(connectivity_type) :: cells
    type(solver_row_type) :: kind
    logical, allocatable :: active(:)
    integer, allocatable :: node(:), first(:), neighbour(:), place(:)
    integer :: i

    cells%count = size(flow%corner, 2)
    cells%first = [(size(flow%corner, 1)*(i - 1) + 1, i=1, cells%count + 1)]
    cells%nodes = reshape(flow%corner, [size(flow%corner)])
    call node_graph(cells, size(flow%head), active, node, first, neighbour)
    kind = solver_row(solver_number(merge('UMFPACK', 'BAND   ', with_suitesparse)))
    allocate (place(size(node)))
    if (kind%narrow_band) then
      call order_bandwidth(first, neighbour, place)
    else
      call order_metis(first, neighbour, place, error)
      if (allocated(error)) return
    end if
    allocate (newton%row(size(flow%head)), source=0)
    newton%row(node) = place
    call make_pattern(first, neighbour, place, newton%matrix)
    allocate (newton%conductance(size(flow%corner, 1), size(flow%corner, 1), 2, cells%count))
    do i = 1, cells%count
      call find_conductance(flow, i, newton%conductance(:, :, :, i))
    end do
    call kind%make(.false., newton%solver)
    call newton%solver%analyse(newton%matrix, error)
  end subroutine start_seepage

  !> Generates the sparsity pattern: neighbours of each node and itself.
  pure subroutine make_pattern(first, neighbour, place, matrix)
    integer, intent(in) :: first(:), neighbour(:), place(:)
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: node_at(size(place)), i, k, last, column

    matrix%n = size(place)
    node_at(place) = [(i, i=1, size(place))]
    allocate (matrix%row_first(matrix%n + 1), matrix%column(size(neighbour) + matrix%n))
    matrix%row_first(1) = 1
    do i = 1, matrix%n
      associate (near => [place(neighbour(first(node_at(i)):first(node_at(i) + 1) - 1)), i])
        last = 0
        do k = 1, size(near)
          column = minval(near, mask=near > last)
          matrix%column(matrix%row_first(i) + k - 1) = column
          last = column
        end do
        matrix%row_first(i + 1) = matrix%row_first(i) + size(near)
      end associate
    end do
    allocate (matrix%values(size(matrix%column)), source=0.0_wp)
  end subroutine make_pattern

  !> Runs Newton's method at one width of suction. Where no step length reduces the residual, the diagonal is increased,
  !> similar to a time step; damped corrections may increase the residual slightly and so pass the kinks of k_r.
  subroutine find_heads(flow, newton, width, height, tolerance, error)
    type(seepage_type), intent(inout) :: flow
    type(seepage_newton_type), intent(inout) :: newton
    !> Width of suction; height of the ground, and residual relative to it.
    real(wp), intent(in) :: width, height, tolerance
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: correction(newton%matrix%n), norm, damping
    integer :: iteration

    damping = 0.0_wp
    call assemble(flow, newton, width)
    norm = residual_norm(newton)
    do iteration = 1, most_iterations
      if (norm <= tolerance*height .and. iteration > 1) return
      call solve_damped(newton, damping, correction, error)
      if (allocated(error)) return
      if (flow%interval > 0.0_wp) then
        if (iteration == most_in_time) exit
        if (iteration > quick_in_time) correction = 0.5_wp*correction
        call take_to_kinks(flow, newton, correction, width, norm)
      else
        call take_share(flow, newton, correction, width, damping, norm)
      end if
    end do
    if (norm <= tolerance*height) return
    call fail(error, error_not_converged, 'the seepage analysis does not converge: heads are in error by '// &
      rounded_text(norm)//' after '//rounded_text(real(most_iterations, wp))//' iterations with suction over a '// &
      'height of '//rounded_text(width))
  end subroutine find_heads

  !> Solves for the corrections of the heads with a share of the scale added to the diagonal of the tangent.
  subroutine solve_damped(newton, damping, correction, error)
    type(seepage_newton_type), intent(inout) :: newton
    real(wp), intent(in) :: damping
    real(wp), intent(out) :: correction(:)
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: right(size(correction))
    integer :: i

    do i = 1, size(newton%row)
      if (newton%row(i) == 0) cycle
      right(newton%row(i)) = -newton%residual(i)
      call add_entry(newton%matrix, newton%row(i), newton%row(i), damping*newton%scale(i))
    end do
    call newton%solver%factorise(newton%matrix, error)
    if (.not. allocated(error)) call newton%solver%solve(right, correction, error)
  end subroutine solve_damped

  !> Applies a correction that stops at nodes whose soil begins to fill, or becomes or ceases to be saturated, since the
  !> equations of the node differ on either side.
  pure subroutine take_to_kinks(flow, newton, correction, width, norm)
    type(seepage_type), intent(inout) :: flow
    type(seepage_newton_type), intent(inout) :: newton
    real(wp), intent(in) :: correction(:), width
    real(wp), intent(out) :: norm
    real(wp) :: before, after
    logical :: linear(size(flow%head))
    integer :: i, c

    flow%iterations = flow%iterations + 1
    linear = .false.
    do c = 1, size(flow%curve)
      if (.not. flow%curve(c)%alpha > 0.0_wp) linear(flow%corner(:, c)) = .true.
    end do
    do i = 1, size(newton%row)
      if (newton%row(i) == 0) cycle
      before = (flow%head(i) - flow%height(i))/flow%reach(i)
      after = before + correction(newton%row(i))/flow%reach(i)
      if (before < -1.0_wp .and. linear(i)) after = min(after, past - 1.0_wp)
      if (before > -1.0_wp .and. linear(i)) after = max(after, -1.0_wp - past)
      if (before > 0.0_wp) after = max(after, -past)
      if (before < 0.0_wp) after = min(after, past)
      flow%head(i) = flow%height(i) + after*flow%reach(i)
    end do
    call assemble(flow, newton, width)
    norm = residual_norm(newton)
  end subroutine take_to_kinks

  !> Applies the longest share of a correction that reduces the residual or, if damped, does not increase it much;
  !> without one the heads are restored and the damping is increased.
  pure subroutine take_share(flow, newton, correction, width, damping, norm)
    type(seepage_type), intent(inout) :: flow
    type(seepage_newton_type), intent(inout) :: newton
    real(wp), intent(in) :: correction(:), width
    real(wp), intent(inout) :: damping, norm
    real(wp) :: before(size(flow%head)), share, found, most

    flow%iterations = flow%iterations + 1
    before = flow%head
    share = 1.0_wp
    do
      where (newton%row > 0) flow%head = before + share*correction(max(1, newton%row))
      call assemble(flow, newton, width)
      found = residual_norm(newton)
      most = merge(most_rise, 1.0_wp - 1.0e-4_wp*share, damping > 0.0_wp)*norm
      if (found < most) exit
      if (share <= shortest) then
        flow%head = before
        call assemble(flow, newton, width)
        damping = max(first_damping, 4.0_wp*damping)
        return
      end if
      share = 0.5_wp*share
    end do
    norm = found
    if (share < 0.5_wp) return
    damping = merge(0.5_wp*damping, 0.0_wp, damping >= 2.0_wp*least_damping)
  end subroutine take_share

  !> Root mean square of the residuals in heads.
  pure real(wp) function residual_norm(newton)
    type(seepage_newton_type), intent(in) :: newton

    residual_norm = norm2(pack(newton%residual/newton%scale, newton%row > 0))/sqrt(real(newton%matrix%n, wp))
  end function residual_norm

  !> Assembles inflows at the current heads, residuals and tangent. A node of a seepage face has zero pressure as long
  !> as water drains there or would drain.
  pure subroutine assemble(flow, newton, width)
    type(seepage_type), intent(in) :: flow
    type(seepage_newton_type), intent(inout) :: newton
    real(wp), intent(in) :: width
    real(wp), dimension(size(flow%corner, 1), 2) :: by_head, inflow
    real(wp) :: factor(2)
    integer :: c, a, b, i

    if (.not. allocated(newton%inflow)) allocate (newton%inflow(size(flow%head)), newton%scale(size(flow%head)))
    newton%inflow = 0.0_wp
    newton%scale = tiny(1.0_wp)
    newton%matrix%values = 0.0_wp
    do c = 1, size(flow%corner, 2)
      associate (node => flow%corner(:, c), conductance => newton%conductance(:, :, :, c))
        call let_through(flow, c, width, factor, by_head)
        do a = 1, size(node)
          inflow(a, :) = [(dot_product(conductance(a, :, b), flow%head(node)), b=1, 2)]
        end do
        newton%inflow(node) = newton%inflow(node) + matmul(inflow, factor)
        do a = 1, size(node)
          newton%scale(node(a)) = newton%scale(node(a)) + sum(conductance(a, a, :))
          do b = 1, size(node)
            call add_entry(newton%matrix, newton%row(node(a)), newton%row(node(b)), dot_product(factor, &
              conductance(a, b, :)) + dot_product(inflow(a, :), by_head(b, :)))
          end do
        end do
      end associate
    end do
    if (flow%interval > 0.0_wp) call store(flow, newton)
    newton%residual = newton%inflow - flow%rain
    do i = 1, size(newton%row)
      if (newton%row(i) == 0 .or. flow%kind(i) == node_free) cycle
      if (flow%kind(i) == node_face) then
        associate (pressure => flow%head(i) - flow%height(i))
          if (.not. newton%scale(i)*pressure - newton%residual(i) > 0.0_wp) cycle
          newton%residual(i) = newton%scale(i)*pressure
        end associate
      else
        newton%residual(i) = 0.0_wp
      end if
      call hold_row(newton%matrix, newton%row(i), newton%scale(i))
    end do
  end subroutine assemble

  !> Adds the storage of a transient step to the inflows. Saturated and dry ground stores none, however short the step;
  !> only the tangent has a small value there, so that the pressure of ground without a level is unique.
  pure subroutine store(flow, newton)
    type(seepage_type), intent(in) :: flow
    type(seepage_newton_type), intent(inout) :: newton
    real(wp) :: water(size(flow%head)), slope(size(flow%head))
    integer :: i

    call water_in(flow, water, slope)
    newton%inflow = newton%inflow + (water - flow%water)/flow%interval
    slope = slope/flow%interval
    do i = 1, size(newton%row)
      if (newton%row(i) == 0) cycle
      call add_entry(newton%matrix, newton%row(i), newton%row(i), slope(i) + yielding*newton%scale(i))
    end do
    newton%scale = newton%scale + slope
  end subroutine store

  !> Computes the water volume in the drainable pores, lumped at the nodes, and its derivative by the head (nodes).
  pure subroutine water_in(flow, water, by_head)
    type(seepage_type), intent(in) :: flow
    real(wp), intent(out) :: water(:), by_head(:)
    real(wp) :: share, slope
    integer :: c, k

    water = 0.0_wp
    by_head = 0.0_wp
    do c = 1, size(flow%corner, 2)
      do k = 1, size(flow%corner, 1)
        associate (i => flow%corner(k, c))
          call take_up(flow%curve(c), flow%head(i) - flow%height(i), flow%reach(i), share, slope)
          water(i) = water(i) + flow%pores(c)*share
          by_head(i) = by_head(i) + flow%pores(c)*slope
        end associate
      end do
    end do
  end subroutine water_in

  !> Computes the saturated flow between the corners of a cell for unit heads, horizontally and vertically.
  pure subroutine find_conductance(flow, c, conductance)
    type(seepage_type), intent(in) :: flow
    integer, intent(in) :: c
    real(wp), intent(out) :: conductance(:, :, :)
    real(wp) :: gradient(size(flow%position, 1), size(flow%corner, 1)), along(size(gradient, 1), 2), part
    integer :: k

    associate (x => flow%position(:, flow%corner(:, c)))
      call find_slopes(x, gradient)
      part = merge(2.0_wp, 6.0_wp, size(x, 1) == 2)*abs(dot_product(gradient(:, 1), x(:, 1) - x(:, 2)))
    end associate
    along = permeability_along(flow, c)
    do k = 1, 2
      conductance(:, :, k) = flow%depth(c)*matmul(transpose(gradient), spread(along(:, k), 2, size(gradient, 2)) &
        *gradient)/part
    end do
  end subroutine find_conductance

  !> Permeability of a cell horizontally and vertically, 0 for the other axes (dimension, 2).
  pure function permeability_along(flow, c) result(along)
    type(seepage_type), intent(in) :: flow
    integer, intent(in) :: c
    real(wp) :: along(size(flow%position, 1), 2), rise(size(flow%position, 1)), determinant

    associate (node => flow%corner(:, c))
      call fall_in(flow%position(:, node), flow%height(node), rise, determinant)
    end associate
    along(:, 2) = merge(flow%permeability(:, c), 0.0_wp, abs(rise) > 0.5_wp*abs(determinant))
    along(:, 1) = flow%permeability(:, c) - along(:, 2)
  end function permeability_along

  !> Returns the relative permeability of a cell, horizontally and vertically, and its derivatives by the heads of its
  !> corners. In a transient step suction acts over the height over which the cell fills, or water would stay in it.
  pure subroutine let_through(flow, c, width, factor, by_head)
    type(seepage_type), intent(in) :: flow
    integer, intent(in) :: c
    !> Width of suction in steady flow.
    real(wp), intent(in) :: width
    !> (2), (corners, 2)
    real(wp), intent(out) :: factor(2), by_head(:, :)

    associate (node => flow%corner(:, c))
      associate (pressure => flow%head(node) - flow%height(node))
        if (flow%interval > 0.0_wp) then
          call let_through_in_time(flow%curve(c), pressure, flow%reach(node), factor, by_head)
        else if (flow%curve(c)%alpha > 0.0_wp) then
          call let_through_in_time(flow%curve(c), pressure, spread(2.0_wp*width, 1, size(node)), factor, by_head)
        else
          call relative(pressure, width, [1, 1], factor, by_head)
        end if
      end associate
    end associate
  end subroutine let_through

  !> Adds a value to an entry of the matrix.
  pure subroutine add_entry(matrix, row, column, value)
    type(sparse_matrix_type), intent(inout) :: matrix
    integer, intent(in) :: row, column
    real(wp), intent(in) :: value
    integer :: k

    do k = matrix%row_first(row), matrix%row_first(row + 1) - 1
      if (matrix%column(k) == column) matrix%values(k) = matrix%values(k) + value
    end do
  end subroutine add_entry

  !> Replaces a row of the matrix by the equation of a prescribed head.
  pure subroutine hold_row(matrix, row, scale)
    type(sparse_matrix_type), intent(inout) :: matrix
    integer, intent(in) :: row
    real(wp), intent(in) :: scale

    associate (entries => matrix%values(matrix%row_first(row):matrix%row_first(row + 1) - 1), &
        columns => matrix%column(matrix%row_first(row):matrix%row_first(row + 1) - 1))
      entries = merge(scale, 0.0_wp, columns == row)
    end associate
  end subroutine hold_row

  !> Computes the velocity in the cells.
  pure subroutine take_velocity(flow, width)
    type(seepage_type), intent(inout) :: flow
    real(wp), intent(in) :: width
    real(wp) :: factor(2), by_head(size(flow%corner, 1), 2), fall(size(flow%position, 1)), determinant
    integer :: c

    allocate (flow%velocity(size(fall), size(flow%corner, 2)))
    do c = 1, size(flow%corner, 2)
      associate (node => flow%corner(:, c))
        call let_through(flow, c, width, factor, by_head)
        call fall_in(flow%position(:, node), flow%head(node), fall, determinant)
        flow%velocity(:, c) = -matmul(permeability_along(flow, c), factor)*fall/determinant
      end associate
    end do
  end subroutine take_velocity
end module qsmpm_seepage
