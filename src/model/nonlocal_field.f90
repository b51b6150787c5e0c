!> Recomputes nodal values of the nonlocal strain (qsmpm_nonlocal_strain) after a change of the mesh: means of the
!> values at the material points, from which the iterations of the next step start.
module qsmpm_nonlocal_field
  use qsmpm_kinds, only: wp
  use qsmpm_kept_arrays, only: is_kept, keep_values
  use qsmpm_model, only: model_type
  use qsmpm_space, only: functions_at, shape_values_type
  implicit none
  private

  public :: gather_field

  !> Name of the nodal field.
  character(len=*), parameter, public :: nonlocal_field = 'nonlocal strain'

contains

  !> Computes sum |N| V kbar / sum |N| V at every node, 0 where no point of a nonlocal law is near.
  subroutine gather_field(model)
    type(model_type), intent(inout) :: model
    type(shape_values_type) :: place
    real(wp) :: values(1, model%space%node_count), volumes(model%space%node_count), weight
    integer :: p, a

    if (.not. is_kept(model%state%kept, nonlocal_field)) return
    values = 0.0_wp
    volumes = 0.0_wp
    associate (points => model%state%points)
      do p = 1, points%count
        associate (law => model%laws(points%material(p))%law)
          if (.not. law%field_length > 0.0_wp) cycle
          call functions_at(model%space, model%mesh, points%cell(p), points%local(:, p), place)
          do a = 1, place%count
            weight = abs(place%shape(a))*points%volume(p)
            volumes(place%node(a)) = volumes(place%node(a)) + weight
            values(1, place%node(a)) = values(1, place%node(a)) + weight*points%state(law%state_count, p)
          end do
        end associate
      end do
    end associate
    where (volumes > 0.0_wp) values(1, :) = values(1, :)/volumes
    call keep_values(model%state%kept, nonlocal_field, values)
  end subroutine gather_field
end module qsmpm_nonlocal_field
