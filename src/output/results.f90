!> Results as numbers: `results.h5` with one group a picture under /steps, the way a body fails in a safety phase under
!> /mechanisms by the number of the phase, and the mesh under /mesh. Beside the points of a picture are the rigid
!> bodies, the contacts and the water levels (qsmpm_surroundings).
!>
!> The group of each picture lives in a file of its own, `results/NNNNNN.h5`, and the mesh in
!> `results/mesh.h5`; `results.h5` holds links to them, which every HDF5 reader follows. So each
!> file is written once and whole, a run of any length never rewrites what it has, and a run that
!> was interrupted and continued leaves the same bytes as one that was not.
!>
!> Of a model that is divided each process gives the rows of its own points, contacts, cells and nodes
!> (qsmpm_hdf5_image). Points carry their `number` then beside what they carry alone.
module qsmpm_results
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type
  use qsmpm_field_list, only: field_type, field_list_type, row_components, shown_in_results
  use qsmpm_fields, only: padded, list_results
  use qsmpm_file, only: file_exists
  use qsmpm_hdf5_image, only: image_type, create_image, put_group, put_array, put_attribute, put_link, save_image
  use qsmpm_element, only: vtk_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_sets, only: take_cells
  use qsmpm_model, only: model_type
  use qsmpm_number_text, only: numbered
  use qsmpm_own_part, only: is_divided, own_of
  use qsmpm_shared_file, only: of_ranks
  use qsmpm_surroundings, only: put_surroundings
  use qsmpm_stress_error, only: stress_error_type
  use qsmpm_team, only: total
  implicit none
  private

  public :: write_mesh_results, write_state, write_results_index

  !> Folder of the parts beside results.h5.
  character(len=*), parameter, public :: results_folder = 'results'
  !> Before the number of the phase in the names of files of mechanisms.
  character(len=*), parameter, public :: mechanism_part = 'mechanism_'

