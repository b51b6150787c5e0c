!> Drainage of each undrained material in each phase, from *DRAIN STATE: plain data of the material, so that its law is
!> identical whenever it is created (after a restart, or again in a phase).
!>
!> A law belongs to a material: all bodies of a material are drained together.
module qsmpm_drainage
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_description, only: drain_state_type
  use qsmpm_phase_tree, only: parent_of
  use qsmpm_undrained_parameters, only: undrained_c, drainage_none, drainage_dissipates, drainage_keeps
  implicit none
  private

  public :: set_drainage, is_drained_by, has_excess_pressure

contains

  !> Sets the drainage of every undrained material in every phase where it is not set yet, since a reduced model has
  !> other bodies.
  pure subroutine set_drainage(analysis)
    type(analysis_type), intent(inout) :: analysis
    integer :: m, i, after(0:size(analysis%phases))

    after(0) = drainage_none
    do m = 1, size(analysis%materials)
      if (.not. analysis%materials(m)%undrained%given) cycle
      associate (undrained => analysis%materials(m)%undrained)
        if (allocated(undrained%drainage)) cycle
        allocate (undrained%drainage(size(analysis%phases)), source=drainage_none)
        do i = 1, size(analysis%phases)
          after(i) = after(parent_of(analysis%phases, i))
          undrained%drainage(i) = after(i)
          associate (card => analysis%phases(i)%drain_state)
            if (.not. is_drained_by(analysis, m, card)) cycle
            undrained%drainage(i) = merge(drainage_keeps, drainage_dissipates, card%keeps)
            after(i) = merge(drainage_keeps, drainage_none, card%stays_drained)
          end associate
        end do
      end associate
    end do
  end subroutine set_drainage

  !> Returns whether a *DRAIN STATE applies to a material.
  pure logical function is_drained_by(analysis, material, card) result(is_drained)
    type(analysis_type), intent(in) :: analysis
    !> Number of the material.
    integer, intent(in) :: material
    type(drain_state_type), intent(in) :: card
    integer :: b, i

    is_drained = card%given
    if (.not. (card%given .and. allocated(card%bodies))) return
    if (size(card%bodies) == 0) return
    is_drained = .false.
    do b = 1, size(analysis%bodies)
      if (analysis%bodies(b)%material /= analysis%materials(material)%name) cycle
      is_drained = is_drained .or. any([(card%bodies(i)%text == analysis%bodies(b)%name, i=1, size(card%bodies))])
    end do
  end function is_drained_by

  !> Returns whether a material has an excess pore pressure.
  pure logical function has_excess_pressure(analysis, material) result(has)
    type(analysis_type), intent(in) :: analysis
    !> Number of the material.
    integer, intent(in) :: material

    associate (undrained => analysis%materials(material)%undrained)
      has = undrained%given .and. undrained%kind /= undrained_c
    end associate
  end function has_excess_pressure
end module qsmpm_drainage
