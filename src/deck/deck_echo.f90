!> The echo: a complete deck of an analysis with every default spelt out. Read again it gives the
!> same analysis, bit for bit.
module qsmpm_deck_echo
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type, mesh_source_type, set_type, surface_type, body_type, history_type, &
    mesh_grid, mesh_file, mesh_inline, select_list, select_box, select_plane, select_segment, select_outline, &
    body_box, body_polygon, body_region, body_polyhedron, kinematics_jaumann, three_dimensional, quantity_stress, &
    quantity_state, quantity_reaction, diagonal_random
  use qsmpm_text, only: real_text, integer_text
  use qsmpm_deck_general, only: echo_general, echo_head
  use qsmpm_deck_materials, only: echo_material
  use qsmpm_echo_lines, only: echo_type, quoted, numbers
  use qsmpm_echo_phases, only: echo_phase
  use qsmpm_echo_point, only: echo_point
  use qsmpm_deck_words, only: diagonal_words, axis_words, tensor_words, surface_words, shape_words, &
    kinematics_words, rate_words, quantity_words, answer_words
  implicit none
  private

  public :: echo_text

contains

  !> Write an analysis as a deck.
  subroutine echo_text(analysis, text)
    !> The analysis.
    type(analysis_type), intent(in) :: analysis
    !> The deck.
    character(len=:), allocatable, intent(out) :: text
    type(echo_type) :: echo
    integer :: i, dimension

    if (analysis%point_test%given) then
      call echo_point_deck(echo, analysis)
      text = echo%text(:echo%length)
      return
    end if
    dimension = merge(3, 2, analysis%model == three_dimensional)
    call echo_general(echo, analysis)
    call echo_mesh(echo, analysis%mesh, dimension)
    do i = 1, size(analysis%node_sets)
      call echo_set(echo, 'NSET', analysis%node_sets(i), dimension)
    end do
    do i = 1, size(analysis%element_sets)
      call echo_set(echo, 'ELSET', analysis%element_sets(i), dimension)
    end do
    do i = 1, size(analysis%surfaces)
      call echo_surface(echo, analysis%surfaces(i), dimension)
    end do
    do i = 1, size(analysis%materials)
      call echo_material(echo, analysis%materials(i))
    end do
    do i = 1, size(analysis%bodies)
      call echo_body(echo, analysis%bodies(i), dimension)
    end do
    do i = 1, size(analysis%histories)
      call echo_history(echo, analysis%histories(i), dimension)
    end do
    do i = 1, size(analysis%phases)
      call echo_phase(echo, analysis%phases(i), dimension)
    end do
    text = echo%text(:echo%length)
  end subroutine echo_text

  !> A deck of a point.
  subroutine echo_point_deck(echo, analysis)
    type(echo_type), intent(inout) :: echo
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: method
    integer :: i

    call echo_head(echo, analysis)
    method = '*METHOD, KINEMATICS='//trim(kinematics_words(analysis%method%kinematics))
    if (analysis%method%kinematics == kinematics_jaumann) method = method//', RATE='// &
      trim(rate_words(analysis%method%rate))
    call echo%line(method)
    do i = 1, size(analysis%materials)
      call echo_material(echo, analysis%materials(i))
    end do
    call echo_point(echo, analysis%point_test)
  end subroutine echo_point_deck

  !> Where the mesh comes from.
  subroutine echo_mesh(echo, mesh, dimension)
    type(echo_type), intent(inout) :: echo
    type(mesh_source_type), intent(in) :: mesh
    !> 2 or 3.
    integer, intent(in) :: dimension
    integer :: i

    select case (mesh%kind)
    case (mesh_grid)
      call echo_grid(echo, mesh, dimension)
    case (mesh_file)
      call echo%line('*MESH, INPUT='//quoted(mesh%file)//', FORMAT='//mesh%format)
    case (mesh_inline)
      call echo%line('*NODE')
      do i = 1, size(mesh%node_labels)
        call echo%line(' '//integer_text(mesh%node_labels(i))//', '// &
          numbers(mesh%nodes(:dimension, i)))
      end do
      call echo%line('*ELEMENT, TYPE='//mesh%element)
      do i = 1, size(mesh%element_labels)
        call echo%list([mesh%element_labels(i), mesh%connectivity(:, i)])
      end do
    end select
  end subroutine echo_mesh

  !> A grid by its lines.
  subroutine echo_grid(echo, mesh, dimension)
    type(echo_type), intent(inout) :: echo
    type(mesh_source_type), intent(in) :: mesh
    !> 2 or 3.
    integer, intent(in) :: dimension
    character(len=:), allocatable :: text
    integer :: axis, i

    text = '*GRID, ELEMENT='//mesh%element
    if (index(mesh%element, 'TRI') == 1 .or. index(mesh%element, 'WEDGE') == 1) &
      text = text//', DIAGONAL='//trim(diagonal_words(mesh%diagonal))
    text = text//', PERTURB='//real_text(mesh%perturbation)
    if (mesh%perturbation > 0.0_wp .or. mesh%diagonal == diagonal_random) &
      text = text//', SEED='//integer_text(mesh%seed)
    text = text//', WINDOW='//trim(answer_words(merge(1, 0, mesh%windowed)))
    call echo%line(text)
    do axis = 1, dimension
      associate (lines => mesh%axes(axis)%lines)
        do i = 1, size(lines)
          text = ' '//real_text(lines(i))
          if (i == 1) text = ' '//trim(axis_words(axis))//', LINES,'//text
          if (i < size(lines)) text = text//','
          call echo%line(text)
        end do
      end associate
    end do
  end subroutine echo_grid

  !> A box as a data line.
  pure function box_line(box, dimension) result(text)
    !> Lower and upper corner (3,2).
    real(wp), intent(in) :: box(3, 2)
    !> 2 or 3.
    integer, intent(in) :: dimension
    character(len=:), allocatable :: text

    text = ' '//numbers(reshape(transpose(box(:dimension, :)), [2*dimension]))
  end function box_line

  !> A set of nodes or elements.
  subroutine echo_set(echo, keyword, set, dimension)
    type(echo_type), intent(inout) :: echo
    !> NSET or ELSET, which is also the parameter that names the set.
    character(len=*), intent(in) :: keyword
    type(set_type), intent(in) :: set
    !> 2 or 3.
    integer, intent(in) :: dimension
    character(len=:), allocatable :: text

    text = '*'//keyword//', '//keyword//'='//quoted(set%name)
    select case (set%selection)
    case (select_list)
      call echo%line(text)
      call echo%list(set%labels)
    case (select_box)
      call echo%line(text//', BOX')
      call echo%line(box_line(set%box, dimension))
    case (select_plane)
      call echo%line(text//', PLANE='//trim(axis_words(set%axis)))
      call echo%line(' '//real_text(set%box(set%axis, 1)))
    end select
  end subroutine echo_set

  !> A surface.
  subroutine echo_surface(echo, surface, dimension)
    type(echo_type), intent(inout) :: echo
    type(surface_type), intent(in) :: surface
    !> 2 or 3.
    integer, intent(in) :: dimension
    character(len=:), allocatable :: text
    integer :: i

    text = '*SURFACE, NAME='//quoted(surface%name)//', TYPE='
    select case (surface%selection)
    case (select_box)
      call echo%line(text//trim(surface_words(1)))
      call echo%line(box_line(surface%box, dimension))
    case (select_segment)
      call echo%line(text//trim(surface_words(2)))
      do i = 1, size(surface%segments, 2)
        call echo%line(' '//numbers(surface%segments(:, i)))
      end do
    case (select_outline)
      text = text//trim(surface_words(4))//', BODY='//quoted(surface%body)
      if (surface%boxed) text = text//', BOX'
      call echo%line(text)
      if (surface%boxed) call echo%line(box_line(surface%box, dimension))
    case default
      call echo%line(text//trim(surface_words(3)))
    end select
  end subroutine echo_surface

  !> A body and its points.
  subroutine echo_body(echo, body, dimension)
    type(echo_type), intent(inout) :: echo
    type(body_type), intent(in) :: body
    !> 2 or 3.
    integer, intent(in) :: dimension
    character(len=:), allocatable :: text
    integer :: i

    text = '*BODY, NAME='//quoted(body%name)//', MATERIAL='//quoted(body%material)// &
      ', SHAPE='//trim(shape_words(body%kind))
    if (body%kind == body_region) text = text//', REGION='//quoted(body%region)
    if (body%kind == body_polyhedron) text = text//', INPUT='//quoted(body%file)
    call echo%line(text)
    if (body%kind == body_box) call echo%line(box_line(body%box, dimension))
    if (body%kind == body_polygon) then
      do i = 1, size(body%polygon, 2)
        call echo%line(' '//numbers(body%polygon(:, i)))
      end do
    end if
    text = 'DEFAULT'
    if (body%points_per_element > 0) text = integer_text(body%points_per_element)
    call echo%line('*POINTS, BODY='//quoted(body%name)//', PER ELEMENT='//text)
  end subroutine echo_body

  !> A history.
  subroutine echo_history(echo, history, dimension)
    type(echo_type), intent(inout) :: echo
    type(history_type), intent(in) :: history
    !> 2 or 3.
    integer, intent(in) :: dimension
    character(len=:), allocatable :: text

    text = '*HISTORY, NAME='//quoted(history%name)//', QUANTITY='// &
      trim(quantity_words(history%quantity))
    if (history%quantity == quantity_state) then
      text = text//', STATE='//quoted(history%state)
    else if (history%quantity == quantity_stress) then
      text = text//', COMPONENT='//trim(tensor_words(history%component))
    else
      text = text//', COMPONENT='//trim(axis_words(history%component))
    end if
    text = text//', UNIT='//quoted(history%unit)//', SCALE='//real_text(history%scale)
    if (history%quantity == quantity_reaction) then
      call echo%line(text//', NSET='//quoted(history%set))
    else
      call echo%line(text)
      call echo%line(' '//numbers(history%at(:dimension)))
    end if
  end subroutine echo_history
end module qsmpm_deck_echo
