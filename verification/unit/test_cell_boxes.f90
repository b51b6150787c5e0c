!> Boxes of cells for the processes of a team: they make up the grid, share what lies in it, and are the same again.
module test_cell_boxes
  use testing, only: tests_type
  use qsmpm_cell_boxes, only: share_jointly, box_of, is_inside
  use qsmpm_grid_window, only: window_type, cells_of
  use qsmpm_sorting, only: place_in_order
  use qsmpm_team, only: team_type
  implicit none
  private

  public :: collect_cell_boxes

contains

  !> All checks of this module.
  subroutine collect_cell_boxes(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('cell_boxes')
    call check_shares(tests)
    call check_narrow(tests)
    call tests%check('a value is found in a rising list', place_in_order([2, 5, 9], 5) == 2)
    call tests%check('one that is not there is not', place_in_order([2, 5, 9], 6) == 0 .and. &
      place_in_order([2, 5, 9], 10) == 0 .and. place_in_order([integer ::], 1) == 0)
  end subroutine collect_cell_boxes

  !> A slope of 12 by 6 cells, four points in each: 1 to 7 processes.
  subroutine check_shares(tests)
    type(tests_type), intent(inout) :: tests
    type(window_type), parameter :: whole = window_type([1, 1, 1], [20, 8, 1])
    integer :: at(3, 4*12*6), owner(20, 8), shared(7), n, i, j, k, ranks
    type(window_type), allocatable :: boxes(:), again(:)
    logical :: short

    n = 0
    do j = 1, 6
      do i = 1, 12 - j
        do k = 1, 4
          n = n + 1
          at(:, n) = [i, j, 1]
        end do
      end do
    end do
    do ranks = 1, 7
      if (allocated(boxes)) deallocate (boxes, again)
      allocate (boxes(ranks), again(ranks))
      call share_cells(at(:, :n), whole, boxes, short)
      call share_cells(at(:, :n), whole, again, short)
      owner = 0
      do j = 1, 8
        do i = 1, 20
          owner(i, j) = count([(is_inside(boxes(k), [i, j, 1]), k=1, ranks)])
        end do
      end do
      call tests%check('every cell is in one box', all(owner == 1) .and. .not. short)
      call tests%check('the boxes are the grid', sum([(product(cells_of(boxes(k))), k=1, ranks)]) == 20*8)
      shared = 0
      do i = 1, n
        k = box_of(boxes, at(:, i))
        shared(k) = shared(k) + 1
      end do
      call tests%check('no box has more than 1.5 times its share of points', &
        maxval(shared) <= 1.5*real(n)/real(ranks) .and. minval(shared(:ranks)) > 0)
      call tests%check('the same boxes again', all([(all(boxes(k)%first == again(k)%first) .and. &
        all(boxes(k)%last == again(k)%last), k=1, ranks)]))
    end do
  end subroutine check_shares

  !> More processes than there are cells with something in them.
  subroutine check_narrow(tests)
    type(tests_type), intent(inout) :: tests
    type(window_type) :: boxes(4)
    logical :: short

    call share_cells(reshape([3, 1, 1, 4, 1, 1, 5, 1, 1], [3, 3]), window_type([1, 1, 1], [9, 9, 1]), boxes, short)
    call tests%check('three cells are too few for four', short)
    call share_cells(reshape([3, 1, 1, 4, 1, 1, 5, 1, 1], [3, 3]), window_type([1, 1, 1], [9, 9, 1]), boxes(:3), short)
    call tests%check('and enough for three', .not. short)
    call check_weights(tests)
  end subroutine check_narrow

  !> Cells that hold much count as much as they hold; layers are those of the box, wherever it begins.
  subroutine check_weights(tests)
    type(tests_type), intent(inout) :: tests
    type(window_type), parameter :: whole = window_type([3, 5, 1], [12, 14, 1])
    integer :: at(3, 10), repeated(3, 55), weight(10), i, k
    type(window_type) :: boxes(3), again(3)
    type(team_type) :: alone
    logical :: short

    at = reshape([(i + 2, 7, 1, i=1, 10)], [3, 10])
    weight = [(i, i=1, 10)]
    repeated = reshape([((at(:, i), k=1, weight(i)), i=1, 10)], [3, 55])
    short = .false.
    call share_jointly(alone, at, weight, whole, boxes, short)
    call share_cells(repeated, whole, again, short)
    call tests%check('a cell counts by what it holds', .not. short .and. all([(all(boxes(k)%first == again(k)%first) &
      .and. all(boxes(k)%last == again(k)%last), k=1, 3)]))
    call tests%check('of 55 in a row 21, 15 and 19 go to three', all(boxes%last(1) == [8, 10, 12]))
  end subroutine check_weights

  !> The boxes; fewer cells in a row than processes leave some without any (`short`).
  subroutine share_cells(at, whole, boxes, short)
    !> Cells in which what is shared lies (3, n).
    integer, intent(in) :: at(:, :)
    type(window_type), intent(in) :: whole
    !> (ranks)
    type(window_type), intent(out) :: boxes(:)
    logical, intent(out) :: short
    type(team_type) :: alone
    integer :: weight(size(at, 2))

    weight = 1
    short = .false.
    call share_jointly(alone, at, weight, whole, boxes, short)
  end subroutine share_cells
end module test_cell_boxes
