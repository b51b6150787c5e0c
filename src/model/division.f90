!> A model divided between the processes of a team, and made whole again.
!>
!> Every process builds the whole model, so that phases begin as they do alone. Then each keeps the material points of
!> its own box of cells (qsmpm_cell_boxes) and those in a ring of cells around it, and looks at that part of the grid
!> only. After an accepted step the copies are thrown away, points that have left the box go to the process whose box
!> they are in, and every process gets copies anew, so that copies never differ from what they are copies of. Tracers
!> and watched places are few: all processes have all of them, and the one whose box they are in moves them.
module qsmpm_division
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: agree
  use qsmpm_analysis, only: analysis_type, stabilise_none
  use qsmpm_basis_traits, only: basis_list
  use qsmpm_cell_boxes, only: share_cells, is_inside
  use qsmpm_error, only: error_type, fail, error_deck, error_other
  use qsmpm_exchange, only: hand_over
  use qsmpm_first_window, only: least_margin, usual_margin
  use qsmpm_grid, only: whole_window
  use qsmpm_grid_window, only: window_type, operator(==), cell_place, hull, holds, renumber, widen
  use qsmpm_model, only: model_type
  use qsmpm_model_mesh, only: grid_of
  use qsmpm_model_window, only: fit_window, move_window
  use qsmpm_own_marks, only: link_histories, mark_own
  use qsmpm_own_part, only: own_part_type, is_divided, own_of
  use qsmpm_point_delivery, only: deliver_points, fingerprint
  use qsmpm_point_selection, only: select_points
  use qsmpm_points, only: carried_type, points_type, watched_points_type
  use qsmpm_sorting, only: order_columns, place_in_order
  use qsmpm_space, only: node_label
  use qsmpm_team, only: team_type, largest, total
  use qsmpm_text, only: integer_text, real_text
  implicit none
  private

  public :: divide_model, division_text, join_model, migrate_points, unevenness, ring_of, whole_of, find_places

  character(len=*), parameter :: lost = 'material points, or what they carry, were lost between the processes'

