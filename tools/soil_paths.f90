!> Laboratory tests on hardening soils, one material point each, as a table on the screen.
!>
!>     cmake --build build --target soil_paths && build/soil_paths > paths.csv
!>     PYTHONPATH=tools python3 -m qsmpm_verify.soil_paths paths.csv docs/figures/soil_paths.svg
!>
!> Columns: test, p, q = radial less axial stress (tension positive, so q > 0 in compression), axial strain and
!> volume strain (logarithmic, compression positive), axial stress (compression positive). The clay is that of
!> `clay_parameters`, the sand that of `sand_parameters`; logarithmic kinematics.
program soil_paths
  use qsmpm_error, only: error_type
  use qsmpm_hardening_parameters, only: cam_clay_parameters_type
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type
  use qsmpm_point_driver, only: point_type, start_point
  use soil_trials, only: clay_parameters, sand_parameters, make_clay, make_sand, compress, triaxial, oedometer
  implicit none

  real(wp), parameter :: isotropic(4) = [-100.0_wp, -100.0_wp, -100.0_wp, 0.0_wp]
  integer, parameter :: rows = 60
  class(law_type), allocatable :: law
  type(cam_clay_parameters_type) :: stiff
  type(point_type) :: point
  type(error_type), allocatable :: error

  write (*, '(a)') 'test,p,q,axial_strain,volume_strain,axial_stress'
  call make_clay(clay_parameters(), 2, .true., law)
  call start_point(law, isotropic, point)
  call undrained('undrained', 0.7_wp)
  call start_point(law, isotropic, point)
  call load('drained', -100.0_wp - 0.98_wp*150.0_wp)
  call start_point(law, isotropic, point)
  call confine('confined', 0.85_wp)
  stiff = clay_parameters()
  stiff%ocr = 8.0_wp
  call make_clay(stiff, 2, .true., law)
  call start_point(law, isotropic*0.25_wp, point)
  call undrained('undrained OCR 8', 0.6_wp)
  call make_sand(sand_parameters(), 2, .true., law)
  call start_point(law, isotropic, point)
  point%state(2) = 1.0e4_wp
  call load('sand triaxial', -250.0_wp)
  call load('sand triaxial', -110.0_wp)
  call load('sand triaxial', -100.0_wp - 268.0_wp)
  call start_point(law, -20.0_wp*[0.4264236_wp, 1.0_wp, 0.4264236_wp, 0.0_wp], point)
  call confine('sand confined', exp(-0.005_wp))
  call confine('sand confined', exp(0.0015_wp))
  call confine('sand confined', exp(-0.006_wp))

contains

  !> Compression at constant volume.
  subroutine undrained(name, factor)
    character(len=*), intent(in) :: name
    !> Axial length at the end over that at the start.
    real(wp), intent(in) :: factor
    real(wp) :: share
    integer :: i

    call write_row(name)
    ! Most happens at first: rows get longer.
    do i = 1, rows
      share = real(2*i - 1, wp)/rows**2
      call compress(law, point, factor**share, factor**(-0.5_wp*share), 20)
      call write_row(name)
    end do
  end subroutine undrained

  !> Axial stress from where it is at constant radial stress.
  subroutine load(name, axial)
    character(len=*), intent(in) :: name
    !> Axial stress at the end.
    real(wp), intent(in) :: axial
    real(wp) :: from
    integer :: i

    from = point%stress(2)
    call write_row(name)
    do i = 1, rows
      call triaxial(law, point, -100.0_wp, from + (axial - from)*i/rows, 20, error)
      if (allocated(error)) error stop 'a triaxial test has no answer'
      call write_row(name)
    end do
  end subroutine load

  !> Compression without radial strain.
  subroutine confine(name, factor)
    character(len=*), intent(in) :: name
    !> Axial length at the end over that at the start.
    real(wp), intent(in) :: factor
    integer :: i

    call write_row(name)
    do i = 1, rows
      call oedometer(law, point, factor**(1.0_wp/rows), 20)
      call write_row(name)
    end do
  end subroutine confine

  !> A row of the table.
  subroutine write_row(name)
    character(len=*), intent(in) :: name

    write (*, '(a,5(",",es14.6))') name, -sum(point%stress(1:3))/3.0_wp, point%stress(1) - point%stress(2), &
      -log(point%deformation(2, 2)), -log(point%volume_ratio), -point%stress(2)
  end subroutine write_row
end program soil_paths
