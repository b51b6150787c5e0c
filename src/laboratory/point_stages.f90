!> Conversion of a laboratory test into controls of a point: what is fixed, what is prescribed, and the path of each
!> control from its value at the start of a stage to its target.
!>
!> Every test has as many controls as the gradient has components. Those of shear fix the components of the gradient (no
!> rotation about y); quantities that a stage does not name keep their values. Signs of the laboratory are converted to
!> those of tensors, strains to ratios of lengths (1 + e, or exp(e) for logarithmic ones, which are linear in e).
module qsmpm_point_stages
  use qsmpm_kinds, only: wp
  use qsmpm_point_driver, only: point_type, control_type, control_value, control_gradient, control_volume, &
    control_stress
  use qsmpm_point_test, only: point_test_type, test_drained, test_undrained, test_biaxial, test_shear, &
    strain_logarithmic, driven_axial_strain, driven_axial_stress, driven_deviator, driven_cell_pressure, &
    driven_shear_strain, driven_shear_stress, driven_normal_stress, driven_pressure, driven_volumetric_strain, &
    driven_strain, driven_stress, driven_row, driven_column
  use qsmpm_tensor, only: gradient_size, gradient_index
  implicit none
  private

  public :: ramp_type, begin_ramps, aim_ramps, set_controls

  !> A control with its path.
  type :: ramp_type
    type(control_type) :: control
    !> Values at the start and the end, of the logarithm if the path is linear in that.
    real(wp) :: from = 0.0_wp
    real(wp) :: to = 0.0_wp
    logical :: logarithmic = .false.
  end type ramp_type

