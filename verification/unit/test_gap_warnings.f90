!> Gaps between bodies that a grid carries forces across, and what is none.
module test_gap_warnings
  use deck_samples, only: joined
  use qsmpm_analysis, only: analysis_type, plane_strain, three_dimensional
  use qsmpm_deck, only: parse_deck
  use qsmpm_error, only: error_type
  use qsmpm_layer_warnings, only: gap_notes
  use qsmpm_messages, only: message_list_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_gap_warnings

contains

  !> All checks, on cells of 1/2 along x and 1 along y.
  subroutine collect_gap_warnings(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: splines = 'SPLINE2G', elements = 'STANDARD'

    call tests%start('gap_warnings')
    call expect(tests, 'layers apart', elements, box('a', '0, 8, 0, 2')//box('b', '0, 8, 2.3, 4'), &
      "'a' and 'b' are 0.3 apart")
    call expect(tests, 'layers that touch', elements, box('a', '0, 8, 0, 2')//box('b', '0, 8, 2, 4'), '')
    call expect(tests, 'layers that miss by a hair', elements, box('a', '0, 8, 0, 2')//box('b', '0, 8, 2.04, 4'), '')
    call expect(tests, 'layers with another one between them', elements, &
      box('a', '0, 8, 0, 2')//box('b', '0, 8, 2.5, 4')//box('c', '0, 8, 2, 2.5'), '')
    call expect(tests, 'columns, by the size of cells across', elements, &
      box('a', '0, 4, 0, 4')//box('b', '4.6, 8, 0, 4'), '')
    call expect(tests, 'columns, nearer', elements, box('a', '0, 4, 0, 4')//box('b', '4.4, 8, 0, 4'), &
      "'a' and 'b' are 0.4 apart")
    call expect(tests, 'splines reach farther', splines, box('a', '0, 4, 0, 4')//box('b', '4.8, 8, 0, 4'), &
      "'a' and 'b' are 0.8 apart")
    call expect(tests, 'so far they do not', splines, box('a', '0, 4, 0, 4')//box('b', '5.1, 8, 0, 4'), '')
    call expect(tests, 'a trench in a body', elements, polygon('a', '0, 0|8, 0|8, 4|4.3, 4|4.3, 2|4, 2|4, 4|0, 4'), &
      "body 'a' has a gap of 0.3")
    call expect(tests, 'the same drawn the other way round', elements, &
      polygon('a', '0, 4|4, 4|4, 2|4.3, 2|4.3, 4|8, 4|8, 0|0, 0'), "body 'a' has a gap of 0.3")
    call expect(tests, 'a gap that narrows, where it is seen first', elements, &
      polygon('a', '0, 0|8, 0|8, 2.4|0, 2.2')//box('b', '0, 8, 2.8, 4'), "'a' and 'b' are 0.4201 apart")
    call check_given(tests)
    call expect(tests, 'a body that is thin itself', elements, box('a', '0, 4, 0, 0.3'), '')
    call expect(tests, 'a slope beside ground', elements, &
      box('a', '0, 8, 0, 2')//polygon('b', '2, 2|6, 2|5, 3|3, 3'), '')
    call expect(tests, 'a body that comes later', elements, box('a', '0, 8, 0, 2')// &
      '*BODY, NAME=b, MATERIAL=soil, SHAPE=BOX, ACTIVE=NO|0, 8, 2.3, 4|', "'a' and 'b' are 0.3 apart")
  end subroutine collect_gap_warnings

  !> Analyses of programs: a polygon the other way round, none at all, space.
  subroutine check_given(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: analysis

    call read_deck('STANDARD', box('a', '0, 8, 0, 2')//polygon('b', '0, 2.3|8, 2.3|8, 4|0, 4'), analysis)
    analysis%bodies(2)%polygon = analysis%bodies(2)%polygon(:, 4:1:-1)
    call tests%check('a polygon that a program gives the other way round', index(gap_notes(analysis), &
      "'a' and 'b' are 0.3 apart") > 0)
    analysis%model = three_dimensional
    call tests%check('space is not looked at', len(gap_notes(analysis)) == 0)
    analysis%model = plane_strain
    deallocate (analysis%bodies)
    call tests%check('no body', len(gap_notes(analysis)) == 0)
  end subroutine check_given

  !> Bodies as a deck has them.
  pure function box(name, bounds) result(lines)
    character(len=*), intent(in) :: name, bounds
    character(len=:), allocatable :: lines

    lines = '*BODY, NAME='//name//', MATERIAL=soil, SHAPE=BOX|'//bounds//'|'
  end function box

  pure function polygon(name, corners) result(lines)
    character(len=*), intent(in) :: name, corners
    character(len=:), allocatable :: lines

    lines = '*BODY, NAME='//name//', MATERIAL=soil, SHAPE=POLYGON|'//corners//'|'
  end function polygon

  !> What is said of some bodies; each gap is told once.
  subroutine expect(tests, what, basis, bodies, words)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: what, basis, bodies
    !> Of the warning, '' where there is none.
    character(len=*), intent(in) :: words
    class(analysis_type), allocatable :: analysis
    character(len=:), allocatable :: notes

    call read_deck(basis, bodies, analysis)
    notes = gap_notes(analysis)
    if (len(words) == 0) then
      call tests%check(what//': nothing to say, not "'//notes//'"', len(notes) == 0)
    else
      call tests%check(what//': told as '//words//', not "'//notes//'"', index(notes, words) > 0)
      call tests%check(what//': one warning, not "'//notes//'"', index(notes, 'warning:') > 0 .and. &
        index(notes, 'warning:') == index(notes, 'warning:', back=.true.))
    end if
  end subroutine expect

  !> A deck of some bodies.
  subroutine read_deck(basis, bodies, analysis)
    character(len=*), intent(in) :: basis, bodies
    class(analysis_type), allocatable, intent(out) :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('gap.inp', joined('*MODEL, TYPE=PLANE STRAIN|*METHOD, BASIS='//basis//', INTEGRATION=CELL|'// &
      '*GRID, ELEMENT=QUAD4|X, 0, 8, 16|Y, 0, 4, 4|*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=soil|*ELASTIC|'// &
      '5000, 0.3|*MOHR COULOMB|12, 20, 0|'//bodies//'*PHASE, NAME=weight|*FIX|base, ALL|*GRAVITY|0, -1|*END PHASE|'), &
      analysis, messages, error)
    if (allocated(error)) error stop 'a deck of the gap_warnings suite is broken'
  end subroutine read_deck
end module test_gap_warnings
