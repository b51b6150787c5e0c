!> Locking as it is seen in a state: pressures that alternate in material that yields, and nothing else.
module test_locking_check
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_locking_check, only: check_locking, pressure_scatter
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use deck_samples, only: joined
  use scripted_solver, only: test_observer_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_locking_check

  !> Shear stress of every point.
  real(wp), parameter :: shear = 2.0_wp

contains

  !> All checks.
  subroutine collect_locking_check(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('locking_check')
    call check_scatter(tests)
    call check_warning(tests)
  end subroutine collect_locking_check

  !> Two by two cells of splines with 16 points each, all of which yield in pure shear.
  subroutine new_model(treatment, model)
    !> A line of the deck.
    character(len=*), intent(in) :: treatment
    type(model_type), intent(out) :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('test.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 2|Y, 0, 2, 2|'// &
      '*METHOD, BASIS=SPLINE2G|*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=soil|*ELASTIC|100, 0.3|'// &
      '*MOHR COULOMB|1, 20, 0|'//treatment//'*BODY, NAME=block, MATERIAL=soil, SHAPE=ALL|'// &
      '*POINTS, PER ELEMENT=16|*PHASE, NAME=load|*FIX|base, ALL|*GRAVITY|0, -1|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the deck of the locking check is not good'
    model%state%points%plastic = 1
    model%state%points%stress = 0.0_wp
    model%state%points%stress(4, :) = shear
  end subroutine new_model

  !> Pressures as on a chess board of points: their mean and slopes over any cells are zero.
  pure function alternating(model, amplitude) result(stress)
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: amplitude
    real(wp) :: stress(3, model%state%points%count)
    integer :: p

    do p = 1, size(stress, 2)
      stress(:, p) = amplitude*(-1)**sum(floor(4.0_wp*model%state%points%position(:, p)))
    end do
  end function alternating

  !> What counts as scatter.
  subroutine check_scatter(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    integer :: i

    allocate (model)
    call new_model('', model)
    associate (points => model%state%points)
      do i = 1, 3
        points%stress(i, :) = -5.0_wp + 3.0_wp*points%position(1, :) - 7.0_wp*points%position(2, :)
      end do
      call tests%close('pressures linear in space do not scatter', pressure_scatter(model, 1), 0.0_wp, 1.0e-13_wp)
      points%stress(:3, :) = points%stress(:3, :) + alternating(model, 1.2_wp)
      call tests%close('alternating ones scatter by their amplitude over the shear stress', pressure_scatter(model, 1), &
        1.2_wp/shear, 1.0e-13_wp)
      points%stress(3, :) = points%stress(3, :) + 3.0_wp
      call tests%close('of which all of the deviator is part', pressure_scatter(model, 1), &
        1.2_wp/sqrt(shear**2 + 3.0_wp), 1.0e-13_wp)
      points%plastic(:7) = 0
      points%stress(4, :7) = 1.0e6_wp
      call tests%close('points that do not yield do not count', pressure_scatter(model, 1), &
        1.2_wp/sqrt(shear**2 + 3.0_wp), 1.0e-13_wp)
      points%plastic = 0
      call tests%close('elastic material does not scatter', pressure_scatter(model, 1), 0.0_wp, 0.0_wp)
      points%stress(4, :) = shear
      model%laws(1)%law%tells_yield = .false.
      call tests%close('where a law does not tell what yields, all that is sheared counts', pressure_scatter(model, 1), &
        1.2_wp/sqrt(shear**2 + 3.0_wp), 1.0e-13_wp)
      points%stress(:3, :) = points%stress(:3, :) - 1000.0_wp
      call tests%close('what yields in compression does not', pressure_scatter(model, 1), 0.0_wp, 0.0_wp)
    end associate
  end subroutine check_scatter

  !> When it is told.
  subroutine check_warning(tests)
    type(tests_type), intent(inout) :: tests

    call tests%check('a scatter of a half is told, with material and figure', index(told('', 0.51_wp), &
      "warning: material 'soil' locks: pressures of neighbouring points that yield differ by 0.51 of") > 0)
    call tests%check('less is no warning', told('', 0.49_wp) == &
      "material 'soil': pressures of neighbouring points that yield differ by 0.49 of their shear stress|")
    call tests%check('none is not told, nor what two digits do not show', len(told('', 0.0_wp)) == 0 .and. &
      len(told('', 0.0049_wp)) == 0 .and. len(told('', 0.0051_wp)) > 0)
    call tests%check('material that is left alone on request is told of too', &
      index(told('*VOLUMETRIC LOCKING, TYPE=NONE|', 0.6_wp), 'locks') > 0)
    call tests%check('treated material is not', len(told('*VOLUMETRIC LOCKING, TYPE=UNIFORM PRESSURE|', 0.6_wp)) == 0)
  end subroutine check_warning

  !> What is reported a scatter.
  function told(treatment, scatter) result(text)
    character(len=*), intent(in) :: treatment
    real(wp), intent(in) :: scatter
    character(len=:), allocatable :: text
    class(model_type), allocatable :: model
    type(test_observer_type) :: observer

    allocate (model)
    call new_model(treatment, model)
    model%state%points%stress(:3, :) = alternating(model, scatter*shear)
    call check_locking(model, observer)
    text = ''
    if (allocated(observer%text)) text = observer%text
  end function told
end module test_locking_check
