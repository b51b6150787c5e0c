!> Sides of the mesh that material cannot cross: planes of symmetry, the axis of axisymmetry, smooth walls.
!>
!> Where the displacement normal to a side is constrained, the side does not move and no material passes it. Functions
!> that are averages over the domain of a point (GIMP, SPLINE2G) do not vanish at a point on the side, whose domain is
!> cut off there, so that points may cross it by a small distance in every step. Such a point is moved back to its
!> mirror image, as far inside as it was outside; only its position is corrected. Points at rest on an axis are not
!> placed on the axis itself, where hoop strains are not defined.
!>
!> Only the ends of the mesh along the axes are checked; elsewhere a point that is too far outside has left the mesh
!> (qsmpm_point_location).
!>
!> A slide driven by its weight that reaches a constrained side is supported by it from then on. This is reported where
!> soil within one cell of a side has yielded and moved along it by more than a cell; a column compressed between
!> rollers does not meet this criterion. Where a phase prescribes displacements or finds a limit load, plastic flow
!> along a side, which may carry load, is reported.
module qsmpm_held_sides
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: any_of, lowest_rank
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_limit_load, only: is_found
  use qsmpm_mesh_search, only: locate
  use qsmpm_model, only: model_type
  use qsmpm_observer, only: observer_type
  use qsmpm_own_part, only: own_of
  use qsmpm_points, only: carried_type, points_type, carries_strains
  use qsmpm_rounded_text, only: rounded_place, rounded_text
  use qsmpm_space, only: shape_values_type, functions_at, node_position
  use qsmpm_team, only: largest, spread_from
  implicit none
  private

  public :: keep_inside, side_check_type, warn_of_crossing, warn_of_reached_sides

  !> Distance across a side in a step, in cell sizes, above which a warning is printed.
  real(wp), parameter :: noticed = 0.1_wp
  !> Functions smaller than this are taken as zero at a side.
  real(wp), parameter :: negligible = 1.0e-9_wp
  !> Plastic shear strain of sliding soil, and smallest ratio of its displacement normal to a smooth side to that along
  !> it.
  real(wp), parameter :: sheared = 0.1_wp, turned = 0.1_wp
  !> Smallest displacement of yielding soil along a side, relative to the largest displacement of all soil.
  real(wp), parameter :: flows = 0.1_wp

  !> Reports made so far.
  type :: side_check_type
    !> Distance last reported, in cells.
    real(wp) :: reported = noticed
    !> Sides reported as reached by a slide (axis, low or high).
    logical :: reached(3, 2) = .false.
  end type side_check_type

