!> What a card is about: the analysis as a whole, or one item of a list of it (a material, a body, a load of a phase).
!> Lists are opened by the cards that begin an item, counted and gone through by the echo, all by their number.
module qsmpm_deck_objects
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_description, only: body_type
  use qsmpm_history_description, only: history_type
  use qsmpm_load_description, only: traction_type, support_type, water_level_type
  use qsmpm_material_description, only: material_type
  use qsmpm_named, only: named_type
  use qsmpm_mesh_description, only: set_type, surface_type, mesh_none
  use qsmpm_phase_description, only: phase_type
  use qsmpm_structures, only: rigid_body_type, contact_type, rigid_move_type, prop_type
  use qsmpm_deck_state, only: deck_state_type, points_request_type
  use qsmpm_point_test, only: point_stage_type
  use qsmpm_recommended_method, only: undecided_method
  implicit none
  private

  public :: empty_deck, prototype_deck, open_item, count_items, go_to_item, check_new_name

  !> Lists; none is the analysis as a whole, of which the mesh is a part that only one card may bring.
  integer, parameter, public :: list_none = 0, list_mesh = 1, list_node_sets = 2, list_element_sets = 3, &
    list_surfaces = 4, list_bodies = 5, list_points = 6, list_materials = 7, list_histories = 8, list_stages = 9, &
    list_rigid_bodies = 10, list_contacts = 11, list_props = 12, list_phases = 13, list_tractions = 14, &
    list_supports = 15, list_water_levels = 16, list_moves = 17
  integer, parameter :: last_list = list_moves

contains

  !> A deck with nothing in it.
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

  !> A deck with one item in every list, from which defaults are taken.
  type(deck_state_type) function prototype_deck() result(state)
    integer :: list

    call empty_deck(state)
    do list = list_node_sets, last_list
      call open_item(state, list)
      call go_to_item(state, list, 1)
    end do
  end function prototype_deck

  !> Put a new item at the end of a list.
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

  !> A new phase, or a new load, support, water level or motion of the last one.
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

  !> Number of items of a list; loads and supports are those of the phase that was gone to.
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

  !> The item that cards are about from now on.
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

  !> The name of the last item of a list is that of no other; an empty one has been reported.
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

  !> The items of a list that have names; null for the others.
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
end module qsmpm_deck_objects
