!> The smallest model that answers a scene: the reductions are tried in turn, each is proved from the
!> data of the deck before it is used, and the verdicts are kept for the plan and the log.
!>
!> With *MODEL, TYPE=AUTO what is proved is used; otherwise the verdicts only tell what could be. A
!> mirror is used unasked only where `mirror_reservation` has nothing against it.
module qsmpm_scene
  use qsmpm_analysis, only: analysis_type, three_dimensional, axisymmetric, mirror_yes, mirror_no
  use qsmpm_reduction, only: reduction_type, expansion_type, verdict_type, reduce_prismatic, reduce_revolved, &
    reduce_column, reduce_mirror, append_step, refuse
  use qsmpm_prismatic, only: prove_prismatic, make_plane
  use qsmpm_revolved, only: figure_type, prove_revolved
  use qsmpm_revolved_half, only: make_revolved
  use qsmpm_column, only: prove_column, make_column
  use qsmpm_mirror, only: prove_mirror, mirror_reservation
  use qsmpm_mirror_half, only: make_half
  use qsmpm_softening_parameters, only: regularise_cell
  implicit none
  private

  public :: reduce_scene, verdict_text

  !> What is tried, in this order: kind and axis.
  integer, parameter :: tries(2, 5) = reshape([reduce_prismatic, 3, reduce_revolved, 0, reduce_column, 1, &
    reduce_mirror, 1, reduce_mirror, 3], [2, 5])

contains

  !> Find the smallest model.
  subroutine reduce_scene(scene, model, expansion, verdicts)
    !> The scene as the deck says it.
    type(analysis_type), intent(in) :: scene
    !> What is to be modelled: the scene itself when nothing is used.
    type(analysis_type), intent(out) :: model
    !> The way back, without steps when nothing is used.
    type(expansion_type), intent(out) :: expansion
    !> What was found, one for each try.
    type(verdict_type), allocatable, intent(out) :: verdicts(:)
    type(analysis_type) :: smaller
    type(reduction_type) :: step
    type(figure_type) :: figure
    integer :: i

    model = scene
    smaller = scene
    allocate (expansion%steps(0), verdicts(size(tries, 2)))
    do i = 1, size(verdicts)
      verdicts(i)%kind = tries(1, i)
      verdicts(i)%axis = tries(2, i)
      call judge(smaller, verdicts(i), figure)
      if (.not. verdicts(i)%possible) cycle
      call take_if_wanted(scene, smaller, verdicts(i))
      ! Where the deck wants no reduction the verdicts go on as if it did.
      if (.not. (verdicts(i)%used .or. .not. scene%reduce)) cycle
      call apply(verdicts(i), figure, smaller, step)
      if (.not. verdicts(i)%used) cycle
      call append_step(expansion, step)
      model = smaller
    end do
  end subroutine reduce_scene

  !> Prove one reduction, or find why it is not possible.
  subroutine judge(analysis, verdict, figure)
    !> The scene so far.
    type(analysis_type), intent(in) :: analysis
    !> Kind and axis in, proof out.
    type(verdict_type), intent(inout) :: verdict
    !> Section of a figure of revolution.
    type(figure_type), intent(inout) :: figure
    integer :: m

    if (analysis%model == axisymmetric) then
      call refuse(verdict%reason, 'the scene is axisymmetric already')
      return
    end if
    do m = 1, size(analysis%materials)
      associate (material => analysis%materials(m))
        if (material%user%given .or. material%own_law) call refuse(verdict%reason, 'nothing is known of the '// &
          "model of material '"//material%name//"'")
        if (material%softening%given .and. material%softening%regularisation == regularise_cell .and. &
          verdict%kind /= reduce_mirror) call refuse(verdict%reason, "the width of the cells, by which material '"// &
          material%name//"' softens, would be another one")
      end associate
    end do
    if (allocated(verdict%reason)) return
    select case (verdict%kind)
    case (reduce_prismatic)
      call prove_prismatic(analysis, verdict%reason)
    case (reduce_revolved)
      call prove_revolved(analysis, figure, verdict%reason)
    case (reduce_column)
      call prove_column(analysis, verdict%reason)
    case default
      if (verdict%axis == 3 .and. analysis%model /= three_dimensional) then
        call refuse(verdict%reason, 'there is no z in the model')
      else
        call prove_mirror(analysis, verdict%axis, verdict%reason)
      end if
    end select
    verdict%possible = .not. allocated(verdict%reason)
  end subroutine judge

  !> Decide on a reduction that is proved.
  pure subroutine take_if_wanted(scene, analysis, verdict)
    !> The scene as the deck says it, and so far.
    type(analysis_type), intent(in) :: scene, analysis
    !> What was found, and what is done.
    type(verdict_type), intent(inout) :: verdict
    character(len=:), allocatable :: reservation

    reservation = ''
    if (verdict%kind == reduce_mirror) then
      reservation = mirror_reservation(analysis)
      if (scene%mirror == mirror_yes) reservation = ''
      if (len(reservation) > 0) reservation = reservation//'; MIRROR=YES of *MODEL takes it'
      if (scene%mirror == mirror_no) reservation = 'refused by MIRROR=NO of *MODEL'
    end if
    if (.not. scene%reduce) reservation = 'TYPE=AUTO of *MODEL takes it'//trim_reservation(reservation)
    verdict%used = len(reservation) == 0
    if (len(reservation) > 0) verdict%reason = reservation
  end subroutine take_if_wanted

  !> A reservation behind another sentence.
  pure function trim_reservation(reservation) result(text)
    !> Empty for none.
    character(len=*), intent(in) :: reservation
    character(len=:), allocatable :: text

    text = ''
    if (len(reservation) > 0) text = ' with MIRROR=YES ('//reservation(:index(reservation//';', ';') - 1)//')'
  end function trim_reservation

  !> Make the smaller scene.
  pure subroutine apply(verdict, figure, analysis, step)
    !> Kind and axis.
    type(verdict_type), intent(in) :: verdict
    !> Section of a figure of revolution.
    type(figure_type), intent(in) :: figure
    !> The scene so far; the smaller one.
    type(analysis_type), intent(inout) :: analysis
    !> The way back.
    type(reduction_type), intent(out) :: step

    select case (verdict%kind)
    case (reduce_prismatic)
      call make_plane(analysis, step)
    case (reduce_revolved)
      call make_revolved(analysis, figure, step)
    case (reduce_column)
      call make_column(analysis, step)
    case default
      call make_half(analysis, verdict%axis, step)
    end select
  end subroutine apply

  !> A verdict as a sentence.
  pure function verdict_text(verdict) result(text)
    !> What was found.
    type(verdict_type), intent(in) :: verdict
    character(len=:), allocatable :: text

    if (verdict%used) then
      text = 'used'
    else if (verdict%possible) then
      text = 'possible, not used: '//verdict%reason
    else
      text = 'not possible: '//verdict%reason
    end if
  end function verdict_text
end module qsmpm_scene
