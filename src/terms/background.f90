!> Soft background: eps E int_K (grad N_a - g_a) . (grad N_b - g_b) dV over each boundary cell K.
!>
!> g_a is the mean of grad N_a over the root of K: K itself when it is filled well, else the nearest such cell at its
!> corners, else the fullest one. So a linear field passes free of charge, and a cell that holds next to nothing follows
!> the linear field of a cell that is held by its material.
module qsmpm_background
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: full_rule, gauss_rule
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: cell_centre
  use qsmpm_point_location, only: activation_type, boundary_fill, whole_fill
  use qsmpm_space, only: space_type, shape_values_type, functions_at, cell_nodes_of_space, most_functions
  use qsmpm_node_graph, only: connectivity_type
  use qsmpm_penalty_matrices, only: penalty_matrices_type, most_nodes
  implicit none
  private

  public :: build_background

contains

  !> Soft background in boundary cells.
  subroutine build_background(mesh, space, activation, factor, stiffness, near, stabilisation)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(activation_type), intent(in) :: activation
    !> eps, and Young's modulus in each active cell (known_count).
    real(wp), intent(in) :: factor, stiffness(:)
    !> Cells that are stabilised, and those whose roots are (cell_count).
    logical, intent(in) :: near(:)
    !> The stabilisation terms.
    type(penalty_matrices_type), intent(inout) :: stabilisation
    integer, allocatable :: cells(:), roots(:)
    logical, allocatable :: wanted(:)
    integer :: k, n

    cells = pack(activation%active_cell, activation%boundary .and. (space%tensor .or. activation%fill < whole_fill))
    roots = [(root_of(cells(k)), k=1, size(cells))]
    wanted = near(cells) .or. near(roots)
    cells = pack(cells, wanted)
    roots = pack(roots, wanted)
    call patches_of_cells(cells, roots, stabilisation%connectivity)
    n = most_nodes(stabilisation%connectivity)
    allocate (stabilisation%matrix(n, n, size(cells)), source=0.0_wp)
    do k = 1, size(cells)
      associate (from => stabilisation%connectivity%first(k), to => stabilisation%connectivity%first(k + 1) - 1)
        call cell_matrix(cells(k), roots(k), factor*stiffness(activation%active_number(cells(k))), &
          stabilisation%connectivity%nodes(from:to), stabilisation%matrix(:, :, k))
      end associate
    end do

  contains

    !> The cell whose linear field a boundary cell follows.
    pure integer function root_of(cell) result(root)
      !> Number of the boundary cell.
      integer, intent(in) :: cell
      real(wp) :: least, distance, most
      integer :: k, g, fullest

      root = cell
      most = activation%fill(activation%active_number(cell))
      if (most >= boundary_fill) return
      fullest = cell
      least = huge(least)
      do k = mesh%vertex_first(cell), mesh%vertex_first(cell + 1) - 1
        g = activation%active_number(mesh%vertex_neighbour(k))
        if (g == 0) cycle
        if (activation%fill(g) > most) fullest = mesh%vertex_neighbour(k)
        most = max(most, activation%fill(g))
        distance = norm2(cell_centre(mesh, cell) - cell_centre(mesh, mesh%vertex_neighbour(k)))
        if (activation%fill(g) < boundary_fill .or. distance >= least) cycle
        least = distance
        root = mesh%vertex_neighbour(k)
      end do
      if (root == cell) root = fullest
    end function root_of

    !> The term of one cell.
    subroutine cell_matrix(cell, root, factor, nodes, matrix)
      !> The boundary cell and its root.
      integer, intent(in) :: cell, root
      !> eps E.
      real(wp), intent(in) :: factor
      !> Nodes of the patch (n).
      integer, intent(in) :: nodes(:)
      !> Leading (n,n) is added to.
      real(wp), intent(inout) :: matrix(:, :)
      real(wp), allocatable :: places(:, :), weights(:)
      real(wp), dimension(mesh%dimension, size(nodes)) :: mean, deviation
      type(shape_values_type) :: place
      real(wp) :: volume
      integer :: q, n

      n = size(nodes)
      mean = 0.0_wp
      volume = 0.0_wp
      call rule_of(root, places, weights)
      do q = 1, size(weights)
        call functions_at(space, mesh, root, places(:, q), place)
        call add_gradients(place, nodes, weights(q)*place%determinant, mean)
        volume = volume + weights(q)*place%determinant
      end do
      call rule_of(cell, places, weights)
      do q = 1, size(weights)
        call functions_at(space, mesh, cell, places(:, q), place)
        deviation = -mean/volume
        call add_gradients(place, nodes, 1.0_wp, deviation)
        matrix(:n, :n) = matrix(:n, :n) + factor*weights(q)*place%determinant*matmul(transpose(deviation), deviation)
      end do
    end subroutine cell_matrix

    !> Rule that integrates products of gradients.
    subroutine rule_of(cell, places, weights)
      !> Number of the cell.
      integer, intent(in) :: cell
      !> Local coordinates (dimension, m), and weights (m).
      real(wp), allocatable, intent(out) :: places(:, :), weights(:)

      if (space%tensor .and. space%degree > 1) then
        call gauss_rule(mesh%cell_kind(cell), 2*space%degree, places, weights)
      else
        call full_rule(mesh%cell_kind(cell), places, weights)
      end if
    end subroutine rule_of

    !> The nodes of cells and of their roots, each once, as patches.
    pure subroutine patches_of_cells(cells, roots, connectivity)
      !> Cells in rising order, and their roots.
      integer, intent(in) :: cells(:), roots(:)
      !> Node lists that couple.
      type(connectivity_type), intent(out) :: connectivity
      integer :: nodes(most_functions), k, n, last, a

      connectivity%count = size(cells)
      allocate (connectivity%first(size(cells) + 1), connectivity%nodes(2*most_functions*size(cells)))
      connectivity%first(1) = 1
      do k = 1, size(cells)
        call cell_nodes_of_space(space, mesh, cells(k), nodes, n)
        last = connectivity%first(k) + n - 1
        connectivity%nodes(connectivity%first(k):last) = nodes(:n)
        call cell_nodes_of_space(space, mesh, roots(k), nodes, n)
        do a = 1, n
          if (any(connectivity%nodes(connectivity%first(k):last) == nodes(a))) cycle
          last = last + 1
          connectivity%nodes(last) = nodes(a)
        end do
        connectivity%first(k + 1) = last + 1
      end do
      connectivity%nodes = connectivity%nodes(:connectivity%first(size(cells) + 1) - 1)
    end subroutine patches_of_cells
  end subroutine build_background

  !> Add the gradients at a place, times a factor, to those of the nodes of a patch.
  pure subroutine add_gradients(place, nodes, factor, gradients)
    !> The functions at the place.
    type(shape_values_type), intent(in) :: place
    !> Nodes of the patch (n).
    integer, intent(in) :: nodes(:)
    real(wp), intent(in) :: factor
    !> (dimension, n)
    real(wp), intent(inout) :: gradients(:, :)
    integer :: a, b

    do a = 1, place%count
      b = findloc(nodes, place%node(a), dim=1)
      gradients(:, b) = gradients(:, b) + factor*place%gradient(:size(gradients, 1), a)
    end do
  end subroutine add_gradients
end module qsmpm_background
