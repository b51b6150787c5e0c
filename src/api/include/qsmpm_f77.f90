!> For programs of the old kind: external subroutines with integers, reals and strings as arguments, no modules and
!> no pointers. Compile qsmpm_c.f90 and this file with the program, with the program's compiler, and link the library.
!>
!> A handle is an INTEGER*8, set by QSMNEW or QSMOPN, given back by QSMEND. IERR is the status of qsmpm.h; QSMERR has
!> the sentence. Names and paths may have trailing blanks.
module qsmpm_f77_handles
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_f_pointer, c_funloc, c_int, c_intptr_t, c_loc, &
    c_null_char, c_null_ptr, c_ptr
  use qsmpm_c, only: qsmpm_increment, qsmpm_response
  implicit none
  private

  public :: analysis_type, law_type, find, pointer_of, number_of, as_c, as_text, start, update, hear
  !> Kinds and addresses of C, for the subroutines below.
  public :: c_char, c_double, c_funloc, c_int, c_intptr_t, c_loc

  abstract interface
    !> A law of the program: one step of one point. Stress and state of the start in, of the end out; six components
    !> 11, 22, 33, 12, 13, 23, tension positive, shear gamma.
    subroutine law_interface(stress, state, dstran, tangnt, nstate, info, rinfo, istat, messge)
      double precision, intent(inout) :: stress(6), state(*)
      !> Strain of the step.
      double precision, intent(in) :: dstran(6)
      !> d stress(i) / d strain(j).
      double precision, intent(inout) :: tangnt(6, 6)
      !> State variables; phase, step, point, cell, 1 where the tangent is read, 1 where it may be the elastic one.
      integer, intent(in) :: nstate, info(6)
      !> Share of the phase at the start and of the step, time at the start and of the step, place (3), cell size,
      !> share of the step that is to be tried with ISTAT = 1.
      double precision, intent(inout) :: rinfo(9)
      !> 0 done, 1 the step is too long, 2 failed, 3 failed and a shorter step does not help.
      integer, intent(inout) :: istat
      !> Why, where ISTAT is not 0.
      character(len=*), intent(inout) :: messge
    end subroutine law_interface

    !> Hear a sentence.
    subroutine logger_interface(text)
      character(len=*), intent(in) :: text
    end subroutine logger_interface
  end interface

  !> What a material's law is.
  type :: law_type
    procedure(law_interface), pointer, nopass :: law => null()
    integer :: states = 0
    type(law_type), pointer :: next => null()
  end type law_type

  !> What a handle stands for: the one of the library, and what its callbacks are given.
  type :: analysis_type
    type(c_ptr) :: pointer = c_null_ptr
    type(law_type), pointer :: laws => null()
    procedure(logger_interface), pointer, nopass :: logger => null()
  end type analysis_type

contains

  !> What a handle stands for, null for 0.
  subroutine find(number, analysis)
    integer(c_intptr_t), intent(in) :: number
    type(analysis_type), pointer, intent(out) :: analysis
    type(c_ptr) :: address

    nullify (analysis)
    if (number == 0_c_intptr_t) return
    address = transfer(number, address)
    call c_f_pointer(address, analysis)
  end subroutine find

  !> The handle as the library knows it.
  type(c_ptr) function pointer_of(number) result(pointer)
    integer(c_intptr_t), intent(in) :: number
    type(analysis_type), pointer :: analysis

    pointer = c_null_ptr
    call find(number, analysis)
    if (associated(analysis)) pointer = analysis%pointer
  end function pointer_of

  !> The handle of an analysis.
  integer(c_intptr_t) function number_of(analysis) result(number)
    type(analysis_type), pointer, intent(in) :: analysis

    number = transfer(c_loc(analysis), number)
  end function number_of

  !> The text without trailing blanks, ended as C wants it.
  pure function as_c(text) result(string)
    character(len=*), intent(in) :: text
    character(len=len_trim(text) + 1) :: string

    string = trim(text)//c_null_char
  end function as_c

  !> The text of a buffer of C, with trailing blanks.
  subroutine as_text(buffer, length, text)
    character(kind=c_char), intent(in) :: buffer(*)
    !> Of the text in the buffer.
    integer, intent(in) :: length
    character(len=*), intent(out) :: text
    integer :: i

    text = ' '
    do i = 1, min(length, len(text))
      text(i:i) = buffer(i)
    end do
  end subroutine as_text

  !> States of the program's laws start at zero.
  subroutine start(user, stress, state) bind(c)
    type(c_ptr), value :: user
    real(c_double), intent(in) :: stress(6)
    real(c_double), intent(inout) :: state(*)
    type(law_type), pointer :: own

    call c_f_pointer(user, own)
    state(:own%states) = 0.0_c_double
  end subroutine start

  !> Call a law of the program.
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

  !> Tell the program's procedure a sentence.
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

