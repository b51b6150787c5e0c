!> Surface points of a model: the surfaces of the deck on the mesh and on the boundaries of bodies.
module qsmpm_model_surfaces
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_load_description, only: support_normal
  use qsmpm_mesh_description, only: surface_type, select_box, select_segment, select_mesh, select_outline
  use qsmpm_method_description, only: grid_degree
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_model, only: model_type
  use qsmpm_model_bodies, only: place_seeds, shape_of
  use qsmpm_own_marks, only: nearest_numbers
  use qsmpm_own_part, only: is_divided
  use qsmpm_points, only: allocate_surface_points, set_normals
  use qsmpm_seed_list, only: seed_list_type
  use qsmpm_seed_table, only: seed_table_type, holds_any
  use qsmpm_surface_seeding, only: seed_faces, seed_segment
  use qsmpm_outline_seeding, only: seed_outline
  use qsmpm_polygon, only: polygon_contains
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_text, only: integer_text
  use qsmpm_mesh_sets, only: faces_in_box, cuts_faces, set_tolerance
  use qsmpm_point_bins, only: point_bins_type, make_bins, nearest_in_bins
  implicit none
  private

  public :: make_surfaces, choose_carrying_points, surface_degree, outline_box

  !> Largest difference of the normals of a plane surface.
  real(wp), parameter :: plane_tolerance = 1.0e-6_wp

