!> The words of the deck for the enumerations of the analysis: one list each, in the order of the
!> parameters of the descriptions in src/problem, used for reading, for the deck reference and for the echo.
module qsmpm_deck_words
  use qsmpm_element_kinds, only: elements, element_kind_count
  implicit none
  private

  public :: bar_list, position_of

  integer, parameter :: n = 16
  character(len=n), parameter, public :: model_words(4) = [character(len=n) :: &
    'PLANE STRAIN', 'AXISYMMETRIC', '3D', 'AUTO']
  !> From 0.
  character(len=n), parameter, public :: mirror_words(0:2) = [character(len=n) :: 'AUTO', 'YES', 'NO']
  character(len=n), parameter, public :: diagonal_words(4) = [character(len=n) :: &
    'RIGHT', 'LEFT', 'RANDOM', 'ALTERNATE']
  character(len=n), parameter, public :: element_words(element_kind_count) = elements%name
  character(len=n), parameter, public :: format_words(2) = [character(len=n) :: 'GMSH', 'ABAQUS']
  character(len=n), parameter, public :: axis_words(3) = [character(len=n) :: 'X', 'Y', 'Z']
  character(len=n), parameter, public :: load_words(4) = [character(len=n) :: 'X', 'Y', 'Z', 'MZ']
  character(len=n), parameter, public :: tensor_words(6) = [character(len=n) :: 'XX', 'YY', 'ZZ', 'XY', 'XZ', 'YZ']
  character(len=n), parameter, public :: surface_words(4) = [character(len=n) :: 'BOX', 'SEGMENT', 'MESH', 'OUTLINE']
  character(len=n), parameter, public :: shape_words(5) = [character(len=n) :: &
    'ALL', 'BOX', 'POLYGON', 'REGION', 'POLYHEDRON']
  character(len=n), parameter, public :: patch_words(2) = [character(len=n) :: 'CELL', 'POINT']
  character(len=n), parameter, public :: rigid_words(6) = [character(len=n) :: &
    'PLANE', 'CIRCLE', 'BOX', 'CONE', 'POLYGON', 'CYLINDER']
  character(len=n), parameter, public :: contact_words(2) = [character(len=n) :: 'SOIL', 'BODY']
  character(len=n), parameter, public :: integration_words(2) = [character(len=n) :: 'POINTS', 'CELL']
  character(len=n), parameter, public :: kinematics_words(2) = [character(len=n) :: 'JAUMANN', 'LOGARITHMIC']
  character(len=n), parameter, public :: rate_words(2) = [character(len=n) :: 'PAPER', 'MIDPOINT']
  !> From 0.
  character(len=n), parameter, public :: stabilisation_words(0:2) = [character(len=n) :: &
    'NONE', 'BACKGROUND', 'GHOST']
  character(len=n), parameter, public :: interface_words(2) = [character(len=n) :: 'UMAT', 'UDSM']
  !> From 0.
  character(len=n), parameter, public :: model_tangent_words(0:3) = [character(len=n) :: &
    'AUTO', 'CONSISTENT', 'ELASTIC', 'NUMERICAL']
  character(len=n), parameter, public :: phase_words(2) = [character(len=n) :: 'LOADING', 'SAFETY']
  character(len=n), parameter, public :: geometry_words(2) = [character(len=n) :: 'FIXED', 'MOVING']
  !> From 0.
  character(len=n), parameter, public :: initial_words(0:3) = [character(len=n) :: 'KEEP', 'K0', 'ISOTROPIC', 'GIVEN']
  !> From 0.
  character(len=n), parameter, public :: support_words(0:2) = [character(len=n) :: 'FREE', 'NORMAL', 'ALL']
  character(len=n), parameter, public :: carrier_words(2) = [character(len=n) :: 'SURFACE', 'POINTS']
  character(len=n), parameter, public :: fill_words(2) = [character(len=n) :: 'LEVEL', 'SHAPE']
  character(len=n), parameter, public :: side_words(2) = [character(len=n) :: 'ABOVE', 'BELOW']
  character(len=18), parameter, public :: test_words(7) = [character(len=18) :: &
    'OEDOMETER', 'TRIAXIAL DRAINED', 'TRIAXIAL UNDRAINED', 'BIAXIAL', 'SIMPLE SHEAR', 'ISOTROPIC', 'PATH']
  character(len=n), parameter, public :: strain_words(2) = [character(len=n) :: 'ENGINEERING', 'LOGARITHMIC']

contains

  !> Words with bars between them, as the keyword table wants them.
  pure function bar_list(words) result(text)
    character(len=*), intent(in) :: words(:)
    character(len=:), allocatable :: text
    integer :: i

    text = trim(words(1))
    do i = 2, size(words)
      text = text//'|'//trim(words(i))
    end do
  end function bar_list

  !> Position of a word in a list from 1, 0 when it is not there.
  pure integer function position_of(word, words) result(position)
    character(len=*), intent(in) :: word, words(:)

    position = findloc(words, word, dim=1)
  end function position_of
end module qsmpm_deck_words
