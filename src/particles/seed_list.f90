!> Growing list of seeds: initial positions of material points and surface points.
module qsmpm_seed_list
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: seed_list_type, add_seed

  !> List of seeds; the first `count` are used.
  type :: seed_list_type
    integer :: count = 0
    !> Cell that is being searched.
    integer :: searched = 0
    !> Owner cell, number of the body or surface, and the searched cell: the owner or a neighbour of it (count).
    integer, allocatable :: cell(:), body(:), found_in(:)
    !> Local coordinates in the cell (dimension, count).
    real(wp), allocatable :: local(:, :)
    !> Volume of a material point, area of a surface point; per radian in axisymmetry (count).
    real(wp), allocatable :: volume(:)
    !> Half lengths of the box that a material point represents; outward area vector of a surface point, with its area
    !> as length (dimension, count).
    real(wp), allocatable :: vector(:, :)
  end type seed_list_type

contains

  !> Appends one seed.
  pure subroutine add_seed(list, cell, body, local, volume, vector)
    type(seed_list_type), intent(inout) :: list
    !> Owner cell.
    integer, intent(in) :: cell
    !> Number of the body or surface.
    integer, intent(in) :: body
    !> Local coordinates (dimension).
    real(wp), intent(in) :: local(:)
    !> Volume or area.
    real(wp), intent(in) :: volume
    !> Half lengths or area vector (dimension).
    real(wp), intent(in) :: vector(:)

    call make_room(list, size(local))
    list%count = list%count + 1
    list%cell(list%count) = cell
    list%body(list%count) = body
    list%found_in(list%count) = list%searched
    list%local(:, list%count) = local
    list%volume(list%count) = volume
    list%vector(:, list%count) = vector
  end subroutine add_seed

  !> Extends the arrays for one more seed if required.
  pure subroutine make_room(list, dimension)
    type(seed_list_type), intent(inout) :: list
    !> 2 or 3.
    integer, intent(in) :: dimension
    type(seed_list_type) :: longer
    integer :: room, n

    n = list%count
    if (allocated(list%cell)) then
      if (n < size(list%cell)) return
    end if
    room = max(256, 2*n)
    allocate (longer%cell(room), longer%body(room), longer%found_in(room), longer%local(dimension, room), &
      longer%volume(room), longer%vector(dimension, room))
    if (n > 0) then
      longer%cell(:n) = list%cell
      longer%body(:n) = list%body
      longer%found_in(:n) = list%found_in
      longer%local(:, :n) = list%local
      longer%volume(:n) = list%volume
      longer%vector(:, :n) = list%vector
    end if
    longer%count = n
    longer%searched = list%searched
    list = longer
  end subroutine make_room
end module qsmpm_seed_list
