!> Strains of the material points, carried where results ask for them (*FIELD, STRAIN): every step deforms the left
!> Cauchy-Green tensor of a point by the deformation gradient that its law has seen, so that strain, volume and stress
!> belong together under any treatment of volumetric locking; and adds the plastic shear strain of the step
!> (qsmpm_strain). A law that tells which points yield adds nothing elsewhere.
module qsmpm_point_strain
  use qsmpm_group_evaluation, only: results_type
  use qsmpm_law, only: law_slot_type
  use qsmpm_points, only: points_type
  use qsmpm_strain, only: deform, plastic_shear_increment
  implicit none
  private

  public :: add_strains

  !> Points from which the strains of a step, some 0.3 microseconds each, are worth waking the threads.
  integer, parameter :: fewest_points = 2000

contains

  !> Add the strains of a step, before the points take its stresses.
  subroutine add_strains(results, source, laws, points)
    !> What the laws said, with the deformation gradients of the step.
    type(results_type), intent(in) :: results
    !> Material point behind each result (n).
    integer, intent(in) :: source(:)
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    type(points_type), intent(inout) :: points
    integer :: p, q

    !$omp parallel do default(shared) private(p) if (size(source) >= fewest_points)
    do q = 1, size(source)
      p = source(q)
      call deform(results%gradient(:, q), points%left_cauchy_green(:, p))
      associate (law => laws(points%material(p))%law)
        if (law%tells_yield .and. results%plastic(q) == 0) cycle
        points%plastic_strain(p) = points%plastic_strain(p) + plastic_shear_increment(results%gradient(:, q), &
          points%stress(:, p), results%stress(:, q), law%shear_compliance(points%stress(:, p), &
          points%state(:law%state_count, p), points%volume(p)/points%initial_volume(p), results%volume_change(q)))
      end associate
    end do
    !$omp end parallel do
  end subroutine add_strains
end module qsmpm_point_strain
