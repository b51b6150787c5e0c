!> Scenes for the tests of the reductions: decks that can be reduced, and what becomes of a deck with a
!> line changed.
module scene_samples
  use, intrinsic :: iso_fortran_env, only: error_unit
  use qsmpm_kinds, only: wp, pi
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type, message_text
  use qsmpm_error, only: error_type
  use qsmpm_reduction, only: expansion_type, reduction_check_type
  use qsmpm_scene, only: reduce_scene, check_text
  use deck_samples, only: joined
  implicit none
  private

  public :: slice_deck, layers_deck, twin_deck, figure_deck, pressed_slice, pressed_layers, pressed_twins, &
    pressed_figure, changed, outcome, reduced, turned_facets, write_stl

  character(len=*), parameter :: soil = '*MATERIAL, NAME=soil|*ELASTIC| 1000, 0.3|*UNIT WEIGHT| 18|'
  !> File of the figure of revolution.
  character(len=*), parameter, public :: figure_file = 'test_scene.stl'

contains

  !> A slice of a slope with a loaded crest, held along z at both faces.
  function slice_deck() result(text)
    character(len=:), allocatable :: text

    text = joined('*MODEL, TYPE=AUTO|*METHOD, BASIS=STANDARD|*GRID, ELEMENT=HEX8| X, 0, 4, 8| Y, 0, 1.5, 6| Z, 0, 0.5, 2|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=left, PLANE=X| 0|*NSET, NSET=right, PLANE=X| 4|'// &
      '*NSET, NSET=front, PLANE=Z| 0|*NSET, NSET=back, PLANE=Z| 0.5|'// &
      '*SURFACE, NAME=crest, TYPE=BOX| 0, 1, 1, 1, 0, 0.5|'//soil// &
      '*BODY, NAME=slope, MATERIAL=soil, SHAPE=POLYGON| 0, 0| 2, 0| 1, 1| 0, 1|'// &
      '*BODY, NAME=toe, MATERIAL=soil, SHAPE=BOX| 2, 4, 0, 0.5, 0, 0.5|*POINTS, PER ELEMENT=27|'// &
      '*HISTORY, NAME=u, QUANTITY=DISPLACEMENT, COMPONENT=Y| 1, 1, 0.3|'// &
      '*HISTORY, NAME=z, QUANTITY=POSITION, COMPONENT=Z, SCALE=2| 1, 1, 0.3|'// &
      '*HISTORY, NAME=force, QUANTITY=REACTION, COMPONENT=Y, NSET=base|'// &
      '*HISTORY, NAME=tyz, QUANTITY=STRESS, COMPONENT=YZ| 1, 1, 0.3|'// &
      '*PHASE, NAME=load|*FIX| base, ALL| left, X| right, X| front, Z| back, Z|*GRAVITY| 0, -1, 0|'// &
      '*TRACTION, SURFACE=crest| 0, -5, 0|*CONTROLS, STEPS=1|*END PHASE|'// &
      '*PHASE, NAME=push|*PRESCRIBE| left, X, 0.01|*CONTROLS, STEPS=1|*END PHASE|')
  end function slice_deck

  !> Level layers between rollers under an even load.
  function layers_deck() result(text)
    character(len=:), allocatable :: text

    text = joined('*MODEL, TYPE=AUTO|*METHOD, BASIS=STANDARD|*GRID, ELEMENT=QUAD4| X, LINES, 0, 1, 1.5, 2.5, 4| Y, 0, 3, 6|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=left, PLANE=X| 0|*NSET, NSET=right, PLANE=X| 4|'// &
      '*SURFACE, NAME=top, TYPE=BOX| 0, 4, 2.5, 2.5|'//soil// &
      '*BODY, NAME=lower, MATERIAL=soil, SHAPE=BOX| 0, 4, 0, 1|'// &
      '*BODY, NAME=upper, MATERIAL=soil, SHAPE=POLYGON| -1, 1| 5, 1| 5, 2.5| -1, 2.5|'// &
      '*HISTORY, NAME=u, QUANTITY=DISPLACEMENT, COMPONENT=Y| 2.2, 2.5|'// &
      '*HISTORY, NAME=x, QUANTITY=POSITION, COMPONENT=X| 2.2, 2.5|'// &
      '*HISTORY, NAME=force, QUANTITY=REACTION, COMPONENT=Y, NSET=base|'// &
      '*HISTORY, NAME=side, QUANTITY=REACTION, COMPONENT=X, NSET=right|'// &
      '*PHASE, NAME=load|*FIX| base, ALL| left, X| right, X|*GRAVITY| 0, -1|'// &
      '*TRACTION, SURFACE=top| 0, -5|*CONTROLS, STEPS=1|*END PHASE|')
  end function layers_deck

  !> Two equal heaps with equal loads, a plate between them.
  function twin_deck() result(text)
    character(len=:), allocatable :: text

    text = joined('*MODEL, TYPE=AUTO|*METHOD, BASIS=STANDARD|*GRID, ELEMENT=QUAD4| X, 0, 8, 16| Y, 0, 2, 4|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=left, PLANE=X| 0|*NSET, NSET=right, PLANE=X| 8|'// &
      '*NSET, NSET=plate, BOX| 3, 5, 1, 1|'// &
      '*SURFACE, NAME=one, TYPE=SEGMENT| 2, 1, 1, 1|*SURFACE, NAME=two, TYPE=SEGMENT| 7, 1, 6, 1|'// &
      '*SURFACE, NAME=wall, TYPE=BOX| 0, 8, 1, 1|'//soil// &
      '*BODY, NAME=first, MATERIAL=soil, SHAPE=POLYGON| 0, 0| 3, 0| 2, 1| 0, 1|'// &
      '*BODY, NAME=second, MATERIAL=soil, SHAPE=POLYGON| 5, 0| 8, 0| 8, 1| 6, 1|'// &
      '*BODY, NAME=middle, MATERIAL=soil, SHAPE=BOX| 3, 5, 0, 1|'// &
      '*HISTORY, NAME=x, QUANTITY=POSITION, COMPONENT=X| 7, 0.5|'// &
      '*HISTORY, NAME=txy, QUANTITY=STRESS, COMPONENT=XY| 7.1, 0.6|'// &
      '*HISTORY, NAME=force, QUANTITY=REACTION, COMPONENT=Y, NSET=base|'// &
      '*HISTORY, NAME=side, QUANTITY=REACTION, COMPONENT=X, NSET=right|'// &
      '*PHASE, NAME=load|*FIX| base, ALL| left, X| right, X|*GRAVITY| 0, -1|*PRESCRIBE| plate, Y, -0.01|'// &
      '*TRACTION, SURFACE=one| 1, -5|*TRACTION, SURFACE=two| -1, -5|*PRESSURE, SURFACE=wall| 2|'// &
      '*CONTROLS, STEPS=1|*END PHASE|')
  end function twin_deck

  !> A quarter of a cylinder on a rough base under an even load.
  function figure_deck() result(text)
    character(len=:), allocatable :: text

    text = joined('*MODEL, TYPE=AUTO|*METHOD, BASIS=STANDARD|*GRID, ELEMENT=HEX8| X, 1, 2.5, 6| Y, 0, 1.5, 6| Z, 1, 2.5, 6|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=cut x, PLANE=X| 1|*NSET, NSET=cut z, PLANE=Z| 1|'// &
      '*NSET, NSET=far, PLANE=X| 2.5|*SURFACE, NAME=top, TYPE=OUTLINE, BODY=figure, BOX| 0, 3, 1, 1, 0, 3|'//soil// &
      '*BODY, NAME=figure, MATERIAL=soil, SHAPE=POLYHEDRON, INPUT='//figure_file//'|*POINTS, PER ELEMENT=8|'// &
      '*HISTORY, NAME=ux, QUANTITY=DISPLACEMENT, COMPONENT=X| 1.3, 0.5, 1.4|'// &
      '*HISTORY, NAME=z, QUANTITY=POSITION, COMPONENT=Z| 1.3, 0.5, 1.4|'// &
      '*HISTORY, NAME=force, QUANTITY=REACTION, COMPONENT=Y, NSET=base|'// &
      '*HISTORY, NAME=szz, QUANTITY=STRESS, COMPONENT=ZZ| 1.3, 0.5, 1|'// &
      '*PHASE, NAME=load|*FIX| base, ALL| cut x, X| cut z, Z| far, X|*GRAVITY| 0, -1, 0|'// &
      '*TRACTION, SURFACE=top| 0, -5, 0|*CONTROLS, STEPS=1|*END PHASE|')
  end function figure_deck

  !> The slice, its crest loaded by a rigid prism.
  function pressed_slice() result(text)
    character(len=:), allocatable :: text

    text = changed(slice_deck(), '*HISTORY, NAME=u,', '*RIGID BODY, NAME=plate, SHAPE=POLYGON| 0, 1| 1, 1| 1, 1.2|'// &
      ' 0, 1.2|*CONTACT, BODY=plate, SURFACE=crest|*HISTORY, NAME=push, QUANTITY=CONTACT FORCE, COMPONENT=Y, '// &
      'BODY=plate|*HISTORY, NAME=turn, QUANTITY=CONTACT MOMENT, BODY=plate|*HISTORY, NAME=out, QUANTITY=BODY MOVE, '// &
      'COMPONENT=Z, BODY=plate|*HISTORY, NAME=u,')
    text = changed(text, '*TRACTION, SURFACE=crest| 0, -5, 0|', '*MOVE, BODY=plate| 0.01, -0.01, 0|')
    text = changed(text, '*PRESCRIBE| left, X, 0.01|', '*LOAD, BODY=plate, COMPONENT=Y| -5|')
  end function pressed_slice

  !> The layers under a level plane.
  function pressed_layers() result(text)
    character(len=:), allocatable :: text

    text = changed(layers_deck(), '*HISTORY, NAME=u,', '*RIGID BODY, NAME=plate, SHAPE=PLANE| 1, 2.5, 0, -1|'// &
      '*CONTACT, BODY=plate, SURFACE=top|*HISTORY, NAME=push, QUANTITY=CONTACT FORCE, COMPONENT=Y, BODY=plate|'// &
      '*HISTORY, NAME=aside, QUANTITY=CONTACT FORCE, COMPONENT=X, BODY=plate|*HISTORY, NAME=u,')
    text = changed(text, '*TRACTION, SURFACE=top| 0, -5|', '*LOAD, BODY=plate, COMPONENT=Y| -8|')
  end function pressed_layers

  !> The twins, a cone on each, a circle between them.
  function pressed_twins() result(text)
    character(len=:), allocatable :: text

    text = changed(twin_deck(), '*HISTORY, NAME=x,', '*RIGID BODY, NAME=ball, SHAPE=CIRCLE| 4, 1.5, 0.5|'// &
      '*RIGID BODY, NAME=left cone, SHAPE=CONE| 1.5, 1, 0.3, 60, 0.5|*RIGID BODY, NAME=right cone, SHAPE=CONE|'// &
      ' 6.5, 1, 0.3, 60, 0.5|*CONTACT, BODY=ball, SURFACE=wall, ADHESION=1|*CONTACT, BODY=left cone, SURFACE=one|'// &
      '*CONTACT, BODY=right cone, SURFACE=two|'// &
      '*HISTORY, NAME=push, QUANTITY=CONTACT FORCE, COMPONENT=Y, BODY=ball|'// &
      '*HISTORY, NAME=aside, QUANTITY=CONTACT FORCE, COMPONENT=X, BODY=ball|'// &
      '*HISTORY, NAME=down, QUANTITY=BODY MOVE, COMPONENT=Y, BODY=ball|'// &
      '*HISTORY, NAME=out, QUANTITY=CONTACT FORCE, COMPONENT=X, BODY=right cone|'// &
      '*HISTORY, NAME=turn, QUANTITY=CONTACT MOMENT, BODY=right cone|'// &
      '*HISTORY, NAME=near, QUANTITY=BODY MOVE, COMPONENT=X, BODY=left cone|'// &
      '*HISTORY, NAME=p, QUANTITY=CONTACT PRESSURE| 6.2, 1|*HISTORY, NAME=x,')
    text = changed(text, '*PRESSURE, SURFACE=wall| 2|', '*LOAD, BODY=ball, COMPONENT=Y| -6|'// &
      '*MOVE, BODY=left cone, ROTATION=2| 0.1, -0.1|*MOVE, BODY=right cone, ROTATION=-2| -0.1, -0.1|')
  end function pressed_twins

  !> The figure under a cylinder that is loaded.
  function pressed_figure() result(text)
    character(len=:), allocatable :: text

    text = changed(figure_deck(), '*HISTORY, NAME=ux,', '*RIGID BODY, NAME=plate, SHAPE=CYLINDER| 1, 1, 1, 0.5, 0.2|'// &
      '*CONTACT, BODY=plate, SURFACE=top|*HISTORY, NAME=push, QUANTITY=CONTACT FORCE, COMPONENT=Y, BODY=plate|'// &
      '*HISTORY, NAME=ux,')
    text = changed(text, '*TRACTION, SURFACE=top| 0, -5, 0|', '*LOAD, BODY=plate, COMPONENT=Y| -5|')
  end function pressed_figure

  !> A deck with a text replaced; bars are line ends. A text that is not there stops the tests.
  function changed(deck, old, new) result(text)
    !> The deck, what is in it and what comes in its place.
    character(len=*), intent(in) :: deck, old, new
    character(len=:), allocatable :: text
    integer :: at

    at = index(deck, joined(old))
    if (at == 0) error stop 'the sample has no such text'
    text = deck(:at - 1)//joined(new)//deck(at + len(old):)
  end function changed

  !> The model of a deck.
  subroutine reduced(deck, model, expansion, checks)
    !> The deck; one that cannot be read stops the tests.
    character(len=*), intent(in) :: deck
    !> The model and the way back.
    type(analysis_type), intent(out) :: model
    type(expansion_type), intent(out) :: expansion
    !> What was found.
    type(reduction_check_type), allocatable, intent(out) :: checks(:)
    class(analysis_type), allocatable :: scene
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (scene)
    call parse_deck('test.inp', deck, scene, messages, error)
    if (allocated(error)) then
      write (error_unit, '(a)') message_text(messages)
      error stop 'the sample cannot be read'
    end if
    call reduce_scene(scene, model, expansion, checks)
  end subroutine reduced

  !> What was found about one reduction of a deck.
  function outcome(deck, kind, axis) result(text)
    !> The deck.
    character(len=*), intent(in) :: deck
    !> The reduction.
    integer, intent(in) :: kind, axis
    character(len=:), allocatable :: text
    class(analysis_type), allocatable :: model
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)
    integer :: i

    allocate (model)
    call reduced(deck, model, expansion, checks)
    text = 'never tried'
    do i = 1, size(checks)
      if (checks(i)%kind == kind .and. checks(i)%axis == axis) text = check_text(checks(i))
    end do
  end function outcome

  !> Surface of a section turned about a vertical axis: bands of facets between rings.
  function turned_facets(section, corners, centre) result(facets)
    !> Radius and height along the section, seen from outside from top to bottom (2,n).
    real(wp), intent(in) :: section(:, :)
    !> Corners of a ring.
    integer, intent(in) :: corners
    !> x and z of the axis.
    real(wp), intent(in) :: centre(2)
    real(wp), allocatable :: facets(:, :, :)
    real(wp) :: corner(3, 4)
    integer :: i, k, n

    allocate (facets(3, 3, 2*corners*size(section, 2)))
    n = 0
    do i = 1, size(section, 2) - 1
      do k = 0, corners - 1
        corner(:, 1) = place(i, k)
        corner(:, 2) = place(i, modulo(k + 1, corners))
        corner(:, 3) = place(i + 1, modulo(k + 1, corners))
        corner(:, 4) = place(i + 1, k)
        if (section(1, i) > 0.0_wp) facets(:, :, n + 1) = corner(:, [1, 2, 3])
        if (section(1, i) > 0.0_wp) n = n + 1
        if (section(1, i + 1) > 0.0_wp) facets(:, :, n + 1) = corner(:, [1, 3, 4])
        if (section(1, i + 1) > 0.0_wp) n = n + 1
      end do
    end do
    facets = facets(:, :, :n)

  contains

    !> A corner; in single precision as in a file.
    function place(ring, number) result(x)
      integer, intent(in) :: ring, number
      real(wp) :: x(3), angle

      angle = 2.0_wp*pi*number/corners
      x = [centre(1) + section(1, ring)*cos(angle), section(2, ring), centre(2) + section(1, ring)*sin(angle)]
      x = real(real(x), wp)
    end function place
  end function turned_facets

  !> Write facets as an STL file in ASCII.
  subroutine write_stl(path, facets)
    !> Name of the file.
    character(len=*), intent(in) :: path
    !> Corners (3, 3, n).
    real(wp), intent(in) :: facets(:, :, :)
    integer :: unit, f, k

    open (newunit=unit, file=path, status='replace')
    write (unit, '(a)') 'solid figure'
    do f = 1, size(facets, 3)
      write (unit, '(a)') 'facet normal 0 0 0', 'outer loop'
      do k = 1, 3
        write (unit, '(a,3(1x,es16.8))') 'vertex', facets(:, k, f)
      end do
      write (unit, '(a)') 'endloop', 'endfacet'
    end do
    write (unit, '(a)') 'endsolid figure'
    close (unit)
  end subroutine write_stl
end module scene_samples
