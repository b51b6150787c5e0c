!> Whether the state that a step begins from can be computed with: a restart file, an embedding program or a
!> law's start may have brought in what is not a number. What a step computes itself is looked at where it is born.
module qsmpm_usable_state
  use qsmpm_error, only: error_type, fail, error_other
  use qsmpm_finite, only: all_usable, is_usable, unusable
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type, progress_type
  use qsmpm_points, only: carried_type, points_type, surface_points_type
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: check_state

  !> Looks at numbers that belong to points; does nothing where there is an error already.
  interface check
    procedure check_scalars, check_vectors
  end interface check

contains

  !> Refuse a state with a number that cannot be computed with; the first one is named.
  subroutine check_state(model, error)
    type(model_type), intent(in) :: model
    !> error_other
    type(error_type), allocatable, intent(out) :: error

    call check_points(model%state%points, error)
    call check_surface(model%state%surface, error)
    call check_carried(model%state%tracers, 'tracer', error)
    call check_carried(model%state%watched, 'watched place', error)
    call check(model%state%watched%pushed, 'push', 'watched place', error)
    call check(model%state%coordinates, 'position', 'node', error)
    call check(model%state%reactions, 'reaction', 'node', error)
    call check(model%state%released, 'released force', 'node', error)
    call check_progress(model%state%plate, model%state%progress, error)
  end subroutine check_state

  !> The material points.
  subroutine check_points(points, error)
    type(points_type), intent(in) :: points
    type(error_type), allocatable, intent(inout) :: error
    character(len=*), parameter :: noun = 'material point'

    call check_carried(points, noun, error)
    call check(points%volume, 'volume', noun, error)
    call check(points%initial_volume, 'initial volume', noun, error)
    call check(points%weight, 'weight', noun, error)
    call check(points%half_size, 'domain', noun, error)
    call check(points%stress, 'stress', noun, error)
    call check(points%state, 'state', noun, error)
    call check(points%deformation_gradient, 'deformation gradient', noun, error)
  end subroutine check_points

  !> The points of loaded and supported surfaces.
  subroutine check_surface(surface, error)
    type(surface_points_type), intent(in) :: surface
    type(error_type), allocatable, intent(inout) :: error
    character(len=*), parameter :: noun = 'surface point'

    call check_carried(surface, noun, error)
    call check(surface%area, 'area', noun, error)
    call check(surface%area_vector, 'area vector', noun, error)
    call check(surface%normal, 'normal', noun, error)
    call check(surface%reaction, 'reaction', noun, error)
    call check(surface%released, 'released force', noun, error)
  end subroutine check_surface

  !> Positions of what rides on the mesh.
  subroutine check_carried(carried, noun, error)
    class(carried_type), intent(in) :: carried
    character(len=*), intent(in) :: noun
    type(error_type), allocatable, intent(inout) :: error

    call check(carried%position, 'position', noun, error)
    call check(carried%initial_position, 'initial position', noun, error)
    call check(carried%local, 'local coordinate', noun, error)
  end subroutine check_carried

  !> Where the analysis stands, and the plate of a moving mesh.
  subroutine check_progress(plate, progress, error)
    real(wp), intent(in) :: plate
    type(progress_type), intent(in) :: progress
    type(error_type), allocatable, intent(inout) :: error

    if (allocated(error)) return
    if (.not. is_usable(plate)) call fail(error, error_other, 'the plate of the moving mesh has a position'//unusable)
    if (.not. (is_usable(progress%fraction) .and. is_usable(progress%next_step) .and. is_usable(progress%proximal))) &
      call fail(error, error_other, 'the step has a load fraction, a length or a damping'//unusable)
    if (.not. (is_usable(progress%external_work) .and. is_usable(progress%internal_work))) &
      call fail(error, error_other, 'the steps so far have a work'//unusable)
  end subroutine check_progress

  !> One number a point.
  subroutine check_scalars(values, name, noun, error)
    real(wp), intent(in) :: values(:)
    !> What it is and of what.
    character(len=*), intent(in) :: name, noun
    type(error_type), allocatable, intent(inout) :: error

    if (allocated(error)) return
    if (all_usable(size(values), values)) return
    call fail(error, error_other, noun//' '//integer_text(findloc(is_usable(values), .false., dim=1))// &
      ' has a '//name//unusable)
  end subroutine check_scalars

  !> Several numbers a point (numbers, points).
  subroutine check_vectors(values, name, noun, error)
    real(wp), intent(in) :: values(:, :)
    !> What they are and of what.
    character(len=*), intent(in) :: name, noun
    type(error_type), allocatable, intent(inout) :: error

    if (allocated(error)) return
    if (all_usable(size(values), values)) return
    call fail(error, error_other, noun//' '//integer_text(findloc(all(is_usable(values), dim=1), .false., dim=1))// &
      ' has a '//name//unusable)
  end subroutine check_vectors
end module qsmpm_usable_state
