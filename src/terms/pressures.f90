!> Pressures on surfaces in their geometry at the end of a step.
!>
!>   force on the nodes   -p N_a a,  a = cof(F) a_0                       (Nanson)
!>   stiffness             p N_a d(cof(F) a_0)/du_b                       (load stiffness)
!>
!> with p at the end of the step (where it varies with height, at the position at the start of the step), the area
!> vector a_0 of a surface point at the start, and F the gradient of the step at the surface point, F_33 = 1 + u_r/r in
!> axisymmetry. Only tangential derivatives of the displacement enter. The load stiffness is symmetric except for terms
!> on the rim of the surface; on much stiffer soil its symmetric part is sufficient, so that the equations remain
!> symmetric. docs/methods/supports.md.
module qsmpm_pressures
  use qsmpm_kinds, only: wp
  use qsmpm_configuration, only: configuration_type
  use qsmpm_equations, only: equations_type
  use qsmpm_matrix_blocks, only: add_block
  use qsmpm_load_path, only: between
  use qsmpm_model, only: model_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_vertical, only: vertical_of
  use qsmpm_surface_pressure, only: pressure_at, acts
  use qsmpm_surface_basis, only: surface_basis_type, find_basis, gradient_of
  use qsmpm_tensor, only: cofactor, cross, identity
  use qsmpm_term, only: term_type, increment_type
  implicit none
  private

  public :: pressures_type

  !> Largest ratio of the pressure to the smallest Young's modulus for which the symmetric part of the load stiffness is
  !> used: 40 iterations for 35 at this ratio, 57 for 40 at five times it (verification/cases/pressure.toml).
  real(wp), parameter :: symmetric_ratio = 0.02_wp

  !> Surface points under pressure; the patches are their node lists.
  type, extends(term_type) :: pressures_type
    type(surface_basis_type) :: basis
    !> Surface of each point, its height, and the applied pressure (points).
    integer, allocatable :: surface(:)
    real(wp), allocatable :: height(:), pressure(:)
    !> Areas remain those at the start of the step.
    logical :: in_place = .false.
  contains
    procedure :: prepare
    procedure :: begin
    procedure :: set_load
    procedure :: add_force
    procedure :: add_blocks
    procedure :: add_linear_force
  end type pressures_type

