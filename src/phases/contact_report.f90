!> Warnings about the forces on the rigid bodies of a phase, printed at its end: a body that moves without contact, or
!> that carries no force although soil is inside it; and a force against a steady motion that decreases in a step and
!> remains low. For prescribed nodal displacements it warns of a loss of most of the reaction, and of a reaction that
!> continues to increase long after clay has failed.
module qsmpm_contact_report
  use qsmpm_kinds, only: wp
  use qsmpm_contact_results, only: deepest_in
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_material_description, only: may_yield, traits_of
  use qsmpm_mesh_measure, only: cell_width
  use qsmpm_method_description, only: basis_fem, basis_standard
  use qsmpm_model, only: model_type
  use qsmpm_observer, only: observer_type
  use qsmpm_own_part, only: own_of
  use qsmpm_points, only: place_of
  use qsmpm_rigid_bodies, only: force_on_body, motion_in_phase, placed_bodies
  use qsmpm_rigid_pose, only: placed_shape_type, rigid_pose_type
  use qsmpm_rigid_shape, only: distance_type
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_sheared_ground, only: most_blur
  use qsmpm_step_length, only: phase_is_complete
  use qsmpm_team, only: largest, smallest, total
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: contact_check_type, begin_contact_check, check_contact, end_contact_check, apart_text

  !> Decrease of a force in a step above which a warning is printed, relative to its value before: on a body, and at
  !> nodes with prescribed displacements, where softening soil may lose some; share of the largest force of the phase
  !> below which a decrease is ignored.
  real(wp), parameter :: much_of_body = 0.05_wp, much_of_nodes = 0.5_wp, little = 0.1_wp
  !> Force at nodes taken as zero, such as that due to the tolerance, over stiffness and the face of a cell.
  real(wp), parameter :: slight = 1.0e-4_wp
  !> Decrease from a maximum that counts as a wave, relative to the largest force; half of it must be recovered.
  real(wp), parameter :: deep = 0.05_wp
  !> Slope of the reaction relative to the steepest one below which soil has failed, and further increase that is
  !> reported: a footing on clay rises by 5 % more, with cells dragged along by the displaced nodes over a third of
  !> their width by 25 %.
  real(wp), parameter :: knee_slope = 0.1_wp, much_of_knee = 0.1_wp
  !> Distance in cells over which the force on a body is followed after failure: over more it increases with its depth.
  real(wp), parameter :: shallow = 0.25_wp
  !> Possible error of a load at failure from which it is reported, and from which it is a warning.
  real(wp), parameter :: much_of_blur = 0.05_wp, far_too_much = 0.1_wp
  !> The same error times the number of cells where ground follows a wall that is drawn away from it, and is restrained
  !> at its foot.
  real(wp), parameter :: blur_of_active = 1.5_wp
  !> Gap and depth in cell sizes: soil closer than the gap is in contact, soil deeper than the depth is inside.
  real(wp), parameter :: touching = 1.0e-3_wp, inside = 0.1_wp

  !> Force history of one body in a phase, or of all prescribed displacements.
  type :: course_type
    !> Decrease of its force above which a warning is printed.
    real(wp) :: much = much_of_body
    !> It has carried a force, before the phase or in it.
    logical :: touched = .false.
    !> Distance to the soil at the start of the phase.
    real(wp) :: gap = 0.0_wp
    !> Force against its motion in the two previous steps, below 0 for none, and the largest one.
    real(wp) :: before(2) = -1.0_wp, most = 0.0_wp
    !> The last step if the force is low in it, 0 if not; the force, the previous one, and the lower one of the two
    !> previous.
    integer :: dip = 0
    real(wp) :: low = 0.0_wp, last = 0.0_wp, high = 0.0_wp
    !> Number of decreases; for the largest one the step and the forces before and after it.
    integer :: falls = 0, step = 0
    real(wp) :: from = 1.0_wp, to = 1.0_wp
    !> Number of waves, last maximum and lowest force after it, and both values of the largest wave.
    integer :: waves = 0
    real(wp) :: crest = 0.0_wp, trough = 0.0_wp, of_largest(2) = 0.0_wp
    !> Completed share of the phase and the force there, the steepest slope, the force and the share at which the slope
    !> had decreased, 0 if not yet, and the largest force that counts since then.
    real(wp) :: done = 0.0_wp, reached = 0.0_wp, steepest = 0.0_wp, knee = 0.0_wp, failed = 0.0_wp, since = 0.0_wp
  end type course_type

  !> Force histories of the bodies in a phase.
  type :: contact_check_type
    private
    type(course_type), allocatable :: of(:)
    type(course_type) :: nodes
  end type contact_check_type

