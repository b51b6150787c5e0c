!> What a run says of the error of its stresses: one line always, and a warning where the estimate
!> (`qsmpm_stress_error`) is beyond limits that sound runs stay below. docs/methods/stress_error.md has the
!> figures the limits are taken from.
module qsmpm_error_report
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: basis_standard, basis_fem, basis_gimp, integrate_points
  use qsmpm_model, only: model_type
  use qsmpm_number_text, only: integer_text, short_text
  use qsmpm_stress_error, only: stress_error_type
  implicit none
  private

  public :: error_line, error_warning

  !> Limits of the mean scatter and of the mean mismatch at loaded surfaces, as shares.
  real(wp), parameter, public :: most_scatter = 0.09_wp, most_mismatch = 0.25_wp

contains

  !> The line of every run.
  pure function error_line(model, estimate) result(text)
    !> The model.
    type(model_type), intent(in) :: model
    !> The error of its stresses.
    type(stress_error_type), intent(in) :: estimate
    character(len=:), allocatable :: text

    text = 'stress error, estimated: none, there is no stress'
    if (estimate%worst_point == 0) return
    associate (p => estimate%worst_point, i => estimate%worst_surface_point)
      text = 'stress error, estimated: mean '//percent(estimate%mean)//', largest '//percent(estimate%largest)// &
        ' at material point '//integer_text(p)//' at '//place_text(model%state%points%position(:, p))
      if (i == 0) return
      text = text//'; on loaded surfaces mean '//percent(estimate%surface_mean)//', largest '// &
        percent(estimate%surface_largest)//' at '//place_text(model%state%surface%position(:, i))
    end associate
  end function error_line

  !> What is to be said against the stresses; empty when nothing.
  subroutine error_warning(model, estimate, text)
    !> The model.
    type(model_type), intent(in) :: model
    !> The error of its stresses.
    type(stress_error_type), intent(in) :: estimate
    !> One line.
    character(len=:), allocatable, intent(out) :: text

    text = ''
    if (estimate%mean > most_scatter) text = 'stresses of neighbouring material points differ by '// &
      percent(estimate%mean)//' of the stress in the mean'
    if (estimate%surface_mean > most_mismatch) then
      if (len(text) > 0) text = text//', and '
      text = text//'stresses at loaded surfaces are off the traction by '//percent(estimate%surface_mean)
    end if
    if (len(text) > 0) text = 'warning: '//text//': '//advice(model)
  end subroutine error_warning

  !> What to do about it.
  pure function advice(model) result(text)
    !> The model.
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text

    associate (method => model%analysis%method)
      if (method%basis == basis_fem) then
        text = 'refine the mesh'
      else if (method%basis == basis_standard .and. method%integration == integrate_points) then
        text = 'points that cross cells do this to functions of one cell; take *METHOD, BASIS=SPLINE2G, '// &
          'INTEGRATION=CELL on a grid, or INTEGRATION=CELL'
      else if (method%basis == basis_standard .or. method%basis == basis_gimp) then
        text = 'take *METHOD, BASIS=SPLINE2G, INTEGRATION=CELL, or more points a cell and smaller cells'
      else
        text = 'take more points a cell, or smaller cells'
      end if
    end associate
  end function advice

  !> A share in per cent.
  pure function percent(share) result(text)
    !> The share.
    real(wp), intent(in) :: share
    character(len=:), allocatable :: text

    text = short_text(100.0_wp*share, 2)//' %'
  end function percent

  !> Coordinates in parentheses.
  pure function place_text(place) result(text)
    !> The place (dimension).
    real(wp), intent(in) :: place(:)
    character(len=:), allocatable :: text
    integer :: j

    text = '('//short_text(place(1), 4)
    do j = 2, size(place)
      text = text//', '//short_text(place(j), 4)
    end do
    text = text//')'
  end function place_text
end module qsmpm_error_report
