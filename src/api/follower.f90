!> Who listens on the processes of a team beside the first, which writes: to nobody but the signals of the system.
module qsmpm_follower
  use qsmpm_observer, only: silent_observer_type
  use qsmpm_posix, only: signal_received
  implicit none
  private

  public :: follower_type

  type, extends(silent_observer_type) :: follower_type
  contains
    procedure :: stop_requested
  end type follower_type

contains

  !> Whether a signal has asked the run to stop.
  logical function stop_requested(self)
    class(follower_type), intent(inout) :: self

    associate (unused => self)
    end associate
    stop_requested = signal_received() /= 0
  end function stop_requested
end module qsmpm_follower
