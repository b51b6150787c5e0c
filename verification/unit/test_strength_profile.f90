!> Strength by place: the profiles themselves, the law of a point against the law that has its strength and stiffness,
!> averages, tangents, and strength that is reduced.
module test_strength_profile
  use law_trials, only: elastic, strong, make_law, random_batch, difference_error
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type, batch_type, tangent_none, tangent_consistent
  use qsmpm_law_factory, only: kinematics_logarithmic, kinematics_jaumann, rate_midpoint
  use qsmpm_material_parameters, only: material_parameters_type
  use qsmpm_profile_law, only: new_profile_law
  use qsmpm_strength_factor, only: strength_factor_type, flow_material, flow_davis_b, lower_strength
  use qsmpm_strength_profile, only: strength_profile_type, is_by_place, reference_strength, strength_at, young_at, &
    varies_friction, varies_stiffness, varies_strength, profile_table, profile_shansep
  use qsmpm_undrained_law, only: make_undrained
  use qsmpm_undrained_parameters, only: undrained_type, water_stiffness
  use qsmpm_value_field, only: value_field_type, field_cohesion, field_friction, field_young, set_samples
  use testing, only: tests_type
  implicit none
  private

  public :: collect_strength_profile

  real(wp), parameter :: rounding = 1.0e-11_wp
  real(wp), parameter :: here(3) = [3.0_wp, -2.0_wp, 0.5_wp]

