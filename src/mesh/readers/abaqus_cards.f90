!> Keyword lines of Abaqus input files: keyword, parameters, where in the assembly they stand.
!>
!> One part without transformation is read. What the assembly adds of its own (reference points,
!> connectors) is no part of the mesh; keywords that would change the mesh in ways that are not
!> followed (generation, included files, other axes) are errors, all others are passed over.
module qsmpm_abaqus_cards
  use qsmpm_error, only: error_type
  use qsmpm_text, only: string_type, upper, stripped, squeezed
  use qsmpm_text_file, only: text_file_type, unquoted, file_error
  use qsmpm_element, only: tri3, tri6, quad4, quad8, tet4, tet10, hex8, hex20, wedge6, wedge15
  implicit none
  private

  public :: abaqus_card_type, start_card

  !> The card whose data lines are being read.
  type :: abaqus_card_type
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
  end type abaqus_card_type

contains

  !> A keyword line.
  subroutine start_card(file, words, card, error)
    !> The file, for messages.
    type(text_file_type), intent(in) :: file
    !> Keyword and parameters.
    type(string_type), intent(in) :: words(:)
    !> The card before; becomes the new one.
    type(abaqus_card_type), intent(inout) :: card
    !> A keyword or element type that cannot be read.
    type(error_type), allocatable, intent(out) :: error

    card%keyword = upper(squeezed(words(1)%text))
    call read_parameters(words(2:), card)
    call follow_assembly(card)
    call check_card(file, words(2:), card, error)
    if (allocated(error)) return
    if (card%in_assembly .and. .not. card%in_instance) then
      if (card%keyword == '*NODE' .or. card%keyword == '*ELEMENT') card%keyword = ''
    end if
    if (card%keyword == '*SURFACE' .and. card%type /= '' .and. card%type /= 'ELEMENT') card%keyword = ''
    if (card%keyword /= '*ELEMENT') return
    card%kind = kind_of(card%type)
    if (card%kind == 0) call file_error(file, "element type '"//card%type//"' is not known", error)
  end subroutine start_card

  !> Parameters of a keyword line.
  pure subroutine read_parameters(words, card)
    !> Name, or name = value.
    type(string_type), intent(in) :: words(:)
    !> Gets the values.
    type(abaqus_card_type), intent(inout) :: card
    character(len=:), allocatable :: value
    integer :: i, place

    card%nset = ''
    card%elset = ''
    card%name = ''
    card%type = ''
    card%instance = ''
    card%generate = .false.
    card%set = 0
    card%pending = [integer ::]
    do i = 1, size(words)
      place = index(words(i)%text//'=', '=')
      value = unquoted(stripped(words(i)%text(min(place, len(words(i)%text)) + 1:)))
      select case (upper(stripped(words(i)%text(:place - 1))))
      case ('NSET')
        card%nset = value
      case ('ELSET')
        card%elset = value
      case ('NAME')
        card%name = value
      case ('INSTANCE')
        card%instance = value
      case ('TYPE')
        card%type = upper(value)
      case ('GENERATE')
        card%generate = .true.
      end select
    end do
  end subroutine read_parameters

  !> Keep account of where the cards stand.
  pure subroutine follow_assembly(card)
    type(abaqus_card_type), intent(inout) :: card

    select case (card%keyword)
    case ('*ASSEMBLY')
      card%in_assembly = .true.
    case ('*END ASSEMBLY')
      card%in_assembly = .false.
    case ('*INSTANCE')
      card%in_instance = .true.
    case ('*END INSTANCE')
      card%in_instance = .false.
    end select
  end subroutine follow_assembly

  !> Refuse cards that change the mesh in ways that are not followed, and cards without their names.
  subroutine check_card(file, words, card, error)
    !> The file, for messages.
    type(text_file_type), intent(in) :: file
    !> Parameters.
    type(string_type), intent(in) :: words(:)
    type(abaqus_card_type), intent(in) :: card
    !> Set when it is refused.
    type(error_type), allocatable, intent(out) :: error
    integer :: i

    select case (card%keyword)
    case ('*INCLUDE', '*NGEN', '*NFILL', '*NCOPY', '*NMAP', '*ELGEN', '*ELCOPY', '*SYSTEM')
      call file_error(file, card%keyword//' is not followed; write nodes and elements out', error)
    case ('*NODE', '*ELEMENT')
      do i = 1, size(words)
        if (upper(words(i)%text) == 'SYSTEM=R') cycle
        if (index(upper(words(i)%text), 'SYSTEM') /= 1 .and. index(upper(words(i)%text), 'INPUT') /= 1) cycle
        call file_error(file, "'"//words(i)%text//"' is not followed; write the mesh out", error)
      end do
    case ('*NSET')
      if (len(card%nset) == 0) call file_error(file, '*NSET needs NSET=name', error)
    case ('*ELSET')
      if (len(card%elset) == 0) call file_error(file, '*ELSET needs ELSET=name', error)
    case ('*SURFACE')
      if (len(card%name) == 0) call file_error(file, '*SURFACE needs NAME=name', error)
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
