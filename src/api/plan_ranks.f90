!> What a deck would be on several processes, for `qsmpm plan --ranks`: the points and equations of each, the copies in
!> the rings around them, and memory. Boxes, rings and owners are those of a run (qsmpm_division), on the points as they
!> lie before the first step; memory is an estimate, by what was measured of a point and of PETSc's matrices.
module qsmpm_plan_ranks
  use qsmpm_kinds, only: wp
  use qsmpm_basis_traits, only: basis_list
  use qsmpm_cell_numbers, only: whole_cells
  use qsmpm_division, only: ring_of, share_cells
  use qsmpm_nodal_fields, only: count_node_equations
  use qsmpm_error, only: error_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: is_divided_as_built
  use qsmpm_number_text, only: integer_text
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_own_marks, only: node_owners
  use qsmpm_plan_items, only: plan_items_type, add_heading, add_item
  use qsmpm_sharing_limits, only: refuse_sharing
  implicit none
  private

  public :: plan_ranks

  !> Bytes of the program with its libraries, of a point with its cell and the state before the step, and of an entry: a
  !> number and its column; fitted to runs with PETSC of 22 000 to 2.7 million points (docs/distributed.md).
  real(wp), parameter :: bytes_of_program = 60.0e6_wp, bytes_of_point = 1500.0_wp, bytes_of_entry = 12.0_wp
  !> The matrix, its copy in PETSc, the coarser ones and the vectors of the method.
  real(wp), parameter :: matrices = 3.0_wp
  real(wp), parameter :: megabyte = 1.0e6_wp

contains

  !> Add what is known of a run on so many processes.
  subroutine plan_ranks(model, ranks, items)
    type(model_type), intent(in) :: model
    !> Two at the least.
    integer, intent(in) :: ranks
    type(plan_items_type), intent(inout) :: items
    type(error_type), allocatable :: error
    integer :: own(ranks), copies(ranks), equations(ranks)
    logical :: short

    call add_heading(items, integer_text(ranks)//' processes')
    call refuse_sharing(model, ranks, error)
    if (allocated(error)) then
      call add_item(items, 'not shared', error%message)
      return
    end if
    call count_parts(model, ranks, own, copies, equations, short)
    if (short) then
      call add_item(items, 'not shared', 'the material lies in too few cells of the mesh')
      return
    end if
    call add_item(items, 'points of a process', integer_text(minval(own))//' to '//integer_text(maxval(own)))
    call add_item(items, 'imbalance', rounded_text(maxval(own)*real(ranks, wp)/sum(own), 3), is_figure=.true.)
    call add_item(items, 'copies in its ring', integer_text(minval(copies))//' to '//integer_text(maxval(copies)))
    call add_item(items, 'copies of a point', rounded_text(sum(copies)/real(sum(own), wp), 3), is_figure=.true.)
    call add_item(items, 'equations of a process', integer_text(minval(equations))//' to '// &
      integer_text(maxval(equations)))
    call add_item(items, 'memory of a process', memory_text(model, maxval(own + copies), maxval(equations)))
  end subroutine plan_ranks

  !> Own points, copies and equations of each process.
  subroutine count_parts(model, ranks, own, copies, equations, short)
    type(model_type), intent(in) :: model
    integer, intent(in) :: ranks
    !> (ranks)
    integer, intent(out) :: own(:), copies(:), equations(:)
    !> There are too few cells with material.
    logical, intent(out) :: short
    class(model_type), allocatable :: shared
    integer, allocatable :: cell(:), owner(:), of_node(:)
    integer :: r, a

    allocate (shared, source=model)
    own = 0
    copies = 0
    equations = 0
    call share_cells(shared, ranks, short)
    if (short) return
    cell = whole_cells(shared, shared%state%points%cell(:shared%state%points%count))
    do r = 1, ranks
      own(r) = count(shared%part%owners%near(r - 1, 0, cell))
      copies(r) = count(shared%part%owners%near(r - 1, ring_of(model%analysis), cell)) - own(r)
    end do
    allocate (owner, source=node_owners(shared))
    allocate (of_node(shared%space%node_count))
    call count_node_equations(shared, of_node)
    do a = 1, size(owner)
      equations(owner(a) + 1) = equations(owner(a) + 1) + of_node(a)
    end do
  end subroutine count_parts

  !> Memory of the process that has most, and of the points of the whole model where every process builds it.
  function memory_text(model, points, equations) result(text)
    type(model_type), intent(in) :: model
    !> Own ones and copies, and equations.
    integer, intent(in) :: points, equations
    character(len=:), allocatable :: text
    real(wp) :: entries

    associate (d => model%mesh%dimension, degree => max(1, basis_list(model%analysis%method%basis)%degree))
      entries = real(d*(2*degree + 1)**d, wp)
    end associate
    text = rounded_text((bytes_of_program + points*bytes_of_point + &
      equations*entries*bytes_of_entry*matrices)/megabyte, 2)//' MB with PETSC'
    if (.not. is_divided_as_built(model%analysis)) text = text//'; '// &
      rounded_text(model%state%points%count*bytes_of_point/megabyte, 2)//' MB of points while the model is built whole'
  end function memory_text
end module qsmpm_plan_ranks
