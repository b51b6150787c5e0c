!> The hand-written head of the deck reference (docs/deck.md): rules that hold for all cards, and
!> exit codes. The cards themselves follow from the keyword table.
module qsmpm_deck_reference_head
  implicit none
  private

  public :: reference_head

  character(len=1), parameter :: n = new_line('a')

contains

  !> The head of the page.
  pure function reference_head() result(text)
    character(len=:), allocatable :: text

    text = '# Deck reference'//n//n// &
      'This page is written by `qsmpm help --markdown` from the table that the reader of decks and'//n// &
      '`qsmpm help KEYWORD` use; do not edit it.'//n//n//writing()//strictness()//order()//exit_codes()// &
      n//'## Keywords'//n
  end function reference_head

  !> How cards are written.
  pure function writing() result(text)
    character(len=:), allocatable :: text

    text = '## Writing'//n//n// &
      '- A card is a line `*KEYWORD, PARAMETER=value, ...` and the data lines below it, items between'//n// &
      '  commas. `**` begins a comment line; empty lines are skipped.'//n// &
      '- Keywords, parameters and words of a choice may be in capitals or not; blanks inside them count'//n// &
      '  as one. Names of sets, bodies, materials and files keep their case.'//n// &
      '- A comma at the end of a line goes on with the next line. Lines may be of any length.'//n// &
      '- Numbers: `1`, `1.0`, `1e3`, `1d3`. Nothing is abbreviated or cut off.'//n// &
      '- A value or name that holds a comma or an equals sign stands in double quotes.'//n// &
      '- Files are relative to the file that names them. `*INCLUDE` puts the lines of another file in its'//n// &
      '  place; it may bring cards, or data lines of the card before.'//n// &
      '- Units are consistent and only labelled (`*UNITS`). Tension is positive. Angles are in degrees.'//n// &
      '- Stress components: XX, YY, ZZ, XY, XZ, YZ. Plane and axisymmetric models have x (radius) and y.'//n//n
  end function writing

  !> What is an error.
  pure function strictness() result(text)
    character(len=:), allocatable :: text

    text = '## Errors'//n//n// &
      'An unknown keyword, parameter, word or name, a card or parameter given twice, a parameter without'//n// &
      'meaning beside the others, a wrong number of items, a number that is none or out of its range: each'//n// &
      'is an error. All errors of a deck are listed, in its order, as'//n//n// &
      '```'//n// &
      "slope.inp:27: *CONTROLS: unknown parameter 'TOLERENCE' (did you mean TOLERANCE?)"//n// &
      '```'//n//n// &
      'and the program ends with exit code 2 before it writes anything. A warning looks alike, with'//n// &
      '`warning:` behind the line, and stops nothing.'//n//n
  end function strictness

  !> Order of cards and the echo.
  pure function order() result(text)
    character(len=:), allocatable :: text

    text = '## Order'//n//n// &
      'The model comes first, in any order, except that properties follow their `*MATERIAL`. Then come the'//n// &
      'phases, `*PHASE` to `*END PHASE`, in the order they are run.'//n//n// &
      'Every run writes `<job>.echo.inp`: the same analysis with includes resolved and every default'//n// &
      'spelt out. It is a deck and gives the same results; mesh files are named by their full path.'//n//n
  end function order

  !> Exit codes of the program.
  pure function exit_codes() result(text)
    character(len=:), allocatable :: text

    text = '## Exit codes'//n//n// &
      '| code | meaning |'//n//'|---|---|'//n//'| 0 | done |'//n//'| 1 | wrong call, or anything not below |'//n// &
      '| 2 | the deck, or the mesh it names |'//n//'| 3 | not converged |'//n// &
      '| 4 | a material point left the mesh |'//n//'| 5 | singular equations |'//n//'| 6 | user material |'//n// &
      '| 130, 143 | stopped by a signal; `restart.h5` continues the run |'//n
  end function exit_codes
end module qsmpm_deck_reference_head
