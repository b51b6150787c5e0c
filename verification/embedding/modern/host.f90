!> A Fortran program that steps an analysis with a soil model of its own, beside one of the library's, step about.
program host
  use qsmpm, only: wp, problem_type, simulation_type, error_type, get_values, program_name
  use own_law, only: elastic_type
  implicit none
  type(problem_type) :: problem, plain
  type(simulation_type) :: own, theirs
  type(elastic_type) :: model
  type(error_type), allocatable :: error
  real(wp) :: settlement(2)
  integer :: steps

  write (*, '(a)') program_name()
  model%young = 1000.0_wp
  model%poisson = 0.3_wp
  model%symmetric = .true.
  model%stiffness_scale = model%young
  model%shear_scale = model%young/2.6_wp
  call problem%read('block.inp', error)
  if (.not. allocated(error)) call problem%set_material('soil', model, error)
  if (.not. allocated(error)) call own%create(problem, error)
  if (.not. allocated(error)) call plain%read('block.inp', error)
  if (.not. allocated(error)) call theirs%create(plain, error)
  steps = 0
  do while (.not. (allocated(error) .or. own%finished()))
    call own%advance(error)
    if (.not. allocated(error)) call theirs%advance(error)
    if (.not. allocated(error)) steps = steps + 1
  end do
  if (.not. allocated(error)) call get_values(own, 'histories', settlement(1:1), error)
  if (.not. allocated(error)) call get_values(theirs, 'histories', settlement(2:2), error)
  if (allocated(error)) then
    write (*, '(a)') 'failed: '//error%message
    stop 1
  end if
  write (*, '(a,i0,2(a,es22.14))') 'steps ', steps, ' own ', settlement(1), ' theirs ', settlement(2)
  call own%destroy()
  call theirs%destroy()
end program host
