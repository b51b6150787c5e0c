!> Detection of volumetric locking: pressures that alternate from point to point in yielding material.
!>
!>   scatter = sqrt( sum V (p - p*)^2 / sum V tau^2 ),   tau^2 = s : s/2
!>
!> over the points of a material that yield in shear, or over all sheared points where a law does not report yielding;
!> p* is the pressure of the smooth stress (qsmpm_smooth_stress), linear for every basis. Plastic flow relates the
!> volume change of every point to its shear. Functions that cannot satisfy this at all points of a cell cause pressures
!> that are not due to a load, as large as the strength, which increase the load on the body. Pressures that are linear
!> over the cells around a node are not counted as scatter, so that weight causes none. Figures:
!> docs/methods/uniform_pressure.md.
module qsmpm_locking_check
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: any_of
  use qsmpm_material_description, only: locking_none
  use qsmpm_model, only: model_type
  use qsmpm_observer, only: observer_type
  use qsmpm_own_part, only: own_of
  use qsmpm_smooth_stress, only: patches_type, smooth_stress_type, make_patches, fit_smooth_stress, smooth_stress_at
  use qsmpm_team, only: total
  use qsmpm_text, only: real_text
  implicit none
  private

  public :: check_locking, pressure_scatter

  !> Scatter above which a warning is printed: above 1 loads are a fifth to a third too high, below this value by less
  !> than a tenth.
  real(wp), parameter :: warned_from = 0.5_wp
  !> Smallest scatter visible with two digits.
  real(wp), parameter :: told_from = 5.0e-3_wp
  !> Ratio of shear stress to pressure below which points yield in compression.
  real(wp), parameter :: least_shear = 0.05_wp
  !> Degree of the smooth stress.
  integer, parameter :: linear = 1

contains

  !> Reports the scatter of each yielding material without treatment of locking; a large one is a warning.
  subroutine check_locking(model, observer)
    type(model_type), intent(in) :: model
    class(observer_type), intent(inout) :: observer
    character(len=:), allocatable :: differ
    real(wp) :: scatter
    integer :: m

    do m = 1, size(model%laws)
      if (model%analysis%materials(m)%locking_treatment /= locking_none) cycle
      scatter = pressure_scatter(model, m)
      differ = 'pressures of neighbouring points that yield differ by '// &
        real_text(real(nint(100.0_wp*scatter), wp)/100.0_wp)//' of their shear stress'
      if (scatter > warned_from) then
        call observer%note("warning: material '"//model%analysis%materials(m)%name//"' locks: "//differ// &
          ', and loads near failure are too high, by 20 to 30 % where that is above 1; use '// &
          '*VOLUMETRIC LOCKING, TYPE=UNIFORM PRESSURE, or take smaller cells')
      else if (scatter >= told_from) then
        call observer%note("material '"//model%analysis%materials(m)%name//"': "//differ)
      end if
    end do
  end subroutine check_locking

  !> Returns the scatter of the pressure in a material, relative to the shear stress; 0 where nothing yields in shear.
  real(wp) function pressure_scatter(model, material) result(scatter)
    type(model_type), intent(in) :: model
    !> Number of the material.
    integer, intent(in) :: material
    type(patches_type) :: connectivity
    type(smooth_stress_type) :: smooth
    real(wp) :: stress(size(model%state%points%stress, 1)), spread, shear
    logical, dimension(model%state%points%count) :: looked_at, own
    integer :: p

    scatter = 0.0_wp
    associate (points => model%state%points)
      looked_at = points%material == material .and. &
        (points%plastic > 0 .or. .not. model%laws(material)%law%tells_yield)
      if (.not. any_of(model%part%team, any(looked_at))) return
      own = own_of(model%part%points, points%count)
      call make_patches(model%mesh, points, connectivity)
      call fit_smooth_stress(model%mesh, model%state%coordinates, connectivity, points, material, linear, smooth)
      spread = 0.0_wp
      shear = 0.0_wp
      do p = 1, points%count
        if (.not. (looked_at(p) .and. own(p))) cycle
        if (shear_square(points%stress(:, p)) <= (least_shear*pressure(points%stress(:, p)))**2) cycle
        call smooth_stress_at(smooth, model%mesh, points%cell(p), points%local(:, p), points%position(:, p), stress)
        spread = spread + points%volume(p)*pressure(points%stress(:, p) - stress)**2
        shear = shear + points%volume(p)*shear_square(points%stress(:, p))
      end do
    end associate
    spread = total(model%part%team, spread)
    shear = total(model%part%team, shear)
    if (shear > 0.0_wp) scatter = sqrt(spread/shear)
  end function pressure_scatter

  !> Returns the mean stress.
  pure real(wp) function pressure(stress)
    !> 11, 22, 33, 12[, 13, 23].
    real(wp), intent(in) :: stress(:)

    pressure = sum(stress(:3))/3.0_wp
  end function pressure

  !> Returns the second invariant of the deviator, s : s/2.
  pure real(wp) function shear_square(stress)
    !> 11, 22, 33, 12[, 13, 23].
    real(wp), intent(in) :: stress(:)

    shear_square = 0.5_wp*sum((stress(:3) - pressure(stress))**2) + sum(stress(4:)**2)
  end function shear_square
end module qsmpm_locking_check
