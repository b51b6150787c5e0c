!> Limit load of a phase by the compliance of the body.
!>
!>   C = (df . U)/(df . df)
!>
!> df is the load increment of a step at the free components of the nodes, U the displacement of the step with its
!> re-equilibrations. The first accepted step of the phase gives the reference; step control rejects a step whose C is
!> more than LIMIT COMPLIANCE times that and bisects the load between the last accepted and the rejected one
!> (qsmpm_step_control). The knee is where C, interpolated in its logarithm between the middles of these two steps, is
!> LIMIT COMPLIANCE times the reference: that is the answer. How sure it is says the plateau, from the load on at which
!> the body is half as compliant as allowed, found in the same way, as far below the knee as the load of an endless
!> compliance may lie above it. Without LIMIT COMPLIANCE C is only measured.
!> docs/methods/limit_loads.md
module qsmpm_limit_load
  use qsmpm_kinds, only: wp
  use qsmpm_rounded_text, only: rounded_text
  implicit none
  private

  public :: compliance_type, limit_load_type, add_compliance, compliance_of, note_accepted, note_refused
  public :: is_found, interpolate_knee, limit_loads, limit_text, limit_report, relative_compliance, jump_note

  !> What the load increment of a step does.
  type :: compliance_type
    !> df . U and df . df.
    real(wp) :: work = 0.0_wp, square = 0.0_wp
  end type compliance_type

  !> Where a phase stands before its limit load; all zero when it begins.
  type :: limit_load_type
    !> Compliance of the first accepted step of the phase, of the last one and of the most compliant one [length/force].
    real(wp) :: first = 0.0_wp, last = 0.0_wp, most = 0.0_wp
    !> Middle of the last accepted step, as a load fraction.
    real(wp) :: middle = 0.0_wp
    !> Load fraction that was rejected for its compliance last, 0 for none; compliance and middle of that step.
    real(wp) :: refused = 0.0_wp, refused_compliance = 0.0_wp, refused_middle = 0.0_wp
    !> Load fraction at which the compliance has come to half of what is allowed, 0 for none: the plateau begins there,
    !> and begins anew behind a stiffer step.
    real(wp) :: plateau = 0.0_wp
    !> Load fraction at the knee, 0 until the limit load is found.
    real(wp) :: knee = 0.0_wp
  end type limit_load_type

  !> Share of the compliance that is allowed from which a step belongs to the plateau.
  real(wp), parameter :: flat = 0.5_wp