contains

  !> Moves back the points that a step has moved across constrained sides.
  subroutine keep_inside(model, displacement, farthest)
    type(model_type), intent(inout) :: model
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Largest distance of a material point across a side; 0 where none crosses.
    real(wp), intent(out) :: farthest
    real(wp) :: of_others

    associate (state => model%state)
      call put_back(model, displacement, state%points, farthest)
      call put_back(model, displacement, state%surface, of_others)
      call put_back(model, displacement, state%tracers, of_others)
      call put_back(model, displacement, state%watched, of_others)
    end associate
  end subroutine keep_inside

  !> Moves back one set of points.
  subroutine put_back(model, displacement, carried, farthest)
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: displacement(:, :)
    class(carried_type), intent(inout) :: carried
    real(wp), intent(out) :: farthest
    real(wp) :: foot(model%mesh%dimension), beyond
    integer :: i, a

    farthest = 0.0_wp
    associate (low => model%mesh%bounds(:, 1), high => model%mesh%bounds(:, 2))
      do i = 1, carried%count
        ! The point belongs to another process of the team.
        if (carried%cell(i) == 0) cycle
        if (all(carried%position(:, i) >= low .and. carried%position(:, i) <= high)) cycle
        foot = min(max(carried%position(:, i), low), high)
        do a = 1, size(foot)
          beyond = carried%position(a, i) - foot(a)
          if (.not. abs(beyond) > 0.0_wp) cycle
          if (.not. is_held(model, carried%cell(i), foot, a, displacement)) cycle
          carried%position(a, i) = foot(a) - beyond
          farthest = max(farthest, abs(beyond))
        end do
      end do
    end associate
  end subroutine put_back

  !> Returns whether a place on a side is constrained along an axis and does not move.
  logical function is_held(model, near, foot, axis, displacement) result(held)
    type(model_type), intent(in) :: model
    !> A cell close to the place.
    integer, intent(in) :: near
    real(wp), intent(in) :: foot(:)
    integer, intent(in) :: axis
    !> Displacement of the step; without it no node is taken as moved.
    real(wp), intent(in), optional :: displacement(:, :)
    type(shape_values_type) :: place
    real(wp) :: local(size(foot))
    integer :: a, cell

    cell = near
    call locate(model%mesh, foot, cell, local, held)
    if (.not. held) return
    call functions_at(model%space, model%mesh, cell, local, place)
    do a = 1, place%count
      if (abs(place%shape(a)) <= negligible) cycle
      held = held .and. model%loading%constrained(axis, place%node(a))
      if (present(displacement)) held = held .and. .not. abs(displacement(axis, place%node(a))) > 0.0_wp
    end do
  end function is_held

  !> Warns where points have moved far across a constrained side, and again when the distance has doubled.
  subroutine warn_of_crossing(cell_size, crossing, check, observer)
    real(wp), intent(in) :: cell_size
    !> Distance in the step.
    real(wp), intent(in) :: crossing
    type(side_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer
    character(len=12) :: buffer

    if (.not. crossing > check%reported*cell_size) return
    check%reported = 2.0_wp*crossing/cell_size
    write (buffer, '(f8.2)') crossing/cell_size
    call observer%note('warning: a step carries material points by '//trim(adjustl(buffer))// &
      ' cells across a fixed side of the mesh; they are reflected to the inside: use smaller steps')
  end subroutine warn_of_crossing

  !> Reports, once each, the sides reached by soil that slides by its weight or yields where the phase prescribes
  !> displacements.
  subroutine warn_of_reached_sides(model, check, observer)
    type(model_type), intent(in) :: model
    type(side_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer
    real(wp) :: way, place(model%mesh%dimension), least
    logical :: fully, pushes
    integer :: axis, side

    least = model%cell_size
    associate (phase => model%analysis%phases(model%state%progress%phase), points => model%state%points)
      pushes = size(phase%prescriptions) + size(phase%moves) > 0 .or. is_found(model%state%progress%limit)
      if (pushes) least = flows*largest(model%part%team, sqrt(maxval([0.0_wp, &
        sum((points%position - points%initial_position)**2, dim=1)])))
    end associate
    do axis = 1, model%mesh%dimension
      do side = 1, 2
        if (check%reached(axis, side)) cycle
        if (model%analysis%model == axisymmetric .and. axis == 1 .and. side == 1) cycle
        if (pushes) then
          if (any_of(model%part%team, is_pushed(model, axis, side))) cycle
        end if
        call find_slide(model, axis, side, pushes, way, place, fully)
        if (.not. way > least) cycle
        check%reached(axis, side) = .true.
        call observer%note(reached_text(model, axis, side, pushes, way, place, fully))
      end do
    end do
  end subroutine warn_of_reached_sides

  !> Returns whether nodes on a side have prescribed displacements: the loaded object is then cut in half by a plane of
  !> symmetry.
  pure logical function is_pushed(model, axis, side)
    type(model_type), intent(in) :: model
    integer, intent(in) :: axis, side
    integer :: a

    is_pushed = .false.
    do a = 1, model%space%node_count
      if (all(abs(model%loading%prescribed(:, a)) <= 0.0_wp)) cycle
      associate (at => node_position(model%space, model%mesh, a))
        is_pushed = is_pushed .or. abs(at(axis) - model%mesh%bounds(axis, side)) <= negligible*model%cell_size
      end associate
    end do
  end function is_pushed

  !> Returns whether a point has sheared plastically; where strains are not stored, whether it yielded in the last step.
  pure logical function has_yielded(points, p, now)
    type(points_type), intent(in) :: points
    integer, intent(in) :: p
    !> Only the last step counts.
    logical, intent(in) :: now

    if (carries_strains(points) .and. .not. now) then
      has_yielded = points%plastic_strain(p) > sheared
    else
      has_yielded = points%plastic(p) > 0
    end if
  end function has_yielded

  !> Finds the largest displacement along a constrained side of yielded soil within a cell of it. Along a smooth side of
  !> a three-dimensional slice the whole slide moves: there only fully fixed sides are checked.
  subroutine find_slide(model, axis, side, now, way, place, fully)
    type(model_type), intent(in) :: model
    !> Axis of the normal of the side; 1 for the lower side, 2 for the upper one.
    integer, intent(in) :: axis, side
    !> Count the soil that yielded in the last step.
    logical, intent(in) :: now
    !> 0 where there is none; place of the largest displacement.
    real(wp), intent(out) :: way, place(:)
    !> All components are constrained there.
    logical, intent(out) :: fully
    real(wp) :: move(size(place)), foot(size(place)), mark(1), across
    logical :: own(model%state%points%count), held
    integer :: p, a, rank

    way = 0.0_wp
    place = 0.0_wp
    fully = .false.
    across = 0.0_wp
    associate (points => model%state%points, bound => model%mesh%bounds(axis, side), team => model%part%team)
      own = own_of(model%part%points, points%count)
      do p = 1, points%count
        if (.not. own(p)) cycle
        if (.not. has_yielded(points, p, now)) cycle
        move = points%position(:, p) - points%initial_position(:, p)
        across = max(across, abs(move(axis)))
        if (abs(points%position(axis, p) - bound) > model%cell_size) cycle
        move(axis) = 0.0_wp
        if (.not. norm2(move) > way) cycle
        foot = points%position(:, p)
        foot(axis) = bound
        if (.not. is_held(model, points%cell(p), foot, axis)) cycle
        held = holds_all()
        if (size(place) == 3 .and. .not. held) cycle
        way = norm2(move)
        place = points%position(:, p)
        fully = held
      end do
      rank = lowest_rank(team, way >= largest(team, way))
      way = largest(team, way)
      mark = merge(1.0_wp, 0.0_wp, fully)
      call spread_from(team, rank, place)
      call spread_from(team, rank, mark)
      across = largest(team, across)
    end associate
    fully = mark(1) > 0.0_wp
    if (.not. fully .and. across < turned*way) way = 0.0_wp

  contains

    !> Returns whether all components are fixed at the foot point.
    logical function holds_all()
      holds_all = all([(is_held(model, model%state%points%cell(p), foot, a), a=1, size(foot))])
    end function holds_all
  end subroutine find_slide

  !> Returns the message: which side, how far and where, and its consequence.
  pure function reached_text(model, axis, side, pushes, way, place, fully) result(text)
    type(model_type), intent(in) :: model
    integer, intent(in) :: axis, side
    !> The phase prescribes displacements.
    logical, intent(in) :: pushes
    real(wp), intent(in) :: way, place(:)
    logical, intent(in) :: fully
    character(len=:), allocatable :: text

    text = "phase '"//model%analysis%phases(model%state%progress%phase)%name//"': "// &
      trim(merge('soil yields along    ', 'the slide has reached', pushes))//' the side '// &
      achar(iachar('x') + axis - 1)//' = '//rounded_text(model%mesh%bounds(axis, side))// &
      ' of the mesh: soil within a cell of it has yielded and moved along it by '//rounded_text(way)//', most at '// &
      rounded_place(place)//'. '
    if (pushes) then
      text = text//'The boundary may carry a part of the load'
    else
      text = 'warning: '//text//'The boundary stops it from there on, and its run-out is decided by the size of '// &
        'the grid'
    end if
    text = text//': move the boundary farther away, unless '//trim(merge('the ground is firm there           ', &
      'it is a plane of symmetry or a wall', fully))
  end function reached_text
end module qsmpm_held_sides
