!> Check that a scene is its own mirror image in the plane half way between two sides of its grid: grid, bodies,
!> supports, loads; and the half model.
!>
!> Supports are compared node by node in every phase; every body and every loaded surface must have a mirror image among
!> those of the deck, which may be itself. A symmetric scene has a symmetric solution; whether it has others too is not
!> checked: `reason_against_mirror` states when the half is not used automatically.
!>
!> The half model is the half below the plane, which is fixed along its normal. Bodies and surfaces that cross the plane
!> are kept whole: the grid ends there, and the part beyond it has no cells.
module qsmpm_mirror
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: three_dimensional
  use qsmpm_history_description, only: quantity_reaction, quantity_displacement, quantity_position, quantity_stress, &
    quantity_strain
  use qsmpm_load_description, only: traction_type
  use qsmpm_mesh_description, only: surface_type, select_box, select_segment, select_list, mesh_grid, &
    diagonal_alternate, select_plane, select_outline
  use qsmpm_method_description, only: basis_standard, basis_fem, integrate_cells, stabilise_ghost
  use qsmpm_phase_description, only: phase_type
  use qsmpm_element, only: element_from_name, element_order
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_material_description, only: traits_of
  use qsmpm_phase_tree, only: lineage
  use qsmpm_loaded_surfaces, only: surface_is_used, drop_unused, require_mirrored_water
  use qsmpm_mirror_images, only: body_partner, surface_partner, mirrored_box
  use qsmpm_rigid_symmetry, only: require_rigid_mirrored, contact_is_associated, half_rigid_bodies, mirror_rigid_history
  use qsmpm_body_description, only: body_change_type, body_type, body_box, body_polygon
  use qsmpm_examined_scene, only: examined_type, card, letters, place_text, refuse, refuse_mesh, &
    require_local_histories, members_type, contains_node, representatives, node_state, keep_supports
  use qsmpm_history_quantities, only: is_taken_at, at_rigid_body
  use qsmpm_reduction, only: reduction_type, reduce_mirror, begin_reduction
  implicit none
  private

  public :: require_mirror, reason_against_mirror, make_half

  !> Position of a set: none of these, in both halves alike, in the retained half, in the other half.
  integer, parameter, public :: side_mixed = 0, side_both = 1, side_kept = 2, side_other = 3

  character(len=*), parameter :: plane_names(3) = ['=mirror x', '=mirror y', '=mirror z']

