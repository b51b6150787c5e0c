!> The hand-written head of the deck reference (docs/deck.md): rules that hold for all cards, and
!> exit codes. The cards themselves follow from the keyword table.
module qsmpm_deck_reference_head
  implicit none
  private

  public :: reference_head

  integer, parameter :: width = 92

contains

  !> The head of the page.
  pure function reference_head() result(text)
    character(len=:), allocatable :: text

    text = page([character(len=width) :: &
      '# Deck reference', '', &
      'This page is written by `qsmpm help --markdown` from the table that the reader of decks', &
      'and `qsmpm help KEYWORD` use; do not edit it.', ''])//writing()//rules()// &
      page([character(len=width) :: '', '## Keywords'])
  end function reference_head

  !> Lines with newlines.
  pure function page(lines) result(text)
    character(len=*), intent(in) :: lines(:)
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(lines)
      text = text//trim(lines(i))//new_line('a')
    end do
  end function page

  !> How cards are written.
  pure function writing() result(text)
    character(len=:), allocatable :: text

    text = page([character(len=width) :: '## Writing', '', &
      '- A card is a line `*KEYWORD, PARAMETER=value, ...` and the data lines below it, their', &
      '  items between commas. `**` begins a comment line; empty lines are skipped.', &
      '- Keywords, parameters and words of a choice may be in capitals or not; blanks inside', &
      '  them count as one. Names of sets, bodies, materials and files keep their case.', &
      '- A comma at the end of a line goes on with the next line. Lines may be of any length.', &
      '- Numbers: `1`, `1.0`, `1e3`, `1d3`. Nothing is abbreviated or cut off.', &
      '- A value or name that holds a comma or an equals sign stands in double quotes.', &
      '- Numbers of a data line may be given by name, in any order and on any number of lines:', &
      "  `E50ref=3e4` or `phi'=30, c'=2`. Names are the columns', without regard to capitals,", &
      "  blanks, `_`, `'`, `*`, `.`, `^` and the endings `ref`, `ur`, `rm`, `unsat`, `x`. Numbers", &
      '  without a name come first, in the order of the columns.', &
      '- Files are relative to the file that names them. `*INCLUDE` puts the lines of another', &
      '  file in its place; it may bring cards, or data lines of the card before.', &
      '- Units are consistent and only labelled (`*UNITS`). Tension is positive. Angles are in', &
      '  degrees.', &
      '- Stress components: XX, YY, ZZ, XY, XZ, YZ. Plane and axisymmetric models have x', &
      '  (the radius) and y.', ''])
  end function writing

  !> What is an error, the order of cards and the echo, exit codes of the program.
  pure function rules() result(text)
    character(len=:), allocatable :: text

    text = page([character(len=width) :: '## Errors', '', &
      'An unknown keyword, parameter, word or name, a card or parameter given twice, a', &
      'parameter without meaning beside the others, a wrong number of items, a number that is', &
      'none or out of its range: each is an error. All errors of a deck are listed, in its', &
      'order, as', '', '```', &
      "slope.inp:27: *CONTROLS: unknown parameter 'TOLERENCE' (did you mean TOLERANCE?)", &
      '```', '', &
      'and the program ends with exit code 2 before it writes anything. A warning looks alike,', &
      'with `warning:` behind the line, and stops nothing.', '', &
      '## Order', '', &
      'The model comes first, in any order, except that properties follow their `*MATERIAL`.', &
      'Then come the phases, `*PHASE` to `*END PHASE`, in the order they are run. A deck of one', &
      'material point (`qsmpm point`) has a `*POINT TEST` and its `*POINT STAGE` cards instead.', '', &
      'Every run writes `<job>.echo.inp`: the same analysis with includes resolved and every', &
      'default spelt out. It is a deck and gives the same results; a mesh file is named by its', &
      'full path.', '', &
      '## Exit codes', '', &
      '| code | meaning |', &
      '|---|---|', &
      '| 0 | done |', &
      '| 1 | wrong call, or anything not below |', &
      '| 2 | the deck, or the mesh it names |', &
      '| 3 | not converged, in any of the phases |', &
      '| 4 | a material point left the mesh |', &
      '| 5 | singular equations from the first iteration on: supports or stiffness are missing |', &
      '| 6 | user material |', '| 130, 143 | stopped by a signal; `restart.h5` continues the run |'])
  end function rules
end module qsmpm_deck_reference_head
