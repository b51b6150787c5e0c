!> Rigid bodies of the smaller scenes: in the plane, beside a mirror, about an axis. What is loaded gets its share of
!> the load, what lies beyond a mirror is left out and read from its image.
module qsmpm_rigid_reduction
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: analysis_type
  use qsmpm_history_description, only: history_type, quantity_contact_force, quantity_contact_moment, &
    quantity_body_rotation
  use qsmpm_structures, only: rigid_body_type, contact_type, rigid_move_type
  use qsmpm_history_quantities, only: is_taken_at, at_rigid_body
  use qsmpm_rigid_symmetry, only: rigid_partner, rigid_side, rigid_above
  implicit none
  private

  public :: flatten_rigid_bodies, half_rigid_bodies, reduce_rigid_history, mirror_rigid_history

contains

  !> Bodies in the plane, or by radius and height: what they have along z is left out, and along x in axisymmetry; loads
  !> on them are shares of those of the scene.
  pure subroutine flatten_rigid_bodies(analysis, axes, factor)
    type(analysis_type), intent(inout) :: analysis
    !> Axes of which nothing stays.
    integer, intent(in) :: axes(:)
    !> Forces of the scene over those of the smaller one.
    real(wp), intent(in) :: factor
    integer :: b, i, p

    if (.not. allocated(analysis%rigid_bodies)) return
    do b = 1, size(analysis%rigid_bodies)
      analysis%rigid_bodies(b)%place(axes) = 0.0_wp
      analysis%rigid_bodies(b)%direction(axes) = 0.0_wp
      analysis%rigid_bodies(b)%box(3, :) = 0.0_wp
    end do
    do p = 1, size(analysis%phases)
      do i = 1, size(analysis%phases(p)%moves)
        analysis%phases(p)%moves(i)%vector(axes) = 0.0_wp
        analysis%phases(p)%moves(i)%load = analysis%phases(p)%moves(i)%load/factor
      end do
    end do
  end subroutine flatten_rigid_bodies

  !> A history of a rigid body that is the same all along what is left out: forces and moments count as often as the
  !> smaller scene does; what goes along an axis that is left out is nothing.
  pure subroutine reduce_rigid_history(history, gone, factor, value_factor)
    type(history_type), intent(inout) :: history
    !> Components that are nothing.
    integer, intent(in) :: gone(:)
    !> Forces of the scene over those of the smaller one.
    real(wp), intent(in) :: factor
    !> Value of the scene over that of the smaller one; stays for other histories.
    real(wp), intent(inout) :: value_factor

    if (.not. is_taken_at(history%quantity, at_rigid_body)) return
    if (any(history%quantity == [quantity_contact_force, quantity_contact_moment])) value_factor = factor
    if (history%quantity == quantity_contact_moment) return
    if (any(gone == history%component)) then
      value_factor = 0.0_wp
      history%component = 2
    end if
  end subroutine reduce_rigid_history

  !> A history of a rigid body in the half below a mirror: of a body across the plane both halves count, one beyond it
  !> is read from its image.
  pure subroutine mirror_rigid_history(analysis, axis, history, value_factor)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: axis
    type(history_type), intent(inout) :: history
    !> Value of the scene over that of the half.
    real(wp), intent(inout) :: value_factor
    integer :: b, partner
    logical :: odd

    b = place_named(analysis%rigid_bodies, history%body)
    partner = rigid_partner(analysis, b, axis)
    ! A moment about z turns its sense in a mirror along x.
    odd = history%component == axis
    if (any(history%quantity == [quantity_contact_moment, quantity_body_rotation])) odd = axis == 1
    if (partner == b) then
      value_factor = merge(2.0_wp, 1.0_wp, any(history%quantity == [quantity_contact_force, quantity_contact_moment]))
      if (odd) value_factor = 0.0_wp
    else if (rigid_side(analysis, analysis%rigid_bodies(b), axis) == rigid_above) then
      value_factor = merge(-1.0_wp, 1.0_wp, odd)
      history%body = analysis%rigid_bodies(partner)%name
    end if
  end subroutine mirror_rigid_history

  !> Bodies beyond the plane are left out with their motions, loads and contacts; of those across it half of the load is
  !> left.
  pure subroutine half_rigid_bodies(analysis, axis)
    type(analysis_type), intent(inout) :: analysis
    integer, intent(in) :: axis
    type(rigid_body_type), allocatable :: bodies(:)
    type(contact_type), allocatable :: contacts(:)
    type(rigid_move_type), allocatable :: moves(:)
    logical :: beyond(size_of(analysis)), whole(size_of(analysis))
    integer :: b, i, p

    if (size(beyond) == 0) return
    allocate (bodies(0), contacts(0))
    do b = 1, size(beyond)
      whole(b) = rigid_partner(analysis, b, axis) == b
      beyond(b) = .not. whole(b) .and. rigid_side(analysis, analysis%rigid_bodies(b), axis) == rigid_above
      if (.not. beyond(b)) bodies = [bodies, analysis%rigid_bodies(b)]
    end do
    do i = 1, size(analysis%contacts)
      if (.not. beyond(place_named(analysis%rigid_bodies, analysis%contacts(i)%body))) &
        contacts = [contacts, analysis%contacts(i)]
    end do
    do p = 1, size(analysis%phases)
      allocate (moves(0))
      do i = 1, size(analysis%phases(p)%moves)
        associate (move => analysis%phases(p)%moves(i))
          b = place_named(analysis%rigid_bodies, move%body)
          if (beyond(b)) cycle
          moves = [moves, move]
          if (whole(b)) moves(size(moves))%load = 0.5_wp*move%load
        end associate
      end do
      call move_alloc(moves, analysis%phases(p)%moves)
    end do
    if (analysis%moving_mesh%by_body) then
      b = place_named(analysis%rigid_bodies, analysis%moving_mesh%body)
      if (beyond(b)) analysis%moving_mesh%body = analysis%rigid_bodies(rigid_partner(analysis, b, axis))%name
    end if
    call move_alloc(bodies, analysis%rigid_bodies)
    call move_alloc(contacts, analysis%contacts)
  end subroutine half_rigid_bodies

  !> Number of rigid bodies.
  pure integer function size_of(analysis)
    type(analysis_type), intent(in) :: analysis

    size_of = 0
    if (allocated(analysis%rigid_bodies)) size_of = size(analysis%rigid_bodies)
  end function size_of
end module qsmpm_rigid_reduction