contains

  !> Checks the whole scene.
  pure subroutine require_mirror(scene)
    type(examined_type), intent(inout) :: scene
    integer :: b

    if (scene%mesh%kind /= mesh_grid) then
      call refuse_mesh(scene)
      return
    end if
    call require_grid(scene)
    do b = 1, size(scene%bodies)
      if (body_partner(scene, b) == 0) &
        call refuse(scene, card('*BODY', scene%bodies(b)%name, scene%bodies(b)%where)//' has no mirror image')
    end do
    if (.not. allocated(scene%reason)) call prove_stages(scene)
    call require_loads(scene)
    call require_mirrored_water(scene)
    call require_rigid_mirrored(scene)
    call require_sets(scene)
    if (.not. allocated(scene%reason)) call require_nodes(scene)
  end subroutine require_mirror

  !> Checks that lines and elements are symmetric, and that the plane is a grid line.
  pure subroutine require_grid(scene)
    type(examined_type), intent(inout) :: scene
    integer :: n
    real(wp) :: c

    c = scene%plane
    associate (mesh => scene%mesh, lines => scene%mesh%axes(scene%axis)%lines)
      n = size(lines)
      if (any(abs(lines + lines(n:1:-1) - 2.0_wp*c) > scene%nothing)) call refuse(scene, 'the lines of *GRID'// &
        place_text(mesh%where)//' along '//letters(scene%axis)//' are not symmetric')
      if (mod(n, 2) == 0) call refuse(scene, 'no line of *GRID'//place_text(mesh%where)// &
        ' lies in the plane: the number of cells along '//letters(scene%axis)//' is odd')
      if (mesh%perturbation > 0.0_wp) call refuse(scene, 'the nodes of *GRID'//place_text(mesh%where)//' are shifted')
      if (index(mesh%element, 'TET') == 1) &
        call refuse(scene, 'the tetrahedra of *GRID'//place_text(mesh%where)//' lean to one side')
      if ((index(mesh%element, 'TRI') == 1 .or. index(mesh%element, 'WEDGE') == 1) .and. scene%axis == 1 .and. &
        mesh%diagonal /= diagonal_alternate) call refuse(scene, 'the triangles of *GRID'//place_text(mesh%where)// &
        ' lean to one side (DIAGONAL=ALTERNATE does not)')
    end associate
  end subroutine require_grid

  !> Returns why the half is not used automatically although the scene is symmetric; empty if there is no reason.
  pure function reason_against_mirror(scene) result(reason)
    type(examined_type), intent(in) :: scene
    character(len=:), allocatable :: reason
    type(law_description_type) :: traits
    integer :: m

    reason = ''
    do m = 1, size(scene%materials)
      associate (material => scene%materials(m))
        traits = traits_of(material)
        if (traits%may_soften) reason = "material '"//material%name//"' may soften: its failure need not be symmetric"
        if (.not. traits%associated_flow) &
          reason = "the failure of material '"//material%name//"' is not associated: it need not be symmetric"
      end associate
    end do
    if (.not. contact_is_associated(scene)) &
      reason = 'the friction of rigid bodies is not associated: failure need not be symmetric'
    if (all(scene%method%basis /= [basis_standard, basis_fem])) &
      reason = 'splines and GIMP are smooth across the plane, those of the half are not'
    if (scene%method%stabilisation == stabilise_ghost .and. len(reason) == 0) &
      reason = 'the ghost penalty acts across the plane, that of the half does not'
    if (scene%method%basis == basis_standard .and. scene%method%integration == integrate_cells .and. &
      element_order(element_from_name(scene%mesh%element)) > 1 .and. len(reason) == 0) &
      reason = 'gradients of quadratic elements are recovered across the plane, those of the half are not'
  end function reason_against_mirror

  !> Checks that gravity is parallel to the plane and that every loaded or supported surface has an image with the
  !> mirrored load.
  pure subroutine require_loads(scene)
    type(examined_type), intent(inout) :: scene
    integer :: p

    call prove_surfaces(scene)
    if (allocated(scene%reason)) return
    do p = 1, size(scene%phases)
      call prove_phase(scene, scene%phases(p))
    end do
  end subroutine require_loads

  !> Checks that every surface in use has an image, and no faces in the plane.
  pure subroutine prove_surfaces(scene)
    type(examined_type), intent(inout) :: scene
    integer :: s

    do s = 1, size(scene%surfaces)
      associate (surface => scene%surfaces(s))
        if (.not. surface_is_used(scene, surface%name)) cycle
        if (surface_partner(scene, s) == 0) &
          call refuse(scene, card('*SURFACE', surface%name, surface%where)//' has no mirror image')
        if (has_faces_in_plane(scene, surface)) &
          call refuse(scene, card('*SURFACE', surface%name, surface%where)//' may have faces in the plane of symmetry')
      end associate
    end do
  end subroutine prove_surfaces

  !> Checks gravity, loads and supports of a phase.
  pure subroutine prove_phase(scene, phase)
    type(examined_type), intent(inout) :: scene
    type(phase_type), intent(in) :: phase
    integer :: i, s, k

    if (phase%gravity%given .and. abs(phase%gravity%vector(scene%axis)) > 0.0_wp) &
      call refuse(scene, card('*GRAVITY of phase', phase%name, phase%where)//' has a part along '//letters(scene%axis))
    do i = 1, size(phase%tractions)
      if (.not. load_has_image(scene, phase%tractions, phase%tractions(i))) call refuse(scene, card('the load on', &
        phase%tractions(i)%surface, phase%tractions(i)%where)//' has no mirror image')
    end do
    do i = 1, size(phase%supports)
      if (phase%supports(i)%contracts) call refuse(scene, card('*CONTRACTION of', phase%supports(i)%surface, &
        phase%supports(i)%where)//' is about a whole cavity')
      s = surface_partner(scene, place_named(scene%surfaces, phase%supports(i)%surface))
      if (.not. any([(phase%supports(k)%surface == scene%surfaces(s)%name .and. &
        phase%supports(k)%kind == phase%supports(i)%kind, k=1, size(phase%supports))])) &
        call refuse(scene, card('*SUPPORT of', phase%supports(i)%surface, phase%supports(i)%where)// &
        ' has no mirror image')
    end do
  end subroutine prove_phase

  !> Checks whether a cut at the plane may give a surface new faces: its box reaches the plane and is not flat along
  !> another axis, or it is in the plane.
  pure logical function has_faces_in_plane(scene, surface) result(yes)
    type(examined_type), intent(in) :: scene
    type(surface_type), intent(in) :: surface
    real(wp) :: c, tolerance
    logical :: flat
    integer :: a

    yes = .false.
    c = scene%plane
    tolerance = scene%nothing
    select case (surface%selection)
    case (select_segment)
      yes = any(maxval(abs(surface%segments([1, 3], :) - c), dim=1) <= tolerance)
    case (select_box)
      if (surface%box(scene%axis, 1) > c + tolerance .or. surface%box(scene%axis, 2) < c - tolerance) return
      flat = .false.
      do a = 1, merge(3, 2, scene%model == three_dimensional)
        if (a /= scene%axis) flat = flat .or. surface%box(a, 2) - surface%box(a, 1) <= tolerance
      end do
      yes = .not. flat
    end select
  end function has_faces_in_plane

  !> Checks whether the mirror image of a load is among the loads of its phase.
  pure logical function load_has_image(scene, loads, load) result(found)
    type(examined_type), intent(in) :: scene
    !> Loads of the phase, and the load.
    type(traction_type), intent(in) :: loads(:), load
    real(wp) :: image(3)
    integer :: k, s

    s = surface_partner(scene, place_named(scene%surfaces, load%surface))
    image = load%vector
    image(scene%axis) = -image(scene%axis)
    found = .false.
    do k = 1, size(loads)
      if (loads(k)%surface /= scene%surfaces(s)%name) cycle
      if ((loads(k)%follows .neqv. load%follows) .or. loads(k)%carrier /= load%carrier) cycle
      found = found .or. (all(abs(loads(k)%vector - image) <= 0.0_wp) &
        .and. abs(loads(k)%pressure - load%pressure) + abs(loads(k)%gradient - load%gradient) &
        + abs(loads(k)%height - load%height) <= 0.0_wp .and. (loads(k)%of_water .eqv. load%of_water))
    end do
  end function load_has_image

  !> Checks that sets are no lists of labels, that a plate is symmetric, and that reactions are those of symmetric sets
  !> or of one half.
  pure subroutine require_sets(scene)
    type(examined_type), intent(inout) :: scene
    logical :: one_sided
    integer :: p, i

    do p = 1, size(scene%phases)
      do i = 1, size(scene%phases(p)%fixities)
        call refuse_labels(scene, scene%phases(p)%fixities(i)%set)
      end do
      do i = 1, size(scene%phases(p)%prescriptions)
        call refuse_labels(scene, scene%phases(p)%prescriptions(i)%set)
      end do
    end do
    associate (moving => scene%moving_mesh)
      one_sided = moving%active .and. moving%axis == scene%axis
      if (moving%active .and. .not. (one_sided .or. moving%by_body)) &
        one_sided = set_side(scene%members, place_named(scene%node_sets, moving%set), scene%axis) /= side_both
      if (one_sided) call refuse(scene, '*MOVING MESH'//place_text(moving%where)//' is not symmetric')
    end associate
    call require_local_histories(scene)
    do i = 1, size(scene%histories)
      associate (history => scene%histories(i))
        if (history%quantity /= quantity_reaction .or. allocated(scene%reason)) cycle
        if (set_side(scene%members, place_named(scene%node_sets, history%set), scene%axis) == side_mixed) &
          call refuse(scene, card('*HISTORY', history%name, history%where)//" reads a reaction of '"//history%set// &
          "', which is neither symmetric nor in one half")
      end associate
    end do
  end subroutine require_sets

  !> Rejects a list of labels, whose position is not known.
  pure subroutine refuse_labels(scene, name)
    type(examined_type), intent(inout) :: scene
    !> Name of the set.
    character(len=*), intent(in) :: name
    integer :: s

    s = place_named(scene%node_sets, name)
    if (scene%node_sets(s)%selection == select_list) &
      call refuse(scene, card('*NSET', name, scene%node_sets(s)%where)//' is a list of labels')
  end subroutine refuse_labels

  !> Returns the position of a set: in both halves alike, or entirely in one. The plane belongs to neither half.
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

  !> Checks that every node is constrained and displaced like its image, in every phase.
  pure subroutine require_nodes(scene)
    type(examined_type), intent(inout) :: scene
    integer, allocatable :: along(:), first(:), second(:)
    integer :: others(2), node(3), image(3), p, i, j, k, c
    logical :: fixed(3), image_fixed(3)
    real(wp) :: value(3), image_value(3)

    others = pack([1, 2, 3], [1, 2, 3] /= scene%axis)
    call representatives(scene%members, scene%axis, .true., along)
    call representatives(scene%members, others(1), .false., first)
    call representatives(scene%members, others(2), .false., second)
    do p = 1, size(scene%phases)
      do i = 1, size(along)
        do j = 1, size(first)
          do k = 1, size(second)
            node(scene%axis) = along(i)
            node(others) = [first(j), second(k)]
            image = node
            image(scene%axis) = scene%members%count(scene%axis) + 1 - node(scene%axis)
            call node_state(scene, scene%members, node, p, fixed, value)
            call node_state(scene, scene%members, image, p, image_fixed, image_value)
            image_value(scene%axis) = -image_value(scene%axis)
            do c = 1, 3
              if ((fixed(c) .eqv. image_fixed(c)) .and. abs(value(c) - image_value(c)) <= 0.0_wp) cycle
              call refuse(scene, blame(scene, node, image, p, c))
            end do
          end do
        end do
      end do
    end do
  end subroutine require_nodes

  !> Returns the last card that treats a node and its image differently.
  pure function blame(scene, node, image, phase, component) result(text)
    type(examined_type), intent(in) :: scene
    !> The two nodes (3).
    integer, intent(in) :: node(3), image(3)
    !> Number of the phase, and the component.
    integer, intent(in) :: phase, component
    character(len=:), allocatable :: text
    integer, allocatable :: line(:)
    integer :: p, i

    text = 'the supports are not symmetric'
    allocate (line, source=lineage(scene%phases, phase))
    do p = 1, size(line)
      associate (now => scene%phases(line(p)))
        do i = 1, size(now%fixities)
          associate (fixity => now%fixities(i))
            if (any(fixity%fixed) .and. .not. fixity%fixed(component)) cycle
            if (is_one_sided(fixity%set)) text = card('*FIX of', fixity%set, fixity%where)//' has no mirror image'
          end associate
        end do
        do i = 1, size(now%prescriptions)
          associate (prescription => now%prescriptions(i))
            if (prescription%component /= component) cycle
            ! A prescribed displacement along the normal of a set with both nodes is not symmetric.
            if (is_one_sided(prescription%set) .or. (node(component) /= image(component) .and. p == size(line)) .or. &
              (all(node == image) .and. p == size(line))) text = card('*PRESCRIBE of', prescription%set, &
              prescription%where)//' has no mirror image'
          end associate
        end do
      end associate
    end do

  contains

    !> Checks whether a set contains only one of the nodes.
    pure logical function is_one_sided(name)
      !> Name of the set.
      character(len=*), intent(in) :: name
      integer :: s

      s = place_named(scene%node_sets, name)
      is_one_sided = contains_node(scene%members, s, node) .neqv. contains_node(scene%members, s, image)
    end function is_one_sided
  end function blame

  !> Checks that every change of a body has its image in the same phase.
  pure subroutine prove_stages(scene)
    type(examined_type), intent(inout) :: scene
    integer :: p

    do p = 1, size(scene%phases)
      associate (phase => scene%phases(p))
        call prove_list(scene, phase%activations, 'ACTIVATE')
        call prove_list(scene, phase%deactivations, 'DEACTIVATE')
        call prove_list(scene, phase%materials, 'CHANGE MATERIAL')
      end associate
    end do
  end subroutine prove_stages

  !> Checks the changes of one keyword.
  pure subroutine prove_list(scene, changes, keyword)
    type(examined_type), intent(inout) :: scene
    type(body_change_type), intent(in) :: changes(:)
    character(len=*), intent(in) :: keyword
    integer :: i, k, b, partner
    logical :: found

    do i = 1, size(changes)
      b = place_named(scene%bodies, changes(i)%body)
      partner = body_partner(scene, b)
      found = .false.
      do k = 1, size(changes)
        if (partner == 0) exit
        if (changes(k)%body /= scene%bodies(partner)%name) cycle
        found = .true.
        if (allocated(changes(i)%material)) found = changes(k)%material == changes(i)%material
      end do
      if (.not. found) &
        call refuse(scene, '*'//keyword//card(' of', changes(i)%body, changes(i)%where)//' has no mirror image')
    end do
  end subroutine prove_list

  !> Makes the half model and its expansion.
  pure subroutine make_half(scene, step)
    !> The scene, checked to be symmetric; on return its half.
    type(examined_type), intent(inout) :: scene
    !> Expansion step.
    type(reduction_type), intent(out) :: step
    integer :: n, s

    call begin_reduction(scene, reduce_mirror, scene%axis, step)
    step%factor = 2.0_wp
    step%plane = scene%plane
    call half_histories(scene, step)
    call half_sets(scene)
    call keep_supports(scene, [(set_side(scene%members, s, scene%axis) /= side_other, s=1, size(scene%node_sets))], &
      scene%axis, [step%plane], plane_names(scene%axis:scene%axis))
    call half_surfaces(scene)
    call half_rigid_bodies(scene)
    call half_bodies(scene, step)
    call drop_unused(scene)
    n = size(scene%mesh%axes(scene%axis)%lines)/2 + 1
    scene%mesh%axes(scene%axis)%lines = scene%mesh%axes(scene%axis)%lines(:n)
  end subroutine make_half

  !> Replaces histories beyond the plane by those of the mirror image.
  pure subroutine half_histories(scene, step)
    type(examined_type), intent(inout) :: scene
    !> Receives the expansion.
    type(reduction_type), intent(inout) :: step
    logical :: beyond
    integer :: i

    do i = 1, size(scene%histories)
      associate (history => scene%histories(i))
        if (history%quantity == quantity_reaction) then
          select case (set_side(scene%members, place_named(scene%node_sets, history%set), scene%axis))
          case (side_both)
            step%history_factor(i) = merge(0.0_wp, 2.0_wp, history%component == scene%axis)
          case (side_other)
            step%history_factor(i) = merge(-1.0_wp, 1.0_wp, history%component == scene%axis)
          end select
          cycle
        end if
        if (is_taken_at(history%quantity, at_rigid_body)) then
          call mirror_rigid_history(scene, history, step%history_factor(i))
          cycle
        end if
        beyond = history%at(scene%axis) > step%plane
        if (.not. beyond) cycle
        history%at(scene%axis) = 2.0_wp*step%plane - history%at(scene%axis)
        select case (history%quantity)
        case (quantity_displacement, quantity_position)
          if (history%component == scene%axis) step%history_factor(i) = -1.0_wp
          if (history%component == scene%axis .and. history%quantity == quantity_position) &
            step%history_offset(i) = 2.0_wp*step%plane
        case (quantity_stress, quantity_strain)
          if (is_odd(history%component, scene%axis)) step%history_factor(i) = -1.0_wp
        end select
      end associate
    end do
  end subroutine half_histories

  !> Checks whether a stress component changes its sign under reflection: a shear with the normal.
  pure logical function is_odd(component, axis)
    !> 1 to 6: 11, 22, 33, 12, 13, 23; and the axis.
    integer, intent(in) :: component, axis

    is_odd = component == 5 .or. (component == 4 .and. axis == 1) .or. (component == 6 .and. axis == 3)
  end function is_odd

  !> Removes loads and supports of surfaces beyond the plane.
  pure subroutine half_surfaces(scene)
    type(examined_type), intent(inout) :: scene
    integer :: p, i

    do p = 1, size(scene%phases)
      associate (phase => scene%phases(p))
        phase%tractions = phase%tractions(pack([(i, i=1, size(phase%tractions))], &
          .not. [(surface_beyond(scene, phase%tractions(i)%surface), i=1, size(phase%tractions))]))
        phase%supports = phase%supports(pack([(i, i=1, size(phase%supports))], .not. [(surface_beyond(scene, &
          phase%supports(i)%surface), i=1, size(phase%supports))]))
      end associate
    end do
  end subroutine half_surfaces

  !> Checks whether a surface is beyond the plane.
  pure logical function surface_beyond(scene, name) result(beyond)
    type(examined_type), intent(in) :: scene
    !> Name of the surface.
    character(len=*), intent(in) :: name
    integer :: b

    associate (surface => scene%surfaces(place_named(scene%surfaces, name)), nothing => scene%nothing)
      beyond = .false.
      select case (surface%selection)
      case (select_box)
        beyond = surface%box(scene%axis, 1) >= scene%plane - nothing
      case (select_segment)
        beyond = minval(surface%segments([1, 3], :)) >= scene%plane - nothing
      case (select_outline)
        if (surface%boxed) beyond = surface%box(scene%axis, 1) >= scene%plane - nothing
        b = place_named(scene%bodies, surface%body)
        if (b > 0) beyond = beyond .or. body_beyond(scene%bodies(b), scene%axis, scene%plane - nothing)
      end select
    end associate
  end function surface_beyond

  !> Checks whether a body is beyond the plane.
  pure logical function body_beyond(body, axis, plane) result(beyond)
    type(body_type), intent(in) :: body
    integer, intent(in) :: axis
    !> Coordinate of the plane.
    real(wp), intent(in) :: plane

    beyond = .false.
    if (body%kind == body_box) beyond = body%box(axis, 1) >= plane
    if (body%kind == body_polygon .and. axis == 1) beyond = minval(body%polygon(1, :)) >= plane
  end function body_beyond

  !> Removes bodies beyond the plane; the others refer to their images.
  pure subroutine half_bodies(scene, step)
    type(examined_type), intent(inout) :: scene
    !> Receives the bodies of the half and their images.
    type(reduction_type), intent(inout) :: step
    type(body_type), allocatable :: kept(:)
    integer, allocatable :: own(:), image(:)
    integer :: b

    allocate (kept(0), own(0), image(0))
    do b = 1, size(scene%bodies)
      if (body_beyond(scene%bodies(b), scene%axis, step%plane - scene%nothing)) cycle
      kept = [kept, scene%bodies(b)]
      own = [own, b]
      image = [image, body_partner(scene, b)]
      ! A polygon extends through the grid along z.
      if (image(size(image)) == b .and. .not. (scene%axis == 3 .and. &
        kept(size(kept))%kind == body_polygon)) kept(size(kept))%copies = 2.0_wp*kept(size(kept))%copies
    end do
    call move_alloc(kept, scene%bodies)
    call drop_absent(scene)
    call move_alloc(own, step%body)
    call move_alloc(image, step%image_body)
  end subroutine half_bodies

  !> Moves sets of reactions beyond the plane to the other side.
  pure subroutine half_sets(scene)
    type(examined_type), intent(inout) :: scene
    integer :: s

    do s = 1, size(scene%node_sets)
      associate (set => scene%node_sets(s))
        if (set_side(scene%members, s, scene%axis) /= side_other) cycle
        if (set%selection == select_plane) set%box(scene%axis, 1) = 2.0_wp*scene%plane - set%box(scene%axis, 1)
        if (set%selection == select_box) set%box = mirrored_box(set%box, scene%axis, scene%plane)
      end associate
    end do
  end subroutine half_sets

  !> Removes the changes of removed bodies.
  pure subroutine drop_absent(scene)
    type(examined_type), intent(inout) :: scene
    integer :: p

    do p = 1, size(scene%phases)
      associate (phase => scene%phases(p))
        call drop_from(scene%bodies, phase%activations)
        call drop_from(scene%bodies, phase%deactivations)
        call drop_from(scene%bodies, phase%materials)
      end associate
    end do
  end subroutine drop_absent

  !> Removes the changes from one list.
  pure subroutine drop_from(bodies, changes)
    type(body_type), intent(in) :: bodies(:)
    type(body_change_type), allocatable, intent(inout) :: changes(:)
    integer :: i

    changes = changes(pack([(i, i=1, size(changes))], &
      [(place_named(bodies, changes(i)%body) > 0, i=1, size(changes))]))
  end subroutine drop_from
end module qsmpm_mirror
