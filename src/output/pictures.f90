!> Pictures of a state for ParaView: the material points as boxes of their volume (`box_corners`), each a cell with
!> the fields of its point; the background mesh with what is in its cells.
!>
!> Of a model that is divided each process writes its own points and cells as a piece (qsmpm_part_files), and the first
!> one the list of the pieces, `.pvtu` in place of `.vtu`. Points carry their `number` then.
module qsmpm_pictures
  use, intrinsic :: iso_fortran_env, only: int8
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: agree, lowest_rank, spread_text
  use qsmpm_element, only: vtk_type
  use qsmpm_error, only: error_type
  use qsmpm_field_list, only: field_type, field_list_type, row_components, shown_in_results
  use qsmpm_fields, only: padded, list_results, cell_fill, cell_point_count
  use qsmpm_file, only: file_exists
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_part, only: take_cells
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: is_divided
  use qsmpm_part_files, only: part_name, remove_parts
  use qsmpm_posix, only: remove_file
  use qsmpm_stress_error, only: stress_error_type
  use qsmpm_team, only: team_type, total
  use qsmpm_text, only: string_type
  use qsmpm_vtu, only: vtu_type, start_vtu, add_reals, add_integers, add_longs, add_bytes, write_vtu, &
    pieces_head, write_pieces, section_cell_data, section_points, section_cells
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_points, only: place_of
  implicit none
  private

  public :: write_points_picture, write_mesh_picture, box_corners

  !> VTK's numbers of a quadrilateral and a brick.
  integer(int8), parameter :: vtk_quad = 9_int8, vtk_brick = 12_int8

  !> Corners in VTK's order, the first four in the plane.
  real(wp), parameter :: corner(3, 8) = reshape([-1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp, &
    -1.0_wp, -1.0_wp, 1.0_wp, -1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, &
    -1.0_wp, 1.0_wp, 1.0_wp], [3, 8])

  !> Least side of a box over the largest, and of all [length]: points of the rule of a cut cell have sides of nothing.
  real(wp), parameter :: flattest = 1.0e-3_wp, smallest = 1.0e-100_wp

