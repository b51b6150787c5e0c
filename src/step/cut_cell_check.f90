!> Integration error in bodies that the grid cuts, reported as notes and warnings: where material points are the
!> integration points, and where cells are integrated but the material can yield, so that the outline is not followed.
!>
!> The points of a cut cell lose the moments of the material in it as the body moves. The loss can be measured without a
!> known solution by the divergence theorem, which requires for every function
!>
!>   d_a  =  sum over integration points of V grad N_a  -  integral of N_a n over the outline  =  0
!>
!> With the mean stress around the node, sigma_a, the product sigma_a d_a is the force out of balance in a state that is
!> in equilibrium. It is reported as a ratio: its norm over all nodes over that of the tractions on the outline, sigma_a
!> times the integral. At a surface without load its weight is as small as the stress there. In axisymmetry the radial
!> stress is used in place of the hoop stress. Figures: docs/methods/bodies.md.
module qsmpm_cut_cell_check
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: any_of, joint_norm, lowest_rank
  use qsmpm_method_description, only: integrate_cells
  use qsmpm_configuration, only: configuration_type
  use qsmpm_own_part, only: is_divided, own_of
  use qsmpm_team, only: largest, smallest, spread_from
  use qsmpm_rounded_text, only: rounded_text, rounded_place
  use qsmpm_model, only: model_type
  use qsmpm_point_location, only: activation_type
  use qsmpm_integration, only: integration_type, place_of
  use qsmpm_space, only: shape_values_type, functions_at, add_at, node_position
  use qsmpm_body_quadrature, only: body_quadrature_type
  use qsmpm_outlines, only: find_bodies, flows
  use qsmpm_outline_surfaces, only: seed_outlines
  use qsmpm_seed_list, only: seed_list_type
  use qsmpm_points, only: points_type
  use qsmpm_observer, only: observer_type
  implicit none
  private

  public :: cut_cell_check_type, measure_cut_cells, warn_of_cut_cells, end_cut_cell_check
  public :: level_of, level_none, level_note, level_warning

  !> Ratios above which a note is printed, and a warning where only smaller cells reduce the error: at 0.4 % the root
  !> mean square of the errors of all stresses of the turned block is 0.6 %, at 3.1 % it is 1.4 %.
  real(wp), parameter :: told_from = 0.004_wp, warned_from = 0.02_wp

  !> Level at which a ratio is reported.
  integer, parameter :: level_none = 0, level_note = 1, level_warning = 2

  !> Results and reports so far; persists between steps.
  type :: cut_cell_check_type
    !> Ratio in this step, and place of the largest contribution (dimension).
    real(wp) :: share = 0.0_wp
    real(wp), allocatable :: place(:)
    !> Number of accepted steps at the time of the measurement.
    integer :: measured_after = -1
    !> Bodies whose outlines did not enclose their points at that time (bodies).
    logical, allocatable :: lost(:)
    !> Largest ratio of the phase and the level of its report; bodies whose invalid outline has been reported (bodies).
    real(wp) :: worst = 0.0_wp
    integer :: level = level_none
    logical, allocatable :: lost_reported(:)
  end type cut_cell_check_type

