!> The doors to UMAT and UDSM: every argument by models that write theirs down, the order of components, the tangent
!> by differences, the frame of the state, and faults planted in doors and models, each of which must be seen.
module test_user_adapters
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use, intrinsic :: iso_c_binding, only: c_double, c_int, c_char, c_funptr, c_f_procpointer
  use law_trials, only: random_batch, difference_error
  use plugin_paths, only: plugin
  use qsmpm_user_adapter, only: ask_stiffness
  use qsmpm_error, only: error_type, error_user_material
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: batch_type, law_type, status_ok, status_cut, status_failed, status_unrecoverable, &
    tangent_consistent, tangent_none
  use qsmpm_law_factory, only: new_law, kinematics_jaumann, rate_midpoint_cauchy
  use qsmpm_material_parameters, only: material_parameters_type
  use qsmpm_plugin, only: load_procedure
  use qsmpm_soil_model, only: soil_increment_type, soil_response_type
  use qsmpm_soil_model_law, only: soil_model_law_type, make_soil_model_law
  use qsmpm_udsm, only: udsm_type, make_udsm
  use qsmpm_tensor, only: identity, pack_gradient
  use qsmpm_umat, only: umat_type, make_umat
  use qsmpm_user_material, only: user_material_type, put_start, interface_umat, interface_udsm, &
    model_tangent_consistent, model_tangent_elastic, model_tangent_numerical
  use testing, only: tests_type
  implicit none
  private

  public :: collect_user_adapters

  abstract interface
    !> What the recording library has written down.
    subroutine recall_interface(reals, integers, name) bind(c)
      import :: c_double, c_int, c_char
      real(c_double), intent(out) :: reals(400)
      integer(c_int), intent(out) :: integers(100)
      character(kind=c_char), intent(out) :: name(80)
    end subroutine recall_interface
  end interface

  real(wp), parameter :: no_stress(6) = 0.0_wp
  real(wp), parameter :: stress0(6) = [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp, 6.0_wp]

