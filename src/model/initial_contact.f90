!> Contact in a phase that starts from initial stresses: where soil touches a rigid body the body carries what the
!> stress there asks for, so that ground at rest beside a wall is in equilibrium from the start.
!>
!>   p = -n . sigma n,   t = -(1 - n n') sigma n
!>
!> with the normal n of the body, which looks at the soil. K0 stresses are those of the surface point itself, others
!> those of the nearest material point.
module qsmpm_initial_contact
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: initial_stress_type, initial_k0
  use qsmpm_carried_basis, only: nearest_point
  use qsmpm_initial_stress, only: stresses_at_rest
  use qsmpm_model, only: model_type
  use qsmpm_points, only: place_of
  use qsmpm_rigid_bodies, only: placed_bodies
  use qsmpm_rigid_pose, only: placed_shape_type
  use qsmpm_rigid_shape, only: distance_type
  use qsmpm_tensor, only: unpack_symmetric
  implicit none
  private

  public :: press_on_bodies

  !> Distance over the size of a cell within which soil touches a body.
  real(wp), parameter :: touching = 1.0e-3_wp

contains

  !> Pressure and shear of the surface points that touch a body.
  subroutine press_on_bodies(model, initial)
    type(model_type), intent(inout) :: model
    !> Of the phase; the material points have its stresses.
    type(initial_stress_type), intent(in) :: initial
    type(placed_shape_type), allocatable :: bodies(:)
    type(distance_type) :: distance
    integer :: k, i

    if (size(model%contact_pairs) == 0) return
    allocate (bodies, source=placed_bodies(model))
    do k = 1, size(model%contact_pairs)
      do i = 1, model%state%surface%count
        if (model%state%surface%surface(i) /= model%contact_pairs(k)%surface) cycle
        distance = bodies(model%contact_pairs(k)%body)%distance_at(place_of(model%state%surface, i))
        if (abs(distance%value) > touching*model%cell_size) cycle
        call press(model, i, distance%normal, stress_at(model, initial, i))
      end do
    end do
  end subroutine press_on_bodies

  !> Stress of the phase at a surface point.
  function stress_at(model, initial, i) result(stress)
    type(model_type), intent(in) :: model
    type(initial_stress_type), intent(in) :: initial
    integer, intent(in) :: i
    real(wp) :: stress(size(model%state%points%stress, 1)), there(size(model%state%points%stress, 1), 1)
    integer :: p

    p = nearest_point(model%state%points, model%state%surface%position(:, i))
    stress = model%state%points%stress(:, p)
    if (initial%kind /= initial_k0) return
    call stresses_at_rest(model, initial, [p], model%state%surface%position(:, i:i), there)
    stress = there(:, 1)
  end function stress_at

  !> Tractions of one surface point; none where the stress pulls.
  pure subroutine press(model, i, normal, stress)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: i
    !> Of the body (3); of the soil (4 or 6).
    real(wp), intent(in) :: normal(3), stress(:)
    real(wp) :: tensor(3, 3), traction(3), pressure

    tensor = unpack_symmetric(stress)
    traction = -matmul(tensor, normal)
    pressure = dot_product(traction, normal)
    if (.not. pressure > 0.0_wp) return
    model%state%surface%contact_pressure(i) = pressure
    traction = traction - pressure*normal
    model%state%surface%contact_shear(:, i) = traction(:model%mesh%dimension)
  end subroutine press
end module qsmpm_initial_contact
