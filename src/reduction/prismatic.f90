!> A 3D scene that does not depend on z, held along z at both ends, as a model of plane strain.
!>
!> Proof: `qsmpm_uniform_axis`, and elements in layers (bricks, wedges). The plane element is the face
!> of the brick or wedge, its points are those of one layer; forces and work of the scene are the
!> thickness times those of the model.
module qsmpm_prismatic
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: analysis_type, three_dimensional, plane_strain
  use qsmpm_history_description, only: quantity_displacement, quantity_position, quantity_stress, quantity_reaction, &
    quantity_strain, quantity_volume
  use qsmpm_load_description, only: fixity_type
  use qsmpm_method_description, only: basis_fem
  use qsmpm_element, only: element_from_name, seed_rule, full_rule
  use qsmpm_error, only: error_type
  use qsmpm_history_quantities, only: is_taken_at, has_components, at_body, at_rigid_body, component_vector
  use qsmpm_reduction, only: reduction_type, reduce_prismatic, refuse, place_text, begin_reduction
  use qsmpm_set_members, only: members_type, find_members, covers_axis, scene_tolerance
  use qsmpm_loaded_surfaces, only: drop_unused
  use qsmpm_rigid_reduction, only: flatten_rigid_bodies, reduce_rigid_history
  use qsmpm_uniform_axis, only: require_uniform
  implicit none
  private

  public :: require_prismatic, make_plane