contains

  !> Write the material points.
  subroutine write_points_picture(directory, name, model, estimate, error)
    character(len=*), intent(in) :: directory
    !> Name of the file without its ending.
    character(len=*), intent(in) :: name
    type(model_type), intent(in) :: model
    !> Estimated error of its stresses.
    type(stress_error_type), intent(in) :: estimate
    !> Set when a file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    type(vtu_type) :: vtu
    type(field_list_type) :: list
    real(wp), allocatable :: corners(:, :)
    integer, allocatable :: own(:)
    integer(long), allocatable :: numbers(:)
    integer :: i, k, corner_count, shown

    associate (points => model%state%points)
      corner_count = 2**model%mesh%dimension
      shown = points%count
      if (is_divided(model%part)) then
        own = pack([(i, i=1, points%count)], model%part%points)
        shown = size(own)
      end if
      call start_vtu(vtu, shown*corner_count, shown)
      if (allocated(own)) then
        numbers = points%number(own)
        call add_longs(vtu, section_cell_data, 'number', numbers)
      end if
      call list_results(model, estimate, list)
      do i = 1, list%count
        if (list%fields(i)%shown >= shown_in_results) call add_field(vtu, list%fields(i), points%count, own)
      end do
      call box_corners(model, corners)
      if (allocated(own)) corners = corners(:, [((corner_count*(own(i) - 1) + k, k=1, corner_count), i=1, shown)])
      call add_reals(vtu, section_points, 'corners', corners)
      call add_boxes(vtu, shown, model%mesh%dimension)
    end associate
    call write_picture(directory, name, model%part%team, vtu, error)
  end subroutine write_points_picture

  !> Write a picture, or the piece of this process and the list of all of them. One that is empty is not written.
  subroutine write_picture(directory, name, team, vtu, error)
    character(len=*), intent(in) :: directory, name
    !> Who has a piece.
    type(team_type), intent(in) :: team
    type(vtu_type), intent(in) :: vtu
    !> The same on all processes that have a piece.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: shown(team%ranks)
    type(string_type), allocatable :: pieces(:)
    character(len=:), allocatable :: head
    integer :: k, r

    if (team%ranks == 1) then
      call write_vtu(vtu, directory//'/'//name//'.vtu', error)
      if (.not. allocated(error)) call remove_former(directory, name, '.pvtu', 0)
      return
    end if
    if (vtu%cell_count > 0) call write_vtu(vtu, directory//'/'//part_name(name, team%rank, '.vtu'), error)
    call agree(team, error)
    if (allocated(error)) return
    shown = 0.0_wp
    shown(team%rank + 1) = real(vtu%cell_count, wp)
    shown = total(team, shown)
    head = pieces_head(vtu)
    call spread_text(team, mod(lowest_rank(team, vtu%cell_count > 0), team%ranks), head)
    if (team%rank == 0) then
      allocate (pieces(count(shown > 0.0_wp)))
      k = 0
      do r = 1, team%ranks
        if (.not. shown(r) > 0.0_wp) cycle
        k = k + 1
        pieces(k)%text = part_name(name, r - 1, '.vtu')
      end do
      call write_pieces(directory//'/'//name//'.pvtu', head, pieces, error)
      if (.not. allocated(error)) call remove_former(directory, name, '.vtu', team%ranks)
    end if
    call agree(team, error)
  end subroutine write_picture

  !> Remove what a run of other processes has left of the same picture.
  subroutine remove_former(directory, name, ending, pieces)
    character(len=*), intent(in) :: directory, name
    !> Of the file that is no longer.
    character(len=*), intent(in) :: ending
    !> Number of pieces that stay.
    integer, intent(in) :: pieces
    integer :: ignored

    if (file_exists(directory//'/'//name//ending)) ignored = remove_file(directory//'/'//name//ending)
    call remove_parts(directory, name, pieces, '.vtu')
  end subroutine remove_former

  !> A field of all points or of some; none where the points do not carry it.
  subroutine add_field(vtu, field, points, chosen)
    type(vtu_type), intent(inout) :: vtu
    type(field_type), intent(in) :: field
    !> Number of points.
    integer, intent(in) :: points
    !> Those that are shown; all where it is not allocated.
    integer, allocatable, intent(in) :: chosen(:)
    real(wp), allocatable :: reals(:, :)
    integer, allocatable :: labels(:)

    if (field%point_count() /= points) return
    if (associated(field%labels)) then
      allocate (labels, source=field%labels)
      if (allocated(chosen)) labels = labels(chosen)
      call add_integers(vtu, section_cell_data, trim(field%name), labels)
    else
      call field%get_values(row_components(field%kind), reals)
      if (allocated(chosen)) reals = reals(:, chosen)
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

  !> Write the background mesh at its present coordinates. Pieces have the nodes at their borders each.
  subroutine write_mesh_picture(directory, name, model, error)
    character(len=*), intent(in) :: directory
    !> Name of the file without its ending.
    character(len=*), intent(in) :: name
    type(model_type), intent(in) :: model
    !> Set when a file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    type(vtu_type) :: vtu
    type(mesh_type) :: own
    real(wp), allocatable :: fill(:, :), places(:, :)
    integer, allocatable :: points(:), active(:), cells(:), nodes(:)
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
    allocate (active, source=merge(1, 0, points > 0))
    call start_vtu(vtu, size(places, 2), size(points))
    call add_integers(vtu, section_cell_data, 'active', active)
    call add_integers(vtu, section_cell_data, 'point_count', points)
    call add_reals(vtu, section_cell_data, 'fill', fill)
    call add_reals(vtu, section_points, 'position', places)
    if (is_divided(model%part)) then
      call add_mesh_cells(vtu, own)
    else
      call add_mesh_cells(vtu, model%mesh)
    end if
    call write_picture(directory, name, model%part%team, vtu, error)
  end subroutine write_mesh_picture

  !> The cells of a mesh; its node order is VTK's.
  subroutine add_mesh_cells(vtu, mesh)
    !> The picture.
    type(vtu_type), intent(inout) :: vtu
    type(mesh_type), intent(in) :: mesh
    integer, allocatable :: integers(:)
    integer(int8), allocatable :: bytes(:)
    integer :: c

    allocate (integers, source=mesh%cell_nodes - 1)
    call add_integers(vtu, section_cells, 'connectivity', integers)
    allocate (integers, source=mesh%cell_first(2:) - 1)
    call add_integers(vtu, section_cells, 'offsets', integers)
    allocate (bytes(mesh%cell_count))
    do c = 1, mesh%cell_count
      bytes(c) = int(vtk_type(mesh%cell_kind(c)), int8)
    end do
    call add_bytes(vtu, section_cells, 'types', bytes)
  end subroutine add_mesh_cells

  !> Places of the corners of boxes as large as the volumes of their points, those of a point behind each other: four a
  !> point in the plane, eight in space. Sides are those with which the point was laid out, times the stretch
  !> (b_ii)^1/2 where points carry their strain, then all of them by one factor to the present volume. A point without
  !> sides (image of a smaller model, rule of a cut cell) has a cube.
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

  !> Half the sides of the box of a point, the third 0 in the plane.
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
end module qsmpm_pictures
