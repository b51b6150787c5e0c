!> Access to values of an analysis by name: size, copy, view of the memory, and setters for those that can be changed.
!> All values are double precision; values of points are stored point by point, with the components of a point
!> contiguous. The fields of the points (qsmpm_field_list) have the prefix `point_`.
module qsmpm_named_values
  use qsmpm_kinds, only: wp
  use qsmpm_consolidation, only: excess_field
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_field_list, only: field_type, field_list_type, field_name_length, shown_nowhere
  use qsmpm_histories, only: take_histories
  use qsmpm_initial_stress, only: start_states
  use qsmpm_kept_arrays, only: is_kept, keep_values, kept_values
  use qsmpm_limit_load, only: limit_loads, relative_compliance
  use qsmpm_model, only: model_type, phase_end_type
  use qsmpm_phase_ends, only: end_of_phase, factor_of_phase
  use qsmpm_phase_tree, only: time_in_phase
  use qsmpm_points, only: points_type, allocate_points, list_made_fields
  use qsmpm_pore_water, only: update_pore_pressure
  use qsmpm_simulation, only: simulation_type
  use qsmpm_text, only: string_type, did_you_mean, integer_text
  implicit none
  private

  public :: list_value_names, value_shape, get_values, view_values, set_values

  integer, parameter :: name_length = field_name_length
  character(len=*), parameter :: of_point = 'point_'
  !> Names other than those of the fields of the points.
  character(len=name_length), parameter :: other_names(25) = [character(len=name_length) :: &
    'point_force', 'node_position', 'node_reaction', 'node_pressure', 'gravity', 'histories', &
    'stage', 'step', 'share', 'load_factor', 'time', 'finished', 'coming_stage', 'dimension', &
    'external_work', 'internal_work', &
    'iterations', 'out_of_balance', 'equations', 'rejected', 'step_error', 'compliance', &
    'limit_load', 'strength_factor', 'phase_results']
  !> Indices in other_names of the first and last scalar, except the limit load.
  integer, parameter :: first_single = 7, last_single = 24

