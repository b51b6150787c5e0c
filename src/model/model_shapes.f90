!> Bounds of the bodies of a deck, as the seeding of points and of surfaces wants them.
module qsmpm_model_shapes
  use, intrinsic :: iso_fortran_env, only: real32
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_error, only: error_type
  use qsmpm_analysis, only: three_dimensional
  use qsmpm_body_description, only: body_type, body_box, body_polygon, body_region, body_polyhedron
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_mesh_description, only: mesh_fitted
  use qsmpm_method_description, only: basis_fem
  use qsmpm_model, only: model_type
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_polyhedron, only: make_polyhedron
  use qsmpm_polyhedron_check, only: polyhedron_problem
  use qsmpm_stl_reader, only: read_stl
  implicit none
  private

  public :: shape_of

  !> Share of a cell that fits outlines by which it may miss a body that holds it.
  real(wp), parameter :: moved = 0.4_wp

contains

  !> Bounds of a body as the seeding wants them.
  type(body_shape_type) function shape_of(model, body, diagnostics) result(shape)
    type(model_type), intent(in) :: model
    type(body_type), intent(in) :: body
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: s

    select case (body%kind)
    case (body_polygon)
      allocate (shape%outline, source=body%polygon)
    case (body_box)
      allocate (shape%outline(2, 4))
      shape%outline(:, 1) = body%box(:2, 1)
      shape%outline(:, 2) = [body%box(1, 2), body%box(2, 1)]
      shape%outline(:, 3) = body%box(:2, 2)
      shape%outline(:, 4) = [body%box(1, 1), body%box(2, 2)]
      if (model%analysis%model == three_dimensional) then
        shape%low = body%box(3, 1)
        shape%high = body%box(3, 2)
      end if
    case (body_region)
      allocate (shape%region(model%mesh%cell_count), source=.false.)
      s = place_named(model%mesh%cell_sets, body%region)
      if (s > 0) then
        shape%region(model%mesh%cell_sets(s)%items) = .true.
      else
        call add_diagnostic(diagnostics, body%where, '*BODY', "there is no element set '"//body%region//"'")
      end if
    case (body_polyhedron)
      call read_solid(body, shape, diagnostics)
    end select
    if (model%analysis%mesh%kind == mesh_fitted .and. model%analysis%method%basis == basis_fem) shape%slack = moved
  end function shape_of

  !> The polyhedron of a body, from its file.
  subroutine read_solid(body, shape, diagnostics)
    type(body_type), intent(in) :: body
    !> Gains the polyhedron; one without facets when there is an error.
    type(body_shape_type), intent(inout) :: shape
    type(diagnostics_type), intent(inout) :: diagnostics
    type(error_type), allocatable :: error
    real(wp), allocatable :: facets(:, :, :)
    character(len=:), allocatable :: problem

    allocate (shape%solid)
    allocate (shape%solid%facets(3, 3, 0))
    call read_stl(body%file, facets, error)
    if (allocated(error)) then
      call add_diagnostic(diagnostics, body%where, '*BODY', error%message)
      return
    end if
    problem = polyhedron_problem(facets)
    if (len(problem) > 0) then
      call add_diagnostic(diagnostics, body%where, '*BODY', body%file//': '//problem)
    else
      call make_polyhedron(facets, shape%solid)
      ! STL files are written in single precision, also those in ASCII.
      shape%uncertainty = epsilon(1.0_real32)*maxval(abs(facets))
    end if
  end subroutine read_solid
end module qsmpm_model_shapes
