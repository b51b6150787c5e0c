!> Interface for Fortran 77 programs: external subroutines with integers, reals and strings as arguments, without
!> modules or pointers. Compile qsmpm_c.f90 and this file with the compiler of the program and link the library.
!>
!> A handle is an INTEGER*8, set by QSMNEW or QSMOPN and freed by QSMEND. IERR is the status defined in qsmpm.h; QSMERR
!> returns the message. Names and paths may have trailing blanks.
module qsmpm_f77_handles
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_f_pointer, c_funloc, c_int, c_intptr_t, c_loc, &
    c_null_char, c_null_ptr, c_ptr
  use qsmpm_c, only: qsmpm_increment, qsmpm_response
  implicit none
  private

  public :: analysis_type, law_type, find, pointer_of, number_of, as_c, as_text, start, update, hear
  !> C kinds and addresses for the subroutines below.
  public :: c_char, c_double, c_funloc, c_int, c_intptr_t, c_loc

  abstract interface
    !> User-defined law: updates one point for one step. Stress and state are those of the start on entry and of the
    !> end on return; six components 11, 22, 33, 12, 13, 23, tension positive, shear gamma.
    subroutine law_interface(stress, state, dstran, tangnt, nstate, info, rinfo, istat, messge)
      double precision, intent(inout) :: stress(6), state(*)
      !> Strain increment of the step.
      double precision, intent(in) :: dstran(6)
      !> d stress(i) / d strain(j).
      double precision, intent(inout) :: tangnt(6, 6)
      !> Number of state variables; phase, step, point, cell, 1 if the tangent is used, 1 if it may be the elastic one.
      integer, intent(in) :: nstate, info(6)
      !> Load fraction of the phase at the start and its increment, time at the start and its increment, location (3),
      !> cell size, fraction of the step to try next with ISTAT = 1.
      double precision, intent(inout) :: rinfo(9)
      !> 0 updated, 1 the step is too large, 2 failed, 3 failed and a smaller step does not help.
      integer, intent(inout) :: istat
      !> Reason, where ISTAT is not 0.
      character(len=*), intent(inout) :: messge
    end subroutine law_interface

    !> Receives a message.
    subroutine logger_interface(text)
      character(len=*), intent(in) :: text
    end subroutine logger_interface
  end interface

  !> User-defined law of a material.
  type :: law_type
    procedure(law_interface), pointer, nopass :: law => null()
    integer :: states = 0
    type(law_type), pointer :: next => null()
  end type law_type

  !> Data of a handle: the handle of the library and the data of its callbacks.
  type :: analysis_type
    type(c_ptr) :: pointer = c_null_ptr
    type(law_type), pointer :: laws => null()
    procedure(logger_interface), pointer, nopass :: logger => null()
  end type analysis_type

