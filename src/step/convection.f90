!> Convective phase of a step (paper, section 3.3): the material points are updated with the displacement of the step,
!> the mesh is reset, and point location finds the cell of every point again.
!>
!> Every material point receives its own deformation gradient, stress and volume (eq. 28 as Omega det F; under the
!> uniform pressure of a group det F includes the volume change of the group), also where the equations were integrated
!> at Gauss points (qsmpm_soil_points). With BASIS=FEM the mesh moves with the material instead of being reset; the rows
!> of a moving mesh follow the plate or the rigid body.
module qsmpm_convection
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_error, only: error_type, fail, error_not_converged, error_tangled
  use qsmpm_active_bodies, only: bodies_active
  use qsmpm_method_description, only: basis_fem
  use qsmpm_integration, only: integration_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_sets, only: items_of
  use qsmpm_model, only: model_type, state_type
  use qsmpm_own_part, only: own_part_type, is_divided, own_of
  use qsmpm_initialisation, only: step_type
  use qsmpm_space, only: space_type, shape_values_type, functions_at, value_at, refresh_space
  use qsmpm_carried_basis, only: basis_at
  use qsmpm_contacts, only: bodies_at_end
  use qsmpm_deformation, only: grow_deformation, point_displacement
  use qsmpm_held_sides, only: keep_inside
  use qsmpm_penetration, only: refuse_penetration, put_back
  use qsmpm_points, only: carried_type, points_type
  use qsmpm_soil_points, only: soil_type, soil_of, find_point_results, take_point_results
  use qsmpm_surface_basis, only: turn_areas
  use qsmpm_point_location, only: activation_type, relocate
  use qsmpm_model_window, only: follow_material, reach_own
  use qsmpm_rigid_pose, only: placed_shape_type
  use qsmpm_moving_rows, only: scale_rows, carry_rows, least_jacobian
  implicit none
  private

  public :: convect, longest_move, move_points, update_in_place

  !> Number of points above which moving and updating them is distributed over threads.
  integer, parameter :: fewest_points = 50000
  !> Number of cells that remain between the rows that follow a body and the ends of a moving mesh.
  real(wp), parameter :: room = 1.0_wp

