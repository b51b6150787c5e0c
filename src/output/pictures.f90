!> Pictures of a state for ParaView: the material points as boxes of their volume (qsmpm_point_boxes), each a cell with
!> the fields of its point; the background mesh with what is in its cells.
module qsmpm_pictures
  use, intrinsic :: iso_fortran_env, only: int8
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: vtk_type
  use qsmpm_error, only: error_type
  use qsmpm_field_list, only: field_type, field_list_type, row_components, shown_in_results
  use qsmpm_fields, only: padded, list_results, cell_fill, cell_point_count
  use qsmpm_model, only: model_type
  use qsmpm_point_boxes, only: box_corners
  use qsmpm_stress_error, only: stress_error_type
  use qsmpm_vtu, only: vtu_type, start_vtu, add_reals, add_integers, add_bytes, write_vtu, &
    section_cell_data, section_points, section_cells
  implicit none
  private

  public :: write_points_picture, write_mesh_picture

  !> VTK's numbers of a quadrilateral and a brick.
  integer(int8), parameter :: vtk_quad = 9_int8, vtk_brick = 12_int8

contains

  !> Write the material points.
  subroutine write_points_picture(path, model, estimate, error)
    !> Name of the file.
    character(len=*), intent(in) :: path
    type(model_type), intent(in) :: model
    !> Estimated error of its stresses.
    type(stress_error_type), intent(in) :: estimate
    !> Set when the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    type(vtu_type) :: vtu
    type(field_list_type) :: list
    real(wp), allocatable :: corners(:, :)
    integer :: i

    associate (points => model%state%points)
      call start_vtu(vtu, points%count*2**model%mesh%dimension, points%count)
      call list_results(model, estimate, list)
      do i = 1, list%count
        if (list%fields(i)%shown >= shown_in_results) call add_field(vtu, list%fields(i), points%count)
      end do
      call box_corners(model, corners)
      call add_reals(vtu, section_points, 'corners', corners)
      call add_boxes(vtu, points%count, model%mesh%dimension)
    end associate
    call write_vtu(vtu, path, error)
  end subroutine write_points_picture

  !> A field; none where the points do not carry it.
  subroutine add_field(vtu, field, points)
    type(vtu_type), intent(inout) :: vtu
    type(field_type), intent(in) :: field
    !> Number of points.
    integer, intent(in) :: points
    real(wp), allocatable :: reals(:, :)
    integer, allocatable :: labels(:)

    if (field%point_count() /= points) return
    if (associated(field%labels)) then
      allocate (labels, source=field%labels)
      call add_integers(vtu, section_cell_data, trim(field%name), labels)
    else
      call field%get_values(row_components(field%kind), reals)
      call add_reals(vtu, section_cell_data, trim(field%name), reals)
    end if
  end subroutine add_field

  !> One cell a point, with corners of its own.
  subroutine add_boxes(vtu, count, dimension)
    !> The picture.
    type(vtu_type), intent(inout) :: vtu
    !> Number of points.
    integer, intent(in) :: count, dimension
    integer, allocatable :: integers(:)
    integer(int8), allocatable :: bytes(:)
    integer :: i

    allocate (integers, source=[(i - 1, i=1, count*2**dimension)])
    call add_integers(vtu, section_cells, 'connectivity', integers)
    allocate (integers, source=[(i*2**dimension, i=1, count)])
    call add_integers(vtu, section_cells, 'offsets', integers)
    allocate (bytes(count), source=merge(vtk_quad, vtk_brick, dimension == 2))
    call add_bytes(vtu, section_cells, 'types', bytes)
  end subroutine add_boxes

  !> Write the background mesh at its present coordinates.
  subroutine write_mesh_picture(path, model, error)
    !> Name of the file.
    character(len=*), intent(in) :: path
    type(model_type), intent(in) :: model
    !> Set when the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    type(vtu_type) :: vtu
    real(wp), allocatable :: reals(:, :)
    integer, allocatable :: count(:), active(:)

    call start_vtu(vtu, model%mesh%node_count, model%mesh%cell_count)
    call cell_point_count(model, count)
    allocate (active, source=merge(1, 0, count > 0))
    call add_integers(vtu, section_cell_data, 'active', active)
    call add_integers(vtu, section_cell_data, 'point_count', count)
    call cell_fill(model, reals)
    call add_reals(vtu, section_cell_data, 'fill', reals)
    call padded(model%state%coordinates, 3, reals)
    call add_reals(vtu, section_points, 'position', reals)
    call add_mesh_cells(vtu, model)
    call write_vtu(vtu, path, error)
  end subroutine write_mesh_picture

  !> The cells of the mesh; its node order is VTK's.
  subroutine add_mesh_cells(vtu, model)
    !> The picture.
    type(vtu_type), intent(inout) :: vtu
    type(model_type), intent(in) :: model
    integer, allocatable :: integers(:)
    integer(int8), allocatable :: bytes(:)
    integer :: c

    associate (mesh => model%mesh)
      allocate (integers, source=mesh%cell_nodes - 1)
      call add_integers(vtu, section_cells, 'connectivity', integers)
      allocate (integers, source=mesh%cell_first(2:) - 1)
      call add_integers(vtu, section_cells, 'offsets', integers)
      allocate (bytes(mesh%cell_count))
      do c = 1, mesh%cell_count
        bytes(c) = int(vtk_type(mesh%cell_kind(c)), int8)
      end do
      call add_bytes(vtu, section_cells, 'types', bytes)
    end associate
  end subroutine add_mesh_cells
end module qsmpm_pictures
