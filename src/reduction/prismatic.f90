!> Reduction of a 3D scene that is independent of z and fixed along z at both ends to plane strain, and of a plane scene
!> of horizontal layers to a single column.
!>
!> Plane strain requires `require_uniform`, and elements in layers (bricks, wedges). The plane element is the face of
!> the brick or wedge, its points are those of one layer; forces and work of the scene are those of the model times the
!> thickness.
!>
!> A plane scene of horizontal layers between rollers, under loads independent of x, is reduced to a single column of
!> cells. It requires `require_uniform` along x, and rectangles with unshifted nodes: then the columns of the grid are
!> all alike and each supports its own width of the load. Triangles are skewed to one side, so that the columns at the
!> ends differ and the scene is not reduced.
!>
!> `require_uniform` checks that a scene is independent of an axis and cannot move along it: bodies, supports, loads and
!> mesh are constant along the axis, and both end planes are fixed along it. Then u = u(other axes), u_axis = 0 is a
!> solution of the discretised equations for every element whose functions and points repeat along the axis: nodal
!> forces are those of the smaller model times the length of the node. Dependence on the axis is checked card by card,
!> the fixities of the end planes node by node for every phase.
module qsmpm_prismatic
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: three_dimensional, plane_strain
  use qsmpm_history_description, only: quantity_displacement, quantity_position, quantity_stress, quantity_reaction, &
    quantity_strain, quantity_volume
  use qsmpm_load_description, only: fixity_type
  use qsmpm_method_description, only: basis_fem
  use qsmpm_element, only: element_from_name, seed_rule, full_rule
  use qsmpm_error, only: error_type
  use qsmpm_history_quantities, only: is_taken_at, has_components, at_body, at_rigid_body, component_vector
  use qsmpm_reduction, only: reduction_type, layers_type, reduce_prismatic, begin_reduction, reduce_column
  use qsmpm_loaded_surfaces, only: drop_unused, require_level_water, require_loads_uniform
  use qsmpm_rigid_symmetry, only: flatten_rigid_bodies, reduce_rigid_history, require_rigid_uniform
  use qsmpm_examined_scene, only: examined_type, card, place_text, refuse, covers_axis, require_local_histories, &
    members_type, keep_supports, letters, refuse_mesh, representatives, node_state
  use qsmpm_body_description, only: body_all, body_box, body_polygon
  use qsmpm_mesh_description, only: mesh_grid, select_list
  implicit none
  private

  public :: require_prismatic, make_plane, require_column, make_column, require_uniform

  !> Names of the sets of the two sides, which a deck cannot define without quotes.
  character(len=*), parameter :: side_names(2) = ['=first side', '=last side ']