contains

  !> Returns the data of a handle, null for 0.
  subroutine find(number, analysis)
    integer(c_intptr_t), intent(in) :: number
    type(analysis_type), pointer, intent(out) :: analysis
    type(c_ptr) :: address

    nullify (analysis)
    if (number == 0_c_intptr_t) return
    address = transfer(number, address)
    call c_f_pointer(address, analysis)
  end subroutine find

  !> Returns the handle of the library.
  type(c_ptr) function pointer_of(number) result(pointer)
    integer(c_intptr_t), intent(in) :: number
    type(analysis_type), pointer :: analysis

    pointer = c_null_ptr
    call find(number, analysis)
    if (associated(analysis)) pointer = analysis%pointer
  end function pointer_of

  !> Returns the handle of an analysis.
  integer(c_intptr_t) function number_of(analysis) result(number)
    type(analysis_type), pointer, intent(in) :: analysis

    number = transfer(c_loc(analysis), number)
  end function number_of

  !> Returns the text without trailing blanks and with a null character.
  pure function as_c(text) result(string)
    character(len=*), intent(in) :: text
    character(len=len_trim(text) + 1) :: string

    string = trim(text)//c_null_char
  end function as_c

  !> Copies the text of a C buffer to a text with trailing blanks.
  subroutine as_text(buffer, length, text)
    character(kind=c_char), intent(in) :: buffer(*)
    !> Length of the text in the buffer.
    integer, intent(in) :: length
    character(len=*), intent(out) :: text
    integer :: i

    text = ' '
    do i = 1, min(length, len(text))
      text(i:i) = buffer(i)
    end do
  end subroutine as_text

  !> Sets the state variables of user-defined laws to zero at the start.
  subroutine start(user, stress, state) bind(c)
    type(c_ptr), value :: user
    real(c_double), intent(in) :: stress(6)
    real(c_double), intent(inout) :: state(*)
    type(law_type), pointer :: own

    call c_f_pointer(user, own)
    state(:own%states) = 0.0_c_double
  end subroutine start

  !> Calls a user-defined law.
  integer(c_int) function update(user, increment, stress, state, answer) bind(c) result(status)
    type(c_ptr), value :: user
    type(qsmpm_increment), intent(in) :: increment
    real(c_double), intent(inout) :: stress(6), state(*)
    type(qsmpm_response), intent(inout) :: answer
    type(law_type), pointer :: own
    character(len=255) :: message
    double precision :: tangent(6, 6), numbers(9)
    integer :: outcome, i

    call c_f_pointer(user, own)
    numbers = [increment%start, increment%duration, increment%time, increment%time_increment, increment%place, &
      increment%cell_size, 0.0_c_double]
    tangent = 0.0d0
    outcome = 0
    message = ' '
    call own%law(stress, state(:max(1, own%states)), increment%strain, tangent, own%states, int([increment%phase, &
      increment%step, increment%point, increment%cell, increment%wants_tangent, increment%elastic_tangent]), numbers, &
      outcome, message)
    answer%tangent = tangent
    answer%share = numbers(9)
    do i = 1, len_trim(message)
      answer%message(i) = message(i:i)
    end do
    answer%message(len_trim(message) + 1) = c_null_char
    status = int(outcome, c_int)
  end function update

  !> Passes a message to the procedure of the program.
  subroutine hear(user, text) bind(c)
    type(c_ptr), value :: user
    character(kind=c_char), intent(in) :: text(*)
    type(analysis_type), pointer :: analysis
    character(len=400) :: line
    integer :: length

    call c_f_pointer(user, analysis)
    if (.not. associated(analysis%logger)) return
    length = 0
    do while (length < len(line) .and. text(length + 1) /= c_null_char)
      length = length + 1
    end do
    call as_text(text, length, line)
    call analysis%logger(line(:max(1, length)))
  end subroutine hear
end module qsmpm_f77_handles

!> Creates a handle for the deck in a file and builds the model.
subroutine qsmnew(handle, deck, ierr)
  use, intrinsic :: iso_c_binding, only: c_intptr_t
  implicit none
  integer(c_intptr_t), intent(out) :: handle
  character(len=*), intent(in) :: deck
  integer, intent(out) :: ierr

  call qsmopn(handle, deck, ierr)
  if (ierr == 0) call qsmini(handle, ierr)
end subroutine qsmnew

!> Creates a handle for the deck in a file without building the model: materials may be assigned laws (QSMMAT) before
!> QSMINI.
subroutine qsmopn(handle, deck, ierr)
  use qsmpm_c, only: qsmpm_create, qsmpm_read_deck
  use qsmpm_f77_handles, only: analysis_type, as_c, number_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(out) :: handle
  character(len=*), intent(in) :: deck
  integer, intent(out) :: ierr
  type(analysis_type), pointer :: analysis

  handle = 0
  allocate (analysis)
  ierr = int(qsmpm_create(analysis%pointer))
  if (ierr /= 0) then
    deallocate (analysis)
    return
  end if
  handle = number_of(analysis)
  ierr = int(qsmpm_read_deck(analysis%pointer, as_c(deck)))
end subroutine qsmopn

