!> Ghost penalty of element meshes on the faces of boundary cells.
!>   g E h_F int_F [d_n N_a][d_n N_b] dF  (+ g E h_F^3 [d_nn][d_nn] on quadratic elements)
!> over the faces F of boundary cells between active cells, h_F = (|K1| + |K2|)/|F|, E that of the softer cell
!> (qsmpm_spline_ghost). On quadratic elements neither term is sufficient alone.
module qsmpm_element_ghost
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: element_geometry, element_order, face_rule, face_area_vector, &
    shape_functions, local_nodes
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_search, only: inverse_map
  use qsmpm_point_location, only: activation_type, whole_fill
  use qsmpm_space, only: space_type
  use qsmpm_penalty_matrices, only: penalty_matrices_type, pair_cells
  implicit none
  private

  public :: build_element_ghost

contains

  !> Builds the ghost penalty on the faces of boundary cells.
  subroutine build_element_ghost(mesh, space, activation, factor, stiffness, volumes, near, stabilisation)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(activation_type), intent(in) :: activation
    real(wp), intent(in) :: factor, stiffness(:), volumes(:)
    !> Cells whose faces are penalised (cell_count).
    logical, intent(in) :: near(:)
    !> The stabilisation terms.
    type(penalty_matrices_type), intent(inout) :: stabilisation
    integer, allocatable :: faces(:)
    integer :: i, one, two
    logical :: penalised(size(mesh%interior_face, 2))

    penalised = near(mesh%interior_face(1, :)) .or. near(mesh%interior_face(3, :))
    do i = 1, size(mesh%interior_face, 2)
      if (.not. penalised(i)) cycle
      one = activation%active_number(mesh%interior_face(1, i))
      two = activation%active_number(mesh%interior_face(3, i))
      penalised(i) = one > 0 .and. two > 0
      if (penalised(i)) penalised(i) = any(activation%boundary([one, two]) .and. &
        activation%fill([one, two]) < whole_fill)
    end do
    faces = pack([(i, i=1, size(penalised))], penalised)
    call pair_cells(mesh, space, mesh%interior_face(1, faces), mesh%interior_face(3, faces), stabilisation)
    do i = 1, size(faces)
      one = activation%active_number(mesh%interior_face(1, faces(i)))
      two = activation%active_number(mesh%interior_face(3, faces(i)))
      associate (from => stabilisation%connectivity%first(i), to => stabilisation%connectivity%first(i + 1) - 1)
        call face_penalty(mesh, mesh%interior_face(:, faces(i)), volumes, factor*min(stiffness(one), stiffness(two)), &
          stabilisation%connectivity%nodes(from:to), stabilisation%matrix(:, :, i))
      end associate
    end do
  end subroutine build_element_ghost

  !> Computes the penalty matrix of one face.
  subroutine face_penalty(mesh, face, volumes, factor, nodes, matrix)
    type(mesh_type), intent(in) :: mesh
    !> Cell, local face, neighbour cell, its local face.
    integer, intent(in) :: face(4)
    !> Volume of every cell (cell_count).
    real(wp), intent(in) :: volumes(:)
    !> g E.
    real(wp), intent(in) :: factor
    !> Nodes of the patch (n).
    integer, intent(in) :: nodes(:)
    !> Leading (n,n) is set.
    real(wp), intent(inout) :: matrix(:, :)
    real(wp), allocatable :: places(:, :), weights(:)
    real(wp) :: first_jump(size(nodes)), second_jump(size(nodes)), normal(mesh%dimension)
    real(wp) :: area, size_of_face, beyond(mesh%dimension), x(mesh%dimension)
    logical :: ok
    integer :: q, i, n

    n = size(nodes)
    call face_rule(mesh%cell_kind(face(1)), face(2), 2*element_order(mesh%cell_kind(face(1))), &
      places, weights)
    area = 0.0_wp
    do q = 1, size(weights)
      call normal_at(mesh, face, places(:, q), normal, size_of_face)
      area = area + weights(q)*size_of_face
    end do
    do q = 1, size(weights)
      call normal_at(mesh, face, places(:, q), normal, size_of_face)
      first_jump = 0.0_wp
      second_jump = 0.0_wp
      call add_jumps(mesh, face(1), places(:, q), normal, 1.0_wp, nodes, first_jump, second_jump, x)
      call inverse_map(mesh, face(3), x, beyond, ok)
      call add_jumps(mesh, face(3), beyond, normal, -1.0_wp, nodes, first_jump, second_jump, x)
      associate (h => (volumes(face(1)) + volumes(face(3)))/area)
        do i = 1, n
          matrix(:n, i) = matrix(:n, i) + factor*weights(q)*size_of_face &
            *(h*first_jump*first_jump(i) + h**3*second_jump*second_jump(i))
        end do
      end associate
    end do
  end subroutine face_penalty

  !> Computes the unit normal of a face, and its area per reference area.
  subroutine normal_at(mesh, face, local, normal, size_of_face)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: face(4)
    !> Local coordinates (dimension).
    real(wp), intent(in) :: local(:)
    real(wp), intent(out) :: normal(:), size_of_face

    associate (c => face(1))
      call face_area_vector(mesh%cell_kind(c), face(2), local, &
        mesh%coordinates(:, mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1)), normal)
    end associate
    size_of_face = norm2(normal)
    normal = normal/size_of_face
  end subroutine normal_at

  !> Adds the normal derivatives of one side, of first and (quadratic elements) second order, to the jumps.
  subroutine add_jumps(mesh, cell, local, normal, sign_of_side, nodes, first_jump, second_jump, x)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    real(wp), intent(in) :: local(:), normal(:), sign_of_side
    !> Node numbers.
    integer, intent(in) :: nodes(:)
    real(wp), intent(inout) :: first_jump(:), second_jump(:)
    !> Position in space.
    real(wp), intent(out) :: x(:)
    real(wp) :: functions(20), gradients(size(normal), 20), determinant, direction(size(normal))
    real(wp) :: corner(size(normal), 20), second(size(normal), size(normal), 20)
    integer :: a, n, place

    n = mesh%cell_first(cell + 1) - mesh%cell_first(cell)
    associate (own => mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell + 1) - 1))
      corner(:, :n) = mesh%coordinates(:, own)
      call element_geometry(mesh%cell_kind(cell), local, corner(:, :n), functions(:n), &
        gradients(:, :n), determinant)
      x = matmul(corner(:, :n), functions(:n))
      if (element_order(mesh%cell_kind(cell)) == 2) then
        call shape_functions(mesh%cell_kind(cell), local, second=second(:, :, :n))
        ! Derivative of the local coordinates along the normal (straight-edged cells): the local coordinates are fields
        ! of the element whose nodal values are the local positions of its nodes.
        direction = matmul(local_nodes(mesh%cell_kind(cell)), matmul(normal, gradients(:, :n)))
      end if
      do a = 1, n
        place = findloc(nodes, own(a), dim=1)
        first_jump(place) = first_jump(place) + sign_of_side*dot_product(gradients(:, a), normal)
        if (element_order(mesh%cell_kind(cell)) == 2) second_jump(place) = second_jump(place) &
          + sign_of_side*dot_product(direction, matmul(second(:, :, a), direction))
      end do
    end associate
  end subroutine add_jumps
end module qsmpm_element_ghost
