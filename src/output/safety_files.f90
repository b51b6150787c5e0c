!> Files of safety phases: `safety.json` with the factors found so far, and pictures of the way the body fails.
module qsmpm_safety_files
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: geometry_fixed
  use qsmpm_error, only: error_type
  use qsmpm_file, only: write_text
  use qsmpm_model, only: model_type
  use qsmpm_number_text, only: integer_text, newline, numbered, real_text
  use qsmpm_pictures, only: write_points_picture, write_mesh_picture
  use qsmpm_results, only: mechanism_part, write_state
  use qsmpm_strength_factor, only: flow_words
  use qsmpm_stress_error, only: stress_error_type
  implicit none
  private

  public :: write_safety, write_mechanism

  character(len=*), parameter, public :: safety_file = 'safety.json'
  !> Heads of the names of the pictures; the number of the phase follows.
  character(len=*), parameter, public :: mechanism_points = 'mechanism_points_', mechanism_mesh = 'mechanism_mesh_'

contains

  !> Write the factors of safety found so far.
  subroutine write_safety(directory, model, error)
    character(len=*), intent(in) :: directory
    type(model_type), intent(in) :: model
    !> Set when the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: text
    integer :: i

    text = '{'//newline//'  "phases": ['
    associate (factors => model%state%progress%factors)
      do i = 1, size(factors, 2)
        if (i > 1) text = text//','
        text = text//newline//'    '//factor_json(model, factors(:, i))
      end do
    end associate
    call write_text(directory//'/'//safety_file, text//newline//'  ]'//newline//'}'//newline, error)
  end subroutine write_safety

  !> Factor of safety of a phase; one at which no equilibrium was found and no mechanism seen is refused, not lost.
  pure function factor_json(model, row) result(text)
    type(model_type), intent(in) :: model
    !> Of qsmpm_safety_factors.
    real(wp), intent(in) :: row(:)
    character(len=:), allocatable :: text

    associate (phase => model%analysis%phases(nint(row(1))), number => nint(row(1)), stable => row(2), lost => row(3))
      text = '{"phase": "'//phase%name//'", "number": '//integer_text(number)//', "flow": "'// &
        trim(flow_words(phase%safety%flow))//'", "geometry": "'// &
        trim(merge('FIXED ', 'MOVING', phase%safety%geometry == geometry_fixed))//'", "stable": '//real_text(stable)// &
        ', "lost": '
      if (row(4) > 0.0_wp) then
        text = text//real_text(lost)//', "mechanism": true}'
      else
        text = text//'null, "mechanism": false'
        if (lost > 0.0_wp) text = text//', "refused": '//real_text(lost)
        text = text//'}'
      end if
    end associate
  end function factor_json

  !> Write the pictures and results of a mechanism.
  subroutine write_mechanism(directory, model, estimate, error)
    character(len=*), intent(in) :: directory
    type(model_type), intent(in) :: model
    !> Estimated error of its stresses.
    type(stress_error_type), intent(in) :: estimate
    !> Set when a file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: number

    number = numbered(model%state%progress%phase)
    if (model%analysis%output%vtk) then
      call write_points_picture(directory, mechanism_points//number, model, estimate, error)
      if (.not. allocated(error)) call write_mesh_picture(directory, mechanism_mesh//number, model, error)
    end if
    if (model%analysis%output%hdf5 .and. .not. allocated(error)) &
      call write_state(directory, mechanism_part//number, model, estimate, error)
  end subroutine write_mechanism
end module qsmpm_safety_files
