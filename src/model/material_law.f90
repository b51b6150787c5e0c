!> Creates the law of a material of the deck: a user model, a soil law, or elasticity with strength; with pore water if
!> undrained. Checks the cell size against softening.
!>
!> Also checks strength profiles and fields of values against the bodies that use them: the strength must not be
!> negative at any point. The log reports the range over the material and points far outside the samples of a field.
!> The mean of a varying stiffness is used to scale the stabilisation.
module qsmpm_material_law
  use qsmpm_material_description, only: material_type
  use qsmpm_method_description, only: method_type, stress_rate_cauchy
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type
  use qsmpm_law_factory, only: new_law, rate_paper, rate_paper_cauchy, rate_midpoint_cauchy
  use qsmpm_profile_law, only: new_profile_law
  use qsmpm_strength_profile, only: is_by_place, strength_profile_type, follows_stress, strength_at, varies_stiffness, &
    young_at
  use qsmpm_undrained_law, only: make_undrained
  use qsmpm_undrained_parameters, only: undrained_c, undrained_ratio
  use qsmpm_user_material_law, only: new_user_law
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_material_parameters, only: material_parameters_type, check_parameters
  use qsmpm_mesh_measure, only: cell_width
  use qsmpm_model, only: model_type
  use qsmpm_softening, only: band_ratio, nonlocal_length
  use qsmpm_softening_model, only: softening_model_type, set_softening, largest_band_ratio
  use qsmpm_team, only: largest_of_all => largest, team_type, smallest, largest, total, spread_from
  use qsmpm_rounded_text, only: rounded_text, rounded_place
  use qsmpm_agreement, only: lowest_rank
  use qsmpm_own_part, only: own_of
  use qsmpm_points, only: place_of
  use qsmpm_text, only: integer_text
  use qsmpm_value_field, only: distance_beyond, field_words, value_between, value_field_type
  implicit none
  private

  public :: make_material_law, check_softening_cells, check_strength_profiles

  !> Distance from the nearest sample, in sample spacings, above which a point is reported.
  real(wp), parameter :: beyond = 1.0_wp

