!> Points of loaded surfaces on the present outlines of bodies, cut by the cells: they are generated again in every
!> attempt at a step where bodies are integrated inside their outlines (qsmpm_outlines). Each process of a team
!> generates those near its part, with the numbers that they have in a run on a single process.
module qsmpm_outline_surfaces
  use qsmpm_kinds, only: wp, long
  use qsmpm_active_bodies, only: has_stages
  use qsmpm_agreement, only: any_of
  use qsmpm_body_quadrature, only: body_quadrature_type
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_carried_outline, only: carried_outline_type, shape_of_outline
  use qsmpm_cell_numbers, only: whole_cells
  use qsmpm_error, only: error_type, fail, error_other
  use qsmpm_mesh, only: mesh_type
  use qsmpm_model, only: model_type
  use qsmpm_model_bodies, only: place_seeds
  use qsmpm_model_surfaces, only: surface_degree
  use qsmpm_outlines, only: measures
  use qsmpm_own_marks, only: mark_own_surface
  use qsmpm_own_part, only: own_cells
  use qsmpm_point_selection, only: keep_chosen, append_points
  use qsmpm_points, only: surface_points_type, allocate_surface_points, set_normals
  use qsmpm_ring_exchange, only: near_cells
  use qsmpm_seed_list, only: seed_list_type
  use qsmpm_seed_table, only: number_jointly
  use qsmpm_surface_seeding, only: seed_segment, seed_facets
  use qsmpm_team, only: largest
  implicit none
  private

  public :: lay_surfaces, seed_outlines, is_laid_anew

  !> Share of the size of a cell within which an edge touches it: larger than that used when points are seeded.
  real(wp), parameter :: touching = 0.02_wp

  type :: laid_type
    type(seed_list_type) :: list
    !> Outline, its part and the cell in which a seed was found, in the order in which seeds are generated (3, seeds).
    integer, allocatable :: key(:, :)
    !> Surface, body, and ratio of the area to the initial one (seeds).
    integer, allocatable :: surface(:), body(:)
    real(wp), allocatable :: stretch(:)
  end type laid_type

