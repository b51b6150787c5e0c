!> Contact in a phase with initial stresses: where soil touches a rigid body the contact tractions are set to those of
!> the stress there, so that soil at rest next to a wall is in equilibrium from the start.
!>
!>   p = -n . sigma n,   t = -(1 - n n') sigma n
!>
!> with the normal n of the body, which points to the soil. K0 stresses are evaluated at the surface point, other
!> stresses at the nearest material point.
module qsmpm_initial_contact
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: initial_stress_type, initial_k0
  use qsmpm_body_points, only: body_points_type, present_body_points, keep_body_points
  use qsmpm_initial_stress, only: stresses_at_rest
  use qsmpm_model, only: model_type
  use qsmpm_points, only: place_of, nearest_point
  use qsmpm_rigid_bodies, only: placed_bodies
  use qsmpm_rigid_pose, only: placed_shape_type
  use qsmpm_rigid_shape, only: distance_type
  use qsmpm_tensor, only: unpack_symmetric
  implicit none
  private

  public :: press_on_bodies

  !> Distance in cell sizes up to which soil touches a body.
  real(wp), parameter :: touching = 1.0e-3_wp

contains

  !> Sets pressure and shear of the points that touch a body.
  subroutine press_on_bodies(model, initial)
    type(model_type), intent(inout) :: model
    !> Initial stresses of the phase, already set at the material points.
    type(initial_stress_type), intent(in) :: initial
    type(placed_shape_type), allocatable :: bodies(:)
    integer :: k

    allocate (bodies, source=placed_bodies(model))
    do k = 1, size(model%contact_pairs)
      call press_surface(model, initial, model%contact_pairs(k)%surface, bodies(model%contact_pairs(k)%body))
    end do
    call press_outlines(model, initial, bodies)
  end subroutine press_on_bodies

  !> Sets the tractions of the points of a surface that touch a body; contact on the body itself has surface 0, which
  !> has no points.
  subroutine press_surface(model, initial, surface, body)
    type(model_type), intent(inout) :: model
    type(initial_stress_type), intent(in) :: initial
    integer, intent(in) :: surface
    type(placed_shape_type), intent(in) :: body
    type(distance_type) :: distance
    real(wp) :: pressure, shear(3)
    integer :: i

    do i = 1, model%state%surface%count
      if (model%state%surface%surface(i) /= surface) cycle
      distance = body%distance_at(place_of(model%state%surface, i))
      if (abs(distance%value) > touching*model%cell_size) cycle
      call press(distance%normal, stress_at(model, initial, model%state%surface%position(:, i)), pressure, shear)
      if (.not. pressure > 0.0_wp) cycle
      model%state%surface%contact_pressure(i) = pressure
      model%state%surface%contact_shear(:, i) = shear(:model%mesh%dimension)
    end do
  end subroutine press_surface

  !> Sets the tractions of contact points on bodies that soil touches.
  subroutine press_outlines(model, initial, bodies)
    type(model_type), intent(inout) :: model
    type(initial_stress_type), intent(in) :: initial
    type(placed_shape_type), intent(in) :: bodies(:)
    type(body_points_type) :: places
    type(distance_type) :: distance
    integer :: i

    call present_body_points(model, bodies, places)
    do i = 1, places%count
      if (.not. places%touched(i)) cycle
      distance = bodies(model%contact_pairs(places%pair(i))%body)%distance_at(place_of(places, i))
      call press(distance%normal, stress_at(model, initial, places%position(:, i)), places%pressure(i), &
        places%shear(:, i))
    end do
    call keep_body_points(model, places)
  end subroutine press_outlines

  !> Returns the initial stress of the phase at a place.
  function stress_at(model, initial, x) result(stress)
    type(model_type), intent(in) :: model
    type(initial_stress_type), intent(in) :: initial
    real(wp), intent(in) :: x(:)
    real(wp) :: stress(size(model%state%points%stress, 1)), there(size(model%state%points%stress, 1), 1), &
      place(size(x), 1)
    integer :: p

    p = nearest_point(model%state%points, x)
    stress = model%state%points%stress(:, p)
    if (initial%kind /= initial_k0) return
    place(:, 1) = x
    call stresses_at_rest(model, initial, [p], place, there)
    stress = there(:, 1)
  end function stress_at

  !> Computes the tractions of one point; zero where the stress is tensile.
  pure subroutine press(normal, stress, pressure, shear)
    !> Normal of the body (3); stress of the soil (4 or 6).
    real(wp), intent(in) :: normal(3), stress(:)
    real(wp), intent(out) :: pressure, shear(3)
    real(wp) :: tensor(3, 3), traction(3)

    tensor = unpack_symmetric(stress)
    traction = -matmul(tensor, normal)
    pressure = max(0.0_wp, dot_product(traction, normal))
    shear = 0.0_wp
    if (pressure > 0.0_wp) shear = traction - pressure*normal
  end subroutine press
end module qsmpm_initial_contact
