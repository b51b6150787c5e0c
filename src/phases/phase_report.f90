!> Log entries about the steps of a phase: warnings about the stabilisation, about material that does not follow a
!> prescribed set and about initial stresses, the active window, and the reason why no equilibrium was found. The module
!> does not affect the solution.
module qsmpm_phase_report
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: any_of
  use qsmpm_consolidation, only: excess_pressure
  use qsmpm_phase_description, only: phase_safety, phase_type
  use qsmpm_contact_report, only: contact_check_type, apart_text, check_contact, end_contact_check
  use qsmpm_contact_results, only: penetration_type, deepest_of_all
  use qsmpm_error, only: error_type, error_not_converged, error_singular, error_tangled
  use qsmpm_phase_loads, only: consolidation_of, free_surface_of, is_body_loaded, waits
  use qsmpm_cut_cell_check, only: cut_cell_check_type, end_cut_cell_check, warn_of_cut_cells
  use qsmpm_grid_window, only: window_type, cells_of, operator(==)
  use qsmpm_initial_strength, only: count_beyond_strength
  use qsmpm_initialisation, only: step_type, ready_terms
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_limit_load, only: relative_compliance
  use qsmpm_locking_check, only: check_locking
  use qsmpm_held_sides, only: side_check_type, warn_of_crossing, warn_of_reached_sides
  use qsmpm_unsupported_parts, only: describe_unsupported_parts
  use qsmpm_model, only: model_type, progress_type
  use qsmpm_node_graph, only: connectivity_type
  use qsmpm_material_description, only: traits_of
  use qsmpm_moving_mesh_check, only: moving_mesh_check_type, check_moving_mesh
  use qsmpm_observer, only: observer_type
  use qsmpm_own_part, only: is_divided, own_of
  use qsmpm_penetration, only: penetration_check_type, warn_of_penetration
  use qsmpm_phase_ends, only: has_start_move, start_move
  use qsmpm_step_control, only: outcome_type
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_edge_failure, only: edge_note
  use qsmpm_sheared_ground, only: fallen_note, flow_notes, swollen_note
  use qsmpm_team, only: largest, total
  use qsmpm_text, only: integer_list, integer_text
  use qsmpm_user_material, only: interface_umat, model_tangent_auto, model_tangent_numerical
  implicit none
  private

  public :: phase_report_type, report_step, report_stabilisation, report_length, report_phase, warn_of_lag, &
    warn_of_initial_strength, advise_on_tangent, all_is_held, begin_report, failure_text, overloaded, beyond_text, &
    start_text

  !> Share of the stabilisation above which a warning is printed for any setting of the deck.
  real(wp), parameter :: much = 5.0e-2_wp
  !> Change of the stress due to the length of a step above which a warning is printed.
  real(wp), parameter :: long_step = 5.0e-2_wp
  !> Displacement, in gamma H^2/M, below which soil is at rest.
  real(wp), parameter :: still = 1.0e-4_wp
  !> Ratio of the remaining excess pore pressure above which a phase has had nearly no drainage.
  real(wp), parameter :: unchanged = 0.99_wp

  !> Reports made so far.
  type :: phase_report_type
    !> A warning that the material does not follow a set of the present phase was printed.
    logical :: lag_warned = .false.
    !> A note that the strength of a material at failure is not unique was printed.
    logical :: flow_told = .false.
    !> A note that the tangent of a user-defined material may be the cause of cut-backs was printed.
    logical :: tangent_told = .false.
    !> A warning that steps are long for a user-defined law was printed.
    logical :: length_warned = .false.
    !> Number of steps of the phase with a large share of the stabilisation, largest share and its load factor.
    integer :: stiff_steps = 0
    real(wp) :: worst_share = 0.0_wp, worst_load_factor = 0.0_wp
    !> Number of steps of the phase accepted with more than STABILISATION SHARE, and the largest share.
    integer :: borne_steps = 0
    real(wp) :: largest_borne = 0.0_wp
    !> Active window last reported to the observer.
    type(window_type) :: window
    !> Results of the rows of a moving mesh.
    type(moving_mesh_check_type) :: rows
    !> Penetration of soil into rigid bodies.
    type(penetration_check_type) :: penetration
    !> Force histories of rigid bodies.
    type(contact_check_type) :: contact
    !> Points that crossed constrained sides of the mesh.
    type(side_check_type) :: sides
    !> Largest and mean excess pore pressure at the start of the phase.
    real(wp) :: excess(2) = 0.0_wp
  end type phase_report_type

