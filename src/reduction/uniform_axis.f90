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
  use qsmpm_body_description, only: body_all, body_box, body_polygon
  use qsmpm_mesh_description, only: mesh_grid, select_list
  use qsmpm_loaded_surfaces, only: require_loads_uniform
  use qsmpm_rigid_symmetry, only: require_rigid_uniform
  use qsmpm_examined_scene, only: examined_type, card, letters, place_text, refuse, refuse_mesh, members_type, &
    covers_axis, representatives, node_state
  implicit none
  private

  public :: require_uniform

contains

  !> Prove it.
  pure subroutine require_uniform(scene)
    type(examined_type), intent(inout) :: scene

    if (scene%mesh%kind /= mesh_grid) then
      call refuse_mesh(scene)
      return
    end if
    call require_bodies(scene)
    call require_sets(scene)
    call require_loads_uniform(scene)
    call require_rigid_uniform(scene)
    call require_plate(scene)
    if (.not. allocated(scene%reason)) call require_held(scene)
  end subroutine require_uniform

  !> Bodies go through the whole grid along the axis.
  pure subroutine require_bodies(scene)
    type(examined_type), intent(inout) :: scene
    real(wp) :: first, last
    logical :: whole
    integer :: b

    associate (lines => scene%mesh%axes(scene%axis)%lines)
      first = lines(1) + scene%nothing
      last = lines(size(lines)) - scene%nothing
    end associate
    do b = 1, size(scene%bodies)
      associate (body => scene%bodies(b))
        select case (body%kind)
        case (body_all)
          whole = .true.
        case (body_box)
          whole = body%box(scene%axis, 1) <= first .and. body%box(scene%axis, 2) >= last
        case (body_polygon)
          whole = scene%axis == 3
          if (scene%axis == 1) whole = is_layer(body%polygon, first, last, scene%nothing)
        case default
          whole = .false.
        end select
        if (.not. whole) call refuse(scene, card('*BODY', body%name, body%where)//' depends on '//letters(scene%axis))
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
  pure subroutine require_sets(scene)
    type(examined_type), intent(inout) :: scene
    logical :: only(3)
    integer :: p, i, s

    only = .false.
    only(scene%axis) = .true.
    do p = 1, size(scene%phases)
      do i = 1, size(scene%phases(p)%fixities)
        associate (fixity => scene%phases(p)%fixities(i))
          s = place_named(scene%node_sets, fixity%set)
          if (scene%node_sets(s)%selection == select_list) &
            call refuse(scene, card('*NSET', fixity%set, scene%node_sets(s)%where)//' is a list of labels')
          if (.not. covers_axis(scene%members, s, scene%axis) .and. any(fixity%fixed .neqv. only)) &
            call refuse(scene, card('*FIX of', fixity%set, fixity%where)//' depends on '//letters(scene%axis))
        end associate
      end do
      do i = 1, size(scene%phases(p)%prescriptions)
        associate (prescription => scene%phases(p)%prescriptions(i))
          s = place_named(scene%node_sets, prescription%set)
          if (.not. covers_axis(scene%members, s, scene%axis)) call refuse(scene, card('*PRESCRIBE of', &
            prescription%set, prescription%where)//' depends on '//letters(scene%axis))
          if (prescription%component == scene%axis .and. abs(prescription%value) > 0.0_wp) &
            call refuse(scene, card('*PRESCRIBE of', prescription%set, prescription%where)//' moves along '// &
            letters(scene%axis))
        end associate
      end do
    end do
  end subroutine require_sets

  !> A plate of a moving mesh goes along another axis and does not depend on this one.
  pure subroutine require_plate(scene)
    type(examined_type), intent(inout) :: scene
    logical :: along

    associate (moving => scene%moving_mesh)
      if (.not. moving%active) return
      along = moving%axis == scene%axis
      if (.not. (along .or. moving%by_body)) &
        along = .not. covers_axis(scene%members, place_named(scene%node_sets, moving%set), scene%axis)
      if (along) call refuse(scene, '*MOVING MESH'//place_text(moving%where)//' depends on '//letters(scene%axis))
    end associate
  end subroutine require_plate

  !> Both end planes are held along the axis in every phase. In a grid with shifted nodes only sets of
  !> whole planes count, and nothing may be freed.
  pure subroutine require_held(scene)
    type(examined_type), intent(inout) :: scene
    type(members_type) :: table
    integer, allocatable :: along(:), across(:)
    integer :: others(2), node(3), p, i, k, side, s
    logical :: fixed(3)
    real(wp) :: value(3)

    others = pack([1, 2, 3], [1, 2, 3] /= scene%axis)
    table = scene%members
    if (scene%mesh%perturbation > 0.0_wp) then
      do s = 1, size(scene%node_sets)
        if (covers_axis(scene%members, s, others(1)) .and. covers_axis(scene%members, s, others(2))) cycle
        table%axis(others(1))%holds(:, s) = .false.
      end do
      ! No set is freed.
      do p = 1, size(scene%phases)
        do i = 1, size(scene%phases(p)%fixities)
          associate (fixity => scene%phases(p)%fixities(i))
            if (.not. any(fixity%fixed)) call refuse(scene, card('*FIX frees', fixity%set, fixity%where)// &
              ' in a grid of shifted nodes')
          end associate
        end do
      end do
    end if
    call representatives(table, others(1), .false., along)
    call representatives(table, others(2), .false., across)
    do p = 1, size(scene%phases)
      do i = 1, size(along)
        do k = 1, size(across)
          node(others) = [along(i), across(k)]
          do side = 1, 2
            node(scene%axis) = merge(1, table%count(scene%axis), side == 1)
            call node_state(scene, table, node, p, fixed, value)
            if (.not. fixed(scene%axis)) call refuse(scene, 'the '//trim(merge('first', 'last ', side == 1))// &
              ' plane across '//letters(scene%axis)//' is not held along '//letters(scene%axis)//card(' in phase', &
              scene%phases(p)%name, scene%phases(p)%where))
          end do
        end do
      end do
    end do
  end subroutine require_held
end module qsmpm_uniform_axis
