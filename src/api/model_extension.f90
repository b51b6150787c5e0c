!> A model under way takes over a scene with more materials and phases than it was built for. The whole scene is built
!> again beside it, so that everything is checked as in a deck; what that model has of laws and phases is taken, and
!> what stands on the state (bodies that come and go, pore pressure, ends of phases) is made ready where the state is.
module qsmpm_model_extension
  use qsmpm_active_bodies, only: has_stages
  use qsmpm_analysis, only: analysis_type
  use qsmpm_material_description, only: material_type
  use qsmpm_body_stages, only: part_bodies
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_kept_phases, only: find_kept_phase, keep_phase
  use qsmpm_law, only: law_slot_type
  use qsmpm_inactive_points, only: lift_feet_type
  use qsmpm_lowered_laws, only: fit_laws
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_tree, only: parent_of
  use qsmpm_points, only: carries_water, start_water
  use qsmpm_pore_water, only: has_pore_pressure
  use qsmpm_reduction, only: expansion_type, reduction_check_type
  use qsmpm_scene, only: reduce_scene
  use qsmpm_stages, only: same_steps, take_phases
  use qsmpm_strength_factor, only: strength_factor_type
  implicit none
  private

  public :: extend_model, drop_materials, shorten

contains

  !> Take over a scene that begins with that of the model.
  subroutine extend_model(scene, expansion, own, ended, model, error)
    type(analysis_type), intent(in) :: scene
    !> The way from the model to the scene.
    type(expansion_type), intent(in) :: expansion
    !> Laws of the program, where it has given any (materials the model was built with).
    type(law_slot_type), intent(in) :: own(:)
    !> The present phase has ended.
    logical, intent(in) :: ended
    !> Unchanged with an error.
    type(model_type), intent(inout) :: model
    !> Set when the scene or the model is not good for it.
    type(error_type), allocatable, intent(out) :: error
    class(analysis_type), allocatable :: reduced
    type(expansion_type) :: now
    type(reduction_check_type), allocatable :: checks(:)
    class(model_type), allocatable :: fresh

    allocate (reduced, fresh)
    call reduce_scene(scene, reduced, now, checks)
    if (.not. same_steps(expansion, now)) then
      call fail(error, error_other, 'with these cards the scene is not what it was reduced to; name the type '// &
        'of the model instead of *MODEL, TYPE=AUTO')
      return
    end if
    call build_fresh(reduced, own, fresh, error)
    if (.not. allocated(error)) call check_fit(fresh, model, error)
    if (allocated(error)) return
    call take_model(fresh, ended, model)
  end subroutine extend_model

  !> Build the whole scene, with the program's laws.
  subroutine build_fresh(analysis, own, fresh, error)
    type(analysis_type), intent(in) :: analysis
    type(law_slot_type), intent(in) :: own(:)
    type(model_type), intent(out) :: fresh
    !> What is wrong with the scene.
    type(error_type), allocatable, intent(out) :: error
    type(law_slot_type) :: laws(size(analysis%materials))
    integer :: m

    do m = 1, size(own)
      if (allocated(own(m)%law)) allocate (laws(m)%law, source=own(m)%law)
    end do
    call build_model(analysis, fresh, error, laws)
  end subroutine build_fresh

  !> Set when the state of the model cannot carry what is new.
  subroutine check_fit(fresh, model, error)
    !> Of the whole scene, at its start.
    type(model_type), intent(in) :: fresh
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error
    integer :: p, parent

    if (size(fresh%state%points%state, 1) > size(model%state%points%state, 1)) then
      call fail(error, error_other, 'a new material has more state variables than the material points carry: '// &
        'give a material of that law in the deck')
    else if (size(fresh%outlines) /= size(model%outlines)) then
      call fail(error, error_other, 'an outline that is carried with its body for a load cannot become a support: '// &
        'give the *SUPPORT in a phase of the deck')
    else if (has_stages(fresh%analysis) .and. .not. has_stages(model%analysis) .and. allocated(model%kept_phases)) then
      call fail(error, error_other, 'bodies come or go for the first time, and the ends of earlier phases are kept '// &
        'without that: give one phase in which they do in the deck, or their parents later')
    end if
    if (allocated(error)) return
    associate (phases => fresh%analysis%phases)
      do p = size(model%analysis%phases) + 1, size(phases)
        parent = parent_of(phases, p)
        if (parent >= model%state%progress%phase .or. find_kept_phase(model, parent) > 0) cycle
        call fail(error, error_other, "the end of phase '"//phases(parent)%name//"', that phase '"//phases(p)%name// &
          "' is to start from, is not kept: add the phase before another one begins")
        return
      end do
    end associate
  end subroutine check_fit

  !> Take materials, laws and phases, and make the state ready for them.
  subroutine take_model(fresh, ended, model)
    type(model_type), intent(inout) :: fresh
    logical, intent(in) :: ended
    type(model_type), intent(inout) :: model
    logical :: parted
    integer :: i

    parted = has_stages(model%analysis)
    call move_alloc(fresh%analysis%materials, model%analysis%materials)
    call move_alloc(fresh%laws, model%laws)
    call move_alloc(fresh%cavity_middle, model%cavity_middle)
    call take_phases(fresh%analysis, model)
    model%strength = strength_factor_type()
    call fit_laws(model)
    if (.not. parted .and. has_stages(model%analysis)) call part_late(model)
    if (has_pore_pressure(model)) then
      call wet(model%state)
      if (allocated(model%kept_phases)) then
        do i = 1, size(model%kept_phases)
          call wet(model%kept_phases(i)%state)
        end do
      end if
    end if
    if (ended) call keep_phase(model)
  end subroutine take_model

  !> Bodies come or go for the first time; those of a state that was put back may have been parted before.
  subroutine part_late(model)
    type(model_type), intent(inout) :: model
    type(lift_feet_type) :: none

    if (allocated(model%tracer_body)) deallocate (model%tracer_body, model%tracer_foot)
    model%feet = none
    call part_bodies(model)
  end subroutine part_late

  !> Let the points carry pore pressures.
  subroutine wet(state)
    type(state_type), intent(inout) :: state

    if (carries_water(state%points)) return
    call start_water(state%points)
    call start_water(state%inactive%points)
    call start_water(state%inactive%unloading)
  end subroutine wet

  !> Forget the materials behind a number, which a state that was put back does not know.
  subroutine drop_materials(number, scene, model)
    integer, intent(in) :: number
    type(analysis_type), intent(inout) :: scene
    type(model_type), intent(inout) :: model
    type(law_slot_type), allocatable :: laws(:)
    integer :: m

    if (size(scene%materials) <= number) return
    call shorten(number, scene)
    call shorten(number, model%analysis)
    allocate (laws(number))
    do m = 1, number
      call move_alloc(model%laws(m)%law, laws(m)%law)
      laws(m)%pressure_factor = model%laws(m)%pressure_factor
      laws(m)%flows = model%laws(m)%flows
      laws(m)%confinement = model%laws(m)%confinement
    end do
    call move_alloc(laws, model%laws)
  end subroutine drop_materials

  !> Keep the first materials.
  subroutine shorten(number, analysis)
    integer, intent(in) :: number
    type(analysis_type), intent(inout) :: analysis
    type(material_type), allocatable :: materials(:)
    integer :: m

    allocate (materials(number))
    do m = 1, number
      materials(m) = analysis%materials(m)
    end do
    call move_alloc(materials, analysis%materials)
  end subroutine shorten
end module qsmpm_model_extension
