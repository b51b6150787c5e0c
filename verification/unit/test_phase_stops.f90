!> Where a phase stops: which share of a step is taken again, what a smaller model has for the value, and the loads of
!> the phases behind it.
module test_phase_stops
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_phase_description, only: controls_type, ended_by_load, ended_by_stop, stop_above, stop_below, stop_type
  use qsmpm_model, only: progress_type, phase_end_type
  use qsmpm_phase_ends, only: end_of_phase, fraction_reached
  use qsmpm_phase_stops, only: is_reached, stop_share
  use qsmpm_reduction, only: reduction_type, move_stops
  use qsmpm_step_length, only: length_to_stop
  use testing, only: tests_type
  implicit none
  private

  public :: collect_phase_stops

  real(wp), parameter :: rounding = 1.0e-14_wp

contains

  !> All tests.
  subroutine collect_phase_stops(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('phase_stops')
    call check_shares(tests)
    call check_length(tests)
    call check_reduced(tests)
    call check_ends(tests)
  end subroutine collect_phase_stops

  !> A stop at 10 from below and one at -4 from above.
  function two_stops() result(stops)
    type(stop_type) :: stops(2)

    stops(1)%history = 'a'
    stops(1)%value = 10.0_wp
    stops(2)%history = 'b'
    stops(2)%side = stop_below
    stops(2)%value = -4.0_wp
  end function two_stops

  !> The share of a step at which a history reaches its value.
  subroutine check_shares(tests)
    type(tests_type), intent(inout) :: tests
    type(stop_type) :: stops(2)

    stops = two_stops()
    call tests%check('a value is reached where it is met, from its side', is_reached(stops(1), 10.0_wp) .and. &
      is_reached(stops(2), -4.0_wp) .and. .not. is_reached(stops(1), 9.9_wp) .and. .not. is_reached(stops(2), -3.9_wp))
    call tests%close('no stop is reached', stop_share(stops, 0.01_wp, [0.0_wp, 0.0_wp], [9.0_wp, -3.0_wp]), 2.0_wp, 0.0_wp)
    call tests%close('a value met within the tolerance ends the phase', &
      stop_share(stops, 0.01_wp, [0.0_wp, 0.0_wp], [10.09_wp, -3.0_wp]), 1.0_wp, 0.0_wp)
    call tests%close('one passed is interpolated', stop_share(stops, 0.01_wp, [4.0_wp, 0.0_wp], [12.0_wp, -3.0_wp]), &
      0.75_wp, rounding)
    call tests%close('the first of two counts', stop_share(stops, 0.01_wp, [4.0_wp, 0.0_wp], [12.0_wp, -8.0_wp]), &
      0.5_wp, rounding)
    call tests%close('a value reached before the step ends the phase with it', &
      stop_share(stops, 0.01_wp, [11.0_wp, 0.0_wp], [13.0_wp, 0.0_wp]), 1.0_wp, 0.0_wp)
    call tests%close('no step is taken again for nothing of it', &
      stop_share(stops, 0.01_wp, [9.999999_wp, 0.0_wp], [13.0_wp, 0.0_wp]), 1.0e-3_wp, 0.0_wp)
  end subroutine check_shares

  !> Length of the step that is taken again.
  subroutine check_length(tests)
    type(tests_type), intent(inout) :: tests
    type(controls_type) :: controls

    controls%steps = 10
    call tests%close('a share of the step', length_to_stop(controls, 0.1_wp, 0.5_wp), 0.05_wp, rounding)
    call tests%close('not below the smallest', length_to_stop(controls, 0.1_wp, 1.0e-9_wp), 1.0e-4_wp, rounding)
    call tests%close('the smallest step stays', length_to_stop(controls, 1.0e-4_wp, 0.5_wp), 0.0_wp, 0.0_wp)
  end subroutine check_length

  !> scene = offset SCALE + factor model.
  subroutine check_reduced(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: analysis
    type(reduction_type) :: step

    allocate (analysis)
    allocate (analysis%histories(2), analysis%phases(1))
    allocate (analysis%phases(1)%stops(2))
    analysis%phases(1)%stops = two_stops()
    analysis%histories(1)%name = 'a'
    analysis%histories(1)%scale = 3.0_wp
    analysis%histories(2)%name = 'b'
    step%history_factor = [-2.0_wp, 0.0_wp]
    step%history_offset = [1.0_wp, 0.0_wp]
    call move_stops(step, analysis)
    associate (stops => analysis%phases(1)%stops)
      call tests%check('a turned sign turns the side', stops(1)%side == stop_below)
      call tests%close('offset and factor move the value', stops(1)%value, -3.5_wp, rounding)
      call tests%check('what does not change in the model reaches no value', .not. is_reached(stops(2), -1.0e300_wp))
    end associate
    step%history_factor = [2.0_wp, 1.0_wp]
    call move_stops(step, analysis)
    call tests%check('and stays on its side otherwise', analysis%phases(1)%stops(1)%side == stop_below)
    call tests%check('sides are two', stop_above /= stop_below)
  end subroutine check_reduced

  !> Loads of a phase that has ended early are those reached.
  subroutine check_ends(tests)
    type(tests_type), intent(inout) :: tests
    type(progress_type) :: progress
    type(phase_end_type) :: ended

    call tests%close('a phase nothing is known of has its whole load', fraction_reached(progress, 1), 1.0_wp, 0.0_wp)
    progress%ends = [phase_end_type(ended_by_stop, 0.25_wp, 2.0_wp), phase_end_type(ended_by_load, 1.0_wp, 3.0_wp)]
    call tests%close('a stopped phase what it reached', fraction_reached(progress, 1), 0.25_wp, 0.0_wp)
    call tests%close('the one behind it its own', fraction_reached(progress, 2), 1.0_wp, 0.0_wp)
    ended = end_of_phase(progress, 2)
    call tests%check('how it ended is told', ended%reason == ended_by_load .and. abs(ended%displacement - 3.0_wp) <= 0.0_wp)
  end subroutine check_ends
end module test_phase_stops
