!> A body that comes, put on the ground: without stress and strain, its weight still to come.
!>
!> FILL=LEVEL stretches it along the vertical from the top as drawn down to the ground as it has settled
!> (qsmpm_inactive_points); where the ground lies above the top nothing is left of it. FILL=SHAPE takes it as drawn: an
!> overlap with the ground of more than a thousandth of it is an error. A body that has been there before comes back
!> where it is. On a mesh that goes with the ground it fills its cells (qsmpm_cells_of_bodies).
module qsmpm_body_placing
  use qsmpm_kinds, only: wp
  use qsmpm_body_description, only: body_change_type, fill_level
  use qsmpm_method_description, only: basis_fem
  use qsmpm_active_bodies, only: body_number
  use qsmpm_cells_of_bodies, only: put_in_cells, place_in_cell
  use qsmpm_error, only: error_type, error_deck, fail
  use qsmpm_inactive_points, only: stretch_over, height_over
  use qsmpm_model, only: model_type
  use qsmpm_point_location, only: relocate
  use qsmpm_point_selection, only: keep_chosen
  use qsmpm_points, only: points_type, surface_points_type, carries_strains, reset_strains, set_normals, place_of
  use qsmpm_rounded_text, only: rounded_text
  implicit none
  private

  public :: place_body

  !> Share of a body that may overlap the ground, and below which thickness, over that drawn, nothing is left of it.
  real(wp), parameter :: overlapping = 1.0e-3_wp, vanishing = 1.0e-2_wp