!> Frees a handle.
subroutine qsmend(handle)
  use qsmpm_c, only: qsmpm_destroy
  use qsmpm_f77_handles, only: analysis_type, law_type, find, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(inout) :: handle
  type(analysis_type), pointer :: analysis
  type(law_type), pointer :: law
  integer :: ierr

  call find(handle, analysis)
  handle = 0
  if (.not. associated(analysis)) return
  ierr = int(qsmpm_destroy(analysis%pointer))
  do while (associated(analysis%laws))
    law => analysis%laws
    analysis%laws => law%next
    deallocate (law)
  end do
  deallocate (analysis)
end subroutine qsmend

!> Returns the message of the last failure.
subroutine qsmerr(handle, text)
  use qsmpm_c, only: qsmpm_error
  use qsmpm_f77_handles, only: as_text, pointer_of, c_char, c_int, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(out) :: text
  character(kind=c_char) :: buffer(len(text) + 1)
  integer :: length

  length = int(qsmpm_error(pointer_of(handle), buffer, int(size(buffer), c_int)))
  call as_text(buffer, length, text)
end subroutine qsmerr

!> Returns the messages of the deck reader, lines ended by CHAR(10); LENGTH is the length of the complete text.
subroutine qsmmsg(handle, text, length)
  use qsmpm_c, only: qsmpm_messages
  use qsmpm_f77_handles, only: as_text, pointer_of, c_char, c_int, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(out) :: text
  integer, intent(out) :: length
  character(kind=c_char) :: buffer(len(text) + 1)

  length = int(qsmpm_messages(pointer_of(handle), buffer, int(size(buffer), c_int)))
  call as_text(buffer, length, text)
end subroutine qsmmsg

!> Sets a subroutine LOGGER(TEXT) that receives nothing (LEVEL 0), messages (1), or also a line for every step (2).
subroutine qsmlog(handle, logger, level, ierr)
  use qsmpm_c, only: qsmpm_set_logger, qsmpm_set_verbosity, qsmpm_no_handle
  use qsmpm_f77_handles, only: analysis_type, find, hear, c_funloc, c_int, c_intptr_t, c_loc
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  external :: logger
  integer, intent(in) :: level
  integer, intent(out) :: ierr
  type(analysis_type), pointer :: analysis

  ierr = int(qsmpm_no_handle)
  call find(handle, analysis)
  if (.not. associated(analysis)) return
  analysis%logger => logger
  ierr = int(qsmpm_set_logger(analysis%pointer, c_funloc(hear), c_loc(analysis)))
  if (ierr == 0) ierr = int(qsmpm_set_verbosity(analysis%pointer, int(level, c_int)))
end subroutine qsmlog

!> Assigns a user-defined law to a material of the deck, between QSMOPN and QSMINI, with NSTATE state variables that
!> are zero at the start. YOUNG and SHEAR are the scales of its stiffness; ISYMM is nonzero if its tangent is always
!> symmetric.
!>     SUBROUTINE LAW(STRESS, STATE, DSTRAN, TANGNT, NSTATE, INFO, RINFO, ISTAT, MESSGE)
!> updates one point for one step; module qsmpm_f77_handles describes its arguments.
subroutine qsmmat(handle, name, law, nstate, isymm, young, shear, ierr)
  use qsmpm_c, only: qsmpm_model_options, qsmpm_set_material, qsmpm_no_handle
  use qsmpm_f77_handles, only: analysis_type, law_type, as_c, find, start, update, c_double, c_funloc, c_int, &
    c_intptr_t, c_loc
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: name
  external :: law
  integer, intent(in) :: nstate, isymm
  double precision, intent(in) :: young, shear
  integer, intent(out) :: ierr
  type(analysis_type), pointer :: analysis
  type(law_type), pointer :: own
  type(qsmpm_model_options) :: options

  ierr = int(qsmpm_no_handle)
  call find(handle, analysis)
  if (.not. associated(analysis)) return
  allocate (own)
  own%law => law
  own%states = nstate
  own%next => analysis%laws
  analysis%laws => own
  options%state_count = int(nstate, c_int)
  options%symmetric = int(isymm, c_int)
  options%stiffness_scale = real(young, c_double)
  options%shear_scale = real(shear, c_double)
  ierr = int(qsmpm_set_material(analysis%pointer, as_c(name), options, c_funloc(start), c_funloc(update), c_loc(own)))
