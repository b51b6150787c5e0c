!> Initial states of the integration points of bodies integrated over their outlines (qsmpm_body_quadrature) whose cell
!> has no material point of the body: those of the nearest point in the surrounding cells, otherwise anywhere in the
!> body, possibly on another process of the team. A process requests them from the owners of the surrounding cells, then
!> from all. Of several points at the same distance the result is that of a single process.
module qsmpm_source_sharing
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: any_of
  use qsmpm_body_quadrature, only: body_quadrature_type, nearest_in
  use qsmpm_cell_numbers, only: whole_cells, window_cells
  use qsmpm_team, only: hand_over
  use qsmpm_model, only: model_type
  use qsmpm_point_location, only: activation_type
  use qsmpm_ring_exchange, only: near_cells
  use qsmpm_mesh_measure, only: place_in_cell
  use qsmpm_points, only: nearest_point
  implicit none
  private

  public :: learn_sources

  !> Keys by which responses are compared: distance, then cell, material and number of the point. Material, volume and
  !> volume ratio follow, then stress and state.
  integer, parameter :: keys = 4, numbers = keys + 3

contains

  !> Finds the states of integration points in cells without a point of their body, as far as required here; collective
  !> over the team.
  subroutine learn_sources(model, activation, quadrature)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    type(body_quadrature_type), intent(inout) :: quadrature
    real(wp), allocatable :: questions(:, :), answers(:, :)
    integer, allocatable :: asking(:), cell(:)
    logical, allocatable :: goes(:, :)
    integer :: i

    call list_questions(model, quadrature, asking, cell, questions)
    if (.not. any_of(model%part%team, size(asking) > 0)) return
    associate (points => model%state%points)
      allocate (answers(numbers + size(points%stress, 1) + size(points%state, 1), size(asking)), source=huge(1.0_wp))
    end associate
    allocate (goes(model%part%team%ranks, size(asking)), source=.false.)
    do i = 1, size(asking)
      associate (around => model%mesh%vertex_neighbour(model%mesh%vertex_first(cell(i)): &
          model%mesh%vertex_first(cell(i) + 1) - 1))
        goes(model%part%owners%of_cells(whole_cells(model, around)) + 1, i) = .true.
      end associate
    end do
    call ask(model, activation, questions, goes, .true., answers)
    goes = spread(answers(1, :) >= huge(1.0_wp), 1, size(goes, 1))
    if (any_of(model%part%team, any(goes))) call ask(model, activation, questions, goes, .false., answers)
    call take_answers(answers, size(model%state%points%stress, 1), asking, quadrature)
  end subroutine learn_sources

  !> Lists integration points without a state.
  subroutine list_questions(model, quadrature, asking, cell, questions)
    type(model_type), intent(in) :: model
    type(body_quadrature_type), intent(in) :: quadrature
    !> Their numbers, and the cells that contain them (n).
    integer, allocatable, intent(out) :: asking(:), cell(:)
    !> Places, cells in the whole mesh, bodies (dimension + 2, n).
    real(wp), allocatable, intent(out) :: questions(:, :)
    logical :: near(model%mesh%cell_count)
    integer :: c, i

    near = near_cells(model, model%part%ring)
    allocate (asking(0), cell(0))
    do c = 1, size(near)
      if (.not. near(c)) cycle
      associate (first => quadrature%first(c), last => quadrature%first(c + 1) - 1)
        if (all(quadrature%source(first:last) /= 0)) cycle
        asking = [asking, pack([(i, i=first, last)], quadrature%source(first:last) == 0)]
        cell = [cell, spread(c, 1, size(asking) - size(cell))]
      end associate
    end do
    allocate (questions(model%mesh%dimension + 2, size(asking)))
    do i = 1, size(asking)
      questions(:, i) = [place_in_cell(model%mesh, cell(i), quadrature%local(:, asking(i))), &
        real([whole_cells(model, [cell(i)]), quadrature%body(asking(i))], wp)]
    end do
  end subroutine list_questions

  !> Requests states from other processes, and keeps the better responses.
  subroutine ask(model, activation, questions, goes, around, answers)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    real(wp), intent(in) :: questions(:, :)
    !> Processes to which a request is sent (ranks, requests).
    logical, intent(in) :: goes(:, :)
    !> Points in the surrounding cells, otherwise any of the body.
    logical, intent(in) :: around
    real(wp), intent(inout) :: answers(:, :)
    real(wp), allocatable :: asked(:), got(:), given(:, :)
    integer, allocatable :: first_asked(:), first_got(:)
    integer :: first(size(goes, 1) + 1), r, i, k, rows, n

    rows = size(questions, 1)
    first = [1, (1 + rows*count(goes(:r, :)), r=1, size(goes, 1))]
    associate (team => model%part%team)
      call hand_over(team, [(pack(questions, spread(goes(r, :), 1, rows)), r=1, size(goes, 1))], first, asked, &
        first_asked)
      n = size(asked)/rows
      allocate (given(size(answers, 1), n))
      do i = 1, n
        given(:, i) = answer(model, activation, asked((i - 1)*rows + 1:i*rows), around, size(answers, 1))
      end do
      call hand_over(team, reshape(given, [size(given)]), (first_asked - 1)/rows*size(answers, 1) + 1, got, first_got)
    end associate
    k = 0
    do r = 1, size(goes, 1)
      do i = 1, size(goes, 2)
        if (.not. goes(r, i)) cycle
        associate (new => got(k + 1:k + size(answers, 1)))
          if (is_before(new(:keys), answers(:keys, i))) answers(:, i) = new
        end associate
        k = k + size(answers, 1)
      end do
    end do
  end subroutine ask

  !> Response of this process to a request: its nearest point, at huge distance if there is none.
  pure function answer(model, activation, question, around, rows)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    real(wp), intent(in) :: question(:)
    logical, intent(in) :: around
    integer, intent(in) :: rows
    real(wp) :: answer(rows)
    integer :: cell(1), body, d, k, p

    d = model%mesh%dimension
    body = nint(question(d + 2))
    answer = huge(1.0_wp)
    associate (points => model%state%points, x => question(:d))
      p = 0
      if (around) then
        cell = window_cells(model, [nint(question(d + 1))])
        if (cell(1) == 0) return
        do k = model%mesh%vertex_first(cell(1)), model%mesh%vertex_first(cell(1) + 1) - 1
          call nearest_in(activation, points, model%mesh%vertex_neighbour(k), body, x, p)
        end do
      else
        p = nearest_point(points, x, body)
      end if
      if (p == 0) return
      answer(:keys) = [sum((points%position(:, p) - x)**2), 0.0_wp, 0.0_wp, real(points%number(p), wp)]
      ! A single process searches the surrounding cells by cells and materials, the whole body by numbers.
      if (around) answer(2:3) = real([whole_cells(model, [points%cell(p)]), points%material(p)], wp)
      answer(keys + 1:) = [real(points%material(p), wp), points%volume(p), &
        points%volume(p)/points%initial_volume(p), points%stress(:, p), points%state(:, p)]
    end associate
  end function answer

  !> Checks whether a response precedes another one.
  pure logical function is_before(one, other)
    !> (keys)
    real(wp), intent(in) :: one(:), other(:)
    integer :: i

    is_before = .false.
    do i = 1, size(one)
      if (one(i) < other(i)) is_before = .true.
      if (abs(one(i) - other(i)) > 0.0_wp) return
    end do
  end function is_before

  !> Assigns the states of the responses to the integration points.
  pure subroutine take_answers(answers, components, asking, quadrature)
    real(wp), intent(in) :: answers(:, :)
    !> Number of stress components.
    integer, intent(in) :: components
    integer, intent(in) :: asking(:)
    type(body_quadrature_type), intent(inout) :: quadrature
    integer :: i

    associate (received => quadrature%received)
      received%material = nint(answers(keys + 1, :))
      received%volume = answers(keys + 2, :)
      received%volume_ratio = answers(keys + 3, :)
      received%stress = answers(numbers + 1:numbers + components, :)
      received%state = answers(numbers + components + 1:, :)
      quadrature%source(asking) = [(-i, i=1, size(asking))]
    end associate
  end subroutine take_answers
end module qsmpm_source_sharing
