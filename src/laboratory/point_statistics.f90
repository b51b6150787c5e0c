!> Statistics of the steps of a point as text: the state at the end of a stage, and the accuracy of the tangent.
module qsmpm_point_statistics
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type, batch_type
  use qsmpm_number_text, only: integer_text
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_point_curves, only: laboratory_type, laboratory_values
  use qsmpm_point_driver, only: point_type
  use qsmpm_point_test, only: point_test_type, test_shear
  use qsmpm_tangent_check, only: tangent_check_type, check_tangent, good_tangent
  implicit none
  private

  public :: point_statistics_type, take_tangent, tangent_text, state_text

  !> Relative change of the tangent allowed between elastic steps.
  real(wp), parameter :: same_tangent = 5.0e-2_wp

  !> Tangents compared so far: of elastic steps (1), of yielding ones (2), and of a law that does not report yielding
  !> (3).
  type :: point_statistics_type
    integer :: steps = 0
    integer :: iterations = 0
    integer :: compared(3) = 0
    real(wp) :: worst(3) = 0.0_wp
    integer :: worst_step(3) = 0
    !> Tangent of the last elastic step, or of the first step if the law does not report yielding (5,5) or (9,9), and
    !> the smallest distance of the tangent of a yielding step from it.
    real(wp), allocatable :: elastic(:, :)
    real(wp) :: from_elastic = huge(1.0_wp)
  end type point_statistics_type

contains

  !> Checks the tangent of a step.
  subroutine take_tangent(statistics, law, batch, step, error)
    type(point_statistics_type), intent(inout) :: statistics
    class(law_type), intent(in) :: law
    !> The point at the end of the step.
    type(batch_type), intent(in) :: batch
    !> Number of the step.
    integer, intent(in) :: step
    !> Error of the tangent, negative if it cannot be measured.
    real(wp), intent(out) :: error
    type(tangent_check_type) :: check
    integer :: kind

    call check_tangent(law, batch, check)
    error = -1.0_wp
    if (.not. check%made) return
    error = check%error
    kind = merge(2, 1, batch%plastic(1) /= 0)
    if (.not. law%tells_yield) kind = 3
    statistics%compared(kind) = statistics%compared(kind) + 1
    if (error > statistics%worst(kind) .or. statistics%worst_step(kind) == 0) then
      statistics%worst(kind) = error
      statistics%worst_step(kind) = step
    end if
    associate (tangent => batch%tangent(:, :, 1))
      if (kind /= 2 .and. .not. allocated(statistics%elastic)) allocate (statistics%elastic, source=tangent)
      if (kind == 1) then
        statistics%elastic(:, :) = tangent
      else if (allocated(statistics%elastic) .and. error > good_tangent) then
        statistics%from_elastic = min(statistics%from_elastic, &
          maxval(abs(tangent - statistics%elastic))/maxval(abs(tangent)))
      end if
    end associate
  end subroutine take_tangent

  !> Returns the assessment of the tangents.
  pure function tangent_text(statistics) result(text)
    type(point_statistics_type), intent(in) :: statistics
    character(len=:), allocatable :: text
    character(len=8), parameter :: kinds(3) = [character(len=8) :: 'elastic', 'yielding', '']
    integer :: i, left_out

    text = ''
    do i = 1, 3
      if (statistics%compared(i) == 0) cycle
      if (len(text) > 0) text = text//', '
      text = text//rounded_text(statistics%worst(i), 2)//' in '//integer_text(statistics%compared(i))//trim(' '// &
        kinds(i))// &
        trim(merge(' step ', ' steps', statistics%compared(i) == 1))//' (step '// &
          integer_text(statistics%worst_step(i))//')'
    end do
    if (len(text) == 0) then
      text = 'tangent: no step could be compared'
      return
    end if
    left_out = statistics%steps - sum(statistics%compared)
    if (left_out > 0) text = text//', '//integer_text(left_out)//' not compared'
    text = 'tangent: largest error '//text//': '//check(statistics)
  end function tangent_text

  !> Returns whether the tangents are consistent, as required by Newton's method.
  pure function check(statistics) result(text)
    type(point_statistics_type), intent(in) :: statistics
    character(len=:), allocatable :: text

    if (maxval(statistics%worst) <= good_tangent) then
      text = 'it is consistent'
    else if (statistics%worst(1) > good_tangent) then
      text = 'it is wrong in elastic steps already'
    else if (statistics%compared(3) > 0) then
      text = 'it is not consistent in every step (the model does not tell which yield)'
      if (statistics%from_elastic < same_tangent) text = &
        'it is that of the first step in others too (the model does not tell which yield)'
    else if (statistics%from_elastic < same_tangent) then
      text = 'it is the elastic one where the law yields'
    else
      text = 'it is not consistent where the law yields'
    end if
  end function check

  !> Returns the state of the point in a few figures.
  pure function state_text(test, point) result(text)
    type(point_test_type), intent(in) :: test
    type(point_type), intent(in) :: point
    character(len=:), allocatable :: text
    type(laboratory_type) :: values

    values = laboratory_values(test, point)
    text = 'axial strain '//rounded_text(values%axial_strain, 5)//', volumetric '// &
      rounded_text(values%volumetric_strain, 5)//', shear '//rounded_text(values%shear_strain, 5)//', p '// &
      rounded_text(values%p + 0.0_wp, 6)//', q '//rounded_text(values%q, 6)
    if (test%kind == test_shear) text = text//', shear stress '//rounded_text(point%stress(4), 6)// &
      ', vertical stress '//rounded_text(point%stress(2), 6)
  end function state_text
end module qsmpm_point_statistics
