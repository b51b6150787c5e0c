!> Shares of terms that are not part of the physics: the measures by which a step is accepted or re-equilibrated, and
!> which are printed in the log and in curves.csv.
!>
!> The share of the proximal damping is its force relative to that of the load, |g|/|f_load|. The force g = G du of the
!> boundary stabilisation in the last solve of a step is not supported by the material; its share is the larger of
!>
!>   work    g . du / sum_i sum_c |f_c . du_i|
!>   force   max over nodes a of |g_a| / max over b of F_b,   F_b = sum_c |f_cb|
!>
!> over the solves i of the step and the cells c with their internal forces f_c; b runs over the nodes of two layers of
!> cells around a. There is no cancellation in the denominators, so that a slender body in bending, whose load is small
!> compared with its stresses, is assessed by its stresses. docs/methods/ghost.md
module qsmpm_term_share
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: any_of, joint_norm
  use qsmpm_node_graph, only: connectivity_type
  use qsmpm_owner_copies, only: owner_copies_type, copy_values
  use qsmpm_team, only: team_type, largest, total
  implicit none
  private

  public :: solve_share_type, step_share_type, share_of_load, share_of_cells, join_share, add_solves, &
    share_named, load_share_named, forces_around, quotient

  !> Columns of curves.csv used by step control.
  character(len=*), parameter, public :: damping_share = 'damping_share', stabilisation_share = 'stabilisation_share'

  !> Layers of cells around a node whose internal forces are the reference of its share: one cell of quadratic triangles
  !> at the tip of a toe has nearly no stress, two layers of any elements reach the next stressed cells.
  integer, parameter :: layers = 2
  !> Ratio to the largest internal force below which forces are close to rounding and not used as a reference.
  real(wp), parameter :: quiet = 1.0e-3_wp

  !> Results of a term in one solve.
  type :: solve_share_type
    character(len=:), allocatable :: name
    !> Share of the load, and whether the shares relative to the cells below apply instead.
    real(wp) :: load_share = 0.0_wp
    logical :: of_cells = .false.
    !> g . du, and sum_c |f_c . du|.
    real(wp) :: work = 0.0_wp
    real(wp) :: internal_work = 0.0_wp
    !> Largest share of the internal force around a node.
    real(wp) :: force_share = 0.0_wp
    !> Node of the largest share, 0 where it belongs to another process.
    integer :: node = 0
  end type solve_share_type

  !> Internal work of the solves of a step, and share of a term after the last one.
  type :: step_share_type
    character(len=:), allocatable :: name
    real(wp) :: internal_work = 0.0_wp
    real(wp) :: share = 0.0_wp
    !> Share of the work, which applies to the whole body.
    real(wp) :: work_share = 0.0_wp
  end type step_share_type