contains

  !> Checks that a scene is independent of the axis and fixed at both ends.
  pure subroutine require_uniform(scene)
    type(examined_type), intent(inout) :: scene

    if (scene%mesh%kind /= mesh_grid) then
      call refuse_mesh(scene)
      return
    end if
    call require_bodies(scene)
    call require_sets(scene)
    call require_loads_uniform(scene)
    call require_rigid_uniform(scene)
    call require_plate(scene)
    if (.not. allocated(scene%reason)) call require_held(scene)
  end subroutine require_uniform

  !> Checks that bodies extend through the whole grid along the axis.
  pure subroutine require_bodies(scene)
    type(examined_type), intent(inout) :: scene
    real(wp) :: first, last
    logical :: whole
    integer :: b

    associate (lines => scene%mesh%axes(scene%axis)%lines)
      first = lines(1) + scene%nothing
      last = lines(size(lines)) - scene%nothing
    end associate
    do b = 1, size(scene%bodies)
      associate (body => scene%bodies(b))
        select case (body%kind)
        case (body_all)
          whole = .true.
        case (body_box)
          whole = body%box(scene%axis, 1) <= first .and. body%box(scene%axis, 2) >= last
        case (body_polygon)
          whole = scene%axis == 3
          if (scene%axis == 1) whole = is_layer(body%polygon, first, last, scene%nothing)
        case default
          whole = .false.
        end select
        if (.not. whole) call refuse(scene, card('*BODY', body%name, body%where)//' depends on '//letters(scene%axis))
      end associate
    end do
  end subroutine require_bodies

  !> Checks whether a polygon is a layer over the whole width: edges within it are horizontal.
  pure logical function is_layer(polygon, first, last, tolerance)
    !> Vertices (2,n).
    real(wp), intent(in) :: polygon(:, :)
    !> The sides, and the tolerance of lengths.
    real(wp), intent(in) :: first, last, tolerance
    integer :: i, k
    logical :: left(2), right(2)

    is_layer = .true.
    do i = 1, size(polygon, 2)
      k = mod(i, size(polygon, 2)) + 1
      left = polygon(1, [i, k]) <= first
      right = polygon(1, [i, k]) >= last
      is_layer = is_layer .and. all(left .or. right) .and. (all(left) .or. all(right) .or. &
        abs(polygon(2, i) - polygon(2, k)) <= tolerance)
    end do
  end function is_layer

  !> Checks that sets that depend on the axis only fix it, and that no displacement is prescribed along it.
  pure subroutine require_sets(scene)
    type(examined_type), intent(inout) :: scene
    logical :: only(3)
    integer :: p, i, s

    only = .false.
    only(scene%axis) = .true.
    do p = 1, size(scene%phases)
      do i = 1, size(scene%phases(p)%fixities)
        associate (fixity => scene%phases(p)%fixities(i))
          s = place_named(scene%node_sets, fixity%set)
          if (scene%node_sets(s)%selection == select_list) &
            call refuse(scene, card('*NSET', fixity%set, scene%node_sets(s)%where)//' is a list of labels')
          if (.not. covers_axis(scene%members, s, scene%axis) .and. any(fixity%fixed .neqv. only)) &
            call refuse(scene, card('*FIX of', fixity%set, fixity%where)//' depends on '//letters(scene%axis))
        end associate
      end do
      do i = 1, size(scene%phases(p)%prescriptions)
        associate (prescription => scene%phases(p)%prescriptions(i))
          s = place_named(scene%node_sets, prescription%set)
          if (.not. covers_axis(scene%members, s, scene%axis)) call refuse(scene, card('*PRESCRIBE of', &
            prescription%set, prescription%where)//' depends on '//letters(scene%axis))
          if (prescription%component == scene%axis .and. abs(prescription%value) > 0.0_wp) &
            call refuse(scene, card('*PRESCRIBE of', prescription%set, prescription%where)//' moves along '// &
            letters(scene%axis))
        end associate
      end do
    end do
  end subroutine require_sets

  !> Checks that the plate of a moving mesh moves along another axis and is independent of this one.
  pure subroutine require_plate(scene)
    type(examined_type), intent(inout) :: scene
    logical :: along

    associate (moving => scene%moving_mesh)
      if (.not. moving%active) return
      along = moving%axis == scene%axis
      if (.not. (along .or. moving%by_body)) &
        along = .not. covers_axis(scene%members, place_named(scene%node_sets, moving%set), scene%axis)
      if (along) call refuse(scene, '*MOVING MESH'//place_text(moving%where)//' depends on '//letters(scene%axis))
    end associate
  end subroutine require_plate

  !> Checks that both end planes are fixed along the axis in every phase. In a grid with shifted nodes only sets of
  !> whole planes count, and nothing may be released.
  pure subroutine require_held(scene)
    type(examined_type), intent(inout) :: scene
    type(members_type) :: table
    integer, allocatable :: along(:), across(:)
    integer :: others(2), node(3), p, i, k, side, s
    logical :: fixed(3)
    real(wp) :: value(3)

    others = pack([1, 2, 3], [1, 2, 3] /= scene%axis)
    table = scene%members
    if (scene%mesh%perturbation > 0.0_wp) then
      do s = 1, size(scene%node_sets)
        if (covers_axis(scene%members, s, others(1)) .and. covers_axis(scene%members, s, others(2))) cycle
        table%axis(others(1))%holds(:, s) = .false.
      end do
      ! No set is released.
      do p = 1, size(scene%phases)
        do i = 1, size(scene%phases(p)%fixities)
          associate (fixity => scene%phases(p)%fixities(i))
            if (.not. any(fixity%fixed)) call refuse(scene, card('*FIX frees', fixity%set, fixity%where)// &
              ' in a grid of shifted nodes')
          end associate
        end do
      end do
    end if
    call representatives(table, others(1), .false., along)
    call representatives(table, others(2), .false., across)
    do p = 1, size(scene%phases)
      do i = 1, size(along)
        do k = 1, size(across)
          node(others) = [along(i), across(k)]
          do side = 1, 2
            node(scene%axis) = merge(1, table%count(scene%axis), side == 1)
            call node_state(scene, table, node, p, fixed, value)
            if (.not. fixed(scene%axis)) call refuse(scene, 'the '//trim(merge('first', 'last ', side == 1))// &
              ' plane across '//letters(scene%axis)//' is not held along '//letters(scene%axis)//card(' in phase', &
              scene%phases(p)%name, scene%phases(p)%where))
          end do
        end do
      end do
    end do
  end subroutine require_held

  !> Checks that a scene is prismatic along z.
  pure subroutine require_prismatic(scene)
    type(examined_type), intent(inout) :: scene
    integer :: b
    type(reduction_type) :: step
    logical :: known

    if (scene%model /= three_dimensional) then
      call refuse(scene, 'the scene is plane already')
      return
    end if
    call require_uniform(scene)
    if (allocated(scene%reason)) return
    if (len(plane_element(scene%mesh%element)) == 0) then
      call refuse(scene, 'the tetrahedra of *GRID'//place_text(scene%mesh%where)//' do not lie in layers along z')
      return
    end if
    call require_histories(scene)
    do b = 1, size(scene%bodies)
      call find_layers(scene, scene%bodies(b)%points_per_element, step, known)
      ! Unknown numbers of points are reported by the reader; here the scene is just not reduced.
      if (.not. known) call refuse(scene, card('*BODY', scene%bodies(b)%name, scene%bodies(b)%where)// &
        ': there is no such number of points per element')
    end do
  end subroutine require_prismatic

  !> Returns the plane element that is the base of a brick or wedge, empty for a tetrahedron.
  pure function plane_element(element) result(name)
    !> Element name.
    character(len=*), intent(in) :: element
    character(len=:), allocatable :: name

    select case (element)
    case ('HEX8')
      name = 'QUAD4'
    case ('HEX20')
      name = 'QUAD8'
    case ('WEDGE6')
      name = 'TRI3'
    case ('WEDGE15')
      name = 'TRI6'
    case default
      name = ''
    end select
  end function plane_element

  !> Checks that histories are within the thickness, and that reactions can be obtained from the plane.
  pure subroutine require_histories(scene)
    type(examined_type), intent(inout) :: scene
    integer :: i, s

    do i = 1, size(scene%histories)
      associate (history => scene%histories(i), lines => scene%mesh%axes(3)%lines)
        if (is_taken_at(history%quantity, at_rigid_body)) cycle
        if (is_taken_at(history%quantity, at_body) .or. len(history%surface) > 0) then
          if (has_components(history%quantity, component_vector) .and. history%component == 3) &
            call refuse(scene, card('*HISTORY', history%name, history%where)//' reads a component along z')
        else if (history%quantity == quantity_reaction) then
          s = place_named(scene%node_sets, history%set)
          if (.not. covers_axis(scene%members, s, 3)) call refuse(scene, card('*HISTORY', history%name, &
            history%where)//" reads a reaction of '"//history%set//"', which depends on z")
          if (history%component == 3) &
            call refuse(scene, card('*HISTORY', history%name, history%where)//' reads a reaction along z')
        else if (history%at(3) < lines(1) - scene%nothing .or. history%at(3) > lines(size(lines)) + scene%nothing) then
          call refuse(scene, card('*HISTORY', history%name, history%where)//' is outside the grid')
        end if
      end associate
    end do
  end subroutine require_histories

  !> Makes the plane model of a prismatic scene and its expansion.
  pure subroutine make_plane(scene, step)
    !> The scene, checked to be prismatic; on return the model.
    type(examined_type), intent(inout) :: scene
    !> Expansion step.
    type(reduction_type), intent(out) :: step
    logical :: known
    integer :: b, s

    call begin_reduction(scene, reduce_prismatic, 3, step)
    associate (lines => scene%mesh%axes(3)%lines)
      step%factor = lines(size(lines)) - lines(1)
    end associate
    allocate (step%layers(size(scene%bodies)))
    do b = 1, size(scene%bodies)
      associate (body => scene%bodies(b))
        call find_layers(scene, body%points_per_element, step, known, b)
        body%points_per_element = plane_points(scene, body%points_per_element)
        body%box(3, :) = 0.0_wp
      end associate
    end do
    call plane_histories(scene, step)
    call plane_supports(scene)
    call flatten_rigid_bodies(scene, [3], step%factor)
    call drop_unused(scene)
    do s = 1, size(scene%node_sets)
      scene%node_sets(s)%box(3, :) = 0.0_wp
    end do
    do s = 1, size(scene%surfaces)
      scene%surfaces(s)%box(3, :) = 0.0_wp
    end do
    scene%mesh%element = plane_element(scene%mesh%element)
    deallocate (scene%mesh%axes(3)%lines)
    scene%model = plane_strain
  end subroutine make_plane

  !> Returns the rule that places the points of an element in 3D.
  pure subroutine solid_rule(scene, count, places, weights, known)
    !> The scene in 3D.
    type(examined_type), intent(in) :: scene
    !> Points per element, 0 for the default.
    integer, intent(in) :: count
    !> Local coordinates (3, n) and weights (n).
    real(wp), allocatable, intent(out) :: places(:, :), weights(:)
    !> Such a rule exists.
    logical, intent(out) :: known
    type(error_type), allocatable :: error

    known = .true.
    if (scene%method%basis == basis_fem .and. count == 0) then
      call full_rule(element_from_name(scene%mesh%element), places, weights)
    else
      call seed_rule(element_from_name(scene%mesh%element), count, scene%method%basis == basis_fem, places, weights, &
        error)
      known = .not. allocated(error)
    end if
  end subroutine solid_rule

  !> Finds the layers of the points of an element, which have equal local z.
  pure subroutine find_layers(scene, count, step, known, body)
    !> The scene in 3D.
    type(examined_type), intent(in) :: scene
    !> Points per element, 0 for the default.
    integer, intent(in) :: count
    !> Receives the layers of the body.
    type(reduction_type), intent(inout) :: step
    !> Such a number of points exists.
    logical, intent(out) :: known
    !> Number of the body; without it only `known` is determined.
    integer, intent(in), optional :: body
    real(wp), allocatable :: places(:, :), weights(:)
    integer :: q, n, layers

    call solid_rule(scene, count, places, weights, known)
    if (.not. known .or. .not. present(body)) return
    n = points_in_layer(places)
    layers = size(weights)/n
    associate (layer => step%layers(body))
      allocate (layer%place(layers), layer%share(layers))
      do q = 1, layers
        layer%place(q) = 0.5_wp*(1.0_wp + places(3, (q - 1)*n + 1))
        layer%share(q) = sum(weights((q - 1)*n + 1:q*n))/sum(weights)
      end do
    end associate
  end subroutine find_layers

  !> Number of points of the first layer of a rule, before local z changes.
  pure integer function points_in_layer(places) result(n)
    !> Local coordinates (3, n), layer after layer.
    real(wp), intent(in) :: places(:, :)

    n = count(abs(places(3, :) - places(3, 1)) < 1.0e-6_wp)
  end function points_in_layer

  !> Points per element of the plane model; 0 for the Gauss rule of FEM.
  pure integer function plane_points(scene, count) result(n)
    !> The scene in 3D.
    type(examined_type), intent(in) :: scene
    !> Points per element, 0 for the default.
    integer, intent(in) :: count
    real(wp), allocatable :: places(:, :), weights(:)
    logical :: known

    n = 0
    if (scene%method%basis == basis_fem .and. count == 0) return
    call solid_rule(scene, count, places, weights, known)
    n = points_in_layer(places)
  end function plane_points

  !> Converts histories to the plane; z components are zero.
  pure subroutine plane_histories(scene, step)
    type(examined_type), intent(inout) :: scene
    !> Receives the expansion.
    type(reduction_type), intent(inout) :: step
    integer :: i

    do i = 1, size(scene%histories)
      associate (history => scene%histories(i))
        select case (history%quantity)
        case (quantity_displacement, quantity_position)
          if (history%component == 3) then
            step%history_factor(i) = 0.0_wp
            if (history%quantity == quantity_position) step%history_offset(i) = history%at(3)
            history%component = 1
          end if
        case (quantity_stress, quantity_strain)
          if (history%component > 4) then
            step%history_factor(i) = 0.0_wp
            history%component = 4
          end if
        case (quantity_reaction, quantity_volume)
          step%history_factor(i) = step%factor
        end select
        call reduce_rigid_history(history, [3], step%factor, step%history_factor(i))
        history%at(3) = 0.0_wp
      end associate
    end do
  end subroutine plane_histories

  !> Converts fixities and prescriptions to the plane: those only along z are removed.
  pure subroutine plane_supports(scene)
    type(examined_type), intent(inout) :: scene
    type(fixity_type), allocatable :: fixities(:)
    integer :: p, i

    do p = 1, size(scene%phases)
      associate (phase => scene%phases(p))
        allocate (fixities(0))
        do i = 1, size(phase%fixities)
          if (phase%fixities(i)%fixed(3) .and. .not. any(phase%fixities(i)%fixed(:2))) cycle
          fixities = [fixities, phase%fixities(i)]
          fixities(size(fixities))%fixed(3) = .false.
        end do
        phase%prescriptions = phase%prescriptions(pack([(i, i=1, size(phase%prescriptions))], &
          phase%prescriptions%component /= 3))
        call move_alloc(fixities, phase%fixities)
      end associate
    end do
  end subroutine plane_supports

  !> Checks that a scene is a row of equal columns.
  pure subroutine require_column(scene)
    type(examined_type), intent(inout) :: scene

    if (scene%model == three_dimensional) then
      call refuse(scene, 'the scene depends on z')
      return
    end if
    call require_uniform(scene)
    if (.not. allocated(scene%reason)) call require_level_water(scene)
    if (allocated(scene%reason)) return
    if (size(scene%mesh%axes(1)%lines) <= 2) then
      call refuse(scene, 'the grid is one cell wide already')
    else if (index(scene%mesh%element, 'QUAD') /= 1) then
      call refuse(scene, 'the triangles of *GRID'//place_text(scene%mesh%where)// &
        ' make columns that are not alike (QUAD4 and QUAD8 do)')
    else if (scene%mesh%perturbation > 0.0_wp) then
      call refuse(scene, 'the nodes of *GRID'//place_text(scene%mesh%where)//' are shifted')
    else
      call require_column_histories(scene)
    end if
  end subroutine require_column

  !> Checks that histories are inside the grid, and that reactions are those of a horizontal set, or along x at a side.
  pure subroutine require_column_histories(scene)
    type(examined_type), intent(inout) :: scene
    integer :: i, s
    logical :: whole

    call require_local_histories(scene)
    if (allocated(scene%reason)) return
    do i = 1, size(scene%histories)
      associate (history => scene%histories(i), lines => scene%mesh%axes(1)%lines)
        if (history%quantity == quantity_reaction) then
          s = place_named(scene%node_sets, history%set)
          whole = covers_axis(scene%members, s, 1)
          if (.not. whole .and. (history%component /= 1 .or. side_of(scene%members, s) == 0)) &
            call refuse(scene, card('*HISTORY', history%name, history%where)//" reads a reaction of '"//history%set// &
            "', which depends on x")
        else if (history%at(1) < lines(1) - scene%nothing .or. history%at(1) > lines(size(lines)) + scene%nothing) then
          call refuse(scene, card('*HISTORY', history%name, history%where)//' is outside the grid')
        end if
      end associate
    end do
  end subroutine require_column_histories

  !> Side of a set: 1 the first line, 2 the last line, 0 neither.
  pure integer function side_of(members, set) result(side)
    type(members_type), intent(in) :: members
    !> Number of the set.
    integer, intent(in) :: set

    side = 0
    associate (holds => members%axis(1)%holds(:, set))
      if (count(holds) /= 1) return
      if (holds(1)) side = 1
      if (holds(size(holds))) side = 2
    end associate
  end function side_of

  !> Makes one column of a scene of equal columns and its expansion.
  pure subroutine make_column(scene, step)
    !> The scene, checked to be a row of equal columns; on return the column.
    type(examined_type), intent(inout) :: scene
    !> Expansion step.
    type(reduction_type), intent(out) :: step
    integer :: s

    call begin_reduction(scene, reduce_column, 1, step)
    ! The points of the column are those of one interval of its lines.
    allocate (step%layers(size(scene%bodies)))
    do s = 1, size(scene%bodies)
      step%layers(s) = layers_type([0.0_wp], [1.0_wp])
    end do
    associate (lines => scene%mesh%axes(1)%lines)
      step%factor = (lines(size(lines)) - lines(1))/(lines(2) - lines(1))
    end associate
    call column_histories(scene, step)
    call flatten_rigid_bodies(scene, [1], step%factor)
    ! Sides that are released are fixed again, as checked.
    call keep_supports(scene, [(covers_axis(scene%members, s, 1), s=1, size(scene%node_sets))], 1, &
      scene%mesh%axes(1)%lines(:2), side_names)
    ! Sets on a side that are used by a history move with the side.
    do s = 1, size(scene%members%axis(1)%holds, 2)
      if (side_of(scene%members, s) == 0) cycle
      scene%node_sets(s)%box(1, :) = scene%mesh%axes(1)%lines(side_of(scene%members, s))
    end do
    call drop_unused(scene)
    scene%bodies%copies = step%factor*scene%bodies%copies
    scene%mesh%axes(1)%lines = scene%mesh%axes(1)%lines(:2)
  end subroutine make_column

  !> Converts histories to the column: nothing moves along x.
  pure subroutine column_histories(scene, step)
    type(examined_type), intent(inout) :: scene
    !> Receives the expansion.
    type(reduction_type), intent(inout) :: step
    integer :: i

    do i = 1, size(scene%histories)
      associate (history => scene%histories(i))
        select case (history%quantity)
        case (quantity_displacement)
          if (history%component == 1) step%history_factor(i) = 0.0_wp
        case (quantity_position)
          if (history%component == 1) step%history_factor(i) = 0.0_wp
          if (history%component == 1) step%history_offset(i) = history%at(1)
        case (quantity_reaction)
          if (covers_axis(scene%members, place_named(scene%node_sets, history%set), 1)) &
            step%history_factor(i) = merge(0.0_wp, step%factor, history%component == 1)
        end select
        call reduce_rigid_history(history, [1], step%factor, step%history_factor(i))
        if (history%quantity /= quantity_reaction) history%at(1) = in_first(scene%mesh%axes(1)%lines, history%at(1))
      end associate
    end do
  end subroutine column_histories

  !> Place in the first cell that corresponds to a place in any cell.
  pure real(wp) function in_first(lines, x)
    !> Lines along x; the place.
    real(wp), intent(in) :: lines(:), x
    integer :: i

    i = max(1, min(size(lines) - 1, count(lines <= x)))
    in_first = lines(1) + (lines(2) - lines(1))*(x - lines(i))/(lines(i + 1) - lines(i))
    in_first = max(lines(1), min(lines(2), in_first))
  end function in_first
end module qsmpm_prismatic
