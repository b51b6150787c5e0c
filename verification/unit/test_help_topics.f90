!> Words of geotechnics that are no keywords: every one has an answer, and every card an answer names exists.
module test_help_topics
  use testing, only: tests_type
  use qsmpm_text, only: string_type, split
  use qsmpm_keyword_table, only: table_type
  use qsmpm_keywords, only: make_table
  use qsmpm_deck_help, only: help_text
  use qsmpm_help_topics, only: topic_text, topics, topics_type
  implicit none
  private

  public :: collect_help_topics

contains

  subroutine collect_help_topics(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('help_topics')
    call words_of_engineers(tests)
    call cards_exist(tests)
  end subroutine collect_help_topics

  !> What a geotechnical engineer types is answered, with the card or with what is nearest.
  subroutine words_of_engineers(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: asked(*) = [character(len=20) :: 'water', 'pile', 'Contact', 'excavate', &
      'factor of safety', 'anchor', 'seepage', 'earthquake', 'embankment', 'phi-c', 'wall', 'sheet pile', 'stage', &
      'K0 procedure', 'lift', 'dewatering', 'consolidation', 'settlement', 'cohesion', 'limit load', 'amplitude', &
      'landslide', 'density', 'tunnel', 'young''s modulus', 'drainage', &
      'wall friction', 'friction angle', 'reaction', 'displacement control', 'gravity loading', 'time', &
      'creep in time', 'yield', 'nlgeom', 'refinement', 'stiff', 'soft', 'failure', 'strain softening', 'slope', &
      'footing', 'friction', 'total stress', 'movie', 'gmsh', 'python', 'bishop', 'monte carlo', 'liquefaction', 'ocr', &
      'rigid', 'c', 'speed', 'concrete', 'rain', 'volume loss', 'contraction', 'dxf', 'strut', 'prop', 'soil nail', &
      'interface', 'dynamic', 'dynamics', 'tbm', 'lining', 'shoring', 'vibration', &
      'volume-loss', 'anisotropy', 'small strain']
    character(len=*), parameter :: answer(*) = [character(len=20) :: '*WATER LEVEL', '*RIGID BODY', '*CONTACT', &
      '*DEACTIVATE', '*SAFETY', '*PROP', 'SEEPAGE', 'no inertia', '*ACTIVATE', '*SAFETY', 'walls', 'walls', &
      '*DEACTIVATE', '*K0', 'FILL=LEVEL', '*WATER LEVEL', 'excess', '*HISTORY', '*MOHR COULOMB', &
      'LIMIT COMPLIANCE', '*PHASE', 'RUNOUT', '*UNIT WEIGHT', '*CONTRACTION', '*ELASTIC', '*UNDRAINED', &
      '*CONTACT', '*MOHR COULOMB', '*HISTORY', '*PRESCRIBE', '*INITIAL', 'equilibrium', &
      '*SOFT SOIL CREEP', '*MOHR COULOMB', 'KINEMATICS', '*GRID', '*ELASTIC', '*ELASTIC', 'LIMIT COMPLIANCE', '*SOFTENING', &
      'POLYGON', '*RIGID BODY', '*CONTACT', 'FIELDS', '*FIELD', '*MESH', 'embedding', 'slices', 'reliability DECK', &
      '*USER MATERIAL', '*CAM CLAY', '*RIGID BODY', '*MOHR COULOMB', 'plan', '*ELASTIC', 'steady rain', &
      '*CONTRACTION', '*CONTRACTION', 'qsmpm-verify import', '*PROP', '*PROP', '*PROP', '*CONTACT', 'no inertia', 'no inertia', &
      '*CONTRACTION', 'stiff', '*PROP', 'no inertia', '*CONTRACTION', '*NGI ADP', 'gamma_07']
    character(len=:), allocatable :: text
    logical :: found
    integer :: k

    do k = 1, size(asked)
      call help_text(trim(asked(k)), text, found)
      call tests%check(trim(asked(k))//' is answered', found .and. index(text, trim(answer(k))) > 0)
    end do
    call tests%check('a topic of its own goes before one that a word holds', index(topic_text('PILE'), 'RIGID') > 0 .and. &
      index(topic_text('SHEET PILE'), 'walls') > 0 .and. index(topic_text('SEEPAGE FLOW'), 'flows') > 0)
    call help_text('pudding', text, found)
    call tests%check('a word without an answer is unknown', .not. found .and. index(text, 'unknown') > 0)
    call help_text('GRAVTY', text, found)
    call tests%check('a slip of the pen is told as one', .not. found .and. index(text, 'GRAVITY') > 0)
    call tests%check('a short word of a topic is not held by a longer one', len(topic_text('PICTON')) == 0 .and. &
      len(topic_text('SUBWALL')) == 0)
    call tests%check('a word that is none has no topic', len(topic_text('PUDDING')) == 0)
  end subroutine words_of_engineers

  !> A card that an answer names is a keyword: the words behind a star begin with one.
  subroutine cards_exist(tests)
    type(tests_type), intent(inout) :: tests
    type(topics_type), allocatable :: known(:)
    type(string_type), allocatable :: pieces(:)
    type(table_type) :: table
    integer :: k, i

    call make_table(table)
    allocate (known, source=topics())
    do k = 1, size(known)
      call split(trim(known(k)%answer), '*', pieces)
      do i = 2, size(pieces)
        call tests%check('card exists: *'//pieces(i)%text(:min(20, len(pieces(i)%text))), &
          begins_with_card(pieces(i)%text))
      end do
      call tests%check('answer is whole: '//trim(known(k)%words), len_trim(known(k)%answer) < len(known(k)%answer))
    end do

  contains

    logical function begins_with_card(text)
      character(len=*), intent(in) :: text
      integer :: j

      begins_with_card = .false.
      do j = 1, table%count
        if (index(text, table%keywords(j)%name) == 1) begins_with_card = .true.
      end do
    end function begins_with_card
  end subroutine cards_exist
end module test_help_topics
