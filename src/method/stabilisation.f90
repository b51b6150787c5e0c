!> Stabilisation of boundary cells, acting on the displacement of the step in residual and tangent.
!>
!> A body ends somewhere inside a cell; the smaller the piece, the worse the equations. Two cures,
!> both bounding the condition number for any cut (docs/methods/ghost.md):
!>   background   a soft material in each boundary cell (`qsmpm_background`),
!>   ghost        a penalty on the jumps of derivatives over the faces of boundary cells
!>                (`qsmpm_element_ghost`, `qsmpm_spline_ghost`).
!> Either is a drag on the step, not a load: its share is reported and a step is held until the
!> share is below its bound.
module qsmpm_stabilisation
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_house_keeping, only: activation_type
  use qsmpm_space, only: space_type
  use qsmpm_penalty_terms, only: stabilisation_type
  use qsmpm_background, only: build_background
  use qsmpm_element_ghost, only: build_element_ghost
  use qsmpm_spline_ghost, only: build_spline_ghost
  use qsmpm_analysis, only: stabilise_background, stabilise_ghost
  implicit none
  private

  public :: build_stabilisation

contains

  !> Build the chosen terms for the boundary cells of this step.
  subroutine build_stabilisation(mesh, space, activation, kind, factor, stiffness, volumes, stabilisation)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> What house-keeping found.
    type(activation_type), intent(in) :: activation
    !> stabilise_none, stabilise_background or stabilise_ghost.
    integer, intent(in) :: kind
    !> eps or g.
    real(wp), intent(in) :: factor
    !> Young's modulus in each active cell (active_count).
    real(wp), intent(in) :: stiffness(:)
    !> Volume of each cell (cell_count).
    real(wp), intent(in) :: volumes(:)
    !> The stabilisation terms.
    type(stabilisation_type), intent(out) :: stabilisation

    select case (kind)
    case (stabilise_background)
      call build_background(mesh, space, activation, factor, stiffness, stabilisation)
    case (stabilise_ghost)
      if (space%tensor) then
        call build_spline_ghost(mesh, space, activation, factor, stiffness, stabilisation)
      else
        call build_element_ghost(mesh, activation, factor, stiffness, volumes, stabilisation)
      end if
    case default
      allocate (stabilisation%patches%first(1), source=1)
      allocate (stabilisation%patches%nodes(0))
      allocate (stabilisation%matrix(0, 0, 0))
    end select
  end subroutine build_stabilisation
end module qsmpm_stabilisation
