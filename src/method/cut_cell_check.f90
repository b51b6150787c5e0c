!> How far material points are from integrating over the bodies that the grid cuts, as warnings.
!>
!> Where the points are integrated, not the cells, those of a cut cell lose the moments of what lies in it as the body
!> moves. What is lost shows without a solution being known: the divergence theorem, for every function
!>
!>   sum over points of V grad N_a  =  integral of N_a n over the outline,
!>
!> whose violation is the force out of balance of a uniform stress 1. It is told as a share: its norm over all nodes
!> over that of the right-hand side. Figures: docs/methods/bodies.md.
module qsmpm_cut_cell_check
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: integrate_cells
  use qsmpm_text, only: real_text
  use qsmpm_model, only: model_type
  use qsmpm_house_keeping, only: activation_type
  use qsmpm_integration, only: integration_type, place_of
  use qsmpm_space, only: place_type, functions_at, node_position
  use qsmpm_body_quadrature, only: body_quadrature_type
  use qsmpm_outlines, only: seed_outlines
  use qsmpm_seed_list, only: seed_list_type
  use qsmpm_observer, only: observer_type
  implicit none
  private

  public :: cut_cell_check_type, measure_cut_cells, warn_of_cut_cells, end_cut_cell_check

  !> Violation from which it is told: at 1.1 % the stress of the turned block is 2.8 % off with GIMP.
  real(wp), parameter :: worth_a_warning = 0.004_wp

  !> What has been seen and told so far; outlives the step.
  type :: cut_cell_check_type
    !> Violation in this step, and where it is largest (dimension).
    real(wp) :: share = 0.0_wp
    real(wp), allocatable :: place(:)
    !> Largest violation of the phase, and whether one is told; bodies whose lost outline is told (bodies).
    real(wp) :: worst = 0.0_wp
    logical :: told = .false.
    logical, allocatable :: lost_told(:)
  end type cut_cell_check_type

contains

  !> Measure the violation for the points as they are at the start of a step.
  subroutine measure_cut_cells(model, activation, bodies, at_points, check)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    type(body_quadrature_type), intent(in) :: bodies
    !> Basis at the material points.
    type(integration_type), intent(in) :: at_points
    type(cut_cell_check_type), intent(inout) :: check
    real(wp), dimension(model%mesh%dimension, model%space%node_count) :: outside, inside
    integer :: node

    call integrate_outlines(model, activation, bodies, outside)
    call integrate_gradients(model, bodies, at_points, inside)
    check%share = norm2(inside - outside)/max(norm2(outside), tiny(1.0_wp))
    node = maxloc(norm2(inside - outside, dim=1), dim=1)
    check%place = node_position(model%space, model%mesh, node)
  end subroutine measure_cut_cells

  !> Integrals of N n over the outlines (dimension, nodes).
  subroutine integrate_outlines(model, activation, bodies, sums)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    type(body_quadrature_type), intent(in) :: bodies
    real(wp), intent(out) :: sums(:, :)
    type(seed_list_type) :: list
    type(place_type) :: place
    integer :: i, a

    sums = 0.0_wp
    call seed_outlines(model, bodies, list)
    do i = 1, list%count
      if (.not. activation%touched(list%cell(i))) cycle
      call functions_at(model%space, model%mesh, list%cell(i), list%local(:, i), place)
      do a = 1, place%count
        sums(:, place%node(a)) = sums(:, place%node(a)) + place%shape(a)*list%vector(:, i)
      end do
    end do
  end subroutine integrate_outlines

  !> Sums of V grad N over the points of the bodies, in axisymmetry with N/r for the first component (dimension, nodes).
  subroutine integrate_gradients(model, bodies, at_points, sums)
    type(model_type), intent(in) :: model
    type(body_quadrature_type), intent(in) :: bodies
    type(integration_type), intent(in) :: at_points
    real(wp), intent(out) :: sums(:, :)
    integer :: g, q, n, b, j

    sums = 0.0_wp
    do g = 1, at_points%group_count
      n = at_points%node_first(g + 1) - at_points%node_first(g)
      associate (nodes => at_points%nodes(at_points%node_first(g):at_points%node_first(g + 1) - 1))
        do q = at_points%first(g), at_points%first(g + 1) - 1
          if (.not. bodies%carried(model%state%points%body(at_points%source(q)))) cycle
          b = at_points%directions*place_of(at_points, g, q)
          do j = 1, at_points%directions
            associate (row => merge(j, 1, j <= size(sums, 1)))
              sums(row, nodes) = sums(row, nodes) + at_points%weight(q)*at_points%gradient(b + (j - 1)*n + 1:b + j*n)
            end associate
          end do
        end do
      end associate
    end do
  end subroutine integrate_gradients

  !> Warn when the violation is large for the first time in a phase, and of outlines that are lost.
  subroutine warn_of_cut_cells(model, bodies, check, observer)
    type(model_type), intent(in) :: model
    !> Unallocated where no outline is carried.
    type(body_quadrature_type), allocatable, intent(in) :: bodies
    type(cut_cell_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer
    integer :: k

    if (.not. allocated(bodies)) return
    if (.not. allocated(check%lost_told)) allocate (check%lost_told(size(bodies%carried)), source=.false.)
    do k = 1, size(model%outlines)
      associate (b => model%outlines(k)%body)
        if (bodies%carried(b) .or. check%lost_told(b)) cycle
        check%lost_told(b) = .true.
        call observer%note("warning: the outline of body '"//model%analysis%bodies(b)%name//"' has folded: its "// &
          'volume is no longer that of the material points. Cells that it cuts are integrated at the points from '// &
          'here on, and stresses there may be far off')
      end associate
    end do
    if (model%analysis%method%integration == integrate_cells) return
    check%worst = max(check%worst, check%share)
    if (check%told .or. .not. check%share > worth_a_warning) return
    check%told = .true.
    call observer%note('warning: '//violation_text(check%share)//', most at '//place_text(check%place)// &
      ': stresses beside the outline are off by several times as much; take INTEGRATION=CELL, which follows the '// &
      'outline')
  end subroutine warn_of_cut_cells

  !> Tell the worst violation of a phase, where one was told.
  subroutine end_cut_cell_check(phase, check, observer)
    !> Its name.
    character(len=*), intent(in) :: phase
    type(cut_cell_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer

    if (check%told) call observer%note("warning: phase '"//phase//"': "//violation_text(check%worst)//' at the most')
    check%told = .false.
    check%worst = 0.0_wp
  end subroutine end_cut_cell_check

  !> A violation as a sentence.
  function violation_text(share) result(text)
    real(wp), intent(in) :: share
    character(len=:), allocatable :: text

    text = 'the material points of cells that a body cuts are '//real_text(anint(1000.0_wp*share)/10.0_wp)// &
      ' % off the divergence theorem over its outline'
  end function violation_text

  !> A place in parentheses.
  function place_text(place) result(text)
    real(wp), intent(in) :: place(:)
    character(len=:), allocatable :: text
    character(len=40) :: buffer
    integer :: a

    text = '('
    do a = 1, size(place)
      write (buffer, '(es11.4)') place(a)
      if (a > 1) text = text//', '
      text = text//trim(adjustl(buffer))
    end do
    text = text//')'
  end function place_text
end module qsmpm_cut_cell_check
