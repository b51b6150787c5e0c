!> Histories: what the deck wants in the columns of the curve.
module qsmpm_histories
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: quantity_displacement, quantity_position, quantity_stress, quantity_reaction, &
    quantity_state
  use qsmpm_model, only: model_type
  use qsmpm_mesh_sets, only: find_set
  implicit none
  private

  public :: take_histories

contains

  !> Values of all histories in the deck's order.
  subroutine take_histories(model, values)
    type(model_type), intent(in) :: model
    real(wp), allocatable, intent(out) :: values(:)
    integer :: i

    allocate (values(size(model%analysis%histories)))
    do i = 1, size(values)
      values(i) = model%analysis%histories(i)%scale*history_value(model, i)
    end do
  end subroutine take_histories

  !> One history before scaling.
  function history_value(model, i) result(value)
    type(model_type), intent(in) :: model
    integer, intent(in) :: i
    real(wp) :: value
    integer :: place

    value = 0.0_wp
    place = model%history_tracer(i)
    associate (history => model%analysis%histories(i), tracers => model%state%tracers)
      select case (history%quantity)
      case (quantity_displacement)
        value = tracers%position(history%component, place) - tracers%initial_position(history%component, place)
      case (quantity_position)
        value = tracers%position(history%component, place)
      case (quantity_stress)
        value = model%state%points%stress(history%component, model%history_point(i))
      case (quantity_state)
        value = model%state%points%state(model%history_state(i), model%history_point(i))
      case (quantity_reaction)
        place = find_set(model%mesh%node_sets, history%set)
        value = sum(model%state%reactions(history%component, model%space%sets(place)%items))
      end select
    end associate
  end function history_value
end module qsmpm_histories
