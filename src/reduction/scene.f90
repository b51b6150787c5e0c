!> Search for the smallest model that gives the results of a scene: the reductions are tried in turn, each is checked by
!> the data of the deck before it is used, and the results of the checks are stored for the plan and the log.
!>
!> With *MODEL, TYPE=AUTO admissible reductions are used; otherwise the checks only report them. A mirror is used
!> automatically only if `reason_against_mirror` returns no reason.
module qsmpm_scene
  use qsmpm_analysis, only: analysis_type, three_dimensional, axisymmetric, mirror_yes, mirror_no
  use qsmpm_phase_description, only: initial_given
  use qsmpm_reduction, only: reduction_type, expansion_type, reduction_check_type, reduce_prismatic, reduce_revolved, &
    reduce_column, reduce_mirror, move_stops
  use qsmpm_examined_scene, only: examined_type, examine, refuse, card, place_text
  use qsmpm_carried_cards, only: not_carried
  use qsmpm_prismatic, only: require_prismatic, make_plane, require_column, make_column
  use qsmpm_revolved, only: revolved_solid_type, require_revolved, make_revolved
  use qsmpm_mirror, only: require_mirror, reason_against_mirror, make_half
  use qsmpm_material_parameters, only: regularise_none
  implicit none
  private

  public :: reduce_scene, check_text

  !> Reductions in the order in which they are tried: kind and axis.
  integer, parameter :: tries(2, 5) = reshape([reduce_prismatic, 3, reduce_revolved, 0, reduce_column, 1, &
    reduce_mirror, 1, reduce_mirror, 3], [2, 5])

