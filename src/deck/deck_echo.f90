!> The echo: a complete deck of an analysis with every default spelt out. Read again it gives the
!> same analysis, bit for bit.
module qsmpm_deck_echo
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type, mesh_source_type, set_type, surface_type, body_type, &
    material_type, history_type, mesh_grid, mesh_file, mesh_inline, select_list, select_box, &
    select_plane, select_segment, select_outline, body_box, body_polygon, body_region, &
    body_polyhedron, basis_fem, &
    kinematics_jaumann, stabilise_none, cure_none, three_dimensional, quantity_stress, quantity_state, &
    quantity_reaction, diagonal_random
  use qsmpm_text, only: real_text, integer_text
  use qsmpm_deck_hardening, only: echo_hardening
  use qsmpm_echo_lines, only: echo_type, quoted, numbers
  use qsmpm_echo_phases, only: echo_phase
  use qsmpm_deck_user_material, only: echo_user_material
  use qsmpm_echo_point, only: echo_point
  use qsmpm_deck_words, only: model_words, mirror_words, diagonal_words, axis_words, tensor_words, &
    surface_words, shape_words, basis_words, integration_words, kinematics_words, rate_words, stress_rate_words, &
    stabilisation_words, solver_words, precision_words, keep_words, quantity_words, answer_words, cure_words, &
    softening_words, regularisation_words
  use qsmpm_softening_parameters, only: regularise_cell
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

  !> Heading and units.
  subroutine echo_head(echo, analysis)
    type(echo_type), intent(inout) :: echo
    type(analysis_type), intent(in) :: analysis

    if (len(analysis%heading) > 0) then
      call echo%line('*HEADING')
      call echo%line(analysis%heading)
    end if
    call echo%line('*UNITS, LENGTH='//quoted(analysis%length_unit)//', FORCE='// &
      quoted(analysis%force_unit))
  end subroutine echo_head

  !> Cards of the analysis as a whole.
  subroutine echo_general(echo, analysis)
    type(echo_type), intent(inout) :: echo
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: method

    call echo_head(echo, analysis)
    if (analysis%reduce) then
      call echo%line('*MODEL, TYPE='//trim(model_words(4))//', MIRROR='//trim(mirror_words(analysis%mirror)))
    else
      call echo%line('*MODEL, TYPE='//trim(model_words(analysis%model)))
    end if
    associate (m => analysis%method)
      method = '*METHOD, BASIS='//trim(basis_words(m%basis))
      if (m%basis /= basis_fem) method = method//', INTEGRATION='// &
        trim(integration_words(m%integration))
      method = method//', KINEMATICS='//trim(kinematics_words(m%kinematics))
      if (m%kinematics == kinematics_jaumann) method = method//', RATE='//trim(rate_words(m%rate))// &
        ', STRESS RATE='//trim(stress_rate_words(m%stress_rate))
      if (m%basis /= basis_fem) method = method//', STABILISATION='// &
        trim(stabilisation_words(m%stabilisation))
      if (m%stabilisation /= stabilise_none) method = method//', FACTOR='// &
        real_text(m%stabilisation_factor)
    end associate
    call echo%line(method)
    call echo%line('*SOLVER, TYPE='//trim(solver_words(analysis%solver%kind))//', PRECISION='// &
      trim(precision_words(analysis%solver%precision))//', KEEP FACTOR='// &
      trim(keep_words(analysis%solver%keep_factor)))
    if (analysis%moving_mesh%active) call echo%line('*MOVING MESH, NSET='// &
      quoted(analysis%moving_mesh%set)//', AXIS='//trim(axis_words(analysis%moving_mesh%axis))// &
      ', BASE='//real_text(analysis%moving_mesh%base))
    call echo%line('*FIELD, EVERY='//integer_text(analysis%output%field_every)// &
      ', VTK='//trim(answer_words(merge(1, 0, analysis%output%vtk)))// &
      ', HDF5='//trim(answer_words(merge(1, 0, analysis%output%hdf5)))// &
      ', STRAIN='//trim(answer_words(merge(1, 0, analysis%output%strains))))
    call echo%line('*RESTART, EVERY='//integer_text(analysis%output%restart_every))
  end subroutine echo_general

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

  !> A material and its properties.
  subroutine echo_material(echo, material)
    type(echo_type), intent(inout) :: echo
    type(material_type), intent(in) :: material
    character(len=:), allocatable :: tensile, cure

    call echo%line('*MATERIAL, NAME='//quoted(material%name))
    if (material%young > 0.0_wp) then
      call echo%line('*ELASTIC')
      call echo%line(' '//numbers([material%young, material%poisson]))
    end if
    call echo_hardening(echo, material)
    if (material%user%given) call echo_user_material(echo, material)
    call echo%line('*UNIT WEIGHT')
    call echo%line(' '//real_text(material%unit_weight))
    if (material%k0 > 0.0_wp) call echo%line('*K0')
    if (material%k0 > 0.0_wp) call echo%line(' '//real_text(material%k0))
    cure = '*VOLUMETRIC LOCKING, TYPE='//trim(cure_words(material%cure))
    if (material%cure /= cure_none .and. material%cure_factor > 0.0_wp) &
      cure = cure//', FACTOR='//real_text(material%cure_factor)
    call echo%line(cure)
    if (.not. material%mohr_coulomb) return
    tensile = 'NONE'
    if (material%tensile_strength < huge(1.0_wp)) tensile = real_text(material%tensile_strength)
    call echo%line('*MOHR COULOMB')
    call echo%line(' '//numbers([material%cohesion, material%friction_angle, &
      material%dilatancy_angle])//', '//tensile)
    if (material%softening%given) call echo_softening(echo, material)
  end subroutine echo_material

  !> How the strength of a material falls.
  subroutine echo_softening(echo, material)
    type(echo_type), intent(inout) :: echo
    type(material_type), intent(in) :: material
    character(len=:), allocatable :: length

    associate (softening => material%softening)
      length = ''
      if (softening%regularisation == regularise_cell) length = ', LENGTH='//real_text(softening%length)
      call echo%line('*SOFTENING, TYPE='//trim(softening_words(softening%shape))//', REGULARISATION='// &
        trim(regularisation_words(softening%regularisation))//length)
      call echo%line(' '//numbers([softening%cohesion, softening%friction_angle, softening%dilatancy_angle, &
        softening%strain]))
    end associate
  end subroutine echo_softening

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
