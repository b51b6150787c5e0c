!> Interfaces to the C functions of QSMPM for a Fortran program built with any compiler, which cannot use module files
!> of another compiler. Compile this file with the program and link the library; qsmpm.h describes the functions. Texts
!> end with c_null_char.
module qsmpm_c
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_funptr, c_int, c_ptr
  implicit none
  private

  public :: qsmpm_api_version, qsmpm_version, qsmpm_has, qsmpm_create, qsmpm_destroy, qsmpm_error, &
    qsmpm_messages, qsmpm_set_logger, qsmpm_set_verbosity, qsmpm_set_threads, qsmpm_read_deck, &
    qsmpm_parse_deck, qsmpm_set_material, qsmpm_initialise, qsmpm_advance, qsmpm_advance_to, qsmpm_run, &
    qsmpm_finished, qsmpm_record, qsmpm_finish_record, qsmpm_save, qsmpm_load, qsmpm_checkpoint, &
    qsmpm_restore_checkpoint, &
    qsmpm_add_stage, qsmpm_add_cards, qsmpm_end_stage, qsmpm_set_load_factor, qsmpm_set_steps, qsmpm_set_time, &
    qsmpm_set_start_time, qsmpm_set_gravity, &
    qsmpm_set_traction, qsmpm_set_pressure, qsmpm_set_water_level, qsmpm_set_displacement, qsmpm_set_fixity, qsmpm_shape, &
    qsmpm_count, &
    qsmpm_get, qsmpm_set, qsmpm_view, qsmpm_name
  public :: qsmpm_model_options, qsmpm_increment, qsmpm_response

  !> Status of a call.
  integer(c_int), parameter, public :: qsmpm_ok = 0, qsmpm_other = 1, qsmpm_deck = 2, qsmpm_not_converged = 3, &
    qsmpm_left_mesh = 4, qsmpm_singular = 5, qsmpm_user_material = 6, qsmpm_no_handle = 7, qsmpm_stopped = 128
  !> Response of a material at a point.
  integer(c_int), parameter, public :: qsmpm_updated = 0, qsmpm_cut = 1, qsmpm_failed = 2, qsmpm_unrecoverable = 3

  !> Properties of a user-defined soil model.
  type, bind(c) :: qsmpm_model_options
    integer(c_int) :: state_count = 0
    integer(c_int) :: symmetric = 0
    integer(c_int) :: thread_safe = 0
    integer(c_int) :: reads_strain = 0
    integer(c_int) :: reads_gradient = 0
    real(c_double) :: stiffness_scale = 0.0_c_double
    real(c_double) :: shear_scale = 0.0_c_double
  end type qsmpm_model_options

  !> Input of the update of a point for one step.
  type, bind(c) :: qsmpm_increment
    real(c_double) :: strain(6), strain_start(6), rotation(3, 3), gradient_start(3, 3), gradient_end(3, 3)
    integer(c_int) :: phase, step
    real(c_double) :: start, duration
    integer(c_int) :: point, cell
    real(c_double) :: place(3), cell_size
    integer(c_int) :: wants_tangent, elastic_tangent
    real(c_double) :: time, time_increment
  end type qsmpm_increment

  !> Result of the update of a point.
  type, bind(c) :: qsmpm_response
    integer(c_int) :: plastic
    real(c_double) :: share
    real(c_double) :: tangent(6, 6)
    character(kind=c_char) :: message(256)
  end type qsmpm_response

  interface
    !> Returns the version of the interface: 10000 major + 100 minor + patch.
    integer(c_int) function qsmpm_api_version() bind(c) result(status)
      import :: c_int
    end function qsmpm_api_version

    !> Returns name, version and build options; the result is the length of the text.
    integer(c_int) function qsmpm_version(buffer, size) bind(c) result(status)
      import :: c_char, c_int
      character(kind=c_char), intent(out) :: buffer(*)
      integer(c_int), value :: size
    end function qsmpm_version

    !> Returns 1 if an optional feature is available.
    integer(c_int) function qsmpm_has(feature) bind(c) result(status)
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: feature(*)
    end function qsmpm_has

    !> Creates a handle.
    integer(c_int) function qsmpm_create(handle) bind(c) result(status)
      import :: c_int, c_ptr
      type(c_ptr), intent(out) :: handle
    end function qsmpm_create

    !> Frees a handle and sets it to null.
    integer(c_int) function qsmpm_destroy(handle) bind(c) result(status)
      import :: c_int, c_ptr
      type(c_ptr), intent(inout) :: handle
    end function qsmpm_destroy

    !> Returns the message of the last failed call; the result is its length.
    integer(c_int) function qsmpm_error(handle, buffer, size) bind(c) result(status)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(out) :: buffer(*)
      integer(c_int), value :: size
    end function qsmpm_error

    !> Returns the messages of the deck reader; the result is the length of the text.
    integer(c_int) function qsmpm_messages(handle, buffer, size) bind(c) result(status)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(out) :: buffer(*)
      integer(c_int), value :: size
    end function qsmpm_messages

    !> Sets the procedure that receives messages.
    integer(c_int) function qsmpm_set_logger(handle, logger, user) bind(c) result(status)
      import :: c_funptr, c_int, c_ptr
      type(c_ptr), value :: handle
      type(c_funptr), value :: logger
      type(c_ptr), value :: user
    end function qsmpm_set_logger

    !> Sets what the logger receives: 0 nothing, 1 messages, 2 messages and steps.
    integer(c_int) function qsmpm_set_verbosity(handle, level) bind(c) result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: handle
      integer(c_int), value :: level
    end function qsmpm_set_verbosity

    !> Sets the number of threads of the analysis.
    integer(c_int) function qsmpm_set_threads(handle, threads) bind(c) result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: handle
      integer(c_int), value :: threads
    end function qsmpm_set_threads

    !> Reads a deck from a file.
    integer(c_int) function qsmpm_read_deck(handle, path) bind(c) result(status)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: path(*)
    end function qsmpm_read_deck

    !> Reads a deck from a text in memory.
    integer(c_int) function qsmpm_parse_deck(handle, text, job) bind(c) result(status)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: text(*)
      character(kind=c_char), intent(in) :: job(*)
    end function qsmpm_parse_deck

    !> Assigns a user-defined soil model to a material of the deck.
    integer(c_int) function qsmpm_set_material(handle, material, options, start, update, user) bind(c) result(status)
      import :: c_char, c_funptr, c_int, c_ptr, qsmpm_model_options
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: material(*)
      type(qsmpm_model_options), intent(in) :: options
      type(c_funptr), value :: start
      type(c_funptr), value :: update
      type(c_ptr), value :: user
    end function qsmpm_set_material

    !> Generates the mesh and the material points and prepares the analysis for stepping.
    integer(c_int) function qsmpm_initialise(handle) bind(c) result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: handle
    end function qsmpm_initialise

    !> Computes one accepted load step.
    integer(c_int) function qsmpm_advance(handle) bind(c) result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: handle
    end function qsmpm_advance

    !> Steps to a load fraction of a stage.
    integer(c_int) function qsmpm_advance_to(handle, share) bind(c) result(status)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: handle
      real(c_double), value :: share
    end function qsmpm_advance_to

    !> Steps to the end of the last stage.
    integer(c_int) function qsmpm_run(handle) bind(c) result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: handle
    end function qsmpm_run

    !> Returns 1 if the last stage has ended.
    integer(c_int) function qsmpm_finished(handle) bind(c) result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: handle
    end function qsmpm_finished

    !> Starts to write results to a directory.
    integer(c_int) function qsmpm_record(handle, directory) bind(c) result(status)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: directory(*)
    end function qsmpm_record

    !> Closes the result files.
    integer(c_int) function qsmpm_finish_record(handle) bind(c) result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: handle
    end function qsmpm_finish_record

    !> Writes the state to a file.
    integer(c_int) function qsmpm_save(handle, path) bind(c) result(status)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: path(*)
    end function qsmpm_save

    !> Reads the state from a file.
    integer(c_int) function qsmpm_load(handle, path) bind(c) result(status)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: path(*)
    end function qsmpm_load

    !> Stores a copy of state, loads and stages in memory.
    integer(c_int) function qsmpm_checkpoint(handle) bind(c) result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: handle
    end function qsmpm_checkpoint

    !> Restores the copy.
    integer(c_int) function qsmpm_restore_checkpoint(handle) bind(c) result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: handle
    end function qsmpm_restore_checkpoint

    !> Appends a stage.
    integer(c_int) function qsmpm_add_stage(handle, name, steps) bind(c) result(status)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: name(*)
      integer(c_int), value :: steps
    end function qsmpm_add_stage

    !> Adds materials and phases, given as deck keywords, to the scene.
    integer(c_int) function qsmpm_add_cards(handle, cards) bind(c) result(status)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: cards(*)
    end function qsmpm_add_cards

    !> Ends the current stage at its current load.
    integer(c_int) function qsmpm_end_stage(handle) bind(c) result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: handle
    end function qsmpm_end_stage

    !> Sets the load factor at the end of the next stage.
    integer(c_int) function qsmpm_set_load_factor(handle, factor) bind(c) result(status)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: handle
      real(c_double), value :: factor
    end function qsmpm_set_load_factor

    !> Sets the number of load steps of the next stage.
    integer(c_int) function qsmpm_set_steps(handle, steps) bind(c) result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: handle
      integer(c_int), value :: steps
    end function qsmpm_set_steps

    !> Sets the duration of the next stage.
    integer(c_int) function qsmpm_set_time(handle, duration) bind(c) result(status)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: handle
      real(c_double), value :: duration
    end function qsmpm_set_time

    !> Sets the time at the start of the next stage.
    integer(c_int) function qsmpm_set_start_time(handle, time) bind(c) result(status)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: handle
      real(c_double), value :: time
    end function qsmpm_set_start_time

    !> Sets gravity (3) at the end of the next stage.
    integer(c_int) function qsmpm_set_gravity(handle, vector) bind(c) result(status)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: handle
      real(c_double), intent(in) :: vector(*)
    end function qsmpm_set_gravity

    !> Sets the dead traction (3) on a surface at the end of the next stage.
    integer(c_int) function qsmpm_set_traction(handle, surface, vector) bind(c) result(status)
      import :: c_char, c_double, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: surface(*)
      real(c_double), intent(in) :: vector(*)
    end function qsmpm_set_traction

    !> Sets the pressure on a surface at the end of the next stage.
    integer(c_int) function qsmpm_set_pressure(handle, surface, pressure) bind(c) result(status)
      import :: c_char, c_double, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: surface(*)
      real(c_double), value :: pressure
    end function qsmpm_set_pressure

    !> Sets a water level at the end of the next stage, identified by its node set, surface or body.
    integer(c_int) function qsmpm_set_water_level(handle, name, level) bind(c) result(status)
      import :: c_char, c_double, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: name(*)
      real(c_double), value :: level
    end function qsmpm_set_water_level

    !> Sets the displacement of a node set over the next stage.
    integer(c_int) function qsmpm_set_displacement(handle, set, component, value) bind(c) result(status)
      import :: c_char, c_double, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: set(*)
      integer(c_int), value :: component
      real(c_double), value :: value
    end function qsmpm_set_displacement

    !> Sets the fixed components (3) of a node set from the next stage on.
    integer(c_int) function qsmpm_set_fixity(handle, set, fixed) bind(c) result(status)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: set(*)
      integer(c_int), intent(in) :: fixed(*)
    end function qsmpm_set_fixity

    !> Returns the number of components and the number of values of a name.
    integer(c_int) function qsmpm_shape(handle, name, rows, columns) bind(c) result(status)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: name(*)
      integer(c_int), intent(out) :: rows
      integer(c_int), intent(out) :: columns
    end function qsmpm_shape

    !> Returns the size of the values of a name: components times number of values.
    integer(c_int) function qsmpm_count(handle, name, number) bind(c) result(status)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: name(*)
      integer(c_int), intent(out) :: number
    end function qsmpm_count

    !> Copies the values of a name to an array.
    integer(c_int) function qsmpm_get(handle, name, values, number) bind(c) result(status)
      import :: c_char, c_double, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: name(*)
      real(c_double), intent(inout) :: values(*)
      integer(c_int), value :: number
    end function qsmpm_get

    !> Sets the values of a name.
    integer(c_int) function qsmpm_set(handle, name, values, number) bind(c) result(status)
      import :: c_char, c_double, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: name(*)
      real(c_double), intent(in) :: values(*)
      integer(c_int), value :: number
    end function qsmpm_set

    !> Returns the address of values in memory.
    integer(c_int) function qsmpm_view(handle, name, values, rows, columns) bind(c) result(status)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: name(*)
      type(c_ptr), intent(out) :: values
      integer(c_int), intent(out) :: rows
      integer(c_int), intent(out) :: columns
    end function qsmpm_view

    !> Returns the name of an item of a kind; the result is its length, -1 if there is none.
    integer(c_int) function qsmpm_name(handle, kind, number, buffer, size) bind(c) result(status)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: kind(*)
      integer(c_int), value :: number
      character(kind=c_char), intent(out) :: buffer(*)
      integer(c_int), value :: size
    end function qsmpm_name
  end interface
end module qsmpm_c
