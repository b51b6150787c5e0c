!> What a reduction makes of a scene, and the way back: the images of the model's points are the points
!> of the scene as it would have been seeded itself, vectors and tensors turn with them, histories come
!> back to the values of the scene.
module test_scene_results
  use qsmpm_kinds, only: wp, pi
  use qsmpm_analysis, only: analysis_type, plane_strain, axisymmetric
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_images, only: image_list_type, make_images, fold_place
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_reduction, only: expansion_type, reduction_check_type, history_of_scene, reduce_revolved
  use scene_samples, only: slice_deck, layers_deck, twin_deck, figure_deck, pressed_slice, pressed_layers, &
    pressed_twins, pressed_figure, changed, reduced, turned_facets, write_stl, figure_file
  use testing, only: tests_type
  implicit none
  private

  public :: collect_scene_results

  !> Places and volumes of images come from sums of a few rounded numbers of size 10.
  real(wp), parameter :: rounding = 1.0e-13_wp

contains

  !> All checks.
  subroutine collect_scene_results(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('scene_results')
    call check_plane(tests)
    call check_column(tests)
    call check_half(tests)
    call check_quarter(tests)
    call check_figure(tests)
    call check_pressed(tests)
    call check_seeds(tests, slice_deck(), 'a slice')
    call check_seeds(tests, changed(changed(slice_deck(), 'HEX8', 'WEDGE15'), 'ELEMENT=27', 'ELEMENT=18'), &
      'a slice of wedges')
    call check_seeds(tests, changed(slice_deck(), 'ELEMENT=HEX8', 'ELEMENT=HEX8, PERTURB=0.1'), &
      'a slice of shifted bricks')
    call check_seeds(tests, layers_deck(), 'layers')
    call check_seeds(tests, twin_deck(), 'a mirrored scene')
    call check_seeds(tests, changed(twin_deck(), 'QUAD4', 'TRI6, DIAGONAL=ALTERNATE'), 'mirrored triangles')
    call check_stress(tests)
    call check_open_edges(tests)
  end subroutine collect_scene_results

  !> A slice becomes its section; forces come back by the thickness, what goes along z by constants.
  subroutine check_plane(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: model
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)

    allocate (model)
    call reduced(slice_deck(), model, expansion, checks)
    call tests%check('a slice becomes one step to plane strain', size(expansion%steps) == 1 .and. &
      model%model == plane_strain .and. model%mesh%element == 'QUAD4' .and. .not. allocated(model%mesh%axes(3)%lines))
    call tests%check('27 points of a brick are 9 of its face', all(model%bodies%points_per_element == 9))
    call tests%check('sets across z are gone', size(model%node_sets) == 3)
    call tests%check('fixities hold in the plane', size(model%phases(1)%fixities) == 3 .and. &
      all(model%phases(1)%fixities(1)%fixed .eqv. [.true., .true., .false.]))
    call tests%close('forces come back by the thickness', expansion%steps(1)%factor, 0.5_wp, 0.0_wp)
    call tests%close('a displacement as it is', history_of_scene(expansion, 1, 3.0_wp), 3.0_wp, 0.0_wp)
    call tests%close('a place along z stands', history_of_scene(expansion, 2, 3.0_wp), 0.3_wp, 0.0_wp)
    call tests%close('a reaction by the thickness', history_of_scene(expansion, 3, 3.0_wp), 1.5_wp, 0.0_wp)
    call tests%close('a shear across z vanishes', history_of_scene(expansion, 4, 3.0_wp), 0.0_wp, 0.0_wp)
  end subroutine check_plane

  !> Layers become their first column.
  subroutine check_column(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: model
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)

    allocate (model)
    call reduced(layers_deck(), model, expansion, checks)
    call tests%check('layers become a column one cell wide', size(expansion%steps) == 1 .and. &
      size(model%mesh%axes(1)%lines) == 2)
    call tests%close('forces come back by the width', expansion%steps(1)%factor, 4.0_wp, 0.0_wp)
    ! 2.2 is 0.7 of the way from 1.5 to 2.5.
    call tests%close('a history reads the like place', model%histories(1)%at(1), 0.7_wp, rounding)
    call tests%close('its place along x stands', history_of_scene(expansion, 2, 0.7_wp), 2.2_wp, rounding)
    call tests%close('a reaction of the base by the width', history_of_scene(expansion, 3, 3.0_wp), 12.0_wp, rounding)
    call tests%close('a reaction of a side as it is', history_of_scene(expansion, 4, 3.0_wp), 3.0_wp, 0.0_wp)
  end subroutine check_column

  !> Twin heaps become the left one.
  subroutine check_half(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: model
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)
    logical :: held
    integer :: i

    allocate (model)
    call reduced(twin_deck(), model, expansion, checks)
    call tests%check('twin heaps become one and half of what is between', size(expansion%steps) == 1 .and. &
      size(model%bodies) == 2 .and. size(model%mesh%axes(1)%lines) == 9)
    call tests%check('each knows its image', all(expansion%steps(1)%body == [1, 3]) .and. &
      all(expansion%steps(1)%image_body == [2, 3]))
    call tests%check('the load of the other heap is gone', size(model%surfaces) == 2 .and. &
      size(model%phases(1)%tractions) == 2)
    held = .false.
    do i = 1, size(model%phases(1)%fixities)
      held = held .or. (model%phases(1)%fixities(i)%set == '=mirror x' .and. model%phases(1)%fixities(i)%fixed(1))
    end do
    call tests%check('the plane is held', held)
    call tests%close('a place beyond is read on this side', model%histories(1)%at(1), 1.0_wp, rounding)
    call tests%close('and mirrored back', history_of_scene(expansion, 1, 1.25_wp), 6.75_wp, rounding)
    call tests%close('a shear changes its sign', history_of_scene(expansion, 2, 3.0_wp), -3.0_wp, 0.0_wp)
    call tests%close('a reaction of both halves is doubled', history_of_scene(expansion, 3, 3.0_wp), 6.0_wp, 0.0_wp)
    call tests%close('one of the other side is mirrored', history_of_scene(expansion, 4, 3.0_wp), -3.0_wp, 0.0_wp)
  end subroutine check_half

  !> A block in 3D is halved twice.
  subroutine check_quarter(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: model
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)
    character(len=:), allocatable :: deck

    allocate (model)
    deck = changed(slice_deck(), ' 0, 0| 2, 0| 1, 1| 0, 1|', ' 1, 0| 3, 0| 3, 1| 1, 1|')
    deck = changed(deck, ' 2, 4, 0, 0.5, 0, 0.5|', ' 1.5, 2.5, 1, 1.25, 0.125, 0.375|')
    deck = changed(deck, ' 0, 1, 1, 1, 0, 0.5|', ' 1, 3, 1, 1, 0, 0.5|')
    deck = changed(deck, '*PRESCRIBE| left, X, 0.01|', '')
    call reduced(deck, model, expansion, checks)
    call tests%check('a block with a smaller one on top is halved twice', size(expansion%steps) == 2 .and. &
      size(model%mesh%axes(1)%lines) == 5 .and. size(model%mesh%axes(3)%lines) == 2)
    call check_seeds(tests, deck, 'a block halved twice')
  end subroutine check_quarter

  !> A cylinder becomes a rectangle; its images have its volume and lie in it.
  subroutine check_figure(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: section(2, 4) = reshape([0.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], &
      [2, 4])
    class(analysis_type), allocatable :: analysis
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)
    class(model_type), allocatable :: model
    type(image_list_type) :: images
    type(error_type), allocatable :: error
    integer :: unit

    allocate (analysis, model)
    call write_stl(figure_file, turned_facets(section, 32, [1.0_wp, 1.0_wp]))
    call reduced(figure_deck(), analysis, expansion, checks)
    open (newunit=unit, file=figure_file, status='old')
    close (unit, status='delete')
    call tests%check('a quarter of a cylinder becomes axisymmetric', size(expansion%steps) == 1 .and. &
      analysis%model == axisymmetric .and. all(analysis%bodies%points_per_element == 4))
    call tests%close('forces come back by the sector', expansion%steps(1)%factor, 0.5_wp*pi, rounding)
    call tests%close('a history reads at its radius', analysis%histories(1)%at(1), 0.5_wp, rounding)
    call tests%close('a displacement along x by the cosine', history_of_scene(expansion, 1, 1.0_wp), 0.6_wp, rounding)
    call tests%close('a place along z by the sine', history_of_scene(expansion, 2, 0.5_wp), 1.4_wp, rounding)
    call tests%check('stress along z is that of the ring on the x axis', analysis%histories(4)%component == 3)
    call build_model(analysis, model, error)
    call tests%check('its model is built', .not. allocated(error))
    if (allocated(error)) return
    call make_images(expansion, model%state%points, grid_cells(model), images)
    call tests%close('the images have the volume of the quarter', sum(images%points%volume), &
      8.0_wp*sin(2.0_wp*pi/32)*0.5_wp, 1.0e-6_wp)
    call tests%check('they lie in the quarter', all(images%points%position([1, 3], :) > 1.0_wp) .and. &
      all(norm2(images%points%position([1, 3], :) - 1.0_wp, dim=1) < 1.0_wp))
    call check_folds(tests, expansion, model, images, 'a cylinder')
  end subroutine check_figure

  !> Rigid bodies of the smaller scenes, their loads and histories.
  subroutine check_pressed(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: section(2, 4) = reshape([0.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], &
      [2, 4])
    class(analysis_type), allocatable :: model
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)
    integer :: unit, i

    allocate (model)
    call reduced(pressed_slice(), model, expansion, checks)
    call tests%check('the surface of a contact stays', size(model%surfaces) == 1)
    call tests%close('the load on a slice of a body is one of unit thickness', model%phases(2)%moves(1)%load, -10.0_wp, 0.0_wp)
    call check_values(tests, 'a slice: force, moment, move along z', expansion, [0.5_wp, 0.5_wp, 0.0_wp])
    call reduced(pressed_layers(), model, expansion, checks)
    call tests%close('the load on a column', model%phases(1)%moves(1)%load, -2.0_wp, rounding)
    call check_values(tests, 'a column: force along y and x', expansion, [4.0_wp, 0.0_wp])
    call reduced(pressed_twins(), model, expansion, checks)
    call tests%check('the body beyond the plane is gone', size(model%rigid_bodies) == 2 .and. size(model%contacts) == 2 &
      .and. size(model%phases(1)%moves) == 2)
    call tests%close('half of the load of what crosses the plane', model%phases(1)%moves(1)%load, -3.0_wp, 0.0_wp)
    call check_values(tests, 'half: force y and x, move across; force x, moment beyond; move of the near one', expansion, &
      [2.0_wp, 0.0_wp, 1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp])
    call tests%check('a body beyond the plane is read from its image', all([(model%histories(i)%body == 'left cone', &
      i=4, 6)]))
    call tests%close('and a pressure from the image of its place', model%histories(7)%at(1), 1.8_wp, rounding)
    call write_stl(figure_file, turned_facets(section, 32, [1.0_wp, 1.0_wp]))
    call reduced(pressed_figure(), model, expansion, checks)
    open (newunit=unit, file=figure_file, status='old')
    close (unit, status='delete')
    call tests%close('a load per radian', model%phases(1)%moves(1)%load, -10.0_wp/pi, rounding)
    call tests%check('a body on the axis', norm2(model%rigid_bodies(1)%place - [0.0_wp, 1.0_wp, 0.0_wp]) < rounding)
    call check_values(tests, 'a quarter: force along the axis', expansion, [0.5_wp*pi])
  end subroutine check_pressed

  !> Values of the first histories of a scene for 1 in its model.
  subroutine check_values(tests, name, expansion, expected)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(expansion_type), intent(in) :: expansion
    real(wp), intent(in) :: expected(:)
    integer :: i

    do i = 1, size(expected)
      call tests%close(name, history_of_scene(expansion, i, 1.0_wp), expected(i), rounding)
    end do
  end subroutine check_values

  !> Numbers of the cells of all points in the whole grid.
  function grid_cells(model) result(cells)
    type(model_type), intent(in) :: model
    integer :: cells(model%state%points%count)

    cells = model%mesh%cell_label(model%state%points%cell)
  end function grid_cells

  !> Images fold back to their origins.
  subroutine check_folds(tests, expansion, model, images, name)
    type(tests_type), intent(inout) :: tests
    type(expansion_type), intent(in) :: expansion
    type(model_type), intent(in) :: model
    type(image_list_type), intent(in) :: images
    character(len=*), intent(in) :: name
    real(wp) :: place(3), sign(3), worst
    integer :: i, d

    d = model%mesh%dimension
    worst = 0.0_wp
    do i = 1, images%points%count
      place = images%points%position(:, i)
      call fold_place(expansion, place, sign)
      worst = max(worst, maxval(abs(place(:d) - model%state%points%position(:, images%origin(i)))))
    end do
    call tests%close('the images of '//name//' fold back', worst, 0.0_wp, rounding)
  end subroutine check_folds

  !> The images of the model's points are the points of the scene: one for one in place, volume, weight,
  !> cell, body and material.
  subroutine check_seeds(tests, deck, name)
    type(tests_type), intent(inout) :: tests
    !> The deck, and a name for it.
    character(len=*), intent(in) :: deck, name
    class(analysis_type), allocatable :: analysis, scene
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)
    type(message_list_type) :: messages
    class(model_type), allocatable :: model, whole
    type(image_list_type) :: images
    type(error_type), allocatable :: error
    logical, allocatable :: taken(:)
    real(wp) :: worst
    integer :: i, k, d

    allocate (analysis, scene, model, whole)
    call reduced(deck, analysis, expansion, checks)
    call build_model(analysis, model, error)
    if (.not. allocated(error)) call parse_deck('test.inp', deck, scene, messages, error)
    if (.not. allocated(error)) call build_model(scene, whole, error)
    call tests%check(name//' is built both ways', .not. allocated(error))
    if (allocated(error)) return
    call make_images(expansion, model%state%points, grid_cells(model), images)
    call tests%check('the images of '//name//' are fewer in the model and as many as in the scene', &
      images%points%count == whole%state%points%count .and. model%state%points%count < images%points%count)
    d = whole%mesh%dimension
    allocate (taken(whole%state%points%count), source=.false.)
    worst = 0.0_wp
    associate (points => whole%state%points)
      do i = 1, images%points%count
        k = minloc(sum(abs(points%position - spread(images%points%position(:d, i), 2, points%count)), dim=1), dim=1, &
          mask=.not. taken)
        taken(k) = .true.
        worst = max(worst, maxval(abs(points%position(:, k) - images%points%position(:d, i))), &
          abs(points%volume(k) - images%points%volume(i)), abs(points%weight(k) - images%points%weight(i)), &
          real(abs(whole%mesh%cell_label(points%cell(k)) - images%points%cell(i)) &
          + abs(points%body(k) - images%points%body(i)) + abs(points%material(k) - images%points%material(i)), wp))
      end do
    end associate
    ! Weights are 18 times volumes.
    call tests%close('the images of '//name//' are the points of the scene', worst, 0.0_wp, 20.0_wp*rounding)
    call check_folds(tests, expansion, model, images, name)
  end subroutine check_seeds

  !> A stress turns with its image: mirrored as R s R with R the reflection, turned about the axis with
  !> its invariants kept.
  subroutine check_stress(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: analysis
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)
    class(model_type), allocatable :: model
    type(image_list_type) :: images
    type(error_type), allocatable :: error
    integer :: i, n
    real(wp) :: trace, norm, worst(2)

    allocate (analysis, model)
    call reduced(twin_deck(), analysis, expansion, checks)
    call build_model(analysis, model, error)
    if (allocated(error)) return
    do i = 1, 4
      model%state%points%stress(i, :) = real(i, wp)
    end do
    call make_images(expansion, model%state%points, grid_cells(model), images)
    n = model%state%points%count
    call tests%close('the half keeps its stress', maxval(abs(images%points%stress(:, 1) - &
      [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 0.0_wp, 0.0_wp])), 0.0_wp, 0.0_wp)
    call tests%close('its image has the other shear', maxval(abs(images%points%stress(:, n + 1) - &
      [1.0_wp, 2.0_wp, 3.0_wp, -4.0_wp, 0.0_wp, 0.0_wp])), 0.0_wp, 0.0_wp)
    call tests%check('and the other sign along x', all(abs(images%sign(:, n + 1) - [-1.0_wp, 1.0_wp, &
      1.0_wp]) <= 0.0_wp))
    ! The same points about an axis: radial 1, vertical 2, ring 3, shear 4.
    expansion%steps(1)%kind = reduce_revolved
    expansion%steps(1)%sector = [0.0_wp, 2.0_wp*pi]
    expansion%steps(1)%lines(3)%lines = expansion%steps(1)%lines(1)%lines
    call make_images(expansion, model%state%points, grid_cells(model), images)
    worst = 0.0_wp
    do i = 1, images%points%count
      associate (s => images%points%stress(:, i), x => images%points%position(1, i), z => images%points%position(3, i))
        trace = sum(s(1:3))
        norm = sum(s(1:3)**2) + 2.0_wp*sum(s(4:6)**2)
        worst(1) = max(worst(1), abs(trace - 6.0_wp), abs(norm - 46.0_wp))
        ! The traction on a face along the radius is 1 along it.
        worst(2) = max(worst(2), abs((s(1)*x*x + 2.0_wp*s(5)*x*z + s(3)*z*z)/(x*x + z*z) - 1.0_wp))
      end associate
    end do
    call tests%close('a turned stress keeps its invariants', worst(1), 0.0_wp, 1.0e-12_wp)
    call tests%close('and its radial part', worst(2), 0.0_wp, 1.0e-12_wp)
  end subroutine check_stress

  !> The rollers of a column hold every node of it, yet its cells at the top of the mesh have a free face.
  subroutine check_open_edges(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: analysis
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)
    class(model_type), allocatable :: model
    type(error_type), allocatable :: error
    character(len=:), allocatable :: deck

    allocate (analysis, model)
    deck = changed(layers_deck(), ' Y, 0, 3, 6|', ' Y, 0, 2.5, 5|')
    call reduced(deck, analysis, expansion, checks)
    call build_model(analysis, model, error)
    call tests%check('a column up to the top of its mesh is built', .not. allocated(error))
    if (allocated(error)) return
    call start_phase(model)
    call tests%check('all of its nodes are held', all(any(model%loading%held, dim=1)))
    call tests%check('its top cell has a free face, the others have none', model%loading%open_edge(5) .and. &
      .not. any(model%loading%open_edge(:4)))
  end subroutine check_open_edges
end module test_scene_results
