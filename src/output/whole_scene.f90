!> The scene as defined by the user, in addition to the reduced model that is run; results are written for the scene.
!>
!> A reduced model and its scene are connected only in this module. The scene has its own mesh, material points and
!> progress, which are derived from those of the model by the expansion that the reductions provide (`qsmpm_reduction`,
!> `qsmpm_images`); writers of results receive the scene in place of the model.
module qsmpm_whole_scene
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_reduction, only: expansion_type, history_of_scene, reduction_name
  use qsmpm_images, only: image_list_type, make_images, fold_place, window_of_scene
  use qsmpm_grid, only: grid_type, make_grid, whole_window, pieces_of
  use qsmpm_grid_window, only: window_type, operator(==), renumber
  use qsmpm_mesh, only: mesh_type
  use qsmpm_point_bins, only: point_bins_type, make_bins, nearest_in_bins
  use qsmpm_field_list, only: field_list_type, kind_internal
  use qsmpm_points, only: allocate_points, points_type, carry_as
  use qsmpm_diagnostics, only: diagnostics_type
  use qsmpm_model, only: model_type
  use qsmpm_model_mesh, only: make_mesh, make_sets, grid_of, make_space
  use qsmpm_model_window, only: fit_window
  use qsmpm_observer, only: step_record_type
  use qsmpm_nodal_fields, only: count_equations
  use qsmpm_number_text, only: integer_text
  use qsmpm_stress_error, only: stress_error_type
  implicit none
  private

  public :: whole_scene_type, begin_whole, follow_step, show_state, whole_record, savings_text, is_reduced, &
    estimate_of_scene, scene_of

  !> The scene and its expansion from the model.
  type :: whole_scene_type
    type(expansion_type) :: expansion
    !> The scene with the data for pictures, if there is a reduction.
    class(model_type), allocatable :: model
    !> Node of the model with which each node of the scene moves; signs of its displacement.
    integer, allocatable :: node(:)
    real(wp), allocatable :: sign(:, :)
    !> Part of the model's grid to which the mesh of the scene corresponds; its initial node coordinates (dimension of
    !> the model, nodes).
    type(window_type) :: window
    real(wp), allocatable :: start(:, :)
    !> Point of the model of which each point of the scene is an image.
    integer, allocatable :: origin(:)
  end type whole_scene_type

