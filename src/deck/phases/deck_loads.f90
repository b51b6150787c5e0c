!> Cards of what acts on a phase: *GRAVITY, *TRACTION, *PRESSURE, *WATER LEVEL (qsmpm_deck_water), *SUPPORT, which holds
!> a surface, and *CONTRACTION, which holds and moves that of a cavity.
module qsmpm_deck_loads
  use qsmpm_kinds, only: wp
  use qsmpm_load_description, only: traction_type, support_all, support_none
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_objects, only: list_tractions, list_supports
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_deck_water, only: add_water_keyword
  use qsmpm_deck_words, only: bar_list, carrier_words, support_words
  use qsmpm_keyword_table, only: table_type, in_phase, once, many
  implicit none
  private

  public :: add_load_keywords

contains

  !> *GRAVITY, *TRACTION, *PRESSURE, *WATER LEVEL, *SUPPORT, *CONTRACTION.
  subroutine add_load_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('GRAVITY', in_phase, once, 'Gravity per unit of load factor; multiplies the '// &
      'unit weight of the materials.', gravity_fields, '*GRAVITY| 0, -1')
    call table%add('TRACTION', in_phase, many, 'Dead load on a surface, force per undeformed '// &
      'area per unit of load factor.', traction_fields, '*TRACTION, SURFACE=top| 0, -10', check_load, &
      list=list_tractions, opens='traction')
    call table%add('PRESSURE', in_phase, many, 'Pressure on a surface per unit of load factor; it '// &
      'follows area and normal of the surface and may grow with depth.', pressure_fields, &
      '*PRESSURE, SURFACE=wall| 50|*PRESSURE, SURFACE=face, LEVEL=3, UNIT WEIGHT=9.81', check_pressure, &
      list=list_tractions, opens='pressure')
    call add_water_keyword(table)
    call table%add('SUPPORT', in_phase, many, 'Surface held at zero displacement wherever it '// &
      'cuts the grid; stays until changed.', support_fields, '*SUPPORT, SURFACE=rock, TYPE=NORMAL', check_support, &
      list=list_supports, opens='support')
    call table%add('CONTRACTION', in_phase, many, 'Outline of a cavity, as of a tunnel, that shrinks over the '// &
      'phase as a lining does, alike all around (a circle along its normals), and is held there until *SUPPORT or '// &
      'another contraction changes it: ground lost to a tunnel. In plane strain.', contraction_fields, &
      '*CONTRACTION, SURFACE=tunnel| 1.5', check_support, list=list_supports, opens='contraction')
  end subroutine add_load_keywords

  !> *GRAVITY.
  subroutine gravity_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (gravity => deck%analysis%phases(deck%phase)%gravity)
      call fields%given(gravity%given)
      call fields%data('vector')
      call vector_fields(fields, 'g', gravity%vector)
    end associate
  end subroutine gravity_fields

  !> Columns of a vector.
  subroutine vector_fields(fields, letter, vector)
    class(card_fields_type), intent(inout) :: fields
    character(len=1), intent(in) :: letter
    real(wp), intent(inout) :: vector(3)

    call fields%number(letter//'x', vector(1), 'component')
    call fields%number(letter//'y', vector(2), 'component')
    call fields%number(letter//'z', vector(3), 'component', third=.true.)
  end subroutine vector_fields

  !> *TRACTION.
  subroutine traction_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (traction => deck%analysis%phases(deck%phase)%tractions(deck%item))
      call fields%there(.not. traction%follows)
      call surface_field(fields, traction)
      call fields%choice('CARRIER', traction%carrier, bar_list(carrier_words), 'tracked surface points, or the '// &
        'outermost material points, only to compare with the paper')
      call fields%data('vector')
      call vector_fields(fields, 't', traction%vector)
    end associate
  end subroutine traction_fields

  !> *PRESSURE.
  subroutine pressure_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (traction => deck%analysis%phases(deck%phase)%tractions(deck%item))
      call fields%given(traction%follows)
      call surface_field(fields, traction)
      call water_fields(fields, traction)
      call fields%data('nothing: the level says it', 0, 0, when='LEVEL')
      call fields%data('pressure')
      call fields%number('p', traction%pressure, 'force per current area, positive against the body')
      call fields%number('gradient', traction%gradient, 'what it grows by per length downwards, 0 when not given', &
        required=.false.)
      call fields%number('y', traction%height, 'height at which it is p, 0 when not given: the coordinate along '// &
        'which gravity acts, y without gravity', required=.false.)
      if (fields%reading .and. traction%of_water) traction%pressure = 0.0_wp
    end associate
  end subroutine pressure_fields

  !> Level and unit weight of the water that presses.
  subroutine water_fields(fields, traction)
    class(card_fields_type), intent(inout) :: fields
    type(traction_type), intent(inout) :: traction
    real(wp) :: weight

    call fields%number('LEVEL', traction%height, 'height of the water that stands against the surface, in place of '// &
      'the data line: the pressure is UNIT WEIGHT times the depth below it', given=traction%of_water)
    weight = 0.0_wp
    if (traction%of_water) weight = traction%gradient
    call fields%number('UNIT WEIGHT', weight, 'weight of the water per volume', range='(0, inf)', needs='LEVEL')
    if (fields%reading .and. traction%of_water) traction%gradient = weight
  end subroutine water_fields

  !> A pressure of water has its weight.
  subroutine check_pressure(state)
    type(deck_state_type), intent(inout) :: state

    call check_load(state)
    if (state%card%has('LEVEL') .and. .not. state%card%has('UNIT WEIGHT')) call state%report_error('LEVEL wants '// &
      'the parameter UNIT WEIGHT, the weight of the water per volume')
  end subroutine check_pressure

  !> The surface of a load.
  subroutine surface_field(fields, traction)
    class(card_fields_type), intent(inout) :: fields
    type(traction_type), intent(inout) :: traction

    call fields%line(traction%where)
    call fields%name('SURFACE', traction%surface, 'the surface', required=.true.)
  end subroutine surface_field

  !> A phase has one load a surface.
  subroutine check_load(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (list => state%analysis%phases(state%phase)%tractions)
      do i = 1, size(list) - 1
        if (list(i)%surface == list(size(list))%surface) call state%report_error("surface '"//list(i)%surface// &
          "' has a traction in this phase already")
      end do
    end associate
  end subroutine check_load

  !> *SUPPORT.
  subroutine support_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (support => deck%analysis%phases(deck%phase)%supports(deck%item))
      call fields%there(.not. support%contracts)
      call fields%line(support%where)
      call fields%name('SURFACE', support%surface, 'the surface; a plane one for TYPE=NORMAL', required=.true.)
      call fields%choice('TYPE', support%kind, bar_list(support_words), 'NORMAL: it slides on its plane, ALL: it '// &
        'sticks, FREE: it is freed again', first=support_none)
    end associate
  end subroutine support_fields

  !> *CONTRACTION.
  subroutine contraction_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (support => deck%analysis%phases(deck%phase)%supports(deck%item))
      call fields%given(support%contracts)
      if (fields%reading) support%kind = support_all
      call fields%line(support%where)
      call fields%name('SURFACE', support%surface, 'the outline of the cavity: closed, or half or a quarter of a '// &
        'circle that ends at planes of symmetry', required=.true.)
      call fields%answer('HELD', support%held, 'NO: the outline as a whole weighs nothing and finds its height, as '// &
        'a lining does; YES: its middle stays, and the trough is flatter')
      call fields%data('volume loss')
      call fields%number('percent', support%volume_loss, 'part of the area of the cavity that is lost at the end '// &
        'of the phase, per unit of load factor; negative: the cavity widens', range='(-100, 50]')
    end associate
  end subroutine contraction_fields

  !> A phase has one support a surface.
  subroutine check_support(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (list => state%analysis%phases(state%phase)%supports)
      do i = 1, size(list) - 1
        if (list(i)%surface == list(size(list))%surface) call state%report_error("surface '"//list(i)%surface// &
          "' has a support or contraction in this phase already")
      end do
    end associate
  end subroutine check_support
end module qsmpm_deck_loads
