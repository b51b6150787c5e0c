!> Scene that is examined for a reduction: the analysis with the tables that the checks use repeatedly, and the first
!> reason found against the reduction.
!>
!> The tables state which lines of the grid belong to which node sets, and so how the phases constrain a node. A set
!> chosen by a plane or a box is a product of intervals, so that three tables determine for every node of the grid
!> whether it is in the set. Nodes with the same entries are treated alike; checks on representatives of them hold for
!> all nodes. Mid-side nodes of quadratic elements are at lines half way.
module qsmpm_examined_scene
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_history_quantities, only: is_taken_at, at_body, at_support
  use qsmpm_mesh_description, only: mesh_fitted, mesh_grid, set_type, axis_type, select_plane, select_box
  use qsmpm_source_line, only: source_line_type
  use qsmpm_text, only: integer_text
  use qsmpm_named, only: place_named
  use qsmpm_history_description, only: quantity_reaction
  use qsmpm_load_description, only: fixity_type
  use qsmpm_element_kinds, only: element_from_name, element_order
  use qsmpm_phase_tree, only: lineage
  implicit none
  private

  public :: examined_type, examine, refuse, refuse_mesh, require_local_histories, place_text, card, members_type, &
    find_members, contains_node, covers_axis, representatives, node_state, scene_tolerance, keep_supports, &
    drop_unused_sets

  !> Lengths that differ by less than this share of the size of the grid are equal, as for the sets of the mesh.
  real(wp), parameter :: closeness = 1.0e-8_wp

  !> Entries along one axis.
  type :: member_table_type
    !> (places along the axis, sets)
    logical, allocatable :: holds(:, :)
  end type member_table_type

  !> Entries of all sets.
  type :: members_type
    integer :: dimension = 0
    !> Places along each axis: lines, and for quadratic elements lines half way; 1 beyond the dimension.
    type(axis_type) :: places(3)
    integer :: count(3) = 1
    type(member_table_type) :: axis(3)
  end type members_type

  !> Names of the axes.
  character(len=1), parameter, public :: letters(3) = ['x', 'y', 'z']

  type, extends(analysis_type) :: examined_type
    !> Axis that is omitted, halved or reduced to one cell; 0 for a figure of revolution.
    integer :: axis = 0
    !> For a grid: which lines are in which node sets, the tolerance of lengths, and the coordinate of the plane half
    !> way between its sides across the axis.
    type(members_type) :: members
    real(wp) :: nothing = 0.0_wp, plane = 0.0_wp
    !> Why the reduction is not possible; unallocated as long as there is no reason against it.
    character(len=:), allocatable :: reason
  end type examined_type

