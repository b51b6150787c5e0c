!> Transient seepage with a free surface: levels at the boundary vary linearly in time, the phreatic surface follows
!> according to the permeability and drainable porosity of the ground.
!>
!>   sum V n (S - S_0) + dt sum V k_r K grad h grad N = dt q                     backward Euler, qsmpm_seepage
!>
!> The step length is controlled by the error: half the difference between the pressures and their extrapolation with
!> the rates of the previous step. The first step is a thousandth of the time and takes instantaneous changes. A step
!> without solution is repeated with a quarter of its length.
module qsmpm_transient_seepage
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_polygon, only: polygon_area
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_seepage, only: end_seepage, find_heads, height_of, node_face, node_head, &
    seepage_newton_type, seepage_type, start_seepage, water_in
  use qsmpm_seepage_field, only: find_slopes
  implicit none
  private

  public :: give_pores, follow_seepage

  !> Residual in heads relative to the height of the ground; with curves, heads of dry ground depend on little water.
  real(wp), parameter :: tolerance = 1.0e-8_wp, tolerance_of_curve = 1.0e-9_wp
  !> Error of the pressures in a step relative to the width of suction, half a cell.
  real(wp), parameter :: largest_error = 0.02_wp
  !> First step relative to the duration, and the shortest one; largest and smallest ratio of successive steps.
  real(wp), parameter :: first = 1.0e-3_wp, shortest = 1.0e-8_wp, longer = 1.5_wp, shorter = 0.25_wp

contains

  !> Computes the water volume that the corners of cells store when they fill, and the mean cell height at the nodes,
  !> over which they fill.
  pure subroutine give_pores(porosity, flow)
    !> (cells)
    real(wp), intent(in) :: porosity(:)
    type(seepage_type), intent(inout) :: flow
    real(wp) :: share, area(size(flow%head)), slope(3, 4)
    integer :: c

    allocate (flow%pores(size(porosity)), flow%reach(size(flow%head)), source=0.0_wp)
    area = 0.0_wp
    do c = 1, size(flow%corner, 2)
      associate (node => flow%corner(:, c))
        if (size(node) == 4) then
          call find_slopes(flow%position(:, node), slope)
          share = abs(dot_product(slope(:, 2), flow%position(:, node(2)) - flow%position(:, node(1))))/24.0_wp
        else
          share = flow%depth(c)*abs(polygon_area(flow%position(:, node)))/3.0_wp
        end if
        area(node) = area(node) + share
        flow%pores(c) = share*porosity(c)
        flow%reach(node) = flow%reach(node) + share*(maxval(flow%height(node)) - minval(flow%height(node)))
      end associate
    end do
    where (area > 0.0_wp) flow%reach = flow%reach/area
  end subroutine give_pores

  !> Computes the heads after a time from those at its start.
  subroutine follow_seepage(flow, row, from, to, time, error)
    !> Contains the heads at the start and the storage.
    type(seepage_type), intent(inout) :: flow
    !> Level of each node on the boundary, 0 for none (nodes).
    integer, intent(in) :: row(:)
    !> Height of each level at the start and at the end.
    real(wp), intent(in) :: from(:), to(:)
    real(wp), intent(in) :: time
    !> error_not_converged.
    type(error_type), allocatable, intent(out) :: error
    type(seepage_newton_type) :: newton
    real(wp) :: reached, next
    real(wp), dimension(size(flow%head)) :: before, rate, ahead, slope

    call start_seepage(flow, newton, error)
    if (allocated(error)) return
    flow%wanted = flow%suction
    allocate (flow%water(size(row)))
    next = first*time
    reached = 0.0_wp
    do while (reached < (1.0_wp - shortest)*time)
      flow%interval = min(next, time - reached)
      before = flow%head
      call water_in(flow, flow%water, slope)
      ahead = surface_of(flow)
      call set_levels(row, from + (to - from)*(reached + flow%interval)/time, flow)
      call find_heads(flow, newton, flow%suction, height_of(flow, newton), &
        merge(tolerance_of_curve, tolerance, any(flow%curve%alpha > 0.0_wp)), error)
      next = shorter*flow%interval
      if (.not. allocated(error)) next = max(flow%interval*next_over_this(flow, ahead, rate), min(flow%interval, &
        first*time))
      if ((allocated(error) .or. next < 0.5_wp*flow%interval) .and. next > shortest*time) then
        if (allocated(error)) deallocate (error)
        flow%head = before
        cycle
      end if
      if (allocated(error)) exit
      flow%steps = flow%steps + 1
      reached = reached + flow%interval
      rate = (surface_of(flow) - ahead)/flow%interval
    end do
    call end_seepage(flow, newton, flow%suction)
    if (allocated(error)) error%message = error%message//', '//rounded_text(reached, 4)//' after the start of the phase'
  end subroutine follow_seepage

  !> Ratio of the next step length to this one by its error; below one half where this step is too long.
  pure real(wp) function next_over_this(flow, ahead, rate) result(ratio)
    type(seepage_type), intent(in) :: flow
    !> Measure of the solution at the start of the step, and its rates in the previous step (nodes).
    real(wp), intent(in) :: ahead(:), rate(:)
    real(wp) :: deviation

    ratio = longer
    ! The first step takes instantaneous changes, so that the second one has no rate to be compared with.
    if (flow%steps < 2) return
    deviation = 0.5_wp*maxval(abs(surface_of(flow) - ahead - flow%interval*rate))
    ratio = max(shorter, min(longer, 0.8_wp*sqrt(largest_error*flow%suction/max(deviation, tiny(1.0_wp)))))
  end function next_over_this

  !> Head in saturated ground, the height in dry ground, as linear suction is irrelevant. With a curve suction counts as
  !> far as it has an effect (nodes).
  pure function surface_of(flow) result(surface)
    type(seepage_type), intent(in) :: flow
    real(wp) :: surface(size(flow%head)), suction
    integer :: c, k

    surface = max(flow%head, flow%height)
    do c = 1, size(flow%curve)
      if (.not. flow%curve(c)%alpha > 0.0_wp) cycle
      do k = 1, size(flow%corner, 1)
        associate (i => flow%corner(k, c))
          suction = max(0.0_wp, flow%height(i) - flow%head(i))
          surface(i) = max(flow%head(i), flow%height(i)) - suction/(1.0_wp + flow%curve(c)%alpha*suction)
        end associate
      end do
    end do
  end function surface_of

  !> Prescribes the head at boundary nodes below their level; those above are seepage faces.
  pure subroutine set_levels(row, level, flow)
    integer, intent(in) :: row(:)
    !> Height of each level.
    real(wp), intent(in) :: level(:)
    type(seepage_type), intent(inout) :: flow
    integer :: i

    do i = 1, size(row)
      if (row(i) == 0) cycle
      if (level(row(i)) >= flow%height(i)) then
        flow%kind(i) = node_head
        flow%head(i) = level(row(i))
      else
        flow%kind(i) = node_face
      end if
    end do
  end subroutine set_levels
end module qsmpm_transient_seepage
