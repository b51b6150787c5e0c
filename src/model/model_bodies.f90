!> Material points of a model: generates the points of the bodies on the mesh.
!>
!> The processes of a team that shares the model each count the points of an equal number of cells, divide the cells by
!> the counts of all processes, and generate the points in their box or ring and those of initially inactive bodies.
module qsmpm_model_bodies
  use, intrinsic :: iso_fortran_env, only: real32
  use qsmpm_kinds, only: wp, long
  use qsmpm_material_description, only: weight_at
  use qsmpm_named, only: place_named
  use qsmpm_agreement, only: agree
  use qsmpm_error, only: error_type
  use qsmpm_active_bodies, only: bodies_active, has_stages
  use qsmpm_analysis, only: axisymmetric, three_dimensional
  use qsmpm_method_description, only: basis_fem, basis_standard, basis_spline2, basis_spline3, integrate_points, &
    grid_degree
  use qsmpm_cell_boxes, only: box_owners_type, share_grid
  use qsmpm_cell_numbers, only: whole_cells
  use qsmpm_element_kinds, only: quad4, hex8, hex20, linear_kind, element_order
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_layer_interfaces, only: corners
  use qsmpm_model, only: model_type
  use qsmpm_model_mesh, only: grid_of
  use qsmpm_own_part, only: is_divided, own_of
  use qsmpm_points, only: allocate_points, carried_type, place_of
  use qsmpm_seed_table, only: seed_table_type, start_table, add_to_table, join_counts, held_by, holds_any, number_seeds
  use qsmpm_seeding, only: seed_list_type, seed_body, seed_even, seed_gauss, seed_fem
  use qsmpm_bodies_in_place, only: has_bodies_in_place, take_out_bodies
  use qsmpm_mesh_measure, only: cell_size, place_in_cell
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_polygon, only: polygon_area, polygon_centroid
  use qsmpm_polyhedron, only: polyhedron_volume, make_polyhedron
  use qsmpm_cell_share, only: cell_volumes
  use qsmpm_team, only: team_type, total
  use qsmpm_rounded_text, only: rounded_text, rounded_place
  use qsmpm_text, only: integer_text
  use qsmpm_body_description, only: body_type, body_box, body_polygon, body_region, body_polyhedron
  use qsmpm_mesh_description, only: mesh_fitted
  use qsmpm_polyhedron_check, only: polyhedron_problem
  use qsmpm_stl_reader, only: read_stl
  implicit none
  private

  public :: make_points, place_seeds, places_for, shape_of

  !> Cells may be filled beyond one by rounding only; a higher value means that bodies overlap, a lower one that a body
  !> ends in the cell.
  real(wp), parameter :: overfull = 1.0_wp + 1.0e-6_wp, cut = 1.0_wp - 1.0e-6_wp

  !> Fraction of a body outside the mesh above which a warning is issued.
  real(wp), parameter :: outside = 1.0e-3_wp
  !> Number of cells counted at a time.
  integer, parameter :: chunk = 16384

  !> Tolerance of a body-fitted cell, as a fraction of the cell, by which a body may miss the cell that contains it.
  real(wp), parameter :: moved = 0.4_wp

