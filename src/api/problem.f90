!> A problem: the definition of an analysis before its model is built. It comes from a deck file, from the text of a
!> deck in memory, or from an analysis filled in by the program. The program can assign user-defined laws to its
!> materials.
module qsmpm_problem
  use qsmpm_named, only: add_names, named_type, place_named
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_deck, only: read_deck, parse_deck, echo_text
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_law, only: law_type, law_slot_type
  use qsmpm_messages, only: message_list_type, message_text
  use qsmpm_soil_model, only: soil_model_type
  use qsmpm_soil_model_law, only: soil_model_law_type, make_soil_model_law
  use qsmpm_stopwatch, only: clock_type, start_clock, stopwatch_type, start_stopwatch, part_input
  use qsmpm_text, only: string_type, integer_text, did_you_mean
  implicit none
  private

  public :: problem_type, own_material_type, own_laws, mark_own

  !> User-defined law of a material: a law for one dimension, or a soil model for any dimension.
  type, extends(named_type) :: own_material_type
    class(law_type), allocatable :: law
    class(soil_model_type), allocatable :: model
  end type own_material_type

  !> Definition of an analysis.
  type :: problem_type
    !> The scene as defined in the deck, with all defaults.
    type(analysis_type) :: scene
    !> Warnings of the reader, one per line; after an error also all faults.
    character(len=:), allocatable :: messages
    !> Whether `scene` has been read.
    logical :: given = .false.
    type(own_material_type), allocatable :: materials(:)
    !> Clocks started when reading begins.
    type(clock_type) :: clock
    type(stopwatch_type) :: watch
  contains
    procedure :: read => read_problem
    procedure :: parse => parse_problem
    procedure :: take => take_scene
    procedure, private :: set_law
    procedure, private :: set_model
    !> Assigns a user-defined law to a material: an extension of law_type or of soil_model_type.
    generic :: set_material => set_law, set_model
  end type problem_type

