!> Ghost penalty of splines and GIMP on the faces of boundary cells.
!>   sum over k of  g E h^(2k-1) int_F [d_n^k N_a][d_n^k N_b] dF
!> over the faces F between touched cells of which one is a boundary cell; k runs from the first derivative that is
!> discontinuous to the degree: only the degree at a simple knot, from one at a reduced knot. The matrix of a face is a
!> product of a jump along its normal and mass matrices along its sides. E is that of the softer cell: next to a
!> concrete body the displacement of soil has a kink, which a penalty with the modulus of concrete would suppress.
!>
!> Cells that contain only a part of the domain of a point are included: their functions have equations but little
!> stiffness. There is no face between a cell and an untouched one, so that nothing is coupled across a plate or into an
!> open slot.
module qsmpm_spline_ghost
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_point_location, only: activation_type, boundary_fill
  use qsmpm_grid_window, only: place_of
  use qsmpm_node_graph, only: lay_lists
  use qsmpm_space, only: space_type, tensor_nodes
  use qsmpm_spline_axis, only: spline_axis_type, axis_values, lowest_jump, highest_degree
  use qsmpm_penalty_matrices, only: penalty_matrices_type, clear_matrices
  implicit none
  private

  public :: build_spline_ghost

  !> Largest number of functions along the normal of a face: two cells at a reduced knot.
  integer, parameter :: most_at_face = 2*highest_degree + 1
  !> Four Gauss points integrate products of cubics.
  real(wp), parameter :: gauss_place(4) = [-0.861136311594052575_wp, -0.339981043584856265_wp, &
    0.339981043584856265_wp, 0.861136311594052575_wp]
  real(wp), parameter :: gauss_weight(4) = [0.347854845137453857_wp, 0.652145154862546143_wp, &
    0.652145154862546143_wp, 0.347854845137453857_wp]

