!> Soil inside rigid bodies. Contact is asked for at surface points: where the surface is folded, has gaps or the body
!> has corners smaller than a patch, soil may get into a body unseen. The material points tell. Where contact is asked
!> for on the body soil may drift away from it and press from afar; they tell that too.
module qsmpm_penetration
  use qsmpm_kinds, only: wp
  use qsmpm_contact_results, only: penetration_type, deepest_point
  use qsmpm_error, only: error_type, fail, error_not_converged
  use qsmpm_model, only: model_type
  use qsmpm_observer, only: observer_type
  use qsmpm_rigid_pose, only: placed_shape_type
  implicit none
  private

  public :: refuse_penetration, penetration_check_type, warn_of_penetration

  !> Depths over the size of a cell that are warned of, and refused.
  real(wp), parameter :: noticed = 0.1_wp, refused = 0.5_wp
  !> Gap over the size of a cell that is warned of.
  real(wp), parameter :: noticed_gap = 0.5_wp

  !> What has been reported so far.
  type :: penetration_check_type
    !> Depth last reported, in cells.
    real(wp) :: reported = noticed
    !> Gap last reported, in cells.
    real(wp) :: reported_gap = noticed_gap
  end type penetration_check_type

contains

  !> A step that leaves soil deep inside a body is no step.
  subroutine refuse_penetration(model, bodies, error)
    !> Its points where they are at the end of the step.
    type(model_type), intent(in) :: model
    !> The bodies where they are at the end of the step (rigid bodies).
    type(placed_shape_type), intent(in) :: bodies(:)
    !> error_not_converged: names body, depth and place.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: depth
    integer :: body, point

    call deepest_point(model, bodies, body, point, depth)
    if (depth > refused*model%cell_size) call fail(error, error_not_converged, sentence(model, body, point, depth))
  end subroutine refuse_penetration

  !> Warn where soil is inside a body, and again when it is twice as deep.
  subroutine warn_of_penetration(model, found, check, observer)
    type(model_type), intent(in) :: model
    !> In the state of the model.
    type(penetration_type), intent(in) :: found
    type(penetration_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer

    call warn_of_gap(model, found, check, observer)
    if (.not. found%depth > check%reported*model%cell_size) return
    check%reported = 2.0_wp*found%depth/model%cell_size
    call observer%note('warning: '//sentence(model, found%body, found%point, found%depth)// &
      '; the surface of its *CONTACT must reach there; else smaller steps, a larger ROUND of *RIGID BODY or '// &
      'smaller cells')
  end subroutine warn_of_penetration

  !> Warn where soil presses on a body from afar, and again when it is twice as far.
  subroutine warn_of_gap(model, found, check, observer)
    type(model_type), intent(in) :: model
    type(penetration_type), intent(in) :: found
    type(penetration_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer
    character(len=80) :: buffer

    if (.not. found%gap > check%reported_gap*model%cell_size) return
    check%reported_gap = 2.0_wp*found%gap/model%cell_size
    write (buffer, '(f8.2,a,2(1x,es11.4))') found%gap/model%cell_size, ' cells away at', found%place
    call observer%note("warning: soil presses on rigid body '"//model%analysis%rigid_bodies(found%pressed)%name// &
      "' from "// &
      trim(adjustl(buffer))//': it has drifted from the body, whose place is wrong by as much; smaller steps and cells')
  end subroutine warn_of_gap

  !> How deep, where and in which body.
  pure function sentence(model, body, point, depth) result(text)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body, point
    real(wp), intent(in) :: depth
    character(len=:), allocatable :: text
    character(len=80) :: buffer

    write (buffer, '(3(1x,es11.4))') model%state%points%position(:, point)
    text = 'soil at '//trim(adjustl(buffer))//' is '
    write (buffer, '(f8.2)') depth/model%cell_size
    text = text//trim(adjustl(buffer))//" cells inside rigid body '"//model%analysis%rigid_bodies(body)%name//"'"
  end function sentence
end module qsmpm_penetration
