!> Results as numbers: `results.h5` with one group a picture under /steps and the mesh under /mesh.
!>
!> The group of each picture lives in a file of its own, `results/NNNNNN.h5`, and the mesh in
!> `results/mesh.h5`; `results.h5` holds links to them, which every HDF5 reader follows. So each
!> file is written once and whole, a run of any length never rewrites what it has, and a run that
!> was interrupted and continued leaves the same bytes as one that was not.
module qsmpm_results
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_fields, only: padded, point_displacement, state_name, state_values
  use qsmpm_hdf5_image, only: image_type, create_image, put_group, put_array, put_attribute, &
    put_link, save_image
  use qsmpm_element, only: vtk_type
  use qsmpm_model, only: model_type
  use qsmpm_number_text, only: numbered
  use qsmpm_stress_error, only: stress_error_type
  implicit none
  private

  public :: write_mesh_results, write_step_results, write_results_index

  !> Folder of the parts beside results.h5.
  character(len=*), parameter, public :: results_folder = 'results'

contains

  !> Write the mesh as it was built: node coordinates, cells in compressed rows, VTK cell types,
  !> labels of the input.
  subroutine write_mesh_results(directory, model, error)
    !> Where the results are.
    character(len=*), intent(in) :: directory
    !> The model.
    type(model_type), intent(in) :: model
    !> Set when the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    type(image_type) :: image
    real(wp), allocatable :: reals(:, :)
    integer, allocatable :: types(:), offsets(:), nodes(:)
    integer :: c

    associate (mesh => model%mesh)
      call create_image(image)
      call put_group(image, '/mesh')
      call padded(mesh%coordinates, 3, reals)
      call put_array(image, '/mesh/coordinates', reals)
      allocate (nodes, source=mesh%cell_nodes - 1)
      call put_array(image, '/mesh/cell_nodes', nodes)
      allocate (offsets, source=mesh%cell_first - 1)
      call put_array(image, '/mesh/cell_offsets', offsets)
      allocate (types(mesh%cell_count))
      do c = 1, mesh%cell_count
        types(c) = vtk_type(mesh%cell_kind(c))
      end do
      call put_array(image, '/mesh/cell_types', types)
      call put_array(image, '/mesh/node_labels', mesh%node_label)
      call put_array(image, '/mesh/cell_labels', mesh%cell_label)
      call put_attribute(image, '/mesh', 'dimension', mesh%dimension)
    end associate
    call save_image(image, directory//'/'//results_folder//'/mesh.h5', error)
  end subroutine write_mesh_results

  !> Write the fields of a step.
  subroutine write_step_results(directory, model, estimate, error)
    !> Where the results are.
    character(len=*), intent(in) :: directory
    !> The model.
    type(model_type), intent(in) :: model
    !> Estimated error of its stresses.
    type(stress_error_type), intent(in) :: estimate
    !> Set when the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    type(image_type) :: image
    real(wp), allocatable :: reals(:, :)

    associate (points => model%state%points, progress => model%state%progress)
      call create_image(image)
      call put_group(image, '/step')
      call put_attribute(image, '/step', 'step', progress%step)
      call put_attribute(image, '/step', 'phase', progress%phase)
      call put_attribute(image, '/step', 'load_factor', progress%load_factor)
      call put_attribute(image, '/step', 'stress_error_mean', estimate%mean)
      call put_attribute(image, '/step', 'stress_error_largest', estimate%largest)
      call put_attribute(image, '/step', 'stress_error_surface', estimate%surface_mean)
      call put_group(image, '/step/points')
      call padded(points%position, 3, reals)
      call put_array(image, '/step/points/position', reals)
      call point_displacement(model, reals)
      call put_array(image, '/step/points/displacement', reals)
      call padded(points%stress, 6, reals)
      call put_array(image, '/step/points/stress', reals)
      call put_array(image, '/step/points/stress_error', estimate%at_point)
      call put_array(image, '/step/points/stress_scale', estimate%scale)
      call put_array(image, '/step/points/volume', points%volume)
      call put_array(image, '/step/points/initial_volume', points%initial_volume)
      call put_array(image, '/step/points/plastic', points%plastic)
      call put_array(image, '/step/points/material', points%material)
      call put_states(image, model)
      call save_image(image, part_path(directory, progress%step), error)
    end associate
  end subroutine write_step_results

  !> State variables by name.
  subroutine put_states(image, model)
    !> The file.
    type(image_type), intent(inout) :: image
    !> The model.
    type(model_type), intent(in) :: model
    real(wp), allocatable :: reals(:, :), row(:)
    integer :: i

    i = 1
    do while (len(state_name(model, i)) > 0)
      call state_values(model, state_name(model, i), reals)
      if (allocated(row)) deallocate (row)
      allocate (row, source=reals(1, :))
      call put_array(image, '/step/points/'//state_name(model, i), row)
      i = i + 1
    end do
  end subroutine put_states

  !> Write `results.h5`.
  subroutine write_results_index(directory, steps, error)
    !> Where the results are.
    character(len=*), intent(in) :: directory
    !> Steps there are results of.
    integer, intent(in) :: steps(:)
    !> Set when the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    type(image_type) :: image
    integer :: i

    call create_image(image)
    call put_link(image, '/mesh', results_folder//'/mesh.h5', '/mesh')
    call put_group(image, '/steps')
    do i = 1, size(steps)
      call put_link(image, '/steps/'//numbered(steps(i)), &
        results_folder//'/'//numbered(steps(i))//'.h5', '/step')
    end do
    call save_image(image, directory//'/results.h5', error)
  end subroutine write_results_index

  !> File of one step.
  pure function part_path(directory, step) result(path)
    !> Where the results are.
    character(len=*), intent(in) :: directory
    !> The step.
    integer, intent(in) :: step
    character(len=:), allocatable :: path

    path = directory//'/'//results_folder//'/'//numbered(step)//'.h5'
  end function part_path
end module qsmpm_results