!> A handle for the deck in a file; the model is made.
subroutine qsmnew(handle, deck, ierr)
  use, intrinsic :: iso_c_binding, only: c_intptr_t
  implicit none
  integer(c_intptr_t), intent(out) :: handle
  character(len=*), intent(in) :: deck
  integer, intent(out) :: ierr

  call qsmopn(handle, deck, ierr)
  if (ierr == 0) call qsmini(handle, ierr)
end subroutine qsmnew

!> A handle for the deck in a file, whose model is not made yet: materials may be given laws (QSMMAT), then QSMINI.
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

!> Give a handle back.
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

!> Sentence of the last failure.
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

!> What the reader of the deck had to say, its lines ended by CHAR(10); LENGTH is the length of all of it.
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

!> A subroutine LOGGER(TEXT) that hears sentences (LEVEL 1), a line for every step too (LEVEL 2), nothing (LEVEL 0).
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

!> A law of the program for a material of the deck, between QSMOPN and QSMINI, with NSTATE state variables that start at
!> zero. YOUNG and SHEAR are the scales of its stiffness; ISYMM is not 0 where its tangent is symmetric for every state.
!>     SUBROUTINE LAW(STRESS, STATE, DSTRAN, TANGNT, NSTATE, INFO, RINFO, ISTAT, MESSGE)
!> is one step of one point; module qsmpm_f77_handles says what each argument is.
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

!> Whether the last stage has ended: IDONE is 1, else 0.
subroutine qsmfin(handle, idone)
  use qsmpm_c, only: qsmpm_finished
  use qsmpm_f77_handles, only: pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(out) :: idone

  idone = int(qsmpm_finished(pointer_of(handle)))
end subroutine qsmfin

!> Make the model of a deck that QSMOPN has read.
subroutine qsmini(handle, ierr)
  use qsmpm_c, only: qsmpm_initialise
  use qsmpm_f77_handles, only: pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(out) :: ierr

  ierr = int(qsmpm_initialise(pointer_of(handle)))
end subroutine qsmini

!> Threads that the analysis may use.
subroutine qsmthr(handle, nthrds, ierr)
  use qsmpm_c, only: qsmpm_set_threads
  use qsmpm_f77_handles, only: pointer_of, c_int, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(in) :: nthrds
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_threads(pointer_of(handle), int(nthrds, c_int)))
end subroutine qsmthr

!> Write results to a directory.
subroutine qsmrec(handle, path, ierr)
  use qsmpm_c, only: qsmpm_record
  use qsmpm_f77_handles, only: as_c, pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: path
  integer, intent(out) :: ierr

  ierr = int(qsmpm_record(pointer_of(handle), as_c(path)))
end subroutine qsmrec

!> Close the results that are written.
subroutine qsmcls(handle, ierr)
  use qsmpm_c, only: qsmpm_finish_record
  use qsmpm_f77_handles, only: pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(out) :: ierr

  ierr = int(qsmpm_finish_record(pointer_of(handle)))
end subroutine qsmcls

!> One accepted load step.
subroutine qsmadv(handle, ierr)
  use qsmpm_c, only: qsmpm_advance
  use qsmpm_f77_handles, only: pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(out) :: ierr

  ierr = int(qsmpm_advance(pointer_of(handle)))
end subroutine qsmadv

!> Step to a share of the present stage, of the coming one between stages.
subroutine qsmadt(handle, share, ierr)
  use qsmpm_c, only: qsmpm_advance_to
  use qsmpm_f77_handles, only: pointer_of, c_double, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  double precision, intent(in) :: share
  integer, intent(out) :: ierr

  ierr = int(qsmpm_advance_to(pointer_of(handle), real(share, c_double)))
