!> What the user says of a material whose model is in a shared library, as plain data.
module qsmpm_user_material
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: user_material_type, put_start

  !> How the library is spoken to, numbered as in the deck's description.
  integer, parameter, public :: interface_umat = 1, interface_udsm = 2
  !> Which tangent the model is asked for: left to it, its consistent one, its elastic one, differences of its
  !> stress.
  integer, parameter, public :: model_tangent_auto = 0, model_tangent_consistent = 1, model_tangent_elastic = 2, &
    model_tangent_numerical = 3

  !> A user's material.
  type :: user_material_type
    logical :: given = .false.
    !> Whether the library may be loaded, that is run; else linear elasticity stands in for it.
    logical :: loads = .true.
    integer :: interface = interface_umat
    !> Shared library: path relative to the working directory or from the root.
    character(len=:), allocatable :: library
    !> Name of the procedure without compiler's decoration, and (UDSM) number of the model.
    character(len=:), allocatable :: symbol
    integer :: model = 1
    !> State variables; negative asks the model.
    integer :: states = -1
    integer :: tangent = model_tangent_auto
    logical :: symmetric = .false.
    logical :: thread_safe = .false.
    !> What the model writes to the standard output is not shown.
    logical :: silent = .false.
    !> Its state variables are among the results.
    logical :: shows_state = .true.
    !> Stress components that a UMAT is reported, 6 or 4.
    integer :: components = 6
    !> Young's modulus that scales stabilisation; 0 asks the model for its elastic tangent.
    real(wp) :: stiffness = 0.0_wp
    !> UDSM: bulk modulus of the pore water over the porosity; 0 is drained.
    real(wp) :: undrained = 0.0_wp
    !> Constants, and state variables at the start.
    real(wp), allocatable :: constants(:)
    real(wp), allocatable :: start(:)
    !> Where they differ from place to place: along which axis (0 for nowhere), coordinates of the levels, rising, and
    !> the variables there (state variable, level), linear between.
    integer :: along = 0
    real(wp), allocatable :: levels(:), profile(:, :)
  end type user_material_type
contains

  !> Put the state variables at the start that the deck gives for a place, as far as they go; beyond the levels those of
  !> the nearest one.
  pure subroutine put_start(user, place, state)
    type(user_material_type), intent(in) :: user
    !> Position (3).
    real(wp), intent(in) :: place(3)
    !> State variables; those the deck does not give stay.
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