contains

  subroutine collect_user_adapters(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('doors')
    call check_umat_slots(tests)
    call check_udsm_slots(tests)
    call check_undrained(tests)
    call check_tangents(tests)
    call check_as_built_in(tests)
    call check_rest(tests)
    call check_changes_at_rest(tests)
    call check_jumps(tests)
    call check_own_helpers(tests)
    call check_faulty_models(tests)
    call check_planted(tests)
    call check_loading(tests)
    call check_traits(tests)
    call check_missing_constants(tests)
    call check_levels(tests)
    call check_sdvini(tests)
    call check_by_gradient(tests)
  end subroutine collect_user_adapters

  !> What a deck would say.
  function user_of(interface, library, constants, states) result(user)
    integer, intent(in) :: interface
    !> Name of the plug-in.
    character(len=*), intent(in) :: library
    real(wp), intent(in) :: constants(:)
    integer, intent(in) :: states
    type(user_material_type) :: user
    integer :: i

    user%given = .true.
    user%interface = interface
    user%library = plugin(library)
    user%symbol = trim(merge('user_mod', 'umat    ', interface == interface_udsm))
    user%states = states
    allocate (user%constants(size(constants)))
    do i = 1, size(constants)
      user%constants(i) = constants(i)
    end do
  end function user_of

  !> An increment in which every number is another one.
  function distinct_increment() result(increment)
    type(soil_increment_type) :: increment
    integer :: i

    do i = 1, 6
      increment%strain(i) = 1.0e-3_wp*i
      increment%strain_start(i) = 1.0e-2_wp*i
    end do
    increment%rotation = reshape([(0.1_wp*i, i=1, 9)], [3, 3])
    increment%gradient_start = reshape([(10.0_wp + i, i=1, 9)], [3, 3])
    increment%gradient_end = reshape([(20.0_wp + i, i=1, 9)], [3, 3])
    increment%step_info%phase = 3
    increment%step_info%step = 17
    increment%step_info%step_of_phase = 9
    increment%step_info%start = 0.25_wp
    increment%step_info%duration = 0.125_wp
    increment%step_info%phase_start = 100.0_wp
    increment%step_info%phase_time = 8.0_wp
    increment%point = 42
    increment%cell = 24
    increment%place = [1.5_wp, 2.5_wp, 3.5_wp]
    increment%cell_size = 0.75_wp
    increment%water = [50.0_wp, 20.0_wp, 0.75_wp]
  end function distinct_increment

  !> What the recorder has written down.
  subroutine recalled(reals, integers, name)
    real(wp), intent(out) :: reals(400)
    integer, intent(out) :: integers(100)
    character(len=80), intent(out) :: name
    procedure(recall_interface), pointer :: recall
    type(c_funptr) :: address
    type(error_type), allocatable :: error
    integer(c_int) :: whole(100)
    character(kind=c_char) :: letters(80)
    integer :: i

    call load_procedure(plugin('recorder'), 'recall', address, error)
    call c_f_procpointer(address, recall)
    call recall(reals, whole, letters)
    integers = whole
    do i = 1, 80
      name(i:i) = letters(i)
    end do
  end subroutine recalled

  !> The 37 arguments of a UMAT. They are copied, so they are equal to the last bit.
  subroutine check_umat_slots(tests)
    type(tests_type), intent(inout) :: tests
    type(umat_type) :: model
    type(error_type), allocatable :: error
    type(soil_increment_type) :: increment
    type(soil_response_type) :: response
    real(wp) :: stress(6), state(3), r(400)
    integer :: n(100), i
    character(len=80) :: name

    call make_umat(user_of(interface_umat, 'recorder', [31.0_wp, 32.0_wp, 33.0_wp], 3), 'loose sand', model, error)
    call tests%check('the recording UMAT is loaded', .not. allocated(error))
    increment = distinct_increment()
    stress = stress0
    state = [7.0_wp, 8.0_wp, 9.0_wp]
    call model%update(increment, stress, state, response)
    call recalled(r, n, name)
    call tests%check('STRESS', same(r(1:6), stress0))
    call tests%check('STATEV', same(r(11:13), [7.0_wp, 8.0_wp, 9.0_wp]))
    call tests%check('SSE, SPD, SCD, RPL, DRPLDT, DDSDDE are zero', same(r(21:26), spread(0.0_wp, 1, 6)))
    call tests%check('STRAN', same(r(31:36), increment%strain_start))
    call tests%check('DSTRAN', same(r(41:46), increment%strain))
    call tests%check('TIME, DTIME, TEMP, DTEMP, PREDEF, DPRED', same(r(51:57), &
      [2.0_wp, 102.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 50.0_wp, 0.0_wp]))
    call tests%check('PREDEF(2) is how far the pores are filled', same(r(58:58), [0.75_wp]))
    call tests%check('PROPS', same(r(61:63), [31.0_wp, 32.0_wp, 33.0_wp]))
    call tests%check('COORDS', same(r(71:73), increment%place))
    call tests%check('PNEWDT, CELENT', same(r(74:75), [1.0_wp, 0.75_wp]))
    call tests%check('DROT column by column', same(r(81:89), reshape(increment%rotation, [9])))
    call tests%check('DFGRD0', same(r(91:99), reshape(increment%gradient_start, [9])))
    call tests%check('DFGRD1', same(r(101:109), reshape(increment%gradient_end, [9])))
    call tests%check('DDSDDT, DRPLDE are zero', same(r(111:112), [0.0_wp, 0.0_wp]))
    call tests%check('NDI, NSHR, NTENS, NSTATV, NPROPS', all(n(1:5) == [3, 3, 6, 3, 3]))
    call tests%check('NOEL, NPT, LAYER, KSPT', all(n(6:9) == [24, 42, 1, 1]))
    call tests%check('four numbers behind KSTEP, and KINC', all(n(10:14) == [3, 1, 1, 0, 9]))
    call tests%check('CMNAME in capitals, 80 long', name == 'LOOSE SAND' .and. n(15) == 80)
    call tests%check('the stress comes back', same(stress, stress0 + [(100.0_wp*i, i=1, 6)]))
    call tests%check('the state comes back', same(state, [8.0_wp, 9.0_wp, 10.0_wp]))
    call tests%check('DDSDDE comes back untransposed', abs(response%tangent(2, 5) - 25.0_wp) <= 0.0_wp .and. &
      abs(response%tangent(5, 2) - 52.0_wp) <= 0.0_wp)
    call check_four(tests, increment)
  end subroutine check_umat_slots

  !> NTENS = 4, and a step at held load.
  subroutine check_four(tests, increment)
    type(tests_type), intent(inout) :: tests
    type(soil_increment_type), intent(inout) :: increment
    type(user_material_type) :: user
    type(umat_type) :: model
    type(error_type), allocatable :: error
    type(soil_response_type) :: response
    real(wp) :: stress(6), state(0), r(400)
    integer :: n(100)
    character(len=80) :: name

    user = user_of(interface_umat, 'recorder', [1.0_wp], 0)
    user%components = 4
    call make_umat(user, 'clay', model, error)
    increment%step_info%duration = 0.0_wp
    stress = stress0
    call model%update(increment, stress, state, response)
    call recalled(r, n, name)
    call tests%check('four components: 3, 1, 4', all(n(1:3) == [3, 1, 4]))
    call tests%check('four components: the others are left', same(stress(5:6), stress0(5:6)))
    call tests%check('four components: DDSDDE is 4 by 4', abs(response%tangent(4, 1) - 41.0_wp) <= 0.0_wp .and. &
      abs(response%tangent(5, 1)) <= 0.0_wp)
    call tests%check('DTIME is positive at held load', r(53) > 0.0_wp)
  end subroutine check_four

  !> Whether two lists are the same numbers.
  pure logical function same(a, b)
    real(wp), intent(in) :: a(:), b(:)

    same = all(abs(a - b) <= 0.0_wp)
  end function same

  !> The 31 arguments of a UDSM.
  subroutine check_udsm_slots(tests)
    type(tests_type), intent(inout) :: tests
    type(udsm_type) :: model
    type(error_type), allocatable :: error
    type(soil_increment_type) :: increment
    type(soil_response_type) :: response
    real(wp) :: stress(6), state(2), r(400)
    integer :: n(100), i
    character(len=80) :: name
    integer, parameter :: swapped(6) = [1, 2, 3, 4, 6, 5]

    call make_udsm(user_of(interface_udsm, 'recorder', [31.0_wp, 32.0_wp], -1), 'clay', model, error)
    call tests%check('the recording UDSM is loaded', .not. allocated(error))
    call tests%check('task 4 tells the state variables', model%state_count == 2)
    call tests%check('task 5 tells of a tangent', model%user%tangent == model_tangent_consistent)
    call model%start(stress0, state)
    call tests%check('task 1 answers in StVar0', same(state, [7.0_wp, 8.0_wp]))
    increment = distinct_increment()
    stress = stress0
    call model%update(increment, stress, state, response)
    call recalled(r, n, name)
    call tests%check('Sig0: 5 and 6 exchanged, zero beyond', same(r(1:6), stress0(swapped)) .and. same(r([8, 9, &
      (i, i=12, 20)]), spread(0.0_wp, 1, 11)))
    call tests%check('Sig0(7) is the steady pore pressure, tension positive', same(r(7:7), [-30.0_wp]))
    call tests%check('Sig0(10) and Sig0(11) are how far the pores are filled', same(r(10:11), [0.75_wp, 0.75_wp]))
    call tests%check('dEps: the increment', same(r(21:26), increment%strain(swapped)))
    call tests%check('dEps: the strain at the start', same(r(27:32), increment%strain_start(swapped)))
    call tests%check('Props as task 1 has left them', same(r([41, 42, 43, 60]), [31.0_wp, 32.0_wp, 0.0_wp, 20.0_wp]))
    call tests%check('X, Y, Z, Time0, dTime, Swp0, BulkW', same(r(91:97), [1.5_wp, 2.5_wp, 3.5_wp, 102.0_wp, &
      1.0_wp, -20.0_wp, 0.0_wp]))
    call tests%check('StVar0', same(r(101:102), [7.0_wp, 8.0_wp]))
    call tests%check('D of task 6 is handed to task 2', same(r(111:146:7), [1001.0_wp, 1002.0_wp, 1003.0_wp, &
      1004.0_wp, 1005.0_wp, 1006.0_wp]))
    call tests%check('Sig is preset by Sig0', same(r(151:156), stress0(swapped)))
    call tests%check('iMod, IsUndr, iStep, iTer, iEl, Int', all(n(21:26) == [1, 0, 17, 1, 24, 42]))
    call tests%check('iPrjDir is a directory, by character codes', n(27) == 2 .and. all(n(28:29) == iachar(['.', '/'])))
    call tests%check('ipl, nStat, NonSym, iStrsDep, iTimeDep, iTang', all(n(40:45) == [0, 2, 1, 0, 0, 1]))
    call tests%check('iAbort', n(46) == 0)
    call tests%check('Sig comes back exchanged', same(stress, stress0 + [100.0_wp, 200.0_wp, 300.0_wp, 400.0_wp, &
      600.0_wp, 500.0_wp]))
    call tests%check('StVar comes back', same(state, [8.0_wp, 9.0_wp]))
    call tests%check('D of task 3 comes back exchanged', abs(response%tangent(2, 5) - 26.0_wp) <= 0.0_wp .and. &
      abs(response%tangent(5, 6) - 65.0_wp) <= 0.0_wp .and. abs(response%tangent(6, 4) - 54.0_wp) <= 0.0_wp)
    call tests%check('ipl tells that it yields', response%plastic)
  end subroutine check_udsm_slots

  !> Pore water: Sig0 is without it, Sig with it, and it is carried.
  subroutine check_undrained(tests)
    type(tests_type), intent(inout) :: tests
    type(user_material_type) :: user
    type(udsm_type) :: model
    type(error_type), allocatable :: error
    type(soil_response_type) :: response
    real(wp) :: stress(6), state(3), r(400)
    integer :: n(100)
    character(len=80) :: name

    user = user_of(interface_udsm, 'recorder', [1.0_wp], -1)
    user%undrained = 900.0_wp
    call make_udsm(user, 'clay', model, error)
    stress = stress0
    state = [40.0_wp, 1.0_wp, 2.0_wp]
    call model%update(distinct_increment(), stress, state, response)
    call recalled(r, n, name)
    call tests%check('Sig0 is the effective stress', same(r(1:4), stress0(1:4) + [40.0_wp, 40.0_wp, 40.0_wp, 0.0_wp]))
    call tests%check('IsUndr, Swp0 and BulkW', n(22) == 1 .and. same(r(96:97), [-40.0_wp, 900.0_wp]))
    call tests%check('Swp is carried', same(state, [35.0_wp, 2.0_wp, 3.0_wp]))
    call tests%check('the stress is the total one', same(stress(1:4), [1.0_wp + 105.0_wp, 207.0_wp, 308.0_wp, 404.0_wp]))
    call tests%check('the tangent is that of the total stress', abs(response%tangent(1, 2) - 912.0_wp) <= 0.0_wp)
  end subroutine check_undrained

  !> Tangents: returned, at no strain, by differences. Differences of a linear law err by round-off over the change
  !> of the strain, 1e-16 1e1/1e-9 at the most, of 2700.
  subroutine check_tangents(tests)
    type(tests_type), intent(inout) :: tests
    type(soil_increment_type) :: increment
    type(soil_response_type) :: response
    type(user_material_type) :: user
    type(umat_type) :: model
    type(error_type), allocatable :: error
    real(wp) :: stress(6), state(6), returned(6, 6)

    user = user_of(interface_umat, 'fibre', [2000.0_wp, 0.3_wp, 500.0_wp], 6)
    call make_umat(user, 'peat', model, error)
    increment%strain = 1.0e-3_wp*[1.0_wp, -2.0_wp, 0.5_wp, 1.0_wp, 0.3_wp, -0.7_wp]
    stress = 0.0_wp
    state = [0.5_wp, 0.2_wp, 0.3_wp, 0.1_wp, 0.4_wp, -0.2_wp]
    call model%update(increment, stress, state, response)
    returned = response%tangent
    model%user%tangent = model_tangent_numerical
    stress = 0.0_wp
    call model%update(increment, stress, state, response)
    call tests%close('differences give the tangent', maxval(abs(response%tangent - returned)), 0.0_wp, 1.0e-5_wp)
    model%user%tangent = model_tangent_elastic
    stress = 0.0_wp
    call model%update(increment, stress, state, response)
    call tests%close('at no strain it is the same here', maxval(abs(response%tangent - returned)), 0.0_wp, 0.0_wp)
    call ask_stiffness(model, 0.0_wp, 0.0_wp, no_stress, error)
    call tests%check('a stiffness is found', .not. allocated(error) .and. model%stiffness_scale > 1000.0_wp)
    call ask_stiffness(model, 10.0_wp, 0.25_wp, no_stress, error)
    call tests%close('that of *ELASTIC goes before it', model%stiffness_scale, 10.0_wp, 0.0_wp)
    call tests%close('and its shear modulus', model%shear_scale, 4.0_wp, 1.0e-15_wp)
  end subroutine check_tangents

  !> A door's law, which must exist.
  subroutine adapter_law(user, dimension, law)
    type(user_material_type), intent(in) :: user
    integer, intent(in) :: dimension
    type(soil_model_law_type), intent(out) :: law
    type(umat_type) :: umat
    type(udsm_type) :: udsm
    type(error_type), allocatable :: error

    if (user%interface == interface_udsm) then
      call make_udsm(user, 'soil', udsm, error)
      call make_soil_model_law(udsm, dimension, law)
    else
      call make_umat(user, 'soil', umat, error)
      call make_soil_model_law(umat, dimension, law)
    end if
  end subroutine adapter_law

  !> Built-in laws of the Cauchy rate, and the same as UMAT and UDSM: stress, Q and A, to round-off relative to E.
  subroutine check_as_built_in(tests)
    type(tests_type), intent(inout) :: tests
    type(material_parameters_type) :: p
    type(user_material_type) :: user
    integer :: dimension

    do dimension = 2, 3
      p = material_parameters_type(young=200.0_wp, poisson=0.33_wp)
      call compare(tests, 'elastic UMAT', user_of(interface_umat, 'elastic_umat', [200.0_wp, 0.33_wp], 0), p, &
        dimension, 1.0e-13_wp)
      user = user_of(interface_udsm, 'elastic_udsm', [200.0_wp, 0.33_wp], -1)
      ! Differences of the stress over 1e-4 of the strain.
      call compare(tests, 'elastic UDSM without a tangent', user, p, dimension, 1.0e-10_wp)
      user%tangent = model_tangent_elastic
      call compare(tests, 'elastic UDSM', user, p, dimension, 1.0e-13_wp)
      p%mohr_coulomb = .true.
      p%cohesion = 1.0_wp
      p%friction_angle = 25.0_wp
      user = user_of(interface_umat, 'mohr_coulomb', [200.0_wp, 0.33_wp, 1.0_wp, 25.0_wp, 0.0_wp], 0)
      ! Gaps of principal stresses that nearly close amplify round-off in the tangent.
      call compare(tests, 'Mohr-Coulomb UMAT', user, p, dimension, 1.0e-9_wp)
      user%components = 4
      if (dimension == 2) call compare(tests, 'UMAT of four components', user, p, dimension, 1.0e-9_wp)
    end do
  end subroutine check_as_built_in

  !> Compare a door with a built-in law.
  subroutine compare(tests, name, user, p, dimension, tolerance)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(user_material_type), intent(in) :: user
    type(material_parameters_type), intent(in) :: p
    integer, intent(in) :: dimension
    !> Relative to Young's modulus.
    real(wp), intent(in) :: tolerance
    type(soil_model_law_type) :: adapter
    class(law_type), allocatable :: built_in
    type(batch_type) :: one, other
    type(error_type), allocatable :: error

    call adapter_law(user, dimension, adapter)
    call new_law(p, dimension, kinematics_jaumann, rate_midpoint_cauchy, built_in, error)
    call random_batch(adapter, 200, 0.03_wp, 1.0_wp, one)
    call random_batch(built_in, 200, 0.03_wp, 1.0_wp, other)
    call adapter%update(one, tangent_consistent)
    call built_in%update(other, tangent_consistent)
    call tests%check(name//': every point is updated', all(one%status == status_ok))
    call tests%close(name//': stress', maxval(abs(one%stress - other%stress)), 0.0_wp, tolerance*p%young)
    call tests%close(name//': Q', maxval(abs(one%piola - other%piola)), 0.0_wp, tolerance*p%young)
    call tests%close(name//': A', maxval(abs(one%tangent - other%tangent)), 0.0_wp, 10.0_wp*tolerance*p%young)
  end subroutine compare

  !> A model that divides by its strain increment: without strain its point stays as it is, with the tangent of small
  !> strains around; its stiffness is found where it starts, and what it gives for a strain is taken as it is.
  subroutine check_rest(tests)
    type(tests_type), intent(inout) :: tests
    type(umat_type) :: model
    type(soil_model_law_type) :: law, good
    type(batch_type) :: batch, other
    type(error_type), allocatable :: error

    call make_umat(user_of(interface_umat, 'faulty', [200.0_wp, 0.3_wp, 15.0_wp, 1.0_wp], 0), 'rests', model, error)
    call ask_stiffness(model, 0.0_wp, 0.0_wp, [-1.0_wp, -2.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], error)
    call tests%check('a model without an answer to no strain has a stiffness', .not. allocated(error))
    call tests%close('that of its differences', model%stiffness_scale, 200.0_wp, 1.0e-6_wp)
    call make_soil_model_law(model, 3, law)
    model%user%constants(3) = 0.0_wp
    model%props(3) = 0.0_wp
    call make_soil_model_law(model, 3, good)
    call random_batch(law, 3, 0.03_wp, 1.0_wp, batch)
    call random_batch(good, 3, 0.03_wp, 1.0_wp, other)
    call at_rest(batch)
    call at_rest(other)
    call law%update(batch, tangent_consistent)
    call good%update(other, tangent_consistent)
    call tests%check('a step without strain is answered', all(batch%status == status_ok))
    call tests%close('stress and state stay', max(maxval(abs(batch%stress - batch%stress_start)), &
      maxval(abs(batch%state - batch%state_start))), 0.0_wp, 0.0_wp)
    call tests%close('its tangent is that of small strains', maxval(abs(batch%tangent - other%tangent)), 0.0_wp, 1.0e-5_wp)
    call law%update(batch, tangent_none)
    call tests%check('no tangent is made where none is wanted', all(batch%status == status_ok))
  end subroutine check_rest

  !> Let the points of a batch stay where they are.
  subroutine at_rest(points)
    type(batch_type), intent(inout) :: points
    integer :: p

    do p = 1, points%count
      call pack_gradient(identity, points%gradient(:, p))
    end do
  end subroutine at_rest

  !> Stress that changes at no strain: again with every call it is a fault, with time it is told, towards a limit it is let be.
  subroutine check_changes_at_rest(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: stress(6) = [-1.0_wp, -2.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
    type(umat_type) :: model
    type(soil_model_law_type) :: law
    type(batch_type) :: batch
    type(error_type), allocatable :: error
    integer :: kind

    do kind = 22, 24
      call make_umat(user_of(interface_umat, 'faulty', [200.0_wp, 0.3_wp, real(kind, wp), 0.0_wp], 0), 'moves', model, error)
      call ask_stiffness(model, 0.0_wp, 0.0_wp, stress, error)
      call make_soil_model_law(model, 3, law)
      call tests%check('a flow is told, nothing else', merge(index(law%advice, 'changes with time') > 0, &
        len(law%advice) == 0, kind == 23))
      call random_batch(law, 3, 0.03_wp, 3.0_wp, batch)
      call at_rest(batch)
      batch%step_info%duration = 0.1_wp
      call law%update(batch, tangent_none)
      call tests%check('a change with every call is a fault, flow and return are not', all(batch%status == &
        merge(status_unrecoverable, status_ok, kind == 22)))
    end do
  end subroutine check_changes_at_rest

  !> A model whose answer jumps by 2e-5 from strain to strain, as one of substeps of controlled error does: its tangent by
  !> differences is that of the elasticity below, 2 % of which the jumps are over the smallest change of a strain.
  subroutine check_jumps(tests)
    type(tests_type), intent(inout) :: tests
    type(umat_type) :: model
    type(error_type), allocatable :: error
    type(soil_response_type) :: smooth, jumps
    real(wp) :: stress(6), state(0)

    call make_umat(user_of(interface_umat, 'faulty', [200.0_wp, 0.3_wp, 25.0_wp, 9.0_wp, 2.0e-5_wp], 0), 'jumps', model, error)
    model%user%tangent = model_tangent_numerical
    stress = 0.0_wp
    call model%update(distinct_increment(), stress, state, jumps)
    model%props(5) = 0.0_wp
    stress = 0.0_wp
    call model%update(distinct_increment(), stress, state, smooth)
    call tests%close('jumps do not become a tangent', maxval(abs(jumps%tangent - smooth%tangent)), 0.0_wp, 2.0_wp)
    call tests%close('without them it is that of the smallest changes', smooth%tangent(1, 1), 200.0_wp*0.7_wp/(1.3_wp*0.4_wp), &
      1.0e-6_wp)
  end subroutine check_jumps

  !> What tools/build-umat does for a library: local variables at zero, its own procedures before those that are lent.
  subroutine check_own_helpers(tests)
    type(tests_type), intent(inout) :: tests
    type(umat_type) :: model
    type(error_type), allocatable :: error
    type(soil_response_type) :: response
    real(wp) :: stress(6), state(0)

    call make_umat(user_of(interface_umat, 'own_helpers', [200.0_wp, 0.0_wp], 0), 'own', model, error)
    call tests%check('a library with an XIT of its own is built', .not. allocated(error))
    if (allocated(error)) return
    stress = 0.0_wp
    call model%update(distinct_increment(), stress, state, response)
    call tests%close('local variables start at zero', stress(1), 0.0_wp, 0.0_wp)
    call tests%close('its own SINV goes first', stress(2), 5.0_wp, 0.0_wp)
  end subroutine check_own_helpers

  !> Models that do not return: the reason, and that others go on.
  subroutine check_faulty_models(tests)
    type(tests_type), intent(inout) :: tests
    type(soil_response_type) :: response

    call ask_faulty('faulty', 5, [0.25_wp, 0.0_wp], response)
    call tests%check('PNEWDT below 1 cuts the step', response%status == status_cut)
    call tests%close('by that share', response%share, 0.25_wp, 0.0_wp)
    call ask_faulty('faulty', 9, [0.0_wp, 0.0_wp], response)
    call tests%check('writing beyond the state is seen', response%status == status_unrecoverable)
    call ask_faulty('faulty', 11, [0.0_wp, 0.0_wp], response)
    call tests%check('so is a small number that is added there', response%status == status_unrecoverable)
    call tests%check('and said', index(response%message, 'writes 1 numbers behind its argument STATEV, which has 0: STATE') > 0)
    call ask_faulty('faulty', 16, [0.0_wp, 0.0_wp], response)
    call tests%check('many numbers behind STATEV, over other arrays', response%status == status_unrecoverable .and. &
      index(response%message, 'writes 211 numbers behind its argument STATEV') > 0)
    call ask_faulty('faulty', 17, [0.0_wp, 0.0_wp], response)
    call tests%check('numbers behind STRESS', index(response%message, 'writes 12 numbers behind its argument STRESS, '// &
      'which has 6') > 0)
    call ask_faulty('faulty', 18, [0.0_wp, 0.0_wp], response)
    call tests%check('a number before DDSDDE', index(response%message, 'writes 2 numbers before its argument DDSDDE') > 0)
    call ask_faulty('faulty', 19, [0.0_wp, 0.0_wp], response)
    call tests%check('a constant behind the last one', index(response%message, 'behind its argument PROPS, which has 6') > 0)
    call ask_faulty('faulty', 13, [0.0_wp, 0.0_wp], response)
    call tests%check('a model that overwrites NTENS is broken', response%status == status_unrecoverable)
    call tests%check('and NTENS is named', index(response%message, 'argument NTENS, 6, by 4') > 0)
    call ask_faulty('faulty', 14, [0.0_wp, 0.0_wp], response)
    call tests%check('one that overwrites NSTATV too', response%status == status_unrecoverable .and. &
      index(response%message, 'argument NSTATV, 0, by 1') > 0)
    call ask_faulty('faulty', 3, [0.0_wp, 0.0_wp], response)
    call tests%check('a fault comes back', response%status == status_unrecoverable)
    call tests%check('with its signal', index(response%message, 'SIGSEGV') > 0)
    call ask_faulty('faulty', 0, [0.0_wp, 0.0_wp], response)
    call tests%check('another analysis calls it again', response%status == status_ok)
    call ask_faulty('faulty_stop', 1, [0.0_wp, 0.0_wp], response)
    call tests%check('STOP comes back', response%status == status_unrecoverable .and. index(response%message, &
      'STOP') > 0)
    call ask_faulty('faulty_arithmetic', 2, [0.0_wp, 0.0_wp], response)
    call tests%check('a division by zero comes back', response%status == status_unrecoverable .and. &
      index(response%message, 'SIGFPE') > 0)
    call ask_faulty('faulty_abort', 8, [0.0_wp, 0.0_wp], response)
    call tests%check('ABORT comes back', response%status == status_unrecoverable .and. index(response%message, &
      'SIGABRT') > 0)
  end subroutine check_faulty_models

  !> Ask the faulty UMAT.
  subroutine ask_faulty(library, kind, more, response)
    !> Name of the plug-in.
    character(len=*), intent(in) :: library
    !> What goes wrong, and two more constants.
    integer, intent(in) :: kind
    real(wp), intent(in) :: more(2)
    type(soil_response_type), intent(out) :: response
    type(umat_type) :: model
    type(error_type), allocatable :: error
    real(wp) :: stress(6), state(0)

    call make_umat(user_of(interface_umat, library, [200.0_wp, 0.3_wp, real(kind, wp), 9.0_wp, more], 0), 'bad', &
      model, error)
    stress = 0.0_wp
    call model%update(distinct_increment(), stress, state, response)
  end subroutine ask_faulty

  !> Faults planted in models: a UDSM whose last two components are exchanged, tensor shear, a transposed tangent and
  !> a rotation from the wrong side give other answers than the same models without, by far.
  subroutine check_planted(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: names(4) = [character(len=24) :: 'slots 5 and 6 exchanged', 'tensor shear', &
      'transposed tangent', 'DROT from the wrong side']
    type(soil_model_law_type) :: law
    real(wp) :: error(0:4)
    integer :: kind

    do kind = 0, 4
      call adapter_law(user_of(interface_umat, 'planted', [200.0_wp, 0.3_wp, 150.0_wp, real(kind, wp)], 6), 3, law)
      call planted_error(law, error(kind))
    end do
    call tests%close('the sound model: tangent is the derivative', error(0), 0.0_wp, 1.0e-7_wp)
    do kind = 1, 4
      call tests%check('a fault is seen: '//trim(names(kind)), error(kind) > 1.0e-3_wp)
    end do
  end subroutine check_planted

  !> Error of the tangent by differences at turned, strained points.
  subroutine planted_error(law, error)
    type(soil_model_law_type), intent(in) :: law
    real(wp), intent(out) :: error
    type(batch_type) :: batch
    integer :: compared, p

    call random_batch(law, 10, 0.1_wp, 50.0_wp, batch)
    do p = 1, batch%count
      batch%state_start(law%before_own + 1:, p) = [0.4_wp, 0.1_wp, 0.5_wp, 0.2_wp, -0.3_wp, 0.25_wp]
    end do
    call law%update(batch, tangent_consistent)
    call difference_error(law, batch, batch%tangent, error, compared)
  end subroutine planted_error

  !> Traits of UDSMs of others; the numbers are exact to round-off.
  subroutine check_traits(tests)
    type(tests_type), intent(inout) :: tests
    type(user_material_type) :: user
    type(udsm_type) :: udsm
    type(soil_model_law_type) :: law
    type(error_type), allocatable :: error
    type(soil_response_type) :: response
    real(wp) :: stress(6), state(3)
    integer :: unit, status

    user = user_of(interface_udsm, 'traits', [260.0_wp, 0.3_wp], -1)
    user%undrained = 1.0_wp
    call make_udsm(user, 'silt', udsm, error)
    call tests%check('too few constants are told, with the name of the first', refused(error, &
      "the model has 3 parameters, here are 2 constants; the first that is missing is 'e_0'"))
    user = user_of(interface_udsm, 'traits', [260.0_wp, 0.3_wp, 0.65_wp], -1)
    user%undrained = 1.0_wp
    call make_udsm(user, 'silt', udsm, error)
    call tests%check('words of another compiler are left out by tools/build-umat', .not. allocated(error))
    open (newunit=unit, file='data.traits.rr0', status='old', iostat=status)
    call tests%check('the model has its own file in the working directory', status == 0)
    if (status == 0) close (unit, status='delete')
    call udsm%start(stress0, state)
    stress = stress0
    call udsm%update(distinct_increment(), stress, state, response)
    ! G = 100, its own bulk modulus of the water 50 G, a volume strain of 6e-3; K + 4 G/3 = 350. The volume grows: suction.
    call tests%close('the pore pressure is that of its own modulus', state(1), -30.0_wp, 1.0e-12_wp)
    call tests%close('and so is the tangent', response%tangent(1, 1), 5350.0_wp, 1.0e-10_wp)
    call tests%check('task 3 finds ipl and StVar of task 2', response%status == status_ok)
    call make_soil_model_law(udsm, 3, law)
    call tests%check('the state has names', law%state_names(7)%text == 'excess_pore_pressure' .and. &
      law%state_names(8)%text == 'SDV1_void_ratio' .and. law%state_names(9)%text == 'SDV2_calls')
    call tests%check('what the law carries has none', all([(len(law%state_names(unit)%text) == 0, unit=1, 6)]))
    user%shows_state = .false.
    call make_udsm(user, 'silt', udsm, error)
    call make_soil_model_law(udsm, 3, law)
    call tests%check('a state that is not to be shown has none', .not. allocated(law%state_names))
  end subroutine check_traits

  !> A UMAT of the deformation gradient: the tangent by differences moves it, too. The law takes a strain at the
  !> end of the step for one of the mid configuration, which costs about the square of the increments of up to 0.03;
  !> without a tangent the error is 1.
  subroutine check_by_gradient(tests)
    type(tests_type), intent(inout) :: tests
    type(user_material_type) :: user
    type(soil_model_law_type) :: law
    type(batch_type) :: batch
    type(umat_type) :: model
    type(error_type), allocatable :: error
    type(soil_increment_type) :: increment
    type(soil_response_type) :: response
    real(wp) :: stress(6), state(0), expected(6, 6), largest
    integer :: i, compared

    user = user_of(interface_umat, 'neo_hooke', [300.0_wp, 400.0_wp], 0)
    user%tangent = model_tangent_numerical
    call make_umat(user, 'gel', model, error)
    stress = 0.0_wp
    call model%update(increment, stress, state, response)
    ! At F = 1 it is Hooke's law; differences over 1e-9 err by 1e-7 of it.
    expected = 0.0_wp
    expected(1:3, 1:3) = 400.0_wp
    do i = 1, 6
      expected(i, i) = expected(i, i) + merge(600.0_wp, 300.0_wp, i <= 3)
    end do
    call tests%close('differences move the deformation gradient', maxval(abs(response%tangent - expected)), 0.0_wp, &
      1.0e-3_wp)
    call adapter_law(user, 3, law)
    call random_batch(law, 20, 0.03_wp, 1.0_wp, batch)
    call law%update(batch, tangent_consistent)
    call difference_error(law, batch, batch%tangent, largest, compared)
    call tests%check('the tangent of a law by the deformation gradient', compared > 100 .and. largest < 2.0e-3_wp)
  end subroutine check_by_gradient

  !> State variables at the start that differ along an axis.
  subroutine check_levels(tests)
    type(tests_type), intent(inout) :: tests
    type(user_material_type) :: user
    real(wp) :: state(3)

    user%start = [5.0_wp, 6.0_wp]
    state = 9.0_wp
    call put_start(user, [0.0_wp, 3.0_wp, 0.0_wp], state)
    call tests%check('the same everywhere', same(state, [5.0_wp, 6.0_wp, 9.0_wp]))
    user%along = 2
    user%levels = [0.0_wp, 2.0_wp, 6.0_wp]
    user%profile = reshape([1.0_wp, 10.0_wp, 3.0_wp, 20.0_wp, 7.0_wp, 0.0_wp], [2, 3])
    call put_start(user, [4.0_wp, 1.0_wp, 5.0_wp], state)
    call tests%check('linear between two levels', same(state, [2.0_wp, 15.0_wp, 9.0_wp]))
    call put_start(user, [4.0_wp, 5.0_wp, 0.0_wp], state)
    call tests%check('and between the next two', same(state, [6.0_wp, 5.0_wp, 9.0_wp]))
    call put_start(user, [4.0_wp, -5.0_wp, 1.0_wp], state)
    call tests%check('below the first level as there', same(state, [1.0_wp, 10.0_wp, 9.0_wp]))
    call put_start(user, [4.0_wp, 60.0_wp, 1.0_wp], state)
    call tests%check('above the last level as there', same(state, [7.0_wp, 0.0_wp, 9.0_wp]))
  end subroutine check_levels

  !> A UMAT that reads more constants than there are finds no numbers there, every time the same.
  subroutine check_missing_constants(tests)
    type(tests_type), intent(inout) :: tests
    type(soil_model_law_type) :: law
    type(batch_type) :: batch

    call adapter_law(user_of(interface_umat, 'elastic_umat', [200.0_wp], 0), 3, law)
    call random_batch(law, 1, 0.01_wp, 1.0_wp, batch)
    call law%update(batch, tangent_consistent)
    call tests%check('a missing constant is found', batch%status(1) == status_unrecoverable)
    call tests%check('which is reported', index(batch%message, 'reads more constants than the 1 of the deck') > 0)
    call adapter_law(user_of(interface_umat, 'mohr_coulomb', [200.0_wp, 0.3_wp, 1.0_wp, 25.0_wp], 0), 3, law)
    call random_batch(law, 1, 0.01_wp, 1.0_wp, batch)
    call law%update(batch, tangent_consistent)
    call tests%check('also where comparisons with it leave the model elastic', batch%status(1) == status_unrecoverable)
  end subroutine check_missing_constants

  !> Libraries and procedures that are not there, and a wrong number of state variables.
  subroutine check_loading(tests)
    type(tests_type), intent(inout) :: tests
    type(user_material_type) :: user
    type(umat_type) :: umat
    type(udsm_type) :: udsm
    type(c_funptr) :: address
    type(error_type), allocatable :: error

    user = user_of(interface_umat, 'elastic_umat', [1.0_wp, 0.0_wp], 0)
    user%symbol = 'nothing'
    call make_umat(user, 'soil', umat, error)
    call tests%check('a missing procedure', refused(error, "has no procedure 'nothing'"))
    call load_procedure(plugin('traits'), 'Titles::titled', address, error)
    call tests%check('a procedure of a module is found', .not. allocated(error))
    user%library = '/no/such/library.so'
    call make_umat(user, 'soil', umat, error)
    call tests%check('a missing library', refused(error, "there is no library '/no/such/library.so'"))
    call make_udsm(user_of(interface_udsm, 'elastic_udsm', [1.0_wp, 0.0_wp], 3), 'soil', udsm, error)
    call tests%check('another number of state variables', refused(error, 'the model has 1 state variables'))
    call make_udsm(user_of(interface_udsm, 'elastic_udsm', [1.0_wp, 0.0_wp], -1), 'soil', udsm, error)
    call tests%check('a model without a tangent is said to have none', allocated(udsm%advice))
    if (allocated(udsm%advice)) call tests%check('and what is made of it', index(udsm%advice, 'by differences') > 0)
    user = user_of(interface_udsm, 'elastic_udsm', [1.0_wp, 0.0_wp], -1)
    user%tangent = model_tangent_numerical
    call make_udsm(user, 'soil', udsm, error)
    call tests%check('unless one is asked for', .not. allocated(udsm%advice))
    call make_udsm(user_of(interface_udsm, 'traits', [260.0_wp, 0.3_wp, 0.65_wp], -1), 'soil', udsm, error)
    call tests%check('one that has a tangent needs none', .not. allocated(udsm%advice))
  end subroutine check_loading

  !> A UMAT's own procedure for initial state variables: it is told the place and what the deck has.
  subroutine check_sdvini(tests)
    type(tests_type), intent(inout) :: tests
    type(user_material_type) :: user
    type(umat_type) :: umat
    type(error_type), allocatable :: error
    real(wp) :: state(2), stress(6)

    stress = 0.0_wp
    user = user_of(interface_umat, 'initial_umat', [1.0_wp, 0.0_wp], 2)
    user%start = [5.0_wp, 7.0_wp]
    call make_umat(user, 'soil', umat, error)
    call umat%start_at(stress, [1.0_wp, 3.0_wp, 0.0_wp], state)
    call tests%check('SDVINI sets state variables by the place, and finds those of the deck', &
      all(abs(state - [6.0_wp, 8.0_wp]) <= 0.0_wp))
    user = user_of(interface_umat, 'fibre', [1.0_wp, 0.0_wp, 1.0_wp], 2)
    user%start = [5.0_wp, 7.0_wp]
    call make_umat(user, 'soil', umat, error)
    call umat%start_at(stress, [1.0_wp, 3.0_wp, 0.0_wp], state)
    call tests%check('without it they are those of the deck', all(abs(state - [5.0_wp, 7.0_wp]) <= 0.0_wp))
    user = user_of(interface_umat, 'initial_umat', [1.0_wp, 0.0_wp], 1)
    call make_umat(user, 'soil', umat, error)
    call tests%put_off_traps()
    call umat%start_at(stress, [1.0_wp, 3.0_wp, 0.0_wp], state(:1))
    call tests%check('one that writes behind them leaves no number', ieee_is_nan(state(1)))
    call tests%trap_again()
  end subroutine check_sdvini

  !> Whether an error is one of the user's material and says something.
  pure logical function refused(error, words)
    type(error_type), allocatable, intent(in) :: error
    character(len=*), intent(in) :: words

    refused = .false.
    if (.not. allocated(error)) return
    refused = error%code == error_user_material .and. index(error%message, words) > 0
  end function refused
end module test_user_adapters
