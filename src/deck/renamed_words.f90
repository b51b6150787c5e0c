!> Words of decks and results that have another name now: said once for the reader, which names the new word beside
!> the old one, for `qsmpm help renamed` and docs/renamed.md, and for tools/convert-deck, which asks the program.
module qsmpm_renamed_words
  implicit none
  private

  public :: renamed, renamed_text

  !> Said behind the new word.
  character(len=*), parameter, public :: by_converter = ' (tools/convert-deck DECK writes the new words)'

  integer, parameter :: n = 24
  character(len=*), parameter :: keyword = 'keyword', curves = 'curves.csv'

  type :: renamed_type
    !> `keyword`, the keyword that a parameter belongs to (its present name), or the file of a result.
    character(len=n) :: where
    character(len=n) :: old, new
  end type renamed_type

  type(renamed_type), parameter :: words(*) = [ &
    renamed_type(keyword, 'LOCKING CURE', 'VOLUMETRIC LOCKING'), &
    renamed_type(keyword, 'HOLD TEST', 'CONSTANT LOAD TEST'), &
    renamed_type('CONTROLS', 'FEW ITERATIONS', 'DESIRED MIN ITERATIONS'), &
    renamed_type('CONTROLS', 'MANY ITERATIONS', 'DESIRED MAX ITERATIONS'), &
    renamed_type('CONTROLS', 'LARGEST MOVE', 'MAX DISPLACEMENT'), &
    renamed_type('CONTROLS', 'MAX HOLDS', 'MAX REEQUILIBRATIONS'), &
    renamed_type('CONTROLS', 'HOLD FADE', 'STABILISATION FADE'), &
    renamed_type('CONTROLS', 'PROXIMAL', 'DAMPING'), &
    renamed_type('CONTROLS', 'DRAG SHARE', 'DAMPING SHARE'), &
    renamed_type('STRENGTH PROFILE', 'TYPE=FIELD', '*FIELD OF VALUES'), &
    renamed_type(curves, 'drag_share', 'damping_share')]

contains

  !> Present name of a word; empty when it was not renamed.
  pure function renamed(where, old) result(new)
    !> `keyword`, or the keyword as it is now that a parameter belongs to; the word in capitals, without a star.
    character(len=*), intent(in) :: where, old
    character(len=:), allocatable :: new
    integer :: i

    new = ''
    do i = 1, size(words)
      if (words(i)%where == where .and. words(i)%old == old) new = trim(words(i)%new)
    end do
  end function renamed

  !> All renamed words as a table in Markdown.
  pure function renamed_text() result(text)
    character(len=:), allocatable :: text
    integer :: i

    text = '| where | old | new |'//new_line('a')//'|---|---|---|'//new_line('a')
    do i = 1, size(words)
      text = text//'| '//shown(words(i)%where)//' | `'//trim(words(i)%old)//'` | `'//trim(words(i)%new)//'` |'// &
        new_line('a')
    end do
  end function renamed_text

  !> The place of a word as a reader knows it.
  pure function shown(where) result(text)
    character(len=*), intent(in) :: where
    character(len=:), allocatable :: text

    text = '*'//trim(where)
    if (where == keyword .or. where == curves) text = trim(where)
  end function shown
end module qsmpm_renamed_words
