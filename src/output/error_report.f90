!> Report of the stress error of a run: one line for every run, and a warning if the estimate (`qsmpm_stress_error`)
!> exceeds limits that valid runs satisfy. docs/methods/stress_error.md has the figures from which the limits are
!> taken.
module qsmpm_error_report
  use qsmpm_kinds, only: wp
  use qsmpm_method_description, only: basis_standard, basis_fem, basis_gimp, integrate_points
  use qsmpm_model, only: model_type
  use qsmpm_number_text, only: integer_text
  use qsmpm_rounded_text, only: rounded_text, rounded_place
  use qsmpm_layer_interfaces, only: interface_type, find_interfaces
  use qsmpm_recommended_method, only: stiff_body
  use qsmpm_stress_error, only: stress_error_type
  implicit none
  private

  public :: error_line, error_warning

  !> Limits of the mean scatter and of the mean mismatch at a loaded surface, as fractions.
  real(wp), parameter, public :: most_scatter = 0.13_wp, most_mismatch = 0.25_wp

contains

  !> Returns the line that every run has.
  pure function error_line(model, estimate) result(text)
    type(model_type), intent(in) :: model
    !> Estimated error of the stresses.
    type(stress_error_type), intent(in) :: estimate
    character(len=:), allocatable :: text

    text = 'stress error, estimated: none, there is no stress'
    if (estimate%worst_point == 0) return
    text = 'stress error, estimated: mean '//percent(estimate%mean)//', '//worst_point_text(model, estimate)
    if (estimate%worst_surface > 0) text = text//'; on loaded surface '//worst_surface_text(model, estimate)
    if (estimate%worst_held > 0) text = text//"; differ from the reaction on supported surface '"// &
      model%analysis%surfaces(estimate%worst_held)%name//"' by "//percent(estimate%reaction)
  end function error_line

  !> Returns a warning about the stresses; empty if there is none.
  subroutine error_warning(model, estimate, text)
    type(model_type), intent(in) :: model
    !> Estimated error of the stresses.
    type(stress_error_type), intent(in) :: estimate
    !> One line.
    character(len=:), allocatable, intent(out) :: text

    text = ''
    if (estimate%mean > most_scatter) text = 'stresses of neighbouring material points differ by '// &
      percent(estimate%mean)//' of the stress around them in the mean, '//worst_point_text(model, estimate)
    if (estimate%surface_mean > most_mismatch) then
      if (len(text) > 0) text = text//', and '
      text = text//'stresses differ from the traction on surface '//worst_surface_text(model, estimate)
    end if
    if (len(text) > 0) text = 'warning: '//text//': '//advice(model)
  end subroutine error_warning

  !> Returns the location of the largest scatter and its reference value.
  pure function worst_point_text(model, estimate) result(text)
    type(model_type), intent(in) :: model
    type(stress_error_type), intent(in) :: estimate
    character(len=:), allocatable :: text

    text = 'largest '//percent(estimate%largest)//' at material point '//integer_text(estimate%worst_point)//' at '// &
      rounded_place(estimate%worst_place(:model%mesh%dimension))//', relative to a stress of '// &
      rounded_text(estimate%worst_scale, 3)//' around it'
  end function worst_point_text

  !> Returns the surface with the largest difference between stress and traction, its value, and its location on all
  !> surfaces.
  pure function worst_surface_text(model, estimate) result(text)
    type(model_type), intent(in) :: model
    type(stress_error_type), intent(in) :: estimate
    character(len=:), allocatable :: text

    text = "'"//model%analysis%surfaces(estimate%worst_surface)%name//"' mean "//percent(estimate%surface_mean)// &
      ', largest '//percent(estimate%surface_largest)//' at '// &
      rounded_place(estimate%surface_place(:model%mesh%dimension))
  end function worst_surface_text

  !> Returns the recommended action.
  pure function advice(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    type(interface_type), allocatable :: interfaces(:)

    call find_interfaces(model%analysis, interfaces)
    associate (method => model%analysis%method)
      if (method%basis == basis_fem) then
        text = 'refine the mesh'
      else if (stiff_body(model%analysis) > 0) then
        text = 'stresses jump beside a body that is so much stiffer; take smaller cells'
        if (method%basis /= basis_standard .or. method%integration == integrate_points) text = text// &
          ', and *METHOD, BASIS=STANDARD, INTEGRATION=CELL where it ends on lines of the grid'
      else if (any(interfaces%axis == 0)) then
        text = 'let grid lines, or element edges of a mesh, follow the interfaces of bodies of different stiffness'
      else if (method%basis == basis_standard .and. method%integration == integrate_points) then
        text = 'material points that cross cell boundaries cause this with BASIS=STANDARD; take *METHOD, '// &
          'BASIS=SPLINE2G, INTEGRATION=CELL on a grid, or INTEGRATION=CELL'
      else if (method%basis == basis_standard .or. method%basis == basis_gimp) then
        text = 'take *METHOD, BASIS=SPLINE2G, INTEGRATION=CELL, or more points a cell and smaller cells'
      else
        text = 'take more points a cell, or smaller cells'
      end if
    end associate
  end function advice

  !> Returns a fraction as a percentage.
  pure function percent(share) result(text)
    real(wp), intent(in) :: share
    character(len=:), allocatable :: text

    text = rounded_text(100.0_wp*share, 2)//' %'
  end function percent
end module qsmpm_error_report
