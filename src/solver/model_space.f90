!> The space of displacements that *METHOD asks for.
module qsmpm_model_space
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: source_line_type, mesh_grid, basis_standard, basis_fem, basis_gimp, basis_spline2, &
    basis_spline3, basis_spline2g, quantity_reaction
  use qsmpm_fault_list, only: fault_list_type, add_fault
  use qsmpm_mesh_sets, only: find_set
  use qsmpm_model, only: model_type
  use qsmpm_space_builder, only: element_space, spline_space, is_structured
  implicit none
  private

  public :: make_space

contains

  !> Build the space; GIMP and splines need a grid of undisturbed quadrilaterals or bricks.
  subroutine make_space(model, faults)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Faults found so far.
    type(fault_list_type), intent(inout) :: faults
    logical :: constrained(size(model%mesh%node_sets))
    integer :: cells(3), a

    if (any(model%analysis%method%basis == [basis_standard, basis_fem])) then
      call element_space(model%mesh, model%space)
      return
    end if
    associate (source => model%analysis%mesh)
      if (source%kind /= mesh_grid) then
        call add_fault(faults, source%where, '*METHOD', &
          'GIMP and splines need a structured grid: give the mesh by *GRID')
        return
      end if
      if (all(source%element /= ['QUAD4', 'HEX8 ']) .or. source%perturbation > 0.0_wp) then
        call add_fault(faults, source%where, '*GRID', &
          'GIMP and splines need ELEMENT=QUAD4 or HEX8 without PERTURB')
        return
      end if
      cells = 1
      do a = 1, model%mesh%dimension
        cells(a) = size(source%axes(a)%lines) - 1
      end do
    end associate
    call mark_constrained(model, cells, constrained, faults)
    call spline_space(model%mesh, cells, degree_of(model%analysis%method%basis), &
      any(model%analysis%method%basis == [basis_gimp, basis_spline2g]), constrained, model%space)
  end subroutine make_space

  !> Degree of the functions.
  pure integer function degree_of(basis)
    !> One of the basis_* values.
    integer, intent(in) :: basis

    select case (basis)
    case (basis_spline2, basis_spline2g)
      degree_of = 2
    case (basis_spline3)
      degree_of = 3
    case default
      degree_of = 1
    end select
  end function degree_of

  !> Node sets that some phase constrains or that are the plate of a moving mesh. Sets that are no box
  !> have no control points: nothing may be asked of them.
  subroutine mark_constrained(model, cells, constrained, faults)
    !> The model.
    type(model_type), intent(in) :: model
    !> Number of cells along each axis.
    integer, intent(in) :: cells(3)
    !> (node sets)
    logical, intent(out) :: constrained(:)
    !> Faults found so far.
    type(fault_list_type), intent(inout) :: faults
    integer :: s, p, i

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
      if (moving%active) call constrain(moving%set, moving%where, '*MOVING MESH')
    end associate
    do i = 1, size(model%analysis%histories)
      associate (history => model%analysis%histories(i))
        if (history%quantity /= quantity_reaction) cycle
        s = find_set(model%mesh%node_sets, history%set)
        if (s == 0) cycle
        if (constrained(s) .or. is_structured(model%mesh, cells, s)) cycle
        call add_fault(faults, history%where, '*HISTORY', no_box(history%set))
      end associate
    end do

  contains

    !> Mark a set; one that is no box is told once.
    subroutine constrain(name, where, keyword)
      !> Name of the set.
      character(len=*), intent(in) :: name
      !> Where it is named, and the card.
      type(source_line_type), intent(in) :: where
      character(len=*), intent(in) :: keyword
      integer :: s

      s = find_set(model%mesh%node_sets, name)
      if (s == 0) return
      if (.not. constrained(s) .and. .not. is_structured(model%mesh, cells, s)) &
        call add_fault(faults, where, keyword, no_box(name))
      constrained(s) = .true.
    end subroutine constrain
  end subroutine mark_constrained

  !> Why a set cannot be constrained.
  pure function no_box(name) result(message)
    !> Name of the set.
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: message

    message = "with GIMP and splines node set '"//name//"' must hold all grid nodes of a plane or box"
  end function no_box
end module qsmpm_model_space
