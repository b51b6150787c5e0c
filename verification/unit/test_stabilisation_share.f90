!> The share of the stabilisation on a chain of five nodes, by hand: a spring k between the first two nodes, cells
!> between neighbours, internal forces given.
module test_stabilisation_share
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use qsmpm_kinds, only: wp
  use qsmpm_node_graph, only: connectivity_type
  use qsmpm_owner_copies, only: owner_copies_type
  use qsmpm_penalty_matrices, only: penalty_matrices_type, add_penalty_force
  use qsmpm_team, only: team_type
  use qsmpm_term_share, only: solve_share_type, step_share_type, share_of_cells, add_solves
  use testing, only: tests_type
  implicit none
  private

  public :: collect_stabilisation_share

  !> A few sums.
  real(wp), parameter :: rounding = 1.0e-14_wp
  !> Spring; the end of the chain moves by one.
  real(wp), parameter :: spring = 0.5_wp

contains

  !> All checks.
  subroutine collect_stabilisation_share(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('stabilisation_share')
    call check_force(tests)
    call check_work(tests)
    call check_nothing(tests)
  end subroutine collect_stabilisation_share

  !> The force is judged by the largest internal force of two layers of cells, and not by what is further away
  !> unless all around is quiet.
  subroutine check_force(tests)
    type(tests_type), intent(inout) :: tests
    type(penalty_matrices_type) :: terms

    call make_spring(terms)
    call tests%close('two layers away counts', force_share(terms, [0.0_wp, 0.0_wp, 10.0_wp, 0.0_wp, 0.0_wp]), &
      spring/10.0_wp, rounding)
    call tests%close('the node with less around it counts', &
      force_share(terms, [0.0_wp, 0.0_wp, 10.0_wp, 100.0_wp, 0.0_wp]), spring/10.0_wp, rounding)
    call tests%close('all around quiet: a thousandth of the largest force', &
      force_share(terms, [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1000.0_wp]), spring, rounding)
    terms%matrix = 0.1_wp*terms%matrix
    call tests%close('a tenth of the stabilisation carries a tenth', &
      force_share(terms, [0.0_wp, 0.0_wp, 10.0_wp, 0.0_wp, 0.0_wp]), spring/100.0_wp, rounding)
  end subroutine check_force

  !> The work of the last solve refers to that of all solves of the step; the larger of both shares is taken.
  subroutine check_work(tests)
    type(tests_type), intent(inout) :: tests
    type(penalty_matrices_type) :: terms
    type(solve_share_type) :: solve
    type(step_share_type), allocatable :: step(:)

    call make_spring(terms)
    call measure(terms, 1.0_wp, [0.0_wp, 0.0_wp, 10.0_wp, 0.0_wp, 0.0_wp], 4.0_wp, solve)
    call add_solves([solve], step)
    call tests%close('work of the stabilisation over that of the cells', step(1)%share, spring/4.0_wp, rounding)
    solve%internal_work = 1.0_wp
    call add_solves([solve], step)
    call tests%close('the works of the cells add up over the step', step(1)%share, spring/5.0_wp, rounding)
    solve%internal_work = 1.0e3_wp
    call add_solves([solve], step)
    call tests%close('where the work is small the force counts', step(1)%share, spring/10.0_wp, rounding)
  end subroutine check_work

  !> Nothing carries nothing; a force where there is no other, or none that is a number, is beyond any bound.
  subroutine check_nothing(tests)
    type(tests_type), intent(inout) :: tests
    type(penalty_matrices_type) :: terms
    type(solve_share_type) :: solve
    type(step_share_type), allocatable :: step(:)

    call make_spring(terms)
    call measure(terms, 0.0_wp, spread(0.0_wp, 1, 5), 0.0_wp, solve)
    call add_solves([solve], step)
    call tests%check('no displacement, no share', step(1)%share <= 0.0_wp)
    call measure(terms, 1.0_wp, spread(0.0_wp, 1, 5), 0.0_wp, solve)
    call add_solves([solve], step)
    call tests%check('all of nothing', step(1)%share > 1.0_wp)
    call tests%put_off_traps()
    call measure(terms, ieee_value(1.0_wp, ieee_quiet_nan), spread(1.0_wp, 1, 5), 1.0_wp, solve)
    call add_solves([solve], step)
    call tests%check('not a number is no small share', .not. step(1)%share <= 1.0_wp)
    call tests%trap_again()
  end subroutine check_nothing

  !> Force share for internal forces at the nodes (5).
  real(wp) function force_share(terms, forces)
    type(penalty_matrices_type), intent(in) :: terms
    real(wp), intent(in) :: forces(5)
    type(solve_share_type) :: solve

    call measure(terms, 1.0_wp, forces, 1.0_wp, solve)
    force_share = solve%force_share
  end function force_share

  !> Measure a move of the first node.
  subroutine measure(terms, move, forces, work, solve)
    type(penalty_matrices_type), intent(in) :: terms
    real(wp), intent(in) :: move, forces(5), work
    type(solve_share_type), intent(out) :: solve
    type(connectivity_type) :: cells
    real(wp), dimension(2, 5) :: displacement, force, force_size

    cells = connectivity_type(4, [1, 3, 5, 7, 9], [1, 2, 2, 3, 3, 4, 4, 5])
    displacement = 0.0_wp
    displacement(1, 1) = move
    force_size = 0.0_wp
    force_size(2, :) = forces
    force = 0.0_wp
    call add_penalty_force(terms, displacement, force)
    solve = share_of_cells('share', force, displacement, cells, force_size, work, maxval(forces), &
      team_type(), owner_copies_type())
  end subroutine measure

  !> A spring between the first two nodes.
  subroutine make_spring(terms)
    type(penalty_matrices_type), intent(out) :: terms

    terms%connectivity = connectivity_type(1, [1, 3], [1, 2])
    allocate (terms%matrix(2, 2, 1))
    terms%matrix(:, :, 1) = spring*reshape([1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp], [2, 2])
  end subroutine make_spring
end module test_stabilisation_share
