!> The data type and the one entry of MUMPS (sequential, double precision), taken from the include
!> file of the library, which stands nowhere else.
module qsmpm_mumps_library
  implicit none
  private

  public :: dmumps_struc, dmumps

  include 'dmumps_struc.h'

  interface
    !> Do what `mumps%job` says.
    subroutine dmumps(mumps)
      import :: dmumps_struc
      type(dmumps_struc), intent(inout) :: mumps
    end subroutine dmumps
  end interface
end module qsmpm_mumps_library
