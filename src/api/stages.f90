!> Changes of the stages of an analysis by an embedding program: a stage (a phase of a deck) ends early, and the model
!> takes the stages of the scene.
!>
!> Materials and phases can be added to a scene as deck keywords. They are read together with the scene as one deck, so
!> that they have the same meaning and are checked in the same way; line numbers of errors refer to the added text.
!>
!> A model in progress is extended to a scene with more materials and phases. The whole scene is built again as a
!> separate model, so that everything is checked as in a deck; laws and phases of that model are taken over, and what
!> depends on the state (activated and deactivated bodies, pore pressure, ends of phases) is set up for the current
!> state.
module qsmpm_stages
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_load_description, only: traction_type
  use qsmpm_phase_description, only: initial_keep
  use qsmpm_drainage, only: set_drainage
  use qsmpm_error, only: error_type, error_other, fail, error_deck
  use qsmpm_load_path, only: between
  use qsmpm_model, only: model_type, state_type
  use qsmpm_phase_loads, only: load_in_force
  use qsmpm_phase_tree, only: lineage, parent_of
  use qsmpm_vertical, only: upwards
  use qsmpm_reduction, only: expansion_type, reduction_check_type
  use qsmpm_scene, only: reduce_scene
  use qsmpm_snapshot, only: copy_phases
  use qsmpm_undrained_law, only: undrained_law_type
  use qsmpm_material_description, only: material_type
  use qsmpm_deck, only: parse_deck, echo_text, message_list_type, message_text
  use qsmpm_text, only: integer_text, newline, upper
  use qsmpm_active_bodies, only: has_stages
  use qsmpm_body_stages, only: part_bodies
  use qsmpm_kept_phases, only: find_kept_phase, keep_phase
  use qsmpm_law, only: law_slot_type
  use qsmpm_inactive_points, only: lift_feet_type
  use qsmpm_lowered_laws, only: fit_laws
  use qsmpm_model_builder, only: build_model
  use qsmpm_points, only: carries_water, start_water
  use qsmpm_pore_water, only: has_pore_pressure
  use qsmpm_strength_factor, only: strength_factor_type
  implicit none
  private

  public :: cut_stage, take_over_stages, take_phases, same_steps, read_added_cards, name_added_lines, extend_model, &
    drop_materials

  !> Replaces the file name in messages.
  character(len=*), parameter :: added_name = 'added cards'

  !> Position of the added lines in the combined deck: materials before the first phase, phases at the end.
  type, public :: added_lines_type
    character(len=:), allocatable :: deck
    !> Number of lines before the materials, of the materials, and between them and the phases.
    integer :: before = 0, materials = 0, between = 0
  end type added_lines_type