contains

  !> Updates everything that moves with the mesh, then resets the mesh. Stresses, states and volumes of the material
  !> points are updated last, when no further failure is possible.
  subroutine convect(model, step, displacement, error, most)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout), target :: step
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> A point that cannot be updated or has left the mesh, or a mesh with tangled elements.
    type(error_type), allocatable, intent(out) :: error
    !> Largest displacement with which points of excavated bodies move with the mesh.
    real(wp), intent(in), optional :: most
    type(soil_type), pointer :: soil
    integer, allocatable :: source(:)
    real(wp) :: areas(model%mesh%dimension, model%state%surface%count)

    soil => soil_of(step%terms)
    call find_point_results(soil, model, step%configuration_type, displacement, source, error)
    if (allocated(error)) return
    call turn_areas(model, step%configuration_type, displacement, areas)
    if (model%state%surface%count > 0) model%state%surface%area_vector(:, :size(areas, 2)) = areas
    associate (mesh => model%mesh, space => model%space, state => model%state)
      call move_carried(mesh, space, displacement, state%surface, activation=step%activation, points=state%points)
      call move_carried(mesh, space, displacement, state%tracers, .not. (of_inactive(model) .or. of_taken_out(model)) &
        .and. own_of(model%part%tracers, state%tracers%count), step%activation, state%points)
      call move_carried(mesh, space, displacement, state%watched, own_of(model%part%watched, state%watched%count), &
        step%activation, state%points)
      call move_inactive(model, step%activation, displacement, most)
      call move_points(step%at_points, displacement, state%points%position)
    end associate
    call refuse_penetration(model, bodies_at_end(step%terms), step%penetration, error)
    if (allocated(error)) return
    call put_back(model, bodies_at_end(step%terms))
    if (model%analysis%method%basis /= basis_fem) call keep_inside(model, displacement, step%crossing)
    if (model%analysis%method%basis == basis_fem) then
      call carry_mesh(step%activation, displacement, model%mesh, model%state%coordinates, error)
    else
      if (model%analysis%moving_mesh%by_body) then
        call follow_body(model, bodies_at_end(step%terms), error)
      else if (model%analysis%moving_mesh%active) then
        call move_rows(model, displacement)
      end if
      if (.not. allocated(error)) then
        if (is_divided(model%part)) then
          call reach_own(model)
        else
          call follow_material(model)
        end if
      end if
      if (.not. allocated(error)) call find_again(model%mesh, model%cell_size, model%part, model%state, error)
    end if
    if (allocated(error)) return
    call take_point_results(soil, source, model%laws, model%state%points)
    if (size(model%state%points%deformation_gradient, 2) > 0) call grow_deformation(step%at_points, displacement, &
      model%state%points%deformation_gradient)
  end subroutine convect

  !> Updates stresses and states only. Positions do not change; points other than material points (springs of supports,
  !> histories) accumulate the displacement by shifting their initial position backwards, except where a run-out
  !> analysis follows, whose points move on.
  subroutine update_in_place(model, step, displacement, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout), target :: step
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> A point that cannot be updated.
    type(error_type), allocatable, intent(out) :: error
    type(soil_type), pointer :: soil
    integer, allocatable :: source(:)
    real(wp) :: volume(model%state%points%count)

    soil => soil_of(step%terms)
    call find_point_results(soil, model, step%configuration_type, displacement, source, error)
    if (allocated(error)) return
    step%crossing = 0.0_wp
    associate (state => model%state)
      call draw_back(model%mesh, model%space, step%activation, state%points, displacement, spread(.true., 1, &
        state%surface%count), state%surface)
      if (.not. model%analysis%phases(state%progress%phase)%safety%runout < huge(1.0_wp)) call draw_back(model%mesh, &
        model%space, step%activation, state%points, displacement, own_of(model%part%tracers, state%tracers%count), &
        state%tracers)
    end associate
    volume = model%state%points%volume
    call take_point_results(soil, source, model%laws, model%state%points)
    model%state%points%volume = volume
  end subroutine update_in_place

  !> Shifts initial positions backwards by a displacement.
  subroutine draw_back(mesh, space, activation, points, displacement, chosen, carried)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(activation_type), intent(in) :: activation
    type(points_type), intent(in) :: points
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Selection of the points.
    logical, intent(in) :: chosen(:)
    class(carried_type), intent(inout) :: carried
    type(shape_values_type) :: place
    integer :: i

    do i = 1, carried%count
      if (.not. chosen(i) .or. carried%cell(i) == 0) cycle
      call basis_at(mesh, space, activation, points, carried, i, place)
      carried%initial_position(:, i) = carried%initial_position(:, i) - value_at(place, displacement)
    end do
  end subroutine draw_back

  !> Moves material points.
  subroutine move_points(at_points, displacement, position)
    !> Basis at the material points.
    type(integration_type), intent(in) :: at_points
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> (dimension, points)
    real(wp), intent(inout) :: position(:, :)
    real(wp) :: u(3)
    integer :: g, q, p, d

    d = size(position, 1)
    !$omp parallel do default(shared) private(q, p, u) if (at_points%point_count >= fewest_points)
    do g = 1, at_points%group_count
      do q = at_points%first(g), at_points%first(g + 1) - 1
        p = at_points%source(q)
        u = point_displacement(at_points, displacement, g, q)
        position(:, p) = position(:, p) + u(:d)
      end do
    end do
    !$omp end parallel do
  end subroutine move_points

  !> Largest displacement of the material points of this process.
  pure real(wp) function longest_move(at_points, displacement) result(longest)
    !> Basis at the material points.
    type(integration_type), intent(in) :: at_points
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    integer :: g, q

    longest = 0.0_wp
    do g = 1, at_points%group_count
      do q = at_points%first(g), at_points%first(g + 1) - 1
        longest = max(longest, norm2(point_displacement(at_points, displacement, g, q)))
      end do
    end do
  end function longest_move

  !> Moves points other than material points, with the functions that the soil has there or, without `points`, with
  !> those of the point's own cells regardless of what else uses these cells.
  subroutine move_carried(mesh, space, displacement, carried, chosen, activation, points, most)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    class(carried_type), intent(inout) :: carried
    !> Selection of the points; all when absent.
    logical, intent(in), optional :: chosen(:)
    type(activation_type), intent(in), optional :: activation
    type(points_type), intent(in), optional :: points
    !> Upper bound of the displacement applied.
    real(wp), intent(in), optional :: most
    type(shape_values_type) :: place
    real(wp) :: u(size(displacement, 1))
    integer :: i

    do i = 1, carried%count
      if (present(chosen)) then
        if (.not. chosen(i) .or. carried%cell(i) == 0) cycle
      end if
      if (present(points)) then
        call basis_at(mesh, space, activation, points, carried, i, place)
      else
        call functions_at(space, mesh, carried%cell(i), carried%local(:, i), place)
      end if
      u = value_at(place, displacement)
      if (present(most)) then
        if (norm2(u) > most) u = u*(most/norm2(u))
      end if
      carried%position(:, i) = carried%position(:, i) + u
    end do
  end subroutine move_carried

  !> Moves points of bodies that are not active: their feet (base points) with the soil they rest on; excavated bodies
  !> with the mesh, which does not move where nothing loads it, and at most by the largest displacement of the soil,
  !> because functions supported by nearly no soil may take large values. Other inactive bodies do not move.
  subroutine move_inactive(model, activation, displacement, most)
    type(model_type), intent(inout) :: model
    type(activation_type), intent(in) :: activation
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Largest displacement of the soil.
    real(wp), intent(in), optional :: most

    associate (mesh => model%mesh, space => model%space, state => model%state)
      if (state%inactive%feet%count > 0) call move_carried(mesh, space, displacement, state%inactive%feet, &
        any(model%feet%on .and. spread(bodies_active(model%analysis, state%progress%phase), 2, &
        state%inactive%feet%count), dim=1) .and. own_of(model%part%feet, state%inactive%feet%count), activation, &
        state%points)
      call move_carried(mesh, space, displacement, state%inactive%unloading, most=most)
      call move_carried(mesh, space, displacement, state%inactive%unloading_surface, most=most)
      call move_carried(mesh, space, displacement, state%tracers, of_taken_out(model) .and. &
        own_of(model%part%tracers, state%tracers%count), most=most)
    end associate
  end subroutine move_inactive

  !> Returns the tracers of bodies that are not active.
  pure function of_inactive(model) result(chosen)
    type(model_type), intent(in) :: model
    logical :: chosen(model%state%tracers%count)

    chosen = .false.
    if (.not. allocated(model%tracer_body)) return
    associate (active => bodies_active(model%analysis, model%state%progress%phase))
      chosen = .not. active(model%tracer_body)
    end associate
  end function of_inactive

  !> Returns the tracers of bodies that are being excavated.
  pure function of_taken_out(model) result(chosen)
    type(model_type), intent(in) :: model
    logical :: chosen(model%state%tracers%count)
    integer :: i

    chosen = .false.
    if (.not. allocated(model%tracer_body)) return
    if (allocated(model%part%taken_out)) then
      chosen = model%part%taken_out(model%tracer_body)
      return
    end if
    do i = 1, size(chosen)
      chosen(i) = any(model%state%inactive%unloading%body == model%tracer_body(i))
    end do
  end function of_taken_out

  !> Updated Lagrangian FEM: the nodes retain their displacement; points retain their local coordinates.
  subroutine carry_mesh(activation, displacement, mesh, coordinates, error)
    type(activation_type), intent(in) :: activation
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    type(mesh_type), intent(inout) :: mesh
    !> Coordinates stored in the state; unchanged on error (dimension, node_count).
    real(wp), intent(inout) :: coordinates(:, :)
    !> An element is tangled.
    type(error_type), allocatable, intent(out) :: error
    character(len=100) :: text
    integer :: k, c

    mesh%coordinates = mesh%coordinates + displacement
    do k = 1, activation%active_count
      c = activation%active_cell(k)
      if (least_jacobian(mesh, mesh%coordinates, c) > 0.0_wp) cycle
      write (text, '(a,i0,a)') 'the mesh is tangled: element ', mesh%cell_label(c), ' has turned inside out'
      call fail(error, error_tangled, trim(text))
      return
    end do
    coordinates = mesh%coordinates
  end subroutine carry_mesh

  !> Moves the rows of a moving mesh with the plate: updates the mesh, the space and the corresponding data of the
  !> state.
  subroutine move_rows(model, displacement)
    type(model_type), intent(inout) :: model
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    real(wp) :: plate_move

    plate_move = plate_displacement(model, displacement)
    call scale_rows(model%mesh, model%analysis%moving_mesh%axis, model%analysis%moving_mesh%base, &
      model%state%plate, model%state%plate + plate_move)
    model%state%plate = model%state%plate + plate_move
    model%state%coordinates = model%mesh%coordinates
    call refresh_space(model%space, model%mesh)
  end subroutine move_rows

  !> Moves the rows of a moving mesh with a rigid body as long as there are enough cells ahead of it.
  subroutine follow_body(model, bodies, error)
    type(model_type), intent(inout) :: model
    !> Bodies at their position at the end of the step.
    type(placed_shape_type), intent(in) :: bodies(:)
    !> error_not_converged: too few cells remain.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: place

    associate (moving => model%analysis%moving_mesh, body => bodies(place_named(model%analysis%rigid_bodies, &
        model%analysis%moving_mesh%body)), bounds => model%mesh%bounds)
      place = body%reference(moving%axis) + body%pose%displacement(moving%axis)
      if (place - moving%near < bounds(moving%axis, 1) + room*model%cell_size .or. &
        place + moving%near > bounds(moving%axis, 2) - room*model%cell_size) then
        call fail(error, error_not_converged, "rigid body '"//moving%body//"' is within NEAR of *MOVING MESH "// &
          'from the end of the grid: use a larger grid, a smaller NEAR or a shorter displacement')
        return
      end if
      call carry_rows(model%mesh, moving%axis, model%state%plate, moving%near, place - model%state%plate)
      model%state%plate = place
    end associate
    model%state%coordinates = model%mesh%coordinates
    call refresh_space(model%space, model%mesh)
  end subroutine follow_body

  !> Returns the mean displacement of the plate along the axis of the moving mesh.
  real(wp) function plate_displacement(model, displacement) result(move)
    type(model_type), intent(in) :: model
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)

    associate (moving => model%analysis%moving_mesh, &
        nodes => items_of(model%space%sets, model%analysis%moving_mesh%set))
      move = sum(displacement(moving%axis, nodes))/size(nodes)
    end associate
  end function plate_displacement

  !> Point location: finds the cells of all points that this process owns.
  subroutine find_again(mesh, cell_size, part, state, error)
    type(mesh_type), intent(in) :: mesh
    real(wp), intent(in) :: cell_size
    type(own_part_type), intent(in) :: part
    type(state_type), intent(inout) :: state
    !> A point has left the mesh.
    type(error_type), allocatable, intent(out) :: error

    call find(state%points, 'material point', part%points)
    call find(state%surface, 'surface point', part%surface)
    call find(state%tracers, 'tracer', part%tracers)
    call find(state%watched, 'material in front of a prescribed set', part%watched)
    call find(state%inactive%points, 'material point that is not there')
    call find(state%inactive%unloading, 'material point that is taken out', part%unloading)
    call find(state%inactive%surface, 'surface point that is not there')
    call find(state%inactive%unloading_surface, 'surface point that is taken out', part%unloading_surface)
    call find(state%inactive%feet, 'place under a body that comes', part%feet)

  contains

    !> Finds the cells of one set of points, unless an earlier set has left the mesh.
    subroutine find(carried, name, own)
      class(carried_type), intent(inout) :: carried
      character(len=*), intent(in) :: name
      logical, intent(in), optional :: own(:)

      if (allocated(error)) return
      ! Points without a cell belong to inactive bodies outside of the part of the grid that this process stores.
      if (present(own)) then
        call relocate(mesh, cell_size, carried, name, error, own .and. carried%cell > 0)
      else
        call relocate(mesh, cell_size, carried, name, error)
      end if
    end subroutine find
  end subroutine find_again
end module qsmpm_convection
