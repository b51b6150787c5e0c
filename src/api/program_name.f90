!> Which library this is, and what it was built with.
module qsmpm_program_name
  use qsmpm_version, only: version, compiler, build_type, with_suitesparse, with_openmp
  implicit none
  private

  public :: program_name, has_feature

  !> Version of the interface to C: 10000 major + 100 minor + patch. It grows with every change a caller can see.
  integer, parameter, public :: api_version = 201

contains

  !> The program's name, version and make.
  pure function program_name() result(text)
    character(len=:), allocatable :: text

    text = 'qsmpm '//version//' ('//compiler//', '//build_type//')'
  end function program_name

  !> Whether something optional is there; false for an unknown word.
  pure logical function has_feature(name)
    !> suitesparse, openmp, mumps, soil_model, umat, udsm.
    character(len=*), intent(in) :: name

    select case (name)
    case ('suitesparse')
      has_feature = with_suitesparse
    case ('openmp')
      has_feature = with_openmp
    case ('mumps', 'soil_model', 'umat', 'udsm')
      has_feature = .true.
    case default
      has_feature = .false.
    end select
  end function has_feature
end module qsmpm_program_name