contains

  !> Generates the points of all bodies.
  subroutine make_points(model, table, diagnostics)
    !> In a team that shares the model, its part has team and ring.
    type(model_type), intent(inout) :: model
    !> Number of points of all bodies in the cells.
    type(seed_table_type), intent(out) :: table
    type(diagnostics_type), intent(inout) :: diagnostics
    logical, allocatable :: readable(:)
    integer :: b, known

    allocate (model%shapes(size(model%analysis%bodies)), readable(size(model%analysis%bodies)))
    do b = 1, size(model%analysis%bodies)
      known = diagnostics%count
      model%shapes(b) = shape_of(model, model%analysis%bodies(b), diagnostics)
      readable(b) = diagnostics%count == known
    end do
    call seed_bodies(model, readable, table, diagnostics)
    if (diagnostics%count == 0 .and. has_bodies_in_place(model%analysis)) call make_room(model, table, diagnostics)
    if (diagnostics%count > 0) return
    do b = 1, size(model%shapes)
      call report_outside(model, model%shapes(b), model%analysis%bodies(b)%name, model%analysis%bodies(b)%copies* &
        sum_of_body(model, model%state%points%volume, b))
    end do
    call check_overlap(model, table, diagnostics)
  end subroutine make_points

  !> Generates the points of all bodies from their shapes and finds the size of the cells that contain them.
  subroutine seed_bodies(model, readable, table, diagnostics)
    type(model_type), intent(inout) :: model
    !> Whether a body has a shape (bodies).
    logical, intent(in) :: readable(:)
    !> Number of points of all bodies in the cells.
    type(seed_table_type), intent(out) :: table
    type(diagnostics_type), intent(inout) :: diagnostics
    type(seed_list_type) :: list
    type(error_type), allocatable :: error
    integer :: b, c

    call start_table(table, model%mesh%cell_count, size(model%analysis%bodies))
    do b = 1, size(model%analysis%bodies)
      if (.not. readable(b)) cycle
      associate (body => model%analysis%bodies(b))
        call count_body(model, b, list, table, error)
        if (allocated(error)) then
          call add_diagnostic(diagnostics, body%where, '*BODY', error%message)
        else if (sum(table%points(:, b)) == 0) then
          call add_diagnostic(diagnostics, body%where, '*BODY', "body '"//body%name//"' lies outside the mesh")
        end if
      end associate
    end do
    if (diagnostics%count == 0 .and. is_divided(model%part)) call take_share(model, table, list, diagnostics)
    if (diagnostics%count > 0) return
    call points_from_seeds(model, list)
    if (is_divided(model%part)) call mark_points(model, table, list)
    model%cell_size = huge(1.0_wp)
    do c = 1, model%mesh%cell_count
      if (any(table%points(c, :) > 0)) model%cell_size = min(model%cell_size, cell_size(model%mesh, c))
    end do
  end subroutine seed_bodies

  !> Generates and counts the points of a body; a single process stores all of them, several processes only count them,
  !> each in a part of the cells.
  subroutine count_body(model, body, list, table, error)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    type(seed_list_type), intent(inout) :: list
    type(seed_table_type), intent(inout) :: table
    type(error_type), allocatable, intent(out) :: error
    integer :: begins(model%part%team%ranks + 1), first, last, before, c, r

    before = list%count
    if (.not. is_divided(model%part)) then
      call seed_cells(model, body, list, error)
      call add_to_table(list, before + 1, table)
      return
    end if
    associate (team => model%part%team)
      begins = [(1 + int(int(model%mesh%cell_count, long)*r/team%ranks), r=0, team%ranks)]
      last = begins(team%rank + 2) - 1
      do first = begins(team%rank + 1), last, chunk
        call seed_cells(model, body, list, error, [(c, c=first, min(first + chunk - 1, last))])
        if (allocated(error)) exit
        call add_to_table(list, 1, table)
        list%count = 0
      end do
      call agree(team, error)
      if (.not. allocated(error)) call join_counts(team, body, begins, table)
    end associate
  end subroutine count_body

  !> Generates the seeds of a body in some cells, or in all.
  subroutine seed_cells(model, body, list, error, cells)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    type(seed_list_type), intent(inout) :: list
    type(error_type), allocatable, intent(out) :: error
    integer, intent(in), optional :: cells(:)

    call seed_body(model%mesh, model%shapes(body), body, &
      model%analysis%bodies(body)%points_per_element, places_for(model), grid_degree(model%analysis%method%basis), &
      list, error, cells)
  end subroutine seed_cells

  !> Divides the cells among the processes of a team by the initially active points, and generates the points in the
  !> box and the ring of this process. Points of inactive bodies are stored by all processes.
  subroutine take_share(model, table, list, diagnostics)
    type(model_type), intent(inout) :: model
    type(seed_table_type), intent(in) :: table
    type(seed_list_type), intent(inout) :: list
    type(diagnostics_type), intent(inout) :: diagnostics
    type(error_type), allocatable :: error
    type(team_type) :: alone
    type(box_owners_type) :: boxes
    integer, allocatable :: held(:)
    integer :: number(model%mesh%cell_count), b, c
    logical :: short, near(model%mesh%cell_count)

    associate (part => model%part, bodies => model%analysis%bodies)
      number = whole_cells(model, [(c, c=1, size(number))])
      held = pack([(c, c=1, size(number))], holds_any(table, bodies%active))
      ! Every process has the complete table.
      call share_grid(alone, grid_of(model%analysis), number(held), [(sum(table%points(held(c), :), &
        mask=bodies%active), c=1, size(held))], part%team%ranks, boxes, short)
      if (short) then
        call add_diagnostic(diagnostics, bodies(size(bodies))%where, '*BODY', 'the material occupies too few cells '// &
          'of the mesh to be divided among '//integer_text(part%team%ranks)//' processes')
        return
      end if
      if (allocated(part%owners)) deallocate (part%owners)
      allocate (part%owners, source=boxes)
      near = part%owners%near(part%team%rank, part%ring, number)
      do b = 1, size(bodies)
        call seed_cells(model, b, list, error, pack([(c, c=1, size(number))], table%points(:, b) > 0 .and. &
          (near .or. .not. bodies(b)%active)))
      end do
    end associate
  end subroutine take_share

  !> Sets the global numbers of the points and marks the owned ones.
  subroutine mark_points(model, table, list)
    type(model_type), intent(inout) :: model
    type(seed_table_type), intent(in) :: table
    type(seed_list_type), intent(in) :: list

    associate (part => model%part, points => model%state%points)
      points%number = number_seeds(table, list)
      part%points = part%owners%near(part%team%rank, 0, whole_cells(model, points%cell(:points%count)))
      part%built_window = model%state%window
      part%built_points = sum(int(table%points, kind(part%built_points)))
    end associate
  end subroutine mark_points

  !> Generates the bodies again without the soil inside rigid bodies in place, and reports the removed soil.
  subroutine make_room(model, table, diagnostics)
    type(model_type), intent(inout) :: model
    type(seed_table_type), intent(out) :: table
    type(diagnostics_type), intent(inout) :: diagnostics
    real(wp) :: volume(size(model%shapes)), weight(size(model%shapes))
    integer :: b

    do b = 1, size(volume)
      volume(b) = sum_of_body(model, model%state%points%volume, b)
      weight(b) = sum_of_body(model, model%state%points%weight, b)
    end do
    call take_out_bodies(model, diagnostics)
    if (diagnostics%count > 0) return
    call seed_bodies(model, [(.true., b=1, size(volume))], table, diagnostics)
    if (diagnostics%count > 0) return
    do b = 1, size(volume)
      volume(b) = volume(b) - sum_of_body(model, model%state%points%volume, b)
      weight(b) = weight(b) - sum_of_body(model, model%state%points%weight, b)
      if (volume(b) > 0.0_wp) model%notes = model%notes//"body '"//model%analysis%bodies(b)%name//"': soil of "// &
        'volume '//rounded_text(volume(b))//' and weight '//rounded_text(weight(b))//' is removed where rigid '// &
        'bodies are in place'//new_line('a')
    end do
  end subroutine make_room

  !> Returns the sum over the points of a body, of all processes.
  real(wp) function sum_of_body(model, values, body)
    type(model_type), intent(in) :: model
    !> (points)
    real(wp), intent(in) :: values(:)
    integer, intent(in) :: body

    sum_of_body = total(model%part%team, sum(values, mask=model%state%points%body == body .and. &
      own_of(model%part%points, model%state%points%count)))
  end function sum_of_body

  !> Returns the arrangement of the points of full cells. In axisymmetry, if functions are evaluated at the point, its
  !> volume is that at its radius: only Gauss points integrate r grad N and N exactly (at the axis, midpoints of equal
  !> parts have an error of 11 % for a uniform stress).
  pure integer function places_for(model) result(places)
    type(model_type), intent(in) :: model

    places = seed_even
    if (model%analysis%model == axisymmetric .and. .not. model%space%domains) places = seed_gauss
    if (model%analysis%method%basis == basis_fem) places = seed_fem
  end function places_for

  !> Reports that a part of a body is outside the mesh.
  subroutine report_outside(model, shape, name, held)
    type(model_type), intent(inout) :: model
    type(body_shape_type), intent(in) :: shape
    character(len=*), intent(in) :: name
    !> Volume of its material points; of the scene if the model is reduced.
    real(wp), intent(in) :: held
    real(wp) :: drawn, high, low, middle(3)
    character(len=12) :: share

    drawn = held
    if (allocated(shape%solid)) then
      call polyhedron_volume(shape%solid%facets, drawn, middle)
    else if (allocated(shape%outline)) then
      drawn = polygon_area(shape%outline)
      middle(:2) = polygon_centroid(shape%outline)
      if (model%analysis%model == axisymmetric) drawn = drawn*middle(1)
      if (model%mesh%dimension == 3) then
        low = merge(model%mesh%bounds(3, 1), shape%low, shape%low <= -huge(1.0_wp))
        high = merge(model%mesh%bounds(3, 2), shape%high, shape%high >= huge(1.0_wp))
        drawn = drawn*(high - low)
      end if
    end if
    if (held > (1.0_wp - outside)*drawn) return
    write (share, '(f12.1)') 100.0_wp*(1.0_wp - held/drawn)
    model%notes = model%notes//"warning: body '"//name//"': "//trim(adjustl(share))// &
      ' % of it lies outside of the mesh'
    if (shape%slack > 0.0_wp) model%notes = model%notes//', or beyond a line nearer than a twentieth of a cell,'
    model%notes = model%notes//' and is left out'//new_line('a')
  end subroutine report_outside

  !> Creates material points from the seeds: unstressed, at their initial locations.
  subroutine points_from_seeds(model, list)
    type(model_type), intent(inout) :: model
    type(seed_list_type), intent(in) :: list
    integer :: p, states, m
    real(wp), allocatable :: zero(:)

    states = 0
    do m = 1, size(model%laws)
      states = max(states, model%laws(m)%law%state_count)
    end do
    call allocate_points(model%state%points, model%mesh%dimension, list%count, &
      merge(4, 6, model%mesh%dimension == 2), states)
    associate (points => model%state%points)
      call place_seeds(model, list, points)
      points%volume = list%volume(:list%count)
      points%initial_volume = points%volume
      points%body = list%body(:list%count)
      allocate (zero(size(points%stress, 1)), source=0.0_wp)
      do p = 1, points%count
        m = place_named(model%analysis%materials, model%analysis%bodies(points%body(p))%material)
        points%material(p) = m
        points%half_size(:, p) = list%vector(:, p)
        points%weight(p) = weight_at(model%analysis%materials(m), place_of(points, p))*points%volume(p)
        call model%laws(m)%law%start_at(zero, place_of(points, p), points%state(:model%laws(m)%law%state_count, p))
      end do
    end associate
  end subroutine points_from_seeds

  !> Sets cells, local coordinates and positions from seeds.
  pure subroutine place_seeds(model, list, carried)
    type(model_type), intent(in) :: model
    type(seed_list_type), intent(in) :: list
    !> Set of points located in the mesh.
    class(carried_type), intent(inout) :: carried
    integer :: i

    do i = 1, list%count
      carried%cell(i) = list%cell(i)
      carried%local(:, i) = list%local(:, i)
      carried%position(:, i) = place_in_cell(model%mesh, list%cell(i), list%local(:, i))
    end do
    carried%initial_position = carried%position
  end subroutine place_seeds

  !> Checks that no cell contains more than its volume at the start; partly filled cells are not valid for every
  !> method.
  subroutine check_overlap(model, table, diagnostics)
    !> The model, to which notes are added.
    type(model_type), intent(inout) :: model
    !> Number of points of all bodies in the cells, from the initial geometry.
    type(seed_table_type), intent(in) :: table
    type(diagnostics_type), intent(inout) :: diagnostics
    real(wp) :: volumes(model%mesh%cell_count), held(model%mesh%cell_count)
    character(len=:), allocatable :: text
    integer :: last, p

    call cell_volumes(model%mesh, volumes)
    last = size(model%analysis%bodies)
    held = held_by(table, model%analysis%bodies%active)
    text = overlap_text(model, table, model%analysis%bodies%active, held/volumes, '')
    if (len(text) > 0) call add_diagnostic(diagnostics, model%analysis%bodies(last)%where, '*BODY', text)
    if (any(held > 0.0_wp .and. held < cut*volumes)) call report_inexact(model)
    if (.not. has_stages(model%analysis)) return
    do p = 1, size(model%analysis%phases)
      associate (phase => model%analysis%phases(p), active => bodies_active(model%analysis, p))
        if (size(phase%activations) == 0) cycle
        text = overlap_text(model, table, active, held_by(table, active)/volumes, " in phase '"//phase%name//"'")
        if (len(text) > 0) call add_diagnostic(diagnostics, phase%activations(1)%where, '*ACTIVATE', text)
      end associate
    end do
  end subroutine check_overlap

  !> Returns which bodies overlap most, and where; empty if none overlap.
  pure function overlap_text(model, table, active, filled, when) result(text)
    type(model_type), intent(in) :: model
    type(seed_table_type), intent(in) :: table
    !> Whether each body is active (bodies); filled fraction of the cells (cells).
    logical, intent(in) :: active(:)
    real(wp), intent(in) :: filled(:)
    character(len=*), intent(in) :: when
    character(len=:), allocatable :: text
    real(wp) :: middle(model%mesh%dimension)
    integer :: cell, first, second, b

    text = ''
    if (all(filled <= overfull)) return
    cell = maxloc(filled, dim=1)
    first = maxloc(table%volume(cell, :), dim=1, mask=active)
    second = maxloc(table%volume(cell, :), dim=1, mask=active .and. table%volume(cell, :) > 0.0_wp .and. &
      [(b /= first, b=1, size(active))])
    associate (nodes => model%mesh%cell_nodes(model%mesh%cell_first(cell):model%mesh%cell_first(cell + 1) - 1))
      middle = sum(model%mesh%coordinates(:, nodes), dim=2)/size(nodes)
    end associate
    text = 'bodies '
    if (second > 0) text = "bodies '"//model%analysis%bodies(first)%name//"' and '"// &
      model%analysis%bodies(second)%name//"' "
    text = text//'overlap'//when//' around '//rounded_place(middle)//': an element contains '// &
      rounded_text(filled(cell), 3)//' times its volume; bodies must not overlap: define the larger one around '// &
      'the smaller'
  end function overlap_text

  !> Reports that the points do not integrate the functions of cut cells exactly; the figures are from a rotated block
  !> under uniform pressure (verification/cases/turned_block.toml).
  subroutine report_inexact(model)
    type(model_type), intent(inout) :: model
    character(len=:), allocatable :: share

    share = ''
    associate (method => model%analysis%method, kinds => model%mesh%cell_kind)
      if (method%basis == basis_standard .and. any(kinds == hex20)) share = '2 %'
      if (method%integration == integrate_points) then
        if (method%basis == basis_standard .and. any(element_order(kinds) > 1 .and. &
          (linear_kind(kinds) == quad4 .or. linear_kind(kinds) == hex8))) share = '5 %'
        if (method%basis == basis_spline2) share = '5 to 16 %'
        if (method%basis == basis_spline3) share = '15 %'
      end if
    end associate
    if (len(share) == 0) return
    model%notes = model%notes//'warning: a body boundary cuts elements, where this method does not reproduce a '// &
      'uniform stress: '//share//' error at the edge of a block turned in its grid; SPLINE2G and SPLINE3 with '// &
      'INTEGRATION=CELL, TRI6 and WEDGE15 do (docs/methods/bodies.md)'//new_line('a')
  end subroutine report_inexact

  !> Returns the boundary of a body in the form required to generate points.
  type(body_shape_type) function shape_of(model, body, diagnostics) result(shape)
    type(model_type), intent(in) :: model
    type(body_type), intent(in) :: body
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: s

    select case (body%kind)
    case (body_polygon, body_box)
      allocate (shape%outline, source=corners(body))
      if (body%kind == body_box .and. model%analysis%model == three_dimensional) then
        shape%low = body%box(3, 1)
        shape%high = body%box(3, 2)
      end if
    case (body_region)
      allocate (shape%region(model%mesh%cell_count), source=.false.)
      s = place_named(model%mesh%cell_sets, body%region)
      if (s > 0) then
        shape%region(model%mesh%cell_sets(s)%items) = .true.
      else
        call add_diagnostic(diagnostics, body%where, '*BODY', "there is no element set '"//body%region//"'")
      end if
    case (body_polyhedron)
      call read_solid(body, shape, diagnostics)
    end select
    if (model%analysis%mesh%kind == mesh_fitted .and. model%analysis%method%basis == basis_fem) shape%slack = moved
  end function shape_of

  !> Reads the polyhedron of a body from its file.
  subroutine read_solid(body, shape, diagnostics)
    type(body_type), intent(in) :: body
    !> Receives the polyhedron, without facets after an error.
    type(body_shape_type), intent(inout) :: shape
    type(diagnostics_type), intent(inout) :: diagnostics
    type(error_type), allocatable :: error
    real(wp), allocatable :: facets(:, :, :)
    character(len=:), allocatable :: problem

    allocate (shape%solid)
    allocate (shape%solid%facets(3, 3, 0))
    call read_stl(body%file, facets, error)
    if (allocated(error)) then
      call add_diagnostic(diagnostics, body%where, '*BODY', error%message)
      return
    end if
    problem = polyhedron_problem(facets)
    if (len(problem) > 0) then
      call add_diagnostic(diagnostics, body%where, '*BODY', body%file//': '//problem)
    else
      call make_polyhedron(facets, shape%solid)
      ! STL files have single precision, including ASCII files.
      shape%uncertainty = epsilon(1.0_real32)*maxval(abs(facets))
    end if
  end subroutine read_solid
end module qsmpm_model_bodies
