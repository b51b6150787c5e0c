!> Pits that stand full of water: soil taken out below a water level that stays.
!>
!> The force of the water on the ground (qsmpm_pore_water) holds its pressure on every face below the level, so also on
!> floor and walls of a pit. That is an excavation under water, and right as such; who means a dry pit has to lower the
!> level.
module qsmpm_flooded_pits
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: bodies_active, body_number
  use qsmpm_diagnostics, only: where_text
  use qsmpm_model, only: model_type
  use qsmpm_overburden, only: overburden_type, body_holds, facet_places
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_water_table, only: water_table_type, head_at
  implicit none
  private

  public :: warn_of_flooded_pits

contains

  !> Warn of bodies that a phase takes out below the level.
  subroutine warn_of_flooded_pits(model, ground, number, tables, tolerance, notes)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: ground
    !> Number of the phase.
    integer, intent(in) :: number
    !> Levels at its end (bodies).
    type(water_table_type), intent(in) :: tables(:)
    !> Depth of water that counts, and distance from a face to what lies behind it [length].
    real(wp), intent(in) :: tolerance(2)
    !> Sentences for the log.
    character(len=:), allocatable, intent(inout) :: notes
    real(wp) :: depth
    integer :: i

    if (.not. allocated(model%analysis%phases(number)%deactivations)) return
    associate (phase => model%analysis%phases(number))
      do i = 1, size(phase%deactivations)
        associate (change => phase%deactivations(i))
          depth = depth_of_water(model, ground, number, body_number(model%analysis, change%body), tables, tolerance(2))
          if (.not. depth > tolerance(1)) cycle
          notes = notes//'warning: '//where_text(change%where)//"*DEACTIVATE: where body '"//change%body// &
            "' is taken out water stands "//rounded_text(depth)//" deep from phase '"//phase%name// &
            "' on, because its level in the ground stays above the floor; for a dry pit let *WATER LEVEL of this "// &
            'phase run along or below the floor'//new_line('a')
        end associate
      end do
    end associate
  end subroutine warn_of_flooded_pits

  !> Largest depth below the level of the faces that a body leaves in what is still there.
  real(wp) function depth_of_water(model, ground, number, body, tables, hair) result(depth)
    type(model_type), intent(in) :: model
    type(overburden_type), intent(in) :: ground
    !> Number of the phase and of the body.
    integer, intent(in) :: number, body
    type(water_table_type), intent(in) :: tables(:)
    real(wp), intent(in) :: hair
    real(wp), allocatable :: places(:, :)
    logical :: active(size(tables))
    integer :: b, k

    depth = 0.0_wp
    active = bodies_active(model%analysis, number)
    call facet_places(ground, body, hair, places)
    do k = 1, size(places, 2)
      do b = 1, size(tables)
        if (.not. active(b) .or. .not. tables(b)%present) cycle
        if (.not. head_at(tables(b), places(:, k)) > depth) cycle
        if (body_holds(ground, b, places(:model%mesh%dimension, k))) depth = head_at(tables(b), places(:, k))
      end do
    end do
  end function depth_of_water
end module qsmpm_flooded_pits
