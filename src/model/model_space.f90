!> The space of displacements that *METHOD asks for.
module qsmpm_model_space
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_history_description, only: quantity_reaction
  use qsmpm_mesh_description, only: mesh_grid, set_type, select_plane, select_box
  use qsmpm_method_description, only: integrate_cells, basis_standard, basis_fem, basis_list
  use qsmpm_source_line, only: source_line_type
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_layer_interfaces, only: interface_type, find_interfaces
  use qsmpm_mesh_sets, only: set_tolerance
  use qsmpm_model, only: model_type
  use qsmpm_space_builder, only: element_space, spline_space, reduced_knots_type
  use qsmpm_grid_window, only: place_of
  use qsmpm_grid_window, only: cells_of
  implicit none
  private

  public :: make_space

  !> A block of grid nodes.
  type :: line_box_type
    !> First and last line along each axis; 1 and 1 along z in the plane.
    integer :: low(3) = 1, high(3) = 1
    !> The set has nodes, and all of the block.
    logical :: whole = .false.
  end type line_box_type

contains

  !> Build the space; GIMP and splines need a grid of undisturbed quadrilaterals or bricks.
  subroutine make_space(model, diagnostics)
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    logical :: constrained(size(model%mesh%node_sets))
    type(line_box_type) :: boxes(size(model%mesh%node_sets))
    type(reduced_knots_type) :: reduced_knots(3)
    integer :: s

    if (any(model%analysis%method%basis == [basis_standard, basis_fem])) then
      call element_space(model%mesh, model%space)
      return
    end if
    associate (source => model%analysis%mesh)
      if (source%kind /= mesh_grid) then
        call add_diagnostic(diagnostics, source%where, '*METHOD', &
          'GIMP and splines need a structured grid: give the mesh by *GRID')
        return
      end if
      if (all(source%element /= ['QUAD4', 'HEX8 ']) .or. source%perturbation > 0.0_wp) then
        call add_diagnostic(diagnostics, source%where, '*GRID', &
          'GIMP and splines need ELEMENT=QUAD4 or HEX8 without PERTURB')
        return
      end if
    end associate
    do s = 1, size(boxes)
      call box_of_set(model, model%analysis%node_sets(s), boxes(s))
    end do
    call mark_constrained(model, boxes, constrained, diagnostics)
    call find_reduced_knots(model, boxes, constrained, reduced_knots)
    associate (basis => basis_list(model%analysis%method%basis))
      call spline_space(model%mesh, cells_of(model%state%window), basis%degree, basis%averaged, constrained, &
        model%space, reduced_knots, model%state%window%first - 1)
    end associate
    ! Splines without averages find their cut cells better by the domains of the points than by the points.
    model%space%domains = model%space%averaged .or. model%analysis%method%integration == integrate_cells
  end subroutine make_space

  !> Lines of the whole grid between which the nodes of a set lie.
  pure subroutine box_of_set(model, set, box)
    type(model_type), intent(in) :: model
    type(set_type), intent(in) :: set
    !> Where it lies.
    type(line_box_type), intent(out) :: box
    integer :: lines(3), at(3), a, i
    real(wp) :: near

    near = set_tolerance(model%mesh)
    lines = 1
    do a = 1, model%mesh%dimension
      associate (x => model%analysis%mesh%axes(a)%lines)
        lines(a) = size(x)
        box%low(a) = 1
        box%high(a) = size(x)
        if (set%selection == select_box .or. (set%selection == select_plane .and. set%axis == a)) then
          box%low(a) = 1 + count(x < set%box(a, 1) - near)
          box%high(a) = count(x <= set%box(a, merge(1, 2, set%selection == select_plane)) + near)
        end if
      end associate
    end do
    box%whole = all(box%low <= box%high)
    if (any(set%selection == [select_plane, select_box])) return
    box%low = lines
    box%high = 1
    do i = 1, size(set%labels)
      at = place_of(set%labels(i), lines)
      box%low = min(box%low, at)
      box%high = max(box%high, at)
    end do
    box%whole = size(set%labels) == product(box%high - box%low + 1)
  end subroutine box_of_set

  !> Reduced knots of the whole grid: where a constrained set begins or ends, and where layers of different
  !> stiffness meet.
  pure subroutine find_reduced_knots(model, boxes, constrained, reduced_knots)
    type(model_type), intent(in) :: model
    !> Where the sets lie, and which of them carry constraints (node sets).
    type(line_box_type), intent(in) :: boxes(:)
    logical, intent(in) :: constrained(:)
    !> Along each axis.
    type(reduced_knots_type), intent(out) :: reduced_knots(3)
    type(interface_type), allocatable :: interfaces(:)
    integer :: a, s

    call find_interfaces(model%analysis, interfaces)
    do a = 1, model%mesh%dimension
      allocate (reduced_knots(a)%at(size(model%analysis%mesh%axes(a)%lines)))
      reduced_knots(a)%at = .false.
      do s = 1, size(boxes)
        if (constrained(s) .and. boxes(s)%whole) reduced_knots(a)%at([boxes(s)%low(a), boxes(s)%high(a)]) = .true.
      end do
      reduced_knots(a)%at(pack(interfaces%line, interfaces%axis == a)) = .true.
    end do
  end subroutine find_reduced_knots

  !> Node sets that some phase constrains or that are the plate of a moving mesh. Sets that are no box
  !> have no control points: nothing may be asked of them.
  subroutine mark_constrained(model, boxes, constrained, diagnostics)
    type(model_type), intent(in) :: model
    !> Where the sets lie (node sets).
    type(line_box_type), intent(in) :: boxes(:)
    !> (node sets)
    logical, intent(out) :: constrained(:)
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: p, i

    constrained = .false.
    do p = 1, size(model%analysis%phases)
      associate (phase => model%analysis%phases(p))
        do i = 1, size(phase%fixities)
          call constrain(phase%fixities(i)%set, phase%fixities(i)%where, '*FIX')
        end do
        do i = 1, size(phase%prescriptions)
          call constrain(phase%prescriptions(i)%set, phase%prescriptions(i)%where, '*PRESCRIBE')
        end do
      end associate
    end do
    associate (moving => model%analysis%moving_mesh)
      if (moving%active .and. .not. moving%by_body) call constrain(moving%set, moving%where, '*MOVING MESH')
    end associate
    call check_reactions(model, boxes, constrained, diagnostics)

  contains

    !> Mark a set; one that is no box is named once.
    subroutine constrain(name, where, keyword)
      character(len=*), intent(in) :: name
      !> Where it is named, and the card.
      type(source_line_type), intent(in) :: where
      character(len=*), intent(in) :: keyword
      integer :: s

      s = place_named(model%mesh%node_sets, name)
      if (s == 0) return
      if (.not. constrained(s) .and. .not. boxes(s)%whole) &
        call add_diagnostic(diagnostics, where, keyword, no_box(name))
      constrained(s) = .true.
    end subroutine constrain
  end subroutine mark_constrained

  !> Sets whose reaction a history asks for are boxes; those that are constrained have been checked.
  subroutine check_reactions(model, boxes, constrained, diagnostics)
    type(model_type), intent(in) :: model
    !> Where the sets lie, and which of them carry constraints (node sets).
    type(line_box_type), intent(in) :: boxes(:)
    logical, intent(in) :: constrained(:)
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: i, s

    do i = 1, size(model%analysis%histories)
      associate (history => model%analysis%histories(i))
        if (history%quantity /= quantity_reaction) cycle
        s = place_named(model%mesh%node_sets, history%set)
        if (s == 0) cycle
        if (constrained(s) .or. boxes(s)%whole) cycle
        call add_diagnostic(diagnostics, history%where, '*HISTORY', no_box(history%set))
      end associate
    end do
  end subroutine check_reactions

  !> Why a set cannot be constrained.
  pure function no_box(name) result(message)
    !> Name of the set.
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: message

    message = "with GIMP and splines node set '"//name//"' must hold all grid nodes of a plane or box"
  end function no_box
end module qsmpm_model_space
