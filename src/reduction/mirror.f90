!> Proof that a scene is its own mirror image in the plane half way between two sides of its grid:
!> grid, bodies, supports, loads.
!>
!> Supports are compared node by node in every phase; every body and every loaded surface must have a
!> mirror image among those of the deck, which may be itself. A symmetric scene has a symmetric
!> solution; whether it has others too is not proved: `reason_against_mirror` says when the half is not
!> taken unasked.
module qsmpm_mirror
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_history_description, only: quantity_reaction
  use qsmpm_load_description, only: traction_type
  use qsmpm_mesh_description, only: surface_type, select_box, select_segment, select_list, mesh_grid, &
    diagonal_alternate
  use qsmpm_method_description, only: basis_standard, basis_fem, integrate_cells, stabilise_ghost
  use qsmpm_phase_description, only: phase_type
  use qsmpm_element, only: element_from_name, element_order
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_material_traits, only: traits_of
  use qsmpm_phase_tree, only: lineage
  use qsmpm_reduction, only: letters, refuse, refuse_mesh, place_text, require_local_histories
  use qsmpm_set_members, only: members_type, find_members, contains_node, representatives, node_state, scene_tolerance
  use qsmpm_loaded_surfaces, only: surface_is_used
  use qsmpm_mirror_stages, only: prove_stages
  use qsmpm_mirror_images, only: mirror_plane, body_partner, surface_partner
  use qsmpm_rigid_symmetry, only: require_rigid_mirrored, contact_is_associated
  use qsmpm_water_symmetry, only: require_mirrored_water
  implicit none
  private

  public :: require_mirror, reason_against_mirror, set_side

  !> Sides of a set: none, or half with its image on the other side, in the kept half, in the other half.
  integer, parameter, public :: side_mixed = 0, side_both = 1, side_kept = 2, side_other = 3

