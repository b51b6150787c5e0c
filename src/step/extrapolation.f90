!> Where the iterations of a step begin: its share of the phase times the rate of the unknowns in the static step before,
!> which near a limit load is nearly all of the answer (docs/methods/steps.md).
!>
!> Rates are kept as fields are, node by node, so that a restart file has them and new nodes begin with zero. The first
!> step of a phase and one behind damped sub-steps begin with nothing; what is prescribed is in force from the start.
module qsmpm_extrapolation
  use qsmpm_agreement, only: any_of
  use qsmpm_equilibrium, only: target_type
  use qsmpm_initialisation, only: step_type
  use qsmpm_kept_arrays, only: kept_arrays_type, is_kept, keep_values, kept_values, lay_array
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type
  use qsmpm_owner_copies, only: copy_values
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_unknowns, only: unknowns_type, joint_node, put_values, values_of
  implicit none
  private

  public :: extrapolate, keep_rates

  character(len=*), parameter :: rate_of = 'rate of '

contains

  !> First guess of a step, unless the attempt brings one or there is no step like it before.
  subroutine extrapolate(model, step, attempt, goal)
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    type(attempt_type), intent(in) :: attempt
    type(target_type), intent(inout) :: goal
    real(wp), allocatable :: rate(:, :)
    real(wp) :: share
    integer :: f

    if (allocated(attempt%guess)) goal%guess = attempt%guess
    share = attempt%fraction - model%state%progress%fraction
    if (allocated(attempt%guess) .or. attempt%damping > 0.0_wp .or. .not. share > 0.0_wp &
      .or. model%state%progress%phase_steps == 0 .or. step%from_rest) return
    allocate (goal%guess, mold=goal%prescribed)
    goal%guess = 0.0_wp
    associate (fields => step%unknowns%fields, kept => model%state%kept)
      do f = 1, size(fields)
        if (.not. is_kept(kept, rate_of//fields(f)%name)) cycle
        rate = kept_values(kept, rate_of//fields(f)%name)
        if (f == 1) call copy_values(step%team, step%node_copies, rate)
        call put_values(step%unknowns, f, share*rate, goal%guess)
      end do
    end associate
    if (any_of(step%team, any(abs(goal%guess) > 0.0_wp))) then
      where (step%equations%number == 0) goal%guess = goal%prescribed
    else
      deallocate (goal%guess)
    end if
  end subroutine extrapolate

  !> Keep the rates of a static step of some share of the phase; a damped one leaves none.
  subroutine keep_rates(unknowns, attempt, share, changes, kept)
    type(unknowns_type), intent(in) :: unknowns
    type(attempt_type), intent(in) :: attempt
    !> 0 at constant load, which leaves the rates.
    real(wp), intent(in) :: share
    !> (most components, all nodes)
    real(wp), intent(in) :: changes(:, :)
    type(kept_arrays_type), intent(inout) :: kept
    real(wp), allocatable :: rate(:, :)
    integer :: f

    if (.not. (share > 0.0_wp .or. attempt%damping > 0.0_wp)) return
    do f = 1, size(unknowns%fields)
      associate (field => unknowns%fields(f))
        if (allocated(rate)) deallocate (rate)
        allocate (rate(field%components, field%node_count), source=0.0_wp)
        if (.not. attempt%damping > 0.0_wp) rate = values_of(unknowns, f, changes)/share
        call lay_array(kept, rate_of//field%name, rate, nodal=field%node_count == unknowns%fields(1)%node_count)
        call keep_values(kept, rate_of//field%name, rate)
      end associate
    end do
  end subroutine keep_rates
end module qsmpm_extrapolation
