!> Fields of the material points that are made from those they carry: the way they have gone, strains where the
!> deformation is carried, and the total stress where pore pressures are.
module qsmpm_made_fields
  use qsmpm_kinds, only: wp
  use qsmpm_field_list, only: field_list_type, kind_number, kind_tensor, kind_vector, shown_everywhere, unit_length, &
    unit_stress
  use qsmpm_points, only: points_type, carries_water
  use qsmpm_isotropic_function, only: logarithmic_strain, shear_strain, volume_strain
  implicit none
  private

  public :: list_made_fields

contains

  !> Add displacement, strains and total stress; what is not carried has no columns.
  subroutine list_made_fields(points, list)
    type(points_type), intent(in) :: points
    type(field_list_type), intent(inout) :: list
    real(wp), allocatable :: displacement(:, :), strain(:, :), volume(:, :), shear(:, :), total(:, :)
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
    allocate (total(size(points%stress, 1), merge(points%count, 0, carries_water(points))))
    do p = 1, size(total, 2)
      total(:, p) = points%stress(:, p)
      total(1:3, p) = total(1:3, p) - points%steady_pore_pressure(p)
    end do
    call list%add_made('total_stress', total, kind_tensor, shown_everywhere, unit_stress, &
      'stress of soil and water together, tension positive')
  end subroutine list_made_fields
end module qsmpm_made_fields
