!> Soil inside rigid bodies. Contact is imposed at surface points: where the surface is folded or has gaps, or the body
!> has corners smaller than a patch, soil may enter a body without contact. It is detected by the material points. Where
!> contact is imposed at points of the body, soil may drift away from it and still transmit pressure over a gap; this is
!> detected by the material points too (qsmpm_contact_results).
!>
!> On a body the contact condition holds for the mean over a patch, and where soil closes behind the body single points
!> would gradually enter it. They are moved back onto the outline along its normal; only their position is corrected.
module qsmpm_penetration
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: lowest_rank
  use qsmpm_contact_results, only: penetration_type, deepest_point
  use qsmpm_error, only: error_type, fail, error_not_converged
  use qsmpm_team, only: spread_from
  use qsmpm_model, only: model_type
  use qsmpm_observer, only: observer_type
  use qsmpm_points, only: place_of
  use qsmpm_rigid_bodies, only: placed_bodies
  use qsmpm_rigid_pose, only: placed_shape_type
  use qsmpm_rigid_shape, only: distance_type
  implicit none
  private

  public :: refuse_penetration, put_back, penetration_check_type, warn_of_penetration

  !> Depths in cell sizes above which a warning is printed, and above which the step is rejected.
  real(wp), parameter :: noticed = 0.1_wp, refused = 0.5_wp
  !> Gap in cell sizes above which a warning is printed: material points fill the sector of a patch up to 0.5.
  real(wp), parameter :: noticed_gap = 0.75_wp
  !> Cosine between the outward normals of soil and body above which a point of the surface is on the wrong side of it.
  real(wp), parameter :: same_way = 0.5_wp

  !> Reports made so far.
  type :: penetration_check_type
    !> Depth last reported, in cells.
    real(wp) :: reported = noticed
    !> Gap last reported, in cells.
    real(wp) :: reported_gap = noticed_gap
    !> A folded surface has been reported.
    logical :: reported_fold = .false.
  end type penetration_check_type

contains

  !> Rejects a step that leaves soil deep inside a body.
  subroutine refuse_penetration(model, bodies, found, error)
    !> The model with its points at their position at the end of the step.
    type(model_type), intent(in) :: model
    !> Bodies at their position at the end of the step (rigid bodies).
    type(placed_shape_type), intent(in) :: bodies(:)
    type(penetration_type), intent(out) :: found
    !> error_not_converged: names body, depth and place.
    type(error_type), allocatable, intent(out) :: error
    integer :: point

    call deepest_point(model, bodies, found%body, point, found%depth)
    if (point > 0) found%deepest = place_of(model%state%points, point)
    if (found%depth > refused*model%cell_size) call fail(error, error_not_converged, sentence(model, found))
  end subroutine refuse_penetration

  !> Moves points that are inside bodies with contact on their outline back onto the outline.
  subroutine put_back(model, bodies)
    type(model_type), intent(inout) :: model
    !> Bodies at their position at the end of the step (rigid bodies).
    type(placed_shape_type), intent(in) :: bodies(:)
    type(distance_type) :: distance
    integer :: k, p, d

    d = model%mesh%dimension
    do k = 1, size(model%contact_pairs)
      if (model%contact_pairs(k)%surface > 0) cycle
      do p = 1, model%state%points%count
        distance = bodies(model%contact_pairs(k)%body)%distance_at(place_of(model%state%points, p))
        if (distance%value < 0.0_wp) model%state%points%position(:, p) = model%state%points%position(:, p) &
          - distance%value*distance%normal(:d)
      end do
    end do
  end subroutine put_back

  !> Warns where soil is inside a body, and again when the depth has doubled.
  subroutine warn_of_penetration(model, found, check, observer)
    type(model_type), intent(in) :: model
    !> Penetration in the step.
    type(penetration_type), intent(in) :: found
    type(penetration_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer

    call warn_of_gap(model, found, check, observer)
    call warn_of_fold(model, check, observer)
    if (.not. found%depth > check%reported*model%cell_size) return
    check%reported = 2.0_wp*found%depth/model%cell_size
    call observer%note('warning: '//sentence(model, found)//'; the surface of its *CONTACT must extend to that '// &
      'place; otherwise use smaller steps, a larger ROUND of *RIGID BODY or smaller cells')
  end subroutine warn_of_penetration

  !> Warns where soil presses on a body over a gap, and again when the gap has doubled.
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
      trim(adjustl(buffer))//': soil is missing in that gap; use smaller steps and cells')
  end subroutine warn_of_gap

  !> Warns once where a surface in contact faces away from its body: the surface has folded over, and the soil in
  !> contact is not represented by surface points.
  subroutine warn_of_fold(model, check, observer)
    type(model_type), intent(in) :: model
    type(penetration_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer
    type(placed_shape_type), allocatable :: bodies(:)
    type(distance_type) :: distance
    character(len=80) :: buffer
    real(wp) :: place(model%mesh%dimension)
    logical :: folds
    integer :: i, k, rank

    if (check%reported_fold) return
    allocate (bodies, source=placed_bodies(model))
    folds = .false.
    k = 0
    do i = 1, model%state%surface%count
      if (.not. model%state%surface%contact_pressure(i) > 0.0_wp) cycle
      k = findloc(model%contact_pairs%surface, model%state%surface%surface(i), dim=1)
      if (k == 0) cycle
      distance = bodies(model%contact_pairs(k)%body)%distance_at(place_of(model%state%surface, i))
      associate (vector => model%state%surface%area_vector(:, i), d => model%mesh%dimension)
        if (dot_product(vector, distance%normal(:d)) < same_way*norm2(vector)) cycle
      end associate
      folds = .true.
      place = model%state%surface%position(:, i)
      exit
    end do
    associate (team => model%part%team)
      rank = lowest_rank(team, folds)
      if (rank == team%ranks) return
      call spread_from(team, rank, k)
      call spread_from(team, rank, place)
    end associate
    check%reported_fold = .true.
    write (buffer, '(3(1x,es11.4))') place
    call observer%note("warning: the surface of the soil is folded at rigid body '"//model%analysis%rigid_bodies( &
      model%contact_pairs(k)%body)%name//"' at "//trim(adjustl(buffer))//': the pressure there is not '// &
      'reliable; ON=BODY enforces contact on the body itself')
  end subroutine warn_of_fold

  !> Returns the message: depth, place and body.
  pure function sentence(model, found) result(text)
    type(model_type), intent(in) :: model
    type(penetration_type), intent(in) :: found
    character(len=:), allocatable :: text
    character(len=80) :: buffer

    write (buffer, '(3(1x,es11.4))') found%deepest(:model%mesh%dimension)
    text = 'soil at '//trim(adjustl(buffer))//' is '
    write (buffer, '(f8.2)') found%depth/model%cell_size
    text = text//trim(adjustl(buffer))//" cells inside rigid body '"//model%analysis%rigid_bodies(found%body)%name//"'"
  end function sentence
end module qsmpm_penetration