contains

  !> Creates the law of a material.
  subroutine make_material_law(material, method, stress, dimension, law, error)
    type(material_type), intent(in) :: material
    !> Kinematics and rate.
    type(method_type), intent(in) :: method
    !> Initial Cauchy stress of the material or a typical one (6).
    real(wp), intent(in) :: stress(6)
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> The law, with its consistent tangent.
    class(law_type), allocatable, intent(out) :: law
    !> Set when a parameter is out of range.
    type(error_type), allocatable, intent(out) :: error
    type(strength_profile_type) :: profile
    integer :: rate

    if (material%user%given) then
      call new_user_law(material%user, material%name, material%young, material%poisson, stress, dimension, law, error)
    else if (allocated(material%soil_law)) then
      call new_law(material%soil_law, dimension, method%kinematics, method%rate, law, error)
    else
      rate = method%rate
      if (method%stress_rate == stress_rate_cauchy) rate = merge(rate_paper_cauchy, rate_midpoint_cauchy, &
        rate == rate_paper)
      if (is_by_place(material%strength_profile)) then
        profile = material%strength_profile
        profile%least = material%cohesion/profile%factor
        profile%young = material%young
        if (profile%dilatancy_angle < 0.0_wp) profile%dilatancy_angle = material%dilatancy_angle
        profile%overconsolidation = material%at_rest%overconsolidation
        profile%pre_overburden = material%at_rest%pre_overburden
        call new_profile_law(parameters_of(material), profile, dimension, method%kinematics, rate, law, error)
      else
        call new_law(parameters_of(material), dimension, method%kinematics, rate, law, error)
      end if
    end if
    if (allocated(error)) return
    ! Quantities scaled by the stiffness are equal for total and effective stress analysis of a material.
    if (material%undrained%given .and. material%undrained%kind == undrained_c) law%stiffness_scale = &
      law%stiffness_scale*(1.0_wp + material%poisson)/(1.0_wp + undrained_ratio(material%undrained, material%poisson))
    call make_undrained(material%undrained, law, error)
  end subroutine make_material_law

  !> Returns the parameters of a material; in total stress analysis with the shear modulus of the skeleton and nu_u.
  pure type(material_parameters_type) function parameters_of(material) result(parameters)
    !> The material as defined in the deck.
    type(material_type), intent(in) :: material

    parameters = material_parameters_type(young=material%young, poisson=material%poisson, &
      mohr_coulomb=material%mohr_coulomb, cohesion=material%cohesion, friction_angle=material%friction_angle, &
      dilatancy_angle=material%dilatancy_angle, tensile_strength=material%tensile_strength, &
      softening=material%softening)
    if (.not. (material%undrained%given .and. material%undrained%kind == undrained_c)) return
    parameters%poisson = undrained_ratio(material%undrained, material%poisson)
    parameters%young = material%young*(1.0_wp + parameters%poisson)/(1.0_wp + material%poisson)
  end function parameters_of

  !> Rejects cells in which a softening point would snap back without confinement. With decreasing friction,
  !> confinement lowers the bound; the law reports this when it occurs.
  subroutine check_softening_cells(model, diagnostics)
    !> The model with its points; notes are added where cells are too wide for a nonlocal strain.
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: m

    do m = 1, size(model%analysis%materials)
      associate (material => model%analysis%materials(m))
        if (material%softening%given) call check_material(model, m, material, diagnostics)
      end associate
    end do
  end subroutine check_softening_cells

  !> Checks a softening material.
  subroutine check_material(model, number, material, diagnostics)
    type(model_type), intent(inout) :: model
    !> Number of the material.
    integer, intent(in) :: number
    type(material_type), intent(in) :: material
    type(diagnostics_type), intent(inout) :: diagnostics
    type(softening_model_type) :: softening
    type(error_type), allocatable :: error
    real(wp) :: largest, bound
    integer :: p

    call check_parameters(parameters_of(material), error)
    if (allocated(error)) return
    call set_softening(parameters_of(material), softening)
    largest = 0.0_wp
    do p = 1, model%state%points%count
      if (model%state%points%material(p) == number) &
        largest = max(largest, cell_width(model%mesh, model%state%points%cell(p)))
    end do
    largest = largest_of_all(model%part%team, largest)
    if (softening%softening%nonlocal) then
      call note_wide_cells(model, softening, material%name, largest)
      if (largest <= softening%coarsest_cell) return
    end if
    bound = largest_band_ratio(softening)
    if (band_ratio(softening%softening, largest) <= bound .or. .not. largest > 0.0_wp) return
    if (softening%softening%by_cell) then
      call add_diagnostic(diagnostics, material%where, '*SOFTENING', "material '"//material%name// &
        "' softens too fast for its cells, which would snap back at a point: cell size "// &
        rounded_text(largest, 3)//', at most '// &
        rounded_text(bound*softening%softening%length, 3))
    else
      call add_diagnostic(diagnostics, material%where, '*SOFTENING', "material '"//material%name// &
        "' softens too fast, and would snap back at a point: plastic shear strain at least "// &
        rounded_text(softening%softening%strain/bound, 3))
    end if
  end subroutine check_material

  !> Adds notes where cells are too wide for a nonlocal strain, at the start and on a subsequent grid.
  subroutine note_wide_cells(model, softening, name, largest)
    type(model_type), intent(inout) :: model
    type(softening_model_type), intent(in) :: softening
    !> Name of the material; size of its largest cell.
    character(len=*), intent(in) :: name
    real(wp), intent(in) :: largest
    character(len=:), allocatable :: start

    start = "warning: material '"//name//"': REGULARISATION=NONLOCAL of *SOFTENING, l = "// &
      rounded_text(nonlocal_length(softening%softening), 3)//', requires cells of '// &
      rounded_text(softening%coarsest_cell, 3)//' and less; '
    if (largest > softening%coarsest_cell) model%notes = model%notes//start//'in wider ones, here up to '// &
      rounded_text(largest, 3)//', strain counts by the size of the cell (CELL)'//new_line('a')
    if (.not. allocated(model%analysis%backgrounds)) return
    associate (cell => model%analysis%backgrounds(2)%cell_size)
      if (cell > softening%coarsest_cell) model%notes = model%notes//start//'on the grid that follows the '// &
        'triangles, of '//rounded_text(cell, 3)//', strain counts by the size of the cell (CELL)'//new_line('a')
    end associate
  end subroutine note_wide_cells

  !> Checks the profiles of all materials.
  subroutine check_strength_profiles(model, diagnostics)
    !> The model with its points.
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: m, i, k

    do m = 1, size(model%analysis%materials)
      associate (profile => model%analysis%materials(m)%strength_profile)
        if (is_by_place(profile) .and. .not. follows_stress(profile)) call check_strength_profile(model, m, diagnostics)
        if (.not. allocated(profile%fields)) cycle
        do i = 1, size(profile%fields)
          ! The file of an earlier field has been reported already.
          call tell_field(model, m, profile%fields(i), any([(profile%fields(k)%file == profile%fields(i)%file, &
            k=max(1, i - 1), i - 1)]))
        end do
      end associate
    end do
  end subroutine check_strength_profiles

  !> Checks the profile of a material.
  subroutine check_strength_profile(model, number, diagnostics)
    type(model_type), intent(inout) :: model
    !> Number of the material.
    integer, intent(in) :: number
    type(diagnostics_type), intent(inout) :: diagnostics
    real(wp) :: strength(2), young(2), place(3), lowest(3), mean(2), value
    logical :: own(model%state%points%count)
    integer :: p

    strength = [huge(1.0_wp), -huge(1.0_wp)]
    young = strength
    mean = 0.0_wp
    lowest = 0.0_wp
    own = own_of(model%part%points, size(own))
    associate (material => model%analysis%materials(number), points => model%state%points)
      do p = 1, points%count
        if (points%material(p) /= number .or. .not. own(p)) cycle
        place = place_of(points, p)
        value = strength_at(material%strength_profile, place)
        if (value < strength(1)) lowest = place
        strength = [min(strength(1), value), max(strength(2), value)]
        if (.not. varies_stiffness(material%strength_profile)) cycle
        value = young_at(material%strength_profile, place)
        young = [min(young(1), value), max(young(2), value)]
        mean = mean + points%volume(p)*[1.0_wp, value]
      end do
      call take_range(model%part%team, strength, lowest)
      call take_range(model%part%team, young, place)
      mean = total(model%part%team, mean)
      if (strength(2) < strength(1)) return
      if (strength(1) < 0.0_wp .or. (varies_stiffness(material%strength_profile) .and. .not. young(1) > 0.0_wp)) then
        call add_diagnostic(diagnostics, material%profile_where, '*STRENGTH PROFILE', "material '"//material%name// &
          "': the strength is "//rounded_text(strength(1))//' inside the body, at '//rounded_place(lowest)//': it '// &
          'must not be negative, nor zero with a STIFFNESS RATIO')
        return
      end if
      if (mean(1) > 0.0_wp) then
        ! The mean stiffness scales the stabilisation, in this law and in laws created from the material later.
        value = material%young
        if (material%strength_profile%mean_young > 0.0_wp) value = material%strength_profile%mean_young
        material%strength_profile%mean_young = mean(2)/mean(1)
        associate (law => model%laws(number)%law, now => material%strength_profile%mean_young)
          law%shear_scale = law%shear_scale*now/value
          law%stiffness_scale = law%stiffness_scale*now/value
        end associate
      end if
      if (.not. material%strength_profile%given) return
      model%notes = model%notes//"material '"//material%name//"': strength from "// &
        rounded_text(max(material%cohesion, strength(1)))//' to '//rounded_text(max(material%cohesion, strength(2)))
      if (varies_stiffness(material%strength_profile)) model%notes = model%notes//", Young's modulus from "// &
        rounded_text(young(1))//' to '//rounded_text(young(2))
      model%notes = model%notes//new_line('a')
    end associate
  end subroutine check_strength_profile

  !> Reports the range of a field over the points of a material and the points far outside its samples.
  subroutine tell_field(model, number, field, is_told)
    type(model_type), intent(inout) :: model
    !> Number of the material.
    integer, intent(in) :: number
    type(value_field_type), intent(in) :: field
    !> Whether its file has been reported already.
    logical, intent(in) :: is_told
    real(wp) :: range(2), place(3), far(3), reach
    integer :: p, outside(2)

    range = [huge(1.0_wp), -huge(1.0_wp)]
    outside = 0
    reach = -1.0_wp
    far = 0.0_wp
    place = 0.0_wp
    associate (points => model%state%points, material => model%analysis%materials(number), own => &
        own_of(model%part%points, model%state%points%count))
      do p = 1, points%count
        if (points%material(p) /= number .or. .not. own(p)) cycle
        place = place_of(points, p)
        associate (value => value_between(field, place(:size(field%places, 1))))
          range = [min(range(1), value), max(range(2), value)]
        end associate
        outside = outside + [1, merge(1, 0, distance_beyond(field, place) > beyond)]
        if (.not. distance_beyond(field, place) > reach) cycle
        reach = distance_beyond(field, place)
        far = place
      end do
      outside = nint(total(model%part%team, real(outside, wp)))
      call take_range(model%part%team, range, place)
      if (range(2) < range(1)) return
      model%notes = model%notes//"material '"//material%name//"': "//trim(field_words(field%parameter))//' from '// &
        rounded_text(range(1))//' to '//rounded_text(range(2))//' by place'//new_line('a')
      if (outside(2) == 0 .or. is_told) return
      range = -reach
      call take_range(model%part%team, range, far)
      model%notes = model%notes//"warning: *FIELD OF VALUES: "//integer_text(outside(2))//' of '// &
        integer_text(outside(1))//" points of material '"//material%name//"' are outside the range of the "// &
        "samples of '"// &
        field%file//"', as at "//rounded_place(far)//', where the nearest samples are used'//new_line('a')
    end associate
  end subroutine tell_field

  !> Returns the range over all processes and the location of its lower end.
  subroutine take_range(team, range, place)
    type(team_type), intent(in) :: team
    !> Range of this process on entry, of all processes on return.
    real(wp), intent(inout) :: range(2)
    real(wp), contiguous, intent(inout) :: place(:)
    real(wp) :: least
    integer :: rank

    least = smallest(team, range(1))
    rank = lowest_rank(team, range(1) <= least)
    range = [least, largest(team, range(2))]
    if (rank < team%ranks) call spread_from(team, rank, place)
  end subroutine take_range
end module qsmpm_material_law