contains

  !> Prove it.
  pure subroutine require_mirror(analysis, axis, reason)
    type(analysis_type), intent(in) :: analysis
    !> 1 or 3.
    integer, intent(in) :: axis
    !> Why not; unallocated when proved.
    character(len=:), allocatable, intent(out) :: reason
    integer :: b

    if (analysis%mesh%kind /= mesh_grid) then
      call refuse_mesh(analysis, reason)
      return
    end if
    call require_grid(analysis, axis, reason)
    do b = 1, size(analysis%bodies)
      if (body_partner(analysis, b, axis) == 0) call refuse(reason, "*BODY '"//analysis%bodies(b)%name//"'"// &
        place_text(analysis%bodies(b)%where)//' has no mirror image')
    end do
    if (.not. allocated(reason)) call prove_stages(analysis, axis, reason)
    call require_loads(analysis, axis, reason)
    call require_mirrored_water(analysis, axis, reason)
    call require_rigid_mirrored(analysis, axis, reason)
    call require_sets(analysis, axis, reason)
    if (.not. allocated(reason)) call require_nodes(analysis, axis, reason)
  end subroutine require_mirror

  !> Lines and elements are symmetric, and the plane is a line.
  pure subroutine require_grid(analysis, axis, reason)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    integer :: n
    real(wp) :: c

    c = mirror_plane(analysis, axis)
    associate (mesh => analysis%mesh, lines => analysis%mesh%axes(axis)%lines)
      n = size(lines)
      if (any(abs(lines + lines(n:1:-1) - 2.0_wp*c) > scene_tolerance(analysis))) &
        call refuse(reason, 'the lines of *GRID'//place_text(mesh%where)//' along '//letters(axis)// &
        ' are not symmetric')
      if (mod(n, 2) == 0) call refuse(reason, 'no line of *GRID'//place_text(mesh%where)// &
        ' lies in the plane: the number of cells along '//letters(axis)//' is odd')
      if (mesh%perturbation > 0.0_wp) call refuse(reason, 'the nodes of *GRID'//place_text(mesh%where)//' are shifted')
      if (index(mesh%element, 'TET') == 1) call refuse(reason, 'the tetrahedra of *GRID'//place_text(mesh%where)// &
        ' lean to one side')
      if ((index(mesh%element, 'TRI') == 1 .or. index(mesh%element, 'WEDGE') == 1) .and. axis == 1 .and. &
        mesh%diagonal /= diagonal_alternate) call refuse(reason, 'the triangles of *GRID'// &
        place_text(mesh%where)//' lean to one side (DIAGONAL=ALTERNATE does not)')
    end associate
  end subroutine require_grid

  !> Why the half is not taken unasked although the scene is symmetric; empty when nothing speaks
  !> against it.
  pure function reason_against_mirror(analysis) result(reason)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: reason
    type(law_description_type) :: traits
    integer :: m

    reason = ''
    do m = 1, size(analysis%materials)
      associate (material => analysis%materials(m))
        traits = traits_of(material)
        if (traits%may_soften) reason = "material '"//material%name//"' may soften: its failure need not be symmetric"
        if (.not. traits%associated_flow) &
          reason = "the failure of material '"//material%name//"' is not associated: it need not be symmetric"
      end associate
    end do
    if (.not. contact_is_associated(analysis)) reason = &
      'the friction of rigid bodies is not associated: failure need not be symmetric'
    if (all(analysis%method%basis /= [basis_standard, basis_fem])) reason = &
      'splines and GIMP are smooth across the plane, those of the half are not'
    if (analysis%method%stabilisation == stabilise_ghost .and. len(reason) == 0) reason = &
      'the ghost penalty acts across the plane, that of the half does not'
    if (analysis%method%basis == basis_standard .and. analysis%method%integration == integrate_cells .and. &
      element_order(element_from_name(analysis%mesh%element)) > 1 .and. len(reason) == 0) reason = &
      'gradients of quadratic elements are recovered across the plane, those of the half are not'
  end function reason_against_mirror

  !> Gravity lies in the plane; every loaded or supported surface has an image with the mirrored load.
  pure subroutine require_loads(analysis, axis, reason)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    integer :: p

    call prove_surfaces(analysis, axis, reason)
    if (allocated(reason)) return
    do p = 1, size(analysis%phases)
      call prove_phase(analysis, analysis%phases(p), axis, reason)
    end do
  end subroutine require_loads

  !> Every surface in use has an image, and no faces in the plane.
  pure subroutine prove_surfaces(analysis, axis, reason)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    integer :: s

    do s = 1, size(analysis%surfaces)
      associate (surface => analysis%surfaces(s))
        if (.not. surface_is_used(analysis, surface%name)) cycle
        if (surface_partner(analysis, s, axis) == 0) call refuse(reason, "*SURFACE '"//surface%name//"'"// &
          place_text(surface%where)//' has no mirror image')
        if (has_faces_in_plane(analysis, surface, axis)) call refuse(reason, "*SURFACE '"//surface%name//"'"// &
          place_text(surface%where)//' may have faces in the plane of symmetry')
      end associate
    end do
  end subroutine prove_surfaces

  !> Gravity, loads and supports of a phase.
  pure subroutine prove_phase(analysis, phase, axis, reason)
    type(analysis_type), intent(in) :: analysis
    type(phase_type), intent(in) :: phase
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    integer :: i, s, k

    if (phase%gravity%given .and. abs(phase%gravity%vector(axis)) > 0.0_wp) call refuse(reason, &
      "*GRAVITY of phase '"//phase%name//"'"//place_text(phase%where)//' has a part along '//letters(axis))
    do i = 1, size(phase%tractions)
      if (.not. load_has_image(analysis, phase%tractions, phase%tractions(i), axis)) call refuse(reason, &
        "the load on '"//phase%tractions(i)%surface//"'"//place_text(phase%tractions(i)%where)//' has no mirror image')
    end do
    do i = 1, size(phase%supports)
      if (phase%supports(i)%contracts) call refuse(reason, "*CONTRACTION of '"//phase%supports(i)%surface//"'"// &
        place_text(phase%supports(i)%where)//' is about a whole cavity')
      s = surface_partner(analysis, place_named(analysis%surfaces, phase%supports(i)%surface), axis)
      if (.not. any([(phase%supports(k)%surface == analysis%surfaces(s)%name .and. &
        phase%supports(k)%kind == phase%supports(i)%kind, k=1, size(phase%supports))])) call refuse(reason, &
        "*SUPPORT of '"//phase%supports(i)%surface//"'"//place_text(phase%supports(i)%where)//' has no mirror image')
    end do
  end subroutine prove_phase

  !> Whether cutting at the plane may give a surface new faces: its box reaches the plane and is not
  !> flat along another axis, or it lies in the plane.
  pure logical function has_faces_in_plane(analysis, surface, axis) result(yes)
    type(analysis_type), intent(in) :: analysis
    type(surface_type), intent(in) :: surface
    integer, intent(in) :: axis
    real(wp) :: c, tolerance
    logical :: flat
    integer :: a

    yes = .false.
    c = mirror_plane(analysis, axis)
    tolerance = scene_tolerance(analysis)
    select case (surface%selection)
    case (select_segment)
      yes = any(maxval(abs(surface%segments([1, 3], :) - c), dim=1) <= tolerance)
    case (select_box)
      if (surface%box(axis, 1) > c + tolerance .or. surface%box(axis, 2) < c - tolerance) return
      flat = .false.
      do a = 1, merge(3, 2, analysis%model == three_dimensional)
        if (a /= axis) flat = flat .or. surface%box(a, 2) - surface%box(a, 1) <= tolerance
      end do
      yes = .not. flat
    end select
  end function has_faces_in_plane

  !> Whether the mirror image of a load is among the loads of its phase.
  pure logical function load_has_image(analysis, loads, load, axis) result(found)
    type(analysis_type), intent(in) :: analysis
    !> Loads of the phase, and the one.
    type(traction_type), intent(in) :: loads(:), load
    integer, intent(in) :: axis
    real(wp) :: image(3)
    integer :: k, s

    s = surface_partner(analysis, place_named(analysis%surfaces, load%surface), axis)
    image = load%vector
    image(axis) = -image(axis)
    found = .false.
    do k = 1, size(loads)
      if (loads(k)%surface /= analysis%surfaces(s)%name) cycle
      if ((loads(k)%follows .neqv. load%follows) .or. loads(k)%carrier /= load%carrier) cycle
      found = found .or. (all(abs(loads(k)%vector - image) <= 0.0_wp) &
        .and. abs(loads(k)%pressure - load%pressure) + abs(loads(k)%gradient - load%gradient) &
        + abs(loads(k)%height - load%height) <= 0.0_wp .and. (loads(k)%of_water .eqv. load%of_water))
    end do
  end function load_has_image

  !> Sets are no lists of labels; a plate is symmetric; reactions are those of symmetric sets or of one
  !> half.
  pure subroutine require_sets(analysis, axis, reason)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    type(members_type) :: members
    logical :: one_sided
    integer :: p, i

    call find_members(analysis, members)
    do p = 1, size(analysis%phases)
      do i = 1, size(analysis%phases(p)%fixities)
        call refuse_labels(analysis, analysis%phases(p)%fixities(i)%set, reason)
      end do
      do i = 1, size(analysis%phases(p)%prescriptions)
        call refuse_labels(analysis, analysis%phases(p)%prescriptions(i)%set, reason)
      end do
    end do
    associate (moving => analysis%moving_mesh)
      one_sided = moving%active .and. moving%axis == axis
      if (moving%active .and. .not. (one_sided .or. moving%by_body)) one_sided = &
        set_side(members, place_named(analysis%node_sets, moving%set), axis) /= side_both
      if (one_sided) call refuse(reason, '*MOVING MESH'//place_text(moving%where)//' is not symmetric')
    end associate
    call require_local_histories(analysis, reason)
    do i = 1, size(analysis%histories)
      associate (history => analysis%histories(i))
        if (history%quantity /= quantity_reaction .or. allocated(reason)) cycle
        if (set_side(members, place_named(analysis%node_sets, history%set), axis) == side_mixed) call refuse(reason, &
          "*HISTORY '"//history%name//"'"//place_text(history%where)//" reads a reaction of '"//history%set// &
          "', which is neither symmetric nor in one half")
      end associate
    end do
  end subroutine require_sets

  !> A list of labels has no place.
  pure subroutine refuse_labels(analysis, name, reason)
    type(analysis_type), intent(in) :: analysis
    !> Name of the set.
    character(len=*), intent(in) :: name
    character(len=:), allocatable, intent(inout) :: reason
    integer :: s

    s = place_named(analysis%node_sets, name)
    if (analysis%node_sets(s)%selection == select_list) call refuse(reason, "*NSET '"//name//"'"// &
      place_text(analysis%node_sets(s)%where)//' is a list of labels')
  end subroutine refuse_labels

  !> Where a set lies: on both sides alike, or wholly on one. The plane belongs to neither half.
  pure integer function set_side(members, set, axis) result(side)
    type(members_type), intent(in) :: members
    !> Number of the set, and the axis.
    integer, intent(in) :: set, axis
    integer :: n

    side = side_mixed
    associate (holds => members%axis(axis)%holds(:, set))
      n = size(holds)
      if (.not. any(holds)) return
      if (all(holds .eqv. holds(n:1:-1))) then
        side = side_both
      else if (.not. any(holds(n/2 + 1:))) then
        side = side_kept
      else if (.not. any(holds(:n/2 + 1))) then
        side = side_other
      end if
    end associate
  end function set_side

  !> Every node is held and moved like its image, in every phase.
  pure subroutine require_nodes(analysis, axis, reason)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    type(members_type) :: members
    integer, allocatable :: along(:), first(:), second(:)
    integer :: others(2), node(3), image(3), p, i, j, k, c
    logical :: fixed(3), image_fixed(3)
    real(wp) :: value(3), image_value(3)

    others = pack([1, 2, 3], [1, 2, 3] /= axis)
    call find_members(analysis, members)
    call representatives(members, axis, .true., along)
    call representatives(members, others(1), .false., first)
    call representatives(members, others(2), .false., second)
    do p = 1, size(analysis%phases)
      do i = 1, size(along)
        do j = 1, size(first)
          do k = 1, size(second)
            node(axis) = along(i)
            node(others) = [first(j), second(k)]
            image = node
            image(axis) = members%count(axis) + 1 - node(axis)
            call node_state(analysis, members, node, p, fixed, value)
            call node_state(analysis, members, image, p, image_fixed, image_value)
            image_value(axis) = -image_value(axis)
            do c = 1, 3
              if ((fixed(c) .eqv. image_fixed(c)) .and. abs(value(c) - image_value(c)) <= 0.0_wp) cycle
              call refuse(reason, blame(analysis, members, node, image, p, c))
            end do
          end do
        end do
      end do
    end do
  end subroutine require_nodes

  !> The last card that treats a node and its image differently.
  pure function blame(analysis, members, node, image, phase, component) result(text)
    type(analysis_type), intent(in) :: analysis
    type(members_type), intent(in) :: members
    !> The two nodes (3).
    integer, intent(in) :: node(3), image(3)
    !> Number of the phase, and the component.
    integer, intent(in) :: phase, component
    character(len=:), allocatable :: text
    integer, allocatable :: line(:)
    integer :: p, i

    text = 'the supports are not symmetric'
    allocate (line, source=lineage(analysis%phases, phase))
    do p = 1, size(line)
      associate (now => analysis%phases(line(p)))
        do i = 1, size(now%fixities)
          associate (fixity => now%fixities(i))
            if (any(fixity%fixed) .and. .not. fixity%fixed(component)) cycle
            if (is_one_sided(fixity%set)) text = "*FIX of '"//fixity%set//"'"//place_text(fixity%where)// &
              ' has no mirror image'
          end associate
        end do
        do i = 1, size(now%prescriptions)
          associate (prescription => now%prescriptions(i))
            if (prescription%component /= component) cycle
            ! A motion along the normal of a set that holds both nodes is none of mirror images.
            if (is_one_sided(prescription%set) .or. (node(component) /= image(component) .and. p == size(line)) .or. &
              (all(node == image) .and. p == size(line))) text = "*PRESCRIBE of '"//prescription%set//"'"// &
              place_text(prescription%where)//' has no mirror image'
          end associate
        end do
      end associate
    end do

  contains

    !> Whether a set holds one of the nodes only.
    pure logical function is_one_sided(name)
      !> Name of the set.
      character(len=*), intent(in) :: name
      integer :: s

      s = place_named(analysis%node_sets, name)
      is_one_sided = contains_node(members, s, node) .neqv. contains_node(members, s, image)
    end function is_one_sided
  end function blame
end module qsmpm_mirror
