!> Rigid bodies that are in place from the start (IN PLACE=YES): the part of the soil inside them is removed before the
!> first step. The outlines of the soil bodies then follow the rigid bodies, as if they had been defined so: cut cells
!> contain the remaining part, and surfaces of type OUTLINE follow. Arcs are approximated by chords whose deviation is a
!> small share of a cell.
module qsmpm_bodies_in_place
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_mesh_description, only: mesh_grid
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_mesh_sets, only: set_tolerance
  use qsmpm_model, only: model_type
  use qsmpm_point_selection, only: keep_chosen
  use qsmpm_points, only: place_of
  use qsmpm_polygon_difference, only: polygon_difference
  use qsmpm_rigid_bodies, only: make_shape, drawn_within
  use qsmpm_rigid_outline, only: outline_corners
  use qsmpm_rigid_pose, only: placed_shape_type
  use qsmpm_rigid_shape, only: rigid_shape_type, distance_type, kind_half_space, kind_polygon, box_polygon
  use qsmpm_rounded_text, only: rounded_text
  implicit none
  private

  public :: has_bodies_in_place, take_out_bodies, drop_buried_surfaces

  !> Largest distance of chords from an arc, in cells; smallest number of chords of a circle.
  real(wp), parameter :: flat = 2.0e-3_wp
  integer, parameter :: fewest = 64

contains

  !> Returns whether any rigid body is in place from the start.
  pure logical function has_bodies_in_place(analysis) result(any_there)
    type(analysis_type), intent(in) :: analysis

    any_there = any(analysis%rigid_bodies%in_place)
  end function has_bodies_in_place

  !> Removes the rigid bodies from the shapes of the soil bodies.
  subroutine take_out_bodies(model, diagnostics)
    !> Its shapes change; radii of corners that depend on the size of a cell are fixed, because this may change now.
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    type(placed_shape_type) :: placed
    real(wp), allocatable :: corners(:, :)
    integer :: r, b, known

    do r = 1, size(model%analysis%rigid_bodies)
      associate (body => model%analysis%rigid_bodies(r))
        if (.not. body%in_place) cycle
        known = diagnostics%count
        call make_shape(body, model%analysis%model, model%cell_size, placed%shape, placed%reference, diagnostics)
        if (diagnostics%count > known) return
        if (placed%shape%kind == kind_polygon) body%round = placed%shape%radius
        allocate (corners, source=corners_of_hole(model, placed%shape))
        do b = 1, size(model%shapes)
          call cut_shape(model, b, corners, diagnostics)
        end do
        deallocate (corners)
      end associate
    end do
  end subroutine take_out_bodies

  !> Returns the corners of a rigid body; for a plane those of a rectangle behind it that contains the end of the mesh.
  function corners_of_hole(model, shape) result(corners)
    type(model_type), intent(in) :: model
    type(rigid_shape_type), intent(in) :: shape
    !> Counter-clockwise order (2,n).
    real(wp), allocatable :: corners(:, :)
    real(wp) :: reach
    integer :: chords

    reach = 2.0_wp*(norm2(model%mesh%bounds(:, 2) - model%mesh%bounds(:, 1)) &
      + norm2(shape%place(:2) - model%mesh%bounds(:, 1)))
    chords = fewest
    if (shape%kind /= kind_half_space .and. shape%radius > flat*model%cell_size) chords = max(fewest, &
      4*ceiling(0.25_wp*acos(-1.0_wp)/acos(1.0_wp - flat*model%cell_size/shape%radius)))
    allocate (corners, source=outline_corners(shape, reach, chords))
    if (shape%kind == kind_half_space) corners = reshape([corners, corners(:, 2) - reach*shape%normal(:2), &
      corners(:, 1) - reach*shape%normal(:2)], [2, 4])
  end function corners_of_hole

  !> Removes a hole from the shape of a soil body.
  subroutine cut_shape(model, b, corners, diagnostics)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: b
    real(wp), intent(in) :: corners(:, :)
    type(diagnostics_type), intent(inout) :: diagnostics
    real(wp), allocatable :: rest(:, :)

    associate (shape => model%shapes(b), body => model%analysis%bodies(b))
      if (.not. allocated(shape%outline) .and. .not. allocated(shape%region) .and. &
        model%analysis%mesh%kind == mesh_grid) &
        shape%outline = box_polygon(model%mesh%bounds(:2, 1), model%mesh%bounds(:2, 2))
      if (.not. allocated(shape%outline)) then
        call add_diagnostic(diagnostics, body%where, '*BODY', "rigid bodies IN PLACE are taken out of bodies of "// &
          "type BOX and POLYGON, and of ALL of a *GRID: '"//body%name//"' is none of them")
        return
      end if
      call polygon_difference(shape%outline, corners, set_tolerance(model%mesh), rest)
      if (size(rest, 2) == 0) then
        call add_diagnostic(diagnostics, body%where, '*BODY', "nothing remains of '"//body%name// &
          "' where rigid bodies are IN PLACE")
      else
        call move_alloc(rest, shape%outline)
      end if
    end associate
  end subroutine cut_shape

  !> Removes the part of the surfaces inside a body in place.
  subroutine drop_buried_surfaces(model, diagnostics)
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    type(distance_type) :: distance
    logical :: buried(model%state%surface%count)
    integer :: b, i, s

    buried = .false.
    do b = 1, size(model%rigid_shapes)
      if (.not. model%analysis%rigid_bodies(b)%in_place) cycle
      do i = 1, size(buried)
        distance = model%rigid_shapes(b)%distance_at(place_of(model%state%surface, i))
        buried(i) = buried(i) .or. distance%value < -drawn_within*model%cell_size
      end do
    end do
    do s = 1, size(model%analysis%surfaces)
      associate (surface => model%analysis%surfaces(s), here => model%state%surface%surface == s)
        if (.not. any(buried .and. here)) cycle
        if (all(buried .or. .not. here)) call add_diagnostic(diagnostics, surface%where, '*SURFACE', "all of '"// &
          surface%name//"' is inside rigid bodies IN PLACE; TYPE=OUTLINE follows them")
        model%notes = model%notes//"surface '"//surface%name//"': "//rounded_text(sum(model%state%surface%area, &
          mask=buried .and. here))//' of it is inside rigid bodies in place and is omitted'//new_line('a')
      end associate
    end do
    if (.not. any(buried)) return
    call keep_chosen(model%state%surface, pack([(i, i=1, size(buried))], .not. buried))
  end subroutine drop_buried_surfaces
end module qsmpm_bodies_in_place
