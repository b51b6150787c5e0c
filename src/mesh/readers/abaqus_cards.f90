!> Keyword lines of Abaqus input files: keyword, parameters, where in the assembly they stand.
!>
!> One part without transformation is read. What the assembly adds of its own (reference points,
!> connectors) is no part of the mesh; keywords that would change the mesh in ways that are not
!> followed (generation, included files, other axes) are errors, all others are passed over.
module qsmpm_abaqus_cards
  use qsmpm_text, only: string_type, upper, stripped, squeezed
  use qsmpm_raw_mesh, only: raw_mesh_type
  use qsmpm_text_file, only: unquoted, file_error
  use qsmpm_element, only: tri3, tri6, quad4, quad8, tet4, tet10, hex8, hex20, wedge6, wedge15
  implicit none
  private

  public :: abaqus_file_type, start_card

  !> The file, the raw mesh that it becomes, and the card whose data lines are being read.
  type, extends(raw_mesh_type) :: abaqus_file_type
    !> Words of the line.
    type(string_type), allocatable :: words(:)
    !> Keyword in capitals with its star; empty before the first and where data are passed over.
    character(len=:), allocatable :: keyword
    !> Values of the parameters, empty when they are not given.
    character(len=:), allocatable :: nset, elset, name, type, instance
    logical :: generate = .false.
    !> Within *ASSEMBLY, within *INSTANCE.
    logical :: in_assembly = .false., in_instance = .false.
    !> Element kind of *ELEMENT.
    integer :: kind = 0
    !> Place of the set the data go to, 0 for none.
    integer :: set = 0
    !> Element that runs over several lines: label and nodes so far, and its first line.
    integer, allocatable :: pending(:)
    integer :: pending_line = 0
  end type abaqus_file_type

contains

  !> A keyword line: the words are keyword and parameters. A keyword or element type that cannot be read is an error.
  subroutine start_card(file)
    type(abaqus_file_type), intent(inout) :: file

    file%keyword = upper(squeezed(file%words(1)%text))
    call read_parameters(file)
    call follow_assembly(file)
    call check_card(file)
    if (file%in_assembly .and. .not. file%in_instance) then
      if (file%keyword == '*NODE' .or. file%keyword == '*ELEMENT') file%keyword = ''
    end if
    if (file%keyword == '*SURFACE' .and. file%type /= '' .and. file%type /= 'ELEMENT') file%keyword = ''
    if (file%keyword /= '*ELEMENT') return
    file%kind = kind_of(file%type)
    if (file%kind == 0) call file_error(file, "element type '"//file%type//"' is not known")
  end subroutine start_card

  !> Parameters of a keyword line, name or name = value.
  pure subroutine read_parameters(file)
    type(abaqus_file_type), intent(inout) :: file
    character(len=:), allocatable :: value
    integer :: i, place

    file%nset = ''
    file%elset = ''
    file%name = ''
    file%type = ''
    file%instance = ''
    file%generate = .false.
    file%set = 0
    file%pending = [integer ::]
    do i = 2, size(file%words)
      associate (word => file%words(i)%text)
        place = index(word//'=', '=')
        value = unquoted(stripped(word(min(place, len(word)) + 1:)))
        select case (upper(stripped(word(:place - 1))))
        case ('NSET')
          file%nset = value
        case ('ELSET')
          file%elset = value
        case ('NAME')
          file%name = value
        case ('INSTANCE')
          file%instance = value
        case ('TYPE')
          file%type = upper(value)
        case ('GENERATE')
          file%generate = .true.
        end select
      end associate
    end do
  end subroutine read_parameters

  !> Keep account of where the cards stand.
  pure subroutine follow_assembly(file)
    type(abaqus_file_type), intent(inout) :: file

    select case (file%keyword)
    case ('*ASSEMBLY')
      file%in_assembly = .true.
    case ('*END ASSEMBLY')
      file%in_assembly = .false.
    case ('*INSTANCE')
      file%in_instance = .true.
    case ('*END INSTANCE')
      file%in_instance = .false.
    end select
  end subroutine follow_assembly

  !> Refuse cards that change the mesh in ways that are not followed, and cards without their names.
  subroutine check_card(file)
    type(abaqus_file_type), intent(inout) :: file
    character(len=:), allocatable :: word
    integer :: i

    select case (file%keyword)
    case ('*INCLUDE', '*NGEN', '*NFILL', '*NCOPY', '*NMAP', '*ELGEN', '*ELCOPY', '*SYSTEM')
      call file_error(file, file%keyword//' is not followed; write nodes and elements out')
    case ('*NODE', '*ELEMENT')
      do i = 2, size(file%words)
        word = upper(file%words(i)%text)
        if (word == 'SYSTEM=R' .or. (index(word, 'SYSTEM') /= 1 .and. index(word, 'INPUT') /= 1)) cycle
        call file_error(file, "'"//file%words(i)%text//"' is not followed; write the mesh out")
      end do
    case ('*NSET')
      if (len(file%nset) == 0) call file_error(file, '*NSET needs NSET=name')
    case ('*ELSET')
      if (len(file%elset) == 0) call file_error(file, '*ELSET needs ELSET=name')
    case ('*SURFACE')
      if (len(file%name) == 0) call file_error(file, '*SURFACE needs NAME=name')
    end select
  end subroutine check_card

  !> Element kind of an Abaqus name, 0 when it has none here. Letters behind the number of nodes
  !> tell of reduced integration, hybrid formulation and the like, not of the shape.
  pure integer function kind_of(name) result(kind)
    !> Name in capitals.
    character(len=*), intent(in) :: name

    select case (name(:verify(name, 'RHITMP', back=.true.)))
    case ('CPE3', 'CPS3', 'CAX3')
      kind = tri3
    case ('CPE6', 'CPS6', 'CAX6')
      kind = tri6
    case ('CPE4', 'CPS4', 'CAX4')
      kind = quad4
    case ('CPE8', 'CPS8', 'CAX8')
      kind = quad8
    case ('C3D4')
      kind = tet4
    case ('C3D10')
      kind = tet10
    case ('C3D8')
      kind = hex8
    case ('C3D20')
      kind = hex20
    case ('C3D6')
      kind = wedge6
    case ('C3D15')
      kind = wedge15
    case default
      kind = 0
    end select
  end function kind_of
end module qsmpm_abaqus_cards
