!> Cards of the soil laws of qsmpm_standard_laws, as each describes itself: nothing here knows any of them.
module qsmpm_deck_soil_laws
  use qsmpm_carried_cards, only: note_card
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_error, only: error_type
  use qsmpm_keyword_table, only: table_type, in_material, once
  use qsmpm_law_parameters, only: law_parameters_type, law_parameters_slot_type, law_description_type
  use qsmpm_principal_model, only: principal_model_type
  use qsmpm_soil_model, only: soil_model_type
  use qsmpm_standard_laws, only: standard_laws
  implicit none
  private

  public :: add_soil_law_keywords

contains

  !> One card a law.
  subroutine add_soil_law_keywords(table)
    type(table_type), intent(inout) :: table
    type(law_parameters_slot_type), allocatable :: laws(:)
    type(law_description_type) :: law
    integer :: i

    call standard_laws(laws)
    do i = 1, size(laws)
      law = laws(i)%parameters%describe()
      call table%add(law%keyword, in_material, once, law%sentence, soil_law_fields, law%example, check_soil_law)
    end do
  end subroutine add_soil_law_keywords

  !> The card of a law: the material's own where it has that one, else one with default parameters.
  subroutine soil_law_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    class(law_parameters_type), allocatable :: law
    type(law_description_type) :: other
    logical :: given

    associate (material => deck%analysis%materials(deck%material))
      given = .false.
      if (allocated(material%soil_law)) then
        other = material%soil_law%describe()
        given = other%keyword == fields%keyword
        if (fields%reading) call deck%error_from(material%where, 'MATERIAL', "material '"//material%name// &
          "' has more than one law: *"//other%keyword//' and *'//fields%keyword)
      end if
      if (given) then
        allocate (law, source=material%soil_law)
      else
        call find_law(fields%keyword, law)
      end if
      call fields%there(given)
      call law%fields(fields)
      if (fields%reading) call move_alloc(law, material%soil_law)
    end associate
  end subroutine soil_law_fields

  !> A law by the keyword of its card.
  subroutine find_law(keyword, law)
    character(len=*), intent(in) :: keyword
    class(law_parameters_type), allocatable, intent(out) :: law
    type(law_parameters_slot_type), allocatable :: laws(:)
    type(law_description_type) :: described
    integer :: i

    call standard_laws(laws)
    do i = 1, size(laws)
      described = laws(i)%parameters%describe()
      if (described%keyword == keyword) call move_alloc(laws(i)%parameters, law)
    end do
  end subroutine find_law

  !> Whether the parameters make a model, here, where the line is known.
  subroutine check_soil_law(state)
    type(deck_state_type), intent(inout) :: state
    class(principal_model_type), allocatable :: model
    class(soil_model_type), allocatable :: soil
    type(law_description_type) :: described
    type(error_type), allocatable :: error

    if (.not. state%card%is_right()) return
    associate (law => state%analysis%materials(state%material)%soil_law)
      described = law%describe()
      if (described%keeps_tensor) call note_card(state%analysis, state%card%keyword//' with a strain history')
      call law%make_soil_model(soil, error)
      if (.not. (allocated(error) .or. allocated(soil))) call law%make_model(model, error)
    end associate
    if (allocated(error)) call state%error_at(state%card%rows(1), error%message)
  end subroutine check_soil_law
end module qsmpm_deck_soil_laws