contains

  !> Divide a whole model.
  subroutine divide_model(model, team, error)
    type(model_type), intent(inout) :: model
    type(team_type), intent(in) :: team
    !> error_deck: there are too few cells with material.
    type(error_type), allocatable, intent(out) :: error
    type(points_type) :: kept
    integer, allocatable :: at(:, :)
    logical, allocatable :: near(:)
    logical :: short
    integer :: i

    if (team%ranks == 1 .or. is_divided(model%part)) return
    associate (part => model%part, points => model%state%points)
      call find_places(model%state%window, points, at)
      allocate (part%boxes(team%ranks))
      call share_cells(at, whole_of(model), part%boxes, short)
      if (short) then
        deallocate (part%boxes)
        call fail(error, error_deck, 'the material lies in too few cells of the grid to be shared by '// &
          integer_text(team%ranks)//' processes')
        return
      end if
      part%team = team
      part%ring = ring_of(model%analysis)
      call select_points(points, [1], part%like)
      part%history_number = numbers_of(model)
      associate (reach => widen(part%boxes(team%rank + 1), spread(part%ring, 1, 3), whole_of(model)))
        near = [(is_inside(reach, at(:, i)), i=1, points%count)]
      end associate
      call select_points(points, pack([(i, i=1, points%count)], near), kept)
    end associate
    call number_cells(model%state%window, whole_of(model), kept)
    call number_cells(model%state%window, whole_of(model), model%state%tracers)
    call number_cells(model%state%window, whole_of(model), model%state%watched)
    call look_at(model, kept, .true.)
  end subroutine divide_model

  !> Rows of cells around a box whose points reach a function of the box, and what these depend on: functions reach
  !> over their degree of cells, domains one further; whether a cell is full, cut or at a ghost face is told by the
  !> cells around it, and its share of the stabilisation by two layers around those.
  pure integer function ring_of(analysis) result(ring)
    type(analysis_type), intent(in) :: analysis
    integer :: degree

    associate (basis => basis_list(analysis%method%basis))
      degree = max(1, basis%degree)
      ring = degree + 3
      if (analysis%method%stabilisation /= stabilise_none) ring = 2*degree + 3
    end associate
  end function ring_of

  !> Points go to the processes whose boxes they are in now, and copies to those whose rings they are in.
  subroutine migrate_points(model, error)
    type(model_type), intent(inout) :: model
    !> error_other: points were lost or doubled.
    type(error_type), allocatable, intent(out) :: error
    type(points_type) :: got
    integer, allocatable :: at(:, :)
    logical, allocatable :: goes(:, :)
    integer(long) :: before(4)
    integer :: p, r

    if (.not. is_divided(model%part)) return
    before = census(model)
    associate (part => model%part, points => model%state%points)
      call find_places(model%state%window, points, at)
      allocate (goes(part%team%ranks, points%count), source=.false.)
      do r = 1, part%team%ranks
        associate (reach => widen(part%boxes(r), spread(part%ring, 1, 3), whole_of(model)))
          do p = 1, points%count
            goes(r, p) = part%points(p) .and. is_inside(reach, at(:, p))
          end do
        end associate
      end do
      call number_cells(model%state%window, whole_of(model), points)
      call deliver_points(part%team, points, goes, part%like, got)
    end associate
    call share_places(model, model%part%tracers, model%state%tracers)
    call share_places(model, model%part%watched, model%state%watched)
    call look_at(model, got, .false.)
    if (any(census(model) /= before)) call fail(error, error_other, lost)
  end subroutine migrate_points

  !> The whole model on every process again.
  subroutine join_model(model, error)
    type(model_type), intent(inout) :: model
    type(error_type), allocatable, intent(out) :: error
    type(points_type) :: got
    type(own_part_type) :: alone
    integer, allocatable :: at(:, :), labels(:)
    real(wp), allocatable :: forces(:, :)
    integer(long) :: before(4)

    if (.not. is_divided(model%part)) return
    before = census(model)
    call number_cells(model%state%window, whole_of(model), model%state%points)
    associate (part => model%part)
      call deliver_points(part%team, model%state%points, spread(part%points, 1, part%team%ranks), part%like, got)
      call share_places(model, part%tracers, model%state%tracers)
      call share_places(model, part%watched, model%state%watched)
    end associate
    call collect_forces(model, labels, forces)
    model%state%points = got
    call link_histories(model, model%part%history_number, spread(.true., 1, got%count))
    model%part = alone
    if (any(census(model) /= before)) call fail(error, error_other, lost)
    if (allocated(error)) return
    call find_places(whole_of(model), model%state%points, at)
    call fit_window(model, around(model, at))
    call number_cells(whole_of(model), model%state%window, model%state%points)
    call number_cells(whole_of(model), model%state%window, model%state%tracers)
    call number_cells(whole_of(model), model%state%window, model%state%watched)
    call put_forces(model, labels, forces)
  end subroutine join_model

  !> How the points are shared, for the log.
  function division_text(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    real(wp) :: copies

    associate (part => model%part)
      copies = real(total(part%team, count(.not. part%points, kind=long)), wp) &
        /real(total(part%team, count(part%points, kind=long)), wp)
      text = 'shared by '//integer_text(part%team%ranks)//' processes: imbalance '//two_digits(unevenness(model))// &
        ' of their points, '//two_digits(copies)//' copies of a point'
    end associate

  contains

    !> With two digits behind the point.
    function two_digits(x) result(text)
      real(wp), intent(in) :: x
      character(len=:), allocatable :: text

      text = real_text(real(nint(100.0_wp*x), wp)/100.0_wp)
    end function two_digits
  end function division_text

  !> Own points of the process that has most of them, over the mean; 1 for a model that is whole.
  real(wp) function unevenness(model)
    type(model_type), intent(in) :: model
    real(wp) :: own

    unevenness = 1.0_wp
    if (.not. is_divided(model%part)) return
    associate (part => model%part)
      own = real(count(part%points), wp)
      unevenness = largest(part%team, own)*part%team%ranks/total(part%team, own)
    end associate
  end function unevenness

  !> Own points of all processes: how many, the sum of their numbers, and what they carry.
  function census(model) result(sums)
    type(model_type), intent(in) :: model
    integer(long) :: sums(4)
    logical :: own(model%state%points%count)

    associate (team => model%part%team, points => model%state%points)
      own = own_of(model%part%points, points%count)
      sums = [total(team, count(own, kind=long)), total(team, sum(points%number, mask=own)), &
        fingerprint(team, points, own)]
    end associate
  end function census

  !> The whole grid.
  pure type(window_type) function whole_of(model)
    type(model_type), intent(in) :: model

    whole_of = whole_window(grid_of(model%analysis))
  end function whole_of

  !> Cells of places in the whole grid.
  pure subroutine find_places(window, carried, at)
    !> In which the cells are numbered.
    type(window_type), intent(in) :: window
    class(carried_type), intent(in) :: carried
    !> (3, places)
    integer, allocatable, intent(out) :: at(:, :)
    integer :: p

    allocate (at(3, carried%count))
    do p = 1, carried%count
      at(:, p) = cell_place(window, 1, carried%cell(p))
    end do
  end subroutine find_places

  !> Number cells as another window does; 0 for one that it has not.
  pure subroutine number_cells(from, to, carried)
    type(window_type), intent(in) :: from, to
    class(carried_type), intent(inout) :: carried
    integer :: p

    do p = 1, carried%count
      if (carried%cell(p) == 0) cycle
      if (is_inside(to, cell_place(from, 1, carried%cell(p)))) then
        carried%cell(p) = renumber(from, to, 1, carried%cell(p))
      else
        carried%cell(p) = 0
      end if
    end do
  end subroutine number_cells

  !> Window around cells, with the margin that is usual.
  pure type(window_type) function around(model, at) result(window)
    type(model_type), intent(in) :: model
    !> (3, n), one at the least.
    integer, intent(in) :: at(:, :)

    window%first = minval(at, dim=2)
    window%last = maxval(at, dim=2)
    window = widen(window, usual_margin(model%analysis, window%last - window%first + 1), whole_of(model))
  end function around

  !> Take over points, and look at the part of the grid in which they are; a process without points keeps its window.
  !> The cells of all that rides are numbered as in the whole grid before, as in the window afterwards.
  subroutine look_at(model, points, anew)
    type(model_type), intent(inout) :: model
    type(points_type), intent(inout) :: points
    !> The window is that of another division.
    logical, intent(in) :: anew
    type(carried_type) :: tracers
    type(watched_points_type) :: watched
    type(window_type) :: needed
    integer, allocatable :: at(:, :)
    integer :: a

    tracers = model%state%tracers
    watched = model%state%watched
    call select_points(model%part%like, spread(1, 1, 0), model%state%points)
    call find_places(whole_of(model), points, at)
    if (points%count > 0) then
      needed = window_type(minval(at, dim=2), maxval(at, dim=2))
      a = least_margin(model%analysis)
      if (anew .or. .not. holds(model%state%window, widen(needed, [a, a, a], whole_of(model)))) &
        call move_window(model, around(model, at), 1)
    end if
    model%state%points = points
    model%state%tracers = tracers
    model%state%watched = watched
    call number_cells(whole_of(model), model%state%window, model%state%points)
    call number_cells(whole_of(model), model%state%window, model%state%tracers)
    call number_cells(whole_of(model), model%state%window, model%state%watched)
    call mark_own(model)
  end subroutine look_at

  !> What the process whose box it is in knows of a place, all know: where it is, and its cell in the whole grid.
  subroutine share_places(model, own, carried)
    type(model_type), intent(in) :: model
    !> Places that this process has moved.
    logical, intent(in) :: own(:)
    class(carried_type), intent(inout) :: carried
    real(wp), allocatable :: values(:, :)
    integer :: d, i

    if (carried%count == 0) return
    d = size(carried%position, 1)
    call number_cells(model%state%window, whole_of(model), carried)
    allocate (values(2*d + 1, carried%count), source=0.0_wp)
    do i = 1, carried%count
      if (own(i)) values(:, i) = [carried%position(:, i), carried%local(:, i), real(carried%cell(i), wp)]
    end do
    values = reshape(total(model%part%team, reshape(values, [size(values)])), shape(values))
    carried%position = values(:d, :)
    carried%local = values(d + 1:2*d, :)
    carried%cell = nint(values(2*d + 1, :))
  end subroutine share_places

  !> Numbers of the points of histories, 0 for none.
  pure function numbers_of(model) result(numbers)
    type(model_type), intent(in) :: model
    integer(long) :: numbers(size(model%history_point))
    integer :: i

    numbers = 0
    do i = 1, size(numbers)
      if (model%history_point(i) > 0) numbers(i) = model%state%points%number(model%history_point(i))
    end do
  end function numbers_of

  !> Reactions and released forces at the own nodes of all processes, where there are any.
  subroutine collect_forces(model, labels, forces)
    type(model_type), intent(in) :: model
    !> Labels of the nodes, and their forces (2 dimension, nodes).
    integer, allocatable, intent(out) :: labels(:)
    real(wp), allocatable, intent(out) :: forces(:, :)
    integer(long), allocatable :: got_labels(:)
    real(wp), allocatable :: table(:, :), got(:)
    integer, allocatable :: chosen(:), first(:)
    integer :: d, i, n, r

    associate (part => model%part, reactions => model%state%reactions, released => model%state%released)
      d = size(reactions, 1)
      chosen = pack([(i, i=1, size(part%nodes))], part%nodes .and. (any(abs(reactions) > 0.0_wp, dim=1) .or. &
        any(abs(released) > 0.0_wp, dim=1)))
      n = size(chosen)
      allocate (table(2*d, n))
      table(:d, :) = reactions(:, chosen)
      table(d + 1:, :) = released(:, chosen)
      ! The same to every process.
      call hand_over(part%team, [((int(node_label(model%space, model%mesh, chosen(i)), long), i=1, n), &
        r=1, part%team%ranks)], [(1 + n*r, r=0, part%team%ranks)], got_labels, first)
      call hand_over(part%team, [(table, r=1, part%team%ranks)], [(1 + 2*d*n*r, r=0, part%team%ranks)], got, first)
    end associate
    labels = int(got_labels)
    forces = reshape(got, [2*d, size(labels)])
  end subroutine collect_forces

  !> Put them at the nodes of the window.
  pure subroutine put_forces(model, labels, forces)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: labels(:)
    !> (2 dimension, labels)
    real(wp), intent(in) :: forces(:, :)
    integer :: order(size(labels)), sorted(size(labels)), a, d, k

    d = size(model%state%reactions, 1)
    call order_columns(reshape(labels, [1, size(labels)]), order)
    sorted = labels(order)
    do a = 1, model%space%node_count
      k = place_in_order(sorted, node_label(model%space, model%mesh, a))
      if (k == 0) cycle
      model%state%reactions(:, a) = forces(:d, order(k))
      model%state%released(:, a) = forces(d + 1:, order(k))
    end do
  end subroutine put_forces
end module qsmpm_division
