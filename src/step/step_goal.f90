!> What a step is to reach: the loads in force at its start and its end, the displacements that are prescribed (paper,
!> eqs. 18 and 19), what eq. 27 refers to at the least.
!>
!> Where the iterations of a step begin: its share of the phase, or what the factor of a search for the safety grows by
!> in it, times the rate of the unknowns in the static step before, which near a limit load is nearly all of the answer;
!> of a damped sub-step, the changes of the one before (docs/methods/steps.md).
!>
!> Both are kept as fields are, node by node, so that a restart file has them and new nodes begin with zero. The first
!> step of a phase begins with nothing, and so does one behind damped sub-steps or an attempt that has failed, but one
!> at another factor; what is prescribed is in force from the start. With laws from elsewhere the second one does too: a
!> law that changes the stress where nothing is strained is found where nothing is strained yet.
module qsmpm_step_goal
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: agree, joint_norm, any_of
  use qsmpm_configuration, only: configuration_type
  use qsmpm_equilibrium, only: target_type
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_finite, only: is_usable, all_usable, unusable
  use qsmpm_law, only: step_info_type
  use qsmpm_model, only: model_type
  use qsmpm_nodal_fields, only: add_shares, find_prescribed, rate_of, substep_of
  use qsmpm_own_part, only: own_of
  use qsmpm_phase_tree, only: phase_start_time
  use qsmpm_space, only: node_label
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_term, only: increment_type, term_slot_type, role_external
  use qsmpm_term_sums, only: begin_terms, set_loads, sum_forces
  use qsmpm_text, only: integer_text
  use qsmpm_unknowns, only: unknowns_type, most_components, all_nodes, own_node, put_values, values_of
  use qsmpm_initialisation, only: step_type
  use qsmpm_kept_arrays, only: kept_arrays_type, is_kept, keep_values, kept_values
  use qsmpm_owner_copies, only: copy_values
  use qsmpm_safety_factors, only: is_searching
  implicit none
  private

  public :: set_goal, extrapolate, keep_rates, length_of

  !> Share of the force of an all-round pressure on the face of a cell that is a load at the least.
  real(wp), parameter :: little = 1.0e-4_wp

contains

  !> Loads in force, prescribed displacements to be reached, the loads of the start, and the time for the laws.
  subroutine set_goal(model, configuration, attempt, unknowns, terms, force_before, goal, error)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    type(attempt_type), intent(in) :: attempt
    type(unknowns_type), intent(in) :: unknowns
    type(term_slot_type), intent(inout) :: terms(:)
    !> External force at the start (dimension, node_count).
    real(wp), allocatable, intent(out) :: force_before(:, :)
    type(target_type), intent(inout) :: goal
    !> A load or a prescribed displacement is not a number.
    type(error_type), allocatable, intent(out) :: error
    real(wp), dimension(most_components(unknowns), all_nodes(unknowns)) :: load, start_of_step

    associate (progress => model%state%progress)
      call begin_terms(terms, increment_type(step_info_type(phase=progress%phase, step=progress%step + 1, &
        step_of_phase=progress%phase_steps + 1, start=progress%fraction, &
        duration=attempt%fraction - progress%fraction, &
        phase_start=phase_start_time(model%analysis%phases, progress%phase), &
        phase_time=model%analysis%phases(progress%phase)%duration, in_place=attempt%in_place), attempt%damping, &
        attempt%stabilisation))
      allocate (force_before, mold=load)
      call put_in_force(model, configuration, progress%fraction, unknowns, terms, force_before)
      start_of_step = force_before
      if (attempt%start < progress%fraction) &
        call put_in_force(model, configuration, attempt%start, unknowns, terms, start_of_step)
      call put_in_force(model, configuration, attempt%fraction, unknowns, terms, load)
      goal%increment = load - start_of_step
      goal%phase_share = attempt%fraction - min(attempt%start, progress%fraction)
    end associate
    call find_prescribed(model, terms, unknowns, attempt%fraction, goal%prescribed)
    goal%tolerance = attempt%tolerance
    ! Soil that bears an all-round pressure and nothing else has no force but for rounding.
    goal%least_load = joint_norm(model%part%team, norm2(pack(model%state%released, &
      spread(own_of(model%part%nodes, model%space%node_count), 1, model%mesh%dimension)))) &
      + joint_norm(model%part%team, norm2(pack(model%state%surface%released, spread(own_of(model%part%surface, &
      model%state%surface%count), 1, model%mesh%dimension)))) &
      + little*model%analysis%confinement*model%cell_size**(model%mesh%dimension - 1)
    goal%least_moved = model%state%progress%force_at_start
    call check_nodes(model, unknowns, 'load', load, error)
    if (.not. allocated(error)) call check_nodes(model, unknowns, 'prescribed displacement', &
      goal%prescribed, error)
    call agree(model%part%team, error)
  end subroutine set_goal

  !> Put the loads of a fraction of the phase in force; what they are on the body as it stands.
  subroutine put_in_force(model, configuration, fraction, unknowns, terms, load)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: fraction
    type(unknowns_type), intent(in) :: unknowns
    type(term_slot_type), intent(inout) :: terms(:)
    !> (dimension, node_count)
    real(wp), intent(out) :: load(:, :)
    real(wp) :: still(size(load, 1), size(load, 2))

    still = 0.0_wp
    call set_loads(terms, model, configuration, fraction)
    call sum_forces(terms, role_external, still, load)
    call add_shares(model%part%team, unknowns, load)
  end subroutine put_in_force

  !> Loads and prescribed displacements are numbers: no smaller step makes them so.
  subroutine check_nodes(model, unknowns, name, values, error)
    type(model_type), intent(in) :: model
    type(unknowns_type), intent(in) :: unknowns
    character(len=*), intent(in) :: name
    !> Values at the nodes (dimension, node_count).
    real(wp), intent(in) :: values(:, :)
    !> error_other: names the node.
    type(error_type), allocatable, intent(out) :: error
    integer :: node

    if (all_usable(size(values), values)) return
    node = own_node(unknowns, findloc(all(is_usable(values), dim=1), .false., dim=1))
    call fail(error, error_other, 'phase '//integer_text(model%state%progress%phase)//', step '// &
      integer_text(model%state%progress%step + 1)//': the '//name//' at node '// &
      integer_text(node_label(model%space, model%mesh, node))//' has a value'//unusable)
  end subroutine check_nodes

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
end module qsmpm_step_goal