contains

  !> Initialises the check at the start of a phase, or where it is resumed.
  subroutine begin_contact_check(model, check)
    type(model_type), intent(in) :: model
    type(contact_check_type), intent(out) :: check
    real(wp) :: width, cell
    integer :: b

    allocate (check%of(size(model%rigid_shapes)))
    check%nodes%much = much_of_nodes
    check%nodes%most = least_force(model)
    check%nodes%done = model%state%progress%fraction
    check%nodes%reached = force_of_push(model)
    do b = 1, size(check%of)
      check%of(b)%touched = any(abs(force_on_body(model, b)) > 0.0_wp)
      check%of(b)%done = model%state%progress%fraction
      check%of(b)%reached = resistance(model, b)
      if (is_moved(model, b)) call look_at_face(model, b, check%of(b)%gap, width, cell)
    end do
  end subroutine begin_contact_check

  !> Returns a force taken as zero, divided by `little`.
  pure real(wp) function least_force(model)
    type(model_type), intent(in) :: model
    integer :: m

    least_force = slight/little*model%cell_size**(model%mesh%dimension - 1)* &
      minval([(model%laws(m)%law%stiffness_scale, m=1, size(model%laws))])
  end function least_force

  !> Updates the force histories after a step: whether a body carries a force, and the force against its motion.
  subroutine check_contact(model, check)
    type(model_type), intent(in) :: model
    type(contact_check_type), intent(inout) :: check
    type(rigid_pose_type) :: motion
    real(wp) :: force
    integer :: b

    do b = 1, size(check%of)
      check%of(b)%touched = check%of(b)%touched .or. any(abs(force_on_body(model, b)) > 0.0_wp)
      force = resistance(model, b)
      motion = motion_in_phase(model, b)
      call follow_force(check%of(b), model%state%progress%step, force)
      call follow_knee(check%of(b), model%state%progress%fraction, force, shallow*model%cell_size/ &
        max(norm2(motion%displacement), tiny(1.0_wp)))
    end do
    force = force_of_push(model)
    call follow_knee(check%nodes, model%state%progress%fraction, force, 1.0_wp)
    call follow_force(check%nodes, model%state%progress%step, force)
  end subroutine check_contact

  !> Returns the force on a body against its motion in the phase.
  real(wp) function resistance(model, b) result(force)
    type(model_type), intent(in) :: model
    integer, intent(in) :: b
    type(rigid_pose_type) :: motion
    real(wp) :: on_body(6)

    motion = motion_in_phase(model, b)
    on_body = force_on_body(model, b)
    force = -dot_product(on_body(:3), motion%displacement)/max(norm2(motion%displacement), tiny(1.0_wp))
  end function resistance

  !> Returns the mean reaction in the direction of the prescribed displacements, weighted by them.
  real(wp) function force_of_push(model) result(force)
    type(model_type), intent(in) :: model
    real(wp) :: work, way

    associate (prescribed => model%loading%prescribed)
      associate (own => spread(own_of(model%part%nodes, size(prescribed, 2)), 1, size(prescribed, 1)))
        work = total(model%part%team, sum(model%state%reactions*prescribed, mask=own))
        way = total(model%part%team, sum(abs(prescribed), mask=own))
      end associate
    end associate
    force = work/max(way, tiny(1.0_wp))
  end function force_of_push

  !> Updates a force history. A low force counts as a decrease if the force was not high for a single step only and does
  !> not recover in the next step.
  pure subroutine follow_force(course, step, force)
    type(course_type), intent(inout) :: course
    integer, intent(in) :: step
    !> Force against the motion.
    real(wp), intent(in) :: force

    if (force < (1.0_wp - course%much)*course%high) call count_fall(course)
    course%dip = 0
    course%high = minval(course%before)
    if (course%high > little*course%most .and. force < (1.0_wp - course%much)*course%high) then
      course%dip = step
      course%low = force
      course%last = course%before(2)
    end if
    course%before = [course%before(2), force]
    course%most = max(course%most, force)
    call follow_wave(course, max(force, 0.0_wp))
  end subroutine follow_force

  !> Stores the force at which its slope first decreases to a given share of the steepest one.
  pure subroutine follow_knee(course, fraction, force, range)
    type(course_type), intent(inout) :: course
    !> Completed fraction of the phase; range of it over which the force counts after that.
    real(wp), intent(in) :: fraction, range
    real(wp), intent(in) :: force
    real(wp) :: slope

    if (.not. fraction > course%done) return
    slope = (force - course%reached)/(fraction - course%done)
    course%done = fraction
    course%reached = force
    course%steepest = max(course%steepest, slope)
    if (.not. course%knee > 0.0_wp .and. slope < knee_slope*course%steepest) then
      course%knee = force
      course%failed = fraction
    end if
    if (course%knee > 0.0_wp .and. fraction <= course%failed + range) course%since = force
  end subroutine follow_knee

  !> Counts a wave where the force rises again; soil that pushes in the direction of motion counts as no resistance.
  pure subroutine follow_wave(course, force)
    type(course_type), intent(inout) :: course
    real(wp), intent(in) :: force

    course%trough = min(course%trough, force)
    associate (fall => course%crest - course%trough, largest => course%of_largest)
      if (fall > deep*course%most .and. force - course%trough > 0.5_wp*deep*course%most) then
        course%waves = course%waves + 1
        if (fall > largest(1) - largest(2)) largest = [course%crest, course%trough]
        course%crest = force
        course%trough = force
      else if (force > course%crest) then
        course%crest = force
        course%trough = force
      end if
    end associate
  end subroutine follow_wave

  !> Counts a low force as a decrease.
  pure subroutine count_fall(course)
    type(course_type), intent(inout) :: course

    if (course%dip == 0) return
    course%falls = course%falls + 1
    if (course%low*course%from > course%to*course%last) return
    course%step = course%dip
    course%from = course%last
    course%to = course%low
  end subroutine count_fall

  !> Prints the warnings at the end of a phase, or where it fails: then contact that could still have occurred is not
  !> assessed.
  subroutine end_contact_check(model, check, observer)
    type(model_type), intent(in) :: model
    type(contact_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer
    integer :: b

    do b = 1, size(check%of)
      associate (body => start_of(model)//" moves rigid body '"//model%analysis%rigid_bodies(b)%name//"'")
        if (phase_is_complete(model%state%progress) .and. .not. check%of(b)%touched .and. is_moved(model, b)) &
          call warn_of_idle(model, b, check%of(b)%gap, body, observer)
        call warn_of_blur(model, b, check%of(b), body, observer)
        associate (rise => rise_of(check%of(b)))
          if (rise > much_of_knee) call observer%note(body//': the force against its motion has risen by '// &
            rounded_text(100.0_wp*rise, 2)//' % within a quarter of a cell since the ground failed: cells beside '// &
            'the body restrain the soil, and the load at failure is the lower one; smaller cells show how much of '// &
            'the rise is real')
        end associate
        call warn_of_falls(body//': the force against its motion', model%state%progress%phase_steps, check%of(b), &
          'the ground fails, or contact is lost; check with smaller steps or cells', observer)
      end associate
    end do
    call warn_of_rise(model, check%nodes, observer)
    call warn_of_falls(start_of(model)//': the mean reaction along its prescribed displacement', &
      model%state%progress%phase_steps, check%nodes, 'the ground fails, or has collapsed in the step and found '// &
      'another equilibrium; check with smaller steps or cells', observer)
  end subroutine end_contact_check

  !> Notes, where prescribed displacements have reached their limit load, that it depends on the grid, and warns of a
  !> reaction that continues to increase after failure, where cells move with the displaced nodes.
  subroutine warn_of_rise(model, course, observer)
    type(model_type), intent(in) :: model
    type(course_type), intent(in) :: course
    class(observer_type), intent(inout) :: observer
    type(law_description_type) :: traits(size(model%analysis%materials))
    character(len=:), allocatable :: depth
    integer :: m

    if (.not. course%knee > 0.0_wp .or. .not. any(may_yield(model%analysis%materials))) return
    call observer%note('the load at failure depends on the grid: `qsmpm-verify study DECK '// &
      '--history NAME` gives it with its discretisation error; since failure it has changed by '// &
      rounded_text(100.0_wp*rise_of(course), 2)//' %')
    if (model%analysis%method%basis /= basis_fem) return
    if (.not. rise_of(course) > much_of_knee) return
    traits = [(traits_of(model%analysis%materials(m)), m=1, size(traits))]
    depth = ''
    if (any(may_yield(model%analysis%materials) .and. .not. traits%failure_keeps_volume)) &
      depth = ' (soil with friction also carries more the deeper they are)'
    call observer%note(start_of(model)//': the mean reaction along its prescribed displacement has risen by '// &
      rounded_text(100.0_wp*rise_of(course), 2)//' % since the ground failed: cells '// &
      'beside the prescribed nodes are dragged along and restrain the soil'//depth//'; smaller cells, or a '// &
      '*RIGID BODY in place of the nodes, show how much of the rise is real')
  end subroutine warn_of_rise

  !> Reports by how much the load at failure on a body a few cells wide may be too high, or that of ground which follows
  !> a body too low, where functions extend over several cells.
  subroutine warn_of_blur(model, b, course, body, observer)
    type(model_type), intent(in) :: model
    integer, intent(in) :: b
    type(course_type), intent(in) :: course
    !> First part of the message.
    character(len=*), intent(in) :: body
    class(observer_type), intent(inout) :: observer
    real(wp) :: gap, width, cell, off

    if (.not. abs(course%knee) > little*least_force(model)) return
    if (.not. any(may_yield(model%analysis%materials)) .or. any(model%analysis%method%basis == [basis_fem, &
      basis_standard])) return
    call look_at_face(model, b, gap, width, cell)
    width = anint(width/cell)
    if (.not. width > 0.0_wp) return
    off = merge(most_blur, blur_of_active, course%knee > 0.0_wp)/width
    if (off < much_of_blur) return
    call observer%note(body(merge(1, len('warning: ') + 1, off >= far_too_much):)//': soil in contact is '// &
      rounded_text(width)//' cells wide, and functions that extend over three cells smooth the slip '// &
      'surface: the load at failure is up to about '// &
      rounded_text(100.0_wp*off, 2)//trim(merge(' % too high', ' % too low ', course%knee > 0.0_wp))// &
      '; use smaller cells')
  end subroutine warn_of_blur

  !> Returns the relative increase of a force since the ground failed, 0 if it has not.
  pure real(wp) function rise_of(course)
    type(course_type), intent(in) :: course

    rise_of = 0.0_wp
    if (course%knee > 0.0_wp) rise_of = course%since/course%knee - 1.0_wp
  end function rise_of

  !> Warns of a force that has decreased in a phase, and resets its history.
  subroutine warn_of_falls(start, steps, course, meaning, observer)
    !> First part of the message, and cause of the decrease.
    character(len=*), intent(in) :: start, meaning
    !> Number of steps of the phase.
    integer, intent(in) :: steps
    type(course_type), intent(inout) :: course
    class(observer_type), intent(inout) :: observer

    call count_fall(course)
    if (course%falls > 0) call observer%note(start//' falls by more than '//rounded_text(100.0_wp*course%much)// &
      ' % and stays low in '//integer_text(course%falls)//' of '//integer_text(steps)//' steps, the most in step '// &
      integer_text(course%step)//', from '//rounded_text(course%from)//' to '//rounded_text(course%to)//': '//meaning)
    if (course%waves > 1) call observer%note(start//' falls and rises again '//integer_text(course%waves)// &
      ' times, the most from '//rounded_text(course%of_largest(1))//' to '//rounded_text(course%of_largest(2))// &
      ': the load at failure is uncertain by these oscillations; a finer *GRID has smaller ones')
    course = course_type(course%much, course%touched, course%gap)
  end subroutine warn_of_falls

  !> Returns the first part of a warning.
  function start_of(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text

    text = "warning: phase '"//model%analysis%phases(model%state%progress%phase)%name//"'"
  end function start_of

  !> Warns of a body that moves and carries no force: soil is inside it, or no soil has come close; a body that moves
  !> away is excluded.
  subroutine warn_of_idle(model, body, gap, start, observer)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    !> Distance to the soil at the start of the phase.
    real(wp), intent(in) :: gap
    !> First part of the message.
    character(len=*), intent(in) :: start
    class(observer_type), intent(inout) :: observer
    type(placed_shape_type) :: placed(size(model%rigid_shapes))
    real(wp) :: left, depth, width, cell
    integer :: point

    placed = placed_bodies(model)
    call look_at_face(model, body, left, width, cell)
    call deepest_in(model, placed(body), point, depth)
    depth = largest(model%part%team, depth)
    if (depth > inside*model%cell_size) then
      call observer%note(start//' into soil without any contact force: soil is '//rounded_text(depth)//' inside '// &
        'of it and the surface of its *CONTACT is elsewhere')
    else if (left > touching*model%cell_size .and. .not. left > gap) then
      call observer%note(start//', and nothing is in contact with it: the nearest soil of its *CONTACT is '// &
        ''//rounded_text(left)// &
        ' away at the end')
    end if
  end subroutine warn_of_idle

  !> Returns whether the present phase moves a body.
  pure logical function is_moved(model, body)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    type(rigid_pose_type) :: motion

    motion = motion_in_phase(model, body)
    is_moved = any(abs([motion%displacement, motion%rotation]) > 0.0_wp)
  end function is_moved

  !> Returns a text on the first body close to soil that it does not touch, for a run that lacks support; otherwise
  !> empty.
  function apart_text(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    real(wp) :: gap, width, cell
    integer :: b

    text = ''
    do b = 1, size(model%rigid_shapes)
      call look_at_face(model, b, gap, width, cell)
      if (gap <= touching*model%cell_size .or. gap > model%cell_size) cycle
      text = "; no soil is in contact with rigid body '"//model%analysis%rigid_bodies(b)%name//"', the nearest is "// &
        rounded_text(gap)//' away: define the soil in contact with the body'
      return
    end do
  end function apart_text

  !> Measures the distance from a body to the nearest soil that may touch it: points of the surfaces of its *CONTACT, or
  !> material points where contact is imposed at points of the body.
  subroutine look_at_face(model, body, gap, width, cell)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    !> Smallest distance, and in plane models the extent across the motion of the soil in contact.
    real(wp), intent(out) :: gap, width
    !> Largest width of a cell in contact; that of the model where there is none.
    real(wp), intent(out) :: cell
    type(placed_shape_type) :: placed(size(model%rigid_shapes))
    type(rigid_pose_type) :: motion
    type(distance_type) :: distance
    logical :: own(model%state%surface%count)
    real(wp) :: place(3), across(3), along, ends(2)
    integer :: i, k, owner

    placed = placed_bodies(model)
    own = own_of(model%part%surface, size(own))
    gap = huge(1.0_wp)
    cell = 0.0_wp
    ends = -0.25_wp*huge(1.0_wp)
    motion = motion_in_phase(model, body)
    across = 0.0_wp
    if (model%mesh%dimension == 2) across(:2) = [-motion%displacement(2), motion%displacement(1)]/ &
      max(norm2(motion%displacement), tiny(1.0_wp))
    do k = 1, size(model%contact_pairs)
      if (model%contact_pairs(k)%body /= body) cycle
      do i = 1, merge(size(own), model%state%points%count, model%contact_pairs(k)%surface > 0)
        if (model%contact_pairs(k)%surface == 0) then
          place = place_of(model%state%points, i)
          owner = model%state%points%cell(i)
        else
          if (.not. own(i) .or. model%state%surface%surface(i) /= model%contact_pairs(k)%surface) cycle
          place = place_of(model%state%surface, i)
          owner = model%state%surface%cell(i)
        end if
        distance = placed(body)%distance_at(place)
        gap = min(gap, distance%value)
        along = dot_product(across, place)
        if (.not. distance%value < inside*model%cell_size) cycle
        ends = max(ends, [along, -along])
        if (owner > 0) cell = max(cell, cell_width(model%mesh, owner))
      end do
    end do
    cell = largest(model%part%team, cell)
    if (.not. cell > 0.0_wp) cell = model%cell_size
    gap = smallest(model%part%team, gap)
    width = max(0.0_wp, largest(model%part%team, ends(1)) + largest(model%part%team, ends(2)))
  end subroutine look_at_face
end module qsmpm_contact_report
