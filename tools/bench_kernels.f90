!> Time the constitutive laws: nanoseconds of CPU time a point, one thread.
!>
!>     cmake --build build --target bench_kernels && build/bench_kernels [points a batch [row]]
!>
!> Batches of 36 points unless told otherwise (a cell of 6 by 6 points): points of an elastic material,
!> points of a Mohr-Coulomb material that stay inside the strength, points that all yield. One row a law
!> and dimension, one column for stress only, stress with consistent tangent, stress with elastic tangent.
!> The best of several runs is printed. `row` is the number of the one row to run, for a profile. The last rows
!> are an elastic UMAT and UDSM of verification/plugins: what a call through a door costs.
program bench_kernels
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type, batch_type, tangent_none, tangent_consistent, tangent_elastic, status_ok
  use qsmpm_law_factory, only: kinematics_jaumann, kinematics_logarithmic, rate_midpoint, rate_paper
  use qsmpm_material_parameters, only: material_parameters_type
  use soil_trials, only: clay_parameters, sand_parameters, make_clay, make_sand, pressed_batch
  use law_trials, only: elastic, strong, make_law, random_batch
  use plugin_paths, only: plugin
  use qsmpm_error, only: error_type
  use qsmpm_user_material, only: user_material_type, interface_umat, interface_udsm
  use qsmpm_user_material_law, only: new_user_law
  implicit none

  character(len=*), parameter :: names(3) = [character(len=16) :: 'logarithmic', 'Jaumann midpoint', &
    'Jaumann paper']
  integer, parameter :: kinematics(3) = [kinematics_logarithmic, kinematics_jaumann, kinematics_jaumann]
  integer, parameter :: rates(3) = [rate_midpoint, rate_midpoint, rate_paper]
  character(len=16) :: word
  class(law_type), allocatable :: subject
  integer :: points, law, dimension, row, only

  points = 36
  row = 0
  only = 0
  if (command_argument_count() > 0) then
    call get_command_argument(1, word)
    read (word, *) points
  end if
  if (command_argument_count() > 1) then
    call get_command_argument(2, word)
    read (word, *) only
  end if
  write (*, '(a)') 'law               dim  material        yield [%]      none  consistent   elastic  [ns a point]'
  do law = 1, size(names)
    do dimension = 2, 3
      call bench('elastic', elastic(200.0_wp, 0.33_wp), 0.05_wp, 0.0_wp)
      call bench('inside', inside(), 0.05_wp, 0.0_wp)
      call bench('yielding', strong(5.0_wp, -1.0_wp), 0.2_wp, 1.0_wp)
    end do
  end do
  do law = 1, 2
    do dimension = 2, 3
      call make_clay(clay_parameters(), dimension, law == 1, subject)
      call bench_soil('clay inside', 2.0e-5_wp, 0.2_wp, 2.0_wp)
      call bench_soil('clay yields', 5.0e-3_wp, 20.0_wp, 1.0_wp)
      call make_sand(sand_parameters(), dimension, law == 1, subject)
      call bench_soil('sand inside', 2.0e-6_wp, 0.2_wp, 2.0_wp)
      call bench_soil('sand yields', 1.0e-3_wp, 20.0_wp, 1.0_wp)
    end do
  end do

  do dimension = 2, 3
    call bench_adapter('UMAT', interface_umat, 'umat', 0)
    call bench_adapter('UDSM', interface_udsm, 'user_mod', -1)
  end do

