!> Limit load of a phase by the compliance of the body.
!>
!>   C = (df . U)/(df . df)
!>
!> df is the load increment of a step at the free components of the nodes, U the displacement of the step including its
!> re-equilibrations. The first accepted step of the phase gives the reference value; step control rejects a step whose
!> C exceeds LIMIT COMPLIANCE times the reference and bisects the load between the last accepted and the rejected step
!> (qsmpm_step_control). The result is the knee, where C, interpolated logarithmically between the midpoints of these
!> two steps, is LIMIT COMPLIANCE times the reference. Its uncertainty is estimated from the plateau, which begins at
!> the load at which C is half of the allowed value, found in the same way, and ends as far above the knee as the
!> extrapolated load of infinite compliance. Without LIMIT COMPLIANCE, C is only measured, and the load at which it
!> first reaches 20 times the reference, or 10 times where it does not, or at which a body-fitted mesh is too
!> distorted, is recorded as an estimate.
!> docs/methods/limit_loads.md
module qsmpm_limit_load
  use qsmpm_kinds, only: wp
  use qsmpm_rounded_text, only: rounded_text
  implicit none
  private

  public :: compliance_type, limit_load_type, add_compliance, compliance_of, convert_compliances
  public :: note_accepted, note_left, note_refused, fallen, is_found, interpolate_knee
  public :: limit_loads, limit_text, limit_report, relative_compliance, jump_note

  !> Work and norm of the load increment of a step, from which its compliance follows.
  type :: compliance_type
    !> df . U and df . df.
    real(wp) :: work = 0.0_wp, square = 0.0_wp
  end type compliance_type

  !> Data of a phase for its limit load; all zero at its start.
  type :: limit_load_type
    !> Compliance of the first and the last accepted step of the phase and the largest one [length/force].
    real(wp) :: first = 0.0_wp, last = 0.0_wp, most = 0.0_wp
    !> Midpoint of the last accepted step, as a load fraction.
    real(wp) :: middle = 0.0_wp
    !> Load fraction last rejected for its compliance, 0 for none; compliance and midpoint of that step.
    real(wp) :: refused = 0.0_wp, refused_compliance = 0.0_wp, refused_middle = 0.0_wp
    !> Load fraction at which the compliance reaches half of the allowed value, 0 for none: the start of the plateau,
    !> which is determined again after a stiffer step.
    real(wp) :: plateau = 0.0_wp
    !> Load fraction at the knee, 0 until the limit load is found.
    real(wp) :: knee = 0.0_wp
    !> Load fraction at which the compliance first reached 10 or 20 times that of the first step, 0 for none; negative
    !> where a body-fitted mesh was left before.
    real(wp) :: passed = 0.0_wp
    !> df . df of the last accepted step over the square of its load fraction; negative where the mesh has changed
    !> since.
    real(wp) :: square = 0.0_wp
  end type limit_load_type

  !> Ratio of the compliance of a step to that of the first one beyond which soil has failed, and at its limit load.
  real(wp), parameter :: fallen = 10.0_wp, at_limit = 20.0_wp
  !> Ratio of the loads at these compliances on a plateau; beyond it the ground has hardened. Ratio of compliances
  !> beyond which a body-fitted mesh that is too distorted has failed with the soil.
  real(wp), parameter :: plateau_end = 1.15_wp, soft = 2.0_wp
  !> Fraction of the allowed compliance above which a step belongs to the plateau.
  real(wp), parameter :: flat = 0.5_wp

