!> Numerical results: `results.h5` has one group per picture under /steps, failure mechanisms of safety phases under
!> /mechanisms by the number of the phase, and the mesh under /mesh. In addition to the points, a picture contains the
!> rigid bodies, contacts and water levels (qsmpm_surroundings).
!>
!> The group of each picture is in a file of its own, `results/NNNNNN.h5`, and the mesh in `results/mesh.h5`;
!> `results.h5` contains links to them, which every HDF5 reader follows. Each file is therefore written once and
!> completely, a run never rewrites existing results, and a run that was interrupted and continued gives the same bytes
!> as one that was not.
!>
!> If the model is divided each process writes the rows of its own points, contacts, cells and nodes
!> (qsmpm_hdf5_image). Points then have their `number` in addition to the other fields.
!>
!> The module also writes pictures for ParaView: the material points as boxes of their volume (`box_corners`), one cell
!> per point with its fields, and the background mesh with quantities of its cells.
!>
!> If the model is divided each process writes its own points and cells as a piece of the same file (qsmpm_vtu). Points
!> then have their `number`.
module qsmpm_results
  use, intrinsic :: iso_fortran_env, only: int8
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type
  use qsmpm_field_list, only: field_type, field_list_type, row_components, shown_in_results
  use qsmpm_fields, only: padded, list_results, cell_fill, cell_point_count
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
  use qsmpm_vtu, only: vtu_type, start_vtu, add_array, write_vtu, section_cell_data, section_points, section_cells
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_points, only: place_of
  implicit none
  private

  public :: write_mesh_results, write_state, write_results_index, write_points_picture, write_mesh_picture, &
    box_corners

  !> Folder of the parts next to results.h5.
  character(len=*), parameter, public :: results_folder = 'results'
  !> Text before the number of the phase in the names of mechanism files.
  character(len=*), parameter, public :: mechanism_part = 'mechanism_'

  !> VTK cell types of a quadrilateral and a brick.
  integer(int8), parameter :: vtk_quad = 9_int8, vtk_brick = 12_int8

  !> Corners in the order of VTK, the first four for plane models.
  real(wp), parameter :: corner(3, 8) = reshape([-1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp, &
    -1.0_wp, -1.0_wp, 1.0_wp, -1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, &
    -1.0_wp, 1.0_wp, 1.0_wp], [3, 8])

  !> Minimum ratio of a side of a box to the largest one; minimum side [length]: integration points of a cut cell have
  !> sides of zero length.
  real(wp), parameter :: flattest = 1.0e-3_wp, smallest = 1.0e-100_wp

