!> The pictures and results of a state with the lists that name them. Every process of a team takes part: where the
!> model is divided each writes its part, else the first one writes all.
module qsmpm_picture_files
  use qsmpm_agreement, only: agree
  use qsmpm_error, only: error_type
  use qsmpm_fields, only: phase_time
  use qsmpm_model, only: model_type
  use qsmpm_number_text, only: numbered
  use qsmpm_own_part, only: is_divided
  use qsmpm_picture_list, only: picture_list_type, add_picture, write_collection
  use qsmpm_pictures, only: write_points_picture, write_mesh_picture
  use qsmpm_results, only: write_results_index, write_state
  use qsmpm_safety_files, only: write_mechanism
  use qsmpm_stress_error, only: stress_error_type
  use qsmpm_team, only: team_type
  implicit none
  private

  public :: write_fields, write_way_of_failure

contains

  !> Write the pictures and results of a state and their lists.
  subroutine write_fields(directory, pictures, team, model, estimate, error)
    character(len=*), intent(in) :: directory
    !> So far; gains this one.
    type(picture_list_type), intent(inout) :: pictures
    !> Who shares the run.
    type(team_type), intent(in) :: team
    type(model_type), intent(in) :: model
    !> Estimated error of its stresses.
    type(stress_error_type), intent(in) :: estimate
    !> The same on all processes: a file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    logical :: leads, writes

    leads = team%rank == 0
    writes = leads .or. is_divided(model%part)
    associate (step => model%state%progress%step, output => model%analysis%output)
      call add_picture(pictures, step, phase_time(model))
      if (output%vtk .and. writes) then
        call write_points_picture(directory, 'points_'//numbered(step), model, estimate, error)
        if (.not. allocated(error)) call write_mesh_picture(directory, 'mesh_'//numbered(step), model, error)
      end if
      if (output%vtk .and. leads) then
        if (.not. allocated(error)) call write_collection(pictures, directory, 'points', error)
        if (.not. allocated(error)) call write_collection(pictures, directory, 'mesh', error)
      end if
      call agree(team, error)
      if (allocated(error) .or. .not. output%hdf5) return
      if (writes) call write_state(directory, numbered(step), model, estimate, error)
      if (leads .and. .not. allocated(error)) &
        call write_results_index(directory, pictures%steps, error, size(model%analysis%phases))
      call agree(team, error)
    end associate
  end subroutine write_fields

  !> Write pictures and results of the way a body fails.
  subroutine write_way_of_failure(directory, pictures, team, model, estimate, error)
    character(len=*), intent(in) :: directory
    type(picture_list_type), intent(in) :: pictures
    !> Who shares the run.
    type(team_type), intent(in) :: team
    type(model_type), intent(in) :: model
    !> Estimated error of its stresses.
    type(stress_error_type), intent(in) :: estimate
    !> The same on all processes: a file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error

    if (team%rank == 0 .or. is_divided(model%part)) call write_mechanism(directory, model, estimate, error)
    if (team%rank == 0 .and. .not. allocated(error) .and. model%analysis%output%hdf5 .and. allocated(pictures%steps)) &
      call write_results_index(directory, pictures%steps, error, size(model%analysis%phases))
    call agree(team, error)
  end subroutine write_way_of_failure
end module qsmpm_picture_files
