!> The state of a model, component by component: every one altered, and the names of those in which two states differ.
!>
!> Fields of points and of what else rides on the mesh are found in their lists; `verification/house.py` demands that
!> every component is in one, and that every other component of the state is named here twice, so that a new one
!> cannot be left out of the tests of checkpoint and restart.
module state_samples
  use, intrinsic :: iso_fortran_env, only: int8
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: state_type, progress_type, phase_end_type
  use qsmpm_field_list, only: field_list_type
  use qsmpm_points, only: carried_type, points_type
  implicit none
  private

  public :: alter_state, alter_validly, state_differences, carried_names, same_reals

  !> Change every element.
  interface alter
    module procedure :: alter_real, alter_reals_1, alter_reals_2, alter_integers
  end interface alter

contains

  !> Change every element of every component; the window stays, since mesh and space belong to it.
  subroutine alter_state(state)
    type(state_type), intent(inout) :: state
    integer :: i

    call alter_carried(state%points)
    call alter_carried(state%surface)
    call alter_carried(state%tracers)
    call alter_carried(state%watched)
    call alter_carried(state%inactive%points)
    call alter_carried(state%inactive%unloading)
    call alter_carried(state%inactive%surface)
    call alter_carried(state%inactive%unloading_surface)
    call alter_carried(state%inactive%feet)
    call alter(state%coordinates)
    call alter(state%reactions)
    call alter(state%released)
    call alter(state%plate)
    if (allocated(state%kept%list)) then
      do i = 1, size(state%kept%list)
        call alter(state%kept%list(i)%values)
      end do
    end if
    call alter_progress(state%progress)
  end subroutine alter_state

  !> Alter all of a state that a run may alter, numbers of cells, bodies and materials staying those of its model.
  subroutine alter_validly(state)
    class(state_type), intent(inout) :: state
    class(state_type), allocatable :: before
    integer :: i

    allocate (before, source=state)
    call alter_state(state)
    state%points%cell = before%points%cell(before%points%count:1:-1)
    state%surface%cell = [(before%points%cell(1 + mod(i, before%points%count)), i=1, state%surface%count)]
    state%tracers%cell = [(before%points%cell(1 + mod(i, before%points%count)), i=1, state%tracers%count)]
    state%points%body = before%points%body
    state%points%material = before%points%material
    state%surface%surface = before%surface%surface
    state%watched%cell = before%points%cell(:state%watched%count)
    state%watched%set = 1
    state%watched%component = 2
    state%points%plastic = 1
    ! A restart file with a volume or a stretch that is none is refused.
    state%points%volume = 0.125_wp + abs(state%points%volume)
    state%points%left_cauchy_green = 0.125_wp + abs(state%points%left_cauchy_green)
    call make_points_valid(state%inactive%points, before%inactive%points)
    call make_points_valid(state%inactive%unloading, before%inactive%unloading)
    state%inactive%surface%cell = before%inactive%surface%cell
    state%inactive%unloading_surface%cell = before%inactive%unloading_surface%cell
    state%inactive%feet%cell = before%inactive%feet%cell
    state%progress%phase = before%progress%phase
  end subroutine alter_validly

  !> The same of points of bodies that are not there.
  subroutine make_points_valid(points, before)
    type(points_type), intent(inout) :: points
    type(points_type), intent(in) :: before

    points%cell = before%cell
    points%body = before%body
    points%material = before%material
    points%volume = 0.125_wp + abs(points%volume)
    points%left_cauchy_green = 0.125_wp + abs(points%left_cauchy_green)
  end subroutine make_points_valid

  !> Change where the analysis stands.
  subroutine alter_progress(progress)
    type(progress_type), intent(inout) :: progress

    progress%phase = progress%phase + 1
    progress%step = progress%step + 2
    progress%phase_steps = progress%phase_steps + 3
    progress%constant_load_tests_done = progress%constant_load_tests_done + 4
    progress%undamped_newton = .not. progress%undamped_newton
    progress%failed_solvers = 3 - progress%failed_solvers
    call alter(progress%release_left)
    call alter(progress%own_settlement)
    call alter(progress%force_at_start)
    call alter(progress%fraction)
    call alter(progress%load_factor)
    call alter(progress%next_step)
    call alter(progress%damping)
    call alter(progress%external_work)
    call alter(progress%internal_work)
    call alter(progress%limit%first)
    call alter(progress%limit%last)
    call alter(progress%limit%middle)
    call alter(progress%limit%refused)
    call alter(progress%limit%refused_compliance)
    call alter(progress%limit%refused_middle)
    call alter(progress%limit%plateau)
    call alter(progress%limit%most)
    call alter(progress%limit%passed)
    call alter(progress%limit%square)
    call alter(progress%limit%knee)
    call alter(progress%strength_factor)
    progress%strength_factor = 2.0_wp + abs(progress%strength_factor)
    call alter(progress%bracket%stable)
    call alter(progress%bracket%lost)
    call alter(progress%bracket%lost_above)
    call alter(progress%bracket%increment)
    progress%bracket%increment = 1.0_wp + abs(progress%bracket%increment)
    progress%factors = reshape([1.0_wp, 1.25_wp, 1.5_wp, 1.0_wp], [4, 1])
    progress%stopped = .not. progress%stopped
    progress%ends = [phase_end_type()]
    progress%ends(1)%reason = 3
    progress%ends(1)%fraction = 0.25_wp
    progress%ends(1)%displacement = 0.125_wp
  end subroutine alter_progress

  !> Change all fields of a carried set; the number of its places stays.
  subroutine alter_carried(carried)
    class(carried_type), intent(inout), target :: carried
    type(field_list_type) :: list
    integer :: i

    call carried%list_fields(list)
    do i = 1, list%count
      associate (field => list%fields(i))
        if (associated(field%reals)) call alter(field%reals)
        if (associated(field%labels)) call alter(field%labels)
        if (associated(field%numbers)) field%numbers = 3*field%numbers + 1
      end associate
    end do
  end subroutine alter_carried

  !> Change a number.
  elemental subroutine alter_real(x)
    real(wp), intent(inout) :: x

    x = 1.0_wp/3.0_wp - 2.0_wp*x
  end subroutine alter_real

  !> Change a row, each element by itself.
  pure subroutine alter_reals_1(x)
    real(wp), intent(inout) :: x(:)
    integer :: i

    do i = 1, size(x)
      x(i) = i/3.0_wp - 2.0_wp*x(i)
    end do
  end subroutine alter_reals_1

  !> Change a table, each column by itself.
  pure subroutine alter_reals_2(x)
    real(wp), intent(inout) :: x(:, :)
    integer :: i

    do i = 1, size(x, 2)
      call alter_reals_1(x(:, i))
      x(:, i) = x(:, i) + i
    end do
  end subroutine alter_reals_2

  !> Change a row of integers.
  elemental subroutine alter_integers(n)
    integer, intent(inout) :: n

    n = n + 1
  end subroutine alter_integers

  !> Names of the components in which two states differ, a blank behind each; bits count, not values.
  function state_differences(a, b) result(names)
    type(state_type), intent(in) :: a, b
    character(len=:), allocatable :: names
    integer :: i

    names = carried_differences('points', a%points, b%points)//carried_differences('surface', a%surface, b%surface)// &
      carried_differences('tracers', a%tracers, b%tracers)//carried_differences('watched', a%watched, b%watched)
    names = names//carried_differences('inactive', a%inactive%points, b%inactive%points)// &
      carried_differences('unloading', a%inactive%unloading, b%inactive%unloading)// &
      carried_differences('inactive_surface', a%inactive%surface, b%inactive%surface)// &
      carried_differences('unloading_surface', a%inactive%unloading_surface, b%inactive%unloading_surface)// &
      carried_differences('feet', a%inactive%feet, b%inactive%feet)
    call note(names, 'coordinates', same_shape(shape(a%coordinates), shape(b%coordinates)))
    if (size(a%coordinates) == size(b%coordinates)) &
      call note(names, 'coordinates', same_reals([a%coordinates], [b%coordinates]))
    call note(names, 'reactions', same_reals([a%reactions], [b%reactions]))
    call note(names, 'released', same_reals([a%released], [b%released]))
    call note(names, 'plate', same_reals([a%plate], [b%plate]))
    call note(names, 'kept', allocated(a%kept%list) .eqv. allocated(b%kept%list))
    if (allocated(a%kept%list) .and. allocated(b%kept%list)) then
      call note(names, 'kept', size(a%kept%list) == size(b%kept%list))
      do i = 1, min(size(a%kept%list), size(b%kept%list))
        call note(names, 'kept', a%kept%list(i)%name == b%kept%list(i)%name .and. &
          same_reals([a%kept%list(i)%values], [b%kept%list(i)%values]))
      end do
    end if
    call note(names, 'window', all(a%window%first == b%window%first) .and. all(a%window%last == b%window%last))
    names = names//progress_differences(a%progress, b%progress)
  end function state_differences

  !> Whether phases have ended alike.
  logical function same_ends(a, b)
    type(progress_type), intent(in) :: a, b

    same_ends = allocated(a%ends) .eqv. allocated(b%ends)
    if (.not. (same_ends .and. allocated(a%ends))) return
    same_ends = size(a%ends) == size(b%ends)
    if (same_ends) same_ends = all(a%ends%reason == b%ends%reason) .and. same_reals(a%ends%fraction, b%ends%fraction) &
      .and. same_reals(a%ends%displacement, b%ends%displacement)
  end function same_ends

  !> Components of the progress that differ.
  function progress_differences(a, b) result(names)
    type(progress_type), intent(in) :: a, b
    character(len=:), allocatable :: names

    names = ''
    call note(names, 'phase', a%phase == b%phase)
    call note(names, 'step', a%step == b%step)
    call note(names, 'phase_steps', a%phase_steps == b%phase_steps)
    call note(names, 'constant_load_tests_done', a%constant_load_tests_done == b%constant_load_tests_done)
    call note(names, 'failed_solvers', a%failed_solvers == b%failed_solvers)
    call note(names, 'undamped_newton', a%undamped_newton .eqv. b%undamped_newton)
    call note(names, 'release_left', same_reals([a%release_left], [b%release_left]))
    call note(names, 'own_settlement', same_reals([a%own_settlement], [b%own_settlement]))
    call note(names, 'force_at_start', same_reals([a%force_at_start], [b%force_at_start]))
    call note(names, 'fraction', same_reals([a%fraction], [b%fraction]))
    call note(names, 'load_factor', same_reals([a%load_factor], [b%load_factor]))
    call note(names, 'next_step', same_reals([a%next_step], [b%next_step]))
    call note(names, 'damping', same_reals([a%damping], [b%damping]))
    call note(names, 'external_work', same_reals([a%external_work], [b%external_work]))
    call note(names, 'internal_work', same_reals([a%internal_work], [b%internal_work]))
    call note(names, 'limit%first', same_reals([a%limit%first], [b%limit%first]))
    call note(names, 'limit%last', same_reals([a%limit%last], [b%limit%last]))
    call note(names, 'limit%middle', same_reals([a%limit%middle], [b%limit%middle]))
    call note(names, 'limit%refused', same_reals([a%limit%refused], [b%limit%refused]))
    call note(names, 'limit%refused_compliance', same_reals([a%limit%refused_compliance], [b%limit%refused_compliance]))
    call note(names, 'limit%refused_middle', same_reals([a%limit%refused_middle], [b%limit%refused_middle]))
    call note(names, 'limit%plateau', same_reals([a%limit%plateau], [b%limit%plateau]))
    call note(names, 'limit%most', same_reals([a%limit%most], [b%limit%most]))
    call note(names, 'limit%passed', same_reals([a%limit%passed], [b%limit%passed]))
    call note(names, 'limit%square', same_reals([a%limit%square], [b%limit%square]))
    call note(names, 'limit%knee', same_reals([a%limit%knee], [b%limit%knee]))
    call note(names, 'strength_factor', same_reals([a%strength_factor], [b%strength_factor]))
    call note(names, 'bracket%stable', same_reals([a%bracket%stable], [b%bracket%stable]))
    call note(names, 'bracket%lost', &
      same_reals([a%bracket%lost, a%bracket%lost_above], [b%bracket%lost, b%bracket%lost_above]))
    call note(names, 'bracket%increment', same_reals([a%bracket%increment], [b%bracket%increment]))
    call note(names, 'factors', allocated(a%factors) .eqv. allocated(b%factors))
    if (allocated(a%factors) .and. allocated(b%factors)) call note(names, 'factors', &
      same_reals([a%factors], [b%factors]))
    call note(names, 'stopped', a%stopped .eqv. b%stopped)
    call note(names, 'ends', same_ends(a, b))
  end function progress_differences

  !> Fields of a carried set that differ.
  function carried_differences(owner, a, b) result(names)
    !> Name of the set.
    character(len=*), intent(in) :: owner
    class(carried_type), intent(in), target :: a, b
    character(len=:), allocatable :: names
    type(field_list_type) :: one, other
    integer :: i

    call a%list_fields(one)
    call b%list_fields(other)
    names = ''
    call note(names, owner//'%count', a%count == b%count)
    do i = 1, one%count
      associate (x => one%fields(i), y => other%fields(i))
        if (associated(x%reals)) call note(names, owner//'%'//trim(x%name), same_reals([x%reals], [y%reals]))
        if (associated(x%labels)) call note(names, owner//'%'//trim(x%name), same_integers(x%labels, y%labels))
        if (associated(x%numbers)) call note(names, owner//'%'//trim(x%name), &
          same_integers(int(x%numbers), int(y%numbers)))
      end associate
    end do
  end function carried_differences

  !> Names of all fields of a carried set as `state_differences` says them, a blank behind each.
  function carried_names(owner, carried) result(names)
    !> Name of the set.
    character(len=*), intent(in) :: owner
    class(carried_type), intent(in), target :: carried
    character(len=:), allocatable :: names
    type(field_list_type) :: list
    integer :: i

    call carried%list_fields(list)
    names = ''
    do i = 1, list%count
      names = names//owner//'%'//trim(list%fields(i)%name)//' '
    end do
  end function carried_names

  !> Add the name of a component that differs.
  subroutine note(names, name, same)
    character(len=:), allocatable, intent(inout) :: names
    character(len=*), intent(in) :: name
    !> Whether it is the same.
    logical, intent(in) :: same

    if (.not. same) names = names//name//' '
  end subroutine note

  !> Whether two rows of reals are the same bits.
  pure logical function same_reals(a, b)
    real(wp), intent(in) :: a(:), b(:)

    same_reals = size(a) == size(b)
    if (same_reals) same_reals = all(transfer(a, [0_int8]) == transfer(b, [0_int8]))
  end function same_reals

  !> Whether two rows of integers are the same.
  pure logical function same_integers(a, b)
    integer, intent(in) :: a(:), b(:)

    same_integers = size(a) == size(b)
    if (same_integers) same_integers = all(a == b)
  end function same_integers

  !> Whether two shapes are the same.
  pure logical function same_shape(a, b)
    integer, intent(in) :: a(:), b(:)

    same_shape = size(a) == size(b)
    if (same_shape) same_shape = all(a == b)
  end function same_shape
end module state_samples