contains

  !> Returns a force relative to that of the load.
  pure type(solve_share_type) function share_of_load(name, force, load_norm) result(share)
    character(len=*), intent(in) :: name
    !> (components, nodes)
    real(wp), intent(in) :: force(:, :)
    real(wp), intent(in) :: load_norm

    share%name = name
    share%load_share = quotient(norm2(force), load_norm)
  end function share_of_load

  !> Returns a force relative to those of the cells. Processes of a team find the part of it at their owned nodes, all
  !> at once.
  function share_of_cells(name, force, displacement, connectivity, force_size, work_size, most, team, copies) &
    result(share)
    character(len=*), intent(in) :: name
    !> g, displacement of the solve, and F (components, nodes).
    real(wp), intent(in) :: force(:, :), displacement(:, :), force_size(:, :)
    !> Node lists of all cells and terms.
    type(connectivity_type), intent(in) :: connectivity
    !> sum_c |f_c . du|.
    real(wp), intent(in) :: work_size
    !> Largest F of all nodes.
    real(wp), intent(in) :: most
    type(team_type), intent(in) :: team
    !> Exchange of values at nodes of other processes.
    type(owner_copies_type), intent(in) :: copies
    type(solve_share_type) :: share
    real(wp) :: magnitude(size(displacement, 2)), shares(size(displacement, 2))

    share%name = name
    share%of_cells = .true.
    share%work = sum(force*displacement)
    share%internal_work = work_size
    magnitude = norm2(force, dim=1)
    if (.not. any_of(team, any(magnitude > 0.0_wp))) return
    shares = quotient(magnitude, forces_around(connectivity, norm2(force_size, dim=1), quiet*most, team, copies))
    share%force_share = maxval(shares)
    share%node = maxloc(shares, dim=1)
  end function share_of_cells

  !> Returns the largest F in the layers of cells around each owned node. All cells at an owned node are stored here;
  !> values around other nodes are known to their owners.
  function forces_around(connectivity, size_at, least, team, copies) result(around)
    type(connectivity_type), intent(in) :: connectivity
    !> F (nodes of the displacement, the first of all).
    real(wp), intent(in) :: size_at(:)
    !> Lower bound of F.
    real(wp), intent(in) :: least
    type(team_type), intent(in) :: team
    type(owner_copies_type), intent(in) :: copies
    real(wp) :: around(size(size_at)), inner(size(size_at)), table(1, size(size_at))
    integer :: k, layer

    around = max(size_at, least)
    do layer = 1, layers
      table(1, :) = around
      call copy_values(team, copies, table)
      inner = table(1, :)
      do k = 1, connectivity%count
        associate (nodes => connectivity%nodes(connectivity%first(k):connectivity%first(k + 1) - 1))
          if (maxval(nodes) > size(around)) cycle
          around(nodes) = max(around(nodes), maxval(inner(nodes)))
        end associate
      end do
    end do
  end function forces_around

  !> Combines the shares of a solve that the processes of a team have found at their owned nodes.
  subroutine join_share(team, share)
    type(team_type), intent(in) :: team
    type(solve_share_type), intent(inout) :: share
    real(wp) :: here

    if (team%ranks == 1) return
    here = share%force_share
    share%load_share = min(joint_norm(team, share%load_share), huge(1.0_wp))
    share%work = total(team, share%work)
    share%internal_work = total(team, share%internal_work)
    share%force_share = largest(team, share%force_share)
    if (here < share%force_share) share%node = 0
  end subroutine join_share

  !> Accumulates the shares of a solve in those of its step; the first solve initialises them.
  pure subroutine add_solves(solves, steps)
    type(solve_share_type), intent(in) :: solves(:)
    !> Shares in the same order.
    type(step_share_type), allocatable, intent(inout) :: steps(:)
    integer :: i

    if (.not. allocated(steps)) allocate (steps(size(solves)))
    do i = 1, size(solves)
      call add_solve(solves(i), steps(i))
    end do
  end subroutine add_solves

  !> Accumulates a solve in the sums of its step.
  pure subroutine add_solve(solve, step)
    type(solve_share_type), intent(in) :: solve
    type(step_share_type), intent(inout) :: step

    step%name = solve%name
    step%share = solve%load_share
    if (.not. solve%of_cells) return
    step%internal_work = step%internal_work + solve%internal_work
    step%work_share = quotient(solve%work, step%internal_work)
    step%share = step%work_share
    ! The larger one; a share that is not a number is retained.
    if (.not. solve%force_share <= step%share) step%share = solve%force_share
  end subroutine add_solve

  !> Returns the share of a given name; 0 if there is none.
  pure real(wp) function share_named(steps, name) result(share)
    type(step_share_type), allocatable, intent(in) :: steps(:)
    character(len=*), intent(in) :: name
    integer :: i

    share = 0.0_wp
    if (.not. allocated(steps)) return
    do i = 1, size(steps)
      if (steps(i)%name == name) share = steps(i)%share
    end do
  end function share_named

  !> Returns the share of the load in a solve, of a given name; 0 if there is none.
  pure real(wp) function load_share_named(solves, name) result(share)
    type(solve_share_type), intent(in) :: solves(:)
    character(len=*), intent(in) :: name
    integer :: i

    share = 0.0_wp
    do i = 1, size(solves)
      if (solves(i)%name == name) share = solves(i)%load_share
    end do
  end function load_share_named

  !> Returns the quotient of a part and a whole; huge if the whole is zero.
  elemental real(wp) function quotient(part, whole)
    real(wp), intent(in) :: part, whole

    quotient = merge(0.0_wp, huge(1.0_wp), part <= 0.0_wp)
    if (whole > 0.0_wp .and. part < whole*sqrt(huge(1.0_wp))) quotient = part/whole
  end function quotient
end module qsmpm_term_share
