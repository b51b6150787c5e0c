!> Number kinds of the whole program and dimensionless constants.
!>
!> Every literal carries `_wp`; integers that count bytes or non-zeros are `long`.
module qsmpm_kinds
  use, intrinsic :: iso_fortran_env, only: real32, real64, int64
  implicit none
  private

  !> Working precision: IEEE double.
  integer, parameter, public :: wp = real64
  !> Single precision, for preconditioners only.
  integer, parameter, public :: sp = real32
  !> Integer wide enough for byte and non-zero counts.
  integer, parameter, public :: long = int64
  !> The number pi.
  real(wp), parameter, public :: pi = acos(-1.0_wp)
end module qsmpm_kinds