contains

  !> Prove that a scene is prismatic along z.
  pure subroutine require_prismatic(analysis, reason)
    type(analysis_type), intent(in) :: analysis
    !> Why not; unallocated when proved.
    character(len=:), allocatable, intent(out) :: reason
    integer :: b
    type(reduction_type) :: step
    logical :: known

    if (analysis%model /= three_dimensional) then
      call refuse(reason, 'the scene is plane already')
      return
    end if
    call require_uniform(analysis, 3, reason)
    if (allocated(reason)) return
    if (len(plane_element(analysis%mesh%element)) == 0) then
      call refuse(reason, 'the tetrahedra of *GRID'//place_text(analysis%mesh%where)//' do not lie in layers along z')
      return
    end if
    call require_histories(analysis, reason)
    do b = 1, size(analysis%bodies)
      call find_layers(analysis, analysis%bodies(b)%points_per_element, step, known)
      ! The reader of points tells which numbers there are; here the scene is only left as it is.
      if (.not. known) call refuse(reason, "*BODY '"//analysis%bodies(b)%name//"'"// &
        place_text(analysis%bodies(b)%where)//': there is no such number of points per element')
    end do
  end subroutine require_prismatic

  !> The plane element a brick or wedge stands on, empty for a tetrahedron.
  pure function plane_element(element) result(name)
    !> Element name.
    character(len=*), intent(in) :: element
    character(len=:), allocatable :: name

    select case (element)
    case ('HEX8')
      name = 'QUAD4'
    case ('HEX20')
      name = 'QUAD8'
    case ('WEDGE6')
      name = 'TRI3'
    case ('WEDGE15')
      name = 'TRI6'
    case default
      name = ''
    end select
  end function plane_element

  !> Histories are inside the thickness, and reactions can be taken from the plane.
  pure subroutine require_histories(analysis, reason)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable, intent(inout) :: reason
    type(members_type) :: members
    integer :: i, s

    call find_members(analysis, members)
    do i = 1, size(analysis%histories)
      associate (history => analysis%histories(i), lines => analysis%mesh%axes(3)%lines)
        if (is_taken_at(history%quantity, at_rigid_body)) cycle
        if (is_taken_at(history%quantity, at_body) .or. len(history%surface) > 0) then
          if (has_components(history%quantity, component_vector) .and. history%component == 3) call refuse(reason, &
            "*HISTORY '"//history%name//"'"//place_text(history%where)//' reads a component along z')
        else if (history%quantity == quantity_reaction) then
          s = place_named(analysis%node_sets, history%set)
          if (.not. covers_axis(members, s, 3)) call refuse(reason, "*HISTORY '"//history%name//"'"// &
            place_text(history%where)//" reads a reaction of '"//history%set//"', which depends on z")
          if (history%component == 3) call refuse(reason, "*HISTORY '"//history%name//"'"// &
            place_text(history%where)//' reads a reaction along z')
        else if (history%at(3) < lines(1) - scene_tolerance(analysis) .or. &
          history%at(3) > lines(size(lines)) + scene_tolerance(analysis)) then
          call refuse(reason, "*HISTORY '"//history%name//"'"//place_text(history%where)//' is outside the grid')
        end if
      end associate
    end do
  end subroutine require_histories

  !> The plane model of a prismatic scene, and the way back.
  pure subroutine make_plane(analysis, step)
    !> The scene, proved to be prismatic; the model.
    type(analysis_type), intent(inout) :: analysis
    !> The way back.
    type(reduction_type), intent(out) :: step
    logical :: known
    integer :: b, s

    call begin_reduction(analysis, reduce_prismatic, 3, step)
    associate (lines => analysis%mesh%axes(3)%lines)
      step%factor = lines(size(lines)) - lines(1)
    end associate
    allocate (step%layers(size(analysis%bodies)))
    do b = 1, size(analysis%bodies)
      associate (body => analysis%bodies(b))
        call find_layers(analysis, body%points_per_element, step, known, b)
        body%points_per_element = plane_points(analysis, body%points_per_element)
        body%box(3, :) = 0.0_wp
      end associate
    end do
    call plane_histories(analysis, step)
    call plane_supports(analysis)
    call flatten_rigid_bodies(analysis, [3], step%factor)
    call drop_unused(analysis)
    do s = 1, size(analysis%node_sets)
      analysis%node_sets(s)%box(3, :) = 0.0_wp
    end do
    do s = 1, size(analysis%surfaces)
      analysis%surfaces(s)%box(3, :) = 0.0_wp
    end do
    analysis%mesh%element = plane_element(analysis%mesh%element)
    deallocate (analysis%mesh%axes(3)%lines)
    analysis%model = plane_strain
  end subroutine make_plane

  !> The rule that seeds an element in 3D.
  pure subroutine solid_rule(analysis, count, places, weights, known)
    !> The scene in 3D.
    type(analysis_type), intent(in) :: analysis
    !> Points per element, 0 for the default.
    integer, intent(in) :: count
    !> Local coordinates (3, n) and weights (n).
    real(wp), allocatable, intent(out) :: places(:, :), weights(:)
    !> There is such a rule.
    logical, intent(out) :: known
    type(error_type), allocatable :: error

    known = .true.
    if (analysis%method%basis == basis_fem .and. count == 0) then
      call full_rule(element_from_name(analysis%mesh%element), places, weights)
    else
      call seed_rule(element_from_name(analysis%mesh%element), count, analysis%method%basis == basis_fem, places, &
        weights, error)
      known = .not. allocated(error)
    end if
  end subroutine solid_rule

  !> Layers of the points of an element: those of equal local z.
  pure subroutine find_layers(analysis, count, step, known, body)
    !> The scene in 3D.
    type(analysis_type), intent(in) :: analysis
    !> Points per element, 0 for the default.
    integer, intent(in) :: count
    !> Gets the layers of the body.
    type(reduction_type), intent(inout) :: step
    !> There is such a number of points.
    logical, intent(out) :: known
    !> Number of the body; without it only `known` is found.
    integer, intent(in), optional :: body
    real(wp), allocatable :: places(:, :), weights(:)
    integer :: q, n, layers

    call solid_rule(analysis, count, places, weights, known)
    if (.not. known .or. .not. present(body)) return
    n = points_in_layer(places)
    layers = size(weights)/n
    associate (layer => step%layers(body))
      allocate (layer%place(layers), layer%share(layers))
      do q = 1, layers
        layer%place(q) = 0.5_wp*(1.0_wp + places(3, (q - 1)*n + 1))
        layer%share(q) = sum(weights((q - 1)*n + 1:q*n))/sum(weights)
      end do
    end associate
  end subroutine find_layers

  !> Points of the first layer of a rule: those before local z changes.
  pure integer function points_in_layer(places) result(n)
    !> Local coordinates (3, n), layer after layer.
    real(wp), intent(in) :: places(:, :)

    n = count(abs(places(3, :) - places(3, 1)) < 1.0e-6_wp)
  end function points_in_layer

  !> Points per element of the plane model; 0 keeps the Gauss rule of FEM.
  pure integer function plane_points(analysis, count) result(n)
    !> The scene in 3D.
    type(analysis_type), intent(in) :: analysis
    !> Points per element, 0 for the default.
    integer, intent(in) :: count
    real(wp), allocatable :: places(:, :), weights(:)
    logical :: known

    n = 0
    if (analysis%method%basis == basis_fem .and. count == 0) return
    call solid_rule(analysis, count, places, weights, known)
    n = points_in_layer(places)
  end function plane_points

  !> Histories in the plane. What has a z component stands still.
  pure subroutine plane_histories(analysis, step)
    type(analysis_type), intent(inout) :: analysis
    !> Gets the way back.
    type(reduction_type), intent(inout) :: step
    integer :: i

    do i = 1, size(analysis%histories)
      associate (history => analysis%histories(i))
        select case (history%quantity)
        case (quantity_displacement, quantity_position)
          if (history%component == 3) then
            step%history_factor(i) = 0.0_wp
            if (history%quantity == quantity_position) step%history_offset(i) = history%at(3)
            history%component = 1
          end if
        case (quantity_stress, quantity_strain)
          if (history%component > 4) then
            step%history_factor(i) = 0.0_wp
            history%component = 4
          end if
        case (quantity_reaction, quantity_volume)
          step%history_factor(i) = step%factor
        end select
        call reduce_rigid_history(history, [3], step%factor, step%history_factor(i))
        history%at(3) = 0.0_wp
      end associate
    end do
  end subroutine plane_histories

  !> Fixities and prescriptions of the plane: what only holds along z is left out.
  pure subroutine plane_supports(analysis)
    type(analysis_type), intent(inout) :: analysis
    type(fixity_type), allocatable :: fixities(:)
    integer :: p, i

    do p = 1, size(analysis%phases)
      associate (phase => analysis%phases(p))
        allocate (fixities(0))
        do i = 1, size(phase%fixities)
          if (phase%fixities(i)%fixed(3) .and. .not. any(phase%fixities(i)%fixed(:2))) cycle
          fixities = [fixities, phase%fixities(i)]
          fixities(size(fixities))%fixed(3) = .false.
        end do
        phase%prescriptions = phase%prescriptions(pack([(i, i=1, size(phase%prescriptions))], &
          phase%prescriptions%component /= 3))
        call move_alloc(fixities, phase%fixities)
      end associate
    end do
  end subroutine plane_supports
end module qsmpm_prismatic
