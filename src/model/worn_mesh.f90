!> Transfer from a mesh that moves with the material to the background grid. When cells are too distorted by shear, the
!> run continues on the grid with the same lines, which is reset after every step. The state is stored at material
!> points, so that only their cells, the loads in force and the quantities at nodes are determined again.
module qsmpm_worn_mesh
  use qsmpm_kinds, only: wp
  use qsmpm_background_in_use, only: is_at_start, take_background
  use qsmpm_body_placing, only: bodies_fit
  use qsmpm_error, only: error_type
  use qsmpm_grid_window, only: window_type
  use qsmpm_kept_arrays, only: renumber_nodal
  use qsmpm_mesh, only: mesh_type
  use qsmpm_model, only: model_type, carried_set_type, carried_sets
  use qsmpm_model_window, only: fit_window, window_of_material
  use qsmpm_moving_rows, only: least_jacobian
  use qsmpm_nonlocal_field, only: gather_field
  use qsmpm_point_location, only: relocate
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: may_leave_mesh, is_worn, has_no_room, leave_mesh

  !> Minimum quality of a triangle; 1 for equal sides, 0.15 for an angle of 5 degrees.
  real(wp), parameter :: least_quality = 0.15_wp
  !> Ratio to the initial quality below which a triangle is too distorted: where a layer pinches out it is flat from
  !> the start.
  real(wp), parameter :: worn_share = 0.5_wp

contains

  !> Returns whether the mesh is the initial one and can be left: the reactions of released fixities still decrease to
  !> zero at its nodes.
  pure logical function may_leave_mesh(model) result(may)
    type(model_type), intent(in) :: model

    may = is_at_start(model)
    if (may .and. model%state%progress%fraction < 1.0_wp) may = .not. any(abs(model%state%released) > 0.0_wp)
  end function may_leave_mesh

  !> Returns whether such a mesh is too distorted.
  logical function is_worn(model)
    type(model_type), intent(in) :: model
    logical :: holds_soil(model%mesh%cell_count)
    real(wp) :: now
    integer :: c

    is_worn = .false.
    if (.not. may_leave_mesh(model)) return
    holds_soil = .false.
    holds_soil(model%state%points%cell) = .true.
    do c = 1, size(holds_soil)
      if (.not. holds_soil(c)) cycle
      now = quality(model%mesh, model%state%coordinates, c)
      if (now < least_quality) is_worn = now < worn_share*quality(model%mesh, model%drawn_coordinates, c)
      if (is_worn) return
    end do
  end function is_worn

  !> Returns whether an activated body does not fit in its cells and the mesh can be left.
  logical function has_no_room(model)
    type(model_type), intent(in) :: model

    has_no_room = .false.
    if (may_leave_mesh(model)) has_no_room = .not. bodies_fit(model)
  end function has_no_room

  !> Returns the least determinant of the map of a triangle relative to the squares of its sides, 1 for equal straight
  !> sides.
  real(wp) function quality(mesh, coordinates, cell)
    type(mesh_type), intent(in) :: mesh
    real(wp), intent(in) :: coordinates(:, :)
    integer, intent(in) :: cell
    real(wp), parameter :: of_equal_sides = 2.0_wp*sqrt(3.0_wp)

    associate (x => coordinates(:, mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell) + 2)))
      quality = of_equal_sides*least_jacobian(mesh, coordinates, cell)/sum((x - x(:, [2, 3, 1]))**2)
    end associate
  end function quality

  !> Transfers the model to the grid.
  subroutine leave_mesh(model, note, error)
    type(model_type), intent(inout), target :: model
    !> Message for the log.
    character(len=:), allocatable, intent(out) :: note
    !> Set when a point is outside the grid.
    type(error_type), allocatable, intent(out) :: error
    type(window_type) :: window
    type(carried_set_type) :: sets(9)
    integer :: i

    call take_background(2, model)
    call window_of_material(model, window)
    call fit_window(model, window)
    call renumber_nodal(model%state%kept, spread(0, 1, model%space%node_count))
    sets = carried_sets(model%state)
    sets(4)%noun = 'material in front of a prescribed set'
    do i = 1, size(sets)
      sets(i)%places%cell = 1
      call relocate(model%mesh, model%cell_size, sets(i)%places, trim(sets(i)%noun), error)
      if (allocated(error)) exit
    end do
    if (.not. allocated(error)) call gather_field(model)
    note = 'the body-fitted mesh is too distorted: the run continues with splines on a background grid of '// &
      integer_text(model%mesh%cell_count)//' cells, which is reset after every step (docs/methods/fitted.md)'
  end subroutine leave_mesh
end module qsmpm_worn_mesh
