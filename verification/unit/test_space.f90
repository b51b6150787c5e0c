!> The space of displacements and its builder: sums, linear fields and gradients of every kind of
!> functions in plane and space, constraints on sets of nodes, and following a mesh that moves.
module test_space
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_sets, only: add_set
  use qsmpm_grid_window, only: place_of
  use qsmpm_space, only: space_type, shape_values_type, functions_at, cell_nodes_of_space, &
    refresh_space, value_at, node_position, most_functions
  use qsmpm_space_builder, only: element_space, box_of_set
  use sample_models, only: sample_grid, uneven_grid, sample_space, owner_of, lines_x, lines_y
  use testing, only: tests_type
  implicit none
  private

  public :: collect_space

  !> Products of three polynomials of degree three and their derivatives, all near one.
  real(wp), parameter :: rounding = 1.0e-12_wp
  !> A footing on a part of the top, and the same in space.
  real(wp), parameter :: footing(3, 2) = reshape([0.3_wp, 3.0_wp, 0.0_wp, 1.4_wp, 3.0_wp, 2.9_wp], [3, 2])

contains

  !> All checks.
  subroutine collect_space(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(space_type) :: space
    character(len=24) :: name
    character(len=7), parameter :: elements(6) = [character(len=7) :: 'TRI6', 'QUAD4', 'QUAD8', 'HEX8', &
      'WEDGE15', 'TET10']
    integer :: dimension, degree, i

    call tests%start('space')
    do i = 1, size(elements)
      call sample_grid(trim(elements(i)), 2, 0.0_wp, mesh)
      call element_space(mesh, space)
      call check_functions(tests, trim(elements(i)), mesh, space)
    end do
    do dimension = 2, 3
      do degree = 1, 3
        write (name, '(a,i0,a,i0,a)') 'degree ', degree, ' in ', dimension, 'D'
        call uneven_grid(dimension, mesh)
        call sample_space(mesh, degree, .false., space)
        call check_functions(tests, trim(name), mesh, space)
        call uneven_grid(dimension, mesh)
        call sample_space(mesh, degree, .false., space, footing)
        call check_functions(tests, trim(name)//' kinked', mesh, space)
        call check_constraints(tests, trim(name), mesh, space)
        call check_refresh(tests, trim(name), mesh, space)
      end do
      call check_hats(tests, dimension)
    end do
    call check_boxes(tests)
  end subroutine collect_space

  !> Places of a cell that lie in every kind of element, and one beyond it.
  pure function places(dimension) result(local)
    integer, intent(in) :: dimension
    real(wp) :: local(dimension, 4)
    real(wp), parameter :: table(3, 4) = reshape([0.1_wp, 0.2_wp, 0.3_wp, 0.5_wp, 0.1_wp, 0.15_wp, &
      0.0_wp, 0.0_wp, 0.0_wp, 1.2_wp, 0.1_wp, -0.3_wp], [3, 4])

    local = table(:dimension, :)
  end function places

  !> Sum, linear fields and gradients, from the positions of the nodes.
  subroutine check_functions(tests, name, mesh, space)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    real(wp) :: x(mesh%dimension, space%node_count), local(mesh%dimension, 4), ones(1, space%node_count)
    real(wp) :: sums, unit, gradients
    type(shape_values_type) :: place
    integer :: c, k, n, a, nodes(most_functions), count
    logical :: listed

    do n = 1, space%node_count
      x(:, n) = node_position(space, mesh, n)
    end do
    ones = 1.0_wp
    local = places(mesh%dimension)
    sums = 0.0_wp
    unit = 0.0_wp
    gradients = 0.0_wp
    listed = .true.
    do c = 1, mesh%cell_count
      call cell_nodes_of_space(space, mesh, c, nodes, count)
      do k = 1, size(local, 2)
        call functions_at(space, mesh, c, local(:, k), place)
        listed = listed .and. place%count == count .and. all(nodes(:count) == place%node(:count))
        sums = max(sums, abs(sum(place%shape(:place%count)) - 1.0_wp))
        do a = 1, mesh%dimension
          sums = max(sums, abs(sum(place%gradient(a, :place%count))))
          unit = max(unit, abs(dot_product(place%gradient(a, :place%count), &
            x(a, place%node(:place%count))) - 1.0_wp))
        end do
        gradients = max(gradients, gradient_error(mesh, space, c, local(:, k), x))
      end do
    end do
    call tests%close(name//': functions sum to one, gradients to nothing', sums, 0.0_wp, rounding)
    call tests%close(name//': positions of the nodes have a unit gradient', unit, 0.0_wp, rounding)
    call tests%close(name//': gradients are those of the functions', gradients, 0.0_wp, 1.0e-7_wp)
    call tests%check(name//': the nodes of a cell are those of its functions', listed)
    call functions_at(space, mesh, 1, local(:, 1), place)
    call tests%close(name//': a constant field has one value', maxval(abs(value_at(place, ones) - 1.0_wp)), &
      0.0_wp, rounding)
  end subroutine check_functions

  !> Gradients against central differences along the local coordinates: dN/dxi = J dN/dx with J by the
  !> difference of the place itself. The difference errs by h^2/6 of a third derivative (1e2) and by
  !> rounding/h, together below 1e-7 for h = 1e-5.
  function gradient_error(mesh, space, cell, local, x) result(worst)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    integer, intent(in) :: cell
    !> Local coordinates, and positions of all nodes.
    real(wp), intent(in) :: local(:), x(:, :)
    real(wp) :: worst
    real(wp), parameter :: h = 1.0e-5_wp
    real(wp) :: moved(size(local)), along(size(local))
    type(shape_values_type) :: place, above, below
    integer :: a, n

    worst = 0.0_wp
    call functions_at(space, mesh, cell, local, place)
    n = place%count
    do a = 1, size(local)
      moved = local
      moved(a) = local(a) + h
      call functions_at(space, mesh, cell, moved, above)
      moved(a) = local(a) - h
      call functions_at(space, mesh, cell, moved, below)
      along = (value_at(above, x) - value_at(below, x))/(2.0_wp*h)
      worst = max(worst, maxval(abs(matmul(along, place%gradient(:size(local), :n)) &
        - (above%shape(:n) - below%shape(:n))/(2.0_wp*h))))
    end do
  end function gradient_error

  !> A field that is zero on a constrained set and arbitrary elsewhere is zero on the footing, not
  !> beside it nor below.
  subroutine check_constraints(tests, name, mesh, space)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    real(wp) :: field(1, space%node_count), on, beside, below
    integer :: k

    do k = 1, space%node_count
      field(1, k) = 1.0_wp + 0.5_wp*sin(1.3_wp*k)
    end do
    field(1, space%sets(1)%items) = 0.0_wp
    on = 0.0_wp
    beside = huge(1.0_wp)
    below = huge(1.0_wp)
    do k = 1, 9
      on = max(on, abs(value(0.3_wp + 0.11_wp*k, 3.0_wp)))
      beside = min(beside, abs(value(1.4_wp + 0.05_wp*k, 3.0_wp)), abs(value(0.3_wp - 0.05_wp*k, 3.0_wp)))
      below = min(below, abs(value(0.3_wp + 0.11_wp*k, 2.9_wp)))
    end do
    call tests%close(name//': a held set holds all of its side', on, 0.0_wp, rounding)
    call tests%check(name//': and nothing beside it', beside > 1.0e-3_wp)
    call tests%check(name//': and nothing below it', below > 1.0e-3_wp)
    call tests%check(name//': kinks are the inner lines at the ends of the set', &
      count(space%axis(1)%knot_reduced) == 2 .and. space%axis(1)%knot_reduced(2) .and. &
        space%axis(1)%knot_reduced(4) .and. &
      count(space%axis(2)%knot_reduced) == 0)
  contains
    !> The field at a place.
    function value(x, y) result(u)
      real(wp), intent(in) :: x, y
      real(wp) :: u
      type(shape_values_type) :: place
      real(wp) :: local(mesh%dimension), at(3), of_field(1)
      integer :: cell

      at = [x, y, 0.8_wp]
      call owner_of(mesh, at(:mesh%dimension), cell, local)
      call functions_at(space, mesh, cell, local, place)
      of_field = value_at(place, field)
      u = of_field(1)
    end function value
  end subroutine check_constraints

  !> After the rows have moved, the functions belong to the new lines.
  subroutine check_refresh(tests, name, mesh, space)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(mesh_type), intent(inout) :: mesh
    type(space_type), intent(inout) :: space
    integer :: before

    before = space%node_count
    mesh%coordinates(2, :) = 0.7_wp*mesh%coordinates(2, :) + 0.1_wp
    call refresh_space(space, mesh)
    call tests%close(name//': lines follow the mesh', &
      maxval(abs(space%axis(2)%lines - 0.7_wp*lines_y - 0.1_wp)), 0.0_wp, rounding)
    call tests%close(name//': lines along the other axes stay', maxval(abs(space%axis(1)%lines - lines_x)), &
      0.0_wp, rounding)
    call tests%check(name//': kinks and number of nodes stay', space%node_count == before .and. &
      product(space%axis(:mesh%dimension)%function_count) == before .and. space%axis(1)%knot_reduced(4))
    call check_functions(tests, name//' moved', mesh, space)
  end subroutine check_refresh

  !> Splines of degree one are the functions of linear elements, with the same numbers.
  subroutine check_hats(tests, dimension)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    type(mesh_type) :: mesh
    type(space_type) :: splines, elements
    type(shape_values_type) :: one, two
    real(wp) :: local(dimension, 4), field(1, 210), worst(4)
    integer :: c, k, n
    character(len=3) :: name

    call uneven_grid(dimension, mesh)
    call sample_space(mesh, 1, .false., splines)
    call element_space(mesh, elements)
    local = places(dimension)
    worst = 0.0_wp
    do n = 1, mesh%node_count
      field(1, n) = sin(1.7_wp*n)
      worst(4) = max(worst(4), maxval(abs(node_position(splines, mesh, n) - mesh%coordinates(:, n))))
    end do
    do c = 1, mesh%cell_count
      do k = 1, size(local, 2)
        call functions_at(splines, mesh, c, local(:, k), one)
        call functions_at(elements, mesh, c, local(:, k), two)
        worst(1) = max(worst(1), maxval(abs(value_at(one, field) - value_at(two, field))))
        worst(2) = max(worst(2), maxval(abs( &
          matmul(one%gradient(:dimension, :one%count), field(1, one%node(:one%count))) &
          - matmul(two%gradient(:dimension, :two%count), field(1, two%node(:two%count))))))
        worst(3) = max(worst(3), abs(one%determinant - two%determinant))
      end do
    end do
    write (name, '(i0,a)') dimension, 'D:'
    call tests%check(name//' hats have the nodes of the mesh', splines%node_count == mesh%node_count)
    call tests%close(name//' hats give the values of linear elements', worst(1), 0.0_wp, rounding)
    call tests%close(name//' hats give the gradients of linear elements', worst(2), 0.0_wp, rounding)
    call tests%close(name//' hats give the determinant of linear elements', worst(3), 0.0_wp, rounding)
    call tests%close(name//' hats sit at the nodes of the mesh', worst(4), 0.0_wp, rounding)
    call tests%check(name//' cells are counted with x fastest', &
      all(place_of(8, splines%axis%cell_count) == [2, 2, 1]))
  end subroutine check_hats

  !> Which sets are boxes of grid nodes.
  subroutine check_boxes(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(space_type) :: space
    integer, parameter :: cells(3) = [6, 5, 1]
    integer :: i

    call uneven_grid(2, mesh)
    call add_set(mesh%node_sets, 'base', [(i, i=1, 7)])
    call add_set(mesh%node_sets, 'corner', [1, 2, 3, 8, 15])
    call add_set(mesh%node_sets, 'block', [1, 2, 8, 9])
    call add_set(mesh%node_sets, 'gap', [1, 3])
    call tests%check('a side is a box', is_structured(mesh, cells, 1))
    call tests%check('an angle is not', .not. is_structured(mesh, cells, 2))
    call tests%check('a block is a box', is_structured(mesh, cells, 3))
    call tests%check('nodes with one left out are not', .not. is_structured(mesh, cells, 4))
    call sample_space(mesh, 2, .false., space)
    call tests%check('the control points of a side are as many as functions along it', &
      size(space%sets(1)%items) == space%axis(1)%function_count)
    call tests%check('a set that is no box has no control points', size(space%sets(2)%items) == 0 .and. &
      size(space%sets(4)%items) == 0)
  end subroutine check_boxes

  !> True when a set of mesh nodes can carry constraints of a spline space.
  pure logical function is_structured(mesh, cells, set)
    type(mesh_type), intent(in) :: mesh
    !> Number of cells along each axis.
    integer, intent(in) :: cells(3)
    !> Number of the set.
    integer, intent(in) :: set
    integer :: low(3), high(3)

    call box_of_set(mesh, cells, set, low, high, is_structured)
  end function is_structured
end module test_space
