!> Strength divided by a factor: the rules for c, phi, psi and the tension cut-off, Davis' factors against the closed
!> form of the strength on a slip line, and the laws that are made of it.
module test_strength_factor
  use qsmpm_kinds, only: wp, pi
  use qsmpm_active_bodies, only: materials_active
  use qsmpm_analysis, only: analysis_type
  use qsmpm_material_description, only: material_type
  use qsmpm_cam_clay, only: cam_clay_parameters_type
  use qsmpm_drucker_prager, only: drucker_prager_parameters_type
  use qsmpm_error, only: error_type
  use qsmpm_hardening_soil, only: hardening_soil_parameters_type
  use qsmpm_hardening_soil_surfaces, only: surfaces_type, make_surfaces
  use qsmpm_lowered_laws, only: lower_material
  use qsmpm_strength_factor, only: strength_factor_type, flow_material, flow_davis_a, flow_davis_b, lower_strength, &
    lower_tension, strength_constant_type, divide_constant, divide_tangent, follow_friction
  use testing, only: tests_type
  implicit none
  private

  public :: collect_strength_factor

  real(wp), parameter :: rounding = 1.0e-12_wp

contains

  !> All tests.
  subroutine collect_strength_factor(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('strength_factor')
    call check_material_flow(tests)
    call check_davis(tests)
    call check_tension(tests)
    call check_softening(tests)
    call check_profile(tests)
    call check_drucker_prager(tests)
    call check_hardening_soil(tests)
    call check_refused(tests)
    call check_named(tests)
    call check_materials_in_use(tests)
  end subroutine collect_strength_factor

  !> Strength by place is lowered as the cohesion is, by a share that leaves what points know of it.
  subroutine check_profile(tests)
    type(tests_type), intent(inout) :: tests
    type(material_type) :: material
    type(error_type), allocatable :: error

    material%young = 100.0_wp
    material%mohr_coulomb = .true.
    material%cohesion = 3.0_wp
    material%friction_angle = 30.0_wp
    material%strength_profile%given = .true.
    call lower_material(strength_factor_type(2.0_wp, flow_davis_a), material, error)
    call tests%close('share of the profile', material%strength_profile%factor, material%cohesion/3.0_wp, rounding)
    call tests%close('by Davis', material%strength_profile%factor, 0.25_wp*sqrt(3.0_wp), rounding)
  end subroutine check_profile

  !> psi stays until phi has come down to it.
  subroutine check_material_flow(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: c, phi, psi

    c = 6.0_wp
    phi = 30.0_wp
    psi = 12.0_wp
    call lower_strength(strength_factor_type(1.5_wp, flow_material), c, phi, psi)
    call tests%close('c/F', c, 4.0_wp, rounding)
    call tests%close('tan(phi)/F', tangent(phi), tangent(30.0_wp)/1.5_wp, rounding)
    call tests%close('psi stays', psi, 12.0_wp, 0.0_wp)
    call lower_strength(strength_factor_type(4.0_wp, flow_material), c, phi, psi)
    call tests%close('and is phi where phi is below it', psi, phi, 0.0_wp)
    c = 1.0_wp/3.0_wp
    phi = 31.7_wp
    call lower_strength(strength_factor_type(1.0_wp, flow_material), c, phi, psi)
    psi = 33.0_wp
    call lower_strength(strength_factor_type(1.0_wp, flow_material), c, phi, psi)
    call tests%check('F = 1 leaves every bit', .not. (abs(c - 1.0_wp/3.0_wp) > 0.0_wp .or. abs(phi - 31.7_wp) > 0.0_wp))
    call tests%close('and psi, whatever it is', psi, 33.0_wp, 0.0_wp)
  end subroutine check_material_flow

  !> Davis: on a slip line of direction psi the shear stress at failure is b (c + sigma tan phi).
  subroutine check_davis(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: c, phi, psi, normal, shear, theta, radius, centre

    c = 2.0_wp
    phi = 35.0_wp
    psi = 10.0_wp
    ! Mohr's circle at failure; strains of direction psi slip on the plane at 45 - psi/2 to the largest stress.
    centre = 7.0_wp
    radius = c*cos(phi*pi/180.0_wp) + centre*sin(phi*pi/180.0_wp)
    theta = pi/2.0_wp + psi*pi/180.0_wp
    normal = centre + radius*cos(theta)
    shear = radius*sin(theta)
    call lower_strength(strength_factor_type(1.0_wp, flow_davis_a), c, phi, psi)
    call tests%close('strength on the slip line', c + normal*tangent(phi), shear, rounding)
    call tests%close('flow is associated', psi, phi, 0.0_wp)
    c = 2.0_wp
    phi = 35.0_wp
    psi = 10.0_wp
    call lower_strength(strength_factor_type(2.0_wp, flow_davis_a), c, phi, psi)
    call tests%close('A divides the strength of F = 1', c + normal*tangent(phi), shear/2.0_wp, rounding)
    call check_davis_b(tests)
  end subroutine check_davis

  !> B takes b at the lowered angles: that of F = 1 of a soil that has them.
  subroutine check_davis_b(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: c(2), phi(2), psi(2)

    c = [3.0_wp, 1.5_wp]
    phi = [35.0_wp, angle(tangent(35.0_wp)/2.0_wp)]
    psi = 10.0_wp
    call lower_strength([strength_factor_type(2.0_wp, flow_davis_b), strength_factor_type(1.0_wp, flow_davis_b)], &
      c, phi, psi)
    call tests%close('B: cohesion', c(1), c(2), rounding)
    call tests%close('B: friction', phi(1), phi(2), rounding)
    c = 2.0_wp
    phi = 20.0_wp
    psi = 20.0_wp
    call lower_strength([strength_factor_type(3.0_wp, flow_davis_b), strength_factor_type(3.0_wp, flow_material)], &
      c, phi, psi)
    call tests%close('associated soil is not lowered beyond F', c(1), c(2), rounding)
    call tests%close('nor its friction', phi(1), phi(2), rounding)
  end subroutine check_davis_b

  !> tan of degrees, and back.
  elemental real(wp) function tangent(degrees)
    real(wp), intent(in) :: degrees

    tangent = tan(degrees*pi/180.0_wp)
  end function tangent

  !> Degrees of a slope.
  elemental real(wp) function angle(slope)
    real(wp), intent(in) :: slope

    angle = atan(slope)*180.0_wp/pi
  end function angle

  !> The tension cut-off.
  subroutine check_tension(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: strength

    strength = 6.0_wp
    call lower_tension(strength_factor_type(1.5_wp), strength)
    call tests%close('tension cut-off/F', strength, 4.0_wp, rounding)
    strength = huge(1.0_wp)
    call lower_tension(strength_factor_type(1.5_wp), strength)
    call tests%check('none stays none', .not. strength < huge(1.0_wp))
  end subroutine check_tension

  !> Peak and residual strength of softening soil.
  subroutine check_softening(tests)
    type(tests_type), intent(inout) :: tests
    type(material_type) :: material
    type(error_type), allocatable :: error

    material%mohr_coulomb = .true.
    material%cohesion = 10.0_wp
    material%friction_angle = 30.0_wp
    material%tensile_strength = 5.0_wp
    material%softening%given = .true.
    material%softening%cohesion = 2.0_wp
    material%softening%friction_angle = 20.0_wp
    material%softening%dilatancy_angle = 20.0_wp
    call lower_material(strength_factor_type(2.0_wp), material, error)
    call tests%check('Mohr-Coulomb soil is lowered', .not. allocated(error))
    call tests%close('peak cohesion', material%cohesion, 5.0_wp, rounding)
    call tests%close('peak friction', tangent(material%friction_angle), tangent(30.0_wp)/2.0_wp, rounding)
    call tests%close('tension', material%tensile_strength, 2.5_wp, rounding)
    call tests%close('residual cohesion', material%softening%cohesion, 1.0_wp, rounding)
    call tests%close('residual friction', tangent(material%softening%friction_angle), tangent(20.0_wp)/2.0_wp, rounding)
    call tests%close('residual dilatancy', material%softening%dilatancy_angle, material%softening%friction_angle, 0.0_wp)
  end subroutine check_softening

  !> The cone is that of the lowered Mohr-Coulomb soil.
  subroutine check_drucker_prager(tests)
    type(tests_type), intent(inout) :: tests
    type(drucker_prager_parameters_type) :: cone
    type(error_type), allocatable :: error

    cone = drucker_prager_parameters_type(200.0_wp, 0.3_wp, 4.0_wp, 30.0_wp, 0.0_wp)
    call cone%lower(strength_factor_type(2.0_wp), error)
    call tests%close('cohesion of the cone', cone%cohesion, 2.0_wp, rounding)
    call tests%close('friction of the cone', tangent(cone%friction_angle), tangent(30.0_wp)/2.0_wp, rounding)
  end subroutine check_drucker_prager

  !> Cone lowered, apex and cap where they were.
  subroutine check_hardening_soil(tests)
    type(tests_type), intent(inout) :: tests
    type(hardening_soil_parameters_type) :: soil
    type(surfaces_type) :: before, after
    type(error_type), allocatable :: error
    real(wp) :: s

    soil%e50 = 3.0e4_wp
    soil%eoed = 3.0e4_wp
    soil%eur = 9.0e4_wp
    soil%power = 0.5_wp
    soil%cohesion = 7.0_wp
    soil%friction_angle = 35.0_wp
    soil%dilatancy_angle = 5.0_wp
    call make_surfaces(soil, before, error)
    call soil%lower(strength_factor_type(2.0_wp), error)
    call make_surfaces(soil, after, error)
    s = sin(angle(tangent(35.0_wp)/2.0_wp)*pi/180.0_wp)
    call tests%check('the soil is lowered', .not. allocated(error))
    call tests%close('strength of the cone', after%strength, 2.0_wp*s/(1.0_wp - s), rounding)
    call tests%close('asymptote with it', after%asymptote/after%strength, before%asymptote/before%strength, rounding)
    call tests%close('critical friction by psi', (after%friction - after%critical)/(1.0_wp - after%friction*after%critical), &
      sin(5.0_wp*pi/180.0_wp), rounding)
    call tests%close('the apex stays', after%shift, before%shift, 0.0_wp)
    call tests%check('so does the cap', .not. (abs(after%cap2 - before%cap2) > 0.0_wp .or. &
      abs(after%hardening - before%hardening) > 0.0_wp .or. abs(after%k0 - before%k0) > 0.0_wp))
  end subroutine check_hardening_soil

  !> Laws whose strength is not known.
  subroutine check_refused(tests)
    type(tests_type), intent(inout) :: tests
    type(material_type) :: material
    type(error_type), allocatable :: error

    allocate (material%soil_law, source=cam_clay_parameters_type())
    call lower_material(strength_factor_type(2.0_wp), material, error)
    call tests%check('a law that says of no strength is refused by name', allocated(error))
    if (allocated(error)) call tests%check('with its card: '//error%message, index(error%message, '*CAM CLAY ') == 1)
    deallocate (material%soil_law)
    material%own_law = .true.
    call lower_material(strength_factor_type(2.0_wp), material, error)
    call tests%check('so is a law of the program', allocated(error))
    material%own_law = .false.
    material%user%given = .true.
    call lower_material(strength_factor_type(2.0_wp), material, error)
    call tests%check('and a model of the user', allocated(error))
  end subroutine check_refused

  !> Constants that the user names: of a UMAT by number, as a value or as an angle, and M of Cam-Clay alone.
  subroutine check_named(tests)
    type(tests_type), intent(inout) :: tests
    type(material_type) :: material, clay
    type(cam_clay_parameters_type) :: parameters
    type(error_type), allocatable :: error

    material%user%given = .true.
    material%user%constants = [1000.0_wp, 0.3_wp, 6.0_wp, 30.0_wp, 25.0_wp, 40.0_wp]
    material%strength_constants = [strength_constant_type(5, follow_friction), strength_constant_type(3, &
      divide_constant), strength_constant_type(4, divide_tangent), strength_constant_type(6, divide_tangent)]
    call lower_material(strength_factor_type(2.0_wp), material, error)
    associate (c => material%user%constants)
      call tests%close('constants that are not named stay', c(1), 1000.0_wp, 0.0_wp)
      call tests%close('DIVIDE', c(3), 3.0_wp, rounding)
      call tests%close('TAN', tangent(c(4)), 0.5_wp*tangent(30.0_wp), rounding)
      call tests%close('the other TAN', tangent(c(6)), 0.5_wp*tangent(40.0_wp), rounding)
      call tests%close('DILATANCY comes down with the smallest of them, whatever the order', c(5), c(4), 0.0_wp)
    end associate
    call lower_material(strength_factor_type(2.0_wp, flow_davis_a), material, error)
    call tests%check('no flow of Davis for a model of the user', allocated(error))
    parameters%slope = 1.2_wp
    allocate (clay%soil_law, source=parameters)
    clay%strength_constants = [strength_constant_type(1, divide_constant)]
    call lower_material(strength_factor_type(1.5_wp), clay, error)
    select type (law => clay%soil_law)
    type is (cam_clay_parameters_type)
      call tests%close('M/F', law%slope, 0.8_wp, rounding)
    end select
    clay%strength_constants%number = 2
    call lower_material(strength_factor_type(1.5_wp), clay, error)
    call tests%check('lambda is no strength', allocated(error))
  end subroutine check_named

  !> Materials that bodies are of in a phase: not those that a phase before has changed, nor of bodies that are gone.
  subroutine check_materials_in_use(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: analysis
    character(len=*), parameter :: names = 'abc'
    integer :: i

    allocate (analysis)
    allocate (analysis%bodies(2), analysis%materials(3), analysis%phases(3))
    do i = 1, 3
      analysis%materials(i)%name = names(i:i)
      analysis%phases(i)%name = names(i:i)
      allocate (analysis%phases(i)%materials(merge(1, 0, i == 2)), analysis%phases(i)%deactivations(merge(1, 0, i == 3)))
    end do
    do i = 1, 2
      analysis%bodies(i)%name = names(i:i)
      analysis%bodies(i)%material = names(i:i)
    end do
    analysis%phases(2)%materials(1)%body = 'a'
    analysis%phases(2)%materials(1)%material = 'c'
    analysis%phases(3)%deactivations(1)%body = 'b'
    call tests%check('at first those of the bodies', all(materials_active(analysis, 1) .eqv. [.true., .true., .false.]))
    call tests%check('a changed for c', all(materials_active(analysis, 2) .eqv. [.false., .true., .true.]))
    call tests%check('then b taken out', all(materials_active(analysis, 3) .eqv. [.false., .false., .true.]))
    analysis%phases(3)%parent = 'a'
    call tests%check('of another line a is what it was', all(materials_active(analysis, 3) .eqv. &
      [.true., .false., .false.]))
  end subroutine check_materials_in_use
end module test_strength_factor