contains

  !> Write the mesh as it was built: node coordinates, cells in compressed rows, VTK cell types,
  !> labels of the input. Processes give the nodes of their own cells, those at borders each.
  subroutine write_mesh_results(directory, model, error)
    !> Where the results are.
    character(len=*), intent(in) :: directory
    type(model_type), intent(in) :: model
    !> Set when the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    type(image_type) :: image
    type(mesh_type) :: own
    integer, allocatable :: nodes(:)
    integer :: c

    call create_image(image, model%part%team)
    call put_group(image, '/mesh')
    if (is_divided(model%part)) then
      call take_cells(model%mesh, pack([(c, c=1, model%mesh%cell_count)], model%part%cells), own, nodes)
      call put_mesh(image, own)
    else
      call put_mesh(image, model%mesh)
    end if
    call put_attribute(image, '/mesh', 'dimension', model%mesh%dimension)
    call save_image(image, part_path(directory, 'mesh'), .false., error)
  end subroutine write_mesh_results

  !> Put a mesh; that of a process stands behind those of others.
  subroutine put_mesh(image, mesh)
    type(image_type), intent(inout) :: image
    type(mesh_type), intent(in) :: mesh
    real(wp), allocatable :: reals(:, :)
    integer(long), dimension(image%team%ranks) :: nodes, corners
    integer :: c

    nodes = of_ranks(image%team, int(mesh%node_count, long))
    corners = of_ranks(image%team, size(mesh%cell_nodes, kind=long))
    call padded(mesh%coordinates, 3, reals)
    call put_array(image, '/mesh/coordinates', reals, rows=.true.)
    associate (before => image%team%rank)
      call put_array(image, '/mesh/cell_nodes', mesh%cell_nodes - 1 + int(sum(nodes(:before))), rows=.true.)
      call put_array(image, '/mesh/cell_offsets', mesh%cell_first(merge(1, 2, before == 0):) - 1 + &
        int(sum(corners(:before))), rows=.true.)
    end associate
    call put_array(image, '/mesh/cell_types', [(vtk_type(mesh%cell_kind(c)), c=1, mesh%cell_count)], rows=.true.)
    call put_array(image, '/mesh/node_labels', mesh%node_label, rows=.true.)
    call put_array(image, '/mesh/cell_labels', mesh%cell_label, rows=.true.)
  end subroutine put_mesh

  !> Write the fields of a state, or of the way a body fails: displacements and strains of the state are those of it.
  subroutine write_state(directory, name, model, estimate, error)
    !> Where the results are, and the number of the step, or that of the phase behind `mechanism_part`.
    character(len=*), intent(in) :: directory, name
    type(model_type), intent(in) :: model
    !> Estimated error of its stresses.
    type(stress_error_type), intent(in) :: estimate
    !> Set when the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    type(image_type) :: image

    associate (progress => model%state%progress)
      call create_image(image, model%part%team)
      call put_group(image, '/step')
      call put_attribute(image, '/step', 'step', progress%step)
      call put_attribute(image, '/step', 'phase', progress%phase)
      call put_attribute(image, '/step', 'load_factor', progress%load_factor)
      call put_attribute(image, '/step', 'stress_error_mean', estimate%mean)
      call put_attribute(image, '/step', 'stress_error_largest', estimate%largest)
      call put_attribute(image, '/step', 'stress_error_surface', estimate%surface_mean)
      call put_group(image, '/step/points')
    end associate
    call put_points(image, model, estimate)
    call put_surroundings(image, '/step', model)
    call save_image(image, part_path(directory, name), .false., error)
  end subroutine write_state

  !> Put the material points, each process its own: the fields that they carry on some process.
  subroutine put_points(image, model, estimate)
    type(image_type), intent(inout) :: image
    type(model_type), intent(in) :: model
    type(stress_error_type), intent(in) :: estimate
    type(field_list_type) :: list
    integer(long), allocatable :: carried(:)
    integer, allocatable :: own(:)
    integer :: i

    call list_results(model, estimate, list)
    associate (points => model%state%points)
      own = pack([(i, i=1, points%count)], own_of(model%part%points, points%count))
      if (is_divided(model%part)) call put_array(image, '/step/points/number', points%number(own), rows=.true.)
      carried = total(image%team, [(merge(1_long, 0_long, list%fields(i)%point_count() == points%count .and. &
        (points%count > 0 .or. .not. is_divided(model%part))), i=1, list%count)])
      do i = 1, list%count
        if (list%fields(i)%shown >= shown_in_results .and. carried(i) > 0) call put_field(image, list%fields(i), own)
      end do
    end associate
  end subroutine put_points

  !> Put a field of some points.
  subroutine put_field(image, field, chosen)
    type(image_type), intent(inout) :: image
    type(field_type), intent(in) :: field
    integer, intent(in) :: chosen(:)
    real(wp), allocatable :: table(:, :)
    character(len=:), allocatable :: path

    path = '/step/points/'//trim(field%name)
    if (associated(field%labels)) then
      call put_array(image, path, field%labels(chosen), rows=.true.)
      return
    end if
    call field%get_values(row_components(field%kind), table)
    if (field%is_row) then
      call put_array(image, path, table(1, chosen), rows=.true.)
    else
      call put_array(image, path, table(:, chosen), rows=.true.)
    end if
  end subroutine put_field

  !> Write `results.h5`.
  subroutine write_results_index(directory, steps, error, phases)
    !> Where the results are.
    character(len=*), intent(in) :: directory
    !> Steps there are results of.
    integer, intent(in) :: steps(:)
    !> Set when the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    !> Number of phases, of which some may have a mechanism.
    integer, intent(in), optional :: phases
    type(image_type) :: image
    integer :: i

    call create_image(image)
    call put_link(image, '/mesh', results_folder//'/mesh.h5', '/mesh')
    call put_group(image, '/steps')
    do i = 1, size(steps)
      call put_link(image, '/steps/'//numbered(steps(i)), results_folder//'/'//numbered(steps(i))//'.h5', '/step')
    end do
    if (present(phases)) call put_mechanisms(image, directory, phases)
    call save_image(image, directory//'/results.h5', .false., error)
  end subroutine write_results_index

  !> Links to the mechanisms there are: a run that is continued finds those of the steps before.
  subroutine put_mechanisms(image, directory, phases)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: directory
    integer, intent(in) :: phases
    logical :: any_yet
    integer :: p

    any_yet = .false.
    do p = 1, phases
      if (.not. file_exists(part_path(directory, mechanism_part//numbered(p)))) cycle
      if (.not. any_yet) call put_group(image, '/mechanisms')
      any_yet = .true.
      call put_link(image, '/mechanisms/'//numbered(p), results_folder//'/'//mechanism_part//numbered(p)//'.h5', &
        '/step')
    end do
  end subroutine put_mechanisms

  !> File of one part.
  pure function part_path(directory, name) result(path)
    !> Where the results are.
    character(len=*), intent(in) :: directory, name
    character(len=:), allocatable :: path

    path = directory//'/'//results_folder//'/'//name//'.h5'
  end function part_path
end module qsmpm_results
