!> State of reading or writing a deck: the analysis so far, the messages, and the position of the reader.
!>
!> A card belongs to the analysis as a whole, or to one item of a list of it (a material, a body, a load of a phase).
!> Items are opened by the cards that begin them, and counted and traversed by the echo, all by their number.
module qsmpm_deck_state
  use qsmpm_named, only: named_type, place_named, add_names
  use qsmpm_analysis, only: analysis_type
  use qsmpm_source_line, only: source_line_type
  use qsmpm_file, only: directory_of, joined, absolute_path
  use qsmpm_text, only: string_type, word_place, did_you_mean
  use qsmpm_messages, only: message_list_type, line_origin_type, severity_error, severity_warning
  use qsmpm_cards, only: card_type, row_type
  use qsmpm_body_description, only: body_type
  use qsmpm_history_description, only: history_type
  use qsmpm_load_description, only: traction_type, support_type, water_level_type
  use qsmpm_material_description, only: material_type
  use qsmpm_mesh_description, only: set_type, surface_type, mesh_none
  use qsmpm_phase_description, only: phase_type
  use qsmpm_structures, only: rigid_body_type, contact_type, rigid_move_type, prop_type
  use qsmpm_point_test, only: point_stage_type
  use qsmpm_recommended_method, only: undecided_method
  implicit none
  private

  public :: deck_state_type, points_request_type, check_name, source_line, beside_deck, empty_deck, prototype_deck, &
    open_item, count_items, go_to_item, check_new_name

  !> A *POINTS card, stored until all bodies are known.
  type :: points_request_type
    type(source_line_type) :: where
    !> Empty: for all bodies without their own *POINTS.
    character(len=:), allocatable :: body
    integer :: per_element = 0
  end type points_request_type

  !> State of a deck that is read or written.
  type :: deck_state_type
    type(analysis_type) :: analysis
    type(message_list_type) :: messages
    !> Current card; errors are marked in it and in its rows.
    type(card_type), pointer :: card => null()
    !> Material, phase and item of another list (body, set, load, ...) to which the card belongs.
    integer :: material = 0, phase = 0, item = 0
    !> 2 or 3, 0 if *MODEL is missing or wrong.
    integer :: dimension = 0
    !> *MODEL is given, correct or not.
    logical :: model_given = .false.
    !> The deck contains an *INCLUDE that could not be resolved: lines are missing.
    logical :: unresolved = .false.
    !> Last line of the deck, the position of messages on missing keywords.
    type(line_origin_type) :: last
    !> Inside *PHASE ... *END PHASE, and the position where the phase began.
    logical :: in_phase = .false.
    type(line_origin_type) :: phase_place
    type(points_request_type), allocatable :: points(:)
    !> Positions of all lines: items of the analysis only store file and line.
    type(line_origin_type), allocatable :: places(:)
    !> Positions of the data lines of the elements of a mesh in the deck.
    type(line_origin_type), allocatable :: element_places(:)
  contains
    procedure :: report_error, error_at, refuse, refuse_row, error_from, check_once, warn, find_file
  end type deck_state_type

  !> Checks that a name is among those of a list, or among words.
  interface check_name
    procedure :: check_named, check_word
  end interface check_name

  !> Lists; none is the analysis as a whole. The mesh is a part that only one card may define.
  integer, parameter, public :: list_none = 0, list_mesh = 1, list_node_sets = 2, list_element_sets = 3, &
    list_surfaces = 4, list_bodies = 5, list_points = 6, list_materials = 7, list_histories = 8, list_stages = 9, &
    list_rigid_bodies = 10, list_contacts = 11, list_props = 12, list_phases = 13, list_tractions = 14, &
    list_supports = 15, list_water_levels = 16, list_moves = 17
  integer, parameter :: last_list = list_moves

