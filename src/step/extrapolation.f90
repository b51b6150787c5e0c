!> Where the iterations of a step begin: its share of the phase, or what the factor of a search for the safety grows by
!> in it, times the rate of the unknowns in the static step before, which near a limit load is nearly all of the answer;
!> of a damped sub-step, the changes of the one before (docs/methods/steps.md).
!>
!> Both are kept as fields are, node by node, so that a restart file has them and new nodes begin with zero. The first
!> step of a phase begins with nothing, and so does one behind damped sub-steps or an attempt that has failed, but one
!> at another factor; what is prescribed is in force from the start. With laws from elsewhere the second one does too: a
!> law that changes the stress where nothing is strained is found where nothing is strained yet.
module qsmpm_extrapolation
  use qsmpm_agreement, only: any_of
  use qsmpm_equilibrium, only: target_type
  use qsmpm_initialisation, only: step_type
  use qsmpm_kept_arrays, only: kept_arrays_type, is_kept, keep_values, kept_values
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type
  use qsmpm_nodal_fields, only: rate_of, substep_of
  use qsmpm_owner_copies, only: copy_values
  use qsmpm_safety_factors, only: is_searching
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_unknowns, only: unknowns_type, put_values, values_of
  implicit none
  private

  public :: extrapolate, keep_rates, length_of

contains

  !> First guess of a step, where there is a step like it before.
  subroutine extrapolate(model, step, attempt, goal)
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    type(attempt_type), intent(in) :: attempt
    type(target_type), intent(inout) :: goal
    real(wp), allocatable :: values(:, :)
    character(len=:), allocatable :: name
    real(wp) :: share
    logical :: damped, searching
    integer :: f

    searching = is_searching(model)
    damped = attempt%damping > 0.0_wp
    share = length_of(model, attempt)
    if (damped) share = 1.0_wp
    if (.not. share > 0.0_wp) return
    if ((damped .or. .not. searching) .and. (step%from_rest .or. (damped .neqv. step%damped))) return
    if (.not. (damped .or. searching .or. model%state%progress%fraction > 0.0_wp)) return
    associate (materials => model%analysis%materials)
      if (.not. damped .and. model%state%progress%phase_steps < merge(2, 1, any(materials%user%given .or. &
        materials%own_law))) return
    end associate
    allocate (goal%guess, mold=goal%prescribed)
    goal%guess = 0.0_wp
    associate (fields => step%unknowns%fields, kept => model%state%kept)
      do f = 1, size(fields)
        name = rate_of//fields(f)%name
        if (damped) name = substep_of//fields(f)%name
        if (.not. is_kept(kept, name)) cycle
        values = kept_values(kept, name)
        if (f == 1) call copy_values(step%team, step%node_copies, values)
        call put_values(step%unknowns, f, share*values, goal%guess)
      end do
    end associate
    if (any_of(step%team, any(abs(goal%guess) > 0.0_wp))) then
      where (step%equations%number == 0) goal%guess = goal%prescribed
    else
      deallocate (goal%guess)
    end if
  end subroutine extrapolate

  !> How far a static step goes: share of the phase, or what the factor grows by where a search has found one that is
  !> stable. A re-equilibration of a search goes as far as what was solved before it, one of other steps nowhere.
  pure real(wp) function length_of(model, attempt)
    type(model_type), intent(in) :: model
    type(attempt_type), intent(in) :: attempt

    associate (progress => model%state%progress)
      length_of = attempt%fraction - progress%fraction
      if (is_searching(model) .and. progress%bracket%stable > 0.0_wp) &
        length_of = progress%strength_factor - progress%bracket%stable
    end associate
  end function length_of

  !> Keep the rates of a static step of some length, or the changes of one that leaves none.
  subroutine keep_rates(unknowns, leaves_none, share, changes, kept)
    type(unknowns_type), intent(in) :: unknowns
    !> A damped sub-step, or the first step of a search for a factor of safety.
    logical, intent(in) :: leaves_none
    !> 0 at constant load, where a static step leaves the rates.
    real(wp), intent(in) :: share
    !> (most components, all nodes)
    real(wp), intent(in) :: changes(:, :)
    type(kept_arrays_type), intent(inout) :: kept
    integer :: f

    if (.not. (share > 0.0_wp .or. leaves_none)) return
    do f = 1, size(unknowns%fields)
      associate (name => unknowns%fields(f)%name, values => values_of(unknowns, f, changes))
        if (.not. is_kept(kept, rate_of//name)) cycle
        if (leaves_none) then
          call keep_values(kept, rate_of//name, 0.0_wp*values)
          call keep_values(kept, substep_of//name, values)
        else
          call keep_values(kept, rate_of//name, values/share)
        end if
      end associate
    end do
  end subroutine keep_rates
end module qsmpm_extrapolation
