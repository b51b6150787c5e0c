!> The axisymmetric model of a figure of revolution: half sections for bodies, radius and height for x and
!> y, and the way back.
module qsmpm_revolved_half
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type, axisymmetric
  use qsmpm_history_description, only: quantity_position, quantity_stress, quantity_strain, quantity_reaction
  use qsmpm_history_quantities, only: is_taken_at, at_rigid_body
  use qsmpm_reduction, only: reduction_type, reduce_revolved, begin_reduction
  use qsmpm_set_members, only: members_type, find_members, keep_supports, scene_tolerance
  use qsmpm_loaded_surfaces, only: drop_unused
  use qsmpm_rigid_reduction, only: flatten_rigid_bodies, reduce_rigid_history
  use qsmpm_revolved, only: revolved_solid_type, is_level
  implicit none
  private

  public :: make_revolved

  !> Name of the set of the axis; no deck can write it without quotes.
  character(len=*), parameter :: axis_name = '=axis'

contains

  !> The axisymmetric model of a figure of revolution, and the way back.
  pure subroutine make_revolved(analysis, solid, step)
    !> The scene; the model.
    type(analysis_type), intent(inout) :: analysis
    !> What the proof has found.
    type(revolved_solid_type), intent(in) :: solid
    !> The way back.
    type(reduction_type), intent(out) :: step
    type(members_type) :: members
    integer :: s, b, p

    call begin_reduction(analysis, reduce_revolved, 0, step)
    call find_members(analysis, members)
    step%factor = solid%sector(2) - solid%sector(1)
    step%centre = solid%centre
    step%sector = solid%sector
    call round_histories(analysis, solid, step)
    call flatten_rigid_bodies(analysis, [1, 3], step%factor)
    do s = 1, size(analysis%node_sets)
      analysis%node_sets(s)%box(1, :) = [-solid%radius, 2.0_wp*solid%radius]
      analysis%node_sets(s)%box(3, :) = 0.0_wp
    end do
    call keep_supports(analysis, [(is_level(members, s), s=1, size(analysis%node_sets))], 1, [0.0_wp], [axis_name])
    do p = 1, size(analysis%phases)
      analysis%phases(p)%fixities%fixed(3) = .false.
    end do
    call drop_unused(analysis)
    do s = 1, size(analysis%surfaces)
      analysis%surfaces(s)%box(1, :) = [0.0_wp, solid%radius]
      analysis%surfaces(s)%box(3, :) = 0.0_wp
    end do
    analysis%bodies = solid%bodies
    do b = 1, size(analysis%bodies)
      associate (n => analysis%bodies(b)%points_per_element)
        if (n > 0) n = nint(real(n, wp)**(1.0_wp/3.0_wp))**2
      end associate
    end do
    call radial_lines(analysis, solid)
    analysis%mesh%element = trim(merge('QUAD4', 'QUAD8', analysis%mesh%element == 'HEX8'))
    analysis%model = axisymmetric
  end subroutine make_revolved

  !> Lines along the radius: those along x beyond the axis, as far as the nearest side.
  pure subroutine radial_lines(analysis, solid)
    !> The scene; its grid in radius and height.
    type(analysis_type), intent(inout) :: analysis
    type(revolved_solid_type), intent(in) :: solid
    real(wp) :: lines(size(analysis%mesh%axes(1)%lines)), tolerance
    integer :: i, n

    tolerance = scene_tolerance(analysis)
    n = 0
    do i = 1, size(lines)
      associate (radius => analysis%mesh%axes(1)%lines(i) - solid%centre(1))
        if (radius < -tolerance .or. radius > solid%radius + tolerance) cycle
        n = n + 1
        lines(n) = merge(0.0_wp, radius, n == 1)
      end associate
    end do
    deallocate (analysis%mesh%axes(1)%lines, analysis%mesh%axes(3)%lines)
    allocate (analysis%mesh%axes(1)%lines(n), source=lines(:n))
  end subroutine radial_lines

  !> Histories by radius and height.
  pure subroutine round_histories(analysis, solid, step)
    type(analysis_type), intent(inout) :: analysis
    type(revolved_solid_type), intent(in) :: solid
    !> Gets the way back.
    type(reduction_type), intent(inout) :: step
    real(wp) :: from(2), along(2), radius
    integer :: i

    do i = 1, size(analysis%histories)
      associate (history => analysis%histories(i))
        if (history%quantity == quantity_reaction) then
          step%history_factor(i) = merge(step%factor, 0.0_wp, history%component == 2)
          if (history%component /= 2) history%component = 1
          cycle
        end if
        if (is_taken_at(history%quantity, at_rigid_body)) then
          call reduce_rigid_history(history, [1, 3], step%factor, step%history_factor(i))
          cycle
        end if
        from = history%at([1, 3]) - solid%centre
        radius = norm2(from)
        along = 0.0_wp
        if (radius > 0.0_wp) along = from/radius
        history%at = [radius, history%at(2), 0.0_wp]
        if (any(history%quantity == [quantity_stress, quantity_strain])) then
          call round_stress(history%component, abs(from(2)) <= scene_tolerance(analysis), along, step%history_factor(i))
        else if (history%component /= 2) then
          step%history_factor(i) = along((history%component + 1)/2)
          if (history%quantity == quantity_position) step%history_offset(i) = solid%centre((history%component + 1)/2)
          history%component = 1
        end if
      end associate
    end do
  end subroutine round_histories

  !> A stress component on the x or z axis by those of radius, height and ring.
  pure subroutine round_stress(component, on_x, along, factor)
    !> 1 to 6 in, 1 to 4 out.
    integer, intent(inout) :: component
    !> The place lies on the x axis, else on the z axis.
    logical, intent(in) :: on_x
    !> Direction of the radius: x and z.
    real(wp), intent(in) :: along(2)
    !> Sign of the component, 0 for what vanishes.
    real(wp), intent(out) :: factor
    integer, parameter :: by_x(6) = [1, 2, 3, 4, 0, 0], by_z(6) = [3, 2, 1, 0, 0, 4]
    integer :: found

    found = merge(by_x(component), by_z(component), on_x)
    factor = 1.0_wp
    if (found == 4) factor = merge(along(1), along(2), on_x)
    if (found == 0) factor = 0.0_wp
    component = max(1, found)
  end subroutine round_stress
end module qsmpm_revolved_half