contains

  !> Reports an error of the card.
  pure subroutine report_error(self, sentence)
    class(deck_state_type), intent(inout) :: self
    character(len=*), intent(in) :: sentence

    call self%messages%add(severity_error, self%card%place, self%card%keyword, sentence)
  end subroutine report_error

  !> Reports an error of a data line of the card.
  pure subroutine error_at(self, row, sentence)
    class(deck_state_type), intent(inout) :: self
    type(row_type), intent(in) :: row
    character(len=*), intent(in) :: sentence

    call self%messages%add(severity_error, row%place, self%card%keyword, sentence)
  end subroutine error_at

  !> Reports an error of the card and marks the card.
  subroutine refuse(self, sentence)
    class(deck_state_type), intent(inout) :: self
    character(len=*), intent(in) :: sentence

    self%card%good = .false.
    call self%report_error(sentence)
  end subroutine refuse

  !> Reports an error of a data line and marks the line.
  subroutine refuse_row(self, row, sentence)
    class(deck_state_type), intent(inout) :: self
    !> Number of the data line.
    integer, intent(in) :: row
    character(len=*), intent(in) :: sentence

    self%card%rows(row)%good = .false.
    call self%error_at(self%card%rows(row), sentence)
  end subroutine refuse_row

  !> Reports an error of an item of the analysis.
  pure subroutine error_from(self, where, keyword, sentence)
    class(deck_state_type), intent(inout) :: self
    type(source_line_type), intent(in) :: where
    character(len=*), intent(in) :: keyword, sentence

    call self%messages%add(severity_error, place_of(self, where), keyword, sentence)
  end subroutine error_from

  !> Warns of an item of the analysis.
  pure subroutine warn(self, where, keyword, sentence)
    class(deck_state_type), intent(inout) :: self
    type(source_line_type), intent(in) :: where
    character(len=*), intent(in) :: keyword, sentence

    call self%messages%add(severity_warning, place_of(self, where), keyword, sentence)
  end subroutine warn

  !> Checks that no data line of the card repeats the first item of an earlier one.
  pure subroutine check_once(self, what)
    class(deck_state_type), intent(inout) :: self
    !> Kind of the first items.
    character(len=*), intent(in) :: what
    integer :: i, k

    associate (rows => self%card%rows)
      do i = 2, size(rows)
        if (.not. rows(i)%good) cycle
        associate (name => rows(i)%items(1)%text, before => pack([(k, k=1, i - 1)], rows(:i - 1)%good))
          if (any([(rows(before(k))%items(1)%text == name, k=1, size(before))])) call self%error_at(rows(i), &
            what//" '"//name//"' is given twice")
        end associate
      end do
    end associate
  end subroutine check_once

  !> Position of an item: its first occurrence, for a file included twice.
  pure type(line_origin_type) function place_of(self, where) result(place)
    type(deck_state_type), intent(in) :: self
    type(source_line_type), intent(in) :: where
    integer :: i

    place = self%last
    do i = 1, size(self%places)
      if (self%places(i)%line /= where%line) cycle
      if (self%places(i)%file /= where%file) cycle
      place = self%places(i)
      return
    end do
  end function place_of

  !> Converts a position into the form stored in the analysis.
  pure type(source_line_type) function source_line(place) result(where)
    type(line_origin_type), intent(in) :: place

    where%file = place%file
    where%line = place%line
  end function source_line

  !> Returns the full path of a file that a parameter of a card names.
  function beside_deck(card, parameter) result(path)
    type(card_type), intent(in) :: card
    character(len=*), intent(in) :: parameter
    character(len=:), allocatable :: path

    path = absolute_path(joined(directory_of(card%place%file), card%value(parameter)))
  end function beside_deck

  !> Returns the full path of a file that a parameter of the card names, and checks that it exists; an empty name has
  !> already been reported.
  subroutine find_file(self, parameter, path)
    class(deck_state_type), intent(inout) :: self
    character(len=*), intent(in) :: parameter
    character(len=:), allocatable, intent(out) :: path
    logical :: there

    path = beside_deck(self%card, parameter)
    if (len(self%card%value(parameter)) == 0) return
    inquire (file=path, exist=there)
    if (.not. there) call self%report_error("there is no file '"//joined(directory_of(self%card%place%file), &
      self%card%value(parameter))//"'")
  end subroutine find_file

  !> Checks that a name is among those of a list.
  subroutine check_named(state, name, list, where, keyword, what)
    type(deck_state_type), intent(inout) :: state
    !> The name; an empty one has already been reported.
    character(len=*), intent(in) :: name
    class(named_type), intent(in) :: list(:)
    type(source_line_type), intent(in) :: where
    character(len=*), intent(in) :: keyword, what
    type(string_type), allocatable :: names(:)

    if (place_named(list, name) > 0) return
    allocate (names(0))
    call add_names(list, names)
    call check_word(state, name, names, where, keyword, what)
  end subroutine check_named

  !> Checks that a name is among the given ones.
  subroutine check_word(state, name, names, where, keyword, what)
    type(deck_state_type), intent(inout) :: state
    !> The name; an empty one has already been reported.
    character(len=*), intent(in) :: name
    type(string_type), intent(in) :: names(:)
    type(source_line_type), intent(in) :: where
    character(len=*), intent(in) :: keyword, what

    if (len(name) == 0 .or. word_place(names, name) > 0) return
    call state%error_from(where, keyword, 'there is no '//what//" '"//name//"'"//did_you_mean(name, names))
  end subroutine check_word

  !> Initialises an empty deck.
  pure subroutine empty_deck(state)
    type(deck_state_type), intent(inout) :: state

    associate (analysis => state%analysis)
      analysis%deck = ''
      analysis%job = ''
      analysis%heading = ''
      analysis%length_unit = '-'
      analysis%force_unit = '-'
      analysis%method = undecided_method()
      allocate (analysis%node_sets(0), analysis%element_sets(0), analysis%surfaces(0), analysis%bodies(0), &
        analysis%materials(0), analysis%histories(0), analysis%phases(0), analysis%point_test%stages(0), &
        analysis%rigid_bodies(0), analysis%contacts(0), analysis%props(0))
    end associate
    allocate (state%points(0), state%element_places(0), state%places(0))
  end subroutine empty_deck

  !> Returns a deck with one item in every list, from which defaults are taken.
  type(deck_state_type) function prototype_deck() result(state)
    integer :: list

    call empty_deck(state)
    do list = list_node_sets, last_list
      call open_item(state, list)
      call go_to_item(state, list, 1)
    end do
  end function prototype_deck

  !> Appends a new item to a list.
  subroutine open_item(state, list)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: list

    associate (analysis => state%analysis)
      select case (list)
      case (list_node_sets)
        analysis%node_sets = [analysis%node_sets, set_type()]
      case (list_element_sets)
        analysis%element_sets = [analysis%element_sets, set_type()]
      case (list_surfaces)
        analysis%surfaces = [analysis%surfaces, surface_type()]
      case (list_bodies)
        analysis%bodies = [analysis%bodies, body_type()]
      case (list_materials)
        analysis%materials = [analysis%materials, material_type()]
      case (list_histories)
        analysis%histories = [analysis%histories, history_type()]
      case (list_rigid_bodies)
        analysis%rigid_bodies = [analysis%rigid_bodies, rigid_body_type()]
      case (list_contacts)
        analysis%contacts = [analysis%contacts, contact_type()]
      case (list_props)
        analysis%props = [analysis%props, prop_type()]
      case (list_points)
        state%points = [state%points, points_request_type()]
      case (list_stages)
        analysis%point_test%stages = [analysis%point_test%stages, point_stage_type()]
      case (list_phases:)
        call open_phase_item(analysis, list)
      end select
    end associate
  end subroutine open_item

  !> Appends a phase, or a load, support, water level or motion to the last phase.
  pure subroutine open_phase_item(analysis, list)
    type(analysis_type), intent(inout) :: analysis
    integer, intent(in) :: list
    type(phase_type) :: phase

    if (list == list_phases) then
      allocate (phase%fixities(0), phase%prescriptions(0), phase%tractions(0), phase%supports(0), &
        phase%activations(0), phase%deactivations(0), phase%materials(0), &
        phase%installed(0), phase%removed(0), phase%water_levels(0), phase%constant_load_test%at(0), &
        phase%stops(0), phase%moves(0))
      analysis%phases = [analysis%phases, phase]
      return
    end if
    associate (last => analysis%phases(size(analysis%phases)))
      select case (list)
      case (list_tractions)
        last%tractions = [last%tractions, traction_type()]
      case (list_supports)
        last%supports = [last%supports, support_type()]
      case (list_water_levels)
        last%water_levels = [last%water_levels, water_level_type()]
      case (list_moves)
        last%moves = [last%moves, rigid_move_type()]
      end select
    end associate
  end subroutine open_phase_item

  !> Number of items of a list; loads and supports are those of the current phase.
  integer function count_items(state, list) result(count)
    type(deck_state_type), intent(in), target :: state
    integer, intent(in) :: list

    select case (list)
    case (list_none)
      count = 1
    case (list_mesh)
      count = merge(0, 1, state%analysis%mesh%kind == mesh_none)
    case (list_points)
      count = size(state%points)
    case (list_contacts)
      count = size(state%analysis%contacts)
    case (list_stages)
      count = size(state%analysis%point_test%stages)
    case (list_tractions)
      count = size(state%analysis%phases(state%phase)%tractions)
    case (list_supports)
      count = size(state%analysis%phases(state%phase)%supports)
    case (list_water_levels)
      count = size(state%analysis%phases(state%phase)%water_levels)
    case (list_moves)
      count = size(state%analysis%phases(state%phase)%moves)
    case default
      count = size(named_items(state%analysis, list))
    end select
  end function count_items

  !> Sets the item to which the following cards belong.
  pure subroutine go_to_item(state, list, number)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: list, number

    select case (list)
    case (list_materials)
      state%material = number
    case (list_phases)
      state%phase = number
    case default
      state%item = number
    end select
  end subroutine go_to_item

  !> Checks that the name of the last item of a list is unique; an empty one has been reported.
  subroutine check_new_name(state, list, what)
    type(deck_state_type), intent(inout), target :: state
    integer, intent(in) :: list
    character(len=*), intent(in) :: what
    class(named_type), pointer :: items(:)
    integer :: i, last

    items => named_items(state%analysis, list)
    if (.not. associated(items)) return
    last = size(items)
    if (len(items(last)%name) == 0) return
    do i = 1, last - 1
      if (items(i)%name == items(last)%name) call state%report_error('there is already a '//what//" '"// &
        items(i)%name//"'")
    end do
  end subroutine check_new_name

  !> Returns the items of a list that have names; null for the others.
  function named_items(analysis, list) result(items)
    type(analysis_type), intent(in), target :: analysis
    integer, intent(in) :: list
    class(named_type), pointer :: items(:)

    nullify (items)
    select case (list)
    case (list_node_sets)
      items => analysis%node_sets
    case (list_element_sets)
      items => analysis%element_sets
    case (list_surfaces)
      items => analysis%surfaces
    case (list_bodies)
      items => analysis%bodies
    case (list_materials)
      items => analysis%materials
    case (list_histories)
      items => analysis%histories
    case (list_rigid_bodies)
      items => analysis%rigid_bodies
    case (list_props)
      items => analysis%props
    case (list_phases)
      items => analysis%phases
    end select
  end function named_items
end module qsmpm_deck_state
