!> All keywords of the deck, in the order of the deck reference and of the echo. A new keyword is an entry with its
!> fields in one of the modules used here.
module qsmpm_keywords
  use qsmpm_keyword_table, only: table_type
  use qsmpm_deck_general, only: add_general_keywords, add_history_keyword
  use qsmpm_deck_mesh, only: add_grid_keyword
  use qsmpm_deck_bodies, only: add_set_keywords
  use qsmpm_deck_materials, only: add_material_keywords
  use qsmpm_deck_phases, only: add_phase_keywords
  use qsmpm_deck_rigid_bodies, only: add_rigid_body_keywords
  use qsmpm_deck_stages, only: add_prop_keyword
  use qsmpm_deck_point, only: add_point_keywords
  implicit none
  private

  public :: make_table

contains

  !> Makes the keyword table.
  subroutine make_table(table)
    type(table_type), intent(out) :: table

    call add_general_keywords(table)
    call add_grid_keyword(table)
    call add_set_keywords(table)
    call add_rigid_body_keywords(table)
    call add_prop_keyword(table)
    call add_material_keywords(table)
    call add_history_keyword(table)
    call add_phase_keywords(table)
    call add_point_keywords(table)
  end subroutine make_table
end module qsmpm_keywords
