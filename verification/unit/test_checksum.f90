!> Tests of the checksum and of the last line of files that are read back.
module test_checksum
  use, intrinsic :: iso_fortran_env, only: int8, int32
  use qsmpm_checksum, only: crc32, crc32_text, followed_by
  use qsmpm_kinds, only: long
  use testing, only: tests_type
  implicit none
  private

  public :: collect_checksum

contains

  !> The suite.
  subroutine collect_checksum(tests)
    type(tests_type), intent(inout) :: tests
    integer(int8) :: bytes(9), changed(9)
    integer :: i, bit
    logical :: seen

    call tests%start('checksum')
    bytes = [(int(iachar('0') + i, int8), i=1, 9)]
    ! The check value of CRC-32 (ITU-T V.42; catalogues of CRC parameters).
    call tests%check('the digits 1 to 9 give CBF43926', crc32_text(crc32(bytes)) == 'CBF43926')
    call tests%check('no bytes give 0', crc32(bytes(:0)) == 0_int32)
    call tests%check('pieces give the sum of the whole', crc32(bytes(5:), crc32(bytes(:4))) == crc32(bytes))
    call tests%check('in any order too', ieor(followed_by(crc32(bytes(:4)), 5_long), crc32(bytes(5:))) == crc32(bytes))
    call tests%check('what nothing follows stays', followed_by(crc32(bytes), 0_long) == crc32(bytes))
    seen = .true.
    do i = 1, 9
      do bit = 0, 7
        changed = bytes
        changed(i) = ieor(changed(i), ibset(0_int8, bit))
        seen = seen .and. crc32(changed) /= crc32(bytes)
      end do
    end do
    call tests%check('every turned bit changes the sum', seen)
  end subroutine collect_checksum
end module test_checksum
