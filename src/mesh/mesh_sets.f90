!> Choosing nodes and faces by place or by name.
module qsmpm_mesh_sets
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_element, only: face_count, face_corners, face_corner_count
  use qsmpm_mesh, only: mesh_type, index_set_type
  implicit none
  private

  public :: nodes_in_box, nodes_on_plane, faces_in_box, cuts_faces, items_of, add_set, set_tolerance

  !> A node lies on a plane when it is this close, as a share of the size of the mesh.
  real(wp), parameter :: closeness = 1.0e-8_wp

contains

  !> Distance below which places count as the same.
  pure real(wp) function set_tolerance(mesh) result(tolerance)
    type(mesh_type), intent(in) :: mesh

    tolerance = closeness*maxval(mesh%bounds(:, 2) - mesh%bounds(:, 1))
  end function set_tolerance

  !> Nodes in a box; limits along z are not looked at in the plane.
  pure subroutine nodes_in_box(mesh, box, items)
    type(mesh_type), intent(in) :: mesh
    !> Lower and upper corner (3,2).
    real(wp), intent(in) :: box(3, 2)
    !> Indices found.
    integer, allocatable, intent(out) :: items(:)
    logical :: inside(mesh%node_count)
    integer :: i

    inside = .true.
    do i = 1, mesh%dimension
      inside = inside .and. mesh%coordinates(i, :) >= box(i, 1) - set_tolerance(mesh) &
        .and. mesh%coordinates(i, :) <= box(i, 2) + set_tolerance(mesh)
    end do
    items = pack([(i, i=1, mesh%node_count)], inside)
  end subroutine nodes_in_box

  !> Nodes on a plane normal to an axis.
  pure subroutine nodes_on_plane(mesh, axis, value, items)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: axis
    real(wp), intent(in) :: value
    !> Indices found.
    integer, allocatable, intent(out) :: items(:)
    integer :: i

    items = pack([(i, i=1, mesh%node_count)], abs(mesh%coordinates(axis, :) - value) <= set_tolerance(mesh))
  end subroutine nodes_on_plane

  !> Faces whose corners all lie in a box; an interior face comes from both its cells.
  pure subroutine faces_in_box(mesh, box, faces)
    type(mesh_type), intent(in) :: mesh
    real(wp), intent(in) :: box(3, 2)
    !> Cell and local face, (2,n).
    integer, allocatable, intent(out) :: faces(:, :)
    integer, allocatable :: items(:)
    integer :: list(2, 6*mesh%cell_count), c, f, n
    logical :: inside(mesh%node_count)

    call nodes_in_box(mesh, box, items)
    inside = .false.
    inside(items) = .true.
    n = 0
    do c = 1, mesh%cell_count
      do f = 1, face_count(mesh%cell_kind(c))
        if (.not. all_inside(mesh, c, f, inside)) cycle
        n = n + 1
        list(:, n) = [c, f]
      end do
    end do
    faces = list(:, :n)
  end subroutine faces_in_box

  !> Whether faces of some cells lie in the plane of a flat box and reach into it and beyond it. A box with a
  !> thickness may: it is made to choose.
  pure logical function cuts_faces(mesh, box, wanted) result(cuts)
    type(mesh_type), intent(in) :: mesh
    !> Lower and upper corner (3,2).
    real(wp), intent(in) :: box(3, 2)
    !> The cells (cell_count).
    logical, intent(in) :: wanted(:)
    real(wp) :: low(mesh%dimension), high(mesh%dimension), slack
    logical :: flat(mesh%dimension)
    integer :: c, f, i

    cuts = .false.
    slack = set_tolerance(mesh)
    flat = box(:mesh%dimension, 2) - box(:mesh%dimension, 1) <= slack
    if (.not. any(flat)) return
    do c = 1, mesh%cell_count
      if (.not. wanted(c)) cycle
      do f = 1, face_count(mesh%cell_kind(c))
        associate (nodes => mesh%cell_first(c) - 1 + face_corners(mesh%cell_kind(c), f))
          do i = 1, mesh%dimension
            low(i) = minval(mesh%coordinates(i, mesh%cell_nodes(nodes)))
            high(i) = maxval(mesh%coordinates(i, mesh%cell_nodes(nodes)))
          end do
        end associate
        if (any(flat .and. (low < box(:mesh%dimension, 1) - slack .or. high > box(:mesh%dimension, 2) + slack))) cycle
        if (any(.not. flat .and. (high <= box(:mesh%dimension, 1) + slack .or. &
          low >= box(:mesh%dimension, 2) - slack))) cycle
        if (any(low < box(:mesh%dimension, 1) - slack .or. high > box(:mesh%dimension, 2) + slack)) cuts = .true.
      end do
    end do
  end function cuts_faces

  !> True when all corners of a face are marked.
  pure logical function all_inside(mesh, cell, face, inside) result(yes)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: cell, face
    logical, intent(in) :: inside(:)
    integer :: corners(face_corner_count(mesh%cell_kind(cell), face))

    corners = face_corners(mesh%cell_kind(cell), face)
    yes = all(inside(mesh%cell_nodes(mesh%cell_first(cell) - 1 + corners)))
  end function all_inside

  !> What a set of a name holds; nothing where there is none.
  pure function items_of(sets, name) result(items)
    !> The list of sets.
    type(index_set_type), intent(in) :: sets(:)
    character(len=*), intent(in) :: name
    integer, allocatable :: items(:)
    integer :: place

    place = place_named(sets, name)
    if (place > 0) items = sets(place)%items
    if (place == 0) allocate (items(0))
  end function items_of

  !> Append a set.
  pure subroutine add_set(sets, name, items)
    !> The list of sets.
    type(index_set_type), allocatable, intent(inout) :: sets(:)
    character(len=*), intent(in) :: name
    !> Indices found.
    integer, intent(in) :: items(:)
    type(index_set_type) :: set

    if (.not. allocated(sets)) allocate (sets(0))
    set%name = name
    set%items = items
    sets = [sets, set]
  end subroutine add_set
end module qsmpm_mesh_sets
