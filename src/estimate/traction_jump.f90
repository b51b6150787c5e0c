!> Jumps of the traction across interfaces of materials.
!>
!>   j_n = |(sigma_a(x) - sigma_b(x)) m|,   m along C^-1 (x_a - x_b) in the patch of node n
!>
!> with the centres x_a, x_b of the points of the two materials in the patch and their covariance C about them (Fisher's
!> discriminant, 1936), or m along the axis that separates the two by a larger distance. Only stress components parallel
!> to the interface may be discontinuous there; the remaining jump is an error of the fields of the two materials
!> relative to each other, which the smooth field of each does not show. x is half way between adjacent points of the
!> two. Only materials separated by a plane are considered: at a corner the normal is not unique.
module qsmpm_traction_jump
  use qsmpm_kinds, only: wp
  use qsmpm_points, only: points_type
  use qsmpm_smooth_stress, only: patches_type, smooth_stress_type, most_terms, term_count, patch_terms
  implicit none
  private

  public :: add_traction_jump, across

  !> Largest overlap of the points of the two materials along the normal, and largest distance between them, in cells.
  real(wp), parameter :: most_mixed = 0.15_wp, most_apart = 1.0_wp
  !> Regularisation of the covariance of a row of points, relative to the square of the cell size.
  real(wp), parameter :: ridge = 1.0e-4_wp