end subroutine qsmadt

!> All stages that are to come.
subroutine qsmrun(handle, ierr)
  use qsmpm_c, only: qsmpm_run
  use qsmpm_f77_handles, only: pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(out) :: ierr

  ierr = int(qsmpm_run(pointer_of(handle)))
end subroutine qsmrun

!> Write the state to a file.
subroutine qsmwrt(handle, path, ierr)
  use qsmpm_c, only: qsmpm_save
  use qsmpm_f77_handles, only: as_c, pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: path
  integer, intent(out) :: ierr

  ierr = int(qsmpm_save(pointer_of(handle), as_c(path)))
end subroutine qsmwrt

!> Read a state back that was written with the same deck and stages.
subroutine qsmred(handle, path, ierr)
  use qsmpm_c, only: qsmpm_load
  use qsmpm_f77_handles, only: as_c, pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  character(len=*), intent(in) :: path
  integer, intent(out) :: ierr

  ierr = int(qsmpm_load(pointer_of(handle), as_c(path)))
end subroutine qsmred

!> A new stage of some load steps.
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

!> End the present stage where it stands.
subroutine qsmest(handle, ierr)
  use qsmpm_c, only: qsmpm_end_stage
  use qsmpm_f77_handles, only: pointer_of, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(out) :: ierr

  ierr = int(qsmpm_end_stage(pointer_of(handle)))
end subroutine qsmest

!> Load factor at the end of the coming stage.
subroutine qsmldf(handle, factor, ierr)
  use qsmpm_c, only: qsmpm_set_load_factor
  use qsmpm_f77_handles, only: pointer_of, c_double, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  double precision, intent(in) :: factor
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_load_factor(pointer_of(handle), real(factor, c_double)))
end subroutine qsmldf

!> Load steps that the coming stage is first cut into.
subroutine qsmstp(handle, nsteps, ierr)
  use qsmpm_c, only: qsmpm_set_steps
  use qsmpm_f77_handles, only: pointer_of, c_int, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  integer, intent(in) :: nsteps
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_steps(pointer_of(handle), int(nsteps, c_int)))
end subroutine qsmstp

!> How long the coming stage lasts.
subroutine qsmtim(handle, time, ierr)
  use qsmpm_c, only: qsmpm_set_time
  use qsmpm_f77_handles, only: pointer_of, c_double, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  double precision, intent(in) :: time
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_time(pointer_of(handle), real(time, c_double)))
end subroutine qsmtim

!> Time at the start of the coming stage.
subroutine qsmtst(handle, time, ierr)
  use qsmpm_c, only: qsmpm_set_start_time
  use qsmpm_f77_handles, only: pointer_of, c_double, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  double precision, intent(in) :: time
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_start_time(pointer_of(handle), real(time, c_double)))
end subroutine qsmtst

!> Gravity at the end of the coming stage.
subroutine qsmgrv(handle, gx, gy, gz, ierr)
  use qsmpm_c, only: qsmpm_set_gravity
  use qsmpm_f77_handles, only: pointer_of, c_double, c_intptr_t
  implicit none
  integer(c_intptr_t), intent(in) :: handle
  double precision, intent(in) :: gx, gy, gz
  integer, intent(out) :: ierr

  ierr = int(qsmpm_set_gravity(pointer_of(handle), real([gx, gy, gz], c_double)))
end subroutine qsmgrv

!> Traction on a surface at the end of the coming stage.
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

!> Pressure on a surface at the end of the coming stage.
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

!> Level of water at the end of the coming stage, by the set of its row or its body.
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

!> Displacement of a node set over the coming stage; component from 1.
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

!> Components of a node set that are held (not 0) from the coming stage on; none frees it.
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

!> Add materials and phases to the scene: N lines of a deck, *MATERIAL and *PHASE with what belongs to them.
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

!> Values by name into an array of N numbers; N is how many there are on return.
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

!> Set values by name: N numbers for point_stress, point_state or point_force.
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

!> Name of number NUMBER (from 1) of a kind: value, history, stage, surface, set, material or body; LENGTH is -1 where
!> there is none.
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

!> Copy the state in memory (ISAVE = 1), or put the copy back (ISAVE = 0).
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

!> Name, version and make of the library.
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
