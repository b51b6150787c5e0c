!> The convective phase (paper, section 3.3): the material points are updated by the displacement of
!> the step, the mesh is reset, and house-keeping finds the points again.
!>
!> Every material point gets its own deformation gradient, stress and volume (eq. 28 as
!> Omega det F; under the pressure of a group det F includes the volume change found there), also
!> where the equations were integrated at Gauss points. With BASIS=FEM the mesh
!> is carried along instead of being reset; with a moving mesh its rows follow the plate.
module qsmpm_convection
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_not_converged
  use qsmpm_analysis, only: basis_fem, integrate_cells
  use qsmpm_law, only: tangent_none
  use qsmpm_model, only: model_type
  use qsmpm_initialisation, only: step_type
  use qsmpm_integration, only: integration_type, measure_cells
  use qsmpm_merged_groups, only: merge_groups
  use qsmpm_assembly, only: evaluation_type, prepare_evaluation, evaluate
  use qsmpm_space, only: place_type, value_at, refresh_space
  use qsmpm_carried_basis, only: basis_at
  use qsmpm_deformation, only: grow_deformation, point_displacement
  use qsmpm_pressures, only: turn_areas
  use qsmpm_points, only: carried_type, points_type
  use qsmpm_house_keeping, only: relocate
  use qsmpm_recovered_gradient, only: recover_gradients
  use qsmpm_model_window, only: follow_material
  use qsmpm_moving_rows, only: scale_rows, is_tangled
  implicit none
  private

  public :: convect

  !> Points from which moving and updating them is worth waking the threads.
  integer, parameter :: fewest_points = 50000

