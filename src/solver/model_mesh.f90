!> The mesh of a model and the sets of the deck on it.
module qsmpm_model_mesh
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_analysis, only: mesh_grid, mesh_file, mesh_inline, select_list, select_box, select_plane, &
    body_polygon, three_dimensional, body_type, set_type, source_line_type
  use qsmpm_element, only: element_from_name, local_dimension
  use qsmpm_fault_list, only: fault_list_type, add_fault
  use qsmpm_model, only: model_type
  use qsmpm_grid, only: grid_type, make_grid
  use qsmpm_mesh_readers, only: read_mesh
  use qsmpm_inline_mesh, only: inline_mesh
  use qsmpm_mesh_topology, only: build_topology
  use qsmpm_mesh_sets, only: nodes_in_box, nodes_on_plane, find_set, add_set
  implicit none
  private

  public :: make_mesh, make_sets

contains

  !> Generate or read the mesh, and build its tables.
  subroutine make_mesh(model, faults)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Faults found so far.
    type(fault_list_type), intent(inout) :: faults
    type(error_type), allocatable :: error

    associate (source => model%analysis%mesh)
      select case (source%kind)
      case (mesh_grid)
        call generate(model)
      case (mesh_file)
        call read_mesh(source%file, source%format, model%mesh, error)
      case (mesh_inline)
        call inline_mesh(element_from_name(source%element), source%node_labels, source%nodes, &
          source%element_labels, source%connectivity, model%mesh, error)
      end select
      if (.not. allocated(error)) then
        if (model%mesh%dimension /= merge(3, 2, model%analysis%model == three_dimensional)) then
          call add_fault(faults, source%where, keyword_of(source%kind), &
            'the mesh has not the dimension of *MODEL')
          return
        end if
        call build_topology(model%mesh, error)
      end if
      if (allocated(error)) call add_fault(faults, source%where, keyword_of(source%kind), error%message)
    end associate
  end subroutine make_mesh

  !> Keyword a mesh comes from.
  pure function keyword_of(kind) result(keyword)
    !> Element kind.
    integer, intent(in) :: kind
    character(len=:), allocatable :: keyword

    select case (kind)
    case (mesh_grid)
      keyword = '*GRID'
    case (mesh_file)
      keyword = '*MESH'
    case default
      keyword = '*ELEMENT'
    end select
  end function keyword_of

  !> A structured grid that respects the edges of polygonal bodies.
  subroutine generate(model)
    !> The model.
    type(model_type), intent(inout) :: model
    type(grid_type) :: grid
    integer :: i

    associate (source => model%analysis%mesh)
      grid%kind = element_from_name(source%element)
      do i = 1, local_dimension(grid%kind)
        grid%axes(i)%lines = source%axes(i)%lines
      end do
      grid%diagonal = source%diagonal
      grid%perturbation = source%perturbation
      grid%seed = source%seed
    end associate
    allocate (grid%kept(4, 0))
    do i = 1, size(model%analysis%bodies)
      if (model%analysis%bodies(i)%kind == body_polygon) call add_edges(model%analysis%bodies(i), grid%kept)
    end do
    call make_grid(grid, model%mesh)
  end subroutine generate

  !> Append the edges of a polygon.
  subroutine add_edges(body, segments)
    !> Number of the body.
    type(body_type), intent(in) :: body
    real(wp), allocatable, intent(inout) :: segments(:, :)
    real(wp), allocatable :: longer(:, :)
    integer :: k, n

    n = size(body%polygon, 2)
    allocate (longer(4, size(segments, 2) + n))
    longer(:, :size(segments, 2)) = segments
    do k = 1, n
      longer(:, size(segments, 2) + k) = [body%polygon(:, k), body%polygon(:, mod(k, n) + 1)]
    end do
    call move_alloc(longer, segments)
  end subroutine add_edges

  !> Sets of the deck, and the check that every set a phase names exists.
  subroutine make_sets(model, faults)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Faults found so far.
    type(fault_list_type), intent(inout) :: faults
    integer :: i, p

    do i = 1, size(model%analysis%node_sets)
      call make_node_set(model, model%analysis%node_sets(i), faults)
    end do
    do i = 1, size(model%analysis%element_sets)
      call make_cell_set(model, model%analysis%element_sets(i), faults)
    end do
    do p = 1, size(model%analysis%phases)
      associate (phase => model%analysis%phases(p))
        do i = 1, size(phase%fixities)
          call require(model, phase%fixities(i)%set, phase%fixities(i)%where, '*FIX', faults)
        end do
        do i = 1, size(phase%prescriptions)
          call require(model, phase%prescriptions(i)%set, phase%prescriptions(i)%where, '*PRESCRIBE', faults)
        end do
      end associate
    end do
    if (model%analysis%moving_mesh%active) call require(model, model%analysis%moving_mesh%set, &
      model%analysis%moving_mesh%where, '*MOVING MESH', faults)
  end subroutine make_sets

  !> A named node set must exist.
  subroutine require(model, name, where, keyword, faults)
    !> The model.
    type(model_type), intent(in) :: model
    !> Name.
    character(len=*), intent(in) :: name
    type(source_line_type), intent(in) :: where
    character(len=*), intent(in) :: keyword
    !> Faults found so far.
    type(fault_list_type), intent(inout) :: faults

    if (find_set(model%mesh%node_sets, name) == 0) &
      call add_fault(faults, where, keyword, "there is no node set '"//name//"' in the deck or the mesh")
  end subroutine require

  !> One node set; labels must exist and a selector must find something.
  subroutine make_node_set(model, set, faults)
    !> The model.
    type(model_type), intent(inout) :: model
    !> The set.
    type(set_type), intent(in) :: set
    !> Faults found so far.
    type(fault_list_type), intent(inout) :: faults
    integer, allocatable :: items(:)
    integer :: i

    select case (set%selection)
    case (select_plane)
      call nodes_on_plane(model%mesh, set%axis, set%box(set%axis, 1), items)
    case (select_box)
      call nodes_in_box(model%mesh, set%box, items)
    case default
      items = pack([(i, i=1, model%mesh%node_count)], &
        [(any(set%labels == model%mesh%node_label(i)), i=1, model%mesh%node_count)])
      if (size(items) < size(set%labels)) &
        call add_fault(faults, set%where, '*NSET', "set '"//set%name//"' names nodes the mesh has not")
    end select
    if (size(items) == 0) call add_fault(faults, set%where, '*NSET', "set '"//set%name//"' finds no node")
    call add_set(model%mesh%node_sets, set%name, items)
  end subroutine make_node_set

  !> One element set: labels, or the elements whose nodes all lie in a box.
  subroutine make_cell_set(model, set, faults)
    !> The model.
    type(model_type), intent(inout) :: model
    !> The set.
    type(set_type), intent(in) :: set
    !> Faults found so far.
    type(fault_list_type), intent(inout) :: faults
    integer, allocatable :: nodes(:), items(:)
    logical :: inside(model%mesh%node_count), chosen(model%mesh%cell_count)
    integer :: c

    inside = .false.
    if (set%selection == select_box) then
      call nodes_in_box(model%mesh, set%box, nodes)
      inside(nodes) = .true.
    end if
    do c = 1, model%mesh%cell_count
      if (set%selection == select_list) then
        chosen(c) = any(set%labels == model%mesh%cell_label(c))
      else
        chosen(c) = all(inside(model%mesh%cell_nodes(model%mesh%cell_first(c):model%mesh%cell_first(c + 1) - 1)))
      end if
    end do
    items = pack([(c, c=1, model%mesh%cell_count)], chosen)
    if (size(items) == 0) call add_fault(faults, set%where, '*ELSET', "set '"//set%name//"' finds no element")
    call add_set(model%mesh%cell_sets, set%name, items)
  end subroutine make_cell_set
end module qsmpm_model_mesh