end subroutine qsmmat

!> Returns whether the last stage has ended: IDONE is 1, otherwise 0.
subroutine qsmfin(handle, idone)
  use qsmpm_c, only: qsmpm_finished
  use qsmpm_f77_handles, only: pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(out) :: idone

  idone = int(qsmpm_finished(pointer_of(handle)))
end subroutine qsmfin

!> Builds the model of a deck that QSMOPN has read.
subroutine qsmini(handle, ierr)
  use qsmpm_c, only: qsmpm_initialise
  use qsmpm_f77_handles, only: pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(out) :: ierr

  ierr = int(qsmpm_initialise(pointer_of(handle)))
end subroutine qsmini

!> Sets the number of threads of the analysis.
subroutine qsmthr(handle, nthrds, ierr)
  use qsmpm_c, only: qsmpm_set_threads
  use qsmpm_f77_handles, only: pointer_of, c_int, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(in) :: nthrds
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_threads(pointer_of(handle), int(nthrds, c_int)))
end subroutine qsmthr

!> Starts to write results to a directory.
subroutine qsmrec(handle, path, ierr)
  use qsmpm_c, only: qsmpm_record
  use qsmpm_f77_handles, only: as_c, pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: path
  integer, intent(out) :: ierr

  ierr = int(qsmpm_record(pointer_of(handle), as_c(path)))
end subroutine qsmrec

!> Closes the result files.
subroutine qsmcls(handle, ierr)
  use qsmpm_c, only: qsmpm_finish_record
  use qsmpm_f77_handles, only: pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(out) :: ierr

  ierr = int(qsmpm_finish_record(pointer_of(handle)))
end subroutine qsmcls

!> Computes one accepted load step.
subroutine qsmadv(handle, ierr)
  use qsmpm_c, only: qsmpm_advance
  use qsmpm_f77_handles, only: pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(out) :: ierr

  ierr = int(qsmpm_advance(pointer_of(handle)))
end subroutine qsmadv

!> Steps to a load fraction of the current stage, or of the next stage when between stages.
subroutine qsmadt(handle, share, ierr)
  use qsmpm_c, only: qsmpm_advance_to
  use qsmpm_f77_handles, only: pointer_of, c_double, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  double precision, intent(in) :: share
  integer, intent(out) :: ierr

  ierr = int(qsmpm_advance_to(pointer_of(handle), real(share, c_double)))
end subroutine qsmadt

!> Steps to the end of the last stage.
subroutine qsmrun(handle, ierr)
  use qsmpm_c, only: qsmpm_run
  use qsmpm_f77_handles, only: pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(out) :: ierr

  ierr = int(qsmpm_run(pointer_of(handle)))
end subroutine qsmrun

!> Writes the state to a file.
subroutine qsmwrt(handle, path, ierr)
  use qsmpm_c, only: qsmpm_save
  use qsmpm_f77_handles, only: as_c, pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: path
  integer, intent(out) :: ierr

  ierr = int(qsmpm_save(pointer_of(handle), as_c(path)))
end subroutine qsmwrt

!> Reads a state that was written with the same deck and stages.
subroutine qsmred(handle, path, ierr)
  use qsmpm_c, only: qsmpm_load
  use qsmpm_f77_handles, only: as_c, pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: path
  integer, intent(out) :: ierr

  ierr = int(qsmpm_load(pointer_of(handle), as_c(path)))
end subroutine qsmred

!> Appends a stage with an initial number of load steps.
subroutine qsmstg(handle, name, nsteps, ierr)
  use qsmpm_c, only: qsmpm_add_stage
  use qsmpm_f77_handles, only: as_c, pointer_of, c_int, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: name
  integer, intent(in) :: nsteps
  integer, intent(out) :: ierr

  ierr = int(qsmpm_add_stage(pointer_of(handle), as_c(name), int(nsteps, c_int)))