contains

  !> Adds the jumps between two materials at the nodes that have points of both in their patch.
  pure subroutine add_traction_jump(patches, points, one, other, jump)
    type(patches_type), intent(in) :: patches
    type(points_type), intent(in) :: points
    !> Fields of the two materials.
    type(smooth_stress_type), intent(in) :: one, other
    !> Largest jump at each node (nodes) [stress].
    real(wp), intent(inout) :: jump(:)
    real(wp), dimension(size(points%position, 1)) :: normal, place, along
    real(wp) :: reach(2), by_axis(2), cell, stress(size(points%stress, 1))
    integer :: n, d

    do n = 1, size(jump)
      if (min(one%degree(n), other%degree(n)) < 0) cycle
      call find_normal(patches, points, n, one, other, normal)
      if (.not. norm2(normal) > 0.0_wp) cycle
      call reach_of(patches, points, n, normal, [other%material, one%material], reach)
      do d = 1, size(normal)
        along = 0.0_wp
        along(d) = sign(1.0_wp, one%centre(d, n) - other%centre(d, n))
        call reach_of(patches, points, n, along, [other%material, one%material], by_axis)
        if (by_axis(2) - by_axis(1) <= reach(2) - reach(1)) cycle
        normal = along
        reach = by_axis
      end do
      cell = dot_product(abs(normal), one%extent(:, n))
      if (reach(2) - reach(1) < -most_mixed*cell .or. reach(2) - reach(1) > most_apart*cell) cycle
      place = 0.5_wp*(one%centre(:, n) + other%centre(:, n))
      place = place + (0.5_wp*sum(reach) - dot_product(place, normal))*normal
      stress = field_at(one, n, place) - field_at(other, n, place)
      jump(n) = max(jump(n), norm2(across(stress, normal)))
    end do
  end subroutine add_traction_jump

  !> Finds the unit normal of the interface from the other material to the first one; 0 where there is none.
  pure subroutine find_normal(patches, points, n, one, other, normal)
    type(patches_type), intent(in) :: patches
    type(points_type), intent(in) :: points
    !> Number of the node.
    integer, intent(in) :: n
    type(smooth_stress_type), intent(in) :: one, other
    real(wp), intent(out) :: normal(:)
    real(wp) :: covariance(size(normal), size(normal)), off(size(normal)), volume
    integer :: i, j, k

    covariance = 0.0_wp
    volume = 0.0_wp
    do i = patches%first_cell(n), patches%first_cell(n + 1) - 1
      do k = patches%first_point(patches%cell(i)), patches%first_point(patches%cell(i) + 1) - 1
        associate (p => patches%point(k))
          if (all(points%material(p) /= [one%material, other%material])) cycle
          off = points%position(:, p) - merge(one%centre(:, n), other%centre(:, n), points%material(p) == one%material)
          volume = volume + points%volume(p)
          do j = 1, size(off)
            covariance(:, j) = covariance(:, j) + points%volume(p)*off(j)*off
          end do
        end associate
      end do
    end do
    covariance = covariance/volume
    do j = 1, size(normal)
      covariance(j, j) = covariance(j, j) + ridge*one%extent(j, n)**2
    end do
    normal = solved(covariance, one%centre(:, n) - other%centre(:, n))
    if (norm2(normal) > 0.0_wp) normal = normal/norm2(normal)
  end subroutine find_normal

  !> Returns the solution of a small symmetric positive definite system (Gauss).
  pure function solved(matrix, rhs) result(x)
    real(wp), intent(in) :: matrix(:, :), rhs(:)
    real(wp) :: x(size(rhs)), a(size(rhs), size(rhs))
    integer :: i, j

    a = matrix
    x = rhs
    do j = 1, size(x)
      do i = j + 1, size(x)
        x(i) = x(i) - a(i, j)/a(j, j)*x(j)
        a(i, j:) = a(i, j:) - a(i, j)/a(j, j)*a(j, j:)
      end do
    end do
    do i = size(x), 1, -1
      x(i) = (x(i) - dot_product(a(i, i + 1:), x(i + 1:)))/a(i, i)
    end do
  end function solved

  !> Finds the extent of the points of the first material along a normal, and the start of those of the second.
  pure subroutine reach_of(patches, points, n, normal, materials, reach)
    type(patches_type), intent(in) :: patches
    type(points_type), intent(in) :: points
    !> Number of the node.
    integer, intent(in) :: n
    real(wp), intent(in) :: normal(:)
    integer, intent(in) :: materials(2)
    real(wp), intent(out) :: reach(2)
    integer :: i, k

    reach = [-huge(1.0_wp), huge(1.0_wp)]
    do i = patches%first_cell(n), patches%first_cell(n + 1) - 1
      do k = patches%first_point(patches%cell(i)), patches%first_point(patches%cell(i) + 1) - 1
        associate (p => patches%point(k))
          if (points%material(p) == materials(1)) reach(1) = max(reach(1), dot_product(normal, points%position(:, p)))
          if (points%material(p) == materials(2)) reach(2) = min(reach(2), dot_product(normal, points%position(:, p)))
        end associate
      end do
    end do
  end subroutine reach_of

  !> Returns the field of a node at a place.
  pure function field_at(smooth, n, place) result(stress)
    type(smooth_stress_type), intent(in) :: smooth
    integer, intent(in) :: n
    real(wp), intent(in) :: place(:)
    real(wp) :: stress(size(smooth%field, 1)), z(most_terms)
    integer :: terms

    terms = term_count(size(place), smooth%degree(n))
    call patch_terms((place - smooth%centre(:, n))/smooth%extent(:, n), smooth%degree(n), z)
    stress = matmul(smooth%field(:, :terms, n), z(:terms))
  end function field_at

  !> Returns the stress vector on a plane.
  pure function across(stress, normal) result(vector)
    !> Components.
    real(wp), intent(in) :: stress(:)
    !> Unit normal, or area vector for the force (dimension).
    real(wp), intent(in) :: normal(:)
    real(wp) :: vector(size(normal))

    if (size(normal) == 2) then
      vector = [stress(1)*normal(1) + stress(4)*normal(2), stress(4)*normal(1) + stress(2)*normal(2)]
    else
      vector = [stress(1)*normal(1) + stress(4)*normal(2) + stress(5)*normal(3), &
        stress(4)*normal(1) + stress(2)*normal(2) + stress(6)*normal(3), &
        stress(5)*normal(1) + stress(6)*normal(2) + stress(3)*normal(3)]
    end if
  end function across
end module qsmpm_traction_jump
