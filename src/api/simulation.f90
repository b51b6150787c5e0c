!> An analysis controlled by a program, with its load program: stages (the phases of a deck) are added, assigned loads
!> before they begin, and can be ended early. They are part of the scene, so that the resolved deck, the fingerprint of
!> restart files and a regenerated window include them. Values are accessed by name (`qsmpm_named_values`) or directly
!> in `model`.
module qsmpm_simulation
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: three_dimensional
  use qsmpm_observer_list, only: observer_list_type
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_load_description, only: fixity_type, gravity_type, prescription_type, traction_type
  use qsmpm_limit_load, only: is_found, limit_load_type
  use qsmpm_named, only: named_type, add_names, place_named
  use qsmpm_phase_description, only: phase_type
  use qsmpm_phase_start, only: resume_phase
  use qsmpm_phase_tree, only: lineage
  use qsmpm_phases, only: end_phase
  use qsmpm_stages, only: cut_stage
  use qsmpm_step_length, only: phase_is_complete
  use qsmpm_stepped_analysis, only: stepped_analysis_type, need_model
  use qsmpm_text, only: string_type, did_you_mean, integer_text
  implicit none
  private

  public :: simulation_type

  !> An analysis whose loads can be changed by the program.
  type, extends(stepped_analysis_type) :: simulation_type
  contains
    procedure :: coming_stage, add_stage, end_stage, set_load_factor, set_steps, set_time, set_start_time, &
      set_gravity, set_traction, set_pressure, set_water_level, set_displacement, set_fixity, set_point_force
  end type simulation_type

