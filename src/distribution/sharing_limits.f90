!> Features that a team of processes does not support yet; they are rejected by name before the analysis starts.
module qsmpm_sharing_limits
  use qsmpm_analysis, only: analysis_type
  use qsmpm_method_description, only: basis_fem
  use qsmpm_carried_cards, only: not_carried
  use qsmpm_cell_sharing, only: has_boxes
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_model, only: model_type
  use qsmpm_material_parameters, only: regularise_nonlocal
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: refuse_sharing

contains

  !> Rejects a model that cannot be divided.
  subroutine refuse_sharing(model, ranks, error)
    type(model_type), intent(in) :: model
    !> Number of processes.
    integer, intent(in) :: ranks
    !> error_deck: all unsupported features, by keyword.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: list

    if (ranks == 1) return
    list = ''
    call refuse_mesh(model%analysis, list)
    associate (analysis => model%analysis)
      if (allocated(model%contact_pairs) .and. .not. has_boxes(analysis)) then
        if (any(model%contact_pairs%surface == 0)) call add(list, 'ON=BODY of *CONTACT on this mesh')
      end if
    end associate
    if (len(not_carried(model%analysis)) > 0) call add(list, not_carried(model%analysis))
    if (size(model%analysis%props) > 0) call add(list, '*PROP')
    if (any(model%analysis%materials%softening%given .and. model%analysis%materials%softening%regularisation == &
      regularise_nonlocal)) call add(list, 'REGULARISATION=NONLOCAL of *SOFTENING')
    if (allocated(model%loading%point_force)) call add(list, 'forces on material points')
    if (len(list) == 0) return
    call fail(error, error_deck, integer_text(ranks)//' processes cannot share this deck yet, for it has '//list// &
      ': run it on one (docs/distributed.md)')
  end subroutine refuse_sharing

  !> Collects unsupported features of the mesh.
  subroutine refuse_mesh(analysis, list)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable, intent(inout) :: list

    if (analysis%method%basis == basis_fem) call add(list, 'BASIS=FEM')
    if (analysis%moving_mesh%active) call add(list, '*MOVING MESH')
  end subroutine refuse_mesh

  !> Adds a feature once.
  subroutine add(list, name)
    character(len=:), allocatable, intent(inout) :: list
    character(len=*), intent(in) :: name

    if (index(list, name) > 0) return
    if (len(list) > 0) list = list//'; '
    list = list//name
  end subroutine add
end module qsmpm_sharing_limits