contains

  !> Measures the ratio for bodies that are not integrated inside their outlines, in the configuration at the start of a
  !> step; once per step, not for every attempt.
  subroutine measure_cut_cells(model, configuration, integration, check)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    !> Integration points of the equations.
    type(integration_type), intent(in) :: integration
    type(cut_cell_check_type), intent(inout) :: check
    real(wp), dimension(model%mesh%dimension, model%space%node_count) :: outside, inside
    real(wp) :: stress(size(model%state%points%stress, 1), model%space%node_count)
    type(body_quadrature_type) :: bodies
    logical :: own(model%mesh%dimension, model%space%node_count)
    integer :: node, a

    if (all(model%outlines%integrates) .or. check%measured_after == model%state%progress%step) return
    check%measured_after = model%state%progress%step
    call find_bodies(model, configuration%volumes, .false., bodies)
    check%lost = .not. bodies%carried
    call integrate_outlines(model, bodies, outside)
    call integrate_gradients(model, configuration%activation, bodies, integration, inside)
    call find_mean_stress(model%state%points, configuration%at_points, stress)
    inside = inside - outside
    do a = 1, size(outside, 2)
      inside(:, a) = traction(stress(:, a), inside(:, a))
      outside(:, a) = traction(stress(:, a), outside(:, a))
    end do
    if (is_divided(model%part)) then
      own = spread(own_of(model%part%nodes, size(inside, 2)), 1, size(inside, 1))
      inside = merge(inside, 0.0_wp, own)
      outside = merge(outside, 0.0_wp, own)
    end if
    associate (team => model%part%team, violation => norm2(inside, dim=1))
      check%share = joint_norm(team, norm2(inside))/max(joint_norm(team, norm2(outside)), tiny(1.0_wp))
      node = maxloc(violation, dim=1)
      check%place = node_position(model%space, model%mesh, node)
      call spread_from(team, lowest_rank(team, violation(node) >= largest(team, violation(node))), check%place)
    end associate
  end subroutine measure_cut_cells

  !> Computes the mean stress of the material points around each node, weighted by |N| V (4 or 6, nodes).
  pure subroutine find_mean_stress(points, at_points, stress)
    type(points_type), intent(in) :: points
    !> Basis at the material points.
    type(integration_type), intent(in) :: at_points
    real(wp), intent(out) :: stress(:, :)
    real(wp) :: volume(size(stress, 2)), share
    integer :: g, q, a, first, place

    stress = 0.0_wp
    volume = 0.0_wp
    do g = 1, at_points%group_count
      first = at_points%node_first(g) - 1
      do q = at_points%first(g), at_points%first(g + 1) - 1
        place = place_of(at_points, g, q)
        do a = 1, at_points%node_first(g + 1) - 1 - first
          share = abs(at_points%shape(place + a))*at_points%weight(q)
          associate (node => at_points%nodes(first + a))
            volume(node) = volume(node) + share
            stress(:, node) = stress(:, node) + share*points%stress(:, at_points%source(q))
          end associate
        end do
      end do
    end do
    stress = stress/spread(max(volume, tiny(1.0_wp)), 1, size(stress, 1))
  end subroutine find_mean_stress

  !> Returns the product of a stress and a vector.
  pure function traction(stress, vector)
    !> 11, 22, 33, 12, 13, 23 (4 or 6).
    real(wp), intent(in) :: stress(:)
    !> (2 or 3)
    real(wp), intent(in) :: vector(:)
    real(wp) :: traction(size(vector))

    traction(1) = stress(1)*vector(1) + stress(4)*vector(2)
    traction(2) = stress(4)*vector(1) + stress(2)*vector(2)
    if (size(vector) < 3) return
    traction(1) = traction(1) + stress(5)*vector(3)
    traction(2) = traction(2) + stress(6)*vector(3)
    traction(3) = stress(5)*vector(1) + stress(6)*vector(2) + stress(3)*vector(3)
  end function traction

  !> Computes the integrals of N n over the outlines (dimension, nodes). Where an outline extends by less than a point
  !> into a cell without points, its part counts for the nodes that this cell shares with the body; other cells without
  !> points have no stress.
  subroutine integrate_outlines(model, bodies, sums)
    type(model_type), intent(in) :: model
    type(body_quadrature_type), intent(in) :: bodies
    real(wp), intent(out) :: sums(:, :)
    type(seed_list_type) :: list
    type(shape_values_type) :: place
    integer :: i

    sums = 0.0_wp
    call seed_outlines(model, bodies, list)
    do i = 1, list%count
      call functions_at(model%space, model%mesh, list%cell(i), list%local(:, i), place)
      call add_at(place, list%vector(:, i), sums)
    end do
  end subroutine integrate_outlines

  !> Computes the sums of V grad N over the bodies, in axisymmetry with N/r added to the first component (dimension,
  !> nodes).
  subroutine integrate_gradients(model, activation, bodies, integration, sums)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    type(body_quadrature_type), intent(in) :: bodies
    type(integration_type), intent(in) :: integration
    real(wp), intent(out) :: sums(:, :)
    integer :: g, q, n, b, j

    sums = 0.0_wp
    do g = 1, integration%group_count
      n = integration%node_first(g + 1) - integration%node_first(g)
      associate (nodes => integration%nodes(integration%node_first(g):integration%node_first(g + 1) - 1))
        do q = integration%first(g), integration%first(g + 1) - 1
          ! Points of bodies that are integrated inside their outlines are skipped.
          if (integration%source(q) < 0 .and. integration%source(q) >= -integration%received) cycle
          if (.not. bodies%carried(body_of(model, activation, integration, g, q))) cycle
          b = integration%directions*place_of(integration, g, q)
          do j = 1, integration%directions
            associate (row => merge(j, 1, j <= size(sums, 1)), gradient => integration%gradient(b + 1:b + n))
              sums(row, nodes) = sums(row, nodes) + integration%weight(q)*gradient
            end associate
            b = b + n
          end do
        end do
      end associate
    end do
  end subroutine integrate_gradients

  !> Returns the body of an integration point; for a Gauss point of a full cell, the body of the points of the cell.
  pure integer function body_of(model, activation, integration, group, point) result(body)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    type(integration_type), intent(in) :: integration
    integer, intent(in) :: group, point
    integer :: source

    source = integration%source(point)
    if (source < 0) source = activation%point(activation%first(activation%active_number(integration%cell(group))))
    body = model%state%points%body(source)
  end function body_of

  !> Reports a large ratio when it first occurs in a phase, and outlines that are no longer valid.
  subroutine warn_of_cut_cells(model, configuration, check, observer)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    type(cut_cell_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer
    logical :: curable

    if (size(model%outlines) == 0) return
    if (allocated(configuration%bodies)) call warn_of_lost(model, .not. configuration%bodies%carried, .true., &
      'Cells cut by it are integrated at the material points from here on, and stresses there may be '// &
      'inaccurate', check, &
      observer)
    if (.not. allocated(check%lost)) return
    call warn_of_lost(model, check%lost, .false., 'The error of stresses beside it is no longer measured', &
      check, observer)
    check%worst = max(check%worst, check%share)
    curable = .false.
    if (check%share > told_from) curable = is_curable(model, check%place)
    if (level_of(check%share, curable) <= check%level) return
    check%level = level_of(check%share, curable)
    call observer%note(prefix(check%level)//violation_text(check%share)//', most at '//rounded_place(check%place)// &
      ': stresses in these cells are in error by several times as much, those inside are not; '//trim(merge( &
      'use INTEGRATION=CELL, which follows the outline of elastic bodies', &
      'cells of half the size halve the error                           ', curable)))
  end subroutine warn_of_cut_cells

  !> Returns whether INTEGRATION=CELL would follow the outline at the place of the largest error, that is whether it
  !> belongs to a body that cannot yield.
  logical function is_curable(model, place)
    type(model_type), intent(in) :: model
    !> (dimension)
    real(wp), intent(in) :: place(:)
    real(wp) :: distance, least
    integer :: p, body

    is_curable = .false.
    if (model%analysis%method%integration == integrate_cells) return
    least = huge(least)
    body = 0
    do p = 1, model%state%points%count
      if (.not. any(model%outlines%body == model%state%points%body(p))) cycle
      distance = norm2(model%state%points%position(:, p) - place)
      if (.not. distance < least) cycle
      least = distance
      body = model%state%points%body(p)
    end do
    associate (team => model%part%team)
      call spread_from(team, min(team%ranks - 1, lowest_rank(team, least <= smallest(team, least))), body)
    end associate
    if (body > 0) is_curable = .not. any_of(model%part%team, flows(model, body))
  end function is_curable

  !> Returns the level at which a ratio is reported.
  pure integer function level_of(share, curable) result(level)
    real(wp), intent(in) :: share
    !> Another choice of the method would avoid the error.
    logical, intent(in) :: curable

    level = level_none
    if (share > told_from) level = level_note
    if (share > warned_from .or. (share > told_from .and. curable)) level = level_warning
  end function level_of

  !> Returns the prefix of a message of a level.
  pure function prefix(level) result(text)
    integer, intent(in) :: level
    character(len=:), allocatable :: text

    text = ''
    if (level == level_warning) text = 'warning: '
  end function prefix

  !> Warns, once for each body, of outlines that no longer enclose their points.
  subroutine warn_of_lost(model, lost, integrates, consequence, check, observer)
    type(model_type), intent(in) :: model
    !> Bodies whose outlines no longer enclose them (bodies); only those integrated inside their outlines, or only the
    !> others.
    logical, intent(in) :: lost(:)
    logical, intent(in) :: integrates
    character(len=*), intent(in) :: consequence
    type(cut_cell_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer
    integer :: k

    if (.not. allocated(check%lost_reported)) allocate (check%lost_reported(size(lost)), source=.false.)
    do k = 1, size(model%outlines)
      associate (b => model%outlines(k)%body)
        if (.not. lost(b) .or. check%lost_reported(b) .or. (model%outlines(k)%integrates .neqv. integrates)) cycle
        if (.not. any_of(model%part%team, any(model%state%points%body == b))) cycle
        check%lost_reported(b) = .true.
        call observer%note("warning: the outline of body '"//model%analysis%bodies(b)%name//"' has folded: its "// &
          'volume is no longer that of the material points. '//consequence)
      end associate
    end do
  end subroutine warn_of_lost

  !> Reports the largest ratio of a phase, if one was reported before.
  subroutine end_cut_cell_check(phase, check, observer)
    character(len=*), intent(in) :: phase
    type(cut_cell_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer

    if (check%level > level_none) call observer%note(prefix(check%level)//"phase '"//phase//"': "// &
      violation_text(check%worst)//' at the most')
    check%level = level_none
    check%worst = 0.0_wp
  end subroutine end_cut_cell_check

  !> Returns the text that reports a ratio.
  function violation_text(share) result(text)
    real(wp), intent(in) :: share
    character(len=:), allocatable :: text

    text = 'the integration error of cells cut by a body is '//rounded_text(100.0_wp*share, 3)// &
      ' % along its outline'
  end function violation_text
end module qsmpm_cut_cell_check
