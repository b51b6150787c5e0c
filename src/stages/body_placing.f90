!> Placing of an activated body on the ground: without stress and strain, its weight increasing over the phase.
!>
!> FILL=LEVEL stretches it vertically from its top as defined in the deck down to the ground as it has settled
!> (qsmpm_inactive_points); where the ground is above the top nothing remains of it. FILL=SHAPE uses the shape defined
!> in the deck: an overlap with the ground of more than a thousandth of it is an error. A body that has been active
!> before returns at its present place. On a mesh that moves with the material it fills its cells.
!>
!> Cells of activated bodies on such a mesh: their nodes on the ground have moved with it, those on free boundaries are
!> placed at their initial position, and the nodes between follow by a smooth displacement, so that the shape of every
!> cell is preserved as far as possible. Material points, surface points and tracers move with their cells.
module qsmpm_body_placing
  use qsmpm_kinds, only: wp
  use qsmpm_body_description, only: body_change_type, fill_level
  use qsmpm_method_description, only: basis_fem
  use qsmpm_active_bodies, only: body_number, bodies_named
  use qsmpm_error, only: error_type, error_deck, fail, error_tangled
  use qsmpm_inactive_points, only: stretch_over, height_over
  use qsmpm_model, only: model_type
  use qsmpm_point_location, only: relocate
  use qsmpm_point_selection, only: keep_chosen
  use qsmpm_points, only: points_type, surface_points_type, carries_strains, reset_strains, set_normals, place_of, &
    carried_type
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_element, only: corner_count, face_corners, face_count, linear_kind, local_nodes, node_count, &
    shape_functions
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: interpolate, place_in_cell
  use qsmpm_moving_rows, only: least_jacobian
  use qsmpm_tensor, only: cofactor, determinant
  implicit none
  private

  public :: place_body, bodies_fit, move_their_nodes

  !> Share of a body that may overlap the ground, and ratio of the thickness to the initial one below which nothing
  !> remains.
  real(wp), parameter :: overlapping = 1.0e-3_wp, vanishing = 1.0e-2_wp

  !> Lower bound of the determinant of the map of a cell relative to the initial one.
  real(wp), parameter :: least_share = 0.15_wp
  !> Largest number of smoothing sweeps, and change relative to the largest displacement at which the smoothing ends.
  integer, parameter :: most_sweeps = 400
  real(wp), parameter :: at_rest = 1.0e-4_wp