contains

  !> Returns whether the model is smaller than the scene.
  pure logical function is_reduced(whole)
    type(whole_scene_type), intent(in) :: whole

    is_reduced = .false.
    if (allocated(whole%expansion%steps)) is_reduced = size(whole%expansion%steps) > 0
  end function is_reduced

  !> Generates the mesh of the scene and its points from those of the model.
  subroutine begin_whole(whole, scene, expansion, model, error)
    type(whole_scene_type), intent(out) :: whole
    !> The scene as defined in the deck; the expansion from the model to the scene.
    type(analysis_type), intent(in) :: scene
    type(expansion_type), intent(in) :: expansion
    !> The model as built.
    type(model_type), intent(in) :: model
    !> Set when the mesh or the sets of the scene have errors.
    type(error_type), allocatable, intent(out) :: error
    type(diagnostics_type) :: diagnostics

    whole%expansion = expansion
    if (.not. is_reduced(whole)) return
    allocate (whole%model)
    whole%model%analysis = scene
    whole%model%analysis%materials = model%analysis%materials
    whole%model%notes = ''
    whole%model%state%window = window_of_scene(expansion, model%state%window)
    call make_mesh(whole%model, diagnostics)
    if (diagnostics%count == 0) call make_sets(whole%model, diagnostics)
    if (diagnostics%count == 0) call make_space(whole%model, diagnostics)
    if (diagnostics%count > 0) then
      call fail(error, error_deck, diagnostics%text)
      return
    end if
    whole%model%state%coordinates = whole%model%mesh%coordinates
    call match_nodes(whole, model)
    call follow_step(whole, model)
    call show_state(whole, model)
  end subroutine begin_whole

  !> Finds the node of the model for every node of the scene.
  subroutine match_nodes(whole, model)
    type(whole_scene_type), intent(inout) :: whole
    type(model_type), intent(in) :: model
    type(point_bins_type) :: bins
    type(mesh_type) :: built
    real(wp) :: place(3)
    integer :: i

    call make_grid(grid_of(model%analysis), built, model%state%window)
    whole%window = model%state%window
    whole%start = built%coordinates
    if (allocated(whole%node)) deallocate (whole%node, whole%sign)
    associate (mesh => whole%model%mesh)
      allocate (whole%node(mesh%node_count), whole%sign(3, mesh%node_count))
      call make_bins(whole%start, bins)
      do i = 1, mesh%node_count
        place = 0.0_wp
        place(:mesh%dimension) = mesh%coordinates(:, i)
        call fold_place(whole%expansion, place, whole%sign(:, i))
        whole%node(i) = nearest_in_bins(bins, whole%start, place(:model%mesh%dimension))
      end do
    end associate
  end subroutine match_nodes

  !> Updates the progress of the scene; work is that of the whole scene.
  pure subroutine follow_step(whole, model)
    type(whole_scene_type), intent(inout) :: whole
    type(model_type), intent(in) :: model
    real(wp) :: factor

    factor = product(whole%expansion%steps%factor)
    whole%model%state%progress = model%state%progress
    whole%model%state%progress%external_work = factor*model%state%progress%external_work
    whole%model%state%progress%internal_work = factor*model%state%progress%internal_work
  end subroutine follow_step

  !> Returns the record of a step with the histories of the scene.
  pure subroutine whole_record(whole, record, changed)
    type(whole_scene_type), intent(in) :: whole
    !> Record of the step in the model.
    type(step_record_type), intent(in) :: record
    !> The record with the histories of the scene.
    type(step_record_type), intent(out) :: changed
    real(wp) :: factor
    integer :: i, s

    changed = record
    if (.not. allocated(record%histories)) return
    do i = 1, size(record%histories)
      factor = 1.0_wp
      do s = 1, size(whole%expansion%steps)
        factor = factor*whole%expansion%steps(s)%history_factor(i)
      end do
      changed%histories(i) = whole%model%analysis%histories(i)%scale*history_of_scene(whole%expansion, i, 0.0_wp) &
        + factor*record%histories(i)
    end do
  end subroutine whole_record

  !> Updates points, nodes and loads of the scene from the current state of the model.
  subroutine show_state(whole, model)
    type(whole_scene_type), intent(inout) :: whole
    type(model_type), intent(in) :: model
    type(image_list_type) :: images
    integer :: i, n

    if (.not. whole%window == model%state%window) then
      call fit_window(whole%model, window_of_scene(whole%expansion, model%state%window))
      call match_nodes(whole, model)
    end if
    call make_images(whole%expansion, model%state%points, model%mesh%cell_label(model%state%points%cell), images)
    whole%origin = images%origin
    call take_points(images%points, whole%model)
    n = model%mesh%dimension
    do i = 1, size(whole%node)
      associate (place => whole%model%state%coordinates(:, i), own => whole%node(i))
        place = whole%model%mesh%coordinates(:, i)
        place(:n) = place(:n) + whole%sign(:n, i)*(model%state%coordinates(:, own) - whole%start(:, own))
      end associate
    end do
    call show_loads(whole, model, images)
  end subroutine show_state

  !> Sets the images as points of the scene, with the number of components of its dimension.
  subroutine take_points(images, scene)
    !> Images; their cells are numbered in the whole grid.
    type(points_type), intent(in), target :: images
    type(model_type), intent(inout), target :: scene
    type(field_list_type) :: from, to
    type(grid_type) :: grid
    integer :: i

    associate (points => scene%state%points, d => scene%mesh%dimension)
      if (points%count /= images%count) then
        call allocate_points(points, d, images%count, merge(4, 6, d == 2), 0)
        call carry_as(points, images)
      end if
      call images%list_fields(from)
      call points%list_fields(to)
      do i = 1, from%count
        if (from%fields(i)%kind == kind_internal) cycle
        if (associated(to%fields(i)%labels)) to%fields(i)%labels = from%fields(i)%labels
        if (associated(to%fields(i)%reals)) &
          to%fields(i)%reals = from%fields(i)%reals(:to%fields(i)%component_count(), :)
      end do
      grid = grid_of(scene%analysis)
      do i = 1, images%count
        points%cell(i) = renumber(whole_window(grid), scene%state%window, pieces_of(grid), images%cell(i))
      end do
    end associate
  end subroutine take_points

  !> Returns the analysis as defined in the deck.
  pure type(analysis_type) function scene_of(whole, model) result(analysis)
    type(whole_scene_type), intent(in) :: whole
    type(model_type), intent(in) :: model

    analysis = model%analysis
    if (is_reduced(whole)) analysis = whole%model%analysis
  end function scene_of

  !> Returns the estimated stress error at the points of the scene.
  pure type(stress_error_type) function estimate_of_scene(whole, estimate) result(shown)
    type(whole_scene_type), intent(in) :: whole
    !> Estimated error at the points of the model.
    type(stress_error_type), intent(in) :: estimate

    shown = estimate
    shown%at_point = estimate%at_point(whole%origin)
    shown%scale = estimate%scale(whole%origin)
  end function estimate_of_scene

  !> Sets gravity of the scene and its points that carry a part of a loaded surface. A surface has up to four images,
  !> one for each pair of signs along x and z.
  subroutine show_loads(whole, model, images)
    type(whole_scene_type), intent(inout) :: whole
    type(model_type), intent(in) :: model
    !> Points of the scene.
    type(image_list_type), intent(in) :: images
    integer, allocatable :: first(:), next(:)
    integer :: i, k, n, s, surfaces, image, turn
    real(wp) :: sign(3)

    whole%model%loading%gravity_start = model%loading%gravity_start
    whole%model%loading%gravity_final = model%loading%gravity_final
    if (.not. allocated(model%loading%traction_final)) return
    surfaces = size(model%loading%traction_final, 2)
    if (allocated(whole%model%loading%traction_start)) deallocate (whole%model%loading%traction_start, &
      whole%model%loading%traction_final)
    allocate (whole%model%loading%traction_start(3, 4*surfaces), whole%model%loading%traction_final(3, 4*surfaces))
    do turn = 0, 3
      sign = [merge(-1.0_wp, 1.0_wp, mod(turn, 2) == 1), 1.0_wp, merge(-1.0_wp, 1.0_wp, turn > 1)]
      do s = 1, surfaces
        whole%model%loading%traction_start(:, turn*surfaces + s) = sign*model%loading%traction_start(:, s)
        whole%model%loading%traction_final(:, turn*surfaces + s) = sign*model%loading%traction_final(:, s)
      end do
    end do
    call chain_images(images, model%state%points%count, first, next, n, model%carrying_point)
    if (allocated(whole%model%carrying_point)) deallocate (whole%model%carrying_point, &
      whole%model%carrying_surface, whole%model%carrying_area)
    allocate (whole%model%carrying_point(n), whole%model%carrying_surface(n), whole%model%carrying_area(n))
    k = 0
    do i = 1, size(model%carrying_point)
      image = first(model%carrying_point(i))
      do while (image > 0)
        k = k + 1
        turn = merge(1, 0, images%sign(1, image) < 0.0_wp) + merge(2, 0, images%sign(3, image) < 0.0_wp)
        whole%model%carrying_point(k) = image
        whole%model%carrying_surface(k) = turn*surfaces + model%carrying_surface(i)
        whole%model%carrying_area(k) = model%carrying_area(i)*images%points%volume(image) &
          /model%state%points%volume(model%carrying_point(i))
        image = next(image)
      end do
    end do
  end subroutine show_loads

  !> Returns the images of each point of the model as linked lists, and the total number for the carrying points.
  pure subroutine chain_images(images, points, first, next, total, carrying)
    !> Points of the scene.
    type(image_list_type), intent(in) :: images
    !> Number of points of the model.
    integer, intent(in) :: points
    !> First image of each point; next image of each image; 0 at the end.
    integer, allocatable, intent(out) :: first(:), next(:)
    !> Number of images of all carrying points.
    integer, intent(out) :: total
    !> Points that carry a part of a surface.
    integer, intent(in) :: carrying(:)
    integer :: k, i, counts(points)

    allocate (first(points), next(images%points%count), source=0)
    counts = 0
    do k = images%points%count, 1, -1
      next(k) = first(images%origin(k))
      first(images%origin(k)) = k
      counts(images%origin(k)) = counts(images%origin(k)) + 1
    end do
    total = 0
    do i = 1, size(carrying)
      total = total + counts(carrying(i))
    end do
  end subroutine chain_images

  !> Returns the savings of the reductions as lines for the log.
  subroutine savings_text(whole, model, text)
    type(whole_scene_type), intent(inout) :: whole
    type(model_type), intent(in) :: model
    !> One reduction per line, then the totals.
    character(len=:), allocatable, intent(out) :: text
    class(model_type), allocatable :: counted
    integer :: before, after, s

    text = ''
    allocate (counted, source=model)
    call count_equations(counted, after)
    call count_equations(whole%model, before)
    do s = 1, size(whole%expansion%steps)
      associate (step => whole%expansion%steps(s))
        text = text//'reduced to '//reduction_name(step%kind, step%axis)//new_line('a')
      end associate
    end do
    text = text//'equations '//integer_text(after)//' for '//integer_text(before)//', material points '// &
      integer_text(model%state%points%count)//' for '//integer_text(whole%model%state%points%count)// &
      ' of the scene; symmetric answers only; restart.h5 holds the reduced model'//new_line('a')
  end subroutine savings_text
end module qsmpm_whole_scene
