!> What a run is told of soil inside of rigid bodies, of soil that presses on them from afar, of surfaces that have
!> folded, of forces that fall and of bodies that carry nothing: from which size on, and how often.
module test_penetration
  use qsmpm_analysis, only: analysis_type
  use qsmpm_contact_report, only: contact_check_type, begin_contact_check, check_contact, end_contact_check
  use qsmpm_contact_results, only: penetration_type, deepest_in, deepest_of_all, deepest_point
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_cam_clay, only: cam_clay_parameters_type
  use qsmpm_drucker_prager, only: drucker_prager_parameters_type
  use qsmpm_hoek_brown, only: flow_associated, hoek_brown_parameters_type
  use qsmpm_kept_arrays, only: keep_values, kept_arrays_type, lay_array
  use qsmpm_nodal_fields, only: rate_of
  use qsmpm_edge_failure, only: edge_strength
  use qsmpm_error, only: error_type
  use qsmpm_initialisation, only: step_type, initialise_step, begin_analysis
  use qsmpm_kinds, only: wp
  use qsmpm_linear_system, only: end_system
  use qsmpm_model, only: model_type
  use qsmpm_method_description, only: basis_fem, basis_spline2g
  use qsmpm_model_builder, only: build_model
  use qsmpm_penetration, only: penetration_check_type, refuse_penetration, warn_of_penetration
  use qsmpm_phase_description, only: phase_safety, phase_loading, phase_type
  use qsmpm_phase_start, only: start_phase
  use qsmpm_rigid_bodies, only: keep_rigid_body, placed_bodies
  use qsmpm_rigid_pose, only: placed_shape_type, rigid_pose_type
  use qsmpm_strength_factor, only: flow_davis_a, flow_material
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_sheared_ground, only: factor_note, fallen_note, flow_notes, loaded_spot_note, moved_note, sheared_note, spot_note, &
    swollen_note
  use qsmpm_team, only: team_type
  use qsmpm_undrained_parameters, only: drainage_dissipates
  use deck_samples, only: joined
  use scripted_solver, only: test_observer_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_penetration

  !> A block in cells of a quarter, on which a plane lies.
  character(len=*), parameter :: block = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 8|Y, 0, 2, 8|'// &
    '*NSET, NSET=base, PLANE=Y|0|*SURFACE, NAME=top, TYPE=SEGMENT|2, 1.1, 0, 1.1|*MATERIAL, NAME=soil|*ELASTIC|'// &
    '1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|0, 2, 0, 1.1|*RIGID BODY, NAME=plate, SHAPE=PLANE|'// &
    '0, 1.1, 0, -1|*CONTACT, BODY=plate, SURFACE=top|*PHASE, NAME=press|*FIX|base, ALL|*MOVE, BODY=plate|0, -0.01|'// &
    '*END PHASE|'
  real(wp), parameter :: cell = 0.25_wp