contains

  !> Finds the smallest model.
  subroutine reduce_scene(scene, model, expansion, checks)
    !> The scene of the deck.
    type(analysis_type), intent(in) :: scene
    !> The model: the scene itself if no reduction is used.
    type(analysis_type), intent(out) :: model
    !> Expansion of the model, without steps if no reduction is used.
    type(expansion_type), intent(out) :: expansion
    !> Results of the checks, one for each trial.
    type(reduction_check_type), allocatable, intent(out) :: checks(:)
    type(examined_type), allocatable :: smaller
    type(reduction_type) :: step
    type(revolved_solid_type) :: figure
    integer :: i

    model = scene
    allocate (smaller)
    smaller%analysis_type = scene
    allocate (expansion%steps(0), checks(size(tries, 2)))
    do i = 1, size(checks)
      checks(i)%kind = tries(1, i)
      checks(i)%axis = tries(2, i)
      call examine(smaller, checks(i)%axis)
      call judge(smaller, checks(i)%kind, figure)
      checks(i)%possible = .not. allocated(smaller%reason)
      if (.not. checks(i)%possible) then
        checks(i)%reason = smaller%reason
        cycle
      end if
      call take_if_wanted(scene, smaller, checks(i))
      ! If the deck requests no reduction, the further checks assume the reduced scene nevertheless.
      if (.not. (checks(i)%used .or. .not. scene%reduce)) cycle
      call apply(checks(i)%kind, figure, smaller, step)
      call move_stops(step, smaller)
      if (.not. checks(i)%used) cycle
      expansion%steps = [expansion%steps, step]
      model = smaller%analysis_type
    end do
  end subroutine reduce_scene

  !> Checks one reduction, or finds why it is not possible.
  subroutine judge(scene, kind, figure)
    !> The scene so far, examined for its axis.
    type(examined_type), intent(inout) :: scene
    !> One of the reduce_* values.
    integer, intent(in) :: kind
    !> Section of a figure of revolution.
    type(revolved_solid_type), intent(inout) :: figure
    integer :: m

    if (scene%model == axisymmetric) then
      call refuse(scene, 'the scene is axisymmetric already')
      return
    end if
    do m = 1, size(scene%materials)
      associate (material => scene%materials(m))
        if (material%user%given .or. material%own_law) &
          call refuse(scene, "nothing is known of the model of material '"//material%name//"'")
        if (allocated(material%strength_profile%fields) .or. material%strength_profile%given .and. &
          material%strength_profile%along /= 2) &
          call refuse(scene, "material '"//material%name//"' differs along more than y")
        if (material%softening%given .and. material%softening%regularisation /= regularise_none .and. &
          kind /= reduce_mirror) call refuse(scene, "the width of the cells, by which material '"//material%name// &
          "' softens, would be another one")
      end associate
    end do
    if (len(not_carried(scene%analysis_type)) > 0) &
      call refuse(scene, not_carried(scene%analysis_type)//' is not known to reductions')
    if (size(scene%props) > 0) &
      call refuse(scene, card('*PROP', scene%props(1)%name, scene%props(1)%where)//' stands in one place')
    do m = 1, size(scene%phases)
      if (scene%phases(m)%initial%kind == initial_given) call refuse(scene, '*INITIAL, TYPE=GIVEN'// &
        place_text(scene%phases(m)%initial%where)//' gives stresses place by place')
    end do
    if (allocated(scene%reason)) return
    select case (kind)
    case (reduce_prismatic)
      call require_prismatic(scene)
    case (reduce_revolved)
      call require_revolved(scene, figure)
    case (reduce_column)
      call require_column(scene)
    case default
      if (scene%axis == 3 .and. scene%model /= three_dimensional) then
        call refuse(scene, 'there is no z in the model')
      else
        call require_mirror(scene)
      end if
    end select
  end subroutine judge

  !> Decides whether an admissible reduction is used.
  pure subroutine take_if_wanted(scene, smaller, check)
    !> The scene of the deck, and the scene so far.
    type(analysis_type), intent(in) :: scene
    type(examined_type), intent(in) :: smaller
    !> Result of the check, and what is done.
    type(reduction_check_type), intent(inout) :: check
    character(len=:), allocatable :: reason_against

    reason_against = ''
    if (check%kind == reduce_mirror) then
      reason_against = reason_against_mirror(smaller)
      if (scene%mirror == mirror_yes) reason_against = ''
      if (len(reason_against) > 0) reason_against = reason_against//'; MIRROR=YES of *MODEL takes it'
      if (scene%mirror == mirror_no) reason_against = 'refused by MIRROR=NO of *MODEL'
    end if
    if (.not. scene%reduce) then
      ! A reservation is appended to another sentence.
      if (len(reason_against) > 0) reason_against = ' with MIRROR=YES ('// &
        reason_against(:index(reason_against//';', ';') - 1)//')'
      reason_against = 'TYPE=AUTO of *MODEL takes it'//reason_against
    end if
    check%used = len(reason_against) == 0
    if (.not. check%used) check%reason = reason_against
  end subroutine take_if_wanted

  !> Makes the smaller scene.
  pure subroutine apply(kind, figure, scene, step)
    !> One of the reduce_* values.
    integer, intent(in) :: kind
    !> Section of a figure of revolution.
    type(revolved_solid_type), intent(in) :: figure
    !> The scene so far, examined; on return the smaller one.
    type(examined_type), intent(inout) :: scene
    !> Expansion step.
    type(reduction_type), intent(out) :: step

    select case (kind)
    case (reduce_prismatic)
      call make_plane(scene, step)
    case (reduce_revolved)
      call make_revolved(scene, figure, step)
    case (reduce_column)
      call make_column(scene, step)
    case default
      call make_half(scene, step)
    end select
  end subroutine apply

  !> Returns the result of a check as a sentence.
  pure function check_text(check) result(text)
    type(reduction_check_type), intent(in) :: check
    character(len=:), allocatable :: text

    if (check%used) then
      text = 'used'
    else if (check%possible) then
      text = 'possible, not used: '//check%reason
    else
      text = 'not possible: '//check%reason
    end if
  end function check_text
end module qsmpm_scene
