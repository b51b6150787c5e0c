!> The method of a deck that names none, or only a part of one: docs/methods/choosing.md.
module test_recommended_method
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_mesh_description, only: mesh_fitted, mesh_grid
  use qsmpm_method_description, only: basis_fem, basis_standard, basis_spline2, basis_spline2g, basis_gimp, &
    integrate_points, integrate_cells, stabilise_none, stabilise_background, stabilise_ghost, grid_ghost_factor, &
    background_factor
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_recommended_method

  character(len=*), parameter :: concrete = '*MATERIAL, NAME=concrete|*ELASTIC| 3e5, 0.2|'// &
    '*BODY, NAME=wall, MATERIAL=concrete, SHAPE=BOX| '
  character(len=*), parameter :: strength = '*MOHR COULOMB| 1, 30, 0|', moving = '*MOVING MESH, NSET=base, AXIS=Y, BASE=1|'

contains

  !> All checks.
  subroutine collect_recommended_method(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('recommended_method')
    call check(tests, 'elastic work on a grid', 'QUAD4', '', basis_spline2g, integrate_cells, stabilise_ghost, &
      grid_ghost_factor, 9)
    call check(tests, 'plastic flow on a grid', 'QUAD4', strength, basis_spline2g, integrate_cells, &
      stabilise_ghost, 1.0e-3_wp, 9)
    call check(tests, 'a grid that moves', 'QUAD4', strength//moving, basis_spline2, integrate_points, &
      stabilise_ghost, 5.0e-4_wp, 9)
    call check(tests, 'a perturbed grid', 'QUAD4, PERTURB=0.1', strength, basis_standard, integrate_cells, &
      stabilise_background, background_factor, 0)
    call check(tests, 'triangles', 'TRI6', strength, basis_standard, integrate_cells, stabilise_background, &
      background_factor, 0)
    call check(tests, 'a part of a method', 'QUAD4', strength//'*METHOD, KINEMATICS=JAUMANN, STABILISATION=NONE|', &
      basis_spline2g, integrate_cells, stabilise_none, 0.0_wp, 9)
    call check(tests, 'a strength of the deck', 'QUAD4', strength//'*METHOD, FACTOR=0.1|', basis_spline2g, &
      integrate_cells, stabilise_ghost, 0.1_wp, 9)
    call check(tests, 'points of the deck', 'QUAD4', strength//'*POINTS, PER ELEMENT=16|', basis_spline2g, &
      integrate_cells, stabilise_ghost, 1.0e-3_wp, 16)
    call check(tests, 'a method that is named', 'QUAD4', strength//'*METHOD, BASIS=GIMP|', basis_gimp, &
      integrate_points, stabilise_ghost, grid_ghost_factor, 0)
    call check(tests, 'a stiff body on lines of the grid', 'QUAD4', strength//concrete//'0, 1, 0.5, 1|', &
      basis_standard, integrate_cells, stabilise_background, background_factor, 0)
    call check(tests, 'one that ends within cells', 'QUAD4', strength//concrete//'0, 1, 0.6, 1|', &
      basis_spline2g, integrate_cells, stabilise_ghost, 1.0e-3_wp, 9)
    call check(tests, 'one that is not so stiff', 'QUAD4', strength//'*MATERIAL, NAME=brick|*ELASTIC| 2.9e4, 0.2|'// &
      '*BODY, NAME=wall, MATERIAL=brick, SHAPE=BOX| 0, 1, 0.5, 1|', basis_spline2g, integrate_cells, stabilise_ghost, &
      1.0e-3_wp, 9)
    call check_meshes(tests)
    call check_lines(tests)
  end subroutine collect_recommended_method

  !> Lines of a grid that follow interfaces: layers at 0.35 and 0.7 in cells of 0.25, beside a wall.
  subroutine check_lines(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: even(5) = [0.0_wp, 0.25_wp, 0.5_wp, 0.75_wp, 1.0_wp]

    call lines('layers', '', '', 0.7_wp, [0.0_wp, 0.35_wp, 0.5_wp, 0.7_wp, 1.0_wp], &
      '; grid lines moved onto interfaces of bodies: y = 0.35, y = 0.7')
    call lines('a thin layer', '', '', 0.4_wp, [0.0_wp, 0.35_wp, 0.4_wp, 0.75_wp, 1.0_wp], &
      '; grid lines moved onto interfaces of bodies: y = 0.35, y = 0.4')
    call lines('a line with nodes of a set', '', '*NSET, NSET=row, PLANE=Y| 0.25|', 0.7_wp, &
      [0.0_wp, 0.25_wp, 0.35_wp, 0.7_wp, 1.0_wp], '; grid lines moved onto interfaces of bodies: y = 0.35, y = 0.7')
    call lines('a line where a surface of faces ends', '', '*SURFACE, NAME=side, TYPE=BOX| 0, 0, 0.75, 1|', 0.7_wp, &
      [0.0_wp, 0.35_wp, 0.5_wp, 0.75_wp, 1.0_wp], '; grid lines moved onto interfaces of bodies: y = 0.35')
    call lines('an element that is named', ', ELEMENT=QUAD4', '', 0.7_wp, even, '')
    call lines('a method that is named', '', '*METHOD, BASIS=GIMP|', 0.7_wp, even, '')
  contains
    !> Read a deck and look at the lines of its grid along y.
    subroutine lines(name, element, cards, top, expected, note)
      character(len=*), intent(in) :: name, element, cards, note
      !> Top of the second layer, and lines.
      real(wp), intent(in) :: top, expected(:)
      class(analysis_type), allocatable :: analysis
      type(message_list_type) :: messages
      type(error_type), allocatable :: error
      character(len=8) :: at

      allocate (analysis)
      write (at, '(f8.3)') top
      call parse_deck('test.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID'//element//'| X, 0, 1, 4| Y, 0, 1, 4|'// &
        '*NSET, NSET=base, PLANE=Y| 0|'//cards//'*MATERIAL, NAME=soil|*ELASTIC| 1000, 0.3|'//strength//'*MATERIAL, NAME=sand|'// &
        '*ELASTIC| 3000, 0.3|*BODY, NAME=low, MATERIAL=soil, SHAPE=BOX| 0, 1, 0, 0.35|*BODY, NAME=middle, MATERIAL=sand, '// &
        'SHAPE=BOX| 0, 1, 0.35, '//at//'|*BODY, NAME=upper, MATERIAL=soil, SHAPE=BOX| 0, 0.5, '//at//', 0.9|'// &
        '*BODY, NAME=beside, MATERIAL=soil, SHAPE=BOX| 0.5, 1, '//at//', 0.9|'// &
        '*RIGID BODY, NAME=plate, SHAPE=BOX| 0, 1, 0.9, 1|*PHASE, NAME=load|*FIX| base, ALL|*GRAVITY| 0, -1|*END PHASE|'), &
        analysis, messages, error)
      call tests%check(name//' can be read', .not. allocated(error))
      if (allocated(error)) return
      call tests%check(name//': lines', all(abs(analysis%mesh%axes(2)%lines - expected) <= 1.0e-12_wp) .and. &
        all(abs(analysis%mesh%axes(1)%lines - even) <= 0.0_wp))
      if (len(note) > 0) call tests%check(name//': '//analysis%method_reason, index(analysis%method_reason, note) > 0)
    end subroutine lines
  end subroutine check_lines

  !> The background of a *GRID that names no element.
  subroutine check_meshes(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: box = '*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX| 0, 1, 0, 0.5|', &
      hill = '*BODY, NAME=block, MATERIAL=soil, SHAPE=POLYGON| 0, 0| 1, 0| 0.4, 0.7|', &
      second = '*BODY, NAME=more, MATERIAL=soil, SHAPE=BOX, ACTIVE=NO| 0, 1, 0.5, 1|', later = '*PHASE, NAME=a|'

    call check_mesh(tests, 'ground that can fail', '', strength//box, 'TRI6', basis_fem, .true.)
    call check_mesh(tests, 'elastic ground on lines', '', box, 'QUAD4', basis_spline2g, .false.)
    call check_mesh(tests, 'elastic ground off lines', '', hill, 'TRI6', basis_fem, .true.)
    call check_mesh(tests, 'two materials', '', concrete//'0, 1, 0.5, 1|'//box, 'TRI6', basis_fem, .true.)
    call check_mesh(tests, 'a body that comes', '', strength//box//second, 'TRI6', basis_fem, .true.)
    call check_mesh(tests, 'a body that comes as drawn', '', strength//box//second//later//'*ACTIVATE, FILL=SHAPE| more|'// &
      '*END PHASE|', &
      'QUAD4', basis_spline2g, .false.)
    call check_mesh(tests, 'a body that goes and comes back', '', strength//box//second//later//'*ACTIVATE| more|*END PHASE|'// &
      '*PHASE, NAME=b|*DEACTIVATE| more|*END PHASE|*PHASE, NAME=c|*ACTIVATE| more|*END PHASE|', 'QUAD4', basis_spline2g, .false.)
    call check_mesh(tests, 'a body that comes and goes', '', strength//box//second//later//'*ACTIVATE| more|*END PHASE|'// &
      '*PHASE, NAME=b|*DEACTIVATE| more|*END PHASE|', 'TRI6', basis_fem, .true.)
    call check_mesh(tests, 'a rigid body', '', strength//box//'*RIGID BODY, NAME=plate, SHAPE=BOX| 0, 1, 0.5, 1|', &
      'QUAD4', basis_spline2g, .false.)
    call check_mesh(tests, 'points of cells', '', strength//box//'*POINTS, PER ELEMENT=25|', 'QUAD4', basis_spline2g, .false.)
    call check_mesh(tests, 'points of triangles', '', strength//box//'*POINTS, PER ELEMENT=12|', 'TRI6', basis_fem, .true.)
    call check_mesh(tests, 'a method for grids', '', strength//box//'*METHOD, BASIS=GIMP|', 'QUAD4', basis_gimp, .false.)
    call check_mesh(tests, 'a mesh that goes with the ground', '', strength//box//'*METHOD, BASIS=FEM|', 'TRI6', basis_fem, &
      .true.)
    call check_mesh(tests, 'no grid that follows', ', ELEMENT=TRI6, FIT=YES, REFIT=NO', strength//box, 'TRI6', basis_fem, &
      .false.)
    call check_mesh(tests, 'nodes that are pushed', '', strength//box//'*PRESCRIBE', 'TRI6', basis_fem, .false.)
    call check_mesh(tests, 'a held line of the grid', '', strength//box//later//'*FIX| top, X|*END PHASE|', 'TRI6', &
      basis_fem, .true.)
    call check_mesh(tests, 'a held line off those of the grid', '', strength//box//'*NSET, NSET=in, BOX| 0, 1, 0.3, 0.4|'// &
      later//'*FIX| in, X|*END PHASE|', 'TRI6', basis_fem, .false.)
    call check_mesh(tests, 'a held plane off them', '', strength//box//'*NSET, NSET=in, PLANE=X| 0.3|'//later// &
      '*FIX| in, X|*END PHASE|', 'TRI6', basis_fem, .false.)
    call check_mesh(tests, 'a plane that is freed', '', strength//box//'*NSET, NSET=in, PLANE=X| 0.3|'//later// &
      '*FIX| in, FREE|*END PHASE|', 'TRI6', basis_fem, .true.)
    call check_mesh(tests, 'a plane that is kept where it is', '', strength//box//'*NSET, NSET=in, PLANE=X| 0.3|'//later// &
      '*PRESCRIBE| in, X, 0|*END PHASE|', 'TRI6', basis_fem, .false.)
  end subroutine check_meshes

  !> Read a deck and look at its background.
  subroutine check_mesh(tests, name, words, cards, element, basis, follows)
    type(tests_type), intent(inout) :: tests
    !> What is checked, words of *GRID, cards behind the material and, from *PHASE on, later phases; *PRESCRIBE at the
    !> end pushes nodes.
    character(len=*), intent(in) :: name, words, cards, element
    integer, intent(in) :: basis
    !> A grid follows when the mesh is worn.
    logical, intent(in) :: follows
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    integer :: pushed, later

    allocate (analysis)
    pushed = index(cards//'*PRESCRIBE', '*PRESCRIBE')
    later = index(cards//'*PHASE', '*PHASE')
    call parse_deck('test.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID'//words//'| X, 0, 1, 2| Y, 0, 1, 2|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=top, BOX| 0, 1, 0.5, 0.5|*MATERIAL, NAME=soil|*ELASTIC| 1000, 0.3|'// &
      cards(:min(pushed, later) - 1)//'*PHASE, NAME=load|*FIX| base, ALL|*GRAVITY| 0, -1|'// &
      trim(merge('*PRESCRIBE| top, Y, -0.1|', '                         ', pushed <= len(cards)))//'*END PHASE|'//cards(later:)), &
      analysis, messages, error)
    call tests%check(name//' without an element can be read', .not. allocated(error))
    if (allocated(error)) return
    call tests%check(name//': '//analysis%mesh%element, analysis%mesh%element == element .and. &
      (analysis%mesh%kind == mesh_fitted .eqv. element == 'TRI6'))
    call tests%check(name//': basis', analysis%method%basis == basis)
    call tests%check(name//': what follows', allocated(analysis%backgrounds) .eqv. follows)
    if (.not. (follows .and. allocated(analysis%backgrounds))) return
    associate (grid => analysis%backgrounds(2))
      call tests%check(name//': splines on a grid of quadrilaterals', grid%kind == mesh_grid .and. &
        grid%element == 'QUAD4' .and. grid%method%basis == basis_spline2g .and. &
        grid%method%stabilisation == stabilise_ghost .and. grid%method%stabilisation_factor > 0.0_wp)
    end associate
  end subroutine check_mesh

  !> Read a deck and look at its method.
  subroutine check(tests, name, element, cards, basis, integration, stabilisation, factor, points)
    type(tests_type), intent(inout) :: tests
    !> What is checked, words of *GRID, cards behind the material.
    character(len=*), intent(in) :: name, element, cards
    integer, intent(in) :: basis, integration, stabilisation
    real(wp), intent(in) :: factor
    !> Points of an element, 0 for its default.
    integer, intent(in) :: points
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('test.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT='//element// &
      '| X, 0, 1, 2| Y, 0, 1, 2|*NSET, NSET=base, PLANE=Y| 0|*MATERIAL, NAME=soil|*ELASTIC| 1000, 0.3|'//cards// &
      '*BODY, NAME=block, MATERIAL=soil, SHAPE=ALL|*PHASE, NAME=load|*FIX| base, ALL|*GRAVITY| 0, -1|*END PHASE|'), &
      analysis, messages, error)
    call tests%check(name//' can be read', .not. allocated(error))
    if (allocated(error)) return
    associate (method => analysis%method)
      call tests%check(name//': basis, integration and stabilisation', method%basis == basis .and. &
        method%integration == integration .and. method%stabilisation == stabilisation)
      call tests%close(name//': strength of the stabilisation', method%stabilisation_factor, factor, 0.0_wp)
      call tests%check(name//': points of an element', analysis%bodies(size(analysis%bodies))%points_per_element == points)
      call tests%check(name//': a reason where the deck has none', &
        allocated(analysis%method_reason) .neqv. (index(cards, 'BASIS') > 0))
    end associate
  end subroutine check
end module test_recommended_method
