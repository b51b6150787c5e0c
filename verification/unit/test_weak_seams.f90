!> Which bodies are seams that a grid holds up: weaker than what they lie between, and thinner than three cells.
module test_weak_seams
  use deck_samples, only: joined
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck
  use qsmpm_error, only: error_type
  use qsmpm_layer_interfaces, only: thin_seam
  use qsmpm_messages, only: message_list_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_weak_seams

contains

  !> All checks, on cells of a half.
  subroutine collect_weak_seams(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('weak_seams')
    call expect(tests, 'clay of half a cell between rocks', 2, &
      body('floor', 'rock', '0, 8, 0, 2')//body('seam', 'clay', '0, 8, 2, 2.25')//body('block', 'rock', '0, 8, 2.25, 4'))
    call expect(tests, 'the same between soils that are stronger', 2, &
      body('floor', 'sand', '0, 8, 0, 2')//body('seam', 'clay', '0, 8, 2, 2.25')//body('block', 'sand', '0, 8, 2.25, 4'))
    call expect(tests, 'three cells are enough', 0, &
      body('floor', 'rock', '0, 8, 0, 2')//body('seam', 'clay', '0, 8, 2, 3.5')//body('block', 'rock', '0, 8, 3.5, 4'))
    call expect(tests, 'slices of the ground beside a wall are none', 0, &
      body('wall', 'rock', '3, 4, 0, 4')//body('ground', 'clay', '0, 3, 0, 2')//body('first', 'clay', '0, 3, 3, 4')// &
      body('second', 'clay', '0, 3, 2, 3'))
    call expect(tests, 'nor is a layer that lies open on rock', 0, &
      body('floor', 'rock', '0, 8, 0, 2')//body('cover', 'clay', '0, 8, 2, 3'))
    call expect(tests, 'nor a body that cannot yield', 0, &
      body('floor', 'rock', '0, 8, 0, 2')//body('plate', 'rock', '0, 8, 2, 2.25')//body('block', 'rock', '0, 8, 2.25, 4'))
  end subroutine collect_weak_seams

  !> A body as a deck has it.
  pure function body(name, material, box) result(lines)
    character(len=*), intent(in) :: name, material, box
    character(len=:), allocatable :: lines

    lines = '*BODY, NAME='//name//', MATERIAL='//material//', SHAPE=BOX|'//box//'|'
  end function body

  !> The seam among some bodies.
  subroutine expect(tests, sentence, seam, bodies)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: sentence
    !> Its number, 0 for none.
    integer, intent(in) :: seam
    character(len=*), intent(in) :: bodies
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('seam.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID|X, 0, 8, 16|Y, 0, 4, 8|'// &
      '*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=rock|*ELASTIC|80000, 0.2|*MATERIAL, NAME=clay|*ELASTIC|5000, 0.45|'// &
      '*MOHR COULOMB|12, 0, 0|*MATERIAL, NAME=sand|*ELASTIC|20000, 0.3|*MOHR COULOMB|15, 30, 0|'//bodies// &
      '*PHASE, NAME=weight|*FIX|base, ALL|*GRAVITY|0, -1|*END PHASE|'), analysis, messages, error)
    call tests%check(sentence, .not. allocated(error))
    if (.not. allocated(error)) call tests%check(sentence//', by its number', thin_seam(analysis) == seam)
  end subroutine expect
end module test_weak_seams
