!> Name and version of the library and its build options.
!>
!> Also manages the settings of the process, not of a model: numbers of threads of OpenMP and OpenBLAS. They are set on
!> entry to the library and restored on return, so that the embedding program keeps its own settings.
module qsmpm_program_name
  use qsmpm_version, only: version, compiler, build_type, with_suitesparse, with_openmp
  use omp_lib, only: omp_get_max_threads, omp_get_num_procs, omp_set_num_threads
  use qsmpm_blas_threads, only: blas_threads, set_blas_threads
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: program_name, has_feature, settings_type, enter_library, leave_library, check_threads

  !> Version of the C interface: 10000 major + 100 minor + patch; increased with every visible change.
  integer, parameter, public :: api_version = 201

  !> Number of threads accepted on any machine: tests of the independence of results use more threads than processors.
  integer, parameter :: always_allowed = 64

  !> Settings of the embedding program.
  type :: settings_type
    integer :: threads = 1
    integer :: blas_threads = 1
  end type settings_type

contains

  !> Returns name, version and build options of the program.
  pure function program_name() result(text)
    character(len=:), allocatable :: text

    text = 'qsmpm '//version//' ('//compiler//', '//build_type//')'
  end function program_name

  !> Returns whether an optional feature is available; false for an unknown word.
  pure logical function has_feature(name)
    !> Name of the feature: suitesparse, openmp, mumps, soil_model, umat, udsm.
    character(len=*), intent(in) :: name

    select case (name)
    case ('suitesparse')
      has_feature = with_suitesparse
    case ('openmp')
      has_feature = with_openmp
    case ('mumps', 'soil_model', 'umat', 'udsm')
      has_feature = .true.
    case default
      has_feature = .false.
    end select
  end function has_feature

  !> Checks the number of threads.
  subroutine check_threads(threads, error)
    !> Number of threads of a model.
    integer, intent(in) :: threads
    !> Set when the number is below 1, or far above the number of processors.
    type(error_type), allocatable, intent(out) :: error
    integer :: most

    most = max(always_allowed, omp_get_num_procs())
    if (threads >= 1 .and. threads <= most) return
    call fail(error, error_other, integer_text(threads)//' threads are not available: from 1 to '// &
      integer_text(most)//' may be requested, this machine has '//integer_text(omp_get_num_procs())//' processors')
  end subroutine check_threads

  !> Applies the settings of the library.
  subroutine enter_library(threads, settings)
    !> Number of threads of a model.
    integer, intent(in) :: threads
    type(settings_type), intent(out) :: settings

    settings%threads = omp_get_max_threads()
    settings%blas_threads = blas_threads()
    call omp_set_num_threads(max(1, threads))
    call set_blas_threads(1)
  end subroutine enter_library

  !> Restores the settings of the program.
  subroutine leave_library(settings)
    type(settings_type), intent(in) :: settings

    call omp_set_num_threads(settings%threads)
    call set_blas_threads(settings%blas_threads)
  end subroutine leave_library
end module qsmpm_program_name
