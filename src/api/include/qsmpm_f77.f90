!> QSMPM for programs of the old kind: external subroutines with integers, reals and strings as arguments, no modules and
!> no pointers. Compile qsmpm_c.f90 and this file with the program, with the program's compiler, and link the library.
!>
!> A handle is an INTEGER*8, set by QSMNEW, given back by QSMEND. IERR is the status of qsmpm.h; QSMERR has the
!> sentence. Names and paths may have trailing blanks.
module qsmpm_f77_texts
  use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t, c_null_char, c_null_ptr, c_ptr
  implicit none
  private

  public :: pointer_of, number_of, as_c

contains

  !> The handle as the library knows it.
  function pointer_of(number) result(pointer)
    integer(c_intptr_t), intent(in) :: number
    type(c_ptr) :: pointer

    pointer = c_null_ptr
    if (number /= 0_c_intptr_t) pointer = transfer(number, pointer)
  end function pointer_of

  !> The handle as a number.
  function number_of(pointer) result(number)
    type(c_ptr), intent(in) :: pointer
    integer(c_intptr_t) :: number

    number = transfer(pointer, number)
  end function number_of

  !> The text without trailing blanks, ended as C wants it.
  pure function as_c(text) result(string)
    character(len=*), intent(in) :: text
    character(len=len_trim(text) + 1) :: string

    string = trim(text)//c_null_char
  end function as_c
end module qsmpm_f77_texts

!> A handle for the deck in a file; the model is made.
subroutine qsmnew(handle, deck, ierr)
  use, intrinsic :: iso_c_binding, only: c_intptr_t, c_null_ptr, c_ptr
  use qsmpm_c, only: qsmpm_create, qsmpm_read_deck, qsmpm_initialise
  use qsmpm_f77_texts, only: as_c, number_of
  implicit none
  integer(c_intptr_t), intent(out) :: handle
  character(len=*), intent(in) :: deck
  integer, intent(out) :: ierr
  type(c_ptr) :: pointer

  handle = 0
  pointer = c_null_ptr
  ierr = int(qsmpm_create(pointer))
  if (ierr /= 0) return
  handle = number_of(pointer)
  ierr = int(qsmpm_read_deck(pointer, as_c(deck)))
  if (ierr == 0) ierr = int(qsmpm_initialise(pointer))
end subroutine qsmnew

!> Give a handle back.
subroutine qsmend(handle)
  use, intrinsic :: iso_c_binding, only: c_intptr_t, c_ptr
  use qsmpm_c, only: qsmpm_destroy
  use qsmpm_f77_texts, only: pointer_of
  implicit none
  integer(c_intptr_t), intent(inout) :: handle
  type(c_ptr) :: pointer
  integer :: ierr

  pointer = pointer_of(handle)
  ierr = int(qsmpm_destroy(pointer))
  handle = 0
end subroutine qsmend

!> Sentence of the last failure.
subroutine qsmerr(handle, text)
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_intptr_t, c_null_char
  use qsmpm_c, only: qsmpm_error
  use qsmpm_f77_texts, only: pointer_of
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(out) :: text
  character(kind=c_char) :: buffer(len(text) + 1)
  integer :: i, length

  text = ' '
  length = int(qsmpm_error(pointer_of(handle), buffer, int(size(buffer), c_int)))
  do i = 1, min(length, len(text))
    text(i:i) = buffer(i)
  end do
end subroutine qsmerr

!> Write results to a directory.
subroutine qsmrec(handle, path, ierr)
  use, intrinsic :: iso_c_binding, only: c_intptr_t
  use qsmpm_c, only: qsmpm_record
  use qsmpm_f77_texts, only: as_c, pointer_of
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: path
  integer, intent(out) :: ierr

  ierr = int(qsmpm_record(pointer_of(handle), as_c(path)))
end subroutine qsmrec

!> One accepted load step.
subroutine qsmadv(handle, ierr)
  use, intrinsic :: iso_c_binding, only: c_intptr_t
  use qsmpm_c, only: qsmpm_advance
  use qsmpm_f77_texts, only: pointer_of
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(out) :: ierr

  ierr = int(qsmpm_advance(pointer_of(handle)))
end subroutine qsmadv

