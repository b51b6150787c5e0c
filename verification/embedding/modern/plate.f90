!> A Fortran program that pushes a rigid plate on the ground, then loads it step by step, and reads its place and force.
program plate
  use qsmpm, only: wp, problem_type, simulation_type, error_type, get_values
  implicit none
  character(len=1), parameter :: nl = new_line('a')
  type(problem_type) :: problem
  type(simulation_type) :: run
  type(error_type), allocatable :: error
  !> Place of the plate, and the force of the ground on it.
  real(wp) :: found(2)

  call problem%read('plate.inp', error)
  if (.not. allocated(error)) call run%create(problem, error)
  if (.not. allocated(error)) call step_through('MOVED')
  if (.not. allocated(error)) call run%add_cards('*PHASE, NAME=load'//nl//'*LOAD, BODY=plate, COMPONENT=Y'//nl// &
    '-40'//nl//'*CONTROLS, STEPS=2, TOLERANCE=1e-8'//nl//'*END PHASE'//nl, error)
  if (.not. allocated(error)) call step_through('LOADED')
  if (allocated(error)) then
    write (*, '(a)') 'failed: '//error%message
    stop 1
  end if
  call run%destroy()

contains

  !> Take the steps that there are.
  subroutine step_through(word)
    character(len=*), intent(in) :: word

    do while (.not. run%finished())
      call run%advance(error)
      if (.not. allocated(error)) call get_values(run, 'histories', found, error)
      if (allocated(error)) return
      write (*, '(a,2es23.14)') word, found
    end do
  end subroutine step_through
end program plate