contains

  !> Update what rides on the mesh, then reset the mesh. Stresses, states and volumes of the material
  !> points are taken last, when nothing can fail any more.
  subroutine convect(model, step, displacement, error)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> A point that cannot be updated or has left the mesh, or a tangled mesh.
    type(error_type), allocatable, intent(out) :: error

    call find_stresses(model, step, displacement, error)
    if (allocated(error)) return
    call turn_areas(model, step%activation, displacement)
    call move_carried(model, step, displacement, model%state%surface)
    call move_carried(model, step, displacement, model%state%tracers)
    call move_carried(model, step, displacement, model%state%watched)
    call move_points(model, step, displacement)
    if (model%analysis%method%basis == basis_fem) then
      call carry_mesh(model, step, displacement, error)
    else
      if (model%analysis%moving_mesh%active) call move_rows(model, displacement)
      call follow_material(model)
      call find_again(model, error)
    end if
    if (allocated(error)) return
    call take_stresses(step, model%state%points)
    if (model%space%domains) call grow_deformation(step%at_points, displacement, &
      model%state%points%deformation_gradient)
  end subroutine convect

  !> Stress, state and volume of every material point by its own strain, or under the pressure of its
  !> group; where the equations are integrated at the points the last evaluation has found them.
  subroutine find_stresses(model, step, displacement, error)
    !> The model.
    type(model_type), intent(in) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error

    if (step%updates_points) return
    if (recovers(model)) call recover_gradients(model%mesh, step%activation, step%volumes, model%laws, &
      displacement, step%at_points)
    if (allocated(step%patch)) then
      call merge_groups(step%at_points, step%patch, step%integration)
      if (allocated(step%at_points%cell_size)) call measure_cells(model%mesh, step%integration)
      call evaluate_points(model, step%integration, displacement, step%evaluation, error)
    else
      step%separate = .false.
      call evaluate_points(model, step%at_points, displacement, step%evaluation, error)
    end if
  end subroutine find_stresses

  !> Cells of elements are integrated apart from their points; their points follow a continuous gradient.
  pure logical function recovers(model)
    !> The model.
    type(model_type), intent(in) :: model

    recovers = model%analysis%method%integration == integrate_cells .and. .not. model%space%tensor &
      .and. model%analysis%method%basis /= basis_fem
  end function recovers

  !> What the laws say of the material points in groups.
  subroutine evaluate_points(model, at_points, displacement, evaluation, error)
    !> The model.
    type(model_type), intent(in) :: model
    !> Material points in groups.
    type(integration_type), intent(in) :: at_points
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Their results.
    type(evaluation_type), intent(inout) :: evaluation
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    character(len=100) :: text

    call prepare_evaluation(at_points, model%mesh%dimension, model%space%node_count, .true., .false., evaluation)
    call evaluate(at_points, model%state%points, model%laws, displacement, tangent_none, evaluation)
    if (evaluation%ok) return
    write (text, '(a,i0,a)') 'material point ', at_points%source(evaluation%bad_point), &
      ' turns inside out or its stress cannot be found'
    call fail(error, error_not_converged, trim(text))
  end subroutine evaluate_points

  !> Give the material points the results of the last evaluation.
  subroutine take_stresses(step, points)
    !> Scratch of the step.
    type(step_type), intent(in) :: step
    !> The material points.
    type(points_type), intent(inout) :: points

    if (step%separate) then
      call take_from(step%integration%source)
    else
      call take_from(step%at_points%source)
    end if
  contains
    !> By the material points behind the results.
    subroutine take_from(source)
      !> (n)
      integer, intent(in) :: source(:)
      integer :: p, q

      associate (results => step%evaluation%results)
        !$omp parallel do default(shared) private(p) if (size(source) >= fewest_points)
        do q = 1, size(source)
          p = source(q)
          points%stress(:, p) = results%stress(:, q)
          points%state(:, p) = results%state(:, q)
          points%plastic(p) = results%plastic(q)
          points%volume(p) = points%volume(p)*results%volume_change(q)
        end do
        !$omp end parallel do
      end associate
    end subroutine take_from
  end subroutine take_stresses

  !> Move material points.
  subroutine move_points(model, step, displacement)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(in) :: step
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    real(wp) :: u(3)
    integer :: g, q, p, d

    d = model%mesh%dimension
    !$omp parallel do default(shared) private(q, p, u) if (step%at_points%point_count >= fewest_points)
    do g = 1, step%at_points%group_count
      do q = step%at_points%first(g), step%at_points%first(g + 1) - 1
        p = step%at_points%source(q)
        u = point_displacement(step%at_points, displacement, g, q)
        model%state%points%position(:, p) = model%state%points%position(:, p) + u(:d)
      end do
    end do
    !$omp end parallel do
  end subroutine move_points

  !> Move surface points or tracers.
  subroutine move_carried(model, step, displacement, carried)
    !> The model.
    type(model_type), intent(in) :: model
    !> Scratch of the step.
    type(step_type), intent(in) :: step
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> What rides on the mesh.
    class(carried_type), intent(inout) :: carried
    type(place_type) :: place
    integer :: i

    do i = 1, carried%count
      call basis_at(model%mesh, model%space, step%activation, model%state%points, carried, i, place)
      carried%position(:, i) = carried%position(:, i) + value_at(place, displacement)
    end do
  end subroutine move_carried

  !> Updated Lagrangian FEM: the nodes keep their displacement; points keep their local coordinates.
  subroutine carry_mesh(model, step, displacement, error)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(in) :: step
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    character(len=100) :: text
    logical :: tangled
    integer :: k, c

    model%mesh%coordinates = model%mesh%coordinates + displacement
    do k = 1, step%activation%active_count
      c = step%activation%active_cell(k)
      call is_tangled(model%mesh, model%mesh%coordinates, c, tangled)
      if (.not. tangled) cycle
      write (text, '(a,i0,a)') 'the mesh is tangled: element ', model%mesh%cell_label(c), ' has turned inside out'
      call fail(error, error_not_converged, trim(text))
      return
    end do
    model%state%coordinates = model%mesh%coordinates
  end subroutine carry_mesh

  !> The rows of a moving mesh follow the plate.
  subroutine move_rows(model, displacement)
    !> The model.
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

  !> Mean displacement of the plate along the axis of the moving mesh.
  function plate_displacement(model, displacement) result(move)
    !> The model.
    type(model_type), intent(in) :: model
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    real(wp) :: move
    integer :: s

    move = 0.0_wp
    do s = 1, size(model%mesh%node_sets)
      if (model%mesh%node_sets(s)%name /= model%analysis%moving_mesh%set) cycle
      associate (nodes => model%space%sets(s)%items)
        move = sum(displacement(model%analysis%moving_mesh%axis, nodes))/size(nodes)
      end associate
    end do
  end function plate_displacement

  !> House-keeping: owner cells of everything that rides.
  subroutine find_again(model, error)
    !> The model.
    type(model_type), intent(inout) :: model
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error

    call relocate(model%mesh, model%cell_size, model%state%points, 'material point', error)
    if (allocated(error)) return
    call relocate(model%mesh, model%cell_size, model%state%surface, 'surface point', error)
    if (allocated(error)) return
    call relocate(model%mesh, model%cell_size, model%state%tracers, 'tracer', error)
    if (allocated(error)) return
    call relocate(model%mesh, model%cell_size, model%state%watched, 'material in front of a prescribed set', error)
  end subroutine find_again
end module qsmpm_convection
