!> Small meshes and bodies that several suites use.
module sample_models
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_element, only: element_from_name, local_dimension
  use qsmpm_mesh, only: mesh_type
  use qsmpm_grid, only: grid_type, make_grid, diagonal_random
  use qsmpm_mesh_topology, only: build_topology
  implicit none
  private

  public :: sample_grid

contains

  !> A grid of n elements a direction on the unit square or cube.
  subroutine sample_grid(name, n, perturbation, mesh)
    !> Element name.
    character(len=*), intent(in) :: name
    integer, intent(in) :: n
    !> Shift of inner nodes.
    real(wp), intent(in) :: perturbation
    type(mesh_type), intent(out) :: mesh
    type(grid_type) :: grid
    type(error_type), allocatable :: error
    integer :: i, k

    grid%kind = element_from_name(name)
    grid%diagonal = diagonal_random
    grid%perturbation = perturbation
    do i = 1, local_dimension(grid%kind)
      grid%axes(i)%lines = [(real(k, wp)/n, k=0, n)]
    end do
    call make_grid(grid, mesh)
    call build_topology(mesh, error)
    if (allocated(error)) error stop 'sample mesh is broken'
  end subroutine sample_grid
end module sample_models
