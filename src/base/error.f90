!> Errors as values.
!>
!> A procedure that can fail has `type(error_type), allocatable, intent(out) :: error` as its
!> last argument: unallocated means success. The code says what kind of failure it is and is the
!> exit code of the program (deck reference, "Exit codes"); the message is a sentence for the user.
!> The library never stops and never writes to the screen.
module qsmpm_error
  implicit none
  private

  public :: error_type, fail, prefix

  !> Exit codes, one a kind of failure.
  integer, parameter, public :: error_other = 1
  integer, parameter, public :: error_deck = 2
  integer, parameter, public :: error_not_converged = 3
  integer, parameter, public :: error_left_mesh = 4
  integer, parameter, public :: error_singular = 5
  integer, parameter, public :: error_user_material = 6
  !> Inside of a step only: a mesh that goes with the ground has turned inside out.
  integer, parameter, public :: error_tangled = 7

  !> What went wrong.
  type :: error_type
    !> One of the `error_*` codes.
    integer :: code = error_other
    !> Sentence for the user, without a trailing full stop or newline.
    character(len=:), allocatable :: message
  end type error_type

contains

  !> Make an error.
  pure subroutine fail(error, code, message)
    !> The error to set.
    type(error_type), allocatable, intent(out) :: error
    !> One of the `error_*` codes.
    integer, intent(in) :: code
    !> Sentence for the user.
    character(len=*), intent(in) :: message

    allocate (error)
    error%code = code
    error%message = message
  end subroutine fail

  !> Put the circumstances ("phase 'loading', step 12") before the message of an error, if there is one.
  pure subroutine prefix(error, circumstances)
    !> The error to extend; nothing happens when it is not allocated.
    type(error_type), allocatable, intent(inout) :: error
    !> Text that goes before the message.
    character(len=*), intent(in) :: circumstances

    if (.not. allocated(error)) return
    error%message = circumstances//': '//error%message
  end subroutine prefix
end module qsmpm_error