!> All stages that are to come.
subroutine qsmrun(handle, ierr)
  use, intrinsic :: iso_c_binding, only: c_intptr_t
  use qsmpm_c, only: qsmpm_run
  use qsmpm_f77_texts, only: pointer_of
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(out) :: ierr

  ierr = int(qsmpm_run(pointer_of(handle)))
end subroutine qsmrun

!> A new stage of some load steps.
subroutine qsmstg(handle, name, nsteps, ierr)
  use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
  use qsmpm_c, only: qsmpm_add_stage
  use qsmpm_f77_texts, only: as_c, pointer_of
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: name
  integer, intent(in) :: nsteps
  integer, intent(out) :: ierr

  ierr = int(qsmpm_add_stage(pointer_of(handle), as_c(name), int(nsteps, c_int)))
end subroutine qsmstg

!> How long the coming stage lasts.
subroutine qsmtim(handle, time, ierr)
  use, intrinsic :: iso_c_binding, only: c_double, c_intptr_t
  use qsmpm_c, only: qsmpm_set_time
  use qsmpm_f77_texts, only: pointer_of
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  double precision, intent(in) :: time
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_time(pointer_of(handle), real(time, c_double)))
end subroutine qsmtim

!> Gravity at the end of the coming stage.
subroutine qsmgrv(handle, gx, gy, gz, ierr)
  use, intrinsic :: iso_c_binding, only: c_double, c_intptr_t
  use qsmpm_c, only: qsmpm_set_gravity
  use qsmpm_f77_texts, only: pointer_of
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  double precision, intent(in) :: gx, gy, gz
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_gravity(pointer_of(handle), real([gx, gy, gz], c_double)))
end subroutine qsmgrv

!> Traction on a surface at the end of the coming stage.
subroutine qsmtrc(handle, surfac, tx, ty, tz, ierr)
  use, intrinsic :: iso_c_binding, only: c_double, c_intptr_t
  use qsmpm_c, only: qsmpm_set_traction
  use qsmpm_f77_texts, only: as_c, pointer_of
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: surfac
  double precision, intent(in) :: tx, ty, tz
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_traction(pointer_of(handle), as_c(surfac), real([tx, ty, tz], c_double)))
end subroutine qsmtrc

!> Displacement of a node set over the coming stage.
subroutine qsmdsp(handle, set, icomp, value, ierr)
  use, intrinsic :: iso_c_binding, only: c_double, c_int, c_intptr_t
  use qsmpm_c, only: qsmpm_set_displacement
  use qsmpm_f77_texts, only: as_c, pointer_of
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: set
  integer, intent(in) :: icomp
  double precision, intent(in) :: value
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_displacement(pointer_of(handle), as_c(set), int(icomp, c_int), real(value, c_double)))
end subroutine qsmdsp

!> Values by name into an array of N numbers; N is how many there are on return.
subroutine qsmget(handle, name, values, n, ierr)
  use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
  use qsmpm_c, only: qsmpm_count, qsmpm_get
  use qsmpm_f77_texts, only: as_c, pointer_of
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: name
  double precision, intent(inout) :: values(*)
  integer, intent(inout) :: n
  integer, intent(out) :: ierr
  integer(c_int) :: number

  ierr = int(qsmpm_count(pointer_of(handle), as_c(name), number))
  if (ierr == 0 .and. number > n) ierr = 1
  if (ierr == 0) ierr = int(qsmpm_get(pointer_of(handle), as_c(name), values, number))
  n = int(number)
end subroutine qsmget

!> Copy the state in memory (ISAVE = 1), or put the copy back (ISAVE = 0).
subroutine qsmsav(handle, isave, ierr)
  use, intrinsic :: iso_c_binding, only: c_intptr_t
  use qsmpm_c, only: qsmpm_checkpoint, qsmpm_restore_checkpoint
  use qsmpm_f77_texts, only: pointer_of
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(in) :: isave
  integer, intent(out) :: ierr

  if (isave /= 0) then
    ierr = int(qsmpm_checkpoint(pointer_of(handle)))
  else
    ierr = int(qsmpm_restore_checkpoint(pointer_of(handle)))
  end if
end subroutine qsmsav
