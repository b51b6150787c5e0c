!> Sides of the mesh that material cannot cross: planes of symmetry, the axis of axisymmetry, smooth walls.
!>
!> Where the displacement along its normal is held on a side, the side does not move, and nothing passes it. Functions
!> that are means over the box of a point (GIMP, SPLINE2G) do not vanish at a point on the side, whose box is cut off
!> there, so that points creep across, a share of the step at a time. Such a point is put back where its mirror image
!> enters, as far inside as it was outside: a place corrected, nothing else. Points at rest on an axis are not put onto
!> the axis itself, where hoop strains are not defined.
!>
!> Only the ends of the mesh along the axes are looked at; elsewhere a point that is too far outside is lost
!> (qsmpm_point_location).
module qsmpm_held_sides
  use qsmpm_kinds, only: wp
  use qsmpm_mesh_search, only: locate
  use qsmpm_model, only: model_type
  use qsmpm_observer, only: observer_type
  use qsmpm_points, only: carried_type
  use qsmpm_space, only: shape_values_type, functions_at
  implicit none
  private

  public :: keep_inside, side_check_type, warn_of_crossing

  !> Way across a side in a step over the size of a cell that is warned of.
  real(wp), parameter :: noticed = 0.1_wp
  !> Functions that are smaller are none at a side.
  real(wp), parameter :: negligible = 1.0e-9_wp

  !> What has been reported so far.
  type :: side_check_type
    !> Way last reported, in cells.
    real(wp) :: reported = noticed
  end type side_check_type

contains

  !> Put back what a step has carried across held sides.
  subroutine keep_inside(model, displacement, farthest)
    type(model_type), intent(inout) :: model
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> The longest way of a material point across a side; 0 where none crosses.
    real(wp), intent(out) :: farthest
    real(wp) :: of_others

    associate (state => model%state)
      call put_back(model, displacement, state%points, farthest)
      call put_back(model, displacement, state%surface, of_others)
      call put_back(model, displacement, state%tracers, of_others)
      call put_back(model, displacement, state%watched, of_others)
    end associate
  end subroutine keep_inside

  !> Put some of it back.
  subroutine put_back(model, displacement, carried, farthest)
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: displacement(:, :)
    class(carried_type), intent(inout) :: carried
    real(wp), intent(out) :: farthest
    real(wp) :: foot(model%mesh%dimension), beyond
    integer :: i, a

    farthest = 0.0_wp
    associate (low => model%mesh%bounds(:, 1), high => model%mesh%bounds(:, 2))
      do i = 1, carried%count
        ! A place that another process of the team looks after.
        if (carried%cell(i) == 0) cycle
        if (all(carried%position(:, i) >= low .and. carried%position(:, i) <= high)) cycle
        foot = min(max(carried%position(:, i), low), high)
        do a = 1, size(foot)
          beyond = carried%position(a, i) - foot(a)
          if (.not. abs(beyond) > 0.0_wp) cycle
          if (.not. is_held(model, displacement, carried%cell(i), foot, a)) cycle
          carried%position(a, i) = foot(a) - beyond
          farthest = max(farthest, abs(beyond))
        end do
      end do
    end associate
  end subroutine put_back

  !> Whether a place on a side does not move along an axis because it is held.
  logical function is_held(model, displacement, near, foot, axis) result(held)
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: displacement(:, :)
    !> A cell not far from the place.
    integer, intent(in) :: near
    real(wp), intent(in) :: foot(:)
    integer, intent(in) :: axis
    type(shape_values_type) :: place
    real(wp) :: local(size(foot))
    integer :: a, cell

    cell = near
    call locate(model%mesh, foot, cell, local, held)
    if (.not. held) return
    call functions_at(model%space, model%mesh, cell, local, place)
    do a = 1, place%count
      if (abs(place%shape(a)) <= negligible) cycle
      held = held .and. model%loading%constrained(axis, place%node(a)) &
        .and. .not. abs(displacement(axis, place%node(a))) > 0.0_wp
    end do
  end function is_held

  !> Warn where points have been carried far across a held side, and again when it is twice as far.
  subroutine warn_of_crossing(cell_size, crossing, check, observer)
    real(wp), intent(in) :: cell_size
    !> Of the step.
    real(wp), intent(in) :: crossing
    type(side_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer
    character(len=12) :: buffer

    if (.not. crossing > check%reported*cell_size) return
    check%reported = 2.0_wp*crossing/cell_size
    write (buffer, '(f8.2)') crossing/cell_size
    call observer%note('warning: a step carries material points by '//trim(adjustl(buffer))// &
      ' cells across a side of the mesh that is held; they are put back, as far inside: smaller steps')
  end subroutine warn_of_crossing
end module qsmpm_held_sides