contains

  !> Put a body in place.
  subroutine place_body(model, change, body, surface, notes, error)
    !> The tracers of the body are put in place, too.
    type(model_type), intent(inout) :: model
    type(body_change_type), intent(in) :: change
    !> Its points and those of its surfaces.
    type(points_type), intent(inout) :: body
    type(surface_points_type), intent(inout) :: surface
    character(len=:), allocatable, intent(inout) :: notes
    type(error_type), allocatable, intent(out) :: error
    integer :: i

    if (model%analysis%method%basis == basis_fem) then
      call put_into_cells(model, change%body, body, surface, notes)
    else if (any(body%foot > 0)) then
      if (change%fill == fill_level) then
        call stretch(model, change%body, body, surface, notes, error)
      else
        call judge_overlap(model, change%body, body, notes, error)
      end if
      if (allocated(error)) return
      call place_tracers(model, body_number(model%analysis, change%body), change%fill)
    end if
    body%foot = 0
    surface%foot = 0
    if (model%analysis%method%basis /= basis_fem) then
      call relocate(model%mesh, model%cell_size, body, 'material point', error)
      if (.not. allocated(error)) call relocate(model%mesh, model%cell_size, surface, 'surface point', error)
      if (allocated(error)) return
    end if
    call start_anew(model, body)
    surface%reaction = 0.0_wp
    surface%released = 0.0_wp
    call set_normals(surface, [(.true., i=1, surface%count)])
  end subroutine place_body

  !> Put a body into the cells of a mesh that goes with the ground.
  subroutine put_into_cells(model, name, body, surface, notes)
    type(model_type), intent(inout) :: model
    character(len=*), intent(in) :: name
    type(points_type), intent(inout) :: body
    type(surface_points_type), intent(inout) :: surface
    character(len=:), allocatable, intent(inout) :: notes
    real(wp) :: drawn
    integer :: i

    drawn = sum(body%volume)
    call put_in_cells(model, body, surface)
    notes = notes//comes_text(name, sum(body%volume), drawn)
    associate (tracers => model%state%tracers, number => body_number(model%analysis, name))
      do i = 1, tracers%count
        if (model%tracer_body(i) /= number) cycle
        tracers%position(:, i) = place_in_cell(model, tracers, i)
        tracers%initial_position(:, i) = tracers%position(:, i)
      end do
    end associate
  end subroutine put_into_cells

  !> Stretch a body down to the ground.
  subroutine stretch(model, name, body, surface, notes, error)
    type(model_type), intent(in) :: model
    character(len=*), intent(in) :: name
    type(points_type), intent(inout) :: body
    type(surface_points_type), intent(inout) :: surface
    character(len=:), allocatable, intent(inout) :: notes
    !> Nothing is left of it.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: ratio(body%count), drawn
    integer :: i

    drawn = sum(body%volume)
    associate (axis => model%feet%axis)
      do i = 1, body%count
        ratio(i) = stretch_over(model%feet, body%foot(i), ground(model, body%foot(i)))
        body%position(axis, i) = height_over(model%feet, body%foot(i), ground(model, body%foot(i)), &
          body%position(axis, i))
        body%volume(i) = ratio(i)*body%volume(i)
        body%weight(i) = ratio(i)*body%weight(i)
        body%half_size(axis, i) = ratio(i)*body%half_size(axis, i)
      end do
      do i = 1, surface%count
        associate (foot => surface%foot(i))
          surface%position(axis, i) = height_over(model%feet, foot, ground(model, foot), surface%position(axis, i))
          call turn_area(stretch_over(model%feet, foot, ground(model, foot)), axis, surface%area_vector(:, i), &
            surface%area(i))
        end associate
      end do
    end associate
    if (any(ratio < vanishing)) call keep_chosen(body, pack([(i, i=1, body%count)], ratio >= vanishing))
    if (body%count == 0) call fail(error, error_deck, "body '"//name//"' cannot be put in place: the ground lies "// &
      'above all of it')
    notes = notes//comes_text(name, sum(body%volume), drawn)
  end subroutine stretch

  !> A sentence for the log.
  pure function comes_text(name, volume, drawn) result(text)
    character(len=*), intent(in) :: name
    !> On the ground as it is, and as drawn.
    real(wp), intent(in) :: volume, drawn
    character(len=:), allocatable :: text

    text = "body '"//name//"' comes: volume "//rounded_text(volume)//' down to the ground, '//rounded_text(drawn)// &
      ' as drawn'//new_line('a')
  end function comes_text

  !> Area of a surface point when heights are stretched: a = cof(F) a_0, F = diag(1, r) or diag(1, 1, r).
  pure subroutine turn_area(ratio, axis, vector, area)
    real(wp), intent(in) :: ratio
    integer, intent(in) :: axis
    !> (dimension)
    real(wp), intent(inout) :: vector(:)
    real(wp), intent(inout) :: area
    real(wp) :: before, upright

    before = norm2(vector)
    upright = vector(axis)
    vector = ratio*vector
    vector(axis) = upright
    if (before > 0.0_wp) area = area*norm2(vector)/before
  end subroutine turn_area

  !> Height of the ground at a foot; 0 for none.
  pure real(wp) function ground(model, foot)
    type(model_type), intent(in) :: model
    integer, intent(in) :: foot

    ground = 0.0_wp
    if (foot > 0) ground = model%state%inactive%feet%position(model%feet%axis, foot)
  end function ground

  !> Gap and overlap of a body as drawn with the ground.
  subroutine judge_overlap(model, name, body, notes, error)
    type(model_type), intent(in) :: model
    character(len=*), intent(in) :: name
    type(points_type), intent(in) :: body
    character(len=:), allocatable, intent(inout) :: notes
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: overlap, gap, share
    integer :: i

    overlap = 0.0_wp
    gap = 0.0_wp
    do i = 1, body%count
      share = 1.0_wp - stretch_over(model%feet, body%foot(i), ground(model, body%foot(i)))
      overlap = overlap + max(0.0_wp, share)*body%volume(i)
      gap = gap + max(0.0_wp, -share)*body%volume(i)
    end do
    notes = notes//"body '"//name//"' comes as drawn, volume "//rounded_text(sum(body%volume))//': it overlaps the '// &
      'ground by '//rounded_text(overlap)//' and leaves a gap of '//rounded_text(gap)//new_line('a')
    if (overlap > overlapping*sum(body%volume)) call fail(error, error_deck, "body '"//name//"' overlaps "// &
      'the ground by a volume of '//rounded_text(overlap)//' of '//rounded_text(sum(body%volume))//': *ACTIVATE, '// &
      'FILL=LEVEL puts it on the ground as it is')
  end subroutine judge_overlap

  !> Tracers of a body that comes for the first time: displacements count from here.
  pure subroutine place_tracers(model, body, fill)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: body, fill
    integer :: i

    associate (tracers => model%state%tracers, axis => model%feet%axis)
      do i = 1, tracers%count
        if (model%tracer_body(i) /= body) cycle
        if (fill == fill_level) tracers%position(axis, i) = height_over(model%feet, model%tracer_foot(i), &
          ground(model, model%tracer_foot(i)), tracers%position(axis, i))
        tracers%initial_position(:, i) = tracers%position(:, i)
      end do
    end associate
  end subroutine place_tracers

  !> Without stress and strain, at its place.
  subroutine start_anew(model, body)
    type(model_type), intent(in) :: model
    type(points_type), intent(inout) :: body
    integer :: p

    body%stress = 0.0_wp
    body%start_weight = 0.0_wp
    body%plastic = 0
    body%initial_volume = body%volume
    body%initial_position = body%position
    body%deformation_gradient = 0.0_wp
    if (model%mesh%dimension == 2) then
      body%deformation_gradient([1, 4, 5], :) = 1.0_wp
    else
      body%deformation_gradient([1, 5, 9], :) = 1.0_wp
    end if
    if (carries_strains(body)) call reset_strains(body)
    do p = 1, body%count
      associate (law => model%laws(body%material(p))%law)
        call law%start_at(body%stress(:, p), place_of(body, p), body%state(:law%state_count, p))
      end associate
    end do
  end subroutine start_anew
end module qsmpm_body_placing
