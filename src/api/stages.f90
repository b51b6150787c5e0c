!> The load program in the hands of an embedding program: stages (the phases of a deck) are added, changed before
!> they begin, and ended before their time. They are data of the scene, so that the resolved deck, the fingerprint of
!> restart files and a window that is rebuilt all know of them.
module qsmpm_stages
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: named_type, add_names, place_named
  use qsmpm_analysis, only: analysis_type
  use qsmpm_load_description, only: fixity_type, prescription_type, traction_type
  use qsmpm_phase_description, only: phase_type, initial_keep
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
  use qsmpm_text, only: string_type, did_you_mean, integer_text
  use qsmpm_undrained_law, only: undrained_law_type
  implicit none
  private

  public :: append_stage, change_traction, change_pressure, change_water_level, change_displacement, change_fixity, &
    cut_stage, take_over_stages, take_phases, same_steps

contains

  !> Add a stage in which nothing changes yet; its controls are those of the last one.
  subroutine append_stage(scene, name, steps, error)
    type(analysis_type), intent(inout) :: scene
    !> Name, which no other stage has.
    character(len=*), intent(in) :: name
    !> Load steps.
    integer, intent(in) :: steps
    !> Set when the name is taken or empty, or there is no step.
    type(error_type), allocatable, intent(out) :: error
    type(phase_type) :: phase

    if (len_trim(name) == 0) then
      call fail(error, error_other, 'a stage wants a name')
    else if (steps < 1) then
      call fail(error, error_other, "stage '"//trim(name)//"': "//integer_text(steps)//' load steps are none')
    end if
    if (allocated(error)) return
    if (place_named(scene%phases, trim(name)) > 0) then
      call fail(error, error_other, "there is already a stage '"//trim(name)//"'")
      return
    end if
    phase%name = trim(name)
    allocate (phase%fixities(0), phase%prescriptions(0), phase%tractions(0), phase%supports(0), phase%water_levels(0), &
      phase%activations(0), phase%deactivations(0), phase%materials(0), phase%installed(0), phase%removed(0), &
      phase%constant_load_test%at(0), phase%stops(0), phase%moves(0))
    if (size(scene%phases) > 0) phase%controls = scene%phases(size(scene%phases))%controls
    phase%controls%steps = steps
    scene%phases = [scene%phases, phase]
  end subroutine append_stage

  !> Dead traction on a surface at the end of a stage, per unit of its load factor.
  subroutine change_traction(scene, number, surface, vector, error)
    type(analysis_type), intent(inout) :: scene
    !> Number of the stage.
    integer, intent(in) :: number
    !> Name of the surface.
    character(len=*), intent(in) :: surface
    !> Force per undeformed area (3).
    real(wp), intent(in) :: vector(3)
    !> Set when there is no such surface.
    type(error_type), allocatable, intent(out) :: error
    type(traction_type) :: traction
    integer :: i, p

    call check_name(scene%surfaces, surface, 'surface', error)
    if (allocated(error)) return
    ! Who carries it stays as it was said last.
    do p = 1, number
      do i = 1, size(scene%phases(p)%tractions)
        associate (known => scene%phases(p)%tractions(i))
          if (known%surface == surface .and. .not. known%follows) traction%carrier = known%carrier
        end associate
      end do
    end do
    traction%surface = surface
    traction%vector = vector
    call put_traction(scene%phases(number), traction)
  end subroutine change_traction

  !> Pressure on a surface at the end of a stage, per unit of its load factor.
  subroutine change_pressure(scene, number, surface, pressure, error)
    type(analysis_type), intent(inout) :: scene
    !> Number of the stage.
    integer, intent(in) :: number
    !> Name of the surface.
    character(len=*), intent(in) :: surface
    !> Force per present area, positive against the body.
    real(wp), intent(in) :: pressure
    !> Set when there is no such surface.
    type(error_type), allocatable, intent(out) :: error
    type(traction_type) :: traction

    call check_name(scene%surfaces, surface, 'surface', error)
    if (allocated(error)) return
    traction%surface = surface
    traction%follows = .true.
    traction%pressure = pressure
    call put_traction(scene%phases(number), traction)
  end subroutine change_pressure

  !> Level of water at the end of a stage: of a row of a free surface in ground that consolidates, or of water at rest.
  !> A stage without levels of its own gets those in force.
  subroutine change_water_level(scene, number, name, level, error)
    type(analysis_type), intent(inout) :: scene
    !> Number of the stage.
    integer, intent(in) :: number
    !> Node set or surface of a row; for water at rest a body, or empty for all that have no level of their own.
    character(len=*), intent(in) :: name
    !> Height as a coordinate.
    real(wp), intent(in) :: level
    !> Set when no such level is in force, or water flows below it through ground as it is drawn.
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: line(:)
    integer :: i, k, r

    allocate (line, source=lineage(scene%phases, number))
    do i = size(line), 1, -1
      do k = 1, size(scene%phases(line(i))%water_levels)
        associate (card => scene%phases(line(i))%water_levels(k))
          r = 0
          if (card%flows .or. card%none) then
            if (card%flows) r = findloc([(card%heads(r)%set == name, r=1, size(card%heads))], .true., dim=1)
            if (r == 0) cycle
          else if (card%body /= name) then
            cycle
          end if
        end associate
        if (scene%phases(line(i))%water_levels(k)%flows .and. .not. scene%phases(line(i))%water_levels(k)%coupled) exit
        if (i < size(line)) scene%phases(number)%water_levels = [scene%phases(number)%water_levels, &
          scene%phases(line(i))%water_levels(k)]
        associate (card => scene%phases(number)%water_levels(merge(k, size(scene%phases(number)%water_levels), &
            i == size(line))))
          if (r > 0) card%heads(r)%level = level
          if (r == 0) card%line(2, :) = level
        end associate
        return
      end do
    end do
    call fail(error, error_other, "no level of '"//name//"' is in force that a stage can move: one of a flow "// &
      'through ground as it is drawn is found when its stage is added (*WATER LEVEL by cards)')
  end subroutine change_water_level

  !> Put a load on a surface in the place of a former one of its kind, or behind the others.
  subroutine put_traction(phase, traction)
    type(phase_type), intent(inout) :: phase
    type(traction_type), intent(in) :: traction
    integer :: i

    do i = 1, size(phase%tractions)
      if (phase%tractions(i)%surface /= traction%surface) cycle
      if (phase%tractions(i)%follows .neqv. traction%follows) cycle
      phase%tractions(i) = traction
      return
    end do
    phase%tractions = [phase%tractions, traction]
  end subroutine put_traction

  !> Displacement of a node set over a stage, per unit of its load factor.
  subroutine change_displacement(model, phase, set, component, value, error)
    !> The model, for the names of its sets.
    type(model_type), intent(in) :: model
    type(phase_type), intent(inout) :: phase
    !> Name of the set.
    character(len=*), intent(in) :: set
    !> 1, 2 or 3.
    integer, intent(in) :: component
    !> The displacement.
    real(wp), intent(in) :: value
    !> Set when there is no such set or component, or the set is held in this stage.
    type(error_type), allocatable, intent(out) :: error
    type(prescription_type) :: prescription
    integer :: i

    call check_name(model%mesh%node_sets, set, 'node set', error)
    if (.not. allocated(error) .and. (component < 1 .or. component > model%mesh%dimension)) &
      call fail(error, error_other, 'component '//integer_text(component)//' is not one of the model')
    if (allocated(error)) return
    do i = 1, size(phase%fixities)
      if (phase%fixities(i)%set == set .and. phase%fixities(i)%fixed(component)) call fail(error, error_other, &
        "set '"//set//"' is held and moved in stage '"//phase%name//"'")
    end do
    if (allocated(error)) return
    prescription%set = set
    prescription%component = component
    prescription%value = value
    do i = 1, size(phase%prescriptions)
      if (phase%prescriptions(i)%set /= set .or. phase%prescriptions(i)%component /= component) cycle
      phase%prescriptions(i) = prescription
      return
    end do
    phase%prescriptions = [phase%prescriptions, prescription]
  end subroutine change_displacement

  !> Components of a node set that are held from a stage on.
  subroutine change_fixity(model, phase, set, fixed, error)
    !> The model, for the names of its sets.
    type(model_type), intent(in) :: model
    type(phase_type), intent(inout) :: phase
    !> Name of the set.
    character(len=*), intent(in) :: set
    !> Held components; none frees the set (3).
    logical, intent(in) :: fixed(3)
    !> Set when there is no such set.
    type(error_type), allocatable, intent(out) :: error
    type(fixity_type) :: fixity
    integer :: i

    call check_name(model%mesh%node_sets, set, 'node set', error)
    ! Where all components are held, those that there are are meant.
    if (.not. allocated(error) .and. model%mesh%dimension == 2 .and. fixed(3) .and. .not. all(fixed)) &
      call fail(error, error_other, 'component 3 is not one of the model')
    if (allocated(error)) return
    fixity%set = set
    fixity%fixed = fixed
    do i = 1, size(phase%fixities)
      if (phase%fixities(i)%set /= set) cycle
      phase%fixities(i) = fixity
      return
    end do
    phase%fixities = [phase%fixities, fixity]
  end subroutine change_fixity

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
    real(wp) :: factor, kept
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
            call reach_pressure(before, share, phase%load_factor, factor, upwards(scene), traction)
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

  !> The pressure that is reached in the place of that of the end of a stage; both vary with height all along.
  pure subroutine reach_pressure(before, share, load_factor, factor, up, traction)
    !> At the end of the stages before.
    type(traction_type), intent(in) :: before
    !> Share of the stage that is done, its load factor as it was and as it is.
    real(wp), intent(in) :: share, load_factor, factor
    !> Sense of upwards along the vertical.
    real(wp), intent(in) :: up
    type(traction_type), intent(inout) :: traction
    real(wp) :: start

    start = before%pressure + up*before%gradient*(before%height - traction%height)
    traction%pressure = between(start, load_factor*traction%pressure, share)/factor
    traction%gradient = between(before%gradient, load_factor*traction%gradient, share)/factor
  end subroutine reach_pressure

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

  !> Whether there is such a surface or node set.
  subroutine check_name(list, name, what, error)
    class(named_type), intent(in) :: list(:)
    character(len=*), intent(in) :: name
    !> What it is the name of.
    character(len=*), intent(in) :: what
    !> Set when there is none.
    type(error_type), allocatable, intent(out) :: error
    type(string_type), allocatable :: names(:)

    if (place_named(list, name) > 0) return
    allocate (names(0))
    call add_names(list, names)
    call fail(error, error_other, 'there is no '//what//" '"//name//"'"//did_you_mean(name, names))
  end subroutine check_name
end module qsmpm_stages