contains

  !> Creates the surface points of all surfaces, and selects the material points that carry tractions in the method of
  !> the paper.
  subroutine make_surfaces(model, table, diagnostics)
    type(model_type), intent(inout) :: model
    !> Parts of the cells in the bodies.
    type(seed_table_type), intent(in) :: table
    type(diagnostics_type), intent(inout) :: diagnostics
    type(seed_list_type) :: list
    logical :: occupied(model%mesh%cell_count)
    integer :: s, k, before

    occupied = holds_any(table, model%analysis%bodies%active)
    do s = 1, size(model%analysis%surfaces)
      associate (surface => model%analysis%surfaces(s))
        if (surface%selection == select_segment .and. model%mesh%dimension == 3) then
          call add_diagnostic(diagnostics, surface%where, '*SURFACE', 'TYPE=SEGMENT is for plane models')
          cycle
        end if
        if (surface%selection == select_segment) call check_sides(model, surface, diagnostics)
        before = list%count
        call seed_surface(model, table, surface, s, occupied, list)
        if (list%count == before) call add_diagnostic(diagnostics, surface%where, '*SURFACE', &
          "surface '"//surface%name//"' touches no element that holds material")
      end associate
    end do
    if (diagnostics%count > 0) return
    call allocate_surface_points(model%state%surface, model%mesh%dimension, list%count)
    if (list%count > 0) then
      call place_seeds(model, list, model%state%surface)
      model%state%surface%surface = list%body(:list%count)
      model%state%surface%area = list%volume(:list%count)
      model%state%surface%area_vector = list%vector(:, :list%count)
      call set_normals(model%state%surface, [(.true., k=1, list%count)])
    end if
    call choose_carrying_points(model)
    call check_planes(model, diagnostics)
  end subroutine make_surfaces

  !> Rejects segments with a body to their right and none to their left, where a pressure would act as tension. Bodies
  !> without a separate outline are not checked.
  subroutine check_sides(model, surface, diagnostics)
    type(model_type), intent(in) :: model
    type(surface_type), intent(in) :: surface
    type(diagnostics_type), intent(inout) :: diagnostics
    !> Distance from the segment that is checked, relative to its length.
    real(wp), parameter :: aside = 1.0e-3_wp
    type(body_shape_type) :: shape
    real(wp) :: middle(2), left(2)
    logical :: soil(2)
    integer :: k, b

    do k = 1, size(surface%segments, 2)
      associate (ends => surface%segments(:, k))
        middle = 0.5_wp*(ends(1:2) + ends(3:4))
        left = aside*[ends(2) - ends(4), ends(3) - ends(1)]
      end associate
      soil = .false.
      do b = 1, size(model%analysis%bodies)
        shape = shape_of(model, model%analysis%bodies(b), diagnostics)
        if (.not. allocated(shape%outline)) return
        soil = soil .or. [polygon_contains(shape%outline, middle + left), &
          polygon_contains(shape%outline, middle - left)]
      end do
      if (soil(2) .and. .not. soil(1)) call add_diagnostic(diagnostics, surface%where, '*SURFACE', "segment "// &
        integer_text(k)//" of surface '"//surface%name//"' has the body to its right: the body lies to the left "// &
        'of a segment, so write x2, y2, x1, y1')
    end do
  end subroutine check_sides

  !> Creates the points of one surface.
  subroutine seed_surface(model, table, surface, number, occupied, list)
    !> The model, to which notes are added.
    type(model_type), intent(inout) :: model
    type(seed_table_type), intent(in) :: table
    type(surface_type), intent(in) :: surface
    integer, intent(in) :: number
    !> Cells that contain material (cell_count).
    logical, intent(in) :: occupied(:)
    type(seed_list_type), intent(inout) :: list
    integer, allocatable :: faces(:, :)
    real(wp) :: left_out
    integer :: b, k

    select case (surface%selection)
    case (select_box)
      call faces_in_box(model%mesh, surface%box, faces)
      call seed_faces(model%mesh, occupied, faces, number, list)
      if (cuts_faces(model%mesh, surface%box, occupied)) model%notes = model%notes//"warning: surface '"// &
        surface%name//"': its box ends within faces of the mesh, which it leaves out; TYPE=SEGMENT and "// &
        'TYPE=OUTLINE take parts of faces'//new_line('a')
    case (select_segment)
      do k = 1, size(surface%segments, 2)
        call seed_segment(model%mesh, occupied, .false., surface%segments(:, k), surface_degree(model), &
          number, list)
      end do
    case (select_outline)
      b = place_named(model%analysis%bodies, surface%body)
      call seed_outline(model%mesh, table%points(:, b) > 0, model%shapes(b), outline_box(model, surface), &
        set_tolerance(model%mesh), surface_degree(model), number, list, left_out)
      if (left_out > 0.0_wp) model%notes = model%notes//"warning: surface '"//surface%name// &
        "': slivers of neighbouring faces in its box, "//rounded_text(left_out)//' in all, are left out'//new_line('a')
    case (select_mesh)
      associate (set => place_named(model%mesh%face_sets, surface%name))
        if (set > 0) call seed_faces(model%mesh, occupied, model%mesh%face_sets(set)%faces, number, list)
      end associate
    end select
  end subroutine seed_surface

  !> Checks that a surface that slides on its plane is plane.
  subroutine check_planes(model, diagnostics)
    type(model_type), intent(in) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: i, p, s, first

    do p = 1, size(model%analysis%phases)
      do i = 1, size(model%analysis%phases(p)%supports)
        associate (support => model%analysis%phases(p)%supports(i), points => model%state%surface)
          if (support%kind /= support_normal) cycle
          do s = 1, size(model%analysis%surfaces)
            if (model%analysis%surfaces(s)%name /= support%surface) cycle
            first = findloc(points%surface, s, dim=1)
            if (any(points%surface == s .and. norm2(points%normal - spread(points%normal(:, first), 2, &
              points%count), dim=1) > plane_tolerance)) call add_diagnostic(diagnostics, support%where, '*SUPPORT', &
              "surface '"//support%surface//"' is not plane; only TYPE=ALL can hold it")
          end do
        end associate
      end do
    end do
  end subroutine check_planes

  !> Returns the degree of the functions along a line or plane through a cell: for elements at most 4.
  pure integer function surface_degree(model) result(degree)
    type(model_type), intent(in) :: model

    degree = max(4, model%mesh%dimension*grid_degree(model%analysis%method%basis))
  end function surface_degree

  !> Returns the corners of the box that bounds a surface on an outline (3,2), with a margin; for a surface without a
  !> box a box larger than the mesh.
  pure function outline_box(model, surface) result(box)
    type(model_type), intent(in) :: model
    type(surface_type), intent(in) :: surface
    real(wp) :: box(3, 2)
    integer :: d

    d = model%mesh%dimension
    box(:, 1) = -1.0_wp
    box(:, 2) = 1.0_wp
    box(:d, 1) = box(:d, 1) + model%mesh%bounds(:, 1)
    box(:d, 2) = box(:d, 2) + model%mesh%bounds(:, 2)
    if (.not. surface%boxed) return
    box(:, 1) = surface%box(:, 1) - set_tolerance(model%mesh)
    box(:, 2) = surface%box(:, 2) + set_tolerance(model%mesh)
  end function outline_box

  !> Selects the material points that carry tractions in the method of the paper (section 3.1): each piece of surface
  !> assigns its area to the nearest material point.
  subroutine choose_carrying_points(model)
    type(model_type), intent(inout) :: model
    type(point_bins_type) :: bins
    integer :: i

    if (allocated(model%carrying_point)) deallocate (model%carrying_point, model%carrying_surface, model%carrying_area)
    allocate (model%carrying_point(model%state%surface%count), model%carrying_surface(model%state%surface%count))
    allocate (model%carrying_area(model%state%surface%count))
    model%carrying_surface = model%state%surface%surface
    model%carrying_area = model%state%surface%area
    ! In a model that is divided when it is created the points are those of the whole model, identified by their labels.
    if (is_divided(model%part)) then
      model%carrying_point = int(nearest_numbers(model, model%state%surface%position))
      return
    end if
    call make_bins(model%state%points%position, bins)
    do i = 1, model%state%surface%count
      model%carrying_point(i) = nearest_in_bins(bins, model%state%points%position, model%state%surface%position(:, i))
    end do
  end subroutine choose_carrying_points
end module qsmpm_model_surfaces