end subroutine qsmstg

!> Ends the current stage at its current load.
subroutine qsmest(handle, ierr)
  use qsmpm_c, only: qsmpm_end_stage
  use qsmpm_f77_handles, only: pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(out) :: ierr

  ierr = int(qsmpm_end_stage(pointer_of(handle)))
end subroutine qsmest

!> Sets the load factor at the end of the next stage.
subroutine qsmldf(handle, factor, ierr)
  use qsmpm_c, only: qsmpm_set_load_factor
  use qsmpm_f77_handles, only: pointer_of, c_double, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  double precision, intent(in) :: factor
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_load_factor(pointer_of(handle), real(factor, c_double)))
end subroutine qsmldf

!> Sets the initial number of load steps of the next stage.
subroutine qsmstp(handle, nsteps, ierr)
  use qsmpm_c, only: qsmpm_set_steps
  use qsmpm_f77_handles, only: pointer_of, c_int, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(in) :: nsteps
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_steps(pointer_of(handle), int(nsteps, c_int)))
end subroutine qsmstp

!> Sets the duration of the next stage.
subroutine qsmtim(handle, time, ierr)
  use qsmpm_c, only: qsmpm_set_time
  use qsmpm_f77_handles, only: pointer_of, c_double, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  double precision, intent(in) :: time
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_time(pointer_of(handle), real(time, c_double)))
end subroutine qsmtim

!> Sets the time at the start of the next stage.
subroutine qsmtst(handle, time, ierr)
  use qsmpm_c, only: qsmpm_set_start_time
  use qsmpm_f77_handles, only: pointer_of, c_double, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  double precision, intent(in) :: time
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_start_time(pointer_of(handle), real(time, c_double)))
end subroutine qsmtst

!> Sets gravity at the end of the next stage.
subroutine qsmgrv(handle, gx, gy, gz, ierr)
  use qsmpm_c, only: qsmpm_set_gravity
  use qsmpm_f77_handles, only: pointer_of, c_double, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  double precision, intent(in) :: gx, gy, gz
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_gravity(pointer_of(handle), real([gx, gy, gz], c_double)))
end subroutine qsmgrv

!> Sets the dead traction on a surface at the end of the next stage.
subroutine qsmtrc(handle, surfac, tx, ty, tz, ierr)
  use qsmpm_c, only: qsmpm_set_traction
  use qsmpm_f77_handles, only: as_c, pointer_of, c_double, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: surfac
  double precision, intent(in) :: tx, ty, tz
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_traction(pointer_of(handle), as_c(surfac), real([tx, ty, tz], c_double)))
end subroutine qsmtrc

!> Sets the pressure on a surface at the end of the next stage.
subroutine qsmprs(handle, surfac, press, ierr)
  use qsmpm_c, only: qsmpm_set_pressure
  use qsmpm_f77_handles, only: as_c, pointer_of, c_double, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: surfac
  double precision, intent(in) :: press
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_pressure(pointer_of(handle), as_c(surfac), real(press, c_double)))
end subroutine qsmprs

!> Sets a water level at the end of the next stage, identified by its node set, surface or body.
subroutine qsmwtr(handle, name, level, ierr)
  use qsmpm_c, only: qsmpm_set_water_level
  use qsmpm_f77_handles, only: as_c, pointer_of, c_double, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: name
  double precision, intent(in) :: level
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_water_level(pointer_of(handle), as_c(name), real(level, c_double)))
end subroutine qsmwtr

!> Sets the displacement of a node set over the next stage; components are numbered from 1.
subroutine qsmdsp(handle, set, icomp, value, ierr)
  use qsmpm_c, only: qsmpm_set_displacement
  use qsmpm_f77_handles, only: as_c, pointer_of, c_double, c_int, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: set
  integer, intent(in) :: icomp
  double precision, intent(in) :: value
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_displacement(pointer_of(handle), as_c(set), int(icomp, c_int), real(value, c_double)))
end subroutine qsmdsp