contains

  !> Returns the names of all values.
  subroutine list_value_names(names)
    character(len=name_length), allocatable, intent(out) :: names(:)
    type(points_type), target :: none
    type(field_list_type) :: list
    integer :: i

    call allocate_points(none, 3, 0, 6, 0)
    call none%list_fields(list)
    call list_made_fields(none, list)
    names = [character(len=name_length) :: (of_point//list%fields(i)%name, i=1, list%count)]
    names = [character(len=name_length) :: pack(names, list%fields(:list%count)%shown /= shown_nowhere), other_names]
  end subroutine list_value_names

  !> Returns the field of the points that has this name; an empty field if there is none or the points do not store it.
  subroutine find_field(points, name, field)
    type(points_type), intent(in), target :: points
    character(len=*), intent(in) :: name
    type(field_type), intent(out) :: field
    type(field_list_type) :: list
    integer :: i

    if (index(name, of_point) /= 1) return
    call points%list_fields(list)
    i = list%find(name(len(of_point) + 1:))
    if (i == 0) call list_made_fields(points, list)
    if (i == 0) i = list%find(name(len(of_point) + 1:))
    if (i > 0) field = list%fields(i)
  end subroutine find_field

  !> Returns the number of components and the number of values of a name.
  subroutine value_shape(simulation, name, rows, columns, error)
    type(simulation_type), intent(in), target :: simulation
    !> A name of list_value_names.
    character(len=*), intent(in) :: name
    !> Components per value; number of values.
    integer, intent(out) :: rows, columns
    !> Set when there is no such name or no model, or when the points do not store the field.
    type(error_type), allocatable, intent(out) :: error
    type(field_type) :: field

    rows = 0
    columns = 0
    call check_name(simulation, name, error)
    if (allocated(error)) return
    rows = 1
    columns = 1
    associate (model => simulation%model)
      select case (name)
      case ('point_force')
        rows = model%mesh%dimension
        columns = model%state%points%count
      case ('node_position')
        rows = model%mesh%dimension
        columns = model%mesh%node_count
      case ('node_reaction')
        rows = model%mesh%dimension
        columns = model%space%node_count
      case ('node_pressure')
        columns = merge(model%space%node_count, 0, is_kept(model%state%kept, excess_field))
      case ('gravity', 'limit_load')
        rows = 3
      case ('histories')
        columns = size(model%analysis%histories)
      case ('phase_results')
        rows = 5
        columns = size(model%analysis%phases)
      case default
        call find_field(model%state%points, name, field)
        if (len_trim(field%name) == 0) return
        rows = field%component_count()
        columns = field%point_count()
        if (columns /= model%state%points%count) call fail(error, error_other, &
          "'"//name//"' is not carried: *FIELD, STRAIN=YES asks for strains, *WATER LEVEL for pore pressures")
      end select
    end associate
  end subroutine value_shape

  !> Copies the values of a name to an array.
  subroutine get_values(simulation, name, values, error)
    type(simulation_type), intent(in), target :: simulation
    !> A name of list_value_names.
    character(len=*), intent(in) :: name
    !> Array of the size given by value_shape.
    real(wp), intent(out) :: values(:)
    !> Set when there is no such name or the size of the array is wrong.
    type(error_type), allocatable, intent(out) :: error
    type(field_type) :: field
    real(wp), allocatable :: histories(:), table(:, :)
    real(wp) :: singles(first_single:last_single), loads(4)
    integer :: rows, columns

    values = 0.0_wp
    call value_shape(simulation, name, rows, columns, error)
    if (.not. allocated(error)) call check_size(name, size(values), rows*columns, error)
    if (allocated(error)) return
    associate (loading => simulation%model%loading)
      select case (name)
      case ('point_force')
        if (allocated(loading%point_force)) values = pack(loading%point_force, .true.)
      case ('node_position')
        values = pack(simulation%model%state%coordinates, .true.)
      case ('node_reaction')
        values = pack(simulation%model%state%reactions, .true.)
      case ('node_pressure')
        if (columns > 0) values = pack(kept_values(simulation%model%state%kept, excess_field), .true.)
      case ('gravity')
        values = loading%gravity_start + simulation%model%state%progress%fraction* &
          (loading%gravity_final - loading%gravity_start)
      case ('limit_load')
        ! Supported and rejected load factor and knee of the current stage; zeros until its limit load is found.
        associate (progress => simulation%model%state%progress)
          loads = limit_loads(progress%limit, progress%fraction, &
            simulation%model%analysis%phases(progress%phase)%load_factor)
        end associate
        values = loads(:3)
      case ('phase_results')
        values = phase_results(simulation%model)
      case ('histories')
        call take_histories(simulation%model, histories)
        values = histories
      case default
        call find_field(simulation%model%state%points, name, field)
        if (len_trim(field%name) == 0) then
          singles = single_values(simulation)
          values(1) = singles(findloc(other_names, name, dim=1))
        else
          call field%get_values(rows, table)
          values = pack(table, .true.)
        end if
      end select
    end associate
  end subroutine get_values

  !> Returns the results of every phase: end status (0 not ended, 1 full load, 2 limit load, 3 stopped, 4 failed), load
  !> fraction and largest displacement at its end, stable and failed factor of safety. A factor is 0 if not available;
  !> where no failed factor is found, the factor of safety is at least the stable one.
  pure function phase_results(model) result(values)
    type(model_type), intent(in) :: model
    real(wp) :: values(5*size(model%analysis%phases))
    type(phase_end_type) :: ended
    integer :: p

    do p = 1, size(model%analysis%phases)
      ended = end_of_phase(model%state%progress, p)
      values(5*p - 4:5*p) = [real(ended%reason, wp), ended%fraction, ended%displacement, &
        factor_of_phase(model%state%progress, p)]
    end do
  end function phase_results

  !> Returns the scalar values in the order of other_names(first_single:last_single).
  function single_values(simulation) result(values)
    type(simulation_type), intent(in) :: simulation
    real(wp) :: values(first_single:last_single)

    associate (model => simulation%model, progress => simulation%model%state%progress, last => simulation%last)
      values = [real(wp) :: progress%phase, progress%step, progress%fraction, progress%load_factor, &
        time_in_phase(model%analysis%phases, progress%phase, progress%fraction), merge(1, 0, simulation%finished()), &
        simulation%coming_stage(), model%mesh%dimension, progress%external_work, progress%internal_work, &
        last%iterations, last%out_of_balance, last%equations, last%rejected, last%step_error, &
        relative_compliance(progress%limit), 0, progress%strength_factor]
    end associate
  end function single_values

  !> Returns a pointer to values in memory. The address is constant from step to step, as long as the analysis exists
  !> and no bodies are activated or deactivated.
  subroutine view_values(simulation, name, values, error)
    type(simulation_type), intent(in), target :: simulation
    !> A name of list_value_names that is a stored real field.
    character(len=*), intent(in) :: name
    !> (components, points)
    real(wp), pointer, intent(out) :: values(:, :)
    !> Set when there is no such name, or when its values are computed only on request.
    type(error_type), allocatable, intent(out) :: error
    type(field_type) :: field
    integer :: rows, columns

    nullify (values)
    call value_shape(simulation, name, rows, columns, error)
    if (allocated(error)) return
    call find_field(simulation%model%state%points, name, field)
    if (associated(field%reals)) then
      values => field%reals
    else
      call fail(error, error_other, "'"//name//"' has no place in memory: get a copy")
    end if
  end subroutine view_values

  !> Sets values: point_stress, with the state variables that belong to it; point_state; point_force.
  subroutine set_values(simulation, name, values, error)
    type(simulation_type), intent(inout) :: simulation
    character(len=*), intent(in) :: name
    !> Array of the size given by value_shape.
    real(wp), intent(in) :: values(:)
    !> Set when the values cannot be changed, or when the array has the wrong size or values that are not finite.
    type(error_type), allocatable, intent(out) :: error
    integer :: rows, columns

    call value_shape(simulation, name, rows, columns, error)
    if (.not. allocated(error)) call check_size(name, size(values), rows*columns, error)
    if (.not. allocated(error) .and. .not. all(abs(values) <= huge(1.0_wp))) &
      call fail(error, error_other, "a value of '"//name//"' is not a finite number")
    if (allocated(error)) return
    select case (name)
    case ('point_stress')
      call start_stresses(simulation%model, reshape(values, [rows, columns]))
    case ('point_state')
      simulation%model%state%points%state(:, :) = reshape(values, [rows, columns])
    case ('node_pressure')
      if (columns > 0) call keep_values(simulation%model%state%kept, excess_field, reshape(values, [1, columns]))
      call update_pore_pressure(simulation%model)
    case ('point_force')
      call simulation%set_point_force(reshape(values, [rows, columns]), error)
    case default
      call fail(error, error_other, "'"//name//"' cannot be set")
    end select
  end subroutine set_values

  !> Sets the stresses of the points as initial stresses, which refer to the current volume.
  subroutine start_stresses(model, stress)
    type(model_type), intent(inout) :: model
    !> Cauchy stress (4 or 6, points).
    real(wp), intent(in) :: stress(:, :)

    model%state%points%stress(:, :) = stress
    model%state%points%initial_volume(:) = model%state%points%volume
    call start_states(model)
  end subroutine start_stresses

  !> Checks that there is a model and such a name.
  subroutine check_name(simulation, name, error)
    type(simulation_type), intent(in) :: simulation
    character(len=*), intent(in) :: name
    !> Its message suggests the nearest name.
    type(error_type), allocatable, intent(out) :: error
    type(string_type), allocatable :: names(:)
    character(len=name_length), allocatable :: known(:)
    integer :: i

    if (.not. simulation%ready) then
      call fail(error, error_other, 'there is no model: create it first')
      return
    end if
    call list_value_names(known)
    if (any(known == name)) return
    allocate (names(size(known)))
    do i = 1, size(names)
      names(i)%text = trim(known(i))
    end do
    call fail(error, error_other, "there are no values '"//name//"'"//did_you_mean(name, names))
  end subroutine check_name

  !> Checks the size of an array.
  pure subroutine check_size(name, given, wanted, error)
    character(len=*), intent(in) :: name
    !> Size of the caller's array and required size.
    integer, intent(in) :: given, wanted
    !> Its message states both sizes.
    type(error_type), allocatable, intent(out) :: error

    if (given /= wanted) call fail(error, error_other, "'"//name//"' are "//integer_text(wanted)// &
      ' numbers, not '//integer_text(given))
  end subroutine check_size
end module qsmpm_named_values
