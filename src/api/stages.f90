!> The load program of an embedding program: a stage (a phase of a deck) ends before its time, the model is given the
!> stages of the scene.
module qsmpm_stages
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_load_description, only: traction_type
  use qsmpm_phase_description, only: initial_keep
  use qsmpm_drainage, only: set_drainage
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_load_path, only: between
  use qsmpm_model, only: model_type
  use qsmpm_phase_loads, only: load_in_force
  use qsmpm_phase_tree, only: lineage
  use qsmpm_vertical, only: upwards
  use qsmpm_reduction, only: expansion_type, reduction_check_type
  use qsmpm_scene, only: reduce_scene
  use qsmpm_snapshot, only: copy_phases
  use qsmpm_undrained_law, only: undrained_law_type
  implicit none
  private

  public :: cut_stage, take_over_stages, take_phases, same_steps

contains

  !> Let a stage end where it stands: its loads become those reached, its displacements those done. A water level that
  !> is half way is not a level, nor is the pressure of one.
  subroutine cut_stage(scene, number, share, error)
    type(analysis_type), intent(inout) :: scene
    !> Number of the stage.
    integer, intent(in) :: number
    !> Share of the stage that is done.
    real(wp), intent(in) :: share
    !> The stage moves a water level; it is then as it was.
    type(error_type), allocatable, intent(out) :: error
    type(traction_type) :: before
    real(wp) :: factor, kept, start
    integer :: i

    if (share < 1.0_wp .and. moves_water(scene, number)) then
      call fail(error, error_other, "stage '"//scene%phases(number)%name//"' moves a water level, which has no "// &
        'form half way: it cannot end before its time')
      return
    end if

    ! A stage of which nothing is done keeps its load factor, which must not be 0.
    kept = merge(share, 1.0_wp, share > 0.0_wp)
    scene%phases(number)%duration = kept*scene%phases(number)%duration
    associate (phase => scene%phases(number))
      factor = kept*phase%load_factor
      if (phase%gravity%given .and. phase%initial%kind == initial_keep) then
        phase%gravity%vector = between(gravity_before(scene, number), &
          phase%load_factor*phase%gravity%vector, share)/factor
      else if (phase%gravity%given) then
        phase%gravity%vector = phase%gravity%vector/kept
      end if
      do i = 1, size(phase%tractions)
        associate (traction => phase%tractions(i))
          before = load_before(scene, number, traction%surface, traction%follows)
          if (phase%initial%kind /= initial_keep) then
            traction%pressure = traction%pressure/kept
            traction%gradient = traction%gradient/kept
            traction%vector = traction%vector/kept
          else if (traction%follows) then
            ! The pressure that is reached in the place of that of the end of a stage; both vary with height all along.
            start = before%pressure + upwards(scene)*before%gradient*(before%height - traction%height)
            traction%pressure = between(start, phase%load_factor*traction%pressure, share)/factor
            traction%gradient = between(before%gradient, phase%load_factor*traction%gradient, share)/factor
          else
            traction%vector = between(before%vector, phase%load_factor*traction%vector, share)/factor
          end if
        end associate
      end do
      do i = 1, size(phase%prescriptions)
        phase%prescriptions(i)%value = phase%prescriptions(i)%value*share/kept
      end do
      phase%load_factor = factor
    end associate
  end subroutine cut_stage

  !> Whether a stage that does not start from K0 stresses gives a water level or a pressure of water.
  pure logical function moves_water(scene, number)
    type(analysis_type), intent(in) :: scene
    !> Number of the stage.
    integer, intent(in) :: number
    type(traction_type) :: before
    integer :: i

    moves_water = .false.
    associate (phase => scene%phases(number))
      if (phase%initial%kind /= initial_keep) return
      moves_water = size(phase%water_levels) > 0
      do i = 1, size(phase%tractions)
        moves_water = moves_water .or. phase%tractions(i)%of_water
        before = load_before(scene, number, phase%tractions(i)%surface, .true.)
        moves_water = moves_water .or. (phase%tractions(i)%follows .and. before%of_water)
      end do
    end associate
  end function moves_water

  !> Gravity at the end of the stages before one.
  pure function gravity_before(scene, number) result(vector)
    type(analysis_type), intent(in) :: scene
    !> Number of the stage.
    integer, intent(in) :: number
    real(wp) :: vector(3)
    integer, allocatable :: line(:)
    integer :: p

    vector = 0.0_wp
    allocate (line, source=lineage(scene%phases, number))
    do p = 1, size(line) - 1
      associate (phase => scene%phases(line(p)))
        if (phase%gravity%given) vector = phase%load_factor*phase%gravity%vector
      end associate
    end do
  end function gravity_before

  !> Dead traction or pressure at the end of the stages before one.
  pure type(traction_type) function load_before(scene, number, surface, follows) result(load)
    type(analysis_type), intent(in) :: scene
    !> Number of the stage.
    integer, intent(in) :: number
    !> Name of the surface.
    character(len=*), intent(in) :: surface
    !> The pressure.
    logical, intent(in) :: follows
    integer, allocatable :: line(:)

    allocate (line, source=lineage(scene%phases, number))
    load = load_in_force(scene%phases, line(:size(line) - 1), surface, follows)
  end function load_before

  !> Give the model the stages of the scene. A reduced model takes them only where its reductions hold with them too.
  subroutine take_over_stages(scene, expansion, model, error)
    !> The scene with its new stages.
    type(analysis_type), intent(in) :: scene
    !> The way from the model to the scene.
    type(expansion_type), intent(in) :: expansion
    !> The model; unchanged with an error.
    type(model_type), intent(inout) :: model
    !> Set when the scene with these stages is not what the model is good for.
    type(error_type), allocatable, intent(out) :: error
    type(analysis_type) :: reduced
    type(expansion_type) :: now
    type(reduction_check_type), allocatable :: checks(:)

    if (size(expansion%steps) == 0) then
      call take_phases(scene, model)
      return
    end if
    call reduce_scene(scene, reduced, now, checks)
    if (.not. same_steps(expansion, now)) then
      call fail(error, error_other, 'with these loads the scene is not what it was reduced to; name the type '// &
        'of the model instead of *MODEL, TYPE=AUTO')
      return
    end if
    call take_phases(reduced, model)
  end subroutine take_over_stages

  !> Copy the stages.
  subroutine take_phases(analysis, model)
    !> Where they come from.
    type(analysis_type), intent(in) :: analysis
    type(model_type), intent(inout) :: model

    call copy_phases(analysis%phases, model%analysis%phases)
    call take_drainage(model)
  end subroutine take_phases

  !> Tell the laws of undrained soil what the pore water does in all phases.
  subroutine take_drainage(model)
    type(model_type), intent(inout) :: model
    integer :: m

    do m = 1, size(model%laws)
      if (allocated(model%analysis%materials(m)%undrained%drainage)) &
        deallocate (model%analysis%materials(m)%undrained%drainage)
    end do
    call set_drainage(model%analysis)
    do m = 1, size(model%laws)
      select type (law => model%laws(m)%law)
      type is (undrained_law_type)
        law%drainage = model%analysis%materials(m)%undrained%drainage
      end select
    end do
  end subroutine take_drainage

  !> Whether two scenes were reduced in the same way.
  pure logical function same_steps(a, b)
    !> Both ways.
    type(expansion_type), intent(in) :: a, b

    same_steps = size(a%steps) == size(b%steps)
    if (same_steps) same_steps = all(a%steps%kind == b%steps%kind .and. a%steps%axis == b%steps%axis)
  end function same_steps
end module qsmpm_stages
