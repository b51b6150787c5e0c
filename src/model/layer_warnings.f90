!> What is to be said of layers before a run: interfaces that lines of the grid do not follow, and bodies that are thin
!> for their cells: weak ones, and stiff ones that bend, which are refused. Figures: docs/methods/bodies.md, "Layers".
module qsmpm_layer_warnings
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: body_materials
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_description, only: body_box, body_polygon
  use qsmpm_mesh_description, only: mesh_grid, mesh_fitted
  use qsmpm_method_description, only: basis_fem
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_layer_interfaces, only: fewest_cells, find_interfaces, interface_type, is_weak, measure_body
  use qsmpm_material_traits, only: may_yield
  use qsmpm_model, only: model_type
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_team, only: total
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: layer_notes, check_bending

  !> Stress that is off by this share of it in cut cells is told: the limit of the scatter of a run.
  real(wp), parameter :: most_off = 0.13_wp
  !> A body this much stiffer than all it touches bends by itself. Material points whose standard deviation is below
  !> this share of its thickness are one row across it; two rows have a quarter. One so many times as long as it is
  !> thick bends.
  real(wp), parameter :: bends = 10.0_wp, one_row = 0.1_wp, slender = 3.0_wp

contains

  !> Sentences for the log.
  pure function layer_notes(analysis) result(notes)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: notes
    type(interface_type), allocatable :: found(:)
    integer :: i, k
    logical, allocatable :: told(:)

    notes = ''
    call find_interfaces(analysis, found, contacts=.true.)
    if (size(found) == 0) return
    allocate (told(size(analysis%bodies)), source=.false.)
    do i = 1, size(found)
      if (found(i)%axis == 0 .and. analysis%mesh%kind /= mesh_fitted) notes = notes//cut_text(analysis, found(i))
      do k = 1, 2
        associate (body => found(i)%bodies(k), other => found(i)%bodies(3 - k))
          if (told(body) .or. .not. is_weak(analysis, found, body, other)) cycle
          told(body) = .true.
          notes = notes//thin_text(analysis, body, any(found%axis == 0 .and. any_body(found, body)))
        end associate
      end do
    end do
  end function layer_notes

  !> Which interfaces are those of a body.
  elemental logical function any_body(found, body)
    type(interface_type), intent(in) :: found
    integer, intent(in) :: body

    any_body = any(found%bodies == body)
  end function any_body

  !> Refuse bodies of the grid that bend and are one material point thick: what a step leaves in them has no moment, and
  !> the next one bends them anew.
  subroutine check_bending(model, diagnostics)
    !> The model with its points.
    type(model_type), intent(in) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    type(interface_type), allocatable :: found(:)
    real(wp) :: normal(3), thick, long, cell, sums(0:2), along(model%state%points%count)
    integer :: number(size(model%analysis%bodies)), b

    if (model%analysis%mesh%kind /= mesh_grid .or. model%analysis%method%basis == basis_fem) return
    call find_interfaces(model%analysis, found, contacts=.true.)
    number = body_materials(model%analysis, 0)
    associate (points => model%state%points, bodies => model%analysis%bodies)
      do b = 1, size(bodies)
        if (number(b) == 0 .or. .not. any(bodies(b)%kind == [body_box, body_polygon])) cycle
        if (may_yield(model%analysis%materials(number(b))) .or. is_held(b)) cycle
        call measure_body(model%analysis, bodies(b), thick, long, cell, normal)
        if (.not. (thick < cell .and. long >= slender*thick)) cycle
        along = matmul(normal(:size(points%position, 1)), points%position(:, :points%count))
        associate (volume => merge(points%volume(:points%count), 0.0_wp, points%body(:points%count) == b))
          sums = total(model%part%team, [sum(volume), sum(volume*along), 0.0_wp])
          if (.not. sums(0) > 0.0_wp) cycle
          sums(2) = total(model%part%team, sum(volume*(along - sums(1)/sums(0))**2))
        end associate
        if (sqrt(sums(2)/sums(0)) < one_row*thick) call add_diagnostic(diagnostics, bodies(b)%where, '*BODY, NAME='// &
          bodies(b)%name, rounded_text(thick/cell)//' cells and one row of material points thick, which keeps no '// &
          'bending moment: it would bend anew in every step (after four by four times what is right); cells of '// &
          rounded_text(thick)//' or smaller across it, or a *GRID that names no ELEMENT and fits it')
      end do
    end associate
  contains
    !> Whether what a body touches is nearly as stiff as it is, or more.
    pure logical function is_held(body)
      integer, intent(in) :: body
      integer :: i, other

      is_held = .false.
      do i = 1, size(found)
        if (.not. any_body(found(i), body)) cycle
        other = number(sum(found(i)%bodies) - body)
        if (other > 0) is_held = is_held .or. model%analysis%materials(number(body))%young < &
          bends*model%analysis%materials(other)%young
      end do
    end function is_held
  end subroutine check_bending

  !> What an interface within cells does. Cells strain as one: of a stiff part f the stress is r/(f r + 1 - f) of what
  !> it should be, with f = 1/2 as said.
  pure function cut_text(analysis, between) result(text)
    type(analysis_type), intent(in) :: analysis
    type(interface_type), intent(in) :: between
    character(len=:), allocatable :: text
    real(wp) :: off

    text = ''
    off = (between%ratio - 1.0_wp)/(between%ratio + 1.0_wp)
    if (off <= most_off) return
    associate (bodies => analysis%bodies(between%bodies))
      text = "warning: bodies '"//bodies(1)%name//"' and '"//bodies(2)%name//"' meet within cells, the one "// &
        rounded_text(between%ratio)//' times as stiff as the other: stresses in the cells that hold both are '// &
        'off by '//integer_text(nint(100.0_wp*off))//' % and more; let lines of the grid, or sides of a mesh, '// &
        'follow their interface'//new_line('a')
    end associate
  end function cut_text

  !> What a weak body of few cells does.
  pure function thin_text(analysis, b, cuts) result(text)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: b
    !> Whether it meets another one within cells.
    logical, intent(in) :: cuts
    character(len=:), allocatable :: text, figures
    real(wp) :: thick, long, cell, normal(3)

    text = ''
    figures = 'by 24, 10 and 4 % along a weak seam of one, two and three cells'
    if (analysis%mesh%kind == mesh_fitted) then
      figures = 'by 2 % along a weak seam of one cell that triangles follow'
    else if (cuts) then
      figures = 'by 56 and 22 % along a weak seam of one and two cells that lies across them'
    end if
    call measure_body(analysis, analysis%bodies(b), thick, long, cell, normal)
    if (.not. thick < (1.0_wp - 1.0e-6_wp)*fewest_cells*cell) return
    text = "warning: body '"//analysis%bodies(b)%name//"' is weaker than what it touches and "// &
      rounded_text(thick/cell)//' cells thick: failure along it is held up by the cells beside it, and limit loads '// &
      'and factors of safety come out too high ('//figures//'); '// &
      'cells of '//rounded_text(thick/fewest_cells)//' or smaller across it are needed'//new_line('a')
  end function thin_text
end module qsmpm_layer_warnings