contains

  !> Returns the distance below which places are equal.
  pure real(wp) function scene_tolerance(analysis) result(tolerance)
    !> The scene; its mesh is a grid.
    class(analysis_type), intent(in) :: analysis
    integer :: a

    tolerance = 0.0_wp
    do a = 1, merge(3, 2, analysis%model == three_dimensional)
      associate (lines => analysis%mesh%axes(a)%lines)
        tolerance = max(tolerance, closeness*(lines(size(lines)) - lines(1)))
      end associate
    end do
  end function scene_tolerance

  !> Builds the tables of a scene.
  pure subroutine find_members(analysis, members)
    !> The scene; its mesh is a grid.
    class(analysis_type), intent(in) :: analysis
    type(members_type), intent(out) :: members
    integer :: a, s, n, i

    members%dimension = merge(3, 2, analysis%model == three_dimensional)
    do a = 1, 3
      if (a <= members%dimension) then
        call places_along(analysis%mesh%axes(a)%lines, analysis%mesh%element, members%places(a)%lines)
        members%count(a) = size(members%places(a)%lines)
      else
        members%places(a)%lines = [0.0_wp]
      end if
      n = members%count(a)
      allocate (members%axis(a)%holds(n, size(analysis%node_sets)), source=.true.)
      if (a > members%dimension) cycle
      do s = 1, size(analysis%node_sets)
        do i = 1, n
          members%axis(a)%holds(i, s) = in_set(analysis%node_sets(s), a, members%places(a)%lines(i), &
            scene_tolerance(analysis))
        end do
      end do
    end do
  end subroutine find_members

  !> Returns the lines, and for quadratic elements also those half way.
  pure subroutine places_along(lines, element, places)
    !> Grid lines.
    real(wp), intent(in) :: lines(:)
    !> Element name.
    character(len=*), intent(in) :: element
    real(wp), allocatable, intent(out) :: places(:)
    integer :: i, n, order

    n = size(lines)
    order = element_from_name(element)
    if (order > 0) order = element_order(order)
    if (order > 1) then
      allocate (places(2*n - 1))
      places(1::2) = lines
      do i = 1, n - 1
        places(2*i) = 0.5_wp*(lines(i) + lines(i + 1))
      end do
    else
      allocate (places(n), source=lines)
    end if
  end subroutine places_along

  !> Checks whether a coordinate is within the limits of a set along an axis. A list of labels has none.
  pure logical function in_set(set, axis, x, tolerance)
    type(set_type), intent(in) :: set
    integer, intent(in) :: axis
    !> The coordinate, and the tolerance of distances.
    real(wp), intent(in) :: x, tolerance

    select case (set%selection)
    case (select_plane)
      in_set = axis /= set%axis .or. abs(x - set%box(set%axis, 1)) <= tolerance
    case (select_box)
      in_set = x >= set%box(axis, 1) - tolerance .and. x <= set%box(axis, 2) + tolerance
    case default
      in_set = .false.
    end select
  end function in_set

  !> Checks whether a set contains a node.
  pure logical function contains_node(members, set, node)
    type(members_type), intent(in) :: members
    !> Number of the set; place of the node along each axis (3).
    integer, intent(in) :: set, node(3)

    contains_node = members%axis(1)%holds(node(1), set) .and. members%axis(2)%holds(node(2), set) &
      .and. members%axis(3)%holds(node(3), set)
  end function contains_node

  !> Checks whether a set is independent of an axis.
  pure logical function covers_axis(members, set, axis)
    type(members_type), intent(in) :: members
    !> Number of the set, and the axis.
    integer, intent(in) :: set, axis

    covers_axis = all(members%axis(axis)%holds(:, set))
  end function covers_axis

  !> Returns places along an axis, one of each kind; the first and the last are separate kinds. With `mirrored` the
  !> entries of the opposite place define the kind too.
  pure subroutine representatives(members, axis, mirrored, list)
    type(members_type), intent(in) :: members
    integer, intent(in) :: axis
    !> Compare both sides.
    logical, intent(in) :: mirrored
    !> Places found.
    integer, allocatable, intent(out) :: list(:)
    integer :: i, k, n, found, some(members%count(axis))
    logical :: known

    n = members%count(axis)
    found = 0
    associate (holds => members%axis(axis)%holds)
      do i = 1, n
        known = .false.
        do k = 1, found
          if (i == 1 .or. i == n) exit
          known = all(holds(i, :) .eqv. holds(some(k), :)) .and. some(k) > 1
          if (mirrored) known = known .and. all(holds(n + 1 - i, :) .eqv. holds(n + 1 - some(k), :))
          if (known) exit
        end do
        if (known) cycle
        found = found + 1
        some(found) = i
      end do
    end associate
    allocate (list(found), source=some(:found))
  end subroutine representatives

  !> Returns the constraints of a node in a phase: fixed components, and the displacement prescribed over the phase.
  pure subroutine node_state(analysis, members, node, phase, fixed, value)
    class(analysis_type), intent(in) :: analysis
    type(members_type), intent(in) :: members
    !> Place of the node along each axis (3); number of the phase.
    integer, intent(in) :: node(3), phase
    !> Fixed components (3).
    logical, intent(out) :: fixed(3)
    !> Prescribed displacement (3).
    real(wp), intent(out) :: value(3)
    integer, allocatable :: line(:)
    integer :: p, i

    fixed = .false.
    allocate (line, source=lineage(analysis%phases, phase))
    do p = 1, size(line)
      value = 0.0_wp
      associate (now => analysis%phases(line(p)))
        do i = 1, size(now%fixities)
          if (.not. contains_node(members, place_named(analysis%node_sets, now%fixities(i)%set), node)) cycle
          fixed = now%fixities(i)%fixed .or. (any(now%fixities(i)%fixed) .and. fixed)
        end do
        do i = 1, size(now%prescriptions)
          associate (prescription => now%prescriptions(i))
            if (.not. contains_node(members, place_named(analysis%node_sets, prescription%set), node)) cycle
            fixed(prescription%component) = .true.
            value(prescription%component) = now%load_factor*prescription%value
          end associate
        end do
      end associate
    end do
  end subroutine node_state

  !> Checks whether anything refers to a node set.
  pure logical function set_is_used(analysis, name) result(used)
    class(analysis_type), intent(in) :: analysis
    !> Name of the set.
    character(len=*), intent(in) :: name
    integer :: p, i

    used = .false.
    if (analysis%moving_mesh%active .and. .not. analysis%moving_mesh%by_body) used = analysis%moving_mesh%set == name
    do i = 1, size(analysis%histories)
      if (analysis%histories(i)%quantity /= quantity_reaction) cycle
      used = used .or. analysis%histories(i)%set == name
    end do
    do p = 1, size(analysis%phases)
      used = used .or. any([(analysis%phases(p)%fixities(i)%set == name, i=1, size(analysis%phases(p)%fixities))])
      used = used .or. any([(analysis%phases(p)%prescriptions(i)%set == name, i=1, &
        size(analysis%phases(p)%prescriptions))])
    end do
  end function set_is_used

  !> Keeps the constraints of some sets in all phases, and fixes planes along their normal in all of them.
  pure subroutine keep_supports(analysis, stays, axis, places, names)
    !> The scene; sets of the planes are added to it.
    class(analysis_type), intent(inout) :: analysis
    !> Constraints of this set are kept (node sets).
    logical, intent(in) :: stays(:)
    !> Normal of the planes, their coordinates and names, which a deck cannot define without quotes.
    integer, intent(in) :: axis
    real(wp), intent(in) :: places(:)
    character(len=*), intent(in) :: names(:)
    type(fixity_type), allocatable :: fixities(:)
    type(fixity_type) :: roller
    type(set_type) :: plane
    integer :: p, i, k

    roller%fixed(axis) = .true.
    do p = 1, size(analysis%phases)
      allocate (fixities(0))
      associate (phase => analysis%phases(p), sets => analysis%node_sets)
        do i = 1, size(phase%fixities)
          if (stays(place_named(sets, phase%fixities(i)%set))) fixities = [fixities, phase%fixities(i)]
        end do
        do k = 1, size(names)
          roller%set = trim(names(k))
          fixities = [fixities, roller]
        end do
        phase%prescriptions = phase%prescriptions(pack([(i, i=1, size(phase%prescriptions))], &
          [(stays(place_named(sets, phase%prescriptions(i)%set)), i=1, size(phase%prescriptions))]))
        call move_alloc(fixities, phase%fixities)
      end associate
    end do
    plane%selection = select_plane
    plane%axis = axis
    do k = 1, size(names)
      plane%name = trim(names(k))
      plane%box(axis, 1) = places(k)
      analysis%node_sets = [analysis%node_sets, plane]
    end do
  end subroutine keep_supports

  !> Removes the node sets to which nothing refers, and all element sets.
  pure subroutine drop_unused_sets(analysis)
    class(analysis_type), intent(inout) :: analysis
    integer :: s

    analysis%node_sets = analysis%node_sets(pack([(s, s=1, size(analysis%node_sets))], &
      [(set_is_used(analysis, analysis%node_sets(s)%name), s=1, size(analysis%node_sets))]))
    deallocate (analysis%element_sets)
    allocate (analysis%element_sets(0))
  end subroutine drop_unused_sets

  !> Initialises the examination of a scene.
  pure subroutine examine(scene, axis)
    type(examined_type), intent(inout) :: scene
    integer, intent(in) :: axis

    scene%axis = axis
    if (allocated(scene%reason)) deallocate (scene%reason)
    if (scene%mesh%kind /= mesh_grid) return
    scene%nothing = scene_tolerance(scene)
    call find_members(scene, scene%members)
    if (axis == 0) return
    associate (lines => scene%mesh%axes(axis)%lines)
      if (allocated(scene%mesh%axes(axis)%lines)) scene%plane = 0.5_wp*(lines(1) + lines(size(lines)))
    end associate
  end subroutine examine

  !> Notes why a reduction is not possible; the first reason is kept.
  pure subroutine refuse(scene, text)
    type(examined_type), intent(inout) :: scene
    character(len=*), intent(in) :: text

    if (.not. allocated(scene%reason)) scene%reason = text
  end subroutine refuse

  !> Rejects a mesh that is not a grid of equal cells along its axes.
  pure subroutine refuse_mesh(scene)
    type(examined_type), intent(inout) :: scene

    if (scene%mesh%kind == mesh_fitted) then
      call refuse(scene, 'its cells are triangles that fit the bodies (*GRID'//place_text(scene%mesh%where)//')')
    else
      call refuse(scene, 'the mesh is no *GRID'//place_text(scene%mesh%where))
    end if
  end subroutine refuse_mesh

  !> Rejects histories of bodies and supported surfaces, which are sums or extremes over the whole scene.
  pure subroutine require_local_histories(scene)
    type(examined_type), intent(inout) :: scene
    integer :: i

    do i = 1, size(scene%histories)
      associate (history => scene%histories(i))
        if (is_taken_at(history%quantity, at_body)) &
          call refuse(scene, card('*HISTORY', history%name, history%where)//' reads whole bodies')
        if (is_taken_at(history%quantity, at_support) .and. len(history%surface) > 0) &
          call refuse(scene, card('*HISTORY', history%name, history%where)//' reads a whole surface')
      end associate
    end do
  end subroutine require_local_histories

  !> Describes a card by its keyword, the name of what it defines or acts on, and its position.
  pure function card(keyword, name, where) result(text)
    character(len=*), intent(in) :: keyword, name
    type(source_line_type), intent(in) :: where
    character(len=:), allocatable :: text

    text = keyword//" '"//name//"'"//place_text(where)
  end function card

  !> Returns the position of a card in the deck in brackets, empty if unknown.
  pure function place_text(where) result(text)
    !> Position in the deck.
    type(source_line_type), intent(in) :: where
    character(len=:), allocatable :: text

    text = ''
    if (allocated(where%file) .and. where%line > 0) text = ' ('//where%file//':'//integer_text(where%line)//')'
  end function place_text
end module qsmpm_examined_scene
