!> Fields of the material points that are made from those they carry: the way they have gone, and strains where the
!> deformation is carried.
module qsmpm_made_fields
  use qsmpm_kinds, only: wp
  use qsmpm_field_list, only: field_list_type, kind_number, kind_tensor, kind_vector, shown_everywhere, unit_length
  use qsmpm_points, only: points_type
  use qsmpm_strain, only: logarithmic_strain, shear_strain, volume_strain
  implicit none
  private

  public :: list_made_fields

contains

  !> Add displacement and strains; strains have no columns where none are carried.
  subroutine list_made_fields(points, list)
    type(points_type), intent(in) :: points
    type(field_list_type), intent(inout) :: list
    real(wp), allocatable :: displacement(:, :), strain(:, :), volume(:, :), shear(:, :)
    integer :: p

    allocate (displacement, source=points%position - points%initial_position)
    allocate (strain, mold=points%left_cauchy_green)
    allocate (volume(1, size(strain, 2)), shear(1, size(strain, 2)))
    do p = 1, size(strain, 2)
      strain(:, p) = logarithmic_strain(points%left_cauchy_green(:, p))
      volume(1, p) = volume_strain(strain(:, p))
      shear(1, p) = shear_strain(strain(:, p))
    end do
    call list%add_made('displacement', displacement, kind_vector, shown_everywhere, unit_length, &
      'position less initial position')
    call list%add_made('strain', strain, kind_tensor, shown_everywhere, meaning='logarithmic strain 1/2 ln b; '// &
      'shear components are engineering strains')
    call list%add_made('volume_strain', volume, kind_number, shown_everywhere, meaning='ln J, trace of the strain')
    call list%add_made('shear_strain', shear, kind_number, shown_everywhere, meaning='(2 e:e)^1/2, e the deviator '// &
      'of the strain; 3^1/2 times the triaxial eps_q')
  end subroutine list_made_fields
end module qsmpm_made_fields