contains

  !> Generates the points of loaded surfaces on the present outlines, cut by the cells; called by all processes of a
  !> team.
  subroutine lay_surfaces(model, bodies, error)
    type(model_type), intent(inout) :: model
    type(body_quadrature_type), intent(in) :: bodies
    !> error_other: a process has not found a point that the owner of a cell has, or has surface points that nothing
    !> moves.
    type(error_type), allocatable, intent(out) :: error
    type(laid_type) :: laid
    integer, allocatable :: all_keys(:, :), chosen(:)
    integer(long), allocatable :: number(:)
    logical :: replaced(size(model%analysis%surfaces)), near(model%mesh%cell_count)
    integer :: i

    call find_seeds(model, bodies, laid)
    associate (list => laid%list, team => model%part%team, old => model%state%surface)
      allocate (number(list%count))
      call number_jointly(team, laid%key, own_cells(model%part, list%cell(:list%count)), number, all_keys)
      replaced = .false.
      do i = 1, size(all_keys, 2)
        replaced(surface_of(model, all_keys(:, i))) = .true.
      end do
      near = near_cells(model, model%part%ring - 1)
      chosen = pack([(i, i=1, list%count)], near(list%cell(:list%count)))
      if (any_of(team, any(number(chosen) == 0))) then
        call fail(error, error_other, 'the processes have found other points on the outline of a body')
      else if (any_of(team, model%state%points%count == 0 .and. .not. all(replaced(old%surface)))) then
        call fail(error, error_other, 'a surface has gone to where no material is near')
      end if
      if (allocated(error) .or. .not. any(replaced)) return
      number = number + nint(largest(team, real(maxval([0_long, old%number]), wp)), long)
    end associate
    call replace_points(model, laid, chosen, number(chosen), replaced)
    call mark_own_surface(model)
  end subroutine lay_surfaces

  !> Returns which surfaces may be generated again (surfaces of the deck).
  pure function is_laid_anew(model) result(is_so)
    type(model_type), intent(in) :: model
    logical :: is_so(size(model%analysis%surfaces))
    integer :: k

    is_so = .false.
    do k = 1, size(model%outlines)
      if (model%outlines(k)%integrates) is_so(model%outlines(k)%surface) = .true.
    end do
  end function is_laid_anew

  !> Finds the seeds on the loaded parts of the moving outlines.
  subroutine find_seeds(model, bodies, laid)
    type(model_type), intent(in) :: model
    type(body_quadrature_type), intent(in) :: bodies
    type(laid_type), intent(out) :: laid
    real(wp), allocatable :: now(:)
    integer, allocatable :: cell(:)
    integer :: k, i, from

    allocate (laid%key(3, 0), laid%surface(0), laid%body(0), laid%stretch(0))
    do k = 1, size(model%outlines)
      associate (outline => model%outlines(k), list => laid%list)
        if (size(outline%part) == 0 .or. .not. bodies%carried(outline%body)) cycle
        from = list%count + 1
        call seed_parts(model, bodies, outline, outline%part, list)
        now = measures(model, vertices_of(model, outline), outline%corner)
        cell = whole_cells(model, list%found_in(from:list%count))
        associate (part => list%body(from:list%count))
          laid%surface = [laid%surface, outline%surface(part)]
          laid%body = [laid%body, spread(merge(outline%body, 0, has_stages(model%analysis)), 1, size(part))]
          laid%stretch = [laid%stretch, now(outline%part(part))/outline%size(outline%part(part))]
          ! Edges are processed one by one, facets cell by cell.
          if (model%mesh%dimension == 2) then
            laid%key = reshape([laid%key, [(k, part(i), cell(i), i=1, size(part))]], [3, list%count])
          else
            laid%key = reshape([laid%key, [(k, cell(i), part(i), i=1, size(part))]], [3, list%count])
          end if
        end associate
      end associate
    end do
    if (.not. allocated(laid%list%cell)) allocate (laid%list%cell(0))
  end subroutine find_seeds

  !> Returns the surface of the deck to which the key of a seed belongs.
  pure integer function surface_of(model, key)
    type(model_type), intent(in) :: model
    !> (3)
    integer, intent(in) :: key(:)

    surface_of = model%outlines(key(1))%surface(key(merge(2, 3, model%mesh%dimension == 2)))
  end function surface_of

  !> Returns the present vertices of an outline.
  pure function vertices_of(model, outline) result(vertices)
    type(model_type), intent(in) :: model
    type(carried_outline_type), intent(in) :: outline
    real(wp) :: vertices(model%mesh%dimension, outline%count)

    vertices = model%state%tracers%position(:, outline%before + 1:outline%before + outline%count)
  end function vertices_of

  !> Finds the seeds on all outlines.
  subroutine seed_outlines(model, bodies, list)
    type(model_type), intent(in) :: model
    type(body_quadrature_type), intent(in) :: bodies
    type(seed_list_type), intent(out) :: list
    integer :: k, i

    do k = 1, size(model%outlines)
      associate (outline => model%outlines(k))
        if (bodies%carried(outline%body)) &
          call seed_parts(model, bodies, outline, [(i, i=1, size(outline%size))], list)
      end associate
    end do
  end subroutine seed_outlines

  !> Finds the seeds on parts of an outline; their `body` is the index in the list of parts.
  subroutine seed_parts(model, bodies, outline, parts, list)
    type(model_type), intent(in) :: model
    type(body_quadrature_type), intent(in) :: bodies
    type(carried_outline_type), intent(in) :: outline
    integer, intent(in) :: parts(:)
    type(seed_list_type), intent(inout) :: list
    type(body_shape_type) :: shape
    type(carried_outline_type) :: loaded
    real(wp) :: vertices(model%mesh%dimension, outline%count)
    real(wp), allocatable :: boxes(:, :)
    integer, allocatable :: near(:)
    logical :: occupied(model%mesh%cell_count)
    integer :: c, i

    occupied = [(any(bodies%body(bodies%first(c):bodies%first(c + 1) - 1) == outline%body), c=1, size(occupied))]
    vertices = vertices_of(model, outline)
    if (model%mesh%dimension == 3) then
      loaded%corner = outline%corner(:, parts)
      call shape_of_outline(loaded, vertices, shape)
      call seed_facets(model%mesh, occupied, shape%solid, shape%solid%low, shape%solid%high, surface_degree(model), &
        [(i, i=1, size(parts))], list)
      return
    end if
    call find_boxes(model%mesh, boxes)
    do i = 1, size(parts)
      associate (a => vertices(:, outline%corner(1, parts(i))), b => vertices(:, outline%corner(2, parts(i))))
        near = pack([(c, c=1, size(occupied))], boxes(1, :) <= max(a(1), b(1)) .and. boxes(2, :) <= max(a(2), b(2)) &
          .and. boxes(3, :) >= min(a(1), b(1)) .and. boxes(4, :) >= min(a(2), b(2)))
        call seed_segment(model%mesh, occupied, .true., [a, b], &
          surface_degree(model), i, list, near)
      end associate
    end do
  end subroutine seed_parts

  !> Finds boxes around the cells of a plane mesh and whatever touches them: a seed is searched in no other cell.
  pure subroutine find_boxes(mesh, boxes)
    type(mesh_type), intent(in) :: mesh
    !> x and y of the lower corner, then of the upper one (4, cell_count).
    real(wp), allocatable, intent(out) :: boxes(:, :)
    real(wp) :: slack
    integer :: c

    allocate (boxes(4, mesh%cell_count))
    do c = 1, mesh%cell_count
      associate (nodes => mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1))
        boxes(:2, c) = [minval(mesh%coordinates(1, nodes)), minval(mesh%coordinates(2, nodes))]
        boxes(3:, c) = [maxval(mesh%coordinates(1, nodes)), maxval(mesh%coordinates(2, nodes))]
      end associate
      slack = touching*maxval(boxes(3:, c) - boxes(:2, c))
      boxes(:, c) = boxes(:, c) + slack*[-1, -1, 1, 1]
    end do
  end subroutine find_boxes

  !> Replaces the points of surfaces by seeds.
  subroutine replace_points(model, laid, chosen, number, replaced)
    type(model_type), intent(inout) :: model
    type(laid_type), intent(in) :: laid
    !> Selected seeds, and their numbers.
    integer, intent(in) :: chosen(:)
    integer(long), intent(in) :: number(:)
    !> Surfaces whose points are replaced (surfaces of the deck).
    logical, intent(in) :: replaced(:)
    type(surface_points_type) :: new
    integer :: i

    associate (old => model%state%surface)
      call keep_chosen(old, pack([(i, i=1, old%count)], .not. replaced(old%surface)))
    end associate
    associate (list => laid%list)
      call allocate_surface_points(new, model%mesh%dimension, list%count)
      call place_seeds(model, list, new)
      new%surface = laid%surface
      new%body = laid%body
      if (list%count > 0) then
        new%area = list%volume(:list%count)/laid%stretch
        new%area_vector = list%vector(:, :list%count)
      end if
      call set_normals(new, [(.true., i=1, list%count)])
    end associate
    call keep_chosen(new, chosen)
    new%number = number
    call append_points(new, model%state%surface)
  end subroutine replace_points
end module qsmpm_outline_surfaces