contains

  !> Take a solve into its step: df is that of the first solve, U grows with each.
  pure subroutine add_compliance(solve, step)
    type(compliance_type), intent(in) :: solve
    type(compliance_type), intent(inout) :: step

    step%work = step%work + solve%work
    if (.not. step%square > 0.0_wp) step%square = solve%square
  end subroutine add_compliance

  !> Compliance of a step, 0 where no load grows.
  pure real(wp) function compliance_of(step)
    type(compliance_type), intent(in) :: step

    compliance_of = 0.0_wp
    if (step%square > 0.0_wp) compliance_of = step%work/step%square
  end function compliance_of

  !> Remember an accepted step.
  pure subroutine note_accepted(step, allowed, start, last, limit)
    type(compliance_type), intent(in) :: step
    !> LIMIT COMPLIANCE, 0 for none.
    real(wp), intent(in) :: allowed
    !> Shares of the phase at its start and end.
    real(wp), intent(in) :: start, last
    type(limit_load_type), intent(inout) :: limit
    type(limit_load_type) :: before

    before = limit
    limit%last = compliance_of(step)
    limit%most = max(limit%most, limit%last)
    limit%middle = 0.5_wp*(start + last)
    if (.not. limit%first > 0.0_wp) limit%first = limit%last
    ! A load that was refused from afar is carried.
    if (.not. last < limit%refused) limit%refused = 0.0_wp
    if (.not. (allowed > 0.0_wp .and. limit%last > flat*allowed*limit%first)) then
      limit%plateau = 0.0_wp
    else if (.not. limit%plateau > 0.0_wp) then
      limit%plateau = load_of(flat*allowed*limit%first, before, limit%last, limit%middle)
    end if
  end subroutine note_accepted

  !> Remember a step rejected for its compliance, or because the ground does not carry its loads.
  pure subroutine note_refused(step, start, last, limit)
    type(compliance_type), intent(in) :: step
    !> Shares of the phase at its start and end.
    real(wp), intent(in) :: start, last
    type(limit_load_type), intent(inout) :: limit

    limit%refused = last
    limit%refused_compliance = compliance_of(step)
    limit%refused_middle = 0.5_wp*(start + last)
  end subroutine note_refused

  !> Whether the phase has ended at its limit load.
  pure logical function is_found(limit)
    type(limit_load_type), intent(in) :: limit

    is_found = limit%knee > 0.0_wp
  end function is_found

  !> The limit load is found: interpolate the knee, and the start of the plateau where no step has been on it.
  pure subroutine interpolate_knee(allowed, limit)
    !> LIMIT COMPLIANCE.
    real(wp), intent(in) :: allowed
    type(limit_load_type), intent(inout) :: limit

    limit%knee = load_of(allowed*limit%first, limit, limit%refused_compliance, limit%refused_middle)
    if (.not. limit%plateau > 0.0_wp) limit%plateau = load_of(flat*allowed*limit%first, limit, &
      limit%refused_compliance, limit%refused_middle)
  end subroutine interpolate_knee

  !> Load fraction of a compliance, log C taken linearly from the middle of the last accepted step to that of another.
  pure real(wp) function load_of(compliance, limit, other, middle) result(load)
    real(wp), intent(in) :: compliance
    !> Up to the last accepted step.
    type(limit_load_type), intent(in) :: limit
    !> Compliance and middle of the other step.
    real(wp), intent(in) :: other, middle

    load = limit%middle + log(compliance/limit%last)/log(other/limit%last)*(middle - limit%middle)
  end function load_of

  !> Load factors between which the search ended, carried and refused, that of the knee and that from which on steps
  !> belong to the plateau; zeros until it is found.
  pure function limit_loads(limit, fraction, load_factor) result(loads)
    type(limit_load_type), intent(in) :: limit
    !> Load fraction done, and load factor at the end of the phase.
    real(wp), intent(in) :: fraction, load_factor
    real(wp) :: loads(4)

    loads = 0.0_wp
    if (is_found(limit)) loads = load_factor*[fraction, limit%refused, limit%knee, min(limit%plateau, limit%knee)]
  end function limit_loads

  !> The limit load in words.
  pure function limit_text(loads) result(text)
    !> As limit_loads gives them (4).
    real(wp), intent(in) :: loads(:)
    character(len=:), allocatable :: text

    text = 'limit load '//rounded_text(loads(3), 6)
  end function limit_text

  !> The limit load, whose it is and how far it is known: from where the plateau begins to where a compliance goes whose
  !> inverse falls on as from there to the knee.
  pure function limit_report(loads) result(text)
    !> As limit_loads gives them (4).
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

  !> The warning of a limit load that no step led up to: the one refused is more than twice as compliant as the last one
  !> carried, as a short step is where iterations lose soil that stands. Empty where the last step was on the plateau.
  pure function jump_note(phase, limit, allowed) result(text)
    character(len=*), intent(in) :: phase
    !> Of a phase that has ended at its limit load.
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

  !> Compliance of the last accepted step relative to that of the first one of its phase, 0 where no load grows.
  pure real(wp) function relative_compliance(limit)
    type(limit_load_type), intent(in) :: limit

    relative_compliance = 0.0_wp
    if (limit%first > 0.0_wp) relative_compliance = limit%last/limit%first
  end function relative_compliance
end module qsmpm_limit_load