contains

  !> Returns the number of the stage that begins next, 0 if there is none.
  pure integer function coming_stage(self)
    class(simulation_type), intent(in) :: self

    coming_stage = 0
    if (.not. self%ready) return
    associate (progress => self%model%state%progress)
      coming_stage = progress%phase + 1
      if (.not. self%loop%begun .and. .not. progress%fraction > 0.0_wp) coming_stage = progress%phase
    end associate
    if (coming_stage > size(self%scene%phases)) coming_stage = 0
  end function coming_stage

  !> Finds the next stage.
  subroutine find_coming(self, number, error, values)
    class(simulation_type), intent(in) :: self
    integer, intent(out) :: number
    !> Set when there is no next stage.
    type(error_type), allocatable, intent(out) :: error
    !> Values to be assigned; an error is set when one is not finite.
    real(wp), intent(in), optional :: values(:)

    number = 0
    call need_model(self, error)
    if (allocated(error)) return
    number = self%coming_stage()
    if (number == 0) call fail(error, error_other, 'no stage is to come: add one, then give it its loads')
    if (present(values) .and. .not. allocated(error)) call need_numbers(values, error)
  end subroutine find_coming

  !> Appends a stage. Loads, fixities and controls are those of the previous stage until they are changed.
  subroutine add_stage(self, name, steps, error)
    class(simulation_type), intent(inout) :: self
    !> Name of the stage, different from those of the other stages.
    character(len=*), intent(in) :: name
    !> Initial number of load steps.
    integer, intent(in) :: steps
    !> Set when the name is in use or empty, or when the number of steps is below 1.
    type(error_type), allocatable, intent(out) :: error
    type(phase_type) :: phase

    call need_model(self, error)
    if (allocated(error)) return
    if (len_trim(name) == 0) then
      call fail(error, error_other, 'a stage requires a name')
    else if (steps < 1) then
      call fail(error, error_other, "stage '"//trim(name)//"': "//integer_text(steps)//' load steps are none')
    else if (place_named(self%scene%phases, trim(name)) > 0) then
      call fail(error, error_other, "there is already a stage '"//trim(name)//"'")
    end if
    if (allocated(error)) return
    phase%name = trim(name)
    allocate (phase%fixities(0), phase%prescriptions(0), phase%tractions(0), phase%supports(0), phase%water_levels(0), &
      phase%activations(0), phase%deactivations(0), phase%materials(0), phase%installed(0), phase%removed(0), &
      phase%constant_load_test%at(0), phase%stops(0), phase%moves(0))
    if (size(self%scene%phases) > 0) phase%controls = self%scene%phases(size(self%scene%phases))%controls
    phase%controls%steps = steps
    self%scene%phases = [self%scene%phases, phase]
    call self%take_over(error)
  end subroutine add_stage

  !> Ends the current stage at its current load, which becomes its final load.
  subroutine end_stage(self, error)
    class(simulation_type), intent(inout), target :: self
    !> Set when no stage is in progress.
    type(error_type), allocatable, intent(out) :: error
    type(observer_list_type) :: observers
    logical :: under_way

    call need_model(self, error)
    if (allocated(error)) return
    under_way = self%loop%begun .or. self%model%state%progress%fraction > 0.0_wp
    associate (progress => self%model%state%progress)
      if (.not. under_way .or. (phase_is_complete(progress) .and. .not. is_found(progress%limit))) then
        call fail(error, error_other, 'no stage is under way')
        return
      end if
      call cut_stage(self%scene, progress%phase, progress%fraction, error)
      if (allocated(error)) return
      call self%take_over(error)
      if (allocated(error)) return
      progress%release_left = max(1.0_wp - progress%fraction, progress%release_left)
      progress%fraction = 1.0_wp
      progress%limit = limit_load_type()
    end associate
    call resume_phase(self%model)
    self%loop%begun = .true.
    if (allocated(self%recorder)) observers%recorder => self%recorder
    if (allocated(self%outcome)) deallocate (self%outcome)
    call end_phase(self%model, self%loop, observers, error)
  end subroutine end_stage

  !> Sets the load factor at the end of the next stage, which multiplies all its loads.
  subroutine set_load_factor(self, factor, error)
    class(simulation_type), intent(inout) :: self
    !> Positive and finite.
    real(wp), intent(in) :: factor
    !> Set when it is not, or when there is no next stage.
    type(error_type), allocatable, intent(out) :: error
    integer :: number

    call find_coming(self, number, error, [factor])
    if (.not. allocated(error) .and. .not. factor > 0.0_wp) &
      call fail(error, error_other, 'the load factor of a stage is above 0')
    if (allocated(error)) return
    self%scene%phases(number)%load_factor = factor
    call self%take_over(error)
  end subroutine set_load_factor

  !> Sets the initial number of load steps of the next stage.
  subroutine set_steps(self, steps, error)
    class(simulation_type), intent(inout) :: self
    !> At least 1.
    integer, intent(in) :: steps
    !> Set when the number is below 1, or when there is no next stage.
    type(error_type), allocatable, intent(out) :: error
    integer :: number

    call find_coming(self, number, error)
    if (.not. allocated(error) .and. steps < 1) &
      call fail(error, error_other, integer_text(steps)//' load steps are none')
    if (allocated(error)) return
    self%scene%phases(number)%controls%steps = steps
    call self%take_over(error)
  end subroutine set_steps

  !> Sets the duration of the next stage, for time-dependent models.
  subroutine set_time(self, duration, error)
    class(simulation_type), intent(inout) :: self
    !> Positive and finite.
    real(wp), intent(in) :: duration
    !> Set when it is not, or when there is no next stage.
    type(error_type), allocatable, intent(out) :: error
    integer :: number

    call find_coming(self, number, error, [duration])
    if (.not. allocated(error) .and. .not. duration > 0.0_wp) &
      call fail(error, error_other, 'a stage lasts longer than 0')
    if (allocated(error)) return
    associate (phase => self%scene%phases(number))
      phase%duration = duration
      phase%controls%first_share = phase%first_time/duration
    end associate
    call self%take_over(error)
  end subroutine set_time

  !> Sets the time at the start of the next stage; by default the end time of the previous one.
  subroutine set_start_time(self, time, error)
    class(simulation_type), intent(inout) :: self
    real(wp), intent(in) :: time
    !> Set when the time is not finite, or when there is no next stage.
    type(error_type), allocatable, intent(out) :: error
    integer :: number

    call find_coming(self, number, error, [time])
    if (allocated(error)) return
    self%scene%phases(number)%start_given = .true.
    self%scene%phases(number)%start_time = time
    call self%take_over(error)
  end subroutine set_start_time

  !> Sets gravity at the end of the next stage.
  subroutine set_gravity(self, vector, error)
    class(simulation_type), intent(inout) :: self
    !> Vector (3) that multiplies the unit weights.
    real(wp), intent(in) :: vector(3)
    !> Set when it has an out-of-plane component, or when there is no next stage.
    type(error_type), allocatable, intent(out) :: error
    integer :: number

    call find_coming(self, number, error)
    if (.not. allocated(error)) call need_vector(self, vector, error)
    if (allocated(error)) return
    self%scene%phases(number)%gravity = gravity_type(.true., vector)
    call self%take_over(error)
  end subroutine set_gravity

  !> Sets the dead traction on a surface at the end of the next stage, per unit load factor.
  subroutine set_traction(self, surface, vector, error)
    class(simulation_type), intent(inout) :: self
    !> Name of the surface.
    character(len=*), intent(in) :: surface
    !> Force per undeformed area (3).
    real(wp), intent(in) :: vector(3)
    !> Set when there is no such surface or no next stage.
    type(error_type), allocatable, intent(out) :: error
    type(traction_type) :: traction
    integer :: number, i, p

    call find_coming(self, number, error)
    if (.not. allocated(error)) call need_vector(self, vector, error)
    if (.not. allocated(error)) call check_name(self%scene%surfaces, surface, 'surface', error)
    if (allocated(error)) return
    ! The carrier of the load (surface or material points) is that of the last definition.
    do p = 1, number
      do i = 1, size(self%scene%phases(p)%tractions)
        associate (known => self%scene%phases(p)%tractions(i))
          if (known%surface == surface .and. .not. known%follows) traction%carrier = known%carrier
        end associate
      end do
    end do
    traction%surface = surface
    traction%vector = vector
    call put_traction(self%scene%phases(number), traction)
    call self%take_over(error)
  end subroutine set_traction

  !> Sets the pressure on a surface at the end of the next stage, per unit load factor.
  subroutine set_pressure(self, surface, pressure, error)
    class(simulation_type), intent(inout) :: self
    !> Name of the surface.
    character(len=*), intent(in) :: surface
    !> Force per current area, positive against the body.
    real(wp), intent(in) :: pressure
    !> Set when there is no such surface or no next stage.
    type(error_type), allocatable, intent(out) :: error
    type(traction_type) :: traction
    integer :: number

    call find_coming(self, number, error, [pressure])
    if (.not. allocated(error)) call check_name(self%scene%surfaces, surface, 'surface', error)
    if (allocated(error)) return
    traction%surface = surface
    traction%follows = .true.
    traction%pressure = pressure
    call put_traction(self%scene%phases(number), traction)
    call self%take_over(error)
  end subroutine set_pressure

  !> Adds a load on a surface, or replaces the load of the same kind on that surface.
  subroutine put_traction(phase, traction)
    type(phase_type), intent(inout) :: phase
    type(traction_type), intent(in) :: traction
    integer :: i

    i = findloc([(phase%tractions(i)%surface == traction%surface .and. &
      (phase%tractions(i)%follows .eqv. traction%follows), i=1, size(phase%tractions))], .true., dim=1)
    if (i == 0) phase%tractions = [phase%tractions, traction]
    if (i > 0) phase%tractions(i) = traction
  end subroutine put_traction

  !> Sets a water level at the end of the next stage: of a row of a free surface in consolidating soil, or of
  !> hydrostatic water. A stage without levels of its own uses those in force.
  subroutine set_water_level(self, name, level, error)
    class(simulation_type), intent(inout) :: self
    !> Node set or surface of a row; for hydrostatic water a body, or empty for all bodies without a level of their
    !> own.
    character(len=*), intent(in) :: name
    !> Elevation, as a coordinate.
    real(wp), intent(in) :: level
    !> Set when no such level is in force, when it is the boundary of a flow through the initial geometry, or when
    !> there is no next stage.
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: line(:)
    integer :: number, i, k, r

    call find_coming(self, number, error, [level])
    if (allocated(error)) return
    associate (phases => self%scene%phases)
      allocate (line, source=lineage(phases, number))
      do i = size(line), 1, -1
        do k = 1, size(phases(line(i))%water_levels)
          associate (card => phases(line(i))%water_levels(k))
            r = 0
            if (card%flows .or. card%none) then
              if (card%flows) r = findloc([(card%heads(r)%set == name, r=1, size(card%heads))], .true., dim=1)
              if (r == 0) cycle
            else if (card%body /= name) then
              cycle
            end if
            if (card%flows .and. .not. card%coupled) exit
          end associate
          if (i < size(line)) &
            phases(number)%water_levels = [phases(number)%water_levels, phases(line(i))%water_levels(k)]
          associate (card => phases(number)%water_levels(merge(k, size(phases(number)%water_levels), i == size(line))))
            if (r > 0) card%heads(r)%level = level
            if (r == 0) card%line(2, :) = level
          end associate
          call self%take_over(error)
          return
        end do
      end do
    end associate
    call fail(error, error_other, "no level of '"//name//"' is in force that a stage can move: one of a flow "// &
      'through ground as it is drawn is found when its stage is added (*WATER LEVEL by cards)')
  end subroutine set_water_level

  !> Sets the displacement of a node set over the next stage, per unit load factor.
  subroutine set_displacement(self, set, component, value, error)
    class(simulation_type), intent(inout) :: self
    !> Name of the set.
    character(len=*), intent(in) :: set
    !> 1, 2 or 3.
    integer, intent(in) :: component
    !> Displacement over the stage.
    real(wp), intent(in) :: value
    !> Set when there is no such set, component or next stage, or when the set is fixed in this stage.
    type(error_type), allocatable, intent(out) :: error
    type(prescription_type) :: prescription
    integer :: number, i

    call find_coming(self, number, error, [value])
    if (allocated(error)) return
    call check_name(self%model%mesh%node_sets, set, 'node set', error)
    if (.not. allocated(error) .and. (component < 1 .or. component > self%model%mesh%dimension)) &
      call fail(error, error_other, 'component '//integer_text(component)//' is not one of the model')
    if (allocated(error)) return
    associate (phase => self%scene%phases(number))
      do i = 1, size(phase%fixities)
        if (phase%fixities(i)%set == set .and. phase%fixities(i)%fixed(component)) call fail(error, error_other, &
          "set '"//set//"' is held and moved in stage '"//phase%name//"'")
      end do
      if (allocated(error)) return
      prescription%set = set
      prescription%component = component
      prescription%value = value
      i = findloc([(phase%prescriptions(i)%set == set .and. phase%prescriptions(i)%component == component, &
        i=1, size(phase%prescriptions))], .true., dim=1)
      if (i == 0) phase%prescriptions = [phase%prescriptions, prescription]
      if (i > 0) phase%prescriptions(i) = prescription
    end associate
    call self%take_over(error)
  end subroutine set_displacement

  !> Sets the fixed components of a node set from the next stage on; none releases it.
  subroutine set_fixity(self, set, fixed, error)
    class(simulation_type), intent(inout) :: self
    !> Name of the set.
    character(len=*), intent(in) :: set
    !> Whether each component is fixed (3).
    logical, intent(in) :: fixed(3)
    !> Set when there is no such set or no next stage.
    type(error_type), allocatable, intent(out) :: error
    type(fixity_type) :: fixity
    integer :: number, i

    call find_coming(self, number, error)
    if (allocated(error)) return
    call check_name(self%model%mesh%node_sets, set, 'node set', error)
    ! A set with all components fixed means the components of a plane model.
    if (.not. allocated(error) .and. self%model%mesh%dimension == 2 .and. fixed(3) .and. .not. all(fixed)) &
      call fail(error, error_other, 'component 3 is not one of the model')
    if (allocated(error)) return
    fixity%set = set
    fixity%fixed = fixed
    associate (phase => self%scene%phases(number))
      i = findloc([(phase%fixities(i)%set == set, i=1, size(phase%fixities))], .true., dim=1)
      if (i == 0) phase%fixities = [phase%fixities, fixity]
      if (i > 0) phase%fixities(i) = fixity
    end associate
    call self%take_over(error)
  end subroutine set_fixity

  !> Sets forces on the material points from the next step on; they are applied in full, not increased over a stage.
  subroutine set_point_force(self, force, error)
    class(simulation_type), intent(inout) :: self
    !> (dimension, points)
    real(wp), intent(in) :: force(:, :)
    !> Set when the number of points differs, or when several processes share the model, since none stores all points.
    type(error_type), allocatable, intent(out) :: error

    call need_model(self, error)
    if (.not. allocated(error)) call need_numbers(reshape(force, [size(force)]), error)
    if (allocated(error)) return
    if (self%loop%team%ranks > 1) then
      call fail(error, error_other, 'forces on the points require a model that one process has')
      return
    end if
    if (any(shape(force) /= [self%model%mesh%dimension, self%model%state%points%count])) then
      call fail(error, error_other, 'forces on the points require '//integer_text(self%model%mesh%dimension)// &
        ' components for each of '//integer_text(self%model%state%points%count)//' points')
      return
    end if
    if (.not. allocated(self%model%loading%point_force)) &
      allocate (self%model%loading%point_force(size(force, 1), size(force, 2)))
    self%model%loading%point_force(:, :) = force
  end subroutine set_point_force

  !> Checks that there is a surface or node set of this name.
  subroutine check_name(list, name, what, error)
    class(named_type), intent(in) :: list(:)
    character(len=*), intent(in) :: name
    !> Kind of the item, for the message.
    character(len=*), intent(in) :: what
    !> Set when there is none.
    type(error_type), allocatable, intent(out) :: error
    type(string_type), allocatable :: names(:)

    if (place_named(list, name) > 0) return
    allocate (names(0))
    call add_names(list, names)
    call fail(error, error_other, 'there is no '//what//" '"//name//"'"//did_you_mean(name, names))
  end subroutine check_name

  !> Checks that a vector is valid for the scene.
  pure subroutine need_vector(self, vector, error)
    class(simulation_type), intent(in) :: self
    !> (3)
    real(wp), intent(in) :: vector(3)
    !> Set when a component is infinite or not a number, or is out of plane in a plane scene.
    type(error_type), allocatable, intent(out) :: error

    call need_numbers(vector, error)
    if (allocated(error) .or. self%scene%model == three_dimensional) return
    if (abs(vector(3)) > 0.0_wp) call fail(error, error_other, 'the vector has a component along z, the scene is plane')
  end subroutine need_vector

  !> Checks that values are finite.
  pure subroutine need_numbers(values, error)
    real(wp), intent(in) :: values(:)
    !> Set when a value is infinite or not a number.
    type(error_type), allocatable, intent(out) :: error

    if (.not. all(abs(values) <= huge(1.0_wp))) call fail(error, error_other, 'a value is not a finite number')
  end subroutine need_numbers
end module qsmpm_simulation
