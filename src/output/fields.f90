!> The fields of a state for results and pictures: fields stored at the material points or derived from them
!> (qsmpm_field_list), their load, the stress error and the state variables of the laws; and quantities of the cells of
!> the mesh. Vectors are written with three components, symmetric tensors with six (11, 22, 33, 12, 13, 23); components
!> that a plane model does not have are zero.
!>
!> Also prints the table of the fields of the material points with their names in pictures, results and named values.
module qsmpm_fields
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_cell_share, only: cell_volumes
  use qsmpm_field_list, only: field_list_type, kind_number, kind_vector, shown_in_results, unit_force, unit_length, &
    unit_stress, field_type, kind_internal, kind_names, row_components, shown_nowhere
  use qsmpm_load_path, only: between
  use qsmpm_mesh, only: mesh_type
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: is_divided
  use qsmpm_seepage_field, only: cell_of_place
  use qsmpm_sorting, only: place_in_order
  use qsmpm_stress_error, only: stress_error_type
  use qsmpm_number_text, only: integer_text, newline
  use qsmpm_points, only: allocate_points, list_made_fields
  implicit none
  private

  public :: padded, list_results, phase_time, cell_fill, cell_point_count, state_name, state_values, fields_markdown

  !> Where a field is available, by the shown_* values from 1.
  character(len=*), parameter :: shown_names(3) = [character(len=25) :: 'values', 'pictures, results', &
    'pictures, results, values']

