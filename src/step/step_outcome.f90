!> What a solve has come to: whether the step may be as long as it is, what its load does, reactions and work, where the
!> residual and the share of the stabilisation are largest.
module qsmpm_step_outcome
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: lowest_rank
  use qsmpm_phase_description, only: controls_type
  use qsmpm_equations, only: gather
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_error, only: error_type, error_not_converged, fail
  use qsmpm_finite, only: is_usable, unusable
  use qsmpm_initialisation, only: step_type
  use qsmpm_limit_load, only: compliance_type
  use qsmpm_model, only: model_type, progress_type
  use qsmpm_space, only: node_label, node_position
  use qsmpm_step_control, only: has_length_error, is_too_long
  use qsmpm_step_error, only: step_error_type, measure_step_error
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_stopwatch, only: switch_timer, part_control, part_step_error
  use qsmpm_team, only: largest, total, spread_from
  use qsmpm_consolidation, only: excess_field
  use qsmpm_kept_arrays, only: is_kept, kept_values
  use qsmpm_nodal_fields, only: rate_of
  use qsmpm_pore_flow, only: course_name
  use qsmpm_unknowns, only: find_field, values_of
  implicit none
  private

  public :: judge_length, compliance_in, take_reactions_and_work, name_worst_node, place_share

contains

  !> Whether the step may be as long as it is: no node moves too far, and the error of its length is allowed.
  subroutine judge_length(model, step, controls, attempt, solution, error)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    type(controls_type), intent(in) :: controls
    type(attempt_type), intent(in) :: attempt
    type(solution_type), intent(inout) :: solution
    !> The equations could not be solved.
    type(error_type), allocatable, intent(out) :: error

    if (controls%by_water) solution%water_error = water_error(model, step, attempt, solution%displacement)
    if (solution%largest_move > attempt%largest_move) then
      solution%converged = .false.
      solution%reason = 'the step moves a node too far'
    else if (has_length_error(controls, attempt) .or. (has_user_law(model) .and. &
      .not. (attempt%damping > 0.0_wp .or. attempt%in_place))) then
      call measure_length_error(model, step, .not. has_length_error(controls, attempt), solution, error)
      if (allocated(error) .or. .not. has_length_error(controls, attempt)) return
      solution%too_long = is_too_long(controls, attempt%fraction - model%state%progress%fraction, solution%step_error)
      if (.not. solution%too_long) return
      solution%converged = .false.
      solution%reason = 'the step is longer than its error allows'
    end if
  end subroutine judge_length

  !> What the length of a step costs where pore water flows in time: how far its excess pressures are from a straight
  !> line with those of the step before,
  !>
  !>   e = max |dp - r dp'| / p_max,      r the length of the step over that of the one before, dp' the change in it,
  !>
  !> p_max the largest pressure of the phase so far: 0 while a load is put on and no water leaves, and in the first step
  !> of a phase. Backward differences of second order (qsmpm_flow_balance) are off by less than that.
  function water_error(model, step, attempt, displacement) result(error)
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    type(attempt_type), intent(in) :: attempt
    !> Changes of all unknowns (components, columns).
    real(wp), intent(in) :: displacement(:, :)
    real(wp) :: error
    real(wp), allocatable :: course(:, :), change(:), before(:)

    error = 0.0_wp
    if (model%state%progress%phase_steps == 0 .or. .not. is_kept(model%state%kept, rate_of//excess_field)) return
    course = kept_values(model%state%kept, course_name)
    before = pack(kept_values(model%state%kept, rate_of//excess_field), .true.)
    change = pack(values_of(step%unknowns, find_field(step%unknowns, excess_field), displacement), .true.)
    before = before*(attempt%fraction - model%state%progress%fraction)
    error = maxval(abs(change - before))/max(course(2, 1), tiny(1.0_wp))
  end function water_error

  !> Whether there is a law of a user: how it integrates its rates is not known, so its steps are measured unasked, but
  !> for those at places that stay, which are no path.
  pure logical function has_user_law(model)
    type(model_type), intent(in) :: model
    integer :: m

    has_user_law = any([(model%laws(m)%law%of_user, m=1, size(model%laws))])
  end function has_user_law

  !> How far the step is off for its length.
  subroutine measure_length_error(model, step, path_only, solution, error)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    !> Leaves the error of the position out; an error that cannot be measured is all of the stress.
    logical, intent(in) :: path_only
    type(solution_type), intent(inout) :: solution
    !> The equations could not be solved.
    type(error_type), allocatable, intent(out) :: error
    type(step_error_type) :: errors

    call switch_timer(step%profile%watch, part_step_error)
    call measure_step_error(model, step, solution%displacement, path_only, errors, error)
    call switch_timer(step%profile%watch, part_control)
    if (.not. allocated(error)) solution%step_error = max(errors%path, errors%position)
    if (path_only) solution%step_error = min(1.0_wp, solution%step_error)
  end subroutine measure_length_error

  !> What a load increment does by a displacement, at the free components: loads at nodes and on rigid bodies.
  type(compliance_type) function compliance_in(step, increment, displacement)
    type(step_type), intent(in) :: step
    !> (components, nodes)
    real(wp), intent(in) :: increment(:, :), displacement(:, :)
    real(wp) :: load(step%equations%count), move(step%equations%count)

    load = 0.0_wp
    move = 0.0_wp
    call gather(step%equations, increment, load)
    call gather(step%equations, displacement, move)
    where (step%field_of == 0) load = 0.0_wp
    compliance_in = compliance_type(total(step%team, dot_product(load, move)), &
      total(step%team, dot_product(load, load)))
  end function compliance_in

  !> Reactions at the constrained components, and the work of the step by the trapezoidal rule.
  subroutine take_reactions_and_work(step, constrained, force_before, solution, reactions, progress, error)
    type(step_type), intent(in) :: step
    !> Constrained components (dimension, node_count).
    logical, intent(in) :: constrained(:, :)
    !> (components, nodes)
    real(wp), intent(in) :: force_before(:, :)
    type(solution_type), intent(in) :: solution
    !> Before, and after (dimension, node_count).
    real(wp), intent(inout) :: reactions(:, :)
    type(progress_type), intent(inout) :: progress
    !> A reaction or the work is not a number.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: new_reactions(size(reactions, 1), size(reactions, 2))
    logical :: own(size(reactions, 1), size(reactions, 2))

    associate (d => size(reactions, 1), n => size(reactions, 2))
      associate (move => solution%displacement(:d, :n), before => force_before(:d, :n), &
          external => solution%external_force(:d, :n), internal => solution%internal_force(:d, :n))
        new_reactions = 0.0_wp
        own = spread(step%own(:n), 1, d)
        where (constrained .and. spread(step%equations%active(:n), 1, d)) new_reactions = internal - external
        progress%external_work = progress%external_work &
          + total(step%team, sum(0.5_wp*(before + external)*move, mask=own)) &
          + total(step%team, sum(0.5_wp*(reactions + new_reactions)*move, mask=own))
        progress%internal_work = progress%internal_work &
          + total(step%team, sum(0.5_wp*(before + reactions + internal)*move, mask=own))
      end associate
    end associate
    if (.not. (is_usable(progress%external_work) .and. is_usable(progress%internal_work))) &
      call fail(error, error_not_converged, 'the work of the step has a value'//unusable)
    reactions = new_reactions
  end subroutine take_reactions_and_work

  !> Label and place of the node with the largest residual of all processes: its number does not outlive a change of
  !> the window.
  subroutine name_worst_node(model, solution)
    type(model_type), intent(in) :: model
    !> What was reached.
    type(solution_type), intent(inout) :: solution
    real(wp) :: worst
    integer(long) :: label(1)
    integer :: node, rank

    node = max(1, solution%worst_node)
    solution%worst_label = node_label(model%space, model%mesh, node)
    solution%worst_place(:model%mesh%dimension) = node_position(model%space, model%mesh, node)
    worst = largest(model%part%team, solution%worst_size)
    rank = lowest_rank(model%part%team, solution%worst_size >= worst)
    if (rank == model%part%team%ranks) return
    label = solution%worst_label
    call spread_from(model%part%team, rank, label)
    call spread_from(model%part%team, rank, solution%worst_place)
    solution%worst_label = int(label(1))
  end subroutine name_worst_node

  !> Where the stabilisation carries the largest share of the forces.
  subroutine place_share(model, solution)
    type(model_type), intent(in) :: model
    type(solution_type), intent(inout) :: solution
    integer :: node, rank

    node = 0
    if (allocated(solution%shares)) node = maxval([0, solution%shares%node])
    rank = lowest_rank(model%part%team, node > 0)
    if (rank == model%part%team%ranks) return
    if (node > 0) solution%share_place(:model%mesh%dimension) = node_position(model%space, model%mesh, node)
    call spread_from(model%part%team, rank, solution%share_place)
  end subroutine place_share
end module qsmpm_step_outcome
