!> Warnings of magnitudes that suggest a wrong unit: unit weights with respect to *UNITS and gravity, angles in radians,
!> strengths relative to the stiffness. Each reports the value and the usual range; nothing is converted.
module qsmpm_deck_magnitudes
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_material_description, only: material_type, may_yield, traits_of
  use qsmpm_source_line, only: source_line_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_strength_profile, only: follows_stress, reference_strength
  use qsmpm_value_field, only: field_young, has_values
  implicit none
  private

  public :: check_magnitudes, check_strengths

  !> Known units, in kN and m.
  character(len=3), parameter :: forces(7) = ['N  ', 'kN ', 'MN ', 'GN ', 'lb ', 'lbf', 'kip'], &
    lengths(6) = ['mm', 'cm', 'm ', 'km', 'in', 'ft']
  real(wp), parameter :: pound = 4.4482216152605e-3_wp, kilonewtons(7) = [1.0e-3_wp, 1.0_wp, 1.0e3_wp, 1.0e6_wp, &
    pound, pound, 1.0e3_wp*pound], metres(6) = [1.0e-3_wp, 1.0e-2_wp, 1.0_wp, 1.0e3_wp, 2.54e-2_wp, 0.3048_wp]
  !> Standard gravity in m/s2 and its tolerance; ranges in kN/m3 of the unit weight of water, of unit weights of
  !> materials, and of values that are unit weights rather than densities where gravity is an acceleration (steel of
  !> 7.85 t/m3 is not).
  real(wp), parameter :: standard = 9.81_wp, near_standard = 0.1_wp, water(2) = [9.0_wp, 11.0_wp], &
    material_weight(2) = [0.1_wp, 100.0_wp], heavy(2) = [7.9_wp, 100.0_wp]
  !> Angles in degrees below this value are probably meant in radians.
  real(wp), parameter :: least_angle = 1.0_wp
  !> Range of Young's modulus over undrained strength, and smallest ratio to a cohesion with friction.
  real(wp), parameter :: undrained_ratio(2) = [100.0_wp, 2.0e4_wp], least_ratio = 50.0_wp, rounding = 1.0e-9_wp