contains

  !> Reads a deck from a file.
  subroutine read_problem(self, path, error)
    !> The problem; user-defined laws assigned before are retained.
    class(problem_type), intent(inout) :: self
    !> Path of the deck file.
    character(len=*), intent(in) :: path
    !> Set when the deck has errors; `messages` lists all of them.
    type(error_type), allocatable, intent(out) :: error

    call take_deck(self, path, error)
  end subroutine read_problem

  !> Reads a deck from a text in memory.
  subroutine parse_problem(self, text, name, error)
    !> The problem; user-defined laws assigned before are retained.
    class(problem_type), intent(inout) :: self
    !> Text of the deck, lines ended by new_line.
    character(len=*), intent(in) :: text
    !> Job name; with a path, also the folder for relative paths in the deck.
    character(len=*), intent(in) :: name
    !> Set when the deck has errors; `messages` lists all of them.
    type(error_type), allocatable, intent(out) :: error

    call take_deck(self, name, error, text)
  end subroutine parse_problem

  !> Starts the clocks, reads the deck and stores the messages of the reader.
  subroutine take_deck(self, name, error, text)
    class(problem_type), intent(inout) :: self
    character(len=*), intent(in) :: name
    type(error_type), allocatable, intent(out) :: error
    !> Text of the deck; if absent, the file with this name is read.
    character(len=*), intent(in), optional :: text
    type(message_list_type) :: messages

    call start_clock(self%clock)
    call start_stopwatch(self%watch, part_input)
    if (.not. allocated(self%materials)) allocate (self%materials(0))
    if (present(text)) then
      call parse_deck(name, text, self%scene, messages, error)
    else
      call read_deck(name, self%scene, messages, error)
    end if
    self%messages = message_text(messages)
    self%given = .not. allocated(error)
  end subroutine take_deck

  !> Takes an analysis filled in by the program. It is written as a deck and read again, so that it is checked and
  !> completed like a deck; errors refer to the lines of that deck.
  subroutine take_scene(self, scene, error)
    !> The problem; user-defined laws assigned before are retained.
    class(problem_type), intent(inout) :: self
    !> The analysis; lists and texts must be allocated, as in the scene of another problem.
    type(analysis_type), intent(in) :: scene
    !> Set when the analysis has errors; `messages` lists all of them.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: text, name

    call echo_text(scene, text)
    name = 'analysis'
    if (allocated(scene%job)) name = scene%job
    call self%parse(text, name, error)
  end subroutine take_scene

  !> Assigns a law for points of one dimension to a material.
  subroutine set_law(self, material, law, error)
    class(problem_type), intent(inout) :: self
    !> Name of the material in the deck.
    character(len=*), intent(in) :: material
    !> The law; a copy is stored.
    class(law_type), intent(in) :: law
    !> Set when the name is empty, or is not a material of the deck that has been read.
    type(error_type), allocatable, intent(out) :: error
    integer :: place

    call find_place(self, material, place, error)
    if (.not. allocated(error)) allocate (self%materials(place)%law, source=law)
  end subroutine set_law

  !> Assigns a soil model to a material.
  subroutine set_model(self, material, model, error)
    class(problem_type), intent(inout) :: self
    !> Name of the material in the deck.
    character(len=*), intent(in) :: material
    !> The model; a copy is stored.
    class(soil_model_type), intent(in) :: model
    !> Set when the name is empty, or is not a material of the deck that has been read.
    type(error_type), allocatable, intent(out) :: error
    integer :: place

    call find_place(self, material, place, error)
    if (.not. allocated(error)) allocate (self%materials(place)%model, source=model)
  end subroutine set_model

  !> Returns an empty position for a material in the list, or its previous position if it is assigned again.
  subroutine find_place(self, material, place, error)
    class(problem_type), intent(inout) :: self
    !> Name of the material.
    character(len=*), intent(in) :: material
    integer, intent(out) :: place
    !> Set when the name is empty, or is not a material of the deck that has been read.
    type(error_type), allocatable, intent(out) :: error
    type(own_material_type), allocatable :: longer(:)
    integer :: i

    place = 0
    if (len_trim(material) == 0) then
      call fail(error, error_other, 'a material of the program requires the name it has in the deck')
      return
    end if
    if (self%given) then
      if (place_named(self%scene%materials, material) == 0) then
        call fail(error, error_other, unknown_text(self%scene, material))
        return
      end if
    end if
    if (.not. allocated(self%materials)) allocate (self%materials(0))
    place = place_named(self%materials, material)
    if (place == 0) then
      place = size(self%materials) + 1
      allocate (longer(place))
      do i = 1, place - 1
        call move_alloc(self%materials(i)%name, longer(i)%name)
        call move_alloc(self%materials(i)%law, longer(i)%law)
        call move_alloc(self%materials(i)%model, longer(i)%model)
      end do
      call move_alloc(longer, self%materials)
      self%materials(place)%name = trim(material)
    end if
    if (allocated(self%materials(place)%law)) deallocate (self%materials(place)%law)
    if (allocated(self%materials(place)%model)) deallocate (self%materials(place)%model)
  end subroutine find_place

  !> Marks the materials with user-defined laws, about which the program makes no assumptions.
  subroutine mark_own(materials, analysis)
    !> Materials with user-defined laws, if any.
    type(own_material_type), allocatable, intent(in) :: materials(:)
    type(analysis_type), intent(inout) :: analysis
    integer :: i, m

    if (.not. allocated(materials)) return
    do i = 1, size(materials)
      m = place_named(analysis%materials, materials(i)%name)
      if (m > 0) analysis%materials(m)%own_law = .true.
    end do
  end subroutine mark_own

  !> Returns the user-defined laws in the order of the materials of an analysis.
  subroutine own_laws(materials, analysis, laws, error)
    !> Materials with user-defined laws, if any.
    type(own_material_type), allocatable, intent(in) :: materials(:)
    type(analysis_type), intent(in) :: analysis
    !> (materials of the analysis)
    type(law_slot_type), allocatable, intent(out) :: laws(:)
    !> Set when a name is not in the deck or a law is for another dimension.
    type(error_type), allocatable, intent(out) :: error
    type(soil_model_law_type) :: adapted
    integer :: i, m, dimension

    allocate (laws(size(analysis%materials)))
    dimension = merge(3, 2, analysis%model == three_dimensional)
    if (.not. allocated(materials)) return
    do i = 1, size(materials)
      m = place_named(analysis%materials, materials(i)%name)
      if (m == 0) then
        call fail(error, error_other, unknown_text(analysis, materials(i)%name))
        return
      end if
      if (allocated(laws(m)%law)) deallocate (laws(m)%law)
      if (allocated(materials(i)%model)) then
        call make_soil_model_law(materials(i)%model, dimension, adapted)
        adapted%name = materials(i)%name
        allocate (laws(m)%law, source=adapted)
      else if (allocated(materials(i)%law)) then
        if (materials(i)%law%dimension /= dimension) then
          call fail(error, error_other, "the law given to material '"//materials(i)%name//"' is for "// &
            integer_text(materials(i)%law%dimension)//' dimensions, the model has '//integer_text(dimension))
          return
        end if
        allocate (laws(m)%law, source=materials(i)%law)
      end if
    end do
  end subroutine own_laws

  !> Returns the error message for an unknown material.
  pure function unknown_text(analysis, name) result(text)
    type(analysis_type), intent(in) :: analysis
    !> The unknown name.
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: text
    type(string_type), allocatable :: names(:)

    allocate (names(0))
    call add_names(analysis%materials, names)
    text = "a law is given to material '"//name//"', but the deck has none of that name"//did_you_mean(name, names)
  end function unknown_text
end module qsmpm_problem
