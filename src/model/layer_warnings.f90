!> Warnings about layers before a run: interfaces that are not on grid lines, and bodies that are thin relative to
!> their cells, either weak ones or stiff ones in bending, which are rejected. Figures: docs/methods/bodies.md,
!> "Layers".
!>
!> Also warns of gaps between bodies, or within one, that a grid does not resolve: functions of the cells on either
!> side span the gap, so that forces are transmitted as if the sides were in contact. A body-fitted mesh resolves them.
module qsmpm_layer_warnings
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: body_materials
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_body_description, only: body_box, body_polygon
  use qsmpm_mesh_description, only: mesh_grid, mesh_fitted
  use qsmpm_method_description, only: basis_fem, grid_degree
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_layer_interfaces, only: fewest_cells, find_interfaces, interface_type, is_weak, measure_body, corners
  use qsmpm_material_description, only: may_yield
  use qsmpm_model, only: model_type
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_team, only: total
  use qsmpm_text, only: integer_text
  use qsmpm_polygon, only: polygon_area
  implicit none
  private

  public :: layer_notes, check_bending, gap_notes

  !> Relative error of the stress in cut cells above which a warning is issued: the limit of the scatter of a run.
  real(wp), parameter :: most_off = 0.13_wp
  !> Stiffness ratio to all bodies in contact above which a body bends independently. Standard deviation of the point
  !> positions, relative to the thickness, below which the points form one row across it; two rows have a quarter.
  !> Ratio of length to thickness from which a body bends.
  real(wp), parameter :: bends = 10.0_wp, one_row = 0.1_wp, slender = 3.0_wp

  !> Edge of a soil body, with the soil on its left.
  type :: edge_type
    integer :: body = 0
    real(wp) :: from(2) = 0.0_wp, to(2) = 0.0_wp
  end type edge_type

  !> Number of sample points along an edge, and how many of them must face another edge for a gap; fraction of a cell
  !> below which there is no gap, since manually defined bodies may not match exactly.
  integer, parameter :: places = 9, most = 3
  real(wp), parameter :: hair = 0.05_wp

