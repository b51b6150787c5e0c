!> Cells that share a pressure, where processes share the model: the patches depend on all cells with material
!> (qsmpm_pressure_groups). Every process therefore sends its cells to the others and retains the patches that contain
!> its own cells. The whole mesh is stored on every process in this case (qsmpm_cell_sharing).
module qsmpm_joint_patches
  use qsmpm_kinds, only: long
  use qsmpm_team, only: hand_over
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: own_cells
  use qsmpm_pressure_groups, only: pressure_patches
  implicit none
  private

  public :: find_joint_patches

contains

  !> Finds the patch of each group of this process, numbered in the order of their first groups.
  subroutine find_joint_patches(model, cells, wanted, patch)
    type(model_type), intent(in) :: model
    !> Cell of each group, and whether it is to share a pressure (groups).
    integer, intent(in) :: cells(:)
    logical, intent(in) :: wanted(:)
    integer, allocatable, intent(out) :: patch(:)
    integer, allocatable :: all_cells(:), all_patches(:), number(:)
    logical, allocatable :: all_wanted(:)
    integer :: group(model%mesh%cell_count), g, count

    call list_all(model, cells, wanted, all_cells, all_wanted)
    call pressure_patches(model%mesh, all_cells, all_wanted, all_patches)
    group = 0
    group(all_cells) = all_patches
    allocate (number(maxval(all_patches)), source=0)
    allocate (patch(size(cells)))
    count = 0
    do g = 1, size(cells)
      associate (n => number(group(cells(g))))
        if (n == 0) then
          count = count + 1
          n = count
        end if
        patch(g) = n
      end associate
    end do
  end subroutine find_joint_patches

  !> Lists the cells with material of all processes in ascending order, and whether they are to share a pressure.
  subroutine list_all(model, cells, wanted, all_cells, all_wanted)
    type(model_type), intent(in) :: model
    integer, intent(in) :: cells(:)
    logical, intent(in) :: wanted(:)
    integer, allocatable, intent(out) :: all_cells(:)
    logical, allocatable, intent(out) :: all_wanted(:)
    integer(long), allocatable :: mine(:), got(:)
    integer, allocatable :: first(:)
    integer :: mark(model%mesh%cell_count), c, n, r

    ! Encoded as twice the number of the cell, plus one where it is to share a pressure.
    mine = pack(2_long*cells + merge(1_long, 0_long, wanted), own_cells(model%part, cells))
    n = size(mine)
    associate (team => model%part%team)
      call hand_over(team, [(mine, r=1, team%ranks)], [(1 + n*r, r=0, team%ranks)], got, first)
    end associate
    mark = -1
    mark(int(got/2)) = int(mod(got, 2_long))
    all_cells = pack([(c, c=1, size(mark))], mark >= 0)
    all_wanted = mark(all_cells) == 1
  end subroutine list_all
end module qsmpm_joint_patches
