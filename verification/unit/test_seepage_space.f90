!> Water that flows through the cells of a mesh in space: heads and flows that are known on every kind of cell, a dam, rain
!> and a column that drains as in the plane, and what is refused.
module test_seepage_space
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type, message_text
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_pore_water, only: discharge_in
  use qsmpm_retention, only: curve_type, let_through_in_time
  use qsmpm_seepage, only: seepage_type
  use qsmpm_transient_seepage, only: give_pores
  use qsmpm_seepage_field, only: gradient_of_flow, head_of_flow, seepage_field_type
  use qsmpm_water_lines, only: water_line_type, water_lines
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_seepage_space

  real(wp), parameter :: solved = 1.0e-10_wp
  !> A block of 2 x 1 x 1.5 m.
  character(len=*), parameter :: sets = '*NSET, NSET=base, PLANE=Z| 0|*NSET, NSET=left, PLANE=X| 0|'// &
    '*NSET, NSET=right, PLANE=X| 2|*NSET, NSET=top, PLANE=Z| 1.5|', &
    soil = '*MATERIAL, NAME=soil|*ELASTIC| 1000, 0.3|*UNIT WEIGHT| 18, 20|', permeable = '*PERMEABILITY| 2, 3, 5|', &
    block = '*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX| 0, 2, 0, 1, 0, 1.5|', &
    phase = '*PHASE, NAME=flow|*FIX| base, ALL|*GRAVITY| 0, 0, -1|', &
    level = '*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10|'

