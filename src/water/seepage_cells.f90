!> Subdivision of the cells of a 3D mesh into tetrahedra for seepage. Each cell is divided from its corner of the
!> smallest number over the faces that do not contain it, quadrilateral faces from theirs, so that neighbours conform
!> (Dompierre and others 1999). Bodies must fill whole cells; otherwise the flow is rejected with an error.
module qsmpm_seepage_cells
  use qsmpm_kinds, only: wp
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_element, only: corner_count, face_corners, face_count
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: cell_volume
  use qsmpm_model, only: model_type
  use qsmpm_seepage_bounds, only: seepage_scene_type
  implicit none
  private

  public :: cut_cells, fill_cells

contains

  !> Generates the tetrahedra and their neighbours.
  pure subroutine cut_cells(mesh, scene)
    type(mesh_type), intent(in) :: mesh
    type(seepage_scene_type), intent(inout) :: scene
    integer, allocatable :: node(:)
    integer :: turn, c, f, i, n, apex, first(0:mesh%cell_count)

    allocate (scene%outlines(0))
    scene%mesh%position = mesh%coordinates
    first = 0
    do turn = 1, 2
      n = 0
      do c = 1, mesh%cell_count
        first(c) = n + 1
        apex = minval(mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c) + corner_count(mesh%cell_kind(c)) - 1))
        do f = 1, face_count(mesh%cell_kind(c))
          node = mesh%cell_nodes(mesh%cell_first(c) - 1 + face_corners(mesh%cell_kind(c), f))
          if (any(node == apex)) cycle
          node = cshift(node, minloc(node, dim=1) - 1)
          do i = 2, size(node) - 1
            n = n + 1
            if (turn == 1) cycle
            scene%cell(n) = c
            scene%mesh%corner(:, n) = [apex, node(1), node(i), node(i + 1)]
          end do
        end do
      end do
      if (turn == 1) allocate (scene%cell(n), scene%mesh%corner(4, n))
    end do
    allocate (scene%face(4, n), scene%mesh%neighbour(4, n), source=0)
    do i = 1, n
      do f = 1, 4
        scene%face(f, i) = face_of(mesh, scene%cell(i), pack(scene%mesh%corner(:, i), scene%mesh%corner(:, i) /= &
          scene%mesh%corner(f, i)))
        scene%mesh%neighbour(f, i) = i
        if (scene%face(f, i) > 0) scene%mesh%neighbour(f, i) = first(mesh%face_neighbour(scene%face(f, i), &
          scene%cell(i)))
      end do
    end do
  end subroutine cut_cells

  !> Returns the face of a cell that contains three of its nodes, 0 for none.
  pure integer function face_of(mesh, c, ends) result(face)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell, and nodes (3).
    integer, intent(in) :: c, ends(:)
    integer :: f, k

    face = 0
    do f = 1, face_count(mesh%cell_kind(c))
      associate (node => mesh%cell_nodes(mesh%cell_first(c) - 1 + face_corners(mesh%cell_kind(c), f)))
        if (all([(any(node == ends(k)), k=1, 3)])) face = f
      end associate
    end do
  end function face_of

  !> Finds the body of each tetrahedron, 0 for none.
  subroutine fill_cells(model, active, scene, diagnostics)
    type(model_type), intent(in) :: model
    !> (bodies)
    logical, intent(in) :: active(:)
    type(seepage_scene_type), intent(inout) :: scene
    !> Reports bodies that end within cells.
    type(diagnostics_type), intent(inout) :: diagnostics
    real(wp) :: volume(size(active), model%mesh%cell_count)
    integer :: body(model%mesh%cell_count), p, b, c
    real(wp), parameter :: whole = 1.0e-6_wp

    volume = 0.0_wp
    associate (points => model%state%points)
      do p = 1, points%count
        associate (here => volume(points%body(p), points%cell(p)))
          if (active(points%body(p))) here = here + points%initial_volume(p)
        end associate
      end do
    end associate
    body = merge(maxloc(volume, dim=1), 0, any(volume > 0.0_wp, dim=1))
    do b = 1, size(active)
      do c = 1, size(body)
        if (.not. volume(b, c) > 0.0_wp) cycle
        if (abs(volume(b, c) - cell_volume(model%mesh, c)) <= whole*volume(b, c)) cycle
        call add_diagnostic(diagnostics, model%analysis%bodies(b)%where, '*BODY', "seepage through body '"// &
          model%analysis%bodies(b)%name//"' (*WATER LEVEL, TYPE=SEEPAGE), which ends inside cells of the mesh: in "// &
          '3D let it end on grid lines, or use a *MESH that conforms to it')
        exit
      end do
    end do
    scene%mesh%region = body(scene%cell)
  end subroutine fill_cells
end module qsmpm_seepage_cells
