!> `curves.csv` of a point: one row per step, first line `name [unit]`, the first four columns as in every run.
!>
!> Laboratory strains are positive in compression and use the strain measure of the test; p is the mean pressure, q the
!> von Mises stress, the deviator the axial minus the lateral stress. Components are those of tensors, positive in
!> tension: the deformation gradient, the logarithmic strain ln V (engineering shear) and the Cauchy stress.
module qsmpm_point_curves
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: tensor_logarithm
  use qsmpm_law, only: law_type
  use qsmpm_point_driver, only: point_type
  use qsmpm_point_test, only: point_test_type, strain_logarithmic, test_undrained
  use qsmpm_tensor, only: pack_symmetric, gradient_row, gradient_column, gradient_size, stress_size
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: point_row_type, point_header, point_row, laboratory_type, laboratory_values

  character(len=1), parameter :: digit(3) = ['1', '2', '3']
  character(len=2), parameter :: pairs(6) = ['11', '22', '33', '12', '13', '23']

  !> Results of a step.
  type :: point_row_type
    integer :: stage = 1
    integer :: step = 0
    !> Increments of the stage so far: steps, and parts of those that were cut back.
    integer :: increments = 0
    !> Share of the stage, or number of the row of its table.
    real(wp) :: load_factor = 0.0_wp
    !> Time at the end of the step.
    real(wp) :: time = 0.0_wp
    integer :: iterations = 0
    !> Number of parts into which the step was cut.
    integer :: parts = 1
    !> Error of the tangent, negative if not computed.
    real(wp) :: tangent_error = -1.0_wp
  end type point_row_type

  !> Laboratory quantities.
  type :: laboratory_type
    real(wp) :: axial_strain = 0.0_wp
    real(wp) :: lateral_strain = 0.0_wp
    real(wp) :: volumetric_strain = 0.0_wp
    real(wp) :: shear_strain = 0.0_wp
    !> Deviatoric strain of ln V: sqrt(2/3 e:e) with its deviator e.
    real(wp) :: deviatoric_strain = 0.0_wp
    real(wp) :: p = 0.0_wp
    real(wp) :: q = 0.0_wp
    real(wp) :: deviator = 0.0_wp
    !> Logarithmic strain with tensor shear (4 or 6).
    real(wp), allocatable :: strain(:)
  end type laboratory_type

