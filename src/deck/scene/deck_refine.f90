!> *REFINE: boxes in which triangles that fit the scene are smaller than the cells of the grid.
module qsmpm_deck_refine
  use qsmpm_card_fields, only: card_fields_type, column_type
  use qsmpm_cards, only: card_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_keyword_table, only: table_type, in_model, once
  implicit none
  private

  public :: add_refine_keyword

contains

  !> *REFINE.
  subroutine add_refine_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('REFINE', in_model, once, 'Boxes in which triangles that fit the scene are smaller than the '// &
      'cells between the lines of *GRID, with cells in between around them: where ground fails, or a corner loads '// &
      'it. A corner is a box of no size. An eighth of a cell of the grid is the least; corners at which soil turns '// &
      'inwards and ends of loads have it anyway. `qsmpm-verify study` finds the boxes.', refine_fields, &
      '*REFINE| 0, 2, -1, 0, 0.1| 2, 2, 0, 0, 0.05', check_boxes)
  end subroutine add_refine_keyword

  !> *REFINE.
  subroutine refine_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    logical :: given

    associate (mesh => deck%analysis%mesh)
      given = .false.
      if (allocated(mesh%refined)) given = size(mesh%refined, 2) > 0
      call fields%given(given)
      call fields%table('boxes', [column_type('xmin', 'least x'), column_type('xmax', 'largest x'), &
        column_type('ymin', 'least y'), column_type('ymax', 'largest y'), &
        column_type('width', 'width of the triangles', range='(0, inf)')], mesh%refined)
    end associate
  end subroutine refine_fields

  !> A box ends where it begins, or beyond.
  subroutine check_boxes(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (refined => state%analysis%mesh%refined)
      do i = 1, size(refined, 2)
        if (refined(2, i) < refined(1, i) .or. refined(4, i) < refined(3, i)) call state%error_at(card, card%rows(i), &
          'the box ends before it begins')
      end do
    end associate
  end subroutine check_boxes
end module qsmpm_deck_refine
