!> The method of a deck that names none: what docs/methods/choosing.md recommends for its grid and its materials.
!>
!>   unperturbed grid of QUAD4 or HEX8    SPLINE2G, CELL, 9 (27) points; FACTOR 0.005 where a material can yield
!>   the same with a moving mesh          SPLINE2, POINTS, 9 (27) points, FACTOR 5e-4
!>   every other mesh                     STANDARD, CELL
!>
!> What the deck says itself stays. Programs that build an analysis without a deck name their method.
module qsmpm_recommended_method
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type, method_type, basis_auto, basis_standard, basis_spline2, &
    basis_spline2g, integrate_points, integrate_cells, mesh_grid, stabilise_background, stabilise_ghost, &
    three_dimensional
  use qsmpm_material_traits, only: may_yield
  implicit none
  private

  public :: undecided_method, decide_method

  !> Marks of what a deck leaves open.
  integer, parameter :: open_integration = 0, open_stabilisation = -1
  !> Strength of the ghost penalty for plastic flow, and for a body that is pushed by a moving mesh (ghost.md).
  real(wp), parameter :: factor_of_flow = 5.0e-3_wp, factor_of_push = 5.0e-4_wp
  !> Points of a cell that the second moments of quadratic functions need, in the plane and in space.
  integer, parameter :: points_in_plane = 9, points_in_space = 27

contains

  !> A method of which nothing is decided but the kinematics.
  pure function undecided_method() result(method)
    type(method_type) :: method

    method%basis = basis_auto
    method%integration = open_integration
    method%stabilisation = open_stabilisation
  end function undecided_method

  !> Decide what is open, and say in `method_reason` what and why where the basis was.
  pure subroutine decide_method(analysis)
    !> The analysis, read to its end.
    type(analysis_type), intent(inout) :: analysis

    if (analysis%method%basis /= basis_auto) return
    if (analysis%mesh%kind == mesh_grid .and. is_spline_grid(analysis)) then
      call decide_splines(analysis)
    else
      call take(analysis%method, basis_standard, integrate_cells, stabilise_background, &
        analysis%method%stabilisation_factor)
      analysis%method_reason = 'BASIS=STANDARD, INTEGRATION=CELL (averaged functions and splines need a *GRID '// &
        'of QUAD4 or HEX8 that is not perturbed)'
    end if
  end subroutine decide_method

  !> Splines on a grid.
  pure subroutine decide_splines(analysis)
    type(analysis_type), intent(inout) :: analysis
    integer :: b

    if (analysis%moving_mesh%active) then
      call take(analysis%method, basis_spline2, integrate_points, stabilise_ghost, factor_of_push)
      analysis%method_reason = 'BASIS=SPLINE2, INTEGRATION=POINTS, FACTOR=5E-4 (the grid moves)'
    else if (any(may_yield(analysis%materials))) then
      call take(analysis%method, basis_spline2g, integrate_cells, stabilise_ghost, factor_of_flow)
      analysis%method_reason = 'BASIS=SPLINE2G, INTEGRATION=CELL, FACTOR=0.005 (a grid, and a material '// &
        'can yield)'
    else
      call take(analysis%method, basis_spline2g, integrate_cells, stabilise_ghost, &
        analysis%method%stabilisation_factor)
      analysis%method_reason = 'BASIS=SPLINE2G, INTEGRATION=CELL (a grid, elastic materials)'
    end if
    do b = 1, size(analysis%bodies)
      if (analysis%bodies(b)%points_per_element == 0) analysis%bodies(b)%points_per_element = &
        merge(points_in_space, points_in_plane, analysis%model == three_dimensional)
    end do
  end subroutine decide_splines

  !> Fill in what is open.
  pure subroutine take(method, basis, integration, stabilisation, factor)
    type(method_type), intent(inout) :: method
    integer, intent(in) :: basis, integration, stabilisation
    !> Negative for the usual one of the stabilisation.
    real(wp), intent(in) :: factor

    method%basis = basis
    if (method%integration == open_integration) method%integration = integration
    if (method%stabilisation == open_stabilisation) then
      method%stabilisation = stabilisation
      if (method%stabilisation_factor < 0.0_wp) method%stabilisation_factor = factor
    end if
  end subroutine take

  !> Whether the mesh is a grid along the axes whose cells are boxes.
  pure logical function is_spline_grid(analysis)
    type(analysis_type), intent(in) :: analysis

    is_spline_grid = .false.
    if (.not. allocated(analysis%mesh%element)) return
    is_spline_grid = (analysis%mesh%element == 'QUAD4' .or. analysis%mesh%element == 'HEX8') &
      .and. .not. analysis%mesh%perturbation > 0.0_wp
  end function is_spline_grid
end module qsmpm_recommended_method