contains

  !> Writes the mesh as built: node coordinates, cells in compressed rows, VTK cell types, labels of the input.
  !> Processes write the nodes of their own cells; nodes at interfaces are written by each of them.
  subroutine write_mesh_results(directory, model, error)
    !> Folder of the results.
    character(len=*), intent(in) :: directory
    type(model_type), intent(in) :: model
    !> Set when the file is not completely written under its name.
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

  !> Writes a mesh; the part of a process follows those of others.
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

  !> Writes the fields of a state, or of a failure mechanism, whose displacements and strains are then those of the
  !> state.
  subroutine write_state(directory, name, model, estimate, error)
    !> Folder of the results; number of the step, or that of the phase after `mechanism_part`.
    character(len=*), intent(in) :: directory, name
    type(model_type), intent(in) :: model
    !> Estimated error of the stresses.
    type(stress_error_type), intent(in) :: estimate
    !> Set when the file is not completely written under its name.
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

  !> Writes the material points, those of each process: the fields that are stored on any process.
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

  !> Writes a field of some points.
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

  !> Writes `results.h5`.
  subroutine write_results_index(directory, steps, error, phases)
    !> Folder of the results.
    character(len=*), intent(in) :: directory
    !> Steps with results.
    integer, intent(in) :: steps(:)
    !> Set when the file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error
    !> Number of phases, some of which may have a mechanism.
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

  !> Adds links to the existing mechanisms; in a continued run these include those of earlier steps.
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

  !> Returns the file of one part.
  pure function part_path(directory, name) result(path)
    !> Folder of the results.
    character(len=*), intent(in) :: directory, name
    character(len=:), allocatable :: path

    path = directory//'/'//results_folder//'/'//name//'.h5'
  end function part_path

  !> Writes the picture of the material points.
  subroutine write_points_picture(directory, name, model, estimate, error)
    character(len=*), intent(in) :: directory
    !> File name without extension.
    character(len=*), intent(in) :: name
    type(model_type), intent(in) :: model
    !> Estimated error of the stresses.
    type(stress_error_type), intent(in) :: estimate
    !> Set when a file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error
    type(vtu_type) :: vtu
    type(field_list_type) :: list
    real(wp), allocatable :: corners(:, :)
    integer, allocatable :: own(:)
    integer :: i, k, n

    associate (points => model%state%points)
      own = pack([(i, i=1, points%count)], own_of(model%part%points, points%count))
      n = 2**model%mesh%dimension
      call start_vtu(vtu, size(own)*n, size(own))
      ! The largest array is built first, while no other memory is allocated.
      call box_corners(model, corners)
      if (is_divided(model%part)) corners = corners(:, [((n*(own(i) - 1) + k, k=1, n), i=1, size(own))])
      call add_array(vtu, section_points, 'corners', corners)
      deallocate (corners)
      if (is_divided(model%part)) call add_array(vtu, section_cell_data, 'number', points%number(own))
      call list_results(model, estimate, list)
      do i = 1, list%count
        if (list%fields(i)%shown >= shown_in_results .and. list%fields(i)%point_count() == points%count) &
          call add_field(vtu, list%fields(i), own)
      end do
    end associate
    ! One cell per point, with its own corners.
    call add_array(vtu, section_cells, 'connectivity', [(i, i=0, size(own)*n - 1)])
    call add_array(vtu, section_cells, 'offsets', [(i*n, i=1, size(own))])
    call add_array(vtu, section_cells, 'types', [(merge(vtk_quad, vtk_brick, n == 4), i=1, size(own))])
    call write_vtu(vtu, directory//'/'//name//'.vtu', model%part%team, error)
  end subroutine write_points_picture

  !> Adds a field of some points.
  subroutine add_field(vtu, field, chosen)
    type(vtu_type), intent(inout) :: vtu
    type(field_type), intent(in) :: field
    integer, intent(in) :: chosen(:)
    real(wp), allocatable :: reals(:, :)

    if (associated(field%labels)) then
      call add_array(vtu, section_cell_data, trim(field%name), field%labels(chosen))
    else
      call field%get_values(row_components(field%kind), reals)
      call add_array(vtu, section_cell_data, trim(field%name), reals(:, chosen))
    end if
  end subroutine add_field

  !> Writes the background mesh at its current coordinates. Nodes at the interface of pieces are in each of them.
  subroutine write_mesh_picture(directory, name, model, error)
    character(len=*), intent(in) :: directory
    !> File name without extension.
    character(len=*), intent(in) :: name
    type(model_type), intent(in) :: model
    !> Set when a file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error
    type(vtu_type) :: vtu
    type(mesh_type) :: own
    real(wp), allocatable :: fill(:, :), places(:, :)
    integer, allocatable :: points(:), cells(:), nodes(:)
    integer :: c

    call cell_point_count(model, points)
    call cell_fill(model, fill)
    call padded(model%state%coordinates, 3, places)
    if (is_divided(model%part)) then
      cells = pack([(c, c=1, model%mesh%cell_count)], model%part%cells)
      call take_cells(model%mesh, cells, own, nodes)
      points = points(cells)
      fill = fill(:, cells)
      places = places(:, nodes)
    end if
    call start_vtu(vtu, size(places, 2), size(points))
    call add_array(vtu, section_cell_data, 'active', merge(1, 0, points > 0))
    call add_array(vtu, section_cell_data, 'point_count', points)
    call add_array(vtu, section_cell_data, 'fill', fill)
    call add_array(vtu, section_points, 'position', places)
    if (is_divided(model%part)) then
      call add_mesh_cells(vtu, own)
    else
      call add_mesh_cells(vtu, model%mesh)
    end if
    call write_vtu(vtu, directory//'/'//name//'.vtu', model%part%team, error)
  end subroutine write_mesh_picture

  !> Adds the cells of a mesh, whose node order is that of VTK.
  subroutine add_mesh_cells(vtu, mesh)
    !> The picture.
    type(vtu_type), intent(inout) :: vtu
    type(mesh_type), intent(in) :: mesh
    integer :: c

    call add_array(vtu, section_cells, 'connectivity', mesh%cell_nodes - 1)
    call add_array(vtu, section_cells, 'offsets', mesh%cell_first(2:) - 1)
    call add_array(vtu, section_cells, 'types', [(int(vtk_type(mesh%cell_kind(c)), int8), c=1, mesh%cell_count)])
  end subroutine add_mesh_cells

  !> Returns the corners of boxes with the volumes of the points, point by point: four per point in plane models, eight
  !> in 3D. The sides are the initial ones times the stretch (b_ii)^1/2 if points store their strain, scaled by a
  !> common factor to the current volume. A point without sides (image of a reduced model, integration point of a cut
  !> cell) is a cube.
  pure subroutine box_corners(model, places)
    type(model_type), intent(in) :: model
    !> (3, corners)
    real(wp), allocatable, intent(out) :: places(:, :)
    real(wp) :: half(3)
    integer :: p, k, n

    n = 2**model%mesh%dimension
    associate (points => model%state%points)
      allocate (places(3, n*points%count))
      do p = 1, points%count
        half = half_sides(model, p)
        do k = 1, n
          places(:, n*(p - 1) + k) = place_of(points, p) + half*corner(:, k)
        end do
      end do
    end associate
  end subroutine box_corners

  !> Returns half the sides of the box of a point; the third is 0 in plane models.
  pure function half_sides(model, p) result(half)
    type(model_type), intent(in) :: model
    !> Number of the point.
    integer, intent(in) :: p
    real(wp) :: half(3), volume
    integer :: d

    d = model%mesh%dimension
    half = 0.0_wp
    associate (points => model%state%points)
      volume = max(0.0_wp, points%volume(p))
      if (model%analysis%model == axisymmetric) volume = volume/points%position(1, p)
      half(:d) = points%half_size(:d, p)
      if (size(points%left_cauchy_green, 2) == points%count) half(:d) = half(:d)*sqrt(points%left_cauchy_green(:d, p))
      if (.not. minval(half(:d)) > max(flattest*maxval(half(:d)), smallest)) half(:d) = 0.5_wp
      half(:d) = half(:d)*(volume/product(2.0_wp*half(:d)))**(1.0_wp/d)
    end associate
  end function half_sides
end module qsmpm_results