contains

  !> All tests of the suite.
  subroutine collect_penetration(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step

    allocate (model, step)
    call tests%start('penetration')
    call check_edge(tests)
    call make_model(model, step)
    call check_depth(tests, model)
    call check_gap(tests, model)
    call check_fold(tests, model)
    call check_waves(tests, model)
    call check_falls(tests, model)
    call check_rise(tests, model)
    call check_lost_reactions(tests, model)
    call check_knee(tests, model)
    call check_sheared(tests, model)
    model%state%progress%fraction = 1.0_wp
    call check_idle(tests, model)
    call check_touch(tests, model)
    call end_system(step%system)
    call check_others(tests)
  end subroutine collect_penetration

  !> What a strip at the edge of a load carries: N_c = 30.14, N_gamma = 22.40 for 30 degrees (Prandtl; Vesic 1973).
  subroutine check_edge(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: carried(2)

    carried = edge_strength(2.0_wp, 30.0_wp, 18.0_wp, [0.0_wp, 0.5_wp])
    call tests%close('an edge carries c Nc', carried(1), 2.0_wp*30.14_wp, 0.01_wp)
    call tests%close('a strip also gamma b N_gamma/2', carried(2) - carried(1), 18.0_wp*0.5_wp*22.40_wp/2.0_wp, 0.02_wp)
  end subroutine check_edge

  !> Of two bodies each has the distance of its own surface, and the first point of a surface may be the nearest.
  subroutine check_others(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: idle = "moves rigid body 'other', and nothing is in contact with it: the "// &
      "nearest soil of its "// &
      '*CONTACT is '
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    integer :: first

    allocate (model, step)
    ! The surface of the other one lies 0.3 below that of the plate, and comes first.
    call make_model(model, step, '*SURFACE, NAME=low, TYPE=SEGMENT|2, 0.8, 0, 0.8|*RIGID BODY, NAME=other, SHAPE=PLANE|'// &
      '0, 1.1, 0, -1|*CONTACT, BODY=other, SURFACE=low|', 'other')
    model%state%progress%fraction = 1.0_wp
    call tests%close('the nearest soil of its own surface', told_of_other(), 1.0_wp, 0.0_wp)
    first = findloc(model%state%surface%surface, model%contact_pairs(2)%surface, dim=1)
    model%state%surface%position(2, first) = 0.9_wp
    call tests%close('the first point', told_of_other('0.7 away'), 1.0_wp, 0.0_wp)
    allocate (model%part%surface(size(model%state%surface%surface)), source=.true.)
    model%part%surface(first) = .false.
    call tests%close('unless it is of another process', told_of_other('0.8 away'), 1.0_wp, 0.0_wp)
    deallocate (model%part%surface)
    model%state%surface%position(2, first) = 0.8_wp
    model%state%surface%position(2, size(model%state%surface%surface)) = 0.9_wp
    call tests%close('the last point, of whichever surface', told_of_other(merge('0.7 away', '0.8 away', &
      model%state%surface%surface(size(model%state%surface%surface)) == model%contact_pairs(2)%surface)), 1.0_wp, 0.0_wp)
    call end_system(step%system)

  contains

    !> How often it is said that the other body has come from 0.6 to 0.5 above its place, and so far away.
    real(wp) function told_of_other(distance)
      !> 0.8 when absent.
      character(len=*), intent(in), optional :: distance
      type(contact_check_type) :: check
      integer :: i

      do i = 0, 1
        call keep_rigid_body(model, 2, rigid_pose_type([0.0_wp, 0.6_wp - 0.1_wp*i, 0.0_wp]), spread(0.0_wp, 1, 6))
        if (i == 0) call begin_contact_check(model, check)
      end do
      call check_contact(model, check)
      if (present(distance)) then
        told_of_other = ended(model, check, idle//distance)
      else
        told_of_other = ended(model, check, idle//'0.8 away')
      end if
    end function told_of_other
  end subroutine check_others

  !> The block before its first step.
  subroutine make_model(model, step, more, moved)
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    !> Cards before those of the phase, and the body that it moves instead of the plate.
    character(len=*), intent(in), optional :: more, moved
    character(len=:), allocatable :: cards
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    cards = block
    if (present(more)) cards = block(:index(block, '*PHASE') - 1)//more//block(index(block, '*PHASE'):)
    call parse_deck('block.inp', joined(cards), analysis, messages, error)
    if (present(moved) .and. .not. allocated(error)) analysis%phases(1)%moves(1)%body = moved
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the deck of the penetration suite is broken'
    call begin_analysis(model, step%terms)
    call start_phase(model)
    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'a step of the penetration suite cannot be made'
  end subroutine make_model

  !> A tenth of a cell is warned of, then what is twice as deep as the last.
  subroutine check_depth(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(in) :: model
    type(penetration_check_type) :: check
    type(penetration_type) :: found

    found%body = 1
    found%depth = 0.09_wp*cell
    call tests%close('0.09 cells inside', said(model, found, check, "inside rigid body 'plate'"), 0.0_wp, 0.0_wp)
    found%depth = 0.11_wp*cell
    found%deepest = [0.5_wp, 0.25_wp, 0.0_wp]
    call tests%close('0.11 cells inside', said(model, found, check, 'soil at 5.0000E-01  2.5000E-01 is 0.11 cells inside '// &
      'rigid body '// &
      "'plate'; the surface of its *CONTACT must extend to that place"), 1.0_wp, 0.0_wp)
    found%depth = 0.21_wp*cell
    call tests%close('0.21 cells are not twice as deep', said(model, found, check, 'inside'), 0.0_wp, 0.0_wp)
    found%depth = 0.23_wp*cell
    call tests%close('0.23 are', said(model, found, check, '0.23 cells inside'), 1.0_wp, 0.0_wp)
  end subroutine check_depth

  !> Three quarters of a cell are warned of, then what is twice as far as the last.
  subroutine check_gap(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(in) :: model
    type(penetration_check_type) :: check
    type(penetration_type) :: found

    found%pressed = 1
    found%gap = 0.74_wp*cell
    call tests%close('0.74 cells away', said(model, found, check, "presses on rigid body 'plate'"), 0.0_wp, 0.0_wp)
    found%gap = 0.76_wp*cell
    call tests%close('0.76 cells away', said(model, found, check, "soil presses on rigid body 'plate' from 0.76 cells "// &
      'away'), 1.0_wp, 0.0_wp)
    found%gap = 1.5_wp*cell
    call tests%close('1.5 cells are not twice as far', said(model, found, check, 'presses'), 0.0_wp, 0.0_wp)
    found%gap = 1.53_wp*cell
    call tests%close('1.53 are', said(model, found, check, '1.53 cells away'), 1.0_wp, 0.0_wp)
  end subroutine check_gap

  !> A piece of the surface in contact whose outward normal is that of the body is warned of, once.
  subroutine check_fold(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    character(len=*), parameter :: words = "folded at rigid body 'plate'"
    type(penetration_check_type) :: check
    type(penetration_type) :: found
    character(len=11) :: where_first

    model%state%surface%area_vector(:, 3) = -model%state%surface%area_vector(:, 3)
    call tests%close('a surface that is folded where nothing presses', said(model, found, check, words), 0.0_wp, 0.0_wp)
    model%state%surface%contact_pressure(1) = 5.0_wp
    call tests%close('one that presses where it is not', said(model, found, check, words), 0.0_wp, 0.0_wp)
    model%state%surface%contact_pressure(3) = 5.0_wp
    call tests%close('one that presses where it is', said(model, found, check, words), 1.0_wp, 0.0_wp)
    call tests%close('again', said(model, found, check, words), 0.0_wp, 0.0_wp)
    ! Turned by 80 degrees the area vector has 0.17 of its length along the body's normal.
    check%reported_fold = .false.
    model%state%surface%area_vector(:, 3) = [0.98_wp, -0.17_wp]
    call tests%close('a steep one is not folded', said(model, found, check, words), 0.0_wp, 0.0_wp)
    model%state%surface%area_vector(:, 3:4) = -model%state%surface%area_vector(:, [5, 5])
    model%state%surface%contact_pressure(4) = 5.0_wp
    write (where_first, '(es11.4)') model%state%surface%position(1, 3)
    call tests%close('of two the first is named', said(model, found, check, where_first), 1.0_wp, 0.0_wp)
  end subroutine check_fold

  !> Falls by more than a twentieth that stay are counted and the worst is named, once, where the phase ends; what is no
  !> push resists nothing, and what is next to nothing falls as it likes.
  subroutine check_falls(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    character(len=*), parameter :: falls = "warning: phase 'press' moves rigid body 'plate': the force against its "// &
      'motion falls by more than 5 % and stays low in '
    type(contact_check_type) :: check

    call begin_contact_check(model, check)
    call go(model, check, [100.0_wp, 100.0_wp, 94.9_wp, 94.9_wp, 90.2_wp, 80.0_wp, 80.0_wp, 76.1_wp])
    call tests%close('falls by 5.1, 5.0, 11 and 4.9 %', ended(model, check, falls//'2 of 8 steps, the most in step 6, '// &
      'from 90.2 to 80: '), 1.0_wp, 0.0_wp)
    call tests%close('they are told once', ended(model, check, falls), 0.0_wp, 0.0_wp)
    call go(model, check, [128.0_wp, 128.0_wp, 0.95_wp*128.0_wp, 0.95_wp*128.0_wp])
    call tests%close('a fall by 5 % and no more', ended(model, check, falls), 0.0_wp, 0.0_wp)
    call go(model, check, [128.0_wp, 128.0_wp, 100.0_wp, 0.95_wp*128.0_wp])
    call tests%close('one that is back but for 5 %', ended(model, check, falls), 0.0_wp, 0.0_wp)
    call go(model, check, [100.0_wp, 110.0_wp, 100.0_wp, 100.0_wp, 94.0_wp, 95.1_wp, 90.5_wp])
    call tests%close('a peak and dips of one step', ended(model, check, falls), 0.0_wp, 0.0_wp)
    call go(model, check, [100.0_wp, 100.0_wp, 90.0_wp, 94.9_wp, 90.0_wp])
    call tests%close('one that is not quite back', ended(model, check, falls//'1 of 5 steps, the most in step 3, from '// &
      '100 to 90: '), 1.0_wp, 0.0_wp)
    call go(model, check, [100.0_wp, 100.0_wp, 90.0_wp])
    call tests%close('the last step', ended(model, check, falls//'1 of 3 steps'), 1.0_wp, 0.0_wp)
    call go(model, check, [100.0_wp, 100.0_wp, 80.0_wp, 80.0_wp, 80.0_wp, 72.0_wp, 72.0_wp])
    call tests%close('the larger of two is the first', ended(model, check, falls//'2 of 7 steps, the most in step 3, '// &
      'from 100 to 80: '), 1.0_wp, 0.0_wp)
    call go(model, check, [50.0_wp, 5.1_wp, 4.0_wp, 1.0_wp, 0.0_wp])
    call tests%close('what is below a tenth falls further', ended(model, check, falls//'1 of 5 steps, the most in step '// &
      '3, from 5.1 to 4: '), 1.0_wp, 0.0_wp)
    call go(model, check, [-50.0_wp, -90.0_wp, -95.0_wp, 0.0_wp, -3.0_wp, -4.0_wp])
    call tests%close('soil that pushes on', ended(model, check, falls), 0.0_wp, 0.0_wp)
    call go(model, check, [20.0_wp, 20.0_wp, 0.0_wp, 0.0_wp])
    call tests%close('a push that carries no more', ended(model, check, falls//'1 of 4 steps'), 1.0_wp, 0.0_wp)
    call go(model, check, [1.0_wp, 1.0_wp, 1.0_wp], across=50.0_wp)
    call go(model, check, [1.0_wp, 1.0_wp, 1.0_wp], across=0.0_wp)
    call tests%close('a force across that goes', ended(model, check, falls), 0.0_wp, 0.0_wp)
  end subroutine check_falls

  !> A body whose force rises by more than a tenth within a quarter of a cell after the ground has failed.
  subroutine check_rise(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    character(len=*), parameter :: rises = "moves rigid body 'plate': the force against its motion has risen by "
    type(contact_check_type) :: check
    real(wp) :: way
    integer :: basis

    way = norm2(model%analysis%phases(1)%moves(1)%vector)
    call push_down([20.0_wp, 40.0_wp, 60.0_wp, 61.0_wp, 66.0_wp, 73.0_wp], 0.25_wp)
    call tests%close('a fifth more in a quarter of a cell', ended(model, check, rises//'20 % within a quarter of a cell'), &
      1.0_wp, 0.0_wp)
    call push_down([20.0_wp, 40.0_wp, 60.0_wp, 61.0_wp, 66.0_wp, 73.0_wp], 0.9_wp)
    call tests%close('in a longer way the body is deeper', ended(model, check, rises), 0.0_wp, 0.0_wp)
    call push_down([20.0_wp, 40.0_wp, 60.0_wp, 61.0_wp, 64.0_wp, 66.0_wp], 0.25_wp)
    call tests%close('a rise of 8 % is none', ended(model, check, rises), 0.0_wp, 0.0_wp)
    model%state%progress%fraction = 0.0_wp
    basis = model%analysis%method%basis
    model%analysis%materials%mohr_coulomb = .true.
    model%analysis%method%basis = basis_spline2g
    call push_down([20.0_wp, 40.0_wp, 60.0_wp, 61.0_wp], 0.25_wp)
    call tests%close('splines smooth the slip surface below it', ended(model, check, "moves rigid body 'plate': soil in "// &
      'contact is '), 1.0_wp, 0.0_wp)
    call push_down([-60.0_wp, -42.0_wp, -40.0_wp, -39.0_wp], 0.25_wp)
    call tests%close('ground that follows a wall', ended(model, check, '% too low; use smaller cells'), 1.0_wp, 0.0_wp)
    model%analysis%method%basis = basis_fem
    call push_down([20.0_wp, 40.0_wp, 60.0_wp, 61.0_wp], 0.25_wp)
    call tests%close('triangles do not', ended(model, check, 'soil in contact is'), 0.0_wp, 0.0_wp)
    model%analysis%method%basis = basis
    model%analysis%materials%mohr_coulomb = .false.
    model%state%progress%fraction = 0.0_wp

  contains

    !> Steps of even length in a part of the phase, in which the body moves so many cells.
    subroutine push_down(forces, cells)
      real(wp), intent(in) :: forces(:), cells
      integer :: i

      model%state%progress%fraction = 0.0_wp
      call place(model, 0, [0.0_wp, 0.0_wp])
      call begin_contact_check(model, check)
      do i = 1, size(forces)
        model%state%progress%fraction = cells*model%cell_size/way*i/size(forces)
        call place(model, i, [0.0_wp, forces(i)])
        call check_contact(model, check)
      end do
    end subroutine push_down
  end subroutine check_rise

  !> A mean reaction along what is prescribed that falls by more than half and stays low is told; what is no force at
  !> the stiffness of the soil may fall.
  subroutine check_lost_reactions(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    character(len=*), parameter :: falls = "warning: phase 'press': the mean reaction along its prescribed "// &
      "displacement falls "// &
      'by more than 50 % and stays low in '
    type(contact_check_type) :: check

    call place(model, 0, [0.0_wp, 0.0_wp])
    call begin_contact_check(model, check)
    call push(model, check, [50.0_wp, 50.0_wp, 24.0_wp, 24.0_wp])
    call tests%close('a reaction that falls by 52 %', ended(model, check, falls//'1 of 4 steps, the most in step 3, '// &
      'from 50 to 24: '), 1.0_wp, 0.0_wp)
    call begin_contact_check(model, check)
    call push(model, check, [50.0_wp, 50.0_wp, 26.0_wp, 26.0_wp])
    call tests%close('by 48 %', ended(model, check, falls), 0.0_wp, 0.0_wp)
    ! 1e-4 of the stiffness times the face of a cell is 0.025.
    call begin_contact_check(model, check)
    call push(model, check, [0.03_wp, 0.03_wp, 0.001_wp, 0.001_wp])
    call tests%close('a little more than no force', ended(model, check, falls), 1.0_wp, 0.0_wp)
    call begin_contact_check(model, check)
    call push(model, check, [0.02_wp, 0.02_wp, 0.001_wp, 0.001_wp])
    call tests%close('no force', ended(model, check, falls), 0.0_wp, 0.0_wp)
    ! As if another process had the second node: -f/2 at the first one is the mean.
    allocate (model%part%nodes(size(model%state%reactions, 2)), source=.true.)
    model%part%nodes(2) = .false.
    call begin_contact_check(model, check)
    call push(model, check, [100.0_wp, 100.0_wp, 48.0_wp, 48.0_wp])
    call tests%close('the mean of nodes of its own', ended(model, check, falls//'1 of 4 steps, the most in step 3, '// &
      'from 50 to 24: '), 1.0_wp, 0.0_wp)
    deallocate (model%part%nodes)
    model%loading%prescribed = 0.0_wp
    model%state%reactions = 0.0_wp
  end subroutine check_lost_reactions

  !> Ground that gives way under what is prescribed: its load is said to be that of the grid, and of clay on a mesh that
  !> goes with it a rise by more than a tenth is warned of. A phase that begins with a force goes on from it.
  subroutine check_knee(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    character(len=*), parameter :: of_grid = 'the load at failure depends on the grid', &
      rises = 'the mean reaction along its prescribed displacement has risen by '
    type(contact_check_type) :: check
    integer :: basis

    basis = model%analysis%method%basis
    model%analysis%method%basis = basis_fem
    model%analysis%materials%mohr_coulomb = .true.
    call go([20.0_wp, 40.0_wp, 60.0_wp, 61.0_wp, 66.0_wp, 73.0_wp], 0)
    call tests%close('clay that gives way at 61', ended(model, check, of_grid), 1.0_wp, 0.0_wp)
    call go([20.0_wp, 40.0_wp, 60.0_wp, 61.0_wp, 66.0_wp, 73.0_wp], 0)
    call tests%close('and carries a fifth more', ended(model, check, rises//'20 % since the ground failed'), 1.0_wp, 0.0_wp)
    call go([20.0_wp, 40.0_wp, 60.0_wp, 61.0_wp, 63.0_wp, 66.0_wp], 0)
    call tests%close('a rise of 8 %', ended(model, check, of_grid), 1.0_wp, 0.0_wp)
    call go([20.0_wp, 40.0_wp, 60.0_wp, 61.0_wp, 63.0_wp, 66.0_wp], 0)
    call tests%close('is none', ended(model, check, rises), 0.0_wp, 0.0_wp)
    call go([20.0_wp, 40.0_wp, 60.0_wp, 75.0_wp, 84.0_wp, 90.0_wp], 0)
    call tests%close('a slope that falls to a third is no failure', ended(model, check, of_grid), 0.0_wp, 0.0_wp)
    call go([20.0_wp, 40.0_wp, 41.0_wp, 42.0_wp, 43.0_wp, 44.0_wp], 3)
    call tests%close('a phase taken up again at half of it, from its slope there', ended(model, check, of_grid), 0.0_wp, &
      0.0_wp)
    model%analysis%materials%friction_angle = 20.0_wp
    call go([20.0_wp, 40.0_wp, 60.0_wp, 61.0_wp, 66.0_wp, 73.0_wp], 0)
    call tests%close('sand may also carry more at depth', ended(model, check, rises//'20 % since the ground failed: '// &
      'cells beside the prescribed nodes are dragged along and restrain the soil (soil with friction'), 1.0_wp, 0.0_wp)
    model%analysis%materials%friction_angle = 0.0_wp
    model%analysis%materials%mohr_coulomb = .false.
    call go([20.0_wp, 40.0_wp, 60.0_wp, 61.0_wp, 66.0_wp, 73.0_wp], 0)
    call tests%close('what cannot yield does not give way', ended(model, check, of_grid), 0.0_wp, 0.0_wp)
    model%analysis%method%basis = basis
    model%loading%prescribed = 0.0_wp
    model%state%reactions = 0.0_wp
    model%state%progress%fraction = 0.0_wp

  contains

    !> Steps of even length with such forces, the first ones before the check begins.
    subroutine go(forces, before)
      real(wp), intent(in) :: forces(:)
      integer, intent(in) :: before
      real(wp) :: start
      integer :: i

      start = 0.0_wp
      if (before > 0) start = forces(before)
      model%loading%prescribed(2, [1, 2]) = [-0.01_wp, -0.03_wp]
      model%state%progress%fraction = real(before, wp)/size(forces)
      model%state%reactions(2, [1, 2]) = start*[-0.5_wp, -7.0_wp/6.0_wp]
      call begin_contact_check(model, check)
      do i = before + 1, size(forces)
        model%state%progress%fraction = real(i, wp)/size(forces)
        call push_once(model, check, i, forces(i))
      end do
    end subroutine go
  end subroutine check_knee

  !> Two waves and more are told with the largest; one alone, flat ones and a fall that stays are no waves.
  subroutine check_waves(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    character(len=*), parameter :: waves = 'falls and rises again '
    type(contact_check_type) :: check

    call begin_contact_check(model, check)
    call go(model, check, [100.0_wp, 94.0_wp, 97.0_wp, 91.0_wp, 88.0_wp, 94.0_wp])
    call tests%close('two waves by 6 and 9 %', ended(model, check, waves//'2 times, the most from 97 to 88: '), 1.0_wp, &
      0.0_wp)
    call tests%close('they are told once', ended(model, check, waves), 0.0_wp, 0.0_wp)
    call go(model, check, [100.0_wp, 91.0_wp, 96.0_wp, 90.5_wp, 94.0_wp])
    call tests%close('two waves by 9 and 5.5 %', ended(model, check, waves//'2 times, the most from 100 to 91: '), 1.0_wp, &
      0.0_wp)
    call go(model, check, [100.0_wp, 94.0_wp, 97.0_wp, 98.0_wp, 99.0_wp])
    call tests%close('one wave', ended(model, check, waves), 0.0_wp, 0.0_wp)
    call go(model, check, [100.0_wp, 94.0_wp, 97.0_wp, 103.0_wp, 109.0_wp, 115.0_wp])
    call tests%close('one wave, and a force that rises on', ended(model, check, waves), 0.0_wp, 0.0_wp)
    call go(model, check, [100.0_wp, 94.0_wp, 100.0_wp, 100.0_wp, 100.0_wp])
    call tests%close('one wave that is back in a step', ended(model, check, waves), 0.0_wp, 0.0_wp)
    call go(model, check, [100.0_wp, 95.1_wp, 100.0_wp, 95.1_wp, 100.0_wp])
    call tests%close('waves by 4.9 %', ended(model, check, waves), 0.0_wp, 0.0_wp)
    call go(model, check, [100.0_wp, 94.0_wp, 96.4_wp, 90.0_wp, 92.4_wp, 91.0_wp])
    call tests%close('falls of which less than half comes back', ended(model, check, waves), 0.0_wp, 0.0_wp)
    call go(model, check, -[20.0_wp, 33.0_wp, 20.0_wp, 33.0_wp, 20.0_wp])
    call tests%close('soil that follows a wall resists nothing', ended(model, check, waves), 0.0_wp, 0.0_wp)
  end subroutine check_waves

  !> Steps with so large a mean reaction at two nodes of which one goes three times as far.
  subroutine push(model, check, forces)
    type(model_type), intent(inout) :: model
    type(contact_check_type), intent(inout) :: check
    real(wp), intent(in) :: forces(:)
    integer :: i

    model%loading%prescribed = 0.0_wp
    model%loading%prescribed(2, [1, 2]) = [-0.01_wp, -0.03_wp]
    do i = 1, size(forces)
      call push_once(model, check, i, forces(i))
    end do
  end subroutine push

  !> One of them.
  subroutine push_once(model, check, step, force)
    type(model_type), intent(inout) :: model
    type(contact_check_type), intent(inout) :: check
    integer, intent(in) :: step
    real(wp), intent(in) :: force

    call place(model, step, [0.0_wp, 0.0_wp])
    model%state%reactions = 0.0_wp
    ! The mean of -f/2 and -7 f/6 by a quarter and three quarters is -f.
    model%state%reactions(2, [1, 2]) = force*[-0.5_wp, -7.0_wp/6.0_wp]
    call check_contact(model, check)
  end subroutine push_once

  !> Soil that has sheared by more than a tenth in more than 0.2 % of its volume has flowed before the search.
  subroutine check_sheared(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    real(wp), dimension(model%state%points%count) :: volume, initial

    volume = model%state%points%volume
    initial = model%state%points%initial_volume
    call tests%check('the points carry strains', size(model%state%points%plastic_strain) > 0)
    model%state%points%plastic_strain = 0.05_wp
    call tests%check('soil that yields and stands', len(sheared_note(model)) == 0)
    model%state%points%plastic_strain(1) = 0.29_wp
    model%state%points%volume(1) = 1.0e-3_wp*sum(volume(2:))
    model%state%points%initial_volume(1) = model%state%points%volume(1)
    call tests%check('a corner that flows', len(sheared_note(model)) == 0)
    model%state%points%initial_position = model%state%points%position
    call tests%check('nothing gives way', len(spot_note(model)) == 0)
    model%state%points%initial_position(1, 1) = model%state%points%position(1, 1) - 0.1_wp
    call tests%check('a corner gives way: '//spot_note(model), index(spot_note(model), "phase 'press': the mechanism "// &
      'involves 0.1 % of the ground, around (') > 0)
    model%state%points%initial_position(1, 2:) = model%state%points%position(1, 2:) - 0.011_wp
    call tests%check('and all of the ground with it', len(spot_note(model)) == 0)
    call check_loaded_spot(tests, model)
    model%state%points%initial_position = model%state%points%position
    model%state%points%volume(1) = 4.0e-3_wp*sum(volume(2:))
    model%state%points%initial_position(:, 2) = model%state%points%position(:, 2) - [0.3_wp, 0.4_wp]
    call tests%check('soil that flows; found: '//sheared_note(model), index(sheared_note(model), "phase 'press': "// &
      'before the search soil has sheared by up to 0.29, 0.4 % of it by more than 0.1') > 0 .and. &
      index(sheared_note(model), 'up to 0.5 away') > 0)
    allocate (cam_clay_parameters_type :: model%analysis%materials(1)%soil_law)
    call tests%check('clay that hardens on its way', len(sheared_note(model)) == 0)
    deallocate (model%analysis%materials(1)%soil_law)
    model%state%points%initial_volume(1) = exp(0.2_wp)*model%state%points%volume(1)
    call tests%check('soft soil that has settled by a fifth', len(sheared_note(model)) == 0)
    model%state%points%initial_volume = initial
    model%state%points%initial_position(:, 2) = model%state%points%position(:, 2)
    model%state%points%plastic_strain = 0.0_wp
    model%state%points%volume = volume
    call check_fallen(tests, model)
    call check_flow(tests, model)
    call check_swollen(tests, model)
    model%state%points%volume = volume
  end subroutine check_sheared

  !> Ground that has sheared, and whose last step moves ten times as far for its load as the first one, has fallen; a
  !> phase that looks for its limit load, or its factor, says so itself.
  subroutine check_fallen(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    type(phase_type) :: kept

    associate (limit => model%state%progress%limit, phase => model%analysis%phases(model%state%progress%phase))
      limit%first = 0.5_wp
      limit%most = 10.0_wp
      limit%passed = 0.25_wp
      call tests%check('soft on the way, and nothing has sheared', len(fallen_note(model)) == 0)
      model%state%points%plastic_strain = 0.2_wp
      call tests%check('fallen: '//fallen_note(model), index(fallen_note(model), "phase 'press': soil has sheared by up "// &
        'to 0.2') > 0 .and. index(fallen_note(model), '20 times as far as in the first step') > 0 .and. &
        index(fallen_note(model), 'about load factor '//rounded_text(0.25_wp*phase%load_factor, 3)//' on this grid by the '// &
        'compliance') > 0)
      limit%passed = -0.25_wp
      call tests%check('a mesh that was left before', index(fallen_note(model), ', above load factor '// &
        rounded_text(0.25_wp*phase%load_factor, 3)//', beyond which the background grid') > 0)
      limit%passed = 0.0_wp
      phase%controls%limit_compliance = 10.0_wp
      call tests%check('a phase that asks for its limit load', len(fallen_note(model)) == 0)
      phase%controls%limit_compliance = 0.0_wp
      phase%kind = phase_safety
      call tests%check('and one that looks for a factor', len(fallen_note(model)) == 0)
      phase%kind = phase_loading
      kept = phase
      phase%moves = phase%moves(:0)
      call tests%check('ground that drains or creeps', len(fallen_note(model)) == 0)
      phase%consolidation%given = .true.
      call tests%check('and whose *CONSOLIDATION begins', len(fallen_note(model)) == 0)
      phase = kept
      limit%most = 4.9_wp
      call tests%check('nine times as soft', len(fallen_note(model)) == 0)
      limit%first = 0.0_wp
      limit%last = 0.0_wp
    end associate
    model%state%points%plastic_strain = 0.0_wp
  end subroutine check_fallen

  !> What the last step below a limit load has moved: all of the ground, or the first cell, which is next to nothing of it.
  subroutine check_loaded_spot(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    type(kept_arrays_type) :: kept
    real(wp) :: rates(model%mesh%dimension, model%space%node_count), volume(model%state%points%count)

    kept = model%state%kept
    volume = model%state%points%volume
    rates = 1.0_wp
    call lay_array(model%state%kept, rate_of//'displacement', rates, .true.)
    call keep_values(model%state%kept, rate_of//'displacement', rates)
    call tests%check('all of the ground moves', len(loaded_spot_note(model)) == 0)
    rates(:, 2:) = 0.0_wp
    call keep_values(model%state%kept, rate_of//'displacement', rates)
    call tests%check('a cell of 64 does', len(loaded_spot_note(model)) == 0)
    where (model%state%points%cell == 1) model%state%points%volume = 1.0e-3_wp*model%state%points%volume
    call tests%check('a spot does; found: '//loaded_spot_note(model), index(loaded_spot_note(model), 'the mechanism involves') &
      > 0 .and. index(loaded_spot_note(model), 'the limit load is that of a local failure') > 0)
    model%state%points%volume = volume
    model%state%kept = kept
  end subroutine check_loaded_spot

  !> Soil that fails with psi far below phi is told with the strength of Davis: of phi = 30 and psi = 0 tan(phi*) = sin(phi).
  subroutine check_flow(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model

    model%state%points%plastic_strain = 0.011_wp
    call tests%check('elastic soil', len(flow_notes(model)) == 0)
    associate (soil => model%analysis%materials(1), phase => model%analysis%phases(model%state%progress%phase))
      soil%mohr_coulomb = .true.
      soil%cohesion = 2.0_wp
      soil%friction_angle = 30.0_wp
      call tests%check('it fails; found: '//flow_notes(model), index(flow_notes(model), "material 'soil' fails and "// &
        'flows at psi = 0 below phi = 30') > 0 .and. index(flow_notes(model), 'phi = psi = 26.6, c = 1.73 (Davis)') > 0)
      call tests%check('its factor is one of several; found: '//factor_note(model, flow_material), &
        index(factor_note(model, flow_material), "'soil' flows at psi = 0 below phi = 30: the factor is then not") == 1)
      model%state%progress%bracket%stable = 1.2_wp
      call tests%check('which is at least cos(30) of it', index(factor_note(model, flow_material), &
        'not unique; after Davis it may be as low as 1.039') > 0)
      call tests%check('not that of the strength of Davis', len(factor_note(model, flow_davis_a)) == 0)
      call tests%check('ground that has hardly moved', len(moved_note(model)) == 0)
      model%state%points%initial_position(2, :) = model%state%points%initial_position(2, :) + 0.1_wp
      call tests%check('ground that has settled by 0.1; found: '//moved_note(model), &
        index(moved_note(model), 'deformed ground, which has moved by up to 0.1') > 0)
      model%state%points%initial_position(2, :) = model%state%points%initial_position(2, :) - 0.1_wp
      soil%undrained%given = .true.
      call tests%check('undrained soil', len(flow_notes(model)) == 0)
      call tests%check('whose factor is the only one', len(factor_note(model, flow_material)) == 0)
      allocate (soil%undrained%drainage(size(model%analysis%phases)), source=drainage_dissipates)
      call tests%check('unless it is drained in the phase', len(factor_note(model, flow_material)) > 0)
      soil%undrained%given = .false.
      soil%dilatancy_angle = 25.0_wp
      call tests%check('psi near phi', len(flow_notes(model)) == 0)
      soil%dilatancy_angle = 0.0_wp
      phase%kind = phase_safety
      call tests%check('a search for a factor', len(flow_notes(model)) == 0)
      phase%kind = phase_loading
      model%state%points%plastic_strain = 0.01_wp
      call tests%check('soil that does not fail yet', len(flow_notes(model)) == 0)
      soil%mohr_coulomb = .false.
      soil%friction_angle = 0.0_wp
      soil%cohesion = 0.0_wp
      model%state%points%plastic_strain = 0.011_wp
      allocate (soil%soil_law, source=drucker_prager_parameters_type(friction_angle=30.0_wp, cohesion=2.0_wp))
      call tests%check('a cone; found: '//flow_notes(model), index(flow_notes(model), 'flows at psi = 0 below phi = 30') > 0)
      deallocate (soil%soil_law)
      allocate (soil%soil_law, source=hoek_brown_parameters_type(dilatancy_angle=5.0_wp))
      call tests%check('rock; found: '//flow_notes(model)//factor_note(model, flow_material), index(flow_notes(model), &
        'flows at psi = 5 far below its friction: its limit load is not unique; one with FLOW=ASSOCIATED shows') &
        > 0 .and. index(factor_note(model, flow_material), 'is then not unique') > 0)
      deallocate (soil%soil_law)
      allocate (soil%soil_law, source=hoek_brown_parameters_type(flow=flow_associated))
      call tests%check('rock whose flow is normal', len(flow_notes(model)//factor_note(model, flow_material)) == 0)
      deallocate (soil%soil_law)
    end associate
    model%state%points%plastic_strain = 0.0_wp
  end subroutine check_flow

  !> Soil that yields and has grown by half of its volume has a dilatancy without end.
  subroutine check_swollen(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    integer :: plastic

    plastic = model%state%points%plastic(3)
    model%state%points%volume = model%state%points%initial_volume
    model%state%points%plastic(3) = 1
    model%state%points%volume(3) = 1.49_wp*model%state%points%initial_volume(3)
    call tests%check('soil that dilates', len(swollen_note(model)) == 0)
    model%state%points%volume(3) = 3.34_wp*model%state%points%initial_volume(3)
    call tests%check('soil that swells; found: '//swollen_note(model), index(swollen_note(model), &
      "phase 'press': shearing soil has dilated to 3.34 times its volume") > 0)
    associate (soil => model%analysis%materials(model%state%points%material(3)))
      soil%mohr_coulomb = .true.
      soil%dilatancy_angle = 0.0_wp
      soil%tensile_strength = 0.0_wp
      call tests%check('what has no dilatancy and no tensile strength has cracked; found: '//swollen_note(model), &
        index(swollen_note(model), "phase 'press': cracks have opened soil to 3.34 times its volume") > 0 .and. &
        index(swollen_note(model), 'dilatancy') == 0)
      soil%tensile_strength = huge(1.0_wp)
      call tests%check('so has what has no dilatancy and no cut-off; found: '//swollen_note(model), &
        index(swollen_note(model), 'cracks have opened') > 0 .and. index(swollen_note(model), 'dilatancy') == 0)
      soil%dilatancy_angle = 1.0_wp
      call tests%check('with a dilatancy it swells', index(swollen_note(model), 'has dilated to 3.34') > 0)
    end associate
    call check_both(tests, model)
    model%state%points%plastic(3) = 0
    call tests%check('what is elastic does not swell', len(swollen_note(model)) == 0)
    model%state%points%plastic(3) = plastic
  end subroutine check_swollen

  !> Soil that swells, at point 3, beside other soil that cracks: both are told.
  subroutine check_both(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(in) :: model
    class(model_type), allocatable :: two

    allocate (two)
    two = model
    two%analysis%materials = [model%analysis%materials, model%analysis%materials(1)]
    associate (other => two%analysis%materials(size(two%analysis%materials)), points => two%state%points)
      other%mohr_coulomb = .true.
      other%dilatancy_angle = 0.0_wp
      other%tensile_strength = 0.0_wp
      points%material(4) = size(two%analysis%materials)
      points%plastic(4) = 1
      points%volume(4) = 2.0_wp*points%initial_volume(4)
    end associate
    call tests%check('swelling and cracks: '//swollen_note(two), index(swollen_note(two), 'has dilated to 3.34 times') > 0 &
      .and. index(swollen_note(two), 'opened soil to 2 times') > 0)
  end subroutine check_both

  !> Steps with so much force against the motion.
  subroutine go(model, check, forces, across)
    type(model_type), intent(inout) :: model
    type(contact_check_type), intent(inout) :: check
    real(wp), intent(in) :: forces(:)
    real(wp), intent(in), optional :: across
    real(wp) :: other
    integer :: i

    other = 0.0_wp
    if (present(across)) other = across
    do i = 1, size(forces)
      call place(model, i, [other, forces(i)])
      call check_contact(model, check)
    end do
  end subroutine go

  !> What nothing touches in a phase that moves it, at its end: the gap that is left, or how deep soil is inside.
  subroutine check_idle(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    character(len=*), parameter :: idle = "moves rigid body 'plate', and nothing is in contact with it: the "// &
      "nearest soil of its "// &
      '*CONTACT is 0.5 away', lost = "moves rigid body 'plate' into soil without any contact force: soil is 0.1917 inside"

    call tests%close('above the ground', told(model, 0.6_wp, 0.5_wp, idle), 1.0_wp, 0.0_wp)
    call tests%close('sideways above it', told(model, 0.5_wp, 0.5_wp, idle), 1.0_wp, 0.0_wp)
    call tests%close('on its way up', told(model, 0.4_wp, 0.5_wp, idle), 0.0_wp, 0.0_wp)
    call tests%close('on the ground', told(model, 0.5_wp, 0.9e-3_wp*cell, 'warning'), 0.0_wp, 0.0_wp)
    call tests%close('just above it', told(model, 0.5_wp, 1.1e-3_wp*cell, 'nothing is in contact with it'), 1.0_wp, 0.0_wp)
    ! The highest points of the soil lie 0.0083 below its surface.
    call tests%close('in the ground', told(model, 0.0_wp, -0.2_wp, lost), 1.0_wp, 0.0_wp)
    call tests%close('less than a tenth of a cell', told(model, 0.0_wp, -0.03_wp, 'warning'), 0.0_wp, 0.0_wp)
    model%state%progress%fraction = 0.5_wp
    call tests%close('the phase is lost on its way', told(model, 0.6_wp, 0.5_wp, 'warning'), 0.0_wp, 0.0_wp)
    model%analysis%phases(1)%moves(1)%body = 'another'
    call tests%close('not moved', told(model, 0.6_wp, 0.5_wp, 'warning'), 0.0_wp, 0.0_wp)
    model%analysis%phases(1)%moves(1)%body = 'plate'
    model%state%progress%fraction = 1.0_wp
    model%analysis%phases(1)%moves(1)%vector = 0.0_wp
    call tests%close('moved by nothing', told(model, 0.6_wp, 0.5_wp, 'warning'), 0.0_wp, 0.0_wp)
    model%analysis%phases(1)%moves(1)%vector(2) = -0.01_wp
    call check_outside(tests, model)
  end subroutine check_idle

  !> Where no point is inside of a body none is named, else the deepest.
  subroutine check_outside(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    type(placed_shape_type), allocatable :: bodies(:)
    type(penetration_type) :: found
    type(error_type), allocatable :: error
    ! Elements, so that what is not set shows: a compiler may drop what a whole variable held.
    real(wp) :: depths(1), depth
    integer :: numbers(2), body, point

    call place(model, 0, [0.0_wp, 0.0_wp, 0.5_wp])
    allocate (bodies, source=placed_bodies(model))
    numbers = 1
    depths = 1.0_wp
    call deepest_point(model, bodies, numbers(1), numbers(2), depths(1))
    call tests%check('no body and no point', all(numbers == 0) .and. depths(1) <= 0.0_wp)
    numbers = 1
    depths = 1.0_wp
    call deepest_in(model, bodies(1), numbers(2), depths(1))
    call tests%check('no point in the body', numbers(2) == 0 .and. abs(depths(1)) <= 0.0_wp)
    deallocate (bodies)
    associate (y => model%state%points%position(2, :))
      y(5) = y(5) + 1.0_wp
      call place(model, 0, [0.0_wp, 0.0_wp, -0.2_wp])
      call deepest_point(model, placed_bodies(model), body, point, depth)
      call tests%check('the deepest point of all', body == 1 .and. point == 5)
      call tests%close('and how deep it is', depth, y(5) - 0.9_wp, 1.0e-14_wp)
      model%contact_pairs(1)%body = 2
      call deepest_point(model, placed_bodies(model), body, point, depth)
      model%contact_pairs(1)%body = 1
      call tests%check('a body that nothing may touch is not looked at', body == 0 .and. point == 0)
      y(5) = y(5) - 1.0_wp
      y(1) = y(1) + 1.5_wp
      allocate (bodies, source=placed_bodies(model))
      call refuse_penetration(model, bodies, found, error)
      call tests%check('the first point may be it', found%body == 1 .and. all(abs(found%deepest(:2) - &
        model%state%points%position(:, 1)) <= 0.0_wp))
      y(1) = y(1) - 1.5_wp
    end associate
    found%depth = 0.25_wp
    call deepest_of_all(team_type(), found)
    call tests%check('of a process alone it is its own', found%body == 1 .and. abs(found%depth - 0.25_wp) <= 0.0_wp)
  end subroutine check_outside

  !> A force before the phase or in it is a touch.
  subroutine check_touch(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    type(contact_check_type) :: check

    model%state%progress%fraction = 1.0_wp
    call place(model, 0, [0.0_wp, 1.0_wp])
    call begin_contact_check(model, check)
    call place(model, 1, [0.0_wp, 0.0_wp, 0.5_wp])
    call check_contact(model, check)
    call tests%close('a force before the phase', ended(model, check, 'warning'), 0.0_wp, 0.0_wp)
    call place(model, 0, [0.0_wp, 0.0_wp, 0.6_wp])
    call begin_contact_check(model, check)
    call place(model, 1, [-1.0_wp, 0.0_wp, 0.5_wp])
    call check_contact(model, check)
    call place(model, 2, [0.0_wp, 0.0_wp, 0.5_wp])
    call check_contact(model, check)
    call tests%close('a force on its way', ended(model, check, 'warning'), 0.0_wp, 0.0_wp)
  end subroutine check_touch

  !> The plate after so many steps, with a force, and how much higher than drawn.
  subroutine place(model, steps, force)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: steps
    !> Along x and y; the third is the height, as drawn where it is left out.
    real(wp), intent(in) :: force(:)
    real(wp) :: height

    height = 0.0_wp
    if (size(force) > 2) height = force(3)
    model%state%progress%step = steps
    model%state%progress%phase_steps = steps
    call keep_rigid_body(model, 1, rigid_pose_type([0.0_wp, height, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp]), &
      [force(1), force(2), 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp])
  end subroutine place

  !> How often something is said at the end of a phase without a force, between two heights.
  real(wp) function told(model, start, end, words)
    type(model_type), intent(inout) :: model
    real(wp), intent(in) :: start, end
    character(len=*), intent(in) :: words
    type(contact_check_type) :: check

    call place(model, 0, [0.0_wp, 0.0_wp, start])
    call begin_contact_check(model, check)
    call place(model, 1, [0.0_wp, 0.0_wp, end])
    call check_contact(model, check)
    told = ended(model, check, words)
  end function told

  !> How often something is said at the end of a phase.
  real(wp) function ended(model, check, words)
    type(model_type), intent(in) :: model
    type(contact_check_type), intent(inout) :: check
    character(len=*), intent(in) :: words
    type(test_observer_type) :: observer

    call end_contact_check(model, check, observer)
    ended = times(observer, words)
  end function ended

  !> How often a warning says something.
  real(wp) function said(model, found, check, words)
    type(model_type), intent(in) :: model
    type(penetration_type), intent(in) :: found
    type(penetration_check_type), intent(inout) :: check
    character(len=*), intent(in) :: words
    type(test_observer_type) :: observer

    call warn_of_penetration(model, found, check, observer)
    said = times(observer, words)
  end function said

  !> How often an observer was told something.
  real(wp) function times(observer, words)
    type(test_observer_type), intent(in) :: observer
    character(len=*), intent(in) :: words
    integer :: start, at

    times = 0.0_wp
    if (.not. allocated(observer%text)) return
    start = 1
    do
      at = index(observer%text(start:), words)
      if (at == 0) exit
      times = times + 1.0_wp
      start = start + at
    end do
  end function times
end module test_penetration
