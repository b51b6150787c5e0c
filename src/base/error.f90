!> Errors as values.
!>
!> A procedure that can fail has `type(error_type), allocatable, intent(out) :: error` as its last argument;
!> unallocated means success. The code gives the kind of failure and is the exit code of the program (deck reference,
!> "Exit codes"); the message is a sentence for the user. The library never stops the program and never writes to the
!> screen.
module qsmpm_error
  implicit none
  private

  public :: error_type, fail, prefix

  !> Exit codes, one for each kind of failure.
  integer, parameter, public :: error_other = 1
  integer, parameter, public :: error_deck = 2
  integer, parameter, public :: error_not_converged = 3
  integer, parameter, public :: error_left_mesh = 4
  integer, parameter, public :: error_singular = 5
  integer, parameter, public :: error_user_material = 6
  !> Used inside a step only: an element of a mesh that moves with the material is inverted.
  integer, parameter, public :: error_tangled = 7

  !> An error.
  type :: error_type
    !> One of the `error_*` codes.
    integer :: code = error_other
    !> Message for the user, without a final full stop or newline.
    character(len=:), allocatable :: message
  end type error_type

contains

  !> Sets an error.
  pure subroutine fail(error, code, message)
    !> The error to set.
    type(error_type), allocatable, intent(out) :: error
    !> One of the `error_*` codes.
    integer, intent(in) :: code
    !> Message for the user.
    character(len=*), intent(in) :: message

    allocate (error)
    error%code = code
    error%message = message
  end subroutine fail

  !> Inserts the context ("phase 'loading', step 12") before the message of an error, if there is one.
  pure subroutine prefix(error, circumstances)
    !> The error to extend; nothing is done if it is unallocated.
    type(error_type), allocatable, intent(inout) :: error
    !> Text inserted before the message.
    character(len=*), intent(in) :: circumstances

    if (.not. allocated(error)) return
    error%message = circumstances//': '//error%message
  end subroutine prefix
end module qsmpm_error
