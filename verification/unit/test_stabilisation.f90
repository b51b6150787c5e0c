!> Stabilisation terms: what they must not resist, and what they must.
module test_stabilisation
  use active_samples, only: activate
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_cell_share, only: cell_volumes
  use qsmpm_points, only: points_type, allocate_points
  use qsmpm_point_location, only: activation_type
  use qsmpm_penalty_matrices, only: penalty_matrices_type, add_penalty_force
  use qsmpm_boundary_stabilisation, only: build_penalty
  use qsmpm_space, only: space_type
  use qsmpm_space_builder, only: element_space
  use qsmpm_method_description, only: stabilise_ghost, stabilise_background
  use sample_models, only: sample_grid
  use testing, only: tests_type
  implicit none
  private

  public :: collect_stabilisation

contains

  !> All checks.
  subroutine collect_stabilisation(tests)
    type(tests_type), intent(inout) :: tests
    character(len=8), parameter :: names(6) = [character(len=8) :: 'TRI3', 'TRI6', 'QUAD4', 'WEDGE6', &
      'WEDGE15', 'TET10']
    integer :: i

    call tests%start('stabilisation')
    do i = 1, size(names)
      call check_ghost(tests, trim(names(i)))
      call check_background(tests, trim(names(i)))
    end do
    ! h_F = (|K1| + |K2|)/|F| on a grid of two cells a direction: whole cells 1, halves of them 1/2.
    call check_jump(tests, 'QUAD4', 1.0_wp)
    call check_jump(tests, 'QUAD8', 1.0_wp)
    call check_jump(tests, 'HEX8', 1.0_wp)
    call check_jump(tests, 'TRI3', 0.5_wp)
    call check_jump(tests, 'TRI6', 0.5_wp)
    call check_jump(tests, 'WEDGE6', 0.5_wp)
  end subroutine collect_stabilisation

  !> All cells of a small grid hold one point, so few that all are boundary cells.
  subroutine thin_body(mesh, kind, stabilisation, filled, stiff_from)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: kind
    type(penalty_matrices_type), intent(out) :: stabilisation
    !> Cells to the left of here along x are filled to 0.9; none when absent.
    real(wp), intent(in), optional :: filled
    !> Cells to the right of here are a thousand times as stiff; none when absent.
    real(wp), intent(in), optional :: stiff_from
    type(space_type) :: space
    type(points_type) :: points
    type(activation_type) :: activation
    real(wp) :: volumes(mesh%cell_count), stiffness(mesh%cell_count)
    integer :: c

    call cell_volumes(mesh, volumes)
    call allocate_points(points, mesh%dimension, mesh%cell_count, merge(4, 6, mesh%dimension == 2), 4)
    points%cell = [(c, c=1, mesh%cell_count)]
    points%material = 1
    points%volume = 0.1_wp*volumes
    do c = 1, mesh%cell_count
      if (.not. present(filled)) exit
      if (maxval(mesh%coordinates(1, mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1))) < filled + 0.1_wp) &
        points%volume(c) = 0.9_wp*volumes(c)
    end do
    call activate(mesh, volumes, points, activation)
    stiffness = 1.0_wp
    do c = 1, mesh%cell_count
      if (.not. present(stiff_from)) exit
      if (minval(mesh%coordinates(1, mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1))) >= stiff_from) &
        stiffness(activation%active_number(c)) = 1.0e3_wp
    end do
    call element_space(mesh, space)
    call build_penalty(mesh, space, activation, kind, 1.0_wp, stiffness, volumes, &
      spread(.true., 1, mesh%cell_count), stabilisation)
  end subroutine thin_body

  !> The ghost penalty resists no linear field, and on quadratic elements no quadratic one.
  subroutine check_ghost(tests, name)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(mesh_type) :: mesh
    type(penalty_matrices_type) :: stabilisation
    real(wp), allocatable :: field(:, :), force(:, :)

    call sample_grid(name, 2, 0.1_wp, mesh)
    call thin_body(mesh, stabilise_ghost, stabilisation)
    allocate (field, source=2.0_wp*mesh%coordinates)
    field(1, :) = field(1, :) - mesh%coordinates(2, :)
    allocate (force(mesh%dimension, mesh%node_count), source=0.0_wp)
    call add_penalty_force(stabilisation, field, force)
    call tests%close('ghost penalty on '//name//' lets a linear field pass', maxval(abs(force)), 0.0_wp, 1.0e-11_wp)
    if (index(name, '6') > 0 .and. name /= 'WEDGE6' .or. name == 'WEDGE15' .or. name == 'TET10') then
      field = mesh%coordinates**2
      force = 0.0_wp
      call add_penalty_force(stabilisation, field, force)
      call tests%close('ghost penalty on '//name//' lets a quadratic field pass', maxval(abs(force)), 0.0_wp, &
        1.0e-9_wp)
    end if
    field = 0.0_wp
    field(1, 1) = 1.0_wp
    force = 0.0_wp
    call add_penalty_force(stabilisation, field, force)
    call tests%check('ghost penalty on '//name//' resists a single node', force(1, 1) > 1.0e-3_wp)
  end subroutine check_ghost

  !> A field of slope one on one side of the middle and zero on the other has the energy
  !> g E h_F |F| summed over the faces between them, and nothing else; the terms are symmetric.
  subroutine check_jump(tests, name, wanted)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    !> Energy for g = E = 1 and a middle of length (area) one.
    real(wp), intent(in) :: wanted
    type(mesh_type) :: mesh
    type(penalty_matrices_type) :: stabilisation
    real(wp), allocatable :: field(:, :), force(:, :)
    real(wp) :: skew
    integer :: k

    call sample_grid(name, 2, 0.0_wp, mesh)
    call thin_body(mesh, stabilise_ghost, stabilisation)
    allocate (field(1, mesh%node_count), force(1, mesh%node_count))
    field(1, :) = max(mesh%coordinates(1, :) - 0.5_wp, 0.0_wp)
    force = 0.0_wp
    call add_penalty_force(stabilisation, field, force)
    call tests%close('ghost penalty on '//name//' has the energy of a jump of slope', sum(force*field), wanted, &
      1.0e-11_wp)
    skew = 0.0_wp
    do k = 1, stabilisation%connectivity%count
      skew = max(skew, maxval(abs(stabilisation%matrix(:, :, k) - transpose(stabilisation%matrix(:, :, k)))))
    end do
    call tests%close('ghost penalty on '//name//' is symmetric', skew, 0.0_wp, 1.0e-11_wp)
    if (name(:1) /= 'Q') return
    call thin_body(mesh, stabilise_ghost, stabilisation, stiff_from=0.5_wp)
    force = 0.0_wp
    call add_penalty_force(stabilisation, field, force)
    call tests%close('ghost penalty on '//name//' beside stiff cells has the modulus of the soft ones', &
      sum(force*field), wanted, 1.0e-9_wp)
  end subroutine check_jump

  !> The background term lets a linear field pass; a field of slope one in cells that hold next to nothing, beside cells
  !> that are filled and at rest, has the energy eps E over those cells.
  subroutine check_background(tests, name)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(mesh_type) :: mesh
    type(penalty_matrices_type) :: stabilisation
    real(wp), allocatable :: field(:, :), force(:, :)

    call sample_grid(name, 2, 0.1_wp, mesh)
    call thin_body(mesh, stabilise_background, stabilisation)
    allocate (field, source=2.0_wp*mesh%coordinates + 1.0_wp)
    field(1, :) = field(1, :) - mesh%coordinates(2, :)
    allocate (force(mesh%dimension, mesh%node_count), source=0.0_wp)
    call add_penalty_force(stabilisation, field, force)
    call tests%close('background on '//name//' lets a linear field pass', maxval(abs(force)), 0.0_wp, 1.0e-12_wp)
    call sample_grid(name, 2, 0.0_wp, mesh)
    call thin_body(mesh, stabilise_background, stabilisation, 0.5_wp)
    field = 0.0_wp
    field(1, :) = max(mesh%coordinates(1, :) - 0.5_wp, 0.0_wp)
    force = 0.0_wp
    call add_penalty_force(stabilisation, field, force)
    call tests%close('background on '//name//' ties thin cells to filled ones', sum(force*field), 0.5_wp, 1.0e-11_wp)
  end subroutine check_background
end module test_stabilisation