contains

  subroutine collect_strength_profile(tests)
    type(tests_type), intent(inout) :: tests
    integer :: d, k

    call tests%start('strength_profile')
    call check_values(tests)
    do d = 2, 3
      do k = kinematics_jaumann, kinematics_logarithmic
        call check_law(tests, d, k, .false., 1.0_wp)
        call check_law(tests, d, k, .true., 1.0_wp)
        call check_law(tests, d, k, .true., 0.7_wp)
        call check_average(tests, d, k)
        call check_friction(tests, d, k)
      end do
    end do
    call check_elastic(tests)
    call check_sand(tests)
    call check_water(tests)
    call check_stress(tests)
  end subroutine collect_strength_profile

  !> SHANSEP: 0.25 sigma_v OCR^0.8 of the effective stress at the start and when it is asked for, along the axis that is
  !> named; the largest stress so far is kept, and in tension the least strength is left.
  subroutine check_stress(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(strength_profile_type) :: profile
    type(material_parameters_type) :: clay
    type(error_type), allocatable :: error
    real(wp) :: stress(4)
    real(wp), allocatable :: state(:)
    integer :: n

    profile = strength_profile_type(given=.true., kind=profile_shansep, ratio=0.25_wp, exponent=0.8_wp, &
      overconsolidation=2.0_wp, pre_overburden=10.0_wp, least=1.0_wp, young=200.0_wp, along=1)
    clay = strong(0.0_wp, -1.0_wp)
    clay%friction_angle = 0.0_wp
    call new_profile_law(clay, profile, 2, kinematics_logarithmic, rate_midpoint, law, error)
    call make_undrained(undrained_type(given=.true.), law, error)
    allocate (state(law%state_count))
    n = law%state_count
    stress = [-40.0_wp, -20.0_wp, -20.0_wp, 0.0_wp]
    call law%start_at(stress, here, state)
    call tests%check('names of strength and past', law%state_names(n - 2)%text == 'undrained_strength' .and. &
      law%state_names(n - 1)%text == 'preconsolidation_stress')
    call tests%close('preconsolidation of the start', state(n - 1), 90.0_wp, rounding)
    call tests%close('strength of the start', state(n - 2), 0.25_wp*40.0_wp*2.25_wp**0.8_wp, rounding)
    ! 30 of 90 are carried by the water.
    state(n) = 30.0_wp
    stress(1) = -90.0_wp
    call law%strengthen(stress, state)
    call tests%close('strength after loading below the past', state(n - 2), 15.0_wp*1.5_wp**0.8_wp, rounding)
    state(n) = 0.0_wp
    stress(1) = -120.0_wp
    call law%strengthen(stress, state)
    call tests%close('strength on the virgin line', state(n - 2), 30.0_wp, rounding)
    stress(1) = -60.0_wp
    call law%strengthen(stress, state)
    call tests%close('the past is kept', state(n - 1), 120.0_wp, rounding)
    call tests%close('strength after unloading', state(n - 2), 15.0_wp*2.0_wp**0.8_wp, rounding)
    stress(1) = 5.0_wp
    call law%strengthen(stress, state)
    call tests%close('the least one in tension', state(n - 2), 1.0_wp, rounding)
    call tests%close('and in tension too the past is kept', state(n - 1), 120.0_wp, rounding)
    call make_law(strong(5.0_wp, -1.0_wp), 2, kinematics_logarithmic, rate_midpoint, law)
    state = 7.0_wp
    call law%strengthen(stress, state(:law%state_count))
    call tests%check('other laws keep what they have', all(abs(state - 7.0_wp) <= 0.0_wp))
  end subroutine check_stress

  !> s = 2 + 1.5 (1 - y), E = 100 s where asked.
  pure function line(stiff) result(profile)
    logical, intent(in) :: stiff
    type(strength_profile_type) :: profile

    profile%given = .true.
    profile%level = 1.0_wp
    profile%strength = 2.0_wp
    profile%gain = 1.5_wp
    profile%young = 200.0_wp
    if (stiff) profile%stiffness_ratio = 100.0_wp
  end function line

  !> Linear profiles and tables.
  subroutine check_values(tests)
    type(tests_type), intent(inout) :: tests
    type(strength_profile_type) :: profile

    profile = line(.true.)
    call tests%close('linear', strength_at(profile, here), 6.5_wp, rounding)
    call tests%close('stiffness in proportion', young_at(profile, here), 650.0_wp, rounding)
    profile%least = 7.0_wp
    call tests%close('that of the least strength', young_at(profile, here), 700.0_wp, rounding)
    profile%along = 1
    call tests%close('along x', strength_at(profile, here), -1.0_wp, rounding)
    profile = strength_profile_type(given=.true., kind=profile_table)
    profile%levels = [-4.0_wp, -1.0_wp, 0.0_wp]
    profile%strengths = [10.0_wp, 4.0_wp, 3.0_wp]
    profile%moduli = [100.0_wp, 70.0_wp, 10.0_wp]
    call tests%close('between levels', strength_at(profile, here), 6.0_wp, rounding)
    call tests%close('stiffness between levels', young_at(profile, here), 80.0_wp, rounding)
    call tests%close('above', strength_at(profile, [0.0_wp, 5.0_wp, 0.0_wp]), 3.0_wp, rounding)
    call tests%close('below', strength_at(profile, [0.0_wp, -5.0_wp, 0.0_wp]), 10.0_wp, rounding)
    call tests%check('stiffness varies', varies_stiffness(profile) .and. .not. varies_stiffness(line(.false.)))
  end subroutine check_values

  !> Friction by place: stress, tangent and averages are those of the material that has the angle of the place, with a
  !> cohesion of its own and one by place, with a stiffness by place, and as a factor of safety lowers it.
  subroutine check_friction(tests, dimension, kinematics)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension, kinematics
    integer :: way

    do way = 1, 4
      call check_friction_law(tests, dimension, kinematics, by_place=way > 1, stiff=way == 3, flow=merge(flow_davis_b, &
        flow_material, way == 4), factor=merge(1.0_wp, 1.3_wp, way == 1))
    end do
  end subroutine check_friction

  !> One way.
  subroutine check_friction_law(tests, dimension, kinematics, by_place, stiff, flow, factor)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension, kinematics, flow
    logical, intent(in) :: by_place, stiff
    real(wp), intent(in) :: factor
    class(law_type), allocatable :: law, own
    type(material_parameters_type) :: parameters
    type(strength_profile_type) :: profile
    type(batch_type) :: batch, same
    type(error_type), allocatable :: error
    real(wp), allocatable :: tangent(:, :, :), fields(:), stress(:), state(:)
    real(wp) :: worst
    integer :: p, n, compared

    profile%fields = friction_fields(by_place, stiff)
    profile%young = 200.0_wp
    profile%least = 2.0_wp
    profile%dilatancy_angle = 26.0_wp
    profile%lowered = strength_factor_type(factor, flow)
    parameters = strong(2.0_wp, -1.0_wp)
    parameters%cohesion = 2.0_wp
    call new_profile_law(parameters, profile, dimension, kinematics, rate_midpoint, law, error)
    call tests%check('names of friction', law%state_names(law%state_count)%text == 'friction_angle')
    ! 21 degrees at the place, below psi of the material.
    parameters%friction_angle = 21.0_wp
    parameters%dilatancy_angle = 21.0_wp
    if (by_place) parameters%cohesion = 6.5_wp
    if (stiff) parameters%young = 650.0_wp
    call lower_strength(profile%lowered, parameters%cohesion, parameters%friction_angle, parameters%dilatancy_angle)
    call make_law(parameters, dimension, kinematics, rate_midpoint, own)
    call tests%check('symmetry', law%symmetric .eqv. (own%symmetric .and. flow /= flow_material))
    call random_batch(own, 60, 0.05_wp, 5.0_wp, same)
    call random_batch(law, 60, 0.05_wp, 5.0_wp, batch)
    do p = 1, batch%count
      call law%start_at(batch%stress_start(:, p), here, batch%state_start(:, p))
    end do
    call law%update(batch, tangent_consistent)
    call own%update(same, tangent_consistent)
    n = law%state_count
    call tests%check('some yield, some do not', any(batch%plastic == 1) .and. any(batch%plastic == 0))
    call tests%close('stress', maxval(abs(batch%stress - same%stress)), 0.0_wp, 1.0e-10_wp)
    call tests%close('tangent', maxval(abs(batch%tangent - same%tangent)), 0.0_wp, 1.0e-8_wp)
    call tests%close('friction is kept', maxval(abs(batch%state(n, :) - 21.0_wp)), 0.0_wp, 1.0e-8_wp)
    allocate (tangent, source=batch%tangent)
    call difference_error(law, batch, tangent, worst, compared)
    call tests%close('tangent against differences', worst, 0.0_wp, 1.0e-7_wp)
    allocate (fields(law%fit_count()), stress(size(batch%stress, 1)), state(n))
    call law%to_fields(batch%stress_start(:, 1), batch%state_start(:, 1), fields)
    call law%from_fields(fields, 1.0_wp, stress, state)
    call tests%close('state comes back', maxval(abs(state - batch%state_start(:, 1))), 0.0_wp, 1.0e-9_wp)
    fields(law%fit_count()) = 89.0_wp
    call law%from_fields(fields, 1.0_wp, stress, state)
    call tests%close('no steeper than any sample', state(n), 27.0_wp, rounding)
    fields(law%fit_count()) = -1.0_wp
    call law%from_fields(fields, 1.0_wp, stress, state)
    call tests%close('nor below nothing', state(n), 0.0_wp, 0.0_wp)
  end subroutine check_friction_law

  !> phi = 27 + 3 y, c = 2 + 1.5 (1 - y), E = 100 c, by samples.
  pure function friction_fields(by_place, stiff) result(fields)
    logical, intent(in) :: by_place, stiff
    type(value_field_type), allocatable :: fields(:)
    real(wp) :: places(3, 3), y(3)

    places = 0.0_wp
    y = [0.0_wp, -2.0_wp, -4.0_wp]
    places(1, :) = 3.0_wp
    places(2, :) = y
    places(3, :) = 0.5_wp
    allocate (fields(1 + merge(1, 0, by_place) + merge(1, 0, stiff)))
    fields(1)%parameter = field_friction
    call set_samples(fields(1), places, 27.0_wp + 3.0_wp*y)
    if (.not. by_place) return
    fields(2)%parameter = field_cohesion
    call set_samples(fields(2), places, 3.5_wp - 1.5_wp*y)
    if (.not. stiff) return
    fields(3)%parameter = field_young
    call set_samples(fields(3), places, 350.0_wp - 150.0_wp*y)
  end function friction_fields

  !> Soil without cohesion whose stiffness alone differs by place.
  subroutine check_sand(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law, own
    type(material_parameters_type) :: sand
    type(strength_profile_type) :: profile
    type(value_field_type) :: stiffness(3)
    type(error_type), allocatable :: error
    type(batch_type) :: batch, same
    integer :: p

    stiffness = friction_fields(.true., .true.)
    profile%fields = [stiffness(3)]
    profile%young = 200.0_wp
    sand = strong(0.0_wp, -1.0_wp)
    sand%cohesion = 0.0_wp
    call new_profile_law(sand, profile, 2, kinematics_logarithmic, rate_midpoint, law, error)
    sand%young = 650.0_wp
    call make_law(sand, 2, kinematics_logarithmic, rate_midpoint, own)
    call random_batch(law, 40, 0.05_wp, 5.0_wp, batch)
    call random_batch(own, 40, 0.05_wp, 5.0_wp, same)
    do p = 1, batch%count
      call law%start_at(batch%stress_start(:, p), here, batch%state_start(:, p))
    end do
    call law%update(batch, tangent_none)
    call own%update(same, tangent_none)
    call tests%check('sand yields', any(batch%plastic == 1))
    call tests%close('stress of sand', maxval(abs(batch%stress - same%stress)), 0.0_wp, 1.0e-10_wp)
    call tests%check('what differs', is_by_place(profile) .and. .not. is_by_place(strength_profile_type()) .and. &
      varies_stiffness(profile) .and. .not. varies_strength(profile) .and. .not. varies_friction(profile))
    profile%fields = stiffness(:2)
    call tests%close('size of a strength by samples', reference_strength(profile), 9.5_wp, rounding)
    call tests%check('and friction', varies_strength(profile) .and. varies_friction(profile))
  end subroutine check_sand

  !> The laws of a place by the profile and by parameters of their own, and batches of the same points.
  subroutine make_both(dimension, kinematics, stiff, factor, law, own, batch, same)
    integer, intent(in) :: dimension, kinematics
    logical, intent(in) :: stiff
    !> Share of the strength.
    real(wp), intent(in) :: factor
    class(law_type), allocatable, intent(out) :: law, own
    type(batch_type), intent(out) :: batch, same
    type(material_parameters_type) :: parameters
    type(strength_profile_type) :: profile
    type(error_type), allocatable :: error
    integer :: p

    profile = line(stiff)
    profile%factor = factor
    parameters = strong(5.0_wp, -1.0_wp)
    call new_profile_law(parameters, profile, dimension, kinematics, rate_midpoint, law, error)
    parameters%cohesion = factor*6.5_wp
    if (stiff) parameters%young = 650.0_wp
    call make_law(parameters, dimension, kinematics, rate_midpoint, own)
    call random_batch(own, 60, 0.05_wp, 5.0_wp, same)
    call random_batch(law, 60, 0.05_wp, 5.0_wp, batch)
    do p = 1, batch%count
      call law%start_at(batch%stress_start(:, p), here, batch%state_start(:, p))
    end do
  end subroutine make_both

  !> Stress, Q, tangent and state are those of the material that has the strength and stiffness of the place.
  subroutine check_law(tests, dimension, kinematics, stiff, factor)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension, kinematics
    logical, intent(in) :: stiff
    real(wp), intent(in) :: factor
    class(law_type), allocatable :: law, own
    type(batch_type) :: batch, same
    real(wp), allocatable :: tangent(:, :, :)
    real(wp) :: error
    integer :: n, compared

    call make_both(dimension, kinematics, stiff, factor, law, own, batch, same)
    n = own%state_count
    call law%update(batch, tangent_consistent)
    call own%update(same, tangent_consistent)
    call tests%check('some yield, some do not', any(batch%plastic == 1) .and. any(batch%plastic == 0))
    call tests%close('stress', maxval(abs(batch%stress - same%stress)), 0.0_wp, 1.0e-10_wp)
    call tests%close('Q', maxval(abs(batch%piola - same%piola)), 0.0_wp, 1.0e-10_wp)
    call tests%close('tangent', maxval(abs(batch%tangent - same%tangent)), 0.0_wp, 1.0e-8_wp)
    call tests%check('state of the law inside', all(abs(batch%state(:n, :) - same%state) < rounding))
    call tests%close('strength', maxval(abs(batch%state(n + 1, :) - 6.5_wp)), 0.0_wp, rounding)
    call tests%close('the start is left as it was', maxval(abs(batch%stress_start - same%stress_start)), 0.0_wp, 0.0_wp)
    call tests%close('G', law%shear_modulus(batch%stress(:, 1), batch%state(:, 1)), own%shear_scale, rounding)
    allocate (tangent, source=batch%tangent)
    call law%blend(0.25_wp)
    call own%blend(0.25_wp)
    call law%update(batch, tangent_consistent)
    call own%update(same, tangent_consistent)
    call tests%close('share of the elastic tangent', maxval(abs(batch%tangent - same%tangent)), 0.0_wp, 1.0e-8_wp)
    call difference_error(law, batch, tangent, error, compared)
    call tests%close('tangent against differences', error, 0.0_wp, 1.0e-7_wp)
    associate (ours => law%shear_compliance(batch%stress(:, 1), batch%state(:, 1), 1.1_wp, 1.0_wp), &
      theirs => own%shear_compliance(same%stress(:, 1), same%state(:, 1), 1.1_wp, 1.0_wp))
      call tests%close('compliance', maxval(abs(ours - theirs)), 0.0_wp, 1.0e-14_wp)
    end associate
  end subroutine check_law

  !> A state comes back from the fields of an average; the mean of two stresses that differ with the stiffness is one.
  subroutine check_average(tests, dimension, kinematics)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension, kinematics
    class(law_type), allocatable :: law, own
    type(batch_type) :: batch, same
    real(wp), allocatable :: fields(:, :), stress(:), state(:)
    integer :: p

    call make_both(dimension, kinematics, .true., 1.0_wp, law, own, batch, same)
    allocate (fields(law%fit_count(), 2), stress(size(batch%stress, 1)), state(law%state_count))
    batch%stress_start(4:, :) = 0.0_wp
    do p = 1, 2
      call law%start_at(batch%stress_start(:, p), here*p, batch%state_start(:, p))
      call law%to_fields(batch%stress_start(:, p), batch%state_start(:, p), fields(:, p))
    end do
    call law%from_fields(fields(:, 2), 1.0_wp, stress, state)
    call tests%close('stress comes back', maxval(abs(stress - batch%stress_start(:, 2))), 0.0_wp, rounding)
    call tests%close('state comes back', maxval(abs(state - batch%state_start(:, 2))), 0.0_wp, 1.0e-10_wp)
    call law%from_fields(0.5_wp*(fields(:, 1) + fields(:, 2)), 1.0_wp, stress, state)
    call tests%close('mean stress', maxval(abs(stress - 0.5_wp*sum(batch%stress_start(:, :2), 2))), 0.0_wp, rounding)
    fields(:, 1) = 0.0_wp
    fields(law%fit_count() - 1:, 1) = -1.0_wp
    call law%from_fields(fields(:, 1), 1.0_wp, stress, state)
    call tests%check('no negative strength nor stiffness', all(state(law%state_count - 1:) > 0.0_wp))
  end subroutine check_average

  !> Without strength the stiffness alone varies.
  subroutine check_elastic(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law, own
    type(error_type), allocatable :: error
    type(batch_type) :: batch, same
    integer :: p

    call new_profile_law(elastic(200.0_wp, 0.3_wp), line(.true.), 2, kinematics_logarithmic, rate_midpoint, law, error)
    call make_law(elastic(650.0_wp, 0.3_wp), 2, kinematics_logarithmic, rate_midpoint, own)
    call random_batch(law, 20, 0.05_wp, 5.0_wp, batch)
    call random_batch(own, 20, 0.05_wp, 5.0_wp, same)
    do p = 1, batch%count
      call law%start_at(batch%stress_start(:, p), here, batch%state_start(:, p))
    end do
    call law%update(batch, tangent_none)
    call own%update(same, tangent_none)
    call tests%close('elastic stress', maxval(abs(batch%stress - same%stress)), 0.0_wp, rounding)
    call tests%close('modulus is kept', maxval(abs(batch%state(law%state_count, :) - 650.0_wp)), 0.0_wp, rounding)
  end subroutine check_elastic

  !> The stiffness of pore water follows that of the place.
  subroutine check_water(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error
    type(undrained_type) :: undrained
    type(batch_type) :: batch

    call new_profile_law(elastic(200.0_wp, 0.3_wp), line(.true.), 2, kinematics_logarithmic, rate_midpoint, law, error)
    undrained%given = .true.
    call make_undrained(undrained, law, error)
    call random_batch(law, 1, 0.0_wp, 0.0_wp, batch)
    call law%start_at(batch%stress_start(:, 1), here, batch%state_start(:, 1))
    batch%gradient(1, 1) = exp(-0.01_wp)
    call law%update(batch, tangent_none)
    call tests%close('excess pressure', batch%state(law%state_count, 1), &
      0.01_wp*water_stiffness(undrained, 650.0_wp/2.6_wp, 0.3_wp), 1.0e-9_wp)
  end subroutine check_water
end module test_strength_profile