contains

  !> Checks all magnitudes of an analysis.
  subroutine check_magnitudes(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    call check_strengths(state)
    call check_weights(state)
    do i = 1, size(state%analysis%contacts)
      associate (contact => state%analysis%contacts(i))
        call check_angle(state, contact%friction_angle, contact%where, 'CONTACT', 'the interface')
      end associate
    end do
  end subroutine check_magnitudes

  !> Checks angles and strengths of the materials.
  subroutine check_strengths(state)
    type(deck_state_type), intent(inout) :: state
    type(law_description_type) :: traits
    integer :: i

    do i = 1, size(state%analysis%materials)
      associate (material => state%analysis%materials(i))
        traits = traits_of(material)
        call check_angle(state, traits%friction_angle, material%where, 'MATERIAL', "material '"//material%name//"'")
        if (material%mohr_coulomb .and. material%young > 0.0_wp) call check_strength(state, material)
      end associate
    end do
  end subroutine check_strengths

  !> Checks that an angle is in degrees.
  subroutine check_angle(state, angle, where, keyword, of_what)
    type(deck_state_type), intent(inout) :: state
    real(wp), intent(in) :: angle
    type(source_line_type), intent(in) :: where
    character(len=*), intent(in) :: keyword, of_what
    real(wp), parameter :: degree = 180.0_wp/acos(-1.0_wp)

    if (.not. angle > 0.0_wp .or. angle >= least_angle) return
    call state%warn(where, keyword, of_what//' has a friction angle of '//rounded_text(angle)// &
      ' degrees; 10 to 45 is usual, and 0 for undrained clay ('//rounded_text(angle)//' in radians is '// &
      rounded_text(angle*degree, 3)//' degrees)')
  end subroutine check_angle

  !> Checks the strength relative to the stiffness; for clay without friction in both directions.
  subroutine check_strength(state, material)
    type(deck_state_type), intent(inout) :: state
    type(material_type), intent(in) :: material
    real(wp) :: strength
    logical :: undrained

    undrained = .not. material%friction_angle > 0.0_wp
    strength = material%cohesion
    strength = max(strength, reference_strength(material%strength_profile))
    if (material%strength_profile%given .and. (material%strength_profile%stiffness_ratio > 0.0_wp .or. &
      follows_stress(material%strength_profile))) return
    if (has_values(material%strength_profile%fields, field_young)) return
    if (undrained .and. strength > 0.0_wp) then
      if (strength*undrained_ratio(1) > material%young*(1.0_wp + rounding) .or. &
        strength*undrained_ratio(2) < material%young) call state%warn(material%where, 'MATERIAL', "material '"// &
        material%name//"' has an undrained strength of "//rounded_text(strength)//" beside a Young's modulus of "// &
        rounded_text(material%young)//': E/s_u is '//rounded_text(material%young/strength, 3)// &
        ', 100 to 2000 is usual; are both in the same unit?')
    else if (strength*least_ratio > material%young*(1.0_wp + rounding)) then
      call state%warn(material%where, 'MATERIAL', "material '"//material%name//"' has a cohesion of "// &
        rounded_text(strength)//" beside a Young's modulus of "//rounded_text(material%young)//': E/c is '// &
        rounded_text(material%young/strength, 3)//', above 100 is usual; are both in the same unit?')
    end if
  end subroutine check_strength

  !> Checks the unit weights of soil and water, each in the given units and relative to each other.
  subroutine check_weights(state)
    type(deck_state_type), intent(inout) :: state
    real(wp) :: unit, density, water_weight
    integer :: i, p

    call find_units(state%analysis, unit, density)
    water_weight = 0.0_wp
    do p = 1, size(state%analysis%phases)
      do i = 1, size(state%analysis%phases(p)%water_levels)
        associate (level => state%analysis%phases(p)%water_levels(i))
          if (level%none) cycle
          water_weight = max(water_weight, level%unit_weight)
          if (unit > 0.0_wp) call check_water_weight(state, level%unit_weight, unit, density, level%where)
        end associate
      end do
    end do
    do i = 1, size(state%analysis%materials)
      call check_weight(state, state%analysis%materials(i), unit, density)
      call check_saturated(state, state%analysis%materials(i), water_weight)
      if (water_weight > 0.0_wp) call check_buoyancy(state, state%analysis%materials(i), water_weight)
    end do
  end subroutine check_weights

  !> Determines the unit of weights in kN/m3, 0 if unknown, and the acceleration that is given as *GRAVITY instead of a
  !> fraction of the weight, in m/s2 where units are unknown; 0 for a fraction.
  pure subroutine find_units(analysis, unit, density)
    type(analysis_type), intent(in) :: analysis
    real(wp), intent(out) :: unit, density
    real(wp) :: length, gravity
    integer :: f, l, p

    unit = 0.0_wp
    length = 1.0_wp
    if (allocated(analysis%force_unit) .and. allocated(analysis%length_unit)) then
      f = findloc(forces == analysis%force_unit, .true., dim=1)
      l = findloc(lengths == analysis%length_unit, .true., dim=1)
      if (f > 0 .and. l > 0) then
        length = metres(l)
        unit = kilonewtons(f)/length**3
      end if
    end if
    density = 0.0_wp
    do p = 1, size(analysis%phases)
      gravity = norm2(analysis%phases(p)%gravity%vector)
      if (abs(gravity*length - standard) < near_standard*standard) density = gravity
    end do
  end subroutine find_units

  !> Checks the unit weight of water.
  subroutine check_water_weight(state, weight, unit, density, where)
    type(deck_state_type), intent(inout) :: state
    real(wp), intent(in) :: weight, unit, density
    type(source_line_type), intent(in) :: where
    real(wp) :: real_weight

    real_weight = weight*unit*merge(density, 1.0_wp, density > 0.0_wp)
    if (real_weight >= water(1) .and. real_weight <= water(2)) return
    call state%warn(where, 'WATER LEVEL', 'UNIT WEIGHT='//rounded_text(weight)//by_gravity(density)//' in '// &
      names(state%analysis)//' is '//rounded_text(real_weight)//' kN/m3; water weighs 9.81')
  end subroutine check_water_weight

  !> Checks that the unit weight of a material is in the usual range and not multiplied by an acceleration.
  subroutine check_weight(state, material, unit, density)
    type(deck_state_type), intent(inout) :: state
    type(material_type), intent(in) :: material
    real(wp), intent(in) :: unit, density
    real(wp) :: weight, known

    known = merge(unit, 1.0_wp, unit > 0.0_wp)
    weight = material%unit_weight*known
    if (.not. weight > 0.0_wp) return
    if (density > 0.0_wp .and. weight >= heavy(1) .and. weight <= heavy(2)) then
      call state%warn(material%where, 'MATERIAL', "material '"//material%name//"' has a unit weight of "// &
        rounded_text(material%unit_weight)//', and *GRAVITY multiplies it by '//rounded_text(density)//': with '// &
        'unit weights of 10 to 25 kN/m3 it is a direction of length 1; an acceleration requires densities of 1 to '// &
        '2.5 t/m3')
      return
    end if
    if (.not. unit > 0.0_wp) return
    weight = weight*merge(density, 1.0_wp, density > 0.0_wp)
    if (weight >= material_weight(1) .and. weight <= material_weight(2)) return
    call state%warn(material%where, 'MATERIAL', "material '"//material%name//"' has a unit weight of "// &
      rounded_text(material%unit_weight)//by_gravity(density)//' in '//names(state%analysis)//', which is '// &
      rounded_text(weight)//' kN/m3; 10 to 25 is usual')
  end subroutine check_weight

  !> Checks that the saturated weight exceeds the other one; buoyant soil has its own warning (check_buoyancy).
  subroutine check_saturated(state, material, water_weight)
    type(deck_state_type), intent(inout) :: state
    type(material_type), intent(in) :: material
    real(wp), intent(in) :: water_weight

    if (material%saturated_weight < water_weight .or. material%saturated_weight >= material%unit_weight) return
    call state%warn(material%where, 'MATERIAL', "material '"//material%name//"' weighs "// &
      rounded_text(material%saturated_weight)//' below the water level and '//rounded_text(material%unit_weight)// &
      ' above: gamma_sat is the saturated unit weight; do not subtract buoyancy')
  end subroutine check_saturated

  !> Checks that soil below water is heavier than water.
  subroutine check_buoyancy(state, material, water_weight)
    type(deck_state_type), intent(inout) :: state
    type(material_type), intent(in) :: material
    real(wp), intent(in) :: water_weight
    real(wp) :: weight

    weight = material%unit_weight
    if (material%saturated_weight >= 0.0_wp) weight = material%saturated_weight
    if (weight >= water_weight .or. .not. (weight > 0.0_wp .and. may_yield(material))) return
    call state%warn(material%where, 'MATERIAL', "material '"//material%name//"' weighs "//rounded_text(weight)// &
      ' below the water level and water '//rounded_text(water_weight)//': it floats; gamma_sat is the saturated '// &
      'unit weight, 1.6 to 2.3 times that of water; do not subtract buoyancy')
  end subroutine check_buoyancy

  !> Returns the text on the factor by which gravity multiplies a density.
  pure function by_gravity(density) result(text)
    real(wp), intent(in) :: density
    character(len=:), allocatable :: text

    text = ''
    if (density > 0.0_wp) text = ' times '//rounded_text(density)//' of *GRAVITY'
  end function by_gravity

  !> Returns the names of the units.
  pure function names(analysis) result(text)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: text

    text = analysis%force_unit//' and '//analysis%length_unit
  end function names
end module qsmpm_deck_magnitudes