contains

  !> Returns the first line, without its newline.
  pure function point_header(test, stress_unit, law, with_tangent) result(text)
    type(point_test_type), intent(in) :: test
    character(len=*), intent(in) :: stress_unit
    !> The law, whose named state variables are written.
    class(law_type), intent(in) :: law
    !> There is a column for the error of the tangent.
    logical, intent(in) :: with_tangent
    character(len=:), allocatable :: text
    integer :: i

    text = 'phase,step,load_factor,iterations,parts,yields,time'
    if (with_tangent) text = text//',tangent_error'
    text = text//',axial_strain,lateral_strain,volumetric_strain,shear_strain,deviatoric_strain,p ['//stress_unit// &
      '],q ['//stress_unit//'],deviator ['//stress_unit//']'
    if (test%kind == test_undrained) text = text//',pore_pressure ['//stress_unit//']'
    do i = 1, gradient_size(test%dimension)
      text = text//',F'//digit(gradient_row(i, test%dimension))//digit(gradient_column(i, test%dimension))
    end do
    do i = 1, stress_size(test%dimension)
      text = text//',log_strain_'//pairs(i)
    end do
    do i = 1, stress_size(test%dimension)
      text = text//',s'//pairs(i)//' ['//stress_unit//']'
    end do
    do i = 1, law%state_count
      if (is_named(law, i)) text = text//','//law%state_names(i)%text
    end do
  end function point_header

  !> Checks whether a state variable is an output, that is, has a name.
  pure logical function is_named(law, i)
    class(law_type), intent(in) :: law
    !> Number of the variable.
    integer, intent(in) :: i

    is_named = .false.
    if (allocated(law%state_names)) is_named = len(law%state_names(i)%text) > 0
  end function is_named

  !> Returns a row, without its newline.
  pure function point_row(test, law, point, row, with_tangent) result(text)
    type(point_test_type), intent(in) :: test
    class(law_type), intent(in) :: law
    type(point_type), intent(in) :: point
    type(point_row_type), intent(in) :: row
    !> There is a column for the error of the tangent.
    logical, intent(in) :: with_tangent
    character(len=:), allocatable :: text
    type(laboratory_type) :: values
    integer :: i, d

    d = test%dimension
    values = laboratory_values(test, point)
    values%strain(4:) = 2.0_wp*values%strain(4:)
    text = integer_text(row%stage)//','//integer_text(row%step)//numbers([row%load_factor])//','// &
      integer_text(row%iterations)//','//integer_text(row%parts)//','//integer_text(merge(1, 0, point%plastic))// &
      numbers([row%time])
    if (with_tangent) text = text//numbers([row%tangent_error])
    text = text//numbers([values%axial_strain, values%lateral_strain, values%volumetric_strain, values%shear_strain, &
      values%deviatoric_strain, values%p, values%q, values%deviator])
    if (test%kind == test_undrained) text = text//numbers([test%cell_pressure + &
      0.5_wp*(point%stress(1) + point%stress(3))])
    text = text//numbers([(point%deformation(gradient_row(i, d), gradient_column(i, d)), i=1, gradient_size(d))])
    text = text//numbers(values%strain)//numbers(point%stress)
    do i = 1, law%state_count
      if (is_named(law, i)) text = text//numbers(point%state(i:i))
    end do
  end function point_row

  !> Returns the laboratory quantities of the point.
  pure type(laboratory_type) function laboratory_values(test, point) result(values)
    type(point_test_type), intent(in) :: test
    type(point_type), intent(in) :: point
    real(wp) :: left(size(point%stress)), deviator(size(point%stress))

    associate (f => point%deformation, s => point%stress)
      values%axial_strain = compression(test, f(2, 2))
      values%lateral_strain = compression(test, f(1, 1))
      values%volumetric_strain = compression(test, point%volume_ratio)
      values%shear_strain = f(1, 2)
      allocate (values%strain(size(s)))
      call pack_symmetric(matmul(f, transpose(f)), left)
      call tensor_logarithm(left, values%strain)
      values%strain = 0.5_wp*values%strain
      deviator = values%strain
      deviator(:3) = deviator(:3) - sum(deviator(:3))/3.0_wp
      values%deviatoric_strain = sqrt(2.0_wp/3.0_wp*square(deviator))
      values%p = -sum(s(:3))/3.0_wp
      deviator = s
      deviator(:3) = s(:3) + values%p
      values%q = sqrt(1.5_wp*square(deviator))
      values%deviator = 0.5_wp*(s(1) + s(3)) - s(2)
    end associate
  end function laboratory_values

  !> Returns a compressive strain in the measure of the test.
  pure real(wp) function compression(test, ratio)
    type(point_test_type), intent(in) :: test
    !> Ratio of lengths or volumes.
    real(wp), intent(in) :: ratio

    compression = 1.0_wp - ratio
    if (test%strain == strain_logarithmic) compression = -log(ratio)
  end function compression

  !> Contracts a symmetric tensor with itself.
  pure real(wp) function square(tensor)
    !> Components (4 or 6).
    real(wp), intent(in) :: tensor(:)

    square = sum(tensor(:3)**2) + 2.0_wp*sum(tensor(4:)**2)
  end function square

  !> Returns numbers that read back to the same bits, each after a comma. All digits are written, as the search for the
  !> shortest form takes longer than the whole test.
  pure function numbers(values) result(text)
    !> The numbers.
    real(wp), intent(in) :: values(:)
    character(len=:), allocatable :: text
    integer, parameter :: width = 25
    character(len=width) :: cells(size(values))
    integer :: i, length, first

    if (size(values) > 0) write (cells, '(es25.16e3)') values
    length = 0
    allocate (character(len=width*size(values)) :: text)
    do i = 1, size(values)
      if (.not. abs(values(i)) > 0.0_wp) cells(i) = repeat(' ', width - 1)//'0'
      first = verify(cells(i), ' ')
      text(length + 1:length + 1) = ','
      text(length + 2:length + 2 + width - first) = cells(i)(first:)
      length = length + 2 + width - first
    end do
    text = text(:length)
  end function numbers
end module qsmpm_point_curves
