!> Proof that a scene does not depend on an axis and cannot move along it: bodies, supports, loads and
!> mesh are the same all along, and both end planes are held along it.
!>
!> Then u = u(other axes), u_axis = 0 is a solution of the equations as they are discretised, for every
!> element whose functions and points repeat along the axis: the forces at a node are those of the
!> smaller model times the length the node stands for. What depends on the axis is looked for card by
!> card; that the end planes are held is shown node by node for every phase.
module qsmpm_uniform_axis
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_description, only: body_all, body_box, body_polygon
  use qsmpm_mesh_description, only: mesh_grid, select_list
  use qsmpm_reduction, only: letters, refuse, refuse_mesh, place_text
  use qsmpm_set_members, only: members_type, find_members, covers_axis, representatives, node_state, scene_tolerance
  use qsmpm_loaded_surfaces, only: require_loads_uniform
  use qsmpm_rigid_symmetry, only: require_rigid_uniform
  implicit none
  private

  public :: require_uniform

contains

  !> Prove it.
  pure subroutine require_uniform(analysis, axis, reason)
    type(analysis_type), intent(in) :: analysis
    !> 1 or 3.
    integer, intent(in) :: axis
    !> Why not; unallocated when proved.
    character(len=:), allocatable, intent(inout) :: reason
    type(members_type) :: members

    if (analysis%mesh%kind /= mesh_grid) then
      call refuse_mesh(analysis, reason)
      return
    end if
    call find_members(analysis, members)
    call require_bodies(analysis, axis, reason)
    call require_sets(analysis, members, axis, reason)
    call require_loads_uniform(analysis, axis, reason)
    call require_rigid_uniform(analysis, axis, reason)
    call require_plate(analysis, members, axis, reason)
    if (.not. allocated(reason)) call require_held(analysis, members, axis, reason)
  end subroutine require_uniform

  !> Bodies go through the whole grid along the axis.
  pure subroutine require_bodies(analysis, axis, reason)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    real(wp) :: first, last
    logical :: whole
    integer :: b

    associate (lines => analysis%mesh%axes(axis)%lines)
      first = lines(1) + scene_tolerance(analysis)
      last = lines(size(lines)) - scene_tolerance(analysis)
    end associate
    do b = 1, size(analysis%bodies)
      associate (body => analysis%bodies(b))
        select case (body%kind)
        case (body_all)
          whole = .true.
        case (body_box)
          whole = body%box(axis, 1) <= first .and. body%box(axis, 2) >= last
        case (body_polygon)
          whole = axis == 3
          if (axis == 1) whole = is_layer(body%polygon, first, last, scene_tolerance(analysis))
        case default
          whole = .false.
        end select
        if (.not. whole) call refuse(reason, "*BODY '"//body%name//"'"//place_text(body%where)// &
          ' depends on '//letters(axis))
      end associate
    end do
  end subroutine require_bodies

  !> Whether a polygon is a layer over the whole width: what of its edges is inside lies level.
  pure logical function is_layer(polygon, first, last, tolerance)
    !> Vertices (2,n).
    real(wp), intent(in) :: polygon(:, :)
    !> The sides, and the length that is none.
    real(wp), intent(in) :: first, last, tolerance
    integer :: i, k
    logical :: left(2), right(2)

    is_layer = .true.
    do i = 1, size(polygon, 2)
      k = mod(i, size(polygon, 2)) + 1
      left = polygon(1, [i, k]) <= first
      right = polygon(1, [i, k]) >= last
      is_layer = is_layer .and. all(left .or. right) .and. (all(left) .or. all(right) .or. &
        abs(polygon(2, i) - polygon(2, k)) <= tolerance)
    end do
  end function is_layer

  !> Sets that depend on the axis may only be held along it; nothing is moved along it.
  pure subroutine require_sets(analysis, members, axis, reason)
    type(analysis_type), intent(in) :: analysis
    type(members_type), intent(in) :: members
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    logical :: only(3)
    integer :: p, i, s

    only = .false.
    only(axis) = .true.
    do p = 1, size(analysis%phases)
      do i = 1, size(analysis%phases(p)%fixities)
        associate (fixity => analysis%phases(p)%fixities(i))
          s = place_named(analysis%node_sets, fixity%set)
          if (analysis%node_sets(s)%selection == select_list) call refuse(reason, "*NSET '"//fixity%set//"'"// &
            place_text(analysis%node_sets(s)%where)//' is a list of labels')
          if (.not. covers_axis(members, s, axis) .and. any(fixity%fixed .neqv. only)) call refuse(reason, &
            "*FIX of '"//fixity%set//"'"//place_text(fixity%where)//' depends on '//letters(axis))
        end associate
      end do
      do i = 1, size(analysis%phases(p)%prescriptions)
        associate (prescription => analysis%phases(p)%prescriptions(i))
          s = place_named(analysis%node_sets, prescription%set)
          if (.not. covers_axis(members, s, axis)) call refuse(reason, "*PRESCRIBE of '"//prescription%set//"'"// &
            place_text(prescription%where)//' depends on '//letters(axis))
          if (prescription%component == axis .and. abs(prescription%value) > 0.0_wp) call refuse(reason, &
            "*PRESCRIBE of '"//prescription%set//"'"//place_text(prescription%where)//' moves along '//letters(axis))
        end associate
      end do
    end do
  end subroutine require_sets

  !> A plate of a moving mesh goes along another axis and does not depend on this one.
  pure subroutine require_plate(analysis, members, axis, reason)
    type(analysis_type), intent(in) :: analysis
    type(members_type), intent(in) :: members
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    logical :: along

    associate (moving => analysis%moving_mesh)
      if (.not. moving%active) return
      along = moving%axis == axis
      if (.not. (along .or. moving%by_body)) along = .not. covers_axis(members, &
        place_named(analysis%node_sets, moving%set), axis)
      if (along) call refuse(reason, '*MOVING MESH'//place_text(moving%where)//' depends on '//letters(axis))
    end associate
  end subroutine require_plate

  !> Both end planes are held along the axis in every phase. In a grid with shifted nodes only sets of
  !> whole planes count, and nothing may be freed.
  pure subroutine require_held(analysis, members, axis, reason)
    type(analysis_type), intent(in) :: analysis
    type(members_type), intent(in) :: members
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    type(members_type) :: table
    integer, allocatable :: along(:), across(:)
    integer :: others(2), node(3), p, i, k, side, s
    logical :: fixed(3)
    real(wp) :: value(3)

    others = pack([1, 2, 3], [1, 2, 3] /= axis)
    table = members
    if (analysis%mesh%perturbation > 0.0_wp) then
      do s = 1, size(analysis%node_sets)
        if (covers_axis(members, s, others(1)) .and. covers_axis(members, s, others(2))) cycle
        table%axis(others(1))%holds(:, s) = .false.
      end do
      call require_nothing_freed(analysis, reason)
    end if
    call representatives(table, others(1), .false., along)
    call representatives(table, others(2), .false., across)
    do p = 1, size(analysis%phases)
      do i = 1, size(along)
        do k = 1, size(across)
          node(others) = [along(i), across(k)]
          do side = 1, 2
            node(axis) = merge(1, table%count(axis), side == 1)
            call node_state(analysis, table, node, p, fixed, value)
            if (.not. fixed(axis)) call refuse(reason, 'the '//trim(merge('first', 'last ', side == 1))// &
              ' plane across '//letters(axis)//' is not held along '//letters(axis)//" in phase '"// &
              analysis%phases(p)%name//"'"//place_text(analysis%phases(p)%where))
          end do
        end do
      end do
    end do
  end subroutine require_held

  !> No set is freed.
  pure subroutine require_nothing_freed(analysis, reason)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable, intent(inout) :: reason
    integer :: p, i

    do p = 1, size(analysis%phases)
      do i = 1, size(analysis%phases(p)%fixities)
        associate (fixity => analysis%phases(p)%fixities(i))
          if (.not. any(fixity%fixed)) call refuse(reason, "*FIX frees '"//fixity%set//"'"// &
            place_text(fixity%where)//' in a grid of shifted nodes')
        end associate
      end do
    end do
  end subroutine require_nothing_freed
end module qsmpm_uniform_axis