contains

  !> All checks.
  subroutine collect_seepage_space(tests)
    type(tests_type), intent(inout) :: tests
    character(len=7), parameter :: kinds(5) = ['TET10  ', 'TET4   ', 'WEDGE15', 'HEX20  ', 'HEX8   ']
    integer :: i

    call tests%start('seepage_space')
    do i = 1, size(kinds)
      call check_linear(tests, trim(kinds(i)))
    end do
    call check_cell(tests)
    call check_free_surface(tests)
    call check_rain(tests)
    call check_column(tests)
    call check_refusals(tests)
  end subroutine collect_seepage_space

  !> Heads that fall evenly along each axis, against which gravity acts, on cells that are no boxes: the head at places,
  !> what flows through, and by which permeability.
  subroutine check_linear(tests, element)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: element
    type(model_type) :: model
    real(wp) :: place(3), worst, along(3)
    integer :: i, d
    character(len=1), parameter :: axis(3) = ['X', 'Y', 'Z']
    character(len=7), parameter :: pull(3) = ['-1,0,0 ', '0,-1,0 ', '0,0,-1 ']
    real(wp), parameter :: size(3) = [2.0_wp, 1.0_wp, 1.5_wp], k(3) = [2.0_wp, 3.0_wp, 5.0_wp]

    do d = 1, 3
      call build(grid(element)//sets//'*NSET, NSET=foot, PLANE='//axis(d)//'| 0|*NSET, NSET=crown, PLANE='//axis(d)//'| '// &
        trim(merge('2  ', merge('1  ', '1.5', d == 2), d == 1))//'|'//soil//permeable//'*BODY, NAME=block, MATERIAL=soil, '// &
        'SHAPE=ALL|*PHASE, NAME=flow|*FIX| base, ALL|*GRAVITY| '//trim(pull(d))//'|'//level//' foot, 4| crown, 3|'// &
        '*END PHASE|', model)
      associate (field => model%analysis%phases(1)%water_levels(1)%field)
        worst = 0.0_wp
        along = 0.0_wp
        along(d) = -1.0_wp/size(d)
        do i = 1, 200
          place = size*modulo([0.618_wp, 0.414_wp, 0.732_wp]*i, 1.0_wp)
          worst = max(worst, abs(head_of_flow(field, place) - 4.0_wp - along(d)*place(d)), &
            norm2(gradient_of_flow(field, place) - along))
        end do
        call tests%close('a linear head and its gradient at 200 places, '//element, worst, 0.0_wp, solved)
        call tests%close('flows by k', maxval(abs(field%velocity + spread(k*along, 2, ubound(field%velocity, 2)))), &
          0.0_wp, solved)
        call tests%close('cells fill the box', sum(volumes(field)), product(size), solved)
      end associate
      call tests%close('in by one side', discharge_in(model%analysis, 1, 'foot'), k(d)/size(d)**2*product(size), solved)
      call tests%close('out by the other', discharge_in(model%analysis, 1, 'crown'), -k(d)/size(d)**2*product(size), solved)
    end do
    call tests%check('told a unit of time', index(model%notes, '(negative: out; a unit of time); ') > 0 .and. &
      index(model%notes, ' tetrahedra, ') > 0)
    call tests%check('water that does not lift the soil is not told', index(model%notes, 'is critical') == 0)
    call build(grid(element)//sets//soil//permeable//'*BODY, NAME=block, MATERIAL=soil, SHAPE=ALL|'//phase//level// &
      ' base, 5| top, 3|*END PHASE|', model)
    call tests%check('more is, and where', index(model%notes, 'water flows out upwards with a hydraulic gradient of 1.33 at (') > 0)
  end subroutine check_linear

  !> One tetrahedron: what it lets through by the middles of its six edges, and the water of its pores.
  subroutine check_cell(tests)
    type(tests_type), intent(inout) :: tests
    type(seepage_type) :: flow
    real(wp), parameter :: pressure(4) = [0.3_wp, -0.5_wp, -0.2_wp, -0.9_wp], reach(4) = [1.0_wp, 0.8_wp, 1.2_wp, 1.0_wp], &
      dry = 1.0e-3_wp
    integer, parameter :: pair(2, 6) = reshape([1, 2, 1, 3, 1, 4, 2, 3, 2, 4, 3, 4], [2, 6])
    real(wp) :: factor(2), by_pressure(4, 2), by(4), filled(6)
    integer :: i, k
    integer, parameter :: power(2) = [3, 1]

    filled = [(1.0_wp + min(0.0_wp, 0.5_wp*sum(pressure(pair(:, i)))), i=1, 6)]
    call let_through_in_time(curve_type(), pressure, reach, factor, by_pressure)
    do k = 1, 2
      by = [(sum(filled**(power(k) - 1), mask=any(pair == i, dim=1) .and. filled < 1.0_wp), i=1, 4)] &
        *power(k)*(1.0_wp - dry)/12.0_wp
      call tests%close('k_r is the mean of those at the middles of six edges, cubes along the level', factor(k), &
        dry + (1.0_wp - dry)*sum(filled**power(k))/6.0_wp, 1.0e-14_wp)
      call tests%close('and its derivative', maxval(abs(by_pressure(:, k) - by)), 0.0_wp, 1.0e-14_wp)
    end do
    flow%position = reshape([0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 2.0_wp, 0.0_wp, 0.3_wp, 0.2_wp, 3.0_wp], &
      [3, 4])
    flow%corner = reshape([1, 2, 3, 4], [4, 1])
    flow%height = flow%position(3, :)
    flow%head = flow%height
    flow%depth = [1.0_wp]
    call give_pores([0.2_wp], flow)
    call tests%close('pores of a cell of 1 m3, a quarter a node', maxval(abs(flow%pores - 0.05_wp)), 0.0_wp, 1.0e-14_wp)
    call tests%close('over its height', maxval(abs(flow%reach - 3.0_wp)), 0.0_wp, 1.0e-14_wp)
  end subroutine check_cell

  !> The dam of Dupuit, 0.5 m wide and 0.125 m thick, on eight cells: as in the plane 1.0 % too much flows.
  subroutine check_free_surface(tests)
    type(tests_type), intent(inout) :: tests
    type(model_type) :: model
    type(water_line_type), allocatable :: lines(:)
    character(len=*), parameter :: air = '*GRID, ELEMENT=HEX8| X, -0.1, 0, 1| X, 0, 0.5, 8| X, 0.5, 0.6, 1| Y, 0, 0.125, 2|'// &
      ' Z, 0, 1.25, 20|*NSET, NSET=base, PLANE=Z| 0|*NSET, NSET=left, PLANE=X| 0|*NSET, NSET=right, PLANE=X| 0.5|'

    call build(air//soil//'*PERMEABILITY| 1|*BODY, NAME=dam, MATERIAL=soil, SHAPE=BOX| 0, 0.5, 0, 0.125, 0, 1.125|'// &
      phase//level//' left, 1| right, 0|*END PHASE|', model)
    call tests%close('what flows through a dam', 8.0_wp*discharge_in(model%analysis, 1, 'left'), 1.0_wp, 1.5e-2_wp)
    call tests%close('leaves it', discharge_in(model%analysis, 1, 'left') + discharge_in(model%analysis, 1, 'right'), &
      0.0_wp, 1.0e-8_wp)
    call tests%check('its face is in air above', index(model%notes, "elsewhere 0 ") > 0)
    call build(air//'*SURFACE, NAME=wet, TYPE=BOX| 0, 0, 0, 0.125, 0, 0.5|'//soil//'*PERMEABILITY| 1|'// &
      '*BODY, NAME=dam, MATERIAL=soil, SHAPE=BOX| 0, 0.5, 0, 0.125, 0, 1.125|'//phase//level//' wet, 1|*END PHASE|', model)
    call tests%close('a surface below, on which the level stands as far as it reaches, and a free face', &
      8.0_wp*discharge_in(model%analysis, 1, 'wet'), 1.0_wp, 1.5e-2_wp)
    call tests%check('and that is told', index(model%notes, "'wet' also acts on adjacent exposed faces up to") > 0)
    call build(air//'*SURFACE, NAME=wet, TYPE=BOX| 0, 0, 0, 0.125, 0, 1.125|*SURFACE, NAME=dry, TYPE=BOX| 0.5, 0.5, 0, 0.125, '// &
      '0, 1.125|'//soil//'*PERMEABILITY| 1|*BODY, NAME=dam, MATERIAL=soil, SHAPE=BOX| 0, 0.5, 0, 0.125, 0, 1.125|'//phase// &
      '*SUPPORT, SURFACE=dry, TYPE=ALL|'//level//' wet, 1|*END PHASE|', model)
    call tests%close('what a support holds is tight', discharge_in(model%analysis, 1, 'wet'), 0.0_wp, 1.0e-8_wp)
    model%state%progress%phase = 1
    call water_lines(model, lines)
    call tests%close('a surface in space is no line', real(size(lines), wp), 0.0_wp, 0.0_wp)
  end subroutine check_free_surface

  !> Rain on a level top between two sides.
  subroutine check_rain(tests)
    type(tests_type), intent(inout) :: tests
    type(model_type) :: model

    call build(grid('HEX8')//'*NSET, NSET=base, PLANE=Z| 0|*NSET, NSET=left, BOX| 0, 0, 0, 1, 0, 0.5|'// &
      '*NSET, NSET=right, BOX| 2, 2, 0, 1, 0, 0.5|*NSET, NSET=top, PLANE=Z| 1.5|'//soil//'*PERMEABILITY| 1|'//block// &
      phase//level//' left, 0.5| right, 0.5| top, 0, 0.05|*END PHASE|', model)
    call tests%close('rain comes in', discharge_in(model%analysis, 1, 'top'), 0.05_wp*2.0_wp, 1.0e-8_wp)
    call tests%close('and leaves by the sides', discharge_in(model%analysis, 1, 'left') &
      + discharge_in(model%analysis, 1, 'right'), -0.1_wp, 1.0e-8_wp)
    call tests%check('its mound is above the levels', head_of_flow(model%analysis%phases(1)%water_levels(1)%field, &
      [1.0_wp, 0.5_wp, 0.3_wp]) > 0.52_wp)
  end subroutine check_rain

  !> A full column of 4 m on a level of 1 m: 2 m of it are full after n (2 + ln 3)/k.
  subroutine check_column(tests)
    type(tests_type), intent(inout) :: tests
    type(model_type) :: model

    call build('*GRID, ELEMENT=HEX8| X, 0, 0.2, 2| Y, 0, 0.1, 1| Z, 0, 4, 40|*NSET, NSET=base, PLANE=Z| 0|'// &
      '*NSET, NSET=top, PLANE=Z| 4|'//soil//'*PERMEABILITY, DRAINABLE POROSITY=0.2| 1|'// &
      '*BODY, NAME=column, MATERIAL=soil, SHAPE=ALL|'//phase//level//' base, 4| top, 4|*END PHASE|'// &
      '*PHASE, NAME=drains, TIME=0.61972|*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, UNIT WEIGHT=10| base, 1| top, 0|'// &
      '*END PHASE|*PHASE, NAME=again, TIME=1E-6|*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, UNIT WEIGHT=10| base, 1|'// &
      ' top, 0|*END PHASE|', model)
    call tests%check('water leaves by its base', discharge_in(model%analysis, 2, 'base') < 0.0_wp)
    ! The level falls evenly over the phase: somewhat more is left than if it were down at once.
    call tests%close('as the surface comes down', head_of_flow(model%analysis%phases(2)%water_levels(1)%field, &
      [0.1_wp, 0.05_wp, 1.0_wp]), 1.7_wp, 0.15_wp)
  end subroutine check_column

  !> What is not taken.
  subroutine check_refusals(tests)
    type(tests_type), intent(inout) :: tests

    call refused(tests, grid('HEX8')//sets//soil//permeable//'*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX| 0, 2, 0, 1, 0, 1.2|'// &
      phase//level//' left, 4| right, 3|*END PHASE|', "'block' (*WATER LEVEL, TYPE=SEEPAGE), which ends inside cells")
    call refused(tests, grid('HEX8')//sets//'*NSET, NSET=inside, BOX| 0.1, 1.9, 0.1, 0.9, 0.1, 1|'//soil//permeable//block// &
      phase//level//' left, 4| inside, 3|*END PHASE|', &
      "no face of the ground is in 'inside' (a well or drain inside the ground requires a plane model)")
  end subroutine check_refusals

  !> A grid whose inner nodes are off their lines, or whose cells differ.
  pure function grid(element) result(lines)
    character(len=*), intent(in) :: element
    character(len=:), allocatable :: lines

    lines = '*GRID, ELEMENT='//element//', PERTURB=0.1| X, 0, 2, 4| Y, 0, 1, 2| Z, 0, 1.5, 3|'
    if (element(:3) /= 'TET' .and. element(:5) /= 'WEDGE') lines = '*GRID, ELEMENT='//element// &
      '| X, 0, 2, 4, 3| Y, 0, 1, 2| Z, 0, 1.5, 3|'
  end function grid

  !> Volumes of tetrahedra.
  pure function volumes(field)
    type(seepage_field_type), intent(in) :: field
    real(wp) :: volumes(size(field%corner, 2)), a(3), b(3), c(3)
    integer :: i

    do i = 1, size(volumes)
      associate (x => field%position(:, field%corner(:, i)))
        a = x(:, 2) - x(:, 1)
        b = x(:, 3) - x(:, 1)
        c = x(:, 4) - x(:, 1)
      end associate
      volumes(i) = abs(a(1)*(b(2)*c(3) - b(3)*c(2)) + a(2)*(b(3)*c(1) - b(1)*c(3)) + a(3)*(b(1)*c(2) - b(2)*c(1)))/6.0_wp
    end do
  end function volumes

  !> A deck is refused with these words.
  subroutine refused(tests, deck, words)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: deck, words
    type(model_type) :: model
    character(len=:), allocatable :: said

    call build(deck, model, said)
    call tests%check(words, index(said, words) > 0)
  end subroutine refused

  !> The model of a deck.
  subroutine build(deck, model, said)
    character(len=*), intent(in) :: deck
    type(model_type), intent(out) :: model
    !> What is said of a deck that is refused; without it none is.
    character(len=:), allocatable, intent(out), optional :: said
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('space.inp', joined('*MODEL, TYPE=3D|'//deck), analysis, messages, error)
    if (present(said)) said = message_text(messages)
    if (.not. allocated(error)) then
      call build_model(analysis, model, error)
      if (allocated(error) .and. present(said)) said = error%message
    end if
    if (.not. allocated(error) .or. present(said)) return
    print '(a)', message_text(messages), error%message
    error stop 'a deck of the suite of seepage in space is broken'
  end subroutine build
end module test_seepage_space
