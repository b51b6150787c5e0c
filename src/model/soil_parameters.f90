!> Parameters of the built-in soil from its description, and the cells that its softening allows.
module qsmpm_soil_parameters
  use qsmpm_kinds, only: wp
  use qsmpm_material_description, only: material_type
  use qsmpm_error, only: error_type
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_material_parameters, only: material_parameters_type, check_parameters
  use qsmpm_mesh_measure, only: cell_width
  use qsmpm_model, only: model_type
  use qsmpm_softening, only: band_ratio, nonlocal_length
  use qsmpm_softening_model, only: softening_model_type, set_softening, largest_band_ratio
  use qsmpm_team, only: largest_of_all => largest
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_undrained_parameters, only: undrained_c, undrained_ratio
  implicit none
  private

  public :: parameters_of, check_softening_cells

contains

  !> Parameters of a material; in analysis of total stress the skeleton's shear modulus with nu_u.
  pure type(material_parameters_type) function parameters_of(material) result(parameters)
    !> As described.
    type(material_type), intent(in) :: material

    parameters = material_parameters_type(young=material%young, poisson=material%poisson, &
      mohr_coulomb=material%mohr_coulomb, cohesion=material%cohesion, friction_angle=material%friction_angle, &
      dilatancy_angle=material%dilatancy_angle, tensile_strength=material%tensile_strength, &
      softening=material%softening)
    if (.not. (material%undrained%given .and. material%undrained%kind == undrained_c)) return
    parameters%poisson = undrained_ratio(material%undrained, material%poisson)
    parameters%young = material%young*(1.0_wp + parameters%poisson)/(1.0_wp + material%poisson)
  end function parameters_of

  !> Refuse cells in which a softening point would snap back without any confinement; with friction that falls,
  !> confinement lowers the bound, which the law tells when it meets it.
  subroutine check_softening_cells(model, diagnostics)
    !> The model with its points; its notes say where cells are too wide for a nonlocal strain.
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: m

    do m = 1, size(model%analysis%materials)
      associate (material => model%analysis%materials(m))
        if (material%softening%given) call check_material(model, m, material, diagnostics)
      end associate
    end do
  end subroutine check_softening_cells

  !> One softening material.
  subroutine check_material(model, number, material, diagnostics)
    type(model_type), intent(inout) :: model
    !> Number of the material, and what was said of it.
    integer, intent(in) :: number
    type(material_type), intent(in) :: material
    type(diagnostics_type), intent(inout) :: diagnostics
    type(softening_model_type) :: softening
    type(error_type), allocatable :: error
    real(wp) :: largest, bound
    integer :: p

    call check_parameters(parameters_of(material), error)
    if (allocated(error)) return
    call set_softening(parameters_of(material), softening)
    largest = 0.0_wp
    do p = 1, model%state%points%count
      if (model%state%points%material(p) == number) &
        largest = max(largest, cell_width(model%mesh, model%state%points%cell(p)))
    end do
    largest = largest_of_all(model%part%team, largest)
    if (softening%softening%nonlocal) then
      call note_wide_cells(model, softening, material%name, largest)
      if (largest <= softening%coarsest_cell) return
    end if
    bound = largest_band_ratio(softening)
    if (band_ratio(softening%softening, largest) <= bound .or. .not. largest > 0.0_wp) return
    if (softening%softening%by_cell) then
      call add_diagnostic(diagnostics, material%where, '*SOFTENING', "material '"//material%name// &
        "' softens too fast for its cells, a point would snap back: size "//rounded_text(largest, 3)//', at most '// &
        rounded_text(bound*softening%softening%length, 3))
    else
      call add_diagnostic(diagnostics, material%where, '*SOFTENING', "material '"//material%name// &
        "' softens too fast, a point would snap back: plastic shear strain at least "// &
        rounded_text(softening%softening%strain/bound, 3))
    end if
  end subroutine check_material

  !> Say where cells are too wide for a nonlocal strain, at the start and on a grid that follows.
  subroutine note_wide_cells(model, softening, name, largest)
    type(model_type), intent(inout) :: model
    type(softening_model_type), intent(in) :: softening
    !> Of the material, and its largest cell.
    character(len=*), intent(in) :: name
    real(wp), intent(in) :: largest
    character(len=:), allocatable :: start

    start = "warning: material '"//name//"': REGULARISATION=NONLOCAL of *SOFTENING, l = "// &
      rounded_text(nonlocal_length(softening%softening), 3)//', wants cells of '// &
      rounded_text(softening%coarsest_cell, 3)//' and less; '
    if (largest > softening%coarsest_cell) model%notes = model%notes//start//'in wider ones, here up to '// &
      rounded_text(largest, 3)//', strain counts by the size of the cell (CELL)'//new_line('a')
    if (.not. allocated(model%analysis%backgrounds)) return
    associate (cell => model%analysis%backgrounds(2)%cell_size)
      if (cell > softening%coarsest_cell) model%notes = model%notes//start//'on the grid that follows the '// &
        'triangles, of '//rounded_text(cell, 3)//', strain counts by the size of the cell (CELL)'//new_line('a')
    end associate
  end subroutine note_wide_cells
end module qsmpm_soil_parameters