contains

  !> A strength that nothing reaches.
  function inside() result(p)
    type(material_parameters_type) :: p

    p = strong(5.0_wp, -1.0_wp)
    p%cohesion = 1.0e4_wp
  end function inside

  !> Time a model behind a door.
  subroutine bench_adapter(name, interface, symbol, states)
    !> Name of the door.
    character(len=*), intent(in) :: name
    !> Which door it is, its procedure, and its state variables.
    integer, intent(in) :: interface
    character(len=*), intent(in) :: symbol
    integer, intent(in) :: states
    type(user_material_type) :: user
    class(law_type), allocatable :: subject
    type(error_type), allocatable :: error
    type(batch_type) :: batch

    row = row + 1
    if (only > 0 .and. row /= only) return
    user%interface = interface
    user%library = plugin(merge('elastic_umat', 'elastic_udsm', interface == interface_umat))
    user%symbol = symbol
    user%states = states
    allocate (user%constants(2), user%start(0))
    user%constants(1) = 200.0_wp
    user%constants(2) = 0.33_wp
    call new_user_law(user, name, 0.0_wp, 0.0_wp, spread(0.0_wp, 1, 6), dimension, subject, error)
    if (allocated(error)) error stop 'the plug-ins are not built'
    call random_batch(subject, points, 0.05_wp, 0.0_wp, batch)
    write (*, '(a16, i5, 2x, a12, f12.0, 3f12.1)') name, dimension, 'elastic', 0.0_wp, &
      time(subject, batch, tangent_none), time(subject, batch, tangent_consistent), &
      time(subject, batch, tangent_elastic)
  end subroutine bench_adapter

  !> Time the three tangents of one law, dimension and material.
  subroutine bench(name, p, spread, stress)
    !> Name of the material.
    character(len=*), intent(in) :: name
    !> Parameters.
    type(material_parameters_type), intent(in) :: p
    !> Largest deviation of gradients from the unit tensor, of stresses from nothing.
    real(wp), intent(in) :: spread, stress
    type(batch_type) :: batch

    row = row + 1
    if (only > 0 .and. row /= only) return
    call make_law(p, dimension, kinematics(law), rates(law), subject)
    call random_batch(subject, points, spread, stress, batch)
    call measure(name, batch)
  end subroutine bench

  !> Time the three tangents of a hardening soil.
  subroutine bench_soil(name, spread, scatter, past)
    !> Name of the material.
    character(len=*), intent(in) :: name
    !> Largest deviation of gradients from the unit tensor, of stresses from 100 kPa.
    real(wp), intent(in) :: spread, scatter
    !> Factor on the preconsolidation pressure.
    real(wp), intent(in) :: past
    type(batch_type) :: batch

    row = row + 1
    if (only > 0 .and. row /= only) return
    call pressed_batch(subject, points, spread, scatter, 100.0_wp, batch)
    batch%state_start(subject%state_count, :) = past*batch%state_start(subject%state_count, :)
    if (past > 1.0_wp .and. subject%state_count > 1) batch%state_start(1, :) = 0.01_wp
    call measure(name, batch)
  end subroutine bench_soil

  !> Time the three tangents of a batch and write the row.
  subroutine measure(name, batch)
    !> Name of the material.
    character(len=*), intent(in) :: name
    !> The points.
    type(batch_type), intent(inout) :: batch
    real(wp) :: share

    call subject%update(batch, tangent_consistent)
    if (any(batch%status(:points) /= status_ok)) error stop 'a point could not be updated'
    share = 100.0_wp*sum(batch%plastic(:points))/points
    write (*, '(a16, i5, 2x, a12, f12.0, 3f12.1)') names(law), dimension, name, share, &
      time(subject, batch, tangent_none), time(subject, batch, tangent_consistent), &
      time(subject, batch, tangent_elastic)
  end subroutine measure

  !> Nanoseconds a point: the best of 15 runs of some milliseconds.
  real(wp) function time(subject, batch, tangent)
    !> The law.
    class(law_type), intent(in) :: subject
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> Which tangent.
    integer, intent(in) :: tangent
    real(wp) :: from, to
    integer :: run, repeat, repeats

    repeats = max(1, 10000/points)
    time = huge(time)
    do run = 1, 15
      call cpu_time(from)
      do repeat = 1, repeats
        call subject%update(batch, tangent)
      end do
      call cpu_time(to)
      time = min(time, 1.0e9_wp*(to - from)/(real(repeats, wp)*points))
    end do
  end function time
end program bench_kernels
