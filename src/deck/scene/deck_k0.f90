!> *K0 of a material, and whether its strength can carry it.
module qsmpm_deck_k0
  use qsmpm_kinds, only: wp
  use qsmpm_material_description, only: material_type
  use qsmpm_phase_description, only: initial_k0
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_keyword_table, only: table_type, in_material, once
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_material_traits, only: traits_of
  use qsmpm_stress_at_rest, only: has_ratio, horizontal_at_rest, passive_ratio, unloading_poisson
  use qsmpm_rounded_text, only: rounded_text
  implicit none
  private

  public :: add_k0_keyword, check_k0

  !> K0 and the passive ratio are the same up to rounding.
  real(wp), parameter :: rounding = 1.0e-9_wp

contains

  !> *K0.
  subroutine add_k0_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('K0', in_material, once, 'Horizontal over vertical effective stress of the material at the '// &
      'start, in the place of that of *INITIAL, TYPE=K0.', ratio_fields, '*K0| 0.5|*K0, TYPE=JAKY, OCR=2', check_card)
  end subroutine add_k0_keyword

  !> *K0.
  subroutine ratio_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (rest => deck%analysis%materials(deck%material)%at_rest)
      call fields%there(has_ratio(deck%analysis%materials(deck%material)))
      call fields%line(rest%where)
      call fields%answer('TYPE', rest%jaky, 'K0 of first loading: VALUE: that of the data line, JAKY: 1 - sin phi', &
        words='VALUE|JAKY')
      call fields%number('OCR', rest%overconsolidation, 'largest vertical stress in the past over the present one: '// &
        'K0 OCR - (OCR - 1) nu/(1 - nu)', range='[1, inf)')
      call fields%number('POP', rest%pre_overburden, 'largest vertical stress in the past less the present one, in '// &
        'the place of OCR', range='[0, inf)')
      call fields%number('NU', rest%poisson, "Poisson's ratio of unloading, for OCR and POP; that of the material "// &
        'when not given', range='[0, 0.5)')
      call fields%data('ratio', when='TYPE=VALUE')
      call fields%number('k0', rest%k0, 'horizontal over vertical stress', range='(0, inf)')
    end associate
  end subroutine ratio_fields

  !> One way to say what the ground has carried.
  subroutine check_card(state)
    type(deck_state_type), intent(inout) :: state

    associate (rest => state%analysis%materials(state%material)%at_rest)
      if (rest%overconsolidation > 1.0_wp .and. rest%pre_overburden > 0.0_wp) call state%report_error('give OCR or '// &
        'POP, not both')
    end associate
  end subroutine check_card

  !> K0 of all materials, when they are complete.
  subroutine check_k0(state)
    type(deck_state_type), intent(inout) :: state
    real(wp) :: default
    logical :: starts
    integer :: i

    default = 1.0_wp
    starts = .false.
    if (size(state%analysis%phases) > 0) then
      starts = state%analysis%phases(1)%initial%kind == initial_k0
      if (starts) default = state%analysis%phases(1)%initial%k0
    end if
    do i = 1, size(state%analysis%materials)
      associate (material => state%analysis%materials(i))
        if (has_ratio(material)) then
          call check_source(state, material)
          call check_range(state, material, default)
        else if (starts) then
          call check_range(state, material, default)
        end if
      end associate
    end do
  end subroutine check_k0

  !> What K0 is made of is known of the material.
  subroutine check_source(state, material)
    type(deck_state_type), intent(inout) :: state
    type(material_type), intent(in) :: material
    type(law_description_type) :: traits

    traits = traits_of(material)
    if (material%at_rest%jaky .and. .not. traits%friction_angle > 0.0_wp) call state%error_from( &
      material%at_rest%where, 'K0', "TYPE=JAKY wants a friction angle, which is not known of material '"// &
      material%name//"': give a value")
    if ((material%at_rest%overconsolidation > 1.0_wp .or. material%at_rest%pre_overburden > 0.0_wp) .and. &
      .not. (unloading_poisson(material) > 0.0_wp .or. material%at_rest%poisson >= 0.0_wp)) call state%error_from( &
      material%at_rest%where, 'K0', "OCR and POP want Poisson's ratio, which is not known of material '"// &
      material%name//"': give NU")
  end subroutine check_source

  !> The ratio lies between 0 and the passive one of soil without cohesion.
  subroutine check_range(state, material, default)
    type(deck_state_type), intent(inout) :: state
    type(material_type), intent(in) :: material
    !> K0 of materials without their own.
    real(wp), intent(in) :: default
    type(material_type) :: normal
    real(wp) :: ratio

    ! With POP the ratio falls with depth; what can be judged is that of a great depth.
    normal = material
    normal%at_rest%pre_overburden = 0.0_wp
    ratio = horizontal_at_rest(normal, default, 1.0_wp)
    if (ratio > 0.0_wp .and. ratio*(1.0_wp - rounding) <= passive_ratio(material)) return
    if (ratio > 0.0_wp) then
      call report("K0 = "//rounded_text(ratio)//" of material '"//material%name//"' is above its passive ratio, "// &
        rounded_text(passive_ratio(material)))
    else
      call report("K0 = "//rounded_text(ratio)//" of material '"//material%name//"' is not above 0")
    end if
  contains
    !> An error at the card that has the ratio.
    subroutine report(sentence)
      character(len=*), intent(in) :: sentence

      if (has_ratio(material)) then
        call state%error_from(material%at_rest%where, 'K0', sentence)
      else
        call state%error_from(state%analysis%phases(1)%initial%where, 'INITIAL', sentence)
      end if
    end subroutine report
  end subroutine check_range
end module qsmpm_deck_k0
