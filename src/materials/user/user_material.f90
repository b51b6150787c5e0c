!> Description of a user material, whose model is in a shared library, as plain data.
module qsmpm_user_material
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: user_material_type, put_start

  !> Interfaces of the library, numbered as in the deck's description.
  integer, parameter, public :: interface_umat = 1, interface_udsm = 2
  !> Requested tangent: chosen by the model, its consistent tangent, its elastic tangent, finite differences of its
  !> stress.
  integer, parameter, public :: model_tangent_auto = 0, model_tangent_consistent = 1, model_tangent_elastic = 2, &
    model_tangent_numerical = 3

  !> A user material.
  type :: user_material_type
    logical :: given = .false.
    !> Whether the library may be loaded and thus executed; otherwise it is replaced by linear elasticity.
    logical :: loads = .true.
    integer :: interface = interface_umat
    !> Shared library: path relative to the working directory or from the root.
    character(len=:), allocatable :: library
    !> Name of the procedure without the compiler's decoration, and (UDSM) number of the model.
    character(len=:), allocatable :: symbol
    integer :: model = 1
    !> Number of state variables; if negative, the number is requested from the model.
    integer :: states = -1
    integer :: tangent = model_tangent_auto
    logical :: symmetric = .false.
    logical :: thread_safe = .false.
    !> Whether standard output of the model is suppressed.
    logical :: silent = .false.
    !> Whether its state variables are written to the results.
    logical :: shows_state = .true.
    !> Number of stress components passed to a UMAT, 6 or 4.
    integer :: components = 6
    !> Young's modulus that scales the stabilisation; if 0, the model's elastic tangent is requested.
    real(wp) :: stiffness = 0.0_wp
    !> UDSM: bulk modulus of the pore water divided by the porosity; 0 is drained.
    real(wp) :: undrained = 0.0_wp
    !> Constants, and initial state variables.
    real(wp), allocatable :: constants(:)
    real(wp), allocatable :: start(:)
    !> Initial state that varies with position: axis (0 for none), coordinates of the levels in ascending order, and
    !> the variables at the levels (state variable, level), linear between them.
    integer :: along = 0
    real(wp), allocatable :: levels(:), profile(:, :)
  end type user_material_type
contains

  !> Sets the initial state variables that the deck gives for a position; beyond the levels those of
  !> the nearest level.
  pure subroutine put_start(user, place, state)
    type(user_material_type), intent(in) :: user
    !> Position (3).
    real(wp), intent(in) :: place(3)
    !> State variables; those not given in the deck are not changed.
    real(wp), intent(inout) :: state(:)
    real(wp) :: x, share
    integer :: k, n

    n = 0
    if (allocated(user%start)) n = min(size(state), size(user%start))
    if (n == 0) return
    state(:n) = user%start(:n)
    if (user%along == 0) return
    state(:n) = user%profile(:n, 1)
    x = place(user%along)
    do k = 2, size(user%levels)
      if (x <= user%levels(k - 1)) exit
      share = min(1.0_wp, (x - user%levels(k - 1))/(user%levels(k) - user%levels(k - 1)))
      state(:n) = user%profile(:n, k - 1) + share*(user%profile(:n, k) - user%profile(:n, k - 1))
    end do
  end subroutine put_start
end module qsmpm_user_material