contains

  !> Builds the penalty on all faces of boundary cells.
  subroutine build_spline_ghost(mesh, space, activation, factor, stiffness, near, stabilisation)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(activation_type), intent(in) :: activation
    !> g.
    real(wp), intent(in) :: factor
    !> Young's modulus in each active cell (known_count).
    real(wp), intent(in) :: stiffness(:)
    !> Cells whose faces are penalised (cell_count).
    logical, intent(in) :: near(:)
    !> The stabilisation terms.
    type(penalty_matrices_type), intent(inout) :: stabilisation
    logical :: boundary(mesh%cell_count), penalised(size(mesh%interior_face, 2))
    real(wp) :: young(mesh%cell_count)
    integer, allocatable :: faces(:)
    integer :: i

    call mark_boundary(mesh, activation, boundary)
    call spread_stiffness(mesh, activation, stiffness, young)
    do i = 1, size(penalised)
      associate (one => mesh%interior_face(1, i), two => mesh%interior_face(3, i))
        penalised(i) = activation%touched(one) .and. activation%touched(two) .and. &
          (boundary(one) .or. boundary(two)) .and. (near(one) .or. near(two))
      end associate
    end do
    faces = pack([(i, i=1, size(penalised))], penalised)
    call patches_of_faces(mesh, space, faces, stabilisation)
    call clear_matrices(stabilisation)
    do i = 1, size(faces)
      associate (one => mesh%interior_face(1, faces(i)), two => mesh%interior_face(3, faces(i)))
        call face_penalty(mesh, space, one, two, factor*min(young(one), young(two)), &
          stabilisation%matrix(:, :, i))
      end associate
    end do
  end subroutine build_spline_ghost

  !> Marks the boundary cells: by the definition of point location, with touched instead of active cells.
  subroutine mark_boundary(mesh, activation, boundary)
    type(mesh_type), intent(in) :: mesh
    type(activation_type), intent(in) :: activation
    !> (cell_count)
    logical, intent(out) :: boundary(:)
    integer :: c

    do c = 1, mesh%cell_count
      boundary(c) = activation%touched(c)
      if (.not. boundary(c) .or. activation%active_number(c) == 0) cycle
      associate (around => mesh%vertex_neighbour(mesh%vertex_first(c):mesh%vertex_first(c + 1) - 1))
        boundary(c) = .not. all(activation%touched(around)) .or. &
          activation%fill(activation%active_number(c)) < boundary_fill
      end associate
    end do
  end subroutine mark_boundary

  !> Sets Young's modulus of every touched cell; one without points receives the largest of its neighbours.
  subroutine spread_stiffness(mesh, activation, stiffness, young)
    type(mesh_type), intent(in) :: mesh
    type(activation_type), intent(in) :: activation
    !> Young's modulus in each active cell (known_count).
    real(wp), intent(in) :: stiffness(:)
    !> (cell_count)
    real(wp), intent(out) :: young(:)
    integer :: c, k, n

    young = 0.0_wp
    young(activation%active_cell) = stiffness
    do c = 1, mesh%cell_count
      if (.not. activation%touched(c) .or. activation%active_number(c) > 0) cycle
      do k = mesh%vertex_first(c), mesh%vertex_first(c + 1) - 1
        n = activation%active_number(mesh%vertex_neighbour(k))
        if (n > 0) young(c) = max(young(c), stiffness(n))
      end do
    end do
  end subroutine spread_stiffness

  !> Collects the control points of the two cells at each face: a block.
  subroutine patches_of_faces(mesh, space, faces, stabilisation)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    !> Interior faces.
    integer, intent(in) :: faces(:)
    !> Penalty whose patches are set.
    type(penalty_matrices_type), intent(inout) :: stabilisation
    integer :: first(3, size(faces)), count(3, size(faces)), k, normal

    do k = 1, size(faces)
      call face_block(space, mesh%dimension, mesh%interior_face(1, faces(k)), &
        mesh%interior_face(3, faces(k)), normal, first(:, k), count(:, k))
    end do
    associate (connectivity => stabilisation%connectivity)
      call lay_lists(product(count, dim=1), connectivity)
      do k = 1, size(faces)
        call tensor_nodes(space, first(:, k), count(:, k), &
          connectivity%nodes(connectivity%first(k):connectivity%first(k + 1) - 1))
      end do
    end associate
  end subroutine patches_of_faces

  !> Finds the axis normal to the face between two cells, and the block of their functions.
  pure subroutine face_block(space, dimension, one, two, normal, first, count)
    type(space_type), intent(in) :: space
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Numbers of the cells, the first one below the second.
    integer, intent(in) :: one, two
    !> Axis normal to the face.
    integer, intent(out) :: normal
    !> First function and number of functions along each axis.
    integer, intent(out) :: first(3), count(3)
    integer :: at(3), beyond(3), a

    at = place_of(one, space%axis%cell_count)
    beyond = place_of(two, space%axis%cell_count)
    first = 1
    count = 1
    normal = 0
    do a = 1, dimension
      associate (last => space%axis(a)%last)
        first(a) = last(at(a)) - space%degree
        count(a) = last(beyond(a)) - first(a) + 1
      end associate
      if (beyond(a) /= at(a)) normal = a
    end do
  end subroutine face_block

  !> Computes the matrix of one face.
  subroutine face_penalty(mesh, space, one, two, factor, matrix)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    !> Numbers of the cells, the first one below the second.
    integer, intent(in) :: one, two
    !> g E.
    real(wp), intent(in) :: factor
    !> Leading part is set.
    real(wp), intent(inout) :: matrix(:, :)
    real(wp) :: along(most_at_face, most_at_face, 3)
    integer :: first(3), count(3), at(3), normal, a, i, j, k, l, m, n, row, column

    call face_block(space, mesh%dimension, one, two, normal, first, count)
    at = place_of(one, space%axis%cell_count)
    along = 0.0_wp
    along(1, 1, 3) = 1.0_wp
    do a = 1, mesh%dimension
      if (a == normal) then
        call jump_matrix(space%axis(a), at(a), along(:, :, a))
      else
        call mass_matrix(space%axis(a), at(a), along(:, :, a))
      end if
    end do
    column = 0
    do n = 1, count(3)
      do m = 1, count(2)
        do l = 1, count(1)
          column = column + 1
          row = 0
          do k = 1, count(3)
            do j = 1, count(2)
              do i = 1, count(1)
                row = row + 1
                matrix(row, column) = factor*along(i, l, 1)*along(j, m, 2)*along(k, n, 3)
              end do
            end do
          end do
        end do
      end do
    end do
  end subroutine face_penalty

  !> Computes the squares of the jumps at the grid line above a cell, scaled by h^(2k-1).
  pure subroutine jump_matrix(axis, cell, matrix)
    type(spline_axis_type), intent(in) :: axis
    !> The cell below the grid line.
    integer, intent(in) :: cell
    !> Leading part is set, the rest zero.
    real(wp), intent(out) :: matrix(:, :)
    real(wp) :: jump(most_at_face), values(highest_degree + 1), h
    integer :: order, from, i

    h = 0.5_wp*(axis%lines(cell + 2) - axis%lines(cell))
    matrix = 0.0_wp
    from = axis%last(cell + 1) - axis%last(cell)
    do order = lowest_jump(axis, cell + 1), axis%degree
      jump = 0.0_wp
      call axis_values(axis, cell + 1, axis%lines(cell + 1), order, values)
      jump(from + 1:from + axis%degree + 1) = values(:axis%degree + 1)
      call axis_values(axis, cell, axis%lines(cell + 1), order, values)
      jump(:axis%degree + 1) = jump(:axis%degree + 1) - values(:axis%degree + 1)
      do i = 1, most_at_face
        matrix(:, i) = matrix(:, i) + h**(2*order - 1)*jump*jump(i)
      end do
    end do
  end subroutine jump_matrix

  !> Computes int N_i N_j dx over a cell.
  pure subroutine mass_matrix(axis, cell, matrix)
    type(spline_axis_type), intent(in) :: axis
    integer, intent(in) :: cell
    !> Leading part is set, the rest zero.
    real(wp), intent(out) :: matrix(:, :)
    real(wp) :: values(highest_degree + 1), half
    integer :: q, i, n

    matrix = 0.0_wp
    n = axis%degree + 1
    half = 0.5_wp*(axis%lines(cell + 1) - axis%lines(cell))
    do q = 1, size(gauss_place)
      call axis_values(axis, cell, axis%lines(cell) + (1.0_wp + gauss_place(q))*half, 0, values)
      do i = 1, n
        matrix(:n, i) = matrix(:n, i) + half*gauss_weight(q)*values(:n)*values(i)
      end do
    end do
  end subroutine mass_matrix
end module qsmpm_spline_ghost