contains

  !> Initialises the controls of a test before its first stage.
  pure subroutine begin_ramps(test, ramps)
    type(point_test_type), intent(in) :: test
    !> One per component (5 or 9).
    type(ramp_type), allocatable, intent(out) :: ramps(:)
    integer :: i, n

    n = gradient_size(test%dimension)
    allocate (ramps(n))
    do i = 1, n
      ramps(i)%control%weight(i) = 1.0_wp
    end do
    associate (xx => component(test, 1, 1), yy => component(test, 2, 2), zz => component(test, 3, 3))
      select case (test%kind)
      case (test_drained)
        ramps([xx, zz])%control%kind = control_stress
        call weigh_deviator(test, ramps(yy)%control)
      case (test_undrained)
        ramps(xx)%control%weight(zz) = -1.0_wp
        ramps(zz)%control%kind = control_volume
        call weigh_deviator(test, ramps(yy)%control)
      case (test_biaxial)
        ramps(xx)%control%kind = control_stress
        call weigh_deviator(test, ramps(yy)%control)
      case (test_shear)
        if (.not. test%fixed_height) ramps(yy)%control%kind = control_stress
      end select
    end associate
  end subroutine begin_ramps

  !> Number of a component.
  pure integer function component(test, row, column)
    type(point_test_type), intent(in) :: test
    !> Row and column.
    integer, intent(in) :: row, column

    component = gradient_index(row, column, test%dimension)
  end function component

  !> Converts a control into that of the deviator: lateral minus axial stress, positive in tension.
  pure subroutine weigh_deviator(test, control)
    type(point_test_type), intent(in) :: test
    type(control_type), intent(inout) :: control

    control%kind = control_stress
    control%weight = 0.0_wp
    control%weight(component(test, 2, 2)) = -1.0_wp
    control%weight(component(test, 1, 1)) = 1.0_wp
    if (test%kind /= test_undrained) return
    control%weight(component(test, 1, 1)) = 0.5_wp
    control%weight(component(test, 3, 3)) = 0.5_wp
  end subroutine weigh_deviator

  !> Sets the controls to the targets of a stage.
  subroutine aim_ramps(test, driven_components, targets, point, ramps)
    type(point_test_type), intent(in) :: test
    !> Prescribed quantities and their values at the end.
    integer, intent(in) :: driven_components(:)
    real(wp), intent(in) :: targets(:)
    !> The point at the start of the stage.
    type(point_type), intent(in) :: point
    !> The controls.
    type(ramp_type), intent(inout) :: ramps(:)
    logical :: prescribed(size(ramps))
    integer :: i

    prescribed = .false.
    ! The axial quantity of the previous stage is released: the deviator is kept, unless the stage names another
    ! quantity.
    if (any(test%kind == [test_drained, test_biaxial]) .and. all(driven_components == driven_cell_pressure)) &
      call weigh_deviator(test, ramps(component(test, 2, 2))%control)
    do i = 1, size(driven_components)
      call prescribe_ramps(test, driven_components(i), targets(i), ramps, prescribed)
    end do
    do i = 1, size(ramps)
      associate (ramp => ramps(i))
        if (.not. prescribed(i)) ramp%logarithmic = .false.
        ramp%from = control_value(ramp%control, point%deformation, point%stress)
        if (ramp%logarithmic) ramp%from = log(ramp%from)
        if (.not. prescribed(i)) ramp%to = ramp%from
      end associate
    end do
  end subroutine aim_ramps

  !> Sets the controls of a quantity.
  subroutine prescribe_ramps(test, driven, target, ramps, prescribed)
    type(point_test_type), intent(in) :: test
    !> The quantity.
    integer, intent(in) :: driven
    !> Its value at the end.
    real(wp), intent(in) :: target
    type(ramp_type), intent(inout) :: ramps(:)
    !> Marks prescribed controls.
    logical, intent(inout) :: prescribed(:)
    integer :: i

    select case (driven)
    case (driven_axial_strain)
      call lead(2, 2, control_gradient, -target, .true.)
    case (driven_axial_stress, driven_normal_stress)
      call lead(2, 2, control_stress, -target, .false.)
    case (driven_deviator)
      call lead(2, 2, control_stress, target, .false.)
      call weigh_deviator(test, ramps(component(test, 2, 2))%control)
    case (driven_cell_pressure)
      call lead(1, 1, control_stress, -target, .false.)
      if (test%kind == test_drained) call lead(3, 3, control_stress, -target, .false.)
    case (driven_shear_strain)
      call lead(1, 2, control_gradient, target, .false.)
    case (driven_shear_stress)
      call lead(1, 2, control_stress, target, .false.)
    case (driven_pressure)
      do i = 1, 3
        call lead(i, i, control_stress, -target, .false.)
      end do
    case (driven_volumetric_strain)
      call lead(1, 1, control_volume, -target, .true.)
      do i = 2, 3
        call keep_difference(component(test, i, i), component(test, 1, 1), ramps(component(test, i, i)))
      end do
    case default
      if (driven > driven_stress) then
        call lead(driven_row(driven), driven_column(driven), control_stress, target, .false.)
      else
        call lead(driven_row(driven), driven_column(driven), control_gradient, target, &
          driven > driven_strain .and. driven_row(driven) == driven_column(driven))
      end if
    end select

  contains

    !> Sets the control of one component.
    subroutine lead(row, column, kind, value, strain)
      integer, intent(in) :: row, column
      !> Kind of the control.
      integer, intent(in) :: kind
      !> Its value at the end, positive in tension.
      real(wp), intent(in) :: value
      !> The value is a strain in the measure of the test, and the control a ratio of lengths or volumes.
      logical, intent(in) :: strain
      integer :: k

      k = component(test, row, column)
      ramps(k)%control%kind = kind
      ramps(k)%control%weight = 0.0_wp
      ramps(k)%control%weight(k) = 1.0_wp
      ramps(k)%logarithmic = strain .and. test%strain == strain_logarithmic
      ramps(k)%to = value
      if (strain .and. .not. ramps(k)%logarithmic) ramps(k)%to = 1.0_wp + value
      prescribed(k) = .true.
    end subroutine lead
  end subroutine prescribe_ramps

  !> Fixes the difference between a length and the first one.
  pure subroutine keep_difference(own, first, ramp)
    !> Numbers of the component and of that of the first axis.
    integer, intent(in) :: own, first
    type(ramp_type), intent(inout) :: ramp

    ramp%control%kind = control_gradient
    ramp%control%weight = 0.0_wp
    ramp%control%weight(own) = 1.0_wp
    ramp%control%weight(first) = -1.0_wp
  end subroutine keep_difference

  !> Returns the values of the controls at a share of the stage.
  pure subroutine set_controls(ramps, share, controls)
    !> The controls with their paths.
    type(ramp_type), intent(in) :: ramps(:)
    !> 0 to 1.
    real(wp), intent(in) :: share
    !> Controls of the step to this share.
    type(control_type), intent(out) :: controls(:)
    integer :: i

    do i = 1, size(ramps)
      controls(i) = ramps(i)%control
      controls(i)%value = ramps(i)%from + share*(ramps(i)%to - ramps(i)%from)
      if (share >= 1.0_wp) controls(i)%value = ramps(i)%to
      if (ramps(i)%logarithmic) controls(i)%value = exp(controls(i)%value)
    end do
  end subroutine set_controls
end module qsmpm_point_stages