contains

  !> Returns the warnings about layers for the log.
  pure function layer_notes(analysis) result(notes)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: notes
    type(interface_type), allocatable :: found(:)
    integer :: i, k
    logical, allocatable :: told(:)
    character(len=:), allocatable :: cut

    notes = ''
    call find_interfaces(analysis, found, contacts=.true.)
    if (size(found) == 0) return
    allocate (told(size(analysis%bodies)), source=.false.)
    do i = 1, size(found)
      cut = ''
      if (found(i)%axis == 0 .and. analysis%mesh%kind /= mesh_fitted) cut = cut_text(analysis, found(i))
      if (index(notes, cut) == 0) notes = notes//cut
      do k = 1, 2
        associate (body => found(i)%bodies(k), other => found(i)%bodies(3 - k))
          if (told(body) .or. .not. is_weak(analysis, found, body, other)) cycle
          told(body) = .true.
          notes = notes//thin_text(analysis, body, any(found%axis == 0 .and. any_body(found, body)))
        end associate
      end do
    end do
  end function layer_notes

  !> Returns whether an interface is one of a body.
  elemental logical function any_body(found, body)
    type(interface_type), intent(in) :: found
    integer, intent(in) :: body

    any_body = any(found%bodies == body)
  end function any_body

  !> Rejects bodies on a grid that bend and are one material point thick: the stresses left by a step have no moment,
  !> and the next step bends them again.
  subroutine check_bending(model, diagnostics)
    !> The model with its points.
    type(model_type), intent(in) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    type(interface_type), allocatable :: found(:)
    real(wp) :: normal(3), thick, long, cell, sums(0:2), along(model%state%points%count)
    integer :: number(size(model%analysis%bodies)), b

    if (model%analysis%mesh%kind /= mesh_grid .or. model%analysis%method%basis == basis_fem) return
    call find_interfaces(model%analysis, found, contacts=.true.)
    number = body_materials(model%analysis, 0)
    associate (points => model%state%points, bodies => model%analysis%bodies)
      do b = 1, size(bodies)
        if (number(b) == 0 .or. .not. any(bodies(b)%kind == [body_box, body_polygon])) cycle
        if (may_yield(model%analysis%materials(number(b))) .or. is_held(b)) cycle
        call measure_body(model%analysis, bodies(b), thick, long, cell, normal)
        if (.not. (thick < cell .and. long >= slender*thick)) cycle
        along = matmul(normal(:size(points%position, 1)), points%position(:, :points%count))
        associate (volume => merge(points%volume(:points%count), 0.0_wp, points%body(:points%count) == b))
          sums = total(model%part%team, [sum(volume), sum(volume*along), 0.0_wp])
          if (.not. sums(0) > 0.0_wp) cycle
          sums(2) = total(model%part%team, sum(volume*(along - sums(1)/sums(0))**2))
        end associate
        if (sqrt(sums(2)/sums(0)) < one_row*thick) call add_diagnostic(diagnostics, bodies(b)%where, '*BODY, NAME='// &
          bodies(b)%name, 'the body is '//rounded_text(thick/cell)//' cells and one row of material points thick: '// &
          'it cannot carry a bending moment from step to step, and its deflection would grow in each of them; '// &
          'cells of '// &
          rounded_text(thick)//' or smaller across it, or a body-fitted mesh (*GRID without ELEMENT), are required')
      end do
    end associate
  contains
    !> Returns whether a body touches another one of nearly the same stiffness or more.
    pure logical function is_held(body)
      integer, intent(in) :: body
      integer :: i, other

      is_held = .false.
      do i = 1, size(found)
        if (.not. any_body(found(i), body)) cycle
        other = number(sum(found(i)%bodies) - body)
        if (other > 0) is_held = is_held .or. model%analysis%materials(number(body))%young < &
          bends*model%analysis%materials(other)%young
      end do
    end function is_held
  end subroutine check_bending

  !> Returns the warning about an interface within cells. A cell has one strain: for a stiff part f the ratio of its
  !> stress to the correct value is r/(f r + 1 - f), reported for f = 1/2.
  pure function cut_text(analysis, between) result(text)
    type(analysis_type), intent(in) :: analysis
    type(interface_type), intent(in) :: between
    character(len=:), allocatable :: text
    real(wp) :: off

    text = ''
    off = (between%ratio - 1.0_wp)/(between%ratio + 1.0_wp)
    if (off <= most_off) return
    associate (bodies => analysis%bodies(between%bodies))
      text = "warning: bodies '"//bodies(1)%name//"' and '"//bodies(2)%name//"' share cells, and one is "// &
        rounded_text(between%ratio)//' times as stiff as the other: stresses in these cells are '// &
        'in error by '//integer_text(nint(100.0_wp*off))//' % and more; let grid lines, or element edges of a '// &
        'mesh, follow their interface'//new_line('a')
    end associate
  end function cut_text

  !> Returns the warning about a weak body that is few cells thick.
  pure function thin_text(analysis, b, cuts) result(text)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: b
    !> Whether it has an interface with another body within cells.
    logical, intent(in) :: cuts
    character(len=:), allocatable :: text, figures
    real(wp) :: thick, long, cell, normal(3)

    text = ''
    figures = 'by 24, 10 and 4 % along a weak seam of one, two and three cells'
    if (analysis%mesh%kind == mesh_fitted) then
      figures = 'by 2 % along a weak seam of one cell in a body-fitted mesh, by more along a thinner one'
    else if (cuts) then
      figures = 'by 56 and 22 % along a weak seam of one and two cells that is not parallel to grid lines'
    end if
    call measure_body(analysis, analysis%bodies(b), thick, long, cell, normal)
    if (.not. thick < (1.0_wp - 1.0e-6_wp)*fewest_cells*cell) return
    text = "warning: body '"//analysis%bodies(b)%name//"' is weaker than its neighbours and "// &
      rounded_text(thick/cell)//' cells thick: the cells beside it restrain failure along it, and limit loads '// &
      'and factors of safety are too high ('//figures//'); '// &
      'cells of '//rounded_text(thick/fewest_cells)//' or smaller across it are required'//new_line('a')
  end function thin_text

  !> Returns the warnings about gaps for the log.
  pure function gap_notes(analysis) result(notes)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: notes
    type(edge_type), allocatable :: edges(:)
    logical, allocatable :: is_said(:, :)
    real(wp) :: width, reach
    integer :: i, k, other, opposite(places)

    notes = ''
    if (analysis%mesh%kind /= mesh_grid .or. analysis%method%basis == basis_fem) return
    if (analysis%model == three_dimensional .or. .not. allocated(analysis%bodies)) return
    call list_edges(analysis, edges)
    allocate (is_said(size(analysis%bodies), size(analysis%bodies)), source=.false.)
    do i = 1, size(edges)
      reach = cells_across(analysis, edges(i))*max(1, grid_degree(analysis%method%basis))
      do k = 1, places
        call look_across(edges, i, real(k, wp)/(places + 1), reach, opposite(k), width)
      end do
      do k = 1, places
        other = opposite(k)
        if (other == 0 .or. count(opposite == other) < most) cycle
        if (is_said(edges(i)%body, other) .or. is_said(other, edges(i)%body)) cycle
        is_said(edges(i)%body, other) = .true.
        call look_across(edges, i, real(k, wp)/(places + 1), reach, other, width)
        notes = notes//sentence(analysis, edges(i)%body, other, width)
      end do
    end do
  end function gap_notes

  !> Returns the warning about a gap.
  pure function sentence(analysis, one, other, width) result(text)
    type(analysis_type), intent(in) :: analysis
    !> The two bodies; width of the gap.
    integer, intent(in) :: one, other
    real(wp), intent(in) :: width
    character(len=:), allocatable :: text

    associate (bodies => analysis%bodies)
      text = "bodies '"//bodies(one)%name//"' and '"//bodies(other)%name//"' are "//rounded_text(width)//' apart'
      if (one == other) text = "body '"//bodies(one)%name//"' has a gap of "//rounded_text(width)
    end associate
    text = 'warning: '//text//', which this grid cannot resolve: it transmits forces as if there were no gap; '// &
      'close the gap, take smaller cells, or a body-fitted mesh (*GRID without ELEMENT)'//new_line('a')
  end function sentence

  !> Lists the edges of all boxes and polygons, including those of bodies activated later.
  pure subroutine list_edges(analysis, edges)
    type(analysis_type), intent(in) :: analysis
    type(edge_type), allocatable, intent(out) :: edges(:)
    real(wp), allocatable :: at(:, :)
    integer :: b, i, n

    allocate (edges(0))
    do b = 1, size(analysis%bodies)
      if (all(analysis%bodies(b)%kind /= [body_box, body_polygon])) cycle
      at = corners(analysis%bodies(b))
      n = size(at, 2)
      if (polygon_area(at) < 0.0_wp) at = at(:, n:1:-1)
      do i = 1, n
        edges = [edges, edge_type(b, at(:, i), at(:, modulo(i, n) + 1))]
      end do
    end do
  end subroutine list_edges

  !> Returns the cell size along the normal of an edge, from the grid lines next to its midpoint.
  pure real(wp) function cells_across(analysis, edge) result(cell)
    type(analysis_type), intent(in) :: analysis
    type(edge_type), intent(in) :: edge
    real(wp) :: width(2), along(2), middle(2)
    integer :: d, k

    along = abs(edge%to - edge%from)/max(norm2(edge%to - edge%from), tiny(1.0_wp))
    middle = 0.5_wp*(edge%from + edge%to)
    do d = 1, 2
      associate (lines => analysis%mesh%axes(d)%lines)
        k = min(max(count(lines <= middle(d)), 1), size(lines) - 1)
        width(d) = lines(k + 1) - lines(k)
      end associate
    end do
    cell = dot_product(along([2, 1]), width)
  end function cells_across

  !> Finds the first body on the outward normal from a point of an edge; 0 if none is within reach or the edges touch.
  pure subroutine look_across(edges, number, share, reach, body, width)
    type(edge_type), intent(in) :: edges(:)
    !> Number of the edge; position on it as a fraction of its length.
    integer, intent(in) :: number
    real(wp), intent(in) :: share, reach
    integer, intent(out) :: body
    !> Distance to the body.
    real(wp), intent(out) :: width
    real(wp) :: from(2), out(2), along(2), facing, t, s
    integer :: i

    body = 0
    width = reach
    associate (edge => edges(number))
      along = edge%to - edge%from
      if (.not. norm2(along) > 0.0_wp) return
      out = [along(2), -along(1)]/norm2(along)
      from = edge%from + share*along
    end associate
    do i = 1, size(edges)
      along = edges(i)%to - edges(i)%from
      facing = along(1)*out(2) - along(2)*out(1)
      if (i == number .or. .not. abs(facing) > 0.5_wp*norm2(along)) cycle
      ! from + t out = its start + s along.
      associate (way => edges(i)%from - from)
        t = (along(1)*way(2) - along(2)*way(1))/facing
        s = (out(1)*way(2) - out(2)*way(1))/facing
      end associate
      if (s < 0.0_wp .or. s > 1.0_wp .or. t < -hair*reach .or. .not. t < width) cycle
      width = t
      body = merge(edges(i)%body, 0, facing > 0.0_wp .and. t > hair*reach)
    end do
  end subroutine look_across
end module qsmpm_layer_warnings