contains

  !> Finds the points under pressure in this phase, at the start of a step.
  subroutine prepare(self, model, configuration)
    class(pressures_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    integer, allocatable :: points(:)
    integer :: i

    associate (load => model%loading, surface => model%state%surface)
      points = pack([(i, i=1, surface%count)], acts(load%pressure_start(surface%surface)) .or. &
        acts(load%pressure_final(surface%surface)))
      self%surface = surface%surface(points)
      self%height = surface%position(vertical_of(model%analysis), points)
    end associate
    call find_basis(model, configuration, points, self%basis)
    self%connectivity = self%basis%connectivity
    self%pressure = spread(0.0_wp, 1, size(points))
    self%symmetric = is_nearly_symmetric(self, model)
  end subroutine prepare

  !> Sets whether areas change in the step.
  subroutine begin(self, increment)
    class(pressures_type), intent(inout) :: self
    type(increment_type), intent(in) :: increment

    self%in_place = increment%step_info%in_place
  end subroutine begin

  !> Applies the pressures of a fraction of the phase.
  subroutine set_load(self, model, configuration, fraction)
    class(pressures_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: fraction

    associate (load => model%loading)
      self%pressure = between(pressure_at(load%pressure_start(self%surface), self%height), &
        pressure_at(load%pressure_final(self%surface), self%height), fraction)
    end associate
  end subroutine set_load

  !> Adds the force of the pressures on the areas deformed by a displacement of the step.
  subroutine add_force(self, displacement, force)
    class(pressures_type), intent(in) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    real(wp) :: push(3)
    integer :: k, a, first

    do k = 1, self%connectivity%count
      push = -self%pressure(k)*self%basis%area(:, k)
      if (.not. self%in_place) push = matmul(cofactor(gradient_of(self%basis, k, displacement)), push)
      first = self%connectivity%first(k)
      do a = first, self%connectivity%first(k + 1) - 1
        associate (node => self%connectivity%nodes(a))
          force(:, node) = force(:, node) + self%basis%shape(a - first + 1, k)*push(:size(force, 1))
        end associate
      end do
    end do
  end subroutine add_force

  !> Adds the load stiffness.
  subroutine add_blocks(self, displacement, equations, matrix)
    class(pressures_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: k

    if (self%in_place) return
    do k = 1, self%connectivity%count
      call add_block(equations, self%first_stencil + k - 1, &
        pressure_block(self, k, displacement, equations%symmetric), matrix)
    end do
  end subroutine add_blocks

  !> Returns the load stiffness of one point, or its symmetric part (dimension, nodes, dimension, nodes).
  !>
  !> With the columns f_j of F, cof(F) a = a_1 f_2 x f_3 + a_2 f_3 x f_1 + a_3 f_1 x f_2 changes by the sum of w_j x
  !> df_j, w_1 = a_2 f_3 - a_3 f_2 and cyclic, and df_j = du N,j.
  pure function pressure_block(pressures, k, displacement, symmetric) result(block)
    class(pressures_type), intent(in) :: pressures
    !> Number of the point.
    integer, intent(in) :: k
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    logical, intent(in) :: symmetric
    real(wp), allocatable :: block(:, :, :, :)
    real(wp) :: f(3, 3), w(3, 3), change(3, 3)
    integer :: a, b, c, j, d, n

    d = size(displacement, 1)
    n = pressures%connectivity%first(k + 1) - pressures%connectivity%first(k)
    f = gradient_of(pressures%basis, k, displacement)
    do j = 1, 3
      associate (next => modulo(j, 3) + 1, last => modulo(j + 1, 3) + 1)
        w(:, j) = pressures%pressure(k)*(pressures%basis%area(next, k)*f(:, last) &
          - pressures%basis%area(last, k)*f(:, next))
      end associate
    end do
    allocate (block(d, n, d, n))
    do b = 1, n
      associate (gradient => pressures%basis%gradient(:, b, k))
        do c = 1, d
          change(:, c) = cross(matmul(w(:, :d), gradient(:d)), identity(:, c))
        end do
        if (d == 2) change(:, 1) = change(:, 1) + cross(w(:, 3), identity(:, 3))*gradient(3)
      end associate
      do a = 1, n
        block(:, a, :, b) = pressures%basis%shape(a, k)*change(:d, :d)
      end do
    end do
    if (symmetric) block = 0.5_wp*(block + reshape(block, shape(block), order=[3, 4, 1, 2]))
  end function pressure_block

  !> Adds the load stiffness at the start of the step times a displacement.
  subroutine add_linear_force(self, displacement, force)
    class(pressures_type), intent(in) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    real(wp), allocatable :: block(:, :, :, :)
    real(wp) :: still(size(force, 1), size(force, 2))
    integer :: k, a, b

    if (self%in_place) return
    still = 0.0_wp
    do k = 1, self%connectivity%count
      block = pressure_block(self, k, still, .false.)
      associate (nodes => self%connectivity%nodes(self%connectivity%first(k):self%connectivity%first(k + 1) - 1))
        do b = 1, size(nodes)
          do a = 1, size(nodes)
            force(:, nodes(a)) = force(:, nodes(a)) + matmul(block(:, a, :, b), displacement(:, nodes(b)))
          end do
        end do
      end associate
    end do
  end subroutine add_linear_force

  !> Returns whether the pressures of this phase are so small that the symmetric part of their stiffness is sufficient.
  pure logical function is_nearly_symmetric(pressures, model)
    type(pressures_type), intent(in) :: pressures
    type(model_type), intent(in) :: model
    real(wp) :: largest
    integer :: m

    associate (load => model%loading, s => pressures%surface, y => pressures%height)
      largest = maxval(abs([0.0_wp, pressure_at(load%pressure_start(s), y), pressure_at(load%pressure_final(s), y)]))
    end associate
    is_nearly_symmetric = all([(largest <= symmetric_ratio*model%laws(m)%law%stiffness_scale, m=1, size(model%laws))])
  end function is_nearly_symmetric
end module qsmpm_pressures
