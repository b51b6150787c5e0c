!> Selects the method of a deck that defines none, as recommended in docs/methods/choosing.md for its grid and
!> materials.
!>
!>   unperturbed grid of QUAD4 or HEX8    SPLINE2G, CELL, 9 (27) points; FACTOR 0.001 where a material can yield
!>   the same with a moving mesh          SPLINE2, POINTS, 9 (27) points, FACTOR 5e-4
!>   triangles that conform to outlines   FEM, 3 points per TRI6, if no body is moved through them or has its initial
!>                                        shape when activated; replaced by the first on the grid when too distorted
!>   every other mesh                     STANDARD, CELL
!>   the first with stiff bodies on lines STANDARD, CELL
!>
!> A body about a hundred times as stiff as the softest one, such as a concrete wall in soil, is a layer that splines
!> over the adjacent cells cannot represent: next to such a body that fills whole cells runs stop (stiff_bodies.toml),
!> whereas cells with their edges on its boundary have no such difficulty. If it ends inside cells, splines are still
!> the better choice.
!>
!> Settings of the deck are not changed. Programs that build an analysis without a deck specify their method.
module qsmpm_recommended_method
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_active_bodies, only: leaves_cells
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_body_description, only: body_type, body_box, body_polygon
  use qsmpm_mesh_description, only: holds_corner, mesh_fitted, mesh_grid, select_list
  use qsmpm_phase_loads, only: has_consolidation
  use qsmpm_method_description, only: background_type, method_type, basis_auto, basis_fem, basis_standard, &
    basis_spline2, basis_spline2g, integrate_points, integrate_cells, stabilise_background, stabilise_ghost, &
    stabilise_none
  use qsmpm_element, only: allowed_counts, tri6
  use qsmpm_interface_lines, only: follow_interfaces
  use qsmpm_layer_interfaces, only: moduli, thin_seam
  use qsmpm_material_description, only: may_yield
  implicit none
  private

  public :: undecided_method, decide_mesh, decide_method, stiff_body

  !> Values of settings not given in a deck.
  integer, parameter :: open_integration = 0, open_stabilisation = -1
  !> Ghost penalty factor for plastic flow, and for a body that is pushed by a moving mesh (ghost.md).
  real(wp), parameter :: factor_of_flow = 1.0e-3_wp, factor_of_push = 5.0e-4_wp
  !> Number of points per cell required by the second moments of quadratic functions, in plane and 3D models; number of
  !> points that integrate a quadratic triangle that moves with the material.
  integer, parameter :: points_in_plane = 9, points_in_space = 27, points_in_triangle = 3
  !> Minimum ratio of Young's modulus to the least one of the deck for a stiff body; tolerance of a coordinate on a
  !> grid line, as a fraction of the length.
  real(wp), parameter :: stiff = 30.0_wp, on_line = 1.0e-6_wp

