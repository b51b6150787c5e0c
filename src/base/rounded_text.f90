!> Numbers in sentences: as many digits as are read, not as many as are known.
module qsmpm_rounded_text
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: real_text
  implicit none
  private

  public :: rounded_text

contains

  !> A number in four digits.
  pure function rounded_text(value) result(text)
    !> Finite.
    real(wp), intent(in) :: value
    character(len=:), allocatable :: text
    character(len=16) :: buffer
    real(wp) :: rounded

    write (buffer, '(es13.3e3)') value
    read (buffer, *) rounded
    text = real_text(rounded)
  end function rounded_text
end module qsmpm_rounded_text
