!> Flow with a free surface in time: levels at the bounds move evenly from one to another, the surface of the water
!> follows as fast as the ground lets water go.
!>
!>   sum V n (S - S_0) + dt sum V k_r K grad h grad N = dt q                     backward Euler, qsmpm_seepage
!>
!> Steps are as long as their error allows: half of what the pressures differ by from those that the rates of the step
!> before would have brought. The first one is a thousandth of the time and takes what is there at once. A step whose
!> flow is not found is taken again, a quarter as long.
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

  !> Residual in heads over the height of the ground; by curves heads of dry ground hang on little water.
  real(wp), parameter :: tolerance = 1.0e-8_wp, tolerance_of_curve = 1.0e-9_wp
  !> Error of the pressures in a step over the width of suction, half a cell.
  real(wp), parameter :: largest_error = 0.02_wp
  !> First step over the time, and the shortest; the next over the last, at most, and what is left of a step at least.
  real(wp), parameter :: first = 1.0e-3_wp, shortest = 1.0e-8_wp, longer = 1.5_wp, shorter = 0.25_wp

contains

  !> Water that corners of cells take up when their ground fills, and the mean height of the cells of nodes, over which.
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

  !> Heads after a time, from those at its start.
  subroutine follow_seepage(flow, row, from, to, time, error)
    !> Its heads are those of the start; storage is given.
    type(seepage_type), intent(inout) :: flow
    !> Level that a node of the bounds has, 0 for none (nodes).
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

  !> Length of the next step over that of this one by its error; below a half where this one is too long.
  pure real(wp) function next_over_this(flow, ahead, rate) result(ratio)
    type(seepage_type), intent(in) :: flow
    !> What the step is judged by at its start, and its rates in the step before (nodes).
    real(wp), intent(in) :: ahead(:), rate(:)
    real(wp) :: deviation

    ratio = longer
    ! The first step takes what is there at once, so that the second one has no rate to be compared with.
    if (flow%steps < 2) return
    deviation = 0.5_wp*maxval(abs(surface_of(flow) - ahead - flow%interval*rate))
    ratio = max(shorter, min(longer, 0.8_wp*sqrt(largest_error*flow%suction/max(deviation, tiny(1.0_wp)))))
  end function next_over_this

  !> Head where there is water, the height where there is none: linear suction is no matter. By a curve it counts
  !> as far as it makes a difference (nodes).
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

  !> Below its level a node of the bounds has it as its head, above it water may leave.
  pure subroutine set_levels(row, level, flow)
    integer, intent(in) :: row(:)
    !> Height of each.
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