contains

  !> Reports the state of solver, mesh and cut bodies after an accepted step.
  subroutine report_step(model, step, penetration, report, observer)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    type(penetration_type), intent(in) :: penetration
    type(phase_report_type), intent(inout) :: report
    class(observer_type), intent(inout) :: observer
    type(penetration_type) :: deepest
    real(wp) :: crossing

    if (allocated(step%system%note)) then
      call observer%note(step%system%note)
      deallocate (step%system%note)
    end if
    crossing = largest(model%part%team, step%crossing)
    call warn_of_crossing(model%cell_size, crossing, report%sides, observer)
    if (step%window == model%state%window .and. .not. is_divided(model%part)) &
      call check_moving_mesh(model, step%activation, report%rows, observer)
    deepest = penetration
    call deepest_of_all(model%part%team, deepest)
    call warn_of_penetration(model, deepest, report%penetration, observer)
    call check_contact(model, report%contact)
    call warn_of_cut_cells(model, step%configuration_type, step%cut, observer)
    if (.not. is_divided(model%part)) call report_window(model, report, observer)
  end subroutine report_step

  !> Reports a change of the active window.
  subroutine report_window(model, report, observer)
    type(model_type), intent(in) :: model
    type(phase_report_type), intent(inout) :: report
    class(observer_type), intent(inout) :: observer

    associate (window => model%state%window, d => model%mesh%dimension)
      if (report%window == window) return
      report%window = window
      call observer%note('active window rebuilt around the material: '//integer_text(product(cells_of(window)))// &
        ' cells of the grid, from cell ('//integer_list(window%first(:d))//') to ('//integer_list(window%last(:d))//')')
    end associate
  end subroutine report_window

  !> Warns of the first step with a significant error due to its length; where the deck bounds that error, of the first
  !> step of the smallest length that still exceeds the bound.
  subroutine report_length(load_factor, step_error, bound, report, observer)
    real(wp), intent(in) :: load_factor
    !> Error due to the length of the step, as a share of the stress, and bound in the deck, 0 for none.
    real(wp), intent(in) :: step_error, bound
    type(phase_report_type), intent(inout) :: report
    class(observer_type), intent(inout) :: observer

    if (report%length_warned .or. .not. step_error > merge(bound, long_step, bound > 0.0_wp)) return
    report%length_warned = .true.
    if (bound > 0.0_wp) then
      call observer%note('warning: the step to load factor '//factor_text(load_factor)//' is the smallest one, and '// &
        'its error by its length, '//percent_text(step_error)//', is above STEP ERROR: the soil moves on '// &
        'without additional load there; a smaller SMALLEST STEP of *CONTROLS resolves it (step_error of curves.csv)')
      return
    end if
    call observer%note('warning: the step to load factor '//factor_text(load_factor)//' in two halves gives '// &
      'stresses that differ by '//percent_text(0.5_wp*step_error)//': the stress integration of the *USER '// &
      'MATERIAL depends on the length of the steps (step_error of curves.csv); use more STEPS, or STEP ERROR of '// &
      '*CONTROLS')
  end subroutine report_length

  !> Warns of the first step of a phase with a large share of the stabilisation, and stores the largest share.
  subroutine report_stabilisation(load_factor, share, allowed, report, observer)
    real(wp), intent(in) :: load_factor
    !> Share of the stabilisation in the step, and share allowed in the deck.
    real(wp), intent(in) :: share, allowed
    type(phase_report_type), intent(inout) :: report
    class(observer_type), intent(inout) :: observer

    if (share > allowed) then
      report%borne_steps = report%borne_steps + 1
      report%largest_borne = max(report%largest_borne, share)
    end if
    if (.not. share > much) return
    if (report%stiff_steps == 0) call observer%note('warning: the stabilisation carries '//percent_text(share)// &
      ' of the forces at load factor '//factor_text(load_factor)//': the body is too stiff '// &
      'by about as much; lower FACTOR of *METHOD or STABILISATION SHARE of *CONTROLS')
    report%stiff_steps = report%stiff_steps + 1
    if (.not. share > report%worst_share) return
    report%worst_share = share
    report%worst_load_factor = load_factor
  end subroutine report_stabilisation

  !> Reports on the results of a phase at its end.
  subroutine report_phase(model, cut, report, observer)
    type(model_type), intent(in) :: model
    type(cut_cell_check_type), intent(inout) :: cut
    type(phase_report_type), intent(inout) :: report
    class(observer_type), intent(inout) :: observer
    character(len=:), allocatable :: notes

    associate (progress => model%state%progress, phase => model%analysis%phases(model%state%progress%phase))
      if (report%stiff_steps > 0) call observer%note("warning: phase '"//phase%name// &
        "': the stabilisation carries more than "//percent_text(much)//' of the forces in '// &
        integer_text(report%stiff_steps)//' of '//integer_text(progress%phase_steps)//' steps, '// &
        percent_text(report%worst_share)//' at the most, at load factor '//factor_text(report%worst_load_factor))
      if (report%borne_steps > 0) call observer%note("warning: phase '"//phase%name// &
        "': the stabilisation of cut cells carries up to "//percent_text(report%largest_borne)// &
        ' of the forces of their neighbourhood in '//integer_text(report%borne_steps)//' of '// &
        integer_text(progress%phase_steps)//' steps, more than STABILISATION SHARE: '// &
        'stresses there are in error by about as much')
      report%borne_steps = 0
      report%largest_borne = 0.0_wp
      report%stiff_steps = 0
      report%worst_share = 0.0_wp
      call end_cut_cell_check(phase%name, cut, observer)
      call end_contact_check(model, report%contact, observer)
      call warn_of_reached_sides(model, report%sides, observer)
      if (progress%phase == 1 .and. has_start_move(progress)) &
        call observer%note(start_text(progress, phase%name, model%analysis%length_unit))
    end associate
    call report_excess(model, report%excess, observer)
    call check_locking(model, observer)
    call observer%note_lines(swollen_note(model)//fallen_note(model)//edge_note(model))
    if (report%flow_told) return
    notes = flow_notes(model)
    call observer%note_lines(notes)
    report%flow_told = len(notes) > 0
  end subroutine report_phase

  !> Initialises the reports at the start of a phase.
  subroutine begin_report(model, report)
    type(model_type), intent(in) :: model
    type(phase_report_type), intent(inout) :: report

    report%lag_warned = .false.
    report%excess = excess_of(model)
  end subroutine begin_report

  !> Returns the largest excess pore pressure of consolidating soil, and its mean over the volume.
  function excess_of(model) result(excess)
    type(model_type), intent(in) :: model
    real(wp) :: excess(2), sums(2)

    associate (points => model%state%points, pressure => abs(excess_pressure(model)), team => model%part%team)
      associate (volume => merge(points%volume(:points%count), 0.0_wp, own_of(model%part%points, points%count)))
        sums = total(team, [sum(volume*pressure), sum(volume)])
        excess = [largest(team, maxval([0.0_wp, pressure])), sums(1)/max(sums(2), tiny(sums))]
      end associate
    end associate
  end function excess_of

  !> Reports the remaining excess pore pressure of a phase with consolidation, and a phase without drainage.
  subroutine report_excess(model, before, observer)
    type(model_type), intent(in) :: model
    !> Largest and mean excess pore pressure at the start of the phase.
    real(wp), intent(in) :: before(2)
    class(observer_type), intent(inout) :: observer
    real(wp) :: now(2)

    associate (phases => model%analysis%phases, number => model%state%progress%phase)
      if (phases(number)%kind == phase_safety .or. consolidation_of(phases, number) == 0 .or. &
        free_surface_of(phases, number) > 0) return
      now = excess_of(model)
      call observer%note("phase '"//phases(number)%name//"': the excess pore pressure is at most "// &
        rounded_text(now(1), 4)//' at its end, '//rounded_text(before(1), 4)//' at its start, in the mean '// &
        rounded_text(now(2), 4)//' and '//rounded_text(before(2), 4))
      if (now(2) > unchanged*before(2) .and. before(2) > 0.0_wp .and. waits(phases(number))) &
        call observer%note("warning: phase '"//phases(number)%name//"' is a waiting phase, and hardly any water "// &
        'drains: do its TIME and *PERMEABILITY have the same unit of time?')
    end associate
  end subroutine report_excess

  !> Returns the displacement of soil that started with K0 stresses: a length, and its ratio to the settlement under its
  !> own weight.
  pure function start_text(progress, phase, unit) result(text)
    type(progress_type), intent(in) :: progress
    !> Name of the phase, and of the unit of length, '-' where the deck has none.
    character(len=*), intent(in) :: phase, unit
    character(len=:), allocatable :: text, length, share
    character(len=8) :: figure

    associate (move => start_move(progress))
      write (figure, '(es8.1)') 2.0_wp*move*progress%own_settlement
      length = trim(adjustl(figure))
      if (unit /= '-') length = length//' '//unit
      write (figure, '(es8.1)') 2.0_wp*move
      share = trim(adjustl(figure))//' of the settlement that its own weight would cause'
      if (.not. move > still) then
        text = "phase '"//phase//"': the ground has moved by "//length//' at the most, '//share
      else
        text = "warning: phase '"//phase//"': K0 stresses that are not quite in equilibrium have moved the ground "// &
          'by '//length//', '//share//'; *RESET DISPLACEMENTS in the next phase removes it from the displacements'
      end if
    end associate
  end function start_text

  !> Warns once in a phase of material that does not follow a prescribed set.
  subroutine warn_of_lag(warning, report, observer)
    !> Empty or unallocated for none.
    character(len=:), allocatable, intent(in) :: warning
    type(phase_report_type), intent(inout) :: report
    class(observer_type), intent(inout) :: observer

    if (.not. allocated(warning) .or. report%lag_warned) return
    if (len(warning) == 0) return
    call observer%note(warning)
    report%lag_warned = .true.
  end subroutine warn_of_lag

  !> Notes once, where an increment is cut back because of non-convergence, that the tangent of a user-defined material
  !> may be the cause.
  subroutine advise_on_tangent(model, cause, report, observer)
    type(model_type), intent(in) :: model
    !> Cause of the cut-back, one of the error codes.
    integer, intent(in) :: cause
    type(phase_report_type), intent(inout) :: report
    class(observer_type), intent(inout) :: observer
    integer :: m

    if (report%tangent_told .or. cause /= error_not_converged) return
    do m = 1, size(model%analysis%materials)
      associate (material => model%analysis%materials(m), user => model%analysis%materials(m)%user)
        if (.not. user%given .or. user%tangent == model_tangent_numerical) cycle
        ! AUTO differentiates numerically a UDSM without tangent.
        if (user%interface /= interface_umat .and. user%tangent == model_tangent_auto) cycle
        call observer%note("material '"//material%name//"': if its tangent is not the derivative of its stress, "// &
          'increments are cut back for that reason alone; TANGENT=NUMERICAL of *USER MATERIAL differentiates '// &
          'the stress, '// &
          "'qsmpm point --tangent' compares the two")
        report%tangent_told = .true.
      end associate
    end do
  end subroutine advise_on_tangent

  !> Warns of initial stresses that exceed the strength of the soil.
  subroutine warn_of_initial_strength(model, observer)
    type(model_type), intent(in) :: model
    class(observer_type), intent(inout) :: observer
    integer(long) :: beyond(size(model%laws)), points
    character(len=:), allocatable :: names
    integer :: m

    associate (team => model%part%team, count_of => model%state%points%count)
      beyond = int(count_beyond_strength(model), long)
      names = ''
      do m = 1, size(beyond)
        beyond(m) = total(team, beyond(m))
        if (beyond(m) > 0) names = names//", '"//model%analysis%materials(m)%name//"'"
        call warn_of_low_pressure(model, m, observer)
      end do
      points = total(team, count(own_of(model%part%points, count_of), kind=long))
    end associate
    if (any(beyond > 0)) call observer%note('warning: the initial stress of '//integer_text(sum(beyond))//' of '// &
      integer_text(points)//' material points exceeds their strength (material '//names(3:)// &
      '); the first step returns it to the yield surface, and displacements follow: change k0 of *K0 or *INITIAL')
  end subroutine warn_of_initial_strength

  !> Warns of a material whose law begins with a constant stiffness at most of its points: in most cases its SMALLEST
  !> PRESSURE is given in another unit.
  subroutine warn_of_low_pressure(model, number, observer)
    type(model_type), intent(in) :: model
    !> Number of the material.
    integer, intent(in) :: number
    class(observer_type), intent(inout) :: observer
    type(law_description_type) :: traits
    integer(long) :: points(2)

    traits = traits_of(model%analysis%materials(number))
    if (.not. traits%smallest_pressure > 0.0_wp) return
    associate (of => model%state%points, count_of => model%state%points%count)
      associate (own => own_of(model%part%points, count_of) .and. of%material(:count_of) == number)
        points = [count(own .and. -sum(of%stress(:3, :count_of), dim=1) < 3.0_wp*traits%smallest_pressure, kind=long), &
          count(own, kind=long)]
      end associate
    end associate
    points = [total(model%part%team, points(1)), total(model%part%team, points(2))]
    if (2*points(1) > points(2)) call observer%note('warning: '//integer_text(points(1))//' of '// &
      integer_text(points(2))//" points of material '"//model%analysis%materials(number)%name//"' begin below the "// &
      'SMALLEST PRESSURE of *'//traits%keyword//', '//rounded_text(traits%smallest_pressure)// &
      ': its stiffness is constant there. The default is meant for kPa: give it in the units of the deck')
  end subroutine warn_of_low_pressure

  !> Returns the reason why a phase ends before its full load: parts without support if there are any, otherwise the
  !> residual of the last solve.
  function failure_text(model, step, phase, outcome) result(message)
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    type(phase_type), intent(in) :: phase
    type(outcome_type), intent(in) :: outcome
    character(len=:), allocatable :: message
    character(len=200) :: text
    character(len=:), allocatable :: unsupported

    write (text, '(a,es13.6,a)') "': no equilibrium beyond load factor ", model%state%progress%load_factor, ': '
    message = "phase '"//phase%name//trim(text)//' '//outcome%reason
    unsupported = ''
    call find_unsupported_parts(model, step, unsupported)
    if (len(unsupported) > 0) then
      message = message//'; '//unsupported
    else if (outcome%out_of_balance < huge(1.0_wp) .and. outcome%worst_label > 0) then
      ! Without a stress there is no residual, and none is reported where equilibrium was found.
      write (text, '(a,es9.2,a,i0,a,3(1x,es11.4))') '; out of balance ', outcome%out_of_balance, ', most at node ', &
        outcome%worst_label, ' at', outcome%worst_place(:model%mesh%dimension)
      message = message//trim(text)
    end if
    if (outcome%cause == error_singular) message = message//apart_text(model)
    if (outcome%cause == error_tangled .and. size(phase%prescriptions) > 0) message = message//'; prescribed '// &
      'displacements distort a mesh that moves with the material: take a *RIGID BODY in their place, ELEMENT=QUAD4 '// &
      'of *GRID, or a smaller displacement'
    if (outcome%cause == error_not_converged .and. is_body_loaded(phase)) message = message//'; the load that is '// &
      'carried depends on the grid: a run with smaller cells shows its error'
    if (outcome%cause == error_singular .and. is_body_loaded(phase) .and. model%state%progress%load_factor > 0.0_wp) &
      message = message//'; the loaded rigid body slides with friction fully mobilised, or the soil yields '// &
      'throughout: the load that is carried is the limit load'
    if (phase%controls%limit_compliance > 0.0_wp) then
      write (text, '(a,f0.1,a)') '; the last step was ', relative_compliance(model%state%progress%limit), &
        ' times as compliant as the first one'
      message = message//trim(text)
    end if
  end function failure_text

  !> Returns the outcome of a phase that ends between a load that is supported and a rejected one close to it.
  pure type(outcome_type) function overloaded(model, phase, reason) result(outcome)
    type(model_type), intent(in) :: model
    type(phase_type), intent(in) :: phase
    !> Reason of the rejection; not known after a restart.
    character(len=*), intent(in), optional :: reason

    outcome%reason = 'no equilibrium at load factor '//factor_text(phase%load_factor* &
      model%state%progress%limit%refused)//', just above it'
    if (present(reason)) outcome%reason = outcome%reason//': '//reason
  end function overloaded

  !> Returns a text on the load up to which the body-fitted mesh was in equilibrium, and its compliance there.
  pure function beyond_text(phase, progress) result(text)
    type(phase_type), intent(in) :: phase
    type(progress_type), intent(in) :: progress
    character(len=:), allocatable :: text

    text = ''
    if (phase%kind == phase_safety) return
    text = ' beyond load factor '//rounded_text(progress%load_factor, 6)
    if (.not. relative_compliance(progress%limit) > 1.0_wp) return
    text = text//', the largest that they carry; there the same load moved the ground '// &
      rounded_text(relative_compliance(progress%limit), 2)//' times as far as in the first step'
  end function beyond_text

  !> Returns whether all parts of the body are supported: on a grid a gap narrower than the support of its functions
  !> would transmit forces without notice.
  logical function all_is_held(model, step) result(held)
    type(model_type), intent(in) :: model
    !> Scratch data of the failed step.
    type(step_type), intent(in) :: step
    character(len=:), allocatable :: unsupported

    call find_unsupported_parts(model, step, unsupported)
    held = len(unsupported) == 0
  end function all_is_held

  !> Reports which parts are unsupported. Each process of a team checks its part in its present state.
  subroutine find_unsupported_parts(model, step, text)
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    character(len=:), allocatable, intent(out) :: text
    class(model_type), allocatable :: present
    type(step_type) :: start
    type(connectivity_type) :: connectivity
    type(error_type), allocatable :: error

    text = ''
    if (.not. is_divided(model%part)) then
      call describe_unsupported_parts(model, step, text)
      return
    end if
    allocate (present, source=model)
    call ready_terms(present, start, connectivity, error)
    if (.not. any_of(model%part%team, allocated(error))) call describe_unsupported_parts(present, start, text)
  end subroutine find_unsupported_parts

  !> Returns a share in percent.
  pure function percent_text(share) result(text)
    real(wp), intent(in) :: share
    character(len=:), allocatable :: text
    character(len=12) :: buffer

    write (buffer, '(f8.1)') min(100.0_wp*share, 99999.0_wp)
    text = trim(adjustl(buffer))//' %'
  end function percent_text

  !> Returns a load factor as text.
  pure function factor_text(load_factor) result(text)
    real(wp), intent(in) :: load_factor
    character(len=:), allocatable :: text
    character(len=16) :: buffer

    write (buffer, '(es11.4)') load_factor
    text = trim(adjustl(buffer))
  end function factor_text
end module qsmpm_phase_report
