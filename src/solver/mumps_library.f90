!> Data types and entry points of MUMPS (double and single precision) from the include files of the library, which are
!> included only here. They are the same for the sequential and the parallel library.
module qsmpm_mumps_library
  implicit none
  private

  public :: dmumps_struc, dmumps, smumps_struc, smumps

  include 'dmumps_struc.h'
  include 'smumps_struc.h'

  interface
    !> Performs the task given by `mumps%job`.
    subroutine dmumps(mumps)
      import :: dmumps_struc
      type(dmumps_struc), intent(inout) :: mumps
    end subroutine dmumps

    !> Performs the task in single precision.
    subroutine smumps(mumps)
      import :: smumps_struc
      type(smumps_struc), intent(inout) :: mumps
    end subroutine smumps
  end interface
end module qsmpm_mumps_library
