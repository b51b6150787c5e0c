!> Where triangles that fit a scene are smallest: corners of soil that can yield, ends of loads, boxes of *REFINE.
module test_singular_corners
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_fitted_background, only: fit_background
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_singular_corners

  !> Ground of 4 x 2 m on cells of 0.5 m, on which and in which bodies are drawn; what holds it and its weight.
  character(len=*), parameter :: head = '*MODEL, TYPE=PLANE STRAIN|*GRID| X, 0, 4, 8| Y, 0, 3, 6|', soil = &
    '*NSET, NSET=base, PLANE=Y| 0|*MATERIAL, NAME=soil|*ELASTIC| 1000, 0.3|*MOHR COULOMB| 10, 20, 20|*UNIT WEIGHT| 1|', &
    ground = '*BODY, NAME=ground, MATERIAL=soil, SHAPE=POLYGON| 0, 0| 4, 0| 4, 2.1| 0, 2.1|', &
    weight = '*PHASE, NAME=weight|*FIX| base, ALL|*GRAVITY| 0, -1|*END PHASE|'

contains

  !> All tests.
  subroutine collect_singular_corners(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: bank = '*BODY, NAME=bank, MATERIAL=soil, SHAPE=POLYGON| 0, 0| 4, 0| 4, 1| 2, 1| '// &
      '1.2, 2.5| 0, 2.5|', pit = '*BODY, NAME=pit, MATERIAL=soil, SHAPE=BOX| 0, 1.3, 1.2, 2.1|', &
      dug = '*PHASE, NAME=dug|*DEACTIVATE| pit|*END PHASE|', face = '*SURFACE, NAME=top, TYPE=OUTLINE, BODY=ground, '// &
      'BOX| 0, 1.3, 2.1, 2.1|', pushed = '*PHASE, NAME=pushed|*PRESSURE, SURFACE=top| 5|*END PHASE|', &
      edge = '*NSET, NSET=plate, BOX| 0, 1.2, 2.1, 2.1|', &
      lens = '*BODY, NAME=lens, MATERIAL=soil, SHAPE=BOX| 1, 2.2, 0.7, 1.3|'

    call tests%start('singular_corners')
    call tests%close('level ground has cells as wide as those of its grid', smallest(head//soil//ground//weight, &
      [2.0_wp, 2.1_wp]), 0.5_wp, 0.35_wp)
    call tests%check('the toe of a bank small ones', smallest(head//soil//bank//weight, [2.0_wp, 1.0_wp]) < 0.1_wp)
    call tests%check('not its crest', smallest(head//soil//bank//weight, [1.2_wp, 2.5_wp]) > 0.15_wp)
    call tests%check('nor where nothing yields', smallest(head//'*REFINE| 3.9, 3.9, 0.1, 0.1, 0.5|'// &
      without(soil, '*MOHR COULOMB| 10, 20, 20|')//bank//weight, [2.0_wp, 1.0_wp]) > 0.15_wp)
    call tests%check('the foot of a pit that is dug', smallest(head//soil//ground//pit//weight//dug, [1.3_wp, 1.2_wp]) &
      < 0.1_wp)
    call tests%check('not a body within', smallest(head//soil//ground//lens//weight, [2.2_wp, 1.3_wp]) > 0.15_wp)
    call tests%check('the end of a load', smallest(head//soil//ground//face//weight//pushed, [1.3_wp, 2.1_wp]) < 0.1_wp)
    call tests%check('no smaller than soft ground settles there', smallest(head//soil//ground//face//weight// &
      '*PHASE, NAME=pushed|*PRESSURE, SURFACE=top| 100|*END PHASE|', [1.3_wp, 2.1_wp]) > 0.15_wp)
    call tests%check('not that of a face alone', smallest(head//soil//ground//face//weight, [1.3_wp, 2.1_wp]) > 0.15_wp)
    call tests%check('nor where nodes are pushed', smallest(head//soil//bank//'*NSET, NSET=top, BOX| 0, 0.5, 2.5, 2.5|'// &
      weight//'*PHASE, NAME=pushed|*PRESCRIBE| top, Y, -0.13|*END PHASE|', [2.0_wp, 1.0_wp]) > 0.15_wp)
    call tests%check('unless they go by no more than a quarter of a cell', smallest(head//soil//ground//edge// &
      '*PHASE, NAME=pushed|*PRESCRIBE| plate, Y, -0.01|*END PHASE|', [1.2_wp, 2.1_wp]) < 0.1_wp)
    call tests%check('none where ground so soft settles by a cell', smallest(head// &
      without(soil, '*ELASTIC| 1000, 0.3|*MOHR COULOMB| 10, 20, 20|*UNIT WEIGHT| 1|')// &
      '*ELASTIC| 6, 0.3|*MOHR COULOMB| 10, 20, 20|*UNIT WEIGHT| 1|'//bank//weight, [2.0_wp, 1.0_wp]) > 0.15_wp)
    call tests%check('nor where the soil beside them has no strength', smallest(head// &
      without(soil, '*MOHR COULOMB| 10, 20, 20|')//'*MOHR COULOMB| 0.9, 20, 20|'//ground//edge// &
      '*PHASE, NAME=pushed|*PRESCRIBE| plate, Y, -0.01|*END PHASE|', [1.2_wp, 2.1_wp]) > 0.15_wp)
    call tests%check('and no smaller than two ways', smallest(head//soil//ground//edge// &
      '*PHASE, NAME=pushed|*PRESCRIBE| plate, Y, -0.1|*END PHASE|', [1.2_wp, 2.1_wp]) > 0.1_wp)
    call tests%close('a set ends at a node', gap_to(head//soil//ground//edge//weight, [1.2_wp, 2.1_wp]), 0.0_wp, 1.0e-6_wp)
    call tests%close('one along a line in the ground has nodes to its lower end', gap_to(head//soil//ground// &
      '*NSET, NSET=wall, BOX| 1.3, 1.3, 0.7, 2.1|'//weight, [1.3_wp, 0.7_wp]), 0.0_wp, 1.0e-6_wp)
    call tests%check('which is not so without it', gap_to(head//soil//ground//weight, [1.3_wp, 0.7_wp]) > 1.0e-3_wp)
    call tests%close('and a face', gap_to(head//soil//ground//face//weight, [1.3_wp, 2.1_wp]), 0.0_wp, 1.0e-6_wp)
    call tests%check('a box around a corner picks its node alone', gap_to(head//soil//ground//'*NSET, NSET=corner, '// &
      'BOX| 3.95, 4.05, 2.05, 2.15|'//weight, [3.95_wp, 2.1_wp]) > 0.04_wp)
    call tests%check('not beside it', gap_to(head//soil//ground//edge//weight, [1.3_wp, 2.1_wp]) > 0.01_wp)
    call tests%check('a box over a graded grid is no finer than an eighth of each of its cells', smallest( &
      '*MODEL, TYPE=PLANE STRAIN|*GRID| X, 0, 4, 40, 1E3| Y, 0, 3, 6|*REFINE| 0, 4, 0, 3, 1E-12|'//soil//ground//weight, &
      [3.5_wp, 0.5_wp]) > 0.01_wp)
    call tests%check('boxes have the width that is asked for, beyond the mesh as well', smallest(head//'*REFINE| 3, 9, '// &
      '-5, 1, 0.125|'//soil//ground//weight, [3.5_wp, 0.5_wp]) < 0.19_wp)
    call tests%check('an eighth of a cell at the least', smallest(head//'*REFINE| 3.5, 3.5, 0.5, 0.5, 1E-9|'//soil// &
      ground//weight, [3.5_wp, 0.5_wp]) > 0.03_wp)
  end subroutine collect_singular_corners

  !> A text without a part of it.
  pure function without(text, part) result(rest)
    character(len=*), intent(in) :: text, part
    character(len=:), allocatable :: rest
    integer :: at

    at = index(text, part)
    rest = text(:at - 1)//text(at + len(part):)
  end function without

  !> Distance of the nearest node from a place.
  real(wp) function gap_to(deck, place) result(gap)
    character(len=*), intent(in) :: deck
    real(wp), intent(in) :: place(2)
    type(mesh_type) :: mesh

    call fit(deck, mesh)
    gap = minval(norm2(mesh%coordinates - spread(place, 2, mesh%node_count), dim=1))
  end function gap_to

  !> The triangles of a deck.
  subroutine fit(deck, mesh)
    character(len=*), intent(in) :: deck
    type(mesh_type), intent(out) :: mesh
    type(message_list_type) :: messages
    class(analysis_type), allocatable :: analysis
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('corner.inp', joined(deck), analysis, messages, error)
    if (.not. allocated(error)) call fit_background(analysis, mesh, error)
    if (allocated(error)) error stop 'the deck of the singular_corners suite is broken'
  end subroutine fit

  !> Shortest distance of two nodes of a cell that lies within half a cell of the grid of a place.
  real(wp) function smallest(deck, place)
    character(len=*), intent(in) :: deck
    real(wp), intent(in) :: place(2)
    type(mesh_type) :: mesh
    integer :: c, k

    call fit(deck, mesh)
    smallest = huge(smallest)
    do c = 1, mesh%cell_count
      associate (nodes => mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c) + 2))
        if (norm2(sum(mesh%coordinates(:, nodes), dim=2)/3.0_wp - place) > 0.25_wp) cycle
        do k = 1, 3
          smallest = min(smallest, norm2(mesh%coordinates(:, nodes(k)) - mesh%coordinates(:, nodes(modulo(k, 3) + 1))))
        end do
      end associate
    end do
  end function smallest
end module test_singular_corners
