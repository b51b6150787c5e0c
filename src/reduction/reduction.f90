!> Reductions of a scene as plain data: one `reduction_type` for each step from the scene of the deck to the model that
!> is run, with all data required to expand the results of the model to those of the scene. The checks are in the
!> modules of the single reductions, the expansion of results is in `qsmpm_images`.
module qsmpm_reduction
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_examined_scene, only: letters
  use qsmpm_mesh_description, only: axis_type
  use qsmpm_phase_description, only: stop_above, stop_below
  implicit none
  private

  public :: reduction_type, expansion_type, layers_type, reduction_check_type
  public :: reduction_name, begin_reduction, history_of_scene, move_stops

  !> Kinds of reduction, in the order in which they are tried.
  integer, parameter, public :: reduce_prismatic = 1, reduce_revolved = 2, reduce_column = 3, reduce_mirror = 4

  !> Layers of the points of a body between two grid lines.
  type :: layers_type
    !> Position between the lines, 0 to 1, and share of the volume (layers).
    real(wp), allocatable :: place(:), share(:)
  end type layers_type

  !> One step from a scene to a smaller one.
  type :: reduction_type
    integer :: kind = 0
    !> Axis that is omitted, halved or reduced to one cell; 0 for a figure of revolution.
    integer :: axis = 0
    !> Forces and work of the scene relative to those of the model.
    real(wp) :: factor = 1.0_wp
    !> Grid lines of the scene before this step; along z only in 3D.
    type(axis_type) :: lines(3)
    !> Number of elements into which a quadrilateral or brick of the grid is divided.
    integer :: pieces = 1
    !> Coordinate of a mirror plane; axis of a figure of revolution: x and z, and its sector in radians.
    real(wp) :: plane = 0.0_wp, centre(2) = 0.0_wp, sector(2) = 0.0_wp
    !> Layers of the points of each body of the smaller scene between two lines of a repeated axis (bodies).
    type(layers_type), allocatable :: layers(:)
    !> Body of the scene that corresponds to each body of the smaller scene, and that of its mirror image (bodies).
    integer, allocatable :: body(:), image_body(:)
    !> Histories: value of the scene = offset + factor * value of the smaller scene, without SCALE.
    real(wp), allocatable :: history_factor(:), history_offset(:)
  end type reduction_type

  !> All steps, from the scene to the model.
  type :: expansion_type
    type(reduction_type), allocatable :: steps(:)
  end type expansion_type

  !> Result of the check of one reduction.
  type :: reduction_check_type
    integer :: kind = 0
    integer :: axis = 0
    !> Admissible; and used in the model that is run.
    logical :: possible = .false.
    logical :: used = .false.
    !> Why it is not possible, why it is possible but not used, or what is done.
    character(len=:), allocatable :: reason
  end type reduction_check_type

contains

  !> Converts the history values at which phases stop to those of the smaller scene. A history that is constant there
  !> never reaches its value.
  pure subroutine move_stops(step, analysis)
    !> Expansion step.
    type(reduction_type), intent(in) :: step
    !> The smaller scene.
    class(analysis_type), intent(inout) :: analysis
    integer :: p, i, h

    do p = 1, size(analysis%phases)
      do i = 1, size(analysis%phases(p)%stops)
        associate (place => analysis%phases(p)%stops(i))
          do h = 1, size(analysis%histories)
            if (analysis%histories(h)%name /= place%history) cycle
            if (step%history_factor(h) < 0.0_wp) place%side = merge(stop_below, stop_above, place%side == stop_above)
            if (abs(step%history_factor(h)) > 0.0_wp) then
              place%value = (place%value - analysis%histories(h)%scale*step%history_offset(h)) /step%history_factor(h)
            else
              place%value = merge(huge(1.0_wp), -huge(1.0_wp), place%side == stop_above)
            end if
          end do
        end associate
      end do
    end do
  end subroutine move_stops

  !> Returns the name of a reduction as in plan and log.
  pure function reduction_name(kind, axis) result(name)
    !> One of the reduce_* values.
    integer, intent(in) :: kind
    integer, intent(in) :: axis
    character(len=:), allocatable :: name

    select case (kind)
    case (reduce_prismatic)
      name = 'plane strain'
    case (reduce_revolved)
      name = 'axisymmetry'
    case (reduce_column)
      name = 'single column'
    case default
      name = 'mirror in '//letters(max(1, axis))
    end select
  end function reduction_name

  !> Initialises a step without effect.
  pure subroutine begin_reduction(analysis, kind, axis, step)
    !> The scene before the step.
    class(analysis_type), intent(in) :: analysis
    !> One of the reduce_* values, and its axis.
    integer, intent(in) :: kind, axis
    type(reduction_type), intent(out) :: step
    integer :: i

    step%kind = kind
    step%axis = axis
    do i = 1, 3
      if (allocated(analysis%mesh%axes(i)%lines)) step%lines(i)%lines = analysis%mesh%axes(i)%lines
    end do
    step%pieces = 1
    if (index(analysis%mesh%element, 'TRI') == 1 .or. index(analysis%mesh%element, 'WEDGE') == 1) step%pieces = 2
    step%body = [(i, i=1, size(analysis%bodies))]
    step%image_body = step%body
    allocate (step%history_factor(size(analysis%histories)), source=1.0_wp)
    allocate (step%history_offset(size(analysis%histories)), source=0.0_wp)
  end subroutine begin_reduction

  !> Returns the value of a history of the scene from that of the model, both before SCALE.
  pure real(wp) function history_of_scene(expansion, number, value)
    type(expansion_type), intent(in) :: expansion
    !> Number of the history.
    integer, intent(in) :: number
    !> Value in the model.
    real(wp), intent(in) :: value
    integer :: s

    history_of_scene = value
    do s = size(expansion%steps), 1, -1
      history_of_scene = expansion%steps(s)%history_offset(number) &
        + expansion%steps(s)%history_factor(number)*history_of_scene
    end do
  end function history_of_scene
end module qsmpm_reduction
