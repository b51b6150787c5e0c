!> Props of a model: the tracers of their ends, and the force of each, which is stored from step to step.
module qsmpm_props
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_kept_arrays, only: lay_array, kept_values
  use qsmpm_model, only: model_type
  implicit none
  private

  public :: lay_prop_forces, prop_force

  !> Forces, tension positive (1, props).
  character(len=*), parameter, public :: prop_forces = 'prop_forces'

contains

  !> Initialises the forces in the state to zero.
  subroutine lay_prop_forces(model)
    type(model_type), intent(inout) :: model
    integer :: b

    if (size(model%analysis%props) > 0) call lay_array(model%state%kept, prop_forces, &
      reshape([(0.0_wp, b=1, size(model%analysis%props))], [1, size(model%analysis%props)]))
  end subroutine lay_prop_forces

  !> Returns the force of one existing prop.
  pure real(wp) function prop_force(model, name) result(force)
    type(model_type), intent(in) :: model
    character(len=*), intent(in) :: name
    real(wp) :: forces(1, size(model%analysis%props))

    forces = kept_values(model%state%kept, prop_forces)
    force = forces(1, place_named(model%analysis%props, name))
  end function prop_force
end module qsmpm_props