contains

  !> Appends zero components.
  pure subroutine padded(values, components, full)
    !> (given components, n)
    real(wp), intent(in) :: values(:, :)
    !> Required number of components.
    integer, intent(in) :: components
    !> (components, n)
    real(wp), allocatable, intent(out) :: full(:, :)

    allocate (full(components, size(values, 2)), source=0.0_wp)
    full(:size(values, 1), :) = values
  end subroutine padded

  !> Lists all fields of the material points; valid while the model is unchanged.
  subroutine list_results(model, estimate, list)
    type(model_type), intent(in), target :: model
    !> Estimated error of the stresses.
    type(stress_error_type), intent(in) :: estimate
    type(field_list_type), intent(inout) :: list
    real(wp), allocatable :: values(:, :)
    integer :: i

    call model%state%points%list_fields(list)
    call list_made_fields(model%state%points, list)
    allocate (values, source=reshape(estimate%at_point, [1, size(estimate%at_point)]))
    call list%add_made('stress_error', values, kind_number, shown_in_results, meaning='estimated error of the '// &
      'stress, as a share of stress_scale')
    values = reshape(estimate%scale, [1, size(estimate%scale)])
    call list%add_made('stress_scale', values, kind_number, shown_in_results, unit_stress, 'norm of the stress in '// &
      'the neighbourhood, root mean square')
    call point_load(model, values)
    call list%add_made('load', values, kind_vector, shown_in_results, unit_force, 'weight and the traction that '// &
      'material points carry, as they stand')
    call list_flow(model, list)
    i = 1
    do while (len(state_name(model, i)) > 0)
      call state_values(model, state_name(model, i), values)
      call list%add_made(state_name(model, i), values, kind_number, shown_in_results)
      i = i + 1
    end do
  end subroutine list_results

  !> Lists head and flow of the water at the points, if there is seepage at the end of the phase.
  subroutine list_flow(model, list)
    type(model_type), intent(in) :: model
    type(field_list_type), intent(inout) :: list
    real(wp), allocatable :: head(:, :), velocity(:, :)
    real(wp) :: share(model%mesh%dimension + 1)
    integer :: p, cell

    if (.not. allocated(model%loading%water_final)) return
    if (.not. allocated(model%loading%water_final(1)%field)) return
    associate (field => model%loading%water_final(1)%field, points => model%state%points)
      allocate (head(1, points%count), velocity(3, points%count), source=0.0_wp)
      do p = 1, points%count
        call cell_of_place(field, points%position(:, p), cell, share)
        head(1, p) = sum(share*field%head(field%corner(:, cell)))
        velocity(:model%mesh%dimension, p) = field%velocity(:, cell)
      end do
    end associate
    call list%add_made('head', head, kind_number, shown_in_results, unit_length, 'height to which water would rise '// &
      'at the end of the phase')
    call list%add_made('darcy_velocity', velocity, kind_vector, shown_in_results, meaning='volume of water a unit '// &
      'of area and of the time of *PERMEABILITY, at the end of the phase')
  end subroutine list_flow

  !> Returns the external force on the material points at the current load: weight, and traction carried by material
  !> points.
  pure subroutine point_load(model, load)
    type(model_type), intent(in) :: model
    !> (3, points)
    real(wp), allocatable, intent(out) :: load(:, :)
    real(wp) :: gravity(3), traction(3)
    integer, allocatable :: number(:)
    integer :: i, s, p

    allocate (load(3, model%state%points%count))
    associate (share => model%state%progress%fraction, loading => model%loading)
      gravity = loading%gravity_start + share*(loading%gravity_final - loading%gravity_start)
      do i = 1, model%state%points%count
        load(:, i) = between(model%state%points%start_weight(i), model%state%points%weight(i), share)*gravity
      end do
      if (.not. allocated(model%carrying_point) .or. .not. allocated(loading%traction_final)) return
      if (is_divided(model%part)) number = int(model%state%points%number)
      do i = 1, size(model%carrying_point)
        p = model%carrying_point(i)
        if (allocated(number)) p = place_in_order(number, p)
        if (p == 0) cycle
        s = model%carrying_surface(i)
        traction = loading%traction_start(:, s) + share*(loading%traction_final(:, s) - loading%traction_start(:, s))
        load(:, p) = load(:, p) + model%carrying_area(i)*traction
      end do
    end associate
  end subroutine point_load

  !> Returns the name of a state variable, numbered over all laws with named variables, each name once; empty beyond
  !> the last one.
  pure function state_name(model, number) result(name)
    type(model_type), intent(in) :: model
    !> Number of the variable.
    integer, intent(in) :: number
    character(len=:), allocatable :: name
    integer :: m, i, count

    name = ''
    count = 0
    if (.not. allocated(model%laws)) return
    do m = 1, size(model%laws)
      if (.not. allocated(model%laws(m)%law%state_names)) cycle
      do i = 1, size(model%laws(m)%law%state_names)
        if (known(model, m, model%laws(m)%law%state_names(i)%text)) cycle
        count = count + 1
        if (count == number) name = model%laws(m)%law%state_names(i)%text
      end do
    end do
  end function state_name

  !> Returns whether an earlier law has a state variable of this name, or the name is empty.
  pure logical function known(model, last, name)
    type(model_type), intent(in) :: model
    !> Number of the law whose predecessors are checked.
    integer, intent(in) :: last
    character(len=*), intent(in) :: name
    integer :: m

    known = len(name) == 0 .or. any([(model%laws(m)%law%state_place(name) > 0, m=1, last - 1)])
  end function known

  !> Returns a state variable at the material points, 0 where the law does not have it.
  subroutine state_values(model, name, values)
    type(model_type), intent(in) :: model
    character(len=*), intent(in) :: name
    !> (1, points)
    real(wp), allocatable, intent(out) :: values(:, :)
    integer :: place(size(model%laws)), m, p

    place = [(model%laws(m)%law%state_place(name), m=1, size(model%laws))]
    associate (points => model%state%points)
      allocate (values(1, points%count), source=0.0_wp)
      do p = 1, points%count
        m = place(points%material(p))
        if (m > 0) values(1, p) = points%state(m, p)
      end do
    end associate
  end subroutine state_values

  !> Returns the time of a picture: completed phases plus the load fraction of the current one, never decreasing.
  pure real(wp) function phase_time(model)
    type(model_type), intent(in) :: model

    phase_time = real(model%state%progress%phase - 1, wp) + model%state%progress%fraction
  end function phase_time

  !> Returns the number of material points in each cell.
  pure subroutine cell_point_count(model, count)
    type(model_type), intent(in) :: model
    !> (cells)
    integer, allocatable, intent(out) :: count(:)
    integer :: i, c

    allocate (count(model%mesh%cell_count), source=0)
    do i = 1, model%state%points%count
      c = model%state%points%cell(i)
      count(c) = count(c) + 1
    end do
  end subroutine cell_point_count

  !> Returns the ratio of the volume of the points in a cell to the volume of the cell.
  subroutine cell_fill(model, fill)
    type(model_type), intent(in) :: model
    !> (1, cells)
    real(wp), allocatable, intent(out) :: fill(:, :)
    real(wp), allocatable :: volumes(:)
    type(mesh_type) :: mesh
    integer :: i, c

    allocate (volumes(model%mesh%cell_count))
    allocate (fill(1, model%mesh%cell_count), source=0.0_wp)
    mesh%dimension = model%mesh%dimension
    mesh%axisymmetric = model%mesh%axisymmetric
    mesh%node_count = model%mesh%node_count
    mesh%cell_count = model%mesh%cell_count
    mesh%cell_kind = model%mesh%cell_kind
    mesh%cell_first = model%mesh%cell_first
    mesh%cell_nodes = model%mesh%cell_nodes
    mesh%coordinates = model%state%coordinates
    call cell_volumes(mesh, volumes)
    do i = 1, model%state%points%count
      c = model%state%points%cell(i)
      fill(1, c) = fill(1, c) + model%state%points%volume(i)
    end do
    ! An inverted cell of a mesh that moves with the material has no filling ratio.
    where (volumes > 0.0_wp)
      fill(1, :) = fill(1, :)/volumes
    elsewhere
      fill(1, :) = 0.0_wp
    end where
  end subroutine cell_fill

  !> Returns all available fields as a table in Markdown.
  subroutine fields_markdown(text)
    character(len=:), allocatable, intent(out) :: text
    type(model_type), target :: none
    type(field_list_type) :: list
    type(stress_error_type) :: no_error
    integer :: i

    call allocate_points(none%state%points, 3, 0, 6, 0)
    allocate (no_error%at_point(0), no_error%scale(0))
    call list_results(none, no_error, list)
    text = '| field | components | unit | kind | where | what |'//newline//'|---|---|---|---|---|---|'//newline
    do i = 1, list%count
      if (list%fields(i)%shown /= shown_nowhere) text = text//row_of(list%fields(i))//newline
    end do
  end subroutine fields_markdown

  !> Returns the table row of a field.
  pure function row_of(field) result(row)
    type(field_type), intent(in) :: field
    character(len=:), allocatable :: row, components, places

    components = integer_text(row_components(field%kind))
    if (field%kind == kind_internal) components = 'of the law'
    places = shown_names(field%shown)
    row = '| `'//trim(field%name)//'` | '//components//' | '//trim(field%unit)//' | '//trim(kind_names(field%kind))// &
      ' | '//trim(places)//' | '//trim(field%meaning)//' |'
  end function row_of
end module qsmpm_fields