contains

  !> Returns a method in which only the kinematics is set.
  pure type(method_type) function undecided_method() result(method)

    method%basis = basis_auto
    method%integration = open_integration
    method%stabilisation = open_stabilisation
  end function undecided_method

  !> Selects the element of a *GRID without ELEMENT.
  pure subroutine decide_mesh(analysis, points)
    type(analysis_type), intent(inout) :: analysis
    !> Points per cell given by *POINTS, 0 for the default number (*POINTS keywords).
    integer, intent(in) :: points(:)

    if (analysis%mesh%kind /= mesh_grid .or. .not. allocated(analysis%mesh%element)) return
    if (len(analysis%mesh%element) > 0) return
    if (analysis%model == three_dimensional) then
      analysis%mesh%element = 'HEX8'
    else if (is_to_be_fitted(analysis, points)) then
      analysis%mesh%element = 'TRI6'
      analysis%mesh%kind = mesh_fitted
    else
      analysis%mesh%element = 'QUAD4'
    end if
    if (analysis%mesh%kind == mesh_grid .and. analysis%method%basis == basis_auto .and. .not. &
      analysis%moving_mesh%active) call follow_interfaces(analysis, analysis%mesh%moved_lines)
  end subroutine decide_mesh

  !> Returns whether a body-fitted mesh is the better background: soil that can fail, layers, or outlines that are not
  !> on grid lines, and no feature that requires a grid.
  pure logical function is_to_be_fitted(analysis, points) result(fits)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: points(:)
    integer :: b, i

    fits = any(analysis%method%basis == [basis_auto, basis_fem]) .and. allocated(analysis%bodies) .and. &
      allocated(analysis%materials) .and. .not. leaves_its_cells(analysis)
    if (fits) fits = size(analysis%bodies) > 0 .and. size(analysis%materials) > 0 .and. &
      .not. analysis%mesh%perturbation > 0.0_wp .and. all([(any(points(i) == [0, allowed_counts(tri6)]), &
      i=1, size(points))])
    if (fits .and. allocated(analysis%element_sets)) fits = size(analysis%element_sets) == 0
    if (fits .and. allocated(analysis%node_sets)) fits = all(analysis%node_sets%selection /= select_list)
    if (.not. fits) return
    fits = all(analysis%bodies%kind == body_box .or. analysis%bodies%kind == body_polygon)
    if (allocated(analysis%mesh%refined) .or. has_consolidation(analysis%phases)) return
    if (any(may_yield(analysis%materials)) .or. size(analysis%materials) > 1) return
    fits = fits .and. .not. all([(ends_on_lines(analysis, b), b=1, size(analysis%bodies))])
  end function is_to_be_fitted

  !> Selects the settings that are not given, and describes the selected basis and the reason in `method_reason`.
  pure subroutine decide_method(analysis)
    !> The analysis after the deck has been read completely.
    type(analysis_type), intent(inout) :: analysis

    if (analysis%method%basis == basis_fem) call prepare_grid(analysis)
    if (analysis%method%basis /= basis_auto) return
    call decide_basis(analysis)
    if (allocated(analysis%mesh%moved_lines)) analysis%method_reason = analysis%method_reason//analysis%mesh%moved_lines
  end subroutine decide_method

  !> Selects basis, integration and stabilisation.
  pure subroutine decide_basis(analysis)
    type(analysis_type), intent(inout) :: analysis
    integer :: b

    b = stiff_body(analysis)
    if (analysis%mesh%kind == mesh_grid .and. is_spline_grid(analysis)) then
      if (b > 0 .and. .not. analysis%moving_mesh%active) then
        if (ends_on_lines(analysis, b)) then
          call take(analysis%method, basis_standard, integrate_cells, stabilise_background, &
            analysis%method%stabilisation_factor)
          analysis%method_reason = "BASIS=STANDARD, INTEGRATION=CELL (body '"//analysis%bodies(b)%name// &
            "' is so much stiffer than the softest one that splines fail beside it)"
          return
        end if
      end if
      call decide_splines(analysis)
      if (b > 0) analysis%method_reason = analysis%method_reason//"; body '"//analysis%bodies(b)%name//"' is much "// &
        'stiffer than the softest one: BASIS=STANDARD is more accurate, and is chosen where it ends on grid lines'
    else if (analysis%mesh%kind == mesh_fitted .and. .not. leaves_its_cells(analysis)) then
      call take(analysis%method, basis_fem, integrate_points, stabilise_none, analysis%method%stabilisation_factor)
      call prepare_grid(analysis)
      if (analysis%mesh%element == 'TRI6') call seed(analysis%bodies, points_in_triangle)
      analysis%method_reason = 'BASIS=FEM, body-fitted '//analysis%mesh%element//' mesh that moves with the material'
      if (allocated(analysis%backgrounds)) analysis%method_reason = analysis%method_reason// &
        '; when elements become too distorted the run continues with splines on the background grid'
      b = thin_seam(analysis)
      if (b > 0) analysis%method_reason = analysis%method_reason// &
        "; the run ends when elements become too distorted, because body '"//analysis%bodies(b)%name// &
        "' is weaker than its neighbours and too thin for the background grid"
      if (len(lost_set(analysis)) > 0) analysis%method_reason = analysis%method_reason// &
        "; the run ends when elements become too distorted, because nodes of set '"//lost_set(analysis)// &
        "' do not exist on the background grid"
    else
      call take(analysis%method, basis_standard, integrate_cells, stabilise_background, &
        analysis%method%stabilisation_factor)
      analysis%method_reason = 'BASIS=STANDARD, INTEGRATION=CELL (GIMP and splines require a *GRID '// &
        'of QUAD4 or HEX8 without PERTURB)'
      if (analysis%mesh%kind == mesh_fitted) analysis%method_reason = 'BASIS=STANDARD, INTEGRATION=CELL (triangles '// &
        'that conform to the outlines, with bodies that are activated in their drawn shape or again, or rigid bodies)'
    end if
  end subroutine decide_basis

  !> Prepares the spline grid that replaces triangles that are too distorted, unless nodes not on the grid have
  !> prescribed displacements, or a weak seam is too thin for the grid and would be supported by the adjacent material
  !> in its cells.
  pure subroutine prepare_grid(analysis)
    type(analysis_type), intent(inout) :: analysis
    type(analysis_type) :: grid

    if (analysis%mesh%kind /= mesh_fitted .or. .not. (analysis%mesh%refits .and. allocated(analysis%phases))) return
    if (leaves_its_cells(analysis) .or. has_consolidation(analysis%phases)) return
    if (thin_seam(analysis) > 0 .or. len(lost_set(analysis)) > 0) return
    grid = analysis
    grid%mesh%kind = mesh_grid
    grid%mesh%element = 'QUAD4'
    grid%method%integration = open_integration
    grid%method%stabilisation = open_stabilisation
    grid%method%stabilisation_factor = factor_of_flow
    call decide_splines(grid)
    allocate (analysis%backgrounds(2))
    call note_background(analysis, analysis%backgrounds(1))
    call note_background(grid, analysis%backgrounds(2))
  end subroutine prepare_grid

  !> Returns the first set without equivalent on the grid: with prescribed displacements, or fixed and not on grid
  !> lines; otherwise empty.
  pure function lost_set(analysis) result(name)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: name
    integer :: p, i

    name = ''
    if (.not. (allocated(analysis%phases) .and. allocated(analysis%node_sets))) return
    ! The grid of a deck with errors may have no lines.
    if (.not. (allocated(analysis%mesh%axes(1)%lines) .and. allocated(analysis%mesh%axes(2)%lines))) return
    do p = 1, size(analysis%phases)
      associate (phase => analysis%phases(p))
        do i = 1, size(phase%prescriptions)
          name = phase%prescriptions(i)%set
          if (abs(phase%prescriptions(i)%value) > 0.0_wp .or. is_off(name)) return
        end do
        do i = 1, size(phase%fixities)
          name = phase%fixities(i)%set
          if (any(phase%fixities(i)%fixed) .and. is_off(name)) return
        end do
      end associate
    end do
    name = ''

  contains

    !> Returns whether no corner of the grid is in a set.
    pure logical function is_off(name)
      character(len=*), intent(in) :: name
      integer :: s

      s = place_named(analysis%node_sets, name)
      is_off = s > 0
      associate (axes => analysis%mesh%axes(:2))
        if (is_off) is_off = .not. holds_corner(analysis%node_sets(s), axes, on_line*maxval(axes(1)%lines(2:) - &
          axes(1)%lines(:size(axes(1)%lines) - 1)))
      end associate
    end function is_off
  end function lost_set

  !> Stores the current mesh and method of an analysis.
  pure subroutine note_background(analysis, background)
    type(analysis_type), intent(in) :: analysis
    type(background_type), intent(inout) :: background

    background%kind = analysis%mesh%kind
    background%element = analysis%mesh%element
    background%method = analysis%method
  end subroutine note_background

  !> Returns whether a mesh that moves with the material cannot be used: an activated body does not fill its cells, or
  !> rigid bodies are moved where no pore water flows.
  pure logical function leaves_its_cells(analysis) result(leaves)
    type(analysis_type), intent(in) :: analysis
    integer :: p

    leaves = analysis%moving_mesh%active
    if (allocated(analysis%rigid_bodies)) leaves = leaves .or. size(analysis%rigid_bodies) > 0 .and. .not. &
      has_consolidation(analysis%phases)
    if (allocated(analysis%phases)) leaves = leaves .or. any([(leaves_cells(analysis, p), p=1, size(analysis%phases))])
  end function leaves_its_cells

  !> Selects splines on a grid.
  pure subroutine decide_splines(analysis)
    type(analysis_type), intent(inout) :: analysis

    if (analysis%moving_mesh%active) then
      call take(analysis%method, basis_spline2, integrate_points, stabilise_ghost, factor_of_push)
      analysis%method_reason = 'BASIS=SPLINE2, INTEGRATION=POINTS, FACTOR=5E-4 (the grid moves)'
    else if (any(may_yield(analysis%materials))) then
      call take(analysis%method, basis_spline2g, integrate_cells, stabilise_ghost, factor_of_flow)
      analysis%method_reason = 'BASIS=SPLINE2G, INTEGRATION=CELL, FACTOR=0.001 (a grid, and a material '// &
        'can yield)'
    else
      call take(analysis%method, basis_spline2g, integrate_cells, stabilise_ghost, &
        analysis%method%stabilisation_factor)
      analysis%method_reason = 'BASIS=SPLINE2G, INTEGRATION=CELL (a grid, elastic materials)'
    end if
    call seed(analysis%bodies, merge(points_in_space, points_in_plane, analysis%model == three_dimensional))
  end subroutine decide_splines

  !> Sets the number of points per cell for bodies for which none is given.
  pure subroutine seed(bodies, points)
    type(body_type), intent(inout) :: bodies(:)
    integer, intent(in) :: points

    where (bodies%points_per_element == 0) bodies%points_per_element = points
  end subroutine seed

  !> Returns the first body that is much stiffer than the softest material of the deck, with its initial material or a
  !> later one; 0 for none. The moduli of soil laws and user models are unknown.
  pure integer function stiff_body(analysis) result(b)
    type(analysis_type), intent(in) :: analysis
    real(wp), allocatable :: young(:, :)

    b = 0
    if (.not. (allocated(analysis%materials) .and. allocated(analysis%bodies) .and. allocated(analysis%phases))) return
    call moduli(analysis, young)
    associate (least => minval(analysis%materials%young, mask=analysis%materials%young > 0.0_wp))
      b = findloc(any(young/stiff >= least, dim=2), .true., dim=1)
    end associate
  end function stiff_body

  !> Returns whether the boundary of a body is on grid lines: a box, or a polygon of such edges.
  pure logical function ends_on_lines(analysis, b) result(ends)
    type(analysis_type), intent(in) :: analysis
    !> Number of the body.
    integer, intent(in) :: b
    integer :: d, i, n, next

    ends = .false.
    ! The grid of a deck with errors may have no lines.
    do d = 1, merge(3, 2, analysis%model == three_dimensional)
      if (.not. allocated(analysis%mesh%axes(d)%lines)) return
    end do
    associate (body => analysis%bodies(b), axes => analysis%mesh%axes)
      if (body%kind == body_box) then
        ends = all([(is_line(axes(d)%lines, body%box(d, 1)) .and. is_line(axes(d)%lines, body%box(d, 2)), d=1, &
          merge(3, 2, analysis%model == three_dimensional))])
      else if (body%kind == body_polygon) then
        n = size(body%polygon, 2)
        ends = .true.
        do i = 1, n
          next = modulo(i, n) + 1
          ends = ends .and. is_line(axes(1)%lines, body%polygon(1, i)) .and. is_line(axes(2)%lines, &
            body%polygon(2, i)) .and. any(abs(body%polygon(:, i) - body%polygon(:, next)) <= 0.0_wp)
        end do
      end if
    end associate
  end function ends_on_lines

  !> Returns whether a coordinate is on one of the lines of an axis, or outside the grid.
  pure logical function is_line(lines, x)
    real(wp), intent(in) :: lines(:)
    real(wp), intent(in) :: x

    associate (near => on_line*(lines(size(lines)) - lines(1)))
      is_line = any(abs(lines - x) <= near) .or. x < lines(1) .or. x > lines(size(lines))
    end associate
  end function is_line

  !> Sets values that are not given.
  pure subroutine take(method, basis, integration, stabilisation, factor)
    type(method_type), intent(inout) :: method
    integer, intent(in) :: basis, integration, stabilisation
    !> Negative for the default of the stabilisation.
    real(wp), intent(in) :: factor

    method%basis = basis
    if (method%integration == open_integration) method%integration = integration
    if (method%stabilisation == open_stabilisation) then
      method%stabilisation = stabilisation
      if (method%stabilisation_factor < 0.0_wp) method%stabilisation_factor = factor
    end if
  end subroutine take

  !> Returns whether the mesh is an axis-parallel grid with rectangular cells.
  pure logical function is_spline_grid(analysis)
    type(analysis_type), intent(in) :: analysis

    is_spline_grid = .false.
    if (.not. allocated(analysis%mesh%element)) return
    is_spline_grid = (analysis%mesh%element == 'QUAD4' .or. analysis%mesh%element == 'HEX8') &
      .and. .not. analysis%mesh%perturbation > 0.0_wp
  end function is_spline_grid
end module qsmpm_recommended_method