!> Sets the fixed components (nonzero) of a node set from the next stage on; none releases it.
subroutine qsmfix(handle, set, ix, iy, iz, ierr)
  use qsmpm_c, only: qsmpm_set_fixity
  use qsmpm_f77_handles, only: as_c, pointer_of, c_int, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: set
  integer, intent(in) :: ix, iy, iz
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_fixity(pointer_of(handle), as_c(set), int([ix, iy, iz], c_int)))
end subroutine qsmfix

!> Adds materials and phases to the scene: N lines of a deck with *MATERIAL and *PHASE blocks.
subroutine qsmadd(handle, cards, n, ierr)
  use qsmpm_c, only: qsmpm_add_cards
  use qsmpm_f77_handles, only: as_c, pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(in) :: n
  character(len=*), intent(in) :: cards(n)
  integer, intent(out) :: ierr
  character(len=:), allocatable :: text
  integer :: i

  text = ''
  do i = 1, n
    text = text//trim(cards(i))//achar(10)
  end do
  ierr = int(qsmpm_add_cards(pointer_of(handle), as_c(text)))
end subroutine qsmadd

!> Copies values by name to an array of N numbers; on return N is the number of values.
subroutine qsmget(handle, name, values, n, ierr)
  use qsmpm_c, only: qsmpm_count, qsmpm_get
  use qsmpm_f77_handles, only: as_c, pointer_of, c_int, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: name
  double precision, intent(inout) :: values(*)
  integer, intent(inout) :: n
  integer, intent(out) :: ierr
  integer(c_int) :: number

  ierr = int(qsmpm_count(pointer_of(handle), as_c(name), number))
  if (ierr == 0 .and. number > n) ierr = 1
  if (ierr == 0) ierr = int(qsmpm_get(pointer_of(handle), as_c(name), values, number))
  n = int(number)
end subroutine qsmget

!> Sets values by name: N numbers for point_stress, point_state or point_force.
subroutine qsmput(handle, name, values, n, ierr)
  use qsmpm_c, only: qsmpm_set
  use qsmpm_f77_handles, only: as_c, pointer_of, c_int, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: name
  integer, intent(in) :: n
  double precision, intent(in) :: values(n)
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set(pointer_of(handle), as_c(name), values, int(n, c_int)))
end subroutine qsmput

!> Returns the name of item NUMBER (from 1) of a kind: value, history, stage, surface, set, material or body; LENGTH is
!> -1 if there is none.
subroutine qsmnam(handle, kind, number, name, length)
  use qsmpm_c, only: qsmpm_name
  use qsmpm_f77_handles, only: as_c, as_text, pointer_of, c_char, c_int, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: kind
  integer, intent(in) :: number
  character(len=*), intent(out) :: name
  integer, intent(out) :: length
  character(kind=c_char) :: buffer(len(name) + 1)

  length = int(qsmpm_name(pointer_of(handle), as_c(kind), int(number, c_int), buffer, int(size(buffer), c_int)))
  call as_text(buffer, length, name)
end subroutine qsmnam

!> Stores a copy of the state in memory (ISAVE = 1) or restores it (ISAVE = 0).
subroutine qsmsav(handle, isave, ierr)
  use qsmpm_c, only: qsmpm_checkpoint, qsmpm_restore_checkpoint
  use qsmpm_f77_handles, only: pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(in) :: isave
  integer, intent(out) :: ierr

  if (isave /= 0) then
    ierr = int(qsmpm_checkpoint(pointer_of(handle)))
  else
    ierr = int(qsmpm_restore_checkpoint(pointer_of(handle)))
  end if
end subroutine qsmsav

!> Returns name, version and build options of the library.
subroutine qsmver(text)
  use qsmpm_c, only: qsmpm_version
  use qsmpm_f77_handles, only: as_text, c_char, c_int
  implicit none
  character(len=*), intent(out) :: text
  character(kind=c_char) :: buffer(len(text) + 1)
  integer :: length

  length = int(qsmpm_version(buffer, int(size(buffer), c_int)))
  call as_text(buffer, length, text)
end subroutine qsmver
