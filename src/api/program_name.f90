!> Which library this is, and what it was built with.
!>
!> Settings that belong to the process, not to a model: threads of OpenMP and of OpenBLAS. They are set on the way into
!> the library and restored on the way out, so that an embedding program keeps its own.
module qsmpm_program_name
  use qsmpm_version, only: version, compiler, build_type, with_suitesparse, with_openmp
  use omp_lib, only: omp_get_max_threads, omp_get_num_procs, omp_set_num_threads
  use qsmpm_blas_threads, only: blas_threads, set_blas_threads
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: program_name, has_feature, settings_type, enter_library, leave_library, check_threads

  !> Version of the interface to C: 10000 major + 100 minor + patch. It grows with every change a caller can see.
  integer, parameter, public :: api_version = 201

  !> Threads that may be asked for on any machine: that results do not depend on them is tested with more than it has.
  integer, parameter :: always_allowed = 64

  !> The settings of the embedding program.
  type :: settings_type
    integer :: threads = 1
    integer :: blas_threads = 1
  end type settings_type

contains

  !> The program's name, version and make.
  pure function program_name() result(text)
    character(len=:), allocatable :: text

    text = 'qsmpm '//version//' ('//compiler//', '//build_type//')'
  end function program_name

  !> Whether something optional is there; false for an unknown word.
  pure logical function has_feature(name)
    !> suitesparse, openmp, mumps, soil_model, umat, udsm.
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

  !> Refuse threads that a machine cannot have.
  subroutine check_threads(threads, error)
    !> Threads that a model may use.
    integer, intent(in) :: threads
    !> Set when they are none, or far more than there are processors.
    type(error_type), allocatable, intent(out) :: error
    integer :: most

    most = max(always_allowed, omp_get_num_procs())
    if (threads >= 1 .and. threads <= most) return
    call fail(error, error_other, integer_text(threads)//' threads are not available: from 1 to '// &
      integer_text(most)//' may be requested, this machine has '//integer_text(omp_get_num_procs())//' processors')
  end subroutine check_threads

  !> Set those of the library.
  subroutine enter_library(threads, settings)
    !> Threads that a model may use.
    integer, intent(in) :: threads
    type(settings_type), intent(out) :: settings

    settings%threads = omp_get_max_threads()
    settings%blas_threads = blas_threads()
    call omp_set_num_threads(max(1, threads))
    call set_blas_threads(1)
  end subroutine enter_library

  !> Restore those of the program.
  subroutine leave_library(settings)
    type(settings_type), intent(in) :: settings

    call omp_set_num_threads(settings%threads)
    call set_blas_threads(settings%blas_threads)
  end subroutine leave_library
end module qsmpm_program_name