contains

  !> Ends a stage at its current load: the loads reached become its loads, the displacements reached its displacements.
  !> An interpolated water level is not a valid level, nor is its pressure.
  subroutine cut_stage(scene, number, share, error)
    type(analysis_type), intent(inout) :: scene
    !> Number of the stage.
    integer, intent(in) :: number
    !> Completed load fraction of the stage.
    real(wp), intent(in) :: share
    !> Set when the stage moves a water level; the stage is then unchanged.
    type(error_type), allocatable, intent(out) :: error
    type(traction_type) :: before
    real(wp) :: factor, kept, start
    integer :: i

    if (share < 1.0_wp .and. moves_water(scene, number)) then
      call fail(error, error_other, "stage '"//scene%phases(number)%name//"' moves a water level, which has no "// &
        'form half way: it cannot end before its time')
      return
    end if

    ! A stage without any completed step keeps its load factor, which must not be 0.
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
            ! The pressure reached replaces the pressure at the end of the stage; both vary linearly with height.
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

  !> Returns whether a stage that does not start from K0 stresses moves a water level or the pressure of water.
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

  !> Returns gravity at the end of the stages before a stage.
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

  !> Returns the dead traction or pressure on a surface at the end of the stages before a stage.
  pure type(traction_type) function load_before(scene, number, surface, follows) result(load)
    type(analysis_type), intent(in) :: scene
    !> Number of the stage.
    integer, intent(in) :: number
    !> Name of the surface.
    character(len=*), intent(in) :: surface
    !> Whether the load is a pressure (follower load).
    logical, intent(in) :: follows
    integer, allocatable :: line(:)

    allocate (line, source=lineage(scene%phases, number))
    load = load_in_force(scene%phases, line(:size(line) - 1), surface, follows)
  end function load_before

  !> Assigns the stages of the scene to the model. A reduced model accepts them only if its reductions remain valid.
  subroutine take_over_stages(scene, expansion, model, error)
    !> The scene with its new stages.
    type(analysis_type), intent(in) :: scene
    !> The expansion from the model to the scene.
    type(expansion_type), intent(in) :: expansion
    !> The model; unchanged on error.
    type(model_type), intent(inout) :: model
    !> Set when the reductions of the model are not valid for the scene with these stages.
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

  !> Copies the stages.
  subroutine take_phases(analysis, model)
    !> Analysis that contains the stages.
    type(analysis_type), intent(in) :: analysis
    type(model_type), intent(inout) :: model

    call copy_phases(analysis%phases, model%analysis%phases)
    call take_drainage(model)
  end subroutine take_phases

  !> Updates the drainage of the laws of undrained soil for all phases.
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

  !> Returns whether two scenes were reduced in the same way.
  pure logical function same_steps(a, b)
    !> Expansions of the two scenes.
    type(expansion_type), intent(in) :: a, b

    same_steps = size(a%steps) == size(b%steps)
    if (same_steps) same_steps = all(a%steps%kind == b%steps%kind .and. a%steps%axis == b%steps%axis)
  end function same_steps

  !> Extends a scene by materials and phases given as deck keywords.
  subroutine read_added_cards(scene, cards, extended, lines, warnings, error)
    type(analysis_type), intent(in) :: scene
    !> Lines of a deck: *MATERIAL and *PHASE blocks.
    character(len=*), intent(in) :: cards
    !> The extended scene.
    type(analysis_type), intent(out) :: extended
    type(added_lines_type), intent(out) :: lines
    !> Messages of the reader, one per line.
    character(len=:), allocatable, intent(out) :: warnings
    !> Set when the keywords have errors; its message lists all of them.
    type(error_type), allocatable, intent(out) :: error
    type(analysis_type) :: whole
    type(message_list_type) :: messages
    character(len=:), allocatable :: echo, text

    call echo_text(scene, echo)
    call put_together(echo, cards, text, lines)
    lines%deck = scene%deck
    call parse_deck(scene%deck, text, whole, messages, error)
    warnings = name_added_lines(message_text(messages), lines)
    if (allocated(error)) then
      deallocate (error)
      ! A scene changed by calls may not be a valid deck any more; its own lines are then reported.
      if (len(warnings) == 0) warnings = message_text(messages)
      call fail(error, error_deck, 'the cards are not good:'//newline//warnings)
      return
    end if
    call check_kinds(scene, echo, whole, error)
    if (.not. allocated(error)) call take_new(scene, whole, extended)
  end subroutine read_added_cards

  !> Assembles the deck with the materials before its first phase and the phases at its end.
  subroutine put_together(echo, cards, text, lines)
    character(len=*), intent(in) :: echo, cards
    character(len=:), allocatable, intent(out) :: text
    type(added_lines_type), intent(inout) :: lines
    integer :: old, new

    old = first_phase(echo)
    new = first_phase(cards)
    text = echo(:old - 1)//ended(cards(:new - 1))
    lines%before = line_count(echo(:old - 1))
    lines%materials = line_count(ended(cards(:new - 1)))
    lines%between = line_count(echo(old:))
    text = text//echo(old:)//ended(cards(new:))
  end subroutine put_together

  !> Returns the position of the first line with *PHASE; the end of the text plus one if there is none.
  pure integer function first_phase(text) result(place)
    character(len=*), intent(in) :: text
    integer :: length

    place = 1
    do while (place <= len(text))
      if (index(upper(adjustl(text(place:min(len(text), place + 80)))), '*PHASE') == 1) return
      length = index(text(place:), newline)
      if (length == 0) exit
      place = place + length
    end do
    place = len(text) + 1
  end function first_phase

  !> Returns a text whose last line is terminated.
  pure function ended(text)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: ended

    ended = text
    if (len(text) == 0) return
    if (text(len(text):) /= newline) ended = text//newline
  end function ended

  !> Returns the number of lines.
  pure integer function line_count(text)
    character(len=*), intent(in) :: text
    integer :: i

    line_count = count([(text(i:i) == newline, i=1, len(text))])
  end function line_count

  !> Selects the messages of the form `deck:line: ...` that refer to added lines and renumbers the lines; messages
  !> about other lines have been reported before and are omitted.
  pure function name_added_lines(sentences, lines) result(text)
    !> Messages, one per line.
    character(len=*), intent(in) :: sentences
    type(added_lines_type), intent(in) :: lines
    character(len=:), allocatable :: text
    integer :: first, last, behind, number, status

    text = ''
    first = 1
    do while (first <= len(sentences))
      last = first + index(sentences(first:)//newline, newline) - 2
      associate (sentence => sentences(first:last), start => len(lines%deck) + 2)
        first = last + 2
        if (index(sentence, lines%deck//':') /= 1) then
          text = text//sentence//newline
          cycle
        end if
        behind = start + index(sentence(start:), ':') - 1
        read (sentence(start:behind - 1), *, iostat=status) number
        number = number - lines%before
        if (number > lines%materials) number = max(0, number - lines%between)
        if (status == 0 .and. number > 0) text = text//added_name//':'//integer_text(number)//sentence(behind:)//newline
      end associate
    end do
  end function name_added_lines

  !> Checks that only materials and phases are new.
  subroutine check_kinds(scene, echo, whole, error)
    type(analysis_type), intent(in) :: scene
    !> The scene written as a deck.
    character(len=*), intent(in) :: echo
    !> The combined scene that was read.
    type(analysis_type), intent(in) :: whole
    type(error_type), allocatable, intent(out) :: error
    type(analysis_type) :: rest
    character(len=:), allocatable :: again

    rest = whole
    call shorten(size(scene%materials), rest)
    call copy_phases(whole%phases(:size(scene%phases)), rest%phases)
    call echo_text(rest, again)
    if (again /= echo) call fail(error, error_other, 'only *MATERIAL and *PHASE, with the cards that belong to '// &
      'them, can be added to a scene')
  end subroutine check_kinds

  !> Takes the new materials and phases; of the existing materials only the drainage in the new phases is changed.
  subroutine take_new(scene, whole, extended)
    type(analysis_type), intent(in) :: scene, whole
    type(analysis_type), intent(inout) :: extended
    type(material_type), allocatable :: materials(:)
    integer :: i

    extended = scene
    if (allocated(whole%cards)) extended%cards = whole%cards
    allocate (materials(size(whole%materials)))
    do i = 1, size(materials)
      materials(i) = whole%materials(i)
      if (i > size(scene%materials)) cycle
      materials(i) = scene%materials(i)
      materials(i)%undrained = whole%materials(i)%undrained
    end do
    call move_alloc(materials, extended%materials)
    do i = size(scene%phases) + 1, size(whole%phases)
      extended%phases = [extended%phases, whole%phases(i)]
    end do
  end subroutine take_new

  !> Extends the model to a scene that begins with the model's scene.
  subroutine extend_model(scene, expansion, own, ended, model, error)
    type(analysis_type), intent(in) :: scene
    !> The expansion from the model to the scene.
    type(expansion_type), intent(in) :: expansion
    !> User-defined laws, where assigned (materials of the model when built).
    type(law_slot_type), intent(in) :: own(:)
    !> Whether the current phase has ended.
    logical, intent(in) :: ended
    !> Unchanged on error.
    type(model_type), intent(inout) :: model
    !> Set when the scene has errors or the model cannot be extended.
    type(error_type), allocatable, intent(out) :: error
    class(analysis_type), allocatable :: reduced
    type(expansion_type) :: now
    type(reduction_check_type), allocatable :: checks(:)
    class(model_type), allocatable :: fresh
    type(law_slot_type), allocatable :: laws(:)
    integer :: m

    allocate (reduced, fresh)
    call reduce_scene(scene, reduced, now, checks)
    if (.not. same_steps(expansion, now)) then
      call fail(error, error_other, 'with these cards the scene is not what it was reduced to; name the type '// &
        'of the model instead of *MODEL, TYPE=AUTO')
      return
    end if
    allocate (laws(size(reduced%materials)))
    do m = 1, size(own)
      if (allocated(own(m)%law)) allocate (laws(m)%law, source=own(m)%law)
    end do
    call build_model(reduced, fresh, error, laws)
    if (.not. allocated(error)) call check_fit(fresh, model, error)
    if (allocated(error)) return
    call take_model(fresh, ended, model)
  end subroutine extend_model

  !> Checks that the state of the model can store the new data.
  subroutine check_fit(fresh, model, error)
    !> Model of the whole scene at its start.
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

  !> Takes materials, laws and phases and prepares the state for them.
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
    ! First activation or deactivation of bodies; in a restored state the bodies may be separated already.
    if (.not. parted .and. has_stages(model%analysis)) then
      if (allocated(model%tracer_body)) deallocate (model%tracer_body, model%tracer_foot)
      model%feet = lift_feet_type()
      call part_bodies(model)
    end if
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

  !> Allocates pore pressures at the points.
  subroutine wet(state)
    type(state_type), intent(inout) :: state

    if (carries_water(state%points)) return
    call start_water(state%points)
    call start_water(state%inactive%points)
    call start_water(state%inactive%unloading)
  end subroutine wet

  !> Removes the materials above a number, which a restored state does not have.
  subroutine drop_materials(number, scene, model)
    integer, intent(in) :: number
    type(analysis_type), intent(inout) :: scene
    type(model_type), intent(inout) :: model
    type(law_slot_type), allocatable :: laws(:)

    if (size(scene%materials) <= number) return
    call shorten(number, scene)
    call shorten(number, model%analysis)
    allocate (laws(number), source=model%laws(:number))
    call move_alloc(laws, model%laws)
  end subroutine drop_materials

  !> Retains the first materials.
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
end module qsmpm_stages