contains

  !> Places a body.
  subroutine place_body(model, change, body, surface, notes, error)
    !> The tracers of the body are also placed.
    type(model_type), intent(inout) :: model
    type(body_change_type), intent(in) :: change
    !> Points of the body and of its surfaces.
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

  !> Places a body in the cells of a mesh that moves with the material.
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
        tracers%position(:, i) = place_in_cell(model%mesh, tracers%cell(i), tracers%local(:, i))
        tracers%initial_position(:, i) = tracers%position(:, i)
      end do
    end associate
  end subroutine put_into_cells

  !> Stretches a body down to the ground.
  subroutine stretch(model, name, body, surface, notes, error)
    type(model_type), intent(in) :: model
    character(len=*), intent(in) :: name
    type(points_type), intent(inout) :: body
    type(surface_points_type), intent(inout) :: surface
    character(len=:), allocatable, intent(inout) :: notes
    !> Nothing remains of the body.
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
    if (body%count == 0) call fail(error, error_deck, "body '"//name//"' cannot be activated: the ground "// &
      'surface is above all of it')
    notes = notes//comes_text(name, sum(body%volume), drawn)
  end subroutine stretch

  !> Returns a message for the log.
  pure function comes_text(name, volume, drawn) result(text)
    character(len=*), intent(in) :: name
    !> Volume on the present ground, and as defined in the deck.
    real(wp), intent(in) :: volume, drawn
    character(len=:), allocatable :: text

    text = "body '"//name//"' is activated: volume "//rounded_text(volume)//' down to the ground, '// &
      rounded_text(drawn)//' as drawn'//new_line('a')
  end function comes_text

  !> Computes the area of a surface point when heights are stretched: a = cof(F) a_0, F = diag(1, r) or diag(1, 1, r).
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

  !> Returns the height of the ground at a foot; 0 for none.
  pure real(wp) function ground(model, foot)
    type(model_type), intent(in) :: model
    integer, intent(in) :: foot

    ground = 0.0_wp
    if (foot > 0) ground = model%state%inactive%feet%position(model%feet%axis, foot)
  end function ground

  !> Checks gap and overlap of a body, as defined in the deck, with the ground.
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
    notes = notes//"body '"//name//"' is activated in its drawn shape, volume "//rounded_text(sum(body%volume))// &
      ': it overlaps the ground by '//rounded_text(overlap)//' and leaves a gap of '//rounded_text(gap)//new_line('a')
    if (overlap > overlapping*sum(body%volume)) call fail(error, error_deck, "body '"//name//"' overlaps "// &
      'the ground by a volume of '//rounded_text(overlap)//' of '//rounded_text(sum(body%volume))//': *ACTIVATE, '// &
      'FILL=LEVEL places it on the deformed ground surface')
  end subroutine judge_overlap

  !> Places the tracers of a body that is activated for the first time: displacements are measured from here.
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

  !> Initialises a body without stress and strain at its place.
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

  !> Returns whether the bodies activated in the current phase fit into their cells; true on a mesh that is reset.
  logical function bodies_fit(model) result(fit)
    type(model_type), intent(in) :: model
    real(wp), allocatable :: places(:, :)

    fit = model%analysis%method%basis /= basis_fem
    if (fit) return
    call find_places(model, places, fit)
  end function bodies_fit

  !> Moves the nodes of the bodies activated in the current phase.
  subroutine move_their_nodes(model, error)
    type(model_type), intent(inout) :: model
    !> A cell would turn inside out.
    type(error_type), allocatable, intent(out) :: error
    real(wp), allocatable :: places(:, :)
    logical :: fit

    call find_places(model, places, fit)
    if (.not. fit) then
      call fail(error, error_tangled, '*ACTIVATE: the ground has moved so far that elements of the body to be '// &
        'activated would be flat or inverted; use a background grid (*GRID, REFIT=YES, or ELEMENT=QUAD4)')
      return
    end if
    model%mesh%coordinates = places
    model%state%coordinates = places
  end subroutine move_their_nodes

  !> Finds the positions of all nodes with the activated bodies in their cells.
  subroutine find_places(model, places, fit)
    type(model_type), intent(in) :: model
    !> (dimension, nodes)
    real(wp), allocatable, intent(out) :: places(:, :)
    logical, intent(out) :: fit
    real(wp), allocatable :: moved(:, :)
    logical :: coming(model%mesh%cell_count), ground(model%mesh%node_count), held(model%mesh%node_count), &
      of_body(model%mesh%node_count)
    integer :: c, p
    logical, allocatable :: named(:)

    allocate (places, source=model%state%coordinates)
    fit = .true.
    ! Cells of the activated bodies that are not yet active.
    allocate (named(size(model%analysis%bodies)))
    coming = .false.
    named = bodies_named(model%analysis, model%analysis%phases(model%state%progress%phase)%activations)
    associate (waiting => model%state%inactive%points)
      do p = 1, waiting%count
        if (named(waiting%body(p))) coming(waiting%cell(p)) = .true.
      end do
    end associate
    if (.not. any(coming)) return
    moved = places - model%drawn_coordinates
    call find_ground(model, ground)
    held = ground
    call put_bounds_as_drawn(model%mesh, coming, held, of_body, moved)
    call smooth(model%mesh, coming, held, moved)
    call straighten(model%mesh, coming, ground, moved)
    where (spread(of_body .and. .not. ground, 1, size(moved, 1))) places = model%drawn_coordinates + moved
    do c = 1, size(coming)
      if (.not. coming(c)) cycle
      fit = least_jacobian(model%mesh, places, c) > least_share*least_jacobian(model%mesh, model%drawn_coordinates, c)
      if (.not. fit) return
    end do
  end subroutine find_places

  !> Finds the nodes of the active soil.
  subroutine find_ground(model, ground)
    type(model_type), intent(in) :: model
    !> Nodes of the active soil (nodes).
    logical, intent(out) :: ground(:)
    integer :: p

    ground = .false.
    associate (mesh => model%mesh, points => model%state%points)
      do p = 1, points%count
        associate (c => points%cell(p))
          ground(mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1)) = .true.
        end associate
      end do
    end associate
  end subroutine find_ground

  !> Moves nodes on boundaries of the activated bodies, where there is no active soil, to their initial position, and as
  !> a first guess those inside.
  subroutine put_bounds_as_drawn(mesh, coming, held, of_body, moved)
    type(mesh_type), intent(in) :: mesh
    logical, intent(in) :: coming(:)
    !> Nodes of the active soil; those on boundaries are added.
    logical, intent(inout) :: held(:)
    !> Nodes of the activated bodies.
    logical, intent(out) :: of_body(:)
    !> Displacement from the initial mesh (dimension, nodes).
    real(wp), intent(inout) :: moved(:, :)
    logical :: on_bounds(size(held))
    integer :: c, f

    on_bounds = .false.
    of_body = .false.
    do c = 1, size(coming)
      if (.not. coming(c)) cycle
      associate (nodes => mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1), kind => mesh%cell_kind(c))
        of_body(nodes) = .true.
        do f = 1, face_count(kind)
          if (.not. is_inside(mesh%face_neighbour(f, c))) on_bounds(nodes(face_corners(kind, f))) = .true.
        end do
      end associate
    end do
    where (spread(of_body .and. .not. held, 1, size(moved, 1))) moved = 0.0_wp
    held = held .or. on_bounds
  contains
    !> Returns whether a cell belongs to an activated body.
    pure logical function is_inside(beyond)
      integer, intent(in) :: beyond

      is_inside = beyond > 0
      if (is_inside) is_inside = coming(beyond)
    end function is_inside
  end subroutine put_bounds_as_drawn

  !> Replaces the displacement of corners that are not fixed by the mean of their neighbours, iteratively.
  subroutine smooth(mesh, coming, held, moved)
    type(mesh_type), intent(in) :: mesh
    logical, intent(in) :: coming(:), held(:)
    !> (dimension, nodes)
    real(wp), intent(inout) :: moved(:, :)
    real(wp) :: total(size(moved, 1), size(moved, 2)), largest, change
    integer :: seen(size(held)), sweep, c, k, n

    largest = maxval(abs(moved))
    do sweep = 1, most_sweeps
      total = 0.0_wp
      seen = 0
      do c = 1, size(coming)
        if (.not. coming(c)) cycle
        n = corner_count(mesh%cell_kind(c))
        associate (corners => mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c) + n - 1))
          do k = 1, n
            total(:, corners(k)) = total(:, corners(k)) + sum(moved(:, corners), dim=2) - moved(:, corners(k))
          end do
          seen(corners) = seen(corners) + n - 1
        end associate
      end do
      change = 0.0_wp
      do k = 1, size(seen)
        if (seen(k) == 0 .or. held(k)) cycle
        change = max(change, maxval(abs(total(:, k)/seen(k) - moved(:, k))))
        moved(:, k) = total(:, k)/seen(k)
      end do
      if (.not. change > at_rest*largest) exit
    end do
  end subroutine smooth

  !> Moves nodes between corners with these, where they do not belong to the active soil.
  subroutine straighten(mesh, coming, ground, moved)
    type(mesh_type), intent(in) :: mesh
    logical, intent(in) :: coming(:), ground(:)
    !> (dimension, nodes)
    real(wp), intent(inout) :: moved(:, :)
    real(wp), allocatable :: place(:, :), shape(:)
    integer :: c, k, n

    do c = 1, size(coming)
      if (.not. coming(c)) cycle
      associate (kind => mesh%cell_kind(c), nodes => mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1))
        n = corner_count(kind)
        place = local_nodes(kind)
        if (allocated(shape)) deallocate (shape)
        allocate (shape(n))
        do k = n + 1, node_count(kind)
          if (ground(nodes(k))) cycle
          call shape_functions(linear_kind(kind), place(:, k), shape)
          moved(:, nodes(k)) = matmul(moved(:, nodes(:n)), shape)
        end do
      end associate
    end do
  end subroutine straighten

  !> Moves a body with its cells: positions, volumes and weights of its material points, positions and areas of its
  !> surface points.
  subroutine put_in_cells(model, body, surface)
    type(model_type), intent(in) :: model
    type(points_type), intent(inout) :: body
    type(surface_points_type), intent(inout) :: surface
    real(wp) :: before(3, 3), behind(3, 3), area(3), old, ratio
    integer :: p

    do p = 1, body%count
      call maps_at(model, body, p, before, behind)
      ratio = determinant(behind)/determinant(before)
      body%volume(p) = ratio*body%volume(p)
      body%weight(p) = ratio*body%weight(p)
      body%position(:, p) = place_in_cell(model%mesh, body%cell(p), body%local(:, p))
    end do
    do p = 1, surface%count
      call maps_at(model, surface, p, before, behind)
      area = 0.0_wp
      area(:model%mesh%dimension) = surface%area_vector(:, p)
      old = norm2(area)
      ! cof(F) = cof(J') cof(J)^-1 with the maps J and J' of the initial and the present cell.
      area = matmul(cofactor(behind), matmul(transpose(before), area))/determinant(before)
      surface%area_vector(:, p) = area(:model%mesh%dimension)
      if (old > 0.0_wp) surface%area(p) = surface%area(p)*norm2(area)/old
      surface%position(:, p) = place_in_cell(model%mesh, surface%cell(p), surface%local(:, p))
    end do
  end subroutine put_in_cells

  !> Computes the derivatives of the position with respect to the local coordinates in the cell of a point, for the
  !> initial and the present cell; out of plane 1, or the radius.
  subroutine maps_at(model, carried, p, before, behind)
    type(model_type), intent(in) :: model
    class(carried_type), intent(in) :: carried
    integer, intent(in) :: p
    real(wp), intent(out) :: before(3, 3), behind(3, 3)
    real(wp), allocatable :: gradients(:, :), shape(:)

    before = 0.0_wp
    before(3, 3) = 1.0_wp
    behind = before
    associate (mesh => model%mesh, c => carried%cell(p), d => model%mesh%dimension)
      associate (nodes => mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1))
        allocate (gradients(d, size(nodes)), shape(size(nodes)))
        call shape_functions(mesh%cell_kind(c), carried%local(:, p), shape, gradients)
        before(:d, :d) = matmul(model%drawn_coordinates(:, nodes), transpose(gradients))
        behind(:d, :d) = matmul(mesh%coordinates(:, nodes), transpose(gradients))
        if (model%analysis%model /= axisymmetric) return
        before(3:, 3) = interpolate(mesh, c, shape, model%drawn_coordinates(:1, :))
        behind(3:, 3) = interpolate(mesh, c, shape, mesh%coordinates(:1, :))
      end associate
    end associate
  end subroutine maps_at
end module qsmpm_body_placing
