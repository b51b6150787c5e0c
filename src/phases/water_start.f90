!> Where ground gets one water pressure with a free surface, suction above it and the water that fills its pores in part
!> act from the first step on. What is out of balance by it at the start of the phase, at all free nodes,
!>
!>   r = sum V (sigma' + S chi p) grad N - f_load,
!>
!> is held then and falls to nothing over the phase, as what a freed fixity has carried: cutting a step would not make
!> it smaller.
module qsmpm_water_start
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_initialisation, only: step_type, initialise_step
  use qsmpm_law, only: tangent_none
  use qsmpm_model, only: model_type
  use qsmpm_phase_loads, only: free_surface_of
  use qsmpm_phase_tree, only: parent_of
  use qsmpm_step_evaluation, only: evaluate_step
  use qsmpm_term_sums, only: discard_terms, set_loads
  implicit none
  private

  public :: hold_water_start

contains

  !> Hold what is out of balance where the surface of the water begins to move.
  subroutine hold_water_start(model, step, error)
    type(model_type), intent(inout) :: model
    !> Scratch.
    type(step_type), intent(inout) :: step
    !> Failures of the initialisation.
    type(error_type), allocatable, intent(out) :: error

    if (.not. begins(model)) return
    call initialise_step(model, step, error)
    if (allocated(error)) return
    call set_loads(step%terms, model, step%configuration_type, 0.0_wp)
    call evaluate_step(model, step, 0.0_wp*step%forces%internal, tangent_none)
    associate (released => model%state%released)
      associate (internal => step%forces%internal(:size(released, 1), :size(released, 2)), &
          external => step%forces%external(:size(released, 1), :size(released, 2)))
        where (.not. model%loading%constrained .and. spread(step%equations%active(:size(released, 2)), 1, &
          size(released, 1))) released = released + internal - external
      end associate
    end associate
    call discard_terms(step%terms)
  end subroutine hold_water_start

  !> Whether the phase is the first of its line with a free surface in ground that consolidates.
  pure logical function begins(model)
    type(model_type), intent(in) :: model
    integer :: parent

    associate (phases => model%analysis%phases, number => model%state%progress%phase)
      begins = free_surface_of(phases, number) > 0
      if (.not. begins) return
      parent = parent_of(phases, number)
      if (parent > 0) begins = free_surface_of(phases, parent) == 0
    end associate
  end function begins
end module qsmpm_water_start