contains

  !> Adds a solve to its step: df is that of the first solve, U is the sum over the solves.
  pure subroutine add_compliance(solve, step)
    type(compliance_type), intent(in) :: solve
    type(compliance_type), intent(inout) :: step

    step%work = step%work + solve%work
    if (.not. step%square > 0.0_wp) step%square = solve%square
  end subroutine add_compliance

  !> Converts the compliances of a phase to the nodes of another mesh, where a step is the first one on it: df . df of
  !> the same load depends on the nodes on which it acts, its work does not.
  pure subroutine convert_compliances(step, length, limit)
    type(compliance_type), intent(in) :: step
    !> Load fraction of the step.
    real(wp), intent(in) :: length
    type(limit_load_type), intent(inout) :: limit
    real(wp) :: ratio

    if (.not. (step%square > 0.0_wp .and. limit%square < 0.0_wp)) return
    ratio = -limit%square*length**2/step%square
    limit%first = ratio*limit%first
    limit%last = ratio*limit%last
    limit%most = ratio*limit%most
    limit%refused_compliance = ratio*limit%refused_compliance
    limit%square = -limit%square
  end subroutine convert_compliances

  !> Returns the compliance of a step, 0 if no load increases.
  pure real(wp) function compliance_of(step)
    type(compliance_type), intent(in) :: step

    compliance_of = 0.0_wp
    if (step%square > 0.0_wp) compliance_of = step%work/step%square
  end function compliance_of

  !> Records an accepted step.
  pure subroutine note_accepted(step, allowed, start, last, limit)
    type(compliance_type), intent(in) :: step
    !> LIMIT COMPLIANCE, 0 for none.
    real(wp), intent(in) :: allowed
    !> Load fractions of the phase at the start and end of the step.
    real(wp), intent(in) :: start, last
    type(limit_load_type), intent(inout) :: limit
    type(limit_load_type) :: before

    before = limit
    limit%last = compliance_of(step)
    limit%most = max(limit%most, limit%last)
    limit%middle = 0.5_wp*(start + last)
    if (.not. limit%first > 0.0_wp) limit%first = limit%last
    limit%square = step%square/(last - start)**2
    call note_passed(before, limit)
    ! A load that was rejected in a larger step is now supported.
    if (.not. last < limit%refused) limit%refused = 0.0_wp
    if (.not. (allowed > 0.0_wp .and. limit%last > flat*allowed*limit%first)) then
      limit%plateau = 0.0_wp
    else if (.not. limit%plateau > 0.0_wp) then
      limit%plateau = load_of(flat*allowed*limit%first, before, limit%last, limit%middle)
    end if
  end subroutine note_accepted

  !> Estimates the limit load where the compliance of an accepted step shows failure for the first time. Soil that moves
  !> against its load, as it rebounds, has a negative compliance and is not assessed.
  pure subroutine note_passed(before, limit)
    !> Data before the step.
    type(limit_load_type), intent(in) :: before
    type(limit_load_type), intent(inout) :: limit
    real(wp) :: load

    if (.not. min(limit%first, before%last) > 0.0_wp) return
    if (limit%last > fallen*limit%first .and. .not. limit%passed > 0.0_wp) then
      limit%passed = before%middle
      if (before%last < fallen*limit%first) limit%passed = load_of(fallen*limit%first, before, limit%last, limit%middle)
    end if
    if (.not. limit%last > at_limit*limit%first .or. before%most > at_limit*limit%first) return
    load = load_of(at_limit*limit%first, before, limit%last, limit%middle)
    if (load <= plateau_end*limit%passed) limit%passed = load
  end subroutine note_passed

  !> Records that a body-fitted mesh is too distorted, or finds no equilibrium, beyond a load.
  pure subroutine note_left(fraction, limit)
    !> Completed load fraction.
    real(wp), intent(in) :: fraction
    type(limit_load_type), intent(inout) :: limit

    if (limit%first > 0.0_wp .and. .not. limit%passed > 0.0_wp) limit%passed = merge(fraction, -fraction, &
      limit%last > soft*limit%first)
  end subroutine note_left

  !> Records a step rejected for its compliance, or because the soil does not support its loads.
  pure subroutine note_refused(step, start, last, limit)
    type(compliance_type), intent(in) :: step
    !> Load fractions of the phase at the start and end of the step.
    real(wp), intent(in) :: start, last
    type(limit_load_type), intent(inout) :: limit

    limit%refused = last
    limit%refused_compliance = compliance_of(step)
    limit%refused_middle = 0.5_wp*(start + last)
  end subroutine note_refused

  !> Returns whether the phase has ended at its limit load.
  pure logical function is_found(limit)
    type(limit_load_type), intent(in) :: limit

    is_found = limit%knee > 0.0_wp
  end function is_found

  !> Ends the search for the limit load: interpolates the knee, and the start of the plateau if no step was on it.
  pure subroutine interpolate_knee(allowed, limit)
    !> LIMIT COMPLIANCE.
    real(wp), intent(in) :: allowed
    type(limit_load_type), intent(inout) :: limit

    limit%knee = load_of(allowed*limit%first, limit, limit%refused_compliance, limit%refused_middle)
    if (.not. limit%plateau > 0.0_wp) limit%plateau = load_of(flat*allowed*limit%first, limit, &
      limit%refused_compliance, limit%refused_middle)
  end subroutine interpolate_knee

  !> Returns the load fraction of a compliance, with log C linear between the midpoints of the last accepted step and
  !> another one.
  pure real(wp) function load_of(compliance, limit, other, middle) result(load)
    real(wp), intent(in) :: compliance
    !> Data of the phase up to the last accepted step.
    type(limit_load_type), intent(in) :: limit
    !> Compliance and midpoint of the other step.
    real(wp), intent(in) :: other, middle

    load = limit%middle + log(compliance/limit%last)/log(other/limit%last)*(middle - limit%middle)
  end function load_of

  !> Returns the load factors between which the search ended, supported and rejected, the load factor of the knee and
  !> the one from which steps belong to the plateau; zeros until the limit load is found.
  pure function limit_loads(limit, fraction, load_factor) result(loads)
    type(limit_load_type), intent(in) :: limit
    !> Completed load fraction; load factor at the end of the phase.
    real(wp), intent(in) :: fraction, load_factor
    real(wp) :: loads(4)

    loads = 0.0_wp
    if (is_found(limit)) loads = load_factor*[fraction, limit%refused, limit%knee, min(limit%plateau, limit%knee)]
  end function limit_loads

  !> Returns the limit load as text.
  pure function limit_text(loads) result(text)
    !> Result of limit_loads (4).
    real(wp), intent(in) :: loads(:)
    character(len=:), allocatable :: text

    text = 'limit load '//rounded_text(loads(3), 6)
  end function limit_text

  !> Returns the report of the limit load and its uncertainty: from the start of the plateau to the load of infinite
  !> compliance, extrapolated linearly in the inverse of the compliance from the plateau to the knee.
  pure function limit_report(loads) result(text)
    !> Result of limit_loads (4).
    real(wp), intent(in) :: loads(:)
    character(len=:), allocatable :: text
    character(len=12) :: scatter
    real(wp) :: endless

    endless = max(loads(2), 2.0_wp*loads(3) - loads(4))
    write (scatter, '(f12.1)') 100.0_wp*(endless - loads(4))/loads(3)
    text = limit_text(loads)//' of this grid (the knee), known to '//trim(adjustl(scatter))// &
      ' %: its plateau begins at '//rounded_text(loads(4), 6)//', the largest load carried is '// &
      rounded_text(loads(1), 6)//', no equilibrium at '//rounded_text(loads(2), 6)// &
      ', and the compliance grows without bound towards '//rounded_text(endless, 3)// &
      '; `qsmpm-verify study DECK --history load_factor` gives the discretisation error'
  end function limit_report

  !> Returns the warning about a limit load with a jump of the compliance: the rejected step is more than twice as
  !> compliant as the last accepted one, as when the iterations of a short step fail in stable soil. Empty if the last
  !> step was on the plateau.
  pure function jump_note(phase, limit, allowed) result(text)
    character(len=*), intent(in) :: phase
    !> Data of a phase that has ended at its limit load.
    type(limit_load_type), intent(in) :: limit
    !> LIMIT COMPLIANCE.
    real(wp), intent(in) :: allowed
    character(len=:), allocatable :: text

    text = ''
    if (relative_compliance(limit) > flat*allowed) return
    text = "warning: phase '"//phase//"': the last accepted step is "// &
      rounded_text(relative_compliance(limit), 2)//' times as compliant as the first one, the rejected one more '// &
      'than '//rounded_text(allowed, 3)//' times: such a jump may come from the iterations, and the '// &
      'ground may carry more than this limit load: check by the phase without LIMIT COMPLIANCE, other steps, or '// &
      '`qsmpm-verify bounds DECK --phase NAME`'//new_line('a')
  end function jump_note

  !> Returns the compliance of the last accepted step relative to that of the first one, 0 if no load increases.
  pure real(wp) function relative_compliance(limit)
    type(limit_load_type), intent(in) :: limit

    relative_compliance = 0.0_wp
    if (limit%first > 0.0_wp) relative_compliance = limit%last/limit%first
  end function relative_compliance
end module qsmpm_limit_load
